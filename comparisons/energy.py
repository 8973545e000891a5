"""Check kind *energy*: drift of what a run conserves, against what the method explains."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ..reference import get_scene
from ..reference.errors import EngineError
from ..reference.scene import Array, Case
from .engine import Engine, Method
from .prediction import (
    RICHARDSON_SAFETY,
    SAFETY,
    affordable,
    claim,
    default_step,
    permitted_horizon,
    rounding,
    rows,
    sample_numbers,
    scheme_of,
    scheme_states,
    trusted,
    truth,
)
from .trajectory import simulate
from .verdict import Finding


def invariants(case: Case) -> Mapping[str, Callable[..., Array]]:
    """Return what the scene conserves with these parameters: the energy, and more if it tells."""
    scene = get_scene(case.scene)
    return scene.invariants(case.parameters) if scene.invariants else {"energy": scene.energy}


def quantities(engine: Engine, case: Case, model: str, method: Method | None) -> tuple[str, ...]:
    """Return the names of what is measured."""
    return tuple(f"{name}_drift" for name in invariants(case))


def drift(case: Case, invariant: Callable[..., Array], states: Array) -> Array:
    """Return (I(t) - I(0)) / I(0) at the samples, by the reference's formula."""
    scene = get_scene(case.scene)
    c = scene.coefficients(case.parameters)
    first = invariant(*np.split(scene.state(case.state), 2), c)
    return np.asarray((invariant(*np.split(states, 2), c) - first) / first)


def measure(engine: Engine, case: Case, model: str, method: Method | None) -> list[Finding]:
    """Compare the largest drift with that of the scheme, or of half the step.

    Where the model's own equations do not conserve, its drift is what they make of it.
    """
    assert method is not None
    names = get_scene(case.scene).state_names
    own = claim(engine, case, model)
    longest, growth = permitted_horizon(case)
    step = default_step(case, method, own)
    scheme = scheme_of(engine, case, model, method)
    samples = sample_numbers(affordable(longest, step, scheme), step, 128)
    times = case.start_time + samples * step
    states = simulate(engine, case, model, method, step, samples).matrix(names)
    right = truth(own, case, times, names)
    if scheme:
        other = rows(own, scheme_states(engine, case, own, scheme, step, samples), names)
        factor, safety, reason = 1.0, SAFETY, f"what {scheme} alone drifts"
    else:
        other = simulate(engine, case, model, method, step / 2, 2 * samples).matrix(names)
        gain = 2**method.order
        factor, safety, reason = gain / (gain - 1), RICHARDSON_SAFETY, "from half the step"
    findings = []
    for name, invariant in invariants(case).items():
        drifts, expected = (drift(case, invariant, item) for item in (states, right.values))
        change = np.abs(drift(case, invariant, other) - (expected if scheme else drifts))
        predicted = factor * (change if scheme else np.maximum.accumulate(change))
        seen = trusted(predicted)
        if not seen:
            raise EngineError("step", f"h = {step:.3g} s is too coarse to be judged at all")
        room = rounding(int(samples[-1]), growth) + float(np.max(right.bound / right.size))
        error = float(np.max(np.abs(drifts - expected)[:seen]))
        findings.append(
            Finding(
                f"{name}_drift",
                "1",
                float(np.max(np.abs(drifts[:seen]))),
                float(np.max(np.abs(expected[:seen]))) if np.any(abs(expected) > room) else 0.0,
                error,
                safety * float(np.max(predicted[:seen])) + room,
                f"h = {step:.3g} s over {samples[seen - 1] * step:.3g} s; "
                f"predicted {float(np.max(predicted[:seen])):.2g}, {reason}",
            )
        )
    return findings
