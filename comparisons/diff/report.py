"""Reports on the changes between two runs: console and Markdown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from rich.console import Console

from ..reports.sections import Section, markdown_sections, print_sections
from ..reports.text import STYLES, print_line
from ..reports.words import plural, with_unit
from .changes import REGRESSIONS, SORTS, Change, Diff, Document

FEW = 3
"""So many changes of a sort are shown one by one; more are grouped by engine and kind."""

MOST_GROUPS = 4
"""Groups of a sort that are shown; ``--verbose`` and the documents have all."""


def summary_line(diff: Diff) -> str:
    """Return the changes in one line."""
    if not diff.changes:
        return f"NO CHANGE: {plural(diff.compared, 'result')}, the same in both"
    word = "REGRESSED" if diff.regressions else "NO REGRESSION"
    counts = [f"{diff.summary[name]} {title}" for name, title in SORTS.items()]
    parts = [text for text in counts if not text.startswith("0 ")]
    return f"{word}: {', '.join(parts)}; {diff.same} of {diff.compared} the same"


def side_line(name: str, side: Document) -> str:
    """Return the description of one of the runs."""
    versions = ", ".join(f"{what} {text}" for what, text in side.versions.items())
    return f"{name} {side.file}: {plural(len(side.results), 'result')}; {versions}"


def numbers(change: Change) -> str:
    """Return verdict and error before and after."""
    sides = (change.old, change.new)
    verdicts = " -> ".join("missing" if s is None else s.verdict for s in sides)
    errors = [s for s in sides if s is not None and s.error is not None]
    if not errors:
        return verdicts
    unit = change.result.unit
    sizes = " -> ".join(with_unit(s.error, unit) for s in errors)
    limits = list(dict.fromkeys(with_unit(s.tolerance, unit) for s in errors))
    return f"{verdicts}; error {sizes}, tolerance {' -> '.join(limits)}"


def reason(change: Change) -> str:
    """Return the reason of the newer result if it is a new failure."""
    wanted = change.regression and change.new is not None and change.new.verdict != "pass"
    return change.result.reason if wanted else ""


def diff_sections(diff: Diff, verbose: bool) -> Iterator[Section]:
    """Yield the two runs, then each sort of change; ``verbose`` lists every change."""
    sides = [side_line("old", diff.old), side_line("new", diff.new)]
    yield Section(lines=[*sides, *(f"  {note}" for note in diff.notes)])
    for name, title in SORTS.items():
        changes = [change for change in diff.changes if change.sort == name]
        groups: dict[str, list[Change]] = {}
        for change in changes:
            groups.setdefault(f"{change.result.engine} {change.result.kind}", []).append(change)
        lines = []
        for change in changes if verbose or len(changes) <= FEW else ():
            lines += change_lines(change)
        for group, members in () if lines else list(groups.items())[:MOST_GROUPS]:
            scenes = Counter(change.result.scene for change in members).items()
            where = ", ".join(f"{scene} ({count})" for scene, count in scenes)
            lines.append(f"{group}: {len(members)} in {where}")
            if name in REGRESSIONS:
                lines += change_lines(members[0], "  worst: ")
        if changes:
            verdict = "deviation" if name in REGRESSIONS else ""
            yield Section(f"{title} ({len(changes)})", lines=lines, verdict=verdict)


def change_lines(change: Change, title: str = "") -> list[str]:
    """Return a change in lines: its id, its numbers, and why."""
    lines = filter(None, (numbers(change), reason(change)))
    return [f"{title}{change.result.id}", *(f"    {line}" for line in lines)]


def print_diff(console: Console, diff: Diff, verbose: bool = False) -> None:
    """Print the two runs, then the changes, then a summary."""
    print_sections(console, diff_sections(diff, verbose))
    print_line(console, summary_line(diff), STYLES["deviation" if diff.regressions else "pass"])


def markdown(diff: Diff) -> str:
    """Return the changes as Markdown."""
    return markdown_sections(f"mbcheck diff: {summary_line(diff)}", diff_sections(diff, True))
