"""Lines, prose and the one table: on a terminal, in a log, and as Markdown.

Nothing is ever broken but prose, and that between its words. A table that is too wide for the
terminal is printed as records, a line for each head and value; where no terminal limits it,
it is as wide as it needs.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence

from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

from .words import Markdown, number, printable

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
    return in_encoding(printable(text), console)


def in_encoding(text: str, console: Console) -> str:
    """Return text with escapes for what the encoding of the console does not have."""
    return text.encode(console.encoding, "backslashreplace").decode(console.encoding)


DIGITS = 10
"""Significant digits of a float, unless a table says otherwise."""

NUMBER = re.compile(r"[-+]?(\d[\d.]*(e[-+]?\d+)?|inf|nan|any|none)?%?")
"""What stands to the right: numbers, and the dash or nothing in their place."""

UNLIMITED = 10**9
"""Columns of what is no terminal."""

LEAST_PROSE = 20
"""Columns that prose needs; with fewer, a table becomes records."""

Rows = Iterable[Sequence[object]]
"""Rows of values; a row of one value is a title of the rows below it."""


def print_table(console: Console, heads: Sequence[str], rows: Rows, digits: int = DIGITS) -> None:
    """Print rows under heads, and an empty line; numbers stand to the right."""
    print_rows(console, heads, rows, digits)
    console.print()


def print_rows(console: Console, heads: Sequence[str], rows: Rows, digits: int = DIGITS) -> None:
    """Print rows under heads; numbers stand to the right."""
    width = console.width if console.is_terminal else UNLIMITED
    lines = [[cell(value, digits, console) for value in row] for row in rows]
    for line in layout([Text(head, "bold") for head in heads], lines, width):
        console.print(line, soft_wrap=True)


def print_matrix(console: Console, cells: Mapping[tuple[str, ...], object]) -> None:
    """Print values by (scene, engine, kind): kinds side by side, engines under their scene."""
    kinds = dict.fromkeys(kind for _, _, kind in cells)
    rows: list[list[object]] = []
    for scene in dict.fromkeys(scene for scene, _, _ in cells):
        rows.append([Text(scene, "bold")])
        for engine in dict.fromkeys(engine for of, engine, _ in cells if of == scene):
            rows.append([f"  {engine}", *(cells.get((scene, engine, kind)) for kind in kinds)])
    if rows:
        print_table(console, ("", *kinds), rows)


def cell(value: object, digits: int, console: Console) -> Text:
    """Return a value as the console can print it; what has a style keeps it."""
    text, style = (value.plain, value.style) if isinstance(value, Text) else (value, "")
    return Text(encodable(number(text, digits, missing="-"), console), style)


def layout(heads: list[Text], rows: list[list[Text]], width: int) -> list[Text]:
    """Return the lines of a table that is at most so wide, unless a single word is wider."""
    full = [row for row in rows if len(row) == len(heads)]
    columns = [list(column) for column in zip(heads, *full, strict=True)]
    widths = [max(text.cell_len for text in column) for column in columns]
    right = [all(NUMBER.fullmatch(text.plain) for text in column[1:]) for column in columns]
    words = [word for text in columns[-1] for word in text.plain.split()]
    prose = widths[-1] if right[-1] else max([LEAST_PROSE, *map(cell_len, words)])
    for gap, least in ((2, widths[-1]), (1, widths[-1]), (2, prose), (1, prose)):
        room = width - sum(widths[:-1]) - gap * len(widths[:-1])
        if room >= least:
            return aligned(heads, rows, [*widths[:-1], min(widths[-1], room)], right, gap)
    return records(heads, rows, width)


def aligned(
    heads: list[Text], rows: list[list[Text]], widths: list[int], right: list[bool], gap: int
) -> list[Text]:
    """Return a table in columns; the last one may take more lines than one."""
    lines: list[Text] = []
    for row in [heads, *rows]:
        if len(row) < len(heads):
            lines += row
            continue
        *first, last = row
        parts = wrapped(last, widths[-1])
        lines.append(Text(" " * gap).join(map(padded, [*first, parts[0]], widths, right)))
        indent = " " * (sum(widths[:-1]) + gap * len(first))
        lines += [Text.assemble(indent, part) for part in parts[1:]]
        if row is heads:
            lines.append(Text("-" * (len(indent) + widths[-1]), "dim"))
    for line in lines:
        line.rstrip()
    return lines


def padded(text: Text, width: int, right: bool) -> Text:
    """Return text with spaces before or behind it."""
    space = " " * (width - text.cell_len)
    return Text.assemble(space, text) if right else Text.assemble(text, space)


def wrapped(text: Text, width: int, indent: str = "") -> list[Text]:
    """Return text in lines, broken at spaces only; those after the first are indented."""
    if text.cell_len <= width:
        return [text]
    lines = textwrap.wrap(
        text.plain,
        width,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [Text(line, text.style) for line in lines]


def records(heads: list[Text], rows: list[list[Text]], width: int) -> list[Text]:
    """Return a block of lines for each row: the heads, and what stands under them."""
    lines: list[Text] = []
    for row in rows:
        lines += [Text("")] if lines else []
        if len(row) < len(heads):
            lines += row
            continue
        for head, text in zip(heads, row, strict=True):
            name = f"{head.plain}: " if head.plain else ""
            if text.plain:
                lines += wrapped(Text.assemble((name, "bold"), text), width, indent="  ")
    return lines


def markdown_table(heads: Sequence[str], rows: Rows, digits: int = DIGITS) -> str:
    """Return a Markdown table; cells that are `Markdown` already stay as they are."""
    lines = [[markdown_cell(value, digits) for value in row] for row in rows]
    columns = zip(*lines, strict=True) if lines else ([] for _ in heads)
    numeric = [bool(column) and all(map(NUMBER.fullmatch, column)) for column in columns]
    rule = ["---:" if right else "---" for right in numeric]
    return "\n".join(f"| {' | '.join(line)} |" for line in (heads, rule, *lines))


def markdown_cell(value: object, digits: int) -> str:
    """Return a value as one cell."""
    if isinstance(value, Markdown):
        return value
    return " ".join(printable(number(value, digits, missing="-")).replace("|", "\\|").split())
