"""rotating_beam as an Exudyn model: a hub and finite elements in absolute coordinates.

Two kinds of element, of 2 nodes each:

- ``ancf`` (ObjectANCFCable2D): node (x, y, x', y'); converges with order 4 to the beam that
  stretches and does not shear.
- ``geometrically_exact`` (ObjectBeamGeometricallyExact2D): node (x, y, angle); converges with
  order 2 to the beam that also shears, of stiffness `shear_stiffness`, with the rotary inertia
  of its cross sections.

Turned in the world ``ancf`` are ObjectANCFCable, node (x, y, z, x', y', z'), whose axial force and
bending moment are the same. What keeps them in a plane is that nothing pushes them out of it.

The mass sits on a node, so that no element has a kink of the shear force inside. There is no
damping.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from ...reference.rotating_beam import EXTENSIBLE
from ...reference.rotating_beam.elements import element_scene, free_coordinates, shear_stiffness
from ...reference.rotating_beam.elements import stations as node_places
from ...reference.rotating_beam.frequencies.stretching import frequencies
from ...reference.rotating_beam.parameters import RotatingBeam
from ...reference.scene import Array
from ..exudyn_system import (
    ExudynSystem,
    Model,
    Turning,
    exudyn,
    items,
    load_in_time,
    rotor_takes_no_joints,
    weigh,
)
from ..placement import right_handed, world_axes

PRESCRIBED = 2.0**60
"""Inertia [kg m^2] of a hub whose motion is prescribed: the torque that moves it by (22) is
scaled likewise, and what the beam does to it lies below rounding."""


def stations(p: RotatingBeam) -> Array:
    """Return the nodes' distances from the clamp [m]: equal elements on each side of the mass."""
    place = p.mass_position if p.mass else 1.0
    return np.asarray(p.length * node_places(round(p.segments), place))


def elements(p: RotatingBeam, axes: Array | None = None) -> ExudynSystem:
    """Return the hub's angle, then the coordinates of the nodes from clamp to tip.

    In ``axes`` (3, 3) of the world the nodes are those of cables in space, and what
    `clamp_in_space` adds comes last.
    """
    ancf = p.element == "ancf"
    at = stations(p)
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    axle = mbs.AddNode(items.Node1D(referenceCoordinates=[0]))
    prescribed = p.drive == "prescribed"
    inertia = PRESCRIBED if prescribed else p.hub_inertia
    upright = np.eye(3) if axes is None else axes
    hub = mbs.AddObject(
        items.ObjectRotationalMass1D(inertia=inertia, nodeNumber=axle, referenceRotation=upright)
    )
    straight = np.zeros((len(at), 4 if ancf else 3))  # reference coordinates
    straight[:, 0] = p.hub_radius + at
    straight[:, 2] = ancf
    places = np.eye(straight.shape[1]) if axes is None else np.kron(np.eye(2), axes[:, :2])
    node, element = (getattr(items, name) for name in KINDS[p.element, axes is not None])
    nodes = [mbs.AddNode(node(referenceCoordinates=list(places @ place))) for place in straight]
    bodies = []
    for ends, length in zip(pairwise(nodes), np.diff(at), strict=True):
        section = {
            "nodeNumbers": list(ends),
            "length": length,
            "massPerLength": p.density * p.area,
            "bendingStiffness": p.youngs_modulus * p.second_moment,
            "axialStiffness": p.youngs_modulus * p.area,
        }
        if not ancf:
            section |= {
                "shearStiffness": shear_stiffness(p),
                "crossSectionInertia": p.density * p.second_moment,
            }
        bodies.append(mbs.AddObject(element(**section)))
    gravity = list(upright @ [p.gravity_x, p.gravity_y, 0.0])
    weigh(mbs, bodies, gravity)
    if p.mass > 0:
        carrier = int(np.argmin(np.abs(at - p.mass_position * p.length)))
        points = 2 if axes is None else 3
        weights = np.diag([*[p.mass] * points, *np.zeros(len(places) - points)])
        mbs.AddObject(items.ObjectGenericODE2(nodeNumbers=[nodes[carrier]], massMatrix=weights))
        point = mbs.AddMarker(items.MarkerNodePosition(nodeNumber=nodes[carrier]))
        pull = [p.mass * g for g in gravity]
        mbs.AddLoad(items.LoadForceVector(markerNumber=point, loadVector=pull))
    rim = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=hub, localPosition=[p.hub_radius, 0, 0]))
    if axes is None:
        clamp(mbs, rim, mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[0])))
    else:
        clamp_in_space(mbs, rim, nodes[0], places @ straight[0])
    turn = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=axle, coordinate=0))
    functions = push(mbs, turn, p)
    mbs.Assemble()

    turning = turning_of(straight, axes)
    first = straight.size + 1 - straight.shape[1]  # coordinate of the tip's node

    def outputs(coordinates: Array, rates: Array) -> dict[str, Array]:
        tip = turning.projection[[first, first + 1]]
        x, y = tip @ (coordinates.T + turning.reference).T
        x_dot, y_dot = tip @ rates
        cos, sin = np.cos(coordinates[0]), np.sin(coordinates[0])
        along = cos * x + sin * y
        return {
            "tip_deflection": cos * y - sin * x,
            "tip_deflection_dot": cos * y_dot - sin * x_dot - rates[0] * along,
            "tip_axial": along - p.hub_radius - p.length,
        }

    readout = np.eye(1, len(turning.reference))
    return ExudynSystem(mbs, turning.placed, readout, container, functions, outputs, turning)


