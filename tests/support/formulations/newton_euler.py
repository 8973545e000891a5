"""Newton's and Euler's equations of rigid bodies that joints hold together, in 50 digits.

Maximal coordinates: each body has the accelerations of its centre of mass and of its spin, in axes
of the world. A joint adds six rows, its relative accelerations along and about three axes. Rows
that the joint holds are constraints, each with a constraint force; the others are the accelerations
of the scene's coordinates, and are read off the solution. There is no Lagrangian and no reduced
mass matrix to solve with. See P. E. Nikravesh, *Computer-Aided Analysis of Mechanical Systems*
(1988), chapters 8 and 11.

Numbers are decimals, in arrays of objects. Sizes, from which follow tolerances, are floats: what
relative errors of one ulp are relative to.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from functools import cache
from typing import Any

import mpmath
import numpy as np

DIGITS = 50
"""Digits of all decimals."""

PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459")

Rows = list[tuple[int, Any]]
"""Numbers of bodies, with the six coefficients of each one's accelerations."""

Values = Mapping[str, Any]


def decimals(values: Any) -> Any:
    """Return numbers as an array of decimals."""
    return np.vectorize(lambda x: +Decimal(x), otypes=[object])(np.asarray(values, dtype=object))


def zeros(*shape: int) -> Any:
    """Return an array of decimals that are 0."""
    return np.full(shape, Decimal(0))


@cache
def cos_sin(angle: Decimal) -> tuple[Decimal, Decimal]:
    """Return cosine and sine."""
    with mpmath.workdps(DIGITS):
        x = mpmath.mpf(str(angle))
        return Decimal(str(mpmath.cos(x))), Decimal(str(mpmath.sin(x)))


def skew(a: Any) -> Any:
    """Return the matrix of a cross product, ``skew(a) @ b``."""
    return np.array([[0 * a[0], -a[2], a[1]], [a[2], 0 * a[1], -a[0]], [-a[1], a[0], 0 * a[2]]])


def about(axis: Any, angle: Any) -> Any:
    """Return the matrix of a rotation about a unit vector, by Rodrigues."""
    cos, sin = cos_sin(angle)
    return UNIT + sin * skew(axis) + (1 - cos) * (skew(axis) @ skew(axis))


def of_quaternion(q: Any) -> Any:
    """Return the rotation matrix of a quaternion of any length, by Euler and Rodrigues."""
    cross = skew(q[1:])
    return UNIT + 2 * (q[0] * cross + cross @ cross) / (q @ q)


def rates_of(q: Any, v: Any) -> Any:
    """Return the angular velocity (3,) in the body of a quaternion and its rates."""
    return 2 * (q[0] * v[1:] - v[0] * q[1:] - skew(q[1:]) @ v[1:]) / (q @ q)


def hamilton(a: Any, b: Any) -> Any:
    """Return the product of two quaternions."""
    vector = a[0] * b[1:] + b[0] * a[1:] + skew(a[1:]) @ b[1:]
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *vector])


def norm(a: Any) -> Any:
    """Return the length of a vector."""
    return (a @ a).sqrt()


UNIT = decimals(np.eye(3, dtype=int))
ZERO = zeros(3)


@dataclass
class Body:
    """A rigid body in axes of the world.

    Attributes
    ----------
    mass : Decimal
    tensor : array (3, 3)
        About the centre of mass.
    place, velocity, spin : array (3,)
    axes : array (3, 3)
        Columns are the body's own axes.
    reach, bent, twisted : Decimal
        Sizes of the place, and of what spins alone make of both accelerations.
    wrench, wrench_size : array (6,)
        Force and torque about the centre of mass.
    """

    mass: Any = Decimal(0)
    tensor: Any = field(default_factory=lambda: 0 * UNIT)
    place: Any = field(default_factory=ZERO.copy)
    velocity: Any = field(default_factory=ZERO.copy)
    spin: Any = field(default_factory=ZERO.copy)
    axes: Any = field(default_factory=UNIT.copy)
    reach: Any = Decimal(0)
    bent: Any = Decimal(0)
    twisted: Any = Decimal(0)
    wrench: Any = field(default_factory=lambda: zeros(6))
    wrench_size: Any = field(default_factory=lambda: zeros(6))


