"""Measures of what the rotating_beam paper derives, sections 2.2 and 3.1.

Its equations themselves are texts in ``claims.toml``.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import eigh

from ....reference.linear import linearise
from ....reference.rotating_beam import SCENE, beam_scene
from ....reference.rotating_beam.frequencies.assumed_modes import (
    assumed_modes,
    first_frequency,
    rest_modes,
    rest_roots,
)
from ....reference.rotating_beam.frequencies.numbers import Numbers as BeamNumbers
from ....reference.rotating_beam.frequencies.numbers import numbers, tension
from ....reference.rotating_beam.frequencies.ritz import gram, places, ritz
from ....reference.rotating_beam.frequencies.stretching import stretching
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ...queries.frequencies import frequencies as engine_frequencies
from ..ledger import Numbers
from ..session import Session
from .results import BEAM, UNIT, segments

FIRST_AXIAL = np.pi / 2 / BEAM.length * np.sqrt(BEAM.youngs_modulus / BEAM.density)
"""First axial frequency at rest [rad/s], as printed."""

STRAIGHT = {
    "E": BEAM.youngs_modulus, "A": BEAM.area, "I": BEAM.second_moment, "rho": BEAM.density,
    "L": BEAM.length, "a": BEAM.hub_radius, "x": BEAM.length, "d_0": BEAM.length,
    "J_h": BEAM.hub_inertia, "m": 0.4, "g": 9.80665, "theta_t": 1.0,
    "beta_2": float(rest_roots(1)[0]) / BEAM.length,
    **dict.fromkeys(("u", "u_f", "v", "u_x", "u_xx", "v_xx", "u_t", "u_f_t", "v_t"), 0.0),
}  # fmt: skip
"""Values of a straight beam's tip, 0.4 kg there, at 1 rad/s, for equations; beta_2 at rest."""

MODES = 16
"""Assumed modes that come to within 1e-3 of what they converge to."""


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
    """Return the relative errors of (2 i - 1) pi/2 as roots, from the third on."""
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


def quadrature() -> tuple[Array, Array]:
    """Return places and weights over the beam, 0 to 1."""
    x, weight = legendre.leggauss(64)
    return (1 + x) / 2, weight / 2


def orthogonality(session: Session) -> Numbers:
    """Return the largest integral between two of four modes of the beam, over that of one."""
    x, weight = quadrature()
    parts = gram(rest_modes(x, 4)[0], weight)
    return {"error": np.max(np.abs(parts - np.diag(np.diag(parts)))) / np.max(np.diag(parts))}


def foreshortening(session: Session) -> Numbers:
    """Return the relative errors of u_f at the free end for deflections of 1 and 10 % of L."""
    x, weight = quadrature()
    value, slope, _ = rest_modes(np.append(x, 1.0), 1)
    bends = np.array([[0.01], [0.1]]) * slope[0, :-1] / value[0, -1]  # x is the arc length
    errors = -(bends**2 @ weight) / 2 / ((np.sqrt(1 - bends**2) - 1) @ weight) - 1
    return {"errors": errors, "order": np.log10(errors[1] / errors[0])}


def pull_of_hub(session: Session) -> Numbers:
    """Return the first frequency by (18), with its own D_1, and the converged one."""
    own, exact = first_frequency(numbers(BEAM), MODES), first_frequency(numbers(BEAM))
    return {"own": own, "exact": exact, "error": abs(own / exact - 1)}


def bending_stiffness(session: Session) -> Numbers:
    """Return the first frequency of (21), dimensionless, without and with K_2, and its errors.

    With 0.4 kg in the middle at 7 rad/s. As printed it is that of a string, converged; with K_2 it
    is that of `MODES` assumed modes, which is compared with the converged one.
    """
    n = numbers(BEAM.replace(mass=0.4, mass_position=0.5))
    exact, own, string = first_frequency(n), assumed_modes(n, MODES)[0], string_frequency(n)
    return {
        "string": string,
        "own": own,
        "exact": exact,
        "corrected": abs(own / exact - 1),
        "as_printed": abs(string / exact - 1),
    }


def string_frequency(n: BeamNumbers, degree: int = 12) -> float:
    """Return the first frequency, dimensionless, of a beam without bending stiffness.

    Its slopes are polynomials from the clamp to the mass, and others from there to the tip.
    """
    x, weight = places(np.array([0.0, n.beta, 1.0]), *legendre.leggauss(2 * degree))
    at, slopes, values = np.append(x, n.beta), [], []
    for start, end in ((0.0, n.beta), (n.beta, 1.0)):
        local = np.clip(2 * (at - start) / (end - start) - 1, -1, 1)
        inside = (start < at) & (at < end)
        slopes += list(legendre.legvander(local, degree).T * inside)
        integrals = legendre.legint(np.eye(degree + 1), lbnd=-1)
        values += list((end - start) / 2 * legendre.legval(local, integrals))
    slope, value = np.array(slopes), np.array(values)
    mass = gram(value, np.append(weight, n.alpha))
    pull = gram(slope[:, :-1], weight * tension(n, x))
    return float(n.gamma * np.sqrt(eigh(pull, mass, eigvals_only=True)[0] - 1))


def extension(session: Session) -> Numbers:
    """Compare a beam that stretches much with one that does not.

    The extension parameter, and the changes of the first frequency by stretch and Coriolis force.
    """
    n, rows = BeamNumbers(0.0, 5.0), []
    for slenderness in (100.0, BEAM.area * BEAM.length**2 / BEAM.second_moment):
        flapwise = stretching(n, slenderness, "flapwise", 1).omega[0]
        chordwise = stretching(n, slenderness, count=1).omega[0]
        stretch = flapwise / ritz(n, "flapwise", 1).omega[0] - 1
        coriolis = chordwise / np.sqrt(flapwise**2 - n.gamma**2) - 1
        rows.append((n.gamma / np.sqrt(slenderness), stretch, coriolis))
    (large, much, with_coriolis), (small, little, _) = rows
    return {
        "large": large,
        "much": much,
        "with_coriolis": with_coriolis,
        "small": small,
        "little": little,
        "least": min(abs(much), abs(with_coriolis)),
        "most": abs(little),
    }
