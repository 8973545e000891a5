"""The extremes table as Markdown, and as lines for the console."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import groupby

from rich.console import Console

from ..reports.console import print_line, print_wrapped
from ..reports.table import markdown_table, print_table
from ..reports.words import exact, number
from .failures import HARMLESS, NOT_PROVOKED
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
            lines += [f"## {section}", "", f"{ABOUT[section]}.", "", table(rows)]
        if rows and section == "failures":
            harmless = [row.name for row in rows if row.outcome == RIGHT and row.name in HARMLESS]
            lines += [f"Provoked, and harmless here: {', '.join(harmless) or 'none'}.", ""]
            lines += ["Known of these engines, and not provoked:", ""]
            lines += [f"* {mode}: {why}" for mode, why in NOT_PROVOKED] + [""]
    return "\n".join(lines).rstrip() + "\n"


def table(rows: Sequence[Row]) -> str:
    """Return rows as a Markdown table; what engines and methods have in common is one line."""
    lines = []
    for _, same in groupby(rows, alike):
        group = list(same)
        first = group[0]
        who = "; ".join(dict.fromkeys(maker(row) for row in group))
        lines.append((
            first.scene, first.name, changes(first.changed), who, first.outcome,
            ", ".join(first.noticed_by), reason(group),
        ))  # fmt: skip
    return markdown_table(HEADS, lines)


def alike(row: Row) -> tuple[object, ...]:
    """Return what rows of one line have in common; each limit has its own numbers."""
    shared = row.scene, row.name, changes(row.changed), row.outcome, row.noticed_by, row.engine
    return (*shared, row.reason) if row.section == "limits" else shared


def maker(row: Row) -> str:
    """Return engine, model, method and step in words."""
    step = "" if row.step is None else f", h = {number(row.step)} s"
    return " ".join(filter(None, [row.engine, row.model, row.method])) + step


def changes(changed: Mapping[str, float | str]) -> str:
    """Return what provokes a row in words."""
    return ", ".join(
        f"{name}={exact(value) if isinstance(value, float | int) else value}"
        for name, value in changed.items()
    )


def reason(group: Sequence[Row]) -> str:
    """Return the reason of the worst of some rows."""
    worst = max(group, key=lambda row: -1.0 if row.error is None else row.error)
    return worst.reason


def unseen(found: Extremes) -> list[Row]:
    """Return the rows that are wrong, and that only the reference notices."""
    return [row for row in found.rows if row.outcome == WRONG and row.noticed_by == (REFERENCE,)]


def show(console: Console, found: Extremes, every: bool) -> None:
    """Print how many rows came out how, and what only the reference notices, or all that is off."""
    counts = Counter((row.section, row.outcome) for row in found.rows)
    sections = [name for name in SECTIONS if any(key[0] == name for key in counts)]
    rows = [(name, *(counts[name, outcome] for outcome in OUTCOMES)) for name in sections]
    print_table(console, ("section", *OUTCOMES), rows)
    hidden = unseen(found)
    for row in [row for row in found.rows if row.outcome != RIGHT] if every else hidden:
        noticed = ", ".join(row.noticed_by) or "-"
        print_wrapped(
            console,
            f"{row.outcome} {row.section}/{row.scene}/{row.name}, {maker(row)}; noticed by "
            f"{noticed}: {row.reason}",
        )
    words = f"{len(found.rows)} rows; of {len(hidden)} wrong ones only the reference knows"
    print_line(console, words)
