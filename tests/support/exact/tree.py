"""Bodies on hinges that float, by the laws of each body: a formulation without a tree.

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


def tilde(a: Array) -> Array:
    """Return the matrix of a x."""
    return np.asarray(np.cross(AXES, a))


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


def by_constraints(
    parts: list[Part], torques: Torques, gravity: Array
) -> Callable[..., tuple[Array, Array]]:
    """Return accelerations from Newton's and Euler's laws of k bodies and forces in hinges.

    Unknown are the acceleration of each centre of mass and each angular acceleration in the
    world (6 k), and for each hinge a force and a torque across its axis (5). They are those that
    `charts.by_rotation_vector` asks for.
    """
    count = len(parts)

    def accelerate(
        t: float, rotation: Array, omega: Array, at: Array, rates: Array
    ) -> tuple[Array, Array]:
        placed = [(rotation @ own, rotation @ origin) for own, origin in frames(parts, at[3:])]
        acting, spins = torques(at[3:], rates[3:]), [rotation @ omega]
        whole, right = np.zeros((6 * count, 6 * count)), np.zeros(6 * count)
        rows, known, axes = [], [], []
        for k, one in enumerate(parts[1:], 1):
            axis, rate, torque = placed[k][0][:, 2], rates[2 + k], acting[k - 1]
            spin = spins[one.parent]
            own = spin + rate * axis
            spins.append(own)
            axes.append(axis)
            base = parts[one.parent]
            near = placed[one.parent][0] @ (one.place - base.centre)
            far = -placed[k][0] @ one.centre
            row, across = np.zeros((5, 6 * count)), np.linalg.svd(axis[None])[2][1:]
            before, mine = (slice(6 * i, 6 * i + 6) for i in (one.parent, k))
            row[:3, before] = np.hstack([AXES, -tilde(near)])
            row[:3, mine] = -np.hstack([AXES, -tilde(far)])
            row[3:, before.start + 3 : before.stop] = -across
            row[3:, mine.start + 3 : mine.stop] = across
            rows.append(row)
            swing = np.cross(own, np.cross(own, far)) - np.cross(spin, np.cross(spin, near))
            known.append(np.append(swing, across @ np.cross(spin, axis) * rate))
            right[before.start + 3 : before.stop] -= torque * axis
            right[mine.start + 3 : mine.stop] += torque * axis
        for k, (one, (frame, _), own) in enumerate(zip(parts, placed, spins, strict=True)):
            first, then = slice(6 * k, 6 * k + 3), slice(6 * k + 3, 6 * k + 6)
            tensor = frame @ one.tensor @ frame.T
            whole[first, first], whole[then, then] = one.mass * AXES, tensor
            right[first] += one.mass * gravity
            right[then] -= np.cross(own, tensor @ own)
        both = np.vstack(rows)
        none = np.zeros((len(both), len(both)))
        matrix = np.block([[whole, both.T], [both, none]])
        found = np.linalg.solve(matrix, np.concatenate([right, *known]))[: 6 * count]
        linear, angular = np.moveaxis(found.reshape(count, 2, 3), 1, 0)
        arm, spin = rotation @ parts[0].centre, spins[0]
        moved = linear[0] - np.cross(angular[0], arm) - np.cross(spin, np.cross(spin, arm))
        more = [
            axis @ (angular[k] - angular[one.parent])
            for k, (one, axis) in enumerate(zip(parts[1:], axes, strict=True), 1)
        ]
        return np.array([*moved, *more]), rotation.T @ angular[0]

    return accelerate


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
