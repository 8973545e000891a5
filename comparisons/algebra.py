"""Check kind *algebra*: accelerations, mass matrix and reactions at random states."""

from __future__ import annotations

import numpy as np

from ..reference import get_scene
from ..reference.scene import Array, Case
from .engine import Engine, Method, contained
from .prediction import Claim, claim, exactly, permitted_horizon, sample_spacing, truth
from .verdict import Finding

STATES = 16
SEED = 2011
ROUNDING = 1e-10
"""Relative error granted to closed-form algebra; a thousand times what either engine needs."""


def quantities(engine: Engine, case: Case, model: str, method: Method | None) -> tuple[str, ...]:
    """Return the names of what is measured."""
    names = ("accelerations", "mass_matrix", *reactions(engine, case, model))
    return names if claim(engine, case, model).stands_for(case) else (*names, "model_error")


def reactions(engine: Engine, case: Case, model: str) -> tuple[str, ...]:
    """Return the joint reactions that an engine's model tells."""
    tell = getattr(engine, "reaction_names", None)
    return tuple(tell(case, model)) if tell else ()


def random_states(case: Case) -> tuple[Array, Array]:
    """Return times (k,) and states (k, 2 n), of the size that the case's motion has."""
    scene = get_scene(case.scene)
    horizon, _ = permitted_horizon(case)
    spacing = sample_spacing(horizon)
    times = case.start_time + spacing * np.arange(1, int(horizon / spacing) + 1)
    size = truth(exactly(case), case, times, scene.state_names).size.copy()
    size[[i for i, name in enumerate(scene.coordinates) if name in scene.turning]] = np.pi
    random = np.random.default_rng(SEED)
    period = float(scene.period(case.parameters))
    return period * random.random(STATES), size * random.uniform(-1, 1, (STATES, len(size)))


def expected(
    case: Case, own: Claim, times: Array, states: Array, names: tuple[str, ...]
) -> dict[str, Array]:
    """Return what a claim says at states (k, 2 n) of the case's scene."""
    scene = get_scene(case.scene)
    derivative = own.scene.right_hand_side(own.parameters)
    # a loop closed by other equations still has the same inertia
    inertial = own.parameters if own.scene is scene else case.parameters
    c = scene.coefficients(inertial)
    own_c = own.scene.coefficients(own.parameters)
    n, own_n = len(scene.coordinates), len(own.scene.coordinates)
    places = [own.scene.coordinates.index(name) for name in scene.coordinates]
    found: dict[str, list[Array]] = {name: [] for name in ("accelerations", "mass_matrix", *names)}
    for time, state in zip(times, states, strict=True):
        values = dict(zip(scene.state_names, map(float, state), strict=True))
        x = own.scene.state(own.scene.embedding(own.parameters, values))
        found["accelerations"].append(derivative(time, x)[own_n:][places])
        found["mass_matrix"].append(np.array(scene.mass_matrix(state[:n], c), dtype=float))
        if names:
            outputs = own.scene.outputs(x[:own_n], x[own_n:], own_c, np)
            for name in names:
                found[name].append(np.array([outputs[name]]))
    return {name: np.array(values) for name, values in found.items()}


def measure(engine: Engine, case: Case, model: str, method: Method | None) -> list[Finding]:
    """Compare with the closed form of what the model claims to be, and that with the scene."""
    times, states = random_states(case)
    names = reactions(engine, case, model)
    own = claim(engine, case, model)
    with contained():
        found = {
            "accelerations": engine.accelerations(case, model, times, states),
            "mass_matrix": engine.mass_matrices(case, model, states),
        }
        if names:
            told = engine.reactions(case, model, times, states)  # type: ignore[attr-defined]
            found |= {name: np.asarray(told[name])[:, None] for name in names}
    truths = expected(case, own, times, states, names)
    reason = f"relative error over {STATES} random states"
    findings = []
    for name, reference in truths.items():
        error = distance(found[name], reference, reference)
        findings.append(Finding(name, "1", error, 0.0, error, ROUNDING, reason))
    if not own.stands_for(case):
        exact = expected(case, exactly(case), times, states, names)
        measured, predicted = (
            max(distance(item[name], exact[name], exact[name]) for name in exact)
            for item in (found, truths)
        )
        error = abs(measured - predicted)
        reason = f"{reason}: what the model is off the scene at any step, against its prediction"
        findings.append(Finding("model_error", "1", measured, predicted, error, ROUNDING, reason))
    return findings


def distance(found: Array, reference: Array, scale: Array) -> float:
    """Return the largest difference, relative to the largest value of each entry."""
    size = np.max(np.abs(scale), axis=0)
    return float(np.max(np.abs(found - reference) / np.where(size > 0, size, np.max(size) or 1.0)))
