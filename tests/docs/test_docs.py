"""Every command and every piece of Python that a document shows runs as it stands."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from mbcheck.comparisons.checks import comparison
from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.checks.truth import MOST_AMPLIFICATION
from mbcheck.comparisons.checks.verdict import PROFILES
from mbcheck.comparisons.cli.group import VERBS
from mbcheck.reference import SCENES, get_scene
from mbcheck.tests.support.command import MAIN, invoke

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")]
SLOW = (
    "mbcheck orbit hula_hoop",
    "mbcheck orbit rotor_pendulum",
    "mbcheck check --id",
    "mbcheck simulate rotating_beam --model",
    "mbcheck boundary",
    "mbcheck check --quick --engine mujoco",
    "mbcheck reproduce",
    "mbcheck tradeoff",
    "mbcheck extremes",
)
"""How commands begin that take more than seconds."""


def marked(text: str, slow: str | tuple[str, ...]) -> Any:
    """Return the text as a parameter of a test, slow if it begins like that."""
    return pytest.param(text, marks=pytest.mark.slow if text.startswith(slow) else ())


LANGUAGES = ("", "sh", "console", "bash")
"""Of blocks that hold commands."""


def blocks(language: str) -> list[tuple[str, str]]:
    """Return (path, text) of the fenced blocks of a language."""
    pattern = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
    return [
        (path.relative_to(ROOT).as_posix(), block)
        for path in DOCUMENTS
        for found, block in pattern.findall(path.read_text(encoding="utf-8"))
        if found == language
    ]


def commands() -> list[str]:
    """Return the mbcheck commands that the documents show without their output, each once."""
    lines = [
        line.strip()
        for language in LANGUAGES
        for _, block in blocks(language)
        for line in block.splitlines()
        if line.startswith("mbcheck ") and not re.search(f"{TOGETHER}|{OWN_ENGINE}", block)
    ]
    printed = {line for block, _ in outputs() for line in block.splitlines()}
    return [line for line in dict.fromkeys(lines) if line not in printed]


TOGETHER = r"mbcheck (compare-maps|compare \w|diff|judge|inspect \w|tradeoff \w+\.xml)"
"""In blocks whose commands read what earlier ones of the block have written."""

OWN_ENGINE = r"--engine my_engine:"
"""In commands that check the engine of the README."""

SMALL = (r"(=[^:= ]+:[^: ]+):30\b", r"\1:4")
"""What shrinks the maps of those blocks."""

FENCED = re.MULTILINE | re.DOTALL

SHOWN = re.compile(r"^```\w*\n((?:mbcheck [^\n]*\n)+)```\n\n```text\n(.*?)^```$", FENCED)
"""Commands, and what the last of them prints."""


def outputs() -> list[tuple[str, str]]:
    """Return commands with the output that a document shows of the last."""
    return [
        (block, output)
        for path in DOCUMENTS
        for block, output in SHOWN.findall(path.read_text(encoding="utf-8"))
        if not re.search(f"{OWN_ENGINE}|toy_engine", block)
    ]


def test_every_verb_is_shown() -> None:
    shown = "\n".join(text for language in LANGUAGES for _, text in blocks(language))
    for verb in VERBS:
        assert re.search(rf"^(\S*/)?mbcheck {verb} ", shown, re.MULTILINE), verb


FEWER = {
    "mbcheck check --quick --engine": " --kind algebra",
    "mbcheck extremes": " --engine mujoco",
    "mbcheck tradeoff": " --engine exudyn",
    "mbcheck simulate rotating_beam --model zero_order": " --times 0.5",
    "mbcheck boundary speed_regulator": " --x damping=30:35 --lines 2",
    "mbcheck boundary hula_hoop --x force_frequency=1:10": " --x force_frequency=7.5:8 --lines 2",
}
"""How the longest commands begin, and options by which they do a part of what a reader sees."""


def shorter(command: str) -> str:
    """Return the command, or a part of what it does; of options that are repeated the last hold."""
    return command + "".join(more for begin, more in FEWER.items() if command.startswith(begin))


@pytest.mark.parametrize("command", [marked(line, SLOW) for line in commands()])
@pytest.mark.usefixtures("own_folder")
def test_command_runs(command: str) -> None:
    result = invoke("", *shlex.split(shorter(command))[1:])
    assert result.exit_code == 0, result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    "block",
    [text for _, text in blocks("") if re.search(TOGETHER, text) and text not in dict(outputs())],
    ids=lambda text: "block",
)
@pytest.mark.usefixtures("own_folder")
def test_commands_run_one_after_the_other(block: str) -> None:
    for line in block.splitlines():
        result = invoke("", *shlex.split(re.sub(*SMALL, line))[1:])
        assert result.exit_code == int(line.startswith("mbcheck compare ")), result.stderr


def shown() -> list[Any]:
    """Return the same as parameters of a test, slow if they take more than seconds."""
    return [
        pytest.param(block, output, marks=pytest.mark.slow if is_slow(block) else (), id="block")
        for block, output in outputs()
    ]


def is_slow(block: str) -> bool:
    """Return True if commands take more than seconds."""
    return block.startswith(SLOW) or re.search(TOGETHER, block) is not None


def assert_prints(output: str, shown: str) -> None:
    """Fail unless all parts of a text, between dots, are in an output, in this order."""
    printed, place = " ".join(output.split()), 0
    for part in shown.split("...\n"):
        place = printed.find(" ".join(part.split()), place)
        assert place >= 0, part


@pytest.mark.parametrize(("block", "output"), shown())
@pytest.mark.usefixtures("own_folder")
def test_output_is_what_is_printed(block: str, output: str) -> None:
    for line in block.splitlines():
        result = invoke("", *shlex.split(line)[1:])
        assert result.exit_code == int(line.startswith("mbcheck compare ")), result.stderr
        assert "Traceback" not in result.stderr
    assert_prints(result.stdout, output)


@pytest.mark.parametrize(
    "block",
    # modules print nothing: engines are followed below and in test_plugin, and the new scene in
    # test_new_scene
    [
        text
        for name, text in blocks("python")
        if name != "docs/new_scene.md" and "(self, " not in text
    ],
)
def test_python_runs(block: str, tmp_path: Path) -> None:
    ended = subprocess.run(
        [sys.executable, "-c", block],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout


def read(name: str) -> str:
    """Return a document."""
    return (ROOT / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", SCENES)
def test_every_paper_is_cited(name: str) -> None:
    paper = get_scene(name).paper
    assert f"Scene {name}\n" in read("CITATION.cff")
    for document in ("docs/scenes.md", "CITATION.cff"):
        words = " ".join(read(document).split())
        assert paper.title in words
        assert paper.doi in words


def anchors(text: str) -> set[str]:
    """Return the addresses of the headings of a page."""
    heads = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```$", "", text, flags=FENCED), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize(
    "path",
    [*DOCUMENTS, *ROOT.glob("docs/papers/*.md"), ROOT / "benchmarks" / "README.md"],
    ids=lambda path: str(path.relative_to(ROOT)),
)
def test_links_lead_somewhere(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    for target, anchor in re.findall(r"\]\(([^)#:\s]*)(?:#([^)\s]*))?\)", text):
        page = path.parent / target if target else path
        assert page.exists(), f"{path.name} links to {target}"
        if anchor:
            found = anchors(page.read_text(encoding="utf-8"))
            assert anchor in found, f"{path.name} links to {target}#{anchor}"


def test_tolerances_are_described_as_they_are() -> None:
    text = " ".join(read("docs/checks.md").split())
    for constant, words in (
        (comparison.SAFETY, "{:g} times its error is granted"),
        (comparison.RICHARDSON_SAFETY, "{:g} times that is granted"),
        (100 * comparison.CAP, "No more than {:g} % of the size"),
        (MOST_AMPLIFICATION, "grows by no more than {:,.0f}:"),
        (PROFILES["strict"], "`--profile strict` takes {:g} times"),
        (PROFILES["loose"], "`--profile loose` {:g} times"),
    ):
        assert words.format(constant) in text


# The README


def python_of(name: str) -> list[str]:
    """Return the Python blocks of a page."""
    return [text for page, text in blocks("python") if page == name]


def run_own_engine(page: str, folder: Path, source: str) -> subprocess.CompletedProcess[str]:
    """Run a page's command for an engine of the reader's, which is written to a folder."""
    (folder / "my_engine.py").write_text(source, encoding="utf-8")
    (command,) = (
        line
        for line in read(page).splitlines()
        if re.search(OWN_ENGINE, line) and line.startswith("mbcheck ")
    )
    return subprocess.run(
        [*MAIN, *shlex.split(command)[1:]], cwd=folder, capture_output=True, text=True
    )


def test_the_readme_engine_has_ten_lines_and_passes(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    (source,) = python_of("README.md")
    body = source.partition("class ")[2].splitlines()[1:]
    assert len([line for line in body if line.strip()]) <= 11
    ended = run_own_engine("README.md", tmp_path, source)
    assert ended.returncode == 0, ended.stdout
    assert "0 deviations, 0 errors" in ended.stdout


@pytest.mark.slow
@pytest.mark.parametrize("page", ["README.md", "docs/tutorial.md"])
def test_a_page_shows_what_is_printed_of_its_defect(page: str, tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    (defect,) = re.findall(r"`(model\.\S+ \*= \S+)`", read(page))
    (shown,) = (text for name, text in blocks("text") if name == page and "Located" in text)
    (source,), (accelerations,) = python_of("README.md"), python_of("docs/tutorial.md")
    reads = "        model = mujoco.MjModel.from_xml_string(system.mjcf)\n"
    source += f"\n{accelerations}"
    assert source.count(reads) == 2
    ended = run_own_engine(page, tmp_path, source.replace(reads, f"{reads}        {defect}\n"))
    assert ended.returncode == 1
    assert_prints(ended.stdout, shown)


def test_the_readme_asks_a_question_for_every_kind() -> None:
    rows = re.findall(r"^\| `(\w+)` \| [A-Z].*\? \|", read("README.md"), re.MULTILINE)
    assert rows == list(KINDS)


def test_the_readme_is_short() -> None:
    assert len(read("README.md").splitlines()) <= 100


def test_the_readme_counts_no_results() -> None:
    assert not re.findall(r"\d+ (?:results|rows|checks|rules|tests)", read("README.md"))


# All pages


def test_every_page_is_in_the_index() -> None:
    index = read("docs/README.md")
    for path in ROOT.glob("docs/*.md"):
        assert path.name == "README.md" or f"]({path.name})" in index, path.name


FOLDERS = ("reference", "models", "comparisons", "tests", "docs", "examples", "benchmarks")
PATH = re.compile(rf"`((?:{'|'.join(FOLDERS)})/[\w./]*)`")
"""A path from the root, in backticks; without placeholders as in `models/<scene>`."""


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_files_that_are_named_are_there(path: Path) -> None:
    for name in PATH.findall(path.read_text(encoding="utf-8")):
        assert (ROOT / name).exists(), f"{path.name} names {name}"
