"""Tasks in this process or in several, which also do what will probably be asked for next."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

from ...reference.continuation.network import SearchOutcome, Task, following
from ...reference.errors import EngineError
from ..engines.isolation import Worker, ready

Perform = Callable[[Task], SearchOutcome]


@contextmanager
def executor(workers: int) -> Iterator[Callable[[Perform, Sequence[Task]], SearchOutcome]]:
    """Lend what returns the outcome of the first of several tasks; the others may be asked for.

    An outcome does not depend on the number of processes.
    """
    if workers == 1:
        yield lambda perform, tasks: perform(tasks[0])
        return
    crew = Crew(workers)
    try:
        yield crew.outcome_of_first
    finally:
        crew.end()


class Crew:
    """Processes that do tasks in the order in which they will probably be asked for.

    Attributes
    ----------
    workers : int
        How many at most.
    """

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self.idle: list[Worker] = []
        self.busy: dict[Worker, bytes] = {}
        self.outcomes: dict[bytes, Any] = {}

    def outcome_of_first(self, perform: Perform, tasks: Sequence[Task]) -> SearchOutcome:
        """Return what the first task leads to; begin the others while there are idle processes.

        Raises
        ------
        EngineError
            If it fails.
        """
        calls = self.calls(perform, tasks)
        first = next(iter(calls))
        needless = [worker for worker, key in self.busy.items() if key not in calls]
        if first not in (*self.outcomes, *self.busy.values()) and len(self.busy) == self.workers:
            for worker in needless[:1]:
                worker.end()
                del self.busy[worker]
        while first not in self.outcomes:
            for key, call in calls.items():
                self.begin(key, call)
            for worker in ready(self.busy):
                self.outcomes[self.busy.pop(worker)] = worker.outcome
                if worker.process.is_alive():
                    self.idle.append(worker)
            calls = self.calls(perform, tasks)
        outcome = self.outcomes.pop(first)
        if isinstance(outcome, EngineError):
            raise outcome
        return outcome

    def calls(self, perform: Perform, tasks: Sequence[Task]) -> dict[bytes, Any]:
        """Return what performs tasks, and after them what those done ahead have led to."""
        known = [item for item in self.outcomes.values() if isinstance(item, SearchOutcome)]
        begun = following(one for item in known for one in item.starts if one.may_bound)
        calls = [partial(perform, one) for one in (*tasks, *begun)]
        return {pickle.dumps(call): call for call in calls}

    def begin(self, key: bytes, call: Callable[[], SearchOutcome]) -> None:
        """Begin a task that is not begun yet, if a process is idle."""
        known = key in self.outcomes or key in self.busy.values()
        if not known and len(self.busy) < self.workers:
            worker = self.idle.pop() if self.idle else Worker()
            self.busy[worker] = key
            worker.begin(call, None, None)

    def end(self) -> None:
        """End all processes."""
        for worker in (*self.idle, *self.busy):
            worker.end()
