"""Engines of others: each is held in a process of its own, which it may take down with it."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ...models.system import System
from ...reference.errors import EngineError, EngineUnavailableError, MbcheckError
from ...reference.scene import Array
from .isolation import SERVING, Worker, await_call
from .messages import as_ours
from .protocol import Engine, Method, Motion
from .run import call_engine

SECONDS_TO_LOAD = 120.0
"""Time in which an engine must have been imported and created."""


class BrokenEngineError(EngineUnavailableError):
    """An engine that is there fails as it is imported, or created, or asked for its name."""


def loading_error(reason: str, traceback: str) -> BrokenEngineError:
    """Return the error of an engine whose own code raised as it was loaded."""
    error = BrokenEngineError(reason)
    error.traceback = traceback
    return error


@dataclass(frozen=True)
class Description:
    """What an engine says of itself.

    Attributes
    ----------
    name, version : str
    methods : tuple of Method
    reads_mjcf : bool
    precision, closure : str
    author : str
        Module and name of the class that its author wrote.
    """

    name: str
    version: str
    methods: tuple[Method, ...]
    reads_mjcf: bool
    precision: str
    closure: str
    author: str


class RemoteEngine(Engine):
    """An engine whose code runs in another process.

    Parameters
    ----------
    describe : callable
        Returns the engine's `Description`; called in that process.
    local : callable
        Returns the engine itself; called in that process.

    Raises
    ------
    BrokenEngineError
        If the engine fails as it is loaded, in whatever way.
    """

    def __init__(self, describe: Callable[[], Description], local: Callable[[], Engine]) -> None:
        self.local = local
        self.folder = Path(os.environ.get(SERVING) or Path.cwd())
        self.worker: Worker | None = None
        try:
            self.description = self.call(describe, SECONDS_TO_LOAD)
        except EngineError as error:
            raise loading_error(f"it cannot be loaded: {error.message}", error.traceback) from error
        about = self.description
        self.name, self.version, self.methods = about.name, about.version, about.methods
        self.reads_mjcf, self.precision = about.reads_mjcf, about.precision
        self.closure = about.closure

    def call(self, work: Callable[[], Any], most: float = math.inf) -> Any:
        """Return what work in the engine's process returns, which may take so long [s] at most.

        Raises
        ------
        EngineError
            If the process has ended, or not ended in time, or the engine raised.
        MbcheckError
            That the work raised.
        """
        if self.worker is None or not self.worker.process.is_alive():
            self.worker = Worker(self.folder)
        outcome = await_call(self.worker, partial(guarded, work), most)
        if isinstance(outcome, MbcheckError):
            raise as_ours(outcome)  # again: nothing makes sure that its process did it
        return outcome

    def simulate(self, system: System, method: Method, step: float, times: Array) -> Motion:
        """Integrate in the engine's process, see `Engine.simulate`."""
        return self.ask("simulate", system, method, step, times)

    def accelerations(
        self, system: System, time: float, positions: Array, velocities: Array
    ) -> Array:
        """Return accelerations from the engine's process, see `Engine.accelerations`."""
        return self.ask("accelerations", system, time, positions, velocities)

    def mass_matrix(self, system: System, positions: Array) -> Array:
        """Return the mass matrix from the engine's process, see `Engine.mass_matrix`."""
        return self.ask("mass_matrix", system, positions)

    def linearise(self, system: System) -> tuple[Array, Array, Array]:
        """Return M, C, K from the engine's process, see `Engine.linearise`."""
        return self.ask("linearise", system)

    def ask(self, function: str, *arguments: Any) -> Any:
        """Return what a function of the engine returns."""
        return self.call(partial(asked, self.local, function, arguments))


def asked(local: Callable[[], Engine], function: str, arguments: tuple[Any, ...]) -> Any:
    """Return what a function of an engine of this process returns."""
    call = getattr(local(), function)
    return call_engine(lambda: call(*arguments))


def guarded(work: Callable[[], Any]) -> Any:
    """Return what work returns, or the error of mbcheck's own that it raises."""
    try:
        return work()
    except MbcheckError as error:
        return as_ours(error)
