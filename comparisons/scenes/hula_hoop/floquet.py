"""Stability of the rotation of `hula_hoop` that turns once in a period of the force (figs. 4, 6).

It is judged by the Floquet multipliers of the orbit: of the true one ("exact", `rotations`), or of
an approximate one, see `reference.hula_hoop.theory`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ....reference.differences import EPS
from ....reference.hula_hoop.equations import HulaHoop
from ....reference.hula_hoop.floquet import floquet_multipliers
from ....reference.hula_hoop.theory import (
    ApproximateSolution,
    corrected_solution,
    paper_solution,
    refined_solution,
)
from ....reference.newton import Effort
from ....reference.orbits import state_scale
from ....reference.periodic import lowest
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ...engines.setup import STEPS_PER_PERIOD
from ..bounds import (
    ROUNDING,
    conditions,
    difference,
    eigenvalue_bounds,
    last_harmonics,
    leading_change,
    refined_steps,
    rounding_displacement,
    with_bounds,
)
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


NUMBERS = ("multiplier", "u_1", "min_speed")
BOUNDS = tuple(f"{name}_bound" for name in NUMBERS)

FLOQUET_VARIABLES = with_bounds(
    {
        "stability": Variable("1", "of the rotation that turns once per period", STABILITY),
        "multiplier": Variable("1", "largest modulus of its Floquet multipliers"),
        "u_1": Variable("rad", "amplitude of its oscillation of theta at 2 omega"),
        "min_speed": Variable("1", "least theta' over the orbit, by omega; negative: reversal"),
        "zone": Variable("1", "stable, unstable, |u_1| at least 0.5: the legend of fig. 4", ZONES),
        "robust": Variable("1", "1 where a search with three times the step finds the same class"),
    },
    *NUMBERS,
)


SMALL = 0.5
"""Largest |u_1| [rad] for which the paper trusts its expansion."""


FLOQUET_STEPS = 20
"""Of the reference in the shortest period: multipliers are then good to 3e-8 (measured)."""


ORBIT_SAMPLES = 48
"""In a period of the force, of a rotation."""

SECOND = Effort(jacobians=1, chords=3)
"""From a rotation to that of more steps."""

BESIDE = 1e-4
"""Displacement, in the size of the states, by which it is seen how slopes change."""


def floquet(points: Points) -> QuantityValues:
    """Return the stability of the rotation that turns once in a period of the force.

    The search takes `COARSER` steps; from what it finds, the rotation is found again with the
    step itself, and ``robust`` compares the two. An engine's search starts from the
    reference's rotations, or from the nearest of the block.
    """
    if points.engine == REFERENCE and points.model != EXACT:
        return approximate_floquet(points)
    return rotation_values(points, *two_searches(points))


def two_searches(points: Points) -> tuple[PeriodFlow, Rotations, Rotations, Places]:
    """Return the flow over a period, the rotations by two steps, and steps in a period (k,)."""
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
    return period_flow, coarse, refine(coarse, period_flow, start, steps), steps


def rotation_values(
    points: Points, period_flow: PeriodFlow, coarse: Rotations, fine: Rotations, steps: Places
) -> QuantityValues:
    """Return the variables of the rotations that two steps have led to."""
    which = np.flatnonzero(fine.exists)
    columns = {name: np.full(len(points), np.nan) for name in (*NUMBERS, *BOUNDS)}
    states = fine.states[:, which]
    slope = period_flow.monodromy(which, states, steps)
    lost = ~np.all(np.isfinite(slope), axis=(1, 2))
    slope[lost] = 0.0
    numbers = measured(period_flow, which, states, steps, slope)
    if points.engine == REFERENCE and which.size:
        numbers |= bounded(period_flow, which, states, steps, slope, numbers)
    for name in numbers.keys() & columns.keys():
        columns[name][which] = numbers[name]
    stability = stability_class(np.where(fine.exists, columns["multiplier"], np.inf), fine.exists)
    values = {
        "stability": stability,
        **columns,
        "zone": zone(stability, columns["u_1"]),
        "robust": (stability_class(coarse.multiplier, coarse.exists) == stability).astype(int),
    }
    unknown = dict.fromkeys(which[lost].tolist(), "motions beside its rotation are lost")
    return QuantityValues.of(values, unknown | period_flow.flow.problems)


def measured(
    period_flow: PeriodFlow,
    which: Places,
    states: Array,
    steps: Places,
    slope: Array,
    between: int = 0,
) -> dict[str, Array]:
    """Return what rotations from states (4, m) with these Jacobians are measured by.

    ``between`` is added to the steps from sample to sample. ``sampling`` and ``peak`` bound what
    samples leave out of u_1 and of min_speed: harmonics fall off beyond the last as up to them.
    """
    period = period_flow.period[which]
    count = -(-steps[which] // ORBIT_SAMPLES) + between
    samples = period_flow.flow(which, states, 0.0, period / ORBIT_SAMPLES, ORBIT_SAMPLES, count)
    phase = 2 * np.pi * np.arange(1, ORBIT_SAMPLES + 1) / ORBIT_SAMPLES
    swing, speed = samples[1] - phase, samples[3] * period[:, None] / (2 * np.pi)
    spectra = [np.abs(np.fft.rfft(x, axis=1)) / ORBIT_SAMPLES for x in (swing, speed)]
    (last, fall), (least_last, least_fall) = (last_harmonics(x) for x in spectra)
    return {
        "multiplier": np.max(np.abs(np.linalg.eigvals(slope)), axis=1),
        "u_1": 2 * np.abs(np.mean(swing * np.exp(-2j * phase), axis=1)),
        "min_speed": lowest(speed),
        "swing": swing,
        "speed": speed,
        "sampling": 4 * last * fall ** (ORBIT_SAMPLES // 4),
        "peak": 4 * least_last / (1 - least_fall),
    }


def bounded(
    period_flow: PeriodFlow,
    which: Places,
    states: Array,
    steps: Places,
    slope: Array,
    first: Mapping[str, Array],
) -> dict[str, Array]:
    """Return bounds on the numbers of rotations of the reference, by a run in more steps."""
    more, eye = refined_steps(steps), np.eye(4)
    with np.errstate(all="ignore"):
        orbits = period_flow.about(which, states, more).close(SECOND, slope - eye)
        other = period_flow.monodromy(which, orbits.states, more)
        other[~np.all(np.isfinite(other), axis=(1, 2))] = 0.0
        second = measured(period_flow, which, orbits.states, more, other, between=1)
        away = rounding_displacement(slope, slope - eye)
        off = np.max(np.abs(away), axis=0)
        beside = states + BESIDE / off * away * period_flow.scale[:, which]
        bent = period_flow.monodromy(which, beside, -(-steps // 2))
        bend = np.max(np.abs(bent - slope), axis=(1, 2)) / BESIDE
        entries = 4 * (bend * off + ROUNDING * np.max(np.sum(np.abs(slope), axis=2), axis=1))
        growth = 4 * np.pi * off * (1 + np.max(np.sum(np.abs(slope), axis=2), axis=1))
        rest = {
            "multiplier": eigenvalue_bounds(slope, entries),
            "u_1": growth + first["sampling"],
            "min_speed": growth + first["peak"],
        }
        # a number may agree by chance where that of which it is made does not
        floors = {
            "multiplier": leading_change(slope, other - slope),
            "u_1": np.sqrt(2) * rms(first["swing"] - second["swing"]),  # all of it in one harmonic
            "min_speed": rms(first["speed"] - second["speed"]),
        }
        return {
            f"{name}_bound": np.where(
                orbits.closed,
                np.maximum(difference(first[name], second[name]), floors[name]) + rest[name],
                np.nan,
            )
            for name in NUMBERS
        }


def rms(values: Array) -> Array:
    """Return the root mean square (k,) of values (k, n)."""
    return np.sqrt(np.mean(values**2, axis=1))


def stability_class(multiplier: Array, rotates: NDArray[np.bool_]) -> Places:
    """Return places in `STABILITY`."""
    return np.where(rotates, np.where(multiplier < 1, 0, 1), 2)


def zone(stability: Places, u_1: Array) -> Places:
    """Return places in `ZONES`."""
    large = (stability < 2) & (np.abs(u_1) >= SMALL)
    names = np.array([ZONES.index(name) for name in ("blue_o", "red_o", "no_rotation")])
    return np.where(large, ZONES.index("black_o"), names[stability])


def least(values: Array, order: int = 2) -> Array:
    """Return the least value (k,) of what is sampled (k, n), of the polynomial through it.

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
