"""Stable steps where they depend on the step, on friction, on drag; growth, and fixes that hold."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from mbcheck.comparisons.inspect.inspection import ModelFinding, inspect
from mbcheck.comparisons.inspect.mujoco.model import load
from mbcheck.comparisons.inspect.rules.remedies import stays_finite
from mbcheck.comparisons.inspect.views import growing, growth_in_run, state_views
from mbcheck.tests.support.command import invoke
from mbcheck.tests.support.mjcf.mistakes import JOINT, KEY, MISTAKES, written

SLIDER = """<mujoco><option timestep="{step}" gravity="0 0 0" {option}>
  <flag contact="disable" {flag}/></option><worldbody><body name="a">
  <joint name="x" type="slide" {joint}/><geom size="0.1" mass="1"/></body></worldbody>{more}
  </mujoco>"""
HELD = '<equality><joint name="lock" joint1="x" solref="0.002 0.3"/></equality>'


def slider(folder: Path, joint: str = "", more: str = "", **options: object) -> Path:
    path = folder / "model.xml"
    values = {"step": 0.002, "option": "", "flag": ""} | options
    path.write_text(SLIDER.format(joint=joint, more=more, **values))
    return path


def grows(path: Path, integrator: str, step: float, steps: int = 4000) -> bool:
    """Return whether MuJoCo's own run blows up."""
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.timestep = step
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    data = mujoco.MjData(model)
    data.qvel[:] += 1e-3
    for _ in range(steps):
        mujoco.mj_step(model, data)
        if not np.all(np.abs(data.qvel) < 1e3):
            return True
    return False


def found(path: Path, rule: str) -> list[ModelFinding]:
    return [one for one in inspect(path).findings if one.rule == rule]


@pytest.mark.parametrize(
    ("joint", "more", "options", "setter"),
    [
        ('stiffness="4000"', HELD, {"step": 0.0002}, "equality lock"),
        ('stiffness="4000"', HELD, {"flag": 'refsafe="disable"'}, "equality lock"),
        ('stiffness="4000" frictionloss="0.01"', "", {}, "x"),
        ('stiffness="4000"', "", {"option": 'density="1000"'}, "x"),
    ],
)
def test_limits_are_those_of_runs(
    joint: str, more: str, options: dict[str, object], setter: str, tmp_path: Path
) -> None:
    """Stable 2 % below, and not 2 % above: closures at any step, friction that slides, drag."""
    path = slider(tmp_path, joint, more, **options)
    limit = next(one for one in inspect(path).steps if one.of_file)
    assert limit.place == setter
    assert not grows(path, "Euler", 0.98 * limit.limit)
    assert grows(path, "Euler", 1.02 * limit.limit)


WELDED = """<mujoco><worldbody>
  <body name="a"><freejoint/><geom size="1" pos="7 0 0"/></body>
  <body name="b"><freejoint/><geom size="1" pos="8.5 0 0"/></body></worldbody>
  <equality><weld body1="a" body2="b"/></equality></mujoco>"""

TIED = """<mujoco><option timestep="0.002"><flag contact="disable"/></option><worldbody>
  <body name="a"><freejoint/><geom size="0.1" mass="1"/><site name="a"/></body>
  <body name="b" pos="9 0 0"><freejoint/><geom size="0.1" mass="1"/><site name="b"/></body>
  </worldbody><tendon><spatial stiffness="2000"><site site="a"/><site site="b"/></spatial></tendon>
  </mujoco>"""


def test_roundoff_of_rigid_modes_limits_no_step(tmp_path: Path) -> None:
    """Welded spheres that overlap, in free fall: they part as fast with a fifth of the step."""
    path = tmp_path / "model.xml"
    path.write_text(WELDED)
    result = inspect(path)
    assert not [one for one in result.findings if one.rule == "step_limit"]
    assert not [mode for view in result.views for mode in view.modes if mode.kind == "unstable"]
    assert not grows(path, "Euler", 0.002)


