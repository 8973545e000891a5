"""The reference solution as an adapter, so that every verb can ask it."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy

from ...models.system import System
from ...reference import get_scene
from ...reference.errors import Unsupported
from ...reference.linear import linearise
from ...reference.scene import Array, Case, EquationsOfMotion
from ...reference.solve.single import solve
from .adapter import Adapter
from .equations import ModelEquations
from .protocol import Engine, Method
from .run import Trajectory

EXACT = "exact"
"""The reference's default model; the others are simplifications that it shows beside."""


class ExactEngine(Engine):
    """SciPy's DOP853, as an engine declares itself."""

    name = "reference"
    version = f"scipy {scipy.__version__}"
    methods = (Method("DOP853", 8),)
    reads_mjcf = False


class ReferenceEngine(Adapter):
    """The hand-written equations of motion, solved by SciPy's DOP853.

    The step is chosen by error control; the ``step`` of `simulate` is only the grid on
    which ``times`` lie.
    """

    def __init__(self) -> None:
        super().__init__(ExactEngine())

    def models(self, scene: str) -> tuple[str, ...]:
        """Return the reference's models of a scene, default first."""
        return (EXACT, *get_scene(scene).variants)

    def equations(self, case: Case, model: str) -> EquationsOfMotion:
        """Return the exact scene, or one of the paper's simplifications."""
        scene = get_scene(case.scene)
        return scene.variants.get(model, scene)

    def model_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Return the equations that are solved."""
        return ModelEquations(self.equations(case, model), case.parameters)

    def why_not(self, case: Case, model: str, method: Method | None) -> str | None:
        """Return why the reference cannot run this case, or None."""
        return "the reference's loops are always closed" if case.inconsistency else None

    def scheme(self, case: Case, model: str, method: Method) -> str | None:
        """Return the method's own scheme, which acts on the equations that are solved."""
        return method.scheme

    def coordinates(self, case: Case, model: str) -> tuple[str, ...]:
        """Return the coordinates of states, the reference's own included."""
        return self.equations(case, model).coordinates

    def joint_system(self, case: Case, model: str) -> System:
        """Refuse: it has no joints.

        Raises
        ------
        Unsupported
        """
        raise Unsupported(f"{self.name} has no joints")

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Solve from ``case.start_time``; `solver.solve` states the bound."""
        scene = self.equations(case, model)
        solution = solve(scene, case.parameters, scene.state(case.state), times, case.start_time)
        return Trajectory(
            times=solution.times,
            values=scene.observe(solution.states, case.parameters),
            clock=solution.times,
            steps=round((solution.times[-1] - case.start_time) / step),
            rhs_evaluations=solution.rhs_evaluations,
        )

    def accelerations(self, case: Case, model: str, times: Array, states: Array) -> Array:
        """Return accelerations (k, n) at ``times`` (k,) and ``states`` (k, 2 n)."""
        scene = self.equations(case, model)
        n = len(scene.coordinates)
        derivative = scene.right_hand_side(case.parameters)
        return np.array([derivative(t, x)[n:] for t, x in zip(times, states, strict=True)])

    def mass_matrices(self, case: Case, model: str, states: Array) -> Array:
        """Return mass matrices (k, n, n) at ``states`` (k, 2 n)."""
        scene = self.equations(case, model)
        c = scene.coefficients(case.parameters)
        n = len(scene.coordinates)
        return np.array([np.array(scene.mass_matrix(x[:n], c), dtype=float) for x in states])

    def linearise(self, case: Case, model: str, state: Array) -> tuple[Any, Any, Any]:
        """Return M, C, K, each (n, n), about a state of rest."""
        return linearise(self.equations(case, model), case.parameters, state)
