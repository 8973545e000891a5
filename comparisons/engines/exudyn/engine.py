"""Exudyn behind the public protocol, for every scene that has an ``exudyn_model`` module."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import reduce
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space

from ....models.placement import world_axes
from ....models.readout import with_lengths, without_lengths
from ....models.tables import table_of
from ....reference import get_scene
from ....reference.differences import by_differences, derivative, one_by_one
from ....reference.scene import Case
from ..protocol import (
    Engine,
    EngineError,
    Method,
    ModelDescription,
    Motion,
    Option,
    System,
    Unsupported,
    import_library,
    refuse_older,
)

Array = NDArray[np.float64]

LEAST_VERSION = "1.10"
"""Oldest that was run with all checks."""

EXPLICIT = (
    Method("ExplicitEuler", 1, "ExplicitEuler"),
    Method("ExplicitMidpoint", 2, "ExplicitMidpoint"),
    Method("RK33", 3, "RK33"),
    Method("RK44", 4, "RK44"),
    Method("DOPRI5", 5, "DOPRI5"),
    Method("RK67", 6, "RK67"),
)
IMPLICIT = (
    Method("GeneralizedAlpha", 2, linear_scheme="generalized_alpha"),
    Method("TrapezoidalIndex2", 2, linear_scheme="trapezoidal"),
)
"""As ``exudyn.DynamicSolverType`` spells them.

VelocityVerlet is left out: it is of order 1 where forces depend on velocities, and still
under test. The implicit ones have no ``scheme``, since constraints are part of theirs.
"""

NEWTON_TOLERANCE = 1e-11
"""Newton iterates until the increment of the coordinates is below this (m, rad).

A tolerance on the residual would be in the model's newtons, and lie below rounding for a
stiff spring or above the signal for a light body. Increments of a full Newton iteration
converge quadratically, so that the error after the last is far smaller than the tolerance
(those of a modified iteration fall by a constant factor, and the error is about as large);
round-off of coordinates of size 1 (eps) is 4 orders below it.
"""

WORK_POINTS = 12
"""Gauss points on the path along which strain energy is the work done; the forces are smooth, and
the truncation error is below round-off."""

SAME = 1e-12
"""Largest relative residual of a constraint's row in the span of the scene's coordinates."""

STEADY_ITERATIONS = 20
"""Most iterations of Newton's method for the shape of a beam in steady rotation."""

NEWTON = Option(
    "newton_tolerance", "m, rad", NEWTON_TOLERANCE, (1e-4, 1e-6, 1e-8, 1e-11), "solver tolerance"
)

NO_ERROR_CONTROL = 1e300
"""Absolute tolerance of DOPRI5, which compares its error estimate and asks for smaller
steps even where automatic steps are switched off."""

LINEAR_STEPS = (2e-5, 1e-5)
"""Relative steps of the forward differences that linearise, whose error of order 1 is extrapolated.
With Exudyn's default, 1e-7, round-off is 5e-10 of the stiffness if a coordinate at rest is not 0.
"""

AT_REST = 1e-9
"""Largest inertia force at a rest state, relative to the larger of stiffness * 1 m (or rad)
and mass * 1 m/s^2: far above rounding, and then without effect on the stiffness."""


