"""What differs between two inspections: physical fields, frequencies, stable steps, findings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ..reports.words import number
from .inspection import Inspection, ModelFinding
from .mujoco.fields import physical_fields

EQUAL = 1e-9
"""Share by which numbers of the file may differ in rounding."""

ALIKE = 1e-6
"""The same for what is computed of differences of forces."""

LONG, FEW = 9, 6
"""Numbers of a field from which on only those are shown that differ, and so many of them."""

Value = object
Row = tuple[str, Value, Value]


@dataclass(frozen=True)
class ModelDifference:
    """What differs: ``rows`` of (what, before, now), and findings that are new or gone."""

    rows: tuple[Row, ...]
    new: tuple[ModelFinding, ...]
    gone: tuple[ModelFinding, ...]

    def __bool__(self) -> bool:
        """Return whether anything differs."""
        return bool(self.rows or self.new or self.gone)


def model_difference(old: Inspection, new: Inspection) -> ModelDifference:
    """Return what differs between two inspections of what is meant to be one model."""
    before, now = ({(f.rule, f.element) for f in one.unwaived} for one in (old, new))
    return ModelDifference(
        rows=tuple(rows_of(old, new)),
        new=tuple(f for f in new.unwaived if (f.rule, f.element) not in before),
        gone=tuple(f for f in old.unwaived if (f.rule, f.element) not in now),
    )


def rows_of(old: Inspection, new: Inspection) -> Iterator[Row]:
    """Yield what differs in numbers: (what, before, now)."""
    before, now = (physical_fields(one.loaded) for one in (old, new))
    for label in dict.fromkeys((*before, *now)):
        if label in before and label in now:
            yield from changes(label, before[label], now[label])
        else:
            yield (label, "there", "gone") if label in before else (label, "not there", "new")
    yield from changes("largest stable step,", limits_of(old), limits_of(new), ALIKE)
    yield from changes("state", frequencies_of(old), frequencies_of(new), ALIKE)


def limits_of(one: Inspection) -> dict[str, Value]:
    """Return the largest stable step of each integrator [s]."""
    return {f"{limit.integrator} [s]": limit.limit for limit in one.steps}


def frequencies_of(one: Inspection) -> dict[str, Value]:
    """Return the circular frequencies of the modes in each state, ascending [rad/s]."""
    return {
        f"{view.state.name}, mode {i} [rad/s]": mode.omega
        for view in one.views
        for i, mode in enumerate((m for m in view.modes if m.kind != "rigid"), 1)
    }


def changes(
    what: str, old: Mapping[str, Value], new: Mapping[str, Value], rel: float = EQUAL
) -> Iterator[Row]:
    """Yield the values that differ, of keys that both have, and keys that one has."""
    for key in dict.fromkeys((*old, *new)):
        before, now = old.get(key), new.get(key)
        if not same(before, now, rel):
            if isinstance(before, list) and isinstance(now, list) and len(now) > LONG:
                pairs = [p for p in zip(before, now, strict=False) if not same(*p, rel)][:FEW]
                before, now = zip(*pairs, strict=True) if pairs else (len(before), len(now))
            cells = shown_as(before), shown_as(now)
            if cells[0] == cells[1]:
                cells = shown_as(before, 12), shown_as(now, 12)
            yield (f"{what} {key}".strip(), *cells)


def same(one: Value, other: Value, rel: float) -> bool:
    """Return whether two values are equal, numbers to rounding."""
    if isinstance(one, tuple | list) and isinstance(other, tuple | list):
        size = max((abs(x) for x in (*one, *other) if isinstance(x, float)), default=0.0)
        return len(one) == len(other) and all(
            same(a, b, rel) or (isinstance(a, float) and abs(a - b) <= rel * size)
            for a, b in zip(one, other, strict=True)
        )
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=rel)
    return one == other


def shown_as(value: Value, digits: int = 6) -> str:
    """Return a value in a cell."""
    if isinstance(value, tuple | list):
        return " ".join(shown_as(one, digits) for one in value)
    if value is None:
        return "-"
    if isinstance(value, float) and math.isinf(value):
        return "no limit"
    return number(value, digits) if isinstance(value, float) else str(value)
