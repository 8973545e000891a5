"""JSON documents: types of their fields, from which documents are written and described."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, get_args, is_typeddict

import msgspec
import numpy as np
from msgspec import Meta

from ...reference.errors import MbcheckError

DRAFT = "https://json-schema.org/draft/2020-12/schema"


def limits(**keywords: Any) -> Meta:
    """Return what limits a value, in the words of JSON Schema; readers are told, not asked."""
    return Meta(extra_json_schema=keywords)


def means(text: str, **keywords: Any) -> Meta:
    """Return what a field means, its unit in brackets, and what limits its value."""
    return Meta(description=text, extra_json_schema=keywords)


NotNegative = Annotated[float, limits(minimum=0)]
Positive = Annotated[float, limits(exclusiveMinimum=0)]
Count = Annotated[int, limits(minimum=0)]
Ordinal = Annotated[int, limits(minimum=1)]
Name = Annotated[str, limits(minLength=1)]
Pair = Annotated[list[float], limits(minItems=2, maxItems=2)]
Vector = Annotated[list[float], limits(minItems=3, maxItems=3)]

Version = Annotated[Literal[1], means("version of this format")]
Scene = Annotated[Name, means("scene, as in `mbcheck list`")]
Engine = Annotated[
    Name, means("engine; `reference` is the ODE solution that engines are checked against")
]
Method = Annotated[Name, means("integrator, as the engine spells it")]
Model = Annotated[Name, means("the engine's model of the scene")]
Step = Annotated[Positive | None, means("fixed step [s]; null for the reference")]
Parameters = Annotated[
    dict[str, float | str],
    means(
        "all parameters of the scene by name [SI]: numbers, or words where `mbcheck list SCENE` "
        "shows one; settings of models are among them"
    ),
]
Versions = Annotated[
    dict[str, str],
    means("versions of mbcheck, numpy, scipy and of the engines that took part, by name"),
]


def to_document(kind: Any, values: Mapping[str, object]) -> dict[str, Any]:
    """Return values as a document of a type.

    Raises
    ------
    MbcheckError
        If a field is missing, or is not what the type says.
    """
    fields = {name: value for name, value in values.items() if name in kind.__annotations__}
    builtins = msgspec.to_builtins(fields, enc_hook=builtin, str_keys=True)
    try:
        return dict(msgspec.convert(plain(builtins), kind))
    except msgspec.ValidationError as error:
        raise MbcheckError(
            f"a fault of mbcheck: this {kind.__name__} is not what docs/json.md says: {error}"
        ) from None


def plain(value: Any) -> Any:
    """Return a value as JSON can hold it: NaN and the infinities are null."""
    if isinstance(value, dict):
        return {name: plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, str):
        return value.encode("utf-8", "backslashreplace").decode("utf-8")
    return None if isinstance(value, float) and not math.isfinite(value) else value


def builtin(value: Any) -> Any:
    """Return a value of another library as one of Python's own; what only runs is None."""
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if callable(value):
        return None
    raise NotImplementedError(f"{type(value).__name__} in a document")


def schema_of(kind: Any) -> dict[str, Any]:
    """Return the JSON Schema of a type of document, its objects in the order of their use."""
    (root,), parts = msgspec.json.schema_components([kind], ref_template="#/$defs/{name}")
    objects = {}
    for record in records(kind):
        part = parts[record.__name__]
        properties = {key: part["properties"][key] for key in record.__annotations__}
        objects[record.__name__] = {
            **part,
            "properties": properties,
            "additionalProperties": False,
        }
    return {"$schema": DRAFT, **root, "$defs": objects}


def records(hint: Any) -> Iterator[Any]:
    """Yield the types of the objects of a document, each before those that it holds."""
    if is_typeddict(hint):
        yield hint
    inner = hint.__annotations__.values() if is_typeddict(hint) else get_args(hint)
    for part in inner:
        yield from records(part)
