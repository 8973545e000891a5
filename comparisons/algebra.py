"""Check kind *algebra*: accelerations and mass matrix at random states."""

from __future__ import annotations

import numpy as np

from ..reference import get_scene
from ..reference.scene import Array, Case
from ..reference.solver import state_size
from .engine import Engine, Method, contained
from .prediction import SAFETY, effective_parameters, reference_solution
from .reference_engine import ReferenceEngine
from .verdict import Finding

STATES = 16
SEED = 2011
ROUNDING = 1e-10
"""Relative error granted to closed-form algebra; a thousand times what either engine needs."""


def quantities(case: Case, method: Method | None) -> tuple[str, ...]:
    """Return the names of what is measured."""
    return ("accelerations", "mass_matrix")


def random_states(case: Case) -> tuple[Array, Array]:
    """Return times (k,) and states (k, 2 n), of the size that the case's motion has."""
    scene = get_scene(case.scene)
    times = case.start_time + np.linspace(0, case.horizon, 65)[1:]
    size = state_size(reference_solution(case, times))
    size[[i for i, name in enumerate(scene.coordinates) if name in scene.turning]] = np.pi
    random = np.random.default_rng(SEED)
    period = float(scene.period(case.parameters))
    return period * random.random(STATES), size * random.uniform(-1, 1, (STATES, len(size)))


def measure(engine: Engine, case: Case, model: str, method: Method | None) -> list[Finding]:
    """Compare with the closed form; a known floor of the model widens the tolerance by itself."""
    times, states = random_states(case)
    truth = ReferenceEngine()
    effective = Case(case.scene, case.name, effective_parameters(engine, case, model))
    with contained():
        found = {
            "accelerations": engine.accelerations(case, model, times, states),
            "mass_matrix": engine.mass_matrices(case, model, states),
        }
    expected = {
        "accelerations": truth.accelerations(case, "", times, states),
        "mass_matrix": truth.mass_matrices(case, "", states),
    }
    floored = {
        "accelerations": truth.accelerations(effective, "", times, states),
        "mass_matrix": truth.mass_matrices(effective, "", states),
    }
    findings = []
    for name, reference in expected.items():
        scale = np.max(np.abs(reference), axis=0)
        scale = np.where(scale > 0, scale, 1.0)
        error = float(np.max(np.abs(found[name] - reference) / scale))
        floor = float(np.max(np.abs(floored[name] - reference) / scale))
        findings.append(
            Finding(
                name,
                "1",
                error,
                0.0,
                error,
                ROUNDING + SAFETY * floor,
                f"relative error over {STATES} random states; the model's own floor is {floor:.1e}",
            )
        )
    return findings
