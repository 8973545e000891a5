"""speed_regulator: the ledger's verdicts, the misprints, and the figures."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from mbcheck.comparisons.papers.ledger import NOT_REPRODUCED
from mbcheck.comparisons.papers.session import Session
from mbcheck.comparisons.papers.speed_regulator import printed, results
from mbcheck.comparisons.papers.speed_regulator.figures import last_turn, turns_apart
from mbcheck.comparisons.papers.speed_regulator.rows import FIGURES, ROWS
from mbcheck.reference import get_scene
from mbcheck.reference.speed_regulator.equations import (
    SpeedRegulator,
    coefficients,
    outputs,
    position,
)
from mbcheck.reference.speed_regulator.orbit import mean_speed
from mbcheck.reference.speed_regulator.theory import least_torque, printed_mean_speed, rotation

PARAMETERS = (
    SpeedRegulator(),
    SpeedRegulator(crank_radius=0.9, rod_mass=3.0, damping=7.0, torque=2.0, stiffness=11.0),
)
SCENE = get_scene("speed_regulator")


@pytest.fixture(scope="module")
def alone() -> Session:
    """Return a session with the reference alone, shared by all tests here."""
    return Session()


def test_a_wrong_reference_changes_verdicts(
    alone: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = {row.name: row for row in ROWS}
    session = replace(alone, kept={})
    monkeypatch.setattr(results, "EXAMPLE", results.EXAMPLE.replace(torque=0.3205))
    assert rows["stabilised_speed"].find(session).verdict == NOT_REPRODUCED
    right = printed.kinematics
    wrong = lambda phi, p: right(phi, p)._replace(t=1.001 * right(phi, p).t)  # noqa: E731
    monkeypatch.setattr(printed, "kinematics", wrong)
    assert rows["remainder"].find(session).verdict == NOT_REPRODUCED
    wrong = lambda phi, p: right(phi, p)._replace(a_1=1.001 * right(phi, p).a_1)  # noqa: E731
    monkeypatch.setattr(printed, "kinematics", wrong)
    for name in ("equation_17", "mean_damper", "kinematics", "last_line_of_19"):
        assert rows[name].find(session).verdict == NOT_REPRODUCED, name


# --- Misprints -------------------------------------------------------------------------------


@pytest.mark.parametrize("p", PARAMETERS)
def test_the_left_of_12_is_a_second_derivative(p: SpeedRegulator) -> None:
    probe, speed, rate = 1e-4, 3.0, 2.0
    times = np.array([-probe, 0.0, probe])
    phi = 0.7 + speed * times + rate * times**2 / 2
    y = position(phi, coefficients(p)).y
    found = printed.kinematics(0.7, p)
    right = found.a_1[4] * rate + found.a_2[4] * speed**2
    assert (y[0] - 2 * y[1] + y[2]) / probe**2 == pytest.approx(right, rel=1e-5)
    assert (y[2] - y[0]) / (2 * probe) != pytest.approx(right, rel=0.1)


@pytest.mark.parametrize("p", PARAMETERS)
def test_the_slider_moves_along_y(p: SpeedRegulator) -> None:
    phi, speed = 0.7, 3.0
    found = {k: float(v) for k, v in outputs([phi], [speed], coefficients(p)).items()}
    load = p.damping * found["y_dot"] + p.stiffness * (found["y"] - p.spring_rest)
    acceleration = SCENE.accelerations(0.0, [phi], [speed], coefficients(p))[0]
    at = position(phi, coefficients(p))
    y_ddot = at.y_phi * acceleration + at.y_phi_phi * speed**2
    assert p.slider_mass * y_ddot == pytest.approx(-load - found["reaction_b_y"], rel=1e-12)
    beta = math.asin(p.crank_radius * math.cos(phi) / p.rod_length)
    assert p.crank_radius * math.cos(phi) == pytest.approx(p.rod_length * math.sin(beta))  # x_B


@pytest.mark.parametrize("p", PARAMETERS)
def test_the_first_row_of_14_is_the_cranks(p: SpeedRegulator) -> None:
    a_1 = printed.kinematics(0.7, p).a_1
    masses = printed.masses(p)
    assert a_1.shape == masses.shape == (5,)
    with pytest.raises(ValueError, match="broadcast"):
        masses * a_1[1:]
    assert (masses * a_1)[0] == p.flywheel_inertia


@pytest.mark.parametrize("p", PARAMETERS)
def test_15_and_not_5_gives_the_equation_of_motion(p: SpeedRegulator) -> None:
    phi, speed = 0.9, 4.0
    exact = SCENE.accelerations(0.0, [phi], [speed], coefficients(p))[0]
    assert printed.acceleration(phi, speed, p) == pytest.approx(exact, rel=1e-11)
    a_1 = printed.kinematics(phi, p).a_1
    assert a_1 @ printed.reaction_matrix(phi, p) == pytest.approx(np.zeros(4), abs=1e-13)
    other = p.replace(torque=3 * p.torque)  # (5) does not know it
    changed = SCENE.accelerations(0.0, [phi], [speed], coefficients(other))[0]
    assert changed != pytest.approx(exact, rel=0.01)
    np.testing.assert_array_equal(printed.kinematics(phi, other).a_1, a_1)


@pytest.mark.parametrize("p", PARAMETERS)
def test_the_last_line_of_19_has_lost_the_damper(p: SpeedRegulator) -> None:
    phi, speed = np.linspace(0, 6, 13), 4.0
    placed = p.replace(spring_rest=-p.rod_length)
    y_phi = position(phi, coefficients(placed)).y_phi
    full = printed.torque(phi, speed, placed)
    last = printed.torque_last_line(phi, placed)
    np.testing.assert_allclose(last - p.damping * speed * y_phi**2, full, atol=1e-11)
    assert np.max(abs(last - full)) > 0.1 * np.max(abs(full))
    np.testing.assert_allclose(printed.torque(phi, 0.0, placed), last, atol=1e-11)


def test_section_3_averages_another_spring() -> None:
    p = PARAMETERS[0]
    phi = np.linspace(0, 6, 13)
    r, l = p.crank_radius, p.rod_length
    b = np.arcsin(r * np.cos(phi) / l)
    force = p.stiffness * (l + r * np.sin(phi) - l * np.cos(b))
    np.testing.assert_allclose(force, printed.spring(phi, p), atol=1e-13)
    averaged = p.stiffness * (r + l + r * np.sin(phi) - l * np.cos(b))
    other = printed.spring(phi, p.replace(spring_rest=-(r + l)))
    np.testing.assert_allclose(averaged, other, atol=1e-13)
    np.testing.assert_allclose(averaged - force, p.stiffness * r)
    means = printed.averages(p)
    assert max(abs(means.spring_19), abs(means.spring_3)) < 1e-15


def test_the_stabilised_speed_is_no_length_per_time() -> None:
    p = PARAMETERS[0]
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


def test_averages_are_those_of_a_quadrature() -> None:
    for ratio in (0.1, 0.2, 0.6):
        p = SpeedRegulator(crank_radius=ratio * 1.25)
        found = printed.averages(p)
        assert found.damper == pytest.approx(1 - math.sqrt(1 - ratio**2), rel=1e-13)
        assert found.remainder == pytest.approx(found.damper - ratio**2 / 2, rel=1e-10)
        assert found.cos_squared == pytest.approx(0.5, rel=1e-14)
        assert abs(found.slope) + abs(found.mixed) < 1e-15


# --- What rows and figures are made of -------------------------------------------------------


@pytest.mark.slow
def test_least_torques_are_the_theorys_to_four_digits() -> None:
    sets = [results.EXAMPLE, results.EXAMPLE.replace(stiffness=8.0, damping=5.0)]
    exact = [least_torque(p).torque for p in sets[:1]]
    found = results.least_torques(sets)
    assert found[0] == pytest.approx(exact[0], rel=2e-4)
    assert found[1] > found[0]


def test_turns_of_a_run(alone: Session) -> None:
    found = results.run(alone, "frictionless")
    speeds = results.turn_speeds(found)
    assert np.all(np.diff(speeds) > 0)
    assert results.mean_over_turns(found, 1)[3] == pytest.approx(speeds[3], rel=1e-3)
    y, rate = last_turn(found)
    assert y[0] == pytest.approx(y[-1], abs=1e-3)
    assert abs(rate[0] - rate[-1]) > 1e-4  # it gets faster
    times, gap = turns_apart(found, found)
    assert len(times) == len(gap) > 3
    assert not np.any(gap)


def test_a_figure_is_drawn_without_engines(alone: Session) -> None:
    pytest.importorskip("matplotlib")
    figure = next(item for item in FIGURES if item.number == 6).draw(alone)
    assert len(figure.axes) == 4
    assert all(item.caption.count("our choice") for item in FIGURES)


@pytest.mark.slow
@pytest.mark.parametrize("number", [3, 4, 5, 6, 7])
def test_figures_are_drawn_with_all_engines(number: int) -> None:
    pytest.importorskip("matplotlib")
    engines = tuple(name for name in ("mujoco", "exudyn") if pytest.importorskip(name))
    figure = next(item for item in FIGURES if item.number == number)
    drawn = figure.draw(Session(engines=engines))
    words = {text.get_text() for text in drawn.legends[0].get_texts()}
    assert {"MuJoCo", "Exudyn"} <= words


@pytest.mark.slow
def test_engines_agree_on_the_regimes() -> None:
    pytest.importorskip("mujoco")
    pytest.importorskip("exudyn")
    session = Session(engines=("mujoco", "exudyn"))
    assert min(results.agreement(session, "damping", name)[0] for name in session.engines) > 0.95
