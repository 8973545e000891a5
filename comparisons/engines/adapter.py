"""Engines in the coordinates of the scenes: what checks ask of an engine, whatever it is."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Self, TypeVar

import numpy as np

from ...models import mjcf
from ...models.kinematics import gap_jacobian, gaps, mass_matrix
from ...models.mechanism import joint_places, mechanism, switched_off
from ...models.placement import placed, placed_motion, why_not_placed, world_axes
from ...models.readout import Readout
from ...models.system import System
from ...reference import get_scene
from ...reference.differences import by_differences, one_by_one
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
from .equations import ModelEquations, scene_equations
from .protocol import Engine, Method, Motion, Option, OwnModel
from .run import VIOLATIONS, Trajectory, call_engine, captured
from .validation import (
    ATTRIBUTES,
    INTEGRALS,
    count,
    declared,
    in_short,
    matrices,
    names_of,
    numbers,
    observables_of,
    optional_count,
    options_of,
    own_functions,
    own_model_of,
    reason_of,
    refuse_lost_joints,
    refuse_lost_length,
    refuse_no_tables,
    refuse_one_state,
    refuse_step_across_end,
)

T = TypeVar("T")

CLOSURE_TIME = Option(
    "closure_time", "s", 2e-3, (2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4), "closure softness"
)
"""Of models whose file may be written with another softness, for engines that read it."""

SYSTEMS, ANSWERS = 256, 4096
"""Systems that an adapter keeps, since a map runs its points repeatedly, and answers of its engine
from before a run: each kind of check asks of all methods."""

OWN = "scene"
"""Name of the model of an engine that reads no MJCF."""

NO_FILE = mjcf.Mjcf(path=Path(), bindings={}, controls=lambda parameters: {})
"""Stands for that model: its joints are the coordinates, and a force drives them."""

UNKNOWN_SOFTNESS = "its loops are soft by a rule of its own: no reference has their equations"

ORDER = 8
DIFFERENCE = 0.03
"""Order and step of central differences (rad, m and their rates). Truncation is 1e-15 then; what
rounding leaves of accelerations, whose stiffest modes are far faster than those looked at, falls
with the step."""

TURNING = DIFFERENCE / 6
"""The same step where quaternions turn: rotations have poles at the length 0, at the distance 1."""


class Adapter:
    """An engine with its models of the scenes, in the coordinates of the scenes.

    ``model`` is one of the names of `models`: ways in which the engine models the scene, the
    first is its default. States are arrays (2 n,): coordinates, then rates, in the order of
    `coordinates`.

    Attributes
    ----------
    inner : Engine
        Its attributes are those of the adapter as well.
    functions : frozenset of str
        Which of the optional functions the engine has.
    closure_time : float or None
        Time constant [s] in which loops close whose softness is free; None: as in the file.
    failure : BrokenEngineError or None
        How it failed as checks of it were planned, after which it is asked for nothing.
    """

    closure_time: float | None = None
    failure: BrokenEngineError | None = None

    def __init__(self, inner: Engine) -> None:
        self.functions = own_functions(inner)
        self.name, self.version, self.methods = inner.name, inner.version, tuple(inner.methods)
        self.reads_mjcf = bool(inner.reads_mjcf)
        self.precision, self.closure = inner.precision, inner.closure
        self.hold(inner)

    def hold(self, inner: Engine) -> None:
        """Replace the wrapped engine and clear what is cached of the one before."""
        self.inner = inner
        self.accumulates_clock, self.least_inertia = inner.accumulates_clock, inner.least_inertia
        self.largest_value, self.newton_tolerance = inner.largest_value, inner.newton_tolerance
        self.systems = lru_cache(SYSTEMS)(self.system_of)
        self.described = lru_cache(ANSWERS)(self.description_of)
        self.own_reason = lru_cache(ANSWERS)(self.reason_against)

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

    def twins(self, scene: str) -> tuple[str, ...]:
        """Return the models that a force in time drives in place of a body."""
        table = mjcf.models(scene)
        return tuple(name for name in self.models(scene) if name in table and table[name].controls)

    def distinct_models(self, scene: str) -> tuple[str, ...]:
        """Return `models` without `twins`."""
        twins = self.twins(scene)
        return tuple(name for name in self.models(scene) if name not in twins)

    def source(self, case: Case, model: str) -> mjcf.Mjcf:
        """Return the named MJCF model, its loop closed as the option says.

        Raises
        ------
        UnknownNameError
            If there is none.
        """
        if not self.reads_mjcf:
            return NO_FILE
        known = mjcf.models(case.scene)
        if model not in known:
            raise UnknownNameError(f"MJCF model of {case.scene}", model, known)
        source = known[model]
        if self.closure_time is None or source.softened is None:
            return source
        return source.softened(self.closure_time)

    def text(self, case: Case, model: str) -> str:
        """Return the MJCF of a case, placed in the world as it says."""
        return placed(mjcf.export(self.source(case, model), case.parameters), case.placement)

    def why_not_placed(self, case: Case, model: str) -> str | None:
        """Return why a model cannot be placed in the world otherwise than it stands, or None."""
        if not self.reads_mjcf:
            return f"{model} of {self.name} is no MJCF, the text of which could be turned"
        text = self.source(case, model).path.read_text(encoding="utf-8")
        return why_not_placed(text, case.placement)

    def model_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Return the equations of motion that the model has, None where they are the scene's.

        A loop is as soft as the engine has it.
        """
        if self.closure == "mjcf" or not self.has_constraints(case, model):
            equations = self.source(case, model).equations
            return ModelEquations(*equations(case.parameters)) if equations else None
        own = self.closure == "soft" and self.about(case, model).equations
        return ModelEquations(*own) if own else None

    def discrete_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Return the equations of the elements of a model that converges to a continuum.

        With them the engine takes states in their coordinates too, and returns these of a run.
        """
        return None

    def has_constraints(self, case: Case, model: str) -> bool:
        """Return whether a loop of the model is closed by a constraint."""
        return self.source(case, model).closed

    def coordinates(self, case: Case, model: str) -> tuple[str, ...]:
        """Return the coordinates of states: the scene's, or its own where those are internal."""
        scene = get_scene(case.scene)
        equations = self.model_equations(case, model) if scene.discretisation_coordinates else None
        return equations.scene.coordinates if equations else scene.coordinates

    def integrates_drive(self, case: Case, model: str) -> bool:
        """Return whether the drive is a body of the model, integrated like the rest."""
        return self.source(case, model).controls is None

    def element_order(self, case: Case, model: str) -> int:
        """Return the order with which the model converges to a continuum, or 0."""
        return self.source(case, model).elements.order

    def frequency_side(self, case: Case, model: str) -> int:
        """Return whether its first frequency lies below (-1) or above (1) the continuum's, or 0."""
        return self.source(case, model).elements.side(case.parameters)

    def reaction_names(self, case: Case, model: str) -> tuple[str, ...]:
        """Return the outputs of the scene that are forces in joints of the model."""
        if "reactions" not in self.functions:
            return ()
        return tuple(self.source(case, model).reactions)

    def about(self, case: Case, model: str) -> OwnModel:
        """Return what the engine tells of a model with the parameters of a case."""
        return self.description(case, model)[0]

    def description(self, case: Case, model: str) -> tuple[OwnModel, str | None]:
        """Return the engine's description of a model of a case, and the reason if it has none.

        Raises
        ------
        UnknownNameError
            If it has none of this name.
        BrokenEngineError
            If it gives no answer.
        """
        return self.described(case.scene, model, case.parameters, case.placement)

    def description_of(
        self, scene: str, model: str, parameters: Any, placement: str
    ) -> tuple[OwnModel, str | None]:
        """Return the same, which depends on nothing else of a case."""
        if model not in self.models(scene):
            raise UnknownNameError(f"{self.name} model of {scene}", model, self.models(scene))
        if "own_model" not in self.functions:
            return OwnModel(), None
        case = Case(scene, "", parameters, placement=placement)
        names, outputs = get_scene(scene).public, get_scene(scene).units
        try:
            if self.reads_mjcf:
                system = self.systems(scene, model, parameters, placement)
            else:
                system = System(case, model, names, *np.zeros((2, len(names))))
            about = self.ahead(
                "own_model", lambda: own_model_of(self.inner.own_model(system), outputs)
            )
            if about.equations is not None:
                self.refuse_foreign_equations(ModelEquations(*about.equations), case)
        except ArithmeticError:
            return OwnModel(), None  # as in `reason_against`
        except Unsupported as error:
            return OwnModel(), str(error)
        return about, None

    def refuse_foreign_equations(self, equations: ModelEquations, case: Case) -> None:
        """Refuse equations that fail in a state of the scene: those of another one, for instance.

        Raises
        ------
        BrokenEngineError
            Names the line that raised.
        """
        scene = get_scene(case.scene)
        first = replace(scene.cases[0], parameters=case.parameters, placement=case.placement)
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
            if missing := set(scene.observables).difference(values):
                raise EngineError("returned", f"they do not tell {', '.join(sorted(missing))}")

        self.ahead(f"own_model: its equations for {scene.name}", refuse_missing)

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
            return self.description(case, model)[1] or UNKNOWN_SOFTNESS
        if not self.reads_mjcf and get_scene(case.scene).discretisation_coordinates:
            return f"{case.scene} is a continuum: only engines that read its MJCF are checked"
        reason = self.source(case, model).why_not(case.parameters)
        if reason or "why_not" not in self.functions:
            return reason
        return self.own_reason(case, model, method)

    def reason_against(self, case: Case, model: str, method: Method | None) -> str | None:
        """Return the engine's reason for not running this case on this model, or None.

        Raises
        ------
        BrokenEngineError
            If it gives no answer.
        """
        try:
            system = self.joint_system(case, model)
        except ArithmeticError:
            return None  # whoever goes on is told, of a run also how many steps it would take
        try:
            return self.ahead("why_not", lambda: reason_of(self.inner.why_not(system, method)))
        except Unsupported as error:
            return str(error)

    def ahead(self, function: str, work: Callable[[], T]) -> T:
        """Return the answer of a function of the engine before there is a check to judge it by.

        Raises
        ------
        Unsupported
            If it cannot do what it was asked for.
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
            other.inner = self.inner.with_option(name, value)
        other.hold(other.inner)
        return other

    def reordered(self, order: tuple[int, ...], inputs_too: bool) -> Self:
        """Return the engine with its answers taken for those of joints in another order."""
        return type(self)(Reordered(self.inner, order, inputs_too))

    # States

    def joint_system(self, case: Case, model: str) -> System:
        """Return the system of a case for the engine; its loops may start open."""
        system = self.systems(case.scene, model, case.parameters, case.placement)
        if not self.reads_mjcf:
            q, v = np.split(self.start(case, model), 2)
        else:
            motion = self.motion(case, model, case.start_time, self.start(case, model))
            off = case.inconsistency
            q = np.hstack([motion[name][0] + off.get(name, 0.0) for name in system.joints])
            v = np.hstack([motion[name][1] + off.get(f"{name}_dot", 0.0) for name in system.joints])
        return replace(
            system, case=case, positions=q, velocities=v, start_time=float(case.start_time)
        )

    def system_of(self, scene: str, model: str, parameters: Any, placement: str = "") -> System:
        """Return what the engine is told of parameters, in the scene's origin, placed so.

        Raises
        ------
        CannotJudgeError
            If the file holds what `models.mechanism` does not understand, unless the engine reads
            all of MJCF by itself.
        EngineError
            ``start``, if a viewer does not open the file there; runs start elsewhere and would
            not tell.
        """
        case = Case(scene, "", parameters, placement=placement)
        if not self.reads_mjcf:
            names = get_scene(scene).coordinates
            return System(case, OWN, names, *np.zeros((2, len(names))))
        source, text = self.source(case, model), self.text(case, model)
        origin = self.motion(case, model, 0.0, self.start(case, model))
        for joint, place in joint_places(text).items():
            expected = origin[joint][0]
            if place is not None and abs(place - expected) > 1e-12 * max(1.0, abs(expected)):
                raise EngineError(
                    "start",
                    f"as opened, the MJCF starts with {joint} at {place:.9g}, not {expected:.9g}",
                )
        joints = tuple(joint_places(text))
        driven = get_scene(scene).drive is not None
        turning = {one.name for one in get_scene(scene).quaternions}
        system = System(
            case=case,
            model=model,
            joints=joints,
            positions=np.hstack([origin[name][0] for name in joints]),
            velocities=np.hstack([origin[name][1] for name in joints]),
            mjcf=text,
            drivers=tuple(
                name for name, at in origin.items() if driven and name not in turning and any(at)
            ),
            observables=() if turning else get_scene(scene).observed,
            reactions={
                name: (element, world_axes(placement)[:, axis])
                for name, (element, axis) in source.reactions.items()
            },
        )
        try:
            whole = mechanism(text)
        except CannotJudgeError:
            if not self.inner.reads_all_mjcf:
                raise
            return system
        waves = source.controls(parameters) if source.controls else {}
        terms = tuple(
            replace(term, **waves[term.name]._asdict())
            if term.kind == "actuator" and term.name in waves
            else term
            for term in whole.terms
        )
        stop = source.stop(parameters)
        return replace(
            system,
            terms=terms if stop is None else switched_off(terms, stop),
            armatures={one.name: one.armature for one in whole.joints if one.armature},
            closures=whole.closures,
            kinds=whole.layout.kinds,
        )

    def start(self, case: Case, model: str) -> Array:
        """Return the initial state of a case; a case need not know the model's coordinates."""
        scene = get_scene(case.scene)
        equations = self.model_equations(case, model) if scene.discretisation_coordinates else None
        return equations.start(case) if equations else scene.state(case.state)

    def prescribed(self, case: Case, model: str) -> list[int]:
        """Return which coordinates have a given motion."""
        names = self.source(case, model).prescribed(case.parameters)
        return [self.coordinates(case, model).index(name) for name in names]

    def motion(self, case: Case, model: str, time: float, state: Array) -> mjcf.Motion:
        """Return position and velocity of every joint."""
        coordinates = self.coordinates(case, model)
        names = (*coordinates, *(f"{name}_dot" for name in coordinates))
        values = dict(zip(names, map(float, state), strict=True))
        motion = self.source(case, model).joints(case.parameters, time, values)
        return placed_motion(motion, case.placement)

    def joint_readout(self, case: Case, model: str, system: System) -> Readout:
        """Return how the coordinates follow from the joints of a system."""
        scene, names = get_scene(case.scene), self.coordinates(case, model)
        sums = self.source(case, model).readout
        axes = world_axes(case.placement)
        return Readout(scene, names, system.joints, system.layout, sums, axes)

    def joint_states(
        self, case: Case, model: str, times: Array, states: Array
    ) -> tuple[System, Array, Array]:
        """Return the system, and positions (k, n_q) and velocities (k, n) of its joints at states.

        Parameters
        ----------
        times : array (k,)
        states : array (k, 2 n_coordinates)
        """
        system = self.joint_system(case, model)
        rows = zip(times, states, strict=True)
        motions = [self.joint_motion(case, model, system.joints, float(t), x) for t, x in rows]
        q, v = zip(*motions, strict=True)
        return system, np.array(q), np.array(v)

    def joint_motion(
        self, case: Case, model: str, joints: tuple[str, ...], time: float, state: Array
    ) -> tuple[Array, Array]:
        """Return positions (n_q,) and velocities (n,) of joints at a time and state."""
        motion = self.motion(case, model, time, state)
        q, v = (np.hstack([motion[name][i] for name in joints]) for i in (0, 1))
        return q, v

    def jacobian(self, case: Case, model: str, joints: tuple[str, ...], state: Array) -> Array:
        """Return the velocities (n, n_v) of joints per unit rate of each coordinate."""
        n = len(state) // 2
        standing = np.concatenate([state[:n], np.zeros(n)])
        moving = standing + np.vstack([np.zeros(2 * n), np.eye(2 * n)[n:]])
        rates = [self.joint_motion(case, model, joints, case.start_time, x)[1] for x in moving]
        return np.array(rates[1:]) - rates[0]

    def of_coordinates(
        self, case: Case, model: str, system: System, state: Array, matrix: Array
    ) -> Array:
        """Return the mass matrix (n, n) of coordinates from the joints' (n_v, n_v) at a state."""
        jacobian = self.jacobian(case, model, system.joints, state)
        own, places = jacobian @ matrix @ jacobian.T, self.prescribed(case, model)
        own[places, :] = own[:, places] = 0  # the identity's where motion is prescribed
        own[places, places] = 1
        return self.joint_readout(case, model, system).completed(own, state, case.parameters)

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

    def accelerations(self, case: Case, model: str, times: Array, states: Array) -> Array:
        """Return accelerations (k, n) at ``times`` (k,) and ``states`` (k, 2 n)."""
        system, q, v = self.joint_states(case, model, times, states)
        moving = self.joint_accelerations(system, times, q, v)
        return self.joint_readout(case, model, system).accelerations(states, moving)

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
        shape = velocities.shape[1:]
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

    def reactions(self, case: Case, model: str, times: Array, states: Array) -> dict[str, Array]:
        """Return those forces (k,) at ``times`` (k,) and ``states`` (k, 2 n)."""
        system, q, v = self.joint_states(case, model, times, states)
        names = self.reaction_names(case, model)
        forces = np.empty((len(names), len(states)))
        for i, (time, at, speed) in enumerate(zip(times, q, v, strict=True)):
            there = self.inner.reactions(system, float(time), at.copy(), speed.copy())
            for row, name in zip(forces, names, strict=True):
                if not isinstance(there, Mapping) or name not in there:
                    raise EngineError("returned", f"reactions must tell {name}: {in_short(there)}")
                row[i] = numbers(f"reactions[{name!r}]", there[name], (), finite=True)
        return dict(zip(names, forces, strict=True))

    def linearise(self, case: Case, model: str, state: Array) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about a state of rest or steady motion.

        The engine's own of a tree at rest, if it tells them; else central differences, of its
        inverse dynamics, or of its accelerations times the mass matrix of the MJCF, which leaves
        the eigenvalues alone.

        Raises
        ------
        Unsupported
            If a closure gives way and there is no inverse dynamics: modes are those of a closed
            loop, and accelerations of another.
        """
        n = len(state) // 2
        resting = not np.any(state[n:])
        if resting and not self.has_constraints(case, model):
            try:
                return self.returned_matrices(case, model, state)
            except Unsupported:  # then it follows from differences
                pass
        if "inverse_dynamics" in self.functions:
            return self.by_inverse_dynamics(case, model, state)
        if self.gives_way(case, model):
            raise Unsupported("accelerations of a soft closure show no modes of a closed loop")
        system = self.joint_system(case, model)
        mass = self.own_mass_matrix(case, model, system, state)

        def forces(places: Array) -> Array:
            times = np.full(places.shape[1], case.start_time)
            accelerations = self.accelerations(case, model, times, places.T)
            masses = [
                mass if np.array_equal(place[:n], state[:n])
                else self.own_mass_matrix(case, model, system, place)
                for place in places.T
            ]  # fmt: skip
            return np.einsum("kij,kj->ik", masses, accelerations)

        width = TURNING if system.layout.is_spatial else DIFFERENCE
        _, slopes = by_differences(forces, state, ORDER, width)
        slopes[self.prescribed(case, model)] = 0
        return mass, -slopes[:, n:], -slopes[:, :n]

    def by_inverse_dynamics(
        self, case: Case, model: str, state: Array
    ) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), by the engine's inverse dynamics.

        A loop counts as closed for good: its constraint's forces do no work here. C and K are
        central differences, the accelerations kept: they hold for small departures from the
        motion through ``state``.
        """
        time, n = np.array([case.start_time]), len(state) // 2
        system, q, v = self.joint_states(case, model, time, state[None])
        closed = self.has_constraints(case, model)
        # a soft closure gives way even at rest, which a closed loop does not
        a = 0 * v[0] if closed else self.joint_accelerations(system, time, q, v)[0]
        jacobian = self.jacobian(case, model, system.joints, state)

        def force(moved: Array) -> Array:
            at, speed = self.joint_motion(case, model, system.joints, case.start_time, moved)
            force = self.inner.inverse_dynamics(system, case.start_time, at, speed, a.copy())
            force = numbers("inverse_dynamics", force, a.shape, finite=True)
            # joints of a tree are linear in the coordinates
            here = self.jacobian(case, model, system.joints, moved) if closed else jacobian
            return np.asarray(here @ force)

        _, slopes = by_differences(one_by_one(force), state)
        slopes[self.prescribed(case, model)] = 0
        mass = self.mass_matrices(case, model, state[None])[0]
        return mass, slopes[:, n:], slopes[:, :n]

    def returned_matrices(self, case: Case, model: str, state: Array) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), by the engine's own function.

        Raises
        ------
        Unsupported
            If it has none.
        """
        names = self.coordinates(case, model)
        keys = (*names, *(f"{name}_dot" for name in names))
        there = replace(case, state=dict(zip(keys, map(float, state), strict=True)))
        system = self.joint_system(there, model)
        jacobian = self.jacobian(case, model, system.joints, state)
        mass, damping, stiffness = (
            jacobian @ item @ jacobian.T
            for item in matrices(self.inner.linearise(system), system.layout.size[1])
        )
        readout = self.joint_readout(case, model, system)
        return readout.completed(mass, state, case.parameters), damping, stiffness

    def own_mass_matrix(self, case: Case, model: str, system: System, state: Array) -> Array:
        """Return the mass matrix (n, n) of the coordinates that the file or the scene has."""
        if not self.reads_mjcf:
            scene = get_scene(case.scene)
            q, c = state[: len(state) // 2], scene.coefficients(case.parameters)
            return np.array(scene.mass_matrix(q, c), dtype=float)
        q, _ = self.joint_motion(case, model, system.joints, case.start_time, state)
        matrix = mass_matrix(mechanism(system.mjcf), q)
        return self.of_coordinates(case, model, system, state, matrix)


class OwnModelsAdapter(Adapter):
    """An engine with models of its own; states are in the coordinates of the scene.

    Those of a model that tells the equations of its elements may be in their coordinates.
    """

    def hold(self, inner: Engine) -> None:
        """Take an engine, and forget what is known of the models of the one before."""
        super().hold(inner)
        self.names = lru_cache(self.names_of_models)

    def names_of_models(self, scene: str) -> tuple[str, ...]:
        """Return the names of models that the engine tells, none of a scene that it refuses."""
        if "models" not in self.functions:
            return (OWN,)
        try:
            return self.ahead("models", lambda: names_of(self.inner.models(scene)))
        except Unsupported:
            return ()

    def models(self, scene: str) -> tuple[str, ...]:
        """Return the names of its models of a scene, default first."""
        return self.names(scene)

    def twins(self, scene: str) -> tuple[str, ...]:
        """Return none: each is driven as the engine likes."""
        return ()

    def coordinates(self, case: Case, model: str) -> tuple[str, ...]:
        """Return the names of the scene's coordinates."""
        return get_scene(case.scene).public

    def has_constraints(self, case: Case, model: str) -> bool:
        """Return whether constraints close loops of the model."""
        return self.about(case, model).constrained

    def model_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Return the equations of motion that the model has, None where they are the scene's."""
        equations = self.about(case, model).equations
        return None if equations is None else ModelEquations(*equations)

    def discrete_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Return the equations of the model's elements, None where it tells none."""
        elements = self.about(case, model).elements
        return None if elements is None else ModelEquations(elements, case.parameters)

    def element_order(self, case: Case, model: str) -> int:
        """Return the order with which the model converges to a continuum, or 0."""
        return self.about(case, model).element_order

    def why_not(self, case: Case, model: str, method: Method | None) -> str | None:
        """Return why this method cannot run this case on this model, or None."""
        about, reason = self.description(case, model)
        if reason is None and "why_not" in self.functions:
            reason = self.own_reason(case, model, method)
        if reason is not None:
            return reason
        soft = about.constrained and about.equations is not None
        if case.inconsistency and not soft:
            return "only a soft closure can close a loop that starts open"
        if about.constrained and self.closure == "soft" and about.equations is None:
            return UNKNOWN_SOFTNESS
        own = about.equations is not None or about.elements is not None
        if get_scene(case.scene).discretisation_coordinates and not own:
            return f"{case.scene} is a continuum: tell the equations of the model, or its elements"
        return None

    def why_not_placed(self, case: Case, model: str) -> str | None:
        """Return why a model cannot be placed in the world otherwise than it stands, or None."""
        return self.about(case, model).why_not_placed

    def scheme(self, case: Case, model: str, method: Method) -> str | None:
        """Return the published scheme that a method is on this model, None if it is none."""
        closed = self.has_constraints(case, model)
        return method.scheme if method.scheme_with_loops or not closed else None

    def start(self, case: Case, model: str) -> Array:
        """Return the initial state of a case, of the elements where their equations are told."""
        discrete = self.discrete_equations(case, model)
        if discrete is not None:
            return discrete.start(case)
        scene = get_scene(case.scene)
        values = scene.completed(case.state)
        return np.array([float(values[name]) for name in scene.public_states])

    def system_of(self, scene: str, model: str, parameters: Any, placement: str = "") -> System:
        """Return what the engine is told of parameters."""
        case = Case(scene, "", parameters, placement=placement)
        discrete = self.discrete_equations(case, model)
        names = get_scene(scene).public if discrete is None else discrete.scene.coordinates
        q, v = np.zeros((2, len(names)))
        return System(case, model, names, q, v, observables=get_scene(scene).observed)

    def system_at(self, case: Case, model: str, state: Array) -> System:
        """Return what the engine is told of a case, from another state (2 n,) on."""
        q, v = np.split(state, 2)
        return replace(self.joint_system(case, model), positions=q, velocities=v)

    def observed(self, system: System, q: Array, v: Array, sensed: Any) -> dict[str, Array]:
        """Return the coordinates (n_t, n) and what the engine tells beside, by name.

        Raises
        ------
        EngineError
            ``returned``, if outputs of the scene are missing that do not follow from them.
        """
        names = (*system.joints, *(f"{name}_dot" for name in system.joints))
        values = dict(zip(names, np.hstack([q, v]).T, strict=True)) | dict(sensed)
        closed = self.has_constraints(system.case, system.model)
        wanted = (*get_scene(system.case.scene).observables, *(VIOLATIONS if closed else ()))
        missing = [name for name in wanted if name not in values]
        if not missing:
            return values
        equations = scene_equations(system.case)
        if set(missing) & set(VIOLATIONS) or system.joints != equations.scene.coordinates:
            raise EngineError("returned", f"Motion.observables must tell {', '.join(missing)}")
        with np.errstate(all="ignore"):  # the guard tells of what is not finite
            observables = equations.scene.observe(np.hstack([q, v]).T, equations.parameters)
        return values | {name: observables[name] for name in missing}

    def accelerations(self, case: Case, model: str, times: Array, states: Array) -> Array:
        """Return accelerations (k, n) at ``times`` (k,) and ``states`` (k, 2 n)."""
        system, q, v = self.joint_states(case, model, times, states)
        return self.joint_accelerations(system, times, q, v)

    def mass_matrices(self, case: Case, model: str, states: Array) -> Array:
        """Return mass matrices (k, n, n) of the coordinates at ``states`` (k, 2 n)."""
        system, n = self.joint_system(case, model), len(states[0]) // 2
        return np.array(
            [
                numbers(
                    "mass_matrix",
                    self.inner.mass_matrix(system, np.array(state[:n])),
                    (n, n),
                    finite=True,
                )
                for state in states
            ]
        )

    def reaction_names(self, case: Case, model: str) -> tuple[str, ...]:
        """Return the outputs of the scene that are forces in joints of the model."""
        return tuple(self.about(case, model).reactions) if "reactions" in self.functions else ()

    def joint_states(
        self, case: Case, model: str, times: Array, states: Array
    ) -> tuple[System, Array, Array]:
        """Return what the engine is told, and positions and velocities (k, n) at states."""
        q, v = np.split(states, 2, axis=1)
        return self.joint_system(case, model), q, v

    def linearise(self, case: Case, model: str, state: Array) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about a state of rest or steady motion.

        In the coordinates that the engine gives them in, which may be fewer than the states'.
        """
        if "linearise" not in self.functions:
            return super().linearise(case, model, state)
        answer = self.inner.linearise(self.system_at(case, model, state))
        mass, damping, stiffness = matrices(answer)
        return mass, damping, stiffness


class Reordered(Engine):
    """Another engine, whose numbers are those of joints in some order.

    Parameters
    ----------
    inner : Engine
    order : tuple of int
        The joint that each number stands for.
    inputs_too : bool
        Whether states are given to it in this order as well.
    """

    def __init__(self, inner: Engine, order: tuple[int, ...], inputs_too: bool) -> None:
        self.inner, self.inputs_too = inner, inputs_too
        self.back = list(np.argsort(order))
        self.order = list(order) if inputs_too else list(range(len(order)))
        for name in ATTRIBUTES:
            setattr(self, name, getattr(inner, name))

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

    def accelerations(self, system: System, time: float, q: Array, v: Array) -> Array:
        """Return accelerations (n,) in order."""
        answer = self.inner.accelerations(self.put(system), time, q[self.order], v[self.order])
        return np.asarray(answer)[self.back]

    def mass_matrix(self, system: System, q: Array) -> Array:
        """Return the mass matrix (n, n) in order."""
        answer = self.inner.mass_matrix(self.put(system), q[self.order])
        return np.asarray(answer)[np.ix_(self.back, self.back)]


def adapt(name: str, offered: Any) -> Adapter:
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


def adapted(inner: Engine) -> Adapter:
    """Return the adapter of an engine: another one if it tells of models of its own."""
    own = not inner.reads_mjcf and bool({"models", "own_model"} & own_functions(inner))
    return (OwnModelsAdapter if own else Adapter)(inner)
