"""`mbcheck compare`: each loss is named, and equal physics in other words is no difference."""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import mujoco
import numpy as np
import pytest

from mbcheck.comparisons.compare import comparison
from mbcheck.comparisons.compare.comparison import Difference, ModelComparison, compared
from mbcheck.comparisons.compare.elements import Compiled, match_elements
from mbcheck.comparisons.compare.mujoco import probe
from mbcheck.comparisons.compare.reading import Operand, Reading
from mbcheck.models import mjcf
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.documents import validated
from mbcheck.tests.support.mjcf.disguise import disguised, saved
from mbcheck.tests.support.mjcf.large import chain, heap, humanoid
from mbcheck.tests.support.mjcf.losses import LOSSES, WHOLE

CONSEQUENCES = {
    ("joint elbow", "springref"): {("tendon couple", "springlength")},
    ("tendon couple", "coef"): {("tendon couple", "springlength")},
    ("geom ball_geom", "size"): {("body ball", "mass"), ("body ball", "inertia")},
    ("key home", "ctrl"): {("key home", f"ctrl of actuator {name}") for name in ("m1", "p1", "f1")},
}
"""What MuJoCo's compiler computes from an attribute, and which differs with it."""


def compiled(text: str) -> Compiled:
    """Return a model, compiled in this process."""
    return Compiled(probe.compiled(mujoco.MjModel.from_xml_string(text)))


def differences(one: Compiled, other: Compiled) -> list[Difference]:
    """Return the compiled differences beyond round-off."""
    every = comparison.differences_of(one, other, match_elements(one, other))
    return [one for one in every if one.share > comparison.EQUAL]


@pytest.fixture(scope="module")
def whole() -> Compiled:
    return compiled(WHOLE)


@pytest.mark.parametrize(("lost", "left", "element", "attribute"), LOSSES)
def test_a_single_loss_is_named_and_nothing_else(
    whole: Compiled, lost: str, left: str, element: str, attribute: str
) -> None:
    assert lost in WHOLE
    found = {
        (d.element, d.attribute) for d in differences(whole, compiled(WHOLE.replace(lost, left, 1)))
    }
    named = {one for one in found if one[0].startswith(element) and one[1].startswith(attribute)}
    assert named
    assert found - named <= CONSEQUENCES.get((element, attribute), set())


def test_equal_physics_in_other_words_is_no_difference(whole: Compiled) -> None:
    """Degrees, a class, signs and axes of quaternions, lengths of axes, ends of a capsule."""
    text = WHOLE.replace('<compiler angle="radian"/>', "")
    for old, new in (
        ('range="-2 2"', f'range="{math.degrees(-2)!r} {math.degrees(2)!r}"'),
        ('range="-2.5 2.5"', f'range="{math.degrees(-2.5)!r} {math.degrees(2.5)!r}"'),
        ('springref=".3"', f'springref="{math.degrees(0.3)!r}"'),
        (' ref=".1"', f' ref="{math.degrees(0.1)!r}"'),
        ('quat=".9 .1 .2 .3"', 'quat="-1.8 -.2 -.4 -.6"'),
        ('axis="0 0 1"', 'axis="0 0 2"'),
        ('fromto="0 0 0 .35 0 0"', 'fromto=".35 0 0 0 0 0" rgba="1 0 0 1" group="2"'),
        ('body1="upper" body2="hand"', 'body1="hand" body2="upper"'),
        ('size="2 2 .1"', 'size="9 9 .1"'),
        ('<position name="p1" joint="elbow" kp="20" kv="1"/>',
         '<general name="p1" joint="elbow" gainprm="20" biastype="affine" biasprm="0 -20 -1"/>'),
    ):  # fmt: skip
        assert old in text
        text = text.replace(old, new, 1)
    assert differences(whole, compiled(text)) == []


