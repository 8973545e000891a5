"""Reference solutions of model equations, with bounds on their errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...reference import get_scene
from ...reference.differences import by_complex_step
from ...reference.equations import ModelEquations
from ...reference.errors import CannotJudgeError, MbcheckError
from ...reference.scene import Array, Case, Scene
from ...reference.solve.batched import growths, solve_many
from ...reference.solve.single import solve
from ...reference.solve.solution import Solution, state_size
from ..engines.run import EPS, VIOLATIONS
from ..engines.setup import power_of_two

MOST_STEPS = 1 << 13
"""Longer runs with a method's default step are cut: mistakes show before. An eighth of it where the
error is predicted by runs with half and a quarter of the step, unless the scene's bodies bend,
which takes long to show: then none is cut of cases for `--full`."""

SAMPLES = 256
"""Least number of times over a case's horizon at which its reference is kept."""

MOST_AMPLIFICATION = 1e5
"""Horizons are cut so that an initial error grows by no more than this."""

MOST_ROUNDING = 1e-2
"""Horizons are cut so that round-off stays below this share of a quantity's size."""

VIBRATION_GROWTH = 1e3
"""Growth factor of an initial error of a beam over its case, in the sizes of its states: 741 by the
variational equations of its spin-up, which cost too much to be solved in each case."""

RATIO, WORST_RATIO = 0.5, 0.9
"""Least and largest part of a refinement's change that the next one is taken to make."""

SMOOTH = 1e-5
"""Change of a refinement, relative to the size, below which it is the last."""

ROUGH = (1e-6, 1e-5)
"""Tolerances of solutions from which only the size of a motion is used."""

STILL = 1e-9
"""A coordinate that changes by less (SI, or relative to its largest value) does not move."""

MARKS = 8
"""Places where a horizon may be cut."""

SHARP = 1e-14
"""Relative tolerance of solutions down to round-off."""

RANDOM_STATES = 16
SEED = 2011


@dataclass(frozen=True)
class Truth:
    """The solution of model equations at sample times, as rows of observables.

    Attributes
    ----------
    times : array (n_t,)
    values : array (k, n_t)
    bound : array (k,)
        On the error of the reference.
    size : array (k,)
        To which errors are related.
    scale : array (k,)
        To which rounding is related: of a displacement, which is the difference of two positions,
        the size of these.
    states : array (2 n, n_t)
        In the coordinates of these equations.
    """

    times: Array
    values: Array
    bound: Array
    size: Array
    scale: Array
    states: Array

    def at(self, places: NDArray[np.intp]) -> Truth:
        """Return it at some of its times; bounds and sizes remain those of all."""
        return replace(
            self,
            times=self.times[places],
            values=self.values[:, places],
            states=self.states[:, places],
        )


def rows(equations: ModelEquations, states: Array, names: tuple[str, ...]) -> Array:
    """Return observables (k, n_t) of states (2 n, n_t) by model equations; unknown ones are 0."""
    observables = equations.scene.observe(states, equations.parameters)
    values = (observables.get(name, 0.0) for name in names)
    return np.array([np.broadcast_to(value, states.shape[1:]) for value in values])


def rounding(steps: float, growth: float, epsilon: float = EPS) -> float:
    """Relative error that rounding may leave after so many steps, errors growing so much.

    ``epsilon`` is `Setup.epsilon`.
    """
    return 8 * epsilon * (16 + steps) * max(growth, 1.0)


def sample_spacing(horizon: float) -> float:
    """Return the spacing [s] of the times at which a case's reference is kept.

    A power of two, as steps are, so that all methods can be sampled at some of them.
    """
    return power_of_two(horizon / SAMPLES)


@lru_cache(maxsize=128)
def _solution(
    equations: ModelEquations, state: tuple[float, ...], start: float, times: tuple[float, ...]
) -> Solution:
    return solve(equations.scene, equations.parameters, np.array(state), np.array(times), start)


