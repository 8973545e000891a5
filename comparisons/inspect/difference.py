"""What differs between two inspections: parts, options, frequencies, stable steps, findings."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from ..reports.words import number
from .findings import ModelFinding
from .inspection import Inspection

EQUAL = 1e-9
"""Share by which numbers of the file may differ in rounding."""

ALIKE = 1e-6
"""The same for what is computed of differences of forces."""

JOINT = ("kind", "axis", "stiffness", "damping", "armature", "range")
BODY = ("parent", "mass", "centre", "inertia")
"""What is compared of a joint and of a body."""

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
    yield from changes("option", vars(old.facts.options), vars(new.facts.options))
    yield from changes("number of", old.facts.counts, new.facts.counts)
    yield from changes("", {"mass": old.facts.mass}, {"mass": new.facts.mass})
    bodies = [{body.name: body for body in one.facts.bodies} for one in (old, new)]
    yield from apart("body", bodies[0], bodies[1])
    for name in (name for name in bodies[0] if name in bodies[1]):
        one, other = (fields_of(each[name], BODY) for each in bodies)
        yield from changes(f"body {name}", one, other)
    joints = [
        {joint.name: joint for body in one.facts.bodies for joint in body.joints}
        for one in (old, new)
    ]
    yield from apart("joint", joints[0], joints[1])
    for name in (name for name in joints[0] if name in joints[1]):
        one, other = (fields_of(each[name], JOINT) for each in joints)
        yield from changes(f"joint {name}", one, other)
    yield from changes("largest stable step,", limits_of(old), limits_of(new), ALIKE)
    yield from changes("state", frequencies_of(old), frequencies_of(new), ALIKE)


def fields_of(facts: object, names: Sequence[str]) -> dict[str, Value]:
    """Return some fields by their names."""
    return {name: getattr(facts, name) for name in names}


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


def apart(kind: str, old: Iterable[str], new: Iterable[str]) -> Iterator[Row]:
    """Yield the names that only one of two has."""
    before, now = list(old), list(new)
    yield from ((f"{kind} {name}", "there", "gone") for name in before if name not in now)
    yield from ((f"{kind} {name}", "not there", "new") for name in now if name not in before)


def changes(
    what: str, old: Mapping[str, Value], new: Mapping[str, Value], rel: float = EQUAL
) -> Iterator[Row]:
    """Yield the values that differ, of keys that both have, and keys that one has."""
    for key in dict.fromkeys((*old, *new)):
        before, now = old.get(key), new.get(key)
        if not same(before, now, rel):
            yield (f"{what} {key}".strip(), shown_as(before), shown_as(now))


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


def shown_as(value: Value) -> str:
    """Return a value in a cell."""
    if isinstance(value, tuple | list):
        return " ".join(map(shown_as, value))
    if value is None:
        return "-"
    if isinstance(value, float) and math.isinf(value):
        return "no limit"
    return number(value, 6) if isinstance(value, float) else str(value)
