"""rigid_body as an Exudyn model: a body with Euler parameters, held at a point."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...reference.body.parameters import PLACES, body_inertia
from ...reference.rigid_body.equations import RigidBody
from ...reference.scene import Array
from ..exudyn_system import ExudynSystem, Model, exudyn, items

UPRIGHT = np.eye(4)[0]
"""The quaternion of no rotation."""
UPRIGHT.flags.writeable = False


def euler_parameters(p: RigidBody) -> ExudynSystem:
    """Return a body in space, (x, y, z, q_w, q_x, q_y, q_z), with its reference point held.

    Exudyn adds the constraint |q| = 1. Its coordinates count from the reference coordinates, those
    of no rotation.
    """
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    node = mbs.AddNode(items.NodeRigidBodyEP(referenceCoordinates=[0, 0, 0, 1, 0, 0, 0]))
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
    ground = mbs.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0)
    )
    for coordinate in range(3):
        marker = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[ground, marker]))
    weight = mbs.AddMarker(items.MarkerBodyMass(bodyNumber=body))
    mbs.AddLoad(
        items.LoadMassProportional(
            markerNumber=weight, loadVector=[float(part) for part in p.gravity]
        )
    )
    mbs.Assemble()

    still = np.zeros(3)

    def place(q: Array, v: Array) -> tuple[Array, Array]:
        return np.concatenate([still, q - UPRIGHT]), np.concatenate([still, v])

    return ExudynSystem(mbs, place, np.eye(7)[3:], container, origin=UPRIGHT)


MODELS: Mapping[str, Model] = {"euler_parameters": Model(euler_parameters, constrained=True)}
"""Models by name, default first."""