class Exudyn(Engine):
    """Exudyn.

    Attributes
    ----------
    name, version : str
    methods : tuple of Method
    adaptive_step : bool
        Let Exudyn shorten steps, as it does by default; off, so that a step that fails is
        an error, and only there to be provoked.
    newton_tolerance : float
        Of the implicit methods, see `NEWTON_TOLERANCE`.

    Raises
    ------
    EngineUnavailableError
        If exudyn cannot be imported, or is older than `LEAST_VERSION`.
    """

    name = "exudyn"
    reads_mjcf = False
    methods: tuple[Method, ...] = EXPLICIT + IMPLICIT
    adaptive_step = False
    newton_tolerance = NEWTON_TOLERANCE

    def __init__(self) -> None:
        self.exudyn = import_library("exudyn", cure)
        self.version = str(self.exudyn.__version__)
        refuse_older(self.name, self.version, LEAST_VERSION)
        self.probes: dict[bool, tuple[Any, Probe]] = {}

    def models(self, scene: str) -> tuple[str, ...]:
        """Return the names of the Exudyn models of a scene, default first."""
        return tuple(models(scene))

    def describe_model(self, system: System) -> ModelDescription:
        """Return the description of a model."""
        case, source = system.case, self.source(system.case, system.model)
        p = case.parameters
        return ModelDescription(
            constrained=bool(source.constrained),
            reactions=source.reactions,
            equations=source.equations(p) if source.equations else None,
            elements=source.discrete(p) if source.discrete else None,
            element_order=source.element_order(p),
            unplaceable_reason=unplaceable_reason(source, case, system.model),
        )

    def unsupported_reason(self, system: System, method: Method | None) -> str | None:
        """Return the reason why this method cannot run this system, or None."""
        source = self.source(system.case, system.model)
        if system.case.inconsistency:
            return "Exudyn's joints take only an assembled mechanism: no loop can start open"
        if method is not None and source.constrained and is_explicit(method):
            return (
                f"{system.model} has algebraic constraints, which Exudyn's explicit solvers cannot "
                f"keep; use {' or '.join(item.name for item in IMPLICIT)}"
            )
        if system.case.placement:
            return None  # what `unplaceable_reason` knows
        reason: str | None = source.unsupported_reason(system.case.parameters)
        return reason

    def options(self, system: System, method: Method) -> tuple[Option, ...]:
        """Return the options that limit accuracy: the tolerance of Newton's method."""
        return () if is_explicit(method) else (NEWTON,)

    def simulate(self, system: System, method: Method, step: float, times: Array) -> Motion:
        """Integrate from ``system.start_time`` with a fixed step; ``times`` lie on its grid.

        A system that deforms while it turns also shows its energy and angular momentum.
        """
        case, model, start = system.case, system.model, system.start_time
        source = self.source(case, model)
        with self.opened(case, model) as built:
            place_initial(self.exudyn, built, np.append(system.positions, system.velocities))
            settings = self.settings(method, start, step, source.large)
            solver = self.solver(method)
            solver.InitializeSolver(built.mbs, settings)
            solver.it.maxStepSize = step  # as asked, not as the difference of two times
            solver.timer.useTimer = False
            begin = perf_counter()
            try:
                coords, rates, angles, clock, steps = integrate_samples(
                    built.mbs, solver, settings, step, times
                )
            finally:
                seconds = perf_counter() - begin
                solver.FinalizeSolver(built.mbs, settings)
            if source.discrete:
                frames = [
                    built.turning.in_frame(*row)[:2] for row in zip(coords, rates, strict=True)
                ]
                q, v = np.moveaxis(np.array(frames), 1, 0)
            else:
                q, v = built.states(coords, rates, angles)
            values = dict(built.outputs(coords.T, rates.T))
            if source.constrained:
                probe = Probe(self.exudyn, built, self.settings(IMPLICIT[0], 0.0, 1.0))
                apart = probe.violations(clock, coords, rates)
                values |= zip(("position_violation", "velocity_violation"), apart, strict=True)
            motion = Motion(
                q,
                v,
                clock,
                steps,
                {"rejected_steps": int(solver.it.rejectedAutomaticStepSizeSteps)},
                evaluations(solver, method, steps),
                None if is_explicit(method) else int(solver.it.newtonStepsCount),
                changes(solver, step),
                seconds,
                values,
            )
        if built.turning is None:
            return motion
        with quiet(self.exudyn):
            probe = self.probe(case, model, bodies=True)
            return replace(motion, observables=values | probe.turning_integrals(coords, rates))

    def accelerations(
        self, system: System, time: float, positions: Array, velocities: Array
    ) -> Array:
        """Return accelerations (n,) at a time and a state.

        Mass matrix, forces (with the load at that time) and constraint Jacobian are
        Exudyn's; the initial accelerations that Exudyn computes have 8 correct digits only.
        """
        return self.motion(system, time, positions, velocities)[0]

    def reactions(
        self, system: System, time: float, positions: Array, velocities: Array
    ) -> dict[str, float]:
        """Return the forces in joints by name, from the multipliers of the constraints."""
        multipliers = self.motion(system, time, positions, velocities)[1]
        rows = self.probe(system.case, system.model).system.reactions
        names = self.source(system.case, system.model).reactions
        return {} if rows is None else dict(zip(names, (rows @ multipliers).tolist(), strict=True))

    def motion(
        self, system: System, time: float, positions: Array, velocities: Array
    ) -> tuple[Array, Array]:
        """Return accelerations (n,) and the system's multipliers (m,) at a time and a state."""
        with quiet(self.exudyn):
            probe = self.probe(system.case, system.model)
            moved, multipliers = probe.motion(time, np.append(positions, velocities))
            built = probe.system
            placed = built.place(positions, velocities)
            if built.turning is None:
                return built.readout_at(placed[0]) @ moved, multipliers
            frame = built.turning.in_frame(*placed, moved)
            return frame[2][: len(positions)], multipliers

    def mass_matrix(self, system: System, positions: Array) -> Array:
        """Return the mass matrix (n, n) of the coordinates at positions (n,).

        Exudyn's mass matrix on the nullspace of its constraint Jacobian, in the basis of
        unit rates of the scene's coordinates. A system that deforms while it turns counts as
        rigid where positions are those of the hub alone; else the hub has the row and the column
        of the identity where its motion is prescribed.
        """
        source, n = self.source(system.case, system.model), len(positions)
        with quiet(self.exudyn):
            probe = self.probe(system.case, system.model, bodies=True)
            probe.place(system.start_time, *probe.system.place(positions, 0 * positions))
            basis = probe.unit_rates()[:, :n]
            matrix: Array = basis.T @ probe.mass() @ basis
        if n > 1 and source.prescribed(system.case.parameters):
            matrix[0, :] = matrix[:, 0] = np.eye(1, n)
        return completed(system, positions, matrix)

    def linearised(self, system: Any, settings: Any, step: float) -> Array:
        """Return Exudyn's M, K, C (3, m, m) by differences of a relative step."""
        settings.staticSolver.newton.numericalDifferentiation.relativeEpsilon = step
        return np.array([np.array(one) for one in system.mbs.ComputeLinearizedSystem(settings)])

    def linearise(self, system: System) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about a state of rest.

        Of a system that deforms while it turns: about steady rotation with the speed of the
        state, in the coordinates that are left where the hub keeps it; n is their number.

        ``ComputeLinearizedSystem``, projected as in `mass_matrix`; K then also takes the
        change of the directions of the constraint forces. Exudyn leaves out what inertia
        forces add to K, so the state must have none.

        Raises
        ------
        EngineError
            ``not_at_rest``, if the state accelerates or, with constraints, moves.
        Unsupported
            Of weights without constraints.
        """
        case, model = system.case, system.model
        if case.parameters.has_gravity and not self.source(case, model).constrained:
            raise Unsupported(
                f"in {model} round-off of the weights leaves few digits of the stiffness K"
            )
        state = np.append(system.positions, system.velocities)
        with quiet(self.exudyn):
            hub_case = in_hub_frame(case, float(system.positions[0]))
            probe = self.probe(hub_case, model, bodies=True)
            if probe.system.turning is not None:
                return probe.rotating(float(system.velocities[0]))
        with self.opened(case, model) as built:
            settings = self.settings(IMPLICIT[0], 0.0, 1.0)
            probe = Probe(self.exudyn, built, settings)
            acceleration, reaction = probe.motion(system.start_time, state)
            place_initial(self.exudyn, built, state)
            coarse, fine = (self.linearised(built, settings, step) for step in LINEAR_STEPS)
            mass, stiffness, damping = 2 * fine - coarse
            placed = built.place(system.positions, system.velocities)
            if get_scene(case.scene).quaternions:
                stiffness = probe.whole_stiffness(*placed)
            stiffness = stiffness + probe.constraint_stiffness(placed[0], reaction)
            probe.place(0.0, *placed)
            basis = probe.unit_rates()
            moves = probe.constraints > 0 and bool(np.any(placed[1]))
            inertia = basis.T @ mass @ acceleration
        projected = [basis.T @ matrix @ basis for matrix in (mass, damping, stiffness)]
        scale = max(np.max(np.abs(projected[2])), np.max(np.abs(projected[0])))
        if moves or np.max(np.abs(inertia)) > AT_REST * scale:
            raise EngineError(
                "not_at_rest",
                f"Exudyn linearises {model} about rest states only: at {state.tolist()} it "
                + ("moves" if moves else "accelerates"),
            )
        scene, names = get_scene(case.scene), system.joints
        damping, stiffness = (without_lengths(m, scene, names, state) for m in projected[1:])
        return completed(system, system.positions, projected[0]), damping, stiffness

    def source(self, case: Case, model: str) -> Any:
        """Return the named Exudyn model of a case's scene."""
        return models(case.scene)[model]

    def system(self, case: Case, model: str) -> Any:
        """Return the assembled system of a case."""
        source = self.source(case, model)
        return source.build(case.parameters, case.placement)

    @contextmanager
    def opened(self, case: Case, model: str) -> Iterator[Any]:
        """Build the system of a case, with Exudyn's console silent; free its memory after."""
        with quiet(self.exudyn):
            system = self.system(case, model)
            try:
                yield system
            finally:
                system.container.Reset()

    def probe(self, case: Case, model: str, bodies: bool = False) -> Probe:
        """Return a probe into the system of a case, or into its bodies without what drives them.

        The last one of each is kept, since systems are slow to build.
        """
        source = self.source(case, model)
        if bodies:
            case = replace(case, parameters=source.bodies(case.parameters))
        key = case.scene, model, case.parameters, case.placement, source
        if bodies not in self.probes or self.probes[bodies][0] != key:
            if bodies in self.probes:
                self.probes.pop(bodies)[1].system.container.Reset()
            built = self.system(case, model)
            self.probes[bodies] = (
                key,
                Probe(self.exudyn, built, self.settings(IMPLICIT[0], 0.0, 1.0)),
            )
        return self.probes[bodies][1]

    def solver(self, method: Method) -> Any:
        """Return a new solver of Exudyn for a method."""
        if is_explicit(method):
            return self.exudyn.MainSolverExplicit()
        return self.exudyn.MainSolverImplicitSecondOrder()

    def settings(self, method: Method, start: float, step: float, large: bool = False) -> Any:
        """Return Exudyn's settings for a method with this step, from this time on.

        A large system keeps its Jacobian, sparse, while the iteration converges.
        """
        settings = self.exudyn.SimulationSettings()
        assign(settings, "solution.file.write", False)
        assign(settings, "solution.sensors.active", False)
        settings.staticSolver.verboseMode = 0
        time = settings.timeIntegration
        time.verboseMode = 0
        span = {"startTime": start, "endTime": start + step}
        with any_values(self.exudyn):  # Exudyn runs before t = 0, but refuses such a start time
            time.SetDictionary({**time.GetDictionary(), **span})
        time.numberOfSteps = 1
        time.adaptiveStep = self.adaptive_step
        time.automaticStepSize = False
        time.absoluteTolerance = NO_ERROR_CONTROL
        solver = getattr(self.exudyn.DynamicSolverType, method.name)
        assign(settings, "timeIntegration.solverType", solver)
        # what SolveDynamic sets for it
        index_2 = method.name == "TrapezoidalIndex2"
        time.generalizedAlpha.useNewmark = index_2
        time.generalizedAlpha.useIndex2Constraints = index_2
        time.newton.useModifiedNewton = large
        if large:
            assign(settings, "linearSolver.solverType", self.exudyn.LinearSolverType.EigenSparse)
        assign(settings, "timeIntegration.newton.residualMode", 1)  # judge increments
        time.newton.relativeTolerance = self.newton_tolerance
        time.newton.absoluteTolerance = self.newton_tolerance
        return settings


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
        return np.array(self.solver.GetSystemMassMatrix()[: self.size, : self.size])

    def forces(self) -> Array:
        """Return generalised forces, velocity-dependent inertia terms included (N,)."""
        self.solver.ComputeODE2RHS(self.mbs)
        return np.array(self.solver.GetSystemResidual()[: self.size])

    def stiffness(self) -> Array:
        """Return minus the derivative of the forces (N, N)."""
        only = {"scalarFactor_ODE2": 1.0, "scalarFactor_ODE2_t": 0.0, "scalarFactor_ODE1": 0.0}
        self.solver.ComputeJacobianODE2RHS(self.mbs, **only)
        return -np.array(self.solver.GetSystemJacobian()[: self.size, : self.size])

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
        return np.array(self.solver.GetSystemJacobian()[self.size :, : self.size])

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
            ``singular``, if the scene's rates do not determine the motion here.
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
            raise EngineError(
                "singular", "the scene's coordinates do not determine the motion here"
            )
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

        They are linear in the frame that turns. Unconstrained coordinates are separate columns:
        summed up with coordinates that stretch, those that bend would lose half their digits.
        """
        still, plane = np.zeros(self.size), self.system.turning.plane
        self.place(0.0, still, still)
        rows = np.vstack([self.jacobian(), np.eye(1, self.size)]) @ plane
        rows = np.where(np.abs(rows) > SAME * np.max(np.abs(rows)), rows, 0.0)
        bound = np.any(rows, axis=0)
        return np.hstack([plane[:, ~bound], plane[:, bound] @ null_space(rows[:, bound])])


def unplaceable_reason(source: Any, case: Case, model: str) -> str | None:
    """Return the reason why a model cannot be placed in the world in this way, or None."""
    if reason := source.unplaceable_reason(case.parameters):
        return str(reason)
    if get_scene(case.scene).quaternions and np.linalg.det(world_axes(case.placement)) < 0:
        return f"joints of {model} turn about given axes of frames, which are no mirror images"
    return None


def completed(system: System, positions: Array, matrix: Array) -> Array:
    """Return a mass matrix with the inertia that lengths of quaternions have in the scene."""
    scene = get_scene(system.case.scene)
    return with_lengths(matrix, scene, system.case.parameters, system.joints, positions)


def is_explicit(method: Method) -> bool:
    """Return True if a method is one of the explicit solvers, whatever order is claimed of it."""
    return method.name in {item.name for item in EXPLICIT}


def cure(reason: str) -> str:
    """Return the cure where Exudyn cannot be imported for this reason."""
    if "libGL" in reason:
        return "install OpenGL, on Debian with: apt-get install libgl1"
    return "install it with: pip install exudyn (on Debian it needs libgl1)"


def models(scene: str) -> Mapping[str, Any]:
    """Return the Exudyn models of a scene by name, default first; none if it has none."""
    name = f"{__package__.partition('.')[0]}.models.{scene}.exudyn_model"
    return table_of(name, "MODELS", {})


def in_hub_frame(case: Case, turn: float) -> Case:
    """Return a case whose gravity is given in a frame turned by an angle [rad] about z."""
    p = case.parameters
    if not p.has_gravity:
        return case
    gravity = (p.gravity_x + 1j * p.gravity_y) * np.exp(-1j * turn)
    return replace(case, parameters=p.replace(gravity_x=gravity.real, gravity_y=gravity.imag))


@contextmanager
def quiet(exudyn: Any) -> Iterator[None]:
    """Keep Exudyn from writing to the console."""
    saved = exudyn.config.printToConsole
    exudyn.config.printToConsole = False
    try:
        yield
    finally:
        exudyn.config.printToConsole = saved


def place_initial(exudyn: Any, system: Any, state: Array) -> None:
    """Set the initial values of a system to a scene state (2 n,)."""
    initial = exudyn.ConfigurationType.Initial
    q, v = np.split(state, 2)
    coordinates, rates = system.place(q, v)
    system.mbs.systemData.SetODE2Coordinates(coordinates, configuration=initial)
    system.mbs.systemData.SetODE2Coordinates_t(rates, configuration=initial)
    system.mbs.systemData.SetDataCoordinates(system.angles(q), configuration=initial)


def evaluations(solver: Any, method: Method, steps: int) -> int:
    """Return the number of evaluations of forces, those for Newton's Jacobians left out."""
    if is_explicit(method):
        return steps * int(solver.GetNumberOfStages())
    return steps + int(solver.it.newtonStepsCount)


