"""What the adapters of `examples` do with quaternions, without their libraries."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbcheck.comparisons.engines.adapter import Adapter, adapt
from mbcheck.examples.pinocchio_engine import PinocchioEngine, scalar_last
from mbcheck.reference import get_scene
from mbcheck.tests.support.engines.examples import PLACES, results


class Borrowed(PinocchioEngine):
    """The adapter of Pinocchio with MuJoCo's accelerations in place of those of the library."""

    version = "0"

    def __init__(self) -> None:
        self.loaded: Any = None

    def load(self, system: Any) -> Any:
        if self.loaded is None or self.loaded[0] != system.mjcf:
            model = mujoco.MjModel.from_xml_string(system.mjcf)
            self.loaded = system.mjcf, model, mujoco.MjData(model)
        return self.loaded[1:]

    def accelerations(self, system: Any, time: float, q: Any, v: Any) -> Any:
        model, data = self.load(system)
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_forward(model, data)
        return data.qacc.copy()


def engine() -> Adapter:
    return adapt("pinocchio", Borrowed)


@pytest.mark.parametrize("scene", ["rigid_body", "ball_hoop"])
def test_quaternions_are_handed_on_in_the_order_of_the_library(scene: str) -> None:
    """By which the last body stands in space as MuJoCo has it."""
    model, case, _ = PLACES[scene]
    system = engine().bind(of := get_scene(scene).case(case), model).system(of)
    (place,) = system.layout.quaternions
    q = np.array(system.positions)
    q[place] = np.array([0.5, -0.1, 0.7, 0.5])
    q[place] /= np.linalg.norm(q[place])
    mjcf = mujoco.MjModel.from_xml_string(system.mjcf)
    data = mujoco.MjData(mjcf)
    data.qpos[:] = q
    mujoco.mj_kinematics(mjcf, data)
    joint = int(np.flatnonzero(mjcf.jnt_type == mujoco.mjtJoint.mjJNT_BALL)[0])
    body = mjcf.jnt_bodyid[joint]
    parent = data.xmat[mjcf.body_parentid[body]].reshape(3, 3)
    own = np.empty(9)
    mujoco.mju_quat2Mat(own, mjcf.body_quat[body])
    turned = Rotation.from_quat(scalar_last(system, q)[place]).as_matrix()
    there = parent @ own.reshape(3, 3) @ turned
    np.testing.assert_allclose(data.xmat[body].reshape(3, 3), there, atol=1e-14)


def test_its_steps_turn_quaternions_with_order_4() -> None:
    found = results(engine(), "rigid_body", ("step",))
    assert found
    assert {item.verdict for item in found} <= {"pass", "skipped"}
    assert "pass" in {item.verdict for item in found}
