"""floating_beam as an Exudyn model: four bodies with Euler parameters in a chain."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...reference.floating_beam import FloatingBeam
from ...reference.quaternions import of_rotation
from ...reference.scene import Array
from ..exudyn_body import UPRIGHT, HingedBody, floating_system
from ..exudyn_system import UPRIGHT as AXES
from ..exudyn_system import ExudynSystem, Model


def rods(p: FloatingBeam) -> list[HingedBody]:
    """Return the rods, each on the one before it."""
    rods, twist = [], np.array(of_rotation([p.twist, 0, 0]))
    for k, ((mass, arm, across), stiffness) in enumerate(zip(p.rods, p.springs, strict=True)):
        moments = np.array([p.polar_moment, across, across])
        place = np.array([p.rod_length if k else p.hub_radius, 0, 0])
        spring = {"stiffness": stiffness, "damping": p.hinge_damping}
        rods.append(HingedBody(k, mass, arm, moments, place, twist if k else UPRIGHT, spring))
    return rods


def euler_parameters(p: FloatingBeam, axes: Array = AXES) -> ExudynSystem:
    """Return hub and rods, in axes (3, 3) in the world."""
    return floating_system(p, rods(p), axes)


MODELS: Mapping[str, Model] = {
    "euler_parameters": Model(euler_parameters, constrained=True, in_axes=euler_parameters)
}
"""Models by name, default first."""
