"""Measures of what the rotating_beam paper derives: sections 2.1, 2.2, equations (5) to (22).

Equations are evaluated as printed, or with what their misprints put right.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import eigh

from ....reference.differences import lagrange_terms
from ....reference.rotating_beam.cases import FIGURE_4
from ....reference.rotating_beam.frequencies.assumed_modes import (
    assumed_mode_matrices,
    rest_modes,
    rest_roots,
)
from ....reference.rotating_beam.frequencies.numbers import numbers, time_unit
from ....reference.rotating_beam.parameters import RotatingBeam, coefficients, drive
from ....reference.scene import Array
from ..equations import Identities
from ..ledger import Numbers
from ..session import Session
from .results import BEAM, HUB_RADIUS, SPEED

LOADED = BEAM.replace(hub_radius=HUB_RADIUS, mass=0.4, mass_position=0.5, hub_inertia=10.0)
"""Of which (15) is assembled: a beam with a hub and a mass in the middle."""

MODES = 2
"""Axial ones and bending ones."""

AXIAL, BENDING = slice(1, 1 + MODES), slice(1 + MODES, 1 + 2 * MODES)


def gauss(low: float, high: float) -> tuple[Array, Array]:
    """Return places and weights between two places."""
    x, weight = legendre.leggauss(32)
    return (low + high + (high - low) * x) / 2, (high - low) / 2 * weight


def axial_modes(x: Any, p: RotatingBeam) -> tuple[Array, Array]:
    """Return the axial shapes (MODES, k) below (9), and their slopes, at places [m]."""
    wave = (2 * np.arange(MODES)[:, None] + 1) * np.pi / 2 / p.length
    return np.sin(wave * x), wave * np.cos(wave * x)


def bending_modes(x: Any, p: RotatingBeam) -> tuple[Array, Array, Array]:
    """Return the bending shapes (MODES, k) of (12), put right, and two derivatives."""
    value, slope, curvature = rest_modes(np.atleast_1d(x) / p.length, MODES)
    return value, slope / p.length, curvature / p.length**2


def pulled(x: float, p: RotatingBeam) -> Array:
    """Return Z(x) (MODES, MODES) of (16)."""
    at, weight = gauss(0.0, x)
    slope = bending_modes(at, p)[1]
    return np.asarray((slope * weight) @ slope.T)


def stations(p: RotatingBeam) -> tuple[Array, Array]:
    """Return places [m] and masses [kg] of the beam, and last of the concentrated mass."""
    x, weight = gauss(0.0, p.length)
    return (
        np.append(x, p.mass_position * p.length),
        np.append(p.density * p.area * weight, p.mass),
    )


def terms_of_15(q: Array, v: Array, a: Array, p: RotatingBeam, right: Collection[str]) -> Array:
    """Return the terms (3, n) of (15), with the entries of (16): of a, of v, and of q and forces.

    Put right they have J_h (``hub``), and the mass in U_10 (``pull``); the torque is nil.
    """
    x, masses = stations(p)
    beam, (axial, _), (bending, _, _) = masses[:-1], axial_modes(x, p), bending_modes(x, p)
    line, weight = gauss(0.0, p.length)
    tension, curvature = axial_modes(line, p)[1], bending_modes(line, p)[2]
    r, m_11, m_22 = (
        (one * masses) @ other.T
        for one, other in ((axial, bending), (axial, axial), (bending, bending))
    )
    u_11, u_12 = ((masses * x) @ shape.T for shape in (axial, bending))
    u_20 = masses @ bending.T
    u_10 = masses @ axial.T if "pull" in right else beam @ axial[:, :-1].T
    z = np.array([pulled(place, p) for place in x])
    d_0, d_1 = np.tensordot(masses, z, 1), np.tensordot(masses * x, z, 1)
    k_1 = p.youngs_modulus * p.area * (tension * weight) @ tension.T
    k_2 = p.youngs_modulus * p.second_moment * (curvature * weight) @ curvature.T
    pull, hub = d_1 + p.hub_radius * d_0, p.hub_inertia if "hub" in right else 0.0
    b_1, b_2, v_1, v_2, speed = q[AXIAL], q[BENDING], v[AXIAL], v[BENDING], v[0]
    stretch = u_11 + p.hub_radius * u_10
    inertia = np.zeros((1 + 2 * MODES,) * 2)
    inertia[0, 0] = hub + masses @ (x + p.hub_radius) ** 2 + b_1 @ m_11 @ b_1 + b_2 @ m_22 @ b_2
    inertia[0, 0] += 2 * stretch @ b_1 - b_2 @ pull @ b_2
    inertia[0, AXIAL] = inertia[AXIAL, 0] = -r @ b_2
    inertia[0, BENDING] = inertia[BENDING, 0] = u_12 + b_1 @ r + p.hub_radius * u_20
    inertia[AXIAL, AXIAL], inertia[BENDING, BENDING] = m_11, m_22
    forces = 2 * speed * (b_1 @ m_11 @ v_1 + b_2 @ m_22 @ v_2 + stretch @ v_1 - b_2 @ pull @ v_2)
    gyroscopic = [forces, *(-2 * speed * r @ v_2), *(2 * speed * r.T @ v_1)]
    static = [
        0.0,
        *((k_1 - speed**2 * m_11) @ b_1 - speed**2 * stretch),
        *((k_2 - speed**2 * m_22 + speed**2 * pull) @ b_2),
    ]
    return np.array([inertia @ a, gyroscopic, static])


def lagrange(q: Array, v: Array, a: Array, p: RotatingBeam) -> Array:
    """Return the terms of Lagrange's equations of (1), (2) and (4), put right, to second order."""
    x, masses = stations(p)
    (axial, _), (bending, _, _) = axial_modes(x, p), bending_modes(x, p)
    line, weight = gauss(0.0, p.length)
    tension, curvature = axial_modes(line, p)[1], bending_modes(line, p)[2]
    reach = []  # of the foreshortening: slopes at places inside each station
    for place in x:
        at, within = gauss(0.0, place)
        reach.append((bending_modes(at, p)[1], within))

    def kinetic(q: Any, v: Any) -> Any:
        u, w = q[AXIAL] @ axial, q[BENDING] @ bending
        short = np.array([-(within @ (q[BENDING] @ slope) ** 2) / 2 for slope, within in reach])
        along = v[AXIAL] @ axial - w * v[0]
        across = v[BENDING] @ bending + (p.hub_radius + x + u) * v[0]
        square = along**2 + across**2 + 2 * (p.hub_radius + x) * short * v[0] ** 2
        return masses @ square / 2 + p.hub_inertia * v[0] ** 2 / 2

    def potential(q: Any) -> Any:
        stretch, bend = q[AXIAL] @ tension, q[BENDING] @ curvature
        return (
            p.youngs_modulus * (p.area * weight @ stretch**2 + p.second_moment * weight @ bend**2)
        ) / 2

    return lagrange_terms(kinetic, potential, q, v, a)


