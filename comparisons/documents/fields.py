"""What classes of requests and results say of their fields: meaning, option, place in documents.

The meaning of a field stands in the docstring of its class, under ``Attributes``; help texts and
the tables of docs/json.md take it from there.
"""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Annotated, Any, ParamSpec, TypeVar

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
