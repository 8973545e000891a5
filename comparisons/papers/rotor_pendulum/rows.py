"""The ledger of the rotor_pendulum paper, and its figures; here sections 2-5.1 and 6.

P. Fang, Y. Hou, Y. Nan, L. Yu, Journal of Vibroengineering 17(5), 2015.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ....reference.rotor_pendulum import theory
from ....reference.rotor_pendulum.cases import CASE_1, CASE_2, CASE_3
from ....reference.rotor_pendulum.equations import RotorPendulum
from ....reference.rotor_pendulum.phase import coupling_torque, wrapped
from ..ledger import (
    CORRECTED,
    DEPENDS,
    ITS_RUN,
    NOT_REPRODUCED,
    NOT_TESTABLE,
    OPEN,
    PRINTED,
    REPRODUCED,
    ROUNDS,
    Cause,
    Condition,
    Erratum,
    LedgerRow,
    Numbers,
    above,
    below,
    corrected,
    depends,
    equal,
    holds,
    misprint,
    number,
    statement,
)
from ..session import Session
from . import cases, derivation, regions
from .cases import LARGEST, WAVE
from .derivation import UNDAMPED, lattice, lines_of_11
from .figures import FIGURES as FIGURES
from .readings import READINGS
from .regions import AFTER, BEFORE, SMALL_PARAMETER
from .results import BETAS, HORIZONS, PRINTED_RATIOS, settled
from .vibration import IDENTITIES, IDENTITY, VIBRATION

TESTS = "tests/reference/rotor_pendulum/test_equations.py::"
OWN_TESTS = "tests/comparisons/papers/rotor_pendulum/test_misprints.py::"

FAILS = 1e-3
"""Relative residual from which it does not."""


def residuals(session: Session, of: Callable[[bool], float]) -> Numbers:
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
        test=TESTS + "test_the_reduced_equations_are_the_printed_ones_but_for_a_sign",
        corrected="- m r l [phi_2'' cos(phi_2 - beta) - phi_2'^2 sin(phi_2 - beta)]",
        why="it is the derivative of the kinetic energy (7); (12) has the sign right",
        effect="none on the theory, which starts from (12). Section 5.2 integrates (11): as "
            "printed it makes case 2's orbit -0.194 rad at 154.65 rad/s with 2.28 N m, where the "
            "right sign makes 0.064 rad, 153.20 rad/s and 3.65 N m and the paper has -0.515 rad, "
            "153.5 rad/s, 3.23 N m, and gives case 3 an orbit at -0.58 rad, where the paper has "
            "none: the print alone is probably at fault. Case 1's rod would swing by 7.3e-4 rad",
        copy="a minus may have been lost",
    ),
    misprint(
        "equation_14", "equation (14)", "The slope of the motor's torque over its speed.",
        NOT_REPRODUCED,
        "as printed V^2/ohm, a power: {power:.3g} W at 153.8 rad/s. By the corrected formula it is "
        "{torque:.3g} N m, where section 5.2 prints 3.08 N m. An error of reasoning, it seems, and "
        "not of print: omega_m stands once for the rotor's speed, and once for the field's",
        equation_14, reference="{torque:.3g} N m", judgement=corrected(below("off", 0.01)),
        printed="n_p L_m^2 U^2 / (L_s^2 omega_m R_r) (omega_s - n_p omega_m)",
        test=ITS_RUN,
        corrected="n_p L_m^2 U^2 (omega_s - n_p omega_m) / (L_s^2 omega_s^2 R_r), with the "
            "field's electric speed omega_s (314.16 rad/s with 50 Hz, our choice), and omega_m "
            "the rotor's",
        why="a torque is a power over a speed, and the flux is the voltage over the field's "
            "speed, to the square",
        effect="neither form gives section 5.2's torques with the entries of table 1, so that the "
            "motor is known from these torques alone",
        copy="an exponent, or an index, may have been lost",
    ),
    misprint(
        "mu_1", "equations (20), (22)",
        "In mu_1, the response of the platform to the first rotor, n_x and n_phi are swapped.",
        CORRECTED, "x of (21) in (16), at case 2, over its largest value: " + OFF,
        IDENTITIES["mu_1"], judgement=MISSES,
        printed="sigma (n_x^2 - 1) n_phi^2 / N",
        test=TESTS + "test_coupling_coefficients_solve_17_and_the_printed_ones_do_not",
        corrected="mu_1 = sigma n_x^2 (n_phi^2 - 1) / N; in (20) sigma l (1 - n_phi^2) n_x^2 "
            "f_1(t)",
        why="it is the solution of (17), the second line of which has omega_phi",
        effect="of print only where it can be told: by case 2's phase, which comes by the "
            "corrected one. Section 3 calls mu_1 and mu_4 identical because of it",
    ),
    misprint(
        "figure_2_caption", "figure 2", "The caption of the first panel names mu_1 and mu_2.",
        CORRECTED,
        "relative difference from mu_1 as printed, of mu_2 and of mu_4: " + OFF,
        partial(residuals, of=figure_2_caption), judgement=MISSES,
        printed="mu_1 and mu_2",
        test=ITS_RUN,
        corrected="mu_1 and mu_4",
        why="mu_2 has a panel of its own, mu_4 has none, and section 3 calls mu_1 and mu_4 one",
        effect="none",
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
        test=TESTS + "test_the_phase_does_not_depend_on_how_the_angle_is_reached",
        corrected="mu_3 cos(beta) cos(alpha) = (mu_3 sin(beta) - mu_1) sin(alpha)",
        why="an error of reasoning, not of print: where the right side of (31) is infinite, "
            "sin(alpha) = 0 solves (30)",
        effect="case 3 does lose synchronism, by the damper of the rod, which (30) leaves out",
    ),
    misprint(
        "equation_35", "equation (35)", "The difference under the derivative is P_1 - P_1.",
        CORRECTED,
        "P_1 - P_1 has the slope {as_printed:g}; that of P_1 - P_2 at the stable root of case 2 "
        "is {right:.4f} N m, minus the amplitude of (34)",
        equation_35, judgement=corrected(below("error", 1e-6)),
        printed="d(P_1 - P_1)/d alpha",
        test=ITS_RUN,
        corrected="d(P_1 - P_2)/d alpha_1 = d(P_1 - P_2)/d alpha",
        why="it is (6) for two rotors, and what stands to the right of it",
        effect="none",
        copy="an index may have been read wrongly",
    ),
    misprint(
        "phase_sign", "5.2, case 1", "The theoretical phase difference has no sign.", CORRECTED,
        "(30) is off by {as_printed:.2g} of its amplitude at +3.013 rad, by {corrected:.1g} at "
        "-3.013 rad",
        sign_of_case_1, judgement=corrected(above("as_printed", 0.1), below("corrected", 1e-3)),
        printed="3.013 rad",
        test=TESTS + "test_the_papers_phases_need_the_corrected_coefficient",
        corrected="-3.013 rad (or 3.270 rad, in the range that section 5.1 gives for antiphase)",
        why="the root of (30) that satisfies (36)",
        effect="none on the kind of synchronism; the simulation's 3.10 rad is compared by modulus",
        copy="a minus may have been lost",
    ),
    misprint(
        "units", "2.2, table 1", "Units of the torsion spring and of the motors' torque.",
        CORRECTED,
        "(8) is an energy with k_phi in {spring}, and (11) is of torques with M_e in {torque}",
        units, judgement=corrected(equal("spring", "N m/rad"), equal("torque", "N m")),
        printed="k_phi [N/rad], M_e [N/m]",
        test=ITS_RUN,
        corrected="k_phi [N m/rad], M_e [N m]",
        why="k_phi phi_3^2 is an energy, M_e a moment",
        effect="none",
    ),
    misprint(
        "dampers_of_9", "equation (9)",
        "The dissipation has f_1, f_2, f_3; (11) and table 1 have the last alone, as f_phi.",
        CORRECTED,
        "the bearings of the rotors are R_e1 and R_e2 in (10) and (11), of which no number is "
        "given; in D they would be counted twice",
        printed="f_1, f_2, f_3",
        test=OWN_TESTS + "test_dampers_take_what_9_says_without_those_of_the_rotors",
        corrected="D = (f_x x'^2 + f_phi phi_3'^2)/2",
        why="(11) has no term in f_1 or f_2, and f_phi phi_3' where (9) gives f_3 phi_3'",
        effect="none on equations; the friction of the bearings is known from section 5.2 alone",
    ),
    misprint(
        "order_of_6", "2.1, (6)", "(6) is called an equation of the k-th order.", CORRECTED,
        "its determinant has k - 1 rows, as the phases count but for their differences: for two "
        "rotors it is (35), of the first order",
        printed="the kth order algebraic equation",
        test=OWN_TESTS + "test_6_is_of_order_k_minus_1",
        corrected="of the (k - 1)-th order",
        why="a common turn of all rotors changes nothing",
        effect="none: (35) is of the first order",
    ),
    misprint(
        "names_of_torques", "5.2, figures 4(b) to 6(b)",
        "The torques of the motors are called coupling torques.", CORRECTED,
        "the vibration's mean torque on a rotor, (26), is 0 in synchronous motion by (30), and at "
        "no phase difference more than {largest:.2f} N m in cases 1 and 2; 3.08 and 3.23 N m are "
        "what the bearings take",
        largest_coupling, judgement=corrected(below("share", 1.0)),
        printed="coupling torques",
        test=OWN_TESTS + "test_coupling_cannot_be_as_large_as_the_torques_of_section_5",
        corrected="torques of the motors",
        why="(30) leaves no torque of the vibration over; the captions of figures 4 (b) to 6 (b) "
            "have torques of the two rotors",
        effect="of words, but for case 3, where coupling torques are called absent, see "
            "case_3_no_coupling",
    ),
    misprint(
        "rotor_2_twice", "5.2, case 2",
        "The speed of rotor 2 is said to fluctuate more than that of rotor 2.", CORRECTED,
        "rotor 1 is meant, on the platform: see case_2_fluctuation",
        printed="stronger than rotor 2",
        test="tests/comparisons/papers/rotor_pendulum/test_measures.py::test_rotor_on_the_rod_fluctuates_more",
        corrected="stronger than that of rotor 1",
        why="there are two rotors",
        effect="none",
    ),
    misprint(
        "equation_numbers", "2.1, 4", "Three references to equations.", CORRECTED,
        "(24) is (21) with (23) in it, while (19) are the frequency ratios; the solution that is "
        "called fundamental in 2.1 is (3), while (4) are the conditions on it;  the "
        "second formula with mu = 0 is one of (1), not of (2)",
        printed="(19), (4), (2)",
        test=TESTS + "test_coupling_coefficients_solve_17_and_the_printed_ones_do_not",
        corrected="(21), (3), (1)",
        why="as the sentences beside them tell",
        effect="none",
    ),
    misprint(
        "omega_m", "(14), (19), (26), table 1",
        "omega_m is the field's electric speed below (14), and the rotors' speed elsewhere.",
        CORRECTED,
        "with n_p = 2 the field's electric speed is twice its mechanical one, of which 157 rad/s "
        "is table 1's largest: 314.16 rad/s with 50 Hz, our choice, as no frequency is printed. "
        "The rotors' speed is omega in (3), the first line of (26), (34) and (35)",
        printed="omega_m",
        test=OWN_TESTS + "test_omega_m_of_14_is_another_than_table_1s",
        corrected="omega_s, electric, in (14); omega_m = omega, the rotors' speed, elsewhere",
        why="frequency ratios by (19) with 314.16 rad/s would be twice those of table 2",
        effect="none, but on (14), see there",
    ),
    misprint(
        "synphase_interval", "5.1", "The interval of synphase motion is (pi/2, pi/2).", CORRECTED,
        "an empty interval; case 2's -0.515 rad, called synphase, is in (-pi/2, pi/2), and so is "
        "all that antiphase, (pi/2, 3 pi/2), leaves of a turn",
        printed="(pi/2, pi/2)",
        test=OWN_TESTS + "test_synphase_is_what_antiphase_leaves",
        corrected="(-pi/2, pi/2)",
        why="the two kinds share a turn",
        effect="none: section 5.2 goes by the right one",
        copy="almost surely at fault: in both intervals of this sentence it has lost the sign "
            "'element of' as well",
    ),
)  # fmt: skip


AGREE = 0.1
"""Distance [rad] below which two phase differences are said to agree; the paper's own two
pairs, which it calls so, are 0.09 and 0.03 apart."""
ALIKE = 0.01
"""Difference of speeds, of the working speed, up to which they count as equal."""
SMALL = 0.1
"""Share of another torque that may be called none."""
STEADY = 0.02
"""Relative change of amplitudes that are called steady."""

RATIO_ROWS: tuple[LedgerRow, ...] = tuple(
    number(
        f"case_{case}_{name}", f"5.2, case {case}",
        f"Frequency ratio {name} of the printed stiffness.",
        REPRODUCED if (case, name) == (2, "n_phi") else NOT_REPRODUCED,
        "ours at {speed:.1f} rad/s, the nearest of table 1's; it takes {takes[0]:.1f} rad/s with "
        + (
            "(m + m_3) l^2 = {inertias[0]:.4g} kg m^2 or {takes[1]:.1f} rad/s with (m_0 + m_3) "
            "l^2 = {inertias[1]:.4g} kg m^2"
            if name == "n_phi"
            else "M = {inertias[0]:.4g} kg or {takes[1]:.1f} rad/s with m_0 = {inertias[1]:.4g} kg"
        )
        + (", the lower end of table 1's range" if (case, name) == (2, "n_x") else ""),
        partial(derivation.frequency_ratio, case=case, rod=name == "n_phi", printed=printed),
        printed=printed,
    )
    for case, name, printed in (
        (1, "n_x", "0.4943"),
        (1, "n_phi", "0.4943"),
        (2, "n_x", "5.916"),
        (2, "n_phi", "5.029"),
    )
)  # fmt: skip


def orbit_rows(case: int, *rows: tuple[str, str, str, str, str, str, Any]) -> tuple[LedgerRow, ...]:
    """Return rows that compare quantities of a case's synchronous orbit with printed numbers.

    Each of name, summary, printed number, quantity, verdict, reason and the measure of its numbers.
    """
    return tuple(
        number(
            f"case_{case}_{name}", f"5.2, case {case}", summary, verdict, reason, numbers,
            partial(
                cases.orbit_quantity, case=case, quantity=quantity, sign=-1 if case_1_phase else 1
            ),
            printed=printed, slow=True,
            judgement={**holds(ROUNDS), **DEPENDENT.get((case, name), {})},
        )
        for name, summary, printed, quantity, verdict, reason, numbers in rows
        for case_1_phase in [(case, name) == (1, "phase")]
    )  # fmt: skip


PASSES = below("begin", HORIZONS[1])
"""The run from rest passes the printed phase."""
DEPENDENT = {
    (1, "phase"): depends(PASSES),
    (1, "rod_amplitude"): depends(Condition("by_print", "rounds to", PRINTED)),
}
"""What else a printed number of an orbit may come by, by case and name."""

LESS_DAMPED = (
    "f_phi = 15 takes {power:.0f} W, which the paper's theory leaves out; with f_phi = 0: {free}; "
    "with 3: {light}"
)
AMPLITUDES = "with f_phi = 0 the platform has {platform:.3g} m and the rod {rod:.3g} rad"
NO_COUPLING = (
    "on what is meant: by coupling torques the text names the curves of figures 4 (b) to 6 (b), "
    "which are the motors' torques, and these are there. The torque by which vibration couples "
    "the rotors is {share:.0%} of case 2's, by (34) {undamped:.3f} of {case_2:.2f} N m, with the "
    "dampers {first:.3f} N m: small, not absent. The damper of the rod drives the rotors apart "
    "with {mean:.2f} N m, and that ends synchronism; without f_phi the orbit is {free}"
)
ABSENT = {**holds(equal("undamped", 0)), **depends(below("share", SMALL, ours=True))}
"""Judgement of a coupling torque that is said to be absent."""

CALIBRATION = (
    "used for calibration, and so no test of the paper: k_e = 0.9391 and f = 0.0199 N m s/rad are "
    "what the printed speed and torque make"
)

ORBITS_1 = orbit_rows(
    1,
    (
        "speed", "Synchronous speed.", "153.8 rad/s", "mean_speed", REPRODUCED,
        CALIBRATION, None,
    ),
    (
        "phase", "Phase difference that the simulation settles at.", "3.10 rad",
        "phase_difference", DEPENDS,
        "modulus compared, as the paper's theory has lost its sign; the orbit has {phase:.4f} rad, "
        "{circle:.3f} rad from 3.10 on the circle. From rest the rotors pass 3.10 rad from "
        "{begin:.1f} to {end:.1f} s, on their way there: how long the simulation is, the text does "
        "not say",
        cases.phase_of_case_1,
    ),
    (
        "torque", "Torque of the motors.", "3.08 N m", "motor_torque_1", REPRODUCED,
        CALIBRATION, None,
    ),
    (
        "rod_amplitude", "Amplitude of the rod.", "7e-4 rad", "rod_amplitude", DEPENDS,
        "on how the simulation has the sign of (11), and on how the digits end: with the sign as "
        "printed it is {by_print:.3g} rad by the linear response (16), with the dampers, where the "
        "right sign gives {linear:.3g} rad; that, cut off and not rounded, is 7e-4 too",
        cases.orbit_of_case_1,
    ),
    (
        "platform_amplitude", "Amplitude of the platform.", "7e-4 m", "platform_amplitude",
        REPRODUCED, "", None,
    ),
)  # fmt: skip

ORBITS_2 = orbit_rows(
    2,
    (
        "speed", "Mean synchronous speed.", "153.5 rad/s", "mean_speed", NOT_REPRODUCED,
        LESS_DAMPED, cases.rod_damper_of_case_2,
    ),
    (
        "phase", "Phase difference that the simulation settles at.", "-0.515 rad",
        "phase_difference", NOT_REPRODUCED, LESS_DAMPED, cases.rod_damper_of_case_2,
    ),
    (
        "torque", "Torque of the motors.", "3.23 N m", "motor_torque_1", NOT_REPRODUCED,
        LESS_DAMPED, cases.rod_damper_of_case_2,
    ),
    (
        "rod_amplitude", "Amplitude of the rod.", "0.02 rad", "rod_amplitude", NOT_REPRODUCED,
        "0.02 if ours is cut off to one digit; with f_phi = 0 it is {rod:.3g} rad. Neither that "
        "damper nor the phase, nor the sign of (11), makes 0.02 rad of it",
        cases.rod_damper_of_case_2,
    ),
    (
        "platform_amplitude", "Amplitude of the platform.", "2.5e-4 m", "platform_amplitude",
        NOT_REPRODUCED, AMPLITUDES, cases.rod_damper_of_case_2,
    ),
)  # fmt: skip


def theory_rows(
    case: int, printed: str, sign: float, type_: str, span: Any
) -> tuple[LedgerRow, ...]:
    """Return the rows on a case's theoretical phase, its agreement with the orbit, and its type."""
    low, high = span
    return (
        number(
            f"case_{case}_theory", f"5.2, case {case}", "Stable phase difference by theory.",
            CORRECTED,
            ("the root is negative, the sign lost; " if sign < 0 else "")
            + "mu_1 as printed gives {as_printed:.4f} rad; at the ratios that belong to the "
            "printed stiffnesses it is {ours:.4f} rad",
            partial(cases.theoretical, case=case, sign=sign),
            judgement=corrected(ROUNDS), printed=printed, slow=True,
        ),
        statement(
            f"case_{case}_agreement", f"5.2, case {case}",
            "Simulation and theory agree in the phase difference.",
            CORRECTED if case == 1 else NOT_REPRODUCED,
            "the orbit is {value:.3f} rad from the theory's {alpha:.4f} rad at the printed "
            "stiffnesses; without f_phi {free:.3f} rad",
            partial(cases.from_theory, case=case), partial(cases.gap_to_theory, case=case),
            "{value:.3f} rad apart", judgement=corrected(below("value", AGREE, ours=True)),
            slow=True,
        ),
        statement(
            f"case_{case}_type", f"5.2, case {case}", type_, REPRODUCED,
            "n_x and n_phi of the printed stiffnesses {ratios[0]:.3g}, {ratios[1]:.3g}; as printed "
            "{ratios[2]:.4g}, {ratios[3]:.4g}",
            partial(cases.coupling_type, case=case),
            judgement=holds(above("ratios", low), below("ratios", high)), slow=True,
        ),
    )  # fmt: skip


