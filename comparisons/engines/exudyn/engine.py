"""Exudyn behind the `Engine` protocol, for every scene that has an ``exudyn_model`` module."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from ....models.placement import world_axes
from ....models.readout import with_lengths, without_lengths
from ....models.tables import table_of
from ....reference import get_scene
from ....reference.errors import EngineError, UnknownNameError
from ....reference.scene import Array, Case
from ..adapter import Adapter, with_attribute
from ..equations import ModelEquations
from ..protocol import Method, Option, import_library, refuse_older
from ..run import Trajectory, grid_indices
from .probe import NEWTON_TOLERANCE, Probe
from .settings import any_values, assign

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
    Method("GeneralizedAlpha", 2, linear="generalized_alpha"),
    Method("TrapezoidalIndex2", 2, linear="trapezoidal"),
)
"""As ``exudyn.DynamicSolverType`` spells them.

VelocityVerlet is left out: it is of order 1 where forces depend on velocities, and still
under test. The implicit ones have no ``scheme``, since constraints are part of theirs.
"""

NEWTON = Option(
    "newton_tolerance", "m, rad", NEWTON_TOLERANCE, (1e-4, 1e-6, 1e-8, 1e-11), "solver tolerance"
)

NO_ERROR_CONTROL = 1e300
"""Absolute tolerance of DOPRI5, which compares its error estimate and asks for smaller
steps even where automatic steps are switched off."""

LINEAR_STEPS = (2e-5, 1e-5)
"""Relative steps of the forward differences that linearise, whose error of order 1 is extrapolated.
With Exudyn's own 1e-7 a coordinate that is not 0 at rest leaves 5e-10 of the stiffness to rounding.
"""

AT_REST = 1e-9
"""Largest inertia force at a rest state, relative to the larger of stiffness * 1 m (or rad)
and mass * 1 m/s^2: far above rounding, and then without effect on the stiffness."""


class ExudynEngine(Adapter):
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
    methods: tuple[Method, ...] = EXPLICIT + IMPLICIT
    adaptive_step = False
    newton_tolerance = NEWTON_TOLERANCE

    def __init__(self) -> None:
        self.exudyn = import_library("exudyn", cure)
        self.version = str(self.exudyn.__version__)
        refuse_older(self.name, self.version, LEAST_VERSION)

    def models(self, scene: str) -> tuple[str, ...]:
        """Return the names of the Exudyn models of a scene, default first."""
        return tuple(models(scene))

    def why_not(self, case: Case, model: str, method: Method | None) -> str | None:
        """Return why this method cannot run this case on this model, or None."""
        if case.inconsistency:
            return "Exudyn's joints take only an assembled mechanism: no loop can start open"
        if method is not None and self.has_constraints(case, model) and is_explicit(method):
            return (
                f"{model} has algebraic constraints, which Exudyn's explicit solvers cannot keep; "
                f"use {' or '.join(item.name for item in IMPLICIT)}"
            )
        reason: str | None = self.model(case, model).why_not(case.parameters)
        return reason

    def has_constraints(self, case: Case, model: str) -> bool:
        """Return whether the model has algebraic constraints."""
        return bool(self.model(case, model).constrained)

    def model_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Return the equations that the model has, or converges to, None if the scene's."""
        equations = self.model(case, model).equations
        return None if equations is None else ModelEquations(*equations(case.parameters))

    def discrete_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Return the equations of motion of the model's elements, None where it has none."""
        discrete = self.model(case, model).discrete
        return (
            None if discrete is None else ModelEquations(discrete(case.parameters), case.parameters)
        )

    def element_order(self, case: Case, model: str) -> int:
        """Return the order with which the model converges as its elements are halved, or 0."""
        order: int = self.model(case, model).element_order(case.parameters)
        return order

    def options(self, case: Case, model: str, method: Method) -> tuple[Option, ...]:
        """Return what limits accuracy beside the step: where Newton's method stops."""
        return () if is_explicit(method) else (NEWTON,)

    def with_option(self, name: str, value: float) -> ExudynEngine:
        """Return this engine with an option set."""
        return with_attribute(self, name, value)

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate from ``case.start_time`` with a fixed step; ``times`` lie on its grid.

        A system that deforms while it turns also shows its energy and angular momentum.
        """
        with self.opened(case, model) as system:
            names = get_scene(case.scene).public_states
            discrete = self.discrete_equations(case, model)
            if discrete is None:
                start = get_scene(case.scene).completed(case.state)
                state = np.array([float(start[name]) for name in names])
            else:
                state = discrete.start(case)
            place_initial(self.exudyn, system, state)
            large = self.model(case, model).large
            settings = self.settings(method, case.start_time, step, large)
            solver = self.solver(method)
            solver.InitializeSolver(system.mbs, settings)
            solver.it.maxStepSize = step  # as asked, not as the difference of two times
            solver.timer.useTimer = False
            begin = perf_counter()
            try:
                coords, rates, clock, steps = integrate(system.mbs, solver, settings, step, times)
            finally:
                seconds = perf_counter() - begin
                solver.FinalizeSolver(system.mbs, settings)
            observed = np.vstack([system.readout @ coords.T, system.readout @ rates.T])
            if system.origin is not None:
                observed[: len(system.origin)] += system.origin[:, None]
            values = dict(zip(names, observed, strict=True))
            values |= system.outputs(coords.T, rates.T)
            if (scene := get_scene(case.scene)).quaternions:
                outputs = scene.observe(observed, case.parameters)
                values |= {name: outputs[name] for name in scene.observed}
            if discrete is not None:
                frames = [
                    system.turning.in_frame(*row)[:2] for row in zip(coords, rates, strict=True)
                ]
                rows = np.array(frames).reshape(len(coords), -1).T
                values |= dict(zip(discrete.scene.state_names, rows, strict=True))
            if self.has_constraints(case, model):
                probe = Probe(self.exudyn, system, self.settings(IMPLICIT[0], 0.0, 1.0))
                values |= probe.violations(clock, coords, rates)
            trajectory = Trajectory(
                times=np.asarray(times, dtype=float),
                values=values,
                clock=clock,
                steps=steps,
                rhs_evaluations=evaluations(solver, method, steps),
                newton_iterations=None if is_explicit(method) else int(solver.it.newtonStepsCount),
                seconds=seconds,
                warnings={"rejected_steps": int(solver.it.rejectedAutomaticStepSizeSteps)},
                changed=changes(solver, step),
            )
        if system.turning is None:
            return trajectory
        with self.opened_bodies(case, model) as probe:
            return replace(trajectory, values=values | probe.turning_integrals(coords, rates))

    def accelerations(self, case: Case, model: str, times: Array, states: Array) -> Array:
        """Return accelerations (k, n) at ``times`` (k,) and ``states`` (k, 2 n).

        Mass matrix, forces (with the load at that time) and constraint Jacobian are
        Exudyn's; its own start accelerations difference that Jacobian to 8 digits only.
        """
        return np.array([moved for moved, _ in self.motions(case, model, times, states)])

    def reaction_names(self, case: Case, model: str) -> tuple[str, ...]:
        """Return the outputs of the scene that are forces in joints of the model."""
        return tuple(self.model(case, model).reactions)

    def reactions(self, case: Case, model: str, times: Array, states: Array) -> dict[str, Array]:
        """Return those forces (k,) at ``times`` (k,) and ``states`` (k, 2 n).

        They are the multipliers that come with the accelerations.
        """
        multipliers = np.array([forces for _, forces in self.motions(case, model, times, states)])
        places: Mapping[str, int] = self.model(case, model).reactions
        return {name: multipliers[:, place] for name, place in places.items()}

    def motions(
        self, case: Case, model: str, times: Array, states: Array
    ) -> list[tuple[Array, Array]]:
        """Return the scene's accelerations (n,) and the multipliers (m,) at each state."""
        with self.opened(case, model) as system:
            probe = Probe(self.exudyn, system, self.settings(IMPLICIT[0], 0.0, 1.0))
            motions = [
                probe.motion(float(time), state) for time, state in zip(times, states, strict=True)
            ]
            if system.turning is None:
                return [(system.readout @ moved, multipliers) for moved, multipliers in motions]
            size = len(states[0]) // 2
            frames = [
                system.turning.in_frame(*system.place(*np.split(state, 2)), moved)[2][:size]
                for state, (moved, _) in zip(states, motions, strict=True)
            ]
            return [(a, forces) for a, (_, forces) in zip(frames, motions, strict=True)]

    def mass_matrices(self, case: Case, model: str, states: Array) -> Array:
        """Return mass matrices (k, n, n) of the scene's coordinates at ``states`` (k, 2 n).

        Exudyn's mass matrix on the nullspace of its constraint Jacobian, in the basis of
        unit rates of the scene's coordinates. A system that deforms while it turns counts as
        rigid where states are those of the hub alone; else the hub has the row and the column of
        the identity where its motion is prescribed.
        """
        with self.opened_bodies(case, model) as probe:
            matrices = []
            for state in states:
                probe.place(case.start_time, *probe.system.place(*np.split(state, 2)))
                basis = probe.unit_rates()[:, : len(state) // 2]
                matrix = basis.T @ probe.mass() @ basis
                if len(matrix) > 1 and self.model(case, model).prescribed(case.parameters):
                    matrix[0, :] = matrix[:, 0] = np.eye(1, len(matrix))
                matrices.append(self.with_lengths(case, model, state, matrix))
        return np.array(matrices)

    def linearised(self, system: Any, settings: Any, step: float) -> Array:
        """Return Exudyn's M, K, C (3, m, m) by differences of a relative step."""
        settings.staticSolver.newton.numericalDifferentiation.relativeEpsilon = step
        return np.array([np.array(one) for one in system.mbs.ComputeLinearizedSystem(settings)])

    def linearise(self, case: Case, model: str, state: Array) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about a state of rest, at ``case.start_time``.

        Of a system that deforms while it turns: about steady rotation with the speed of the
        state, in the coordinates that are left where the hub keeps it; n is their number.

        ``ComputeLinearizedSystem``, projected as in `mass_matrices`; K then also takes the
        change of the directions of the constraint forces. Exudyn leaves out what inertia
        forces add to K, so the state must have none.

        Raises
        ------
        EngineError
            ``not_at_rest``, if the state accelerates or, with constraints, moves.
        """
        with self.opened_bodies(case, model) as probe:
            if probe.system.turning is not None:
                return probe.rotating(float(state[len(state) // 2]))
        with self.opened(case, model) as system:
            settings = self.settings(IMPLICIT[0], 0.0, 1.0)
            probe = Probe(self.exudyn, system, settings)
            acceleration, reaction = probe.motion(case.start_time, state)
            place_initial(self.exudyn, system, state)
            coarse, fine = (self.linearised(system, settings, step) for step in LINEAR_STEPS)
            mass, stiffness, damping = 2 * fine - coarse
            placed = system.place(*np.split(state, 2))
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
        mass = self.with_lengths(case, model, state, projected[0])
        names, scene = self.coordinates(case, model), get_scene(case.scene)
        damping, stiffness = (without_lengths(m, scene, names, state) for m in projected[1:])
        return mass, damping, stiffness

    def with_lengths(self, case: Case, model: str, state: Array, matrix: Array) -> Array:
        """Return a mass matrix with the inertia that lengths of quaternions have in the scene."""
        names, scene = self.coordinates(case, model), get_scene(case.scene)
        return with_lengths(matrix, scene, case.parameters, names, state)

    def model(self, case: Case, model: str) -> Any:
        """Return the named Exudyn model of a case's scene.

        Raises
        ------
        UnknownNameError
            If there is none.
        """
        known = models(case.scene)
        if model not in known:
            raise UnknownNameError(f"Exudyn model of {case.scene}", model, known)
        return known[model]

    def system(self, case: Case, model: str) -> Any:
        """Return the assembled system of a case."""
        source = self.model(case, model)
        if not case.placement:
            return source.build(case.parameters)
        return source.in_axes(case.parameters, world_axes(case.placement))

    def why_not_placed(self, case: Case, model: str) -> str | None:
        """Return why a model cannot be placed in the world otherwise than it stands, or None."""
        if self.model(case, model).in_axes is None:
            return f"{model} is built in the plane of x and y: Exudyn's plane elements stay in it"
        if np.linalg.det(world_axes(case.placement)) < 0:
            return f"joints of {model} turn about given axes of frames, which are no mirror images"
        return None

    @contextmanager
    def opened(self, case: Case, model: str) -> Iterator[Any]:
        """Lend the system of a case, with Exudyn's console silent; free its memory after."""
        with quiet(self.exudyn):
            system = self.system(case, model)
            try:
                yield system
            finally:
                system.container.Reset()

    @contextmanager
    def opened_bodies(self, case: Case, model: str) -> Iterator[Probe]:
        """Lend a probe into the system of a case without what drives it."""
        bodies = self.model(case, model).bodies(case.parameters)
        with self.opened(replace(case, parameters=bodies), model) as system:
            yield Probe(self.exudyn, system, self.settings(IMPLICIT[0], 0.0, 1.0))

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
        with any_values(self.exudyn):  # Exudyn runs before t = 0, but refuses to be told so
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


def is_explicit(method: Method) -> bool:
    """Return whether a method is one of the explicit solvers, whatever order is claimed of it."""
    return method.name in {item.name for item in EXPLICIT}


def cure(reason: str) -> str:
    """Return what to do where Exudyn cannot be imported for a reason."""
    if "libGL" in reason:
        return "install OpenGL, on Debian with: apt-get install libgl1"
    return "install it with: pip install exudyn (on Debian it needs libgl1)"


def models(scene: str) -> Mapping[str, Any]:
    """Return the Exudyn models of a scene by name, default first; none if it has none."""
    name = f"{__package__.partition('.')[0]}.models.{scene}.exudyn_model"
    return table_of(name, "MODELS", {})


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
    coordinates, rates = system.place(*np.split(state, 2))
    system.mbs.systemData.SetODE2Coordinates(coordinates, configuration=initial)
    system.mbs.systemData.SetODE2Coordinates_t(rates, configuration=initial)


def integrate(
    mbs: Any, solver: Any, settings: Any, step: float, times: Array
) -> tuple[Array, Array, Array, int]:
    """Run an initialised solver from sample to sample.

    One solver does all: its memory (the algorithmic accelerations of GeneralizedAlpha) goes
    on through a sample, which therefore does not act on the motion. It counts its steps and
    its time from the start of each leg, which is where its own clock stood.

    Returns
    -------
    coordinates, rates : arrays (n_t, N)
    clock : array (n_t,)
    steps : int

    Raises
    ------
    EngineError
        ``solver``, if Exudyn gave up.
    """
    data, progress = mbs.systemData, solver.it
    legs = np.diff(grid_indices(times, progress.startTime, step), prepend=0).tolist()
    size = len(data.GetODE2Coordinates())
    coordinates, rates = np.empty((len(times), size)), np.empty((len(times), size))
    clock = np.empty(len(times))
    steps = 0
    for row, leg in enumerate(legs):
        if leg:
            progress.startTime = begin = data.GetTime()
            progress.endTime = begin + leg * step
            finished = solver.SolveSteps(mbs, settings)
            steps += progress.currentStepIndex - 1
            if not finished:
                raise EngineError("solver", gave_up(solver))
        coordinates[row] = data.GetODE2Coordinates()
        rates[row] = data.GetODE2Coordinates_t()
        clock[row] = data.GetTime()
    return coordinates, rates, clock, steps


def gave_up(solver: Any) -> str:
    """Return where a solver stopped, and Exudyn's words for it."""
    reason = " ".join(str(solver.GetErrorString()).split()) or "no reason given"
    return (
        f"Exudyn's solver found no solution at t = {solver.it.currentTime:.9g} s; "
        f"try a smaller step (Exudyn: {reason})"
    )


def evaluations(solver: Any, method: Method, steps: int) -> int:
    """Return how often forces were evaluated, those for Newton's Jacobians left out."""
    if is_explicit(method):
        return steps * int(solver.GetNumberOfStages())
    return steps + int(solver.it.newtonStepsCount)


def changes(solver: Any, step: float) -> tuple[str, ...]:
    """Return what the solver changed on its own.

    Fixed steps stay the same to the bit; one that may adapt also shrinks by rounding where
    a leg ends.
    """
    taken = float(solver.it.currentStepSize)
    same = taken == step or (solver.it.adaptiveStep and abs(taken - step) <= 1e-9 * step)
    return () if same else (f"step ({taken:.9g} s instead of {step:.9g} s)",)
