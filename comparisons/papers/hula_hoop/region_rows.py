"""The ledger of the hula_hoop paper: sections 5.2 and 6, what figures 4-7 are said to show."""

from __future__ import annotations

from functools import partial

from ..ledger import (
    CORRECTED,
    DEPENDS,
    NOT_REPRODUCED,
    OPEN,
    PRINTED,
    REPRODUCED,
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
from . import boundaries, regions, transients
from .results import NATURAL, STABILITIES

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
        partial(boundaries.distances, plate=figure == 6),
        partial(boundaries.distances_by, plate=figure == 6),
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
        f"{transients.PASSING} and {transients.LASTING} periods of the force among the first "
        f"{transients.TRANSIENT} from rest: {{both[0]:.0%}} of the {{count}} points of fig. 5, "
        "{both[1]:.0%} of those of fig. 7. In the end none, by this class; but there they all turn "
        "on in one sense, a turn per period, as section 5 has it of the ideal",
        transients.transients_of_both, reference="{passing:.0%}, {lasting:.0%}",
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
