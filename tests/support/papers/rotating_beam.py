"""Formulas of the rotating_beam paper as printed and put right, and what the reference gives.

Lengths are over L and masses over that of the beam where nothing else is said.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import eigh

from mbcheck.comparisons.engines.registry import REFERENCE
from mbcheck.comparisons.papers.rotating_beam.results import BEAM, response
from mbcheck.comparisons.papers.session import Session
from mbcheck.reference.linear import linearise
from mbcheck.reference.rotating_beam.cases import FIGURE_5
from mbcheck.reference.rotating_beam.equations import prepare_truncated
from mbcheck.reference.rotating_beam.frequencies.assumed_modes import (
    assumed_modes,
    rest_modes,
    rest_roots,
)
from mbcheck.reference.rotating_beam.frequencies.continua import frequencies
from mbcheck.reference.rotating_beam.frequencies.numbers import numbers, time_unit
from mbcheck.reference.rotating_beam.frequencies.ritz import ritz
from mbcheck.reference.rotating_beam.parameters import RotatingBeam, coefficients
from mbcheck.reference.rotating_beam.scene import EXTENSIBLE, SCENE, beam_scene
from mbcheck.reference.rotating_beam.shapes import cantilever_modes
from mbcheck.reference.scene import Array, Scene

AGREE = 1e-7
"""Relative difference within which two values are the same."""

GRAVITY = 9.80665
"""[m/s^2]"""

LOADED = BEAM.replace(mass=0.4, mass_position=0.5)
"""Beam of figure 3, on its hub of 8 m, with a mass in the middle."""


class Formula(NamedTuple):
    """One quantity by the printed formula, by the corrected one, and by the reference."""

    printed: float
    corrected: float
    reference: float
    within: float = AGREE


def straight(p: RotatingBeam, speed: float, scene: Any = SCENE) -> tuple[Array, Array]:
    """Return q and v of the straight beam that turns."""
    size = len(scene.coordinates)
    return np.zeros(size), speed * np.eye(size)[0]


def quadrature() -> tuple[Array, Array]:
    """Return points and weights over the beam, 0 to 1."""
    x, weight = legendre.leggauss(40)
    return (1 + x) / 2, weight / 2


# Energies (2) to (5) ------------------------------------------------------------------------


def strain_energy(session: Session) -> Formula:
    """Stretch evenly: (2) has the second derivative of u, which is 0."""
    stretch = 1e-4
    size, own = len(EXTENSIBLE.coordinates), [n.startswith("e_") for n in EXTENSIBLE.coordinates]
    found = EXTENSIBLE.energy(stretch * np.array(own, float), np.zeros(size), coefficients(BEAM))
    right = BEAM.youngs_modulus * BEAM.area * stretch**2 * BEAM.length / 2
    return Formula(0.0, right, float(found))


def kinetic_energy(hub_radius: float) -> float:
    """Energy [J] of the straight beam at 1 rad/s, clamped at this distance from the axis."""
    x, weight = quadrature()
    line = BEAM.density * BEAM.area * BEAM.length
    return float(line * np.sum(weight * (hub_radius + BEAM.length * x) ** 2) / 2)


def hub_radius(session: Session) -> Formula:
    """(3) turns the beam about its clamp."""
    c = coefficients(BEAM.replace(hub_inertia=0.0))
    found = SCENE.energy(*straight(BEAM, 1.0), c)
    values = kinetic_energy(0.0), kinetic_energy(BEAM.hub_radius), float(found)
    return Formula(*values)


def coupling_energy(session: Session) -> Formula:
    """(4) has theta'^2 in a term that is linear in theta' and in v'."""
    c = coefficients(BEAM.replace(drive="torque"))
    q, v = straight(BEAM, 2.0)
    v[1] = 0.3
    mass = np.array(SCENE.mass_matrix(q, c))
    own = (mass[0, 0] * v[0] ** 2 + mass[1, 1] * v[1] ** 2) / 2
    printed, right = (own + mass[0, 1] * v[0] ** power * v[1] for power in (2, 1))
    return Formula(printed, right, float(SCENE.energy(q, v, c)))


def stretch_of_4(session: Session) -> Formula:
    """(4) turns a stretched beam as if it had its length at rest."""
    stretch, p = 1e-3, BEAM.replace(hub_inertia=0.0)
    q, v = straight(p, 1.0, EXTENSIBLE)
    q[:] = [stretch * name.startswith("e_") for name in EXTENSIBLE.coordinates]
    found = EXTENSIBLE.energy(q, v, coefficients(p)) - EXTENSIBLE.energy(q, 0 * v, coefficients(p))
    x, weight = quadrature()
    reach = BEAM.hub_radius + BEAM.length * x * (1 + stretch)
    right = BEAM.density * BEAM.area * BEAM.length * float(weight @ reach**2) / 2
    return Formula(kinetic_energy(BEAM.hub_radius), right, float(found))


