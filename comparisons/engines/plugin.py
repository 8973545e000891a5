"""Engines that are plugged in: what makes an adapter of them, and what their answers must be."""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Mapping
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...models import mjcf
from ...models.kinematics import gap_jacobian, gaps, mass_matrix
from ...models.mechanism import mechanism
from ...models.system import System
from ...reference import get_scene
from ...reference.differences import by_differences
from ...reference.errors import (
    EngineError,
    UnknownNameError,
    Unsupported,
    UsageError,
)
from ...reference.scene import Array, Case
from ...reference.solve.schemes import SCHEMES
from .equations import ModelEquations, scene_equations
from .mjcf import MjcfAdapter
from .protocol import Engine, Method, Motion
from .remote import loading_error
from .run import VIOLATIONS, Trajectory, describe, traceback_of

ORDER = 8
DIFFERENCE = 0.03
"""Order and step of central differences (rad, m and their rates). Truncation is 1e-15 then; what
rounding leaves of accelerations, whose stiffest modes are far faster than those looked at, falls
with the step."""

TURNING = DIFFERENCE / 6
"""The same step where quaternions turn: rotations have poles at the length 0, at the distance 1."""

OWN = "scene"
"""Name of the model of an engine that reads no MJCF."""

PRECISIONS = ("float64", "float32")
CLOSURES = ("rigid", "mjcf", "soft")

LONGEST_NAME = 63
"""Characters of the name of an engine or a method: it stands in ids and in tables."""

NO_FILE = mjcf.Mjcf(path=Path(), bindings={}, controls=lambda parameters: {})
"""Stands for that model: its joints are the coordinates, and a force drives them."""


