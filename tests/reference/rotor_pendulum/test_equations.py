"""rotor_pendulum: the reduced equations, and the paper's theory."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp

from mbcheck.reference.errors import NoOrbitError, ParameterError
from mbcheck.reference.linear import linearise, modes
from mbcheck.reference.orbits import Orbit, orbit_samples, shoot
from mbcheck.reference.rotor_pendulum import (
    CASE_1,
    CASE_2,
    CASE_3,
    CONSERVATIVE,
    SCENE,
    SPINNING,
    theory,
)
from mbcheck.reference.rotor_pendulum.equations import (
    PLACEMENTS,
    RotorPendulum,
    operating_speed,
)
from mbcheck.reference.rotor_pendulum.phase import (
    balanced_phase,
    coupling_harmonics,
    coupling_torque,
    forced_response,
    orbit_guesses,
    settling_rate,
    wrapped,
)
from mbcheck.reference.scene import Array
from mbcheck.reference.solve.single import solve

REDUCED = SCENE.variants["reduced"]


UNDAMPED = {"platform_damping": 0.0, "rod_damping": 0.0}


# Equations of motion ------------------------------------------------------------------------


def random_points(placement: str, count: int = 40) -> list[tuple[Any, Any, RotorPendulum]]:
    """Return coordinates, rates and parameters over orders of magnitude."""
    random = np.random.default_rng(11)
    points = []
    for _ in range(count):
        values = {
            name: value * 10 ** random.uniform(-1, 1)
            for name, value in CASE_2.replace(gravity_x=3.0, gravity_y=-9.0).as_dict().items()
            if name != "motor_placement"
        }
        values["installation_angle"] = random.uniform(-np.pi, np.pi)
        q = random.normal(size=4) * (0.01, 3, 3, 1)
        v = random.normal(size=4) * (1, 100, 100, 30)
        points.append((q, v, RotorPendulum(motor_placement=placement, **values)))
    return points


def test_heavy_rotors_cost_no_digits() -> None:
    p = CASE_2.replace(rotor_mass=1e9, installation_angle=1.0)
    c = SCENE.coefficients(p)
    q, v = np.array([0.01, 0.3, -0.8, 0.2]), np.array([0.5, 4.0, 3.0, -2.0])
    exact = sp.Matrix(SCENE.mass_matrix([sp.Rational(z) for z in q], _rational(c), sp)).evalf(50)
    load = sp.Matrix(
        SCENE.forces(0, [sp.Rational(z) for z in q], [sp.Rational(z) for z in v], _rational(c), sp)
    ).evalf(50)
    wanted = [float(value) for value in exact.LUsolve(load)]
    np.testing.assert_allclose(SCENE.accelerations(0.0, q, v, c), wanted, rtol=1e-11)


def _rational(c: Any) -> Any:
    return type(c)(*(sp.Rational(value) for value in c))


def test_invariants_are_constant_in_free_motion_and_named_as_they_apply() -> None:
    free = SCENE.case("free_platform")
    assert list(SCENE.invariants(CASE_1)) == ["energy"]  # type: ignore[misc]
    for case, names in ((SCENE.case("conservative"), ["energy"]), (free, ["energy", "momentum"])):
        c = SCENE.coefficients(case.parameters)
        times = np.linspace(0, case.horizon, 21)[1:]
        states = solve(SCENE, case.parameters, SCENE.state(case.state), times).states
        invariants = SCENE.invariants(case.parameters)  # type: ignore[misc]
        assert list(invariants) == names
        for value in invariants.values():
            path = value(states[:4], states[4:], c)
            start = value(*np.split(SCENE.state(case.state), 2), c)
            assert np.max(np.abs(path - start)) < 1e-10 * abs(start)


def equation_11(q: Any, v: Any, a: Any, p: RotorPendulum, sign: int) -> Array:
    """Left less right sides of (11); ``sign`` before phi_2'^2 in its last line, printed +1."""
    m, r, length, beta = p.rotor_mass, p.eccentricity, p.rod_length, p.installation_angle
    mass = p.platform_mass + 2 * m + p.rod_mass
    end = (m + p.rod_mass) * length
    torques = [
        p.motor_slope * (p.synchronous_speed - rate) - p.friction * rate for rate in (v[1], v[2])
    ]
    return np.array(
        [
            mass * a[0] + p.platform_damping * v[0] + p.platform_stiffness * q[0]
            + m * r * (a[1] * np.sin(q[1]) + v[1] ** 2 * np.cos(q[1]))
            - m * r * (a[2] * np.sin(q[2]) + v[2] ** 2 * np.cos(q[2]))
            - end * (a[3] * np.sin(beta) + v[3] ** 2 * np.cos(beta)),
            m * r**2 * a[1] - torques[0] + m * r * a[0] * np.sin(q[1]),
            m * r**2 * a[2] - torques[1] - m * r * (
                a[0] * np.sin(q[2])
                - length * a[3] * np.cos(beta - q[2])
                + length * v[3] ** 2 * np.sin(beta - q[2])
            ),
            end * length * a[3] + p.rod_damping * v[3] + p.rod_stiffness * q[3]
            - end * a[0] * np.sin(beta)
            + m * r * length * (
                a[2] * np.cos(q[2] - beta) + sign * v[2] ** 2 * np.sin(q[2] - beta)
            ),
        ]
    )  # fmt: skip


