"""Measures of the rotating_beam paper's modes and frequencies, sections 2.2 and 3.1."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import eigh
from scipy.optimize import brentq

from ....reference.linear import linearise
from ....reference.rotating_beam import SCENE, beam_scene
from ....reference.rotating_beam.frequencies.assumed_modes import (
    assumed_mode_matrices,
    best_mass_position,
    crossover,
    rest_modes,
    rest_roots,
)
from ....reference.rotating_beam.frequencies.numbers import Numbers as BeamNumbers
from ....reference.rotating_beam.frequencies.numbers import numbers
from ....reference.rotating_beam.frequencies.ritz import ritz
from ....reference.rotating_beam.frequencies.stretching import frequencies, stretching
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ...queries.frequencies import frequencies as engine_frequencies
from ..ledger import Numbers
from ..session import Session
from .results import (
    BEAM,
    FIRST_VARIABLE,
    LOADS,
    MASSES,
    PRINTED_MAXIMA,
    SPEED,
    UNIT,
    by_place,
    by_ratio,
    by_speed,
    crossed,
    curves_of_figure_3,
    furthest,
    loaded,
    matched,
    maximum,
    segments,
)

FIRST_AXIAL = np.pi / 2 / BEAM.length * np.sqrt(BEAM.youngs_modulus / BEAM.density)
"""First axial frequency at rest [rad/s], as printed."""

# Modes at rest, section 2.2


def root(session: Session, who: str, i: int) -> float:
    """Return beta_i L of the cantilever at rest; an engine's is that of its frequency."""
    if who == REFERENCE:
        return float(np.sqrt(ritz(BeamNumbers(), count=3).omega[i - 1]))
    at_rest = {"angular_speed": 0.0, "segments": segments(session)}
    modes = session.once(
        (SCENE.name, "modes at rest", who),
        lambda: engine_frequencies(SCENE.name, engine=who, parameters=at_rest, count=3).modes,
    )
    return float(np.sqrt(modes[i - 1].omega * UNIT))


def asymptote(session: Session) -> Numbers:
    """Return how far (2 i - 1) pi/2 is from the roots, from the third on, relative to them."""
    i = np.arange(3, 9)
    errors = np.abs((2 * i - 1) * np.pi / 2 / rest_roots(8)[2:] - 1)
    return {"errors": errors, "rises": np.diff(errors)}


def axial_frequencies(session: Session) -> Numbers:
    """Compare the first form of the axial frequencies with an extensible beam's at rest."""
    scene = beam_scene("extensible", 2, 12)
    mass, _, stiffness = linearise(scene, BEAM, np.zeros(2 * len(scene.coordinates)))
    along = slice(3, None)
    omega = np.sqrt(eigh(stiffness[along, along], mass[along, along], eigvals_only=True)[:3])
    printed = FIRST_AXIAL * np.array([1, 3, 5])
    return {"omega": omega, "error": np.max(np.abs(printed / omega - 1))}


MODES = 16
"""Assumed modes that come to within 1e-3 of what they converge to."""


def over_the_beam(weight: Callable[[Array], Array], derivative: int, modes: int) -> Array:
    """Return integrals (modes, modes) of products of the modes of (12), or of their slopes."""
    x, share = np.polynomial.legendre.leggauss(64)
    x, share = (1 + x) / 2, share / 2
    shapes = rest_modes(x, modes)[derivative]
    return np.asarray((shapes * share * weight(x)) @ shapes.T)


def orthogonality(session: Session) -> Numbers:
    """Return the largest integral between two of four modes of the beam, over that of one."""
    parts = over_the_beam(np.ones_like, 0, 4)
    return {"error": np.max(np.abs(parts - np.diag(np.diag(parts)))) / np.max(np.diag(parts))}


def pull_of_hub(session: Session) -> Numbers:
    """Return first frequencies by (17) with D_1, D_0 of (16), and by (18) with its own D_1."""
    n = numbers(BEAM)
    parts, alone = (assumed_mode_matrices(m, MODES) for m in (n, n._replace(delta=0.0)))
    hub = over_the_beam(lambda x: 1 - x, 1, MODES)
    own = [
        np.sqrt(
            eigh(parts.bending + n.gamma**2 * (pull - parts.mass), parts.mass, eigvals_only=True)[0]
        )
        for pull in (alone.centrifugal + n.delta * hub, parts.centrifugal)
    ]
    exact = ritz(n, count=1).omega[0]
    return {"own": own, "exact": exact, "error": np.max(np.abs(np.array(own) / exact - 1))}


# Frequencies of the turning beam, section 3.1


def slenderness(session: Session) -> Numbers:
    """Return the first axial frequency over that of bending at rest."""
    bending = frequencies(BEAM.replace(angular_speed=0.0), count=1).omega[0]
    return {"ratio": FIRST_AXIAL / bending}


def stretch_gap(session: Session, who: str) -> Numbers:
    """Return by how much stretching lowers the first frequency, with most mass at the tip."""
    p = BEAM.replace(mass=LOADS[-1])
    if who == REFERENCE:
        soft = frequencies(p, count=1, continuum="extensible").omega[0]
    else:
        soft = by_place(session, who).variables["frequency_1"][-1, -1]
    return {"gap": 1 - float(soft) / float(frequencies(p, count=1).omega[0])}


