"""Servos wherever they act: on tendons, in a parent's axes, on ball joints."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest

from mbcheck.comparisons.inspect.inspection import inspect
from mbcheck.tests.support.mjcf.mistakes import (
    END,
    INERTIAL,
    JOINT,
    LIMITED,
    Edits,
    held,
    turned,
    written,
)

UNDAMPED = (' damping="0.1"', "")
HELD = 'qpos="0.9" ctrl="{}"'
"""A keyframe in which the base takes 8.3 Nm: 4.5 of its spring, 3.8 of its weight."""
SERVO = 'position kp="9"'
SLIDE = (JOINT, '<joint name="swing" type="slide" damping="1"/>')
INTEGRATES = 'intvelocity kp="9" kv="1" actrange="{}" ctrlrange="{}"'


def tendon(settings: str = "", coefficient: float = 1.0, more: str = "") -> tuple[str, str]:
    """Return a fixed tendon over the joint, and what else it runs over."""
    part = f'<joint joint="swing" coef="{coefficient:g}"/>{more}'
    return END, f'{END}<tendon><fixed name="cord" {settings}>{part}</fixed></tendon>'


def pulled(*servos: str, key: str = "") -> Edits:
    """Return actuators of the tendon."""
    return tuple(
        (a, b.replace('joint="swing"', 'tendon="cord"')) for a, b in held(*servos, key=key)
    )


def parent(*servos: str) -> Edits:
    """Return actuators in the axes of the joint's parent."""
    return tuple((a, b.replace("joint=", "jointinparent=")) for a, b in held(*servos))


def ball(control: str) -> Edits:
    """Return a ball joint with three servos, turned by 1.2 rad about x, and their controls."""
    *others, (place, key), acts = turned("30")
    return (*others, (place, key.replace("1.2 0 0", control)), acts)


@pytest.mark.parametrize(
    ("rule", "mistake", "mended"),
    [
        (
            "undamped_servo",
            (UNDAMPED, *held(SERVO), tendon()),
            (UNDAMPED, *held(SERVO), tendon('damping="0.5"')),
        ),
        (
            "undamped_servo",
            (UNDAMPED, *held(SERVO), tendon('damping="0.5"', 0.1)),
            (UNDAMPED, *held(SERVO), tendon('damping="0.5"', 0.5)),
        ),
        (
            "undamped_servo",
            (UNDAMPED, tendon(), *pulled(SERVO)),
            (UNDAMPED, tendon(), *pulled(SERVO + ' kv="1"')),
        ),
        ("undamped_servo", (UNDAMPED, *parent(SERVO)), (UNDAMPED, *parent(SERVO + ' kv="1"'))),
        (
            "undamped_servo",
            (UNDAMPED, *held(SERVO, 'damper kv="1" ctrlrange="0 1"', key='ctrl="0 0"')),
            (UNDAMPED, *held(SERVO, 'damper kv="1" ctrlrange="0 1"', key='ctrl="0 1"')),
        ),
        (
            "control_in_degrees",
            (LIMITED, *held(INTEGRATES.format("-90 90", "-1 1"))),
            (LIMITED, *held(INTEGRATES.format("-1.5 1.5", "-90 90"))),
        ),
        (
            "control_beyond_range",
            (LIMITED, *held(INTEGRATES.format("-3 3", "-1 1"))),
            (LIMITED, *held(INTEGRATES.format("-1.5 1.5", "-3 3"))),
        ),
        (
            "control_in_degrees",
            (LIMITED, tendon(), *pulled(SERVO + ' ctrlrange="-90 90"')),
            (
                LIMITED,
                tendon("", 60.0),
                *pulled('position kp="0.01" kv="0.001" ctrlrange="-90 90"'),
            ),
        ),
        (
            "control_beyond_range",
            (tendon('range="-0.1 0.1"', 0.1), *held(SERVO + ' ctrlrange="-2 2"')),
            (tendon('range="-0.2 0.2"', 0.1), *held(SERVO + ' ctrlrange="-2 2"')),
        ),
        (
            "unlimited_joint",
            (tendon(), *pulled(SERVO + ' ctrlrange="-1 1"')),
            (tendon('range="-1 1"'), *pulled(SERVO + ' ctrlrange="-1 1"')),
        ),
        ("two_servos", (tendon(), *pulled(SERVO, SERVO)), (tendon(), *pulled(SERVO, "motor"))),
        (
            "positive_feedback",
            (tendon(), *pulled('general gainprm="1" biastype="affine" biasprm="0 1 0"')),
            (tendon(), *pulled('general gainprm="1" biastype="affine" biasprm="0 -1 0"')),
        ),
        (
            "saturated_actuator",
            (tendon("", 2.0), *pulled('motor ctrlrange="-4 4"', key=HELD.format(4))),
            (tendon("", 2.0), *pulled('motor ctrlrange="-5 5"', key=HELD.format(4))),
        ),
        (
            "saturated_actuator",
            (tendon('actuatorfrcrange="-4 4"', 2.0), *pulled("motor", key=HELD.format(4))),
            (tendon('actuatorfrcrange="-5 5"', 2.0), *pulled("motor", key=HELD.format(4))),
        ),
        (
            "control_not_holding",
            (tendon(), *pulled('position kp="10"', key=HELD.format(0.9))),
            (tendon(), *pulled('position kp="10"', key=HELD.format(1.73))),
        ),
        ("control_not_holding", ball("0 0 0"), ball("1.2 0 0")),
        ("control_not_holding", ball("1.2 0.5 0"), ball("1.2 0.1 0")),
        (
            "light_joint",
            (SLIDE, *held('motor forcerange="-3e6 3e6"')),
            (SLIDE, *held('motor forcerange="-1e5 1e5"')),
        ),
    ],
)
def test_drives_are_seen_where_they_act(
    rule: str, mistake: Edits, mended: Edits, tmp_path: Path
) -> None:
    for edits, rules in ((mistake, {rule}), (mended, set[str]())):
        assert {one.rule for one in inspect(written(tmp_path, *edits)).findings} == rules


