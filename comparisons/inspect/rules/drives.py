"""Rules about what drives a model: actuators, their ranges, and the joints that they move."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
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


class Drive(NamedTuple):
    """An actuator of one hinge or slide: directly, or by a fixed tendon over that joint alone.

    Attributes
    ----------
    actuator, joint, dof : int
    name, where : str
        Those of the actuator and of its joint.
    gear : float
        The length of the actuator for a unit of the joint's coordinate, not 0.
    stiffness, damping : float
        With which it holds the joint back.
    holds, motor : bool
        Whether its control is a position, or a force.
    low, high : float
        Its least and largest force on the joint, -inf and inf of most.
    unit, unit_of_force : str
        In which the joint moves, and is moved.
    """

    actuator: int
    joint: int
    dof: int
    name: str
    where: str
    gear: float
    stiffness: float
    damping: float
    holds: bool
    motor: bool
    low: float
    high: float
    unit: str
    unit_of_force: str


def drives(s: InspectedModel) -> list[Drive]:
    """Return the actuators of single hinges and slides."""
    m, kind, tendons = s.model, s.loaded.of_kind, tendons_of_one_joint(s)
    simple, hinges = kind("jnt_type", "hinge", "slide"), kind("jnt_type", "hinge")
    direct, pulled = (
        kind("actuator_trntype", "joint", "jointinparent"),
        kind("actuator_trntype", "tendon"),
    )
    affine, holds, motor = kind("actuator_biastype", "affine"), pulls_to_control(s), motors(s)
    listed = []
    for i, target in enumerate(m.actuator_trnid[:, 0].tolist()):
        nothing = (target, float(direct[i]))
        joint, factor = tendons.get(target, nothing) if pulled[i] else nothing
        gear = float(np.ravel(gears(m, i))[0]) * factor
        if not gear or not simple[joint]:
            continue
        limits = [
            (m.actuator_forcelimited[i], m.actuator_forcerange[i], gear),
            (
                motor[i] & m.actuator_ctrllimited[i],
                m.actuator_ctrlrange[i],
                gear * m.actuator_gainprm[i, 0],
            ),
            (m.jnt_actfrclimited[joint], m.jnt_actfrcrange[joint], 1.0),
        ]
        if pulled[i]:
            limits.append((m.tendon_actfrclimited[target], m.tendon_actfrcrange[target], factor))
        low, high = narrowest(limits)
        _, position, speed = (m.actuator_biasprm[i, :3] * affine[i]).tolist()
        drive = Drive(
            actuator=i,
            joint=joint,
            dof=int(m.jnt_dofadr[joint]),
            name=s.loaded.name("actuator", i),
            where=s.loaded.name("joint", joint),
            gear=gear,
            stiffness=-position * gear**2,
            damping=-speed * gear**2,
            holds=bool(holds[i]),
            motor=bool(motor[i]),
            low=float(low),
            high=float(high),
            unit="rad" if hinges[joint] else "m",
            unit_of_force="Nm" if hinges[joint] else "N",
        )
        listed.append(drive)
    return listed


def narrowest(limits: Iterable[tuple[Any, Any, float]]) -> Array:
    """Return the ends (2,) that ranges leave: whether each counts, it, and its factor."""
    ends = np.array([-np.inf, np.inf])
    for limited, own, factor in limits:
        if limited:
            ends = np.clip(ends, *np.sort(np.asarray(own) * factor))
    return ends


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


def sign_attribute(s: InspectedModel, actuator: int, what: str) -> str:
    """Return the attribute in which an actuator has its reaction to ``position`` or ``speed``."""
    element = s.loaded.places.get(("actuator", actuator))
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


def motors(s: InspectedModel) -> Flags:
    """Return which actuators (nu,) give a force in proportion to their control."""
    kind = s.loaded.of_kind
    plain = kind("actuator_gaintype", "fixed") & kind("actuator_biastype", "none")
    return np.asarray(plain & kind("actuator_dyntype", "none"))


class Asked(NamedTuple):
    """A servo, and from where to where it may be asked to move its joint.

    ``attribute`` is the range of the actuator that says it, ``bounds`` (2,) that of the joint with
    those of tendons over it alone, if there is any; ``degrees`` tells whether it looks like them.
    """

    drive: Drive
    attribute: str
    low: float
    high: float
    bounds: Array | None
    degrees: bool


def asked_servos(s: InspectedModel) -> Iterator[Asked]:
    """Yield the position servos that are asked for positions in a range.

    The control of one that integrates is a speed; its activation is the position.
    """
    m, integrates = s.model, s.loaded.of_kind("actuator_dyntype", "integrator")
    for one in drives(s):
        name = "act" if integrates[one.actuator] else "ctrl"
        limited, ends = (
            getattr(m, f"actuator_{name}{what}")[one.actuator] for what in ("limited", "range")
        )
        if one.holds and limited:
            low, high = np.sort(np.asarray(ends) / one.gear).tolist()
            ranges = [(m.jnt_limited[one.joint], m.jnt_range[one.joint], 1.0)]
            for tendon, (joint, factor) in tendons_of_one_joint(s).items():
                if joint == one.joint and factor:
                    ranges.append((m.tendon_limited[tendon], m.tendon_range[tendon], 1 / factor))
            ends = narrowest(ranges)
            bounds = ends if np.all(np.isfinite(ends)) else None
            most = max(-low, high)
            wide = bounds is None or most > 10 * np.max(np.abs(bounds))
            degrees = bool(one.unit == "rad" and wide and most > TURNS)
            yield Asked(one, f"{name}range", low, high, bounds, degrees)


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


# Rules ----------------------------------------------------------------------------------------


def control_in_degrees(s: InspectedModel) -> Iterator[Hit]:
    for one in asked_servos(s):
        if one.degrees:
            message = (
                f"its {one.attribute} of {one.low:g} to {one.high:g} rad is up to "
                f"{max(-one.low, one.high) / (2 * np.pi):.3g} turns of {one.drive.where}: controls "
                "are in radians, whatever the compiler's angle"
            )
            yield s.hit("actuator", one.drive.actuator, message, attribute=one.attribute)


def control_beyond_range(s: InspectedModel) -> Iterator[Hit]:
    for one in asked_servos(s):
        if one.bounds is None or one.drive.unit != "rad" or one.degrees:
            continue  # grippers press on purpose
        least, most = one.bounds
        if max(least - one.low, one.high - most) > BEYOND * (most - least) * (1 + 1e-9):
            message = (
                f"its {one.attribute} asks {one.drive.where} for {one.low:.4g} to {one.high:.4g}, "
                f"and the joint's range is {least:.4g} to {most:.4g}: it pushes into the limit"
            )
            yield s.hit("actuator", one.drive.actuator, message, attribute=one.attribute)


def unlimited_joint(s: InspectedModel) -> Iterator[Hit]:
    for one in asked_servos(s):
        if one.bounds is None and not one.degrees:
            message = (
                f"it has no limit, and {one.drive.name} moves it from {one.low:.4g} to "
                f"{one.high:.4g}: a load carries it beyond"
            )
            yield s.hit("joint", one.drive.joint, message)


def positive_feedback(s: InspectedModel) -> Iterator[Hit]:
    for one in drives(s):
        for what, resists in (("position", one.stiffness), ("speed", one.damping)):
            if resists < 0:
                message = (
                    f"its force grows with the {what} of {one.where}, by {-resists:.4g} for a unit "
                    "of it: it pushes on what it shall hold back"
                )
                attribute = sign_attribute(s, one.actuator, what)
                fix = f"turn the sign of {attribute}"
                yield s.hit("actuator", one.actuator, message, attribute=attribute, fix=fix)


def undamped_servo(s: InspectedModel) -> Iterator[Hit]:
    m, every = s.model, drives(s)
    for one in (one for one in every if one.holds):
        critical = 2 * np.sqrt(one.stiffness * float(m.dof_M0[one.dof]))
        own = float(m.dof_damping[one.dof])
        own += sum(other.damping for other in every if other.dof == one.dof)
        dry = m.dof_frictionloss[one.dof] or np.any(m.tendon_frictionloss)
        if own >= DAMPED * critical or dry or m.opt.viscosity:
            continue  # most are, which costs nothing to see
        ratio = damping_of(s, one.dof) / critical
        if ratio < DAMPED:
            message = (
                f"it holds {one.where} with a damping ratio of {ratio:.2g}: a disturbance rings "
                "for tens of periods"
            )
            yield s.hit("actuator", one.actuator, message)


def two_servos(s: InspectedModel) -> Iterator[Hit]:
    m, seen = s.model, dict[tuple[str, int], str]()
    idle = (m.actuator_ctrllimited != 0) & np.any(m.actuator_ctrlrange == 0, 1)
    wrong = {
        "hold": "with different controls they work against each other",
        "drive": "their forces add",
    }
    for what in wrong:
        for one in drives(s):
            if one.holds if what == "hold" else one.motor and not idle[one.actuator]:
                first = seen.setdefault((what, one.joint), one.name)
                if first != one.name:
                    message = f"it and {first} both {what} {one.where}: {wrong[what]}"
                    yield s.hit("actuator", one.actuator, message)


def light_joint(s: InspectedModel) -> Iterator[Hit]:
    for one in drives(s):
        force, inertia = max(-one.low, one.high), float(s.model.dof_M0[one.dof])
        way, hinge = force / inertia * s.timestep**2, one.unit == "rad"
        if np.inf > way > (TURN_IN_A_STEP if hinge else s.facts.size):
            what = (
                f"inertia of {inertia:.3g} kg m^2 is turned"
                if hinge
                else f"mass of {inertia:.3g} kg is moved"
            )
            message = (
                f"its {what} by {way:.3g} {one.unit} in the first step of {s.timestep:g} s under "
                f"the full force of {one.name}, {force:.3g} {one.unit_of_force}"
                f"{'' if hinge else f': the model has {s.facts.size:.3g} m'}"
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
    m, kind = s.model, s.loaded.of_kind
    first = m.jnt_qposadr + 3 * kind("jnt_type", "free")
    turning = np.flatnonzero(kind("jnt_type", "free", "ball"))
    places = [("qpos", m.nq, int(first[i]), s.loaded.name("joint", i)) for i in turning]
    places += [
        ("mquat", 4 * m.nmocap, 4 * int(m.body_mocapid[i]), s.loaded.name("body", i))
        for i in np.flatnonzero(m.body_mocapid >= 0)
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
    """Forces in a keyframe, of each degree of freedom (nv,).

    Attributes
    ----------
    force, left : array (nv,)
        Of the actuators, and what is left over.
    control : array (nu,)
    arms : array (nu, nv)
        Moment arms of the actuators.
    free : array (nv,)
        Whether it falls freely.
    undriven : array (nv,)
        The most that is left over in its tree at a joint that is neither free nor driven.
    """

    force: Array
    left: Array
    control: Array
    arms: Array
    free: Flags
    undriven: Array

    @property
    def needs(self) -> Array:
        """The forces (nv,) of actuators that would hold each degree of freedom."""
        same = np.isclose(self.force, self.left, rtol=1e-12, atol=0.0)
        return np.where(same, 0.0, self.force - self.left)

    @property
    def falls(self) -> Flags:
        """Whether nothing is held about each degree of freedom (nv,)."""
        return np.asarray(self.free | (self.undriven > LOOSE * np.abs(self.needs)))


def balance_of(s: InspectedModel, state: State, unlimited: Flags | None = None) -> KeyframeForces:
    """Return the forces in a keyframe, those of some actuators (nu,) without their limits."""
    m, model = s.model, s.loaded.sharp()
    if unlimited is not None:
        model.actuator_forcelimited[unlimited] = 0
        model.jnt_actfrclimited[:], model.tendon_actfrclimited[:] = 0, 0
    data, left = s.loaded.data(state, model), np.empty(m.nv)
    s.loaded.mujoco.mj_forward(model, data)
    s.loaded.mujoco.mj_mulM(model, data, left, data.qacc)
    free, gravity = s.loaded.of_kind("jnt_type", "free"), np.linalg.norm(s.facts.options.gravity)
    first = m.jnt_dofadr[free]
    falls = [i for i in first if np.linalg.norm(data.qacc[i : i + 3]) > FALLING * gravity]
    arms = moments(s.loaded, state)
    bound = np.any(arms, axis=0) | free[m.dof_jntid]
    most = np.zeros(m.ntree)
    np.maximum.at(most, m.dof_treeid, np.where(bound, 0.0, np.abs(left)))
    falling = np.isin(m.dof_treeid, m.dof_treeid[falls])
    force, control = np.array(data.qfrc_actuator), np.array(data.ctrl)
    return KeyframeForces(force, left, control, arms, falling, most[m.dof_treeid])


def saturated_actuator(s: InspectedModel) -> Iterator[Hit]:
    said = set[int]()
    for state in keyframes(s):
        balance = balance_of(s, state)
        alone = ~balance.falls & (np.count_nonzero(balance.arms, axis=0) == 1)
        for one in drives(s):
            need = float(balance.needs[one.dof])
            room = OVERLOAD * abs(need)
            within = one.low - room <= need <= one.high + room
            if one.actuator in said or not alone[one.dof] or within:
                continue
            said.add(one.actuator)
            unit = one.unit_of_force
            message = (
                f"in the state {state.name!r} {one.where} takes {need:.4g} {unit} to stay, and its "
                f"limits are {one.low:.4g} to {one.high:.4g} {unit}"
            )
            yield s.hit("actuator", one.actuator, message)


def control_not_holding(s: InspectedModel) -> Iterator[Hit]:
    """Find keyframes that their own controls leave.

    A servo moves its joint to where its control asks, however weak it is: its force counts without
    limits. Where a joint falls, a servo counts if it gives all its force, and without a load.
    """
    said = set[int]()
    for state in keyframes(s):
        limited, balance = balance_of(s, state), balance_of(s, state, pulls_to_control(s))
        full, falls = limited.force != balance.force, limited.falls
        left = np.where(falls, balance.force, balance.left)
        for joint, how in (
            *simple_joints_left(s, limited, left),
            *ball_joints_left(s, balance.arms, left),
        ):
            dof = int(s.model.jnt_dofadr[joint])
            if (full[dof] or not falls[dof]) and joint not in said:
                said.add(joint)
                message = f"the controls of the state {state.name!r} do not hold it: {how}"
                yield s.hit("joint", joint, message)


def simple_joints_left(
    s: InspectedModel, limited: KeyframeForces, unlimited: Array
) -> Iterator[tuple[int, str]]:
    """Yield the hinges and slides that leave a keyframe, and how.

    ``unlimited`` (nv,) is what servos without limits leave over.
    """
    for one in drives(s):
        left, force = float(limited.left[one.dof]), float(limited.force[one.dof])
        if one.holds:
            drift = float(unlimited[one.dof]) / one.stiffness
            if abs(drift) > (DRIFT if one.unit == "rad" else SHIFT * s.facts.size):
                yield one.joint, f"{one.name} gives way by about {drift:.3g} {one.unit}"
        elif one.motor and limited.control[one.actuator] and abs(left) > OFF * abs(force):
            need = f"{limited.needs[one.dof]:.3g} would hold it"
            yield one.joint, f"{one.name} gives {force:.3g} {one.unit_of_force}, and {need}"


def ball_joints_left(s: InspectedModel, arms: Array, left: Array) -> Iterator[tuple[int, str]]:
    """Yield the ball joints that leave a keyframe, about the axes on which they have servos."""
    m, kind = s.model, s.loaded.of_kind
    acts = pulls_to_control(s) & kind("actuator_trntype", "joint", "jointinparent")
    for joint in np.flatnonzero(kind("jnt_type", "ball")):
        own = np.flatnonzero(acts & (m.actuator_trnid[:, 0] == joint))
        dofs = slice(int(m.jnt_dofadr[joint]), int(m.jnt_dofadr[joint]) + 3)
        stiffness = -(arms[own, dofs].T * m.actuator_biasprm[own, 1]) @ arms[own, dofs]
        turn = float(np.linalg.norm(np.linalg.pinv(stiffness) @ left[dofs]))
        if turn > DRIFT:
            names = ", ".join(s.loaded.name("actuator", i) for i in own)
            yield int(joint), f"{names} give way by about {turn:.3g} rad"
