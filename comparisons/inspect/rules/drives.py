"""Rules about what drives a model: actuators, their ranges, and the joints that they move."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ....reference.scene import Array
from ..mujoco.model import OPENED, Flags, Numbers, State, numbers
from ..subject import Hit, InspectedModel
from .parts import gears

TURNS = 4 * np.pi
"""A position that is asked of a hinge beyond it is one in degrees."""

BEYOND = 0.1
"""Share of a joint's range by which a servo may ask for more: calibration, and a firm hold."""

DAMPED = 0.02
"""Damping ratio of a servo below which it rings for tens of periods."""

TURN_IN_A_STEP = np.pi
"""What full force may turn a joint by in the first step [rad]."""

FULL = 1 - 1e-9
"""Share of the largest force from which on an actuator gives all."""

DRIFT, SHIFT = 0.2, 0.2
"""How far a servo may have to give way to hold a keyframe [rad], and in the model's size."""

SKEWED = 0.01
"""By how much the norm of a quaternion in a keyframe may differ from 1."""


class Servo(NamedTuple):
    """An actuator that pulls a hinge or slide to where its control says.

    ``stiffness`` and ``damping`` are those that it gives the joint; ``gear`` is the length of the
    actuator for a unit of the joint's coordinate.
    """

    actuator: int
    joint: int
    dof: int
    gear: float
    stiffness: float
    damping: float


def servos(s: InspectedModel) -> list[Servo]:
    """Return the actuators of hinges and slides whose force depends on position or speed."""
    m, kind = s.model, s.loaded.of_kind
    simple = kind("jnt_type", "hinge", "slide")
    affine = kind("actuator_biastype", "affine") & kind("actuator_trntype", "joint")
    listed = []
    for i in np.flatnonzero(affine):
        joint = int(m.actuator_trnid[i, 0])
        gear = float(np.ravel(gears(m, int(i)))[0])
        if simple[joint] and gear:
            _, position, speed = m.actuator_biasprm[i, :3]
            dof = int(m.jnt_dofadr[joint])
            terms = (-float(position) * gear**2, -float(speed) * gear**2)
            listed.append(Servo(int(i), joint, dof, gear, *terms))
    return listed


def position_servos(s: InspectedModel) -> list[Servo]:
    """Return those whose control is a position: gain and stiffness are the same."""
    m = s.model
    return [
        one
        for one in servos(s)
        if one.stiffness > 0
        and np.isclose(m.actuator_gainprm[one.actuator, 0], -m.actuator_biasprm[one.actuator, 1])
        and s.loaded.of_kind("actuator_gaintype", "fixed")[one.actuator]
    ]


def ranges(s: InspectedModel, servo: Servo) -> tuple[Array, Array | None]:
    """Return the positions (2,) that a servo may be asked for, and the range (2,) of its joint."""
    m = s.model
    asked = np.sort(np.asarray(m.actuator_ctrlrange[servo.actuator]) / servo.gear)
    limited = bool(m.jnt_limited[servo.joint])
    return asked, np.asarray(m.jnt_range[servo.joint]) if limited else None


def asked_servos(s: InspectedModel) -> Iterator[tuple[Servo, Array, Array | None]]:
    """Yield the position servos with a range of control, with what `ranges` gives."""
    for one in position_servos(s):
        if s.model.actuator_ctrllimited[one.actuator]:
            yield one, *ranges(s, one)


def in_degrees(s: InspectedModel, servo: Servo, asked: Array, bounds: Array | None) -> bool:
    """Return whether a range of control looks as if it were in degrees."""
    hinge = bool(s.loaded.of_kind("jnt_type", "hinge")[servo.joint])
    wide = bounds is None or np.max(np.abs(asked)) > 10 * np.max(np.abs(bounds))
    return hinge and wide and float(np.max(np.abs(asked))) > TURNS


def control_in_degrees(s: InspectedModel) -> Iterator[Hit]:
    """A range of control that is in degrees."""
    for one, asked, bounds in asked_servos(s):
        if in_degrees(s, one, asked, bounds):
            message = (
                f"its ctrlrange of {asked[0]:g} to {asked[1]:g} rad is up to "
                f"{np.max(np.abs(asked)) / (2 * np.pi):.3g} turns of {joint_of(s, one)}: controls "
                "are in radians, whatever the compiler's angle"
            )
            yield s.hit("actuator", one.actuator, message, attribute="ctrlrange")


