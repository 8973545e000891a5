"""Known deviations: a TOML file of id patterns, each with a reason.

What an entry covers gets the verdict ``known`` and does not fail. An entry is *stale* when the
whole run of today shows that it is of no use; a run that was filtered or cut short shows nothing
of the checks that it left out. docs/ci.md is the page for users.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from math import inf
from typing import Any, Literal

from ...reference.errors import UnknownNameError, UsageError
from ..documents.reading import read_document
from .verdict import FAILURES, Result

TODO = "TODO: why does it deviate?"
"""Stands in a drafted file in place of each reason."""

KEYS = ("id", "reason", "max_error")
"""Keys of an entry; the first two are required. ``id`` may be a table of ids with their errors."""

State = Literal["used", "stale", "open"]


@dataclass(frozen=True)
class Entry:
    """One entry of a file of known deviations.

    Attributes
    ----------
    number : int
        its place in the file
    id : str
        pattern for ids
    reason : str
        as the user gave it
    max_error : float or None
        largest error that it covers, in the unit of the result; null: any, and what has none
    """

    number: int
    id: str
    reason: str
    max_error: float | None = None

    @property
    def place(self) -> str:
        """Its place in the file, for messages."""
        return f"entry {self.number}"

    def covers(self, result: Result) -> bool:
        """Return True if it covers a result that fails, or would if it were not known."""
        if result.verdict not in (*FAILURES, "known") or not fnmatchcase(result.id, self.id):
            return False
        return self.max_error is None or (
            result.verdict != "error"
            and result.error is not None
            and result.error <= self.max_error
        )


@dataclass(frozen=True)
class Use:
    """The use of an entry in a run.

    Attributes
    ----------
    entry : Entry
        as the file has it
    results : int
        how many are known because of it
    state : {"used", "stale", "open"}
        `stale`: no longer needed; `open`: undecided by this run
    why : str
        why it is not used; empty if it is
    """

    entry: Entry
    results: int
    state: State
    why: str = ""


@dataclass(frozen=True)
class Listing:
    """The known deviations of a run.

    Attributes
    ----------
    file : str or None
        None if there is no file.
    entries : tuple of Entry
    """

    file: str | None = None
    entries: tuple[Entry, ...] = ()

    def settle(self, result: Result) -> Result:
        """Return a result, `known` if an entry covers it; of several the first gives the reason."""
        about = [one for one in self.entries if fnmatchcase(result.id, one.id)]
        if result.verdict not in FAILURES or not about:
            return result
        entry = next((one for one in about if one.covers(result)), None)
        if entry is not None:
            return replace(result, verdict="known", known=entry.reason)
        largest = max(one.max_error or 0.0 for one in about)
        unit = "" if result.unit == "1" else f" {result.unit}"
        now = "" if result.error is None else f", now {result.error:.3g}{unit}"
        reason = f"known up to an error of {largest:g}{unit}{now}: {result.reason}"
        return replace(result, reason=reason)

    def uses(
        self,
        results: Sequence[Result],
        usual: Callable[[], Collection[str]],
        every: Callable[[], Collection[str]],
        others: Collection[str] = (),
    ) -> tuple[Use, ...]:
        """Return the use of each entry.

        Parameters
        ----------
        results : sequence of Result
            As `settle` returned them.
        usual : callable () -> collection of str
            All ids of the run's engines, had nothing been filtered. Called if needed.
        every : callable () -> collection of str
            These, and those that are left out by default.
        others : collection of str
            Names of engines that took no part.
        """
        uses = []
        for entry in self.entries:
            covered = sum(entry.covers(one) for one in results)
            if covered:
                uses.append(Use(entry, covered, "used"))
                continue
            mine = {id for id in usual() if fnmatchcase(id, entry.id)}
            ran = [one for one in results if one.id in mine]
            elsewhere = any(fnmatchcase(id, entry.id) for id in every())
            if not mine and not elsewhere and not {*entry.id.split("/")} & {*others}:
                uses.append(Use(entry, 0, "stale", "no check has such an id"))
            elif len({one.id for one in ran}) < len(mine) or all(
                one.verdict == "skipped" for one in ran
            ):
                uses.append(Use(entry, 0, "open", "not all of its checks ran"))
            else:
                uses.append(Use(entry, 0, "stale", "nothing that it covers fails any more"))
        return tuple(uses)


def read(file: str) -> Listing:
    """Return the known deviations of a file.

    Raises
    ------
    UsageError
        If it cannot be read, is not TOML, or an entry is not as docs/ci.md describes it; the
        message names the entry.
    """
    _, document = read_document(file, "TOML", tomllib.loads, "--known: ")
    for key in document:
        if key != "known":
            raise UsageError(f"--known: {file!r}: unknown key {key!r}; entries are [[known]]")
    tables = document.get("known", [])
    if not isinstance(tables, list) or not all(isinstance(item, dict) for item in tables):
        raise UsageError(f"--known: {file!r}: entries are written as [[known]], two brackets")
    entries: list[Entry] = []
    for number, table in enumerate(tables, 1):
        try:
            entries += entries_of(number, table)
        except UsageError as error:
            raise UsageError(f"--known: {file!r}, entry {number}: {error}") from None
    return Listing(file, tuple(entries))


def entries_of(number: int, table: Mapping[str, Any]) -> Iterator[Entry]:
    """Yield an entry for each id of a table: one, or several, each with its largest error.

    Raises
    ------
    UsageError
        If a key is unknown or missing, or a value makes no sense.
    """
    for key in table:
        if key not in KEYS:
            raise UnknownNameError("key", key, KEYS)
    for key in KEYS[:2]:
        if key not in table:
            raise UsageError(f"{key} is missing")
    id, reason = table["id"], table["reason"]
    several = isinstance(id, dict)
    for key, value in [("reason", reason), *(("id", one) for one in (id if several else [id]))]:
        if not isinstance(value, str) or not value.strip():
            raise UsageError(f"{key} must be a string with something in it, not {value!r}")
    if several and "max_error" in table:
        raise UsageError("each id has its largest error: remove max_error")
    if reason.strip() == TODO:
        raise UsageError(
            f"the reason is still {TODO!r}: write why it deviates, or remove the entry"
        )
    for pattern, most in (id if several else {id: table.get("max_error", inf)}).items():
        if type(most) not in (int, float) or not most > 0:
            raise UsageError(f"max_error must be a positive number, not {most!r}")
        yield Entry(number, pattern, reason, None if most == inf else most)


def draft(results: Iterable[Result]) -> str:
    """Return a file of known deviations, to be completed: an entry for each cause.

    It lists its ids, each with twice the error as its largest one; a failed run has no size.
    """
    groups: dict[str, list[Result]] = {}
    for result in results:
        if result.verdict in FAILURES:
            groups.setdefault(fault(result) or result.check_id, []).append(result)
    lines = ["# Known deviations: write a reason for each entry, or repair and remove it."]
    for members in groups.values():
        about = fault(members[0]) or members[0].reason
        lines += ["", "[[known]]", f"# {about}", f'reason = "{TODO}"', "[known.id]"]
        for result in members:
            id = json.dumps(re.sub(r"([*?[])", r"[\1]", result.id), ensure_ascii=False)
            size = 2 * (result.error or 0.0) if result.verdict == "deviation" else inf
            lines.append(f"{id} = {size:.3g}")
    return "".join(f"{plain_line(line)}\n" for line in lines)


def fault(result: Result) -> str:
    """Return the cause, part or message that several failures may share; empty if there is none."""
    if result.cause or result.verdict == "error":
        return result.cause or result.reason
    return result.reason.partition("; ")[2] if result.kind == "parts" else ""


def plain_line(text: str) -> str:
    """Return text without the characters that a TOML file must not hold."""
    return re.sub(r"[\x00-\x08\x0a-\x1f\x7f\ud800-\udfff]+", " ", text)
