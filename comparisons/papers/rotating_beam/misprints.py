"""Misprints of the paper on `rotating_beam`: what a formula gives as printed, and put right.

Each is shown by one number that the reference, which has its equations from Lagrange's, gives
by another route. Lengths are over L and masses over that of the beam where nothing else is said.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import eigh

from ....reference.linear import linearise
from ....reference.rotating_beam.cases import FIGURE_5
from ....reference.rotating_beam.equations import prepare_truncated
from ....reference.rotating_beam.frequencies.assumed_modes import (
    assumed_mode_matrices,
    assumed_modes,
    rest_modes,
    rest_roots,
)
from ....reference.rotating_beam.frequencies.continua import frequencies
from ....reference.rotating_beam.frequencies.numbers import numbers, time_unit
from ....reference.rotating_beam.frequencies.ritz import ritz
from ....reference.rotating_beam.parameters import RotatingBeam, coefficients
from ....reference.rotating_beam.scene import EXTENSIBLE, SCENE, beam_scene
from ....reference.rotating_beam.shapes import cantilever_modes
from ....reference.scene import Array, Scene
from ...engines.registry import REFERENCE
from ..ledger import CORRECTED, NOT_REPRODUCED, REPRODUCED, Finding, Row
from .results import BEAM, run

if TYPE_CHECKING:
    from ..session import Session

AGREE = 1e-7
"""Relative difference within which two values are the same."""

GRAVITY = 9.80665
"""[m/s^2]"""

LOADED = BEAM.replace(mass=0.4, mass_position=0.5)
"""Beam of figure 3, on its hub of 8 m, with a mass in the middle."""


class Shown(NamedTuple):
    """One quantity by the printed formula, by the corrected one, and by the reference."""

    what: str
    printed: float
    corrected: float
    reference: float
    unit: str = ""
    within: float = AGREE


def judged(shown: Shown) -> Finding:
    """Tell which of the two formulas gives what the reference does."""
    what, printed, corrected, reference, unit, within = shown
    room = within * max(abs(printed), abs(corrected), abs(reference))
    right, already = (abs(value - reference) <= room for value in (corrected, printed))
    reason = f"{what}: as printed {printed:.5g}, corrected {corrected:.5g} {unit}".strip()
    verdict = CORRECTED if right and not already else REPRODUCED if already else NOT_REPRODUCED
    return Finding(verdict, reason, f"{reference:.5g} {unit}".strip())


def straight(p: RotatingBeam, speed: float, scene: Any = SCENE) -> tuple[Array, Array]:
    """Return q and v of the straight beam that turns."""
    size = len(scene.coordinates)
    return np.zeros(size), speed * np.eye(size)[0]


def quadrature() -> tuple[Array, Array]:
    """Return points and weights over the beam, 0 to 1."""
    x, weight = legendre.leggauss(40)
    return (1 + x) / 2, weight / 2


# Energies (2) to (5) ------------------------------------------------------------------------


def strain_energy(session: Session) -> Shown:
    """Stretch evenly: (2) has the second derivative of u, which is 0."""
    stretch = 1e-4
    size, own = len(EXTENSIBLE.coordinates), [n.startswith("e_") for n in EXTENSIBLE.coordinates]
    found = EXTENSIBLE.energy(stretch * np.array(own, float), np.zeros(size), coefficients(BEAM))
    right = BEAM.youngs_modulus * BEAM.area * stretch**2 * BEAM.length / 2
    return Shown("strain energy of a beam stretched by 1e-4", 0.0, right, float(found), "J")


def kinetic_energy(hub_radius: float) -> float:
    """Energy [J] of the straight beam at 1 rad/s, clamped at this distance from the axis."""
    x, weight = quadrature()
    line = BEAM.density * BEAM.area * BEAM.length
    return float(line * np.sum(weight * (hub_radius + BEAM.length * x) ** 2) / 2)


def hub_radius(session: Session) -> Shown:
    """(3) turns the beam about its clamp."""
    c = coefficients(BEAM.replace(hub_inertia=0.0))
    found = SCENE.energy(*straight(BEAM, 1.0), c)
    values = kinetic_energy(0.0), kinetic_energy(BEAM.hub_radius), float(found)
    return Shown("kinetic energy at 1 rad/s on a hub of 8 m without inertia", *values, "J")


def coupling_energy(session: Session) -> Shown:
    """(4) has theta'^2 in a term that is linear in theta' and in v'."""
    c = coefficients(BEAM.replace(drive="torque"))
    q, v = straight(BEAM, 2.0)
    v[1] = 0.3
    mass = np.array(SCENE.mass_matrix(q, c))
    own = (mass[0, 0] * v[0] ** 2 + mass[1, 1] * v[1] ** 2) / 2
    printed, right = (own + mass[0, 1] * v[0] ** power * v[1] for power in (2, 1))
    return Shown(
        "kinetic energy of a beam that turns and bends",
        printed,
        right,
        float(SCENE.energy(q, v, c)),
        "J",
    )


