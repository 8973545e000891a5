"""Deviations that a user knows of: a TOML file of id patterns, each with its reason.

What an entry covers gets the verdict ``known`` and does not fail. An entry is *stale* when the
whole run of today shows that it is of no use; a run that was filtered or cut short shows nothing
of the checks that it left out. docs/ci.md is the page for users.
"""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import Any, Literal

from ...reference.errors import UnknownNameError, UsageError
from ..documents.reading import read_document
from .verdict import Result

TODO = "TODO: why does it deviate?"
"""What a drafted file has in place of a reason."""

KEYS = ("id", "reason", "verdict", "max_error")
"""What an entry may say; the first two it must."""

COVERED = ("deviation", "error")
"""What `verdict` may be; an entry that does not say covers deviations."""

HEADER = re.compile(r"^[ \t]*\[\[[ \t]*known[ \t]*\]\]", re.MULTILINE)

State = Literal["used", "stale", "open"]


@dataclass(frozen=True)
class Entry:
    """One entry of a file of known deviations.

    Attributes
    ----------
    number : int
        its place in the file
    line : int or None
        where it begins; null if not written as `[[known]]`
    id : str
        pattern for ids
    reason : str
        as the user gave it
    verdict : {"deviation", "error"}
        what it covers
    max_error : float or None
        largest error that it covers, in the unit of a result; null for any
    """

    number: int
    line: int | None
    id: str
    reason: str
    verdict: str = "deviation"
    max_error: float | None = None

    @property
    def place(self) -> str:
        """Where it stands, for messages."""
        return f"entry {self.number}" + ("" if self.line is None else f" (line {self.line})")

    def has_room_for(self, result: Result) -> bool:
        """Return whether the error of a result is not larger than it covers."""
        if self.max_error is None:
            return True
        return result.error is not None and result.error <= self.max_error


@dataclass(frozen=True)
class Use:
    """What became of an entry in a run.

    Attributes
    ----------
    entry : Entry
        as the file has it
    results : int
        how many are known because of it
    state : {"used", "stale", "open"}
        `stale`: of no use any more; `open`: this run cannot tell
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
        """Return a result, `known` if an entry covers it; of several the first tells why."""
        about = [one for one in self.entries if is_about(one, result)]
        entry = next((one for one in about if one.has_room_for(result)), None)
        if result.verdict not in COVERED or not about:
            return result
        if entry is None:
            largest = max(one.max_error or 0.0 for one in about)
            reason = f"known, but not with an error above {largest:g}: {result.reason}"
            return replace(result, reason=reason)
        return replace(result, verdict="known", known=entry.reason)

    def uses(
        self,
        results: Sequence[Result],
        usual: Callable[[], Collection[str]],
        every: Callable[[], Collection[str]],
        others: Collection[str] = (),
    ) -> tuple[Use, ...]:
        """Return what became of each entry.

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
        return tuple(self._use(entry, results, usual, every, others) for entry in self.entries)

    def _use(
        self,
        entry: Entry,
        results: Sequence[Result],
        usual: Callable[[], Collection[str]],
        every: Callable[[], Collection[str]],
        others: Collection[str],
    ) -> Use:
        covered = sum(is_about(entry, one) and entry.has_room_for(one) for one in results)
        if covered:
            return Use(entry, covered, "used")
        mine = {id for id in usual() if fnmatchcase(id, entry.id)}
        if not mine and any(fnmatchcase(id, entry.id) for id in every()):
            return Use(entry, 0, "open", "its checks run with --full only")
        absent = [name for name in entry.id.split("/") if name in others]
        if not mine:
            why = f"engine {absent[0]} took no part" if absent else "no check has such an id"
            return Use(entry, 0, "open" if absent else "stale", why)
        here = {result.id: result for result in results if result.id in mine}
        ran = [result for result in here.values() if result.verdict != "skipped"]
        if len(here) < len(mine):
            left = len(mine) - len(here)
            return Use(entry, 0, "open", f"{left} of its {len(mine)} results are not in this run")
        if not ran:
            return Use(entry, 0, "open", f"all its {len(mine)} results were skipped")
        if all(result.verdict == "pass" for result in ran):
            return Use(entry, 0, "stale", f"what it covers passes now ({len(ran)} results)")
        return Use(entry, 0, "stale", f"none of its {len(ran)} results is now: {entry.verdict}")


