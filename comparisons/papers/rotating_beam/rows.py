"""The ledger of the paper on `rotating_beam`, and its figures."""

from __future__ import annotations

from functools import partial

from ...engines.registry import REFERENCE
from ..ledger import (
    CORRECTED,
    DEPENDS,
    NOT_REPRODUCED,
    NOT_TESTABLE,
    PRINTED,
    REPRODUCED,
    ROUNDS,
    UNCONVERGED,
    Cause,
    Condition,
    LedgerRow,
    above,
    below,
    corrected,
    depends,
    equal,
    holds,
    misprint,
    number,
    statement,
    unconverged,
)
from . import derivation, frequencies, responses
from .derivation import IDENTITIES
from .figures import FIGURES as FIGURES
from .readings import READINGS
from .results import LOADS, PRINTED_MAXIMA, free_amplitude, peak, top_speed

TESTS = "tests/comparisons/papers/rotating_beam/test_misprints.py::"
FORMULA = TESTS + "test_corrected_formula_gives_what_the_reference_does"
OTHERS = TESTS + "test_misprints_of_symbols"
STIFFNESS = (
    "tests/reference/rotating_beam/test_frequencies.py"
    "::test_figure_3_without_bending_stiffness_has_no_speed"
)

NONE = "none on the results: later equations have it right"
LAGRANGE = "Lagrange's equations of the second-order energies"
BRACES = "brackets of this equation do not match in our copy, which may have lost more than one"

