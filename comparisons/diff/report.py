"""Reports on what changed between two runs: console and Markdown."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.console import Console

from ..reports.run.markdown import short_table
from ..reports.text import print_line, print_wrapped
from ..reports.words import code, plain, plural, with_unit
from .changes import SORTS, Change, Diff
from .document import Document

FEW = 3
"""So many changes of a sort are shown one by one; more are grouped by engine and kind."""

MOST_GROUPS = 4
"""Groups of a sort that are shown; ``--verbose`` and the documents have all."""

Groups = list[tuple[str, list[Change]]]


def summary_line(diff: Diff) -> str:
    """Return what changed in one line."""
    if not diff.changes:
        return f"NO CHANGE: {plural(diff.compared, 'result')}, the same in both"
    word = "REGRESSED" if diff.regressions else "NO REGRESSION"
    counts = [f"{diff.summary[name]} {sort.title}" for name, sort in SORTS.items()]
    parts = [text for text in counts if not text.startswith("0 ")]
    return f"{word}: {', '.join(parts)}; {diff.same} of {diff.compared} the same"


def side_line(name: str, side: Document) -> str:
    """Return what one of the runs was."""
    versions = ", ".join(f"{what} {text}" for what, text in side.versions.items())
    return f"{name} {side.file}: {plural(len(side.results), 'result')}; {versions}"


def by_sort(diff: Diff) -> Iterator[tuple[str, list[Change]]]:
    """Yield the sorts that there are, with their changes."""
    for name in SORTS:
        changes = [change for change in diff.changes if change.sort == name]
        if changes:
            yield name, changes


def groups(changes: Sequence[Change]) -> Groups:
    """Return changes by engine and kind, the group with the worst change first."""
    by_name: dict[str, list[Change]] = {}
    for change in changes:
        by_name.setdefault(f"{change.result.engine} {change.result.kind}", []).append(change)
    return list(by_name.items())


def where(changes: Sequence[Change]) -> str:
    """Return how many changes there are, and in which scenes."""
    scenes: dict[str, int] = {}
    for change in changes:
        scenes[change.result.scene] = scenes.get(change.result.scene, 0) + 1
    return f"{len(changes)} in " + ", ".join(f"{name} ({n})" for name, n in scenes.items())


def numbers(change: Change) -> str:
    """Return what verdict and error were, and what they are."""
    sides = (change.old, change.new)
    verdicts = " -> ".join("not there" if s is None else s.verdict for s in sides)
    errors = [s for s in sides if s is not None and s.error is not None]
    if not errors:
        return verdicts
    unit = change.result.unit
    sizes = " -> ".join(with_unit(s.error, unit) for s in errors)
    limits = list(dict.fromkeys(with_unit(s.tolerance, unit) for s in errors))
    return f"{verdicts}; error {sizes}, tolerance {' -> '.join(limits)}"


def reason(change: Change) -> str:
    """Return why the newer result is what it is, where that is news."""
    wanted = change.regression and change.new is not None and change.new.verdict != "pass"
    return change.result.reason if wanted else ""


# Console


def print_diff(console: Console, diff: Diff, verbose: bool = False) -> None:
    """Print what was compared, then what changed, then one line.

    Parameters
    ----------
    console : rich.console.Console
    diff : Diff
    verbose : bool
        Show every change.
    """
    for name, side in (("old", diff.old), ("new", diff.new)):
        print_wrapped(console, side_line(name, side))
    for note in diff.notes:
        print_wrapped(console, note, indent="  ")
    for name, changes in by_sort(diff):
        console.print()
        style = "bold red" if SORTS[name].regression else "bold"
        print_line(console, f"{SORTS[name].title} ({len(changes)})", style)
        if verbose or len(changes) <= FEW:
            for change in changes:
                print_change(console, change, "  ")
            continue
        by_name = groups(changes)
        for title, members in by_name[:MOST_GROUPS]:
            print_wrapped(console, f"{title}: {where(members)}", indent="  ")
            if SORTS[name].regression:
                print_change(console, members[0], "    worst: ")
        left = by_name[MOST_GROUPS:]
        if left:
            count = sum(len(members) for _, members in left)
            print_wrapped(console, f"{count} more in {plural(len(left), 'group')}", indent="  ")
    console.print()
    style = "bold red" if diff.regressions else "green"
    print_line(console, summary_line(diff), style)


def print_change(console: Console, change: Change, indent: str) -> None:
    """Print one change: its id, its numbers, and why."""
    print_line(console, f"{indent}{change.result.id}", "")
    for line in filter(None, (numbers(change), reason(change))):
        print_wrapped(console, line, indent="      ")


# Markdown


def markdown(diff: Diff) -> str:
    """Return what changed as Markdown: a table for each sort of change."""
    parts = [f"## mbcheck diff: {plain(summary_line(diff))}\n"]
    parts += [f"{plain(side_line(n, s))}\n" for n, s in (("old", diff.old), ("new", diff.new))]
    if diff.notes:
        parts.append("".join(f"- {plain(note)}\n" for note in diff.notes))
    for name, changes in by_sort(diff):
        parts.append(f"### {SORTS[name].title} ({len(changes)})\n")
        if len(changes) > FEW:
            cells = ((title, where(members)) for title, members in groups(changes))
            parts.append(short_table(("Engine, kind", "Changes"), cells))
        rows = ((code(c.result.id), numbers(c), reason(c)) for c in changes)
        parts.append(short_table(("Id", "Change", "Why"), rows))
    return "\n".join(parts)
