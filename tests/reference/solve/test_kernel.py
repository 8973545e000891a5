"""Source code of the equations of motion computes what they say."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import DOP853

from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.differences import PROBE
from mbcheck.reference.scene import NO_CONTINUUM
from mbcheck.reference.solve.kernel import MANY_CALLS, MATH, NUMPY, source, written_out
from mbcheck.reference.solve.rk8 import equal_steps

TRACED = [name for name in SCENES if get_scene(name).continuum is NO_CONTINUUM]


def states(scene: Any, count: int, complex_steps: bool) -> Any:
    rng = np.random.default_rng(0)
    x = rng.normal(size=(2 * len(scene.coordinates), count))
    return x + 1j * PROBE * rng.normal(size=x.shape) if complex_steps else x


@pytest.mark.parametrize("name", TRACED)
@pytest.mark.parametrize("complex_steps", [False, True])
@pytest.mark.parametrize("count", [3, 64])
def test_arrays_give_what_the_equations_give(name: str, complex_steps: bool, count: int) -> None:
    """To the last bit, but for the squares of complex numbers."""
    scene = get_scene(name)
    c = scene.coefficients(scene.parameters())
    c = type(c)(*(np.full(count, value, dtype=float) for value in c))
    x, t, n = states(scene, count, complex_steps), np.linspace(0, 1, count), len(scene.coordinates)
    u = scene.drive(t, c, np) if scene.drive else 0.0
    plain = np.array([*x[n:], *scene.accelerations(u, x[:n], x[n:], c, np)])
    derivative = scene.derivative(c)
    for _ in range(2):
        found = derivative(t, x)
        for part in (np.real, np.imag):
            size = np.max(np.abs(part(plain)), axis=1, keepdims=True)
            allowed = 64 * np.finfo(float).eps if complex_steps else 0.0
            assert np.all(np.abs(part(found) - part(plain)) <= allowed * size)
        assert derivative(t, x) is not found


@pytest.mark.parametrize("name", TRACED)
@pytest.mark.parametrize("kind", [np.float32, complex])
def test_single_states_of_other_numbers_than_doubles(name: str, kind: Any) -> None:
    """One after the other; with 32 bits to the last one, so that nothing in between has more."""
    scene = get_scene(name)
    c = scene.coefficients(scene.parameters())
    c = type(c)(*(np.float32(value) if kind is np.float32 else value for value in c))
    derivative, n = scene.derivative(c), len(scene.coordinates)
    allowed = 64 * np.finfo(float).eps if kind is complex else 0.0
    for t, x in enumerate(states(scene, 3, kind is complex).T.astype(kind)):
        time = np.float32(t)
        u = scene.drive(time, c, np) if scene.drive else 0.0
        plain = np.array([*x[n:], *scene.accelerations(u, x[:n], x[n:], c, np)])
        found = derivative(time, x)
        assert found.dtype == plain.dtype == kind
        for part in (np.real, np.imag):
            off = np.abs(part(found) - part(plain))
            assert np.all(off <= allowed * np.max(np.abs(part(plain))))


@pytest.mark.parametrize("name", TRACED)
def test_source_code_gives_what_the_equations_give_to_the_last_bit(name: str) -> None:
    scene = get_scene(name)
    c, n = scene.coefficients(scene.parameters()), len(scene.coordinates)
    numbers = type(c)(*(float(value) for value in c))
    derivative = scene.derivative(c)
    for _ in range(MANY_CALLS):
        derivative(0.0, np.ones(2 * n))
    for t, x in enumerate(states(scene, 20, False).T):
        u = scene.drive(float(t), numbers, math) if scene.drive else 0.0
        q, v = x[:n].tolist(), x[n:].tolist()
        plain = np.array([*v, *scene.accelerations(u, q, v, numbers, math)])
        np.testing.assert_array_equal(derivative(t, x), plain)
    assert np.all(np.isnan(derivative(0.0, np.full(2 * n, np.inf))[n:]))


def test_times_that_are_whole_numbers_leave_others_whole() -> None:
    scene, x = get_scene("hula_hoop"), np.ones((4, 9))
    derivative = scene.right_hand_side(scene.parameters())
    derivative(0, x)
    again = scene.right_hand_side(scene.parameters())
    np.testing.assert_array_equal(derivative(0.3, x), again(0.3, x))


def by_stages(derivative: Any, x: Any, t: Any, h: Any, steps: int) -> Any:
    """Steps as textbooks write them, by calls of the right-hand side."""
    for i in range(steps):
        k: list[Any] = []
        for s in range(DOP853.n_stages):
            at = x + sum((DOP853.A[s, j] * k[j] for j in range(s)), np.zeros_like(x))
            k.append(h * derivative(t + (i + DOP853.C[s]) * h, at))
        x = x + sum(weight * slope for weight, slope in zip(DOP853.B, k, strict=True))
    return x


@pytest.mark.parametrize("name", TRACED)
@pytest.mark.parametrize("complex_steps", [False, True])
@pytest.mark.parametrize("count", [0, 3, 64])
def test_steps_are_those_of_the_method(name: str, complex_steps: bool, count: int) -> None:
    """Of one set of coefficients and of many, in steps that change; 0 is one state of that."""
    scene = get_scene(name)
    c = scene.coefficients(scene.parameters())
    if count:
        c = type(c)(*(np.full(count, value, dtype=float) for value in c))
    x = 0.1 * states(scene, count or 1, complex_steps)
    derivative = scene.derivative(c)
    t = np.linspace(0.0, 1.0, count) if count else 0.3
    for h in (1e-3, 2e-3, 2e-3):
        found, plain = equal_steps(derivative, x, t, h, 3), by_stages(derivative, x, t, h, 3)
        for part in (np.real, np.imag):
            size = np.max(np.abs(part(plain)), axis=1, keepdims=True)
            assert np.all(np.abs(part(found) - part(plain)) <= 1e-12 * size)
        moved = np.max(np.abs(found - x))
        assert moved > 1e-6  # else nothing would be seen


def test_source_code_takes_the_place_of_long_equations_only_where_it_can() -> None:
    def whole(t: Any, q: Any, v: Any, xp: Any) -> Any:
        calls.append(t)
        return [2 * xp.sqrt(q[0]) - v[0] ** 3 / t]

    def absolute(t: Any, q: Any, v: Any, xp: Any) -> Any:
        calls.append(t)
        return [abs(q[0])]

    for rates, asked in ((whole, MANY_CALLS + 1), (absolute, 2 * MANY_CALLS + 1)):
        calls: list[Any] = []
        accelerations = written_out(rates)
        values = [accelerations(0.5, [4.0], [3.0], math) for _ in range(2 * MANY_CALLS)]
        assert values == [rates(0.5, [4.0], [3.0], math)] * len(values)
        assert len(calls) == asked + 1
    assert source(absolute, 1, MATH) is None


def test_what_is_more_than_arithmetic_is_left_to_numpy() -> None:
    for rate in (lambda q, xp: xp.where(q, 1.0, -1.0), lambda q, xp: abs(q), lambda q, xp: q % 1):

        def rates(t: Any, q: Any, v: Any, xp: Any, rate: Any = rate) -> Any:
            return [rate(q[0], xp)]

        assert source(rates, 1, NUMPY) is None
