"""What came of each extreme, and who noticed, against the committed table.

``python -m tests.test_extremes_tables`` from the repository writes the table again.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

import pytest

from mbcheck.comparisons.extremes import failures, parameters, starts
from mbcheck.comparisons.extremes.row import (
    ENGINE,
    FAILED,
    GUARD,
    HALVING,
    OUTCOMES,
    REFERENCE,
    RIGHT,
    RULE,
    SKIPPED,
    WRONG,
    Row,
)
from mbcheck.comparisons.extremes.task import Task
from mbcheck.reference import SCENES

TABLE = Path(__file__).with_name("extremes_table.json")
ENGINES = ("mujoco", "exudyn")
SECTIONS = (parameters, starts, failures)

QUICK = (
    "parameters/hula_hoop/stiffness_1e+12/mujoco",
    "parameters/hula_hoop/stiffness_1e+09/exudyn",
    "parameters/speed_regulator/massless_rod_and_slider/exudyn",
    "parameters/speed_regulator/lambda_1-1e-09/mujoco",
    "starts/hula_hoop/rod_aligned_at_rest/exudyn",
    "starts/speed_regulator/open_by_0.001_m/exudyn",
    "starts/speed_regulator/rest_top/exudyn",
    "failures/hula_hoop/force_through_ctrl_at_step_start/mujoco",
    "failures/hula_hoop/automatic_reset_unwarned/mujoco",
    "failures/hula_hoop/no_inertia/mujoco",
    "failures/hula_hoop/inertia_floor/mujoco",
    "failures/hula_hoop/energy_before_mj_forward/mujoco",
    "failures/hula_hoop/lost_inertia/mujoco",
    "failures/hula_hoop/transition_matrix/mujoco",
    "failures/hula_hoop/unstable_is_success/exudyn",
    "failures/hula_hoop/velocity_verlet/exudyn",
    "failures/hula_hoop/dverk6/exudyn",
    "failures/hula_hoop/halved_steps/exudyn",
    "failures/speed_regulator/through_the_dead_centre/exudyn",
    "failures/speed_regulator/closure_softened_refused/mujoco",
)
"""Tasks of the default run."""


def tasks() -> dict[str, Task]:
    """Return all tasks of the default set by their id."""
    found = [task for section in SECTIONS for task in section.tasks(SCENES, ENGINES, False)]
    return {f"{t.section}/{t.scene}/{t.name}/{t.engine}": t for t in found}


def classes(rows: Iterable[Row]) -> dict[str, str]:
    """Return what is kept of rows: outcome, and who noticed."""
    return {
        f"{row.name}/{row.model}/{row.method}": " ".join((row.outcome, *row.noticed_by))
        for row in rows
    }


def committed() -> dict[str, dict[str, str]]:
    """Return the committed table: by task, then by row."""
    table: dict[str, dict[str, str]] = json.loads(TABLE.read_text(encoding="utf-8"))
    return table


def test_ids_are_unique_and_in_the_table() -> None:
    count = sum(len(section.tasks(SCENES, ENGINES, False)) for section in SECTIONS)
    assert len(tasks()) == count
    assert set(committed()) == set(tasks())
    assert set(QUICK) < set(tasks())


def test_the_table_has_every_outcome_and_every_noticer() -> None:
    said = [text.split() for rows in committed().values() for text in rows.values()]
    assert {first for first, *_ in said} == set(OUTCOMES)
    noticed = {who for _, *rest in said for who in rest}
    assert {ENGINE, GUARD, HALVING, REFERENCE} < noticed
    assert any(who.startswith(RULE) for who in noticed)
    for outcome, *rest in said:
        assert (outcome in (RIGHT, SKIPPED)) or rest
        assert (outcome != RIGHT) or not rest
        assert (outcome != WRONG) or rest[-1] == REFERENCE
        assert (outcome != FAILED) or rest[0] in (ENGINE, GUARD)


@pytest.mark.parametrize("name", QUICK)
def test_quick_rows_are_as_committed(name: str) -> None:
    assert classes(tasks()[name].call()) == committed()[name]


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(set(tasks()) - set(QUICK)))
def test_rows_are_as_committed(name: str) -> None:
    assert classes(tasks()[name].call()) == committed()[name]


def test_what_is_not_provoked_has_its_reason() -> None:
    assert all(mode and why for mode, why in failures.NOT_PROVOKED)


if __name__ == "__main__":
    table = {name: classes(task.call()) for name, task in tasks().items()}
    TABLE.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")
