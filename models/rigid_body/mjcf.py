"""rigid_body as MJCF: on a ball joint, or floating freely where nothing pulls at it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ...reference.body.rotation import QUATERNION
from ...reference.rigid_body import RigidBody
from ..body import BODY, INERTIAL, ball_motion
from ..mjcf import Mjcf, Motion


def joints(p: RigidBody, time: float, state: Mapping[str, float]) -> Motion:
    """Return the motion of the ball joint."""
    return {QUATERNION.name: ball_motion(state)}


def floating(p: RigidBody, time: float, state: Mapping[str, float]) -> Motion:
    """Return the motion of the free joint: its centre of mass stays where it is."""
    position, velocity = ball_motion(state)
    still = np.zeros(3)
    return {QUATERNION.name: (np.append(still, position), np.append(still, velocity))}


def unsupported_floating(p: RigidBody) -> str | None:
    """Return the reason if the fixed point is not the centre of mass, or gravity acts."""
    if np.any(p.centre) or np.any(p.gravity):
        return "a free body needs gravity_x, _y, _z and centre_x, _y, _z of 0"
    return None


FLOATING = {
    (INERTIAL, "mass"): lambda p: p.mass,
    (INERTIAL, "quat"): lambda p: tuple(map(float, p.axes)),
    (INERTIAL, "diaginertia"): lambda p: tuple(map(float, p.moments)),
}
"""The same of the body that floats: by principal axes."""

MODELS = {
    "ball": Mjcf(
        path=Path(__file__).with_name("rigid_body.xml"),
        bindings=BODY,
        joints=joints,
    ),
    "free": Mjcf(
        path=Path(__file__).with_name("floating.xml"),
        bindings=FLOATING,
        joints=floating,
        unsupported_reason=unsupported_floating,
    ),
}