MISPRINTS: tuple[LedgerRow, ...] = tuple(
    misprint(
        name, section, summary, CORRECTED,
        f"{what}: as printed {printed}, corrected {right} {unit}".strip(),
        reference=f"{right} {unit}".strip(),
        test=test, corrected=formula, why=why, effect=effect, copy=copy,
    )
    for name, section, summary, (what, printed, right, unit), test, formula, why, effect, copy in (
        (
            "strain_energy", "equation (2)",
            "The energy of stretching has the second derivative of u.",
            ("strain energy of a beam stretched by 1e-4", "0", "0.20125", "J"), FORMULA,
            "V = 1/2 EI int v_xx^2 dx + 1/2 EA int u_x^2 dx",
            "an even stretch stores energy; (5) has u_x", NONE,
            "an exponent too many would look the same",
        ),
        (
            "hub_radius", "equation (3)",
            "The velocity of a point of the beam is without the hub radius a.",
            ("kinetic energy at 1 rad/s on a hub of 8 m without inertia", "17.227", "120.59", "J"),
            FORMULA,
            "(v' + (a + x + u + u_f) theta') j'",
            "the axis is at a distance a from the clamp; (4) and (16) have it", NONE, "",
        ),
        (
            "coupling_energy", "equation (4)",
            "The energy that couples turning and bending has the square of theta'.",
            ("kinetic energy of a beam that turns and bends", "523.57", "513", "J"), FORMULA,
            "rho A theta' int (-v u_f' + v' (a + x + u_f)) dx",
            "a kinetic energy is of degree two in the rates; (5) has theta'", NONE,
            "an exponent too many would look the same",
        ),
        (
            "stretch_of_4", "equations (4), (5)",
            "The kinetic energy, before it is expanded, is without the stretch u.",
            ("kinetic energy at 1 rad/s of a beam stretched by 1e-3, a = 8 m", "120.59", "120.68",
             "J"), FORMULA,
            "(a + x + u + u_f)^2, u' + u_f' for u_f', and v' (a + x + u + u_f)",
            "(3) has it, and so has the expanded (5)", NONE, "",
        ),
        (
            "gravity", "equations (4), (5)",
            "The potential energy has a weight, though the plane is horizontal.",
            ("torque on the hub at rest", "-126.71", "0", "N m"), FORMULA,
            "V = 1/2 EA int u_x^2 dx + 1/2 EI int v_xx^2 dx",
            "2.1 has the system move in a horizontal plane, and (2) no weight",
            "none on the results: (14) to (16) have no weight", "",
        ),
        (
            "mass_twice", "equation (5)",
            "The kinetic energy of the concentrated mass is counted a second time, without the "
            "hub radius.",
            ("kinetic energy of 0.4 kg at the free end at 1 rad/s, a = 8 m", "64", "51.2", "J"),
            FORMULA,
            "1/2 m ((u' + u_f' - v theta')^2 + (v' + (a + d + u + u_f) theta')^2) at d, once",
            "the terms with (a + d + u_fd)^2, and those with d^2, u_d^2 and their products, are "
            "both the whole energy of the mass; (16) has it once", NONE, BRACES,
        ),
        (
            "hub_energy", "equation (5)",
            "The kinetic energy of the hub, which (4) has, is gone.",
            ("kinetic energy at 1 rad/s", "17.227", "22.227", "J"), FORMULA,
            "+ 1/2 J_h theta'^2", "(1) and (4) have it",
            "none shown: (14) to (16) have no J_h either, and read literally are those of a hub "
            "without inertia, with which figure 5's claims can be judged too", "",
        ),
        (
            "hub_alone", "equation (7)",
            "The equation of the hub has its own inertia and the torque only.",
            ("hub's angle after the pulse", "1.5915", "0.35781", "rad"), FORMULA,
            "J_h theta'' = tau + a times the shear force at the clamp + the moment there",
            "the beam holds the hub back",
            "none if the third row of (14) is used, or if tau is read as all torque on the hub, "
            "the beam's included", "",
        ),
        (
            "axial_frequency", "2.2, below (9)",
            "The second form of the axial frequencies, for i = 1, 3, 5, has no i in it.",
            ("second axial frequency, i = 3", "980.22", "2940.7", "rad/s"), FORMULA,
            "omega_i = (i/2) (pi/L) sqrt(E/rho), i = 1, 3, 5, ...",
            "cos(beta_1 L) = 0; the first form is right", "none",
            "an i read as 1 would look the same",
        ),
        (
            "swapped_constants", "equation (10)",
            "B_1 and B_2 have changed places against (9): (10) fits B_1 as the cosine's and B_2 as "
            "the sine's constant.",
            ("B_1/B_2 of the first mode by the first row", "-1.3622", "-0.7341", ""), FORMULA,
            "B_1 (sin + sinh) + B_2 (cos + cosh) = 0 and "
            "B_1 (cos + cosh) - B_2 (sin - sinh) = 0, at beta_2 L",
            "in (9) B_1 is the factor of the sine; so it is in (12)",
            "none: (12) has the ratio of the constants right, but for its sign", "",
        ),
        (
            "free_end", "equation (10)",
            "In the second row, of the shear force at the free end, stands cos - cosh.",
            ("shear force of the first mode at the free end", "4.9", "0", ""), FORMULA,
            "cos(beta_2 L) + cosh(beta_2 L)",
            "third derivative of (9) at L; the determinant of (10) as printed is -2 sinh^2, which "
            "has no root but 0",
            "none: the roots below (11) are right", "",
        ),
        (
            "determinant", "equation (11)",
            "The determinant is another than that of (10), with the signs of its second row.",
            ("determinant at 1.8751; as printed it is 2 sin^2", "1.8204", "0", ""), FORMULA,
            "|cos + cosh, sin + sinh; -sin + sinh, cos + cosh| = 2 + 2 cos cosh = 0",
            "third derivative of (9) at L; as printed the roots are i pi",
            "none: the roots below are those of the corrected one",
            "a sign too many in the last element would look the same",
        ),
        (
            "frequency_formula", "2.2, below (11)",
            "The formula of the bending frequencies has beta_i L without a square.",
            ("first frequency at rest", "1.5523", "2.9107", "rad/s"), FORMULA,
            "omega_i = (beta_i L)^2 sqrt(EI/(rho A L^4))",
            "beta_2^4 = rho A omega^2/EI, below (9)", "none: no later equation uses it",
            "a lost exponent would look the same",
        ),
        (
            "mode_sign", "equation (12)",
            "The sine's part of the mode is added.",
            ("bending moment of the first mode at the free end", "-6.0756", "0", ""), FORMULA,
            "cos - cosh - xi_i (sin - sinh)",
            "the moment at the free end vanishes, first row of (10)",
            "none shown: used as printed, the modes would have a moment at the free end", "",
        ),
        (
            "mode_argument", "2.2, below (12)",
            "The constant xi_i is written as a function of x.",
            (
                "deflection of the first mode in the middle over that of the end",
                "0.29006", "0.33952", "",
            ), FORMULA,
            "xi_i = (cos(beta_i L) + cosh(beta_i L))/(sin(beta_i L) + sinh(beta_i L))",
            "a constant of (9) does not depend on x", "none shown, as of its sign",
            "an L read as x would look the same",
        ),
        (
            "equation_14_axial", "equation (14), row 1",
            "The axial stiffness is the integral of EA phi' phi.",
            ("stiffness of the first axial mode", "3.1446e+05", "7.7589e+05", "N/m"), FORMULA,
            "int EA phi_1'^T phi_1' B_1 dx", "so it is in K_1 of (16)", NONE,
            "a lost prime would look the same",
        ),
        (
            "equation_14_driving", "equation (14), row 2",
            "The hub's theta'' stands with minuses in the row of B_2, and as theta' in the mass's "
            "term with B_1; the beam's (a + x) H lacks rho A.",
            ("what theta'' does to the first bending mode, over rho A L^2", "-1.6041", "1.6041",
             ""), FORMULA,
            "+ int rho A ((a + x) phi_2 + B_1^T phi_1^T phi_2) dx theta'' + m ((a + d) phi_2(d) + "
            "B_1^T phi_1^T(d) phi_2(d)) theta'' and + int rho A (a + x) H dx B_2 theta'^2",
            f"{LAGRANGE}; M_theta2 of (16) has the plus", NONE, "",
        ),
        (
            "equation_14_centrifugal", "equation (14), row 2",
            "Both of the mass's terms with theta'^2 B_2 have the other sign.",
            ("stiffness that the mass has from theta'^2, over rho A L", "-0.31318", "0.31318", ""),
            FORMULA,
            "m theta'^2 ((a + d) H(d) - phi_2(d)^T phi_2(d)) B_2",
            f"{LAGRANGE}; K_22 of (16) has them right", NONE, BRACES,
        ),
        (
            "equation_14_hub", "equation (14), row 3",
            "What stands with theta'' has no hub, and theta' with the mass's (a + d)^2.",
            ("what stands with theta'' of the straight beam", "241.18", "308.78", "kg m^2"),
            FORMULA,
            "theta'' (J_h + int rho A (a + x)^2 dx + m (a + d)^2 + ...)",
            f"{LAGRANGE}; (16) has the mass", "none shown, see J_h in (16)",
            "a lost dot would look the same",
        ),
        (
            "equation_14_mass", "equation (14), row 3",
            "Most terms of the concentrated mass stand without the factor m, three of them without "
            "theta'', and terms with H of beam and mass without 2 theta' or a rate.",
            ("what B_2'' of the first mode does to the hub by 0.4 kg in the middle", "8.1486",
             "3.2594", "kg m"), FORMULA,
            "at d, m theta'' ((a + d)^2 + B_1^T phi_1^T phi_1 B_1 + B_2^T phi_2^T phi_2 B_2 + "
            "2 (a + d) phi_1 B_1 - (a + d) B_2^T H B_2) + m ((a + d) phi_2 B_2'' + "
            "B_1^T phi_1^T phi_2 B_2'' - B_2^T phi_2^T phi_1 B_1'') + 2 m theta' ((a + d) phi_1 "
            "B_1' + B_1^T phi_1^T phi_1 B_1' + B_2^T phi_2^T phi_2 B_2' - (a + d) B_2^T H B_2'); "
            "of the beam - 2 theta' int rho A (a + x) B_2^T H B_2' dx",
            "they are no torques without it; M_theta2 of (16) has it", NONE, BRACES,
        ),
        (
            "hub_inertia", "equation (16)",
            "M_theta_theta is without J_h.",
            ("M_theta_theta, straight", "298.78", "308.78", "kg m^2"), FORMULA,
            "M_theta_theta = J_h + int rho A (x + a)^2 dx + m (d + a)^2 + ...",
            LAGRANGE,
            "none shown: the paper gives no J_h; read literally, (14) to (16) are those of a hub "
            "without inertia: figure 5's deformation then grows by 9, 14, 16 % with the mass, with "
            "10 kg m^2 by 23, 35, 42 %", "",
        ),
        (
            "torque", "equation (16)",
            "Q_theta is without the torque tau.",
            ("Q_theta at rest under 1 N m", "0", "1", "N m"), FORMULA,
            "Q_theta = tau - 2 theta' (...)", "the third row of (14) has it on its right",
            "none shown: figure 5 was computed with it, or it would show nothing", "",
        ),
        (
            "axial_pull", "equation (16)",
            "U_10 is without the concentrated mass, which U_20 has.",
            ("U_11 + a U_10, over rho A L^2", "1.1295", "1.3046", ""), FORMULA,
            "U_10 = int rho A phi_1 dx + m phi_1(d)", LAGRANGE,
            "none to be seen: the stretch by the mass's pull is too small in figures 2 to 5", "",
        ),
        (
            "driving_vector", "3.1, below (17)",
            "U_12 has the mass without its distance from the axis.",
            ("U_12 of the first mode", "1.52", "1.6041", ""), FORMULA,
            "U_12 = int (delta + xi) phi_2 dxi + alpha (delta + beta) phi_2(beta)",
            f"{LAGRANGE}; U_12 of (16) has d", "none on frequencies: it drives only", "",
        ),
        (
            "bending_stiffness", "3.1, below (21)",
            "K^C is without the bending stiffness K_2.",
            ("first dimensionless frequency at 7 rad/s, 0.4 kg in the middle", "10.601", "11.619",
             ""), STIFFNESS,
            "K^C = K_2 - gamma^2 M_22 + gamma^2 D_1", "(18) has it",
            "none shown: without it no speed has the maxima of figure 3, which has it then", "",
        ),
    )
)  # fmt: skip