def test_rigid_modes_hide_no_limit(tmp_path: Path) -> None:
    """Two free bodies on a spring: omega = sqrt(2 k / m), stable up to 2 / omega."""
    path = tmp_path / "model.xml"
    path.write_text(TIED)
    limit = next(one for one in inspect(path).steps if one.of_file)
    assert limit.limit == pytest.approx(2 / math.sqrt(4000), rel=1e-3)


def test_a_closure_that_the_step_softens_sets_no_limit(tmp_path: Path) -> None:
    """With 5 ms at 2 ms: at 20 ms `refsafe` has raised it, and the run stays bounded."""
    held = HELD.replace("0.002 0.3", "0.005 1")
    path = slider(tmp_path, 'stiffness="0"', held)
    assert not grows(path, "Euler", 0.02)
    assert next(one for one in inspect(path).steps if one.of_file).limit == math.inf
    off = slider(tmp_path, 'stiffness="0"', held, flag='refsafe="disable"')
    limit = next(one for one in inspect(off).steps if one.of_file)
    assert limit.constraint == "equality lock"
    assert grows(off, "Euler", 1.02 * limit.limit)


def test_drag_is_no_damper_at_rest(tmp_path: Path) -> None:
    path = slider(tmp_path, 'stiffness="4000"', option='density="1000" viscosity="0"')
    (view,) = inspect(path).views
    assert view.linear is not None
    assert abs(view.linear.parts.damping[0, 0]) < 1e-9
    path = slider(tmp_path, 'stiffness="4000"', option='density="0" viscosity="2"')
    (view,) = inspect(path).views
    assert view.linear is not None
    assert view.linear.parts.damping[0, 0] == pytest.approx(
        6 * math.pi * 2 * 0.1, rel=0.3
    )  # Stokes


def test_a_filter_has_a_step_of_its_own(tmp_path: Path) -> None:
    motor = '<general name="m" joint="x" dyntype="{}" dynprm="0.01"/>'
    for kind, limit in (("filter", 0.02), ("filterexact", math.inf)):
        actuator = f"<actuator>{motor.format(kind)}</actuator>"
        found_limit = next(
            one for one in inspect(slider(tmp_path, 'damping="1"', actuator)).steps if one.of_file
        )
        assert found_limit.limit == limit
        assert (found_limit.joint == "activation of m") == (kind == "filter")


def test_what_limits_leave_out_is_told(tmp_path: Path) -> None:
    """A body that spins has no constant modes; Euler feeds its precession until the run fails."""
    edits, mended = MISTAKES["run_fails"]
    text = invoke("inspect", written(tmp_path, *edits)).stdout
    assert "left out of these limits: the state hanging" in " ".join(text.split())
    assert 'fix: integrator="implicitfast"' in " ".join(text.split())
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "model.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    for _ in range(640):
        mujoco.mj_step(model, data)
    assert data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number
    assert invoke("inspect", written(tmp_path, *mended)).exit_code == 0


@pytest.mark.parametrize(
    ("position", "stiffness", "untold", "rules"),
    [
        ("2.5", "1", True, set()),
        ("3.141592653589793", "4.88", True, set()),
        ("3.141592653589793", "4", False, {"unstable_equilibrium"}),
        ("0.5", "1", False, set()),
    ],
)
def test_growth_is_a_finding_or_said_to_be_none(
    position: str, stiffness: str, untold: bool, rules: set[str], tmp_path: Path
) -> None:
    """A pendulum with a spring that holds it: on its way, upright and slow or not, and at rest."""
    place = f' springref="{position}"' if float(position) > 3 else ""
    spring = JOINT.replace('"5"', f'"{stiffness}"{place}')
    path = written(tmp_path, (JOINT, spring), (KEY, KEY.replace("/>", f' qpos="{position}"/>')))
    text = " ".join(invoke("inspect", path).stdout.split())
    assert ("an unstable mode here is no finding " in text) == untold
    assert {one.rule for one in inspect(path).findings} == rules


