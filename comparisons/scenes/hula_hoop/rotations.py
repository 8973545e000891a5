"""The rotations of `hula_hoop` that turn once in a period of the force: found by Newton's method.

They are fixed points of the period map of the reference or an engine, of two kinds. Half a period
later the equations of motion are those of -y and theta + pi; a rotation either repeats itself so,
or has a twin. The first kind is looked for over half a period; where it loses its stability with a
multiplier through 1, the twins part from it and are stable for a while: they are looked for beside
it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....reference.hula_hoop.equations import HulaHoop, coefficients
from ....reference.orbits import period_advance
from ....reference.scene import Array
from ..flow import Flow
from ..quantity import Points
from .steps import Places

CLOSED = 1e-6
"""Newton correction, in the size of each state, after which an orbit counts as found: the
next one would be its square, or 1e-7 of it."""

MOST_ITERATIONS = 9
FEW_ITERATIONS = 9
"""Of Newton's method, from a guess and from a neighbour."""
CHORDS = 4
"""Iterations with a Jacobian that is known already."""

HALF_STARTS = ((0, 0.0, 1.0), (1, 5 * np.pi / 4, 2.0))
WHOLE_STARTS = ((0, 0.0, 1.0), (1, np.pi / 2, 2.0))
"""Starts of the search over half a period and over all of it: which guess, by what angle [rad]
its rod is turned on, and what its theta' is multiplied by. The second of the former finds the
rotations whose theta' swings by more than its mean."""

LEVELS = 12
"""Of the force, from a weak one up to a point's own, on the way of which a rotation is followed."""
WEAKEST = 1.5
"""The weakest, at least, by the force that the mean torque balance asks for."""

TWINS = (0.1, -0.1, 0.06, 0.15)
"""How far from a rotation its twins are looked for, in the size of each state, where its
multiplier is 2 or more; nearer to 1 they part as the root of what it exceeds 1 by."""
MOST_UNSTABLE = 5.0
"""Largest multiplier of a rotation that may have stable twins: 3 was the largest seen."""
LARGEST_CORRECTION = 0.1
"""Of the size of each state; longer Newton corrections are shortened to it."""

ONE_SIDED, CENTRAL = 1e-7, 3e-6
"""Steps of the differences, in the size of each state."""

COARSER = 3
"""By how much longer the steps are that the search takes."""


