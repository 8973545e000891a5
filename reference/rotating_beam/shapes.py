"""Shape functions of `rotating_beam`: polynomials, or the paper's modes.

The polynomials have one piece from clamp to mass and one from there to the tip, as smooth as the
solution: psi and psi' are continuous and psi' vanishes at the tip; psi'' and e jump at the mass.
A coordinate is the angle (the slope, the stretch) at one point, so that all have like sizes; the
error falls geometrically with their number.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from decimal import Decimal, localcontext
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import block_diag, null_space, qr

from ..scene import Array
from .frequencies.assumed_modes import rest_modes, rest_roots

DIGITS = 40

NEWTON_STEPS = 2
"""Newton steps from 16 digits; each doubles their number."""

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


class Shapes(NamedTuple):
    """Shape functions over s / L at Gauss points, and integrals from the clamp to the stations.

    Stations are the Gauss points and the mass.

    Attributes
    ----------
    angle : float or array
        P (gauss, n).
    curvature : float or array
        P' (gauss, n).
    stretch : float or array
        Q (gauss, k).
    integral : float or array
        (stations, gauss).
    weights : float or array
        Of the Gauss points: the beam's mass there, over all of it.
    """

    angle: Any
    curvature: Any
    stretch: Any
    integral: Any
    weights: Any
    stations: Any


MORE_POINTS = 12
"""Gauss points of a piece beyond the degree of its polynomials."""


def pieces(n: int, place: float) -> list[tuple[float, float, int]]:
    """Start, end and degree of psi on each piece: n free values are left by the conditions."""
    if place == 1:
        return [(0.0, 1.0, n + 1)]
    first = 2 + round((n - 2) * place)
    return [(0.0, place, first), (place, 1.0, n + 2 - first)]


def nodal(values: Decimals, rough: Array) -> Decimals:
    """Combine functions (points, n) so that each is 1 at one point and 0 at n - 1 others.

    The points are chosen by pivoting (approximate Fekete points) of the same functions in doubles,
    in any orthonormal basis of them.
    """
    _, pivots = qr(rough.T, mode="r", pivoting=True)
    return inverse(values[np.sort(pivots[: values.shape[1]])])


def free_series(conditions: Array) -> Array:
    """Return the series (m, n) that satisfy conditions (m - n, m) of entries 1 and -1, exactly."""
    count = len(conditions)
    last = -np.linalg.solve(conditions[:, -count:], conditions[:, :-count])
    return np.concatenate([np.eye(conditions.shape[1] - count), last])


@cache
def polynomials(n: int, k: int, place: float) -> Shapes:
    """Shapes of n bending and k stretching coordinates, mass at ``place``."""
    parts = pieces(n, place)
    first = min(k, max(1, round(k * place)))
    shares = [k] if len(parts) == 1 else [first, k - first]
    ends = [(-1.0) ** np.arange(degree) for _, _, degree in parts]  # of the curvature's series
    free_tip = np.concatenate([*(0 * end for end in ends[:-1]), abs(ends[-1])])
    conditions = np.array([free_tip, np.concatenate([abs(ends[0]), -ends[-1]])][: len(parts)])
    local = [gauss(degree + MORE_POINTS)[0] for _, _, degree in parts]
    with many_digits():
        stations = np.concatenate([*(gauss_points(*part)[0] for part in parts), decimals([place])])
        weights = np.concatenate([gauss_points(*part)[1] for part in parts])
        integral = np.hstack([piece_integral(stations, *part) for part in parts])
        series = block_diag(
            *(legendre_values(x, len(end) - 1) for x, end in zip(local, ends, strict=True))
        )
        curvature = series @ decimals(free_series(conditions))
        angle = integral[: len(weights)] @ curvature
        orthonormal = doubles(integral[: len(weights)] @ series) @ null_space(conditions)
        to_nodes = nodal(angle, orthonormal)
        stretch = block_diag(
            *(legendre_values(x, share)[:, :share] for x, share in zip(local, shares, strict=True))
        )
        tables = (
            angle @ to_nodes,
            curvature @ to_nodes,
            stretch @ nodal(stretch, doubles(stretch)) if k else stretch,
            integral,
            weights,
            stations,
        )
    return Shapes(*map(doubles, tables))


def gauss_points(start: float, end: float, degree: int) -> tuple[Decimals, Decimals]:
    """Gauss points and weights on a piece."""
    points, weights = gauss(degree + MORE_POINTS)
    begin, half = Decimal(start), (Decimal(end) - Decimal(start)) / 2
    return begin + half * (1 + points), half * weights


def piece_integral(stations: Decimals, start: float, end: float, degree: int) -> Decimals:
    """Integrals over a piece, up to the stations, of functions known at its Gauss points."""
    points, weights = gauss(degree + MORE_POINTS)
    count, half = len(points), (Decimal(end) - Decimal(start)) / 2
    double = 2 * np.arange(count).astype(object) + 1
    to_series = double[:, None] * legendre_values(points, count - 1).T * weights / 2
    ahead = (stations - Decimal(start)) / half - 1
    local = np.array([min(max(x, Decimal(-1)), Decimal(1)) for x in ahead])
    values = legendre_values(local, count)
    values[:, 1:-1] = (values[:, 2:] - values[:, :-2]) / double[1:]
    values[:, 0] += local
    return half * values[:, :-1] @ to_series


@cache
def cantilever_modes(n: int, k: int, place: float) -> Shapes:
    """Shapes of the paper: the modes (8), (12) at rest and without the mass, signs corrected."""
    exact = polynomials(max(n, 8) + 8, 1, place)
    at = exact.stations[: len(exact.angle)]
    roots = rest_roots(n)
    _, slope, curvature = rest_modes(at, n)
    odd = np.pi / 2 * (2 * np.arange(1, k + 1) - 1)
    return exact._replace(
        angle=-slope.T / roots,
        curvature=-curvature.T / roots,
        stretch=np.cos(np.multiply.outer(at, odd)),
    )


def prolongation(n: int, more: int, place: float) -> Array:
    """Return the matrix (more, n) from n bending coordinates to more of them, of the same shape.

    More coordinates have polynomials of a higher degree on the same pieces, and others of the
    points as theirs.
    """
    coarse, fine = polynomials(n, 0, place), polynomials(more, 0, place)
    known, rows = coarse.stations[:-1], []
    for start, end, degree in pieces(n, place):
        inside = (start < known) & (known < end)
        at = fine.stations[:-1][(start < fine.stations[:-1]) & (fine.stations[:-1] < end)]
        x, y = (2 * (points - start) / (end - start) - 1 for points in (known[inside], at))
        rows.append(legendre.legval(y, legendre.legfit(x, coarse.angle[inside], degree)).T)
    return np.asarray(np.linalg.lstsq(fine.angle, np.vstack(rows))[0])