def matrices_16(session: Session) -> Numbers:
    """Return by how much (15), (16) miss Lagrange's equations, relative to the largest terms.

    At random states: put right, and but for the hub's inertia or the mass's pull.
    """
    random, size = np.random.default_rng(16), 1 + 2 * MODES
    lost = {"corrected": ("hub", "pull"), "hub": ("pull",), "pull": ("hub",)}
    off = dict.fromkeys(lost, 0.0)
    for _ in range(2):
        q, v, a = random.normal(size=(3, size)) * [[1.0], [2.0], [3.0]]
        q[AXIAL] *= 1e-3
        truth = lagrange(q, v, a, LOADED)
        for name, right in lost.items():
            left = terms_of_15(q, v, a, LOADED, right).sum(axis=0) - truth.sum(axis=0)
            worst = float(np.max(np.abs(left) / np.abs(truth).max(axis=0)))
            off[name] = max(off[name], worst)
    return off


def dimensionless(session: Session) -> Numbers:
    """Return by how much frequencies of (17) and of (18) differ, relative, by two modes."""
    p = LOADED.replace(angular_speed=SPEED)
    x, masses = stations(p)
    line, weight = gauss(0.0, p.length)
    bending, curvature = bending_modes(x, p)[0], bending_modes(line, p)[2]
    z = np.array([pulled(place, p) for place in x])
    pull = np.tensordot(masses * (x + p.hub_radius), z, 1)
    mass = (bending * masses) @ bending.T
    stiffness = p.youngs_modulus * p.second_moment * (curvature * weight) @ curvature.T
    squares = eigh(stiffness + SPEED**2 * (pull - mass), mass, eigvals_only=True)
    n = numbers(p)
    of_18 = assumed_mode_matrices(n, MODES)
    whole = of_18.bending + n.gamma**2 * (of_18.centrifugal - of_18.mass)
    own = np.sqrt(eigh(whole, of_18.mass, eigvals_only=True))
    return {"error": np.max(np.abs(np.sqrt(squares) * time_unit(p) / own - 1)), "own": own}


