"""Limits of stability, found on runs, against the theory; and that a wrong engine is seen."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.checks.kinds.limits import bisected
from mbcheck.comparisons.checks.suite import Check, run_check
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.faults.catalogue import ENGINES
from mbcheck.comparisons.faults.runs import OtherMethod
from mbcheck.comparisons.faults.variants import Misread
from mbcheck.comparisons.scenes.extremes import limits


def checks(scene: str, engine: str) -> dict[tuple[str, str], Check]:
    """Return the checks of limits by model and method."""
    found = limits("limits", scene, engine)
    return {(one.model, one.method.name): one for one in found if one.method}


def row(scene: str, engine: str, method: str, model: str = "", made: Any = None) -> Result:
    """Return the result of one of them, of an engine or of another in its place."""
    known = checks(scene, engine)
    (result,) = run_check(known[model or next(iter(known))[0], method], engine=made)
    return result


def h_omega(result: Result) -> float:
    """Return the limit found, in 1 / omega."""
    found = re.search(r"h omega = (\S+),", result.reason)
    assert found
    return float(found[1])


@pytest.mark.parametrize(
    ("engine", "method", "limit"),
    [
        ("mujoco", "Euler", 2.0),
        ("mujoco", "RK4", 2 * np.sqrt(2)),
        ("exudyn", "RK44", 2 * np.sqrt(2)),
        ("exudyn", "RK33", 1.8),  # sqrt 3, but for what it may grow by
    ],
)
def test_hula_hoop_is_as_the_books_say(engine: str, method: str, limit: float) -> None:
    found = row("hula_hoop", engine, method)
    assert found.verdict == "pass"
    assert not found.noticed_by
    assert h_omega(found) == pytest.approx(limit, rel=1e-2)
    assert found.value == pytest.approx(limit / np.sqrt(1000 / 0.45), rel=1e-2)  # M alone
    assert "mode of y" in found.reason


def test_methods_without_a_limit_have_none() -> None:
    found = row("rotor_pendulum", "mujoco", "discrete")
    assert found.verdict == "pass"
    assert "none by theory" in found.reason


def test_an_overshoot_is_granted_as_far_as_its_matrix_has_it() -> None:
    """With 1000 periods in a step generalized-alpha gives 61 times the rates; one_dof, 1e11."""
    right = row("speed_regulator", "exudyn", "GeneralizedAlpha", "redundant")
    assert right.verdict == "pass"
    wrong = row("speed_regulator", "exudyn", "GeneralizedAlpha", "one_dof")
    assert wrong.verdict == "deviation"
    assert wrong.noticed_by[0] == "rule:coarse_step"


def test_a_step_without_a_solution_fails() -> None:
    found = row("speed_regulator", "exudyn", "TrapezoidalIndex2", "one_dof")
    assert found.verdict == "error"
    assert found.noticed_by[:2] == ("engine", "rule:coarse_step")


def test_the_closure_limits_what_it_closes() -> None:
    found = row("speed_regulator", "mujoco", "Euler", "connect_hard")
    assert found.verdict == "pass"
    assert "pin_angle" in found.reason
    assert h_omega(found) < 1.7  # its damper is explicit: less than 2
    found = row("speed_regulator", "mujoco", "Euler", "connect")
    assert (found.verdict, found.noticed_by[:1]) == ("skipped", ("engine",))


def stiffer(p: Any) -> Any:
    return p.replace(stiffness=1.02 * p.stiffness)


@pytest.mark.parametrize("method", ["Euler", "RK4"])
def test_a_spring_that_is_off_is_seen(method: str) -> None:
    wrong = Misread(ENGINES["mujoco"](), stiffer)
    found = row("hula_hoop", "mujoco", method, made=wrong)
    assert found.verdict == "deviation"
    assert found.noticed_by == ("reference",)
    assert found.value is not None
    assert found.reference is not None
    assert found.value / found.reference - 1 == pytest.approx(-0.01, abs=3e-3)


def test_a_method_that_is_another_is_seen() -> None:
    wrong = OtherMethod(ENGINES["mujoco"](), "Euler")  # it claims RK4
    found = row("hula_hoop", "mujoco", "RK4", made=wrong)
    assert found.verdict == "deviation"
    assert h_omega(found) == pytest.approx(2.0, rel=1e-2)


def test_bisection_ends_where_good_turns_bad() -> None:
    assert bisected(lambda x: x > 3.0, 1.0, 2.0) == pytest.approx(3.0, rel=2e-3)
    assert bisected(lambda x: False, 1.0, 2.0) > 1e6
    assert bisected(lambda x: True, 1.0, 2.0) < 1e-6
