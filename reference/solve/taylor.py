"""`solve_many` by heyoka's batch Taylor method (optional extra ``fast``)."""

from __future__ import annotations

from functools import cache
from typing import Any

import heyoka as hy
import numpy as np

from ..scene import Array, Dynamics
from .batched import perturbed
from .solution import RELATIVE_PERTURBATION, Solution, floor_relative_to_largest, run_sizes

TOLERANCES = (0.0, 1e-13)
"""heyoka's tolerance of the answer (0 is the rounding unit) and of its check."""


@cache
def integrator(dynamics: Dynamics, kind: type[Any], tolerance: float) -> tuple[Any, int]:
    """Compile the batch integrator of a scene; returns it with its number of lanes."""
    symbols = hy.make_vars(*dynamics.state_names)
    n = len(dynamics.coordinates)
    c = kind(*(hy.par[i] for i in range(len(kind._fields))))  # run-time parameters
    u = dynamics.drive(hy.time, c, hy) if dynamics.drive else 0.0
    rates = [*symbols[n:], *dynamics.accelerations(u, symbols[:n], symbols[n:], c, hy)]
    lanes = hy.recommended_simd_size()
    system = list(zip(symbols, rates, strict=True))
    options = {"tol": tolerance} if tolerance else {}
    return hy.taylor_adaptive_batch(system, np.zeros((2 * n, lanes)), **options), lanes


def solves(dynamics: Dynamics, kind: type[Any]) -> bool:
    """Return True if heyoka can solve a scene.

    A drive that ends compares times, and an eliminated mass matrix takes minutes to compile.
    """
    if dynamics.eliminates:
        return False
    try:
        integrator(dynamics, kind, TOLERANCES[0])  # type: ignore[arg-type]
    except TypeError:  # expressions are not compared
        return False
    return True


def solve_points(dynamics: Dynamics, c: Any, points: Array, times: Array, start: float) -> Solution:
    """`mbcheck.reference.solve.batched.solve_many` for flat arrays.

    Parameters
    ----------
    dynamics : Dynamics
    c : NamedTuple of numbers or arrays (m,)
    points : array (2 n, m)
    times : array (n_t, m)
    start : float

    Returns
    -------
    Solution
        The bound is three times the difference between runs at the two `TOLERANCES`; the check
        starts off by a `RELATIVE_PERTURBATION` and has `perturbed` coefficients, because the
        answer's own errors are rounding.
    """
    states, steps = _propagate(dynamics, c, points, times, start, TOLERANCES[0])
    with np.errstate(all="ignore"):
        size = run_sizes(states, times[-1] - start, points)
        starts = points + RELATIVE_PERTURBATION * np.where(np.isfinite(size), size, 0.0)
        off = perturbed(dynamics, c)
        check, taken = _propagate(dynamics, off, starts, times, start, TOLERANCES[1])
        change = floor_relative_to_largest(np.max(np.abs(states - check), axis=2), size)
    bound = np.where(np.isfinite(change), 3 * change + 8 * np.finfo(float).eps * size, np.inf)
    return Solution(times, states, bound, steps + taken, steps + taken)


def _propagate(
    dynamics: Dynamics, c: Any, points: Array, times: Array, start: float, tolerance: float
) -> tuple[Array, int]:
    """States (2 n, m, n_t) and the number of Taylor steps."""
    integrate, lanes = integrator(dynamics, type(c), tolerance)  # type: ignore[arg-type]
    n, count = points.shape
    states = np.full((n, count, len(times)), np.nan)
    coefficients = np.array([np.broadcast_to(value, count) for value in c])
    with_start = np.concatenate([np.full((1, count), start), times])
    steps = 0
    for first in range(0, count, lanes):
        lane = np.minimum(np.arange(first, first + lanes), count - 1)
        filled = min(lanes, count - first)
        integrate.set_time(start)
        integrate.state[:] = points[:, lane]
        integrate.pars[:] = coefficients[: len(integrate.pars), lane]  # the last may be unused
        grid = np.ascontiguousarray(with_start[:, lane])
        repeated = bool(np.any(grid[1] == grid[0]))
        samples = np.asarray(integrate.propagate_grid(grid[1:] if repeated else grid)[-1])
        samples = samples if repeated else samples[1:]
        states[:, first : first + filled] = np.moveaxis(samples, 0, 2)[:, :filled]
        steps += sum(int(result[3]) for result in integrate.propagate_res[:filled])
    return states, steps