SYMBOLS: tuple[LedgerRow, ...] = tuple(
    misprint(
        name, section, summary, CORRECTED, reason,
        printed=printed, test=OTHERS, corrected=formula, why=why, effect=effect, copy=copy,
    )
    for name, section, summary, reason, printed, formula, why, effect, copy in (
        (
            "axial_condition", "2.2, below (9)",
            "The condition at the free end has cos(beta_1 x) = 0.",
            "a condition at x = L; for all x it has no solution. beta_1 L = (2 i - 1) pi/2 below "
            "is that at L",
            "cos(beta_1 x) = 0", "cos(beta_1 L) = 0", "phi'(L) = 0 with A_2 = 0",
            "none: the frequencies below are right", "an L read as x would look the same",
        ),
        (
            "lost_rates", "equations (3), (5)",
            "Rates stand without their dots: u^2 + u_f^2 + 2 u u_f and 2 (x + u_f + a) v theta' in "
            "(5), phi x r in (3); and v' of the mass without its d.",
            "a kinetic energy is of degree two in the rates, and (3) has the hub's speed in its "
            "components",
            "u^2 + u_f^2 + 2 u u_f; 2 x v theta', 2 u_f v theta', 2 a v theta'; v' (a + d + u_fd); "
            "phi x r",
            "u'^2 + u_f'^2 + 2 u' u_f'; 2 (x + u_f + a) v' theta'; v_d' (a + d + u_fd); "
            "theta' k x r",
            "square of (3)", "none: (14) has the rates",
            "almost surely at fault: a copy loses dots easily, and this one has an i for u' beside",
        ),
        (
            "symbols_of_16", "equations (15), (16)",
            "Q_theta has M_1 and M_2, which are defined nowhere, and (15) k_11 for K_11.",
            "with M_11 and M_22 in their place Q_theta is Lagrange's to rounding, see matrices_16",
            "M_1, M_2; k_11, k_22", "B_1^T M_11 B_1' + B_2^T M_22 B_2'; K_11, K_22",
            "derivative of M_theta_theta in time", "none", "lost digits would look the same",
        ),
        (
            "drive_of_17", "equations (17), (18)",
            "(18), called the form of (17) without dimension, has the hub's acceleration on its "
            "right, where (17) has 0.",
            "(17) is right at the constant speed of which section 3.1 speaks, and so is (18), chi "
            "being 0 there; but one is not the form of the other: theta'' drives the bending modes",
            "= 0; = -chi U_12^T", "(18) with 0 on its right, or (17) with -(U_12 + a U_20)^T "
            "theta''", "third row of (15)",
            "none: the frequencies are those at constant speed", "",
        ),
        (
            "substitution_21", "3.1, below (20)",
            "(18) is put into (20), and omega stands in (21) for f.",
            "(20) is the motion that goes into (18), and its frequency is f, without dimension, as "
            "are M and K^C; omega = f/T",
            "Substituting (18) into (20); omega^2 M", "(20) into (18); f^2 M Theta = K^C Theta",
            "(20), and the matrices of (18)", "none", "",
        ),
        (
            "hub_symbols", "(1), (7), notations",
            "The hub's moment of inertia is I_h in (1), J_0 in (7) and J_oh in the notations.",
            "all stand with theta'' or theta'^2/2 of the hub: one number, which is not printed",
            "I_h, J_0, J_oh", "J_h throughout", "(1) and (7) are of the same hub", "none", "",
        ),
        (
            "angle_of_notations", "notations",
            "theta is the angle between the beam and the x-axis.",
            "the x-axis turns with the hub, so that the straight beam has the angle 0 with it; "
            "(1) and (7) need the angle of x with X, which is fixed",
            "x-axis", "the angle between the x-axis and the X-axis",
            "2.1: O-XY is fixed, o-xy turns", "none", "a capital read as small would look the same",
        ),
    )
)  # fmt: skip


