"""The ledger of a paper as data: figures, and rows that state what is printed or claimed."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Any, Literal

import numpy as np

from .equations import Identities
from .session import Session

REPRODUCED = "reproduced"
UNCONVERGED = "reproduced, unconverged"
"""By the paper's own truncation; what it converges to is another number."""
CORRECTED = "reproduced with a corrected equation"
NOT_REPRODUCED = "not reproduced"
DEPENDS = "depends on what is not printed"
OPEN = "open"
"""Hangs on a limit that is ours, by less than `MARGIN` of it."""
NOT_TESTABLE = "not testable"
ERROR = "error"
"""Of a row that could not be judged: a fault of ours or of an engine, not of the paper."""
READ = ""
"""Of a reading, which is judged by nobody and not counted."""

VERDICTS = (REPRODUCED, UNCONVERGED, CORRECTED, NOT_REPRODUCED, DEPENDS, OPEN, NOT_TESTABLE)

MARGIN = 0.05
"""Share of a limit that we chose within which it decides nothing."""

KINDS = ("number", "claim", "misprint", "reading")

Numbers = Mapping[str, Any]
"""What a measure returns by name: numbers, arrays of them, or a word such as a class."""


@dataclass(frozen=True)
class PaperFigure:
    """One figure of a paper, drawn again.

    Attributes
    ----------
    number : int
        As in the paper.
    title : str
        What it shows, in our own words.
    caption : str
        What is drawn and with which choices, where the text leaves them open; how the engines
        compare.
    draw : callable ``(Session) -> matplotlib PaperFigure``
    """

    number: int
    title: str
    caption: str
    draw: Callable[[Session], Any]


def half_unit(printed: str) -> float:
    """Return half a unit of the last digit of a printed number: what rounding may hide.

    >>> half_unit("3.10")
    0.005
    """
    exponent = Decimal(printed.split()[0]).as_tuple().exponent
    assert isinstance(exponent, int)
    return float(Decimal(1).scaleb(exponent)) / 2


def rounds_to(value: Any, printed: str) -> bool:
    """Return whether a number, or each of several, rounds to a printed one."""
    off = np.abs(value - float(printed.split()[0]))
    return bool(np.all(off <= half_unit(printed) * (1 + 1e-9)))


