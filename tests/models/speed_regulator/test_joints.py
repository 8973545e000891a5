"""Reactions of the joints of speed_regulator, and a loop that starts open."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest

from mbcheck.comparisons.checks.suite import checks_of, run_check
from mbcheck.comparisons.engines.adapter import Adapter, BoundModel
from mbcheck.comparisons.engines.exudyn.engine import Exudyn
from mbcheck.comparisons.engines.mujoco.engine import joint_force
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.faults.exudyn import ExudynAdapter
from mbcheck.comparisons.faults.mujoco import Edited, MujocoAdapter
from mbcheck.comparisons.faults.variants import Wrapped
from mbcheck.models.speed_regulator import exudyn_model
from mbcheck.models.speed_regulator.mjcf import MODELS
from mbcheck.reference.equations import ModelEquations
from mbcheck.reference.errors import UnknownNameError
from mbcheck.reference.scene import Array, Case, EquationsOfMotion
from mbcheck.reference.solve.single import solve
from mbcheck.reference.speed_regulator import SCENE
from mbcheck.reference.speed_regulator.equations import SpeedRegulator
from mbcheck.reference.speed_regulator.soft import (
    soft_scene,
)
from mbcheck.tests.support.mjcf.crank import (
    CLOSURES,
    DEFAULT,
    MASSLESS,
    OTHER,
    claimed,
    compiled,
    predicted,
    samples,
)

ENGINE = ExudynAdapter()


EXUDYN = exudyn_model.MODELS


# --- Reactions of the joints

REACTIONS = ("reaction_a_x", "reaction_a_y", "reaction_b_x", "reaction_b_y")


def reactions(scene: EquationsOfMotion, p: SpeedRegulator, states: Array) -> Array:
    """Return the reactions (k, 4) that a scene has."""
    observed = scene.observe(states.T, p)
    return np.array([observed[name] for name in REACTIONS]).T


@pytest.mark.parametrize("name", CLOSURES)
def test_reactions_of_the_claim_move_crank_and_slider(name: str) -> None:
    """Both bodies by themselves: the claim finds them from the closure and the rod."""
    scene, p = claimed(name, OTHER), OTHER
    states = samples(p, 1e-3)
    (phi, _, y), (_, _, y_dot) = np.split(states.T, 2)
    phi_ddot, _, y_ddot = predicted(scene, p, states).T
    a_x, a_y, _, b_y = reactions(scene, p, states).T
    lever = p.crank_radius * (np.cos(phi) * a_y - np.sin(phi) * a_x)
    torque = p.flywheel_inertia * phi_ddot - lever
    assert torque == pytest.approx(np.full(len(states), p.torque), abs=1e-11 * np.ptp(lever))
    spring = -p.stiffness * (y - p.spring_rest) - p.damping * y_dot
    assert p.slider_mass * y_ddot == pytest.approx(spring - b_y, abs=1e-11 * np.ptp(b_y))


@pytest.mark.parametrize("p", [DEFAULT, OTHER], ids=["default", "other"])
@pytest.mark.parametrize("opened", [0.0, 2e-4, 1e-2])
@pytest.mark.parametrize("name", CLOSURES)
def test_mujocos_reactions_are_those_of_the_claim(
    name: str, opened: float, p: SpeedRegulator
) -> None:
    model, states = compiled(MODELS[name], p), samples(p, opened)
    data = mujoco.MjData(model)
    found = []
    for state in states:
        data.qpos[:], data.qvel[:] = np.split(state, 2)
        mujoco.mj_forward(model, data)
        mujoco.mj_rnePostConstraint(model, data)
        places = MODELS[name].reactions
        assert tuple(places) == REACTIONS
        found.append([joint_force(mujoco, model, data, at)[axis] for at, axis in places.values()])
    truths = reactions(claimed(name, p), p, states)
    np.testing.assert_allclose(found, truths, rtol=0, atol=1e-10 * np.max(np.abs(truths)))


@pytest.mark.parametrize("p", [DEFAULT, OTHER, MASSLESS], ids=["default", "other", "massless"])
def test_exudyns_reactions_are_right(p: SpeedRegulator) -> None:
    states = samples(p)[:, [0, 3]]
    case = Case(SCENE.name, "some_motion", p)
    found = ENGINE.bind(case, "redundant").reactions(np.zeros(len(states)), states)
    assert tuple(found) == ENGINE.bind(case, "redundant").reaction_names == REACTIONS
    truths = reactions(SCENE, p, states)
    scale = np.max(np.abs(truths))
    np.testing.assert_allclose(np.array(list(found.values())).T, truths, rtol=0, atol=1e-11 * scale)


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


@pytest.mark.parametrize("name", CLOSURES)
def test_an_opened_loop_closes_in_mujoco(name: str) -> None:
    engine = MujocoAdapter()
    rk4 = next(item for item in engine.methods if item.name == "RK4")
    times = np.array([0.0, 0.25, 0.5])
    found = engine.bind(OPENED, name).simulate(OPENED, rk4, 2.0**-11, times).values
    gap = OPENED.inconsistency["y"]
    start = SCENE.observe(SCENE.state(OPENED.state), DEFAULT)
    assert found["y"][0] - start["y"] == pytest.approx(gap, rel=1e-12)
    assert found["position_violation"][0] == pytest.approx(gap, rel=1e-12)
    assert found["phi"][0] == 0.0
    own = engine.bind(OPENED, name).equations
    left = solve(own.scene, own.parameters, own.start(OPENED), times[1:]).states
    violation = own.scene.observe(left, own.parameters)["position_violation"]
    assert np.max(violation) < 0.25 * gap  # what the load leaves open
    assert found["position_violation"][1:] == pytest.approx(violation, abs=1e-6 * gap)


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
