"""The flow of the equations of motion by equal steps, its Jacobian, and how errors grow in it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..differences import by_complex_step, probed
from ..scene import Array, Dynamics
from .rk8 import FixedSteps
from .single import solve
from .solution import sample_times, state_size

FIRST_STEPS = 8
"""Steps that a search for enough of them begins with."""

HALVING = 4.0
"""What the change from a coarser run is divided by to bound the finer run's error; order 8
predicts 255 for half the steps, and 25 for two thirds."""

LEAST, FARTHEST = 1.5, 4.0
"""By what numbers of steps grow in the search, at least, and at most where changes are
`ASYMPTOTIC`; else they are doubled."""

ASYMPTOTIC = 1e-3
"""Relative change below which the order is trusted to foretell the next."""

MARGIN = 1.1
"""What foretold steps are multiplied by."""

MOST_STEPS = 1 << 13
"""With which the search ends: chaos, instability."""


Advance = Callable[[int], tuple[Array, Array]]
"""From a number of steps to the flow (2 n, ...) and its Jacobian (2 n, 2 n, ...)."""


def _advance(dynamics: Dynamics, parameters: Any, state: Array, start: Any, end: Any) -> Advance:
    derivative, span = dynamics.right_hand_side(parameters), np.asarray(end) - start
    with np.errstate(all="ignore"):
        flow = FixedSteps(derivative, probed(state), start, span)

    def advance(steps: int) -> tuple[Array, Array]:
        with np.errstate(all="ignore"):
            return by_complex_step(lambda x: flow(x, start, span, steps), state)

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
    entry of the Jacobian; where it is never met, `MOST_STEPS` are returned.
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
    steps = FIRST_STEPS
    flow, jacobian = advance(steps)
    finer = 2 * steps
    while finer < MOST_STEPS:
        before, slopes_before, coarse, steps = flow, jacobian, steps, finer
        flow, jacobian = advance(steps)
        with np.errstate(all="ignore"):
            change = np.max(np.abs(flow - before) / (1 + np.abs(flow)))
            changes = np.max(np.abs(jacobian - slopes_before), axis=of)
            slope = np.max(changes / np.max(np.abs(jacobian), axis=of))
        excess = np.maximum(change, slope / 10) / (HALVING * tolerance)
        if excess < 1:
            return steps, flow, jacobian
        far = FARTHEST if np.maximum(change, slope) < ASYMPTOTIC else 2.0
        wanted = MARGIN * coarse * (excess ** (1 / 8) if np.isfinite(excess) else np.inf)
        finer = int(np.ceil(np.clip(wanted, LEAST * steps, far * steps)))
    return MOST_STEPS, flow, jacobian


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
