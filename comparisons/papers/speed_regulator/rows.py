"""The ledger of the speed_regulator paper, and its figures.

S. Vlase, M. Mihalcica, M. L. Scutaru, "Determining the Functional Parameters of a Simple Speed
Regulator" (2018).
"""

from __future__ import annotations

from ..ledger import (
    CORRECTED,
    NOT_TESTABLE,
    REPRODUCED,
    Cause,
    Erratum,
    LedgerRow,
    above,
    below,
    corrected,
    equal,
    holds,
    misprint,
    number,
    statement,
)
from . import derivation, motions
from .derivation import averages
from .figures import FIGURES as FIGURES
from .motions import AWAY, BRAKING, CLOSE, INERTIAS
from .readings import READINGS
from .results import EXAMPLE, STARTS, TORQUE

TESTS = "tests/comparisons/papers/speed_regulator/test_misprints.py::"
IDENTITY_TEST = TESTS + "test_printed_formula_misses_an_identity_and_the_corrected_one_holds"
EQUATION_TESTS = "tests/reference/speed_regulator/test_equations.py::"

ROUNDING = 1e-12

DERIVATION: tuple[LedgerRow, ...] = (
    statement(
        "one_degree_of_freedom", "abstract, 2",
        "The mechanism has one degree of freedom.",
        REPRODUCED,
        "crank, rod and slider as three bodies with joints follow the one equation: difference "
        "of the crank angle over 10 s from 8 rad/s",
        each=derivation.crank_angle_error,
        reference="exact by construction", engines="{value:.1g} rad",
        judgement=holds(below("value", 0.1, everyone=True)), slow=True,
    ),
    statement(
        "numerical_only", "1",
        "Its equations can be solved numerically only, and give no quick qualitative conclusions.",
        NOT_TESTABLE,
        "what is quick is a matter of judgement; no closed form with a damper is known to us. "
        "Without one the energy integral has phi' over phi; with one, phi'^2 over phi obeys an "
        "equation of first order, from which follow at most one rotation, its stability, and, for "
        "weak damping, by a quadrature, the least torque: 0.05262 N m, the solution 0.05261 N m",
        reference="0.05261 N m",
    ),
    statement(
        "slow_variation", "1",
        "Amplitude and speed vary slowly, so that averaging applies.",
        REPRODUCED,
        "of a deviation from the limit cycle, {lost:.1%} is lost in a turn for c = 2, 3, 4; near "
        "the least torque, where a turn takes long, the premise fails",
        motions.limit_cycles, reference="{lost:.1%}", judgement=holds(below("lost", 0.2)),
    ),
    statement(
        "frictionless_turns", "2",
        "Without friction the constant torque makes the crank faster, from turn to turn.",
        REPRODUCED,
        "a crank that turns gains the motor's work, 2 pi M_m in every turn (balance off by "
        "{error:.0e}). Within a turn the speed falls for {falls:.0%} of the time, with the spring "
        "and the moment of inertia",
        derivation.work_without_friction, derivation.slowest_gain,
        "slowest gain {value:.4f} rad/s per turn",
        judgement=holds(above("value", 0, everyone=True)), slow=True,
    ),
    statement(
        "kinematics", "equations (1)-(12)",
        "Links are holonomic; speeds and accelerations follow from the crank's.",
        REPRODUCED,
        "speeds and accelerations of all bodies are the derivatives of their positions to "
        "{error:.0e}, at two ratios lambda",
        derivation.kinematic_error, derivation.opening,
        "{error:.0e}", "loop open by up to {opening:.1g} m",
        holds(below("error", ROUNDING)), slow=True,
    ),
    misprint(
        "dots_of_12", "equations (12), (13)",
        "Left-hand sides: y_B (and y_C) with one dot.",
        CORRECTED,
        "the right-hand side is the second derivative of y_B: off by 1.2 as printed, by 0 "
        "corrected",
        printed="y_B'",
        test=IDENTITY_TEST,
        corrected="{eps_1, x_C'', y_C'', eps_2, y_B''} on the left",
        why="the right-hand sides of (12) are accelerations",
        effect="none: the matrix of (13) multiplies the right ones",
        copy="a lost dot would look the same",
    ),
    statement(
        "slider_forces", "2, above (13)",
        "Damper and spring on the slider, c y_B' and k (y_B - y_0), over the crank angle.",
        REPRODUCED,
        "with the spring at rest where y_B = -l: against derivatives of the energy and of the "
        "dissipation that the scene has, off by {error:.0e}",
        derivation.slider_forces, judgement=holds(below("error", ROUNDING)),
    ),
    misprint(
        "slider_equation", "2, above (13)",
        "Momentum of the slider, along x and with a reaction at C.",
        CORRECTED,
        "the slider, B, stays at x = 0 and moves along y: m y_B'' = -F_a - F_e - Y_B, as in (13): "
        "off by 1 as printed, by 2e-16 corrected",
        printed="m x_B'' = ... - Y_C",
        test=IDENTITY_TEST,
        corrected="m y_B'' = -F_a - F_e - Y_B",
        why="the slider moves along y and its joint with the rod is B, as in (13)",
        effect="none: (13) has it right",
    ),
    misprint(
        "two_inertias", "2, (13), below (21)",
        "One moment of inertia has two symbols, and one function two more.",
        CORRECTED,
        "J_O of the flywheel above (13) is the J in it; Je and Jp of the system below (21) are J "
        "and J' of (17). With J_O = J the first row of (13) is the law above it (off by 0)",
        printed="J_O, J; Je, Jp",
        test=TESTS + "test_the_inertia_of_the_first_row_of_13_is_the_flywheels",
        corrected="J eps_1 = M_m - X_A r sin phi + Y_A r cos phi; J(phi), J'(phi) in the system",
        why="both stand with eps_1 in the same equation",
        effect="none",
    ),
    misprint(
        "citations", "1, 2, 3",
        "Citations are one number too high: van der Pol's, and all of section 2.",
        CORRECTED,
        "as printed [8] for van der Pol's method, which is [7], and [14], where the list has 13; "
        "so [5]-[7], [9], [10] for the theorems, and [10]-[14] for the work of the reactions, "
        "seem to be one too high as well. [8] and [12] are one paper",
        printed="[5]-[7], [9], [10]; [8]; [10]-[14]",
        test=TESTS + "test_citations_do_not_fit_the_list",
        corrected="[4]-[6], [8], [9]; [7] for van der Pol; [9]-[13]",
        why="the list of references, from which one seems to have been taken",
        effect="none",
    ),
    statement(
        "free_bodies_13", "equations (13), (15)",
        "Momentum and moment of momentum of crank, rod and slider.",
        REPRODUCED,
        "the signs of (13) are right: its five rows give the reactions and the acceleration "
        "(off by {error:.0e}); dots are missing on y_C and y_B, see the row on (12)",
        each=derivation.reactions, reference="{error:.0e}",
        engines="reactions within {error:.1g}", judgement=holds(below("error", ROUNDING)),
    ),
    misprint(
        "row_4_of_14", "equation (14)",
        "Moments of Y_A and Y_B about the rod's centre.",
        CORRECTED,
        "(16) asks that the reactions do no work; Y_A and Y_B need minus signs, as in (13): off "
        "by 0.0201 as printed, by 4e-17 corrected; as printed phi'' at 0.3 rad would be -0.0309 "
        "instead of -0.00626 rad/s^2",
        printed="+(l/2) sin beta",
        test=EQUATION_TESTS + "test_14_needs_minus_signs_and_16_says_so",
        corrected="-(l/2) sin beta with Y_A and with Y_B",
        why="(16): reactions of ideal joints do no work; (13) has the signs",
        effect="none on (17) to (21): reactions drop out of (17)",
        copy="lost minus signs would look the same",
    ),
    misprint(
        "first_row_of_14", "equation (14)",
        "The vector A_1 without its first row.",
        CORRECTED,
        "as printed 4 rows meet a matrix of 5; with the 1 of (11) in front, the first row is the "
        "crank's J eps_1 again",
        printed="4 rows",
        test=TESTS + "test_the_first_row_of_14_is_the_cranks",
        corrected="{A_1} = {1, -r sin phi + ..., r cos phi - ..., t, r cos phi - l t sin beta}",
        why="(11); a matrix of five rows needs five",
        effect="none",
        copy="a lost line of the vector would look the same",
    ),
    statement(
        "reactions_do_no_work", "equations (14), (16)",
        "Reactions of ideal joints do no work.",
        CORRECTED,
        "A_1^T [N] is 0 to {work:.0e} with the signs of (14) put right (the line above (16) lacks "
        "a transpose)",
        lambda session: derivation.work_of_reactions(as_printed=False),
        reference="{work:.0e}", judgement=corrected(below("work", ROUNDING)),
    ),
    misprint(
        "equation_multiplied", "2, above (17)",
        "Which equation is multiplied by A_1^T.",
        CORRECTED,
        "A_1^T times (15) is the equation of motion (off by 2e-16); (5) relates two speeds, has "
        "no forces, and cannot give a motion that depends on the torque",
        printed="(5)",
        test=TESTS + "test_15_and_not_5_gives_the_equation_of_motion",
        corrected="{A_1}^T times (15)",
        why="only (15) has the forces",
        effect="none: (17) follows from (15)",
        copy="a lost digit would look the same",
    ),
    statement(
        "equation_17", "equations (17)-(19)",
        "The equation of motion.",
        CORRECTED,
        "with the 2 that (18) lacks; without it the accelerations are off by {as_printed:.2g}. A "
        "soft closure resists late, which is its model's error and no one's misprint",
        each=derivation.accelerations_17, reference="{error:.0e}",
        engines="{model}: accelerations off by {error:.1g}",
        judgement=corrected(below("error", ROUNDING)),
    ),
    misprint(
        "factor_of_18", "equation (18)",
        "Derivative of the moment of inertia.",
        CORRECTED,
        "J' = 2 A_1^T [m] A_2: off by 0.5 as printed, by 3e-16 corrected; with J' as printed the "
        "energy of a free crank would swing by 2.08% in a turn",
        printed="A_1^T [m] A_2",
        test=EQUATION_TESTS + "test_18_lacks_a_factor_2",
        corrected="J'(phi) = 2 {A_1}^T [m] {A_2}",
        why="J' is the derivative of J(phi) = {A_1}^T [m] {A_1}, and A_2 that of A_1",
        effect="the limit cycle of (17), integrated as printed, is at 5.085 instead of 5.071 "
            "rad/s; none on (20), (21), as J' averages to 0",
    ),
    misprint(
        "last_line_of_19", "equation (19)",
        "Generalised torque, multiplied out.",
        CORRECTED,
        "the last line has lost - c omega_1 (r cos phi - l t sin beta)^2: off by 0.564 as "
        "printed, by 2e-15 corrected; without it there would be no steady rotation to stabilise "
        "at",
        printed="no c in the last line",
        test=IDENTITY_TEST,
        corrected="M(phi) = M_m - c omega_1 (r cos phi - l t sin beta)^2 - k l (...) - k (...) "
            "(...)",
        why="the line before it has the damper",
        effect="none: the averages of section 3 have it",
        copy="a line of the formula may be lost in our copy",
    ),
    misprint(
        "linear_system", "3, below (21)",
        "In x_1, x_2 the equation is called a linear system.",
        CORRECTED,
        "it is of first order and not linear: from 3 to 6 rad/s phi'' changes otherwise than from "
        "0 to 3 rad/s, by {bend:.0%} of that. It also has x_1 = alpha for phi, and M(x_1) "
        "for M(x_1, x_2): the damper needs the speed",
        derivation.nonlinearity,
        judgement=corrected(above("bend", 1e-6), above("uneven", 1e-6)),
        printed="M(x_1)",
        test=TESTS + "test_the_system_below_21_is_not_linear",
        corrected="a system of first order in x_1 = phi, x_2 = omega_1, with M(x_1, x_2)",
        why="x_2' has x_2^2 and functions of x_1; the damper's torque in (19) has the speed",
        effect="none: it is integrated numerically",
    ),
    misprint(
        "autonomous", "4",
        "The mechanism is non-autonomous.",
        CORRECTED,
        "nothing in (17) depends on time: a motion taken up again a second later is the same "
        "(to {error:.0e} rad). Read as *driven*, by a motor, it is right",
        derivation.taken_up_again, judgement=corrected(below("error", 1e-6)),
        test=TESTS + "test_the_equation_of_motion_has_no_time",
        corrected="driven vibratory mechanisms, or autonomous ones",
        why="(17) to (19) have no time, and the torque is constant",
        effect="none",
    ),
    statement(
        "mean_slope", "3", "J' averages to 0 over a turn.", REPRODUCED,
        "0 to {mean:.0e} for lambda = 0.05 to 0.9: J' is the derivative of a periodic function",
        lambda session: derivation.largest_mean("slope"),
        reference="{mean:.0e}", judgement=holds(below("mean", 1e-14)),
    ),
    statement(
        "mean_spring", "3", "The spring's torque averages to 0.", REPRODUCED,
        "0 to {mean:.0e} over a turn, with either reference of the spring, so that k is not in "
        "(21); the limit cycle feels it a little: {speeds:.4f} rad/s with k = 0, 32, 64 N/m",
        derivation.mean_spring, reference="{mean:.0e}", judgement=holds(below("mean", 1e-13)),
    ),
    misprint(
        "spring_of_section_3", "3", "Where the spring is at rest.", CORRECTED,
        "the averages have r + l, with the other sign, where (19) has -l: a spring at rest at "
        "-(r + l), and not at -l as in F_e. Each averages to 0, so that (20) stands: forces are "
        "off by 1 as printed, by 0 corrected, over k r",
        printed="r + l",
        test=IDENTITY_TEST,
        corrected="mean of k (r cos phi - l t sin beta) l",
        why="F_e and (19) have the spring at rest at y = -l",
        effect="none: both average to 0",
    ),
    number(
        "mean_cos_squared", "3", "Mean of cos^2 phi.", REPRODUCED,
        numbers=lambda session: {"value": averages(EXAMPLE)["cos_squared"]}, printed="0.5",
    ),
    number(
        "remainder", "3", "Mean of t^2 sin^2 beta.", REPRODUCED,
        "exactly 1 - sqrt(1 - lambda^2) - lambda^2/2 = {exact:.9f}",
        derivation.remainder, printed="0.000204",
    ),
    statement(
        "remainder_everywhere", "equations (20), (21)",
        "The lengths enter by lambda as a symbol, and by the number 0.000204.",
        CORRECTED,
        "the number is that of lambda = 0.2, which the text does not say: t^2 sin^2 beta has the "
        "mean {means}, for which (21) with 0.000204 is off by {errors:+.2%}. The exact mean is a "
        "formula in lambda (off from a quadrature by {closed:.0e})",
        derivation.remainder_everywhere, reference="{means}",
        judgement={**holds(below("largest", 0.005)), **corrected(below("closed", ROUNDING))},
        printed="0.000204",
        erratum=Erratum(
            EQUATION_TESTS
            + "test_21_takes_the_exact_mean_and_the_printed_one_holds_at_one_fifth",
            "omega_1 = M_m/(c l^2 (1 - sqrt(1 - lambda^2)))",
            "mean of (r cos phi - l t sin beta)^2 over a turn, in closed form",
            "none at lambda = 0.2; at lambda = 0.5 the speed is 7 % too high",
        ),
    ),
    statement(
        "mixed_mean", "3", "t cos phi sin beta averages to 0.", REPRODUCED,
        "odd in phi: {mean:.0e}",
        lambda session: derivation.largest_mean("mixed"),
        reference="{mean:.0e}", judgement=holds(below("mean", 1e-15)),
    ),
    statement(
        "mean_damper", "equation (20)", "Mean of the damper's torque.", REPRODUCED,
        "over the angle, at constant speed: {mean:.9f} c l^2 omega_1, printed {printed:.6f} "
        "(off by {error:.0e}) at lambda = 0.2",
        derivation.mean_damper, reference="{mean:.9f}", judgement=holds(below("error", 1e-5)),
    ),
)  # fmt: skip


