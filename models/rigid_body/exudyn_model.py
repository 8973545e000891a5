"""rigid_body as an Exudyn model: a body with Euler parameters, held at a point."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from ...reference.body.parameters import PLACES, body_inertia
from ...reference.quaternions import product
from ...reference.rigid_body.equations import RigidBody
from ...reference.scene import Array
from ..exudyn_system import UPRIGHT, ExudynSystem, Model, exudyn, items


def euler_parameters(p: RigidBody, axes: Array = UPRIGHT) -> ExudynSystem:
    """Return a body in space, (x, y, z, q_w, q_x, q_y, q_z), with its reference point held.

    Exudyn adds the constraint |q| = 1. Its coordinates count from the reference coordinates, those
    of no rotation. ``axes`` (3, 3) are the model's in the world; the quaternion of the scene is
    from the frame of the body to those.
    """
    x, y, z, w = Rotation.from_matrix(axes).as_quat()
    turn = np.array([product([w, x, y, z], unit) for unit in np.eye(4)]).T
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
    mbs.AddLoad(items.LoadMassProportional(markerNumber=weight, loadVector=list(axes @ p.gravity)))
    mbs.Assemble()

    still, reference = np.zeros(3), np.eye(4)[0]

    def place(q: Array, v: Array) -> tuple[Array, Array]:
        return np.concatenate([still, turn @ q - reference]), np.concatenate([still, turn @ v])

    readout = np.hstack([np.zeros((4, 3)), turn.T])
    return ExudynSystem(mbs, place, readout, container, origin=turn.T @ reference)


MODELS: Mapping[str, Model] = {
    "euler_parameters": Model(euler_parameters, constrained=True, in_axes=euler_parameters)
}
"""Models by name, default first."""
