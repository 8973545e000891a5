"""Rules about the drives of a model: actuators, their ranges, and the joints that they move."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from ....reference.scene import Array
from ..mujoco.model import OPENED, Flags, State, numbers
from ..subject import Hit, InspectedModel
from ..tuning import EFFORT, NUMERICS, THRESHOLDS
from .parts import gears
from .remedies import moments


class Drive(NamedTuple):
    """An actuator of one hinge or slide: directly, or by a fixed tendon over that joint alone.

    Attributes
    ----------
    actuator, joint, dof : int
    name, where : str
        Names of the actuator and of its joint.
    gear : float
        Length of the actuator per unit of the joint's coordinate, not 0.
    stiffness, damping : float
        Stiffness and damping with which it resists motion of the joint.
    holds, motor : bool
        True if its control is a position, or a force.
    low, high : float
        Least and largest force on the joint; -inf and inf without limits.
    unit, unit_of_force : str
        Units of the joint's coordinate, and of its force.
    ends : tuple of float
        Range of the joint, infinite without limits.
    servo_drift : float
        Displacement up to which a servo keeps the joint in its place.
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
    ends: tuple[float, float]
    servo_drift: float


def drives(s: InspectedModel) -> list[Drive]:
    """Return the actuators of single hinges and slides."""
    m, kind, tendons = s.model, s.loaded.of_kind, tendons_of_one_joint(s)
    simple, hinges = kind("jnt_type", "hinge", "slide"), kind("jnt_type", "hinge")
    direct, pulled = (
        kind("actuator_trntype", "joint", "jointinparent"),
        kind("actuator_trntype", "tendon"),
    )
    affine, holds = kind("actuator_biastype", "affine"), pulls_to_control(s)
    controls = s.loaded.first_of("ctrl")
    motor = kind("actuator_gaintype", "fixed") & kind("actuator_biastype", "none")
    motor &= kind("actuator_dyntype", "none")  # its force is proportional to its control
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
                motor[i] & m.actuator_ctrllimited[controls[i]],
                m.actuator_ctrlrange[controls[i]],
                gear * m.actuator_gainprm[i, 0],
            ),
            (m.jnt_actfrclimited[joint], m.jnt_actfrcrange[joint], 1.0),
        ]
        if pulled[i]:
            limits.append((m.tendon_actfrclimited[target], m.tendon_actfrcrange[target], factor))
        low, high = narrowest(limits)
        _, position, speed = (m.actuator_biasprm[i, :3] * affine[i]).tolist()
        listed.append(
            Drive(
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
                ends=tuple(narrowest([(m.jnt_limited[joint], m.jnt_range[joint], 1.0)]).tolist()),
                servo_drift=THRESHOLDS.servo_drift * (1.0 if hinges[joint] else s.size),
            )
        )
    return listed


def narrowest(limits: Iterable[tuple[Any, Any, float]]) -> Array:
    """Return the intersection (2,) of ranges: each is a flag that it counts, ends, and a factor."""
    ends = np.array([-np.inf, np.inf])
    for limited, bounds, factor in limits:
        if limited:
            ends = np.clip(ends, *np.sort(np.asarray(bounds) * factor))
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
    """Return the attribute with the reaction of an actuator to ``position`` or ``speed``."""
    element = s.loaded.places.get(("actuator", actuator))
    tag = element.tag if element else "general"
    if tag in ("position", "velocity", "intvelocity"):
        return "kp" if what == "position" else "kv"
    return "bias" if tag == "cylinder" else "biasprm"


def pulls_to_control(s: InspectedModel) -> Flags:
    """Return the actuators (nu,) whose control is a position: gain and stiffness are equal."""
    m, kind = s.model, s.loaded.of_kind
    stiffness = -m.actuator_biasprm[:, 1]
    alike = (stiffness > 0) & np.isclose(m.actuator_gainprm[:, 0], stiffness)
    affine, plain = kind("actuator_biastype", "affine"), kind("actuator_gaintype", "fixed")
    return np.asarray(alike & affine & plain)


