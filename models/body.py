"""A rigid body on a ball or free joint in MJCF: its motion, and the bindings of its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..reference.body.rotation import (
    AXES,
    COORDINATES,
    PLACES,
    QUATERNION,
    BodyParameters,
    central_inertia,
)
from ..reference.quaternions import spin
from .mjcf import Binding, Motion


def ball_motion(state: Mapping[str, float]) -> tuple[Any, Any]:
    """Return the motion of the ball joint: a unit quaternion, and rates in the body."""
    q = np.array([state[name] for name in COORDINATES])
    rates = [state[f"{name}_dot"] for name in COORDINATES]
    return q / np.linalg.norm(q), 2 * np.array(spin(q, rates)[1:])


def free_motion(hinges: Sequence[str], p: Any, time: float, state: Mapping[str, float]) -> Motion:
    """Return the motion of the free joint and of the hinges of these names."""
    attitude, rates = ball_motion(state)
    place, velocity = ([state[f"{axis}{dot}"] for axis in AXES] for dot in ("", "_dot"))
    return {
        QUATERNION.name: (np.append(place, attitude), np.append(velocity, rates)),
        **{name: (state[name], state[f"{name}_dot"]) for name in hinges},
    }


def inertia_entries(p: BodyParameters) -> tuple[float, ...]:
    """Return the inertia tensor about the centre of mass as MJCF orders it."""
    tensor = central_inertia(p)
    return tuple(float(tensor[place]) for place in PLACES)


INERTIAL = "body:body/inertial"

BODY: Mapping[tuple[str, str], Binding] = {
    ("option", "gravity"): lambda p: tuple(map(float, p.gravity)),
    (INERTIAL, "pos"): lambda p: tuple(map(float, p.centre)),
    (INERTIAL, "mass"): lambda p: p.mass,
    (INERTIAL, "fullinertia"): inertia_entries,
    ("geom:figure", "pos"): lambda p: tuple(map(float, p.centre)),
}
"""Attribute of the MJCF -> its value: of the body called `body`, and of gravity."""
