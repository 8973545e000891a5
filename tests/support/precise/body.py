"""A rigid body about a point, fixed or on a slide, as power series in time: Euler's equations.

The coordinates are a quaternion of any length; the rate of the logarithm of its length stays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product as pairs
from operator import mul
from typing import Any

import gmpy2

Numbers = list[Any]


class Body:
    """Euler's equations of a body that turns under gravity, as a `System`.

    Attributes
    ----------
    breaks : tuple of numbers
        None.
    arm, gravity : list of numbers (3,)
    inertia, inverse : list of list of numbers (3, 3)
        About the point, in the frame of the body.
    slide : mapping of name to number
        Parameters of the slide along y on which the point is; empty where it is fixed.
    """

    breaks: tuple[Any, ...] = ()

    def __init__(self, p: Any, bits: int) -> None:
        value = {name: gmpy2.mpfr(number) for name, number in p.as_dict().items()}
        centre = [value[f"centre_{axis}"] for axis in "xyz"]
        moments = [value[f"moment_{i}"] for i in (1, 2, 3)]
        axes = rodrigues([value[f"axes_{axis}"] for axis in "xyz"])
        far = sum(c * c for c in centre)
        mass = value["mass"]
        self.inertia = [
            [
                sum(axes[i][k] * moments[k] * axes[j][k] for k in range(3))
                + mass * ((far if i == j else 0) - centre[i] * centre[j])
                for j in range(3)
            ]
            for i in range(3)
        ]
        self.inverse = inverse_of(self.inertia)
        self.arm = [mass * c for c in centre]
        self.gravity = [value[f"gravity_{axis}"] for axis in "xyz"]
        self.slide = {name: value[name] for name in SLIDE if name in value}
        if self.slide:
            self.slide["mass"] = value["main_mass"] + mass
            self.slide["omega"] = 2 * gmpy2.const_pi() * value["force_frequency"]

    def to_float(self) -> None:
        """Compute with doubles from now on."""
        self.arm, self.gravity = ([float(x) for x in row] for row in (self.arm, self.gravity))
        self.inertia, self.inverse = (
            [[float(x) for x in row] for row in rows] for rows in (self.inertia, self.inverse)
        )
        self.slide = {name: float(x) for name, x in self.slide.items()}

    def expand(self, time: Any, state: Numbers, order: int) -> list[Numbers]:
        """Return the Taylor coefficients (n, order + 1) of the coordinates about a time."""
        zero, half = state[0] * 0, len(state) // 2
        turn, rate = state[half - 4 : half], state[-4:]
        size = sum(x * x for x in turn)
        start = [x / size for x in hamilton([turn[0], *(-x for x in turn[1:])], rate)]
        growth = start[0]
        slide = Slide(self, time, state[0], state[half]) if self.slide else None
        friction = self.slide.get("joint_damping", zero)
        q: list[Numbers] = [[x] for x in turn]
        omega: list[Numbers] = [[2 * x] for x in start[1:]]
        # of the rotation: entries of q q^T, the square of the length and its reciprocal
        inverse: Numbers = []
        squares: Numbers = []
        outer: dict[tuple[int, int], Numbers] = {at: [] for at in pairs(range(4), range(4))}
        pull: list[Numbers] = [[], [], []]
        side: list[Numbers] = [[], [], []]
        wanted = [(pull, self.gravity), (side, [zero, zero + 1, zero])][: 2 if slide else 1]
        spin: list[Numbers] = [[], [], []]
        for k in range(order):
            for i, j in outer:
                outer[i, j].append(term(q[i], q[j]))
            squares.append(sum(outer[i, i][k] for i in range(4)))
            inverse.append(1 / squares[0] if k == 0 else -term(squares[1:], inverse) * inverse[0])
            for parts, vector in wanted:
                for j, row in enumerate(pulled(outer, k, vector)):
                    parts[j].append(row)
            ahead = [term(part, inverse) for part in pull]
            for i in range(3):
                spin[i].append(
                    sum(mul(a, w[k]) for a, w in zip(self.inertia[i], omega, strict=True))
                )
            moment = []
            for i in range(3):
                a, b = (i + 1) % 3, (i + 2) % 3
                gyroscopic = term(omega[a], spin[b]) - term(omega[b], spin[a])
                weight = self.arm[a] * ahead[b] - self.arm[b] * ahead[a]
                moment.append(weight - gyroscopic - friction * omega[i][k])
            faster = times(self.inverse, moment)
            if slide is not None:
                slide.expand(omega, [term(part, inverse) for part in side], faster)
            rates = [[growth if m == 0 else zero for m in range(k + 1)], *halves(omega)]
            turned = series_product(q, rates)
            for i in range(4):
                q[i].append(turned[i] / (k + 1))
            for i in range(3):
                omega[i].append(faster[i] / (k + 1))
        return q if slide is None else [slide.places, *q]


SLIDE = ("stiffness", "damping", "joint_damping", "force_amplitude")
"""Parameters of what holds and drives the slide, and of the friction in the joint."""


class Slide:
    """The series of the motion along y, one coefficient after the other."""

    def __init__(self, body: Body, time: Any, place: Any, speed: Any) -> None:
        self.body, self.places, self.speeds = body, [place], [speed]
        self.faster: Numbers = []
        self.room: Numbers = []
        self.axis, self.swing, self.bend = vectors(), vectors(), vectors()
        self.lever, self.pushed, self.free = vectors(), vectors(), vectors()
        omega = body.slide["omega"]
        cos, sin = (math.cos, math.sin) if isinstance(time, float) else (gmpy2.cos, gmpy2.sin)
        phase = omega * time
        self.waves = (cos(phase), -sin(phase), -cos(phase), sin(phase))
        self.wave = body.slide["force_amplitude"]

    def expand(self, omega: list[Numbers], axis: Numbers, faster: Numbers) -> None:
        """Add the next coefficient, and what the slide's acceleration adds to that of the body."""
        p, arm, k = self.body.slide, self.body.arm, len(self.faster)
        lever = [arm[a] * axis[b] - arm[b] * axis[a] for a, b in AHEAD]
        swing = [omega[a][k] * arm[b] - omega[b][k] * arm[a] for a, b in AHEAD]
        series = (self.axis, self.lever, self.pushed, self.free, self.swing)
        rows = (axis, lever, times(self.body.inverse, lever), faster, swing)
        for parts, row in zip(series, rows, strict=True):
            for part, value in zip(parts, row, strict=True):
                part.append(value)
        for i, (a, b) in enumerate(AHEAD):
            self.bend[i].append(term(omega[a], self.swing[b]) - term(omega[b], self.swing[a]))
        force = self.wave * self.waves[k % 4]
        force -= p["damping"] * self.speeds[k] + p["stiffness"] * self.places[k]
        force -= sum(map(term, self.axis, self.bend)) + sum(map(term, self.lever, self.free))
        room = -sum(map(term, self.lever, self.pushed))
        if k == 0:
            force += p["mass"] * self.body.gravity[1]
            room += p["mass"]
        self.room.append(room)
        known = term(self.faster, self.room[1:]) if k else 0 * force
        self.faster.append((force - known) / self.room[0])
        for i in range(3):
            faster[i] -= term(self.faster, self.pushed[i])
        self.wave = self.wave * p["omega"] / (k + 1)
        self.places.append(self.speeds[k] / (k + 1))
        self.speeds.append(self.faster[k] / (k + 1))


