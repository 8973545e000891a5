"""rigid_body as MJCF: on a ball joint, or floating freely where nothing pulls at it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ...reference.body.parameters import PLACES, central_inertia
from ...reference.body.rotation import COORDINATES, QUATERNION
from ...reference.quaternions import spin
from ...reference.rigid_body.equations import RigidBody
from ..mjcf import Mjcf, Motion


def joints(p: RigidBody, time: float, state: Mapping[str, float]) -> Motion:
    """Return the motion of the ball joint: a unit quaternion, and rates in the body."""
    q = np.array([state[name] for name in COORDINATES])
    rates = [state[f"{name}_dot"] for name in COORDINATES]
    return {QUATERNION.name: (q / np.linalg.norm(q), 2 * np.array(spin(q, rates)[1:]))}


def floating(p: RigidBody, time: float, state: Mapping[str, float]) -> Motion:
    """Return the motion of the free joint: its centre of mass stays where it is."""
    position, velocity = joints(p, time, state)[QUATERNION.name]
    still = np.zeros(3)
    return {QUATERNION.name: (np.append(still, position), np.append(still, velocity))}


def why_not_floating(p: RigidBody) -> str | None:
    """Say so where the fixed point is not the centre of mass, or gravity pulls."""
    if np.any(p.centre) or np.any(p.gravity):
        return "a body that floats turns about its centre of mass, and falls under gravity"
    return None


def entries(p: RigidBody) -> tuple[float, ...]:
    """Return the inertia tensor about the centre of mass as MJCF orders it."""
    tensor = central_inertia(p)
    return tuple(float(tensor[place]) for place in PLACES)


INERTIA = "body:body/inertial"

BINDINGS = {
    ("option", "gravity"): lambda p: tuple(map(float, p.gravity)),
    (INERTIA, "pos"): lambda p: tuple(map(float, p.centre)),
    (INERTIA, "mass"): lambda p: p.mass,
    (INERTIA, "fullinertia"): entries,
    ("geom:figure", "pos"): lambda p: tuple(map(float, p.centre)),
}
"""Attribute of the MJCF -> its value."""

FLOATING = {
    (INERTIA, "mass"): lambda p: p.mass,
    (INERTIA, "quat"): lambda p: tuple(map(float, p.axes)),
    (INERTIA, "diaginertia"): lambda p: tuple(map(float, p.moments)),
}
"""The same of the body that floats: by principal axes."""

MODELS = {
    "ball": Mjcf(
        path=Path(__file__).with_name("rigid_body.xml"),
        bindings=BINDINGS,
        joints=joints,
    ),
    "free": Mjcf(
        path=Path(__file__).with_name("floating.xml"),
        bindings=FLOATING,
        joints=floating,
        why_not=why_not_floating,
    ),
}