def run_up(case: int, summary: str, verdict: str, relation: str) -> LedgerRow:
    """Return the row on the speeds of a case's rotors while they speed up."""
    either = "least" if relation == "<" else "largest"
    return statement(
        f"case_{case}_accelerations", f"5.2, case {case}", summary, verdict,
        "largest difference of the speeds before both are at the working speed, over it: by the "
        "tangent (14) from rest on {laws[0]:.1%}, by a motor's curve of the same slope and at "
        f"most {LARGEST:g} N m {{laws[1]:.1%}}; {ALIKE:.0%} would be alike",
        partial(cases.gaps, case=case), partial(cases.run_up_gap, case=case), "{value:.2%}",
        judgement={
            **holds(Condition("laws", relation, ALIKE, ours=True)),
            **depends(Condition(either, relation, ALIKE, ours=True)),
        },
        slow=True,
    )  # fmt: skip


def settles(case: int, name: str, kind: str) -> LedgerRow:
    """Return the row on how a case synchronises from rest."""
    return statement(
        f"case_{case}_{name}", f"5.2, case {case}", f"It settles in {kind} from rest.", REPRODUCED,
        kind + "; phase of the last turn from rest, the stable orbit has {target:.4f} rad",
        each=partial(cases.last_phase, case=case), reference="{end:.4f} rad",
        judgement=holds(
            below("off", 0.01, everyone=True), equal("kind", kind), equal("stable", True)
        ),
        slow=True,
    )  # fmt: skip


