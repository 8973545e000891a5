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

The coordinates are the quaternion q = (w, x, y, z), whose length may be any: with
q^-1 q' = (rho, omega / 2) and Lagrange's function

    L = omega^T J omega / 2 + mu rho^2 / 2 + s . (R(q)^T g)                           (3)

the logarithm of the length has an inertia mu of its own, keeps its rate rho, and touches nothing
else; |q| = 1 remains. Lagrange's equations of (3) are (1), (2) and rho' = 0. So a mass matrix of
four coordinates is regular, and no constraint has to be kept.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..errors import NoOrbitError, ParameterError
from ..parameters import Parameters, quantity
from ..quaternions import Quaternion, cross, matrix, of_rotation, product, spin, square, to
from ..scene import Array

TRIANGLE = 1e-12
"""Relative rounding that moments of a plane figure may be off the triangle inequality."""


@dataclass(frozen=True)
class RigidBody(Parameters):
    """Parameters of `rigid_body` (SI units).

    The principal axes stand in the frame of the body as its own axes turned by a rotation vector.
    """

    mass: float = quantity(1.2, "m", "kg", "chosen", "of the body")
    centre_x: float = quantity(0.03, "c_x", "m", "chosen", "of mass, in the body", "any")
    centre_y: float = quantity(-0.02, "c_y", "m", "chosen", "of mass, in the body", "any")
    centre_z: float = quantity(0.06, "c_z", "m", "chosen", "of mass, in the body", "any")
    moment_1: float = quantity(0.004, "I_1", "kg m^2", "chosen", "principal, about C")
    moment_2: float = quantity(0.006, "I_2", "kg m^2", "chosen", "principal, about C")
    moment_3: float = quantity(0.007, "I_3", "kg m^2", "chosen", "principal, about C")
    axes_x: float = quantity(0.4, "a_x", "rad", "chosen", "rotation of principal axes", "any")
    axes_y: float = quantity(-0.7, "a_y", "rad", "chosen", "rotation of principal axes", "any")
    axes_z: float = quantity(0.5, "a_z", "rad", "chosen", "rotation of principal axes", "any")
    gravity_x: float = quantity(0.0, "g_x", "m/s^2", "chosen", "in the world", "any")
    gravity_y: float = quantity(0.0, "g_y", "m/s^2", "chosen", "in the world", "any")
    gravity_z: float = quantity(-9.81, "g_z", "m/s^2", "chosen", "in the world", "any")

    def validate(self) -> None:
        """Refuse moments that no body has: each is at most the sum of the others."""
        moments = np.array(np.broadcast_arrays(self.moment_1, self.moment_2, self.moment_3))
        if np.any(2 * np.max(moments, axis=0) > (1 + TRIANGLE) * np.sum(moments, axis=0)):
            raise ParameterError(
                "no moment of inertia is larger than the sum of the other two; moment_1, moment_2, "
                f"moment_3 cannot be {self.moment_1}, {self.moment_2}, {self.moment_3}"
            )

    @property
    def centre(self) -> Any:
        """The centre of mass in the frame of the body (3, ...) [m]."""
        return np.array(np.broadcast_arrays(self.centre_x, self.centre_y, self.centre_z))

    @property
    def gravity(self) -> Any:
        """Gravity in the world (3, ...) [m/s^2]."""
        return np.array(np.broadcast_arrays(self.gravity_x, self.gravity_y, self.gravity_z))

    @property
    def moments(self) -> Any:
        """The principal moments about the centre of mass (3, ...) [kg m^2]."""
        return np.array(np.broadcast_arrays(self.moment_1, self.moment_2, self.moment_3))

    @property
    def axes(self) -> Any:
        """The quaternion (4, ...) that turns principal axes into the frame of the body."""
        return of_rotation(np.array(np.broadcast_arrays(self.axes_x, self.axes_y, self.axes_z)))


def central_inertia(p: RigidBody) -> Array:
    """Return the inertia tensor (3, 3) about the centre of mass, in the frame of the body."""
    axes = np.array(matrix(p.axes))
    return np.asarray(np.einsum("ik...,k...,jk...->ij...", axes, p.moments, axes))


