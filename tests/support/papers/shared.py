"""Maps of the papers that several tests look at, computed once for all of them."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.papers.session import Session


@dataclass(frozen=True)
class SharedSession(Session):
    """A session whose folder other processes have too: one computes a map, the others read it."""

    def _map(self, asked: Any, settings: str) -> Any:
        assert self.folder is not None
        with alone(self.folder / f"{sha256(settings.encode()).hexdigest()}.lock"):
            return super()._map(asked, settings)


@contextmanager
def alone(file: Path) -> Iterator[None]:
    """Let one process in at a time; a file that a process holds is free once the process ends."""
    with file.open("w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        yield


def folder_of_all(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder that all processes of one run of the tests have, empty as that begins."""
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "maps_of_papers"
    folder.mkdir(exist_ok=True)
    return folder
