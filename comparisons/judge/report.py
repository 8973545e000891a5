"""A judgement as a report of one check, and on the console."""

from __future__ import annotations

from rich.console import Console

from ..checks.request import CheckRequest
from ..queries.environment import environment
from ..reports.run.outcome import Report
from ..reports.sections import Section, print_sections
from ..reports.text import STYLES, print_line
from ..reports.words import assignments, number
from .judge import Judgement

HARMLESS = 1e3
"""Growth up to which an error is not taken for that of a start."""

CHAOS = "late errors may be small initial errors that have grown."


def as_report(judgement: Judgement, command: str | None = None) -> Report:
    """Return a judgement as the report of one check, which a command repeats."""
    selection = CheckRequest((judgement.scene,), ids=(f"{judgement.scene}/{judgement.case}",))
    return Report(
        judgement.results,
        judgement.versions,
        planned=1,
        selection=selection,
        environment=environment(),
        command=command,
    )


def print_judgement(console: Console, judgement: Judgement, quiet: bool = False) -> None:
    """Print errors, tolerances and notes; or the last line alone."""
    if not quiet:
        print_sections(console, [judgement_section(judgement)])
    if judgement.tolerance:
        outcome = as_report(judgement)
        print_line(console, outcome.summary_line, STYLES[outcome.verdict])
    else:
        print_line(console, "nothing is judged without --tolerance, or --order and --step")


def judgement_section(judgement: Judgement) -> Section:
    """Return the largest error of each observable, and what was noticed."""
    changed = {**judgement.state} if judgement.case == "user" else {}
    start = f", from {assignments(changed)}" if changed else ""
    results = {result.quantity: result for result in judgement.results}
    rows = []
    for error in judgement.errors:
        result = results.get(error.quantity)
        name = f"{error.quantity} [{error.unit}]"
        compared = (error.value, error.reference, error.error, error.relative, error.time)
        rows.append((name, *compared, *([result.tolerance, result.verdict] if result else [])))
    heads = ["", "value", "reference", "largest error", "relative", "at t [s]"]
    growth = "errors are the method's or the model's." if judgement.growth <= HARMLESS else CHAOS
    return Section(
        f"{judgement.file} against {judgement.scene}/{judgement.case}{start}",
        [*heads, *(["tolerance", "verdict"] if results else [])],
        rows,
        [
            f"{judgement.judged} of {judgement.samples} samples judged, to t = "
            f"{number(judgement.until, 6)} s; an initial error grows by "
            f"a factor of {number(judgement.growth)} until then: {growth}",
            *(f"Note: {note}" for note in judgement.notes),
            *(
                f"{result.verdict}: {result.quantity}: {result.reason}"
                for result in judgement.results
                if result.verdict in ("error", "skipped")
            ),
        ],
        digits=4,
    )
