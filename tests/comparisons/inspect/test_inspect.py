"""What inspection says of motion: frequencies, stable steps, loops; against truth and MuJoCo."""

from __future__ import annotations

import math
import re
from functools import partial
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.inspect.inspection import Inspection, inspect
from mbcheck.comparisons.inspect.views import View, longest_step
from mbcheck.comparisons.queries.query import mjcf_text
from mbcheck.models import mjcf
from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.errors import UsageError
from mbcheck.reference.linear import linearise, modes

ROOT = Path(mbcheck.__file__).parent
COMMITTED = sorted(ROOT.glob("models/*/*.xml"))
EXPORTED = [
    (scene, model)
    for scene in SCENES
    for model, known in mjcf.models(scene).items()
    if mjcf.export(known, get_scene(scene).parameters())
    not in {path.read_text() for path in COMMITTED}
]
"""Models whose default text is not a committed one."""

SLOW = pytest.mark.slow
INTEGRATORS = ("Euler", "implicit", "implicitfast", "RK4", "discrete")


def written(folder: Path, text: str) -> Path:
    path = folder / "model.xml"
    path.write_text(text)
    return path


def exported(
    folder: Path,
    scene: str,
    model: str | None = None,
    parameters: dict[str, Any] | None = None,
    *edits: tuple[str, str],
) -> Path:
    """Write a scene's MJCF, edited."""
    text = mjcf_text(scene, parameters, model)
    for pattern, replacement in edits:
        text, count = re.subn(pattern, replacement, text)
        assert count, pattern
    return written(folder, text)


def limit(found: Inspection, integrator: str) -> float:
    return next(one.limit for one in found.steps if one.integrator == integrator)


def pairs(view: View) -> list[complex]:
    """Return the eigenvalues of all modes that are not rigid."""
    return [mode.rate for mode in view.modes if mode.kind != "rigid"]


def assert_among(wanted: list[complex], found: list[complex], rel: float) -> None:
    for value in wanted:
        nearest = min(found, key=lambda other: abs(other - value))
        assert abs(nearest - value) <= rel * abs(value), f"{value} is not among {found}"


# Our own models -----------------------------------------------------------------------------


@pytest.mark.parametrize("path", COMMITTED, ids=lambda path: path.stem)
def test_committed_models_have_no_findings(path: Path) -> None:
    assert inspect(path, strict=True).unwaived == ()
    assert (
        inspect(path, modes=False, strict=True).unwaived == ()
    )  # no waiver is called unused in vain


@pytest.mark.parametrize(("scene", "model"), EXPORTED)
def test_exported_models_have_no_findings(scene: str, model: str, tmp_path: Path) -> None:
    found = inspect(exported(tmp_path, scene, model), strict=True)
    assert found.unwaived == ()
    assert all(one.waived for one in found.findings)


# Frequencies against the reference ----------------------------------------------------------


@pytest.mark.parametrize("damping", [0.001, 0.4])
def test_modes_of_hula_hoop(damping: float, tmp_path: Path) -> None:
    """Those of the reference, beside the clock that drives the foot."""
    parameters = {"damping_ratio": damping}
    (view,) = inspect(exported(tmp_path, "hula_hoop", None, parameters)).views
    truth = mbcheck.frequencies("hula_hoop", parameters=parameters).modes
    clock = 2 * math.pi * 3j
    assert_among([clock], pairs(view), 1e-9)
    assert_among([complex(m.re, m.im) for m in truth if m.omega], pairs(view), 1e-8)
    assert len(view.modes) == len(truth) + 1
    names = {round(m.omega, 3): m.dof for m in view.modes}
    assert names[round(abs(clock), 3)] == 0


