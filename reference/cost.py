"""Budget of time: the cost of a computation is predicted while it runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np

from .errors import UsageError

LOOKED = 5.0
"""Time [s] after which the rest of a run is foretold from how far it is."""

MANY = 100_000
"""Steps of an engine that are not taken before the time of one is known."""

EVERY = 16
"""Calls of a right-hand side between two looks at the clock."""

UNITS = (("years", 31557600.0), ("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0))

Progress = Callable[[float, float], None]


@dataclass
class Budget:
    """The time that a computation may take.

    Attributes
    ----------
    seconds : float
        Wall time [s].
    progress : callable ``(share, 1.0)``, optional
        Told how far a run is.
    end : float or None
        When the run of one trajectory ends [s of its own time]; None for anything else.
    """

    seconds: float
    progress: Progress | None = None
    end: float | None = None
    begun: float = field(default_factory=perf_counter)
    farthest: float = 0.0
    since: float = field(default_factory=perf_counter)

    @property
    def left(self) -> float:
        """Remaining time [s]."""
        return self.begun + self.seconds - perf_counter()

    def foretell(self, seconds: float) -> None:
        """Refuse what would take so much longer.

        Raises
        ------
        UsageError
            With the estimate.
        """
        if not seconds <= self.left:
            all_in_all = words(self.seconds - self.left + seconds)
            about = "would take about" if seconds else "has not ended after"
            raise UsageError(
                f"this {about} {all_in_all}, and its budget is {words(self.seconds)}: ask for "
                "less, choose other parameters, or give it more seconds (--budget)"
            )

    def look(self, time: Any) -> None:
        """Foretell the rest of a run that has come to a time [s].

        Raises
        ------
        UsageError
        """
        now = perf_counter()
        time = float(np.max(np.real(time)))
        if self.end:
            if time < 0.5 * self.farthest:  # another run over the same time
                self.farthest, self.since = 0.0, now
            self.farthest = max(self.farthest, time)
            share, elapsed = self.farthest / self.end, now - self.since
            if elapsed > LOOKED:
                self.foretell(elapsed * (1 / share - 1) if share else np.inf)
                if self.progress:
                    self.progress(share, 1.0)
        self.foretell(0.0)

    def watch(self, derivative: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
        """Return a right-hand side that looks at the clock now and then."""
        calls = 0

        def watched(t: Any, x: Any) -> Any:
            nonlocal calls
            calls += 1
            if calls % EVERY == 0:
                self.look(t)
            return derivative(t, x)

        return watched


BUDGET: ContextVar[Budget | None] = ContextVar("budget", default=None)


@contextmanager
def within(seconds: float, progress: Progress | None = None) -> Iterator[None]:
    """Refuse a computation as soon as it is predicted to take longer than a time [s].

    It is ``mbcheck.budget``: ``with mbcheck.budget(60): ...`` holds for the reference, for engines
    and for the processes of both, whichever function of the package is called, in the thread that
    has entered it. One within another lasts no longer than that.

    Raises
    ------
    UsageError
        If the time is no positive number; and from the computation, with an estimate where one
        exists.
    """
    if not 0 < seconds < np.inf:
        raise UsageError(f"the budget must be finite and greater than 0, not {seconds:g}")
    outer = time_left()
    if outer is not None:
        keep_budget(1.0)
        seconds = min(seconds, outer)
    token = BUDGET.set(Budget(seconds, progress))
    try:
        yield
    finally:
        BUDGET.reset(token)


def watched(derivative: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    """Return a right-hand side that keeps the budget, if there is one."""
    budget = BUDGET.get()
    return derivative if budget is None else budget.watch(derivative)


@contextmanager
def expected_end(time: float) -> Iterator[None]:
    """Foretell the runs within by how far they are on their way to this time [s]."""
    budget = BUDGET.get()
    if budget is None:
        yield
        return
    budget.end, budget.farthest, budget.since = time, 0.0, perf_counter()
    try:
        yield
    finally:
        budget.end = None  # of what comes next nothing is known


def keep_steps(steps: float, seconds: Callable[[], float]) -> None:
    """Refuse so many steps beyond the budget, if there is one.

    Parameters
    ----------
    steps : float
    seconds : callable
        Measures how long a step takes [s]; called where there are `MANY` steps or more.

    Raises
    ------
    UsageError
    """
    budget = BUDGET.get()
    if budget is not None and steps > MANY:
        budget.foretell(steps * seconds())


def keep_budget(share: float) -> None:
    """Refuse a computation that will exceed the budget, if there is one, by its finished share.

    A share of 1 refuses only what has exceeded it.

    Raises
    ------
    UsageError
    """
    budget = BUDGET.get()
    if budget is not None:
        elapsed = perf_counter() - budget.begun
        budget.foretell(elapsed * (1 / share - 1))


def time_left() -> float | None:
    """Return the remaining budget [s], 0 if it is over; None if there is none."""
    budget = BUDGET.get()
    return None if budget is None else max(budget.left, 0.0)


def words(seconds: float) -> str:
    """Return a time in the unit that suits it."""
    for unit, size in UNITS:
        if seconds >= size:
            count = f"{seconds / size:.2g}"
            return f"{count} {unit.removesuffix('s') if count == '1' else unit}"
    return f"{seconds:.2g} s"
