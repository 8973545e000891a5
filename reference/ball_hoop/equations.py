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

The quaternion may have any length, see `..body.rotation`. Without d, r and
F (1)-(3) are Lagrange's equations of

    L = (M + m) y'^2 / 2 + y' h . omega + omega^T J omega / 2 + mu rho^2 / 2
        - k y^2 / 2 + (M + m) g_y y + s . (R^T g)                                     (4)

The slide's guide can put no torque on the body about the line along which O moves: the angular
momentum about it changes by gravity across the slide and by friction in the joint alone, whatever
drives and damps the slide.
"""

from __future__ import annotations

from collections import namedtuple
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..body.parameters import NUMBERS, BodyParameters, body_inertia, body_numbers
from ..body.rotation import (
    Moment,
    accelerations_by,
    body_rates,
    euler,
    inner,
    momentum_of,
    rest_attitude,
    rotation_columns,
    rotation_energy,
    rotation_forces,
    rotation_mass_matrix,
    rotation_outputs,
    sum_of,
    times,
)
from ..errors import NoOrbitError
from ..parameters import quantity
from ..quaternions import cross, matrix, square
from ..scene import Array


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


def coefficients(p: BallHoop) -> Any:
    """Return the numbers of (1)-(4)."""
    return coefficients_of(p, body_inertia(p))


def coefficients_of(p: BallHoop, tensor: Array) -> Any:
    """Return these numbers of an inertia tensor (3, 3, ...) about the ball joint."""
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
    block = rotation_mass_matrix(q[TURN], c)
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
