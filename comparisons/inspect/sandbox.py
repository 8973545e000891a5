"""Files of strangers: a process with limits of time and memory compiles and inspects them."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from functools import partial
from math import inf
from time import monotonic
from typing import Any, TypeVar

from rich.console import Console

from ...reference.errors import EngineError, MbcheckError
from ..engines.isolation import MEMORY, Worker, await_call, tell, within_limits
from .batch import Inspections, InspectRequest
from .console import print_difference, print_inspection
from .difference import model_difference
from .fixes import neutral_edit
from .inspection import Inspection, inspect, inspection_of
from .pace import Pace, omissions

T = TypeVar("T")

PATIENCE = 600.0
"""Time [s] after which a file is given up."""

BRIEF = 2.0
"""Time [s] that each of several files has before it is stopped, however little there is."""

GRACE = 5.0
"""Time [s] after `--budget` at which what still goes on is stopped."""


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

    Attributes
    ----------
    pace : Pace
        The time for all files; it is told how far they are.
    grace : float
        Time [s] after the end of it at which what still goes on is stopped.
    report : FileReport or None
        What work that was stopped had found until then.
    """

    def __init__(self, pace: Pace, grace: float = GRACE) -> None:
        self.pace, self.grace = pace, grace
        self.worker: Worker | None = None
        self.report: FileReport | None = None
        self.part, self.alone = "", False

    def close(self) -> None:
        """End the process."""
        if self.worker is not None:
            self.worker.end()

    def run(self, work: Callable[[float], T], alone: bool = False) -> T:
        """Return the result of work on a file, which is given the time that it may take [s].

        Work on one file ``alone`` may take all the time that there is, else half of it, so that
        none takes all from the others.

        Raises
        ------
        EngineError
            If it was stopped, or took its process down.
        MbcheckError
            That the work raised.
        """
        budget = self.pace.remaining().budget
        most = budget + self.grace
        if not alone:
            budget /= 2
            most = min(max(1.25 * budget, BRIEF), self.pace.end - monotonic() + self.grace)
        most = PATIENCE if budget == inf else most
        if most <= 0:
            raise EngineError("timeout", "not inspected: the time was up")
        self.report, self.part, self.alone = None, "", alone
        if self.worker is None or not self.worker.process.is_alive():
            self.worker = Worker()
            self.worker.heard = self.hear
        with within_limits(most, MEMORY):
            outcome = await_call(self.worker, partial(in_folder, os.getcwd(), work, budget), most)
        if isinstance(outcome, EngineError):
            message = outcome.message
            if outcome.kind == "timeout" and budget < inf:
                message = f"stopped: the time of --budget was up, {budget:.3g} s for this file"
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
                self.pace.progress(*message)


def in_folder(folder: str, work: Callable[[float], T], budget: float) -> T | MbcheckError:
    """Return the result of work in a folder, or the error of mbcheck's own that it raises."""
    os.chdir(folder)
    try:
        return work(budget)
    except MbcheckError as error:
        return error


# What is done in the process ------------------------------------------------------------------


def inspect_file(
    file: str, request: InspectRequest, options: Mapping[str, Any], screen: Screen, budget: float
) -> FileReport:
    """Inspect a file; tell what is found so far."""

    def report_of(result: Inspection) -> FileReport:
        report = partial(
            print_inspection,
            inspection=result,
            full=options["full"],
            fail_on=options["fail_on"],
        )
        return result.as_json(), text_on(screen, report)

    pace = Pace(
        budget,
        lambda *part: tell(part),
        checkpoint=lambda *so_far: tell(report_of(inspection_of(file, *so_far))),
    )
    asked = options["rotation"], options["modes"], request.strict, request.selection(file)
    return report_of(inspect(file, *asked, pace))


def fix(file: str, request: InspectRequest, dry_run: bool, budget: float) -> tuple[str, str, bool]:
    """Leave out what a file does without; return the edit, a summary, and if there is any edit."""
    pace = Pace(budget, lambda *part: tell(part))
    selection = request.fixing().selection(file)
    edit = neutral_edit(inspect(file, modes=False, selection=selection, pace=pace))
    if not dry_run:
        edit.write()
    left = omissions(pace.left_out)
    return edit.diff, edit.summary + (f"\n{file}: {left}" if left else ""), bool(edit.attributes)


def compare_models(
    files: Sequence[str], request: InspectRequest, modes: bool | None, screen: Screen, budget: float
) -> tuple[str, bool, list[str]]:
    """Return a table of differences, if fields differ, and the severities of new findings."""
    pace = Pace(budget, lambda *part: tell(part))
    old, new = (
        inspect(name, None, modes, request.strict, request.selection(name), pace) for name in files
    )
    result = model_difference(old, new)
    text = text_on(screen, partial(print_difference, result=result))
    return text, bool(result.rows), [one.severity for one in result.new]


# Many files -----------------------------------------------------------------------------------


def inspect_files(
    files: Sequence[str],
    work: Callable[[str], Callable[[float], FileReport]],
    pace: Pace,
    grace: float = GRACE,
) -> tuple[Inspections, list[str]]:
    """Inspect files one after the other; one that cannot be read does not end the others.

    Parameters
    ----------
    files : sequence of str
    work : callable
        From a file to what inspects it.
    pace : Pace
        The time for all of them; it is told which file is next.
    grace : float
        As of `Sandbox`.

    Returns
    -------
    Inspections, and the reports of its models.
    """
    every, unreadable = list[FileReport](), dict[str, str]()
    with closing(Sandbox(pace, grace)) as sandbox:
        for number, file in enumerate(files):
            if len(files) > 1:
                pace.progress(number, len(files), file)
            try:
                every.append(sandbox.run(work(file), len(files) == 1))
            except MbcheckError as error:
                ended = error.kind if isinstance(error, EngineError) else ""
                report = sandbox.report if ended else None  # a user's slip has none
                every += [report] if report else []
                if not (report and ended == "timeout"):
                    unreadable[file] = str(error)
    return Inspections(tuple(model for model, _ in every), unreadable), [text for _, text in every]
