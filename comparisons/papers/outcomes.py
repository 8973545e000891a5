"""The document `reproduce`: the figures and rows of papers, and the runs that made them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...reference import SCENES
from ..documents import document
from .assess import Assessment
from .claims import read_paper
from .ledger import ERROR, Cause, Erratum, LedgerRow, PaperFigure, Printed


@dataclass(frozen=True)
class Made:
    """How a figure or a row was made.

    Attributes
    ----------
    full : bool
        whether `--full` was given
    date : str
        the day, as 2026-11-27; empty if unknown
    commit : str
        of the clone that mbcheck ran from; empty if it is installed otherwise
    """

    versions: Mapping[str, str]
    full: bool = False
    date: str = ""
    commit: str = ""

    @property
    def way(self) -> tuple[Mapping[str, str], bool]:
        """The settings that must be the same for an interrupted run to go on."""
        return self.versions, self.full


@dataclass(frozen=True)
class FigureEntry:
    """A figure in the document.

    Attributes
    ----------
    number : int
        as in the paper
    title : str
        subject of the figure
    caption : str
        the curves that are drawn, with which choices
    error : str or None
        why it was not drawn, or null
    run : int
        how it was made: its place in `runs`
    seconds : float
        run time [s]
    """

    scene: str
    number: int
    title: str
    caption: str
    error: str | None
    run: int
    seconds: float

    @property
    def name(self) -> str:
        """Name among the figures and rows of the paper."""
        return f"figure {self.number}"

    @property
    def failure(self) -> str:
        """The reason why it could not be drawn, with its name; empty if it was."""
        return f"{self.name} of {self.scene}: {self.error}" if self.error else ""

    @classmethod
    def of(cls, scene: str, figure: PaperFigure, error: str | None, **how: Any) -> FigureEntry:
        """Return the entry of a figure, with how it was made."""
        return cls(scene, figure.number, figure.title, figure.caption, error, **how)


@dataclass(frozen=True, kw_only=True)
class RowEntry(Assessment):
    """A row of the ledger in the document.

    Attributes
    ----------
    name : str
        name of the row, unique in its scene
    kind : str
        a printed `number`, a `claim` in words, a `misprint`, a `reading` of what the text leaves
        open
    section : str
        place in the paper
    claim : str
        the paper's statement, in our words
    printed : str
        printed value; empty for a claim in words
    cause : str
        name of the cause that it shares with others, or empty
    erratum : Erratum or None
        of a misprint; otherwise null
    quantity : Printed or None
        the printed number that it is judged by; null if there is none
    run : int
        how it was made: its place in `runs`
    seconds : float
        run time, with that of maps and runs that it was the first to need [s]
    """

    scene: str
    name: str
    kind: str
    section: str
    claim: str
    printed: str
    cause: str
    erratum: Erratum | None
    quantity: Printed | None
    run: int
    seconds: float

    @property
    def failure(self) -> str:
        """The reason why it could not be judged, with its name; empty if it was."""
        return f"{self.scene} {self.name}: {self.reason}" if self.verdict == ERROR else ""

    @classmethod
    def of(cls, scene: str, row: LedgerRow, assessment: Assessment, **how: Any) -> RowEntry:
        """Return the entry of a row, with how it was made."""
        shared = (cause.name for cause in read_paper(scene).causes if row.name in cause.rows)
        names = ("name", "kind", "section", "claim", "printed", "erratum", "quantity")
        own = {name: getattr(row, name) for name in names}
        return cls(scene=scene, cause=next(shared, ""), **own, **vars(assessment), **how)


@dataclass(frozen=True)
class CauseEntry(Cause):
    """A cause in the document."""

    scene: str


@dataclass(frozen=True)
class Findings:
    """The ``reproduce`` document.

    Attributes
    ----------
    full : bool
        whether `--full` was given
    figures : tuple of FigureEntry
        one for each figure
    rows : tuple of RowEntry
        the ledger
    causes : tuple of CauseEntry
        what several rows that do not hold as printed have in common
    runs : tuple of Made
        the ways in which figures and rows were made
    """

    versions: Mapping[str, str]
    full: bool
    figures: tuple[FigureEntry, ...]
    rows: tuple[RowEntry, ...]
    causes: tuple[CauseEntry, ...]
    runs: tuple[Made, ...]

    def as_json(self) -> dict[str, Any]:
        """Return the ``reproduce`` document of docs/json.md."""
        return document("reproduce", self)

    @property
    def entries(self) -> list[FigureEntry | RowEntry]:
        """The figures, and then the rows."""
        return [*self.figures, *self.rows]

    @property
    def scenes(self) -> list[str]:
        """The scenes of all entries, in the order of the list of scenes."""
        there = {item.scene for item in self.entries}
        return [scene for scene in SCENES if scene in there]

    def figures_of(self, scene: str) -> list[FigureEntry]:
        """Return the figures of a scene's paper."""
        return [item for item in self.figures if item.scene == scene]

    def rows_of(self, scene: str) -> list[RowEntry]:
        """Return the rows of a scene's paper."""
        return [item for item in self.rows if item.scene == scene]

    @property
    def failures(self) -> list[str]:
        """The figures and rows that failed, each with its reason."""
        return [item.failure for item in self.entries if item.failure]

    def verdicts(self, scene: str) -> Counter[str]:
        """Return the number of rows of a scene with each verdict; readings have none."""
        return Counter(item.verdict for item in self.rows_of(scene) if item.verdict)

    def causes_by_verdict(self, scene: str) -> Counter[str]:
        """Return the number of causes of each verdict; a row that shares none counts as one."""
        rows = [item for item in self.rows_of(scene) if item.verdict]
        return Counter(
            verdict for verdict, _ in {(item.verdict, item.cause or item.name) for item in rows}
        )
