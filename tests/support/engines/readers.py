"""MuJoCo behind the public door as a reader of any file, and readers that lose something."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

import mbcheck


class FileReader(mbcheck.Engine):
    """MuJoCo, by the file's path alone."""

    name, version = "file_reader", "1"
    methods = (mbcheck.Method("RK4", 4),)

    def edit(self, model: Any) -> None:
        """Lose nothing."""

    def accelerations(self, system: mbcheck.System, time: float, q: Any, v: Any) -> Any:
        """Return what MuJoCo computes after the edit."""
        model = mujoco.MjModel.from_xml_path(system.path)
        self.edit(model)
        mujoco.mj_setConst(model, mujoco.MjData(model))  # as after compiling what it has read
        data = mujoco.MjData(model)
        data.qpos, data.qvel, data.ctrl = q, v, system.controls(time)
        mujoco.mj_forward(model, data)
        return data.qacc


class WithoutDamping(FileReader):
    """Drops the damping of all joints."""

    name = "without_damping"

    def edit(self, model: Any) -> None:
        model.dof_damping[:] = 0


class UnitGear(FileReader):
    """Reads the gear of the first motor as 1."""

    name = "unit_gear"

    def edit(self, model: Any) -> None:
        model.actuator_gear[0, 0] = 1


class WithoutGravity(FileReader):
    """Ignores gravity."""

    name = "without_gravity"

    def edit(self, model: Any) -> None:
        model.opt.gravity[:] = 0


class DegreesAndArmature(FileReader):
    """Takes stiffness for one per degree, and drops armature."""

    name = "degrees_and_armature"

    def edit(self, model: Any) -> None:
        model.jnt_stiffness[:] *= 180 / np.pi
        model.dof_armature[:] = 0


class SinglePrecision(FileReader):
    """Answers in 32 bits, and drops the damping of the second joint."""

    name = "single_precision"
    precision = "float32"

    def edit(self, model: Any) -> None:
        model.dof_damping[1] = 0

    def accelerations(self, *arguments: Any) -> Any:
        """Return them in 32 bits."""
        return super().accelerations(*arguments).astype(np.float32)


class OtherConventions(FileReader):
    """Joints by their names, quaternions with the scalar last, rates in the world; no damping."""

    name = "other_conventions"

    def edit(self, model: Any) -> None:
        model.dof_damping[0] = 0

    def accelerations(self, system: mbcheck.System, time: float, q: Any, v: Any) -> Any:
        """Return them for the joints elbow, float (free), shoulder, in this order."""
        own = np.concatenate([q[8:], q[:1], q[1:4], q[7:8], q[4:7]])
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, own[5:])
        axes = turn.reshape(3, 3)
        rates = np.concatenate([v[7:], v[:1], v[1:4], axes.T @ v[4:7]])
        a = super().accelerations(system, time, own, rates)
        return np.concatenate([a[1:2], a[2:5], axes @ a[5:8], a[:1]])


class Raises(FileReader):
    """Fails."""

    name = "raises"

    def accelerations(self, *arguments: Any) -> Any:
        raise RuntimeError("no such joint")


class Refuses(FileReader):
    """Cannot do it."""

    name = "refuses"

    def accelerations(self, *arguments: Any) -> Any:
        raise mbcheck.Unsupported("no actuators")