@pytest.mark.parametrize(
    "text", [WHOLE, chain(6), heap(12), "humanoid"], ids=["whole", "chain", "heap", "humanoid"]
)
def test_other_names_and_orders_are_no_difference(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text = humanoid(tmp_path).read_text() if text == "humanoid" else text
    one, other = compiled(text), compiled(disguised(text))
    assert [d for d in differences(one, other) if not d.element.startswith("key")] == []
    assert list(comparison.renamed(one, other, match_elements(one, other)))


WRITTEN = {
    **{scene: next(iter(mjcf.models(scene).values())).path.read_text()
       for scene in ("hula_hoop", "speed_regulator", "rotor_pendulum", "ball_hoop")},
    "inertia of several geoms": """<mujoco><worldbody><body name="thigh"><joint name="j"/>
<geom type="capsule" fromto="0 0 0 0 .01 -.34" size=".06"/>
<body name="shin" pos="0 .01 -.4"><joint name="k"/>
<geom type="capsule" fromto="0 0 0 0 0 -.3" size=".049"/><geom size=".0273" pos=".011 .07 -.3111"/>
<geom type="box" size=".1 .033 .0271" euler="10 20 30"/></body></body></worldbody></mujoco>""",
    "thigh and foot of a public humanoid": """<mujoco><compiler angle="radian"/>
<worldbody><body name="thigh"><joint name="hip"/><geom type="capsule" size=".06 .1822257"
pos="-5.0684e-08 -.202473 0"/><body name="foot"><joint name="ankle"/><geom type="capsule"
size=".03 .0543914" pos="-.0269999975006 -.02 -.01"/><geom type="capsule" size=".03 .0543914"
pos=".0270000024994 -.02 -.01"/></body></body></worldbody></mujoco>""",
    "muscle": """<mujoco><worldbody><site name="hook" pos="0 0 .2"/><body name="load" pos="0 0 .1">
<geom size=".01" mass="1"/><site name="end"/><joint type="slide" axis="0 0 1"/></body></worldbody>
<tendon><spatial name="t" limited="true" range=".075 .105"><site site="hook"/><site site="end"/>
</spatial></tendon><actuator><muscle name="m" tendon="t" scale="25"/></actuator></mujoco>""",
    "turned free body on a string": """<mujoco><worldbody><site name="01" pos=".2 0 1.3"/>
<body pos="-.3 0 1" euler="10 20 30"><freejoint/><geom type="box" size=".1 .2 .3"/>
<site name="12" pos=".1 -.1 .1"/></body></worldbody><tendon><spatial range="0 .6"><site site="01"/>
<site site="12"/></spatial></tendon></mujoco>""",
}  # fmt: skip
"""Models whose copies MuJoCo writes in six digits, from which other quantities are computed."""


@pytest.mark.parametrize("name", WRITTEN)
@pytest.mark.parametrize("order", [1, -1])
def test_a_copy_that_mujoco_saved_is_no_difference(name: str, order: int, tmp_path: Path) -> None:
    (tmp_path / "written.xml").write_text(WRITTEN[name])
    one, other = [WRITTEN[name], saved(tmp_path / "written.xml")][::order]
    assert texts_compared(one, other, tmp_path).findings == []


def test_a_lost_range_of_lengths_of_a_muscle_is_named(tmp_path: Path) -> None:
    (tmp_path / "muscle.xml").write_text(WRITTEN["muscle"])
    text = saved(tmp_path / "muscle.xml")
    other = re.sub(r'lengthrange="[^"]*"', 'lengthrange="0.05 0.2"', text)
    assert other != text
    found = texts_compared(text, other, tmp_path)
    assert [one.id for one in found.differences] == ["actuator m lengthrange"]
    assert found.closed


SEVERAL = """<mujoco><worldbody>
<body><joint name="j" type="slide"/><geom size=".1"/></body>
<body pos="1 0 0"><joint name="b" type="ball"/><geom size=".1"/></body>
<body pos="2 0 0"><joint name="k"/><geom size=".1"/></body></worldbody><actuator>
<dcmotor name="d" joint="j" motorconst="1" resistance="1" input="pos vel" controller="10 0 5"/>
<orientation name="o" joint="b" kp="1"/>
<motor name="m" joint="k" ctrllimited="true" ctrlrange="-3 3" gear="7"/></actuator></mujoco>"""


@pytest.mark.skipif(int(mujoco.__version__[0]) < 4, reason="actuators have one control before 4.0")
@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ('ctrllimited="true" ctrlrange="-3 3"', "", "actuator m ctrlrange"),
        ('gear="7"', 'gear="1"', "actuator m gear"),
        ('kp="1"', 'kp="2"', "actuator o"),
    ],
)
def test_actuators_with_several_controls_and_forces(
    old: str, new: str, named: str, tmp_path: Path
) -> None:
    assert old in SEVERAL
    found = texts_compared(SEVERAL, SEVERAL.replace(old, new), tmp_path)
    assert found.differences
    assert all(one.id.startswith(named) for one in found.differences)
    assert found.closed
    assert texts_compared(SEVERAL, disguised(SEVERAL), tmp_path).findings == []


