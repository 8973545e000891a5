"""The hula hoop in space, in Exudyn: what a third dimension costs."""

from __future__ import annotations

import numpy as np

from ...reference.hula_hoop.equations import HulaHoop, coefficients
from ...reference.scene import Array
from ..exudyn_system import ExudynSystem, Model, exudyn, harmonic_load, items, weigh
from .exudyn_model import centre_inertia


def spatial(p: HulaHoop) -> ExudynSystem:
    """Return a mass point and a body in space, (x, y, z, x_f, y_f, z_f, three angles), joined.

    The plane model's bodies with all the coordinates that bodies have, and 7 constraints in
    place of 3: the slide, a spherical joint, and no rotation about x and y.
    """
    c, radius, about = coefficients(p), p.rod_length, centre_inertia(p)
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    main_node = mbs.AddNode(items.NodePoint(referenceCoordinates=[0, 0, 0]))
    free_node = mbs.AddNode(items.NodeRigidBodyRxyz(referenceCoordinates=[radius, *(0,) * 5]))
    main = mbs.AddObject(items.ObjectMassPoint(mass=p.main_mass, nodeNumber=main_node))
    free = mbs.AddObject(
        items.ObjectRigidBody(
            mass=p.free_mass,
            inertia=[about, about, about, 0, 0, 0],
            nodeNumber=free_node,
        )
    )

    def marker(node: int, coordinate: int) -> int:
        return int(
            mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        )

    ground = marker(mbs.AddNode(items.NodePointGround()), 0)
    for fixed in ((main_node, 0), (main_node, 2), (free_node, 3), (free_node, 4)):
        mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[ground, marker(*fixed)]))
    slide = marker(main_node, 1)
    for end, stiffness, damping in (
        (slide, p.stiffness, c.damping),
        (marker(free_node, 5), 0.0, c.hinge_damping),
    ):
        mbs.AddObject(
            items.ObjectConnectorCoordinateSpringDamper(
                markerNumbers=[ground, end], stiffness=stiffness, damping=damping
            )
        )
    ends = [
        mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[offset, 0, 0]))
        for body, offset in ((main, 0.0), (free, -radius))
    ]
    mbs.AddObject(items.ObjectJointSpherical(markerNumbers=ends))
    weigh(mbs, (main, free), (p.gravity_x, p.gravity_y, 0))
    functions = harmonic_load(mbs, slide, p.force_amplitude, c.omega)
    mbs.Assemble()

    def place(q: Array, v: Array) -> tuple[Array, Array]:
        (y, theta), (speed, spin) = q, v
        cos, sin = radius * np.cos(theta), radius * np.sin(theta)
        positions = np.array([0.0, y, 0.0, cos - radius, y + sin, 0.0, 0.0, 0.0, theta])
        rates = np.array([0.0, speed, 0.0, -sin * spin, speed + cos * spin, 0.0, 0.0, 0.0, spin])
        return positions, rates

    return ExudynSystem(mbs, place, np.eye(9)[[1, 8]], container, functions)


MODEL = Model(spatial, constrained=True)
"""Beside the `MODELS` in the plane."""
