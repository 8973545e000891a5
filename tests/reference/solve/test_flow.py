"""The linearised flow: transition matrices and what they amplify."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbcheck.reference import get_scene
from mbcheck.reference.differences import by_complex_step
from mbcheck.reference.hula_hoop.equations import (
    PLATE,
    UNFORCED,
    HulaHoop,
)
from mbcheck.reference.scene import Array
from mbcheck.reference.solve.batched import converged_steps, growths
from mbcheck.reference.solve.rk8 import rk8_steps

SCENE = get_scene("hula_hoop")


REST = SCENE.state({})


SPINNING = SCENE.state({"y": 0.01, "theta": 0.3, "theta_dot": 18.0})


# Linearised flow ------------------------------------------------------------------------


def field_jacobian(p: HulaHoop, t: float, x: Array) -> Array:
    """d f / d x by central differences of the fourth order."""
    f = SCENE.right_hand_side(p)
    columns = []
    for i in range(4):
        h = 1e-3 * np.eye(4)[i]
        near, far = (f(t, x + k * h) - f(t, x - k * h) for k in (1, 2))
        columns.append((8 * near - far) / 12e-3)
    return np.array(columns).T


def transition_matrix(p: HulaHoop, state: Array, end: Any, start: float = 0.0) -> Any:
    """Return the flow and its Jacobian by complex steps, in the converged number of steps."""
    steps = converged_steps(SCENE, p, state, end, start)
    derivative = SCENE.right_hand_side(p)
    return by_complex_step(lambda x: rk8_steps(derivative, x, start, end, steps), state)


@pytest.mark.parametrize("p", [HulaHoop(), PLATE])
def test_transition_matrix_solves_the_variational_equations(p: HulaHoop) -> None:
    start, end = 0.05, 0.3

    def rates(t: float, z: Array) -> Array:
        x, matrix = z[:4], z[4:].reshape(4, 4)
        slope = SCENE.right_hand_side(p)(t, x)
        return np.concatenate([slope, (field_jacobian(p, t, x) @ matrix).ravel()])

    z = np.concatenate([SPINNING, np.eye(4).ravel()])
    other = solve_ivp(rates, (start, end), z, "DOP853", rtol=1e-10, atol=1e-10).y[:, -1]
    flow, jacobian = transition_matrix(p, SPINNING, end, start)
    np.testing.assert_allclose(flow, other[:4], rtol=1e-8, atol=1e-8)
    size = np.abs(jacobian).max(axis=1, keepdims=True)
    np.testing.assert_allclose(jacobian / size, other[4:].reshape(4, 4) / size, atol=1e-7)


def test_errors_of_a_damped_oscillator_do_not_grow() -> None:
    """Light mass on a long rod, no force: nothing grows but theta with its rate."""
    p = UNFORCED.replace(free_mass=1e-9, rod_length=1e3, damping_ratio=0.5)
    state = SCENE.state({"y": 0.1, "theta": 0.3, "theta_dot": 18.0})
    growth = growths(SCENE, p, state, np.linspace(0, 0.5, 9)[1:])[-1]
    assert 1 <= growth < 3


def test_growth_is_the_largest_stretching_so_far() -> None:
    """Of y'' = 9 y errors grow by e^3t where y and y' have the sizes 1 and 3; then they shrink."""

    def accelerations(u: Any, q: Any, v: Any, c: Any, xp: Any = np) -> list[Any]:
        return [9 * q[0], -q[1]]

    def settling(u: Any, q: Any, v: Any, c: Any, xp: Any = np) -> list[Any]:
        return [-9 * q[0] - 6 * v[0], -q[1] - 2 * v[1]]

    unstable = replace(SCENE, accelerations=accelerations, drive=None)
    times = np.array([0.5, 1.0, 2.0])
    start = np.array([1.0, 1.0, 3.0, 0.0])
    found = growths(unstable, HulaHoop(), start, times)
    np.testing.assert_allclose(found, np.exp(3 * times), rtol=2e-3)
    damped = replace(SCENE, accelerations=settling, drive=None)
    found = growths(damped, HulaHoop(), np.array([0.0, 0.0, 1.0, 1.0]), np.array([0.2, 5.0]))
    assert 1.01 < found[1] == found[0] < 1.3


def test_growth_that_overflows_is_infinite() -> None:
    """Exponential growth at rest: e^(3e4 0.1) is no number."""

    def accelerations(u: Any, q: Any, v: Any, c: Any, xp: Any = np) -> list[Any]:
        return [9e8 * q[0], 9e8 * q[1]]

    unstable = replace(SCENE, accelerations=accelerations, drive=None)
    assert growths(unstable, HulaHoop(), REST, np.array([0.1]))[-1] == np.inf


def test_transition_matrices_of_many_points() -> None:
    frequencies = np.array([2.0, 3.0])
    p = HulaHoop(force_frequency=frequencies)  # type: ignore[arg-type]
    states = np.stack([SPINNING, REST], axis=1)
    flow, jacobian = transition_matrix(p, states, 1 / frequencies)
    assert jacobian.shape == (4, 4, 2)
    for i, frequency in enumerate(frequencies):
        one = HulaHoop(force_frequency=frequency)
        alone = transition_matrix(one, states[:, i], 1 / frequency)
        np.testing.assert_allclose(flow[:, i], alone[0], rtol=1e-10, atol=1e-11)
        np.testing.assert_allclose(jacobian[..., i], alone[1], rtol=1e-8, atol=1e-8)