class CommandRange(NamedTuple):
    """A servo, and the range of positions that its control may command.

    ``attribute`` is the range of the actuator, ``bounds`` (2,) that of the joint and tendons over
    it alone, if there is any; ``degrees`` is True if the numbers look like degrees.
    """

    drive: Drive
    attribute: str
    low: float
    high: float
    bounds: Array | None
    degrees: bool

    def fix(self, ends: Sequence[float] | Array) -> str:
        """Return the attribute for other ends (2,) of the joint's coordinate."""
        low, high = np.sort(np.asarray(ends) * self.drive.gear)
        return f'write {self.attribute}="{low:.6g} {high:.6g}" on the actuator'

    @property
    def exceeds_joint(self) -> bool:
        """True if a hinge is commanded beyond its range; slides of grippers press on purpose."""
        if self.bounds is None or self.drive.unit != "rad" or self.degrees:
            return False
        least, most = self.bounds
        room = THRESHOLDS.control_excess * (most - least) * (1 + 1e-9)
        return bool(max(least - self.low, self.high - most) > room)


def command_ranges(s: InspectedModel) -> Iterator[CommandRange]:
    """Yield the position servos whose commands are limited to a range.

    The control of an integrating servo is a speed; its activation is the position.
    """
    m, integrates = s.model, s.loaded.of_kind("actuator_dyntype", "integrator")
    controls = s.loaded.first_of("ctrl")
    for one in drives(s):
        name, row = "ctrl", controls[one.actuator]
        if integrates[one.actuator]:
            name, row = "act", one.actuator
        limited, ends = (getattr(m, f"actuator_{name}{what}")[row] for what in ("limited", "range"))
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
            degrees = bool(one.unit == "rad" and wide and most > THRESHOLDS.max_turn)
            yield CommandRange(one, f"{name}range", low, high, bounds, degrees)


def damping_of(s: InspectedModel, dof: int) -> float:
    """Return the largest damping of a degree of freedom in the states of the file.

    It is the difference of passive and actuator forces, without limits, over that of the speed, and
    includes joints, tendons, actuators of any kind and fluids.
    """
    lib, model = s.loaded.mujoco, s.loaded.sharp()
    for limited in ("actuator_forcelimited", "jnt_actfrclimited", "tendon_actfrclimited"):
        getattr(model, limited)[:] = 0
    values, most = [0.0], NUMERICS.probe_speed
    for state in s.loaded.states[: EFFORT.max_states]:
        forces = []
        for speed in (most, -most):
            data = s.loaded.data(state, model)
            data.qvel[:] = 0
            data.qvel[dof] = speed
            lib.mj_forward(model, data)
            forces.append(float(data.qfrc_passive[dof] + data.qfrc_actuator[dof]))
        values.append((forces[1] - forces[0]) / (2 * most))
    return max(values)


# Rules ----------------------------------------------------------------------------------------


def control_in_degrees(s: InspectedModel) -> Iterator[Hit]:
    for one in command_ranges(s):
        if one.degrees:
            yield s.hit(
                "actuator",
                one.drive.actuator,
                f"its {one.attribute} of {one.low:g} to {one.high:g} rad is up to "
                f"{max(-one.low, one.high) / (2 * np.pi):.3g} turns of {one.drive.where}: controls "
                "are in radians, whatever the compiler's angle",
                attribute=one.attribute,
                fix=one.fix(np.deg2rad([one.low, one.high])),
            )


def control_beyond_range(s: InspectedModel) -> Iterator[Hit]:
    for one in command_ranges(s):
        if one.bounds is not None and one.exceeds_joint:
            least, most = one.bounds
            yield s.hit(
                "actuator",
                one.drive.actuator,
                f"its {one.attribute} commands {one.drive.where} to {one.low:.4g} to "
                f"{one.high:.4g}, beyond the joint's range of {least:.4g} to {most:.4g}: it pushes "
                "into the limit",
                attribute=one.attribute,
                fix=one.fix(one.bounds),
            )


