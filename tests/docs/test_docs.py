"""Every command and every piece of Python that a document shows runs as it stands."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.checks.rules.cautions import RULES
from mbcheck.comparisons.checks.suite import KINDS
from mbcheck.comparisons.cli import catalogue
from mbcheck.reference import SCENES, get_scene

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")]
MBCHECK = [sys.executable, "-c", "from mbcheck.comparisons.cli import main; main()"]
SLOW = (
    "mbcheck orbit hula_hoop",
    "mbcheck orbit rotor_pendulum",
    "mbcheck check --id",
    "mbcheck simulate rotating_beam --model",
    "mbcheck simulate rotating_beam --set",
    "mbcheck reproduce",
    "mbcheck tradeoff",
    "mbcheck extremes",
)
"""How commands begin that take more than seconds."""

SLOW_PYTHON = "# takes"
"""How blocks of Python begin that do."""


def marked(text: str, slow: str | tuple[str, ...]) -> Any:
    """Return the text as a parameter of a test, slow if it begins like that."""
    return pytest.param(text, marks=pytest.mark.slow if text.startswith(slow) else ())


def blocks(language: str) -> list[tuple[str, str]]:
    """Return (document, text) of the fenced blocks of a language."""
    pattern = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
    return [
        (path.name, block)
        for path in DOCUMENTS
        for found, block in pattern.findall(path.read_text(encoding="utf-8"))
        if found == language
    ]


def commands() -> list[str]:
    """Return the mbcheck commands that the documents show, each once."""
    lines = [
        line.strip()
        for language in ("", "sh", "console", "bash")
        for _, block in blocks(language)
        for line in block.splitlines()
        if line.startswith("mbcheck ") and not re.search(TOGETHER, block)
    ]
    return list(dict.fromkeys(lines))


TOGETHER = r"mbcheck compare-maps|mbcheck diff|mbcheck judge|mbcheck inspect \w"
"""In blocks whose commands read what earlier ones of the block have written."""

SMALL = (r"(=[^:= ]+:[^: ]+):30\b", r"\1:4")
"""What shrinks the maps of those blocks."""


def test_the_documents_show_commands() -> None:
    verbs = {line.split()[1] for line in commands()}
    assert verbs >= {
        "check",
        "simulate",
        "orbit",
        "frequencies",
        "export",
        "list",
        "map",
        "reproduce",
    }


@pytest.mark.parametrize("command", [marked(line, SLOW) for line in commands()])
def test_command_runs(command: str, tmp_path: Path) -> None:
    arguments = shlex.split(command)[1:]
    ended = subprocess.run(
        [*MBCHECK, *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert ended.returncode == 0, ended.stderr
    assert "Traceback" not in ended.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    "block", [text for _, text in blocks("") if re.search(TOGETHER, text)], ids=lambda text: "block"
)
def test_commands_run_one_after_the_other(block: str, tmp_path: Path) -> None:
    for line in block.splitlines():
        smaller = re.sub(*SMALL, line)
        ended = subprocess.run(
            [*MBCHECK, *shlex.split(smaller)[1:]],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=300,
        )
        assert ended.returncode == 0, ended.stderr


@pytest.mark.parametrize(
    "block",
    # the example of an engine is followed in test_plugin
    [marked(text, SLOW_PYTHON) for name, text in blocks("python") if name != "engines.md"],
)
def test_python_runs(block: str, tmp_path: Path) -> None:
    ended = subprocess.run(
        [sys.executable, "-c", block], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout


def read(name: str) -> str:
    """Return a document."""
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_coverage_is_shown() -> None:
    text = read("docs/checks.md")
    for engine in ("mujoco", "exudyn"):
        pytest.importorskip(engine, exc_type=ImportError)
    rows: dict[tuple[str, str], list[str]] = {}
    for cell in catalogue.coverage()["cells"]:
        rows.setdefault((cell["scene"], cell["engine"]), []).append(str(cell["checks"]))
    kinds = " | ".join(KINDS)
    assert f"| Scene | Engine | {kinds} |" in text
    for place, checks in rows.items():
        assert f"| {' | '.join((*place, *checks))} |" in text


@pytest.mark.parametrize("name", SCENES)
def test_scenes_are_described_as_they_are(name: str) -> None:
    text = read("docs/scenes.md").partition(f"\n## {name}\n")[2].partition("\n## ")[0]
    sheet = catalogue.scene_sheet(name)
    for item in sheet["parameters"]:
        default = item["default"]
        shown = default if isinstance(default, str) else f"{default:.10g}"
        cells = (f"`{item['name']}`", item["symbol"], item["unit"], shown, item["meaning"])
        assert f"| {' | '.join(cells)} |" in text
    named = [entry["name"] for entry in sheet["cases"] if not entry["full_only"]]
    for word in (
        *named,
        *sheet["about"],
        *(m for models in sheet["models"].values() for m in models),
    ):
        assert word == "exact" or f"`{word}`" in text, word


@pytest.mark.parametrize("name", SCENES)
def test_maps_are_described_as_they_are(name: str) -> None:
    text = read("docs/maps.md")
    sheet = catalogue.scene_sheet(name)
    for item in sheet["maps"]:
        models, variables = (", ".join(f"`{w}`" for w in item[k]) for k in ("models", "variables"))
        cells = (name, f"`{item['quantity']}`", item["about"], models, variables)
        assert f"| {' | '.join(cells)} |" in text
    for axis in sheet["axes"]:
        assert f"`{axis['name']}`" in text


@pytest.mark.parametrize("name", SCENES)
def test_every_paper_is_cited(name: str) -> None:
    paper = get_scene(name).paper
    assert f"Scene {name}\n" in read("CITATION.cff")
    for document in ("README.md", "docs/scenes.md", "CITATION.cff"):
        words = " ".join(read(document).split())
        assert paper.title in words
        assert paper.doi in words


def test_links_lead_somewhere() -> None:
    for path in DOCUMENTS:
        for target in re.findall(r"\]\(([^)#:]+)\)", path.read_text(encoding="utf-8")):
            assert (path.parent / target).exists(), f"{path.name} links to {target}"


def test_rules_are_described_as_they_are() -> None:
    text = read("docs/checks.md")
    for name, rule in RULES.items():
        assert f"| `{name}` | {rule.meaning} |" in text


def cells_of(text: str) -> list[list[str]]:
    """Return the cells of all rows of Markdown tables."""
    lines = [line for line in text.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in lines]


def test_the_readme_tells_what_the_tables_tell() -> None:
    readme = read("README.md")
    needed = readme.partition("*What do I need for 0.1 %?*")[2].partition("`mbcheck extremes`")[0]
    shown = [row for row in cells_of(needed) if row[0] in SCENES]
    wanted = [row for row in cells_of(read("docs/tradeoff.md")) if row[2:3] == ["0.001"]]
    chosen = [[*row[:2], *row[3:8]] for row in wanted if len(row) == 9 and row[0] in SCENES]
    assert sorted(shown) == sorted(chosen)
    assert {row[0] for row in shown} == set(SCENES)
    counts = re.findall(r"\* \*\*(\w+)\*\*: .*?\((\d+)\)", read("docs/extremes.md"))
    told = dict(counts)
    assert f"Of {sum(int(n) for _, n in counts)} rows {told['right']} are right" in readme
    assert f"{told['wrong']} wrong though finite, {told['failed']} failed and" in readme


def test_the_readme_is_about_two_screens() -> None:
    assert len(read("README.md").splitlines()) < 160