def test_modes_of_rotor_pendulum(tmp_path: Path) -> None:
    """Those of the reference's matrices, with the motors' slope and without motors."""
    scene = get_scene("rotor_pendulum")
    p = scene.parameters()
    state = np.zeros(8)
    (view,) = inspect(exported(tmp_path, "rotor_pendulum")).views
    mass, damping, stiffness = linearise(scene, p, state)
    truth = modes(mass, damping, stiffness)
    assert [mode.kind for mode in view.modes].count("rigid") == 2
    assert_among([complex(m.re, m.im) for m in truth if m.omega > 1e-3], pairs(view), 1e-6)
    off = exported(tmp_path, "rotor_pendulum", None, None, (r'biasprm="[^"]*"', 'biasprm="0 0 0"'))
    (view,) = inspect(off).views
    truth = modes(*linearise(scene, scene.unforced(p), state))
    assert len(truth) == len(view.modes) == 4
    assert_among([complex(m.re, m.im) for m in truth if m.omega], pairs(view), 1e-8)


def test_modes_of_speed_regulator_with_its_loop_closed(tmp_path: Path) -> None:
    """The loop is closed exactly, whatever its softness: those of the mechanism at its rest."""
    scene = get_scene("speed_regulator")
    p = scene.parameters()
    rest = scene.equilibria["right"](p)
    truth = modes(*linearise(scene, p, scene.state(rest)))
    source = mjcf.models("speed_regulator")["connect"]
    motion = source.joints(p, 0.0, {"phi": rest["phi"], "phi_dot": 0.0})
    place = " ".join(repr(float(motion[name][0])) for name in ("phi", "pin_angle", "y"))
    key = (r'<key name="rest"/>', f'<key name="rest" qpos="{place}"/>')
    for model in ("connect", "connect_hard"):
        view = inspect(exported(tmp_path, "speed_regulator", model, None, key)).views[1]
        assert_among([complex(m.re, m.im) for m in truth], pairs(view), 1e-7)
        assert len(view.modes) == len(truth) == 1
        assert view.linear is not None
        assert view.linear.closed == 2
        assert np.max(np.abs(view.linear.acceleration)) < 1e-6


@pytest.mark.parametrize("speed", [pytest.param(0.4, marks=SLOW), 10.0])
def test_modes_of_the_chain_about_its_rotation(speed: float, tmp_path: Path) -> None:
    """Those that the adapter finds of the same chain, and near the beam's own."""
    about = {"theta": speed}
    found = inspect(exported(tmp_path, "rotating_beam"), about_rotation=about).views[-1]
    truth = mbcheck.frequencies(
        "rotating_beam",
        about="rotation",
        engine="mujoco",
        parameters={"angular_speed": speed},
        count=10,
    ).modes
    omegas = [mode.omega for mode in found.modes if mode.kind == "oscillating"]
    for mode in truth:
        assert min(abs(omega - mode.omega) for omega in omegas) < 1e-7 * mode.omega
    assert found.steady_hinge == "theta"


def test_gyroscopic_terms_split_the_frequencies(tmp_path: Path) -> None:
    """A mass on two springs that turns: omega_0 - W and omega_0 + W, in closed form."""
    text = """<mujoco><compiler angle="radian"/><option gravity="0 0 0"/><worldbody>
      <body name="table"><joint name="turn"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
        <body name="bob"><joint name="x" type="slide" axis="1 0 0" stiffness="400"/>
          <joint name="y" type="slide" axis="0 1 0" stiffness="400"/>
          <inertial pos="0 0 0" mass="4" diaginertia="1e-3 1e-3 1e-3"/></body></body>
      </worldbody></mujoco>"""
    path = written(tmp_path, text)
    for speed in (1.0, 4.0):
        modes = inspect(path, about_rotation={"turn": speed}).views[-1].modes
        assert [mode.omega for mode in modes] == pytest.approx([10 - speed, 10 + speed], rel=1e-9)
    over = inspect(path, about_rotation={"turn": 12.0}).views[-1]
    assert [mode.kind for mode in over.modes] == ["oscillating", "oscillating"]