def gravity(session: Session) -> Shown:
    """(4) and (5) have a weight that (14) to (16) know nothing of; they have d for x in it."""
    p = FIGURE_5.replace(mass=0.0)
    q, v = straight(p, 0.0)
    weight = p.density * p.area * p.length * GRAVITY
    torque = -weight * (p.hub_radius + p.mass_position * p.length)
    found = SCENE.forces(0.0, q, v, coefficients(p))[0]
    return Shown("torque on the hub at rest", torque, 0.0, float(found), "N m")


def hub_energy(session: Session) -> Shown:
    """(5) has lost the hub's part of (4)."""
    p = FIGURE_5.replace(mass=0.0)
    beam = p.density * p.area * p.length**3 / 6
    found = SCENE.energy(*straight(p, 1.0), coefficients(p))
    return Shown("kinetic energy at 1 rad/s", beam, beam + p.hub_inertia / 2, float(found), "J")


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


def hub_alone(session: Session) -> Shown:
    """(7) leaves out what the beam does to the hub."""
    p = FIGURE_5.replace(mass=0.0)
    end = np.array([p.torque_period])
    printed = p.torque_amplitude * p.torque_period**2 / (2 * np.pi * p.hub_inertia)
    whole = run(session, 5, REFERENCE, 0.0)
    found = whole.values["theta"][whole.times == p.torque_period][0]
    right = float(linear_pulse(p, end)["theta"][0])
    return Shown("hub's angle after the pulse", printed, right, float(found), "rad", 1e-4)


def axial_frequency(session: Session) -> Shown:
    """The second form, for i = 1, 3, 5, has lost the factor i."""
    scene = beam_scene("extensible", 2, 10)
    mass, _, stiffness = linearise(scene, BEAM, np.zeros(2 * len(scene.coordinates)))
    along = slice(3, None)
    squares = eigh(stiffness[along, along], mass[along, along], eigvals_only=True)
    first = np.pi / 2 / BEAM.length * np.sqrt(BEAM.youngs_modulus / BEAM.density)
    found = float(np.sqrt(squares[1]))
    return Shown("second axial frequency, i = 3", first, 3 * first, found, "rad/s")


def free_end(session: Session) -> Shown:
    """The second row of (10) has cos - cosh where the shear force has cos + cosh."""
    k = rest_roots(1)[0]
    ratio = -(np.cos(k) + np.cosh(k)) / (np.sin(k) + np.sinh(k))  # sine's part of the mode
    bent = -(np.sin(k) - np.sinh(k))
    printed, right = (bent + ratio * (np.cos(k) + s * np.cosh(k)) for s in (-1, 1))
    return Shown("shear force of the first mode at the free end", printed, right, 0.0)


def determinant(session: Session) -> Shown:
    """(11) as printed is 2 sin^2, which vanishes at i pi."""
    k = rest_roots(1)[0]
    cos, sin, cosh, sinh = np.cos(k), np.sin(k), np.cosh(k), np.sinh(k)
    printed = (cos + cosh) * (cosh - cos) - (sin + sinh) * (sinh - sin)
    right = (cos + cosh) ** 2 - (sin + sinh) * (sinh - sin)
    return Shown("determinant at 1.8751; as printed it is 2 sin^2", printed, right, 0.0)


