"""The record of a run, the container around code of engines, and the errors that it raises."""

from __future__ import annotations

import importlib
import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import chdir, contextmanager, nullcontext, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path
from traceback import TracebackException, walk_tb
from typing import Any, TypeVar

import numpy as np
import scipy

from ...reference.errors import EngineError, MbcheckError, UsageError
from ...reference.scene import Array

T = TypeVar("T")

EPS = float(np.finfo(float).eps)

VIOLATIONS = ("position_violation", "velocity_violation")
"""Largest residual of a closed loop's constraints [m], and of their rates [m/s]."""

OURS = f"{Path(__file__).parents[2]}{os.sep}"
"""Folder of this package."""

SOLVERS = tuple(f"{Path(str(one.__file__)).parent}{os.sep}" for one in (np, scipy))
"""Folders of the libraries by which this package calls an engine's equations."""

LOADERS = ("<frozen importlib", importlib.__file__)
"""Beginnings of the names of files whose code imports modules."""

LONGEST_REASON, LONGEST_TRACEBACK = 300, 8000
"""Most characters of the line about an exception, and of its traceback."""

MOST_STEPS = 2**31 - 1
"""Engines count their steps in 32 bits."""

NOTES: ContextVar[dict[str, None]] = ContextVar("NOTES")
"""Harmless findings about runs, each once, while `noting` is active."""


@dataclass(frozen=True)
class Trajectory:
    """The record of a run; `guard` judges it before anyone reads it.

    Attributes
    ----------
    times : array (n_t,)
        Sample times [s].
    values : mapping of str to array (n_t,)
        Observables by name, SI units.
    clock : array (n_t,)
        The engine's own clock at the samples [s].
    steps : int
        Steps that the engine counted (not those requested).
    rhs_evaluations : int or None
    newton_iterations : int or None
        Of an implicit method, or of a solver of constraints; all steps together.
    warnings : mapping of str to int
        The engine's warning counters; any of them above zero is a failure.
    changed_inputs : tuple of str
        Inputs that the engine changed (controls, parameters, step).
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
    changed_inputs: tuple[str, ...] = ()
    seconds: float = 0.0

    def matrix(self, names: tuple[str, ...]) -> Array:
        """Return the named observables as an array (n_names, n_t)."""
        return np.array([self.values[name] for name in names])


@contextmanager
def noting() -> Iterator[dict[str, None]]:
    """Return the notes on runs in the context, each once."""
    before = NOTES.set({})
    try:
        yield NOTES.get()
    finally:
        NOTES.reset(before)


IN_SIGHT: ContextVar[bool] = ContextVar("IN_SIGHT", default=False)
"""Whether the console of engines is the user's, as a debugger needs it."""


class Console:
    """The text written to standard output and error while `captured` was active."""

    text = ""


@contextmanager
def captured(console: Console | None = None) -> Iterator[Console]:
    """Capture all output, that of C code too, unless the console of engines is the user's."""
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


def call_engine(
    work: Callable[[], T], console: Console | None = None, container: Callable[..., Any] = contained
) -> T:
    """Return the result of a call of an engine, made inside the container.

    Raises
    ------
    EngineError
        ``raised``, for whatever an engine raises except errors of mbcheck.
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
    """Return the result of some work, or the `EngineError` of its failure."""
    try:
        return call_engine(work, container=nullcontext)
    except EngineError as error:
        return error


def engine_error(error: BaseException, console: str = "") -> EngineError:
    """Return the `EngineError` of an exception of third-party code, with its console."""
    parts = [traceback_of(error), console and f"its console:\n{console}"]
    traceback = excerpt("\n\n".join(filter(None, parts)))
    message = append_console_tail(describe(error) + place_of(error), console)
    return EngineError("raised", message, traceback)


def describe(error: BaseException) -> str:
    """Return one line about an exception.

    A first line that ends in a colon only announces the reason.
    """
    lines = (str(error).strip() or "no message").splitlines()
    reason = " ".join(lines[:2]) if lines[0].endswith(":") else lines[0]
    return printable_text(f"{type(error).__name__}: {reason}", LONGEST_REASON)


def place_of(error: BaseException) -> str:
    """Return the file and line in an engine's module that led to an exception; empty if none did.

    The module is the first of others than us; the line is the last reached in it.
    """
    every = ((at.f_code.co_filename, line) for at, line in walk_tb(error.__traceback__))
    frames = [one for one in every if not one[0].startswith((OURS, *LOADERS, *SOLVERS))]
    lines = [line for name, line in frames if name == frames[0][0]]
    return f" ({printable_text(Path(frames[0][0]).name, 80)}:{lines[-1]})" if frames else ""


def traceback_of(error: BaseException) -> str:
    """Return the traceback of an exception, from the first line outside this package."""
    try:
        whole = TracebackException.from_exception(error)
        parts = [whole]
        for part in parts:
            inside = [frame.filename.startswith((OURS, *LOADERS)) for frame in part.stack]
            del part.stack[: 0 if all(inside) else inside.index(False)]
            parts += filter(None, (part.__cause__, part.__context__))
        return excerpt("".join(whole.format()))
    except BaseException:  # of whatever the exception is made of
        return ""


def excerpt(traceback: object) -> str:
    """Return a printable traceback, whatever another process has sent in its place."""
    lines = without_middle(f"{traceback}", 2 * LONGEST_TRACEBACK).split("\n")
    return without_middle("\n".join(map(printable_text, lines)), LONGEST_TRACEBACK).rstrip()


def printable_text(text: str, most: int = 2 * LONGEST_TRACEBACK) -> str:
    """Return text of at most so many characters, with escapes for what a terminal might obey."""
    text = without_middle(text, most)
    seen = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
    return without_middle(seen, most)


def without_middle(text: str, most: int) -> str:
    """Return text, its middle left out if it is longer than so many characters."""
    half = (most - 5) // 2
    return text if len(text) <= most else f"{text[:half]} ... {text[-half:]}"


def append_console_tail(message: str, console: str) -> str:
    """Append the last line that the engine printed."""
    lines = [line.strip() for line in console.splitlines() if line.strip()]
    return f"{message} (console: {printable_text(lines[-1], 200)})" if lines else message