@dataclass(frozen=True)
class PeriodMap:
    """The flow of some points over one period of the force, from t = 0, less the turn.

    Attributes
    ----------
    flow : Flow
    period : array (k,) [s]
    scale : array (4, k)
        Size of each state.
    half : bool
        Over half a period, less half a turn and with y reversed: what is fixed then is a
        rotation too.
    """

    flow: Flow
    period: Array
    scale: Array
    half: bool = False

    def __call__(self, which: Places, states: Array, steps: Places) -> Array:
        """Return the states (4, m) a period after states (4, m), less a turn."""
        if self.half:
            time, steps = self.period[which] / 2, -(-steps // 2)
            ends = self.flow(which, states, 0.0, time, 1, steps)[..., 0]
            return np.array([[-1.0], [1.0], [-1.0], [1.0]]) * (
                ends - period_advance(self.flow.scene) / 2
            )
        ends = self.flow(which, states, 0.0, self.period[which], 1, steps)
        return ends[..., 0] - period_advance(self.flow.scene)

    def slope(self, which: Places, states: Array, steps: Places) -> tuple[Array, Array]:
        """Return the ends (4, m), and the scaled Jacobian (m, 4, 4) by one-sided differences."""
        lanes = np.concatenate([np.zeros((1, 4)), ONE_SIDED * np.eye(4)])
        ends = self._lanes(lanes, which, states, steps)
        return ends[:, 0], self._scaled(ends[:, 1:] - ends[:, :1], which) / ONE_SIDED

    def central_slope(self, which: Places, states: Array, steps: Places) -> Array:
        """Return the scaled Jacobian (m, 4, 4) by central differences."""
        lanes = CENTRAL * np.concatenate([np.eye(4), -np.eye(4)])
        ends = self._lanes(lanes, which, states, steps)
        return self._scaled(ends[:, :4] - ends[:, 4:], which) / (2 * CENTRAL)

    def _lanes(self, lanes: Array, which: Places, states: Array, steps: Places) -> Array:
        """Return the ends (4, lanes, m) of states displaced by lanes (lanes, 4) of their size."""
        starts = states[:, None] + lanes.T[:, :, None] * self.scale[:, None, which]
        flat = starts.reshape(4, -1)
        count = len(lanes)
        return self(np.tile(which, count), flat, np.tile(steps, count)).reshape(starts.shape)

    def _scaled(self, differences: Array, which: Places) -> Array:
        """Return differences (4, 4, m) of ends as matrices (m, 4, 4) in the states' sizes."""
        return np.moveaxis(differences / self.scale[:, None, which], -1, 0)


@dataclass
class Rotations:
    """The best rotation known of each point: that of the smallest leading multiplier.

    Attributes
    ----------
    states : array (4, k)
        At t = 0; NaN where none was found.
    matrices : array (k, 4, 4)
        Scaled Jacobian of the period map there.
    multiplier : array (k,)
        Largest modulus of the multipliers; infinite where none was found.
    """

    states: Array
    matrices: Array
    multiplier: Array

    @classmethod
    def unknown(cls, count: int) -> Rotations:
        """Return none for any of so many points."""
        states, matrices = np.full((4, count), np.nan), np.full((count, 4, 4), np.nan)
        return cls(states, matrices, np.full(count, np.inf))

    @property
    def found(self) -> NDArray[np.bool_]:
        """Where there is one."""
        return np.isfinite(self.multiplier)

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Where it is stable."""
        return self.multiplier < 1

    def take(self, which: Places, states: Array, matrices: Array) -> None:
        """Take those of states (4, m) and Jacobians (m, 4, 4) that are better."""
        multiplier = np.max(np.abs(np.linalg.eigvals(matrices)), axis=1)
        better = multiplier < self.multiplier[which]
        which = which[better]
        self.multiplier[which] = multiplier[better]
        self.states[:, which] = states[:, better]
        self.matrices[which] = matrices[better]


def correction(matrix: Array, residual: Array) -> tuple[Array, Array]:
    """Return Newton's correction (4, m), shortened, and its size (m,) before that."""
    change = -np.einsum("mij,jm->im", np.linalg.pinv(matrix - np.eye(4)), residual)
    size = np.max(np.abs(change), axis=0)
    return change * np.minimum(1, LARGEST_CORRECTION / np.maximum(size, 1e-300)), size


def improve(
    best: Rotations,
    period_map: PeriodMap,
    which: Places,
    guess: Array,
    steps: Places,
    iterations: int,
) -> None:
    """Take the orbits that Newton's method finds from guesses (4, m) where they are better."""
    states = guess.copy()
    pending = np.arange(len(which))
    with np.errstate(all="ignore"):
        for _ in range(iterations):
            own = which[pending]
            ends, matrix = period_map.slope(own, states[:, pending], steps[own])
            usable = np.all(np.isfinite(matrix), axis=(1, 2)) & np.all(np.isfinite(ends), axis=0)
            pending, own, ends, matrix = (
                pending[usable],
                own[usable],
                ends[:, usable],
                matrix[usable],
            )
            if not pending.size:
                return
            scale = period_map.scale[:, own]
            change, size = correction(matrix, (ends - states[:, pending]) / scale)
            states[:, pending] += change * scale
            done = size < CLOSED
            closed = matrix[done] @ matrix[done] if period_map.half else matrix[done]
            best.take(own[done], states[:, pending[done]], closed)
            pending = pending[~done]


def refine(coarse: Rotations, period_map: PeriodMap, start: Array, steps: Places) -> Rotations:
    """Return the rotations that those of longer steps go over into, from states (4, k).

    First with the Jacobians that are known, then, where that does not do, with new ones.
    """
    fine = Rotations.unknown(len(steps))
    states = start.copy()
    closed = np.zeros(len(steps), dtype=bool)
    pending = np.flatnonzero(coarse.found)
    with np.errstate(all="ignore"):
        for _ in range(CHORDS):
            ends = period_map(pending, states[:, pending], steps[pending])
            scale = period_map.scale[:, pending]
            change, size = correction(coarse.matrices[pending], (ends - states[:, pending]) / scale)
            states[:, pending] += change * scale
            closed[pending] = size < CLOSED
            pending = pending[np.isfinite(size) & ~closed[pending]]
    which = np.flatnonzero(closed)
    fine.take(which, states[:, which], coarse.matrices[which])
    which = np.flatnonzero(~closed)
    improve(fine, period_map, which, start[:, which], steps, MOST_ITERATIONS)
    return fine


def search(points: Points, period_map: PeriodMap, guesses: list[Array], steps: Any) -> Rotations:
    """Find the rotations of points; stable ones where there is a choice.

    Each point for itself first, then from its neighbours.

    Parameters
    ----------
    points : Points
    period_map : PeriodMap
    guesses : list of arrays (4, k)
    steps : int array (k,)
        In a period.
    """
    best = Rotations.unknown(len(points))
    half = replace(period_map, half=True)
    try_starts(best, half, guesses, HALF_STARTS, steps)
    raise_force(best, points, half, steps)
    find_twins(best, period_map, steps)
    try_starts(best, period_map, guesses, WHOLE_STARTS, steps)
    follow(best, points, period_map, steps)
    return best


def try_starts(
    best: Rotations, period_map: PeriodMap, guesses: list[Array], starts: Any, steps: Places
) -> None:
    """Start points without a stable rotation from changed guesses, see `HALF_STARTS`."""
    for place, angle, factor in starts:
        which = np.flatnonzero(~best.stable)
        guess = guesses[place][:, which]
        guess = np.stack([guess[0], guess[1] + angle, guess[2], factor * guess[3]])
        improve(best, period_map, which, guess, steps, MOST_ITERATIONS)


def weakest_force(p: HulaHoop) -> Any:
    """Return the force amplitude [N] below which the mean torques have no balance."""
    c = coefficients(p)
    impedance = c.stiffness - c.mass * c.omega**2 + 1j * c.damping * c.omega
    friction = 2 * c.hinge_damping / (c.coupling * c.omega)
    own = c.coupling * c.omega**2 * np.imag(1 / impedance)
    return np.abs(friction - own) * np.abs(impedance)


def raise_force(best: Rotations, points: Points, period_map: PeriodMap, steps: Places) -> None:
    """Follow the rotation of a weak force up to points that have none.

    By secants and, at each of the forces between, one Newton step and two with its Jacobian.
    """
    p = points.parameters
    own = np.broadcast_to(p.force_amplitude, len(points))
    weak = np.maximum(WEAKEST * weakest_force(p), own / LEVELS)
    which = np.flatnonzero(~best.found & (weak < own))
    known = Rotations.unknown(len(points))
    before = states = known.states
    for level, force in enumerate(np.linspace(weak, own, LEVELS)):
        if not which.size:
            return
        at = replace(points, parameters=p.replace(force_amplitude=force))
        here = replace(period_map, flow=Flow(at, points.scene))
        if level == 0:
            guess = np.broadcast_to(points.scene.orbit.guesses(at.parameters)[0], states.shape)
            improve(known, here, which, guess[:, which], steps, MOST_ITERATIONS)
            before = states = known.states
            which = which[known.found[which]]
            continue
        before, states = states, 2 * states - before
        if level == LEVELS - 1:
            improve(best, here, which, states[:, which], steps, MOST_ITERATIONS)
            return
        which = correct(here, which, states, steps)


def correct(period_map: PeriodMap, which: Places, states: Array, steps: Places) -> Places:
    """Bring predicted states (4, k) nearer to rotations; return the points not lost."""
    with np.errstate(all="ignore"):
        ends, matrix = period_map.slope(which, states[:, which], steps[which])
        for _ in range(3):
            usable = np.all(np.isfinite(matrix), axis=(1, 2)) & np.all(np.isfinite(ends), axis=0)
            which, ends, matrix = which[usable], ends[:, usable], matrix[usable]
            scale = period_map.scale[:, which]
            states[:, which] += correction(matrix, (ends - states[:, which]) / scale)[0] * scale
            ends = period_map(which, states[:, which], steps[which])
    return which


def find_twins(best: Rotations, period_map: PeriodMap, steps: Places) -> None:
    """Look for twins along the direction in which an unstable rotation is left."""
    which = np.flatnonzero(best.found & ~best.stable & (best.multiplier < MOST_UNSTABLE))
    if not which.size:
        return
    values, vectors = np.linalg.eig(best.matrices[which])
    each, leading = np.arange(len(which)), np.argmax(np.abs(values), axis=1)
    value, vector = values[each, leading], vectors[each, :, leading]
    parting = (value.imag == 0) & (value.real > 0)
    which, away = which[parting], vector[parting].real.T
    apart = np.sqrt(np.minimum(value[parting].real - 1, 1))
    away *= apart / np.max(np.abs(away), axis=0) * period_map.scale[:, which]
    middle = best.states[:, which].copy()
    for distance in TWINS:
        left = ~best.stable[which]
        guess = middle[:, left] + distance * away[:, left]
        improve(best, period_map, which[left], guess, steps, MOST_ITERATIONS)


def follow(best: Rotations, points: Points, period_map: PeriodMap, steps: Places) -> None:
    """Retry points from their neighbours until that brings nothing more.

    Those without a rotation start from the nearest that has one, those without a stable one
    from a neighbour that has one; what they had, they keep unless they find a stable one.
    """
    tried = np.full(len(points), -1)
    places = points.places
    while True:
        any_near, stable_near = nearest(places, best.found), nearest(places, best.stable)
        apart = np.max(np.abs(places - places[stable_near]), axis=1)
        source = np.where(best.found, np.where(apart <= 2, stable_near, -1), any_near)
        which = np.flatnonzero(~best.stable & (source >= 0) & (source != tried))
        if not which.size:
            return
        tried[which] = source[which]
        own = Rotations.unknown(len(points))
        improve(own, period_map, which, best.states[:, source[which]], steps, FEW_ITERATIONS)
        gained = np.flatnonzero(own.stable | (own.found & ~best.found))
        best.take(gained, own.states[:, gained], own.matrices[gained])


def nearest(places: Places, among: NDArray[np.bool_]) -> Places:
    """Return the nearest of some places to each place, -1 where there is none of them."""
    known = np.flatnonzero(among)
    if not known.size:
        return np.full(len(places), -1)
    distance = np.sum((places[:, None] - places[None, known]) ** 2, axis=-1)
    return known[np.argmin(distance, axis=1)]


def from_nearest(places: Places, known: Rotations, otherwise: Array) -> Array:
    """Return states (4, k): of the rotations, where there is none of the nearest one."""
    source = np.where(known.found, np.arange(len(places)), nearest(places, known.found))
    return np.where(source >= 0, known.states[:, source], otherwise)
