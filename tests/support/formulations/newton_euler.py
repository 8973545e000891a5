"""Newton's and Euler's equations of rigid bodies that joints hold together, in 50 digits.

Maximal coordinates: each body has the accelerations of its centre of mass and of its spin, in axes
of the world. A joint adds six rows, its relative accelerations along and about three axes. Rows
that the joint holds are constraints, each with a constraint force; the others are the accelerations
of the scene's coordinates, and are read off the solution. There is no Lagrangian, no generalised
force and no reduced mass matrix to solve with. See P. E. Nikravesh, *Computer-Aided Analysis of
Mechanical Systems* (1988), chapters 8 and 11.

Numbers are decimals, in arrays of objects.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from functools import cache
from typing import Any

import mpmath
import numpy as np

DIGITS = 50
"""Digits of all decimals."""

PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459")

EPS = float(np.finfo(float).eps)

Rows = list[tuple[int, Any]]
"""Numbers of bodies, with the six coefficients of each one's accelerations."""


def decimals(values: Any) -> Any:
    """Return numbers as an array of the decimals that they are."""
    return np.vectorize(Decimal, otypes=[object])(np.asarray(values, dtype=object))


@cache
def cos_sin(angle: Decimal) -> tuple[Decimal, Decimal]:
    """Return cosine and sine."""
    with mpmath.workdps(DIGITS):
        x = mpmath.mpf(str(angle))
        return Decimal(str(mpmath.cos(x))), Decimal(str(mpmath.sin(x)))


def skew(a: Any) -> Any:
    """Return the matrix of a cross product, ``skew(a) @ b``."""
    zero = 0 * a[0]
    return np.array([[zero, -a[2], a[1]], [a[2], zero, -a[0]], [-a[1], a[0], zero]])


def about(axis: int, angle: Any) -> Any:
    """Return the matrix of a rotation about a coordinate axis."""
    cos, sin = cos_sin(angle)
    cross = skew(UNIT[axis])
    return UNIT + sin * cross + (1 - cos) * (cross @ cross)


def of_quaternion(q: Any) -> Any:
    """Return the rotation matrix of a quaternion of any length, by Euler and Rodrigues."""
    cross = skew(q[1:])
    return UNIT + 2 * (q[0] * cross + cross @ cross) / (q @ q)


def norm(a: Any) -> Any:
    """Return the length of a vector."""
    return (a @ a).sqrt()


UNIT = decimals(np.eye(3, dtype=int))
ZERO = decimals(np.zeros(3, dtype=int))


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
    reach : Decimal
        Sum of the lengths of all arms up to the centre of mass [m].
    bent, twisted : Decimal
        Sizes of what the spins alone make of the accelerations of the centre of mass and of spin.
    wrench, size : array (6,)
        Force and torque about the centre of mass, and the sum of their contributions' sizes.
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
    wrench: Any = field(default_factory=lambda: decimals(np.zeros(6, dtype=int)))
    size: Any = field(default_factory=lambda: decimals(np.zeros(6, dtype=int)))


