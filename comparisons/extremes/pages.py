"""The extremes table: as CSV, as a page of what only the reference sees, and for the console."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import groupby

from rich.console import Console

from ..engines.variants.catalogue import NOT_PROVOKED
from ..reports.text import markdown_table, print_line, print_table, print_wrapped
from ..reports.words import assignments, exact, number
from .cases import failures
from .row import OUTCOMES, REFERENCE, RIGHT, SECTIONS, WRONG, Row
from .run import ABOUT, Extremes

HEADS = ("scene", "what", "provoked by", "engine, model, method", "reason")

COLUMNS = (
    "section", "scene", "what", "provoked by", "engine", "model", "method", "step [s]", "outcome",
    "who notices", "error", "predicted", "reason",
)  # fmt: skip

INTRODUCTION = """# Extremes

`mbcheck extremes{full} --markdown` wrote this page: what is finite and wrong, and only the
reference notices. The whole table is [extremes.csv](extremes.csv), written by `--csv`.
"""

WHO = """Who notices, in the table: `engine`, the engine itself or its adapter; `guard`, what
mbcheck asks of every run; `rule:...`, a rule that is known before the run; `halving`, a run with
half the step; `reference`, only who knows the truth.
"""


def markdown(result: Extremes) -> str:
    """Return the page: what `docs/extremes.md` is."""
    counts = [f"* **{name}**: {words} ({result.summary[name]})" for name, words in OUTCOMES.items()]
    lines = [INTRODUCTION.format(full=" --full" if result.full else ""), *counts, "", WHO]
    for section in SECTIONS:
        rows = [row for row in unseen(result) if row.section == section]
        if rows:
            lines += [f"## {section}", "", f"{ABOUT[section]}.", "", table(rows), ""]
    lines += [f"Provoked, and harmless here: {', '.join(harmless(result)) or 'none'}.", ""]
    lines += ["Known of these engines, and not provoked:", ""]
    lines += [f"* {mode}: {why}" for mode, why in NOT_PROVOKED]
    return "\n".join(lines).rstrip() + "\n"


def harmless(result: Extremes) -> list[str]:
    """Return what is said to fail and is right."""
    return [
        row.name
        for row in result.rows
        if row.outcome == RIGHT
        and any(one.harmless and one.name == row.name for one in failures(row.scene, row.section))
    ]


def csv_text(result: Extremes) -> str:
    """Return the whole table as CSV, numbers with few digits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in result.rows:
        names = row.section, row.scene, row.name, changes(row), row.engine, row.model
        numbers = [number(value, missing="") for value in (row.step, row.error, row.predicted)]
        verdict = row.outcome, ", ".join(row.noticed_by)
        writer.writerow((*names, row.method, numbers[0], *verdict, *numbers[1:], words(row)))
    return text.getvalue()


def words(row: Row) -> str:
    """Return a row's reason on one line, without the places of files."""
    return " ".join(re.sub(r" \[Python file .*?\]", "", row.reason).split())


def table(rows: Sequence[Row]) -> str:
    """Return rows as a Markdown table; what methods have in common is one line."""
    lines = []
    for _, same in groupby(rows, lambda row: (row.scene, row.name, changes(row), row.engine)):
        group = list(same)
        worst = max(group, key=lambda row: -1.0 if row.error is None else row.error)
        who = "; ".join(dict.fromkeys(maker(row) for row in group))
        lines.append((worst.scene, worst.name, changes(worst), who, words(worst)))
    return markdown_table(HEADS, lines)


def maker(row: Row) -> str:
    """Return engine, model, method and step in words."""
    step = "" if row.step is None else f", h = {number(row.step)} s"
    return " ".join(filter(None, [row.engine, row.model, row.method])) + step


def changes(row: Row) -> str:
    """Return what provokes a row in words: of a limit, what it is, else exactly what is set."""
    if row.section == "limits":
        return assignments(row.changed, 4)
    return assignments({k: v if isinstance(v, str) else exact(v) for k, v in row.changed.items()})


def unseen(result: Extremes) -> list[Row]:
    """Return the rows that are wrong, and that only the reference notices."""
    return [row for row in result.rows if row.outcome == WRONG and row.noticed_by == (REFERENCE,)]


def show(console: Console, result: Extremes, every: bool) -> None:
    """Print how many rows came out how, and what only the reference notices, or all that is off."""
    counts: Mapping[tuple[str, str], int] = Counter((r.section, r.outcome) for r in result.rows)
    sections = [name for name in SECTIONS if any(key[0] == name for key in counts)]
    rows = [(name, *(counts[name, outcome] for outcome in OUTCOMES)) for name in sections]
    print_table(console, ("section", *OUTCOMES), rows)
    hidden = unseen(result)
    for row in [row for row in result.rows if row.outcome != RIGHT] if every else hidden:
        noticed = ", ".join(row.noticed_by) or "-"
        print_wrapped(
            console,
            f"{row.outcome} {row.section}/{row.scene}/{row.name}, {maker(row)}; noticed by "
            f"{noticed}: {row.reason}",
        )
    print_line(
        console, f"{len(result.rows)} rows; of {len(hidden)} wrong ones only the reference knows"
    )
