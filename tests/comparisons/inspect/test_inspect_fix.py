"""`inspect --fix`, `--budget`, and baselines that notice what has become worse."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from mbcheck.comparisons.inspect.fixes import neutral_edit
from mbcheck.comparisons.inspect.inspection import inspect, inspect_in_parts
from mbcheck.comparisons.inspect.mujoco.model import load
from mbcheck.comparisons.inspect.request import InspectRequest
from mbcheck.comparisons.inspect.rules.table import RULES
from mbcheck.tests.support.command import invoke, refusal, succeeds
from mbcheck.tests.support.documents import validated
from mbcheck.tests.support.mjcf import large
from mbcheck.tests.support.mjcf.mistakes import JOINT, held, written

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.usefixtures("own_folder")

MODEL = """<mujoco model="links">
  <!-- angles: radians -->
  <compiler angle="radian"/>
  <option timestep="0.002" gravity="0 0 -9.81"
          solver = 'Newton'/>
  <default>
    <joint damping="0"/>
    <geom size="0.05"/>
  </default>
  <worldbody>
    <body name="one"> <joint name="hinge"   axis="0 1 0" damping="0" ref="0"/>
      <geom type="sphere" size="0.05" rgba="1 0 0 1" pos="0.1 0 0"/>
    </body>
  </worldbody>
</mujoco>
"""


def bits(path: Path) -> bytes:
    """Return a file as MuJoCo compiles it."""
    loaded = load(path)
    return loaded.dumped(loaded.model)


def test_a_fix_changes_no_bit_of_the_model() -> None:
    path = Path("links.xml")
    path.write_text(MODEL)
    before = bits(path)
    done = invoke("inspect links.xml --fix --dry-run")
    assert done.exit_code == 1
    assert path.read_text() == MODEL
    assert "-  <option timestep=" in done.stdout
    assert "same to the last bit" in done.stderr
    succeeds("inspect links.xml --fix")
    after = path.read_text()
    assert bits(path) == before
    for gone in ("gravity=", "Newton", 'ref="0"', 'axis="0 0 1"'):
        assert gone not in after
    for stays in ("<!-- angles: radians -->", 'rgba="1 0 0 1"', 'name="hinge"', 'angle="radian"'):
        assert stays in after
    # a size that the default gives as well, or the default: one of them has to stay
    assert after.count('size="0.05"') == 1
    assert invoke("inspect links.xml --fix --dry-run").stdout == ""
    assert invoke("inspect links.xml --fix --dry-run").exit_code == 0


def test_what_would_change_a_bit_stays() -> None:
    """Iterations that no constraint asks for are in vain, and still a number of the model."""
    Path("links.xml").write_text(MODEL.replace("solver = 'Newton'", 'iterations="50"'))
    edit = neutral_edit(InspectRequest("links.xml"))
    assert b'iterations="50"' in edit.after
    assert edit.refused == 2  # and one of two sizes that say the same
    assert "2 findings left unchanged" in edit.summary


def test_waived_and_foreign_attributes_stay() -> None:
    Path("links.xml").write_text(
        MODEL.replace("<default>", '<include file="part.xml"/>\n<default>')
    )
    part = '<mujoco><visual><map znear="0.01"/></visual></mujoco>'
    Path("part.xml").write_text(part)
    reason = "<!-- mbcheck: allow unused_option, option: told on purpose -->"
    Path("links.xml").write_text(reason + Path("links.xml").read_text())
    succeeds("inspect links.xml --fix")
    assert Path("part.xml").read_text() == part
    assert "Newton" in Path("links.xml").read_text()


def test_its_options_belong_together() -> None:
    Path("links.xml").write_text(MODEL)
    assert "--dry-run is for --fix" in refusal("inspect links.xml --dry-run")
    assert "no_such.xml" in refusal("inspect no_such.xml --fix")


# Baselines ----------------------------------------------------------------------------------

STIFF = """<mujoco><option timestep="{}"/><worldbody><body>
<joint name="spring" type="slide" stiffness="1000"/><geom size="0.1" mass="1" contype="0"/>
</body></worldbody></mujoco>"""


def test_a_baseline_notices_what_is_worse() -> None:
    """Twice the step beyond the limit is news; a little more of it, or less, is not."""
    words = "inspect spring.xml --select step_limit"
    Path("spring.xml").write_text(STIFF.format(0.07))
    assert invoke(f"{words} --json old.json").exit_code == 1
    for step, code in ((0.07, 0), (0.072, 0), (0.0651, 0), (0.14, 1)):
        Path("spring.xml").write_text(STIFF.format(step))
        done = invoke(f"{words} --baseline old.json")
        assert done.exit_code == code
    assert "worse than the baseline's 1.11: now 2.21" in " ".join(done.stdout.split())


# Time ---------------------------------------------------------------------------------------


def test_what_there_is_no_time_for_is_told() -> None:
    """Modes of a long chain take minutes."""
    Path("chain.xml").write_text(large.chain(450))
    done = invoke("inspect chain.xml --budget 4 --modes --json out.json")
    assert done.exit_code == 1
    assert "stopped before modes; " in " ".join(done.stdout.split())
    answer = validated("inspect", json.loads(Path("out.json").read_text()))
    assert "rule step_limit" in answer["left_out"]
    Path("spring.xml").write_text(STIFF.format(0.07))
    done = invoke("inspect spring.xml --budget 1e6")
    assert done.exit_code == 1
    assert "state as opened" in done.stdout
    assert "  1 mode, not at rest" in done.stdout
    assert "--budget must be a positive number" in refusal("inspect spring.xml --budget 0")


def test_masses_and_drives_come_before_what_takes_time(tmp_path: Path) -> None:
    """What is found before the modes holds in the whole inspection, which finds no more here."""
    path = written(tmp_path, (JOINT, JOINT.replace("0.1", "0")), *held('position kp="9"'))
    so_far = next(
        report() for left, report in inspect_in_parts(InspectRequest(path)) if left[0] == "modes"
    )
    assert [one.rule for one in so_far.findings] == ["undamped_servo"]
    late = {name for name, rule in RULES.items() if rule.needs in ("states", "modes", "runs")}
    assert {part.removeprefix("rule ") for part in so_far.left_out[3:]} == late - {
        name for name in late if RULES[name].house
    }
    assert inspect(path).findings == so_far.findings


def test_a_name_is_told_once_where_there_are_several() -> None:
    Path("models").mkdir()
    for name in ("a.xml", "b.xml"):
        Path("models", name).write_text("<mujoco><worldbody><body></worldbody></mujoco>")
    done = invoke("inspect models/a.xml models/b.xml")
    assert done.exit_code == 2
    lines = done.stderr.splitlines()
    assert [line.count(".xml") for line in lines] == [1, 1]
    assert "models/a.xml is not XML" in lines[0]
