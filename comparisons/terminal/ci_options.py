"""Options of ``mbcheck check`` for those who run it in CI; docs/ci.md is their page."""

from __future__ import annotations

import os

import click

from ...reference.errors import UsageError
from ..reports.files import Destination
from .program import destination


def new_file(
    context: click.Context, option: click.Parameter, name: str | None
) -> Destination | None:
    """Return where a document goes that replaces nothing.

    Raises
    ------
    UsageError
        If there is a file of that name, or it cannot be written.
    """
    if name is not None and os.path.lexists(name):
        raise UsageError(f"{option.opts[0]}: {name!r} is there already: give another name")
    return destination(context, option, name)


KNOWN = click.option(
    "--known",
    metavar="FILE",
    help="TOML file of deviations that are known, and do not fail; see docs/ci.md.",
)
STRICT_KNOWN = click.option(
    "--strict-known", is_flag=True, help="Fail if an entry of --known is stale."
)
WRITE_KNOWN = click.option(
    "--write-known",
    "draft_file",
    callback=new_file,
    metavar="FILE",
    help="Write a new file for --known with all that fails now; then give each its reason.",
)
ANNOTATIONS = click.option(
    "--annotations/--no-annotations",
    default=None,
    help="Print annotations for GitHub; by default where GITHUB_ACTIONS is true.",
)
