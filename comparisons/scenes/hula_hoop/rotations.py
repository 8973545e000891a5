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

from ....reference.differences import balanced_step
from ....reference.hula_hoop.equations import HulaHoop, coefficients
from ....reference.newton import Effort
from ....reference.orbits import PeriodMap, period_advance
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ..quantity import Flow, Points
from .steps import Places

EFFORT = Effort(jacobians=9, chords=1, within_reach=True)
KNOWN = Effort(jacobians=9, chords=4)
"""Where the first Jacobian is nearly right."""

HALF_STARTS = ((0, 0.0, 0.0), (1, 5 * np.pi / 4, 1.0))
WHOLE_STARTS = ((0, 3 * np.pi / 2, 1.0), (0, 4 * np.pi / 3, 1.0), (0, np.pi / 2, 1.0))
"""Starts of the search over half a period and over all of it: which guess, by what angle [rad] its
rod is turned on, and by what share of omega it turns faster. The second of the former finds the
rotations whose theta' swings by more than its mean, the latter those that are not their own mirror
images."""

LEVELS = 12
"""Of the force, from a weak one up to a point's own, on the way of which a rotation is followed."""
WEAKEST = 1.5
"""The weakest, at least, by the force that the mean torque balance asks for."""

TWINS = (0.1, 0.06, 0.15)
"""How far from a rotation its twins are looked for, in the size of each state, where its
multiplier is 2 or more; nearer to 1 they part as the root of what it exceeds 1 by."""
MOST_UNSTABLE = 5.0
"""Largest multiplier of a rotation that may have stable twins: 3 was the largest seen."""
FORWARD, CENTRAL = balanced_step(1, rounding=1e-14), balanced_step(2, rounding=1e-14, roughness=1e3)
"""Steps of the differences, in the size of each state."""

SYMMETRIC = 1e-10
"""By how far, in the size of the states, a rotation that is its own mirror image may miss that."""

COARSER = 3
"""By how much longer the steps are that the search takes."""


@dataclass(frozen=True)
class PeriodFlow:
    """The flow of some points over one period of the force, from t = 0.

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

    def about(self, which: Places, states: Array, steps: Places) -> PeriodMap:
        """Return the period map of some points about a guess (4, m) of each."""
        turn = period_advance(self.flow.scene)

        def whole(rows: Places, starts: Array, spans: Array) -> Array:
            return self.flow(which[rows], starts, 0.0, spans, 1, steps[which[rows]])[..., 0]

        def half(rows: Places, starts: Array, spans: Array) -> Array:
            count = -(-steps[which[rows]] // 2)
            ends = self.flow(which[rows], starts, 0.0, spans / 2, 1, count)[..., 0]
            return np.asarray(MIRROR * (ends - turn / 2))

        return PeriodMap(
            flow=half if self.half else whole,
            states=states,
            periods=self.period[which],
            scale=self.scale[:, which],
            advance=0 * turn if self.half else turn,
            order=1,
            step=FORWARD,
        )

    def monodromy(self, which: Places, states: Array, steps: Places) -> Array:
        """Return the scaled Jacobians (m, 4, 4) at states (4, m).

        By complex steps, which engines do not take: by central differences then. Those of the
        reference's rotations that are their own mirror images are squares of half a period's.
        """
        if self.flow.points.engine != REFERENCE:
            return self._slopes(which, states, steps, 2)
        mirrored, every = replace(self, half=True), np.arange(len(which))
        left = mirrored.about(which, states, steps).residual(every, 0 * states)
        halves = np.max(np.abs(left), axis=0) < SYMMETRIC
        slopes = np.empty((len(which), 4, 4))
        whole = mirrored._slopes(which[halves], states[:, halves], steps, None)
        slopes[halves] = whole @ whole
        slopes[~halves] = self._slopes(which[~halves], states[:, ~halves], steps, None)
        return slopes

    def _slopes(self, which: Places, states: Array, steps: Places, order: int | None) -> Array:
        about = replace(self.about(which, states, steps), order=order, step=CENTRAL)
        return about.linearise(np.arange(len(which)), 0 * states)[1] + np.eye(4)


MIRROR = np.array([[-1.0], [1.0], [-1.0], [1.0]])


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
    def exists(self) -> NDArray[np.bool_]:
        """Where there is one."""
        return np.isfinite(self.multiplier)

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Where it is stable."""
        return self.multiplier < 1

    def take(self, which: Places, states: Array, matrices: Array) -> None:
        """Take those of states (4, m) and Jacobians (m, 4, 4) that are better.

        A point may stand there several times.
        """
        multiplier = np.max(np.abs(np.linalg.eigvals(matrices)), axis=1)
        better = np.flatnonzero(multiplier < self.multiplier[which])
        better = better[np.argsort(-multiplier[better], kind="stable")]  # the best comes last
        which = which[better]
        self.multiplier[which] = multiplier[better]
        self.states[:, which] = states[:, better]
        self.matrices[which] = matrices[better]


