"""An engine whose joints are taken to be in another order than that of `System.joints`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...models.system import System
from ...reference.errors import Unsupported
from ...reference.scene import Array
from .protocol import Engine, Method, Motion
from .validation import ATTRIBUTES


class Reordered(Engine):
    """Another engine, whose numbers are those of joints in some order.

    Parameters
    ----------
    inner : Engine
    order : tuple of int
        The joint that each number stands for.
    inputs_too : bool
        Whether states are given to it in this order as well.
    """

    def __init__(self, inner: Engine, order: tuple[int, ...], inputs_too: bool) -> None:
        self.inner, self.inputs_too = inner, inputs_too
        self.back = list(np.argsort(order))
        self.order = list(order) if inputs_too else list(range(len(order)))
        for name in ATTRIBUTES:
            setattr(self, name, getattr(inner, name))

    def put(self, system: System) -> System:
        """Return a system whose initial state is in the other order.

        Raises
        ------
        Unsupported
            If it has not one number for each joint.
        """
        if {len(system.positions), len(system.joints)} != {len(self.back)}:
            raise Unsupported("it has not one number for each joint")
        place = self.order
        return replace(
            system, positions=system.positions[place], velocities=system.velocities[place]
        )

    def simulate(self, system: System, method: Method, step: float, times: Array) -> Motion:
        """Integrate, and put what comes back in order."""
        motion = self.inner.simulate(self.put(system), method, step, times)
        q, v = (np.asarray(rows)[:, self.back] for rows in (motion.positions, motion.velocities))
        return replace(motion, positions=q, velocities=v)

    def accelerations(self, system: System, time: float, q: Array, v: Array) -> Array:
        """Return accelerations (n,) in order."""
        answer = self.inner.accelerations(self.put(system), time, q[self.order], v[self.order])
        return np.asarray(answer)[self.back]

    def mass_matrix(self, system: System, q: Array) -> Array:
        """Return the mass matrix (n, n) in order."""
        answer = self.inner.mass_matrix(self.put(system), q[self.order])
        return np.asarray(answer)[np.ix_(self.back, self.back)]
