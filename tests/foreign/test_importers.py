"""Public models as other engines import them: what is lost is named."""

from __future__ import annotations

from pathlib import Path

import pytest

from mbcheck import compare
from mbcheck.tests.foreign.importers import written_by_newton
from mbcheck.tests.foreign.packages import unpacked

ASSETS = "gymnasium/envs/mujoco/assets"

READERS = {
    "Pinocchio": "mbcheck.tests.foreign.importers:Pinocchio",
    "MJX": "mbcheck.examples.mjx_engine:MjxEngine",
}

NAMED = {
    ("Pinocchio", "inverted_pendulum"): {
        "every joint: range dropped",
        "actuator slide: gear 100 dropped",
        "every joint: damping 1 1 dropped",
    },
    ("MJX", "inverted_pendulum"): set[str](),
}
"""Importer and model -> what is named, all of it."""

WRITTEN = {
    "hopper": "joint rooty: pos 0 0 0 read as 0 0 -1.25",
    "half_cheetah": "body torso: mass 6.25021 read as 9.45733",
    "pusher_v5": "option: gravity 0 0 0 read as 0 0 -9.81",
}
"""Model -> the largest difference of the file that Newton writes."""

pytestmark = pytest.mark.foreign


@pytest.fixture(scope="module")
def assets(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the models of gymnasium."""
    return unpacked("gymnasium", tmp_path_factory.mktemp("models")) / ASSETS


@pytest.mark.parametrize(("engine", "model"), NAMED)
def test_what_an_importer_loses_is_named(assets: Path, engine: str, model: str) -> None:
    path = assets / f"{model}.xml"
    result = compare(str(path), f"{path}@{READERS[engine]}")
    assert {one.sentence for one in result.differences} == NAMED[engine, model]
    assert result.closed is (True if result.gaps else None)


@pytest.mark.parametrize("model", WRITTEN)
def test_what_newton_writes_is_compared(assets: Path, model: str, tmp_path: Path) -> None:
    pytest.importorskip("newton", reason="newton 1.8 needs an older mujoco: another environment")
    path = assets / f"{model}.xml"
    result = compare(str(path), str(written_by_newton(path, tmp_path)))
    assert result.differences[0].sentence == WRITTEN[model]
