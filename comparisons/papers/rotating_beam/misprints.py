"""Misprints of the rotating_beam paper: what a formula gives as printed, and put right.

Each is proved by one number that the reference, which has its equations from Lagrange's, gives by
another route.
"""

from __future__ import annotations

from ..ledger import CORRECTED, LedgerRow, misprint

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
