"""MuJoCo behind the `Engine` protocol, for every scene that has MJCF."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from ..models import mjcf
from ..reference import get_scene
from ..reference.errors import (
    EngineError,
    EngineUnavailableError,
    UnknownNameError,
    UsageError,
)
from ..reference.scene import Array, Case, Scene
from .engine import MOST_STEPS, VIOLATIONS, Method, Trajectory, grid_indices
from .prediction import Claim

METHODS = (
    Method("Euler", 1, "semi_implicit_euler"),
    Method("implicit", 1, "implicit_euler_velocity"),
    Method("implicitfast", 1, "implicit_euler_dampers"),
    Method("RK4", 4, "RK44"),
    Method("discrete", 1),
)
"""As MuJoCo spells them; `discrete` exists from 3.13 on."""

STENCIL = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))
"""Central difference of order 4: (place, weight)."""

DIFFERENCE = 1e-3
"""Step of that difference (rad, m and their rates): truncation is then below rounding."""


class MujocoEngine:
    """MuJoCo.

    Attributes
    ----------
    name, version : str
    methods : tuple of Method
    integrates_drive : bool
        The drive is a body of the model, integrated like the rest.

    Raises
    ------
    EngineUnavailableError
        If mujoco cannot be imported.
    """

    name = "mujoco"
    integrates_drive = True

    def __init__(self) -> None:
        self.mujoco = import_mujoco()
        self.version = str(self.mujoco.__version__)
        known = dir(self.mujoco.mjtIntegrator)
        self.methods = tuple(m for m in METHODS if integrator_name(m.name) in known)

    def models(self, scene: str) -> tuple[str, ...]:
        """Return the names of the MJCF models of a scene, default first."""
        return tuple(mjcf.models(scene))

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

    def claim(self, case: Case, model: str) -> tuple[Scene, Any] | None:
        """Return the equations of motion that the model really has, where not the scene's."""
        own = self.source(case, model).claim
        return own(case.parameters) if own else None

    def coordinates(self, case: Case, model: str) -> tuple[str, ...]:
        """Return the coordinates of states: the scene's, or its own where those are internal."""
        scene = get_scene(case.scene)
        own = self.claim(case, model)
        return own[0].coordinates if scene.internal and own else scene.coordinates

    def constrained(self, case: Case, model: str) -> bool:
        """Return whether a loop of the model is closed by a constraint."""
        return self.source(case, model).closed

    def element_order(self, case: Case, model: str) -> int:
        """Return the order with which the model converges to a continuum, or 0."""
        return self.source(case, model).element_order

    def side(self, case: Case, model: str) -> int:
        """Return whether its first frequency lies below (-1) or above (1) the continuum's, or 0."""
        return self.source(case, model).side(case.parameters)

    def scheme(self, case: Case, model: str, method: Method) -> str | None:
        """Return the published scheme that a method is on this model.

        The implicit ones leave the constraints' forces out of their derivatives, which no
        scheme on the equations of motion alone does. Where a model has coordinates of its own
        there are many, and the scheme in Python would take far longer than the engine.
        """
        if get_scene(case.scene).internal:
            return None
        implicit = method.name in ("implicit", "implicitfast")
        return None if implicit and self.constrained(case, model) else method.scheme

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate from ``case.start_time`` with a fixed step; ``times`` lie on its grid.

        Raises
        ------
        EngineError
            ``step``, if it is so long that MuJoCo would soften a closure in silence.
        """
        longest = self.source(case, model).longest_step
        if step > longest:
            raise EngineError(
                "step",
                f"with steps above {longest:g} s MuJoCo softens the closure of {model} without a "
                f"word (refsafe), so {step:.6g} s would be a run of another model",
            )
        with quiet(self.mujoco):
            compiled = self.load(case, model)
            compiled.opt.timestep = step
            compiled.opt.integrator = getattr(
                self.mujoco.mjtIntegrator, integrator_name(method.name)
            )
            data = self.mujoco.MjData(compiled)
            motion = self.motion(case, model, case.start_time, self.start(case, model))
            place(compiled, data, shifted(motion, case.inconsistency))
            data.time = case.start_time
            joints = tuple(compiled.joint(i).name for i in range(compiled.njnt))
            stop = self.source(case, model).stop(case.parameters)
            found = integrate(self.mujoco, compiled, data, joints, times, stop)
            values: dict[str, Array] = {}
            for suffix in ("", "_dot"):
                for name, sums in self.readout(case, model).items():
                    rows = [factor * found.values[f"{j}{suffix}"] for j, factor in sums.items()]
                    values[f"{name}{suffix}"] = np.sum(rows, axis=0)
            closed = self.constrained(case, model)
            observed = get_scene(case.scene).observed
            if observed or closed:
                values |= self.sensed(compiled, found.values, joints, observed, closed)
            return replace(found, values=values)

    def sensed(
        self,
        compiled: Any,
        values: Mapping[str, Array],
        joints: tuple[str, ...],
        sensors: tuple[str, ...],
        closed: bool,
    ) -> dict[str, Array]:
        """Return what the model's sensors show of recorded joints, and how far loops are open."""
        data = self.mujoco.MjData(compiled)
        positions, dofs = addresses(compiled, joints)
        count = len(values[joints[0]])
        found = {name: np.empty(count) for name in (*sensors, *(VIOLATIONS if closed else ()))}
        for i in range(count):
            data.qpos[positions] = [values[name][i] for name in joints]
            data.qvel[dofs] = [values[f"{name}_dot"][i] for name in joints]
            self.mujoco.mj_forward(compiled, data)
            for name in sensors:
                found[name][i] = data.sensor(name).data[0]
            if closed:
                for name, residual in zip(VIOLATIONS, (data.efc_pos, data.efc_vel), strict=True):
                    found[name][i] = np.linalg.norm(residual)
        return found

    def accelerations(self, case: Case, model: str, times: Array, states: Array) -> Array:
        """Return accelerations (k, n) at ``times`` (k,) and ``states`` (k, 2 n)."""
        with quiet(self.mujoco):
            compiled = self.load(case, model)
            sums = self.readout(case, model).values()
            dofs = [addresses(compiled, tuple(joints))[1] for joints in sums]
            factors = [list(joints.values()) for joints in sums]
            found = np.empty((len(states), len(dofs)))
            visits = self.visits(case, model, compiled, times, states)
            for row, data in enumerate(visits):
                found[row] = [data.qacc[at] @ f for at, f in zip(dofs, factors, strict=True)]
        return found

    def reaction_names(self, case: Case, model: str) -> tuple[str, ...]:
        """Return the outputs of the scene that are forces in joints of the model."""
        return tuple(self.source(case, model).reactions)

    def reactions(self, case: Case, model: str, times: Array, states: Array) -> dict[str, Array]:
        """Return those forces (k,) at ``times`` (k,) and ``states`` (k, 2 n)."""
        places = self.source(case, model).reactions
        found = {name: np.empty(len(states)) for name in places}
        with quiet(self.mujoco):
            compiled = self.load(case, model)
            for row, data in enumerate(self.visits(case, model, compiled, times, states)):
                self.mujoco.mj_rnePostConstraint(compiled, data)
                for name, (element, axis) in places.items():
                    found[name][row] = joint_force(self.mujoco, compiled, data, element)[axis]
        return found

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

    def mass_matrices(self, case: Case, model: str, states: Array) -> Array:
        """Return mass matrices (k, n, n) of the coordinates at ``states`` (k, 2 n).

        Joints that depend on the coordinates take part; a clock does not. Those whose motion
        is prescribed have the row and the column of the identity.
        """
        with quiet(self.mujoco):
            compiled = self.load(case, model)
            data = self.mujoco.MjData(compiled)
            n = len(self.coordinates(case, model))
            given = self.prescribed(case, model)
            found = np.empty((len(states), n, n))
            for row, state in enumerate(states):
                place(compiled, data, self.motion(case, model, case.start_time, state))
                self.mujoco.mj_forward(compiled, data)
                jacobian = self.jacobian(case, model, compiled, state)
                for column, direction in enumerate(jacobian):
                    momentum = np.empty(compiled.nv)
                    self.mujoco.mj_mulM(compiled, data, momentum, direction)
                    found[row, :, column] = jacobian @ momentum
            found[:, given, :] = found[:, :, given] = 0
            found[:, given, given] = 1
        return found

    def linearise(self, case: Case, model: str, state: Array) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about a state, at ``case.start_time``.

        A loop counts as closed for good: its constraint's forces do no work here. C and K
        are central differences of the inverse dynamics, the accelerations kept: they hold
        for small departures from the motion through ``state``.
        """
        with quiet(self.mujoco):
            compiled = self.load(case, model)
            data = self.mujoco.MjData(compiled)
            self.put(case, model, compiled, data, case.start_time, state)
            self.mujoco.mj_forward(compiled, data)
            closed = self.constrained(case, model)
            # a soft closure gives way even at rest, which a closed loop does not
            acceleration = 0 * data.qacc if closed else data.qacc.copy()
            jacobian = self.jacobian(case, model, compiled, state)
            n = len(state) // 2
            slopes = np.zeros((n, 2 * n))
            for column in range(2 * n):
                for position, weight in STENCIL:
                    moved = state.copy()
                    moved[column] += position * DIFFERENCE
                    place(compiled, data, self.motion(case, model, case.start_time, moved))
                    data.qacc[:] = acceleration
                    self.mujoco.mj_inverse(compiled, data)
                    self.mujoco.mj_fwdActuation(compiled, data)
                    force = data.qfrc_inverse - data.qfrc_actuator
                    if closed:  # joints of a tree are linear in the coordinates
                        jacobian = self.jacobian(case, model, compiled, moved)
                    slopes[:, column] += weight / DIFFERENCE * (jacobian @ force)
            slopes[self.prescribed(case, model)] = 0
        mass = self.mass_matrices(case, model, state[None])[0]
        return mass, slopes[:, n:], slopes[:, :n]

    def source(self, case: Case, model: str) -> mjcf.Mjcf:
        """Return the named MJCF model of a case's scene.

        Raises
        ------
        UnknownNameError
            If there is none.
        """
        known = mjcf.models(case.scene)
        if model not in known:
            raise UnknownNameError(f"MJCF model of {case.scene}", model, known)
        return known[model]

    def text(self, case: Case, model: str) -> str:
        """Return the MJCF of a case."""
        return mjcf.export(self.source(case, model), case.parameters)

    def load(self, case: Case, model: str) -> Any:
        """Return the compiled model of a case, with Euler, for which inverse dynamics is exact.

        Raises
        ------
        EngineError
            ``start``, if the model as a viewer opens it is not at rest in the scene's
            origin with its drive at t = 0; runs here are placed elsewhere and would not tell.
        """
        compiled = self.mujoco.MjModel.from_xml_string(self.text(case, model))
        compiled.opt.integrator = self.mujoco.mjtIntegrator.mjINT_EULER
        coordinates = self.coordinates(case, model)
        rest = dict.fromkeys((*coordinates, *(f"{name}_dot" for name in coordinates)), 0.0)
        expected = self.source(case, model).joints(case.parameters, 0.0, rest)
        positions = compiled.qpos0[addresses(compiled, tuple(expected))[0]]
        for (joint, (wanted, _)), found in zip(expected.items(), positions, strict=True):
            if abs(found - wanted) > 1e-12 * max(1.0, abs(wanted)):
                raise EngineError(
                    "start",
                    f"as opened, the MJCF starts with {joint} at {found:.9g}, not {wanted:.9g}",
                )
        return compiled

    def start(self, case: Case, model: str) -> Array:
        """Return the initial state of a case; a case need not know the model's coordinates."""
        scene = get_scene(case.scene)
        own = self.claim(case, model)
        if not (scene.internal and own):
            return scene.state(case.state)
        return Claim(*own).start(case)

    def prescribed(self, case: Case, model: str) -> list[int]:
        """Return which coordinates have a given motion."""
        names = self.source(case, model).prescribed(case.parameters)
        return [self.coordinates(case, model).index(name) for name in names]

    def motion(self, case: Case, model: str, time: float, state: Array) -> mjcf.Motion:
        """Return position and velocity of every joint."""
        coordinates = self.coordinates(case, model)
        names = (*coordinates, *(f"{name}_dot" for name in coordinates))
        values = dict(zip(names, map(float, state), strict=True))
        return self.source(case, model).joints(case.parameters, time, values)

    def readout(self, case: Case, model: str) -> dict[str, Mapping[str, float]]:
        """Return each coordinate as a sum of joints."""
        told = self.source(case, model).readout
        return {name: told.get(name, {name: 1.0}) for name in self.coordinates(case, model)}

    def jacobian(self, case: Case, model: str, compiled: Any, state: Array) -> Array:
        """Return the joint velocities (n, nv) per unit rate of each coordinate."""
        n = len(state) // 2
        standing = np.concatenate([state[:n], np.zeros(n)])
        velocities = []
        for row in range(-1, n):
            moving = standing.copy()
            if row >= 0:
                moving[n + row] = 1.0
            motion = self.motion(case, model, case.start_time, moving)
            velocity = np.zeros(compiled.nv)
            velocity[addresses(compiled, tuple(motion))[1]] = [v for _, v in motion.values()]
            velocities.append(velocity)
        return np.array(velocities[1:]) - velocities[0]