def foreshortening(session: Session) -> Numbers:
    """Return the relative errors of u_f at the free end for deflections of 1 and 10 % of L."""
    s, weight = gauss(0.0, 1.0)
    value, slope, _ = rest_modes(np.append(s, 1.0), 1)
    errors = []
    for size in (0.01, 0.1):
        bend = size * slope[0, :-1] / value[0, -1]  # arc length is the coordinate along the beam
        exact = weight @ (np.sqrt(1 - bend**2) - 1)
        errors.append(float(-(weight @ bend**2) / 2 / exact - 1))
    return {"errors": errors, "order": np.log10(errors[1] / errors[0])}


def mode_conditions(session: Session) -> Numbers:
    """Return what is left of the conditions at both ends by (8) and (9), of the largest terms.

    Value and slope at the clamp, moment and shear force at the free end, and of the axial modes
    value and slope, with B_1/B_2 from the moment, for three modes.
    """
    left = []
    for i, k in enumerate(rest_roots(3)):
        ratio = -(np.cos(k) + np.cosh(k)) / (np.sin(k) + np.sinh(k))
        b = np.array([ratio, 1.0, -ratio, -1.0])

        def terms(z: float, order: int, b: Array = b) -> Array:
            sines = [np.sin(z), np.cos(z), -np.sin(z), -np.cos(z)]
            circular = [sines[order % 4], sines[(order + 1) % 4]]
            hyperbolic = [np.sinh(z), np.cosh(z)] if order % 2 == 0 else [np.cosh(z), np.sinh(z)]
            return b * np.array([*circular, *hyperbolic])

        for z, order in ((0.0, 0), (0.0, 1), (k, 2), (k, 3)):
            parts = terms(z, order)
            left.append(abs(parts.sum()) / np.abs(parts).max())
        left.append(abs(np.cos((2 * i + 1) * np.pi / 2)))
    return {"left": max(left)}


PROBE = 1e-30
"""Complex step, far below rounding."""


IDENTITIES: Mapping[str, Identities] = {
    "expanded_5": Identities(
        """
        1 = (u_1**2 + u_f1**2 + 2*u_1*u_f1 + 2*(x + u_f + a)*v_1*w + rest)/square
        printed = (u**2 + u_f**2 + 2*u*u_f + 2*(x + u_f + a)*v*w + rest)/square
        """,
        """
        square = (u_1 + u_f1 - v*w)**2 + (v_1 + (a + x + u + u_f)*w)**2
        rest = v**2*w**2 - 2*u_1*v*w - 2*u_f1*v*w + x**2*w**2 + u**2*w**2 + 2*u_f*u*w**2 + v_1**2
            + u_f**2*w**2 + 2*u*x*w**2 + 2*u_f*x*w**2 + 2*u*v_1*w + a**2*w**2 + 2*a*x*w**2
            + 2*a*u*w**2 + 2*a*u_f*w**2
        """,
        dict(
            zip(
                ("a", "x", "u", "u_f", "v", "u_1", "u_f1", "v_1", "w"),
                np.random.default_rng(5).normal(size=9), strict=True,
            )
        ),
    ),
}  # fmt: skip
"""The beam's terms of (5) over the square of (3), which has the hub radius."""


