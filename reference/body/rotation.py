r"""How a rigid body turns about a point, in a quaternion q = (w, x, y, z) of any length.

With q^-1 q' = (rho, omega / 2) and Lagrange's function

    L = omega^T J omega / 2 + mu rho^2 / 2 + ...                                      (1)

the logarithm of the length has an inertia mu of its own, keeps its rate rho, and touches nothing
else; |q| = 1 remains. So a mass matrix of four coordinates is regular, and no constraint has to be
kept.

The quaternion is the last of a scene's coordinates. The first numbers of its coefficients are
those of `parameters.body_numbers`: s = m c, the inertia tensor J about the point and its inverse in
the frame of the body, gravity g, mu.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import permutations
from typing import Any

import numpy as np

from ..errors import NoOrbitError, ParameterError
from ..parameters import Parameters, quantity
from ..quaternions import (
    Quaternion,
    conjugate,
    cross,
    matrix,
    of_rotation,
    product,
    spin,
    square,
    to,
)
from ..scene import Array

TRIANGLE = 1e-12
"""Relative rounding that moments of a plane figure may be off the triangle inequality."""


@dataclass(frozen=True)
class BodyParameters(Parameters):
    """Parameters of a rigid body, and of gravity (SI units).

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
    gravity_z: float = quantity(0.0, "g_z", "m/s^2", "chosen", "in the world", "any")

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


def central_inertia(p: BodyParameters) -> Array:
    """Return the inertia tensor (3, 3) about the centre of mass, in the frame of the body."""
    axes = np.array(matrix(p.axes))
    return np.asarray(np.einsum("ik...,k...,jk...->ij...", axes, p.moments, axes))


def body_inertia(p: BodyParameters) -> Array:
    """Return the inertia tensor (3, 3) about the fixed point, in the frame of the body."""
    c, one = p.centre, np.eye(3)
    spread = np.multiply.outer(one, np.sum(c * c, axis=0)) - c[:, None] * c[None, :]
    return np.asarray(central_inertia(p) + p.mass * spread)


PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Rows and columns of the entries xx, yy, zz, xy, xz, yz of a symmetric tensor."""

NUMBERS = (
    *(f"s_{axis}" for axis in "xyz"),
    *(f"{of}_{'xyz'[i]}{'xyz'[j]}" for of in ("inertia", "inverse") for i, j in PLACES),
    *("g_x", "g_y", "g_z", "radial"),
)
"""Names of `body_numbers`, with which the coefficients of scenes with a body begin."""


def body_numbers(p: BodyParameters, tensor: Array | None = None) -> list[Any]:
    """Return s, J, its inverse, g and the trace of J; by default J is `body_inertia`.

    These are 3, 6, 6, 3 numbers and one, see `NUMBERS`.
    """
    tensor = body_inertia(p) if tensor is None else tensor
    inverse = np.moveaxis(np.linalg.inv(np.moveaxis(tensor, (0, 1), (-2, -1))), (-2, -1), (0, 1))
    numbers = [
        *(p.mass * p.centre),
        *(tensor[place] for place in PLACES),
        *(inverse[place] for place in PLACES),
        *p.gravity,
        tensor[0, 0] + tensor[1, 1] + tensor[2, 2],
    ]
    return [float(one) if np.ndim(one) == 0 else one for one in numbers]


def inexact_numbers(c: Any, change: float) -> Iterator[Any]:
    """Yield coefficients that begin with `body_numbers`, one number each off by a relative change.

    Entries of J are sums, and off by so much of what they are sums of (Cauchy, Schwarz); of its
    inverse K those of K J K are, as inversion leaves it, and each by itself. An arm much longer
    than the radii of gyration makes J and K ill-conditioned: about it hardly anything is left of
    terms that cancel, while rounding of the arm and of the moments leaves them as they should be.
    """
    c = type(c)(*np.broadcast_arrays(*c))
    root = np.sqrt(np.abs(c[3:6]))
    rows, columns = np.transpose(PLACES)
    inverse = np.zeros((3, 3, *np.shape(c[0])))
    inverse[rows, columns] = inverse[columns, rows] = c[9:15]
    for k, (i, j) in enumerate(PLACES):
        share = change * root[i] * root[j]
        numbers = list(c)
        numbers[3 + k] = numbers[3 + k] + share
        yield type(c)(*numbers)
        spread = share * inverse[i][:, None] * inverse[j]
        spread = spread + spread.swapaxes(0, 1) if i != j else spread
        yield type(c)(*c[:9], *(c[9:15] - spread[rows, columns]), *c[15:])
    for name, value in zip(c._fields, c, strict=True):
        if np.any(value):
            yield c._replace(**{name: value * (1 + change)})


def without_products(p: BodyParameters) -> Array:
    """Return the inertia tensor about the fixed point of a body without central products."""
    central = central_inertia(p)
    off = central * (1 - np.eye(3)).reshape(3, 3, *(1,) * (central.ndim - 2))
    return body_inertia(p) - off


COORDINATES = ("q_w", "q_x", "q_y", "q_z")
AXES = "xyz"
ROTATION = tuple(f"R_{row}{column}" for row in AXES for column in AXES)
"""Entries of the rotation matrix: components in the world (first) of the body's axes (second)."""