def displacements(case: int, relation: str, verb: str = "become") -> LedgerRow:
    """Return the row on how steady the displacements of a case become."""
    return statement(
        f"case_{case}_displacements", f"5.2, case {case}", f"The displacements {verb} steady.",
        REPRODUCED,
        "largest change of the amplitudes of x and phi_3, taken over three turns each, in the "
        "last quarter of the run",
        each=partial(cases.change_of_amplitudes, case=case), reference="{value:.1%}",
        judgement=holds(Condition("value", relation, STEADY, ours=True)), slow=True,
    )  # fmt: skip


def case_row(case: int, name: str, summary: str, *more: Any, **keywords: Any) -> LedgerRow:
    """Return the row of a claim on one case."""
    where = f"5.2, case {case}"
    return replace(statement(f"case_{case}_{name}", where, summary, *more, **keywords), slow=True)


CASE_ROWS: tuple[LedgerRow, ...] = (
    *ORBITS_1,
    *theory_rows(1, "3.013 rad", -1.0, "It is of type 1: both before resonance.", (0.1, 0.9)),
    run_up(1, "Both rotors speed up alike.", DEPENDS, "<"),
    case_row(
        1, "stiff_springs", "They do so because their inertias are the same and the springs stiff.",
        REPRODUCED,
        "difference of the speeds in case 1, and in case 2, with the same rotors and soft springs: "
        "by (14) {first[0]:.1%} and {second[0]:.1%}, by a motor's curve {first[1]:.1%} and "
        "{second[1]:.0%}",
        cases.stiffer_is_calmer, judgement=holds(above("ratios", 1)),
    ),
    statement(
        "start_differs", "5.2, cases 1, 2",
        "While the rotors speed up their speeds differ, and the phase difference is not constant.",
        DEPENDS,
        "on how long a start is. Speeds differ by up to {gaps:.1%}; the phase moves by "
        "{early:.2f} rad in the first second, by {moves:.2f} rad on the whole, and by "
        "{rests:.0e} rad in the last half second: case 1 leaves its first phase long after the "
        "rotors are at speed",
        cases.differences,
        judgement={
            **holds(above("gaps", 0), above("early", 0.1, ours=True)),
            **depends(above("gaps", 0), above("slows", 10, ours=True)),
        },
        slow=True,
    ),
    settles(1, "antiphase", "antiphase"),
    displacements(1, "<"),
    statement(
        "one_motor", "5.2", "Cases 1 and 2 have the same motors.", DEPENDS,
        "on the motors' curve and their speed without load, for which 157.08 rad/s is our choice. "
        "With it torque over slip, as rounding allows it, is {first[0]:.3f} to {first[1]:.3f} "
        "N m s/rad in case 1 and {second[0]:.3f} to {second[1]:.3f} in case 2: no line as (14) "
        "goes through both, as lines do from {onset:.2f} rad/s on; curves of an induction motor "
        "do, with a largest torque of {curves[0]:.1f} to {curves[1]:.1f} N m",
        cases.one_motor,
        judgement={**holds(above("overlap", 0)), **depends(above("curves", 3.23))},
    ),
    *ORBITS_2,
    *theory_rows(2, "-0.5474 rad", 1.0, "It is of type 3: both after resonance.", (1.1, 7.0)),
    run_up(2, "The rotors speed up differently.", REPRODUCED, ">="),
    case_row(
        2, "larger_swing", "The reason is that the rod swings more than in case 1.", REPRODUCED,
        "largest swing of the rod until both rotors are at speed, in cases 1 and 2: by (14) "
        "{first[0]:.2g} and {second[0]:.2g} rad, by a motor's curve {first[1]:.2g} and "
        "{second[1]:.2g} rad; the speeds differ more as well",
        cases.larger_swing, judgement=holds(above("ratios", 1), above("differ", 1)),
    ),
    case_row(
        2, "synphase", "The stable orbit is in synphase.", REPRODUCED, "within pi/2 of 0",
        each=partial(cases.orbit_quantity, case=2, quantity="phase_difference"),
        reference="{value:.4f} rad",
        judgement=holds(above("value", -WAVE / 4), below("value", WAVE / 4)),
    ),
    settles(2, "settles", "synphase"),
    case_row(
        2, "fluctuation", "The speed of the rotor on the rod fluctuates more than the other's.",
        REPRODUCED,
        "half the range of the speeds of rotors 1 and 2 in the last second",
        each=cases.fluctuations, reference="{first:.3f} and {second:.3f} rad/s",
        judgement=holds(above("ratio", 2)),
        erratum=Erratum(
            "tests/comparisons/papers/rotor_pendulum/test_measures.py"
            "::test_rotor_on_the_rod_fluctuates_more",
            "... of rotor 2, on the rod, is stronger than that of rotor 1",
            "the text names rotor 2 twice",
            "none",
        ),
    ),
    case_row(
        2, "amplitude_fluctuation",
        "The larger the rod swings, the more the speed of its rotor fluctuates.",
        REPRODUCED,
        "of cases 1 and 2: swing {small:.2g} and {large:.2g} rad; values: fluctuation of rotor 2",
        cases.swings, cases.fluctuations_of_rotor_2, "{first:.3f} and {second:.3f} rad/s",
        judgement=holds(above("swings", 2), above("ratio", 2)),
    ),
    case_row(
        2, "resonance_passage", "Speeding up through resonance shows in x and phi_3.",
        DEPENDS,
        "largest x and phi_3 at the start over those at the end: by the tangent (14) from rest on "
        "{linear[0]:.2f} and {linear[1]:.2f}, since the rotors are at speed after {times[0]:.3f} "
        "s, less than a turn; by a motor's curve of the same slope and at most "
        f"{LARGEST:g} N m, after {{times[1]:.2f}} s, {{curve[0]:.2f}} and {{curve[1]:.2f}}",
        cases.passages, cases.overshoot, "{ratios[0]:.2f} and {ratios[1]:.2f}",
        judgement={
            **holds(above("ratios", 2, ours=True)), **depends(above("largest", 2, ours=True)),
        },
    ),
    displacements(2, "<"),
    case_row(
        3, "unstable_phase", "The phase difference is not stable.", REPRODUCED,
        "what rotor 1 gains on rotor 2 in {duration:.3g} s, more than a turn; a synchronous orbit "
        "is {words}",
        cases.orbit_of_case_3, cases.slip, "{gain:.3f} rad",
        judgement=holds(above("size", WAVE, everyone=True), equal("kind", "none")),
    ),
    case_row(
        3, "no_coupling", "The reason is that coupling torques are absent at beta = pi/2.",
        DEPENDS, NO_COUPLING, cases.coupling_of_case_3, judgement=ABSENT,
    ),
    case_row(
        3, "torques", "The torques of the motors differ at all times.", REPRODUCED,
        "least and largest of what motor 2 gives more than motor 1, averaged over turns",
        each=cases.slip, reference="{least:.2f} to {largest:.2f} N m",
        judgement=holds(above("least", 0)),
    ),
    case_row(
        3, "rotor_1_faster", "Rotor 1 is faster during the start.", REPRODUCED,
        "mean difference of the speeds over the first 12 turns; {first:.2f} rad/s in the first "
        "turn, in which rotor 2 is ahead. By a motor's curve of the same slope and at most "
        f"{LARGEST:g} N m, {{curve:.1f}} rad/s until both are at speed",
        cases.lead_of_rotor_1, cases.slip, "{mean:.3f} rad/s",
        judgement=holds(above("mean", 0), above("curve", 0), above("ahead", 0.8)),
    ),
    displacements(3, ">=", "do not become"),
    statement(
        "case_3_unsuitable", "5.2, case 3", "Such parameters are not for use.", NOT_TESTABLE,
        "an advice, which follows from the rows above",
    ),
)  # fmt: skip