def test_a_rotation_stretches_what_it_turns(tmp_path: Path) -> None:
    """A bob on a spring along a turning arm: its place is found, k - m W^2 its stiffness."""
    text = """<mujoco><compiler angle="radian"/><option gravity="0 0 0"/><worldbody>
      <body name="arm"><joint name="turn"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
        <body name="bob" pos="1 0 0"><joint name="x" type="slide" axis="1 0 0" stiffness="400"
          damping="2"/><inertial pos="0 0 0" mass="4" diaginertia="1e-3 1e-3 1e-3"/></body></body>
      </worldbody></mujoco>"""
    path = written(tmp_path, text)
    view = inspect(path, about_rotation={"turn": 5.0}).views[-1]
    assert view.state.position[1] == pytest.approx(4 * 25 / (400 - 4 * 25), rel=1e-9)
    (mode,) = view.modes
    assert mode.omega == pytest.approx(math.sqrt(300 / 4), rel=1e-9)
    assert mode.damping_ratio == pytest.approx(2 / (2 * math.sqrt(300 * 4)), rel=1e-8)
    beyond = inspect(path, about_rotation={"turn": 12.0}).views[-1]
    assert "unstable" in {mode.kind for mode in beyond.modes}


@pytest.mark.parametrize(
    ("about", "words"),
    [
        ({"sving": 1.0}, "did you mean 'swing'"),
        ({"slide": 1.0}, "is not a hinge"),
        ({"swing": math.nan}, "finite"),
        ({"swing": 1.0, "slide": 1.0}, "not several"),
        ({"swing": 3.0}, "not steady"),
    ],
)
def test_rotations_that_there_are_not(about: dict[str, float], words: str, tmp_path: Path) -> None:
    text = """<mujoco><compiler angle="radian"/><worldbody>
      <body><joint name="swing" axis="0 1 0"/><inertial pos="0 0 1" mass="1" diaginertia="1 1 1"/>
      <body pos="0 0 1"><joint name="slide" type="slide" axis="1 0 0" stiffness="99"/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></body></worldbody></mujoco>"""
    with pytest.raises(UsageError, match=words):
        inspect(written(tmp_path, text), about_rotation=about)


FREE = """<mujoco><compiler angle="radian"/><option gravity="{}"/><worldbody>
  <body pos="0 0 2"><freejoint/><inertial pos="0 0 0.3" mass="3" diaginertia="1 2 2.5"/>
    <body pos="0 0 1"><joint name="ball" type="ball" stiffness="50" damping="0.2"/>
      <inertial pos="0 0 0.2" mass="1" diaginertia="0.3 0.2 0.1"/></body></body>
  </worldbody></mujoco>"""


def test_a_floating_body_has_six_rigid_modes(tmp_path: Path) -> None:
    """Quaternions included, and gravity, in which it falls, changes nothing."""
    found = [
        inspect(written(tmp_path, FREE.format(gravity))).views[0].modes
        for gravity in ("0 0 0", "0 0 -9.81")
    ]
    for one in found:
        assert [mode.kind for mode in one] == ["rigid"] * 6 + ["oscillating"] * 3
    first, second = ([mode.rate for mode in one[6:]] for one in found)
    assert first == pytest.approx(second, rel=1e-7)
    inertia = np.array([1.0, 2.0, 2.5])
    about_z = math.sqrt(50 * (1 / 0.1 + 1 / inertia[2]))
    assert max(abs(rate) for rate in first) == pytest.approx(about_z, rel=1e-8)


# Stable steps against MuJoCo's own runs -----------------------------------------------------

OSCILLATORS = """<mujoco><compiler angle="radian"/>
  <option gravity="0 0 -9.81" integrator="{integrator}"><flag contact="disable"/></option>
  <worldbody>
  <body><joint name="x" type="slide" axis="1 0 0" stiffness="900" damping="{damping}"/>
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
    <body><joint name="swing" axis="0 1 0" stiffness="{spring}" damping="{hinge}"/>
      <inertial pos="0 0 -1" mass="2" diaginertia="1e-2 1e-2 1e-2"/></body></body>
  </worldbody><actuator><general name="servo" joint="swing" gainprm="0" biastype="affine"
    biasprm="0 -{servo} -{slope}"/></actuator></mujoco>"""

