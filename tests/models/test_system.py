"""MJCF in joint coordinates, by no engine: against the references, and against MuJoCo."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import mbcheck
from mbcheck.comparisons.engines.adapter import adapt
from mbcheck.models import kinematics, mechanism, mjcf
from mbcheck.models.joints import JointLayout
from mbcheck.models.system import System, term_force
from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.equations import scene_equations
from mbcheck.reference.errors import CannotJudgeError
from mbcheck.reference.scene import Array

MODELS = [
    (scene, name)
    for scene in SCENES
    if not get_scene(scene).quaternions  # ball and free joints: test_ball_joints
    for name in mjcf.models(scene)
    if name != "transmission"
]


def accelerations(whole: mechanism.Mechanism, force: Array, q: Array, v: Array) -> Array:
    """Return accelerations of all joints, loops closed for good."""
    mass, loops = kinematics.mass_matrix(whole, q), kinematics.gap_jacobian(whole, q)
    loops = loops[np.any(loops != 0, axis=1)]
    drift = kinematics.gap_drift(whole, q, v)[: len(loops)]
    matrix = np.block([[mass, loops.T], [loops, np.zeros((len(loops),) * 2)]])
    right = np.concatenate([force - kinematics.inertial_force(whole, q, v), -drift])
    found: Array = np.linalg.solve(matrix, right)[: len(q)]
    return found


class Reader(mbcheck.Engine):
    """Reads the files, and computes nothing."""

    name, version, closure = "reader", "1", "mjcf"
    methods = (mbcheck.Method("none", 1),)


@pytest.mark.parametrize(("scene", "model"), MODELS)
def test_its_accelerations_are_those_of_the_reference(scene: str, model: str) -> None:
    reader, source = adapt("reader", Reader), mjcf.models(scene)[model]
    case = next(
        c for c in get_scene(scene).cases if source.unsupported_reason(c.parameters) is None
    )
    own = (
        scene_equations(case)
        if reader.bind(case, model).has_constraints
        else reader.bind(case, model).equations
    )
    names = reader.bind(case, model).coordinates
    states = np.random.default_rng(7).normal(size=(4, 2 * len(names)))
    times = np.linspace(0.0, 0.3, 4)
    bound = reader.bind(case, model)
    held, (q, v) = bound.origin, bound.joint_states(times, states)
    whole = mechanism.mechanism(held.mjcf)
    right = own.scene.right_hand_side(own.parameters)
    factors = bound.readout.factors()
    for time, state, position, rate in zip(times, states, q, v, strict=True):
        found = factors @ accelerations(
            whole, held.force(float(time), position, rate), position, rate
        )
        expected = right(float(time), state)[len(names) :]
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.max(np.abs(expected)))


@pytest.mark.parametrize(("scene", "model"), MODELS)
def test_its_parts_add_up_to_what_mujoco_has(scene: str, model: str) -> None:
    mujoco: Any = pytest.importorskip("mujoco")
    text = adapt("reader", Reader).bind(get_scene(scene).cases[0], model).text
    whole, compiled = mechanism.mechanism(text), mujoco.MjModel.from_xml_string(text)
    data, random = mujoco.MjData(compiled), np.random.default_rng(8)
    data.qpos[:] = compiled.qpos0 + random.normal(size=compiled.nq)
    data.qvel[:] = random.normal(size=compiled.nv)
    mujoco.mj_forward(compiled, data)
    mass = np.empty((compiled.nv, compiled.nv))
    for column, unit in enumerate(np.eye(compiled.nv)):
        mujoco.mj_mulM(compiled, data, mass[column], unit)
    size = np.sqrt(np.outer(np.diag(mass), np.diag(mass)))
    assert np.max(np.abs(kinematics.mass_matrix(whole, data.qpos) - mass) / size) < 1e-14
    bias = kinematics.inertial_force(whole, data.qpos, data.qvel)
    assert bias == pytest.approx(data.qfrc_bias, rel=1e-12, abs=1e-12 * np.max(np.abs(bias)))
    names = tuple(one.name for one in whole.joints)
    kinds = whole.layout.kinds
    held = System(None, model, names, data.qpos, data.qvel, terms=whole.terms, kinds=kinds)  # type: ignore[arg-type]
    forces = data.qfrc_passive + data.qfrc_actuator
    assert held.force(0.0, data.qpos, data.qvel) == pytest.approx(forces, rel=1e-13)
    one_by_one = [term_force(t, held, 0.0, data.qpos, data.qvel) for t in whole.terms]
    assert np.sum(one_by_one, axis=0) == pytest.approx(forces, rel=1e-13)


def test_weight_is_the_slope_of_the_potential() -> None:
    text = adapt("reader", Reader).bind(get_scene("speed_regulator").cases[0], "connect").text
    whole, gravity = mechanism.mechanism(text), np.array([0.3, -9.81, 2.0])

    def potential(q: Array) -> Any:
        placed = kinematics.place(whole, q)
        return -sum(
            body.mass * gravity @ placed.point(mechanism.Site(i, body.centre))
            for i, body in enumerate(whole.bodies)
        )

    q = np.array([0.4, -0.3, -1.1])
    slopes = [potential(q + 1e-30j * unit).imag / 1e-30 for unit in np.eye(3)]
    assert kinematics.weight(whole, q, gravity) == pytest.approx(-np.array(slopes), rel=1e-12)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('<body><joint name="b" type="screw"/></body>', "joint b is a screw"),
        (
            '<body><joint name="b" type="ball" stiffness="1"/></body>',
            "joint b has a stiffness",
        ),
        ('<body axisangle="1 0 0 1"><joint name="b"/></body>', "axisangle is not understood"),
        ('<body><joint name="a"/></body>|<position name="m" joint="a"/>', None),
        (
            '<body><joint name="a"/></body>|<motor name="m" joint="a" gear="2"/>',
            "m takes a control",
        ),
        ('<body><joint name="a"/></body>|<general name="m" joint="a"/>', "m takes a control"),
        ('<body><joint name="a"/></body>|<general name="m" site="s"/>', "m acts on no joint"),
    ],
)
def test_what_it_does_not_understand_is_refused(text: str, said: str | None) -> None:
    bodies, _, actuators = text.partition("|")
    whole = f"<mujoco><worldbody>{bodies}</worldbody><actuator>{actuators}</actuator></mujoco>"
    said = said or "position is not understood"
    with pytest.raises(CannotJudgeError, match=said):
        mechanism.mechanism(whole)


@pytest.mark.parametrize("time", [0.4, 1.5, 1.6])
def test_terms_add_up_to_the_force_while_they_last(time: float) -> None:
    reader, case = adapt("reader", Reader), get_scene("rotating_beam").case("pulse_quick")
    states = np.random.default_rng(9).normal(
        size=(1, 2 * len(reader.bind(case, "forced").coordinates))
    )
    bound = reader.bind(case, "forced")
    system, ((q,), (v,)) = bound.origin, bound.joint_states(np.array([time]), states)
    assert [term.until for term in system.terms if term.amplitude] == [1.5]
    parts = [term_force(term, system, time, q, v) for term in system.terms]
    assert np.sum(parts, axis=0) == pytest.approx(system.force(time, q, v), rel=1e-12)
    assert (parts[-1][0] != 0) == (time < 1.5)


def test_a_quaternion_that_is_displaced_comes_out_of_length_1() -> None:
    layout = JointLayout(("ball",))
    turned = layout.displaced(np.array([0.0, 0.0, 0.0, 2.0]), np.array([0.0, 0.0, np.pi / 2]))
    assert turned == pytest.approx(np.array([-1.0, 0, 0, 1.0]) / np.sqrt(2))
