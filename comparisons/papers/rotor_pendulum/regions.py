"""Measures of the rotor_pendulum paper's figure 3, section 5.1, and of the limits of its theory.

The theory of figure 3 has a phase everywhere. With the dampers of table 1 the synchronous orbit
begins at a fold, which is followed over n_x here.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....reference import get_scene
from ....reference.continuation.along import BoundaryAlong
from ....reference.rotor_pendulum import theory
from ....reference.rotor_pendulum.cases import CASE_1, CASE_2
from ....reference.rotor_pendulum.equations import RotorPendulum, coefficients, operating_speed
from ....reference.rotor_pendulum.phase import wrapped
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ...maps.store import Map
from ...scenes.rotor_pendulum.phase import PHASES
from ..ledger import REPRODUCED, Numbers, below, holds, statement
from ..session import Session
from .results import (
    BETAS,
    CASES,
    SCENE,
    class_shares,
    inside,
    orbit_value,
    phase_map,
    settled,
    synchronous_orbit,
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


STARTS: Mapping[str, Mapping[float, float]] = {
    "pi/6": {2.0: 1.7, 3.0: 1.8, 7.0: 2.0},
    "pi/3": {2.0: 2.1, 3.0: 2.65, 7.0: 3.4},
}
"""By installation angle and n_x: an n_phi with an orbit, near the fold at which it begins."""


def at_ratios(n_x: float, n_phi: float, beta: float) -> RotorPendulum:
    """Return the parameters of a point of figure 3, with the dampers of table 1."""
    c, speed = coefficients(CASE_1), float(operating_speed(CASE_1))
    return CASE_1.replace(
        installation_angle=beta,
        platform_stiffness=float(c.mass) * (speed / n_x) ** 2,
        rod_stiffness=float(c.end_mass * c.length**2) * (speed / n_phi) ** 2,
    )


def folds(session: Session, angle: str) -> list[BoundaryAlong]:
    """Return where the synchronous orbit begins along k_phi, for each n_x."""
    return session.once(
        (SCENE, "folds", angle),
        lambda: [
            BoundaryAlong(
                get_scene(SCENE), at_ratios(n_x, n_phi, BETAS[angle]), "fold", "rod_stiffness"
            )
            for n_x, n_phi in STARTS[angle].items()
        ],
    )


def ratio_of(one: BoundaryAlong, place: float) -> float:
    """Return n_phi at a place of the window."""
    p = one.parameters.replace(rod_stiffness=one.value(place))
    return float(theory.ratios(p).n_phi)


def fold_curve(session: Session, angle: str) -> tuple[Array, Array]:
    """Return n_x and n_phi of the points at which the synchronous orbit begins."""
    places = [ratio_of(one, one.solution[1].place[1]) for one in folds(session, angle)]
    return np.array(list(STARTS[angle])), np.array(places)


SMALLER = (1.0, 1 / 4, 1 / 16, 1 / 64)
"""Factors of rotor masses and dampers: the small parameter."""


def small_parameter(session: Session) -> Numbers:
    """Return how far orbits are from the theory's phase [rad] as rotors get lighter, and the order.

    And that with the rod's mass and spring smaller, too, and dampers weaker still.
    Case 2, dampers in proportion to the masses, motors and bearings to their square, as
    the torque by which vibration couples them.
    """
    sets = [
        CASE_2.replace(
            rotor_mass=CASE_2.rotor_mass * mu,
            platform_damping=CASE_2.platform_damping * mu,
            rod_damping=CASE_2.rod_damping * mu,
            motor_slope=CASE_2.motor_slope * mu**2,
            friction=CASE_2.friction * mu**2,
        )
        for mu in SMALLER
    ]
    phases = [float(theory.stable_phase_difference(theory.ratios(p))) for p in sets]
    orbits = settled(session, sets)
    gaps = [abs(float(wrapped(o.phase - alpha))) for o, alpha in zip(orbits, phases, strict=True)]
    light = sets[-1].replace(
        rod_mass=CASE_2.rod_mass * SMALLER[-1],
        rod_stiffness=CASE_2.rod_stiffness * SMALLER[-1],
        rod_damping=CASE_2.rod_damping * SMALLER[-1] ** 3,
        platform_damping=CASE_2.platform_damping * SMALLER[-1] ** 2,
    )
    (other,) = settled(session, [light])
    alpha = float(theory.stable_phase_difference(theory.ratios(light)))
    order = np.log(gaps[-2] / gaps[-1]) / np.log(SMALLER[-2] / SMALLER[-1])
    return {"gaps": gaps, "order": order, "off": abs(order - 1), "factors": SMALLER,
            "other": abs(float(wrapped(other.phase - alpha))), "kind": other.kind}  # fmt: skip


def speed_and_phase(session: Session) -> Numbers:
    """Return what (26) and (30), (36) have: speeds and stable phases of cases 1 and 2, how many.

    And the mean speeds of the orbits [rad/s].
    """
    c = coefficients(CASE_1)
    rates = np.linspace(0, float(CASE_1.synchronous_speed), 4097)
    excess = c.slope * (c.speed - rates) - c.friction * rates
    alpha, phases = np.linspace(-np.pi, np.pi, 4098), []
    for case in (1, 2):
        n = theory.ratios(CASES[case])
        crossings = np.diff(np.sign(theory.balance(n, alpha))) != 0
        phases.append(int(np.sum(crossings & (theory.stability(n, alpha[1:]) > 0))))
    orbits = [orbit_value(synchronous_orbit(session, CASES[i]), "mean_speed") for i in (1, 2)]
    return {
        "speeds": float(operating_speed(CASE_1)),
        "orbits": orbits,
        "roots": int(np.sum(np.diff(np.sign(excess)) != 0)),
        "phases": phases,
    }


SMALL_PARAMETER = statement(
    "small_parameter", "equations (1)-(6)",
    "For a small enough parameter a root of (4) that satisfies (6) belongs to a stable motion.",
    REPRODUCED,
    "phase of the stable orbit less that of the theory, case 2 with the rotors' masses and the "
    "dampers times {factors:.3g}, motors and bearings times the squares of these, as the torque "
    "that couples them: {gaps:.2g} rad, falling with the order {order:.2f}. It is 2.2's m_1, m_2 "
    "that must be small: with the rod as light as the rotors, and dampers weaker still, the last "
    "gap is {other:.2g} rad ({kind}). With table 1's masses and dampers the parameter is not small",
    small_parameter, judgement=holds(below("off", 0.05)), slow=True,
)  # fmt: skip
