"""Rules of inspection: each finds its own mistake, and nothing in the file that is mended."""

from __future__ import annotations

import math
import re
from collections import Counter
from pathlib import Path

import mujoco
import numpy as np
import pytest

from mbcheck.comparisons.inspect.inspection import Inspection, inspect
from mbcheck.comparisons.inspect.rules.table import RULES
from mbcheck.comparisons.inspect.rules.text import repeated_default
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.mjcf.mistakes import (
    BASE,
    END,
    FLAG,
    GEOM,
    INERTIAL,
    JOINT,
    KEY,
    MISTAKES,
    ON,
    SOLID,
    WITH_MODES,
    WORLD,
    Edits,
    after,
    held,
    joint,
    written,
)


def inspected(path: Path, rule: str) -> Inspection:
    """Inspect a file, with modes if a rule looks at them."""
    return inspect(path, modes=None if rule in WITH_MODES else False, strict=True)


def test_every_rule_has_its_mistake() -> None:
    assert set(MISTAKES) == set(RULES) - {"compiler_warning"}


def test_the_base_is_clean(tmp_path: Path) -> None:
    found = inspect(written(tmp_path), strict=True)
    assert found.findings == ()
    assert found.steps


@pytest.mark.parametrize("rule", MISTAKES)
def test_a_mistake_is_found_by_its_rule_alone(rule: str, tmp_path: Path) -> None:
    mistake, mended = MISTAKES[rule]
    found = inspected(written(tmp_path, *mistake), rule)
    assert {one.rule for one in found.findings} == {rule}, found.findings
    for one in found.findings:
        assert one.severity == RULES[rule].severity
        assert one.message
        assert one.fix
        assert one.waived is None
    assert found.exit_code == (RULES[rule].severity == "error")
    assert inspected(written(tmp_path, *mended), rule).findings == ()


HELD = 'qpos="0.9" ctrl="{}"'
"""A keyframe in which the base takes 8.3 Nm: 4.5 of its spring, 3.8 of its weight."""
MOCAP = '<body name="hand" mocap="true"><geom size="0.1"/></body>'
SITE = '<site name="tip" pos="0 0 -1"/>'
THRUST = '<actuator><motor site="tip" gear="0 0 1 0 0 0" ctrlrange="0 9"/></actuator>'


@pytest.mark.parametrize(
    ("rule", "mistake", "mended"),
    [
        (
            "saturated_actuator",
            held('position kp="900" kv="9" forcerange="-8 8"', key=HELD.format(0.9)),
            held('position kp="900" kv="9" forcerange="-9 9"', key=HELD.format(0.9)),
        ),
        (
            "saturated_actuator",
            (
                joint('actuatorfrcrange="-8 8"'),
                *held('position kp="900" kv="9"', key=HELD.format(0.9)),
            ),
            (
                joint('actuatorfrcrange="-9 9"'),
                *held('position kp="900" kv="9"', key=HELD.format(0.9)),
            ),
        ),
        (
            "saturated_actuator",
            held('motor ctrlrange="-2 2" gear="4"', key=HELD.format(2)),
            held('motor ctrlrange="-3 3" gear="4"', key=HELD.format(2)),
        ),
        (
            "control_not_holding",
            held("motor", key=HELD.format(20)),
            held("motor", key=HELD.format(8)),
        ),
        (
            "light_joint",
            held('motor ctrlrange="-1 1" gear="2e6"'),
            held('motor ctrlrange="-1 1" gear="2e5"'),
        ),
        ("two_servos", held("motor", "motor"), held("motor", "velocity")),
        ("two_servos", held("motor", "motor"), held('motor ctrlrange="0 9"', 'motor gear="-1"')),
        (
            "odd_density",
            (*SOLID, (INERTIAL, ""), (GEOM, GEOM[:-2] + ' density="1e6"/>')),
            (*SOLID, (INERTIAL, ""), (GEOM, GEOM[:-2] + ' density="7800"/>')),
        ),
        (
            "zero_quaternion",
            (after(WORLD, MOCAP), (KEY, '<key name="hanging" mquat="0 0 0 0"/>')),
            (after(WORLD, MOCAP), (KEY, '<key name="hanging" mquat="0.6 0 0.8 0"/>')),
        ),
    ],
)
def test_a_mistake_has_several_forms(
    rule: str, mistake: Edits, mended: Edits, tmp_path: Path
) -> None:
    for edits, rules in ((mistake, {rule}), (mended, set[str]())):
        assert {one.rule for one in inspect(written(tmp_path, *edits)).findings} == rules


