"""Bodies on hinges that float: Lagrange's equations from the velocity of each body.

Body 0 is the base. Positions are x, y, z of the base's point, the angles of the hinges, and the
quaternion from the base's frame to the world's.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from mbcheck.reference import quaternions
from mbcheck.reference.differences import by_differences, one_by_one
from mbcheck.reference.scene import Array

AXES = np.eye(3)


class Part(NamedTuple):
    """A body whose frame's origin is at its hinge, about its z axis.

    Attributes
    ----------
    parent : int
        -1 of the base.
    mass : float
    centre : array (3,)
        Of mass, in its frame.
    tensor : array (3, 3)
        Of inertia about it, in its frame.
    place : array (3,)
        Of the hinge in the parent's frame.
    frame : array (3, 3)
        Of the body in the parent's frame, at the angle 0.
    """

    parent: int
    mass: float
    centre: Array
    tensor: Array
    place: Array = AXES[0] * 0
    frame: Array = AXES


Torques = Callable[[Any, Any], Any]
"""From angles and rates to the torques at hinges."""


def about(axis: Array, angle: Any) -> Array:
    """Return the rotation (3, 3) about a unit axis."""
    return np.array(quaternions.matrix([np.cos(angle / 2), *(np.sin(angle / 2) * axis)]))


def frames(parts: list[Part], angles: Any) -> list[tuple[Array, Array]]:
    """Return rotation and origin of each body, in the frame of the base."""
    found: list[tuple[Array, Array]] = [(AXES, AXES[0] * 0)]
    for one, angle in zip(parts[1:], angles, strict=True):
        rotation, origin = found[one.parent]
        own = rotation @ one.frame @ about(AXES[2], angle)
        found.append((own, origin + rotation @ one.place))
    return found


def centres(parts: list[Part], q: Array) -> Array:
    """Return the centres of mass in the world (3 k,)."""
    rotation = np.array(quaternions.matrix(q[-4:]))
    placed = zip(parts, frames(parts, q[3:-4]), strict=True)
    return np.concatenate(
        [q[:3] + rotation @ (origin + own @ one.centre) for one, (own, origin) in placed]
    )


def rates_of(parts: list[Part], q: Array) -> Array:
    """Return what rates make: velocities in the world, spins in bodies, rho (6 k + 1, n)."""
    step, units = 1e-30, np.eye(len(q))
    columns = [centres(parts, q + 1j * step * unit).imag / step for unit in units]
    turning = np.array([quaternions.spin(q[-4:], unit) for unit in np.eye(4)]).T
    first = np.zeros((3, len(q) - 4))
    spins, placed = [np.hstack([first, 2 * turning[1:]])], frames(parts, q[3:-4])
    for k, one in enumerate(parts[1:], 1):
        back = placed[k][0].T @ placed[one.parent][0]
        spins.append(back @ spins[one.parent] + np.outer(AXES[2], units[2 + k]))
    rho = np.append(first[0], turning[0])[None]
    return np.vstack([np.array(columns).T, *spins, rho])


def lagrange(
    parts: list[Part], q: Array, v: Array, gravity: Array, radial: float
) -> tuple[Array, Array, float]:
    """Return mass matrix, generalised forces without springs and dampers, and energy.

    By differences of the mass matrix, which is what velocities and spins make it.
    """
    count, n = len(parts), len(q)
    weights = np.zeros((6 * count + 1, 6 * count + 1))
    for k, one in enumerate(parts):
        first, then = (slice(a + 3 * k, a + 3 * k + 3) for a in (0, 3 * count))
        weights[first, first], weights[then, then] = one.mass * AXES, one.tensor
    weights[-1, -1] = radial
    pull = np.concatenate([one.mass * gravity for one in parts])
    matrix = rates_of(parts, q)
    slopes = by_differences(one_by_one(lambda at: rates_of(parts, at).ravel()), q)[1]
    slopes = np.moveaxis(slopes.reshape(6 * count + 1, n, n), 2, 0)
    mass = matrix.T @ weights @ matrix
    by_q = np.array([one.T @ weights @ matrix + matrix.T @ weights @ one for one in slopes])
    right = by_q @ v @ v / 2 - np.tensordot(v, by_q, 1) @ v + pull @ matrix[: 3 * count]
    return mass, right, float(v @ mass @ v / 2 - pull @ centres(parts, q))


def momenta(parts: list[Part], q: Array, v: Array) -> tuple[Array, Array]:
    """Return the angular momentum about the centre of mass of all, and the linear one (3,)."""
    count, rates = len(parts), rates_of(parts, q) @ v
    points = centres(parts, q).reshape(count, 3)
    rotation = np.array(quaternions.matrix(q[-4:]))
    weights = np.array([one.mass for one in parts])
    velocities, spins = rates[:-1].reshape(2, count, 3)
    middle = weights @ points / np.sum(weights)
    turning = weights @ np.cross(points - middle, velocities)
    for one, (frame, _), spin in zip(parts, frames(parts, q[3:-4]), spins, strict=True):
        turning += rotation @ frame @ one.tensor @ spin
    return turning, weights @ velocities
