"""A setup: a bound model with a case, a method and its step; its runs, and their guard.

Engines fail silently; what `run` returns has not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...reference import get_scene
from ...reference.amplification import AMPLIFICATION
from ...reference.errors import EngineError, MbcheckError, NoOrbitError, UsageError
from ...reference.linear import linearise, modes
from ...reference.scene import Array, Case, Scene
from .adapter import Adapter, BoundModel
from .protocol import Method
from .run import (
    EPS,
    NOTES,
    Console,
    Trajectory,
    append_console_tail,
    attempt,
    call_engine,
    grid_indices,
    noting,
)

STEPS_PER_PERIOD = {1: 800, 2: 300, 3: 150, 4: 100, 5: 60, 6: 40}
"""Steps in the shortest period of a scene, by order of the method."""

MAX_ROTATION_RATIO = 20.0
"""Rotation rates above this multiple of all other rates do not set the step unless they can be
reached: a motor with hardly any damper takes long to its working speed."""

ANGLES = 16
"""Angles of a turn at which the largest acceleration is sought."""

STIFF = 0.5
"""Longest step times the fastest rate of a model's closure: a quarter of the stability limit of
explicit methods."""

TRIAL_STEPS = 16
"""Steps of the two short runs that tell remainder steps from shorter steps."""

SAME, LEAST_SIZE = 1e-9, 1e-3
"""Largest relative difference of the ends of these runs, and the least size (SI) of an observable
that it is relative to."""

REMAINDER_STEPS = (
    "the engine counts remainder steps to times that its clock misses by round-off: no fault"
)


@dataclass(frozen=True)
class Setup:
    """An engine's model of a case, `bound` to its parameters, with a method and its step.

    Attributes
    ----------
    engine : Adapter
    case : Case
    model : str
        One of the engine's models of the case's scene.
    method : Method or None
        None where nothing is integrated.
    step : float or None
        Step [s]; None for `default_step`.
    """

    engine: Adapter
    case: Case
    model: str
    method: Method | None = None
    step: float | None = None

    @cached_property
    def scene(self) -> Scene:
        """The scene of the case."""
        return get_scene(self.case.scene)

    @cached_property
    def integrator(self) -> Method:
        """The method, of a setup that integrates.

        Raises
        ------
        UsageError
            If it has none.
        """
        if self.method is None:
            raise UsageError(f"{self.engine.name} {self.model} was given no method to integrate by")
        return self.method

    @cached_property
    def epsilon(self) -> float:
        """Distance from 1 to the next of the numbers that the method, or the engine, has."""
        own = self.method.precision if self.method else None
        return float(np.finfo(own or self.engine.precision).eps)

    @cached_property
    def step_size(self) -> float:
        """Step [s]: the one that was set, or the default."""
        return self.default_step if self.step is None else self.step

    @cached_property
    def bound(self) -> BoundModel:
        """The engine's model, with the parameters of the case."""
        return self.engine.bind(self.case, self.model)

    @cached_property
    def scheme(self) -> str | None:
        """The published scheme that the method is on this model, None if it is none."""
        return self.bound.scheme(self.integrator)

    @cached_property
    def linear_scheme(self) -> str | None:
        """The scheme of `AMPLIFICATION` that the method is on free vibrations of the model."""
        if self.bound.approximates_continuum:
            return None
        scheme = self.integrator.linear_scheme or self.integrator.scheme
        return scheme if scheme in AMPLIFICATION else None

    @cached_property
    def default_step(self) -> float:
        """A step [s] for the method: a power of two, so that no clock has to round."""
        return default_step(self.case, self.integrator, self.stable_step_bound)

    @cached_property
    def stable_step_bound(self) -> float:
        """The longest step [s] for the equations of a closure; a continuum sets none."""
        equations = self.bound.equations
        if equations.scene is self.scene or equations.scene.continuum.refined:
            return np.inf
        start = equations.start(self.case)
        matrices = linearise(equations.scene, equations.parameters, start)
        return STIFF / max(mode.omega for mode in modes(*matrices))

    @cached_property
    def unsupported_reason(self) -> str | None:
        """Why the engine cannot run this, or None."""
        return self.bound.unsupported_reason(self.case, self.method)

    def with_case(self, case: Case) -> Setup:
        """Return the setup of another case."""
        return replace(self, case=case)

    def with_step(self, step: float) -> Setup:
        """Return the setup with a step [s]."""
        return replace(self, step=step)

    def with_option(self, name: str, value: float) -> Setup:
        """Return the setup with an option of its engine set."""
        return replace(self, engine=self.engine.with_option(name, value))

    def with_segments(self, factor: float) -> Setup:
        """Return the setup with so many times the segments of a continuum."""
        p = self.case.parameters
        segments = max(2, round(factor * p.segments))
        return self.with_case(replace(self.case, parameters=p.replace(segments=segments)))

    def simulate(self, step: float, samples: Any) -> Trajectory:
        """Run the engine with a step [s] and record it at these step numbers, see `run`."""
        return run(self.with_step(step), self.case.start_time + samples * step)