def improve(
    best: Rotations,
    flow: PeriodFlow,
    which: Places,
    guess: Array,
    steps: Places,
) -> None:
    """Take the orbits that Newton's method leads to from guesses (4, m) where they are better."""
    if not which.size:
        return
    orbits = flow.about(which, guess, steps).close(EFFORT)
    closed = orbits.at(orbits.closed)
    matrices = closed.monodromy @ closed.monodromy if flow.half else closed.monodromy
    best.take(which[orbits.closed], closed.states, matrices)


def refine(coarse: Rotations, flow: PeriodFlow, start: Array, steps: Places) -> Rotations:
    """Return the rotations that those of longer steps go over into, from states (4, k).

    First with the Jacobians that are known, then, where that does not do, with new ones.
    """
    fine = Rotations.unknown(len(steps))
    known = np.flatnonzero(coarse.exists)
    if known.size:
        orbits = flow.about(known, start[:, known], steps).close(
            KNOWN, coarse.matrices[known] - np.eye(4)
        )
        closed = orbits.at(orbits.closed)
        fine.take(known[orbits.closed], closed.states, closed.monodromy)
    which = np.flatnonzero(~fine.exists)
    improve(fine, flow, which, start[:, which], steps)
    return fine


def search(points: Points, flow: PeriodFlow, guesses: list[Array], steps: Any) -> Rotations:
    """Find the rotations of points; stable ones where there is a choice.

    Each point for itself first, then from its neighbours.

    Parameters
    ----------
    points : Points
    flow : PeriodFlow
    guesses : list of arrays (4, k)
    steps : int array (k,)
        In a period.
    """
    points.parameters.refuse_gravity("maps of hula_hoop's rotations")  # breaks the symmetry
    best, half = Rotations.unknown(len(points)), replace(flow, half=True)

    def start(over: PeriodFlow, place: int, angle: float, faster: float) -> None:
        """Start points without a stable rotation from a changed guess."""
        which = np.flatnonzero(~best.stable)
        states = guesses[place][:, which].copy()
        states[1] += angle
        states[3] += faster * 2 * np.pi / flow.period[which]
        improve(best, over, which, states, steps)

    for one in HALF_STARTS:
        start(half, *one)
    raise_force(best, points, half, steps)
    find_twins(best, flow, steps)
    for one in WHOLE_STARTS:
        start(flow, *one)
    follow(best, points, flow, steps)
    return best


def weakest_force(p: HulaHoop) -> Any:
    """Return the force amplitude [N] below which the mean torques have no balance."""
    c = coefficients(p)
    impedance = c.stiffness - c.mass * c.omega**2 + 1j * c.damping * c.omega
    friction = 2 * c.hinge_damping / (c.coupling * c.omega)
    own = c.coupling * c.omega**2 * np.imag(1 / impedance)
    return np.abs(friction - own) * np.abs(impedance)