def gravity(session: Session) -> Formula:
    """(4) and (5) have a weight that (14) to (16) know nothing of; they have d for x in it."""
    p = FIGURE_5.replace(mass=0.0)
    q, v = straight(p, 0.0)
    weight = p.density * p.area * p.length * GRAVITY
    torque = -weight * (p.hub_radius + p.mass_position * p.length)
    found = SCENE.forces(0.0, q, v, coefficients(p))[0]
    return Formula(torque, 0.0, float(found))


def mass_twice(session: Session) -> Formula:
    """(5) has the mass's energy with (a + d)^2, and once more with d^2."""
    p = BEAM.replace(mass=0.4)
    arm, own = p.hub_radius + p.length, p.mass_position * p.length
    bare, loaded = (
        SCENE.energy(*straight(p, 1.0), coefficients(p.replace(mass=mass))) for mass in (0.0, 0.4)
    )
    values = (arm**2 + own**2) * p.mass / 2, arm**2 * p.mass / 2, float(loaded - bare)
    return Formula(*values)


def hub_energy(session: Session) -> Formula:
    """(5) has lost the hub's part of (4)."""
    p = FIGURE_5.replace(mass=0.0)
    beam = p.density * p.area * p.length**3 / 6
    found = SCENE.energy(*straight(p, 1.0), coefficients(p))
    return Formula(beam, beam + p.hub_inertia / 2, float(found))


# Modes (7) to (13) --------------------------------------------------------------------------


def linear_pulse(p: RotatingBeam, times: Array, scene: Scene = SCENE) -> dict[str, Array]:
    """Observables of the pulse (23), linear about rest: mode by mode, in closed form."""
    size = len(scene.coordinates)
    mass, _, stiffness = linearise(scene, p.replace(drive="torque"), np.zeros(2 * size))
    squares, shapes = eigh(stiffness, mass)
    w, end = 2 * np.pi / p.torque_period, p.torque_period

    def driven(t: Array, omega: float) -> tuple[Array, Array]:
        """Response to sin(w t) from rest, and its rate."""
        if omega < 1e-3 * w:  # the hub turns freely
            return t / w - np.sin(w * t) / w**2, (1 - np.cos(w * t)) / w
        gain = 1 / (omega**2 - w**2)
        return (
            gain * (np.sin(w * t) - w / omega * np.sin(omega * t)),
            gain * w * (np.cos(w * t) - np.cos(omega * t)),
        )

    q, v = np.zeros((2, size, len(times)))
    for square, shape in zip(squares, shapes.T, strict=True):
        omega = np.sqrt(max(square, 0.0))
        at, rate = driven(np.minimum(times, end), omega)
        after = np.maximum(times - end, 0.0)
        cos, sin, lag = np.cos(omega * after), np.sin(omega * after), np.sinc(omega / np.pi * after)
        push = shape[0] * p.torque_amplitude
        q += push * np.outer(shape, at * cos + rate * after * lag)
        v += push * np.outer(shape, rate * cos - omega * at * sin)
    return scene.observe(np.concatenate([q, v]), p)


def hub_alone(session: Session) -> Formula:
    """(7) leaves out what the beam does to the hub."""
    p = FIGURE_5.replace(mass=0.0)
    end = np.array([p.torque_period])
    printed = p.torque_amplitude * p.torque_period**2 / (2 * np.pi * p.hub_inertia)
    whole = response(session, 5, REFERENCE, 0.0)
    found = whole.values["theta"][whole.times == p.torque_period][0]
    right = float(linear_pulse(p, end)["theta"][0])
    return Formula(printed, right, float(found), 1e-4)


def axial_frequency(session: Session) -> Formula:
    """The second form, for i = 1, 3, 5, has lost the factor i."""
    scene = beam_scene("extensible", 2, 10)
    mass, _, stiffness = linearise(scene, BEAM, np.zeros(2 * len(scene.coordinates)))
    along = slice(3, None)
    squares = eigh(stiffness[along, along], mass[along, along], eigvals_only=True)
    first = np.pi / 2 / BEAM.length * np.sqrt(BEAM.youngs_modulus / BEAM.density)
    found = float(np.sqrt(squares[1]))
    return Formula(first, 3 * first, found)


def swapped_constants(session: Session) -> Formula:
    """The first row of (10) has B_1 and B_2 of (9) the other way round."""
    k, step = rest_roots(1)[0], 1e-5
    even, odd = np.cos(k) + np.cosh(k), np.sin(k) + np.sinh(k)
    bent = rest_modes(np.array([0.0, step, 2 * step]), 1)[2][0]
    rate = (-3 * bent[0] + 4 * bent[1] - bent[2]) / (2 * step)
    found = float(rate / (k * bent[0]))  # third over second derivative of (9) at 0
    return Formula(-odd / even, -even / odd, found)


