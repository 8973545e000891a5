"""The ledger of the hula_hoop paper, sections 5.2 and 6: what figs. 4-7 are said to show."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from ....reference.hula_hoop.theory import paper_solution
from ..ledger import CORRECTED, NOT_REPRODUCED, REPRODUCED, Finding, Row, claimed, number
from ..session import Session
from .results import (
    HERTZ,
    NATURAL,
    STABILITIES,
    agreement,
    everyone,
    grid,
    is_class,
    motion_map,
    on_grid,
    own_maps,
    regions,
    stability_map,
    stable,
    told,
)

GOOD = 0.9
"""Share of points from which on two figures are said to agree well."""
MOST = 0.5
"""Share from which on a region is said to be of a kind."""


def stable_zone(session: Session) -> Finding:
    """Region II of fig. 4: the rotation is stable."""
    said, true = (stable(session, False, name) for name in ("paper", "exact"))
    better = stable(session, False, "corrected")
    right, ours = float(np.mean(true[said])), float(np.mean(true[better]))
    verdict = REPRODUCED if right >= GOOD else CORRECTED if ours >= GOOD else NOT_REPRODUCED
    return Finding(
        verdict,
        f"the true rotation is stable at {right:.0%} of the points where the printed solution "
        f"is, and at {ours:.0%} of those where the one with the phase theta_0 is",
        f"{right:.0%}",
        engine_stable_shares(session, said),
    )


def engine_stable_shares(session: Session, said: Any) -> dict[str, str]:
    """Return at how many of some points (n_y, n_x) an engine's own rotation is stable."""
    found = {}
    for name in session.engines:
        own = stability_map(session, False, name)
        here = on_grid(session, own, said) & (own.computed == 1)
        found[name] = f"{np.mean(is_class(own, 'stability', 'stable')[here]):.0%} where computed"
    return found


def unstable_regions(plate: bool, printed: str) -> Callable[[Session], Finding]:
    """Return the row that counts the unstable regions of fig. 4, or 6 (plate)."""

    def find(session: Session) -> Finding:
        counts = {name: len(regions(~stable(session, plate, name))) for name in STABILITIES}
        words = ", ".join(f"{words} {counts[name]}" for name, words in STABILITIES.items())
        as_printed = counts["printed"] == int(printed)
        return number(
            printed,
            counts["printed" if as_printed else "paper"],
            because=f"connected regions of 2 points or more: {words}",
            corrected=not as_printed,
        )

    return find


def small_regions_red(session: Session) -> Finding:
    """Regions III, IV, V of fig. 4 have red o alone."""
    u_1 = np.abs(paper_solution(grid(session, False)).u_1)
    small = regions(~stable(session, False, "paper"))[1:]
    largest = max((float(u_1[region].max()) for region in small), default=float("nan"))
    return claimed(
        largest < 0.5,
        f"largest |u_1| of the {len(small)} unstable regions beside region I: {largest:.2f} rad "
        "(printed solution, (55) corrected)",
        reference=f"{largest:.3f} rad",
        corrected=True,
    )


def no_stable_above_half(session: Session) -> Finding:
    """|u_1| < 0.5 is needed for hula-hoop motion."""
    counts = {}
    for model in ("paper", "exact"):
        pairs = [(stability_map(session, plate, model=model)) for plate in (False, True)]
        counts[model] = [
            int(np.sum((found.variables["u_1"] >= 0.5) & is_class(found, "stability", kind)))
            for found in pairs
            for kind in ("stable", "unstable")
        ]
    large, calm = sum(counts["exact"]), sum(counts["exact"][::2])
    return claimed(
        calm == 0,
        f"of {large} true rotations of figs. 4 and 6 with |u_1| of 0.5 or more {calm} are stable "
        f"({counts['exact'][0]} of them without inertia); of {sum(counts['paper'])} printed "
        f"solutions {sum(counts['paper'][::2])}",
        reference=f"{calm} stable",
    )


def unstable_small(session: Session) -> Any:
    """Return the red zone of fig. 4 (n_y, n_x): unstable though |u_1| < 0.5."""
    u_1 = np.abs(paper_solution(grid(session, False)).u_1)
    return ~stable(session, False, "paper") & (u_1 < 0.5)


def red_zone(session: Session) -> Finding:
    """In the red zone the free mass moves to and fro."""
    motion = motion_map(session, False)
    here = unstable_small(session) & (motion.variables["robust"] == 1)
    hoop = float(np.mean(is_class(motion, "motion", "blue_o")[here]))
    reversing = float(np.mean(motion.variables["min_speed"][here] < 0))
    return claimed(
        hoop <= 1 - GOOD and reversing >= GOOD,
        f"of {int(here.sum())} robust points there {hoop:.0%} have hula-hoop motion from rest, and "
        f"{reversing:.0%} reversals",
        reference=f"{reversing:.0%} with reversals",
    )