FAR = 3.0
ALMOST_ALL = 0.95
"""Share of a region from which on it counts as being of one kind throughout."""
SOME = 1e-3
"""Share from which on a kind counts as appearing in a region."""
SMALL_POWER = 0.02
"""Share of a motor's power that may be left out of its balance."""

N = theory.ratios(CASE_1)

MODEL: tuple[LedgerRow, ...] = (
    statement(
        "energies", "equations (7), (8)", "Kinetic and potential energy.", REPRODUCED,
        "without J_i, which 2.2 neglects; against the scene's energy at 16 random states: off by "
        "{error:.0e}",
        derivation.printed_energy, judgement=holds(below("error", IDENTITY)),
    ),
    statement(
        "equation_10", "equations (9), (10)",
        "Lagrange's equations with a dissipation, and the motors' torques as generalised forces.",
        REPRODUCED,
        "(7) to (9) in (10) give the scene's accelerations: off by {error:.0e}",
        derivation.equation_10, judgement=holds(below("error", IDENTITY)),
    ),
    statement(
        "equation_11_lines", "equations (11), (13)",
        "Equations of the platform and of both rotors, lines 1 to 3.", REPRODUCED,
        "with the accelerations of Lagrange's equations at phi_3 = 0 they leave {left:.0e} of "
        "their largest terms",
        derivation.other_lines_of_11, judgement=holds(below("left", IDENTITY)),
    ),
    statement(
        "speed_range", "table 1", "omega_m lies from 152 to 157 rad/s.", DEPENDS,
        "on what it speaks of. Stable orbits of figure 3, with the dampers, have {least:.1f} to "
        "{largest:.1f} rad/s. Read as what (19) divides, section 5.2's stiffnesses and ratios ask "
        "for {asked:.2f} rad/s, which rounds to that range; of the right inertia and the paper's "
        "each is taken with the one that comes nearer: the right one for case 2's n_phi alone. "
        "Table 1's largest stiffnesses are 157 rad/s to all digits, 100 kg and 9.9 kg m^2 times "
        "(157/0.1)^2, case 1's are twice that speed, 314^2 times these",
        derivation.speeds_of_ratios, regions.speeds, "{least:.1f} to {largest:.1f} rad/s",
        judgement={
            **holds(above("least", 151.5), below("largest", 157.5)),
            **depends(
                Condition("slowest", "rounds to", "152"), Condition("fastest", "rounds to", "157")
            ),
        },
        printed="152 to 157 rad/s", slow=True,
    ),
    statement(
        "equation_11_reduction", "2.2",
        "With light rotors the inertia coupling by asymmetry may be neglected, which gives (11).",
        REPRODUCED,
        "the phase difference from rest is off by at most {gaps[0]:.1e} rad in case 1, "
        "{gaps[1]:.1e} rad in case 2, {gaps[2]:.1e} rad in case 3; of two terms of the same order "
        "one is dropped, so that energy is not conserved, but both are small here",
        derivation.reduction,
        reference="case 2 ends at {exact:.5f} rad by the exact equations, {reduced:.5f} rad by "
        "(11)",
        judgement=holds(below("gaps", 0.01 * np.pi)), slow=True,
    ),
    *(
        number(
            name, section, f"{what} stiffness at {'n_phi' if rod else 'n_x'} = {ratio:g}.",
            NOT_REPRODUCED,
            mistake + " gives {mistaken:.9g} at n = {ratio:g} and 157 rad/s" + more,
            partial(derivation.stiffness, ratio=ratio, rod=rod),
            reference="{value:.6g} {unit}", printed=printed,
        )
        for name, section, what, mistake, ratio, rod, printed, more in (
            (
                name, section, *by_inertia, ratio, rod, printed,
                ", near what is printed, not that" if name == "kx_low" else "",
            )
            for rod, by_inertia in (
                (False, ("Platform", "m_0 = {wrong:g} kg for M = {right:g} kg")),
                (
                    True,
                    (
                        "Torsional",
                        "(m_0 + m_3) l^2 = {wrong:.4g} kg m^2 for (m + m_3) l^2 = {right:.4g}",
                    ),
                ),
            )
            for name, section, ratio, printed in (
                (
                    ("kphi_high", "table 1", 0.1, "24402510 N m/rad"),
                    ("kphi_low", "table 1", 7.0, "4980 N m/rad"),
                )
                if rod
                else (
                    ("kx_high", "table 1", 0.1, "246490000 N/m"),
                    ("kx_low", "table 1", 7.0, "50307 N/m"),
                    ("kx_resonance", "5.1", 1.0, "2.46e6 N/m"),
                )
            )
        )
    ),
    *(
        number(
            name, "table 2", summary, REPRODUCED, "{value:.4g} before rounding",
            partial(derivation.dimensionless, value=value), printed=printed,
        )
        for name, summary, value, printed in (
            ("eta", "eta = m_3/m.", CASE_1.rod_mass / CASE_1.rotor_mass, "5"),
            ("sigma", "sigma = 1/(1 + eta).", N.sigma, "0.17"),
            ("r_m", "r_m = m/M.", N.r_m, "0.02"),
        )
    ),
)  # fmt: skip

