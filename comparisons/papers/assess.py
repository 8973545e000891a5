"""How a row is assessed: numbers measured, conditions tested, templates filled."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from string import Formatter
from typing import Any, TypeVar

import numpy as np

from ...reference.errors import EngineError, MbcheckError
from ..documents.fields import Number
from ..engines.registry import REFERENCE
from ..engines.run import describe
from .ledger import (
    NOT_REPRODUCED,
    OPEN,
    PRINTED,
    Condition,
    LedgerRow,
    Numbers,
    RowThreshold,
    half_unit,
)
from .session import Session

T = TypeVar("T")


@dataclass(frozen=True)
class Assessment:
    """Verdict on a row, and the numbers that it rests on.

    Attributes
    ----------
    verdict : str
        the verdict; `error` where we failed, empty for a reading
    reason : str
        why
    reference : str
        our value as text, with its unit
    engines : mapping of str to str
        the same by engine
    candidates : tuple of (str, str)
        of an open reading: each candidate, and what it gives
    thresholds : tuple of RowThreshold
        conditions that decide on the verdict
    values : mapping of str to float
        of a printed number: ours in its unit, by `reference` and by engine
    numbers : mapping of str to mapping of str to float or list
        the numbers in `reason`, `reference` and `engines`, by who has them and by name
    """

    verdict: str
    reason: str
    reference: str = ""
    engines: Mapping[str, str] = field(default_factory=dict)
    candidates: tuple[tuple[str, str], ...] = ()
    thresholds: tuple[RowThreshold, ...] = ()
    values: Mapping[str, float | None] = field(default_factory=dict)
    numbers: Mapping[str, Mapping[str, Number | list[Number] | None]] = field(default_factory=dict)


class Template(Formatter):
    """A formatter of lists and mappings of numbers.

    The elements of arrays and sequences are formatted one by one and joined by commas, those of
    mappings after their names; a truth value without a format is ``yes`` or ``no``.
    """

    def format_field(self, value: Any, format_spec: str) -> str:
        """Return a value in words."""
        if isinstance(value, Mapping):
            return ", ".join(f"{k} {self.format_field(v, format_spec)}" for k, v in value.items())
        if isinstance(value, Sequence | np.ndarray) and not isinstance(value, str):
            nested = any(isinstance(item, Mapping) or np.ndim(item) for item in value)
            separator = "; " if nested else ", "
            return separator.join(self.format_field(item, format_spec) for item in value)
        if isinstance(value, bool | np.bool_) and not format_spec:
            return "yes" if value else "no"
        return value if isinstance(value, str) else str(format(value, format_spec))


def fill(template: str, numbers: Numbers) -> str:
    """Return a template with numbers in it.

    >>> fill("{speed:.1f} rad/s; {shares:.0%}; {falls}",
    ...      {"speed": [1.0, 2.0], "shares": {"rest": 0.25}, "falls": True})
    '1.0, 2.0 rad/s; rest 25%; yes'
    """
    return Template().vformat(template, (), numbers).strip()


def numbers_in(template: str, numbers: Numbers) -> dict[str, Any]:
    """Return the numbers that a template is filled in with, by name; those of a mapping by key.

    >>> numbers_in("{speed:.1f} rad/s; {shares:.0%}; {falls}",
    ...            {"speed": [1.0, 2.0], "shares": {"rest": 0.25}, "falls": True})
    {'speed': [1.0, 2.0], 'shares.rest': 0.25}
    """
    flat: dict[str, Any] = {}
    for place in [place for _, place, _, _ in Formatter().parse(template) if place]:
        name = re.split(r"[.\[]", place)[0]
        value = numbers.get(name)
        parts = value.items() if isinstance(value, Mapping) else ()
        flat |= {f"{name}.{key}": part for key, part in parts} or {name: value}
    arrays = {name: np.asarray(value) for name, value in flat.items()}
    plain = {name: one for name, one in arrays.items() if one.dtype.kind in "fiu" and one.ndim < 2}
    return {name: one.tolist() for name, one in plain.items()}


def assess(row: LedgerRow, session: Session) -> Assessment:
    """Assess a row; without conditions its verdict is the expected one.

    Raises
    ------
    EngineError
        If an engine failed whose numbers the verdict depends on.
    """
    if row.is_text:
        return Assessment(row.verdict, row.reason, row.reference, {}, tuple(row.candidates.items()))
    numbers, engines = measure(row, session)
    able = {name: own for name, own in engines.items() if not isinstance(own, str)}
    template = row.engines or row.reference
    sources = [(REFERENCE, row.reason + row.reference, numbers)]
    sources += [(name, template, own) for name, own in able.items()]
    return Assessment(
        verdict_of(row, numbers, engines) if row.judgement else row.verdict,
        reason_of(row, numbers),
        fill(row.reference, numbers),
        {
            name: own if isinstance(own, str) else fill(template, own)
            for name, own in engines.items()
        },
        tuple((way, fill(result, numbers)) for way, result in row.candidates.items()),
        tuple(
            condition.compare(numbers, row.printed, verdict)
            for verdict, conditions in row.judgement.items()
            for condition in conditions
        ),
        {name: float(own["value"]) for name, _, own in sources if row.quantity},
        {name: used for name, text, own in sources if (used := numbers_in(text, own))},
    )


def measure(row: LedgerRow, session: Session) -> tuple[Numbers, Mapping[str, Numbers | str]]:
    """Return the numbers of a row by the reference and by each engine.

    An engine that fails or does not compute them has words in place of numbers.
    """
    unit = {"unit": row.printed.partition(" ")[2]}
    numbers: dict[str, Any] = dict(unit)
    for call in (row.equations, row.numbers):
        numbers |= call(session) if call is not None else {}
    engines: dict[str, Numbers | str] = {}
    if row.each is not None:
        numbers |= by_name(row.each(session, REFERENCE))
        for name in session.engines:
            try:
                own = row.each(session, name)
            except EngineError as error:
                own = str(error)
            engines[name] = own if isinstance(own, str) else unit | by_name(own)
    return numbers, engines


def by_name(measured: Any) -> dict[str, Any]:
    """Return measured numbers by name; a bare one is called ``value``."""
    return dict(measured) if isinstance(measured, Mapping) else {"value": measured}


def attempt(call: Callable[[], T]) -> tuple[T | None, str]:
    """Return the result of a call and no words, or None and the failure in one line."""
    try:
        return call(), ""
    except MbcheckError as error:
        return None, str(error)
    except Exception as error:  # of an engine or of matplotlib
        return None, describe(error)


def verdict_of(row: LedgerRow, numbers: Numbers, engines: Mapping[str, Numbers | str]) -> str:
    """Return the first verdict whose conditions hold, or else that the row is not reproduced.

    It is open if the verdict changes with the outcome of conditions whose limits are ours and
    close to the number.
    """

    def satisfied(condition: Condition, close: bool | None) -> bool:
        for own in engines.values() if condition.everyone else ():
            if isinstance(own, str):
                raise EngineError("failed", own)
            if not condition.compare(own, row.printed).holds:
                return False
        threshold = condition.compare(numbers, row.printed)
        return threshold.holds if close is None or not threshold.is_close else close

    def verdict(close: bool | None) -> str:
        for name, conditions in row.judgement.items():
            if all(satisfied(condition, close) for condition in conditions):
                return name
        return NOT_REPRODUCED

    return verdict(None) if verdict(True) == verdict(False) else OPEN


def reason_of(row: LedgerRow, numbers: Numbers) -> str:
    """Return the reason for a row's verdict, and how far a printed number is off."""
    reason = fill(row.reason, numbers)
    conditions = sum(row.judgement.values(), ())
    if not any(item.limit == PRINTED and item.name == "value" for item in conditions):
        return reason
    printed = row.printed.split()[0]
    off = f"off by {abs(numbers['value'] - float(printed)):.2g}"
    return "; ".join(filter(None, (f"{off}, rounding allows {half_unit(printed):.1g}", reason)))
