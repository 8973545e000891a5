"""Lines, prose and the one table: on a terminal, in a log, and as Markdown.

Nothing is ever broken but prose, and that between its words. A table that is too wide for the
terminal is printed as records, a line for each head and value; where no terminal limits it,
it is as wide as it needs.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from rich.box import Box
from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from rich.text import Text

from .words import Markdown, number, printable

STYLES: Mapping[str, str] = {
    "pass": "green",
    "deviation": "bold red",
    "known": "yellow",
    "skipped": "dim",
    "error": "bold magenta",
}
"""Style of each verdict."""


class Cell(NamedTuple):
    """Text in the style of a verdict; ``target`` is the anchor that it leads to in HTML."""

    text: str
    verdict: str = ""
    target: str = ""

    def __str__(self) -> str:
        return self.text


Rows = Iterable[Sequence[object]]


def print_line(console: Console, text: str, style: str = "") -> None:
    """Print text that is not to be broken: it may be copied, or searched for in a log."""
    console.print(Text(encodable(text, console), style), soft_wrap=True)


def print_wrapped(console: Console, text: str, indent: str = "", hanging: str = "") -> None:
    """Print prose, broken between words only; lines after the first are indented further."""
    for line in textwrap.wrap(
        encodable(text, console),
        console.width,
        initial_indent=indent,
        subsequent_indent=indent + hanging,
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

UNLIMITED = 10**6
"""Columns of a log."""

LEAST_PROSE = 20
"""Columns that prose needs; with fewer, a table becomes records."""

GAPS = (2, 1)
"""Blanks between columns, the second where the first leaves too little room."""

HEAD_RULE = Box("    \n    \n -- \n    \n    \n    \n    \n    \n", ascii=True)
"""A line below the heads, and no other."""


def print_table(console: Console, heads: Sequence[str], rows: Rows, digits: int = DIGITS) -> None:
    """Print rows under heads, and an empty line; numbers stand to the right."""
    print_rows(console, heads, rows, digits)
    console.print()


def print_rows(console: Console, heads: Sequence[str], rows: Rows, digits: int = DIGITS) -> None:
    """Print rows under heads; numbers stand to the right, and the last column may be wrapped."""
    lines = [[cell(value, digits, console) for value in row] for row in rows]
    columns = [[line[i] for line in lines] for i in range(len(heads))]
    widths = [
        max(map(cell_len, (head, *map(str, column))))
        for head, column in zip(heads, columns, strict=True)
    ]
    right = [all(NUMBER.fullmatch(text.plain) for text in column) for column in columns]
    words = [word for text in (heads[-1], *map(str, columns[-1])) for word in text.split()]
    least = widths[-1] if right[-1] else max([LEAST_PROSE, *map(cell_len, words)])
    width = console.width if console.is_terminal else UNLIMITED
    for gap in GAPS:
        left = width - sum(widths[:-1]) - gap * (len(heads) - 1)
        if left >= min(least, widths[-1]):
            break
    else:
        print_records(console, heads, lines)
        return
    widths[-1] = min(widths[-1], left)
    table = Table(box=HEAD_RULE, show_edge=False, pad_edge=False, padding=(0, gap - 1, 0, 0))
    for head, size, to_the_right in zip(heads, widths, right, strict=True):
        table.add_column(Text(head), width=size, justify="right" if to_the_right else "left")
    for line in lines:
        table.add_row(*line)
    wide = console.options.update(max_width=UNLIMITED)
    for segments in console.render_lines(table, wide, pad=False):
        text = Text.assemble(*((part.text, part.style or "") for part in segments))
        text.rstrip()
        console.print(text, soft_wrap=True)


def print_records(console: Console, heads: Sequence[str], lines: Sequence[Sequence[Text]]) -> None:
    """Print a block of lines for each row: the heads, and what stands under them."""
    for number_of_row, line in enumerate(lines):
        if number_of_row:
            console.print()
        for head, text in zip(heads, line, strict=True):
            if text.plain:
                words = f"{head}: {text.plain}" if head else text.plain
                print_wrapped(console, words, hanging="  ")


def cell(value: object, digits: int, console: Console) -> Text:
    """Return a value as the console can print it."""
    style = STYLES.get(value.verdict, "") if isinstance(value, Cell) else ""
    return Text(encodable(number(value, digits, missing="-"), console), style)


def matrix_by_kind(cells: Mapping[tuple[str, ...], object]) -> tuple[list[str], list[list[object]]]:
    """Return a table of values by (scene, engine, kind): heads, and rows.

    Kinds stand side by side, engines below their scene.
    """
    kinds = list(dict.fromkeys(kind for _, _, kind in cells))
    rows: list[list[object]] = []
    for scene in dict.fromkeys(scene for scene, _, _ in cells):
        rows.append([scene, *("" for _ in kinds)])
        for engine in dict.fromkeys(engine for of, engine, _ in cells if of == scene):
            rows.append([f"  {engine}", *(cells.get((scene, engine, kind)) for kind in kinds)])
    return ["", *kinds], rows


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
