r"""A body on a free joint that carries bodies on hinges, in chains or side by side.

Featherstone, *Rigid Body Dynamics Algorithms* (2008), chapter 9, calls it a floating base.

Hinge k turns body k against its parent, the base or another of them, about the unit axis e_k by
theta_k. In the frame of the base, whose angular velocity is omega and whose body has the number 0,
d_i is the place of the centre of mass of body i from that of all, I_i its tensor about it, and J
the tensor of all. s_i is the angular velocity of body i against the base, t_ik = e_k x (its centre
of mass from hinge k) of a body i that hinge k carries, 0 of any other. With all theta'' and omega'
0, body i gains the spin against the base sigma_i and its centre of mass the acceleration

    alpha_i = a_i + 2 omega x u_i,

where u_i and a_i are velocity and acceleration against the base, a_i by what the hinges' rates
give each other. With the means b of alpha_i, t_k of t_ik over all masses, whose sum is M,

    J omega' + sum_k theta_k'' h_k = -sum_i (N_i + m_i d_i x (omega x (omega x d_i) + alpha_i))  (1)
    h_k . omega' + sum_l theta_l'' m_kl
        = tau_k - sum_i (e_k . N_i + m_i t_ik . (omega x (omega x d_i) + alpha_i - b))           (2)
    h_k = sum_i (m_i d_i x t_ik + I_i e_k)
    m_kl = sum_i (m_i (t_ik - t_k) . (t_il - t_l) + e_k . I_i e_l)
    N_i = I_i (sigma_i + omega x s_i) + w_i x (I_i w_i),    w_i = omega + s_i
    x'' = g - R (omega' x r + omega x (omega x r) + sum_k t_k theta_k'' + b)                     (3)
    q' = q (0, omega) / 2                                                                        (4)

where e_k . N_i and e_k . I_i count bodies that hinge k carries alone, and r is the place of the
centre of mass of all from the base's point x. The torques tau_k act between bodies: no torque at a
hinge changes the momenta of the whole. The velocity x' appears nowhere, by Galileo's principle.
The quaternion may have any length, see `.rotation`; without motors and dampers these are Lagrange's
equations, whose mass matrix is that about the base's point.

Coordinates are x, y, z, the angles, and the quaternion. Coefficients begin with those of
`parameters.body_numbers` about the centre of mass of the base; ``mass`` is that of all, ``base``
and ``centre_x``, ``centre_y``, ``centre_z`` are mass and centre of mass of the base.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..quaternions import cross, matrix, square
from ..scene import Array
from .rotation import (
    NUMBERS,
    BodyParameters,
    Moment,
    body_inertia,
    body_numbers,
    body_rates,
    central_inertia,
    euler,
    inner,
    into_body,
    rotation_columns,
    sum_of,
    times,
    turned_forces,
    turned_inertia,
)

BASE_NUMBERS = (*NUMBERS, "mass", "base", "centre_x", "centre_y", "centre_z")
"""Names of `base_numbers`."""

PLACE, TURN = slice(0, 3), slice(-4, None)
HINGES = slice(3, -4)
"""Places among the coordinates."""


def base_numbers(p: BodyParameters, tensor: Array | None, others: Any) -> list[Any]:
    """Return the first coefficients; the tensor (3, 3, ...) about the base's point may be another.

    ``others`` is the mass of all bodies on hinges.
    """
    central = central_inertia(p)
    if tensor is not None:
        central = central + (tensor - body_inertia(p))
    still = p.replace(centre_x=0.0, centre_y=0.0, centre_z=0.0)
    own = [p.mass + others, p.mass, p.centre_x, p.centre_y, p.centre_z]
    return [*body_numbers(still, central), *own]


class Link(NamedTuple):
    """A body of revolution on a hinge; vectors are in the frame of the base.

    Attributes
    ----------
    parent : int
        Number of the body that bears the hinge, 0 of the base.
    mass, polar, crosswise :
        And its moments about its figure's axis, and across it, about its centre of mass.
    figure, axis : lists of 3
        Unit vectors of its figure's axis, and e of the hinge.
    offset : list of 3
        From the parent's hinge, or the base's point, to its own.
    arm : list of 3
        From its hinge to its centre of mass.
    """

    parent: int
    mass: Any
    polar: Any
    crosswise: Any
    figure: list[Any]
    axis: list[Any]
    offset: list[Any]
    arm: list[Any]

    def spread(self, w: Any) -> list[Any]:
        """Return I w."""
        across, along = self.crosswise, (self.polar - self.crosswise) * inner(self.figure, w)
        return sum_of([across * w[0], across * w[1], across * w[2]], self.figure, along)


class Rates(NamedTuple):
    """How a body moves against the base where no rate of a hinge changes.

    Attributes
    ----------
    spin, faster : lists of 3
        s and sigma.
    velocity, bent : lists of 3
        u and a of its centre of mass.
    """

    spin: list[Any]
    faster: list[Any]
    velocity: list[Any]
    bent: list[Any]


Vectors = dict[int, list[Any]]
"""Vectors of bodies by their numbers, of which those that are not there are 0."""


class Column(NamedTuple):
    """Influence of a hinge on the bodies that it carries.

    Attributes
    ----------
    axis : list of 3
        e.
    levers, spread : Vectors
        t_ik and I_i e_k.
    """

    axis: list[Any]
    levers: Vectors
    spread: Vectors


class Sides(NamedTuple):
    """Right-hand sides of (1), (2), in the frame of the base.

    Attributes
    ----------
    bent, moments : Vectors
        alpha and N of bodies on hinges.
    hinges : list
        tau.
    turning : vector
        The torques on the base: -omega x (I_0 omega).
    """

    bent: Vectors
    moments: Vectors
    hinges: list[Any]
    turning: list[Any]


NOTHING: list[Any] = [0, 0, 0]


def around(omega: Any, place: Any) -> list[Any]:
    """Return omega x (omega x d)."""
    return cross(omega, cross(omega, place))


def path(links: list[Link], i: int) -> Iterator[int]:
    """Yield the numbers of a body and of those that bear it, without the base."""
    while i:
        yield i
        i = links[i - 1].parent


def columns_of(links: list[Link]) -> list[Column]:
    """Return the influence of each hinge on the bodies that it carries."""
    columns = [Column(one.axis, {}, {}) for one in links]
    for i, one in enumerate(links, 1):
        arm = one.arm
        for k in path(links, i):
            axis = links[k - 1].axis
            columns[k - 1].levers[i] = cross(axis, arm)
            columns[k - 1].spread[i] = one.spread(axis)
            arm = sum_of(arm, links[k - 1].offset)
    return columns


def masses(links: list[Link], c: Any) -> list[Any]:
    """Return those of all bodies."""
    return [c.base, *(one.mass for one in links)]


def centre(c: Any) -> list[Any]:
    """Return the centre of mass of the base in its frame."""
    return [c.centre_x, c.centre_y, c.centre_z]


def from_point(links: list[Link], c: Any) -> Vectors:
    """Return the centres of mass of all bodies from the base's point."""
    places, hinges = {0: centre(c)}, [NOTHING]
    for i, one in enumerate(links, 1):
        hinges.append(sum_of(hinges[one.parent], one.offset))
        places[i] = sum_of(hinges[i], one.arm)
    return places