def test_a_body_that_falls_holds_nothing(tmp_path: Path) -> None:
    """In free fall a leg weighs nothing: its servo need not bear what it would on the ground.

    Its control counts all the same, where it asks for another place than the keyframe's.
    """
    robot = """<mujoco><worldbody><body name="trunk"><freejoint/><body name="leg">
      <geom type="capsule" fromto="0.3 0 0 1 0 0" size="0.05" mass="5"/>
      <joint name="hip" axis="0 1 0" damping="1"/></body><geom size="0.2" mass="9"/></body>
      </worldbody><actuator><position joint="hip" kp="90" kv="9" forcerange="-9 9"/></actuator>
      <keyframe><key time="0"/></keyframe></mujoco>"""
    turned, path = 'qpos="0 0 1 1 0 0 0 0.8"', tmp_path / "model.xml"
    for edit, rules in (
        (("", ""), set[str]()),
        (("<freejoint/>", ""), {"saturated_actuator", "control_not_holding"}),
        (('name="trunk"', 'name="trunk" gravcomp="1"'), {"control_not_holding"}),
        (('time="0"', turned), {"control_not_holding"}),
        (('time="0"', f'{turned} ctrl="0.8"'), set[str]()),
    ):
        path.write_text(robot.replace(*edit) if edit[0] else robot)
        found = {one.rule for one in inspect(path, modes=False).findings}
        assert found >= rules if "gravcomp" in edit[1] else found == rules


PENDULUM = """<mujoco><worldbody><body>
  <joint name="shoulder" axis="0 1 0" damping="0.1"/>
  <geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02" mass="1"/><body pos="0 0 -0.5">
  <joint name="elbow" axis="0 1 0" damping="0.1"/>
  <geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02" mass="1"/></body></body></worldbody>
  <actuator><motor name="m" joint="shoulder" ctrlrange="-2 2"/>{more}</actuator>
  <keyframe><key name="raised" qpos="0.5 {elbow}" ctrl="{ctrl}"/></keyframe></mujoco>"""


def test_where_a_joint_without_a_drive_falls_nothing_is_held(tmp_path: Path) -> None:
    """A control that balances the shoulder holds it only where the elbow hangs, or is held."""
    elbow = '<position name="e" joint="elbow" kp="900" kv="30"/>'
    found: list[dict[str, str]] = []
    for angle, more, ctrl in ((-0.3, "", "0.3"), (-0.5, "", "0.3"), (-0.3, elbow, "0.3 -0.3")):
        path = tmp_path / f"{len(found)}.xml"
        path.write_text(PENDULUM.format(elbow=angle, more=more, ctrl=ctrl))
        found.append({one.rule: one.message for one in inspect(path, modes=False).findings})
    falls, hangs, held = found
    rules = {"saturated_actuator", "control_not_holding"}
    assert not rules & set(falls)
    assert rules <= set(hangs)
    assert rules <= set(held)
    weight = 9.81 * (0.25 + 0.5) * math.sin(0.5)
    assert f"m exerts 0.3 Nm, and {weight:.3g} would balance it" in hangs["control_not_holding"]


def test_a_force_that_turns_along_is_no_obstacle(tmp_path: Path) -> None:
    """A thrust in a body's own axes has a stiffness without diagonal; steps have limits still."""
    free = (JOINT, '<freejoint name="swing"/>')
    hovers = (KEY, '<key name="hanging" qpos="0 0 1 1 0 0 0" ctrl="9"/>')
    found = inspect(written(tmp_path, free, hovers, after(GEOM, SITE), after(END, THRUST)))
    assert len(found.steps) == 5
    assert found.exit_code == 0