THEORY: tuple[LedgerRow, ...] = (
    *VIBRATION,
    statement(
        "level_mu_1", "5.1", "mu_1 is negative for n_x < 1 where beta = 0.", CORRECTED,
        "at most {right:.2g} there; mu_1 as printed comes up to {printed:.2g}",
        derivation.level_mu_1, judgement=corrected(below("right", 0), above("printed", 0)),
    ),
    statement(
        "mu_1_is_mu_4", "3", "mu_1 and mu_4 are the same expression.", CORRECTED,
        "with n_x and n_phi exchanged: the right mu_1(n_x, n_phi) is mu_4(n_phi, n_x), to "
        "{mirrored:.0e}. At the same place the median difference of the two is {apart:.0%}; as "
        "printed, by the misprint in mu_1, there is none",
        derivation.mirror_images,
        judgement={**holds(below("apart", IDENTITY)), **corrected(below("mirrored", IDENTITY))},
    ),
    statement(
        "level_rod_coupling", "3", "Without installation angle the coupling is absent.", REPRODUCED,
        "mu_2 and mu_3 are {largest:g}; the rotors stay coupled, by mu_1 through the platform, by "
        "up to {torque:.2f} N m with case 2's springs",
        derivation.level_rod, judgement=holds(equal("largest", 0)),
    ),
    statement(
        "coupling_strength", "3",
        "The larger mu_2 and mu_3, the stronger the system is coupled.",
        DEPENDS,
        "on what is meant by strength: the rod's swing by rotor 1 and the platform's by rotor 2 "
        "go with mu_3 and mu_2 (rank correlation {swing:.2f}). The torque that couples the rotors "
        "goes with |(mu_1 - mu_3 sin(beta), mu_3 cos(beta))|: its rank correlation with mu_3 is "
        "{rank:.2f} at beta = pi/6, and at beta = 0 it acts though mu_2 and mu_3 are zero",
        derivation.strength,
        judgement={
            **holds(above("rank", 0.9, ours=True), equal("mu_1_alone", 0)),
            **depends(above("swing", 0.999)),
        },
    ),
    statement(
        "resonance_peaks", "3, figure 2",
        "Coefficients are small before and after resonance, far larger within 0.9-1.1.",
        OPEN,
        "medians of |mu_1| ... |mu_4| before, at and after resonance of both: before: "
        "{before:.2g}; at: {at:.2g}; after: {after:.2g}; at resonance the least of them is "
        f"{{rise:.3g}} times larger, {FAR:g} would be far; they are infinite on the curve N = 0, "
        "which passes beside n_x = 1 and n_phi = 1",
        derivation.peaks, judgement=corrected(above("rise", FAR, ours=True)),
    ),
    statement(
        "coupling_types", "3", "Frequency ratios divide systems into three types of coupling.",
        REPRODUCED,
        "a definition, which leaves {unnamed:.1%} of the plane without a type, the strips of "
        "resonance; the coupling torque at n_x = n_phi = 0.5, 1.01, 3 is {torques:.2g} N m",
        derivation.coupling_types, judgement=holds(above("rises", 0)),
    ),
    statement(
        "equation_27", "equation (27)",
        "In synchronous motion each motor gives what its own bearing takes, and no more.",
        NOT_REPRODUCED,
        "so that vibration takes no power. Motors' powers less those of their bearings, over the "
        "motors', of rotors 1 and 2: {shares[0]:.1%} and {shares[1]:.1%} in case 1, "
        "{shares[2]:.1%} and {shares[3]:.1%} in case 2 ({watts[0]:.0f} and {watts[1]:.0f} W): "
        "the rotors feed the dampers, and do so unequally. What fails in case 2 fails by it, "
        "but for the rod's amplitude. Without dampers and with equal motors it is exact, as "
        "(28) and (29) leave no torque of the vibration, see identity_29",
        each=cases.excess_powers, reference="{shares:.1%}",
        judgement=holds(below("shares", SMALL_POWER, ours=True)), slow=True,
    ),
    statement(
        "equation_34", "equations (26), (34)", "Mean torques of the vibration on the rotors.",
        CORRECTED,
        "(34) against the mean torque in steady vibration, case 2 without dampers: off by "
        "{as_printed:.2g} as printed, by {corrected:.1g} corrected. With the dampers a constant "
        "part comes in that it lacks, {mean:.2f} N m beside an amplitude of {amplitude:.2f} N m "
        "in case 2",
        derivation.equation_34,
        judgement=corrected(below("corrected", IDENTITY), above("as_printed", FAILS)),
    ),
    statement(
        "balance_and_stability", "equations (30), (36)",
        "A synchronous motion needs a phase difference that balances and is stable.",
        REPRODUCED,
        "for every n_x, n_phi and beta tried, with mu_1 as printed and corrected, there is exactly "
        "one stable root, and the unstable one is opposite; (30) holds to {residual:.0e} of its "
        "amplitude",
        derivation.roots, judgement=holds(below("residual", IDENTITY), below("opposite", 0)),
    ),
    statement(
        "equation_33_branch", "equations (31), (33)", "Phase difference as an inverse cotangent.",
        REPRODUCED,
        "the stable root of (30) has this cotangent, with mu_1 as printed and corrected, to "
        "{error:.0e}. Of the "
        "two angles of a turn that have it (36) takes one; the one in (0, pi) alone, with mu_1 as "
        "printed, would be the unstable one on {shares:.0%} of the range of table 2",
        derivation.branch_of_33, judgement=holds(below("error", IDENTITY)), slow=True,
        printed="alpha = arccot(...)",
    ),
    statement(
        "speed_and_phase", "4",
        "(26) and (31) can be solved for the synchronous speed and the phase difference.",
        REPRODUCED,
        "with (14)'s line one speed, {speeds:.2f} rad/s, for both cases, as (30) leaves the motors "
        "and their bearings alone, and one stable phase in each; orbits, with the dampers: "
        "{orbits:.2f} rad/s",
        regions.speed_and_phase, judgement=holds(equal("roots", 1), equal("phases", 1)), slow=True,
    ),
    SMALL_PARAMETER,
    statement(
        "equation_36", "equations (35), (36)", "Which phase differences are stable.", REPRODUCED,
        "(36) is the slope of (30) over alpha, which (35) takes with a minus: apart by "
        "{slope:.0e}, the step of the difference; a claim on a vibration without dampers",
        derivation.equations_31_36, judgement=holds(below("slope", 1e-8)),
    ),
    statement(
        "springs_decide", "4", "Both springs are key to the phase difference.", REPRODUCED,
        "at beta = pi/6 k_phi moves it by {by_phi:.2f} rad; k_x only decides between two opposite "
        "values ({flips:.0%} of the plane has the other one than n_x = 0.1), and moves it by "
        "{by_x:.0e} rad otherwise, as n_x cancels in (30) but for the sign of N. With "
        "mu_1 as printed k_x moves it, by {printed[1]:.2f} rad, and k_phi does not, but for "
        "half turns",
        derivation.springs_decide,
        judgement=holds(above("most", SMALL), above("by_phi", SMALL), above("flips", SMALL)),
    ),
)  # fmt: skip

