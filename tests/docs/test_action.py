"""The scripts of the GitHub action run, and the action has the inputs that its page shows."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from mbcheck.tests.support.command import MAIN, succeeds


@pytest.fixture
def action(clone: Path) -> Any:
    return yaml.safe_load((clone / "action.yml").read_text(encoding="utf-8"))


def run_step(action: Any, name: str, folder: Path, **inputs: str) -> tuple[int, str]:
    """Run the script of a step as GitHub does; return its exit code, and what it prints."""
    (step,) = (one for one in action["runs"]["steps"] if one.get("name") == name)
    given = {key: entry["default"] for key, entry in action["inputs"].items()}
    given |= {key.replace("_", "-"): value for key, value in inputs.items()}
    environment = {
        variable: re.sub(r"\$\{\{ inputs\.([\w-]+) \}\}", lambda m: given[m[1]], text)
        for variable, text in step["env"].items()
    }
    environment |= {"PATH": f"{folder}:{os.environ['PATH']}", "GITHUB_ACTION_PATH": "here"}
    shell = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]]
    ended = subprocess.run(
        shell, cwd=folder, env=os.environ | environment, capture_output=True, text=True
    )
    return ended.returncode, ended.stdout + ended.stderr


def write_program(path: Path, text: str) -> None:
    path.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
    path.chmod(0o755)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with the command `mbcheck`, a sound model and one that is unstable."""
    start, script = MAIN[:-1], MAIN[-1]
    write_program(tmp_path / "mbcheck", f"exec {' '.join(start)} '{script}' \"$@\"")
    for name, stiffness in (("sound", "1e3"), ("stiff", "1e8")):
        succeeds(f"export hula_hoop --set stiffness={stiffness} -o", tmp_path / f"{name}.xml")
    return tmp_path


def test_the_page_shows_all_inputs(action: Any, clone: Path) -> None:
    page = (clone / "docs" / "action.md").read_text(encoding="utf-8")
    assert re.findall(r"^\| `([\w-]+)` \|", page, re.MULTILINE) == list(action["inputs"])


def test_versions_are_installed_with_the_action(action: Any, tmp_path: Path) -> None:
    write_program(tmp_path / "python", 'echo "$@"')
    code, printed = run_step(action, "Install", tmp_path, versions="mujoco==4.0.0 my-engine")
    assert code == 0
    assert "-m pip install here mujoco==4.0.0 my-engine\n" in printed


@pytest.mark.parametrize(
    ("inputs", "code", "words"),
    [
        ({"model": "sound.xml"}, 0, "0 errors"),
        ({"model": "stiff.xml"}, 1, "step_limit"),
        ({"model": "stiff.xml", "fail_on": "never"}, 0, "step_limit"),
        ({"model": "sound.xml", "compare": "stiff.xml"}, 1, "joint y"),
        ({"model": "sound.xml", "compare": "stiff.xml", "fail_on": "never"}, 0, "joint y"),
        ({"model": "nowhere.xml", "fail_on": "never"}, 2, "nowhere.xml"),
        ({"engine": "mujoco", "arguments": "hula_hoop --kind algebra"}, 0, "PASS"),
    ],
    ids=["sound", "unstable", "report", "compared", "compared-report", "missing", "engine"],
)
def test_the_action_runs(
    action: Any, folder: Path, inputs: dict[str, str], code: int, words: str
) -> None:
    pytest.importorskip("mujoco")
    ended, printed = run_step(action, "Run", folder, **inputs)
    assert (ended, words in printed) == (code, True), printed
    assert sys.executable in (folder / "mbcheck").read_text(encoding="utf-8")