RELATIONS: Mapping[str, Callable[[Any, Any], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "rounds to": rounds_to,
}


PRINTED = "printed"


@dataclass(frozen=True)
class Condition:
    """A relation between a measured number and a limit; of an array, all elements must satisfy it.

    Attributes
    ----------
    name : str
        Of the number.
    relation : str
        One of `RELATIONS`.
    limit : float or str
        A number, a word, or `PRINTED`, which stands for the row's printed number.
    everyone : bool
        Whether the engines' numbers must satisfy it too.
    ours : bool
        Whether the limit is ours, and neither printed nor derived: see `MARGIN`.
    """

    name: str
    relation: str
    limit: float | str | bool
    everyone: bool = False
    ours: bool = False

    def holds(self, numbers: Numbers, printed: str = "") -> bool:
        """Return whether it is satisfied; NaN satisfies nothing."""
        limit = printed if self.limit == PRINTED else self.limit
        return bool(np.all(RELATIONS[self.relation](np.asarray(numbers[self.name]), limit)))

    def compared(self, numbers: Numbers, printed: str = "") -> tuple[float, float, float] | None:
        """Return the number, the limit, and the distance to it, on its right side if positive.

        Of several the one that is nearest to breaking the condition, or breaks it most. Words
        and truth values have none.
        """
        values = np.asarray(numbers[self.name])
        limit = printed.split()[0] if self.limit == PRINTED else self.limit
        if values.dtype.kind not in "fiu" or isinstance(limit, bool):
            return None
        bound = float(limit)
        sides = {"<": bound - values, ">": values - bound}
        room = half_unit(printed) if self.relation == "rounds to" else 0.0
        distances = np.ravel(sides.get(self.relation[0], room - np.abs(values - bound)))
        worst = int(np.argmin(distances))
        return float(np.ravel(values)[worst]), bound, float(distances[worst])

    def is_close(self, numbers: Numbers, printed: str = "") -> bool:
        """Return whether the limit is ours, and too close to the number to decide by."""
        triple = self.compared(numbers, printed) if self.ours else None
        return triple is not None and abs(triple[2]) <= MARGIN * abs(triple[1])


Judgement = Mapping[str, tuple[Condition, ...]]
"""Conditions of a verdict: the first verdict whose conditions all hold is that of the row, and
`NOT_REPRODUCED` if there is none."""


@dataclass(frozen=True)
class Erratum:
    """A misprint, as its authors would want it told; where and what it is, the row says.

    Attributes
    ----------
    corrected : str
        the formula as it should be
    why : str
        why
    effect : str
        what it does to the paper's results
    copy : str
        why our copy of the text may be at fault, if it may
    equations : tuple of str
        what is to be changed: equations, a table, a place in the text
    kind : str
        a fault of `print`, of `reasoning`, or of `wording` or a symbol
    """

    corrected: str = ""
    why: str = ""
    effect: str = "none"
    copy: str = ""
    equations: tuple[str, ...] = ()
    kind: Literal["print", "reasoning", "wording"] = "print"


@dataclass(frozen=True)
class Cause:
    """What several rows of a paper have in common that do not hold as printed.

    Attributes
    ----------
    name : str
        unique in its scene
    summary : str
        what it is
    rows : tuple of str
        names of the rows that share it
    """

    name: str
    summary: str
    rows: tuple[str, ...]


@dataclass(frozen=True)
class Printed:
    """A printed number.

    Attributes
    ----------
    value : float
        as printed, in the unit
    tolerance : float
        half a unit of its last digit
    unit : str
        unit; empty for a pure number
    """

    value: float
    tolerance: float
    unit: str


@dataclass(frozen=True)
class LedgerRow:
    """One printed number, qualitative claim, misprint, or open reading.

    Without conditions its verdict is the expected one. Templates (``reason``, ``reference``,
    ``engines`` and the ``candidates``) are filled in with the measured numbers by `assess.fill`.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    name : str
        Unique in its scene: ``case_1_speed``.
    section : str
        Where it stands: ``5.2, case 1``, ``equation (21)``, ``figure 3``.
    claim : str
        What the paper says, in our own words.
    verdict : str
        The one that is expected, of `VERDICTS`; `READ` of a reading.
    reason : str
        Template of the line that says why, with numbers.
    numbers : callable ``(Session) -> Numbers``, optional
        What the reference alone measures.
    each : callable ``(Session, str) -> Numbers or number``, optional
        What the reference and every engine measure; a bare number is called ``value``.
    reference, engines : str
        Templates of our value by the reference and by an engine, with units; that of the engines
        is the reference's by default.
    judgement : mapping of str to tuple of Condition
    printed : str
        The value as printed, with its unit; empty for a claim in words.
    candidates : mapping of str to str
        Of a reading that the text leaves open: each candidate, and what it gives.
    erratum : Erratum, optional
        Of a misprint.
    slow : bool
        Takes more than two seconds.
    equations : Identities, optional
        Equations as printed, corrected and derived; their errors are among the row's numbers.
    """

    kind: Literal["number", "claim", "misprint", "reading"]
    name: str
    section: str
    claim: str
    verdict: str
    reason: str = ""
    numbers: Callable[[Session], Numbers] | None = None
    each: Callable[[Session, str], Any] | None = None
    reference: str = ""
    engines: str = ""
    judgement: Judgement = field(default_factory=dict)
    printed: str = ""
    candidates: Mapping[str, str] = field(default_factory=dict)
    erratum: Erratum | None = None
    slow: bool = False
    equations: Identities | None = None

    @property
    def quantity(self) -> Printed | None:
        """Return the printed number, if the row is judged by one."""
        conditions = (item for verdict in self.judgement.values() for item in verdict)
        if not any(item.limit == PRINTED for item in conditions):
            return None
        digits, _, unit = self.printed.partition(" ")
        return Printed(float(digits), half_unit(digits), unit)

    @property
    def is_text(self) -> bool:
        """Return whether nothing is computed."""
        return self.numbers is None and self.each is None and self.equations is None
