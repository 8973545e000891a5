"""What rounding leaves unknown of a trajectory, carried along by its variational equations.

A run in floating point solves a problem that is off by rounding: of the start, of the parameters,
of the rates and of the states that each step stores. To first order what is off grows by the flow
of the linearised equations, ``d' = J(t) d + g(t)`` (Higham, Accuracy and Stability of Numerical
Algorithms, 2nd edition, chapter 1, on forward errors as condition times backward errors). Between
nodes that lie a step of a loose run apart, J and g are those at the midpoint, and the solution is
a matrix exponential.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..differences import EPS, by_complex_step
from ..errors import ParameterError
from ..scene import Array, Dynamics

CHANGE = 2.0**-36
"""Relative change of a parameter by which its influence is measured; rounding of the rates has
the same condition, and is a ten-thousandth of it."""

DEVIATIONS = 5.0
"""Standard deviations of what is random that a bound counts."""

DEGREE = 10
"""Of Taylor's series of a matrix of norm 1/2: it is off by 1e-11."""

HALF_UNIT = EPS / 2
"""Largest relative error of a rounded number."""


def roundoff(
    dynamics: Dynamics, parameters: Any, nodes: Array, states: Array, sizes: Array, steps: int
) -> Array:
    """Return a bound on what rounding makes of a run, at its nodes.

    Parameters
    ----------
    dynamics : Dynamics
    parameters : Parameters of it
    nodes : array (2 k + 1,)
        Times [s]: ends and midpoints of k intervals, in turn.
    states : array (2 n, 2 k + 1)
        The run there.
    sizes : array (2 n,)
        Of the states.
    steps : int
        Of the run.

    Returns
    -------
    bound : array (2 n, k + 1)
        At the ends of the intervals; infinite from where it overflows.
    """
    count = len(nodes) // 2
    ends = states[:, ::2] / sizes[:, None]
    with np.errstate(all="ignore"):
        slopes, changes, noise = influences(dynamics, parameters, nodes[1::2], states[:, 1::2])
        slopes = np.moveaxis(slopes * sizes[:, None] / sizes[:, None, None], -1, 0)
        changes, noise = changes / sizes[:, None, None], noise / sizes[:, None]
        flows, sums = exponentials(slopes, np.diff(nodes[::2]))
    each = max(steps / count, 1.0)
    common = np.hstack([np.diag(ends[:, 0]), np.zeros((len(ends), changes.shape[1]))])
    random = np.zeros((len(ends), len(ends)))
    bound = np.empty((len(ends), count + 1))
    bound[:, 0] = np.abs(ends[:, 0])
    with np.errstate(all="ignore"):
        for i, (flow, total) in enumerate(zip(flows, sums, strict=True)):
            common = flow @ common
            common[:, len(ends) :] += total @ changes[..., i]
            rates = total * noise[:, i]
            stored = np.diag(each * ends[:, i + 1] ** 2)
            random = flow @ random @ flow.T + rates @ rates.T / each + stored
            bound[:, i + 1] = np.sum(np.abs(common), axis=1)
            bound[:, i + 1] += DEVIATIONS * np.sqrt(np.diag(random))
    return np.nan_to_num(HALF_UNIT * bound * sizes[:, None], nan=np.inf, posinf=np.inf)


def exponentials(matrices: Array, lengths: Array) -> tuple[Array, Array]:
    """Return ``exp(A h)`` and its integral from 0 to h, of matrices A (k, m, m) and steps h (k,).

    By Taylor's series of a fraction of h, which is then doubled as often as that needs.
    """
    norms = lengths * np.max(np.sum(np.abs(matrices), axis=2), axis=1)
    doublings = np.ceil(np.log2(np.maximum(np.nan_to_num(norms, posinf=1.0), 0.5))).astype(int) + 1
    one = np.eye(matrices.shape[1])
    scaled = matrices * (lengths * 0.5**doublings)[:, None, None]
    sums = np.broadcast_to(one, scaled.shape)
    for power in range(DEGREE, 1, -1):
        sums = one + scaled @ sums / power
    flows = one + scaled @ sums
    sums = sums * (lengths * 0.5**doublings)[:, None, None]
    for doubled in range(int(np.max(doublings))):
        rows = doublings > doubled
        sums[rows] = (flows[rows] + one) @ sums[rows]
        flows[rows] = flows[rows] @ flows[rows]
    return flows, sums


def influences(
    dynamics: Dynamics, parameters: Any, times: Array, states: Array
) -> tuple[Array, Array, Array]:
    """Return what changes the rates along a run.

    Returns
    -------
    slopes : array (2 n, 2 n, k)
        By the states.
    changes : array (2 n, m, k)
        By the relative change of each of the m parameters that are not 0.
    noise : array (2 n, k)
        Of rounding, relative to that of a number: the sum of what the parameters, the states and
        the time change, each of its own size.
    """
    derivative = dynamics.right_hand_side(parameters)
    _, slopes = by_complex_step(lambda x: derivative(times, x), states)
    c = list(changed(dynamics, parameters))
    many = type(c[0])(*(np.array(values) for values in zip(*c, strict=True)))
    rates = dynamics.derivative(many)(times[:, None], np.repeat(states[..., None], len(c), -1))
    changes = np.moveaxis(rates[..., 1:] - rates[..., :1], -1, 1) / CHANGE
    later = derivative(times * (1 + CHANGE), states) - rates[..., 0]
    noise = np.sum(np.abs(changes), axis=1) + np.abs(later) / CHANGE
    noise += np.sum(np.abs(slopes * states), axis=1)
    n = len(noise) // 2
    noise[:n] = 0.0  # the rate of a coordinate is a state, and copied
    return slopes, changes, noise


def changed(dynamics: Dynamics, parameters: Any) -> Iterator[Any]:
    """Yield the coefficients, and those with each parameter changed that is not 0."""
    yield dynamics.coefficients(parameters)
    for name, value in parameters.as_dict().items():
        if isinstance(value, float) and value:
            for change in (CHANGE, -CHANGE):
                try:
                    yield dynamics.coefficients(parameters.replace(**{name: value * (1 + change)}))
                except ParameterError:
                    continue
                break
