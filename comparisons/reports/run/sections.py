"""The report on a run of checks: its sections for console, Markdown and HTML, and its items."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from rich.console import Console

from ...checks.known import Use
from ...checks.table import KINDS
from ...checks.verdict import FAILURES, NOT_APPLICABLE, Result, Verdict
from ..item import Outcome, ReportItem
from ..junit import junit
from ..sarif import sarif
from ..sections import Section, markdown_sections, print_sections
from ..text import STYLES, Cell, matrix_by_kind, print_line
from ..words import number, plural, with_unit
from .located import HEADS, blocks, located
from .outcome import Report
from .results import (
    MEASURES,
    error_size,
    grouped,
    measured,
    method_of,
    ran,
    ratio,
    reasons,
    tally,
    why_known,
    worst,
)

MOST = 10
"""Failing checks that are shown without --verbose."""

MOST_IN_MARKDOWN = 50
"""The same of a page of Markdown, which GitHub refuses above 1 MiB."""

FEW_NAMES = 4
"""Largest number of models and of methods that are named with a reason."""

RESULT_HEADS = (
    "verdict", "case", "model, method", "quantity", "error", "tolerance", "times",
)  # fmt: skip

REASON_HEADS = ("engine", "model", "method", "results", "why")

STALE_RULE = "stale_known"

RULES = {
    **{name: (f"{name}: {kind.level}", f"{kind.level} is wrong; see docs/checks.md")
       for name, kind in KINDS.items()},
    STALE_RULE: ("stale known deviation", "an entry of --known that nothing needs: docs/ci.md"),
}  # fmt: skip
"""Rules of the items of a run: kinds of checks, from the model to its motion."""


# Sections


def origin(report: Report) -> str:
    """Return versions and machine, in one line."""
    both = [*report.versions.items(), *report.environment.items()]
    return ", ".join(f"{name} {text}" for name, text in both)


def print_report(console: Console, report: Report, verbosity: int = 0) -> None:
    """Print the location of deviations, then the failures, then the rest.

    Parameters
    ----------
    console : rich.console.Console
    report : Report
    verbosity : int
        -1 prints the summary line only, 1 adds all that failed and every single result.
    """
    if verbosity >= 0:
        most = None if verbosity > 0 else MOST
        sections = [*failure_sections(report, most), *tracebacks(report.results, verbosity > 0)]
        sections += result_sections(report) if verbosity > 0 else ()
        print_sections(console, [*sections, *closing_sections(report)])
        print_line(console, origin(report))
        print_line(console, report.counts_line)
    print_line(console, report.summary_line, STYLES[report.verdict])


def run_summary(report: Report) -> str:
    """Return the Markdown of a run, for CI services."""
    about = Section(lines=[report.counts_line, origin(report)])
    failures = failure_sections(report, MOST_IN_MARKDOWN)
    title = f"mbcheck: {report.summary_line}"
    return markdown_sections(title, [about, *failures, *closing_sections(report)])


def failure_sections(report: Report, most: int | None) -> Iterator[Section]:
    """Yield the subject of a run, its first wrong level, and at most so many failures."""
    if report.header:
        yield Section(lines=[report.header])
    if where := located(report.results):
        yield Section("Located:", lines=where)
    failures = blocks(report.results)
    limit = len(failures) if most is None else most
    for block in failures[:limit]:
        yield Section(
            block.title,
            HEADS,
            block.rows,
            block.reasons,
            [report.repeat(block.worst.id)],
            verdict=block.worst.verdict,
        )
    if more := len(failures[limit:]):
        yield Section(
            lines=[f"and {plural(more, 'more check')} with other failures: -v shows them"]
        )


def tracebacks(results: Sequence[Result], whole: bool) -> Iterator[Section]:
    """Yield where engines raised, each place once, or how to see it."""
    raised = grouped((r for r in results if r.traceback), lambda r: (r.traceback or "",))
    if raised and not whole:
        yield Section(lines=[f"{plural(len(raised), 'traceback')} of engines: shown with -v"])
    for (traceback,), members in raised.items() if whole else ():
        others = f" and {len(members) - 1} more" if members[1:] else ""
        title = f"TRACEBACK {members[0].id}{others}"
        yield Section(title, verbatim=traceback.splitlines(), verdict="error")


def result_sections(report: Report, repeat: bool = False) -> Iterator[Section]:
    """Yield every result, by scene, engine and kind; with the command that repeats it."""
    heads = (*RESULT_HEADS, *(["repeat"] if repeat else []))
    groups = grouped(ran(report.results), lambda r: (r.scene, r.engine, r.kind))
    for name, members in groups.items():
        rows = [
            (
                Cell(r.verdict.replace("pass", "ok"), r.verdict),
                r.case,
                method_of(r),
                r.quantity,
                *(with_unit(x, r.unit, missing="") for x in (r.error, r.tolerance)),
                "" if r.error is None or r.tolerance is None else number(ratio(r)),
                *([report.repeat(r.id)] if repeat else []),
            )
            for r in members
        ]
        title = f"{'/'.join(name)}: {tally(members)}"
        yield Section(title, heads, rows, anchor="-".join(name), folded=True)


def closing_sections(report: Report) -> Iterator[Section]:
    """Yield the matrix of verdicts, accuracy, and known, stale and skipped results."""
    results = report.results
    cells = grouped(ran(results), lambda r: (r.scene, r.engine, r.kind))
    if cells:
        table = matrix_by_kind(
            {key: Cell(tally(own), worst(own), "-".join(key)) for key, own in cells.items()}
        )
        yield Section("Verdicts", *table, anchor="verdicts")
    if lines := list(accuracy(results)):
        yield Section("Accuracy", lines=lines)
    yield from reasons_section("known", "Known deviations", results)
    if report.stale:
        lines = list(map(report.stale_line, report.stale))
        verdict = "deviation" if report.selection.strict_known else "known"
        yield Section("Stale known deviations", lines=lines, anchor="stale", verdict=verdict)
    yield from reasons_section("skipped", "Skipped", results)


def accuracy(results: Sequence[Result]) -> Iterator[str]:
    """Yield the most and the least accurate method of each scene and engine.

    Methods are compared by the first observable of the trajectories.
    """
    trajectories = (r for r in results if r.kind == "trajectory" and r.error is not None)
    for (scene,), of_scene in grouped(trajectories, lambda r: (r.scene,)).items():
        quantity = of_scene[0].quantity
        errors = [r for r in of_scene if r.quantity == quantity]
        for (engine,), members in grouped(errors, lambda r: (r.engine,)).items():
            methods = grouped(members, lambda r: (method_of(r),)).values()
            ranked = sorted((max(group, key=error_size) for group in methods), key=error_size)
            ends = dict.fromkeys(
                f"{with_unit(r.error, r.unit)} ({method_of(r)})" for r in (ranked[0], ranked[-1])
            )
            yield f"{scene} {engine}: error of {quantity} {' to '.join(ends)}"


def reasons_section(verdict: Verdict, title: str, results: Sequence[Result]) -> Iterator[Section]:
    """Yield the reasons of a verdict, each once, with the number of results it holds for."""
    groups = reasons(results, verdict)
    rows = [
        (
            engine,
            few(r.model for r in members),
            few(r.method for r in members),
            len(members),
            reason or "no reason given",
        )
        for (engine, reason), members in groups.items()
    ]
    if rows:
        total = sum(map(len, groups.values()))
        yield Section(f"{title} ({total})", REASON_HEADS, rows, anchor=verdict, verdict=verdict)


def few(names: Iterable[str | None]) -> str | None:
    """Return the first of several names, each once; None if there are none."""
    each = list(dict.fromkeys(name for name in names if name and name != NOT_APPLICABLE))
    return ", ".join([*each[:FEW_NAMES], *(["..."] if each[FEW_NAMES:] else [])]) or None


# Items

OUTCOMES: Mapping[Verdict, Outcome] = {
    "pass": "pass",
    "deviation": "failure",
    "known": "skipped",
    "skipped": "skipped",
    "error": "error",
}
"""Names of verdicts on test pages of CI services."""


def run_items(report: Report) -> list[ReportItem]:
    """Return an item for each result, and for each stale entry of the known deviations.

    A deviation is a failure, an error an error; skipped and known results are skipped. The time
    of a check is shared equally by its results.
    """
    siblings = Counter(result.check_id for result in report.results)
    items = []
    for r in report.results:
        failed = r.verdict in FAILURES
        known = f"known deviation: {why_known(r)}; {r.reason}"
        seconds = r.work.get("seconds", 0.0)
        details = (measured(r), report.repeat(r.id), r.traceback or "") if failed else ()
        names = ("method", "model", "quantity", "unit", *MEASURES, "verdict")
        items.append(
            ReportItem(
                id=r.id,
                rule=r.kind,
                suite=suite_of(r),
                outcome=OUTCOMES[r.verdict],
                severity="error" if failed else None,
                message=known if r.verdict == "known" else r.reason,
                details=tuple(filter(None, details)),
                numbers={name: getattr(r, name) for name in names},
                seconds=seconds / siblings[r.check_id] if math.isfinite(seconds) else 0.0,
            )
        )
    return [*items, *(stale_item(use, report) for use in report.stale)]


def suite_of(result: Result) -> str:
    """Return the suite of a result: scene, engine and kind."""
    return f"{result.scene}/{result.engine}/{result.kind}"


def stale_item(use: Use, report: Report) -> ReportItem:
    """Return a stale entry of the known deviations as an item: a failure if it is to fail."""
    is_failure = report.selection.strict_known
    return ReportItem(
        id=f"{use.entry.place}: {use.entry.id}",
        rule=STALE_RULE,
        suite="known deviations",
        outcome="failure" if is_failure else "skipped",
        severity="error" if is_failure else "warning",
        message=f"{report.stale_line(use)}; remove it",
        file=report.selection.known,
        title="stale known deviation",
    )


def run_annotations(report: Report) -> list[ReportItem]:
    """Return the annotations: stale entries, the first wrong level, failing checks, counts."""
    results = report.results
    items = [stale_item(use, report) for use in report.stale]
    if where := located(results):
        items.append(_error("mbcheck: located", where))
    for block in blocks(results):
        lines = [*block.quantities, *block.reasons, report.repeat(block.worst.id)]
        items.append(_error(f"{block.worst.verdict}: {block.worst.check_id}", lines))
    skipped = [
        f"skipped {len(members)} x {engine}: {why}"
        for (engine, why), members in reasons(results, "skipped").items()
    ]
    last = _error("mbcheck", [report.summary_line, report.counts_line, *skipped])
    return [*items, last if report.exit_code == 2 else replace(last, severity="note")]


def _error(title: str, lines: Sequence[str]) -> ReportItem:
    """Return an annotation of these lines."""
    return ReportItem(title, "", "", "failure", "error", lines[0], tuple(lines[1:]), title=title)


def run_junit(report: Report) -> str:
    """Return the JUnit XML of a run; suites that fail say where the engine is wrong."""
    by_engine = grouped(report.results, lambda r: (r.engine,))
    where = {engine: located(own) for (engine,), own in by_engine.items()}
    output = {
        suite_of(r): ["Located:", *where[r.engine]]
        for r in report.results
        if r.verdict in FAILURES and where[r.engine]
    }
    return junit(run_items(report), {**report.versions, **report.environment}, output)


def run_sarif(report: Report) -> str:
    """Return the SARIF of a run: what failed, and stale entries of the known deviations."""
    return sarif(run_items(report), RULES, report.versions["mbcheck"])


BADGE_COLOURS = {"PASS": "brightgreen", "FAIL": "red"}
"""Colour of a badge by `Report.word`; the badge of any other run is grey and has that word."""


def run_badge(report: Report) -> str:
    """Return the badge of a run, as the endpoint of shields.io reads it."""
    counts, message, colour = report.summary, report.word.lower(), "lightgrey"
    if report.word in BADGE_COLOURS:
        bad = [f"{counts['known']} known"] * bool(counts["known"])
        bad += [plural(counts[name], name) for name in FAILURES[::-1] if counts[name]]
        message, colour = ", ".join([f"{counts['pass']} passed", *bad]), BADGE_COLOURS[report.word]
    badge = {"schemaVersion": 1, "label": "mbcheck", "message": message, "color": colour}
    return json.dumps(badge) + "\n"
