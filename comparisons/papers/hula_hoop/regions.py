"""Measures of the hula_hoop paper's figures 4-7, sections 5.2 and 6."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.stats import spearmanr

from ....reference.hula_hoop.theory import paper_solution
from ...engines.registry import REFERENCE
from ..ledger import Numbers, rounds_to
from ..session import Session
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


def unstable_regions(session: Session, plate: bool, printed: str) -> Numbers:
    """Count unstable regions by each solution; that of (55) as printed counts if it fits."""
    counts = {name: len(regions(~stable(session, plate, name))) for name in STABILITIES}
    fits = rounds_to(counts["printed"], printed)
    return {
        "value": counts["printed" if fits else "paper"],
        "as_printed": fits,
        "counts": {words: counts[name] for name, words in STABILITIES.items()},
    }


def printed_u_1(session: Session) -> Any:
    """Return |u_1| (n_y, n_x) of the printed solution in figure 4."""
    return np.abs(paper_solution(grid(session, False)).u_1)


def small_regions(session: Session) -> Numbers:
    """Return the number of unstable regions beside the largest, and the largest |u_1| in them."""
    u_1 = printed_u_1(session)
    small = regions(~stable(session, False, "paper"))[1:]
    largest = max((float(u_1[region].max()) for region in small), default=float("nan"))
    return {"count": len(small), "largest": largest}


def stable_above_half(session: Session) -> Numbers:
    """Count rotations of figures 4 and 6 with |u_1| of 0.5 or more, and the stable ones."""
    counts = {
        (model, plate, kind): int(
            np.sum((plane.variables["u_1"] >= 0.5) & is_class(plane, "stability", kind))
        )
        for model in ("paper", "exact")
        for plate in PLATES
        for plane in [stability_map(session, plate, model=model)]
        for kind in ("stable", "unstable")
    }

    def total(model: str, *kinds: str) -> int:
        return sum(counts[model, plate, kind] for plate in PLATES for kind in kinds)

    return {
        "large": total("exact", "stable", "unstable"),
        "calm": total("exact", "stable"),
        "without": counts["exact", False, "stable"],
        "printed": total("paper", "stable", "unstable"),
        "printed_calm": total("paper", "stable"),
    }


def reversals_by_u_1(session: Session) -> Numbers:
    """Return shares of true rotations with reversals: |u_1| of 0.5 or more, and stable below."""
    exact = stability_map(session, False)
    u_1, least = exact.variables["u_1"], exact.variables["min_speed"]
    below = (u_1 < 0.5) & is_class(exact, "stability", "stable")
    return {"above": np.mean(least[u_1 >= 0.5] < 0), "below": np.mean(least[below] < 0)}


def wrong_about_stability(session: Session) -> Numbers:
    """Return shares of points where solutions are wrong on stability, and what theta_0 leaves."""
    shares = {
        name: [
            float(np.mean(stable(session, plate, name) != stable(session, plate, "exact")))
            for plate in PLATES
        ]
        for name in ("paper", "corrected")
    }
    left = [b / a for a, b in zip(shares["paper"], shares["corrected"], strict=True)]
    return {**shares, "left": left}


def unstable_by_inertia(session: Session) -> Numbers:
    """Return shares of unstable points without and with inertia, and how they change."""
    shares = {
        name: [float(np.mean(~stable(session, plate, name))) for plate in PLATES]
        for name in STABILITIES
    }
    return {**shares, "changes": [after - before for before, after in shares.values()]}


def unstable_between(session: Session, low: float, high: float) -> Numbers:
    """Return shares of unstable points in a range of natural frequencies, without and with inertia.

    Their changes too, and the range [Hz].
    """
    frequency: Any = grid(session, False).force_frequency
    there = (frequency >= low * NATURAL) & (frequency < high * NATURAL)
    shares = {
        name: [float(np.mean(~stable(session, plate, name) & there)) for plate in PLATES]
        for name in ("paper", "exact")
    }
    return {
        **shares,
        "changes": [after - before for before, after in shares.values()],
        "after": [after for _, after in shares.values()],
        "low": max(low * NATURAL, HERTZ[0]),
        "high": high * NATURAL,
    }


def stable_by_inertia(session: Session, who: str) -> Numbers:
    """Return shares of the points of figures 4 and 6 where the rotation is stable."""
    if who == REFERENCE:
        where = [stable(session, plate, "exact") for plate in PLATES]
    else:
        maps = [stability_map(session, plate, who) for plate in PLATES]
        where = [is_class(own, "stability", "stable") for own in maps]
    return {"shares": [np.mean(item) for item in where]}


# Figures 5 and 7: motion from rest


def share_of_class(session: Session, who: str, name: str, plate: bool = False) -> float:
    """Return the share of a class in all of figure 5, or 7 (plate)."""
    return float(np.mean(is_class(motion_map(session, plate, who), "motion", name)))


def class_by_inertia(session: Session, who: str, name: str, below: float = np.inf) -> Numbers:
    """Return the shares of a class in figures 5 and 7 below a frequency [Hz], and their change."""
    shares = []
    for plate in PLATES:
        motion = motion_map(session, plate, who)
        there = is_class(motion, "motion", name) & (motion.x.values < below)
        shares.append(float(np.mean(there)))
    return {"shares": shares, "change": shares[1] - shares[0]}


def cyan_of_several_periods(session: Session) -> Numbers:
    """Count points of cyan o in figure 7, and those that repeat after several periods."""
    motion = motion_map(session, True)
    cyan = is_class(motion, "motion", "cyan_o")
    several = int(np.sum(motion.variables["periods"][cyan] > 1))
    return {"several": several, "count": int(cyan.sum())}


def robust_in(session: Session, here: Any, name: str) -> Numbers:
    """Return the share of a class among the robust points of a region of figure 5, their number."""
    motion = motion_map(session, False)
    robust = here & (motion.variables["robust"] == 1)
    there = is_class(motion, "motion", name)[robust]
    share = float(np.mean(there)) if there.size else float("nan")
    return {"share": share, "count": there.size}


def region_2(session: Session) -> Numbers:
    """Return the share of hula-hoop motion where the printed solution is stable."""
    return robust_in(session, stable(session, False, "paper"), "blue_o")


def region_1(session: Session) -> Numbers:
    """Return the share of red x in the largest unstable region, and of reversals among them."""
    largest = regions(~stable(session, False, "paper"))[0]
    motion = motion_map(session, False)
    red = largest & is_class(motion, "motion", "red_x")
    reversing = float(np.mean(motion.variables["min_speed"][red] < 0)) if np.any(red) else 0.0
    return {**robust_in(session, largest, "red_x"), "reversing": reversing}


def red_zone(session: Session) -> Numbers:
    """Return what motions do where the rotation is unstable though |u_1| < 0.5, from rest.

    Shares with hula-hoop motion and with reversals, and the rank correlation of |u_1| with the
    largest backward speed.
    """
    motion, u_1 = motion_map(session, False), printed_u_1(session)
    zone = ~stable(session, False, "paper") & (u_1 < 0.5)
    here = zone & (motion.variables["robust"] == 1)
    speed = motion.variables["min_speed"]
    known = here & np.isfinite(speed)
    return {
        "count": int(here.sum()),
        "hoop": np.mean(is_class(motion, "motion", "blue_o")[here]),
        "reversing": np.mean(speed[here] < 0),
        "known": int(known.sum()),
        "rank": float(spearmanr(u_1[known], -speed[known]).statistic),
    }


def near(where: Any, cells: int = 2) -> Any:
    """Return which points (n_y, n_x) lie within some cells of others."""
    close = where.copy()
    for _ in range(cells):
        wide = np.pad(close, 1)
        rows, columns = close.shape
        close = np.any(
            [wide[i : i + rows, j : j + columns] for i in range(3) for j in range(3)], axis=0
        )
    return close


def transition(session: Session) -> Numbers:
    """Return the share of cyan + in figure 5 that lies near both rotation and its absence."""
    motion = motion_map(session, False)
    cyan, red, blue, plus = (
        is_class(motion, "motion", name) for name in ("cyan_plus", "red_x", "blue_o", "blue_plus")
    )
    between = float(np.mean((near(red) & near(blue | plus))[cyan])) if np.any(cyan) else 0.0
    return {"between": between, "count": int(cyan.sum())}


def region_3(session: Session) -> Numbers:
    """Count points of cyan o in figure 5: all, unstable ones, and those that repeat each period."""
    motion = motion_map(session, False)
    cyan = is_class(motion, "motion", "cyan_o")
    count, unstable = int(cyan.sum()), int(np.sum(~stable(session, False, "exact") & cyan))
    periods, f_u = (motion.variables[name][cyan] for name in ("periods", "f_u"))
    first = int(np.sum((periods == 1) & (np.abs(f_u - 1) < 0.02)))
    share = unstable / count if count else float("nan")
    return {"count": count, "unstable": unstable, "first": first, "share": share}


# Figures 4 and 5, 6 and 7


def agreements(session: Session, plate: bool) -> Numbers:
    """Return at which share of the robust points stability tells the motion from rest."""
    by_solution = {name: agreement(session, plate, name) for name in STABILITIES}
    shares = {name: item.share for name, item in by_solution.items()}
    return {
        **shares,
        "best": max(shares["paper"], shares["corrected"]),
        "points": by_solution["paper"].points,
        "trivial": by_solution["paper"].trivial,
    }


def own_agreement(session: Session, who: str, plate: bool) -> Numbers:
    """Return at which share of points an engine's own rotation tells where it gets from rest."""
    if who == REFERENCE:
        return {}
    calm, hoop, _ = own_maps(session, plate, who)
    return {"share": np.mean(calm == hoop), "count": len(hoop)}


def both_agreements(session: Session) -> Numbers:
    """Return the shares of points at which figures 4 and 5, 6 and 7 agree, by two solutions."""
    return {
        name: [agreement(session, plate, name).share for plate in PLATES]
        for name in ("paper", "corrected")
    }
