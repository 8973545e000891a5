"""The ledger of the hula_hoop paper, and its figures; here sections 1-5.1.

C. X. Lu, C. C. Wang, C. K. Sung, P. C. P. Chao, J. Vib. Acoust. 133, 014501 (2011).
"""

from __future__ import annotations

from ....reference.hula_hoop.equations import SEMICIRCLE, HulaHoop
from ....reference.hula_hoop.theory import nondimensional
from ..ledger import (
    CORRECTED,
    DEPENDS,
    NOT_TESTABLE,
    OPEN,
    PRINTED,
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
from . import derivation, example, identities
from .example import OMEGA
from .figures import FIGURES as FIGURES
from .identities import IDENTITIES
from .misprints import MISPRINTS
from .readings import READINGS
from .region_rows import REGION_ROWS
from .results import LOCKED, LONG_RUN

ROUNDING = 1e-10
"""Relative residual below which an identity holds."""
GOOD = 0.9
"""Share of points that may be called nearly all."""
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
        each=derivation.equations_of_motion,
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

EXAMPLE: tuple[LedgerRow, ...] = (
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
    *EXAMPLE,
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