def integrate_samples(
    mbs: Any, solver: Any, settings: Any, step: float, times: Array
) -> tuple[Array, Array, Array, Array, int]:
    """Run an initialised solver from sample to sample.

    One solver does all: its memory (the algorithmic accelerations of GeneralizedAlpha) persists
    through a sample, which therefore does not act on the motion. It counts its steps and its time
    from the start of each leg.

    Returns
    -------
    coordinates, rates : arrays (n_t, N)
    angles : array (n_t, h)
        Exudyn's data coordinates, which count the turns of hinges.
    clock : array (n_t,)
    steps : int

    Raises
    ------
    EngineError
        ``solver``, if Exudyn gave up.
    """
    data, progress = mbs.systemData, solver.it
    indices = np.rint((times - progress.startTime) / step).astype(int)
    legs = np.diff(indices, prepend=0).tolist()
    rows, steps = [], 0
    for leg in legs:
        if leg:
            progress.startTime = begin = data.GetTime()
            progress.endTime = begin + leg * step
            finished = solver.SolveSteps(mbs, settings)
            steps += progress.currentStepIndex - 1
            if not finished:
                reason = " ".join(str(solver.GetErrorString()).split()) or "no reason given"
                raise EngineError(
                    "solver",
                    f"Exudyn's solver found no solution at t = {progress.currentTime:.9g} s; "
                    f"try a smaller step (Exudyn: {reason})",
                )
        parts = data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetDataCoordinates()
        rows.append((*map(np.array, parts), data.GetTime()))
    coordinates, rates, angles, clock = (np.array(part) for part in zip(*rows, strict=True))
    return coordinates, rates, angles, clock, steps


