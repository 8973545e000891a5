"""The ledger of the rotor_pendulum paper: sections 2-4, the model and its theory, and figure 2."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.stats import spearmanr

from ....reference import get_scene
from ....reference.rotor_pendulum import theory
from ....reference.rotor_pendulum.cases import CASE_1, CASE_2, CASE_3
from ....reference.rotor_pendulum.equations import RotorPendulum, coefficients, operating_speed
from ....reference.rotor_pendulum.phase import coupling_harmonics, coupling_torque, wrapped
from ....reference.scene import Array
from ..ledger import CORRECTED, NOT_REPRODUCED, Finding, Row, claimed, number
from ..session import Session
from .results import (
    BETA_NAMES,
    BETAS,
    PRINTED_RATIOS,
    RANGE,
    REDUCED,
    SCENE,
    class_shares,
    find_orbit,
    from_rest,
    measured,
    phase_map,
    settled,
)

TESTS = "tests/test_rotor_pendulum.py::"
OWN_TESTS = "tests/test_rotor_pendulum_paper.py::"

IDENTITY = 1e-9
"""Relative residual below which an identity holds."""
FAILS = 1e-3
"""Relative residual from which it does not."""
SMALL = 0.1
"""Share that may be called small."""
FAR = 3.0

LATTICE = np.linspace(*RANGE, 139)
"""Values of a frequency ratio, 0.05 apart; none is 1."""

UNDAMPED = CASE_2.replace(platform_damping=0.0, rod_damping=0.0)


def lattice(beta: float = np.pi / 6) -> theory.Ratios:
    """Return both frequency ratios over the range of the figures, (139, 139)."""
    values = LATTICE + 1e-3
    return theory.Ratios(values[None], values[:, None], beta=beta)


def misprint(printed: float, corrected: float, what: str) -> Finding:
    """Judge a misprint: the printed formula fails an identity, the corrected one does not."""
    holds = corrected < IDENTITY and printed > FAILS
    reason = f"{what}: off by {printed:.2g} as printed, by {corrected:.1g} corrected"
    return Finding(CORRECTED if holds else NOT_REPRODUCED, reason)


# Section 2: model and equations


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


def equation_11(session: Session) -> Finding:
    """The inertia coupling is neglected for m << m_0."""
    worst = {
        case: float(
            np.max(abs(from_rest(session, case, REDUCED).phase - from_rest(session, case).phase))
        )
        for case in (1, 2, 3)
    }
    phases = [
        measured(find_orbit(session, CASE_2, model=model), "phase_difference")
        for model in (None, REDUCED)
    ]
    words = ", ".join(f"{gap:.1e} rad in case {case}" for case, gap in worst.items())
    return claimed(
        max(worst.values()) < 0.01 * np.pi,
        f"the phase difference from rest is off by at most {words}; of two terms of the same "
        "order one is dropped, so that energy is not conserved, but both are small here",
        reference=f"case 2 ends at {phases[0]:.5f} rad by the exact equations, "
        f"{phases[1]:.5f} rad by (11)",
    )


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


def equation_14(session: Session) -> Finding:
    """Torque of the motors."""
    slip = float(CASE_1.synchronous_speed) - 153.8
    printed, twice = (slip * motor_slope(powers) for powers in (1, 2))
    return Finding(
        NOT_REPRODUCED,
        f"V^2/ohm is a power, not a torque: at 153.8 rad/s it is {printed:.3g} W, and with one "
        f"more division by the electric speed {twice:.3g} N m, where section 5.2 prints 3.08 N m",
        reference=f"{slip * float(CASE_1.motor_slope):.3g} N m",
    )


# Section 3: coupling coefficients, figure 2


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


def equation_18(session: Session) -> Finding:
    """Two factors of (18) are nowhere defined."""
    eta = float(CASE_1.rod_mass / CASE_1.rotor_mass)
    return misprint(
        equation_18_residual(eta**2 * (1 + eta)),
        equation_18_residual(1 * (1 + eta)),
        "(17) with eta of (15) for both, against m_2/m_1 = 1 and m_3/m_1, which make it 1/sigma",
    )


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


def mu_1(session: Session) -> Finding:
    """n_x and n_phi are swapped in mu_1."""
    return misprint(
        equation_20_residual(True), equation_20_residual(False), "x of (21) in (17), at case 2"
    )


def mirror_images(session: Session) -> Finding:
    """mu_1 and mu_4 are said to be identical."""
    n = lattice()
    mu = theory.coupling_coefficients(n)
    size = np.maximum(abs(mu.mu_1), abs(mu.mu_4))
    apart = np.median(abs(mu.mu_1 - mu.mu_4) / size)
    turned = theory.coupling_coefficients(n._replace(n_x=n.n_phi, n_phi=n.n_x))
    mirrored = float(np.max(abs(turned.mu_4 - mu.mu_1) / size))
    return claimed(
        bool(apart < IDENTITY),
        "only by the misprint in mu_1; the right mu_1(n_x, n_phi) is mu_4(n_phi, n_x) (to "
        f"{mirrored:.0e}), and the median difference of the two is {apart:.0%}",
    )


def caption_errors() -> tuple[float, float]:
    """Return by how much mu_2 and mu_4 differ from mu_1 as printed: medians, relative."""
    mu = theory.coupling_coefficients(lattice(), as_printed=True)
    second, fourth = (
        float(np.median(abs(one - mu.mu_1) / abs(mu.mu_1))) for one in (mu.mu_2, mu.mu_4)
    )
    return second, fourth


def level_rod(session: Session) -> Finding:
    """No coupling of platform and rod where beta = 0."""
    mu = theory.coupling_coefficients(lattice(0.0))
    largest = float(max(np.max(abs(mu.mu_2)), np.max(abs(mu.mu_3))))
    level = CASE_2.replace(installation_angle=0.0, platform_damping=0.0, rod_damping=0.0)
    torque = float(theory.coupling_amplitude(level))
    return claimed(
        largest == 0,
        f"mu_2 and mu_3 are {largest:g}; the rotors stay coupled, by mu_1 through the "
        f"platform, by up to {torque:.2f} N m with case 2's springs",
    )


def strength(session: Session) -> Finding:
    """The larger mu_2 and mu_3, the stronger the coupling."""
    n = lattice()
    mu = theory.coupling_coefficients(n)
    torque = np.hypot(mu.mu_1 - mu.mu_3 * np.sin(n.beta), mu.mu_3 * np.cos(n.beta))
    rank = float(spearmanr(abs(mu.mu_3).ravel(), torque.ravel()).statistic)
    level = theory.coupling_coefficients(lattice(0.0))
    uncoupled = np.max(abs(level.mu_1)) > 0 and np.max(abs(level.mu_3)) == 0
    return claimed(
        rank > 0.9 and not uncoupled,
        "the torque that couples the rotors goes with |(mu_1 - mu_3 sin(beta), mu_3 cos(beta))|: "
        f"its rank correlation with mu_3 is {rank:.2f} at beta = pi/6, and at beta = 0 it acts "
        "though mu_2 and mu_3 are zero",
    )


def identity_29(session: Session) -> Finding:
    """mu_3 r_m = mu_2 sigma."""
    n = lattice()
    mu = theory.coupling_coefficients(n)
    left, right = mu.mu_3 * n.r_m, mu.mu_2 * n.sigma
    apart = float(np.max(abs(left - right) / abs(right)))
    return claimed(
        apart < IDENTITY,
        f"off by {apart:.0e} at most; so the two conditions (28) are one, and vibration passes no "
        "power on where there are no dampers",
    )


REGIONS = {
    "before": (0.1, 0.9),
    "at": (0.9, 1.1),
    "after": (1.1, 7.0),
}
"""Of a frequency ratio, as section 3 divides it."""


def typical_couplings() -> dict[str, Array]:
    """Return medians of |mu_1| ... |mu_4| where both ratios are in a region."""
    fine = theory.Ratios(*np.meshgrid(*[np.linspace(*RANGE, 1381) + 1e-4] * 2))
    mu = theory.coupling_coefficients(fine)
    found = {}
    for name, (low, high) in REGIONS.items():
        here = (fine.n_x > low) & (fine.n_x < high) & (fine.n_phi > low) & (fine.n_phi < high)
        found[name] = np.array([np.median(abs(one[here])) for one in mu])
    return found


def peaks(session: Session) -> Finding:
    """Couplings are far larger at resonance than before or after."""
    typical = typical_couplings()
    over = [typical["at"] / typical[name] for name in ("before", "after")]
    words = "; ".join(
        f"{name}: " + ", ".join(f"{value:.2g}" for value in values)
        for name, values in typical.items()
    )
    return claimed(
        bool(min(np.min(one) for one in over) > FAR),
        f"medians of |mu_1| ... |mu_4| before, at and after resonance of both: {words}; at "
        f"resonance the least of them is {min(np.min(one) for one in over):.3g} times larger, "
        f"{FAR:g} would be far; they are infinite on the curve N = 0, which passes beside n_x = 1 "
        "and n_phi = 1",
        corrected=True,
    )


def coupling_types(session: Session) -> Finding:
    """Three types by n_x and n_phi."""
    edges = (0.1, 0.9, 1.1, 7.0)
    side = RANGE[1] - RANGE[0]
    named = (edges[1] - edges[0] + edges[3] - edges[2]) / side
    before, at, after = (
        theory.coupling_amplitude(_with_ratios(ratio, ratio)) for ratio in (0.5, 1.01, 3.0)
    )
    return claimed(
        bool(at > before and at > after),
        f"a definition, which leaves {1 - named**2:.1%} of the plane without a type, the strips "
        "of resonance; the coupling torque at n_x = n_phi = 0.5, 1.01, 3 is "
        f"{before:.2g}, {at:.2g}, {after:.2g} N m",
    )


def _with_ratios(n_x: float, n_phi: float) -> RotorPendulum:
    p = CASE_2
    w = float(operating_speed(p))
    return p.replace(platform_stiffness=114 * (w / n_x) ** 2, rod_stiffness=1.08 * (w / n_phi) ** 2)


# Section 4: synchronisation and stability


def coupling_error(as_printed: bool) -> float:
    """Return by how much (34) misses the mean coupling torque, relative to its amplitude."""
    p, alpha = UNDAMPED, np.linspace(-np.pi, np.pi, 73)
    w = float(operating_speed(p))
    n = theory.ratios(p)
    scale = p.rotor_mass * (p.eccentricity * w) ** 2 * n.r_m
    torque = -scale * theory.balance(n, alpha, as_printed)
    truth = coupling_torque(p, alpha)
    return float(np.max(abs(torque - truth)) / np.max(abs(truth)))


def equation_34(session: Session) -> Finding:
    """Difference of the mean torques of the vibration."""
    found = misprint(
        coupling_error(True),
        coupling_error(False),
        "(34) against the mean torque in steady vibration, case 2 without dampers",
    )
    mean, first = coupling_harmonics(CASE_2)
    return Finding(
        found.verdict,
        f"{found.reason}. With the dampers a constant part comes in that it lacks, "
        f"{float(mean):.2f} N m beside an amplitude of {abs(complex(first)):.2f} N m in case 2",
    )


def roots(session: Session) -> Finding:
    """Balance (30) and stability (36) tell the phase difference."""
    worst, other = 0.0, -np.inf
    for beta in (*BETAS, np.pi / 2):
        n = lattice(beta)
        alpha = theory.stable_phase_difference(n)
        mu = theory.coupling_coefficients(n)
        size = np.hypot(mu.mu_1 - mu.mu_3 * np.sin(beta), mu.mu_3 * np.cos(beta))
        worst = max(worst, float(np.max(abs(theory.balance(n, alpha) / size))))
        other = max(other, float(np.max(theory.stability(n, alpha + np.pi) / size)))
    return claimed(
        worst < IDENTITY and other < 0,
        "for every n_x, n_phi and beta tried there is exactly one stable root, and the unstable "
        f"one is opposite; (30) holds to {worst:.0e} of its amplitude",
        corrected=True,
    )


def critical_point(session: Session) -> Finding:
    """The installation angle pi/2 is called critical."""
    n = PRINTED_RATIOS[3]
    alpha = float(theory.stable_phase_difference(n))
    size = abs(float(theory.stability(n, alpha)))
    around = theory.stable_phase_difference(n._replace(beta=np.pi / 2 + np.array([-1e-6, 1e-6])))
    jump = float(abs(wrapped(around[1] - around[0])))
    kinds = settled(session, [CASE_3.replace(rod_damping=0.0), CASE_3])
    return claimed(
        not (abs(theory.balance(n, alpha)) < IDENTITY * size and jump < 1e-4),
        f"(31) divides (30) by cos(beta); (30) itself has the stable root {alpha:.4f} rad there, "
        f"and the phase passes beta = pi/2 without a jump ({jump:.0e} rad). The orbit of case 3 is "
        f"{kinds[0].words} without f_phi, {kinds[1].words} with it",
    )


def equation_33(session: Session) -> Finding:
    """The arccot of (33)."""
    shares = {
        name: class_shares(phase_map(session, beta, "paper"), Ellipsis)["unstable"]
        for name, beta in zip(BETA_NAMES, BETAS, strict=True)
    }
    words = ", ".join(f"{share:.0%} at beta = {name}" for name, share in shares.items())
    return claimed(
        False,
        "arccot knows nothing of (36): with values in (0, pi), and mu_1 as printed, the root "
        f"that it gives is the unstable one on {words} of the range of table 2; atan2 of sine "
        "and cosine with the sign of N gives the stable one",
    )


def equation_35_derivatives() -> tuple[float, float]:
    """Return d(P_1 - P_1)/d alpha as printed, d(P_1 - P_2)/d alpha, by (26) at case 2 [N m]."""
    p, step = UNDAMPED, 1e-5
    ends = theory.stable_phase_difference(theory.ratios(p)) + np.array([-step, step])
    first, second = coupling_torque(p, ends) / 2, -coupling_torque(p, ends) / 2
    printed, right = ((one[1] - one[0]) / (2 * step) for one in (first - first, first - second))
    return float(printed), float(right)


def equation_35(session: Session) -> Finding:
    """A subscript of (35)."""
    printed, right = equation_35_derivatives()
    amplitude = float(theory.coupling_amplitude(UNDAMPED))
    return Finding(
        CORRECTED if printed == 0 and abs(right / amplitude + 1) < 1e-6 else NOT_REPRODUCED,
        f"P_1 - P_1 has the slope {printed:g}; that of P_1 - P_2 at the stable root of case 2 is "
        f"{right:.4f} N m, minus the amplitude of (34)",
    )


def springs_decide(session: Session) -> Finding:
    """Both springs are said to be key to the phase difference."""
    n = lattice()
    alpha = theory.stable_phase_difference(n)
    doubled = np.exp(2j * alpha)
    by_x = float(np.max(abs(np.angle(doubled / doubled[:, :1]))) / 2)
    by_phi = float(np.ptp(np.unwrap(np.angle(doubled[:, 0])) / 2))
    flips = float(np.mean(abs(wrapped(alpha - alpha[:, :1])) > np.pi / 2))
    return claimed(
        by_phi > SMALL and flips > SMALL,
        f"at beta = pi/6 k_phi moves it by {by_phi:.2f} rad; k_x only decides between two opposite "
        f"values ({flips:.0%} of the plane has the other one than n_x = 0.1), and moves it by "
        f"{by_x:.0e} rad otherwise, as n_x cancels in (30) but for the sign of N",
        corrected=True,
    )


# Tables 1, 2


def beyond_table(mass: float, inertia: float, speed: float, ratio: float) -> tuple[float, float]:
    """Return k_x [N/m] and k_phi [N m/rad] that belong to a frequency ratio."""
    return mass * (speed / ratio) ** 2, inertia * (speed / ratio) ** 2


PRINTED_SPEED = 157.0
"""50 pi, rounded, from which table 1's ranges follow [rad/s]."""


