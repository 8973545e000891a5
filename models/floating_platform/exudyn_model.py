"""floating_platform as an Exudyn model: three bodies with Euler parameters, two hinges."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...reference.floating_platform import FloatingPlatform
from ...reference.quaternions import of_rotation, product
from ...reference.scene import Array
from ..exudyn_body import UPRIGHT, HingedBody, floating_system
from ..exudyn_system import UPRIGHT as AXES
from ..exudyn_system import ExudynSystem, Model


def rods(p: FloatingPlatform) -> tuple[HingedBody, HingedBody]:
    """Return rotor and rod, at the angles of their coordinates."""
    tilt = of_rotation([p.tilt, 0, 0])
    ahead = np.array(product(tilt, of_rotation([0, 0, p.installation_angle])))
    motor = {"damping": p.motor_slope, "velocityOffset": p.synchronous_speed}
    spring = {"stiffness": p.rod_stiffness, "damping": p.rod_damping}
    disc = np.array([p.cross_moment, p.cross_moment, p.polar_moment])
    up, along = np.array([0, 0, p.rotor_height]), np.array([p.rod_place, 0, 0])
    return (
        HingedBody(0, p.rotor_mass, p.eccentricity, disc, up, UPRIGHT, motor),
        HingedBody(0, p.rod_mass, p.rod_length, np.full(3, p.rod_moment), along, ahead, spring),
    )


def euler_parameters(p: FloatingPlatform, axes: Array = AXES) -> ExudynSystem:
    """Return platform, rotor and rod, in axes (3, 3) in the world."""
    return floating_system(p, rods(p), axes)


MODELS: Mapping[str, Model] = {
    "euler_parameters": Model(euler_parameters, constrained=True, in_axes=euler_parameters)
}
"""Models by name, default first."""