def is_about(entry: Entry, result: Result) -> bool:
    """Return True if an entry covers a result, whatever the size of its error."""
    return original_verdict(result) == entry.verdict and fnmatchcase(result.id, entry.id)


def original_verdict(result: Result) -> str:
    """Return the verdict of a result before it was `known`.

    A deviation is the only one of the two that has a finite error and a finite tolerance.
    """
    if result.verdict != "known":
        return result.verdict
    numbers = (result.error, result.tolerance)
    return "deviation" if all(x is not None and math.isfinite(x) for x in numbers) else "error"


# Reading


def read(file: str) -> Listing:
    """Return the known deviations of a file.

    Raises
    ------
    UsageError
        If it cannot be read, is not TOML, or an entry is not what docs/ci.md tells; the message
        names the entry.
    """
    text, document = read_document(file, "TOML", tomllib.loads, "--known: ")
    for key in document:
        if key != "known":
            raise UsageError(f"--known: {file!r}: unknown key {key!r}; entries are [[known]]")
    tables = document.get("known", [])
    if not isinstance(tables, list) or not all(isinstance(item, dict) for item in tables):
        raise UsageError(f"--known: {file!r}: entries are written as [[known]], two brackets")
    lines: list[int | None] = [
        text.count("\n", 0, match.start()) + 1 for match in HEADER.finditer(text)
    ]
    if len(lines) != len(tables):
        lines = [None] * len(tables)
    entries = []
    for number, (line, table) in enumerate(zip(lines, tables, strict=True), 1):
        where = Entry(number, line, "", "").place
        try:
            entries.append(entry(number, line, table))
        except UsageError as error:
            raise UsageError(f"--known: {file!r}, {where}: {error}") from None
    return Listing(file, tuple(entries))


def entry(number: int, line: int | None, table: Mapping[str, Any]) -> Entry:
    """Return an entry from its table.

    Raises
    ------
    UsageError
        For an unknown or missing key, or a value that makes no sense.
    """
    for key, value in table.items():
        if key not in KEYS:
            raise UnknownNameError("key", key, KEYS)
        if key == "max_error":
            valid = type(value) in (int, float) and 0 < value < math.inf
            if not valid or table.get("verdict") == "error":
                raise UsageError(
                    f"max_error must be a positive number, of deviations only, not {value!r}"
                )
        elif not isinstance(value, str) or not value.strip():
            raise UsageError(f"{key} must be a string with something in it, not {value!r}")
    for key in KEYS[:2]:
        if key not in table:
            raise UsageError(f"{key} is missing")
    if table["reason"].strip() == TODO:
        raise UsageError(
            f"the reason is still {TODO!r}: write why it deviates, or remove the entry"
        )
    entry = Entry(number, line, **table)
    if entry.verdict not in COVERED:
        raise UnknownNameError("verdict", entry.verdict, COVERED)
    return entry


# Writing


def draft(results: Iterable[Result]) -> str:
    """Return a file of known deviations: an entry for each result that fails, to be completed."""
    head = "# Known deviations: give each a reason, and remove what is to be repaired instead.\n"
    return head + "".join(table(result) for result in results if result.verdict in COVERED)


def table(result: Result) -> str:
    """Return the entry of a result that fails, with what was seen as a comment."""
    lines = ["", "[[known]]", f"# {result.quantity}: {result.reason}"]
    lines += [f"id = {quoted(literal(result.id))}", f'reason = "{TODO}"']
    if result.verdict != "deviation":
        lines.append(f"verdict = {quoted(result.verdict)}")
    return "".join(f"{one_line(line)}\n" for line in lines)


def literal(id: str) -> str:
    """Return a pattern that matches an id and nothing else."""
    return re.sub(r"([*?[])", r"[\1]", id)


def quoted(text: str) -> str:
    """Return a TOML string."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def one_line(text: str) -> str:
    """Return text without what a TOML comment must not hold."""
    return re.sub(r"[\x00-\x08\x0a-\x1f\x7f\ud800-\udfff]+", " ", text)
