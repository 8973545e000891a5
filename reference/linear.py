"""Natural frequencies and damping of ``M a + C v + K q = 0``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eig, eigh, null_space

from .differences import by_complex_step
from .errors import MbcheckError
from .scene import Array, Dynamics

FREE = 1e-10
"""A direction that resists by less than this share of the stiffest is free: differences leave
as much in an engine's matrices."""

ZERO = 1e-6
"""An eigenvalue below this share of the largest counts as a zero mode (has no damping ratio)."""

SMALL = 1e-6
"""Relative correction of an eigenvalue up to which it is simple, and Newton's method holds."""

OVERFLOW = (
    "the natural frequencies, or their ratios, exceed what floating-point numbers hold; bring "
    "masses, stiffnesses and dampings closer together"
)


@dataclass(frozen=True)
class Mode:
    """One mode.

    Attributes
    ----------
    re, im : float
        real part [1/s] and imaginary part [rad/s] of the eigenvalue
    omega : float
        its modulus [rad/s]
    hertz : float
        omega / (2 pi) [Hz]
    damping_ratio : float or None
        -re / omega [1]; null for a zero mode, which has none
    error_bound : float or None
        bound on the error of the eigenvalue in the complex plane, hence of `re`, `im` and `omega`
        [1/s]; null for an engine, and where rounding leaves none
    damping_ratio_bound : float or None
        bound on the error of `damping_ratio` [1]; null where there is none
    """

    re: float
    im: float
    omega: float
    hertz: float
    damping_ratio: float | None
    error_bound: float | None = None
    damping_ratio_bound: float | None = None


def modes(
    mass: Array,
    damping: Array,
    stiffness: Array,
    steady: Sequence[int] = (),
    free_share: float = FREE,
) -> list[Mode]:
    """Modes ascending in omega; a complex pair is one mode, a real eigenvalue is one mode.

    A direction that neither spring nor damper resists has a double zero eigenvalue, which
    is listed once; such directions are split off first, because a defective eigenvalue
    would keep half its digits only.

    Parameters
    ----------
    mass, damping, stiffness : array (n, n)
    steady : sequence of int
        Coordinates that keep their speed; each counts as a zero mode.
    free_share : float
        Of the stiffest direction, by which one resists that counts as free; 0 where none is.

    Raises
    ------
    MbcheckError
        If a matrix is not finite, the mass matrix is not positive definite, or numbers overflow.
    """
    if steady:
        left = np.delete(np.arange(len(mass)), steady)
        inner = np.ix_(left, left)
        others = modes(mass[inner], damping[inner], stiffness[inner], (), free_share)
        return [Mode(0.0, 0.0, 0.0, 0.0, None)] * len(steady) + others
    if not all(np.all(np.isfinite(m)) for m in (mass, damping, stiffness)):
        raise MbcheckError("the linearised model is not finite")
    try:
        np.linalg.cholesky(mass)
    except np.linalg.LinAlgError:
        raise MbcheckError("the mass matrix is not positive definite") from None
    with np.errstate(over="ignore", invalid="ignore"):
        root = 1 / np.sqrt(np.diag(mass))  # to unit inertia, so that metres and radians compare
        m, c, k = (matrix * np.outer(root, root) for matrix in (mass, damping, stiffness))
        sizes = [np.linalg.norm(matrix) for matrix in (m, c, k)]
    if not np.all(np.isfinite(sizes)):
        raise MbcheckError(OVERFLOW)
    free, elastic = rigid_and_elastic(m, c, k, free_share)
    m, c, k = (elastic.T @ matrix @ elastic for matrix in (m, c, k))
    values = [0j] * free.shape[1]
    if len(m):
        values += [value for value in eigenvalues(m, c, k) if value.imag >= 0]
    top = max((abs(value) for value in values), default=0.0)
    return [mode_of(complex(value), ZERO * top) for value in sorted(values, key=abs)]


def eigenvalues(mass: Array, damping: Array, stiffness: Array) -> Any:
    """Return the roots of ``|s^2 M + s C + K|``, without damping those with re or im above 0.

    LAPACK's rounding is that of the stiffest direction, and differs with the order of its sums,
    which is that of its threads. Rayleigh quotients in more digits leave that of M, C and K.
    """
    if not np.any(damping):
        mass, stiffness = (mass + mass.T) / 2, (stiffness + stiffness.T) / 2
        shapes = eigh(stiffness, mass)[1]
        squares = forms(shapes, stiffness, shapes) / forms(shapes, mass, shapes)
        return 1j * np.sqrt(squares.astype(complex)).conj()
    n, inverse = len(mass), np.linalg.inv(mass)
    system = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])
    values, left, right = eig(system, left=True)
    left, right = inverse.T @ left[n:].conj(), right[:n]
    m, c, k = (forms(left, matrix, right) for matrix in (mass, damping, stiffness))
    slope = 2 * values * m + c
    with np.errstate(all="ignore"):  # double ones have no slope
        step = ((values * m + c) * values + k) / slope
    return np.where(np.abs(step) < SMALL * np.abs(values), values - step, values)


def forms(left: Any, matrix: Array, right: Any) -> Any:
    """Return ``y^T A x`` of each pair of columns (n, k), summed up in extended precision."""
    return np.sum(left * (matrix.astype(np.longdouble) @ right), axis=0)


def rigid_and_elastic(
    mass: Array, damping: Array, stiffness: Array, share: float
) -> tuple[Array, Array]:
    """Return the directions (n, r) that neither spring nor damper resists, and all others.

    Parameters
    ----------
    mass, damping, stiffness : array (n, n)
        Of unit inertias.
    share : float
        Of the stiffest direction, by which one resists that counts as free.
    """
    resisting = [matrix / (np.linalg.norm(matrix) or 1.0) for matrix in (stiffness, damping)]
    free = null_space(np.vstack(resisting), rcond=share)
    return free, null_space((mass @ free).T) if free.size else np.eye(len(mass))


def mode_of(value: complex, zero: float) -> Mode:
    """Return the mode of an eigenvalue [1/s]; up to ``zero`` in modulus it is a zero mode."""
    omega = abs(value)
    ratio = -value.real / omega if omega > zero else None
    return Mode(value.real, value.imag, omega, omega / (2 * np.pi), ratio)


def linearise(dynamics: Dynamics, parameters: Any, state: Array) -> tuple[Array, Array, Array]:
    """M, C = -df/dv, K = -df/dq of the undriven system about a state of rest.

    The derivatives are exact to rounding (complex steps).

    Returns
    -------
    M, C, K : array (n, n)
    """
    return linearise_at(dynamics, dynamics.coefficients(parameters), state)[:3]


def linearise_at(
    dynamics: Dynamics, c: Any, state: Array, xp: Any = np
) -> tuple[Array, Array, Array, Array]:
    """Return M, C, K (n, n) of `linearise` and the forces (n,) from coefficients."""
    n = len(dynamics.coordinates)

    def forces(x: Any) -> Any:
        return np.array(np.broadcast_arrays(*dynamics.forces(0j, x[:n], x[n:], c, xp)))

    value, slopes = by_complex_step(forces, np.asarray(state))
    mass = np.array(dynamics.mass_matrix(np.asarray(state)[:n], c, xp), dtype=float)
    return mass, -slopes[:, n:] + 0.0, -slopes[:, :n] + 0.0, value
