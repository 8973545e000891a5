"""Check kind *frequency*: modes from the engine's own M, K, C against the reference's."""

from __future__ import annotations

import numpy as np

from ..reference import get_scene
from ..reference.linear import Mode, linearise, modes
from ..reference.scene import Array, Case
from .engine import Engine, Method, contained
from .prediction import SAFETY, effective_parameters
from .verdict import Finding

BACKWARD_ERROR = 1e-11
"""Relative error granted to an engine's M, C, K. They are differences of forces with steps
near 1e-3, whose rounding is eps / 1e-3 = 2e-13 of the largest force."""


def quantities(case: Case, method: Method | None) -> tuple[str, ...]:
    """Return the names of what is measured: undamped modes, then eigenvalues with damping."""
    return tuple(name for name, _, _ in expected(case, case.parameters))


def expected(case: Case, parameters: object) -> list[tuple[str, Mode, float]]:
    """Return name, mode and tolerance [1/s] of each mode about the case's state."""
    scene = get_scene(case.scene)
    mass, damping, stiffness = linearise(scene, parameters, scene.state(case.state))
    undamped = modes(mass, 0 * mass, stiffness)
    top = max(mode.omega for mode in undamped)
    named = [
        (
            f"undamped_omega_{i}",
            mode,
            BACKWARD_ERROR * top * (top / mode.omega)
            if mode.damping_ratio is not None
            else np.sqrt(BACKWARD_ERROR) * top,
        )
        for i, mode in enumerate(undamped, start=1)
    ]
    if np.any(damping):
        named += [
            (f"eigenvalue_{i}", mode, sensitivity(mass, damping, stiffness, mode))
            for i, mode in enumerate(modes(mass, damping, stiffness), start=1)
        ]
    return named


def sensitivity(mass: Array, damping: Array, stiffness: Array, mode: Mode) -> float:
    """Bound on the change of an eigenvalue when M, C, K change by `BACKWARD_ERROR`.

    The condition number of the quadratic eigenvalue problem (Tisseur 2000, theorem 5), with
    coordinates scaled to unit inertia so that metres and radians compare.
    """
    root = 1 / np.sqrt(np.diag(mass))
    m, c, k = (matrix * np.outer(root, root) for matrix in (mass, damping, stiffness))
    value = complex(mode.re, mode.im)
    left, _, right = np.linalg.svd(value**2 * m + value * c + k)
    x, y = right[-1].conj(), left[:, -1]
    change = abs(value) ** 2 * np.linalg.norm(m, 2) + abs(value) * np.linalg.norm(c, 2)
    change += np.linalg.norm(k, 2)
    return float(BACKWARD_ERROR * change / abs(y.conj() @ (2 * value * m + c) @ x))


def measure(engine: Engine, case: Case, model: str, method: Method | None) -> list[Finding]:
    """Compare the engine's modes with those of the reference, pair by pair."""
    scene = get_scene(case.scene)
    with contained():
        mass, damping, stiffness = engine.linearise(case, model, scene.state(case.state))
    found = modes(mass, 0 * mass, stiffness)
    if np.any(linearise(scene, case.parameters, scene.state(case.state))[1]):
        found = found + modes(mass, damping, stiffness)
    truth = expected(case, case.parameters)
    floored = expected(case, effective_parameters(engine, case, model))
    findings = []
    for i, (name, mode, tolerance) in enumerate(truth):
        value = found[i] if i < len(found) else None
        floor = abs(eigenvalue(floored[i][1]) - eigenvalue(mode))
        error = abs(eigenvalue(value) - eigenvalue(mode)) if value else float("inf")
        findings.append(
            Finding(
                name,
                "1/s",
                value.omega if value else float("nan"),
                mode.omega,
                error,
                tolerance + SAFETY * floor,
                f"M, C, K granted {BACKWARD_ERROR:.0e}; {len(found)} modes found, "
                f"{len(truth)} expected",
            )
        )
    return findings


def eigenvalue(mode: Mode) -> complex:
    """Return re + i im."""
    return complex(mode.re, mode.im)
