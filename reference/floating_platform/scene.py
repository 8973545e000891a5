"""The scene `floating_platform`."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..body.floating_scene import floating_scene
from ..rotor_pendulum import SCENE as ROTOR_PENDULUM
from .cases import CASES
from .equations import (
    TREE,
    FloatingPlatform,
    coefficients,
    coefficients_of,
    damping_matrix,
    powers,
)


def keeps_energy(p: FloatingPlatform) -> bool:
    """Return whether the motor is off and the rod undamped."""
    return not np.any(p.motor_slope) and not np.any(p.rod_damping)


def period(p: FloatingPlatform) -> Any:
    """Return the time [s] of a turn of the rotor at the motor's own speed, at most 1 s."""
    return 2 * np.pi / np.maximum(np.abs(p.synchronous_speed), 2 * np.pi)


SCENE = floating_scene(
    TREE,
    coefficients_of,
    keeps_energy,
    placed=CASES[3],
    name="floating_platform",
    title="platform afloat in space with a rotor and a sprung pendulum",
    paper=ROTOR_PENDULUM.paper,
    parameters=FloatingPlatform,
    coordinates=("phi", "theta"),
    units={"phi": "rad", "theta": "rad"},
    coefficients=coefficients,
    damping_matrix=damping_matrix,
    powers=powers,
    period=period,
    unforced=lambda p: p.replace(motor_slope=0.0),
    cases=CASES,
)
