"""Parameters into MJCF: the models of a scene's `mjcf` module, and their text.

The committed file is the model; this module only exchanges numbers in its text, so that comments
and formatting stay. No engine is needed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple
from xml.sax.saxutils import quoteattr

from ..reference.scene import EquationsOfMotion
from .tables import table_of

Value = float | str | tuple[float, ...]
Binding = Callable[[Any], Value]
Motion = Mapping[str, tuple[Any, Any]]
"""Position and velocity by joint (SI); arrays where a joint has several numbers, see `joints`."""


def coordinates_alone(parameters: Any, time: float, state: Mapping[str, float]) -> Motion:
    """Return the motion of joints that are the scene's coordinates, and no others."""
    return {
        name: (value, state[f"{name}_dot"])
        for name, value in state.items()
        if f"{name}_dot" in state
    }


class Wave(NamedTuple):
    """A control ``amplitude cos(omega t + phase)`` (N or N m, rad/s, rad)."""

    amplitude: float
    omega: float
    phase: float


@dataclass(frozen=True)
class Elements:
    """Convergence of a model to a scene with a continuum.

    Attributes
    ----------
    order : int
        Order of convergence as its segments are halved; 0: it has none.
    side : callable ``(parameters) -> -1, 0 or 1``
        Whether its first frequency lies below or above that of the continuum; 0: unknown.
    """

    order: int = 0
    side: Callable[[Any], int] = lambda parameters: 0


@dataclass(frozen=True)
class Mjcf:
    """One MJCF model of a scene.

    Attributes
    ----------
    path : Path
        The committed file, bound to the default parameters. Its sensors are called as the
        scene's observables.
    bindings : mapping of (element, attribute) to ``(parameters) -> value``
        An element is ``tag:name``, or, for one without a name, ``tag:name/tag`` below its
        nearest parent with a name (``body:rod/inertial``), or ``tag`` (``option``). A value
        is a number, several numbers, or text.
    joints : callable ``(parameters, time, state) -> {joint: (position, velocity)}``
        The motion of every joint; ``state`` holds coordinates and rates by name. A clock that
        drives the scene is a joint, and so is one that a closed loop makes redundant.
    readout : mapping of coordinate to {joint: factor}
        Coordinates that are no joint, but a sum of joints.
    closed : bool
        Whether a loop of it is closed by a constraint (``equality``).
    reactions : mapping of output to (element, axis)
        Which output of the scene is the component, along an axis of the world (0, 1, 2), of
        the force that ``body:name`` puts on its parent, or ``connect:name`` on the body of
        its first site.
    equations : callable ``(parameters) -> (EquationsOfMotion, parameters)``, or None
        The equations of motion that this model really has, where MuJoCo cannot express the
        scene's: the engine is compared with these. None if they are the scene's.
    unsupported_reason : callable ``(parameters) -> str or None``
        The reason why the model cannot represent the scene with these parameters.
    expand : callable ``(text, parameters) -> text``
        What bindings cannot do: repeats elements of the file, before they are applied.
    stop : callable ``(parameters) -> time or None``
        When all actuators are switched off (`opt.disableactuator`, group 0) [s]: what drives
        the scene may end, and no integrator steps across that without an error.
    prescribed : callable ``(parameters) -> names``
        Coordinates whose motion is given: armatures so heavy that nothing else moves them.
    elements : Elements
    longest_step : float
        Above which MuJoCo itself changes the model [s].
    softened : callable ``(time constant [s]) -> Mjcf``, or None
        The same model with its loop closed more softly, or harder.
    controls : callable ``(parameters) -> {actuator: Wave}``, or None
        Controls of a model that differs from the scene's default one by its drive: a control in
        place of a body.
    """

    path: Path
    bindings: Mapping[tuple[str, str], Binding]
    joints: Callable[[Any, float, Mapping[str, float]], Motion] = coordinates_alone
    readout: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    closed: bool = False
    reactions: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    equations: Callable[[Any], tuple[EquationsOfMotion, Any]] | None = None
    unsupported_reason: Callable[[Any], str | None] = lambda parameters: None
    expand: Callable[[str, Any], str] = lambda text, parameters: text
    stop: Callable[[Any], float | None] = lambda parameters: None
    prescribed: Callable[[Any], tuple[str, ...]] = lambda parameters: ()
    elements: Elements = Elements()
    longest_step: float = math.inf
    softened: Callable[[float], Mjcf] | None = None
    controls: Callable[[Any], Mapping[str, Wave]] | None = None


def models(scene: str) -> Mapping[str, Mjcf]:
    """Return the MJCF models of a scene by name, default first; none if it has none."""
    return table_of(f"{__package__}.{scene}.mjcf", "MODELS", {})


def number(value: float) -> str:
    """Return the shortest text that reads back as this float."""
    return repr(float(value)).removesuffix(".0")


def attribute_text(value: Value) -> str:
    """Return a value as MJCF writes it: numbers separated by blanks."""
    if isinstance(value, str):
        return value
    if isinstance(value, float | int):
        return number(value)
    return " ".join(number(item) for item in value)


TAG = re.compile(
    r"""<!--.*?-->|<(?P<end>/?)(?P<tag>\w+)(?P<rest>(?:[^>"']|"[^"]*"|'[^']*')*)>""", re.DOTALL
)
"""A comment or a tag; a ``>`` may stand inside quotes."""

NAME = re.compile(r"""\sname\s*=\s*["']([^"']*)""")


@lru_cache(maxsize=64)
def start_tags(text: str) -> Mapping[str, list[tuple[int, int]]]:
    """Return the places of the start tags of each element, as (begin, end)."""
    places: dict[str, list[tuple[int, int]]] = {}
    path: list[tuple[str, str | None]] = []
    for match in TAG.finditer(text):
        if match["end"]:
            path.pop()
        elif match["tag"]:
            name = NAME.search(match["rest"])
            path.append((match["tag"], name[1] if name else None))
            places.setdefault(address(path), []).append(match.span())
            if match["rest"].endswith("/"):
                path.pop()
    return places


def address(path: Sequence[tuple[str, str | None]]) -> str:
    """Return the name of an element in `Mjcf.bindings`, from the tags and names above it."""
    tag, name = path[-1]
    if name is not None:
        return f"{tag}:{name}"
    owners = [f"{owner}:{name}/" for owner, name in path[:-1] if name is not None]
    return (owners[-1] if owners else "") + tag


def bind(text: str, values: Mapping[tuple[str, str], Value]) -> str:
    """Return MJCF text with these values of attributes, by element and attribute.

    Raises
    ------
    KeyError
        If the text does not have exactly one such element, or it lacks the attribute.
    """
    places, edits = start_tags(text), []
    for (element, attribute), value in values.items():
        matches = places.get(element, [])
        if len(matches) != 1:
            raise KeyError(f"{len(matches)} elements {element!r} in the MJCF, expected one")
        begin, end = matches[0]
        pattern = rf"""\s{attribute}\s*=\s*("[^"]*"|'[^']*')"""
        match = re.compile(pattern).search(text, begin, end)
        if match is None:
            raise KeyError(f"{element!r} has no attribute {attribute!r} in the MJCF")
        edits.append((match.span(1), quoteattr(attribute_text(value))))
    for (begin, end), replacement in sorted(edits, reverse=True):
        text = text[:begin] + replacement + text[end:]
    return text


def export(model: Mjcf, parameters: Any) -> str:
    """Return the model's committed MJCF with these parameters."""
    text = model.expand(model.path.read_text(encoding="utf-8"), parameters)
    return bind(text, {key: value(parameters) for key, value in model.bindings.items()})
