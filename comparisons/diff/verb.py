"""The verb ``mbcheck diff``."""

from __future__ import annotations

import click

from ..reports.files import Destination, refuse_conflicts
from ..terminal.program import JSON, MARKDOWN, console, examples, json_text, to_stdout


@click.command(
    epilog=examples(
        "mbcheck diff old.json new.json",
        "mbcheck diff old.json new.json --json diff.json --markdown diff.md",
    ),
)
@click.argument("old", metavar="OLD.json")
@click.argument("new", metavar="NEW.json")
@click.option("-v", "--verbose", is_flag=True, help="Print every change.")
@JSON
@MARKDOWN
def diff(
    old: str,
    new: str,
    json_file: Destination | None,
    markdown_file: Destination | None,
    verbose: bool,
) -> int:
    """Compare two runs of `mbcheck check --json`.

    New deviations and errors come first, then errors that grew beyond their noise, and results that
    are missing; improvements come last. Exit code 0 without a regression, 1 with one, 2 if there is
    nothing to compare.
    """
    refuse_conflicts(json_file, markdown_file)
    from ..reports.github import append_step_summary
    from . import report
    from .changes import compare, read

    result = compare(read(old), read(new))
    if json_file:
        json_file.write(json_text(result.as_json()))
    text = report.markdown(result)
    if markdown_file:
        markdown_file.write(text)
    append_step_summary(text)
    if not to_stdout(json_file, markdown_file):
        report.print_diff(console(), result, verbose)
    return result.exit_code
