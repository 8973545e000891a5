"""Files of strangers: a process with limits of time and memory compiles and inspects them."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import inf
from time import monotonic
from typing import Any, TypeVar

from rich.console import Console

from ...reference.errors import EngineError, MbcheckError, UsageError
from ..engines.isolation import MEMORY, Worker, await_call, tell, within_limits
from .batch import Inspections
from .console import print_inspection
from .fixes import neutral_edit
from .inspection import Inspection, inspect_in_parts
from .request import InspectRun

T = TypeVar("T")

PATIENCE = 600.0
"""Time [s] after which a file is given up."""

BRIEF = 2.0
"""Time [s] that a file has at least, once it is begun."""

OFTEN = 0.5
"""Time [s] between two reports of what is found so far, while rules are asked."""

FileReport = tuple[dict[str, Any], str]
"""The ``inspect`` document of a file, and its report."""

Screen = Mapping[str, Any]
"""What a report is written for: arguments of rich's console."""


def text_on(screen: Screen, printer: Callable[[Console], None]) -> str:
    """Return the text that a function prints."""
    written = io.StringIO()
    printer(Console(file=written, highlight=False, **screen))
    return written.getvalue()


class Sandbox:
    """A process that does work on one file after the other; another one follows if it ends.

    Parameters
    ----------
    budget : float, optional
        Time [s] for all files, after which what still goes on is stopped.
    progress : callable, optional
        Is told how many parts are done, of how many, and which is next.

    Attributes
    ----------
    report : FileReport or None
        What work that was stopped had found until then.
    """

    def __init__(
        self, budget: float = inf, progress: Callable[..., None] = lambda *_: None
    ) -> None:
        if not budget > 0:
            raise UsageError(f"--budget must be a positive number, not {budget:g}")
        self.end, self.progress = monotonic() + budget, progress
        self.worker: Worker | None = None
        self.report: FileReport | None = None
        self.part, self.alone = "", False

    def close(self) -> None:
        """End the process."""
        if self.worker is not None:
            self.worker.end()

    def run(self, work: Callable[[], T], alone: bool = False) -> T:
        """Return the result of work on a file.

        Work on one file ``alone`` may take all the time that there is, else half of it, so that
        none takes all from the others.

        Raises
        ------
        EngineError
            If it was stopped, or took its process down.
        MbcheckError
            That the work raised.
        """
        left = self.end - monotonic()
        if left <= 0:
            raise EngineError("timeout", "not inspected: the time was up")
        most = PATIENCE if left == inf else max(BRIEF, left if alone else left / 2)
        self.report, self.part, self.alone = None, "", alone
        if self.worker is None or not self.worker.process.is_alive():
            self.worker = Worker()
            self.worker.heard = self.hear
        with within_limits(most, MEMORY):
            outcome = await_call(self.worker, partial(in_folder, os.getcwd(), work), most)
        if isinstance(outcome, EngineError):
            message = outcome.message
            if outcome.kind == "timeout" and left < inf:
                message = f"stopped: the time of --budget was up, {most:.3g} s for this file"
            raise EngineError(outcome.kind, f"{message}; it was at: {self.part}")
        if isinstance(outcome, MbcheckError):
            raise outcome
        return outcome

    def hear(self, message: Any) -> None:
        """Take the part that is next, or what is found so far."""
        if len(message) == 2:
            self.report = message
        else:
            self.part = message[-1]
            if self.alone:
                self.progress(*message)


def in_folder(folder: str, work: Callable[[], T]) -> T | MbcheckError:
    """Return the result of work in a folder, or the error of mbcheck's own that it raises."""
    os.chdir(folder)
    try:
        return work()
    except MbcheckError as error:
        return error


# What is done in the process ------------------------------------------------------------------


def inspect_file(run: InspectRun, screen: Screen) -> FileReport:
    """Inspect a file; tell what is found so far, now and then."""

    def report_of(result: Inspection) -> FileReport:
        report = partial(print_inspection, inspection=result, full=run.full, fail_on=run.fail_on)
        return result.as_json(), text_on(screen, report)

    last_report, total = monotonic(), 0
    tell((0, 1, f"MuJoCo compiles {os.path.basename(run.path)}"))
    for left, inspection in inspect_in_parts(run):
        total = max(total, len(left))
        for part in left[:1]:
            tell((total - len(left), total, part))
            if not part.startswith("rule ") or monotonic() > last_report + OFTEN:
                tell(report_of(inspection()))
                last_report = monotonic()
    return report_of(inspection())


def fix(run: InspectRun) -> tuple[str, str, bool]:
    """Leave out what a file does without; return the edit, a summary, and if there is any edit."""
    edit = neutral_edit(run)
    if not run.dry_run:
        edit.write()
    return edit.diff, edit.summary, bool(edit.attributes)


# Many files -----------------------------------------------------------------------------------


def inspect_files(
    files: Sequence[str], work: Callable[[str], Callable[[], FileReport]], sandbox: Sandbox
) -> tuple[Inspections, list[str]]:
    """Inspect files one after the other; one that cannot be read does not end the others.

    Parameters
    ----------
    files : sequence of str
    work : callable
        From a file to what inspects it.
    sandbox : Sandbox
        Its progress is told which file is next.

    Returns
    -------
    Inspections, and the reports of its models.
    """
    every, unreadable = list[FileReport](), dict[str, str]()
    for number, file in enumerate(files):
        if len(files) > 1:
            sandbox.progress(number, len(files), file)
        try:
            every.append(sandbox.run(work(file), len(files) == 1))
        except MbcheckError as error:
            ended = error.kind if isinstance(error, EngineError) else ""
            report = sandbox.report if ended else None  # a user's slip has none
            every += [report] if report else []
            if not (report and ended == "timeout"):
                unreadable[file] = str(error)
    return Inspections(tuple(model for model, _ in every), unreadable), [text for _, text in every]
