"""A trajectory that was computed elsewhere: a file of named columns, read and checked."""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...reference.errors import UsageError
from ...reference.scene import Array
from ..documents.reading import STDIN, read_document

TIME = ("t", "time")
"""Names of the column of times, in small letters."""

SECONDS = ("s", "sec", "seconds", "")

DELIMITERS = {",": "commas", ";": "semicolons", "\t": "tabs"}
"""Separators in the order in which a header is searched for them; by default blanks."""

UNIT = re.compile(r"(?P<name>.*?)\s*[\[(]\s*(?P<unit>[^\])]*?)\s*[\])]")
"""A column's name with its unit: ``theta [rad]`` or ``theta (rad)``."""

DIGIT_ROWS = 400
"""Number of rows by which the digits of a file are counted."""

LONGEST_NAME = 500
"""Longest name of a column; a longer one shows that a file has no columns."""

FULL = 15
"""So many significant digits, or more, count as full precision."""


@dataclass(frozen=True)
class Recording:
    """Times and named columns.

    Attributes
    ----------
    name : str
        Name of the file, without its folder and ending.
    times : array (n_t,)
        Increasing [s].
    columns : mapping of str to array (n_t,)
        May hold NaN.
    units : mapping of str to str
        Units of those columns that have one.
    """

    name: str
    times: Array
    columns: Mapping[str, Array]
    units: Mapping[str, str] = field(default_factory=dict)

    def rounding(self, values: Array) -> float:
        """Return half a unit in the last place with which values (n_t,) are written.

        All columns of a file are taken to be written alike, with as many decimals or as many
        significant digits as the longest number has, whichever is coarser.
        """
        columns = (self.times, *self.columns.values())
        decimals, digits = np.max([written(column) for column in columns], axis=0)
        largest = float(np.max(np.abs(values), initial=0.0, where=np.isfinite(values)))
        if digits >= FULL or not largest:
            return 0.0
        significant = math.floor(math.log10(largest)) + 1 - digits
        return float(0.5 * 10.0 ** max(-decimals, significant))


