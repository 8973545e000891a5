"""Rigid bodies in space, in Exudyn: with Euler parameters, their reference points at joints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..reference.body.parameters import PLACES, BodyParameters, body_inertia
from ..reference.quaternions import matrix, product, spin
from ..reference.scene import Array
from .exudyn_system import ExudynSystem, Hinge, Items, exudyn, items, parameters, weigh
from .placement import turn_quaternion

UPRIGHT = np.eye(4)[0]
"""The quaternion of no rotation, from which Exudyn's coordinates count."""
UPRIGHT.flags.writeable = False


def euler_parameters_of(q: Array, v: Array) -> tuple[Array, Array]:
    """Return the coordinates (4,) of a quaternion of any length, and their rates, for length 1."""
    size = np.linalg.norm(q)
    unit, rates = q / size, v / size
    return unit - UPRIGHT, rates - (unit @ rates) * unit


def add_body(mbs: Any, p: BodyParameters) -> tuple[Any, Any]:
    """Add the body of these parameters; return its node and itself."""
    return add_rigid_body(mbs, p.mass, p.centre, body_inertia(p))


def add_rigid_body(
    mbs: Any, mass: float, centre: Iterable[float], tensor: Array
) -> tuple[Any, Any]:
    """Add a body (x, y, z, q_w, q_x, q_y, q_z); return its node and itself.

    Its centre of mass and its inertia tensor (3, 3) are from its reference point. Exudyn adds the
    constraint |q| = 1.
    """
    node = mbs.AddNode(items.NodeRigidBodyEP(referenceCoordinates=[0, 0, 0, *UPRIGHT]))
    xx, yy, zz, xy, xz, yz = (float(tensor[place]) for place in PLACES)
    body = mbs.AddObject(
        items.ObjectRigidBody(
            mass=mass,
            inertia=[xx, yy, zz, yz, xz, xy],
            centerOfMass=[float(part) for part in centre],
            nodeNumber=node,
        )
    )
    return node, body


def add_hinge(mbs: Any, bodies: tuple[Any, Any], hinge: Hinge, **spring: float) -> None:
    """Add a hinge between two bodies, with a torsion spring that counts its turns."""
    first, second = bodies
    place, axes = hinge.point.tolist(), np.array(matrix(hinge.frame))
    marker: dict[str, Any] = {"localPosition": place}
    between: dict[str, Any] = {"rotationMarker0": axes}
    if "localHT" in parameters(Items.module, "MarkerBodyRigid"):  # from 1.12.244 on
        frame = np.block([[axes, hinge.point[:, None]], [np.eye(4)[3]]])
        marker, between = {"localHT": frame}, {}
    between["markerNumbers"] = [
        mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=first, **marker)),
        mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=second)),
    ]
    mbs.AddObject(items.ObjectJointRevoluteZ(**between))
    count = mbs.AddNode(items.NodeGenericData(initialCoordinates=[0.0], numberOfDataCoordinates=1))
    mbs.AddObject(items.ObjectConnectorTorsionalSpringDamper(nodeNumber=count, **between, **spring))


class HingedBody(NamedTuple):
    """A body on a hinge, about whose z axis it turns, its centre of mass along its x axis.

    Attributes
    ----------
    parent : int
        Number of the body that bears the hinge, 0 of the base.
    mass, arm : float
        And how far the centre of mass is from the hinge.
    moments : array (3,)
        About the centre of mass, along its axes.
    place : array (3,)
        Of the hinge in the parent's frame.
    frame : array (4,)
        The quaternion of its frame in the parent's at the angle 0.
    spring : mapping
        What the torsion spring of the hinge takes.
    """

    parent: int
    mass: float
    arm: float
    moments: Array
    place: Array
    frame: Array
    spring: Mapping[str, float]


def floating_system(p: BodyParameters, rods: Sequence[HingedBody], axes: Array) -> ExudynSystem:
    """Return (x, y, z, q_w, q_x, q_y, q_z) of a base and of bodies on hinges, these from them.

    The scene's coordinates are those of the base's point, the angles and the quaternion. ``axes``
    (3, 3) are the model's in the world.
    """
    turn, count = turn_quaternion(axes), len(rods)
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    bodies, hinges = [add_body(mbs, p)[1]], []
    for k, one in enumerate(rods, 1):
        about = one.moments + one.mass * one.arm**2 * np.array([0, 1, 1])
        bodies.append(add_rigid_body(mbs, one.mass, (one.arm, 0, 0), np.diag(about))[1])
        attitudes = 7 * one.parent + 3, 7 * k + 3
        hinges.append(Hinge(2 + k, one.place, one.frame, attitudes))
        add_hinge(mbs, (bodies[one.parent], bodies[k]), hinges[-1], **one.spring)
    weigh(mbs, bodies, list(axes @ p.gravity))
    mbs.Assemble()

    def place(q: Array, v: Array) -> tuple[Array, Array]:
        attitude, rates = euler_parameters_of(turn @ q[-4:], turn @ v[-4:])
        moved = [(np.append(axes @ q[:3], attitude), np.append(axes @ v[:3], rates))]
        for one, hinge in zip(rods, hinges, strict=True):
            at = hinge.coordinate
            moved.append(carried(hinge, moved[one.parent], q[at], v[at]))
        coordinates, speeds = zip(*moved, strict=True)
        return np.concatenate(coordinates), np.concatenate(speeds)

    readout = np.zeros((7 + count, 7 * (1 + count)))
    readout[:3, :3], readout[-4:, 3:7] = axes.T, turn.T
    origin = np.append(np.zeros(3 + count), turn.T @ UPRIGHT)
    return ExudynSystem(mbs, place, readout, container, origin=origin, hinges=tuple(hinges))


def carried(
    hinge: Hinge, body: tuple[Array, Array], angle: float, rate: float
) -> tuple[Array, Array]:
    """Return coordinates and rates (7,) of the second body of a hinge from those of the first."""
    places, speeds = body
    attitude = places[3:] + UPRIGHT
    omega = 2 * np.array(spin(attitude, speeds[3:])[1:])
    turn = np.array(product(hinge.frame, [np.cos(angle / 2), 0, 0, np.sin(angle / 2)]))
    unit = np.array(product(attitude, turn))
    own = omega @ np.array(matrix(turn)) + [0, 0, rate]
    axes = np.array(matrix(attitude))
    place = places[:3] + axes @ hinge.point
    speed = speeds[:3] + axes @ np.cross(omega, hinge.point)
    return (
        np.concatenate([place, unit - UPRIGHT]),
        np.concatenate([speed, product(unit, [0, *(own / 2)])]),
    )
