"""`inspect --diff`: what an importer loses is listed, and equal physics in other words is not."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from mbcheck.comparisons.inspect.difference import Row, model_difference
from mbcheck.comparisons.inspect.inspection import Inspection, inspect

WHOLE = """<mujoco><compiler angle="radian"/>
<option integrator="RK4" gravity="0 0 -9.8" density="1.2"><flag eulerdamp="disable"/></option>
<worldbody><geom name="floor" type="plane" size="2 2 0.1"/><body name="a" pos="0 0 1" gravcomp="1">
  <inertial pos="0 0 0.1" mass="1" diaginertia="0.1 0.2 0.25"/>
  <joint name="x" axis="0 1 0" range="-1 1" springref="0.2" stiffness="3" frictionloss="0.1"
    damping="0.5" armature="0.01" solreflimit="0.03 1" actuatorfrcrange="-5 5"/>
  <geom name="g" type="capsule" size="0.02" fromto="0 0 0 0.1 0 0.3" condim="6" margin="0.01"
    friction="0.7 0.01 0.001" solimp="0.9 0.99 0.01" contype="3"/><site name="t"/>
  <site name="s" pos="0 0 0.1"/>
  <body name="b" pos="0 0 0.3"><joint name="y" type="slide"/><geom size="0.1" mass="1"/>
  <body name="c" pos="0.3 0 0"><joint name="z" axis="0 1 0"/><geom size="0.1" mass="1"/>
  <geom name="box" type="box" size="0.1 0.1 0.2" mass="0.5"/></body></body></body></worldbody>
