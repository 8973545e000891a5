"""Measures of the hula_hoop paper's figures 4-7, sections 5.2 and 6."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
from scipy.ndimage import binary_dilation
from scipy.stats import spearmanr

from ....reference.hula_hoop.theory import paper_solution
from ...engines.registry import REFERENCE
from ..ledger import Numbers, rounds_to
from ..session import Session
from .derivation import PHASES, TRIAL
from .results import (
    HERTZ,
    NATURAL,
    STABILITIES,
    agreement,
    grid,
    is_class,
    motion_map,
    on_grid,
    own_maps,
    regions,
    stability_map,
    stable,
)

PLATES = (False, True)
"""Without and with inertia: figures 4, 5 and figures 6, 7."""
SMALL = 0.1
"""Turns per period that chaotic motion may drift by in the window of the maps."""


# Figures 4 and 6: stability


def stable_zone(session: Session) -> Numbers:
    """Return where the true rotation is stable, of the points where the approximate ones are."""
    true = stable(session, False, "exact")
    return {
        name: float(np.mean(true[stable(session, False, name)])) for name in ("paper", "corrected")
    }


def stable_zone_by(session: Session, who: str) -> Numbers:
    """Return where a rotation is stable, of the points where the printed one is."""
    zone = stable(session, False, "paper")
    if who == REFERENCE:
        return {"share": stable_zone(session)["paper"]}
    own = stability_map(session, False, who)
    here = on_grid(session, own, zone) & (own.computed == 1)
    return {"share": np.mean(is_class(own, "stability", "stable")[here])}


PARTS = ((0.0, 1.0), (0.1, 0.8), (0.0, 0.6), (0.2, 1.0))
"""Parts of each axis of figures 4 and 6 that regions are counted on."""


def unstable_regions(session: Session, plate: bool, printed: str) -> Numbers:
    """Count unstable regions by each solution, on our axes and grid, and on parts of them.

    The value is that of the printed solution, of (55) as printed if it fits.
    """
    counts = {name: len(regions(~stable(session, plate, name))) for name in STABILITIES}
    fits = rounds_to(counts["printed"], printed)
    choices = np.array(
        [
            len(regions(part(~stable(session, plate, name), x, y)[::every, ::every], least))
            for name in ("paper", "corrected", "exact")
            for x in PARTS
            for y in PARTS
            for every in (1, 2)
            for least in (1, 2, 3)
        ]
    )
    return {
        "value": counts["printed" if fits else "paper"],
        "choices": choices,
        "least": choices.min(),
        "largest": choices.max(),
        "spread": np.ptp(choices),
        "counts": {words: counts[name] for name, words in STABILITIES.items()},
    }


def part(where: Any, x: tuple[float, float], y: tuple[float, float]) -> Any:
    """Return the part (n, m) of points (n_y, n_x) between shares of both axes."""
    rows, columns = (
        slice(*(round(share * size) for share in ends))
        for ends, size in zip((y, x), where.shape, strict=True)
    )
    return where[rows, columns]


def printed_u_1(session: Session, plate: bool = False) -> Any:
    """Return |u_1| (n_y, n_x) of the printed solution in figure 4, or 6 (plate)."""
    return np.abs(paper_solution(grid(session, plate)).u_1)


def colours_of_region_1(session: Session) -> Numbers:
    """Count points of region I in figure 4 with |u_1| below 0.5 (red), and from 0.5 on (black).

    With (55) corrected and as printed.
    """
    u_1, numbers = printed_u_1(session), {}
    for name in ("paper", "printed"):
        inside = u_1[regions(~stable(session, False, name))[0]]
        numbers[name] = [int(np.sum(inside < 0.5)), int(np.sum(inside >= 0.5))]
    return {**numbers, "least": min(*numbers["paper"], *numbers["printed"])}


def classes_of_figure_6(session: Session) -> Numbers:
    """Count points of figure 6 that are blue, red, black, and stable with |u_1| of 0.5 or more.

    With (55) corrected and as printed.
    """
    large, numbers = printed_u_1(session, plate=True) >= 0.5, {}
    for name in ("paper", "printed"):
        calm = stable(session, True, name)
        kinds = (calm & ~large, ~calm & ~large, ~calm & large, calm & large)
        numbers[name] = [int(np.sum(kind)) for kind in kinds]
    both = list(zip(*numbers.values(), strict=True))
    return {**numbers, "least": min(map(min, both[:3])), "others": max(both[3])}


def small_regions(session: Session) -> Numbers:
    """Return the number of unstable regions beside the largest, and the largest |u_1| in them.

    With (55) corrected and as printed.
    """
    u_1 = printed_u_1(session)
    numbers: dict[str, float] = {}
    for name, prefix in (("paper", ""), ("printed", "printed_")):
        small = regions(~stable(session, False, name))[1:]
        numbers[f"{prefix}count"] = len(small)
        numbers[f"{prefix}largest"] = max((u_1[region].max() for region in small), default=0.0)
    return numbers


def stable_above_half(session: Session) -> Numbers:
    """Count rotations of figures 4 and 6 with |u_1| of 0.5 or more, and the stable ones.

    Of the true ones those, too, that are stable and keep their sense.
    """
    exact, paper = (
        np.array(
            [
                [
                    np.sum((plane.variables["u_1"] >= 0.5) & is_class(plane, "stability", kind))
                    for kind in ("stable", "unstable")
                ]
                for plane in (stability_map(session, plate, model=model) for plate in PLATES)
            ]
        )
        for model in ("exact", "paper")
    )
    planes = [stability_map(session, plate) for plate in PLATES]
    hoop = [
        (plane.variables["u_1"] >= 0.5)
        & (plane.variables["min_speed"] >= 0)
        & is_class(plane, "stability", "stable")
        for plane in planes
    ]
    return {
        "hoop": int(np.sum(hoop)),
        "large": exact.sum(),
        "calm": exact[:, 0].sum(),
        "without": exact[0, 0],
        "printed": paper.sum(),
        "printed_calm": paper[:, 0].sum(),
    }


def reversals_by_u_1(session: Session) -> Numbers:
    """Return shares of true rotations with reversals: |u_1| of 0.5 or more, and stable below.

    And the least theta' of (17) with u_1 of 0.5, by omega.
    """
    motion = replace(TRIAL, u_1=0.5, gamma=np.pi / 2).motion(PHASES / TRIAL.alpha)
    slowest = float(np.min(motion.theta_dot) / TRIAL.alpha)
    exact = stability_map(session, False)
    u_1, least = exact.variables["u_1"], exact.variables["min_speed"]
    below = (u_1 < 0.5) & is_class(exact, "stability", "stable")
    return {
        "least": slowest,
        "off": abs(slowest),
        "above": np.mean(least[u_1 >= 0.5] < 0),
        "below": np.mean(least[below] < 0),
    }


def smoothness(session: Session) -> Numbers:
    """Return rank correlations of u_1 with 1 - min theta'/omega, of stable true rotations."""
    ranks = []
    for plate in PLATES:
        plane = stability_map(session, plate)
        here = is_class(plane, "stability", "stable")
        u_1, least = (plane.variables[name][here] for name in ("u_1", "min_speed"))
        ranks.append(float(spearmanr(u_1, 1 - least).statistic))
    return {"ranks": ranks}


