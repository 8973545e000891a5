"""Requirements on plugged-in engines and on their answers."""

from __future__ import annotations

import inspect
import re
from collections.abc import Collection, Mapping
from contextlib import suppress
from typing import Any, cast

import numpy as np

from ...reference import get_scene
from ...reference.amplification import AMPLIFICATION
from ...reference.equations import invariants_of, scene_equations
from ...reference.errors import EngineError, UnknownNameError, UsageError
from ...reference.scene import Array, Case, EquationsOfMotion
from ...reference.solve.schemes import SCHEMES
from .protocol import Engine, Method, ModelDescription, Motion, Option, System
from .run import VIOLATIONS, Trajectory, grid_indices

PRECISIONS = ("float64", "float32")
CLOSURES = ("rigid", "mjcf", "soft")

LONGEST_NAME, LONGEST_VERSION = 63, 200
"""Most characters of the name of an engine or a method, which is part of ids, and of a version."""

MAX_NAMES = 100
"""Methods of an engine, or models of a scene, above which it is refused: each has its checks."""


def expect(right: bool, need: str, answer: Any) -> None:
    """Refuse an answer that does not meet a need.

    Raises
    ------
    EngineError
        ``returned``
    """
    if not right:
        raise EngineError("returned", f"{need}, not {in_short(answer)}")


def numbers(what: str, value: Any, shape: tuple[int, ...], finite: bool = False) -> Array:
    """Return an engine's answer as an array of floats of this shape.

    Raises
    ------
    EngineError
        ``returned``; names the fault.
    """
    try:
        array = np.asarray(value)
        array = np.asarray(array.tolist()) if array.dtype.kind == "O" else array
        if array.dtype.kind not in "biuf" or np.ma.is_masked(value):
            raise TypeError
        array = np.array(array, dtype=float)
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


def matrices(answer: Any, size: int | None = None) -> Array:
    """Return an engine's answer as M, C, K (3, n, n); without a size n is that of M.

    Raises
    ------
    EngineError
        ``returned``; names the fault.
    """
    try:
        n = len(answer[0]) if size is None else size
    except (TypeError, LookupError):
        n = 0
    return numbers("M, C, K of linearise", answer, (3, n, n), finite=True)


UNIT, UNITS = 1e-9, 256
"""Largest error of the length of a quaternion: absolute, and in units of round-off."""


def refuse_lost_length(system: System, times: Array, positions: Array, precision: str) -> None:
    """Refuse quaternions in positions (n_t, n_q) that are not of length 1.

    Raises
    ------
    EngineError
        ``returned``
    """
    room = max(UNIT, UNITS * float(np.finfo(precision).eps))
    for place in system.layout.quaternions:
        lengths = np.linalg.norm(positions[:, place], axis=1)
        off = np.flatnonzero(np.abs(lengths - 1) > room)
        if off.size:
            raise EngineError(
                "returned",
                f"a quaternion has the length {lengths[off[0]]:.9g} at t = {times[off[0]]:.6g} s: "
                "normalise it as you integrate it; its order is (w, x, y, z), after the place of a "
                "free joint",
            )


def refuse_lost_joints(system: System, times: Array, states: Array) -> None:
    """Refuse states (n_t, n_q + n) that are not finite.

    Raises
    ------
    EngineError
        ``non_finite``, with the first joint.
    """
    lost = np.argwhere(~np.isfinite(states))
    if lost.size:
        slices = zip(
            (*system.layout.positions, *system.layout.velocities), system.joints * 2, strict=True
        )
        joint = [name for at, name in slices for _ in range(at.start, at.stop)][lost[0][1]]
        time = times[lost[0][0]]
        raise EngineError("non_finite", f"the joint {joint} is not finite at t = {time:.6g} s")


def refuse_one_state(system: System, positions: Array, velocities: Array) -> None:
    """Refuse positions (n_t, n_q) and velocities (n_t, n) that are all one, and not the first.

    Raises
    ------
    EngineError
        ``returned``
    """
    same = all(np.all(rows == rows[:1]) for rows in (positions, velocities))
    moved = len(positions) > 1 and not np.allclose(positions[0], system.positions)
    if same and moved and np.any(velocities):
        raise EngineError(
            "returned",
            "all states of the run are the same, and they move: copy each as it comes, if they are "
            "views of a buffer that the next step overwrites",
        )


