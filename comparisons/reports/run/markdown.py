"""A run as Markdown: what a CI service shows of it, and a table of its methods."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ...checks.verdict import Result
from ..text import Rows, markdown_table
from ..words import Markdown, code, number, plain, plural, with_unit
from .blocks import Block, blocks
from .located import located
from .outcome import Report
from .results import (
    FAILURES,
    error_size,
    grouped,
    headline_errors,
    known_reasons,
    method_of,
    pass_counts,
    ran,
    ratio,
    skip_reasons,
    summary,
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
    """Return how many results passed, or of how many deviate, fail or are known."""
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


# Methods


def method_table(results: Sequence[Result]) -> str:
    """Return a Markdown table with one row per scene, engine and method.

    The measured error is the largest of a trajectory's first observable; columns named by
    a kind hold the largest error / tolerance of its checks. A row without trajectory, such
    as that of a model, shows the check that is nearest to its tolerance.
    """
    ordered = in_order([result for result in results if result.verdict != "skipped"])
    kinds = list(dict.fromkeys(r.kind for r in results if r.verdict != "skipped"))
    heads = ["Scene", "Engine", "Method", "Measured", "Error", "Tolerance", *kinds, "Verdict"]
    rows = []
    for (scene,), of_scene in grouped(ordered, lambda r: (r.scene,)).items():
        quantity, _ = headline_errors(of_scene)
        for (engine, how), members in grouped(of_scene, lambda r: (r.engine, method_of(r))).items():
            ratios = [ratio_cell([r for r in members if r.kind == kind]) for kind in kinds]
            method = f"(model {how})" if members[0].method is None else how
            rows.append(
                [scene, engine, method, *headline(members, quantity), *ratios, outcome(members)]
            )
    return markdown_table(heads, rows) + "\n"


def in_order(results: Sequence[Result]) -> list[Result]:
    """Return results with scenes, and then engines, together, in the order of appearance."""
    scenes = list(dict.fromkeys(result.scene for result in results))
    engines = list(dict.fromkeys(result.engine for result in results))
    return sorted(results, key=lambda r: (scenes.index(r.scene), engines.index(r.engine)))


def headline(results: Sequence[Result], quantity: str | None) -> list[str]:
    """Return the name, error and tolerance of the result that stands for a method."""
    _, errors = headline_errors([result for result in results if result.quantity == quantity])
    example = max(errors or results, key=error_size if errors else ratio)
    what = example.quantity if errors else f"{example.kind}: {example.quantity}"
    return [what, *(with_unit(x, example.unit) for x in (example.error, example.tolerance))]


def ratio_cell(results: Sequence[Result]) -> str:
    """Return the largest error / tolerance of results, bold where it is too large."""
    if not results:
        return ""
    verdict = worst(results)
    if verdict == "error":
        return bold("error")
    text = number(max(map(ratio, results)), digits=2)
    return bold(text) if verdict == "deviation" else text


def outcome(results: Sequence[Result]) -> str:
    """Return how many results of a row passed, and in words what the others did."""
    counts, (passed, count) = summary(results), pass_counts(results)
    parts: Iterable[str] = [
        f"{counts[name]} known" if name == "known" else bold(plural(counts[name], name))
        for name in ("error", "deviation", "known")
        if counts[name]
    ]
    return Markdown(
        ", ".join([f"{passed} of {count} pass", *parts]) if parts else f"pass ({count})"
    )