BY_TWO_MODES = {
    **holds(ROUNDS),
    **unconverged(below("two_off", 0.005, ours=True)),
}

ROUNDING = 1e-9

MODES: tuple[LedgerRow, ...] = (
    statement(
        "extension_and_coriolis", "1",
        "stretch and Coriolis force matter where the extension parameter is large",
        REPRODUCED,
        "at an extension parameter of {large:.2g} the first frequency changes by {much:+.2g} for "
        "the stretch and {with_coriolis:+.2g} for the Coriolis force; at {small:.2g}, this beam's "
        "at the same speed, by {little:+.1g} for the stretch",
        frequencies.extension, judgement=holds(above("least", 0.01), below("most", 1e-4)),
    ),
    *(
        number(
            f"root_{i}", "2.2, after (11)", f"beta_{i} L of the cantilever at rest", CORRECTED,
            "of cos cosh = -1; (11) as printed vanishes at multiples of pi instead",
            each=partial(frequencies.root, i=i), judgement=corrected(ROUNDS), printed=printed,
        )
        for i, printed in enumerate(("1.875", "4.694", "7.855"), start=1)
    ),
    statement(
        "asymptote", "2.2, after (11)", "from the third on, beta_i L is nearly (2 i - 1) pi/2",
        REPRODUCED,
        "off by {errors[0]:.1e} for i = 3, by {errors[1]:.1e} for i = 4, falling",
        frequencies.asymptote, judgement=holds(below("errors", 1e-3), Condition("rises", "<=", 0)),
    ),
    statement(
        "axial_frequencies", "2.2", "axial frequencies at rest are (2 i - 1)/2 pi/L sqrt(E/rho)",
        REPRODUCED, "largest relative difference {error:.1e} of three",
        frequencies.axial_frequencies,
        reference="{omega:.5g} rad/s", judgement=holds(below("error", 1e-6)),
    ),
    statement(
        "orthogonal_modes", "equation (13)",
        "the transverse modes of the beam are orthogonal",
        REPRODUCED,
        "largest integral between two of the first four, over that of one: {error:.0e}. The beam "
        "alone is meant; (16) has a term for the concentrated mass, so that it need not hold with "
        "that. The 1 for m = n asks for (12) over sqrt(rho A L)",
        frequencies.orthogonality, reference="{error:.0e}", judgement=holds(below("error", 1e-6)),
    ),
    statement(
        "mode_conditions", "equations (8), (9)",
        "The shapes of stretching and bending, with the conditions at both ends.", REPRODUCED,
        "value and slope at the clamp, moment, shear force and pull at the free end, of three "
        "modes: at most {left:.0e} of their largest terms",
        derivation.mode_conditions, judgement=holds(below("left", ROUNDING)),
    ),
    statement(
        "conditions_10", "equations (10)-(12)",
        "The conditions of bending at the free end, their determinant, and the modes.", CORRECTED,
        "at the first root, over the largest terms: as printed they leave {as_printed:.2g}, put "
        "right {corrected:.0e}",
        derivation.free_end, judgement=corrected(below("most", ROUNDING), above("least", 1e-3)),
    ),
    statement(
        "foreshortening", "2.2, above (4)",
        "A beam that bends draws its points in by half the integral of the slope's square.",
        REPRODUCED,
        "at the free end, deflected in the first mode by 1 and 10 % of the length, off by "
        "{errors[0]:.0e} and {errors[1]:.0e}: to second order, as is said",
        derivation.foreshortening, judgement=holds(above("order", 1.9), below("order", 2.1)),
    ),
    statement(
        "matrices_16", "equations (1), (2), (6), (15), (16)",
        "The equations of motion as matrices, from the energies.", CORRECTED,
        "with the energies (1), (2), (4) put right, two axial and two bending modes, at random "
        "states: off by {pull:.2g} for the mass that U_10 lacks, by {hub:.2g} for the hub's "
        "inertia (10 kg m^2, our choice), by {corrected:.0e} with both. Of the other entries "
        "Q_theta lacks the torque, see torque, and has two undefined symbols, see symbols_of_16; "
        "the rest is right",
        derivation.matrices_16,
        judgement=corrected(below("corrected", ROUNDING), above("pull", 1e-3)),
    ),
    statement(
        "expanded_5", "equations (3), (5)",
        "The kinetic energy of the beam, multiplied out.", CORRECTED,
        "its terms against the square of (3) with the hub radius, at random values: off by "
        "{as_printed:.2g} as printed, by {corrected:.0e} with the dots that it has lost, see "
        "lost_rates",
        IDENTITIES["expanded_5"],
        judgement=corrected(below("corrected", ROUNDING), above("as_printed", 1e-3)),
    ),
    statement(
        "equation_14", "equations (7), (14)", "The equations of motion, written out.", CORRECTED,
        "with what the five rows on it put right, against Lagrange's equations as matrices_16 "
        "has them: off by {corrected:.0e}; as printed row 1 is off by {row_1:.2g} and row 2 by "
        "{row_2:.2g} of their largest terms, and row 3 adds what has different units; (7), which "
        "is row 3 of a hub alone, is off by {alone:.2g}",
        derivation.equation_14,
        judgement=corrected(
            below("corrected", ROUNDING), above("row_1", 1e-3), above("row_2", 1e-3),
            above("alone", 1e-3),
        ),
    ),
    statement(
        "dimensionless_18", "equations (17)-(19)",
        "With the numbers (19) the left-hand side of (17) becomes that of (18).", REPRODUCED,
        "frequencies by two modes with lengths, and without: apart by {error:.0e}; 0.4 kg in the "
        "middle at 7 rad/s", derivation.dimensionless, reference="{own:.5g}",
        judgement=holds(below("error", ROUNDING)),
    ),
    statement(
        "harmonic_motion", "equations (18), (20), (21)",
        "A harmonic motion turns (18) into an eigenvalue problem.", REPRODUCED,
        "(20) with f = {f:.5g} in (18): off by {error:.0e}; that is (21), with the K_2 that K^C "
        "has lost and f for omega, to {eigen:.0e}: see bending_stiffness, substitution_21",
        derivation.harmonic_motion,
        judgement=holds(below("error", ROUNDING), below("eigen", ROUNDING)),
    ),
    statement(
        "pull_of_the_hub", "equations (17), (18)",
        "the pull along the beam is D_1 + a D_0 with lengths, and D_1 alone without dimension",
        REPRODUCED,
        "D_1 of (16) is without the hub radius and that below (17) with it: both give {own:.6g} "
        "at 7 rad/s, a = L, with 16 modes, the reference {exact:.6g}",
        frequencies.pull_of_hub, reference="{exact:.5g}", judgement=holds(below("error", 1e-3)),
    ),
)  # fmt: skip

