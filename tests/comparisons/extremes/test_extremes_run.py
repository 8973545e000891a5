"""The extremes as a whole: tasks in processes, what dies, the document, and the verb."""

from __future__ import annotations

import csv
import json
import os
import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.cli.group import program
from mbcheck.comparisons.extremes import cases, pages, run
from mbcheck.comparisons.extremes.row import REFERENCE, WRONG, Provocation, Row
from mbcheck.comparisons.extremes.run import Extremes, extremes
from mbcheck.tests.support.documents import validated


def few(*extra: Any) -> list[Provocation]:
    """Return two cheap tasks and more."""
    known = cases.extreme_tasks("starts", ("hula_hoop",), ("exudyn",), False)
    return [*known[:2], *extra]


def test_a_task_that_dies_takes_no_other_along(monkeypatch: pytest.MonkeyPatch) -> None:
    dying = Provocation("starts", "hula_hoop", "dies", "exudyn", os.abort)
    monkeypatch.setattr(run, "tasks", lambda *_: few(dying))
    states: list[tuple[int, int, str]] = []
    found = extremes(jobs=2, progress=lambda *state: states.append(state))
    assert states[-1][:2] == (3, 3)
    assert [row.name for row in found.lost] == ["dies"]
    assert "crashed" in found.lost[0].reason
    assert len(found.rows) > 2
    assert found.rows[-1].name == "dies"  # in the order of the tasks
    validated("extremes", found.as_json())
    assert sum(found.summary.values()) == len(found.rows)


def row(**changes: Any) -> Row:
    usual: dict[str, Any] = {
        "section": "starts", "scene": "hula_hoop", "name": "a | b", "engine": "mujoco",
        "model": "tree", "method": "RK4", "step": 1e-3, "changed": {"y": 0.1},
        "outcome": WRONG, "noticed_by": (REFERENCE,), "error": 1.0, "predicted": 0.1,
        "reason": "wrong",
    }  # fmt: skip
    return Row(**usual | changes)


def test_the_page_is_a_table_with_what_nobody_sees() -> None:
    found = Extremes([], ("mujoco",), False, {0: [row(), row(method="Euler", reason="worse")]})
    text = pages.markdown(found)
    (line,) = [one for one in text.splitlines() if one.startswith("| hula_hoop")]
    assert "a \\| b" in line
    assert "mujoco tree RK4" in line
    assert "mujoco tree Euler" in line
    assert "* **wrong**: finite, and wrong (2)" in text
    assert len(pages.unseen(found)) == 2
    seen = row(noticed_by=("rule:step_limit", REFERENCE), name="seen")
    both = Extremes([], (), False, {0: [row(), seen]})
    assert pages.unseen(both) == [row()]
    assert "seen" not in pages.markdown(both).partition("## starts")[2]


def test_the_whole_table_is_csv_with_few_digits() -> None:
    rows = [row(error=0.123456, predicted=None), row(noticed_by=(), outcome="right", step=None)]
    text = pages.csv_text(Extremes([], ("mujoco",), False, {0: rows}))
    head, first, second = csv.reader(text.splitlines())
    assert dict(zip(head, first, strict=True)) == {
        "section": "starts", "scene": "hula_hoop", "what": "a | b", "provoked by": "y=0.1",
        "engine": "mujoco", "model": "tree", "method": "RK4", "step [s]": "0.001",
        "outcome": "wrong", "who notices": "reference", "error": "0.123", "predicted": "",
        "reason": "wrong",
    }  # fmt: skip
    assert (second[7], second[9]) == ("", "")


def test_places_of_files_stay_out_of_the_table() -> None:
    """Exudyn names the Python file that called it, which is another on every machine."""
    named = row(reason="no solver [Python file '/home/x/engine.py', line 15]\n in sight")
    assert pages.words(named) == "no solver in sight"


def test_an_interrupted_run_keeps_what_it_has(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(found: Extremes, jobs: int) -> Iterator[tuple[int, int, str]]:
        found.rows_of[0] = [row()]
        yield 1, 2, "one of two"
        raise KeyboardInterrupt

    monkeypatch.setattr(Extremes, "work", interrupted)
    file = tmp_path / "found.json"
    asked = ["extremes", "hula_hoop", "--section", "starts", "--json", str(file)]
    assert program.exit_code(args=asked) == 130
    assert "interrupted" in capsys.readouterr().err
    assert len(json.loads(file.read_text())["rows"]) == 1


def test_tasks_can_be_sent() -> None:
    for task in run.tasks(("hula_hoop", "rotating_beam"), ("mujoco", "exudyn"), (), True):
        assert pickle.loads(pickle.dumps(task.call))
