"""Engines that others plug in: the small protocol they follow, and what makes it an `Engine`.

docs/engines.md is the page for their authors.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ...models import mjcf
from ...models.kinematics import gap_jacobian, gaps, mass_matrix
from ...models.mechanism import mechanism
from ...models.system import System
from ...reference import get_scene
from ...reference.errors import (
    EngineError,
    EngineUnavailableError,
    UnknownNameError,
    Unsupported,
    UsageError,
)
from ...reference.scene import Array, Case, Scene
from ...reference.solve.schemes import SCHEMES
from .mjcf_models import MjcfModels
from .protocol import VIOLATIONS, Method, Trajectory

__all__ = ["EngineUnavailableError", "Motion", "Plugged", "PluginEngine", "System", "Unsupported"]

STENCIL = tuple(
    (sign * place, sign * weight)
    for place, weight in ((1, 4 / 5), (2, -1 / 5), (3, 4 / 105), (4, -1 / 280))
    for sign in (-1, 1)
)
"""Central difference of order 8: (place, weight)."""

DIFFERENCE = 0.03
"""Step of that difference (rad, m and their rates). Truncation is 1e-15 then; what rounding
leaves of accelerations, whose stiffest modes are far faster than those looked at, falls with it."""

OWN = "scene"
"""Name of the model of an engine that reads no MJCF."""

NO_FILE = mjcf.Mjcf(path=Path(), bindings={})
"""Stands for that model: its joints are the coordinates."""


@dataclass(frozen=True)
class Motion:
    """What a plugged-in engine returns of a run.

    Attributes
    ----------
    positions, velocities : array (n_t, n)
        Of the joints, in the order of `System.joints`, at the times that were asked for.
    clock : array (n_t,), optional
        The engine's own clock at these times [s]. Without it a reset in silence goes unnoticed.
    steps : int, optional
        Steps that the engine counted itself.
    warnings : mapping of str to int
        Warning counters; any that is not zero fails the run.
    rhs_evaluations : int, optional
        How often forces were evaluated.
    """

    positions: Any
    velocities: Any
    clock: Any = None
    steps: int | None = None
    warnings: Mapping[str, int] = field(default_factory=dict)
    rhs_evaluations: int | None = None


class PluginEngine(Protocol):
    """What an author writes. Everything but `simulate` and the three attributes is optional.

    Optional: ``reads_mjcf = False`` for an engine that models the scenes itself and takes their
    own coordinates for joints; ``accelerations(system, time, positions (n,), velocities (n,))``
    returns accelerations (n,); ``mass_matrix(system, positions (n,))`` returns (n, n);
    ``linearise(system)`` returns M, C, K, each (n, n), about the system's initial state of rest.
    Each may raise `Unsupported` with a reason: the check is skipped.
    """

    name: str
    version: str
    methods: tuple[Method, ...]

    def simulate(self, system: System, method: Method, step: float, times: Array) -> Motion:
        """Integrate from ``system.start_time`` with a fixed step; ``times`` lie on its grid."""
        ...


class Plugged(MjcfModels):
    """A plugged-in engine as an `Engine`.

    Attributes
    ----------
    inner : PluginEngine
    reads_mjcf : bool
    """

    def __init__(self, inner: PluginEngine) -> None:
        self.inner = inner
        self.name, self.version, self.methods = inner.name, inner.version, tuple(inner.methods)
        self.reads_mjcf = bool(getattr(inner, "reads_mjcf", True))
        self.integrates_drive = self.reads_mjcf

    # What it models

    def models(self, scene: str) -> tuple[str, ...]:
        """Return the names of its models of a scene: those in MJCF, each closure once."""
        if not self.reads_mjcf:
            return (OWN,)
        table = mjcf.models(scene)
        return tuple(name for name, one in table.items() if one.softened is None)

    def source(self, case: Case, model: str) -> mjcf.Mjcf:
        """Return the named model; one that is not MJCF has the scene's own coordinates."""
        return super().source(case, model) if self.reads_mjcf else NO_FILE

    def claim(self, case: Case, model: str) -> tuple[Scene, Any] | None:
        """Return the model's equations of motion; a loop counts as closed without softness."""
        return None if self.constrained(case, model) else super().claim(case, model)

    def why_not(self, case: Case, model: str, method: Method | None) -> str | None:
        """Return why this method cannot run this case on this model, or None."""
        if case.inconsistency:
            return "the loop starts open, which only a soft closure can close"
        if not self.reads_mjcf and get_scene(case.scene).internal:
            return f"{case.scene} is a continuum: only engines that read its MJCF are checked"
        return self.source(case, model).why_not(case.parameters)

    def scheme(self, case: Case, model: str, method: Method) -> str | None:
        """Return the method's published scheme, if it acts on the scene's own coordinates."""
        if get_scene(case.scene).internal or self.constrained(case, model):
            return None
        return method.scheme

    def system(self, case: Case, model: str) -> System:
        """Return what the engine is told of a case."""
        if self.reads_mjcf:
            return super().system(case, model)
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
        system = self.system(case, model)
        motion = self.inner.simulate(system, method, step, times.copy())
        if not isinstance(motion, Motion):
            raise EngineError("returned", f"simulate must return a Motion, not {told(motion)}")
        shape = (len(times), len(system.joints))
        q = numbers("Motion.positions", motion.positions, shape)
        v = numbers("Motion.velocities", motion.velocities, shape)
        clock = times if motion.clock is None else numbers("Motion.clock", motion.clock, shape[:1])
        steps = round((times[-1] - case.start_time) / step)
        if motion.steps is not None:
            steps = int(numbers("Motion.steps", motion.steps, (), finite=True))
        if not isinstance(motion.warnings, Mapping):
            raise EngineError(
                "returned", f"Motion.warnings must be counts by name, not {told(motion.warnings)}"
            )
        values = self.observed(case, model, system, q, v)
        lost = np.argwhere(~np.isfinite(q) | ~np.isfinite(v))
        if lost.size and all(np.all(np.isfinite(row)) for row in values.values()):
            time, joint = times[lost[0][0]], system.joints[lost[0][1]]
            raise EngineError("non_finite", f"the joint {joint} is not finite at t = {time:.6g} s")
        return Trajectory(
            times=times,
            values=values,
            clock=clock,
            steps=steps,
            rhs_evaluations=motion.rhs_evaluations,
            warnings=dict(motion.warnings),
        )

    def observed(
        self, case: Case, model: str, system: System, q: Array, v: Array
    ) -> dict[str, Array]:
        """Return the scene's observables of joints' motion (n_t, n), and how far loops are open."""
        places = {name: i for i, name in enumerate(system.joints)}
        rows = []
        for moving in (q, v):
            for sums in self.readout(case, model).values():
                rows.append(np.sum([f * moving[:, places[j]] for j, f in sums.items()], axis=0))
        own = self.claim(case, model) or (get_scene(case.scene), case.parameters)
        with np.errstate(all="ignore"):  # the guard tells of what is not finite
            shown = own[0].observe(np.array(rows), own[1])
            wanted = (*own[0].state_names, *get_scene(case.scene).observables)
            values = {name: shown[name] for name in wanted}
            if self.constrained(case, model):
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
        tell = self.function("accelerations")
        rows = zip(times, positions, velocities, strict=True)
        shape = (len(system.joints),)
        found = [tell(system, float(t), q.copy(), v.copy()) for t, q, v in rows]
        return np.array([numbers("accelerations", a, shape, finite=True) for a in found])

    def joint_mass_matrices(self, system: System, positions: Array) -> Array:
        """Return mass matrices (k, n, n) of the joints at positions (k, n).

        Raises
        ------
        Unsupported
            If the engine has no `mass_matrix`.
        EngineError
            ``returned``
        """
        tell = self.function("mass_matrix")
        shape = (len(system.joints),) * 2
        found = [tell(system, q.copy()) for q in positions]
        return np.array([numbers("mass_matrix", m, shape, finite=True) for m in found])

    def accelerations(self, case: Case, model: str, times: Array, states: Array) -> Array:
        """Return accelerations (k, n) at ``times`` (k,) and ``states`` (k, 2 n)."""
        system, q, v = self.joint_states(case, model, times, states)
        return self.joint_accelerations(system, times, q, v) @ self.factors(case, model, system).T

    def mass_matrices(self, case: Case, model: str, states: Array) -> Array:
        """Return mass matrices (k, n, n) of the coordinates at ``states`` (k, 2 n).

        Joints that depend on the coordinates take part; a clock does not. Those whose motion
        is prescribed have the row and the column of the identity.
        """
        system, q, _ = self.joint_states(case, model, np.full(len(states), case.start_time), states)
        found = []
        for matrix, state in zip(self.joint_mass_matrices(system, q), states, strict=True):
            jacobian = self.jacobian(case, model, system.joints, state)
            found.append(self.held(case, model, jacobian @ matrix @ jacobian.T))
        return np.array(found)

    def linearise(self, case: Case, model: str, state: Array) -> tuple[Array, Array, Array]:
        """Return M, C, K, each (n, n), about a state of rest or steady motion.

        The engine's own of a tree at rest, if it tells them; else central differences of its
        accelerations times the mass matrix of the MJCF, which leaves the eigenvalues alone.
        """
        n = len(state) // 2
        system = self.system(case, model)
        resting = not np.any(state[n:])
        if resting and hasattr(self.inner, "linearise") and not self.constrained(case, model):
            jacobian = self.jacobian(case, model, system.joints, state)
            names = self.coordinates(case, model)
            keys = (*names, *(f"{name}_dot" for name in names))
            there = replace(case, state=dict(zip(keys, map(float, state), strict=True)))
            shape = (len(system.joints),) * 2
            answer = self.inner.linearise(self.system(there, model))
            matrices = [numbers("linearise", item, shape, finite=True) for item in answer]
            mass, damping, stiffness = (jacobian @ item @ jacobian.T for item in matrices)
            return mass, damping, stiffness
        places, weights = np.array(STENCIL).T
        moved = state + DIFFERENCE * np.kron(np.eye(2 * n), places[:, None])
        times = np.full(len(moved), case.start_time)
        accelerations = self.accelerations(case, model, times, moved)
        mass, *elsewhere = (
            self.own_mass_matrix(case, model, system, one)
            for one in (state, *moved[: len(moved) // 2])
        )
        masses = elsewhere + [mass] * len(elsewhere)  # the second half moves rates alone
        forces = np.einsum("kij,kj->ki", masses, accelerations)
        slopes = np.einsum("csi,s->ic", forces.reshape(2 * n, -1, n), weights / DIFFERENCE)
        slopes[self.prescribed(case, model)] = 0
        return mass, -slopes[:, n:], -slopes[:, :n]

    def own_mass_matrix(self, case: Case, model: str, system: System, state: Array) -> Array:
        """Return the mass matrix (n, n) of the coordinates that the file or the scene has."""
        if not self.reads_mjcf:
            scene = get_scene(case.scene)
            q, c = state[: len(state) // 2], scene.coefficients(case.parameters)
            return np.array(scene.mass_matrix(q, c), dtype=float)
        q, _ = self.joint_motion(case, model, system.joints, case.start_time, state)
        jacobian = self.jacobian(case, model, system.joints, state)
        matrix = mass_matrix(mechanism(system.mjcf), q)
        return self.held(case, model, jacobian @ matrix @ jacobian.T)

    def factors(self, case: Case, model: str, system: System) -> Array:
        """Return the coordinates as sums of joints (n, n_joints)."""
        sums = self.readout(case, model).values()
        return np.array([[one.get(name, 0.0) for name in system.joints] for one in sums])

    def function(self, name: str) -> Any:
        """Return an optional function of the engine.

        Raises
        ------
        Unsupported
            If it has none of this name.
        """
        found = getattr(self.inner, name, None)
        if found is None:
            raise Unsupported(f"{self.name} has no {name}(...)")
        return found


# Validation


def numbers(what: str, given: Any, shape: tuple[int, ...], finite: bool = False) -> Array:
    """Return an engine's answer as an array of floats of this shape.

    Raises
    ------
    EngineError
        ``returned``, with what is wrong.
    """
    try:
        if given is None or np.iscomplexobj(given) or np.ma.is_masked(given):
            raise TypeError
        array = np.array(given, dtype=float)
    except (TypeError, ValueError):
        raise EngineError("returned", f"{what} must be real numbers, not {told(given)}") from None
    if array.shape != shape:
        hint = "; it is transposed" if array.ndim > 1 and array.shape[::-1] == shape else ""
        raise EngineError("returned", f"{what} has shape {array.shape}, expected {shape}{hint}")
    if finite and not np.all(np.isfinite(array)):
        raise EngineError("non_finite", f"{what} holds {array[~np.isfinite(array)][0]}")
    return array


def told(given: Any) -> str:
    """Return an answer in one short line."""
    text = " ".join(repr(given).split())
    return f"{type(given).__name__} {text if len(text) <= 40 else text[:37] + '...'}"


def plugged(name: str, found: Any) -> Plugged:
    """Return an engine from a class that someone else wrote.

    Parameters
    ----------
    name : str
        How it was asked for, for messages.
    found : class, or instance
        Following `PluginEngine`.

    Raises
    ------
    UsageError
        If it does not follow the protocol; says in what.
    EngineUnavailableError
        If the class raises it, for want of a library.
    """
    try:
        with redirect_stdout(sys.stderr):  # which may be for a document
            inner = found() if isinstance(found, type) else found
    except UsageError:
        raise
    except (Exception, SystemExit) as error:
        raise UsageError(f"engine {name}: {type(error).__name__} on creation: {error}") from error
    for attribute in ("name", "version", "methods", "simulate"):
        if not hasattr(inner, attribute):
            raise UsageError(f"engine {name} has no {attribute}; see docs/engines.md")
    refuse_name(f"engine {name} calls itself", inner.name)
    if not (isinstance(inner.version, str) and inner.version.isprintable() and inner.version):
        raise UsageError(f"engine {name}: version must be text, not {told(inner.version)}")
    methods = inner.methods
    if not isinstance(methods, tuple | list) or not methods:
        raise UsageError(f"engine {name}: methods must be a tuple of mbcheck.Method")
    for method in methods:
        refuse_method(name, method)
    names = [method.name for method in methods]
    if len(set(names)) < len(names):
        raise UsageError(f"engine {name}: two methods have the same name: {', '.join(names)}")
    for function, arguments in CALLS.items():
        refuse_signature(name, function, getattr(inner, function, None), arguments)
    return Plugged(inner)


CALLS = {
    "simulate": 4,
    "accelerations": 4,
    "mass_matrix": 2,
    "linearise": 1,
}
"""Functions of the protocol, and how many arguments each is called with."""


def refuse_signature(name: str, function: str, found: Any, arguments: int) -> None:
    """Refuse a function that cannot be called as the protocol calls it.

    Raises
    ------
    UsageError
    """
    if found is None:
        return
    if not callable(found):
        raise UsageError(f"engine {name}: {function} must be a function, not {told(found)}")
    try:
        signature = inspect.signature(found)
    except ValueError:  # of compiled code
        return
    try:
        signature.bind(*range(arguments))
    except TypeError as error:
        raise UsageError(
            f"engine {name}: {function}{signature} cannot be called with the {arguments} arguments "
            f"of the protocol ({error}); see docs/engines.md"
        ) from None


def refuse_name(what: str, given: Any) -> None:
    """Refuse a name that cannot stand in ids of results.

    Raises
    ------
    UsageError
    """
    if not (isinstance(given, str) and re.fullmatch(r"[A-Za-z0-9_.+-]+", given)):
        raise UsageError(f"{what} {given!r}; a name has letters, digits and _.+- only")


def refuse_method(name: str, method: Any) -> None:
    """Refuse what is no `Method`, or has an impossible order or an unknown scheme.

    Raises
    ------
    UsageError
    """
    if not isinstance(method, Method):
        raise UsageError(f"engine {name}: {told(method)} is no mbcheck.Method")
    refuse_name(f"engine {name} calls a method", method.name)
    if not (type(method.order) is int and method.order >= 1):
        raise UsageError(
            f"engine {name}: method {method.name} must have an order of 1 or more, "
            f"not {method.order!r}"
        )
    if method.scheme is not None and method.scheme not in SCHEMES:
        raise UnknownNameError(f"scheme of {name} {method.name}", method.scheme, SCHEMES)
