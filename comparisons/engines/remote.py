"""Engines of others: each is held in a process of its own, which it may take down with it."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from copy import copy
from functools import partial
from pathlib import Path
from typing import Any, Self

from ...reference.errors import BrokenEngineError, EngineError, MbcheckError
from .isolation import SERVING, Worker, await_call
from .protocol import Engine
from .run import call_engine
from .validation import ATTRIBUTES, CALLS

Local = Callable[[tuple[tuple[str, float], ...]], Engine]

SECONDS_TO_LOAD = 120.0
"""Time in which an engine must have been imported and created."""


class RemoteEngine(Engine):
    """An engine whose code runs in another process.

    Parameters
    ----------
    describe : callable
        Returns the engine's attributes by name, and as ``functions`` the names of the functions
        that it has of its own; called in that process.
    local : callable ``(options) -> Engine``
        Returns the engine itself, with options (name, value) set; called in that process.

    Raises
    ------
    BrokenEngineError
        If the engine fails as it is loaded, in whatever way.
    """

    def __init__(self, describe: Callable[[], dict[str, Any]], local: Local) -> None:
        self.local = local
        self.settings: tuple[tuple[str, float], ...] = ()
        self.folder = Path(os.environ.get(SERVING) or Path.cwd())
        self.worker: Worker | None = None
        try:
            about = self.call(describe, SECONDS_TO_LOAD)
            vars(self).update({name: about[name] for name in ATTRIBUTES})
            self.functions = (set(CALLS) - {"with_option"}) & set(about["functions"])
        except EngineError as error:
            reason = f"it cannot be loaded: {error.message}"
            raise BrokenEngineError(reason, error.traceback) from error
        except (KeyError, TypeError) as error:
            raise BrokenEngineError("what its process sent is no description of it") from error
        self.connect()

    def connect(self) -> None:
        """Have each function that the engine has of its own called in its process."""
        for name in self.functions:
            setattr(self, name, partial(self.ask, name))

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
            raise outcome
        return outcome

    def with_option(self, name: str, value: float) -> Self:
        """Return the engine that is told of an option before it is asked."""
        other = copy(self)
        other.settings = (*self.settings, (name, value))
        other.connect()
        return other

    def ask(self, function: str, *arguments: Any) -> Any:
        """Return what a function of the engine returns."""
        return self.call(partial(asked, self.local, self.settings, function, arguments))


def asked(
    local: Local, settings: tuple[tuple[str, float], ...], function: str, arguments: tuple[Any, ...]
) -> Any:
    """Return what a function of an engine of this process returns."""
    call = getattr(local(settings), function)
    return call_engine(lambda: call(*arguments))


def guarded(work: Callable[[], Any]) -> Any:
    """Return what work returns, or the error of mbcheck's own that it raises."""
    try:
        return work()
    except MbcheckError as error:
        return error
