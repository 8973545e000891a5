"""rigid_body as an Exudyn model: a body with Euler parameters, held at a point."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...reference.rigid_body import RigidBody
from ...reference.scene import Array
from ..exudyn_body import UPRIGHT, add_body, euler_parameters_of
from ..exudyn_system import UPRIGHT as AXES
from ..exudyn_system import ExudynSystem, Model, exudyn, items, weigh
from ..placement import turn_quaternion


def euler_parameters(p: RigidBody, axes: Array = AXES) -> ExudynSystem:
    """Return a body in space, (x, y, z, q_w, q_x, q_y, q_z), with its reference point held.

    Exudyn's coordinates count from the reference coordinates, those of no rotation. ``axes`` (3, 3)
    are the model's in the world; the scene's quaternion is from the frame of the body to those.
    """
    turn = turn_quaternion(axes)
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    node, body = add_body(mbs, p)
    ground = mbs.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0)
    )
    for coordinate in range(3):
        marker = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[ground, marker]))
    weigh(mbs, (body,), list(axes @ p.gravity))
    mbs.Assemble()

    still = np.zeros(3)

    def place(q: Array, v: Array) -> tuple[Array, Array]:
        attitude, rates = euler_parameters_of(turn @ q, turn @ v)
        return np.concatenate([still, attitude]), np.concatenate([still, rates])

    readout = np.hstack([np.zeros((4, 3)), turn.T])
    return ExudynSystem(mbs, place, readout, container, origin=turn.T @ UPRIGHT)


MODELS: Mapping[str, Model] = {
    "euler_parameters": Model(euler_parameters, constrained=True, in_axes=euler_parameters)
}
"""Models by name, default first."""
