"""Bounds on the errors of a run: local errors, propagated by the linearised flow.

The local error between two nodes is the difference of the run from a solution with far more steps
that starts where the run is. Rounding of the start, of the parameters, of the rates and of the
states that each step stores adds to it (Higham, Accuracy and Stability of Numerical Algorithms, 2nd
edition, chapter 1: forward errors are condition times backward errors). To first order all that
grows by the linearised equations, ``e' = J(t) e``. Their flow from node to node is a matrix
exponential, by Magnus's series with J at two Gauss points (Iserles, Norsett (1999), Phil. Trans.
R. Soc. A 357, 983-1019).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import matrix_balance

from ..differences import EPS, by_complex_step
from ..errors import ParameterError
from ..scene import Array, Dynamics
from .rk8 import rk8_steps


class BoundOptions(NamedTuple):
    """Contributions to a bound on the error of a run.

    Attributes
    ----------
    change : float
        Relative change of a parameter by which its influence is measured; rounding of the rates has
        the same condition, and is a ten-thousandth of it.
    continuous : float
        Largest share of a change of the rates that half the change of a parameter makes, unless the
        parameter changes what coordinates mean: a mass that leaves the tip does.
    safety : float
        What the growth of local errors to first order is multiplied by.
    deviations : float
        Standard deviations of random errors that a bound covers.
    terms : float
        Weight of a step's change in the sums that make a step and interpolate in it: those of
        DOP853 hold larger terms that cancel.
    gauss_terms : float
        The same of Gauss's methods, whose weights are positive: nothing cancels.
    degree : int
        Of Taylor's series of a matrix of norm 1/2: it is off by 1e-17.
    block : int
        States of a continuum whose equations are evaluated together.
    patterns : int
        Draws of the rounding of a continuum's matrices, whose effects are squared and averaged.
    sums : float
        Standard deviation of an entry of these matrices, a sum, in half units of rounding, where it
        is rounded anew in each state.
    tables : float
        The same of entries that are constant in all states, and of `Dynamics.inexact_numbers`.
    still : float
        Change over a run below which an entry is rounded in the same way in all of it.
    steady : float
        Change of the rates by each state within an interval, relative to what they are sums of,
        below which their rounding is one and the same in all of it: at rest it pushes in one
        direction.
    steps : tuple[int, int]
        Fewest and most steps of the solution within an interval that a run is compared with.
    """

    change: float = 2.0**-36
    continuous: float = 0.75
    safety: float = 2.0
    deviations: float = 5.0
    terms: float = 8.0
    gauss_terms: float = 2.0
    degree: int = 14
    block: int = 32
    patterns: int = 16
    sums: float = 1.25
    tables: float = 1.0
    still: float = 8 * EPS
    steady: float = float(np.sqrt(EPS))
    steps: tuple[int, int] = (8, 256)


OPTIONS = BoundOptions()


GAUSS = 0.5 - np.sqrt(3) / 6, 0.5 + np.sqrt(3) / 6
"""Gauss points of an interval, at which J is evaluated."""


HALF_UNIT = EPS / 2
"""Largest relative error of a rounded number."""


class Samples(NamedTuple):
    """A run at the nodes and the Gauss points of its intervals.

    Attributes
    ----------
    nodes : array (k + 1,)
        Ends [s] of k intervals.
    states : array (2 n, k + 1)
        The run there.
    inside : array (2, 2 n, k)
        The run at the `GAUSS` points of the intervals.
    sizes : array (2 n,)
        Of the states.
    steps : int
        Of the run.
    """

    nodes: Array
    states: Array
    inside: Array
    sizes: Array
    steps: int

    @property
    def lengths(self) -> Array:
        """Lengths of the intervals [s]."""
        return np.diff(self.nodes)


def gauss_points(nodes: Array) -> Array:
    """Return the times (2, k) of the `GAUSS` points of intervals."""
    return nodes[:-1] + np.multiply.outer(GAUSS, np.diff(nodes))


def bounds_of(dynamics: Dynamics, parameters: Any, run: Samples, method: Array | None) -> Array:
    """Return a bound on the error of a run, at its nodes.

    Parameters
    ----------
    dynamics : Dynamics
    parameters : Parameters of it
    run : Samples
    method : array (2 n, k + 1), or None
        A bound on the error of the method; by default it follows from local errors.

    Returns
    -------
    bounds : array (2 n, k + 1)
        On the largest error up to each node; infinite from where it overflows.
    """
    if method is not None and dynamics.continuum.has_waves:
        return method + run.sizes[:, None] * HALF_UNIT * OPTIONS.deviations * np.sqrt(run.steps)
    sizes, lengths = run.sizes[:, None], run.lengths
    n, count = len(sizes), len(lengths)
    ends = run.states / sizes
    each = max(run.steps / count, 1.0)
    local = unsure = np.zeros((n, count))
    with np.errstate(all="ignore"):
        effects = sensitivities(dynamics, parameters, gauss_points(run.nodes)[0], run.inside[0])
        matrices = flow_matrices(dynamics, parameters, run, effects.slopes)
        flows, sums = exponentials(matrices * sizes.T / sizes, lengths)
        changes, tables, noise = (
            part / sizes[..., None]
            for part in (effects.changes, effects.tables, effects.directions)
        )
        moves = np.einsum("kij,jk->ik", np.abs(effects.slopes), np.abs(np.diff(run.states)))
        still = np.all((moves <= OPTIONS.steady * effects.noise)[n // 2 :], axis=0)
        if np.any(still):
            tables = np.concatenate([tables, noise * still], axis=1)
        share = OPTIONS.gauss_terms if dynamics.stiff else OPTIONS.terms
        terms = np.abs(ends[:, 1:]) + share * np.abs(effects.rates / sizes) * lengths / each
        if method is None:
            local, unsure = local_errors(dynamics.right_hand_side(parameters), run)
            local, unsure = local / sizes, unsure / sizes
        error = np.zeros(n)
        common = np.hstack([np.diag(ends[:, 0]), np.zeros((n, changes.shape[1]))])
        fixed = np.zeros((n, tables.shape[1]))
        random = np.zeros((n, n))
        bounds = np.empty((n, count + 1))
        bounds[:, 0] = HALF_UNIT * np.abs(ends[:, 0])
        for i, (flow, total) in enumerate(zip(flows, sums, strict=True)):
            error = flow @ error + local[:, i]
            common = flow @ common
            common[:, n:] += total @ changes[..., i]
            fixed = flow @ fixed + total @ tables[..., i]
            rates = total @ noise[..., i]
            random = flow @ random @ flow.T + rates @ rates.T / each
            random += np.diag(each * terms[:, i] ** 2 + (unsure[:, i] / HALF_UNIT) ** 2)
            rounding = np.sum(np.abs(common), axis=1) + 2 * terms[:, i]
            rounding += OPTIONS.deviations * np.sqrt(np.diag(random) + np.sum(fixed**2, axis=1))
            bounds[:, i + 1] = OPTIONS.safety * np.abs(error) + HALF_UNIT * rounding
        bounds = np.nan_to_num(bounds * sizes, nan=np.inf, posinf=np.inf)
    bounds = np.maximum.accumulate(bounds, axis=1)
    return bounds if method is None else bounds + method


def local_errors(derivative: Callable[[Any, Any], Any], run: Samples) -> tuple[Array, Array]:
    """Return the local errors of a run within each interval, and bounds on their own errors.

    Both have shape (2 n, k). All intervals are solved together by the method of the run's order,
    with more and more steps until only round-off remains.
    """
    starts, ends = run.states[:, :-1], run.states[:, 1:]
    exact = np.empty_like(ends)
    unsure = np.full_like(ends, np.inf)
    pending, steps = np.arange(len(run.lengths)), OPTIONS.steps[0]
    coarse = None
    while pending.size and steps <= OPTIONS.steps[1]:
        times = run.nodes[pending], run.nodes[pending + 1]
        fine = rk8_steps(derivative, starts[:, pending], *times, steps)
        if coarse is not None:
            exact[:, pending], unsure[:, pending] = fine, np.abs(fine - coarse) / 16
            off = np.abs(ends[:, pending] - fine) / 16 + 4 * EPS * np.abs(fine)
            rough = np.any(~(unsure[:, pending] <= off), axis=0)
            pending, fine = pending[rough], fine[:, rough]
        coarse, steps = fine, 2 * steps
    return ends - exact, unsure


def exponentials(matrices: Array, lengths: Array) -> tuple[Array, Array]:
    """Return ``exp(A h)`` and its integral from 0 to h, of matrices A (k, m, m) and steps h (k,).

    By Taylor's series of a fraction of h, which is then doubled as often as that needs, in balanced
    coordinates: fast modes would take many times more doublings, each of which doubles rounding.
    """
    finite = np.nan_to_num(np.max(np.abs(matrices), axis=0), posinf=0.0)
    _, (scale, _) = matrix_balance(finite, permute=False, separate=True)
    matrices = matrices * scale / scale[:, None]
    norms = lengths * np.max(np.sum(np.abs(matrices), axis=2), axis=1)
    doublings = np.ceil(np.log2(np.maximum(np.nan_to_num(norms, posinf=1.0), 0.5))).astype(int) + 1
    one = np.eye(matrices.shape[1])
    fractions = (lengths * 0.5**doublings)[:, None, None]
    scaled = matrices * fractions
    sums = np.broadcast_to(one, scaled.shape)
    for power in range(OPTIONS.degree, 1, -1):
        sums = one + scaled @ sums / power
    flows, sums = one + scaled @ sums, sums * fractions
    for doubled in range(int(np.max(doublings))):
        rows = doublings > doubled
        sums[rows] = (flows[rows] + one) @ sums[rows]
        flows[rows] = flows[rows] @ flows[rows]
    back = scale[:, None] / scale
    return flows * back, sums * back


class Sensitivities(NamedTuple):
    """Derivatives of the rates at some states.

    Attributes
    ----------
    slopes : array (k, 2 n, 2 n)
        By the states.
    rates : array (2 n, k)
    changes : array (2 n, m, k)
        By the relative change of each of the m parameters that are not 0.
    inputs : array (2 n, m + 2 n + 1 + l, k)
        The same of the accelerations, and by the relative change of each state, of the time, and
        of each of the l `Dynamics.inexact_numbers`.
    patterns : array (2 n, p, k)
        By the rounding of a continuum's matrices, all of it, drawn p times and divided by
        the root of their number, anew in each state. Of other mechanisms there are none.
    tables : array (2 n, p or l, k)
        By rounding with one value in all states: of these matrices, or of these numbers.
    """

    slopes: Array
    rates: Array
    changes: Array
    inputs: Array
    patterns: Array
    tables: Array

    @property
    def noise(self) -> Array:
        """Largest effect (2 n, k) of rounding, relative to that of a number."""
        drawn = np.sqrt(OPTIONS.patterns) / OPTIONS.sums * self.patterns
        return np.asarray(np.sum(np.abs(self.inputs), axis=1) + np.sum(np.abs(drawn), axis=1))

    @property
    def directions(self) -> Array:
        """Columns (2 n, m, k) that rounding adds at random.

        A continuum's inverse mass matrix makes most of what shakes its fastest modes, and next to
        nothing of what moves the slow ones: as one column the rounding of an entry keeps to that.
        The few accelerations of other mechanisms are taken to be off each by itself.
        """
        if self.patterns.size:
            return np.concatenate([self.inputs, self.patterns], axis=1)
        return np.asarray(np.eye(len(self.rates))[..., None] * self.noise)


def flow_matrices(dynamics: Dynamics, parameters: Any, run: Samples, first: Array) -> Array:
    """Return the matrices (k, 2 n, 2 n) of the linear flow in each interval of a run.

    From the slopes (k, 2 n, 2 n) at its first points and those at its second ones.
    """
    second = slopes_of(dynamics, parameters, gauss_points(run.nodes)[1], run.inside[1])
    matrices = (first + second) / 2
    if not dynamics.stiff:
        turning = second @ first - first @ second
        matrices += np.sqrt(3) / 12 * run.lengths[:, None, None] * turning
    return matrices


def slopes_of(dynamics: Dynamics, parameters: Any, times: Array, states: Array) -> Array:
    """Return the derivatives (k, 2 n, 2 n) of the rates by states (2 n, k)."""
    derivative = dynamics.right_hand_side(parameters)

    def slopes(times: Array, states: Array) -> Array:
        return by_complex_step(lambda x: derivative(times, x), states)[1]

    return np.moveaxis(in_blocks(slopes, dynamics, times, states), -1, 0)


def in_blocks(
    function: Callable[[Array, Array], Array], dynamics: Dynamics, times: Array, states: Array
) -> Array:
    """Return a function (..., k) of times (k,) and states (2 n, k), of a continuum in blocks.

    The arrays within its equations are a thousand times as large as its states.
    """
    block = OPTIONS.block if dynamics.discretisation_coordinates else len(times)
    parts = [np.s_[i : i + block] for i in range(0, len(times), block)]
    return np.concatenate([function(times[part], states[:, part]) for part in parts], axis=-1)


def sensitivities(
    dynamics: Dynamics, parameters: Any, times: Array, states: Array
) -> Sensitivities:
    """Return the derivatives of the rates at times (k,) and states (2 n, k)."""
    derivative = dynamics.right_hand_side(parameters)
    slopes = slopes_of(dynamics, parameters, times, states)
    c = list(changed(dynamics, parameters, OPTIONS.change))
    last = len(c)
    c += dynamics.inexact_numbers(c[0], OPTIONS.change)
    rates, off = changes_of_rates(dynamics, c, times, states)
    moved, numbers = off[:, : last - 1], off[:, last - 1 :] / OPTIONS.change
    products = [
        changes_of_rates(replace(dynamics, accelerations=one), c[:1], times, states)[0] - rates
        for one in dynamics.inexact_accelerations(OPTIONS.change)
    ]
    size = np.max(np.abs(moved), axis=(0, -1))
    if np.any(size >= np.max(np.abs(rates))):  # what changes coordinates does not halve
        c = list(changed(dynamics, parameters, OPTIONS.change / 2))
        halved = changes_of_rates(dynamics, c, times, states)[1]
        moved = moved[:, np.max(np.abs(halved), axis=(0, -1)) <= OPTIONS.continuous * size]
    changes = moved / OPTIONS.change
    later = derivative(times * (1 + OPTIONS.change), states) - rates
    inputs = np.concatenate(
        [changes, np.moveaxis(slopes, 0, -1) * states, later[:, None] / OPTIONS.change, numbers]
        + [one[:, None] / OPTIONS.change for one in products],
        axis=1,
    )
    inputs[: len(inputs) // 2] = 0.0  # the rate of a coordinate is a state, and copied
    patterns, tables = inputs[:, :0], OPTIONS.tables * numbers
    if dynamics.discretisation_coordinates or dynamics.eliminates:
        patterns, tables = inexact_matrices(dynamics, c[0], states, rates, slopes)
    return Sensitivities(slopes, rates, changes, inputs, patterns, tables)


def changes_of_rates(
    dynamics: Dynamics, c: Sequence[Any], times: Array, states: Array
) -> tuple[Array, Array]:
    """Return the rates (2 n, k) by the first coefficients, and what others change (2 n, m, k)."""
    derivative = dynamics.derivative(type(c[0])(*map(np.array, zip(*c, strict=True))))

    def all_rates(times: Array, states: Array) -> Array:
        rates = derivative(times[:, None], np.repeat(states[..., None], len(c), -1))
        return np.moveaxis(rates, -1, 1)

    rates = in_blocks(all_rates, dynamics, times, states)
    return rates[:, 0], rates[:, 1:] - rates[:, :1]


def inexact_matrices(
    dynamics: Dynamics, c: Any, states: Array, rates: Array, slopes: Array
) -> tuple[Array, Array]:
    """Return the changes of rates by the rounding of entries of mass and stiffness matrices.

    A continuum's are sums, each rounded on its own, and solving with the mass matrix changes each
    by its rounding as well (Higham, section 9.3). Beside a heavy mass it is a large share of the
    inertia of light coordinates. The same is true of bodies whose mass matrix is eliminated.

    Parameters
    ----------
    states, rates : array (2 n, k)
    slopes : array (k, 2 n, 2 n)
        Of the rates.

    Returns
    -------
    patterns, tables : array (2 n, p, k)
        See `Sensitivities`; of either sign, drawn for each entry.
    """
    n, elastic = len(states) // 2, bool(dynamics.discretisation_coordinates)
    entries = dynamics.mass_matrix(states[:n], c)  # those that all points share are numbers
    rows = [[np.broadcast_to(one, states.shape[1:]) for one in row] for row in entries]
    mass = np.moveaxis(np.array(rows, dtype=float), -1, 0)
    signs = np.triu(np.random.default_rng(n).choice([-1.0, 1.0], (2, OPTIONS.patterns, n, n)))
    signs += np.triu(signs, 1).swapaxes(-1, -2)  # as M and K, which are symmetric to the last bit
    fresh = fixed = np.zeros((len(mass), n, OPTIONS.patterns))
    for sign, matrix, vector in (
        (signs[0], mass, rates[n:]),
        *([(signs[1], mass @ slopes[:, n:, :n], states[:n])] if elastic else []),
    ):
        size = size_of_entries(matrix)
        still = np.max(np.abs(matrix - matrix[0]), axis=0) <= OPTIONS.still * np.max(size, axis=0)
        fresh = fresh + np.einsum("pij,kij,jk->kip", sign, OPTIONS.sums * size, vector)
        same = np.where(still, OPTIONS.sums, OPTIONS.tables) * size
        fixed = fixed + np.einsum("pij,kij,jk->kip", sign, same, vector)
    moved = np.linalg.solve(mass, np.concatenate([fresh, fixed], axis=2)) / np.sqrt(
        OPTIONS.patterns
    )
    moved = np.moveaxis(np.concatenate([np.zeros_like(moved), moved], axis=1), 0, -1)
    return moved[:, : OPTIONS.patterns], moved[:, OPTIONS.patterns :]


def size_of_entries(matrices: Array) -> Array:
    """Return the size of what entries of symmetric matrices (k, n, n) are sums of.

    By Cauchy and Schwarz: an entry off the diagonal may be far less than its terms.
    """
    root = np.sqrt(np.abs(np.diagonal(matrices, axis1=1, axis2=2)))
    return np.asarray(root[:, :, None] * root[:, None, :])


def changed(dynamics: Dynamics, parameters: Any, change: float) -> Iterator[Any]:
    """Yield the coefficients, and those with each nonzero parameter changed."""
    yield dynamics.coefficients(parameters)
    for name, value in parameters.as_dict().items():
        if isinstance(value, float) and value:
            for share in (change, -change):
                try:
                    yield dynamics.coefficients(parameters.replace(**{name: value * (1 + share)}))
                except ParameterError:
                    continue
                break
