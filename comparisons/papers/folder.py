"""The folder that ``mbcheck reproduce`` writes to: what it holds, and what a run adds to that."""

from __future__ import annotations

import json
import logging
import shutil
from collections.abc import Callable, Mapping
from dataclasses import fields
from pathlib import Path
from time import perf_counter
from typing import Any

from ...reference import SCENES
from ...reference.errors import UsageError
from ..reports.drawing import save_and_close
from ..reports.files import write_whole
from .assess import Assessment, RowThreshold, assess, attempt
from .ledger import ERROR, LedgerRow, PaperFigure
from .outcomes import FigureOutcome, Made, Reproduction, RowOutcome
from .session import Session

FINDINGS, FIGURES = "findings.json", "figures"
"""What is found, the ``reproduce`` document of docs/json.md, which the pages show; pictures."""
WORK = ".mbcheck"
"""Folder of maps that an interrupted run goes on with."""
SUFFIXES = ("png", "svg")
DOTS_PER_INCH = 229
"""Of pictures, which are then 1,600 points wide."""

LOG = logging.getLogger(__name__)

Paper = tuple[tuple[PaperFigure, ...], tuple[LedgerRow, ...]]


class Folder:
    """What an output folder holds, and what takes its place there.

    Attributes
    ----------
    file, figures, work : Path
        What is found, pictures, and maps.
    tables : callable ``(scene) -> Paper``
        Figures and rows of a scene's paper.
    made : Made
        How this run makes what it adds.
    drawn, assessed : dict by (scene, number) and by (scene, row's name)
    """

    def __init__(self, out: Path, tables: Callable[[str], Paper], made: Made) -> None:
        self.file, self.figures, self.work = out / FINDINGS, out / FIGURES, out / WORK
        self.tables, self.made = tables, made
        self.drawn: dict[tuple[str, int], FigureOutcome] = {}
        self.assessed: dict[tuple[str, str], RowOutcome] = {}
        try:
            for path in (self.figures, self.work):
                path.mkdir(parents=True, exist_ok=True)
            self._refresh_work()
            text = self.file.read_text("utf-8", "replace") if self.file.exists() else "{}"
        except OSError as error:
            raise UsageError(f"--out: cannot write {str(out)!r}: {error.strerror}") from None
        try:
            self._take(json.loads(text))
        except (ValueError, LookupError, TypeError, RecursionError):
            LOG.warning("Warning: %s is damaged, or another document: replaced", self.file)

    def _refresh_work(self) -> None:
        """Remove the maps of other versions, and remember which these are."""
        stamp, now = self.work / "versions.json", json.dumps(self.made.versions)
        if not stamp.exists() or stamp.read_text("utf-8", "replace") != now:
            shutil.rmtree(self.work)
            self.work.mkdir()
            stamp.write_text(now, "utf-8")

    def _take(self, document: Mapping[str, Any]) -> None:
        """Take what a document has of the figures and rows that the papers have now."""
        runs = [Made(one["versions"], one["full"]) for one in document.get("runs", ())]
        items = [*document.get("figures", ()), *document.get("rows", ())]
        known = {item["scene"] for item in items}.intersection(SCENES)
        papers = {scene: self.tables(scene) for scene in known}
        figures = {(scene, one.number): one for scene in papers for one in papers[scene][0]}
        rows = {(scene, one.name): one for scene in papers for one in papers[scene][1]}
        for item in items:
            made = runs[item["run"]].within(item["seconds"])
            scene = item["scene"]
            if figure := figures.get((scene, item.get("number"))):
                self.drawn[scene, figure.number] = FigureOutcome(figure, item["error"] or "", made)
            if row := rows.get((scene, item.get("name"))):
                parts = {one.name: item[one.name] for one in fields(Assessment) if one.name in item}
                parts["candidates"] = tuple((name, text) for name, text in parts["candidates"])
                parts["thresholds"] = tuple(RowThreshold(**one) for one in parts["thresholds"])
                whole = assess(row, Session()) if row.is_text else Assessment(**parts)
                self.assessed[scene, row.name] = RowOutcome(row, whole, made)

    def forget_maps(self, scene: str) -> None:
        """Remove the maps of a scene, so that they are computed again."""
        for path in self.work.glob(f"{scene}_*"):
            if path.is_dir():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink()

    @property
    def contents(self) -> Reproduction:
        """Return all that is there, in the order of the papers."""
        there = {scene for scene, _ in (*self.drawn, *self.assessed)}
        return self.selection({scene: self.tables(scene) for scene in SCENES if scene in there})

    def selection(self, papers: Mapping[str, Paper]) -> Reproduction:
        """Return what there is of figures and rows."""
        return Reproduction(
            {
                scene: tuple(
                    self.drawn[scene, item.number]
                    for item in figures
                    if (scene, item.number) in self.drawn
                )
                for scene, (figures, _) in papers.items()
            },
            {
                scene: tuple(
                    self.assessed[scene, row.name]
                    for row in rows
                    if (scene, row.name) in self.assessed
                )
                for scene, (_, rows) in papers.items()
            },
            self.made.full,
            self.made.versions,
        )

    def save(self) -> None:
        """Write what is found."""
        text = json.dumps(self.contents.as_json(), ensure_ascii=False, separators=(",", ":"))
        lines = text.replace('},{"scene"', '},\n{"scene"')  # a figure or a row each
        write_whole(self.file, f"{lines}\n".encode())

    def has(self, outcome: FigureOutcome | RowOutcome | None) -> bool:
        """Return whether something is finished that would be made in the same way again."""
        return bool(outcome and not outcome.failed and outcome.made.run == self.made.run)

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
        made = self.made.within(perf_counter() - begin)
        self.drawn[key] = FigureOutcome(figure, failure, made)
        self.save()

    def assess(self, scene: str, session: Session, row: LedgerRow, resume: bool) -> None:
        """Assess a row, unless an interrupted run has."""
        key = scene, row.name
        if resume and self.has(self.assessed.get(key)):
            return
        begin = perf_counter()
        assessment, failure = attempt(lambda: assess(row, session))
        made = self.made.within(perf_counter() - begin)
        self.assessed[key] = RowOutcome(row, assessment or Assessment(ERROR, failure), made)
        self.save()
