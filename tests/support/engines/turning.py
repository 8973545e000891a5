"""An engine for a body on a ball joint, right or with one of the faults that engines have had."""

from __future__ import annotations

from typing import Any

import numpy as np

import mbcheck
from mbcheck.models.mechanism import Mechanism, mechanism
from mbcheck.reference.quaternions import cross, matrix, of_rotation, product
from mbcheck.reference.scene import Array

LARGEST_RATE, LEAST_MOMENT = 50.0, 1e-3
"""Rate [rad/s] that an engine limits bodies to, and moment [N m] below which one takes a body to be
in equilibrium."""

SIDES = {"world_update": -1.0, "world_rates": -1.0, "order_two": 0.0, "not_normalised": 0.0}
"""Sign of u in the rate of the rotation vector u, 0 where it is left out, by fault."""


class Rotating(mbcheck.Engine):
    """Runs of a mechanism with one rotation in space, by equations that a subclass has.

    Attributes
    ----------
    fault : str
        What is wrong, empty if nothing is.
    spin : slice
        Where the angular velocity stands among the velocities.
    """

    methods: tuple[mbcheck.Method, ...] = (mbcheck.Method("RK4", 4),)
    fault = text = ""
    has_mass_matrix = True
    spin = slice(0, None)

    def moved(self, q: Array, change: Array) -> Array:
        """Return positions after small shifts and a small rotation."""
        raise NotImplementedError

    def taken(self, system: mbcheck.System, q: Array, v: Array) -> Array:
        """Return what the positions change by."""
        return v

    def step(
        self, system: mbcheck.System, time: float, q: Array, v: Array, h: float
    ) -> tuple[Array, Array]:
        """Return the state after a step of the fourth order.

        Runge and Kutta's, of the rotation vector within the step (Munthe-Kaas): its rate is
        ``omega + u x omega / 2 + u x (u x omega) / 12``, u x reversed for rates of the world.
        """
        side = SIDES.get(self.fault, 1.0)

        def rates(share: float, u: Array, w: Array) -> tuple[Array, Array]:
            at = self.moved(q, u)
            bent, around = self.taken(system, at, w).copy(), u[self.spin]
            turn = cross_of(around, w[self.spin])
            bent[self.spin] += side * turn / 2 + side * side * cross_of(around, turn) / 12
            return bent, self.accelerations(system, time + share * h, at, w)

        u1, a1 = rates(0.0, np.zeros(len(v)), v)
        u2, a2 = rates(0.5, h / 2 * u1, v + h / 2 * a1)
        u3, a3 = rates(0.5, h / 2 * u2, v + h / 2 * a2)
        u4, a4 = rates(1.0, h * u3, v + h * a3)
        return (
            self.moved(q, h / 6 * (u1 + 2 * u2 + 2 * u3 + u4)),
            v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4),
        )

    def simulate(self, system: mbcheck.System, method: Any, step: float, times: Any) -> Any:
        """Run."""
        q, v, count, rows = system.positions, system.velocities, 0, []
        for time in times:
            while (now := system.start_time + count * step) + step / 2 < time:
                q, v = self.step(system, now, q, v, step)
                count += 1
            rows.append((self.shown(q), v))
        positions, velocities = map(np.array, zip(*rows, strict=True))
        return mbcheck.Motion(positions, velocities, times, count)

    def shown(self, q: Array) -> Array:
        """Return positions as a run tells them."""
        return q