def rows_of_14(q: Array, v: Array, a: Array, p: RotatingBeam, as_printed: bool) -> Array:
    """Return the rows (n,) of (14), all to the left, in the order of theta, B_1, B_2.

    As printed the first is not finite: there bare lengths and terms without theta'' stand beside
    torques.
    """
    x, masses = stations(p)
    beam, lump = masses.copy(), np.zeros_like(masses)
    beam[-1], lump[-1] = 0.0, masses[-1]
    (axial, _), (bending, _, _) = axial_modes(x, p), bending_modes(x, p)
    line, weight = gauss(0.0, p.length)
    tension, curvature = axial_modes(line, p), bending_modes(line, p)[2]
    h = np.array([pulled(place, p) for place in x])
    b_1, b_2, v_1, v_2, turn, push = q[AXIAL], q[BENDING], v[AXIAL], v[BENDING], v[0], a[0]
    u, u_1, u_2 = b_1 @ axial, v_1 @ axial, a[AXIAL] @ axial
    w, w_1, w_2 = b_2 @ bending, v_2 @ bending, a[BENDING] @ bending
    arm, pull = p.hub_radius + x, h @ b_2
    along = masses * (u_2 - 2 * w_1 * turn - w * push - arm * turn**2 - u * turn**2)
    stretched = tension[0 if as_printed else 1]  # phi_1 for phi_1'
    row_1 = axial @ along
    row_1 += p.youngs_modulus * p.area * (tension[1] * weight) @ (b_1 @ stretched)
    bent = p.youngs_modulus * p.second_moment * (curvature * weight) @ (b_2 @ curvature)
    free = w_2 + 2 * u_1 * turn
    if as_printed:
        across = beam * (free - arm * push - u * push - turn**2 * w)
        across += lump * (free - arm * push + u * turn + turn**2 * w)
        light = np.append(weight, 0.0) - lump  # no rho A, and a minus
        row_2 = bending @ across + turn**2 * (light * arm) @ pull + bent
        return np.array([np.nan, *row_1, *row_2])
    across = masses * (free + arm * push + u * push - turn**2 * w)
    row_2 = bending @ across + turn**2 * (masses * arm) @ pull + bent
    inertia = arm**2 + w**2 + u**2 + 2 * arm * u - arm * (pull @ b_2)
    rates = arm * u_1 + u * u_1 + w * w_1 - arm * (pull @ v_2)
    row_3 = masses @ (inertia * push + arm * w_2 + u * w_2 - w * u_2 + 2 * turn * rates)
    return np.array([row_3 + p.hub_inertia * push, *row_1, *row_2])


def equation_14(session: Session) -> Numbers:
    """Return by how much (14) misses Lagrange's equations at random states, of largest terms.

    All rows put right, rows 1 and 2, of B_1 and B_2, as printed, and (7) in place of row 3.
    """
    random, size = np.random.default_rng(14), 1 + 2 * MODES
    off = {"corrected": 0.0, "row_1": 0.0, "row_2": 0.0, "alone": 0.0}
    for _ in range(2):
        q, v, a = random.normal(size=(3, size)) * [[1.0], [2.0], [3.0]]
        q[AXIAL] *= 1e-3
        truth = lagrange(q, v, a, LOADED)
        whole, sizes = truth.sum(axis=0), np.abs(truth).max(axis=0)
        right, printed = (
            np.abs(rows_of_14(q, v, a, LOADED, as_printed) - whole) / sizes
            for as_printed in (False, True)
        )
        parts = {
            "corrected": right,
            "row_1": printed[AXIAL],
            "row_2": printed[BENDING],
            "alone": np.abs(LOADED.hub_inertia * a[:1] - whole[:1]) / sizes[:1],
        }
        off = {name: max(off[name], float(np.max(part))) for name, part in parts.items()}
    return off


