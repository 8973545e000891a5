"""Other engines as readers of one file: what each drops is named, and closed by edits."""

from __future__ import annotations

from pathlib import Path

import pytest

from mbcheck import compare

pytestmark = pytest.mark.foreign

ARM = """<mujoco model="arm"><compiler angle="radian"/><option gravity="0 0 -3.7"/><worldbody>
<body name="upper" pos="0 0 1"><joint name="shoulder" axis="0 1 0" damping=".4" armature=".02"/>
<inertial pos=".2 0 .01" mass="1.5" diaginertia=".01 .02 .025"/>
<body name="lower" pos=".4 0 0"><joint name="elbow" axis="0 1 0" stiffness="3" springref=".3"
damping=".2"/><inertial pos=".15 0 0" mass=".7" diaginertia=".001 .01 .0105"/></body></body>
</worldbody></mujoco>"""

STIFFNESS = "joint elbow: stiffness 3 dropped"
ARMATURE = "joint shoulder: armature 0.02 dropped"

READERS = {
    "pinocchio": [STIFFNESS, "every joint: damping 0.4 0.2 dropped"],
    "drake": [STIFFNESS, ARMATURE],
    "dart": [STIFFNESS, ARMATURE],
    "mbcheck.examples.mjx_engine:MjxEngine": list[str](),
    "mbcheck.examples.mujoco_warp_engine:MujocoWarpEngine": list[str](),
}
"""Reader -> what it drops."""


@pytest.mark.parametrize("reader", READERS)
def test_what_a_reader_drops_is_named_and_closed(reader: str, tmp_path: Path) -> None:
    dropped = READERS[reader]
    file = tmp_path / "arm.xml"
    file.write_text(ARM)
    result = compare(str(file), f"{file}@{reader}")
    assert [one.sentence for one in result.differences] == dropped
    assert result.closed is (True if dropped else None)