def control_beyond_range(s: InspectedModel) -> Iterator[Hit]:
    """A servo that may be asked for what its hinge cannot reach; grippers press on purpose."""
    hinges = s.loaded.of_kind("jnt_type", "hinge")
    for one, asked, bounds in asked_servos(s):
        if bounds is None or not hinges[one.joint] or in_degrees(s, one, asked, bounds):
            continue
        over = max(bounds[0] - asked[0], asked[1] - bounds[1])
        if over > BEYOND * (bounds[1] - bounds[0]) * (1 + 1e-9):
            message = (
                f"its ctrlrange asks {joint_of(s, one)} for {asked[0]:.4g} to {asked[1]:.4g}, and "
                f"the joint's range is {bounds[0]:.4g} to {bounds[1]:.4g}: it pushes into the limit"
            )
            yield s.hit("actuator", one.actuator, message, attribute="ctrlrange")


def unlimited_joint(s: InspectedModel) -> Iterator[Hit]:
    """A joint without a limit that a servo moves within a range."""
    for one, asked, bounds in asked_servos(s):
        if bounds is None and not in_degrees(s, one, asked, bounds):
            name = s.loaded.name("actuator", one.actuator)
            message = (
                f"it has no limit, and {name} moves it from {asked[0]:.4g} to {asked[1]:.4g}: a "
                "load carries it beyond"
            )
            yield s.hit("joint", one.joint, message)


def joint_of(s: InspectedModel, servo: Servo) -> str:
    """Return the name of the joint that a servo moves."""
    return s.loaded.name("joint", servo.joint)


def positive_feedback(s: InspectedModel) -> Iterator[Hit]:
    """A servo that pushes away from where it shall be, or along with its speed."""
    for one in servos(s):
        parts = [("position", one.stiffness), ("speed", one.damping)]
        for what, resists in parts:
            if resists < 0:
                message = (
                    f"its force grows with the {what} of {joint_of(s, one)}, by "
                    f"{-resists:.4g} for a unit of it: it pushes on what it shall hold back"
                )
                yield s.hit("actuator", one.actuator, message, attribute="biasprm")


def undamped_servo(s: InspectedModel) -> Iterator[Hit]:
    """A servo that nothing damps."""
    m = s.model
    for one in position_servos(s):
        same = [other for other in servos(s) if other.dof == one.dof]
        damping = float(m.dof_damping[one.dof]) + sum(other.damping for other in same)
        ratio = damping / (2 * np.sqrt(one.stiffness * float(m.dof_M0[one.dof])))
        if ratio < DAMPED and not m.dof_frictionloss[one.dof] and not m.opt.viscosity:
            message = (
                f"it holds {joint_of(s, one)} with a damping ratio of {ratio:.2g}: a disturbance "
                "rings for tens of periods"
            )
            yield s.hit("actuator", one.actuator, message)


def two_servos(s: InspectedModel) -> Iterator[Hit]:
    """Two servos on one joint, each of which pulls it to a place of its own."""
    seen: dict[int, int] = {}
    for one in position_servos(s):
        first = seen.setdefault(one.joint, one.actuator)
        if first != one.actuator:
            message = (
                f"it and {s.loaded.name('actuator', first)} both hold {joint_of(s, one)}: with "
                "different controls they work against each other"
            )
            yield s.hit("actuator", one.actuator, message)


def light_joint(s: InspectedModel) -> Iterator[Hit]:
    """A joint too light for the force that acts on it, at the step of the file."""
    m = s.model
    motors = s.loaded.of_kind("actuator_trntype", "joint") & (m.actuator_forcelimited != 0)
    hinge = s.loaded.of_kind("jnt_type", "hinge")
    for i in np.flatnonzero(motors):
        joint = int(m.actuator_trnid[i, 0])
        gear = float(np.ravel(gears(m, int(i)))[0])
        force = abs(gear) * float(np.max(np.abs(m.actuator_forcerange[i])))
        inertia = float(m.dof_M0[m.jnt_dofadr[joint]])
        turn = force / inertia * s.timestep**2
        if hinge[joint] and turn > TURN_IN_A_STEP:
            message = (
                f"its inertia of {inertia:.3g} kg m^2 is turned by {turn:.3g} rad in the first "
                f"step of {s.timestep:g} s under the full force of "
                f"{s.loaded.name('actuator', i)}, {force:.3g} Nm"
            )
            yield s.hit("joint", joint, message)


