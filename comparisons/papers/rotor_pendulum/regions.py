"""Measures of the rotor_pendulum paper's figure 3: phases over frequency ratios, section 5.1."""

from __future__ import annotations

import numpy as np

from ....reference.rotor_pendulum import theory
from ....reference.rotor_pendulum.phase import wrapped
from ...engines.registry import REFERENCE
from ...maps.store import Map
from ...scenes.rotor_pendulum.phase import PHASES
from ..ledger import Numbers
from ..session import Session
from .results import (
    BETAS,
    CASES,
    class_shares,
    inside,
    phase_map,
    settled,
)

SMALL = 0.1
"""Distance of n_x from resonance that is left out."""
FINE = 400
"""Values along each side of a region, at which the theory is asked."""

Span = tuple[float, float]
BEFORE, AFTER, ANY = (0.1, 1.0), (1.0, 7.0), (0.0, 8.0)
"""Of a frequency ratio: before and after resonance, and wherever."""


def orbits(session: Session, who: str, beta: float) -> Map:
    """Return the map of the true orbits, by the reference or an engine."""
    return phase_map(session, beta, engine="" if who == REFERENCE else who)


def kinds_in_regions(
    session: Session, who: str, beta: float, regions: tuple[tuple[Span, Span], ...]
) -> Numbers:
    """Return shares of the kinds of synchronism in regions of (n_x, n_phi).

    By the orbits of the reference or an engine, and by theory, which alone is judged; with mu_1 as
    printed the lesser share.
    """
    plane = orbits(session, who, beta)
    places = [inside(plane, *region) for region in regions]
    shares = [class_shares(plane, where) if np.any(where) else "no point there" for where in places]
    if who != REFERENCE:
        return {"orbits": shares}
    by_theory, apart, by_print = [], [], []
    for region in regions:
        n_x, n_phi = np.meshgrid(*(np.linspace(*ends, FINE + 2)[1:-1] for ends in region))
        n = theory.Ratios(n_x, n_phi, beta=beta)
        synphase = np.cos(theory.stable_phase_difference(n)) > 0
        printed = np.mean(np.cos(theory.stable_phase_difference(n, as_printed=True)) > 0)
        by_print.append(min(printed, 1 - printed))
        far = (abs(n_x - 1) > SMALL) & (abs(n_phi - 1) > SMALL)
        by_theory.append({"synphase": np.mean(synphase), "antiphase": np.mean(~synphase)})
        apart.append({"synphase": np.mean(synphase[far]), "antiphase": np.mean(~synphase[far])})
    kinds = {kind: [shares[kind] for shares in by_theory] for kind in ("synphase", "antiphase")}
    turn = 1 / np.sqrt(np.cos(beta) ** 2)
    return {
        "orbits": shares,
        "theory": by_theory,
        "apart": apart,
        "by_print": min(by_print),
        "turn": turn,
        **kinds,
    }


def speeds(session: Session, who: str) -> Numbers:
    """Return the least and the largest mean speed of stable orbits over figure 3 [rad/s]."""
    planes = [orbits(session, who, beta).variables for beta in BETAS.values()]
    there = np.concatenate(
        [plane["mean_speed"][plane["class"] < PHASES.index("unstable")] for plane in planes]
    )
    return {
        "least": np.min(there, initial=np.inf),
        "largest": np.max(there, initial=-np.inf),
    }


def level_phases(session: Session) -> Numbers:
    """Return what the theory says of phases at beta = 0 [rad].

    How far they are from pi before, and from 0 after resonance; how they spread along n_phi; and
    one by the equation as printed.
    """
    plane = phase_map(session, 0.0, "theory")
    alpha = plane.variables["phase_difference"]
    before, after = (alpha[inside(plane, span, ANY)] for span in (BEFORE, AFTER))
    n = theory.Ratios(0.5, 2.0, beta=0.0)
    return {
        "off": max(np.max(abs(wrapped(before - np.pi))), np.max(abs(after))),
        "by_theory": spread(plane),
        "printed": float(theory.stable_phase_difference(n, as_printed=True)),
    }


def level_orbits(session: Session, who: str) -> Numbers:
    """Return what orbits are like at beta = 0.

    Shares of their kinds before and after the platform's resonance; how their phases spread along
    n_phi [rad]; and the share of points without any.
    """
    plane = orbits(session, who, 0.0)
    return {
        "before": class_shares(plane, inside(plane, BEFORE, ANY)),
        "after": class_shares(plane, inside(plane, AFTER, ANY)),
        "spread": spread(plane),
        "lost": np.mean(plane.variables["class"] == PHASES.index("none")),
    }


def spread(plane: Map) -> float:
    """Return the largest distance along n_phi from the median phase of a column, off resonance."""
    column = abs(plane.x.values - 1) > SMALL
    phase = np.exp(1j * plane.variables["phase_difference"][:, column])
    return float(np.nanmax(abs(np.angle(phase / np.nanmean(phase, axis=0)))))


def theory_on_map(session: Session) -> Numbers:
    """Compare theory and true orbits over figure 3, for each beta.

    Shares of points of the same class, and without a stable orbit; the median difference [rad].
    And the kinds of the orbits of section 5.2's cases, whether they are the theory's, (32) in case
    3, and how far their phases are from it in the others [rad].
    """
    simulated = settled(session, list(CASES.values()))
    phases = [float(theory.stable_phase_difference(theory.ratios(CASES[case]))) for case in (1, 2)]
    expected = ["antiphase" if np.cos(phase) < 0 else "synphase" for phase in phases]
    shares, lost, gaps = [], [], []
    for beta in BETAS.values():
        plane, true = (phase_map(session, beta, model).variables for model in ("theory", "exact"))
        stable = true["class"] < PHASES.index("unstable")
        gap = abs(wrapped(plane["phase_difference"] - true["phase_difference"]))
        shares.append(np.mean(plane["class"] == true["class"]))
        lost.append(np.mean(~stable))
        gaps.append(np.median(gap[stable]))
    kinds = {f"case {case}": orbit.kind for case, orbit in zip(CASES, simulated, strict=True)}
    return {
        "shares": shares,
        "lost": lost,
        "gaps": gaps,
        "kinds": kinds,
        "same": list(kinds.values()) == [*expected, "none"],
        "gaps_of_cases": [
            abs(float(wrapped(orbit.phase - phase)))
            for orbit, phase in zip(simulated, phases, strict=False)
        ],
    }


def theory_against_engine(session: Session, who: str) -> Numbers:
    """Return the share of an engine's points whose class is the theory's, for each beta."""
    shares = []
    for beta in BETAS.values() if who != REFERENCE else ():
        own = phase_map(session, beta, engine=who)
        n = theory.Ratios(*np.meshgrid(own.x.values, own.y.values), beta=beta)
        antiphase = ~(np.cos(theory.stable_phase_difference(n)) > 0)
        shares.append(np.mean(own.variables["class"] == antiphase))
    return {"agree": shares}


def kinds_of_figure_3(session: Session, who: str) -> Numbers:
    """Return shares of the kinds of orbits, for each beta, and the largest of each kind."""
    shares = [class_shares(orbits(session, who, beta), Ellipsis) for beta in BETAS.values()]
    largest = {kind: max(item.get(kind, 0.0) for item in shares) for kind in PHASES}
    return {"shares": shares, **largest}
