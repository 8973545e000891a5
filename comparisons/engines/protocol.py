"""The protocol of engines: what an author writes (docs/engines.md is the page for authors).

MuJoCo and Exudyn import nothing else of mbcheck.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, field
from typing import Any, Self

from packaging.version import Version

from ...models.system import System
from ...reference.errors import EngineError, EngineUnavailableError, Unsupported, UsageError
from ...reference.scene import Array, EquationsOfMotion

__all__ = [
    "Engine",
    "EngineError",
    "EngineUnavailableError",
    "Method",
    "ModelDescription",
    "Motion",
    "Option",
    "System",
    "Unsupported",
    "UsageError",
    "import_library",
    "refuse_older",
]

NO_ACCELERATIONS = "has no accelerations(...)"
"""The words for an engine without accelerations."""


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
    scheme_with_loops : bool
        Whether it is this scheme on models with loops too, with their softness as in the file.
    linear_scheme : str or None
        The scheme in `mbcheck.reference.amplification` that it is on a linear system without
        constraints, if another one than ``scheme``: stability and damping are predicted by it.
    evaluations_per_step : int, optional
        How often a step evaluates forces. A run whose `Motion.rhs_evaluations` differs took other
        steps than requested.
    precision : str or None
        Of the numbers that its states are kept in, ``float32`` or ``float64``; that of the engine
        where it is None.
    """

    name: str
    order: int
    scheme: str | None = None
    linear_scheme: str | None = None
    evaluations_per_step: int | None = None
    precision: str | None = None
    scheme_with_loops: bool = True


@dataclass(frozen=True)
class Option:
    """A setting of an engine, apart from method and step, that limits its accuracy.

    Attributes
    ----------
    name, unit : str
    default : float
    values : tuple of float
        From coarse to fine; the default is one of them.
    error_source : str
        The error that it leaves and no step removes: ``closure softness``, ...
    """

    name: str
    unit: str
    default: float
    values: tuple[float, ...]
    error_source: str


@dataclass(frozen=True)
class ModelDescription:
    """An engine's description of a model that it builds itself, or that has compliant parts.

    Attributes
    ----------
    constrained : bool
        Whether constraints close loops; `Motion.observables` then holds their residuals.
    reactions : tuple of str
        Outputs of the scene that are forces in its joints, which `Engine.reactions` returns.
    equations : (EquationsOfMotion, parameters), or None
        The equations of motion that the model really has, or converges to, where they are not the
        scene's: those of a soft closure or of compliant joints, for instance.
    elements : EquationsOfMotion or None
        Of a model that converges to a continuum: the equations of its elements. The engine then
        takes states in their coordinates, and returns these of a run.
    element_order : int
        Order with which it converges as its elements are halved; 0 without elements.
    unplaceable_reason : str or None
        Why it cannot be placed in the world as `Case.placement` says; None if it can.
    """

    constrained: bool = False
    reactions: tuple[str, ...] = ()
    equations: tuple[EquationsOfMotion, Any] | None = None
    elements: EquationsOfMotion | None = None
    element_order: int = 0
    unplaceable_reason: str | None = "the engine reads no MJCF, so its model cannot be turned"


@dataclass(frozen=True)
class Motion:
    """The result of a run.

    Attributes
    ----------
    positions, velocities : array (n_t, n)
        Of the joints, in the order of `System.joints`, at the requested times.
    clock : array (n_t,), optional
        The engine's own clock at these times [s]. Without it a silent reset goes unnoticed.
    steps : int, optional
        Steps that the engine counted itself.
    warnings : mapping of str to int
        Warning counters; any of them above zero fails the run.
    rhs_evaluations : int, optional
        How often forces were evaluated.
    newton_iterations : int, optional
        Of an implicit method, or of a solver of constraints; all steps together.
    changed_inputs : tuple of str
        Inputs that the engine changed (controls, parameters, step): they fail the run.
    seconds : float
        Wall time of the stepping alone [s]; that of the whole call counts where it is 0.
    observables : mapping of str to array (n_t,)
        What the engine's own sensors show of `System.observables`, and the norms of its loops'
        residuals, ``position_violation`` [m] and ``velocity_violation`` [m/s]. What is absent
        follows from the joints.
    """

    positions: Any
    velocities: Any
    clock: Any = None
    steps: int | None = None
    warnings: Mapping[str, int] = field(default_factory=dict)
    rhs_evaluations: int | None = None
    newton_iterations: int | None = None
    changed_inputs: tuple[str, ...] = ()
    seconds: float = 0.0
    observables: Mapping[str, Any] = field(default_factory=dict)


