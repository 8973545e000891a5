"""The table: 80 columns, and no word of a cell is ever broken, on the console or as Markdown."""

import io
import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from mbcheck import models
from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.cli import catalogue
from mbcheck.comparisons.reports.text import markdown_table, print_table
from mbcheck.comparisons.reports.words import assignments, exact, number, plain, with_unit
from mbcheck.reference import SCENES
from mbcheck.tests.support.command import on_a_terminal, succeeds

WIDTH = 80
DOCS = Path(__file__).resolve().parents[3] / "docs"


def printed(*table: Any, width: int = WIDTH, **options: Any) -> str:
    """Return a table in 80 columns."""
    raw = io.StringIO()
    console = Console(file=raw, width=width, color_system=None)
    print_table(console, *table, **options)
    return raw.getvalue()


WORDS = st.text(st.characters(codec="ascii", categories=["L", "N", "P", "S"]), min_size=1)
PROSE = st.lists(WORDS.map(lambda word: word[:40]), max_size=12).map(" ".join)
VALUES = st.one_of(st.none(), st.integers(), st.floats(), PROSE)


@st.composite
def tables(draw: st.DrawFn) -> tuple[list[str], list[list[object]]]:
    """Draw heads and rows of any values."""
    heads = draw(st.lists(PROSE, min_size=1, max_size=9))
    row: st.SearchStrategy[list[object]] = st.lists(
        VALUES, min_size=len(heads), max_size=len(heads)
    )
    return heads, draw(st.lists(row, max_size=6))


def words_of(value: object) -> list[str]:
    return number(value, 10, missing="-").split()


@given(tables())
def test_every_word_of_every_cell_is_printed_whole(
    table: tuple[list[str], list[list[object]]],
) -> None:
    heads, rows = table
    text = printed(heads, rows)
    there = text.split()
    for value in [value for row in rows for value in row]:
        for word in words_of(value):
            assert word in there
    for line in text.splitlines():
        assert len(line) <= WIDTH or len(line.split()) <= 2  # a head of one word, and a word


@given(tables())
def test_a_wide_console_has_a_line_for_each_row(
    table: tuple[list[str], list[list[object]]],
) -> None:
    heads, rows = table
    lines = printed(heads, rows, width=10**5).splitlines()
    assert len(lines) == len(rows) + 3  # heads, a rule, and a blank line at the end


@given(tables())
def test_markdown_has_a_cell_for_each_value(table: tuple[list[str], list[list[object]]]) -> None:
    heads, rows = table
    for line, row in zip(
        markdown_table(["a" for _ in heads], rows).splitlines()[2:], rows, strict=True
    ):
        cells = re.split(r"(?<!\\)\|", line)[1:-1]
        assert [cell.replace("\\|", "|").split() for cell in cells] == [words_of(v) for v in row]


def test_numbers_stand_to_the_right_and_words_to_the_left() -> None:
    rows = [("one", 1.5, 7, "4 m"), ("eleven", -2.25e-17, None, "12.5 m")]
    assert printed(("name", "x", "n", "size"), rows, digits=3).splitlines() == [
        "name            x  n  size",
        "----------------------------",
        "one           1.5  7  4 m",
        "eleven  -2.25e-17  -  12.5 m",
        "",
    ]


def test_a_row_with_one_value_is_a_heading_and_widens_no_column() -> None:
    rows = [("floating_platform", "", ""), ("  mujoco", "ok 1", "ok 2")]
    assert printed(("", "parts", "algebra"), rows).splitlines()[2:] == [
        "floating_platform",
        "  mujoco  ok 1   ok 2",
        "",
    ]


def test_the_widest_columns_are_wrapped_first() -> None:
    rows = [("x", "some words " * 6, "others " * 5, 1.25)]
    text = printed(("case", "differs by", "kinds", "at t [s]"), rows, width=60).splitlines()
    assert len(text[0]) <= 60
    assert len(text) > 4
    assert text[2].endswith("1.25")
    assert all(line.startswith("      some ") for line in text[3:-1] if "some" in line)