def _solved(
    equations: ModelEquations,
    state: tuple[float, ...],
    start: float,
    times: Array,
    horizon: float | None,
) -> Solution:
    """Solve at the times alone, or on the grid of a horizon [s] where they lie on it."""
    if horizon is not None:
        spacing = sample_spacing(horizon)
        numbers = np.rint((times - start) / spacing).astype(int)
        on_grid = np.array_equal(start + spacing * numbers, times)
        if on_grid and numbers[0] >= 1 and numbers[-1] * spacing <= horizon:
            grid = start + spacing * np.arange(1, int(horizon / spacing) + 1)
            whole = _solution(equations, state, start, tuple(grid.tolist()))
            return replace(whole, times=times, states=whole.states[:, numbers - 1])
    return _solution(equations, state, start, tuple(times.tolist()))


@lru_cache(maxsize=256)
def _truth(
    equations: ModelEquations,
    state: tuple[float, ...],
    start: float,
    times: tuple[float, ...],
    horizon: float | None,
    names: tuple[str, ...],
) -> Truth:
    def solved(one: ModelEquations, at: tuple[float, ...]) -> Solution:
        return _solved(one, at, start, np.array(times), horizon)

    return truncated(
        equations, state, truth_of(equations, solved(equations, state), names), names, solved
    )


def truncated(
    equations: ModelEquations,
    state: tuple[float, ...],
    solution: Truth,
    names: tuple[str, ...],
    solved: Callable[[ModelEquations, tuple[float, ...]], Solution],
) -> Truth:
    """Return a solution whose bound counts what all other coordinates of a continuum change.

    Each refinement is taken to change `RATIO` times as much as the last one. Further ones are
    computed only if a short drive excites coordinates that the first leaves out: then the ratio is
    measured.
    """
    values = dict(zip(equations.scene.state_names, state, strict=True))
    coarse, bound, changes = solution, solution.bound, [np.zeros(len(names))]
    scene: Any = equations.scene
    while scene.continuum.refined is not None:
        scene = scene.continuum.refined
        finer = ModelEquations(scene, equations.parameters)
        same = scene.embedding(equations.parameters, values)
        at = tuple(same.get(name, 0.0) for name in scene.state_names)
        other = truth_of(finer, solved(finer, at), names)
        changes.append(np.max(np.abs(other.values - coarse.values), axis=1))
        coarse, bound = other, bound + other.bound + changes[-1]
        if np.all(changes[-1] <= SMOOTH * solution.size):
            break
    before, last = changes[-2:] if len(changes) > 1 else (changes[0], changes[0])
    measured = np.divide(last, before, out=np.full_like(last, RATIO), where=before > 0)
    ratio = np.clip(measured, RATIO, WORST_RATIO)
    return replace(solution, bound=bound + last * ratio / (1 - ratio))


def truth_of(equations: ModelEquations, solution: Solution, names: tuple[str, ...]) -> Truth:
    """Return a solution as rows of observables; bounds of outputs follow from the states'."""
    scene, parameters = equations.scene, equations.parameters
    observables = scene.observe(solution.states, parameters)
    units = dict(zip(VIOLATIONS, ("m", "m/s"), strict=True)) | dict(scene.units)
    bounds = dict(zip(scene.state_names, solution.error_bound, strict=True))
    sizes = dict(zip(scene.state_names, state_size(solution), strict=True))
    scales = dict(sizes)
    for name in set(observables) - set(sizes):
        sizes[name] = float(np.max(np.abs(observables[name]))) or 1.0
        # it may be the difference of two positions, or of their rates
        positions = scene.continuum.reach(parameters)
        if scene.units.get(name) != "m":
            speeds = [observables[f"{turns}_dot"] for turns in scene.rotations_per_period]
            positions *= max((float(np.max(np.abs(speed))) for speed in speeds), default=0.0)
        scales[name] = max(sizes[name], positions)
        bounds[name] = 8 * EPS * scales[name]
    outputs = tuple(set(observables) - set(scene.state_names))
    slopes: Any = ()
    if outputs:
        slopes = by_complex_step(lambda x: rows(equations, x, outputs), solution.states)[1]
    for name, slope in zip(outputs, slopes, strict=True):
        bounds[name] += float(np.max(np.abs(slope), axis=1) @ solution.error_bound)
    for name in set(names) & set(VIOLATIONS):
        sizes[name] = max(
            (sizes[other] for other in sizes if other not in VIOLATIONS
             and units[other] == units[name]), default=1.0,
        )  # fmt: skip
    zero = np.zeros(len(solution.times))
    return Truth(
        times=solution.times,
        values=np.array([observables.get(name, zero) for name in names]),
        bound=np.array([bounds.get(name, 0.0) for name in names]),
        size=np.array([sizes[name] for name in names]),
        scale=np.array([max(sizes[name], scales.get(name, 0.0)) for name in names]),
        states=solution.states,
    )