def frequency_formula(session: Session) -> Shown:
    """The formula lacks the square of beta_i L."""
    k, unit = rest_roots(1)[0], time_unit(BEAM)
    found = frequencies(BEAM.replace(angular_speed=0.0), count=1).omega[0]
    return Shown("first frequency at rest", k / unit, k**2 / unit, float(found), "rad/s")


def mode_sign(session: Session) -> Shown:
    """(12) has the sign of xi_i wrong."""
    k = rest_roots(1)[0]
    xi = (np.cos(k) + np.cosh(k)) / (np.sin(k) + np.sinh(k))
    printed, right = (-np.cos(k) - np.cosh(k) - s * xi * (np.sin(k) + np.sinh(k)) for s in (1, -1))
    found = rest_modes(1.0, 1)[2][0, 0] / k**2
    return Shown("bending moment of the first mode at the free end", printed, right, float(found))


def mode_argument(session: Session) -> Shown:
    """(12) has xi_i with x for L: no constant."""
    k = rest_roots(1)[0]

    def xi(x: float) -> float:
        return float((np.cos(x) + np.cosh(x)) / (np.sin(x) + np.sinh(x)))

    def mode(x: float, factor: float) -> float:
        return float(np.cos(x) - np.cosh(x) - factor * (np.sin(x) - np.sinh(x)))

    printed, right = (mode(k / 2, factor) / mode(k, xi(k)) for factor in (xi(k / 2), xi(k)))
    (half, end), _, _ = (part[0] for part in rest_modes(np.array([0.5, 1.0]), 1))
    what = "deflection of the first mode in the middle over that of the end"
    return Shown(what, printed, right, float(half / end))


def normalisation(session: Session) -> Shown:
    """(13) does not hold for (12): the integral is the beam's mass."""
    x, weight = quadrature()
    line = BEAM.density * BEAM.area * BEAM.length
    found = line * np.sum(weight * rest_modes(x, 1)[0][0] ** 2)
    return Shown("integral of rho A phi_1^2", 1.0, line, float(found), "kg")


def orthogonality(session: Session) -> Shown:
    """(13) does not hold for the beam with its mass: m phi_1 phi_2 is left."""
    n = numbers(BEAM.replace(mass=0.4))
    one, two = rest_modes(1.0, 2)[0][:, 0]
    found = assumed_mode_matrices(n, 2).mass[0, 1]
    what = "M_22 between modes 1 and 2 with 0.4 kg at the tip, over the beam's mass"
    return Shown(what, 0.0, float(n.alpha * one * two), float(found))


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


def axial_stiffness(session: Session) -> Shown:
    """Row 1 of (14) has lost a prime."""
    c = coefficients(BEAM)
    shapes = cantilever_modes(1, 1, 1.0)
    found = np.sum(shapes.weights * shapes.stretch[:, 0] ** 2) * c.axial * (np.pi / 2) ** 2
    unit = BEAM.length**2
    values = c.axial / 2 / unit, c.axial * np.pi**2 / 8 / unit, float(found) / unit
    return Shown("stiffness of the first axial mode", *values, "N/m")


def driving(session: Session) -> Shown:
    """Row 2 of (14) has theta'' with the wrong sign."""
    right = float(np.sum(one_mode(LOADED).across))
    matrices, scale = paper_scene(LOADED)
    found = matrices.mass[0, 1] * scale / coefficients(LOADED).beam
    what = "what theta'' does to the first bending mode, over rho A L^2"
    return Shown(what, -right, right, float(found))


def centrifugal(session: Session) -> Shown:
    """Row 2 of (14) has both terms of the mass with theta'^2 B_2 with the wrong sign."""
    parts = one_mode(LOADED)
    right = float(parts.pull[1] - parts.square[1])
    with_mass, bare = (
        paper_scene(p)[0].softening[1, 1] for p in (LOADED, LOADED.replace(mass=0.0))
    )
    scale = paper_scene(LOADED)[1]
    found = -(with_mass - bare) * scale**2 / coefficients(LOADED).beam
    what = "stiffness that the mass has from theta'^2, over rho A L"
    return Shown(what, -right, right, float(found))


