"""Rigid bodies in space, in Exudyn: with Euler parameters, their reference points at joints."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..reference.body.rotation import PLACES, BodyParameters, body_inertia
from ..reference.quaternions import matrix, product, spin
from ..reference.scene import Array
from .exudyn_system import ExudynSystem, Hinge, Items, exudyn, items, parameters, weigh
from .placement import UNEQUAL, turn_quaternion

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
    add_torsion_spring(mbs, **between, **spring)


def add_torsion_spring(mbs: Any, **spring: Any) -> None:
    """Add a torsion spring that counts the turns between its markers."""
    count = mbs.AddNode(items.NodeGenericData(initialCoordinates=[0.0], numberOfDataCoordinates=1))
    mbs.AddObject(items.ObjectConnectorTorsionalSpringDamper(nodeNumber=count, **spring))


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


class PlaneMechanism:
    """A mechanism that joints keep in a plane, of bodies that could move in space.

    Each body has its reference point at its centre of mass and its z axis across the plane. All
    points are told in the frame of the plane, or of a body.

    Attributes
    ----------
    frame : array (3, 3)
        Axes of the plane, and across it, in the world; a rotation.
    container, mbs
        Exudyn's.
    ground : int
        Number of a body that stands still, along ``frame``.
    bodies, nodes : list of int
        Numbers of those that move, and of their nodes.
    hinges : list of Hinge
        The angles that are counted.
    """

    def __init__(self, frame: Array) -> None:
        self.frame = frame
        self.attitude = turn_quaternion(frame) @ UPRIGHT
        self.container = exudyn.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.ground = int(self.mbs.AddObject(items.ObjectGround(referenceRotation=frame)))
        self.bodies: list[int] = []
        self.nodes: list[int] = []
        self.hinges: list[Hinge] = []

    def add_body(self, mass: float, moment: float = 0.0) -> int:
        """Add a body with a moment of inertia about its z axis; return its number.

        Those about x and y are others, which shows whether the tensor turns with the body.
        """
        tensor = moment * np.diag(UNEQUAL)
        node, body = add_rigid_body(self.mbs, mass, (0, 0, 0), tensor)
        self.nodes.append(int(node))
        self.bodies.append(int(body))
        return self.bodies[-1]

    def marker(self, body: int, at: complex = 0) -> Any:
        """Return a marker at a point of a body, x + i y."""
        place = [at.real, at.imag, 0]
        return self.mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=place))

    def slide(self, body: int, free: Sequence[int]) -> None:
        """Join a body to the ground, so that it moves along some axes (0, 1, 2) without turning."""
        axes = [int(axis not in free) for axis in range(6)]
        markers = [self.marker(self.ground), self.marker(body)]
        self.mbs.AddObject(items.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=axes))

    def coordinates(self, body: int) -> list[Any]:
        """Return markers of the three places of a body in the world."""
        node = self.nodes[self.bodies.index(body)]
        return [
            self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=i))
            for i in range(3)
        ]

    def hinge(self, first: tuple[int, complex], second: tuple[int, complex]) -> None:
        """Join points of two bodies, x + i y, by a hinge across the plane."""
        markers = [self.marker(*first), self.marker(*second)]
        self.mbs.AddObject(items.ObjectJointRevoluteZ(markerNumbers=markers))

    def ball(self, first: tuple[int, complex], second: tuple[int, complex]) -> None:
        """Join points of two bodies, x + i y, by a ball joint."""
        markers = [self.marker(*first), self.marker(*second)]
        self.mbs.AddObject(items.ObjectJointSpherical(markerNumbers=markers))

    def spring(self, body: int, axis: int, **spring: float) -> None:
        """Put a spring and damper along an axis (0, 1) between the ground and a body."""
        markers, direction = [self.marker(self.ground), self.marker(body)], list(np.eye(3)[axis])
        self.mbs.AddObject(
            items.ObjectConnectorLinearSpringDamper(
                markerNumbers=markers, axisMarker0=direction, **spring
            )
        )

    def count(
        self, coordinate: int, between: tuple[int, int], sign: float = 1.0, **spring: float
    ) -> None:
        """Count the angle from one body to another as a coordinate of the scene, with a spring."""
        attitudes = [7 * self.bodies.index(body) + 3 for body in between]
        hinge = Hinge(coordinate, np.zeros(3), UPRIGHT, (attitudes[0], attitudes[1]), sign)
        self.hinges.append(hinge)
        add_torsion_spring(self.mbs, markerNumbers=[self.marker(one) for one in between], **spring)

    def place(self, places: Array, rates: Array) -> tuple[Array, Array]:
        """Return coordinates and rates (7 k,) from x, y and angle of each body (k, 3)."""
        coordinates, speeds = np.zeros((2, len(places), 7))
        coordinates[:, :3], speeds[:, :3] = (
            part[:, :2] @ self.frame[:, :2].T for part in (places, rates)
        )
        for row, speed, angle, rate in zip(
            coordinates, speeds, places[:, 2], rates[:, 2], strict=True
        ):
            unit = product(self.attitude, [np.cos(angle / 2), 0, 0, np.sin(angle / 2)])
            row[3:], speed[3:] = unit - UPRIGHT, product(unit, [0, 0, 0, rate / 2])
        return coordinates.ravel(), speeds.ravel()

    def along(self, body: int, axis: int) -> Array:
        """Return what an axis (0, 1) takes of all coordinates (7 k,), for the place of a body."""
        row = np.zeros((len(self.bodies), 7))
        row[self.bodies.index(body), :3] = self.frame[:, axis]
        return row.ravel()

    def system(
        self, place: Callable[[Array, Array], tuple[Array, Array]], readout: Array, **more: Any
    ) -> ExudynSystem:
        """Assemble it, with what `ExudynSystem` takes."""
        self.mbs.Assemble()
        return ExudynSystem(
            self.mbs, place, readout, self.container, hinges=tuple(self.hinges), **more
        )
