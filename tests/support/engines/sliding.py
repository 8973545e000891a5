"""An engine for a body on a ball joint on a slide, right or with a fault."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

import mbcheck
from mbcheck.models.mechanism import Mechanism
from mbcheck.reference.quaternions import matrix
from mbcheck.reference.scene import Array
from mbcheck.tests.support.engines.turning import Turning, cross_of

SLIDE = np.array([0.0, 1.0, 0.0])
"""Its direction in the frame of the main mass: in the world where the model is not turned."""


class Sliding(Turning):
    """The foot of a spring, a slide, and a body on a ball joint on it, by their own equations."""

    name, spin = "sliding", slice(2, None)

    def unsupported_reason(self, system: mbcheck.System, method: Any) -> str | None:
        """Refuse what has other joints, or stands otherwise."""
        same = system.kinds == ("slide", "slide", "ball")
        return None if same else "a foot, a slide and a ball joint only"

    def read(self, whole: Mechanism) -> tuple[Array, ...]:
        """Return masses of foot and slide, the inertia tensor about the joint, m c, gravity."""
        foot, main, body = whole.bodies[1:]
        central, c = body.inertia, body.centre
        if self.fault == "products":
            central = np.diag(np.diag(central))
        self.central = central
        spread = body.mass * (c @ c * np.eye(3) - np.outer(c, c))
        masses = np.array([foot.mass + whole.joints[0].armature, main.mass + body.mass])
        sign = -1.0 if self.fault == "gravity_sign" else 1.0
        self.slide = main.rotation.T @ SLIDE if self.fault == "slide_in_world" else SLIDE
        return masses, central + spread, body.mass * c, sign * main.rotation.T @ whole.gravity

    def axis(self, rotation: Array) -> Array:
        """Return the direction of the slide in the frame of the body."""
        return SLIDE if self.fault == "slide_in_body" else rotation.T @ self.slide

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
        if self.fault == "friction_lost":
            rest = tuple(term for term in system.terms if "q" not in term.joints)
            system = replace(system, terms=rest)
        force = system.force(time, q, v)
        force[1] += masses[1] * gravity @ self.slide
        force[1] -= 0.0 if self.fault == "pull_lost" else axis @ swing
        force[2:] += cross_of(arm, rotation.T @ gravity)
        gyroscopic = {"gyroscopic_lost": 0 * tensor, "gyroscopic_of_centre": tensor - self.central}
        force[2:] -= cross_of(omega, gyroscopic.get(self.fault, tensor) @ omega)
        if self.fault == "transport_lost":
            force[2:] += v[1] * cross_of(axis, cross_of(omega, arm))
        a = np.linalg.solve(self.body_matrix(system, rotation), force)
        return np.append(a[:2], rotation @ a[2:]) if outside else np.asarray(a)

    def linearise(self, system: mbcheck.System) -> tuple[Array, Array, Array]:
        """Return M, C, K for shifts, and small rotations in the frame of the body."""
        _, _, arm, gravity = self.load(system)
        q, rotation = system.positions, np.array(matrix(system.positions[2:]))
        damping, stiffness = np.zeros((2, 5, 5))
        for i, unit in enumerate(np.eye(5)):
            damping[:, i] = -system.force(0.0, 0 * q, unit)
            stiffness[:, i] = -system.force(
                0.0, np.append(unit[:2], [1.0, 0.0, 0.0, 0.0]), 0 * unit
            )
        pull = rotation.T @ gravity
        stiffness[2:, 2:] = np.transpose([cross_of(arm, cross_of(e, pull)) for e in np.eye(3)])
        at = np.eye(3) if self.fault == "inertia_as_opened" else rotation
        return self.body_matrix(system, at), damping, stiffness

    def mass_matrix(self, system: mbcheck.System, q: Array) -> Array:
        """Return it, in the frame in which rates are."""
        if not self.has_mass_matrix:
            raise mbcheck.Unsupported("no mass matrix")
        rotation, turn = np.array(matrix(q[2:])), np.eye(5)
        turn[2:, 2:] = rotation if self.fault == "world_rates" else np.eye(3)
        return np.asarray(turn @ self.body_matrix(system, rotation) @ turn.T)


def sliding(fault: str) -> Sliding:
    """Return the engine with a fault."""
    engine = Sliding()
    engine.fault = fault
    return engine