def motion_of(
    system: System, motion: Any, times: Array, precision: str
) -> tuple[Array, Array, dict[str, Array]]:
    """Return positions (n_t, n_q), velocities (n_t, n) and sensors (n_t,) by name of a run.

    Raises
    ------
    EngineError
        ``returned``, if they have no sense, or what was returned in place of a motion.
    """
    if isinstance(motion, Exception):
        raise motion
    expect(isinstance(motion, Motion), "simulate must return a Motion", motion)
    for name, what in (("warnings", "counts"), ("observables", "values")):
        value = vars(motion)[name]
        expect(isinstance(value, Mapping), f"Motion.{name} must be {what} by name", value)
    shape, (positions, rates) = (len(times),), system.layout.size
    q = numbers("Motion.positions", motion.positions, (*shape, positions))
    v = numbers("Motion.velocities", motion.velocities, (*shape, rates))
    refuse_lost_length(system, times, q, precision)
    if not any(motion.warnings.values()) and np.allclose(clock_of(motion, times), times):
        refuse_one_state(system, q, v)
    return q, v, observables_of(motion, system.case, shape)


def clock_of(motion: Motion, times: Array) -> Array:
    """Return the times of an engine's clock (n_t,) [s]: the requested ones where it has none."""
    return times if motion.clock is None else numbers("Motion.clock", motion.clock, times.shape)


def trajectory_of(
    system: System, motion: Motion, step: float, times: Array, values: Mapping[str, Array]
) -> Trajectory:
    """Return the record of a run with these observables, its counts validated.

    Raises
    ------
    EngineError
        ``returned``
    """
    requested = round((times[-1] - system.start_time) / step)
    counts = {
        name: None
        if (value := vars(motion)[name]) is None
        else int(numbers(f"Motion.{name}", value, (), finite=True))
        for name in ("steps", "rhs_evaluations", "newton_iterations")
    }
    return Trajectory(
        times=times,
        values=values,
        clock=clock_of(motion, times),
        steps=requested if counts["steps"] is None else counts["steps"],
        rhs_evaluations=counts["rhs_evaluations"],
        newton_iterations=counts["newton_iterations"],
        warnings=dict(motion.warnings),
        changed_inputs=tuple(map(str, motion.changed_inputs)),
        seconds=float(numbers("Motion.seconds", motion.seconds, (), finite=True)),
    )


def refuse_step_across_end(system: System, step: float, times: Array) -> None:
    """Refuse a step [s] that leads across the time at which the drive ends.

    Raises
    ------
    UsageError
    """
    end = system.drive_end
    if end is None or not system.start_time < end < times[-1]:
        return
    try:
        grid_indices(np.array([end]), system.start_time, step)
    except UsageError as error:
        raise UsageError(f"the drive ends between two steps: {error}") from None


def options_of(answer: Any) -> tuple[Option, ...]:
    """Return an engine's options.

    Raises
    ------
    EngineError
        ``returned``, if they are none.
    """
    right = isinstance(answer, tuple | list) and all(isinstance(x, Option) for x in answer)
    expect(right, "options must return a tuple of mbcheck.Option", answer)
    return tuple(answer)


INTEGRALS = ("energy", "momentum")
"""Integrals of motion, conserved in some cases of a scene: an engine may return them in all."""


def observables_of(motion: Motion, case: Case, shape: tuple[int, ...]) -> dict[str, Array]:
    """Return the sensors' values in a motion of a case, by name, each of this shape.

    Raises
    ------
    EngineError
        ``returned`` for other names, at which nobody would look, and for other values.
    """
    if not motion.observables:
        return {}
    conserved = (*invariants_of(scene_equations(case)), *INTEGRALS)
    known = (*get_scene(case.scene).observables, *conserved, *VIOLATIONS)
    for name in motion.observables:
        if name not in known:
            raise EngineError(
                "returned",
                f"Motion.observables holds {name!r}; known: {', '.join(dict.fromkeys(known))}",
            )
    return {
        name: numbers(f"Motion.observables[{name!r}]", rows, shape)
        for name, rows in motion.observables.items()
    }


def in_short(value: Any) -> str:
    """Return an answer in one short line."""
    text = " ".join(repr(value).split())
    return f"{type(value).__name__} {text if len(text) <= 40 else text[:37] + '...'}"