def free_end(session: Session) -> Formula:
    """The second row of (10) has cos - cosh where the shear force has cos + cosh."""
    k = rest_roots(1)[0]
    ratio = -(np.cos(k) + np.cosh(k)) / (np.sin(k) + np.sinh(k))  # sine's part of the mode
    bent = -(np.sin(k) - np.sinh(k))
    printed, right = (bent + ratio * (np.cos(k) + s * np.cosh(k)) for s in (-1, 1))
    return Formula(printed, right, 0.0)


def determinant(session: Session) -> Formula:
    """(11) as printed is 2 sin^2, which vanishes at i pi."""
    k = rest_roots(1)[0]
    cos, sin, cosh, sinh = np.cos(k), np.sin(k), np.cosh(k), np.sinh(k)
    printed = (cos + cosh) * (cosh - cos) - (sin + sinh) * (sinh - sin)
    right = (cos + cosh) ** 2 - (sin + sinh) * (sinh - sin)
    return Formula(printed, right, 0.0)


def frequency_formula(session: Session) -> Formula:
    """The formula lacks the square of beta_i L."""
    k, unit = rest_roots(1)[0], time_unit(BEAM)
    found = frequencies(BEAM.replace(angular_speed=0.0), count=1).omega[0]
    return Formula(k / unit, k**2 / unit, float(found))


def mode_sign(session: Session) -> Formula:
    """(12) has the sign of xi_i wrong."""
    k = rest_roots(1)[0]
    xi = (np.cos(k) + np.cosh(k)) / (np.sin(k) + np.sinh(k))
    printed, right = (-np.cos(k) - np.cosh(k) - s * xi * (np.sin(k) + np.sinh(k)) for s in (1, -1))
    found = rest_modes(1.0, 1)[2][0, 0] / k**2
    return Formula(printed, right, float(found))


def mode_argument(session: Session) -> Formula:
    """(12) has xi_i with x for L: no constant."""
    k = rest_roots(1)[0]

    def xi(x: float) -> float:
        return float((np.cos(x) + np.cosh(x)) / (np.sin(x) + np.sinh(x)))

    def mode(x: float, factor: float) -> float:
        return float(np.cos(x) - np.cosh(x) - factor * (np.sin(x) - np.sinh(x)))

    printed, right = (mode(k / 2, factor) / mode(k, xi(k)) for factor in (xi(k / 2), xi(k)))
    (half, end), _, _ = (part[0] for part in rest_modes(np.array([0.5, 1.0]), 1))
    return Formula(printed, right, float(half / end))


# Equations of motion (14) to (16) -----------------------------------------------------------


class OneMode(NamedTuple):
    """Parts of (16), of the beam and of the mass: one axial and one bending mode."""

    moment: Array
    """(a + x)^2"""
    across: Array
    """(a + x) phi_2"""
    along: Array
    """phi_1 without the lever, then with x"""
    square: Array
    """phi_2^2"""
    pull: Array
    """(a + x) H"""


def one_mode(p: RotatingBeam) -> OneMode:
    """Return them: columns are the beam and the mass."""
    n = numbers(p)
    x, weight = quadrature()
    # in two pieces, so that H up to the mass is integrated exactly
    slopes = [rest_modes(part * x, 1)[1][0] for part in (1.0, n.beta)]
    bend = [rest_modes(part, 1)[0][0] for part in (x, n.beta)]
    axial = [np.sin(np.pi / 2 * np.asarray(part)) for part in (x, n.beta)]
    outer = n.delta * (1 - x) + (1 - x**2) / 2  # by parts: what pulls at x
    lever = n.delta + n.beta
    return OneMode(
        moment=np.array([weight @ (n.delta + x) ** 2, n.alpha * lever**2]),
        across=np.array([weight @ ((n.delta + x) * bend[0]), n.alpha * lever * bend[1][0]]),
        along=np.array(
            [
                [weight @ axial[0], n.alpha * axial[1]],
                [weight @ (x * axial[0]), n.alpha * n.beta * axial[1]],
            ]
        ),
        square=np.array([weight @ bend[0] ** 2, n.alpha * bend[1][0] ** 2]),
        pull=np.array(
            [
                weight @ (outer * slopes[0] ** 2),
                n.alpha * lever * n.beta * (weight @ slopes[1] ** 2),
            ]
        ),
    )


def paper_scene(p: RotatingBeam) -> tuple[Any, Any]:
    """Return the matrices (16) of the reference with these two modes, and the bending one's scale.

    The reference's coordinate is the slope's: phi_2 has its sign and root of the other way round.
    """
    c = coefficients(p.replace(drive="torque"))
    shapes = cantilever_modes(1, 1, c.place)
    return prepare_truncated(shapes, c), -rest_roots(1)[0]


