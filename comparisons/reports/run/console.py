"""A run on the console: where it is wrong first, then what failed, a matrix, and one line."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.text import Text

from ...checks.verdict import Result
from ..text import STYLES, print_line, print_matrix, print_rows, print_table, print_wrapped
from ..words import plural, with_unit
from .blocks import HEADS, MOST, blocks
from .located import located
from .outcome import Report
from .results import (
    against_tolerance,
    error_size,
    grouped,
    headline_errors,
    known_reasons,
    method_of,
    ran,
    skip_reasons,
    tally,
    worst,
)

FEW_METHODS = 4
"""So many methods are named beside a reason."""


def print_report(console: Console, outcome: Report, verbosity: int = 0) -> None:
    """Print what a reader needs first: where an engine is wrong, then what failed, then the rest.

    Parameters
    ----------
    console : rich.console.Console
    outcome : Report
    verbosity : int
        -1 prints the summary line only, 1 adds all that failed and every single result.
    """
    results, run = outcome.results, outcome.run
    if verbosity >= 0:
        if run.header:
            print_wrapped(console, run.header)
            console.print()
        if where := located(results):
            for line in ["Located:", *(f"  {line}" for line in where), ""]:
                print_line(console, line)
        print_blocks(console, outcome, all_of_them=verbosity > 0)
        print_tracebacks(console, results, verbosity > 0)
        if verbosity > 0:
            print_results(console, results)
        cells = grouped(ran(results), lambda r: (r.scene, r.engine, r.kind))
        print_matrix(console, {key: verdict_cell(members) for key, members in cells.items()})
        print_accuracy(console, results)
        for verdict, reasons in (
            ("known", known_reasons(results)),
            ("skipped", skip_reasons(results)),
        ):
            print_reasons(console, verdict, reasons)
        print_wrapped(
            console, ", ".join(f"{name} {text}" for name, text in outcome.versions.items())
        )
        print_line(console, outcome.counts_line)
    for use in run.stale:
        print_line(
            console, run.stale_line(use), STYLES["deviation" if run.strict_known else "known"]
        )
    print_line(console, outcome.summary_line, STYLES[outcome.verdict])


def print_blocks(console: Console, outcome: Report, all_of_them: bool) -> None:
    """Print the checks that failed, each with its quantities, why, and how to run it again."""
    failures = blocks(outcome.results)
    first = failures if all_of_them else failures[:MOST]
    for block in first:
        print_line(console, block.title, STYLES[block.worst.verdict])
        if block.rows:
            print_rows(console, HEADS, block.rows)
        for line in (block.why, block.others):
            print_wrapped(console, line, indent="    ")
        print_line(console, f"    {outcome.run.repeat(block.worst.id)}", style="cyan")
        console.print()
    if left := failures[len(first) :]:
        print_line(
            console, f"and {plural(len(left), 'more check')} that fail otherwise: -v shows them"
        )
        console.print()


def print_tracebacks(console: Console, results: Sequence[Result], whole: bool) -> None:
    """Print where engines raised, each place once, or how to see it."""
    raised = grouped((r for r in results if r.traceback), lambda r: (r.traceback or "",))
    if raised and not whole:
        them = "them" if len(raised) > 1 else "it"
        print_line(console, f"{plural(len(raised), 'traceback')} of engines: -v shows {them}")
        console.print()
    for (traceback,), members in raised.items() if whole else ():
        others = f" and {len(members) - 1} more" if members[1:] else ""
        print_line(console, f"TRACEBACK {members[0].id}{others}", STYLES["error"])
        for line in traceback.splitlines():
            print_line(console, f"    {line}")
        console.print()


def print_results(console: Console, results: Sequence[Result]) -> None:
    """Print every result as a line of a table per scene, case, kind and engine."""
    groups = grouped(results, lambda r: (r.source, r.scene, r.case, r.kind, r.engine))
    for key, members in groups.items():
        print_line(console, "/".join(key), style="bold")
        rows = [
            (
                Text(result.verdict.replace("pass", "ok"), STYLES[result.verdict]),
                method_of(result),
                result.quantity,
                against_tolerance(result),
            )
            for result in members
        ]
        print_table(console, ("verdict", "method", "quantity", "error, tolerance"), rows)


def verdict_cell(results: Sequence[Result]) -> Text:
    """Return what became of results, in the style of the worst."""
    return Text(tally(results), STYLES[worst(results)])


def print_accuracy(console: Console, results: Sequence[Result]) -> None:
    """Print the most and the least accurate method of each scene and engine."""
    lines = []
    for (scene,), of_scene in grouped(results, lambda r: (r.scene,)).items():
        quantity, errors = headline_errors(of_scene)
        for (engine,), members in grouped(errors, lambda r: (r.engine,)).items():
            methods = grouped(members, lambda r: (method_of(r),)).values()
            ranked = sorted((max(group, key=error_size) for group in methods), key=error_size)
            ends = dict.fromkeys(
                f"{with_unit(r.error, r.unit)} ({method_of(r)})" for r in (ranked[0], ranked[-1])
            )
            lines.append(f"{scene} {engine}: error of {quantity} {' to '.join(ends)}")
    for line in lines:
        print_wrapped(console, line)
    if lines:
        console.print()


def print_reasons(
    console: Console, verdict: str, reasons: dict[tuple[str, ...], list[Result]]
) -> None:
    """Print the reasons of a verdict, each once, with the number of checks it holds for."""
    if not reasons:
        return
    print_line(console, f"{verdict} ({sum(map(len, reasons.values()))}):", style=STYLES[verdict])
    for (engine, reason), members in reasons.items():
        methods = list(dict.fromkeys(method_of(r) for r in members))
        names = ", ".join([*methods[:FEW_METHODS], *(["..."] if methods[FEW_METHODS:] else [])])
        line = f"{len(members)} x {engine} {names}: {reason or 'no reason given'}"
        print_wrapped(console, line, indent="  ")
    console.print()
