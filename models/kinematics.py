"""Kinematics and inertia of a mechanism: Jacobians, mass matrix, weight, openness of loops.

Featherstone, *Rigid Body Dynamics Algorithms*, 2008, chapters 4 and 6.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np

from ..reference.differences import along
from ..reference.scene import Array
from .mechanism import Mechanism, Site, turn

# Kinematics


@dataclass(frozen=True)
class Placed:
    """A mechanism at one position: bodies' frames, joints' axes and anchors (n, 3) in the world."""

    whole: Mechanism
    rotations: list[Array]
    origins: list[Array]
    axes: Array
    anchors: Array

    def point(self, site: Site) -> Array:
        """Return a point in the world (3,)."""
        return self.origins[site.body] + self.rotations[site.body] @ site.position

    def jacobian(self, site: Site) -> Array:
        """Return the velocity (3, n) of a point per rate of each joint."""
        hinges, slides = movers(self.whole)[site.body]
        columns = np.zeros_like(self.axes)
        columns[slides] = self.axes[slides]
        columns[hinges] = np.cross(self.axes[hinges], self.point(site) - self.anchors[hinges])
        return columns.T

    def turning(self, body: int) -> Array:
        """Return the angular velocity (3, n) of a body per rate of each joint."""
        hinges, _ = movers(self.whole)[body]
        columns = np.zeros_like(self.axes)
        columns[hinges] = self.axes[hinges]
        return columns.T


@lru_cache(maxsize=64)
def movers(whole: Mechanism) -> tuple[tuple[list[int], list[int]], ...]:
    """Return the hinges, and the slides, that move each body."""
    paths: list[tuple[list[int], list[int]]] = []
    for body in whole.bodies:
        hinges, slides = paths[body.parent] if body.parent >= 0 else ([], [])
        own = [i for i in body.joints if whole.joints[i].hinge]
        paths.append(([*hinges, *own], [*slides, *(set(body.joints) - set(own))]))
    return tuple(paths)


def place(whole: Mechanism, q: Array) -> Placed:
    """Return a mechanism at joint positions (n,), which may be complex."""
    rotations, origins = [np.eye(3)], [np.zeros(3)]
    axes, anchors = np.zeros((2, len(q), 3), dtype=q.dtype)
    for body in whole.bodies[1:]:
        rotation = rotations[body.parent] @ body.rotation
        origin = origins[body.parent] + rotations[body.parent] @ body.position
        for i in body.joints:
            one = whole.joints[i]
            moved = q[i] - one.ref
            axes[i], anchors[i] = rotation @ one.axis, origin + rotation @ one.anchor
            if one.hinge:
                rotation = rotation @ turn(one.axis, moved)
                origin = anchors[i] - rotation @ one.anchor
            else:
                origin = origin + moved * axes[i]
        rotations.append(rotation)
        origins.append(origin)
    return Placed(whole, rotations, origins, axes, anchors)


def inertias(whole: Mechanism, q: Array) -> dict[str, Array]:
    """Return what each part adds to the mass matrix (n, n): masses, inertias, armatures."""
    placed = place(whole, q)
    matrices: dict[str, Array] = {}
    for i, body in enumerate(whole.bodies):
        if not any(movers(whole)[i]):
            continue
        if body.mass:
            moving = placed.jacobian(Site(i, body.centre))
            matrices[f"mass.{body.name}"] = body.mass * moving.T @ moving
        if np.any(body.inertia):
            turning = placed.rotations[i].T @ placed.turning(i)
            matrices[f"inertia.{body.name}"] = turning.T @ (body.inertia[:, None] * turning)
    for i, one in enumerate(whole.joints):
        if one.armature:
            matrix = np.zeros((len(q), len(q)))
            matrix[i, i] = one.armature
            matrices[f"armature.{one.name}"] = matrix
    return matrices


def mass_matrix(whole: Mechanism, q: Array) -> Array:
    """Return the mass matrix (n, n) of all joints at positions (n,)."""
    total: Array = np.sum(list(inertias(whole, q).values()), axis=0)
    return total


def inertial_force(whole: Mechanism, q: Array, v: Array) -> Array:
    """Return Coriolis and centrifugal forces (n,): dM/dt v - grad(v M v)/2."""
    mass = partial(mass_matrix, whole)
    slopes = [v @ along(mass, q, unit) @ v for unit in np.eye(len(q))]
    return np.asarray(along(mass, q, v) @ v - np.array(slopes) / 2)


def weight(whole: Mechanism, q: Array, gravity: Array) -> Array:
    """Return the generalised force (n,) of a gravity (3,) on all bodies."""
    placed = place(whole, q)
    total: Array = np.sum(
        [
            body.mass * gravity @ placed.jacobian(Site(i, body.centre))
            for i, body in enumerate(whole.bodies)
        ],
        axis=0,
    )
    return total


def gaps(whole: Mechanism, q: Array) -> Array:
    """Return how far each loop is open (3 k,) [m]."""
    placed = place(whole, q)
    open_by = [placed.point(one.first) - placed.point(one.second) for one in whole.closures]
    return np.concatenate(open_by) if open_by else np.zeros(0)


def gap_jacobian(whole: Mechanism, q: Array) -> Array:
    """Return the rate at which loops open (3 k, n) per rate of each joint."""
    placed = place(whole, q)
    rates = [placed.jacobian(one.first) - placed.jacobian(one.second) for one in whole.closures]
    return np.concatenate(rates) if rates else np.zeros((0, len(q)))


def gap_drift(whole: Mechanism, q: Array, v: Array) -> Array:
    """Return dJ/dt v (3 k,) of the loops [m/s^2]."""
    return np.asarray(along(partial(gap_jacobian, whole), q, v) @ v)
