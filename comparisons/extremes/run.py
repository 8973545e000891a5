"""``mbcheck extremes``: all sections together, each task in a process of its own."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from ...reference.errors import EngineError, UnknownNameError
from ..documents import document
from ..documents.fields import HIDDEN, documented
from ..engines.isolation import MEMORY, isolated
from ..engines.registry import resolve_selection
from ..queries.environment import versions
from . import limits
from .cases import extreme_tasks, failure_tasks
from .long_runs import follow
from .row import ENGINE, OUTCOMES, SECTIONS, Provocation, Row

LIMIT = 240.0
"""What a task may take [s]."""

ABOUT: Mapping[str, str] = {
    "limits": "Stability limits, result by bisection, beside the theory of the method",
    "parameters": "Parameters at their extremes, by a step that suits them, and by the usual one",
    "starts": "Starts that ask for trouble",
    "long": "Long horizons: what drifts, and what the method predicts",
    "failures": "Failures, provoked for real",
}

TASKS: Mapping[str, tuple[Callable[..., list[Provocation]], ...]] = {
    "limits": (limits.tasks,),
    "parameters": (partial(extreme_tasks, "parameters"), partial(failure_tasks, "parameters")),
    "starts": (partial(extreme_tasks, "starts"),),
    "long": (follow.tasks,),
    "failures": (partial(failure_tasks, "failures"),),
}
"""What makes the tasks of a section."""

Progress = Callable[[int, int, str], None]


def tasks(
    scenes: tuple[str, ...], engines: tuple[str, ...], sections: Sequence[str], full: bool
) -> list[Provocation]:
    """Return the tasks of these sections, all if none are named.

    Raises
    ------
    UnknownNameError
        For an unknown section.
    """
    for name in sections:
        if name not in SECTIONS:
            raise UnknownNameError("section", name, SECTIONS)
    return [
        task
        for name in SECTIONS
        if name in (sections or SECTIONS)
        for tasks_of in TASKS[name]
        for task in tasks_of(scenes, engines, full)
    ]


@dataclass
class Extremes:
    """The extremes table; filled by `work`.

    Attributes
    ----------
    tasks : list of Task
    engines : tuple of str
    full : bool
        whether `--full` was given
    rows_of : dict of int to list of Row
        By place of the task.
    """

    tasks: list[Provocation] = field(metadata=HIDDEN)
    engines: tuple[str, ...] = field(metadata=HIDDEN)
    full: bool
    rows_of: dict[int, list[Row]] = field(default_factory=dict, metadata=HIDDEN)

    @classmethod
    def asked(
        cls,
        scenes: Sequence[str] = (),
        engines: Sequence[str] = (),
        sections: Sequence[str] = (),
        full: bool = False,
    ) -> Extremes:
        """Return what is asked for, to be filled by `work`; see `extremes`."""
        where, who = resolve_selection(scenes, engines)
        return cls(tasks(where, who, sections, full), who, full)

    def work(self, jobs: int) -> Iterator[tuple[int, int, str]]:
        """Do the tasks in so many processes; tell how far it is."""
        calls = [task.call for task in self.tasks]
        for place, rows in isolated(calls, jobs, LIMIT, MEMORY):
            task = self.tasks[place]
            self.rows_of[place] = [lost(task, rows)] if isinstance(rows, EngineError) else rows
            yield len(self.rows_of), len(calls), f"{task.section} {task.scene} {task.name}"

    @property
    @documented
    def versions(self) -> dict[str, str]:
        """Versions of mbcheck, numpy, scipy and of the engines that took part, by name."""
        return versions(self.engines)

    @property
    @documented
    def rows(self) -> list[Row]:
        """In the order of sections, scenes and tasks."""
        return [row for place in sorted(self.rows_of) for row in self.rows_of[place]]

    @property
    @documented
    def summary(self) -> dict[str, int]:
        """Number of rows by outcome: right, wrong, failed, refused, skipped."""
        counts = Counter(row.outcome for row in self.rows)
        return {outcome: counts[outcome] for outcome in OUTCOMES}

    @property
    def lost(self) -> list[Row]:
        """The rows of tasks that died."""
        return [row for row in self.rows if not row.model]

    def as_json(self) -> dict[str, Any]:
        """Return the ``extremes`` document of docs/json.md."""
        return document("extremes", self)


def lost(task: Provocation, error: EngineError) -> Row:
    """Return the row of a task that died."""
    reason = f"{error.kind}: {error.message}"
    who = (task.section, task.scene, task.name, task.engine)
    return Row(*who, model="", noticed_by=(ENGINE,), reason=reason)


def extremes(
    scenes: Sequence[str] = (),
    engines: Sequence[str] = (),
    sections: Sequence[str] = (),
    full: bool = False,
    jobs: int = 1,
    progress: Progress | None = None,
) -> Extremes:
    """Push engines to where they break, and tell who notices.

    Parameters
    ----------
    scenes, engines, sections : sequence of str
        All, if empty.
    full : bool
        Longer horizons and more extremes.
    jobs : int
        Processes.
    progress : callable ``(done, total, what)``, optional

    Raises
    ------
    UsageError
        For unknown names, or an engine that cannot be imported.
    """
    result = Extremes.asked(scenes, engines, sections, full)
    for state in result.work(jobs):
        if progress:
            progress(*state)
    return result