def inertia(p: RotatingBeam) -> float:
    """Moment of inertia of the straight scene about its axis [kg m^2]."""
    q, _ = straight(p, 0.0)
    return float(np.array(SCENE.mass_matrix(q, coefficients(p.replace(drive="torque"))))[0, 0])


def third_row(session: Session) -> Shown:
    """Row 3 of (14) has no J_h, and theta' for theta'' at the mass's (a + d)^2."""
    beam, mass = one_mode(LOADED).moment * coefficients(LOADED).beam
    right = beam + mass + LOADED.hub_inertia
    values = float(beam), float(right), inertia(LOADED)
    return Shown("what stands with theta'' of the straight beam", *values, "kg m^2")


def hub_inertia(session: Session) -> Shown:
    """M_theta_theta lacks J_h."""
    whole = float(np.sum(one_mode(LOADED).moment) * coefficients(LOADED).beam)
    right = whole + LOADED.hub_inertia
    return Shown("M_theta_theta, straight", whole, right, inertia(LOADED), "kg m^2")


def torque(session: Session) -> Shown:
    """Q_theta lacks tau."""
    q, v = straight(FIGURE_5, 0.0)
    found = SCENE.forces(1.0, q, v, coefficients(FIGURE_5))[0]
    return Shown("Q_theta at rest under 1 N m", 0.0, 1.0, float(found), "N m")


def axial_pull(session: Session) -> Shown:
    """U_10 lacks the mass."""
    delta = numbers(LOADED).delta
    without, lever = one_mode(LOADED).along
    printed, right = (float(np.sum(lever) + delta * part) for part in (without[0], np.sum(without)))
    found = paper_scene(LOADED)[0].pull[2] / coefficients(LOADED).beam * np.pi / 2
    return Shown("U_11 + a U_10, over rho A L^2", printed, right, float(found))


# The frequency equation (17) to (21) --------------------------------------------------------

MANY_MODES = 16
"""Assumed modes that come to within 1e-3 of what they converge to, even with a mass inside."""


def hub_twice(session: Session) -> Shown:
    """D_1 of (18) contains the hub radius, which (17) adds once more."""
    n = numbers(BEAM)
    parts = assumed_mode_matrices(n, MANY_MODES)
    hub = parts.centrifugal - assumed_mode_matrices(n._replace(delta=0.0), MANY_MODES).centrifugal
    pull = n.gamma**2 * (parts.centrifugal + hub - parts.mass)
    printed = np.sqrt(eigh(parts.bending + pull, parts.mass, eigvals_only=True)[0])
    right, found = assumed_modes(n, MANY_MODES)[0], ritz(n, count=1).omega[0]
    what = "first dimensionless frequency at 7 rad/s, a = L"
    return Shown(what, float(printed), float(right), float(found), within=1e-3)


def driving_vector(session: Session) -> Shown:
    """U_12 of (18) has the mass without its distance from the axis."""
    n, parts = numbers(LOADED), one_mode(LOADED).across
    printed = float(parts[0] + parts[1] / (n.delta + n.beta))
    matrices, scale = paper_scene(LOADED)
    found = matrices.mass[0, 1] * scale / coefficients(LOADED).beam
    return Shown("U_12 of the first mode", printed, float(np.sum(parts)), float(found))


def bending_stiffness(session: Session) -> Shown:
    """K^C of (21) has lost K_2."""
    n = numbers(LOADED)
    printed = assumed_modes(n, MANY_MODES, as_printed=True)[0]
    right, found = assumed_modes(n, MANY_MODES)[0], ritz(n, count=1).omega[0]
    what = "first dimensionless frequency at 7 rad/s, 0.4 kg in the middle"
    return Shown(what, float(printed), float(right), float(found), within=1e-3)


# Rows ---------------------------------------------------------------------------------------

ENERGIES, MODES, MOTION, FREQUENCY = (
    f"tests/test_rotating_beam_paper.py::test_misprints_of_the_{part}"
    for part in ("energies", "modes", "equations_of_motion", "frequency_equation")
)