def written(values: Array) -> tuple[int, int]:
    """Return with how many decimals and significant digits values (n_t,) are written."""
    some = values[:: max(1, len(values) // DIGIT_ROWS)]
    words = [f"{value!r}" for value in some[np.isfinite(some)].tolist()]
    parts = [word.partition("e") for word in words]
    decimals = [len(m.partition(".")[2].rstrip("0")) - int(e or 0) for m, _, e in parts]
    digits = [len(m.replace(".", "").lstrip("-0").rstrip("0")) for m, _, _ in parts]
    return max(decimals, default=0), max(digits, default=0)


def recording(data: Any) -> Recording:
    """Return a recording of a file's name, or of arrays by name.

    Raises
    ------
    UsageError
        If it is none.
    """
    if isinstance(data, Mapping):
        return from_arrays(data)
    if isinstance(data, str | Path):
        return from_file(str(data))
    raise UsageError(f"a trajectory is a file, or arrays by name, not {type(data).__name__}")


def from_arrays(data: Mapping[str, Any]) -> Recording:
    """Return a recording of ``{"t": times, name: values}``.

    Raises
    ------
    UsageError
        If these are not rows of numbers, all of one length, with increasing times.
    """
    arrays = {}
    for name, values in data.items():
        try:
            arrays[str(name)] = np.asarray(values, dtype=float)
        except (TypeError, ValueError):
            raise UsageError(f"trajectory: {name} must be numbers") from None
        if arrays[str(name)].ndim != 1:
            raise UsageError(f"trajectory: {name} must be one row of numbers")
    lengths = {len(values) for values in arrays.values()}
    if len(lengths) > 1:
        counts = ", ".join(f"{name} {len(values)}" for name, values in arrays.items())
        raise UsageError(f"trajectory: columns differ in length: {counts}")
    names, units, times = named(list(arrays), "trajectory")
    columns = dict(zip(names, arrays.values(), strict=True))
    refuse_disorder(columns[times], "trajectory", lambda row: f"row {row}")
    return Recording("trajectory", columns.pop(times), columns, units)


def from_file(name: str) -> Recording:
    """Read a file of named columns, or standard input for ``-``.

    The first line names the columns, ``t`` among them, each with its unit if it likes to:
    ``theta [rad]``. It may begin with ``#``, as may comments. Columns are separated by commas,
    semicolons, tabs or blanks.

    Raises
    ------
    UsageError
        If it cannot be read, naming the line.
    """
    where = "standard input" if name == STDIN else name
    text, _ = read_document(name, "text in UTF-8: write it as CSV", str, label=where)
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    try:
        head, names, delimiter = header(lines, where)
        heads, units, times = named(names, where)
        rows = numbers(lines, head, names, delimiter, where)
    except csv.Error as error:  # a cell is longer than any number or name
        raise UsageError(f"{where}: {error}") from None
    columns, places = dict(zip(heads, np.array([*rows.values()]).T, strict=True)), list(rows)
    refuse_disorder(columns[times], where, lambda row: f"line {places[row]}")
    stem = "stdin" if name == STDIN else Path(name).stem
    return Recording(stem, columns.pop(times), columns, units)


def header(lines: Sequence[str], where: str) -> tuple[int, list[str], str | None]:
    """Return the number of the line that names the columns, the names, and what separates them.

    It is the first line without a comment or, if that has numbers, the comment before it.

    Raises
    ------
    UsageError
        If there is none.
    """
    comment = None
    for number, line in enumerate(lines):
        text = line.strip()
        if text.startswith("#"):
            comment = number if text.strip("# ") else comment
        elif text:
            cells, delimiter = split(text)
            if not all(map(is_number, cells)):
                return number, cells, delimiter
            if comment is None:
                break
            return comment, *split(lines[comment].strip().lstrip("# "))
    else:
        raise UsageError(f"{where} is empty: it needs a line that names the columns, and numbers")
    raise UsageError(f"{where} line {number + 1}: the first line must name the columns, as t,theta")


def split(line: str) -> tuple[list[str], str | None]:
    """Return the cells of a line, and what separates them: None for blanks."""
    delimiter = next((mark for mark in DELIMITERS if mark in line), None)
    names = cells_of(line, delimiter)
    return names[:-1] if not names[-1] else names, delimiter


def cells_of(line: str, delimiter: str | None) -> list[str]:
    """Return the cells of a line."""
    cells = next(csv.reader([line], delimiter=delimiter)) if delimiter else line.split()
    return [cell.strip().strip('"') for cell in cells]


def is_number(word: str) -> bool:
    """Return True if a word is a number."""
    try:
        float(word)
    except ValueError:
        return False
    return True


def numbers(
    lines: Sequence[str], head: int, names: Sequence[str], delimiter: str | None, where: str
) -> dict[int, list[float]]:
    """Return the numbers below a header, by the number of their line.

    Raises
    ------
    UsageError
        If there are none, a line has more or fewer cells than the header, or a cell is no number.
    """
    rows = {}
    for number, line in enumerate(lines[head + 1 :], start=head + 2):
        text = line.partition("#")[0].strip()
        if not text:
            continue
        cells = cells_of(text, delimiter)
        if len(cells) == len(names) + 1 and not cells[-1]:
            cells.pop()
        if len(cells) != len(names):
            marks = DELIMITERS.get(delimiter or "", "blanks")
            raise UsageError(
                f"{where} line {number}: {len(cells)} numbers, but the header names {len(names)} "
                f"columns ({', '.join(names)}); {marks} separate them"
            )
        try:
            rows[number] = [float(cell) for cell in cells]
        except ValueError:
            name, cell = next(
                one for one in zip(names, cells, strict=True) if not is_number(one[1])
            )
            hint = "; decimals need a point" if is_number(cell.replace(",", ".")) else ""
            raise UsageError(
                f"{where} line {number}: {name} is {cell!r}, which is no number{hint}"
            ) from None
    if not rows:
        raise UsageError(f"{where} has a header and no numbers below it")
    return rows


def named(heads: Sequence[str], where: str) -> tuple[list[str], dict[str, str], str]:
    """Return the names of columns, the units of those that have one, and the name of the times.

    Raises
    ------
    UsageError
        If a name stands twice, or no column holds times in seconds.
    """
    names, units = list[str](), dict[str, str]()
    if max(map(len, heads), default=0) > LONGEST_NAME:
        raise UsageError(f"{where}: a column's name has more than {LONGEST_NAME} characters")
    for head in heads:
        parts = UNIT.fullmatch(head)
        names.append(parts["name"] if parts else head)
        if parts:
            units[names[-1]] = parts["unit"]
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise UsageError(f"{where}: two columns are named {twice[0]!r}")
    times = next((name for name in names if name.lower() in TIME), None)
    if times is None:
        raise UsageError(
            f"{where}: no column is named t; found: {', '.join(map(repr, names)) or 'nothing'} "
            "(commas, semicolons, tabs or blanks separate columns)"
        )
    if units.pop(times, "s") not in SECONDS:
        raise UsageError(f"{where}: times must be in seconds: {heads[names.index(times)]}")
    return names, units, times


def refuse_disorder(times: Array, where: str, place_of: Callable[[int], str]) -> None:
    """Refuse times that are not finite or do not increase.

    Raises
    ------
    UsageError
        Naming the place by ``place_of``, from the number of a row.
    """
    if not times.size:
        raise UsageError(f"{where} is empty")
    wrong = np.flatnonzero(~np.isfinite(times))
    if wrong.size:
        raise UsageError(f"{where} {place_of(int(wrong[0]))}: t is {times[wrong[0]]}")
    wrong = np.flatnonzero(np.diff(times) <= 0)
    if wrong.size:
        before, after = times[wrong[0]], times[wrong[0] + 1]
        what = "stands twice" if before == after else f"comes after {before:.12g}"
        raise UsageError(
            f"{where} {place_of(int(wrong[0]) + 1)}: t = {after:.12g} {what}; times must increase "
            "(write more digits, or leave repeated rows out)"
        )
