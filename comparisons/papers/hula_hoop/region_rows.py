"""The ledger of the hula_hoop paper: sections 5.2 and 6, what figures 4-7 are said to show."""

from __future__ import annotations

from functools import partial

from ..ledger import (
    CORRECTED,
    NOT_REPRODUCED,
    REPRODUCED,
    ROUNDS,
    Condition,
    LedgerRow,
    above,
    below,
    corrected,
    equal,
    holds,
    number,
    statement,
)
from . import regions
from .results import NATURAL, STABILITIES

GOOD = 0.9
"""Share of points from which on two figures are said to agree well."""
MOST = 0.5
"""Share from which on a region is said to be of a kind."""

AGREEMENTS = "; ".join(f"{words} {{{name}:.1%}}" for name, words in STABILITIES.items())


def good_agreement(stability: int, verdict: str) -> LedgerRow:
    """Return the row on the agreement of figure 4 with 5, or 6 with 7."""
    motion, plate = stability + 1, stability == 6
    return statement(
        f"good_agreement_{stability}_{motion}", f"5.2, figures {stability}, {motion}",
        f"Figures {stability} and {motion} agree well.", verdict,
        "share of {points} robust points where stable and hula-hoop from rest are both true or "
        f"both false: {AGREEMENTS}. {GOOD:.0%} would be good; the same answer everywhere reaches "
        "{trivial:.1%}",
        partial(regions.agreements, plate=plate), partial(regions.own_agreement, plate=plate),
        "{paper:.1%}", "own rotation {share:.1%} of {count} points",
        {
            **holds(Condition("printed", ">=", GOOD)),
            **corrected(Condition("best", ">=", GOOD)),
        },
        slow=True,
    )  # fmt: skip


