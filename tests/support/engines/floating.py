"""An engine for a platform on a free joint with bodies on hinges, right or with a fault."""

from __future__ import annotations

from typing import Any

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


class Floating(Rotating):
    """Newton's and Euler's laws of each body, by what each velocity does to it."""

    name, version, spin = "floating", "1", OWN

    def why_not(self, system: mbcheck.System, method: Any) -> str | None:
        """Refuse what has other joints."""
        same = system.kinds == ("free", "hinge", "hinge")
        return None if same else "a free joint and two hinges only"

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
        """Return mass, tensor, Jacobians (3, 8) and the accelerations left at rest, of each body.

        All in the frame of the platform.
        """
        base, *others = self.load(system).bodies[1:]
        rotation, omega = self.attitude(q), v[OWN]
        rows = []
        for k, body in enumerate((base, *others)):
            frame, place = np.eye(3), body.centre
            shift, spin = np.zeros((2, 3, 8))
            shift[:, :3], spin[:, OWN] = rotation.T, np.eye(3)
            bias, twist = np.zeros((2, 3))
            if k:
                axis = body.rotation @ self.whole.joints[body.joints[0]].axis
                frame = turn(axis, q[6 + k]) @ body.rotation
                arm = frame @ body.centre
                place, rate = body.position + arm, v[5 + k]
                shift[:, 5 + k], spin[:, 5 + k] = cross_of(axis, arm), axis
                if self.fault != "coriolis_lost":
                    bias = 2 * rate * cross_of(omega, shift[:, 5 + k])
                bias, twist = bias - rate * rate * arm, rate * cross_of(omega, axis)
            shift[:, OWN] = -np.array([[0, -place[2], place[1]], [place[2], 0, -place[0]],
                                       [-place[1], place[0], 0]])  # fmt: skip
            bias = bias + cross_of(omega, cross_of(omega, place))
            inertia = body.inertia
            if self.fault == "products":
                inertia = np.diag(np.diag(inertia))
            tensor = frame @ inertia @ frame.T
            whole = spin @ v
            gyroscopic = tensor @ twist + cross_of(whole, tensor @ whole)
            if self.fault == "gyroscopic_lost" and not k:
                gyroscopic = 0 * whole
            if self.fault == "spin_lost" and k:
                gyroscopic = cross_of(omega, tensor @ omega)
            rows.append((body.mass, tensor, shift, spin, bias, gyroscopic))
        return rows

    def inertia(self, rows: list[tuple[Any, ...]]) -> Array:
        """Return the mass matrix (8, 8)."""
        total = np.zeros((8, 8))
        for mass, tensor, shift, spin, *_ in rows:
            total += mass * shift.T @ shift + spin.T @ tensor @ spin
        if self.fault == "coupling_lost":
            total[:6, 6:], total[6:, :6] = 0.0, 0.0
            total[6, 7] = total[7, 6] = 0.0
        return total

    def accelerations(self, system: mbcheck.System, time: float, q: Array, v: Array) -> Array:
        """Return them."""
        v = self.taken(system, q, v)
        rows, rotation = self.moving(system, q, v), self.attitude(q)
        force = system.force(time, q, v)
        pull = rotation.T @ self.whole.gravity
        for k, torque in enumerate(force[6:]):
            axis = rows[k + 1][3][:, 6 + k]
            if self.fault in ("reaction_lost", "reaction_in_world") or (
                self.fault == "reaction_of_motor_lost" and not k
            ):
                force[OWN] += torque * axis
            if self.fault == "reaction_in_world":
                force[OWN] -= torque * rotation.T @ axis
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
        return self.inertia(self.moving(system, q, np.zeros(8)))

    def linearise(self, system: mbcheck.System) -> tuple[Array, Array, Array]:
        """Return M, C, K about rest."""
        q, still = system.positions, np.zeros(8)
        at = q if self.fault != "inertia_as_opened" else np.append(q[:7], [0.0, 0.0])
        if self.fault == "inertia_as_opened":
            at = np.array([*q[:3], 1.0, 0.0, 0.0, 0.0, *OPENED])
        damping, stiffness = np.zeros((2, 8, 8))
        for i, unit in enumerate(np.eye(8)):
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

OPENED = (0.4, 0.4)
"""Angles [rad] of hinges at which a fault takes the inertia."""


def floating(fault: str) -> Floating:
    """Return the engine with a fault."""
    engine = Floating()
    engine.fault = fault
    return engine
