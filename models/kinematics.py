"""Kinematics and inertia of a mechanism: Jacobians, mass matrix, weight, openness of loops.

Featherstone, *Rigid Body Dynamics Algorithms*, 2008, chapters 4 and 6.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from ..reference import quaternions
from ..reference.differences import along
from ..reference.scene import Array
from .mechanism import Body, Mechanism, Site, turn

# Kinematics


@dataclass(frozen=True)
class Placed:
    """A mechanism at one position: bodies' frames in the world, and axes of the velocities.

    Attributes
    ----------
    whole : Mechanism
    rotations, origins : list of arrays (3, 3), (3,)
    axes, anchors : array (n, 3)
        The axis about which, or along which, each of n velocities moves bodies, and a point on it.
    """

    whole: Mechanism
    rotations: list[Array]
    origins: list[Array]
    axes: Array
    anchors: Array

    def point(self, site: Site) -> Array:
        """Return a point in the world (3,)."""
        return self.origins[site.body] + self.rotations[site.body] @ site.position

    def jacobian(self, site: Site) -> Array:
        """Return the velocity (3, n) of a point per unit of each velocity."""
        turns, shifts = movers(self.whole)[site.body]
        columns = np.zeros_like(self.axes)
        columns[shifts] = self.axes[shifts]
        columns[turns] = np.cross(self.axes[turns], self.point(site) - self.anchors[turns])
        return columns.T

    def turning(self, body: int) -> Array:
        """Return the angular velocity (3, n) of a body in the world per unit of each velocity."""
        turns, _ = movers(self.whole)[body]
        columns = np.zeros_like(self.axes)
        columns[turns] = self.axes[turns]
        return columns.T


@lru_cache(maxsize=64)
def movers(whole: Mechanism) -> tuple[tuple[list[int], list[int]], ...]:
    """Return the numbers of the velocities that turn each body, and of those that shift it."""
    paths: list[tuple[list[int], list[int]]] = []
    for body in whole.bodies:
        turns, shifts = paths[body.parent] if body.parent >= 0 else ([], [])
        for i in body.joints:
            own, kind = whole.layout.velocities[i], whole.joints[i].kind
            first = {"slide": own.stop, "free": own.start + 3}.get(kind, own.start)
            shifts = [*shifts, *range(own.start, first)]
            turns = [*turns, *range(first, own.stop)]
        paths.append((turns, shifts))
    return tuple(paths)


def place(whole: Mechanism, q: Array) -> Placed:
    """Return a mechanism at joint positions, which may be complex."""
    rotations, origins = [np.eye(3)], [np.zeros(3)]
    count = whole.layout.size[1]
    axes, anchors = np.zeros((2, count, 3), dtype=q.dtype)
    for body in whole.bodies[1:]:
        rotation = rotations[body.parent] @ body.rotation
        origin = origins[body.parent] + rotations[body.parent] @ body.position
        for i in body.joints:
            one, own, numbers = (
                whole.joints[i],
                whole.layout.velocities[i],
                q[whole.layout.positions[i]],
            )
            if one.kind == "free":  # in the world, wherever the file places its body
                rotation, origin = np.array(quaternions.matrix(numbers[3:])), numbers[:3]
                axes[own], anchors[own] = np.concatenate([np.eye(3), rotation.T]), origin
                continue
            at = origin + rotation @ one.anchor
            if one.kind == "ball":
                rotation = rotation @ np.array(quaternions.matrix(numbers))
                origin = at - rotation @ one.anchor
                axes[own], anchors[own] = rotation.T, at
                continue
            axes[own], anchors[own] = rotation @ one.axis, at
            moved = numbers[0] - one.ref
            if one.hinge:
                rotation = rotation @ turn(one.axis, moved)
                origin = at - rotation @ one.anchor
            else:
                origin = origin + moved * (rotation @ one.axis)
        rotations.append(rotation)
        origins.append(origin)
    return Placed(whole, rotations, origins, axes, anchors)


def inertias(whole: Mechanism, q: Array) -> dict[str, Array]:
    """Return the share of each part in the mass matrix (n, n): masses, inertias, armatures.

    In space, products of inertia are separate parts.
    """
    placed = place(whole, q)
    matrices: dict[str, Array] = {}
    for i, body in enumerate(whole.bodies):
        if not any(movers(whole)[i]):
            continue
        if body.mass:
            moving = placed.jacobian(Site(i, body.centre))
            matrices[f"mass.{body.name}"] = body.mass * moving.T @ moving
        turning = placed.rotations[i].T @ placed.turning(i)
        for name, part in tensors(whole, body).items():
            if np.any(part):
                matrices[f"{name}.{body.name}"] = turning.T @ (part @ turning)
    for own, one in zip(whole.layout.velocities, whole.joints, strict=True):
        if one.armature:
            unit = np.zeros(placed.axes.shape[0])
            unit[own] = one.armature
            matrices[f"armature.{one.name}"] = np.diag(unit)
    return matrices


def tensors(whole: Mechanism, body: Body) -> dict[str, Array]:
    """Return the parts (3, 3) of a body's inertia tensor: its products apart in space."""
    moments = np.diag(np.diag(body.inertia)) if whole.layout.is_spatial else body.inertia
    return {"inertia": moments, "products": body.inertia - moments}


