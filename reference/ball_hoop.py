r"""ball_hoop: the sprung main mass of `hula_hoop` with a rigid body on a ball joint.

::

      |\/\/\/|  k          /  m, J   x_C = y e_y + R c
    --|      |----[ M ]---O          q: from the frame of the body to that of the world
      |=[ ]==|  d    \               omega: angular velocity in the frame of the body
                      ---> y, driven by F cos(2 pi f t)

Source: a textbook example on the mechanism of Lu, Wang, Sung, Chao (2011), J. Vib. Acoust. 133,
014501, whose hinge is a ball joint here and whose rod has an inertia tensor. The slide is along y.
O is the ball joint, whose friction is -r omega; c, s = m c and J are the centre of mass, its moment
and the inertia tensor about O in the frame of the body, g is gravity in the world. With the slide's
direction b = R^T e_y and the lever h = s x b

    (M + m) y'' + h . omega' = F cos(2 pi f t) - d y' - k y + (M + m) g_y
                               - b . (omega x (omega x s))                            (1)
    h y'' + J omega' = s x (R^T g) - omega x (J omega) - r omega                      (2)
    q' = q (0, omega) / 2                                                             (3)

The quaternion may have any length, see `.body.rotation`. Without d, r and
F (1)-(3) are Lagrange's equations of

    L = (M + m) y'^2 / 2 + y' h . omega + omega^T J omega / 2 + mu rho^2 / 2
        - k y^2 / 2 + (M + m) g_y y + s . (R^T g)                                     (4)

The slide's guide can put no torque on the body about the line along which O moves: the angular
momentum about it changes by gravity across the slide and by friction in the joint alone, whatever
drives and damps the slide.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .body.mistakes import with_mistakes
from .body.rotation import (
    COORDINATES,
    NUMBERS,
    QUATERNION,
    RATES,
    ROTATION,
    UNITS,
    BodyAccelerations,
    BodyParameters,
    Moment,
    accelerations_by,
    body_numbers,
    body_rates,
    euler,
    inexact_accelerations,
    inexact_numbers,
    inner,
    momentum_of,
    rest_attitude,
    rotation_columns,
    rotation_energy,
    rotation_forces,
    rotation_outputs,
    sum_of,
    times,
    turned_inertia,
)
from .errors import NoOrbitError
from .hula_hoop import SCENE as HULA_HOOP
from .parameters import quantity
from .quaternions import cross, matrix, square
from .scene import Array, Scene, case_maker, with_placements, with_rates


@dataclass(frozen=True)
class BallHoop(BodyParameters):
    """Parameters of `ball_hoop` (SI units)."""

    main_mass: float = quantity(2.0, "M", "kg", "chosen", "sprung main mass")
    stiffness: float = quantity(2000.0, "k", "N/m", "chosen", "spring of the main mass")
    damping: float = quantity(15.0, "d", "N s/m", "chosen", "of the main mass", "non-negative")
    joint_damping: float = quantity(
        0.005, "r", "N m s", "chosen", "of the ball joint", "non-negative"
    )
    force_amplitude: float = quantity(
        60.0, "F", "N", "chosen", "amplitude of the force on M", "non-negative"
    )
    force_frequency: float = quantity(3.0, "f", "Hz", "chosen", "of the force")


OTHERS = ("mass", "stiffness", "damping", "friction", "force", "omega")
Coefficients: Any = namedtuple("Coefficients", (*NUMBERS, *OTHERS))  # type: ignore[misc]
"""Numbers of (1)-(4): those of `body_numbers`, then M + m, k, d, r, F, 2 pi f."""


def coefficients(p: BallHoop, tensor: Array | None = None) -> Any:
    """Return the numbers of the equations; the inertia tensor (3, 3, ...) may be another."""
    drive = (p.force_amplitude, 2 * np.pi * p.force_frequency)
    slide = [p.main_mass + p.mass, p.stiffness, p.damping, p.joint_damping, *drive]
    return Coefficients(*(body_numbers(p, tensor) + slide))


FIRST = 1
"""Place of the quaternion among the coordinates."""

TURN = slice(FIRST, FIRST + 4)


def slide_axis(q: Any) -> list[Any]:
    """Return b, the slide's direction in the frame of the body."""
    return matrix(q[TURN])[1]


def slide_force(u: Any, q: Any, v: Any, c: Any) -> Any:
    """Return drive, damper, spring and weight on the slide."""
    return c.force * u - c.damping * v[0] - c.stiffness * q[0] + c.mass * c.g_y


def centripetal(omega: Any, c: Any) -> list[Any]:
    """Return omega x (omega x s)."""
    return cross(omega, cross(omega, c[0:3]))


def mass_matrix(q: Any, c: Any, xp: Any = np) -> list[list[Any]]:
    """Return the mass matrix of (4)."""
    lever, size = cross(c[0:3], slide_axis(q)), square(q[TURN])
    mixed = [2 * inner(column, lever) / size for column in rotation_columns(q[TURN])]
    block = turned_inertia(q[TURN], c[3:9], c[18])
    return [
        [c.mass, *mixed],
        *([side, *row] for side, row in zip(mixed, block, strict=True)),
    ]