SPINNING = """<mujoco><option timestep="{step:g}" gravity="0 0 0" integrator="{integrator}"/>
  <worldbody><body name="p"><freejoint/><geom type="ellipsoid" size="0.3 0.05 0.02" mass="1"/>
  </body></worldbody><keyframe><key name="s" qvel="0 0 0 3 60 5"/></keyframe></mujoco>"""


def speed_after(seconds: float, step: float, integrator: str) -> float:
    """Return the speed [rad/s] of the body of `SPINNING`; infinite if its run fails."""
    model = mujoco.MjModel.from_xml_string(SPINNING.format(step=step, integrator=integrator))
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    while data.time < seconds:
        mujoco.mj_step(model, data)
    failed = data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number
    return math.inf if failed else float(np.linalg.norm(data.qvel[3:]))


def test_a_fix_does_not_only_postpone_the_failure(tmp_path: Path) -> None:
    """With a fifth of the step the run gains energy all the time, and fails at 8 s, not at once."""
    path = tmp_path / "model.xml"
    path.write_text(SPINNING.format(step=0.002, integrator="Euler"))
    (failure,) = found(path, "run_fails")
    assert failure.fix.startswith('integrator="implicitfast"')
    assert "timestep" not in failure.fix
    assert speed_after(5.0, 0.0004, "Euler") > 120
    assert speed_after(10.0, 0.0004, "Euler") == math.inf
    assert speed_after(10.0, 0.002, "implicitfast") < 80


def test_energy_that_only_swings_is_no_growth(tmp_path: Path) -> None:
    """Of a pendulum's run by Euler's steps the energy swings, and that of a fall is no gain."""
    swings = SLIDER.replace('gravity="0 0 0"', "").replace(
        'type="slide"', 'axis="0 1 0" pos="0 0 1"'
    )
    for joint in ("", 'damping="0.01"', 'stiffness="40"'):
        path = tmp_path / "model.xml"
        path.write_text(swings.format(step=0.002, option="", flag="", joint=joint, more=""))
        loaded = load(path)
        assert stays_finite(loaded, loaded.states[0]._replace(position=np.array([1.5])))


# Two cases after reports of users -----------------------------------------------------------

LINK = '<inertial pos="0 0 -0.05" mass="0.1" diaginertia="1e-3 1e-3 1e-3"/>'
ARM = f"""<mujoco><compiler angle="radian"/><option timestep="0.002" integrator="{{integrator}}"/>
  <worldbody><body><joint name="j1" axis="0 1 0" {{joint}}/>{LINK}
  <body pos="0 0 -0.1"><joint name="j2" axis="0 1 0" {{joint}}/>{LINK}</body></body></worldbody>
  <actuator><position name="a1" joint="j1" kp="2000" kv="100"/>
  <position name="a2" joint="j2" kp="2000" kv="100"/></actuator></mujoco>"""


def arm(folder: Path, integrator: str = "Euler", joint: str = "") -> Path:
    path = folder / "arm.xml"
    path.write_text(ARM.format(integrator=integrator, joint=joint))
    return path


def test_an_arm_of_stiff_servos_without_armature(tmp_path: Path) -> None:
    """Under Euler at 2 ms it fails; it is told that implicitfast, or armature, is stable."""
    report = inspect(arm(tmp_path))
    (one,) = [item for item in report.findings if item.severity == "error"]
    assert report.exit_code == 1
    assert one.rule == "step_limit"
    assert one.fix.startswith('integrator="implicitfast"')
    match = re.search(r'armature="([\d.]+)" on joints j1, j2', one.fix)
    assert match is not None
    assert 0.1 <= float(match[1]) < 0.2
    damping = re.search(r'damping="[\d.]+"', one.fix)
    assert damping is not None
    for edit in (
        {"integrator": "implicitfast"},
        {"joint": match[0].partition(" ")[0]},
        {"joint": damping[0]},
    ):
        path = arm(tmp_path, **edit)
        assert inspect(path).exit_code == 0
        assert not grows(path, edit.get("integrator", "Euler"), 0.002, 2500)
    assert grows(arm(tmp_path), "Euler", 0.002)
    gain = re.search(r"([\d.]+) times the gains \(kp, kv\) of a1, a2", one.fix)
    assert gain is not None
    path = arm(tmp_path)
    softer = f'kp="{2000 * float(gain[1])}" kv="{100 * float(gain[1])}"'
    path.write_text(path.read_text().replace('kp="2000" kv="100"', softer))
    assert inspect(path).exit_code == 0
    assert not grows(path, "Euler", 0.002, 2500)


