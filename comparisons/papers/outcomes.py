"""What of a paper was drawn and judged, how it was made, and the JSON document of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, TypeVar

from ...models.tables import table_of
from ...reference import SCENES
from ...reference.errors import UnknownNameError
from ..documents import document
from ..documents.fields import HIDDEN
from .assess import Assessment
from .ledger import ERROR, Cause, Erratum, LedgerRow, PaperFigure, Printed

T = TypeVar("T")


def tables(scene: str) -> tuple[tuple[PaperFigure, ...], tuple[LedgerRow, ...]]:
    """Return the figures and rows of a scene's paper; a scene may have none.

    Raises
    ------
    UnknownNameError
        If there is no such scene.
    """
    if scene not in SCENES:
        raise UnknownNameError("scene", scene, SCENES)
    return of_paper(scene, "FIGURES", ()), of_paper(scene, "ROWS", ())


def scenes_with_ledger() -> tuple[str, ...]:
    """Return the scenes of papers that are reproduced; others are textbook mechanics."""
    return tuple(scene for scene in SCENES if any(tables(scene)))


def of_paper(scene: str, table: str, empty: T) -> T:
    """Return a table of a scene's paper; a scene may have no paper."""
    return table_of(f"{__package__}.{scene}.rows", table, empty)


def causes(scene: str) -> tuple[Cause, ...]:
    """Return what rows of a scene's paper have in common; a scene may have no paper."""
    return of_paper(scene, "CAUSES", ())


def conclusions(scene: str) -> str:
    """Return the section of a paper's conclusions."""
    return of_paper(scene, "CLOSING_SECTION", "")


def cause_of(scene: str, row: str) -> str:
    """Return the name of the cause that a row shares with others, empty if it has none."""
    return next((cause.name for cause in causes(scene) if row in cause.rows), "")


@dataclass(frozen=True)
class Made:
    """How a figure or a row was made.

    Attributes
    ----------
    full : bool
        whether `--full` was given
    seconds : float
        Run time, with that of the maps and runs that it was the first to need [s].
    """

    versions: dict[str, str] = field(default_factory=dict)
    full: bool = False
    seconds: float = field(default=0.0, metadata=HIDDEN)

    def within(self, seconds: float) -> Made:
        """Return the same with a run time [s]."""
        return replace(self, seconds=seconds)

    @property
    def run(self) -> dict[str, Any]:
        """Return what the things of one run have in common."""
        return {"versions": self.versions, "full": self.full}


class FigureOutcome(NamedTuple):
    """A figure that was drawn, or why it was not."""

    figure: PaperFigure
    error: str = ""
    made: Made = Made()

    @property
    def failed(self) -> bool:
        """Return whether it could not be drawn."""
        return bool(self.error)


class RowOutcome(NamedTuple):
    """A row and what became of it."""

    row: LedgerRow
    assessment: Assessment
    made: Made = Made()

    @property
    def failed(self) -> bool:
        """Return whether it could not be judged."""
        return self.assessment.verdict == ERROR


@dataclass(frozen=True)
class FigureEntry:
    """A figure in the document.

    Attributes
    ----------
    number : int
        as in the paper
    title : str
        what it shows
    caption : str
        what is drawn, with which choices
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
        where it stands in the paper
    claim : str
        what it says, in our words
    printed : str
        printed value; empty for a claim in words
    test : str
        of a misprint: the test that shows it
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
    test: str
    cause: str
    erratum: Erratum | None
    quantity: Printed | None
    run: int
    seconds: float


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


@dataclass(frozen=True)
class Reproduction:
    """What ``mbcheck reproduce`` has drawn and assessed.

    Attributes
    ----------
    figures : dict of str to tuple of FigureOutcome
        By scene.
    rows : dict of str to tuple of RowOutcome
    full : bool
    versions : dict of str to str
    """

    figures: dict[str, tuple[FigureOutcome, ...]]
    rows: dict[str, tuple[RowOutcome, ...]]
    full: bool
    versions: dict[str, str]

    @property
    def failures(self) -> list[str]:
        """Return what could not be drawn or assessed."""
        return [
            f"figure {item.figure.number} of {scene}: {item.error}"
            for scene, items in self.figures.items()
            for item in items
            if item.failed
        ] + [
            f"{scene} {item.row.name}: {item.assessment.reason}"
            for scene, items in self.rows.items()
            for item in items
            if item.failed
        ]

    @property
    def verdicts(self) -> dict[str, Counter[str]]:
        """Return how many rows have which verdict, by scene; readings have none."""
        return {
            scene: Counter(item.assessment.verdict for item in items if item.assessment.verdict)
            for scene, items in self.rows.items()
        }

    @property
    def causes(self) -> dict[str, Counter[str]]:
        """Return how many causes there are of each verdict, by scene; a row alone is its own."""
        return {
            scene: Counter(
                verdict
                for verdict, _ in {
                    (item.assessment.verdict, cause_of(scene, item.row.name) or item.row.name)
                    for item in items
                    if item.assessment.verdict
                }
            )
            for scene, items in self.rows.items()
        }

    def runs(self, scene: str = "") -> list[Made]:
        """Return the different ways in which things of a scene, or of all, were made."""
        different: list[Made] = []
        for items in (self.figures, self.rows):
            for own, outcomes in items.items():
                for outcome in outcomes if own == scene or not scene else ():
                    if outcome.made.within(0.0) not in different:
                        different.append(outcome.made.within(0.0))
        return different

    def as_json(self) -> dict[str, Any]:
        """Return the ``reproduce`` document of docs/json.md."""
        runs = self.runs()

        def how(made: Made) -> dict[str, Any]:
            return {"run": runs.index(made.within(0.0)), "seconds": round(made.seconds, 2)}

        figures = tuple(
            FigureEntry(
                scene,
                item.figure.number,
                item.figure.title,
                item.figure.caption,
                item.error or None,
                **how(item.made),
            )
            for scene, items in self.figures.items()
            for item in items
        )
        rows = tuple(
            RowEntry(
                scene=scene,
                name=row.name,
                kind=row.kind,
                section=row.section,
                claim=row.summary,
                printed=row.printed,
                test=row.test,
                cause=cause_of(scene, row.name),
                erratum=row.erratum,
                quantity=row.quantity,
                **vars(assessment),
                **how(made),
            )
            for scene, items in self.rows.items()
            for row, assessment, made in items
        )
        named = tuple(
            CauseEntry(**vars(cause), scene=scene) for scene in self.rows for cause in causes(scene)
        )
        made = tuple(runs)
        return document("reproduce", Findings(self.versions, self.full, figures, rows, named, made))