def larger_reversal(session: Session) -> Finding:
    """The larger |u_1|, the larger the reversal."""
    motion = motion_map(session, False)
    u_1 = np.abs(paper_solution(grid(session, False)).u_1)
    depth = -motion.variables["min_speed"]
    here = unstable_small(session) & (motion.variables["robust"] == 1) & np.isfinite(depth)
    rank = float(spearmanr(u_1[here], depth[here]).statistic)
    return claimed(
        rank > 0.5,
        f"rank correlation of |u_1| with the largest backward speed over {int(here.sum())} robust "
        "points of the red zone",
        reference=f"{rank:.2f}",
    )


def reversal_from_half(session: Session) -> Finding:
    """The oscillation may cause reversals where |u_1| is 0.5 or more."""
    exact = stability_map(session, False)
    u_1, least = exact.variables["u_1"], exact.variables["min_speed"]
    calm = is_class(exact, "stability", "stable")
    above, below = u_1 >= 0.5, (u_1 < 0.5) & calm
    rates = [float(np.mean(least[where] < 0)) for where in (above, below)]
    return claimed(
        rates[0] >= GOOD,
        "theta' = omega (1 - 2 u_1 sin psi) turns negative at 0.5 exactly; the true rotation has "
        f"reversals at {rates[0]:.0%} of the points with u_1 of 0.5 or more, and at "
        f"{rates[1]:.0%} of the stable ones below",
        reference=f"{rates[0]:.0%}",
    )


def good_agreement(plate: bool) -> Callable[[Session], Finding]:
    """Return the row on the agreement of figs. 4 and 5, or 6 and 7 (plate)."""

    def find(session: Session) -> Finding:
        found = {name: agreement(session, plate, name) for name in STABILITIES}
        words = "; ".join(f"{STABILITIES[name]} {a.share:.1%}" for name, a in found.items())
        one = found["paper"]
        if found["printed"].share >= GOOD:
            verdict = REPRODUCED
        else:
            fits = max(found[name].share for name in ("paper", "corrected")) >= GOOD
            verdict = CORRECTED if fits else NOT_REPRODUCED
        return Finding(
            verdict,
            f"share of {one.points} robust points where stable and hula-hoop from rest are both "
            f"true or both false: {words}. {GOOD:.0%} would be good; the same answer everywhere "
            f"reaches {one.trivial:.1%}",
            f"{one.share:.1%}",
            {name: own_agreement(session, plate, name) for name in session.engines},
        )

    return find


def own_agreement(session: Session, plate: bool, engine: str) -> str:
    """Return how well an engine's own rotation tells where it gets from rest."""
    calm, hoop, _ = own_maps(session, plate, engine)
    return f"own rotation {np.mean(calm == hoop):.1%} of {len(hoop)} points"


def share_of(session: Session, plate: bool, here: Any, *names: str) -> tuple[float, int]:
    """Return the share of classes among the robust points of a region, and their number."""
    motion = motion_map(session, plate)
    robust = here & (motion.variables["robust"] == 1)
    kinds = np.any([is_class(motion, "motion", name) for name in names], axis=0)
    return (float(np.mean(kinds[robust])) if np.any(robust) else float("nan")), int(robust.sum())


def motion_shares(session: Session, plate: bool, *names: str) -> dict[str, Any]:
    """Return the shares of classes in all of fig. 5, or 7 (plate), by the reference and engines."""

    def tell(engine: str) -> str:
        motion = motion_map(session, plate, engine)
        return f"{np.mean([is_class(motion, 'motion', n) for n in names], axis=(1, 2)).sum():.1%}"

    return told(session, tell)


def region_2(session: Session) -> Finding:
    """Region II of fig. 5: blue o."""
    share, count = share_of(session, False, stable(session, False, "paper"), "blue_o")
    return claimed(
        share >= GOOD,
        f"{share:.0%} of the {count} robust points where the printed solution is stable; all over "
        "the figure",
        **motion_shares(session, False, "blue_o"),
    )


def region_1(session: Session) -> Finding:
    """Region I of fig. 5: red x."""
    largest = regions(~stable(session, False, "paper"))[0]
    share, count = share_of(session, False, largest, "red_x")
    motion = motion_map(session, False)
    red = largest & is_class(motion, "motion", "red_x")
    reversing = float(np.mean(motion.variables["min_speed"][red] < 0)) if np.any(red) else 0.0
    return claimed(
        share >= MOST and reversing >= GOOD,
        f"{share:.0%} of the {count} robust points of the largest unstable region of fig. 4; "
        f"{reversing:.0%} of these points have reversals; all over the figure",
        **motion_shares(session, False, "red_x"),
    )