BALL = """<mujoco><compiler angle="radian"/>
  <option timestep="0.001" gravity="0 0 0" integrator="implicitfast"/><worldbody><body>
  <joint name="wrist" type="ball" {joint}/>
  <inertial pos="0 0 0" mass="1" diaginertia=".01 .02 .03"/></body></worldbody><actuator>
  <position name="ax" joint="wrist" gear="1 0 0" kp="20" forcerange="-90 90"/>
  <position name="ay" joint="wrist" gear="0 1 0" kp="20"/>
  <position name="az" joint="wrist" gear="0 0 1" kp="20"/></actuator>
  <keyframe><key name="off" qpos="{quat}" ctrl="{ctrl}"/></keyframe></mujoco>"""


def ball(folder: Path, turn: float, joint: str = "") -> Path:
    path = folder / "ball.xml"
    quat = f"{math.cos(turn / 2)!r} {math.sin(turn / 2)!r} 0 0"
    path.write_text(BALL.format(quat=quat, ctrl=f"{turn!r} 0 0", joint=joint))
    return path


def test_a_drive_on_a_ball_joint_feeds_a_mode(tmp_path: Path) -> None:
    """Off identity its stiffness has a rotational part: 20 (1.2 / 2) beside 20 (0.6 cot 0.6)."""
    report = inspect(ball(tmp_path, 1.2))
    assert report.exit_code == 1
    (one,) = [item for item in report.findings if item.severity == "error"]
    assert (one.rule, one.element) == ("unstable_mode", "joint:wrist")
    assert "actuators ay, az feed it" in one.message
    match = re.fullmatch(r'(damping="[\d.]+") on joint wrist', one.fix)
    assert match is not None
    assert inspect(ball(tmp_path, 1.2, match[1])).exit_code == 0
    assert inspect(ball(tmp_path, 0.0)).exit_code == 0
    linear = report.views[-1].linear
    assert linear is not None
    assert linear.parts.stiffness[1:, 1:] == pytest.approx(
        20 * np.array([[0.6 / math.tan(0.6), -0.6], [0.6, 0.6 / math.tan(0.6)]]), rel=1e-6
    )


STIFF = """<mujoco><compiler angle="radian"/>
  <option timestep="{step}" gravity="0 0 0"/><worldbody><body>
  <joint name="shoulder" axis="0 1 0" damping="0.1"/>
  <inertial pos="0.15 0 0" mass="0.4" diaginertia="0.001 0.003 0.003"/><body pos="0.3 0 0">
  <joint name="elbow" axis="0 1 0" stiffness="{stiffness}"/>
  <inertial pos="0.15 0 0" mass="0.2" diaginertia="0.001 0.002 0.002"/></body></body></worldbody>
  <actuator><position name="s" joint="shoulder" kp="{kp}"/></actuator></mujoco>"""


def stiff(folder: Path, kp: float = -5, **settings: object) -> Path:
    """Return an arm whose elbow is stiff: a servo of negative gain turns it out of its place."""
    path = folder / "stiff.xml"
    path.write_text(STIFF.format(kp=kp, **{"step": 0.0002, "stiffness": 5e4} | settings))
    return path


