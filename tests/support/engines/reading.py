"""An engine that reads MJCF as `models.mechanism` does, and makes something else of it."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

import mbcheck
from mbcheck.models.kinematics import (
    gap_drift,
    gap_jacobian,
    inertial_force,
    mass_matrix,
    weight,
)
from mbcheck.models.mechanism import Mechanism, mechanism
from mbcheck.reference.scene import Array


def same(one: Any) -> Any:
    """Return what is given."""
    return one


class Reader(mbcheck.Engine):
    """Equations of motion of a mechanism, with loops that hold exactly.

    Attributes
    ----------
    change : callable
        Mechanism that it has in place of the file's.
    system : callable
        System that forces are taken from in place of the one that it is given.
    push : callable
        Force (n,) of time, positions and velocities that it adds.
    inertia : callable
        Mass matrix (n, n) in place of the mechanism's, by positions.
    """

    name, version, methods = "reader", "1", (mbcheck.Method("RK4", 4),)

    def __init__(
        self,
        change: Callable[[Mechanism], Mechanism] = same,
        system: Callable[[Any], Any] = same,
        push: Callable[[float, Array, Array], Any] = lambda time, q, v: 0.0,
        inertia: Callable[[Array, Array], Array] = lambda matrix, q: matrix,
    ) -> None:
        self.read = lru_cache(lambda text: change(mechanism(text)))
        self.system, self.push, self.inertia = system, push, inertia

    def simulate(self, *asked: Any) -> mbcheck.Motion:
        """Refuse to."""
        raise mbcheck.Unsupported("no runs")

    def mass_matrix(self, system: Any, q: Array) -> Array:
        """Return the mass matrix (n, n)."""
        return self.inertia(mass_matrix(self.read(system.mjcf), q), q)

    def drift(self, whole: Mechanism, q: Array, v: Array) -> Array:
        """Return the accelerations of the loops' gaps (3 l,) where no joint accelerates."""
        return gap_drift(whole, q, v)

    def accelerations(self, system: Any, time: float, q: Array, v: Array) -> Array:
        """Return accelerations (n,), by Lagrange's multipliers where there are loops."""
        whole = self.read(system.mjcf)
        mass = self.inertia(mass_matrix(whole, q), q)
        force = self.system(system).force(time, q, v) - inertial_force(whole, q, v)
        force = force + weight(whole, q, whole.gravity) + self.push(time, q, v)
        if not whole.closures:
            return np.asarray(np.linalg.solve(mass, force))
        jacobian, n = gap_jacobian(whole, q), len(v)
        held = np.block([[mass, jacobian.T], [jacobian, np.zeros([len(jacobian)] * 2)]])
        right = np.concatenate([force, -self.drift(whole, q, v)])
        return np.asarray(np.linalg.lstsq(held, right, rcond=None)[0][:n])


class Unweighed(Reader):
    """A reader that gives accelerations alone."""

    mass_matrix = mbcheck.Engine.mass_matrix  # type: ignore[assignment]
