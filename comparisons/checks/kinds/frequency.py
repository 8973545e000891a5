"""Check kind *frequency*: modes from the engine's own M, K, C against the reference's."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ....reference import get_scene
from ....reference.linear import Mode, linearise, modes
from ....reference.scene import Array, Case, Scene
from ...engines.run import contained
from ...engines.setup import Setup
from .. import elements
from ..comparison import Measured, matrix_rounding, model_error
from ..verdict import Finding

BACKWARD_ERROR = 1e-11
"""Relative error granted to an engine's M, C, K. They are differences of forces with steps
near 1e-3, whose rounding is eps / 1e-3 = 2e-13 of the largest force."""


def quantities(setup: Setup) -> tuple[str, ...]:
    """Return the names of the measured quantities: undamped modes, then damped eigenvalues."""
    if setup.scene.continuum.spectrum:
        return (*(f"omega_{i}" for i in range(1, elements.COUNT + 1)), "model_error")
    names = tuple(name for name, _, _ in expected(*resting(setup.case)))
    return names if inertial(setup) == setup.case.parameters else (*names, "model_error")


def inertial(setup: Setup) -> Any:
    """Return the parameters that the model's M, C, K have; a loop counts as closed."""
    equations = setup.bound.equations
    return equations.parameters if equations.scene is setup.scene else setup.case.parameters


def resting(case: Case) -> tuple[Scene, Any, Array, tuple[int, ...]]:
    """Return scene, parameters without forces, state, and coordinates that keep their speed."""
    scene = get_scene(case.scene)
    parameters = scene.unforced(case.parameters)
    values = scene.equilibria[case.about](parameters) if case.about else case.state
    return scene, parameters, scene.state(values), elements.steady_places(case, scene.coordinates)


def expected(
    scene: Scene,
    parameters: Any,
    state: Array,
    steady: tuple[int, ...],
    granted: float = BACKWARD_ERROR,
) -> list[tuple[str, Mode, float]]:
    """Return name, mode and tolerance [1/s] of each mode about a state of rest."""
    mass, damping, stiffness = linearise(scene, parameters, state)
    undamped = modes(mass, 0 * mass, stiffness, steady)
    top = max(mode.omega for mode in undamped)
    named = [
        (
            f"undamped_omega_{i}",
            mode,
            granted * top * (top / mode.omega)
            if mode.damping_ratio is not None
            else np.sqrt(granted) * top,
        )
        for i, mode in enumerate(undamped, start=1)
    ]
    if np.any(damping):
        free_places = np.delete(np.arange(len(mass)), steady)
        free = np.ix_(free_places, free_places)
        named += [
            (
                f"eigenvalue_{i}",
                mode,
                sensitivity(mass[free], damping[free], stiffness[free], mode, granted)
                if mode.damping_ratio is not None
                else np.sqrt(granted) * top,
            )
            for i, mode in enumerate(modes(mass, damping, stiffness, steady), start=1)
        ]
    return named


def sensitivity(mass: Array, damping: Array, stiffness: Array, mode: Mode, granted: float) -> float:
    """Bound on the change of an eigenvalue when M, C, K change by so much, relative.

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
    return float(granted * change / abs(y.conj() @ (2 * value * m + c) @ x))


def measure(setup: Setup) -> Measured:
    """Compare the engine's modes with those of its model, pair by pair, and these with the scene's.

    The case's forces and motors are switched off.
    """
    if setup.scene.continuum.spectrum:
        return Measured(elements.measure_frequencies(setup))
    scene, parameters, state, steady = resting(setup.case)
    still = replace(setup.case, parameters=parameters)
    with contained():
        mass, damping, stiffness = setup.with_case(still).bound.linearise(state)
    measured_modes = modes(mass, 0 * mass, stiffness, steady)
    if np.any(linearise(scene, parameters, state)[1]):
        measured_modes = measured_modes + modes(mass, damping, stiffness, steady)
    granted = matrix_rounding(setup.epsilon, BACKWARD_ERROR)
    exact = expected(scene, parameters, state, steady)
    real = inertial(setup.with_case(still))
    equations = expected(scene, real, state, steady, granted)
    findings = []
    for i, (name, mode, tolerance) in enumerate(equations):
        value = measured_modes[i] if i < len(measured_modes) else None
        error = abs(eigenvalue(value) - eigenvalue(mode)) if value else float("inf")
        findings.append(
            Finding(
                name,
                "1/s",
                value.omega if value else float("nan"),
                mode.omega,
                error,
                tolerance,
                f"M, C, K granted {granted:.0e}; {len(measured_modes)} modes found, "
                f"{len(exact)} expected",
            )
        )
    if real != parameters:
        top = max(mode.omega for _, mode, _ in exact)
        measured, predicted = (
            max(
                abs(eigenvalue(a) - eigenvalue(b)) / top
                for a, (_, b, _) in zip(item, exact, strict=False)
            )
            for item in (measured_modes, [mode for _, mode, _ in equations])
        )
        granted = max(tolerance for _, _, tolerance in equations) / top
        reason = "distance of the model's modes from the scene's, relative to the highest"
        findings.append(model_error(measured, predicted, granted, reason))
    return Measured(findings)


def eigenvalue(mode: Mode) -> complex:
    """Return re + i im."""
    return complex(mode.re, mode.im)
