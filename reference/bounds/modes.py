"""Modes of ``M a + C v + K q = 0`` to all digits that M, C and K have, with bounds on their errors.

The bounds are those that rounding of each entry of M, C and K leads to (Higham, Tisseur (2002),
Linear Algebra Appl. 351, 455-474), not of the largest: a slow mode beside a fast one keeps its
digits. They are found from factors of K and M that are graded as the modes are, by Jacobi rotations
(Drmac, Veselic (2008), SIAM J. Matrix Anal. 29, 1322-1342), then each by Newton's method.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigvals, matrix_balance, solve_triangular
from scipy.linalg.lapack import dgejsv

from ..differences import EPS
from ..errors import MbcheckError
from ..linear import OVERFLOW, Mode, linearise_at, mode_of
from ..scene import Array, Dynamics


class ModeOptions(NamedTuple):
    """Granted round-off, and the correction of eigenvalues.

    Attributes
    ----------
    coefficient : float
        Relative error of a coefficient of the equations of motion, and of the values of functions
        in them.
    entry : float
        Relative error of an entry of a matrix, and again of its products.
    step : float
        Relative step of the differences by which the matrices' sensitivities are found.
    singular : float
        Relative change of an eigenvalue by rounding of M beyond which it may as well be infinite.
    near : float
        Relative distance of approximate eigenvalues that are not meant to be one.
    far : float
        Ratio of eigenvalues beyond which one decomposition does not tell all of them.
    tolerance : float
        Largest last correction of an eigenvalue, relative to it; nearly double ones keep half their
        digits.
    max_iterations : int
        Corrections of an eigenvalue; two serve where it is simple.
    """

    coefficient: float = 1.5 * EPS
    entry: float = 1.5 * EPS
    step: float = 1e-4
    singular: float = 1 / 8
    near: float = 0.1
    far: float = 1e10
    tolerance: float = 1e-5
    max_iterations: int = 8


OPTIONS = ModeOptions()


INDEFINITE = "the mass matrix is not positive definite"


@dataclass(frozen=True)
class OneFunctionOff:
    """NumPy with one of its functions off by a factor."""

    name: str
    factor: float

    def __getattr__(self, name: str) -> Any:
        """Return a function of NumPy."""
        function = getattr(np, name)
        return (lambda x: self.factor * function(x)) if name == self.name else function


class Entries(NamedTuple):
    """Matrices (n, n) of ``M a + C v + K q = 0``, or bounds on the errors of their entries."""

    mass: Array
    damping: Array
    stiffness: Array

    def at(self, rows: Any) -> Entries:
        """Return the matrices of some coordinates."""
        return Entries(*(matrix[np.ix_(rows, rows)] for matrix in self))

    def scaled(self, unit: Array) -> Entries:
        """Return the matrices of coordinates that are measured in units (n,)."""
        return Entries(*(matrix * unit[:, None] * unit for matrix in self))

    def pencil(self, value: Any) -> Any:
        """Return ``(s^2 M + s C + K) / |s|^2`` at s."""
        size = abs(value)
        unit = value / size
        return unit**2 * self.mass + unit * (self.damping / size) + self.stiffness / size / size

    def slope(self, value: Any) -> Any:
        """Return ``(2 s M + C) / |s|`` at s."""
        return 2 * (value / abs(value)) * self.mass + self.damping / abs(value)


def linearisation_error(dynamics: Dynamics, parameters: Any, state: Array) -> Entries:
    """Bounds on the errors of M, C and K: what rounding of coefficients, state and entries leaves.

    Where the state of rest balances forces, it is off by their error over the stiffness; bounds are
    infinite where that error is no small part of the distance to where the state vanishes.
    """
    state, n = np.asarray(state), len(dynamics.coordinates)
    c = dynamics.coefficients(parameters)
    *exact, forces = linearise_at(dynamics, c, state)
    errors, load = Entries(*(OPTIONS.entry * np.abs(matrix) for matrix in exact)), np.abs(forces)

    def add(upper: Any, lower: Any, share: float) -> None:
        for error, high, low in zip(errors, upper, lower, strict=True):
            error += share * np.abs(high - low)

    factors = 1 + OPTIONS.step, 1 - OPTIONS.step
    places: list[Any] = [
        [(c._replace(**{name: value * factor}), state) for factor in factors]
        for name, value in zip(c._fields, c, strict=True)
        if np.any(value)
    ]
    for name in ("sin", "cos", "sqrt"):
        places.append([(c, state, OneFunctionOff(name, factor)) for factor in factors])
    for pair in places:
        upper, lower = (linearise_at(dynamics, *place) for place in pair)
        add(upper[:3], lower[:3], OPTIONS.coefficient / (2 * OPTIONS.step))
        load += OPTIONS.coefficient / (2 * OPTIONS.step) * np.abs(upper[3] - lower[3])
    place = EPS * np.abs(state)
    if np.any(load):
        place[:n] += np.abs(np.linalg.pinv(exact[2])) @ load
    for i in np.flatnonzero(place):
        step = max(place[i], OPTIONS.step * max(abs(state[i]), 1.0)) * np.eye(2 * n)[i]
        upper, lower = (linearise_at(dynamics, c, state + side * step) for side in (1, -1))
        add(upper[:3], lower[:3], place[i] / step[i])  # twice the slope: that changes on the way
        bend = place[i] / (2 * step[i]) * np.abs(upper[2] - lower[2])
        if np.any(load) and np.any(bend > np.abs(exact[2]) / 4 + errors[2]):
            errors = Entries(*(np.full_like(error, np.inf) for error in errors))
    return errors


def bounded_modes(matrices: Entries, errors: Entries, steady: Sequence[int] = ()) -> list[Mode]:
    """Return the modes of `linear.modes` with bounds on their errors.

    A coordinate that no spring holds has a zero mode, exactly.

    Parameters
    ----------
    matrices, errors : Linear
        M symmetric; bounds on the errors of the entries.
    steady : sequence of int
        Coordinates that keep their speed; each counts as a zero mode.

    Raises
    ------
    MbcheckError
        If a matrix is not finite, the mass matrix is not positive definite, or numbers overflow.
    """
    rows = np.delete(np.arange(len(matrices.mass)), steady)
    matrices, errors = matrices.at(rows), errors.at(rows)
    if not np.all(np.isfinite(matrices)):
        raise MbcheckError("the linearised model is not finite")
    if np.any(np.diag(matrices.mass) <= 0):
        raise MbcheckError(INDEFINITE)
    sprung, damped = (
        np.any(matrix, axis=0) | np.any(matrix, axis=1)
        for matrix in (matrices.stiffness, matrices.damping)
    )
    with np.errstate(all="ignore"):
        # to inertias near 1, by powers of two, which round nothing
        unit = np.exp2(-np.round(np.log2(np.diag(matrices.mass)) / 2))
        matrices, errors = matrices.scaled(unit), errors.scaled(unit)
        starts = approximate_eigenvalues(matrices, sprung, sprung | damped)
        before = pair_separations(starts)
        pairs = [
            refined(matrices, errors, complex(start), reach)
            for start, reach in zip(starts, before / 2, strict=True)
        ]
        values, first_order = np.array(pairs).reshape(-1, 2).T
        if not np.all(np.isfinite(values)):
            raise MbcheckError(OVERFLOW)
        after = pair_separations(values)
        bounds = pair_bounds(after, first_order.real)
        if np.any(
            (before > OPTIONS.near * np.abs(starts)) & (after < OPTIONS.near**2 * np.abs(starts))
        ):
            raise MbcheckError(OVERFLOW)  # two starts led to one eigenvalue
        bounds += np.where(after < before / 2, np.abs(values - starts), 0.0)
    rigid = [Mode(0.0, 0.0, 0.0, 0.0, None, 0.0)] * (len(steady) + int(np.sum(~sprung)))
    others = [with_bound(complex(v), float(b)) for v, b in zip(values, bounds, strict=True)]
    return rigid + sorted(others, key=lambda mode: mode.omega)


def approximate_eigenvalues(matrices: Entries, sprung: Any, resisted: Any) -> Any:
    """Return the eigenvalues (k,) with im >= 0 that are not zero, graded as the modes are.

    Parameters
    ----------
    matrices : Linear
        Of inertias near 1.
    sprung, resisted : bool array (n,)
        Coordinates that springs hold, and that springs or dampers do.

    Raises
    ------
    MbcheckError
        If the mass matrix is not positive definite, or numbers overflow.
    """
    order = np.argsort(np.where(resisted, np.abs(np.diag(matrices.stiffness)), -1), kind="stable")
    free = int(np.sum(~resisted))
    mass, damping, stiffness = matrices.at(order)
    if not np.all(np.isfinite(matrices)):
        raise MbcheckError(OVERFLOW)
    try:
        lower = np.linalg.cholesky(mass)[free:, free:]
    except np.linalg.LinAlgError:
        raise MbcheckError(INDEFINITE) from None

    def over_inertia(matrix: Array) -> Array:
        """Return forces per inertia, in speeds whose kinetic energy is a sum of squares."""
        return np.asarray(solve_triangular(lower, matrix, lower=True, check_finite=False))

    stiffness, springs = stiffness[free:, free:], np.flatnonzero(sprung[order][free:])
    loss = over_inertia(over_inertia(damping[free:, free:]).T).T
    factor = spring_factor(stiffness[np.ix_(springs, springs)])
    if factor is None:
        pull = over_inertia(stiffness[:, springs])
        push = over_inertia(np.eye(len(lower))[:, springs]).T
    else:  # the springs' states in units in which their energy is a sum of squares, too
        omega, shapes = graded_svd(over_inertia(np.eye(len(lower))[:, springs] @ factor))
        if not np.any(loss):
            return 1j * omega
        loss = shapes.T @ loss @ shapes
        push = np.eye(len(omega), len(loss)) * omega[:, None]
        pull = push.T
    together = np.argsort([*2 * np.arange(len(push)), *2 * np.arange(len(loss)) + 1])
    system = np.block([[np.zeros((len(push), len(push))), push], [-pull, -loss]])
    spectrum = graded_eigenvalues(system[np.ix_(together, together)])
    return spectrum[spectrum.imag >= 0]


def graded_eigenvalues(matrix: Array) -> Any:
    """Return eigenvalues; where they spread far, the small ones are those of the inverse."""
    fastest = np.max(np.abs(matrix), initial=0.0) or 1.0
    if not np.all(np.isfinite(matrix / fastest)):
        raise MbcheckError(OVERFLOW)
    matrix, _ = matrix_balance(matrix / fastest)
    spectrum = eigvals(matrix)
    try:
        inverse = np.linalg.inv(matrix)
        spread = np.max(np.abs(inverse), initial=0.0)
        inverses = eigvals(inverse) if spread > OPTIONS.far else spectrum[:0]
    except (np.linalg.LinAlgError, ValueError):  # not finite
        return fastest * spectrum
    large = spectrum[np.abs(spectrum) >= 1 / np.sqrt(spread)]
    small = inverses[np.abs(inverses) > np.sqrt(spread)]
    if len(large) + len(small) == len(spectrum):
        spectrum = np.concatenate([large, 1 / small])
    return fastest * spectrum


def spring_factor(stiffness: Array) -> Array | None:
    """Return B of ``K = B B^T``; None where K is not symmetric and positive definite."""
    root = np.sqrt(np.diag(stiffness))
    unit = stiffness / root[:, None] / root
    if not np.all(np.abs(unit - unit.T) < 1e-12):  # NaN where an entry is not positive
        return None
    try:
        return np.asarray(root[:, None] * np.linalg.cholesky(unit))
    except np.linalg.LinAlgError:
        return None


def graded_svd(matrix: Array) -> tuple[Array, Array]:
    """Return singular values, each to its own digits, and all left singular vectors."""
    if not np.all(np.isfinite(matrix)):
        raise MbcheckError(OVERFLOW)
    if not matrix.size:
        return np.zeros(0), np.eye(len(matrix))
    values, left, _, scales, *_ = dgejsv(matrix, joba=2, jobu=1, jobv=3)
    return values * (scales[0] / scales[1]), left


def refined(
    matrices: Entries, errors: Entries, start: complex, reach: float
) -> tuple[complex, float]:
    """Return an eigenvalue by Newton's method, and to first order a bound on its error.

    It stays within reach of its start; the bound is infinite where it cannot come to rest there.
    """
    magnitudes, last, value = Entries(*map(np.abs, matrices)), np.inf, start
    for _ in range(OPTIONS.max_iterations):
        if not value:
            return complex(np.nan), np.inf
        size = magnitudes.pencil(abs(value))
        balance = np.outer(*2 * [1 / np.sqrt(np.diag(size))])
        pencil = matrices.pencil(value) * balance
        if not np.all(np.isfinite(pencil)):
            return complex(np.nan), np.inf
        left, _, right = np.linalg.svd(pencil)
        y, x = left[:, -1].conj(), right[-1].conj()
        slope, bend = (
            y @ (matrix * balance) @ x for matrix in (matrices.slope(value), matrices.mass)
        )
        weights = np.outer(np.abs(y), np.abs(x)) * balance
        if np.sum(
            weights * (errors.mass + OPTIONS.entry * magnitudes.mass)
        ) > OPTIONS.singular * abs(bend):
            return value, np.inf
        rounding = np.sum(weights * (errors.pencil(abs(value)) + OPTIONS.entry * size))
        rest = y @ pencil @ x
        step = abs(value) * rest / slope
        if not abs(step) < last / 2 or abs(value - step - start) > reach:
            break
        value, last = value - step, abs(step)
        if last <= EPS * abs(value):
            break
    last = min(last, abs(step))
    if last < OPTIONS.tolerance * abs(value):
        return value, float(abs(value) * rounding / abs(slope) + last)
    # two that meet: how far off both roots of a parabola may be
    root = np.sqrt(abs(slope) ** 2 + 4 * abs(bend) * (rounding + abs(rest)))
    bound = abs(value) * (abs(slope) + root) / (2 * abs(bend))
    return value, float(bound) if bound < abs(value) else np.inf


def separations(values: Any, others: Any = ()) -> Array:
    """Return the distance of each complex number (k,) from the nearest of the rest and others."""
    apart = np.abs(values[:, None] - np.concatenate([values, others]))
    np.fill_diagonal(apart, np.inf)
    return np.asarray(np.min(apart, axis=1, initial=np.inf))


def pair_separations(values: Any) -> Array:
    """Return the distance of each eigenvalue (k,) with im >= 0 from the nearest other one."""
    return separations(values, np.conj(values[np.imag(values) > 0]))


def pair_bounds(gap: Array, first_order: Array) -> Array:
    """Return bounds on the errors of eigenvalues from those to first order.

    Two eigenvalues at the distance gap move as the roots of ``z (z + gap) = first_order gap``.
    """
    share = 4 * first_order / gap
    apart = 2 * first_order / (1 + np.sqrt(np.maximum(1 - share, 0.0)))
    close = gap / 2 + np.sqrt(gap**2 / 4 + first_order * gap)
    return np.where(share < 1, apart, np.maximum(2 * first_order, close))


def with_bound(value: complex, bound: float) -> Mode:
    """Return the mode of an eigenvalue with a bound [1/s] on its error, None if it is infinite."""
    mode = mode_of(value, bound if np.isfinite(bound) else 0.0)
    if not np.isfinite(bound):
        return mode
    if mode.damping_ratio is None:
        return replace(mode, error_bound=bound)
    sine = bound / mode.omega  # of the angle in the complex plane
    change = abs(value.imag) / mode.omega * sine
    change += abs(mode.damping_ratio) * (1 - np.sqrt(1 - sine**2))
    return replace(mode, error_bound=bound, damping_ratio_bound=float(change) + 2 * EPS)
