"""How long an inspection may take: what it leaves out when its time is up, and its progress."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf
from time import monotonic
from typing import Any

from ...reference.errors import UsageError

LEAST = 1e-9
"""Time [s] that is none."""

OFTEN = 1.0
"""Time [s] between two checkpoints."""

UP = "the time was up"
"""Why something was left out."""


def has_unasked_rules(left_out: Sequence[str]) -> bool:
    """Return True if there was no time for a rule."""
    return any(part.startswith("rule ") for part in left_out)


def omissions(left_out: Sequence[str]) -> str:
    """Return in words what was left out; empty if nothing was."""
    rules = [part.removeprefix("rule ") for part in left_out if part.startswith("rule ")]
    others = [part for part in left_out if not part.startswith("rule ")]
    others += [f"the rules {', '.join(rules)}"] if rules else []
    return f"{UP}, and left out are {'; '.join(others)}" if others else ""


def unseen(done: int, total: int, now: str) -> None:
    """Show nothing."""


@dataclass
class Pace:
    """The time that is left, asked between the parts of an inspection.

    Attributes
    ----------
    budget : float
        Time [s] after which no part is begun.
    progress : callable
        Is told how many parts are done, of how many, and which is next.
    left_out : list of str
        Parts for which there was no time.
    checkpoint : callable or None
        Is given a model and its findings so far, to outlive a process that is stopped.
    """

    budget: float = inf
    progress: Callable[[int, int, str], None] = unseen
    left_out: list[str] = field(default_factory=list)
    checkpoint: Callable[[Any, Any], None] | None = None
    done: int = 0
    total: int = 0

    def __post_init__(self) -> None:
        if not self.budget > 0:
            raise UsageError(f"--budget must be a positive number, not {self.budget:g}")
        self.last_checkpoint = monotonic()
        self.end = self.last_checkpoint + self.budget

    def remaining(self) -> Pace:
        """Return the pace of one of several tasks that share the time."""
        return Pace(max(self.end - monotonic(), LEAST))

    def keep(self, result: Callable[[], Sequence[Any]], now: bool = False) -> None:
        """Hand on what is found so far, now and then."""
        if self.checkpoint and (now or monotonic() - self.last_checkpoint > OFTEN):
            self.checkpoint(*result())
            self.last_checkpoint = monotonic()

    def begins(self, part: str) -> bool:
        """Return whether there is time to begin a part, which is left out if there is none."""
        self.done += 1
        self.progress(self.done - 1, max(self.done, self.total), part)
        if monotonic() < self.end:
            return True
        self.left_out.append(part)
        return False