def moves(coordinates: Array) -> bool:
    """Return True if one of the coordinates (n, n_t) of a solution changes, rounding apart."""
    still = STILL * (1 + np.max(np.abs(coordinates), axis=1))
    return bool(np.any(np.ptp(coordinates, axis=1) > still))


def truth(equations: ModelEquations, case: Case, times: Any, names: tuple[str, ...]) -> Truth:
    """Return the solution of a case; remembered within a process."""
    state = tuple(float(value) for value in equations.start(case))
    times = tuple(float(t) for t in times)
    return _truth(equations, state, case.start_time, times, permitted_horizon(case)[0], names)


def truth_to_the_end(
    equations: ModelEquations, state: Array, start: float, times: Array, names: tuple[str, ...]
) -> Truth:
    """Return the solution from a state, with its bound, however errors grow."""
    return _truth(equations, tuple(state.tolist()), start, tuple(times.tolist()), None, names)


def sizes(equations: ModelEquations, case: Case, times: Array, names: tuple[str, ...]) -> Array:
    """Return the sizes (k,) of states of a case, of a continuum roughly: its solution is dear."""
    if not equations.scene.discretisation_coordinates:
        return truth(equations, case, times, names).size.copy()
    rough = _roughly(equations, tuple(equations.start(case)), case.start_time, tuple(times))
    known = dict(zip(equations.scene.state_names, state_size(rough), strict=True))
    return np.array([known[name] for name in names])


@lru_cache(maxsize=64)
def _roughly(
    equations: ModelEquations, state: tuple[float, ...], start: float, times: tuple[float, ...]
) -> Solution:
    return solve(*equations, np.array(state), times, start, tolerances=ROUGH)


def roundoff_reference(
    equations: ModelEquations, case: Case, times: Array, names: tuple[str, ...]
) -> Truth:
    """Return the solution over a short time, down to round-off unless it is stiff."""
    return after_starts(equations, [case], times - case.start_time, names)


def after_starts(
    equations: ModelEquations,
    cases: Sequence[Case],
    after: Any,
    names: tuple[str, ...],
    tolerance: float = SHARP,
) -> Truth:
    """Return the same (k, n m) some times (m,) [s] after each of n starts, solved together.

    A relative tolerance larger than `SHARP` saves the steps that fight with round-off.
    """
    begins = [one.start_time for one in cases]
    columns = map(tuple, np.add.outer(np.atleast_1d(after), begins).T.tolist())
    states = (tuple(map(float, equations.start(one))) for one in cases)
    each = tuple(zip(states, begins, columns, strict=True))
    solutions = (
        [_truth(equations, state, begin, column, column[-1] - begin, names)
         for state, begin, column in each]
        if equations.scene.stiff
        else _sharp(equations, each, names, tolerance)
    )  # fmt: skip
    return Truth(
        times=np.concatenate([one.times for one in solutions]),
        values=np.hstack([one.values for one in solutions]),
        bound=np.max([one.bound for one in solutions], axis=0),
        size=np.max([one.size for one in solutions], axis=0),
        scale=np.max([one.scale for one in solutions], axis=0),
        states=np.hstack([one.states for one in solutions]),
    )