def mean(vectors: Vectors, links: list[Link], c: Any) -> list[Any]:
    """Return the mean of vectors over the masses."""
    total, weights = NOTHING, masses(links, c)
    for i, vector in vectors.items():
        total = sum_of(total, vector, weights[i])
    return [part / c.mass for part in total]


def from_mean(vectors: Vectors, links: list[Link], c: Any) -> Vectors:
    """Return vectors from their mean over the masses, by their differences from each other.

    So a body that has nearly all of the mass is near the mean without a loss of digits.
    """
    weights, apart = masses(links, c), {}
    others = sum(mass for i, mass in enumerate(weights) if i not in vectors)
    for i, here in vectors.items():
        away = [others * part for part in here]
        for j, there in vectors.items():
            if j != i:
                away = sum_of(away, sum_of(here, there, -1), weights[j])
        apart[i] = [d / c.mass for d in away]
    return apart


def coupling(column: Column, links: list[Link], places: Vectors) -> list[Any]:
    """Return h_k with bodies at places from a point."""
    total = NOTHING
    for i, lever in column.levers.items():
        total = sum_of(total, column.spread[i])
        total = sum_of(total, cross(places[i], lever), links[i - 1].mass)
    return total


def joined(one: Column, two: Column, levers: Vectors, links: list[Link]) -> Any:
    """Return m_kl, of t_ik and of t_il from their mean or, with mass and arm, as they are."""
    total: Any = 0
    for i, lever in one.levers.items():
        if i in two.spread:
            total = total + inner(one.axis, two.spread[i])
        if i in levers:
            total = total + links[i - 1].mass * inner(lever, levers[i])
    return total


