r"""rigid_body: a rigid body on a ball joint, under gravity.

::

              z   / e (body)      q: from the frame of the body to that of the world
              |  /    C           omega: angular velocity in the frame of the body
              | /   /             C: centre of mass, at c in the frame of the body
              |/  /               s = m c, J: inertia tensor about O in the frame of the body
        ------O------ y           g: gravity in the world
             /|
            x                     J omega' = s x (R^T g) - omega x (J omega)          (1)
                                  q' = q (0, omega) / 2                               (2)

Source: a textbook example: Landau, Lifshitz, Mechanics, 3rd edition (1976), sections 32, 35-37;
Goldstein, Poole, Safko, Classical Mechanics, 3rd edition (2002), chapters 4 and 5; Whittaker, A
Treatise on the Analytical Dynamics of Particles and Rigid Bodies, 4th edition (1937), chapter 6.

The coordinates are the quaternion q = (w, x, y, z), whose length may be any, see `.body.rotation`:
Lagrange's equations of

    L = omega^T J omega / 2 + mu rho^2 / 2 + s . (R(q)^T g)                           (3)

with q^-1 q' = (rho, omega / 2) are (1), (2) and rho' = 0.
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
    BodyParameters,
    Moment,
    accelerations_by,
    body_inertia,
    body_numbers,
    body_rates,
    inexact_accelerations,
    inexact_numbers,
    momentum_of,
    rest_attitude,
    rotation_energy,
    rotation_forces,
    rotation_outputs,
    times,
    turned_inertia,
)
from .parameters import quantity
from .quaternions import matrix
from .scene import Array, Paper, Scene, case_maker, with_placements, with_rates


@dataclass(frozen=True)
class RigidBody(BodyParameters):
    """Parameters of `rigid_body` (SI units)."""

    gravity_z: float = quantity(-9.81, "g_z", "m/s^2", "chosen", "in the world", "any")


Coefficients: Any = namedtuple("Coefficients", NUMBERS)  # type: ignore[misc]
"""Numbers of (1)-(3): s, the entries of J and of its inverse, g, mu."""


def coefficients(p: RigidBody, tensor: Array | None = None) -> Any:
    """Return the numbers of the equations; the inertia tensor (3, 3, ...) may be another."""
    return Coefficients(*body_numbers(p, tensor))


def body_accelerations(u: Any, motion: Any, c: Any, moment: Moment, xp: Any = np) -> list[Any]:
    """Return omega' by (1)."""
    q, _, omega = motion
    return times(c[9:15], moment(q, omega, times(c[3:9], omega), c))


def outputs(q: Any, v: Any, c: Any, xp: Any = np) -> dict[str, Any]:
    """Return attitude, body rates, angular momentum in the world, energy, length of q."""
    return rotation_outputs(q, v, momentum_of(q, v, c), rotation_energy(q, v, c), xp)


def pendulum_rate(p: RigidBody) -> Any:
    """Return the largest rate [rad/s] of small swings about rest, 0 without a torque of gravity."""
    pull = p.mass * np.linalg.norm(p.gravity, axis=0) * np.linalg.norm(p.centre, axis=0)
    least = np.min(np.linalg.eigvalsh(np.moveaxis(body_inertia(p), (0, 1), (-2, -1))), axis=-1)
    return np.sqrt(pull / least)


def period(p: RigidBody) -> Any:
    """Return the time [s] of the fastest swing about rest; that of 1 rad/s without any."""
    rate = pendulum_rate(p)
    return 2 * np.pi / np.where(rate > 0, rate, 1.0)


SAME = 1e-12
"""Relative difference of moments that count as the same."""


def magnitude(q: Any, v: Any, c: Any) -> Any:
    """Return the size of the angular momentum [kg m^2/s]."""
    return np.sqrt(sum(part * part for part in momentum_of(q, v, c)))


def along_gravity(q: Any, v: Any, c: Any) -> Any:
    """Return the angular momentum along gravity [kg m^2/s]."""
    g = np.array([c.g_x, c.g_y, c.g_z])
    return sum(a * b for a, b in zip(momentum_of(q, v, c), g / np.linalg.norm(g), strict=True))


def about_figure(q: Any, v: Any, c: Any) -> Any:
    """Return the angular momentum about the line to the centre of mass: of Lagrange's top."""
    arm = np.array(c[0:3]) / np.linalg.norm(c[0:3])
    return sum(a * b for a, b in zip(times(c[3:9], body_rates(q, v)[1]), arm, strict=True))


def kovalevskaya(q: Any, v: Any, c: Any) -> Any:
    """Return Kovalevskaya's integral [1/s^4] of a top with J_x = J_y = 2 J_z and C on the x axis.

    Whittaker, section 72: ``|(omega_x + i omega_y)^2 - nu (gamma_x + i gamma_y)|^2`` with
    nu = s g / J_z and the upward vertical gamma in the frame of the body.
    """
    omega, rows = body_rates(q, v)[1], matrix(q)
    g = np.array([c.g_x, c.g_y, c.g_z])
    up = [-sum(rows[i][j] * g[i] for i in range(3)) * c.s_x / c.inertia_zz for j in range(2)]
    real = omega[0] ** 2 - omega[1] ** 2 - up[0]
    imaginary = 2 * omega[0] * omega[1] - up[1]
    return real**2 + imaginary**2