@lru_cache(maxsize=64)
def _sharp(
    equations: ModelEquations,
    each: tuple[tuple[tuple[float, ...], float, tuple[float, ...]], ...],
    names: tuple[str, ...],
    tolerance: float,
) -> tuple[Truth, ...]:
    states, begins, times = (np.array(values).T for values in zip(*each, strict=True))
    start = begins if len(each) > 1 else float(begins[0])
    solution = solve_many(equations.scene, equations.parameters, states, times, start, tolerance)
    return tuple(
        truth_of(
            equations,
            replace(
                solution,
                times=times[:, i],
                states=solution.states[:, i],
                error_bound=solution.error_bound[:, i],
            ),
            names,
        )
        for i in range(len(each))
    )


@lru_cache(maxsize=64)
def _permitted(
    scene: Scene,
    parameters: Any,
    state: tuple[float, ...],
    start: float,
    horizon: float,
    rounding_rate: tuple[float, float],
) -> tuple[float, float]:
    step, epsilon = rounding_rate
    for _ in range(4):
        times = start + horizon * np.arange(1, MARKS + 1) / MARKS
        growth = growths(scene, parameters, np.array(state), times, start)
        steps = (times - start) / step
        lost = np.array([rounding(*one, epsilon) for one in zip(steps, growth, strict=True)])
        tolerable = np.flatnonzero((growth <= MOST_AMPLIFICATION) & (lost <= MOST_ROUNDING))
        if tolerable.size:
            last = int(tolerable[-1])
            return float(times[last] - start), float(growth[last])
        horizon /= MARKS
    kind = MbcheckError if epsilon == EPS else CannotJudgeError
    raise kind(
        f"errors grow by a factor of {growth[0]:.3g} within {horizon:.3g} s: no trajectory can be "
        "compared"
    )


def permitted_horizon(
    case: Case, step: float = np.inf, epsilon: float = EPS
) -> tuple[float, float]:
    """Return the horizon [s] that error growth permits, and the amplification over it.

    Round-off of the steps [s], with unit ``epsilon``, must stay small enough as well.
    """
    scene = get_scene(case.scene)
    if scene.discretisation_coordinates:
        return case.horizon, VIBRATION_GROWTH
    state = tuple(scene.state(case.state))
    rate = (step, epsilon) if epsilon > EPS else (np.inf, EPS)
    return _permitted(scene, case.parameters, state, case.start_time, case.horizon, rate)


def simulated_horizon(case: Case, step: float, scheme: str | None, epsilon: float = EPS) -> float:
    """Return the part of the permitted horizon [s] simulated with this step."""
    horizon, _ = permitted_horizon(case, step, epsilon)
    if get_scene(case.scene).discretisation_coordinates:
        return horizon if case.full_only else min(horizon, MOST_STEPS * step)
    return min(horizon, (MOST_STEPS if scheme else MOST_STEPS // 8) * step)


def random_states(
    equations: ModelEquations, case: Case, names: tuple[str, ...]
) -> tuple[Array, Array]:
    """Return times (k,) and states (k, 2 n) of coordinates, of the size that the motion has."""
    scene = equations.scene
    horizon, _ = permitted_horizon(case)
    spacing = sample_spacing(horizon)
    times = np.asarray(case.start_time + spacing * np.arange(1, int(horizon / spacing) + 1), float)
    states = (*names, *(f"{name}_dot" for name in names))
    size = sizes(equations, case, times, states)
    size[[i for i, name in enumerate(names) if name in scene.rotations_per_period]] = np.pi
    random = np.random.default_rng(SEED)
    period = float(scene.period(case.parameters))
    moments = period * random.random(RANDOM_STATES)
    drawn = size * random.uniform(-1, 1, (RANDOM_STATES, len(size)))
    return moments, scene.on_unit_quaternions(drawn) if names == scene.coordinates else drawn
