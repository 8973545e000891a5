"""Options of the command line, from the fields of requests."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import MISSING, fields
from types import NoneType, UnionType
from typing import (
    Annotated,
    Any,
    Literal,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

import click

from ...reference.errors import UsageError
from ..documents.fields import OptionMark, descriptions

Function = TypeVar("Function", bound=Callable[..., Any])


class Number(click.ParamType):  # type: ignore[type-arg]
    """A decimal number in plain digits.

    Parameters
    ----------
    least : int, optional
        For a whole number, of this size or larger.
    """

    name = "number"

    def __init__(self, least: int | None = None) -> None:
        self.least = least

    def convert(
        self, value: Any, option: click.Parameter | None, context: click.Context | None
    ) -> float | int:
        """Return the number."""
        from ...reference.parameters import as_number

        if not isinstance(value, str):
            number: float | int = value
            return number
        try:
            if self.least is None:
                return as_number(value)
            whole = int(re.fullmatch(r" *[+-]?[0-9]{1,18} *", value)[0])  # type: ignore[index]
        except (ValueError, TypeError):
            kind = "float" if self.least is None else "integer"
            self.fail(f"{value!r} is not a valid {kind}", option, context)
        if whole < self.least:
            self.fail(f"{whole} is not in the range x>={self.least}", option, context)
        return whole


NUMBER, COUNT, SEED = Number(), Number(1), Number(0)


def with_options_of(
    *kinds: type, without: Collection[str] = (), only: Collection[str] = ()
) -> Callable[[Function], Function]:
    """Return a decorator: a function takes the fields of requests as options and arguments.

    Parameters
    ----------
    *kinds : type
        Dataclasses; their fields with an `OptionMark` are taken, each once.
    without, only : collection of str
        Fields that are left out; those that are taken, by default all.
    """
    items: dict[str, Callable[[Any], Any]] = {}
    for kind in kinds:
        hints, meanings = get_type_hints(kind, include_extras=True), descriptions(kind)
        for field in fields(kind):
            marks = getattr(hints[field.name], "__metadata__", ())
            option = next((mark for mark in marks if isinstance(mark, OptionMark)), None)
            if option is None or field.name in without or (only and field.name not in only):
                continue
            made = field.default_factory() if callable(field.default_factory) else field.default
            default = made if option.default is None else option.default
            hint = get_args(hints[field.name])[0]
            items[field.name] = parameter(field.name, hint, option, default, meanings[field.name])

    def decorate(function: Function) -> Function:
        for item in reversed(items.values()):
            function = item(function)
        return function

    return decorate


def parameter(
    name: str, hint: Any, option: OptionMark, default: Any, meaning: str
) -> Callable[[Any], Any]:
    """Return the decorator that adds an option, or an argument, for a field.

    Parameters
    ----------
    name : str
    hint : type
        Of the field: a flag for a bool; repeatable for a mapping, a tuple, and a sequence unless
        its text is parsed as a whole.
    option : OptionMark
    default
        `dataclasses.MISSING` makes it required.
    meaning : str
        The text of the help.
    """
    kind = bare(hint)
    several = kind in (Mapping, tuple) or (kind is Sequence and option.parse is None)
    if option.flags == ():
        count, metavar = -1 if several else 1, option.metavar or None
        return click.argument(name, nargs=count, metavar=metavar, required=default is MISSING)
    flag = f"--{(name.removesuffix('s') if several else name).replace('_', '-')}"
    about: dict[str, Any] = {"metavar": option.metavar or None}
    if kind is bool:
        flag = f"{flag}/--no-{name}" if default is None else flag
        about = {"is_flag": True}
    elif several:
        about |= {"multiple": True, "callback": assignments if kind is Mapping else None}
    elif get_origin(kind) is Literal:
        about = {"type": click.Choice(get_args(kind))}
    elif kind in (int, float):
        about |= {"type": Number(option.least) if kind is int else NUMBER}
    if option.parse is not None:
        about["callback"] = parsed(option.parse)
    if not several:
        about |= {"required": True} if default is MISSING else {"default": default}
        has_default = option.default is None and isinstance(default, str | int | float)
        about["show_default"] = has_default and default not in ("", False)
    text = f"{meaning} (repeatable)." if several else f"{meaning}."
    return click.option(*(option.flags or (flag,)), name, help=text, **about)


def bare(hint: Any) -> Any:
    """Return a type without None and metadata: of sequences and mappings the origin."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return bare(args[0])
    if origin in (Union, UnionType):
        return bare(next(item for item in args if item is not NoneType))
    return origin if origin in (Sequence, Mapping, tuple) else hint


def parsed(parse: Callable[[str, str], Any]) -> Callable[..., Any]:
    """Return the callback of an option whose text, or each of several, is parsed."""

    def callback(context: click.Context, option: click.Parameter, value: Any) -> Any:
        flag = option.opts[0]
        if isinstance(value, tuple):
            return tuple(dict.fromkeys(parse(text, flag) for text in value))
        return parse(value, flag) if isinstance(value, str) else value

    return callback


def assignments(
    context: click.Context, option: click.Parameter, words: tuple[str, ...]
) -> dict[str, float | str]:
    """Return values by name from words NAME=VALUE; some parameters are words themselves.

    Raises
    ------
    UsageError
        If a word is no assignment, or a name stands twice.
    """
    from ...reference.parameters import as_number

    values: dict[str, float | str] = {}
    for word in words:
        name, equals, text = (part.strip() for part in word.partition("="))
        if not (name and equals):
            raise UsageError(f"{option.opts[0]} needs NAME=VALUE, not {word!r}")
        if name in values:
            raise UsageError(f"{option.opts[0]} {name} is given twice")
        try:
            values[name] = as_number(text)
        except ValueError:
            values[name] = text
    return values
