"""A judgement as a report of one check, and on the console."""

from __future__ import annotations

from rich.console import Console

from ..checks.request import CheckRequest
from ..queries.environment import environment
from ..reports.run.outcome import Report, Run
from ..reports.text import STYLES, print_line, print_table, print_wrapped
from ..reports.words import assignments, number
from .judge import Judgement

HARMLESS = 1e3
"""Growth up to which an error is not taken for that of a start."""

CHAOS = "what looks like a fault late in the run may be a small error that has grown."


def as_report(judgement: Judgement, command: str | None = None) -> Report:
    """Return a judgement as the report of one check, which a command repeats."""
    selection = CheckRequest((judgement.scene,), ids=(f"{judgement.scene}/{judgement.case}",))
    run = Run(planned=1, selection=selection, environment=environment(), command=command)
    return Report(judgement.results, judgement.versions, run)


def print_judgement(console: Console, judgement: Judgement, quiet: bool = False) -> None:
    """Print errors, what they are held against, and what was noticed; or the last line alone."""
    if not quiet:
        print_errors(console, judgement)
    if judgement.tolerance:
        outcome = as_report(judgement)
        print_line(console, outcome.summary_line, STYLES[outcome.verdict])
    else:
        print_line(console, "nothing is judged without --tolerance, or --order and --step")


def print_errors(console: Console, judgement: Judgement) -> None:
    """Print errors, what they are held against, and what was noticed."""
    changed = {**judgement.state} if judgement.case == "user" else {}
    start = f", from {assignments(changed)}" if changed else ""
    print_wrapped(console, f"{judgement.file} against {judgement.scene}/{judgement.case}{start}")
    by_quantity = {result.quantity: result for result in judgement.results}
    heads = ["", "largest error", "relative", "at t [s]"]
    lines: list[list[object]] = []
    for error in judgement.errors:
        line: list[object] = [f"{error.quantity} [{error.unit}]", error.error, error.relative]
        line.append(error.time)
        if judgement.tolerance:
            result = by_quantity[error.quantity]
            line = [result.verdict, *line[:2], result.tolerance, *line[2:]]
        else:
            line += [error.value, error.reference]
        lines.append(line)
    if judgement.tolerance:
        heads = ["verdict", *heads[:2], "tolerance", *heads[2:]]
    else:
        heads += ["value", "reference"]
    print_table(console, heads, lines, digits=4)
    print_wrapped(
        console,
        f"{judgement.judged} of {judgement.samples} samples judged, to t = "
        f"{number(judgement.until, 6)} s; an initial error grows by {number(judgement.growth)} "
        "until then: "
        + ("errors are the method's or the model's." if judgement.growth <= HARMLESS else CHAOS),
    )
    for note in judgement.notes:
        print_wrapped(console, f"Note: {note}")
    for result in judgement.results:
        if result.verdict in ("error", "skipped"):
            print_wrapped(console, f"{result.verdict}: {result.quantity}: {result.reason}")
