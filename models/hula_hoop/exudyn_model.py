"""hula_hoop as Exudyn models: a kinematic tree, and bodies joined by constraints.

Both are put together from the mechanism's masses, lengths, spring and dampers (SI units);
the equations of motion are Exudyn's own. There is no gravity.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from ...reference.hula_hoop import HulaHoop, coefficients
from ...reference.scene import Array

# As Any, since Exudyn's type stubs refuse calls that it documents.
exudyn: Any = import_module("exudyn")
items: Any = import_module("exudyn.itemInterface")
utilities: Any = import_module("exudyn.advancedUtilities")


@dataclass(frozen=True)
class System:
    """An assembled Exudyn system of a scene, with n coordinates out of N.

    Attributes
    ----------
    mbs : exudyn.MainSystem
    place : callable ``(q, v) -> (Q, V)``
        ODE2 coordinates (N,), less the reference coordinates, and their rates, of scene
        coordinates (n,) and rates; constraints are met in position and velocity.
    readout : array (n, N)
        And back: ``q = readout @ Q``, likewise for rates and accelerations.
    container : exudyn.SystemContainer
        Holder of ``mbs``; its ``Reset`` frees the memory, which Exudyn else keeps.
    functions : tuple of exudyn.symbolic.UserFunction
        Must live as long as ``mbs``.
    """

    mbs: Any
    place: Callable[[Array, Array], tuple[Array, Array]]
    readout: Array
    container: Any
    functions: tuple[Any, ...]


@dataclass(frozen=True)
class Model:
    """One way to model the scene.

    Attributes
    ----------
    build : callable ``(parameters, driven) -> System``
        Without its loads if not ``driven``.
    constrained : bool
        Whether it has algebraic constraints, which Exudyn's explicit solvers cannot keep.
    """

    build: Callable[[HulaHoop, bool], System]
    constrained: bool


def kinematic_tree(p: HulaHoop, driven: bool = True) -> System:
    """Return minimal coordinates (y, theta): a prismatic joint carrying a revolute one."""
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
            jointTransformations=exudyn.Matrix3DList([np.eye(3)] * 2),
            jointOffsets=exudyn.Vector3DList([[0, 0, 0]] * 2),
            linkMasses=[p.main_mass, p.free_mass],
            linkCOMs=exudyn.Vector3DList([[0, 0, 0], [p.rod_length, 0, 0]]),
            linkInertiasCOM=exudyn.Matrix3DList([np.zeros((3, 3)), inertia]),
            jointPositionOffsetVector=[0, 0],
            jointVelocityOffsetVector=[0, 0],
            jointPControlVector=[p.stiffness, 0],
            jointDControlVector=[c.damping, c.hinge_damping],
        )
    )
    slide = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=0))
    functions = harmonic_load(mbs, slide, p.force_amplitude, c.omega) if driven else ()
    mbs.Assemble()
    return System(mbs, lambda q, v: (q, v), np.eye(2), container, functions)


def redundant(p: HulaHoop, driven: bool = True) -> System:
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
    functions = harmonic_load(mbs, slide, p.force_amplitude, c.omega) if driven else ()
    mbs.Assemble()

    def place(q: Array, v: Array) -> tuple[Array, Array]:
        y, theta = q
        cos, sin = radius * np.cos(theta), radius * np.sin(theta)
        coordinates = np.array([0.0, y, cos - radius, y + sin, theta])
        return coordinates, np.array([0.0, v[0], -sin * v[1], v[0] + cos * v[1], v[1]])

    return System(mbs, place, np.eye(5)[[1, 4]], container, functions)


MODELS: Mapping[str, Model] = {
    "kinematic_tree": Model(kinematic_tree, constrained=False),
    "redundant": Model(redundant, constrained=True),
}
"""Models by name, default first."""


def centre_inertia(p: HulaHoop) -> float:
    """Moment of inertia of the free mass about its own centre; 0 for a point."""
    return p.inertia_ratio * p.free_mass * p.rod_length**2


def harmonic_load(mbs: Any, marker: Any, amplitude: float, omega: float) -> tuple[Any, ...]:
    """Put a load amplitude * cos(omega t) on a coordinate; return what must stay alive.

    Symbolic, so that Exudyn evaluates it in C++ at the time of every stage.
    """

    def force(mbs: Any, t: Any, load: Any) -> Any:
        return load * exudyn.symbolic.cos(float(omega) * t)

    symbolic = utilities.CreateSymbolicUserFunction(
        mbs, function=force, userFunctionName="loadUserFunction", itemTypeName="LoadCoordinate"
    )
    mbs.AddLoad(
        items.LoadCoordinate(markerNumber=marker, load=amplitude, loadUserFunction=symbolic)
    )
    return (symbolic,)