def equation_14_axial(session: Session) -> Formula:
    """Row 1 of (14) has lost a prime."""
    c = coefficients(BEAM)
    shapes = cantilever_modes(1, 1, 1.0)
    found = np.sum(shapes.weights * shapes.stretch[:, 0] ** 2) * c.axial * (np.pi / 2) ** 2
    unit = BEAM.length**2
    values = c.axial / 2 / unit, c.axial * np.pi**2 / 8 / unit, float(found) / unit
    return Formula(*values)


def equation_14_driving(session: Session) -> Formula:
    """Row 2 of (14) has theta'' with the wrong sign."""
    right = float(np.sum(one_mode(LOADED).across))
    matrices, scale = paper_scene(LOADED)
    found = matrices.mass[0, 1] * scale / coefficients(LOADED).beam
    return Formula(-right, right, float(found))


def equation_14_centrifugal(session: Session) -> Formula:
    """Row 2 of (14) has both terms of the mass with theta'^2 B_2 with the wrong sign."""
    parts = one_mode(LOADED)
    right = float(parts.pull[1] - parts.square[1])
    with_mass, bare = (
        paper_scene(p)[0].softening[1, 1] for p in (LOADED, LOADED.replace(mass=0.0))
    )
    scale = paper_scene(LOADED)[1]
    found = -(with_mass - bare) * scale**2 / coefficients(LOADED).beam
    return Formula(-right, right, float(found))


def inertia(p: RotatingBeam) -> float:
    """Moment of inertia of the straight scene about its axis [kg m^2]."""
    q, _ = straight(p, 0.0)
    return float(np.array(SCENE.mass_matrix(q, coefficients(p.replace(drive="torque"))))[0, 0])


def equation_14_hub(session: Session) -> Formula:
    """Row 3 of (14) has no J_h, and theta' for theta'' at the mass's (a + d)^2."""
    beam, mass = one_mode(LOADED).moment * coefficients(LOADED).beam
    right = beam + mass + LOADED.hub_inertia
    values = float(beam), float(right), inertia(LOADED)
    return Formula(*values)


def equation_14_mass(session: Session) -> Formula:
    """Row 3 of (14) has terms of the mass outside of m ( )."""
    p, scale = LOADED, paper_scene(LOADED)[1]
    arm = p.hub_radius + p.mass_position * p.length
    printed = arm * float(rest_modes(numbers(p).beta, 1)[0][0, 0])
    own = one_mode(p).across[1] * coefficients(p).beam / p.length
    loaded, bare = (paper_scene(one)[0].mass[0, 1] for one in (p, p.replace(mass=0.0)))
    found = float(loaded - bare) * scale / p.length
    return Formula(printed, float(own), found)


def hub_inertia(session: Session) -> Formula:
    """M_theta_theta lacks J_h."""
    whole = float(np.sum(one_mode(LOADED).moment) * coefficients(LOADED).beam)
    right = whole + LOADED.hub_inertia
    return Formula(whole, right, inertia(LOADED))


def torque(session: Session) -> Formula:
    """Q_theta lacks tau."""
    q, v = straight(FIGURE_5, 0.0)
    found = SCENE.forces(1.0, q, v, coefficients(FIGURE_5))[0]
    return Formula(0.0, 1.0, float(found))


def axial_pull(session: Session) -> Formula:
    """U_10 lacks the mass."""
    delta = numbers(LOADED).delta
    without, lever = one_mode(LOADED).along
    printed, right = (float(np.sum(lever) + delta * part) for part in (without[0], np.sum(without)))
    found = paper_scene(LOADED)[0].pull[2] / coefficients(LOADED).beam * np.pi / 2
    return Formula(printed, right, float(found))


# The frequency equation (17) to (21) --------------------------------------------------------

MANY_MODES = 16
"""Assumed modes that come to within 1e-3 of what they converge to, even with a mass inside."""


def driving_vector(session: Session) -> Formula:
    """U_12 of (18) has the mass without its distance from the axis."""
    n, parts = numbers(LOADED), one_mode(LOADED).across
    printed = float(parts[0] + parts[1] / (n.delta + n.beta))
    matrices, scale = paper_scene(LOADED)
    found = matrices.mass[0, 1] * scale / coefficients(LOADED).beam
    return Formula(printed, float(np.sum(parts)), float(found))


def bending_stiffness(session: Session) -> Formula:
    """K^C of (21) has lost K_2."""
    n = numbers(LOADED)
    printed = assumed_modes(n, MANY_MODES, as_printed=True)[0]
    right, found = assumed_modes(n, MANY_MODES)[0], ritz(n, count=1).omega[0]
    return Formula(float(printed), float(right), float(found), within=1e-3)
