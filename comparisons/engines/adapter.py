"""Engines and their models of the scenes, in the coordinates of the scenes."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import replace
from functools import cached_property, lru_cache, partial
from pathlib import Path
from typing import Any, Self, TypeVar

import numpy as np

from ...models import mjcf
from ...models.kinematics import gap_jacobian, gaps, mass_matrix
from ...models.mechanism import joint_places, mechanism, switched_off
from ...models.placement import placed, placed_motion, unplaceable_reason, world_axes
from ...models.readout import Readout
from ...models.system import System
from ...reference import get_scene
from ...reference.differences import by_differences, one_by_one
from ...reference.equations import ModelEquations, scene_equations
from ...reference.errors import (
    BrokenEngineError,
    CannotJudgeError,
    EngineError,
    EngineUnavailableError,
    MbcheckError,
    UnknownNameError,
    Unsupported,
)
from ...reference.scene import Array, Case
from .protocol import Engine, Method, ModelDescription, Motion, Option
from .run import VIOLATIONS, Trajectory, call_engine, captured
from .validation import (
    attributes,
    declared,
    functions_by_method,
    in_short,
    matrices,
    model_description,
    model_names,
    motion_of,
    numbers,
    options_of,
    own_functions,
    reason_of,
    refuse_lost_joints,
    refuse_step_across_end,
    trajectory_of,
)

T = TypeVar("T")

CLOSURE_TIME = Option(
    "closure_time", "s", 2e-3, (2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4), "closure softness"
)
"""Closure softness, an option of engines that read it from the file."""

MAX_MODELS = 256
"""Bound models that an adapter keeps, since a map runs its points repeatedly."""

MAX_REASONS = 4096
"""Reasons of an engine that are kept: each kind of check asks for those of all methods."""

OWN = "scene"
"""Name of the model of an engine that reads no MJCF and names none."""

NO_FILE = mjcf.Mjcf(path=Path(), bindings={}, controls=lambda parameters: {})
"""The file of such a model: its joints are the coordinates, and a force drives them."""

UNKNOWN_SOFTNESS = "its loops are soft by a rule of its own: no reference has their equations"

UNKNOWN_COMPLIANCE = (
    "its joints give way by a rule of its own: no reference has its equations, unless "
    "describe_model returns them"
)

ORDER = 8
DIFFERENCE = 0.03
"""Order and step of central differences (rad, m and their rates). Truncation is 1e-15 then;
round-off of accelerations, whose stiffest modes are far faster than those of interest, falls with
the step."""

CURVED_DIFFERENCE = DIFFERENCE / 6
"""The same step where joints are no sums of coordinates: in loops, and where quaternions turn.
Rotations have poles at the length 0, at the distance 1."""


class BoundModel:
    """An engine's model of a scene, with the parameters of a case.

    States are arrays (2 n,): coordinates, then rates, in the order of `coordinates`. What is known
    of the model is computed once: `Adapter.bind` keeps models.

    Parameters
    ----------
    engine : Adapter
    case : Case
        A scene, its parameters and a placement, without an initial state.
    name : str
        One of the engine's models of the scene.

    Attributes
    ----------
    source : Mjcf
        The model's file, its loop closed as the option says; `NO_FILE` without one.
    """

    def __init__(self, engine: Adapter, case: Case, name: str) -> None:
        self.engine, self.case, self.name = engine, case, name
        self.scene = get_scene(case.scene)
        self.source = engine.read_source(case.scene, name)
        self.engine_reason = lru_cache(MAX_REASONS)(self.ask_reason)

    # Its equations

    @cached_property
    def described(self) -> tuple[ModelDescription, str | None]:
        """The description of the model, and the engine's reason if it has none.

        An MJCF model is described by its `Mjcf`; the engine describes models that it builds itself,
        and those whose joints or loops are compliant by its own rule.

        Raises
        ------
        BrokenEngineError
            If the engine gives no answer.
        """
        engine, source, p = self.engine, self.source, self.case.parameters
        soft = engine.compliant_joints or (source.closed and engine.closure == "soft")
        description, reason = ModelDescription(), None
        if "describe_model" in engine.functions and (soft or not engine.reads_mjcf):
            try:
                description = self.ask_description()
            except ArithmeticError:
                pass  # as in `ask_reason`
            except Unsupported as error:
                reason = str(error)
        if not engine.reads_mjcf:
            return description, reason
        equations = description.equations
        if not soft and source.equations and (engine.closure == "mjcf" or not source.closed):
            equations = source.equations(p)
        fixed = None
        if self.case.placement:
            text = source.path.read_text(encoding="utf-8")
            fixed = unplaceable_reason(text, self.case.placement)
        return ModelDescription(
            constrained=source.closed,
            reactions=tuple(source.reactions),
            equations=equations,
            element_order=source.elements.order,
            unplaceable_reason=fixed,
        ), reason

    def ask_description(self) -> ModelDescription:
        """Return the engine's own description of the model.

        Raises
        ------
        BrokenEngineError, Unsupported
        """
        engine, names = self.engine, self.scene.public
        bare = System(self.case, self.name, names, *np.zeros((2, len(names))))
        system = self.origin if engine.reads_mjcf else bare
        description = engine.call_before_checks(
            "describe_model",
            lambda: model_description(engine.inner.describe_model(system), self.scene.units),
        )
        if description.equations is not None:
            self.refuse_foreign_equations(ModelEquations(*description.equations))
        return description

    def refuse_foreign_equations(self, equations: ModelEquations) -> None:
        """Refuse equations that fail in a state of the scene: those of another one, for instance.

        Raises
        ------
        BrokenEngineError
            Names the line that raised.
        """
        first = replace(
            self.scene.cases[0],
            parameters=self.case.parameters,
            placement=self.case.placement,
        )
        try:
            scene_equations(first).start(first)
        except (ArithmeticError, MbcheckError):
            return  # no state of the scene with these parameters

        def refuse_missing() -> None:
            try:
                state = equations.start(first)
                slopes = equations.scene.right_hand_side(equations.parameters)
                slopes(float(first.start_time), state)
                values = equations.scene.observe(state, equations.parameters)
            except ArithmeticError:  # of these parameters, as of a body without mass
                return
            if missing := set(self.scene.observables).difference(values):
                raise EngineError("returned", f"they do not tell {', '.join(sorted(missing))}")

        function = f"describe_model: its equations for {self.scene.name}"
        self.engine.call_before_checks(function, refuse_missing)

    @cached_property
    def description(self) -> ModelDescription:
        """The description of the model, see `described`."""
        return self.described[0]

    @cached_property
    def own_equations(self) -> ModelEquations | None:
        """The equations of motion that the model has, None where they are the scene's."""
        pair = self.description.equations
        return None if pair is None else ModelEquations(*pair)

    @cached_property
    def equations(self) -> ModelEquations:
        """The equations of motion that the model has."""
        return self.own_equations or scene_equations(self.case)

    @cached_property
    def discrete(self) -> ModelEquations | None:
        """The equations of the model's elements, if the engine describes any.

        The engine then takes and returns states in their coordinates.
        """
        elements = self.description.elements
        return None if elements is None else ModelEquations(elements, self.case.parameters)

    @cached_property
    def solved_equations(self) -> ModelEquations:
        """The equations that runs converge to as steps are halved: of its elements, if any."""
        return self.discrete or self.equations

    @cached_property
    def is_exact(self) -> bool:
        """Whether its equations are those of the scene."""
        return self.equations.is_exact_for(self.case)

    @cached_property
    def has_constraints(self) -> bool:
        """Whether constraints close loops of the model."""
        return self.description.constrained

    @cached_property
    def has_soft_closure(self) -> bool:
        """Whether a soft constraint closes a loop of the model."""
        return self.has_constraints and self.equations.scene is not self.scene

    @cached_property
    def knows_softness(self) -> bool:
        """Whether the softness of the model's loops is known."""
        engine = self.engine
        by_file = engine.reads_mjcf and engine.closure == "mjcf"
        return self.has_constraints and (by_file or self.description.equations is not None)

    @cached_property
    def approximates_continuum(self) -> bool:
        """Whether the model converges to a continuum whose equations it does not solve."""
        scene = self.equations.scene
        return bool(scene.discretisation_coordinates) and self.coordinates != scene.coordinates

    @cached_property
    def integrates_drive(self) -> bool:
        """Whether the drive is a body of the model, integrated like the rest."""
        return self.source.controls is None

    @cached_property
    def frequency_side(self) -> int:
        """Whether its first frequency lies below (-1) or above (1) the continuum's, or 0."""
        return self.source.elements.side(self.case.parameters)

    @cached_property
    def observables(self) -> tuple[str, ...]:
        """Names of the outputs that are compared; for closed loops also their residuals."""
        names = self.scene.observables
        return (*names, *VIOLATIONS) if self.has_constraints else names

    @cached_property
    def reaction_names(self) -> tuple[str, ...]:
        """The outputs of the scene that are forces in joints and that the engine returns."""
        return tuple(self.description.reactions) if "reactions" in self.engine.functions else ()

    # What it supports

    def unsupported_reason(self, case: Case, method: Method | None) -> str | None:
        """Return the reason why this method cannot run a case, or None."""
        if case.placement and self.description.unplaceable_reason:
            return self.description.unplaceable_reason
        if self.engine.reads_mjcf:
            return self.model_reason(case) or self.engine_reason(case, method)
        return self.described[1] or self.engine_reason(case, method) or self.model_reason(case)

    def model_reason(self, case: Case) -> str | None:
        """Return the reason why the model cannot represent a case in any engine, or None."""
        engine, description = self.engine, self.description
        if case.inconsistency and not description.constrained:
            return f"no constraint closes a loop of {self.name}: none can start open"
        if case.inconsistency and not self.knows_softness:
            return "the loop starts open, which only a soft closure can close"
        if description.equations is None and engine.compliant_joints:
            return self.described[1] or UNKNOWN_COMPLIANCE
        if description.equations is None and description.constrained and engine.closure == "soft":
            return self.described[1] or UNKNOWN_SOFTNESS
        if engine.reads_mjcf:
            return self.source.unsupported_reason(self.case.parameters)
        own = description.equations or description.elements
        if self.scene.discretisation_coordinates and not own:
            name = self.scene.name
            return f"{name} is a continuum: tell the equations of the model, or its elements"
        return None

    def ask_reason(self, case: Case, method: Method | None) -> str | None:
        """Return the engine's reason for not running a case, or None.

        Raises
        ------
        BrokenEngineError
            If it gives no answer.
        """
        engine = self.engine
        if "unsupported_reason" not in engine.functions:
            return None
        try:
            system = self.system(case)
        except ArithmeticError:
            return None  # the call itself will raise it
        ask = engine.inner.unsupported_reason
        try:
            return engine.call_before_checks(
                "unsupported_reason", lambda: reason_of(ask(system, method))
            )
        except Unsupported as error:
            return str(error)

    def scheme(self, method: Method) -> str | None:
        """Return the published scheme that a method is on this model, None if it is none.

        Joints of a file are the scene's coordinates in a tree without rotations in space alone.
        """
        loop = self.has_constraints
        if self.engine.reads_mjcf and (
            self.scene.discretisation_coordinates
            or self.scene.quaternions  # rotations are no sums, whatever scheme their rates have
            or (loop and not self.knows_softness)
        ):
            return None
        return method.scheme if method.scheme_with_loops or not loop else None

    def options(self, method: Method) -> tuple[Option, ...]:
        """Return the options that limit accuracy: the closure's softness, and the engine's."""
        engine = self.engine
        soft = engine.closure == "mjcf" and self.source.softened is not None
        own: tuple[Option, ...] = ()
        if "options" in engine.functions:
            own = options_of(engine.inner.options(self.origin, method))
        return (CLOSURE_TIME, *own) if soft else own

    # Its joints

    @cached_property
    def text(self) -> str:
        """The MJCF, with the parameters, placed in the world as the case says."""
        return placed(mjcf.export(self.source, self.case.parameters), self.case.placement)

    @cached_property
    def file_equations(self) -> ModelEquations | None:
        """The equations that an MJCF model of a continuum has, which states belong to."""
        find = self.source.equations if self.scene.discretisation_coordinates else None
        return ModelEquations(*find(self.case.parameters)) if find else None

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """The coordinates in which the engine takes states and gives matrices."""
        if self.file_equations:
            return self.file_equations.scene.coordinates
        return self.scene.coordinates if self.engine.reads_mjcf else self.scene.public

    def start(self, case: Case) -> Array:
        """Return the initial state of a case; a case need not know the model's coordinates."""
        own = self.file_equations if self.engine.reads_mjcf else self.discrete
        if own:
            return own.start(case)
        if self.coordinates == self.scene.coordinates:
            return self.scene.state(case.state)
        values = self.scene.completed(case.state)
        return np.array([float(values[name]) for name in self.scene.public_states])

    def system(self, case: Case) -> System:
        """Return the system of a case for the engine, with the parameters that are bound.

        Its loops may start open.
        """
        origin, time, state = self.origin, float(case.start_time), self.start(case)
        q, v = np.split(state, 2)
        if self.engine.reads_mjcf:
            motion, off = self.motion(time, state), case.inconsistency
            q = np.hstack([motion[name][0] + off.get(name, 0.0) for name in origin.joints])
            v = np.hstack([motion[name][1] + off.get(f"{name}_dot", 0.0) for name in origin.joints])
        bound = replace(case, parameters=self.case.parameters, placement=self.case.placement)
        return replace(origin, case=bound, positions=q, velocities=v, start_time=time)

    @cached_property
    def origin(self) -> System:
        """The system in the origin of the scene.

        Raises
        ------
        CannotJudgeError
            If the file holds what `models.mechanism` does not understand, unless the engine needs
            nothing but the file.
        EngineError
            ``start``, if a viewer does not open the file there; runs start elsewhere and would
            not tell.
        """
        case, scene, source, p = self.case, self.scene, self.source, self.case.parameters
        if not self.engine.reads_mjcf:
            names = self.discrete.scene.coordinates if self.discrete else self.coordinates
            q, v = np.zeros((2, len(names)))
            return System(case, self.name, names, q, v, observables=scene.observed)
        text = self.text
        motion = self.motion(0.0, self.start(case))
        for joint, place in joint_places(text).items():
            expected = motion[joint][0]
            if place is not None and abs(place - expected) > 1e-12 * max(1.0, abs(expected)):
                raise EngineError(
                    "start",
                    f"as opened, the MJCF starts with {joint} at {place:.9g}, not {expected:.9g}",
                )
        joints = tuple(joint_places(text))
        turning = {one.name for one in scene.quaternions}
        drivers = (name for name, at in motion.items() if name not in turning and any(at))
        system = System(
            case=case,
            model=self.name,
            joints=joints,
            positions=np.hstack([motion[name][0] for name in joints]),
            velocities=np.hstack([motion[name][1] for name in joints]),
            mjcf=text,
            drivers=tuple(drivers) if scene.drive is not None else (),
            observables=() if turning else scene.observed,
            reactions={
                name: (element, world_axes(case.placement)[:, axis])
                for name, (element, axis) in source.reactions.items()
            },
        )
        try:
            whole = mechanism(text)
        except CannotJudgeError:
            if not self.engine.inner.needs_only_mjcf:
                raise
            return system
        waves = source.controls(p) if source.controls else {}
        terms = tuple(
            replace(term, **waves[term.name]._asdict())
            if term.kind == "actuator" and term.name in waves
            else term
            for term in whole.terms
        )
        stop = source.stop(p)
        return replace(
            system,
            terms=terms if stop is None else switched_off(terms, stop),
            armatures={one.name: one.armature for one in whole.joints if one.armature},
            closures=whole.closures,
            kinds=whole.layout.kinds,
        )

    @cached_property
    def prescribed(self) -> list[int]:
        """Which coordinates have a given motion."""
        names = self.source.prescribed(self.case.parameters)
        return [self.coordinates.index(name) for name in names]

    def motion(self, time: float, state: Array) -> mjcf.Motion:
        """Return position and velocity of every joint of a file at a time [s] and state (2 n,)."""
        names = (*self.coordinates, *(f"{name}_dot" for name in self.coordinates))
        values = dict(zip(names, map(float, state), strict=True))
        motion = self.source.joints(self.case.parameters, time, values)
        return placed_motion(motion, self.case.placement) if self.case.placement else motion

    @cached_property
    def readout(self) -> Readout:
        """How the coordinates follow from the joints of a file."""
        system, sums = self.origin, self.source.readout
        axes = world_axes(self.case.placement)
        return Readout(self.scene, self.coordinates, system.joints, system.layout, sums, axes)

    def joint_motion(self, time: float, state: Array) -> tuple[Array, Array]:
        """Return positions (n_q,) and velocities (n_v,) of all joints at a time and state."""
        if not self.engine.reads_mjcf:
            q, v = np.split(state, 2)
            return q, v
        joints, motion = self.origin.joints, self.motion(time, state)
        q, v = (np.hstack([motion[name][i] for name in joints]) for i in (0, 1))
        return q, v

    def joint_states(self, times: Array, states: Array) -> tuple[Array, Array]:
        """Return positions (k, n_q) and velocities (k, n_v) of all joints at states.

        Parameters
        ----------
        times : array (k,)
        states : array (k, 2 n)
        """
        rows = zip(times, states, strict=True)
        q, v = zip(*(self.joint_motion(float(t), x) for t, x in rows), strict=True)
        return np.array(q), np.array(v)

    def jacobian(self, time: float, state: Array) -> Array:
        """Return the velocities (n, n_v) of joints per unit rate of each coordinate."""
        n = len(state) // 2
        standing = np.concatenate([state[:n], np.zeros(n)])
        moving = standing + np.vstack([np.zeros(2 * n), np.eye(2 * n)[n:]])
        rates = [self.joint_motion(time, x)[1] for x in moving]
        return np.array(rates[1:]) - rates[0]

    def of_coordinates(self, state: Array, matrix: Array) -> Array:
        """Return the mass matrix (n, n) of coordinates from the joints' (n_v, n_v) at a state."""
        if not self.engine.reads_mjcf:
            return matrix
        jacobian = self.jacobian(0.0, state)
        own, places = jacobian @ matrix @ jacobian.T, self.prescribed
        own[places, :] = own[:, places] = 0  # the identity's where motion is prescribed
        own[places, places] = 1
        return self.readout.completed(own, state, self.case.parameters)

    # What it computes

    def simulate(self, case: Case, method: Method, step: float, times: Array) -> Trajectory:
        """Integrate from ``case.start_time`` with a fixed step; ``times`` lie on its grid.

        Raises
        ------
        EngineError
            ``returned``, if what comes back has no sense.
        """
        system = self.system(case)
        refuse_step_across_end(system, step, times)
        motion = self.engine.inner.simulate(system, method, step, times.copy())
        return self.trajectory(system, step, times, motion, method.precision)

    def trajectory(
        self, system: System, step: float, times: Array, motion: Any, precision: str | None = None
    ) -> Trajectory:
        """Return the record of a run, in the scene's observables.

        Raises
        ------
        EngineError
            ``returned``, if ``motion`` is not a valid `Motion`; the error itself if it is one.
        """
        q, v, sensed = motion_of(system, motion, times, precision or self.engine.precision)
        values = self.observed(q, v, sensed)
        if all(np.all(np.isfinite(row)) for row in values.values()):
            refuse_lost_joints(system, times, np.hstack([q, v]))
        return trajectory_of(system, motion, step, times, values)

    def observed(self, q: Array, v: Array, sensed: Mapping[str, Array]) -> dict[str, Array]:
        """Return the scene's observables (n_t,) of joints' motion, and how far loops are open.

        What the engine's sensors show comes from them, the rest from the joints.

        Parameters
        ----------
        q : array (n_t, n_q)
        v : array (n_t, n_v)
        sensed : mapping of str to array (n_t,)

        Raises
        ------
        EngineError
            ``returned``, if outputs of the scene are missing that do not follow from the joints.
        """
        by_file = self.engine.reads_mjcf
        names = self.coordinates if by_file else self.origin.joints
        rows = self.readout.states(q, v) if by_file else np.hstack([q, v]).T
        values = dict(zip((*names, *(f"{name}_dot" for name in names)), rows, strict=True))
        values |= sensed
        missing = [name for name in self.observables if name not in values]
        if not missing:
            return values
        equations = scene_equations(self.case)
        if by_file and not self.has_constraints:
            equations = self.equations
        elif not by_file and (
            set(missing) & set(VIOLATIONS) or names != equations.scene.coordinates
        ):
            raise EngineError("returned", f"Motion.observables must tell {', '.join(missing)}")
        states = np.array([values[name] for name in equations.scene.state_names])
        with np.errstate(all="ignore"):  # the guard refuses values that are not finite
            others = equations.scene.observe(states, equations.parameters)
            if by_file and self.has_constraints:
                others |= self.loop_motion(q, v)
        return values | {name: others[name] for name in missing if name in others}

    def loop_motion(self, q: Array, v: Array) -> dict[str, Array]:
        """Return the motion (n_t,) of the joints of a file by name, and how far loops are open."""
        layout, whole = self.origin.layout, mechanism(self.text)
        values: dict[str, Array] = {}
        places = zip(layout.positions, layout.velocities, strict=True)
        for joint, (at, rate) in zip(self.origin.joints, places, strict=True):
            values |= {joint: q[:, at.start], f"{joint}_dot": v[:, rate.start]}
        apart = [gaps(whole, row) for row in q]
        rates = [gap_jacobian(whole, a) @ b for a, b in zip(q, v, strict=True)]
        for name, residuals in zip(VIOLATIONS, (apart, rates), strict=True):
            values[name] = np.linalg.norm(residuals, axis=1)
        return values

    def accelerations(self, times: Array, states: Array, method: Method | None = None) -> Array:
        """Return accelerations (k, n) at ``times`` (k,) and ``states`` (k, 2 n)."""
        moving = self.joint_accelerations(times, *self.joint_states(times, states), method)
        return self.readout.accelerations(states, moving) if self.engine.reads_mjcf else moving

    def joint_accelerations(
        self, times: Array, positions: Array, velocities: Array, method: Method | None = None
    ) -> Array:
        """Return accelerations (k, n_v) of the joints at times (k,) and states (k, n_q), (k, n_v).

        Raises
        ------
        Unsupported
            If the engine has no `accelerations`.
        EngineError
            ``returned``
        """
        ask = self.engine.by_method("accelerations", method)
        rows = zip(times, positions, velocities, strict=True)
        shape = velocities.shape[1:]
        return np.array(
            [  # each is copied as it comes: an engine may return a view of its own buffer
                numbers(
                    "accelerations",
                    ask(self.origin, float(t), q.copy(), v.copy()),
                    shape,
                    finite=True,
                )
                for t, q, v in rows
            ]
        )

    def mass_matrices(self, states: Array, method: Method | None = None) -> Array:
        """Return mass matrices (k, n, n) of the coordinates at ``states`` (k, 2 n).

        Joints that depend on the coordinates take part; a clock does not. Those whose motion
        is prescribed have the row and the column of the identity.
        """
        q, v = self.joint_states(np.zeros(len(states)), states)
        rows = zip(states, self.joint_mass_matrices(q, v.shape[1], method), strict=True)
        return np.array([self.of_coordinates(state, matrix) for state, matrix in rows])

    def joint_mass_matrices(
        self, positions: Array, size: int, method: Method | None = None
    ) -> Array:
        """Return mass matrices (k, n_v, n_v) of n_v joint velocities at positions (k, n_q).

        Raises
        ------
        Unsupported
            If the engine has no `mass_matrix`.
        EngineError
            ``returned``
        """
        ask = self.engine.by_method("mass_matrix", method)
        return np.array(
            [
                numbers("mass_matrix", ask(self.origin, q.copy()), (size, size), finite=True)
                for q in positions
            ]
        )

    def reactions(self, times: Array, states: Array) -> dict[str, Array]:
        """Return those forces (k,) at ``times`` (k,) and ``states`` (k, 2 n)."""
        names = self.reaction_names
        forces = np.empty((len(names), len(states)))
        for i, (time, at, speed) in enumerate(
            zip(times, *self.joint_states(times, states), strict=True)
        ):
            there = self.engine.inner.reactions(self.origin, float(time), at.copy(), speed.copy())
            for row, name in zip(forces, names, strict=True):
                if not isinstance(there, Mapping) or name not in there:
                    raise EngineError("returned", f"reactions must tell {name}: {in_short(there)}")
                row[i] = numbers(f"reactions[{name!r}]", there[name], (), finite=True)
        return dict(zip(names, forces, strict=True))

    def linearise(self, state: Array, time: float = 0.0) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about a state of rest or steady motion.

        The engine's matrices, if it has `linearise`: for a tree at rest, and for models that it
        describes, in coordinates that may be fewer than the states'. Else central differences.

        Raises
        ------
        Unsupported
            If a closure is soft and there is no inverse dynamics: modes are those of a closed
            loop, accelerations those of an open one.
        """
        moves = np.any(state[len(state) // 2 :])
        own_models = bool({"models", "describe_model"} & self.engine.functions)
        if "linearise" in self.engine.functions and (
            own_models or not (moves or self.has_constraints)
        ):
            try:
                return self.linearise_by_engine(state, time)
            except Unsupported:
                if own_models:
                    raise
        return self.linearise_numerically(state, time)

    def linearise_by_engine(self, state: Array, time: float) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), by the engine's own function."""
        q, v = self.joint_motion(time, state)
        system = replace(self.origin, positions=q, velocities=v, start_time=time)
        size = len(v) if self.engine.reads_mjcf else None
        mass, damping, stiffness = matrices(self.engine.inner.linearise(system), size)
        if not self.engine.reads_mjcf:
            return mass, damping, stiffness
        jacobian = self.jacobian(time, state)
        mass, damping, stiffness = (
            jacobian @ item @ jacobian.T for item in (mass, damping, stiffness)
        )
        return self.readout.completed(mass, state, self.case.parameters), damping, stiffness

    def linearise_numerically(self, state: Array, time: float) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), by central differences of forces.

        Of those of the engine's inverse dynamics, the accelerations kept; without it, of its
        accelerations times the mass matrix of the file, which leaves the eigenvalues alone. With
        inverse dynamics a loop counts as closed for good: its constraint's forces do no work.
        """
        n, times, engine = len(state) // 2, np.array([time]), self.engine
        inverse = "inverse_dynamics" in engine.functions
        if not inverse and self.knows_softness:
            raise Unsupported("accelerations of a soft closure show no modes of a closed loop")
        q, v = self.joint_states(times, state[None])
        # a soft closure yields even at rest, which a closed loop does not
        acceleration = 0 * v[0]
        if inverse and not self.has_constraints:
            acceleration = self.joint_accelerations(times, q, v)[0]

        def force(moved: Array) -> Array:
            if not inverse:
                force = self.own_mass_matrix(moved) @ self.accelerations(times, moved[None])[0]
                return np.asarray(-force)
            at, speed = self.joint_motion(time, moved)
            force = engine.inner.inverse_dynamics(self.origin, time, at, speed, acceleration.copy())
            force = numbers("inverse_dynamics", force, acceleration.shape, finite=True)
            constant = not curved or np.array_equal(moved[:n], state[:n])  # only rates are moved
            return np.asarray((standing if constant else self.jacobian(time, moved)) @ force)

        standing = self.jacobian(time, state)
        # joints of a tree in the plane are linear in the coordinates
        curved = self.has_constraints or self.origin.layout.is_spatial
        width = CURVED_DIFFERENCE if curved else DIFFERENCE
        _, slopes = by_differences(one_by_one(force), state, ORDER, width)
        slopes[self.prescribed] = 0
        mass = self.mass_matrices(state[None])[0] if inverse else self.own_mass_matrix(state)
        return mass, slopes[:, n:], slopes[:, :n]

    def own_mass_matrix(self, state: Array) -> Array:
        """Return the mass matrix (n, n) of the coordinates that the file or the scene has."""
        if not self.engine.reads_mjcf:
            c = self.scene.coefficients(self.case.parameters)
            return np.array(self.scene.mass_matrix(state[: len(state) // 2], c), dtype=float)
        q, _ = self.joint_motion(0.0, state)
        return self.of_coordinates(state, mass_matrix(mechanism(self.text), q))


class Adapter:
    """An engine with its models of the scenes.

    Attributes
    ----------
    inner : Engine
        Its attributes are those of the adapter as well.
    functions : frozenset of str
        Which of the optional functions the engine has.
    closure_time : float or None
        Time constant [s] in which loops close whose softness is free; None: as in the file.
    failure : BrokenEngineError or None
        Its failure while checks were planned, after which it is not called again.
    bound : type
        Of its models.
    """

    closure_time: float | None = None
    failure: BrokenEngineError | None = None
    bound: type[BoundModel] = BoundModel

    def __init__(self, inner: Engine) -> None:
        self.functions = own_functions(inner)
        self.name, self.version, self.methods = inner.name, inner.version, tuple(inner.methods)
        self.reads_mjcf, self.compliant_joints = bool(inner.reads_mjcf), inner.compliant_joints
        self.precision, self.closure = inner.precision, inner.closure
        self.wrap(inner)

    def wrap(self, inner: Engine) -> None:
        """Replace the wrapped engine and clear cached models."""
        self.inner = inner
        self.accumulates_clock, self.min_inertia = inner.accumulates_clock, inner.min_inertia
        self.max_value, self.newton_tolerance = inner.max_value, inner.newton_tolerance
        self.takes_method = functions_by_method(inner)
        self.made = lru_cache(MAX_MODELS)(self.make)
        self.names = lru_cache(self.ask_names)

    def bind(self, case: Case, model: str) -> BoundModel:
        """Return a model of this name with the parameters and the placement of a case.

        Raises
        ------
        UnknownNameError
            If the engine has no such model of the scene.
        """
        return self.made(case.scene, model, case.parameters, case.placement)

    def make(self, scene: str, model: str, parameters: Any, placement: str) -> BoundModel:
        """Return a new bound model."""
        return self.bound(self, Case(scene, "", parameters, placement=placement), model)

    def read_source(self, scene: str, model: str) -> mjcf.Mjcf:
        """Return the named MJCF model, `NO_FILE` of an engine that reads none.

        Raises
        ------
        UnknownNameError
            If the engine has no such model of the scene.
        """
        table = mjcf.models(scene)
        known = table if self.reads_mjcf else self.models(scene)
        if model not in known:
            owner = "MJCF" if self.reads_mjcf else self.name
            raise UnknownNameError(f"{owner} model of {scene}", model, known)
        source = table[model] if self.reads_mjcf else NO_FILE
        if self.closure_time is None or source.softened is None:
            return source
        return source.softened(self.closure_time)

    def models(self, scene: str) -> tuple[str, ...]:
        """Return the names of its models of a scene, default first.

        For engines that ignore the softness of a closure, models that differ in it count once.
        """
        if not self.reads_mjcf:
            return self.names(scene)
        every = self.closure == "mjcf"
        table = mjcf.models(scene)
        return tuple(name for name, one in table.items() if every or one.softened is None)

    def ask_names(self, scene: str) -> tuple[str, ...]:
        """Return the engine's names of models, none of a scene that it refuses."""
        if "models" not in self.functions:
            return (OWN,)
        try:
            return self.call_before_checks("models", lambda: model_names(self.inner.models(scene)))
        except Unsupported:
            return ()

    def twins(self, scene: str) -> tuple[str, ...]:
        """Return the models of a file that a force in time drives in place of a body."""
        table = mjcf.models(scene) if self.reads_mjcf else {}
        return tuple(name for name in self.models(scene) if name in table and table[name].controls)

    def distinct_models(self, scene: str) -> tuple[str, ...]:
        """Return `models` without `twins`."""
        twins = self.twins(scene)
        return tuple(name for name in self.models(scene) if name not in twins)

    def call_before_checks(self, function: str, work: Callable[[], T]) -> T:
        """Return the answer of a function of the engine before there is a check to judge it by.

        Raises
        ------
        Unsupported
            If it refuses the call.
        BrokenEngineError
            If it gives no answer; names the line of its code that raised.
        """
        try:
            return call_engine(work)
        except Unsupported:
            raise
        except MbcheckError as error:
            lines = re.findall(r'File "([^"]+)", line (\d+)', error.traceback)
            place = "".join(f" ({Path(file).name}, line {line})" for file, line in lines[-1:])
            reason = f"engine {self.name}: {function}: {error}{place}"
            self.failure = BrokenEngineError(reason, error.traceback)
            raise self.failure from error

    def by_method(self, function: str, method: Method | None) -> Callable[..., Any]:
        """Return ``accelerations`` or ``mass_matrix``, for a method if the engine takes one."""
        call: Callable[..., Any] = self.inner.accelerations
        if function == "mass_matrix":
            call = self.inner.mass_matrix
        takes = method is not None and function in self.takes_method
        return partial(call, method=method) if takes else call

    def with_option(self, name: str, value: float) -> Self:
        """Return the engine with one of its options set."""
        other = copy(self)
        if name == CLOSURE_TIME.name and self.reads_mjcf and self.closure == "mjcf":
            other.closure_time = value
        else:
            other.inner = self.inner.with_option(name, value)
        other.wrap(other.inner)
        return other

    def reordered(self, order: tuple[int, ...], inputs_too: bool) -> Self:
        """Return the engine with its answers taken for those of joints in another order."""
        return type(self)(Reordered(self, order, inputs_too))


