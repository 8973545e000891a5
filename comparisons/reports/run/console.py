"""A run on the console: deviations first, then a matrix, then one line."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.text import Text

from ...checks.verdict import Result
from ..text import STYLES, print_line, print_matrix, print_table, print_wrapped
from ..words import plural, with_unit
from .located import located
from .outcome import Report
from .results import (
    FAILURES,
    SIGNS,
    against_tolerance,
    error_size,
    grouped,
    headline_errors,
    known_reasons,
    measured,
    method_of,
    pass_counts,
    ran,
    skip_reasons,
    worst,
)

FEW_METHODS = 4
"""So many methods are named beside a reason."""


def print_report(console: Console, outcome: Report, verbosity: int = 0) -> None:
    """Print what a reader needs first: deviations, then a matrix, then one summary line.

    Parameters
    ----------
    console : rich.console.Console
    outcome : Report
    verbosity : int
        -1 prints the summary line only, 1 adds every single result.
    """
    results, run = outcome.results, outcome.run
    if verbosity >= 0:
        if run.header:
            print_wrapped(console, run.header)
            console.print()
        for result in results:
            if result.verdict in FAILURES:
                print_failure(console, result, outcome.run.repeat(result.id))
        print_tracebacks(console, results, verbosity > 0)
        if verbosity > 0:
            print_results(console, results)
        if where := located(results):
            for line in ["Located:", *(f"  {line}" for line in where), ""]:
                print_line(console, line)
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


def print_failure(console: Console, result: Result, command: str) -> None:
    """Print one deviation or error, why, and how to run it again."""
    print_line(console, f"{result.verdict.upper()} {result.id}", STYLES[result.verdict])
    for line in filter(None, (measured(result), result.reason)):
        print_wrapped(console, line, indent="    ")
    print_line(console, f"    {command}", style="cyan")
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
    """Return a sign, and how many of the results that were judged passed."""
    verdict, (passed, count) = worst(results), pass_counts(results)
    if not count:
        return Text(verdict, STYLES[verdict])
    of = "" if passed == count else f"/{count}"
    return Text(f"{SIGNS[verdict]} {passed}{of}", STYLES[verdict])


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
