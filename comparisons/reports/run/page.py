"""The page that ``mbcheck check --html`` writes: one file, without scripts and without a network.

Everything in it that comes from outside (names, reasons, versions) is escaped by the template.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from datetime import datetime
from pathlib import Path

from ....reference.errors import UsageError
from ...checks.request import CheckRequest
from ...checks.verdict import FAILURES
from ..files import STDOUT, Destination
from ..html import render
from ..sections import Section
from .located import blocks
from .outcome import Report
from .results import ratio
from .sections import (
    closing_sections,
    failure_sections,
    origin,
    result_sections,
    run_badge,
    run_junit,
    run_sarif,
    run_summary,
)

SIGNS: Mapping[str, str] = {
    "pass": "\N{CHECK MARK}",
    "deviation": "\N{BALLOT X}",
    "error": "!",
    "known": "\N{ALMOST EQUAL TO}",
    "skipped": "\N{EN DASH}",
}
"""Marks of the verdicts, so that the page reads without colours."""

MOST_FIGURES = 24
"""Deviations that are drawn by default."""

GENERATOR = b'<meta name="generator" content="mbcheck">'
"""Mark of a page of mbcheck, which may be overwritten."""

INDEX = "index.html"


def page_file(name: str) -> Destination:
    """Return the page in a folder, which is made; refuse at once what cannot be written.

    Raises
    ------
    UsageError
        If the folder is a file, cannot be written, or holds a page of someone else's.
    """
    if name in ("", STDOUT):
        raise UsageError("--html needs the name of a folder")
    try:
        Path(name).mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        is_file = isinstance(error, FileExistsError | NotADirectoryError)
        reason = "it is no folder" if is_file else getattr(error, "strerror", None) or str(error)
        raise UsageError(f"--html: cannot write into {name!r}: {reason}") from None
    place = Destination("--html", os.path.join(name, INDEX))
    if place.path.is_file() and GENERATOR not in place.path.read_bytes()[:4096]:
        raise UsageError(
            f"--html: {place.name!r} exists and is no page of mbcheck; name another folder"
        )
    return place


def write_reports(report: Report, **files: Destination | None) -> None:
    """Write the reports of a run, each named by its format, one of `WRITERS`."""
    for name, place in files.items():
        if place is not None:
            place.write(WRITERS[name](report))


def check_page(
    report: Report, when: datetime | None = None, most_figures: int = MOST_FIGURES
) -> str:
    """Return the page of a run of checks.

    Parameters
    ----------
    report : Report
    when : datetime, optional
        When it ended; now by default.
    most_figures : int
        Failing checks that are drawn.
    """
    failed = sum(result.verdict in FAILURES for result in report.results)
    every = Section("Every result", lines=["Open a part to see its results."], anchor="results")
    sections = [
        Section("What was checked", ("", ""), facts(report, when), anchor="what"),
        Section(f"Deviations and errors ({failed})", anchor="failed"),
        *drawn(report, most_figures),
        *closing_sections(report),
        every,
        *result_sections(report, repeat=True),
    ]
    return render(
        "check.html",
        title=report.word,
        worst=report.verdict,
        summary=report.summary_line,
        interrupted=report.interrupted,
        sections=sections,
        signs=SIGNS,
    )


def facts(report: Report, when: datetime | None) -> list[tuple[str, str]]:
    """Return selection, time, versions and machine, by name."""
    seconds = {r.check_id: r.work["seconds"] for r in report.results if "seconds" in r.work}
    ended = when or datetime.now().astimezone()
    return [
        ("Checks", report.counts_line),
        ("Selection", selection(report.selection)),
        ("Ended", ended.strftime("%Y-%m-%d %H:%M %Z").strip()),
        ("Took", f"{sum(seconds.values()):.0f} s, all checks together"),
        ("Versions", origin(report) or f"python {sys.version.split()[0]}"),
    ]


def selection(asked: CheckRequest) -> str:
    """Return the selection of a run in words."""
    named = {key: getattr(asked, key) for key in ("scenes", "engines", "kinds", "methods", "ids")}
    parts = [f"{key} {', '.join(names)}" for key, names in named.items() if names]
    parts += [] if asked.profile == "default" else [f"profile {asked.profile}"]
    parts += [f"with --{name}" for name in ("full", "quick") if getattr(asked, name)]
    return "; ".join(parts) or "the default set of checks"


def drawn(report: Report, most: int) -> Iterator[Section]:
    """Yield all failures, with pictures of so many of those that have a series."""
    from . import figures

    failures = {block.title: block.failed for block in blocks(report.results)}
    count = 0
    for section in failure_sections(report, most=None):
        drawable = [result for result in failures.get(section.title, ()) if result.series]
        if drawable and count < most:
            count += 1
            try:
                figure = figures.deviation(max(drawable, key=ratio))
            except UsageError as error:
                yield replace(section, lines=[*section.lines, f"There is no picture: {error}."])
                continue
            yield replace(section, figures=[figure])
        else:
            yield section


WRITERS: Mapping[str, Callable[[Report], str]] = {
    "junit": run_junit,
    "sarif": run_sarif,
    "badge": run_badge,
    "markdown": run_summary,
    "html": check_page,
}
"""Functions that return the text of a report in each format."""
