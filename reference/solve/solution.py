"""Solutions: states at sample times, and bounds on their errors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import UsageError
from ..scene import Array

RELATIVE_PERTURBATION = 1e-13
"""Relative change of start and rates by which rounding over a run is judged."""


LOST = 0.01
"""Share of a state's size beyond which a bound says that nothing is known."""

SMALLEST = 1e-6
"""Size of a state relative to the largest one, below which its own error loses nothing."""


@dataclass(frozen=True)
class Solution:
    """States at sample times, with an error bound.

    Attributes
    ----------
    times : array (n_t,) or (n_t, ...)
        Sample times [s].
    states : array (2 n, n_t) from `solve`, (2 n, ..., n_t) from `solve_many`
        Coordinates, then rates (SI).
    error_bound : array (2 n,) or (2 n, ...)
        Bound on the error of each state, the largest over the sample times.
    steps, rhs_evaluations : int
        Work done.
    bounds : array (2 n, n_t) from `solve`, or None
        Bound on the error of each state up to each of the times.
    lost_from : float or None
        First sample time [s] from which nothing is known of some state any more, see `known`.
    """

    times: Array
    states: Array
    error_bound: Array
    steps: int
    rhs_evaluations: int
    bounds: Array | None = None
    lost_from: float | None = None

    @property
    def before_lost(self) -> Solution:
        """The part of one trajectory of which something is known; its times may be none."""
        if self.bounds is None or self.lost_from is None:
            return self
        count = int(np.searchsorted(self.times, self.lost_from))
        bounds = self.bounds[:, :count]
        return replace(
            self,
            times=self.times[:count],
            states=self.states[:, :count],
            error_bound=np.max(bounds, axis=1, initial=0.0),
            bounds=bounds,
            lost_from=None,
        )


def known(bounds: Array, sizes: Array) -> NDArray[np.bool_]:
    """Return at which times (n_t,) bounds (2 n, n_t) leave something known of states."""
    sizes = np.maximum(sizes, SMALLEST * np.max(sizes))
    every: NDArray[np.bool_] = np.all(bounds <= LOST * sizes[:, None], axis=0)
    return every


def sample_times(times: Any, start_time: Any) -> Array:
    """Check sample times: finite, increasing along the first axis, not before the start.

    Raises
    ------
    UsageError
    """
    times = np.asarray(times, dtype=float)
    if times.ndim == 0 or times.size == 0 or not np.all(np.isfinite(times)):
        raise UsageError("sample times must be an array of finite numbers, and not empty")
    if not np.all(np.isfinite(start_time)):
        raise UsageError(f"the start of the run must be finite, not {start_time!r}")
    if np.any(np.diff(times, axis=0) <= 0) or np.any(times[0] < start_time):
        raise UsageError("sample times must increase and must not lie before the start of the run")
    return times


def initial_states(states: Any) -> Array:
    """Check initial states: finite.

    Raises
    ------
    UsageError
    """
    states = np.asarray(states, dtype=float)
    if not np.all(np.isfinite(states)):
        raise UsageError("initial states must be finite")
    return states


def floor_relative_to_largest(difference: Array, size: Array) -> Array:
    """Raise the differences (2 n, ...) of single states to a third of the largest one.

    Compared relative to the states' sizes; so that one state's difference that passes
    through zero at a sample time does not pass for accuracy.
    """
    unit = np.where(size > 0, size, np.max(size, axis=0))
    unit = np.where(unit > 0, unit, 1.0)
    return np.maximum(difference, unit / 3 * np.max(difference / unit, axis=0))


def run_sizes(samples: Array, span: Any, starts: Any = 0.0) -> Array:
    """Return the size (2 n, ...) of each state over runs, to which errors are related.

    A rate is no smaller than what its coordinate's size makes over the run, so that a
    coordinate that stands still does not measure errors in units of rounding.

    Parameters
    ----------
    samples : array (2 n, ..., n_t)
    span : float or array (...)
        Length of the runs [s].
    starts : array (2 n, ...)
    """
    size = np.maximum(np.max(np.abs(samples), axis=-1), np.abs(starts))
    n = len(size) // 2
    size[n:] = np.maximum(size[n:], size[:n] / np.where(span > 0, span, 1.0))
    return np.where(size > 0, size, 1.0)


def state_size(solution: Solution) -> Array:
    """Return the `run_sizes` (2 n,) of one trajectory."""
    return run_sizes(solution.states, solution.times[-1] - solution.times[0])
