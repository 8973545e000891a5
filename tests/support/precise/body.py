"""A rigid body about a fixed point, as power series in time: Euler's equations for its body rates.

The coordinates are a quaternion of any length; the rate of the logarithm of its length stays.
"""

from __future__ import annotations

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
        About the fixed point, in the frame of the body.
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

    def to_float(self) -> None:
        """Compute with doubles from now on."""
        self.arm, self.gravity = ([float(x) for x in row] for row in (self.arm, self.gravity))
        self.inertia, self.inverse = (
            [[float(x) for x in row] for row in rows] for rows in (self.inertia, self.inverse)
        )

    def expand(self, time: Any, state: Numbers, order: int) -> list[Numbers]:
        """Return the Taylor coefficients (4, order + 1) of the quaternion about a time."""
        zero = state[0] * 0
        size = sum(x * x for x in state[:4])
        start = [x / size for x in hamilton([state[0], *(-x for x in state[1:4])], state[4:])]
        growth = start[0]
        q: list[Numbers] = [[x] for x in state[:4]]
        omega: list[Numbers] = [[2 * x] for x in start[1:]]
        # of the rotation: entries of q q^T, the square of the length and its reciprocal
        inverse: Numbers = []
        squares: Numbers = []
        outer: dict[tuple[int, int], Numbers] = {at: [] for at in pairs(range(4), range(4))}
        pull: list[Numbers] = [[], [], []]
        spin: list[Numbers] = [[], [], []]
        for k in range(order):
            for i, j in outer:
                outer[i, j].append(term(q[i], q[j]))
            squares.append(sum(outer[i, i][k] for i in range(4)))
            inverse.append(1 / squares[0] if k == 0 else -term(squares[1:], inverse) * inverse[0])
            for j, row in enumerate(self.pulled(outer, k)):
                pull[j].append(row)
            ahead = [term(part, inverse) for part in pull]
            for i in range(3):
                spin[i].append(
                    sum(mul(a, w[k]) for a, w in zip(self.inertia[i], omega, strict=True))
                )
            moment = []
            for i in range(3):
                a, b = (i + 1) % 3, (i + 2) % 3
                gyroscopic = term(omega[a], spin[b]) - term(omega[b], spin[a])
                moment.append(self.arm[a] * ahead[b] - self.arm[b] * ahead[a] - gyroscopic)
            faster = [sum(map(mul, row, moment)) for row in self.inverse]
            rates = [[growth if m == 0 else zero for m in range(k + 1)], *halves(omega)]
            turned = series_product(q, rates)
            for i in range(4):
                q[i].append(turned[i] / (k + 1))
            for i in range(3):
                omega[i].append(faster[i] / (k + 1))
        return q

    def pulled(self, outer: dict[tuple[int, int], Numbers], k: int) -> Numbers:
        """Return coefficient k of gravity in the frame of the body, times the square of |q|."""
        at = {place: values[k] for place, values in outer.items()}
        ww, xx, yy, zz = (at[i, i] for i in range(4))
        rows = [
            [ww + xx - yy - zz, 2 * (at[1, 2] - at[0, 3]), 2 * (at[1, 3] + at[0, 2])],
            [2 * (at[1, 2] + at[0, 3]), ww - xx + yy - zz, 2 * (at[2, 3] - at[0, 1])],
            [2 * (at[1, 3] - at[0, 2]), 2 * (at[2, 3] + at[0, 1]), ww - xx - yy + zz],
        ]
        return [sum(rows[i][j] * self.gravity[i] for i in range(3)) for j in range(3)]


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