AHEAD = ((1, 2), (2, 0), (0, 1))
"""Components of the factors of a cross product."""


def vectors() -> list[Numbers]:
    """Return three series without a coefficient."""
    return [[], [], []]


def pulled(outer: dict[tuple[int, int], Numbers], k: int, vector: Numbers) -> Numbers:
    """Return coefficient k of a vector of the world in the frame of the body, times |q|^2."""
    at = {place: values[k] for place, values in outer.items()}
    ww, xx, yy, zz = (at[i, i] for i in range(4))
    rows = [
        [ww + xx - yy - zz, 2 * (at[1, 2] - at[0, 3]), 2 * (at[1, 3] + at[0, 2])],
        [2 * (at[1, 2] + at[0, 3]), ww - xx + yy - zz, 2 * (at[2, 3] - at[0, 1])],
        [2 * (at[1, 3] - at[0, 2]), 2 * (at[2, 3] + at[0, 1]), ww - xx - yy + zz],
    ]
    return [sum(rows[i][j] * vector[i] for i in range(3)) for j in range(3)]


def times(matrix: list[Numbers], vector: Numbers) -> Numbers:
    """Return the product of a matrix with a vector."""
    return [sum(map(mul, row, vector)) for row in matrix]


def term(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Return the last coefficient of the product of two series of one length."""
    return sum(map(mul, a, b[::-1]))


def halves(series: list[Numbers]) -> list[Numbers]:
    """Return half of each series."""
    return [[x / 2 for x in one] for one in series]


def series_product(a: list[Numbers], b: list[Numbers]) -> Numbers:
    """Return the last coefficients of the product of two quaternions."""
    p = [[term(x, y) for y in b] for x in a]
    return [
        p[0][0] - p[1][1] - p[2][2] - p[3][3],
        p[0][1] + p[1][0] + p[2][3] - p[3][2],
        p[0][2] - p[1][3] + p[2][0] + p[3][1],
        p[0][3] + p[1][2] - p[2][1] + p[3][0],
    ]


def hamilton(a: Numbers, b: Numbers) -> Numbers:
    """Return the product of two quaternions."""
    return series_product([[x] for x in a], [[x] for x in b])


def rodrigues(vector: Numbers) -> list[Numbers]:
    """Return the matrix (3, 3) of a rotation vector."""
    angle = gmpy2.sqrt(sum(x * x for x in vector))
    x, y, z = vector if angle == 0 else (part / angle for part in vector)
    sine, rest = gmpy2.sin(angle), 1 - gmpy2.cos(angle)
    return [
        [1 - rest * (y * y + z * z), rest * x * y - sine * z, rest * x * z + sine * y],
        [rest * x * y + sine * z, 1 - rest * (x * x + z * z), rest * y * z - sine * x],
        [rest * x * z - sine * y, rest * y * z + sine * x, 1 - rest * (x * x + y * y)],
    ]


def inverse_of(a: list[Numbers]) -> list[Numbers]:
    """Return the inverse of a matrix (3, 3), by its cofactors."""

    def cofactor(i: int, j: int) -> Any:
        (a1, a2), (b1, b2) = (((i + 1) % 3, (i + 2) % 3), ((j + 1) % 3, (j + 2) % 3))
        return a[a1][b1] * a[a2][b2] - a[a1][b2] * a[a2][b1]

    whole = sum(a[0][j] * cofactor(0, j) for j in range(3))
    return [[cofactor(j, i) / whole for j in range(3)] for i in range(3)]
