"""The folder that ``mbcheck reproduce`` writes to: what it holds, and what a run adds to that."""

from __future__ import annotations

import json
import logging
import shutil
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import msgspec

from ...reference import SCENES
from ...reference.errors import UsageError
from ..reports.drawing import save_and_close
from ..reports.files import write_whole
from .assess import Assessment, assess, attempt
from .claims import PaperData, read_paper
from .ledger import ERROR, LedgerRow, PaperFigure
from .outcomes import CauseEntry, FigureEntry, Findings, Made, RowEntry
from .session import Session

FINDINGS, FIGURES = "findings.json", "figures"
"""What is found, the ``reproduce`` document of docs/json.md, which the pages show; pictures."""
WORK = ".mbcheck"
"""Folder of maps that an interrupted run goes on with."""
SUFFIXES = ("png", "svg")
DOTS_PER_INCH = 229
"""Of pictures, which are then 1,600 points wide."""

LOG = logging.getLogger(__name__)

Papers = Mapping[str, PaperData]
"""Papers, or what is selected of them, by scene."""


class Folder:
    """What an output folder holds, and what takes its place there.

    Attributes
    ----------
    file, figures, work : Path
        What is found, pictures, and maps.
    runs : list of Made
        How things were made; the first is how this run makes what it adds.
    drawn, assessed : dict by (scene, number) and by (scene, row's name)
    """

    def __init__(self, out: Path, made: Made) -> None:
        self.file, self.figures, self.work = out / FINDINGS, out / FIGURES, out / WORK
        self.runs = [made]
        self.drawn: dict[tuple[str, int], FigureEntry] = {}
        self.assessed: dict[tuple[str, str], RowEntry] = {}
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

    def _take(self, found: Findings) -> None:
        """Take what a document has of the figures and rows that the papers have now."""
        self.runs += [one for one in found.runs if one not in self.runs]
        for item in found.entries:
            paper = read_paper(item.scene) if item.scene in SCENES else PaperData()
            how = {"run": self.runs.index(found.runs[item.run]), "seconds": item.seconds}
            if isinstance(item, FigureEntry):
                for figure in paper.figures:
                    if figure.number == item.number:
                        self._add_figure(item.scene, figure, item.error, **how)
                continue
            for row in paper.rows:
                if row.name == item.name:
                    parts = {one.name: getattr(item, one.name) for one in fields(Assessment)}
                    whole = assess(row, Session()) if row.is_text else Assessment(**parts)
                    self.assessed[item.scene, row.name] = RowEntry.of(item.scene, row, whole, **how)

    def _add_figure(self, scene: str, figure: PaperFigure, error: str | None, **how: Any) -> None:
        self.drawn[scene, figure.number] = FigureEntry(
            scene, figure.number, figure.title, figure.caption, error, **how
        )

    def forget_maps(self, scene: str) -> None:
        """Remove the maps of a scene, so that they are computed again."""
        for path in self.work.glob(f"{scene}_*"):
            if path.is_dir():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink()

    @property
    def contents(self) -> Findings:
        """Return all that is there, in the order of the papers."""
        there = {scene for scene, _ in (*self.drawn, *self.assessed)}
        return self.selection({scene: read_paper(scene) for scene in SCENES if scene in there})

    def selection(self, papers: Papers) -> Findings:
        """Return what there is of figures and rows."""
        figures = [
            self.drawn[scene, one.number]
            for scene, paper in papers.items()
            for one in paper.figures
            if (scene, one.number) in self.drawn
        ]
        rows = [
            self.assessed[scene, one.name]
            for scene, paper in papers.items()
            for one in paper.rows
            if (scene, one.name) in self.assessed
        ]
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

    def save(self) -> None:
        """Write what is found."""
        text = json.dumps(self.contents.as_json(), ensure_ascii=False, separators=(",", ":"))
        lines = text.replace('},{"scene"', '},\n{"scene"')  # a figure or a row each
        write_whole(self.file, f"{lines}\n".encode())

    def has(self, entry: FigureEntry | RowEntry | None) -> bool:
        """Return whether something is finished that would be made in the same way again."""
        return bool(entry and not entry.failed and self.runs[entry.run].way == self.runs[0].way)

    def draw(self, scene: str, session: Session, figure: PaperFigure, resume: bool) -> None:
        """Draw a figure, unless an interrupted run has."""
        key = scene, figure.number
        paths = [self.figures / f"{scene}_{figure.number}.{suffix}" for suffix in SUFFIXES]
        if resume and self.has(self.drawn.get(key)) and all(path.exists() for path in paths):
            return
        begin = perf_counter()
        drawn, failure = attempt(lambda: figure.draw(session))
        if not failure:
            save_and_close(drawn, *paths, dots=DOTS_PER_INCH)
        seconds = round(perf_counter() - begin, 2)
        self._add_figure(scene, figure, failure or None, run=0, seconds=seconds)
        self.save()

    def assess(self, scene: str, session: Session, row: LedgerRow, resume: bool) -> None:
        """Assess a row, unless an interrupted run has."""
        key = scene, row.name
        if resume and self.has(self.assessed.get(key)):
            return
        begin = perf_counter()
        assessment, failure = attempt(lambda: assess(row, session))
        how = {"run": 0, "seconds": round(perf_counter() - begin, 2)}
        own = assessment or Assessment(ERROR, failure)
        self.assessed[key] = RowEntry.of(scene, row, own, **how)
        self.save()
