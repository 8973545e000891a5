"""Options of the command line, from the fields of requests."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import MISSING
from typing import Any, Literal, TypeVar, get_args, get_origin

import click

from ...reference.errors import UsageError
from ..documents.fields import OptionField, option_fields

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
    items = {
        field.name: parameter(field)
        for kind in kinds
        for field in option_fields(kind)
        if field.name not in without and (not only or field.name in only)
    }

    def decorate(function: Function) -> Function:
        for item in reversed(items.values()):
            function = item(function)
        return function

    return decorate


def parameter(field: OptionField) -> Callable[[Any], Any]:
    """Return the decorator that adds an option, or an argument, for a field."""
    mark, kind, default, several = field.mark, field.kind, field.default, field.is_repeatable
    required, metavar = default is MISSING, mark.metavar or None
    if mark.flags == ():
        count = -1 if several else 1
        return click.argument(field.name, nargs=count, metavar=metavar, required=required)
    flag, about = f"--{field.word}", dict[str, Any](metavar=metavar)
    if kind is bool:
        flag = f"{flag}/--no-{field.word}" if default is None else flag
        about = {"is_flag": True}
    elif several:
        about |= {"multiple": True, "callback": assignments if kind is Mapping else None}
    elif get_origin(kind) is Literal:
        about = {"type": click.Choice(get_args(kind))}
    elif kind in (int, float):
        about |= {"type": Number(mark.least) if kind is int else NUMBER}
    if mark.parse is not None:
        about["callback"] = parsed(mark.parse)
    if not several:
        about |= {"required": True} if required else {"default": default}
        has_default = mark.default is None and isinstance(default, str | int | float)
        about["show_default"] = has_default and default not in ("", False)
    return click.option(*(mark.flags or (flag,)), field.name, help=field.help, **about)


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
