"""The extremes table as Markdown, and as lines for the console."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

from ..engines.variants.catalogue import NOT_PROVOKED
from .row import OUTCOMES, REFERENCE, RIGHT, SECTIONS, WRONG, Row
from .run import ABOUT, Extremes

HEADS = (
    "scene",
    "what",
    "provoked by",
    "engine, model, method",
    "outcome",
    "who notices",
    "reason",
)


def markdown(found: Extremes) -> str:
    """Return the whole table as a page: what `docs/extremes.md` is."""
    lines = ["# Extremes", ""]
    lines += [f"`mbcheck extremes{' --full' if found.full else ''}` wrote this page.", ""]
    lines += [f"* **{name}**: {words} ({found.summary[name]})" for name, words in OUTCOMES.items()]
    lines += [
        "",
        "Who notices: `engine`, the engine itself or its adapter; `guard`, what mbcheck asks of",
    ]
    lines += [
        "every run; `rule:...`, a rule that is known before the run; `halving`, a run with half the"
    ]
    lines += ["step; `reference`, only who knows the truth.", ""]
    for section in SECTIONS:
        rows = [row for row in found.rows if row.section == section]
        if rows:
            lines += [f"## {section}", "", f"{ABOUT[section]}.", "", *table(rows), ""]
        if rows and section == "failures":
            harmless = [row.name for row in rows if row.outcome == RIGHT and row.name in HARMLESS]
            lines += [f"Provoked, and harmless here: {', '.join(harmless) or 'none'}.", ""]
            lines += ["Known of these engines, and not provoked:", ""]
            lines += [f"* {mode}: {why}" for mode, why in NOT_PROVOKED] + [""]
    return "\n".join(lines).rstrip() + "\n"


def table(rows: Sequence[Row]) -> list[str]:
    """Return rows as a Markdown table; what engines and methods have in common is one line."""
    lines = [f"| {' | '.join(HEADS)} |", f"|{' --- |' * len(HEADS)}"]
    for _, same in groupby(rows, alike):
        group = list(same)
        first = group[0]
        who = "; ".join(dict.fromkeys(maker(row) for row in group))
        cells = (
            first.scene, first.name, changes(first.changed), who, first.outcome,
            ", ".join(first.noticed_by), reason(group),
        )  # fmt: skip
        lines.append(f"| {' | '.join(escaped(cell) for cell in cells)} |")
    return lines


def alike(row: Row) -> tuple[object, ...]:
    """Return what rows of one line have in common; each limit has its own numbers."""
    shared = row.scene, row.name, changes(row.changed), row.outcome, row.noticed_by, row.engine
    return (*shared, row.reason) if row.section == "limits" else shared


def maker(row: Row) -> str:
    """Return engine, model, method and step in words."""
    step = "" if row.step is None else f", h = {row.step:.3g} s"
    return " ".join(filter(None, [row.engine, row.model, row.method])) + step


def changes(changed: Mapping[str, float | str]) -> str:
    """Return what provokes a row in words."""
    return ", ".join(
        f"{name}={repeatable(value) if isinstance(value, float | int) else value}"
        for name, value in changed.items()
    )


def repeatable(value: float) -> str:
    """Return a number in six digits, or in as many as it takes to read it back."""
    short = f"{value:.6g}"
    return short if float(short) == value else repr(float(value))


def reason(group: Sequence[Row]) -> str:
    """Return the reason of the worst of some rows."""
    worst = max(group, key=lambda row: -1.0 if row.error is None else row.error)
    return worst.reason


def escaped(text: str) -> str:
    """Return text for a cell of a table."""
    return " ".join(text.replace("|", "\\|").split())


def unseen(found: Extremes) -> list[Row]:
    """Return the rows that are wrong, and that only the reference notices."""
    return [row for row in found.rows if row.outcome == WRONG and row.noticed_by == (REFERENCE,)]


def show(console: Any, found: Extremes, every: bool) -> None:
    """Print how many rows came out how, and what only the reference notices, or all that is off."""
    from ..reports.tables import show as say
    from ..reports.tables import table as columns

    counts = Counter((row.section, row.outcome) for row in found.rows)
    sections = [name for name in SECTIONS if any(key[0] == name for key in counts)]
    rows = [(name, *(counts[name, outcome] for outcome in OUTCOMES)) for name in sections]
    columns(console, ("section", *OUTCOMES), rows)
    hidden = unseen(found)
    shown = [row for row in found.rows if row.outcome != RIGHT] if every else hidden
    for row in shown:
        noticed = ", ".join(row.noticed_by) or "-"
        say(
            console,
            f"{row.outcome} {row.section}/{row.scene}/{row.name}, {maker(row)}; noticed by "
            f"{noticed}: {row.reason}",
        )
    say(console, f"{len(found.rows)} rows; of {len(hidden)} wrong ones only the reference knows")
