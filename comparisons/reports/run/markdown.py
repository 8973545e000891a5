"""A run as Markdown: what a CI service shows of it."""

from __future__ import annotations

from collections.abc import Sequence

from ...checks.verdict import Result
from ..text import Rows, markdown_table
from ..words import Markdown, code, plain, plural, with_unit
from .blocks import Block, blocks
from .located import located
from .outcome import Report
from .results import (
    FAILURES,
    grouped,
    known_reasons,
    ran,
    skip_reasons,
    tally,
    worst,
)

MOST_ROWS = 50
"""Rows of a table of the summary; GitHub refuses summaries of more than 1 MiB."""

Reasons = dict[tuple[str, ...], list[Result]]


def run_summary(outcome: Report) -> str:
    """Return the summary of a run: what failed first, then what is known, stale and skipped."""
    results, run = outcome.results, outcome.run
    origin = ", ".join(
        f"{name} {text}" for name, text in [*outcome.versions.items(), *run.environment.items()]
    )
    parts = [
        f"## mbcheck: {plain(outcome.summary_line)}\n",
        f"{plain(outcome.counts_line)}. {plain(origin)}\n",
    ]
    parts += [f"{plain(run.header)}\n"] if run.header else []
    if where := located(results):
        parts.append("### Located\n")
        parts += [
            f"{'  ' * (len(line) - len(line.lstrip()))}- {plain(line.strip())}" for line in where
        ]
        parts.append("")
    if failed := blocks(results):
        parts.append("### Deviations and errors\n")
        parts.append(short_table(("Verdict", "Check", "Worst", "Why"), map(failure_row, failed)))
        parts.append(f"To repeat one alone: {code(f'{run.check_command} --id ID')}\n")
    parts += reasons_table("Known deviations", known_reasons(results))
    if run.stale:
        stale = ((use.entry.place, code(use.entry.id), use.why) for use in run.stale)
        parts.append(f"### Stale entries of {plain(run.known_file or '')}\n")
        parts.append(short_table(("Entry", "Id", "Why"), stale))
    parts += reasons_table("Skipped", skip_reasons(results))
    return "\n".join([*parts, matrix(results)])


def failure_row(block: Block) -> Sequence[str]:
    """Return the cells of a check that failed."""
    worst, count = block.worst, len(block.failed)
    of = f" ({count} of {block.count})" if block.count > 1 else ""
    why = "; ".join(filter(None, (block.why, block.others)))
    size = f"{with_unit(worst.error, worst.unit)} > {with_unit(worst.tolerance, worst.unit)}"
    size = size if worst.error is not None else ""
    return f"{worst.verdict}{of}", code(worst.id), size, why


def reasons_table(title: str, reasons: Reasons) -> list[str]:
    """Return a titled table of how many results have which reason; nothing of none."""
    rows = [(engine, why, str(len(same))) for (engine, why), same in reasons.items()]
    return [f"### {title}\n", short_table(("Engine", "Why", "Results"), rows)] if rows else []


def matrix(results: Sequence[Result]) -> str:
    """Return a table of scene and engine against kind: how many results passed, or fail."""
    cells = grouped(ran(results), lambda r: (r.scene, r.engine, r.kind))
    kinds = dict.fromkeys(kind for _, _, kind in cells)
    rows = [
        [*pair, *(verdict_cell(cells.get((*pair, kind), [])) for kind in kinds)]
        for pair in dict.fromkeys((scene, engine) for scene, engine, _ in cells)
    ]
    return short_table(("Scene", "Engine", *map(plain, kinds)), rows) if rows else ""


def verdict_cell(results: Sequence[Result]) -> str:
    """Return the number of results that passed, or that deviate, fail or are known."""
    if not results:
        return "-"
    failed = worst(results) in FAILURES
    return bold(tally(results)) if failed else tally(results)


def bold(text: str) -> Markdown:
    """Return text in bold."""
    return Markdown(f"**{text}**")


def short_table(heads: Sequence[str], rows: Rows) -> str:
    """Return a table of texts from outside; what is too long is cut, and says so."""
    lines = [[x if isinstance(x, Markdown) else plain(str(x)) for x in row] for row in rows]
    text = markdown_table(heads, lines[:MOST_ROWS]) + "\n"
    left = len(lines) - MOST_ROWS
    if left > 0:
        text += f"\nand {plural(left, 'more row')}, see the JSON or JUnit document\n"
    return text
