"""Rules about what drives a model: actuators, their ranges, and the joints that they move."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ....reference.scene import Array
from ..mujoco.model import OPENED, Flags, State, numbers
from ..subject import Hit, InspectedModel
from .parts import gears
from .remedies import moments

SPEED = 0.1
"""Speed [rad/s, m/s] at which the damping of a joint is read, either way."""

MOST_STATES = 8
"""States in which it is."""

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


def tendons_of_one_joint(s: InspectedModel) -> dict[int, tuple[int, float]]:
    """Return the fixed tendons over one hinge or slide: tendon -> joint and coefficient."""
    m, listed = s.model, {}
    over_joint = s.loaded.of_kind("wrap_type", "joint")
    for tendon, (start, count) in enumerate(zip(m.tendon_adr, m.tendon_num, strict=True)):
        parts = slice(int(start), int(start + count))
        used = np.asarray(m.wrap_prm[parts]) != 0
        joints = np.unique(np.asarray(m.wrap_objid[parts])[used])
        if np.all(over_joint[parts]) and len(joints) == 1:
            listed[tendon] = (int(joints[0]), float(np.sum(m.wrap_prm[parts])))
    return listed


def on_simple_joints(s: InspectedModel) -> Iterator[tuple[int, int, float]]:
    """Yield the actuators of single hinges and slides, their joints and gears, none of them 0.

    An actuator of a fixed tendon over one joint acts in that joint, with its coefficient.
    """
    m, kind = s.model, s.loaded.of_kind
    simple, single = kind("jnt_type", "hinge", "slide"), tendons_of_one_joint(s)
    direct, pulled = kind("actuator_trntype", "joint", "jointinparent"), tendon_driven(s)
    for i in range(m.nu):
        target = int(m.actuator_trnid[i, 0])
        if direct[i]:
            joint, factor = target, 1.0
        elif pulled[i] and target in single:
            joint, factor = single[target]
        else:
            continue
        gear = float(np.ravel(gears(m, i))[0]) * factor
        if simple[joint] and gear:
            yield i, joint, gear


def tendon_driven(s: InspectedModel) -> Flags:
    """Return which actuators (nu,) pull a tendon."""
    return s.loaded.of_kind("actuator_trntype", "tendon")


def servos(s: InspectedModel) -> list[Servo]:
    """Return the actuators of hinges and slides whose force depends on position or speed."""
    m, affine, listed = s.model, s.loaded.of_kind("actuator_biastype", "affine"), []
    for i, joint, gear in on_simple_joints(s):
        if affine[i]:
            _, position, speed = m.actuator_biasprm[i, :3]
            dof = int(m.jnt_dofadr[joint])
            terms = (-float(position) * gear**2, -float(speed) * gear**2)
            listed.append(Servo(i, joint, dof, gear, *terms))
    return listed


def sign_attribute(s: InspectedModel, servo: Servo, what: str) -> str:
    """Return the attribute in which an actuator has its reaction to ``position`` or ``speed``."""
    element = s.loaded.places.get(("actuator", servo.actuator))
    tag = element.tag if element else "general"
    if tag in ("position", "velocity", "intvelocity"):
        return "kp" if what == "position" else "kv"
    return "bias" if tag == "cylinder" else "biasprm"


def pulls_to_control(s: InspectedModel) -> Flags:
    """Return which actuators (nu,) have a position for control: gain and stiffness are the same."""
    m, kind = s.model, s.loaded.of_kind
    stiffness = -m.actuator_biasprm[:, 1]
    alike = (stiffness > 0) & np.isclose(m.actuator_gainprm[:, 0], stiffness)
    affine, plain = kind("actuator_biastype", "affine"), kind("actuator_gaintype", "fixed")
    return np.asarray(alike & affine & plain)


def position_servos(s: InspectedModel) -> list[Servo]:
    """Return the servos whose control, or what is integrated of it, is a position."""
    pulls = pulls_to_control(s)
    return [one for one in servos(s) if pulls[one.actuator]]


class Asked(NamedTuple):
    """The positions (2,) that a servo may be asked for, and the range (2,) of its joint, if any.

    ``attribute`` is the range of the actuator that says it.
    """

    servo: Servo
    attribute: str
    positions: Array
    bounds: Array | None


def asked_servos(s: InspectedModel) -> Iterator[Asked]:
    """Yield the position servos that are asked for positions in a range.

    The control of one that integrates is a speed; its activation is the position.
    """
    m = s.model
    integrates = s.loaded.of_kind("actuator_dyntype", "integrator")
    for one in position_servos(s):
        i = one.actuator
        name, limited, ends = "ctrlrange", m.actuator_ctrllimited[i], m.actuator_ctrlrange[i]
        if integrates[i]:
            name, limited, ends = "actrange", m.actuator_actlimited[i], m.actuator_actrange[i]
        if limited:
            positions = np.sort(np.asarray(ends) / one.gear)
            yield Asked(one, name, positions, bounds_of(s, one.joint))


def bounds_of(s: InspectedModel, joint: int) -> Array | None:
    """Return the range (2,) of a hinge or slide: its own, and those of tendons over it alone."""
    m, ends = s.model, np.array([-np.inf, np.inf])
    if m.jnt_limited[joint]:
        ends = np.clip(ends, *m.jnt_range[joint])
    for tendon, (one, factor) in tendons_of_one_joint(s).items():
        if one == joint and factor and m.tendon_limited[tendon]:
            ends = np.clip(ends, *np.sort(np.asarray(m.tendon_range[tendon]) / factor))
    return ends if np.all(np.isfinite(ends)) else None


def damping_of(s: InspectedModel, dof: int) -> float:
    """Return the damping of a degree of freedom by all that acts in it, where it is largest.

    The difference of passive forces and of actuators', not limited, over that of its speed, in
    the states of the file: joints, tendons, actuators of any kind, fluids.
    """
    lib, model = s.loaded.mujoco, s.loaded.sharp()
    for limited in ("actuator_forcelimited", "jnt_actfrclimited", "tendon_actfrclimited"):
        getattr(model, limited)[:] = 0
    values = [0.0]
    for state in s.loaded.states[:MOST_STATES]:
        forces = []
        for speed in (SPEED, -SPEED):
            data = s.loaded.data(state, model)
            data.qvel[:] = 0
            data.qvel[dof] = speed
            lib.mj_forward(model, data)
            forces.append(float(data.qfrc_passive[dof] + data.qfrc_actuator[dof]))
        values.append((forces[1] - forces[0]) / (2 * SPEED))
    return max(values)


class Strength(NamedTuple):
    """The least and the largest force of an actuator on a hinge or slide, -inf and inf of most."""

    actuator: int
    joint: int
    low: float
    high: float


def strengths(s: InspectedModel) -> Iterator[Strength]:
    """Yield what the actuators of hinges and slides can give, by their force or their control."""
    m, single, pulled = s.model, tendons_of_one_joint(s), tendon_driven(s)
    by_control = motors(s) & (m.actuator_ctrllimited != 0)
    for i, joint, gear in on_simple_joints(s):
        limits = [
            (m.actuator_forcelimited[i], m.actuator_forcerange[i], gear),
            (by_control[i], m.actuator_ctrlrange[i], gear * m.actuator_gainprm[i, 0]),
            (m.jnt_actfrclimited[joint], m.jnt_actfrcrange[joint], 1.0),
        ]
        if pulled[i]:
            tendon = int(m.actuator_trnid[i, 0])
            whole = m.tendon_actfrclimited[tendon], m.tendon_actfrcrange[tendon]
            limits.append((*whole, single[tendon][1]))
        ends = np.array([-np.inf, np.inf])
        for limited, own, factor in limits:
            if limited:
                ends = np.clip(ends, *np.sort(np.asarray(own) * factor))
        yield Strength(i, joint, float(ends[0]), float(ends[1]))


def motors(s: InspectedModel) -> Flags:
    """Return which actuators (nu,) give a force in proportion to their control."""
    kind = s.loaded.of_kind
    plain = kind("actuator_gaintype", "fixed") & kind("actuator_biastype", "none")
    return np.asarray(plain & kind("actuator_dyntype", "none"))


def joint_units(s: InspectedModel, joint: int) -> tuple[str, str]:
    """Return in which units a hinge or slide moves, and is moved."""
    return ("rad", "Nm") if s.loaded.of_kind("jnt_type", "hinge")[joint] else ("m", "N")


# Rules ------------------------------------------------------------------------------------------


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
