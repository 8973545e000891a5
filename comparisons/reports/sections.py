"""A report as sections: titled tables and lines, written alike by console, Markdown and HTML."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from rich.console import Console

from ..checks.verdict import FAILURES
from .text import (
    DIGITS,
    STYLES,
    Cell,
    Rows,
    markdown_table,
    print_command,
    print_line,
    print_rows,
    print_unbroken,
)
from .words import Markdown, code, number, plain, plural

MOST_ROWS = 50
"""Rows of a table in Markdown; GitHub refuses summaries of more than 1 MiB."""

MOST_LINES = 200
"""Lines of a section in Markdown."""


@dataclass(frozen=True)
class Section:
    """A part of a report.

    Attributes
    ----------
    title : str
    heads : sequence of str
        Heads of the table.
    rows : sequence of sequences
        Values, or `Cell`.
    lines : sequence of str
        Prose; blanks at the beginning of a line indent it.
    commands : sequence of str
        Shell commands to copy.
    verbatim : sequence of str
        Lines that are not wrapped, such as those of a traceback.
    verdict : str
        The style of the title.
    anchor : str
        Its name in HTML.
    digits : int
        Significant digits of the numbers in the table.
    folded : bool
        Whether HTML folds it away.
    figures : sequence
        Pictures, in HTML.
    """

    title: str = ""
    heads: Sequence[str] = ()
    rows: Sequence[Sequence[object]] = ()
    lines: Sequence[str] = ()
    commands: Sequence[str] = ()
    verbatim: Sequence[str] = ()
    verdict: str = ""
    anchor: str = ""
    digits: int = DIGITS
    folded: bool = False
    figures: Sequence[Any] = field(default=(), compare=False)


def print_sections(console: Console, sections: Iterable[Section]) -> None:
    """Print sections, each followed by an empty line."""
    for section in sections:
        if section.title:
            print_line(console, section.title, STYLES.get(section.verdict, "bold"), hanging="  ")
        if section.rows:
            print_rows(console, section.heads, section.rows, section.digits)
        for line in section.lines:
            text = line.lstrip()
            print_line(console, text, indent="  " + " " * (len(line) - len(text)))
        for command in section.commands:
            print_command(console, command)
        for line in section.verbatim:
            print_unbroken(console, f"  {line}")
        console.print()


def markdown_sections(title: str, sections: Iterable[Section]) -> str:
    """Return a page of Markdown; text from outside is shown as it is."""
    parts = [f"## {plain(title)}\n"]
    for section in sections:
        if section.title:
            parts.append(f"### {plain(section.title)}\n")
        if section.rows:
            parts.append(short_table(section.heads, section.rows))
        lines = [f"{x[: -len(x.lstrip())]}- {plain(x.strip())}" for x in section.lines]
        lines += [f"- {code(x)}" for x in (*section.commands, *section.verbatim)]
        left = len(lines) - MOST_LINES
        lines[MOST_LINES:] = [f"- and {plural(left, 'more line')}"] if left > 0 else []
        parts += ["\n".join(lines) + "\n"] if lines else []
    return "\n".join(parts)


def short_table(heads: Sequence[str], rows: Rows) -> str:
    """Return a table of texts from outside; a long one is cut, with a note."""
    lines = [[markdown_text(value) for value in row] for row in rows]
    text = markdown_table([plain(head) for head in heads], lines[:MOST_ROWS]) + "\n"
    left = len(lines) - MOST_ROWS
    more = f"\nand {plural(left, 'more row')}, see the JSON or JUnit document\n"
    return text + (more if left > 0 else "")


def markdown_text(value: object) -> Markdown:
    """Return a value as Markdown, in bold if its verdict is a failure."""
    text = plain(number(value, missing="-"))
    bold = isinstance(value, Cell) and value.verdict in FAILURES
    return Markdown(f"**{text}**") if bold else text
