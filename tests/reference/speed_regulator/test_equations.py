"""speed_regulator: kinematics, rest and rotation."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import quad

from mbcheck.reference.errors import NoOrbitError, ParameterError
from mbcheck.reference.linear import linearise, modes
from mbcheck.reference.orbits import find_orbit, orbit_samples
from mbcheck.reference.periodic import extremes
from mbcheck.reference.speed_regulator import SCENE, theory
from mbcheck.reference.speed_regulator.equations import (
    SpeedRegulator,
    assembled,
    coefficients,
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
