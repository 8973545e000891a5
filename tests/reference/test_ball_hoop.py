"""The equations of ball_hoop against Lagrange's, Newton's and those of hula_hoop."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy as sp

from mbcheck.reference import get_scene
from mbcheck.reference.ball_hoop import BallHoop
from mbcheck.reference.body.rotation import RATES, ROTATION, body_inertia, central_inertia
from mbcheck.reference.errors import NoOrbitError
from mbcheck.reference.hula_hoop.equations import HulaHoop
from mbcheck.reference.orbits import find_orbit
from mbcheck.reference.scene import Array
from mbcheck.reference.solve.single import solve

SCENE = get_scene("ball_hoop")
GENERAL = BallHoop(gravity_x=3.0, gravity_y=-5.0, gravity_z=-7.0)
STATES = np.random.default_rng(20).normal(size=(4, 2, 5))


@pytest.fixture(scope="module")
def kinematics() -> Callable[..., Any]:
    """Return (q, centre) -> A, its slopes by q, and the centre of mass, from positions by SymPy.

    A q' is the velocity of the centre of mass, the angular velocity in the body, and rho.
    """
    y, *turn = q = sp.symbols("y w i j k", real=True)
    c, v = sp.symbols("c:3", real=True), sp.symbols("v:5", real=True)
    size = sum(one**2 for one in turn)
    unit, rates = sp.Quaternion(*turn), sp.Quaternion(*v[1:])
    arm = unit * sp.Quaternion(0, *c) * unit.conjugate()
    place = sp.Matrix([arm.b, y * size + arm.c, arm.d]) / size
    rate = unit.conjugate() * rates
    moving = sp.Matrix([2 * rate.b, 2 * rate.c, 2 * rate.d, rate.a]) / size
    matrix = sp.Matrix.vstack(place.jacobian(q), moving.jacobian(v))
    return sp.lambdify((*q, *c), (matrix, [matrix.diff(one) for one in q], place))


def test_they_are_lagranges(kinematics: Callable[..., Any]) -> None:
    p, c = GENERAL, SCENE.coefficients(GENERAL)
    weights = np.zeros((7, 7))
    weights[:3, :3], weights[3:6, 3:6] = p.mass * np.eye(3), central_inertia(p)
    weights[6, 6] = np.trace(body_inertia(p))
    for u, (q, v) in zip((1.0, -0.4, 0.0, 0.7), STATES, strict=True):
        matrix, slopes, place = kinematics(*q, *p.centre)
        mass = matrix.T @ weights @ matrix
        mass[0, 0] += p.main_mass
        by_q = np.array([one.T @ weights @ matrix + matrix.T @ weights @ one for one in slopes])
        right = by_q @ v @ v / 2 - np.tensordot(v, by_q, 1) @ v + p.mass * p.gravity @ matrix[:3]
        drive = p.force_amplitude * u - p.damping * v[0]
        right[0] += drive - p.stiffness * q[0] + p.main_mass * p.gravity_y
        right -= p.joint_damping * matrix[3:6].T @ matrix[3:6] @ v
        energy = v @ mass @ v / 2 + p.stiffness * q[0] ** 2 / 2
        energy -= p.main_mass * p.gravity_y * q[0] + p.mass * p.gravity @ place.ravel()
        assert np.array(SCENE.mass_matrix(q, c)) == pytest.approx(mass, rel=1e-11, abs=1e-13)
        assert SCENE.forces(u, q, v, c) == pytest.approx(right, rel=1e-10, abs=1e-11)
        assert SCENE.energy(q, v, c) == pytest.approx(energy, rel=1e-12)
        a = np.linalg.solve(mass, right)
        assert SCENE.accelerations(u, q, v, c) == pytest.approx(a, rel=1e-10, abs=1e-11)


def observed(p: BallHoop, start: dict[str, float], times: Array) -> tuple[dict[str, Any], Any]:
    """Return what is observed of the reference, and its solution."""
    solution = solve(SCENE, p, SCENE.state(start), times)
    return SCENE.observe(solution.states, p), solution


START = {"y": 0.02, "y_dot": -0.3, "q_w": 0.9, "q_x": 0.3, "q_y": -0.3, "q_z": 0.1,
         "omega_x": 5.0, "omega_y": -4.0, "omega_z": 8.0}  # fmt: skip


def in_plane(p: HulaHoop) -> BallHoop:
    """Return the mechanism whose plane motion is that of a hula hoop."""
    moment = p.inertia_ratio * p.free_mass * p.rod_length**2
    damping = 2 * p.damping_ratio * (p.main_mass + p.free_mass) * float(p.omega_n)
    friction = p.hinge_damping_ratio * p.free_mass * p.rod_length**2 * float(p.omega_n)
    return BallHoop(
        mass=p.free_mass, centre_x=p.rod_length, centre_y=0.0, centre_z=0.0,
        moment_1=0.8 * moment, moment_2=0.5 * moment, moment_3=moment,
        axes_x=0.0, axes_y=0.0, axes_z=0.0,
        gravity_x=p.gravity_x, gravity_y=p.gravity_y,
        main_mass=p.main_mass, stiffness=p.stiffness, damping=damping, joint_damping=friction,
        force_amplitude=p.force_amplitude, force_frequency=p.force_frequency,
    )  # fmt: skip


@pytest.mark.parametrize("gravity", [(0.0, 0.0), (7.0, -5.0)])
def test_in_the_plane_it_is_the_hula_hoop(gravity: tuple[float, float]) -> None:
    plane, times = get_scene("hula_hoop"), np.array([0.25, 0.5, 1.0])
    p = HulaHoop(
        inertia_ratio=1.7, hinge_damping_ratio=0.02, gravity_x=gravity[0], gravity_y=gravity[1]
    )
    start = {"y": 0.01, "theta": 0.3, "theta_dot": 18.0}
    right = solve(plane, p, plane.state(start), times)
    y, theta, y_dot, theta_dot = right.states
    half = {"q_w": np.cos(0.15), "q_z": np.sin(0.15)}
    values, solution = observed(in_plane(p), {"y": 0.01, **half, "omega_z": 18.0}, times)
    expected = {
        "y": y, "y_dot": y_dot, "omega_z": theta_dot, "omega_x": 0, "R_xz": 0,
        "R_xx": np.cos(theta), "R_yx": np.sin(theta),
    }  # fmt: skip
    bound = float(np.max(right.error_bound)) + 4 * float(np.max(solution.error_bound))
    assert bound < 1e-9
    for name, value in expected.items():
        assert np.max(np.abs(values[name] - value)) < bound, name


def test_power_of_the_drive_is_the_change_of_energy() -> None:
    times = np.linspace(0, 0.5, 1025)[1:]
    values, solution = observed(GENERAL, START, times)
    q, v = np.split(solution.states, 2)
    c = SCENE.coefficients(GENERAL)
    powers = SCENE.powers(SCENE.drive(times, c), q, v, c)  # type: ignore[misc]
    power = np.sum(list(powers.values()), axis=0)
    h = times[1] - times[0]
    # Boole's rule over the inner samples, of order 6
    weights = np.zeros(1021)
    for i in range(0, 1020, 4):
        weights[i : i + 5] += 2 * h / 45 * np.array([7, 32, 12, 32, 7])
    change = values["energy"][1020] - values["energy"][0]
    assert weights @ power[:1021] == pytest.approx(change, abs=1e-9 * np.ptp(values["energy"]))


@pytest.mark.parametrize("case", SCENE.cases, ids=lambda case: case.name)
def test_what_it_conserves(case: Any) -> None:
    p, c = case.parameters, SCENE.coefficients(case.parameters)
    known = SCENE.invariants(p)  # type: ignore[misc]
    assert set(known) == {
        "driven": {"momentum"}, "weighed": set(), "conservative": {"energy"}, "hanging": set(),
        "gravity_along": {"energy", "momentum"}, "planar": set(),
    }[case.name]  # fmt: skip
    states = solve(SCENE, p, SCENE.state(START), np.linspace(0, 0.5, 5)[1:]).states
    for name, invariant in known.items():
        values = invariant(states[:5], states[5:], c)
        assert np.ptp(values) < 1e-11 * np.max(np.abs(values)), name


def test_outputs_tell_the_momentum_about_the_moving_joint() -> None:
    (q, v), p = STATES[0], GENERAL
    values = SCENE.observe(np.concatenate([q, v]), p)
    rotation = np.array([values[name] for name in ROTATION]).reshape(3, 3)
    omega = rotation @ np.array([values[name] for name in RATES])
    arm = rotation @ p.centre
    speed = v[0] * np.array([0.0, 1.0, 0.0]) + np.cross(omega, arm)
    momentum = p.mass * np.cross(arm, speed)
    momentum += rotation @ central_inertia(p) @ rotation.T @ omega
    found = [values[f"momentum_{axis}"] for axis in "xyz"]
    assert found == pytest.approx(momentum, rel=1e-12)


@pytest.mark.parametrize("name", ["hanging", "inverted", "weightless"])
def test_at_rest_nothing_accelerates(name: str) -> None:
    p, other = (GENERAL, BallHoop()) if name != "weightless" else (BallHoop(), GENERAL)
    p = p.replace(force_amplitude=0.0)
    state = SCENE.state(SCENE.equilibria[name](p))
    assert np.max(np.abs(SCENE.right_hand_side(p)(0.0, state))) < 1e-11
    with pytest.raises(NoOrbitError):
        SCENE.equilibria[name](other)


def test_a_body_on_its_centre_of_mass_hangs_in_any_attitude() -> None:
    p = BallHoop(centre_x=0.0, centre_y=0.0, centre_z=0.0, gravity_y=-9.81, force_amplitude=0.0)
    state = SCENE.state(SCENE.equilibria["weightless"](p))
    assert np.max(np.abs(SCENE.right_hand_side(p)(0.0, state))) < 1e-11
    with pytest.raises(NoOrbitError, match="ask for weightless"):
        SCENE.equilibria["hanging"](p)


def test_it_is_not_said_that_nothing_drives_it() -> None:
    with pytest.raises(NoOrbitError, match="none is sought of this scene"):
        find_orbit(SCENE, BallHoop())


def test_a_light_slide_keeps_its_digits() -> None:
    """The body's share of the slide's inertia comes of a difference of about equal numbers."""
    p = GENERAL.replace(main_mass=1e-3, mass=10.0)
    c, (q, v) = SCENE.coefficients(p), STATES[1]
    right = np.linalg.solve(np.array(SCENE.mass_matrix(q, c)), SCENE.forces(0.0, q, v, c))
    assert SCENE.accelerations(0.0, q, v, c) == pytest.approx(right, rel=1e-8)
    assert np.linalg.cond(body_inertia(p)) < 100
