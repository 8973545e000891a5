"""A run at an extreme: each outcome, and each who may notice, provoked with wrong engines."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbcheck.comparisons.checks import truth
from mbcheck.comparisons.checks.kinds import pushed
from mbcheck.comparisons.checks.kinds.pushed import halving_shows
from mbcheck.comparisons.checks.suite import Check, run_check
from mbcheck.comparisons.checks.verdict import (
    ENGINE,
    GUARD,
    HALVING,
    REFERENCE,
    Result,
)
from mbcheck.comparisons.engines.run import Trajectory
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.faults.exudyn import ExudynAdapter
from mbcheck.comparisons.faults.mujoco import MujocoAdapter
from mbcheck.comparisons.faults.runs import Altered, Resetting
from mbcheck.comparisons.faults.variants import Misread
from mbcheck.reference import get_scene
from mbcheck.reference.equations import scene_equations
from mbcheck.reference.scene import Case

SPINNING = get_scene("hula_hoop").case("spinning_3hz_60n")
STEP = 2.0**-10


def verdict(engine: Any, method: str = "RK4", case: Case = SPINNING, **changes: Any) -> Result:
    """Judge a quarter of a second of a case by an engine's default model."""
    p = case.parameters.replace(**changes)
    case = replace(case, parameters=p, horizon=0.25, placement="")
    known = {item.name: item for item in engine.methods}
    model, made = engine.models(case.scene)[0], known[method]
    check = Check(
        "parameters", case, engine.name, model, made, (pushed.QUANTITY,),
        unsupported_reason=engine.bind(case, model).unsupported_reason(case, made), step=STEP,
    )  # fmt: skip
    (result,) = run_check(check, engine=engine)
    return result


@pytest.mark.parametrize(
    ("make", "method"), [(MujocoAdapter, "RK4"), (ExudynAdapter, "RK67"), (ExudynAdapter, "RK44")]
)
def test_a_right_engine_is_right(make: Any, method: str) -> None:
    row = verdict(make(), method)
    assert row.verdict == "pass"
    assert row.noticed_by == ()
    assert row.error is not None
    assert row.tolerance is not None
    assert row.error <= row.tolerance < 1e-3


def test_a_wrong_mass_is_seen_by_the_reference_alone() -> None:
    row = verdict(Misread(MujocoAdapter(), lambda p: p.replace(free_mass=1.001 * p.free_mass)))
    assert row.verdict == "deviation"
    assert row.noticed_by == (REFERENCE,)


def test_halving_sees_a_force_through_controls() -> None:
    from mbcheck.comparisons.faults.mujoco import Controlled

    for moment, order in ((0.0, "1.0"), (0.5, "2.0")):
        row = verdict(Controlled(moment))
        assert row.verdict == "deviation"
        assert HALVING in row.noticed_by
        assert f"order {order} instead of 4" in row.reason


def test_the_guard_sees_what_is_not_a_number() -> None:
    row = verdict(ExudynAdapter(), "RK44", stiffness=1e9)
    assert row.verdict == "error"
    assert row.noticed_by[:2] == (GUARD, "rule:step_limit")
    assert row.reason.startswith("non_finite")


def test_the_engine_counts_its_warnings_and_the_guard_reads_clocks() -> None:
    from mbcheck.comparisons.faults.mujoco import Edited, Unwarned
    from mbcheck.comparisons.faults.variants import mujoco

    reset = (' autoreset="disable"', "")
    engines = (
        (Edited(reset), ENGINE, "warning"),
        (Unwarned(mujoco("Edited", reset)), GUARD, "clock"),
    )
    for engine, who, kind in engines:
        row = verdict(engine, "Euler", stiffness=1e9)
        assert row.verdict == "error"
        assert row.noticed_by[0] == who
        assert row.reason.startswith(kind)


def test_a_reset_that_nobody_counts_is_wrong() -> None:
    row = verdict(Resetting(MujocoAdapter()))
    assert row.verdict == "deviation"
    assert row.noticed_by == (REFERENCE,)


def test_the_adapter_refuses_and_the_engine_refuses() -> None:
    from mbcheck.comparisons.faults.mujoco import Edited

    row = verdict(MujocoAdapter(), "discrete")
    assert (row.verdict, row.noticed_by) == ("skipped", (ENGINE,))
    assert "discrete" in row.reason
    row = verdict(Edited(("2e-15 2e-15 2e-15", "0 0 0")))
    assert (row.verdict, row.noticed_by) == ("skipped", (ENGINE,))
    assert row.reason.startswith("the engine refuses")


def test_an_exception_in_a_run_is_a_failure_of_the_engine() -> None:
    def torn(found: Trajectory, case: Case) -> Trajectory:
        raise ValueError("sensor torn off")

    row = verdict(Altered(MujocoAdapter(), torn))
    assert row.verdict == "error"
    assert row.noticed_by[0] == ENGINE
    assert "sensor torn off" in row.reason


def test_a_reference_that_may_be_wrong_judges_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    right = truth.truth_to_the_end

    def unsure(*call: Any) -> Any:
        exact = right(*call)
        return replace(exact, bound=2 * pushed.SHARPEST * exact.size)

    monkeypatch.setattr(pushed, "truth_to_the_end", unsure)
    row = verdict(MujocoAdapter())
    assert row.verdict == "skipped"
    assert "the reference may be off" in row.reason


@pytest.mark.parametrize("damping", [1e3, 1e9])
def test_references_of_stiff_dampers_agree(damping: float) -> None:
    """Explicit methods fail there; Gauss collocation and LSODA share nothing."""
    p = SPINNING.parameters.replace(damping_ratio=damping / 44.5, force_amplitude=0.0)
    case = replace(SPINNING, parameters=p, placement="")
    engine = ExudynAdapter()
    setup = Setup(engine, case, engine.models(case.scene)[0], step=2.0**-6)
    run = pushed.Sampled(setup, np.arange(1, 17))
    equations = scene_equations(case)
    found = run.solution(equations)
    rate = equations.scene.right_hand_side(p)
    other = solve_ivp(
        rate, (0, 0.25), equations.start(case), "LSODA", run.times, rtol=1e-11, atol=1e-14
    )
    assert np.max(found.bound / found.size) < 1e-9
    np.testing.assert_allclose(found.states, other.y, atol=1e-8 * np.max(np.abs(other.y)))


def test_a_soft_closure_that_is_told_is_right_and_one_that_is_not_is_wrong() -> None:
    from mbcheck.comparisons.faults.mujoco import WithoutEquations

    case = get_scene("speed_regulator").case("rotation")
    assert verdict(MujocoAdapter(), case=case).verdict == "pass"
    assert verdict(WithoutEquations(), case=case).noticed_by == (REFERENCE,)


def test_halved_steps() -> None:
    assert halving_shows([16e-4, 1e-4], 4, 1e-9) == ""
    assert "order 1.0 instead of 4" in halving_shows([2e-4, 1e-4], 4, 1e-9)
    assert halving_shows([2e-10, 1e-10], 4, 1e-9) == ""  # rounding
    assert "changes it by 0.3" in halving_shows([0.3, 0.01], 4, 1e-9)
    assert halving_shows([np.nan, 0.01], 4, 1e-9)
