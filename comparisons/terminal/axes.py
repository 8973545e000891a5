"""The options ``--x`` and ``--y`` of verbs that look at two parameters."""

from __future__ import annotations

import re
from typing import Any

import click

from ...reference.errors import UsageError
from .program import number


def axis_option(name: str, about: str, is_counted: bool = False) -> Any:
    """Return the option of an axis: its name and bounds, and how many values it has.

    Parameters
    ----------
    name : str
        Of the option.
    about : str
        Its line of help.
    is_counted : bool
        Whether a number of values follows.
    """
    form, rule = ("NAME=LO:HI:N", " with a whole number N") if is_counted else ("NAME=LO:HI", "")

    def parts(context: click.Context, option: click.Parameter, text: str) -> tuple[Any, ...]:
        flag = option.opts[0]
        name, equals, words = (part.strip() for part in text.partition("="))
        low, colon, rest = words.partition(":")
        high, *count = rest.split(":")
        whole = all(re.fullmatch(r" *[0-9]{1,9} *", word) for word in count)
        if not (name and equals and colon and len(count) == is_counted and whole):
            raise UsageError(f"{flag} needs {form}{rule}, not {text!r}")
        ends = (number(word, f"{flag} {name}: a bound") for word in (low, high))
        return (name, *ends, *map(int, count))

    return click.option(f"--{name}", required=True, callback=parts, metavar=form, help=about)
