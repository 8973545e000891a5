"""Running the ledger: figures drawn, rows assessed, and both kept in the folder once finished."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from datetime import date
from pathlib import Path
from typing import Annotated

from ...reference.errors import UnknownNameError, UsageError
from ..documents.fields import JOBS, OptionMark, takes_fields_of
from ..engines.registry import available, get_engine
from ..queries.environment import own_commit, versions
from ..reports.drawing import import_pyplot
from .claims import PaperData, read_paper, scenes_with_ledger
from .folder import Folder, Papers
from .outcomes import Findings, Made
from .session import Session

Progress = Callable[[int, int, str], None]


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

    The findings are added to those of other calls in the folder. Only a call for whole papers
    computes maps again that are there.

    Raises
    ------
    UsageError
        If a name or a figure is unknown, the folder cannot be written, or matplotlib is not
        installed.
    """
    import_pyplot()
    papers = selected(request.scenes or scenes_with_ledger(), request.figure, request.rows)
    made = Made(versions(available()), request.full, date.today().isoformat(), own_commit())
    folder = Folder(Path(request.out), made)
    figures = [(scene, item) for scene, paper in papers.items() for item in paper.figures]
    rows = [(scene, item) for scene, paper in papers.items() for item in paper.rows]
    names = [f"{scene} figure {item.number}" for scene, item in figures]
    names += [f"{scene} {item.name}" for scene, item in rows]
    done = 0

    def tell_map(name: str, finished: int, total: int) -> None:
        request.progress(done, len(names), f"{names[done]}: map {name} {finished}/{total}")

    session = Session(available(), request.full, request.workers, folder.work, tell_map)
    sessions = {scene: for_scene(session, scene) for scene in papers}
    is_part = request.resume or request.rows or request.figure is not None
    for scene in () if is_part else papers:
        folder.forget_maps(scene)
    for done, (scene, item) in enumerate((*figures, *rows)):
        request.progress(done, len(names), names[done])
        if not (request.resume and folder.has(scene, item)):
            folder.make(scene, sessions[scene], item)
        request.progress(done + 1, len(names), names[done])
    return folder.selection(papers)


def contents(out: str | Path) -> Findings:
    """Return everything that calls of `reproduce` have found in a folder."""
    return Folder(Path(out), Made(versions(available()))).contents


def selected(scenes: Sequence[str], figure: int | None, rows: Collection[str]) -> Papers:
    """Return the selected figures and rows; all of the scenes by default.

    Raises
    ------
    UsageError
        If none of the papers has them, or a scene has no paper.
    """
    papers = {scene: read_paper(scene) for scene in scenes}
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