def test_the_reduced_equations_are_the_printed_ones_but_for_a_sign() -> None:
    for q, v, weighed in random_points("absolute", 20):
        p = weighed.replace(gravity_x=0.0, gravity_y=0.0)
        c = REDUCED.coefficients(p)
        a = np.array(REDUCED.accelerations(0.0, q, v, c))
        size = np.abs(REDUCED.mass_matrix(q, c)) @ np.abs(a)
        assert np.all(np.abs(equation_11(q, v, a, p, sign=-1)) < 1e-11 * size)
        assert abs(equation_11(q, v, a, p, sign=1)[3]) > 1e-6 * size[3]
        load = REDUCED.forces(0.0, q, v, c)
        pushed = np.array(REDUCED.mass_matrix(q, c)) @ a
        np.testing.assert_allclose(pushed, load, atol=1e-11 * np.max(size))


def test_the_reduced_equations_do_not_conserve_energy() -> None:
    start = SCENE.state(SPINNING)
    c = SCENE.coefficients(CONSERVATIVE)
    changes = {}
    for scene in (SCENE, REDUCED):
        states = solve(scene, CONSERVATIVE, start, np.linspace(0, 0.2, 41)[1:]).states
        energies = scene.energy(states[:4], states[4:], c)
        changes[scene] = np.max(np.abs(energies / scene.energy(start[:4], start[4:], c) - 1))
    assert changes[SCENE] < 1e-10
    assert changes[REDUCED] > 1e-2
    small = start * 1e-3  # where B is beta to first order, the two are one
    near = [solve(scene, CONSERVATIVE, small, [0.05]).states for scene in (SCENE, REDUCED)]
    np.testing.assert_allclose(near[1], near[0], atol=1e-3 * np.max(np.abs(near[0])))


# Theory -------------------------------------------------------------------------------------


GRID_X, GRID_PHI, GRID_BETA = np.meshgrid(
    [0.1, 0.5, 0.97, 1.0, 1.03, 1.1, 2.0, 7.0],
    [0.1, 0.5, 0.97, 1.0, 1.03, 1.1547005383792517, 2.0, 7.0],
    [0.0, 1e-9, np.pi / 6, np.pi / 3, 5 * np.pi / 12, np.pi / 2, 2.0, np.pi, -0.7, -np.pi / 2],
    indexing="ij",
)


