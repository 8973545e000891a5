"""The verb ``mbcheck extremes``."""

from __future__ import annotations

import click

from ..checks.execution import Execution
from ..reports.files import Destination, refuse_conflicts
from ..terminal.options import with_options_of
from ..terminal.program import (
    FAILED,
    INTERRUPTED,
    JSON,
    complain,
    console,
    examples,
    finished,
    into,
    json_text,
    several,
    to_stdout,
)


@click.command(
    epilog=examples(
        "mbcheck extremes speed_regulator --section starts",
        "mbcheck extremes --json extremes.json --markdown extremes.md --csv extremes.csv",
    ),
)
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@several("engine", "ENGINE", "Only this engine")
@several("section", "NAME", "Only limits, parameters, starts, long or failures")
@click.option("--full", is_flag=True, help="Longer horizons and more extremes.")
@with_options_of(Execution, without=("fail_fast", "time_limit", "memory_limit"))
@click.option("-v", "--verbose", is_flag=True, help="Print every row that is not right.")
@JSON
@into("markdown", "Write what only the reference notices as Markdown to a file, or '-'.")
@into("csv", "Write all rows as CSV to a file, or '-'.")
def extremes(
    scenes: tuple[str, ...],
    engines: tuple[str, ...],
    sections: tuple[str, ...],
    full: bool,
    jobs: int,
    verbose: bool,
    json_file: Destination | None,
    markdown_file: Destination | None,
    csv_file: Destination | None,
) -> int:
    """Push engines to where they break, and tell who notices.

    Each row is right, wrong though finite, or failed, and names who notices: the engine, the
    guard, a rule known before the run, a run with half the step, or only the reference. Exit
    code 0 whatever the rows say, 1 if a task died.
    """
    from . import pages, run

    refuse_conflicts(json_file, markdown_file, csv_file)
    result = run.Extremes.asked(scenes, engines, sections, full)
    ended = finished(result.work(jobs), "tasks")
    if json_file:
        json_file.write(json_text(result.as_json()))
    if markdown_file:
        markdown_file.write(pages.markdown(result))
    if csv_file:
        csv_file.write(pages.csv_text(result))
    if not to_stdout(json_file, markdown_file, csv_file):
        pages.show(console(), result, verbose)
    if not ended:
        return complain("interrupted", INTERRUPTED)
    return FAILED if result.lost else 0
