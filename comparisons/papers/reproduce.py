"""Running the ledger: figures drawn, rows assessed, and both kept in the folder once finished."""

from __future__ import annotations

import json
import logging
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from datetime import date
from pathlib import Path
from time import perf_counter
from typing import Annotated

import msgspec

from ...reference import SCENES
from ...reference.cost import words
from ...reference.errors import UnknownNameError, UsageError
from ..documents.fields import JOBS, OptionMark, takes_fields_of
from ..engines.registry import available, get_engine
from ..queries.environment import own_commit, versions
from ..reports.drawing import import_pyplot, save_and_close
from ..reports.files import write_whole
from ..reports.words import plural
from .assess import Assessment, assess, attempt
from .claims import PaperData, read_paper, scenes_with_ledger
from .ledger import ERROR, LedgerRow, PaperFigure
from .outcomes import CauseEntry, FigureEntry, Findings, Made, RowEntry
from .session import Session

FINDINGS, FIGURES = "findings.json", "figures"
"""The ``reproduce`` document of docs/json.md, which the pages show; the folder of pictures."""
WORK = ".mbcheck"
"""Folder of maps that an interrupted run goes on with."""
SUFFIXES = ("png", "svg")
DOTS_PER_INCH = 229
"""Resolution of pictures, which are then 1,600 points wide."""

LOG = logging.getLogger(__name__)

Papers = Mapping[str, PaperData]
"""Papers, or a selection of their figures and rows, by scene."""


