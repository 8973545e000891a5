"""hula_hoop as Exudyn models: a kinematic tree, and bodies joined by constraints.

Both are put together from the mechanism's masses, lengths, spring and dampers (SI units);
the equations of motion are Exudyn's own. Gravity acts in the plane.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...reference.hula_hoop.equations import HulaHoop, coefficients
from ...reference.scene import Array
from ..exudyn_body import PlaneMechanism
from ..exudyn_system import (
    UPRIGHT,
    ExudynSystem,
    Model,
    exudyn,
    harmonic_load,
    items,
    weigh,
)


def kinematic_tree(p: HulaHoop, axes: Array = UPRIGHT) -> ExudynSystem:
    """Return minimal coordinates (y, theta): a prismatic joint carrying a revolute one.

    ``axes`` (3, 3) are the model's in the world.
    """
    c = coefficients(p)
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    node = mbs.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=[0, 0],
            initialCoordinates=[0, 0],
            initialCoordinates_t=[0, 0],
            numberOfODE2Coordinates=2,
        )
    )
    inertia = np.diag([0, 0, centre_inertia(p)])
    mbs.AddObject(
        items.ObjectKinematicTree(
            nodeNumber=node,
            jointTypes=[exudyn.JointType.PrismaticY, exudyn.JointType.RevoluteZ],
            linkParents=[-1, 0],
            jointTransformations=exudyn.Matrix3DList([axes, np.eye(3)]),
            jointOffsets=exudyn.Vector3DList([[0, 0, 0]] * 2),
            linkMasses=[p.main_mass, p.free_mass],
            linkCOMs=exudyn.Vector3DList([[0, 0, 0], [p.rod_length, 0, 0]]),
            linkInertiasCOM=exudyn.Matrix3DList([np.zeros((3, 3)), inertia]),
            jointPositionOffsetVector=[0, 0],
            jointVelocityOffsetVector=[0, 0],
            jointPControlVector=[p.stiffness, 0],
            jointDControlVector=[c.damping, c.hinge_damping],
            gravity=list(axes @ [p.gravity_x, p.gravity_y, 0]),
        )
    )
    slide = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=0))
    functions = harmonic_load(mbs, slide, p.force_amplitude, c.omega)
    mbs.Assemble()
    return ExudynSystem(mbs, lambda q, v: (q, v), np.eye(2), container, functions)


def redundant(p: HulaHoop) -> ExudynSystem:
    """Return a mass point on a slide and a plane body, (x, y, x_f, y_f, theta), and a hinge.

    The node of the body is the free mass; the hinge is the rod's length away. The main mass
    does not turn, so the friction of the hinge acts between theta and the ground.
    """
    c = coefficients(p)
    radius = p.rod_length
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    main_node = mbs.AddNode(items.NodePoint2D(referenceCoordinates=[0, 0]))
    free_node = mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[radius, 0, 0]))
    main = mbs.AddObject(items.ObjectMassPoint2D(mass=p.main_mass, nodeNumber=main_node))
    free = mbs.AddObject(
        items.ObjectRigidBody2D(mass=p.free_mass, inertia=centre_inertia(p), nodeNumber=free_node)
    )
    ground, across, slide, angle = (
        mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        for node, coordinate in (
            (mbs.AddNode(items.NodePointGround()), 0),
            (main_node, 0),
            (main_node, 1),
            (free_node, 2),
        )
    )
    mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[ground, across]))
    for marker, stiffness, damping in (
        (slide, p.stiffness, c.damping),
        (angle, 0.0, c.hinge_damping),
    ):
        mbs.AddObject(
            items.ObjectConnectorCoordinateSpringDamper(
                markerNumbers=[ground, marker], stiffness=stiffness, damping=damping
            )
        )
    ends = [
        mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[offset, 0, 0]))
        for body, offset in ((main, 0.0), (free, -radius))
    ]
    mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=ends))
    weigh(mbs, (main, free), (p.gravity_x, p.gravity_y, 0))
    functions = harmonic_load(mbs, slide, p.force_amplitude, c.omega)
    mbs.Assemble()

    def place(q: Array, v: Array) -> tuple[Array, Array]:
        y, theta = q
        cos, sin = radius * np.cos(theta), radius * np.sin(theta)
        coordinates = np.array([0.0, y, cos - radius, y + sin, theta])
        return coordinates, np.array([0.0, v[0], -sin * v[1], v[0] + cos * v[1], v[1]])

    return ExudynSystem(mbs, place, np.eye(5)[[1, 4]], container, functions)


def redundant_in_space(p: HulaHoop, axes: Array) -> ExudynSystem:
    """Return the same bodies and joints in space, in ``axes`` (3, 3) of the world."""
    c, radius, whole = coefficients(p), p.rod_length, PlaneMechanism(axes)
    main, free = whole.add_body(p.main_mass), whole.add_body(p.free_mass, centre_inertia(p))
    whole.slide(main, free=[1])
    whole.hinge((main, 0), (free, -radius))
    whole.spring(main, 1, stiffness=p.stiffness, damping=c.damping)
    whole.count(1, (main, free), damping=c.hinge_damping)
    weigh(whole.mbs, whole.bodies, list(axes @ [p.gravity_x, p.gravity_y, 0]))
    functions = [
        harmonic_load(whole.mbs, marker, share * p.force_amplitude, c.omega)[0]
        for share, marker in zip(axes[:, 1], whole.coordinates(main), strict=True)
    ]

    def place(q: Array, v: Array) -> tuple[Array, Array]:
        y, theta = q
        cos, sin = radius * np.cos(theta), radius * np.sin(theta)
        places = np.array([[0, y, 0], [cos, y + sin, theta]])
        return whole.place(places, np.array([[0, v[0], 0], [-sin * v[1], v[0] + cos * v[1], v[1]]]))

    readout = np.array([whole.along(main, 1), np.zeros(14)])
    return whole.system(place, readout, functions=tuple(functions))


MODELS: Mapping[str, Model] = {
    "kinematic_tree": Model(kinematic_tree, constrained=False, in_axes=kinematic_tree),
    "redundant": Model(redundant, constrained=True, in_axes=redundant_in_space),
}
"""Models by name, default first."""


def centre_inertia(p: HulaHoop) -> float:
    """Moment of inertia of the free mass about its own centre; 0 for a point."""
    return p.inertia_ratio * p.free_mass * p.rod_length**2