def test_coupling_coefficients_solve_17_and_the_printed_ones_do_not() -> None:
    random = np.random.default_rng(5)
    for _ in range(20):
        w_x, w_phi, w, r, length = random.uniform(0.3, 3, 5)
        sigma, r_m, beta = random.uniform(0.1, 0.9), random.uniform(0.01, 0.3), random.uniform(0, 3)
        phi_1, phi_2 = random.uniform(0, 6, 2)
        wave = np.array([np.cos(phi_1) - np.cos(phi_2), np.sin(phi_2 - beta)])
        f_1, f_2 = -r_m * r / length * wave[0], -sigma * r / length * wave[1]
        sin = np.sin(beta)
        steady = np.linalg.solve(  # (17) at s^2 = -w^2
            [
                [w_x**2 - w**2, r_m * length * w**2 * sin / sigma],
                [w**2 * sin / length, w_phi**2 - w**2],
            ],
            [w**2 * length * f_1, -(w**2) * f_2],
        )
        n = theory.Ratios(w / w_x, w / w_phi, sigma, r_m, beta)
        errors = []
        for as_printed in (False, True):
            mu = theory.coupling_coefficients(n, as_printed)
            x = mu.mu_1 * r_m * r * wave[0] - mu.mu_2 * sigma * r * wave[1]
            phi_3 = r / length * (mu.mu_3 * r_m * wave[0] - mu.mu_4 * sigma * wave[1])
            errors.append(np.max(np.abs(np.array([x, phi_3]) / steady - 1)))
            assert mu.mu_3 * r_m == pytest.approx(mu.mu_2 * sigma)  # (29)
        assert errors[0] < 1e-9
        assert errors[1] > 1e-4


def test_the_stable_phase_difference_satisfies_30_and_36_everywhere() -> None:
    n = theory.Ratios(GRID_X, GRID_PHI, beta=GRID_BETA)
    alpha = theory.stable_phase_difference(n)
    assert np.all((alpha > -np.pi) & (alpha <= np.pi) | np.isnan(alpha))
    mu = theory.coupling_coefficients(n)
    size = np.hypot(mu.mu_1 - mu.mu_3 * np.sin(GRID_BETA), mu.mu_3 * np.cos(GRID_BETA))
    level = np.abs(np.sin(GRID_BETA)) < 1e-15
    finite = np.isfinite(size) & ~(level & ((GRID_PHI == 1) | (GRID_X == 1)))  # there (22) is 0/0
    assert np.all(np.abs(theory.balance(n, alpha) / size)[finite] < 1e-9)
    np.testing.assert_allclose((theory.stability(n, alpha) / size)[finite], 1, rtol=1e-9)
    np.testing.assert_array_equal(np.isnan(alpha), level & (GRID_X == 1))  # true resonance
    np.testing.assert_allclose(alpha[level & (GRID_X < 1)], np.pi)
    np.testing.assert_allclose(alpha[level & (GRID_X > 1)], 0, atol=1e-12)
    circle = np.linspace(-np.pi, np.pi, 721)
    signs = theory.balance(theory.Ratios(0.5, 2.0), circle) > 0
    assert np.sum(~signs[:-1] & signs[1:]) == 1  # no second stable root


def test_the_phase_does_not_depend_on_how_the_angle_is_reached() -> None:
    n = theory.Ratios(GRID_X, GRID_PHI, beta=GRID_BETA)
    for turn in (np.pi, -np.pi):  # l -> -l with phi_2 measured alike: the same roots
        other = theory.stable_phase_difference(n._replace(beta=GRID_BETA + turn))
        away = wrapped(other - theory.stable_phase_difference(n))
        assert np.nanmax(np.abs(away)) < 1e-6
    steps = theory.stable_phase_difference(
        theory.Ratios(2.0, 3.0, beta=np.linspace(0, 2 * np.pi, 2001))
    )
    assert np.max(np.abs(wrapped(np.diff(steps)))) < 0.05  # no jump, at pi/2 neither


def test_springs_may_be_missing() -> None:
    endless = theory.stable_phase_difference(theory.Ratios(np.inf, np.inf, beta=0.4))
    far = theory.stable_phase_difference(theory.Ratios(1e7, 1e7, beta=0.4))
    assert endless == pytest.approx(far, abs=1e-9)
    n = theory.ratios(CASE_2.replace(platform_stiffness=0.0))
    assert n.n_x == np.inf
    assert np.isfinite(theory.stable_phase_difference(n))


