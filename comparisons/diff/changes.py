"""Changes between two runs, and which are regressions, by the rules of docs/ci.md."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from fnmatch import fnmatchcase
from functools import partial
from typing import Any, NoReturn

from msgspec import convert, to_builtins

from ...reference.errors import UsageError
from ..checks.request import CheckRequest
from ..checks.verdict import NOT_APPLICABLE, Result, result_from
from ..documents import SCHEMA, document
from ..documents.core import record
from ..documents.fields import HIDDEN, documented
from ..documents.reading import read_document
from ..reports.run.outcome import Report
from ..reports.run.results import ratio

FACTOR = 1.5
"""An error that grows by a smaller factor has not changed: the safety factor of errors that the
suite cannot predict exactly."""

SHARE = 0.5
"""Share of the tolerance; an error that grows by less has not changed. The arithmetic of another
processor (no FMA, no AVX, other BLAS kernels) moved errors of a whole run by up to 0.42 of it: a
tolerance allows for round-off, and an error far below it is nothing else."""


@dataclass(frozen=True)
class Document:
    """One run of checks.

    Attributes
    ----------
    file : str
        file that was read
    environment : mapping of str to str
        python, system, machine, processor and libc, on which round-off may depend
    results : mapping of id to Result
        Without those for an engine that cannot be imported.
    selection : CheckRequest
    not_reached : int
        Number of planned checks that did not start.
    unavailable : mapping of str to str
        Why an engine could not be imported, by its name.
    """

    file: str
    versions: Mapping[str, str]
    environment: Mapping[str, str]
    results: Mapping[str, Result] = field(metadata=HIDDEN)
    selection: CheckRequest = field(metadata=HIDDEN)
    not_reached: int = field(metadata=HIDDEN)
    unavailable: Mapping[str, str] = field(metadata=HIDDEN)

    @property
    @documented
    def result_count(self) -> int:
        """Number of results."""
        return len(self.results)

    @property
    def engines(self) -> tuple[str, ...]:
        """Engines that have results."""
        return tuple(dict.fromkeys(result.engine for result in self.results.values()))


def read(file: str) -> Document:
    """Return the ``check`` document of a file.

    Raises
    ------
    UsageError
        If it cannot be read, or is no such document of this schema.
    """

    def constant(word: str) -> NoReturn:
        raise ValueError(f"{word} is no JSON")

    _, content = read_document(file, "JSON", partial(json.loads, parse_constant=constant))
    if not isinstance(content, dict) or "schema" not in content:
        raise UsageError(f"{file!r} is no document of mbcheck: write one with `check --json`")
    if content["schema"] != SCHEMA:
        raise UsageError(
            f"{file!r} has schema {content['schema']!r}; this mbcheck reads schema {SCHEMA}"
        )
    try:
        return run_of(file, convert(content, record(Report, is_root=True)))
    except ValueError as error:
        raise UsageError(f"{file!r} is not what `mbcheck check --json` writes: {error}") from None


def run_of(file: str, content: Any) -> Document:
    """Return a run from its document.

    Raises
    ------
    ValueError
        If an id stands twice.
    """
    results: dict[str, Result] = {}
    unavailable = {}
    for item in content.results:
        result = result_from(to_builtins(item))
        if result.id in results:
            raise ValueError(f"the id {result.id!r} stands twice")
        if result.kind == NOT_APPLICABLE:
            unavailable[result.engine] = result.reason
        else:
            results[result.id] = result
    return Document(
        file,
        content.versions,
        content.environment,
        results,
        CheckRequest(**to_builtins(content.selection)),
        content.checks.not_reached,
        unavailable,
    )


# Changes


SORTS: Mapping[str, str] = {
    "new_error": "new errors",
    "new_deviation": "new deviations",
    "grew": "errors that grew",
    "vanished": "missing now",
    "now_skipped": "now skipped",
    "other_failure": "errors, now deviations",
    "now_known": "now known",
    "fixed": "fixed",
    "shrank": "errors that shrank",
    "now_runs": "no longer skipped",
    "appeared": "new without failure",
    "left_out": "not compared: left out of the new run",
    "dropped": "missing now, and skipped before",
}
"""Titles of sorts of changes, the most important first."""

REGRESSIONS = ("new_error", "new_deviation", "grew", "vanished", "now_skipped")


@dataclass(frozen=True)
class Change:
    """A change of the result of one id.

    Attributes
    ----------
    sort : str
        sort of change, one of those that `summary` counts
    old, new : Result or None
        the result there; null where the id is not there
    """

    sort: str
    old: Result | None
    new: Result | None

    @property
    def result(self) -> Result:
        """The newer result of the two, which names the change."""
        newer = self.new or self.old
        assert newer is not None
        return newer

    @property
    @documented
    def id(self) -> str:
        """As in `check`."""
        return self.result.id

    @property
    @documented
    def regression(self) -> bool:
        """Whether it makes the new run worse."""
        return self.sort in REGRESSIONS

    @property
    def weight(self) -> tuple[int, float, float, str]:
        """Key of the order of changes: sort, error over tolerance, factor of growth, id."""
        where = tuple(SORTS).index(self.sort)
        return where, -ratio(self.result), -self.factor, self.result.id

    @property
    def factor(self) -> float:
        """Ratio of the larger error to the smaller; 1 where there are not two."""
        errors = [side.error for side in (self.old, self.new) if side and side.error is not None]
        if len(errors) < 2 or max(errors) == 0:
            return 1.0
        return max(errors) / min(errors) if min(errors) > 0 else math.inf


@dataclass(frozen=True)
class Diff:
    """The changes between two runs.

    Attributes
    ----------
    old, new : Document
        the runs
    changes : tuple of Change
        the most important first
    notes : tuple of str
        other differences of the runs, in words
    """

    old: Document
    new: Document
    changes: tuple[Change, ...]
    compared: int = field(metadata=HIDDEN)
    same: int = field(metadata=HIDDEN)
    notes: tuple[str, ...]

    @property
    @documented
    def summary(self) -> dict[str, int]:
        """Number of changes by sort, and of the ids that were `compared` and are the `same`."""
        counts = {sort: sum(item.sort == sort for item in self.changes) for sort in SORTS}
        return {"compared": self.compared, "same": self.same, **counts}

    @property
    @documented
    def regressions(self) -> int:
        """Number of changes that are regressions; exit code 1 if there is one."""
        return sum(change.regression for change in self.changes)

    @property
    def exit_code(self) -> int:
        """1 if there is a regression, otherwise 0."""
        return 1 if self.regressions else 0

    def as_json(self) -> dict[str, Any]:
        """Return the ``diff`` document of docs/json.md."""
        return document("diff", self)


def compare(old: Document, new: Document) -> Diff:
    """Return the changes between two runs.

    Raises
    ------
    UsageError
        If no id is in both: there is nothing to compare.
    """
    both = [id for id in old.results if id in new.results]
    if not both:
        raise UsageError(
            f"{old.file!r} and {new.file!r} have no result in common: nothing to compare"
        )
    pairs = [(old.results[id], new.results[id]) for id in both]
    sorts = [sort_of(*pair) for pair in pairs]
    changes = [Change(sort, *pair) for sort, pair in zip(sorts, pairs, strict=True) if sort]
    same = len(both) - len(changes)
    failed = {"deviation": "new_deviation", "error": "new_error"}
    changes += [
        Change(failed.get(result.verdict, "appeared"), None, result)
        for result in new.results.values()
        if result.id not in old.results
    ]
    changes += absent(old, new)
    changes.sort(key=lambda change: change.weight)
    return Diff(old, new, tuple(changes), len(both), same, tuple(notes(old, new)))


def sort_of(old: Result, new: Result) -> str | None:
    """Return the sort of change between two results of one id; None if there is none."""
    if old.verdict == new.verdict:
        return growth(old, new)
    sorts: dict[str, str] = {
        "error": "new_error",
        "deviation": "other_failure" if old.verdict == "error" else "new_deviation",
        "skipped": "now_skipped",
        "known": "now_known",
        "pass": "now_runs" if old.verdict == "skipped" else "fixed",
    }
    return sorts[new.verdict]


def growth(old: Result, new: Result) -> str | None:
    """Return ``grew`` or ``shrank`` if an error changes beyond its noise; None otherwise."""
    before, after = old.error, new.error
    if before is None or after is None or old.tolerance is None or new.tolerance is None:
        return None
    noise = SHARE * min(old.tolerance, new.tolerance)
    for name, less, more in (("grew", before, after), ("shrank", after, before)):
        if more > FACTOR * less and more - less > noise:
            return name
    return None


def absent(old: Document, new: Document) -> Iterator[Change]:
    """Yield the results that are not in the new run: left out by its options, dropped, vanished."""
    before, asked = old.selection, new.selection
    narrower = (before.full and not asked.full) or (asked.quick and not before.quick)
    named = [name for name in asked.engines if ":" not in name]
    engines = {*named, *new.engines} if asked.engines else set()
    checks = {
        result.check_id
        for result in old.results.values()
        if any(fnmatchcase(result.id, pattern) for pattern in asked.ids)
    }
    for result in old.results.values():
        restrictions = (
            (asked.scenes, result.scene),
            (asked.kinds, result.kind),
            (asked.methods, result.method),
            (engines, result.engine),
        )
        filtered = any(names and name not in names for names, name in restrictions)
        filtered |= bool(asked.ids) and result.check_id not in checks
        if result.id not in new.results:
            sort = "dropped" if result.verdict == "skipped" else "vanished"
            left_out = new.not_reached or narrower or filtered
            yield Change("left_out" if left_out else sort, result, None)


def notes(old: Document, new: Document) -> Iterator[str]:
    """Yield the differences of two runs besides their results."""
    for what in ("versions", "environment"):
        before: Mapping[str, str] = getattr(old, what)
        after: Mapping[str, str] = getattr(new, what)
        if not before or not after:
            continue
        for name in dict.fromkeys([*before, *after]):
            if before.get(name) != after.get(name):
                yield f"{name}: {before.get(name, 'none')} -> {after.get(name, 'none')}"
    for side, here, there in (("old", old, new), ("new", new, old)):
        for name in here.engines:
            if name not in there.engines:
                yield f"engine {name} is in the {side} run only"
        for name, reason in here.unavailable.items():
            yield f"engine {name} could not be imported in the {side} run: {reason}"
        if here.not_reached:
            yield f"the {side} run was stopped: {here.not_reached} checks did not start"
    for item in fields(CheckRequest):
        first, second = (getattr(side.selection, item.name) for side in (old, new))
        if first != second:
            yield f"selection: {item.name} {in_words(first)} -> {in_words(second)}"


def in_words(value: Any) -> str:
    """Return a part of a selection in words."""
    if isinstance(value, list):
        return ", ".join(map(str, value)) or "all"
    return str(value).lower() if isinstance(value, bool) else str(value)
