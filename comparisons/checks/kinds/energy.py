"""Check kind *energy*: drift of invariants of a run, compared with the drift of the method."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ....reference.equations import ModelEquations, invariants_of, scene_equations
from ....reference.errors import CannotJudgeError, EngineError
from ....reference.scene import Array
from ...engines.setup import Setup
from ..comparison import (
    RICHARDSON_SAFETY,
    SAFETY,
    Measured,
    Part,
    drifts,
    ideal_rows,
    invariant_size,
    last_trusted_sample,
    sample_numbers,
)
from ..truth import permitted_horizon, rounding, simulated_horizon, truth
from ..verdict import Finding

ENERGIES = ("energy", "jacobi")
"""Invariants that have a potential in them, whose zero is chosen."""


def quantities(setup: Setup) -> tuple[str, ...]:
    """Return the names of the measured quantities."""
    return tuple(f"{name}_drift" for name in invariants_of(scene_equations(setup.case)))


def sensor_gaps(setup: Setup, step: float, values: Mapping[str, Array]) -> dict[str, float]:
    """Return the relative distances of reported invariants from those of a run's states.

    The size is the largest value, or the terms that cancel in it. Empty if the states give no
    invariant. An energy is known up to a constant, which is the same for another start: a step from
    there shows a wrong factor even if the run keeps its energy.
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
        terms = abs(invariant_size(invariant, right[0], q, v, c))
        size = max(float(terms), float(np.max(np.abs(right))))
        lost = 8 * setup.epsilon * max(size, float(np.max(np.abs(series))))
        off = max(0.0, float(np.max(np.abs(gap))) - lost)
        gaps[name] = off / size if size else off
    return gaps


def measure(setup: Setup) -> Measured:
    """Compare the largest drift with that of the scheme, or of half the step.

    If the model's own equations do not conserve, the reference is their drift. A beam is judged by
    its model's energy, which it conserves whatever the number of its elements.
    """
    case, step, scheme = setup.case, setup.default_step, setup.scheme
    beam = bool(setup.scene.discretisation_coordinates)
    formula = setup.bound.equations if beam else scene_equations(case)
    samples = sample_numbers(simulated_horizon(case, step, scheme, setup.epsilon), step, 128)
    times, part = case.start_time + samples * step, Part(case, samples)

    def drift_of(values: Mapping[str, Array]) -> dict[str, Array]:
        return drifts(formula, case, times, values)

    values = setup.simulate(step, samples).values
    refuse_untold(setup, formula, values)
    drift, names = drift_of(values), setup.scene.state_names
    expected, bound = {name: 0 * series for name, series in drift.items()}, 0.0
    if not beam:
        right = truth(setup.bound.equations, case, times, names)
        expected = drift_of(dict(zip(names, right.values, strict=True)))
        bound = float(np.max(right.bound / right.size))
    if scheme:
        ideal = ideal_rows(setup, [part], step, names)
        others = drift_of(dict(zip(names, ideal, strict=True)))
        factor, safety, reason = 1.0, SAFETY, f"the drift of {scheme}"
    else:
        others = drift_of(setup.simulate(step / 2, 2 * samples).values)
        gain = 2**setup.integrator.order
        factor, safety, reason = gain / (gain - 1), RICHARDSON_SAFETY, "from half the step"
    _, growth = permitted_horizon(case, step, setup.epsilon)
    room = rounding(int(samples[-1]), growth, setup.epsilon) + bound
    findings, gaps = [], sensor_gaps(setup, step, values)
    for name, series in drift.items():
        change = np.abs(others[name] - (expected[name] if scheme else series))
        predicted = factor * (change if scheme else np.maximum.accumulate(change))
        seen = last_trusted_sample(predicted)
        if not seen:
            raise EngineError("step", f"h = {step:.3g} s is too coarse to be judged at all")
        largest = float(np.max(predicted[:seen]))
        error = float(np.max(np.abs(series - expected[name])[:seen]))
        tolerance = safety * largest + room
        if error <= tolerance < gaps.get(name, 0.0):
            raise EngineError(
                "returned",
                f"Motion.observables[{name!r}] differs by {gaps[name]:.2g} of it from that by the "
                "positions and velocities of the run: return that of the scene, or none",
            )
        most, true = (float(np.max(np.abs(one[:seen]))) for one in (series, expected[name]))
        true = true if np.any(abs(expected[name]) > room) else 0.0
        reason_here = (
            f"h = {step:.3g} s up to t = {times[seen - 1 - len(series)]:.3g} s; "
            f"predicted {largest:.2g}, {reason}"
        )
        findings.append(Finding(f"{name}_drift", "1", most, true, error, tolerance, reason_here))
    return Measured(findings)


def refuse_untold(setup: Setup, formula: ModelEquations, values: Mapping[str, Array]) -> None:
    """Refuse a run that has neither invariants nor the states from which they follow.

    Raises
    ------
    CannotJudgeError
    """
    missing = [name for name in invariants_of(formula) if name not in values]
    if missing and not set(formula.scene.state_names) <= set(values):
        raise CannotJudgeError(
            f"{setup.engine.name} gives neither {', '.join(missing)} nor the states that they "
            "follow from"
        )
