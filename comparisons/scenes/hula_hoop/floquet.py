"""Stability of the rotation of `hula_hoop` that turns once in a period of the force (figs. 4, 6).

It is judged by the Floquet multipliers of the orbit: of the true one ("exact", `rotations`), or of
an approximate one, see `reference.hula_hoop.theory`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ....reference.hula_hoop.equations import HulaHoop
from ....reference.hula_hoop.floquet import floquet_multipliers
from ....reference.hula_hoop.theory import (
    ApproximateSolution,
    corrected_solution,
    paper_solution,
    refined_solution,
)
from ....reference.orbits import state_scale
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ...engines.setup import STEPS_PER_PERIOD
from ..quantity import Flow, Points, QuantityValues, Variable, engine_setup
from .rotations import (
    COARSER,
    PeriodFlow,
    Rotations,
    follow,
    from_nearest,
    improve,
    refine,
    search,
)
from .steps import Places, step_counts

STABILITY = ("stable", "unstable", "no_rotation")
ZONES = ("blue_o", "red_o", "black_o", "no_rotation")


FLOQUET_VARIABLES: Mapping[str, Variable] = {
    "stability": Variable("1", "of the rotation that turns once per period", STABILITY),
    "multiplier": Variable("1", "largest modulus of its Floquet multipliers"),
    "u_1": Variable("rad", "amplitude of its oscillation of theta at 2 omega"),
    "min_speed": Variable("1", "least theta' over the orbit, by omega; negative: reversal"),
    "zone": Variable("1", "stable, unstable, |u_1| at least 0.5: the legend of fig. 4", ZONES),
    "robust": Variable("1", "1 where a search with three times the step finds the same class"),
}


SMALL = 0.5
"""Largest |u_1| [rad] for which the paper trusts its expansion."""


FLOQUET_STEPS = 20
"""Of the reference in the shortest period: multipliers are then good to 3e-8 (measured)."""


ORBIT_SAMPLES = 48
"""In a period of the force, of a rotation."""


def floquet(points: Points) -> QuantityValues:
    """Return the stability of the rotation that turns once in a period of the force.

    The search takes `COARSER` steps; from what it finds, the rotation is found again with the
    step itself, and ``robust`` compares the two. An engine's search starts from the
    reference's rotations, or from the nearest of the block.
    """
    if points.engine == REFERENCE and points.model != EXACT:
        return approximate_floquet(points)
    scene, p = points.scene, points.parameters
    period = np.broadcast_to(scene.period(p), len(points))
    guesses = [np.broadcast_to(guess, (4, len(points))) for guess in scene.orbit.guesses(p)]
    period_flow = PeriodFlow(
        Flow(points, scene), period, state_scale(scene, guesses[0], 2 * np.pi / period)
    )
    known = replace(points, engine=REFERENCE, model=EXACT, method=None)
    if points.engine != REFERENCE:
        known = replace(known, step=None)
    steps = step_counts(known, period, FLOQUET_STEPS, COARSER)
    coarse = search(known, replace(period_flow, flow=Flow(known, scene)), guesses, steps)
    per_period = FLOQUET_STEPS
    if points.engine != REFERENCE:
        per_period = STEPS_PER_PERIOD[
            min(engine_setup(points).integrator.order, max(STEPS_PER_PERIOD))
        ]
        start = from_nearest(points.places, coarse, guesses[0])
        steps = step_counts(points, period, per_period, COARSER)
        coarse = Rotations.unknown(len(points))
        improve(coarse, period_flow, np.arange(len(points)), start, steps)
        follow(coarse, points, period_flow, steps)
    steps = step_counts(points, period, per_period)
    start = from_nearest(points.places, coarse, guesses[0])
    return rotation_values(
        points, period_flow, coarse, refine(coarse, period_flow, start, steps), steps
    )


def rotation_values(
    points: Points, period_flow: PeriodFlow, coarse: Rotations, fine: Rotations, steps: Places
) -> QuantityValues:
    """Return the variables of the rotations that two steps have led to."""
    which = np.flatnonzero(fine.exists)
    multiplier, u_1, min_speed = np.full((3, len(points)), np.nan)
    spacing = period_flow.period[which] / ORBIT_SAMPLES
    between = -(-steps[which] // ORBIT_SAMPLES)
    states = fine.states[:, which]
    samples = period_flow.flow(which, states, 0.0, spacing, ORBIT_SAMPLES, between)
    slope = period_flow.monodromy(which, states, steps)
    lost = ~np.all(np.isfinite(slope), axis=(1, 2))
    slope[lost] = 0.0
    multiplier[which] = np.max(np.abs(np.linalg.eigvals(slope)), axis=1)
    phase = 2 * np.pi * np.arange(1, ORBIT_SAMPLES + 1) / ORBIT_SAMPLES
    u_1[which] = 2 * np.abs(np.mean((samples[1] - phase) * np.exp(-2j * phase), axis=1))
    min_speed[which] = least(samples[3] * period_flow.period[which, None] / (2 * np.pi))
    stability = stability_class(np.where(fine.exists, multiplier, np.inf), fine.exists)
    values = {
        "stability": stability,
        "multiplier": multiplier,
        "u_1": u_1,
        "min_speed": min_speed,
        "zone": zone(stability, u_1),
        "robust": (stability_class(coarse.multiplier, coarse.exists) == stability).astype(int),
    }
    unknown = dict.fromkeys(which[lost].tolist(), "motions beside its rotation are lost")
    return QuantityValues.of(values, unknown | period_flow.flow.problems)


def stability_class(multiplier: Array, rotates: NDArray[np.bool_]) -> Places:
    """Return places in `STABILITY`."""
    return np.where(rotates, np.where(multiplier < 1, 0, 1), 2)


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


def approximate_floquet(points: Points) -> QuantityValues:
    """Return the same of an approximate rotation; it is robust where no rounding matters."""
    p = points.parameters
    solution = SOLUTIONS[points.model](p)
    rotates = np.broadcast_to(np.isfinite(solution.u_1), len(points))
    multipliers = np.abs(floquet_multipliers(solution, p)[0])
    multiplier = np.where(rotates, np.broadcast_to(multipliers, len(points)), np.nan)
    u_1 = np.where(rotates, np.abs(solution.u_1), np.nan)
    stability = stability_class(multiplier, rotates)
    return QuantityValues(
        {
            "stability": stability,
            "multiplier": multiplier,
            "u_1": u_1,
            "min_speed": 1 - 2 * u_1,
            "zone": zone(stability, u_1),
            "robust": np.where(np.abs(multiplier - 1) < MONODROMY_ERROR, 0, 1),
        }
    )