class Folder:
    """The contents of an output folder, and what takes its place there.

    Attributes
    ----------
    file, figures, work : Path
        The document, the folder of pictures, and that of maps.
    runs : list of Made
        How things were made; the first is how this run makes what it adds.
    entries : dict by (scene, name of a figure or row)
    """

    def __init__(self, out: Path, made: Made) -> None:
        self.file, self.figures, self.work = out / FINDINGS, out / FIGURES, out / WORK
        self.runs = [made]
        self.entries: dict[tuple[str, str], FigureEntry | RowEntry] = {}
        try:
            for path in (self.figures, self.work):
                path.mkdir(parents=True, exist_ok=True)
            self._refresh_work()
            text = self.file.read_bytes() if self.file.exists() else b""
        except OSError as error:
            raise UsageError(f"--out: cannot write {str(out)!r}: {error.strerror}") from None
        try:
            if text:
                self._take(msgspec.json.decode(text, type=Findings))
        except (msgspec.MsgspecError, LookupError, ValueError, RecursionError):
            LOG.warning("Warning: %s is damaged, or another document: replaced", self.file)

    def _refresh_work(self) -> None:
        """Remove the maps of other versions, and remember which these are."""
        stamp, now = self.work / "versions.json", json.dumps(self.runs[0].versions)
        if not stamp.exists() or stamp.read_text("utf-8", "replace") != now:
            shutil.rmtree(self.work)
            self.work.mkdir()
            stamp.write_text(now, "utf-8")

    def _take(self, document: Findings) -> None:
        """Take the entries of a document whose figures and rows the papers still have."""
        self.runs += [one for one in document.runs if one not in self.runs]
        for item in document.entries:
            paper = read_paper(item.scene) if item.scene in SCENES else PaperData()
            how = {"run": self.runs.index(document.runs[item.run]), "seconds": item.seconds}
            for own in paper.items:
                if own.name != item.name:
                    continue
                if isinstance(own, PaperFigure) and isinstance(item, FigureEntry):
                    self.add(FigureEntry.of(item.scene, own, item.error, **how))
                elif isinstance(own, LedgerRow):
                    parts = {one.name: getattr(item, one.name) for one in fields(Assessment)}
                    whole = assess(own, Session()) if own.is_text else Assessment(**parts)
                    self.add(RowEntry.of(item.scene, own, whole, **how))

    def add(self, entry: FigureEntry | RowEntry) -> None:
        """Add an entry, in the place of an earlier one of the same figure or row."""
        self.entries[entry.scene, entry.name] = entry

    @property
    def contents(self) -> Findings:
        """All entries, in the order of the papers."""
        there = {scene for scene, _ in self.entries}
        return self.selection({scene: read_paper(scene) for scene in SCENES if scene in there})

    def selection(self, papers: Papers) -> Findings:
        """Return the entries of some figures and rows."""
        keys = [(scene, item.name) for scene, paper in papers.items() for item in paper.items]
        there = [self.entries[key] for key in keys if key in self.entries]
        figures = [item for item in there if isinstance(item, FigureEntry)]
        rows = [item for item in there if isinstance(item, RowEntry)]
        used = list(dict.fromkeys([item.run for item in figures] + [item.run for item in rows]))
        made = self.runs[0]
        return Findings(
            made.versions,
            made.full,
            tuple(replace(item, run=used.index(item.run)) for item in figures),
            tuple(replace(item, run=used.index(item.run)) for item in rows),
            tuple(
                CauseEntry(**vars(cause), scene=scene)
                for scene in papers
                for cause in read_paper(scene).causes
            ),
            tuple(self.runs[i] for i in used),
        )

    def pictures(self, scene: str, figure: PaperFigure) -> list[Path]:
        """Return the files of a figure."""
        return [self.figures / f"{scene}_{figure.number}.{suffix}" for suffix in SUFFIXES]

    def has(self, scene: str, item: PaperFigure | LedgerRow) -> bool:
        """Return True if an item is finished that would be made in the same way again."""
        entry = self.entries.get((scene, item.name))
        if entry is None or entry.failure or self.runs[entry.run].way != self.runs[0].way:
            return False
        paths = self.pictures(scene, item) if isinstance(item, PaperFigure) else []
        return all(path.exists() for path in paths)

    def make(self, scene: str, session: Session, item: PaperFigure | LedgerRow) -> None:
        """Draw a figure or assess a row, and write the document."""
        begin = perf_counter()
        entry: FigureEntry | RowEntry
        if isinstance(item, PaperFigure):
            drawn, failure = attempt(lambda: item.draw(session))
            if not failure:
                save_and_close(drawn, *self.pictures(scene, item), dots=DOTS_PER_INCH)
            entry = FigureEntry.of(scene, item, failure or None, run=0, seconds=0.0)
        else:
            assessment, failure = attempt(lambda: assess(item, session))
            whole = assessment or Assessment(ERROR, failure)
            entry = RowEntry.of(scene, item, whole, run=0, seconds=0.0)
        self.add(replace(entry, seconds=round(perf_counter() - begin, 2)))
        text = json.dumps(self.contents.as_json(), ensure_ascii=False, separators=(",", ":"))
        lines = text.replace('},{"scene"', '},\n{"scene"')  # a figure or a row each
        write_whole(self.file, f"{lines}\n".encode())


# The verb ------------------------------------------------------------------------------------


Progress = Callable[[int, int, str], None]

FIGURE_TIME, SLOW_ROW_TIME = 80.0, 5.0
"""Mean times [s] of a figure and of a row marked as slow, of all papers on two cores."""


@dataclass(frozen=True)
class ReproduceRequest:
    """Which figures and rows of papers are made, and where they go.

    Attributes
    ----------
    scenes : sequence of str
        Whose papers; all by default.
    figure : int or None
        Only this figure, and no rows but those that are named.
    rows : sequence of str
        Only this row of the ledger; may go with --figure.
    out : str or Path
        Folder for pages and figures, which keeps what was there; open index.html in it.
    full : bool
        Maps and runs at full size.
    resume : bool
        Go on with what an interrupted run has left.
    workers : int
        Processes for maps; by default one for each core on the command line, and one in Python.
    progress : callable ``(done, total, what)``, optional
        Called as figures and rows are finished.
    """

    scenes: Annotated[Sequence[str], OptionMark("[SCENE]...", flags=())] = ()
    figure: Annotated[int | None, OptionMark("N")] = None
    rows: Annotated[Sequence[str], OptionMark("NAME")] = ()
    out: Annotated[str | Path, OptionMark("DIR")] = "reproduction"
    full: Annotated[bool, OptionMark()] = False
    resume: Annotated[bool, OptionMark()] = False
    workers: Annotated[int, OptionMark("N", least=1, default=JOBS.default)] = 1
    progress: Progress = lambda done, total, what: None


