"""The rotating beam in any precision: polynomial shapes, and the principle of d'Alembert.

With the angles psi of the beam at Gauss points, the place of every point in the axes of the hub is
a sum of ``exp(i psi)`` with constant factors, and so are its velocity and acceleration. Hence the
generalised forces of inertia are ``A' Re(conj(i E) (B E''))`` with ``E = exp(i psi)``, its second
derivative in axes at rest, a constant matrix B of masses, and A of the derivatives of the angles by
the coordinates. Nothing is subtracted that nearly cancels where the beam is nearly straight.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import gmpy2
import numpy as np

from mbcheck.reference.rotating_beam import BENDING
from mbcheck.reference.rotating_beam.shapes import MORE_POINTS, polynomials
from mbcheck.tests.support.precise.series import Numbers

Array = np.ndarray[Any, Any]

HAS_EXTENDED = float(np.finfo(np.longdouble).eps) < 2e-19
"""Whether NumPy has numbers of 64 bits, with which this is ten times faster."""


@dataclass(frozen=True)
class Table:
    """The shapes of a beam with its mass at one place, lengths over L.

    Attributes
    ----------
    angle, curvature : array (g, n)
        At the Gauss points.
    weights : array (g,)
    integral : array (g + 1, g)
        From the clamp to the Gauss points and to the mass.
    """

    angle: Any
    curvature: Any
    weights: Any
    integral: Any


@cache
def table_of(place: float, bits: int) -> Table:
    """Return the shapes that the reference documents, by exact integrals of Legendre polynomials.

    The curvature is a polynomial on each side of the mass, continuous there and zero at the tip. A
    coordinate is the angle at one Gauss point: which one, the reference says.
    """
    n = BENDING
    first = 2 + round((n - 2) * place)
    parts = [(0, 1, n + 1)] if place == 1 else [(0, place, first), (place, 1, n + 2 - first)]
    with gmpy2.context(gmpy2.get_context(), precision=bits):
        sides = [
            Side.of(gmpy2.mpfr(start), gmpy2.mpfr(end), degree) for start, end, degree in parts
        ]
        angle, curvature = (np.array(rows) for rows in basis(sides))
        weights = np.concatenate([side.weights for side in sides])
        points = np.concatenate([side.points for side in sides])
        integral = np.hstack(
            [np.array([side.integrals(x) for x in (*points, gmpy2.mpfr(place))]) for side in sides]
        )
        known = polynomials(n, 0, place).angle
        nodes = [int(np.argmin(np.sum((known - one) ** 2, axis=1))) for one in np.eye(n)]
        to_nodes = inverse(angle[nodes])
        return Table(angle @ to_nodes, curvature @ to_nodes, weights, integral)


@dataclass(frozen=True)
class Side:
    """One polynomial piece from ``start`` to ``end``, with its Gauss points."""

    start: Any
    half: Any
    degree: int
    local: Any
    weights: Any

    @classmethod
    def of(cls, start: Any, end: Any, degree: int) -> Side:
        """Return a piece for angles of this degree."""
        local, weights = gauss(degree + MORE_POINTS)
        half = (end - start) / 2
        return cls(start, half, degree, local, half * weights)

    @property
    def points(self) -> Any:
        """Gauss points."""
        return self.start + self.half * (1 + self.local)

    def integrals(self, x: Any) -> list[Any]:
        """Return the integrals up to x of the polynomials that are 1 at one Gauss point."""
        count = len(self.local)
        upto = self.upto((x - self.start) / self.half - 1, count)
        return [
            w * sum((2 * j + 1) * p * up for j, (p, up) in enumerate(zip(*values, strict=True))) / 2
            for w, values in (
                (w, (legendre(at, count - 1), upto))
                for w, at in zip(self.weights, self.local, strict=True)
            )
        ]

    def upto(self, x: Any, count: int) -> list[Any]:
        """Return the integrals of the first Legendre polynomials from -1 to x, on -1 to 1."""
        x = min(max(x, x * 0 - 1), x * 0 + 1)
        p = legendre(x, count)
        return [x + 1, *((p[j + 1] - p[j - 1]) / (2 * j + 1) for j in range(1, count))]


def legendre(x: Any, most: int) -> list[Any]:
    """Return the Legendre polynomials up to a degree."""
    values = [x * 0 + 1, x]
    for j in range(1, most):
        values.append(((2 * j + 1) * x * values[-1] - j * values[-2]) / (j + 1))
    return values[: most + 1]


def gauss(count: int) -> tuple[Any, Any]:
    """Return the Gauss points and weights on -1 to 1, by Newton's method."""
    points, weights = [], []
    for i in range(count):
        x = gmpy2.cos(gmpy2.const_pi() * (4 * i + 3) / (4 * count + 2))
        for _ in range(12):
            p = legendre(x, count)
            slope = count * (p[-2] - x * p[-1]) / (1 - x * x)
            x -= p[-1] / slope
        points.append(x)
        weights.append(2 / ((1 - x * x) * slope * slope))
    return np.array(points[::-1]), np.array(weights[::-1])