def test_the_papers_phases_need_the_corrected_coefficient() -> None:
    one, two = theory.Ratios(0.4943, 0.4943), theory.Ratios(5.916, 5.029)
    assert theory.stable_phase_difference(two) == pytest.approx(-0.5474, abs=1e-4)
    assert theory.stable_phase_difference(two, as_printed=True) != pytest.approx(-0.5474, abs=5e-3)
    assert -theory.stable_phase_difference(one) == pytest.approx(3.013, abs=1e-3)  # sign lost
    found = theory.printed_phase_difference(one)  # (33): on the unstable root
    assert theory.stability(one, found) < 0
    assert np.isnan(theory.printed_phase_difference(one._replace(beta=0.0, n_x=1.0)))


def phase_decay_rate(p: RotorPendulum) -> Any:
    """Return the rate [1/s] at which the phase settles, by the coupling without dampers.

    The slow root of ``m r^2 alpha'' + (k_e + f) alpha' + W alpha = 0``, which (35) leaves in units
    of torque: W over k_e + f where the motors are stiff.
    """
    inertia = p.rotor_mass * np.square(p.eccentricity)
    loss = np.asarray(p.motor_slope + p.friction, dtype=complex)
    amplitude = theory.coupling_amplitude(p)
    return (2 * amplitude / (loss + np.sqrt(loss**2 - 4 * inertia * amplitude))).real


@pytest.mark.parametrize("p", [CASE_1, CASE_2, CASE_3, CASE_2.replace(installation_angle=-2.0)])
def test_without_dampers_the_coupling_is_the_papers(p: RotorPendulum) -> None:
    p = p.replace(**UNDAMPED)
    alpha = np.linspace(-np.pi, np.pi, 50)
    stable = theory.stable_phase_difference(theory.ratios(p))
    amplitude = theory.coupling_amplitude(p)
    expected = -amplitude * np.sin(alpha - stable)
    np.testing.assert_allclose(coupling_torque(p, alpha), expected, atol=1e-9 * amplitude)
    assert abs(wrapped(balanced_phase(p) - stable)) < 1e-7
    assert settling_rate(p, stable) == pytest.approx(phase_decay_rate(p), rel=1e-9)
    assert settling_rate(p, stable + np.pi) < 0


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_coupling_torque_is_the_average_of_what_the_equations_give(placement: str) -> None:
    """Mean of (26) by quadrature, x and phi_3 from the linearised scene by M, C, K."""
    p = CASE_2.replace(motor_placement=placement)
    c = SCENE.coefficients(p)
    w = float(operating_speed(p))
    at = np.ix_([0, 3], [0, 3])
    mass, damping, stiffness = (
        matrix[at] for matrix in linearise(SCENE, p, SCENE.state({"phi_2": 0.0}))
    )
    turn = np.arange(64) * 2 * np.pi / 64
    for alpha in (-2.0, 0.3, 1.0):
        second = turn - alpha
        q = np.array([0 * turn, turn, second, 0 * turn])
        v = np.array([0 * turn, w + 0 * turn, w + 0 * turn, 0 * turn])
        load = np.array(SCENE.forces(0.0, q, v, c))[[0, 3]]
        load -= np.mean(load, axis=1)[:, None]
        impedance = stiffness - w**2 * mass + 1j * w * damping
        amplitude = np.linalg.solve(impedance, 2 * np.mean(load * np.exp(-1j * turn), axis=1))
        np.testing.assert_allclose(amplitude, forced_response(p, alpha), rtol=1e-9)
        a = np.real(-(w**2) * amplitude[:, None] * np.exp(1j * turn))
        full = np.array([a[0], 0 * turn, 0 * turn, a[1]])
        inertial = np.einsum("ij...,j...->i...", _mass_along(q, c), full)
        difference = -np.mean(inertial[1] - inertial[2])
        assert difference == pytest.approx(float(coupling_torque(p, alpha)), rel=1e-9)
        mean, first = coupling_harmonics(p)
        assert difference == pytest.approx(float(mean + np.real(first * np.exp(1j * alpha))))


