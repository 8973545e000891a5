"""speed_regulator: equations by two other routes, rest and rotation."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import quad

from mbcheck.reference.differences import by_complex_step
from mbcheck.reference.errors import NoOrbitError, ParameterError
from mbcheck.reference.linear import linearise, modes
from mbcheck.reference.orbits import find_orbit, orbit_samples
from mbcheck.reference.periodic import extremes
from mbcheck.reference.solve.rk8 import rk8_steps
from mbcheck.reference.speed_regulator import SCENE, theory
from mbcheck.reference.speed_regulator.equations import (
    SpeedRegulator,
    assembled,
    coefficients,
    inertia,
    inertia_slope,
    position,
)
from mbcheck.reference.speed_regulator.motions import (
    EQUILIBRIA,
    found_equilibria,
    mean_speed,
    orbit_quantities,
    static_stiffness,
    static_torque,
)

Array = NDArray[np.float64]


DEFAULT = SpeedRegulator()


least_torque = functools.cache(theory.least_torque)


REACTIONS = ("reaction_a_x", "reaction_a_y", "reaction_b_x", "reaction_b_y")


def random_parameters(count: int = 40) -> list[SpeedRegulator]:
    """Return parameters over orders of magnitude; some without the masses, or a damper."""
    random = np.random.default_rng(2018)
    found = []
    for i in range(count):
        values = {
            name: value * 10 ** random.uniform(-1, 1)
            for name, value in DEFAULT.as_dict().items()
            if not name.startswith("gravity_")
        }
        values["crank_radius"] = values["rod_length"] * random.uniform(0.02, 0.9)
        values["torque"] *= random.choice([-1, 1])
        values["spring_rest"] *= random.choice([-1, 1])
        for k, name in enumerate(("rod_mass", "slider_mass", "damping", "stiffness")):
            values[name] *= i % 8 != k
        found.append(SpeedRegulator(**values))
    return found


def random_points() -> list[tuple[float, float, SpeedRegulator]]:
    """Return angles, speeds and parameters."""
    random = np.random.default_rng(4)
    return [(random.uniform(-10, 10), random.normal() * 10, p) for p in random_parameters()]


# --- Lagrange --------------------------------------------------------------------------------


def test_power_is_the_rate_of_energy() -> None:
    probe = 1e-30
    for phi, speed, p in random_points():
        c = coefficients(p)
        acceleration = SCENE.accelerations(0.0, [phi], [speed], c)[0]
        changed = SCENE.energy([phi + 1j * probe * speed], [speed + 1j * probe * acceleration], c)
        powers = SCENE.powers(0.0, [phi], [speed], c)
        at = position(phi, c)
        spring = c.stiffness * abs(at.y_phi * (at.y - c.rest) * speed)
        size = sum(map(abs, powers.values())) + spring + abs(inertia_slope(at, c) * speed**3)
        assert changed.imag / probe == pytest.approx(sum(powers.values()), abs=1e-12 * size)
        assert powers["damper"] <= 0


# --- Newton and Euler: (11)-(16) -------------------------------------------------------------


def printed_vectors(phi: float, p: SpeedRegulator) -> tuple[Array, Array]:
    """Return {A_1}, {A_2} of (12), from (7) and (10)."""
    r, l = p.crank_radius, p.rod_length
    b = math.asin(r * math.cos(phi) / l)
    s, c, sin_b, cos_b = math.sin(phi), math.cos(phi), math.sin(b), math.cos(b)
    t = r * s / (l * cos_b)
    u = r / l * c / cos_b - t**2 * sin_b / cos_b
    a_1 = [
        1,
        -r * s + l / 2 * t * cos_b,
        r * c - l / 2 * t * sin_b,
        t,
        r * c - l * t * sin_b,
    ]
    a_2 = [
        0,
        -r * c + l / 2 * t**2 * sin_b + l / 2 * u * cos_b,
        -r * s + l / 2 * t**2 * cos_b - l / 2 * u * sin_b,
        u,
        -r * s + l * t**2 * cos_b - l * u * sin_b,
    ]
    return np.array(a_1), np.array(a_2)


def masses(p: SpeedRegulator, rod_inertia: float = 1 / 12) -> Array:
    """Return [m] of (13), J_C in units of m_b l^2."""
    j_c = rod_inertia * p.rod_mass * p.rod_length**2
    return np.array([p.flywheel_inertia, p.rod_mass, p.rod_mass, j_c, p.slider_mass])


def reaction_matrix(phi: float, p: SpeedRegulator, sign: int = -1) -> Array:
    """Return [N] of (14); as printed with ``sign=1``, from the free bodies of (13) with -1."""
    r, l = p.crank_radius, p.rod_length
    b = math.asin(r * math.cos(phi) / l)
    x, y = l / 2 * math.cos(b), sign * l / 2 * math.sin(b)
    return np.array(
        [
            [-r * math.sin(phi), r * math.cos(phi), 0, 0],
            [-1, 0, 1, 0],
            [0, -1, 0, 1],
            [x, y, x, y],
            [0, 0, 0, -1],
        ]
    )


def newton_euler(
    phi: float, speed: float, p: SpeedRegulator, rod_inertia: float = 1 / 12, sign: int = -1
) -> Array:
    """Return phi'' and X_A, Y_A, X_B, Y_B: (14) with all rows, solved as one linear system."""
    a_1, a_2 = printed_vectors(phi, p)
    m = masses(p, rod_inertia)
    b = math.asin(p.crank_radius * math.cos(phi) / p.rod_length)
    y = p.crank_radius * math.sin(phi) - p.rod_length * math.cos(b)
    load = p.damping * a_1[4] * speed + p.stiffness * (y - p.spring_rest)
    external = np.array([p.torque, 0, 0, 0, -load])
    system = np.column_stack([m * a_1, -reaction_matrix(phi, p, sign)])
    return np.asarray(np.linalg.solve(system, external - m * a_2 * speed**2), dtype=float)


def test_accelerations_and_reactions_are_those_of_newton_and_euler() -> None:
    for phi, speed, p in random_points():
        c = coefficients(p)
        exact = newton_euler(phi, speed, p)
        found = SCENE.outputs(np.array([phi]), np.array([speed]), c)
        reactions = [found[name] for name in REACTIONS]
        at = position(phi, c)
        loads = c.stiffness * (abs(at.y) + abs(c.rest)) + c.damping * abs(found["y_dot"])
        size = np.max(np.abs(exact[1:])) + loads
        np.testing.assert_allclose(reactions, exact[1:], rtol=1e-12, atol=3e-12 * size)
        solved = SCENE.accelerations(0.0, [phi], [speed], c)[0]
        atol = 1e-12 * size * c.radius / inertia(at, c)
        assert solved == pytest.approx(exact[0], rel=1e-12, abs=atol)


def test_14_needs_minus_signs_and_16_says_so() -> None:
    for phi, _, p in random_points():
        a_1, _ = printed_vectors(phi, p)
        size = p.rod_length
        np.testing.assert_allclose(a_1 @ reaction_matrix(phi, p), 0, atol=1e-13 * size)
        assert np.max(np.abs(a_1 @ reaction_matrix(phi, p, sign=1))) > 1e-6 * size
    exact, printed = (newton_euler(0.3, 5.0, DEFAULT, sign=sign)[0] for sign in (-1, 1))
    assert abs(printed - exact) > 0.01 * abs(exact)


def test_18_lacks_a_factor_2() -> None:
    for phi, _, p in random_points():
        c = coefficients(p)
        at = position(phi, c)
        a_1, a_2 = printed_vectors(phi, p)
        m = masses(p)
        slope = inertia(position(phi + 1e-30j, c), c).imag / 1e-30
        size = inertia(at, c)
        assert a_1 @ (m * a_1) == pytest.approx(size, rel=1e-13)
        assert 2 * a_1 @ (m * a_2) == pytest.approx(slope, rel=1e-12, abs=1e-13 * size)
        assert inertia_slope(at, c) == pytest.approx(slope, rel=1e-12, abs=1e-13 * size)


FAULTS: dict[str, Callable[[float, float], float]] = {
    "lost factor 2 in J'": lambda phi, speed: float(
        SCENE.accelerations(0.0, [phi], [speed], coefficients(DEFAULT))[0]
        + inertia_slope(position(phi, coefficients(DEFAULT)), coefficients(DEFAULT))
        * speed**2
        / (4 * inertia(position(phi, coefficients(DEFAULT)), coefficients(DEFAULT)))
    ),
    "J_C = m_b l^2/3": lambda phi, speed: float(newton_euler(phi, speed, DEFAULT, 1 / 3)[0]),
    "y_0 = -(l + r)": lambda phi, speed: float(
        newton_euler(phi, speed, DEFAULT.replace(spring_rest=-1.5))[0]
    ),
    "0.1 % on the rod's length": lambda phi, speed: float(
        newton_euler(phi, speed, DEFAULT.replace(rod_length=1.25125))[0]
    ),
    "no damper": lambda phi, speed: float(
        newton_euler(phi, speed, DEFAULT.replace(damping=0.0))[0]
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_show_in_the_accelerations(fault: str) -> None:
    random = np.random.default_rng(5)
    points = np.column_stack([random.uniform(-np.pi, np.pi, 16), random.uniform(-5, 5, 16)])
    c = coefficients(DEFAULT)
    exact = np.array([SCENE.accelerations(0.0, [q], [v], c)[0] for q, v in points])
    wrong = np.array([FAULTS[fault](*point) for point in points])
    assert np.max(np.abs(wrong - exact)) > 1e-4 * np.max(np.abs(exact))  # algebra: 1e-10


# --- Kinematics ------------------------------------------------------------------------------


def test_rod_and_slider_close_the_loop_and_move_as_their_rates_say() -> None:
    probe = 1e-30
    pairs = {"y": "y_dot", "rod_angle": "rod_angle_dot", "rod_x": "rod_x_dot", "rod_y": "rod_y_dot"}
    for phi, speed, p in random_points():
        c = coefficients(p)
        found = SCENE.outputs([phi], [speed], c)
        pin = c.radius * np.array([math.cos(phi), math.sin(phi)])
        slider = np.array([0.0, found["y"]])
        b = found["rod_angle"]
        np.testing.assert_allclose(
            pin - slider, c.length * np.array([math.sin(b), math.cos(b)]), atol=1e-14 * c.length
        )
        np.testing.assert_allclose(
            (pin + slider) / 2, [found["rod_x"], found["rod_y"]], atol=1e-14 * c.length
        )
        assert found["cos_b"] == pytest.approx(math.cos(b), rel=1e-12)
        moved = SCENE.outputs([phi + 1j * probe * speed], [speed + 0j], c)
        for name, rate in pairs.items():
            size = c.length * abs(speed)
            assert moved[name].imag / probe == pytest.approx(found[rate], abs=1e-12 * size)
    assert set(SCENE.units) == {"phi", "phi_dot", *found}


def test_the_assembly_branch_is_seen() -> None:
    phi = np.linspace(0, 7, 50)
    p = DEFAULT.replace(crank_radius=1.2499999)
    at = position(phi, coefficients(p))
    assert np.all(assembled({"phi": phi, "y": at.y}, p))
    flipped = p.crank_radius * at.sin + at.h
    assert not np.any(assembled({"phi": phi, "y": flipped}, p))


def test_near_lambda_1_the_loop_keeps_its_digits() -> None:
    p = DEFAULT.replace(crank_radius=1.25 * (1 - 1e-13))
    at = position(1e-7, coefficients(p))
    exact = sp.sqrt(
        sp.Float(p.rod_length, 50) ** 2
        - (sp.Float(p.crank_radius, 50) * sp.cos(sp.Float(1e-7, 50))) ** 2
    )
    assert at.h == pytest.approx(float(exact), rel=1e-14)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"crank_radius": 1.25}, "lengthen rod_length"),
        ({"rod_length": 0.2}, "must be less than 1"),
        ({"crank_radius": np.array([0.1, 1.3])}, "1.04"),
        ({"rod_mass": -0.1}, "rod_mass must be 0 or greater"),
        ({"slider_mass": -1.0}, "slider_mass must be 0 or greater"),
        ({"flywheel_inertia": 0.0}, "flywheel_inertia must be greater than 0"),
        ({"damping": -2.0}, "damping must be 0 or greater"),
        ({"torque": math.nan}, "torque must be finite"),
    ],
)
def test_impossible_parameters_are_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        DEFAULT.replace(**changes)


# --- Rest ------------------------------------------------------------------------------------


@pytest.mark.parametrize("torque", [-0.5, 0.0, 0.32, 0.9])
@pytest.mark.parametrize("rest", [-1.4, -1.25, -1.05])
def test_equilibria_rest_and_are_stable_or_saddles_as_named(torque: float, rest: float) -> None:
    p = DEFAULT.replace(torque=torque, spring_rest=rest)
    found = found_equilibria(p)
    for name, phi in found.items():
        state = SCENE.state(SCENE.equilibria[name](p))
        assert state[0] == phi
        assert np.max(np.abs(SCENE.right_hand_side(p)(0.0, state))) < 1e-14
        values = [mode.re for mode in modes(*linearise(SCENE, p, state))]
        stable = name in ("right", "left")
        assert (max(values) < 0) == stable
        assert (min(values) < 0 < max(values)) == (not stable)
    turned = found_equilibria(p.replace(torque=-torque))  # the mirror phi -> pi - phi
    mirror = {"right": "left", "left": "right", "top": "top", "bottom": "bottom"}
    for name, phi in found.items():
        assert math.sin(turned[mirror[name]]) == pytest.approx(math.sin(phi), abs=1e-12)
    if torque == 0:
        assert tuple(found) == EQUILIBRIA
        assert math.cos(found["right"]) > 0 > math.cos(found["left"])
        assert found["top"] == pytest.approx(np.pi / 2, abs=1e-12)


def test_an_equilibrium_that_is_not_there_is_named_with_the_reason() -> None:
    with pytest.raises(NoOrbitError, match=r"'right': the spring holds torques from .* 0\.93593"):
        SCENE.equilibria["right"](DEFAULT.replace(torque=1.0))
    assert set(found_equilibria(DEFAULT.replace(torque=1.0))) == {"left", "bottom"}
    assert found_equilibria(DEFAULT.replace(torque=1.1)) == {}
    far = DEFAULT.replace(spring_rest=-0.5)
    with pytest.raises(NoOrbitError, match="never comes to spring_rest"):
        SCENE.equilibria["right"](far)
    assert static_stiffness(found_equilibria(far)["top"], coefficients(far)) > 0
    with pytest.raises(NoOrbitError, match="without a spring"):
        SCENE.equilibria["right"](DEFAULT.replace(stiffness=0.0))


def test_saddle_node_torques_are_the_largest_that_the_spring_holds() -> None:
    for p in random_parameters():
        found = theory.saddle_node_torques(p)
        torque = static_torque(np.linspace(0, 2 * np.pi, 20001), coefficients(p))
        scale = np.max(np.abs(torque))
        assert max(found.values(), default=0.0) == pytest.approx(np.max(torque), abs=1e-6 * scale)
        for name, last in found.items():
            assert name in found_equilibria(p.replace(torque=last * (1 - 1e-9)))
            assert name not in found_equilibria(p.replace(torque=last * (1 + 1e-9)))


# --- Rotation --------------------------------------------------------------------------------


def test_21_takes_the_exact_mean_and_the_printed_one_holds_at_one_fifth() -> None:
    for p in random_parameters(8):
        c = coefficients(p)
        mean = quad(lambda phi: position(phi, c).y_phi ** 2, 0, 2 * np.pi, epsrel=1e-12)[0]  # noqa: B023
        ratio = p.crank_radius / p.rod_length
        exact = 2 * np.pi * p.rod_length**2 * (1 - math.sqrt(1 - ratio**2))
        assert mean == pytest.approx(exact, rel=1e-10)
        if p.damping:
            power = p.damping * mean / (2 * np.pi) * mean_speed(p)
            assert power == pytest.approx(p.torque, rel=1e-10)
    assert mean_speed(DEFAULT) == pytest.approx(5.07, abs=0.005)
    assert theory.printed_mean_speed(DEFAULT) == pytest.approx(mean_speed(DEFAULT), rel=1e-5)
    long = DEFAULT.replace(crank_radius=1.0)
    assert theory.printed_mean_speed(long) > 1.2 * mean_speed(long)


LIMIT_CYCLES: list[dict[str, float]] = [
    {},
    {"damping": 4.0},
    {"crank_radius": 0.75, "torque": 3.0},
    {"rod_mass": 0.0, "slider_mass": 0.0},
    {"flywheel_inertia": 0.5, "torque": 0.6},
    {"stiffness": 0.0},
    {"torque": 3.0, "damping": 30.0},
]


@pytest.mark.parametrize(
    "changes",
    [
        *LIMIT_CYCLES[:2],
        *(pytest.param(changes, marks=pytest.mark.slow) for changes in LIMIT_CYCLES[2:]),
    ],
)
def test_the_limit_cycle_by_shooting_is_that_by_the_crank_angle(changes: dict[str, float]) -> None:
    p = DEFAULT.replace(**changes)
    exact = theory.rotation(p)
    orbit = find_orbit(SCENE, p)
    assert orbit.period == pytest.approx(exact.period, rel=1e-10)
    assert orbit.state[1] == pytest.approx(exact.start_speed, rel=1e-10)
    multipliers = sorted(np.abs(orbit.multipliers))
    assert multipliers == pytest.approx(sorted([1, exact.multiplier]), rel=1e-9)
    found = orbit_quantities(orbit_samples(SCENE, p, orbit), coefficients(p))
    assert found["mean_speed"] == pytest.approx(exact.mean_speed, rel=1e-9)
    assert found["minimum_speed"] == pytest.approx(exact.minimum_speed, rel=1e-8)
    assert found["maximum_speed"] == pytest.approx(exact.maximum_speed, rel=1e-8)
    spread = (exact.maximum_speed - exact.minimum_speed) / exact.mean_speed
    assert found["irregularity"] == pytest.approx(spread, abs=1e-7)
    assert found["damper_work_ratio"] == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize("factor", [1.01, 1.1, 3.0])
def test_the_closed_multiplier_is_the_variational_one(factor: float) -> None:
    p = DEFAULT.replace(damping=4.0)
    p = p.replace(torque=least_torque(p).torque * factor)
    cycle = theory.rotation(p)
    start = np.array([0.0, cycle.start_speed])
    derivative = SCENE.right_hand_side(p)
    flow, jacobian = by_complex_step(
        lambda x: rk8_steps(derivative, x, 0.0, cycle.period, 2000), start
    )
    np.testing.assert_allclose(flow, [2 * np.pi, start[1]], rtol=1e-8)
    assert np.linalg.det(jacobian) == pytest.approx(cycle.multiplier, rel=1e-6)
    assert 0 < cycle.multiplier < 1


def test_no_rotation_is_said_so() -> None:
    for changes in ({"torque": 0.05}, {"torque": -1.0}, {"damping": 0.0}, {"torque": 0.0}):
        p = DEFAULT.replace(**changes)
        with pytest.raises(NoOrbitError, match="least_torque"):
            theory.rotation(p)
        assert not theory.rotates(p)
        assert np.all(np.isfinite(SCENE.period(p)))
        assert np.all(np.isfinite(SCENE.orbit.guesses(p)))


@pytest.mark.parametrize("count", [63, 64])
def test_extremes_lie_between_the_samples(count: int) -> None:
    phase = 2 * np.pi * (np.arange(count) + 0.37) / count
    low, high = extremes(1 / (1.5 + np.cos(phase)))
    assert (low, high) == pytest.approx((1 / 2.5, 2.0), rel=1e-8)
    assert extremes(np.full(count, 3.0)) == pytest.approx((3, 3), rel=1e-15)
