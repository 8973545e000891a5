"""The phase difference at which the rotors of `rotor_pendulum` turn together, and its stability."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....reference.orbits import period_advance
from ....reference.rotor_pendulum import theory
from ....reference.rotor_pendulum.equations import (
    RotorPendulum,
    coefficients,
    operating_speed,
    period,
)
from ....reference.rotor_pendulum.phase import (
    balanced_phase,
    forced_response,
    mean_phase,
    orbit_guesses,
)
from ....reference.scene import Array, Scene
from ...engines.registry import REFERENCE
from ..flow import Flow
from ..quantity import Points, QuantityValues, Variable
from .steps import NUDGE, RESOLVED, Ints, columns, doubled, fastest_rate

PHASES = ("synphase", "antiphase", "unstable", "none")
SYNPHASE, ANTIPHASE, UNSTABLE, NONE = range(len(PHASES))


PHASE = {
    "phase_difference": Variable("rad", "phi_1 - phi_2, averaged over a turn"),
    "class": Variable(
        "1",
        "synphase: within pi/2 of 0; antiphase: of pi; unstable: the orbit, or (33), is so; "
        "none: there is none",
        PHASES,
    ),
    "robust": Variable("1", "1 where a perturbation and a halved step leave the class"),
    "mean_speed": Variable("rad/s", "of both rotors"),
    "multiplier": Variable("1", "leading Floquet multiplier's modulus, that of a shift left out"),
}
CLASSES = ("class", "robust")


def _phase_class(phase: Any, stable: Any = True) -> Ints:
    """Return the class of a phase difference [rad], of which NaN is none."""
    side = np.where(np.cos(phase) > 0, SYNPHASE, ANTIPHASE)
    return np.where(np.isnan(phase), NONE, np.where(stable, side, UNSTABLE))


def _by_theory(p: RotorPendulum) -> tuple[Any, Any]:
    """Root of (30) that satisfies (36), and that it is stable."""
    return theory.stable_phase_difference(theory.ratios(p)), True


def _as_printed(p: RotorPendulum) -> tuple[Any, Any]:
    """(33) to the letter, and whether it satisfies (36) with the corrected mu_1."""
    n = theory.ratios(p)
    alpha = theory.printed_phase_difference(n)
    return alpha, theory.stability(n, alpha) > 0


def _by_damped_theory(p: RotorPendulum) -> tuple[Any, Any]:
    """Phase of the Poincare method with the dampers, and that it is stable."""
    return balanced_phase(p), True


THEORIES: Mapping[str, Callable[[RotorPendulum], tuple[Any, Any]]] = {
    "theory": _by_theory,
    "paper": _as_printed,
    "damped": _by_damped_theory,
}


def phase(points: Points) -> QuantityValues:
    """Stable phase difference: by a theory, or of the periodic orbit that motions have."""
    if points.engine == REFERENCE and points.model in THEORIES:
        return _theoretical_phase(points, THEORIES[points.model])
    flow = Flow(points, points.scene.variants.get(points.model, points.scene))
    return _direct_phase(flow)


def _theoretical_phase(
    points: Points, theorem: Callable[[RotorPendulum], tuple[Any, Any]]
) -> QuantityValues:
    p = points.parameters

    def phase_at(change_x: float, change_phi: float) -> tuple[Array, Ints]:
        near = p.replace(
            platform_stiffness=p.platform_stiffness * (1 + change_x),
            rod_stiffness=p.rod_stiffness * (1 + change_phi),
        )
        alpha, stable = columns(points, *theorem(near))
        return alpha, _phase_class(alpha, stable > 0)

    alpha, kind = phase_at(0.0, 0.0)
    changes = (-2 * NUDGE, 2 * NUDGE)  # of a stiffness: half as much of a frequency
    robust = np.all([phase_at(x, phi)[1] == kind for x in changes for phi in changes], axis=0)
    (speed,) = columns(points, operating_speed(p))
    return QuantityValues(
        {
            "phase_difference": alpha,
            "class": kind,
            "robust": robust.astype(int),
            "mean_speed": np.where(kind == NONE, np.nan, speed),
            "multiplier": np.full(len(points), np.nan),
        }
    )


STEPS_PER_TURN = {True: 32, False: 64}
"""Steps in a turn, by whether the reference takes them (8th order) or an engine."""


SAMPLES = 32
"""Samples of an orbit, from which its phase is averaged."""


def steps_per_turn(points: Points) -> Ints:
    """Return steps in a turn (k,): a power of two times the least, as the springs need."""
    reference = points.engine == REFERENCE
    p = points.parameters
    turns, fastest = columns(points, period(p), fastest_rate(p))
    longest = RESOLVED[reference] / np.maximum(fastest, 1e-300)
    least = STEPS_PER_TURN[reference]
    if points.step is not None:
        longest, least = np.full(len(points), points.step), SAMPLES
    return doubled(least, turns / longest)


def _whole(p: RotorPendulum, count: int) -> RotorPendulum:
    """Return the parameters with one stiffness at least an array (count,)."""
    return p.replace(platform_stiffness=np.broadcast_to(p.platform_stiffness, count).copy())


DIFFERENCE = 1e-6
"""Of the forward differences, in the size of each state: what they leave out is about as
large, and rounding is 1e-8."""

CLOSED = 1e-9
"""Largest Newton correction, in the size of each state, of an orbit that counts as found."""

CLOSE = 1e-3
"""Correction below which the Jacobian is that of the orbit."""

MOST_JACOBIANS, MOST_CHORDS = 5, 4
"""Jacobians in a search, and corrections with each of them."""

CONTRACTION = 0.5
"""A correction larger than this share of the one before asks for a new Jacobian."""

LARGEST = 0.1
"""Of the size of each state; longer corrections are shortened to it."""

FURTHEST = 2
"""Columns and rows between a point without an orbit and the neighbour it is retried from."""


@dataclass
class Orbits:
    """Synchronous orbits of the points of a map, and what Newton's method closes them with.

    Attributes
    ----------
    states : array (8, k)
        At phi_1 = 0; NaN where there is none.
    periods : array (k,) [s]
    monodromy : array (k, 8, 8)
        In the size of each state.
    closing : array (k, 8, 8)
        The same less the identity, the column of phi_1 replaced by the change with the period.
    """

    states: Array
    periods: Array
    monodromy: Array
    closing: Array

    @property
    def found(self) -> NDArray[np.bool_]:
        """Which points have one."""
        return np.isfinite(self.periods)

    def take(self, which: Ints, other: Orbits) -> None:
        """Replace those of some points (k,) by others (as many)."""
        self.states[:, which] = other.states
        self.periods[which] = other.periods
        self.monodromy[which] = other.monodromy
        self.closing[which] = other.closing


def _residual(flow: Flow, which: Ints, states: Array, periods: Array, steps: Ints) -> Array:
    """Return by how far orbits do not close (8, k), in the size of each state."""
    end = flow(which, states, 0.0, periods, 1, steps)[..., 0]
    advance = period_advance(flow.points.scene)
    residual: Array = (end - states - advance) / _scale(flow, which, periods)
    return residual


def _scale(flow: Flow, which: Ints, periods: Array) -> Array:
    """Return the size of each state (8, k): what the unbalance moves, a turn, and their rates.

    Not that of the states themselves: without an installation angle the platform of an orbit
    in synphase stands still.
    """
    c = coefficients(flow.points.parameters)
    shift = c.unbalance / c.mass
    swing = c.unbalance / (c.end_mass * c.length)
    rows = (shift, 2 * np.pi, 2 * np.pi, swing)
    size = np.array([np.broadcast_to(row, len(flow.points))[which] for row in rows])
    return np.concatenate([size, 2 * np.pi / periods * size])


def _jacobian(
    flow: Flow, which: Ints, states: Array, periods: Array, steps: Ints
) -> tuple[Array, Array, Array]:
    """Return residual (8, k), monodromy and closing matrix (k, 8, 8), by forward differences."""
    n, count = states.shape
    scale = _scale(flow, which, periods)
    lanes = np.repeat(states[:, None], n + 2, axis=1)  # n states, the period, none
    for i in range(n):
        lanes[i, i] += DIFFERENCE * scale[i]
    spans = np.tile(periods, (n + 2, 1))
    spans[n] *= 1 + DIFFERENCE
    ends = flow(
        np.tile(which, n + 2),
        lanes.reshape(n, -1),
        0.0,
        spans.reshape(-1),
        1,
        np.tile(steps, n + 2),
    ).reshape(n, n + 2, count)
    slopes = (ends[:, :-1] - ends[:, -1:]) / (DIFFERENCE * scale[:, None])
    slopes = np.moveaxis(slopes, -1, 0)  # k, states, columns
    monodromy = slopes[..., :n]
    closing = monodromy - np.eye(n)
    row = _section(flow.points.scene)
    closing[..., row] = slopes[..., n]
    return (ends[:, -1] - states - period_advance(flow.points.scene)) / scale, monodromy, closing


def _section(scene: Scene) -> int:
    assert scene.orbit.section_coordinate is not None
    return scene.coordinates.index(scene.orbit.section_coordinate)


def _correction(closing: Array, residual: Array) -> tuple[Array, Array]:
    """Return Newton's corrections (8, k), shortened, and how long they were (k,).

    Or how large the residual is, if that is more: a steep map makes corrections short.
    """
    usable = np.all(np.isfinite(closing), axis=(1, 2)) & np.all(np.isfinite(residual), axis=0)
    matrix = np.where(usable[:, None, None], closing, np.eye(len(residual)))
    change = -np.einsum("kij,jk->ik", np.linalg.pinv(matrix), np.where(usable, residual, 0.0))
    size = np.max(np.maximum(np.abs(change), np.abs(residual)), axis=0)
    size = np.where(usable, size, np.inf)
    return change * np.minimum(1.0, LARGEST / np.maximum(size, LARGEST)), size


def _corrected(
    flow: Flow, which: Ints, states: Array, periods: Array, change: Array
) -> tuple[Array, Array]:
    """Return states and periods after a correction."""
    row = _section(flow.points.scene)
    moved = change * _scale(flow, which, periods)
    moved[row] = 0.0
    return states + moved, periods * (1 + change[row])


def closed_orbits(flow: Flow, which: Ints, states: Array, periods: Array, steps: Ints) -> Orbits:
    """Newton's method on the period map of some points, from a start of each.

    Jacobians are kept for as long as corrections shrink by `CONTRACTION`. Where a new one makes
    a longer correction than the last did, the point is given up.
    """
    n, count = states.shape
    guess = periods
    states, periods = states.copy(), periods.copy()
    done = Orbits(
        np.full((n, count), np.nan),
        np.full(count, np.nan),
        np.full((count, n, n), np.nan),
        np.full((count, n, n), np.nan),
    )
    active, before = np.arange(count), np.full(count, np.inf)
    for _ in range(MOST_JACOBIANS):
        if not active.size:
            break
        x, span = states[:, active], periods[active]
        residual, monodromy, closing = _jacobian(flow, which[active], x, span, steps[active])
        change, size = _correction(closing, residual)
        near, shorter = size < CLOSE, size < before[active]
        before[active] = size
        x, span = _corrected(flow, which[active], x, span, change)
        ended = size < CLOSED
        going = np.isfinite(size) & ~ended
        for _ in range(MOST_CHORDS - 1):
            rows = np.flatnonzero(going)
            if not rows.size:
                break
            residual = _residual(
                flow, which[active[rows]], x[:, rows], span[rows], steps[active[rows]]
            )
            change, after = _correction(closing[rows], residual)
            x[:, rows], span[rows] = _corrected(
                flow, which[active[rows]], x[:, rows], span[rows], change
            )
            ended[rows] = after < CLOSED
            going[rows] = (after < CONTRACTION * size[rows]) & ~ended[rows]
            size[rows] = after
        kept = ended & near
        done.take(active[kept], Orbits(x[:, kept], span[kept], monodromy[kept], closing[kept]))
        states[:, active], periods[active] = x, span
        sane = np.isfinite(size) & (abs(np.log2(span / guess[active])) < 1)
        active = active[~kept & sane & shorter]
    return done


BESIDE = (np.pi / 2, -np.pi / 2)
"""Tried beside the theory's phase [rad], which knows no ripple of the rotors."""