SETTINGS = {
    "undamped": {"damping": 0, "spring": 0, "hinge": 0, "servo": 0, "slope": 0},
    "damped": {"damping": 9, "spring": 300, "hinge": 4, "servo": 0, "slope": 0},
    "stiff": {"damping": 200, "spring": 3000, "hinge": 90, "servo": 0, "slope": 0},
    "servo": {"damping": 3, "spring": 0, "hinge": 0, "servo": 4000, "slope": 60},
}


def growth(path: Path, step: float, steps: int = 3000) -> float:
    """Return by how much a small disturbance of MuJoCo's own run grows; infinite if it fails."""
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.timestep = step
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    rest, largest = data.qpos.copy(), 0.0
    data.qpos[:] += 1e-9
    for _ in range(steps):
        mujoco.mj_step(model, data)
        if not np.all(np.isfinite(data.qpos)):
            return math.inf
        largest = max(largest, float(np.max(np.abs(data.qpos - rest))) / 1e-9)
        if largest > 1e4:
            break
    return largest


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize(
    "name", ["damped", *(pytest.param(n, marks=SLOW) for n in ("undamped", "stiff", "servo"))]
)
def test_the_largest_stable_step_is_real(name: str, integrator: str, tmp_path: Path) -> None:
    """MuJoCo stays bounded just below it, and blows up just above; where any is, at all steps."""
    text = OSCILLATORS.format(integrator=integrator, **SETTINGS[name])
    path = written(tmp_path, text)
    found = limit(inspect(path), integrator)
    if math.isinf(found):
        assert integrator == "discrete"
        assert growth(path, 0.5) < 100
        return
    assert growth(path, 0.985 * found) < 1000
    assert growth(path, 1.015 * found) > 1e4


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
def test_the_limit_of_a_closed_loop_is_real(integrator: str, tmp_path: Path) -> None:
    """The closure's own modes set it, as connect.xml tells: h sqrt(K) < 0.83, RK4 2.78."""
    path = exported(
        tmp_path,
        "speed_regulator",
        "connect_hard",
        None,
        (r"RK4", integrator),
        (r"0\.32 0 0", "0 0 0"),
        (r'springref="-1.25"', 'springref="-1.224744871391589"'),
    )
    found = limit(inspect(path), integrator)
    assert found * 500 == pytest.approx(2.77 if integrator == "RK4" else 0.829, rel=5e-3)
    assert growth(path, 0.97 * found) < 1000
    assert growth(path, 1.03 * found) > 1e4


def test_the_mode_that_sets_the_limit_is_named(tmp_path: Path) -> None:
    """A servo's damping, explicit in Euler, on one of two joints: h c / J < 2 of that joint."""
    text = OSCILLATORS.format(
        integrator="Euler", **{"damping": 3, "spring": 0, "hinge": 0, "servo": 0, "slope": 5000}
    )
    found = next(one for one in inspect(written(tmp_path, text)).steps if one.of_file)
    assert found.joint == "swing"
    assert found.omega is not None
    assert found.limit * found.omega == pytest.approx(2, rel=1e-2)
    assert growth(tmp_path / "model.xml", 1.02 * found.limit) > 1e4


def test_mode_by_mode_agrees_with_the_whole(tmp_path: Path) -> None:
    text = OSCILLATORS.format(integrator="Euler", **SETTINGS["undamped"])
    (view,) = inspect(written(tmp_path, text)).views
    assert view.linear is not None
    for integrator in INTEGRATORS:
        at, modes = partial(view.linear.motion, integrator), view.simulated
        whole, mode = longest_step(integrator, at, modes)
        apart, same = longest_step(integrator, at, modes, full_up_to=0)
        coupled = integrator == "discrete"  # by springs of which it takes one part late
        assert apart == pytest.approx(whole, rel=0.1 if coupled else 1e-6)
        assert (mode and mode.dof) == (same and same.dof)


