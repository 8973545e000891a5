"""Coordinates of a scene from the joints of a model, and what belongs to them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from ..reference.quaternions import Quaternion, product, spin
from ..reference.scene import Array, Dynamics
from .joints import JointLayout
from .placement import turn_quaternion


@dataclass(frozen=True)
class Readout:
    """How coordinates of a scene follow from the joints of a model.

    Attributes
    ----------
    scene : Dynamics
    coordinates : tuple of str, n of them
        In which states are given.
    joints : tuple of str
    layout : JointLayout
        Of the joints.
    sums : mapping of coordinate to {joint: factor}
        What is missing is a joint of the same name. A quaternion is the ball joint, or the end of
        the free joint, of its name.
    axes : array (3, 3)
        Rotation from the axes of the model to those of the world, which free joints have.
    """

    scene: Dynamics
    coordinates: tuple[str, ...]
    joints: tuple[str, ...]
    layout: JointLayout
    sums: Mapping[str, Mapping[str, float]]
    axes: Array = field(default_factory=partial(np.eye, 3))

    @property
    def quaternions(self) -> tuple[Quaternion, ...]:
        """Quaternions that are joints of the model."""
        return tuple(one for one in self.scene.quaternions if one.name in self.joints)

    def place(self, name: str) -> tuple[slice, slice]:
        """Return the places of a joint in vectors of positions and of velocities."""
        i = self.joints.index(name)
        return self.layout.positions[i], self.layout.velocities[i]

    def quaternion(self, one: Quaternion) -> tuple[list[int], slice, slice]:
        """Return the places of a quaternion in coordinates and positions, and of its rates."""
        at, own = self.place(one.name)
        places = [self.coordinates.index(name) for name in one.coordinates]
        return places, slice(at.stop - 4, at.stop), slice(own.stop - 3, own.stop)

    def factors(self) -> Array:
        """Return coordinates as sums of velocities (n, n_v); those of quaternions have none."""
        matrix = np.zeros((len(self.coordinates), self.layout.size[1]))
        for row, _, own, factor in self.scalars():
            matrix[row, own] = factor
        return matrix

    def scalars(self) -> Iterator[tuple[int, int, int, float]]:
        """Yield the terms of coordinates that are sums of numbers, quaternions apart.

        Places of a coordinate, of a number in positions and of one in velocities; a factor.
        """
        spatial = [name for one in self.quaternions for name in (*one.coordinates, *one.place)]
        for one in self.quaternions:
            at, own = self.place(one.name)
            for name, axis in zip(one.place, self.axes.T.tolist(), strict=False):
                for i, factor in enumerate(axis):
                    if factor:  # else what is not finite would spread
                        yield self.coordinates.index(name), at.start + i, own.start + i, factor
        for row, name in enumerate(self.coordinates):
            if name in spatial:
                continue
            for joint, factor in self.sums.get(name, {name: 1.0}).items():
                at, own = self.place(joint)
                yield row, at.start, own.start, factor

    def states(self, positions: Array, velocities: Array) -> Array:
        """Return states (2 n, k) of positions (k, n_q) and velocities (k, n_v)."""
        n = len(self.coordinates)
        states = np.zeros((2 * n, len(positions)))
        for row, place, rate, factor in self.scalars():
            states[row] += factor * positions[:, place]
            states[n + row] += factor * velocities[:, rate]
        for one in self.quaternions:
            rows, at, own = self.quaternion(one)
            q, omega = positions[:, at].T, velocities[:, own].T
            if self.layout.kinds[self.joints.index(one.name)] == "free":
                q = turn_quaternion(self.axes).T @ q
            states[rows] = q
            states[[n + row for row in rows]] = product(q, [0.0 * q[0], *(omega / 2)])
        return states

    def accelerations(self, states: Array, velocities_dot: Array) -> Array:
        """Return accelerations (k, n) of coordinates at states (k, 2 n) from those of joints."""
        rows = velocities_dot @ self.factors().T
        n = len(self.coordinates)
        for one in self.quaternions:
            places, _, own = self.quaternion(one)
            q, rates = states[:, places].T, states[:, [n + i for i in places]].T
            rho, *half = spin(q, rates)
            along = rho * rho - sum(rate * rate for rate in half)
            faster = velocities_dot[:, own].T
            across = [2 * rho * rate + more / 2 for rate, more in zip(half, faster, strict=True)]
            rows[:, places] = np.array(product(q, [along, *across])).T
        return np.asarray(rows)

    def completed(self, matrix: Array, state: Array, parameters: Any) -> Array:
        """Return a mass matrix (n, n) `with_lengths` of quaternions that are joints."""
        scene = replace(self.scene, quaternions=self.quaternions)
        return with_lengths(matrix, scene, parameters, self.coordinates, state)


def with_lengths(
    matrix: Array, scene: Dynamics, parameters: Any, names: tuple[str, ...], state: Array
) -> Array:
    """Return a mass matrix (n, n) of coordinates with the inertia of the lengths of quaternions.

    No model has any: it is the scene's.
    """
    if not scene.quaternions:
        return matrix
    values = dict(zip(names, state[: len(names)], strict=True))
    at = np.array([values.get(name, 0.0) for name in scene.coordinates])
    whole = np.array(scene.mass_matrix(at, scene.coefficients(parameters)), dtype=float)
    for one in scene.quaternions:
        rows = [scene.coordinates.index(name) for name in one.coordinates]
        places = np.ix_(*[[names.index(name) for name in one.coordinates]] * 2)
        q = at[rows]
        length = q @ whole[np.ix_(rows, rows)] @ q / (q @ q) ** 2
        matrix[places] += length * np.outer(q, q)
    return matrix


def without_lengths(matrix: Array, scene: Dynamics, names: tuple[str, ...], state: Array) -> Array:
    """Return a matrix (n, n) of coordinates on the motions that keep the lengths of quaternions."""
    if not scene.quaternions:
        return matrix
    across = np.eye(len(names))
    for one in scene.quaternions:
        rows = [names.index(name) for name in one.coordinates]
        q = state[rows] / np.linalg.norm(state[rows])
        across[np.ix_(rows, rows)] -= np.outer(q, q)
    return np.asarray(across @ matrix @ across)