def free_end(session: Session) -> Numbers:
    """Return residuals of (10), (11) and (12) for the first mode, as printed and put right.

    Of both rows of (10) with the constants of (9), over their largest terms; of the determinant;
    and of moment and shear force of (12) at the free end.
    """
    k = float(rest_roots(1)[0])
    cos, sin, cosh, sinh = np.cos(k), np.sin(k), np.cosh(k), np.sinh(k)
    xi = (cos + cosh) / (sin + sinh)
    sine, cosine = -xi, 1.0  # B_1 and B_2 of (9) in (12), its sign put right

    def largest(*rows: tuple[float, float]) -> float:
        return max(abs(sum(row)) / max(map(abs, row)) for row in rows)

    printed = {
        "(10)": largest(
            (sine * (cos + cosh), cosine * (sin + sinh)),
            (-sine * (sin - sinh), cosine * (cos - cosh)),
        ),
        "(11)": largest(((cos + cosh) * (-cos + cosh), -(sin + sinh) * (-sin + sinh))),
        "(12)": largest((-cos - cosh, xi * (-sin - sinh)), (sin - sinh, xi * (-cos - cosh))),
    }
    right = {
        "(10)": largest(
            (sine * (sin + sinh), cosine * (cos + cosh)),
            (sine * (cos + cosh), -cosine * (sin - sinh)),
        ),
        "(11)": largest(((cos + cosh) * (cos + cosh), -(sin + sinh) * (-sin + sinh))),
        "(12)": largest((-cos - cosh, -xi * (-sin - sinh)), (sin - sinh, -xi * (-cos - cosh))),
    }
    return {
        "as_printed": printed,
        "corrected": right,
        "least": min(printed.values()),
        "most": max(right.values()),
    }


def harmonic_motion(session: Session) -> Numbers:
    """Return what (20) leaves of (18), and (21) of itself, relative; (21) with K_2.

    With the first eigenvector of two modes, 0.4 kg in the middle at 7 rad/s; the right of (18) is
    nil at a constant speed.
    """
    n = numbers(LOADED.replace(angular_speed=SPEED))
    parts, time = assumed_mode_matrices(n, MODES), 0.3
    whole = parts.bending + n.gamma**2 * (parts.centrifugal - parts.mass)
    squares, vectors = eigh(whole, parts.mass)
    f, shape = np.sqrt(squares[0]), vectors[:, 0]
    period = 2 * np.pi / f * np.arange(16) / 16
    motion = np.exp(1j * f * (time + period))[:, None] * shape
    waves = np.fft.fftfreq(16, 1 / 16)[:, None] * f  # its derivatives by its Fourier series
    bent = np.fft.ifft((1j * waves) ** 2 * np.fft.fft(motion, axis=0), axis=0)
    left = bent @ parts.mass + motion @ whole
    return {
        "error": np.max(np.abs(left)) / np.max(np.abs(motion @ whole)),
        "eigen": np.max(np.abs(f**2 * parts.mass @ shape - whole @ shape))
        / np.max(np.abs(whole @ shape)),
        "f": f,
    }


def ramp(session: Session) -> Numbers:
    """Return by how much the scene's acceleration misses the slope of (22), over its largest.

    And the speed that (22) has at the end [rad/s].
    """
    c, end, last = coefficients(FIGURE_4), 15.0, 10.0
    t = end * (np.arange(64) + 0.5) / 64 + 1j * PROBE
    printed = last / end * t - last / (2 * np.pi) * np.sin(2 * np.pi / end * t)
    own, after = drive(t.real, c), drive(np.array([end, end + 1.0]), c)
    off = [*(own - printed.imag / PROBE), *after]
    reached = last / end * end - last / (2 * np.pi) * np.sin(2 * np.pi / end * end)
    return {
        "error": np.max(np.abs(off)) / np.max(np.abs(own)),
        "end": reached,
        "missed": abs(reached / last - 1),
    }