PRINTED_SPEED = "5.07 rad/s"

MOTIONS: tuple[LedgerRow, ...] = (
    statement(
        "formula_21", "equation (21)",
        "Stabilised speed from torque, damper and lengths.",
        REPRODUCED,
        "(21) over the limit cycle's speed, less 1, for c = 2, 3, 4; its exact average would "
        "change that by {change:.0e} only. The rest is the speed's variation in a turn, which "
        "averaging leaves out, and grows as the speed falls",
        each=motions.own_rotations, reference="{errors:+.2%}",
        judgement=holds(below("largest", CLOSE)), slow=True,
    ),
    statement(
        "asymptote", "1, 4",
        "Averaging in van der Pol's manner gives the speed.",
        REPRODUCED,
        f"with J = {', '.join(f'{value:g}' for value in INERTIAS)} kg m^2 the limit cycle is "
        "faster than the exact average by {errors:.1e}: an asymptote, its error going as "
        "J^{slope:.2f}",
        motions.asymptote, reference="{errors:.1e}", judgement=holds(below("off", 0.05)), slow=True,
    ),
    statement(
        "linear_law", "3, figure 3",
        "The stabilised speed grows linearly with the torque, for several dampers.",
        REPRODUCED,
        f"from {AWAY:g} times the least torque of a rotation to {TORQUE[1]:g} N m each curve lies "
        "within {bend:.1%} of its height of a straight line for c = 2, 3, 4, and (21) within "
        "{apart:.1%}; from the least torque itself ({least:.4f} N m) within {near:.1%}. Where the "
        "axis of figure 3 begins is not in the text",
        motions.linear_law, motions.speeds_of_figure_3, "{bend:.1%}",
        "within {gap:.1e} of the reference",
        holds(below("bend", CLOSE, ours=True)), slow=True,
    ),
    statement(
        "energy_balance", "3, 4",
        "At the operating speed the damper takes what the motor gives.",
        REPRODUCED,
        "the damper's work over the motor's in the last turn of the run from 6 rad/s with c = 4, "
        "which is {faster:.1%} faster than the limit cycle yet",
        each=motions.work_ratio, reference="{ratio:.3f}",
        judgement=holds(below("error", CLOSE, everyone=True)), slow=True,
    ),
    statement(
        "stabilised_speed", "3, figure 4", "Speed at which the motion stabilises.", NOT_TESTABLE,
        "used for calibration, and so no test of the paper: M_m/(c l^2) is chosen to have it. "
        "(21) then gives 5.0683 rad/s, and the limit cycle has 5.0712 rad/s",
        reference="5.0712 rad/s", printed=PRINTED_SPEED,
    ),
    misprint(
        "unit_of_the_speed", "caption of figure 4",
        "Unit of the stabilised angular speed.",
        CORRECTED,
        "M_m/(c l^2) is a rate: (21) gives 5.07 in any unit of length, and the text below says "
        "rad/s; a speed in m/s, that of the crank pin, would be 1.27 with r = 0.25 m",
        printed="m/s",
        test=TESTS + "test_the_stabilised_speed_is_no_length_per_time",
        corrected="omega_st = 5.07 rad/s",
        why="(21) gives a rate; the text below the figure has rad/s",
        effect="none",
    ),
    statement(
        "stabilises", "2, 3",
        "Under a constant torque the speed becomes constant on average.",
        REPRODUCED,
        "change of the mean speed over the last ten turns of 200 s from 8 rad/s; a deviation "
        "falls by {multipliers[0]:.4f} in each turn",
        motions.limit_cycles, motions.last_speeds, "{drift:.1e}",
        judgement=holds(below("drift", 1e-2, everyone=True)), slow=True,
    ),
    statement(
        "independent_of_start", "3, figure 4",
        "Different initial conditions end at the same speed.",
        REPRODUCED,
        f"from {', '.join(f'{v:g}' for v in STARTS)} rad/s, a spread of "
        f"{STARTS[-1] - STARTS[0]:g} rad/s; after 200 s it is {{spread:.3f}} rad/s, and falls by "
        "{lost[0]:.1%} in each turn",
        motions.limit_cycles, motions.last_speeds, "{speeds:.4f} rad/s",
        judgement=holds(below("spread", 0.01 * (STARTS[-1] - STARTS[0]), everyone=True)), slow=True,
    ),
    statement(
        "damping_slows", "3, figure 5",
        "A stronger damper stabilises at a lower speed, from the same start.",
        REPRODUCED,
        "for c = 2, 3, 4; by (21) in inverse proportion: c times the speed is {products:.2f} N/m",
        each=motions.own_rotations, reference="{speeds:.4f} rad/s",
        judgement=holds(below("changes", 0, everyone=True)), printed="c = 2, 3, 4", slow=True,
    ),
    statement(
        "quasi_uniform", "abstract, 4",
        "The stabilised rotation is nearly uniform.",
        REPRODUCED,
        "the speed varies in a turn by {variation:.1%} of its mean for c = 2, 3, 4; below, in the "
        "last turn of the runs of figure 5",
        motions.limit_cycles, motions.variation_of_runs, "{last:.1%}",
        judgement=holds(below("variation", 0.1)), slow=True,
    ),
    statement(
        "braked", "3, figure 6",
        "Where the damper takes more than the motor gives, a damped vibration results.",
        REPRODUCED,
        "with {torque:g} N m and c = {damping:g} N s/m, below the least torque of a rotation, "
        "{least:.4f} N m: turns get slower, the last one does not come over the spring, and a "
        "damped vibration about a position of rest is left",
        motions.braked, motions.end_of_braking, "{end} after {reversals} reversals",
        judgement=holds(equal("end", "rest", everyone=True), below("gain", 1e-9)), slow=True,
    ),
    BRAKING,
    statement(
        "phase_space", "3, figure 7",
        "Trajectories of the slider in its phase plane go to a limit cycle.",
        REPRODUCED,
        "trajectories of the slider from 6 and 1.5 rad/s close in on one curve, c = 4: gap of "
        "their mean speeds in the first and last turn of 100 s (multiplier {multipliers[2]:.4f})",
        motions.limit_cycles, motions.closing_in, "{first:.3f} to {last:.3f} rad/s",
        judgement=holds(below("left", 0.02, everyone=True)), slow=True,
    ),
    statement(
        "limit_cycle_stable", "abstract, 4",
        "Limit cycles and their stability are established.",
        REPRODUCED,
        "Floquet multipliers for c = 2, 3, 4; they are exp(-integral of c y_phi^2/(J omega)) < 1 "
        "for every damper. The paper shows trajectories and no criterion; the engines' factors "
        "are from their runs",
        motions.limit_cycles, motions.decay, "{multipliers:.5f}",
        "c = 4: a deviation falls by {value:.3f} in each turn",
        holds(above("multipliers", 0), below("multipliers", 1)), slow=True,
    ),
    statement(
        "conditions", "abstract, 3, 4",
        "What a nearly uniform rotation takes is derived: the balance (20).",
        REPRODUCED,
        "as a balance: (20) asks for the torque that the limit cycle has to within {errors:+.2%} "
        "for c = 2, 3, 4. That there is a rotation is a condition of its own: from {least:.4f} "
        "N m on, which depends on the spring and is not in the paper",
        motions.least_torques_of_rotation, motions.own_rotations, "{errors:+.2%}",
        judgement=holds(below("largest", CLOSE, ours=True)), slow=True,
    ),
    statement(
        "design", "4",
        "A damper for an imposed speed can be chosen by the formula.",
        REPRODUCED,
        "the damper that (21) asks for, tried on the equation of motion: off by {errors[0]} at "
        "5.07 rad/s; {errors[1]} at 2.5 rad/s; {errors[2]} at 1.5 rad/s; {errors[3]} at 1 rad/s. "
        "Good while a turn is much shorter than the crank's swing on the spring",
        motions.designs, reference="{errors}", judgement=holds(below("second", CLOSE)),
    ),
    statement(
        "resonance", "4", "Resonance conditions are studied.", NOT_TESTABLE,
        "named in the conclusions; no equation, number or figure is about it. The crank's own "
        "vibrations about its positions of rest, without torque and damper: right 0.942 rad/s, "
        "left 0.988 rad/s",
        reference="right 0.942 rad/s, left 0.988 rad/s",
    ),
)  # fmt: skip

ROWS: tuple[LedgerRow, ...] = (*DERIVATION, *MOTIONS, *READINGS)

CLOSING_SECTION = "4"

CAUSES: tuple[Cause, ...] = (
    Cause(
        "signs_of_14",
        "The matrix of (14) has lost the minus signs of (13) in its fourth row",
        ("row_4_of_14", "reactions_do_no_work"),
    ),
    Cause(
        "half_slope",
        "The derivative of the moment of inertia in (18) is half of what (17) needs",
        ("equation_17", "factor_of_18"),
    ),
)
