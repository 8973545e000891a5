"""The rigid body against Jacobi's functions, and what it conserves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.special import ellipj, ellipkinc

from mbcheck.reference.body.rotation import COORDINATES, RATES, ROTATION
from mbcheck.reference.errors import NoOrbitError, ParameterError, UnknownNameError
from mbcheck.reference.rigid_body import (
    FREE,
    HEAVY,
    KOVALEVSKAYA,
    LAGRANGE,
    SCENE,
    TUMBLING,
    RigidBody,
    coefficients,
)
from mbcheck.reference.scene import Array
from mbcheck.reference.solve.single import solve

RANDOM = np.random.default_rng(36)


def shown(p: RigidBody, state: Array, times: Array) -> tuple[Array, Array, Any]:
    """Return rotations (k, 3, 3) and body rates (k, 3) of the reference, and its solution."""
    solution = solve(SCENE, p, state, times)
    values = SCENE.observe(solution.states, p)
    rotations = np.array([values[name] for name in ROTATION]).T.reshape(-1, 3, 3)
    return rotations, np.array([values[name] for name in RATES]).T, solution


def free_rates(moments: Array, omega: Array, times: Array) -> Array:
    """Return the rates (3, n_t) of a free body about its principal axes, by Jacobi's functions.

    Landau, Lifshitz, (37.8)-(37.12). About the axis that the angular momentum goes round, that of
    the largest or of the smallest moment, the rate keeps its sign and is a dn. Rotation about one
    axis, and the separatrix, are limits.

    Parameters
    ----------
    moments : array (3,)
        In any order.
    omega : array (3,)
        At t = 0.
    times : array (n_t,)
    """
    twice, square = float(moments @ omega**2), float(moments**2 @ omega**2)
    order = axes_in_order(moments, omega)
    one, two, three = (float(moments[axis]) for axis in order)
    near, far = square - twice * one, twice * three - square
    if near == 0 or far == 0 or two == three or np.count_nonzero(omega) == 1:
        return np.outer(omega, np.ones_like(times))
    sizes = np.sqrt(
        [far / (one * (three - one)), far / (two * (three - two)), near / (three * (three - one))]
    )
    rate = np.sqrt((three - two) * near / (one * two * three))
    modulus = min((two - one) * far / ((three - two) * near), 1.0)
    start, sign = omega[order], np.copysign(1.0, omega[order[2]])
    way = sign * np.copysign(1.0, np.linalg.det(np.eye(3)[order])) * np.copysign(1.0, three - one)
    phase = ellipkinc(np.arctan2(way * start[1] / sizes[1], start[0] / sizes[0]), modulus)
    sn, cn, dn, _ = ellipj(rate * times + phase, modulus)
    rates = np.empty((3, len(times)))
    rates[order] = sizes[:, None] * [cn, way * sn, sign * dn]
    return rates


def axes_in_order(moments: Array, omega: Array) -> Any:
    """Return the axes so that the angular momentum goes round the last one."""
    order = np.argsort(moments)
    twice, square = moments @ omega**2, moments**2 @ omega**2
    return order if square >= twice * moments[order[1]] else order[::-1]


PANEL, NODES = 0.5, 20
"""Length of a panel, in radians of the body's rotation, and the number of Gauss points in it: what
they leave is round-off, since the integrand is smooth."""


def free_attitude(moments: Array, omega: Array, times: Array) -> Array:
    """Return the rotation matrices (n_t, 3, 3) of a free body's principal axes, those at t = 0 one.

    The angular momentum stays where it is, and the axis across it and the first one goes round it
    at the rate of Landau, Lifshitz, (37.17), whose integral is a sum over panels.

    Parameters
    ----------
    moments, omega, times :
        As of `free_rates`.
    """
    momentum = moments * omega
    size = np.linalg.norm(momentum)
    axis = np.eye(3)[axes_in_order(moments, omega)[0]]

    def frames(rates: Array) -> Array:
        along = (moments[:, None] * rates / size).T
        nodes = np.cross(axis, along)
        nodes /= np.linalg.norm(nodes, axis=1)[:, None]
        return np.stack([nodes, np.cross(along, nodes), along], axis=2)

    points, weights = np.polynomial.legendre.leggauss(NODES)
    angles = np.empty(len(times))
    for i, time in enumerate(times):
        count = max(1, int(np.ceil(abs(time) * np.linalg.norm(omega) / PANEL)))
        places = ((np.arange(count)[:, None] + (1 + points) / 2) / count).ravel() * time
        across = (1 - axis)[:, None] * moments[:, None] * free_rates(moments, omega, places)
        speed = np.sum(across**2 / moments[:, None], axis=0) / np.sum(across**2, axis=0)
        angles[i] = size * time / (2 * count) * float(np.tile(weights, count) @ speed)
    cos, sin, none = np.cos(angles), np.sin(angles), np.zeros(len(times))
    turns = np.array([[cos, -sin, none], [sin, cos, none], [none, none, none + 1]])
    first = frames(omega[:, None])[0]
    return np.asarray(
        first
        @ np.moveaxis(turns, 2, 0)
        @ np.swapaxes(frames(free_rates(moments, omega, times)), 1, 2)
    )


@pytest.mark.parametrize("seed", range(6))
def test_a_free_body_moves_by_jacobis_functions_within_its_bound(seed: int) -> None:
    random = np.random.default_rng(seed)
    moments, omega = random.permutation([0.004, 0.006, 0.007]), random.normal(size=3) * 5
    if seed >= 4:  # beside the axis that is unstable
        omega = random.normal(size=3) * 0.01 + 5 * (moments == 0.006)
    times = np.linspace(0.5, 3, 4)
    p = FREE.replace(
        axes_x=0.0, axes_y=0.0, axes_z=0.0,
        **{f"moment_{i}": value for i, value in enumerate(moments, 1)},
    )  # fmt: skip
    rotations, rates, solution = shown(p, SCENE.state(dict(zip(RATES, omega, strict=True))), times)
    bound, room = solution.error_bound, 1e-13 * (1 + 40 * (seed >= 4))
    error = np.max(np.abs(rotations - free_attitude(moments, omega, times)))
    assert error < 4 * np.sum(bound[:4]) + room
    error = np.max(np.abs(rates - free_rates(moments, omega, times).T))
    assert error < 2 * np.sum(bound[4:]) + 10 * np.sum(bound[:4]) + 10 * room


@pytest.mark.parametrize("case", SCENE.cases, ids=lambda case: case.name)
def test_what_a_top_conserves(case: Any) -> None:
    p, c = case.parameters, coefficients(case.parameters)
    expected = {"kovalevskaya_top": "kovalevskaya", "lagrange_top": "spin"}.get(case.name, "energy")
    known = SCENE.invariants(p)  # type: ignore[misc]
    assert expected in known
    times = np.linspace(0, min(case.horizon, 2.0), 5)[1:]
    states = solve(SCENE, p, SCENE.state(case.state | TUMBLING), times).states
    for name, invariant in known.items():
        values = invariant(states[:4], states[4:], c)
        assert np.ptp(values) < 1e-10 * np.max(np.abs(values)), name


def test_only_tops_have_a_fourth_integral() -> None:
    off = 1 + 1e-9
    names = [set(SCENE.invariants(p)) for p in (  # type: ignore[misc]
        LAGRANGE, LAGRANGE.replace(moment_1=0.004 * off),
        KOVALEVSKAYA, KOVALEVSKAYA.replace(moment_3=0.015 * off), FREE,
    )]  # fmt: skip
    four = {"energy", "momentum"}
    assert names == [four | {"spin"}, four, four | {"kovalevskaya"}, four, four]


def test_what_is_observed_knows_no_sign_and_no_length() -> None:
    state = RANDOM.normal(size=8)
    names = SCENE.observables
    assert not set(names) & set(COORDINATES)
    for factor in (-1.0, 3.0):
        a, b = (SCENE.observe(x, HEAVY) for x in (state, factor * state))
        assert [b[name] for name in names] == pytest.approx([a[name] for name in names], rel=1e-13)


def test_a_start_without_names_is_no_rotation() -> None:
    assert SCENE.state({}).tolist() == [1, 0, 0, 0, 0, 0, 0, 0]
    half = {"q_w": 0.6, "q_z": 0.8, "omega_x": 2.0}
    assert SCENE.state(half) == pytest.approx([0.6, 0, 0, 0.8, 0, 0.6, 0.8, 0])
    with pytest.raises(UnknownNameError):
        SCENE.state({"omega": 1.0})


@pytest.mark.parametrize("length", [0.0, 1e-300, 1e-5, 1e200])
def test_a_quaternion_far_from_a_rotation_is_refused(length: float) -> None:
    with pytest.raises(ParameterError, match=r"the quaternion q has the length .*brought to 1"):
        SCENE.state({"q_w": 0.0, "q_y": length})


def test_moments_that_no_body_has_are_refused() -> None:
    with pytest.raises(ParameterError, match="is larger than the sum"):
        RigidBody(moment_3=0.011)
    RigidBody(moment_3=0.01)


@pytest.mark.parametrize(("name", "sign"), [("hanging", -1), ("upright", 1)])
def test_at_rest_it_hangs_or_stands(name: str, sign: int) -> None:
    for p in (HEAVY, LAGRANGE, HEAVY.replace(gravity_x=3.0, gravity_y=-4.0)):
        state = SCENE.state(SCENE.equilibria[name](p))
        values = SCENE.observe(state, p)
        rotation = np.array([values[entry] for entry in ROTATION]).reshape(3, 3)
        height = -rotation @ p.centre @ p.gravity
        most = np.linalg.norm(p.centre) * np.linalg.norm(p.gravity)
        assert height == pytest.approx(sign * most, rel=1e-12)
        assert np.max(np.abs(SCENE.right_hand_side(p)(0.0, state))) < 1e-12
    with pytest.raises(NoOrbitError):
        SCENE.equilibria[name](FREE)
