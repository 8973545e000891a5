"""`inspect` on files of strangers: names that give orders, models that hang, crash or grow."""

from __future__ import annotations

import json
import math
import os
import time
import xml.etree.ElementTree as ET
from contextlib import closing
from functools import partial
from pathlib import Path

import pytest

from mbcheck.comparisons.inspect.batch import Sandbox, inspect_files
from mbcheck.reference.errors import EngineError
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.mjcf.mistakes import MISTAKES, written
from mbcheck.tests.support.mjcf.strangers import MODEL, end_in

pytestmark = pytest.mark.usefixtures("own_folder")

ORDER = "&#10;::stop-commands::pwn&#10;::error::x&#x9b;31m&#x202e;"
NAMES = (
    "esc\x1b[31m.xml",
    "line\n::error::x.xml",
    "c1\x9b.xml",
    "turned\u202elmx.xml",
    os.fsdecode(b"bytes\xff.xml"),
)


def test_names_give_no_orders(tmp_path: Path) -> None:
    """Neither to GitHub nor to a terminal, in lines, reports, errors, progress and documents."""
    for name in NAMES:
        Path(name).write_text(MODEL.format("swing" if "line" in name else ORDER))
    options = ("--no-modes", "--annotations", "--junit", "j.xml", "--sarif", "s.json")
    done = invoke("inspect", ".", *options)
    assert done.exit_code == 2  # MuJoCo opens no name that is not UTF-8
    assert "bytes\\udcff.xml: MuJoCo opens no file whose name is not UTF-8" in done.stderr
    lines = done.stdout.split("\n")
    assert all(line.isprintable() for line in [*lines, *done.stderr.split("\n")])
    token = lines[0].removeprefix("::stop-commands::")
    assert len(token) == 32
    end = lines.index(f"::{token}::")
    assert any("negative_damping" in line for line in lines[1:end])
    assert {line[:10] for line in lines[end + 1 :] if line} == {"::warning "}
    for node in ET.parse("j.xml").getroot().iter():
        assert all(text.isprintable() for text in node.attrib.values()), node.attrib
        assert all(line.isprintable() for line in (node.text or "").split("\n"))
    run = json.loads(Path("s.json").read_text())["runs"][0]
    uris = [one["locations"][0]["physicalLocation"]["artifactLocation"] for one in run["results"]]
    assert {uri["uri"] for uri in uris} >= {"turned%E2%80%AElmx.xml", "esc%1B%5B31m.xml"}
    report = invoke("inspect", NAMES[0], "--no-modes").stdout
    assert "::stop-commands::pwn ::error::x\\x9b31m\\u202e" in report
    assert all(line.isprintable() for line in report.split("\n"))


def test_a_file_that_hangs_or_cannot_be_read_ends_no_other() -> None:
    """A pipe as a mesh, and an encoding of several bytes; each has 2 s, and the budget binds."""
    os.mkfifo("pipe.stl")
    Path("good.xml").write_text(MODEL.format("swing"))
    Path("encoded.xml").write_text(f'<?xml version="1.0" encoding="shift_jis"?>{MODEL}')
    Path("pipe.xml").write_text(
        '<mujoco><asset><mesh name="m" file="pipe.stl"/></asset><worldbody/></mujoco>'
    )
    begun = time.monotonic()
    done = invoke("inspect good.xml encoded.xml pipe.xml --budget 20 --json all.json")
    assert time.monotonic() - begun < 100  # seconds, and a start of two processes
    assert done.exit_code == 2
    found = json.loads(Path("all.json").read_text())
    assert [one["file"] for one in found["models"]] == ["good.xml"]
    assert [one["file"] for one in found["unreadable"]] == ["encoded.xml", "pipe.xml"]
    assert "multi-byte encodings" in found["unreadable"][0]["reason"]
    assert "MuJoCo compiles pipe.xml" in found["unreadable"][1]["reason"]
    assert "Traceback" not in done.output