SMALL = """<mujoco><worldbody><geom type="plane" size="1 1 .1"/><body name="b" pos="0 0 1">
<joint name="j" axis="0 1 0" damping="1"/><joint name="k" axis="1 0 0"/><geom name="g" size=".1"/>
<geom name="drawn" size=".1" pos="0 0 .3" contype="0" conaffinity="0" mass="0"/><site name="s"/>
</body></worldbody><tendon><fixed name="t"><joint joint="j" coef="1"/><joint joint="k" coef="2"/>
</fixed></tendon><actuator><position name="p" joint="j" kp="30" kv="2"/></actuator>
<sensor><jointpos name="q" joint="j"/><gyro name="w" site="s"/></sensor></mujoco>"""

OTHERS = {
    "infinite": ('damping="1"', 'damping="inf"', ["joint j damping"]),
    "not a number": ('damping="1"', 'damping="nan"', ["joint j damping"]),
    "turned site": ('<site name="s"/>', '<site name="s" euler="90 0 0"/>', ["site s quat"]),
    "another sensor": ("<jointpos", "<jointvel", ["sensor q type"]),
    "another joint": ('kp="30" kv="2"', 'kp="30" kv="2" gear="1"', []),
    "retargeted": ('"p" joint="j"', '"p" joint="k"', ["actuator p target"]),
    "stiffness as gear": (
        '<position name="p" joint="j" kp="30" kv="2"/>', '<motor name="p" joint="j" gear="30"/>',
        ["actuator p biasprm", "actuator p biastype", "actuator p gainprm", "actuator p gear"],
    ),
    "drawn only": (
        '<geom name="drawn" size=".1" pos="0 0 .3" contype="0" conaffinity="0" mass="0"/>', "", [],
    ),
    "another order": (
        '<joint joint="j" coef="1"/><joint joint="k" coef="2"/>',
        '<joint joint="k" coef="2"/><joint joint="j" coef="1"/>', [],
    ),
}  # fmt: skip
"""What an adversary tried: text, text in its place, and what is to be named."""


@pytest.mark.parametrize("name", OTHERS)
def test_what_an_adversary_tried(name: str) -> None:
    old, new, wanted = OTHERS[name]
    assert old in SMALL
    found = differences(compiled(SMALL), compiled(SMALL.replace(old, new)))
    assert sorted(f"{d.element} {d.attribute}" for d in found) == wanted


@pytest.mark.parametrize("name", ["not a number", "another sensor", "stiffness as gear"])
def test_edits_that_cannot_be_made_end_nothing(name: str, tmp_path: Path) -> None:
    old, new, wanted = OTHERS[name]
    files = [tmp_path / "a.xml", tmp_path / "b.xml"]
    for file, text in zip(files, (SMALL, SMALL.replace(old, new)), strict=True):
        file.write_text(text)
    done = invoke("compare", *map(str, files))
    assert done.exit_code == 1
    assert all(one.rpartition(" ")[2] in done.stdout for one in wanted)
    validated("compare", json.loads(invoke("compare", *map(str, files), "--json", "-").stdout))


# At states -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Reading]:
    path = tmp_path_factory.mktemp("whole") / "whole.xml"
    path.write_text(WHOLE)
    with Reading(Operand(str(path), "mujoco"), sys.executable) as reading:
        yield reading


def against(first: Reading, path: Path, lost: str, left: str = "") -> ModelComparison:
    """Return what a model with an edit differs in from the whole one."""
    assert lost in WHOLE
    path.write_text(WHOLE.replace(lost, left, 1))
    with Reading(Operand(str(path), "mujoco"), sys.executable) as second:
        return compared(first, second, ("a", "b"))


def test_nothing_differs_from_itself(first: Reading) -> None:
    with Reading(first.operand, sys.executable) as second:
        found = compared(first, second, ("a", "b"))
    assert found.exit_code == 0
    assert {name.split()[0] for name in found.states} >= {"as", "keyframe", "random", "joints"}
    assert any(name.startswith("contact") for name in found.states)


CLOSED = (' damping=".4"', ' range="-2 2" limited="true"', ' gear="50"', ' solref=".005 1"')