class Engine:
    """Base class of engines; an engine overrides `simulate`, and of the rest what it supports.

    Attributes
    ----------
    name, version : str
        The name is part of the ids of results.
    methods : tuple of Method
        The engine's integrators.
    reads_mjcf : bool
        Whether the engine reads `System.mjcf`. One that does not models the scenes itself, and
        takes their coordinates for joints.
    needs_only_mjcf : bool
        Whether it needs nothing of `System` but the file and the state: then it also runs models
        whose forces `System.terms` cannot represent, and is empty.
    precision : str
        Of the numbers that it computes with, ``float64`` or ``float32``. All tolerances follow.
    closure : str
        How it holds loops closed: ``rigid``, or as ``solref`` and ``solimp`` of the file say
        (``mjcf``), or ``soft`` by another rule; then models with loops are skipped, unless
        `describe_model` returns their equations.
    compliant_joints : bool
        Whether its joints are compliant by its own rule, as those of position-based dynamics or of
        maximal coordinates with penalties do. Then models are skipped, unless `describe_model`
        returns their equations.
    accumulates_clock : bool
        Whether its clock adds up its steps.
    min_inertia : float
        Largest inertia (SI) that it refuses.
    max_value : float
        Position, rate or acceleration (SI) above which it counts a run as failed.
    newton_tolerance : float
        Increment (m, rad) at which Newton's method stops in implicit methods.
    """

    name: str
    version: str
    methods: tuple[Method, ...]
    reads_mjcf: bool = True
    needs_only_mjcf: bool = False
    precision: str = "float64"
    closure: str = "rigid"
    compliant_joints: bool = False
    accumulates_clock: bool = False
    min_inertia: float = 0.0
    max_value: float = math.inf
    newton_tolerance: float = 0.0

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
        """Return the joints' accelerations (n,) at a time [s] and a state (n_q,), (n,).

        An engine whose solvers differ in them takes one more keyword, ``method=None``: one of
        `methods`, or None for its default.
        """
        raise Unsupported(f"{self.name} {NO_ACCELERATIONS}")

    def mass_matrix(self, system: System, positions: Array) -> Array:
        """Return the joints' mass matrix (n, n) at positions (n_q,).

        The keyword ``method=None`` may be taken as in `accelerations`.
        """
        raise Unsupported(f"{self.name} has no mass_matrix(...)")

    def linearise(self, system: System) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about the system's initial state.

        A state of rest; of an engine that describes its models, a steady motion as well.
        """
        raise Unsupported(f"{self.name} has no linearise(...)")

    def unsupported_reason(self, system: System, method: Method | None) -> str | None:
        """Return the reason why this method cannot run this system, or None.

        Its checks are then skipped. Without a method: the reason why no method can.
        """
        return None

    def models(self, scene: str) -> tuple[str, ...]:
        """Return the names of the models that an engine which reads no MJCF has of a scene.

        The first is the default; none where it has no model.
        """
        return ("scene",)

    def describe_model(self, system: System) -> ModelDescription:
        """Return the description of a model.

        Called if the engine reads no MJCF, or if its joints or loops are compliant.
        """
        return ModelDescription()

    def inverse_dynamics(
        self,
        system: System,
        time: float,
        positions: Array,
        velocities: Array,
        accelerations: Array,
    ) -> Array:
        """Return the forces (n,) on the joints, in addition to the model's, for a given motion.

        Constraint forces of closed loops may be included or not: they do no work.
        """
        raise Unsupported(f"{self.name} has no inverse_dynamics(...)")

    def reactions(
        self, system: System, time: float, positions: Array, velocities: Array
    ) -> Mapping[str, float]:
        """Return the forces in joints [N] that `System.reactions` asks for, by name."""
        raise Unsupported(f"{self.name} has no reactions(...)")

    def options(self, system: System, method: Method) -> tuple[Option, ...]:
        """Return the settings that limit accuracy, apart from the step."""
        return ()

    def with_option(self, name: str, value: float) -> Self:
        """Return a copy of the engine with the attribute of this name set."""
        other = copy(self)
        setattr(other, name, value)
        return other


def import_library(name: str, cure: Callable[[str], str]) -> Any:
    """Return an engine's package.

    Parameters
    ----------
    name : str
    cure : callable ``(reason) -> str``
        What to do where it cannot be imported.

    Raises
    ------
    EngineUnavailableError
        With the reason, and what `cure` says of it.
    """
    try:
        return importlib.import_module(name)
    except Exception as error:  # a broken binary raises anything, OSError for one
        reason = (str(error).strip() or "no message").splitlines()[0]
        raise EngineUnavailableError(
            f"{name} cannot be imported ({type(error).__name__}: {reason}); {cure(reason)}"
        ) from error


def refuse_older(name: str, version: str, least: str) -> None:
    """Refuse an engine older than the oldest release known to work.

    Raises
    ------
    EngineUnavailableError
    """
    if Version(version) < Version(least):
        raise EngineUnavailableError(
            f"{name} {version} is too old: mbcheck needs {name} {least} or newer; upgrade it with: "
            f"pip install -U {name}"
        )
