"""ball_hoop as an Exudyn model: a mass point on a slide, and a body with Euler parameters."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...reference.ball_hoop.equations import BallHoop, coefficients
from ...reference.scene import Array
from ..exudyn_body import UPRIGHT, add_body, euler_parameters_of
from ..exudyn_system import ExudynSystem, Model, exudyn, harmonic_load, items, weigh


def euler_parameters(p: BallHoop) -> ExudynSystem:
    """Return (x, y, z) of the main mass, and (x, y, z, q_w, q_x, q_y, q_z) of the body.

    The reference point of the body is held at the main mass by a spherical joint.
    """
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    main_node = mbs.AddNode(items.NodePoint(referenceCoordinates=[0, 0, 0]))
    main = mbs.AddObject(items.ObjectMassPoint(mass=p.main_mass, nodeNumber=main_node))
    _, body = add_body(mbs, p)
    ground, across, slide, along = (
        mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        for node, coordinate in (
            (mbs.AddNode(items.NodePointGround()), 0),
            (main_node, 0),
            (main_node, 1),
            (main_node, 2),
        )
    )
    for fixed in (across, along):
        mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[ground, fixed]))
    mbs.AddObject(
        items.ObjectConnectorCoordinateSpringDamper(
            markerNumbers=[ground, slide], stiffness=p.stiffness, damping=p.damping
        )
    )
    ends = [mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=one)) for one in (main, body)]
    mbs.AddObject(items.ObjectJointSpherical(markerNumbers=ends))
    weigh(mbs, (main, body), [float(part) for part in p.gravity])
    c = coefficients(p)
    functions = harmonic_load(mbs, slide, c.force, c.omega)
    mbs.Assemble()

    def place(q: Array, v: Array) -> tuple[Array, Array]:
        shift, speed = np.zeros((2, 3))
        shift[1], speed[1] = q[0], v[0]
        turn, rates = euler_parameters_of(q[1:], v[1:])
        return np.concatenate([shift, shift, turn]), np.concatenate([speed, speed, rates])

    readout = np.eye(10)[[1, 6, 7, 8, 9]]
    origin = np.append(0.0, UPRIGHT)
    return ExudynSystem(mbs, place, readout, container, functions, origin=origin)


MODELS: Mapping[str, Model] = {"euler_parameters": Model(euler_parameters, constrained=True)}
"""Models by name, default first."""
