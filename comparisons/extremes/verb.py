"""The verb ``mbcheck extremes``."""

from __future__ import annotations

import click

from ..reports.files import Destination, refuse_conflicts
from ..terminal.program import (
    FAILED,
    INTERRUPTED,
    JOBS,
    JSON,
    complain,
    console,
    examples,
    into,
    json_text,
    several,
    to_stdout,
)

LIMIT = 240.0
"""What a check may take [s]."""


@click.command(
    epilog=examples(
        "mbcheck extremes speed_regulator --kind starts",
        "mbcheck extremes --json extremes.json --markdown extremes.md",
    ),
)
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@several("engine", "ENGINE", "Only this engine")
@several("kind", "KIND", "Only limits, parameters, starts, long or failures")
@click.option("--full", is_flag=True, help="Longer horizons and more extremes.")
@JOBS
@click.option("-v", "--verbose", is_flag=True, help="Print every result that is not right.")
@JSON
@into("markdown", "Write what breaks in each engine as Markdown to a file, or '-'.")
def extremes(
    scenes: tuple[str, ...],
    engines: tuple[str, ...],
    kinds: tuple[str, ...],
    full: bool,
    jobs: int,
    verbose: bool,
    json_file: Destination | None,
    markdown_file: Destination | None,
) -> int:
    """Push engines to where they break, and show who notices.

    These are the checks of `mbcheck check --extremes`. Each result is right, wrong though finite,
    or failed, and names who notices: the engine, the guard, a rule known before the run, a run with
    half the step, or only the reference. Exit code 0 whatever the results are, 1 if a check died.
    """
    from ..check.request import CheckRequest
    from ..check.verb import checked
    from ..checks.execution import Execution
    from ..engines.isolation import MEMORY
    from . import page

    refuse_conflicts(json_file, markdown_file)
    request = CheckRequest(scenes, engines, kinds, full=full, extremes=True)
    report = checked(request.plan(), Execution(jobs, False, LIMIT, MEMORY), bar=True)
    if json_file:
        json_file.write(json_text(report.as_json()))
    if markdown_file:
        markdown_file.write(page.markdown(report.results, full))
    if not to_stdout(json_file, markdown_file):
        page.show(console(), report.results, verbose)
    if report.run.interrupted:
        return complain("interrupted", INTERRUPTED)
    return FAILED if any(map(page.died, report.results)) else 0
