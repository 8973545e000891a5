"""Engines that follow the public protocol as adapters: all of them, MuJoCo among them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from copy import copy
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, Self

import numpy as np

from ....models import mjcf
from ....models.kinematics import gap_jacobian, gaps
from ....models.mechanism import joint_places, mechanism
from ....models.placement import world_axes
from ....models.system import System
from ....reference import get_scene
from ....reference.errors import (
    BrokenEngineError,
    CannotJudgeError,
    EngineError,
    EngineUnavailableError,
    MbcheckError,
)
from ....reference.scene import Array, Case
from ..equations import ModelEquations, scene_equations
from ..mjcf import MjcfAdapter
from ..protocol import Engine, Method, Motion, Option, OwnModel
from ..run import VIOLATIONS, Trajectory, attempt, call_engine, captured
from .linear import linearise
from .planning import UNKNOWN_SOFTNESS, description, own_reason
from .reordered import Reordered
from .validation import (
    INTEGRALS,
    answers_of,
    as_engine,
    count,
    declared,
    in_short,
    numbers,
    observables_of,
    optional_count,
    options_of,
    own_functions,
    refuse_lost_joints,
    refuse_lost_length,
    refuse_no_tables,
    refuse_one_state,
    refuse_step_across_end,
)

CLOSURE_TIME = Option(
    "closure_time", "s", 2e-3, (2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4), "closure softness"
)
"""Of models whose file may be written with another softness, for engines that read it."""

SYSTEMS = 256
"""Systems that an adapter keeps: a map runs its points repeatedly."""

OWN = "scene"
"""Name of the model of an engine that reads no MJCF."""

NO_FILE = mjcf.Mjcf(path=Path(), bindings={}, controls=lambda parameters: {})
"""Stands for that model: its joints are the coordinates, and a force drives them."""


class PluginAdapter(MjcfAdapter):
    """An engine that works in joints, in the coordinates of the scenes.

    Attributes
    ----------
    inner : Engine
    functions : frozenset of str
        Which of the optional functions the engine has.
    closure_time : float or None
        Time constant [s] in which loops close whose softness is free; None: as in the file.
    """

    closure_time: float | None = None

    def __init__(self, inner: Engine) -> None:
        self.functions = own_functions(inner)
        self.name, self.version, self.methods = inner.name, inner.version, tuple(inner.methods)
        self.reads_mjcf = bool(inner.reads_mjcf)
        self.precision, self.closure = inner.precision, inner.closure
        self.hold(inner)

    def hold(self, inner: Engine) -> None:
        """Take an engine, and forget the systems of the one before."""
        self.inner = inner
        self.accumulates_clock, self.least_inertia = inner.accumulates_clock, inner.least_inertia
        self.largest_value, self.newton_tolerance = inner.largest_value, inner.newton_tolerance
        self.systems = lru_cache(SYSTEMS)(self.system_of)

    # What it models

    def models(self, scene: str) -> tuple[str, ...]:
        """Return the names of its models of a scene: those in MJCF.

        A closure that is there with different softness is there once for an engine that ignores it.
        """
        if not self.reads_mjcf:
            return (OWN,)
        table = mjcf.models(scene)
        every = self.closure == "mjcf"
        return tuple(name for name, one in table.items() if every or one.softened is None)

    def source(self, case: Case, model: str) -> mjcf.Mjcf:
        """Return the named model, its loop closed as the option says.

        One that is not MJCF has the scene's own coordinates.
        """
        if not self.reads_mjcf:
            return NO_FILE
        source = super().source(case, model)
        if self.closure_time is None or source.softened is None:
            return source
        return source.softened(self.closure_time)

    def model_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Return the model's equations of motion; a loop is as soft as the engine has it."""
        if self.closure == "mjcf" or not self.has_constraints(case, model):
            return super().model_equations(case, model)
        own = self.closure == "soft" and self.about(case, model).equations
        return ModelEquations(*own) if own else None

    def about(self, case: Case, model: str) -> OwnModel:
        """Return what the engine tells of a model with the parameters of a case."""
        return description(self, case, model)[0]

    def gives_way(self, case: Case, model: str) -> bool:
        """Return whether a loop of the model is soft, and it is known how."""
        if self.closure == "rigid" or not self.has_constraints(case, model):
            return False
        return self.closure == "mjcf" or self.about(case, model).equations is not None

    def why_not(self, case: Case, model: str, method: Method | None) -> str | None:
        """Return why this method cannot run this case on this model, or None."""
        closed, soft = self.has_constraints(case, model), self.gives_way(case, model)
        if case.inconsistency and not closed:
            return f"no constraint closes a loop of {model}: none can start open"
        if case.inconsistency and not soft:
            return "the loop starts open, which only a soft closure can close"
        if closed and not soft and self.closure == "soft":
            return description(self, case, model)[1] or UNKNOWN_SOFTNESS
        if not self.reads_mjcf and get_scene(case.scene).discretisation_coordinates:
            return f"{case.scene} is a continuum: only engines that read its MJCF are checked"
        reason = self.source(case, model).why_not(case.parameters)
        if reason or "why_not" not in self.functions:
            return reason
        return own_reason(self, case, model, method)

    def scheme(self, case: Case, model: str, method: Method) -> str | None:
        """Return the method's published scheme, if it acts on the scene's own coordinates."""
        closed = self.has_constraints(case, model) and not self.gives_way(case, model)
        if get_scene(case.scene).discretisation_coordinates or closed:
            return None
        if self.reads_mjcf and get_scene(case.scene).quaternions:
            return None  # rotations are no sums, whatever scheme their rates have
        loop = self.has_constraints(case, model)
        return method.scheme if method.scheme_with_loops or not loop else None

    def options(self, case: Case, model: str, method: Method) -> tuple[Option, ...]:
        """Return what limits accuracy beside the step: how a loop is closed, and the engine's."""
        soft = self.closure == "mjcf" and self.source(case, model).softened is not None
        own: tuple[Option, ...] = ()
        if "options" in self.functions:
            own = options_of(self.inner.options(self.joint_system(case, model), method))
        return (CLOSURE_TIME, *own) if soft else own

    def with_option(self, name: str, value: float) -> Self:
        """Return the engine with one of its options set."""
        other = copy(self)
        if name == CLOSURE_TIME.name and self.reads_mjcf and self.closure == "mjcf":
            other.closure_time = value
        else:
            other.inner = as_engine(self.inner.with_option(name, value))
        other.hold(other.inner)
        return other

    def reordered(self, order: tuple[int, ...], inputs_too: bool) -> Self:
        """Return the engine with its answers taken for those of joints in another order."""
        return type(self)(Reordered(self.inner, order, inputs_too))

    def joint_system(self, case: Case, model: str) -> System:
        """Return what the engine is told of a case."""
        system = self.systems(case.scene, model, case.parameters, case.placement)
        if not self.reads_mjcf:
            q, v = np.split(self.start(case, model), 2)
        else:
            motion = self.initial_motion(case, model)
            q, v = (np.hstack([motion[name][i] for name in system.joints]) for i in (0, 1))
        return replace(
            system, case=case, positions=q, velocities=v, start_time=float(case.start_time)
        )

    def system_of(self, scene: str, model: str, parameters: Any, placement: str = "") -> System:
        """Return what the engine is told of parameters, in the scene's origin, placed so.

        Raises
        ------
        EngineError
            ``start``, if a viewer does not open the file there; runs start elsewhere and would
            not tell.
        """
        case = Case(scene, "", parameters, placement=placement)
        if not self.reads_mjcf:
            names = get_scene(scene).coordinates
            return System(case, OWN, names, *np.zeros((2, len(names))))
        system = self.read(case, model)
        origin = self.motion(case, model, 0.0, self.start(case, model))
        for joint, place in joint_places(system.mjcf).items():
            expected = origin[joint][0]
            if place is not None and abs(place - expected) > 1e-12 * max(1.0, abs(expected)):
                raise EngineError(
                    "start",
                    f"as opened, the MJCF starts with {joint} at {place:.9g}, not {expected:.9g}",
                )
        driven = get_scene(scene).drive is not None
        turning = {one.name for one in get_scene(scene).quaternions}
        return replace(
            system,
            drivers=tuple(
                name for name, at in origin.items() if driven and name not in turning and any(at)
            ),
            observables=() if get_scene(scene).quaternions else get_scene(scene).observed,
            reactions={
                name: (element, world_axes(placement)[:, axis])
                for name, (element, axis) in self.source(case, model).reactions.items()
            },
        )

    def read(self, case: Case, model: str) -> System:
        """Return a model in joint coordinates, for who reads all of MJCF without its forces.

        Raises
        ------
        CannotJudgeError
            If it holds what `models.mechanism` does not understand.
        """
        try:
            return super().joint_system(case, model)
        except CannotJudgeError:
            if not self.inner.reads_all_mjcf:
                raise
        text = self.text(case, model)
        joints = tuple(joint_places(text))
        q, v = np.zeros((2, len(joints)))
        return System(case, model, joints, q, v, 0.0, text)

    # What it computes

    def simulate(
        self, case: Case, model: str, method: Method, step: float, times: Array
    ) -> Trajectory:
        """Integrate from ``case.start_time`` with a fixed step; ``times`` lie on its grid.

        Raises
        ------
        EngineError
            ``returned``, if what comes back has no sense.
        """
        system = self.joint_system(case, model)
        refuse_step_across_end(system, step, times)
        motion = self.inner.simulate(system, method, step, times.copy())
        return self.trajectory(system, step, times, motion, method.precision)

    def simulate_many(
        self, cases: Sequence[Case], model: str, method: Method, steps: Array, times: Array
    ) -> list[Trajectory | EngineError]:
        """Return what `simulate` returns of each case, or the error that it raises.

        Together, where the engine can; see `Adapter.simulate_many`.
        """
        if "simulate_many" not in self.functions:
            return super().simulate_many(cases, model, method, steps, times)
        outcomes: list[Any] = [attempt(partial(self.joint_system, case, model)) for case in cases]
        ready = [i for i, one in enumerate(outcomes) if isinstance(one, System)]
        systems = [outcomes[i] for i in ready]
        for i, system in zip(ready, systems, strict=True):
            refuse_step_across_end(system, float(steps[i]), times[i])
        answers = self.inner.simulate_many(systems, method, steps[ready], times[ready])
        motions = answers_of(answers, len(systems))
        for i, system, motion in zip(ready, systems, motions, strict=True):
            step, grid = float(steps[i]), times[i]
            if motion is None:
                work = partial(self.simulate, cases[i], model, method, step, grid)
            else:
                work = partial(self.trajectory, system, step, grid, motion, method.precision)
            outcomes[i] = attempt(work)
        return outcomes

    def trajectory(
        self, system: System, step: float, times: Array, motion: Any, precision: str | None = None
    ) -> Trajectory:
        """Return what a method of this precision returned of a run, in the scene's observables.

        Raises
        ------
        EngineError
            ``returned``, if it has no sense, or what was returned in place of a motion.
        """
        if isinstance(motion, Exception):
            raise motion
        if not isinstance(motion, Motion):
            raise EngineError("returned", f"simulate must return a Motion, not {in_short(motion)}")
        shape = (len(times),)
        positions, rates = system.layout.size
        q = numbers("Motion.positions", motion.positions, (*shape, positions))
        v = numbers("Motion.velocities", motion.velocities, (*shape, rates))
        refuse_lost_length(system, times, q, precision or self.precision)
        clock = times if motion.clock is None else numbers("Motion.clock", motion.clock, shape)
        asked = round((times[-1] - system.start_time) / step)
        refuse_no_tables(motion)
        if not any(motion.warnings.values()) and np.allclose(clock, times):
            refuse_one_state(system, q, v)
        values = self.observed(system, q, v, observables_of(motion, system.case, shape))
        if all(np.all(np.isfinite(row)) for row in values.values()):
            refuse_lost_joints(system, times, np.hstack([q, v]))
        return Trajectory(
            times=times,
            values=values,
            clock=clock,
            steps=asked if motion.steps is None else count("steps", motion.steps),
            rhs_evaluations=optional_count("rhs_evaluations", motion.rhs_evaluations),
            newton_iterations=optional_count("newton_iterations", motion.newton_iterations),
            warnings=dict(motion.warnings),
            changed=tuple(map(str, motion.changed)),
            seconds=float(numbers("Motion.seconds", motion.seconds, (), finite=True)),
        )

    def observed(
        self, system: System, q: Array, v: Array, sensed: Mapping[str, Array]
    ) -> dict[str, Array]:
        """Return the scene's observables of joints' motion, and how far loops are open.

        Positions have the shape (n_t, n_q), velocities (n_t, n). What the engine's sensors show
        (n_t,) comes from them, the rest from the joints.
        """
        case, model = system.case, system.model
        names = self.coordinates(case, model)
        rows = self.joint_readout(case, model, system).states(q, v)
        values = dict(zip((*names, *(f"{name}_dot" for name in names)), rows, strict=True))
        closed = self.has_constraints(case, model)
        names = (*get_scene(case.scene).observables, *(VIOLATIONS if closed else ()))
        values |= {name: sensed[name] for name in (*names, *INTEGRALS) if name in sensed}
        if all(name in values for name in names):
            return values
        own = None if closed else self.model_equations(case, model)
        equations = own or scene_equations(case)
        states = np.array([values[name] for name in equations.scene.state_names])
        with np.errstate(all="ignore"):  # the guard tells of what is not finite
            observables = equations.scene.observe(states, equations.parameters)
            others = {name: observables[name] for name in names if name in observables}
            if closed:  # and so by the engine's joints
                places = zip(system.layout.positions, system.layout.velocities, strict=True)
                for joint, (at, rate) in zip(system.joints, places, strict=True):
                    others |= {joint: q[:, at.start], f"{joint}_dot": v[:, rate.start]}
                whole = mechanism(system.mjcf)
                apart = [gaps(whole, row) for row in q]
                rates = [gap_jacobian(whole, a) @ b for a, b in zip(q, v, strict=True)]
                for name, residuals in zip(VIOLATIONS, (apart, rates), strict=True):
                    others[name] = np.linalg.norm(residuals, axis=1)
        return values | {n: others[n] for n in names if n in others and n not in sensed}

    def joint_accelerations(
        self, system: System, times: Array, positions: Array, velocities: Array
    ) -> Array:
        """Return accelerations (k, n) of the joints at times (k,) and states (k, n).

        Raises
        ------
        Unsupported
            If the engine has no `accelerations`.
        EngineError
            ``returned``
        """
        rows = zip(times, positions, velocities, strict=True)
        shape = system.layout.size[1:]
        return np.array(
            [  # each is copied as it comes: an engine may return a view of its own buffer
                numbers(
                    "accelerations",
                    self.inner.accelerations(system, float(t), q.copy(), v.copy()),
                    shape,
                    finite=True,
                )
                for t, q, v in rows
            ]
        )

    def joint_mass_matrices(self, system: System, positions: Array) -> Array:
        """Return mass matrices (k, n, n) of the joints at positions (k, n).

        Raises
        ------
        Unsupported
            If the engine has no `mass_matrix`.
        EngineError
            ``returned``
        """
        shape = system.layout.size[1:] * 2
        return np.array(
            [
                numbers("mass_matrix", self.inner.mass_matrix(system, q.copy()), shape, finite=True)
                for q in positions
            ]
        )

    def reaction_names(self, case: Case, model: str) -> tuple[str, ...]:
        """Return the outputs of the scene that are forces in joints of the model."""
        if "reactions" not in self.functions:
            return ()
        return tuple(self.source(case, model).reactions)

    def reactions(self, case: Case, model: str, times: Array, states: Array) -> dict[str, Array]:
        """Return those forces (k,) at ``times`` (k,) and ``states`` (k, 2 n)."""
        system, q, v = self.joint_states(case, model, times, states)
        names = self.reaction_names(case, model)
        forces = np.empty((len(names), len(states)))
        with self.session(system):
            for i, (time, at, speed) in enumerate(zip(times, q, v, strict=True)):
                there = self.inner.reactions(system, float(time), at.copy(), speed.copy())
                for row, name in zip(forces, names, strict=True):
                    if not isinstance(there, Mapping) or name not in there:
                        raise EngineError(
                            "returned", f"reactions must tell {name}: {in_short(there)}"
                        )
                    row[i] = numbers(f"reactions[{name!r}]", there[name], (), finite=True)
        return dict(zip(names, forces, strict=True))

    def accelerations(self, case: Case, model: str, times: Array, states: Array) -> Array:
        """Return accelerations (k, n) at ``times`` (k,) and ``states`` (k, 2 n)."""
        system, q, v = self.joint_states(case, model, times, states)
        moving = self.joint_accelerations(system, times, q, v)
        return self.joint_readout(case, model, system).accelerations(states, moving)

    def mass_matrices(self, case: Case, model: str, states: Array) -> Array:
        """Return mass matrices (k, n, n) of the coordinates at ``states`` (k, 2 n).

        Joints that depend on the coordinates take part; a clock does not. Those whose motion
        is prescribed have the row and the column of the identity.
        """
        system, q, _ = self.joint_states(case, model, np.full(len(states), case.start_time), states)
        matrices = []
        for matrix, state in zip(self.joint_mass_matrices(system, q), states, strict=True):
            matrices.append(self.of_coordinates(case, model, system, state, matrix))
        return np.array(matrices)

    def session(self, system: System) -> AbstractContextManager[Any]:
        """Return a context in which the engine is asked about a system several times."""
        return self.inner.session(system) if "session" in self.functions else nullcontext()

    def linearise(self, case: Case, model: str, state: Array) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about a state of rest or steady motion, see `linear`."""
        return linearise(self, case, model, state)


def adapt(name: str, offered: Any) -> PluginAdapter:
    """Return an engine from a class that someone wrote.

    Parameters
    ----------
    name : str
        How it was asked for, for messages.
    offered : class, or instance
        An `Engine`, or what has its attributes.

    Raises
    ------
    BrokenEngineError
        If the class raises anything, or does not follow the protocol; says in what.
    EngineUnavailableError
        If the class raises it, for want of a library.
    """
    try:
        engine = call_engine(
            lambda: declared(name, offered() if isinstance(offered, type) else offered),
            container=captured,
        )
    except EngineUnavailableError:
        raise
    except EngineError as error:
        reason = error.message.replace(":", " on creation:", 1)
        raise BrokenEngineError(f"engine {name}: {reason}", error.traceback) from error
    except MbcheckError as error:
        raise BrokenEngineError(f"{error}", error.traceback) from error
    return adapted(engine)


def adapted(inner: Engine) -> PluginAdapter:
    """Return the adapter of an engine: another one if it tells of models of its own."""
    from .own import OwnModelsAdapter

    own = not inner.reads_mjcf and bool({"models", "own_model"} & own_functions(inner))
    return (OwnModelsAdapter if own else PluginAdapter)(inner)