def misprint(
    name: str,
    where: str,
    claim: str,
    show: Callable[[Session], Shown],
    test: str,
    slow: bool = False,
) -> Row:
    """Return the row of a misprint."""
    return Row(
        name, "misprint", where, claim, lambda session: judged(show(session)), test=test, slow=slow
    )


MISPRINTS = (
    misprint(
        "strain_energy",
        "equation (2)",
        "stretching stores energy by u_xx: it is u_x",
        strain_energy,
        ENERGIES,
    ),
    misprint(
        "hub_radius", "equation (3)", "the velocity has no hub radius a in it", hub_radius, ENERGIES
    ),
    misprint(
        "coupling_energy",
        "equation (4)",
        "turning and bending couple by theta'^2: it is theta'",
        coupling_energy,
        ENERGIES,
    ),
    misprint(
        "gravity",
        "equations (4), (5)",
        "a beam in a horizontal plane has weight",
        gravity,
        ENERGIES,
    ),
    misprint("hub_energy", "equation (5)", "the hub has no kinetic energy", hub_energy, ENERGIES),
    misprint(
        "hub_alone",
        "equation (7)",
        "the hub feels the torque only, not the beam",
        hub_alone,
        MOTION,
        slow=True,
    ),
    misprint(
        "axial_frequency",
        "section 2.2",
        "axial frequencies for i = 1, 3, 5 do not depend on i",
        axial_frequency,
        MODES,
    ),
    misprint(
        "free_end",
        "equation (10)",
        "the shear force at the free end has cos - cosh",
        free_end,
        MODES,
    ),
    misprint("determinant", "equation (11)", "the determinant has these signs", determinant, MODES),
    misprint(
        "frequency_formula",
        "section 2.2",
        "bending frequencies are proportional to beta_i L, not to its square",
        frequency_formula,
        MODES,
    ),
    misprint("mode_sign", "equation (12)", "xi_i is positive", mode_sign, MODES),
    misprint("mode_argument", "equation (12)", "xi_i depends on x", mode_argument, MODES),
    misprint(
        "normalisation",
        "equation (13)",
        "modes (12) have the integral 1 of rho A phi^2",
        normalisation,
        MODES,
    ),
    misprint(
        "orthogonality",
        "equation (13)",
        "the modes are orthogonal, which (16) needs of the beam with its mass",
        orthogonality,
        MODES,
    ),
    misprint(
        "equation_14_axial",
        "equation (14), row 1",
        "the axial stiffness is the integral of EA phi' phi",
        axial_stiffness,
        MOTION,
    ),
    misprint(
        "equation_14_driving",
        "equation (14), row 2",
        "theta'' stands with a minus in the row of B_2",
        driving,
        MOTION,
    ),
    misprint(
        "equation_14_centrifugal",
        "equation (14), row 2",
        "a mass softens the beam by its pull, and stiffens it by its inertia",
        centrifugal,
        MOTION,
    ),
    misprint(
        "equation_14_hub",
        "equation (14), row 3",
        "neither hub nor mass resist theta''",
        third_row,
        MOTION,
    ),
    misprint("hub_inertia", "equation (16)", "M_theta_theta has no J_h", hub_inertia, MOTION),
    misprint("torque", "equation (16)", "Q_theta has no torque tau", torque, MOTION),
    misprint("axial_pull", "equation (16)", "U_10 has no concentrated mass", axial_pull, MOTION),
    misprint(
        "hub_twice",
        "equations (17), (18)",
        "D_1 has the hub radius in it, and a D_0 is added",
        hub_twice,
        FREQUENCY,
    ),
    misprint(
        "driving_vector",
        "equation (18)",
        "U_12 has the mass without its distance from the axis",
        driving_vector,
        FREQUENCY,
    ),
    misprint(
        "bending_stiffness",
        "equation (21)",
        "K^C has no bending stiffness K_2",
        bending_stiffness,
        "tests/test_rotating_beam_frequencies.py"
        "::test_figure_3_without_bending_stiffness_has_no_speed",
    ),
)
