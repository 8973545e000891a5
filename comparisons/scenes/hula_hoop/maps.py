"""Maps of `hula_hoop`: stability of its rotation, and what it does from rest.

**Stability** (figs. 4, 6 of the paper) is judged by the Floquet multipliers of the orbit that
turns once in a period of the force: of the true one ("exact"), found by Newton's method on
the period map of the reference or an engine, or of an approximate one, see
`reference.hula_hoop_theory`. True rotations are of two kinds. Half a period later the equations
of motion are those of -y and theta + pi; a rotation either repeats itself so, or has a twin.
The first kind is looked for over half a period; where it loses its stability with a multiplier
through 1, the twins part from it and are stable for a while: they are looked for beside it.

**Motion from rest** (figs. 5, 7) is classified as the paper's table does. With W the turns
that theta makes in a period of the force, sign folded away by the mirror theta -> pi - theta,
and f_u the frequency at which theta' oscillates most:

============  ==========  =============  ===========
class         W           reversal       f_u
============  ==========  =============  ===========
``blue_o``    1           no             2 omega
``blue_plus`` 1           yes            2 omega
``cyan_o``    1           no             other
``cyan_plus`` 1           yes            other
``red_x``     not 1
============  ==========  =============  ===========
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....reference.hula_hoop.equations import HulaHoop, coefficients
from ....reference.hula_hoop.theory import (
    ApproximateSolution,
    corrected_solution,
    floquet_multipliers,
    paper_solution,
    refined_solution,
)
from ....reference.orbits import state_scale, turn
from ....reference.scene import Array, Case
from ...checks.prediction import STEPS_PER_PERIOD
from ...engines.registry import REFERENCE
from ...queries.flow import Flow, chosen
from ...queries.quantity import NO_VALUE, AxisName, Found, Points, Quantity, Variable

Places = NDArray[np.int_]

STABILITY = ("stable", "unstable", "no_rotation")
ZONES = ("blue_o", "red_o", "black_o", "no_rotation")
MOTIONS = ("blue_o", "blue_plus", "cyan_o", "cyan_plus", "red_x")
LABELS = (
    "rotator",
    "rest",
    "libration",
    "other_lock",
    "not_periodic",
    "unstable_rotation",
    "no_rotation",
)

FLOQUET_VARIABLES: Mapping[str, Variable] = {
    "stability": Variable("1", "of the rotation that turns once per period", STABILITY),
    "multiplier": Variable("1", "largest modulus of its Floquet multipliers"),
    "u_1": Variable("rad", "amplitude of its oscillation of theta at 2 omega"),
    "min_speed": Variable("1", "least theta' over the orbit, by omega; negative: reversal"),
    "zone": Variable("1", "stable, unstable, |u_1| at least 0.5: the legend of fig. 4", ZONES),
    "robust": Variable("1", "1 where a search with three times the step finds the same class"),
}
MOTION_VARIABLES: Mapping[str, Variable] = {
    "motion": Variable("1", "from rest, in the end: the legend of figs. 5, 7", MOTIONS),
    "label": Variable("1", "what kind of motion that is", LABELS),
    "turns": Variable("1", "|W|, turns of theta in a period of the force"),
    "f_u": Variable("1", "frequency at which theta' oscillates most, by that of the force"),
    "min_speed": Variable("1", "least theta' in the sense of the turning, by omega"),
    "periods": Variable("1", "of the force after which the motion repeats; 0: it does not"),
    "robust": Variable("1", "1 where twice the step and a start off by 1e-6 give the same"),
}

SMALL = 0.5
"""Largest |u_1| [rad] for which the paper trusts its expansion."""


# Steps

FLOQUET_STEPS = 20
"""Of the reference in the shortest period: multipliers are then good to 3e-8 (measured)."""
MOTION_STEPS = 12
"""The same from rest, where no digits are asked for."""
ENGINE_MOTION_STEPS = {1: 200, 2: 96, 3: 48, 4: 32, 5: 24, 6: 24}
"""Of an engine from rest, by the order of its method: fewer than `STEPS_PER_PERIOD`."""

MOST_STEPS_PER_FORCE = 8.0
"""No period counts as shorter than that of force or spring divided by this."""

FEW = np.array(sorted({m << j for j in range(24) for m in (1, 3)}))
"""Numbers of steps that are taken: few, so that points share them."""
MORE = np.array(sorted({m << j for j in range(24) for m in (4, 5, 6, 7)}))
"""The same for long spans."""


def fastest_rate(p: HulaHoop) -> Any:
    """Return the fastest circular frequency [rad/s] that steps have to resolve.

    That of the force, of the spring with the rod across, or of the rod as it librates about
    the line of the force, shaken by the linear response of the main mass.
    """
    c = coefficients(p)
    slow = np.maximum(c.omega, np.sqrt(c.stiffness * c.inertia / c.determinant))
    impedance = c.stiffness - c.mass * c.omega**2 + 1j * c.damping * c.omega
    response = c.force / np.maximum(np.abs(impedance), 1e-12 * c.stiffness)
    libration = c.omega * np.sqrt(c.coupling * response / c.inertia)
    return np.clip(libration, slow, MOST_STEPS_PER_FORCE * slow)


def step_counts(
    points: Points, spans: Array, per_period: float, coarser: int = 1, allowed: Places = FEW
) -> Places:
    """Return how many equal steps each point's span [s] is gone through in.

    Parameters
    ----------
    points : Points
    spans : array (k,)
    per_period : float
        Steps in the shortest period, unless ``points.step`` tells the longest step.
    coarser : int
        By how much longer the steps may be.
    allowed : int array
        Numbers to choose from.
    """
    longest = points.step or 2 * np.pi / (fastest_rate(points.parameters) * per_period)
    wanted = np.broadcast_to(spans / (coarser * longest), (len(points),))
    return allowed[np.searchsorted(allowed, wanted * (1 - 1e-9))]


def advance(
    flow: Flow, which: Places, states: Array, start: Any, spacing: Array, count: int, steps: Places
) -> Array:
    """Call `Flow` with a number of ``steps`` (m,) of each row's own; returns (4, m, count).

    The reference takes the steps of all rows together, while they last: its time goes into
    calls rather than arithmetic.
    """
    counts = np.unique(steps)
    if flow.points.engine != REFERENCE or len(counts) == 1:
        return flow(which, states, start, spacing, count, steps)
    found = np.empty((*states.shape, count))
    start = np.broadcast_to(start, len(which))
    step = spacing / steps
    legs = [
        (np.flatnonzero(steps >= end), int(begin), int(end))
        for begin, end in zip([0, *counts], counts, strict=False)
    ]
    states = states.copy()
    for i in range(count):
        for rows, begin, end in legs:
            time = start[rows] + i * spacing[rows] + begin * step[rows]
            length = (end - begin) * step[rows]
            now = states[:, rows]
            states[:, rows] = flow(which[rows], now, time, length, 1, end - begin)[..., 0]
        found[..., i] = states
    return found


def order_of(points: Points) -> int:
    """Return the order of the engine's method."""
    case = Case(points.scene.name, "point", points.one(0))
    return chosen(points, case)[2].order