class Mechanism:
    """Bodies, the first of which is the ground, with joints and loads.

    Attributes
    ----------
    q, v : mapping of name to Decimal
        Coordinates and their rates.
    held : list of (Rows, constant)
        Constraints ``rows . accelerations + constant = 0``.
    read : dict of name to (Rows, constant)
        Accelerations of coordinates.
    powers : dict of name to (P, size)
        Of named loads [W].
    potentials : list of (E, size)
        Contributions [J].
    given : dict of name to (number of the constraint, size)
        Coordinates whose acceleration is prescribed.
    told : dict of name to (number of the constraint, sign)
        Forces of joints, on the body further out or back on the other, that the scene tells.
    """

    def __init__(self, q: Values, v: Values) -> None:
        self.q, self.v = q, v
        self.bodies = [Body()]
        self.held: list[tuple[Rows, Any]] = []
        self.read: dict[str, tuple[Rows, Any]] = {}
        self.powers: dict[str, tuple[Any, Any]] = {}
        self.potentials: list[tuple[Any, Any]] = []
        self.given: dict[str, tuple[int, Any]] = {}
        self.told: dict[str, tuple[int, int]] = {}

    def slide(self, name: str, axis: int, mass: Any) -> int:
        """Add a body that slides along an axis of the world; return its number."""
        along = UNIT[axis]
        return self.attach(
            0, mass, {axis: name}, shift=self.q[name] * along, speed=self.v[name] * along
        )

    def hinge(self, name: str, parent: int, mass: Any, **joint: Any) -> int:
        """Add a body that a hinge turns about the z axis of its joint's frame."""
        turn, spin = about(UNIT[2], self.q[name]), self.v[name] * UNIT[2]
        return self.attach(parent, mass, {5: name}, turn=turn, spin=spin, **joint)

    def attach(
        self,
        parent: int,
        mass: Any,
        free: Mapping[int, str],
        *,
        tensor: Any = 0 * UNIT,
        arm: Any = ZERO,
        at: Any = ZERO,
        frame: Any = UNIT,
        shift: Any = ZERO,
        turn: Any = UNIT,
        speed: Any = ZERO,
        spin: Any = ZERO,
    ) -> int:
        """Add a body on a joint, and return its number.

        The joint's frame sits ``at`` a point of the parent, from its centre of mass, and is turned
        against it. In it the body's point is shifted and its axes are turned, at a speed and a
        spin; its centre of mass is an arm further. ``free`` names the coordinates by their rows:
        along 0, 1, 2 of the frame, about 3, 4, 5 of the body. Only the ground bears what shifts.
        """
        base = self.bodies[parent]
        frame = base.axes @ frame
        lever = base.axes @ at + frame @ shift
        axes = frame @ turn
        out = axes @ arm
        rate = base.spin + frame @ spin
        self.bodies.append(
            Body(
                mass,
                axes @ tensor @ axes.T,
                base.place + lever + out,
                base.velocity + skew(base.spin) @ lever + frame @ speed + skew(rate) @ out,
                rate,
                axes,
                base.reach + norm(lever) + norm(out),
                base.bent + base.spin @ base.spin * norm(lever) + rate @ rate * norm(out),
                base.twisted + norm(base.spin) * norm(rate),
            )
        )
        child = len(self.bodies) - 1
        for row, entry in enumerate(self.joint(parent, child, lever, -out, frame, axes)):
            if row in free:
                self.read[free[row]] = entry
            else:
                self.held.append(entry)
        return child

    def joint(
        self, parent: int, child: int, lever: Any, arm: Any, along: Any, around: Any
    ) -> list[tuple[Rows, Any]]:
        """Return the six rows of a joint at these levers from both centres of mass."""
        old, new = self.bodies[parent].spin, self.bodies[child].spin
        bias = skew(new) @ skew(new) @ arm - skew(old) @ skew(old) @ lever
        moved: list[tuple[Rows, Any]] = [
            ([(parent, [*-d, *(skew(d) @ lever)]), (child, [*d, *(skew(arm) @ d)])], d @ bias)
            for d in along.T
        ]
        turned: list[tuple[Rows, Any]] = [
            ([(parent, [*ZERO, *-d]), (child, [*ZERO, *d])], -d @ skew(old) @ new) for d in around.T
        ]
        return moved + turned

    def load(
        self, body: int, force: Any = ZERO, torque: Any = ZERO, name: str = "", size: Any = 1
    ) -> None:
        """Let a force at the centre of mass and a torque act; a name keeps account of the power.

        The load's own size is so many times itself.
        """
        on = self.bodies[body]
        wrench = np.array([*force, *torque])
        on.wrench = on.wrench + wrench
        on.wrench_size = on.wrench_size + size * abs(wrench)
        if name:
            power, before = self.powers.get(name, (0, 0))
            sizes = norm(force) * norm(on.velocity) + norm(torque) * norm(on.spin)
            new = power + force @ on.velocity + torque @ on.spin
            self.powers[name] = new, before + size * sizes

    def twist(self, parent: int, child: int, torque: Any, name: str = "") -> None:
        """Let a torque act on a body, about its third axis, and back on its parent."""
        vector = self.bodies[child].axes[:, 2] * torque
        self.load(child, torque=vector, name=name)
        self.load(parent, torque=-vector, name=name)

    def spring(self, stiffness: Any, *parts: Any) -> Any:
        """Return the force of a spring stretched by the sum of parts, and count its energy."""
        stretch, size = sum(parts), sum(abs(part) for part in parts)
        self.potentials.append((stiffness * stretch**2 / 2, stiffness * abs(stretch) * size))
        return -stiffness * stretch

    def weigh(self, gravity: Any) -> None:
        """Let gravity act on all bodies."""
        for number, body in enumerate(self.bodies):
            weight = body.mass * gravity
            self.load(number, weight)
            self.potentials.append((-weight @ body.place, norm(weight) * body.reach))

    def inertia(self) -> Any:
        """Return masses and tensors of all bodies but the ground, as one matrix (6 n, 6 n)."""
        n = len(self.bodies) - 1
        matrix = zeros(6 * n, 6 * n)
        for i, body in enumerate(self.bodies[1:]):
            matrix[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = body.mass * UNIT
            matrix[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = body.tensor
        return matrix

    def velocities(self) -> Any:
        """Return velocities and spins (6 n,) of all bodies but the ground."""
        return np.concatenate([[*body.velocity, *body.spin] for body in self.bodies[1:]])

    def row(self, rows: Rows) -> Any:
        """Return the coefficients (6 n,) of all accelerations."""
        full = zeros(len(self.bodies), 6)
        for body, values in rows:
            full[body] += values
        return full[1:].ravel()

    def sizes(self) -> tuple[Any, Any, Any]:
        """Return sizes of inertia (6 n, 6 n), velocities, velocity-dependent accelerations (6 n,).

        Components of vectors and tensors are rounded as these are, whatever their own sizes.
        """
        inertia = abs(self.inertia()).astype(float)
        moving, bent = np.zeros((2, len(inertia)))
        for i, body in enumerate(self.bodies[1:]):
            place, turn = slice(6 * i, 6 * i + 3), slice(6 * i + 3, 6 * i + 6)
            inertia[turn, turn] = float(body.tensor.trace())
            spin = norm(body.spin)
            moving[place], moving[turn] = norm(body.velocity) + spin * body.reach, spin
            bent[place], bent[turn] = body.bent, body.twisted
        return inertia, moving, bent

    def loads(self) -> tuple[Any, Any]:
        """Return forces, and torques less gyroscopic ones, on bodies (6 n,), and their sizes."""
        load = np.concatenate([body.wrench for body in self.bodies[1:]])
        size = np.concatenate([body.wrench_size for body in self.bodies[1:]])
        for i, body in enumerate(self.bodies[1:]):
            turn = slice(6 * i + 3, 6 * i + 6)
            load[turn] -= skew(body.spin) @ body.tensor @ body.spin
            size[turn] += abs(skew(body.spin)) @ abs(body.tensor) @ abs(body.spin)
        return load, size.astype(float)

    def move(self) -> tuple[dict[str, Any], Any, Any]:
        """Return accelerations by coordinate, those of bodies (6 n,), and constraint forces."""
        jacobian = np.array([self.row(rows) for rows, _ in self.held])
        constants = [constant for _, constant in self.held]
        bodies, forces = constrained(self.inertia(), self.loads()[0], jacobian, constants)
        read = {name: self.row(rows) @ bodies + more for name, (rows, more) in self.read.items()}
        return read, bodies, forces


def solve(matrix: Any, right: Any) -> Any:
    """Return x of A x = b, by elimination with row exchanges that skips zeros."""
    a = np.column_stack([matrix, right])
    n = len(a)
    for k in range(n):
        pivot = k + int(np.argmax(abs(a[k:, k])))
        a[[k, pivot]] = a[[pivot, k]]
        below = k + 1 + np.flatnonzero(a[k + 1 :, k] != 0)
        across = k + np.flatnonzero(a[k, k:] != 0)
        a[np.ix_(below, across)] -= np.outer(a[below, k] / a[k, k], a[k, across])
    x = a[:, n].copy()
    for k in reversed(range(n)):
        x[k] = (x[k] - a[k, k + 1 : n] @ x[k + 1 :]) / a[k, k]
    return x


def constrained(inertia: Any, load: Any, jacobian: Any, constants: Any) -> tuple[Any, Any]:
    """Return accelerations and constraint forces, ``jacobian @ accelerations + constants = 0``."""
    matrix = np.block([[inertia, -jacobian.T], [jacobian, zeros(len(jacobian), len(jacobian))]])
    x = solve(matrix, np.concatenate([load, [-value for value in constants]]))
    return x[: len(inertia)], x[len(inertia) :]
