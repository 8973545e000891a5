"""An engine for a body on a ball joint on a slide, right or with a fault."""

from __future__ import annotations

from typing import Any

import numpy as np

import mbcheck
from mbcheck.models.mechanism import Mechanism, mechanism
from mbcheck.reference.quaternions import matrix, of_rotation, product
from mbcheck.reference.scene import Array
from mbcheck.tests.support.engines.turning import cross_of

SLIDE = np.array([0.0, 1.0, 0.0])
"""Its direction in the world."""


class Sliding(mbcheck.Engine):
    """The foot of a spring, a slide, and a body on a ball joint on it, by their own equations.

    Attributes
    ----------
    fault : str
        What is wrong, empty if nothing is.
    """

    name, version = "sliding", "1"
    methods: tuple[mbcheck.Method, ...] = (mbcheck.Method("RK4", 4),)
    fault = text = ""
    has_mass_matrix = True

    def why_not(self, system: mbcheck.System, method: Any) -> str | None:
        """Refuse what has other joints, or stands otherwise."""
        same = system.kinds == ("slide", "slide", "ball") and not system.case.placement
        return None if same else "a foot, a slide and a ball joint only"

    def load(self, system: mbcheck.System) -> tuple[Array, Array, Array, Array]:
        """Return masses of foot and slide, the inertia tensor about the joint, m c, gravity."""
        if self.text != system.mjcf:
            self.text, self.numbers = system.mjcf, self.read(mechanism(system.mjcf))
        return self.numbers

    def read(self, whole: Mechanism) -> tuple[Array, Array, Array, Array]:
        """Return what `load` does."""
        foot, main, body = whole.bodies[1:]
        central, c = body.inertia, body.centre
        if self.fault == "products":
            central = np.diag(np.diag(central))
        self.central = central
        spread = body.mass * (c @ c * np.eye(3) - np.outer(c, c))
        masses = np.array([foot.mass + whole.joints[0].armature, main.mass + body.mass])
        sign = -1.0 if self.fault == "gravity_sign" else 1.0
        return masses, central + spread, body.mass * c, sign * whole.gravity

    def axis(self, rotation: Array) -> Array:
        """Return the direction of the slide in the frame of the body."""
        return SLIDE if self.fault == "slide_in_body" else rotation.T @ SLIDE

    def body_matrix(self, system: mbcheck.System, rotation: Array) -> Array:
        """Return the mass matrix (5, 5), for rates in the frame of the body."""
        masses, tensor, arm, _ = self.load(system)
        whole = np.zeros((5, 5))
        whole[:2, :2], whole[2:, 2:] = np.diag(masses), tensor
        if self.fault != "coupling_lost":
            whole[1, 2:] = whole[2:, 1] = cross_of(arm, self.axis(rotation))
        return whole

    def accelerations(self, system: mbcheck.System, time: float, q: Array, v: Array) -> Array:
        """Return them."""
        masses, tensor, arm, gravity = self.load(system)
        rotation, outside = np.array(matrix(q[2:])), self.fault == "world_rates"
        omega = rotation.T @ v[2:] if outside else v[2:]
        swing, axis = cross_of(omega, cross_of(omega, arm)), self.axis(rotation)
        force = system.force(time, q, v)
        force[1] += masses[1] * gravity @ SLIDE
        force[1] -= 0.0 if self.fault == "pull_lost" else axis @ swing
        force[2:] = cross_of(arm, rotation.T @ gravity)
        gyroscopic = {"gyroscopic_lost": 0 * tensor, "gyroscopic_of_centre": tensor - self.central}
        force[2:] -= cross_of(omega, gyroscopic.get(self.fault, tensor) @ omega)
        if self.fault == "transport_lost":
            force[2:] += v[1] * cross_of(axis, cross_of(omega, arm))
        a = np.linalg.solve(self.body_matrix(system, rotation), force)
        return np.append(a[:2], rotation @ a[2:]) if outside else np.asarray(a)

    def mass_matrix(self, system: mbcheck.System, q: Array) -> Array:
        """Return it, in the frame in which rates are."""
        if not self.has_mass_matrix:
            raise mbcheck.Unsupported("no mass matrix")
        rotation, turn = np.array(matrix(q[2:])), np.eye(5)
        turn[2:, 2:] = rotation if self.fault == "world_rates" else np.eye(3)
        return np.asarray(turn @ self.body_matrix(system, rotation) @ turn.T)

    def moved(self, q: Array, change: Array) -> Array:
        """Return positions after a small shift and a small rotation."""
        turn = of_rotation(change[2:])
        outside = self.fault in ("world_update", "world_rates")
        after = np.array(product(turn, q[2:]) if outside else product(q[2:], turn))
        return np.append(q[:2] + change[:2], after / np.linalg.norm(after))

    def step(
        self, system: mbcheck.System, time: float, q: Array, v: Array, h: float
    ) -> tuple[Array, Array]:
        """Return the state after a step of the fourth order, see `turning.Turning.step`."""
        side = -1.0 if self.fault in ("world_update", "world_rates") else 1.0

        def rates(share: float, u: Array, w: Array) -> tuple[Array, Array]:
            turn, bent = cross_of(u[2:], w[2:]), w.copy()
            bent[2:] += side * turn / 2 + cross_of(u[2:], turn) / 12
            return bent, self.accelerations(system, time + share * h, self.moved(q, u), w)

        u1, a1 = rates(0, np.zeros(5), v)
        u2, a2 = rates(0.5, h / 2 * u1, v + h / 2 * a1)
        u3, a3 = rates(0.5, h / 2 * u2, v + h / 2 * a2)
        u4, a4 = rates(1, h * u3, v + h * a3)
        change = h / 6 * (u1 + 2 * u2 + 2 * u3 + u4)
        return self.moved(q, change), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)

    def simulate(self, system: mbcheck.System, method: Any, step: float, times: Any) -> Any:
        """Run."""
        q, v, count, rows = system.positions, system.velocities, 0, []
        for time in times:
            while (now := system.start_time + count * step) + step / 2 < time:
                q, v = self.step(system, now, q, v, step)
                count += 1
            rows.append((np.append(q[:2], -q[2:]) if self.fault == "other_sign" else q, v))
        positions, velocities = map(np.array, zip(*rows, strict=True))
        return mbcheck.Motion(positions, velocities, times, count)


def sliding(fault: str) -> Sliding:
    """Return the engine with a fault."""
    engine = Sliding()
    engine.fault = fault
    return engine
