"""The parameters of a rigid body that is held at a point, and its inertia tensor."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ParameterError
from ..parameters import Parameters, quantity
from ..quaternions import matrix, of_rotation
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
"""Of the entries xx, yy, zz, xy, xz, yz of a symmetric tensor."""

NUMBERS = (
    *(f"s_{axis}" for axis in "xyz"),
    *(f"{of}_{'xyz'[i]}{'xyz'[j]}" for of in ("inertia", "inverse") for i, j in PLACES),
    *("g_x", "g_y", "g_z", "radial"),
)
"""Names of `body_numbers`, with which the coefficients of scenes with a body begin."""


def body_numbers(p: BodyParameters, tensor: Array) -> list[Any]:
    """Return s, J, its inverse, g and the trace of J, of an inertia tensor (3, 3, ...) as J.

    These are 3, 6, 6, 3 numbers and one, see `NUMBERS`.
    """
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
    inverse K those of K J K are, as inversion leaves it, and each by itself. An arm that is long
    beside the radii of gyration makes J and K ill-conditioned: about it hardly anything is left of
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
