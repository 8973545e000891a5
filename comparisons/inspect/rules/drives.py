"""Rules about what drives a model: actuators, their ranges, and the joints that they move."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ....reference.scene import Array
from ..mujoco.model import OPENED, Flags, State, numbers
from ..subject import Hit, InspectedModel
from .actuation import (
    Asked,
    Servo,
    asked_servos,
    damping_of,
    joint_units,
    motors,
    position_servos,
    pulls_to_control,
    servos,
    sign_attribute,
    strengths,
)
from .remedies import moments

TURNS = 4 * np.pi
"""A position that is asked of a hinge beyond it is one in degrees."""

BEYOND = 0.1
"""Share of a joint's range by which a servo may ask for more: calibration, and a firm hold."""

DAMPED = 0.02
"""Damping ratio of a servo below which it rings for tens of periods."""

TURN_IN_A_STEP = np.pi
"""What full force may turn a joint by in the first step [rad]."""

DRIFT, SHIFT = 0.2, 0.2
"""How far a servo may have to give way to hold a keyframe [rad], and in the model's size."""

OVERLOAD = 0.01
"""Share by which the load of a keyframe may be beyond what an actuator gives."""

OFF = 0.5
"""Share of a motor's force that may be missing, or too much, to hold a keyframe."""

FALLING = 0.5
"""Share of gravity from which on a free body falls: nothing is held in it."""

LOOSE = 0.1
"""Share of what would hold a joint from which on joints of its tree without a drive may be out of
balance, and no more: where more is, they fall, and nothing is held."""

SKEWED = 0.01
"""By how much the norm of a quaternion in a keyframe may differ from 1."""


def in_degrees(s: InspectedModel, one: Asked) -> bool:
    """Return whether a range of control looks as if it were in degrees."""
    hinge = bool(s.loaded.of_kind("jnt_type", "hinge")[one.servo.joint])
    most = float(np.max(np.abs(one.positions)))
    wide = one.bounds is None or most > 10 * np.max(np.abs(one.bounds))
    return hinge and wide and most > TURNS


def control_in_degrees(s: InspectedModel) -> Iterator[Hit]:
    for one in asked_servos(s):
        if in_degrees(s, one):
            low, high = one.positions
            message = (
                f"its {one.attribute} of {low:g} to {high:g} rad is up to "
                f"{max(-low, high) / (2 * np.pi):.3g} turns of {joint_of(s, one.servo)}: controls "
                "are in radians, whatever the compiler's angle"
            )
            yield s.hit("actuator", one.servo.actuator, message, attribute=one.attribute)


def control_beyond_range(s: InspectedModel) -> Iterator[Hit]:
    hinges = s.loaded.of_kind("jnt_type", "hinge")
    for one in asked_servos(s):
        if one.bounds is None or not hinges[one.servo.joint] or in_degrees(s, one):
            continue
        (low, high), (least, most) = one.positions, one.bounds
        if max(least - low, high - most) > BEYOND * (most - least) * (1 + 1e-9):
            message = (
                f"its {one.attribute} asks {joint_of(s, one.servo)} for {low:.4g} to {high:.4g}, "
                f"and the joint's range is {least:.4g} to {most:.4g}: it pushes into the limit"
            )
            yield s.hit("actuator", one.servo.actuator, message, attribute=one.attribute)


def unlimited_joint(s: InspectedModel) -> Iterator[Hit]:
    for one in asked_servos(s):
        if one.bounds is None and not in_degrees(s, one):
            name = s.loaded.name("actuator", one.servo.actuator)
            message = (
                f"it has no limit, and {name} moves it from {one.positions[0]:.4g} to "
                f"{one.positions[1]:.4g}: a load carries it beyond"
            )
            yield s.hit("joint", one.servo.joint, message)


def joint_of(s: InspectedModel, servo: Servo) -> str:
    """Return the name of the joint that a servo moves."""
    return s.loaded.name("joint", servo.joint)


def positive_feedback(s: InspectedModel) -> Iterator[Hit]:
    for one in servos(s):
        parts = [("position", one.stiffness), ("speed", one.damping)]
        for what, resists in parts:
            if resists < 0:
                message = (
                    f"its force grows with the {what} of {joint_of(s, one)}, by "
                    f"{-resists:.4g} for a unit of it: it pushes on what it shall hold back"
                )
                attribute = sign_attribute(s, one, what)
                hit = s.hit("actuator", one.actuator, message, attribute=attribute)
                yield hit._replace(fix=f"turn the sign of {attribute}")


def undamped_servo(s: InspectedModel) -> Iterator[Hit]:
    m, every = s.model, servos(s)
    for one in position_servos(s):
        critical = 2 * np.sqrt(one.stiffness * float(m.dof_M0[one.dof]))
        own = float(m.dof_damping[one.dof])
        own += sum(other.damping for other in every if other.dof == one.dof)
        dry = m.dof_frictionloss[one.dof] or np.any(m.tendon_frictionloss)
        if own >= DAMPED * critical or dry or m.opt.viscosity:
            continue  # most are, which costs nothing to see
        ratio = damping_of(s, one.dof) / critical
        if ratio < DAMPED:
            message = (
                f"it holds {joint_of(s, one)} with a damping ratio of {ratio:.2g}: a disturbance "
                "rings for tens of periods"
            )
            yield s.hit("actuator", one.actuator, message)


