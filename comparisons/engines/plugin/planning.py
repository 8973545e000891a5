"""What engines that are plugged in are asked before there is a check, and what they may answer."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ....models.system import System
from ....reference import get_scene
from ....reference.errors import (
    BrokenEngineError,
    EngineError,
    MbcheckError,
    UnknownNameError,
    Unsupported,
)
from ....reference.scene import Case, EquationsOfMotion
from ..equations import ModelEquations, scene_equations
from ..protocol import Method, OwnModel
from ..run import call_engine
from .validation import MAX_NAMES, in_short, refuse_name

if TYPE_CHECKING:
    from .adapter import PluginAdapter

T = TypeVar("T")

UNKNOWN_SOFTNESS = "its loops are soft by a rule of its own: no reference has their equations"

REASONS = 4096
"""Answers on what an engine cannot run that are kept: each kind of check asks of all methods."""


@lru_cache(REASONS)
def own_reason(one: PluginAdapter, case: Case, model: str, method: Method | None) -> str | None:
    """Return why an engine says that it cannot run this case on this model, or None.

    Raises
    ------
    BrokenEngineError
        If it gives no answer.
    """
    try:
        system = one.joint_system(case, model)
    except ArithmeticError:
        return None  # whoever goes on is told, of a run also how many steps it would take
    try:
        return ahead(one, "why_not", lambda: reason_of(one.inner.why_not(system, method)))
    except Unsupported as error:
        return str(error)


def description(one: PluginAdapter, case: Case, model: str) -> tuple[OwnModel, str | None]:
    """Return what an engine tells of a model with the parameters of a case, and why it has none.

    Raises
    ------
    UnknownNameError
        If it has none of this name.
    BrokenEngineError
        If it gives no answer.
    """
    return described(one, case.scene, model, case.parameters, case.placement)


@lru_cache(REASONS)
def described(
    one: PluginAdapter, scene: str, model: str, parameters: Any, placement: str
) -> tuple[OwnModel, str | None]:
    """Return the same, which hangs on nothing else of a case."""
    if model not in one.models(scene):
        raise UnknownNameError(f"{one.name} model of {scene}", model, one.models(scene))
    if "own_model" not in one.functions:
        return OwnModel(), None
    case, outputs = Case(scene, "", parameters, placement=placement), get_scene(scene).units
    names = get_scene(scene).public
    try:
        if one.reads_mjcf:
            system = one.systems(scene, model, parameters, placement)
        else:
            system = System(case, model, names, *np.zeros((2, len(names))))
        about = ahead(one, "own_model", lambda: own_model_of(one.inner.own_model(system), outputs))
        if about.equations is not None:
            refuse_foreign_equations(one, ModelEquations(*about.equations), case)
    except ArithmeticError:
        return OwnModel(), None  # as in `own_reason`
    except Unsupported as error:
        return OwnModel(), str(error)
    return about, None


def refuse_foreign_equations(one: PluginAdapter, equations: ModelEquations, case: Case) -> None:
    """Refuse equations that fail in a state of the scene: those of another one, for instance.

    Raises
    ------
    BrokenEngineError
        Tells the line that raised.
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
            equations.scene.right_hand_side(equations.parameters)(float(first.start_time), state)
            values = equations.scene.observe(state, equations.parameters)
        except ArithmeticError:  # of these parameters, as of a body without mass
            return
        if missing := set(scene.observables).difference(values):
            raise EngineError("returned", f"they do not tell {', '.join(sorted(missing))}")

    ahead(one, f"own_model: its equations for {scene.name}", refuse_missing)


def ahead(one: PluginAdapter, function: str, work: Callable[[], T]) -> T:
    """Return what a function of an engine answers before there is a check to judge it by.

    Raises
    ------
    Unsupported
        If it cannot do what it was asked for.
    BrokenEngineError
        If it gives no answer; tells the line of its code that raised.
    """
    try:
        return call_engine(work)
    except Unsupported:
        raise
    except MbcheckError as error:
        lines = re.findall(r'File "([^"]+)", line (\d+)', error.traceback)
        place = "".join(f" ({Path(file).name}, line {line})" for file, line in lines[-1:])
        reason = f"engine {one.name}: {function}: {error}{place}"
        one.failure = BrokenEngineError(reason, error.traceback)
        raise one.failure from error


def names_of(answer: Any) -> tuple[str, ...]:
    """Return the names of models that an engine tells.

    Raises
    ------
    EngineError
        ``returned``, if they are no names, or too many.
    UsageError
        If they cannot stand in ids of results.
    """
    if not isinstance(answer, tuple | list) or len(answer) > MAX_NAMES:
        raise EngineError(
            "returned",
            f"models must return a tuple of names, {MAX_NAMES} at most, not {in_short(answer)}",
        )
    for model in answer:
        refuse_name("it calls a model", model)
    if len(set(answer)) < len(answer):
        raise EngineError("returned", f"two models have the same name: {', '.join(answer)}")
    return tuple(answer)


def own_model_of(answer: Any, outputs: Collection[str]) -> OwnModel:
    """Return what an engine tells of a model of a scene with these outputs.

    Raises
    ------
    EngineError
        ``returned``, if it has no sense; says in what.
    """
    if not isinstance(answer, OwnModel):
        raise EngineError("returned", f"own_model must return an OwnModel, not {in_short(answer)}")
    equations, order = answer.equations, answer.element_order
    pair = isinstance(equations, tuple) and len(equations) == 2
    whole = equations is None or (
        pair
        and isinstance(equations[0], EquationsOfMotion)
        and isinstance(equations[1], equations[0].parameters)
    )
    elements = answer.elements is None or isinstance(answer.elements, EquationsOfMotion)
    named = isinstance(answer.reactions, tuple | list) and set(answer.reactions) <= set(outputs)
    placed = isinstance(answer.why_not_placed, str | None)
    needs = {
        "constrained": (isinstance(answer.constrained, bool), "True or False"),
        "reactions": (named, f"a tuple of names among {', '.join(outputs)}"),
        "equations": (whole, "None or (EquationsOfMotion, its parameters)"),
        "elements": (elements, "None or an EquationsOfMotion"),
        "element_order": (type(order) is int and order >= 0, "an order of 0 or more"),
        "why_not_placed": (placed, "None or a reason"),
    }
    for field, (right, need) in needs.items():
        if not right:
            value = in_short(vars(answer)[field])
            raise EngineError("returned", f"OwnModel.{field} must be {need}, not {value}")
    return answer


def reason_of(answer: Any) -> str | None:
    """Return why an engine cannot run something, None where it gives no reason.

    Raises
    ------
    EngineError
        ``returned``, if it is no text.
    """
    if not isinstance(answer, str | None):
        raise EngineError(
            "returned", f"why_not must return a reason or None, not {in_short(answer)}"
        )
    return answer or None
