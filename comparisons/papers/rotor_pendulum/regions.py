"""Measures of the rotor_pendulum paper's figure 3, section 5.1, and of the limits of its theory.

The theory of figure 3 has a phase everywhere. With the dampers of table 1 the synchronous orbit
begins at a fold, which is followed over n_x here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ....reference import get_scene
from ....reference.continuation.along import BoundaryAlong
from ....reference.rotor_pendulum import CASE_1, CASE_2, theory
from ....reference.rotor_pendulum.equations import operating_speed
from ....reference.rotor_pendulum.phase import wrapped
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ...scenes.rotor_pendulum.phase import PHASES
from ..ledger import Numbers
from ..session import Session
from .derivation import at_ratios, lattice
from .results import (
    BETAS,
    CASES,
    SCENE,
    class_shares,
    inside,
    kind_of,
    orbit_value,
    phase_map,
    stable_phases,
    synchronous_orbit,
    theory_on,
)

SMALL = 0.1
"""Distance of n_x from resonance that is left out."""
FINE = 400
"""Values along each side of a region at which the theory is evaluated."""

Span = tuple[float, float]
BEFORE, AFTER, ANY = (0.1, 1.0), (1.0, 7.0), (0.0, 8.0)
"""Of a frequency ratio: before and after resonance, and wherever."""


def kinds_in_regions(
    session: Session, who: str, angle: str, regions: Sequence[tuple[Span, Span]]
) -> Numbers:
    """Return shares of the kinds of synchronism in regions of (n_x, n_phi).

    By the orbits of the reference or an engine, and by theory, which alone is judged; with mu_1 as
    printed the lesser share.
    """
    beta = BETAS[angle]
    plane = phase_map(session, beta, who)
    places = [inside(plane, *region) for region in regions]
    shares = [class_shares(plane, where) if np.any(where) else "no point there" for where in places]
    if who != REFERENCE:
        return {"orbits": shares}
    synphase, far, by_print = [], [], []
    for region in regions:
        n_x, n_phi = np.meshgrid(*(np.linspace(*ends, FINE + 2)[1:-1] for ends in region))
        n = theory.Ratios(n_x, n_phi, beta=beta)
        kinds = np.cos(theory.stable_phase_difference(n)) > 0
        printed = np.mean(np.cos(theory.stable_phase_difference(n, as_printed=True)) > 0)
        synphase.append(np.mean(kinds))
        far.append(np.mean(kinds[(abs(n_x - 1) > SMALL) & (abs(n_phi - 1) > SMALL)]))
        by_print.append(min(printed, 1 - printed))
    return {
        "orbits": shares,
        "theory": [{"synphase": one, "antiphase": 1 - one} for one in synphase],
        "apart": [{"synphase": one, "antiphase": 1 - one} for one in far],
        "by_print": min(by_print),
        "turn": 1 / np.cos(beta),
        "synphase": synphase,
        "antiphase": [1 - one for one in synphase],
    }


def branch_of_33(session: Session) -> Numbers:
    """Return shares of figure 3's range where (33), in (0, pi), is the unstable root of (30)."""
    shares = {}
    for name, beta in BETAS.items():
        n = lattice(beta)
        alpha = theory.printed_phase_difference(n)
        shares[f"beta = {name}"] = np.mean(theory.stability(n, alpha) <= 0)
    return {"shares": shares}


def level_phases(session: Session) -> Numbers:
    """Return what the theory says of phases at beta = 0 [rad].

    How far they are from pi before, and from 0 after resonance; how they spread along n_phi; and
    one by the equation as printed.
    """
    n = lattice(0.0)
    alpha = theory.stable_phase_difference(n)
    before = n.n_x[0] < 1
    printed = theory.stable_phase_difference(theory.Ratios(0.5, 2.0, beta=0.0), as_printed=True)
    return {
        "off": max(np.max(abs(wrapped(alpha[:, before] - np.pi))), np.max(abs(alpha[:, ~before]))),
        "by_theory": spread(alpha),
        "printed": float(printed),
    }


