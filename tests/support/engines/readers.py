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

    def force(self, v: Any) -> Any:
        """Return forces (n,) that the file does not have."""
        return 0 * v

    def read(self, system: mbcheck.System) -> Any:
        """Return the model after the edit."""
        model = mujoco.MjModel.from_xml_path(system.path)
        self.edit(model)
        mujoco.mj_setConst(model, mujoco.MjData(model))  # as after compiling what it has read
        return model

    def accelerations(self, system: mbcheck.System, time: float, q: Any, v: Any) -> Any:
        """Return MuJoCo's accelerations (n,) after the edit."""
        model = self.read(system)
        data = mujoco.MjData(model)
        data.qpos, data.qvel, data.ctrl = q, v, system.controls(time)
        data.qfrc_applied = self.force(v)
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


class WithMassMatrix(FileReader):
    """Has a mass matrix, too."""

    def mass_matrix(self, system: mbcheck.System, q: Any) -> Any:
        """Return MuJoCo's after the edit."""
        model = self.read(system)
        data = mujoco.MjData(model)
        data.qpos = q
        mujoco.mj_forward(model, data)
        rows = np.zeros((model.nv, model.nv))
        for row, unit in zip(rows, np.eye(model.nv), strict=True):
            mujoco.mj_mulM(model, data, row, unit)
        return rows


class JointsLost(FileReader):
    """Drops armature, stiffness and damping of all joints."""

    name = "joints_lost"

    def edit(self, model: Any) -> None:
        model.dof_armature[:] = 0
        model.jnt_stiffness[:] = 0
        model.dof_damping[:] = 0


class JointsLostByMass(JointsLost, WithMassMatrix):
    """The same, with a mass matrix."""

    name = "joints_lost_by_mass"


class MassMisread(FileReader):
    """Reads the mass of the second body 1.3 times as large, and drops armature and damping."""

    name = "mass_misread"

    def edit(self, model: Any) -> None:
        model.body_mass[2] *= 1.3
        model.dof_armature[:] = 0
        model.dof_damping[:] = 0


class MassMisreadByMass(MassMisread, WithMassMatrix):
    """The same, with a mass matrix."""

    name = "mass_misread_by_mass"


class MotorLost(FileReader):
    """Drops armature and gravity, and reads the gear of the first motor as 1."""

    name = "motor_lost"

    def edit(self, model: Any) -> None:
        model.dof_armature[:] = 0
        model.opt.gravity[:] = 0
        model.actuator_gear[0, 0] = 1


class MotorLostByMass(MotorLost, WithMassMatrix):
    """The same, with a mass matrix."""

    name = "motor_lost_by_mass"


class Drag(FileReader):
    """Drops damping and armature, and adds a cubic drag, for which MJCF of hinges has no word."""

    name = "drag"

    def edit(self, model: Any) -> None:
        model.dof_armature[:] = 0
        model.dof_damping[:] = 0

    def force(self, v: Any) -> Any:
        return -0.3 * np.sinh(v)


class DragByMass(Drag, WithMassMatrix):
    """The same, with a mass matrix."""

    name = "drag_by_mass"


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


class OtherOrderWithDrag(OtherConventions):
    """Joints in another order, and a drag that no edit explains."""

    name = "other_order_with_drag"

    def force(self, v: Any) -> Any:
        return -0.3 * np.sinh(v)


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
