"""Tasks in this process or in several, which also do what will probably be asked for next."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

from ...reference.continuation.network import SearchOutcome, Task
from ...reference.errors import EngineError
from ..engines.isolation import Worker, ready

Perform = Callable[[Task], SearchOutcome]


@contextmanager
def executor(workers: int) -> Iterator[Callable[[Perform, Sequence[Task]], SearchOutcome]]:
    """Lend a function that returns the outcome of the first of several tasks, or raises its error.

    Other processes, if there are any, begin the tasks after it meanwhile, in their order. An
    outcome does not depend on the number of processes.
    """
    idle: list[Worker] = []
    busy: dict[Worker, bytes] = {}
    outcomes: dict[bytes, Any] = {}

    def outcome_of_first(perform: Perform, tasks: Sequence[Task]) -> SearchOutcome:
        if workers == 1:
            return perform(tasks[0])
        calls = {pickle.dumps(call): call for call in (partial(perform, one) for one in tasks)}
        first = next(iter(calls))
        needless = [worker for worker, key in busy.items() if key not in calls]
        if first not in (*outcomes, *busy.values()) and len(busy) == workers:
            for worker in needless[:1]:
                worker.end()
                del busy[worker]
        while first not in outcomes:
            for key, call in calls.items():
                if len(busy) < workers and key not in (*outcomes, *busy.values()):
                    worker = idle.pop() if idle else Worker()
                    busy[worker] = key
                    worker.begin(call, None, None)
            for worker in ready(busy):
                outcomes[busy.pop(worker)] = worker.outcome
                idle.extend([worker] if worker.process.is_alive() else [])
        outcome = outcomes.pop(first)
        if isinstance(outcome, EngineError):
            raise outcome
        found: SearchOutcome = outcome
        return found

    try:
        yield outcome_of_first
    finally:
        for worker in (*idle, *busy):
            worker.end()
