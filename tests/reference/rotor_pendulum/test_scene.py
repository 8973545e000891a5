"""Modes, parameters and cases of rotor_pendulum."""

from __future__ import annotations

import numpy as np
import pytest

from mbcheck.reference.errors import ParameterError, UnknownNameError
from mbcheck.reference.linear import linearise, modes
from mbcheck.reference.rotor_pendulum import CASE_1, SCENE
from mbcheck.reference.rotor_pendulum.equations import (
    RotorPendulum,
)
from mbcheck.reference.rotor_pendulum.phase import (
    balanced_phase,
    phase_rate,
    wrapped,
)

# Modes, parameters, cases ---------------------------------------------------------------------


def test_at_speed_the_rotors_masses_count_at_their_axes() -> None:
    p = SCENE.unforced(CASE_1)
    mass, damping, stiffness = linearise(SCENE, p, SCENE.state({}))
    held = tuple(SCENE.coordinates.index(name) for name in SCENE.steady_coordinates["synchronous"])
    found = modes(mass, 0 * mass, stiffness, held)
    lift = 3.6 * np.sin(np.pi / 6)
    hand = np.linalg.eigvals(
        np.linalg.solve([[114, -lift], [-lift, 1.08]], np.diag([9859600.0, 976100.0]))
    )
    np.testing.assert_allclose(
        [mode.omega for mode in found], [0, 0, *np.sort(np.sqrt(hand))], rtol=1e-12, atol=1e-9
    )
    np.testing.assert_array_equal(damping, np.diag([1064.0, 0, 0, 15.0]))
    free = modes(mass, 0 * mass, stiffness)
    assert [mode.omega for mode in free[:2]] == pytest.approx([0, 0], abs=1e-6)
    assert free[3].omega > 1.01 * found[3].omega  # free rotors give way


def test_bad_parameters_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"rotor_mass must be greater than 0"):
        RotorPendulum(rotor_mass=-2.0)
    with pytest.raises(ParameterError, match=r"friction must be 0 or greater"):
        RotorPendulum(friction=-0.1)
    with pytest.raises(
        UnknownNameError, match=r"motor_placement 'absolut'; did you mean 'absolute'"
    ):
        RotorPendulum(motor_placement="absolut")
    with pytest.raises(UnknownNameError, match=r"did you mean 'rod_length'"):
        CASE_1.replace(rod_lenght=1.0)
    RotorPendulum(installation_angle=-4.0, platform_stiffness=0.0, motor_slope=0.0)


def test_the_cases_are_those_of_the_paper_and_start_where_they_say() -> None:
    stiffness = {
        "case_1_startup": (9859600, 976100, np.pi / 6),
        "case_2_startup": (65969, 1053, np.pi / 6),
        "case_3_startup": (65969, 1053, np.pi / 2),
    }
    for name, values in stiffness.items():
        case = SCENE.case(name)
        p = case.parameters
        assert (p.platform_stiffness, p.rod_stiffness, p.installation_angle) == values
        assert not case.state
        assert case.horizon == 1
    for case in SCENE.cases:
        SCENE.state(case.state)
        assert case.parameters.names() == RotorPendulum.names()
        if case.watch == "outcome":
            rate = phase_rate(case.parameters)
            assert case.horizon > 8 / rate * 1.05
            away = wrapped(case.state["phi_1"] - balanced_phase(case.parameters))
            assert 0.9 < abs(away) < 1.1


def test_the_period_is_a_number_whatever_is_switched_off() -> None:
    assert 2 * np.pi / SCENE.period(CASE_1) == pytest.approx(0.94 / 0.96 * 50 * np.pi)
    off = CASE_1.replace(motor_slope=np.array([0.0, 0.94]), friction=0.0)
    np.testing.assert_allclose(SCENE.period(off), 0.04)


def test_a_rod_that_stands_upright_rests_there() -> None:
    """Gravity against the rod, exactly: between the spring and hanging there is no other root."""
    p = RotorPendulum(installation_angle=0.0, rod_stiffness=10.0, gravity_x=-9.81)
    assert SCENE.equilibria["rest"](p)["phi_3"] == 0
