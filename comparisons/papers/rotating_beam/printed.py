"""Measures of the rotating_beam paper's equations (5), (10)-(12), (14) and (18)-(22).

Each is evaluated as printed, or with what its misprints put right.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh

from ....reference.rotating_beam import FIGURE_4
from ....reference.rotating_beam.frequencies.assumed_modes import assumed_mode_matrices, rest_roots
from ....reference.rotating_beam.frequencies.numbers import numbers
from ....reference.rotating_beam.parameters import RotatingBeam, coefficients, drive
from ....reference.scene import Array
from ..ledger import Numbers
from ..session import Session
from . import derivation
from .derivation import AXIAL, BENDING, LOADED, MODES, axial_modes, bending_modes, lagrange, pulled
from .results import SPEED

PROBE = 1e-30
"""Complex step, far below rounding."""


def terms_of_5(as_printed: bool) -> float:
    """Return by how much the beam's terms of (5) miss the square of (3), relative.

    At random values; (3) has the hub radius, and corrected terms the dots that (5) has lost.
    """
    a, x, u, u_f, v, u_1, u_f1, v_1, w = np.random.default_rng(5).normal(size=9)
    square = (u_1 + u_f1 - v * w) ** 2 + (v_1 + (a + x + u + u_f) * w) ** 2
    own, own_f, across = (u, u_f, v) if as_printed else (u_1, u_f1, v_1)
    first = own**2 + own_f**2 + 2 * own * own_f + v**2 * w**2 - 2 * u_1 * v * w - 2 * u_f1 * v * w
    first += x**2 * w**2 + u**2 * w**2
    second = 2 * u_f * u * w**2 + v_1**2 + u_f**2 * w**2 + 2 * u * x * w**2 + 2 * u_f * x * w**2
    second += 2 * x * across * w + 2 * u * v_1 * w
    third = 2 * u_f * across * w + a**2 * w**2 + 2 * a * x * w**2 + 2 * a * u * w**2
    third += 2 * a * u_f * w**2 + 2 * a * across * w
    return float(abs(first + second + third - square) / square)


def rows_of_14(q: Array, v: Array, a: Array, p: RotatingBeam, as_printed: bool) -> Array:
    """Return the rows (n,) of (14), all to the left, in the order of theta, B_1, B_2.

    As printed the first is not finite: there bare lengths and terms without theta'' stand beside
    torques.
    """
    x, masses = derivation.stations(p)
    beam, lump = masses.copy(), np.zeros_like(masses)
    beam[-1], lump[-1] = 0.0, masses[-1]
    (axial, _), (bending, _, _) = axial_modes(x, p), bending_modes(x, p)
    line, weight = derivation.gauss(0.0, p.length)
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


def equation_5(session: Session) -> Numbers:
    """Return what (5) leaves of the square of (3), as printed and corrected."""
    return {"as_printed": terms_of_5(True), "corrected": terms_of_5(False)}


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