def _orbits(flow: Flow, steps: Ints) -> Orbits:
    """Return the orbits of the points.

    From the theory's phase with the dampers; where there is such a phase but no orbit near it,
    from others; then from the orbits of the nearest points that have one.
    """
    points = flow.points
    count = len(points)
    p = _whole(points.parameters, count)
    (turns,) = columns(points, period(p))
    (alpha,) = columns(points, balanced_phase(p))
    starts = np.array(np.broadcast_to(orbit_guesses(p)[0], (8, count)), dtype=float)
    found = closed_orbits(flow, np.arange(count), starts, turns, steps)
    for offset in BESIDE:
        missing = _missing(flow, found)
        missing = missing[np.isfinite(alpha[missing])]
        if missing.size:
            starts = _uniform_rotation(p, np.nan_to_num(alpha) + offset)[:, missing]
            more = closed_orbits(flow, missing, starts, turns[missing], steps[missing])
            kept = more.found
            kept[kept] = np.abs(_own_multipliers(more.monodromy[kept])) < 1
            found.take(missing[kept], _some(more, kept))
    missing, known = _missing(flow, found), np.flatnonzero(found.found)
    if missing.size and known.size:
        apart = np.max(np.abs(points.places[missing][:, None] - points.places[known]), axis=2)
        nearest = np.argmin(apart, axis=1)
        close = apart[np.arange(len(missing)), nearest] <= FURTHEST
        missing, source = missing[close], known[nearest[close]]
        more = closed_orbits(
            flow, missing, found.states[:, source], found.periods[source], steps[missing]
        )
        found.take(missing[more.found], _some(more, more.found))
    return found


