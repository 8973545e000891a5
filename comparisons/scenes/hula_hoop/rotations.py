"""The rotations of `hula_hoop` that turn once in a period of the force: found by Newton's method.

They are fixed points of the period map of the reference or an engine, of two kinds. Half a period
later the equations of motion are those of -y and theta + pi; a rotation either repeats itself so,
or has a twin. The first kind is looked for over half a period; where it loses its stability with a
multiplier through 1, the twins part from it and are stable for a while: they are looked for beside
it. Harmonic balance leads the reference near them, at a tenth of the cost of the period map.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....reference.differences import balanced_step
from ....reference.hula_hoop.balance import Balance, Nodes
from ....reference.hula_hoop.equations import Coefficients, HulaHoop, coefficients
from ....reference.newton import Effort
from ....reference.orbits import PeriodMap, period_advance
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ..quantity import Flow, Points
from .steps import Places

EFFORT = Effort(jacobians=9, chords=1)
BALANCED = Effort(jacobians=3, chords=3)
"""From what harmonic balance leads to."""
KNOWN = Effort(jacobians=9, chords=4)
"""Where the first Jacobian is nearly right."""

HALF_NODES, NODES = Nodes(16, half=True), Nodes(32, half=False)
"""Of harmonic balance. They leave 1e-6 rad where the rotation is rough, which shooting removes."""

HALF_STARTS = ((0, 0.0, 0.0), (1, 5 * np.pi / 4, 0.5))
WHOLE_STARTS = ((0, 0.0, 1.0), (0, np.pi / 4, 1.6j), (0, 0.0, 0.5j))
"""Starts of the search over half a period and over all of it: which guess, by what angle [rad]
its rod is turned on, and by what complex amplitude [rad] it swings: at twice the frequency of the
force, and at that itself. The second of the former finds the rotations whose theta' swings by more
than its mean, the latter those that are not their own mirror images."""

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

BESIDE = 1e-4
"""Displacement, by that to twins, at which the way to them is looked at."""

SYMMETRIC = 1e-10
"""By how far, in the size of the states, a rotation that is its own mirror image may miss that."""

SAME = 1e-4
"""In the size of the states: what differs by less counts as the same rotation."""

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
    effort: Effort = EFFORT,
) -> None:
    """Take the orbits that Newton's method leads to from guesses (4, m) where they are better."""
    if not which.size:
        return
    orbits = flow.about(which, guess, steps).close(effort)
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
    best = Rotations.unknown(len(points))
    c = coefficients_of(points)
    over_half, over_all = (
        Search(best, replace(flow, half=True), c, HALF_NODES, steps),
        Search(best, flow, c, NODES, steps),
    )
    for start in HALF_STARTS:
        over_half.start(*over_half.changed(guesses, start))
    raise_force(over_half, points)
    starts = [*twins(over_all), *(over_all.changed(guesses, start) for start in WHOLE_STARTS)]
    over_all.start(*map(np.concatenate, zip(*starts, strict=True)))
    follow(best, points, flow, steps)
    return best


def coefficients_of(points: Points) -> Coefficients:
    """Return the coefficients (k,) of the reference's equations.

    Raises
    ------
    ParameterError
        If there is gravity, which no rotation is its own mirror image in.
    """
    points.parameters.refuse_gravity("maps of hula_hoop's rotations")
    values = coefficients(points.parameters)
    return Coefficients(*(np.array(np.broadcast_to(x, len(points)), float) for x in values))


Start = tuple[Places, Array]
"""Points (m,), and phi (m, nodes) from which they start."""


