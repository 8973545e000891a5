"""Frequencies of `rotating_beam` by power series, step by step from the clamp."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from mbcheck.reference.differences import EPS
from mbcheck.reference.rotating_beam.frequencies.numbers import Numbers, check, pull
from mbcheck.reference.rotating_beam.frequencies.ritz import ROUNDING
from mbcheck.reference.scene import Array

TERMS = 40
"""Of the series; with steps this short they decay below rounding."""

APART = 1e-6
"""Relative distance over which the determinant's slope is taken."""

GRID = 0.05
"""Spacing of lambda^(1/4) at which the determinant's sign is looked at."""


def transfer(n: Numbers, load: Array, x: float, step: float) -> Array:
    """Matrices (k, 4, 4) that carry (w, w', w'', V) from x to x + step, no mass between.

    ``V = w''' - tau w'`` is minus the shear force and has the derivative ``load w``.
    """
    square = n.gamma**2
    tau = float(pull(n, x)), -square * (n.delta + x) - n.weight, -square / 2
    w = np.zeros((TERMS + 3, 4, len(load)))
    v = np.zeros((TERMS + 1, 4, len(load)))
    w[0, 0], w[1, 1], w[2, 2], v[0, 3] = 1, 1, 0.5, 1
    for k in range(TERMS):
        v[k + 1] = load * w[k] / (k + 1)
        slope = tau[0] * (k + 1) * w[k + 1] + tau[1] * k * w[k] + tau[2] * (k - 1) * w[k - 1]
        w[k + 3] = (v[k] + slope) / ((k + 1) * (k + 2) * (k + 3))
    degree: Array = np.arange(TERMS + 3.0)
    powers = step**degree
    rows = [powers, degree * powers / step, degree * (degree - 1) * powers / step**2]
    state = [np.tensordot(row, w, 1) for row in rows] + [np.tensordot(powers[: TERMS + 1], v, 1)]
    return np.moveaxis(np.array(state), 2, 0)


def free_end_determinant(n: Numbers, load: Array, refine: int = 1) -> tuple[Array, Array]:
    """Return numbers (k,) that vanish where ``load = lambda`` (k,) belongs to a vibration.

    Second comes the rounding (k,) that they may carry: half a unit of the products that they are
    the difference of, for each step.

    The two solutions that the clamp permits are orthonormalised after each step: they would
    else become parallel. That changes the determinant by a positive factor only. Each derivative
    is scaled by the wave number, lest rounding of the largest, V, be all that the least, w, has.
    """
    growth = 1 + np.sqrt(float(pull(n, 0.0))) + float(np.max(load)) ** 0.25
    edges = [0.0, n.beta, 1.0] if 0 < n.beta < 1 else [0.0, 1.0]
    two, taken = np.eye(4)[:, 2:], 0
    wave = np.maximum(load, 1.0) ** 0.25
    scale = wave[:, None] ** np.arange(4)
    for left, right in pairwise(edges):
        steps = refine * int(np.ceil((right - left) * growth))
        step = (right - left) / steps
        taken += steps
        for i in range(steps):
            carried = transfer(n, load, left + i * step, step) * scale[:, None] / scale[..., None]
            two, upper = np.linalg.qr(carried @ two)
            two = two * np.sign(np.diagonal(upper, axis1=1, axis2=2))[:, None, :]
        if right == n.beta:
            two[:, 3] += (load / wave**3 * n.alpha)[:, None] * two[:, 0]
    one, other = two[:, 2, 0] * two[:, 3, 1], two[:, 2, 1] * two[:, 3, 0]
    return one - other, taken * EPS / 2 * (np.abs(one) + np.abs(other))


def shooting(n: Numbers, plane: str = "chordwise", count: int = 2) -> tuple[Array, Array]:
    """Frequencies of the inextensible beam, by power series; with a bound on their errors.

    Returns
    -------
    omega, bound : array (count,)
        Dimensionless; the bound is what halving the steps changes, and rounding.
    """
    check(n, plane, count)
    shift = n.gamma**2 if plane == "chordwise" else 0.0

    def determinant(root: float, refine: int) -> float:
        return float(free_end_determinant(n, np.array([root**4]), refine)[0][0])

    roots: list[tuple[float, float]] = []
    grid: Array = GRID * np.arange(1.0, 2 + int(np.pi / GRID))  # a root in each pi, or nearly
    while len(roots) < count:
        signs = np.sign(free_end_determinant(n, grid**4)[0])
        for i in np.flatnonzero(signs[:-1] * signs[1:] < 0):
            ends = grid[i], grid[i + 1]
            pair = [brentq(determinant, *ends, (r,), xtol=1e-15, rtol=4 * EPS) for r in (1, 2)]
            roots.append((pair[0], pair[1]))
        grid = grid[-1] + GRID * np.arange(len(grid))
    coarse, fine = np.sqrt(np.array(roots[:count]).T ** 4 - shift)
    at = np.array(roots[:count])[:, 1]
    near = APART * at
    (low, _), (high, rounding) = (
        free_end_determinant(n, (at + sign * near) ** 4, 2) for sign in (-1, 1)
    )
    blurred = 2 * at**2 / fine * rounding * at * 2 * near / np.abs(high - low)
    strong = 40 * EPS * float(pull(n, 0.0))  # what a strong tension costs
    rounded = (4 * ROUNDING * (1 + shift / fine**2) + strong) * fine
    return fine, np.abs(fine - coarse) + rounded + blurred