@pytest.mark.parametrize("lost", CLOSED)
def test_the_edit_closes_the_gap(first: Reading, lost: str, tmp_path: Path) -> None:
    found = against(first, tmp_path / "lost.xml", lost)
    assert found.gaps
    assert found.closed
    assert len(found.differences) == 1


@pytest.mark.slow
@pytest.mark.parametrize(("lost", "left", "element", "attribute"), LOSSES)
def test_every_gap_that_shows_is_closed(
    first: Reading, lost: str, left: str, element: str, attribute: str, tmp_path: Path
) -> None:
    """All but one: geoms of a lost pair touch by their own friction."""
    found = against(first, tmp_path / "lost.xml", lost, left)
    assert found.exit_code == 1
    assert found.closed in (True, None) or (element, attribute) == ("pair bf", "")


def texts_compared(one: str, other: str, folder: Path, **older: float) -> ModelComparison:
    """Return the comparison of two texts, B as by a release with other defaults of options."""
    files = [folder / "one.xml", folder / "other.xml"]
    for file, text in zip(files, (one, other), strict=True):
        file.write_text(text)
    with ExitStack() as stack:
        first, second = (
            stack.enter_context(Reading(Operand(str(file), "mujoco"), sys.executable))
            for file in files
        )
        answer = dict(second.model.answer)
        for name, value in older.items():
            assert answer[f"opt.{name}"] == answer[f"default.{name}"]
            answer |= {f"{group}.{name}": np.array(value) for group in ("opt", "default")}
        second.model = Compiled(answer)
        return compared(first, second, ("a", "b"))


ROD = """<mujoco><worldbody><geom type="plane" size="1 1 .1"/><body pos="0 0 .1"><freejoint/>
<geom type="capsule" size=".1 .2"/></body></worldbody></mujoco>"""

EGG = ROD.replace('type="capsule" size=".1 .2"', 'type="ellipsoid" size=".1 .2 .3"')
DISTANCE = (
    ROD.replace("</mujoco>", '<sensor><distance geom1="p" geom2="c"/></sensor></mujoco>')
    .replace('type="plane"', 'name="p" type="plane"')
    .replace('type="capsule"', 'name="c" type="capsule"')
)
UNTOUCHED = EGG.replace("<geom type", '<geom contype="0" conaffinity="0" type')
SLEEPY = ROD.replace("<worldbody>", '<option><flag sleep="enable"/></option><worldbody>')


@pytest.mark.parametrize(
    ("text", "option", "value", "idle"),
    [
        (ROD, "sleep_tolerance", 1e-4, True),
        (SLEEPY, "sleep_tolerance", 1e-4, False),
        (ROD, "ccd_iterations", 50, True),
        (EGG, "ccd_iterations", 50, False),
        (UNTOUCHED, "ccd_iterations", 50, True),
        (DISTANCE, "ccd_iterations", 50, False),
        (ROD, "iterations", 50, False),
        (ROD, "impratio", 2, False),
    ],
)
def test_a_changed_default_counts_where_it_may_have_an_effect(
    text: str, option: str, value: float, idle: bool, tmp_path: Path
) -> None:
    found = texts_compared(text, text, tmp_path, **{option: value})
    assert found.exit_code == (not idle)
    assert [one.partition(" ")[0] for one in found.idle_defaults] == idle * ["option:"]
    assert [one.attribute for one in found.differences] == (not idle) * [option]


def test_a_value_that_the_file_gives_is_no_changed_default(tmp_path: Path) -> None:
    other = ROD.replace("<worldbody>", '<option sleep_tolerance="1e-4"/><worldbody>')
    found = texts_compared(ROD, other, tmp_path)
    assert [one.attribute for one in found.differences] == ["sleep_tolerance"]
    assert found.idle_defaults == []


SHORT = """<mujoco><compiler angle="radian"/><worldbody><body name="b" pos=".333 0 1"><joint
name="j" axis="0 1 .3" damping="1.1"/><geom type="box" size=".11 .07 .03" pos=".1 .2 .033"/><geom
type="capsule" size=".04 .1" pos=".1 .2 .333"/><body name="c" pos="0 0 .3"><joint name="k"/>
<inertial pos="0 0 0" mass="1" fullinertia=".03 .04 .05 .001 .002 .003"/></body></body></worldbody>
</mujoco>"""


