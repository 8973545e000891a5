"""Check kind *order*: errors over halved steps, their slope, and what they extrapolate to.

Where a method of high order meets the round-off floor before its slopes have reached the
declared order, those of its own scheme on the true equations are what it has to show.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..reference import get_scene
from ..reference.errors import CannotJudgeError, EngineError
from ..reference.scene import Array, Case
from ..reference.solver import Solution, state_size
from .engine import EPS, Engine, Method
from .prediction import (
    SAFETY,
    effective_parameters,
    permitted_horizon,
    reference_solution,
    scheme_states,
    shortest_period,
)
from .trajectory import simulate
from .verdict import Finding

SLACK = 0.2
"""The finest slopes may stay this much below the declared order."""

LEVELS = 12
POINTS = 5
FLOOR = 30.0
"""An error counts as above the round-off floor where it is this many times larger."""


def quantities(case: Case, method: Method | None) -> tuple[str, ...]:
    """Return the names of what is measured."""
    return ("order", "extrapolated")


def measure(engine: Engine, case: Case, model: str, method: Method | None) -> list[Finding]:
    """Halve the step from a few steps per period until the error reaches the floor."""
    assert method is not None
    scene = get_scene(case.scene)
    horizon, growth = permitted_horizon(case)
    coarsest = 2.0 ** np.floor(np.log2(shortest_period(case) / 8))
    horizon = coarsest * max(4, round(horizon / coarsest))
    marks = np.arange(1, round(horizon / coarsest) + 1)
    truth = reference_solution(case, case.start_time + marks * coarsest)
    size = state_size(truth)
    floor = model_floor(engine, case, model, coarsest, marks)
    steps: list[float] = []
    runs: list[Array] = []
    errors: list[float] = []
    for level in range(LEVELS):
        step = coarsest / 2**level
        bound = noise(len(marks) * 2**level, growth) + float(np.max(truth.error_bound / size))
        try:
            samples = marks * 2**level
            states = simulate(engine, case, model, method, step, samples).matrix(scene.state_names)
        except EngineError as error:
            if error.kind not in ("non_finite", "warning", "solver") or level > LEVELS // 2:
                raise
            continue  # too coarse for this method; finer ones follow
        error_now = relative_error(states, truth)
        lowest = FLOOR * (bound + floor)
        if error_now < lowest and len(errors) >= 2:
            break
        steps.append(step)
        runs.append(states)
        errors.append(error_now)
        if len(errors) >= POINTS and error_now < 1e-4 and stands(errors, method.order):
            break
    if len(errors) < 4:
        raise CannotJudgeError(
            f"only {len(errors)} steps from {coarsest:.3g} s down leave an error above round-off"
        )
    slopes = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    finest = finest_slope(errors)
    expected = float(method.order)
    if method.scheme and finest < expected - SLACK:
        expected = min(expected, ideal_slope(engine, case, model, method, coarsest, marks, lowest))
    listed = ", ".join(f"{slope:.2f}" for slope in slopes[-4:])
    gain = 2**method.order - 1
    limits = [b + (b - a) / gain for a, b in pairwise(runs)]
    last = relative_error(limits[-1], truth)
    spread = float(np.max(np.max(np.abs(limits[-1] - limits[-2]), axis=1) / size))
    tolerance = spread + SAFETY * floor + bound
    return [
        Finding(
            "order",
            "1",
            finest,
            expected,
            max(0.0, expected - finest),
            SLACK,
            f"slopes {listed} down to h = {steps[-1]:.3g} s, error {errors[-1]:.2g}; "
            f"declared {method.order}",
        ),
        Finding(
            "extrapolated",
            "1",
            last,
            0.0,
            last,
            tolerance,
            f"relative error of the value extrapolated to h -> 0 over {horizon:.3g} s",
        ),
    ]


def relative_error(states: Array, truth: Solution) -> float:
    """Return the largest error of any state at any sample, relative to the state's size."""
    return float(np.max(np.max(np.abs(states - truth.states), axis=1) / state_size(truth)))


def ideal_slope(
    engine: Engine,
    case: Case,
    model: str,
    method: Method,
    coarsest: float,
    marks: Array,
    floor: float,
) -> float:
    """Return the finest slope above round-off of the method's scheme on the true equations."""
    truth = reference_solution(case, case.start_time + marks * coarsest)
    errors: list[float] = []
    for level in range(LEVELS):
        numbers = marks * 2**level
        states = scheme_states(engine, case, model, method, coarsest / 2**level, numbers)
        error = relative_error(states, truth)
        if error < floor:
            break
        errors += [error] if np.isfinite(error) else []
    return finest_slope(errors) if len(errors) >= 4 else float(method.order)


def finest_slope(errors: list[float]) -> float:
    """Return the last slope, or the mean of the last two where that is more."""
    slopes = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    return float(max(slopes[-1], np.mean(slopes[-2:])))


def noise(steps: int, growth: float) -> float:
    """Return the relative error that rounding makes, its signs being random."""
    return float(8 * EPS * np.sqrt(steps) * growth)


def stands(errors: list[float], order: int) -> bool:
    """Return whether the last two slopes agree with each other or exceed the order."""
    slopes = np.log2(np.array(errors[-3:-1]) / np.array(errors[-2:]))
    return bool(np.all(slopes > order - SLACK / 2))


def model_floor(engine: Engine, case: Case, model: str, step: float, marks: Array) -> float:
    """Return the relative error that the model's own floor causes, by the reference."""
    effective = effective_parameters(engine, case, model)
    if effective == case.parameters:
        return 0.0
    times = case.start_time + marks * step
    truth = reference_solution(case, times)
    changed = Case(case.scene, case.name, effective, case.state, case.horizon, (), case.start_time)
    moved = reference_solution(changed, times)
    difference = np.max(np.abs(moved.states - truth.states), axis=1)
    return float(np.max(difference / state_size(truth)))