class Turning(Rotating):
    """A body that turns about a fixed point, by its own equations.

    Positions and rates of slides stand before those of the ball joint.
    """

    name, version, spin = "turning", "1", slice(0, None)

    def unsupported_reason(self, system: mbcheck.System, method: Any) -> str | None:
        """Refuse what has other joints."""
        return None if system.kinds == ("ball",) else "one ball joint only"

    def load(self, system: mbcheck.System) -> tuple[Array, ...]:
        """Return the inertia tensor about the joint, m c, and gravity."""
        if self.text != system.mjcf:
            self.text, self.numbers = system.mjcf, self.read(mechanism(system.mjcf))
        return self.numbers

    def read(self, whole: Mechanism) -> tuple[Array, ...]:
        """Return what `load` does."""
        body, gravity = whole.bodies[1], whole.gravity
        central, c = body.inertia, body.centre
        if self.fault == "products":
            central = np.diag(np.diag(central))
        gravity = {"gravity_sign": -1.0, "gravity_size": 1.01}.get(self.fault, 1.0) * gravity
        if self.fault != "world_attitude":
            gravity = body.rotation.T @ gravity
        spread = body.mass * (c @ c * np.eye(3) - np.outer(c, c))
        if self.fault == "parallel_axes":
            spread = np.diag(np.diag(spread))
        return central + spread, body.mass * c, gravity

    def tensor(self, inertia: Array, rotation: Array) -> Array:
        """Return the inertia tensor in the frame of the body."""
        return rotation.T @ inertia @ rotation if self.fault == "standing_tensor" else inertia

    def faster(self, system: mbcheck.System, q: Array, omega: Array) -> Array:
        """Return the angular acceleration in the frame of the body."""
        inertia, arm, gravity = self.load(system)
        rotation = np.array(matrix(q))
        tensor = self.tensor(inertia, rotation)
        if self.fault == "world_rates":
            outside = rotation @ tensor @ rotation.T
            moment = cross_of(rotation @ arm, gravity) - cross_of(omega, outside @ omega)
            return np.asarray(np.linalg.solve(outside, moment))
        pull = gravity if self.fault == "gravity_frame" else rotation.T @ gravity
        sign = {"gyroscopic_lost": 0.0, "standing_tensor": 0.0, "gyroscopic_sign": -1.0}
        gyroscopic = sign.get(self.fault, 1.0) * cross_of(omega, tensor @ omega)
        moment = cross_of(arm, pull) - gyroscopic
        if self.fault == "coarse_tolerance" and np.linalg.norm(moment) < LEAST_MOMENT:
            moment = np.zeros(3)
        return np.asarray(np.linalg.solve(tensor, moment))

    def accelerations(self, system: mbcheck.System, time: float, q: Array, v: Array) -> Array:
        """Return them."""
        return self.faster(system, q, v)

    def mass_matrix(self, system: mbcheck.System, q: Array) -> Array:
        """Return the inertia tensor, in the frame in which rates are."""
        if not self.has_mass_matrix:
            raise mbcheck.Unsupported("no mass matrix")
        rotation = np.array(matrix(q))
        tensor = self.tensor(self.load(system)[0], rotation)
        return rotation @ tensor @ rotation.T if self.fault == "world_rates" else tensor

    def linearise(self, system: mbcheck.System) -> tuple[Array, Array, Array]:
        """Return M, C, K for small rotations in the frame of the body."""
        inertia, arm, gravity = self.load(system)
        pull = np.array(matrix(system.positions)).T @ gravity
        stiffness = [cross_of(arm, cross_of(axis, pull)) for axis in np.eye(3)]
        share = 0.0 if self.fault == "weight_that_stands" else 1.0
        return inertia, np.zeros((3, 3)), share * np.array(stiffness).T

    def moved(self, q: Array, change: Array) -> Array:
        """Return positions after small shifts and a small rotation."""
        first = self.spin.start
        shift, turn, vector = q[:first] + change[:first], q[first:], change[first:]
        if self.fault == "not_normalised":
            after = turn + np.array(product(turn, [0.0, *(vector / 2)]))
            return np.append(shift, after)
        step = of_rotation(vector)
        outside = self.fault in ("world_update", "world_rates")
        after = np.array(product(step, turn) if outside else product(turn, step))
        return np.append(shift, after / np.linalg.norm(after))

    def step(
        self, system: mbcheck.System, time: float, q: Array, v: Array, h: float
    ) -> tuple[Array, Array]:
        """Return the state after a step, its rates no larger than a fault lets them be."""
        q, v = super().step(system, time, q, v, h)
        if self.fault == "largest_rate":
            v = v * min(1.0, LARGEST_RATE / float(np.linalg.norm(v)))
        return q, v

    def shown(self, q: Array) -> Array:
        """Return positions, the quaternion with the sign that a fault gives it."""
        side = -1.0 if self.fault == "other_sign" else 1.0
        first = self.spin.start
        return np.append(q[:first], side * q[first:])


def cross_of(a: Any, b: Any) -> Array:
    """Return a cross product, faster than NumPy's."""
    return np.array(cross(a, b))


def turning(fault: str) -> Turning:
    """Return the engine with a fault."""
    engine = Turning()
    engine.fault = fault
    return engine
