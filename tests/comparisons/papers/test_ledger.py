"""The ledgers: their tables, how a row is assessed, and that verdicts are the expected ones."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.papers import ledger, pages
from mbcheck.comparisons.papers.assess import assess, attempt, fill, measure
from mbcheck.comparisons.papers.claims import (
    read_condition,
    read_paper,
    read_row,
    scenes_with_ledger,
)
from mbcheck.comparisons.papers.ledger import (
    CORRECTED,
    NOT_REPRODUCED,
    NOT_TESTABLE,
    REPRODUCED,
)
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference.errors import EngineError
from mbcheck.tests.support.papers.shared import expected_findings, row_of

EVERY_ROW = [(scene, row) for scene in scenes_with_ledger() for row in read_paper(scene).rows]


@pytest.fixture(scope="module")
def summary(clone: Path) -> str:
    """Return the committed summary."""
    return (clone / "docs" / "ledger.md").read_text(encoding="utf-8")


# How a row is assessed


@pytest.mark.parametrize(
    ("printed", "value", "verdict"),
    [
        ("3.10", 3.1049, REPRODUCED),
        ("3.10", 3.0951, REPRODUCED),
        ("3.10", 3.1051, NOT_REPRODUCED),
        ("153.8", 153.74, NOT_REPRODUCED),
        ("0.000204", 0.0002044, REPRODUCED),
        ("7e-4", 7.6e-4, NOT_REPRODUCED),
        ("-0.515", -0.5154, REPRODUCED),
        ("-0.515", 0.515, NOT_REPRODUCED),
        ("5", float("nan"), NOT_REPRODUCED),
    ],
)
def test_number_is_reproduced_if_it_rounds_to_what_is_printed(
    printed: str, value: float, verdict: str
) -> None:
    row = row_of("a", lambda s: {"value": value}, kind="number", printed=printed)
    assert assess(row, Session()).verdict == verdict


def test_corrected_equation_is_told_apart() -> None:
    def verdict(value: float, **judgement: list[str]) -> str:
        keys: dict[str, Any] = {"kind": "number", "printed": "2.0", **judgement}
        return assess(row_of("a", lambda s: {"value": value}, **keys), Session()).verdict

    assert verdict(2.01, corrected_if=["value rounds to printed"]) == CORRECTED
    assert verdict(2.1, corrected_if=["value rounds to printed"]) == NOT_REPRODUCED
    either = {"corrected_if": ["value < 2"], "reproduced_if": ["value < 1"]}
    assert [verdict(value, **either) for value in (0.5, 1.5, 2.5)] == [
        REPRODUCED,
        CORRECTED,
        NOT_REPRODUCED,
    ]


@pytest.mark.parametrize(
    ("condition", "value", "expected"),
    [
        ("x < 1", 0.5, True),
        ("x < 1", 1.0, False),
        ("x < 1", [0.5, 2.0], False),
        ("x > 0", np.array([1.0, 2.0]), True),
        ("x > 0", float("nan"), False),
        ("x < 0", float("nan"), False),
        ("x == rest", "rest", True),
        ("x == rest", "rotation", False),
        ("x == true", np.bool_(True), True),
        ("x <= 1", [1, 1], True),
        ("x >= 2, ours", [2, 1], False),
        ("x < 1e-3, everyone, ours", 9e-4, True),
    ],
)
def test_conditions(condition: str, value: Any, expected: bool) -> None:
    assert read_condition(condition).compare({"x": value}).holds is expected


@pytest.mark.parametrize(
    ("value", "ours", "verdict"),
    [
        (9.0, True, REPRODUCED),
        (9.7, True, ledger.OPEN),
        (10.3, True, ledger.OPEN),
        (11.0, True, NOT_REPRODUCED),
        (9.7, False, REPRODUCED),
        (10.3, False, NOT_REPRODUCED),
    ],
)
def test_no_verdict_hangs_on_a_limit_of_ours_that_is_close(
    value: float, ours: bool, verdict: str
) -> None:
    condition = "value < 10" + ", ours" * ours
    row = row_of("a", lambda session: {"value": [1.0, value]}, reproduced_if=[condition])
    assessment = assess(row, Session())
    assert assessment.verdict == verdict
    (threshold,) = assessment.thresholds
    assert threshold.value == value
    assert threshold.distance == pytest.approx(10 - value)


def test_a_close_limit_is_open_only_where_the_verdict_hangs_on_it() -> None:
    def verdict(first: float, second: float) -> str:
        conditions = ["x < 10, ours", "y < 1"]
        row = row_of("a", lambda session: {"x": first, "y": second}, reproduced_if=conditions)
        return assess(row, Session()).verdict

    assert [verdict(9.9, 0.5), verdict(9.9, 2)] == [ledger.OPEN, NOT_REPRODUCED]


def test_printed_number_is_a_number_with_unit_and_tolerance() -> None:
    row = row_of("a", each=by_engine, kind="number", printed="3.08 N m")
    assessment = assess(row, Session(("able", "silent")))
    assert row.quantity == ledger.Printed(3.08, 0.005, "N m")
    assert assessment.values == {"reference": 1.0, "able": 2.0}
    (threshold,) = assessment.thresholds
    assert (threshold.limit, threshold.value) == (3.08, 1.0)
    assert threshold.distance == pytest.approx(0.005 - 2.08)


def test_formulas_use_those_before_them_names_of_measures_and_who_computes() -> None:
    keys = {"numbers": {"a": "NATURAL", "value": "a - NATURAL + 1"}, "each": {"last": "who[-1]"}}
    row = read_row("hula_hoop", "a", {"section": "1", "claim": "a claim", **keys}, {})
    numbers, engines = measure(row, Session(("mujoco",)))
    assert (numbers["value"], engines) == (1, {"mujoco": {"unit": "", "last": "o"}})
    keys = {"numbers": {"a": "ab"}}
    wrong = read_row("rotor_pendulum", "a", {"section": "1", "claim": "a claim", **keys}, {})
    assert attempt(lambda: assess(wrong, Session()))[1] == "NameError: name 'ab' is not defined"


def by_engine(session: Session, who: str) -> Any:
    """Return 1 by the reference, 2 by one engine, words and a failure by others."""
    if who == "broken":
        raise EngineError("failed", "went away")
    return "cannot tell" if who == "silent" else {"reference": 1.0, "able": 2.0}[who]


def test_engines_stand_beside_the_reference() -> None:
    session = Session(("able", "silent", "broken"))
    keys = {"reference": "{value:.1f} m", "reproduced_if": ["value < 1.5"]}
    row = row_of("a", each=by_engine, **keys)
    assessment = assess(row, session)
    assert assessment.verdict == REPRODUCED
    assert assessment.reference == "1.0 m"
    assert assessment.engines == {"able": "2.0 m", "silent": "cannot tell", "broken": "went away"}
    assert assessment.numbers == {"reference": {"value": 1.0}, "able": {"value": 2.0}}


def test_condition_of_everyone_looks_at_engines() -> None:
    def verdict(engine: str, limit: float) -> str:
        row = row_of("a", each=by_engine, reproduced_if=[f"value < {limit}, everyone"])
        return assess(row, Session((engine,))).verdict

    assert verdict("able", 3) == REPRODUCED
    assert verdict("able", 1.5) == NOT_REPRODUCED
    with pytest.raises(EngineError, match="went away"):
        verdict("broken", 3)
    with pytest.raises(EngineError, match="cannot tell"):
        verdict("silent", 3)


def test_templates_take_lists_mappings_and_truth() -> None:
    numbers = {
        "list": [1.0, 2.5], "pairs": {"rest": 0.25, "rotation": 0.75}, "yes": np.bool_(True),
        "nested": [{"rest": 1.0}, {"rotation": 0.5}], "word": "rest", "names": ("a", "b"),
    }  # fmt: skip
    assert fill("{list:.1f}; {list[1]:.2f}", numbers) == "1.0, 2.5; 2.50"
    assert fill("{pairs:.0%}", numbers) == "rest 25%, rotation 75%"
    assert fill("{nested:.0%}", numbers) == "rest 100%; rotation 50%"
    assert fill("{yes} {yes!s} {word} {names}", numbers) == "yes True rest a, b"


# The tables of the papers


@pytest.mark.parametrize("scene", scenes_with_ledger())
def test_tables_are_complete(scene: str) -> None:
    figures, rows = read_paper(scene).figures, read_paper(scene).rows
    wanted = {
        "hula_hoop": range(2, 8),
        "rotor_pendulum": range(2, 7),
        "rotating_beam": range(2, 6),
        "speed_regulator": range(3, 8),
    }
    assert [figure.number for figure in figures] == list(wanted[scene])
    assert len({row.name for row in rows}) == len(rows) >= 20
    assert {row.kind for row in rows} == set(ledger.KINDS)
    for row in rows:
        assert re.fullmatch(r"[a-z0-9_]+", row.name)
        assert row.section
        assert row.claim
        assert (row.erratum is not None) >= (row.kind == "misprint")
        assert bool(row.printed) or row.kind != "number"
        assert bool(row.candidates) == (row.kind == "reading")
        assert row.verdict in (ledger.VERDICTS if row.kind != "reading" else (ledger.READ,))


EQUATIONS = {"hula_hoop": 62, "rotor_pendulum": 36, "rotating_beam": 23, "speed_regulator": 21}
"""Number of the last equation of each paper."""


@pytest.mark.parametrize(("scene", "last"), EQUATIONS.items())
def test_every_equation_has_a_row_that_computes(scene: str, last: int) -> None:
    there: set[int] = set()
    for row in read_paper(scene).rows:
        if row.is_text:
            continue
        for first, end in re.findall(r"\((\d+)\)(?:-\((\d+)\))?", row.section):
            there.update(range(int(first), int(end or first) + 1))
    assert there == set(range(1, last + 1))


@pytest.mark.parametrize("scene", scenes_with_ledger())
def test_causes_are_of_rows_that_do_not_hold_as_printed(scene: str) -> None:
    held = {row.name: row.verdict for row in read_paper(scene).rows}
    shared = [name for cause in read_paper(scene).causes for name in cause.rows]
    assert len(set(shared)) == len(shared)
    assert {cause.name for cause in read_paper(scene).causes if len(cause.rows) < 2} == set()
    assert {held[name] for name in shared} <= set(ledger.VERDICTS) - {REPRODUCED, NOT_TESTABLE}


def test_row_computes_or_is_text() -> None:
    """What cannot be tested simulates nothing; what is computed is judged by conditions."""
    for _, row in EVERY_ROW:
        unjudged = row.kind == "reading" or row.verdict == NOT_TESTABLE
        assert bool(row.judgement) == (not row.is_text and not unjudged), row.name
        is_told = unjudged or row.kind == "misprint"
        assert not row.is_text or (row.reason and is_told), row.name


def test_a_mistake_in_a_file_is_told_with_row_and_field() -> None:
    for keys, words in (
        ({"claims": "a"}, "row a: 'claims' is no field; there are kind, name"),
        ({"verdict": 3}, "row a: Expected `str`, got `int` - at `$.verdict`"),
        ({"kind": "claims"}, "row a: Invalid enum value 'claims' - at `$.kind`"),
        ({"reproduced_if": ["x is 3"]}, "row a: 'x is 3' is no condition such as"),
        ({"numbers": "absent"}, "row a: module .* has no attribute 'absent'"),
        ({"numbers": {"value": "1 +"}}, "row a: invalid syntax"),
        ({"erratum": {"wy": "a"}}, "row a: 'wy' is no field; there are corrected, why"),
    ):
        with pytest.raises(ValueError, match=words.replace("$", "\\$")):
            read_row("hula_hoop", "a", {"section": "1", "claim": "a", "verdict": "", **keys}, {})


def test_summary_is_the_golden_one(summary: str) -> None:
    """With the expected verdicts; the file is committed as ``mbcheck reproduce`` wrote it."""
    assert pages.summary(expected_findings(*scenes_with_ledger())) == summary
