"""Common parts of queries: a scene at a user's parameters, and an engine that computes it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...models import mjcf
from ...reference import get_scene
from ...reference.errors import (
    ParameterError,
    UnknownNameError,
    UsageError,
)
from ...reference.parameters import Parameters, as_number
from ...reference.scene import Case, EquationsOfMotion, Scene
from ..engines.adapter import Adapter
from ..engines.protocol import Method
from ..engines.registry import get_engine
from ..engines.setup import Setup, run
from .environment import versions

TRIAL = 1000
"""Steps of the trial run that measures the computing time of a step."""

CONSISTENT = 1e-9
"""Largest distance of a given initial value from the one that follows from the others (SI)."""


def user_case(
    scene: str, changes: Mapping[str, Any] | None, state: Mapping[str, Any] | None = None
) -> Case:
    """Return the case of a user's parameters and initial values, otherwise 0.

    Raises
    ------
    UsageError
        For unknown names or impossible values.
    """
    known = get_scene(scene)
    parameters = changed(known.parameters(), changes)
    return Case(scene, "user", parameters, initial_values(known, parameters, state or {}))


def changed(parameters: Parameters, changes: Mapping[str, Any] | None) -> Parameters:
    """Return parameters with some of them changed.

    Raises
    ------
    UsageError
        For unknown names or impossible values.
    """
    words = parameters.choices()
    return parameters.replace(
        **{
            name: value if name in words else as_float(name, value)
            for name, value in (changes or {}).items()
        }
    )


def initial_values(
    scene: Scene, parameters: Parameters, values: Mapping[str, Any]
) -> dict[str, float]:
    """Return the initial values of the states; outputs must agree with them.

    Raises
    ------
    ParameterError
        If a given value contradicts the others, or is a state that the parameters fix.
    UnknownNameError
        If a state is the reference's own.
    """
    values = {name: as_float(name, value) for name, value in values.items()}
    fixed = scene.constrained_initial_values(parameters)
    taken = scene.initial_states
    states = {n: value for n, value in values.items() if n in taken or n not in scene.observed}
    for name in states:
        if name not in taken:
            known = (*taken, *(name for name in scene.observed if name not in taken))
            raise UnknownNameError(f"state of {scene.name}", name, known)
    observed = scene.observe(scene.state(states | fixed), parameters)
    for name in values:
        expected = float(observed[name])
        if not abs(values[name] - expected) <= CONSISTENT * max(1.0, abs(expected)):
            raise ParameterError(
                f"initial {name} = {values[name]:.9g} {scene.units[name]} contradicts the other "
                f"values, from which {name} = {expected:.9g} follows; leave it out"
            )
    return states | fixed


def as_float(name: str, value: Any) -> float:
    """Return a value as a float.

    Raises
    ------
    ParameterError
        If it is not one number.
    """
    try:
        return as_number(value)
    except (TypeError, ValueError, OverflowError):
        raise ParameterError(f"{name} must be a number, not {value!r}") from None


def valid_step(step: Any) -> float:
    """Return a step [s].

    Raises
    ------
    ParameterError
        If it is not a positive number.
    """
    value = as_float("step", step)
    if not (math.isfinite(value) and value > 0):
        raise ParameterError(f"step must be finite and greater than 0, not {step!r}")
    return value


def choose_engine(name: str, case: Case, model: str | None) -> tuple[Adapter, str]:
    """Return an engine and the name of one of its models of a case's scene.

    Raises
    ------
    UsageError
        For unknown names, an engine that cannot be imported or has no model of the scene.
    """
    engine = get_engine(name)
    what = f"{name} model of {case.scene}"
    return engine, known_name(what, model, engine.models(case.scene))


def known_name(kind: str, name: str | None, known: tuple[str, ...]) -> str:
    """Return a name, or the first of those known.

    Raises
    ------
    UsageError
        If it is not known, or none is.
    """
    if not known:
        raise UsageError(f"there is no {kind}")
    if name is not None and name not in known:
        raise UnknownNameError(kind, name, known)
    return known[0] if name is None else name


def mjcf_text(
    scene: str, parameters: Mapping[str, Any] | None = None, model: str | None = None
) -> str:
    """Return the MJCF of a scene with these parameters.

    Raises
    ------
    UsageError
        For unknown names, impossible values, a scene without MJCF, or a model unsuitable for
        these parameters.
    """
    case, models = user_case(scene, parameters), mjcf.models(scene)
    name = known_name(f"MJCF model of {scene}", model, tuple(models))
    if reason := models[name].unsupported_reason(case.parameters):
        raise UsageError(f"model {name} of {scene} is not for these parameters: {reason}")
    return mjcf.export(models[name], case.parameters)


def choose_method(engine: Adapter, case: Case, model: str, name: str | None) -> Method:
    """Return a method by name, or the one of highest order that can run the case.

    Raises
    ------
    UsageError
        If it is unknown, or cannot run the case.
    """
    by_name = {method.name: method for method in engine.methods}
    if name is not None:
        if name not in by_name:
            raise UnknownNameError(f"method of {engine.name}", name, by_name)
        reason = engine.bind(case, model).unsupported_reason(case, by_name[name])
        if reason is not None:
            raise UsageError(f"{engine.name} {name} cannot run this: {reason}")
        return by_name[name]
    for method in sorted(engine.methods, key=lambda item: -item.order):
        if engine.bind(case, model).unsupported_reason(case, method) is None:
            return method
    raise UsageError(f"no method of {engine.name} can run {model} of {case.scene}")


@dataclass(frozen=True)
class Origin:
    """Scene, engine, model, parameters and versions of a result."""

    scene: str
    engine: str
    model: str
    parameters: Mapping[str, float | str]
    versions: Mapping[str, str]


def seconds_of_a_step(setup: Setup) -> float:
    """Return the computing time of a step of an engine [s], from a short trial run."""
    trial = run(setup, setup.case.start_time + np.array([TRIAL * setup.step_size]))
    return trial.seconds / TRIAL


def described(setup: Setup) -> dict[str, Any]:
    """Return the fields that the results of all queries have."""
    return {
        "scene": setup.case.scene,
        "engine": setup.engine.name,
        "model": setup.model,
        "parameters": setup.case.parameters.as_dict(),
        "versions": versions([setup.engine.name]),
    }


def by_state(scene: EquationsOfMotion, rows: Iterable[Any]) -> dict[str, Any]:
    """Return rows by the name of the state that each belongs to."""
    return dict(zip(scene.state_names, rows, strict=True))


def floats(values: Mapping[str, Any]) -> dict[str, float]:
    """Return plain floats by name."""
    return {name: float(value) for name, value in values.items()}