def _missing(flow: Flow, found: Orbits) -> Ints:
    """Return the points without an orbit at which the engine has not failed."""
    rows = np.flatnonzero(~found.found)
    return np.array([i for i in rows if i not in flow.problems], dtype=int)


def _uniform_rotation(p: RotorPendulum, alpha: Array) -> Array:
    """Return uniform rotation with the linear response (8, k), at phi_1 = 0."""
    w = operating_speed(p)
    x, phi_3 = forced_response(p, alpha)
    rows = (x.real, 0.0, -alpha % (2 * np.pi), phi_3.real, -w * x.imag, w, w, -w * phi_3.imag)
    return np.array(np.broadcast_arrays(*rows), dtype=float)


def _some(orbits: Orbits, rows: Any) -> Orbits:
    return Orbits(
        orbits.states[:, rows], orbits.periods[rows], orbits.monodromy[rows], orbits.closing[rows]
    )


def _phases(flow: Flow, which: Ints, states: Array, periods: Array, steps: Ints) -> Array:
    """Return phi_1 - phi_2 (k,), averaged over an orbit on the circle."""
    path = flow(which, states, 0.0, periods / SAMPLES, SAMPLES, steps // SAMPLES)
    return np.array([mean_phase(alpha) for alpha in path[1] - path[2]], dtype=float)


MARGIN = 1e-4
"""Distance of the leading multiplier's modulus from 1 that differences and steps may hide."""


def _direct_phase(flow: Flow) -> QuantityValues:
    points = flow.points
    steps = steps_per_turn(points)
    orbits = _orbits(flow, steps)
    values = {name: np.full(len(points), np.nan) for name in PHASE if name not in CLASSES}
    kind = np.full(len(points), NONE)
    robust = np.ones(len(points), dtype=int)
    rows = np.flatnonzero(orbits.found)
    if rows.size:
        some = _some(orbits, rows)
        alpha = _phases(flow, rows, some.states, some.periods, steps[rows])
        moduli = np.abs(_own_multipliers(some.monodromy))
        values["phase_difference"][rows] = alpha
        values["mean_speed"][rows] = 2 * np.pi / some.periods
        values["multiplier"][rows] = moduli
        kind[rows] = _phase_class(alpha, moduli < 1)
        again = _phase_again(flow, rows, some, steps[rows])
        same = _phase_class(again, moduli < 1) == kind[rows]
        robust[rows] = same & (abs(moduli - 1) > MARGIN)
    return flow.values(values | {"class": kind, "robust": robust})


def _own_multipliers(monodromy: Array) -> Any:
    """Return the Floquet multiplier (k,) of largest modulus beside that of a shift in time."""
    multipliers = np.linalg.eigvals(monodromy)
    trivial = np.argmin(np.abs(multipliers - 1), axis=1)[:, None]
    np.put_along_axis(multipliers, trivial, 0.0, axis=1)
    largest = np.argmax(np.abs(multipliers), axis=1)[:, None]
    return np.take_along_axis(multipliers, largest, axis=1)[:, 0]


def _phase_again(flow: Flow, which: Ints, orbits: Orbits, steps: Ints) -> Array:
    """Return the phase (k,) found from a perturbed start with twice the steps; NaN if none is."""
    states = orbits.states + NUDGE * _scale(flow, which, orbits.periods)
    states[_section(flow.points.scene)] = 0.0
    periods = orbits.periods
    size = np.full(len(which), np.inf)
    for _ in range(MOST_CHORDS):
        residual = _residual(flow, which, states, periods, 2 * steps)
        change, size = _correction(orbits.closing, residual)
        states, periods = _corrected(flow, which, states, periods, change)
    phases = _phases(flow, which, states, periods, 2 * steps)
    return np.where(size < NUDGE / 10, phases, np.nan)
