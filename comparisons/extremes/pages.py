"""The extremes table: as CSV, as a page of what only the reference sees, and for the console."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

from ..engines.variants.catalogue import NOT_PROVOKED
from ..reports.tables import show as say
from ..reports.tables import table as columns
from .failures import failures
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


def markdown(found: Extremes) -> str:
    """Return the page: what `docs/extremes.md` is."""
    counts = [f"* **{name}**: {words} ({found.summary[name]})" for name, words in OUTCOMES.items()]
    lines = [INTRODUCTION.format(full=" --full" if found.full else ""), *counts, "", WHO]
    for section in SECTIONS:
        rows = [row for row in unseen(found) if row.section == section]
        if rows:
            lines += [f"## {section}", "", f"{ABOUT[section]}.", "", *table(rows), ""]
    lines += [f"Provoked, and harmless here: {', '.join(harmless(found)) or 'none'}.", ""]
    lines += ["Known of these engines, and not provoked:", ""]
    lines += [f"* {mode}: {why}" for mode, why in NOT_PROVOKED]
    return "\n".join(lines).rstrip() + "\n"


def harmless(found: Extremes) -> list[str]:
    """Return what is said to fail and is right."""
    return [
        row.name
        for row in found.rows
        if row.outcome == RIGHT
        and any(one.harmless and one.name == row.name for one in failures(row.scene, row.section))
    ]


def csv_text(found: Extremes) -> str:
    """Return the whole table as CSV, numbers with few digits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in found.rows:
        who = row.engine, row.model, row.method or ""
        numbers = (
            f"{value:.3g}" if value is not None else "" for value in (row.error, row.predicted)
        )
        writer.writerow(
            (row.section, row.scene, row.name, changes(row), *who, step(row), row.outcome,
             ", ".join(row.noticed_by), *numbers, words(row)),
        )  # fmt: skip
    return text.getvalue()


def step(row: Row) -> str:
    """Return a row's step [s] in words."""
    return "" if row.step is None else f"{row.step:.3g}"


def words(row: Row) -> str:
    """Return a row's reason on one line, without the places of files."""
    return " ".join(re.sub(r" \[Python file .*?\]", "", row.reason).split())


def table(rows: Sequence[Row]) -> list[str]:
    """Return rows as a Markdown table; what methods have in common is one line."""
    lines = [f"| {' | '.join(HEADS)} |", f"|{' --- |' * len(HEADS)}"]
    for _, same in groupby(rows, lambda row: (row.scene, row.name, changes(row), row.engine)):
        group = list(same)
        worst = max(group, key=lambda row: -1.0 if row.error is None else row.error)
        who = "; ".join(dict.fromkeys(maker(row) for row in group))
        cells = (worst.scene, worst.name, changes(worst), who, words(worst))
        lines.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |")
    return lines


def maker(row: Row) -> str:
    """Return engine, model, method and step in words."""
    named = " ".join(filter(None, [row.engine, row.model, row.method]))
    return named if row.step is None else f"{named}, h = {step(row)} s"


def changes(row: Row) -> str:
    """Return what provokes a row in words: of a limit, what it is, else exactly what is set."""
    write = "{:.4g}".format if row.section == "limits" else repeatable
    return ", ".join(
        f"{name}={value if isinstance(value, str) else write(value)}"
        for name, value in row.changed.items()
    )


def repeatable(value: float) -> str:
    """Return a number in six digits, or in as many as it takes to read it back."""
    short = f"{value:.6g}"
    return short if float(short) == value else repr(float(value))


def unseen(found: Extremes) -> list[Row]:
    """Return the rows that are wrong, and that only the reference notices."""
    return [row for row in found.rows if row.outcome == WRONG and row.noticed_by == (REFERENCE,)]


def show(console: Any, found: Extremes, every: bool) -> None:
    """Print how many rows came out how, and what only the reference notices, or all that is off."""
    counts: Mapping[tuple[str, str], int] = Counter((r.section, r.outcome) for r in found.rows)
    sections = [name for name in SECTIONS if any(key[0] == name for key in counts)]
    rows = [(name, *(counts[name, outcome] for outcome in OUTCOMES)) for name in sections]
    columns(console, ("section", *OUTCOMES), rows)
    hidden = unseen(found)
    for row in [row for row in found.rows if row.outcome != RIGHT] if every else hidden:
        noticed = ", ".join(row.noticed_by) or "-"
        say(
            console,
            f"{row.outcome} {row.section}/{row.scene}/{row.name}, {maker(row)}; noticed by "
            f"{noticed}: {row.reason}",
        )
    say(console, f"{len(found.rows)} rows; of {len(hidden)} wrong ones only the reference knows")
