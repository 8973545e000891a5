"""The reference solution as an adapter, so that every verb can ask it."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import scipy

from ...models.mjcf import Mjcf
from ...models.system import System
from ...reference import get_scene
from ...reference.errors import Unsupported
from ...reference.linear import linearise
from ...reference.scene import Array, Case, EquationsOfMotion
from ...reference.solve.single import solve
from .adapter import NO_FILE, Adapter, BoundModel
from .protocol import Engine, Method, ModelDescription
from .run import Trajectory

EXACT = "exact"
"""The reference's default model; its other models are simplifications from papers."""


class ExactEngine(Engine):
    """SciPy's DOP853, as an engine declares itself."""

    name = "reference"
    version = f"scipy {scipy.__version__}"
    methods = (Method("DOP853", 8),)
    reads_mjcf = False


class ReferenceModel(BoundModel):
    """The equations of motion of a scene, or one of a paper's simplifications, solved.

    The step is chosen by error control; the ``step`` of `simulate` is only the grid on
    which ``times`` lie.
    """

    @property
    def solved(self) -> EquationsOfMotion:
        """The exact scene, or one of the paper's simplifications."""
        return self.scene.variants.get(self.name, self.scene)

    @cached_property
    def described(self) -> tuple[ModelDescription, None]:
        """That it has the equations that are solved."""
        return ModelDescription(equations=(self.solved, self.case.parameters)), None

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """The coordinates of states, the reference's own included."""
        return self.solved.coordinates

    @property
    def origin(self) -> System:
        """Refuse: it has no joints.

        Raises
        ------
        Unsupported
        """
        raise Unsupported(f"{self.engine.name} has no joints")

    def unsupported_reason(self, case: Case, method: Method | None) -> str | None:
        """Return the reason why the reference cannot run this case, or None."""
        return "the reference's loops are always closed" if case.inconsistency else None

    def simulate(self, case: Case, method: Method, step: float, times: Array) -> Trajectory:
        """Solve from ``case.start_time``; `solver.solve` states the bound."""
        scene, p = self.solved, self.case.parameters
        solution = solve(scene, p, scene.state(case.state), times, case.start_time)
        return Trajectory(
            times=solution.times,
            values=scene.observe(solution.states, p),
            clock=solution.times,
            steps=round((solution.times[-1] - case.start_time) / step),
            rhs_evaluations=solution.rhs_evaluations,
        )

    def accelerations(self, times: Array, states: Array, method: Method | None = None) -> Array:
        """Return accelerations (k, n) at ``times`` (k,) and ``states`` (k, 2 n)."""
        n = len(self.solved.coordinates)
        derivative = self.solved.right_hand_side(self.case.parameters)
        return np.array([derivative(t, x)[n:] for t, x in zip(times, states, strict=True)])

    def mass_matrices(self, states: Array, method: Method | None = None) -> Array:
        """Return mass matrices (k, n, n) at ``states`` (k, 2 n)."""
        c, n = self.solved.coefficients(self.case.parameters), len(self.solved.coordinates)
        return np.array([np.array(self.solved.mass_matrix(x[:n], c), dtype=float) for x in states])

    def linearise(self, state: Array, time: float = 0.0) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about a state of rest."""
        return linearise(self.solved, self.case.parameters, state)


class ReferenceEngine(Adapter):
    """The hand-written equations of motion, solved by SciPy's DOP853."""

    bound = ReferenceModel

    def __init__(self) -> None:
        super().__init__(ExactEngine())

    def models(self, scene: str) -> tuple[str, ...]:
        """Return the reference's models of a scene, default first."""
        return (EXACT, *get_scene(scene).variants)

    def read_source(self, scene: str, model: str) -> Mjcf:
        """Return that it has no file."""
        return NO_FILE
