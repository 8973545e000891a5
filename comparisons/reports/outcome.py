"""What a run of checks came to: its results, what was asked for, and its exit code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..checks.verdict import Result
from . import report


@dataclass(frozen=True)
class Report:
    """The results of a run of checks.

    Attributes
    ----------
    results : tuple of Result
    versions : mapping of str to str
    run : report.Run
        What was asked for, where it ran, and what became of the known deviations.
    """

    results: tuple[Result, ...]
    versions: Mapping[str, str]
    run: report.Run = field(default_factory=report.Run)

    @property
    def summary(self) -> dict[str, int]:
        """Number of results by verdict, and their ``total``."""
        return report.summary(self.results)

    @property
    def exit_code(self) -> int:
        """0 if all is well, 1 for any deviation or error, 2 if nothing ran.

        1 for stale entries of the known deviations too, where they are to fail.
        """
        return report.exit_code(self.results, self.run)

    def as_json(self) -> dict[str, Any]:
        """Return the ``check`` document of docs/json.md."""
        return report.json_document(self.results, self.versions, self.run)

    def markdown(self) -> str:
        """Return a Markdown table with a line for each method of each engine."""
        return report.markdown(self.results)