def stiffness_range(printed: str, ratio: float, rod: bool) -> Finding:
    """Compare an end of table 1's ranges of stiffness with its frequency ratio."""
    c = coefficients(CASE_1)
    mass, inertia = float(c.mass), float(c.end_mass * c.length**2)
    wrong_inertia = float((c.platform + c.rod) * c.length**2)
    right = beyond_table(mass, inertia, PRINTED_SPEED, ratio)[rod]
    wrong = beyond_table(float(c.platform), wrong_inertia, PRINTED_SPEED, ratio)[rod]
    mistake = (
        f"(m_0 + m_3) l^2 = {wrong_inertia:.4g} kg m^2 for (m + m_3) l^2 = {inertia:.4g}"
        if rod
        else f"m_0 = {float(c.platform):g} kg for M = {mass:g} kg"
    )
    because = f"{mistake} gives {wrong:.9g} at n = {ratio:g} and {PRINTED_SPEED:g} rad/s"
    return number(printed, right, "N m/rad" if rod else "N/m", because=because, digits=6)


def dimensionless(printed: str, value: Any) -> Finding:
    """Compare an entry of table 2."""
    return number(printed, float(value), because=f"{float(value):.4g} before rounding")


N = theory.ratios(CASE_1)

ROWS: tuple[Row, ...] = (
    Row(
        "equation_11_sign",
        "misprint",
        "equation (11)",
        "Sign before phi_2'^2 in the fourth line.",
        lambda session: misprint(
            equation_11_residual(1),
            equation_11_residual(-1),
            "fourth line with the accelerations of Lagrange's equations at phi_3 = 0",
        ),
        printed="+ phi_2'^2 sin(phi_2 - beta)",
        test=TESTS + "test_the_reduced_equations_are_the_printed_ones_but_for_a_sign",
    ),
    Row(
        "equation_11_reduction",
        "claim",
        "2.2",
        "With light rotors the inertia coupling by asymmetry may be neglected, which gives (11).",
        equation_11,
        slow=True,
    ),
    Row(
        "equation_14",
        "misprint",
        "equation (14)",
        "Torque of an induction motor near its working speed.",
        equation_14,
        printed="n_p L_m^2 U^2 / (L_s^2 omega_m R_r) (omega_s - n_p omega_m)",
        test=OWN_TESTS + "test_14_is_no_torque",
    ),
    Row(
        "kx_high",
        "number",
        "table 1",
        "Platform stiffness at n_x = 0.1.",
        lambda session: stiffness_range("246490000", 0.1, rod=False),
        printed="246490000 N/m",
    ),
    Row(
        "kx_low",
        "number",
        "table 1",
        "Platform stiffness at n_x = 7.",
        lambda session: stiffness_range("50307", 7.0, rod=False),
        printed="50307 N/m",
    ),
    Row(
        "kx_resonance",
        "number",
        "5.1",
        "Platform stiffness at n_x = 1.",
        lambda session: stiffness_range("2.46e6", 1.0, rod=False),
        printed="2.46e6 N/m",
    ),
    Row(
        "kphi_high",
        "number",
        "table 1",
        "Torsional stiffness at n_phi = 0.1.",
        lambda session: stiffness_range("24402510", 0.1, rod=True),
        printed="24402510 N m/rad",
    ),
    Row(
        "kphi_low",
        "number",
        "table 1",
        "Torsional stiffness at n_phi = 7.",
        lambda session: stiffness_range("4980", 7.0, rod=True),
        printed="4980 N m/rad",
    ),
    Row(
        "eta",
        "number",
        "table 2",
        "eta = m_3/m.",
        lambda session: dimensionless("5", CASE_1.rod_mass / CASE_1.rotor_mass),
        printed="5",
    ),
    Row(
        "sigma",
        "number",
        "table 2",
        "sigma = 1/(1 + eta).",
        lambda session: dimensionless("0.17", N.sigma),
        printed="0.17",
    ),
    Row(
        "r_m",
        "number",
        "table 2",
        "r_m = m/M.",
        lambda session: dimensionless("0.02", N.r_m),
        printed="0.02",
    ),
    Row(
        "equation_18",
        "misprint",
        "equation (18)",
        "Laplace transform of the platform's motion, with factors left over.",
        equation_18,
        printed="eta_21 (1 + eta_31)",
        test=OWN_TESTS + "test_18_has_factors_that_are_not_eta",
    ),
    Row(
        "mu_1",
        "misprint",
        "equations (20), (22)",
        "n_x and n_phi in mu_1, the response of the platform to the first rotor.",
        mu_1,
        printed="sigma (n_x^2 - 1) n_phi^2 / N",
        test=TESTS + "test_coupling_coefficients_solve_17_and_the_printed_ones_do_not",
    ),
    Row(
        "mu_1_is_mu_4",
        "claim",
        "3",
        "mu_1 and mu_4 are the same expression.",
        mirror_images,
    ),
    Row(
        "figure_2_caption",
        "misprint",
        "figure 2",
        "Which coefficients the first panel shows.",
        lambda session: misprint(
            *caption_errors(), "relative difference from mu_1 as printed, of mu_2 and of mu_4"
        ),
        printed="mu_1 and mu_2",
        test=OWN_TESTS + "test_the_first_panel_of_figure_2_is_mu_4",
    ),
    Row(
        "level_rod_coupling",
        "claim",
        "3",
        "Without installation angle the coupling is absent.",
        level_rod,
    ),
    Row(
        "coupling_strength",
        "claim",
        "3",
        "The larger mu_2 and mu_3, the stronger the system is coupled.",
        strength,
    ),
    Row(
        "resonance_peaks",
        "claim",
        "3, figure 2",
        "Coefficients are small before and after resonance, far larger within 0.9-1.1.",
        peaks,
    ),
    Row(
        "coupling_types",
        "claim",
        "3",
        "Frequency ratios divide systems into three types of coupling.",
        coupling_types,
    ),
    Row(
        "equation_34",
        "claim",
        "equations (26), (34)",
        "Mean torques of the vibration on the rotors.",
        equation_34,
    ),
    Row(
        "identity_29",
        "claim",
        "equations (28), (29)",
        "The balance conditions of the two rotors are one.",
        identity_29,
    ),
    Row(
        "balance_and_stability",
        "claim",
        "equations (30), (36)",
        "A synchronous motion needs a phase difference that balances and is stable.",
        roots,
    ),
    Row(
        "critical_point",
        "misprint",
        "equations (31), (32)",
        "beta = pi/2 as a point at which no phase difference exists.",
        critical_point,
        printed="beta = k pi + pi/2",
        test=TESTS + "test_the_phase_does_not_depend_on_how_the_angle_is_reached",
    ),
    Row(
        "equation_33_branch",
        "misprint",
        "equation (33)",
        "Phase difference as an inverse cotangent.",
        equation_33,
        printed="alpha = arccot(...)",
        test=TESTS + "test_the_papers_phases_need_the_corrected_coefficient",
    ),
    Row(
        "equation_35",
        "misprint",
        "equation (35)",
        "Of which difference the derivative is taken.",
        equation_35,
        printed="d(P_1 - P_1)/d alpha",
        test=OWN_TESTS + "test_35_as_printed_is_zero",
    ),
    Row(
        "springs_decide",
        "claim",
        "4",
        "Both springs are key to the phase difference.",
        springs_decide,
    ),
)