def import_mujoco() -> Any:
    """Return the mujoco module.

    Raises
    ------
    EngineUnavailableError
        With the reason.
    """
    try:
        return importlib.import_module("mujoco")
    except Exception as error:  # a broken binary raises anything, OSError for one
        reason = (str(error).strip() or "no message").splitlines()[0]
        raise EngineUnavailableError(
            f"mujoco cannot be imported ({type(error).__name__}: {reason}); "
            "install it with: pip install mujoco"
        ) from error


def integrator_name(method: str) -> str:
    """Return the member of ``mjtIntegrator`` of a method."""
    return f"mjINT_{method.upper()}"


@contextmanager
def quiet(mujoco: Any) -> Iterator[None]:
    """Keep MuJoCo from writing to the console and to MUJOCO_LOG.TXT."""
    if not hasattr(mujoco, "MjLogConfig"):  # before 4.0: `contained` keeps the file away
        yield
        return
    saved, silent = mujoco.MjLogConfig.get(), mujoco.MjLogConfig.get()
    silent.logto_console = silent.logto_file = False
    silent.set()
    try:
        yield
    finally:
        saved.set()


def drives(model: mjcf.Mjcf, case: Case) -> bool:
    """Return whether a clock of the model moves in this case."""
    rest = dict.fromkeys(get_scene(case.scene).state_names, 0.0)
    motion = model.joints(case.parameters, 0.0, rest) if model.clocks else {}
    return any(motion[clock] != (0.0, 0.0) for clock in model.clocks)