def unlimited_joint(s: InspectedModel) -> Iterator[Hit]:
    for one in command_ranges(s):
        if one.bounds is None and not one.degrees:
            yield s.hit(
                "joint",
                one.drive.joint,
                f"it has no limit, and {one.drive.name} moves it from {one.low:.4g} to "
                f"{one.high:.4g}: a load can carry it beyond",
            )


def positive_feedback(s: InspectedModel) -> Iterator[Hit]:
    for one in drives(s):
        for what, resists in (("position", one.stiffness), ("speed", one.damping)):
            if resists < 0:
                attribute = sign_attribute(s, one.actuator, what)
                yield s.hit(
                    "actuator",
                    one.actuator,
                    f"its force grows with the {what} of {one.where}, by {-resists:.4g} per unit: "
                    "it amplifies motion that it should resist",
                    attribute=attribute,
                    fix=f"reverse the sign of {attribute}",
                )


def undamped_servo(s: InspectedModel) -> Iterator[Hit]:
    m, every = s.model, drives(s)
    for one in (one for one in every if one.holds):
        critical = 2 * np.sqrt(one.stiffness * float(m.dof_M0[one.dof]))
        own = float(m.dof_damping[one.dof])
        own += sum(other.damping for other in every if other.dof == one.dof)
        dry = m.dof_frictionloss[one.dof] or np.any(m.tendon_frictionloss)
        if own >= THRESHOLDS.min_damping_ratio * critical or dry or m.opt.viscosity:
            continue  # damped, as most are: no need of the dearer measurement
        ratio = damping_of(s, one.dof) / critical
        if ratio < THRESHOLDS.min_damping_ratio:
            words = "a disturbance rings for tens of periods"
            message = f"its damping ratio at {one.where} is {ratio:.2g}: {words}"
            yield s.hit("actuator", one.actuator, message)


def two_servos(s: InspectedModel) -> Iterator[Hit]:
    m, seen = s.model, dict[tuple[str, int], str]()
    controls = s.loaded.first_of("ctrl")
    idle = (m.actuator_ctrllimited != 0)[controls] & np.any(m.actuator_ctrlrange == 0, 1)[controls]
    for words, acts in (
        ("position {}: with different controls they work against each other", lambda x: x.holds),
        ("drive {}: their forces add", lambda x: x.motor and not idle[x.actuator]),
    ):
        for one in filter(acts, drives(s)):
            first = seen.setdefault((words, one.joint), one.name)
            if first != one.name:
                message = f"it and {first} both {words.format(one.where)}"
                yield s.hit("actuator", one.actuator, message)


def light_joint(s: InspectedModel) -> Iterator[Hit]:
    for one in drives(s):
        force, inertia = max(-one.low, one.high), float(s.model.dof_M0[one.dof])
        way, hinge = force / inertia * s.timestep**2, one.unit == "rad"
        if np.inf > way > (THRESHOLDS.max_turn_in_step if hinge else s.size):
            moved = f"inertia of {inertia:.3g} kg m^2 turns" if hinge else ""
            moved = moved or f"mass of {inertia:.3g} kg moves"
            yield s.hit(
                "joint",
                one.joint,
                f"its {moved} by {way:.3g} {one.unit} in the first step of {s.timestep:g} s under "
                f"the full force of {one.name}, {force:.3g} {one.unit_of_force}"
                f"{'' if hinge else f': the size of the model is {s.size:.3g} m'}",
            )


