"""Misprints of the rotor_pendulum paper: what a formula gives as printed, and put right."""

from __future__ import annotations

from functools import partial

import numpy as np

from ....reference.rotor_pendulum import CASE_1, CASE_2, CASE_3, theory
from ....reference.rotor_pendulum.equations import RotorPendulum
from ....reference.rotor_pendulum.phase import coupling_torque, wrapped
from ..ledger import (
    CORRECTED,
    NOT_REPRODUCED,
    Erratum,
    LedgerRow,
    Numbers,
    above,
    below,
    corrected,
    equal,
    holds,
    misprint,
)
from ..session import Session
from .derivation import UNDAMPED, lattice, lines_of_11
from .results import PRINTED_RATIOS, settled
from .vibration import IDENTITY, Residual, equation_20

TESTS = "tests/reference/rotor_pendulum/test_equations.py::"
OWN_TESTS = "tests/comparisons/papers/rotor_pendulum/test_misprints.py::"

FAILS = 1e-3
"""Relative residual from which it does not."""


def residuals(session: Session, of: Residual) -> Numbers:
    """Return what a formula leaves of an identity, as printed and corrected."""
    return {"as_printed": of(True), "corrected": of(False)}


MISSES = corrected(above("as_printed", FAILS), below("corrected", IDENTITY))
"""As printed the formula misses an identity that it satisfies when corrected."""


# What formulas leave over


def equation_11(as_printed: bool) -> float:
    """Return the residual of line 4 of (11)."""
    return float(lines_of_11(1 if as_printed else -1)[3])


def figure_2_caption(as_printed: bool) -> float:
    """Return how far the first panel's second coefficient is from mu_1 as printed.

    Median, relative: mu_2 by the caption, mu_4 put right.
    """
    mu = theory.coupling_coefficients(lattice(), as_printed=True)
    second = mu.mu_2 if as_printed else mu.mu_4
    return float(np.median(abs(second - mu.mu_1) / abs(mu.mu_1)))


def equation_35(session: Session) -> Numbers:
    """Return d(P_1 - P_1)/d alpha as printed and d(P_1 - P_2)/d alpha at case 2 [N m].

    By (26), at the stable root; and minus the amplitude of (34), which the second should be.
    """
    p, step = UNDAMPED, 1e-5
    ends = theory.stable_phase_difference(theory.ratios(p)) + np.array([-step, step])
    first, second = coupling_torque(p, ends) / 2, -coupling_torque(p, ends) / 2
    printed, right = ((one[1] - one[0]) / (2 * step) for one in (first - first, first - second))
    amplitude = float(theory.coupling_amplitude(p))
    return {
        "as_printed": float(printed),
        "right": float(right),
        "error": abs(right + amplitude) / amplitude,
    }


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


def equation_14(session: Session) -> Numbers:
    """Return what (14) gives at 153.8 rad/s: a power [W], with omega_m^2 a torque [N m].

    And how far the torque is from the 3.08 N m of section 5.2, relative to them.
    """
    slip = 50 * np.pi - 153.8
    power, torque = motor_slope(1) * slip, motor_slope(2) * slip
    return {"power": power, "torque": torque, "off": abs(torque / 3.08 - 1)}


def critical_point(session: Session) -> Numbers:
    """Return the stable root of (30) at beta = pi/2 [rad], and how far the phase jumps there.

    And the orbits of case 3 without and with the rod's damper, in words.
    """
    n = PRINTED_RATIOS[3]
    alpha = float(theory.stable_phase_difference(n))
    around = theory.stable_phase_difference(n._replace(beta=np.pi / 2 + np.array([-1e-6, 1e-6])))
    free, damped = settled(session, [CASE_3.replace(rod_damping=0.0), CASE_3])
    return {
        "root": alpha,
        "left": float(abs(theory.balance(n, alpha) / theory.stability(n, alpha))),
        "jump": float(abs(wrapped(around[1] - around[0]))),
        "free": free.words,
        "damped": damped.words,
    }


def largest_coupling(session: Session) -> Numbers:
    """Return the largest mean torque (26) of the vibration on a rotor in cases 1, 2 [N m].

    Over all phase differences; and the larger of its shares of the torques of section 5.2.
    """
    largest = [float(theory.coupling_amplitude(case)) / 2 for case in (CASE_1, CASE_2)]
    return {"largest": largest, "share": max(np.divide(largest, (3.08, 3.23)))}