def power_of_two(most: float) -> float:
    """Return the largest power of two up to a number; no clock has to round it."""
    return float(2.0 ** np.floor(np.log2(most)))


def default_step(case: Case, method: Method, bound: float = np.inf) -> float:
    """Return a step [s] for a method, not above a bound [s].

    It is a power of two, or where that would step over the end of a drive a fraction of the time
    until then.
    """
    order = min(method.order, max(STEPS_PER_PERIOD))
    step = power_of_two(min(shortest_period(case) / STEPS_PER_PERIOD[order], bound))
    end = float(get_scene(case.scene).drive_end_time(case.parameters)) - case.start_time
    return step if end <= 0 or end % step == 0 else end * power_of_two(step / end)


@lru_cache(maxsize=64)
def shortest_period(case: Case) -> float:
    """Return the shortest of the orbit's period and the natural periods [s]."""
    scene = get_scene(case.scene)
    whole = 2 * np.pi / float(scene.period(case.parameters))
    if scene.discretisation_coordinates:  # whose modes have no end
        return 2 * np.pi / whole
    omega: list[float] = []
    for place in scene.equilibria.values():
        try:
            state = scene.state(place(case.parameters))
        except NoOrbitError:
            continue
        mass, _, stiffness = linearise(scene, case.parameters, state)
        omega += [mode.omega for mode in modes(mass, 0 * mass, stiffness)]
    omega += [abs(case.state.get(f"{name}_dot", 0.0)) for name in scene.rotations_per_period]
    omega.append(scene.turning_speed(scene.state(case.state)))
    others = max(omega)
    if not scene.drive and whole > MAX_ROTATION_RATIO * others > 0:
        whole = min(whole, max(others, reachable_speed(case)))
    return 2 * np.pi / max(whole, others)


def reachable_speed(case: Case) -> float:
    """Return an upper estimate of the speed of a coordinate within the horizon of a case [rad/s].

    The largest acceleration over a turn, at the initial speed, acts for the whole time.
    """
    scene = get_scene(case.scene)
    slopes, start = scene.right_hand_side(case.parameters), scene.state(case.state)
    n = len(scene.coordinates)
    turns = np.linspace(0, 2 * np.pi, ANGLES, endpoint=False)
    states = np.array([np.concatenate([start[:n] + turn, start[n:]]) for turn in turns])
    faster = [np.max(np.abs(slopes(case.start_time, state)[n:])) for state in states]
    return float(np.max(np.abs(start[n:])) + max(faster) * case.horizon)