# Stability of the rotation

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

SAMPLES, ORBIT_SAMPLES = 24, 48
"""In a period of the force, of a motion from rest and of a rotation."""


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
            ends = advance(self.flow, which, states, 0.0, time, 1, steps)[..., 0]
            return np.array([[-1.0], [1.0], [-1.0], [1.0]]) * (ends - turn(self.flow.scene, 1) / 2)
        ends = advance(self.flow, which, states, 0.0, self.period[which], 1, steps)
        return ends[..., 0] - turn(self.flow.scene, 1)

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
            guess = np.broadcast_to(points.scene.orbit_guesses(at.parameters)[0], states.shape)
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


def floquet(points: Points) -> Found:
    """Return the stability of the rotation that turns once in a period of the force.

    The search takes `COARSER` steps; from what it finds, the rotation is found again with the
    step itself, and ``robust`` compares the two. An engine's search starts from the
    reference's rotations, or from the nearest of the block.
    """
    if points.engine == REFERENCE and points.model != EXACT:
        return approximate_floquet(points)
    scene, p = points.scene, points.parameters
    period = np.broadcast_to(scene.period(p), len(points))
    guesses = [np.broadcast_to(guess, (4, len(points))) for guess in scene.orbit_guesses(p)]
    period_map = PeriodMap(
        Flow(points, scene), period, state_scale(scene, guesses[0], 2 * np.pi / period)
    )
    known = replace(points, engine=REFERENCE, model=EXACT, method=None)
    if points.engine != REFERENCE:
        known = replace(known, step=None)
    steps = step_counts(known, period, FLOQUET_STEPS, COARSER)
    coarse = search(known, replace(period_map, flow=Flow(known, scene)), guesses, steps)
    per_period = FLOQUET_STEPS
    if points.engine != REFERENCE:
        per_period = STEPS_PER_PERIOD[min(order_of(points), max(STEPS_PER_PERIOD))]
        start = from_nearest(points.places, coarse, guesses[0])
        steps = step_counts(points, period, per_period, COARSER)
        coarse = Rotations.unknown(len(points))
        improve(coarse, period_map, np.arange(len(points)), start, steps, MOST_ITERATIONS)
        follow(coarse, points, period_map, steps)
    steps = step_counts(points, period, per_period)
    start = from_nearest(points.places, coarse, guesses[0])
    fine = refine(coarse, period_map, start, steps)
    return judged(points, period_map, coarse, fine, steps)