def spring_beyond_range(s: InspectedModel) -> Iterator[Hit]:
    """A spring that rests beyond the joint's limits."""
    m = s.model
    sprung = (m.jnt_limited != 0) & (m.jnt_stiffness != 0)
    sprung &= s.loaded.of_kind("jnt_type", "hinge", "slide")
    rests = m.qpos_spring[m.jnt_qposadr]
    low, high = m.jnt_range.T
    slack = 1e-6 * (high - low)
    return s.hits(
        "joint",
        sprung & ((rests < low - slack) | (rests > high + slack)),
        lambda i: (
            f"its spring rests at {rests[i]:.4g}, beyond its range of {low[i]:.4g} to "
            f"{high[i]:.4g}: it is pressed against its limit"
        ),
        attribute="springref",
    )


def zero_quaternion(s: InspectedModel) -> Iterator[Hit]:
    """A keyframe whose quaternion is none."""
    m = s.model
    turning = s.loaded.of_kind("jnt_type", "free", "ball")
    first = m.jnt_qposadr + 3 * s.loaded.of_kind("jnt_type", "free")
    for key in s.loaded.source.tagged("key"):
        values = numbers(key.attributes.get("qpos", ""))
        if len(values) != m.nq:
            continue
        for joint in np.flatnonzero(turning):
            norm = float(np.linalg.norm(values[first[joint] : first[joint] + 4]))
            if abs(norm - 1) > SKEWED:
                name = s.loaded.name("joint", joint)
                what = "zero" if norm == 0 else f"of norm {norm:.4g}"
                message = (
                    f"the quaternion of {name} is {what}; MuJoCo takes "
                    f"{'no rotation' if norm == 0 else 'its direction'} without a word"
                )
                yield Hit(key, key.address, message, attribute="qpos")


def keyframes(s: InspectedModel) -> Iterator[State]:
    """Yield the keyframes in which nothing moves, and which have the joints somewhere."""
    for view in s.views:
        resting = not np.any(view.state.velocity) and view.steady_hinge is None
        if resting and view.state.keys != (OPENED,) and s.model.nu:
            yield view.state


def saturated_actuator(s: InspectedModel) -> Iterator[Hit]:
    """An actuator that gives all its force in a keyframe."""
    m, said = s.model, set[int]()
    for state in keyframes(s):
        data = s.loaded.data(state)
        s.loaded.mujoco.mj_forward(m, data)
        for i in full_force(s, np.array(data.actuator_force)):
            if i not in said:
                said.add(int(i))
                low, high = m.actuator_forcerange[i]
                message = (
                    f"in the state {state.name!r} it gives all its force, "
                    f"{float(data.actuator_force[i]):.4g} of {low:.4g} to {high:.4g}"
                )
                yield s.hit("actuator", i, message)


def full_force(s: InspectedModel, force: Array) -> Numbers:
    """Return the actuators whose servos' forces (nu,) are at their limit."""
    m = s.model
    listed = {one.actuator for one in servos(s)}
    low, high = np.asarray(m.actuator_forcerange).T
    most = ((force >= FULL * high) & (high > 0)) | ((force <= FULL * low) & (low < 0))
    reacts: Flags = np.isin(np.arange(m.nu), list(listed))
    return np.flatnonzero(most & (m.actuator_forcelimited != 0) & reacts)


def control_not_holding(s: InspectedModel) -> Iterator[Hit]:
    """A keyframe that its own controls leave."""
    m, said = s.model, set[int]()
    stiff = {one.dof: one for one in position_servos(s)}
    for state in keyframes(s):
        model = s.loaded.sharp()
        data = s.loaded.data(state, model)
        s.loaded.mujoco.mj_forward(model, data)
        left = np.empty(m.nv)
        s.loaded.mujoco.mj_mulM(model, data, left, data.qacc)
        for dof, one in stiff.items():
            drift = float(left[dof]) / one.stiffness
            hinge = bool(s.loaded.of_kind("jnt_type", "hinge")[one.joint])
            if abs(drift) > (DRIFT if hinge else SHIFT * s.facts.size) and one.joint not in said:
                said.add(one.joint)
                message = (
                    f"the controls of the state {state.name!r} do not hold it: "
                    f"{s.loaded.name('actuator', one.actuator)} gives way by about {drift:.3g} "
                    f"{'rad' if hinge else 'm'}"
                )
                yield s.hit("joint", one.joint, message)
