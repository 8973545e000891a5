"""ball_hoop as an Exudyn model: a mass on a slide, and a body with Euler parameters."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...reference.ball_hoop import BallHoop, coefficients
from ...reference.scene import Array
from ..exudyn_body import UPRIGHT, add_body, euler_parameters_of
from ..exudyn_system import UPRIGHT as AXES
from ..exudyn_system import ExudynSystem, Model, exudyn, harmonic_load, items, weigh
from ..placement import turn_quaternion


def euler_parameters(p: BallHoop, axes: Array = AXES) -> ExudynSystem:
    """Return y of the main mass, and (x, y, z, q_w, q_x, q_y, q_z) of the body.

    The reference point of the body is held at the main mass by a spherical joint. ``axes`` (3, 3)
    are the model's in the world.
    """
    turn = turn_quaternion(axes)
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    main_node = mbs.AddNode(items.Node1D(referenceCoordinates=[0]))
    main = mbs.AddObject(
        items.ObjectMass1D(
            mass=p.main_mass,
            nodeNumber=main_node,
            referenceRotation=axes[:, [1, 2, 0]],  # it slides along the first
        )
    )
    _, body = add_body(mbs, p)
    ground, slide = (
        mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=0))
        for node in (mbs.AddNode(items.NodePointGround()), main_node)
    )
    mbs.AddObject(
        items.ObjectConnectorCoordinateSpringDamper(
            markerNumbers=[ground, slide], stiffness=p.stiffness, damping=p.damping
        )
    )
    ends = [mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=one)) for one in (main, body)]
    mbs.AddObject(items.ObjectJointSpherical(markerNumbers=ends))
    frames = [mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=one)) for one in (main, body)]
    mbs.AddObject(
        items.ObjectConnectorRigidBodySpringDamper(
            markerNumbers=frames, damping=p.joint_damping * np.diag([0, 0, 0, 1, 1, 1])
        )
    )
    weigh(mbs, (body,), list(axes @ p.gravity))
    mbs.AddLoad(items.LoadCoordinate(markerNumber=slide, load=p.main_mass * float(p.gravity[1])))
    c = coefficients(p)
    functions = harmonic_load(mbs, slide, c.force, c.omega)
    mbs.Assemble()

    def place(q: Array, v: Array) -> tuple[Array, Array]:
        attitude, rates = euler_parameters_of(turn @ q[1:], turn @ v[1:])
        shift, speed = ([one[0], *(one[0] * axes[:, 1])] for one in (q, v))
        return np.concatenate([shift, attitude]), np.concatenate([speed, rates])

    readout = np.zeros((5, 8))
    readout[0, 0], readout[1:, 4:] = 1.0, turn.T
    origin = np.append(0.0, turn.T @ UPRIGHT)
    return ExudynSystem(mbs, place, readout, container, functions, origin=origin)


MODELS: Mapping[str, Model] = {
    "euler_parameters": Model(euler_parameters, constrained=True, in_axes=euler_parameters)
}
"""Models by name, default first."""
