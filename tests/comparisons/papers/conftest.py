"""What the tests of all papers share."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mbcheck.comparisons.engines.registry import available
from mbcheck.comparisons.papers.session import Session
from mbcheck.tests.support.papers.shared import SharedSession, folder_of_all


@pytest.fixture(scope="session")
def with_engines(tmp_path_factory: pytest.TempPathFactory) -> Session:
    """Return what tests compute with at the size of ``mbcheck reproduce``."""
    return SharedSession(available(), shared=folder_of_all(tmp_path_factory))


@pytest.fixture(scope="session")
def session(with_engines: Session) -> Session:
    """Return the same without engines."""
    return replace(with_engines, engines=())