<contact><exclude body1="a" body2="c"/><pair geom1="floor" geom2="box" condim="4"/></contact>
<tendon><fixed name="f" damping="0.3" springlength="0.1"><joint joint="x" coef="1"/>
<joint joint="y" coef="-2"/></fixed></tendon>
<equality><joint name="e" joint1="z" joint2="y" polycoef="0 0.5 0 0 0"/></equality>
<actuator><position name="p" joint="x" kp="9" kv="3" ctrlrange="-1 1" forcerange="-9 9"/>
<motor name="r" site="t" refsite="s"/></actuator>
<sensor><jointpos name="q" joint="x" noise="0.1"/></sensor>
<keyframe><key name="k" qpos="0.1 0.2 0.3" ctrl="0.1 0"/></keyframe></mujoco>"""


def seen(path: Path) -> Inspection:
    """Inspect a file without modes and rules."""
    return inspect(path, modes=False, ignore=("*",))


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Inspection:
    path = tmp_path_factory.mktemp("whole") / "whole.xml"
    path.write_text(WHOLE)
    return seen(path)


def rows(whole: Inspection, folder: Path, text: str) -> tuple[Row, ...]:
    """Return what differs between the whole model and another."""
    path = folder / "lost.xml"
    path.write_text(text)
    return model_difference(whole, seen(path)).rows


@pytest.mark.parametrize(
    ("lost", "what"),
    [
        (' springref="0.2"', "joint x qpos_spring"),
        (' solreflimit="0.03 1"', "joint x solref"),
        (' actuatorfrcrange="-5 5"', "joint x actfrclimited, joint x actfrcrange"),
        (' range="-1 1"', "joint x limited, joint x range"),
        (' ctrlrange="-1 1"', "actuator p ctrllimited, actuator p ctrlrange"),
        (' friction="0.7 0.01 0.001"', "geom g friction"),
        (' condim="4"', "pair 1 of geom box dim"),
        ('<exclude body1="a" body2="c"/>', "exclude 1 of body a and body c"),
        ('<geom size="0.1" mass="1"/>\n  <geom', "geom 1 of body c"),
        (' integrator="RK4"', "option integrator"),
        (' eulerdamp="disable"', "option disableflags"),
        (' polycoef="0 0.5 0 0 0"', "equality e data"),
        (' qpos="0.1 0.2 0.3"', "key k qpos of joint x"),
        (' ctrl="0.1 0"', "key k ctrl of actuator p"),
        (' noise="0.1"', "sensor q noise"),
        (' refsite="s"', "actuator r trnid"),
    ],
)
def test_a_single_loss_is_listed(whole: Inspection, lost: str, what: str, tmp_path: Path) -> None:
    """By its element and name, and alone: no other element is told to differ."""
    assert lost in WHOLE
    left = "<geom" if lost.endswith("<geom") else ""
    found = [row[0] for row in rows(whole, tmp_path, WHOLE.replace(lost, left, 1))]
    first = what.split(", ")[0]
    assert set(what.split(", ")) <= set(found)
    element = " ".join(first.split()[:2]) if " of " not in first[:9] else first
    others = [row for row in found if not row.startswith((element, "body c"))]
    assert others == []


def test_a_turned_tensor_and_a_tiny_change_are_listed(whole: Inspection, tmp_path: Path) -> None:
    """The principal inertias are the same, and what they belong to is not."""
    inertia = 'diaginertia="0.1 0.2 0.25"'
    turned = WHOLE.replace(inertia, inertia + ' euler="1.5707963267948966 0 0"')
    ((what, before, now),) = rows(whole, tmp_path, turned)
    assert what == "body a inertia"
    for cell, entries in ((before, (0.1, 0.2, 0.25)), (now, (0.1, 0.25, 0.2))):
        np.testing.assert_allclose(
            np.reshape(str(cell).split(), (3, 3)).astype(float), np.diag(entries), atol=1e-12
        )
    ((what, before, now),) = rows(whole, tmp_path, WHOLE.replace('"0.5" arm', '"0.50000001" arm'))
    assert (what, before, now) == ("joint x damping", "0.5", "0.50000001")


def test_equal_physics_in_other_words_does_not_differ(whole: Inspection, tmp_path: Path) -> None:
    """Degrees, classes, names, orders, signs of quaternions, permuted axes of inertia."""
    text = WHOLE.replace('<compiler angle="radian"/>', "").replace(
        'range="-1 1" springref="0.2"',
        f'range="{math.degrees(-1)!r} {math.degrees(1)!r}" springref="{math.degrees(0.2)!r}"',
    )
    for old, new in (
        ('diaginertia="0.1 0.2 0.25"', 'diaginertia="0.2 0.1 0.25" euler="0 0 90"'),
        ('fromto="0 0 0 0.1 0 0.3"', 'fromto="0.1 0 0.3 0 0 0" rgba="1 0 0 1" group="2"'),
        ('pos="0 0 1" gravcomp', 'pos="0 0 1" quat="-1 0 0 0" gravcomp'),
        ('size="2 2 0.1"', 'size="5 5 0.1"'),
        ('body1="a" body2="c"', 'body1="c" body2="a"'),
        ('<position name="p" joint="x" kp="9" kv="3"', GENERAL),
        ('axis="0 1 0" range', 'axis="0 2 0" range'),
        ('<joint name="y" type="slide"/>', '<joint name="y" class="sliding"/>'),
        (
            "<worldbody>",
            '<default><default class="sliding"><joint type="slide"/></default></default>'
            "<worldbody>",
        ),
    ):
        assert old in text
        text = text.replace(old, new, 1)
    assert rows(whole, tmp_path, text) == ()


GENERAL = '<general name="p" joint="x" gainprm="9" biastype="affine" biasprm="0 -9 -3"'
TWO = '<body name="one" pos="0 0 1"><joint name="u"/><geom size="0.1" mass="1"/></body>'
OTHER = '<body name="two" pos="1 0 1"><joint name="w"/><geom size="0.2" mass="1"/></body>'
DRIVES = '<motor name="m" joint="u"/>', '<motor name="n" joint="w" gear="2"/>'


def test_the_order_of_elements_does_not_count(tmp_path: Path) -> None:
    """Neither do their numbers, which references hold, and the places of joints in keyframes."""
    text = (
        "<mujoco><worldbody>{}</worldbody><actuator>{}</actuator><keyframe>{}</keyframe></mujoco>"
    )
    path = tmp_path / "old.xml"
    key = '<key name="k" qpos="{}" ctrl="{}"/>'
    path.write_text(text.format(TWO + OTHER, "".join(DRIVES), key.format("1 2", "3 4")))
    swapped = text.format(OTHER + TWO, "".join(DRIVES[::-1]), key.format("2 1", "4 3"))
    assert rows(seen(path), tmp_path, swapped) == ()