FREQUENCIES: tuple[LedgerRow, ...] = (
    statement(
        "slender", "3.1",
        "stretching is so much faster than bending that their coupling may be left out",
        REPRODUCED,
        "first axial frequency {ratio:.3g} times the first of bending; stretching lowers the "
        "latter by {gap:.1e} of itself, with 1.2 kg at the tip at 7 rad/s",
        frequencies.slenderness, frequencies.stretch_gap,
        "gap {gap:.2g}", "{gap:.2g} (its own error included)",
        holds(above("ratio", 100), above("gap", 0), below("gap", 1e-3)), slow=True,
    ),
    statement(
        "lowered_at_tip", "figure 2", "a mass at the tip lowers the first frequency", REPRODUCED,
        "means over gamma 0 to 12, of the beam without mass: {means:.3g}",
        each=frequencies.speed_curves, reference="{falls}",
        judgement=holds(equal("falls", True)), slow=True,
    ),
    statement(
        "attenuated", "figure 2",
        "the more mass there is, the less more of it lowers the frequency",
        REPRODUCED,
        "each further 0.4 kg lowers it by {drops:.3g} at gamma = 7; convex at all speeds",
        partial(frequencies.speed_curves, who=REFERENCE), frequencies.convexity, "{convex}",
        judgement=holds(equal("convex", True)), slow=True,
    ),
    statement(
        "rises_then_falls", "figure 3",
        "as the mass moves out, the first frequency rises and then falls",
        REPRODUCED,
        "one rise and one fall at 7 rad/s; without rotation only a fall (maximum at "
        "beta = {still:.2g}, the first looked at)",
        frequencies.best_places_otherwise, frequencies.curves, "{holds}",
        judgement=holds(equal("holds", True)), slow=True,
    ),
    statement(
        "variation", "figure 3", "the place changes the frequency the more, the larger the mass",
        REPRODUCED, "largest less smallest dimensionless frequency, by mass",
        each=frequencies.curves, reference="{ranges:.4g}",
        judgement=holds(above("growth", 0)), slow=True,
    ),
    number(
        "crossover", "figure 3", "the curves of all masses cross near this share of the length",
        UNCONVERGED,
        "0.4 kg at 7 rad/s, a speed of ours; no one point: {converged:.4g} for 0.4, 0.8, 1.2 kg. "
        "Two assumed modes have {two:.4g} there, and {two_faster:.4g} at {matched:.4g} rad/s, with "
        "the maxima at {two_maxima:.3g}. Converged, 0.4 kg are at 0.67 for {speed:.3g} rad/s, and "
        "the masses at {fast:.4g} at 15 rad/s. The speed is not printed",
        frequencies.crossovers, frequencies.crossover_of_0_4, engines="{value:.4g}",
        judgement={
            **holds(ROUNDS), **unconverged(Condition("two_first", "rounds to", PRINTED)),
        },
        printed="0.67", slow=True,
    ),
    *(
        number(
            f"maximum_{mass:g}".replace(".", "_"), "figure 3",
            f"the first frequency is largest with {mass:g} kg at this share of the length",
            UNCONVERGED,
            "converged, at 7 rad/s; at no speed beyond {top:.4f} (at {at:.2g} rad/s). Two assumed "
            "modes have {two:.4f} there, and the printed one at {matched:.4g} rad/s",
            partial(frequencies.printed_maximum, mass=mass),
            partial(frequencies.best_place, mass=mass), reference="{value:.4g}",
            judgement=BY_TWO_MODES, printed=f"{PRINTED_MAXIMA[mass]:g}", slow=True,
        )
        for mass in LOADS
    ),
    statement(
        "maxima_move_in", "figure 3", "the larger the mass, the farther in its best place",
        REPRODUCED, "at 7 rad/s; with two assumed modes {two:.4g}",
        frequencies.best_places_otherwise, frequencies.best_places, "{places:.4g}",
        judgement=holds(below("outward", 0), below("two_outward", 0)), slow=True,
    ),
    statement(
        "falls_beyond", "abstract, conclusion 1",
        "with the mass beyond 0.67 of the length, more mass lowers the first frequency",
        DEPENDS,
        "at 7 rad/s, and up to {speed:.3g} rad/s, beyond which 0.4 kg at 0.67 raise it (at 40 "
        "rad/s up to {fastest_first:.3f}). Converged, this and rises_inside hold together at no "
        "speed with 0.67",
        frequencies.crossovers, frequencies.curves, "{falls}",
        judgement={
            **holds(equal("falls", True), below("fastest_first", frequencies.THRESHOLD)),
            **depends(equal("falls", True)),
        },
        slow=True,
    ),
    statement(
        "rises_inside", "abstract, conclusion 1",
        "with the mass inside 0.67 of the length, more mass raises the first frequency",
        DEPENDS,
        "up to where 0.8 and 1.2 kg cross: {last:.3f} at 7 rad/s, {fast:.3f} at 15 rad/s, "
        "{fastest:.3f} at 40 rad/s; the speed is not printed. Converged, this and falls_beyond "
        "hold together at no speed with 0.67. 0.4 kg cross the beam without mass "
        "at {slowly} at 4 rad/s, {still} at rest, {no_hub} with a = 0; with two assumed modes at "
        "{two}",
        frequencies.crossings_inside, frequencies.curves, "{words}",
        judgement={
            **holds(equal("words", "yes")), **depends(above("fastest", 0.665)),
        },
        slow=True,
    ),
    statement(
        "better_prediction", "conclusion 1",
        "0.67 is nearer to the truth for taking the second-order coupling in",
        NOT_TESTABLE,
        "the text gives no other value to be better than, and no measured one; without the "
        "coupling a mass lowers the frequency wherever it sits; converged: 0.556 at 4 rad/s, "
        "0.635 at 7 rad/s, 0.670 at 15 rad/s",
        reference="0.635",
    ),
    statement(
        "near_0_42", "abstract, conclusion 2",
        "there is a best place of the mass, near 0.42 of the length",
        UNCONVERGED,
        "by mass, at 7 rad/s; at no speed beyond {tops:.4g}. Two assumed modes have {two:.4g} at "
        "7 rad/s",
        frequencies.furthest_places, frequencies.best_places, "{places:.4g}",
        judgement={
            **holds(below("gap", 0.005, ours=True)),
            **unconverged(below("two_gap", 0.005, ours=True)),
        },
        slow=True,
    ),
    statement(
        "value_of_6", "conclusion 2",
        "reference [6] has the best place at this share of the length",
        NOT_TESTABLE,
        "[6] would have to be read. Converged, at 7 rad/s, it is from 0.377 with 1.2 kg to 0.397 "
        "with 0.4 kg, nearer to this than to 0.42",
        reference="0.377 to 0.397", printed="0.4",
    ),
    statement(
        "coupling_of_6", "conclusion 2",
        "reference [6] leaves out the second-order coupling, hence the difference",
        NOT_TESTABLE,
        "[6] would have to be read; but without the coupling omega^2 is that at rest less "
        "Omega^2, and a mass at 0.4 lowers that at rest, from 2.911 to 2.837 rad/s: there would "
        "be no maximum to find, at 0.4 or elsewhere",
    ),
)  # fmt: skip

