"""The misprints of the rotor_pendulum paper, proved by what formulas give as printed and right."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.papers.rotor_pendulum.derivation import UNDAMPED, lattice, stiffness
from mbcheck.comparisons.papers.rotor_pendulum.results import (
    BETAS,
    PRINTED_RATIOS,
    class_shares,
    phase_map,
    settled,
)
from mbcheck.comparisons.papers.rotor_pendulum.rows import ROWS
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference import get_scene
from mbcheck.reference.rotor_pendulum import theory
from mbcheck.reference.rotor_pendulum.cases import CASE_1, CASE_2, CASE_3
from mbcheck.reference.rotor_pendulum.equations import RotorPendulum, coefficients
from mbcheck.reference.rotor_pendulum.phase import coupling_torque, wrapped

REASONS = {row.name: row.reason for row in ROWS}
SCENE = "rotor_pendulum"


def equation_11_residual(sign: int) -> float:
    """Return the residual of line 4 of (11) where it must be exact, with phi_3 = 0.

    Relative to its largest term; ``sign`` stands before phi_2'^2, printed +1.
    """
    scene, p = get_scene(SCENE), CASE_2
    c = coefficients(p)
    q, v = np.array([1e-3, 0.4, 1.1, 0.0]), np.array([0.1, 150.0, 155.0, 2.0])
    a = scene.accelerations(0.0, q, v, c)
    terms = (
        c.end_mass * c.length**2 * a[3],
        c.rod_damping * v[3],
        -c.end_mass * c.length * a[0] * np.sin(c.beta),
        c.unbalance * c.length * a[2] * np.cos(q[2] - c.beta),
        sign * c.unbalance * c.length * v[2] ** 2 * np.sin(q[2] - c.beta),
    )
    return float(abs(sum(terms)) / max(map(abs, terms)))


def equation_18_residual(factor: float) -> float:
    """Return the residual of (18) in the first line of (17), relative to its largest term.

    ``factor`` stands before r_m s^2 F_2 sin(beta), printed eta_21 (1 + eta_31).
    """
    s, w_x, w_phi, w, r_m, beta, length = 0.7j, 1.3, 0.8, 1.0, 0.02, 0.6, 0.3
    sigma, f_1, f_2 = 1 / 6, 0.4 + 0.1j, -0.2 + 0.3j
    g = (s**2 + w_x**2) * (s**2 + w_phi**2) - r_m * s**4 * np.sin(beta) ** 2 / sigma
    x = (s**2 + w_phi**2) * w**2 * f_1 - factor * r_m * s**2 * w**2 * f_2 * np.sin(beta)
    phi = s**2 * w**2 * f_1 * np.sin(beta) - (s**2 + w_x**2) * w**2 * f_2
    terms = (
        (s**2 + w_x**2) * length * x / g,
        -(w**2) * length * f_1,
        -r_m * length * s**2 * np.sin(beta) / sigma * phi / g,
    )
    return float(abs(sum(terms)) / max(map(abs, terms)))


def equation_20_residual(as_printed: bool) -> float:
    """Return by how much (20)-(22) miss (17) in steady vibration, relative to x."""
    n = PRINTED_RATIOS[2]
    sin, phi_1, phi_2 = np.sin(n.beta), 0.9, 0.2
    wave = np.array([np.cos(phi_1) - np.cos(phi_2), np.sin(phi_2 - n.beta)])
    steady = np.linalg.solve(
        [
            [1 / n.n_x**2 - 1, n.r_m * sin / n.sigma],
            [sin, 1 / n.n_phi**2 - 1],
        ],
        [-n.r_m * wave[0], n.sigma * wave[1]],
    )
    mu = theory.coupling_coefficients(n, as_printed)
    x = mu.mu_1 * n.r_m * wave[0] - mu.mu_2 * n.sigma * wave[1]
    return float(abs(x / steady[0] - 1))


def caption_errors() -> tuple[float, float]:
    """Return by how much mu_2 and mu_4 differ from mu_1 as printed: medians, relative."""
    mu = theory.coupling_coefficients(lattice(), as_printed=True)
    second, fourth = (
        float(np.median(abs(one - mu.mu_1) / abs(mu.mu_1))) for one in (mu.mu_2, mu.mu_4)
    )
    return second, fourth


def caption_error(as_printed: bool) -> float:
    """Error of the first panel's second coefficient: mu_2 in the caption, mu_4 in truth."""
    return caption_errors()[0 if as_printed else 1]


def residual_11(as_printed: bool) -> float:
    return equation_11_residual(1 if as_printed else -1)


ETA = float(CASE_1.rod_mass / CASE_1.rotor_mass)


def residual_18(as_printed: bool) -> float:
    """Error with eta of (15) for both factors, and with m_2/m_1 = 1 and m_3/m_1."""
    return equation_18_residual((ETA**2 if as_printed else 1) * (1 + ETA))


@pytest.mark.parametrize(
    ("name", "residual"),
    [
        ("equation_11_sign", residual_11),
        ("equation_18", residual_18),
        ("mu_1", equation_20_residual),
        ("figure_2_caption", caption_error),
    ],
)
def test_printed_formula_misses_an_identity_and_the_corrected_one_holds(
    name: str, residual: Any
) -> None:
    printed, corrected = residual(True), residual(False)
    assert corrected < 1e-9 < 1e-3 < printed
    assert f"off by {printed:.2g} as printed" in REASONS[name]


