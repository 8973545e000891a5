"""Models that nobody here wrote: those of packages, unpacked and never imported."""

from __future__ import annotations

import statistics
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from mbcheck.comparisons.inspect.inspection import Inspection, inspect
from mbcheck.reference.errors import UsageError

PACKAGES = ("gymnasium", "playground")
PATIENCE = 120
"""Seconds that a download may take."""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def inspected(tmp_path_factory: pytest.TempPathFactory) -> list[Inspection]:
    """Return what is found in all files that compile alone."""
    folder = tmp_path_factory.mktemp("wheels")
    command = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "-d", str(folder)]
    try:
        done = subprocess.run(
            [*command, *PACKAGES], capture_output=True, text=True, timeout=PATIENCE, check=False
        )
    except subprocess.TimeoutExpired:
        pytest.skip(f"no download within {PATIENCE} s")
    if done.returncode:
        pytest.skip(f"no download: {done.stderr.strip().splitlines()[-1:]}")
    for wheel in folder.glob("*.whl"):
        with zipfile.ZipFile(wheel) as content:
            content.extractall(folder / wheel.stem)
    return list(reports(folder))


def reports(folder: Path) -> Iterator[Inspection]:
    for path in sorted(folder.rglob("*.xml")):
        if "<mujoco" in path.read_text(errors="replace"):
            try:
                yield inspect(path)
            except UsageError:  # a part of another file, or one whose meshes are elsewhere
                continue


def test_good_models_are_left_in_peace(inspected: list[Inspection]) -> None:
    assert len(inspected) > 30
    assert statistics.median(one.summary["warning"] for one in inspected) <= 1
    assert [one.file for one in inspected if one.exit_code] == []


def test_reports_are_short(inspected: list[Inspection]) -> None:
    import io

    from rich.console import Console

    from mbcheck.comparisons.inspect.console import print_inspection

    lengths = []
    for one in inspected:
        printed = io.StringIO()
        print_inspection(Console(file=printed, width=100), one, full=False)
        lengths.append(len(printed.getvalue().splitlines()))
    assert statistics.median(lengths) < 40