class Reordered(Engine):
    """Another engine, whose numbers are those of joints in some order.

    Parameters
    ----------
    adapter : Adapter
        The other engine's.
    order : tuple of int
        The joint of each number.
    inputs_too : bool
        Whether states are given to it in this order as well.
    """

    def __init__(self, adapter: Adapter, order: tuple[int, ...], inputs_too: bool) -> None:
        self.adapter, self.inner, self.inputs_too = adapter, adapter.inner, inputs_too
        self.back = list(np.argsort(order))
        self.order = list(order) if inputs_too else list(range(len(order)))
        vars(self).update(attributes(self.inner))

    def put(self, system: System) -> System:
        """Return a system whose initial state is in the other order.

        Raises
        ------
        Unsupported
            If it has not one number for each joint.
        """
        if {len(system.positions), len(system.joints)} != {len(self.back)}:
            raise Unsupported("it has not one number for each joint")
        place = self.order
        return replace(
            system, positions=system.positions[place], velocities=system.velocities[place]
        )

    def simulate(self, system: System, method: Method, step: float, times: Array) -> Motion:
        """Integrate, and put what comes back in order."""
        motion = self.inner.simulate(self.put(system), method, step, times)
        q, v = (np.asarray(rows)[:, self.back] for rows in (motion.positions, motion.velocities))
        return replace(motion, positions=q, velocities=v)

    def accelerations(
        self, system: System, time: float, q: Array, v: Array, method: Method | None = None
    ) -> Array:
        """Return accelerations (n,) in order."""
        ask = self.adapter.by_method("accelerations", method)
        answer = ask(self.put(system), time, q[self.order], v[self.order])
        return np.asarray(answer)[self.back]

    def mass_matrix(self, system: System, q: Array, method: Method | None = None) -> Array:
        """Return the mass matrix (n, n) in order."""
        ask = self.adapter.by_method("mass_matrix", method)
        return np.asarray(ask(self.put(system), q[self.order]))[np.ix_(self.back, self.back)]


def adapt(name: str, offered: Any) -> Adapter:
    """Return an engine from a class that someone wrote.

    Parameters
    ----------
    name : str
        The name given by the user, for messages.
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
    return Adapter(engine)