def addresses(compiled: Any, joints: tuple[str, ...]) -> tuple[list[int], list[int]]:
    """Return where joints (hinges, slides) stand in ``qpos`` and in ``qvel``."""
    found = [compiled.joint(name) for name in joints]
    return [int(j.qposadr[0]) for j in found], [int(j.dofadr[0]) for j in found]


def shifted(motion: mjcf.Motion, offsets: Mapping[str, float]) -> mjcf.Motion:
    """Return a motion with offsets of positions (by joint) and velocities (``_dot``)."""
    return {
        joint: (q + offsets.get(joint, 0.0), v + offsets.get(f"{joint}_dot", 0.0))
        for joint, (q, v) in motion.items()
    }


def joint_force(mujoco: Any, compiled: Any, data: Any, element: str) -> Array:
    """Return a force (3,) in the world's axes, of an element as in `mjcf.Mjcf.reactions`."""
    kind, name = element.split(":")
    if kind == "body":
        found: Array = -data.cfrc_int[compiled.body(name).id, 3:]  # it is that on the body
        return found
    rows = data.efc_id == compiled.equality(name).id
    found = data.efc_force[rows & (data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)]
    return found


def switch(compiled: Any, off: bool) -> None:
    """Switch all actuators (of group 0) off, or on again."""
    compiled.opt.disableactuator = int(off)