@pytest.mark.parametrize(
    ("way", "words"),
    [
        ("killed", "took its process down with it: SIGSEGV"),
        ("memory", "no more memory"),
        ("raised", "KeyError: 'a fault of mbcheck'"),
        ("hangs", "was up"),
    ],
)
def test_what_was_found_before_a_file_ends_its_process_is_kept(way: str, words: str) -> None:
    for name in ("bad.xml", "good.xml"):
        Path(name).write_text(MODEL.format("swing"))
    with closing(Sandbox(20.0 if way == "hangs" else math.inf)) as sandbox:
        work = partial(partial, end_in, way)
        every, reports = inspect_files(["bad.xml", "good.xml"], work, sandbox)
    bad, good = every.models
    assert [one["file"] for one in every.models] == ["bad.xml", "good.xml"]
    assert {one["rule"] for one in bad["findings"]} == {one["rule"] for one in good["findings"]}
    assert bad["left_out"][-1] == "rule run_fails"
    assert good["left_out"] == []
    assert len(reports) == 2
    if way == "hangs":
        assert (every.unreadable, every.exit_code("never")) == ({}, 1)
    else:
        assert words in every.unreadable["bad.xml"]
        assert every.exit_code("never") == 2


def test_time_that_is_up_begins_no_other_file() -> None:
    with pytest.raises(EngineError, match="was up"):
        Sandbox(1e-9).run(partial(end_in, "hangs", "x.xml"))


# Documents -----------------------------------------------------------------------------------


def test_names_of_findings_stay_as_lines_are_added(tmp_path: Path) -> None:
    """In JUnit and SARIF, where tools tell by them what is new; alike findings are numbered."""
    path = written(tmp_path, *MISTAKES["angle_unit"][0])
    names, prints = [], []
    for text in (path.read_text(), path.read_text().replace("<worldbody>", "\n\n<worldbody>")):
        path.write_text(text)
        invoke("inspect model.xml --strict --no-modes --junit j.xml --sarif s.json")
        names.append([case.get("name") for case in ET.parse("j.xml").iter("testcase")])
        results = json.loads(Path("s.json").read_text())["runs"][0]["results"]
        prints.append([tuple(one["partialFingerprints"].values()) for one in results])
    assert names[0] == names[1]
    assert prints[0] == prints[1]
    assert len(set(names[0])) == len(names[0]) == len(set(prints[0])) > 0


def test_a_summary_of_the_job(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(tmp_path, *MISTAKES["angle_unit"][0])
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", "summary.md")
    invoke("inspect model.xml --no-modes")
    text = Path("summary.md").read_text()
    assert text.startswith("## mbcheck inspect: OK: 0 errors, 1 warning, 0 notes\n")
    assert "| warning | angle\\_unit | model.xml:9 |" in text


def test_the_hook_leaves_out_what_is_no_mjcf(tmp_path: Path) -> None:
    """As of folders: package.xml of ROS, a URDF with a section for MuJoCo, an included file."""
    path = written(tmp_path, *MISTAKES["angle_unit"][0])
    for name, text in (
        ("package.xml", "<package><name>robot</name></package>"),
        ("robot.xml", "<robot><mujoco><compiler/></mujoco></robot>"),
        ("part.xml", "<mujocoinclude><body/></mujocoinclude>"),
    ):
        path.with_name(name).write_text(text)
    done = invoke("inspect --whole-models package.xml robot.xml part.xml")
    assert (done.exit_code, done.stderr) == (0, "")
    assert invoke("inspect package.xml").exit_code == 2
    done = invoke("inspect --whole-models package.xml robot.xml part.xml model.xml --no-modes")
    assert "model.xml:9: warning angle_unit" in done.stdout
    assert invoke("inspect . --no-modes").exit_code == 0
    assert invoke("inspect --whole-models nothing.xml").exit_code == 2


@pytest.mark.parametrize("absolute", [False, True])
def test_a_fix_through_a_link_mends_what_it_points_to(absolute: bool, tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    target = Path("there/model.xml")
    target.write_text(MODEL.format("swing").replace("<geom", '<geom type="sphere"'))
    Path("link.xml").symlink_to(target.absolute() if absolute else target)
    before = target.read_text()
    done = invoke("inspect link.xml --fix --select repeated_default")
    assert done.exit_code == 0, done.output
    assert Path("link.xml").is_symlink()
    assert target.read_text() != before
