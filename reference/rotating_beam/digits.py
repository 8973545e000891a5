"""Legendre polynomials, Gauss points and linear equations in many digits, of Python's decimals.

Shape functions in doubles are off by hundreds of units of rounding near the ends of a piece, where
polynomials are steep, and all that follows of them with these; in decimals they are rounded once.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from decimal import Decimal, localcontext
from functools import cache
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from ..scene import Array

DIGITS = 40

NEWTON_STEPS = 2
"""From 16 digits, each of which doubles their number."""

Decimals = Any
"""Array of `decimal.Decimal`."""


@contextmanager
def many_digits() -> Iterator[None]:
    """Compute with decimals of `DIGITS` digits."""
    with localcontext(prec=DIGITS):
        yield


def decimals(values: Any) -> Decimals:
    """Return doubles as the decimals that they are."""
    return np.vectorize(Decimal, otypes=[object])(values)


def doubles(values: Decimals) -> Array:
    """Return decimals, rounded."""
    return np.asarray(values, dtype=float)


def legendre_values(x: Decimals, most: int) -> Decimals:
    """Return the Legendre polynomials (k, most + 1) up to a degree, at points (k,)."""
    values = [0 * x + 1, x]
    for j in range(1, most):
        values.append(((2 * j + 1) * x * values[-1] - j * values[-2]) / (j + 1))
    return np.stack(values[: most + 1], axis=-1)


@cache
def gauss(count: int) -> tuple[Decimals, Decimals]:
    """Return the Gauss points and weights (count,) on -1 to 1."""
    with many_digits():
        x = decimals(legendre.leggauss(count)[0])
        for last in [False] * NEWTON_STEPS + [True]:
            *_, before, value = legendre_values(x, count).T
            slope = count * (before - x * value) / (1 - x * x)
            if not last:
                x = x - value / slope
        return x, 2 / ((1 - x * x) * slope * slope)


def inverse(matrix: Decimals) -> Decimals:
    """Return the inverse of a matrix (n, n), by elimination."""
    n = len(matrix)
    rows = np.concatenate([matrix, np.eye(n, dtype=int).astype(object)], axis=1)
    for i in range(n):
        pivot = i + int(np.argmax(np.abs(doubles(rows[i:, i]))))
        rows[[i, pivot]] = rows[[pivot, i]]
        rows[i] = rows[i] / rows[i, i]
        for j in range(n):
            if j != i:
                rows[j] = rows[j] - rows[j, i] * rows[i]
    return rows[:, n:]
