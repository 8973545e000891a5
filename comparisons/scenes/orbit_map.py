"""Periodic orbits of all points of a map: found by Newton's method, and again with half the step.

A scene says where the search starts and what an orbit is measured by. Of several orbits of a point
the most stable one counts; points that have none, or no stable one, start from neighbours.
Two runs are compared: a class is robust where both have it, and the error of a number is bounded by
twice the change with half the step, plus the displacement of the orbit by round-off.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...reference.differences import balanced_step
from ...reference.newton import Effort
from ...reference.orbits import Orbits, PeriodMap, period_advance, section_row
from ...reference.scene import Array
from ..engines.registry import REFERENCE
from .bounds import difference, eigenvalue_bounds, leading_change, rounding_displacement
from .quantity import Flow

Ints = NDArray[np.int_]

Starts = Callable[["OrbitMap", Orbits], Iterable[tuple[Ints, Array]]]
"""Function of a map and the orbits known so far that yields points (m,) and states (2 n, m) from
which their orbits are sought; later ones may depend on the results of earlier ones."""


class OrbitMapOptions(NamedTuple):
    """How orbits are sought, and distinguished.

    Attributes
    ----------
    search, again : Effort
        Of Newton's method: from a start, and from an orbit to that of half the step.
    forward, central : float
        Steps of differences, in the size of each state.
    twins : tuple of float
        Distances, in the size of each state, at which an orbit is looked for beside an unstable one
        whose multiplier exceeds 1 by 1 or more; nearer to 1 twins part as the root of that excess.
    max_twin_multiplier : float
        Largest multiplier beside whose orbit stable twins are looked for.
    max_period_ratio : float
        Largest ratio of an orbit's period to the guess, where the period is unknown.
    max_distance : int
        Columns or rows to a stable neighbour that a point with an unstable orbit starts from.
    margin : float
        Distance from 1 of the leading multiplier of a robust class.
    """

    search: Effort = Effort(jacobians=9, chords=1)
    again: Effort = Effort(jacobians=4, chords=4)
    forward: float = balanced_step(1, rounding=1e-13)
    central: float = balanced_step(2, rounding=1e-14, roughness=1e3)
    twins: tuple[float, ...] = (0.1, 0.06, 0.15)
    max_twin_multiplier: float = 5.0
    max_period_ratio: float = 2.0
    max_distance: int = 2
    margin: float = 1e-4


OPTIONS = OrbitMapOptions()


class OrbitNumber(NamedTuple):
    """A number of orbits (m,).

    Attributes
    ----------
    value : array (m,)
    profile : array (m, n)
        Values that it is computed from: a number may agree by chance, its profile does not.
    unit : float or array (m,)
        What a displacement by the size of the states changes it by.
    left_out : float or array (m,)
        Bound on what sampling leaves out.
    turn : float
        Its period, of an angle.
    """

    value: Array
    profile: Any
    unit: Any = 1.0
    left_out: Any = 0.0
    turn: float = np.inf

    def change(self, other: OrbitNumber) -> Array:
        """Return a bound (m,) on the error that another run, with half the step, shows."""
        change = np.abs(other.value - self.value)
        off = np.sqrt(np.mean(np.abs(other.profile - self.profile) ** 2, axis=1))
        return difference(self.value, self.value + np.minimum(change, self.turn - change)) + off


Measure = Callable[["OrbitMap", Ints, Orbits, int], Mapping[str, OrbitNumber]]
"""Function of a map, points, orbits and the divisor of the step: the numbers of the orbits."""


@dataclass(frozen=True)
class OrbitMap:
    """The period maps of the points of a map.

    Attributes
    ----------
    flow : Flow
    periods : array (k,)
        Of the drive, or guesses [s].
    scale : array (2 n, k)
        Size of each state.
    steps : int array (k,)
        In a period.
    """

    flow: Flow
    periods: Array
    scale: Array
    steps: Ints

    @property
    def by_reference(self) -> bool:
        """Whether the reference takes the steps, which complex steps linearise."""
        return self.flow.points.engine == REFERENCE

    def about(self, which: Ints, states: Array, periods: Array, finer: int = 1) -> PeriodMap:
        """Return the period map of some points about a guess (2 n, m) of each."""

        def advance(rows: Ints, starts: Array, spans: Array) -> Array:
            steps = finer * self.steps[which[rows]]
            return self.flow(which[rows], starts, 0.0, spans, 1, steps)[..., 0]

        scene = self.flow.scene
        return PeriodMap(
            flow=advance,
            states=states,
            periods=periods,
            scale=self.scale[:, which],
            advance=period_advance(scene),
            section=section_row(scene),
            order=1,
            step=OPTIONS.forward,
        )

    def exact(self, which: Ints, orbits: Orbits, finer: int) -> Orbits:
        """Return orbits with slopes by complex steps, or an engine's by central differences.

        Those whose neighbours are lost do not count as closed.
        """
        about = self.about(which, orbits.states, orbits.periods, finer)
        about = replace(about, order=None if self.by_reference else 2, step=OPTIONS.central)
        with np.errstate(all="ignore"):
            slopes = about.linearise(np.arange(len(which)), 0 * orbits.states)[1]
        known = np.all(np.isfinite(slopes), axis=(1, 2))
        slopes[~known] = 0.0
        return replace(orbits, slopes=slopes, closed=orbits.closed & known)

    # The search -------------------------------------------------------------------------------

    def search(self, starts: Starts) -> Orbits:
        """Return the most stable orbit of each point."""
        (n, count), section = self.scale.shape, section_row(self.flow.scene)
        columns = np.arange(n)
        if section is not None:
            columns[section] = n
        known = Orbits(
            states=np.full((n, count), np.nan),
            periods=np.array(self.periods),
            closed=np.zeros(count, dtype=bool),
            correction=np.full(count, np.inf),
            slopes=np.zeros((count, n, n + (section is not None))),
            scale=self.scale.copy(),
            columns=columns,
        )
        for which, states in chain(starts(self, known), twins(self, known)):
            self.improve(known, which, states, self.periods[which])
        tried = np.full(count, -1)
        while True:
            source = sources(known, self.flow.points.places)
            which = np.flatnonzero((source >= 0) & (source != tried))
            if not which.size:
                return known
            tried[which] = source[which]
            near = known.at(source[which])
            periods = self.periods[which] if section is None else near.periods
            self.improve(known, which, near.states, periods, from_neighbours=True)

    def improve(
        self,
        known: Orbits,
        which: Ints,
        states: Array,
        periods: Array,
        from_neighbours: bool = False,
    ) -> None:
        """Take the orbits that Newton's method leads to from states (2 n, m) where they are better.

        From neighbours, only orbits of points without one, and stable ones.
        """
        usable = np.array([i not in self.flow.problems for i in which.tolist()], dtype=bool)
        which, states, periods = which[usable], states[:, usable], periods[usable]
        if not which.size:
            return
        reached = self.about(which, states, periods).close(OPTIONS.search)
        with np.errstate(all="ignore"):
            near = np.abs(np.log2(reached.periods / periods)) < np.log2(OPTIONS.max_period_ratio)
            reached = replace(reached, closed=reached.closed & near)
            better = reached.leading < known.at(which).leading
            if from_neighbours:
                better = reached.closed & ((reached.leading < 1) | ~known.closed[which])
        known.put(which[better], reached.at(better))

    def again(self, which: Ints, orbits: Orbits) -> Orbits:
        """Return the orbits that others go over into with half the step."""
        about = self.about(which, orbits.states, orbits.periods, finer=2)
        return about.close(OPTIONS.again, orbits.slopes)

    # What is known ----------------------------------------------------------------------------

    def values(
        self,
        orbits: Orbits,
        measure: Measure,
        class_of: Callable[[Mapping[str, Array]], Ints],
        none: int,
    ) -> dict[str, Array]:
        """Return ``class``, ``robust``, the numbers of orbits and ``multiplier``, and their bounds.

        Parameters
        ----------
        orbits : Orbits
        measure : Measure
        class_of : callable
            From the numbers of orbits (m,) to their classes.
        none : int
            Class of a point without an orbit.
        """
        which = np.flatnonzero(orbits.closed)
        first = self.exact(which, orbits.at(which), 1)
        lost = which[~first.closed].tolist()
        self.flow.problems.update(dict.fromkeys(lost, "motions beside its orbit are lost"))
        second = self.exact(which, self.again(which, first), 2)
        one, two = (
            {**measure(self, which, some, finer), "multiplier": leading(some)}
            for some, finer in ((first, 1), (second, 2))
        )
        kinds, others = (
            class_of({name: item.value for name, item in some.items()}) for some in (one, two)
        )
        clear = np.abs(one["multiplier"].value - 1) > OPTIONS.margin
        count = len(self.steps)
        values: dict[str, Array] = {
            "class": np.full(count, none),
            "robust": np.ones(count, dtype=int),
        }
        values["class"][which] = kinds
        values["robust"][which] = (kinds == others) & second.closed & clear
        floors = rounding_floors(second)
        for name, item in one.items():
            bound = item.change(two[name]) + item.unit * floors + item.left_out
            if name == "multiplier":
                shift = leading_change(first.monodromy, second.monodromy - first.monodromy)
                bound = np.maximum(bound, shift) + eigenvalue_bounds(second.monodromy, floors)
            known = second.closed & self.by_reference
            for column, numbers in ((name, item.value), (f"{name}_bound", bound)):
                values[column] = np.full(count, np.nan)
                values[column][which] = np.where(known | (column == name), numbers, np.nan)
        return values


def leading(orbits: Orbits) -> OrbitNumber:
    """Return the largest modulus of the multipliers, that of a shift in time left out."""
    modulus = orbits.leading
    return OrbitNumber(modulus, modulus[:, None], unit=0.0)


def rounding_floors(orbits: Orbits) -> Array:
    """Return bounds (m,) on the displacement of orbits by round-off, in the sizes of the states."""
    with np.errstate(all="ignore"):
        away = rounding_displacement(orbits.monodromy, orbits.closing)
        growth = 1 + np.max(np.sum(np.abs(orbits.monodromy), axis=2), axis=1, initial=0.0)
        return 4 * np.pi * growth * (np.max(np.abs(away), axis=0) + orbits.correction)


def twins(maps: OrbitMap, known: Orbits) -> Iterator[tuple[Ints, Array]]:
    """Yield where orbits are looked for beside unstable ones, along the direction they are left."""
    n = len(known.states)
    for distance in OPTIONS.twins:
        moduli = known.leading
        which = np.flatnonzero((moduli >= 1) & (moduli < OPTIONS.max_twin_multiplier))
        values, vectors = np.linalg.eig(known.monodromy[which])
        each, first = np.arange(len(which)), np.argmin(np.abs(values - moduli[which, None]), axis=1)
        value, away = values[each, first], vectors[each, :, first].real
        parting = (np.abs(value.imag) < 1e-12) & (value.real > 1)
        which, away, value = which[parting], away[parting].T, value[parting].real
        if which.size:
            length = distance * np.sqrt(np.minimum(value - 1, 1)) / np.max(np.abs(away), axis=0)
            yield which, known.states[:, which] + length * away * known.scale[:n, which]


def sources(known: Orbits, places: Ints) -> Ints:
    """Return which orbit each place may start from, -1 where there is none, or no need."""
    source = np.full(len(places), -1)
    stable = known.leading < 1
    lost, unstable = np.flatnonzero(~known.closed), np.flatnonzero(known.closed & ~stable)
    source[lost] = nearest(places[lost], places, known.closed)
    near = nearest(places[unstable], places, stable)
    apart = np.max(np.abs(places[unstable] - places[near]), axis=1, initial=0)
    source[unstable] = np.where(apart <= OPTIONS.max_distance, near, -1)
    return source


def nearest(from_places: Ints, places: Ints, among: NDArray[np.bool_]) -> Ints:
    """Return the nearest of some places to each of others, -1 where there is none of them."""
    known = np.flatnonzero(among)
    if not known.size:
        return np.full(len(from_places), -1)
    to = places[known].astype(float)
    distance = np.sum(to**2, axis=1) - 2 * from_places.astype(float) @ to.T
    return known[np.argmin(distance, axis=1)]


def from_reference(known: Orbits, places: Ints) -> Starts:
    """Return the starts of an engine's search: the reference's orbit, or the nearest there is."""
    source = np.where(known.closed, np.arange(len(places)), nearest(places, places, known.closed))
    which = np.flatnonzero(source >= 0)
    return lambda maps, best: [(which, known.states[:, source[which]])]