def near(where: Any, cells: int = 2) -> Any:
    """Return which points (n_y, n_x) lie within some cells of others."""
    found = where.copy()
    for _ in range(cells):
        wide = np.pad(found, 1)
        rows, columns = found.shape
        found = np.any(
            [wide[i : i + rows, j : j + columns] for i in range(3) for j in range(3)], axis=0
        )
    return found


def transition(session: Session) -> Finding:
    """Cyan + between regions I and II."""
    motion = motion_map(session, False)
    cyan, red = (is_class(motion, "motion", name) for name in ("cyan_plus", "red_x"))
    blue = is_class(motion, "motion", "blue_o") | is_class(motion, "motion", "blue_plus")
    between = float(np.mean((near(red) & near(blue))[cyan])) if np.any(cyan) else 0.0
    return claimed(
        between >= MOST,
        f"{between:.0%} of the {int(cyan.sum())} such points lie within two cells of both "
        "rotation and its absence; all over the figure",
        **motion_shares(session, False, "cyan_plus"),
    )


def region_3(session: Session) -> Finding:
    """Region III of fig. 5: cyan o, hula-hoop motion at first and none in the end."""
    motion = motion_map(session, False)
    cyan = is_class(motion, "motion", "cyan_o")
    count = int(cyan.sum())
    unstable = int(np.sum(~stable(session, False, "exact") & cyan))
    periods, f_u = (motion.variables[name][cyan] for name in ("periods", "f_u"))
    first = int(np.sum((periods == 1) & (np.abs(f_u - 1) < 0.02)))
    return claimed(
        count > 0 and unstable >= MOST * count,
        f"{count} points turn once per period without reversal and oscillate at another frequency; "
        f"they do so in the steady state. The rotation is unstable at {unstable} of them; at "
        f"{first} it is stable and repeats in each period, its symmetry of half a period lost, so "
        "that f_u = omega",
        **motion_shares(session, False, "cyan_o"),
    )


def less_accurate(session: Session) -> Finding:
    """The approximate analysis is less accurate than direct integration."""
    wrong = stable_apart(session)
    return claimed(
        min(wrong["paper"]) > 0,
        "stable or not against the true rotation, points of figs. 4 and 6 that differ: "
        f"{wrong['paper'][0]:.0%} and {wrong['paper'][1]:.0%}",
        reference=f"{wrong['paper'][0]:.1%} and {wrong['paper'][1]:.1%}",
    )


def stable_apart(session: Session) -> dict[str, list[float]]:
    """Return shares of points of figs. 4, 6 where a solution is wrong about stability."""
    return {
        name: [
            float(np.mean(stable(session, plate, name) != stable(session, plate, "exact")))
            for plate in (False, True)
        ]
        for name in ("paper", "corrected")
    }


def harmonics_are_the_reason(session: Session) -> Finding:
    """Omitted harmonics are the reason."""
    wrong = stable_apart(session)
    kept = [b / a for a, b in zip(wrong["paper"], wrong["corrected"], strict=True)]
    return claimed(
        min(kept) > MOST,
        "with the same two harmonics and the phase theta_0 the points that are wrong fall from "
        f"{wrong['paper'][0]:.0%} to {wrong['corrected'][0]:.0%} (point mass) and from "
        f"{wrong['paper'][1]:.0%} to {wrong['corrected'][1]:.0%} (plate): the missing phase is the "
        "larger part",
        reference=f"{kept[0]:.0%} and {kept[1]:.0%} are left",
    )


def inertia_shrinks(session: Session) -> Finding:
    """Figs. 4 and 6: with inertia the unstable regions are smaller."""
    parts = {
        name: [float(np.mean(~stable(session, plate, name))) for plate in (False, True)]
        for name in STABILITIES
    }
    words = "; ".join(f"{STABILITIES[name]} {a:.0%} to {b:.0%}" for name, (a, b) in parts.items())
    return claimed(
        all(b < a for a, b in parts.values()),
        f"share of unstable points, without and with inertia: {words}",
        reference="{:.1%} to {:.1%}".format(*parts["exact"]),
    )


def between(session: Session, where: Any, low: float, high: float) -> float:
    """Return the share of all points that lie in a region, in a range of frequencies [Hz]."""
    frequency: Any = grid(session, False).force_frequency
    return float(np.mean(where & (frequency >= low) & (frequency < high)))


