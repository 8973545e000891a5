"""Wrong engines that solve equations of motion of the reference."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ...reference.equations import ModelEquations
from ...reference.scene import Array, Case, EquationsOfMotion
from ...reference.solve import schemes
from ..engines.adapter import Adapter, BoundModel
from ..engines.protocol import Method, ModelDescription
from ..engines.reference import ReferenceEngine, ReferenceModel
from ..engines.run import VIOLATIONS, Trajectory, grid_indices
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


class Undeclared(ReferenceEngine):
    """The reference, whose simplified theories pass for exact."""

    class Model(ReferenceModel):
        """A theory that declares no equations."""

        described = ModelDescription(), None

    bound = Model


class ImpostorModel(ReferenceModel):
    """Equations of motion that pass for an engine's model.

    It claims the scene's own equations.
    """

    engine: Impostor
    described = ModelDescription(), None

    @property
    def solved(self) -> EquationsOfMotion:
        """The equations that are solved."""
        return self.engine.change(self.scene)

    @property
    def passed_for(self) -> BoundModel:
        """The model of the engine that it passes for."""
        return self.engine.engine.bind(self.case, self.name)

    def simulate(self, case: Case, method: Method, step: float, times: Array) -> Trajectory:
        """Integrate with the method's scheme, or without error where it has none."""
        scheme = self.passed_for.scheme(method)
        if scheme:
            own = ModelEquations(self.solved, self.case.parameters)
            start = self.solved.state(case.state)
            trajectory = integrated(own, scheme, start, case, step, times)
        else:
            trajectory = super().simulate(case, method, step, times)
        closed = dict.fromkeys(VIOLATIONS, np.zeros(len(times)))
        return replace(trajectory, values={**trajectory.values, **closed})


class Impostor(ReferenceEngine):
    """Equations of motion that pass for an engine, integrated as its methods would.

    With the scene's own equations it passes every check.
    """

    bound = ImpostorModel

    def __init__(
        self, engine: Adapter, change: Callable[[EquationsOfMotion], EquationsOfMotion]
    ) -> None:
        super().__init__()
        self.engine = engine
        self.change = change

    def __getattr__(self, name: str) -> Any:
        return getattr(self.engine, name)


class Mistaken(Wrapped):
    """An engine that solves its model's equations with the mistake that these know of."""

    def mistaken(self, model: BoundModel) -> tuple[ModelEquations, EquationsOfMotion]:
        """Return the right equations, and those that are solved."""
        (scene,) = model.equations.scene.mistakes.values()
        return model.equations, scene

    def simulate(
        self, model: BoundModel, case: Case, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate the mistaken equations by the method's scheme."""
        right, scene = self.mistaken(model)
        own = ModelEquations(scene, right.parameters)
        return integrated(own, str(model.scheme(method)), right.start(case), case, step, times)

    def compute(self, model: BoundModel, name: str, *arguments: Any) -> Any:
        """Return accelerations of the mistaken equations."""
        if name != "accelerations":
            return super().compute(model, name, *arguments)
        right, scene = self.mistaken(model)
        slopes, n = scene.right_hand_side(right.parameters), len(scene.coordinates)
        names = model.scene.state_names
        states = [dict(zip(names, map(float, state), strict=True)) for state in arguments[1]]
        starts = [right.start(replace(model.case, state=state)) for state in states]
        places = [scene.coordinates.index(name) for name in model.scene.coordinates]
        return np.array([slopes(0.0, x)[n:][places] for x in starts])
