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
from ....reference.rotor_pendulum.equations import RotorPendulum, operating_speed
from ....reference.rotor_pendulum.phase import wrapped
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ...scenes.rotor_pendulum.phase import PHASES
from ..ledger import Numbers
from ..session import Session, once
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
"""Points nearer to resonance in n_x than this are not judged."""
FINE = 400
"""Values along each side of a region at which the theory is evaluated."""

Span = tuple[float, float]
BEFORE, AFTER, ANY = (0.1, 1.0), (1.0, 7.0), (0.0, 8.0)
"""Ranges of a frequency ratio: before and after resonance, and all."""


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
        kinds, printed = (
            np.cos(theory.stable_phase_difference(n, as_printed)) > 0
            for as_printed in (False, True)
        )
        synphase.append(np.mean(kinds))
        far.append(np.mean(kinds[(abs(n_x - 1) > SMALL) & (abs(n_phi - 1) > SMALL)]))
        by_print.append(min(np.mean(printed), 1 - np.mean(printed)))
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
    """Return the theory's phases at beta = 0 [rad].

    Their largest distance from pi before, and from 0 after resonance; their spread along n_phi;
    and one by the equation as printed.
    """
    n = lattice(0.0)
    alpha, before = theory.stable_phase_difference(n), n.n_x[0] < 1
    printed = theory.stable_phase_difference(theory.Ratios(0.5, 2.0, beta=0.0), as_printed=True)
    return {
        "off": max(np.max(abs(wrapped(alpha[:, before] - np.pi))), np.max(abs(alpha[:, ~before]))),
        "by_theory": spread(alpha),
        "printed": float(printed),
    }


def level_orbits(session: Session, who: str) -> Numbers:
    """Return the properties of orbits at beta = 0.

    Shares of their kinds before and after the platform's resonance; the spread of their phases
    along n_phi [rad]; and the share of points without any.
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
    """Return the properties of the orbits over figure 3, for each beta.

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
"""Installation angle -> n_x -> an n_phi with an orbit, near the fold at which it begins."""


@once
def folds(session: Session, angle: str) -> list[BoundaryAlong]:
    """Return where the synchronous orbit begins along k_phi, for each n_x."""
    scene, points = get_scene(SCENE), STARTS[angle].items()
    return [
        BoundaryAlong(scene, at_ratios(n_x, n_phi, BETAS[angle]), "fold", "rod_stiffness")
        for n_x, n_phi in points
    ]


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
    """Return distances of orbits from the theory [rad] as rotors get lighter, and the order.

    And that with the rod's mass and spring smaller, too, and dampers weaker still.
    Case 2, dampers in proportion to the masses, motors and bearings to their square, as
    the torque by which vibration couples them.
    """

    def lighter(**powers: int) -> list[RotorPendulum]:
        """Return case 2 with parameters times powers of the small parameter."""
        return [
            CASE_2.replace(**{name: getattr(CASE_2, name) * mu**n for name, n in powers.items()})
            for mu in SMALLER
        ]

    rotors = {"rotor_mass": 1, "motor_slope": 2, "friction": 2}
    sets = lighter(**rotors, platform_damping=1, rod_damping=1)
    light = lighter(**rotors, platform_damping=2, rod_damping=3, rod_mass=1, rod_stiffness=1)[-1]
    apart = []
    for p in (*sets, light):
        phase = orbit_value(synchronous_orbit(session, p), "phase_difference")
        apart.append(float(abs(wrapped(phase - theory.stable_phase_difference(theory.ratios(p))))))
    *gaps, other = apart
    order = np.log(gaps[-2] / gaps[-1]) / np.log(SMALLER[-2] / SMALLER[-1])
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


def limits_of_synphase(session: Session, angle: str) -> Numbers:
    """Return where orbits leave synphase at n_x > 1: by the theory, and with the dampers.

    The n_phi of resonance at n_x = 7 and 2, and that at which the phase passes pi/2, from the sign
    of the cosine; n_x and n_phi of folds.
    """
    n_x, folds = fold_curve(session, angle)
    n_phi, antiphase = np.linspace(0.1, 7, 690_001), []
    for x in (n_x[-1], n_x[0]):
        alpha = theory.stable_phase_difference(theory.Ratios(x, n_phi, beta=BETAS[angle]))
        antiphase.append(n_phi[np.cos(alpha) < 0])
    resonance = [own[0] for own in antiphase]
    return {"resonance": resonance, "turn": antiphase[0][-1], "n_x": n_x, "folds": folds}