LEVEL: tuple[LedgerRow, ...] = (
    statement(
        "level_phase", "5.1, figure 3(a)",
        "Without installation angle the phase is pi for n_x < 1 and 0 for n_x > 1.",
        CORRECTED,
        "by (30), (36) pi and 0 to {off:.0e} rad; with mu_1 as printed n_phi would decide, and "
        "the phase at n_x = 0.5, n_phi = 2 be {printed:.2g}. Values: true orbits",
        regions.level_phases, regions.level_orbits, "n_x < 1: {before:.0%}, n_x > 1: {after:.0%}",
        judgement=corrected(below("off", 1e-6)), slow=True,
    ),
    statement(
        "level_rod_spring", "5.1, figure 3(a)",
        "Without installation angle the rod's spring has little influence on the phase.",
        CORRECTED,
        "along n_phi the phase of the theory varies by {by_theory:.0e} rad. Values: true orbits, "
        "where the damper f_phi, which the theory leaves out, brings n_phi back in",
        regions.level_phases, regions.level_orbits,
        "by up to {spread:.2g} rad, no orbit on {lost:.0%}",
        judgement=corrected(below("by_theory", 1e-6)), slow=True,
    ),
)  # fmt: skip

WIDE = (0.1, 7.0)
ALWAYS = {
    kind: corrected(Condition(kind, ">=", ALMOST_ALL, ours=True))
    for kind in ("synphase", "antiphase")
}
EITHER = tuple(Condition(kind, ">=", SOME, ours=True) for kind in ("synphase", "antiphase"))
BOTH = {**holds(*EITHER, Condition("by_print", ">=", SOME, ours=True)), **corrected(*EITHER)}

