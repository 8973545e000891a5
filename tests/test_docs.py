"""Every command and every piece of Python that a document shows runs as it stands."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
DOCUMENTS = [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")]
MBCHECK = [sys.executable, "-c", "from mbcheck.comparisons.cli import main; main()"]
SLOW = ("mbcheck check", "mbcheck check -j 2 --json report.json --junit report.xml")
"""Commands that run the whole default set, which the conformance tests run too."""


def blocks(language: str) -> list[tuple[str, str]]:
    """Return (document, text) of the fenced blocks of a language."""
    pattern = re.compile(rf"^```{language}\n(.*?)^```$", re.MULTILINE | re.DOTALL)
    return [
        (path.name, block)
        for path in DOCUMENTS
        for block in pattern.findall(path.read_text(encoding="utf-8"))
    ]


def commands() -> list[str]:
    """Return the mbcheck commands that the documents show, each once."""
    lines = [
        line.strip()
        for language in ("", "sh", "console", "bash")
        for _, block in blocks(language)
        for line in block.splitlines()
        if line.startswith("mbcheck ")
    ]
    return list(dict.fromkeys(lines))


def test_the_documents_show_commands() -> None:
    if not DOCUMENTS:
        pytest.skip("runs from an installed package: there are no documents")
    verbs = {line.split()[1] for line in commands()}
    assert verbs >= {"check", "simulate", "orbit", "frequencies", "export", "list"}


@pytest.mark.parametrize(
    "command",
    [pytest.param(line, marks=pytest.mark.slow) if line in SLOW else line for line in commands()],
)
def test_command_runs(command: str, tmp_path: Path) -> None:
    arguments = shlex.split(command)[1:]
    ended = subprocess.run(
        [*MBCHECK, *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert ended.returncode == 0, ended.stderr
    assert "Traceback" not in ended.stderr


@pytest.mark.parametrize("block", [text for _, text in blocks("python")])
def test_python_runs(block: str, tmp_path: Path) -> None:
    ended = subprocess.run(
        [sys.executable, "-c", block], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout


def test_links_lead_somewhere() -> None:
    for path in DOCUMENTS:
        for target in re.findall(r"\]\(([^)#:]+)\)", path.read_text(encoding="utf-8")):
            assert (path.parent / target).exists(), f"{path.name} links to {target}"


def test_the_readme_is_about_two_screens() -> None:
    if not DOCUMENTS:
        pytest.skip("runs from an installed package: there are no documents")
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) < 160