def inertia(p: RigidBody) -> Array:
    """Return the inertia tensor (3, 3) about the fixed point, in the frame of the body."""
    c, one = p.centre, np.eye(3)
    spread = np.multiply.outer(one, np.sum(c * c, axis=0)) - c[:, None] * c[None, :]
    return np.asarray(central_inertia(p) + p.mass * spread)


PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Of the entries xx, yy, zz, xy, xz, yz of a symmetric tensor."""


class Coefficients(NamedTuple):
    """Numbers of (1)-(3): s, the entries of J and of its inverse, g, mu."""

    s_x: Any
    s_y: Any
    s_z: Any
    inertia_xx: Any
    inertia_yy: Any
    inertia_zz: Any
    inertia_xy: Any
    inertia_xz: Any
    inertia_yz: Any
    inverse_xx: Any
    inverse_yy: Any
    inverse_zz: Any
    inverse_xy: Any
    inverse_xz: Any
    inverse_yz: Any
    g_x: Any
    g_y: Any
    g_z: Any
    radial: Any


def coefficients(p: RigidBody) -> Coefficients:
    """Return the numbers of (1)-(3); mu is the trace of J."""
    return coefficients_of(p, inertia(p))


def coefficients_of(p: RigidBody, tensor: Array) -> Coefficients:
    """Return these numbers of an inertia tensor (3, 3, ...) about the fixed point."""
    inverse = np.moveaxis(np.linalg.inv(np.moveaxis(tensor, (0, 1), (-2, -1))), (-2, -1), (0, 1))
    numbers = [
        *(p.mass * p.centre),
        *(tensor[place] for place in PLACES),
        *(inverse[place] for place in PLACES),
        *p.gravity,
        tensor[0, 0] + tensor[1, 1] + tensor[2, 2],
    ]
    return Coefficients(*(float(one) if np.ndim(one) == 0 else one for one in numbers))


def times(entries: Any, w: Any) -> list[Any]:
    """Return the product of a symmetric tensor, by its six entries, with a vector."""
    xx, yy, zz, xy, xz, yz = entries
    return [
        xx * w[0] + xy * w[1] + xz * w[2],
        xy * w[0] + yy * w[1] + yz * w[2],
        xz * w[0] + yz * w[1] + zz * w[2],
    ]


def torque(q: Any, c: Coefficients) -> list[Any]:
    """Return the torque of the weight about the fixed point, in the frame of the body."""
    rows = matrix(q)
    pull = [rows[0][i] * c.g_x + rows[1][i] * c.g_y + rows[2][i] * c.g_z for i in range(3)]
    return cross(c[0:3], pull)


def mass_matrix(q: Any, c: Coefficients, xp: Any = np) -> list[list[Any]]:
    """Return the mass matrix of (3): (4 E^T J E + mu q q^T) / |q|^4 with E q' = Im(q* q')."""
    w, x, y, z = q
    columns = [[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]]
    size = square(q)
    rotated = [times(c[3:9], column) for column in columns]
    return [
        [
            (4 * sum(a * b for a, b in zip(columns[i], rotated[j], strict=True))
             + c.radial * q[i] * q[j]) / (size * size)
            for j in range(4)
        ]
        for i in range(4)
    ]  # fmt: skip


def moving(q: Any, v: Any, c: Coefficients) -> tuple[Any, list[Any], list[Any], list[Any]]:
    """Return rho, omega, J omega, and the right-hand side of (1)."""
    half = spin(q, v)
    omega = [2 * rate for rate in half[1:]]
    momentum = times(c[3:9], omega)
    gyroscopic = cross(omega, momentum)
    moment = [a - b for a, b in zip(torque(q, c), gyroscopic, strict=True)]
    return half[0], omega, momentum, moment


def forces(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
    """Return the right-hand side of ``M(q) a = f``."""
    rho, omega, momentum, moment = moving(q, v, c)
    along = c.radial * (rho * rho - (omega[0] ** 2 + omega[1] ** 2 + omega[2] ** 2) / 4)
    across = [4 * rho * a + 2 * b for a, b in zip(momentum, moment, strict=True)]
    size = square(q)
    return [part / size for part in product(q, [along, *across])]


def accelerations(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> list[Any]:
    """Return q'' by (1), (2): q ((rho, omega / 2)^2 + (0, omega' / 2))."""
    rho, omega, _, moment = moving(q, v, c)
    faster = times(c[9:15], moment)
    along = rho * rho - (omega[0] * omega[0] + omega[1] * omega[1] + omega[2] * omega[2]) / 4
    return product(q, [along, *(rho * a + b / 2 for a, b in zip(omega, faster, strict=True))])


def damping_matrix(c: Coefficients) -> Array:
    """Return zeros: nothing damps."""
    return np.zeros((4, 4))


def energy(q: Any, v: Any, c: Coefficients) -> Any:
    """Return kinetic and potential energy [J], that of the length of q included."""
    rho, omega, momentum, _ = moving(q, v, c)
    rows = matrix(q)
    centre = [sum(row[i] * c[i] for i in range(3)) for row in rows]
    kinetic = sum(a * b for a, b in zip(omega, momentum, strict=True)) + c.radial * rho * rho
    return kinetic / 2 - (centre[0] * c.g_x + centre[1] * c.g_y + centre[2] * c.g_z)


def momentum_of(q: Any, v: Any, c: Coefficients) -> list[Any]:
    """Return the angular momentum about the fixed point in the world [kg m^2/s]."""
    _, _, momentum, _ = moving(q, v, c)
    return [sum(row[i] * momentum[i] for i in range(3)) for row in matrix(q)]


def powers(u: Any, q: Any, v: Any, c: Coefficients) -> dict[str, Any]:
    """Return nothing: all forces are conservative."""
    return {}


COORDINATES = ("q_w", "q_x", "q_y", "q_z")
AXES = "xyz"
ROTATION = tuple(f"R_{row}{column}" for row in AXES for column in AXES)
"""Entries of the rotation matrix: components in the world (first) of the body's axes (second)."""

MOMENTUM = tuple(f"momentum_{axis}" for axis in AXES)
QUATERNION = Quaternion("q", COORDINATES, ("omega_x", "omega_y", "omega_z"))
RATES = QUATERNION.rates


def outputs(q: Any, v: Any, c: Coefficients, xp: Any = np) -> dict[str, Any]:
    """Return attitude, body rates, angular momentum in the world, energy, length of q."""
    rows = matrix(q)
    _, omega, _, _ = moving(q, v, c)
    return {
        **dict(zip(ROTATION, (entry for row in rows for entry in row), strict=True)),
        **dict(zip(RATES, omega, strict=True)),
        **dict(zip(MOMENTUM, momentum_of(q, v, c), strict=True)),
        "energy": energy(q, v, c),
        "norm": xp.sqrt(square(q)),
    }


def pendulum_rate(p: RigidBody) -> Any:
    """Return the largest rate [rad/s] of small swings about rest, 0 without a torque of gravity."""
    pull = p.mass * np.linalg.norm(p.gravity, axis=0) * np.linalg.norm(p.centre, axis=0)
    least = np.min(np.linalg.eigvalsh(np.moveaxis(inertia(p), (0, 1), (-2, -1))), axis=-1)
    return np.sqrt(pull / least)


def period(p: RigidBody) -> Any:
    """Return the time [s] of the fastest swing about rest; that of 1 rad/s without any."""
    rate = pendulum_rate(p)
    return 2 * np.pi / np.where(rate > 0, rate, 1.0)


def rest_attitude(p: RigidBody, sign: float) -> dict[str, float]:
    """Return the attitude in which gravity pulls along the arm of C (sign 1) or against it (-1).

    Raises
    ------
    NoOrbitError
        If there is no torque of gravity: every attitude is one of rest.
    """
    if not np.any(p.centre) or not np.any(p.gravity):
        raise NoOrbitError("without an offset of the centre of mass and gravity nothing swings")
    q = to(p.centre, sign * p.gravity)
    return dict(zip(COORDINATES, map(float, q), strict=True))
