"""The ledger of a paper as data: figures, and rows for its printed numbers and its claims."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Any, Literal

import numpy as np

from .equations import Identities
from .session import Session

REPRODUCED = "reproduced"
UNCONVERGED = "reproduced, unconverged"
"""The paper's truncation gives the printed number; the converged number is another one."""
CORRECTED = "reproduced with a corrected equation"
NOT_REPRODUCED = "not reproduced"
DEPENDS = "depends on what is not printed"
OPEN = "open"
"""Our number is within `MARGIN` of a limit that we chose."""
NOT_TESTABLE = "not testable"
ERROR = "error"
"""The row could not be judged: a fault of ours or of an engine, not of the paper."""
READ = ""
"""A reading of the text has no verdict and is not counted."""

VERDICTS = (REPRODUCED, UNCONVERGED, CORRECTED, NOT_REPRODUCED, DEPENDS, OPEN, NOT_TESTABLE)

MARGIN = 0.05
"""A number within this share of a limit that we chose decides nothing."""

KINDS = ("number", "claim", "misprint", "reading")

Numbers = Mapping[str, Any]
"""Results of a measure by name: numbers, arrays of them, or a word such as a class."""


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
    draw : callable ``(Session) -> matplotlib Figure``
    """

    number: int
    title: str
    caption: str
    draw: Callable[[Session], Any]

    @property
    def name(self) -> str:
        """Name among the figures and rows of the paper."""
        return f"figure {self.number}"


def half_unit(printed: str) -> float:
    """Return half a unit of the last digit of a printed number, which rounding may hide.

    >>> half_unit("3.10")
    0.005
    """
    exponent = Decimal(printed.split()[0]).as_tuple().exponent
    assert isinstance(exponent, int)
    return float(Decimal(1).scaleb(exponent)) / 2


@dataclass(frozen=True)
class RowThreshold:
    """A condition on a number, and how far the number is from its limit.

    Attributes
    ----------
    verdict : str
        the verdict whose conditions it is among
    quantity : str
        name of the judged number
    relation : str
        <, <=, >, >=, == or `rounds to`: to the limit
    limit : float or None
        limit; null if it is a word or a truth value
    value : float or None
        our number, of several the one nearest to breaking the condition; null as above
    distance : float or None
        from the limit, on the side that holds where positive; null as above
    holds : bool
        whether the condition holds
    ours : bool
        whether the limit is ours, neither printed nor derived: within 5 % of it the verdict is
        `open`
    """

    verdict: str
    quantity: str
    relation: str
    limit: float | None
    value: float | None
    distance: float | None
    holds: bool
    ours: bool

    @property
    def is_close(self) -> bool:
        """True if the limit is ours, and too close to the number to decide by."""
        if not self.ours or self.limit is None or self.distance is None:
            return False
        return abs(self.distance) <= MARGIN * abs(self.limit)


PRINTED = "printed"


@dataclass(frozen=True)
class Condition:
    """A relation between a measured number and a limit; of an array, all elements must satisfy it.

    Attributes
    ----------
    name : str
        Name of the number.
    relation : str
        <, <=, >, >=, == or ``rounds to``.
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

    def compare(self, numbers: Numbers, printed: str = "", verdict: str = "") -> RowThreshold:
        """Compare the number with the limit; NaN satisfies nothing."""
        values = np.ravel(numbers[self.name])
        limit = printed.split()[0] if self.limit == PRINTED else self.limit
        about = (verdict, self.name, self.relation)
        if values.dtype.kind not in "fiu" or isinstance(limit, bool):
            return RowThreshold(*about, None, None, None, bool(np.all(values == limit)), self.ours)
        bound = float(limit)
        room = half_unit(printed) if self.relation == "rounds to" else 0.0
        sides = {"<": bound - values, ">": values - bound}
        distances = sides.get(self.relation[0], room - np.abs(values - bound))
        worst = int(np.argmin(distances))
        distance = float(distances[worst])
        holds = distance > 0 if self.relation in "<>" else distance >= -1e-9 * room
        return RowThreshold(*about, bound, float(values[worst]), distance, holds, self.ours)


Judgement = Mapping[str, tuple[Condition, ...]]
"""Conditions of a verdict: the first verdict whose conditions all hold is that of the row, and
`NOT_REPRODUCED` if there is none."""


@dataclass(frozen=True)
class Erratum:
    """A misprint, as its authors would want it stated; its place and content are the row's.

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
        the places to correct: equations, a table, a place in the text
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
    """The common cause of several rows of a paper that do not hold as printed.

    Attributes
    ----------
    name : str
        unique in its scene
    summary : str
        the cause in one sentence
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
        Place in the paper: ``5.2, case 1``, ``equation (21)``, ``figure 3``.
    claim : str
        The paper's statement, in our own words.
    verdict : str
        The expected one, of `VERDICTS`; `READ` of a reading.
    reason : str
        Template of the line that says why, with numbers.
    numbers : callable ``(Session) -> Numbers``, optional
        Measure of the reference alone.
    each : callable ``(Session, str) -> Numbers or number``, optional
        Measure of the reference and of every engine; a bare number is called ``value``.
    reference, engines : str
        Templates of our value by the reference and by an engine, with units; that of the engines
        is the reference's by default.
    judgement : mapping of str to tuple of Condition
    printed : str
        The value as printed, with its unit; empty for a claim in words.
    candidates : mapping of str to str
        Each way to read what the text leaves open, and its result.
    erratum : Erratum, optional
        The correction of a misprint.
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
        """The printed number, if the row is judged by one."""
        conditions = (item for verdict in self.judgement.values() for item in verdict)
        if not any(item.limit == PRINTED for item in conditions):
            return None
        digits, _, unit = self.printed.partition(" ")
        return Printed(float(digits), half_unit(digits), unit)

    @property
    def is_text(self) -> bool:
        """True if nothing is computed."""
        return self.numbers is None and self.each is None and self.equations is None
