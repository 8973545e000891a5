"""A corner of figure 4, followed once in a module."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from mbcheck.tests.support.command import SMALL, succeeds
from mbcheck.tests.support.documents import validated


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("boundary")


@pytest.fixture(scope="module")
def printed(folder: Path) -> str:
    return succeeds(SMALL, "-o", folder / "small.json", "--plot", folder / "small.png")


@pytest.fixture(scope="module")
def small(folder: Path, printed: str) -> dict[str, Any]:
    return validated("boundary", json.loads((folder / "small.json").read_text()))
