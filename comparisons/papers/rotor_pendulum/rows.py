"""The ledger of the rotor_pendulum paper, and its figures; here sections 2-5.1 and 6.

P. Fang, Y. Hou, Y. Nan, L. Yu, Journal of Vibroengineering 17(5), 2015.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ....reference.rotor_pendulum import theory
from ....reference.rotor_pendulum.cases import CASE_1
from ..ledger import (
    CORRECTED,
    NOT_REPRODUCED,
    NOT_TESTABLE,
    REPRODUCED,
    Cause,
    Condition,
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
from . import cases, derivation, regions
from .case_rows import CASE_ROWS, NO_COUPLING, RATIO_ROWS
from .figures import FIGURES as FIGURES
from .readings import READINGS
from .regions import AFTER, BEFORE
from .results import BETAS

TESTS = "tests/reference/rotor_pendulum/test_equations.py::"
OWN_TESTS = "tests/comparisons/papers/rotor_pendulum/test_misprints.py::"

IDENTITY = 1e-9
"""Relative residual below which an identity holds."""
FAILS = 1e-3
"""Relative residual from which it does not."""
SMALL = 0.1
"""Share that may be called small."""
FAR = 3.0
ALMOST_ALL = 0.95
"""Share of a region from which on it counts as being of one kind throughout."""
SOME = 1e-3
"""Share from which on a kind counts as appearing in a region."""
GOOD = 0.9
"""Share of points from which on two maps are said to agree."""

N = theory.ratios(CASE_1)

MODEL: tuple[LedgerRow, ...] = (
    misprint(
        "equation_11_sign", "equation (11)", "Sign before phi_2'^2 in the fourth line.", CORRECTED,
        "fourth line with the accelerations of Lagrange's equations at phi_3 = 0: off by 1.9 as "
        "printed, by 3e-16 corrected",
        printed="+ phi_2'^2 sin(phi_2 - beta)",
        erratum=Erratum(TESTS + "test_the_reduced_equations_are_the_printed_ones_but_for_a_sign"),
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
    misprint(
        "equation_14", "equation (14)", "Torque of an induction motor near its working speed.",
        NOT_REPRODUCED,
        "V^2/ohm is a power, not a torque: at 153.8 rad/s it is 6.33e+03 W, and with one more "
        "division by the electric speed 20.1 N m, where section 5.2 prints 3.08 N m",
        reference="3.08 N m",
        printed="n_p L_m^2 U^2 / (L_s^2 omega_m R_r) (omega_s - n_p omega_m)",
        erratum=Erratum(OWN_TESTS + "test_14_is_no_torque"),
    ),
    *(
        number(
            name, section, f"{what} stiffness at {'n_phi' if rod else 'n_x'} = {ratio:g}.",
            NOT_REPRODUCED,
            mistake + " gives {mistaken:.9g} at n = {ratio:g} and 157 rad/s",
            partial(derivation.stiffness, ratio=ratio, rod=rod),
            reference="{value:.6g} {unit}", printed=printed,
        )
        for name, section, what, mistake, ratio, rod, printed in (
            (name, section, *by_inertia, ratio, rod, printed)
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
    misprint(
        "equation_18", "equation (18)",
        "Laplace transform of the platform's motion, with factors left over.",
        CORRECTED,
        "(17) with eta of (15) for both, against m_2/m_1 = 1 and m_3/m_1, which make it 1/sigma: "
        "off by 1 as printed, by 1e-16 corrected",
        printed="eta_21 (1 + eta_31)",
        erratum=Erratum(
            OWN_TESTS + "test_18_has_factors_that_are_not_eta"
        ),
    ),
    misprint(
        "mu_1", "equations (20), (22)",
        "n_x and n_phi in mu_1, the response of the platform to the first rotor.",
        CORRECTED, "x of (21) in (17), at case 2: off by 0.021 as printed, by 1e-15 corrected",
        printed="sigma (n_x^2 - 1) n_phi^2 / N",
        erratum=Erratum(TESTS + "test_coupling_coefficients_solve_17_and_the_printed_ones_do_not"),
    ),
    statement(
        "mu_1_is_mu_4", "3", "mu_1 and mu_4 are the same expression.", NOT_REPRODUCED,
        "only by the misprint in mu_1; the right mu_1(n_x, n_phi) is mu_4(n_phi, n_x) (to "
        "{mirrored:.0e}), and the median difference of the two is {apart:.0%}",
        derivation.mirror_images, judgement=holds(below("apart", IDENTITY)),
    ),
    misprint(
        "figure_2_caption", "figure 2", "Which coefficients the first panel shows.", CORRECTED,
        "relative difference from mu_1 as printed, of mu_2 and of mu_4: off by 0.94 as printed, "
        "by 0 corrected",
        printed="mu_1 and mu_2",
        erratum=Erratum(
            OWN_TESTS + "test_the_first_panel_of_figure_2_is_mu_4"
        ),
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
        NOT_REPRODUCED,
        "the torque that couples the rotors goes with |(mu_1 - mu_3 sin(beta), mu_3 cos(beta))|: "
        "its rank correlation with mu_3 is {rank:.2f} at beta = pi/6, and at beta = 0 it acts "
        "though mu_2 and mu_3 are zero",
        derivation.strength, judgement=holds(above("rank", 0.9), equal("mu_1_alone", 0)),
    ),
    statement(
        "resonance_peaks", "3, figure 2",
        "Coefficients are small before and after resonance, far larger within 0.9-1.1.",
        NOT_REPRODUCED,
        "medians of |mu_1| ... |mu_4| before, at and after resonance of both: before: "
        "{before:.2g}; at: {at:.2g}; after: {after:.2g}; at resonance the least of them is "
        f"{{rise:.3g}} times larger, {FAR:g} would be far; they are infinite on the curve N = 0, "
        "which passes beside n_x = 1 and n_phi = 1",
        derivation.peaks, judgement=corrected(above("rise", FAR)),
    ),
    statement(
        "coupling_types", "3", "Frequency ratios divide systems into three types of coupling.",
        REPRODUCED,
        "a definition, which leaves {unnamed:.1%} of the plane without a type, the strips of "
        "resonance; the coupling torque at n_x = n_phi = 0.5, 1.01, 3 is {torques:.2g} N m",
        derivation.coupling_types, judgement=holds(above("rises", 0)),
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
        "identity_29", "equations (28), (29)",
        "The balance conditions of the two rotors are one.",
        REPRODUCED,
        "off by {error:.0e} at most; so the two conditions (28) are one, and vibration passes no "
        "power on where there are no dampers",
        derivation.identity_29, judgement=holds(below("error", IDENTITY)),
    ),
    statement(
        "balance_and_stability", "equations (30), (36)",
        "A synchronous motion needs a phase difference that balances and is stable.",
        CORRECTED,
        "for every n_x, n_phi and beta tried there is exactly one stable root, and the unstable "
        "one is opposite; (30) holds to {residual:.0e} of its amplitude",
        derivation.roots, judgement=corrected(below("residual", IDENTITY), below("opposite", 0)),
    ),
    misprint(
        "critical_point", "equations (31), (32)",
        "beta = pi/2 as a point at which no phase difference exists.",
        NOT_REPRODUCED,
        "(31) divides (30) by cos(beta); (30) itself has the stable root -3.1416 rad there, and "
        "the phase passes beta = pi/2 without a jump (5e-05 rad). The orbit of case 3 is "
        "antiphase, -2.8544 rad at 153.71 rad/s, 3.17 N m without f_phi, not there with it",
        printed="beta = k pi + pi/2",
        erratum=Erratum(TESTS + "test_the_phase_does_not_depend_on_how_the_angle_is_reached"),
    ),
    misprint(
        "equation_33_branch", "equation (33)", "Phase difference as an inverse cotangent.",
        NOT_REPRODUCED,
        "arccot knows nothing of (36): with values in (0, pi), and mu_1 as printed, the root that "
        "it gives is the unstable one on 100% at beta = 0, 99% at beta = pi/6, 94% at beta = "
        "pi/3, 84% at beta = 5 pi/12 of the range of table 2; atan2 of sine and cosine with the "
        "sign of N gives the stable one",
        printed="alpha = arccot(...)",
        erratum=Erratum(TESTS + "test_the_papers_phases_need_the_corrected_coefficient"),
    ),
    misprint(
        "equation_35", "equation (35)", "Of which difference the derivative is taken.", CORRECTED,
        "P_1 - P_1 has the slope 0; that of P_1 - P_2 at the stable root of case 2 is -1.8961 "
        "N m, minus the amplitude of (34)",
        printed="d(P_1 - P_1)/d alpha", erratum=Erratum(OWN_TESTS + "test_35_as_printed_is_zero"),
    ),
    statement(
        "springs_decide", "4", "Both springs are key to the phase difference.", CORRECTED,
        "at beta = pi/6 k_phi moves it by {by_phi:.2f} rad; k_x only decides between two opposite "
        "values ({flips:.0%} of the plane has the other one than n_x = 0.1), and moves it by "
        "{by_x:.0e} rad otherwise, as n_x cancels in (30) but for the sign of N",
        derivation.springs_decide,
        judgement=corrected(above("by_phi", SMALL), above("flips", SMALL)),
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
ALWAYS = {kind: corrected(Condition(kind, ">=", ALMOST_ALL)) for kind in ("synphase", "antiphase")}
BOTH = corrected(Condition("synphase", ">=", SOME), Condition("antiphase", ">=", SOME))

FIGURE_3: tuple[LedgerRow, ...] = tuple(
    statement(
        f"fig_3{panel}_{name}", f"5.1, figure 3({panel})", f"beta = {angle}, {summary}", verdict,
        "share of the region by (30), (36): {theory:.0%}; the phase passes +-pi/2 at n_phi = "
        "{turn:.3g} and at resonance. True orbits, with the dampers: {orbits:.0%}",
        each=partial(regions.kinds_in_regions, beta=BETAS[angle], regions=tuple(places)),
        reference="{theory:.0%}", engines="{orbits:.0%}",
        judgement=ALWAYS.get(name, BOTH), slow=True,
    )
    for panel, angle, name, verdict, summary, places in (
        (
            "b", "pi/6", "antiphase", CORRECTED,
            "n_x < 1, n_phi > 1: antiphase.", [(BEFORE, AFTER)],
        ),
        (
            "b", "pi/6", "both", CORRECTED,
            "n_x < 1, n_phi < 1: both antiphase and synphase appear.", [(BEFORE, BEFORE)],
        ),
        (
            "b", "pi/6", "synphase", CORRECTED,
            "n_x > 1: always synphase.", [(AFTER, WIDE)],
        ),
        (
            "c", "pi/3", "antiphase", NOT_REPRODUCED,
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
            "d", "5 pi/12", "antiphase", NOT_REPRODUCED,
            "n_x < 1, n_phi < 1: antiphase.", [(BEFORE, BEFORE)],
        ),
        (
            "d", "5 pi/12", "both", CORRECTED,
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
    "theory_against_orbits", "abstract, 6", "Simulations verify the theory.", NOT_REPRODUCED,
    ", ".join(
        f"beta = {name}: {{shares[{i}]:.0%}} of classes agree, {{lost[{i}]:.0%}} without a stable "
        f"orbit, median difference {{gaps[{i}]:.2g}} rad"
        for i, name in PLACES
    )
    + "; the dampers of table 1, above all f_phi, which (30) leaves out, shift phases and end "
    "synchronism around n_phi = 1 to 2",
    regions.theory_on_map, regions.theory_against_engine,
    engines=" / ".join(f"{{agree[{i}]:.0%}}" for i, _ in PLACES),
    judgement=corrected(Condition("shares", ">=", GOOD)), slow=True,
)  # fmt: skip

CONCLUSIONS: tuple[LedgerRow, ...] = (
    misprint(
        "phase_sign", "5.2, case 1", "Sign of the theoretical phase difference.", CORRECTED,
        "(30) is off by 0.25 of its amplitude at +3.013 rad, by 0.0002 at -3.013 rad",
        printed="3.013 rad",
        erratum=Erratum(
            TESTS + "test_the_papers_phases_need_the_corrected_coefficient"
        ),
    ),
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
        NOT_REPRODUCED, NO_COUPLING,
        cases.coupling_of_case_3, judgement=holds(below("undamped", 1e-6)), slow=True,
    ),
    statement(
        "screens", "6", "Elliptical vibrating screens may be designed with it.", NOT_TESTABLE,
        "an outlook on use, of which the paper gives no numbers",
    ),
)  # fmt: skip

ROWS: tuple[LedgerRow, ...] = (
    *MODEL,
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

CAUSES: tuple[Cause, ...] = ()
