"""Check kind *step*: one step from each of some states of the reference.

Between accelerations and a free run: what a method does wrong in a single step shows here, at
the state where it does, before later steps hide or amplify it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....reference import get_scene
from ....reference.scene import Array, Case
from ...engines.protocol import Engine, Method, run_many
from ...judge.slips import other_measure
from ..prediction import (
    VIOLATION,
    Claim,
    Truth,
    affordable,
    claim,
    default_step,
    exactly,
    exchanged,
    observables,
    rounding,
    rows,
    sample_numbers,
    scheme_of,
    scheme_states,
    sharp_truth,
    truth,
)
from ..verdict import Finding
from .trajectory import REFINEMENTS, Prediction, by_extrapolation, by_scheme, relative, unit_of

STATES = 8


def quantities(engine: Engine, case: Case, model: str, method: Method | None) -> tuple[str, ...]:
    """Return the observables, and the test of the method.

    None of a model whose states are not those of a reference, and none of a run that starts
    with its loop open.
    """
    assert method is not None
    if case.inconsistency or not startable(engine, case, model):
        return ()
    last = "scheme_residual" if scheme_of(engine, case, model, method) else "extrapolated"
    return (*observables(engine, case, model), last)


def startable(engine: Engine, case: Case, model: str) -> bool:
    """Return whether a model can be put into every state of a reference."""
    scene = get_scene(case.scene)
    own = claim(engine, case, model).scene if scene.internal else scene
    return exchanged(engine, case, model) == own.coordinates


def starts(case: Case, own: Claim, step: float, scheme: str | None) -> list[Case]:
    """Return the case as it would start at each of some times of its reference."""
    horizon = affordable(case, step, scheme)
    times = case.start_time + step * sample_numbers(horizon, step, STATES)
    source = own if get_scene(case.scene).internal else exactly(case)
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


def measure(engine: Engine, case: Case, model: str, method: Method | None) -> list[Finding]:
    """Judge every observable after the step that errs most beside its tolerance."""
    assert method is not None
    names = observables(engine, case, model)
    own = claim(engine, case, model)
    scheme = scheme_of(engine, case, model, method)
    for refinement in range(REFINEMENTS):
        step = default_step(case, method, own) / 2**refinement
        cases = starts(case, own, step, scheme)
        right = truths(own, cases, step, names)
        size = truth(own, case, [one.start_time for one in cases], names).size
        right = replace(right, size=np.maximum(size, right.size))
        values = after(engine, cases, model, method, step, 1, names)
        how = engine, cases, model, method, step, own, scheme
        prediction = predicted(*how, values, right, names)
        if prediction.shrinks:
            break
    errors = np.abs(values - right.values)
    findings = []
    for i, name in enumerate(names):
        room = max(rounding(1, 1.0), VIOLATION if name.endswith("_violation") else 0.0)
        granted = prediction.safety * prediction.errors[i] + right.bound[i] + room * right.size[i]
        worst = int(np.argmax(errors[i] / granted))
        reason = (
            f"h = {step:.3g} s from the reference's state at t = {cases[worst].start_time:.4g} s, "
            f"worst of {len(cases)}; {prediction.reason}"
        )
        if errors[i, worst] > granted[worst]:
            measure = name, unit_of(case, name), values[i], right.values[i], float(right.size[i])
            reason = "; ".join(filter(None, [reason, other_measure(*measure)]))
        findings.append(
            Finding(
                name,
                unit_of(case, name),
                float(values[i, worst]),
                float(right.values[i, worst]),
                float(errors[i, worst]),
                float(granted[worst]),
                reason,
            )
        )
    states = [i for i, name in enumerate(names) if not name.endswith("_violation")]
    away = relative(prediction.limit, right.values, right.size, states, len(cases))
    room = rounding(1, 1.0) + float(np.max((right.bound / right.size)[states]))
    room += prediction.granted(len(cases), right.size, states)
    last = "scheme_residual" if scheme else "extrapolated"
    return [*findings, Finding(last, "1", away, 0.0, away, room, prediction.reason)]


def truths(own: Claim, cases: list[Case], step: float, names: tuple[str, ...]) -> Truth:
    """Return the claim's solution (k, n) one step after each start."""
    found = [sharp_truth(own, one, np.array([one.start_time + step]), names) for one in cases]
    return Truth(
        times=np.concatenate([one.times for one in found]),
        values=np.hstack([one.values for one in found]),
        bound=np.max([one.bound for one in found], axis=0),
        size=np.max([one.size for one in found], axis=0),
        states=np.hstack([one.states for one in found]),
    )


def after(
    engine: Engine,
    cases: list[Case],
    model: str,
    method: Method,
    step: float,
    parts: int,
    names: tuple[str, ...],
) -> Array:
    """Return observables (k, n) one step after each start, taken in so many parts.

    Raises
    ------
    EngineError
        Of the first run that failed.
    """
    steps = np.full(len(cases), step / parts)
    times = np.array([[one.start_time + step] for one in cases])
    columns = []
    for found in run_many(engine, cases, model, method, steps, times):
        if isinstance(found, Exception):
            raise found
        columns.append(found.matrix(names)[:, 0])
    return np.array(columns).T


def predicted(
    engine: Engine,
    cases: list[Case],
    model: str,
    method: Method,
    step: float,
    own: Claim,
    scheme: str | None,
    values: Array,
    right: Truth,
    names: tuple[str, ...],
) -> Prediction:
    """Predict the error of one step from each start."""
    if scheme is None:
        finer = [after(engine, cases, model, method, step, k, names) for k in (2, 4)]
        found = by_extrapolation(method.order, [values, *finer], right, names)
        largest = np.max(found.errors, axis=1, keepdims=True)  # its first term may vanish at one
        largest = largest * slower([values, *finer], method.order)
        return replace(found, errors=np.broadcast_to(largest, values.shape))
    ideal = [
        rows(own, scheme_states(engine, one, own, scheme, step, np.array([1])), names)
        for one in cases
    ]
    return by_scheme(scheme, values, np.hstack(ideal), right)


def slower(runs: list[Array], order: int) -> Array:
    """Return by how much errors (k, 1) exceed a prediction of this order that is not met yet.

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
    found: Array = ratio / (ratio - 1) * (full - 1) / full
    return found
