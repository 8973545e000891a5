"""Frequencies of `rotating_beam` by polynomials of high degree on either side of the mass."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import solve_triangular

from ...bounds.modes import graded_svd
from ...errors import MbcheckError
from ...scene import Array
from .numbers import NaturalModes, Numbers, check, pull


class Table(NamedTuple):
    """Basis functions (rows) at points (columns) of all elements, with their derivatives."""

    x: Array
    weight: Array
    value: Array
    slope: Array
    curvature: Array


def element_ends(n: Numbers) -> Array:
    """Ends of the elements: one on either side of a mass inside the beam."""
    return np.array([0.0, 1.0] if n.beta in (0.0, 1.0) or n.alpha == 0 else [0.0, n.beta, 1.0])


def basis(
    ends: Array,
    degree: int,
    s: Array,
    weight: Array,
    times: int = 2,
    bend: Array | None = None,
) -> Table:
    """Legendre polynomials of one element each, integrated from the clamp.

    Integrated twice, they are clamped shapes with continuous value and slope, and their own
    energy of bending is 1: that keeps elements of any length well conditioned. Integrated
    once, they vanish at the clamp and are continuous.

    Parameters
    ----------
    ends : array (elements + 1,)
    degree : int
    s, weight : array (k,)
        Points in each element, -1 to 1, and their weights.
    times : {2, 1}
    bend : array (elements - 1,), optional
        Ratio of the slopes behind and before an inner end; 1 by default.
    """
    p = legendre.legvander(s, degree + times).T
    tables = [p]
    for _ in range(times):  # the integral from -1; what stands for P_-1 is -P_0
        last = tables[-1]
        k = np.arange(len(last) - 1)[:, None]
        tables.append((last[1:] - np.vstack([-last[:1], last[:-2]])) / (2 * k + 1))
    norm = np.sqrt(np.arange(degree) + 0.5)[:, None]
    tables = [norm * table[:degree] for table in tables[::-1]]
    # at the end all are 0 but one slope, or but two values: the element carries what is beyond
    end_slope, end_values = 2 * norm[0, 0], norm[:2, 0] * np.array([2.0, -2 / 3])
    elements = len(ends) - 1
    half = np.diff(ends) / 2
    flat_x, weights = places(ends, s, weight)
    x = flat_x.reshape(elements, -1)
    values = np.zeros((3, elements, degree, elements, len(s)))
    for e in range(elements):
        for order, table in enumerate(tables):
            values[order, e, :, e] = table * half[e] ** (times - 0.5 - order)
        for after in range(e + 1, elements):
            slope = end_slope * half[e] ** 0.5
            if times == 1:
                values[0, e, 0, after] = slope
                continue
            slope *= 1.0 if bend is None else bend[e]
            values[0, e, :2, after] = end_values[:, None] * half[e] ** 1.5
            values[0, e, 0, after] += slope * (x[after] - ends[e + 1])
            values[1, e, 0, after] = slope
    flat = values.reshape(3, elements * degree, -1)
    return Table(flat_x, weights, *flat)


def at_mass(n: Numbers, ends: Array, degree: int, times: int = 2) -> Array:
    """Values of the basis where the mass sits, times the root of its ratio alpha."""
    if n.beta == 0:
        return np.zeros(degree * (len(ends) - 1))
    end = np.ones(1)
    values: Array = np.sqrt(n.alpha) * basis(ends, degree, end, end, times).value[:, 0]
    return values


def places(ends: Array, s: Array, weight: Array) -> tuple[Array, Array]:
    """Points and weights of all elements in a row."""
    half, middle = np.diff(ends) / 2, (ends[1:] + ends[:-1]) / 2
    return (middle[:, None] + np.outer(half, s)).ravel(), np.outer(half, weight).ravel()


def gram(rows: Array, factor: Any, columns: Array | None = None) -> Array:
    """Return the integrals of products of basis functions; ``factor`` includes the weights."""
    matrix: Array = (rows * factor) @ (rows if columns is None else columns).T
    return matrix


def gauss(degree: int) -> tuple[Array, Array]:
    """Points and weights that integrate products of three such polynomials."""
    rule: tuple[Array, Array] = legendre.leggauss(degree + 8)
    return rule


DEGREES = (16, 24, 36, 54, 80, 120)
"""Degrees of the polynomials that are tried until two results agree."""

AGREED = 1e-12
"""Relative difference of frequencies that counts as agreement."""

ROUNDING = 2e-14
"""Relative rounding error that an eigenvalue is granted for each unit of cancellation."""

Solve = Callable[[int], Array]
"""Function of the degree of the polynomials that returns frequencies."""


def converged(solve: Solve, count: int, cancellation: Callable[[Array], Any]) -> NaturalModes:
    """Raise the degree until the frequencies stand still.

    The bound is their last change, plus rounding times ``cancellation``. The change from one
    degree to the next is far above what the next leaves: convergence is exponential.
    """
    before = None
    for degree in DEGREES:
        omega = solve(degree)
        if before is not None:
            change = np.abs(omega - before)
            if np.all(change < (AGREED + ROUNDING * cancellation(omega)) * omega):
                bound = change + ROUNDING * cancellation(omega) * omega
                return NaturalModes(omega, bound)
        before = omega
    raise MbcheckError(
        f"{count} frequencies need polynomials of a degree above {DEGREES[-1]}: "
        "ask for fewer, or for a lower speed"
    )


def ritz(n: Numbers, plane: str = "chordwise", count: int = 2) -> NaturalModes:
    """Frequencies of the inextensible beam, by polynomials: (17) with very many modes."""
    check(n, plane, count)
    ends = element_ends(n)
    shift = n.gamma**2 if plane == "chordwise" else 0.0

    def solve(degree: int) -> Array:
        at, deflection = basis(ends, degree, *gauss(degree)), at_mass(n, ends, degree)
        inertia = np.column_stack([at.value * np.sqrt(at.weight), deflection])
        stiffness = gram(at.curvature, at.weight)
        stiffness += gram(at.slope, pull(n, at.x) * at.weight)
        factor = np.linalg.cholesky(stiffness)
        # the inverse problem, in factors: the lowest frequencies are the best determined, and the
        # others keep their digits beside that of a heavy mass
        of_energy = solve_triangular(factor, inertia, lower=True)
        inverse = graded_svd(of_energy.T)[0][:count]
        return np.asarray(np.sqrt(1 / inverse**2 - shift))

    return converged(solve, count, lambda omega: 1 + shift / omega**2)
