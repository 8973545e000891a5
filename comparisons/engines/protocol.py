"""What an engine is to mbcheck: a small protocol, its result, and the guard around it."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any, Protocol, TypeVar

import numpy as np
from packaging.version import Version

from ...reference import get_scene
from ...reference.errors import EngineError, EngineUnavailableError, MbcheckError, UsageError
from ...reference.scene import Array, Case

T = TypeVar("T")

EPS = float(np.finfo(float).eps)

VIOLATIONS = ("position_violation", "velocity_violation")
"""Largest residual of a closed loop's constraints [m], and of their rates [m/s]."""

MOST_STEPS = 2**31 - 1
"""Engines count their steps in 32 bits."""


@dataclass(frozen=True)
class Method:
    """One integrator of an engine.

    Attributes
    ----------
    name : str
        As the engine spells it.
    order : int
        Declared order of convergence of the states.
    scheme : str or None
        The published scheme in `mbcheck.reference.solve.schemes` that it claims to be; with it
        the error is predicted exactly, without it by Richardson extrapolation.
    linear : str or None
        The scheme in `mbcheck.reference.amplification` that it is on a linear system without
        constraints, where that is not ``scheme``: what stability and damping are predicted by.
    """

    name: str
    order: int
    scheme: str | None = None
    linear: str | None = None


@dataclass(frozen=True)
class Knob:
    """A setting of an engine beside method and step that limits accuracy.

    Attributes
    ----------
    name, unit : str
    default : float
    values : tuple of float
        From coarse to fine; the default is one of them.
    limits : str
        What it leaves as an error that no step removes: ``closure softness``, ...
    """

    name: str
    unit: str
    default: float
    values: tuple[float, ...]
    limits: str


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