def wrong_about_stability(session: Session) -> Numbers:
    """Return shares of points where solutions are wrong on stability, and what theta_0 leaves."""
    shares = by_plate(
        ("paper", "corrected"),
        lambda name, plate: stable(session, plate, name) != stable(session, plate, "exact"),
    )
    return {**shares, "left": np.divide(shares["corrected"], shares["paper"])}


def by_plate(names: Iterable[str], where: Callable[[str, bool], Any]) -> dict[str, list[float]]:
    """Return the shares of points of a solution without and with inertia, by its name."""
    return {name: [float(np.mean(where(name, plate))) for plate in PLATES] for name in names}


def unstable_by_inertia(
    session: Session, names: Iterable[str] = STABILITIES, low: float = 0.0, high: float = np.inf
) -> Numbers:
    """Return shares of unstable points without and with inertia, and how they change.

    In a range of natural frequencies, by default all; and the range [Hz].
    """
    frequency: Any = grid(session, False).force_frequency
    there = (frequency >= low * NATURAL) & (frequency < high * NATURAL)
    shares = by_plate(names, lambda name, plate: ~stable(session, plate, name) & there)
    return {
        **shares,
        "changes": [after - before for before, after in shares.values()],
        "after": [after for _, after in shares.values()],
        "low": max(low * NATURAL, HERTZ[0]),
        "high": high * NATURAL,
    }


