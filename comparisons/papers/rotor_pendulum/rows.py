"""The ledger of the rotor_pendulum paper, and its figures; here sections 2-5.1 and 6.

P. Fang, Y. Hou, Y. Nan, L. Yu, Journal of Vibroengineering 17(5), 2015.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ....reference.rotor_pendulum import CASE_1, theory
from ..ledger import (
    CORRECTED,
    DEPENDS,
    NOT_REPRODUCED,
    NOT_TESTABLE,
    OPEN,
    REPRODUCED,
    Cause,
    Condition,
    LedgerRow,
    above,
    below,
    corrected,
    depends,
    equal,
    holds,
    number,
    statement,
)
from . import cases, derivation, limits, regions
from .case_rows import ABSENT, AGREE, CASE_ROWS, NO_COUPLING, RATIO_ROWS
from .figures import FIGURES as FIGURES
from .limits import SMALL_PARAMETER
from .misprints import FAILS, MISPRINTS
from .readings import READINGS
from .regions import AFTER, BEFORE
from .results import BETAS
from .vibration import IDENTITY, VIBRATION

SMALL = 0.1
"""Share that may be called small."""
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
        limits.speed_and_phase, judgement=holds(equal("roots", 1), equal("phases", 1)), slow=True,
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
