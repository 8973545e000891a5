"""Running the ledger: every figure drawn, every row assessed, what is finished recorded."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from ...reference import SCENES
from ...reference.errors import UnknownNameError, UsageError
from ..documents import document
from ..engines.registry import available, get_engine
from ..queries.environment import versions
from ..reports.drawing import import_pyplot, save_and_close
from ..reports.files import write_whole
from .assess import Assessment, assess, attempt
from .ledger import ERROR, Cause, LedgerRow, PaperFigure
from .session import Session

SUFFIXES = ("png", "svg")
WORK = ".mbcheck"
"""Folder, in that of the pages, of what is finished while the rest is computed."""

Progress = Callable[[int, int, str], None]
T = TypeVar("T")


class FigureOutcome(NamedTuple):
    """A figure that was drawn, or why it was not."""

    figure: PaperFigure
    error: str = ""


class RowOutcome(NamedTuple):
    """A row and what became of it."""

    row: LedgerRow
    assessment: Assessment


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
            if item.error
        ] + [
            f"{scene} {row.name}: {assessment.reason}"
            for scene, items in self.rows.items()
            for row, assessment in items
            if assessment.verdict == ERROR
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
                    (assessment.verdict, cause_of(scene, row.name) or row.name)
                    for row, assessment in items
                    if assessment.verdict
                }
            )
            for scene, items in self.rows.items()
        }

    def as_json(self) -> dict[str, Any]:
        """Return the ``reproduce`` document of docs/json.md."""
        figures = [
            {**vars(item.figure), "scene": scene, "error": item.error or None}
            for scene, items in self.figures.items()
            for item in items
        ]
        rows = [
            {
                "scene": scene,
                "name": row.name,
                "kind": row.kind,
                "section": row.section,
                "claim": row.summary,
                "printed": row.printed,
                "test": row.test,
                "cause": cause_of(scene, row.name),
                "erratum": vars(row.erratum) if row.erratum else None,
                "quantity": vars(row.quantity) if row.quantity else None,
                **vars(assessment),
            }
            for scene, items in self.rows.items()
            for row, assessment in items
        ]
        named = [{"scene": scene, **vars(cause)} for scene in self.rows for cause in causes(scene)]
        return document("reproduce", self, figures=figures, rows=rows, causes=named)


def tables(scene: str) -> tuple[tuple[PaperFigure, ...], tuple[LedgerRow, ...]]:
    """Return the figures and rows of a scene's paper; a scene may have none.

    Raises
    ------
    UnknownNameError
        If there is no such scene.
    """
    if scene not in SCENES:
        raise UnknownNameError("scene", scene, SCENES)
    if not (Path(__file__).parent / scene).is_dir():
        return (), ()
    paper = import_module(f".{scene}.rows", __package__)
    return paper.FIGURES, paper.ROWS


def causes(scene: str) -> tuple[Cause, ...]:
    """Return what rows of a scene's paper have in common; a scene may have no paper."""
    if not (Path(__file__).parent / scene).is_dir():
        return ()
    named: tuple[Cause, ...] = import_module(f".{scene}.rows", __package__).CAUSES
    return named


def cause_of(scene: str, row: str) -> str:
    """Return the name of the cause that a row shares with others, empty if it has none."""
    return next((cause.name for cause in causes(scene) if row in cause.rows), "")


def reproduce(
    scenes: Sequence[str] = (),
    *,
    out: str | Path,
    figure: int | None = None,
    full: bool = False,
    workers: int = 1,
    resume: bool = False,
    progress: Progress = lambda done, total, what: None,
) -> Reproduction:
    """Draw the figures of papers and judge the rows of their ledgers.

    Parameters
    ----------
    scenes : sequence of str
        Whose papers; all by default.
    out : str or Path
        Folder; figures go to ``figures`` in it.
    figure : int, optional
        Only this figure, and no rows.
    full : bool
        Maps and runs at full size.
    workers : int
        Processes for the maps.
    resume : bool
        Take what an interrupted run has finished.
    progress : callable ``(done, total, what)``

    Raises
    ------
    UsageError
        If a name or a figure is unknown, the folder cannot be written, or matplotlib is not
        installed.
    """
    import_pyplot()
    papers = {scene: tables(scene) for scene in scenes or SCENES}
    if figure is not None:
        papers = {scene: (only(figure, papers, scene), ()) for scene in papers}
    work = Work(Path(out), full, resume)
    count = Count(sum(len(items) for paper in papers.values() for items in paper), progress)
    session = Session(available(), full, workers, work.folder, count.within)
    sessions = {scene: for_scene(session, scene) for scene in papers}
    drawn = {
        scene: tuple(count.each(figures, scene, partial(work.draw, scene, sessions[scene])))
        for scene, (figures, _) in papers.items()
    }
    rows = {
        scene: tuple(count.each(rows, scene, partial(work.assess, scene, sessions[scene])))
        for scene, (_, rows) in papers.items()
    }
    return Reproduction(drawn, rows, full, versions(session.engines))