def stable_by_inertia(session: Session, who: str) -> Numbers:
    """Return shares of the points of figures 4 and 6 where the rotation is stable."""
    maps = [stability_map(session, plate, who) for plate in PLATES]
    return {"shares": [np.mean(is_class(plane, "stability", "stable")) for plane in maps]}


# Figures 5 and 7: motion from rest


def share_of_class(session: Session, who: str, name: str, plate: bool = False) -> float:
    """Return the share of a class in all of figure 5, or 7 (plate)."""
    return float(np.mean(is_class(motion_map(session, plate, who), "motion", name)))


def class_by_inertia(session: Session, who: str, name: str, below: float = np.inf) -> Numbers:
    """Return the shares of a class in figures 5 and 7 below a frequency [Hz], and their change."""
    shares = [
        float(np.mean(is_class(motion, "motion", name) & (motion.x.values < below)))
        for motion in (motion_map(session, plate, who) for plate in PLATES)
    ]
    return {"shares": shares, "change": shares[1] - shares[0]}


def share(where: Any, of_none: float = np.nan) -> float:
    """Return the share of points at which something holds; there may be no point."""
    return float(np.mean(where)) if where.size else of_none


def cyan_in_region_1(session: Session) -> Numbers:
    """Count points of cyan o in region I without and with inertia, by three solutions.

    And those of figure 7, with those among them that repeat after several periods.
    """
    cyan = [is_class(motion_map(session, plate), "motion", "cyan_o") for plate in PLATES]
    counts = {
        STABILITIES[name]: [
            int(np.sum(here & regions(~stable(session, plate, name))[0]))
            for here, plate in zip(cyan, PLATES, strict=True)
        ]
        for name in ("paper", "corrected", "exact")
    }
    changes = [after - before for before, after in counts.values()]
    periods = motion_map(session, True).variables["periods"][cyan[1]]
    return {
        "counts": counts,
        "changes": changes,
        "least": min(changes),
        "several": int(np.sum(periods > 1)),
        "count": periods.size,
    }


def slow_cyan(session: Session) -> Numbers:
    """Count points of cyan o below half the natural frequency, in figures 5 and 7.

    And those of them that repeat in each period, without the symmetry of half a period.
    """
    counts: dict[str, list[int]] = {"every": [], "first": []}
    for plate in PLATES:
        motion = motion_map(session, plate)
        here = is_class(motion, "motion", "cyan_o") & (motion.x.values < NATURAL / 2)
        counts["every"].append(int(np.sum(here)))
        counts["first"].append(int(np.sum(here & (motion.variables["periods"] == 1))))
    return {**counts, **{f"{name}_change": two[1] - two[0] for name, two in counts.items()}}


def classes(session: Session) -> Numbers:
    """Count the points of each class in figures 5 and 7."""
    first, second = (
        {
            name.replace("_", " "): int(np.sum(is_class(motion, "motion", name)))
            for name in motion.about["motion"].classes
        }
        for motion in (motion_map(session, plate) for plate in PLATES)
    )
    return {"counts": first, "plate": second, "least": min(first.values())}


def red_x(session: Session) -> Numbers:
    """Return the share of red x of figure 5 that hardly turns, and how many lock otherwise."""
    motion = motion_map(session, False)
    here = is_class(motion, "motion", "red_x") & motion.robust
    locked = is_class(motion, "motion", "red_x") & is_class(motion, "label", "other_lock")
    return {
        "share": np.mean(motion.variables["turns"][here] < SMALL),
        "locked": int(np.sum(locked)),
    }


def robust_in(session: Session, here: Any, name: str) -> Numbers:
    """Return the share of a class among the robust points of a region of figure 5, their number."""
    motion = motion_map(session, False)
    there = is_class(motion, "motion", name)[here & motion.robust]
    return {"share": share(there), "count": there.size}


def region_2(session: Session) -> Numbers:
    """Return the share of hula-hoop motion where the printed solution is stable.

    And where that with theta_0 is; of this also the largest on parts of our axes.
    """
    calm, motion = stable(session, False, "corrected"), motion_map(session, False)
    other = robust_in(session, calm, "blue_o")
    hoop = is_class(motion, "motion", "blue_o")
    return {
        **robust_in(session, stable(session, False, "paper"), "blue_o"),
        "corrected": other["share"],
        "parts": largest_on_parts(hoop, calm & motion.robust),
    }