def guard(
    trajectory: Trajectory, setup: Setup, times: Array, remainder_steps: int | None = None
) -> None:
    """Refuse a run of a setup that failed silently.

    Parameters
    ----------
    trajectory : Trajectory
    setup : Setup
        With the step of the run.
    times : array (n_t,)
        The requested times [s].
    remainder_steps : int, optional
        Most additional steps that may be remainders; by default `count_remainder_steps`.

    Raises
    ------
    EngineError
        Named by its kind: ``shape``, ``names``, ``warning``, ``non_finite``, ``clock``,
        ``clock_reversed``, ``step_count``, ``work_count``, ``inputs_changed`` or ``branch``.
    """
    expected = np.asarray(times, dtype=float)
    case, step, values = setup.case, setup.step_size, trajectory.values
    if not np.array_equal(trajectory.times, expected):
        raise EngineError("shape", "the engine did not return the requested times")
    for name, rows in values.items():
        if np.shape(rows) != expected.shape:
            raise EngineError(
                "shape", f"{name} has shape {np.shape(rows)}, expected {expected.shape}"
            )
    for name, count in trajectory.warnings.items():
        if count:
            raise EngineError("warning", f"the engine's warning counter {name} is {count}")
    for name, rows in values.items():
        bad = np.flatnonzero(~np.isfinite(rows))
        if bad.size:
            raise EngineError(
                "non_finite",
                f"{name} is {rows[bad[0]]} at t = {expected[bad[0]]:.6g} s: the run is unstable; "
                "try a smaller step",
            )
    clock = trajectory.clock
    back = np.flatnonzero(np.diff(clock) < 0)
    if back.size:
        raise EngineError(
            "clock_reversed",
            f"the engine's clock decreased from {clock[back[0]]:.9g} s to "
            f"{clock[back[0] + 1]:.9g} s: the simulation was reset",
        )
    requested = round((expected[-1] - case.start_time) / step)
    slack = setup.epsilon * max(requested, 1) * np.maximum(np.abs(expected), step)
    late = np.flatnonzero(~(np.abs(clock - expected) <= slack))
    if late.size:
        raise EngineError(
            "clock",
            f"the engine's clock shows {clock[late[0]]:.17g} s at t = {expected[late[0]]:.17g} s: "
            "stop at the requested times",
        )
    refuse_other_steps(trajectory, setup, requested, remainder_steps)
    if trajectory.changed_inputs:
        raise EngineError(
            "inputs_changed",
            f"the engine changed its inputs: {', '.join(trajectory.changed_inputs)}",
        )
    missing = set(setup.scene.observables) - set(values)
    if missing:
        raise EngineError("names", f"the engine returned no {', '.join(sorted(missing))}")
    if setup.scene.assembled is not None:
        apart = np.flatnonzero(~setup.scene.assembled(values, case.parameters))
        if apart.size:
            raise EngineError(
                "branch",
                f"at t = {expected[apart[0]]:.6g} s the loop has switched to its other assembly "
                "branch: the engine went through a singular position; try a smaller step",
            )


def refuse_other_steps(
    trajectory: Trajectory, setup: Setup, requested: int, remainder_steps: int | None
) -> None:
    """Refuse a run whose counts show other steps than requested, remainder steps apart.

    Raises
    ------
    EngineError
        ``step_count`` or ``work_count``.
    """
    more, work = trajectory.steps - requested, trajectory.rhs_evaluations
    evaluations, few, beyond = setup.integrator.evaluations_per_step, False, 0.0
    if evaluations is not None and work is not None:
        few = work < evaluations * (requested - 1)
        # one to start with, one for each sample
        beyond = max(0.0, (work - len(trajectory.times)) / evaluations - requested - 1)
    if not (more or few or beyond):
        return
    if remainder_steps is None:
        extra = more > 0 or beyond
        remainder_steps = count_remainder_steps(setup, trajectory.times) if extra else 0
    if not 0 <= more <= remainder_steps:
        raise EngineError(
            "step_count",
            f"the engine took {trajectory.steps} steps, {requested} were requested: count the "
            "steps of this run, each of the given size, or leave Motion.steps out",
        )
    if few or beyond > remainder_steps:
        raise EngineError(
            "work_count",
            f"the engine evaluated forces {work} times, {(evaluations or 0) * requested} "
            f"make {requested} steps of {evaluations} each: it takes other steps than requested",
        )
    NOTES.get({})[REMAINDER_STEPS] = None


