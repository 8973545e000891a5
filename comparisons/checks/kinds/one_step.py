"""Check kind *step*: one step from each of some states of the reference.

A mistake of a method in a single step shows here, at the state where it happens, before later steps
hide or amplify it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ....reference import get_scene
from ....reference.equations import ModelEquations, scene_equations
from ....reference.errors import EngineError
from ....reference.scene import Array, Case
from ....reference.solve.schemes import OF_VELOCITIES, VelocityEquations, mean_acceleration
from ...engines.setup import Setup, power_of_two, run_many
from ..comparison import (
    CAP,
    REFINEMENTS,
    Measured,
    Part,
    Prediction,
    RunComparison,
    by_extrapolation,
    by_scheme,
    conclusion,
    ideal_rows,
    largest_share,
    least_error,
    richardson,
    sample_numbers,
    taylor_remainder,
    unfollowed_vibrations,
)
from ..truth import Truth, after_starts, rounding, rows, simulated_horizon, truth
from ..verdict import Finding, Inconclusive

STATES = 8

SETTLED = 48
"""Steps after which a method without a scheme is extrapolated. One with accelerations as variables
begins with an error that decays over some steps (GeneralizedAlpha: by 0.9 in each) and would hide
other errors in fewer steps. Parts of one step would do, but Newton's tolerance divided by ever
shorter steps is an ever larger error of velocities."""

BEGINNING = (8, 16, 32)
"""Divisions of a step that are tried if errors with 1, 2 and 4 do not shrink as declared: a
multistep method starts with another one, whose error dominates in few steps."""

OFF_GRID = round(2**30 / 3) / 2**30
"""Part of a step: a clock that adds up steps of 64 bits is exact there, one of 32 bits is not."""

LONGER = 8
"""Multiple of the default step at which the least error of an order is judged."""


def quantities(setup: Setup) -> tuple[str, ...]:
    """Return the observables, and the test of the method.

    None of a model whose states are not those of a reference, and none of a run that starts
    with its loop open.
    """
    scene = setup.scene
    equations = setup.bound.solved_equations.scene if scene.discretisation_coordinates else scene
    same = setup.bound.discrete or setup.bound.coordinates == equations.coordinates
    if setup.case.inconsistency or not same:
        return ()
    last = () if setup.scheme else ("extrapolated", "least_error")
    by_scheme = setup.scheme or scheme_of_velocities(setup)
    return (*setup.bound.observables, *last, *(("scheme_residual",) if by_scheme else ()))


def scheme_of_velocities(setup: Setup) -> str | None:
    """Return the scheme of the velocities, where rotations make it none of the states.

    How an engine advances rotations is not declared; of these schemes it does not matter in a step.
    """
    scheme, in_space = setup.integrator.scheme, setup.scene.quaternions and in_coordinates(setup)
    return scheme if in_space and not setup.scheme and scheme in OF_VELOCITIES else None


def in_coordinates(setup: Setup) -> bool:
    """Return True if a model has the coordinates of its scene, and no others."""
    scene = setup.bound.solved_equations.scene
    others = setup.bound.has_constraints or scene.discretisation_coordinates
    return scene is setup.scene and not others


def starts(setup: Setup, step: float, scheme: str | None) -> list[Case]:
    """Return the case as it would start at each of some times of its reference.

    Where a function of time drives it, these lie off the grid of steps, `OFF_GRID`.
    """
    case, equations = setup.case, setup.bound.solved_equations
    horizon = simulated_horizon(case, step, scheme)
    numbers = sample_numbers(horizon, step, STATES)
    ends = setup.scene.drive_end_time(case.parameters)
    late = OFF_GRID if driven_in_time(setup, equations) and not ends else 0.0
    times = case.start_time + step * (numbers + late)
    source = (
        equations if get_scene(case.scene).discretisation_coordinates else scene_equations(case)
    )
    states = truth(source, case, times, source.scene.state_names).states.T
    names = source.scene.state_names
    return [
        replace(
            case,
            state=dict(zip(names, map(float, state), strict=True)),
            start_time=float(time),
            horizon=step,
        )
        for time, state in zip(times, states, strict=True)
    ]


def measure(setup: Setup) -> Measured:
    """Judge every observable after the step with the largest ratio of error to tolerance."""
    for refinement in range(REFINEMENTS):
        steps = with_step(setup, setup.default_step / 2**refinement)
        if steps.prediction.shrinks:
            break
    reason, step = steps.prediction.reason, steps.step
    cases = [one.case for one in steps.parts]

    def describe(row: int, worst: int) -> str:
        return (
            f"h = {step:.3g} s from the reference's state at t = {cases[worst].start_time:.4g} s, "
            f"worst of {len(cases)}; {reason}"
        )

    findings = steps.observables(describe, over_time=False)
    if setup.scheme:
        away = steps.largest(steps.prediction.limit - steps.right.values)
        findings.append(steps.limit("scheme_residual", away, 0.0, reason))
        return Measured(findings, steps.runs)
    findings += [limit_of_steps(setup, cases, step, steps.right.size), error_from_below(setup)]
    if scheme_of_velocities(setup):
        findings.append(residual_of_velocities(setup, cases, step, steps.values, steps.right.size))
    return Measured(findings, steps.runs)


def with_step(setup: Setup, step: float) -> RunComparison:
    """Take one step [s] from each start, and predict the error."""
    cases, names = starts(setup, step, setup.scheme), setup.bound.observables
    right = after_starts(setup.bound.solved_equations, cases, step, names)
    begins = [one.start_time for one in cases]
    size = truth(setup.bound.solved_equations, setup.case, begins, names).size
    right = replace(right, size=np.maximum(size, right.size))
    values = after(setup, cases, step, 1)
    prediction = predict(setup, cases, step, values, right)
    room, units, count = rounding(1, 1.0, setup.epsilon), setup.scene.units, len(cases)
    parts = [Part(one, np.array([1])) for one in cases]
    return RunComparison(names, units, values, right, prediction, room, count, setup, step, parts)


def limit_of_steps(
    setup: Setup, cases: list[Case], step: float, size: Array
) -> Finding | Inconclusive:
    """Judge what some steps [s] from each start extrapolate to, where they are halved twice."""
    names, whole = setup.bound.observables, SETTLED * step
    unsharp = rounding(4 * SETTLED, 1.0)  # no less is granted
    right = after_starts(setup.bound.solved_equations, cases, whole, names, unsharp)
    runs = [after(setup, cases, whole, parts * SETTLED) for parts in (1, 2, 4)]
    estimate = richardson(runs, setup.integrator.order)
    count, size = len(setup.scene.observables), np.maximum(size, right.size)

    def largest(errors: Array) -> float:
        return largest_share(errors[:count], size[:count])

    away, known = largest(estimate.limit - right.values), right.bound
    known = known + rounding(4 * SETTLED, 1.0, setup.epsilon) * right.scale
    room = float(np.max((known / size)[:count]))
    reason = (
        f"value after {SETTLED} steps of {step:.3g} s, extrapolated to h -> 0; halving divides the "
        f"error by {estimate.ratio:.3g}, {2**estimate.order} expected"
    )
    granted = room + min(largest(estimate.moved), CAP**2)
    finding = Finding("extrapolated", "1", away, 0.0, away, granted, reason)
    change = largest(runs[0] - runs[1])
    if not setup.bound.discrete or conclusion(finding, change, "shaken") is finding:
        return finding
    shaken = (
        unfollowed_vibrations(setup.with_case(one), step, whole, right, room) for one in cases
    )
    return conclusion(finding, change, next(filter(None, shaken), ""))


def error_from_below(setup: Setup) -> Finding | Inconclusive:
    """Judge if the error of one long step from some states is as large as its order requires."""
    equations, order = setup.bound.solved_equations, setup.integrator.order
    names = setup.scene.observables
    step = min(LONGER * setup.default_step, power_of_two(setup.stable_step_bound))
    cases = starts(setup, step, None)
    ahead = step * np.arange(order + 2)
    begins = np.array([one.start_time for one in cases])
    if equations.scene.stiff:  # the whole motion takes long, at times that no one else asks for
        right = after_starts(equations, cases, ahead, names)
        motion = right.values.reshape(len(names), len(cases), -1)
        size = np.maximum(truth(equations, setup.case, begins, names).size, right.size)
    else:
        times, places = np.unique(begins[:, None] + ahead, return_inverse=True)
        right = truth(equations, setup.case, times, names)
        motion = right.values[:, places].reshape(len(names), len(cases), -1)
        size = right.size
    try:
        values = after(setup, cases, step, 1)[
            [setup.bound.observables.index(name) for name in names]
        ]
    except EngineError as failure:
        if failure.kind != "solver":
            raise
        return Inconclusive("least_error", f"a step of {step:.3g} s is too long: {failure.message}")
    error = np.max(np.abs(values - motion[:, :, 1]) / size[:, None])
    remainder = taylor_remainder(motion, size, order)
    bound = float(np.max((right.bound + rounding(1, 1.0, setup.epsilon) * right.scale) / size))
    return least_error(order, step, float(error), bound, remainder)


def driven_in_time(setup: Setup, equations: ModelEquations) -> bool:
    """Return True if a drive is a function of time, and no body of the model."""
    return equations.scene.drive is not None and not setup.bound.integrates_drive


def after(setup: Setup, cases: list[Case], step: float, parts: int) -> Array:
    """Return observables (k, n) one step [s] after each start, taken in so many parts.

    Raises
    ------
    EngineError
        Of the first run that failed.
    """
    steps = np.full(len(cases), step / parts)
    times = np.array([[one.start_time + step] for one in cases])
    columns = []
    for run in run_many(setup, cases, steps, times):
        if isinstance(run, Exception):
            raise run
        columns.append(run.matrix(setup.bound.observables)[:, 0])
    return np.array(columns).T


def predict(
    setup: Setup, cases: list[Case], step: float, values: Array, right: Truth
) -> Prediction:
    """Predict the error of one step [s] from each start, where the engine has these values."""
    order, names = setup.integrator.order, setup.bound.observables
    if setup.scheme is None:
        runs = [values, *(after(setup, cases, step, parts) for parts in (2, 4))]
        prediction = by_extrapolation(order, runs, right, names)
        for parts in BEGINNING:
            if prediction.shrinks:
                break
            runs = [*runs[1:], after(setup, cases, step, parts)]
            prediction = by_extrapolation(order, runs, right, names)
            errors = prediction.shrinks * np.abs(values - prediction.limit)
            prediction = replace(prediction, errors=errors)
        largest = np.max(prediction.errors, axis=1, keepdims=True)  # its first term may vanish
        errors = np.tile(largest * slower(runs, order), values.shape[1])
        if order == 1 and in_coordinates(setup):
            places, bounds = first_order_errors(setup, cases, step, right)
            errors[places] = np.minimum(errors[places], bounds)
        return replace(prediction, errors=errors)
    ideal = ideal_rows(setup, [Part(one, np.array([1])) for one in cases], step, names)
    return by_scheme(setup.scheme, values, ideal, right)


def velocities_at(
    setup: Setup, cases: list[Case]
) -> tuple[VelocityEquations, list[int], list[tuple[Any, ...]]]:
    """Return the equations of velocities, their rows among observables, and (t, q, w) at starts."""
    equations = setup.bound.solved_equations
    of = VelocityEquations(equations.scene, equations.parameters)
    states = [(one.start_time, equations.start(one)) for one in cases]
    starts = [(t, x[: len(x) // 2], rows(equations, x[:, None], of.names)[:, 0]) for t, x in states]
    return of, [setup.bound.observables.index(name) for name in of.names], starts


def residual_of_velocities(
    setup: Setup, cases: list[Case], step: float, values: Array, size: Array
) -> Finding | Inconclusive:
    """Judge velocities after a step by the scheme that they have."""
    scheme, name = f"{scheme_of_velocities(setup)}", "scheme_residual"
    kinds = setup.bound.system(setup.case).kinds
    if kinds == ("free",) and scheme.startswith("implicit"):
        reason = "engines rotate a single floating body by other implicit rules"
        return Inconclusive(name, reason)
    (of, places, starts), damping = velocities_at(setup, cases), OF_VELOCITIES[scheme]
    ideal = [w + step * mean_acceleration(of, t, q, w, step, damping) for t, q, w in starts]
    away = float(np.max(np.abs(values[places] - np.transpose(ideal)) / size[places, None]))
    room, reason = rounding(1, 1.0, setup.epsilon), f"distance of velocities from {scheme}"
    return Finding(name, "1", away, 0.0, away, room, reason)


def first_order_errors(
    setup: Setup, cases: list[Case], step: float, right: Truth
) -> tuple[list[int], Array]:
    """Return rows of velocities, and by how much (k, n) a step of a right method of order 1 errs.

    It takes each argument of the accelerations somewhere between the start and the end of the step,
    and returns velocities at most half a step off, by accelerations of the start or of the end.
    """
    of, places, starts = velocities_at(setup, cases)
    at_end = zip(
        right.states.T, rows(setup.bound.solved_equations, right.states, of.names).T, strict=True
    )
    errors = []
    for (t, q, w), (later, faster) in zip(starts, at_end, strict=True):
        moved = ((t, q, np.where(one, faster, w)) for one in np.eye(of.n))
        arguments = [(t, q, w), (t, q, 0 * w), (t + step, q, w), (t, later[: len(q)], w), *moved]
        pushed, still, *others = (mean_acceleration(of, *at, step) for at in arguments)
        change = np.sum(np.abs(np.array(others) - pushed), axis=0)
        errors.append(step / 2 * (2 * change + np.abs(still) + np.abs(pushed - still)))
    return places, np.array(errors).T


def slower(runs: list[Array], order: int) -> Array:
    """Return the factor by which errors (k, 1) exceed a prediction before the asymptotic range.

    From the ratio r of the changes with h, h/2, h/4 of each row: the error is r / (r - 1) times
    the first change, where the order promises 2^p / (2^p - 1).
    """
    values, half, quarter = runs
    first, second = (
        np.max(np.abs(a - b), axis=1, keepdims=True) for a, b in ((values, half), (half, quarter))
    )
    full = 2.0**order
    ratio = np.clip(first / np.where(second > 0, second, np.inf), 2 ** (order - 0.5), full)
    ratio = np.where(second > 0, ratio, full)
    excess: Array = ratio / (ratio - 1) * (full - 1) / full
    return excess
