"""Exudyn models of scenes, and loads in time that Exudyn evaluates without Python."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from inspect import signature
from typing import Any, NamedTuple

import numpy as np

from ..reference.body.rotation import inner, rotation_columns
from ..reference.quaternions import square
from ..reference.scene import Array, EquationsOfMotion

# As Any, since Exudyn's type stubs refuse calls that it documents.
exudyn: Any = import_module("exudyn")
utilities: Any = import_module("exudyn.advancedUtilities")


class Items:
    """The items of ``exudyn.itemInterface``, called with the parameter names of Exudyn 1.12.

    Older releases name the ``mass`` of a body ``physicsMass``, and so on.
    """

    module: Any = import_module("exudyn.itemInterface")

    def __getattr__(self, kind: str) -> Callable[..., Any]:
        item, known = getattr(self.module, kind), parameters(self.module, kind)

        def build(**values: Any) -> Any:
            return item(**{n if n in known else physics(n): v for n, v in values.items()})

        return build


@cache
def parameters(module: Any, kind: str) -> frozenset[str]:
    """Return the parameter names of a kind of item."""
    return frozenset(signature(getattr(module, kind)).parameters)


def physics(name: str) -> str:
    """Return an older name: physicsMass for mass."""
    return f"physics{name[0].upper()}{name[1:]}"


items = Items()


def rotor_takes_no_joints() -> str | None:
    """Return the reason why joints act on the axis of an ObjectRotationalMass1D alone, or None."""
    if "inertia" in parameters(Items.module, "ObjectRotationalMass1D"):
        return None
    return (
        f"Exudyn {exudyn.__version__} takes no joint off the axis of a rotor "
        "(ObjectRotationalMass1D), which 1.13.6 does"
    )


class Turning(NamedTuple):
    """The rotation of N coordinates about an axis; the first of them is its angle.

    Attributes
    ----------
    reference : array (N,)
        Reference coordinates, at the angle 0.
    quarter : array (N, N)
        Turns those that are vectors by 90 degrees, and is 0 elsewhere.
    angles : array (N,)
        1 where a coordinate is an angle.
    free : int array (n,)
        Coordinates of the plane that constraints leave in the frame that turns, the angle apart.
    plane : array (N, N')
        The N coordinates from those of the plane of the motion.
    projection : array (N', N)
        And back: ``projection @ plane = 1``.
    """

    reference: Array
    quarter: Array
    angles: Array
    free: Array
    plane: Array
    projection: Array

    def rates(self, coordinates: Array) -> Array:
        """Return the rates (N,) of a rigid rotation with unit speed."""
        return self.angles + self.quarter @ (self.reference + coordinates)

    def rotated(self, angle: float, shape: Array | float = 0.0) -> Array:
        """Return the coordinates (N,) from those in the frame that turns, ``shape``."""
        return shape + angle * self.angles + self.swing(angle, self.reference + shape)

    def swing(self, angle: float, vectors: Array) -> Array:
        """Return the change of vectors (N,) or (N, k) in a rotation by an angle."""
        ahead = self.quarter @ vectors
        back = 2 * np.sin(angle / 2) ** 2 * (self.quarter @ ahead)
        return np.asarray(np.sin(angle) * ahead + back)

    def shape(self, coordinates: Array) -> Array:
        """Return the coordinates (N,) in the frame that turns: those at the angle 0."""
        return self.rotated(-coordinates[0], coordinates)

    def basis(self, coordinates: Array) -> Array:
        """Return the rates (N, 1 + n) of a unit rotation, and of unit rates in that frame."""
        units = self.plane[:, self.free]
        inner = units + self.swing(coordinates[0], units)
        return np.column_stack([self.rates(coordinates), inner])

    def placed(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Return coordinates and rates (N,) from the angle alone (1,), or from all (1 + n,)."""
        shape = self.plane[:, self.free[: len(q) - 1]] @ q[1:]
        coordinates = self.rotated(q[0], shape)
        return coordinates, self.basis(coordinates)[:, : len(v)] @ v

    def in_frame(
        self, coordinates: Array, rates: Array, accelerations: Array | None = None
    ) -> tuple[Array, Array, Array]:
        """Return positions, rates and accelerations (1 + n,) in the frame that turns.

        The inverse of `placed`. Without accelerations (N,) of the coordinates they are 0.
        """
        angle, speed = coordinates[0], rates[0]

        def back(vectors: Array) -> Array:
            return vectors + self.swing(-angle, vectors)

        relative = rates - speed * self.rates(coordinates)
        q, v, a = self.shape(coordinates), back(relative), np.zeros(len(rates))
        if accelerations is not None:
            at = self.reference + coordinates
            swing = self.quarter @ (2 * speed * relative + speed**2 * (self.quarter @ at))
            a = back(accelerations - accelerations[0] * self.rates(coordinates) - swing)
            a[0] = accelerations[0]
        q[0], v[0] = angle, speed
        rows = self.projection[np.append(0, self.free)]
        return rows @ q, rows @ v, rows @ a


class Hinge(NamedTuple):
    """An angle between two bodies with Euler parameters, which a connector counts the turns of.

    Attributes
    ----------
    coordinate : int
        Which of the scene's coordinates is the angle.
    axes : tuple of two arrays (3,)
        The axis in each of the bodies.
    attitudes : tuple of two int, or None for the world
        Where the Euler parameters of both begin among all N coordinates, whose reference is 1.
    """

    coordinate: int
    axes: tuple[Array, ...]
    attitudes: tuple[int | None, ...]

    def row(self, coordinates: Array) -> Array:
        """Return the rate of the scene's coordinate (N,) per rate of each of Exudyn's.

        It is linear in accelerations as well: an axis fixed in both bodies has no
        product of rates.
        """
        row = np.zeros(len(coordinates))
        for at, axis, sign in zip(self.attitudes, self.axes, (-1.0, 1.0), strict=True):
            if at is None:
                continue
            unit = coordinates[at : at + 4] + np.eye(4)[0]
            columns, size = rotation_columns(unit), square(unit)
            row[at : at + 4] = [sign * 2 * inner(axis, column) / size for column in columns]
        return row


@dataclass(frozen=True)
class ExudynSystem:
    """An assembled Exudyn system of a scene, with n coordinates out of N.

    Attributes
    ----------
    mbs : exudyn.MainSystem
    place : callable ``(q, v) -> (Q, V)``
        ODE2 coordinates (N,), less the reference coordinates, and their rates, of scene
        coordinates (n,) and rates; constraints are met in position and velocity.
    readout : array (n, N)
        And back: ``q = readout @ Q + origin``, likewise for rates and accelerations without it.
    container : exudyn.SystemContainer
        Holder of ``mbs``; its ``Reset`` frees the memory, which Exudyn else keeps.
    functions : tuple of exudyn.symbolic.UserFunction
        Must live as long as ``mbs``.
    outputs : callable ``(Q (N, k), V (N, k)) -> {name: array (k,)}``
        The scene's observed outputs, as this system has them.
    turning : Turning or None
        For a system that deforms while it turns: ``place`` takes the angle alone, of a rigid
        rotation, or also the free coordinates in the frame that turns.
    origin : array (n,), or None
        The scene's coordinates where those of Exudyn are 0; None: 0.
    hinges : tuple of Hinge
        The coordinates without a row in ``readout``. Their angles are Exudyn's data coordinates.
    reactions : array (k, m), or None
        The matrix from the m multipliers of this system to the k reactions of the model.
    """

    mbs: Any
    place: Callable[[Array, Array], tuple[Array, Array]]
    readout: Array
    container: Any
    functions: tuple[Any, ...] = ()
    outputs: Callable[[Array, Array], Mapping[str, Array]] = lambda coordinates, rates: {}
    turning: Turning | None = None
    origin: Array | None = None
    hinges: tuple[Hinge, ...] = ()
    reactions: Array | None = None

    def angles(self, q: Array) -> list[float]:
        """Return the data coordinates at positions (n,) of the scene."""
        return [float(q[hinge.coordinate]) for hinge in self.hinges]

    def readout_at(self, coordinates: Array) -> Array:
        """Return the matrix (n, N) to rates, and to accelerations, at coordinates (N,)."""
        if not self.hinges:
            return self.readout
        rows = np.array(self.readout)
        for hinge in self.hinges:
            rows[hinge.coordinate] = hinge.row(coordinates)
        return rows

    def states(self, coordinates: Array, rates: Array, angles: Array) -> tuple[Array, Array]:
        """Return q and v (k, n) of coordinates and rates (k, N), and of data coordinates (k, h)."""
        q, v = (self.readout @ coordinates.T).T, (self.readout @ rates.T).T
        q = q if self.origin is None else q + self.origin
        for hinge, angle in zip(self.hinges, angles.T, strict=True):
            q[:, hinge.coordinate] = angle
            rows = zip(coordinates, rates, strict=True)
            v[:, hinge.coordinate] = [hinge.row(at) @ speed for at, speed in rows]
        return q, v


@dataclass(frozen=True)
class Model:
    """One way to model the scene.

    Attributes
    ----------
    build : callable ``(parameters, placement) -> System``
    constrained : bool
        Whether it has algebraic constraints, which Exudyn's explicit solvers cannot keep.
    reactions : tuple of str
        Outputs of the scene that are forces in joints: the reactions of the system, in order.
    large : bool
        Whether it has so many coordinates that factorising Newton's Jacobian takes long.
    equations : callable ``(parameters) -> (EquationsOfMotion, parameters)``, or None
        The equations of motion that the model has, or converges to; the scene's without it.
    discrete : callable ``(parameters) -> EquationsOfMotion``, or None
        The equations of motion of the elements of a model that converges to a continuum, in the
        coordinates of its ``turning``.
    prescribed : callable ``(parameters) -> bool``
        Whether the first coordinate has a given motion.
    element_order : callable ``(parameters) -> int``
        Order with which it converges to that as its elements are halved; 0 without elements.
    unsupported_reason : callable ``(parameters) -> str or None``
        The reason why the model, not placed elsewhere, cannot represent these parameters.
    unplaceable_reason : callable ``(parameters) -> str or None``
        The reason why it cannot be placed in another way.
    bodies : callable ``(parameters) -> parameters``
        With which the mass matrix holds the scene's bodies alone, and nothing that drives.
    """

    build: Callable[[Any, str], ExudynSystem]
    constrained: bool
    reactions: tuple[str, ...] = ()
    large: bool = False
    equations: Callable[[Any], tuple[EquationsOfMotion, Any]] | None = None
    discrete: Callable[[Any], EquationsOfMotion] | None = None
    prescribed: Callable[[Any], bool] = lambda parameters: False
    element_order: Callable[[Any], int] = lambda parameters: 0
    unsupported_reason: Callable[[Any], str | None] = lambda parameters: None
    unplaceable_reason: Callable[[Any], str | None] = lambda parameters: None
    bodies: Callable[[Any], Any] = lambda parameters: parameters


def weigh(mbs: Any, bodies: Sequence[Any], gravity: Sequence[float]) -> None:
    """Put the weight in a gravity (3,) [m/s^2] on bodies; nothing where there is none."""
    for body in bodies if any(gravity) else ():
        marker = mbs.AddMarker(items.MarkerBodyMass(bodyNumber=body))
        mbs.AddLoad(items.LoadMassProportional(markerNumber=marker, loadVector=list(gravity)))


def harmonic_load(mbs: Any, marker: Any, amplitude: float, omega: float) -> tuple[Any, ...]:
    """Put a load amplitude * cos(omega t) on a coordinate; return what must stay alive."""
    return load_in_time(mbs, marker, amplitude, lambda t: exudyn.symbolic.cos(float(omega) * t))


def load_in_time(
    mbs: Any, marker: Any, amplitude: float, shape: Callable[[Any], Any]
) -> tuple[Any, ...]:
    """Put a load amplitude * shape(t) on a coordinate; return what must stay alive.

    Symbolic, so that Exudyn evaluates it in C++ at the time of every stage.
    """

    def force(mbs: Any, t: Any, load: Any) -> Any:
        return load * shape(t)

    symbolic = utilities.CreateSymbolicUserFunction(
        mbs, function=force, userFunctionName="loadUserFunction", itemTypeName="LoadCoordinate"
    )
    mbs.AddLoad(
        items.LoadCoordinate(markerNumber=marker, load=amplitude, loadUserFunction=symbolic)
    )
    return (symbolic,)