FIGURE_3: tuple[LedgerRow, ...] = tuple(
    statement(
        f"fig_3{panel}_{name}", f"5.1, figure 3({panel})", f"beta = {angle}, {summary}", verdict,
        ("least share with mu_1 as printed {by_print:.1%}; " if name == "both" else "")
        + "share of the region by (30), (36): {theory:.1%}, without the strips of resonance, "
        "0.9-1.1, {apart:.1%}; the phase passes +-pi/2 at n_phi = {turn:.3g} and at resonance. "
        "True orbits, with the dampers: {orbits:.0%}",
        each=partial(regions.kinds_in_regions, beta=BETAS[angle], regions=tuple(places)),
        reference="{theory:.1%}", engines="{orbits:.0%}",
        judgement=ALWAYS.get(name, BOTH), slow=True,
    )
    for panel, angle, name, verdict, summary, places in (
        (
            "b", "pi/6", "antiphase", OPEN,
            "n_x < 1, n_phi > 1: antiphase.", [(BEFORE, AFTER)],
        ),
        (
            "b", "pi/6", "both", REPRODUCED,
            "n_x < 1, n_phi < 1: both antiphase and synphase appear.", [(BEFORE, BEFORE)],
        ),
        (
            "b", "pi/6", "synphase", OPEN,
            "n_x > 1: always synphase.", [(AFTER, WIDE)],
        ),
        (
            "c", "pi/3", "antiphase", OPEN,
            "n_x < 1, n_phi < 1: antiphase.", [(BEFORE, BEFORE)],
        ),
        (
            "c", "pi/3", "both", CORRECTED,
            "n_x < 1, n_phi > 1: both appear.", [(BEFORE, AFTER)],
        ),
        (
            "c", "pi/3", "synphase", NOT_REPRODUCED,
            "n_x > 1, n_phi > 1: synphase.", [(AFTER, AFTER)],
        ),
        (
            "d", "5 pi/12", "antiphase", OPEN,
            "n_x < 1, n_phi < 1: antiphase.", [(BEFORE, BEFORE)],
        ),
        (
            "d", "5 pi/12", "both", REPRODUCED,
            "n_x > 1, n_phi < 2.7: both appear.", [(AFTER, (0.1, 2.7))],
        ),
        (
            "d", "5 pi/12", "synphase", NOT_REPRODUCED,
            "elsewhere: synphase.", [(BEFORE, AFTER), (AFTER, (2.7, 7.0))],
        ),
    )
)  # fmt: skip