def place(compiled: Any, data: Any, motion: mjcf.Motion) -> None:
    """Set position and velocity of joints."""
    positions, dofs = addresses(compiled, tuple(motion))
    data.qpos[positions] = [q for q, _ in motion.values()]
    data.qvel[dofs] = [v for _, v in motion.values()]


def integrate(
    mujoco: Any,
    compiled: Any,
    data: Any,
    joints: tuple[str, ...],
    times: Array,
    stop: float | None = None,
) -> Trajectory:
    """Step a MuJoCo model from ``data.time`` and record joints at ``times``.

    Parameters
    ----------
    mujoco : module
    compiled : MjModel
    data : MjData
        The initial state, and controls if the model has any.
    joints : tuple of str
        Hinges and slides to record.
    times : array (n_t,)
        Sample times [s], multiples of ``opt.timestep`` after ``data.time``.
    stop : float, optional
        Time [s] at which the actuators are switched off, on the same grid.

    Raises
    ------
    UsageError
        If a time, or the drive's end, is off the grid.
    """
    step = compiled.opt.timestep
    driven = steps_driven(times, data.time, step, stop)
    numbers = np.array([0, *grid_indices(times, data.time, step)])
    legs = zip(np.diff(np.minimum(numbers, driven)), np.diff(numbers), strict=True)
    before = inputs(mujoco, compiled, data)
    begin = data.time
    kept = mujoco.mjtState.mjSTATE_TIME | mujoco.mjtState.mjSTATE_QPOS
    kept = int(kept | mujoco.mjtState.mjSTATE_QVEL)
    states = np.empty((len(times), mujoco.mj_stateSize(compiled, kept)))
    advance, save = mujoco.mj_step, mujoco.mj_getState
    for (on, whole), row in zip(legs, states, strict=True):
        if on:
            advance(compiled, data, on)
        if on < whole:
            switch(compiled, off=True)
            advance(compiled, data, whole - on)
        save(compiled, data, row, kept)
    switch(compiled, off=False)
    clock, positions, velocities = np.split(states.T, [1, 1 + compiled.nq])
    after = inputs(mujoco, compiled, data)
    at_q, at_v = addresses(compiled, joints)
    values = dict(zip(joints, positions[at_q], strict=True))
    values |= {f"{name}_dot": row for name, row in zip(joints, velocities[at_v], strict=True)}
    return Trajectory(
        times=np.asarray(times, dtype=float),
        values=values,
        clock=clock[0],
        steps=steps_counted(begin, clock[0], compiled.opt.timestep),
        warnings=warnings(mujoco, data),
        changed=tuple(n for n in before if not np.array_equal(before[n], after[n], equal_nan=True)),
    )


