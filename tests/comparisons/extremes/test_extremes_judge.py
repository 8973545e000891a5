"""Each outcome of an extreme, and each who may notice, provoked with engines that are wrong."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.engines.equations import scene_equations
from mbcheck.comparisons.engines.protocol import Method
from mbcheck.comparisons.engines.run import Trajectory
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.engines.variants.catalogue import Misread
from mbcheck.comparisons.engines.variants.exudyn import ExudynAdapter
from mbcheck.comparisons.engines.variants.mujoco import MujocoAdapter
from mbcheck.comparisons.extremes import certify
from mbcheck.comparisons.extremes.judge import halving_shows, judge
from mbcheck.comparisons.extremes.row import (
    ENGINE,
    FAILED,
    GUARD,
    HALVING,
    REFERENCE,
    REFUSED,
    RIGHT,
    SKIPPED,
    WRONG,
    Row,
    detected_by,
)
from mbcheck.reference import get_scene
from mbcheck.reference.errors import EngineError
from mbcheck.reference.scene import Array, Case
from mbcheck.tests.support.faults import Resetting

SPINNING = get_scene("hula_hoop").case("spinning_3hz_60n")
STEP = 2.0**-10


def verdict(engine: Any, method: str = "RK4", step: float = STEP, **changes: Any) -> Row:
    """Judge a quarter of a second of the hula hoop by an engine's default model."""
    case = replace(SPINNING, parameters=SPINNING.parameters.replace(**changes))
    known = {item.name: item for item in engine.methods}
    setup = Setup(engine, case, engine.models(case.scene)[0], known[method], step)
    return judge(Row.of("parameters", "test", setup, changed=changes), setup, 0.25)


@pytest.mark.parametrize(
    ("make", "method"), [(MujocoAdapter, "RK4"), (ExudynAdapter, "RK67"), (ExudynAdapter, "RK44")]
)
def test_a_right_engine_is_right(make: Any, method: str) -> None:
    row = verdict(make(), method)
    assert row.outcome == RIGHT
    assert row.noticed_by == ()
    assert row.error is not None
    assert row.predicted is not None
    assert row.error <= 1.2 * row.predicted + row.values["reference_bound"]
    assert row.values["reference_bound"] < 1e-8


def test_a_wrong_mass_is_seen_by_the_reference_alone() -> None:
    row = verdict(Misread(MujocoAdapter(), lambda p: p.replace(free_mass=1.001 * p.free_mass)))
    assert row.outcome == WRONG
    assert row.noticed_by == (REFERENCE,)
    assert "only the reference sees it" in row.reason


def test_halving_sees_a_force_through_controls() -> None:
    from mbcheck.comparisons.engines.variants.mujoco import Controlled

    for moment, order in ((0.0, "1.0"), (0.5, "2.0")):
        row = verdict(Controlled(moment))
        assert row.outcome == WRONG
        assert HALVING in row.noticed_by
        assert f"order {order} instead of 4" in row.reason


def test_who_notices_goes_by_the_kind_of_failure() -> None:
    assert detected_by(EngineError("solver", "no solution")) == ENGINE
    assert detected_by(EngineError("clock", "off")) == GUARD


def test_the_guard_sees_what_is_not_a_number() -> None:
    row = verdict(ExudynAdapter(), "RK44", stiffness=1e9)
    assert row.outcome == FAILED
    assert row.noticed_by[:2] == (GUARD, "rule:step_limit")
    assert row.reason.startswith("non_finite")


def test_the_engine_counts_its_warnings_and_the_guard_reads_clocks() -> None:
    from mbcheck.comparisons.engines.variants.catalogue import mujoco
    from mbcheck.comparisons.engines.variants.mujoco import Edited, Unwarned

    reset = (' autoreset="disable"', "")
    engines = (
        (Edited(reset), ENGINE, "warning"),
        (Unwarned(mujoco("Edited", reset)), GUARD, "clock"),
    )
    for engine, who, kind in engines:
        row = verdict(engine, "Euler", stiffness=1e9)
        assert row.outcome == FAILED
        assert row.noticed_by[0] == who
        assert row.reason.startswith(kind)


def test_a_reset_that_nobody_counts_is_wrong() -> None:
    row = verdict(Resetting(MujocoAdapter()))
    assert row.outcome == WRONG
    assert row.noticed_by == (REFERENCE,)


def test_the_adapter_refuses_and_the_engine_refuses() -> None:
    from mbcheck.comparisons.engines.variants.mujoco import Edited

    row = verdict(MujocoAdapter(), "discrete")
    assert (row.outcome, row.noticed_by) == (REFUSED, (ENGINE,))
    assert row.reason.startswith("the adapter refuses")
    row = verdict(Edited(("2e-15 2e-15 2e-15", "0 0 0")))
    assert (row.outcome, row.noticed_by) == (REFUSED, (ENGINE,))
    assert row.reason.startswith("the engine refuses")


def test_an_exception_in_a_run_is_a_failure_of_the_engine() -> None:
    class Torn(MujocoAdapter):
        def simulate(
            self, case: Case, model: str, method: Method, step: float, times: Array
        ) -> Trajectory:
            raise ValueError("sensor torn off")

    row = verdict(Torn())
    assert row.outcome == FAILED
    assert row.noticed_by[0] == ENGINE
    assert "sensor torn off" in row.reason


def test_a_reference_that_is_not_certified_judges_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    first = certify.second

    def other(problem: certify.InitialValueProblem, state: Array) -> Any:
        solution = first(problem, state)
        return replace(solution, states=solution.states * (1 + 1e-4))

    monkeypatch.setattr(certify, "second", other)
    certify._certified.cache_clear()
    try:
        row = verdict(MujocoAdapter())
    finally:
        certify._certified.cache_clear()
    assert row.outcome == SKIPPED
    assert "no reference is certified" in row.reason


@pytest.mark.parametrize("damping", [1e3, 1e9])
def test_references_of_stiff_dampers_agree(damping: float) -> None:
    """Explicit methods fail there; Gauss collocation and LSODA share nothing."""
    p = SPINNING.parameters.replace(damping_ratio=damping / 44.5, force_amplitude=0.0)
    case = replace(SPINNING, parameters=p)
    times = np.arange(1, 17) / 64
    found = certify.certified(scene_equations(case), case, times, ("y", "theta"))
    assert found.routes < 1e-9
    assert found.bound < 1e-9


def test_halved_steps() -> None:
    assert halving_shows([16e-4, 1e-4], 4, 1e-9) == ""
    assert "order 1.0 instead of 4" in halving_shows([2e-4, 1e-4], 4, 1e-9)
    assert halving_shows([2e-10, 1e-10], 4, 1e-9) == ""  # rounding
    assert "changes it by 0.3" in halving_shows([0.3, 0.01], 4, 1e-9)
    assert halving_shows([np.nan, 0.01], 4, 1e-9)


def test_a_soft_closure_that_is_told_is_right_and_one_that_is_not_is_wrong() -> None:
    from mbcheck.comparisons.engines.variants.mujoco import WithoutEquations

    case = get_scene("speed_regulator").case("rotation")

    def row(engine: Adapter) -> Row:
        rk4 = next(m for m in engine.methods if m.name == "RK4")
        setup = Setup(engine, case, "connect", rk4, STEP)
        return judge(Row.of("failures", "t", setup), setup, 0.5)

    assert row(MujocoAdapter()).outcome == RIGHT
    assert row(WithoutEquations()).noticed_by == (REFERENCE,)
