"""Check kind *trajectory*: a free run of the engine against the reference.

A method whose scheme is published must make exactly the error of that scheme
(`scheme_residual`); for the others the error is predicted from three steps, and what they
extrapolate to must be the reference (`extrapolated`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..reference import get_scene
from ..reference.errors import EngineError
from ..reference.scene import Array, Case
from ..reference.solver import Solution, state_size
from .engine import Engine, Method, Trajectory, run
from .prediction import (
    CAP,
    RICHARDSON_SAFETY,
    SAFETY,
    default_step,
    permitted_horizon,
    reference_solution,
    richardson,
    rounding,
    sample_numbers,
    scheme_states,
    trusted,
)
from .verdict import Finding

REFINEMENTS = 4
"""Times that a step is halved until errors shrink with it as the order says."""


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
    predict = by_scheme if method.scheme else by_extrapolation
    for refinement in range(REFINEMENTS):
        step = default_step(case, method) / 2**refinement
        samples = sample_numbers(horizon, step)
        truth = reference_solution(case, case.start_time + samples * step)
        states = simulate(engine, case, model, method, step, samples).matrix(scene.state_names)
        prediction = predict(engine, case, model, method, step, samples, states, truth)
        if prediction.shrinks:
            break
    size = state_size(truth)
    seen = trusted(prediction.errors / size[:, None])
    if not seen:
        raise EngineError("step", f"h = {step:.3g} s is too coarse to be judged over any time")
    room = rounding(int(samples[-1]), growth)
    note = (
        f"h = {step:.3g} s over {samples[seen - 1] * step:.3g} s; errors grow by {growth:.3g} "
        f"in {horizon:.3g} s"
    )
    findings = []
    for i, name in enumerate(scene.state_names):
        worst = int(np.argmax(np.abs(states[i] - truth.states[i])[:seen]))
        value, reference = float(states[i, worst]), float(truth.states[i, worst])
        error = abs(value - reference)
        predicted = float(np.max(prediction.errors[i, :seen]))
        tolerance = prediction.safety * predicted + truth.error_bound[i] + room * size[i]
        reason = (
            f"worst at t = {truth.times[worst]:.3g} s; {note}; predicted error {predicted:.3g}, "
            f"relative error {error / size[i]:.2g}"
        )
        unit = scene.units[name]
        findings.append(Finding(name, unit, value, reference, error, tolerance, reason))
    away = float(np.max(prediction.residual[:, :seen] / size[:, None]))
    granted = prediction.granted(seen, size) + room + float(np.max(truth.error_bound / size))
    last = quantities(case, method)[-1]
    reason = f"{note}; {prediction.reason}"
    return [*findings, Finding(last, "1", away, 0.0, away, granted, reason)]


@dataclass(frozen=True)
class Prediction:
    """What a correct engine would do.

    Attributes
    ----------
    errors : array (2 n, n_t)
        Predicted error of each state at each sample.
    safety : float
        Factor on them.
    residual : array (2 n, n_t)
        What should vanish if the engine is right.
    spread : array (2 n, n_t)
        By how much it may still differ from 0, rounding apart.
    shrinks : bool
        Whether the error shrinks with the step as declared; no error is granted if not.
    reason : str
    """

    errors: Array
    safety: float
    residual: Array
    spread: Array
    shrinks: bool
    reason: str

    def granted(self, seen: int, size: Array) -> float:
        """Return the relative tolerance of the residual over the samples seen."""
        return min(float(np.max(self.spread[:, :seen] / size[:, None])), CAP**2)


def simulate(
    engine: Engine, case: Case, model: str, method: Method, step: float, samples: Array
) -> Trajectory:
    """Run the engine and record it at these step numbers."""
    return run(engine, case, model, method, step, case.start_time + samples * step)


def by_scheme(
    engine: Engine,
    case: Case,
    model: str,
    method: Method,
    step: float,
    samples: Array,
    states: Array,
    truth: Solution,
) -> Prediction:
    """Predict errors by the method's own scheme on the true equations of motion."""
    ideal = scheme_states(engine, case, model, method, step, samples)
    return Prediction(
        errors=np.abs(ideal - truth.states),
        safety=SAFETY,
        residual=np.abs(states - ideal),
        spread=np.zeros_like(states),
        shrinks=True,
        reason=f"distance from {method.scheme} on the true equations",
    )


def by_extrapolation(
    engine: Engine,
    case: Case,
    model: str,
    method: Method,
    step: float,
    samples: Array,
    states: Array,
    truth: Solution,
) -> Prediction:
    """Predict errors from h, h/2, h/4 (Richardson), if they shrink as declared."""
    scene = get_scene(case.scene)
    half, quarter = (
        simulate(engine, case, model, method, step / k, samples * k).matrix(scene.state_names)
        for k in (2, 4)
    )
    size = state_size(truth)[:, None]
    gain = 2**method.order - 1
    predicted = np.abs(states - half) * (gain + 1) / gain
    before = half + (half - states) / gain
    limit = quarter + (quarter - half) / gain
    seen = max(1, trusted(np.maximum.accumulate(predicted / size, axis=1)))
    estimate = richardson([(run / size)[:, :seen] for run in (states, half, quarter)], method.order)
    shrinks = estimate.shrinks(float(np.max(truth.error_bound / size[:, 0])))
    return Prediction(
        errors=np.maximum.accumulate(predicted, axis=1) if shrinks else 0 * predicted,
        safety=RICHARDSON_SAFETY,
        residual=np.abs(limit - truth.states),
        spread=np.abs(limit - before) if shrinks else 0 * predicted,
        shrinks=shrinks,
        reason=f"value extrapolated to h -> 0; halving divides the error by "
        f"{estimate.ratio:.3g}, {2**method.order} expected",
    )