@takes_fields_of(ReproduceRequest)
def reproduce(request: ReproduceRequest) -> Findings:
    """Draw the figures of papers and judge the rows of their ledgers; takes a `ReproduceRequest`.

    It writes ``findings.json`` and the figures; only ``mbcheck reproduce`` writes the pages. The
    findings are added to those of other calls in the folder. Only a call for whole papers
    computes maps again that are there.

    Raises
    ------
    UsageError
        If a name or a figure is unknown, the folder cannot be written, or matplotlib is not
        installed.
    """
    import_pyplot()
    papers = selected(request)
    made = Made(versions(available()), request.full, date.today().isoformat(), own_commit())
    folder = Folder(Path(request.out), made)
    items = [(scene, item) for scene, paper in papers.items() for item in paper.items]
    items.sort(key=lambda one: isinstance(one[1], LedgerRow))  # figures come before rows
    names = [f"{scene} {item.name}" for scene, item in items]
    done = 0

    def report(words: str) -> None:
        request.progress(done, len(names), f"{names[done]}: {words}")

    session = Session(available(), request.full, request.workers, folder.work, report)
    sessions = {scene: for_scene(session, scene) for scene in papers}
    is_part = request.resume or request.rows or request.figure is not None
    for scene in () if is_part else papers:
        for path in folder.work.glob(f"{scene}_*"):  # its maps are computed again
            path.unlink()
    for done, (scene, item) in enumerate(items):
        request.progress(done, len(names), names[done])
        if not (request.resume and folder.has(scene, item)):
            folder.make(scene, sessions[scene], item)
        request.progress(done + 1, len(names), names[done])
    return folder.selection(papers)


def announced(request: ReproduceRequest) -> str:
    """Return the figures and rows of a request in numbers, and an estimate of their time."""
    papers = selected(request)
    figures = sum(len(paper.figures) for paper in papers.values())
    rows = [row for paper in papers.values() for row in paper.rows]
    seconds = FIGURE_TIME * figures + SLOW_ROW_TIME * sum(row.slow for row in rows)
    about = f"about {words(seconds)}" if seconds else "a few seconds"
    what = f"{plural(figures, 'figure')} and {plural(len(rows), 'row')} of {', '.join(papers)}"
    return f"{what}: {about}{', and hours for maps at full size' if request.full else ''}"


def contents(out: str | Path) -> Findings:
    """Return everything that calls of `reproduce` have found in a folder."""
    return Folder(Path(out), Made(versions(available()))).contents


def selected(request: ReproduceRequest) -> Papers:
    """Return the selected figures and rows; all of the scenes by default.

    Raises
    ------
    UsageError
        If none of the papers has them, or a scene has no paper.
    """
    figure, rows = request.figure, request.rows
    papers = {scene: read_paper(scene) for scene in request.scenes or scenes_with_ledger()}
    for scene, paper in papers.items():
        if not paper.rows:
            own = ", ".join(scenes_with_ledger())
            raise UsageError(f"{scene} has no paper to reproduce; these have one: {own}")
    numbers = sorted({item.number for paper in papers.values() for item in paper.figures})
    if figure is not None and figure not in numbers:
        raise UsageError(f"there is no figure {figure}; there are {', '.join(map(str, numbers))}")
    names = [row.name for paper in papers.values() for row in paper.rows]
    for name in rows:
        if name not in names:
            raise UnknownNameError(f"row of {', '.join(papers)}", name, names)
    if figure is None and not rows:
        return papers
    return {
        scene: PaperData(
            tuple(item for item in paper.figures if item.number == figure),
            tuple(row for row in paper.rows if row.name in rows),
        )
        for scene, paper in papers.items()
    }


def for_scene(session: Session, scene: str) -> Session:
    """Return the session with those engines alone that have a model of a scene."""
    engines = tuple(name for name in session.engines if get_engine(name).models(scene))
    return replace(session, engines=engines)