KINDS = {
    ("ancf", False): ("NodePoint2DSlope1", "ObjectANCFCable2D"),
    ("geometrically_exact", False): ("NodeRigidBody2D", "ObjectBeamGeometricallyExact2D"),
    ("ancf", True): ("NodePointSlope1", "ObjectANCFCable"),
}
"""Exudyn's nodes and elements, of the plane and in space."""


def turning_of(straight: Array, axes: Array | None) -> Turning:
    """Return the rotation of the hub's angle and the nodes (k, 4 or 3 in the plane)."""
    count, size = straight.shape
    rotate = np.zeros((size, size))
    rotate[:2, :2] = QUARTER
    angles = np.zeros(size)
    if size == 4:
        rotate[2:, 2:] = QUARTER  # the slope vector
    else:
        angles[2] = 1
    whole = np.zeros((straight.size + 1,) * 2)
    whole[1:, 1:] = np.kron(np.eye(count), rotate)
    free = 1 + free_coordinates(count, size)
    plane = projection = np.eye(len(whole))
    if axes is not None:
        nodes = block_diag(1, np.kron(np.eye(2 * count), axes[:, :2]))
        ahead = np.zeros((6, len(whole)))
        ahead[:3] = nodes[1:4] + nodes[4:7]
        plane = np.vstack([nodes, ahead])
        projection = np.hstack([nodes.T, 0 * ahead.T])
    return Turning(
        plane @ np.append(0, straight),
        plane @ whole @ projection,
        plane @ np.append(1, np.tile(angles, count)),
        free,
        plane,
        projection,
    )


QUARTER = [[0, -1], [1, 0]]
"""Turns a vector by 90 degrees."""


def clamp(mbs: Any, rim: int, root: int) -> None:
    """Join position and direction of the beam's first node to the hub's rim.

    The slope vector of an ANCF node keeps its length, which is the stretch.
    """
    axes = [1, 1, 0, 0, 0, 1]  # x, y and the rotation about z
    mbs.AddObject(items.ObjectJointGeneric(markerNumbers=[rim, root], constrainedAxes=axes))