def declared(name: str, author: Any) -> Engine:
    """Return an object that follows the protocol as an `Engine`.

    Raises
    ------
    UsageError
        If it does not; says in what.
    """
    if not isinstance(author, Engine):
        raise UsageError(f"engine {name} is no mbcheck.Engine: inherit from it")
    for old, new in RENAMED.items():
        if hasattr(author, old):
            raise UsageError(f"engine {name}: {old} is now {new}: rename it, see CHANGELOG.md")
    for attribute in ("name", "version", "methods"):
        if not hasattr(author, attribute):
            raise UsageError(f"engine {name} has no {attribute}; see docs/engines.md")
    refuse_name(f"engine {name} calls itself", author.name)
    version, methods, table = author.version, author.methods, attributes(author)
    text = isinstance(version, str) and version.isprintable()
    listed = isinstance(methods, tuple | list) and 0 < len(methods) <= MAX_NAMES
    needs: dict[str, tuple[bool, str]] = {
        "version": (
            text and 0 < len(version) <= LONGEST_VERSION,
            f"text of at most {LONGEST_VERSION} characters",
        ),
        "methods": (listed, f"a tuple of mbcheck.Method, of {MAX_NAMES} at most"),
        **{flag: (isinstance(table[flag], bool | np.bool_), "True or False") for flag in FLAGS},
        **{
            one: (isinstance(table[one], int | float) and table[one] >= 0, "a number")
            for one in NUMBERS
        },
    }
    refuse_unfit(f"engine {name}", table, needs)
    for method in methods:
        refuse_method(name, method)
    names = [method.name for method in methods]
    if len(set(names)) < len(names):
        raise UsageError(f"engine {name}: two methods have the same name: {', '.join(names)}")
    for function, arguments in CALLS.items():
        refuse_signature(name, function, getattr(author, function), arguments)
    gives_way = author.closure == "soft" or author.compliant_joints
    if author.reads_mjcf and not gives_way and "describe_model" in own_functions(author):
        raise UsageError(
            f"engine {name}: describe_model needs reads_mjcf = False, compliant_joints = True, or "
            f'closure = "soft"; {RENAME}'
        )
    words = [("precision", author.precision, PRECISIONS), ("closure", author.closure, CLOSURES)]
    words += [
        ("precision", one.precision, PRECISIONS) for one in methods if one.precision is not None
    ]
    for attribute, word, allowed in words:
        if word not in allowed:
            raise UnknownNameError(
                f"{attribute} of engine {name}", str(word)[:LONGEST_NAME], allowed
            )
    return author


def refuse_unfit(
    where: str, values: Mapping[str, Any], needs: Mapping[str, tuple[bool, str]]
) -> None:
    """Refuse the first value that does not meet its need.

    Raises
    ------
    UsageError
    """
    for name, (right, need) in needs.items():
        if not right:
            raise UsageError(f"{where}: {name} must be {need}, not {in_short(values[name])}")


def attributes(author: Engine) -> dict[str, Any]:
    """Return the attributes of the protocol that an engine has."""
    return {name: getattr(author, name) for name in ATTRIBUTES}


def own_functions(author: Engine) -> frozenset[str]:
    """Return the names of the functions of the protocol that an engine defines."""
    return frozenset(
        name
        for name in CALLS
        if name in vars(author) or getattr(type(author), name) is not vars(Engine)[name]
    )


NUMBERS = ("min_inertia", "max_value", "newton_tolerance")
FLAGS = ("reads_mjcf", "needs_only_mjcf", "compliant_joints", "accumulates_clock")
ATTRIBUTES = ("name", "version", "methods", "precision", "closure", *FLAGS, *NUMBERS)
"""Attributes of the protocol, and those of them that are numbers, or true or false."""

CALLS = {
    "simulate": 4,
    "accelerations": 4,
    "mass_matrix": 2,
    "linearise": 1,
    "unsupported_reason": 2,
    "models": 1,
    "describe_model": 1,
    "inverse_dynamics": 5,
    "reactions": 4,
    "options": 2,
    "with_option": 2,
}
"""Functions of the protocol, and how many arguments each is called with."""

RENAMED = {
    "why_not": "unsupported_reason",
    "own_model": "describe_model",
    "reads_all_mjcf": "needs_only_mjcf",
    "least_inertia": "min_inertia",
    "largest_value": "max_value",
}
"""Attributes and functions of an engine, by the names that they had before."""


def functions_by_method(author: Engine) -> frozenset[str]:
    """Return the names of the functions of an engine that take the keyword ``method``."""
    taking = set()
    for name in ("accelerations", "mass_matrix"):
        with suppress(ValueError):  # of compiled code
            if "method" in inspect.signature(getattr(author, name)).parameters:
                taking.add(name)
    return frozenset(taking)