@pytest.mark.parametrize("angle", ["radian", "degree"])
def test_rounding_by_the_writer_is_no_difference_and_a_change_above_it_is(
    angle: str, tmp_path: Path
) -> None:
    (tmp_path / "short.xml").write_text(SHORT.replace("radian", angle))
    text = saved(tmp_path / "short.xml")
    assert texts_compared(SHORT, text, tmp_path).exit_code == 0
    for old, new, element, attribute in (
        ('damping="1.1"', 'damping="1.10001"', "joint j", "damping"),
        ("0.333 0 1", "0.333001 0 1", "body b", "pos"),
        (*last_digit(text, "diaginertia", 7), "body c", "inertia"),
        (*last_digit(text, "axis", 7), "joint j", "axis"),
    ):
        assert old in text
        found = texts_compared(SHORT, text.replace(old, new), tmp_path)
        assert (element, attribute) in {(one.element, one.attribute) for one in found.differences}


def last_digit(text: str, attribute: str, units: int) -> tuple[str, str]:
    """Return an attribute, and the same with more units of the last digit of its last number."""
    (words,) = set(re.findall(rf' {attribute}="([^"]*)"', text))
    word = words.split()[-1]
    unit = 10.0 ** -len(word.partition(".")[2])
    return words, words.replace(word, f"{float(word) + units * unit:.{len(word) - 2}f}")


def limbs(joint: str = "", motor: str = "", count: int = 9) -> str:
    """Return a chain of joints, each with a motor, and a ball; attributes of all."""
    inner, motors = "", ""
    for i in reversed(range(count)):
        inner = (
            f'<body pos=".1 0 0"><joint name="j{i}" axis="0 {i % 2} {1 - i % 2}" {joint}/><geom '
            f'type="capsule" size=".02" fromto="0 0 0 .1 0 0" contype="0"/>{inner}</body>'
        )
        motors += f'<motor name="m{i}" joint="j{i}" gear="2" {motor}/>'
    ball = '<body><joint name="s" type="ball" range="0 .7"/><geom size=".1"/></body>'
    return (
        f'<mujoco><compiler angle="radian"/><worldbody>{inner}{ball}</worldbody>'
        f"<actuator>{motors}</actuator></mujoco>"
    )


@pytest.mark.parametrize(
    ("joint", "motor", "lost"),
    [
        ('range="-.4 .3"', "", 'range="-.4 .3"'),
        ("", "", 'range="0 .7"'),
        ('actuatorfrcrange="-70 70"', "", 'actuatorfrcrange="-70 70"'),
        ("", 'forcerange="-25 25"', 'forcerange="-25 25"'),
        ("", 'ctrlrange="-9 9"', 'ctrlrange="-9 9"'),
    ],
)
@pytest.mark.parametrize("is_new", [False, True])
def test_a_lost_or_new_range_of_any_element_has_an_effect(
    joint: str, motor: str, lost: str, is_new: bool, tmp_path: Path
) -> None:
    text = limbs(joint, motor)
    before, _, after = text.rpartition(lost)
    texts = (before + after, text) if is_new else (text, before + after)
    (one,) = texts_compared(*texts, tmp_path).differences
    assert one.attribute == lost.partition("=")[0]
    assert one.effect
    assert one.effect > 1e-3


def test_effects_are_relative_to_each_joint(tmp_path: Path) -> None:
    """A wrist beside a shoulder that is a million times as fast; round-off has no effect."""
    text = """<mujoco><worldbody><body><joint name="fast"/><geom size=".01" contype="0"/></body>
    <body pos="0 0 1"><joint name="slow" damping="1e-3"/><geom size=".1" mass="9" contype="0"
    pos=".1 0 0"/><site name="s"/></body></worldbody><actuator><motor joint="fast" gear="1e3"/>
    </actuator></mujoco>"""
    (one,) = texts_compared(text, text.replace("1e-3", "1e-1"), tmp_path).differences
    assert one.element == "joint slow"
    assert one.effect == pytest.approx(99)  # (0.1 - 0.001) / 0.001: nothing else acts on it
    (still,) = texts_compared(text, text.replace('"s"', '"s" pos=".1 0 0"'), tmp_path).differences
    assert still.effect == 0


def test_a_change_that_only_a_step_shows_has_no_effect_and_says_so(tmp_path: Path) -> None:
    other = SMALL.replace("<worldbody>", '<option timestep=".004"/><worldbody>')
    (one,) = texts_compared(SMALL, other, tmp_path).differences
    assert (one.id, one.effect) == ("option timestep", 0)
    assert one.seen.startswith("step of Euler, ")
    files = [str(tmp_path / f"{name}.xml") for name in ("one", "other")]
    assert f"0 (seen: {one.seen})" in " ".join(invoke("compare", *files).stdout.split())


