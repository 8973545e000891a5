"""Rows of the ledgers as checks of the one list, ``validation/<scene>/<row>``.

A row passes if its verdict is the expected one; what has changed since is a deviation. Rows are
about papers, not engines, and run only on request.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter

import numpy as np

from ...reference.errors import UnknownNameError
from ..checks.suite import Task, matches, narrowed
from ..checks.verdict import Result, Subject
from ..engines.registry import REFERENCE, resolve_selection
from .assess import assess, attempt
from .claims import read_paper
from .ledger import KINDS, LedgerRow, RowThreshold
from .reproduce import for_scene
from .session import Session

UNJUDGED = "no conditions judge it: a text, or what the paper leaves open"
"""Reason for which a row is skipped."""


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
        Engines that take part besides the reference.
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
        """Subject of the result."""
        prefix = f"validation/{self.scene}"
        return Subject(prefix, "validation", self.engine, self.scene, kind=self.kind)

    @property
    def group(self) -> tuple[str, str, str]:
        """Group of the rows of a paper, which share runs and maps."""
        return "", self.scene, "validation"

    @property
    def takes_long(self) -> bool:
        """True for a slow row."""
        return self.row.slow

    @property
    def participants(self) -> tuple[str, ...]:
        """The engines that take part."""
        return self.engines

    def run(self, profile: str) -> list[Result]:
        """Return the row's result; rows have no tolerances that a profile could scale."""
        row = self.row
        if not row.judgement:
            return self.skipped(UNJUDGED)
        begin = perf_counter()
        assessment, failure = attempt(lambda: assess(row, shared_session(self.engines)))
        if assessment is None:
            return self.failed(failure)
        value, limit = judged_number(assessment.thresholds[0])
        if not np.isfinite(value):
            return self.failed(f"{value} cannot be judged: {assessment.reason}")
        changed = assessment.verdict != row.verdict
        before = f"was {row.verdict}, is " if changed else ""
        return [
            self.subject.result(
                row.name,
                "deviation" if changed else "pass",
                ": ".join(filter(None, (before + assessment.verdict, assessment.reason))),
                value=value,
                reference=limit,
                error=float(changed),
                tolerance=0.0,
                work={"seconds": perf_counter() - begin},
            )
        ]


def judged_number(threshold: RowThreshold) -> tuple[float, float]:
    """Return the number that a condition judges, and its limit.

    A word or a truth value gives 1 or 0, whether the condition holds, with the limit 1.
    """
    if threshold.value is None or threshold.limit is None:
        return float(threshold.holds), 1.0
    return threshold.value, threshold.limit
