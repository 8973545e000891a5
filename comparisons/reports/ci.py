"""What a CI service shows of a run: a Markdown summary, and GitHub's annotations."""

from __future__ import annotations

import html
import os
import re
import secrets
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..checks.verdict import Result
from .report import (
    SIGNS,
    counts_line,
    grouped,
    measured,
    plural,
    printable,
    ratio,
    rerun,
    skip_reasons,
    summary,
    summary_line,
    why_known,
    with_unit,
    worst,
)

if TYPE_CHECKING:
    from ..reports.outcome import Report

MOST_ROWS = 50
"""Rows of a table of the summary; GitHub refuses summaries of more than 1 MiB."""

MOST_ANNOTATIONS = 10
"""Of a kind; GitHub shows no more of one step."""

STEP_SUMMARY = "GITHUB_STEP_SUMMARY"
"""Environment variable that names the file that GitHub shows on the page of a run."""


def failing(results: Iterable[Result]) -> list[Result]:
    """Return errors, then deviations, each from the one farthest beyond its tolerance down."""
    chosen = [result for result in results if result.verdict in ("error", "deviation")]
    return sorted(chosen, key=lambda r: (r.verdict != "error", -ratio(r), r.id))


# Markdown


def markdown(outcome: Report, command: str = "mbcheck check", interrupted: bool = False) -> str:
    """Return the summary of a run: what failed first, then what is known, stale and skipped.

    Parameters
    ----------
    outcome : Report
    command : str
        What the commands that re-run one check start with.
    interrupted : bool
        The run was, so its results are not all there are.
    """
    results, run = outcome.results, outcome.run
    parts = [f"## mbcheck: {plain(summary_line(results, interrupted, run))}\n"]
    where = [*outcome.versions.items(), *run.environment.items()]
    told = ", ".join(f"{name} {text}" for name, text in where)
    parts.append(f"{plain(counts_line(results, run))}. {plain(told)}\n")
    bad = failing(results)
    if bad:
        parts.append("### Deviations and errors\n")
        parts.append(table(("Verdict", "Id", "Error", "Tolerance", "Why"), map(bad_row, bad)))
        parts.append(f"To repeat one alone: {code(f'{command} --id ID')}\n")
    known = [result for result in results if result.verdict == "known"]
    if known:
        groups = grouped(known, lambda r: (r.engine, why_known(r)))
        rows = ((engine, why, str(len(found))) for (engine, why), found in groups.items())
        parts.append("### Known deviations\n")
        parts.append(table(("Engine", "Why", "Results"), (map(plain, row) for row in rows)))
    if run.stale:
        parts.append(f"### Stale entries of {plain(run.known_file or '')}\n")
        stale = ((plain(u.entry.place), code(u.entry.id), plain(u.why)) for u in run.stale)
        parts.append(table(("Entry", "Id", "Why"), stale))
    skipped = skip_reasons(results)
    if skipped:
        cells = ((engine, reason, str(n)) for (engine, reason), n in skipped.items())
        parts.append("### Skipped\n")
        parts.append(table(("Engine", "Why", "Results"), (map(plain, row) for row in cells)))
    parts.append(verdicts(results))
    return "\n".join(parts)


def bad_row(result: Result) -> Sequence[str]:
    """Return the cells of a result that failed."""
    error, tolerance = (with_unit(x, result.unit) for x in (result.error, result.tolerance))
    return (
        result.verdict,
        code(result.id),
        plain(error),
        plain(tolerance),
        plain(result.reason),
    )


def verdicts(results: Sequence[Result]) -> str:
    """Return a table of scene and engine against kind: worst verdict, passed of judged."""
    ran = [result for result in results if result.kind != "-"]
    kinds = list(dict.fromkeys(result.kind for result in ran))
    rows = []
    for (scene, engine), members in grouped(ran, lambda r: (r.scene, r.engine)).items():
        cells = [verdict_cell([r for r in members if r.kind == kind]) for kind in kinds]
        rows.append([plain(scene), plain(engine), *cells])
    return table(("Scene", "Engine", *map(plain, kinds)), rows) if rows else ""


