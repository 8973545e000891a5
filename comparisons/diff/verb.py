"""The verb ``mbcheck diff``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import click

from ..documents.fields import OptionMark
from ..reports.files import Destination, refuse_conflicts
from ..terminal.options import with_options_of
from ..terminal.program import JSON, MARKDOWN, console, examples, json_text, to_stdout


@dataclass(frozen=True)
class DiffRequest:
    """Two documents of `mbcheck check`, and the length of the report.

    Attributes
    ----------
    old, new : str
        Documents to compare.
    verbose : bool
        Print every change.
    """

    old: Annotated[str, OptionMark("OLD.json", flags=())]
    new: Annotated[str, OptionMark("NEW.json", flags=())]
    verbose: Annotated[bool, OptionMark(flags=("-v", "--verbose"))] = False


@click.command(
    epilog=examples(
        "mbcheck diff old.json new.json",
        "mbcheck diff old.json new.json --json diff.json --markdown diff.md",
    ),
)
@with_options_of(DiffRequest)
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
