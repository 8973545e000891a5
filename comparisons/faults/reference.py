"""Wrong engines that solve equations of motion of the reference."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ...reference import get_scene
from ...reference.scene import Array, Case, EquationsOfMotion
from ...reference.solve import schemes
from ..engines.adapter import Adapter
from ..engines.equations import ModelEquations
from ..engines.protocol import Method
from ..engines.reference import ReferenceEngine
from ..engines.registry import REFERENCE, get_engine
from ..engines.run import VIOLATIONS, Trajectory, grid_indices
from ..engines.setup import Setup
from .variants import Wrapped


def integrated(
    equations: ModelEquations, scheme: str, start: Array, case: Case, step: float, times: Array
) -> Trajectory:
    """Return the run of equations of motion by a scheme, from a state (2 n,)."""
    scene, p = equations.scene, equations.parameters
    numbers = grid_indices(times, case.start_time, step)
    scalar = schemes.ScalarEquations(scene, p)
    states = schemes.integrate(scalar, scheme, start, step, numbers, case.start_time)
    return Trajectory(times, scene.observe(states, p), times, int(numbers[-1]))


class Undeclared(Wrapped):
    """The reference, whose simplified theories pass for exact."""

    def __init__(self) -> None:
        super().__init__(get_engine(REFERENCE))

    def model_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Declare none."""
        return None


class Impostor(ReferenceEngine):
    """Equations of motion that pass for an engine, integrated as its methods would.

    With the scene's own equations it passes every check.
    """

    def __init__(
        self, engine: Adapter, change: Callable[[EquationsOfMotion], EquationsOfMotion]
    ) -> None:
        super().__init__()
        self.engine = engine
        self.change = change

    def __getattr__(self, name: str) -> Any:
        return getattr(self.engine, name)

    def equations(self, case: Case, model: str) -> EquationsOfMotion:
        """Return the equations that are solved."""
        return self.change(get_scene(case.scene))

    def model_equations(self, case: Case, model: str) -> None:
        """Return that it claims the scene's own equations."""

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate with the method's scheme, or without error where it has none."""
        scheme = Setup(self.engine, case, model, method).scheme
        if scheme:
            scene = self.equations(case, model)
            own = ModelEquations(scene, case.parameters)
            trajectory = integrated(own, scheme, scene.state(case.state), case, step, times)
        else:
            trajectory = super().simulate(case, model, method, step, times)
        closed = dict.fromkeys(VIOLATIONS, np.zeros(len(times)))
        return replace(trajectory, values={**trajectory.values, **closed})


class Mistaken(Wrapped):
    """An engine that solves its model's equations with the mistake that these know of."""

    def mistaken(self, case: Case, model: str) -> tuple[ModelEquations, EquationsOfMotion]:
        """Return the right equations, and those that are solved."""
        right = self.engine.model_equations(case, model)
        assert right is not None
        (scene,) = right.scene.mistakes.values()
        return right, scene

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate the mistaken equations by the method's scheme."""
        right, scene = self.mistaken(case, model)
        scheme = str(Setup(self.engine, case, model, method).scheme)
        own = ModelEquations(scene, right.parameters)
        return integrated(own, scheme, right.start(case), case, step, times)

    def compute(self, method: Callable[..., Any], case: Case, model: str, *rest: Any) -> Any:
        """Return accelerations of the mistaken equations."""
        if method.__name__ != "accelerations":
            return method(case, model, *rest)
        right, scene = self.mistaken(case, model)
        slopes, n = scene.right_hand_side(right.parameters), len(scene.coordinates)
        names = get_scene(case.scene).state_names
        states = [dict(zip(names, map(float, state), strict=True)) for state in rest[1]]
        starts = [right.start(replace(case, state=state)) for state in states]
        places = [scene.coordinates.index(name) for name in get_scene(case.scene).coordinates]
        return np.array([slopes(0.0, x)[n:][places] for x in starts])
