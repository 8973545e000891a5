"""One run of an engine: the container around it, its result, and the guard that judges that.

Engines fail silently; what `run` returns has not.
"""

from __future__ import annotations

import importlib
import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import chdir, contextmanager, nullcontext, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from traceback import StackSummary, TracebackException
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...reference import get_scene
from ...reference.errors import EngineError, MbcheckError, UsageError
from ...reference.scene import Array, Case

if TYPE_CHECKING:
    from .setup import Setup

T = TypeVar("T")

EPS = float(np.finfo(float).eps)

VIOLATIONS = ("position_violation", "velocity_violation")
"""Largest residual of a closed loop's constraints [m], and of their rates [m/s]."""

OURS = f"{Path(__file__).resolve().parents[2]}{os.sep}"
"""Where the files of this package lie."""

LOADERS = ("<frozen importlib", importlib.__file__)
"""What the names of files begin with whose code imports modules."""

LONGEST_REASON, LONGEST_TRACEBACK = 300, 8000
"""Characters of what is told of an exception in a line, and of its traceback."""

MOST_STEPS = 2**31 - 1
"""Engines count their steps in 32 bits."""

TRIAL = 16
"""Steps of the two short runs that tell slivers from shorter steps."""

SAME, STILL = 1e-9, 1e-3
"""Difference of their ends that slivers do not explain, in the size of what is observed, and the
least of these sizes (SI)."""

SLIVERS = "the engine counts slivers of steps to times that are off its clock by rounding: no fault"

NOTES: ContextVar[dict[str, None]] = ContextVar("NOTES")
"""What was seen of runs that is no fault, each thing once, while `noting` is active."""


@dataclass(frozen=True)
class Trajectory:
    """What an engine returns; `guard` judges it before anyone reads it.

    Attributes
    ----------
    times : array (n_t,)
        Sample times [s].
    values : mapping of str to array (n_t,)
        Observables by name, SI units.
    clock : array (n_t,)
        The engine's own clock at the samples [s].
    steps : int
        Steps that the engine counted (not those it was asked for).
    rhs_evaluations : int or None
    newton_iterations : int or None
        Of an implicit method, or of a solver of constraints; all steps together.
    warnings : mapping of str to int
        The engine's warning counters; any that is not zero is a failure.
    changed : tuple of str
        Inputs that the engine changed on its own (controls, parameters, step).
    seconds : float
        Wall time of the stepping alone [s]; `run` puts that of the whole call where it is 0.
    """

    times: Array
    values: Mapping[str, Array]
    clock: Array
    steps: int
    rhs_evaluations: int | None = None
    newton_iterations: int | None = None
    warnings: Mapping[str, int] = field(default_factory=dict)
    changed: tuple[str, ...] = ()
    seconds: float = 0.0

    def matrix(self, names: tuple[str, ...]) -> Array:
        """Return the named observables as an array (n_names, n_t)."""
        return np.array([self.values[name] for name in names])


