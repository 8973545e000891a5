"""Ball and free joints, and inertia tensors, read by no engine: against MuJoCo."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mbcheck import simulate
from mbcheck.models import kinematics
from mbcheck.models.joints import JointLayout
from mbcheck.models.mechanism import mechanism
from mbcheck.models.mjcf import export, models
from mbcheck.models.readout import Readout
from mbcheck.models.rigid_body.mjcf import MODELS
from mbcheck.models.system import System, term_force
from mbcheck.reference import get_scene
from mbcheck.reference.rigid_body import FREE, HEAVY, SCENE

TREE = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="1 -2 -9"><flag contact="disable"/></option>
  <worldbody>
    <body pos="1 2 3" quat="0.5 0.5 -0.5 0.5">
      <inertial pos="0.1 0.2 -0.1" mass="2" fullinertia="0.3 0.35 0.4 0.02 -0.03 0.04"/>
      <freejoint name="base"/>
      <body name="arm" pos="0.3 0 0.1" euler="0.2 -0.3 0.5">
        <inertial pos="0 0.2 0" mass="0.5" diaginertia="0.02 0.03 0.04" quat="0.8 0 0.6 0"/>
        <joint name="ball" type="ball" pos="0.05 -0.1 0.02" armature="0.01" damping="0.3"/>
        <body name="tip" pos="0 0.4 0">
          <inertial pos="0 0.1 0.05" mass="0.2" euler="0.1 0.2 0.3"
            diaginertia="0.002 0.003 0.004"/>
          <joint name="slide" type="slide" axis="0 1 1" stiffness="3" springref="0.1"/>
          <joint name="hinge" axis="1 0 1" damping="0.2" armature="0.003"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def at_random(compiled: Any, seed: int) -> tuple[Any, Any]:
    random = np.random.default_rng(seed)
    q, v = random.normal(size=compiled.nq), random.normal(size=compiled.nv)
    for part in mechanism(TREE).layout.quaternions if compiled.nq > 7 else (slice(-4, None),):
        q[part] /= np.linalg.norm(q[part])
    return q, v


def test_a_tree_in_space_is_that_of_mujoco() -> None:
    mujoco: Any = pytest.importorskip("mujoco")
    whole, compiled = mechanism(TREE), mujoco.MjModel.from_xml_string(TREE)
    data, layout = mujoco.MjData(compiled), whole.layout
    assert layout.size == (compiled.nq, compiled.nv)
    names = tuple(one.name for one in whole.joints)
    for seed in range(3):
        data.qpos[:], data.qvel[:] = q, v = at_random(compiled, seed)
        mujoco.mj_forward(compiled, data)
        mass = np.empty((compiled.nv, compiled.nv))
        for column, unit in enumerate(np.eye(compiled.nv)):
            mujoco.mj_mulM(compiled, data, mass[column], unit)
        assert kinematics.mass_matrix(whole, q) == pytest.approx(mass, rel=1e-11, abs=1e-12)
        bias = kinematics.inertial_force(whole, q, v) - kinematics.weight(whole, q, whole.gravity)
        assert bias == pytest.approx(data.qfrc_bias, rel=1e-10, abs=1e-10)
        system = System(
            None, "", names, q, v, terms=whole.terms, kinds=layout.kinds  # type: ignore[arg-type]
        )  # fmt: skip
        assert system.force(0.0, q, v) == pytest.approx(data.qfrc_passive, abs=1e-13)
        terms = [term_force(one, system, 0.0, q, v) for one in whole.terms]
        assert np.sum(terms, axis=0) == pytest.approx(data.qfrc_passive, abs=1e-13)
        moved = q.copy()
        mujoco.mj_integratePos(compiled, moved, v, 0.7)
        assert system.displaced(q, 0.7 * v) == pytest.approx(moved, abs=1e-14)
        rates = (system.displaced(q, 1e-6 * v) - system.displaced(q, -1e-6 * v)) / 2e-6
        assert layout.rates(q, v) == pytest.approx(rates, abs=1e-9)


def test_parts_of_an_inertia_tensor_add_up() -> None:
    whole = mechanism(TREE)
    parts = kinematics.inertias(whole, at_random(type("", (), {"nq": 13, "nv": 11}), 5)[0])
    assert {"inertia.arm", "products.arm", "armature.ball", "mass.tip"} < set(parts)
    gyroscopic = kinematics.gyroscopic_forces(whole, whole_position(whole), np.ones(11))
    assert set(gyroscopic) == {"gyroscopic.", "gyroscopic.arm", "gyroscopic.tip"}


def whole_position(whole: Any) -> Any:
    q = np.zeros(whole.layout.size[0])
    for part in whole.layout.quaternions:
        q[part.start] = 1.0
    return q


@pytest.mark.parametrize(("model", "p"), [("ball", HEAVY), ("ball", FREE), ("free", FREE)])
def test_the_rigid_body_is_the_reference(model: str, p: Any) -> None:
    mujoco: Any = pytest.importorskip("mujoco")
    source, text = MODELS[model], export(MODELS[model], p)
    whole, compiled = mechanism(text), mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(compiled)
    names = tuple(one.name for one in whole.joints)
    readout = Readout(SCENE, SCENE.coordinates, names, whole.layout, {})
    states = np.random.default_rng(3).normal(size=(4, 8))
    for state in states:
        ((q, v),) = source.joints(p, 0.0, dict(zip(SCENE.state_names, state, strict=True))).values()
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_forward(compiled, data)
        expected = SCENE.right_hand_side(p)(0.0, state)[4:]
        size = np.max(np.abs(expected))
        for a in (data.qacc, own_accelerations(whole, q, v)):
            there = readout.accelerations(state[None], a[None])[0]
            assert there == pytest.approx(expected, abs=1e-11 * size)
        back = readout.states(q[None], v[None])[:, 0]
        found, right = SCENE.observe(back, p), SCENE.observe(state, p)
        for name in SCENE.observables:
            assert found[name] == pytest.approx(right[name], rel=1e-12, abs=1e-12), name
        unit = np.append(state[:4] / np.linalg.norm(state[:4]), state[4:])
        jacobian = unit_rates(source, p, unit)
        joined = jacobian @ kinematics.mass_matrix(whole, q) @ jacobian.T
        mass = np.array(SCENE.mass_matrix(unit[:4], SCENE.coefficients(p)))
        assert readout.completed(joined, unit, p) == pytest.approx(mass, abs=1e-13)


@pytest.mark.parametrize("scene", ["rigid_body", "ball_hoop", "floating_platform", "floating_beam"])
def test_the_files_have_the_default_parameters(scene: str) -> None:
    for model in models(scene).values():
        parameters = get_scene(scene).parameters()
        assert export(model, parameters) == model.path.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["rigid_body", "ball_hoop", "floating_platform", "floating_beam"])
@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_a_start_may_have_a_quaternion_of_any_length(engine: str, name: str) -> None:
    pytest.importorskip(engine, exc_type=ImportError)
    case = get_scene(name).cases[0]
    turn = {key: 2 * value for key, value in case.state.items() if key.startswith("q_")}
    ends = [
        simulate(name, engine=engine, state=dict(state), times=[2.0**-6]).observables["R_xx"]
        for state in (case.state, {**case.state, **turn})
    ]
    assert ends[0] == pytest.approx(ends[1], rel=1e-9)


def own_accelerations(whole: Any, q: Any, v: Any) -> Any:
    force = kinematics.weight(whole, q, whole.gravity) - kinematics.inertial_force(whole, q, v)
    return np.linalg.solve(kinematics.mass_matrix(whole, q), force)


def unit_rates(source: Any, p: Any, state: Any) -> Any:
    rows = []
    for unit in np.eye(4):
        moving = dict(zip(SCENE.state_names, [*state[:4], *unit], strict=True))
        rows.append(source.joints(p, 0.0, moving)["q"][1])
    return np.array(rows)


def test_without_spatial_joints_positions_are_sums() -> None:
    layout, q, v = JointLayout(("hinge", "slide")), np.array([1.0, 2.0]), np.array([0.5, -0.25])
    assert layout.displaced(q, v).tolist() == [1.5, 1.75]
    assert layout.rates(q, v) is v
    assert layout.size == (2, 2)
    assert JointLayout(("slide", "ball")).size == (5, 4)
