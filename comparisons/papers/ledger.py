"""What a row of the ledger is: something that a paper prints or claims, and what we find."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .session import Session

REPRODUCED = "reproduced"
CORRECTED = "reproduced with a corrected equation"
NOT_REPRODUCED = "not reproduced"
NOT_TESTABLE = "not testable"
ERROR = "error"
"""Of a row that could not be judged: a fault of ours or of an engine, not of the paper."""

VERDICTS = (REPRODUCED, CORRECTED, NOT_REPRODUCED, NOT_TESTABLE)

KINDS = ("number", "claim", "misprint", "reading")


@dataclass(frozen=True)
class Finding:
    """What became of a row.

    Attributes
    ----------
    verdict : str
        One of `VERDICTS`.
    reason : str
        One line: why, with numbers.
    reference : str
        Our value, by the reference: with its unit.
    engines : mapping of str to str
        The same by each engine that can tell.
    candidates : tuple of (str, str)
        Of a reading that the text leaves open: each candidate, and what it gives.
    """

    verdict: str
    reason: str
    reference: str = ""
    engines: Mapping[str, str] = field(default_factory=dict)
    candidates: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Row:
    """One printed number, qualitative claim, misprint, or open reading.

    Attributes
    ----------
    name : str
        Unique in its scene: ``case_1_speed``.
    kind : str
        One of `KINDS`.
    section : str
        Where it stands: ``5.2, case 1``, ``equation (21)``, ``figure 3``.
    claim : str
        In our own words.
    find : callable ``(Session) -> Finding``
    printed : str
        The value as printed, with its unit; empty for a claim in words.
    test : str
        Of a misprint: the test that shows it, ``tests/test_x.py::test_y``.
    slow : bool
        Takes more than two seconds.
    """

    name: str
    kind: str
    section: str
    claim: str
    find: Callable[[Session], Finding]
    printed: str = ""
    test: str = ""
    slow: bool = False


def half_unit(printed: str) -> float:
    """Return half a unit of the last digit of a printed number: what rounding may hide.

    >>> half_unit("3.10")
    0.005
    """
    exponent = Decimal(printed.split()[0]).as_tuple().exponent
    assert isinstance(exponent, int)
    return float(Decimal(1).scaleb(exponent)) / 2


def number(
    printed: str,
    value: float,
    unit: str = "",
    engines: Mapping[str, float] | None = None,
    because: str = "",
    corrected: bool = False,
    digits: int = 5,
) -> Finding:
    """Compare a number with its printed value: they agree if it rounds to what is printed.

    Parameters
    ----------
    printed : str
        The printed number, without its unit.
    value : float
        By the reference.
    unit : str
    engines : mapping of str to float
        By the engines.
    because : str
        Why it differs, or what was corrected.
    corrected : bool
        Whether an equation of the paper was corrected to get it.
    digits : int
        Significant digits shown.
    """
    off = abs(value - float(printed))
    agrees = off <= half_unit(printed) * (1 + 1e-9)
    verdict = NOT_REPRODUCED
    if agrees:
        verdict = CORRECTED if corrected else REPRODUCED
    reason = f"off by {off:.2g}, rounding allows {half_unit(printed):.1g}"
    return Finding(
        verdict,
        "; ".join(part for part in (reason, because) if part),
        shown(value, unit, digits),
        {name: shown(found, unit, digits) for name, found in (engines or {}).items()},
    )


def claimed(holds: bool, reason: str, corrected: bool = False, **more: Any) -> Finding:
    """Judge a claim in words by a condition that was computed."""
    if not holds:
        return Finding(NOT_REPRODUCED, reason, **more)
    return Finding(CORRECTED if corrected else REPRODUCED, reason, **more)


def shown(value: float, unit: str = "", digits: int = 5) -> str:
    """Return a number with its unit."""
    return f"{value:.{digits}g} {unit}".strip()