def guard(
    trajectory: Trajectory, setup: Setup, times: Array, slivers: Callable[[], int] | None = None
) -> None:
    """Refuse a run of a setup, with its step, that failed silently.

    ``slivers`` returns how many steps more than were asked for are slivers, at most; by default
    `most_slivers` finds out.

    Raises
    ------
    EngineError
        Named by its kind: ``shape``, ``names``, ``warning``, ``non_finite``, ``clock``,
        ``clock_reversed``, ``step_count``, ``work_count``, ``inputs_changed`` or ``branch``.
    """
    expected = np.asarray(times, dtype=float)
    case, step, evaluations = setup.case, setup.step_size, setup.integrator.evaluations
    if trajectory.times.shape != expected.shape or not np.array_equal(trajectory.times, expected):
        raise EngineError("shape", "the engine did not return the times that were asked for")
    for name, values in trajectory.values.items():
        if np.shape(values) != expected.shape:
            raise EngineError(
                "shape", f"{name} has shape {np.shape(values)}, expected {expected.shape}"
            )
    for name, count in trajectory.warnings.items():
        if count:
            raise EngineError("warning", f"the engine's warning counter {name} stands at {count}")
    for name, values in trajectory.values.items():
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise EngineError(
                "non_finite",
                f"{name} is {values[bad[0]]} at t = {expected[bad[0]]:.6g} s: the run is unstable; "
                "try a smaller step",
            )
    if np.any(np.diff(trajectory.clock) < 0):
        first = int(np.flatnonzero(np.diff(trajectory.clock) < 0)[0])
        raise EngineError(
            "clock_reversed",
            f"the engine's clock went back from {trajectory.clock[first]:.9g} s to "
            f"{trajectory.clock[first + 1]:.9g} s: it reset itself",
        )
    asked = round((expected[-1] - case.start_time) / step)
    slack = setup.epsilon * max(asked, 1) * np.maximum(np.abs(expected), step)
    late = np.flatnonzero(~(np.abs(trajectory.clock - expected) <= slack))
    if late.size:
        raise EngineError(
            "clock",
            f"the engine's clock shows {trajectory.clock[late[0]]:.17g} s at "
            f"t = {expected[late[0]]:.17g} s: stop at the times that are asked for",
        )
    slivers = slivers or partial(most_slivers, setup, expected)
    refuse_other_steps(trajectory, asked, evaluations, slivers)
    if trajectory.changed:
        raise EngineError(
            "inputs_changed", f"the engine changed its inputs: {', '.join(trajectory.changed)}"
        )
    scene = get_scene(case.scene)
    missing = set(scene.observables) - set(trajectory.values)
    if missing:
        raise EngineError("names", f"the engine returned no {', '.join(sorted(missing))}")
    if scene.assembled is not None:
        apart = np.flatnonzero(~scene.assembled(trajectory.values, case.parameters))
        if apart.size:
            raise EngineError(
                "branch",
                f"at t = {expected[apart[0]]:.6g} s the mechanism is put together the other way "
                "round: the engine went through a singular position; try a smaller step",
            )


def refuse_other_steps(
    trajectory: Trajectory, asked: int, evaluations: int | None, slivers: Callable[[], int]
) -> None:
    """Refuse a run whose counts tell of other steps than were asked for, slivers apart.

    Raises
    ------
    EngineError
        ``step_count`` or ``work_count``.
    """
    more, work = trajectory.steps - asked, trajectory.rhs_evaluations
    few, beyond = False, 0.0
    if evaluations is not None and work is not None:
        few = work < evaluations * (asked - 1)
        # one to start with, one for each sample
        beyond = max(0.0, (work - len(trajectory.times)) / evaluations - asked - 1)
    if not (more or few or beyond):
        return
    most = slivers() if more > 0 or beyond else 0
    if not 0 <= more <= most:
        raise EngineError(
            "step_count",
            f"the engine took {trajectory.steps} steps, {asked} were asked for: count "
            "those of this run, each of the step that is given, or leave Motion.steps out",
        )
    if few or beyond > most:
        raise EngineError(
            "work_count",
            f"the engine evaluated forces {work} times, {(evaluations or 0) * asked} "
            f"make {asked} steps of {evaluations} each: it takes other steps than asked",
        )
    NOTES.get({})[SLIVERS] = None


def most_slivers(setup: Setup, times: Array) -> int:
    """Return how many steps of a run (n_t times) may be slivers; 0 if the engine takes others.

    A clock that adds up its steps misses a sample time by rounding, and what is left takes a step
    of its own: one for each such time, whatever lies between them. So a run with one sample has
    one at most, and ends where a run with many ends. An engine that halves its steps, or takes one
    more from sample to sample, differs in one of these.
    """
    most = missed(setup, times)
    if not most:
        return 0
    grid = setup.case.start_time + setup.step_size * np.arange(1, TRIAL + 1)
    ends = []
    for samples in (grid[-1:], grid):
        try:
            short = short_run(setup, samples)
        except MbcheckError:
            return 0
        values = short.matrix(get_scene(setup.case.scene).observables)
        ends.append(values[:, -1])
    sizes = np.maximum(np.max(np.abs(values), axis=1), STILL)
    alike = max(SAME, 8 * TRIAL * setup.epsilon)
    return most if np.all(np.abs(ends[1] - ends[0]) <= alike * sizes) else 0


