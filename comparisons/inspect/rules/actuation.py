"""What actuators do in single joints: which way they pull, how far, how hard, and what damps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ....reference.scene import Array
from ..mujoco.model import Flags
from ..subject import InspectedModel
from .parts import gears

SPEED = 0.1
"""Speed [rad/s, m/s] at which the damping of a joint is read, either way."""

MOST_STATES = 8
"""States in which it is."""


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
