"""Bounds on the numbers of maps, from a second run in more steps and from what rounding does.

A method of order 8 errs by 1/255 with half the step: the first run errs by little more than the two
differ by. `SAFETY` times the difference holds as long as the second run
is at least twice as good as the first. What both have in common, rounding, is added: of the states,
of the coefficients and of the steps, as far as the period map and its inverse make it grow.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...reference.differences import EPS
from ...reference.scene import Array
from .quantity import Variable

SAFETY = 2.0
"""Bound over difference."""

ROUNDING = 6 * EPS
"""Round-off of the end of a period, relative to the sizes of the states."""


UNITS, CHANGE = 2.0, 1e-7
"""Round-off of each parameter of a closed form, in units, and the relative change by which its
effect is measured."""


def with_bounds(variables: Mapping[str, Variable], *names: str) -> dict[str, Variable]:
    """Return variables of a map, and the bound of each of some of them behind them."""
    bounds = {
        f"{name}_bound": replace(
            variables[name], meaning=f"bound on the error of {name}; of the reference alone"
        )
        for name in names
    }
    return {**variables, **bounds}


def difference(first: Array, second: Array | float) -> Array:
    """Return a bound on the error of what a second run gives again, NaN where it does not."""
    return SAFETY * np.abs(first - second) + EPS * np.abs(first)


def rounding_displacement(monodromy: Array, closing: Array) -> Array:
    """Return by what rounding displaces periodic orbits (n, k) at most, in the sizes of the states.

    Parameters
    ----------
    monodromy : array (k, n, n)
        Slopes of the period maps.
    closing : array (k, n, n)
        What Newton's method inverts.
    """
    sources = ROUNDING * (1 + np.sum(np.abs(monodromy), axis=2))
    inverse = inverted(closing)
    worst = np.argmax(np.einsum("kij,kj->ki", np.abs(inverse), sources), axis=1)
    signs = np.sign(inverse[np.arange(len(inverse)), worst])
    return np.einsum("kij,kj->ik", inverse, signs * sources)


def inverted(matrices: Array) -> Array:
    """Return the inverses (k, n, n); infinite where there is none."""
    usable = np.all(np.isfinite(matrices), axis=(1, 2))
    inverses = np.full(matrices.shape, np.inf, dtype=matrices.dtype)
    usable[usable] = np.linalg.cond(matrices[usable]) < 1 / EPS
    inverses[usable] = np.linalg.inv(matrices[usable])
    return inverses


def eigenvalue_bounds(matrices: Array, error: Array) -> Array:
    """Return bounds (k,) on what errors (k,) of the norm of matrices (k, n, n) do to eigenvalues.

    The smaller of those of Bauer and Fike, by the condition of the eigenvectors, and of Elsner,
    which needs none.
    """
    n = matrices.shape[1]
    vectors = np.linalg.eig(matrices)[1]
    condition = np.linalg.cond(vectors)
    size = np.linalg.norm(matrices, 2, axis=(1, 2))
    elsner = (2 * size + error) ** (1 - 1 / n) * error ** (1 / n)
    return np.minimum(condition * error, elsner)


def leading_change(matrices: Array, changes: Array) -> Array:
    """Return the largest changes of leading eigenvalues (k,) by changes (k, n, n) of matrices.

    To first order, the changes of the entries added up as they are largest.
    """
    values, right = np.linalg.eig(matrices)
    left = inverted(right)
    each, leading = np.arange(len(matrices)), np.argmax(np.abs(values), axis=1)
    rows, columns = np.abs(left[each, leading]), np.abs(right[each, :, leading])
    return np.einsum("ki,kij,kj->k", rows, np.abs(changes), columns)


def last_harmonics(spectra: Array) -> tuple[Array, Array]:
    """Return the size (k,) of the last harmonics of spectra (k, n), and how they fall off.

    The latter is the ratio of one harmonic to the one before, by which those beyond go on.
    """
    count = spectra.shape[1] // 8
    last, before = (
        np.max(spectra[:, part], axis=1) for part in (np.s_[-count:], np.s_[-2 * count : -count])
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(before > 0, last / before, 0.0) ** (1 / count)
    return last, np.minimum(ratio, 0.99)


def conditions(
    measure: Callable[[Any], Sequence[Any]], parameters: Any, angles: bool = False
) -> list[Array]:
    """Return bounds on what rounding does to closed forms of parameters.

    Each parameter counts with `UNITS` of rounding, and so does the result. Of angles [rad] a
    change is taken on the circle.
    """
    with np.errstate(all="ignore"):
        values = [np.asarray(value) for value in measure(parameters)]
        bounds = [UNITS * EPS * np.abs(value) for value in values]
        for name, value in parameters.as_dict().items():
            if isinstance(value, str):
                continue
            beside = measure(parameters.replace(**{name: value * (1 + CHANGE)}))
            for i, other in enumerate(beside):
                change = np.abs(other - values[i])
                change = np.minimum(change, np.abs(2 * np.pi - change)) if angles else change
                bounds[i] = bounds[i] + UNITS * EPS / CHANGE * change
    return bounds
