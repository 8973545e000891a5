"""The one record of a report: a result of a check, or a finding about a line of a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Level = Literal["error", "warning", "note"]

Outcome = Literal["pass", "failure", "error", "skipped"]

LEVELS: tuple[Level, ...] = ("error", "warning", "note")
"""The severities of items, the worst first."""


@dataclass(frozen=True)
class ReportItem:
    """A result or a finding, as JUnit, SARIF, annotations and lines of text write it.

    Attributes
    ----------
    id : str
        A name that stays from run to run, and as lines are added above it in a file.
    rule : str
        The kind of a check, or the rule of `mbcheck inspect`.
    suite : str
        Group of the item: scene, engine and kind, or the given file.
    outcome : {"pass", "failure", "error", "skipped"}
        As test pages of CI services know it.
    severity : {"error", "warning", "note"} or None
        None for results that passed, were skipped or are known.
    message : str
        One line.
    details : tuple of str
        Further lines: numbers, what to do, the command that repeats it.
    file : str or None
        As the user names it.
    line : int or None
    title : str
        Heading of an annotation; ``mbcheck:`` and the rule by default.
    numbers : mapping of str to object
        Value, reference, error, tolerance, ... by name.
    seconds : float
        Time that it took [s].
    """

    id: str
    rule: str
    suite: str
    outcome: Outcome
    severity: Level | None
    message: str
    details: tuple[str, ...] = ()
    file: str | None = None
    line: int | None = None
    title: str = ""
    numbers: Mapping[str, object] = field(default_factory=dict)
    seconds: float = 0.0

    @property
    def place(self) -> str:
        """File and line, as compilers write them; the id of an item without a file."""
        where = self.file or self.id
        return where if self.line is None else f"{where}:{self.line}"

    @property
    def text(self) -> str:
        """The item in one line: ``file:line: severity rule message; details``."""
        words = "; ".join((self.message, *self.details))
        return " ".join(f"{self.place}: {self.severity} {self.rule} {words}".split())
