"""JSON documents: written from dataclasses, and described by their annotations and docstrings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from types import GenericAlias, UnionType
from typing import (
    Annotated,
    Any,
    Literal,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

import msgspec
import numpy as np
from msgspec import Meta

from ...reference.errors import MbcheckError
from . import SCHEMA
from .fields import NULLABLE, descriptions

DRAFT = "https://json-schema.org/draft/2020-12/schema"

COMMON: dict[str, str] = {
    "schema": "version of this format",
    "scene": "scene, as in `mbcheck list`",
    "engine": "engine; `reference` is the ODE solution that engines are checked against",
    "method": "integrator, as the engine spells it",
    "model": "the engine's model of the scene",
    "parameters": "all parameters of the scene by name [SI]: numbers, or words where `mbcheck list "
    "SCENE` shows one; settings of models are among them",
    "versions": "versions of mbcheck, numpy, scipy and of the engines that took part, by name",
}
"""Meaning of fields that documents share, unless a docstring defines another."""


def to_document(kind: Any, result: object, parts: Mapping[str, object]) -> dict[str, Any]:
    """Return a result as a document of a type, with some parts given apart.

    Raises
    ------
    MbcheckError
        If a field is missing, or is not what the type says.
    """
    wanted = record(kind, is_root=True)
    written = {
        name: as_plain(parts[name] if name in parts else getattr(result, name))
        for name in wanted.__struct_fields__
        if name in parts or hasattr(result, name)
    }
    return checked(wanted, written)


def checked(kind: Any, content: Any) -> dict[str, Any]:
    """Return a document after a check of its type.

    Raises
    ------
    MbcheckError
        If it is not.
    """
    try:
        return dict(msgspec.to_builtins(msgspec.convert(content, kind)))
    except msgspec.ValidationError as error:
        raise MbcheckError(
            f"a fault of mbcheck: this {kind.__name__} contradicts docs/json.md: {error}"
        ) from None


def as_plain(value: Any) -> Any:
    """Return a value as JSON can hold it: NaN and the infinities are null."""
    if is_dataclass(value) or hasattr(value, "_fields"):
        kind: Any = type(value)
        return {name: as_plain(getattr(value, name)) for name in hints_of(kind)}
    if isinstance(value, Mapping):
        return {str(name): as_plain(item) for name, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return as_plain(value.tolist())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [as_plain(item) for item in value]
    if isinstance(value, complex):
        return {"re": value.real, "im": value.imag}
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value.encode("utf-8", "backslashreplace").decode() if isinstance(value, str) else value


# Types ----------------------------------------------------------------------------------------


class ComplexNumber(msgspec.Struct):
    """A complex number."""

    re: Annotated[float, Meta(description="real part")]
    im: Annotated[float, Meta(description="imaginary part")]


@cache
def hints_of(kind: Any) -> dict[str, Any]:
    """Return the types of the fields and marked properties of a class that documents hold."""
    hints, bases = get_type_hints(kind, include_extras=True), reversed(kind.__mro__)
    if not is_dataclass(kind):
        return hints
    getters = {
        name: getattr(item, "fget", None) for base in bases for name, item in vars(base).items()
    }
    visible = [item for item in fields(kind) if item.metadata.get("is_documented", True)]
    return {
        name: get_type_hints(getter)["return"]
        for name, getter in getters.items()
        if hasattr(getter, "is_documented")
    } | {item.name: hints[item.name] for item in visible}


@cache
def record(kind: Any, is_root: bool = False) -> type[msgspec.Struct]:
    """Return the type of the objects that documents hold of a class.

    What an earlier release of the same schema did not write takes its default as it is read.
    """
    meanings = COMMON | descriptions(kind)
    hints: dict[str, Any] = {"schema": Literal[SCHEMA]} if is_root else {}
    known: dict[str, Any] = {item.name: item for item in fields(kind)} if is_dataclass(kind) else {}
    parts: list[Any] = []
    for name, hint in (hints | hints_of(kind)).items():
        part: tuple[Any, ...] = (name, described(resolved(hint), meanings.get(name, "")))
        item = known.get(name)
        if item is not None and item.default is not MISSING:
            part = (*part, item.default)
        elif item is not None and item.default_factory is not MISSING:
            part = (*part, msgspec.field(default_factory=item.default_factory))
        parts.append(part)
    return msgspec.defstruct(kind.__name__, parts, kw_only=True)


def described(hint: Any, meaning: str) -> Any:
    """Return a type with the meaning of a field of it."""
    return hint if get_origin(hint) is Annotated else Annotated[hint, Meta(description=meaning)]


def resolved(hint: Any) -> Any:
    """Return a type with the records of the classes that it names."""
    origin, args = get_origin(hint), get_args(hint)
    if is_dataclass(hint) or hasattr(hint, "_fields"):
        return record(hint)
    if origin is Annotated:
        known = [item for item in hint.__metadata__ if isinstance(item, Meta)]
        one = resolved(args[0])
        one = Union[one, None] if NULLABLE in hint.__metadata__ else one  # noqa: UP007
        return Annotated[(one, *known)] if known else one
    if origin in (Union, UnionType):
        return Union[tuple(map(resolved, args))]  # noqa: UP007
    if origin is np.ndarray:
        return list[float | None]
    inner = map(resolved, args)
    if origin is tuple and args[-1] is not Ellipsis:
        return GenericAlias(tuple, tuple(inner))
    if origin in (tuple, list, Sequence):
        return GenericAlias(list, next(inner))
    if origin in (dict, Mapping):
        return GenericAlias(dict, tuple(inner))
    return ComplexNumber if hint is complex else hint


# JSON Schema ----------------------------------------------------------------------------------


def schema_of(kind: Any) -> dict[str, Any]:
    """Return the JSON Schema of a type of document, its objects in the order of their use."""
    root = record(kind, is_root=True)
    (reference,), parts = msgspec.json.schema_components([root], ref_template="#/$defs/{name}")
    objects = {}
    for one in records(root):
        properties = parts[one.__name__]["properties"]
        for item in properties.values():
            item.pop("default", None)
        objects[one.__name__] = parts[one.__name__] | {
            "required": list(properties),
            "additionalProperties": False,
        }
    return {"$schema": DRAFT, **reference, "$defs": objects}


def records(hint: Any) -> Iterator[Any]:
    """Yield the types of the objects of a document, each before those that it holds."""
    is_record = isinstance(hint, type) and issubclass(hint, msgspec.Struct)
    if is_record:
        yield hint
    for part in hint.__annotations__.values() if is_record else get_args(hint):
        yield from records(part)