def basis(sides: list[Side]) -> tuple[list[list[Any]], list[list[Any]]]:
    """Return angles and curvatures of a basis at all Gauss points, (g, n) both."""
    last = len(sides) - 1
    angles, curvatures = [], []
    for i, side in enumerate(sides):
        end = side.half * 0 + 1
        for x in side.local:
            p, up = legendre(x, side.degree), side.upto(x, side.degree)
            row, turn = [], []
            for j, other in enumerate(sides):
                pairs = inner(other, last > 0 and j == last)
                for combine in pairs:
                    whole = side.half * 0
                    if i == j:
                        row.append(combine(p))
                        turn.append(side.half * combine(up))
                    elif i > j:
                        row.append(whole)
                        turn.append(other.half * combine(other.upto(end, other.degree)))
                    else:
                        row.append(whole)
                        turn.append(whole)
            if last > 0:  # constant up to the mass, and falling to nothing at the tip
                row.append(end if i == 0 else (p[0] - p[1]) / 2)
                before = 2 * sides[0].half
                turn.append(
                    side.half * up[0] if i == 0 else before + side.half * (up[0] - up[1]) / 2
                )
            angles.append(turn)
            curvatures.append(row)
    return angles, curvatures


def inner(side: Side, both: bool) -> list[Callable[[list[Any]], Any]]:
    """Return combinations of Legendre polynomials that vanish at the end, or at both ends."""
    if both:
        return [lambda p, j=j: p[j] - p[j - 2] for j in range(2, side.degree)]  # type: ignore[misc]
    return [lambda p, j=j: p[j] - p[0] for j in range(1, side.degree)]  # type: ignore[misc]


def inverse(matrix: Array) -> Array:
    """Return the inverse, by elimination with pivots."""
    n = len(matrix)
    rows = np.hstack([matrix, np.eye(n, dtype=int) + matrix * 0])
    for column in range(n):
        pivot = column + int(np.argmax(np.abs(rows[column:, column])))
        rows[[column, pivot]] = rows[[pivot, column]]
        rows[column] = rows[column] / rows[column, column]
        factors = rows[:, column].copy()
        factors[column] = factors[column] * 0
        rows = rows - factors[:, None] * rows[column]
    return rows[:, n:]