def verdict_cell(results: Sequence[Result]) -> str:
    """Return a sign, and how many of the results that were judged passed."""
    if not results:
        return "-"
    counts = summary(results)
    judged = counts["total"] - counts["skipped"]
    if not judged:
        return "skipped"
    text = f"{SIGNS[worst(results)]} {counts['pass']}/{judged}"
    return f"**{text}**" if counts["deviation"] or counts["error"] else text


def table(heads: Sequence[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table of cells that are Markdown; what is too long is cut, and says so."""
    lines = [list(row) for row in rows]
    shown = [list(heads), ["---"] * len(heads), *lines[:MOST_ROWS]]
    text = "".join(f"| {' | '.join(row)} |\n" for row in shown)
    left = len(lines) - MOST_ROWS
    if left > 0:
        text += f"\nand {plural(left, 'more row')}, see the JSON or JUnit document\n"
    return text


def plain(text: str) -> str:
    """Return text that Markdown shows as it is, in a cell too."""
    escaped = re.sub(r"([\\`*_\[\]|~#])", r"\\\1", html.escape(printable(text), quote=False))
    return escaped.replace("@", "@\N{ZERO WIDTH SPACE}")  # no one is to be notified


def code(text: str) -> str:
    """Return text as code, in a cell too; what would end it is replaced."""
    return "`" + printable(text).replace("`", "'").replace("|", "\\|") + "`"


def append_step_summary(text: str) -> str | None:
    """Append to the summary that GitHub shows, where it asks for one.

    Returns
    -------
    str or None
        Why it could not be written. What was found stands whether or not GitHub shows it.
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


def wanted() -> bool:
    """Return whether GitHub reads what is printed."""
    return os.environ.get("GITHUB_ACTIONS") == "true"


@contextmanager
def annotated(outcome: Report, command: str, asked: bool | None, err: bool) -> Iterator[None]:
    """Print annotations after what is printed meanwhile, which GitHub is told not to obey.

    Parameters
    ----------
    outcome : Report
    command : str
        What the commands that re-run one check start with.
    asked : bool or None
        Whether the user wants them; None leaves it to the environment.
    err : bool
        Print on standard error, as a document goes to standard output. GitHub reads both.
    """
    if not (wanted() if asked is None else asked):
        yield
        return
    token = secrets.token_hex(16)
    click.echo(f"::stop-commands::{token}", err=err)
    yield
    click.echo(f"::{token}::", err=err)
    for line in workflow_commands(outcome, command):
        click.echo(line, err=err)


def workflow_commands(outcome: Report, command: str = "mbcheck check") -> list[str]:
    """Return workflow commands: what failed, what is stale, and how many checks ran.

    There are no more of each kind than GitHub shows; the last one tells how many are left out.
    """
    results, run = outcome.results, outcome.run
    errors = [
        annotation(
            "error",
            "\n".join(filter(None, [measured(r), r.reason, rerun(r, command)])),
            title=f"{r.verdict}: {r.id}",
        )
        for r in failing(results)
    ]
    stale = [
        annotation(
            "error" if run.strict_known else "warning",
            f"{use.entry.place}, {use.entry.id}: {use.why}; remove it",
            file=run.known_file or "",
            line=str(use.entry.line or 1),
            title="stale known deviation",
        )
        for use in run.stale
    ]
    line = summary_line(results, run=run)
    reasons = [f"{n} x {engine}: {why}" for (engine, why), n in skip_reasons(results).items()]
    told = "\n".join([line, counts_line(results, run), *(f"skipped {text}" for text in reasons)])
    last = annotation("error" if outcome.exit_code == 2 else "notice", told, title="mbcheck")
    if run.strict_known:
        return [*limited("error", [*stale, *errors]), last]
    return [*limited("error", errors), *limited("warning", stale), last]


def limited(level: str, lines: Sequence[str]) -> list[str]:
    """Return as many annotations as GitHub shows of a kind."""
    if len(lines) <= MOST_ANNOTATIONS:
        return list(lines)
    kept = MOST_ANNOTATIONS - 1
    more = f"{len(lines) - kept} more; the summary and the log have all of them"
    return [*lines[:kept], annotation(level, more, title="mbcheck")]


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
