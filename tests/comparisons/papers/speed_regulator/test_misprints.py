"""The misprints of the speed_regulator paper, proved."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from mbcheck.comparisons.papers.session import Session
from mbcheck.comparisons.papers.speed_regulator import derivation
from mbcheck.comparisons.papers.speed_regulator.derivation import (
    ANGLES,
    PROBE,
    SPEED,
    nonlinearity,
    slope_of,
    work_of_reactions,
)
from mbcheck.comparisons.papers.speed_regulator.results import EXAMPLE, damped
from mbcheck.comparisons.papers.speed_regulator.rows import ROWS
from mbcheck.reference import get_scene
from mbcheck.reference.errors import NoOrbitError
from mbcheck.reference.speed_regulator.equations import (
    SpeedRegulator,
    coefficients,
    position,
)
from mbcheck.reference.speed_regulator.orbit import mean_speed
from mbcheck.reference.speed_regulator.rest import static_torque
from mbcheck.reference.speed_regulator.theory import printed_mean_speed, rotation

PARAMETERS = (
    SpeedRegulator(),
    SpeedRegulator(crank_radius=0.9, rod_mass=3.0, damping=7.0, torque=2.0, stiffness=11.0),
)
SCENE = get_scene("speed_regulator")
REASONS = {row.name: row.reason for row in ROWS}


def torque_last_line(phi: Any, p: SpeedRegulator) -> Any:
    """Return M by the last line of (19) as printed."""
    at = derivation.kinematics(phi, p)
    y_phi, y = at.a_1[4], at.places[4]
    return p.torque - p.stiffness * p.rod_length * y_phi - p.stiffness * y_phi * y


# What identities leave over, relative: as printed and corrected ---------------------------------


def dots_of_12() -> tuple[float, float]:
    """Left of (12): y_B with one dot, and its second derivative by a complex step."""
    phi, speed, rate = 0.7, SPEED, 1.3
    at = derivation.kinematics(phi, EXAMPLE)
    right = at.a_1[4] * rate + at.a_2[4] * speed**2
    moved = derivation.kinematics(phi + 1j * PROBE * speed, EXAMPLE)
    a_1 = at.a_1[4] + slope_of(moved.a_1[4]) * 1j * PROBE
    second = slope_of(a_1 * (speed + 1j * PROBE * rate))
    return abs(at.a_1[4] * speed / right - 1), abs(float(second) / right - 1)


def slider_equation() -> tuple[float, float]:
    """Momentum of the slider: along x, where it does not move, and along y."""
    phi = 0.7
    free = derivation.free_bodies(phi, SPEED, EXAMPLE)
    at = derivation.kinematics(phi, EXAMPLE)
    load = EXAMPLE.damping * at.a_1[4] * SPEED + derivation.spring(phi, EXAMPLE)
    y_b = at.a_1[4] * free[0] + at.a_2[4] * SPEED**2
    x_b = EXAMPLE.crank_radius * np.cos(phi) - EXAMPLE.rod_length * np.sin(at.beta)
    force = -load - free[4]
    along_x, along_y = (abs(EXAMPLE.slider_mass * a - force) / abs(force) for a in (x_b, y_b))
    return float(along_x), float(along_y)


def row_4_of_14() -> tuple[float, float]:
    """Work of the reactions."""
    wrong, right = (float(work_of_reactions(as_printed)["work"]) for as_printed in (True, False))
    return wrong, right


def factor_of_18() -> tuple[float, float]:
    """J' and the derivative of J, by a complex step."""
    slope = slope_of(derivation.moment_of_inertia(ANGLES + 1j * PROBE, EXAMPLE))
    half = derivation.printed_slope(ANGLES, EXAMPLE)
    wrong, right = (np.max(abs(k * half - slope)) / np.max(abs(slope)) for k in (1, 2))
    return float(wrong), float(right)


def last_line_of_19() -> tuple[float, float]:
    """M(phi) without and with the damper."""
    c = coefficients(EXAMPLE)
    missing = c.damping * SPEED * position(ANGLES, c).y_phi ** 2
    full = c.torque - static_torque(ANGLES, c) - missing
    last = torque_last_line(ANGLES, EXAMPLE)
    wrong, right = (np.max(abs(m - full)) / np.max(abs(full)) for m in (last, last - missing))
    return float(wrong), float(right)


def spring_of_section_3() -> tuple[float, float]:
    """Forces of springs at rest at -(r + l) and at -l, over k r."""
    phi, p = np.array([0.3, 1.0, 2.0]), EXAMPLE
    y = derivation.kinematics(phi, p).places[4]
    true, size = derivation.spring(phi, p), p.stiffness * p.crank_radius
    wrong, right = (
        np.max(abs(p.stiffness * (rest + y) - true)) / size
        for rest in (p.crank_radius + p.rod_length, p.rod_length)
    )
    return float(wrong), float(right)


@pytest.mark.parametrize(
    ("name", "residuals"),
    [
        ("dots_of_12", dots_of_12),
        ("slider_equation", slider_equation),
        ("row_4_of_14", row_4_of_14),
        ("factor_of_18", factor_of_18),
        ("last_line_of_19", last_line_of_19),
        ("spring_of_section_3", spring_of_section_3),
    ],
)
def test_printed_formula_misses_an_identity_and_the_corrected_one_holds(
    name: str, residuals: Any
) -> None:
    wrong, right = residuals()
    assert right < 1e-12 < 1e-3 < wrong
    assert f"off by {wrong:.3g} as printed" in REASONS[name]


def test_row_4_of_14_changes_the_acceleration() -> None:
    wrong, right = (
        derivation.free_bodies(0.3, SPEED, EXAMPLE, as_printed)[0] for as_printed in (True, False)
    )
    words = f"phi'' at 0.3 rad would be {wrong:.3g} instead of {right:.3g} rad/s^2"
    assert words in REASONS["row_4_of_14"]


