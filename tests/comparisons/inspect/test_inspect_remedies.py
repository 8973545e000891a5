"""Printed fixes, typed into the file: they load, leave no finding of their kind, and no motion."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import mujoco
import numpy as np
import pytest

from mbcheck.comparisons.inspect.batch import Sandbox
from mbcheck.comparisons.inspect.console import steps_section
from mbcheck.comparisons.inspect.inspection import ModelFinding, inspect
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.mjcf.mistakes import INERTIAL, KEY, LIMITED, SOLID, held, written

SERVO = """<mujoco><compiler angle="radian"/>
  <option timestep="0.002" integrator="{integrator}" gravity="0 0 0"/><worldbody><body>
  <joint name="j" axis="0 1 0" {joint}/>
  <inertial pos="0 0 0" mass="1" diaginertia="0.0016 0.0016 0.0016"/></body></worldbody>
  <actuator><position name="a" joint="j" kp="{kp}" kv="{kv}" {servo}/></actuator></mujoco>"""
UNFIXED = {
    "integrator": "Euler",
    "joint": 'damping="0.01"',
    "kp": 3600.0,
    "kv": 0.36,
    "servo": 'forcerange="-700 700"',
}


def servo(path: Path, **settings: object) -> Path:
    """Write a joint with a stiff servo of limited force."""
    path.write_text(SERVO.format(**{**UNFIXED, **settings}))
    return path


def lasting_speed(path: Path, angle: float, step: float = 0.002) -> float:
    """Return the largest speed [rad/s] in the third second of a run from an angle."""
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.timestep = step
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    data = mujoco.MjData(model)
    data.qpos[:] = angle
    speeds = []
    while data.time < 3.0 and np.all(np.isfinite(data.qvel)):
        mujoco.mj_step(model, data)
        speeds.append(float(np.max(np.abs(data.qvel))))
    return max(speeds[len(speeds) * 2 // 3 :])


def one_of(path: Path, rule: str) -> ModelFinding:
    """Return the only finding of a file."""
    (found,) = inspect(path).findings
    assert found.rule == rule, found
    return found


def number(pattern: str, text: str) -> float:
    match = re.search(pattern, text)
    assert match is not None, text
    return float(match[1])


@pytest.mark.slow
def test_a_fix_leaves_no_spin_and_is_not_near_the_limit(tmp_path: Path) -> None:
    """By `discrete` it reverses its largest force every other step, at 870 rad/s, for ever.

    All fixes are typed into the file: no finding is left, and from angles at which none was tried
    the joint moves no faster than with a hundredth of the step.
    """
    path = servo(tmp_path / "model.xml")
    fix = one_of(path, "step_limit").fix
    assert '(not integrator "discrete": a run with a servo\'s joint displaced' in fix
    rows, lines = zip(*((x.rows, x.lines) for x in steps_section(inspect(path))), strict=True)
    assert [row[0] for row in rows[0] if str(row[0]).endswith(" *")] == ["discrete *"]
    assert lines[0][0].startswith("* discrete is no remedy: a run with a servo's joint displaced")
    assert lasting_speed(servo(path, integrator="discrete"), 0.5) > 800
    gain = number(r"([\d.]+) times the gains", fix)
    edits: list[dict[str, object]] = [
        {"joint": f'damping="0.01" armature="{number("""armature="([^"]+)" on""", fix)}"'},
        {"joint": f'damping="{number("""damping="([^"]+)" on""", fix)}"'},
        {"kp": gain * 3600, "kv": gain * 0.36},
    ]
    for edit in edits:
        rules = {one.rule for one in inspect(servo(path, **edit)).findings}
        assert rules.isdisjoint({"step_limit", "near_step_limit"}), edit
        for angle in (0.2, 0.55, 0.8):
            there = lasting_speed(path, angle, 2e-5)
            assert lasting_speed(path, angle) < 2 * there + 0.1, (edit, angle)
    step = number(r'timestep="([\d.]+)"', fix)
    path.write_text(servo(path).read_text().replace('timestep="0.002"', f'timestep="{step}"'))
    assert inspect(path).findings == ()


