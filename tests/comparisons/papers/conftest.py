"""What the tests of all papers share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from mbcheck.comparisons.engines.registry import available
from mbcheck.comparisons.papers.session import Session
from mbcheck.tests.support.papers.shared import SharedSession, folder_of_all


@pytest.fixture(scope="session")
def with_engines(tmp_path_factory: pytest.TempPathFactory) -> Session:
    """Return what tests compute with at the size of ``mbcheck reproduce``."""
    return SharedSession(available(), shared=folder_of_all(tmp_path_factory))


ENGINE_POINTS = {"hula_hoop": 4, "rotor_pendulum": 4}
"""Along the axes of the engines' maps where those of ``mbcheck reproduce`` take minutes: a row's
texts, which are held, are of the reference, its verdict of both."""

ENGINES = {"rotating_beam": ("exudyn",), "rotor_pendulum": ("mujoco",)}
"""Of scenes whose runs and maps take as long by each engine."""


@pytest.fixture(scope="session")
def with_fewer(with_engines: Session) -> Callable[[str], Session]:
    """Return, by scene, what computes the reference's part as that and less of the engines'."""

    def session_of(scene: str) -> Session:
        engines = ENGINES.get(scene, with_engines.engines)
        engines = tuple(name for name in with_engines.engines if name in engines)
        return replace(with_engines, engines=engines, engine_points=ENGINE_POINTS.get(scene))

    return session_of


@pytest.fixture(scope="session")
def session(with_engines: Session) -> Session:
    """Return the same without engines."""
    return replace(with_engines, engines=())