class PluginAdapter(MjcfAdapter):
    """A plugged-in engine, which works in joints, in the coordinates of the scenes.

    Attributes
    ----------
    inner : Engine
    author : str
        Module and name of the class that its author wrote.
    """

    def __init__(self, inner: Engine, author: str) -> None:
        self.author = author
        self.inner = inner
        self.name, self.version, self.methods = inner.name, inner.version, tuple(inner.methods)
        self.reads_mjcf = bool(inner.reads_mjcf)
        self.precision, self.closure = inner.precision, inner.closure

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
        """Return the named model; one that is not MJCF has the scene's own coordinates."""
        return super().source(case, model) if self.reads_mjcf else NO_FILE

    def model_equations(self, case: Case, model: str) -> ModelEquations | None:
        """Return the model's equations of motion; a loop is as soft as the engine has it."""
        closed = self.has_constraints(case, model) and not self.gives_way(case, model)
        return None if closed else super().model_equations(case, model)

    def gives_way(self, case: Case, model: str) -> bool:
        """Return whether a loop of the model is as soft as the file says."""
        return self.has_constraints(case, model) and self.closure == "mjcf"

    def why_not(self, case: Case, model: str, method: Method | None) -> str | None:
        """Return why this method cannot run this case on this model, or None."""
        if case.inconsistency and not self.gives_way(case, model):
            return "the loop starts open, which only a soft closure can close"
        if self.has_constraints(case, model) and self.closure == "soft":
            return "its loops are soft by a rule of its own: no reference has their equations"
        if not self.reads_mjcf and get_scene(case.scene).discretisation_coordinates:
            return f"{case.scene} is a continuum: only engines that read its MJCF are checked"
        return self.source(case, model).why_not(case.parameters)

    def scheme(self, case: Case, model: str, method: Method) -> str | None:
        """Return the method's published scheme, if it acts on the scene's own coordinates."""
        closed = self.has_constraints(case, model) and not self.gives_way(case, model)
        if get_scene(case.scene).discretisation_coordinates or closed:
            return None
        # rotations are no sums, whatever scheme their rates have
        return None if self.joint_system(case, model).layout.is_spatial else method.scheme

    def joint_system(self, case: Case, model: str) -> System:
        """Return what the engine is told of a case."""
        if self.reads_mjcf:
            return super().joint_system(case, model)
        n = len(get_scene(case.scene).coordinates)
        state = self.start(case, model)
        names = get_scene(case.scene).coordinates
        return System(case, OWN, names, state[:n], state[n:], case.start_time)

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
        motion = self.inner.simulate(system, method, step, times.copy())
        if not isinstance(motion, Motion):
            raise EngineError("returned", f"simulate must return a Motion, not {in_short(motion)}")
        count = (len(times),)
        positions, rates = system.layout.size
        q = numbers("Motion.positions", motion.positions, (*count, positions))
        v = numbers("Motion.velocities", motion.velocities, (*count, rates))
        refuse_lost_length(
            system,
            times,
            q,
            max(UNIT, UNITS * float(np.finfo(method.precision or self.precision).eps)),
        )
        clock = times if motion.clock is None else numbers("Motion.clock", motion.clock, count)
        steps = round((times[-1] - case.start_time) / step)
        if motion.steps is not None:
            steps = int(numbers("Motion.steps", motion.steps, (), finite=True))
        work = motion.rhs_evaluations
        if work is not None:
            work = int(numbers("Motion.rhs_evaluations", work, (), finite=True))
        if not isinstance(motion.warnings, Mapping):
            raise EngineError(
                "returned",
                f"Motion.warnings must be counts by name, not {in_short(motion.warnings)}",
            )
        values = self.observed(case, model, system, q, v)
        lost = np.argwhere(~np.isfinite(np.hstack([q, v])))
        if lost.size and all(np.all(np.isfinite(row)) for row in values.values()):
            time, joint = times[lost[0][0]], joint_of(system, q, v, lost[0])
            raise EngineError("non_finite", f"the joint {joint} is not finite at t = {time:.6g} s")
        return Trajectory(
            times=times,
            values=values,
            clock=clock,
            steps=steps,
            rhs_evaluations=work,
            warnings=dict(motion.warnings),
        )

    def observed(
        self, case: Case, model: str, system: System, q: Array, v: Array
    ) -> dict[str, Array]:
        """Return the scene's observables of joints' motion, and how far loops are open.

        Positions have the shape (n_t, n_q), velocities (n_t, n).
        """
        rows = self.joint_readout(case, model, system).states(q, v)
        closed = self.has_constraints(case, model)
        own = None if closed else self.model_equations(case, model)
        equations = own or scene_equations(case)
        with np.errstate(all="ignore"):  # the guard tells of what is not finite
            observables = equations.scene.observe(rows, equations.parameters)
            names = (*equations.scene.state_names, *get_scene(case.scene).observables)
            values = {name: observables[name] for name in names}
            if closed:  # and so by the engine's joints
                places = zip(system.layout.positions, system.layout.velocities, strict=True)
                for joint, (at, own) in zip(system.joints, places, strict=True):
                    for name, row in ((joint, q[:, at.start]), (f"{joint}_dot", v[:, own.start])):
                        if name in values:
                            values[name] = row
                whole = mechanism(system.mjcf)
                apart = [gaps(whole, row) for row in q]
                rates = [gap_jacobian(whole, a) @ b for a, b in zip(q, v, strict=True)]
                for name, residuals in zip(VIOLATIONS, (apart, rates), strict=True):
                    values[name] = np.linalg.norm(residuals, axis=1)
        return values

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

    def linearise(self, case: Case, model: str, state: Array) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about a state of rest or steady motion.

        The engine's own of a tree at rest, if it tells them; else central differences of its
        accelerations times the mass matrix of the MJCF, which leaves the eigenvalues alone.

        Raises
        ------
        Unsupported
            If a closure gives way, since modes are those of a closed loop.
        """
        if self.gives_way(case, model):
            raise Unsupported("accelerations of a soft closure show no modes of a closed loop")
        n = len(state) // 2
        system = self.joint_system(case, model)
        resting = not np.any(state[n:])
        if resting and not self.has_constraints(case, model):
            try:
                return self.returned_matrices(case, model, state)
            except Unsupported:  # then it follows from accelerations
                pass
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
        shape = system.layout.size[1:] * 2
        mass, damping, stiffness = (
            jacobian @ numbers("linearise", item, shape, finite=True) @ jacobian.T
            for item in self.inner.linearise(system)
        )
        return mass, damping, stiffness

    def own_mass_matrix(self, case: Case, model: str, system: System, state: Array) -> Array:
        """Return the mass matrix (n, n) of the coordinates that the file or the scene has."""
        if not self.reads_mjcf:
            scene = get_scene(case.scene)
            q, c = state[: len(state) // 2], scene.coefficients(case.parameters)
            return np.array(scene.mass_matrix(q, c), dtype=float)
        q, _ = self.joint_motion(case, model, system.joints, case.start_time, state)
        matrix = mass_matrix(mechanism(system.mjcf), q)
        return self.of_coordinates(case, model, system, state, matrix)


# Validation


def numbers(what: str, value: Any, shape: tuple[int, ...], finite: bool = False) -> Array:
    """Return an engine's answer as an array of floats of this shape.

    Raises
    ------
    EngineError
        ``returned``, with what is wrong.
    """
    try:
        if value is None or np.iscomplexobj(value) or np.ma.is_masked(value):
            raise TypeError
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise EngineError(
            "returned", f"{what} must be real numbers, not {in_short(value)}"
        ) from None
    if array.shape != shape:
        hint = "; it is transposed" if array.ndim > 1 and array.shape[::-1] == shape else ""
        raise EngineError("returned", f"{what} has shape {array.shape}, expected {shape}{hint}")
    if finite and not np.all(np.isfinite(array)):
        raise EngineError("non_finite", f"{what} holds {array[~np.isfinite(array)][0]}")
    return array


UNIT, UNITS = 1e-9, 256
"""By how much the length of a quaternion may be off 1: so much, or units of rounding."""


def refuse_lost_length(system: System, times: Array, q: Array, room: float) -> None:
    """Refuse quaternions in positions (n_t, n_q) that are not of length 1.

    Raises
    ------
    EngineError
        ``returned``
    """
    for place in system.layout.quaternions:
        lengths = np.linalg.norm(q[:, place], axis=1)
        off = np.flatnonzero(np.abs(lengths - 1) > room)
        if off.size:
            first = off[0]
            raise EngineError(
                "returned",
                f"a quaternion has the length {lengths[first]:.9g} at t = {times[first]:.6g} s: it "
                "must be normalised as it is integrated (and its order is w, x, y, z)",
            )


def joint_of(system: System, q: Array, v: Array, place: Any) -> str:
    """Return the joint that a column of positions and velocities, side by side, belongs to."""
    column, count = int(place[1]), q.shape[1]
    slices = system.layout.positions if column < count else system.layout.velocities
    column -= count * (column >= count)
    return next(n for n, at in zip(system.joints, slices, strict=True) if column < at.stop)


def in_short(value: Any) -> str:
    """Return an answer in one short line."""
    text = " ".join(repr(value).split())
    return f"{type(value).__name__} {text if len(text) <= 40 else text[:37] + '...'}"


def adapt(name: str, offered: Any) -> PluginAdapter:
    """Return an engine from a class that someone else wrote.

    Parameters
    ----------
    name : str
        How it was asked for, for messages.
    offered : class, or instance
        An `Engine`, or what has its attributes.

    Raises
    ------
    UsageError
        If it does not follow the protocol; says in what.
    EngineUnavailableError
        If the class raises it, for want of a library, or anything else.
    """
    try:
        with redirect_stdout(sys.stderr):  # which may be for a document
            author = offered() if isinstance(offered, type) else offered
    except UsageError:
        raise
    except BaseException as error:  # whatever a foreign class raises
        reason = describe(error, "").replace(":", " on creation:", 1)
        raise loading_error(f"engine {name}: {reason}", traceback_of(error)) from error
    for attribute in ("name", "version", "methods", "simulate"):
        if not hasattr(author, attribute):
            raise UsageError(f"engine {name} has no {attribute}; see docs/engines.md")
    refuse_name(f"engine {name} calls itself", author.name)
    if not (isinstance(author.version, str) and author.version.isprintable() and author.version):
        raise UsageError(f"engine {name}: version must be text, not {in_short(author.version)}")
    methods = author.methods
    if not isinstance(methods, tuple | list) or not methods:
        raise UsageError(f"engine {name}: methods must be a tuple of mbcheck.Method")
    for method in methods:
        refuse_method(name, method)
    names = [method.name for method in methods]
    if len(set(names)) < len(names):
        raise UsageError(f"engine {name}: two methods have the same name: {', '.join(names)}")
    for function, arguments in CALLS.items():
        refuse_signature(name, function, getattr(author, function, None), arguments)
    kind, engine = type(author), as_engine(author)
    words = [("precision", engine.precision, PRECISIONS), ("closure", engine.closure, CLOSURES)]
    words += [("precision", one.precision, PRECISIONS) for one in methods if one.precision]
    for attribute, word, allowed in words:
        if word not in allowed:
            raise UnknownNameError(
                f"{attribute} of engine {name}", str(word)[:LONGEST_NAME], allowed
            )
    return PluginAdapter(engine, f"{kind.__module__}.{kind.__qualname__}")


def as_engine(author: Any) -> Engine:
    """Return an object that follows the protocol as an `Engine`, whatever its class."""
    if isinstance(author, Engine):
        return author
    engine = Engine()
    for name in ("name", "version", "methods", "reads_mjcf", "precision", "closure", *CALLS):
        if hasattr(author, name):
            setattr(engine, name, getattr(author, name))
    return engine


CALLS = {
    "simulate": 4,
    "accelerations": 4,
    "mass_matrix": 2,
    "linearise": 1,
}
"""Functions of the protocol, and how many arguments each is called with."""


def refuse_signature(name: str, function: str, call: Any, arguments: int) -> None:
    """Refuse a function that cannot be called as the protocol calls it.

    Raises
    ------
    UsageError
    """
    if call is None:
        return
    if not callable(call):
        raise UsageError(f"engine {name}: {function} must be a function, not {in_short(call)}")
    try:
        signature = inspect.signature(call)
    except ValueError:  # of compiled code
        return
    try:
        signature.bind(*range(arguments))
    except TypeError as error:
        raise UsageError(
            f"engine {name}: {function}{signature} cannot be called with the {arguments} arguments "
            f"of the protocol ({error}); see docs/engines.md"
        ) from None


def refuse_name(what: str, name: Any) -> None:
    """Refuse a name that cannot stand in ids of results.

    Raises
    ------
    UsageError
    """
    if not (isinstance(name, str) and re.fullmatch(rf"[A-Za-z0-9_.+-]{{1,{LONGEST_NAME}}}", name)):
        raise UsageError(
            f"{what} {repr(name)[:LONGEST_NAME]}; a name has at most {LONGEST_NAME} letters, "
            "digits and _.+- only"
        )


def refuse_method(name: str, method: Any) -> None:
    """Refuse what is no `Method`, or has an impossible order or an unknown scheme.

    Raises
    ------
    UsageError
    """
    if not isinstance(method, Method):
        raise UsageError(f"engine {name}: {in_short(method)} is no mbcheck.Method")
    refuse_name(f"engine {name} calls a method", method.name)
    if not (type(method.order) is int and method.order >= 1):
        raise UsageError(
            f"engine {name}: method {method.name} must have an order of 1 or more, "
            f"not {method.order!r}"
        )
    work = method.evaluations
    if work is not None and not (type(work) is int and work >= 1):
        raise UsageError(
            f"engine {name}: method {method.name} must evaluate forces once a step or more often, "
            f"not {work!r} times"
        )
    if method.scheme is not None and method.scheme not in SCHEMES:
        raise UnknownNameError(f"scheme of {name} {method.name}", method.scheme, SCHEMES)