def extension(session: Session) -> Numbers:
    """Compare a beam that stretches much with one that does not."""

    def changes(slenderness: float) -> tuple[float, float, float]:
        """Return the extension parameter, and what stretch and Coriolis force change."""
        n = BeamNumbers(0.0, 5.0)
        flapwise = stretching(n, slenderness, "flapwise", 1).omega[0]
        chordwise = stretching(n, slenderness, count=1).omega[0]
        return (
            n.gamma / np.sqrt(slenderness),
            flapwise / ritz(n, "flapwise", 1).omega[0] - 1,
            chordwise / np.sqrt(flapwise**2 - n.gamma**2) - 1,
        )

    large, much, with_coriolis = changes(100.0)
    small, little, _ = changes(BEAM.area * BEAM.length**2 / BEAM.second_moment)
    return {
        "large": large,
        "much": much,
        "with_coriolis": with_coriolis,
        "small": small,
        "little": little,
        "least": min(abs(much), abs(with_coriolis)),
        "most": abs(little),
    }


def best_places_otherwise(session: Session) -> Numbers:
    """Return the best places of two assumed modes by mass, and the outermost without rotation."""
    two = [best_mass_position(loaded(mass), 2) for mass in LOADS]
    still = max(best_mass_position(loaded(mass, 0.0)) for mass in LOADS)
    return {"two": two, "two_outward": np.diff(two), "still": still}


def speed_curves(session: Session, who: str) -> Numbers:
    """Return whether frequencies fall with the mass at the tip, and their means by mass."""
    curves = by_speed(session, who).variables[FIRST_VARIABLE]
    return {
        "falls": np.all(np.diff(curves, axis=0) < 0),
        "means": np.mean(curves, axis=1) / np.mean(curves[0]),
        "drops": -np.diff(curves[:, 14]),
    }


def convexity(session: Session, who: str) -> Numbers:
    """Return whether frequencies are convex functions of the mass ratio at all speeds."""
    curves = by_ratio(session, who).variables[FIRST_VARIABLE]
    return {"convex": np.all(np.diff(curves, 2, axis=1) > 0)}


# Where curves cross, and their maxima


def crossover_speed(session: Session, place: float) -> float:
    """Return the speed [rad/s] at which 0.4 kg cross the beam without mass at this place."""
    return session.once(
        (SCENE.name, "crossover speed", place),
        lambda: float(brentq(lambda w: crossover(loaded(LOADS[0], w)) - place, 5, 40, rtol=1e-4)),
    )


def crossover_of_0_4(session: Session, who: str) -> float:
    """Return where the curve of 0.4 kg crosses that without mass."""
    if who == REFERENCE:
        return crossover(loaded(LOADS[0]))
    place, curves = curves_of_figure_3(session, who)
    return float(CubicSpline(place, curves[1] - curves[0]).roots(extrapolate=False)[-1])


def crossovers(session: Session) -> Numbers:
    """Return the crossovers by mass, converged and of two modes, and the speed of that at 0.67.

    Those of two modes, and their maxima, at the speed too that gives the printed maximum of 0.4 kg.
    """
    speed = matched(session, LOADS[0])
    faster = [loaded(mass, speed) for mass in LOADS]
    two = [crossover(one, modes=2) for one in faster]
    return {
        "matched": speed,
        "two_faster": two,
        "two_first": two[0],
        "two_maxima": [best_mass_position(one, 2) for one in faster],
        "converged": [crossover(loaded(mass)) for mass in LOADS],
        "two": [crossover(loaded(mass), modes=2) for mass in LOADS],
        "speed": crossover_speed(session, THRESHOLD),
        "fast": [crossover(loaded(mass, FAST)) for mass in LOADS],
        "fastest_first": crossover(loaded(LOADS[0], FASTEST_LOOK)),
    }


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
    return {
        "top": top,
        "at": at,
        "matched": matched(session, mass),
        "two": two,
        "two_off": abs(two - PRINTED_MAXIMA[mass]),
    }


def best_places(session: Session, who: str) -> Numbers:
    """Return the best places by mass, and how near they come to 0.42."""
    places = [best_place(session, who, mass) for mass in LOADS]
    return {
        "places": places,
        "outward": np.diff(places),
        "gap": min(abs(place - 0.42) for place in places),
    }


def furthest_places(session: Session) -> Numbers:
    """Return the best places at any speed, by mass, and those of two modes at 7 rad/s."""
    two = [best_mass_position(loaded(mass), 2) for mass in LOADS]
    return {
        "tops": [furthest(session, mass)[0] for mass in LOADS],
        "two": two,
        "two_gap": min(abs(place - 0.42) for place in two),
    }


# What is concluded of frequencies

THRESHOLD = 0.67

FAST, FASTEST_LOOK = 15.0, 40.0
"""Speeds [rad/s] at which the first crossing, and the last, are at the threshold."""


def curves(session: Session, who: str) -> Numbers:
    """Return what the curves of figure 3 do.

    Whether each with a mass rises first, and turns once; its largest less smallest frequency.
    Whether more mass lowers the frequency at all places beyond the threshold, and the innermost
    place inside at which it does not raise it, in words too.
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


def crossings_inside(session: Session) -> Numbers:
    """Return where masses cross each other, and 0.4 kg the beam without mass, by circumstance."""
    places = {
        "slowly": crossover(loaded(LOADS[0], 4.0)),
        "still": crossover(loaded(LOADS[0], 0.0)._replace(delta=1)),
        "no_hub": crossover(loaded(LOADS[0])._replace(delta=0)),
        "two": crossover(loaded(LOADS[0]), modes=2),
    }
    at_speed = {"last": SPEED, "fast": FAST, "fastest": FASTEST_LOOK}
    last = {
        name: min(crossover(loaded(b, w), loaded(a, w).alpha) for a, b in pairwise(LOADS))
        for name, w in at_speed.items()
    }
    return last | {name: crossed(place) for name, place in places.items()}
