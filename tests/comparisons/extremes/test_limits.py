"""Limits of stability, found on runs, against the theory; and that a wrong engine is seen."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.engines.variants.catalogue import Misread
from mbcheck.comparisons.extremes.limits import (
    bisected,
    free_setup,
    parameter_row,
    step_row,
    tasks,
)
from mbcheck.reference import SCENES
from mbcheck.reference.errors import MbcheckError
from mbcheck.tests.support.faults import ENGINES


def setup(
    scene: str, engine: str, method: str, model: str = "", engine_object: Any = None
) -> Setup:
    one = engine_object or get_engine(engine)
    free = free_setup(scene, engine, model or one.models(scene)[0])
    return replace(free, engine=one, method={item.name: item for item in one.methods}[method])


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
    row = step_row(setup("hula_hoop", engine, method))
    assert row.outcome == "right"
    assert not row.noticed_by
    assert row.values["h_omega"] == pytest.approx(limit, rel=1e-2)
    assert row.values["theory"] == pytest.approx(limit, rel=1e-2)
    assert row.values["omega"] == pytest.approx(np.sqrt(1000 / 0.45))  # M alone, not M + m
    assert "mode of y" in row.reason


def test_methods_without_a_limit_have_none() -> None:
    row = step_row(setup("rotor_pendulum", "mujoco", "discrete"))
    assert row.outcome == "right"
    assert "none by theory" in row.reason
    assert row.values["h_omega"] > 6000


def test_an_overshoot_is_granted_as_far_as_its_matrix_has_it() -> None:
    """With 1000 periods in a step generalized-alpha gives 61 times the rates; one_dof, 1e11."""
    right = step_row(setup("speed_regulator", "exudyn", "GeneralizedAlpha", "redundant"))
    assert right.outcome == "right"
    assert right.values["h_omega"] > 6000
    assert right.values["borne"] == right.step
    wrong = step_row(setup("speed_regulator", "exudyn", "GeneralizedAlpha", "one_dof"))
    assert wrong.outcome == "wrong"
    assert wrong.noticed_by[0] == "rule:coarse_step"
    assert wrong.step is not None
    assert wrong.values["borne"] == pytest.approx(wrong.step / 10)


def test_a_step_without_a_solution_is_that_of_the_row() -> None:
    row = step_row(setup("speed_regulator", "exudyn", "TrapezoidalIndex2", "one_dof"))
    assert row.outcome == "failed"
    assert row.noticed_by[:2] == ("engine", "rule:coarse_step")
    assert row.step is not None
    assert row.values.get("borne", 0.0) < row.step
    assert row.values["h_omega"] == pytest.approx(row.step * row.values["omega"])


def test_the_closure_limits_what_it_closes() -> None:
    row = step_row(setup("speed_regulator", "mujoco", "Euler", "connect_hard"))
    assert row.outcome == "right"
    assert "pin_angle" in row.reason
    assert row.values["omega"] == pytest.approx(1000, rel=1e-2)
    assert row.values["h_omega"] < 1.7  # its damper is explicit: less than 2
    row = step_row(setup("speed_regulator", "mujoco", "Euler", "connect"))
    assert row.outcome == "refused"
    assert row.noticed_by == ("engine",)


def stiffer(p: Any) -> Any:
    return p.replace(stiffness=1.02 * p.stiffness)


@pytest.mark.parametrize("method", ["Euler", "RK4"])
def test_a_spring_that_is_off_is_seen(method: str) -> None:
    wrong = Misread(ENGINES["mujoco"](), stiffer)
    row = step_row(setup("hula_hoop", "mujoco", method, engine_object=wrong))
    assert row.outcome == "wrong"
    assert row.noticed_by == ("reference",)
    assert row.error == pytest.approx(0.01, abs=3e-3)


def test_a_method_that_is_another_is_seen() -> None:
    class Downgraded(Misread):
        """It claims RK4 and takes Euler."""

        def compute(self, method: Any, case: Any, model: str, *rest: Any) -> Any:
            euler = next(m for m in self.engine.methods if m.name == "Euler")
            chosen = (euler, *rest[1:]) if method.__name__ == "simulate" else rest
            return method(case, model, *chosen)

    wrong = Downgraded(ENGINES["mujoco"](), lambda p: p)
    row = step_row(setup("hula_hoop", "mujoco", "RK4", engine_object=wrong))
    assert row.outcome == "wrong"
    assert row.values["h_omega"] == pytest.approx(2.0, rel=1e-2)


def test_largest_stiffness_and_damping() -> None:
    rk4 = setup("hula_hoop", "mujoco", "RK4").with_step(2.0**-10)
    stiff = parameter_row(rk4, "stiffness_limit", "stiffness")
    assert stiff.outcome == "right"
    assert stiff.values["found"] == pytest.approx(8 * 0.45 * 2.0**20, rel=1e-2)  # (h omega)^2 = 8
    damped = parameter_row(rk4, "damping_limit", "damping_ratio")
    assert damped.outcome == "right"
    euler = setup("hula_hoop", "mujoco", "Euler").with_step(2.0**-10)
    free = parameter_row(euler, "damping_limit", "damping_ratio")
    assert free.outcome == "right"
    assert "none by theory" in free.reason


def test_bisection_ends_where_good_turns_bad() -> None:
    assert bisected(lambda x: x > 3.0, 1.0, 2.0) == pytest.approx(3.0, rel=2e-3)
    with pytest.raises(MbcheckError, match="stable even"):
        bisected(lambda x: False, 1.0, 2.0)
    with pytest.raises(MbcheckError, match="unstable even"):
        bisected(lambda x: True, 1.0, 2.0)


def test_there_is_a_task_for_every_model() -> None:
    found = tasks((), ("mujoco", "exudyn"), False)
    assert {task.scene for task in found} == set(SCENES)
    every = [(get_engine(name), scene) for scene in set(SCENES) for name in ("mujoco", "exudyn")]
    models = sum(len(engine.distinct_models(scene)) for engine, scene in every)
    assert len(found) == models


AS_EXPECTED = {
    ("exudyn", "GeneralizedAlpha"), ("exudyn", "TrapezoidalIndex2"),
}  # fmt: skip
"""Have no limit by theory, and yet fail, by name, with a thousand periods in a step."""

HANGING = {("rigid_body", "discrete")}
"""The torque of a weight turns with the body, which its derivatives leave out: it fails by name."""


def test_all_limits_are_those_of_theory(clone: Path) -> None:
    """In the table of docs/extremes.csv, whose rows `test_rows_are_golden` measures again."""
    with (clone / "docs" / "extremes.csv").open(encoding="utf-8", newline="") as lines:
        rows = [row for row in csv.DictReader(lines) if row["section"] == "limits"]
    assert {(row["scene"], row["engine"]) for row in rows} == {
        (task.scene, task.engine) for task in tasks((), ("mujoco", "exudyn"), False)
    }

    def bad(row: Mapping[str, str]) -> bool:
        known = (row["engine"], row["method"]) in AS_EXPECTED
        known |= (row["scene"], row["method"]) in HANGING
        unlimited = known and row["what"] == "step_limit"
        return row["outcome"] in ("wrong", "failed") and not unlimited

    assert not [row for row in rows if bad(row)]
