"""Check kind *trajectory*: a free run of the engine against the reference.

A method whose scheme is published must make exactly the error of that scheme
(`scheme_residual`); for the others the error is predicted from three steps, and what they
extrapolate to must be the reference (`extrapolated`).
"""

from __future__ import annotations

import numpy as np

from ..reference import get_scene
from ..reference.scene import Array, Case
from ..reference.solver import Solution
from .engine import Engine, Method, Trajectory, run
from .prediction import (
    CAP,
    SAFETY,
    default_step,
    permitted_horizon,
    reference_solution,
    richardson,
    rounding,
    sample_numbers,
    scheme_states,
    state_range,
)
from .verdict import Finding


def quantities(case: Case, method: Method | None) -> tuple[str, ...]:
    """Return the names of what is measured: every state, and the test of the method."""
    assert method is not None
    last = "scheme_residual" if method.scheme else "extrapolated"
    return (*get_scene(case.scene).state_names, last)


def measure(engine: Engine, case: Case, model: str, method: Method | None) -> list[Finding]:
    """Run the case with the method's default step and judge every state."""
    assert method is not None
    scene = get_scene(case.scene)
    horizon, growth = permitted_horizon(case)
    step = default_step(case, method)
    samples = sample_numbers(horizon, step)
    truth = reference_solution(case, case.start_time + samples * step)
    first = simulate(engine, case, model, method, step, samples)
    states = first.matrix(scene.state_names)
    if method.scheme:
        predicted, last = by_scheme(engine, case, model, method, step, samples, states, truth)
        grant = SAFETY
        room = rounding(int(samples[-1]), growth)
    else:
        predicted, last = by_extrapolation(engine, case, model, method, step, samples, states, truth)
        grant = 1.0
        room = float(np.max(truth.error_bound / state_range(truth)))
    size = state_range(truth)
    note = f"h = {step:.3g} s; errors grow by {growth:.3g} over {horizon:.3g} s"
    findings = []
    for i, name in enumerate(scene.state_names):
        error = float(np.max(np.abs(states[i] - truth.states[i])))
        tolerance = min(grant * predicted[i], CAP * size[i])
        tolerance += truth.error_bound[i] + rounding(int(samples[-1]), growth) * size[i]
        reason = f"{note}; predicted error {predicted[i]:.3g}, relative {error / size[i]:.2g}"
        unit = scene.units[name]
        findings.append(Finding(name, unit, error, 0.0, error, tolerance, reason))
    error, tolerance, reason = last
    tolerance += room
    findings.append(
        Finding(
            quantities(case, method)[-1], "1", error, 0.0, error, tolerance, f"{note}; {reason}"
        )
    )
    return findings


def simulate(
    engine: Engine, case: Case, model: str, method: Method, step: float, samples: Array
) -> Trajectory:
    """Run the engine and record it at these step numbers."""
    return run(engine, case, model, method, step, case.start_time + samples * step)


Last = tuple[float, float, str]


def by_scheme(
    engine: Engine,
    case: Case,
    model: str,
    method: Method,
    step: float,
    samples: Array,
    states: Array,
    truth: Solution,
) -> tuple[Array, Last]:
    """Predict errors (2 n,) by the method's own scheme; the residual tells it from the engine."""
    ideal = scheme_states(engine, case, model, method, step, samples)
    residual = float(np.max(np.max(np.abs(states - ideal), axis=1) / state_range(truth)))
    predicted = np.max(np.abs(ideal - truth.states), axis=1)
    return predicted, (residual, 0.0, f"distance from {method.scheme} on the true equations")


def by_extrapolation(
    engine: Engine,
    case: Case,
    model: str,
    method: Method,
    step: float,
    samples: Array,
    states: Array,
    truth: Solution,
) -> tuple[Array, Last]:
    """Predict errors (2 n,) from h, h/2, h/4 (Richardson), if they shrink as declared."""
    scene = get_scene(case.scene)
    half, quarter = (
        simulate(engine, case, model, method, step / k, samples * k).matrix(scene.state_names)
        for k in (2, 4)
    )
    size = state_range(truth)[:, None]
    estimate = richardson([run / size for run in (states, half, quarter)], method.order)
    error = float(np.max(np.abs(estimate.limit - truth.states / size)))
    reason = (
        f"value extrapolated to h -> 0; halving divides the error by {estimate.ratio:.3g}, "
        f"{2**method.order} expected"
    )
    if not estimate.shrinks(float(np.max(truth.error_bound / size[:, 0]))):
        return np.zeros(len(states)), (error, 0.0, reason)
    predicted = np.array(
        [
            richardson([run[i] for run in (states, half, quarter)], method.order).predicted
            for i in range(len(states))
        ]
    )
    return predicted, (error, min(estimate.spread, CAP**2), reason)
