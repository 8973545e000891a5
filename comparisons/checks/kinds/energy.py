"""Check kind *energy*: drift of what a run conserves, against what the method explains."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ....reference import get_scene
from ....reference.errors import EngineError
from ....reference.scene import Array, Case
from ...engines.protocol import Engine, Method
from ..prediction import (
    RICHARDSON_SAFETY,
    SAFETY,
    Claim,
    affordable,
    claim,
    default_step,
    exactly,
    permitted_horizon,
    rounding,
    rows,
    sample_numbers,
    scheme_of,
    scheme_states,
    trusted,
    truth,
)
from ..verdict import Finding
from .trajectory import simulate


def invariants(own: Claim) -> Mapping[str, Callable[..., Array]]:
    """Return what a claim conserves where nothing drives it: the energy, and more if it tells."""
    scene = own.scene
    if scene.invariants is None:
        return {"energy": scene.energy}
    return scene.invariants(scene.unforced(own.parameters))


def quantities(engine: Engine, case: Case, model: str, method: Method | None) -> tuple[str, ...]:
    """Return the names of what is measured."""
    return tuple(f"{name}_drift" for name in invariants(exactly(case)))


def drifts(own: Claim, case: Case, times: Any, values: Mapping[str, Array]) -> dict[str, Array]:
    """Return (I(t) - I) / I (n_t,) of a run, by the reference's formula or as the engine tells.

    I is that at the start. Where the scene was driven, I(t) is counted from the end of the
    drive on, relative to the largest value before: a pulse may leave none of its momentum.
    """
    scene, c = own.scene, own.scene.coefficients(own.parameters)
    end = scene.driven_until(own.parameters)
    found = {}
    for name, invariant in invariants(own).items():
        if name in values:
            series = values[name]
        else:
            states = np.array([values[state] for state in scene.state_names])
            series = np.asarray(invariant(*np.split(states, 2), c))
        if end:
            quiet = series[times >= end]
            found[name] = (quiet - quiet[0]) / np.max(np.abs(series))
        else:
            first = invariant(*np.split(own.start(case), 2), c)
            found[name] = (series - first) / first
    return found


def measure(engine: Engine, case: Case, model: str, method: Method | None) -> list[Finding]:
    """Compare the largest drift with that of the scheme, or of half the step.

    Where the model's own equations do not conserve, its drift is what they make of it. What
    bends has its own energy, which it conserves whatever the number of its elements.
    """
    assert method is not None
    scene, own = get_scene(case.scene), claim(engine, case, model)
    formula = own if scene.internal else exactly(case)
    _, growth = permitted_horizon(case)
    step = default_step(case, method, own)
    scheme = scheme_of(engine, case, model, method)
    samples = sample_numbers(affordable(case, step, scheme), step, 128)
    times = case.start_time + samples * step
    found = drifts(
        formula, case, times, simulate(engine, case, model, method, step, samples).values
    )
    truths, bound = {name: 0 * series for name, series in found.items()}, 0.0
    if not scene.internal:
        right = truth(own, case, times, scene.state_names)
        truths = drifts(
            formula, case, times, dict(zip(scene.state_names, right.values, strict=True))
        )
        bound = float(np.max(right.bound / right.size))
    if scheme:
        states = scheme_states(engine, case, own, scheme, step, samples)
        ideal = rows(own, states, scene.state_names)
        others = drifts(formula, case, times, dict(zip(scene.state_names, ideal, strict=True)))
        factor, safety, reason = 1.0, SAFETY, f"what {scheme} alone drifts"
    else:
        finer = simulate(engine, case, model, method, step / 2, 2 * samples)
        others = drifts(formula, case, times, finer.values)
        gain = 2**method.order
        factor, safety, reason = gain / (gain - 1), RICHARDSON_SAFETY, "from half the step"
    findings = []
    for name, series in found.items():
        expected = truths[name]
        change = np.abs(others[name] - (expected if scheme else series))
        predicted = factor * (change if scheme else np.maximum.accumulate(change))
        seen = trusted(predicted)
        if not seen:
            raise EngineError("step", f"h = {step:.3g} s is too coarse to be judged at all")
        room = rounding(int(samples[-1]), growth) + bound
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