# Closures against MuJoCo's own violation ----------------------------------------------------

HUNG = """<mujoco><compiler angle="radian"/>
  <option timestep="0.0009765625" integrator="RK4" tolerance="1e-30" jacobian="dense">
    <flag contact="disable" autoreset="disable"/></option><worldbody>
  <site name="wall" pos="1 0 0"/>
  <body name="beam"><joint name="tilt" axis="0 1 0" damping="5"/>
    <inertial pos="0.5 0 0" mass="3" diaginertia="0.2 0.2 0.2"/><site name="end" pos="1 0 0"/>
  </body>
  <body name="bob" pos="3 0 0"><joint name="drop" type="slide" damping="9"/>
    <inertial pos="0 0 0" mass="2" diaginertia="0.1 0.1 0.1"/></body>
  <body name="box" pos="5 0 0"><freejoint name="box"/>
    <inertial pos="0.2 0 0" mass="2" diaginertia="1 1 1"/></body>
  </worldbody>
  <equality>
    <connect name="pin" site1="end" site2="wall" {how}/>
    <joint name="held" joint1="drop" {how}/>
    <weld name="glued" body1="box" {how}/>
  </equality></mujoco>"""


@pytest.mark.parametrize(
    "how",
    [
        "",
        'solref="0.01 0.7"',
        pytest.param('solref="0.05 1"', marks=SLOW),
        pytest.param('solref="-40000 -500" solimp="0.99 0.999 0.01"', marks=SLOW),
    ],
)
def test_the_opening_of_a_closure_is_that_of_a_run(how: str, tmp_path: Path) -> None:
    path = written(tmp_path, HUNG.format(how=how))
    predicted = {one.name: one for one in inspect(path, modes=False).closures}
    assert set(predicted) == {"pin", "held", "glued"}
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    for _ in range(12000):
        mujoco.mj_step(model, data)
    assert np.max(np.abs(data.qvel)) < 1e-5
    for name, one in predicted.items():
        rows = np.array(data.efc_pos)[np.array(data.efc_id) == model.equality(name).id]
        assert one.opening == pytest.approx(np.linalg.norm(rows[:3]), rel=2e-3)
        if one.turn is not None:
            assert one.turn == pytest.approx(np.linalg.norm(rows[3:]), rel=2e-2)
        assert one.opening > 1e-7


def test_a_closure_decays_as_it_is_told(tmp_path: Path) -> None:
    """A joint held alone: its departure dies away, and swings, at the rates that are told."""
    text = HUNG.format(how='solref="0.05 0.3"').replace("<option", '<option gravity="0 0 0"')
    path = written(tmp_path, text.replace(' damping="9"', ""))
    one = {c.name: c for c in inspect(path, modes=False).closures}["held"]
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    data.joint("drop").qpos = 1e-7
    turns = []
    for _ in range(600):
        before = float(data.joint("drop").qvel[0])
        mujoco.mj_step(model, data)
        if before * float(data.joint("drop").qvel[0]) < 0:
            turns.append((data.time, abs(float(data.joint("drop").qpos[0]))))
    (first, high), *_, (last, low) = turns
    assert math.log(high / low) / (last - first) == pytest.approx(one.decay, rel=0.02)
    half = math.pi / math.sqrt(one.omega**2 - one.decay**2)
    assert (last - first) / (len(turns) - 1) == pytest.approx(half, rel=0.02)


def test_the_stiffest_closure_comes_first(tmp_path: Path) -> None:
    text = HUNG.format(how="").replace('joint1="drop" ', 'joint1="drop" solref="-90000 -600" ')
    found = inspect(written(tmp_path, text), modes=False).closures
    assert found[0].name == "held"
    assert [one.omega for one in found] == sorted((one.omega for one in found), reverse=True)


