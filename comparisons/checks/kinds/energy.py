"""Check kind *energy*: drift of what a run conserves, against what the method explains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ....reference.equations import ModelEquations, invariants_of, scene_equations
from ....reference.errors import CannotJudgeError, EngineError
from ....reference.scene import Array, Case
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

ENERGIES = ("energy", "jacobi")
"""Invariants that have a potential in them, whose zero is chosen."""

CANCELLED = 1e-3
"""Share of its terms below which an invariant is a sum that cancels."""


def quantities(setup: Setup) -> tuple[str, ...]:
    """Return the names of what is measured."""
    return tuple(f"{name}_drift" for name in invariants_of(scene_equations(setup.case)))


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
            q, v = np.split(equations.start(case), 2)
            first = invariant(q, v, c)
            drift[name] = (series - first) / size_of(invariant, first, q, v, c)
    return drift


def sensor_gaps(setup: Setup, step: float, values: Mapping[str, Array]) -> dict[str, float]:
    """Return by how much what a run shows of invariants is off its states, relative to its size.

    That is the largest value, or the terms that cancel in it. None where its states give none. An
    energy is known up to a constant, the same from another start as well: a step of that tells a
    factor, where a run keeps its energy.
    """
    equations = setup.bound.discrete or scene_equations(setup.case)
    scene, c = equations.scene, equations.scene.coefficients(equations.parameters)
    sensed = invariants_of(equations).keys() & values.keys()
    # a loop that gives way has energies that no formula has
    rigid = setup.bound.discrete or not setup.bound.has_soft_closure
    if not (sensed and rigid and set(scene.state_names) <= set(values)):
        return {}
    runs = [values]
    if setup.case.state:
        whole = {name for one in setup.scene.quaternions for name in one.coordinates}
        state = {name: x if name in whole else x / 2 for name, x in setup.case.state.items()}
        slower = setup.with_case(replace(setup.case, state=state))
        runs.append(slower.simulate(step, np.array([1])).values)
    states = np.hstack([np.array([run[name] for name in scene.state_names]) for run in runs])
    gaps = {}
    for name in sensed:
        series = np.concatenate([run[name] for run in runs])
        invariant = invariants_of(equations)[name]
        right = np.asarray(invariant(*np.split(states, 2), c))
        gap = series - right
        gap -= gap[0] if name in ENERGIES else 0.0
        q, v = np.split(states[:, 0], 2)
        terms = abs(size_of(invariant, right[0], q, v, c))
        size = max(float(terms), float(np.max(np.abs(right))))
        lost = 8 * setup.epsilon * max(size, float(np.max(np.abs(series))))
        off = max(0.0, float(np.max(np.abs(gap))) - lost)
        gaps[name] = off / size if size else off
    return gaps


def size_of(invariant: Any, first: Any, q: Array, v: Array, c: Any) -> Any:
    """Return to what a drift is related: the value at the start, or terms that cancel in it.

    The terms are what each rate (n,) alone makes of it: a momentum may be the small difference of
    large ones, or 0.
    """
    terms = sum(
        abs(invariant(q, rate * unit, c)) for rate, unit in zip(v, np.eye(len(v)), strict=True)
    )
    return first if abs(first) > CANCELLED * terms else terms


def measure(setup: Setup) -> list[Finding]:
    """Compare the largest drift with that of the scheme, or of half the step.

    Where the model's own equations do not conserve, its drift is what they make of it. What
    bends has its own energy, which it conserves whatever the number of its elements.
    """
    scene, equations = setup.scene, setup.bound.equations
    formula = equations if scene.discretisation_coordinates else scene_equations(setup.case)
    step, epsilon = setup.default_step, setup.epsilon
    _, growth = permitted_horizon(setup.case, step, epsilon)
    scheme = setup.scheme
    horizon = simulated_horizon(setup.case, step, scheme, epsilon)
    samples = sample_numbers(horizon, step, 128)
    times = setup.case.start_time + samples * step
    values = setup.simulate(step, samples).values
    missing = [name for name in invariants_of(formula) if name not in values]
    if missing and not set(formula.scene.state_names) <= set(values):
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
    gaps = sensor_gaps(setup, step, values)
    for name, series in drift.items():
        expected = truths[name]
        change = np.abs(others[name] - (expected if scheme else series))
        predicted = factor * (change if scheme else np.maximum.accumulate(change))
        seen = last_trusted_sample(predicted)
        if not seen:
            raise EngineError("step", f"h = {step:.3g} s is too coarse to be judged at all")
        room = rounding(int(samples[-1]), growth, epsilon) + bound
        error = float(np.max(np.abs(series - expected)[:seen]))
        tolerance = safety * float(np.max(predicted[:seen])) + room
        if error <= tolerance < gaps.get(name, 0.0):
            raise EngineError(
                "returned",
                f"Motion.observables[{name!r}] is off by {gaps[name]:.2g} of it from that by the "
                "positions and velocities of the run: tell that of the scene, or none",
            )
        findings.append(
            Finding(
                f"{name}_drift",
                "1",
                float(np.max(np.abs(series[:seen]))),
                float(np.max(np.abs(expected[:seen]))) if np.any(abs(expected) > room) else 0.0,
                error,
                tolerance,
                f"h = {step:.3g} s up to t = {times[seen - 1 - len(series)]:.3g} s; "
                f"predicted {float(np.max(predicted[:seen])):.2g}, {reason}",
            )
        )
    return findings
