"""Newton's method on many small systems of equations at once."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .cost import keep_budget
from .scene import Array

Rows = NDArray[np.int_]
"""Numbers (k,) of systems."""

Residual = Callable[[Rows, Array], Array]
"""Function of systems (k,) and unknowns (m, k) that returns the residuals (m, k)."""

Linearise = Callable[[Rows, Array], tuple[Array, Array]]
"""The same with the Jacobian (k, m, p); p is larger than m where it has more than is solved for."""

CLOSED = 1e-9
"""Largest last correction, in the unit of each unknown, of a solution that counts as one.

The period maps of engines are rounded to 1e-14 of the states, and to 1e-10 where an implicit method
stops its own iterations: corrections stop shrinking there."""

ROUNDING = 1e-11
"""Correction after which no other is made. Newton's method leaves its square, and a Jacobian by
differences 1e-6 of it: solution and Jacobian are exact to rounding."""


class Effort(NamedTuple):
    """How long solutions are sought.

    Attributes
    ----------
    jacobians : int
        Jacobians at most, including one that was given.
    chords : int
        Further corrections with each of them, as long as they shrink.
    longest : float
        Longer corrections are shortened to this.
    contraction : float
        Corrections, or residuals, that do not shrink by this factor ask for a new Jacobian.
    """

    jacobians: int = 40
    chords: int = 0
    longest: float = 0.1
    contraction: float = 0.5


class Roots(NamedTuple):
    """Result of Newton's method.

    Attributes
    ----------
    unknowns : array (m, k)
    jacobians : array (k, m, p)
        The last of each system.
    size : array (k,)
        Last correction, before it was shortened; infinite where the system was lost.
    closed : bool array (k,)
        Which systems are solved.
    """

    unknowns: Array
    jacobians: Array
    size: Array
    closed: NDArray[np.bool_]


def linearisation(residual: Residual, rule: Callable[..., tuple[Array, Array]]) -> Linearise:
    """Return residual and Jacobian by one of the rules of `differences`.

    The residual must take unknowns (m, lanes, k).
    """

    def linearise(rows: Rows, x: Array) -> tuple[Array, Array]:
        value, slopes = rule(partial(residual, rows), x)
        return value, np.moveaxis(slopes, -1, 0)

    return linearise


def correction(matrix: Array, residual: Array) -> tuple[Array, Array]:
    """Return Newton's corrections (m, k) and their sizes (k,), infinite where there is none.

    By a singular matrix it is the shortest one; what that leaves of the residual is a size as well.

    Parameters
    ----------
    matrix : array (k, m, m)
    residual : array (m, k)
    """
    usable = np.all(np.isfinite(matrix), axis=(1, 2)) & np.all(np.isfinite(residual), axis=0)
    change, beyond = np.zeros_like(residual), np.zeros(len(usable))
    right = residual[:, usable].T[..., None]
    try:
        step = np.linalg.solve(matrix[usable], right)
    except np.linalg.LinAlgError:  # some are singular; the others stay as they are
        step = np.array([shortest(*one) for one in zip(matrix[usable], right, strict=True)])
        beyond[usable] = np.max(np.abs(matrix[usable] @ step - right), axis=(1, 2))
    change[:, usable] = -step[..., 0].T
    size = np.maximum(np.max(np.abs(change), axis=0), beyond)
    return change, np.where(usable, size, np.inf)


def shortest(matrix: Array, right: Array) -> Array:
    """Return the solution (m, 1) of a linear system, the shortest one if the matrix is singular."""
    try:
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.pinv(matrix) @ right)


NEWTON = Effort()


def newton(
    residual: Residual,
    linearise: Linearise,
    start: Array,
    effort: Effort = NEWTON,
    jacobians: Array | None = None,
    columns: Rows | slice = slice(None),
) -> Roots:
    """Solve systems from a start of each; those that are solved, or lost, are left alone.

    Parameters
    ----------
    residual, linearise : callable
    start : array (m, k)
        Unknowns in units in which they are of order one.
    effort : Effort
    jacobians : array (k, m, p), optional
        Jacobians that are known already; they serve first.
    columns : int array (m,), optional
        Columns of the Jacobians that belong to the unknowns.
    """
    x, size = np.array(start, dtype=float), np.full(start.shape[1], np.inf)
    before = size.copy()
    rows, closed = np.arange(len(size)), np.zeros(len(size), dtype=bool)
    with np.errstate(all="ignore"):
        if jacobians is None:
            left, slopes = linearise(rows, x)
        else:
            left, slopes = residual(rows, x), jacobians.copy()
        for number in range(effort.jacobians):
            keep_budget(1.0)
            if number:
                left, slopes[rows] = linearise(rows, x[:, rows])
            going = rows
            for chord in range(effort.chords + 1):
                left = residual(going, x[:, going]) if chord else left
                change, now = correction(slopes[going][..., columns], left)
                x[:, going] += change * np.minimum(1.0, effort.longest / np.maximum(now, CLOSED))
                reach = np.maximum(now, np.max(np.abs(left), axis=0))
                shrinks = reach < effort.contraction * before[going]
                closed[going] = (now < ROUNDING) | ((now < CLOSED) & ~shrinks)
                size[going], before[going] = now, reach
                useful = shrinks if chord else now < effort.longest / 10
                going = going[~closed[going] & np.isfinite(now) & useful]
                if not going.size:
                    break
            rows = rows[~closed[rows] & np.isfinite(size[rows])]
            if not rows.size:
                break
    return Roots(x, slopes, size, closed)
