"""The equations of motion against those of Lagrange, by SymPy from positions and energies alone."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest
import sympy as sp

from mbcheck.reference import get_scene
from mbcheck.reference.differences import by_complex_step
from mbcheck.tests.support.precise.lagrange import MECHANISMS, mass_and_load


@pytest.mark.parametrize(("name", "word"), MECHANISMS)
def test_equations_are_those_of_lagrange(name: str, word: str) -> None:
    """Over two orders of magnitude of each parameter, with gravity."""
    scene, system = get_scene(name), MECHANISMS[name, word]()
    gravity = sp.symbols("gravity_x gravity_y", real=True)
    weight = sum(m * (gravity[0] * at[0] + gravity[1] * at[1]) for m, at in system.masses)
    matrix, load = mass_and_load(system._replace(potential=system.potential - weight))
    names = scene.parameters.numeric_names()
    symbols = [system.time, *system.q, *system.v, *(sp.Symbol(one, real=True) for one in names)]
    exact, random = sp.lambdify(symbols, (matrix, load), cse=True), np.random.default_rng(7)
    n, words = len(system.q), {key: word for key in scene.parameters.choices()}
    for _ in range(40):
        p = drawn(scene, random, words)
        t, q, v = random.uniform(0, 9), random.normal(size=n), 10 * random.normal(size=n)
        numbers = [getattr(p, one) for one in names]
        mass, right = (np.array(part, dtype=float) for part in exact(t, *q, *v, *numbers))
        c = scene.coefficients(p)
        u = scene.drive(t, c, np) if scene.drive else 0.0
        size = np.sqrt(np.diag(mass))
        unit = mass / np.outer(size, size)
        relative = np.array(scene.mass_matrix(q, c)) / np.outer(size, size)
        np.testing.assert_allclose(relative, unit, rtol=0, atol=1e-12)
        forces = np.array(scene.forces(u, q, v, c))
        np.testing.assert_allclose(forces, right, rtol=1e-11, atol=1e-12 * largest(scene, p, q, v))
        wanted = np.linalg.solve(unit, right / size)
        inverse = np.abs(np.linalg.inv(unit))
        room = 1e-12 * inverse @ (largest(scene, p, q, v) / size + np.abs(unit) @ np.abs(wanted))
        found = np.array(scene.accelerations(u, q, v, c)) * size
        assert np.all(np.abs(found - wanted) <= room)
        if name != "speed_regulator":  # its damper has no constant matrix
            free = c._replace(**{one: 0.0 for one in c._fields if "damping" in one})
            slopes = [
                by_complex_step(partial(velocity_forces, scene, u, q, of), v)[1] for of in (free, c)
            ]
            np.testing.assert_allclose(
                slopes[0] - slopes[1],
                scene.damping_matrix(c),
                rtol=0,
                atol=1e-12 * np.max(np.abs(slopes)),
            )


def velocity_forces(scene: Any, u: float, q: Any, c: Any, v: Any) -> Any:
    """Return the forces (n, ...) at velocities (n, ...)."""
    return scene.forces(u, q, v, c)


def drawn(scene: Any, random: Any, words: dict[str, str]) -> Any:
    """Return parameters about the defaults, with gravity."""
    values = {
        name: (value or 5.0) * 10 ** random.uniform(-1, 1)
        for name, value in scene.parameters().as_dict().items()
        if name not in words
    }
    if "crank_radius" in values:
        values["crank_radius"] = values["rod_length"] * random.uniform(0.02, 0.9)
    return scene.parameters(**values, **words)


def largest(scene: Any, p: Any, q: Any, v: Any) -> float:
    """Return the size of the terms of forces: with each sign of speed, and by each coefficient."""
    c = scene.coefficients(p)
    parts = [scene.forces(1.0, q, sign * v, c) for sign in (1, -1, 0)]
    parts += [
        (np.array(scene.forces(1.0, q, v, c._replace(**{name: 1.5 * value}))) - parts[0]) / 0.5
        for name, value in zip(c._fields, c, strict=True)
    ]
    return float(np.max(np.abs(parts)))
