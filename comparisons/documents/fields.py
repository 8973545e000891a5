"""What classes of requests and results say of their fields: meaning, option, place in documents.

The meaning of a field stands in the docstring of its class, under ``Attributes``; help texts and
the tables of docs/json.md take it from there.
"""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import wraps
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
    hint : type
        Of the field: a flag for a bool; repeatable for a mapping, a tuple, and a sequence unless
        its text is parsed as a whole.
    mark : OptionMark
    default
        `dataclasses.MISSING` makes it required.
    meaning : str
        The text of the help.
    """

    name: str
    hint: Any
    mark: OptionMark
    default: Any
    meaning: str

    @property
    def kind(self) -> Any:
        """The type without None and metadata: of sequences and mappings the origin."""
        return bare(self.hint)

    @property
    def is_repeatable(self) -> bool:
        """Whether it holds several values."""
        return self.kind in (Mapping, tuple) or (self.kind is Sequence and self.mark.parse is None)

    @property
    def word(self) -> str:
        """Its name on the command line, without the plural of what may be repeated."""
        return (self.name.removesuffix("s") if self.is_repeatable else self.name).replace("_", "-")

    @property
    def help(self) -> str:
        """What it means, in a sentence."""
        return f"{self.meaning} (repeatable)." if self.is_repeatable else f"{self.meaning}."


def option_fields(kind: type) -> Iterator[OptionField]:
    """Yield the fields of a request that have an `OptionMark`."""
    hints, meanings = get_type_hints(kind, include_extras=True), descriptions(kind)
    for field in fields(kind):
        marks = getattr(hints[field.name], "__metadata__", ())
        mark = next((mark for mark in marks if isinstance(mark, OptionMark)), None)
        if mark is not None:
            made = field.default_factory() if callable(field.default_factory) else field.default
            default = made if mark.default is None else mark.default
            yield OptionField(field.name, hints[field.name], mark, default, meanings[field.name])


def bare(hint: Any) -> Any:
    """Return a type without None and metadata: of sequences and mappings the origin."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return bare(args[0])
    if origin in (Union, UnionType):
        return bare(next(item for item in args if item is not NoneType))
    return origin if origin in (Sequence, Mapping, tuple) else hint


JOBS = OptionMark("N", ("-j", "--jobs"), least=1, default=os.cpu_count() or 1)
"""How many processes work."""


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


def takes_fields_of(
    request: Callable[P, Request],
) -> Callable[[Callable[[Request], Outcome]], Callable[P, Outcome]]:
    """Return a decorator: a function of a request takes the fields of the request instead."""

    def decorate(function: Callable[[Request], Outcome]) -> Callable[P, Outcome]:
        @wraps(function)
        def call(*values: P.args, **named: P.kwargs) -> Outcome:
            return function(request(*values, **named))

        call.__signature__ = inspect.signature(request)  # type: ignore[attr-defined]
        return call

    return decorate
