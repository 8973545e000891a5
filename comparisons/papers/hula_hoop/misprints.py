"""Misprints of the hula_hoop paper: what a formula gives as printed, and put right."""

from __future__ import annotations

import numpy as np

from ....reference.hula_hoop.equations import HulaHoop
from ....reference.hula_hoop.floquet import floquet_multipliers
from ....reference.hula_hoop.theory import nondimensional, paper_solution
from ....reference.scene import Array
from ..ledger import (
    CORRECTED,
    ITS_RUN,
    Judgement,
    LedgerRow,
    Numbers,
    above,
    below,
    corrected,
    misprint,
)
from ..session import Session
from . import derivation, example
from .identities import IDENTITIES
from .results import EXAMPLE, grid, stable

TESTS = "tests/comparisons/papers/hula_hoop/test_misprints.py::"
THEORY_TESTS = "tests/reference/hula_hoop/test_theory.py::"


def misses(within: float) -> Judgement:
    """Return that as printed a formula misses an identity, and is within a bound corrected."""
    return corrected(below("corrected", within), below("share", 0.1))


def restored(p: HulaHoop) -> Array:
    """Return |u_1| (2, ...) of (35), (36), (46), (47), without and with what (35) has lost."""
    c = nondimensional(p)
    stiffness, damping = 1 - c.alpha**2, 2 * c.rho * c.alpha
    inertial, inertia = c.epsilon * c.alpha**2, 4 * c.alpha**2 * c.inertia
    friction, half = 2 * c.zeta_m * c.alpha, c.alpha**2 / 2
    sizes = []
    for lost in (0.0, inertial / 2):
        rows = (  # unknowns q_1 cos beta, q_1 sin beta, u_1 cos gamma, u_1 sin gamma
            (-damping, stiffness, 0, -lost),
            (stiffness, damping, -inertial / 2, 0),
            (0, -half, -friction, -inertia),
            (-half, 0, -inertia, friction),
        )
        shape = np.broadcast_shapes(np.shape(c.alpha), np.shape(c.force))
        matrix = np.array([[np.broadcast_to(value, shape) for value in row] for row in rows])
        right = np.array([np.broadcast_to(v, shape) for v in (inertial, c.force, 0, 0)])
        x = np.linalg.solve(
            np.moveaxis(matrix, (0, 1), (-2, -1)), np.moveaxis(right, 0, -1)[..., None]
        )
        sizes.append(np.hypot(x[..., 2, 0], x[..., 3, 0]))
    return np.array(sizes)


# The rows


def lost_term(session: Session) -> Numbers:
    """Return what (35) leaves of an identity, and by how much what it has lost changes u_1."""
    changes = []
    for p in (EXAMPLE, grid(session, False)):
        without, with_it = restored(p)
        changes.append(float(np.max(np.abs(with_it / without - 1))))
    return {**IDENTITIES["lost_term_35"](session), "changes": changes}


def misprint_of_55(session: Session) -> Numbers:
    """Return what (55) leaves of an identity, and what it changes of multipliers and figure 4."""
    solution = paper_solution(EXAMPLE)
    multipliers = [
        float(abs(floquet_multipliers(solution, EXAMPLE, as_printed)[0]))
        for as_printed in (True, False)
    ]
    shares = [float(np.mean(stable(session, False, name))) for name in ("printed", "paper")]
    return {**IDENTITIES["variational_55"](session), "multipliers": multipliers, "shares": shares}


OFF = "off by {as_printed:.3g} as printed, by {corrected:.0e} corrected"

