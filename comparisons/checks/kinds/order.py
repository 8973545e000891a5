"""Check kind *order*: errors over halved steps, their slope, and what they extrapolate to.

If a method of high order reaches round-off before its slopes reach the declared order, the slopes
of its own scheme on the true equations are expected.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ....reference.errors import EngineError
from ....reference.scene import Array
from ...engines.setup import Setup, shortest_period
from .. import elements
from ..comparison import Measured, Part, ideal_rows, least_error, richardson, taylor_remainder
from ..truth import Truth, permitted_horizon, roundoff_reference
from ..verdict import Finding, Inconclusive, Series

SLACK = 0.2
"""The finest slopes may stay this much below the declared order."""

LEVELS = 12
LEAST_POINTS, POINTS = 4, 5
MOST_MARKS = 16
"""Longest horizon, in coarsest steps: slopes need a short run of many steps."""

WRONG_ORDER = 0.75
"""Slopes that settle this much below the declared order will not reach it."""

SMALL = 1e-4
"""Relative error below which constant slopes are final."""

FLOOR = 30.0
"""An error counts as above the round-off floor where it is this many times larger."""


def quantities(setup: Setup) -> tuple[str, ...]:
    """Return the names of the measured quantities."""
    if setup.case.watch == "elements":
        bracket = ("bracket",) if setup.bound.frequency_side else ()
        return ("order", "extrapolated", "least_error", *bracket)
    return ("order", "extrapolated", *(() if setup.scheme else ("least_error",)))


def measure(setup: Setup) -> Measured:
    """Halve the step from a few steps per period until the error reaches the floor."""
    if setup.case.watch == "elements":
        return Measured(elements.measure_order(setup))
    names, order = setup.scene.observables, setup.integrator.order
    longest = min(shortest_period(setup.case) / 8, setup.stable_step_bound)
    coarsest = 2.0 ** np.floor(np.log2(longest))
    horizon, growth = permitted_horizon(setup.case, coarsest, setup.epsilon)
    horizon = coarsest * min(max(4, round(horizon / coarsest)), MOST_MARKS)
    marks = np.arange(1, round(horizon / coarsest) + 1)
    times = marks * coarsest
    right = roundoff_reference(
        setup.bound.equations, setup.case, setup.case.start_time + times, names
    )
    steps, floors, runs, errors, bound = halved(setup, right, coarsest, growth)
    below = [] if setup.scheme else [error_from_below(setup, right, coarsest, steps[0], errors[0])]
    if len(errors) < LEAST_POINTS:
        few = f"only {len(errors)} steps from {coarsest:.3g} s down have an error above round-off"
        return Measured([Inconclusive("order", few), Inconclusive("extrapolated", few), *below])
    slopes = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    finest, expected = finest_slope(errors), float(order)
    if setup.scheme and finest < expected - SLACK:
        expected = min(expected, ideal_slope(setup, right, steps, floors, times))
    listed = ", ".join(f"{slope:.2f}" for slope in slopes[-4:])
    declared = errors[0] * (np.array(steps) / steps[0]) ** order
    estimate = richardson(runs[-3:], order)
    last = relative_error(estimate.limit, right)
    tolerance = float(np.max(np.max(estimate.moved, axis=1) / right.size)) + bound
    reason = (
        f"slopes {listed} down to h = {steps[-1]:.3g} s, error {errors[-1]:.2g}; declared {order}"
    )
    off = max(0.0, expected - finest)
    drawn = Series("step", np.array(steps), np.array(errors), declared)
    extrapolated = f"relative error of the value extrapolated to h -> 0 over {horizon:.3g} s"
    return Measured(
        [
            Finding("order", "1", finest, expected, off, SLACK, reason, drawn),
            Finding("extrapolated", "1", last, 0.0, last, tolerance, extrapolated),
            *below,
        ]
    )


def halved(
    setup: Setup, right: Truth, coarsest: float, growth: float
) -> tuple[list[float], list[float], list[Array], list[float], float]:
    """Run with halved steps [s], to the times of the truth, until the order is decided.

    Returns
    -------
    steps : list of float
        Steps [s].
    floors : list of float
        Relative errors that may be round-off.
    runs : list of array (k, n_t)
    errors : list of float
        Largest relative error of each run.
    bound : float
        Round-off and the error of the reference in the last run.
    """
    names, count = setup.scene.observables, right.values.shape[1]
    trust = float(np.max(right.bound / right.size))
    steps, floors, errors, runs = list[float](), list[float](), list[float](), list[Array]()
    for level in range(LEVELS):
        step, marks = coarsest / 2**level, np.arange(1, count + 1) * 2**level
        bound = noise(count * 2**level, growth, setup.epsilon) + trust
        try:
            values = setup.simulate(step, marks).matrix(names)
        except EngineError as error:
            if error.kind not in ("non_finite", "warning", "solver") or level > LEVELS // 2:
                raise
            continue  # too coarse for this method; finer ones follow
        error_now, lowest = relative_error(values, right), FLOOR * bound
        if error_now < lowest and len(errors) >= 2:
            break
        steps.append(step)
        floors.append(lowest)
        runs.append(values)
        errors.append(error_now)
        if enough(errors, setup.integrator.order):
            break
    return steps, floors, runs, errors, bound


def error_from_below(
    setup: Setup, right: Truth, spacing: float, step: float, error: float
) -> Finding | Inconclusive:
    """Judge if the error with the coarsest step [s] is as large as its order requires.

    The true motion is known at times that are ``spacing`` [s] apart.
    """
    order = setup.integrator.order
    if right.values.shape[1] < order + 2:
        return Inconclusive("least_error", f"the run is too short to judge order {order}")
    remainder = taylor_remainder(
        sliding_window_view(right.values, order + 2, axis=1), right.size, order
    ) * (step / spacing) ** (order + 1)
    trust = float(np.max(right.bound / right.size)) + noise(1, 1.0, setup.epsilon)
    return least_error(order, step, error, trust, remainder)


def relative_error(values: Array, right: Truth) -> float:
    """Return the largest error of any observable at any sample, relative to its size."""
    return float(np.max(np.max(np.abs(values - right.values), axis=1) / right.size))


def ideal_slope(
    setup: Setup, right: Truth, steps: list[float], floors: list[float], times: Array
) -> float:
    """Return the finest slope of the setup's scheme on its equations, with these steps [s].

    Only of errors above round-off (``floors``), else a wrong engine might be as flat.
    """
    errors: list[float] = []
    for step, floor in zip(steps, floors, strict=True):
        part = Part(setup.case, np.rint(times / step).astype(int))
        values = ideal_rows(setup, [part], step, setup.scene.observables)
        error = relative_error(values, right)
        if error < floor:
            break
        errors += [error] if np.isfinite(error) else []
    return finest_slope(errors) if len(errors) >= LEAST_POINTS else np.inf


def finest_slope(errors: list[float]) -> float:
    """Return the last slope, or the mean of the last two if it is larger."""
    slopes = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    return float(max(slopes[-1], np.mean(slopes[-2:])))


def noise(steps: int, growth: float, epsilon: float) -> float:
    """Return the relative error that rounding makes, its signs being random."""
    return float(8 * epsilon * np.sqrt(steps) * growth)


def enough(errors: list[float], order: int) -> bool:
    """Return True if finer steps would not change the verdict.

    Either the last two slopes are those of the declared order with a small error, since large
    errors may shrink at a higher order than small ones; or the last three have settled on a lower
    order.
    """
    if len(errors) < POINTS:
        return False
    slopes = np.log2(np.array(errors[-4:-1]) / np.array(errors[-3:]))
    stands = errors[-1] < SMALL and np.all(slopes[-2:] > order - SLACK / 2)
    settled = np.ptp(slopes) < SLACK / 2 and np.mean(slopes) < order - WRONG_ORDER
    return bool(stands or settled)