MUTUAL, STATOR, RESISTANCE, VOLTAGE, POLES = 0.13, 0.1, 0.54, 220.0, 2
"""Table 1's induction motor [H, H, ohm, V, 1]."""


def motor_slope(electric_powers: int, p: RotorPendulum = CASE_1) -> float:
    """Return the slope of (14) over the mechanical speed [N m s/rad, if it is one].

    (14) divides by the electric speed once; a torque needs it twice. With the electric
    synchronous speed omega_s = n_p times the mechanical one, the slip is omega_s - n_p omega_m.
    """
    electric = POLES * float(p.synchronous_speed)
    scale = POLES * MUTUAL**2 * VOLTAGE**2 / (STATOR**2 * RESISTANCE)
    return float(POLES * scale / electric**electric_powers)


def test_14_is_no_torque() -> None:
    """In V^2/ohm, a power; the torque is larger than section 5.2's by the electric speed."""
    ratio = motor_slope(1) / motor_slope(2)
    assert ratio == pytest.approx(100 * np.pi)  # an angular speed: the dimension that is missing
    slip = 50 * np.pi - 153.8
    assert motor_slope(1) * slip > 1000 * 3.08
    assert motor_slope(2) * slip > 5 * 3.08
    assert f"it is {motor_slope(1) * slip:.3g} W" in REASONS["equation_14"]
    assert f"speed {motor_slope(2) * slip:.3g} N m" in REASONS["equation_14"]


def test_18_has_factors_that_are_not_eta() -> None:
    assert equation_18_residual(6.0) < 1e-14  # eta_21 = 1, eta_31 = 5
    for wrong in (25 * 6.0, 5 * 6.0, 5.0, 1.0):
        assert equation_18_residual(wrong) > 1e-3


def test_the_first_panel_of_figure_2_is_mu_4() -> None:
    second, fourth = caption_errors()
    assert fourth == 0  # as printed, mu_1 and mu_4 are one expression
    assert second > 0.5


def test_the_phase_passes_the_critical_point() -> None:
    """(30) has a stable root at beta = pi/2, and none of the phases beside it is far."""
    n = PRINTED_RATIOS[3]
    alpha = float(theory.stable_phase_difference(n))
    assert abs(theory.balance(n, alpha)) < 1e-9 * abs(float(theory.stability(n, alpha)))
    around = theory.stable_phase_difference(n._replace(beta=np.pi / 2 + np.array([-1e-6, 1e-6])))
    jump = float(abs(wrapped(around[1] - around[0])))
    assert jump < 1e-4
    free, damped = settled(Session(), [CASE_3.replace(rod_damping=0.0), CASE_3])
    words = (
        f"root {alpha:.4f} rad there, and the phase passes beta = pi/2 without a jump "
        f"({jump:.0e} rad). The orbit of case 3 is {free.words} without f_phi, {damped.words} "
        "with it"
    )
    assert words in REASONS["critical_point"]


def test_33_gives_unstable_roots() -> None:
    """Nearly everywhere: arccot knows nothing of (36)."""
    for name, beta in BETAS.items():
        share = class_shares(phase_map(Session(), beta, "paper"), Ellipsis)["unstable"]
        assert f"{share:.0%} at beta = {name}" in REASONS["equation_33_branch"]


def equation_35_derivatives() -> tuple[float, float]:
    """Return d(P_1 - P_1)/d alpha as printed, d(P_1 - P_2)/d alpha, by (26) at case 2 [N m]."""
    p, step = UNDAMPED, 1e-5
    ends = theory.stable_phase_difference(theory.ratios(p)) + np.array([-step, step])
    first, second = coupling_torque(p, ends) / 2, -coupling_torque(p, ends) / 2
    printed, right = ((one[1] - one[0]) / (2 * step) for one in (first - first, first - second))
    return float(printed), float(right)


def test_35_as_printed_is_zero() -> None:
    printed, right = equation_35_derivatives()
    assert printed == 0
    assert right == pytest.approx(-float(theory.coupling_amplitude(UNDAMPED)), rel=1e-6)
    assert f"case 2 is {right:.4f} N m" in REASONS["equation_35"]


def test_the_phase_of_case_1_has_lost_its_sign() -> None:
    n = PRINTED_RATIOS[1]
    size = abs(float(theory.stability(n, theory.stable_phase_difference(n))))
    wrong, right = (abs(float(theory.balance(n, alpha))) / size for alpha in (3.013, -3.013))
    assert right < 1e-3 < 0.1 < wrong
    assert f"{wrong:.2g} of its amplitude at +3.013 rad, by {right:.1g}" in REASONS["phase_sign"]


def test_table_1_takes_the_wrong_masses() -> None:
    for ratio, platform, rod in ((0.1, 246490000, 24402510), (7.0, 50307, 4980)):
        assert stiffness(Session(), ratio, rod=False)["mistaken"] == pytest.approx(
            platform, rel=1e-4
        )
        assert stiffness(Session(), ratio, rod=True)["mistaken"] == pytest.approx(rod, rel=1e-4)
