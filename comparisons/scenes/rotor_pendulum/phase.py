"""The phase difference at which the rotors of `rotor_pendulum` turn together, and its stability."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ....reference.differences import balanced_step
from ....reference.newton import Effort
from ....reference.orbits import Orbits, PeriodMap, period_advance, section_row
from ....reference.rotor_pendulum import theory
from ....reference.rotor_pendulum.equations import (
    RotorPendulum,
    coefficients,
    operating_speed,
    period,
)
from ....reference.rotor_pendulum.phase import (
    balanced_phase,
    mean_phase,
    orbit_guesses,
    uniform_rotation,
    wrapped,
)
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ..bounds import (
    SAFETY,
    conditions,
    difference,
    eigenvalue_bounds,
    rounding_displacement,
    with_bounds,
)
from ..quantity import Flow, Points, QuantityValues, Variable
from .steps import NUDGE, Ints, columns, step_counts

PHASES = ("synphase", "antiphase", "unstable", "none")
SYNPHASE, ANTIPHASE, UNSTABLE, NONE = range(len(PHASES))


NUMBERS = ("phase_difference", "mean_speed", "multiplier")

PHASE = with_bounds(
    {
        "phase_difference": Variable("rad", "phi_1 - phi_2, averaged over a turn"),
        "class": Variable(
            "1",
            "synphase: within pi/2 of 0; antiphase: of pi; unstable: the orbit, or (33), is so; "
            "none: there is none",
            PHASES,
        ),
        "robust": Variable("1", "1 where a perturbation and a halved step leave the class"),
        "mean_speed": Variable("rad/s", "of both rotors"),
        "multiplier": Variable(
            "1", "leading Floquet multiplier's modulus, that of a shift left out"
        ),
    },
    *NUMBERS,
)
CLASSES = ("class", "robust")


def _phase_class(phase: Any, stable: Any = True) -> Ints:
    """Return the class of a phase difference [rad], of which NaN is none."""
    side = np.where(np.cos(phase) > 0, SYNPHASE, ANTIPHASE)
    return np.where(np.isnan(phase), NONE, np.where(stable, side, UNSTABLE))


def _as_printed(p: RotorPendulum) -> tuple[Any, Any]:
    """(33) to the letter, and whether it satisfies (36) with the corrected mu_1."""
    n = theory.ratios(p)
    alpha = theory.printed_phase_difference(n)
    return alpha, theory.stability(n, alpha) > 0


THEORIES: Mapping[str, Callable[[RotorPendulum], tuple[Any, Any]]] = {
    "theory": lambda p: (theory.stable_phase_difference(theory.ratios(p)), True),
    "paper": _as_printed,
    "damped": lambda p: (balanced_phase(p), True),
}
"""Phase difference and whether it is stable: the root of (30) that satisfies (36), (33) to the
letter, and that of the Poincare method with the dampers."""


def phase(points: Points) -> QuantityValues:
    """Stable phase difference: by a theory, or of the periodic orbit that motions have."""
    if points.engine == REFERENCE and points.model in THEORIES:
        return _theoretical_phase(points, THEORIES[points.model])
    flow = Flow(points, points.scene.variants.get(points.model, points.scene))
    return closed_orbit_values(flow, orbits_of(flow))


def _theoretical_phase(
    points: Points, theorem: Callable[[RotorPendulum], tuple[Any, Any]]
) -> QuantityValues:
    p = points.parameters
    p.refuse_gravity("the theories of rotor_pendulum")

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
    (off,) = conditions(lambda p: theorem(p)[:1], p, angles=True)
    speed, off, speed_off = columns(
        points, operating_speed(p), off, *conditions(lambda p: [operating_speed(p)], p)
    )
    none = kind == NONE
    return QuantityValues(
        {
            "phase_difference": alpha,
            "class": kind,
            "robust": robust.astype(int),
            "mean_speed": np.where(none, np.nan, speed),
            "multiplier": np.full(len(points), np.nan),
            "phase_difference_bound": np.where(none, np.nan, off),
            "mean_speed_bound": np.where(none, np.nan, speed_off),
            "multiplier_bound": np.full(len(points), np.nan),
        }
    )


STEPS_PER_TURN = {True: 32, False: 64}
"""Steps in a turn, by whether the reference takes them (8th order) or an engine."""


SAMPLES = 32
"""Samples of an orbit, from which its phase is averaged."""


def steps_per_turn(points: Points) -> Ints:
    """Return steps in a turn (k,)."""
    (turns,) = columns(points, period(points.parameters))
    return step_counts(points, turns, STEPS_PER_TURN, SAMPLES)


EFFORT = Effort(jacobians=8, chords=3, near=1e-3, within_reach=True)
AGAIN = Effort(jacobians=1, chords=3, longest=1.0, contraction=np.inf)
"""Near an orbit; the first correction may overshoot where the phase settles slowly."""

FURTHEST = 2
"""Columns and rows between a point without an orbit and the neighbour it is retried from."""


def period_map(flow: Flow, which: Ints, states: Array, periods: Array, steps: Ints) -> PeriodMap:
    """Return the period map of some points about a guess of each."""
    scene = flow.points.scene

    def advance(rows: Ints, starts: Array, spans: Array) -> Array:
        return flow(which[rows], starts, 0.0, spans, 1, steps[rows])[..., 0]

    return PeriodMap(
        flow=advance,
        states=states,
        periods=periods,
        scale=_scale(flow, which, periods),
        advance=period_advance(scene),
        section=section_row(scene),
        order=1,
        step=balanced_step(1, rounding=1e-12),
    )


def _scale(flow: Flow, which: Ints, periods: Array) -> Array:
    """Return the size of each state (8, k): what the unbalance moves, a turn, and their rates.

    Not that of the states themselves: without an installation angle the platform of an orbit
    in synphase stands still.
    """
    c = coefficients(flow.points.parameters)
    shift = c.unbalance / c.mass
    rows = (shift, 2 * np.pi, 2 * np.pi, c.unbalance / (c.end_mass * c.length))
    size = np.array([np.broadcast_to(row, len(flow.points))[which] for row in rows])
    return np.concatenate([size, 2 * np.pi / periods * size])


def closed_orbits(flow: Flow, which: Ints, states: Array, periods: Array, steps: Ints) -> Orbits:
    """Return the orbits of some points near a guess of each; their periods are near it too."""
    orbits = period_map(flow, which, states, periods, steps).close(EFFORT)
    with np.errstate(all="ignore"):
        near = abs(np.log2(orbits.periods / periods)) < 1
    return replace(orbits, closed=orbits.closed & near)


BESIDE = (np.pi / 2, -np.pi / 2)
"""Tried beside the theory's phase [rad], which knows no ripple of the rotors."""