def raise_force(best: Rotations, points: Points, flow: PeriodFlow, steps: Places) -> None:
    """Follow the rotation of a weak force up to points that have none, by secants."""
    p = points.parameters
    own = np.broadcast_to(p.force_amplitude, len(points))
    weak = np.maximum(WEAKEST * weakest_force(p), own / LEVELS)
    which = np.flatnonzero(~best.exists & (weak < own))
    if not which.size:
        return
    guess = points.scene.orbit.guesses(p.replace(force_amplitude=weak))[0]
    before = states = np.broadcast_to(guess, (4, len(points)))[:, which].copy()
    for level, force in enumerate(np.linspace(weak, own, LEVELS)[:-1]):
        weaker = replace(points, parameters=p.replace(force_amplitude=force))
        over = replace(flow, flow=replace(flow.flow, points=weaker))
        reached = over.about(which, states if level < 2 else 2 * states - before, steps)
        orbits = reached.close(EFFORT)
        which, before = which[orbits.closed], states[:, orbits.closed]
        states = orbits.states[:, orbits.closed]
    improve(best, flow, which, 2 * states - before, steps)


def find_twins(best: Rotations, flow: PeriodFlow, steps: Places) -> None:
    """Look for twins along the direction in which an unstable rotation is left."""
    which = np.flatnonzero(best.exists & ~best.stable & (best.multiplier < MOST_UNSTABLE))
    values, vectors = np.linalg.eig(best.matrices[which])
    each, leading = np.arange(len(which)), np.argmax(np.abs(values), axis=1)
    value, vector = values[each, leading], vectors[each, :, leading]
    parting = (value.imag == 0) & (value.real > 0)
    which, away, growth = which[parting], vector[parting].real.T, value[parting].real
    away *= np.sqrt(np.minimum(growth - 1, 1)) / np.max(np.abs(away), axis=0)
    middle = best.states[:, which]
    for distance in TWINS:
        improve(best, flow, which, middle + distance * away * flow.scale[:, which], steps)


def follow(best: Rotations, points: Points, flow: PeriodFlow, steps: Places) -> None:
    """Retry points from their neighbours until that brings nothing more.

    Those without a rotation start from the nearest that has one, those without a stable one
    from a neighbour that has one; what they had, they keep unless they find a stable one.
    """
    tried = np.full(len(points), -1)
    while True:
        source = sources(best, points.places)
        which = np.flatnonzero((source >= 0) & (source != tried))
        if not which.size:
            return
        tried[which] = source = source[which]
        own, states = Rotations.unknown(len(points)), best.states[:, source]
        improve(own, flow, which, states, steps)
        gained = np.flatnonzero(own.stable | (own.exists & ~best.exists))
        best.take(gained, own.states[:, gained], own.matrices[gained])


def sources(best: Rotations, places: Places) -> Places:
    """Return which rotation each place may start from, -1 where there is none, or no need."""
    source = np.full(len(places), -1)
    lost, unstable = np.flatnonzero(~best.exists), np.flatnonzero(best.exists & ~best.stable)
    source[lost] = nearest(places[lost], places, best.exists)
    near = nearest(places[unstable], places, best.stable)
    apart = np.max(np.abs(places[unstable] - places[near]), axis=1, initial=0)
    source[unstable] = np.where(apart <= 2, near, -1)
    return source


def nearest(from_places: Places, places: Places, among: NDArray[np.bool_]) -> Places:
    """Return the nearest of some places to each of others, -1 where there is none of them."""
    known = np.flatnonzero(among)
    if not known.size:
        return np.full(len(from_places), -1)
    to = places[known].astype(float)
    distance = np.sum(to**2, axis=1) - 2 * from_places.astype(float) @ to.T
    return known[np.argmin(distance, axis=1)]


def from_nearest(places: Places, known: Rotations, otherwise: Array) -> Array:
    """Return states (4, k): of the rotations, where there is none of the nearest one."""
    source, lost = np.arange(len(places)), np.flatnonzero(~known.exists)
    source[lost] = nearest(places[lost], places, known.exists)
    return np.where(source >= 0, known.states[:, source], otherwise)