@pytest.mark.parametrize("armature", [0.0, 0.003])
def test_the_value_of_a_fix_is_the_one_to_write(armature: float, tmp_path: Path) -> None:
    """It is above that of the file, not to be added to it, and no integrator has the same limit."""
    inertia = 0.0016 + armature
    joint = f'damping="{45 * inertia:g}" armature="{{}}"'
    settings = {"servo": "", "kp": 8e5 * inertia, "kv": 0.0}
    path = servo(tmp_path / "model.xml", joint=joint.format(armature), **settings)
    found = one_of(path, "near_step_limit")
    assert not re.search('integrator="(implicit|implicitfast)"', found.fix)
    value = number(r'armature="([^"]+)" on', found.fix)
    assert value > armature
    assert inspect(servo(path, joint=joint.format(value), **settings)).findings == ()


@pytest.mark.parametrize(
    ("servo", "rule"),
    [
        ('position kp="9" kv="1" ctrlrange="-3 3"', "control_beyond_range"),
        ('position kp="9" kv="1" gear="-2" ctrlrange="-6 6"', "control_beyond_range"),
        ('position kp="9" kv="1" ctrlrange="-90 90"', "control_in_degrees"),
        ('intvelocity kp="9" kv="1" actrange="-3 3"', "control_beyond_range"),
    ],
)
def test_a_printed_range_takes_the_place_of_the_other(
    servo: str, rule: str, tmp_path: Path
) -> None:
    """`inheritrange` beside it would be refused by MuJoCo."""
    path = written(tmp_path, LIMITED, *held(servo))
    fix = one_of(path, rule).fix
    match = re.fullmatch(r'write ((\w+)="[^"]*") on the actuator', fix)
    assert match is not None, fix
    path.write_text(re.sub(rf'{match[2]}="[^"]*"', match[1], path.read_text()))
    assert inspect(path).findings == ()


POSITION = 'position kp="900" kv="9"'
INSIDE = "give the keyframe a ctrl within the range of the joint"


@pytest.mark.parametrize(
    ("actuator", "key", "words"),
    [
        (POSITION, 'qpos="1.5" ctrl="2.5"', "in the state 'hanging' one drives it to 2.49 rad"),
        (POSITION, 'qpos="0.5" ctrl="2.5"', "do not keep it there: one drives it to 2.49 rad"),
        (POSITION, 'qpos="0.5" ctrl="1"', "do not keep it there: one yields by about 0.495 rad"),
        (POSITION, 'qpos="1.5" ctrl="1.55"', None),
        ("motor", 'qpos="1.5" ctrl="90"', None),
        ("motor", 'qpos="1.5" ctrl="-90"', "one exerts -90 Nm"),
        (POSITION + ' forcerange="-2 2"', 'qpos="-1.5" ctrl="-1.5"', "needs"),
    ],
)
def test_a_set_point_beyond_a_limit_is_named(
    actuator: str, key: str, words: str | None, tmp_path: Path
) -> None:
    """A joint that is pressed against its limit stays there: no control lets go of it."""
    findings = inspect(written(tmp_path, LIMITED, *held(actuator, key=key)), modes=False).findings
    if words is None:
        assert findings == ()
        return
    (found,) = findings
    assert words in found.message
    assert ("beyond its range" in found.message) == (found.fix == INSIDE)


def test_a_negative_damper_is_one_finding(tmp_path: Path) -> None:
    """The error names it; without modes the warning does, and a waiver of it is used."""
    path = written(tmp_path, ('damping="0.1"', 'damping="-0.5"'))
    found = one_of(path, "unstable_mode")
    assert (found.severity, found.fix) == ("error", "reverse the sign of damping of swing")
    assert [one.rule for one in inspect(path, modes=False).findings] == ["negative_damping"]
    waiver = "<!-- mbcheck: allow negative_damping, swing: a source of energy -->"
    path.write_text(path.read_text().replace(KEY, waiver + KEY))
    assert [one.rule for one in inspect(path).findings] == ["unstable_mode"]


def test_a_sign_is_mended_beside_an_inverted_pendulum(tmp_path: Path) -> None:
    """Gravity lets the pole fall, whatever the servo of the cart does: modes tell them apart."""
    path = tmp_path / "model.xml"
    text = """<mujoco><compiler angle="radian"/><option timestep="0.002"/><worldbody><body>
      <joint name="slide" type="slide" axis="1 0 0"/><geom size="0.1" mass="1"/>
      <body><joint name="pole" axis="0 1 0"/>
      <inertial pos="0 0 0.3" mass="0.1" diaginertia="1e-3 1e-3 1e-3"/></body></body></worldbody>
      <actuator><position name="p" joint="slide" kp="{}"/></actuator></mujoco>"""
    path.write_text(text.format(-50))
    found = {one.rule: one.fix for one in inspect(path).findings}
    assert found["unstable_mode"] == "reverse the sign of kp of p"
    assert "positive_feedback" not in found
    path.write_text(text.format(50))
    assert "unstable_mode" not in {one.rule for one in inspect(path).findings}