def two_servos(s: InspectedModel) -> Iterator[Hit]:
    m, seen = s.model, dict[tuple[str, int], int]()
    every = [("hold", one.actuator, one.joint) for one in position_servos(s)]
    both_ways = motors(s) & ~((m.actuator_ctrllimited != 0) & np.any(m.actuator_ctrlrange == 0, 1))
    every += [("drive", one.actuator, one.joint) for one in strengths(s) if both_ways[one.actuator]]
    for what, actuator, joint in every:
        first = seen.setdefault((what, joint), actuator)
        if first != actuator:
            wrong = "with different controls they work against each other"
            message = (
                f"it and {s.loaded.name('actuator', first)} both {what} "
                f"{s.loaded.name('joint', joint)}: "
                f"{wrong if what == 'hold' else 'their forces add'}"
            )
            yield s.hit("actuator", actuator, message)


def light_joint(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    for one in strengths(s):
        force = max(-one.low, one.high)
        inertia = float(m.dof_M0[m.jnt_dofadr[one.joint]])
        way = force / inertia * s.timestep**2
        unit, unit_of_force = joint_units(s, one.joint)
        hinge = unit == "rad"
        if np.inf > way > (TURN_IN_A_STEP if hinge else s.facts.size):
            what = (
                f"inertia of {inertia:.3g} kg m^2 is turned"
                if hinge
                else f"mass of {inertia:.3g} kg is moved"
            )
            message = (
                f"its {what} by {way:.3g} {unit} in the first step of {s.timestep:g} s under the "
                f"full force of {s.loaded.name('actuator', one.actuator)}, {force:.3g} "
                f"{unit_of_force}{'' if hinge else f': the model has {s.facts.size:.3g} m'}"
            )
            yield s.hit("joint", one.joint, message)


def spring_beyond_range(s: InspectedModel) -> Iterator[Hit]:
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
    m = s.model
    turning = s.loaded.of_kind("jnt_type", "free", "ball")
    first = m.jnt_qposadr + 3 * s.loaded.of_kind("jnt_type", "free")
    places = [
        ("qpos", m.nq, int(first[i]), s.loaded.name("joint", i)) for i in np.flatnonzero(turning)
    ]
    mocap = np.flatnonzero(m.body_mocapid >= 0)
    places += [
        ("mquat", 4 * m.nmocap, 4 * int(m.body_mocapid[i]), s.loaded.name("body", i)) for i in mocap
    ]
    for key in s.loaded.source.tagged("key"):
        for attribute, size, start, name in places:
            values = numbers(key.attributes.get(attribute, ""))
            norm = float(np.linalg.norm(values[start : start + 4])) if len(values) == size else 1.0
            if abs(norm - 1) > SKEWED:
                what = "zero" if norm == 0 else f"of norm {norm:.4g}"
                message = (
                    f"the quaternion of {name} is {what}; MuJoCo takes "
                    f"{'no rotation' if norm == 0 else 'its direction'} without a word"
                )
                yield Hit(key, key.address, message, attribute=attribute)


def keyframes(s: InspectedModel) -> Iterator[State]:
    """Yield the keyframes in which nothing moves, and which have the joints somewhere."""
    for view in s.views:
        resting = not np.any(view.state.velocity) and view.steady_hinge is None
        if resting and view.state.keys != (OPENED,) and s.model.nu:
            yield view.state


class KeyframeForces(NamedTuple):
    """Forces in a keyframe: its data, and some of each degree of freedom (nv,).

    The moment arms (nu, nv) of actuators, what is left over, whether it falls freely, and the most
    that is left over in its tree at a joint that is neither free nor driven.
    """

    data: Any
    arms: Array
    left: Array
    free: Flags
    undriven: Array

    def falls(self, dof: int) -> bool:
        """Return whether nothing is held about a degree of freedom."""
        return bool(self.free[dof] or self.undriven[dof] > LOOSE * abs(self.needs(dof)))

    def needs(self, dof: int) -> float:
        """Return the force of actuators that would hold a degree of freedom."""
        force, left = float(self.data.qfrc_actuator[dof]), float(self.left[dof])
        return 0.0 if np.isclose(force, left, rtol=1e-12, atol=0.0) else force - left


def balance_of(s: InspectedModel, state: State, unlimited: Flags | None = None) -> KeyframeForces:
    """Return the forces in a keyframe, those of some actuators (nu,) without their limits."""
    m, model = s.model, s.loaded.sharp()
    if unlimited is not None:
        model.actuator_forcelimited[unlimited] = 0
        model.jnt_actfrclimited[:], model.tendon_actfrclimited[:] = 0, 0
    data, left = s.loaded.data(state, model), np.empty(m.nv)
    s.loaded.mujoco.mj_forward(model, data)
    s.loaded.mujoco.mj_mulM(model, data, left, data.qacc)
    free = s.loaded.of_kind("jnt_type", "free")
    first = m.jnt_dofadr[free]
    falls = [i for i in first if np.linalg.norm(data.qacc[i : i + 3]) > FALLING * gravity(s)]
    arms = moments(s.loaded, state)
    bound = np.any(arms, axis=0) | free[m.dof_jntid]
    most = np.zeros(m.ntree)
    np.maximum.at(most, m.dof_treeid, np.where(bound, 0.0, np.abs(left)))
    falling = np.isin(m.dof_treeid, m.dof_treeid[falls])
    return KeyframeForces(data, arms, left, falling, most[m.dof_treeid])


def gravity(s: InspectedModel) -> float:
    """Return the size of gravity [m/s^2]."""
    return float(np.linalg.norm(s.facts.options.gravity))


def saturated_actuator(s: InspectedModel) -> Iterator[Hit]:
    m, said = s.model, set[int]()
    for state in keyframes(s):
        balance = balance_of(s, state)
        for one in strengths(s):
            dof = int(m.jnt_dofadr[one.joint])
            need = balance.needs(dof)
            room = OVERLOAD * abs(need)
            alone = not balance.falls(dof) and np.count_nonzero(balance.arms[:, dof]) == 1
            within = one.low - room <= need <= one.high + room
            if one.actuator in said or not alone or within:
                continue
            said.add(one.actuator)
            _, unit = joint_units(s, one.joint)
            message = (
                f"in the state {state.name!r} {s.loaded.name('joint', one.joint)} takes "
                f"{need:.4g} {unit} to stay, and its limits are {one.low:.4g} to {one.high:.4g} "
                f"{unit}"
            )
            yield s.hit("actuator", one.actuator, message)


def control_not_holding(s: InspectedModel) -> Iterator[Hit]:
    """A keyframe that its own controls leave.

    A servo moves its joint to where its control asks, however weak it is: its force counts without
    limits. Where a joint falls, a servo counts if it gives all its force, and without a load.
    """
    said = set[int]()
    for state in keyframes(s):
        limited, balance = balance_of(s, state), balance_of(s, state, pulls_to_control(s))
        force = balance.data.qfrc_actuator
        full = limited.data.qfrc_actuator != force
        falls = np.array([limited.falls(dof) for dof in range(s.model.nv)])
        balance = balance._replace(left=np.where(falls, force, balance.left))
        ways = [*simple_joints_left(s, limited, balance), *ball_joints_left(s, balance)]
        for joint, how in ways:
            dof = int(s.model.jnt_dofadr[joint])
            if (full[dof] or not falls[dof]) and joint not in said:
                said.add(joint)
                message = f"the controls of the state {state.name!r} do not hold it: {how}"
                yield s.hit("joint", joint, message)


def simple_joints_left(
    s: InspectedModel, limited: KeyframeForces, balance: KeyframeForces
) -> Iterator[tuple[int, str]]:
    """Yield the hinges and slides that leave a keyframe, and how; servos without their limits."""
    stiff = {one.actuator: one.stiffness for one in position_servos(s)}
    driven = motors(s) & (balance.data.ctrl != 0)
    for one in strengths(s):
        dof, (unit, unit_of_force) = int(s.model.jnt_dofadr[one.joint]), joint_units(s, one.joint)
        left, force = float(limited.left[dof]), float(limited.data.qfrc_actuator[dof])
        name = s.loaded.name("actuator", one.actuator)
        if one.actuator in stiff:
            drift = float(balance.left[dof]) / stiff[one.actuator]
            if abs(drift) > (DRIFT if unit == "rad" else SHIFT * s.facts.size):
                yield one.joint, f"{name} gives way by about {drift:.3g} {unit}"
        elif driven[one.actuator] and abs(left) > OFF * abs(force):
            need = f"{limited.needs(dof):.3g} would hold it"
            yield one.joint, f"{name} gives {force:.3g} {unit_of_force}, and {need}"


def ball_joints_left(s: InspectedModel, balance: KeyframeForces) -> Iterator[tuple[int, str]]:
    """Yield the ball joints that leave a keyframe, about the axes on which they have servos."""
    m, kind = s.model, s.loaded.of_kind
    acts = pulls_to_control(s) & kind("actuator_trntype", "joint", "jointinparent")
    for joint in np.flatnonzero(kind("jnt_type", "ball")):
        own = np.flatnonzero(acts & (m.actuator_trnid[:, 0] == joint))
        dofs = slice(int(m.jnt_dofadr[joint]), int(m.jnt_dofadr[joint]) + 3)
        arms = balance.arms[own, dofs]
        stiffness = -(arms.T * m.actuator_biasprm[own, 1]) @ arms
        turn = float(np.linalg.norm(np.linalg.pinv(stiffness) @ balance.left[dofs]))
        if turn > DRIFT:
            names = ", ".join(s.loaded.name("actuator", i) for i in own)
            yield int(joint), f"{names} give way by about {turn:.3g} rad"
