"""Measures and readings of the hula_hoop paper's figures 4-7, sections 5.2 and 6."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
from scipy.ndimage import binary_dilation
from scipy.stats import spearmanr

from ....reference.hula_hoop.equations import HulaHoop
from ....reference.hula_hoop.floquet import floquet_multipliers
from ....reference.hula_hoop.theory import paper_solution
from ...engines.registry import REFERENCE
from ..ledger import Numbers
from ..session import Session
from .derivation import PHASES, TRIAL
from .results import (
    HERTZ,
    NATURAL,
    NEWTON,
    PLATES,
    POINTS,
    STABILITIES,
    agreement,
    changed,
    grid,
    is_class,
    motion_map,
    moves,
    on_grid,
    own_maps,
    regions,
    stability_map,
    stable,
)

SMALL = 0.1
"""Turns per period that chaotic motion may drift by in the window of the maps."""

CORRECTED = ("paper", "corrected")
"""Approximate solutions by (55) corrected: without and with theta_0."""


def count(where: Any) -> int:
    """Return the number of points at which something holds."""
    return int(np.sum(where))


def share(where: Any, of_none: float = np.nan) -> float:
    """Return the share of points at which something holds; there may be no point."""
    return float(np.mean(where)) if where.size else of_none


def by_plate(names: Iterable[str], where: Callable[[str, bool], Any]) -> dict[str, list[float]]:
    """Return the shares of points of a solution without and with inertia, by its name."""
    return {name: [float(np.mean(where(name, plate))) for plate in PLATES] for name in names}


def printed_u_1(session: Session, plate: bool = False) -> Any:
    """Return |u_1| (n_y, n_x) of the printed solution in figure 4, or 6 (plate)."""
    return np.abs(paper_solution(grid(session, plate)).u_1)


# Figures 4 and 6: stability


def stable_zone(session: Session, who: str) -> Numbers:
    """Return where a rotation is stable, of the points where approximate ones are."""
    own = stability_map(session, False, who)
    calm, shares = is_class(own, "stability", "stable"), {}
    for name in CORRECTED:
        zone = on_grid(session, own, stable(session, False, name)) & (own.computed == 1)
        shares[name] = float(np.mean(calm[zone]))
    return {**shares, "share": shares["paper"]}


PARTS = ((0.0, 1.0), (0.1, 0.8), (0.0, 0.6), (0.2, 1.0))
"""Parts of each axis of figures 4 and 6 that regions are counted on."""


def part(where: Any, x: tuple[float, float], y: tuple[float, float]) -> Any:
    """Return the part (n, m) of points (n_y, n_x) between shares of both axes."""
    rows, columns = (
        slice(*(round(share * size) for share in ends))
        for ends, size in zip((y, x), where.shape, strict=True)
    )
    return where[rows, columns]


def unstable_regions(session: Session, plate: bool, printed: str) -> Numbers:
    """Count unstable regions by each solution, on our axes and grid, and on parts of them.

    The value is that of the printed solution, of (55) as printed if it fits.
    """
    unstable = {name: ~stable(session, plate, name) for name in STABILITIES}
    counts = {name: len(regions(where)) for name, where in unstable.items()}
    choices = np.array(
        [
            len(regions(part(unstable[name], x, y)[::every, ::every], least))
            for name, x, y, every, least in product(
                (*CORRECTED, "exact"), PARTS, PARTS, (1, 2), (1, 2, 3)
            )
        ]
    )
    return {
        "value": counts["printed" if counts["printed"] == int(printed) else "paper"],
        "choices": choices,
        "least": choices.min(),
        "largest": choices.max(),
        "spread": np.ptp(choices),
        "counts": {words: counts[name] for name, words in STABILITIES.items()},
    }


def colours_of_region_1(session: Session) -> Numbers:
    """Count points of region I in figure 4 with |u_1| below 0.5 (red), and from 0.5 on (black).

    With (55) corrected and as printed.
    """
    u_1, numbers = printed_u_1(session), {}
    for name in ("paper", "printed"):
        inside = u_1[regions(~stable(session, False, name))[0]]
        numbers[name] = [count(inside < 0.5), count(inside >= 0.5)]
    return {**numbers, "least": min(*numbers["paper"], *numbers["printed"])}


def classes_of_figure_6(session: Session) -> Numbers:
    """Count points of figure 6 that are blue, red, black, and stable with |u_1| of 0.5 or more.

    With (55) corrected and as printed.
    """
    large, numbers = printed_u_1(session, plate=True) >= 0.5, {}
    for name in ("paper", "printed"):
        calm = stable(session, True, name)
        kinds = (calm & ~large, ~calm & ~large, ~calm & large, calm & large)
        numbers[name] = [count(kind) for kind in kinds]
    both = list(zip(*numbers.values(), strict=True))
    return {**numbers, "least": min(map(min, both[:3])), "others": max(both[3])}


def small_regions(session: Session) -> Numbers:
    """Return the number of unstable regions besides the largest, and the largest |u_1| in them.

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

    ``hoop`` counts the true rotations that are stable and keep their sense.
    """
    large, calm, hoop = {}, {}, 0
    for model, plate in product(("exact", "paper"), PLATES):
        plane = stability_map(session, plate, model=model)
        here = plane.variables["u_1"] >= 0.5
        still = here & is_class(plane, "stability", "stable")
        large[model, plate] = count(still | (here & is_class(plane, "stability", "unstable")))
        calm[model, plate] = count(still)
        if model == "exact":
            hoop += count(still & (plane.variables["min_speed"] >= 0))
    return {
        "hoop": hoop,
        "large": sum(large["exact", plate] for plate in PLATES),
        "calm": sum(calm["exact", plate] for plate in PLATES),
        "without": calm["exact", False],
        "printed": sum(large["paper", plate] for plate in PLATES),
        "printed_calm": sum(calm["paper", plate] for plate in PLATES),
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
    """Return shares of points where solutions are wrong on stability, and their ratio."""
    shares = by_plate(
        CORRECTED,
        lambda name, plate: stable(session, plate, name) != stable(session, plate, "exact"),
    )
    return {**shares, "left": np.divide(shares["corrected"], shares["paper"])}


def right_about_stability(session: Session) -> Numbers:
    """Return the shares of points of figures 4 and 6 where solutions are right on stability."""
    wrong = wrong_about_stability(session)
    return {name: 1 - np.array(wrong[name]) for name in CORRECTED}


def unstable_by_inertia(
    session: Session, names: Iterable[str] = STABILITIES, low: float = 0.0, high: float = np.inf
) -> Numbers:
    """Return shares of unstable points without and with inertia, and their changes.

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