def test_prose_in_the_last_column_is_wrapped_between_words() -> None:
    text = printed(("name", "meaning"), [("stiffness", "of the spring, " * 10)])
    first, *more = text.splitlines()[2:-1]
    assert first.startswith("stiffness  of the spring,")
    assert more
    assert all(line.startswith(" " * 11) and line[11] != " " for line in more)


def test_what_does_not_fit_becomes_records() -> None:
    heads = ("engine", "model, method", "step [s]", "note")
    rows = [("mujoco", "m" * 40, 0.25, "n" * 30), ("exudyn", "k" * 40, 0.125, "")]
    assert printed(heads, rows).splitlines() == [
        "engine: mujoco",
        f"model, method: {'m' * 40}",
        "step [s]: 0.25",
        f"note: {'n' * 30}",
        "",
        "engine: exudyn",
        f"model, method: {'k' * 40}",
        "step [s]: 0.125",
        "",
    ]
    assert len(printed(heads, rows, width=120).splitlines()) == 5


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (1 / 3, 3, "0.333"),
        (-0.0, 3, "0"),
        (float("inf"), 3, "inf"),
        (float("-inf"), 3, "-inf"),
        (float("nan"), 3, "nan"),
        (12345, 3, "12345"),
        (12345.0, 3, "1.23e+04"),
        (None, 3, "none"),
        ("RK4", 3, "RK4"),
    ],
)
def test_numbers_as_words(value: object, digits: int, text: str) -> None:
    assert number(value, digits) == text


def test_units_and_assignments() -> None:
    assert with_unit(0.5, "rad") == "0.5 rad"
    assert with_unit(0.5, "1") == "0.5"
    assert with_unit(None, "rad") == "none"
    assert assignments({"y": 0.01, "scheme": "cells"}) == "y=0.01, scheme=cells"


@given(st.floats(allow_nan=False))
def test_an_exact_number_is_read_back(value: float) -> None:
    assert float(exact(value)) == value


def test_markdown_shows_text_as_it_is() -> None:
    assert plain("a_b *c* [d](e) <f> @g") == (
        "a\\_b \\*c\\* \\[d\\](e) &lt;f&gt; @\N{ZERO WIDTH SPACE}g"
    )


# What the verbs print


@pytest.mark.parametrize("scene", SCENES)
def test_a_scene_is_listed_whole_at_80_columns(scene: str) -> None:
    text = on_a_terminal(f"list {scene}")
    there = set(text.split())
    sheet = catalogue.scene_sheet(scene)
    for item in sheet["parameters"]:
        assert {item["name"], *item["symbol"].split(), number(item["default"], 10)} <= there
    for case in sheet["cases"]:
        for values in (case["parameters"], case["state"]):
            assert set(assignments(values).replace(",", "").split()) <= {
                word.rstrip(",") for word in there
            }
    assert {case["name"] for case in sheet["cases"]} <= there
    assert max(map(len, text.splitlines())) <= WIDTH


def test_the_coverage_fits_80_columns() -> None:
    text = on_a_terminal("list --coverage")
    assert max(map(len, text.splitlines())) <= WIDTH
    (heads,) = [line for line in text.splitlines() if "algebra" in line and "order" in line]
    assert heads.split() == list(KINDS)


@pytest.mark.parametrize("model", ["speed_regulator/connect", "rotating_beam/chain"])
def test_an_inspection_is_printed_whole_at_80_columns(model: str) -> None:
    pytest.importorskip("mujoco", exc_type=ImportError)
    path = Path(models.__file__).parent / f"{model}.xml"
    wide = on_a_terminal(f"inspect {path}", 500)
    narrow = succeeds(f"inspect {path}")
    words = {word for word in wide.split() if set(word) != {"-"}}
    assert words <= {word.removesuffix(":") for word in narrow.split()} | set(narrow.split())
    assert max(len(line) for line in narrow.splitlines() if str(path) not in line) <= WIDTH