PLACES = tuple(enumerate(BETAS))

ORBITS = statement(
    "theory_against_orbits", "abstract, 6", "Simulations verify the theory.", DEPENDS,
    "on what is meant by it: theory and orbits agree in kind at all three points that are "
    "simulated, {kinds}; in phase case 1 is {gaps_of_cases[0]:.2f} rad apart, case 2 "
    "{gaps_of_cases[1]:.2f} rad. The map is our extension, and not judged: "
    + ", ".join(
        f"beta = {name}: {{shares[{i}]:.0%}} of classes agree, {{lost[{i}]:.0%}} without a stable "
        f"orbit, median difference {{gaps[{i}]:.2g}} rad"
        for i, name in PLACES
    )
    + "; the dampers of table 1, above all f_phi, which (30) leaves out, shift phases and end "
    "synchronism around n_phi = 1 to 2",
    regions.theory_on_map, regions.theory_against_engine,
    engines=" / ".join(f"{{agree[{i}]:.0%}}" for i, _ in PLACES),
    judgement={
        **corrected(below("gaps_of_cases", AGREE, ours=True)), **depends(equal("same", True)),
    },
    slow=True,
)  # fmt: skip

CONCLUSIONS: tuple[LedgerRow, ...] = (
    statement(
        "springs_and_angle", "abstract, 6",
        "Springs and installation angle decide on existence and stability of synchronism.",
        REPRODUCED,
        "true orbits over n_x and n_phi, with the dampers: "
        + "; ".join(f"beta = {name}: {{shares[{i}]:.0%}}" for i, name in PLACES),
        each=regions.kinds_of_figure_3, engines="{shares:.0%}",
        judgement=holds(*(above(kind, SOME) for kind in ("synphase", "antiphase", "none"))),
        slow=True,
    ),
    statement(
        "critical_conclusion", "6",
        "At beta = pi/2 there is no coupling torque, and so no stable phase.",
        DEPENDS, NO_COUPLING, cases.coupling_of_case_3, judgement=ABSENT, slow=True,
    ),
    statement(
        "screens", "6", "Elliptical vibrating screens may be designed with it.", NOT_TESTABLE,
        "an outlook on use, of which the paper gives no numbers",
    ),
)  # fmt: skip

ROWS: tuple[LedgerRow, ...] = (
    *MODEL,
    *MISPRINTS,
    *THEORY,
    *LEVEL,
    *FIGURE_3,
    ORBITS,
    *RATIO_ROWS,
    *CASE_ROWS,
    *CONCLUSIONS,
    *READINGS,
)

CLOSING_SECTION = "6"

CAUSES: tuple[Cause, ...] = (
    Cause(
        "masses",
        "Stiffnesses and frequency ratios go by the platform's mass and (m_0 + m_3) l^2, where "
        "(15) has all that moves along x and (m + m_3) l^2.",
        (
            "kx_high", "kx_low", "kx_resonance", "kphi_high", "kphi_low",
            "case_1_n_x", "case_1_n_phi", "case_2_n_x",
        ),
    ),
    Cause(
        "damper",
        "(27) leaves out the power that vibration passes on; the rod's damper of table 1 takes "
        "158 W of it in case 2.",
        (
            "equation_27", "theory_against_orbits", "case_2_speed", "case_2_phase",
            "case_2_torque", "case_2_platform_amplitude", "case_2_agreement",
        ),
    ),
    Cause(
        "mu_1",
        "mu_1 is printed with n_x and n_phi swapped; case 2's phase comes by the right one.",
        (
            "mu_1", "mu_1_is_mu_4", "level_mu_1", "equation_34", "level_phase", "level_rod_spring",
            "fig_3c_both", "case_2_theory", "case_1_agreement",
        ),
    ),
    Cause(
        "resonance_strips",
        "Beside resonance, a few per cent of a region, the phase is another one; how much of a "
        "region may be so is not said.",
        ("fig_3b_antiphase", "fig_3b_synphase", "fig_3c_antiphase", "fig_3d_antiphase"),
    ),
    Cause(
        "turning_point",
        "The phase passes pi/2 at n_phi = 1/cos(beta), 2 and 3.86 in figure 3 (c) and (d), where "
        "the text has 1 and 2.7.",
        ("fig_3c_synphase", "fig_3d_synphase"),
    ),
    Cause(
        "critical_point",
        "At beta = pi/2 the denominator of (31) vanishes; (30) and the coupling torque do not.",
        ("critical_point", "critical_conclusion", "case_3_no_coupling"),
    ),
    Cause(
        "motor",
        "(14) is no torque, and the tangent at working speed: the motors' curve from rest is not "
        "given.",
        ("equation_14", "one_motor", "case_1_accelerations", "case_2_resonance_passage"),
    ),
    Cause(
        "sign",
        "Case 1's theoretical phase difference is printed without its sign.",
        ("phase_sign", "case_1_theory"),
    ),
)  # fmt: skip