def only(number: int, papers: dict[str, Any], scene: str) -> tuple[PaperFigure, ...]:
    """Return the figure of a scene's paper that has a number, which one of the papers must have."""
    numbers = sorted({item.number for figures, _ in papers.values() for item in figures})
    if number not in numbers:
        raise UsageError(f"there is no figure {number}; there are {', '.join(map(str, numbers))}")
    return tuple(item for item in papers[scene][0] if item.number == number)


def for_scene(session: Session, scene: str) -> Session:
    """Return the session with those engines alone that have a model of a scene."""
    engines = tuple(name for name in session.engines if get_engine(name).models(scene))
    return replace(session, engines=engines)


@dataclass
class Count:
    """How much is done."""

    total: int
    progress: Progress
    done: int = 0
    what: str = ""

    def each(self, items: Sequence[Any], scene: str, run: Callable[[Any], T]) -> Iterator[T]:
        """Run items one after the other."""
        for item in items:
            name = f"figure {item.number}" if isinstance(item, PaperFigure) else item.name
            self.what = f"{scene} {name}"
            self.progress(self.done, self.total, self.what)
            yield run(item)
            self.done += 1
            self.progress(self.done, self.total, self.what)

    def within(self, name: str, done: int, total: int) -> None:
        """Tell how far the map is that the current item waits for."""
        self.progress(self.done, self.total, f"{self.what}: map {name} {done}/{total}")


class Work:
    """What is finished, in a folder, so that an interrupted run can go on.

    Attributes
    ----------
    figures, folder : Path
        Of the figures, and of everything that only an interrupted run needs.
    finished : dict
        Assessments by scene and row, and which figures are drawn; all of one version and size.
    """

    def __init__(self, out: Path, full: bool, resume: bool) -> None:
        self.figures, self.folder = out / "figures", out / WORK
        self.file = self.folder / "findings.json"
        if not resume:
            shutil.rmtree(self.folder, ignore_errors=True)
        stamp = {"versions": versions(available()), "full": full}
        self.finished: dict[str, Any] = {"stamp": stamp}
        try:
            for folder in (self.figures, self.folder):
                folder.mkdir(parents=True, exist_ok=True)
            finished = json.loads(self.file.read_text("utf-8")) if self.file.exists() else {}
        except ValueError:  # cut off in writing
            finished = {}
        except OSError as error:
            raise UsageError(f"--out: cannot write {str(out)!r}: {error.strerror}") from None
        if finished.get("stamp") == stamp:
            self.finished = finished

    def record(self, key: str, value: Any) -> None:
        """Record what is finished."""
        self.finished[key] = value
        write_whole(self.file, json.dumps(self.finished, indent=1).encode())

    def draw(self, scene: str, session: Session, figure: PaperFigure) -> FigureOutcome:
        """Draw a figure, unless that is done."""
        key = f"{scene} figure {figure.number}"
        paths = [self.figures / f"{scene}_{figure.number}.{suffix}" for suffix in SUFFIXES]
        if key in self.finished and all(path.exists() for path in paths):
            return FigureOutcome(figure)
        drawn, failure = attempt(lambda: figure.draw(session))
        if failure:
            return FigureOutcome(figure, failure)
        save_and_close(drawn, *paths)
        self.record(key, True)
        return FigureOutcome(figure)

    def assess(self, scene: str, session: Session, row: LedgerRow) -> RowOutcome:
        """Assess a row, unless that is done."""
        key = f"{scene} {row.name}"
        if finished := self.finished.get(key):
            pairs = tuple((name, text) for name, text in finished["candidates"])
            lists = {"candidates": pairs, "thresholds": tuple(finished["thresholds"])}
            return RowOutcome(row, Assessment(**finished | lists))
        assessment, failure = attempt(lambda: assess(row, session))
        if assessment is None:
            return RowOutcome(row, Assessment(ERROR, failure))
        self.record(key, asdict(assessment))
        return RowOutcome(row, assessment)