def test_growth_beside_a_stiff_joint_is_seen(tmp_path: Path) -> None:
    """The arm turns as one: (I s^2 + c s - 5) = 0."""
    inertia = 0.003 + 0.4 * 0.15**2 + 0.002 + 0.2 * 0.45**2
    rate = (-0.1 + math.sqrt(0.1**2 + 4 * 5 * inertia)) / (2 * inertia)
    path = stiff(tmp_path)
    (one,) = [item for item in inspect(path).findings if item.severity == "error"]
    assert (one.rule, one.element) == ("unstable_mode", "joint:shoulder")
    assert f"({rate:.3g} 1/s)" in one.message
    assert one.fix == "reverse the sign of kp of s"
    assert grows(path, "Euler", 0.0002, 12000)
    assert not grows(stiff(tmp_path, kp=5), "Euler", 0.0002, 12000)


class Counted:
    """MuJoCo's library, with the number of its steps."""

    steps = 0

    def __getattr__(self, name: str) -> Any:
        """Return a member of the library."""
        return getattr(mujoco, name)

    def mj_step(self, *arguments: Any) -> None:
        """Make a step."""
        self.steps += 1
        mujoco.mj_step(*arguments)


def test_a_run_that_confirms_growth_resolves_no_other_mode(tmp_path: Path) -> None:
    """RK4 must only not feed them: 2 steps in 1 / omega of the fastest, where 40 were made."""
    loaded = load(stiff(tmp_path))
    (view,) = [one for one in state_views(loaded, None, None) if growing(one)]
    (mode,), fastest = growing(view), max(one.omega for one in view.simulated)
    library, horizon = Counted(), 4 / mode.rate.real
    factor = growth_in_run(replace(loaded, mujoco=library), view, mode, horizon)
    assert factor is not None
    assert factor > math.exp(3)
    assert library.steps <= 2 * (2 * fastest * horizon + horizon / 0.0002)


def test_what_grows_of_itself_comes_before_the_step(tmp_path: Path) -> None:
    """No damping makes a wrong sign right; with the sign turned the integrator is offered."""
    (one,) = found(stiff(tmp_path, step=0.002), "step_limit")
    assert one.fix.startswith("first mend the growing motion of shoulder (unstable_mode)")
    assert 'integrator="discrete" is stable' in one.fix
    assert "damping=" not in one.fix
    (one,) = found(stiff(tmp_path, kp=5, step=0.002), "step_limit")
    assert one.fix.startswith('integrator="discrete" (without limit')


def test_integrators_are_tried_without_modes(tmp_path: Path) -> None:
    """Where a run fails, and no limits are known; those that fail as well are told."""
    path = stiff(tmp_path, kp=5, step=0.002)
    (one,) = inspect(path, modes=False).findings
    assert one.rule == "run_fails"
    assert one.fix.startswith('integrator="discrete"; or timestep="0.0004" (not integrator')
    assert '"implicitfast" or "implicit": its run fails' in one.fix
    assert [grows(path, name, 0.002) for name in ("implicitfast", "implicit", "discrete")] == [
        True,
        True,
        False,
    ]


def test_what_gravity_feeds_is_a_note(tmp_path: Path) -> None:
    """A pendulum that stands; with a servo that is too weak it is still gravity that feeds it."""
    text = """<mujoco><compiler angle="radian"/><worldbody><body>
      <joint name="up" axis="0 1 0"/><inertial pos="0 0 2" mass="3" diaginertia="1 1 1"/>
      </body></worldbody><actuator><position joint="up" kp="{}"/></actuator></mujoco>"""
    path = tmp_path / "model.xml"
    for gain, rules in (("9", {"unstable_equilibrium"}), ("900", set())):
        path.write_text(text.format(gain))
        rule = {one.rule for one in inspect(path).findings if one.rule.startswith("unstable")}
        assert rule == rules


# Closures -----------------------------------------------------------------------------------

