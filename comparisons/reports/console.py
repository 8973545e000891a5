"""Lines on the console: colours, words that are not broken, and prose that is."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping

from rich.console import Console
from rich.text import Text

from .words import printable

STYLES: Mapping[str, str] = {
    "pass": "green",
    "deviation": "bold red",
    "known": "yellow",
    "skipped": "dim",
    "error": "bold magenta",
}
"""Of verdicts."""


def print_line(console: Console, text: str, style: str = "") -> None:
    """Print text that is not to be broken: it may be copied, or searched for in a log."""
    console.print(Text(encodable(text, console), style), soft_wrap=True)


def print_wrapped(console: Console, text: str, indent: str = "") -> None:
    """Print prose, broken between words only."""
    for line in textwrap.wrap(
        encodable(text, console),
        console.width,
        initial_indent=indent,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    ):
        console.print(Text(line), soft_wrap=True)


def encodable(text: str, console: Console) -> str:
    """Return printable text in the encoding of the console."""
    return printable(text).encode(console.encoding, "backslashreplace").decode(console.encoding)
