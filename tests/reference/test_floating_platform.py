"""The equations of floating_platform against Lagrange's, Newton's, and those of a plane."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbcheck.reference import get_scene, quaternions
from mbcheck.reference.body.floating_scene import LINEAR
from mbcheck.reference.body.rotation import COORDINATES, MOMENTUM, central_inertia
from mbcheck.reference.errors import NoOrbitError
from mbcheck.reference.floating_platform import IN_PLANE, PLANAR, TUMBLING, FloatingPlatform
from mbcheck.reference.orbits import find_orbit
from mbcheck.reference.scene import Array
from mbcheck.reference.solve.single import solve
from mbcheck.tests.support.exact.tree import (
    AXES,
    Part,
    Torques,
    about,
    lagrange,
    momenta,
)

SCENE = get_scene("floating_platform")
WEIGHED = FloatingPlatform(gravity_x=3.0, gravity_y=-5.0, gravity_z=-7.0)
STATES = np.random.default_rng(20).normal(size=(3, 2, 9))


def parts(p: FloatingPlatform) -> list[Part]:
    """Return platform, rotor and rod."""
    polar, cross = p.polar_moment, p.cross_moment
    tilted = about(AXES[0], p.tilt) @ about(AXES[2], p.installation_angle)
    up, ahead = p.rotor_height * AXES[2], p.rod_place * AXES[0]
    arms = p.eccentricity * AXES[0], p.rod_length * AXES[0]
    return [
        Part(-1, p.mass, p.centre, central_inertia(p)),
        Part(0, p.rotor_mass, arms[0], np.diag([cross, cross, polar]), up),
        Part(0, p.rod_mass, arms[1], p.rod_moment * AXES, ahead, tilted),
    ]


def torques(p: FloatingPlatform) -> Torques:
    """Return what motor, spring and damper make of angles and rates."""
    return lambda angles, rates: (
        p.motor_slope * (p.synchronous_speed - rates[0]),
        -p.rod_stiffness * angles[1] - p.rod_damping * rates[1],
    )


@pytest.mark.parametrize("p", [WEIGHED, FloatingPlatform(tilt=-1.1, eccentricity=0.2)])
def test_they_are_lagranges(p: FloatingPlatform) -> None:
    c = SCENE.coefficients(p)
    for q, v in STATES:
        radial = np.trace(central_inertia(p))
        mass, right, energy = lagrange(parts(p), q, v, p.gravity, radial)
        right[3:5] += torques(p)(q[3:5], v[3:5])
        energy += p.rod_stiffness * q[4] ** 2 / 2
        assert np.array(SCENE.mass_matrix(q, c)) == pytest.approx(mass, rel=1e-11, abs=1e-13)
        assert SCENE.forces(0.0, q, v, c) == pytest.approx(right, rel=1e-7, abs=1e-8)
        assert SCENE.energy(q, v, c) == pytest.approx(energy, rel=1e-12)
        a = np.linalg.solve(mass, SCENE.forces(0.0, q, v, c))
        assert SCENE.accelerations(0.0, q, v, c) == pytest.approx(a, rel=1e-10, abs=1e-11)


def run(p: FloatingPlatform, start: Any, times: Any) -> tuple[dict[str, Array], float]:
    """Return what is observed of the reference, and the bound on its error."""
    solution = solve(SCENE, p, SCENE.state(start), np.asarray(times))
    bound = float(np.max(solution.error_bound))
    assert bound < 1e-9
    return SCENE.observe(solution.states, p), bound


def plane_rates(p: FloatingPlatform) -> Callable[[float, Array], Array]:
    """Return the rates of (x, y, psi, phi, theta) and theirs: the mechanism in a plane.

    Points are complex numbers, and psi is the platform's angle.
    """
    moment = central_inertia(p)[2, 2]
    central = np.array([moment, p.polar_moment, p.rod_moment])
    masses = np.array([p.mass, p.rotor_mass, p.rod_mass])
    turns = np.array([[0, 0, 1, 0, 0], [0, 0, 1, 1, 0], [0, 0, 1, 0, 1.0]])

    def rates(t: float, state: Array) -> Array:
        _, _, psi, phi, theta = state[:5]
        v = state[5:]
        on = np.exp(1j * psi) * np.array([p.centre_x + 1j * p.centre_y, 0, p.rod_place])
        out = np.array([
            0, p.eccentricity * np.exp(1j * (psi + phi)),
            p.rod_length * np.exp(1j * (psi + p.installation_angle + theta)),
        ])  # fmt: skip
        moving = np.zeros((3, 5), dtype=complex)
        moving[:, 0], moving[:, 1], moving[:, 2] = 1, 1j, 1j * (on + out)
        moving[1, 3], moving[2, 4] = 1j * out[1], 1j * out[2]
        swing = -(v[2] ** 2) * on - (turns @ v) ** 2 * out
        mass = (moving.conj().T * masses @ moving).real + turns.T * central @ turns
        right = -(moving.conj().T @ (masses * swing)).real
        right[3] += p.motor_slope * (p.synchronous_speed - v[3])
        right[4] -= p.rod_stiffness * theta + p.rod_damping * v[4]
        return np.concatenate([v, np.linalg.solve(mass, right)])

    return rates


@pytest.fixture(scope="module")
def plane() -> tuple[Array, Array]:
    """Return times, and the motion in the plane (10, k) from `IN_PLANE`."""
    times = np.array([0.1, 0.2, 0.4])
    start = np.zeros(10)
    start[[4, 5, 6, 7, 8]] = [
        IN_PLANE[name] for name in ("theta", "x_dot", "y_dot", "omega_z", "phi_dot")
    ]
    found = solve_ivp(plane_rates(PLANAR), (0, 0.4), start, "DOP853", times, rtol=1e-13, atol=1e-13)
    return times, found.y


@pytest.mark.parametrize("seen_from", ["rest", "a moving frame", "a turned frame"])
def test_in_the_plane_it_is_the_plane_mechanism(seen_from: str, plane: Any) -> None:
    times, (x, y, psi, phi, theta, *_, phi_dot, _) = plane
    drift = np.array([1.5, -0.7, 0.4]) * (seen_from == "a moving frame")
    turn = quaternions.of_rotation(np.array([0.4, -1.1, 0.7]) * (seen_from == "a turned frame"))
    axes = np.array(quaternions.matrix(turn))
    velocity = axes @ [IN_PLANE["x_dot"], IN_PLANE["y_dot"], 0.0] + drift
    start = IN_PLANE | dict(zip(COORDINATES, turn, strict=True))
    start |= dict(zip(("x_dot", "y_dot", "z_dot"), velocity, strict=True))
    values, bound = run(PLANAR, start, times)
    place = axes @ [x, y, 0 * x] + np.outer(drift, times)
    in_plane = np.array([[np.cos(psi), -np.sin(psi)], [np.sin(psi), np.cos(psi)]])
    rotation = np.einsum("ij,jkt->ikt", axes[:, :2], in_plane)
    expected = dict(zip("xyz", place, strict=True)) | {"phi": phi, "theta": theta}
    expected |= {"phi_dot": phi_dot}
    expected |= {f"R_{'xyz'[i]}{'xy'[k]}": rotation[i, k] for i in range(3) for k in range(2)}
    for name, value in expected.items():
        assert np.max(np.abs(values[name] - value)) < 4 * bound + 1e-10, name


@pytest.mark.parametrize("case", SCENE.cases, ids=lambda case: case.name)
def test_momenta_are_conserved_to_rounding(case: Any) -> None:
    p, c = case.parameters, SCENE.coefficients(case.parameters)
    known = SCENE.invariants(p)  # type: ignore[misc]
    linear = set() if case.name == "falling" else set(LINEAR)
    energy = {"energy"} if case.name in ("conservative", "falling") else set()
    assert set(known) == {*MOMENTUM, *linear, *energy}
    states = solve(SCENE, p, SCENE.state(TUMBLING), np.linspace(0, 0.25, 5)[1:]).states
    series = {name: invariant(states[:9], states[9:], c) for name, invariant in known.items()}
    for name, values in series.items():
        family = [one for other, one in series.items() if other[:-1] == name[:-1]]
        assert np.ptp(values) < 2e-13 * np.max(np.abs(family)), name
        assert np.max(np.abs(values)) > 1e-2 * np.max(np.abs(family))


def test_momenta_are_those_of_the_bodies() -> None:
    (q, v), p = STATES[0], WEIGHED
    values = SCENE.observe(np.concatenate([q, v]), p)
    turning, moving = momenta(parts(p), q, v)
    assert [values[name] for name in MOMENTUM] == pytest.approx(turning, rel=1e-11)
    assert [values[name] for name in LINEAR] == pytest.approx(moving, rel=1e-11)


def test_powers_are_the_change_of_energy() -> None:
    c, step = SCENE.coefficients(WEIGHED), 1e-30
    for q, v in STATES:
        a = np.array(SCENE.accelerations(0.0, q, v, c))
        slope = SCENE.energy(q + 1j * step * v, v + 1j * step * a, c).imag / step
        assert slope == pytest.approx(sum(SCENE.powers(0.0, q, v, c).values()), rel=1e-10)


def test_at_rest_nothing_accelerates_and_nothing_drives_an_orbit() -> None:
    p = SCENE.unforced(FloatingPlatform())
    state = SCENE.state(SCENE.equilibria["afloat"](p))
    assert not np.any(SCENE.right_hand_side(p)(0.0, state))
    with pytest.raises(NoOrbitError, match="falls"):
        SCENE.equilibria["afloat"](WEIGHED)
    with pytest.raises(NoOrbitError):
        find_orbit(SCENE, p)


def test_heavy_arms_keep_their_digits() -> None:
    p = replace(WEIGHED, mass=1e-2, rotor_mass=10.0, rod_mass=30.0)
    c, (q, v) = SCENE.coefficients(p), STATES[1]
    right = np.linalg.solve(np.array(SCENE.mass_matrix(q, c)), SCENE.forces(0.0, q, v, c))
    assert SCENE.accelerations(0.0, q, v, c) == pytest.approx(right, rel=1e-8)
