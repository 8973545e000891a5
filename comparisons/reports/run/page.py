"""The page that ``mbcheck check --html`` writes: one file, without scripts and without a network.

Everything in it that comes from outside (names, reasons, versions) is escaped by the template.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ....reference.errors import UsageError
from ...checks.request import CheckRequest
from ...checks.verdict import Result
from ..files import STDOUT, Destination
from ..html import render
from ..words import number, plural, with_unit
from .located import located
from .outcome import Report
from .results import (
    FAILURES,
    grouped,
    known_reasons,
    method_of,
    pass_counts,
    ran,
    ratio,
    skip_reasons,
    summary,
    tally,
    worst,
)

if TYPE_CHECKING:
    from .figures import Figure

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
"""What tells a page of ours, which may be overwritten, from another."""

INDEX = "index.html"


# Where it goes


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
            f"--html: {place.name!r} is there already, and no page of mbcheck; name another folder"
        )
    return place


# What is on it


Content = dict[str, Any]
"""What the template shows of one thing, by the names that it uses."""


def check_page(
    outcome: Report, when: datetime | None = None, most_figures: int = MOST_FIGURES
) -> str:
    """Return the page of a run of checks.

    Parameters
    ----------
    outcome : Report
    when : datetime, optional
        When it ended; now by default.
    most_figures : int
        Deviations that are drawn: those farthest beyond their tolerance.
    """
    results, run = outcome.results, outcome.run
    artist = Artist(most_figures)
    scenes = list(scene_sections(results))
    failures = list(failed_checks(outcome, artist))
    known, skipped = known_reasons(results), skip_reasons(results)
    failed = sum(result.verdict in FAILURES for result in results)
    headings = [
        ("what", "What was checked", True),
        ("verdicts", "Verdicts", True),
        ("failed", f"Deviations and errors ({failed})", True),
        ("known", "Known deviations", bool(known or run.stale)),
        ("skipped", "Skipped", bool(skipped)),
        *((scene["anchor"], scene["name"], True) for scene in scenes),
    ]
    return render(
        "check.html",
        title=outcome.word,
        worst=outcome.verdict,
        summary=outcome.summary_line,
        interrupted=run.interrupted,
        sections=[{"anchor": a, "title": t} for a, t, wanted in headings if wanted],
        facts=facts(outcome, when or datetime.now().astimezone()),
        signs=SIGNS,
        kinds=list(dict.fromkeys(result.kind for result in ran(results))),
        failures=failures,
        located=located(results),
        no_pictures=artist.excuse if failures else "",
        undrawn=artist.undrawn(),
        known=[(engine, why, len(same)) for (engine, why), same in known.items()],
        known_file=run.known_file,
        stale=[(use.entry.place, use.entry.id, use.why) for use in run.stale],
        skipped=[(engine, why, len(same)) for (engine, why), same in skipped.items()],
        scenes=scenes,
        amount=partial(with_unit, missing=""),
        share=share,
        method_of=method_of,
        repeat=run.repeat,
    )


def facts(outcome: Report, when: datetime) -> list[tuple[str, str]]:
    """Return what was checked, when, with what, and on what machine."""
    run, versions = outcome.run, outcome.versions
    seconds = {r.check_id: r.work["seconds"] for r in outcome.results if "seconds" in r.work}
    machine = ", ".join(f"{name} {text}" for name, text in run.environment.items())
    return [
        ("Checks", outcome.counts_line),
        ("Selection", selection(run.selection)),
        *([("Reference", run.header)] if run.header else []),
        ("When", when.strftime("%Y-%m-%d %H:%M %Z").strip()),
        ("Took", f"{sum(seconds.values()):.0f} s, all checks together"),
        ("Versions", ", ".join(f"{name} {text}" for name, text in versions.items())),
        ("Machine", machine or f"python {sys.version.split()[0]}"),
    ]


def selection(asked: CheckRequest) -> str:
    """Return in words what a run was restricted to."""
    named = {key: getattr(asked, key) for key in ("scenes", "engines", "kinds", "methods", "ids")}
    parts = [f"{key} {', '.join(names)}" for key, names in named.items() if names]
    parts += [] if asked.profile == "default" else [f"profile {asked.profile}"]
    parts += [f"with --{name}" for name in ("full", "quick") if getattr(asked, name)]
    return "; ".join(parts) or "everything that is checked by default"


def share(result: Result) -> str:
    """Return error / tolerance of a result; empty if it has none."""
    return "" if result.error is None or result.tolerance is None else number(ratio(result))


def failed_checks(outcome: Report, artist: Artist) -> Iterator[Content]:
    """Yield what failed by its check: errors first, then from the farthest off down."""
    failed = (result for result in outcome.results if result.verdict in FAILURES)
    groups = grouped(failed, lambda r: (r.check_id,)).values()

    def severity(members: Sequence[Result]) -> tuple[bool, float, str]:
        return worst(members) != "error", -max(map(ratio, members)), members[0].check_id

    for i, members in enumerate(sorted(groups, key=severity)):
        by_reason = grouped(members, lambda r: (r.reason,))
        yield {
            "anchor": f"failure-{i}",
            "name": members[0].check_id,
            "verdict": worst(members),
            "measured": [result for result in members if result.error is not None],
            "reasons": [([r.quantity for r in same], why) for (why,), same in by_reason.items()],
            "command": outcome.run.repeat(max(members, key=ratio).id),
            "figures": list(artist.failure(members)),
        }


def scene_sections(results: Sequence[Result]) -> Iterator[Content]:
    """Yield the results by scene, and of each by engine and kind."""
    for i, ((scene,), members) in enumerate(grouped(ran(results), lambda r: (r.scene,)).items()):
        groups = grouped(members, lambda r: (r.engine, r.kind))
        yield {
            "anchor": f"scene-{i}",
            "name": scene,
            "parts": {key: part(f"scene-{i}-{j}", groups[key]) for j, key in enumerate(groups)},
        }


def part(anchor: str, results: Sequence[Result]) -> Content:
    """Return the results of one scene, engine and kind, with what they come to."""
    counts, (passed, count) = summary(results), pass_counts(results)
    words = [f"{passed} of {count} passed"] if count else []
    words += [plural(counts[name], name) for name in ("deviation", "error") if counts[name]]
    words += [f"{counts[name]} {name}" for name in ("known", "skipped") if counts[name]]
    measured = [ratio(r) for r in results if r.error is not None and r.tolerance is not None]
    return {
        "anchor": anchor,
        "engine": results[0].engine,
        "kind": results[0].kind,
        "verdict": worst(results),
        "text": tally(results),
        "words": ", ".join(words),
        "margin": f"largest error / tolerance {number(max(measured))}" if measured else "",
        "results": results,
    }


# Pictures


class Artist:
    """Draws results, as long as there is matplotlib and not too many failures."""

    def __init__(self, most: int) -> None:
        from ..drawing import import_pyplot
        from . import figures

        self.most, self.drawn, self.left, self.excuse = most, 0, 0, ""
        self.figures: Any = figures
        try:
            import_pyplot()
        except UsageError as error:
            self.figures, self.excuse = None, f"There are no pictures: {error}."

    def failure(self, members: Sequence[Result]) -> Iterator[Figure]:
        """Yield a picture of the worst of a check's results that has a series."""
        drawable = [result for result in members if result.series is not None]
        if not (drawable and self.figures):
            return
        if self.drawn == self.most:
            self.left += 1
            return
        self.drawn += 1
        yield self.figures.deviation(max(drawable, key=ratio))

    def undrawn(self) -> str:
        """Return how many failures have no picture because there are too many."""
        return f"The worst {self.drawn} are drawn, {self.left} more are not." if self.left else ""