@pytest.mark.parametrize(
    ("inertia", "unit"), [(("1e8", "1e8", "1e7"), "g mm^2"), (("1e3", "1e3", "1e2"), "kg cm^2")]
)
def test_an_inertia_in_another_unit_is_written_in_ours(
    inertia: tuple[str, ...], unit: str, tmp_path: Path
) -> None:
    path = written(
        tmp_path, *SOLID, (INERTIAL, INERTIAL.replace("0.1 0.1 0.01", " ".join(inertia)))
    )
    match = re.fullmatch(
        r'write (diaginertia="[^"]*"), if .* is in (.*)', one_of(path, "odd_inertia").fix
    )
    assert match is not None
    assert match[1] == 'diaginertia="0.1 0.1 0.01"'
    assert match[2] == unit
    path = written(tmp_path, *SOLID, (INERTIAL, INERTIAL.replace("0.1 0.1 0.01", "5 5 1")))
    assert one_of(path, "odd_inertia").fix.startswith("write about 0.0")


WEAK = 'position kp="{}" kv="9" {}'
LYING = ('pos="0 0 -0.5" mass="1"', 'pos="-0.5 0 0" mass="1"')


@pytest.mark.parametrize(
    ("servo", "rule", "words"),
    [
        (WEAK.format(900, 'forcerange="-4 4"'), "saturated_actuator", "swing needs 4.905 Nm"),
        (WEAK.format(10, ""), "control_not_holding", "one yields by about -0.491 rad"),
        (WEAK.format(900, 'forcerange="-6 6"'), None, ""),
    ],
)
def test_a_servo_too_weak_for_its_load_is_seen_as_the_file_opens(
    servo: str, rule: str | None, words: str, tmp_path: Path
) -> None:
    key = f"<keyframe>\n    {KEY}\n  </keyframe>"
    path = written(tmp_path, *held(servo), LYING, (key, ""), (' stiffness="5"', ""))
    found = {one.rule: one.message for one in inspect(path).findings}
    assert [*found] == [rule] * (rule is not None)
    assert words in found.get(str(rule), "")


def test_an_overdamped_joint_decays_and_has_no_frequency(tmp_path: Path) -> None:
    path = written(tmp_path, (' damping="0.1"', ' damping="90"'))
    report = " ".join(invoke(f"inspect {path} --full").stdout.split())
    assert "2 modes, 2 decaying" in report
    assert re.search(r" - 1 -[\d.]+ swing decaying", report)


def test_waivers_to_paste(tmp_path: Path) -> None:
    """`--full` prints them: with a reason each, they waive what was found."""
    path = written(tmp_path, ('name="swing"', 'name="a[1]"'), ('damping="0.1"', 'damping="-0.05"'))
    text = invoke("inspect", str(path), "--full", "--no-modes").stdout
    start = text.index("  [[waive]]")
    entries = text[start : text.index("\n\n", start)]
    assert tomllib.loads(entries)["waive"] == [
        {"rule": "negative_damping", "element": "joint:a[[]1]", "reason": ""}
    ]
    file = tmp_path / "w.toml"
    file.write_text(entries.replace('reason = ""', 'reason = "on purpose"'))
    done = invoke("inspect", str(path), "--no-modes", "--waivers", str(file))
    assert "OK: 0 errors, 0 warnings, 0 notes, 1 waived" in done.stdout


def test_progress_names_what_is_tried() -> None:
    """An edit that a rule tries is shown with the rule."""
    seen: list[tuple[object, ...]] = []
    sandbox = Sandbox(progress=lambda *message: seen.append(message))
    sandbox.alone = True
    sandbox.hear((3, 9, "rule step_limit"))
    sandbox.hear(('armature="1" on joint j',))
    assert seen[-1] == (3, 9, 'rule step_limit: armature="1" on joint j')