def test_lines_and_elements_are_those_of_the_text(tmp_path: Path) -> None:
    text = BASE.replace(JOINT, JOINT[:-2] + ' type="hinge"/>')
    line = next(i for i, row in enumerate(text.splitlines(), 1) if 'name="swing"' in row)
    (one,) = inspect(written(tmp_path, text=text), modes=False, strict=True).findings
    assert (one.element, one.file, one.line) == ("joint:swing", "model.xml", line)


def test_lines_in_included_files(tmp_path: Path) -> None:
    body = BASE[BASE.index("    <body") : BASE.index(END)].replace(
        JOINT, JOINT[:-2] + ' margin="1"/>'
    )
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "rod.xml").write_text(f"<mujocoinclude>\n\n{body}</mujocoinclude>")
    around = (
        BASE[: BASE.index("    <body")]
        + '<include file="parts/rod.xml"/>'
        + BASE[BASE.index(END) :]
    )
    (one,) = inspect(written(tmp_path, text=around), modes=False, strict=True).findings
    assert (one.rule, one.file, one.line) == ("unused_setting", "parts/rod.xml", 5)


def test_what_mujoco_warns_of_is_told(tmp_path: Path) -> None:
    flex = (
        '<flexcomp name="cloth" type="grid" count="3 3 1" spacing="0.1 0.1 0.1" radius="0.01">'
        '<contact contype="0" conaffinity="0"/></flexcomp>'
    )
    path = written(tmp_path, (END, flex + END))
    rules = {one.rule: one.message for one in inspect(path, modes=False).findings}
    assert "no equality constraints or passive forces" in rules["compiler_warning"]


# Waivers ------------------------------------------------------------------------------------

TWO = JOINT[:-2] + ' type="hinge" margin="1"/>'


@pytest.mark.parametrize(
    ("waiver", "waived"),
    [
        ("allow repeated_default: it is a joint", {"repeated_default"}),
        ("allow repeated_default, swing: it is\n a joint", {"repeated_default"}),
        ("allow repeated_default, joint:swing: it is a joint", {"repeated_default"}),
        ("allow repeated_default, joint:*: it is a joint", {"repeated_default"}),
        ("allow unused_setting, s*g: for later", {"unused_setting"}),
    ],
)
def test_a_waiver_allows_what_it_names(waiver: str, waived: set[str], tmp_path: Path) -> None:
    found = inspect(
        written(tmp_path, (JOINT, TWO), (KEY, f"<!-- mbcheck: {waiver} -->{KEY}")),
        modes=False,
        strict=True,
    )
    assert {one.rule for one in found.findings if one.waived} == waived
    assert {one.rule for one in found.unwaived} == {"repeated_default", "unused_setting"} - waived
    assert all(
        " a joint" in one.waived or one.waived == "for later"
        for one in found.findings
        if one.waived
    )


@pytest.mark.parametrize(
    ("waiver", "complaint"),
    [
        ("allow repeated_default, other: not here", "waiver_unused"),
        ("allow repeated_default, body:swing: not here", "waiver_unused"),
        ("allow repeated_default", "waiver_reason"),
        ("allow repeated_default, swing:", "waiver_reason"),
        ("allow everything: please", "waiver_unknown"),
        ("ignore repeated_default: please", "waiver_reason"),
    ],
)
def test_a_waiver_that_does_not_hold_is_found_itself(
    waiver: str, complaint: str, tmp_path: Path
) -> None:
    found = inspect(
        written(tmp_path, (JOINT, TWO), (KEY, f"<!-- mbcheck: {waiver} -->{KEY}")),
        modes=False,
        strict=True,
    )
    rules = Counter(one.rule for one in found.unwaived)
    assert rules == {"repeated_default": 1, "unused_setting": 1, complaint: 1}


