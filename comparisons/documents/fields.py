"""Fields of requests and results: their meanings, options and places in documents.

The meaning of a field is in the docstring of its class, under ``Attributes``, for help texts and
the tables of docs/json.md.
"""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache, wraps
from types import NoneType, UnionType
from typing import (
    Annotated,
    Any,
    NamedTuple,
    ParamSpec,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

from ...reference.errors import UsageError

P = ParamSpec("P")
Request = TypeVar("Request")
Outcome = TypeVar("Outcome")
Getter = TypeVar("Getter", bound=Callable[..., Any])

NULLABLE = "null where it is not finite"

Number = Annotated[float, NULLABLE]
"""A number that documents hold as null where it is not finite."""

HIDDEN = {"is_documented": False}
"""Metadata of a field that documents do not hold."""

ENTRY = re.compile(r"^(\w+(?:, \w+)*)(?: : .*)?$")
"""First line of an entry under ``Attributes``."""


@dataclass(frozen=True)
class OptionMark:
    """How the command line takes a field; its type and default are those of the field.

    Attributes
    ----------
    metavar : str
        Stands for the value in help texts.
    flags : tuple of str
        By default ``--name``, without the plural of what may be repeated; none of an argument.
    parse : callable (text, flag), optional
        Returns the value, or refuses the text by a `UsageError`.
    least : int
        Smallest value of a whole number.
    default
        Of the command line, where it is not that of the field.
    """

    metavar: str = ""
    flags: tuple[str, ...] | None = None
    parse: Callable[[str, str], Any] | None = None
    least: int = -(10**18)
    default: Any = None


class OptionField(NamedTuple):
    """A field of a request that the command line takes.

    Attributes
    ----------
    name : str
    word : str
        Its name on the command line, without the plural of what may be repeated.
    kind : type
        Without None and metadata: of sequences and mappings the origin.
    is_repeatable : bool
        Whether it holds several values: a mapping, a tuple, and a sequence unless its text is
        parsed as a whole.
    mark : OptionMark
    default
        `dataclasses.MISSING` makes it required.
    help : str
        Its meaning, in a sentence.
    """

    name: str
    word: str
    kind: Any
    is_repeatable: bool
    mark: OptionMark
    default: Any
    help: str


def option_fields(request: type) -> Iterator[OptionField]:
    """Yield the fields of a request that have an `OptionMark`."""
    hints, meanings = get_type_hints(request, include_extras=True), descriptions(request)
    for item in fields(request):
        marks = getattr(hints[item.name], "__metadata__", ())
        mark = next((mark for mark in marks if isinstance(mark, OptionMark)), None)
        if mark is None:
            continue
        kind = bare(hints[item.name])
        several = kind in (Mapping, tuple) or (kind is Sequence and mark.parse is None)
        yield OptionField(
            name=item.name,
            word=(item.name.removesuffix("s") if several else item.name).replace("_", "-"),
            kind=kind,
            is_repeatable=several,
            mark=mark,
            default=(item.default_factory() if callable(item.default_factory) else item.default)
            if mark.default is None
            else mark.default,
            help=f"{meanings[item.name]}{' (repeatable)' if several else ''}.",
        )


def bare(hint: Any) -> Any:
    """Return a type without None and metadata: of sequences and mappings the origin."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return bare(args[0])
    if origin in (Union, UnionType):
        return bare(next(item for item in args if item is not NoneType))
    return origin if origin in (Sequence, Mapping, tuple) else hint


JOBS = OptionMark("N", ("-j", "--jobs"), least=1, default=os.cpu_count() or 1)
"""Option of the number of processes."""


def number_from(text: str, what: str) -> float:
    """Return a number from the command line.

    Raises
    ------
    UsageError
        If it is none.
    """
    from ...reference.parameters import as_number

    try:
        return as_number(text)
    except ValueError:
        raise UsageError(f"{what} must be a number, not {text!r}") from None


def documented(getter: Getter) -> Getter:
    """Mark the getter of a property that documents hold."""
    getter.is_documented = True  # type: ignore[attr-defined]
    return getter


def descriptions(kind: type) -> dict[str, str]:
    """Return the meanings of fields and properties, from the docstrings that have them."""
    meanings: dict[str, str] = {}
    for base in reversed(kind.__mro__):
        section = inspect.cleandoc(base.__doc__ or "").partition("Attributes\n----------\n")[2]
        names: list[str] = []
        own: dict[str, str] = {}
        for line in section.partition("\n\n")[0].splitlines():
            if entry := ENTRY.match(line):
                names = entry[1].split(", ")
                continue
            for name in names:
                own[name] = f"{own.get(name, '')} {line.strip()}".strip()
        meanings |= own
        for name, item in vars(base).items():
            if isinstance(item, property):
                meanings[name] = inspect.cleandoc(item.__doc__ or "").partition("\n\n")[0]
    return {name: text.removesuffix(".") for name, text in meanings.items()}


@cache
def lists_of(request: type) -> tuple[str, ...]:
    """Return the names of the fields of a request that are lists."""
    return tuple(
        one.name for one in option_fields(request) if one.is_repeatable and one.kind is not Mapping
    )


def takes_fields_of(
    request: Callable[P, Request],
) -> Callable[[Callable[[Request], Outcome]], Callable[P, Outcome]]:
    """Return a decorator: a function of a request takes the fields of the request instead.

    Paths in lists become texts; one value in place of a list is a `UsageError`.
    """
    signature = inspect.signature(request)

    def decorate(function: Callable[[Request], Outcome]) -> Callable[P, Outcome]:
        @wraps(function)
        def call(*values: P.args, **named: P.kwargs) -> Outcome:
            bound = signature.bind(*values, **named)
            for name in lists_of(request):
                value: Any = bound.arguments.get(name)
                if isinstance(value, str | os.PathLike):
                    text = repr(os.fspath(value))
                    raise UsageError(f"{name} must be a list, not {text}; did you mean [{text}]?")
                if value is not None:
                    texts = (os.fspath(v) if isinstance(v, os.PathLike) else v for v in value)
                    bound.arguments[name] = tuple(texts)
            return function(request(*bound.args, **bound.kwargs))

        call.__signature__ = signature  # type: ignore[attr-defined]
        return call

    return decorate
