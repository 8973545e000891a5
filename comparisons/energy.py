"""Check kind *energy*: drift of a conservative run, against what the method explains."""

from __future__ import annotations

import numpy as np

from ..reference import get_scene
from ..reference.scene import Array, Case
from .engine import Engine, Method
from .prediction import (
    CAP,
    SAFETY,
    default_step,
    permitted_horizon,
    richardson,
    rounding,
    sample_numbers,
    scheme_states,
)
from .trajectory import simulate
from .verdict import Finding


def quantities(case: Case, method: Method | None) -> tuple[str, ...]:
    """Return the name of what is measured."""
    return ("energy_drift",)


def drift(case: Case, states: Array) -> Array:
    """Return (E(t) - E(0)) / E(0) at the samples, by the reference's energy."""
    scene = get_scene(case.scene)
    c = scene.coefficients(case.parameters)
    n = len(scene.coordinates)
    start = scene.state(case.state)
    energy = scene.energy(start[:n], start[n:], c)
    return np.asarray((scene.energy(states[:n], states[n:], c) - energy) / energy)


def measure(engine: Engine, case: Case, model: str, method: Method | None) -> list[Finding]:
    """Compare the largest drift with that of the scheme, or of half the step."""
    assert method is not None
    scene = get_scene(case.scene)
    names = scene.state_names
    horizon, growth = permitted_horizon(case)
    step = default_step(case, method)
    samples = sample_numbers(horizon, step, 128)
    states = simulate(engine, case, model, method, step, samples).matrix(names)
    drifts = drift(case, states)
    if method.scheme:
        ideal = drift(case, scheme_states(engine, case, model, method, step, samples))
        predicted, grant = float(np.max(np.abs(ideal))), SAFETY
        reason = f"{method.scheme} alone drifts by {predicted:.2g}"
    else:
        finer = [
            drift(case, simulate(engine, case, model, method, step / k, k * samples).matrix(names))
            for k in (2, 4)
        ]
        estimate = richardson([drifts, *finer], method.order)
        predicted, grant = estimate.predicted, 1.0
        reason = f"halving divides the change by {estimate.ratio:.3g}"
    value = float(np.max(np.abs(drifts)))
    tolerance = min(grant * predicted, CAP) + rounding(int(samples[-1]), growth)
    return [
        Finding(
            "energy_drift",
            "1",
            value,
            0.0,
            value,
            tolerance,
            f"h = {step:.3g} s over {horizon:.3g} s; {reason}",
        )
    ]
