"""Numbers, counts and text as every report writes them."""

from __future__ import annotations

import html
import re
import textwrap
from collections.abc import Mapping
from typing import Any

BREAKS = re.compile(r"(?:\s(?<! ))+")
"""Line ends, tabs, and blanks that are none."""


SHELL_WORD = re.compile(r" *(?:--?[a-z-]+ (?!-))?(?:'[^']*'|\\.|[^ '])+")
"""A word of a shell command, or an option with its value; blanks before it included."""


def shell_lines(command: str, width: int) -> list[str]:
    """Return a shell command in lines of at most a width, each but the last with a backslash."""
    first, *words = SHELL_WORD.findall(command)
    lines, indent = [first], first[: -len(first.lstrip())] + " " * 3
    for word in words:
        if len(lines[-1]) + len(word) + 2 > width:
            lines[-1] += " \\"
            lines.append(indent)
        lines[-1] += word
    return lines


def broken_lines(text: str, width: int, first: str = "", others: str = "") -> list[str]:
    """Return the lines of a text, broken between words only, with indents."""
    return textwrap.wrap(
        text,
        width,
        initial_indent=first,
        subsequent_indent=others,
        break_long_words=False,
        break_on_hyphens=False,
    )


def number(value: object, digits: int = 3, missing: str = "none") -> str:
    """Return a float with so many significant digits, anything else as it is written.

    Zero has no sign, and None is called ``missing``.
    """
    if value is None:
        return missing
    return f"{value + 0.0:.{digits}g}" if isinstance(value, float) else str(value)


def with_unit(value: float | None, unit: str, digits: int = 3, missing: str = "none") -> str:
    """Return a number with its unit."""
    text = number(value, digits, missing)
    return text if value is None or unit in ("", "1") else f"{text} {unit}"


def exact(value: float) -> str:
    """Return a number in six digits, or in as many as it takes to read it back."""
    short = f"{value:.6g}"
    return short if float(short) == value else repr(float(value))


def plural(count: int, noun: str) -> str:
    """Return a count with its noun."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def assignments(values: Mapping[str, Any], digits: int = 10) -> str:
    """Return values as NAME=VALUE, in one line."""
    return ", ".join(f"{name}={number(value, digits)}" for name, value in values.items())


def printable(text: str) -> str:
    """Return text on one line, without control characters, and with escapes for invisible ones.

    The indentation stays; text of engines must not move the cursor, colour a log, or reverse the
    direction of writing.
    """
    if text.isprintable():
        return text
    seen = (c if c.isprintable() else ascii(c)[1:-1] for c in BREAKS.sub(" ", text))
    return "".join(seen)


class Markdown(str):
    """Text in Markdown, which is not escaped."""


def plain(text: str) -> Markdown:
    """Return text that Markdown shows as it is, in a cell too."""
    escaped = re.sub(r"([\\`*_\[\]|~#])", r"\\\1", html.escape(printable(text), quote=False))
    return Markdown(escaped.replace("@", "@\N{ZERO WIDTH SPACE}"))  # no one is to be notified


def code(text: str) -> Markdown:
    """Return text as code, in a cell too; what would end it is replaced."""
    return Markdown("`" + printable(text).replace("`", "'").replace("|", "\\|") + "`")
