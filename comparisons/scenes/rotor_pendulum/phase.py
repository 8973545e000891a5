"""The phase difference at which the rotors of `rotor_pendulum` turn together, and its stability."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from ....reference.orbits import Orbits
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
)
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ..bounds import conditions, with_bounds
from ..orbit_map import Ints, OrbitMap, OrbitNumber
from ..quantity import Flow, Points, QuantityValues, Variable
from .steps import NUDGE, columns, step_counts

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
        "robust": Variable(
            "1", "1 where other stiffnesses (theory), or half the step, give the same class"
        ),
        "mean_speed": Variable("rad/s", "of both rotors"),
        "multiplier": Variable(
            "1", "leading Floquet multiplier's modulus, that of a shift left out"
        ),
    },
    *NUMBERS,
)


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
    return orbit_values(*orbits_of(points))


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


STEPS_PER_TURN = (64, 32)
"""Steps in a turn, of an engine and of the reference (8th order)."""


SAMPLES = 32
"""Samples of an orbit, from which its phase is averaged."""


def turning_map(points: Points) -> OrbitMap:
    """Return the maps over a turn of the rotors.

    The size of a state is what the unbalance moves, a turn, and their rates: without an
    installation angle the platform of an orbit in synphase stands still.
    """
    (turns,) = columns(points, period(points.parameters))
    c = coefficients(points.parameters)
    size = np.array(
        columns(
            points,
            c.unbalance / c.mass,
            2 * np.pi,
            2 * np.pi,
            c.unbalance / (c.end_mass * c.length),
        )
    )
    return OrbitMap(
        Flow(points, points.scene.variants.get(points.model, points.scene)),
        turns,
        np.concatenate([size, 2 * np.pi / turns * size]),
        step_counts(points, turns, STEPS_PER_TURN, SAMPLES),
    )


BESIDE = (np.pi / 2, -np.pi / 2)
"""Tried beside the theory's phase [rad], which knows no ripple of the rotors."""


def phases_of_theory(maps: OrbitMap, known: Orbits) -> Iterator[tuple[Ints, Array]]:
    """Yield starts: at the theory's phase with the dampers; where there is one, beside it."""
    points = maps.flow.points
    p, count = points.parameters, len(points)
    p = p.replace(platform_stiffness=np.broadcast_to(p.platform_stiffness, count).copy())
    yield np.arange(count), np.array(np.broadcast_to(orbit_guesses(p)[0], (8, count)), dtype=float)
    (alpha,) = columns(points, balanced_phase(p))
    for offset in BESIDE:
        which = np.flatnonzero(~known.closed & np.isfinite(alpha))
        yield which, uniform_rotation(p, np.nan_to_num(alpha) + offset)[:, which]


def orbits_of(points: Points) -> tuple[OrbitMap, Orbits]:
    """Return the maps over a turn, and the synchronous orbits that are found."""
    maps = turning_map(points)
    return maps, maps.search(phases_of_theory)


def orbit_values(maps: OrbitMap, orbits: Orbits) -> QuantityValues:
    """Return the variables of synchronous orbits."""
    values = maps.values(
        orbits,
        measured,
        lambda numbers: _phase_class(numbers["phase_difference"], numbers["multiplier"] < 1),
        NONE,
    )
    return maps.flow.values(values)


def measured(maps: OrbitMap, which: Ints, orbits: Orbits, finer: int) -> dict[str, OrbitNumber]:
    """Return the numbers of orbits: phi_1 - phi_2, averaged on the circle, and the speed."""
    steps = finer * -(-maps.steps[which] // SAMPLES)
    path = maps.flow(which, orbits.states, 0.0, orbits.periods / SAMPLES, SAMPLES, steps)
    alpha, speed = path[1] - path[2], 2 * np.pi / orbits.periods
    mean = np.array([mean_phase(one) for one in alpha], dtype=float)
    return {
        "phase_difference": OrbitNumber(mean, np.exp(1j * alpha), turn=2 * np.pi),
        "mean_speed": OrbitNumber(speed, speed[:, None], unit=speed),
    }