RESPONSES: tuple[LedgerRow, ...] = (
    number(
        "ramp", "3.2, (22)", "after the ramp the hub turns at this speed", REPRODUCED,
        "at t = 15 s",
        each=responses.speed_after_ramp, printed="10 rad/s", slow=True,
    ),
    statement(
        "ramp_22", "3.2, (22)", "the hub's speed rises smoothly from rest, and then stays",
        REPRODUCED,
        "the scene's angular acceleration is the slope of (22), and none after it, to {error:.0e}; "
        "at its end (22) has {end:.5g} rad/s",
        derivation.ramp, judgement=holds(below("error", ROUNDING), below("missed", ROUNDING)),
    ),
    statement(
        "pulse", "3.2, (23)", "the torque on the hub is one turn of a sine, and then none",
        REPRODUCED,
        "{momentum:.1g} N m s of angular momentum are left behind, of {most:.3g} N m s in the "
        "middle of the pulse, so that the hub comes to rest on the average; the scene's torque is "
        "(23) to {error:.0e}",
        responses.pulse, judgement=holds(below("error", ROUNDING), below("momentum", ROUNDING)),
    ),
    *(
        statement(
            name, section, summary, REPRODUCED,
            what + " with 0, 0.4, 0.8, 1.2 kg; it grows {evenly} with the mass",
            each=partial(responses.against_none, figure=4, measure=measure),
            reference="{values:.4g}", judgement=holds(above("more", 0)), slow=True,
        )
        for name, section, summary, measure, what in (
            (
                "deformation_larger", "figure 4 (a)",
                "the free end deforms more with the mass than without",
                peak, "largest deflection [m]",
            ),
            (
                "velocity_larger", "figure 4 (b)",
                "the free end is faster with the mass than without",
                top_speed, "largest velocity [m/s]",
            ),
            (
                "vibration_larger", "figure 4",
                "a mass at the free end increases its vibration",
                free_amplitude, "vibration left after the ramp [m]",
            ),
        )
    ),
    statement(
        "angle_depressed", "figure 5 (a)",
        "during the pulse, the angle is smaller the larger the mass",
        REPRODUCED,
        "angle of the free end [rad] after 10 s with 0, 0.4, 0.8, 1.2 kg; it falls with the mass "
        "at all times from {start:.2g} s on, when it has come to {little:.1g} %",
        responses.order_of_angles,
        partial(responses.against_none, figure=5, measure=responses.angle_after_pulse),
        "{values:.4g}", judgement=holds(below("changes", 0), below("start", 2)), slow=True,
    ),
    statement(
        "periodic", "figure 5", "after the pulse a periodic vibration is left", REPRODUCED,
        "amplitude of the second half of the free run over that of the first, by mass; amplitudes "
        "{amplitudes:.3g} m; a sum of modes, nearly periodic",
        each=responses.decay, reference="{ratios:.4g}",
        judgement=holds(below("off", 0.05), above("amplitudes", 1e-4)), slow=True,
    ),
    statement(
        "deformation_increased", "figure 5 (c)",
        "under the pulse, the mass increases the deformation slightly",
        REPRODUCED,
        "largest deflection [m], with a hub of 10 kg m^2: more than without mass by {percent:.2g} "
        "%. (14) to (16) as printed have no hub inertia; read so, it is by 9, 14, 16 %, see "
        "hub_of_figure_5",
        each=partial(responses.against_none, figure=5, measure=peak),
        reference="{values:.4g}", judgement=holds(above("changes", 0)), slow=True,
    ),
    statement(
        "stabilises", "3.2", "the mass calms the vibration of the free end", DEPENDS,
        "amplitude [m] after the pulse: {shares[0]:.2g} of that without mass for 0.4 kg, but "
        "{shares[1]:.2g} and {shares[2]:.2g} for 0.8 and 1.2 kg; the phase at which the torque "
        "ends decides. Neither the masses of figure 5 nor the hub's inertia are printed, see "
        "hub_of_figure_5",
        each=partial(responses.against_none, figure=5, measure=free_amplitude),
        reference="{values:.4g}",
        judgement={**holds(below("most", 1)), **depends(below("least", 1))}, slow=True,
    ),
    statement(
        "suppresses", "abstract, 3.2, conclusion 3", "the mass mainly suppresses the vibration",
        DEPENDS,
        "amplitude [m] after the pulse of figure 5, which section 3.2 concludes it from: with a "
        "hub of 10 kg m^2 {shares:.2g} of that without mass for 0.4, 0.8, 1.2 kg; without hub "
        "inertia 0.4 and 0.8 kg calm it and 1.2 kg do not, see hub_of_figure_5. That the "
        "vibration of figure 4 grows, as 3.2 says too, contradicts *mainly*",
        each=partial(responses.against_none, figure=5, measure=free_amplitude),
        reference="{values:.4g}",
        judgement={**holds(below("most", 1)), **depends(below("least", 1))}, slow=True,
    ),
    statement(
        "damps", "abstract, 3.2, conclusion 3", "the mass shows characteristics of damping",
        NOT_REPRODUCED,
        "nothing damps in (1) to (16), where a mass moves energy and takes none: after the pulse "
        "the energy stays, to {drift:.0e} of its largest. Read as *calms*, which the same sentence "
        "says before, it is judged by suppresses; engines: "
        "amplitude of the second half of the free run over the first, by mass",
        responses.energy_drift, responses.decay,
        "energy changes by {drift:.0e}", "{ratios:.4g}", holds(above("drift", 1e-3)), slow=True,
    ),
)  # fmt: skip