MISPRINTS: tuple[LedgerRow, ...] = (
    misprint(
        "lost_dots", "2, (4) and the text below the sketch",
        "The velocity of the free mass has theta for theta', the damper's force y for y'.",
        CORRECTED, "velocity of cos(theta): " + OFF,
        IDENTITIES["lost_dots"], judgement=misses(1e-8),
        corrected="x_f' = -R_m theta' sin(theta), y_f' = y' + R_m theta' cos(theta), Theta = F "
            "cos(omega t) - c y'",
        why="they are derivatives, and a damper resists a speed; (1) and (5) have the dots",
        effect="none",
        copy="a copy loses dots easily",
    ),
    misprint(
        "square_25", "equation (25)", "The mixed term of the square of theta' has no alpha.",
        CORRECTED, "square of theta': " + OFF,
        IDENTITIES["square_25"], judgement=misses(1e-10), printed="-2 u_1 f_u",
        corrected="-2 alpha u_1 f_u sin(f_u tau - gamma)",
        why="theta' is alpha - u_1 f_u sin(f_u tau - gamma); (24) and (28) have the alpha",
        effect="none: (28) is right",
        copy="a letter may have been lost, twice",
    ),
    misprint(
        "expansion_30", "equation (30)",
        "The second bracket of theta'' cos(theta) lacks sin(alpha tau), J_1 and J_3.",
        CORRECTED,
        "theta'' cos(theta): off by {corrected:.0e} corrected; almost surely a fault of our copy",
        IDENTITIES["expansion_30"], judgement=misses(1e-5),
        corrected="... - [-u_1 f_u^2 cos psi] sin(alpha tau) [2 J_1 cos psi - 2 J_3 cos 3 psi + 2 "
            "J_5 cos 5 psi - ...], psi = f_u tau - gamma",
        why="it is (29) with Neumann's expansion, as (25) has it",
        effect="none: (31) is right",
        copy="a line of the formula is lost, almost surely in our copy alone",
    ),
    misprint(
        "second_order_20", "equation (20)",
        "The term with p^2 has the nonlinear terms at V_1 alone.",
        CORRECTED, "second order in p of (14) with (18), at random values: " + OFF,
        derivation.second_order, judgement=misses(1e-5),
        printed="p^2 [L(V_2q) + N(V_1theta)]",
        test=ITS_RUN,
        corrected="p^2 [L(V_2q) + N'(V_0theta) V_1theta]",
        why="N is not linear: its first change is its derivative at V_0",
        effect="none: the paper stops at the first order",
    ),
    misprint(
        "arguments_15", "equations (15), (39)",
        "The nonlinear term of (8) is N(V_thetatheta).", CORRECTED,
        "it is q'' cos(theta), of both; by theta alone it would not be driven by the main mass. "
        "So put right, (15) with (19) has the orders (38), (39), see homotopy",
        printed="N(V_thetatheta)",
        test=TESTS + "test_the_nonlinear_term_of_8_has_both_arguments",
        corrected="N(V_q, V_theta)",
        why="below (40) the paper says that it is q'' cos(theta)",
        effect="none: (41), (42) have both",
        copy="an index may have been read wrongly",
    ),
    misprint(
        "lost_term_35", "equations (33), (35)",
        "The sine of the force balance of the main mass lacks a term in u_1.",
        CORRECTED,
        "sine harmonic of (7): " + OFF + "; change of u_1: 3 Hz, 60 N {changes[0]:.2%}, fig. 4 at "
        "most {changes[1]:.2%}",
        lost_term, judgement=misses(1e-4),
        test=THEORY_TESTS + "test_sympy_derives_the_printed_conditions_and_what_they_drop",
        corrected="(1 - alpha^2) q_1 sin(beta) - 2 rho q_1 alpha cos(beta) - eps alpha^2 - eps "
            "alpha^2 u_1 sin(gamma)/2 = 0",
        why="(28) and (31) have it; its twin with cos(gamma) stands in (36)",
        effect="u_1 changes by less than 2 % in figure 4",
    ),
    misprint(
        "product_41", "equation (41)", "The harmonics of q'' cos(theta) are not those of (42).",
        CORRECTED,
        "coefficient of cos(2 alpha tau): off by {corrected:.0e} corrected; almost surely a fault "
        "of our copy",
        IDENTITIES["product_41"], judgement=misses(1e-10),
        corrected="cos(2 alpha tau) (-q_1 f_q^2)/2 [J_0 cos(-beta) - J_2 cos(beta - 2 gamma) + "
            "J_1 sin(-beta - gamma) - J_1 sin(beta - gamma)] + (-q_1 f_q^2)/2 [J_0 cos(-beta) + "
            "J_1 sin(beta - gamma)]",
        why="as (42) has it",
        effect="none: what follows starts from (42)",
        copy="a sine was read as a 2, almost surely in our copy alone",
    ),
    misprint(
        "mean_balance_44", "equations (17), (44), (48)",
        "The mean torque balance is derived, then not used; theta has no constant phase.",
        CORRECTED,
        "five conditions for four unknowns: with theta_0 = 0 the mean torque is off by "
        "{paper:.0f} times the friction; with theta_0 = {phase:.2f} rad and (44) it is balanced, "
        "and the largest error of theta falls {gain:.0f} times",
        derivation.mean_balance, example.rotation,
        "theta_0 = {phase:.3f} rad", "mean of theta - omega t: {mean_phase:.3f} rad",
        corrected(below("corrected", 1e-9), above("paper", 1), above("gain", 10)),
        test=THEORY_TESTS
            + "test_closed_form_solves_its_own_four_equations_but_not_the_torque_balance",
        corrected="theta = theta_0 + alpha tau + u_1 cos(2 alpha tau - gamma), with (44) as the "
            "fifth condition",
        why="an error of reasoning, not of print: the rotation is driven by the mean of q'' "
            "cos(theta), which only a phase can make equal to the friction",
        effect="amplitudes are fair, the phase of theta and the stability of figures 4 and 6 are "
            "not",
    ),
    misprint(
        "kernel_45", "equation (45)",
        "The correction of theta has the kernel and the denominator of an angle with a spring.",
        CORRECTED,
        "(39) with the L of (42): " + OFF + ". Its twin (34), of the main mass, which has a "
        "spring, is right but for damping",
        IDENTITIES["kernel_45"], judgement=misses(1e-10),
        corrected="V = -(1 + I_eq)^-1 times the integral of [1 - exp(-d (tau - t))]/d times the "
            "torque, with d = zeta_m/(1 + I_eq)",
        why="(8) has inertia and friction, and no term in theta alone",
        effect="none: (46), (47) set the harmonics themselves to zero",
    ),
    misprint(
        "variables_34", "equations (34), (45)",
        "The integrals are called functions of t, (34) has a second dt, and (45) no sign between "
        "the two brackets.",
        CORRECTED,
        "integrated over t from 0 to tau they are functions of tau. A product of (45)'s brackets "
        "would be of second order in q_1 and u_1",
        printed="V_1q(t), sin(alpha t) dt, ] [",
        test=TESTS + "test_34_and_45_are_sums_and_functions_of_tau",
        corrected="V_1q(tau) = integral over t from 0 to tau of sin(t - tau) {... sin(alpha t) + "
            "...} dt; [...] [2 alpha sin(tau) - sin(2 alpha tau)] + [...] [cos(tau) - cos(2 alpha "
            "tau)]",
        why="the integrand is a sum, and so is its integral",
        effect="none: both brackets are set to zero",
        copy="a sign may have been lost",
    ),
    misprint(
        "source_of_bessel", "3.2, below (43)",
        "J_0 = 1 and J_1 = u_1/2 are said to come from (25).", CORRECTED,
        "(25) has J_0 to J_5 as they are; (27) simplifies them, as is said below (41)",
        printed="(25)",
        test=TESTS + "test_the_bessel_functions_are_simplified_in_27",
        corrected="(27)",
        why="(27) gives 1 for n = 0, and u_1/2 for n = 1",
        effect="none",
        copy="a digit may have been read wrongly",
    ),
    misprint(
        "force_symbols", "2, (7), (36), (51)",
        "F_eq is the force over time in (7), and its amplitude in (36) and (51).", CORRECTED,
        "with F_eq = F cos(alpha tau)/((M + m) R_m omega_n^2), as below (8), (36) would change in "
        "time; (34) has the amplitude, with R for R_m, and F_eqa for its force",
        printed="F_eq, F_eqa",
        test=TESTS + "test_36_has_the_amplitude_of_the_force",
        corrected="F/((M + m) R_m omega_n^2) in (36) and (51)",
        why="(36) is the harmonic of cos(alpha tau) in (7)",
        effect="none",
    ),
    misprint(
        "variational_55", "equation (55)",
        "The first coupling term of the perturbed main mass has theta~' for theta~''.",
        CORRECTED,
        "linearisation of (7): " + OFF + "; the printed solution at 3 Hz and 60 N has the "
        "multiplier {multipliers[0]:.3f} with it, and {multipliers[1]:.3f} without; in fig. 4 "
        "{shares[0]:.0%} of the points are stable with it, and {shares[1]:.0%} without",
        misprint_of_55, reference="{multipliers[1]:.3f}", judgement=misses(1e-8),
        printed="p_1 theta~'", slow=True,
        test=THEORY_TESTS + "test_misprint_in_55_changes_the_verdict",
        corrected="q~'' + 2 rho q~' + q~ + p_1 theta~'' + p_2 theta~' + p_3 theta~ = 0",
        why="p_1 = eps cos(theta_b) is the factor of theta'' in (7), and p_2 has its own term",
        effect="which form figures 4 and 6 were drawn with cannot be told; with the printed one "
            "the solution of section 5.1 is stable, as the text says, corrected it is not",
        copy="a prime may have been lost",
    ),
    misprint(
        "eigenvalues_62", "equation (62)",
        "The matrix A(tau) is called the transition matrix whose eigenvalues decide on stability.",
        CORRECTED,
        "A(tau) has an eigenvalue above 1 in modulus for {above:.0%} of the period though the "
        "rotation is stable; those of the transition matrix over a period decide: {largest:.4f}, "
        "of the true rotation {multiplier:.4f}",
        derivation.eigenvalues, example.rotation, "{multiplier:.6f}",
        judgement=corrected(above("above", 0), below("largest", 1), below("multiplier", 1)),
        test=ITS_RUN,
        corrected="Phi(T) of Phi' = A(tau) Phi, Phi(0) = 1, T = 2 pi/alpha",
        why="Floquet's theorem, which the paper cites",
        effect="of words, as it says that the matrix is computed over one period",
    ),
    misprint(
        "symbols_of_damping", "2, (8), table 1",
        "The damping ratio of the hinge has several symbols.", CORRECTED,
        "our reading, and no proof of an error: xi in (8), s below it and in (42), (46), (47), a "
        "final sigma in (43)-(45) and (56), C in table 1, each with the index m; read as one",
        printed="xi_m, s_m, C_m",
        test="tests/comparisons/papers/hula_hoop/test_readings.py::test_units_of_the_damping",
        corrected="s_m = c_m/(m R_m^2 omega_n) throughout",
        why="(8) is (6) over m R_m^2 omega_n^2",
        effect="none, but that the unit of table 1's entry is told by the motion alone",
        copy="a zeta, a final sigma and an s look alike",
    ),
)  # fmt: skip
