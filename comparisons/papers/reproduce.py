"""Running the ledger: every figure drawn, every row judged, what is finished kept."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from ...reference import SCENES
from ...reference.errors import MbcheckError, UnknownNameError, UsageError
from ..documents import document
from ..engines.registry import available
from ..engines.run import describe
from ..queries.environment import versions
from ..reports.drawing import import_pyplot, save
from ..reports.files import write_whole
from .figure import Figure
from .ledger import ERROR, Finding, Row
from .session import Session

SUFFIXES = ("png", "svg")
WORK = ".mbcheck"
"""Folder, in that of the pages, of what is finished while the rest is computed."""

Progress = Callable[[int, int, str], None]


class Drawn(NamedTuple):
    """A figure that was drawn, or why it was not."""

    figure: Figure
    error: str = ""


class Judged(NamedTuple):
    """A row and what became of it."""

    row: Row
    finding: Finding


@dataclass(frozen=True)
class Reproduction:
    """What ``mbcheck reproduce`` found.

    Attributes
    ----------
    figures : dict of str to tuple of Drawn
        By scene.
    rows : dict of str to tuple of Judged
    full : bool
    versions : dict of str to str
    """

    figures: dict[str, tuple[Drawn, ...]]
    rows: dict[str, tuple[Judged, ...]]
    full: bool
    versions: dict[str, str]

    @property
    def failures(self) -> list[str]:
        """Return what could not be drawn or judged."""
        drawn = [
            f"figure {item.figure.number} of {scene}: {item.error}"
            for scene, items in self.figures.items()
            for item in items
            if item.error
        ]
        judged = [
            f"{scene} {item.row.name}: {item.finding.reason}"
            for scene, items in self.rows.items()
            for item in items
            if item.finding.verdict == ERROR
        ]
        return drawn + judged

    def as_json(self) -> dict[str, Any]:
        """Return the ``reproduce`` document of docs/json.md."""
        figures = [
            {**vars(item.figure), "scene": scene, "error": item.error or None}
            for scene, items in self.figures.items()
            for item in items
        ]
        rows = [
            {**vars(item.row), "scene": scene, **vars(item.finding)}
            for scene, items in self.rows.items()
            for item in items
        ]
        return document("reproduce", self, figures=figures, rows=rows)


def tables(scene: str) -> tuple[tuple[Figure, ...], tuple[Row, ...]]:
    """Return the figures and rows of a scene's paper.

    Raises
    ------
    UnknownNameError
        If there is no such scene.
    """
    if scene not in SCENES:
        raise UnknownNameError("scene", scene, SCENES)
    paper = import_module(f".{scene}.rows", __package__)
    return paper.FIGURES, paper.ROWS


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
    chosen = {scene: tables(scene) for scene in scenes or SCENES}
    if figure is not None:
        numbers = sorted({item.number for figures, _ in chosen.values() for item in figures})
        if figure not in numbers:
            raise UsageError(
                f"there is no figure {figure}; there are {', '.join(map(str, numbers))}"
            )
        chosen = {
            scene: (tuple(item for item in figures if item.number == figure), ())
            for scene, (figures, _) in chosen.items()
        }
    work = Work(Path(out), full, resume)
    total = sum(len(figures) + len(rows) for figures, rows in chosen.values())
    count = Count(total, progress)
    engines = available()
    session = Session(engines, full, workers, work.folder, count.within)
    drawn = {
        scene: tuple(count.each(figures, scene, partial(work.draw, scene, session)))
        for scene, (figures, _) in chosen.items()
    }
    judged = {
        scene: tuple(count.each(rows, scene, partial(work.judge, scene, session)))
        for scene, (_, rows) in chosen.items()
    }
    return Reproduction(drawn, judged, full, versions(engines))


@dataclass
class Count:
    """How much is done."""

    total: int
    progress: Progress
    done: int = 0
    what: str = ""

    def each(self, items: Sequence[Any], scene: str, run: Callable[[Any], Any]) -> Iterator[Any]:
        """Run items one after the other."""
        for item in items:
            name = f"figure {item.number}" if isinstance(item, Figure) else item.name
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
    """

    def __init__(self, out: Path, full: bool, resume: bool) -> None:
        self.figures, self.folder = out / "figures", out / WORK
        if not resume:
            shutil.rmtree(self.folder, ignore_errors=True)
        try:
            for folder in (self.figures, self.folder):
                folder.mkdir(parents=True, exist_ok=True)
            self.findings = self.read(full)
        except OSError as error:
            raise UsageError(f"--out: cannot write {str(out)!r}: {error.strerror}") from None

    def read(self, full: bool) -> dict[str, Any]:
        """Return the findings of an interrupted run, if they are of this version and size."""
        stamp = {"versions": versions(available()), "full": full}
        self.file = self.folder / "findings.json"
        try:
            found: dict[str, Any] = json.loads(self.file.read_text(encoding="utf-8"))
        except (FileNotFoundError, ValueError):
            found = {}
        return found if found.get("stamp") == stamp else {"stamp": stamp}

    def keep(self, key: str, value: Any) -> None:
        """Keep a finding."""
        self.findings[key] = value
        write_whole(self.file, json.dumps(self.findings, indent=1).encode())

    def draw(self, scene: str, session: Session, figure: Figure) -> Drawn:
        """Draw a figure, unless that is done."""
        key = f"{scene} figure {figure.number}"
        paths = [self.figures / f"{scene}_{figure.number}.{suffix}" for suffix in SUFFIXES]
        if key in self.findings and all(path.exists() for path in paths):
            return Drawn(figure)
        try:
            drawn = figure.draw(session)
        except Exception as error:  # one figure that fails must not cost the others
            return Drawn(figure, failed(error))
        try:
            for path in paths:
                save(drawn, path)
        finally:
            import_pyplot().close(drawn)
        self.keep(key, True)
        return Drawn(figure)

    def judge(self, scene: str, session: Session, row: Row) -> Judged:
        """Judge a row, unless that is done."""
        key = f"{scene} {row.name}"
        if key in self.findings:
            found = dict(self.findings[key])
            found["candidates"] = tuple((a, b) for a, b in found["candidates"])
            return Judged(row, Finding(**found))
        try:
            finding = row.find(session)
        except Exception as error:  # nor one row
            return Judged(row, Finding(ERROR, failed(error)))
        self.keep(key, asdict(finding))
        return Judged(row, finding)


def failed(error: Exception) -> str:
    """Return in one line why something failed; the rest goes on."""
    return str(error) if isinstance(error, MbcheckError) else describe(error, "")