def short_run(setup: Setup, times: NDArray[Any]) -> Trajectory:
    """Return a run that has a sliver at most where a time is missed; nothing is noted of it.

    Raises
    ------
    MbcheckError
        If the engine fails, or the run has other steps.
    """
    case, method, step = setup.case, setup.integrator, setup.step_size
    room = missed(setup, times)
    short = call_engine(lambda: setup.engine.simulate(case, setup.model, method, step, times))
    with noting():
        guard(short, setup, times, lambda: room)
    return short


def missed(setup: Setup, times: NDArray[Any]) -> int:
    """Return how many times (n_t,) a clock may miss by rounding that adds up steps to each [s]."""
    if setup.epsilon > EPS:  # its sums are not those of this machine
        return len(times)
    start, step = setup.case.start_time, setup.step_size
    places = [start, *map(float, times)]
    counts = np.diff(grid_indices(times, start, step), prepend=0)
    return sum(
        float(np.cumsum([before, *np.full(count, step)])[-1]) != after
        for before, after, count in zip(places, places[1:], counts, strict=False)
    )


@contextmanager
def noting() -> Iterator[dict[str, None]]:
    """Lend what is noted of runs meanwhile, each thing once."""
    before = NOTES.set({})
    try:
        yield NOTES.get()
    finally:
        NOTES.reset(before)


IN_SIGHT: ContextVar[bool] = ContextVar("IN_SIGHT", default=False)
"""Whether the console of engines is the user's, as a debugger needs it."""


class Console:
    """What was written to standard output and error while `captured` was active."""

    text = ""


@contextmanager
def captured(console: Console | None = None) -> Iterator[Console]:
    """Capture what is written, from C code too, unless the console of engines is the user's."""
    console = console or Console()
    if IN_SIGHT.get():
        yield console
        return
    flush()
    with tempfile.TemporaryFile() as log:
        saved = os.dup(1), os.dup(2)
        os.dup2(log.fileno(), 1)
        os.dup2(log.fileno(), 2)
        try:
            yield console
        finally:
            flush()
            for target, copy in enumerate(saved, start=1):
                os.dup2(copy, target)
                os.close(copy)
            log.seek(0)
            console.text = log.read().decode(errors="replace").strip()


@contextmanager
def contained(console: Console | None = None) -> Iterator[Console]:
    """Run engine code in a temporary working directory, with the console captured."""
    with captured(console) as caught, tempfile.TemporaryDirectory() as folder, chdir(folder):
        yield caught