SERVO = """<mujoco><worldbody><body><joint name="j" range="-40 40" springref="20" stiffness="3"/>
<geom size=".1" pos=".2 0 0" mass="1"/></body></worldbody><actuator>
<position name="p" joint="j" kp="10" dampratio=".7" gear="3"/></actuator></mujoco>"""


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ('kp="10"', 'kp="20"', {"actuator p: kp 10 read as 20"}),
        ('mass="1"', 'mass="2"', {"body 1 of body world: mass 1 read as 2"}),
        ('dampratio=".7"', 'dampratio=".8"', {"actuator p: kv 0.309552 read as 0.353773"}),
        ('springref="20"', "", {"joint j: springref 0.349066 rad dropped"}),
        (' range="-40 40"', "", {"joint j: range -0.698132 0.698132 rad dropped"}),
        ('stiffness="3"', 'stiffness="inf"', {"joint j: stiffness 3 read as inf"}),
    ],
)
def test_what_follows_from_a_ratio_is_no_difference_and_angles_have_a_unit(
    old: str, new: str, named: set[str], tmp_path: Path
) -> None:
    """`kv` follows from `kp` and the mass where a file gives `dampratio`; its edit is not lost."""
    found = texts_compared(SERVO, SERVO.replace(old, new), tmp_path)
    sentences = {one.sentence for one in found.differences}
    assert {one for one in sentences if " inertia " not in one} == named
    assert found.closed or "inf" in new


def test_numbers_of_a_table_differ(tmp_path: Path) -> None:
    (tmp_path / "one.xml").write_text(SMALL)
    (tmp_path / "other.xml").write_text(SMALL.replace('damping="1"', 'damping="1.0000001"'))
    files = [str(tmp_path / f"{name}.xml") for name in ("one", "other")]
    shown = invoke("compare", *files).stdout.partition("differ most")[2]
    numbers = re.findall(r"joint j +(\S+) +(\S+)", shown)
    assert numbers
    assert all(a != b for a, b in numbers)


# The command ---------------------------------------------------------------------------------


def test_command_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Exit codes 0, 1 and 2; documents that have the numbers; the same bytes twice."""
    monkeypatch.chdir(tmp_path)
    Path("a.xml").write_text(WHOLE)
    Path("b.xml").write_text(WHOLE.replace(' kp="20"', ' kp="2"'))
    Path("broken.xml").write_text("<mujoco><worldbody><body/>")
    assert invoke("compare", "a.xml", "a.xml").exit_code == 0
    done = invoke("compare", "a.xml", "b.xml")
    assert done.exit_code == 1
    assert "actuator p1: kp 20 read as 2" in done.stdout
    assert "closes the gap" in done.stdout
    documents = [invoke("compare", "a.xml", "b.xml", "--json", "-").stdout for _ in range(2)]
    assert documents[0] == documents[1]
    found = json.loads(documents[0])
    validated("compare", found)
    assert found["differences"][0]["element"] == "actuator p1"
    for words, message in (
        (("a.xml", "nowhere.xml"), "nowhere.xml"),
        (("a.xml", "broken.xml"), "cannot compile"),
        (("a.xml", "a.xml@mujoco==0.1"), "--install"),
        (("a.xml", "a.xml@mujoco==3.3.7 --foo"), "no release"),
        (("a.xml", "."), "no file"),
        (("a.xml", "a.xml@/nowhere/python"), "no Python"),
        (("a.xml", "a.xml@/bin/true"), "ended without an answer"),
    ):
        refused = invoke("compare", *words)
        assert refused.exit_code == 2, words
        assert message in refused.stderr


def test_findings_of_sarif_and_junit_name_the_element(tmp_path: Path) -> None:
    for name, text in (("a", WHOLE), ("b", WHOLE.replace(' gear="50"', ""))):
        (tmp_path / f"{name}.xml").write_text(text)
    files = [str(tmp_path / f"{name}.xml") for name in "ab"]
    sarif = json.loads(invoke("compare", *files, "--sarif", "-").stdout)
    (result,) = sarif["runs"][0]["results"]
    assert result["message"]["text"] == "actuator m1: gear 50 read as 1"
    assert 'failures="1"' in invoke("compare", *files, "--junit", "-").stdout
