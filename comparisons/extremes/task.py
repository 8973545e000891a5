"""A task of the extremes: what one worker process does at a time."""

from collections.abc import Callable
from typing import NamedTuple

from .row import Row


class Task(NamedTuple):
    """One extreme of one scene by one engine, ready for a process of its own.

    Attributes
    ----------
    section : str
        Section of the extremes: ``limits``, ``parameters``, ``starts``, ``long`` or ``failures``.
    scene : str
        Scene of the task.
    name : str
        What is told of it while it runs, and in the row of a task that died.
    engine : str
        Engine of the task.
    call : callable
        No arguments, gives the rows; picklable (a module's function or a partial of one with plain
        arguments), for a worker process calls it.
    """

    section: str
    scene: str
    name: str
    engine: str
    call: Callable[[], list[Row]]
