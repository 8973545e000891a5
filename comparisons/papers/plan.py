"""Rows of the ledgers as checks of the one list, ``validation/<scene>/<row>``.

A row passes if its verdict is the expected one; what has changed since is a deviation. Rows are
about papers, not engines, so that they run when they are asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter

import numpy as np

from ...reference.errors import UnknownNameError
from ..checks.refusals import narrowed
from ..checks.suite import Task, matches
from ..checks.verdict import Result, Subject, Verdict
from ..engines.registry import REFERENCE, resolve_selection
from .assess import Assessment, assessed, attempt, measure
from .claims import read_paper
from .ledger import KINDS, Condition, LedgerRow, Numbers
from .reproduce import for_scene
from .session import Session

UNJUDGED = "no conditions judge it: a text, or what the paper leaves open"
"""Why a row is skipped."""


def plan(
    scenes: Sequence[str] = (),
    kinds: Sequence[str] = (),
    ids: Sequence[str] = (),
    full: bool = False,
) -> list[RowCheck]:
    """Return the checks of rows that match; empty sequences mean all.

    Parameters
    ----------
    scenes : sequence of str
    kinds : sequence of str
        Kinds of rows, see `ledger.KINDS`.
    ids : sequence of str
        Shell patterns (``*``, ``?``) for ids.
    full : bool
        Include the slow rows, which simulate maps and long runs.

    Raises
    ------
    UsageError
        For an unknown name, or if no row matches.
    """
    scenes, engines = resolve_selection(scenes)
    for kind in kinds:
        if kind not in KINDS:
            raise UnknownNameError("kind of row", kind, KINDS)
    checks = [
        RowCheck(scene, row.kind, (row.name,), for_scene(Session(engines), scene).engines)
        for scene in scenes
        for row in read_paper(scene).rows
        if not kinds or row.kind in kinds
    ]
    checks = narrowed(checks, f"--id {' '.join(ids)}", lambda one: not ids or matches(one, ids))
    return narrowed(checks, "a run without --full", lambda one: full or not one.takes_long)


@lru_cache(maxsize=1)
def shared_session(engines: tuple[str, ...]) -> Session:
    """Return the session of the rows that are computed one after the other."""
    return Session(engines)


@dataclass(frozen=True)
class RowCheck(Task):
    """One row of a ledger.

    Attributes
    ----------
    scene, kind : str
    quantities : tuple of str
        The name of the row.
    engines : tuple of str
        Those that take part beside the reference.
    """

    scene: str
    kind: str
    quantities: tuple[str, ...]
    engines: tuple[str, ...]
    engine: str = REFERENCE

    @property
    def row(self) -> LedgerRow:
        """The row itself; a check knows its name, so that it can be sent to another process."""
        return next(row for row in read_paper(self.scene).rows if row.name == self.quantities[0])

    @property
    def subject(self) -> Subject:
        """What the result is about."""
        prefix = f"validation/{self.scene}"
        return Subject(prefix, "validation", self.engine, self.scene, kind=self.kind)

    @property
    def group(self) -> tuple[str, str, str]:
        """What it shares with other rows of the paper: their runs and maps."""
        return "", self.scene, "validation"

    @property
    def takes_long(self) -> bool:
        """Whether it is a slow row."""
        return self.row.slow

    @property
    def participants(self) -> tuple[str, ...]:
        """The engines that take part."""
        return self.engines

    def run(self, profile: str) -> list[Result]:
        """Return the row's result; rows have no tolerances that a profile could scale."""
        if not self.row.judgement:
            return self.skipped(UNJUDGED)
        begin = perf_counter()
        outcome, failure = attempt(lambda: self.assess(shared_session(self.engines)))
        if outcome is None:
            return self.failed(failure)
        assessment, value, limit = outcome
        if not np.isfinite(value):
            return self.failed(f"{value} cannot be judged: {assessment.reason}")
        changed = assessment.verdict != self.row.verdict
        verdict: Verdict = "deviation" if changed else "pass"
        before = f"was {self.row.verdict}, is " if changed else ""
        return [
            self.subject.result(
                self.row.name,
                verdict,
                ": ".join(filter(None, (before + assessment.verdict, assessment.reason))),
                value=value,
                reference=limit,
                error=float(changed),
                tolerance=0.0,
                work={"seconds": perf_counter() - begin},
            )
        ]

    def assess(self, session: Session) -> tuple[Assessment, float, float]:
        """Return what became of the row, the number that it is judged by first, and its limit."""
        numbers, engines = measure(self.row, session)
        assessment = assessed(self.row, numbers, engines)
        first = next(iter(self.row.judgement.values()))[0]
        return assessment, *judged_number(first, numbers, self.row.printed)


def judged_number(condition: Condition, numbers: Numbers, printed: str) -> tuple[float, float]:
    """Return the number of a condition that comes nearest to breaking it, and its limit.

    Of a word or a truth value it is whether the condition holds: 1 or 0, with the limit 1.
    """
    triple = condition.compared(numbers, printed)
    return triple[:2] if triple else (float(condition.holds(numbers, printed)), 1.0)