def forces(u: Any, q: Any, v: Any, c: Any, xp: Any = np) -> list[Any]:
    """Return the right-hand side of ``M(q) a = f``."""
    axis = slide_axis(q)
    rho, omega = body_rates(q[TURN], v[TURN])
    growth = 2 * rho * inner(cross(c[0:3], axis), omega)
    push = slide_force(u, q, v, c) - inner(axis, centripetal(omega, c)) + growth
    return [push, *rotation_forces(q[TURN], v[TURN], c, braked_by(euler))]


def braked_by(moment: Moment) -> Moment:
    """Return a moment with that of the friction in the joint."""

    def braked(q: Any, omega: Any, momentum: Any, c: Any) -> list[Any]:
        return sum_of(moment(q, omega, momentum, c), omega, -c.friction)

    return braked


def joined(push: Any, lever: list[Any], moment: list[Any], c: Any) -> list[Any]:
    """Return y'' and omega' of (1), (2) with these right-hand sides and this lever h."""
    free, pushed = times(c[9:15], moment), times(c[9:15], lever)
    faster = (push - inner(lever, free)) / (c.mass - inner(lever, pushed))
    return [faster, *(a - faster * b for a, b in zip(free, pushed, strict=True))]


def body_accelerations(u: Any, motion: Any, c: Any, moment: Moment, xp: Any = np) -> list[Any]:
    """Return y'' and omega' by (1), (2)."""
    q, v, omega = motion
    axis = slide_axis(q)
    push = slide_force(u, q, v, c) - inner(axis, centripetal(omega, c))
    turning = braked_by(moment)(q[TURN], omega, times(c[3:9], omega), c)
    return joined(push, cross(c[0:3], axis), turning, c)


accelerations = accelerations_by(body_accelerations, FIRST)


def damping_matrix(c: Any) -> Array:
    """Return diag(d, 0, 4 r, 4 r, 4 r): friction in the joint depends on q, here upright."""
    return np.diag([c.damping, 0.0, *[4 * c.friction] * 3])


def energy(q: Any, v: Any, c: Any) -> Any:
    """Return kinetic and potential energy [J], that of the length of q included."""
    lever = cross(c[0:3], slide_axis(q))
    sliding = (c.mass * v[0] ** 2 + c.stiffness * q[0] ** 2) / 2 - c.mass * c.g_y * q[0]
    shared = v[0] * inner(lever, body_rates(q[TURN], v[TURN])[1])
    return sliding + shared + rotation_energy(q[TURN], v[TURN], c)


def powers(u: Any, q: Any, v: Any, c: Any) -> dict[str, Any]:
    """Return the powers [W] of the force, of the damper and of the joint's friction."""
    omega = body_rates(q[TURN], v[TURN])[1]
    return {
        "force": c.force * u * v[0],
        "damper": -c.damping * v[0] ** 2,
        "friction": -c.friction * inner(omega, omega),
    }


def along_slide(q: Any, v: Any, c: Any) -> Any:
    """Return the angular momentum about the line along which the ball joint moves."""
    return momentum_of(q[TURN], v[TURN], c)[1]


def outputs(q: Any, v: Any, c: Any, xp: Any = np) -> dict[str, Any]:
    """Return attitude, body rates, energy, length of q, and angular momentum about O."""
    arm = [inner(row, c[0:3]) for row in matrix(q[TURN])]
    x, y, z = momentum_of(q[TURN], v[TURN], c)
    momentum = [x - arm[2] * v[0], y, z + arm[0] * v[0]]
    return rotation_outputs(q[TURN], v[TURN], momentum, energy(q, v, c), xp)


def sagging(p: BallHoop) -> float:
    """Return where weights hold the main mass at rest [m]."""
    return float((p.main_mass + p.mass) * p.gravity_y / p.stiffness)


def rest(p: BallHoop, sign: float) -> dict[str, float]:
    """Return the state of rest in which the body hangs (sign 1), or stands (-1)."""
    if not np.any(p.gravity) or not np.any(p.centre):
        raise NoOrbitError("no torque of gravity turns the body of ball_hoop: ask for weightless")
    return {"y": sagging(p), **rest_attitude(p, sign)}


def weightless(p: BallHoop) -> dict[str, float]:
    """Return one of the states of rest without a torque of gravity: any attitude is one.

    Raises
    ------
    NoOrbitError
        If there is a torque of gravity.
    """
    if np.any(p.gravity) and np.any(p.centre):
        raise NoOrbitError("gravity turns the body of ball_hoop: it hangs, or it is inverted")
    return {"y": sagging(p)}