def from_nearest(places: Places, known: Rotations, otherwise: Array) -> Array:
    """Return states (4, k): of the rotations, where there is none of the nearest one."""
    source = np.where(known.found, np.arange(len(places)), nearest(places, known.found))
    return np.where(source >= 0, known.states[:, source], otherwise)


def judged(
    points: Points, period_map: PeriodMap, coarse: Rotations, fine: Rotations, steps: Places
) -> Found:
    """Return the variables of the rotations that were found with two steps."""
    which = np.flatnonzero(fine.found)
    multiplier, u_1, min_speed = np.full((3, len(points)), np.nan)
    spacing = period_map.period[which] / ORBIT_SAMPLES
    between = -(-steps[which] // ORBIT_SAMPLES)
    samples = advance(
        period_map.flow, which, fine.states[:, which], 0.0, spacing, ORBIT_SAMPLES, between
    )
    slope = period_map.central_slope(which, fine.states[:, which], steps[which])
    lost = ~np.all(np.isfinite(slope), axis=(1, 2))
    slope[lost] = 0.0
    multiplier[which] = np.max(np.abs(np.linalg.eigvals(slope)), axis=1)
    phase = 2 * np.pi * np.arange(1, ORBIT_SAMPLES + 1) / ORBIT_SAMPLES
    u_1[which] = 2 * np.abs(np.mean((samples[1] - phase) * np.exp(-2j * phase), axis=1))
    speed = samples[3] * period_map.period[which, None] / (2 * np.pi)
    min_speed[which] = least(speed)
    problems = period_map.flow.problems
    failed = np.isin(np.arange(len(points)), [*problems, *which[lost]])
    stability = stability_class(np.where(fine.found, multiplier, np.inf), fine.found)
    before = stability_class(coarse.multiplier, coarse.found)
    return Found(
        {
            "stability": np.where(failed, NO_VALUE, stability),
            "multiplier": np.where(failed, np.nan, multiplier),
            "u_1": np.where(failed, np.nan, u_1),
            "min_speed": np.where(failed, np.nan, min_speed),
            "zone": np.where(failed, NO_VALUE, zone(stability, u_1)),
            "robust": np.where(failed, NO_VALUE, before == stability).astype(int),
        },
        problems,
    )


def stability_class(multiplier: Array, found: NDArray[np.bool_]) -> Places:
    """Return places in `STABILITY`."""
    return np.where(found, np.where(multiplier < 1, 0, 1), 2)


def zone(stability: Places, u_1: Array) -> Places:
    """Return places in `ZONES`."""
    large = (stability < 2) & (np.abs(u_1) >= SMALL)
    names = np.array([ZONES.index(name) for name in ("blue_o", "red_o", "no_rotation")])
    return np.where(large, ZONES.index("black_o"), names[stability])


def least(values: Array) -> Array:
    """Return the least value (k,) of what is sampled (k, n), of the parabola through it."""
    place = np.clip(np.argmin(values, axis=1), 1, values.shape[1] - 2)
    before, at, after = (
        np.take_along_axis(values, (place + i)[:, None], 1)[:, 0] for i in (-1, 0, 1)
    )
    slope, bend = (after - before) / 2, after - 2 * at + before
    inside = (bend > 0) & (np.abs(slope) < bend)
    lowest = at - np.divide(slope**2, 2 * bend, out=np.zeros_like(at), where=inside)
    return np.minimum(np.min(values, axis=1), lowest)


EXACT = "exact"

SOLUTIONS: Mapping[str, Callable[[HulaHoop], ApproximateSolution]] = {
    "paper": paper_solution,
    "refined": refined_solution,
    "corrected": corrected_solution,
}
"""Approximate rotations, by the name of the model."""

MONODROMY_ERROR = 1e-8
"""Bound on the relative error of their multipliers."""


def approximate_floquet(points: Points) -> Found:
    """Return the same of an approximate rotation; it is robust where no rounding matters."""
    p = points.parameters
    solution = SOLUTIONS[points.model](p)
    found = np.broadcast_to(np.isfinite(solution.u_1), len(points))
    multipliers = np.abs(floquet_multipliers(solution, p)[0])
    multiplier = np.where(found, np.broadcast_to(multipliers, len(points)), np.nan)
    u_1 = np.where(found, np.abs(solution.u_1), np.nan)
    stability = stability_class(multiplier, found)
    return Found(
        {
            "stability": stability,
            "multiplier": multiplier,
            "u_1": u_1,
            "min_speed": 1 - 2 * u_1,
            "zone": zone(stability, u_1),
            "robust": np.where(np.abs(multiplier - 1) < MONODROMY_ERROR, 0, 1),
        }
    )


# Motion from rest

SETTLING = 12.0
"""Time constants of the slower damper that motions are given to settle. They may take twice as
long as it would: at 3 Hz, 60 N the rotation's own rate is half of that damper's."""
SHORTEST, LONGEST = 20, 2000
"""Least and most of it, in periods of the force."""

WINDOW = 120
"""Periods of the force that are then watched."""

OFF = 1e-6
"""Angle [rad] by which the start of the check is off."""

SLACK = 0.5
"""Turns by which a rotation may miss one turn per period over the window."""

NEAR = 0.02
"""How close f_u / omega must be to 2."""

REPEATS = 0.02
"""How closely a motion repeats, in the size of each state."""

LONGEST_CYCLE = 20
"""Most periods of the force after which it may."""

STANDS = 1e-3
"""A theta' that never leaves its mean by more, by omega, is no oscillation."""


def motion(points: Points) -> Found:
    """Return what comes of the scene from rest, rod across, in the end.

    ``robust`` compares it with a run of twice the step whose start is off.
    """
    if points.engine == REFERENCE and points.model != EXACT:
        return approximate_motion(points)
    flow = Flow(points, points.scene)
    per_period = MOTION_STEPS
    if points.engine != REFERENCE:
        per_period = ENGINE_MOTION_STEPS[min(order_of(points), max(ENGINE_MOTION_STEPS))]
    found, check = (
        from_rest(flow, theta, per_period, coarser) for theta, coarser in ((0.0, 1), (OFF, 2))
    )
    same = (found["motion"] == check["motion"]) & (found["label"] == check["label"])
    failed = np.isin(np.arange(len(points)), list(flow.problems))
    return Found(found | {"robust": np.where(failed, NO_VALUE, same).astype(int)}, flow.problems)


def from_rest(flow: Flow, theta: float, per_period: float, coarser: int) -> dict[str, Array]:
    """Return the variables of the motions from rest at an angle [rad], robust left out."""
    points = flow.points
    every = np.arange(len(points))
    period = np.broadcast_to(points.scene.period(points.parameters), len(points))
    settling = settling_time(points.parameters, period)
    start = np.zeros((4, len(points)))
    start[1] = theta
    steps = step_counts(points, settling, per_period, coarser, MORE)
    begin = advance(flow, every, start, 0.0, settling, 1, steps)
    spacing = period / SAMPLES
    steps = step_counts(points, spacing, per_period, coarser)
    watched = advance(flow, every, begin[..., 0], settling, spacing, WINDOW * SAMPLES, steps)
    return described(np.concatenate([begin, watched], axis=2), 2 * np.pi / period)


def settling_time(p: HulaHoop, period: Array) -> Array:
    """Return how long motions take to settle [s]: in `SETTLING` of the slower damper's times."""
    c = coefficients(p)
    rate = np.minimum(c.hinge_damping / c.inertia, c.damping / c.mass) / 2
    with np.errstate(divide="ignore"):
        return np.clip(SETTLING / rate, SHORTEST * period, LONGEST * period)


def described(samples: Array, omega: Array) -> dict[str, Array]:
    """Return the variables of motions, robust left out.

    Parameters
    ----------
    samples : array (4, k, WINDOW SAMPLES + 1)
        States over the window, both its ends included.
    omega : array (k,)
        Circular frequency of the force [rad/s].
    """
    theta, speed = samples[1], samples[3] / omega[:, None]
    known = np.all(np.isfinite(samples), axis=(0, 2))
    with np.errstate(invalid="ignore"):
        turns = (theta[:, -1] - theta[:, 0]) / (2 * np.pi)
        rotates = np.abs(np.abs(turns) - WINDOW) < SLACK
        min_speed = least(np.where(turns[:, None] < 0, -speed, speed))
        f_u = strongest(speed[:, :-1])
        cycle, advance_per_cycle = repetition(samples[..., ::SAMPLES], omega)
        odd = np.abs(f_u - 2) >= NEAR
    motions = np.where(rotates, (min_speed < 0) + 2 * odd, MOTIONS.index("red_x"))
    still = np.ptp(speed, axis=1) < STANDS
    label = np.select(
        [rotates, still, cycle == 0, advance_per_cycle == 0],
        [LABELS.index(name) for name in ("rotator", "rest", "not_periodic", "libration")],
        LABELS.index("other_lock"),
    )
    return {
        "motion": np.where(known, motions, NO_VALUE),
        "label": np.where(known, label, NO_VALUE),
        "turns": np.where(known, np.abs(turns) / WINDOW, np.nan),
        "f_u": np.where(known, f_u, np.nan),
        "min_speed": np.where(known, min_speed, np.nan),
        "periods": np.where(known, cycle, np.nan),
    }


def strongest(speed: Array) -> Array:
    """Return at which frequency, by that of the force, theta' (k, n) oscillates most.

    The largest peak of its spectrum over the window (Hann), its mean removed; NaN where it
    stands.
    """
    swing = speed - np.mean(speed, axis=1, keepdims=True)
    spectrum = np.abs(np.fft.rfft(swing * np.hanning(speed.shape[1] + 1)[:-1], axis=1))
    return np.where(np.ptp(speed, axis=1) < STANDS, np.nan, np.argmax(spectrum, axis=1) / WINDOW)


def repetition(strobe: Array, omega: Array) -> tuple[Array, Array]:
    """Return after how many periods a motion repeats, 0 if not, and its turns in that time.

    Parameters
    ----------
    strobe : array (4, k, n)
        States at the same phase of the force, the later half of which is looked at.
    omega : array (k,)
    """
    later = strobe[..., strobe.shape[2] // 2 :]
    amplitude = np.max(np.hypot(later[0], later[2] / omega[:, None]), axis=1)
    amplitude = np.where(amplitude > 0, amplitude, 1.0)
    size = np.stack([amplitude, np.ones_like(omega), omega * amplitude, omega])
    cycle, turns = np.zeros((2, len(omega)))
    for periods in range(LONGEST_CYCLE, 0, -1):
        cycles = (later.shape[2] - 1) // periods
        end = cycles * periods
        own = np.rint((later[1, :, end] - later[1, :, 0]) / (2 * np.pi * cycles))
        folded = later[..., :end].reshape(4, len(omega), cycles, periods).copy()
        folded[1] -= 2 * np.pi * own[:, None, None] * np.arange(cycles)[:, None]
        spread = np.max(np.ptp(folded, axis=2), axis=2) / size
        repeats = np.all(spread < REPEATS, axis=0)
        cycle, turns = np.where(repeats, periods, cycle), np.where(repeats, own, turns)
    return cycle, turns


def approximate_motion(points: Points) -> Found:
    """Return what an approximate rotation says of the motion: it turns, if it is stable."""
    found = approximate_floquet(points).values
    stability, min_speed = found["stability"], found["min_speed"]
    stable = stability == STABILITY.index("stable")
    labels = np.array([LABELS.index(n) for n in ("rotator", "unstable_rotation", "no_rotation")])
    return Found(
        {
            "motion": np.where(stable, (min_speed < 0) * 1, MOTIONS.index("red_x")),
            "label": labels[stability],
            "turns": np.where(stable, 1.0, np.nan),
            "f_u": np.where(stable, 2.0, np.nan),
            "min_speed": np.where(stable, min_speed, np.nan),
            "periods": np.where(stable, 1.0, np.nan),
            "robust": found["robust"],
        }
    )


QUANTITIES: Mapping[str, Quantity] = {
    "floquet": Quantity(
        about="stability of the rotation that turns once in a period of the force (figs. 4, 6)",
        variables=FLOQUET_VARIABLES,
        evaluate=floquet,
        models=(EXACT, *SOLUTIONS),
        block=1024,
        engine_block=64,
    ),
    "class": Quantity(
        about="what comes of the scene from rest (figs. 5, 7)",
        variables=MOTION_VARIABLES,
        evaluate=motion,
        models=(EXACT, "paper", "corrected"),
        block=1024,
        engine_block=8,
    ),
}

AXES: Mapping[str, AxisName] = {}
