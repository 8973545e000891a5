"""Frequencies of `rotating_beam` by the paper's assumed modes, and what figure 3 is made of."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import eigh
from scipy.optimize import brentq, minimize_scalar

from ...errors import ParameterError
from ...scene import Array
from .numbers import Numbers, check, tension
from .ritz import gram, places, ritz


def rest_roots(count: int) -> Array:
    """Return the roots of ``cos cosh = -1``, (11) with its signs put right."""

    def scaled(k: float) -> float:
        return float(np.cos(k) + 1 / np.cosh(k))

    return np.array([brentq(scaled, i * np.pi, (i + 1) * np.pi, xtol=1e-15) for i in range(count)])


def rest_modes(x: Any, count: int) -> tuple[Array, Array, Array]:
    """Modes (12) of the beam at rest without a mass, put right; first and second derivatives.

    Written with exponentials that decay, so that high modes keep their digits.

    Parameters
    ----------
    x : array (points,)
        Places, 0 to 1.
    count : int
    """
    k = rest_roots(count)[:, None]
    z = k * np.atleast_1d(x)
    # cosh - q sinh = (1 - q)/2 e^z + (1 + q)/2 e^-z, and 1 - q is of order e^-k
    down = np.exp(-k)
    below = 1 - down**2 + 2 * np.sin(k) * down  # 2 e^-k (sinh + sin)
    less = 2 * down * (np.sin(k) - np.cos(k) - down) / below  # 1 - q, q = (cosh + cos)/(sinh + sin)
    q = 1 - less
    rising = less * np.exp(z) / 2
    falling = (1 + q) * np.exp(-z) / 2
    return (
        rising + falling - np.cos(z) + q * np.sin(z),
        k * (rising - falling + np.sin(z) + q * np.cos(z)),
        k**2 * (rising + falling + np.cos(z) - q * np.sin(z)),
    )


class Matrices(NamedTuple):
    """Dimensionless matrices of (18), each (modes, modes): M_22, K_2 and D_1."""

    mass: Array
    bending: Array
    centrifugal: Array


def assumed_mode_matrices(n: Numbers, modes: int = 2) -> Matrices:
    """Matrices of (18): D_1 with the hub, once."""
    at = np.array([0.0, n.beta, 1.0]) if 0 < n.beta < 1 else np.array([0.0, 1.0])
    s, weight = legendre.leggauss(24 + 6 * modes)
    x, w = places(at, s, weight)
    value, slope, curvature = rest_modes(x, modes)
    mass = gram(value, w)
    at_mass = rest_modes(n.beta, modes)[0]
    return Matrices(
        mass=mass + n.alpha * at_mass @ at_mass.T,
        bending=gram(curvature, w),
        centrifugal=gram(slope, w * tension(n, x)),
    )


def assumed_modes(
    n: Numbers, modes: int = 2, plane: str = "chordwise", count: int = 1, as_printed: bool = False
) -> Array:
    """Frequencies (count,) of (18), dimensionless, with so many bending modes.

    With ``as_printed`` those of (21): without the bending stiffness, proportional to gamma.
    """
    check(n, plane, count)
    if modes < count:
        raise ParameterError(f"{count} frequencies need as many modes, not {modes}")
    matrices = assumed_mode_matrices(n, modes)
    shift = n.gamma**2 if plane == "chordwise" else 0.0
    stiffness = n.gamma**2 * matrices.centrifugal + (0 if as_printed else matrices.bending)
    squares = eigh(stiffness, matrices.mass, eigvals_only=True)[:count] - shift
    return np.sqrt(np.maximum(squares, 0.0))


def first_frequency(n: Numbers, modes: int | None = None) -> float:
    """First chordwise frequency, dimensionless, with n assumed modes or (None) converged."""
    omega = ritz(n, "chordwise", 1).omega if modes is None else assumed_modes(n, modes)
    return float(omega[0])


def best_mass_position(n: Numbers, modes: int | None = None) -> float:
    """Return the beta at which the first chordwise frequency is largest: figure 3.

    Parameters
    ----------
    n : Numbers
        Its beta is ignored.
    modes : int, optional
        So many assumed modes; converged by default.
    """

    def lower(beta: float) -> float:
        return -first_frequency(n._replace(beta=beta), modes)

    grid = np.linspace(0.04, 1, 25)
    top = int(np.argmin([lower(beta) for beta in grid]))
    around = grid[max(top - 1, 0)], grid[min(top + 1, len(grid) - 1)]
    return float(minimize_scalar(lower, bounds=around, options={"xatol": 1e-6}).x)


def first_rise(function: Callable[[float], float], grid: Array, **accuracy: float) -> float:
    """Return where a function first turns positive along a grid, NaN if nowhere."""
    before = function(grid[0])
    for one, other in pairwise(grid):
        after = function(other)
        if before < 0 <= after:
            return float(brentq(function, one, other, **accuracy))
        before = after
    return float("nan")


def crossover(n: Numbers, other: float = 0.0, modes: int | None = None) -> float:
    """Return the largest beta at which two masses give the same first chordwise frequency.

    NaN where there is none: at low speed a mass lowers the frequency wherever it sits.

    Parameters
    ----------
    n : Numbers
        Its beta is ignored.
    other : float
        The other mass ratio.
    modes : int, optional
        So many assumed modes; converged by default.
    """
    at_other = None if other else first_frequency(n._replace(alpha=0.0), modes)

    def difference(beta: float) -> float:
        one = first_frequency(n._replace(beta=beta), modes)
        return one - (at_other or first_frequency(n._replace(beta=beta, alpha=other), modes))

    return first_rise(difference, np.linspace(1, 0.05, 20), xtol=1e-9)


def matching_speed(n: Numbers, position: float, modes: int | None = None) -> float:
    """Return the lowest gamma at which `best_mass_position` is this; NaN where none is.

    Parameters
    ----------
    n : Numbers
        Its beta and gamma are ignored.
    position : float
    modes : int, optional
        So many assumed modes; converged by default.
    """

    def excess(gamma: float) -> float:
        return best_mass_position(n._replace(gamma=gamma), modes) - position

    return first_rise(excess, np.geomspace(*MATCHED, 13), rtol=1e-4)


MATCHED = (2.0, 200.0)
"""Range of gamma in which a match is sought."""