class Beam:
    """The beam's equations as a `System`, its hub driven or prescribed.

    Attributes
    ----------
    jacobian : array (g + 1, n + 1)
        Absolute angles by coordinates, the hub's first.
    masses : array (g + 1, g + 1)
        B.
    weight : array (g + 1,)
        Mass times L^2 that each tangent carries.
    gravity : array (2,)
        Over L, along the axes of theta = 0.
    stiffness : array (n + 1, n + 1)
    hub : number
        Moment of inertia.
    end : number
        Time [s] at which the drive ends.
    """

    def __init__(self, p: Any, bits: int) -> None:
        place = float(p.mass_position) if p.mass > 0 else 1.0
        table = table_of(place, bits)
        with gmpy2.context(gmpy2.get_context(), precision=bits):
            number = gmpy2.mpfr
            length, line = number(p.length), number(p.density) * number(p.area)
            station = np.append(line * length**3 * table.weights, number(p.mass) * length**2)
            arm = np.full((len(station), 1), number(p.hub_radius) / length)
            lever = np.hstack([arm, table.integral])
            self.masses = lever.T @ (station[:, None] * lever)
            self.weight = lever.T @ station
            self.gravity = np.array([number(p.gravity_x), number(p.gravity_y)]) / length
            zero = np.full((1, table.angle.shape[1]), number(0))
            rigid = np.full((len(table.angle) + 1, 1), number(1))
            self.jacobian = np.hstack([rigid, np.vstack([zero, table.angle])])
            bending = number(p.youngs_modulus) * number(p.second_moment) / length
            n = table.angle.shape[1] + 1
            self.stiffness = np.full((n, n), number(0))
            self.stiffness[1:, 1:] = bending * (
                table.curvature.T @ (table.weights[:, None] * table.curvature)
            )
            self.hub = number(p.hub_inertia)
            self.prescribed = p.drive == "prescribed"
            if self.prescribed:
                self.end = number(p.ramp_time)
                self.drive = number(p.angular_speed) / self.end if p.ramp_time > 0 else number(0)
            else:
                self.end, self.drive = number(p.torque_period), number(p.torque_amplitude)
            self.omega = 2 * gmpy2.const_pi() / self.end if self.end > 0 else number(0)
        self.kind: Any = gmpy2.mpfr
        self.breaks = (self.end,)

    def to_float(self) -> None:
        """Compute with doubles from now on."""
        self.convert(float, lambda value: float(value))

    def to_extended(self) -> Any:
        """Compute with numbers of 64 bits from now on; returns their type."""
        self.convert(np.longdouble, lambda value: np.longdouble(str(value)))
        return np.longdouble

    def convert(self, kind: Any, number: Callable[[Any], Any]) -> None:
        """Compute with other numbers from now on."""
        self.kind = kind
        for name in ("masses", "jacobian", "stiffness", "weight", "gravity"):
            values = getattr(self, name)
            flat = [number(value) for value in values.ravel()]
            setattr(self, name, np.array(flat, dtype=kind).reshape(values.shape))
        for name in ("hub", "drive", "end", "omega"):
            setattr(self, name, number(getattr(self, name)))
        self.breaks = (self.end,)

    def functions(self, angles: Any) -> tuple[Any, Any]:
        """Return cosines and sines."""
        if self.kind is gmpy2.mpfr:
            pairs = [(gmpy2.cos(x), gmpy2.sin(x)) for x in angles]
            return tuple(map(np.array, zip(*pairs, strict=True)))  # type: ignore[return-value]
        return np.cos(angles), np.sin(angles)

    def driven(self, time: Any, order: int) -> list[Any]:
        """Return the Taylor coefficients of the hub's acceleration, or of the torque on it."""
        zero = time * 0
        if time >= self.end:
            return [zero] * order
        (_, cosine), (half, sine) = self.functions(np.array([time / 2, time]) * self.omega)
        values, factor = [], self.drive
        for k in range(order):
            if self.prescribed:
                turn = (cosine, -sine, -cosine, sine)[k % 4]
                values.append(factor * (-turn if k else 2 * half * half))  # 1 - cosine
            else:
                values.append(factor * (sine, cosine, -sine, -cosine)[k % 4])
            factor = factor * self.omega / (k + 1)
        return values

    def expand(self, time: Any, state: Numbers, order: int) -> list[Numbers]:
        """Return the Taylor coefficients (n, order + 1) of the coordinates about a time.

        In axes that turn with the hub, with the beam's angles psi in them, ``E = exp(i psi)`` and
        all that turns with ``theta' + psi'``, the velocities ``U = i (theta' + psi') E`` have the
        derivative ``U' + i theta' U`` in axes at rest.
        """
        n = len(state) // 2
        dtype = object if self.kind is gmpy2.mpfr else self.kind
        zero = state[0] * 0
        q = np.full((order + 2, n), zero, dtype=dtype)
        q[0], q[1] = state[:n], state[n:]
        slopes, turns, x, y, u_x, u_y, push_x, push_y = (
            np.full((order + 2, len(self.jacobian)), zero, dtype=dtype) for _ in range(8)
        )
        x[0], y[0] = self.functions(self.jacobian[:, 1:] @ q[0, 1:])
        mass = self.jacobian.T @ (
            self.masses * (np.outer(x[0], x[0]) + np.outer(y[0], y[0])) @ self.jacobian
        )
        mass[0, 0] += self.hub
        free = slice(1, n) if self.prescribed else slice(0, n)
        solver = inverse(mass[free, free])
        drive = self.driven(time, order)
        speed, along, across = (np.full((order + 2, 1), zero, dtype=dtype) for _ in range(3))
        (cos,), (sin,) = self.functions(q[0, :1])
        g_x, g_y = self.gravity
        along[0], across[0] = g_x * cos + g_y * sin, g_y * cos - g_x * sin
        for k in range(order):
            speed[k] = (k + 1) * q[k + 1, 0]
            slopes[k + 1] = (k + 1) * (self.jacobian[:, 1:] @ q[k + 1, 1:])
            turns[k] = slopes[k + 1] + speed[k]
            x[k + 1] = -product(slopes[1:], y, k) / (k + 1)
            y[k + 1] = product(slopes[1:], x, k) / (k + 1)
            u_x[k], u_y[k] = -product(turns, y, k), product(turns, x, k)
            # all but what the unknown accelerations make of it
            turn = self.jacobian[:, 0] * drive[k] if self.prescribed else zero
            last_x = -turn * y[0] - (k + 1) * product(turns, y[1:], k) - product(speed, u_y, k)
            last_y = turn * x[0] + (k + 1) * product(turns, x[1:], k) + product(speed, u_x, k)
            push_x[k], push_y[k] = self.masses @ last_x, self.masses @ last_y
            load = self.jacobian.T @ (product(y, push_x, k) - product(x, push_y, k))
            load -= self.stiffness @ q[k]
            weight = product(x, across, k) - product(y, along, k)
            load += self.jacobian.T @ (self.weight * weight)
            along[k + 1] = product(speed, across, k) / (k + 1)
            across[k + 1] = -product(speed, along, k) / (k + 1)
            a = np.full(n, zero, dtype=dtype)
            if self.prescribed:
                a[0] = drive[k]
            else:
                load[0] += drive[k]
            a[free] = solver @ load[free]
            q[k + 2] = a / ((k + 1) * (k + 2))
            turn = self.jacobian[:, free] @ a[free]
            push_x[k] -= self.masses @ (turn * y[0])
            push_y[k] += self.masses @ (turn * x[0])
        return [list(q[: order + 1, i]) for i in range(n)]


def product(a: Array, b: Array, k: int) -> Any:
    """Return coefficient k of products of power series."""
    return np.add.reduce(a[: k + 1] * b[k::-1])
