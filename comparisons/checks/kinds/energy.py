"""Check kind *energy*: drift of what a run conserves, against what the method explains."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ....reference.errors import CannotJudgeError, EngineError
from ....reference.scene import Array, Case
from ...engines.equations import ModelEquations, invariants_of, scene_equations
from ...engines.setup import Setup
from ..tolerances import (
    RICHARDSON_SAFETY,
    SAFETY,
    last_trusted_sample,
    rounding,
    rows,
    sample_numbers,
)
from ..truth import permitted_horizon, simulated_horizon, truth
from ..verdict import Finding


def quantities(setup: Setup) -> tuple[str, ...]:
    """Return the names of what is measured."""
    return tuple(f"{name}_drift" for name in invariants_of(scene_equations(setup.case)))


def silent_invariants(equations: ModelEquations, values: Mapping[str, Array]) -> list[str]:
    """Return the invariants that a run gives neither itself nor by its states."""
    if set(equations.scene.state_names) <= set(values):
        return []
    return [name for name in invariants_of(equations) if name not in values]


def drifts(
    equations: ModelEquations, case: Case, times: Any, values: Mapping[str, Array]
) -> dict[str, Array]:
    """Return (I(t) - I) / I (n_t,) of a run, by the reference's formula or as the engine tells.

    What it tells counts where its states do not give it. I is that at the start. Where the scene
    was driven, I(t) is counted from the end of the drive on, relative to the largest value before:
    a pulse may leave none of its momentum.
    """
    scene, c = equations.scene, equations.scene.coefficients(equations.parameters)
    end = scene.drive_end_time(equations.parameters)
    has_states, drift = set(scene.state_names) <= set(values), {}
    for name, invariant in invariants_of(equations).items():
        if name in values and not has_states:
            series = values[name]
        else:
            states = np.array([values[state] for state in scene.state_names])
            series = np.asarray(invariant(*np.split(states, 2), c))
        if end:
            quiet = series[times >= end]
            drift[name] = (quiet - quiet[0]) / np.max(np.abs(series))
        else:
            first = invariant(*np.split(equations.start(case), 2), c)
            drift[name] = (series - first) / first
    return drift


def measure(setup: Setup) -> list[Finding]:
    """Compare the largest drift with that of the scheme, or of half the step.

    Where the model's own equations do not conserve, its drift is what they make of it. What
    bends has its own energy, which it conserves whatever the number of its elements.
    """
    scene, equations = setup.scene, setup.equations
    formula = equations if scene.discretisation_coordinates else scene_equations(setup.case)
    step, epsilon = setup.default_step, setup.epsilon
    _, growth = permitted_horizon(setup.case, step, epsilon)
    scheme = setup.scheme
    horizon = simulated_horizon(setup.case, step, scheme, epsilon)
    samples = sample_numbers(horizon, step, 128)
    times = setup.case.start_time + samples * step
    values = setup.simulate(step, samples).values
    if missing := silent_invariants(formula, values):
        raise CannotJudgeError(
            f"{setup.engine.name} gives neither {', '.join(missing)} nor the states that they "
            "follow from"
        )
    drift = drifts(formula, setup.case, times, values)
    truths, bound = {name: 0 * series for name, series in drift.items()}, 0.0
    if not scene.discretisation_coordinates:
        right = truth(equations, setup.case, times, scene.state_names)
        truths = drifts(
            formula, setup.case, times, dict(zip(scene.state_names, right.values, strict=True))
        )
        bound = float(np.max(right.bound / right.size))
    if scheme:
        states = setup.scheme_states(step, samples)
        ideal = rows(equations, states, scene.state_names)
        others = drifts(
            formula, setup.case, times, dict(zip(scene.state_names, ideal, strict=True))
        )
        factor, safety, reason = 1.0, SAFETY, f"what {scheme} alone drifts"
    else:
        finer = setup.simulate(step / 2, 2 * samples)
        others = drifts(formula, setup.case, times, finer.values)
        gain = 2**setup.integrator.order
        factor, safety, reason = gain / (gain - 1), RICHARDSON_SAFETY, "from half the step"
    findings = []
    for name, series in drift.items():
        expected = truths[name]
        change = np.abs(others[name] - (expected if scheme else series))
        predicted = factor * (change if scheme else np.maximum.accumulate(change))
        seen = last_trusted_sample(predicted)
        if not seen:
            raise EngineError("step", f"h = {step:.3g} s is too coarse to be judged at all")
        room = rounding(int(samples[-1]), growth, epsilon) + bound
        error = float(np.max(np.abs(series - expected)[:seen]))
        findings.append(
            Finding(
                f"{name}_drift",
                "1",
                float(np.max(np.abs(series[:seen]))),
                float(np.max(np.abs(expected[:seen]))) if np.any(abs(expected) > room) else 0.0,
                error,
                safety * float(np.max(predicted[:seen])) + room,
                f"h = {step:.3g} s up to t = {times[seen - 1 - len(series)]:.3g} s; "
                f"predicted {float(np.max(predicted[:seen])):.2g}, {reason}",
            )
        )
    return findings