def share_of_class(session: Session, who: str, name: str) -> float:
    """Return the share of a class in all of figure 5."""
    return float(np.mean(moves(session, False, name, who)))


def class_by_inertia(session: Session, who: str, name: str, below: float = np.inf) -> Numbers:
    """Return the shares of a class in figures 5 and 7 below a frequency [Hz], and their change."""
    shares = [
        float(np.mean(is_class(motion, "motion", name) & (motion.x.values < below)))
        for motion in (motion_map(session, plate, who) for plate in PLATES)
    ]
    return {"shares": shares, "change": shares[1] - shares[0]}


def cyan_in_region_1(session: Session) -> Numbers:
    """Count points of cyan o in region I without and with inertia, by three solutions.

    And those of figure 7, with those among them that repeat after several periods.
    """
    cyan = [moves(session, plate, "cyan_o") for plate in PLATES]
    counts = {
        STABILITIES[name]: [
            count(here & regions(~stable(session, plate, name))[0])
            for here, plate in zip(cyan, PLATES, strict=True)
        ]
        for name in (*CORRECTED, "exact")
    }
    changes = [after - before for before, after in counts.values()]
    periods = motion_map(session, True).variables["periods"][cyan[1]]
    return {
        "counts": counts,
        "changes": changes,
        "least": min(changes),
        "several": count(periods > 1),
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
        counts["every"].append(count(here))
        counts["first"].append(count(here & (motion.variables["periods"] == 1)))
    return {**counts, **{f"{name}_change": two[1] - two[0] for name, two in counts.items()}}


def classes(session: Session) -> Numbers:
    """Count the points of each class in figures 5 and 7."""
    names = motion_map(session, False).about["motion"].classes
    first, second = (
        {name.replace("_", " "): count(moves(session, plate, name)) for name in names}
        for plate in PLATES
    )
    return {"counts": first, "plate": second, "least": min(first.values())}


def red_x(session: Session) -> Numbers:
    """Return the share of red x of figure 5 that hardly turns, and how many lock otherwise."""
    motion, red = motion_map(session, False), moves(session, False, "red_x")
    return {
        "share": np.mean(motion.variables["turns"][red & motion.robust] < SMALL),
        "locked": count(red & is_class(motion, "label", "other_lock")),
    }


def robust_in(session: Session, here: Any, name: str) -> Numbers:
    """Return the share of a class among the robust points of a region of figure 5, their number."""
    there = moves(session, False, name)[here & motion_map(session, False).robust]
    return {"share": share(there), "count": there.size}


def region_2(session: Session) -> Numbers:
    """Return the share of hula-hoop motion where the printed solution is stable.

    And where that with theta_0 is; of this also the largest on parts of our axes.
    """
    calm, robust = stable(session, False, "corrected"), motion_map(session, False).robust
    return {
        **robust_in(session, stable(session, False, "paper"), "blue_o"),
        "corrected": robust_in(session, calm, "blue_o")["share"],
        "parts": largest_on_parts(moves(session, False, "blue_o"), calm & robust),
    }


def largest_on_parts(right: Any, counted: Any) -> float:
    """Return the largest share, on parts of our axes, of those that are right, of the counted."""
    return max(
        share(part(right, *ends)[part(counted, *ends)], 0.0) for ends in product(PARTS, PARTS)
    )


def region_1(session: Session) -> Numbers:
    """Return the share of red x in the largest unstable region, and of reversals among them."""
    largest = regions(~stable(session, False, "paper"))[0]
    red = largest & moves(session, False, "red_x")
    speeds = motion_map(session, False).variables["min_speed"][red]
    return {**robust_in(session, largest, "red_x"), "reversing": share(speeds < 0, 0.0)}


def red_zone(session: Session) -> Numbers:
    """Return the motions from rest where the rotation is unstable though |u_1| < 0.5.

    Shares without hula-hoop motion and with reversals, and the rank correlation of |u_1| with the
    largest backward speed.
    """
    motion, u_1 = motion_map(session, False), printed_u_1(session)
    here = ~stable(session, False, "paper") & (u_1 < 0.5) & motion.robust
    speed = motion.variables["min_speed"]
    known = here & np.isfinite(speed)
    return {
        "count": count(here),
        "none": np.mean(~moves(session, False, "blue_o")[here]),
        "reversing": np.mean(speed[here] < 0),
        "known": count(known),
        "rank": float(spearmanr(u_1[known], -speed[known]).statistic),
    }


def near(where: Any, cells: int = 2) -> Any:
    """Return which points (n_y, n_x) lie within some cells of others."""
    return binary_dilation(where, np.ones((3, 3)), iterations=cells)


def transition(session: Session) -> Numbers:
    """Return the share of cyan + in figure 5 that lies near both rotation and its absence."""
    cyan, red, blue, plus = (
        moves(session, False, name) for name in ("cyan_plus", "red_x", "blue_o", "blue_plus")
    )
    between = (near(red) & near(blue | plus))[cyan]
    return {"between": share(between, 0.0), "count": between.size}


def region_3(session: Session) -> Numbers:
    """Count points of cyan o in figure 5, and those that repeat each period.

    And shares of them at which approximate solutions are unstable: with theta_0, and as printed.
    """
    cyan, variables = moves(session, False, "cyan_o"), motion_map(session, False).variables
    periods, f_u = (variables[name][cyan] for name in ("periods", "f_u"))
    as_printed = ~stable(session, False, "printed")[cyan]
    return {
        "count": periods.size,
        "share": share(~stable(session, False, "corrected")[cyan]),
        "paper": share(as_printed),
        "unstable": count(as_printed),
        "first": count((periods == 1) & (np.abs(f_u - 1) < 0.02)),
    }


# Figures 4 and 5, 6 and 7


def agreements(session: Session, who: str, plate: bool) -> Numbers:
    """Return the share of the robust points at which stability predicts the motion from rest.

    By each solution; of an engine, by the stability of its rotation.
    """
    if who != REFERENCE:
        calm, hoop, _ = own_maps(session, plate, who)
        return {"share": np.mean(calm == hoop), "count": len(hoop)}
    by_solution = {name: agreement(session, plate, name) for name in STABILITIES}
    shares = {name: item["share"] for name, item in by_solution.items()}
    hoop, robust = moves(session, plate, "blue_o"), motion_map(session, plate).robust
    parts = [largest_on_parts(hoop == stable(session, plate, name), robust) for name in CORRECTED]
    return {
        **by_solution["paper"],
        **shares,
        "best": max(shares[name] for name in CORRECTED),
        "parts": max(parts),
    }


def unstable_seen(session: Session, who: str) -> Numbers:
    """Count robust points of figure 5 with a periodic motion where a rotation is unstable."""
    if who != REFERENCE:
        calm, _, periodic = own_maps(session, False, who)
        return {"count": np.sum(periodic & ~calm), "total": np.sum(periodic)}
    motion = motion_map(session, False)
    hoop = is_class(motion, "motion", "blue_o") & motion.robust
    periodic = hoop & (motion.variables["periods"] == 1)
    paper, exact = (count(~stable(session, False, name) & periodic) for name in ("paper", "exact"))
    total = count(periodic)
    more = count(hoop) - total
    return {"paper": paper, "exact": exact, "count": exact, "total": total, "more": more}


def stable_elsewhere(session: Session) -> Numbers:
    """Return where motions from rest end that do not reach a stable true rotation.

    And the largest multiplier of these rotations.
    """
    motion = motion_map(session, False)
    here = stable(session, False, "exact") & motion.robust
    elsewhere = here & ~is_class(motion, "motion", "blue_o")
    return {
        "share": elsewhere.sum() / here.sum(),
        "multiplier": stability_map(session, False).variables["multiplier"][here].max(),
        "total": count(here),
        "kinds": {
            name.replace("_", " "): count(elsewhere & is_class(motion, "motion", name))
            for name in motion.about["motion"].classes[1:]
        },
    }


# Readings


def axes_of_maps(session: Session) -> Numbers:
    """Return stable shares and numbers of unstable regions on other axes: of figures 4 and 6."""
    axes = [(HERTZ, NEWTON), (HERTZ, (5.0, 100.0)), ((1.0, 20.0), NEWTON), ((2.0, 8.0), NEWTON)]
    shares, counts = np.zeros((2, len(axes), 2))
    for (i, (hertz, newton)), plate in product(enumerate(axes), PLATES):
        p = HulaHoop(
            force_frequency=np.linspace(*hertz, POINTS)[None, :],  # type: ignore[arg-type]
            force_amplitude=np.linspace(*newton, POINTS)[:, None],  # type: ignore[arg-type]
            **changed(plate),
        )
        multiplier = np.abs(floquet_multipliers(paper_solution(p), p)[0])
        shares[i, int(plate)] = np.mean(multiplier < 1)
        counts[i, int(plate)] = len(regions(multiplier >= 1))
    return {"shares": shares, "counts": counts}


def drawn_solution(session: Session) -> Numbers:
    """Return regions and agreement with the motion from rest, of figures 4 and 6, by solution."""
    return {
        name: {
            "counts": [len(regions(~stable(session, plate, name))) for plate in PLATES],
            "shares": [agreement(session, plate, name)["share"] for plate in PLATES],
        }
        for name in STABILITIES
    }


def class_definitions(session: Session) -> Numbers:
    """Return the shares of the classes of figure 5 with other limits between them."""
    values = motion_map(session, False).variables
    limits = {
        "ours": (0.5 / 120, 0.02, 0.0),
        "quarter": (0.25 / 120, 0.02, 0.0),
        "slack": (0.05, 0.02, 0.0),
        "wide": (0.5 / 120, 0.1, 0.0),
        "slow": (0.5 / 120, 0.02, -0.05),
    }
    shares = {}
    for name, (slack, near_two, least) in limits.items():
        with np.errstate(invalid="ignore"):
            turns = np.abs(values["turns"] - 1) < slack
            two = np.abs(values["f_u"] - 2) < near_two
            forward = values["min_speed"] >= least
        classes = {
            "blue o": turns & two & forward,
            "blue +": turns & two & ~forward,
            "cyan o": turns & ~two & forward,
            "cyan +": turns & ~two & ~forward,
            "red x": ~turns,
        }
        shares[name] = {one: float(np.mean(where)) for one, where in classes.items()}
    return shares


def definition(session: Session) -> Numbers:
    """Return shares of figure 5 with hula-hoop motion by wider definitions, and of an ideal one."""
    plane = stability_map(session, False)
    u_1 = plane.variables["u_1"][is_class(plane, "stability", "stable")]
    kinds = ("blue_o", "blue_plus", "cyan_o", "cyan_plus")
    shares = [float(np.mean(moves(session, False, name))) for name in kinds]
    return {
        "ideal": np.mean(u_1 == 0),
        "least": np.min(u_1),
        "shares": [shares[0], sum(shares[:2]), sum(shares)],
    }
