"""Check kind *energy*: drift of a conservative run, against what the method explains."""

from __future__ import annotations

import numpy as np

from ..reference import get_scene
from ..reference.errors import EngineError
from ..reference.scene import Array, Case
from .engine import Engine, Method
from .prediction import (
    RICHARDSON_SAFETY,
    SAFETY,
    default_step,
    permitted_horizon,
    rounding,
    sample_numbers,
    scheme_states,
    trusted,
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
        predicted = np.abs(drift(case, scheme_states(engine, case, model, method, step, samples)))
        safety = SAFETY
        reason = f"what {method.scheme} alone drifts"
    else:
        half = simulate(engine, case, model, method, step / 2, 2 * samples)
        gain = 2**method.order
        change = np.abs(drifts - drift(case, half.matrix(names)))
        predicted = np.maximum.accumulate(change) * gain / (gain - 1)
        safety = RICHARDSON_SAFETY
        reason = "from half the step"
    seen = trusted(predicted)
    if not seen:
        raise EngineError("step", f"h = {step:.3g} s is too coarse to be judged over any time")
    value, expected = (float(np.max(np.abs(item[:seen]))) for item in (drifts, predicted))
    tolerance = safety * expected + rounding(int(samples[-1]), growth)
    return [
        Finding(
            "energy_drift",
            "1",
            value,
            0.0,
            value,
            tolerance,
            f"h = {step:.3g} s over {samples[seen - 1] * step:.3g} s; "
            f"predicted {expected:.2g}, {reason}",
        )
    ]
