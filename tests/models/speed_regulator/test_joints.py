"""Reactions of the joints of speed_regulator, and a loop that starts open."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.checks.suite import checks_of, run_check
from mbcheck.comparisons.engines.adapter import Adapter, BoundModel
from mbcheck.comparisons.engines.exudyn.engine import Exudyn
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.faults.exudyn import ExudynAdapter
from mbcheck.comparisons.faults.mujoco import Edited, MujocoAdapter
from mbcheck.comparisons.faults.variants import Wrapped
from mbcheck.models.speed_regulator import exudyn_model
from mbcheck.reference.equations import ModelEquations
from mbcheck.reference.errors import UnknownNameError
from mbcheck.reference.scene import Case
from mbcheck.reference.speed_regulator import SCENE
from mbcheck.reference.speed_regulator.soft import (
    soft_scene,
)
from mbcheck.tests.support.mjcf.crank import (
    CLOSURES,
    DEFAULT,
    MASSLESS,
)

ENGINE = ExudynAdapter()


EXUDYN = exudyn_model.MODELS


# --- Reactions of the joints

REACTIONS = ("reaction_a_x", "reaction_a_y", "reaction_b_x", "reaction_b_y")


def test_models_without_joints_tell_no_reactions() -> None:
    for engine, name in (("mujoco", "transmission"), ("exudyn", "one_dof")):
        found: Any = get_engine(engine)
        assert found.bind(SCENE.case("rotation"), name).reaction_names == ()


HOMOGENEOUS = DEFAULT.rod_mass * DEFAULT.rod_length**2 / 12


def wrong_mujoco(mass: float, inertia: float) -> Edited:
    """Return MuJoCo with other numbers of the rod in its file."""
    return Edited(('mass="0.5"', f'mass="{mass!r}"'), (repr(HOMOGENEOUS), repr(inertia)))


class WrongExudyn(Exudyn):
    """Exudyn with other numbers of the rod."""

    def __init__(self, mass: float, inertia: float) -> None:
        super().__init__()
        self.numbers = {"mass": mass, "inertia": inertia}

    def system(self, case: Case, model: str) -> Any:
        system = super().system(case, model)
        for name, number in self.numbers.items():
            system.mbs.SetObjectParameter(2, name, number)
        return system


class PushedBack(Wrapped):
    """An engine that tells the force in A on the other body."""

    def compute(self, model: BoundModel, name: str, *arguments: Any) -> Any:
        found = super().compute(model, name, *arguments)
        if name != "reactions":
            return found
        return {name: -value if "_a_" in name else value for name, value in found.items()}


WRONG: Mapping[str, Callable[[float, float], Adapter]] = {
    "mujoco": wrong_mujoco,
    "exudyn": lambda *numbers: ExudynAdapter(WrongExudyn(*numbers)),
}


def verdicts(engine: str, case: Case, wrong: Adapter | None = None) -> dict[str, set[str]]:
    """Return, by quantity, the verdicts of the check kind that a case feeds first."""
    found: dict[str, set[str]] = {}
    for check in checks_of(case.kinds[0], case, engine):
        for item in (
            [] if check.unsupported_reason else run_check(check, "loose", wrong, explain=False)
        ):
            found.setdefault(item.quantity, set()).add(item.verdict)
    return found


@pytest.mark.parametrize("engine", WRONG)
def test_the_check_of_reactions_catches_faults(engine: str) -> None:
    case = SCENE.case("rotation")
    right = verdicts(engine, case)
    assert set(REACTIONS) < set(right)
    assert set.union(*right.values()) == {"pass"}
    same = verdicts(engine, case, WRONG[engine](DEFAULT.rod_mass, HOMOGENEOUS))
    assert {name: same[name] for name in REACTIONS} == {name: {"pass"} for name in REACTIONS}
    for mass, inertia in ((1.001 * DEFAULT.rod_mass, HOMOGENEOUS), (0.5, 4 * HOMOGENEOUS)):
        wrong = verdicts(engine, case, WRONG[engine](mass, inertia))
        assert all("deviation" in wrong[name] for name in REACTIONS)
    flipped = verdicts(engine, case, PushedBack(get_engine(engine)))
    missed = {name for name in REACTIONS if flipped[name] == {"pass"}}
    assert missed == {"reaction_b_x", "reaction_b_y"}
    assert flipped["accelerations"] == {"pass"}


# --- A loop that starts open, as declared

OPENED = SCENE.case("opened_loop")


class Assembling(Wrapped):
    """MuJoCo that is started with the loop closed, whatever the case says."""

    def simulate(self, model: BoundModel, case: Case, *rest: Any) -> Any:
        return super().simulate(model, replace(case, inconsistency={}), *rest)


@pytest.mark.slow
def test_the_check_of_an_opened_loop_sees_that_it_was_open() -> None:
    assert set.union(*verdicts("mujoco", OPENED).values()) == {"pass"}
    closed = verdicts("mujoco", OPENED, Assembling(MujocoAdapter()))
    assert closed["scheme_residual"] == closed["model_error"] == {"deviation"}


def test_models_that_cannot_start_open_say_so() -> None:
    for name in EXUDYN:
        assert "only an assembled mechanism" in str(
            ENGINE.bind(OPENED, name).unsupported_reason(OPENED, None)
        )
    mujoco_engine = MujocoAdapter()
    massless = replace(OPENED, parameters=MASSLESS)
    reason = mujoco_engine.bind(massless, "transmission").unsupported_reason(massless, None)
    assert "none can start open" in str(reason)
    reasons = [
        mujoco_engine.bind(OPENED, name).unsupported_reason(OPENED, None) for name in CLOSURES
    ]
    assert reasons == [None] * len(CLOSURES)


def test_only_what_is_declared_may_be_inconsistent() -> None:
    with pytest.raises(UnknownNameError):
        SCENE.state({"phi": 0.0, "y": 1.0})
    own = ModelEquations(soft_scene(), DEFAULT)
    shift = own.start(OPENED) - own.start(replace(OPENED, inconsistency={}))
    np.testing.assert_allclose(shift, [0, 0, 1e-3, 0, 0, 0], rtol=1e-12, atol=0)
    with pytest.raises(UnknownNameError):
        own.start(replace(OPENED, inconsistency={"why": 1e-3}))
