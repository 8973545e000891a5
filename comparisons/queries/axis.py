"""Axes over parameters, of maps and windows."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, fields
from typing import Self

from ...reference.errors import UnknownNameError, UsageError
from ..documents.fields import number_from


@dataclass(frozen=True)
class ParameterRange:
    """A parameter, and its range on an axis.

    Raises
    ------
    UsageError
        If it is none.
    """

    name: str
    low: float
    high: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise UsageError(
                f"axis {self.name}: it must go from a lower to a higher finite number, not from "
                f"{self.low!r} to {self.high!r}"
            )

    @classmethod
    def parse(cls, text: str, flag: str) -> Self:
        """Return the axis of ``NAME=LO:HI``, or of ``NAME=LO:HI:N`` where it has a count.

        Raises
        ------
        UsageError
            If the text is none.
        """
        counts = [item.name for item in fields(cls)][3:]
        form = ":".join(["NAME=LO:HI", *("N" for _ in counts)])
        rule = " with a whole number N" if counts else ""
        name, equals, words = (part.strip() for part in text.partition("="))
        low, colon, rest = words.partition(":")
        high, *count = rest.split(":")
        whole = all(re.fullmatch(r" *[0-9]{1,9} *", word) for word in count)
        if not (name and equals and colon and len(count) == len(counts) and whole):
            raise UsageError(f"{flag} needs {form}{rule}, not {text!r}")
        ends = (number_from(word, f"{flag} {name}: a bound") for word in (low, high))
        return cls(name, *ends, *map(int, count))


def refuse_axes(
    what: str, x: ParameterRange, y: ParameterRange, names: Sequence[str], fixed: Collection[str]
) -> None:
    """Refuse axes that span no plane of parameters.

    Parameters
    ----------
    what : str
        The map or window of these axes, for messages.
    x, y : ParameterRange
    names : sequence of str
        Known parameters.
    fixed : collection of str
        Parameters with a value given elsewhere.

    Raises
    ------
    UsageError
    """
    if x.name == y.name:
        raise UsageError(f"both axes are {x.name}: {what} needs two parameters")
    for axis in (x, y):
        if axis.name not in names:
            raise UnknownNameError(f"axis of {what}", axis.name, names)
        if axis.name in fixed:
            raise UsageError(f"{axis.name} is on an axis, and cannot be set as well")