MOMENTUM = tuple(f"momentum_{axis}" for axis in AXES)
QUATERNION = Quaternion("q", COORDINATES, ("omega_x", "omega_y", "omega_z"))
RATES = QUATERNION.rates
UNITS = {
    **dict.fromkeys(ROTATION, "1"),
    **dict.fromkeys(RATES, "rad/s"),
    **dict.fromkeys(MOMENTUM, "kg m^2/s"),
    "energy": "J",
    "norm": "1",
}
"""Names of the rotation outputs."""

Moment = Callable[[Any, Any, Any, Any], list[Any]]
"""Function of q, omega, J omega and coefficients that returns J omega' about a fixed point."""

BodyAccelerations = Callable[..., list[Any]]
"""Function of u, (q, v, omega), coefficients, a `Moment` and ``xp`` that returns the accelerations
of the coordinates before the quaternion, then omega'."""


def inner(a: Any, b: Any) -> Any:
    """Return the scalar product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def sum_of(a: Any, b: Any, factor: Any = 1.0) -> list[Any]:
    """Return a + factor b of two vectors."""
    return [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]]


def times(entries: Any, w: Any) -> list[Any]:
    """Return the product of a symmetric tensor, by its six entries, with a vector."""
    xx, yy, zz, xy, xz, yz = entries
    return [
        xx * w[0] + xy * w[1] + xz * w[2],
        xy * w[0] + yy * w[1] + yz * w[2],
        xz * w[0] + yz * w[1] + zz * w[2],
    ]


def into_body(q: Any, vector: Any) -> list[Any]:
    """Return the components in the frame of the body of a vector of the world."""
    return [inner(column, vector) for column in zip(*matrix(q), strict=True)]


def torque(q: Any, c: Any) -> list[Any]:
    """Return the torque of the weight about the point, in the frame of the body."""
    return cross(c[0:3], into_body(q, c[15:18]))


def euler(q: Any, omega: Any, momentum: Any, c: Any) -> list[Any]:
    """Return torque and gyroscopic term of Euler's equations: s x (R^T g) - omega x (J omega)."""
    return sum_of(torque(q, c), cross(omega, momentum), -1.0)


def body_rates(q: Any, v: Any) -> tuple[Any, list[Any]]:
    """Return rho and the angular velocity in the frame of the body."""
    rho, *half = spin(q, v)
    return rho, [2 * rate for rate in half]


def world_rates(q: Any, v: Any) -> tuple[Any, list[Any]]:
    """Return rho and the angular velocity in the world."""
    rho, *half = (part / square(q) for part in product(v, conjugate(q)))
    return rho, [2 * rate for rate in half]