def unstable_regions(figure: int, summary: str, verdict: str, printed: str) -> LedgerRow:
    """Return the row that counts the unstable regions of figure 4 or 6."""
    return number(
        f"unstable_regions_{figure}", f"5.2, figure {figure}", summary, verdict,
        "connected regions of 2 points or more: {counts}",
        partial(regions.unstable_regions, plate=figure == 6, printed=printed),
        judgement={**holds(equal("as_printed", True), ROUNDS), **corrected(ROUNDS)},
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


FIGURE_4: tuple[LedgerRow, ...] = (
    statement(
        "stable_zone", "5.2, figure 4", "Region II: the rotation is stable.", CORRECTED,
        "the true rotation is stable at {paper:.0%} of the points where the printed solution is, "
        "and at {corrected:.0%} of those where the one with the phase theta_0 is",
        regions.stable_zone, regions.stable_zone_by, "{share:.0%}", "{share:.0%} where computed",
        {
            **holds(Condition("paper", ">=", GOOD)),
            **corrected(Condition("corrected", ">=", GOOD)),
        },
        slow=True,
    ),
    unstable_regions(4, "Unstable regions without inertia: I, III, IV, V.", NOT_REPRODUCED, "4"),
    unstable_regions(6, "Unstable regions with inertia: I, III, IV.", CORRECTED, "3"),
    statement(
        "small_regions_red", "5.2, figure 4",
        "The unstable regions III, IV and V have |u_1| < 0.5 (red o) throughout.",
        CORRECTED,
        "largest |u_1| of the {count} unstable regions beside region I: {largest:.2f} rad (printed "
        "solution, (55) corrected)",
        regions.small_regions, reference="{largest:.3f} rad",
        judgement=corrected(below("largest", 0.5)), slow=True,
    ),
    statement(
        "no_stable_above_half", "5.2, figures 4, 6", "Hula-hoop motion needs |u_1| < 0.5.",
        NOT_REPRODUCED,
        "of {large} true rotations of figs. 4 and 6 with |u_1| of 0.5 or more {calm} are stable "
        "({without} of them without inertia); of {printed} printed solutions {printed_calm}",
        regions.stable_above_half, reference="{calm} stable",
        judgement=holds(equal("calm", 0)), slow=True,
    ),
    statement(
        "red_zone", "5.2, figure 4",
        "In the red zone there is no hula-hoop motion though |u_1| < 0.5: the mass reverses.",
        NOT_REPRODUCED,
        "of {count} robust points there {hoop:.0%} have hula-hoop motion from rest, and "
        "{reversing:.0%} reversals",
        regions.red_zone, reference="{reversing:.0%} with reversals",
        judgement=holds(Condition("hoop", "<=", 1 - GOOD), Condition("reversing", ">=", GOOD)),
        slow=True,
    ),
    statement(
        "larger_reversal", "5.2, figure 4",
        "In the red zone a larger |u_1| means larger reversals.",
        REPRODUCED,
        "rank correlation of |u_1| with the largest backward speed over {known} robust points of "
        "the red zone",
        regions.red_zone, reference="{rank:.2f}", judgement=holds(above("rank", 0.5)), slow=True,
    ),
    statement(
        "reversal_from_half", "5.2",
        "The oscillation u_1 cos(..) makes the rotation reverse from |u_1| = 0.5 on.",
        REPRODUCED,
        "theta' = omega (1 - 2 u_1 sin psi) turns negative at 0.5 exactly; the true rotation has "
        "reversals at {above:.0%} of the points with u_1 of 0.5 or more, and at {below:.0%} of the "
        "stable ones below",
        regions.reversals_by_u_1, reference="{above:.0%}",
        judgement=holds(Condition("above", ">=", GOOD)), slow=True,
    ),
    good_agreement(4, CORRECTED),
)  # fmt: skip

FIGURE_5: tuple[LedgerRow, ...] = (
    statement(
        "region_2", "5.2, figure 5", "In region II hula-hoop motion occurs from rest (blue o).",
        NOT_REPRODUCED,
        "{share:.0%} of the {count} robust points where the printed solution is stable; all over "
        "the figure",
        regions.region_2, partial(regions.share_of_class, name="blue_o"), "{value:.1%}",
        judgement=holds(Condition("share", ">=", GOOD)), slow=True,
    ),
    statement(
        "region_1", "5.2, figure 5", "In region I there is none (red x).", REPRODUCED,
        "{share:.0%} of the {count} robust points of the largest unstable region of fig. 4; "
        "{reversing:.0%} of these points have reversals; all over the figure",
        regions.region_1, partial(regions.share_of_class, name="red_x"), "{value:.1%}",
        judgement=holds(Condition("share", ">=", MOST), Condition("reversing", ">=", GOOD)),
        slow=True,
    ),
    statement(
        "transition", "5.2, figure 5",
        "Between regions I and II the free mass reverses again and again (cyan +).",
        REPRODUCED,
        "{between:.0%} of the {count} such points lie within two cells of both rotation and its "
        "absence; all over the figure",
        regions.transition, partial(regions.share_of_class, name="cyan_plus"), "{value:.1%}",
        judgement=holds(Condition("between", ">=", MOST)), slow=True,
    ),
    statement(
        "region_3", "5.2, figure 5",
        "In region III hula-hoop motion shows at first, at another frequency, and is unstable "
        "(cyan o).",
        NOT_REPRODUCED,
        "{count} points turn once per period without reversal and oscillate at another frequency; "
        "they do so in the steady state. The rotation is unstable at {unstable} of them; at "
        "{first} it is stable and repeats in each period, its symmetry of half a period lost, so "
        "that f_u = omega",
        regions.region_3, partial(regions.share_of_class, name="cyan_o"), "{value:.1%}",
        judgement=holds(Condition("share", ">=", MOST)), slow=True,
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
        "harmonics_are_the_reason", "5.2",
        "That is because harmonics above alpha in (7) and 2 alpha in (8) are left out.",
        NOT_REPRODUCED,
        "with the same two harmonics and the phase theta_0 the points that are wrong fall from "
        "{paper[0]:.0%} to {corrected[0]:.0%} (point mass) and from {paper[1]:.0%} to "
        "{corrected[1]:.0%} (plate): the missing phase is the larger part",
        regions.wrong_about_stability, reference="{left[0]:.0%} and {left[1]:.0%} are left",
        judgement=holds(above("left", MOST)), slow=True,
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
    good_agreement(6, NOT_REPRODUCED),
    statement(
        "fewer_red", "5.2, figures 5, 7",
        "With inertia the left part of region I (red x) is smaller.",
        REPRODUCED, f"red x below the natural frequency of {NATURAL:.2f} Hz, of all points",
        each=partial(regions.class_by_inertia, name="red_x", below=NATURAL),
        reference="{shares[0]:.1%} to {shares[1]:.1%}",
        judgement=holds(below("change", 0, everyone=True)), slow=True,
    ),
    statement(
        "fewer_cyan", "5.2, figures 5, 7",
        "With inertia region III is smaller and cyan o are fewer.",
        NOT_REPRODUCED,
        "cyan o of all points, without and with inertia; with it {several} of {count} are "
        "rotations that repeat after several periods",
        regions.cyan_of_several_periods, partial(regions.class_by_inertia, name="cyan_o"),
        "{shares[0]:.1%} to {shares[1]:.1%}", judgement=holds(below("change", 0)), slow=True,
    ),
    statement(
        "easier_with_inertia", "5.2", "Hula-hoop motion is obtained more easily with inertia.",
        REPRODUCED, "share of points with hula-hoop motion from rest, without and with inertia",
        each=partial(regions.class_by_inertia, name="blue_o"),
        reference="{shares[0]:.1%} to {shares[1]:.1%}",
        judgement=holds(above("change", 0, everyone=True)), slow=True,
    ),
    statement(
        "adequate", "6",
        "The approximate solutions are adequate for the dynamics of this device.",
        NOT_REPRODUCED,
        "agreement of figs. 4 and 5, 6 and 7: printed solution {paper:.0%}; with its phase "
        "{corrected:.0%}",
        regions.both_agreements, reference="{paper:.1%}",
        judgement={
            **holds(Condition("paper", ">=", GOOD)),
            **corrected(Condition("corrected", ">=", GOOD)),
        },
        slow=True,
    ),
    statement(
        "large_set", "6", "The rotation is stable for a large set of frequencies and amplitudes.",
        REPRODUCED,
        "share of the points of figs. 4 and 6 where the true rotation is stable; a quarter would "
        "do",
        each=regions.stable_by_inertia, reference="{shares:.0%}",
        judgement=holds(above("shares", 0.25)), slow=True,
    ),
)  # fmt: skip

REGION_ROWS: tuple[LedgerRow, ...] = (*FIGURE_4, *FIGURE_5, *INERTIA)
