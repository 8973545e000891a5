"""What mbcheck asks of an engine, in the coordinates of the scenes: cases, models and states."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Self

from ...models.system import System
from ...reference import get_scene
from ...reference.errors import BrokenEngineError, EngineError, UnknownNameError, Unsupported
from ...reference.scene import Array, Case
from .equations import ModelEquations
from .protocol import Method, Option
from .run import Trajectory, attempt


class Adapter(ABC):
    """An engine with its models of the scenes.

    ``model`` is one of the names of `models`: ways in which the engine models the scene, the
    first is its default. States are arrays (2 n,): coordinates, then rates, in the order of
    `coordinates`. What is not abstract has the default of an engine without that feature.

    Attributes
    ----------
    name, version : str
    methods : tuple of Method
    reads_mjcf : bool
        Whether its models are the MJCF files of the scenes.
    precision : str
        Of the numbers that it computes with, see `Engine`.
    accumulates_clock : bool
        Whether its clock adds up its steps.
    least_inertia : float
        Largest inertia (SI) that it refuses.
    largest_value : float
        Position, rate or acceleration (SI) above which it counts a run as failed.
    newton_tolerance : float
        Increment (m, rad) at which Newton's method stops in implicit methods.
    failure : BrokenEngineError or None
        How it failed as checks of it were planned, after which it is asked for nothing.
    """

    name: str
    version: str
    methods: tuple[Method, ...]
    reads_mjcf = False
    precision = "float64"
    accumulates_clock = False
    least_inertia = 0.0
    largest_value = math.inf
    newton_tolerance = 0.0
    failure: BrokenEngineError | None = None

    @abstractmethod
    def models(self, scene: str) -> tuple[str, ...]:
        """Return the names of the models that it has of a scene, default first."""

    @abstractmethod
    def why_not(self, case: Case, model: str, method: Method | None) -> str | None:
        """Return why this method cannot run this case on this model, or None.

        Without a method: why the model cannot stand for the case at all.
        """

    @abstractmethod
    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate from ``case.start_time`` with a fixed step; ``times`` lie on its grid."""

    @abstractmethod
    def accelerations(self, case: Case, model: str, times: Array, states: Array) -> Array:
        """Return accelerations (k, n) at ``times`` (k,) and ``states`` (k, 2 n)."""

    @abstractmethod
    def mass_matrices(self, case: Case, model: str, states: Array) -> Array:
        """Return mass matrices (k, n, n) of the coordinates at ``states`` (k, 2 n)."""

    @abstractmethod
    def linearise(self, case: Case, model: str, state: Array) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about a state of rest, at ``case.start_time``."""

    def simulate_many(
        self, cases: Sequence[Case], model: str, method: Method, steps: Array, times: Array
    ) -> list[Trajectory | EngineError]:
        """Return what `simulate` returns of each case, or the error that it raises.

        Parameters
        ----------
        cases : sequence of Case, k of them
        model, method
        steps : array (k,) [s]
        times : array (k, n_t) [s]
            With as many steps from sample to sample in each case.
        """
        return [
            attempt(partial(self.simulate, case, model, method, float(step), grid))
            for case, step, grid in zip(cases, steps, times, strict=True)
        ]

    def model_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Return the equations of motion that the model has, None where they are the scene's."""
        return None

    def discrete_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Return the equations of the elements of a model that converges to a continuum.

        With them the engine takes states in their coordinates too, and returns these of a run.
        """
        return None

    def scheme(self, case: Case, model: str, method: Method) -> str | None:
        """Return the published scheme that a method is on this model, None if it is none."""
        return method.scheme

    def has_constraints(self, case: Case, model: str) -> bool:
        """Return whether constraints close loops; `simulate` then returns `VIOLATIONS` too."""
        return False

    def coordinates(self, case: Case, model: str) -> tuple[str, ...]:
        """Return the names of the coordinates in which states and matrices are given."""
        return get_scene(case.scene).public

    def twins(self, scene: str) -> tuple[str, ...]:
        """Return those of `models` that differ from the first in what drives them alone."""
        return ()

    def distinct_models(self, scene: str) -> tuple[str, ...]:
        """Return `models` without `twins`."""
        twins = self.twins(scene)
        return tuple(name for name in self.models(scene) if name not in twins)

    def integrates_drive(self, case: Case, model: str) -> bool:
        """Return whether the drive is a body of the model, integrated like the rest."""
        return False

    def element_order(self, case: Case, model: str) -> int:
        """Return the order with which the model converges to a continuum, 0 where to none."""
        return 0

    def frequency_side(self, case: Case, model: str) -> int:
        """Return whether its first frequency lies below (-1) or above (1) the continuum's, or 0."""
        return 0

    def reaction_names(self, case: Case, model: str) -> tuple[str, ...]:
        """Return the outputs of the scene that are forces in joints of the model."""
        return ()

    def reactions(self, case: Case, model: str, times: Array, states: Array) -> Mapping[str, Array]:
        """Return those forces (k,) by name at ``times`` (k,) and ``states`` (k, 2 n)."""
        return {}

    def why_not_placed(self, case: Case, model: str) -> str | None:
        """Return why a model cannot be placed in the world otherwise than it stands, or None."""
        return f"{model} of {self.name} is no MJCF, the text of which could be turned"

    def options(self, case: Case, model: str, method: Method) -> tuple[Option, ...]:
        """Return what limits accuracy beside the step."""
        return ()

    def with_option(self, name: str, value: float) -> Self:
        """Return the engine with one of its options set.

        Raises
        ------
        UnknownNameError
            If it has none of this name.
        """
        raise UnknownNameError(f"option of {self.name}", name, ())

    def reordered(self, order: tuple[int, ...], inputs_too: bool) -> Self:
        """Return the engine with its answers taken for those of joints in another order.

        Parameters
        ----------
        order : tuple of int, n of them
            The joint that each of its numbers is taken for.
        inputs_too : bool
            Whether states are given to it in this order as well.

        Raises
        ------
        Unsupported
            If it has no joints, or not one number for each.
        """
        raise Unsupported(f"{self.name} has no joints")

    def joint_system(self, case: Case, model: str) -> System:
        """Return the MJCF model in joint coordinates, with the initial state of a case.

        Raises
        ------
        CannotJudgeError
            If it holds what `models.system` does not understand.
        """
        raise Unsupported(f"{self.name} reads no MJCF")

    def joint_states(
        self, case: Case, model: str, times: Array, states: Array
    ) -> tuple[System, Array, Array]:
        """Return the MJCF model, and positions and velocities (k, n) of its joints at states."""
        raise Unsupported(f"{self.name} reads no MJCF")

    def joint_accelerations(
        self, system: System, times: Array, positions: Array, velocities: Array
    ) -> Array:
        """Return accelerations (k, n) of the joints at times (k,) and states (k, n)."""
        raise Unsupported(f"{self.name} reads no MJCF")

    def joint_mass_matrices(self, system: System, positions: Array) -> Array:
        """Return mass matrices (k, n, n) of the joints at positions (k, n)."""
        raise Unsupported(f"{self.name} reads no MJCF")