def flush() -> None:
    """Write out what Python buffers, unless an engine has closed or removed the streams."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError, ValueError):
            stream.flush()


def grid_indices(times: Array, start: float, step: float) -> Array:
    """Return the step number of each sample time.

    Raises
    ------
    UsageError
        If a time is not on the grid ``start + i step``; names the nearest that are.
    """
    position = (np.asarray(times, dtype=float) - start) / step
    index = np.rint(position)
    off = np.flatnonzero(np.abs(position - index) > 1e-9 * np.maximum(1.0, np.abs(index)))
    if off.size:
        low = np.floor(position[off[0]])
        raise UsageError(
            f"time {times[off[0]]:.12g} s is not on the grid of step {step:.12g} s; the nearest "
            f"that fit are {start + low * step:.12g} and {start + (low + 1) * step:.12g}"
        )
    if index[-1] > MOST_STEPS:
        raise UsageError(
            f"{index[-1]:.3g} steps of {step:.3g} s are more than an engine can count; choose a "
            "longer step"
        )
    if np.any(index < 0) or np.any(np.diff(index) <= 0):
        raise UsageError("times must increase and must not lie before the start of the run")
    return index.astype(int)


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
        trajectory = setup.engine.simulate(case, setup.model, method, step, times)
        return trajectory, perf_counter() - begin

    console = Console()
    trajectory, seconds = call_engine(simulate, console)
    try:
        guard(trajectory, setup.with_step(step), times)
    except EngineError as error:
        raise EngineError(error.kind, last_words(error.message, console.text)) from error
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
    for case, step, grid in zip(cases, steps, times, strict=True):
        grid_indices(grid, case.start_time, float(step))

    def simulate(case: Case, step: float, grid: Array) -> Trajectory:
        engine, method = setup.engine, setup.integrator
        return engine.simulate(case, setup.model, method, step, grid)

    rows = zip(cases, steps.tolist(), times, strict=True)
    results = call_engine(lambda: [attempt(partial(simulate, *row)) for row in rows])
    for i, result in enumerate(results):
        if isinstance(result, EngineError):
            continue
        try:
            guard(result, setup.with_case(cases[i]).with_step(float(steps[i])), times[i])
        except EngineError as error:
            results[i] = error
    return results


def call_engine(
    work: Callable[[], T], console: Console | None = None, container: Callable[..., Any] = contained
) -> T:
    """Return what a call of an engine returns, made inside the container.

    Raises
    ------
    EngineError
        ``raised``, for whatever an engine raises that is no error of mbcheck's own.
    """
    console = console or Console()
    try:
        with container(console):
            return work()
    except MbcheckError:
        raise
    except (Exception, SystemExit) as error:  # whatever an engine raises is a verdict, not a crash
        raise engine_error(error, console.text) from error


def attempt(work: Callable[[], Any]) -> Any:
    """Return what some work returns, or the `EngineError` that `run` makes of a failure."""
    try:
        return call_engine(work, container=nullcontext)
    except EngineError as error:
        return error


def engine_error(error: BaseException, console: str = "") -> EngineError:
    """Return the `EngineError` of an exception of foreign code, and what it had printed."""
    parts = [traceback_of(error), console and f"its console:\n{console}"]
    traceback = excerpt("\n\n".join(filter(None, parts)))
    return EngineError("raised", describe(error, console), traceback)


def describe(error: BaseException, console: str) -> str:
    """Return one line about an exception, with the last line of the engine's console.

    A first line that ends in a colon only announces the reason.
    """
    lines = (str(error).strip() or "no message").splitlines()
    reason = " ".join(lines[:2]) if lines[0].endswith(":") else lines[0]
    return last_words(in_sight(f"{type(error).__name__}: {reason}", LONGEST_REASON), console)


def traceback_of(error: BaseException) -> str:
    """Return the traceback of an exception, from the first line on that is not ours."""
    try:
        whole = TracebackException.from_exception(error)
        without_callers(whole)
        return excerpt("".join(whole.format()))
    except BaseException:  # of whatever the exception is made of
        return ""


def without_callers(whole: TracebackException) -> None:
    """Leave out of a traceback, and of those that led to it, how foreign code was called."""
    parts = [whole]
    for part in parts:
        del part.stack[: callers(part.stack)]
        parts += filter(None, (part.__cause__, part.__context__))


def callers(stack: StackSummary) -> int:
    """Return how many frames of a stack stand before foreign code; 0 if there is none of it."""
    inside = [frame.filename.startswith((OURS, *LOADERS)) for frame in stack]
    return 0 if all(inside) else inside.index(False)


def excerpt(traceback: object) -> str:
    """Return a traceback as it is shown, whatever a foreign process has sent in its place."""
    lines = without_middle(f"{traceback}", 2 * LONGEST_TRACEBACK).split("\n")
    return without_middle("\n".join(map(in_sight, lines)), LONGEST_TRACEBACK).rstrip()


def in_sight(text: str, most: int = 2 * LONGEST_TRACEBACK) -> str:
    """Return text of at most so many characters, with escapes for what a terminal might obey."""
    text = without_middle(text, most)
    seen = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
    return without_middle(seen, most)


def without_middle(text: str, most: int) -> str:
    """Return text, its middle left out if it is longer than so many characters."""
    half = (most - 5) // 2
    return text if len(text) <= most else f"{text[:half]} ... {text[-half:]}"


def last_words(message: str, console: str) -> str:
    """Append the last line that the engine printed."""
    lines = [line.strip() for line in console.splitlines() if line.strip()]
    return f"{message} (console: {in_sight(lines[-1], 200)})" if lines else message