PINNED = """<mujoco><compiler angle="radian"/><option timestep="{step}" {option}/><worldbody>
  <body name="beam"><joint name="tilt" axis="0 1 0" damping="5" {joint}/>
  <inertial pos="0.5 0 0" mass="300" diaginertia="20 20 20"/><site name="end" pos="1 0 0"/></body>
  <site name="wall" pos="1 0 0"/></worldbody>
  <equality><connect name="pin" site1="end" site2="wall" solref="{solref}"/></equality></mujoco>"""


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
@pytest.mark.parametrize("step", [0.002, 0.01])
def test_the_fix_of_a_soft_closure_holds_a_run(
    integrator: str, step: float, tmp_path: Path
) -> None:
    """Applied to the file, it closes the loop, and the run stays where it is."""
    path = tmp_path / "model.xml"
    values = {"step": step, "option": f'integrator="{integrator}"', "joint": ""}
    path.write_text(PINNED.format(solref="0.2 1", **values))
    (one,) = found(path, "closure_softness")
    match = re.match(r'(solref="[^"]*" solimp="[^"]*"): it then opens by', one.fix)
    assert match is not None
    path.write_text(path.read_text().replace('solref="0.2 1"', match[1]))
    assert {f.rule for f in inspect(path).findings}.isdisjoint({"closure_softness", "step_limit"})
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    for _ in range(int(5 / step)):
        mujoco.mj_step(model, data)
    assert abs(data.qpos[0]) < 2e-3
    assert not any(warning.number for warning in data.warning)


def test_what_the_load_of_a_closure_leaves_out_is_told(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(PINNED.format(solref="0.2 1", step=0.002, option="", joint='frictionloss="9"'))
    (one,) = found(path, "closure_softness")
    assert "the load does not include dry friction" in one.message


def test_a_handle_is_no_closure(tmp_path: Path) -> None:
    """A weld to a mocap body drags softly, on purpose."""
    text = PINNED.format(solref="0.2 1", step=0.002, option="", joint="")
    path = tmp_path / "model.xml"
    handle = '<body name="hand" mocap="true" pos="1 0 0"><site name="wall"/></body>'
    path.write_text(text.replace('<site name="wall" pos="1 0 0"/>', handle))
    assert not found(path, "closure_softness")


TIGHT = """<mujoco><worldbody><body name="base"><joint name="big" type="slide"/>
  <geom size="0.1" mass="5"/><body name="wrist" pos="0.3 0 0"><joint name="small" axis="0 0 1"/>
  <geom type="capsule" size="0.01" fromto="0 0 0 0.1 0 0" mass="0.05"/></body></body></worldbody>
  <actuator><position joint="small" kp="{kp}" forcerange="-0.5 0.5"/></actuator></mujoco>"""


def test_a_servo_below_its_limit_has_its_whole_stiffness(tmp_path: Path) -> None:
    path, rates = tmp_path / "model.xml", []
    for kp in (100, 400):
        path.write_text(TIGHT.format(kp=kp))
        (mode,) = (one for one in inspect(path).states[0].modes if one.omega > 1)
        assert mode.joint == "small"
        rates.append(mode.omega)
    assert rates[1] == pytest.approx(2 * rates[0], rel=1e-6)


CHAIN = """<mujoco><worldbody><body><joint name="shoulder" axis="0 1 0" stiffness="1"/>
  <geom type="capsule" size="0.04" fromto="0 0 0 0 0 0.3" mass="1.2"/><body pos="0 0 0.3">
  <joint name="elbow" axis="0 1 0" stiffness="1"/>
  <inertial pos="0 0 0.15" mass="0.05" diaginertia="5e-4 5e-4 5e-4"/><body pos="0 0 0.3">
  <joint name="wrist" axis="0 1 0" stiffness="2000"/>
  <geom type="capsule" size="0.02" fromto="0 0 0 0 0 0.1" mass="1"/></body></body></body>
  </worldbody></mujoco>"""


def test_a_mode_is_that_of_the_joint_with_its_kinetic_energy(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(CHAIN)
    assert max(inspect(path).states[0].modes, key=lambda one: one.omega).joint == "wrist"
