"""Many files at once: profiles, waivers from outside, baselines, lines and documents."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import jsonschema
import pytest

from mbcheck.comparisons.documents import schema
from mbcheck.comparisons.inspect.batch import files_of
from mbcheck.comparisons.inspect.inspection import inspect
from mbcheck.comparisons.inspect.rules.table import RULES
from mbcheck.reference.errors import UsageError
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.documents import results_of_sarif
from mbcheck.tests.support.mjcf.mistakes import MISTAKES, written

pytestmark = pytest.mark.usefixtures("own_folder")

LOOSE = "model.xml"


def folder_of(tmp_path: Path, *rules: str) -> Path:
    """Write a file with the mistake of each of these rules, named after it."""
    folder = tmp_path / "models"
    folder.mkdir(exist_ok=True)
    for rule in rules:
        written(folder, *MISTAKES[rule][0]).rename(folder / f"{rule}.xml")
    return folder


# Profiles -----------------------------------------------------------------------------------


@pytest.mark.parametrize("rule", [name for name in MISTAKES if RULES[name].house])
def test_rules_of_the_house_are_asked_for(rule: str, tmp_path: Path) -> None:
    """They say nothing by default, unless they are selected."""
    path = written(tmp_path, *MISTAKES[rule][0])
    assert rule not in {one.rule for one in inspect(path, modes=False).findings}
    assert {one.rule for one in inspect(path, select=(rule,)).findings} == {rule}


def test_no_error_is_a_matter_of_taste() -> None:
    assert all(rule.severity != "error" for rule in RULES.values() if rule.house)


def test_rules_are_selected_and_ignored(tmp_path: Path) -> None:
    written(tmp_path, *MISTAKES["range_ignored"][0])
    assert "range_ignored" in invoke("inspect", LOOSE, "--lines").stdout
    for words in (
        ("--ignore", "range_*"),
        ("--select", "step_limit"),
        ("--strict", "--ignore", "range_ignored"),
    ):
        done = invoke("inspect", LOOSE, "--lines", *words)
        assert done.exit_code == 0
        assert "range_ignored" not in done.stdout
    done = invoke("inspect", LOOSE, "--select", "rainge_ignored")
    assert done.exit_code == 2
    assert "did you mean 'range_ignored'" in done.stderr


@pytest.mark.parametrize(
    ("fail_on", "code"), [("error", 0), ("warning", 1), ("note", 1), ("never", 0)]
)
def test_what_fails_is_chosen(fail_on: str, code: int, tmp_path: Path) -> None:
    written(tmp_path, *MISTAKES["range_ignored"][0])
    done = invoke("inspect", LOOSE, "--fail-on", fail_on)
    assert done.exit_code == code
    assert ("FAIL" in done.stdout) == bool(code)


# Waivers from outside -----------------------------------------------------------------------

WAIVE = '[[waive]]\nrule = "range_ignored"\nreason = "not ours"\n'


@pytest.mark.parametrize(
    ("more", "waived"),
    [
        ("", True),
        ('element = "joint:sw*"\n', True),
        ('element = "other"\n', False),
        ('file = "mod*.xml"\n', True),
        ('file = "other.xml"\n', False),
    ],
)
def test_waivers_beside_the_model(more: str, waived: bool, tmp_path: Path) -> None:
    written(tmp_path, *MISTAKES["range_ignored"][0])
    for name, option in (("mbcheck-inspect.toml", ()), ("own.toml", ("--waivers", "own.toml"))):
        Path(name).write_text(WAIVE + more)
        done = invoke("inspect", LOOSE, "--fail-on", "warning", *option)
        Path(name).unlink()
        assert done.exit_code == int(not waived)
        assert ("1 waived" in done.stdout) == waived


@pytest.mark.parametrize(
    ("more", "told"), [('file = "model.xml"\n', True), ('file = "mod*.xml"\n', False), ("", False)]
)
def test_a_waiver_beside_the_model_that_waives_nothing(
    more: str, told: bool, tmp_path: Path
) -> None:
    """It is told where it names this model alone: others of the folder may need it."""
    written(tmp_path)
    for name, option in (("mbcheck-inspect.toml", ()), ("own.toml", ("--waivers", "own.toml"))):
        Path(name).write_text(f"\n{WAIVE}{more}")
        done = invoke("inspect", LOOSE, "--no-modes", "--lines", *option)
        words = f"{name}:2: warning waiver_unused range_ignored finds nothing"
        assert (words in done.stdout) == told
        assert "waiver_unused" not in invoke("inspect", LOOSE, "--ignore=range_ignored").stdout
        Path(name).unlink()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[[waive", "'own.toml' is not TOML"),
        ("waive = 3", "an entry must be a table of strings"),
        ('[[waive]]\nrule = "range_ignored"\n', "line 1: add the missing reason"),
        ('\n[[waive]]\nrule = "range"\nreason = "x"\n', "did you mean"),
        (WAIVE + 'elment = "x"\n', "did you mean 'element'"),
    ],
)
def test_waivers_that_cannot_be_read(text: str, words: str, tmp_path: Path) -> None:
    written(tmp_path)
    Path("own.toml").write_text(text)
    done = invoke("inspect", LOOSE, "--waivers", "own.toml")
    assert done.exit_code == 2
    assert words in done.stderr


def test_a_baseline_waives_what_was_there(tmp_path: Path) -> None:
    folder = folder_of(tmp_path, "range_ignored", "solimp_clamped")
    words = ("inspect", str(folder), "--fail-on", "warning", "--no-modes")
    assert invoke(*words, "--json", "before.json").exit_code == 1
    done = invoke(*words, "--baseline", "before.json")
    assert done.exit_code == 0
    assert "2 waived" in done.stdout
    folder_of(tmp_path, "angle_unit")
    done = invoke(*words, "--baseline", "before.json")
    assert done.exit_code == 1
    (line,) = [line for line in done.stdout.splitlines() if ": warning " in line]
    assert "angle_unit" in line
    Path("before.json").write_text("[]")
    done = invoke(*words, "--baseline", "before.json")
    assert done.exit_code == 2
    assert "is not a document of inspect" in done.stderr


# Many files ---------------------------------------------------------------------------------


def test_files_of_folders_and_patterns(tmp_path: Path) -> None:
    """What is no MJCF, and what another file includes, is left out; nothing comes twice."""
    folder = folder_of(tmp_path, "range_ignored", "angle_unit")
    (folder / "part.xml").write_text("<mujoco><worldbody><body/></worldbody></mujoco>")
    (folder / "whole.xml").write_text('<mujoco><include file="part.xml"/><worldbody/></mujoco>')
    (folder / "note.xml").write_text("<html/>")
    (folder / "broken.xml").write_text("<mujoco><worldbody>")
    names = [Path(name).name for name in files_of([str(folder), f"{folder}/*.xml"])]
    assert names == ["angle_unit.xml", "broken.xml", "range_ignored.xml", "whole.xml"]
    with pytest.raises(UsageError, match="has no MJCF file"):
        files_of([f"{folder}/*.urdf"])


def test_a_line_for_each_finding(tmp_path: Path) -> None:
    """The others are inspected where one cannot be read; that is exit code 2."""
    folder = folder_of(tmp_path, "range_ignored", "angle_unit")
    done = invoke("inspect", str(folder), "--no-modes")
    assert done.exit_code == 0
    first, second, last = done.stdout.splitlines()
    assert first.startswith(f"{folder}/angle_unit.xml:9: warning angle_unit ")
    assert "; fix: " in first
    assert "range_ignored" in second
    assert last == "OK: 2 files, 0 errors, 2 warnings, 0 notes"
    (folder / "broken.xml").write_text("<mujoco><worldbody>")
    done = invoke("inspect", str(folder), "--no-modes")
    assert done.exit_code == 2
    assert len(done.stdout.splitlines()) == 3
    assert "1 cannot be read" in done.stdout
    assert "broken.xml is not XML" in done.stderr
    done = invoke("inspect", str(folder), "--full")
    assert done.exit_code == 2
    assert "--full is for one model" in done.stderr


def test_documents_of_many_files(tmp_path: Path) -> None:
    folder = folder_of(tmp_path, "step_limit", "angle_unit")
    (folder / "broken.xml").write_text("<mujoco><worldbody>")
    outputs = ("--json", "a.json", "--sarif", "a.sarif", "--junit", "a.xml")
    assert invoke("inspect", str(folder), *outputs).exit_code == 2
    found = json.loads(Path("a.json").read_text())
    jsonschema.Draft202012Validator(schema("inspections")).validate(found)
    assert found["summary"] == {"error": 1, "warning": 1, "note": 0, "waived": 0}
    assert [one["file"] for one in found["unreadable"]] == [f"{folder}/broken.xml"]
    results = results_of_sarif(Path("a.sarif").read_text())
    assert [one["level"] for one in results] == ["warning", "error"]
    for one in results:
        where = one["locations"][0]["physicalLocation"]
        assert Path(where["artifactLocation"]["uri"]).is_file()
        assert where["region"]["startLine"] > 1
    root = ET.parse("a.xml").getroot()
    assert {name: root.get(name) for name in ("tests", "failures", "errors", "skipped")} == {
        "tests": "3",
        "failures": "1",
        "errors": "1",
        "skipped": "1",
    }


def test_documents_of_one_file(tmp_path: Path) -> None:
    """To standard output, and nothing else goes there; a clean file is a test that passes."""
    written(tmp_path)
    root = ET.fromstring(invoke("inspect", LOOSE, "--junit", "-").stdout)
    assert (root.get("tests"), root.get("failures")) == ("1", "0")
    assert results_of_sarif(invoke("inspect", LOOSE, "--sarif", "-").stdout) == []


def test_annotations_for_github(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(tmp_path, *MISTAKES["angle_unit"][0])
    lines = invoke("inspect", LOOSE, "--annotations").stdout.splitlines()
    token = lines[0].removeprefix("::stop-commands::")
    (one,) = lines[lines.index(f"::{token}::") + 1 :]
    assert one.startswith("::warning file=model.xml,line=9,title=mbcheck%3A angle_unit::")
    assert "::" not in invoke("inspect", LOOSE, "--no-annotations").stdout
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    assert "::warning" in invoke("inspect", LOOSE).stdout


def test_lines_of_an_included_file(tmp_path: Path) -> None:
    """A finding points at the file that it stands in, from where the user is."""
    folder = folder_of(tmp_path, "angle_unit")
    (folder / "whole.xml").write_text('<mujoco>\n<include file="angle_unit.xml"/>\n</mujoco>')
    done = invoke("inspect", f"{folder}/whole.xml", "--lines", "--no-modes")
    assert done.stdout.startswith(f"{folder}/angle_unit.xml:9: warning angle_unit")
