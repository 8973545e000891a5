"""A rigid body on a ball joint in MJCF: how it moves, and where its numbers stand."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..reference.body.parameters import PLACES, BodyParameters, central_inertia
from ..reference.body.rotation import COORDINATES
from ..reference.quaternions import spin
from .mjcf import Binding


def ball_motion(state: Mapping[str, float]) -> tuple[Any, Any]:
    """Return the motion of the ball joint: a unit quaternion, and rates in the body."""
    q = np.array([state[name] for name in COORDINATES])
    rates = [state[f"{name}_dot"] for name in COORDINATES]
    return q / np.linalg.norm(q), 2 * np.array(spin(q, rates)[1:])


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