class Mechanism:
    """Bodies, the first of which is the ground, with joints and loads.

    Attributes
    ----------
    held : list of (Rows, constant, size)
        Constraints ``rows . accelerations + constant = 0``.
    read : dict of name to (Rows, constant, size)
        Accelerations of coordinates.
    powers, power_sizes : dict
        Of named loads [W], and the sum of the contributions' sizes.
    potentials : list of (E, size)
        Contributions [J].
    """

    def __init__(self) -> None:
        self.bodies = [Body()]
        self.held: list[tuple[Rows, Any, Any]] = []
        self.read: dict[str, tuple[Rows, Any, Any]] = {}
        self.powers: dict[str, Any] = {}
        self.power_sizes: dict[str, Any] = {}
        self.potentials: list[tuple[Any, Any]] = []

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

        The joint's frame sits ``at`` the parent's axes, from its centre of mass, and is turned
        against them. In it the body's point is shifted and its axes are turned, at a speed and a
        spin; its centre of mass is an arm further. ``free`` names the coordinates, by their rows:
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
    ) -> list[tuple[Rows, Any, Any]]:
        """Return the six rows of a joint at these levers from both centres of mass."""
        old, new = self.bodies[parent].spin, self.bodies[child].spin
        bias = skew(new) @ skew(new) @ arm - skew(old) @ skew(old) @ lever
        size = new @ new * norm(arm) + old @ old * norm(lever)
        rows = []
        for d in along.T:
            ends = [(parent, [*-d, *-(skew(lever) @ d)]), (child, [*d, *(skew(arm) @ d)])]
            rows.append((ends, d @ bias, size))
        for d in around.T:
            ends = [(parent, [*ZERO, *-d]), (child, [*ZERO, *d])]
            rows.append((ends, -d @ skew(old) @ new, norm(old) * norm(new)))
        return rows

    def load(
        self, body: int, force: Any = ZERO, torque: Any = ZERO, name: str = "", size: Any = 1
    ) -> None:
        """Let a force at the centre of mass and a torque act; a name keeps account of power.

        The load is rounded as ``size`` times itself would be.
        """
        on = self.bodies[body]
        wrench = np.array([*force, *torque])
        on.wrench = on.wrench + wrench
        on.size = on.size + size * abs(wrench)
        if name:
            power = force @ on.velocity + torque @ on.spin
            size *= norm(force) * norm(on.velocity) + norm(torque) * norm(on.spin)
            self.powers[name] = self.powers.get(name, 0) + power
            self.power_sizes[name] = self.power_sizes.get(name, 0) + size

    def twist(self, parent: int, child: int, torque: Any, name: str = "") -> None:
        """Let a torque act on a body, about its third axis, and back on its parent."""
        vector = self.bodies[child].axes[:, 2] * torque
        self.load(child, torque=vector, name=name)
        self.load(parent, torque=-vector, name=name)

    def weigh(self, gravity: Any) -> None:
        """Let gravity act on all bodies."""
        for number, body in enumerate(self.bodies):
            weight = body.mass * gravity
            self.load(number, weight)
            self.potentials.append((-weight @ body.place, norm(weight) * body.reach))

    def inertia(self) -> Any:
        """Return masses and tensors of all bodies but the ground, as one matrix (6 n, 6 n)."""
        n = len(self.bodies) - 1
        matrix = decimals(np.zeros((6 * n, 6 * n), dtype=int))
        for i, body in enumerate(self.bodies[1:]):
            matrix[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = body.mass * UNIT
            matrix[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = body.tensor
        return matrix

    def velocities(self) -> Any:
        """Return velocities and spins (6 n,) of all bodies but the ground."""
        return np.concatenate([[*b.velocity, *b.spin] for b in self.bodies[1:]])

    def row(self, rows: Rows) -> Any:
        """Return the coefficients (6 n,) of all accelerations."""
        full = decimals(np.zeros((len(self.bodies), 6), dtype=int))
        for body, values in rows:
            full[body] += values
        return full[1:].ravel()

    def sizes(self) -> tuple[Any, Any, Any]:
        """Return sizes of inertia (6 n, 6 n), velocities and velocity-dependent accelerations (6 n,).

        Those of vectors and tensors, of which components are rounded as their sizes are.
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


@dataclass
class Motion:
    """The solution of Newton's and Euler's equations.

    Attributes
    ----------
    accelerations, errors : dict
        By coordinate, and what round-off of one ulp in each entry of the equations makes of them.
    bodies : array (6 n,)
        Accelerations of all bodies.
    load, load_size : array (6 n,)
        Forces and torques less gyroscopic ones, and the sum of the contributions' sizes.
    reactions : array (m,)
        Constraint forces on the children.
    """

    accelerations: dict[str, Any]
    errors: dict[str, float]
    bodies: Any
    load: Any
    load_size: Any
    reactions: Any


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


def constrained(
    inertia: Any, load: Any, load_sizes: Any, jacobian: Any, constants: Any, sizes: Any
) -> tuple[Any, Any]:
    """Return accelerations and constraint forces under ``jacobian @ accelerations + constants = 0``.

    Beside them, what round-off of one ulp in each entry makes of them (Skeel's condition; N. J.
    Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd edition (2002), theorem 7.4).
    """
    matrix = np.block([[inertia, -jacobian.T], [jacobian, 0 * jacobian @ jacobian.T]])
    x = solve(matrix, np.concatenate([load, [-value for value in constants]]))
    residual = abs(matrix) @ abs(x) + np.concatenate([load_sizes, sizes])
    inverse = abs(np.linalg.inv(matrix.astype(float)))
    return x, EPS * inverse @ residual.astype(float)


def move(m: Mechanism) -> Motion:
    """Solve for the accelerations of all bodies and the constraint forces."""
    inertia = m.inertia()
    jacobian = np.array([m.row(rows) for rows, _, _ in m.held])
    load = np.concatenate([b.wrench for b in m.bodies[1:]])
    size = np.concatenate([b.size for b in m.bodies[1:]])
    for i, body in enumerate(m.bodies[1:]):
        turn = slice(6 * i + 3, 6 * i + 6)
        load[turn] -= skew(body.spin) @ body.tensor @ body.spin
        size[turn] += abs(skew(body.spin)) @ abs(body.tensor) @ abs(body.spin)
    constants, sizes = ([entry[i] for entry in m.held] for i in (1, 2))
    x, errors = constrained(inertia, load, size, jacobian, constants, sizes)
    bodies, n = x[: len(inertia)], len(inertia)
    accelerations, uncertain = {}, {}
    for name, (rows, constant, row_size) in m.read.items():
        row = m.row(rows)
        accelerations[name] = row @ bodies + constant
        uncertain[name] = float(abs(row).astype(float) @ errors[:n] + EPS * float(row_size))
    return Motion(accelerations, uncertain, bodies, load, size, x[n:])


def hamilton(a: Any, b: Any) -> Any:
    """Return the product of two quaternions."""
    vector = a[0] * b[1:] + b[0] * a[1:] + skew(a[1:]) @ b[1:]
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *vector])


def rates_of(q: Any, v: Any) -> Any:
    """Return the angular velocity (3,) in the body of a quaternion and its rates."""
    return 2 * (q[0] * v[1:] - v[0] * q[1:] - skew(q[1:]) @ v[1:]) / (q @ q)


def quaternion_accelerations(
    q: Any, v: Any, turning: Sequence[Any], errors: Sequence[float]
) -> tuple[Any, Any]:
    """Return q'' of q' = q (rho, omega / 2), with omega' (3,) and rho' = 0, and its errors."""
    rates = np.array([q @ v / (q @ q), *rates_of(q, v) / 2])
    values = hamilton(v, rates) + hamilton(q, np.array([Decimal(0), *np.array(turning) / 2]))
    length = float(norm(q))
    size = EPS * float(v @ v) / length + length * float(np.linalg.norm(errors)) / 2
    return values, [size + EPS * abs(float(x)) for x in values]