def whole_tensor(links: list[Link], places: Vectors, c: Any) -> list[Any]:
    """Return xx, yy, zz, xy, xz, yz of the tensor of all, with bodies at places from a point."""
    entries = list(c[3:9])
    for m, (x, y, z) in zip(masses(links, c), places.values(), strict=True):
        own = [y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z]
        entries = [a + m * b for a, b in zip(entries, own, strict=True)]
    for one in links:
        (e, f, g), d, p = one.figure, one.crosswise, one.polar - one.crosswise
        own = [d + p * e * e, d + p * f * f, d + p * g * g, p * e * f, p * e * g, p * f * g]
        entries = [a + b for a, b in zip(entries, own, strict=True)]
    return entries


def rates_of(links: list[Link], speeds: Any, turning: float = 1.0) -> list[Rates]:
    """Return the motion of the bodies on hinges against the base, by the hinges' rates.

    ``turning`` is 0 where, by mistake, no axis turns with the bodies before it.
    """
    moving, joints = [], [Rates(NOTHING, NOTHING, NOTHING, NOTHING)]  # of bodies, of hinges
    for one, rate in zip(links, speeds, strict=True):
        spin, faster, velocity, bent = joints[one.parent]
        if one.parent:
            velocity = sum_of(velocity, cross(spin, one.offset))
            bent = sum_of(bent, around(spin, one.offset))
            bent = sum_of(bent, cross(faster, one.offset))
            faster = sum_of(faster, cross(spin, one.axis), turning * rate)
        spin = sum_of(spin, one.axis, rate)
        joints.append(Rates(spin, faster, velocity, bent))
        velocity = sum_of(velocity, cross(spin, one.arm))
        bent = sum_of(bent, around(spin, one.arm))
        bent = sum_of(bent, cross(faster, one.arm)) if one.parent else bent
        moving.append(Rates(spin, faster, velocity, bent))
    return moving


def spun(one: Link, omega: Any, rates: Rates) -> list[Any]:
    """Return N, the rate of a body's spin about its centre of mass where no rate changes."""
    whole = sum_of(omega, rates.spin)
    faster = sum_of(rates.faster, cross(omega, rates.spin))
    return sum_of(cross(whole, one.spread(whole)), one.spread(faster))


def driven(links: list[Link], omega: Any, moving: list[Rates]) -> tuple[Vectors, Vectors]:
    """Return alpha and N of bodies on hinges, by their motion against the base."""
    bent, moments = {}, {}
    for i, (one, rates) in enumerate(zip(links, moving, strict=True), 1):
        bent[i] = sum_of(rates.bent, cross(omega, rates.velocity), 2)
        moments[i] = spun(one, omega, rates)
    return bent, moments


def symmetric_solution(rows: list[list[Any]], right: list[Any]) -> list[Any]:
    """Return x of A x = b for a positive definite A, by its upper triangle (Cholesky, L D L^T)."""
    rows, right, n = [list(row) for row in rows], list(right), len(right)
    for k in range(n):
        for i in range(k + 1, n):
            factor = rows[k][i] / rows[k][k]
            for j in range(i, n):
                rows[i][j] = rows[i][j] - factor * rows[k][j]
            right[i] = right[i] - factor * right[k]
    for k in reversed(range(n)):
        for j in range(k + 1, n):
            right[k] = right[k] - rows[k][j] * right[j]
        right[k] = right[k] / rows[k][k]
    return right