def refuse_signature(name: str, function: str, call: Any, arguments: int) -> None:
    """Refuse a function that cannot be called as the protocol calls it.

    Raises
    ------
    UsageError
    """
    if not callable(call):
        raise UsageError(
            f"engine {name}: {function} must be a function, not {in_short(call)}; {RENAME}"
        )
    try:
        signature = inspect.signature(call)
    except ValueError:  # of compiled code
        return
    try:
        signature.bind(*range(arguments))
    except TypeError as error:
        raise UsageError(
            f"engine {name}: {function}{signature} cannot be called with the {arguments} arguments "
            f"of the protocol ({error}); see docs/engines.md, and {RENAME}"
        ) from None


RENAME = "rename it if it is a helper of yours"


def refuse_name(what: str, name: Any) -> None:
    """Refuse a name that cannot be part of ids of results.

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
    """Refuse an object other than a `Method`, an impossible order or an unknown scheme.

    Raises
    ------
    UsageError
    """
    if not isinstance(method, Method):
        raise UsageError(f"engine {name}: {in_short(method)} is no mbcheck.Method")
    refuse_name(f"engine {name} calls a method", method.name)
    work = method.evaluations_per_step
    needs = {
        "order": (type(method.order) is int and method.order >= 1, "1 or more"),
        "evaluations_per_step": (work is None or (type(work) is int and work >= 1), "1 or more"),
        "scheme_with_loops": (isinstance(method.scheme_with_loops, bool), "True or False"),
    }
    refuse_unfit(f"engine {name}: method {method.name}", vars(method), needs)
    for what, scheme, known in (
        ("scheme", method.scheme, SCHEMES),
        ("linear scheme", method.linear_scheme, AMPLIFICATION),
    ):
        if not (scheme is None or (isinstance(scheme, str) and scheme in known)):
            raise UnknownNameError(
                f"{what} of {name} {method.name}", str(scheme)[:LONGEST_NAME], known
            )


def model_names(answer: Any) -> tuple[str, ...]:
    """Return an engine's names of models.

    Raises
    ------
    EngineError
        ``returned``, if they are no names, or too many.
    UsageError
        If they cannot be part of ids of results.
    """
    few = isinstance(answer, tuple | list) and len(answer) <= MAX_NAMES
    expect(few, f"models must return a tuple of names, {MAX_NAMES} at most", answer)
    for model in answer:
        refuse_name("it calls a model", model)
    if len(set(answer)) < len(answer):
        raise EngineError("returned", f"two models have the same name: {', '.join(answer)}")
    return tuple(answer)


def model_description(answer: Any, outputs: Collection[str]) -> ModelDescription:
    """Return an engine's description of a model of a scene with these outputs.

    Raises
    ------
    EngineError
        ``returned``, if it has no sense; says in what.
    """
    right = isinstance(answer, ModelDescription)
    expect(right, "describe_model must return a ModelDescription", answer)
    equations, order = answer.equations, answer.element_order
    pair = isinstance(equations, tuple) and len(equations) == 2
    whole = equations is None or (
        pair
        and isinstance(equations[0], EquationsOfMotion)
        and isinstance(equations[1], equations[0].parameters)
    )
    elements = answer.elements is None or isinstance(answer.elements, EquationsOfMotion)
    named = isinstance(answer.reactions, tuple | list) and set(answer.reactions) <= set(outputs)
    placed = isinstance(answer.unplaceable_reason, str | None)
    needs = {
        "constrained": (isinstance(answer.constrained, bool), "True or False"),
        "reactions": (named, f"a tuple of names among {', '.join(outputs)}"),
        "equations": (whole, "None or (EquationsOfMotion, its parameters)"),
        "elements": (elements, "None or an EquationsOfMotion"),
        "element_order": (type(order) is int and order >= 0, "an order of 0 or more"),
        "unplaceable_reason": (placed, "None or a reason"),
    }
    for field, (right, need) in needs.items():
        expect(right, f"ModelDescription.{field} must be {need}", vars(answer)[field])
    return cast(ModelDescription, answer)


def reason_of(answer: Any) -> str | None:
    """Return an engine's reason for not running something, None if it gives none.

    Raises
    ------
    EngineError
        ``returned``, if it is no text.
    """
    right = isinstance(answer, str | None)
    expect(right, "unsupported_reason must return a reason or None", answer)
    return answer or None
