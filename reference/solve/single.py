"""One trajectory, by DOP853 or Gauss collocation, with a stated error bound."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import DOP853, solve_ivp

from ..differences import EPS
from ..errors import UsageError
from ..scene import Array, Dynamics
from .gauss import Gauss
from .rounding import roundoff
from .solution import (
    Solution,
    floor_relative_to_largest,
    initial_states,
    known,
    run_sizes,
    sample_times,
)

TOLERANCES = (1e-13, 1e-11)
"""Relative tolerances of the two runs behind `solve`: the answer, and its check."""

GAIN = 10.0
"""What the answer is more accurate than its check, at least: their tolerances say 100."""

LOOSE = 1e-6
"""Relative tolerance of the run whose steps are the intervals of `roundoff`."""


def solve(
    dynamics: Dynamics,
    parameters: Any,
    state: Array,
    times: Any,
    start_time: float = 0.0,
    tolerances: tuple[float, float] | None = None,
) -> Solution:
    """Solve one trajectory: by DOP853, a stiff scene by Gauss collocation.

    The bound adds what the method and what rounding leave unknown. For the method it is a
    `GAIN`-th of the difference between runs at the two `TOLERANCES`, whose steps share no grid;
    both interpolate at the sample times, so that it covers that too. Rounding of the start, of
    the parameters, of the rates and of the states is carried along, see `roundoff`. No step leads
    across the end of a drive. From where the bound passes a share of the states' sizes nothing is
    known, and the solution is lost (`Solution.lost_from`).

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
    if times[-1] == start_time:
        bounds = EPS / 2 * np.abs(state[:, None])
        return Solution(times, state[:, None], bounds[:, 0], 0, 0, bounds)
    derivative = dynamics.right_hand_side(parameters)
    method = Gauss if dynamics.stiff else DOP853
    end = float(dynamics.drive_end_time(parameters))
    pieces = [start_time, *([end] if start_time < end < times[-1] else []), times[-1]]

    def run(rtol: float, atol: Any, marks: Array | None = None) -> tuple[Array, Array, int]:
        """Return times, states (2 n, m) there and evaluations, piece by piece.

        At the marks, which hold the ends of the pieces; without any at the ends of the steps.
        """
        whole, rows, work = [np.array([start_time])], [state[:, None]], 0
        for first, last in pairwise(pieces):
            inside = None if marks is None else marks[(marks > first) & (marks <= last)]
            with np.errstate(all="ignore"):
                piece = solve_ivp(
                    derivative, (first, last), rows[-1][:, -1], method, inside, rtol=rtol, atol=atol
                )
            if not piece.success or not np.all(np.isfinite(piece.y)):
                raise UsageError(f"the reference cannot follow this trajectory: {piece.message}")
            begin = 0 if inside is not None else 1
            whole, rows = [*whole, piece.t[begin:]], [*rows, piece.y[:, begin:]]
            work += piece.nfev
        return np.hstack(whole), np.hstack(rows), work

    ends, coarse, work = run(LOOSE, 1e-9)
    nodes = np.sort(np.concatenate([ends, (ends[1:] + ends[:-1]) / 2]))
    marks = np.union1d(times, nodes)
    scale = run_sizes(coarse, times[-1] - start_time, state)
    tolerances = tolerances or dynamics.stiff or TOLERANCES
    (_, fine, steps), (_, check, more) = (run(tol, tol * scale, marks) for tol in tolerances)
    rows, places = np.searchsorted(marks, times), np.searchsorted(marks, nodes)
    sizes = run_sizes(fine, times[-1] - start_time, state)
    difference = floor_relative_to_largest(np.abs(fine - check), sizes[:, None])
    rounding = roundoff(
        dynamics, parameters, nodes, fine[:, places], sizes, steps // method.n_stages
    )
    later = np.searchsorted(ends, times)
    bounds = np.maximum.accumulate(
        np.maximum.accumulate(difference, axis=1)[:, rows] / GAIN
        + np.maximum.accumulate(rounding, axis=1)[:, later]
        + EPS * np.abs(fine[:, rows]),
        axis=1,
    )
    lost = ~known(bounds, sizes)
    return Solution(
        times=times,
        states=fine[:, rows],
        error_bound=bounds[:, -1],
        steps=steps // method.n_stages,
        rhs_evaluations=work + steps + more,
        bounds=bounds,
        lost_from=float(times[np.argmax(lost)]) if np.any(lost) else None,
    )