def orbits_of(flow: Flow) -> Orbits:
    """Return the orbits of the points.

    From the theory's phase with the dampers; where there is such a phase but no orbit near it,
    from others; then from the orbits of the nearest points that have one.
    """
    points, steps = flow.points, steps_per_turn(flow.points)
    count = len(points)
    p = points.parameters
    p = p.replace(platform_stiffness=np.broadcast_to(p.platform_stiffness, count).copy())
    (turns,) = columns(points, period(p))
    (alpha,) = columns(points, balanced_phase(p))
    starts = np.array(np.broadcast_to(orbit_guesses(p)[0], (8, count)), dtype=float)
    orbits = closed_orbits(flow, np.arange(count), starts, turns, steps)
    for offset in BESIDE:
        missing = _missing(flow, orbits)
        missing = missing[np.isfinite(alpha[missing])]
        if missing.size:
            starts = uniform_rotation(p, np.nan_to_num(alpha) + offset)[:, missing]
            more = closed_orbits(flow, missing, starts, turns[missing], steps[missing])
            stable = more.closed & (leading_modulus(more) < 1)
            orbits.put(missing[stable], more.at(stable))
    missing, known = _missing(flow, orbits), np.flatnonzero(orbits.closed)
    if missing.size and known.size:
        apart = np.max(np.abs(points.places[missing][:, None] - points.places[known]), axis=2)
        nearest = np.argmin(apart, axis=1)
        close = apart[np.arange(len(missing)), nearest] <= FURTHEST
        missing, near = missing[close], orbits.at(known[nearest[close]])
        more = closed_orbits(flow, missing, near.states, near.periods, steps[missing])
        orbits.put(missing[more.closed], more.at(more.closed))
    return orbits


def _missing(flow: Flow, orbits: Orbits) -> Ints:
    """Return the points without an orbit at which the engine has not failed."""
    return np.array(
        [i for i in np.flatnonzero(~orbits.closed) if i not in flow.problems], dtype=int
    )


