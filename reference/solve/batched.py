"""Many trajectories at once, each with a stated error bound."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853

from ..differences import EPS, by_complex_step
from ..scene import Array, Dynamics, coefficients_at
from .rk8 import equal_steps, rk8_samples
from .single import solve
from .solution import (
    RELATIVE_PERTURBATION,
    Solution,
    floor_relative_to_largest,
    initial_states,
    run_sizes,
    sample_times,
    state_size,
)


class BatchOptions(NamedTuple):
    """How many equal steps many trajectories are given.

    Attributes
    ----------
    first_steps : int
        Steps that a search for enough of them begins with.
    halving : float
        What the change from a coarser run is divided by to bound the finer run's error; order 8
        predicts 255 for half the steps, and 25 for two thirds.
    growth : tuple[float, float]
        By what numbers of steps grow in the search, at least, and at most where changes are below
        `asymptotic`; else they are doubled.
    asymptotic : float
        Relative change below which the order is trusted to foretell the next.
    margin : float
        What foretold steps are multiplied by.
    max_steps : int
        With which the search ends: chaos, instability.
    point_growth : tuple[float, float]
        Least and largest growth of the number of steps of a point that misses its tolerance.
    settled : float
        A change below this share of the range that stops falling is rounding, not the method.
    block : int
        Most points solved together in `solve_many`; about what the cache holds.
    inexact : float
        Relative change of coefficients by which their rounding is judged: several units, since
        those of some may cancel those of others.
    calls : int
        Points whose arithmetic takes as long as NumPy's calls do, whatever their number.
    """

    first_steps: int = 8
    halving: float = 4.0
    growth: tuple[float, float] = (1.5, 4.0)
    asymptotic: float = 1e-3
    margin: float = 1.1
    max_steps: int = 1 << 13
    point_growth: tuple[float, float] = (1.25, 8.0)
    settled: float = 1e-3
    block: int = 2048
    inexact: float = 4 * EPS
    calls: int = 500


OPTIONS = BatchOptions()


Advance = Callable[[int], tuple[Array, Array]]
"""Function of a number of steps: the flow (2 n, ...) and its Jacobian (2 n, 2 n, ...)."""


def _advance(dynamics: Dynamics, parameters: Any, state: Array, start: Any, end: Any) -> Advance:
    derivative, span = dynamics.right_hand_side(parameters), np.asarray(end) - start

    def advance(steps: int) -> tuple[Array, Array]:
        with np.errstate(all="ignore"):
            return by_complex_step(
                lambda x: equal_steps(derivative, x, start, span / steps, steps), state
            )

    return advance


def converged_steps(
    dynamics: Dynamics,
    parameters: Any,
    state: Array,
    end: Any,
    start_time: float = 0.0,
    tolerance: float = 1e-12,
) -> int:
    """Steps two thirds of which, or fewer, leave the flow and its Jacobian unchanged.

    ``tolerance`` is relative to the size of the flow and ten times that to the largest
    entry of the Jacobian; where it is never met, `OPTIONS.max_steps` are returned.
    """
    advance = _advance(dynamics, parameters, state, start_time, end)
    return _converged(advance, tolerance)[0]


def _converged(
    advance: Advance, tolerance: float, of: tuple[int, ...] | None = None
) -> tuple[int, Array, Array]:
    """The steps of `converged_steps`; the flow and its Jacobian.

    Entries of the Jacobian are judged by the largest along the axes ``of``, by default by that of
    all points. What a larger number of steps changes foretells, by the order 8, the number that
    is needed.
    """
    steps = OPTIONS.first_steps
    flow, jacobian = advance(steps)
    finer = 2 * steps
    while finer < OPTIONS.max_steps:
        before, slopes_before, coarse, steps = flow, jacobian, steps, finer
        flow, jacobian = advance(steps)
        with np.errstate(all="ignore"):
            change = np.max(np.abs(flow - before) / (1 + np.abs(flow)))
            changes = np.max(np.abs(jacobian - slopes_before), axis=of)
            slope = np.max(changes / np.max(np.abs(jacobian), axis=of))
        excess = np.maximum(change, slope / 10) / (OPTIONS.halving * tolerance)
        if excess < 1:
            return steps, flow, jacobian
        far = OPTIONS.growth[1] if np.maximum(change, slope) < OPTIONS.asymptotic else 2.0
        wanted = OPTIONS.margin * coarse * (excess ** (1 / 8) if np.isfinite(excess) else np.inf)
        finer = int(np.ceil(np.clip(wanted, OPTIONS.growth[0] * steps, far * steps)))
    return OPTIONS.max_steps, flow, jacobian


def growths(
    dynamics: Dynamics, parameters: Any, state: Array, times: Array, start_time: float = 0.0
) -> Array:
    """Largest growth (n_t,) of a small initial error, up to each of the times.

    Errors are measured in each state's own size over the run (`run_sizes`), so that metres
    and radians compare. Infinite from where the growth overflows. The spans between times are
    gone through together, each from the state that a run reaches at its begin.
    """
    times = sample_times(times, start_time)
    solution = solve(dynamics, parameters, state, times, start_time, (1e-7, 1e-6))
    scale = state_size(solution)
    begins = np.append(start_time, times[:-1])
    states = np.column_stack([state, solution.states[:, :-1]])
    spans = _advance(dynamics, parameters, states, begins, times)
    jacobians = _converged(spans, 1e-3, of=(0, 1))[2]
    product = np.eye(len(state))
    largest = np.full(len(times), np.inf)
    for i in range(len(times)):
        with np.errstate(all="ignore"):
            product = jacobians[..., i] @ product
        if not np.all(np.isfinite(product)):
            break
        largest[i] = np.linalg.norm(product * scale / scale[:, None], 2)
    return np.maximum.accumulate(np.maximum(largest, 1.0))


def perturbed(dynamics: Dynamics, c: Any) -> Any:
    """Return coefficients (...) each off by an `OPTIONS.inexact` share of its terms, up or down.

    Those of a continuum stay as they are: the place of a mass changes what its coordinates mean.
    """
    if dynamics.discretisation_coordinates:
        return c
    each = [*dynamics.inexact_numbers(c, OPTIONS.inexact)] or [
        c._replace(**{name: getattr(c, name) * (1 + OPTIONS.inexact)}) for name in c._fields
    ]
    signs = np.random.default_rng(len(each)).choice([-1.0, 1.0], len(each))
    return type(c)(
        *(
            value + sum(sign * (one - value) for sign, one in zip(signs, moved, strict=True))
            for value, moved in zip(c, zip(*each, strict=True), strict=True)
        )
    )


def derivatives(dynamics: Dynamics, c: Any) -> Callable[[Any], Any]:
    """Return the right-hand sides of some points; where all are the same it is made once."""
    common = None if any(map(np.ndim, c)) else dynamics.derivative(c)
    return lambda points: common or dynamics.derivative(coefficients_at(c, points))


def with_relative_perturbation(
    derivative: Callable[[Any, Any], Any],
) -> Callable[[Any, Any], Any]:
    """Return a right-hand side with a `RELATIVE_PERTURBATION`, all along the run."""
    return lambda t, x: (1 + RELATIVE_PERTURBATION) * derivative(t, x)


def solve_many(
    dynamics: Dynamics,
    parameters: Any,
    states: Array,
    times: Any,
    start_time: Any = 0.0,
    tolerance: float = 1e-10,
    most_steps: int = 1 << 17,
) -> Solution:
    """Solve many trajectories at once.

    Each point is solved with some number of steps between samples, and with half of it; the change
    predicts the number that it needs, until its bound is below ``tolerance`` times its range. The
    bound is 1/4 of the change that the last halving made: 64 times what the order 8 predicts for
    the finer run, which is returned. Where rounding stops the change from falling, or the steps
    end, it is twice the change. Three times what a `RELATIVE_PERTURBATION` of start and rates and
    `perturbed` coefficients make is added for rounding. A chaotic or unstable point keeps the bound
    that it has, however large (or infinite).

    Parameters
    ----------
    dynamics : Dynamics
    parameters : Parameters of it
        Fields may be arrays over the points; all broadcast against each other.
    states : array (2 n,) or (2 n, ...)
        Initial states; broadcast against the points.
    times : array (n_t,) or (n_t, ...)
        Sample times [s], common or per point.
    start_time : float or array (...)
        Start of the runs [s], common or per point.
    tolerance : float
        Wanted error relative to the range of each state.
    most_steps : int
        Most steps of a point over its whole run.

    Returns
    -------
    Solution
        ``states`` has shape (2 n, points..., n_t).

    Raises
    ------
    UsageError
        For times that cannot be sampled, or states that are not finite.
    """
    times = sample_times(times, start_time)
    states = initial_states(states)
    c = dynamics.coefficients(parameters)
    shape = np.broadcast_shapes(
        states.shape[1:], times.shape[1:], np.shape(start_time), *(np.shape(v) for v in c)
    )

    def flat(values: Array) -> Array:
        """Return values (m, ...) for all points (m, k)."""
        axes = (len(values), *(1,) * (len(shape) - values.ndim + 1), *values.shape[1:])
        whole = np.broadcast_to(values.reshape(axes), (len(values), *shape))
        return whole.reshape(len(values), -1)

    one_each = type(c)(*(flat(v[None])[0] if np.ndim(v) else v for v in c))
    starts = flat(np.asarray(start_time, float)[None])[0]
    nodes, rows = with_drive_end(
        flat(times), flat(np.asarray(dynamics.drive_end_time(parameters), float)[None])[0], starts
    )
    solution = _solve_points(dynamics, one_each, flat(states), nodes, starts, tolerance, most_steps)
    n = len(states)
    at_times = np.take_along_axis(solution.states, rows.T[None], axis=2)
    return Solution(
        times=times,
        states=at_times.reshape(n, *shape, len(times)),
        error_bound=solution.error_bound.reshape(n, *shape),
        steps=solution.steps,
        rhs_evaluations=solution.rhs_evaluations,
    )


def with_drive_end(times: Array, ends: Array, start: Any) -> tuple[Array, NDArray[np.intp]]:
    """Return times with the end of each point's drive among them, and the rows of the others.

    No step then leads across it.

    Parameters
    ----------
    times : array (n_t, m)
    ends : array (m,)
    start : float or array (m,)

    Returns
    -------
    nodes : array (n_t or n_t + 1, m)
    rows : int array (n_t, m)
        Where each of ``times`` stands among ``nodes``.
    """
    rows = np.broadcast_to(np.arange(len(times))[:, None], times.shape)
    if not np.any((ends > start) & (ends < times[-1])):
        return times, rows
    ends = np.clip(ends, start, times[-1])
    return np.sort(np.vstack([times, ends]), axis=0), rows + (times >= ends)


def _solve_points(
    dynamics: Dynamics,
    c: Any,
    points: Array,
    times: Array,
    start: Array,
    tolerance: float,
    most_steps: int,
) -> Solution:
    """`solve_many` for flat arrays: points (2 n, m), times (n_t, m), start (m,).

    Coefficients are numbers, or arrays (m,).
    """
    n, count = points.shape
    states = np.empty((n, count, len(times)))
    bound = np.full((n, count), np.inf)
    wanted = np.full(count, max(2, 2 * OPTIONS.first_steps // len(times)))
    before = np.full(count, np.inf)
    most = max(most_steps // len(times), 2 * OPTIONS.first_steps)
    work = 0
    pending = np.arange(count)
    answer, check = (derivatives(dynamics, one) for one in (c, perturbed(dynamics, c)))
    while pending.size:
        missed = []
        for block in _blocks(pending, wanted):
            half = int(wanted[block[-1]] + 1) // 2
            derivative = answer(block)
            with np.errstate(all="ignore"):
                coarse, fine = (
                    rk8_samples(derivative, points[:, block], start[block], times[:, block], steps)
                    for steps in (half, 2 * half)
                )
                work += 3 * half * len(times) * block.size
                size = run_sizes(fine, times[-1, block] - start[block], points[:, block])
                change = floor_relative_to_largest(np.max(np.abs(fine - coarse), axis=2), size)
                change[~np.isfinite(change)] = np.inf
                relative = np.nan_to_num(np.max(change / size, axis=0), nan=np.inf)
                growth = (relative / (OPTIONS.halving * tolerance)) ** (1 / 8)
                done = relative <= OPTIONS.halving * tolerance
                stuck = ~done & (relative < OPTIONS.settled) & (relative > before[block] / 2)
                last = done | stuck | (2 * half >= most)
                rounding = np.zeros_like(size)
                if np.any(last):
                    other = with_relative_perturbation(check(block))
                    starts = points[:, block] + RELATIVE_PERTURBATION * size
                    off = rk8_samples(other, starts, start[block], times[:, block], half)
                    work += half * len(times) * block.size
                    rounding = 3 * floor_relative_to_largest(
                        np.max(np.abs(off - coarse), axis=2), size
                    )
            states[:, block] = fine
            bound[:, block] = np.where(done, change / OPTIONS.halving, 2 * change)
            bound[:, block] += np.where(np.isfinite(rounding), rounding, np.inf)
            before[block] = relative
            wanted[block] = np.minimum(2 * half * np.clip(growth, *OPTIONS.point_growth), most)
            missed.append(block[~last])
        pending = np.concatenate(missed)
    bound = np.nan_to_num(bound + 8 * EPS * np.max(np.abs(states), axis=2), nan=np.inf)
    return Solution(times, states, bound, work, work * DOP853.n_stages)


def _blocks(points: Any, wanted: Any) -> Iterator[Any]:
    """Share points among blocks, ascending in wanted steps, where sharing saves time."""
    points = points[np.argsort(wanted[points], kind="stable")]
    while points.size:
        steps = wanted[points]
        size = np.arange(1, points.size + 1)
        rest = np.where(size < points.size, points.size - size + OPTIONS.calls, 0)
        best = int(size[np.argmin(steps * (size + OPTIONS.calls) + steps[-1] * rest)])
        yield points[: min(best, OPTIONS.block)]
        points = points[min(best, OPTIONS.block) :]