def invariants(p: RigidBody) -> Mapping[str, Callable[..., Any]]:
    """Return energy and angular momentum, and the fourth integral of the tops that have one."""
    tensor, arm = body_inertia(p), p.centre
    known: dict[str, Callable[..., Any]] = {"energy": rotation_energy}
    if not np.any(arm) or not np.any(p.gravity):
        return known | {"momentum": magnitude}
    known["momentum"] = along_gravity
    if is_symmetric(tensor, arm):
        known["spin"] = about_figure
    if is_kovalevskaya(tensor, arm):
        known["kovalevskaya"] = kovalevskaya
    return known


def is_symmetric(tensor: Array, arm: Array) -> bool:
    """Return True if a tensor (3, 3) is the same about all axes across an arm (3,)."""
    e = arm / np.linalg.norm(arm)
    along = e @ tensor @ e
    across = (np.trace(tensor) - along) / 2
    symmetric = across * np.eye(3) + (along - across) * np.outer(e, e)
    return bool(np.max(np.abs(tensor - symmetric)) <= SAME * across)


def is_kovalevskaya(tensor: Array, arm: Array) -> bool:
    """Return True if J = diag(2, 2, 1) J_z, with the centre of mass on the x axis."""
    right = tensor[2, 2] * np.diag([2.0, 2.0, 1.0])
    return not np.any(arm[1:]) and bool(np.max(np.abs(tensor - right)) <= SAME * tensor[0, 0])


HEAVY = RigidBody()
WEIGHTLESS = HEAVY.replace(gravity_z=0.0)
FREE = WEIGHTLESS.replace(centre_x=0.0, centre_y=0.0, centre_z=0.0)
ALIGNED = FREE.replace(axes_x=0.0, axes_y=0.0, axes_z=0.0)
LAGRANGE = HEAVY.replace(
    centre_x=0.0, centre_y=0.0, axes_x=0.0, axes_y=0.0, axes_z=0.0, moment_2=0.004, moment_3=0.005
)
KOVALEVSKAYA = LAGRANGE.replace(
    mass=1.0, centre_x=0.1, centre_z=0.0, moment_1=0.05, moment_2=0.04, moment_3=0.015
)
TILTED = {"q_w": 0.9, "q_x": 0.3, "q_y": -0.3, "q_z": 0.1}  # of length 1
TUMBLING = {"omega_x": 6.0, "omega_y": -4.0, "omega_z": 9.0}
SPINNING = {"q_w": 0.96, "q_x": 0.28, "omega_x": 0.5, "omega_y": 1.0, "omega_z": 60.0}
ABOUT_MIDDLE = {"omega_x": 0.02, "omega_y": 10.0, "omega_z": 0.01}


MOTION = ("trajectory", "energy")

case = case_maker("rigid_body")

CASES = (
    case("heavy_tumbling", HEAVY, TILTED | TUMBLING, 1.0, "algebra", "order", *MOTION),
    case("free_euler", FREE, TILTED | TUMBLING, 2.0, "algebra", "order", *MOTION),
    case("intermediate_axis", ALIGNED, ABOUT_MIDDLE, 4.0, *MOTION, methods="best"),
    case("lagrange_top", LAGRANGE, SPINNING, 1.0, *MOTION, methods="best"),
    case("rest_hanging", HEAVY, {}, 0.5, "frequency", about="hanging"),
    case("kovalevskaya_top", KOVALEVSKAYA, TILTED | {"omega_z": 8.0}, 2.0, *MOTION, full_only=True),
    case("free_euler_long", FREE, TILTED | TUMBLING, 32.0, *MOTION, full_only=True),
)
"""`intermediate_axis` leaves its axis and turns over; it and `free_euler` have closed forms."""


SCENE = Scene(
    name="rigid_body",
    title="rigid body turning about a fixed point",
    paper=Paper(
        "L. D. Landau, E. M. Lifshitz",
        "Mechanics",
        "Butterworth-Heinemann, 3rd edition, sections 32-37",
        1976,
        "",  # a book
    ),
    parameters=RigidBody,
    coordinates=COORDINATES,
    quaternions=(QUATERNION,),
    units=with_rates(**dict.fromkeys(COORDINATES, "1")) | UNITS,
    coefficients=coefficients,
    inexact_numbers=inexact_numbers,
    inexact_accelerations=lambda change: inexact_accelerations(body_accelerations, 0, change),
    mass_matrix=lambda q, c, xp=np: turned_inertia(q, c[3:9], c[18]),
    forces=lambda u, q, v, c, xp=np: rotation_forces(q, v, c),
    accelerations=accelerations_by(body_accelerations),
    damping_matrix=lambda c: np.zeros((4, 4)),
    energy=rotation_energy,
    outputs=outputs,
    observed=(*ROTATION, *RATES),
    equilibria={
        "hanging": lambda p: rest_attitude(p, 1.0),
        "upright": lambda p: rest_attitude(p, -1.0),
    },
    period=period,
    invariants=invariants,
    cases=CASES,
    placed=with_placements(CASES[0], "algebra")[:1],  # a mirror has other quaternions
)

SCENE = replace(SCENE, mistakes=with_mistakes(SCENE, body_accelerations, coefficients))
