"""What comes of each extreme, and who notices, against the golden table.

``mbcheck extremes --markdown docs/extremes.md --csv docs/extremes.csv`` writes it again.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.extremes import cases, pages, run
from mbcheck.comparisons.extremes.row import (
    ENGINE,
    FAILED,
    GUARD,
    HALVING,
    OUTCOMES,
    REFERENCE,
    RIGHT,
    RULE,
    SECTIONS,
    SKIPPED,
    WRONG,
    Provocation,
    Row,
)
from mbcheck.comparisons.reports.words import number
from mbcheck.reference import SCENES

DOCS = Path(__file__).resolve().parents[3] / "docs"
ENGINES = ("mujoco", "exudyn")

QUICK = (
    "parameters/hula_hoop/stiffness_1e+12/mujoco",
    "parameters/hula_hoop/stiffness_1e+09/exudyn",
    "parameters/speed_regulator/massless_rod_and_slider/exudyn",
    "parameters/speed_regulator/lambda_1-1e-09/mujoco",
    "limits/rotating_beam/limits of elements/exudyn",
    "starts/hula_hoop/rod_aligned_at_rest/exudyn",
    "starts/rotor_pendulum/at_rest/mujoco",
    "starts/rotating_beam/straight_in_rotation/mujoco",
    "starts/speed_regulator/open_by_0.001_m/exudyn",
    "starts/speed_regulator/rest_top/exudyn",
    "long/hula_hoop/free, tree/mujoco",
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

LONGEST = (
    "long/rotor_pendulum/conservative, kinematic_tree/exudyn",
    "long/rotor_pendulum/locked, kinematic_tree/exudyn",
    "parameters/hula_hoop/speed_1e4/exudyn",
    "parameters/rotating_beam/no_second_order_coupling/reference",
)
"""Tasks that take longest, which are run by hand: two long runs, two at the ends of parameters."""


DECADES = re.compile(r"(.*_1e)([+-]?\d+)(/.*)")
"""Names of tasks that try one parameter in several decades."""


def farthest(names: Iterable[str]) -> set[str]:
    """Return the names but for those of decades nearer to 1 than another of the same parameter."""
    kept: dict[tuple[str, bool, str], tuple[int, str]] = {}
    for name in names:
        found = DECADES.fullmatch(name)
        before, decade, after = found.groups() if found else (name, "0", "")
        key = before, int(decade) > 0, after
        kept[key] = max(kept.get(key, (-1, "")), (abs(int(decade)), name))
    return {name for _, name in kept.values()}


def tasks() -> dict[str, Provocation]:
    """Return all tasks of the default set by their id."""
    found = run.tasks(SCENES, ENGINES, (), False)
    return {f"{t.section}/{t.scene}/{t.name}/{t.engine}": t for t in found}


Key = tuple[str, str, str, str]
"""Section, scene, what was tried, and by which engine, model, method and step."""


def golden() -> dict[Key, str]:
    """Return outcome and noticers of each row of the golden table."""
    return {
        (
            row["section"],
            row["scene"],
            row["what"],
            maker(row["engine"], row["model"], row["method"], row["step [s]"]),
        ): f"{row['outcome']} {row['who notices']}".strip()
        for row in table()
    }


def maker(*words: str) -> str:
    """Return who made a row."""
    return " ".join(filter(None, words))


def table() -> list[dict[str, str]]:
    """Return the rows of the golden table."""
    path = DOCS / "extremes.csv"
    with path.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


def classes(rows: Iterable[Row]) -> dict[Key, str]:
    """Return the same of rows."""
    return {
        (
            row.section,
            row.scene,
            row.name,
            maker(row.engine, row.model, row.method or "", number(row.step, missing="")),
        ): " ".join(filter(None, [row.outcome, ", ".join(row.noticed_by)]))
        for row in rows
    }


def test_tasks_are_told_apart() -> None:
    assert len(tasks()) == len(run.tasks(SCENES, ENGINES, (), False))
    assert {*QUICK, *LONGEST} < set(tasks())


def test_the_table_has_every_outcome_and_every_noticer() -> None:
    said = [text.replace(",", "").split() for text in golden().values()]
    assert {first for first, *_ in said} == set(OUTCOMES)
    noticed = {who for _, *rest in said for who in rest}
    assert {ENGINE, GUARD, HALVING, REFERENCE} < noticed
    assert any(who.startswith(RULE) for who in noticed)
    for outcome, *rest in said:
        assert (outcome in (RIGHT, SKIPPED)) or rest
        assert (outcome != RIGHT) or not rest
        assert (outcome != WRONG) or rest[-1] == REFERENCE
        assert (outcome != FAILED) or rest[0] in (ENGINE, GUARD)
    assert {key[0] for key in golden()} == set(SECTIONS)


def test_every_failure_fails_but_those_that_are_harmless() -> None:
    right = {key[2] for key, said in golden().items() if key[0] == "failures" and said == RIGHT}
    assert right == {one.name for scene in SCENES for one in cases.failures(scene) if one.harmless}


def test_the_page_shows_what_only_the_reference_notices() -> None:
    unseen = {
        (row["scene"], row["what"])
        for row in table()
        if (row["outcome"], row["who notices"]) == (WRONG, REFERENCE)
    }
    page = (DOCS / "extremes.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.split(" | ")] for line in page.splitlines()]
    shown = {(first.strip("| "), second) for first, second, *_ in (row for row in rows if row[4:])}
    assert shown - {("scene", "what"), ("---", "---")} == unseen
    counts = Counter(row["outcome"] for row in table())
    for outcome, words in OUTCOMES.items():
        assert f"* **{outcome}**: {words} ({counts[outcome]})" in page


@pytest.mark.parametrize("value", [1e-4, 1.25 * (1 - 1e-9), 2**-10, 3, 0.0])
def test_what_provokes_a_row_is_read_back_from_the_table(value: float) -> None:
    row = Row("parameters", "s", "n", "e", "m", changed={"crank_radius": value})
    name, text = pages.changes(row).split("=")
    assert (name, float(text)) == ("crank_radius", value)


def check(name: str) -> None:
    """Do a task, and hold its rows against the table: no drift is a surprise."""
    made = tasks()[name].call()
    rows, expected = classes(made), golden()
    assert rows
    assert not [row for row in made if "not as predicted" in row.reason]
    assert rows == {key: expected.get(key) for key in rows}


@pytest.mark.parametrize("name", QUICK)
def test_quick_rows_are_golden(name: str) -> None:
    check(name)


def alternating(names: Iterable[str]) -> set[str]:
    """Return the names by every second engine or model of what several try, turn and turn about.

    Limits, of which each model has its own, and failures are all kept.
    """
    kept, tried = set(), dict[str, list[str]]()
    for name in sorted(names):
        section = name.partition("/")[0]
        by_engine = section in ("parameters", "starts")
        what = name.rpartition("/")[0] if by_engine else name.partition(", ")[0]
        tried.setdefault(what if by_engine or section == "long" else name, []).append(name)
    for place, several in enumerate(tried.values()):
        kept |= set(several if len(several) == 1 else several[place % 2 :: 2])
    return kept


def marked() -> list[Any]:
    """Return the tasks that are not of the default run.

    Nearer decades, what another engine or model tries and `LONGEST` are run by hand.
    """
    slow = farthest(tasks()) & alternating(tasks()) - set(LONGEST)
    return [
        pytest.param(name, marks=pytest.mark.slow if name in slow else pytest.mark.campaign)
        for name in sorted(set(tasks()) - set(QUICK))
    ]


@pytest.mark.parametrize("name", marked())
def test_rows_are_golden(name: str) -> None:
    check(name)
