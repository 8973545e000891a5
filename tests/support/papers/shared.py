"""What several tests need of the papers, computed once for all of them."""

from __future__ import annotations

import fcntl
import os
import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar, cast

import pytest

from mbcheck.comparisons.papers.assess import Assessment
from mbcheck.comparisons.papers.claims import read_paper, read_row
from mbcheck.comparisons.papers.ledger import REPRODUCED, LedgerRow
from mbcheck.comparisons.papers.outcomes import FigureEntry, Findings, Made, RowEntry
from mbcheck.comparisons.papers.session import Session

T = TypeVar("T")


@dataclass(frozen=True)
class SharedSession(Session):
    """A session whose values other processes have too: one computes each, the others read it.

    Attributes
    ----------
    shared : Path
        The folder that all processes have.
    """

    shared: Path = Path()

    def once(self, key: Any, produce: Callable[[], T]) -> T:
        """Return a value: of this session, of another process, or else what `produce` returns."""
        return super().once(key, lambda: self.read_or_produce(key, produce))

    def read_or_produce(self, key: Any, produce: Callable[[], T]) -> T:
        """Return the value that some process has produced, or is about to.

        What cannot be written, such as a scene's equations, stays with who has produced it.
        """
        asked = repr((key, self.full, self.points, self.seconds))
        file = self.shared / sha256(asked.encode()).hexdigest()
        with alone(file.with_suffix(".lock")):
            if file.exists():
                return cast("T", pickle.loads(file.read_bytes()))
            value = produce()
            with suppress(pickle.PicklingError, AttributeError):
                file.write_bytes(pickle.dumps(value))
        return value


@contextmanager
def alone(file: Path) -> Iterator[None]:
    """Let one process in at a time; a file that a process holds is free once the process ends."""
    with file.open("w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        yield


def folder_of_all(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder that all processes of one run of the tests have, empty as that begins."""
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "values_of_papers"
    folder.mkdir(exist_ok=True)
    return folder


def expected_findings(*scenes: str) -> Findings:
    """Return all of some papers, with the verdicts that their rows expect."""
    rows = tuple(
        RowEntry.of(scene, row, Assessment(row.verdict, "why"), run=0, seconds=0.0)
        for scene in scenes
        for row in read_paper(scene).rows
    )
    figures = tuple(
        FigureEntry(scene, one.number, one.title, one.caption, None, 0, 0.0)
        for scene in scenes
        for one in read_paper(scene).figures
    )
    return Findings({}, False, figures, rows, (), (Made({}),))


def row_of(name: str, numbers: Any = None, each: Any = None, **keys: Any) -> LedgerRow:
    """Return a row as a paper's file has it, with functions for its measures."""
    texts = {"section": "1", "claim": "a claim", "verdict": REPRODUCED} | keys
    return replace(read_row("hula_hoop", name, texts, {}), numbers=numbers, each=each)
