"""Stability of the approximate rotations of `hula_hoop`, equations (55)-(62) of the paper."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..scene import Array
from ..solve.rk8 import rk8_steps
from .equations import HulaHoop
from .theory import ApproximateSolution, Nondimensional, nondimensional


def variational_coefficients(
    solution: ApproximateSolution, p: HulaHoop, tau: ArrayLike
) -> tuple[Any, Any, Any, Any, Any]:
    """Periodic coefficients p_1, ..., p_5 of (55), (56), equations (57)-(61).

    The printed (57)-(61) are right, with theta_0 added to theta_b where there is one. The
    printed (55) is not: its first ``p_1 theta~'`` must be ``p_1 theta~''``.

    Parameters
    ----------
    solution : ApproximateSolution
    p : HulaHoop
    tau : array_like
        Nondimensional time; broadcasts against the solution.

    Returns
    -------
    tuple of five arrays of the broadcast shape
    """
    c = nondimensional(p)
    base = solution.motion(tau)
    cos, sin = np.cos(base.theta), np.sin(base.theta)
    return (
        c.epsilon * cos,
        -2 * c.epsilon * base.theta_dot * sin,
        -c.epsilon * (base.theta_dot**2 * cos + base.theta_ddot * sin),
        -base.q_ddot * sin / c.inertia,
        cos / c.inertia,
    )


def monodromy_matrix(solution: ApproximateSolution, p: HulaHoop, as_printed: bool = False) -> Array:
    """Fundamental solution of (55), (56) after one forcing period.

    Dormand and Prince's method of order 8 with fixed steps, the same for all points and as
    many as keep the relative error below 1e-9, whatever the damping and the mass ratio.

    Parameters
    ----------
    solution : ApproximateSolution
    p : HulaHoop
    as_printed : bool
        Take (55) with its misprint ``p_1 theta~'``.

    Returns
    -------
    array, shape (4, 4, ...)
        Of the state (q~, theta~, q~', theta~').
    """
    c = nondimensional(p)
    shape = np.broadcast_shapes(np.shape(solution.q_1), *(np.shape(value) for value in c))
    matrix = np.array(np.broadcast_to(np.eye(4).reshape(4, 4, *[1] * len(shape)), (4, 4, *shape)))
    rate = (1 + 2 * c.rho + c.zeta_m) / (1 - c.epsilon / c.inertia)  # bounds that of (55), (56)
    steps = int(np.ceil(16 + 12 * np.max(rate / c.alpha)))

    def derivative(tau: Any, x: Array) -> Array:
        return perturbation_rate(x, variational_coefficients(solution, p, tau), c, as_printed)

    return np.asarray(rk8_steps(derivative, matrix, 0.0, 2 * np.pi / c.alpha, steps))


def floquet_multipliers(
    solution: ApproximateSolution, p: HulaHoop, as_printed: bool = False
) -> NDArray[np.complex128]:
    """Eigenvalues of the monodromy matrix of (62), largest magnitude first.

    The rotation is stable if all magnitudes are below 1. The paper takes "eigenvalues of the
    transition matrix A(tau)" for them; those of the monodromy matrix are meant.

    Parameters
    ----------
    solution : ApproximateSolution
    p : HulaHoop
    as_printed : bool
        Take (55) with its misprint, see `monodromy_matrix`.

    Returns
    -------
    complex array, shape (4, ...)
        NaN where the solution is NaN.
    """
    matrix = np.moveaxis(monodromy_matrix(solution, p, as_printed), (0, 1), (-2, -1))
    exists = np.asarray(np.isfinite(matrix).all(axis=(-2, -1)))
    multipliers = np.linalg.eigvals(np.where(exists[..., None, None], matrix, 0)).astype(complex)
    multipliers[~exists] = np.nan
    order = np.argsort(-np.abs(multipliers), axis=-1)
    return np.moveaxis(np.take_along_axis(multipliers, order, axis=-1), -1, 0)


def perturbation_rate(
    x: Array, coefficients: tuple[Any, ...], c: Nondimensional, as_printed: bool
) -> Array:
    """Right-hand side of (62) for x = (q~, theta~, q~', theta~')."""
    p_1, p_2, p_3, p_4, p_5 = coefficients
    q, theta, q_dot, theta_dot = x
    slide = -(2 * c.rho * q_dot + q + p_2 * theta_dot + p_3 * theta)
    hinge = -(c.zeta_m / c.inertia * theta_dot + p_4 * theta)
    corrected = (slide - p_1 * hinge) / (1 - p_1 * p_5)
    q_ddot = slide - p_1 * theta_dot if as_printed else corrected
    return np.stack([q_dot, theta_dot, q_ddot, hinge - p_5 * q_ddot])
