"""Solutions of a scene's equations of motion, each with a stated error bound.

`solve` follows one trajectory with SciPy's DOP853 at two tolerances; `solve_many` follows
thousands at once with a fixed-step Runge-Kutta method of order 8, each point with steps
short enough that halving them changes little, or with heyoka's batch Taylor method where that is
installed. The two share no step-size control, and a test holds one against the other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.integrate import DOP853, solve_ivp

from ..errors import UsageError
from ..scene import Array, Scene
from .gauss import Gauss

TOLERANCES = (1e-13, 1e-11)
"""Relative tolerances of the two runs behind `solve`: the answer, and its check."""

FIRST_STEPS, MOST_STEPS = 8, 1 << 17
HALVING = 4.0
"""What a halving's change is divided by to bound the finer run's error; order 8 predicts 255."""

NUDGE = 1e-13
"""Relative change of start and rates by which rounding over a run is judged."""

GROWTH = (1.25, 8.0)
"""Least and largest growth of the number of steps of a point that misses its tolerance."""

SETTLED = 1e-3
"""A change below this share of the range that stops falling is rounding, not the method."""

BLOCK = 2048
"""Most points solved together in `solve_many`; about what the cache holds."""

CALLS = 500
"""Points whose arithmetic takes as long as NumPy's calls do, whatever their number."""


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
    """

    times: Array
    states: Array
    error_bound: Array
    steps: int
    rhs_evaluations: int


def sample_times(times: Any, start_time: float) -> Array:
    """Check sample times: finite, increasing along the first axis, not before the start.

    Raises
    ------
    UsageError
    """
    times = np.asarray(times, dtype=float)
    if times.ndim == 0 or times.size == 0 or not np.all(np.isfinite(times)):
        raise UsageError("sample times must be an array of finite numbers, and not empty")
    if not np.isfinite(start_time):
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


def evened(difference: Array, size: Array) -> Array:
    """Raise the differences (2 n, ...) of single states to a third of the largest one.

    Compared relative to the states' sizes; so that one state's difference that passes
    through zero at a sample time does not pass for accuracy.
    """
    unit = np.where(size > 0, size, np.max(size, axis=0))
    unit = np.where(unit > 0, unit, 1.0)
    return np.maximum(difference, unit / 3 * np.max(difference / unit, axis=0))


def nudged(derivative: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    """Return a right-hand side that is off by a `NUDGE`, all along the run."""
    return lambda t, x: (1 + NUDGE) * derivative(t, x)


def solve(
    scene: Scene,
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
    so the bound covers that too. Where a run is chaotic to its end, the bound says
    no more than that the states are lost.

    Parameters
    ----------
    scene : Scene
    parameters : Parameters of the scene
    state : array (2 n,)
        Coordinates, then rates, at ``start_time``.
    times : array (n_t,)
        Sample times [s], increasing.
    start_time : float
        Start of the run [s].
    tolerances : (float, float)
        Relative tolerances of the answer and of its check, by default `TOLERANCES`, or
        those of a stiff scene.

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
    derivative = scene.right_hand_side(parameters)
    method = Gauss if scene.stiff else DOP853

    def run(rtol: float, atol: Any) -> Any:
        with np.errstate(all="ignore"):
            result = solve_ivp(
                derivative, (start_time, times[-1]), state, method, times, rtol=rtol, atol=atol
            )
        if not result.success or not np.all(np.isfinite(result.y)):
            raise UsageError(f"the reference cannot follow this trajectory: {result.message}")
        return result

    if times[-1] == start_time:
        return Solution(times, state[:, None], np.zeros(len(state)), 0, 0)
    coarse = run(1e-6, 1e-9)
    scale = sizes(coarse.y[:, None], state[:, None], times[-1:] - start_time)[:, 0]
    tolerances = tolerances or scene.stiff or TOLERANCES
    fine, check = (run(rtol, rtol * scale) for rtol in tolerances)
    difference = evened(np.max(np.abs(fine.y - check.y), axis=1), scale)
    return Solution(
        times=times,
        states=fine.y,
        error_bound=difference + 8 * np.finfo(float).eps * scale,
        steps=fine.nfev // method.n_stages,
        rhs_evaluations=coarse.nfev + fine.nfev + check.nfev,
    )


def rk8_steps(derivative: Callable[[Any, Any], Any], x: Any, t0: Any, t1: Any, steps: int) -> Any:
    """Advance x from t0 to t1 in equal steps of the 8th-order Dormand-Prince method.

    Works on real or complex arrays of any shape (2 n, ...); ``t0``, ``t1`` broadcast
    against the points.
    """
    stages = DOP853.n_stages
    A, B, C = DOP853.A, DOP853.B, DOP853.C
    h = (np.asarray(t1, dtype=float) - t0) / steps
    k = np.empty((stages, *x.shape), dtype=x.dtype)
    at = np.empty_like(k[0])
    flat, flat_at = k.reshape(stages, -1), at.reshape(-1)
    for i in range(steps):
        t = t0 + i * h
        k[0] = derivative(t, x)
        for s in range(1, stages):
            np.matmul(A[s, :s], flat[:s], out=flat_at)
            np.multiply(at, h, out=at)
            np.add(at, x, out=at)
            k[s] = derivative(t + C[s] * h, at)
        x = x + h * (B @ flat).reshape(x.shape)
    return x


def _rk8_samples(
    derivative: Callable[[Any, Any], Any], x: Any, start: Any, times: Array, steps: int
) -> Any:
    """States (2 n, points, n_t) at ``times`` (n_t, points), ``steps`` to each interval."""
    samples = np.empty((*x.shape, len(times)), dtype=x.dtype)
    before = start
    for i, now in enumerate(times):
        x = rk8_steps(derivative, x, before, now, steps)
        samples[..., i] = x
        before = now
    return samples


def solve_many(
    scene: Scene,
    parameters: Any,
    states: Array,
    times: Any,
    start_time: float = 0.0,
    tolerance: float = 1e-10,
    backend: str = "auto",
) -> Solution:
    """Solve many trajectories at once.

    With NumPy, each point is solved with some number of steps between samples, and with
    half of it; the change predicts the number that it needs, until its bound is below
    ``tolerance`` times its range. The bound is 1/4 of the change that the last halving
    made: 64 times what the order 8 predicts for the finer run, which is returned. Where
    rounding stops the change from falling, or the steps end, it is the change. Three times
    what a `NUDGE` of start and rates grows to is added for rounding. heyoka solves to
    rounding, whatever ``tolerance`` is, see `taylor.solve_points`. A chaotic or unstable
    point keeps the bound that it has, however large (or infinite).

    Parameters
    ----------
    scene : Scene
    parameters : Parameters of the scene
        Fields may be arrays over the points; all broadcast against each other.
    states : array (2 n,) or (2 n, ...)
        Initial states; broadcast against the points.
    times : array (n_t,) or (n_t, ...)
        Sample times [s], common or per point.
    start_time : float
        Start of the runs [s].
    tolerance : float
        Wanted error relative to the range of each state.
    backend : {"auto", "numpy", "heyoka"}
        "auto" takes heyoka where it is installed.

    Returns
    -------
    Solution
        ``states`` has shape (2 n, points..., n_t).

    Raises
    ------
    UsageError
        For times that cannot be sampled, states that are not finite, or a backend that is
        not there.
    """
    times = sample_times(times, start_time)
    states = initial_states(states)
    c = scene.coefficients(parameters)
    shape = np.broadcast_shapes(states.shape[1:], times.shape[1:], *(np.shape(v) for v in c))
    count = int(np.prod(shape))
    points = np.broadcast_to(
        states.reshape(len(states), *(1,) * (len(shape) - states.ndim + 1), *states.shape[1:]),
        (len(states), *shape),
    ).reshape(len(states), count)
    grid = np.broadcast_to(
        times.reshape(len(times), *(1,) * (len(shape) - times.ndim + 1), *times.shape[1:]),
        (len(times), *shape),
    ).reshape(len(times), count)
    flat = type(c)(*(np.broadcast_to(v, shape).reshape(count) for v in c))
    if backend not in ("auto", "numpy", "heyoka"):
        raise UsageError(f"unknown backend {backend!r}; known: auto, numpy, heyoka")
    installed = find_spec("heyoka") is not None
    if backend == "heyoka" and not installed:
        raise UsageError("heyoka is not installed; pip install 'mbcheck[fast]'")
    if installed and backend != "numpy":
        from . import taylor

        solution = taylor.solve_points(scene, flat, points, grid, start_time)
    else:
        solution = _solve_points(scene, flat, points, grid, start_time, tolerance)
    n = len(states)
    return Solution(
        times=times,
        states=solution.states.reshape(n, *shape, len(times)),
        error_bound=solution.error_bound.reshape(n, *shape),
        steps=solution.steps,
        rhs_evaluations=solution.rhs_evaluations,
    )


def _solve_points(
    scene: Scene, c: Any, points: Array, times: Array, start: float, tolerance: float
) -> Solution:
    """`solve_many` for flat arrays: points (2 n, m), times (n_t, m), c of arrays (m,)."""
    n, count = points.shape
    states = np.empty((n, count, len(times)))
    bound = np.full((n, count), np.inf)
    wanted = np.full(count, 2 * FIRST_STEPS)
    before = np.full(count, np.inf)
    most = max(MOST_STEPS // len(times), 2 * FIRST_STEPS)
    work = 0
    pending = np.arange(count)
    while pending.size:
        missed = []
        for block in _blocks(pending, wanted):
            half = int(wanted[block[-1]] + 1) // 2
            derivative = scene.derivative(type(c)(*(v[block] for v in c)))
            with np.errstate(all="ignore"):
                coarse, fine = (
                    _rk8_samples(derivative, points[:, block], start, times[:, block], steps)
                    for steps in (half, 2 * half)
                )
                work += 3 * half * len(times) * block.size
                size = sizes(fine, points[:, block], times[-1, block] - start)
                change = evened(np.max(np.abs(fine - coarse), axis=2), size)
                change[~np.isfinite(change)] = np.inf
                relative = np.nan_to_num(np.max(change / size, axis=0), nan=np.inf)
                growth = (relative / (HALVING * tolerance)) ** (1 / 8)
                done = relative <= HALVING * tolerance
                stuck = ~done & (relative < SETTLED) & (relative > before[block] / 2)
                last = done | stuck | (2 * half >= most)
                rounding = np.zeros_like(size)
                if np.any(last):
                    starts = points[:, block] + NUDGE * size
                    off = _rk8_samples(nudged(derivative), starts, start, times[:, block], half)
                    work += half * len(times) * block.size
                    rounding = 3 * evened(np.max(np.abs(off - coarse), axis=2), size)
            states[:, block] = fine
            bound[:, block] = np.where(done, change / HALVING, change)
            bound[:, block] += np.where(np.isfinite(rounding), rounding, np.inf)
            before[block] = relative
            wanted[block] = np.minimum(2 * half * np.clip(growth, *GROWTH), most)
            missed.append(block[~last])
        pending = np.concatenate(missed)
    eps = np.finfo(float).eps
    bound = np.nan_to_num(bound + 8 * eps * np.max(np.abs(states), axis=2), nan=np.inf)
    return Solution(times, states, bound, work, work * DOP853.n_stages)


def sizes(samples: Array, starts: Array, span: Array) -> Array:
    """Size (2 n, points) of each state of each point, as `state_size`."""
    n = len(starts) // 2
    size = np.maximum(np.max(np.abs(samples), axis=2), np.abs(starts))
    size[n:] = np.maximum(size[n:], size[:n] / np.where(span > 0, span, 1.0))
    return np.where(size > 0, size, 1.0)


def _blocks(points: Any, wanted: Any) -> Iterator[Any]:
    """Share points among blocks, ascending in wanted steps, where sharing saves time."""
    points = points[np.argsort(wanted[points], kind="stable")]
    while points.size:
        steps = wanted[points]
        size = np.arange(1, points.size + 1)
        rest = np.where(size < points.size, points.size - size + CALLS, 0)
        best = int(size[np.argmin(steps * (size + CALLS) + steps[-1] * rest)])
        yield points[: min(best, BLOCK)]
        points = points[min(best, BLOCK) :]


def transition_matrix(
    scene: Scene, parameters: Any, state: Array, end: Any, start_time: float = 0.0, steps: int = 0
) -> tuple[Array, Array]:
    """Flow of a state and its Jacobian, exact to rounding by complex steps.

    Parameters
    ----------
    scene : Scene
    parameters : Parameters of the scene
        Fields may be arrays over points.
    state : array (2 n, ...)
    end : float or array (...)
        End of the run [s].
    start_time : float
    steps : int
        Steps of the 8th-order method; 0 takes `converged_steps`.

    Returns
    -------
    flow : array (2 n, ...)
    jacobian : array (2 n, 2 n, ...)
        d flow_i / d state_j, entry [i, j].
    """
    if not steps:
        steps = converged_steps(scene, parameters, state, end, start_time)
    lanes = _probed(np.asarray(state, dtype=float))
    with np.errstate(all="ignore"):
        result = rk8_steps(scene.right_hand_side(parameters), lanes, start_time, end, steps)
    return result.real[:, 0], result.imag / PROBE


PROBE = 1e-40
"""Complex step of the Jacobians; far below rounding, so the real part is the plain flow."""


def _probed(state: Array) -> Any:
    """States (2 n, 2 n, ...), column j with a complex step in state j."""
    n = len(state)
    lanes = np.broadcast_to(state[:, None], (n, *state.shape)).astype(complex)
    lanes[np.arange(n), np.arange(n)] += 1j * PROBE
    return lanes


def converged_steps(
    scene: Scene,
    parameters: Any,
    state: Array,
    end: Any,
    start_time: float = 0.0,
    tolerance: float = 1e-12,
) -> int:
    """Steps at which the halved step leaves the flow and its Jacobian unchanged.

    ``tolerance`` is relative to the size of the flow and ten times that to the largest
    entry of the Jacobian; where it is never met (chaos, instability) 2^13 is returned.
    """
    return _converged(scene, parameters, state, end, start_time, tolerance, FIRST_STEPS)[0]


def _converged(
    scene: Scene,
    parameters: Any,
    state: Array,
    end: Any,
    start_time: float,
    tolerance: float,
    count: int,
) -> tuple[int, Any]:
    """The steps of `converged_steps`, searched from ``count`` on, and the probed flow."""
    lanes = _probed(np.asarray(state, dtype=float))
    derivative = scene.right_hand_side(parameters)
    result = before = None
    with np.errstate(all="ignore"):
        while count < 1 << 13:
            result = rk8_steps(derivative, lanes, start_time, end, count)
            if before is not None:
                flow = np.max(np.abs(result.real - before.real) / (1 + np.abs(result.real)))
                slope = np.max(np.abs(result.imag - before.imag)) / np.max(np.abs(result.imag))
                if flow < HALVING * tolerance and slope < 10 * HALVING * tolerance:
                    break
            count, before = 2 * count, result
    return count, result


def state_size(solution: Solution) -> Array:
    """Return the size (2 n,) of each state over a run, to which errors are related.

    A rate is no smaller than what its coordinate's size makes over the run, so that a
    coordinate that stands still does not measure errors in units of rounding.
    """
    n = len(solution.states) // 2
    span = float(solution.times[-1] - solution.times[0]) or 1.0
    size = np.max(np.abs(solution.states), axis=1)
    size[n:] = np.maximum(size[n:], size[:n] / span)
    return np.where(size > 0, size, 1.0)


def growths(
    scene: Scene, parameters: Any, state: Array, times: Array, start_time: float = 0.0
) -> Array:
    """Largest growth (n_t,) of a small initial error, up to each of the times.

    Errors are measured in each state's own size over the run (`state_size`), so that metres
    and radians compare. Infinite from where the growth overflows.
    """
    times = sample_times(times, start_time)
    scale = state_size(solve(scene, parameters, state, times, start_time, (1e-7, 1e-6)))
    product = np.eye(len(state))
    found = np.full(len(times), np.inf)
    now, steps = start_time, FIRST_STEPS
    for i, mark in enumerate(times):
        steps, flow = _converged(scene, parameters, state, mark, now, 1e-3, max(steps // 2, 8))
        state, jacobian = flow.real[:, 0], flow.imag / PROBE
        product, now = jacobian @ product, mark
        if not np.all(np.isfinite(product)):
            break
        found[i] = np.linalg.norm(product * scale / scale[:, None], 2)
    return np.maximum.accumulate(np.maximum(found, 1.0))


def amplification(
    scene: Scene, parameters: Any, state: Array, times: Array, start_time: float = 0.0
) -> float:
    """Largest growth of a small initial error, looked at eight times over the horizon."""
    marks = np.linspace(start_time, np.asarray(times)[-1], 9)[1:]
    return float(growths(scene, parameters, state, marks, start_time)[-1])