def _mass_along(q: Array, c: Any) -> Array:
    rows = SCENE.mass_matrix(q, c)
    return np.array([[np.broadcast_to(entry, q[0].shape) for entry in row] for row in rows])


@pytest.mark.slow
def test_orbit_and_theory_meet() -> None:
    """Cases 1 and 2: phase and settling rate; the damper of the rod moves the phase of case 2."""
    for p, phase, rate in ((CASE_1, 1e-3, 0.002), (CASE_2, 0.09, 0.07)):
        guess = orbit_guesses(p)[0]
        one = shoot(SCENE, p, guess[:, None], steps=64)
        assert np.all(one.closed)
        parts = one.periods[0], one.states[:, 0], one.multipliers[:, 0], one.monodromy[0]
        orbit = Orbit(*parts)
        speed = 2 * np.pi / orbit.period
        found = SCENE.orbit.quantities(orbit_samples(SCENE, p, orbit), SCENE.coefficients(p))
        assert set(found) == set(SCENE.orbit.units)
        assert abs(wrapped(found["phase_difference"] - balanced_phase(p, speed))) < phase
        slowest = np.sort(np.abs(np.log(np.abs(orbit.multipliers))))[1] / orbit.period
        assert settling_rate(p, found["phase_difference"], speed) == pytest.approx(
            slowest, rel=rate
        )
        assert np.sum(np.abs(orbit.multipliers) > 1 - 1e-9) == 1  # the shift in time
        assert found["motor_torque_1"] == pytest.approx(0.94 * (50 * np.pi - speed))
        assert found["motor_torque_2"] == pytest.approx(found["motor_torque_1"])
        without = theory.stable_phase_difference(theory.ratios(p, speed))
        assert (abs(without - found["phase_difference"]) > 0.5) == (p is CASE_2)


def test_case_3_has_no_phase_because_of_the_rods_damper() -> None:
    assert np.isnan(balanced_phase(CASE_3))
    assert np.isfinite(balanced_phase(CASE_3.replace(rod_damping=0.0)))
    assert np.isfinite(theory.stable_phase_difference(theory.ratios(CASE_3)))
    guesses = orbit_guesses(CASE_3)
    assert np.all(np.isfinite(guesses))
    many = CASE_2.replace(installation_angle=np.array([0.5, np.pi / 2]))
    assert np.all(np.isfinite(orbit_guesses(many)))
    assert np.shape(orbit_guesses(many)) == (9, 8, 2)


def test_a_rotor_that_hangs_is_a_pendulum() -> None:
    stiff = CONSERVATIVE.replace(
        platform_stiffness=1e12, rod_stiffness=1e12, gravity_x=3.0, gravity_y=-4.0
    )
    state = SCENE.state(SCENE.equilibria["rest"](stiff))
    forces = np.array(SCENE.forces(0.0, state[:4], state[4:], SCENE.coefficients(stiff)))
    assert np.max(np.abs(forces)) < 1e-12 * 1000
    mass, _, stiffness = linearise(SCENE, stiff, state)
    omega = sorted(mode.omega for mode in modes(mass, 0 * mass, stiffness))
    np.testing.assert_allclose(omega[:2], np.sqrt(5.0 / stiff.eccentricity), rtol=1e-5)
    with pytest.raises(NoOrbitError, match="turns steadily"):
        SCENE.equilibria["synchronous"](stiff)
    with pytest.raises(ParameterError, match="gravity"):
        theory.ratios(stiff)
    free = CONSERVATIVE.replace(rod_stiffness=0.0, gravity_y=-4.0)
    assert SCENE.equilibria["rest"](free)["phi_3"] == pytest.approx(-2 * np.pi / 3)