def count_remainder_steps(setup: Setup, times: Array) -> int:
    """Return the most steps of a run (n_t times) that may be remainders of others.

    A clock that adds up its steps misses a sample time by round-off, and the remainder takes a step
    by itself: one for each such time, whatever lies between them. So a run with one sample has
    one at most, and ends where a run with many ends. An engine that halves its steps, or takes one
    more from sample to sample, differs in one of these: then 0.
    """
    most = off_grid_times(setup, times)
    if not most:
        return 0
    case, method, step = setup.case, setup.integrator, setup.step_size
    ends: list[Array] = []
    grid = np.asarray(case.start_time + step * np.arange(1, TRIAL_STEPS + 1), dtype=float)
    for samples in (grid[-1:], grid):
        try:
            short = call_engine(partial(setup.bound.simulate, case, method, step, samples))
            with noting():
                guard(short, setup, samples, off_grid_times(setup, samples))
        except MbcheckError:
            return 0
        values = short.matrix(setup.scene.observables)
        ends.append(values[:, -1])
    sizes = np.maximum(np.max(np.abs(values), axis=1), LEAST_SIZE)
    alike = max(SAME, 8 * TRIAL_STEPS * setup.epsilon)
    return most if np.all(np.abs(ends[1] - ends[0]) <= alike * sizes) else 0


def off_grid_times(setup: Setup, times: NDArray[Any]) -> int:
    """Return the number of times (n_t,) that a clock misses by round-off as it adds up steps."""
    if setup.epsilon > EPS:  # its sums are not those of this machine
        return len(times)
    start, step = setup.case.start_time, setup.step_size
    places = [start, *map(float, times)]
    counts = np.diff(grid_indices(times, start, step), prepend=0)
    return sum(
        float(np.cumsum([before, *np.full(count, step)])[-1]) != after
        for before, after, count in zip(places, places[1:], counts, strict=False)
    )


def run(setup: Setup, times: Array) -> Trajectory:
    """Simulate with the setup's method and step inside the container, and guard the result.

    Raises
    ------
    EngineError
        If the engine raised, or the guard refused its result.
    UsageError
        If times are off the engine's grid.
    """
    case, method, step = setup.case, setup.integrator, setup.step_size
    times = np.asarray(times, dtype=float)
    grid_indices(times, case.start_time, step)

    def simulate() -> tuple[Trajectory, float]:
        begin = perf_counter()
        trajectory = setup.bound.simulate(case, method, step, times)
        return trajectory, perf_counter() - begin

    console = Console()
    trajectory, seconds = call_engine(simulate, console)
    try:
        guard(trajectory, setup, times)
    except EngineError as error:
        raise EngineError(error.kind, append_console_tail(error.message, console.text)) from error
    return trajectory if trajectory.seconds else replace(trajectory, seconds=seconds)


def run_many(
    setup: Setup, cases: Sequence[Case], steps: Array, times: Array
) -> list[Trajectory | EngineError]:
    """Simulate many cases of a scene in one container; errors are returned.

    Parameters
    ----------
    setup : Setup
        Its case and its step are not used.
    cases : sequence of Case, k of them
    steps : array (k,) [s]
    times : array (k, n_t) [s]
        As many steps from one to the next in every case.
    """
    rows = list(zip(cases, steps.tolist(), times, strict=True))
    for case, step, grid in rows:
        grid_indices(grid, case.start_time, step)

    def simulate(case: Case, step: float, grid: Array) -> Trajectory:
        own = setup.with_case(case).with_step(step)
        trajectory = own.bound.simulate(case, setup.integrator, step, grid)
        guard(trajectory, own, grid)
        return trajectory

    return call_engine(lambda: [attempt(partial(simulate, *row)) for row in rows])
