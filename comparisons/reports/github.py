"""Reports for GitHub: a summary on the page of a run, and annotations."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import click

from .item import LEVELS, Level, ReportItem
from .words import printable

MOST_ANNOTATIONS = 10
"""Annotations of one level; GitHub shows no more of one step."""

STEP_SUMMARY = "GITHUB_STEP_SUMMARY"
"""Environment variable that names the file that GitHub shows on the page of a run."""


def append_step_summary(text: str) -> None:
    """Append to the summary that GitHub shows, if it names a file; warn if that fails."""
    name = os.environ.get(STEP_SUMMARY)
    try:
        if name:
            with Path(name).open("a", encoding="utf-8") as file:
                file.write(text + "\n")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", error)
        click.echo(f"Warning: {STEP_SUMMARY}: cannot write {name!r}: {reason}", err=True)


@contextmanager
def annotated(
    items: Callable[[], Sequence[ReportItem]], wanted: bool | None, err: bool
) -> Iterator[None]:
    """Print annotations after the text of the context, in which GitHub runs no commands.

    Parameters
    ----------
    items : callable
        Returns the items to annotate; called at the end.
    wanted : bool or None
        True if the user wants them; None: only on GitHub.
    err : bool
        Print on standard error, as a document goes to standard output. GitHub reads both.
    """
    on_github = os.environ.get("GITHUB_ACTIONS") == "true"
    if not (on_github if wanted is None else wanted):
        yield
        return
    token = secrets.token_hex(16)
    click.echo(f"::stop-commands::{token}", err=err)
    try:
        yield
    finally:
        click.echo(f"::{token}::", err=err)
    for line in workflow_commands(items()):
        click.echo(line, err=err)


def workflow_commands(items: Sequence[ReportItem]) -> list[str]:
    """Return workflow commands of GitHub, no more of each level than it shows.

    The last one of a level counts those that are left out.
    """
    lines = []
    for level in LEVELS:
        same = [annotation(item, level) for item in items if item.severity == level]
        if len(same) > MOST_ANNOTATIONS:
            room = MOST_ANNOTATIONS - 1
            more = f"{len(same) - room} more; the summary and the log have all of them"
            last = ReportItem("", "", "", "failure", level, more, title="mbcheck")
            same = [*same[:room], annotation(last, level)]
        lines += same
    return lines


def annotation(item: ReportItem, level: Level) -> str:
    """Return a workflow command of GitHub, escaped as its own toolkit does."""
    file = {"file": item.file, "line": str(item.line or 1)} if item.file else {}
    properties = {**file, "title": item.title or f"mbcheck: {item.rule}"}
    named = ",".join(
        f"{name}={escaped(printable(text)).replace(':', '%3A').replace(',', '%2C')}"
        for name, text in properties.items()
    )
    lines = "\n".join((item.message, *item.details)).splitlines()
    message = escaped("\n".join(printable(line) for line in lines if line))
    return f"::{'notice' if level == 'note' else level} {named}::{message}"


def escaped(text: str) -> str:
    """Return text as the message of a workflow command."""
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")