def steps_driven(times: Array, start: float, step: float, stop: float | None) -> int:
    """Return the number of steps until the drive ends, or the run if that comes first."""
    if stop is None or stop >= times[-1]:
        return MOST_STEPS
    if stop <= start:
        return 0
    try:
        return int(grid_indices(np.array([stop]), start, step)[0])
    except UsageError as error:
        raise UsageError(f"the drive ends between two steps: {error}") from None


def steps_counted(begin: float, clock: Array, step: float) -> int:
    """Return the number of steps that the engine's clock shows."""
    shown = np.rint(np.diff(clock, prepend=begin) / step)
    return int(np.sum(shown)) if np.all(np.isfinite(shown)) else -1


def warnings(mujoco: Any, data: Any) -> dict[str, int]:
    """Return MuJoCo's warning counters by name."""
    kinds = mujoco.mjtWarning.__members__
    return {
        name.removeprefix("mjWARN_"): int(data.warning[int(kind)].number)
        for name, kind in kinds.items()
        if name != "mjNWARNING"
    }


def inputs(mujoco: Any, compiled: Any, data: Any) -> Mapping[str, Array]:
    """Return a copy of what only the caller may change."""
    image = np.empty(mujoco.mj_sizeModel(compiled), np.uint8)
    mujoco.mj_saveModel(compiled, None, image)
    return {
        "opt.timestep": np.array(compiled.opt.timestep),
        "opt.integrator": np.array(float(compiled.opt.integrator)),
        "model": image.astype(float),
        "ctrl": data.ctrl.copy(),
        "qfrc_applied": data.qfrc_applied.copy(),
        "xfrc_applied": data.xfrc_applied.copy(),
    }