def accelerations_by(
    accelerate: BodyAccelerations, first: int = 0, moment: Moment = euler, outside: bool = False
) -> Any:
    """Return the accelerations of a scene: q'' = q ((rho, omega / 2)^2 + (0, omega' / 2)).

    Parameters
    ----------
    accelerate : BodyAccelerations
    first : int
        Place of the quaternion among the coordinates; an integrated clock comes after it.
    moment : Moment
    outside : bool
        Whether, by mistake, omega turns the quaternion as if it were given in the world frame.
    """
    turning = slice(first, first + 4)

    def accelerations(u: Any, q: Any, v: Any, c: Any, xp: Any = np) -> list[Any]:
        turn = q[turning]
        rho, omega = (world_rates if outside else body_rates)(turn, v[turning])
        *others, x, y, z = accelerate(u, (q, v, omega), c, moment, xp)
        along = rho * rho - inner(omega, omega) / 4
        change = [along, *(rho * a + b / 2 for a, b in zip(omega, (x, y, z), strict=True))]
        return [*others, *(product(change, turn) if outside else product(turn, change))]

    return accelerations


def inexact_accelerations(
    accelerate: BodyAccelerations, first: int, change: float
) -> Iterator[Callable[..., Any]]:
    """Yield the accelerations of a scene, one product of a moment each off by a relative change.

    At rest the arm is along gravity: changes of either leave no moment about it, where the moment
    of inertia may be least, but rounding of their products does.
    """
    for i, j, k in permutations(range(3)):

        def moment(q: Any, omega: Any, momentum: Any, c: Any, at: Any = (i, j, k)) -> list[Any]:
            parts, (i, j, k) = euler(q, omega, momentum, c), at
            parts[i] += change * (c[j] * into_body(q, c[15:18])[k] + omega[j] * momentum[k])
            return parts

        yield accelerations_by(accelerate, first, moment)


def rotation_columns(q: Any) -> list[list[Any]]:
    """Return E^T (4, 3): E q' is the vector part of q* q'."""
    w, x, y, z = q
    return [[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]]


def turned_inertia(q: Any, tensor: Any, radial: Any) -> list[list[Any]]:
    """Return the mass matrix of q, (4 E^T J E + mu q q^T) / |q|^4, by J's six entries and mu."""
    columns, size = rotation_columns(q), square(q)
    rotated = [times(tensor, column) for column in columns]
    return [
        [
            (4 * inner(columns[i], rotated[j]) + radial * q[i] * q[j]) / (size * size)
            for j in range(4)
        ]
        for i in range(4)
    ]  # fmt: skip


def rotation_forces(q: Any, v: Any, c: Any, moment: Moment = euler) -> list[Any]:
    """Return the generalised forces of q, velocity-dependent inertia terms included."""
    omega = body_rates(q, v)[1]
    momentum = times(c[3:9], omega)
    return turned_forces(q, v, moment(q, omega, momentum, c), momentum, c[18])


def turned_forces(q: Any, v: Any, turning: Any, momentum: Any, radial: Any) -> list[Any]:
    """Return the generalised forces of q, by the right-hand side of J omega' = ..., J omega, mu."""
    rho, omega = body_rates(q, v)
    along = radial * (rho * rho - inner(omega, omega) / 4)
    change = sum_of([2 * part for part in turning], momentum, 4 * rho)
    size = square(q)
    return [part / size for part in product(q, [along, *change])]


def rotation_energy(q: Any, v: Any, c: Any) -> Any:
    """Return kinetic energy and that of the weight [J], that of the length of q included."""
    rho, omega = body_rates(q, v)
    kinetic = inner(omega, times(c[3:9], omega)) + c[18] * rho * rho
    return kinetic / 2 - inner(c[0:3], into_body(q, c[15:18]))


def momentum_of(q: Any, v: Any, c: Any) -> list[Any]:
    """Return R J omega, the angular momentum about the point in the world [kg m^2/s]."""
    momentum = times(c[3:9], body_rates(q, v)[1])
    return [inner(row, momentum) for row in matrix(q)]


def rotation_outputs(q: Any, v: Any, momentum: Any, energy: Any, xp: Any) -> dict[str, Any]:
    """Return attitude, body rates, angular momentum in the world, energy, length of q."""
    return {
        **dict(zip(ROTATION, (entry for row in matrix(q) for entry in row), strict=True)),
        **dict(zip(RATES, body_rates(q, v)[1], strict=True)),
        **dict(zip(MOMENTUM, momentum, strict=True)),
        "energy": energy,
        "norm": xp.sqrt(square(q)),
    }


def rest_attitude(p: BodyParameters, sign: float) -> dict[str, float]:
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