def _phases(flow: Flow, which: Ints, states: Array, periods: Array, steps: Ints) -> Array:
    """Return phi_1 - phi_2 (k,), averaged over an orbit on the circle."""
    path = flow(which, states, 0.0, periods / SAMPLES, SAMPLES, steps // SAMPLES)
    return np.array([mean_phase(alpha) for alpha in path[1] - path[2]], dtype=float)


MARGIN = 1e-4
"""Distance of the leading multiplier's modulus from 1 that differences and steps may hide."""


def closed_orbit_values(flow: Flow, orbits: Orbits) -> QuantityValues:
    """Return the variables of the points' orbits."""
    points = flow.points
    steps = steps_per_turn(points)
    values = {name: np.full(len(points), np.nan) for name in PHASE if name not in CLASSES}
    kind = np.full(len(points), NONE)
    robust = np.ones(len(points), dtype=int)
    rows = np.flatnonzero(orbits.closed)
    if rows.size:
        some = orbits.at(rows)
        alpha = _phases(flow, rows, some.states, some.periods, steps[rows])
        moduli = leading_modulus(some)
        values["phase_difference"][rows] = alpha
        values["mean_speed"][rows] = 2 * np.pi / some.periods
        values["multiplier"][rows] = moduli
        kind[rows] = _phase_class(alpha, moduli < 1)
        again, phases = _orbits_again(flow, rows, some, steps[rows])
        seen = np.where(again.correction < NUDGE / 10, phases, np.nan)
        robust[rows] = (_phase_class(seen, moduli < 1) == kind[rows]) & (abs(moduli - 1) > MARGIN)
        if points.engine == REFERENCE:
            for name, bound in _bounds(flow, rows, some, again, wrapped(phases - alpha)).items():
                values[name][rows] = bound
    return flow.values(values | {"class": kind, "robust": robust})


def leading_modulus(orbits: Orbits) -> Array:
    """Return the largest modulus (k,) of the multipliers beside that of a shift in time."""
    multipliers = orbits.multipliers.T
    multipliers[~orbits.closed] = np.inf
    trivial = np.argmin(np.abs(multipliers - 1), axis=1)[:, None]
    np.put_along_axis(multipliers, trivial, 0.0, axis=1)
    return np.asarray(np.max(np.abs(multipliers), axis=1))


def _orbits_again(flow: Flow, which: Ints, orbits: Orbits, steps: Ints) -> tuple[Orbits, Array]:
    """Return orbits near perturbed starts with twice the steps, and their phases (k,)."""
    about = period_map(flow, which, orbits.states, orbits.periods, 2 * steps)
    starts = orbits.states + NUDGE * about.scale
    starts[about.section] = 0.0
    again = replace(about, states=starts).close(AGAIN, orbits.slopes)
    if flow.points.engine == REFERENCE:
        again = replace(again, slopes=_exact_slopes(flow, which, again, 2 * steps))
    return again, _phases(flow, which, again.states, again.periods, 2 * steps)


def _exact_slopes(flow: Flow, which: Ints, orbits: Orbits, steps: Ints) -> Array:
    """Return the slopes at orbits of the reference by complex steps; 0 where they are lost."""
    about = period_map(flow, which, orbits.states, orbits.periods, steps)
    with np.errstate(all="ignore"):
        slopes = replace(about, order=None).linearise(np.arange(len(which)), 0 * orbits.states)[1]
    return np.where(np.all(np.isfinite(slopes), axis=(1, 2))[:, None, None], slopes, 0.0)


def _bounds(
    flow: Flow, which: Ints, orbits: Orbits, again: Orbits, shift: Array
) -> dict[str, Array]:
    """Return bounds on the numbers of orbits of the reference, by those of twice the steps.

    ``shift`` is by how much their phases differ [rad].
    """
    other, speed = 2 * np.pi / again.periods, 2 * np.pi / orbits.periods
    known = replace(again, closed=again.correction < NUDGE / 10)
    with np.errstate(all="ignore"):
        away = rounding_displacement(again.monodromy, again.closing)
        off = np.max(np.abs(away), axis=0) + again.correction
        growth = 1 + np.max(np.sum(np.abs(again.monodromy), axis=2), axis=1)
        bounds = {
            "phase_difference_bound": SAFETY * np.abs(shift) + 4 * np.pi * growth * off,
            "mean_speed_bound": difference(speed, other) + 2 * off * speed,
            "multiplier_bound": difference(leading_modulus(orbits), leading_modulus(known))
            + eigenvalue_bounds(again.monodromy, growth * off),
        }
    return {name: np.where(known.closed, bound, np.nan) for name, bound in bounds.items()}