ROWS: tuple[LedgerRow, ...] = (*MODES, *FREQUENCIES, *RESPONSES, *MISPRINTS, *SYMBOLS, *READINGS)

CLOSING_SECTION = "4"

CAUSES: tuple[Cause, ...] = (
    Cause(
        "two_modes",
        "The places come out of two assumed modes, whose number the paper does not give, and at "
        "no one speed; with more modes they move in",
        ("crossover", "maximum_0_4", "maximum_0_8", "maximum_1_2", "near_0_42"),
    ),
    Cause(
        "speed_of_figure_3",
        "The crossings of figure 3 move with the angular speed, which is not printed",
        ("falls_beyond", "rises_inside"),
    ),
    Cause(
        "phase_of_figure_5",
        "What is left after the pulse hangs on the phase at which the torque ends: on the masses "
        "and the hub's inertia, which are not printed",
        ("stabilises", "suppresses"),
    ),
    Cause(
        "free_end_of_9",
        "The shear force at the free end was written with the wrong constants and signs",
        (
            "root_1",
            "root_2",
            "root_3",
            "conditions_10",
            "swapped_constants",
            "free_end",
            "determinant",
        ),
    ),
    Cause(
        "dots_of_5",
        "(5) has lost dots, almost surely in our copy alone",
        ("lost_rates", "expanded_5"),
    ),
    Cause(
        "signs_of_14",
        "(14) as a whole is off by what its rows tell, most by the signs of the hub's acceleration",
        ("equation_14", "equation_14_driving"),
    ),
    Cause(
        "lost_hub",
        "The inertia of the hub is in (1) and (4), and lost from (5) on",
        ("hub_energy", "equation_14_hub", "hub_inertia"),
    ),
)
