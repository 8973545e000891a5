"""Stability of the rotation of `hula_hoop` that turns once in a period of the force (figs. 4, 6).

It is judged by the Floquet multipliers of the orbit: of the true one ("exact", `rotations`), or of
an approximate one, see `reference.hula_hoop.theory`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ....reference.differences import EPS
from ....reference.hula_hoop.equations import HulaHoop
from ....reference.hula_hoop.floquet import floquet_multipliers
from ....reference.hula_hoop.theory import (
    ApproximateSolution,
    corrected_solution,
    paper_solution,
    refined_solution,
)
from ....reference.orbits import Orbits, state_scale
from ....reference.periodic import lowest
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ...engines.setup import STEPS_PER_PERIOD
from ..bounds import conditions, last_harmonics, with_bounds
from ..orbit_map import Ints, OrbitMap, OrbitNumber, from_reference
from ..quantity import Flow, Points, QuantityValues, Variable, engine_setup
from .rotations import balanced_rotations
from .steps import step_counts

STABILITY = ("stable", "unstable", "no_rotation")
ZONES = ("blue_o", "red_o", "black_o", "no_rotation")


NUMBERS = ("multiplier", "u_1", "min_speed")

FLOQUET_VARIABLES = with_bounds(
    {
        "stability": Variable("1", "of the rotation that turns once per period", STABILITY),
        "multiplier": Variable("1", "largest modulus of its Floquet multipliers"),
        "u_1": Variable("rad", "amplitude of its oscillation of theta at 2 omega"),
        "min_speed": Variable("1", "least theta' over the orbit, by omega; negative: reversal"),
        "zone": Variable(
            "1", "fig. 4: blue_o stable, red_o unstable, black_o |u_1| at least 0.5", ZONES
        ),
        "robust": Variable("1", "1 where half the step finds the same class, by a margin"),
    },
    *NUMBERS,
)


SMALL = 0.5
"""Largest |u_1| [rad] for which the paper trusts its expansion."""

FLOQUET_STEPS = 20
"""Steps of the reference in the shortest period: multipliers err by less than 3e-8 (measured)."""

ORBIT_SAMPLES = 48
"""Samples of a rotation in a period of the force."""


def floquet(points: Points) -> QuantityValues:
    """Return the stability of the rotation that turns once in a period of the force.

    An engine's search starts from the reference's rotations, or from the nearest of the block.
    """
    if points.engine == REFERENCE and points.model != EXACT:
        return approximate_floquet(points)
    return rotation_values(*rotations(points))


def rotation_map(points: Points) -> OrbitMap:
    """Return the maps over a period of the force."""
    scene, p = points.scene, points.parameters
    period = np.broadcast_to(scene.period(p), len(points))
    guess = np.broadcast_to(scene.orbit.guesses(p)[0], (4, len(points)))
    per_period = FLOQUET_STEPS
    if points.engine != REFERENCE:
        order = engine_setup(points).integrator.order
        per_period = STEPS_PER_PERIOD[min(order, max(STEPS_PER_PERIOD))]
    scale = state_scale(scene, guess, 2 * np.pi / period)
    return OrbitMap(Flow(points, scene), period, scale, step_counts(points, period, per_period))


def rotations(points: Points) -> tuple[OrbitMap, Orbits]:
    """Return the maps over a period of the force, and the rotations that are found."""
    maps = rotation_map(points)
    if points.engine == REFERENCE:
        return maps, maps.search(balanced_rotations)
    known = rotations(replace(points, engine=REFERENCE, model=EXACT, method=None, step=None))[1]
    return maps, maps.search(from_reference(known, points.places))


def rotation_values(maps: OrbitMap, orbits: Orbits) -> QuantityValues:
    """Return the variables of rotations."""
    values = maps.values(
        orbits,
        measured,
        lambda numbers: stability_class(numbers["multiplier"], True),
        STABILITY.index("no_rotation"),
    )
    stability: Ints = values.pop("class").astype(int)
    classes = {"stability": stability, "zone": zone(stability, values["u_1"])}
    return maps.flow.values(classes | values)


def measured(maps: OrbitMap, which: Ints, orbits: Orbits, finer: int) -> dict[str, OrbitNumber]:
    """Return the numbers of rotations.

    Samples leave out harmonics, which fall off beyond the last as up to them.
    """
    period = maps.periods[which]
    count = finer * -(-maps.steps[which] // ORBIT_SAMPLES)
    samples = maps.flow(which, orbits.states, 0.0, period / ORBIT_SAMPLES, ORBIT_SAMPLES, count)
    phase = 2 * np.pi * np.arange(1, ORBIT_SAMPLES + 1) / ORBIT_SAMPLES
    swing, speed = samples[1] - phase, samples[3] * period[:, None] / (2 * np.pi)
    spectra = [np.abs(np.fft.rfft(x, axis=1)) / ORBIT_SAMPLES for x in (swing, speed)]
    (last, fall), (least_last, least_fall) = (last_harmonics(x) for x in spectra)
    u_1 = 2 * np.abs(np.mean(swing * np.exp(-2j * phase), axis=1))
    return {
        "u_1": OrbitNumber(u_1, swing, left_out=4 * last * fall ** (ORBIT_SAMPLES // 4)),
        "min_speed": OrbitNumber(lowest(speed), speed, left_out=4 * least_last / (1 - least_fall)),
    }


def stability_class(multiplier: Array, rotates: Any) -> Ints:
    """Return places in `STABILITY`."""
    return np.where(rotates, np.where(multiplier < 1, 0, 1), 2)


def zone(stability: Ints, u_1: Array) -> Ints:
    """Return places in `ZONES`."""
    large = (stability < 2) & (np.abs(u_1) >= SMALL)
    names = np.array([ZONES.index(name) for name in ("blue_o", "red_o", "no_rotation")])
    return np.where(large, ZONES.index("black_o"), names[stability])


def least(values: Array, order: int = 2) -> Array:
    """Return the least value (k,) of the polynomial through samples (k, n).

    A parabola through three samples, or one of order 4 through five.
    """
    reach = order // 2
    place = np.clip(np.argmin(values, axis=1), reach, values.shape[1] - 1 - reach)
    near = np.take_along_axis(values, place[:, None] + np.arange(-reach, reach + 1), 1).T
    before, at, after = near[reach - 1 : reach + 2]
    slope, bend = (after - before) / 2, after - 2 * at + before
    inside = (bend > 0) & (np.abs(slope) < bend)
    off = -np.divide(slope, bend, out=np.zeros_like(at), where=inside)
    bottom = at + slope * off / 2
    if order == 4:
        third = (near[4] - near[0]) / 12 - slope / 3
        fourth = (near[4] + near[0] - 4 * (after + before) + 6 * at) / 24
        bottom = bottom + third * (off**3 - off) + fourth * (off**4 - off**2)
    return np.minimum(np.min(values, axis=1), bottom)


EXACT = "exact"

SOLUTIONS: Mapping[str, Callable[[HulaHoop], ApproximateSolution]] = {
    "paper": paper_solution,
    "refined": refined_solution,
    "corrected": corrected_solution,
}
"""Approximate rotations, by the name of the model."""

MONODROMY_ERROR = 1e-8
"""Bound on the relative error of their multipliers."""


def approximate_floquet(points: Points) -> QuantityValues:
    """Return the same of an approximate rotation; it is robust where no rounding matters."""
    p = points.parameters
    solution = SOLUTIONS[points.model](p)
    rotates = np.broadcast_to(np.isfinite(solution.u_1), len(points))
    multipliers = np.abs(floquet_multipliers(solution, p)[0])
    multiplier = np.where(rotates, np.broadcast_to(multipliers, len(points)), np.nan)
    u_1 = np.where(rotates, np.abs(solution.u_1), np.nan)
    (off,) = conditions(lambda p: [np.abs(SOLUTIONS[points.model](p).u_1)], p)
    off = np.where(rotates, off, np.nan)
    stability = stability_class(multiplier, rotates)
    return QuantityValues(
        {
            "stability": stability,
            "multiplier": multiplier,
            "u_1": u_1,
            "min_speed": 1 - 2 * u_1,
            "zone": zone(stability, u_1),
            "robust": np.where(np.abs(multiplier - 1) < MONODROMY_ERROR, 0, 1),
            "multiplier_bound": MONODROMY_ERROR * multiplier,
            "u_1_bound": off,
            "min_speed_bound": 2 * off + EPS,
        }
    )