def outward(q: Any, vector: Any) -> list[Any]:
    """Return the components in the world of a vector of the base."""
    return [inner(row, vector) for row in matrix(q[TURN])]


@dataclass(frozen=True)
class FloatingTree:
    """The equations of a base with bodies on hinges.

    Attributes
    ----------
    base : str
        What the base is called.
    links : callable ``(q, c, xp) -> list of Link``
        Parents stand before what they bear.
    torques : callable ``(q, v, c) -> list``
        tau.
    strain : callable ``(q, c) -> E``
        Energy of the springs [J].
    """

    base: str
    links: Callable[..., list[Link]]
    torques: Callable[..., list[Any]]
    strain: Callable[..., Any]

    def mass_matrix(self, q: Any, c: Any, xp: Any = np) -> list[list[Any]]:
        """Return the mass matrix of (1)-(3) in the coordinates."""
        links, rows, turn = self.links(q, c, xp), matrix(q[TURN]), q[TURN]
        places, hinges = from_point(links, c), columns_of(links)
        moment = [c.mass * part for part in mean(places, links, c)]
        swings = [[c.mass * part for part in mean(one.levers, links, c)] for one in hinges]
        mixed = [
            *(cross(moment, row) for row in rows),
            *(coupling(one, links, places) for one in hinges),
        ]
        others = [
            *(
                [c.mass if i == j else 0 for j in range(3)] + [inner(row, one) for one in swings]
                for i, row in enumerate(rows)
            ),
            *(
                [inner(row, swing) for row in rows]
                + [joined(one, two, two.levers, links) for two in hinges]
                for one, swing in zip(hinges, swings, strict=True)
            ),
        ]
        columns, size = rotation_columns(turn), square(turn)
        sides = [[2 * inner(column, one) / size for column in columns] for one in mixed]
        block = turned_inertia(turn, whole_tensor(links, places, c), c.radial)
        return [
            *([*row, *side] for row, side in zip(others, sides, strict=True)),
            *([side[i] for side in sides] + block[i] for i in range(4)),
        ]

    def sides(self, links: list[Link], motion: Any, c: Any, moment: Moment = euler) -> Sides:
        """Return the right-hand sides of (1), (2) at (q, v, omega)."""
        q, v, omega = motion
        bent, moments = driven(links, omega, rates_of(links, v[HINGES]))
        turning = moment(q[TURN], omega, times(c[3:9], omega), c)
        return Sides(bent, moments, self.torques(q, v, c), turning)

    def forces(self, u: Any, q: Any, v: Any, c: Any, xp: Any = np) -> list[Any]:
        """Return the right-hand side of ``M(q) a = f``."""
        links = self.links(q, c, xp)
        rho, omega = body_rates(q[TURN], v[TURN])
        sides, places = self.sides(links, (q, v, omega), c), from_point(links, c)
        pull, push, turning, force = into_body(q[TURN], c[15:18]), NOTHING, sides.turning, {}
        for i, mass in enumerate(masses(links, c)):
            swing = around(omega, places[i])
            swing = sum_of(swing, sides.bent[i]) if i else swing
            force[i] = [mass * (a - b) for a, b in zip(pull, swing, strict=True)]
            push, turning = sum_of(push, force[i]), sum_of(turning, cross(places[i], force[i]))
        for moment in sides.moments.values():
            turning = sum_of(turning, moment, -1)
        moved = [c.mass * part for part in cross(omega, mean(places, links, c))]
        push, hinges = sum_of(push, moved, 2 * rho), []
        for one, torque in zip(columns_of(links), sides.hinges, strict=True):
            whole = torque + 2 * rho * inner(coupling(one, links, places), omega)
            for i, lever in one.levers.items():
                whole = whole + inner(lever, force[i]) - inner(one.axis, sides.moments[i])
            hinges.append(whole)
        momentum = times(whole_tensor(links, places, c), omega)
        rest = turned_forces(q[TURN], v[TURN], turning, momentum, c.radial)
        return [*(inner(row, push) for row in matrix(q[TURN])), *hinges, *rest]

    def body_accelerations(
        self, u: Any, motion: Any, c: Any, moment: Moment, xp: Any = np
    ) -> list[Any]:
        """Return x'', the angles' accelerations and omega' by (1)-(3)."""
        links = self.links(motion[0], c, xp)
        return self.central(links, self.sides(links, motion, c, moment), motion, c)

    def central(self, links: list[Link], sides: Sides, motion: Any, c: Any) -> list[Any]:
        """Return them of (q, v, omega) and of what drives (1), (2)."""
        q, _, omega = motion
        places, hinges, count = from_point(links, c), columns_of(links), len(links)
        apart, pushed = from_mean(places, links, c), from_mean(sides.bent, links, c)
        turning, swings = sides.turning, {i: around(omega, one) for i, one in apart.items()}
        for i, mass in enumerate(masses(links, c)):
            swing = sum_of(swings[i], sides.bent[i]) if i else swings[i]
            turning = sum_of(turning, cross(apart[i], swing), -mass)
        for moment in sides.moments.values():
            turning = sum_of(turning, moment, -1)
        right, means = list(sides.hinges), [mean(one.levers, links, c) for one in hinges]
        near = [from_mean(one.levers, links, c) for one in hinges]
        rows: list[list[Any]] = []
        for k, one in enumerate(hinges):
            for i, lever in one.levers.items():
                spin = inner(one.axis, sides.moments[i])
                swung = links[i - 1].mass * inner(lever, sum_of(swings[i], pushed[i]))
                right[k] = right[k] - spin - swung
            rows.append([0.0] * k)
            for two, middle, apart_from in zip(hinges[k:], means[k:], near[k:], strict=True):
                away = {i: apart_from.get(i, [-part for part in middle]) for i in one.levers}
                rows[k].append(joined(one, two, away, links))
            rows[k] += coupling(one, links, apart)
        xx, yy, zz, xy, xz, yz = whole_tensor(links, apart, c)
        rows += [[0.0] * count + row for row in ([xx, xy, xz], [0.0, yy, yz], [0.0, 0.0, zz])]
        solution = symmetric_solution(rows, [*right, *turning])
        angles, faster, place = solution[:count], solution[count:], mean(places, links, c)
        moved = sum_of(cross(faster, place), around(omega, place))
        moved = sum_of(moved, mean(sides.bent, links, c))
        for middle, change in zip(means, angles, strict=True):
            moved = sum_of(moved, middle, change)
        pulled = [g - part for g, part in zip(c[15:18], outward(q, moved), strict=True)]
        return [*pulled, *angles, *faster]

    def energy(self, q: Any, v: Any, c: Any) -> Any:
        """Return kinetic and potential energy [J], that of the length of q included."""
        rows, links = self.mass_matrix(q, c), self.links(q, c, np)
        kinetic = sum(
            v[i] * v[j] * entry for i, row in enumerate(rows) for j, entry in enumerate(row)
        )
        place = sum_of(q[PLACE], outward(q, mean(from_point(links, c), links, c)))
        return kinetic / 2 + self.strain(q, c) - c.mass * inner(c[15:18], place)

    def momentum(self, q: Any, v: Any, c: Any) -> list[Any]:
        """Return the linear momentum in the world [kg m/s]."""
        links, omega = self.links(q, c, np), body_rates(q[TURN], v[TURN])[1]
        inside = cross(omega, mean(from_point(links, c), links, c))
        for one, rate in zip(columns_of(links), v[HINGES], strict=True):
            inside = sum_of(inside, mean(one.levers, links, c), rate)
        return [c.mass * (a + b) for a, b in zip(v, outward(q, inside), strict=False)]

    def angular_momentum(self, q: Any, v: Any, c: Any) -> list[Any]:
        """Return the angular momentum about the centre of mass of all, in the world [kg m^2/s]."""
        links, omega = self.links(q, c, np), body_rates(q[TURN], v[TURN])[1]
        apart = from_mean(from_point(links, c), links, c)
        inside = times(whole_tensor(links, apart, c), omega)
        for one, rate in zip(columns_of(links), v[HINGES], strict=True):
            inside = sum_of(inside, coupling(one, links, apart), rate)
        return outward(q, inside)
