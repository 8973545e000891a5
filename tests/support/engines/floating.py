"""An engine for a base on a free joint with bodies on hinges, right or with a fault."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

import mbcheck
from mbcheck.models.mechanism import Mechanism, mechanism, turn
from mbcheck.reference.quaternions import matrix, product
from mbcheck.reference.scene import Array
from mbcheck.tests.support.engines.turning import Rotating, cross_of

OWN = slice(3, 6)
"""Angular velocity of the platform, in its frame, among velocities."""

VELOCITIES = ("velocity_of_centre", "velocity_in_body")
"""Faults by which the first three velocities are another thing."""


class Hung(NamedTuple):
    """How a body hangs on the base, in its frame, where the base does not move.

    Attributes
    ----------
    frame : array (3, 3)
        From the body's.
    origin : array (3,)
        Of that frame, at its hinge.
    path : mapping of column to (axis, origin)
        Of the hinges before it, its own included.
    around, faster : array (3,)
        Its angular velocity, and angular acceleration where no rate changes.
    velocity, bias : array (3,)
        And the same of the origin.
    """

    frame: Array
    origin: Array
    path: Mapping[int, tuple[Array, Array]]
    around: Array
    faster: Array
    velocity: Array
    bias: Array


ON_BASE = Hung(np.eye(3), np.zeros(3), {}, *np.zeros((4, 3)))


class Floating(Rotating):
    """Newton's and Euler's laws of each body, by what each velocity does to it."""

    name, version, spin = "floating", "1", OWN

    def unsupported_reason(self, system: mbcheck.System, method: Any) -> str | None:
        """Refuse what has other joints."""
        same = system.kinds[0] == "free" and {*system.kinds[1:]} == {"hinge"}
        return None if same else "a free joint and hinges only"

    def load(self, system: mbcheck.System) -> Mechanism:
        """Return what the file holds."""
        if self.text != system.mjcf:
            self.text, self.whole = system.mjcf, mechanism(system.mjcf)
        return self.whole

    def attitude(self, q: Array) -> Array:
        """Return the rotation (3, 3) from the platform's frame to the world's."""
        rotation = np.array(matrix(q[3:7]))
        return self.whole.bodies[1].rotation @ rotation if self.fault == "from_file" else rotation

    def moving(self, system: mbcheck.System, q: Array, v: Array) -> list[tuple[Any, ...]]:
        """Return mass, tensor, Jacobians (3, n) and the accelerations left at rest, of each body.

        All in the frame of the base.
        """
        self.load(system)
        rotation, hung = self.attitude(q), {1: ON_BASE}
        rows = [self.row(1, ON_BASE, rotation, v)]
        for number in range(2, len(self.whole.bodies)):
            hung[number] = self.carried(number, hung, q, v)
            rows.append(self.row(number, hung[number], rotation, v))
        return rows

    def carried(self, number: int, hung: dict[int, Hung], q: Array, v: Array) -> Hung:
        """Return how a body on a hinge hangs."""
        body = self.whole.bodies[number]
        on, column = hung[body.parent], number + 4
        own, rate = body.rotation @ self.whole.joints[body.joints[0]].axis, v[column]
        axis, arm = on.frame @ own, on.frame @ body.position
        if self.fault == "axes_as_opened" and on.path:
            axis = self.whole.bodies[body.parent].rotation @ own  # as the parent opened
        faster = on.faster
        if self.fault != "axes_still":
            faster = faster + rate * cross_of(on.around, axis)
        return Hung(
            on.frame @ turn(own, q[column + 1]) @ body.rotation,
            on.origin + arm,
            {**on.path, column: (axis, on.origin + arm)},
            on.around + rate * axis,
            faster,
            on.velocity + cross_of(on.around, arm),
            on.bias + cross_of(on.around, cross_of(on.around, arm)) + cross_of(on.faster, arm),
        )

    def row(self, number: int, hung: Hung, rotation: Array, v: Array) -> tuple[Any, ...]:
        """Return what `moving` does of one body."""
        body, omega, around = self.whole.bodies[number], v[OWN], hung.around
        arm = hung.frame @ body.centre
        place, inertia = hung.origin + arm, body.inertia
        shift, spin = np.zeros((2, 3, len(v)))
        shift[:, :3], spin[:, OWN] = rotation.T, np.eye(3)
        shift[:, OWN] = -np.array([[0, -place[2], place[1]], [place[2], 0, -place[0]],
                                   [-place[1], place[0], 0]])  # fmt: skip
        for column, (axis, origin) in hung.path.items():
            shift[:, column], spin[:, column] = cross_of(axis, place - origin), axis
        bias = hung.bias + cross_of(around, cross_of(around, arm)) + cross_of(hung.faster, arm)
        if self.fault != "coriolis_lost":
            bias = bias + 2 * cross_of(omega, hung.velocity + cross_of(around, arm))
        bias = bias + cross_of(omega, cross_of(omega, place))
        if self.fault == "products":
            inertia = np.diag(np.diag(inertia))
        tensor, whole = hung.frame @ inertia @ hung.frame.T, omega + around
        gyroscopic = tensor @ (hung.faster + cross_of(omega, around))
        gyroscopic = gyroscopic + cross_of(whole, tensor @ whole)
        if self.fault == "gyroscopic_lost" and not hung.path:
            gyroscopic = 0 * whole
        if self.fault == "spin_lost" and hung.path:
            gyroscopic = cross_of(omega, tensor @ omega)
        return body.mass, tensor, shift, spin, bias, gyroscopic

    def inertia(self, rows: list[tuple[Any, ...]]) -> Array:
        """Return the mass matrix (n, n)."""
        size = rows[0][2].shape[1]
        total = np.zeros((size, size))
        for mass, tensor, shift, spin, *_ in rows:
            total += mass * shift.T @ shift + spin.T @ tensor @ spin
        if self.fault == "coupling_lost":
            total[:6, 6:], total[6:, :6] = 0.0, 0.0
            total[6:, 6:] = np.diag(np.diag(total[6:, 6:]))
        return total

    def forces_by_fault(self, system: mbcheck.System, q: Array, v: Array, rows: list[Any]) -> Array:
        """Return what a fault adds to the generalised forces (n,), by where reactions act."""
        added, rotation = np.zeros(len(v)), self.attitude(q)
        force = system.force(0.0, q, v)
        damping = force - system.force(0.0, q, np.zeros(len(v)))
        for k, torque in enumerate(force[6:]):
            spin = rows[k + 1][3]
            axis, before = spin[:, 6 + k], rows[self.whole.bodies[k + 2].parent - 1][3]
            if self.fault == "damper_on_base":
                added[6:] += damping[6 + k] * axis @ before[:, 6:]
            on_base = not np.any(before[:, 6:])
            lost = self.fault == "reaction_of_motor_lost" and not k
            if on_base and (self.fault in ("reaction_lost", "reaction_in_world") or lost):
                added[OWN] += torque * axis
            if on_base and self.fault == "reaction_in_world":
                added[OWN] -= torque * rotation.T @ axis
        return added

    def accelerations(self, system: mbcheck.System, time: float, q: Array, v: Array) -> Array:
        """Return them."""
        v = self.taken(system, q, v)
        rows, rotation = self.moving(system, q, v), self.attitude(q)
        force = system.force(time, q, v)
        pull = rotation.T @ self.whole.gravity
        force = force + self.forces_by_fault(system, q, v, rows)
        for mass, _, shift, spin, bias, gyroscopic in rows:
            force += mass * shift.T @ (pull - bias) - spin.T @ gyroscopic
        if self.fault == "dragged":
            force[:3] -= DRAG * v[:3]
        a = np.linalg.solve(self.inertia(rows), force)
        arm = rotation @ self.whole.bodies[1].centre
        if self.fault == "velocity_of_centre":
            spin, faster = rotation @ v[OWN], rotation @ a[OWN]
            a[:3] += cross_of(faster, arm) + cross_of(spin, cross_of(spin, arm))
        if self.fault == "velocity_in_body":
            a[:3] = rotation.T @ a[:3] - cross_of(v[OWN], rotation.T @ v[:3])
        return np.asarray(a)

    def taken(self, system: mbcheck.System, q: Array, v: Array) -> Array:
        """Return velocities with that of the platform's point in the world."""
        if self.fault not in VELOCITIES:
            return v
        rotation, v = np.array(matrix(q[3:7])), v.copy()
        arm = self.load(system).bodies[1].centre
        if self.fault == "velocity_in_body":
            v[:3] = rotation @ v[:3]
        else:
            v[:3] -= rotation @ cross_of(v[OWN], arm)
        return v

    def mass_matrix(self, system: mbcheck.System, q: Array) -> Array:
        """Return it."""
        if not self.has_mass_matrix:
            raise mbcheck.Unsupported("no mass matrix")
        return self.inertia(self.moving(system, q, np.zeros(len(system.velocities))))

    def linearise(self, system: mbcheck.System) -> tuple[Array, Array, Array]:
        """Return M, C, K about rest."""
        q, size = system.positions, len(system.velocities)
        still, at = np.zeros(size), q
        if self.fault == "inertia_as_opened":
            at = np.array([*q[:3], 1.0, 0.0, 0.0, 0.0, *[OPENED] * (size - 6)])
        damping, stiffness = np.zeros((2, size, size))
        for i, unit in enumerate(np.eye(size)):
            damping[:, i] = system.force(0.0, q, still) - system.force(0.0, q, unit)
            if i > 5:
                moved = q + np.append(0.0, unit)
                stiffness[:, i] = system.force(0.0, q, still) - system.force(0.0, moved, still)
        return self.inertia(self.moving(system, at, still)), damping, stiffness

    def moved(self, q: Array, change: Array) -> Array:
        """Return positions after small shifts and a small rotation."""
        half = np.array([0.0, *(change[OWN] / 2)])
        angle = np.linalg.norm(half)
        step = np.array([np.cos(angle), *(half[1:] * np.sinc(angle / np.pi))])
        after = product(step, q[3:7]) if self.fault == "world_update" else product(q[3:7], step)
        return np.concatenate([q[:3] + change[:3], after, q[7:] + change[6:]])


DRAG = 1e-4
"""Of a fault: what brakes the platform against the world [N s/m]."""

OPENED = 0.4
"""Angle [rad] of hinges at which a fault takes the inertia."""


def floating(fault: str) -> Floating:
    """Return the engine with a fault."""
    engine = Floating()
    engine.fault = fault
    return engine