def test_18_as_printed_does_not_conserve_energy() -> None:
    """Of a free crank: phi'' = -J' phi'^2 / (2 J) with half the slope."""
    p = EXAMPLE.replace(torque=0.0, damping=0.0, stiffness=0.0)
    moment = derivation.moment_of_inertia(np.linspace(0, 2 * np.pi, 513), p)
    energy = moment * moment**-0.5  # phi'^2 goes as J^(-1/2), not 1 / J
    assert f"by {np.ptp(energy) / energy[0]:.2%} in a turn" in REASONS["factor_of_18"]


def test_without_the_damper_there_is_no_steady_rotation() -> None:
    with pytest.raises(NoOrbitError):
        rotation(damped(0.0))


# By other routes --------------------------------------------------------------------------------


@pytest.mark.parametrize("p", PARAMETERS)
def test_the_first_row_of_14_is_the_cranks(p: SpeedRegulator) -> None:
    a_1 = derivation.kinematics(0.7, p).a_1
    masses = derivation.masses(p)
    assert a_1.shape == masses.shape == (5,)
    with pytest.raises(ValueError, match="broadcast"):
        masses * a_1[1:]
    assert (masses * a_1)[0] == p.flywheel_inertia


@pytest.mark.parametrize("p", PARAMETERS)
def test_15_and_not_5_gives_the_equation_of_motion(p: SpeedRegulator) -> None:
    phi, speed = 0.9, 4.0
    exact = SCENE.accelerations(0.0, [phi], [speed], coefficients(p))[0]
    assert derivation.acceleration(phi, speed, p) == pytest.approx(exact, rel=1e-11)
    a_1 = derivation.kinematics(phi, p).a_1
    assert a_1 @ derivation.reaction_matrix(phi, p) == pytest.approx(np.zeros(4), abs=1e-13)
    other = p.replace(torque=3 * p.torque)  # (5) does not know it
    changed = SCENE.accelerations(0.0, [phi], [speed], coefficients(other))[0]
    assert changed != pytest.approx(exact, rel=0.01)
    np.testing.assert_array_equal(derivation.kinematics(phi, other).a_1, a_1)


def test_the_stabilised_speed_is_no_length_per_time() -> None:
    p = PARAMETERS[0]
    pin = float(mean_speed(p)) * p.crank_radius
    assert f"would be {pin:.2f} with r = {p.crank_radius:g} m" in REASONS["unit_of_the_speed"]
    feet = p.replace(  # the same regulator with lengths in another unit
        **{
            name: getattr(p, name) / 0.3048
            for name in ("crank_radius", "rod_length", "spring_rest")
        },
        **{name: getattr(p, name) / 0.3048**2 for name in ("flywheel_inertia", "torque")},
    )
    assert float(mean_speed(feet)) == pytest.approx(float(mean_speed(p)), rel=1e-12)
    assert float(printed_mean_speed(feet)) == pytest.approx(float(printed_mean_speed(p)), rel=1e-12)
    assert rotation(feet).mean_speed == pytest.approx(rotation(p).mean_speed, rel=1e-9)


@pytest.mark.parametrize("p", PARAMETERS)
def test_the_inertia_of_the_first_row_of_13_is_the_flywheels(p: SpeedRegulator) -> None:
    phi = 0.7
    rate, x_a, y_a, *_ = derivation.free_bodies(phi, SPEED, p)
    law = p.torque - p.crank_radius * (x_a * np.sin(phi) - y_a * np.cos(phi))
    assert derivation.masses(p)[0] * rate == pytest.approx(law, rel=1e-12, abs=1e-15)


VAN_DER_POL, LAST = 7, 13
"""In the paper's list of references: van der Pol's paper, and the last."""


def test_citations_do_not_fit_the_list() -> None:
    row = next(row for row in ROWS if row.name == "citations")
    assert row.erratum
    as_printed, right = (
        [int(number) for number in re.findall(r"\[(\d+)\]", text)]
        for text in (row.printed, row.erratum.corrected)
    )
    assert [number - 1 for number in as_printed] == right
    assert VAN_DER_POL in right
    assert max(as_printed) > max(right) == LAST
    assert f"the list has {LAST}" in row.reason


def test_the_system_below_21_is_not_linear() -> None:
    found = nonlinearity(Session())
    assert min(found["bend"], found["uneven"]) > 0.01


def test_the_equation_of_motion_has_no_time() -> None:
    state = [[0.7], [SPEED], coefficients(EXAMPLE)]
    early, late = (SCENE.accelerations(time, *state) for time in (0.0, 17.3))
    np.testing.assert_array_equal(early, late)


def test_18_as_printed_moves_the_limit_cycle() -> None:
    """Mean speed of the rotation of (17): that of an angle's period, by a secant of its return."""

    def turn(speed: float, factor: float) -> Any:
        def over_angle(phi: float, values: Any) -> Any:
            rate = derivation.acceleration(phi, values[0], EXAMPLE, factor)
            return [float(rate) / values[0], 1 / values[0]]

        return solve_ivp(over_angle, (0, 2 * np.pi), [speed, 0], rtol=1e-9, atol=1e-11).y[:, -1]

    words = []
    for factor in (1, 2):
        start = brentq(lambda v, f=factor: turn(v, f)[0] - v, 4.9, 5.3, xtol=1e-6)
        words.append(f"{2 * np.pi / turn(start, factor)[1]:.3f}")
    effect = next(row.erratum.effect for row in ROWS if row.name == "factor_of_18" and row.erratum)
    assert f"at {words[0]} instead of {words[1]} rad/s" in effect
