"""What all tests of the clone share."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from mbcheck.comparisons.engines import use_one_thread

use_one_thread()  # before any test imports NumPy
settings.register_profile("any speed", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("any speed")  # a busy machine fails no test


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out the tests of other engines, which import them, unless they are called for."""
    called = config.option.markexpr == "foreign"
    return True if collection_path.name == "foreign" and not called else None


@pytest.fixture(scope="session")
def clone() -> Path:
    """Return the folder of the clone; the tests import the package that is *installed*."""
    return Path(__file__).resolve().parents[1]


@pytest.fixture(autouse=True)
def _not_on_github(monkeypatch: pytest.MonkeyPatch) -> None:
    """Print what is printed at a desk; the report at the end of the session is not held back."""
    for name in ("GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY"):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run a test in a folder of its own, which is empty."""
    monkeypatch.chdir(tmp_path)