def unstable_below(low: float, high: float) -> Callable[[Session], Finding]:
    """Return the row that compares figs. 4 and 6 in a range of natural frequencies."""

    def find(session: Session) -> Finding:
        sizes = {
            name: [
                between(session, ~stable(session, plate, name), low * NATURAL, high * NATURAL)
                for plate in (False, True)
            ]
            for name in ("paper", "exact")
        }
        words = {name: "{:.1%} to {:.1%}".format(*pair) for name, pair in sizes.items()}
        return claimed(
            all(0 < after < before for before, after in sizes.values()),
            f"unstable points from {max(low * NATURAL, HERTZ[0]):.2f} to {high * NATURAL:.2f} Hz, "
            f"of all: printed solution, (55) corrected {words['paper']}; true rotation "
            f"{words['exact']}",
            reference=words["exact"],
        )

    return find


def fewer_red(session: Session) -> Finding:
    """Figs. 5 and 7: the left part of region I is smaller."""

    def share(plate: bool, engine: str) -> float:
        motion = motion_map(session, plate, engine)
        left = motion.x.values < NATURAL
        return float(np.mean(is_class(motion, "motion", "red_x") & left))

    found = {name: (share(False, name), share(True, name)) for name in everyone(session)}
    return claimed(
        all(after < before for before, after in found.values()),
        f"red x below the natural frequency of {NATURAL:.2f} Hz, of all points",
        **told(session, lambda name: "{:.1%} to {:.1%}".format(*found[name])),
    )


def fewer_cyan(session: Session) -> Finding:
    """Figs. 5 and 7: region III, and cyan o, become smaller."""

    def share(plate: bool, engine: str) -> float:
        return float(np.mean(is_class(motion_map(session, plate, engine), "motion", "cyan_o")))

    found = {name: (share(False, name), share(True, name)) for name in everyone(session)}
    periods = motion_map(session, True).variables["periods"]
    cyan = is_class(motion_map(session, True), "motion", "cyan_o")
    several = int(np.sum(periods[cyan] > 1))
    return claimed(
        found["reference"][1] < found["reference"][0],
        f"cyan o of all points, without and with inertia; with it {several} of {int(cyan.sum())} "
        "are rotations that repeat after several periods",
        **told(session, lambda name: "{:.1%} to {:.1%}".format(*found[name])),
    )


def easier_with_inertia(session: Session) -> Finding:
    """Hula-hoop motion is obtained more easily with inertia."""

    def share(plate: bool, engine: str) -> float:
        return float(np.mean(is_class(motion_map(session, plate, engine), "motion", "blue_o")))

    found = {name: (share(False, name), share(True, name)) for name in everyone(session)}
    return claimed(
        all(b > a for a, b in found.values()),
        "share of points with hula-hoop motion from rest, without and with inertia",
        **told(session, lambda name: "{:.1%} to {:.1%}".format(*found[name])),
    )


# 6


def adequate(session: Session) -> Finding:
    """Agreement shows that the approximate solutions are adequate."""
    shown = {
        name: [agreement(session, plate, name).share for plate in (False, True)]
        for name in ("paper", "corrected")
    }
    fits = {name: min(values) >= GOOD for name, values in shown.items()}
    verdict = REPRODUCED if fits["paper"] else CORRECTED if fits["corrected"] else NOT_REPRODUCED
    return Finding(
        verdict,
        "agreement of figs. 4 and 5, 6 and 7: printed solution {:.0%}, {:.0%}; with its phase "
        "{:.0%}, {:.0%}".format(*shown["paper"], *shown["corrected"]),
        "{:.1%}, {:.1%}".format(*shown["paper"]),
    )


def large_set(session: Session) -> Finding:
    """The rotation is stable for many frequencies and amplitudes."""
    parts = [float(np.mean(stable(session, plate, "exact"))) for plate in (False, True)]
    engines = {}
    for name in session.engines:
        own = [
            np.mean(is_class(stability_map(session, plate, name), "stability", "stable"))
            for plate in (False, True)
        ]
        engines[name] = "{:.0%}, {:.0%}".format(*own)
    return claimed(
        min(parts) > 0.25,
        "share of the points of figs. 4 and 6 where the true rotation is stable; a quarter would "
        "do",
        reference="{:.0%}, {:.0%}".format(*parts),
        engines=engines,
    )


