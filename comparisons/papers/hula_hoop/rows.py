"""The ledger of the hula_hoop paper, and its figures; here sections 1-5.1.

C. X. Lu, C. C. Wang, C. K. Sung, P. C. P. Chao, J. Vib. Acoust. 133, 014501 (2011).
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ....reference.hula_hoop.equations import SEMICIRCLE, HulaHoop
from ....reference.hula_hoop.floquet import floquet_multipliers
from ....reference.hula_hoop.theory import nondimensional, paper_solution
from ....reference.scene import Array
from ..ledger import (
    CORRECTED,
    DEPENDS,
    ITS_RUN,
    NOT_REPRODUCED,
    NOT_TESTABLE,
    OPEN,
    PRINTED,
    REPRODUCED,
    Cause,
    Condition,
    Judgement,
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
from . import derivation, example, identities, regions
from .example import OMEGA
from .figures import FIGURES as FIGURES
from .identities import IDENTITIES
from .readings import READINGS
from .results import EXAMPLE, LOCKED, LONG_RUN, NATURAL, STABILITIES, grid, stable

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


GOOD = 0.9
"""Share of points from which on two figures are said to agree well."""
MOST = 0.5
"""Share from which on a region is said to be of a kind."""

AGREEMENTS = "; ".join(f"{words} {{{name}:.1%}}" for name, words in reversed(STABILITIES.items()))
BESIDE = ("", "Even the true one does not tell what is reached from rest. ")
"""What hinders the agreement of figures 4 and 5, and of figures 6 and 7."""


def good_agreement(stability: int, verdict: str) -> LedgerRow:
    """Return the row on the agreement of figure 4 with 5, or 6 with 7."""
    motion, plate = stability + 1, stability == 6
    return statement(
        f"good_agreement_{stability}_{motion}", f"5.2, figures {stability}, {motion}",
        f"Figures {stability} and {motion} agree well.", verdict,
        "share of {points} robust points where stable and hula-hoop from rest are both true or "
        f"both false: {AGREEMENTS}. {BESIDE[plate]}{GOOD:.0%} would be good; the same "
        "answer everywhere reaches {trivial:.1%}. On parts of our axes, which are a choice, at "
        "best {parts:.1%}",
        partial(regions.agreements, plate=plate), partial(regions.own_agreement, plate=plate),
        "{printed:.1%}, at best {best:.1%}", "own rotation {share:.1%} of {count} points",
        {
            **holds(Condition("printed", ">=", GOOD, ours=True)),
            **corrected(Condition("best", ">=", GOOD, ours=True)),
            **depends(Condition("parts", ">=", GOOD, ours=True)),
        },
        slow=True,
    )  # fmt: skip


def unstable_regions(figure: int, summary: str, printed: str) -> LedgerRow:
    """Return the row that counts the unstable regions of figure 4 or 6."""
    return number(
        f"unstable_regions_{figure}", f"5.2, figure {figure}", summary, DEPENDS,
        "on axes and grid, which are not given. Connected regions of 2 points or more on ours: "
        "{counts}. On parts of them, every other point, and regions of 1 to 3 points at least, "
        "the corrected ones have {least} to {largest}",
        partial(regions.unstable_regions, plate=figure == 6, printed=printed),
        judgement={
            **holds(Condition("choices", "rounds to", PRINTED)), **depends(above("spread", 0)),
        },
        printed=printed, slow=True,
    )  # fmt: skip


def unstable_below(name: str, summary: str, low: float, high: float) -> LedgerRow:
    """Return the row that compares figures 4 and 6 in a range of natural frequencies."""
    return statement(
        name, "5.2, figures 4, 6", summary, REPRODUCED,
        "unstable points from {low:.2f} to {high:.2f} Hz, of all: printed solution, (55) corrected "
        "{paper[0]:.1%} to {paper[1]:.1%}; true rotation {exact[0]:.1%} to {exact[1]:.1%}",
        partial(regions.unstable_by_inertia, names=("paper", "exact"), low=low, high=high),
        reference="{exact[0]:.1%} to {exact[1]:.1%}",
        judgement=holds(below("changes", 0), above("after", 0)), slow=True,
    )  # fmt: skip


def upper_end(figure: int) -> LedgerRow:
    """Return the row on where region II of figure 4 or 6 ends as the force grows."""
    return statement(
        f"upper_end_{figure}", f"5.2, figure {figure}",
        "Region II, where the approximate solution is stable, ends at region I.", CORRECTED,
        "the force at which the true rotation loses its symmetry at 4.5 to 6 Hz is missed by "
        "{printed:.3g} N ((55) as printed), {paper:.3g} N ((55) corrected), {corrected:.2g} N "
        "(with the phase theta_0), at most; of the plate as far as 260 N, beyond our axis",
        partial(example.distances, plate=figure == 6),
        partial(example.distances_by, plate=figure == 6),
        "{first:.6g} N at 4.5 Hz, {last:.6g} N at 6 Hz",
        "{off:.1g} N off with 80 steps in a period, at most",
        {
            **holds(Condition("printed_share", "<=", 1 - GOOD, ours=True)),
            **corrected(Condition("corrected_share", "<=", 1 - GOOD, ours=True)),
        },
        slow=True,
    )  # fmt: skip


FIGURE_4: tuple[LedgerRow, ...] = (
    statement(
        "stable_zone", "5.2, figure 4", "Region II: the rotation is stable.", CORRECTED,
        "the true rotation is stable at {paper:.0%} of the points where the printed solution is, "
        "and at {corrected:.0%} of those where the one with the phase theta_0 is",
        regions.stable_zone, regions.stable_zone_by, "{share:.0%}", "{share:.0%} where computed",
        {
            **holds(Condition("paper", ">=", GOOD, ours=True)),
            **corrected(Condition("corrected", ">=", GOOD, ours=True)),
        },
        slow=True,
    ),
    upper_end(4),
    upper_end(6),
    unstable_regions(4, "Unstable regions without inertia: I, III, IV, V.", "4"),
    unstable_regions(6, "Unstable regions with inertia: I, III, IV.", "3"),
    statement(
        "region_1_colours", "5.2, figure 4",
        "Region I has points with |u_1| < 0.5 (red o) and with |u_1| >= 0.5 (black o).",
        REPRODUCED,
        "in the largest unstable region of the printed solution, red and black: {printed} with "
        "(55) as printed, {paper} with it corrected",
        regions.colours_of_region_1, reference="{printed} points",
        judgement=holds(above("least", 0)), slow=True,
    ),
    statement(
        "table_6", "figure 6, table",
        "Hula-hoop motion with |u_1| < 0.5 (blue o), none below 0.5 (red o) or from 0.5 on "
        "(black o).",
        REPRODUCED,
        "points of the printed solution that are blue, red, black, and stable from 0.5 on, for "
        "which there is no class: {printed} with (55) as printed, {paper} with it corrected",
        regions.classes_of_figure_6, reference="{printed} points",
        judgement=holds(above("least", 0), equal("others", 0)), slow=True,
    ),
    statement(
        "small_regions_red", "5.2, figure 4",
        "The unstable regions III, IV and V have |u_1| < 0.5 (red o) throughout.",
        DEPENDS,
        "on axes and grid, and on the form of (55) that was drawn. Unstable regions beside region "
        "I, and the largest |u_1| in them: {count}, {largest:.2f} rad (printed solution, (55) "
        "corrected); {printed_count}, {printed_largest:.2f} rad ((55) as printed)",
        regions.small_regions, reference="{largest:.3f} rad",
        judgement={
            **holds(
                below("largest", 0.5), equal("printed_count", 3), below("printed_largest", 0.5)
            ),
            **depends(below("largest", 0.5)),
        },
        slow=True,
    ),
    statement(
        "no_stable_above_half", "5.2, figures 4, 6", "Hula-hoop motion needs |u_1| < 0.5.",
        REPRODUCED,
        "of {large} true rotations of figs. 4 and 6 with |u_1| of 0.5 or more {calm} are stable "
        "({without} of them without inertia), and {hoop} of these keep their sense, as the table "
        "of figs. 5, 7 asks of hula-hoop motion; of {printed} printed solutions {printed_calm} "
        "are stable",
        regions.stable_above_half, reference="{hoop} without reversals",
        judgement=holds(equal("hoop", 0)), slow=True,
    ),
    statement(
        "red_zone", "5.2, figure 4",
        "In the red zone there is no hula-hoop motion though |u_1| < 0.5: the mass reverses.",
        OPEN,
        "of {count} robust points there {none:.0%} have no hula-hoop motion from rest, and "
        "{reversing:.0%} reversals",
        regions.red_zone, reference="{reversing:.0%} with reversals",
        judgement=holds(
            Condition("none", ">=", GOOD, ours=True), Condition("reversing", ">=", GOOD, ours=True)
        ),
        slow=True,
    ),
    statement(
        "larger_reversal", "5.2, figure 4",
        "In the red zone a larger |u_1| means larger reversals.",
        REPRODUCED,
        "rank correlation of |u_1| with the largest backward speed over {known} robust points of "
        "the red zone",
        regions.red_zone, reference="{rank:.2f}",
        judgement=holds(above("rank", 0.5, ours=True)), slow=True,
    ),
    statement(
        "reversal_from_half", "5.2",
        "The oscillation u_1 cos(..) makes the rotation reverse from |u_1| = 0.5 on.",
        REPRODUCED,
        "theta' of (17) is omega (1 - 2 u_1 sin psi), and comes down to {least:.0e} omega at 0.5. "
        "The true rotation, of more harmonics, has reversals at {above:.0%} of the points with u_1 "
        "of 0.5 or more, and at {below:.0%} of the stable ones below",
        regions.reversals_by_u_1, reference="{above:.0%}",
        judgement=holds(below("off", 1e-9)), slow=True,
    ),
    good_agreement(4, OPEN),
)  # fmt: skip

FIGURE_5: tuple[LedgerRow, ...] = (
    statement(
        "class_table", "figures 5, 7, tables",
        "Five classes: rotation at the force's frequency (blue, cyan) or none (red x), with its "
        "oscillation at twice that (blue) or not (cyan), without reversals (o) or with (+).",
        REPRODUCED,
        "each of them is found from rest in fig. 5, points of all: {counts}; in fig. 7: {plate}",
        regions.classes, judgement=holds(above("least", 0)), slow=True,
    ),
    statement(
        "red_x_is_at_rest", "figures 5, 7, tables", "Red x: no rotation on the average.", OPEN,
        "share of its robust points in fig. 5 that turn by less than a tenth of a turn per period "
        "in our window of 120. {locked} points lock at another speed than the force's, for which "
        "the table has no class; what is not periodic may drift to and fro",
        regions.red_x, reference="{share:.0%}",
        judgement=holds(Condition("share", ">=", GOOD, ours=True)), slow=True,
    ),
    statement(
        "region_2", "5.2, figure 5", "In region II hula-hoop motion occurs from rest (blue o).",
        DEPENDS,
        "on the axes, which are not given: on ours at {share:.0%} of the {count} robust points "
        "where the printed solution is stable, and {corrected:.0%} of those where that with the "
        "phase theta_0 is, as beside a stable rotation there are other motions; on parts of our "
        "axes at {parts:.0%} of the latter. Values: all over the figure",
        regions.region_2, partial(regions.share_of_class, name="blue_o"), "{value:.1%}",
        judgement={
            **holds(Condition("share", ">=", GOOD, ours=True)),
            **corrected(Condition("corrected", ">=", GOOD, ours=True)),
            **depends(Condition("parts", ">=", GOOD, ours=True)),
        }, slow=True,
    ),
    statement(
        "region_1", "5.2, figure 5", "In region I there is none (red x).", REPRODUCED,
        "{share:.0%} of the {count} robust points of the largest unstable region of fig. 4; "
        "{reversing:.0%} of these points have reversals; all over the figure",
        regions.region_1, partial(regions.share_of_class, name="red_x"), "{value:.1%}",
        judgement=holds(
            Condition("share", ">=", MOST, ours=True),
            Condition("reversing", ">=", GOOD, ours=True),
        ),
        slow=True,
    ),
    statement(
        "transition", "5.2, figure 5",
        "Between regions I and II the free mass reverses again and again (cyan +).",
        REPRODUCED,
        "{between:.0%} of the {count} such points lie within two cells of both rotation and its "
        "absence; all over the figure",
        regions.transition, partial(regions.share_of_class, name="cyan_plus"), "{value:.1%}",
        judgement=holds(Condition("between", ">=", MOST, ours=True)), slow=True,
    ),
    statement(
        "region_3", "5.2, figure 5",
        "In region III the motion oscillates at another frequency, since hula-hoop motion is "
        "unstable in the steady state (cyan o).",
        CORRECTED,
        "{count} points turn once per period without reversal and oscillate at another frequency. "
        "The solution (16), (17) with the phase theta_0 is unstable at {share:.0%} of them, as "
        "printed at {unstable} = {paper:.0%}. What is seen there is steady, not a "
        "transient: at {first} it repeats in each "
        "period, its symmetry of half a period lost, so that f_u = omega",
        regions.region_3, partial(regions.share_of_class, name="cyan_o"), "{value:.1%}",
        judgement={
            **holds(Condition("paper", ">=", MOST, ours=True)),
            **corrected(Condition("share", ">=", MOST, ours=True)),
        },
        slow=True,
    ),
    statement(
        "transient_hoop", "5.2, figures 5, 7",
        "Cyan o: hula-hoop motion in the transient, and none in the steady state.", DEPENDS,
        "on how long it is to last, and on what it is. As the table has it, at 2 omega, for "
        f"{example.PASSING} and {example.LASTING} periods of the force among the first "
        f"{example.TRANSIENT} from rest: {{both[0]:.0%}} of the {{count}} points of fig. 5, "
        "{both[1]:.0%} of those of fig. 7. In the end none, by this class; but there they all turn "
        "on in one sense, a turn per period, as section 5 has it of the ideal",
        example.transients_of_both, reference="{passing:.0%}, {lasting:.0%}",
        judgement={
            **holds(Condition("lasting", ">=", MOST, ours=True)),
            **depends(Condition("passing", ">=", MOST, ours=True)),
        },
        slow=True,
    ),
    statement(
        "less_accurate", "5.2",
        "The stability of the approximate solutions is less accurate than direct integration.",
        REPRODUCED,
        "stable or not against the true rotation, points of figs. 4 and 6 that differ: "
        "{paper[0]:.0%} and {paper[1]:.0%}",
        regions.wrong_about_stability, reference="{paper[0]:.1%} and {paper[1]:.1%}",
        judgement=holds(above("paper", 0)), slow=True,
    ),
    statement(
        "smooth_if_small", "5.2", "The smaller u_1, the smoother the rotation.", REPRODUCED,
        "rank correlation of u_1 with the drop of the angular velocity below its mean, over the "
        "stable true rotations of figs. 4 and 6",
        regions.smoothness, reference="{ranks:.2f}",
        judgement=holds(above("ranks", 0.9, ours=True)), slow=True,
    ),
    statement(
        "harmonics_are_the_reason", "5.2",
        "Their stability is less accurate because harmonics above alpha in (7) and 2 alpha in (8) "
        "are left out.",
        NOT_REPRODUCED,
        "with the same two harmonics and the phase theta_0 the points that are wrong fall from "
        "{paper[0]:.0%} to {corrected[0]:.0%} (point mass) and from {paper[1]:.0%} to "
        "{corrected[1]:.0%} (plate): the missing phase is the larger part. That "
        "these two terms alone are taken is a reason: the mean of (8), see mean_balance_44, is "
        "left out as well, and it is no high frequency",
        regions.wrong_about_stability, reference="{left[0]:.0%} and {left[1]:.0%} are left",
        judgement=holds(above("left", MOST, ours=True)), slow=True,
    ),
)  # fmt: skip

INERTIA: tuple[LedgerRow, ...] = (
    statement(
        "inertia_shrinks", "5.2, figures 4, 6",
        "With inertia the unstable regions I, III, IV are smaller.",
        REPRODUCED,
        "share of unstable points, without and with inertia: "
        + "; ".join(
            f"{words} {{{name}[0]:.0%}} to {{{name}[1]:.0%}}" for name, words in STABILITIES.items()
        ),
        regions.unstable_by_inertia, reference="{exact[0]:.1%} to {exact[1]:.1%}",
        judgement=holds(below("changes", 0)), slow=True,
    ),
    unstable_below(
        "left_of_region_1",
        "With inertia the left part of region I, which reaches down in figure 4, is smaller.",
        0.5, 1.0,
    ),
    unstable_below(
        "region_3_shrinks", "With inertia the slim region III is smaller.", 0.0, 0.5
    ),
    good_agreement(6, OPEN),
    statement(
        "fewer_red", "5.2, figures 5, 7",
        "With inertia the left part of region I (red x) is smaller.",
        REPRODUCED, f"red x below the natural frequency of {NATURAL:.2f} Hz, of all points",
        each=partial(regions.class_by_inertia, name="red_x", below=NATURAL),
        reference="{shares[0]:.1%} to {shares[1]:.1%}",
        judgement=holds(below("change", 0, everyone=True)), slow=True,
    ),
    statement(
        "region_3_in_7", "5.2, figures 5, 7",
        "With inertia region III (cyan o) is smaller in figure 7 than in figure 5.", DEPENDS,
        "on which cyan o are region III: below half the natural frequency all of them go from "
        "{every[0]} to {every[1]} points, those that repeat in each period, as all but one of "
        "figure 5 do there, from {first[0]} to {first[1]}",
        regions.slow_cyan, reference="{first[0]} to {first[1]} points",
        judgement={**holds(below("every_change", 0)), **depends(below("first_change", 0))},
        slow=True,
    ),
    statement(
        "fewer_cyan", "5.2, figures 5, 7",
        "With inertia there are fewer cyan o in region I.", DEPENDS,
        "on the limits of region I. Points of cyan o in the largest unstable region, without and "
        "with inertia: {counts}. All over the figures they grow more, with inertia {several} of "
        "{count} as rotations that repeat after several periods",
        regions.cyan_in_region_1, partial(regions.class_by_inertia, name="cyan_o"),
        "{shares[0]:.1%} to {shares[1]:.1%} of all points",
        judgement={**holds(below("changes", 0)), **depends(below("least", 0))}, slow=True,
    ),
    statement(
        "easier_with_inertia", "5.2", "Inertia of the free mass helps it to start turning.",
        REPRODUCED, "share of points with hula-hoop motion from rest, without and with inertia",
        each=partial(regions.class_by_inertia, name="blue_o"),
        reference="{shares[0]:.1%} to {shares[1]:.1%}",
        judgement=holds(above("change", 0, everyone=True)), slow=True,
    ),
    statement(
        "adequate", "6",
        "The device can be analysed by the approximate solutions.",
        OPEN,
        "points of figs. 4 and 6 at which they are stable or not as the true rotation is: with the "
        "phase theta_0 {corrected:.0%}, as printed {paper:.0%}; "
        f"{GOOD:.0%} would do",
        regions.right_about_stability, reference="{corrected:.0%}",
        judgement={
            **holds(Condition("paper", ">=", GOOD, ours=True)),
            **corrected(Condition("corrected", ">=", GOOD, ours=True)),
        },
        slow=True,
    ),
    statement(
        "large_set", "6", "The rotation is stable for a large set of frequencies and amplitudes.",
        REPRODUCED,
        "share of the points of figs. 4 and 6 where the true rotation is stable; a quarter would "
        "do",
        each=regions.stable_by_inertia, reference="{shares:.0%}",
        judgement=holds(above("shares", 0.25, ours=True)), slow=True,
    ),
)  # fmt: skip

REGION_ROWS: tuple[LedgerRow, ...] = (*FIGURE_4, *FIGURE_5, *INERTIA)


ROUNDING = 1e-10
"""Relative residual below which an identity holds."""
SMALL = 0.1
"""Relative error that may be called an approximation."""

EQUATIONS: tuple[LedgerRow, ...] = (
    statement(
        "rotation_from_shaking", "abstract, 1",
        "Shaken along a line, the device turns the free mass round, in step with the force.",
        REPRODUCED, "a stable rotation exists at 3 Hz and 60 N",
        each=example.rotation,
        reference="one turn per period, stable: {stable!s}, multiplier {multiplier:.6f}",
        judgement=holds(equal("stable", True, everyone=True)), slow=True,
    ),
    statement(
        "energy_scavenging", "abstract, 6",
        "With coils and magnets it can harvest energy, and the results are design guidelines.",
        NOT_TESTABLE,
        "the equations have no generator; the hinge friction, the only load there is, takes 0.0204 "
        "W of the 4.28 W that the force puts in at 3 Hz and 60 N",
        reference="0.0204 W",
    ),
    statement(
        "better_than_simple", "1",
        "The homotopy perturbation method gives better approximate solutions.",
        DEPENDS,
        "better than which is not said. Than a uniform rotation beside a main mass at rest: y is "
        "off by {y_error:.1%} of its size. Than a uniform rotation whose phase balances the mean "
        "torque: theta is off by up to {error:.2f} rad, that one by {uniform:.2f} rad. To first "
        "order the method is harmonic balance with the mean balance left out",
        derivation.uniform_rotation, reference="{error:.2f} rad",
        judgement={**holds(below("ratio", 1)), **depends(below("y_error", 1))},
    ),
    statement(
        "energies", "equations (1), (2)", "Kinetic and potential energy.",
        REPRODUCED,
        "both lines of (1), with and without the plate's inertia, against the scene's energy at "
        "16 random states: off by {error:.0e}",
        IDENTITIES["energies"], judgement=holds(below("error", ROUNDING)),
    ),
    statement(
        "lagrange", "2, (3)-(8)",
        "Lagrange's equations with (1), (2) and the forces, the equations of motion, and their "
        "nondimensional form.",
        REPRODUCED,
        "what the scene's accelerations leave at 16 random states, over the largest terms, with "
        "and without the plate's inertia: {errors:.0e}",
        IDENTITIES["lagrange"], judgement=holds(below("largest", 1e-9)),
    ),
    statement(
        "equations_of_motion", "2, (7), (8)",
        "The nondimensional equations of the two masses.",
        REPRODUCED, "(7), (8) hold to {error:.1g} at {count} random states",
        each=identities.equations_of_motion,
        reference="residual of (7), (8) {error:.1g}", engines="accelerations off by {error:.1g}",
        judgement=holds(below("error", 1e-8, everyone=True)),
    ),
    number(
        "plate_inertia", "2, below (8)", "Inertia ratio I_eq of the semicircular plate.",
        REPRODUCED,
        "hinged at the middle of its straight edge, its centre of mass at R_m: {ratio:.5f} by "
        f"quadrature, 9 pi^2/32 - 1 = {SEMICIRCLE:.5f}",
        derivation.plate_inertia, reference="{ratio:.5f}",
        judgement=holds(below("error", ROUNDING)), printed="9 pi^2/32 - 1",
    ),
)  # fmt: skip

SOLUTIONS: tuple[LedgerRow, ...] = (
    statement(
        "homotopy", "equations (9)-(15), (18), (19), (21), (22), (38), (39)",
        "The homotopy, what it is at p = 0 and p = 1, and its first two orders in p.", REPRODUCED,
        "(10), (11) with random values, (12), (13), and (21), (22) as the first two orders of (14) "
        "with (18); with (19), (38) and (39) as those of (15), which has the same form, its N of "
        "both arguments, see arguments_15: apart by {error:.0e}",
        derivation.homotopy, judgement=holds(below("error", ROUNDING)),
    ),
    statement(
        "linear_terms", "equations (16), (17), (23), (32), (40), (42)",
        "The zeroth order is the trial motion, and so are the linear terms of (32) and (42).",
        REPRODUCED,
        "linear terms of (7), (8) along (23), (40) against those of (32), (42), which are said to "
        "be of (16), (17): off by {error:.0e}; so they solve (21), (38)",
        IDENTITIES["linear_terms"], judgement=holds(below("error", ROUNDING)),
    ),
    statement(
        "products", "equations (24), (29)",
        "theta'^2 sin(theta) and theta'' cos(theta) along the trial motion, multiplied out.",
        REPRODUCED,
        "three lines of each, against the motion and its derivatives: off by {error:.0e}; the last "
        "line of (24) with sin(alpha tau) cos(...) and alpha^2, which our copy has lost",
        IDENTITIES["products"], judgement=holds(below("error", ROUNDING)),
    ),
    statement(
        "bessel_26", "equation (26)", "Series of the Bessel functions.", REPRODUCED,
        "ten terms, J_0 to J_5: off by {error:.0e}",
        identities.bessel_series, judgement=holds(below("error", ROUNDING)),
    ),
    statement(
        "expansions", "equations (28), (31), (32), (42), (44)",
        "Harmonics of the nonlinear terms of (7) and (8), and the mean torque.", REPRODUCED,
        "(28) and (31), of which (32) is made, and (42), with its mean (44), against the harmonics "
        "of a motion of the form (16), (17): off by {errors:.0e}",
        IDENTITIES["expansions"], judgement=holds(below("largest", ROUNDING)),
    ),
    statement(
        "ansatz_harmonics", "3.2, (16), (17)",
        "The main mass moves at the frequency of the force, the angle oscillates at twice that.",
        REPRODUCED,
        "of the true rotation at 3 Hz and 60 N: y has odd harmonics alone, theta even ones",
        each=example.rotation,
        reference="next harmonic of y {rest:.2%}, of theta {theta:.2%}",
        judgement=holds(below("other", SMALL, ours=True)),
    ),
    statement(
        "no_even_harmonics", "3.2, below (27) and (30)",
        "The nonlinear terms of (7) have no harmonic at twice the frequency.",
        REPRODUCED,
        "nor any other even one: half a turn of theta in half a period turns their signs; share "
        "{share:.1g}",
        derivation.even_harmonics, reference="{share:.1g}",
        judgement=holds(below("share", ROUNDING)),
    ),
    statement(
        "bessel_27", "equation (27), below (32)",
        "For |u_1| < 0.5 J_n is about u_1^n/(2^n n!); J_0 is about 1, J_1 u_1/2, J_2 and J_3 0.",
        REPRODUCED, "errors at |u_1| = 0.5: {errors:.1%}",
        identities.bessel, reference="{largest:.1%}",
        judgement=holds(below("largest", SMALL, ours=True)),
    ),
    statement(
        "secular_terms", "3.2, below (34) and (45)",
        "Coefficients are set to zero since secular terms would follow in the next iteration.",
        REPRODUCED,
        "(34) itself stays bounded, but its cos(tau) and sin(tau) are at the frequency of q'' + "
        "q: put into 2 rho q', they make the next correction grow, {growth:.2f} times as large "
        "at the end of 3000 periods as at half. For theta, which has no spring, (45) has these "
        "terms by its kernel only; what is set to zero there is harmonic balance",
        derivation.secular_terms, judgement=holds(above("growth", 1.5)),
    ),
    statement(
        "dropped_torque_43", "3.2, (43)-(47)",
        "Terms of second order in u_1 can be ignored while |u_1| < 0.5.",
        OPEN,
        "how small is small is not said. With theta_0 = 0 and every term kept u_1 changes by "
        "{median:.1%} in the median of the points with |u_1| < 0.5 of fig. 4, by less than a tenth "
        "at {within:.0%} of them, and by {largest:.0%} at worst, at resonance",
        derivation.dropped_torque, reference="{median:.1%}",
        judgement=holds(above("within", GOOD, ours=True)),
    ),
    statement(
        "solution_34", "equation (34)", "Correction of the main mass's motion.", REPRODUCED,
        "but for damping, which (22) has not: put into (22), and at rest at the start, off by "
        "{error:.0e}",
        IDENTITIES["solution_34"], judgement=holds(below("error", ROUNDING)),
    ),
    statement(
        "approximation_37", "equations (37), (48)",
        "The approximations of first order are the trial motions (16), (17) themselves.",
        REPRODUCED,
        "where the balances (35), (36), (46), (47) are met (34) leaves {of_q:.0e} of q_1, and (45) "
        "{of_theta:.0e} of u_1, for the plate at 3 Hz and 60 N, so that V_0 is the sum. (45) has "
        "the harmonics alone; of the mean torque (44), which is not met, see mean_balance_44",
        identities.approximations,
        judgement=holds(below("of_q", ROUNDING), below("of_theta", ROUNDING)),
    ),
    statement(
        "first_order", "equations (33), (36), (43), (46), (47)",
        "Balances of the harmonics to first order in the amplitudes.", REPRODUCED,
        "against the harmonics of (7), (8) at amplitudes of 1e-6, over these: off by {errors:.0e}. "
        "(36) is the cosine of (33), whose sine is in lost_term_35; (46), (47) are the brackets of "
        "(43)",
        IDENTITIES["first_order"], judgement=holds(below("largest", 1e-5)),
    ),
    statement(
        "closed_form", "equations (49)-(52)", "The four unknowns in closed form.", REPRODUCED,
        "largest residual over the grids of figs. 4 and 6: {residual:.1g}; the branch of the "
        "arctangent does not matter",
        derivation.closed_form, reference="{residual:.1g}",
        judgement=holds(below("residual", ROUNDING)),
    ),
)  # fmt: skip

STABILITY: tuple[LedgerRow, ...] = (
    statement(
        "coefficients_57", "equations (53)-(61)",
        "The perturbed motion, and its linear equations with their coefficients.", REPRODUCED,
        "(53), (54) put into (7), (8), against (55), with theta~'' after p_1, and (56): off by "
        "{error:.0e}; see variational_55",
        IDENTITIES["coefficients_57"], judgement=holds(below("error", ROUNDING)),
    ),
    statement(
        "newton", "4", "Newton's method makes the approximate solutions accurate.", DEPENDS,
        "on the equations that it is used for, which are not told. The closed form solves those "
        "printed. On the untruncated ones theta is off by {refined_theta:.2f} rad, as without "
        "Newton ({paper_theta:.2f} rad); with (44) and a phase theta_0 by {corrected_theta:.3f} "
        "rad",
        example.errors_of_solutions, reference="{refined_theta:.2f} rad",
        judgement={
            **holds(below("left", 0.5)), **depends(below("left_with_phase", 0.5)),
        },
    ),
    statement(
        "unstable_not_seen", "4",
        "With a multiplier above 1 the rotation cannot be observed in the steady state.",
        REPRODUCED,
        "of {total} robust points of fig. 5 with a periodic hula-hoop motion {exact} lie where the "
        "true rotation is unstable, and {paper} where the printed solution is; {more} more have "
        "blue o without repeating in each period",
        derivation.unstable_seen, derivation.unstable_seen_by, "{count} of {total} points",
        judgement=holds(equal("exact", 0)), slow=True,
    ),
    statement(
        "stable_appears", "4", "With all multipliers below 1 hula-hoop motion will appear.",
        DEPENDS,
        "on the start, which is not told there: from starts beside a stable rotation it does, by "
        "multipliers of {multiplier:.4f} at most. From rest, as in table 1, {share:.0%} of {total} "
        "robust points with a stable true rotation end elsewhere ({kinds})",
        derivation.stable_elsewhere, reference="{share:.0%} elsewhere",
        judgement={**holds(equal("share", 0)), **depends(below("multiplier", 1))}, slow=True,
    ),
)  # fmt: skip

EXAMPLE_ROWS: tuple[LedgerRow, ...] = (
    number(
        "mass_ratio", "table 1", "Mass ratio m/(M + m).", REPRODUCED, "1/11, rounded",
        lambda session: {"value": float(nondimensional(HulaHoop()).epsilon)}, printed="0.09",
    ),
    statement(
        "main_mass_harmonic", "5.1, figures 2(a), 3(a)",
        "The main mass moves harmonically at the frequency of the force.",
        REPRODUCED,
        "at the frequency of the force; all other harmonics are below {rest:.1%} of it. The "
        "printed solution gives {paper:.2f} mm",
        example.printed_solution, example.rotation, "{first:.4f} mm",
        judgement=holds(below("rest", 0.05, ours=True)),
    ),
    statement(
        "mean_slope", "5.1, figures 2(b), 3(b)",
        "The free mass turns on in one sense, on the average at the frequency of the force.",
        REPRODUCED, f"mean slope omega = {OMEGA:.5f} rad/s",
        each=example.rotation, reference="{speed:.5f} rad/s",
        judgement=holds(below("off", 1e-9, everyone=True)),
    ),
    statement(
        "speed_varies", "5.1, figures 2(c), 3(c)", "Its angular velocity is not constant.",
        REPRODUCED,
        f"in the last period of {LONG_RUN:.0f} s from rest; by the printed solution "
        "{slowest:.1f} to {fastest:.1f} rad/s",
        example.printed_solution, example.motion_from_rest, "{slow:.2f} to {fast:.2f} rad/s",
        judgement=holds(above("width", 0.1, ours=True), above("slow", 0)),
    ),
    statement(
        "doubled_frequency", "5.1",
        "The oscillation of the rotation has twice the frequency of the main mass.",
        REPRODUCED,
        "largest peak of the spectrum of theta' over the last 12 periods from rest; u_1 is "
        "{second:.4f} rad, by the printed solution {u_1:.4f} rad",
        example.printed_solution, example.motion_from_rest, "{ratio:.3f} omega",
        judgement=holds(below("off", 0.02, everyone=True)),
    ),
    number(
        "transient_end", "5.1, figure 3", "End of the transient from rest.", OPEN,
        "by the last reversal, as the paper does not say what ends it; the last slip by half a "
        "turn is at {slip:.2f} s, and the phase stays within 0.5 rad of its end from "
        "{settled:.2f} s on",
        each=example.motion_from_rest, printed="1.5 s",
        judgement=holds(Condition("value", "rounds to", PRINTED, ours=True)),
    ),
    statement(
        "locked_by_then", "5.1, figure 3", "After 1.5 s hula-hoop motion has set in.", REPRODUCED,
        "the last slip by half a turn; from then on one turn per period",
        each=example.motion_from_rest, reference="{slip:.2f} s",
        judgement=holds(below("slip", 1.5, everyone=True), below("turns", LOCKED, everyone=True)),
    ),
    statement(
        "transient_reverses", "5.1, figure 3",
        "The angular velocity oscillates in the transient; in the steady state it keeps its sign.",
        REPRODUCED, "least angular velocity of the last period, by omega, after reversals before",
        each=example.motion_from_rest, reference="{least:.4f}",
        judgement=holds(above("value", 0, everyone=True), above("least", 0, everyone=True)),
    ),
    statement(
        "figures_2_and_3", "5.1",
        "Figures 2 and 3 agree and confirm model, equations and solution.",
        CORRECTED,
        "the printed solution misses the true rotation by up to {paper:.1f} mm and "
        "{paper_theta:.2f} rad: y is fair, the phase of theta is not. With the phase theta_0 "
        "it is {corrected:.1f} mm and {corrected_theta:.3f} rad",
        example.errors_of_solutions, reference="{paper_theta:.3f} rad",
        judgement={
            **holds(
                below("paper_share", 0.05, ours=True), below("paper_theta", 0.1, ours=True)
            ),
            **corrected(
                below("corrected_share", 0.05, ours=True), below("corrected_theta", 0.1, ours=True)
            ),
        },
    ),
    statement(
        "example_is_stable", "4, 5.1",
        "The rotation of figure 2 is stable, and so seen in the steady state of figure 3.",
        REPRODUCED,
        "by (55) as printed, whose multiplier is {printed:.3f}, though two errors cancel there: "
        "with (55) corrected the printed solution has {paper:.3f}, and with the phase theta_0 too "
        "{corrected:.3f}",
        example.multipliers, example.rotation, "{multiplier:.6f}",
        judgement={
            **holds(equal("stable", True, everyone=True), below("printed", 1)),
            **corrected(equal("stable", True, everyone=True), below("corrected", 1)),
        },
    ),
)  # fmt: skip

ROWS: tuple[LedgerRow, ...] = (
    *EQUATIONS,
    *MISPRINTS,
    *SOLUTIONS,
    *STABILITY,
    *EXAMPLE_ROWS,
    *REGION_ROWS,
    *READINGS,
)

CLOSING_SECTION = "6"

CAUSES: tuple[Cause, ...] = (
    Cause(
        "phase",
        "theta has no constant phase, since the mean torque balance (44) is not used; with both, "
        "two harmonics are enough for most of what the paper says.",
        (
            "mean_balance_44", "newton", "figures_2_and_3", "stable_zone", "upper_end_4",
            "upper_end_6", "region_3", "harmonics_are_the_reason", "good_agreement_4_5", "adequate",
        ),
    ),
    Cause(
        "from_rest",
        "From rest other motions are reached beside a stable rotation.",
        ("red_zone", "stable_appears"),
    ),
    Cause(
        "variational_55",
        "(55) is printed with theta~' for theta~''; which form figures 4 and 6 were drawn with "
        "cannot be told.",
        ("variational_55", "small_regions_red"),
    ),
    Cause(
        "axes",
        "Axes and grid of figures 4 to 7 are not given: regions are counted, measured and marked "
        "off by ours.",
        (
            "unstable_regions_4", "unstable_regions_6", "region_2", "good_agreement_6_7",
            "fewer_cyan",
        ),
    ),
)  # fmt: skip
