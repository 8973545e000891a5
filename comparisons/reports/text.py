"""Lines, the one table, and commands: on a terminal, in a log, and as Markdown.

Nothing is wider than the console, which has 80 columns where no terminal says otherwise. Lines
break between words only: a word that needs more, such as an id, is alone on its line.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from rich.align import AlignMethod
from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

from .words import Markdown, broken_lines, number, printable, shell_lines

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


def print_line(
    console: Console, text: str, style: str = "", indent: str = "", hanging: str = ""
) -> None:
    """Print text, broken between words only; lines after the first are indented further."""
    for line in broken_lines(encodable(text, console), console.width, indent, indent + hanging):
        print_unbroken(console, line, style)


def print_unbroken(console: Console, text: str, style: str = "") -> None:
    """Print one line whatever its width, for programs that read it."""
    console.print(Text(encodable(text, console), style), soft_wrap=True)


def print_command(console: Console, command: str) -> None:
    """Print a shell command, indented."""
    for line in shell_lines(f"  {command}", console.width):
        print_unbroken(console, line, "cyan")


def encodable(text: str, console: Console) -> str:
    """Return printable text in the encoding of the console."""
    return in_encoding(printable(text), console)


def in_encoding(text: str, console: Console) -> str:
    """Return text with escapes for what the encoding of the console does not have."""
    return text.encode(console.encoding, "backslashreplace").decode(console.encoding)


DIGITS = 10
"""Significant digits of a float, unless a table says otherwise."""

NUMBER = re.compile(r"[-+]?(\d[\d.]*(e[-+]?\d+)?|inf|nan|any|none)?%?")
"""Cells that are aligned to the right: numbers, and the dash or nothing in their place."""

LEAST_PROSE = 14
"""Columns of text are wrapped to this width, or to half of what they need, and no further."""


def print_table(console: Console, heads: Sequence[str], rows: Rows, digits: int = DIGITS) -> None:
    """Print rows under heads, and an empty line; numbers are aligned to the right."""
    print_rows(console, heads, rows, digits)
    console.print()


def print_rows(console: Console, heads: Sequence[str], rows: Rows, digits: int = DIGITS) -> None:
    """Print rows under heads; numbers stand to the right.

    Where the console is too narrow cells are wrapped, the widest first; where that does not do, a
    row becomes a record: a line for each head and value. A row whose first cell alone holds text
    is a heading of those that follow.
    """
    lines = [[cell(value, digits, console) for value in row] for row in rows]
    body = [line for line in lines if not is_heading(line)]
    columns = [[head, *(line[i].plain for line in body)] for i, head in enumerate(heads)]
    widths = [max(1, *map(cell_len, column)) for column in columns]
    least = [
        max([min(LEAST_PROSE, size // 2), *map(cell_len, " ".join(column).split())])
        for size, column in zip(widths, columns, strict=True)
    ]
    for gap, sizes in ((2, widths), (1, widths), (2, least), (1, least)):
        room = console.width - gap * (len(heads) - 1)
        if sum(sizes) <= room:
            break
    else:
        print_records(console, heads, lines)
        return
    while sum(widths) > room:
        widths[max(range(len(heads)), key=lambda i: (widths[i] > least[i], widths[i]))] -= 1
    sides: list[AlignMethod] = [
        "right" if all(map(NUMBER.fullmatch, column[1:])) else "left" for column in columns
    ]
    rule = Text("-" * (sum(widths) + gap * (len(heads) - 1)))
    for line in ([Text(head) for head in heads], [rule], *lines):
        if len(line) < len(heads) or is_heading(line):
            print_line(console, line[0].plain, str(line[0].style))
            continue
        parts = [text.wrap(console, size) for text, size in zip(line, widths, strict=True)]
        for i in range(max(map(len, parts))):
            printed = Text()
            for part, size, side in zip(parts, widths, sides, strict=True):
                piece = part[i] if i < len(part) else Text()
                piece.align(side, size)
                printed.append_text(piece).append(" " * gap)
            printed.rstrip()
            console.print(printed, soft_wrap=True)


def is_heading(line: Sequence[Text]) -> bool:
    """Return True if the first of several cells alone holds text."""
    return len(line) > 1 and bool(line[0].plain) and not any(text.plain for text in line[1:])


def print_records(console: Console, heads: Sequence[str], lines: Sequence[Sequence[Text]]) -> None:
    """Print a block of lines for each row: the heads, and their values."""
    for number_of_row, line in enumerate(lines):
        if number_of_row:
            console.print()
        for head, text in zip(heads, line, strict=True):
            if text.plain:
                words = f"{head}: {text.plain}" if head else text.plain
                print_line(console, words, hanging="  ")


def cell(value: object, digits: int, console: Console) -> Text:
    """Return a value as the console can print it."""
    style = STYLES.get(value.verdict, "") if isinstance(value, Cell) else ""
    return Text(encodable(number(value, digits, missing="-"), console), style)


def matrix_by_kind(cells: Mapping[tuple[str, ...], object]) -> tuple[list[str], list[list[object]]]:
    """Return a table of values by (scene, engine, kind): heads, and rows.

    Kinds are columns, engines rows below their scene.
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
