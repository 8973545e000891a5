"""One trajectory, by DOP853 or Gauss collocation, with a stated error bound."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import DOP853, solve_ivp

from ..errors import UsageError
from ..scene import Array, Dynamics
from .gauss import Gauss
from .solution import Solution, floor_relative_to_largest, initial_states, run_sizes, sample_times

TOLERANCES = (1e-13, 1e-11)
"""Relative tolerances of the two runs behind `solve`: the answer, and its check."""


def solve(
    dynamics: Dynamics,
    parameters: Any,
    state: Array,
    times: Any,
    start_time: float = 0.0,
    tolerances: tuple[float, float] | None = None,
) -> Solution:
    """Solve one trajectory: by DOP853, a stiff scene by Gauss collocation.

    The bound is the difference between runs at the two `TOLERANCES`, whose steps share no
    grid, plus rounding of the largest value. The tolerances lie a factor of 100 apart, so
    that the errors of the two hardly ever cancel. Both runs interpolate at the sample times,
    so the bound covers that too. No step leads across the end of a drive. Where a run is
    chaotic to its end, the bound says no more than that the states are lost.

    Parameters
    ----------
    dynamics : Dynamics
    parameters : Parameters of it
    state : array (2 n,)
        Coordinates, then rates, at ``start_time``.
    times : array (n_t,)
        Sample times [s], increasing.
    start_time : float
        Start of the run [s].
    tolerances : (float, float)
        Relative tolerances of the answer and of its check, by default `TOLERANCES`, or
        those of a stiff dynamics.

    Returns
    -------
    Solution

    Raises
    ------
    UsageError
        If the times cannot be sampled, the state is not finite, or the integration fails.
    """
    times = sample_times(times, start_time)
    state = initial_states(state)
    derivative = dynamics.right_hand_side(parameters)
    method = Gauss if dynamics.stiff else DOP853

    end = float(dynamics.drive_end_time(parameters))
    nodes = [start_time, *([end] if start_time < end < times[-1] else []), times[-1]]

    def run(rtol: float, atol: Any) -> tuple[Array, int]:
        """Return the states (2 n, n_t), piece by piece between nodes, and the evaluations."""
        x, rows, work = state, [state[:, None][:, : np.sum(times == start_time)]], 0
        for first, last in pairwise(nodes):
            inside = times[(times > first) & (times <= last)]
            marks = np.union1d(inside, [last])
            with np.errstate(all="ignore"):
                piece = solve_ivp(derivative, (first, last), x, method, marks, rtol=rtol, atol=atol)
            if not piece.success or not np.all(np.isfinite(piece.y)):
                raise UsageError(f"the reference cannot follow this trajectory: {piece.message}")
            x, work = piece.y[:, -1], work + piece.nfev
            rows.append(piece.y[:, : len(inside)])
        return np.hstack(rows), work

    if times[-1] == start_time:
        return Solution(times, state[:, None], np.zeros(len(state)), 0, 0)
    coarse, work = run(1e-6, 1e-9)
    scale = run_sizes(coarse, times[-1] - start_time, state)
    tolerances = tolerances or dynamics.stiff or TOLERANCES
    (fine, steps), (check, more) = (run(rtol, rtol * scale) for rtol in tolerances)
    difference = floor_relative_to_largest(np.max(np.abs(fine - check), axis=1), scale)
    return Solution(
        times=times,
        states=fine,
        error_bound=difference + 8 * np.finfo(float).eps * scale,
        steps=steps // method.n_stages,
        rhs_evaluations=work + steps + more,
    )
