"""Comparison of two maps: agreement, exchanged classes, distances of boundaries."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.ndimage import distance_transform_edt

from ...reference.errors import UnknownNameError, UsageError
from ...reference.scene import Array
from ..documents import document
from ..documents.fields import HIDDEN, documented
from ..scenes.quantity import NO_VALUE
from .request import Axis
from .store import Map

SAME = 1e-9
"""Values of two axes that differ by less than this share of their spacing are the same."""


@dataclass(frozen=True)
class Spread:
    """Median and largest of some numbers.

    Attributes
    ----------
    median, largest : float
        0 without any
    """

    median: float
    largest: float

    @classmethod
    def of(cls, values: Array) -> Spread:
        """Return the spread of numbers (n,)."""
        return cls(*(float(f(values)) if values.size else 0.0 for f in (np.median, np.max)))


@dataclass(frozen=True)
class MapComparison:
    """Two maps on their common points.

    Attributes
    ----------
    variable : str
        the variable of both maps
    unit : str
        its unit; 1 for classes
    classes : tuple of str
        names of the classes; empty for numbers
    x, y : array (n_x,), (n_y,)
        Values on the axes that both maps have.
    one, other : array (n_y, n_x)
        The variable in either map; classes as places in ``classes``, -1 for none.
    compared : bool array (n_y, n_x)
        Computed, with a value, in both.
    robust : bool array (n_y, n_x)
        Robust in both.
    maps : (str, str)
        engine, model and method of either map
    """

    variable: str
    unit: str
    classes: tuple[str, ...]
    x: Array = field(metadata=HIDDEN)
    y: Array = field(metadata=HIDDEN)
    one: Array = field(metadata=HIDDEN)
    other: Array = field(metadata=HIDDEN)
    compared: Any = field(metadata=HIDDEN)
    robust: Any = field(metadata=HIDDEN)
    maps: tuple[str, str]

    @property
    def differs(self) -> Any:
        """Return where the classes differ (n_y, n_x)."""
        return self.compared & (self.one != self.other)

    def share(self, points: Any) -> float | None:
        """Return the share of some points that agree; None without points or classes."""
        return float(np.mean(~self.differs[points])) if self.classes and np.any(points) else None

    @property
    @documented
    def points(self) -> int:
        """Points that both maps computed with a value."""
        return int(np.sum(self.compared))

    @property
    @documented
    def agreement(self) -> float | None:
        """Share of points whose classes agree [1]; null without points, and for numbers."""
        return self.share(self.compared)

    @property
    @documented
    def robust_points(self) -> int:
        """Points that are robust in both maps."""
        return int(np.sum(self.compared & self.robust))

    @property
    @documented
    def robust_agreement(self) -> float | None:
        """Share of these whose classes agree [1]; null without any, and for numbers."""
        return self.share(self.compared & self.robust)

    @property
    @documented
    def confusion(self) -> dict[str, dict[str, int]]:
        """Points by class of the first map, then of the second; empty for numbers."""
        count = len(self.classes)
        pairs = self.one[self.compared] * count + self.other[self.compared]
        numbers = np.bincount(pairs.astype(int) if count else [], minlength=count**2)
        rows = zip(self.classes, numbers.reshape(count, count).tolist(), strict=True)
        return {name: dict(zip(self.classes, row, strict=True)) for name, row in rows}

    @property
    def offsets(self) -> Array:
        """Return, for each point that differs, how far [cells] the boundary would have to move.

        The way from one map's boundary over the point to the other's: to the nearest point
        that has its class of one map in the other, and vice versa, less the point itself.
        The diagonal of the map stands for "nowhere".
        """
        far = np.hypot(*self.one.shape)
        away = np.full(self.one.shape, -1.0)
        for i in range(len(self.classes)):
            for here, there in ((self.one, self.other), (self.other, self.one)):
                distance = distance_transform_edt(there != i) if np.any(there == i) else far
                away += np.where(here == i, distance, 0.0)
        offsets: Array = np.minimum(away, far)[self.differs]
        return offsets

    @property
    def differences(self) -> Array:
        """Return other less one (n,) where both are compared: numbers, angles on the circle."""
        values: Array = (self.other - self.one)[self.compared]
        return np.angle(np.exp(1j * values)) if self.unit == "rad" else values

    @property
    @documented
    def boundary_offset_cells(self) -> Spread | None:
        """Cells by which boundaries would have to move over the points that differ."""
        return Spread.of(self.offsets) if self.classes else None

    @property
    @documented
    def difference(self) -> Spread | None:
        """Absolute difference of numbers [`unit`]; null for classes."""
        return None if self.classes else Spread.of(np.abs(self.differences))

    @property
    @documented
    def relative_difference(self) -> float | None:
        """Largest difference over the largest value of the first map [1]; null for classes."""
        size = float(np.max(np.abs(self.one[self.compared]), initial=0.0))
        off = self.difference
        return None if off is None else off.largest / size if size else 0.0

    def as_json(self) -> dict[str, Any]:
        """Return the ``compare_maps`` document of docs/json.md."""
        return document("compare_maps", self)


def compare(one: Map, other: Map, variable: str | None = None) -> MapComparison:
    """Compare two maps of the same scene and axes on the points that both computed.

    Raises
    ------
    UsageError
        If they are not of the same, or share no point.
    """
    for what in ("scene", "quantity"):
        if one.settings[what] != other.settings[what]:
            raise UsageError(
                f"the maps are not of the same {what}: {one.settings[what]} and "
                f"{other.settings[what]}"
            )
    if (one.x.name, one.y.name) != (other.x.name, other.y.name):
        raise UsageError(
            f"the maps have different axes: {one.x.name}, {one.y.name} and {other.x.name}, "
            f"{other.y.name}"
        )
    variable = variable or one.main_variable
    common = [name for name in one.about if name in other.about]
    if variable not in common:
        raise UnknownNameError("variable of these maps", variable, common)
    columns, rows = shared(one.x, other.x), shared(one.y, other.y)
    if not (columns[0].size and rows[0].size):
        raise UsageError("the maps have no point in common: choose grids that share some")
    here, there = np.ix_(rows[0], columns[0]), np.ix_(rows[1], columns[1])
    values, others = one.variables[variable][here], other.variables[variable][there]
    about = one.about[variable]
    classes = tuple(dict.fromkeys([*about.classes, *other.about[variable].classes]))
    if classes:
        values, others = (
            renumbered(v, m.about[variable].classes, classes)
            for v, m in ((values, one), (others, other))
        )
        valued = (values >= 0) & (others >= 0)
    else:
        valued = np.isfinite(values) & np.isfinite(others)
    return MapComparison(
        variable,
        about.unit,
        classes,
        one.x.values[columns[0]],
        one.y.values[rows[0]],
        values,
        others,
        one.computed[here] & other.computed[there] & valued,
        one.robust[here] & other.robust[there],
        (called(one.settings), called(other.settings)),
    )


def called(settings: Mapping[str, Any]) -> str:
    """Return who computed a map."""
    return " ".join(filter(None, (settings[name] for name in ("engine", "model", "method"))))


def shared(one: Axis, other: Axis) -> tuple[Any, Any]:
    """Return the places of the values that two axes have in common."""
    near = other.nearest(one.values)
    spacing = min(axis.values[1] - axis.values[0] for axis in (one, other))
    same = np.abs(other.values[near] - one.values) < SAME * spacing
    return np.flatnonzero(same), near[same]


def renumbered(values: Any, names: tuple[str, ...], classes: tuple[str, ...]) -> Any:
    """Return places in ``classes`` from places in ``names``; -1 stays."""
    return np.array([*map(classes.index, names), NO_VALUE])[values.astype(int)]
