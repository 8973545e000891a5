"""What GitHub shows of a run: a summary on its page, and annotations."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import click

from ..words import printable
from .blocks import blocks
from .located import located
from .outcome import Report
from .results import skip_reasons

MOST_ANNOTATIONS = 10
"""Of a kind; GitHub shows no more of one step."""

STEP_SUMMARY = "GITHUB_STEP_SUMMARY"
"""Environment variable that names the file that GitHub shows on the page of a run."""


def append_step_summary(text: str) -> str | None:
    """Append to the summary that GitHub shows, where it asks for one.

    Returns
    -------
    str or None
        Why it could not be written. The results stand whether or not GitHub shows them.
    """
    name = os.environ.get(STEP_SUMMARY)
    if not name:
        return None
    try:
        with Path(name).open("a", encoding="utf-8") as file:
            file.write(text + "\n")
    except (OSError, ValueError) as error:
        return f"{STEP_SUMMARY}: cannot write {name!r}: {getattr(error, 'strerror', error)}"
    return None


# Annotations


@contextmanager
def annotated(
    commands: Callable[[], Sequence[str]], asked: bool | None, err: bool
) -> Iterator[None]:
    """Print annotations after what is printed meanwhile, which GitHub is told not to obey.

    Parameters
    ----------
    commands : callable
        Returns the workflow commands of the annotations, when the time has come.
    asked : bool or None
        Whether the user wants them; None leaves it to the environment.
    err : bool
        Print on standard error, as a document goes to standard output. GitHub reads both.
    """
    if not wants_annotations(asked):
        yield
        return
    token = secrets.token_hex(16)
    click.echo(f"::stop-commands::{token}", err=err)
    try:
        yield
    finally:
        click.echo(f"::{token}::", err=err)
    for line in commands():
        click.echo(line, err=err)


def wants_annotations(asked: bool | None) -> bool:
    """Return whether to print annotations: as asked, by default where GitHub runs."""
    return os.environ.get("GITHUB_ACTIONS") == "true" if asked is None else asked


def workflow_commands(outcome: Report) -> list[str]:
    """Return workflow commands: what failed, what is stale, and how many checks ran.

    There are no more of each kind than GitHub shows; the last one tells how many are left out.
    """
    results, run = outcome.results, outcome.run
    where = "\n".join(located(results))
    errors = [annotation("error", where, title="mbcheck: located")] if where else []
    errors += [
        annotation(
            "error",
            "\n".join(
                filter(None, [*b.quantities, b.why, b.others, outcome.run.repeat(b.worst.id)])
            ),
            title=f"{b.worst.verdict}: {b.worst.check_id}",
        )
        for b in blocks(results)
    ]
    stale = [
        annotation(
            "error" if run.strict_known else "warning",
            f"{use.entry.place}, {use.entry.id}: {use.why}; remove it",
            file=run.known_file or "",
            title="stale known deviation",
        )
        for use in run.stale
    ]
    skipped = [
        f"skipped {len(members)} x {engine}: {why}"
        for (engine, why), members in skip_reasons(results).items()
    ]
    lines = "\n".join([outcome.summary_line, outcome.counts_line, *skipped])
    last = annotation("error" if outcome.exit_code == 2 else "notice", lines, title="mbcheck")
    if run.strict_known:
        return [*limited("error", [*stale, *errors]), last]
    return [*limited("error", errors), *limited("warning", stale), last]


def limited(level: str, lines: Sequence[str]) -> list[str]:
    """Return as many annotations as GitHub shows of a kind."""
    if len(lines) <= MOST_ANNOTATIONS:
        return list(lines)
    room = MOST_ANNOTATIONS - 1
    more = f"{len(lines) - room} more; the summary and the log have all of them"
    return [*lines[:room], annotation(level, more, title="mbcheck")]


def annotation(level: str, message: str, **properties: str) -> str:
    """Return a workflow command of GitHub, escaped as its own toolkit does."""
    named = ",".join(f"{name}={in_property(text)}" for name, text in properties.items())
    lines = "\n".join(printable(line) for line in message.splitlines())
    return f"::{level} {named}::{in_message(lines)}"


def in_message(text: str) -> str:
    """Return text as the message of a workflow command."""
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def in_property(text: str) -> str:
    """Return text as a property of a workflow command."""
    return in_message(printable(text)).replace(":", "%3A").replace(",", "%2C")