def spring_beyond_range(s: InspectedModel) -> Iterator[Hit]:
    m = s.model
    rests, (low, high) = m.qpos_spring[m.jnt_qposadr], m.jnt_range.T
    slack = 1e-6 * (high - low)
    return s.hits(
        "joint",
        s.loaded.limited_joints
        & (m.jnt_stiffness != 0)
        & ((rests < low - slack) | (rests > high + slack)),
        lambda i: (
            f"its spring rests at {rests[i]:.4g}, beyond its range of {low[i]:.4g} to "
            f"{high[i]:.4g}: it presses against its limit"
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
            if abs(norm - 1) > THRESHOLDS.quaternion_norm:
                message = (
                    f"the quaternion of {name} has a norm of {norm:.4g}; MuJoCo silently uses "
                    f"{'no rotation' if norm == 0 else 'its direction'}"
                )
                yield Hit(key, key.address, message, attribute=attribute)


def rests(s: InspectedModel) -> Iterator[State]:
    """Yield the states at rest of models with actuators."""
    for view in s.views:
        if not np.any(view.state.velocity) and view.steady_hinge is None and s.model.nu:
            yield view.state


class KeyframeForces(NamedTuple):
    """Forces on each degree of freedom (nv,) in a keyframe.

    Attributes
    ----------
    force, left : array (nv,)
        Forces of the actuators, and the unbalanced ones.
    control : array (nu,)
    arms : array (nu, nv)
        Moment arms of the actuators.
    needs : array (nv,)
        Forces of actuators that would balance each degree of freedom.
    falls : array (nv,)
        True if it falls, so that no balance is to be expected.
    """

    force: Array
    left: Array
    control: Array
    arms: Array
    needs: Array
    falls: Flags


def balance_of(s: InspectedModel, state: State, unlimited: Flags | None = None) -> KeyframeForces:
    """Return the forces in a keyframe; actuators ``unlimited`` (nu,) count without limits."""
    m, model = s.model, s.loaded.sharp()
    if unlimited is not None:
        model.actuator_forcelimited[unlimited] = 0
        model.jnt_actfrclimited[:], model.tendon_actfrclimited[:] = 0, 0
    data, left = s.loaded.data(state, model), np.empty(m.nv)
    s.loaded.mujoco.mj_forward(model, data)
    s.loaded.mujoco.mj_mulM(model, data, left, data.qacc)
    free, gravity = s.loaded.of_kind("jnt_type", "free"), np.linalg.norm(s.options.gravity)
    first = m.jnt_dofadr[free]
    falls = [
        i for i in first if np.linalg.norm(data.qacc[i : i + 3]) > THRESHOLDS.free_fall * gravity
    ]
    arms = moments(s.loaded, state)
    bound = np.any(arms, axis=0) | free[m.dof_jntid]
    most = np.zeros(m.ntree)
    np.maximum.at(most, m.dof_treeid, np.where(bound, 0.0, np.abs(left)))
    falling = np.isin(m.dof_treeid, m.dof_treeid[falls])
    force, control = np.array(data.qfrc_actuator), np.array(data.ctrl)
    same = np.isclose(force, left, rtol=1e-12, atol=0.0)
    needs = np.where(same, 0.0, force - left)
    loose = most[m.dof_treeid] > THRESHOLDS.undriven_imbalance * np.abs(needs)
    return KeyframeForces(force, left, control, arms, needs, np.asarray(falling | loose))


def saturated_actuator(s: InspectedModel) -> Iterator[Hit]:
    said = set[int]()
    for state in rests(s):
        balance = balance_of(s, state)
        alone = ~balance.falls & (np.count_nonzero(balance.arms, axis=0) == 1)
        for one in drives(s):
            need = float(balance.needs[one.dof])
            room = THRESHOLDS.overload * abs(need)
            within = one.low - room <= need <= one.high + room
            stopped = stopped_by_limit(s, one, state, float(balance.left[one.dof]))
            if one.actuator in said or not alone[one.dof] or within or stopped:
                continue
            said.add(one.actuator)
            unit = one.unit_of_force
            yield s.hit(
                "actuator",
                one.actuator,
                f"in the state {state.name!r} {one.where} needs {need:.4g} {unit} to stay, beyond "
                f"its limits of {one.low:.4g} to {one.high:.4g} {unit}",
            )


def control_not_holding(s: InspectedModel) -> Iterator[Hit]:
    """Find states that their own controls do not keep.

    A servo moves its joint to the position of its control, however weak it is: its force counts
    without limits. Where a joint falls, a servo counts at its full force, and without a load. As
    opened, controls are 0: only joints at the position 0 are judged.
    """
    said = set[int]()
    for state in rests(s):
        limited, balance = balance_of(s, state), balance_of(s, state, pulls_to_control(s))
        full, falls = limited.force != balance.force, limited.falls
        left = np.where(falls, balance.force, balance.left)
        for joint, message, fix in (
            *simple_joints_left(s, state, limited, left),
            *ball_joints_left(s, state, balance.arms, left),
        ):
            dof = int(s.model.jnt_dofadr[joint])
            if (full[dof] or not falls[dof]) and joint not in said:
                said.add(joint)
                yield s.hit("joint", joint, message, fix=fix)


LEAVES = "the controls of the state {!r} do not keep it there: {}"
INSIDE = "give the keyframe a ctrl within the range of the joint"

JointLeft = tuple[int, str, str]
"""Number of a joint that leaves a keyframe, a message, and a fix, empty for that of the rule."""


def simple_joints_left(
    s: InspectedModel, state: State, limited: KeyframeForces, unlimited: Array
) -> Iterator[JointLeft]:
    """Yield the hinges and slides that leave a keyframe, or that a servo presses into a limit.

    ``unlimited`` (nv,) are the forces that servos without limits do not balance.
    """
    pressing = {one.drive.actuator for one in command_ranges(s) if one.exceeds_joint}
    for one in drives(s):
        left, force = float(limited.left[one.dof]), float(limited.force[one.dof])
        here, (low, high) = float(state.position[s.model.jnt_qposadr[one.joint]]), one.ends
        if state.keys == (OPENED,) and here:
            continue
        if one.holds:
            target = here + float(unlimited[one.dof]) / one.stiffness
            moves = abs(np.clip(target, low, high) - here) > one.servo_drift
            outside = max(low - target, target - high) > THRESHOLDS.control_excess * (high - low)
            how = (
                f"{one.name} drives it to {target:.3g} {one.unit}, beyond its range of {low:.4g} "
                f"to {high:.4g}"
            )
            if moves and not outside:
                how = f"{one.name} yields by about {target - here:.3g} {one.unit}"
            if moves:
                yield one.joint, LEAVES.format(state.name, how), INSIDE if outside else ""
            elif outside and one.unit == "rad" and one.actuator not in pressing:
                yield one.joint, f"in the state {state.name!r} {how}: it presses there", INSIDE
        elif (
            one.motor
            and limited.control[one.actuator]
            and abs(left) > THRESHOLDS.motor_imbalance * abs(force)
            and not stopped_by_limit(s, one, state, left)
        ):
            how = (
                f"{one.name} exerts {force:.3g} {one.unit_of_force}, and "
                f"{limited.needs[one.dof]:.3g} would balance it"
            )
            yield one.joint, LEAVES.format(state.name, how), ""


def stopped_by_limit(s: InspectedModel, one: Drive, state: State, force: float) -> bool:
    """Return True if a limit stops the motion to which an unbalanced force would lead."""
    here, (low, high) = state.position[s.model.jnt_qposadr[one.joint]], one.ends
    return bool((high - here if force > 0 else here - low) < one.servo_drift)


def ball_joints_left(
    s: InspectedModel, state: State, arms: Array, left: Array
) -> Iterator[JointLeft]:
    """Yield the ball joints that leave a keyframe about axes with servos."""
    m, kind = s.model, s.loaded.of_kind
    acts = pulls_to_control(s) & kind("actuator_trntype", "joint", "jointinparent")
    for joint in np.flatnonzero(kind("jnt_type", "ball")):
        own = np.flatnonzero(acts & (m.actuator_trnid[:, 0] == joint))
        dofs = slice(int(m.jnt_dofadr[joint]), int(m.jnt_dofadr[joint]) + 3)
        stiffness = -(arms[own, dofs].T * m.actuator_biasprm[own, 1]) @ arms[own, dofs]
        turn = float(np.linalg.norm(np.linalg.pinv(stiffness) @ left[dofs]))
        if turn > THRESHOLDS.servo_drift:
            names = ", ".join(s.loaded.name("actuator", i) for i in own)
            how = f"{names} yield by about {turn:.3g} rad"
            yield int(joint), LEAVES.format(state.name, how), ""
