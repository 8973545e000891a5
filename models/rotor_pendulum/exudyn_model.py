"""rotor_pendulum as Exudyn models: a kinematic tree, and bodies joined by constraints.

Both are put together from the mechanism's masses, lengths, springs, dampers and motors (SI
units); the equations of motion are Exudyn's own. All angles count
counter-clockwise here, so that of rotor 1 is -phi_1.
"""

from __future__ import annotations

from cmath import exp
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...reference.rotor_pendulum.equations import RotorPendulum
from ...reference.scene import Array
from ..exudyn_body import PlaneMechanism
from ..exudyn_system import UPRIGHT, ExudynSystem, Model, exudyn, items, weigh

JOINTS = np.array([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1], [0, 0, 1, -1]], dtype=float)
"""Joints of the tree, (x, -phi_1, phi_3, phi_2 - phi_3), from (x, phi_1, phi_2, phi_3)."""


def kinematic_tree(p: RotorPendulum, axes: Array = UPRIGHT) -> ExudynSystem:
    """Return minimal coordinates: a prismatic joint carrying rotor 1 and the rod with rotor 2.

    ``axes`` (3, 3) are the model's in the world.
    """
    platform, rotor_1, rod, rotor_2 = range(4)
    beta, l, r = p.installation_angle, p.rod_length, p.eccentricity
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    node = mbs.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=[0] * 4,
            initialCoordinates=[0] * 4,
            initialCoordinates_t=[0] * 4,
            numberOfODE2Coordinates=4,
        )
    )
    tree = mbs.AddObject(
        items.ObjectKinematicTree(
            nodeNumber=node,
            jointTypes=[exudyn.JointType.PrismaticX] + [exudyn.JointType.RevoluteZ] * 3,
            linkParents=[-1, platform, platform, rod],
            jointTransformations=exudyn.Matrix3DList(
                [axes, np.eye(3), rotation(beta), rotation(-beta)]
            ),
            jointOffsets=exudyn.Vector3DList([[0, 0, 0], [0, 0, 0], [0, 0, 0], [l, 0, 0]]),
            linkMasses=[p.platform_mass, p.rotor_mass, p.rod_mass, p.rotor_mass],
            linkCOMs=exudyn.Vector3DList([[0, 0, 0], [-r, 0, 0], [l, 0, 0], [r, 0, 0]]),
            linkInertiasCOM=exudyn.Matrix3DList([np.zeros((3, 3))] * 4),
            jointPositionOffsetVector=[0] * 4,
            jointVelocityOffsetVector=[0] * 4,
            jointPControlVector=[p.platform_stiffness, 0, p.rod_stiffness, 0],
            jointDControlVector=[p.platform_damping, 0, p.rod_damping, 0],
            gravity=list(axes @ [p.gravity_x, p.gravity_y, 0]),
        )
    )
    links = [
        mbs.AddMarker(items.MarkerKinematicTreeRigid(objectNumber=tree, linkNumber=link))
        for link in (platform, rotor_1, rod, rotor_2)
    ]
    add_motors(mbs, p, *links)
    mbs.Assemble()
    return ExudynSystem(
        mbs, lambda q, v: (JOINTS @ q, JOINTS @ v), np.linalg.inv(JOINTS), container
    )


def redundant(p: RotorPendulum) -> ExudynSystem:
    """Return a mass on a slide, (x), three plane bodies, each (x, y, angle), and three hinges.

    The node of each body is its point mass. Bodies in the order rotor 1, rod, rotor 2.
    """
    r, rod_end = p.eccentricity, p.rod_length * exp(1j * p.installation_angle)
    masses = (p.rotor_mass, p.rod_mass, p.rotor_mass)
    origins = np.array([-r, rod_end, rod_end + r])  # in the complex plane, as all places below
    angles = (0.0, p.installation_angle, 0.0)
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    slide = mbs.AddNode(items.Node1D(referenceCoordinates=[0]))
    nodes = [
        mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[origin.real, origin.imag, angle]))
        for origin, angle in zip(origins, angles, strict=True)
    ]
    platform = mbs.AddObject(items.ObjectMass1D(mass=p.platform_mass, nodeNumber=slide))
    rotor_1, rod, rotor_2 = (
        mbs.AddObject(items.ObjectRigidBody2D(mass=mass, inertia=0, nodeNumber=node))
        for mass, node in zip(masses, nodes, strict=True)
    )
    for carrier, carried, hinge in (
        (platform, rotor_1, r),
        (platform, rod, -p.rod_length),
        (rod, rotor_2, -r),
    ):
        ends = [
            mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[place, 0, 0]))
            for body, place in ((carrier, 0), (carried, hinge))
        ]
        mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=ends))
    ground, shift, swing = (
        mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
        for node, coordinate in (
            (mbs.AddNode(items.NodePointGround()), 0),
            (slide, 0),
            (nodes[1], 2),  # less the installation angle; the platform does not turn
        )
    )
    for marker, stiffness, damping in (
        (shift, p.platform_stiffness, p.platform_damping),
        (swing, p.rod_stiffness, p.rod_damping),
    ):
        mbs.AddObject(
            items.ObjectConnectorCoordinateSpringDamper(
                markerNumbers=[ground, marker], stiffness=stiffness, damping=damping
            )
        )
    weigh(mbs, (rotor_1, rod, rotor_2), (p.gravity_x, p.gravity_y, 0))
    if p.gravity_x:
        mbs.AddLoad(items.LoadCoordinate(markerNumber=shift, load=p.platform_mass * p.gravity_x))
    add_motors(
        mbs,
        p,
        *(
            mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body))
            for body in (platform, rotor_1, rod, rotor_2)
        ),
    )
    mbs.Assemble()

    def place(q: Array, v: Array) -> tuple[Array, Array]:
        coordinates, velocities = carried_motion(p, q, v, origins).reshape(2, 9)
        return np.append(q[0], coordinates), np.append(v[0], velocities)

    readout = np.zeros((4, 10))
    readout[range(4), [0, 3, 9, 6]] = [1, -1, 1, 1]
    return ExudynSystem(mbs, place, readout, container)