def level_orbits(session: Session, who: str) -> Numbers:
    """Return what orbits are like at beta = 0.

    Shares of their kinds before and after the platform's resonance; how their phases spread along
    n_phi [rad]; and the share of points without any.
    """
    plane = phase_map(session, 0.0, who)
    off_resonance = abs(plane.x.values - 1) > SMALL
    return {
        "before": class_shares(plane, inside(plane, BEFORE, ANY)),
        "after": class_shares(plane, inside(plane, AFTER, ANY)),
        "spread": spread(plane.variables["phase_difference"][:, off_resonance]),
        "lost": np.mean(plane.variables["class"] == PHASES.index("none")),
    }


def spread(phases: Array) -> float:
    """Return the largest distance of phases from the mean of their column [rad]."""
    unit = np.exp(1j * phases)
    return float(np.nanmax(abs(np.angle(unit / np.nanmean(unit, axis=0)))))


def figure_3(session: Session, who: str) -> Numbers:
    """Return what the orbits over figure 3 are like, for each beta, and how far from the theory.

    Shares of their kinds, and the largest of each; shares of points at which the theory has the
    same kind, and of those without a stable orbit; the median difference of the phases [rad]; and
    the least and largest mean speed of all [rad/s].
    """
    shares, agree, lost, gaps, speeds = [], [], [], [], []
    for beta in BETAS.values():
        plane = phase_map(session, beta, who)
        alpha, phase = theory_on(plane, beta), stable_phases(plane)
        shares.append(class_shares(plane))
        agree.append(np.mean(np.cos(alpha) * np.cos(phase) > 0))
        lost.append(np.mean(np.isnan(phase)))
        gaps.append(np.nanmedian(abs(wrapped(alpha - phase))))
        speeds.append(plane.variables["mean_speed"][np.isfinite(phase)])
    there = np.concatenate(speeds)
    return {
        "shares": shares,
        **{kind: max(item.get(kind, 0.0) for item in shares) for kind in PHASES},
        "agree": agree,
        "lost": lost,
        "gaps": gaps,
        "least": there.min(initial=np.inf),
        "largest": there.max(initial=-np.inf),
    }


STARTS: Mapping[str, Mapping[float, float]] = {
    "pi/6": {2.0: 1.7, 3.0: 1.8, 7.0: 2.0},
    "pi/3": {2.0: 2.1, 3.0: 2.65, 7.0: 3.4},
}
"""By installation angle and n_x: an n_phi with an orbit, near the fold at which it begins."""


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
    smallest = SMALLER[-1]
    light = sets[-1].replace(
        rod_mass=CASE_2.rod_mass * smallest,
        rod_stiffness=CASE_2.rod_stiffness * smallest,
        rod_damping=CASE_2.rod_damping * smallest**3,
        platform_damping=CASE_2.platform_damping * smallest**2,
    )
    apart = []
    for p in (*sets, light):
        phase = orbit_value(synchronous_orbit(session, p), "phase_difference")
        apart.append(float(abs(wrapped(phase - theory.stable_phase_difference(theory.ratios(p))))))
    *gaps, other = apart
    order = np.log(gaps[-2] / gaps[-1]) / np.log(SMALLER[-2] / smallest)
    return {
        "factors": SMALLER,
        "gaps": gaps,
        "order": order,
        "off": abs(order - 1),
        "other": other,
        "kind": kind_of(synchronous_orbit(session, light)),
    }


def speeds(session: Session) -> Numbers:
    """Return the speed of motors and bearings alone, and those of cases 1 and 2 [rad/s]."""
    orbits = [orbit_value(synchronous_orbit(session, CASES[i]), "mean_speed") for i in (1, 2)]
    return {"speeds": float(operating_speed(CASE_1)), "orbits": orbits}