def test_refsafe_is_taken_into_account(tmp_path: Path) -> None:
    """A time constant below two steps is raised, and the prediction knows it."""
    text = HUNG.format(how='solref="0.0001 1"')
    found = inspect(written(tmp_path, text), modes=False)
    assert {one.effective for one in found.closures} == {(2 * 0.0009765625, 1.0)}
    rules = [one.rule for one in found.findings]
    assert rules.count("solref_raised") == 3
    off = text.replace("autoreset=", 'refsafe="disable" autoreset=')
    found = inspect(written(tmp_path, off), modes=False)
    assert {one.effective for one in found.closures} == {(0.0001, 1.0)}
    assert "solref_raised" not in [one.rule for one in found.findings]


SLACK = '<tendon name="{}" tendon1="{}"/>'
"""An equality of a tendon; MuJoCo leaves out the row of one whose moment is zero."""
WITH_TENDON = """<mujoco><option gravity="0 0 -10"/><worldbody><site name="top" pos="0 0 2"/>
  <body pos="0 0 1"><joint name="swing" axis="0 1 0"/><geom size="0.1" pos="0 0 -0.3" mass="2"/>
    <site name="bob" pos="0 0 -0.3"/></body>
  <body pos="1 0 1"><joint name="drop" type="slide" axis="0 0 1"/><geom size="0.1" mass="3"/></body>
  <body pos="2 0 1"><joint name="hold" axis="0 1 0" stiffness="40"/>
    <geom size="0.1" pos="0.3 0 0" mass="1"/></body></worldbody>
  <tendon><spatial name="rope"><site site="top"/><site site="bob"/></spatial></tendon>
  <equality>{before}<joint joint1="drop" joint2="hold" polycoef="0 0.2 0.4 0 0"/>{after}</equality>
  <keyframe>{key}</keyframe></mujoco>"""


@pytest.mark.parametrize("where", ["before", "after"])
@pytest.mark.parametrize("key", ["", '<key qpos="0.3 0 0"/>', '<key qvel="1 0 0"/>'])
def test_an_equality_without_a_moment_ties_nothing(where: str, key: str, tmp_path: Path) -> None:
    """Its row comes and goes with the position; other loops keep theirs, with their loads."""
    values = {"before": "", "after": "", "key": key}
    plain = inspect(written(tmp_path, WITH_TENDON.format(**values)))
    values[where] = SLACK.format("slack", "rope")
    tied = inspect(written(tmp_path, WITH_TENDON.format(**values)))
    free, same = plain.views[0], tied.views[0]
    assert len(free.modes) == 2
    np.testing.assert_allclose(pairs(same), pairs(free), rtol=1e-6)  # its force is 1e9 N nearby
    if "qpos" in key:  # where the rope has a moment, it takes a direction away
        assert [len(view.modes) for view in tied.views] == [2, 1]


def test_what_grows_of_itself_excuses_no_other_mode(tmp_path: Path) -> None:
    """A double pendulum that stands has modes of +-g and +-f; RK4 follows f's decay up to 2.785/f.

    One step of MuJoCo from a departure along that mode shrinks it below the limit alone.
    """
    rod = """<body name="{0}" pos="0 0 {1}"><joint name="j{0}" axis="0 1 0"/>
      <geom type="capsule" size="0.01" fromto="0 0 0 0 0 0.3" mass="1"/>{2}</body>"""
    text = f"<mujoco><worldbody>{rod.format('a', 0, rod.format('b', 0.3, ''))}</worldbody></mujoco>"
    found = inspect(path := written(tmp_path, text))
    (decay,) = [one for one in found.views[0].modes if one.omega > 10 and one.rate.real < 0]
    assert limit(found, "RK4") == pytest.approx(2.785 / decay.omega, rel=1e-3)
    assert limit(found, "Euler") == math.inf
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    shape, kept = 1e-5 * decay.vector.real / np.linalg.norm(decay.vector), []
    for share in (0.98, 1.02):
        model.opt.timestep = share * limit(found, "RK4")
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = shape, decay.rate.real * shape
        mujoco.mj_step(model, data)
        kept.append(float(np.linalg.norm(data.qpos) / np.linalg.norm(shape)))
    assert kept[0] < 1 < kept[1]