def coupled_by(axis_in_body: bool, inertia: float, pull: float, transport: float) -> Any:
    """Return `body_accelerations` with the factors 1, 1 and 0 changed, or another axis."""

    def accelerate(u: Any, motion: Any, c: Any, moment: Moment, xp: Any) -> list[Any]:
        q, v, omega = motion
        axis = [0.0, 1.0, 0.0] if axis_in_body else slide_axis(q)
        push = slide_force(u, q, v, c) - pull * inner(axis, centripetal(omega, c))
        lever = [inertia * part for part in cross(c[0:3], axis)]
        turning = braked_by(moment)(q[TURN], omega, times(c[3:9], omega), c)
        convected = cross(axis, cross(omega, c[0:3]))
        return joined(push, lever, sum_of(turning, convected, transport * v[0]), c)

    return accelerate


COUPLINGS: dict[str, BodyAccelerations] = {
    "the inertia that couples slide and ball joint is lost": coupled_by(False, 0.0, 1.0, 0.0),
    "the turning body does not pull at the slide": coupled_by(False, 1.0, 0.0, 0.0),
    "the slide's direction is taken in the frame of the body": coupled_by(True, 1.0, 1.0, 0.0),
    "the moment about the moving joint lacks v x p": coupled_by(False, 1.0, 1.0, 1.0),
}


def invariants(p: BallHoop) -> Mapping[str, Callable[..., Any]]:
    """Return the energy without dampers, and the angular momentum that gravity leaves.

    The latter without friction in the joint, also while a force drives the slide.
    """
    known: dict[str, Callable[..., Any]] = {}
    if not np.any(p.damping) and not np.any(p.joint_damping):
        known["energy"] = energy
    if not np.any(p.gravity[[0, 2]]) and not np.any(p.joint_damping):
        known["momentum"] = along_slide
    return known


WEIGHED = BallHoop(gravity_x=3.0, gravity_y=-5.0, gravity_z=-7.0)
CONSERVATIVE = WEIGHED.replace(damping=0.0, joint_damping=0.0, force_amplitude=0.0)
ALONG = CONSERVATIVE.replace(gravity_x=0.0, gravity_z=0.0)
FREELY = BallHoop(joint_damping=0.0)
PLANAR = BallHoop(
    mass=0.45, centre_x=0.15, centre_y=0.0, centre_z=0.0, axes_x=0.0, axes_y=0.0, axes_z=0.0
)
"""Turns about z for ever where it does so at the start, as the rod of `hula_hoop` does."""

SPINNING = {
    "y": 0.02, "q_w": 0.9, "q_x": 0.3, "q_y": -0.3, "q_z": 0.1,
    "omega_x": 5.0, "omega_y": -4.0, "omega_z": 8.0,
}  # fmt: skip


case = case_maker("ball_hoop")

CASES = (
    case("weighed", WEIGHED, SPINNING, 0.25, "algebra", "trajectory", methods="best"),
    case("hanging", WEIGHED, {}, 0.5, "frequency", about="hanging"),
    case("driven", FREELY, SPINNING, 0.5, "order", "trajectory", "energy", full_only=True),
    case("conservative", CONSERVATIVE, SPINNING, 0.5, "energy", full_only=True),
    case("gravity_along", ALONG, SPINNING, 2.0, "trajectory", "energy", full_only=True),
    case("planar", PLANAR, {"omega_z": 18.0}, 0.5, "trajectory", "order", full_only=True),
)
"""The *energy* check of `driven` examines the angular momentum about the slide alone."""

SCENE = Scene(
    name="ball_hoop",
    title="rigid body on a ball joint that a sprung mass drives",
    paper=HULA_HOOP.paper,
    parameters=BallHoop,
    coordinates=("y", *COORDINATES),
    quaternions=(QUATERNION,),
    units=with_rates(y="m", **dict.fromkeys(COORDINATES, "1")) | UNITS,
    coefficients=coefficients,
    inexact_numbers=inexact_numbers,
    inexact_accelerations=lambda change: inexact_accelerations(body_accelerations, FIRST, change),
    drive=HULA_HOOP.drive,
    drive_form="force on y: F cos(2 pi f t), largest at t = 0, whenever a run starts",
    mass_matrix=mass_matrix,
    forces=forces,
    accelerations=accelerations,
    damping_matrix=damping_matrix,
    energy=energy,
    powers=powers,
    outputs=outputs,
    observed=(*ROTATION, *RATES),
    equilibria={
        "hanging": lambda p: rest(p, 1.0),
        "inverted": lambda p: rest(p, -1.0),
        "weightless": weightless,
    },
    period=HULA_HOOP.period,
    unforced=lambda p: p.replace(force_amplitude=0.0),
    invariants=invariants,
    cases=CASES,
    placed=with_placements(CASES[0], "algebra")[:1],  # a mirror has other quaternions
)

SCENE = replace(
    SCENE,
    mistakes={
        **with_mistakes(SCENE, body_accelerations, coefficients),
        **{
            words: replace(SCENE, accelerations=accelerations_by(accelerate, FIRST), cases=())
            for words, accelerate in COUPLINGS.items()
        },
    },
)