def test_other_comments_are_no_waivers(tmp_path: Path) -> None:
    path = written(tmp_path, (KEY, f"<!-- see mbcheck: allow -->{KEY}"))
    assert inspect(path, strict=True).findings == ()


def test_a_waived_error_does_not_fail(tmp_path: Path) -> None:
    mistake, _ = MISTAKES["step_limit"]
    waiver = "<!-- mbcheck: allow step_limit, option: a test of instability -->"
    assert inspect(written(tmp_path, *mistake)).exit_code == 1
    found = inspect(written(tmp_path, *mistake, (KEY, waiver + KEY)))
    assert found.exit_code == 0
    assert found.summary == {"error": 0, "warning": 0, "note": 0, "waived": 1}


def test_what_was_not_tried_is_told(tmp_path: Path) -> None:
    """A model that is too large leaves attributes out, says so, and blames no waiver for it."""
    waiver = f"<!-- mbcheck: allow repeated_default, swing: an editor writes it -->{KEY}"
    path = written(tmp_path, joint('type="hinge"'), (KEY, waiver))
    assert inspect(path, modes=False, strict=True).untried is None
    results, untried = repeated_default(inspect(path, modes=False), budget=1.0)
    assert results == []
    assert "not tried" in str(untried)


WEAK = 'position kp="100" kv="5" forcerange="-9 9"'
"""A servo that bears the 8.3 Nm of `HELD`; it gives all its force 0.1 rad from its control."""


def test_a_keyframe_without_controls_is_no_weak_servo(tmp_path: Path) -> None:
    """The servo gives all its force, and more would not help: the keyframe's control is wrong."""
    (found,) = inspect(written(tmp_path, *held(WEAK, key='qpos="0.9"'))).findings
    assert found.rule == "control_not_holding"
    assert "one yields by about -0.983 rad" in found.message
    assert "forcerange" not in found.fix
    stronger = WEAK.replace("9 9", "900 900").replace("-9", "-900")
    (same,) = inspect(written(tmp_path, *held(stronger, key='qpos="0.9"'))).findings
    assert (same.rule, same.message) == (found.rule, found.message)
    mended = held(WEAK, key='qpos="0.9" ctrl="0.983"')
    assert inspect(written(tmp_path, *mended)).findings == ()


def test_the_remedies_of_a_raised_time_constant_hold(tmp_path: Path) -> None:
    """The solref that is printed changes no bit of a run, and the step raises nothing more."""
    mistake = MISTAKES["solref_raised"][0]
    path = written(tmp_path, *mistake)
    (found,) = inspect(path).findings
    step, solref = re.findall('(?:timestep|solref)="([^"]*)"', found.fix)
    text, runs = path.read_text(), []
    assert "-" not in solref
    for old, new in (("", ""), ('solref="0.001 1"', f'solref="{solref}"')):
        path.write_text(text.replace(old, new) if old else text)
        model = mujoco.MjModel.from_xml_path(str(path))
        data = mujoco.MjData(model)
        data.qvel[:] = 1
        mujoco.mj_step(model, data, 500)
        runs.append(data.qpos.copy())
    np.testing.assert_array_equal(*runs)
    assert inspect(path).findings == ()
    path.write_text(text.replace('timestep="0.0009765625"', f'timestep="{step}"'))
    assert "solref_raised" not in {one.rule for one in inspect(path).findings}


def test_limits_say_what_they_do_not_know(tmp_path: Path) -> None:
    touching = (
        (FLAG, ON),
        after(WORLD, '<geom name="floor" type="plane" size="1 1 1" pos="0 0 -3"/>'),
    )
    words = "no contact is active in the state as opened = hanging: "
    dry = "dry friction makes these limits conservative"
    said = [
        " ".join(invoke("inspect", str(written(tmp_path, *edits))).stdout.split())
        for edits in ((), touching, (joint('frictionloss="0.1"'),))
    ]
    assert [(words in text, dry in text) for text in said] == [
        (False, False),
        (True, False),
        (False, True),
    ]
