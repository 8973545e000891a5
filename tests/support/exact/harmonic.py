"""Floquet multipliers by Fourier collocation: orbits and their stability without any integration.

A periodic orbit is a trigonometric polynomial that satisfies the equations of motion at
equidistant times. Perturbations ``p(t) exp(lambda t)`` of it, p periodic, make an eigenvalue
problem (Hill's method). Nothing of it is shared with the shooting of `reference.orbits`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mbcheck.reference.differences import by_complex_step
from mbcheck.reference.scene import Array, EquationsOfMotion


def differentiation(count: int, period: float) -> Array:
    """Return the matrix (count, count) that differentiates trigonometric polynomials; odd count."""
    j = np.arange(count)
    off = j[:, None] - j
    with np.errstate(divide="ignore"):
        matrix = 0.5 * (-1.0) ** off / np.sin(np.pi * off / count)
    matrix[j, j] = 0.0
    return np.asarray(2 * np.pi / period * matrix)


def residual(
    scene: EquationsOfMotion, parameters: Any, samples: Array, period: float, turns: Array
) -> tuple[float, Array]:
    """Return by how far samples of an orbit are none, and slopes (count, 2 n, 2 n) of the rates.

    The former in the largest of each rate; nothing is solved, since the equations are singular at
    a fold.

    Parameters
    ----------
    scene, parameters
    samples : array (2 n, count)
        At equidistant times from 0 on, an odd number of them.
    period : float [s]
    turns : array (2 n,)
        By how much each state is ahead after a period.
    """
    count = samples.shape[1]
    times, drift = period * np.arange(count) / count, turns[:, None] / period
    rate = scene.right_hand_side(parameters)
    value, slopes = by_complex_step(lambda y: rate(times, y), samples)
    left = (samples - drift * times) @ differentiation(count, period).T + drift - value
    worst = np.max(np.abs(left), axis=1) / np.max(np.abs(value), axis=1)
    return float(np.max(worst)), np.moveaxis(slopes, -1, 0)


def multipliers(slopes: Array, period: float) -> Any:
    """Return the Floquet multipliers (2 n,) of an orbit with these slopes (count, 2 n, 2 n).

    Of each exponent those are taken that are known best: those in the strip about the real axis.
    """
    count, size = slopes.shape[:2]
    d = differentiation(count, period)
    blocks = [[np.diag(slopes[:, i, j]) for j in range(size)] for i in range(size)]
    exponents = np.linalg.eigvals(np.block(blocks) - np.kron(np.eye(size), d))
    middle = exponents[np.argsort(np.abs(exponents.imag))][: 3 * size]
    values = np.exp(middle * period)
    distinct: list[complex] = []
    for value in values:
        if all(abs(value - other) > 1e-6 for other in distinct):
            distinct.append(complex(value))
    return np.array(distinct[:size])
