"""The misprints of the rotor_pendulum paper, proved by what formulas give as printed and right."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from mbcheck.comparisons.papers.rotor_pendulum import rows as misprints
from mbcheck.comparisons.papers.rotor_pendulum.derivation import stiffness
from mbcheck.comparisons.papers.rotor_pendulum.rows import ROWS
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference import get_scene
from mbcheck.reference.rotor_pendulum import theory
from mbcheck.reference.rotor_pendulum.cases import CASE_1, CASE_2
from mbcheck.reference.rotor_pendulum.equations import coefficients
from mbcheck.reference.rotor_pendulum.phase import coupling_torque

OF = {row.name: row for row in ROWS}


def test_the_phase_passes_the_critical_point() -> None:
    """(30) has a stable root at beta = pi/2, and none of the phases beside it is far."""
    found = misprints.critical_point(Session())
    assert found["left"] < 1e-9
    assert found["jump"] < 1e-4


def test_coupling_cannot_be_as_large_as_the_torques_of_section_5() -> None:
    """The vibration's mean power on both rotors, undamped, at 720 phase differences."""
    alpha = np.linspace(-np.pi, np.pi, 720)
    bounds = misprints.largest_coupling(Session())["largest"]
    for case, bound, printed in zip((CASE_1, CASE_2), bounds, (3.08, 3.23), strict=True):
        free = case.replace(platform_damping=0.0, rod_damping=0.0)
        on_a_rotor = np.array([coupling_torque(free, float(one)) for one in alpha]) / 2
        assert np.max(abs(on_a_rotor)) == pytest.approx(bound, rel=1e-3)
        assert 3 * bound < printed


def test_table_1_takes_the_wrong_masses() -> None:
    for ratio, platform, rod in ((0.1, 246490000, 24402510), (7.0, 50307, 4980)):
        assert stiffness(Session(), ratio, rod=False)["mistaken"] == pytest.approx(
            platform, rel=1e-4
        )
        assert stiffness(Session(), ratio, rod=True)["mistaken"] == pytest.approx(rod, rel=1e-4)


def test_dampers_take_what_9_says_without_those_of_the_rotors() -> None:
    """The power that (11) loses beside the motors' and the bearings' is twice the corrected (9)."""
    scene, c = get_scene("rotor_pendulum"), coefficients(CASE_2)
    rates = np.array([0.2, 150.0, 140.0, 3.0])
    power = scene.powers(0.0, np.zeros(4), rates, c)
    lost = power["platform"] + power["rod"]
    assert lost == pytest.approx(-(c.damping * 0.2**2 + c.rod_damping * 3.0**2))


@pytest.mark.slow
@pytest.mark.parametrize(("sign", "phase", "speed"), [(1, -0.194, 154.65), (-1, 0.064, 153.20)])
def test_what_the_sign_of_11_makes_of_case_2(sign: int, phase: float, speed: float) -> None:
    """The orbits that the erratum tells, by direct integration until they are steady."""
    reduced, c = get_scene("rotor_pendulum").variants["reduced"], coefficients(CASE_2)
    swing = c.unbalance * c.length

    def rates(time: float, state: np.ndarray) -> np.ndarray:
        q, v = state[:4], state[4:]
        load = np.array(reduced.forces(0.0, q, v, c))
        load[3] -= (1 + sign) * swing * np.sin(q[2] - c.beta) * v[2] ** 2
        return np.concatenate([v, np.linalg.solve(np.array(reduced.mass_matrix(q, c)), load)])

    start = np.array([0.0, phase, 0.0, 0.0, 0.0, speed, speed, 0.0])
    end, turns = 12.0, 2 * np.pi / speed * 20
    times = np.linspace(end - turns, end, 2000)
    run = solve_ivp(rates, (0.0, end), start, "DOP853", times, rtol=1e-8, atol=1e-10)
    first, second = run.y[1], run.y[2]
    assert np.mean(first - second) == pytest.approx(phase, abs=1e-3)
    assert (first[-1] - first[0]) / turns == pytest.approx(speed, abs=5e-3)
    torque = float(CASE_2.motor_slope) * (50 * np.pi - speed)
    erratum = OF["equation_11_sign"].erratum
    assert erratum is not None
    for words in (f"{phase:.3f} rad", f"{speed:.2f} rad/s", f"{torque:.2f} N m"):
        assert words in erratum.effect


def test_omega_m_of_14_is_another_than_table_1s() -> None:
    """Frequency ratios by the field's electric speed are twice those of table 2."""
    mechanical = theory.ratios(CASE_2, speed=50 * np.pi)
    electric = theory.ratios(CASE_2, speed=misprints.POLES * 50 * np.pi)
    assert electric.n_x / mechanical.n_x == pytest.approx(2)
    assert float(electric.n_x) > 7 > float(mechanical.n_x)


def test_6_is_of_order_k_minus_1() -> None:
    """By the number of its roots, which are those of differences of phases."""
    chi = sp.Symbol("chi")
    for k in (2, 3, 4):
        slopes = sp.Matrix(k - 1, k - 1, lambda i, j: sp.Integer((i + 1) * (j + 2) + (i == j)))
        determinant = (slopes - chi * sp.eye(k - 1)).det()
        assert sp.degree(determinant, chi) == k - 1


def test_synphase_is_what_antiphase_leaves() -> None:
    alpha = -np.pi / 2 + 2 * np.pi * (np.arange(100) + 0.5) / 100
    antiphase = (alpha > np.pi / 2) & (alpha < 3 * np.pi / 2)
    assert np.all(antiphase ^ ((alpha > -np.pi / 2) & (alpha < np.pi / 2)))
    assert not np.any((alpha > np.pi / 2) & (alpha < np.pi / 2))
    assert -np.pi / 2 < -0.515 < np.pi / 2
