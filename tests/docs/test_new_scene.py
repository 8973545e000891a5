"""The scene that docs/new_scene.md adds, in a copy of the package."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

MBCHECK = [sys.executable, "-c", "from mbcheck.comparisons.cli import main; main()"]
NAME = "spring_pendulum"
PLACES = {"reference", f"models/{NAME}"}
"""Folders in which the page may put files."""

QUICK = ("list", "simulate", "frequencies", "export", "inspect")
"""Verbs that take seconds."""


@pytest.fixture(scope="module")
def page(clone: Path) -> str:
    return (clone / "docs" / "new_scene.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def copied(clone: Path, page: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a copy of the package to which the page was applied."""
    folder = tmp_path_factory.mktemp("new_scene")
    package = folder / "mbcheck"
    leave = shutil.ignore_patterns("__pycache__")
    for name in ("reference", "models", "comparisons"):
        shutil.copytree(clone / name, package / name, ignore=leave)
    shutil.copy(clone / "__init__.py", package)
    for place, text in files(page).items():
        path = package / place
        assert not path.exists()
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
    scenes = package / "reference" / "__init__.py"
    source = scenes.read_text(encoding="utf-8")
    listed = re.compile(r"^(SCENES = \([^)]*?),?\n?\)$", re.MULTILINE)
    registered = listed.sub(rf'\1, "{NAME}")', source)
    assert registered != source
    scenes.write_text(registered, encoding="utf-8")
    return folder


def files(page: str) -> dict[str, str]:
    """Return the files that the page shows, by their places."""
    pattern = r"^### (\S+)\n\n```\w+\n(.*?)^```$"
    return dict(re.findall(pattern, page, re.MULTILINE | re.DOTALL))


def run(folder: Path, command: str) -> str:
    """Return what a command of the page prints."""
    ended = subprocess.run(
        [*MBCHECK, *shlex.split(command)[1:]],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout


def commands(page: str) -> list[str]:
    """Return the commands of the page."""
    return [line for line in page.splitlines() if line.startswith("mbcheck ")]


def test_a_scene_is_one_module_and_one_folder(page: str) -> None:
    places = {place.rpartition("/")[0] for place in files(page)}
    assert places == PLACES
    assert len(files(page)) <= 5
    assert sum(len(text.splitlines()) for text in files(page).values()) <= 250
    assert [place for place in files(page) if place.startswith("reference/")] == [
        f"reference/{NAME}.py"
    ]


@pytest.mark.slow
def test_the_new_scene_is_served_and_passes_all_checks(copied: Path, page: str) -> None:
    for engine in ("mujoco", "exudyn"):
        pytest.importorskip(engine, exc_type=ImportError)
    printed = {command: run(copied, command) for command in commands(page)}
    for command, text in printed.items():
        if command.split()[1] in QUICK:
            assert NAME in text or "export" in command, command
    assert "0 deviations, 0 errors" in printed[f"mbcheck check {NAME}"]