ROWS: tuple[Row, ...] = (
    Row(
        "stable_zone",
        "claim",
        "5.2, figure 4",
        "Region II: the rotation is stable.",
        stable_zone,
        slow=True,
    ),
    Row(
        "unstable_regions_4",
        "number",
        "5.2, figure 4",
        "Unstable regions without inertia: I, III, IV, V.",
        unstable_regions(False, "4"),
        printed="4",
        slow=True,
    ),
    Row(
        "unstable_regions_6",
        "number",
        "5.2, figure 6",
        "Unstable regions with inertia: I, III, IV.",
        unstable_regions(True, "3"),
        printed="3",
        slow=True,
    ),
    Row(
        "small_regions_red",
        "claim",
        "5.2, figure 4",
        "The unstable regions III, IV and V have |u_1| < 0.5 (red o) throughout.",
        small_regions_red,
        slow=True,
    ),
    Row(
        "no_stable_above_half",
        "claim",
        "5.2, figures 4, 6",
        "Hula-hoop motion needs |u_1| < 0.5.",
        no_stable_above_half,
        slow=True,
    ),
    Row(
        "red_zone",
        "claim",
        "5.2, figure 4",
        "In the red zone there is no hula-hoop motion though |u_1| < 0.5: the mass reverses.",
        red_zone,
        slow=True,
    ),
    Row(
        "larger_reversal",
        "claim",
        "5.2, figure 4",
        "In the red zone a larger |u_1| means larger reversals.",
        larger_reversal,
        slow=True,
    ),
    Row(
        "reversal_from_half",
        "claim",
        "5.2",
        "The oscillation u_1 cos(..) makes the rotation reverse from |u_1| = 0.5 on.",
        reversal_from_half,
        slow=True,
    ),
    Row(
        "good_agreement_4_5",
        "claim",
        "5.2, figures 4, 5",
        "Figures 4 and 5 agree well.",
        good_agreement(False),
        slow=True,
    ),
    Row(
        "region_2",
        "claim",
        "5.2, figure 5",
        "In region II hula-hoop motion occurs from rest (blue o).",
        region_2,
        slow=True,
    ),
    Row(
        "region_1",
        "claim",
        "5.2, figure 5",
        "In region I there is none (red x).",
        region_1,
        slow=True,
    ),
    Row(
        "transition",
        "claim",
        "5.2, figure 5",
        "Between regions I and II the free mass reverses again and again (cyan +).",
        transition,
        slow=True,
    ),
    Row(
        "region_3",
        "claim",
        "5.2, figure 5",
        "In region III hula-hoop motion shows at first, at another frequency, and is unstable "
        "(cyan o).",
        region_3,
        slow=True,
    ),
    Row(
        "less_accurate",
        "claim",
        "5.2",
        "The stability of the approximate solutions is less accurate than direct integration.",
        less_accurate,
        slow=True,
    ),
    Row(
        "harmonics_are_the_reason",
        "claim",
        "5.2",
        "That is because harmonics above alpha in (7) and 2 alpha in (8) are left out.",
        harmonics_are_the_reason,
        slow=True,
    ),
    Row(
        "inertia_shrinks",
        "claim",
        "5.2, figures 4, 6",
        "With inertia the unstable regions I, III, IV are smaller.",
        inertia_shrinks,
        slow=True,
    ),
    Row(
        "left_of_region_1",
        "claim",
        "5.2, figures 4, 6",
        "With inertia the left part of region I, which reaches down in figure 4, is smaller.",
        unstable_below(0.5, 1.0),
        slow=True,
    ),
    Row(
        "region_3_shrinks",
        "claim",
        "5.2, figures 4, 6",
        "With inertia the slim region III is smaller.",
        unstable_below(0.0, 0.5),
        slow=True,
    ),
    Row(
        "good_agreement_6_7",
        "claim",
        "5.2, figures 6, 7",
        "Figures 6 and 7 agree well.",
        good_agreement(True),
        slow=True,
    ),
    Row(
        "fewer_red",
        "claim",
        "5.2, figures 5, 7",
        "With inertia the left part of region I (red x) is smaller.",
        fewer_red,
        slow=True,
    ),
    Row(
        "fewer_cyan",
        "claim",
        "5.2, figures 5, 7",
        "With inertia region III is smaller and cyan o are fewer.",
        fewer_cyan,
        slow=True,
    ),
    Row(
        "easier_with_inertia",
        "claim",
        "5.2",
        "Hula-hoop motion is obtained more easily with inertia.",
        easier_with_inertia,
        slow=True,
    ),
    Row(
        "adequate",
        "claim",
        "6",
        "The approximate solutions are adequate for the dynamics of this device.",
        adequate,
        slow=True,
    ),
    Row(
        "large_set",
        "claim",
        "6",
        "The rotation is stable for a large set of frequencies and amplitudes.",
        large_set,
        slow=True,
    ),
)
