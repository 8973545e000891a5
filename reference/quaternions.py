"""Quaternions (w, x, y, z) by Hamilton's rule, as lists of four numbers of any kind.

They turn a body's frame into the world's: a vector r of the body is q r q^-1 in the world. The
length may be any.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np


class Quaternion(NamedTuple):
    """Four coordinates (w, x, y, z) that turn a body's frame into the world's.

    They are a unit quaternion by Hamilton's rule. Its sign is a convention and its length is kept:
    runs are compared by outputs that depend on neither.

    Attributes
    ----------
    name : str
        Of the ball or free joint that has it in models.
    coordinates : (str, str, str, str)
    rates : (str, str, str)
        Outputs that are the angular velocity [rad/s] in the body's frame. An initial state may have
        them in place of the coordinates' rates.
    place : tuple of str
        Coordinates that are the place in the world of the body's frame, of a free joint.
    """

    name: str
    coordinates: tuple[str, str, str, str]
    rates: tuple[str, str, str]
    place: tuple[str, ...] = ()


def product(a: Any, b: Any) -> list[Any]:
    """Return the product a b."""
    return [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]


def conjugate(a: Any) -> list[Any]:
    """Return the quaternion of the opposite rotation."""
    return [a[0], -a[1], -a[2], -a[3]]


def square(a: Any) -> Any:
    """Return the square of the length."""
    return a[0] * a[0] + a[1] * a[1] + a[2] * a[2] + a[3] * a[3]


def matrix(a: Any) -> list[list[Any]]:
    """Return the rotation matrix (3, 3): its columns are the body's axes in the world."""
    w, x, y, z = a
    s = 2 / square(a)
    return [
        [1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
        [s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)],
        [s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)],
    ]


def cross(a: Any, b: Any) -> list[Any]:
    """Return the cross product of two vectors."""
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def spin(a: Any, rates: Any) -> list[Any]:
    """Return (s, x, y, z): half the angular velocity in the body's frame, s for a change of length.

    It is a^-1 da/dt.
    """
    size = square(a)
    return [part / size for part in product(conjugate(a), rates)]


def of_rotation(vector: Any) -> Any:
    """Return the unit quaternion (4, ...) of a rotation vector (3, ...).

    The angle is rounded once: many turns on, each rounding is one of as many radians.
    """
    vector = np.asarray(vector)
    angle = np.asarray(np.frompyfunc(math.hypot, 3, 1)(*vector), dtype=float)
    share = np.divide(np.sin(angle / 2), angle, out=np.full(angle.shape, 0.5), where=angle > 0)
    return np.concatenate([[np.cos(angle / 2)], vector * share])


def to(a: Any, b: Any) -> Any:
    """Return the unit quaternion (4,) that turns the direction of a vector (3,) into another's."""
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    half = a + b
    if np.linalg.norm(half) < 1e-7:  # half a turn about any axis across
        across = np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
        return np.concatenate([[0.0], across / np.linalg.norm(across)])
    half = half / np.linalg.norm(half)
    return np.concatenate([[a @ half], np.cross(a, half)])
