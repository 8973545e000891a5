"""Rows as checks of the one list: `check --source validation`."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.check.request import check
from mbcheck.comparisons.checks.execution import run_checks
from mbcheck.comparisons.checks.request import Execution
from mbcheck.comparisons.papers import plan as papers
from mbcheck.comparisons.papers.claims import (
    PaperData,
    read_condition,
    read_paper,
    scenes_with_ledger,
)
from mbcheck.comparisons.papers.ledger import NOT_REPRODUCED, NOT_TESTABLE, REPRODUCED, LedgerRow
from mbcheck.comparisons.papers.plan import judged_number, plan
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference.errors import EngineError, UsageError
from mbcheck.tests.support.command import invoke, refusal
from mbcheck.tests.support.documents import validated
from mbcheck.tests.support.papers.shared import row_of

QUICK = ["validation/speed_regulator/mean_*", "validation/rotor_pendulum/eta"]


def crash(session: Session) -> Any:
    raise EngineError("non_finite", "the state exploded")


def toy(name: str, verdict: str, value: float = 2.01) -> LedgerRow:
    """Return the row of a number that is printed as 2.0."""
    keys = {"kind": "number", "verdict": verdict, "reason": "why", "printed": "2.0 m/s"}
    return row_of(name, lambda session: {"value": value}, **keys)


TOYS = (
    toy("expected", REPRODUCED),
    toy("changed", REPRODUCED, 2.1),
    toy("still_wrong", NOT_REPRODUCED, 2.1),
    toy("nowhere", REPRODUCED, float("nan")),
    row_of("broken", crash, reproduced_if=["value > 0"]),
    row_of("text", verdict=NOT_TESTABLE, reason="an outlook"),
)


@pytest.fixture
def _toys(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(papers, "read_paper", lambda scene: PaperData(rows=TOYS))


# What is planned


def test_every_row_has_its_id() -> None:
    ids = [name for item in plan(full=True) for name in item.ids]
    rows = [
        f"validation/{scene}/{row.name}"
        for scene in scenes_with_ledger()
        for row in read_paper(scene).rows
    ]
    assert ids == rows


def test_slow_rows_are_left_out_of_the_default_set() -> None:
    chosen = {name for item in plan(["hula_hoop"]) for name in item.ids}
    assert "validation/hula_hoop/mean_slope" in chosen
    assert "validation/hula_hoop/region_2" not in chosen


def test_rows_are_chosen_by_kind_and_id() -> None:
    assert {item.kind for item in plan(kinds=["number"], full=True)} == {"number"}
    (only,) = plan(ids=["*/hula_hoop/mass_*"])
    assert only.ids == ("validation/hula_hoop/mass_ratio",)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("hula_hop", "did you mean 'hula_hoop'"),
        ("--kind trajectory", "unknown kind of row 'trajectory'"),
        ("--id x", "none is left by --id x; nearest ids: validation/"),
        ("--id validation/hula_hoop/region_2", "none is left by a run without --full"),
        ("--engine mujoco", "choose among checks of engines"),
        ("--method RK4", "choose among checks of engines"),
    ],
)
def test_misuse_is_refused(line: str, words: str) -> None:
    assert words in refusal(f"check --source validation {line}")


def test_unknown_source_is_refused() -> None:
    assert "did you mean 'validation'" in refusal("check --source validaton")


def test_engines_alone_are_checked_by_default() -> None:
    with pytest.raises(UsageError, match="no check matches"):
        check(ids=["validation/*"])


# What becomes of rows


@pytest.mark.usefixtures("_toys")
def test_a_changed_verdict_is_a_deviation() -> None:
    results = {r.quantity: r for r in check(["hula_hoop"], source="validation").results}
    verdicts = {name: result.verdict for name, result in results.items()}
    assert verdicts == {
        "expected": "pass",
        "changed": "deviation",
        "still_wrong": "pass",
        "nowhere": "error",
        "broken": "error",
        "text": "skipped",
    }
    changed = results["changed"]
    assert changed.id == "validation/hula_hoop/changed"
    assert changed.reason == (
        "was reproduced, is not reproduced: off by 0.1, rounding allows 0.05; why"
    )
    assert (changed.source, changed.engine, changed.kind) == ("validation", "reference", "number")
    assert (changed.value, changed.reference, changed.error, changed.tolerance) == (2.1, 2.0, 1, 0)
    assert results["still_wrong"].reason.startswith("not reproduced: off by 0.1")
    assert "exploded" in results["broken"].reason
    assert "nan cannot be judged" in results["nowhere"].reason


@pytest.mark.parametrize(
    ("condition", "value", "expected"),
    [
        ("x < 2", [0.5, 1.5], (1.5, 2.0)),
        ("x > 2", [0.5, 1.5], (0.5, 2.0)),
        ("x == rest", "rest", (1.0, 1.0)),
        ("x == true", False, (0.0, 1.0)),
        ("x rounds to printed", 2.01, (2.01, 2.0)),
    ],
)
def test_number_that_a_row_is_judged_by(condition: str, value: Any, expected: Any) -> None:
    threshold = read_condition(condition).compare({"x": value}, "2.0 m/s")
    assert judged_number(threshold) == expected


def test_results_do_not_depend_on_processes() -> None:
    checks = plan(ids=QUICK)
    alone, together = (
        [replace(item, work={}) for item in run_checks(checks, execution=Execution(jobs=jobs))]
        for jobs in (1, 2)
    )
    assert alone == together
    assert {item.verdict for item in alone} == {"pass"}


def test_an_engine_that_changes_a_verdict_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    row = row_of(
        "a",
        each=lambda session, who: float(who == "mujoco"),
        reproduced_if=["value < 0.5, everyone"],
    )
    monkeypatch.setattr(papers, "read_paper", lambda scene: PaperData(rows=(row,)))
    (result,) = papers.RowCheck("hula_hoop", "claim", ("a",), ("mujoco",)).run("default")
    assert result.verdict == "deviation"


# Documents


@pytest.mark.usefixtures("own_folder")
def test_documents_serve_rows() -> None:
    line = "check --source validation -j 1 --json a.json --junit a.xml --html pages"
    done = invoke(line, *(word for name in QUICK for word in ("--id", name)))
    assert done.exit_code == 0, done.output
    document = validated("check", json.loads(Path("a.json").read_text()))
    assert document["selection"]["source"] == "validation"
    assert document["checks"]["planned"] == len(document["results"]) == 5
    assert {item["source"] for item in document["results"]} == {"validation"}
    names = [item.get("name") for item in ET.parse("a.xml").iter("testcase")]
    assert "eta" in " ".join(map(str, names))
    assert "validation" in Path("pages/index.html").read_text()
    assert invoke("diff a.json a.json").exit_code == 0


@pytest.mark.usefixtures("_toys", "own_folder")
def test_known_deviations_cover_rows() -> None:
    done = invoke("check --source validation hula_hoop -j 1 --write-known known.toml")
    assert done.exit_code == 1
    assert "mbcheck check --source validation --id 'validation/hula_hoop/changed'" in done.output
    draft = Path("known.toml").read_text()
    assert '"validation/hula_hoop/changed" = ' in draft
    Path("known.toml").write_text(draft.replace("TODO: why does it deviate?", "the paper is wrong"))
    again = invoke("check --source validation hula_hoop -j 1 --known known.toml")
    assert again.exit_code == 0, again.output
    assert "3 known" in again.output