@dataclass(frozen=True)
class Search:
    """A search of the reference: by harmonic balance at nodes, then by shooting.

    Attributes
    ----------
    best : Rotations
        What it has come to.
    flow : PeriodFlow
    c : Coefficients
        Arrays (k,).
    nodes : Nodes
    steps : int array (k,)
        In a period.
    """

    best: Rotations
    flow: PeriodFlow
    c: Coefficients
    nodes: Nodes
    steps: Places

    def start(self, which: Places, phi: Array) -> None:
        """Start some points from phi (m, nodes), theta less the phase of the force."""
        if not which.size:
            return
        balance = Balance(self.c, self.nodes)
        phi, solved = balance.solve(which, phi)
        which = which[solved]
        states = balance.states(which, phi[solved])
        new = self.is_new(which, states)
        improve(self.best, self.flow, which[new], states[:, new], self.steps, BALANCED)

    def is_new(self, which: Places, states: Array) -> NDArray[np.bool_]:
        """Return which of states (4, m) are neither known already nor there before."""
        off = (states - self.best.states[:, which]) / self.flow.scale[:, which]
        off[1] -= np.rint(off[1])  # its size is a turn
        known = np.max(np.abs(off), axis=0) < SAME
        turns = states[1] / (2 * np.pi)
        rows = np.stack([which, np.rint((turns - np.floor(turns)) / SAME)])
        first = np.zeros(len(which), dtype=bool)
        first[np.unique(rows, axis=1, return_index=True)[1]] = True
        return first & ~known

    def changed(self, guesses: list[Array], start: tuple[int, float, complex]) -> Start:
        """Return a changed guess of points without a stable rotation, see `HALF_STARTS`."""
        place, angle, amplitude = start
        which = np.flatnonzero(~self.best.stable)
        order = 2 if self.nodes.half else 1
        swing = np.imag(amplitude * np.exp(1j * order * self.nodes.phases))
        return which, guesses[place][1, which, None] + angle + swing

    def phi(self, which: Places, states: Array) -> Array:
        """Return phi (m, nodes) of motions of some points from states (4, m)."""
        count = self.nodes.count
        spacing, steps = self.flow.period[which] / count, -(-self.steps[which] // count)
        path = self.flow.flow(which, states, 0.0, spacing, count - 1, steps)[1]
        return np.concatenate([states[1][:, None], path], axis=1) - self.nodes.phases


def weakest_force(p: HulaHoop) -> Any:
    """Return the force amplitude [N] below which the mean torques have no balance."""
    c = coefficients(p)
    impedance = c.stiffness - c.mass * c.omega**2 + 1j * c.damping * c.omega
    friction = 2 * c.hinge_damping / (c.coupling * c.omega)
    own = c.coupling * c.omega**2 * np.imag(1 / impedance)
    return np.abs(friction - own) * np.abs(impedance)


def raise_force(search: Search, points: Points) -> None:
    """Follow the rotation of a weak force up to points that have none, by secants."""
    p, best, nodes = points.parameters, search.best, search.nodes
    own = np.broadcast_to(p.force_amplitude, len(points))
    weak = np.maximum(WEAKEST * weakest_force(p), own / LEVELS)
    which = np.flatnonzero(~best.exists & (weak < own))
    if not which.size:
        return
    guess = points.scene.orbit.guesses(p.replace(force_amplitude=weak))[0][1]
    before = phi = np.repeat(np.broadcast_to(guess, len(points))[which, None], nodes.count, axis=1)
    for level, force in enumerate(np.linspace(weak, own, LEVELS)[:-1]):
        balance = Balance(search.c._replace(force=force), nodes)
        reached, solved = balance.solve(which, phi if level < 2 else 2 * phi - before)
        which, before, phi = which[solved], phi[solved], reached[solved]
    search.start(which, 2 * phi - before)


def twins(search: Search) -> list[Start]:
    """Return where to look for twins: along the direction in which an unstable rotation is left."""
    best, flow = search.best, search.flow
    which = np.flatnonzero(best.exists & ~best.stable & (best.multiplier < MOST_UNSTABLE))
    if not which.size:
        return []
    values, vectors = np.linalg.eig(best.matrices[which])
    each, leading = np.arange(len(which)), np.argmax(np.abs(values), axis=1)
    value, vector = values[each, leading], vectors[each, :, leading]
    parting = (value.imag == 0) & (value.real > 0)
    which, away, growth = which[parting], vector[parting].real.T, value[parting].real[:, None]
    away *= np.sqrt(np.minimum(growth.T - 1, 1)) / np.max(np.abs(away), axis=0)
    states = best.states[:, which]
    middle = search.phi(which, states)
    beside = search.phi(which, states + BESIDE * away * flow.scale[:, which])
    parts = (beside - middle) / BESIDE * growth ** (-search.nodes.phases / (2 * np.pi))
    return [(which, middle + distance * parts) for distance in TWINS]


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
        if flow.flow.points.engine == REFERENCE:
            search = Search(own, flow, coefficients_of(points), NODES, steps)
            search.start(which, search.phi(source, states))
        else:
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