@pytest.mark.parametrize(
    ("actuator", "attribute"),
    [
        ('position kp="-3"', "kp"),
        ('velocity kv="-3"', "kv"),
        ('intvelocity kp="-3" actrange="-1 1"', "kp"),
        ('cylinder timeconst="1" bias="0 3 0"', "bias"),
        ('general biastype="affine" biasprm="0 3 0"', "biasprm"),
    ],
)
def test_the_attribute_with_the_wrong_sign_is_named(
    actuator: str, attribute: str, tmp_path: Path
) -> None:
    findings = inspect(written(tmp_path, *held(actuator)), modes=False).findings
    (one,) = [found for found in findings if found.rule == "positive_feedback"]
    assert (one.attribute, one.fix) == (attribute, f"reverse the sign of {attribute}")


def test_the_damping_of_a_tendon_is_that_of_a_run(tmp_path: Path) -> None:
    """It counts with the square of the coefficient, and a ratio of 0.02 lies between these two."""
    ratios = {}
    for coefficient in (0.1, 1.0):
        edits = UNDAMPED, *held(SERVO), tendon('damping="0.5"', coefficient)
        report = inspect(written(tmp_path, *edits))
        ratio = report.views[0].modes[0].damping_ratio
        assert ratio is not None
        ratios[coefficient] = ratio
    assert 0 < ratios[0.1] < 0.02 < ratios[1.0]
    assert ratios[1.0] == pytest.approx(100 * ratios[0.1], rel=1e-6)


def test_what_couples_several_joints_is_left_out(tmp_path: Path) -> None:
    """A servo on it holds no joint alone: neither its range nor its gain is that of one."""
    second = (
        '<body><joint name="tip" axis="0 1 0" stiffness="5" damping="1"/>'
        + INERTIAL
        + "</body></body>"
    )
    chain = (f"    </body>\n{END}", f"{second}{END}")
    both = tendon("", 1.0, '<joint joint="tip" coef="1"/>')
    edits = chain, both, *pulled(SERVO + ' ctrlrange="-90 90"')
    assert inspect(written(tmp_path, *edits)).findings == ()


def test_a_run_leaves_what_controls_of_a_ball_joint_do_not_hold(tmp_path: Path) -> None:
    for control, leaves in (("0 0 0", True), ("1.2 0 0", False)):
        path = written(tmp_path, *ball(control))
        model = mujoco.MjModel.from_xml_path(str(path))
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        start = data.qpos.copy()
        while data.time < 2.0:
            mujoco.mj_step(model, data)
        cosine = 2 * float(data.qpos @ start) ** 2 - 1
        assert (cosine < 0.9) == leaves