def changes(solver: Any, step: float) -> tuple[str, ...]:
    """Return the inputs that the solver changed.

    Fixed steps stay the same to the bit; one that may adapt also shrinks by rounding where
    a leg ends.
    """
    taken = float(solver.it.currentStepSize)
    same = taken == step or (solver.it.adaptiveStep and abs(taken - step) <= 1e-9 * step)
    return () if same else (f"step ({taken:.9g} s instead of {step:.9g} s)",)


def assign(settings: Any, path: str, value: Any) -> None:
    """Set what `RENAMED` may have another name for."""
    *parents, name = (path if hasattr(settings, "solution") else RENAMED.get(path, path)).split(".")
    setattr(reduce(getattr, parents, settings), name, value)


RENAMED = {
    "solution.file.write": "solutionSettings.writeSolutionToFile",
    "solution.sensors.active": "solutionSettings.sensorsStoreAndWriteFiles",
    "timeIntegration.solverType": "timeIntegration.explicitIntegration.dynamicSolverType",
    "timeIntegration.newton.residualMode": "timeIntegration.newton.newtonResidualMode",
    "linearSolver.solverType": "linearSolverType",
}
"""Settings by their names of today: what Exudyn called them before 1.12."""


@contextmanager
def any_values(exudyn: Any) -> Iterator[None]:
    """Take Exudyn's settings out of its range checks, which before 1.12 no dictionary meets."""
    checks = exudyn.special.exceptions
    if not hasattr(checks, "parameterRangeChecks"):
        yield
        return
    saved = checks.parameterRangeChecks
    checks.parameterRangeChecks = False
    try:
        yield
    finally:
        checks.parameterRangeChecks = saved