def clamp_in_space(mbs: Any, rim: int, root: int, straight: Array) -> None:
    """Join the first node of a cable in space, at ``straight`` (6,), to the hub's rim.

    The node has a slope ``r'``, and no rotation that a joint could hold. A body without mass keeps
    to the point ``r + r'``, which slides along the hub.
    """
    place, slope = np.split(straight, 2)
    node = mbs.AddNode(items.NodeRigidBodyRxyz(referenceCoordinates=[*(place + slope), 0, 0, 0]))
    body = mbs.AddObject(items.ObjectRigidBody(mass=0, inertia=[1, 1, 1, 0, 0, 0], nodeNumber=node))
    end = mbs.AddMarker(items.MarkerNodePosition(nodeNumber=root))
    mbs.AddObject(items.ObjectJointSpherical(markerNumbers=[rim, end]))
    ahead = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body))
    axes = [0, 1, 1, 0, 0, 0]  # y and z
    mbs.AddObject(items.ObjectJointGeneric(markerNumbers=[rim, ahead], constrainedAxes=axes))
    mbs.AddObject(
        items.ObjectConnectorCoordinateVector(
            markerNumbers=[
                mbs.AddMarker(items.MarkerNodeCoordinates(nodeNumber=one)) for one in (root, node)
            ],
            scalingMarker0=np.hstack([np.eye(3), np.eye(3)]),
            scalingMarker1=np.eye(3, 6),
            offset=np.zeros(3),
        )
    )


def push(mbs: Any, turn: int, p: RotatingBeam) -> tuple[Any, ...]:
    """Put the torque of (22) or (23) on the hub; return what must stay alive.

    Time stops at the end of ramp or pulse.
    """
    if p.drive != "torque" and p.ramp_time <= 0:
        return ()
    if p.drive == "torque":
        amplitude, end = p.torque_amplitude, p.torque_period
    else:
        amplitude, end = PRESCRIBED * p.angular_speed / p.ramp_time, p.ramp_time

    def shape(t: Any) -> Any:
        phase = 2 * np.pi / end * exudyn.symbolic.min(t, end)
        if p.drive == "torque":
            return exudyn.symbolic.sin(phase)
        return 1 - exudyn.symbolic.cos(phase)

    return load_in_time(mbs, turn, amplitude, shape)


def shearing(p: RotatingBeam, plane: str, count: int) -> tuple[Array, Array]:
    """Frequencies [rad/s] of the beam that geometrically exact elements converge to."""
    modes = frequencies(p, plane, count, "shear_flexible", shear_stiffness(p), True)
    return modes.omega, modes.bound


SHEARING = replace(
    EXTENSIBLE,
    title="hub with a flexible beam and a concentrated mass (exact, extensible, shearing)",
    continuum=replace(EXTENSIBLE.continuum, spectrum=shearing),
)
"""Its equations of motion are those of a beam that does not shear: that lowers the frequencies of
a slender beam by a few parts in 1e5. Runs are compared with `discrete`, which shears."""


def hub_takes_no_elements(p: RotatingBeam) -> str | None:
    """Return the reason why elements cannot be clamped to the hub, or None."""
    return rotor_takes_no_joints() if p.hub_radius else None


def elements_cannot_turn(p: RotatingBeam) -> str | None:
    """Return the reason why elements cannot be turned, or None."""
    if p.element != "ancf":
        return "geometrically exact elements lie in a plane: those in space are others, on SE(3)"
    return hub_takes_no_elements(p)


def build(p: RotatingBeam, placement: str) -> ExudynSystem:
    """Return the elements, along the axes of the world or turned with them."""
    return elements(p, right_handed(world_axes(placement)) if placement else None)


MODELS: Mapping[str, Model] = {
    "elements": Model(
        build,
        constrained=True,
        unsupported_reason=hub_takes_no_elements,
        large=True,
        equations=lambda p: (EXTENSIBLE if p.element == "ancf" else SHEARING, p),
        discrete=lambda p: element_scene(round(p.segments), p.element),
        prescribed=lambda p: p.drive == "prescribed",
        element_order=lambda p: 4 if p.element == "ancf" else 2,
        bodies=lambda p: p.replace(drive="torque"),
        unplaceable_reason=elements_cannot_turn,
    )
}
"""The one model; the parameter ``element`` selects its elements."""
