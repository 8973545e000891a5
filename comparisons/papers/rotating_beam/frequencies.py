"""Measures of the rotating_beam paper's frequencies, section 3.1: figures 2 and 3."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from ....reference.rotating_beam import SCENE
from ....reference.rotating_beam.frequencies.assumed_modes import best_mass_position, crossover
from ....reference.rotating_beam.frequencies.stretching import frequencies
from ...engines.registry import REFERENCE
from ..ledger import Numbers
from ..session import Session
from .derivation import FIRST_AXIAL
from .results import (
    BEAM,
    FIRST_VARIABLE,
    LOADS,
    MASSES,
    PRINTED_MAXIMA,
    SPEED,
    by_place,
    by_ratio,
    by_speed,
    crossed,
    curves_of_figure_3,
    furthest,
    loaded,
    matched,
    maximum,
)

THRESHOLD = 0.67
"""Printed place at which the curves of figure 3 cross."""


def slenderness(session: Session) -> Numbers:
    """Return the first axial frequency over that of bending at rest."""
    bending = frequencies(BEAM.replace(angular_speed=0.0), count=1).omega[0]
    return {"ratio": FIRST_AXIAL / bending}


def stretch_gap(session: Session, who: str) -> Numbers:
    """Return the relative decrease of the first frequency by stretching, most mass at the tip."""
    p = BEAM.replace(mass=LOADS[-1])
    if who == REFERENCE:
        soft = frequencies(p, count=1, continuum="extensible").omega[0]
    else:
        soft = by_place(session, who).variables["frequency_1"][-1, -1]
    return {"gap": 1 - float(soft) / float(frequencies(p, count=1).omega[0])}


def speed_curves(session: Session, who: str = REFERENCE) -> Numbers:
    """Return True if frequencies fall with the mass at the tip, and their means by mass."""
    curves = by_speed(session, who).variables[FIRST_VARIABLE]
    return {
        "falls": np.all(np.diff(curves, axis=0) < 0),
        "means": np.mean(curves, axis=1) / np.mean(curves[0]),
        "drops": -np.diff(curves[:, 14]),
    }


def convexity(session: Session, who: str = REFERENCE) -> Numbers:
    """Return True if frequencies are convex functions of the mass ratio at all speeds."""
    curves = by_ratio(session, who).variables[FIRST_VARIABLE]
    return {"convex": np.all(np.diff(curves, 2, axis=1) > 0)}


# Where curves cross, and their maxima


def crossings(speed: float, modes: int | None = None) -> list[float]:
    """Return the place where each mass crosses the beam without mass at a speed [rad/s]."""
    return [crossover(loaded(mass, speed), modes=modes) for mass in LOADS]


def best(speed: float, modes: int | None = None) -> list[float]:
    """Return the best place of each mass at a speed [rad/s]."""
    return [best_mass_position(loaded(mass, speed), modes) for mass in LOADS]


def crossover_of_0_4(session: Session, who: str) -> float:
    """Return where the curve of 0.4 kg crosses that without mass."""
    if who == REFERENCE:
        return crossover(loaded(LOADS[0]))
    place, curves = curves_of_figure_3(session, who)
    return float(CubicSpline(place, curves[1] - curves[0]).roots(extrapolate=False)[-1])


def crossovers(session: Session, fast: float, fastest: float) -> Numbers:
    """Return the crossovers by mass, converged and of two modes, and the speed of that at 0.67.

    Those of two modes, and their maxima, at the speed too that gives the printed maximum of 0.4 kg.

    Parameters
    ----------
    fast, fastest : float
        Speeds [rad/s] at which the first crossing, and the last, are at the threshold.
    """
    speed = matched(session, LOADS[0])
    faster = crossings(speed, 2)

    def beyond(w: float) -> float:
        return crossover(loaded(LOADS[0], w)) - THRESHOLD

    return {
        "matched": speed,
        "two_faster": faster,
        "two_first": faster[0],
        "two_maxima": best(speed, 2),
        "converged": crossings(SPEED),
        "two": crossings(SPEED, 2),
        "speed": session.once((SCENE.name, "speed"), lambda: brentq(beyond, 5, 40, rtol=1e-4)),
        "fast": crossings(fast),
        "fastest_first": crossover(loaded(LOADS[0], fastest)),
    }


def crossings_inside(session: Session, fast: float, fastest: float) -> Numbers:
    """Return where masses cross each other, and 0.4 kg the beam without mass, by circumstance."""
    places = {
        "slowly": crossover(loaded(LOADS[0], 4.0)),
        "still": crossover(loaded(LOADS[0], 0.0)._replace(delta=1)),
        "no_hub": crossover(loaded(LOADS[0])._replace(delta=0)),
        "two": crossover(loaded(LOADS[0]), modes=2),
    }
    last = {
        name: min(crossover(loaded(b, w), loaded(a, w).alpha) for a, b in pairwise(LOADS))
        for name, w in (("last", SPEED), ("fast", fast), ("fastest", fastest))
    }
    return last | {name: crossed(place) for name, place in places.items()}


def best_place(session: Session, who: str, mass: float) -> float:
    """Return where a mass makes the first frequency largest, at the speed of figure 3."""
    if who == REFERENCE:
        return best_mass_position(loaded(mass))
    place, curves = curves_of_figure_3(session, who)
    return maximum(place, curves[MASSES.index(mass)])


def printed_maximum(session: Session, mass: float) -> Numbers:
    """Return the best place at any speed, its speed, and that at which two modes have the printed.

    Speeds are in rad/s.
    """
    top, at = furthest(session, mass)
    two = best_mass_position(loaded(mass), 2)
    off = abs(two - PRINTED_MAXIMA[mass])
    return {"top": top, "at": at, "matched": matched(session, mass), "two": two, "two_off": off}


def best_places(session: Session, who: str) -> Numbers:
    """Return the best places by mass, and how near they come to 0.42."""
    places = np.array([best_place(session, who, mass) for mass in LOADS])
    return {"places": places, "outward": np.diff(places), "gap": np.min(np.abs(places - 0.42))}


def best_places_otherwise(session: Session) -> Numbers:
    """Return the best places of two assumed modes by mass, and the outermost without rotation.

    And how near those of two modes come to 0.42.
    """
    two = np.array(best(SPEED, 2))
    gap = np.min(np.abs(two - 0.42))
    return {"two": two, "two_outward": np.diff(two), "two_gap": gap, "still": max(best(0.0))}


def furthest_places(session: Session) -> Numbers:
    """Return the best places at any speed, by mass, and those of two modes at 7 rad/s."""
    tops = [furthest(session, mass)[0] for mass in LOADS]
    return {"tops": tops, **best_places_otherwise(session)}


def curves(session: Session, who: str) -> Numbers:
    """Return properties of the curves of figure 3.

    ``holds``: each with a mass rises first, and turns once; its largest less smallest frequency.
    ``falls``: more mass lowers the frequency at all places beyond the threshold. And the innermost
    place inside at which more mass does not raise it, in words too.
    """
    place, frequency = curves_of_figure_3(session, who)
    outward, by_load = np.diff(frequency[1:], axis=1), np.diff(frequency, axis=0)
    turns = np.count_nonzero(np.diff(np.sign(outward)), axis=1)
    spans = np.ptp(frequency[1:], axis=1)
    wrong = place[(place < THRESHOLD) & np.any(by_load <= 0, axis=0)]
    innermost = float(np.min(wrong, initial=np.inf))
    return {
        "holds": np.all(outward[:, 0] > 0) and np.all(turns == 1),
        "ranges": spans,
        "growth": np.diff(spans),
        "falls": np.all(by_load[:, place > THRESHOLD] < 0),
        "innermost": innermost,
        "words": f"not at beta = {innermost:.3f}" if np.isfinite(innermost) else "yes",
    }


# Readings


def axis_of_figure_2(session: Session) -> Numbers:
    """Return the text's statements on both axes that figure 2 may have."""
    return {**speed_curves(session), **convexity(session)}


def maxima_at_speeds(session: Session, speeds: Sequence[float]) -> Numbers:
    """Return the best places and the crossover of 0.4 kg, of two modes and converged, by speed.

    At these speeds [rad/s], and at those, ``matched``, that give two modes the printed maxima.
    """
    own = [matched(session, mass) for mass in LOADS]
    every = sorted([*speeds, own[0], own[-1]])
    return {
        "matched": own,
        "speeds": every,
        "two": [best(speed, 2) for speed in every],
        "converged": [best(speed) for speed in every],
        "two_crossings": [crossover(loaded(LOADS[0], speed), modes=2) for speed in every],
        "crossings": [crossover(loaded(LOADS[0], speed)) for speed in every],
    }


def maxima_of_modes(session: Session, most: int) -> Numbers:
    """Return the best places by number of assumed modes, the last converged, and their errors."""
    places = [best(SPEED, modes) for modes in (*range(1, most + 1), None)]
    off = np.max(np.abs(np.array(places) - list(PRINTED_MAXIMA.values())), axis=1)
    return {"places": places, "off": off, "nearest": int(np.argmin(off)) + 1, "least": min(off)}