def redundant_in_space(p: RotorPendulum, axes: Array) -> ExudynSystem:
    """Return the same bodies and joints in space, in ``axes`` (3, 3) of the world."""
    r, rod_end = p.eccentricity, p.rod_length * exp(1j * p.installation_angle)
    whole = PlaneMechanism(axes)
    platform, rotor_1, rod, rotor_2 = bodies = [
        whole.add_body(mass) for mass in (p.platform_mass, p.rotor_mass, p.rod_mass, p.rotor_mass)
    ]
    whole.slide(platform, free=[0])
    whole.hinge((platform, 0), (rotor_1, r))
    whole.hinge((platform, 0), (rod, -rod_end))
    whole.hinge((rod, 0), (rotor_2, -r))
    whole.spring(platform, 0, stiffness=p.platform_stiffness, damping=p.platform_damping)
    whole.count(1, (platform, rotor_1), sign=-1.0)
    whole.count(2, (platform, rotor_2))
    whole.count(3, (platform, rod), stiffness=p.rod_stiffness, damping=p.rod_damping)
    weigh(whole.mbs, whole.bodies, list(axes @ [p.gravity_x, p.gravity_y, 0]))
    add_motors(whole.mbs, p, *(whole.marker(body) for body in bodies))

    def place(q: Array, v: Array) -> tuple[Array, Array]:
        slide = np.array([[[q[0], 0, 0]], [[v[0], 0, 0]]])
        return whole.place(*np.concatenate([slide, carried_motion(p, q, v)], axis=1))

    readout = np.zeros((4, 28))
    readout[0] = whole.along(platform, 0)
    return whole.system(place, readout)


def carried_motion(p: RotorPendulum, q: Array, v: Array, origins: Array | float = 0.0) -> Array:
    """Return x, y, angle and their rates (2, 3, 3) of rotor 1, rod and rotor 2.

    Places (3,), in the complex plane, are told from ``origins``; the rod's angle is phi_3.
    """
    r, rod_end = p.eccentricity, p.rod_length * exp(1j * p.installation_angle)
    x, phi_1, phi_2, phi_3 = q
    arms = np.array([-r * exp(-1j * phi_1), rod_end * exp(1j * phi_3), r * exp(1j * phi_2)])
    turns = np.array([-phi_1, phi_3, phi_2])
    speeds = np.array([-v[1], v[3], v[2]])
    places, rates = x + CARRIED @ arms - origins, v[0] + CARRIED @ (1j * speeds * arms)
    bodies = np.array([[places.real, places.imag, turns], [rates.real, rates.imag, speeds]])
    return bodies.transpose(0, 2, 1)


CARRIED = np.array([[1, 0, 0], [0, 1, 0], [0, 1, 1]])
"""Arms that lead from the platform to each of rotor 1, rod, rotor 2."""


def add_motors(
    mbs: Any, p: RotorPendulum, platform: int, rotor_1: int, rod: int, rotor_2: int
) -> None:
    """Put motors and bearings between the markers of bodies.

    A motor that acts on the absolute angle of rotor 2 stands on the platform, which does not
    turn. The connector puts the opposite of its torque on its second marker.
    """
    stand = {"absolute": platform, "relative": rod}[p.motor_placement]
    torque = p.motor_slope * p.synchronous_speed
    for base, rotor, direction in ((platform, rotor_1, -1), (stand, rotor_2, 1)):
        mbs.AddObject(
            items.ObjectConnectorTorsionalSpringDamper(
                markerNumbers=[base, rotor],
                damping=p.motor_slope + p.friction,
                torque=-direction * torque,
            )
        )


def rotation(angle: float) -> Array:
    """Return the matrix (3, 3) of a rotation about z."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])


MODELS: Mapping[str, Model] = {
    "kinematic_tree": Model(kinematic_tree, constrained=False, in_axes=kinematic_tree),
    "redundant": Model(redundant, constrained=True, in_axes=redundant_in_space),
}
"""Models by name, default first."""