def largest_on_parts(right: Any, counted: Any) -> float:
    """Return the largest share, on parts of our axes, of those that are right, of the counted."""
    return max(
        share(part(right, *ends)[part(counted, *ends)], 0.0) for ends in product(PARTS, PARTS)
    )


def region_1(session: Session) -> Numbers:
    """Return the share of red x in the largest unstable region, and of reversals among them."""
    largest = regions(~stable(session, False, "paper"))[0]
    motion = motion_map(session, False)
    speeds = motion.variables["min_speed"][largest & is_class(motion, "motion", "red_x")]
    return {**robust_in(session, largest, "red_x"), "reversing": share(speeds < 0, 0.0)}


def red_zone(session: Session) -> Numbers:
    """Return what motions do where the rotation is unstable though |u_1| < 0.5, from rest.

    Shares without hula-hoop motion and with reversals, and the rank correlation of |u_1| with the
    largest backward speed.
    """
    motion, u_1 = motion_map(session, False), printed_u_1(session)
    here = ~stable(session, False, "paper") & (u_1 < 0.5) & motion.robust
    speed = motion.variables["min_speed"]
    known = here & np.isfinite(speed)
    return {
        "count": int(here.sum()),
        "none": np.mean(~is_class(motion, "motion", "blue_o")[here]),
        "reversing": np.mean(speed[here] < 0),
        "known": int(known.sum()),
        "rank": float(spearmanr(u_1[known], -speed[known]).statistic),
    }


def near(where: Any, cells: int = 2) -> Any:
    """Return which points (n_y, n_x) lie within some cells of others."""
    return binary_dilation(where, np.ones((3, 3)), iterations=cells)


def transition(session: Session) -> Numbers:
    """Return the share of cyan + in figure 5 that lies near both rotation and its absence."""
    motion = motion_map(session, False)
    cyan, red, blue, plus = (
        is_class(motion, "motion", name) for name in ("cyan_plus", "red_x", "blue_o", "blue_plus")
    )
    between = (near(red) & near(blue | plus))[cyan]
    return {"between": share(between, 0.0), "count": between.size}


def region_3(session: Session) -> Numbers:
    """Count points of cyan o in figure 5, and those that repeat each period.

    And shares of them at which approximate solutions are unstable: with theta_0, and as printed.
    """
    motion = motion_map(session, False)
    cyan = is_class(motion, "motion", "cyan_o")
    periods, f_u = (motion.variables[name][cyan] for name in ("periods", "f_u"))
    return {
        "count": periods.size,
        "share": share(~stable(session, False, "corrected")[cyan]),
        "paper": share(~stable(session, False, "printed")[cyan]),
        "unstable": int(np.sum(~stable(session, False, "printed")[cyan])),
        "first": int(np.sum((periods == 1) & (np.abs(f_u - 1) < 0.02))),
    }


# Figures 4 and 5, 6 and 7


def agreements(session: Session, plate: bool) -> Numbers:
    """Return at which share of the robust points stability tells the motion from rest."""
    by_solution = {name: agreement(session, plate, name) for name in STABILITIES}
    shares = {name: item.share for name, item in by_solution.items()}
    motion = motion_map(session, plate)
    hoop = is_class(motion, "motion", "blue_o")
    return {
        **shares,
        "best": max(shares["paper"], shares["corrected"]),
        "parts": max(
            largest_on_parts(hoop == stable(session, plate, name), motion.robust)
            for name in ("paper", "corrected")
        ),
        "points": by_solution["paper"].points,
        "trivial": by_solution["paper"].trivial,
    }


def own_agreement(session: Session, who: str, plate: bool) -> Numbers:
    """Return at which share of points an engine's own rotation tells where it gets from rest."""
    if who == REFERENCE:
        return {}
    calm, hoop, _ = own_maps(session, plate, who)
    return {"share": np.mean(calm == hoop), "count": len(hoop)}


def right_about_stability(session: Session) -> Numbers:
    """Return the shares of points of figures 4 and 6 where solutions are right on stability."""
    wrong = wrong_about_stability(session)
    return {name: 1 - np.array(wrong[name]) for name in ("paper", "corrected")}
