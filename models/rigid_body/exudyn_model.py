"""rigid_body as an Exudyn model: a body with Euler parameters, held at a point."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...reference.rigid_body.equations import RigidBody
from ...reference.scene import Array
from ..exudyn_body import UPRIGHT, add_body, euler_parameters_of
from ..exudyn_system import ExudynSystem, Model, exudyn, items, weigh


def euler_parameters(p: RigidBody) -> ExudynSystem:
    """Return a body in space, (x, y, z, q_w, q_x, q_y, q_z), with its reference point held.

    Exudyn's coordinates count from the reference coordinates, those of no rotation.
    """
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    node, body = add_body(mbs, p)
    ground = mbs.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0)
    )
    for coordinate in range(3):
        marker = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[ground, marker]))
    weigh(mbs, (body,), [float(part) for part in p.gravity])
    mbs.Assemble()

    still = np.zeros(3)

    def place(q: Array, v: Array) -> tuple[Array, Array]:
        turn, rates = euler_parameters_of(q, v)
        return np.concatenate([still, turn]), np.concatenate([still, rates])

    return ExudynSystem(mbs, place, np.eye(7)[3:], container, origin=UPRIGHT)


MODELS: Mapping[str, Model] = {"euler_parameters": Model(euler_parameters, constrained=True)}
"""Models by name, default first."""