def with_shares(whole: Mechanism, shares: Mapping[str, float]) -> Mechanism:
    """Return a mechanism whose masses and inertia tensors count so many times, 1 by default.

    Parameters
    ----------
    whole : Mechanism
    shares : mapping of str to float
        By the names of `inertias`; armatures, of which no other force comes, are left.
    """
    bodies = [
        replace(
            body,
            mass=shares.get(f"mass.{body.name}", 1.0) * body.mass,
            inertia=np.sum(
                [
                    shares.get(f"{name}.{body.name}", 1.0) * part
                    for name, part in tensors(whole, body).items()
                ],
                axis=0,
            ),
        )
        for body in whole.bodies
    ]
    return replace(whole, bodies=tuple(bodies))


def mass_matrix(whole: Mechanism, q: Array) -> Array:
    """Return the mass matrix (n, n) of all joints at positions (n,)."""
    return np.asarray(np.sum(list(inertias(whole, q).values()), axis=0))


def inertial_force(whole: Mechanism, q: Array, v: Array) -> Array:
    """Return Coriolis, centrifugal and gyroscopic forces (n,)."""
    return centrifugal_force(whole, q, v) + sum(gyroscopic_forces(whole, q, v).values())


def centrifugal_force(whole: Mechanism, q: Array, v: Array) -> Array:
    """Return the inertial forces (n,) of bodies' accelerations at constant joint velocities."""
    faster, total = along(partial(motions, whole), q, whole.layout.rates(q, v)) @ v, 0 * v
    placed = place(whole, q)
    for i, (body, (shift, turn_rate)) in enumerate(zip(whole.bodies, faster, strict=True)):
        total = total + body.mass * shift @ placed.jacobian(Site(i, body.centre))
        rotation = placed.rotations[i]
        total += (rotation @ body.inertia @ rotation.T @ turn_rate) @ placed.turning(i)
    return total


def motions(whole: Mechanism, q: Array) -> Array:
    """Return the velocity of each centre of mass and of each body (k, 2, 3, n) per velocity."""
    placed = place(whole, q)
    return np.array(
        [
            [placed.jacobian(Site(i, body.centre)), placed.turning(i)]
            for i, body in enumerate(whole.bodies)
        ]
    )


def gyroscopic_forces(whole: Mechanism, q: Array, v: Array) -> dict[str, Array]:
    """Return the forces (n,) of ``omega x (I omega)`` of each body that turns."""
    placed = place(whole, q)
    forces = {}
    for i, body in enumerate(whole.bodies):
        if np.any(body.inertia) and movers(whole)[i][0]:
            turning = placed.rotations[i].T @ placed.turning(i)
            omega = turning @ v
            forces[f"gyroscopic.{body.name}"] = np.cross(omega, body.inertia @ omega) @ turning
    return forces


def weight(whole: Mechanism, q: Array, gravity: Array) -> Array:
    """Return the generalised force (n,) of a gravity (3,) on all bodies."""
    placed = place(whole, q)
    shifts = [placed.jacobian(Site(i, body.centre)) for i, body in enumerate(whole.bodies)]
    pulls = [body.mass * gravity @ shift for body, shift in zip(whole.bodies, shifts, strict=True)]
    return np.asarray(np.sum(pulls, axis=0))


def gaps(whole: Mechanism, q: Array) -> Array:
    """Return the gaps of the loops (3 k,) [m]."""
    placed = place(whole, q)
    open_by = [placed.point(one.first) - placed.point(one.second) for one in whole.closures]
    return np.concatenate(open_by) if open_by else np.zeros(0)


def gap_jacobian(whole: Mechanism, q: Array) -> Array:
    """Return the rate at which loops open (3 k, n) per rate of each joint."""
    placed = place(whole, q)
    rates = [placed.jacobian(one.first) - placed.jacobian(one.second) for one in whole.closures]
    return np.concatenate(rates) if rates else np.zeros((0, len(placed.axes)))


def gap_drift(whole: Mechanism, q: Array, v: Array) -> Array:
    """Return dJ/dt v (3 k,) of the loops [m/s^2]."""
    rates = whole.layout.rates(q, v)
    return np.asarray(along(partial(gap_jacobian, whole), q, rates) @ v)
