"""MuJoCo as an adapter, for every scene that has MJCF."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

import numpy as np

from ....models import mjcf
from ....models.placement import world_axes
from ....models.system import System
from ....reference import get_scene
from ....reference.differences import by_differences, one_by_one
from ....reference.errors import EngineError
from ....reference.scene import Array, Case
from ..adapter import Option, refuse_older, with_attribute
from ..mjcf import MjcfAdapter
from ..protocol import Method
from ..run import VIOLATIONS, Trajectory, attempt
from .library import controlled, import_mujoco, quiet
from .runs import CompiledRun, addresses, integrate, integrate_many, joint_names, place, switch

LEAST_VERSION = "3.6"
"""Oldest that was run with all checks."""

METHODS = (
    Method("Euler", 1, "semi_implicit_euler"),
    Method("implicit", 1, "implicit_euler_velocity"),
    Method("implicitfast", 1, "implicit_euler_dampers"),
    Method("RK4", 4, "RK44"),
    Method("discrete", 1, linear="implicit_euler"),
)
"""As MuJoCo spells them; `discrete` exists from 3.13 on."""

CLOSURE_TIME = Option(
    "closure_time", "s", 2e-3, (2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4), "closure softness"
)
SOLVER_TOLERANCE = Option(
    "solver_tolerance", "1", 1e-30, (1e-2, 1e-4, 1e-8, 1e-30), "solver tolerance"
)
"""All values leave the same floor: Newton's method solves the two rows of a loop at once. CG does
not, see `extremes.cases`."""

MODELS = 256
"""Compiled models that `simulate_many` keeps, of 0.25 MB each: a map runs its points repeatedly."""


class MujocoEngine(MjcfAdapter):
    """MuJoCo.

    Attributes
    ----------
    name, version : str
    methods : tuple of Method
    accumulates_clock : bool
    least_inertia, largest_value : float
        ``mjMINVAL`` and ``mjMAXVAL``, see `Adapter`.
    closure_time : float or None
        Time constant [s] in which the closure of a model with a `mjcf.Mjcf.softened` closes.
    solver_tolerance : float or None
        Of MuJoCo's solver of constraints.
        Both are those of the model where they are None; see `options`.

    Raises
    ------
    EngineUnavailableError
        If mujoco cannot be imported, or is older than `LEAST_VERSION`.
    """

    name = "mujoco"
    accumulates_clock = True
    least_inertia = 1e-15
    largest_value = 1e10
    closure_time: float | None = None
    solver_tolerance: float | None = None

    def __init__(self) -> None:
        self.mujoco = import_mujoco()
        self.version = str(self.mujoco.__version__)
        refuse_older(self.name, self.version, LEAST_VERSION)
        known = dir(self.mujoco.mjtIntegrator)
        self.methods = tuple(m for m in METHODS if integrator_name(m.name) in known)
        self.cached_model = lru_cache(MODELS)(self.compiled)

    def why_not(self, case: Case, model: str, method: Method | None) -> str | None:
        """Return why this method cannot run this case on this model, or None."""
        source = self.source(case, model)
        if case.inconsistency and not source.closed:
            return f"no constraint closes a loop of {model}: none can start open"
        if method is not None and method.name == "discrete" and drives(source, case):
            return (
                "discrete makes springs implicit and so damps the oscillator that drives this "
                "model: the force itself would fade"
            )
        return source.why_not(case.parameters)

    def scheme(self, case: Case, model: str, method: Method) -> str | None:
        """Return the published scheme that a method is on this model.

        The implicit ones leave the constraints' forces out of their derivatives, which no
        scheme on the equations of motion alone does. Where a model has coordinates of its own
        there are many, and the scheme in Python would take far longer than the engine.
        """
        if get_scene(case.scene).discretisation_coordinates:
            return None
        implicit = method.name in ("implicit", "implicitfast")
        return None if implicit and self.has_constraints(case, model) else method.scheme

    def options(self, case: Case, model: str, method: Method) -> tuple[Option, ...]:
        """Return what limits accuracy beside the step: how a loop is closed."""
        softened = self.source(case, model).softened is not None
        return (CLOSURE_TIME, SOLVER_TOLERANCE) if softened else ()

    def with_option(self, name: str, value: float) -> MujocoEngine:
        """Return this engine with an option set."""
        return with_attribute(self, name, value)

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate from ``case.start_time`` with a fixed step; ``times`` lie on its grid.

        Raises
        ------
        EngineError
            ``step``, if it is so long that MuJoCo would soften a closure in silence.
        """
        with self.opened(case, model):
            where = case.scene, model, case.parameters, method, step, case.placement
            compiled = self.compiled(*where)
            run = self.run(case, model, compiled, times)
            data = self.mujoco.MjData(run.compiled)
            place(run.compiled, data, run.motion)
            data.time = run.start
            joints = joint_names(run.compiled)
            recorded = integrate(self.mujoco, run.compiled, data, joints, times, run.stop)
            return self.observed(case, model, run, data, recorded)

    def simulate_many(
        self, cases: Sequence[Case], model: str, method: Method, steps: Array, times: Array
    ) -> list[Trajectory | EngineError]:
        """Return what `simulate` returns of each case, or the error that it raises.

        The same to the bit, but on several threads (`mujoco_run.threads`), and cases with the
        same parameters share a model. One after the other where models of the cases differ in
        size, and before MuJoCo 3.17, which has no `mujoco.batch`.

        Parameters
        ----------
        cases : sequence of Case, k of them
        model, method
        steps : array (k,) [s]
        times : array (k, n_t) [s]
        """

        def prepare(case: Case, step: float, grid: Array) -> CompiledRun:
            where = case.scene, model, case.parameters, method, step, case.placement
            compiled = self.cached_model(*where)
            return self.run(case, model, compiled, grid)

        rows = list(zip(cases, map(float, steps), times, strict=True))
        if model in self.twins(cases[0].scene):  # a hook in Python runs on one thread only
            return super().simulate_many(cases, model, method, steps, times)
        with quiet(self.mujoco), controlled(self.mujoco, None):
            outcomes: list[Any] = [attempt(partial(prepare, *row)) for row in rows]
            ready = [i for i, run in enumerate(outcomes) if isinstance(run, CompiledRun)]
            runs = [outcomes[i] for i in ready]
            recorded = integrate_many(self.mujoco, runs)
            data = self.mujoco.MjData(runs[0].compiled) if runs else None
            for i, run, trajectory in zip(ready, runs, recorded, strict=True):
                case, step, grid = rows[i]
                if trajectory is None:
                    work = partial(self.simulate, case, model, method, step, grid)
                else:
                    work = partial(self.observed, case, model, run, data, trajectory)
                outcomes[i] = attempt(work)
        return outcomes

    def compiled(
        self,
        scene: str,
        model: str,
        parameters: Any,
        method: Method,
        step: float,
        placement: str = "",
    ) -> Any:
        """Return the compiled model of these parameters, placed so, with a method and its step.

        Raises
        ------
        EngineError
            ``step``, if it is so long that MuJoCo would soften a closure in silence.
        """
        case = Case(scene, "", parameters, placement=placement)
        longest = self.source(case, model).longest_step
        if step > longest:
            raise EngineError(
                "step",
                f"with steps above {longest:g} s MuJoCo softens the closure of {model} without a "
                f"word (refsafe), so {step:.6g} s would be a run of another model",
            )
        compiled = self.load(case, model)
        compiled.opt.timestep = step
        if self.solver_tolerance is not None:
            compiled.opt.tolerance = self.solver_tolerance
        compiled.opt.integrator = getattr(self.mujoco.mjtIntegrator, integrator_name(method.name))
        return compiled

    def run(self, case: Case, model: str, compiled: Any, times: Array) -> CompiledRun:
        """Return the run of a case on its compiled model."""
        stop = self.source(case, model).stop(case.parameters)
        motion = self.initial_motion(case, model)
        return CompiledRun(compiled, motion, case.start_time, times, stop)

    def observed(
        self, case: Case, model: str, run: CompiledRun, data: Any, recorded: Trajectory
    ) -> Trajectory:
        """Return a recorded trajectory with the scene's observables instead of joints.

        ``data`` is written to; all that is shown follows from positions and velocities.
        """
        values: dict[str, Array] = {}
        for suffix in ("", "_dot"):
            for name, sums in self.readout(case, model).items():
                rows = [factor * recorded.values[f"{j}{suffix}"] for j, factor in sums.items()]
                values[f"{name}{suffix}"] = np.sum(rows, axis=0)
        closed = self.has_constraints(case, model)
        observed = get_scene(case.scene).observed
        if observed or closed:
            values |= self.sensed(run.compiled, data, recorded.values, observed, closed)
        return replace(recorded, values=values)

    def sensed(
        self,
        compiled: Any,
        data: Any,
        values: Mapping[str, Array],
        sensors: tuple[str, ...],
        closed: bool,
    ) -> dict[str, Array]:
        """Return what the model's sensors show of recorded joints, and how far loops are open."""
        joints = joint_names(compiled)
        positions, dofs = addresses(compiled, joints)
        count = len(values[joints[0]])
        sensed = {name: np.empty(count) for name in (*sensors, *(VIOLATIONS if closed else ()))}
        for i in range(count):
            data.qpos[positions] = [values[name][i] for name in joints]
            data.qvel[dofs] = [values[f"{name}_dot"][i] for name in joints]
            self.mujoco.mj_forward(compiled, data)
            for name in sensors:
                sensed[name][i] = data.sensor(name).data[0]
            if closed:
                for name, residual in zip(VIOLATIONS, (data.efc_pos, data.efc_vel), strict=True):
                    sensed[name][i] = np.linalg.norm(residual)
        return sensed

    @contextmanager
    def opened(self, case: Case, model: str) -> Iterator[None]:
        """Keep MuJoCo silent, and give it the controls of a case."""
        driven = self.source(case, model).controls is not None
        controls = self.joint_system(case, model).controls if driven else None
        with quiet(self.mujoco), controlled(self.mujoco, controls):
            yield

    def accelerations(self, case: Case, model: str, times: Array, states: Array) -> Array:
        """Return accelerations (k, n) at ``times`` (k,) and ``states`` (k, 2 n)."""
        with self.opened(case, model):
            compiled = self.load(case, model)
            sums = self.readout(case, model).values()
            dofs = [addresses(compiled, tuple(joints))[1] for joints in sums]
            factors = [list(joints.values()) for joints in sums]
            rows = np.empty((len(states), len(dofs)))
            visits = self.visits(case, model, compiled, times, states)
            for row, data in enumerate(visits):
                rows[row] = [data.qacc[at] @ f for at, f in zip(dofs, factors, strict=True)]
        return rows

    def reaction_names(self, case: Case, model: str) -> tuple[str, ...]:
        """Return the outputs of the scene that are forces in joints of the model."""
        return tuple(self.source(case, model).reactions)

    def reactions(self, case: Case, model: str, times: Array, states: Array) -> dict[str, Array]:
        """Return those forces (k,) at ``times`` (k,) and ``states`` (k, 2 n)."""
        places, axes = self.source(case, model).reactions, world_axes(case.placement)
        forces = {name: np.empty(len(states)) for name in places}
        with self.opened(case, model):
            compiled = self.load(case, model)
            for row, data in enumerate(self.visits(case, model, compiled, times, states)):
                self.mujoco.mj_rnePostConstraint(compiled, data)
                for name, (element, axis) in places.items():
                    force = joint_force(self.mujoco, compiled, data, element)
                    forces[name][row] = force @ axes[:, axis]
        return forces

    def visits(
        self, case: Case, model: str, compiled: Any, times: Array, states: Array
    ) -> Iterator[Any]:
        """Yield the same data with all forces and accelerations at each of the states."""
        data = self.mujoco.MjData(compiled)
        for time, state in zip(times, states, strict=True):
            self.put(case, model, compiled, data, float(time), state)
            self.mujoco.mj_forward(compiled, data)
            yield data

    def put(
        self, case: Case, model: str, compiled: Any, data: Any, time: float, state: Array
    ) -> None:
        """Set the motion of all joints, and whether actuators are on, at a time."""
        stop = self.source(case, model).stop(case.parameters)
        switch(compiled, off=stop is not None and time >= stop)
        place(compiled, data, self.motion(case, model, time, state))
        data.time = time

    def joint_accelerations(
        self, system: System, times: Array, positions: Array, velocities: Array
    ) -> Array:
        """Return accelerations (k, n) of all joints at times (k,) and states (k, n)."""
        rows = np.empty(positions.shape)
        stop = self.source(system.case, system.model).stop(system.case.parameters)
        with self.opened(system.case, system.model):
            compiled = self.load(system.case, system.model)
            data = self.mujoco.MjData(compiled)
            for row, (time, q, v) in enumerate(zip(times, positions, velocities, strict=True)):
                switch(compiled, off=stop is not None and time >= stop)
                data.time, data.qpos[:], data.qvel[:] = time, q, v
                self.mujoco.mj_forward(compiled, data)
                rows[row] = data.qacc
        return rows

    def joint_mass_matrices(self, system: System, positions: Array) -> Array:
        """Return mass matrices (k, n, n) of all joints at positions (k, n)."""
        with quiet(self.mujoco):
            compiled = self.load(system.case, system.model)
            data = self.mujoco.MjData(compiled)
            matrices = np.empty((len(positions), compiled.nv, compiled.nv))
            for row, q in enumerate(positions):
                data.qpos[:] = q
                self.mujoco.mj_forward(compiled, data)
                for column, unit in enumerate(np.eye(compiled.nv)):
                    self.mujoco.mj_mulM(compiled, data, matrices[row, column], unit)
        return matrices

    def mass_matrices(self, case: Case, model: str, states: Array) -> Array:
        """Return mass matrices (k, n, n) of the coordinates at ``states`` (k, 2 n).

        Joints that depend on the coordinates take part; a clock does not. Those whose motion
        is prescribed have the row and the column of the identity.
        """
        with quiet(self.mujoco):
            compiled = self.load(case, model)
            data = self.mujoco.MjData(compiled)
            n = len(self.coordinates(case, model))
            matrices = np.empty((len(states), n, n))
            for row, state in enumerate(states):
                place(compiled, data, self.motion(case, model, case.start_time, state))
                self.mujoco.mj_forward(compiled, data)
                jacobian = self.jacobian(case, model, joint_names(compiled), state)
                for column, direction in enumerate(jacobian):
                    momentum = np.empty(compiled.nv)
                    self.mujoco.mj_mulM(compiled, data, momentum, direction)
                    matrices[row, :, column] = jacobian @ momentum
                self.with_identity_rows(case, model, matrices[row])
        return matrices

    def linearise(self, case: Case, model: str, state: Array) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about a state, at ``case.start_time``.

        A loop counts as closed for good: its constraint's forces do no work here. C and K
        are central differences of the inverse dynamics, the accelerations kept: they hold
        for small departures from the motion through ``state``.
        """
        with self.opened(case, model):
            compiled = self.load(case, model)
            data = self.mujoco.MjData(compiled)
            self.put(case, model, compiled, data, case.start_time, state)
            self.mujoco.mj_forward(compiled, data)
            closed = self.has_constraints(case, model)
            # a soft closure gives way even at rest, which a closed loop does not
            acceleration = 0 * data.qacc if closed else data.qacc.copy()
            names, n = joint_names(compiled), len(state) // 2
            jacobian = self.jacobian(case, model, names, state)

            def force(moved: Array) -> Array:
                place(compiled, data, self.motion(case, model, case.start_time, moved))
                data.qacc[:] = acceleration
                self.mujoco.mj_inverse(compiled, data)
                self.mujoco.mj_fwdActuation(compiled, data)
                # joints of a tree are linear in the coordinates
                here = self.jacobian(case, model, names, moved) if closed else jacobian
                return np.asarray(here @ (data.qfrc_inverse - data.qfrc_actuator))

            _, slopes = by_differences(one_by_one(force), state)
            slopes[self.prescribed(case, model)] = 0
        mass = self.mass_matrices(case, model, state[None])[0]
        return mass, slopes[:, n:], slopes[:, :n]

    def source(self, case: Case, model: str) -> mjcf.Mjcf:
        """Return the named MJCF model of a case's scene, its loop closed as the option says.

        Raises
        ------
        UnknownNameError
            If there is none.
        """
        source = super().source(case, model)
        if self.closure_time is None or source.softened is None:
            return source
        return source.softened(self.closure_time)

    def load(self, case: Case, model: str) -> Any:
        """Return the compiled model of a case, with Euler, for which inverse dynamics is exact.

        Raises
        ------
        EngineError
            ``start``, if the model as a viewer opens it is not at rest in the scene's
            origin with its drive at t = 0; runs here are placed elsewhere and would not tell.
            ``model``, if MuJoCo takes a centre of mass for the place of its body's frame.
        """
        with controlled(self.mujoco, None):  # it compiles none under a hook in Python
            compiled = self.mujoco.MjModel.from_xml_string(self.text(case, model))
        self.refuse_lost_offsets(compiled)
        compiled.opt.integrator = self.mujoco.mjtIntegrator.mjINT_EULER
        coordinates = self.coordinates(case, model)
        rest = dict.fromkeys((*coordinates, *(f"{name}_dot" for name in coordinates)), 0.0)
        expected = self.source(case, model).joints(case.parameters, 0.0, rest)
        positions = compiled.qpos0[addresses(compiled, tuple(expected))[0]]
        for (joint, (wanted, _)), position in zip(expected.items(), positions, strict=True):
            if abs(position - wanted) > 1e-12 * max(1.0, abs(wanted)):
                raise EngineError(
                    "start",
                    f"as opened, the MJCF starts with {joint} at {position:.9g}, not {wanted:.9g}",
                )
        return compiled

    def refuse_lost_offsets(self, compiled: Any) -> None:
        """Refuse a model whose centres of mass lie too near to their bodies' frames.

        Below 1e-6 m MuJoCo takes them for one place without a word (``body_sameframe``).

        Raises
        ------
        EngineError
            ``model``
        """
        offset = np.linalg.norm(compiled.body_ipos, axis=1)
        same = compiled.body_sameframe == int(self.mujoco.mjtSameFrame.mjSAMEFRAME_BODY)
        for body in np.flatnonzero(same & (offset > 0)):
            raise EngineError(
                "model",
                f"MuJoCo takes the centre of mass of {compiled.body(body).name}, "
                f"{offset[body]:.3g} m from its frame, for the frame's own place, as all below "
                "1e-6 m; choose a larger unit of length",
            )


def integrator_name(method: str) -> str:
    """Return the member of ``mjtIntegrator`` of a method."""
    return f"mjINT_{method.upper()}"


def drives(model: mjcf.Mjcf, case: Case) -> bool:
    """Return whether a body of the model drives it in this case: it moves where all is at rest."""
    if get_scene(case.scene).drive is None:
        return False
    rest = dict.fromkeys(get_scene(case.scene).state_names, 0.0)
    return any(one != (0.0, 0.0) for one in model.joints(case.parameters, 0.0, rest).values())


def joint_force(mujoco: Any, compiled: Any, data: Any, element: str) -> Array:
    """Return a force (3,) in the world's axes, of an element as in `mjcf.Mjcf.reactions`."""
    kind, name = element.split(":")
    if kind == "body":
        force: Array = -data.cfrc_int[compiled.body(name).id, 3:]  # it is that on the body
        return force
    rows = data.efc_id == compiled.equality(name).id
    force = data.efc_force[rows & (data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)]
    return force
