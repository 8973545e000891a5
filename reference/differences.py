"""Derivatives of functions that are only computed: by differences, and by complex steps.

A central difference of even order p needs p/2 points on either side of a place; the weights are
those of Fornberg (1988), Math. Comp. 51, 699-706, in closed form. A forward difference has order 1.
A complex step (Squire, Trapp (1998), SIAM Rev. 40, 110-112) subtracts nothing: its derivative is
exact to rounding, but the function must take complex numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from scipy.special import binom

from .scene import Array

EPS = float(np.finfo(float).eps)

PROBE = 1e-40
"""Size of a complex step: so far below rounding that the real part is the function's value."""


class Stencil(NamedTuple):
    """Places and weights (p,) of a difference: f'(0) is the sum of ``weight f(place h) / h``."""

    places: Array
    weights: Array


@cache
def stencil(order: int) -> Stencil:
    """Return the central difference of an even order, or the forward difference of order 1.

    Places that lie opposite each other stand side by side, so that values that are equal there
    cancel without rounding.
    """
    if order == 1:
        return Stencil(np.array([1.0, 0.0]), np.array([1.0, -1.0]))
    half = order // 2
    j = np.repeat(np.arange(1, half + 1), 2) * np.tile([1.0, -1.0], half)
    shares = binom(2 * half, half + j) / binom(2 * half, half)
    return Stencil(j, -((-1.0) ** j) * shares / j)


def balanced_step(order: int, rounding: float = EPS, roughness: float = 1.0) -> float:
    """Return the step at which truncation and rounding of a difference are equally large.

    Rounding of the values is divided by the step; truncation is the step to the power of the order.

    Parameters
    ----------
    order : int
    rounding : float
        Relative error of the function's values.
    roughness : float
        Size of the derivative in the truncation error, relative to the values.
    """
    return float((rounding / roughness) ** (1 / (order + 1)))


def derivative(function: Callable[[float], Any], order: int = 4, step: float | None = None) -> Any:
    """Return the derivative at 0 of a function of one number; its values may be arrays."""
    step = balanced_step(order) if step is None else step
    terms = zip(*stencil(order), strict=True)
    return sum(weight / step * function(float(place) * step) for place, weight in terms)


def by_differences(
    function: Callable[[Array], Array], x: Array, order: int = 4, step: float | None = None
) -> tuple[Array, Array]:
    """Return the value of a function and its Jacobian, by one call at all places of a difference.

    Parameters
    ----------
    function : callable ``(n, lanes, ...) -> (m, lanes, ...)``
    x : array (n, ...)
        Unknowns in units in which they are of order one.
    order : int
        Of the `stencil`.
    step : float, optional
        By default the `balanced_step` of values that are exact to rounding.

    Returns
    -------
    value : array (m, ...)
    jacobian : array (m, n, ...)
        Entry [i, j] is d value_i / d x_j.
    """
    n = len(x)
    step = balanced_step(order) if step is None else step
    places, weights = stencil(order)
    moved = [step * place * np.eye(n) for place in places if place]
    lanes = np.concatenate([np.zeros((n, 1)), *moved], axis=1)
    values = function(x[:, None] + lanes.reshape(*lanes.shape, *(1,) * (x.ndim - 1)))
    value, ends = values[:, 0], values[:, 1:]
    ends = ends.reshape(len(ends), len(moved), n, *x.shape[1:])
    pairs = zip(weights[places != 0], np.moveaxis(ends, 1, 0), strict=True)
    change = sum(weight * end for weight, end in pairs)
    return value, (change + np.sum(weights[places == 0]) * value[:, None]) / step


def probed(x: Array) -> Any:
    """Return copies (n, n, ...) of unknowns (n, ...), the j-th with a complex step in x_j."""
    lanes = np.repeat(np.asarray(x, dtype=complex)[:, None], len(x), axis=1)
    lanes[np.arange(len(x)), np.arange(len(x))] += 1j * PROBE
    return lanes


def by_complex_step(function: Callable[[Any], Any], x: Array) -> tuple[Array, Array]:
    """Return the value of an analytic function and its Jacobian, exact to rounding.

    Parameters and results are those of `by_differences`.
    """
    values = np.asarray(function(probed(x)))
    return values.real[:, 0], values.imag / PROBE


def along(function: Callable[[Any], Any], x: Array, direction: Array) -> Array:
    """Return the derivative of an analytic function in a direction, exact to rounding."""
    return np.asarray(np.imag(function(x + 1j * PROBE * direction)) / PROBE)


def one_by_one(function: Callable[[Array], Array]) -> Callable[[Array], Array]:
    """Return a function of many places (n, k) from one of a single place (n,)."""
    return lambda places: np.column_stack([function(x) for x in places.T])
