"""MuJoCo behind the public protocol, for every model in MJCF."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..protocol import Engine, EngineError, Method, Motion, Option, System, refuse_older
from .library import controlled, import_mujoco, integrate, quiet, switch

Array = NDArray[np.float64]

LEAST_VERSION = "3.6"
"""Oldest that was run with all checks."""

METHODS = (
    Method("Euler", 1, "semi_implicit_euler"),
    Method("implicit", 1, "implicit_euler_velocity", scheme_with_loops=False),
    Method("implicitfast", 1, "implicit_euler_dampers", scheme_with_loops=False),
    Method("RK4", 4, "RK44"),
    Method("discrete", 1, linear_scheme="implicit_euler"),
)
"""As MuJoCo spells them; `discrete` exists from 3.13 on. The implicit ones leave the forces of
constraints out of their derivatives, which no scheme on the equations of motion alone does."""

SOLVER_TOLERANCE = Option(
    "solver_tolerance", "1", 1e-30, (1e-2, 1e-4, 1e-8, 1e-30), "solver tolerance"
)
"""All values leave the same floor: Newton's method solves the two rows of a loop at once. CG does
not, see docs/extremes.md."""

MODELS = 256
"""Compiled models that are kept, of 0.25 MB each: a map runs its points repeatedly."""


class MuJoCo(Engine):
    """MuJoCo.

    Attributes
    ----------
    solver_tolerance : float or None
        Of MuJoCo's solver of constraints; that of the file where it is None.

    Raises
    ------
    EngineUnavailableError
        If mujoco cannot be imported, or is older than `LEAST_VERSION`.
    """

    name = "mujoco"
    closure = "mjcf"
    needs_only_mjcf = True
    accumulates_clock = True
    min_inertia = 1e-15  # mjMINVAL
    max_value = 1e10  # mjMAXVAL
    solver_tolerance: float | None = None

    def __init__(self) -> None:
        self.mujoco = import_mujoco()
        self.version = str(self.mujoco.__version__)
        refuse_older(self.name, self.version, LEAST_VERSION)
        known = dir(self.mujoco.mjtIntegrator)
        self.methods = tuple(m for m in METHODS if integrator_name(m.name) in known)
        self.compiled = lru_cache(MODELS)(self.compile)

    def unsupported_reason(self, system: System, method: Method | None) -> str | None:
        """Return the reason why this method cannot run this system, or None."""
        if method is not None and method.name == "discrete" and system.drivers:
            return (
                "discrete makes springs implicit and so damps the oscillator that drives this "
                "model: the force itself would fade"
            )
        return None

    def options(self, system: System, method: Method) -> tuple[Option, ...]:
        """Return the tolerance of the constraint solver if constraints are hard enough."""
        hard = any(closure.solref[0] < 0 for closure in system.closures)
        return (SOLVER_TOLERANCE,) if hard else ()

    # Runs

    def simulate(self, system: System, method: Method, step: float, times: Array) -> Motion:
        """Integrate from ``system.start_time`` with a fixed step; ``times`` lie on its grid.

        Raises
        ------
        EngineError
            ``step``, if it is so long that MuJoCo would soften a closure silently.
        """
        with self.opened(system):
            settings = method.name, step, self.solver_tolerance
            compiled = self.compiled(system.mjcf, system.model, *settings)
            data = self.data(compiled, system.start_time, system.positions, system.velocities)
            motion = integrate(self.mujoco, compiled, data, times, system.drive_end)
            return self.with_sensors(system, compiled, data, motion)

    def with_sensors(self, system: System, compiled: Any, data: Any, motion: Motion) -> Motion:
        """Return a motion with its sensors' values and the errors of its closed loops."""
        if not (system.observables or system.closures):
            return motion
        self.mujoco.mj_resetData(compiled, data)
        sensed = {name: np.empty(len(motion.positions)) for name in system.observables}
        apart, rates = np.empty((2, len(motion.positions)))
        for i, (q, v) in enumerate(zip(motion.positions, motion.velocities, strict=True)):
            data.qpos[:], data.qvel[:] = q, v
            self.mujoco.mj_forward(compiled, data)
            for name, values in sensed.items():
                values[i] = data.sensor(name).data[0]
            apart[i], rates[i] = np.linalg.norm(data.efc_pos), np.linalg.norm(data.efc_vel)
        if system.closures:
            sensed |= {"position_violation": apart, "velocity_violation": rates}
        return replace(motion, observables=sensed)

    # Algebra

    def accelerations(
        self, system: System, time: float, positions: Array, velocities: Array
    ) -> Array:
        """Return the joints' accelerations (n,) at a time and a state."""
        with self.opened(system):
            _, data = self.at(system, time, positions, velocities)
            return np.array(data.qacc)

    def mass_matrix(self, system: System, positions: Array) -> Array:
        """Return the joints' mass matrix (n, n)."""
        with quiet(self.mujoco):
            compiled, data = self.at(system, system.start_time, positions, 0 * system.velocities)
            columns = np.empty((compiled.nv, compiled.nv))
            for column, unit in zip(columns, np.eye(compiled.nv), strict=True):
                self.mujoco.mj_mulM(compiled, data, column, unit)
        return columns.T

    def inverse_dynamics(
        self,
        system: System,
        time: float,
        positions: Array,
        velocities: Array,
        accelerations: Array,
    ) -> Array:
        """Return the forces (n,) that a motion takes, those of constraints left out."""
        with self.opened(system):
            compiled, data = self.at(system, time, positions, velocities)
            data.qacc[:] = accelerations
            self.mujoco.mj_inverse(compiled, data)
            self.mujoco.mj_fwdActuation(compiled, data)
            return np.array(data.qfrc_inverse - data.qfrc_actuator)

    def reactions(
        self, system: System, time: float, positions: Array, velocities: Array
    ) -> dict[str, float]:
        """Return the forces in the joints of `System.reactions`, by name."""
        with self.opened(system):
            compiled, data = self.at(system, time, positions, velocities)
            self.mujoco.mj_rnePostConstraint(compiled, data)
            return {
                name: float(joint_force(self.mujoco, compiled, data, element) @ direction)
                for name, (element, direction) in system.reactions.items()
            }

    @contextmanager
    def opened(self, system: System) -> Iterator[None]:
        """Keep MuJoCo silent, and give it the controls of a system."""
        driven = any(term.kind == "actuator" and term.amplitude for term in system.terms)
        with quiet(self.mujoco), controlled(self.mujoco, system.controls if driven else None):
            yield

    def at(
        self, system: System, time: float, positions: Array, velocities: Array
    ) -> tuple[Any, Any]:
        """Return model and data with all forces and accelerations at a time and a state."""
        compiled = self.compiled(system.mjcf, system.model)
        end = system.drive_end
        switch(compiled, off=end is not None and time >= end)
        data = self.data(compiled, time, positions, velocities)
        self.mujoco.mj_forward(compiled, data)
        return compiled, data

    def data(self, compiled: Any, time: float, positions: Array, velocities: Array) -> Any:
        """Return new data of a model at a time and a state."""
        data = self.mujoco.MjData(compiled)
        data.time, data.qpos[:], data.qvel[:] = time, positions, velocities
        return data

    # Models

    def compile(
        self,
        text: str,
        model: str,
        method: str = "Euler",
        step: float | None = None,
        tolerance: float | None = None,
    ) -> Any:
        """Return a compiled model, for runs with a method and a step [s].

        Raises
        ------
        EngineError
            ``step``, see `simulate`.
        """
        compiled = self.load(text)
        compiled.opt.integrator = getattr(self.mujoco.mjtIntegrator, integrator_name(method))
        if step is not None:
            self.refuse_softening(compiled, model, step)
            compiled.opt.timestep = step
            if tolerance is not None:
                compiled.opt.tolerance = tolerance
        return compiled

    def load(self, text: str) -> Any:
        """Return the compiled model of a text.

        Raises
        ------
        EngineError
            ``model``, if MuJoCo takes a centre of mass for the place of its body's frame.
        """
        with controlled(self.mujoco, None):  # it compiles none under a hook in Python
            compiled = self.mujoco.MjModel.from_xml_string(text)
        self.refuse_lost_offsets(compiled)
        return compiled

    def refuse_softening(self, compiled: Any, model: str, step: float) -> None:
        """Refuse a step at which MuJoCo gives a closure a longer time constant (refsafe).

        Raises
        ------
        EngineError
            ``step``
        """
        times = compiled.eq_solref[:, 0]
        longest = np.min(times[times > 0], initial=np.inf) / 2
        if step > longest:
            raise EngineError(
                "step",
                f"with steps above {longest:g} s MuJoCo softens the closure of {model} silently "
                f"(refsafe), so {step:.6g} s would be a run of another model",
            )

    def refuse_lost_offsets(self, compiled: Any) -> None:
        """Refuse a model whose centres of mass lie too near to their bodies' frames.

        Below 1e-6 m MuJoCo takes them for one place silently (``body_sameframe``).

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


def joint_force(mujoco: Any, compiled: Any, data: Any, element: str) -> Array:
    """Return a force (3,) in the world's axes, of an element as in `System.reactions`."""
    kind, name = element.split(":")
    if kind == "body":
        return np.asarray(-data.cfrc_int[compiled.body(name).id, 3:])  # it is that on the body
    rows = data.efc_id == compiled.equality(name).id
    rows = rows & (data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    return np.asarray(data.efc_force[rows])
