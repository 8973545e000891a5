"""One trajectory, by DOP853 or Gauss collocation, with a stated error bound."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import DOP853, solve_ivp

from ..differences import EPS
from ..errors import UsageError
from ..scene import Array, Dynamics
from .bounds import Samples, bounds_of, gauss_points
from .gauss import Gauss
from .solution import (
    Solution,
    floor_relative_to_largest,
    initial_states,
    known,
    run_sizes,
    sample_times,
)


class SolveOptions(NamedTuple):
    """How one trajectory is solved.

    Attributes
    ----------
    tolerance : float
        Relative tolerance of the answer, unless it is stiff.
    loose_tolerance : float
        Relative tolerance of the run whose steps are the intervals of local errors, unless that of
        a stiff answer's check is larger.
    max_times : int
        Sample times that are nodes too; of others the bound is that of the next node.
    safety : float
        What the difference of a stiff answer from its check is multiplied by. A check at a larger
        tolerance errs by more than the answer; one at a smaller tolerance by a part of what that
        does: of Gauss's steps, of order 20 and chosen by an estimate of order 10, a third of it
        makes a ninth.
    min_steps : tuple[int, int, int]
        Fewest steps of the answer, and of a check at a larger or a smaller tolerance: in a time so
        short that no tolerance limits a step they would share their steps, and their errors.
    first_steps : tuple[int, int, int]
        First steps of stiff runs are such parts of them.
    straight : float
        Share of a state's size by which it may be off a straight line within an interval.
    max_parts : int
        Most parts that an interval is divided into for that.
    min_quaternion_size : float
        Smallest size of a quaternion's coordinate, in that of the largest, whose rounding it
        shares.
    """

    tolerance: float = 1e-13
    loose_tolerance: float = 1e-8
    max_times: int = 10_000
    safety: float = 2.0
    min_steps: tuple[int, int, int] = (7, 3, 11)
    first_steps: tuple[int, int, int] = (100, 37, 173)
    straight: float = 0.1
    max_parts: int = 8
    min_quaternion_size: float = 1e-3


OPTIONS = SolveOptions()


ANSWER, COARSER, FINER = range(3)


def solve(
    dynamics: Dynamics,
    parameters: Any,
    state: Array,
    times: Any,
    start_time: float = 0.0,
    tolerances: tuple[float, float] | None = None,
) -> Solution:
    """Solve one trajectory: by DOP853, a stiff scene by Gauss collocation.

    The bound carries local errors along by the linearised equations: those of the method, each
    the difference from a solution with far more steps, and those of rounding, of the start
    and of the parameters too, see `bounds_of`. A stiff answer is compared with a run at another
    tolerance instead, whose steps share no grid with its own. No step leads across the end of a
    drive. From where the bound passes a share of the states' sizes nothing is known, and the
    solution is lost (`Solution.lost_from`).

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
        Relative tolerances of the answer and of the check of a stiff one, by default
        `OPTIONS.tolerance`, or those of a stiff dynamics.

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
    runs = Integration(dynamics, parameters, state, start_time, float(times[-1]))
    rtol, rtol_check = tolerances or tolerances_of(dynamics)
    loose = max(OPTIONS.loose_tolerance, rtol_check)
    ends, scale, work = runs.rough(loose)
    nodes = np.union1d(ends, times[:: 1 + len(times) // OPTIONS.max_times])
    points = gauss_points(nodes)
    marks = np.union1d(np.union1d(nodes, points), times)
    _, fine, steps = runs(rtol, rtol * scale, marks)
    sizes = run_sizes(fine, times[-1] - start_time, state)
    common = with_companions(dynamics, sizes)
    difference = None
    if dynamics.stiff:
        place = FINER if rtol_check < rtol else COARSER
        _, check, more = runs(rtol_check, rtol_check * scale, marks, place)
        difference = OPTIONS.safety * np.abs(fine - check)
        if place == COARSER:
            difference = floor_relative_to_largest(difference, common[:, None])
        ahead = np.append(nodes[1:], nodes[-1])  # a difference may pass through zero at a node
        difference = np.maximum.accumulate(difference, axis=1)[:, np.searchsorted(marks, ahead)]
        work += more
    samples = Samples(
        nodes=nodes,
        states=fine[:, np.searchsorted(marks, nodes)],
        inside=np.moveaxis(fine[:, np.searchsorted(marks, points)], 1, 0),
        sizes=sizes,
        steps=steps // runs.method.n_stages,
    )
    rows = np.searchsorted(nodes, times)
    bounds = bounds_of(dynamics, parameters, samples, difference)[:, rows]
    lost = ~known(bounds, common)
    bounds[:, lost] = np.inf  # to first order other states may seem not to be touched
    return Solution(
        times=times,
        states=fine[:, np.searchsorted(marks, times)],
        error_bound=bounds[:, -1],
        steps=samples.steps,
        rhs_evaluations=work + steps,
        bounds=bounds,
        lost_from=float(times[np.argmax(lost)]) if np.any(lost) else None,
    )


def states_at(
    dynamics: Dynamics,
    parameters: Any,
    state: Array,
    times: Any,
    tolerances: tuple[float, float] | None = None,
) -> Array:
    """Return the states (2 n, n_t) of `solve` from t = 0, without the bound on their errors.

    The steps are the same; only round-off of the interpolation between them may differ.

    Parameters
    ----------
    dynamics, parameters, state, times, tolerances
        As in `solve`; the last time is positive.

    Raises
    ------
    UsageError
        As `solve` does.
    """
    times = sample_times(times, 0.0)
    runs = Integration(dynamics, parameters, initial_states(state), 0.0, float(times[-1]))
    rtol, rtol_check = tolerances or tolerances_of(dynamics)
    _, scale, _ = runs.rough(max(OPTIONS.loose_tolerance, rtol_check))
    marks = np.union1d(times, runs.pieces)
    _, states, _ = runs(rtol, rtol * scale, marks)
    return np.asarray(states[:, np.searchsorted(marks, times)])


def tolerances_of(dynamics: Dynamics) -> tuple[float, float]:
    """Return the relative tolerances of the answer and of the check of a stiff one."""
    return dynamics.stiff or (OPTIONS.tolerance, 0.0)


@dataclass(frozen=True)
class Integration:
    """Runs of one trajectory at different tolerances.

    Attributes
    ----------
    dynamics : Dynamics
    parameters : Parameters of it
    state : array (2 n,)
        At the start.
    start, end : float
        Of the trajectory [s].
    """

    dynamics: Dynamics
    parameters: Any
    state: Array
    start: float
    end: float

    @cached_property
    def derivative(self) -> Callable[[Any, Any], Any]:
        """The right-hand side."""
        return self.dynamics.right_hand_side(self.parameters)

    @property
    def method(self) -> Any:
        """The method of SciPy's that takes the steps."""
        return Gauss if self.dynamics.stiff else DOP853

    @property
    def pieces(self) -> list[float]:
        """Times [s] that no step leads across: start, end of a drive, end."""
        off = float(self.dynamics.drive_end_time(self.parameters))
        return [self.start, *([off] if self.start < off < self.end else []), self.end]

    def __call__(
        self, rtol: float, atol: Any, marks: Array | None = None, place: int = ANSWER
    ) -> tuple[Array, Array, int]:
        """Return times, states (2 n, m) there and evaluations, piece by piece.

        At the marks, which hold the ends of the pieces; without any at the ends of the steps, of
        which a stiff run follows the bends.
        """
        stiff = bool(self.dynamics.stiff)
        whole, rows, work = [np.array([self.start])], [self.state[:, None]], 0
        for first, last in pairwise(self.pieces):
            inside = None if marks is None else marks[(marks > first) & (marks <= last)]
            with np.errstate(all="ignore"):
                piece = solve_ivp(
                    self.derivative,
                    (first, last),
                    rows[-1][:, -1],
                    self.method,
                    inside,
                    rtol=rtol,
                    atol=atol,
                    max_step=(last - first) / OPTIONS.min_steps[place],
                    first_step=(last - first) / OPTIONS.first_steps[place] if stiff else None,
                    dense_output=marks is None and stiff,
                )
            if not piece.success or not np.all(np.isfinite(piece.y)):
                raise UsageError(f"the reference cannot follow this trajectory: {piece.message}")
            begin = 0 if inside is not None else 1
            if piece.sol is not None:
                piece.t = straightened(piece.t, piece.sol)
                piece.y = piece.sol(piece.t)
            whole, rows = [*whole, piece.t[begin:]], [*rows, piece.y[:, begin:]]
            work += piece.nfev
        return np.hstack(whole), np.hstack(rows), work

    def rough(self, rtol: float) -> tuple[Array, Array, int]:
        """Return the ends of the steps of a run, sizes (2 n,) of states, and evaluations."""
        ends, coarse, work = self(rtol, rtol / 10)
        sizes = run_sizes(coarse, self.end - self.start, self.state)
        return ends, with_companions(self.dynamics, sizes), work


def straightened(nodes: Array, path: Callable[[Array], Array]) -> Array:
    """Return nodes (k,) divided so that hardly any state bends between two of them.

    Gauss's steps are as long as the fastest motion's period: what rounding of the equations adds
    to a vibration in time with itself would average out over such an interval.
    """
    parts = 1
    while True:
        fine = np.interp(np.arange((len(nodes) - 1) * 2 * parts + 1) / (2 * parts),
                         np.arange(len(nodes)), nodes)  # fmt: skip
        x = path(fine)
        bend = np.abs(x[:, 1::2] - (x[:, :-1:2] + x[:, 2::2]) / 2)
        size = np.max(np.abs(x), axis=1, keepdims=True)
        if parts == OPTIONS.max_parts or np.all(bend <= OPTIONS.straight * size):
            return fine[::2]
        parts *= 2


def with_companions(dynamics: Dynamics, sizes: Array) -> Array:
    """Return sizes (2 n,) of states, those of a continuum's coordinates the largest of their unit.

    The one that stretches least would else set the step: by waves along a beam, which no one sees.
    Where there are no waves, each has its own; in a quaternion it is no less than a share of the
    largest: one of the size of round-off would otherwise set the step.
    """
    names, sizes = dynamics.state_names, sizes.copy()
    for one in dynamics.quaternions:
        for end in ("", "_dot"):
            rows = [names.index(name + end) for name in one.coordinates]
            sizes[rows] = np.maximum(sizes[rows], OPTIONS.min_quaternion_size * np.max(sizes[rows]))
    if not dynamics.continuum.has_waves:
        return sizes
    inner = {*dynamics.discretisation_coordinates}
    units = [dynamics.units[name] if name.removesuffix("_dot") in inner else name for name in names]
    largest: dict[str, float] = {}
    for unit, size in zip(units, sizes, strict=True):
        largest[unit] = max(largest.get(unit, 0.0), float(size))
    return np.array([largest[unit] for unit in units])