def sign_of_case_1(session: Session) -> Numbers:
    """Return what (30) leaves at the phase that is printed, and at its negative, by amplitude."""
    n = PRINTED_RATIOS[1]
    size = abs(float(theory.stability(n, theory.stable_phase_difference(n))))
    printed, right = (abs(float(theory.balance(n, a))) / size for a in (3.013, -3.013))
    return {"as_printed": printed, "corrected": right}


def units(session: Session) -> Numbers:
    """Return the units that (8) and (11) ask of the torsion spring and of a motor's torque."""
    spring, slope = map(RotorPendulum.unit_of, ("rod_stiffness", "motor_slope"))
    return {"spring": spring, "torque": slope.replace(" s/rad", "")}


# The rows

OFF = "off by {as_printed:.2g} as printed, by {corrected:.1g} corrected"

MISPRINTS: tuple[LedgerRow, ...] = (
    misprint(
        "equation_11_sign", "equation (11)", "Sign before phi_2'^2 in the fourth line.", CORRECTED,
        "fourth line with the accelerations of Lagrange's equations at phi_3 = 0: " + OFF,
        partial(residuals, of=equation_11), judgement=MISSES,
        printed="+ phi_2'^2 sin(phi_2 - beta)",
        erratum=Erratum(
            TESTS + "test_the_reduced_equations_are_the_printed_ones_but_for_a_sign",
            "- m r l [phi_2'' cos(phi_2 - beta) - phi_2'^2 sin(phi_2 - beta)]",
            "it is the derivative of the kinetic energy (7); (12) has the sign right",
            "none on the theory, which starts from (12). Section 5.2 integrates (11): "
            "as printed it makes case 2's orbit -0.194 rad at 154.65 rad/s with 2.28 N m, where "
            "the right sign makes 0.064 rad, 153.20 rad/s and 3.65 N m and the paper has -0.515 "
            "rad, 153.5 rad/s, 3.23 N m, and gives case 3 an orbit at -0.58 rad, where the paper "
            "has none: the print alone is probably at fault. Case 1's rod would swing by 7.3e-4 "
            "rad",
            "a minus may have been lost",
        ),
    ),
    misprint(
        "equation_14", "equation (14)", "The slope of the motor's torque over its speed.",
        NOT_REPRODUCED,
        "as printed V^2/ohm, a power: {power:.3g} W at 153.8 rad/s. By the corrected formula it is "
        "{torque:.3g} N m, where section 5.2 prints 3.08 N m. An error of reasoning, it seems, and "
        "not of print: omega_m stands once for the rotor's speed, and once for the field's",
        equation_14, reference="{torque:.3g} N m", judgement=corrected(below("off", 0.01)),
        printed="n_p L_m^2 U^2 / (L_s^2 omega_m R_r) (omega_s - n_p omega_m)",
        erratum=Erratum(
            OWN_TESTS + "test_14_is_no_torque",
            "n_p L_m^2 U^2 (omega_s - n_p omega_m) / (L_s^2 omega_s^2 R_r), with the field's "
            "electric speed omega_s (314.16 rad/s with 50 Hz, our choice), and omega_m the rotor's",
            "a torque is a power over a speed, and the flux is the voltage over the field's speed, "
            "to the square",
            "neither form gives section 5.2's torques with the entries of table 1, so that the "
            "motor is known from these torques alone",
            "an exponent, or an index, may have been lost",
        ),
    ),
    misprint(
        "mu_1", "equations (20), (22)",
        "In mu_1, the response of the platform to the first rotor, n_x and n_phi are swapped.",
        CORRECTED, "x of (21) in (16), at case 2, over its largest value: " + OFF,
        partial(residuals, of=equation_20), judgement=MISSES,
        printed="sigma (n_x^2 - 1) n_phi^2 / N",
        erratum=Erratum(
            TESTS + "test_coupling_coefficients_solve_17_and_the_printed_ones_do_not",
            "mu_1 = sigma n_x^2 (n_phi^2 - 1) / N; in (20) sigma l (1 - n_phi^2) n_x^2 f_1(t)",
            "it is the solution of (17), the second line of which has omega_phi",
            "of print only where it can be told: by case 2's phase, which comes by the corrected "
            "one. Section 3 calls mu_1 and mu_4 identical because of it",
        ),
    ),
    misprint(
        "figure_2_caption", "figure 2", "The caption of the first panel names mu_1 and mu_2.",
        CORRECTED,
        "relative difference from mu_1 as printed, of mu_2 and of mu_4: " + OFF,
        partial(residuals, of=figure_2_caption), judgement=MISSES,
        printed="mu_1 and mu_2",
        erratum=Erratum(
            OWN_TESTS + "test_the_first_panel_of_figure_2_is_mu_4",
            "mu_1 and mu_4",
            "mu_2 has a panel of its own, mu_4 has none, and section 3 calls mu_1 and mu_4 one",
            "none",
        ),
    ),
    misprint(
        "critical_point", "equations (31), (32)",
        "beta = pi/2 is taken for a point without a phase difference, since (31) divides by "
        "cos(beta).",
        NOT_REPRODUCED,
        "(30) itself has the stable root {root:.4f} rad there, and the phase passes beta = pi/2 "
        "without a jump ({jump:.0e} rad). The orbit of case 3 is {free} without f_phi, {damped} "
        "with it",
        critical_point, judgement=holds(above("jump", 0.1)),
        printed="beta = k pi + pi/2", slow=True,
        erratum=Erratum(
            TESTS + "test_the_phase_does_not_depend_on_how_the_angle_is_reached",
            "mu_3 cos(beta) cos(alpha) = (mu_3 sin(beta) - mu_1) sin(alpha)",
            "an error of reasoning, not of print: where the right side of (31) is infinite, "
            "sin(alpha) = 0 solves (30)",
            "case 3 does lose synchronism, by the damper of the rod, which (30) leaves out",
        ),
    ),
    misprint(
        "equation_35", "equation (35)", "The difference under the derivative is P_1 - P_1.",
        CORRECTED,
        "P_1 - P_1 has the slope {as_printed:g}; that of P_1 - P_2 at the stable root of case 2 "
        "is {right:.4f} N m, minus the amplitude of (34)",
        equation_35, judgement=corrected(below("error", 1e-6)),
        printed="d(P_1 - P_1)/d alpha",
        erratum=Erratum(
            OWN_TESTS + "test_35_as_printed_is_zero",
            "d(P_1 - P_2)/d alpha_1 = d(P_1 - P_2)/d alpha",
            "it is (6) for two rotors, and what stands to the right of it",
            "none",
            "an index may have been read wrongly",
        ),
    ),
    misprint(
        "phase_sign", "5.2, case 1", "The theoretical phase difference has no sign.", CORRECTED,
        "(30) is off by {as_printed:.2g} of its amplitude at +3.013 rad, by {corrected:.1g} at "
        "-3.013 rad",
        sign_of_case_1, judgement=corrected(above("as_printed", 0.1), below("corrected", 1e-3)),
        printed="3.013 rad",
        erratum=Erratum(
            TESTS + "test_the_papers_phases_need_the_corrected_coefficient",
            "-3.013 rad (or 3.270 rad, in the range that section 5.1 gives for antiphase)",
            "the root of (30) that satisfies (36)",
            "none on the kind of synchronism; the simulation's 3.10 rad is compared by modulus",
            "a minus may have been lost",
        ),
    ),
    misprint(
        "units", "2.2, table 1", "Units of the torsion spring and of the motors' torque.",
        CORRECTED,
        "(8) is an energy with k_phi in {spring}, and (11) is of torques with M_e in {torque}",
        units, judgement=corrected(equal("spring", "N m/rad"), equal("torque", "N m")),
        printed="k_phi [N/rad], M_e [N/m]",
        erratum=Erratum(
            OWN_TESTS + "test_units_of_spring_and_torque",
            "k_phi [N m/rad], M_e [N m]",
            "k_phi phi_3^2 is an energy, M_e a moment",
            "none",
        ),
    ),
    misprint(
        "dampers_of_9", "equation (9)",
        "The dissipation has f_1, f_2, f_3; (11) and table 1 have the last alone, as f_phi.",
        CORRECTED,
        "the bearings of the rotors are R_e1 and R_e2 in (10) and (11), of which no number is "
        "given; in D they would be counted twice",
        printed="f_1, f_2, f_3",
        erratum=Erratum(
            OWN_TESTS + "test_dampers_take_what_9_says_without_those_of_the_rotors",
            "D = (f_x x'^2 + f_phi phi_3'^2)/2",
            "(11) has no term in f_1 or f_2, and f_phi phi_3' where (9) gives f_3 phi_3'",
            "none on equations; the friction of the bearings is known from section 5.2 alone",
        ),
    ),
    misprint(
        "order_of_6", "2.1, (6)", "(6) is called an equation of the k-th order.", CORRECTED,
        "its determinant has k - 1 rows, as the phases count but for their differences: for two "
        "rotors it is (35), of the first order",
        printed="the kth order algebraic equation",
        erratum=Erratum(
            OWN_TESTS + "test_6_is_of_order_k_minus_1",
            "of the (k - 1)-th order",
            "a common turn of all rotors changes nothing",
            "none: (35) is of the first order",
        ),
    ),
    misprint(
        "names_of_torques", "5.2, figures 4(b) to 6(b)",
        "The torques of the motors are called coupling torques.", CORRECTED,
        "the vibration's mean torque on a rotor, (26), is 0 in synchronous motion by (30), and at "
        "no phase difference more than {largest:.2f} N m in cases 1 and 2; 3.08 and 3.23 N m are "
        "what the bearings take",
        largest_coupling, judgement=corrected(below("share", 1.0)),
        printed="coupling torques",
        erratum=Erratum(
            OWN_TESTS + "test_coupling_cannot_be_as_large_as_the_torques_of_section_5",
            "torques of the motors",
            "(30) leaves no torque of the vibration over; the captions of figures 4 (b) to 6 (b) "
            "have torques of the two rotors",
            "of words, but for case 3, where coupling torques are called absent, see "
            "case_3_no_coupling",
        ),
    ),
    misprint(
        "rotor_2_twice", "5.2, case 2",
        "The speed of rotor 2 is said to fluctuate more than that of rotor 2.", CORRECTED,
        "rotor 1 is meant, on the platform: see case_2_fluctuation",
        printed="stronger than rotor 2",
        erratum=Erratum(
            "tests/comparisons/papers/rotor_pendulum/test_measures.py"
            "::test_rotor_on_the_rod_fluctuates_more",
            "stronger than that of rotor 1",
            "there are two rotors",
            "none",
        ),
    ),
    misprint(
        "equation_numbers", "2.1, 4", "Three references to equations.", CORRECTED,
        "(24) is (21) with (23) in it, while (19) are the frequency ratios; the solution that is "
        "called fundamental in 2.1 is (3), while (4) are the conditions on it;  the "
        "second formula with mu = 0 is one of (1), not of (2)",
        printed="(19), (4), (2)",
        erratum=Erratum(
            TESTS + "test_coupling_coefficients_solve_17_and_the_printed_ones_do_not",
            "(21), (3), (1)",
            "as the sentences beside them tell",
            "none",
        ),
    ),
    misprint(
        "omega_m", "(14), (19), (26), table 1",
        "omega_m is the field's electric speed below (14), and the rotors' speed elsewhere.",
        CORRECTED,
        "with n_p = 2 the field's electric speed is twice its mechanical one, of which 157 rad/s "
        "is table 1's largest: 314.16 rad/s with 50 Hz, our choice, as no frequency is printed. "
        "The rotors' speed is omega in (3), the first line of (26), (34) and (35)",
        printed="omega_m",
        erratum=Erratum(
            OWN_TESTS + "test_omega_m_of_14_is_another_than_table_1s",
            "omega_s, electric, in (14); omega_m = omega, the rotors' speed, elsewhere",
            "frequency ratios by (19) with 314.16 rad/s would be twice those of table 2",
            "none, but on (14), see there",
        ),
    ),
    misprint(
        "synphase_interval", "5.1", "The interval of synphase motion is (pi/2, pi/2).", CORRECTED,
        "an empty interval; case 2's -0.515 rad, called synphase, is in (-pi/2, pi/2), and so is "
        "all that antiphase, (pi/2, 3 pi/2), leaves of a turn",
        printed="(pi/2, pi/2)",
        erratum=Erratum(
            OWN_TESTS + "test_synphase_is_what_antiphase_leaves",
            "(-pi/2, pi/2)",
            "the two kinds share a turn",
            "none: section 5.2 goes by the right one",
            "almost surely at fault: in both intervals of this sentence it has lost the sign "
            "'element of' as well",
        ),
    ),
)  # fmt: skip
