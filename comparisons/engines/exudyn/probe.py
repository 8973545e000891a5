"""What Exudyn's own system of a model tells: mass, forces, constraints, and their derivatives."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space

from ....reference.differences import by_differences, derivative, one_by_one
from ..protocol import EngineError

Array = NDArray[np.float64]

NEWTON_TOLERANCE = 1e-11
"""Newton iterates until the increment of the coordinates is below this (m, rad).

A tolerance on the residual would be in the model's newtons, and lie below rounding for a
stiff spring or above the signal for a light body. Increments of a full Newton iteration
converge quadratically, so what is left after the last is far smaller than the tolerance
(those of a modified one fall by a constant factor, and what is left is about as large);
rounding of coordinates of size 1 (eps) is 4 orders below it.
"""

WORK_POINTS = 12
"""Gauss points on the way along which strain energy is the work done; the forces are smooth
there: what is left out lies below rounding."""

SAME = 1e-12
"""Part of a constraint's row that is left of one that the scene's coordinates keep."""

STEADY_ITERATIONS = 20
"""Of Newton's method for the shape of a beam that turns steadily."""


class Probe:
    """Exudyn's matrices and forces at single states of a system.

    Coordinates are those of Exudyn, Q (N,), rates V (N,); there are m constraints.
    """

    def __init__(self, exudyn: Any, system: Any, settings: Any) -> None:
        self.system = system
        self.mbs = system.mbs
        self.settings = settings
        self.current = exudyn.ConfigurationType.Current
        self.solver = exudyn.MainSolverImplicitSecondOrder()
        self.solver.InitializeSolver(self.mbs, settings)
        self.size = int(self.solver.GetODE2size())
        self.constraints = int(self.solver.GetAEsize())

    def place(self, time: float, coordinates: Array, rates: Array) -> None:
        """Set time and state."""
        data = self.mbs.systemData
        data.SetODE2Coordinates(coordinates, configuration=self.current)
        data.SetODE2Coordinates_t(rates, configuration=self.current)
        data.SetTime(time, self.current)

    def mass(self) -> Array:
        """Return the mass matrix (N, N)."""
        self.solver.ComputeMassMatrix(self.mbs)
        matrix: Array = np.array(self.solver.GetSystemMassMatrix())[: self.size, : self.size]
        return matrix

    def forces(self) -> Array:
        """Return generalised forces, velocity-dependent inertia terms included (N,)."""
        self.solver.ComputeODE2RHS(self.mbs)
        forces: Array = np.array(self.solver.GetSystemResidual())[: self.size]
        return forces

    def stiffness(self) -> Array:
        """Return minus the derivative of the forces (N, N)."""
        only = {"scalarFactor_ODE2": 1.0, "scalarFactor_ODE2_t": 0.0, "scalarFactor_ODE1": 0.0}
        self.solver.ComputeJacobianODE2RHS(self.mbs, **only)
        matrix: Array = -np.array(self.solver.GetSystemJacobian())[: self.size, : self.size]
        return matrix

    def whole_stiffness(self, coordinates: Array, rates: Array) -> Array:
        """Return minus the derivative of all forces (N, N), by differences.

        Exudyn's own leaves out how loads change, as the torque of a weight does.
        """

        def force(moved: Array) -> Array:
            self.place(0.0, moved, rates)
            return self.forces()

        return -by_differences(one_by_one(force), coordinates)[1]

    def jacobian(self) -> Array:
        """Return the Jacobian of the constraints (m, N).

        Rows are empty where a joint in space is used in the plane.
        """
        if not self.constraints:
            return np.zeros((0, self.size))
        none = {"scalarFactor_ODE2": 0.0, "scalarFactor_ODE2_t": 0.0, "scalarFactor_ODE1": 0.0}
        self.solver.ComputeJacobianODE2RHS(self.mbs, **none)  # clears what the next one adds to
        self.solver.ComputeJacobianAE(
            self.mbs, **{**none, "scalarFactor_ODE2": 1.0}, velocityLevel=False
        )
        matrix: Array = np.array(self.solver.GetSystemJacobian())[self.size :, : self.size]
        return matrix

    def evaluate_constraints(self) -> None:
        """Put how far loops are open [m] into the solver's residual."""
        try:
            self.solver.ComputeAlgebraicEquations(self.mbs, velocityLevel=False)
        except RuntimeError as error:
            if "size mismatch" not in str(error):  # of Exudyn before 1.12
                raise
            alpha = self.settings.timeIntegration.generalizedAlpha
            rates, alpha.useIndex2Constraints = alpha.useIndex2Constraints, False
            self.solver.ComputeNewtonResidual(self.mbs, self.settings)
            alpha.useIndex2Constraints = rates

    def violations(self, clock: Array, coordinates: Array, rates: Array) -> Array:
        """Return the norms of the constraints' residuals and of their rates (2, k).

        Parameters
        ----------
        clock : array (k,)
        coordinates, rates : array (k, N)
        """
        residuals = np.empty((2, len(clock)))
        for i, state in enumerate(zip(clock, coordinates, rates, strict=True)):
            self.place(*state)
            self.evaluate_constraints()
            residuals[0, i] = np.linalg.norm(np.array(self.solver.GetSystemResidual())[self.size :])
            residuals[1, i] = np.linalg.norm(self.jacobian() @ rates[i])
        return residuals

    def motion(self, time: float, state: Array) -> tuple[Array, Array]:
        """Return accelerations (N,) and constraint multipliers (m,) at a scene state (2 n,).

        Solves ``M A + C^T lambda = f`` with ``C A = -(dC/dt) V``.
        """
        q, v = np.split(state, 2)
        coordinates, rates = self.system.place(q, v)
        self.place(time, coordinates, rates)
        self.mbs.systemData.SetDataCoordinates(self.system.angles(q), configuration=self.current)
        mass, forces, jacobian = self.mass(), self.forces(), self.jacobian()
        slope = self.slope(coordinates, rates) @ rates
        corner = np.diag((~np.any(jacobian, axis=1)).astype(float))  # no multiplier without force
        matrix = np.block([[mass, jacobian.T], [jacobian, corner]])
        try:
            solution = np.linalg.solve(matrix, np.concatenate([forces, -slope]))
        except np.linalg.LinAlgError as error:
            raise EngineError("singular", f"accelerations are not determined at {state}") from error
        return solution[: self.size], solution[self.size :]

    def slope(self, coordinates: Array, direction: Array) -> Array:
        """Return the derivative of the constraint Jacobian in a direction (m, N).

        Leaves Exudyn at a state nearby.
        """
        length = np.max(np.abs(direction))
        if not self.constraints or length == 0:
            return np.zeros((self.constraints, self.size))

        def at(distance: float) -> Array:
            moved = coordinates + distance / length * direction
            self.mbs.systemData.SetODE2Coordinates(moved, configuration=self.current)
            return self.jacobian()

        return np.asarray(length * derivative(at))

    def constraint_stiffness(self, coordinates: Array, multipliers: Array) -> Array:
        """Return the derivative of the constraint forces ``C^T lambda``, lambda kept (N, N)."""
        columns = [self.slope(coordinates, unit).T @ multipliers for unit in np.eye(self.size)]
        return np.array(columns).T

    def unit_rates(self) -> Array:
        """Return the rates (N, n) that the constraints leave, for unit scene rates.

        Of a system that deforms while it turns, those of the turning frame come after the angle's.

        Raises
        ------
        EngineError
            ``singular``, if the scene's rates do not tell the motion here.
        """
        at = np.array(self.mbs.systemData.GetODE2Coordinates(configuration=self.current))
        if self.system.turning is not None:
            return np.asarray(self.system.turning.basis(at))
        jacobian, readout = self.jacobian(), self.system.readout_at(at)
        n = len(readout)
        if self.constraints + n > self.size:  # the scene's coordinates keep some of them themselves
            others = jacobian - jacobian @ np.linalg.pinv(readout) @ readout
            jacobian = jacobian[np.any(np.abs(others) > SAME * np.max(np.abs(jacobian)), axis=1)]
        rows = np.vstack([jacobian, readout])
        wanted = np.vstack([np.zeros((len(jacobian), n)), np.eye(n)])
        if rows.shape[0] != self.size or np.linalg.cond(rows) > 1e12:
            raise EngineError("singular", "the scene's coordinates do not tell the motion here")
        return np.linalg.solve(rows, wanted)

    def turning_integrals(self, coordinates: Array, rates: Array) -> dict[str, Array]:
        """Return energy [J] and angular momentum [kg m^2/s] at samples (k, N).

        The strain energy is the work against Exudyn's forces on the straight way from the
        undeformed to the deformed shape in the hub frame.
        """
        turning, mass = self.system.turning, self.mass()
        nodes, weights = np.polynomial.legendre.leggauss(WORK_POINTS)
        integrals = np.empty((2, len(rates)))
        for i, (at, speed) in enumerate(zip(coordinates, rates, strict=True)):
            momentum, shape = mass @ speed, turning.shape(at)
            work = 0.0
            for share, weight in zip((1 + nodes) / 2, weights / 2, strict=True):
                self.place(0.0, share * shape, np.zeros(self.size))
                work -= weight * (self.forces() @ shape)
            integrals[:, i] = momentum @ speed / 2 + work, momentum @ turning.rates(at)
        return {"energy": integrals[0], "momentum": integrals[1]}

    def rotating(self, speed: float) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), of small motions about steady rotation.

        In the frame that turns, with the shape S, ``M S'' + 2 speed G S' + f(S) = speed^2 D
        (X + S)``: G and D follow from M and the turn by 90 degrees, f and its derivative are
        Exudyn's. Exudyn's own eigenvalues leave out what speed does.
        """
        mass, quarter, free = self.mass(), self.system.turning.quarter, self.free_shapes()
        self.place(0.0, self.steady_shape(speed), np.zeros(self.size))
        stiffness = self.stiffness() - speed**2 * quarter.T @ mass @ quarter
        matrices = mass, 2 * speed * mass @ quarter, stiffness
        inner, gyroscopic, stiff = (free.T @ matrix @ free for matrix in matrices)
        return inner, gyroscopic, stiff

    def steady_shape(self, speed: float) -> Array:
        """Return the shape (N,) that a steady rotation stretches the system into.

        Raises
        ------
        EngineError
            ``not_at_rest``, if Newton's method finds none, or one that would be left.
        """
        turning, free, still = self.system.turning, self.free_shapes(), np.zeros(self.size)
        pull = speed**2 * turning.quarter.T @ self.mass() @ turning.quarter
        shape = still
        for _ in range(STEADY_ITERATIONS):
            self.place(0.0, shape, still)
            left = free.T @ (self.forces() + pull @ (turning.reference + shape))
            stiffness = free.T @ (self.stiffness() - pull) @ free
            change = free @ np.linalg.solve(stiffness, left)
            shape = shape + change
            if np.max(np.abs(change)) < NEWTON_TOLERANCE:
                if np.min(np.linalg.eigvalsh(stiffness)) > 0:
                    return shape
                break
        raise EngineError("not_at_rest", f"no steady shape found at {speed} rad/s")

    def free_shapes(self) -> Array:
        """Return a basis (N, n) of the shapes that the constraints leave, the angle kept.

        They are linear in the frame that turns. What no constraint holds stands alone in them:
        summed up with coordinates that stretch, those that bend would lose half their digits.
        """
        still, plane = np.zeros(self.size), self.system.turning.plane
        self.place(0.0, still, still)
        rows = np.vstack([self.jacobian(), np.eye(1, self.size)]) @ plane
        rows = np.where(np.abs(rows) > SAME * np.max(np.abs(rows)), rows, 0.0)
        bound = np.any(rows, axis=0)
        return np.hstack([plane[:, ~bound], plane[:, bound] @ null_space(rows[:, bound])])
