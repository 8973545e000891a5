"""Files of all kinds, the verb, its document and its pictures."""

from __future__ import annotations

import io
import json
import os
import re
from pathlib import Path
from time import process_time
from typing import Any

import jsonschema
import pytest
from rich.console import Console

import mbcheck
from mbcheck.comparisons.documents import schema
from mbcheck.comparisons.inspect import batch
from mbcheck.comparisons.inspect.inspection import Inspection, inspect
from mbcheck.comparisons.inspect.rules.table import RULES
from mbcheck.models import mjcf
from mbcheck.reference.errors import UsageError
from mbcheck.tests.support.command import invoke, on_a_terminal, process
from mbcheck.tests.support.mjcf import large
from mbcheck.tests.support.mjcf.mistakes import MISTAKES, written

SCHEMA = schema("inspect")
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)
LOCAL = "model.xml"


pytestmark = pytest.mark.usefixtures("own_folder")


# What is no model ---------------------------------------------------------------------------

ONE = '<mujoco><worldbody><body><joint name="j" {}/><geom size="0.1"/></body></worldbody></mujoco>'
BOMB = '<!DOCTYPE a [<!ENTITY a "aaaaaaaaaaaaaaaa">' + "".join(
    f'<!ENTITY {new} "{f"&{old};" * 16}">' for old, new in zip("abcde", "bcdef", strict=True)
)
BROKEN: dict[str, tuple[str | bytes, str]] = {
    "empty": ("", "is empty"),
    "blank": (" \n ", "is empty"),
    "binary": (b"\x7fELF\0\1\2\3" * 99, "binary"),
    "no XML": ("<mujoco><a></mujoco>", "not XML: mismatched tag: line 1"),
    "words": ("hello", "not XML"),
    "URDF": ('<robot name="r"/>', "root is <robot>.*URDF"),
    "another root": ("<html/>", "root is <html>"),
    "unknown element": (
        "<mujoco>\n<wordbody/></mujoco>",
        "unrecognized element.*'wordbody', line 2",
    ),
    "unknown attribute": (ONE.format('stifness="1"'), "unrecognized attribute.*stifness"),
    "missing mesh": (
        '<mujoco><asset><mesh name="m" file="none.stl"/></asset></mujoco>',
        r"cannot compile.*none.stl.*\(model.xml, line 1\)",
    ),
    "missing include": (
        '<mujoco><include file="none.xml"/></mujoco>',
        "cannot read none.xml, which model.xml, line 1, includes",
    ),
    "include of nothing": ("<mujoco><include/></mujoco>", "line 1: <include> names no file"),
    "include of itself": (f'<mujoco><include file="{LOCAL}"/></mujoco>', "more than once"),
    "not a number": (ONE.format('stiffness="nan"'), "line 1: stiffness of joint:j is not a number"),
    "huge": (ONE.format('damping="1e300"'), "damping of joint:j is out of any range"),
    "too deep": (
        f"<mujoco><worldbody>{'<body>' * 600}{'</body>' * 600}</worldbody></mujoco>",
        "deep",
    ),
    "massless": (ONE.format("").replace("geom size", 'geom mass="0" size'), "mass and inertia"),
    "entities": (f"{BOMB}]><mujoco>&f;</mujoco>", "not XML"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_what_cannot_be_read_is_told_in_a_line(name: str, tmp_path: Path) -> None:
    content, words = BROKEN[name]
    path = tmp_path / LOCAL
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    done = invoke("inspect", LOCAL)
    assert done.exit_code == 2
    assert done.stdout == ""
    assert re.fullmatch(f"Error: .*{words}.*\n", done.stderr, re.DOTALL)
    assert done.stderr.count("\n") == 1
    with pytest.raises(UsageError):
        inspect(path)


def test_a_folder_a_missing_file_and_a_compiled_model(tmp_path: Path) -> None:
    (tmp_path / "folder.xml").mkdir()
    (tmp_path / "model.mjb").write_bytes(b"\0")
    for name, words in (
        ("folder.xml", "has no MJCF file"),
        ("nothing.xml", "No such file"),
        ("model.mjb", "compiled model"),
        ("", "folder"),
    ):
        done = invoke("inspect", name)
        assert done.exit_code == 2
        assert words in done.stderr
        assert done.stderr.count("\n") == 1


def test_misuse(tmp_path: Path) -> None:
    written(tmp_path)
    for words, message in (
        ((), "which file"),
        ((LOCAL, "--select", "stap_limit"), "did you mean 'step_limit'"),
        ((LOCAL, "--about-rotation", "swing"), "NAME=VALUE"),
        ((LOCAL, "--about-rotation", "swing=fast"), "must be a finite number"),
        ((LOCAL, "--about-rotation", "swung=1"), "did you mean 'swing'"),
        ((LOCAL, "--json", "no/where.json"), "cannot write"),
    ):
        done = invoke("inspect", *words)
        assert (done.exit_code, done.stdout) == (2, "")
        assert message in done.stderr


# What is a model after all ------------------------------------------------------------------

ODD = {
    "nothing": "<mujoco/>",
    "no bodies": '<mujoco><worldbody><geom size="1"/></worldbody></mujoco>',
    "free bodies": ONE.format("").replace('<joint name="j" />', "<freejoint/>"),
    "not finite": ONE.format('damping="inf"'),
    "enormous": ONE.format('stiffness="1e90"'),
    "tiny": ONE.format("").replace(
        '<geom size="0.1"/>', '<inertial pos="0 0 0" mass="1e-14" diaginertia="2e-15 2e-15 2e-15"/>'
    ),
    "unnamed": "<mujoco><worldbody><body><joint/><geom size='1'/></body></worldbody></mujoco>",
    "markup in names": ONE.format("").replace('"j"', '"[red]j[/] &lt;"'),
    "rotated": ONE.format('type="ball"'),
    "two states": ONE.format('type="ball"').replace(
        "</mujoco>", '<keyframe><key qvel="1 2 3"/><key qpos="0 1 0 0"/></keyframe></mujoco>'
    ),
    "replicated": ONE.format("")
    .replace("<body>", "<replicate count='5' offset='1 0 0'><body>")
    .replace("</body>", "</body></replicate>"),
    "a plugin's settings": ONE.format("").replace(
        "</mujoco>", "<custom><numeric name='n' data='1'/></custom></mujoco>"
    ),
}


@pytest.mark.parametrize("name", ODD)
def test_odd_models_are_inspected(name: str, tmp_path: Path) -> None:
    (tmp_path / LOCAL).write_text(ODD[name])
    done = invoke("inspect", LOCAL, "--json", "found.json")
    assert done.exit_code in (0, 1)
    assert "Traceback" not in done.output
    found = json.loads(Path("found.json").read_text())
    VALIDATOR.validate(found)
    assert found["summary"]["error"] == done.exit_code
    assert {"MUJOCO_LOG.TXT"}.isdisjoint(os.listdir())


def test_includes_may_be_deep(tmp_path: Path) -> None:
    for i in range(60):
        (tmp_path / f"part{i}.xml").write_text(f'<x><include file="part{i + 1}.xml"/></x>')
    (tmp_path / "part60.xml").write_text(
        "<x><worldbody><body name='b'><joint name='j'/><geom size='0.1' type='sphere'/></body>"
        "</worldbody></x>"
    )
    (tmp_path / LOCAL).write_text('<mujoco><include file="part0.xml"/></mujoco>')
    found = inspect(LOCAL, modes=False, strict=True)
    assert len(found.files) == 62
    assert {one.file for one in found.findings if one.rule == "repeated_default"} == {"part60.xml"}


# The verb -----------------------------------------------------------------------------------


def test_exit_codes(tmp_path: Path) -> None:
    """0 with warnings, 1 with an error: which is said; the same from the command line."""
    written(tmp_path, ('autoreset="disable"', ""))
    done = invoke("inspect", LOCAL, "--strict")
    assert done.exit_code == 0
    assert "OK: 0 errors, 1 warning, 0 notes" in done.stdout
    written(tmp_path, ('timestep="0.0009765625"', 'timestep="2"'))
    done = invoke("inspect", LOCAL)
    assert done.exit_code == 1
    assert "error step_limit option (model.xml:3)" in done.stdout
    assert "FAIL: 1 error, 0 warnings, 0 notes" in done.stdout
    ended = invoke("inspect", LOCAL, "--json", "-")
    assert ended.exit_code == 1
    assert json.loads(ended.stdout)["findings"][0]["rule"] == "step_limit"


def test_a_stranger_can_read_it(tmp_path: Path) -> None:
    written(tmp_path)
    text = invoke("inspect", LOCAL).stdout
    for words in (
        "pendulum: model.xml, MuJoCo",
        "1 degree of freedom",
        "auto-reset off",
        "swing: hinge y, k 5, c 0.1",
        "state as opened = hanging",
        "RK4 (file)",
        "steps in the shortest period",
        "OK: 0 errors",
    ):
        assert words in text


def test_rules_are_listed_and_explained(clone: Path) -> None:
    """All of them in docs/inspect.md and by `mbcheck explain`, each with what it needs."""
    listed = invoke("explain").stdout
    page = (clone / "docs" / "inspect.md").read_text(encoding="utf-8")
    rows = []
    for name, rule in RULES.items():
        assert name in listed
        severity = f"*{rule.severity}*" if rule.house else rule.severity
        rows.append(f"| `{name}` | {severity} | {rule.needs} | {rule.meaning} |")
    assert "\n".join(rows) in page
    text = " ".join(invoke("explain", "closure_softness").stdout.split())
    for words in (RULES["closure_softness"].meaning, RULES["closure_softness"].why):
        assert words in text
    assert f"fix: {RULES['closure_softness'].fix}" in text


def test_modes_may_be_left_out(tmp_path: Path) -> None:
    path = written(tmp_path)
    found = inspect(path, modes=False)
    assert found.steps == ()
    assert found.views[0].reason == "switched off by --no-modes"
    assert inspect(path, modes=True).steps


def test_the_public_function(tmp_path: Path) -> None:
    found = mbcheck.inspect(written(tmp_path))
    assert isinstance(found, Inspection)
    assert found.exit_code == 0
    assert found.counts["nv"] == 1
    assert found.mass == pytest.approx(1.0)
    (body,) = found.bodies
    assert body.inertia == (0.1, 0.1, 0.01)
    assert body.joints[0].axis == (0.0, 1.0, 0.0)


# The document -------------------------------------------------------------------------------


def document(folder: Path) -> dict[str, Any]:
    path = written(
        folder, *MISTAKES["closure_open"][0], ('timestep="0.0009765625"', 'timestep="2"')
    )
    found: dict[str, Any] = json.loads(json.dumps(inspect(path).as_json(), allow_nan=False))
    return found


def test_the_document_keeps_its_schema(tmp_path: Path) -> None:
    found = document(tmp_path)
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    VALIDATOR.validate(found)
    assert set(found) == set(SCHEMA["$defs"]["Inspection"]["required"])


# Larger models ------------------------------------------------------------------------------


def test_a_floating_humanoid(tmp_path: Path) -> None:
    """Quaternions, meshes, tendons that wrap, equalities of all types, two keyframes."""
    found = inspect(large.humanoid(tmp_path))
    VALIDATOR.validate(json.loads(json.dumps(found.as_json())))
    assert found.exit_code == 0
    assert found.counts["nv"] == 31
    standing, crouched = found.views
    assert [view.state.name for view in found.views] == ["as opened = standing", "crouched"]
    for view in (standing, crouched):
        assert view.linear is not None
        assert view.linear.closed == 10
        assert [mode.kind for mode in view.modes].count("rigid") == 6
        assert "unstable" not in {mode.kind for mode in view.modes}
    assert {one.kind for one in found.closures} == {"connect", "weld", "joint", "tendon"}
    assert next(one for one in found.steps if one.of_file).limit > 0.005


@pytest.mark.parametrize(
    "text",
    [pytest.param(large.chain(300), marks=pytest.mark.slow), large.chain(150), large.heap(30)],
    ids=["chain of 300", "chain of 150", "heap"],
)
def test_large_models_take_seconds(text: str, tmp_path: Path) -> None:
    """Without a crash; modes of many degrees of freedom are left out, and why is said."""
    (tmp_path / LOCAL).write_text(text)
    begin = process_time()
    found = inspect(LOCAL)
    assert process_time() - begin < 20  # a few
    assert found.exit_code == 0
    VALIDATOR.validate(found.as_json())
    assert "--modes finds them" in str(found.views[0].reason)
    printed = io.StringIO()
    batch.print_inspection(Console(file=printed, width=100), found, full=False)
    assert len(printed.getvalue().splitlines()) < 60


def test_a_heap_in_contact_has_a_stable_step(tmp_path: Path) -> None:
    (tmp_path / LOCAL).write_text(large.heap(4))
    (view,) = inspect(LOCAL).views
    assert view.linear is not None
    assert view.linear.rows.contacts > 3
    assert [mode.kind for mode in view.modes] == ["rigid"] * 24
    assert {mode.kind for mode in view.simulated} > {"rigid"}


def test_an_opengl_that_is_not_there_is_named(tmp_path: Path) -> None:
    written(tmp_path)
    ended = process("inspect", LOCAL, MUJOCO_GL="nonsense")
    assert ended.returncode == 2
    assert "MUJOCO_GL=nonsense" in ended.stderr
    assert ended.stderr.count("\n") == 1


@pytest.mark.parametrize("options", ["", "--full --strict"])
def test_reports_fit_80_columns(options: str) -> None:
    """Findings, modes, steps and closures of a mechanism with a loop."""
    text = mjcf.models("speed_regulator")["connect"].path.read_text("utf-8")
    Path("crank.xml").write_text(text.replace("<!-- mbcheck: allow", "<!--"))
    printed = on_a_terminal(f"inspect crank.xml {options}")
    assert "closure" in printed
    assert [line for line in printed.splitlines() if len(line) > 80] == []