class Engine(Protocol):
    """Something that simulates a model of a scene.

    ``model`` is one of the names of `models`: ways in which the engine models the scene,
    the first is its default. States are arrays (2 n,): coordinates, then rates, in the
    order of ``Scene.state_names``.

    Sixteen attributes are optional. ``claim(case, model)`` returns the equations of motion that
    the model really has, as a `Scene` and its parameters, where the engine cannot express
    those of the case. ``constrained(case, model)`` is True where loops are closed by
    constraints; `simulate` then also returns the `VIOLATIONS`. ``scheme(case, model,
    method)`` returns the method's published scheme on this model, or None.
    ``reaction_names(case, model)`` returns the scene's outputs that are forces in joints of
    the model, and ``reactions(case, model, times (k,), states (k, 2 n))`` these forces (k,)
    by name. ``integrates_drive`` is True where the drive is a body of the model, which the
    integrator moves along. Of scenes with internal coordinates, ``coordinates(case, model)``
    returns the names of those that states are given in, by default the public ones,
    ``element_order(case, model)`` the order of convergence with `segments`, and ``side(case,
    model)`` whether the first frequency lies below (-1) or above (1) the continuum's, 0 if
    that is unknown. ``simulate_many(cases, model, method, steps (k,), times (k, n_t))`` returns
    a list with what `simulate` returns for each case, or the `EngineError` that it raises,
    faster: there are as many steps from sample to sample in each case. ``knobs(case, model,
    method)`` returns a tuple of `Knob`, and ``turned(name, value)`` the engine with one of them
    set. For `rules` alone: ``accumulates_clock`` is True where the clock adds up its steps,
    ``least_inertia`` (SI) the largest that is refused, ``largest_value`` (SI) the position, rate
    or acceleration above which a run counts as failed, and ``newton_tolerance`` the increment
    (m, rad) at which Newton's method stops in implicit methods.
    """

    name: str
    version: str
    methods: tuple[Method, ...]

    def models(self, scene: str) -> tuple[str, ...]:
        """Return the names of the models that it has of a scene, default first."""
        ...

    def why_not(self, case: Case, model: str, method: Method | None) -> str | None:
        """Return why this method cannot run this case on this model, or None.

        Without a method: why the model cannot stand for the case at all.
        """
        ...

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate from ``case.start_time`` with a fixed step; ``times`` lie on its grid."""
        ...

    def accelerations(self, case: Case, model: str, times: Array, states: Array) -> Array:
        """Return accelerations (k, n) at ``times`` (k,) and ``states`` (k, 2 n)."""
        ...

    def mass_matrices(self, case: Case, model: str, states: Array) -> Array:
        """Return mass matrices (k, n, n) of the scene's coordinates at ``states`` (k, 2 n)."""
        ...

    def linearise(self, case: Case, model: str, state: Array) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about a state of rest, at ``case.start_time``."""
        ...


def guard(trajectory: Trajectory, case: Case, step: float, times: Array) -> None:
    """Refuse a run that failed silently.

    Raises
    ------
    EngineError
        Named by its kind: ``shape``, ``names``, ``warning``, ``non_finite``, ``clock``,
        ``clock_reversed``, ``step_count``, ``inputs_changed`` or ``branch``.
    """
    expected = np.asarray(times, dtype=float)
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
    slack = EPS * max(asked, 1) * np.maximum(np.abs(expected), step)
    late = np.flatnonzero(~(np.abs(trajectory.clock - expected) <= slack))
    if late.size:
        raise EngineError(
            "clock",
            f"the engine's clock shows {trajectory.clock[late[0]]:.17g} s at "
            f"t = {expected[late[0]]:.17g} s",
        )
    if trajectory.steps != asked:
        raise EngineError(
            "step_count", f"the engine took {trajectory.steps} steps, {asked} were asked for"
        )
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


class Console:
    """What was written to standard output and error while `contained` was active."""

    text = ""


@contextmanager
def contained() -> Iterator[Console]:
    """Run engine code in a temporary working directory, with the console captured.

    Engines log from C code, so the file descriptors themselves are redirected.
    """
    console = Console()
    home = Path.cwd()
    sys.stdout.flush()
    sys.stderr.flush()
    with tempfile.TemporaryFile() as log, tempfile.TemporaryDirectory() as folder:
        saved = os.dup(1), os.dup(2)
        os.dup2(log.fileno(), 1)
        os.dup2(log.fileno(), 2)
        os.chdir(folder)
        try:
            yield console
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os.chdir(home)
            for target, copy in enumerate(saved, start=1):
                os.dup2(copy, target)
                os.close(copy)
            log.seek(0)
            console.text = log.read().decode(errors="replace").strip()


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


def run(
    engine: Engine, case: Case, model: str, method: Method, step: float, times: Array
) -> Trajectory:
    """Simulate inside the container and pass the result through the guard.

    Raises
    ------
    EngineError
        If the engine raised, or the guard refused its result.
    UsageError
        If times are off the engine's grid.
    """
    times = np.asarray(times, dtype=float)
    grid_indices(times, case.start_time, step)
    console = Console()
    try:
        with contained() as console:
            begin = perf_counter()
            trajectory = engine.simulate(case, model, method, step, times)
            seconds = perf_counter() - begin
    except MbcheckError:
        raise
    except (Exception, SystemExit) as error:  # whatever an engine raises is a verdict, not a crash
        raise EngineError("raised", describe(error, console.text)) from error
    try:
        guard(trajectory, case, step, times)
    except EngineError as error:
        raise EngineError(error.kind, last_words(error.message, console.text)) from error
    return trajectory if trajectory.seconds else replace(trajectory, seconds=seconds)


def run_many(
    engine: Engine, cases: Sequence[Case], model: str, method: Method, steps: Array, times: Array
) -> list[Trajectory | EngineError]:
    """Simulate many cases of a scene, together if the engine can; errors are returned.

    Parameters
    ----------
    engine, model, method
    cases : sequence of Case, k of them
    steps : array (k,) [s]
    times : array (k, n_t) [s]
        As many steps from one to the next in every case.
    """
    for case, step, grid in zip(cases, steps, times, strict=True):
        grid_indices(grid, case.start_time, float(step))
    together = getattr(engine, "simulate_many", None) or partial(one_by_one, engine)
    try:
        with contained() as console:
            found: list[Trajectory | EngineError] = together(cases, model, method, steps, times)
    except MbcheckError:
        raise
    except (Exception, SystemExit) as error:  # as in `run`
        raised = EngineError("raised", describe(error, console.text))
        return [raised for _ in cases]
    for i, result in enumerate(found):
        if isinstance(result, EngineError):
            continue
        try:
            guard(result, cases[i], float(steps[i]), times[i])
        except EngineError as error:
            found[i] = error
    return found


def one_by_one(
    engine: Engine, cases: Sequence[Case], model: str, method: Method, steps: Array, times: Array
) -> list[Trajectory | EngineError]:
    """Do what ``simulate_many`` would, for an engine that has none."""
    return [
        attempt(partial(engine.simulate, case, model, method, float(step), grid))
        for case, step, grid in zip(cases, steps, times, strict=True)
    ]


def attempt(work: Callable[[], Any]) -> Any:
    """Return what some work returns, or the `EngineError` that `engine.run` makes of a failure."""
    try:
        return work()
    except EngineError as error:
        return error
    except MbcheckError:
        raise
    except (Exception, SystemExit) as error:  # as in `run`
        return EngineError("raised", describe(error, ""))


def with_attribute(engine: T, name: str, value: float) -> T:
    """Return a copy of an engine with an attribute set: a knob that is one.

    What the engine keeps of its models is not shared with the copy.
    """
    copied = type(engine)()
    vars(copied).update({key: item for key, item in vars(engine).items() if key != "kept"})
    setattr(copied, name, value)
    return copied


def refuse_older(name: str, version: str, least: str) -> None:
    """Refuse an engine that is older than the oldest that mbcheck was run with.

    Raises
    ------
    EngineUnavailableError
    """
    if Version(version) < Version(least):
        raise EngineUnavailableError(
            f"{name} {version} is too old: mbcheck needs {name} {least} or newer; upgrade it with: "
            f"pip install -U {name}"
        )


def describe(error: BaseException, console: str) -> str:
    """Return one line about an exception, with the last line of the engine's console.

    A first line that ends in a colon only announces the reason.
    """
    lines = (str(error).strip() or "no message").splitlines()
    reason = " ".join(lines[:2]) if lines[0].endswith(":") else lines[0]
    return last_words(f"{type(error).__name__}: {reason}", console)


def last_words(message: str, console: str) -> str:
    """Append the last line that the engine printed."""
    lines = [line.strip() for line in console.splitlines() if line.strip()]
    return f"{message} (console: {lines[-1][:200]})" if lines else message
