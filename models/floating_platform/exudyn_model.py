"""floating_platform as an Exudyn model: three bodies with Euler parameters, two hinges."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...reference.floating_platform.equations import FloatingPlatform
from ...reference.quaternions import of_rotation, product
from ...reference.scene import Array
from ..exudyn_body import (
    UPRIGHT,
    add_body,
    add_hinge,
    add_rigid_body,
    carried,
    euler_parameters_of,
)
from ..exudyn_system import UPRIGHT as AXES
from ..exudyn_system import ExudynSystem, Hinge, Model, exudyn, weigh
from ..placement import turn_quaternion


def hinges(p: FloatingPlatform) -> tuple[Hinge, Hinge]:
    """Return those of rotor and rod on the platform, at the angles of their coordinates."""
    tilt = of_rotation([p.tilt, 0, 0])
    ahead = np.array(product(tilt, of_rotation([0, 0, p.installation_angle])))
    return (
        Hinge(3, np.array([0, 0, p.rotor_height]), UPRIGHT, (3, 10)),
        Hinge(4, np.array([p.rod_place, 0, 0]), ahead, (3, 17)),
    )


def euler_parameters(p: FloatingPlatform, axes: Array = AXES) -> ExudynSystem:
    """Return (x, y, z, q_w, q_x, q_y, q_z) of platform, rotor and rod, these from their hinges.

    ``axes`` (3, 3) are the model's in the world.
    """
    turn, both = turn_quaternion(axes), hinges(p)
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    _, platform = add_body(mbs, p)
    off = p.rotor_mass * p.eccentricity**2, p.rod_mass * p.rod_length**2
    moments = np.array([[p.cross_moment, p.cross_moment, p.polar_moment], [p.rod_moment] * 3])
    (_, rotor), (_, rod) = (
        add_rigid_body(mbs, mass, (arm, 0, 0), np.diag(own + np.array([0, more, more])))
        for mass, arm, own, more in zip(
            (p.rotor_mass, p.rod_mass), (p.eccentricity, p.rod_length), moments, off, strict=True
        )
    )
    motor = {"damping": p.motor_slope, "velocityOffset": p.synchronous_speed}
    add_hinge(mbs, (platform, rotor), both[0], **motor)
    add_hinge(mbs, (platform, rod), both[1], stiffness=p.rod_stiffness, damping=p.rod_damping)
    weigh(mbs, (platform, rotor, rod), list(axes @ p.gravity))
    mbs.Assemble()

    def place(q: Array, v: Array) -> tuple[Array, Array]:
        attitude, rates = euler_parameters_of(turn @ q[5:], turn @ v[5:])
        body = np.append(axes @ q[:3], attitude), np.append(axes @ v[:3], rates)
        angles = zip(both, q[3:5], v[3:5], strict=True)
        moved = [body, *(carried(hinge, body, angle, rate) for hinge, angle, rate in angles)]
        coordinates, speeds = zip(*moved, strict=True)
        return np.concatenate(coordinates), np.concatenate(speeds)

    readout = np.zeros((9, 21))
    readout[:3, :3], readout[5:, 3:7] = axes.T, turn.T
    origin = np.append(np.zeros(5), turn.T @ UPRIGHT)
    return ExudynSystem(mbs, place, readout, container, origin=origin, hinges=both)


MODELS: Mapping[str, Model] = {
    "euler_parameters": Model(euler_parameters, constrained=True, in_axes=euler_parameters)
}
"""Models by name, default first."""
