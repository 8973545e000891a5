"""The protocol of engines: what an author writes (docs/engines.md is the page for authors)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ...models.system import System
from ...reference.errors import EngineUnavailableError, Unsupported
from ...reference.scene import Array

__all__ = ["Engine", "EngineUnavailableError", "Method", "Motion", "System", "Unsupported"]


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
    precision : str or None
        Of the numbers that its states are kept in, ``float32`` or ``float64``; that of the engine
        where it is None.
    evaluations : int, optional
        How often a step evaluates forces. A run whose `Motion.rhs_evaluations` says otherwise took
        other steps than were asked for.
    """

    name: str
    order: int
    scheme: str | None = None
    linear: str | None = None
    evaluations: int | None = None
    precision: str | None = None


@dataclass(frozen=True)
class Motion:
    """What a plugged-in engine returns of a run.

    Attributes
    ----------
    positions, velocities : array (n_t, n)
        Of the joints, in the order of `System.joints`, at the times that were asked for.
    clock : array (n_t,), optional
        The engine's own clock at these times [s]. Without it a reset in silence goes unnoticed.
    steps : int, optional
        Steps that the engine counted itself.
    warnings : mapping of str to int
        Warning counters; any that is not zero fails the run.
    rhs_evaluations : int, optional
        How often forces were evaluated.
    """

    positions: Any
    velocities: Any
    clock: Any = None
    steps: int | None = None
    warnings: Mapping[str, int] = field(default_factory=dict)
    rhs_evaluations: int | None = None


class Engine:
    """Base class of engines; an engine overrides `simulate`, and of the rest what it supports.

    A class with the same attributes that does not inherit from it is an engine as well.

    Attributes
    ----------
    name, version : str
        The name stands in the ids of results.
    methods : tuple of Method
        The engine's integrators.
    reads_mjcf : bool
        Whether the engine reads `System.mjcf`. One that does not models the scenes itself, and
        takes their coordinates for joints.
    precision : str
        Of the numbers that it computes with, ``float64`` or ``float32``. All tolerances follow.
    closure : str
        How it holds loops closed: ``rigid``, or as ``solref`` and ``solimp`` of the file say
        (``mjcf``), or ``soft`` by a rule of its own; then checks that need rigid ones are skipped.
    """

    name: str
    version: str
    methods: tuple[Method, ...]
    reads_mjcf: bool = True
    precision: str = "float64"
    closure: str = "rigid"

    def simulate(self, system: System, method: Method, step: float, times: Array) -> Motion:
        """Integrate from ``system.start_time`` with a fixed step.

        Parameters
        ----------
        system : System
        method : Method
            One of `methods`.
        step : float
            Step [s].
        times : array (n_t,)
            Times [s] at which the motion is returned; they lie on the grid of the step.

        Raises
        ------
        Unsupported
            If the engine cannot run this system; the check is skipped.
        """
        raise Unsupported(f"{self.name} has no simulate(...)")

    def accelerations(
        self, system: System, time: float, positions: Array, velocities: Array
    ) -> Array:
        """Return the joints' accelerations (n,) at a time [s] and a state (n,), (n,)."""
        raise Unsupported(f"{self.name} has no accelerations(...)")

    def mass_matrix(self, system: System, positions: Array) -> Array:
        """Return the joints' mass matrix (n, n) at positions (n,)."""
        raise Unsupported(f"{self.name} has no mass_matrix(...)")

    def linearise(self, system: System) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about the system's initial state, a state of rest."""
        raise Unsupported(f"{self.name} has no linearise(...)")
