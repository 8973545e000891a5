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

The coordinates are the quaternion q = (w, x, y, z), whose length may be any, see `..body.rotation`:
Lagrange's equations of

    L = omega^T J omega / 2 + mu rho^2 / 2 + s . (R(q)^T g)                           (3)

with q^-1 q' = (rho, omega / 2) are (1), (2) and rho' = 0.
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
    momentum_of,
    rotation_energy,
    rotation_forces,
    rotation_mass_matrix,
    rotation_outputs,
    times,
)
from ..parameters import quantity
from ..scene import Array


@dataclass(frozen=True)
class RigidBody(BodyParameters):
    """Parameters of `rigid_body` (SI units)."""

    gravity_z: float = quantity(-9.81, "g_z", "m/s^2", "chosen", "in the world", "any")


Coefficients: Any = namedtuple("Coefficients", NUMBERS)  # type: ignore[misc]
"""Numbers of (1)-(3): s, the entries of J and of its inverse, g, mu."""


def coefficients(p: RigidBody) -> Any:
    """Return the numbers of (1)-(3); mu is the trace of J."""
    return coefficients_of(p, body_inertia(p))


def coefficients_of(p: RigidBody, tensor: Array) -> Any:
    """Return these numbers of an inertia tensor (3, 3, ...) about the fixed point."""
    return Coefficients(*body_numbers(p, tensor))


def mass_matrix(q: Any, c: Any, xp: Any = np) -> list[list[Any]]:
    """Return the mass matrix of (3)."""
    return rotation_mass_matrix(q, c)


def forces(u: Any, q: Any, v: Any, c: Any, xp: Any = np) -> list[Any]:
    """Return the right-hand side of ``M(q) a = f``."""
    return rotation_forces(q, v, c)


def body_accelerations(u: Any, motion: Any, c: Any, moment: Moment, xp: Any = np) -> list[Any]:
    """Return omega' by (1)."""
    q, _, omega = motion
    return times(c[9:15], moment(q, omega, times(c[3:9], omega), c))


accelerations = accelerations_by(body_accelerations)


def damping_matrix(c: Any) -> Array:
    """Return zeros: nothing damps."""
    return np.zeros((4, 4))


def energy(q: Any, v: Any, c: Any) -> Any:
    """Return kinetic and potential energy [J], that of the length of q included."""
    return rotation_energy(q, v, c)


def outputs(q: Any, v: Any, c: Any, xp: Any = np) -> dict[str, Any]:
    """Return attitude, body rates, angular momentum in the world, energy, length of q."""
    return rotation_outputs(q, v, momentum_of(q, v, c), energy(q, v, c), xp)


def pendulum_rate(p: RigidBody) -> Any:
    """Return the largest rate [rad/s] of small swings about rest, 0 without a torque of gravity."""
    pull = p.mass * np.linalg.norm(p.gravity, axis=0) * np.linalg.norm(p.centre, axis=0)
    least = np.min(np.linalg.eigvalsh(np.moveaxis(body_inertia(p), (0, 1), (-2, -1))), axis=-1)
    return np.sqrt(pull / least)


def period(p: RigidBody) -> Any:
    """Return the time [s] of the fastest swing about rest; that of 1 rad/s without any."""
    rate = pendulum_rate(p)
    return 2 * np.pi / np.where(rate > 0, rate, 1.0)
