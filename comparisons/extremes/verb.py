"""The verb ``mbcheck extremes``."""

from __future__ import annotations

from typing import Any

import click

from ..checks.request import CheckRequest, Execution
from ..reports.files import Destination, refuse_conflicts
from ..terminal.options import with_options_of
from ..terminal.program import (
    FAILED,
    INTERRUPTED,
    JSON,
    complain,
    console,
    examples,
    into,
    json_text,
    to_stdout,
)

LIMIT = 240.0
"""Time limit of a check [s]."""


@click.command(
    epilog=examples(
        "mbcheck extremes speed_regulator --kind starts",
        "mbcheck extremes --json extremes.json --markdown extremes.md",
    ),
)
@with_options_of(CheckRequest, Execution, only=("scenes", "engines", "kinds", "full", "jobs"))
@click.option("-v", "--verbose", is_flag=True, help="Print every wrong result.")
@JSON
@into("markdown", "Write what breaks in each engine as Markdown to a file, or '-'.")
def extremes(
    verbose: bool,
    json_file: Destination | None,
    markdown_file: Destination | None,
    **asked: Any,
) -> int:
    """Push engines to where they break, and show who notices.

    These are the checks of `mbcheck check --extremes`. Each result is right, wrong though finite,
    or failed, and names who notices: the engine, the guard, a rule known before the run, a run with
    half the step, or only the reference. Exit code 0 whatever the results are, 1 if a check died.
    """
    from ..check.request import CheckRun, plan_checks
    from ..check.verb import checked
    from ..engines.isolation import MEMORY
    from . import page

    refuse_conflicts(json_file, markdown_file)
    run = CheckRun(**asked, extremes=True, time_limit=LIMIT, memory_limit=MEMORY)
    report = checked(plan_checks(run), run, bar=True)
    if json_file:
        json_file.write(json_text(report.as_json()))
    if markdown_file:
        markdown_file.write(page.markdown(report.results, run.full))
    if not to_stdout(json_file, markdown_file):
        page.show(console(), report.results, verbose)
    if report.interrupted:
        return complain("interrupted", INTERRUPTED)
    return FAILED if any(map(page.died, report.results)) else 0
