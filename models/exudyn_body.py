"""A rigid body in space, in Exudyn: with Euler parameters, its reference point at a joint."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ..reference.body.parameters import PLACES, BodyParameters, body_inertia
from ..reference.quaternions import product
from ..reference.scene import Array
from .exudyn_system import items

UPRIGHT = np.eye(4)[0]
"""The quaternion of no rotation, from which Exudyn's coordinates count."""
UPRIGHT.flags.writeable = False


def quaternion_turn(axes: Array) -> Array:
    """Return the matrix (4, 4) by which axes (3, 3) of a model in the world turn a quaternion."""
    x, y, z, w = Rotation.from_matrix(axes).as_quat()
    return np.array([product([w, x, y, z], unit) for unit in np.eye(4)]).T


def euler_parameters_of(q: Array, v: Array) -> tuple[Array, Array]:
    """Return the coordinates (4,) of a quaternion of any length, and their rates, for length 1."""
    size = np.linalg.norm(q)
    unit, rates = q / size, v / size
    return unit - UPRIGHT, rates - (unit @ rates) * unit


def add_body(mbs: Any, p: BodyParameters) -> tuple[Any, Any]:
    """Add a body (x, y, z, q_w, q_x, q_y, q_z); return its node and itself.

    Exudyn adds the constraint |q| = 1.
    """
    node = mbs.AddNode(items.NodeRigidBodyEP(referenceCoordinates=[0, 0, 0, *UPRIGHT]))
    tensor = body_inertia(p)
    xx, yy, zz, xy, xz, yz = (float(tensor[place]) for place in PLACES)
    body = mbs.AddObject(
        items.ObjectRigidBody(
            mass=p.mass,
            inertia=[xx, yy, zz, yz, xz, xy],
            centerOfMass=[float(part) for part in p.centre],
            nodeNumber=node,
        )
    )
    return node, body
