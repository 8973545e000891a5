"""Public models as other engines import them: what is lost is named."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from mbcheck import compare
from mbcheck.tests.foreign.importers import IMPORTERS, written_by_newton

ASSETS = "gymnasium/envs/mujoco/assets"

LIBRARIES = {"Pinocchio": "pinocchio", "Drake": "pydrake", "DART": "dartpy", "MJX": "mujoco.mjx"}

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
    """Unpack the models of a public package, which is never imported."""
    folder = tmp_path_factory.mktemp("models")
    command = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "-d", str(folder)]
    subprocess.run([*command, "gymnasium"], timeout=300, check=True)
    with zipfile.ZipFile(next(folder.glob("*.whl"))) as wheel:
        wheel.extractall(folder)
    return folder / ASSETS


@pytest.mark.parametrize(("engine", "model"), NAMED)
def test_what_an_importer_loses_is_named(assets: Path, engine: str, model: str) -> None:
    pytest.importorskip(LIBRARIES[engine])
    path = assets / f"{model}.xml"
    result = compare(
        str(path), f"{path}@{IMPORTERS[engine].__module__}:{IMPORTERS[engine].__name__}"
    )
    assert {one.sentence for one in result.differences} == NAMED[engine, model]
    assert result.closed is (True if result.gaps else None)


@pytest.mark.parametrize("model", WRITTEN)
def test_what_newton_writes_is_compared(assets: Path, model: str, tmp_path: Path) -> None:
    pytest.importorskip("newton")
    path = assets / f"{model}.xml"
    result = compare(str(path), str(written_by_newton(path, tmp_path)))
    assert result.differences[0].sentence == WRITTEN[model]
