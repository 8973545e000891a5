"""Engines of others: each is held in a process of its own, which it may take down with it."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Self

from ...models.system import System
from ...reference.errors import EngineError, EngineUnavailableError, MbcheckError, UsageError
from ...reference.scene import Array
from .isolation import SERVING, Worker, await_call
from .messages import as_ours
from .protocol import Engine, Method, Motion, Option, OwnModel
from .run import call_engine, engine_error

Local = Callable[[tuple[tuple[str, float], ...]], Engine]

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
    attributes : mapping of str to value
        Those of `Engine`.
    functions : frozenset of str
        Which of the optional functions it has.
    author : str
        Module and name of the class that its author wrote.
    """

    attributes: Mapping[str, Any]
    functions: frozenset[str]
    author: str


class RemoteEngine(Engine):
    """An engine whose code runs in another process.

    Parameters
    ----------
    describe : callable
        Returns the engine's `Description`; called in that process.
    local : callable ``(options) -> Engine``
        Returns the engine itself, with options (name, value) set; called in that process.

    Raises
    ------
    BrokenEngineError
        If the engine fails as it is loaded, in whatever way.
    """

    def __init__(self, describe: Callable[[], Description], local: Local) -> None:
        self.local = local
        self.settings: tuple[tuple[str, float], ...] = ()
        self.folder = Path(os.environ.get(SERVING) or Path.cwd())
        self.worker: Worker | None = None
        try:
            self.description = self.call(describe, SECONDS_TO_LOAD)
        except EngineError as error:
            raise loading_error(f"it cannot be loaded: {error.message}", error.traceback) from error
        vars(self).update(self.description.attributes)

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

    def why_not(self, system: System, method: Method | None) -> str | None:
        """Return why not from the engine's process, see `Engine.why_not`."""
        reason: str | None = self.ask("why_not", system, method)
        return reason

    def models(self, scene: str) -> tuple[str, ...]:
        """Return names from the engine's process, see `Engine.models`."""
        names: tuple[str, ...] = self.ask("models", scene)
        return names

    def own_model(self, system: System) -> OwnModel:
        """Return a description from the engine's process, see `Engine.own_model`.

        Raises
        ------
        UsageError
            If equations are told, which are functions: they cannot be sent.
        """
        about: Any = self.ask("own_model", system)
        if isinstance(about, str) and about == EQUATIONS:
            raise UsageError(
                f"engine {self.name}: own_model tells equations, which are functions: check it "
                "in this process, with --in-process or mbcheck.check_engine"
            )
        model: OwnModel = about
        return model

    def simulate_many(
        self, systems: Sequence[System], method: Method, steps: Array, times: Array
    ) -> Sequence[Motion | Exception | None]:
        """Integrate together in the engine's process, see `Engine.simulate_many`."""
        motions: Sequence[Motion | None] = self.ask("simulate_many", systems, method, steps, times)
        return motions

    def inverse_dynamics(self, system: System, time: float, *motion: Array) -> Array:
        """Return forces from the engine's process, see `Engine.inverse_dynamics`."""
        return self.ask("inverse_dynamics", system, time, *motion)

    def reactions(
        self, system: System, time: float, positions: Array, velocities: Array
    ) -> Mapping[str, float]:
        """Return forces in joints from the engine's process, see `Engine.reactions`."""
        return self.ask("reactions", system, time, positions, velocities)

    def options(self, system: System, method: Method) -> tuple[Option, ...]:
        """Return options from the engine's process, see `Engine.options`."""
        options: tuple[Option, ...] = self.ask("options", system, method)
        return options

    def with_option(self, name: str, value: float) -> Self:
        """Return the engine that is told of an option before it is asked."""
        other = copy(self)
        other.settings = (*self.settings, (name, value))
        return other

    def ask(self, function: str, *arguments: Any) -> Any:
        """Return what a function of the engine returns."""
        return self.call(partial(asked, self.local, self.settings, function, arguments))


def asked(
    local: Local, settings: tuple[tuple[str, float], ...], function: str, arguments: tuple[Any, ...]
) -> Any:
    """Return what a function of an engine of this process returns."""
    call = getattr(local(settings), function)
    answer = call_engine(lambda: call(*arguments))
    if function == "simulate_many":  # no other exceptions can be sent
        return [as_engine_error(one) if isinstance(one, Exception) else one for one in answer]
    if isinstance(answer, OwnModel) and (
        answer.equations is not None or answer.elements is not None
    ):
        return EQUATIONS
    return answer


EQUATIONS = "equations"
"""Stands for a model with equations of its own."""


def as_engine_error(error: Exception) -> MbcheckError:
    """Return an exception as one of mbcheck's own."""
    return as_ours(error) if isinstance(error, MbcheckError) else engine_error(error)


def guarded(work: Callable[[], Any]) -> Any:
    """Return what work returns, or the error of mbcheck's own that it raises."""
    try:
        return work()
    except MbcheckError as error:
        return as_ours(error)
