"""The example of an engine in the page for authors is right, and works as the page says."""

from __future__ import annotations

import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from mbcheck.comparisons.reports.run.located import located
from mbcheck.tests.support import example
from mbcheck.tests.support.example import CASES, LEVELS, bad, results

pytest.importorskip("mujoco", reason="the example takes inertias from MuJoCo")

ROOT = Path(__file__).resolve().parents[3]
PAGE = ROOT / "docs" / "engines.md"
blocks = partial(example.blocks, PAGE)
toy_class = partial(example.toy_class, PAGE)


# The page


def test_the_example_is_short_enough_to_read() -> None:
    assert len(blocks("python")[0].splitlines()) <= 60


@pytest.mark.parametrize("scene", CASES)
def test_the_example_is_right(scene: str) -> None:
    found = results(toy_class(), scene)
    assert {item.kind for item in found if item.verdict == "pass"} == set(LEVELS)
    assert not bad(found)


def test_the_page_shows_what_the_suite_says_of_a_lost_coriolis_force() -> None:
    wrong = toy_class((" - self.data.qfrc_bias", ""))
    *_, shown = blocks("text")
    assert "\n".join(
        ["Located:", *(f"  {line}" for line in located(results(wrong, "hula_hoop")))]
    ) == (shown.strip())


def test_the_example_runs_from_its_folder(tmp_path: Path) -> None:
    (tmp_path / "toy_engine.py").write_text(blocks("python")[0], encoding="utf-8")
    ended = subprocess.run(
        [
            *(sys.executable, "-c", "from mbcheck.comparisons.cli import main; main()"),
            *("check", "hula_hoop", "--engine", "toy_engine:Toy", "--kind", "parts", "-j", "2"),
        ],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert ended.returncode == 0, ended.stderr
    assert "toy 0.1" in ended.stdout
    assert "PASS: " in ended.stdout


@pytest.mark.slow
def test_the_page_is_followed_literally_in_a_fresh_environment(tmp_path: Path) -> None:
    source, project, home = tmp_path / "mbcheck-source", tmp_path / "toy", tmp_path / "venv"
    ignored = ("-C", str(ROOT), "ls-files", "-z", "--cached", "--others", "--exclude-standard")
    names = subprocess.run(["git", *ignored], capture_output=True, text=True, check=True).stdout
    for name in filter(None, names.split("\0")):
        if (ROOT / name).exists():
            copy = source / name
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes((ROOT / name).read_bytes())
    project.mkdir()
    (project / "toy_engine.py").write_text(blocks("python")[0], encoding="utf-8")
    (project / "pyproject.toml").write_text(blocks("toml")[0], encoding="utf-8")

    def run(line: str, code: int = 0) -> str:
        program, *arguments = line.split()
        path = home / "bin" / program if home.exists() else Path(sys.executable)
        ended = subprocess.run(
            [path, *arguments], cwd=project, capture_output=True, text=True, timeout=900
        )
        assert ended.returncode == code, ended.stdout + ended.stderr
        return ended.stdout

    run(f"python -m venv {home}")
    run(f"python -m pip install --quiet {source}")
    of_file, of_engine, once_more, *_ = blocks("shell")
    for command in of_file.splitlines():
        assert "hula_hoop" in run(command)
    install, *commands = of_engine.splitlines()
    run(install)
    for command in commands:
        assert "toy 0.1" in run(command)
    everywhere = run("mbcheck list")
    assert "toy" in everywhere
    assert "pinocchio" not in everywhere
    right, wrong = (
        "force = system.force(time, q, v) - self.data.qfrc_bias",
        "force = system.force(time, q, v)",
    )
    text = (project / "toy_engine.py").read_text(encoding="utf-8")
    assert right in text
    (project / "toy_engine.py").write_text(text.replace(right, wrong), encoding="utf-8")
    (command,) = once_more.splitlines()
    assert blocks("text")[-1].strip() in run(command, code=1)
