"""An engine as a reader: what it lost is named, and its conventions are no difference."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from mbcheck import compare
from mbcheck.tests.support.command import invoke

READERS = "mbcheck.tests.support.engines.readers"

ARM = """<mujoco><compiler angle="radian"/><worldbody>
<body name="upper" pos="0 0 1"><joint name="shoulder" axis="0 1 0" damping=".4" armature=".02"
  range="-2 2" limited="true"/><geom type="capsule" size=".04" fromto="0 0 0 .4 0 0"/>
<body name="lower" pos=".4 0 0"><joint name="elbow" axis="0 1 0" stiffness="3" springref=".3"
  damping=".2"/><geom type="capsule" size=".03" fromto="0 0 0 .35 0 0"/></body></body>
<body name="ball" pos="2 0 1"><freejoint name="float"/><geom type="box" size=".1 .2 .07"/></body>
</worldbody><actuator><motor name="m1" joint="shoulder" gear="50" ctrlrange="-1 1"
ctrllimited="true"/><position name="p1" joint="elbow" kp="20" kv="1"/></actuator></mujoco>"""

NAMED = {
    "WithoutDamping": ["every joint: damping 0.4 0.2 dropped"],
    "UnitGear": ["actuator m1: gear 50 read as 1"],
    "WithoutGravity": ["option: gravity 0 0 -9.81 dropped"],
    "DegreesAndArmature": [
        "joint elbow: stiffness 3 read as 171.887",
        "joint shoulder: armature 0.02 dropped",
    ],
    "SinglePrecision": ["joint elbow: damping 0.2 dropped"],
    "OtherConventions": ["joint shoulder: damping 0.4 dropped"],
}
"""Reader -> what it lost or misread, in words."""


CHAIN = """<mujoco><compiler angle="radian"/><worldbody>
<body name="a" pos="0 0 1"><joint name="ja" axis="0 1 0" damping=".4" armature=".2" stiffness="2"/>
<inertial pos=".2 0 .01" mass="1.5" diaginertia=".01 .02 .025"/>
<body name="b" pos=".4 0 0"><joint name="jb" axis="1 0 0" damping=".2" armature=".1" stiffness="3"
springref=".3"/><inertial pos=".15 0 .02" mass=".7" diaginertia=".004 .01 .0105"/>
<body name="c" pos=".3 0 0"><joint name="jc" axis="0 0 1" damping=".1" armature=".05"
stiffness="5"/><inertial pos=".1 .05 0" mass=".4" diaginertia=".001 .002 .0025"/>
</body></body></body></worldbody>
<actuator><motor name="m1" joint="ja" gear="50" ctrlrange="-1 1" ctrllimited="true"/></actuator>
</mujoco>"""

ARMATURES = "every joint: armature 0.2 0.1 0.05 dropped"
DAMPINGS = "every joint: damping 0.4 0.2 0.1 dropped"

SEVERAL = {
    "JointsLost": {ARMATURES, DAMPINGS, "every joint: stiffness 2 3 5 dropped"},
    "MassMisread": {ARMATURES, DAMPINGS, "body b: mass 0.7 read as 0.91"},
    "MotorLost": {
        ARMATURES,
        "option: gravity 0 0 -9.81 dropped",
        "actuator m1: gear 50 read as 1",
    },
}
"""Reader -> what it lost or misread at once."""


@pytest.fixture
def chain(tmp_path: Path) -> str:
    path = tmp_path / "chain.xml"
    path.write_text(CHAIN)
    return str(path)


@pytest.mark.parametrize("mass_matrix", ["", "ByMass"])
@pytest.mark.parametrize("reader", SEVERAL)
def test_several_losses_are_named_and_no_wrong_masses(
    chain: str, reader: str, mass_matrix: str
) -> None:
    result = compare(chain, f"{chain}@{READERS}:{reader}{mass_matrix}")
    assert {one.sentence for one in result.differences} == SEVERAL[reader]
    assert result.closed


def test_masses_are_named_only_with_a_proof(chain: str) -> None:
    """A drag remains that no edit of the file explains."""
    result = compare(chain, f"{chain}@{READERS}:Drag")
    assert result.closed is False
    named = {one.attribute for one in result.differences}
    assert not named & {"mass", "inertia", "inertial pos", "armature"}
    result = compare(chain, f"{chain}@{READERS}:DragByMass")
    assert result.closed is False
    named = {one.sentence for one in result.differences}
    assert ARMATURES in named
    assert not {word for word in named if "mass" in word or "inertia" in word}
    assert "mass matrix" not in {gap.quantity for gap in result.left}


def test_a_convention_is_told_only_if_edits_then_close_the_gap(arm: str) -> None:
    result = compare(arm, f"{arm}@{READERS}:OtherOrderWithDrag")
    assert result.closed is False
    assert list(result.conventions) == []


@pytest.fixture
def arm(tmp_path: Path) -> str:
    path = tmp_path / "arm.xml"
    path.write_text(ARM)
    return str(path)


def test_a_reader_that_loses_nothing_is_alike(arm: str) -> None:
    assert compare(arm, f"{arm}@{READERS}:FileReader").exit_code == 0


@pytest.mark.parametrize("reader", NAMED)
def test_what_a_reader_lost_is_named_and_closes_the_gap(arm: str, reader: str) -> None:
    result = compare(arm, f"{arm}@{READERS}:{reader}")
    assert [one.sentence for one in result.differences] == NAMED[reader]
    assert result.closed
    assert result.exit_code == 1
    departs = reader == "OtherConventions"
    assert list(result.conventions) == departs * [
        "joints in alphabetical order",
        "quaternions as (x, y, z, w)",
        "angular velocities in the frame of the world",
    ]


def test_the_example_of_the_page(
    arm: str, clone: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = (clone / "docs/compare.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    (tmp_path / "my_reader.py").write_text(example.replace("print(", "str("))
    monkeypatch.chdir(tmp_path)
    result = compare(arm, f"{arm}@my_reader:MyReader")
    (difference,) = result.differences
    assert f"{difference.sentence}                     {difference.effect:.2g}" in page


def test_a_waiver_allows_a_difference_and_a_stale_one_is_reported(arm: str, tmp_path: Path) -> None:
    other = tmp_path / "other.xml"
    other.write_text(ARM.replace(' damping=".4"', ""))
    waivers = tmp_path / "known.toml"
    entry = '[[waive]]\nrule = "compare"\nelement = "{}"\nreason = "known"\nfile = "arm.xml"\n'
    waivers.write_text(entry.format("joint * damping"))
    words = ("compare", arm, str(other), "--waivers", str(waivers))
    done = invoke(*words)
    assert done.exit_code == 0, done.stdout
    assert "joint shoulder: damping 0.4 dropped (waived: known)" in done.stdout
    assert json.loads(invoke(*words, "--json", "-").stdout)["waived"] == {
        "joint shoulder damping": "known"
    }
    for element in ("shoulder", "joint:shoulder", "joint:shoulder damping"):  # as `inspect` has it
        waivers.write_text(entry.format(element))
        assert invoke(*words).exit_code == 0, element
    waivers.write_text(entry.replace('file = "arm.xml"\n', "").format("joint elbow *"))
    done = invoke(*words)
    assert done.exit_code == 1
    assert "line 1: joint elbow * waives nothing here" in " ".join(done.stdout.split())
    assert "waiver_unused" not in invoke(*words, "--sarif", "-").stdout
    waivers.write_text(entry.format("joint elbow *"))
    done = invoke(*words)
    assert done.exit_code == 1
    assert "joint elbow * is alike, remove the waiver" in " ".join(done.stdout.split())
    assert "waiver_unused" in invoke(*words, "--sarif", "-").stdout
    waivers.write_text(entry.replace("compare", "step_limit"))
    assert invoke(*words).exit_code == 2


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((f"{READERS}:Raises",), "no such joint"),
        ((f"{READERS}:Refuses",), "no actuators"),
        (("exudyn",), "reads no MJCF"),
        (("nowhere:Engine",), "nowhere"),
        (("foo",), "unknown engine 'foo'"),
    ],
)
def test_an_engine_that_cannot_read_it_is_refused(
    arm: str, words: tuple[str], message: str
) -> None:
    refused = invoke("compare", arm, f"{arm}@{words[0]}")
    assert refused.exit_code == 2
    assert message in refused.stderr
    assert "Traceback" not in refused.stderr


def test_an_engine_is_the_second_reader(arm: str) -> None:
    refused = invoke("compare", f"{arm}@{READERS}:FileReader", arm)
    assert refused.exit_code == 2
    assert "mbcheck compare" in refused.stderr
