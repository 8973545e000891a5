"""The beam of `rotating_beam` as particles, which constraint forces hold on its curve.

Particles sit at the Gauss points of the beam's pieces, with the mass as one more. Newton's law
moves each in axes of the world. Angles of the tangent and stretches are massless coordinates, with
the moments and forces of bending and stretching; they and the particles are held together by two
constraints for each particle, the second derivative of its place

    r = R(theta) (a, 0) + int_0^s (1 + e) (cos, sin)(theta + psi) ds.

Integrals are those of the polynomials through the Gauss points, in 50 digits.
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from functools import cache
from typing import Any, NamedTuple

import mpmath
import numpy as np

from mbcheck.reference.rotating_beam.shapes import pieces, polynomials
from mbcheck.reference.scene import EquationsOfMotion
from mbcheck.tests.support.formulations.newton_euler import (
    DIGITS,
    constrained,
    cos_sin,
    decimals,
    solve,
    zeros,
)
from mbcheck.tests.support.formulations.scenes import hub_drive
from mbcheck.tests.support.formulations.witness import motion

ONE = Decimal(1)


class Curve(NamedTuple):
    """Tables over the Gauss points g of all pieces; lengths over L.

    Attributes
    ----------
    angle, curvature, stretch : array (g, n), (g, n), (g, k)
    integral : array (g + 2, g)
        From the clamp to the Gauss points, to the mass and to the tip.
    """

    angle: Any
    curvature: Any
    stretch: Any
    integral: Any


def powers_at(points: Any, count: int) -> tuple[Any, Any]:
    """Return 1, t, t^2, ... (points, count), and their derivatives."""
    exponents = decimals(np.arange(count))
    values = np.array([[t**i if i else ONE for i in range(count)] for t in points])
    slopes = np.column_stack([0 * values[:, :1], values[:, :-1] * exponents[1:]])
    return values, slopes


def gauss_points(count: int) -> Any:
    """Return the Gauss points on 0 to 1."""
    with mpmath.workdps(DIGITS + 10):
        start = np.polynomial.legendre.leggauss(count)[0]
        roots = [mpmath.findroot(lambda x: mpmath.legendre(count, x), x) for x in start]
        return np.array([Decimal(str((1 + root) / 2)) for root in roots])


def nodal(values: Any, slopes: Any, conditions: Any, nodes: Any) -> tuple[Any, Any]:
    """Combine functions so that they satisfy conditions, and each is 1 at its node, 0 at others."""
    matrix = np.vstack([conditions, values[nodes]])
    right = np.vstack([0 * conditions[:, : len(nodes)], decimals(np.eye(len(nodes), dtype=int))])
    columns = np.column_stack([solve(matrix, column) for column in right.T])
    return values @ columns, slopes @ columns


def nodes_of(table: Any) -> Any:
    """Return the points at which each coordinate is the function, by the reference's table."""
    return [int(np.flatnonzero(row == 1)[0]) for row in np.where(table.sum(1) == 1, table.T, 0)]


def placed(*blocks: Any) -> Any:
    """Return blocks on the diagonal of a matrix."""
    matrix, i, j = zeros(*np.sum([block.shape for block in blocks], axis=0)), 0, 0
    for block in blocks:
        rows, columns = block.shape
        matrix[i : i + rows, j : j + columns] = block
        i, j = i + rows, j + columns
    return matrix


@cache
def curve(n: int, k: int, place: float) -> Curve:
    """Return the tables of n angles and k stretches with the mass at a place.

    An angle is a polynomial on each piece, 0 at the clamp and smooth at the mass, without slope at
    the tip. Which points the coordinates belong to is the reference's choice.
    """
    table = polynomials(n, k, place)
    at = table.stations[:-1]
    with localcontext(prec=DIGITS):
        tables: list[list[Any]] = [[], [], [], [], []]
        values, slopes, integrals, edges, edge_slopes = tables
        for start, end, degree in pieces(n, place):
            count = int(((start < at) & (at < end)).sum())
            size, points = Decimal(end) - Decimal(start), gauss_points(count)
            to_series = np.column_stack(
                [solve(powers_at(points, count)[0], unit) for unit in decimals(np.eye(count))]
            )
            grown = powers_at([*points, ONE], count + 1)[0][:, 1:] / decimals(range(1, count + 1))
            integrals.append(size * grown @ to_series)
            for x, own, slope in (
                (points, values, slopes),
                ([Decimal(0), ONE], edges, edge_slopes),
            ):
                value, by_t = powers_at(x, degree + 1)
                own.append(value)
                slope.append(by_t / size)
        edge, edge_slope = placed(*edges), placed(*edge_slopes)
        joints = [x[i] - x[i + 1] for x in (edge, edge_slope) for i in range(1, len(edge) - 1, 2)]
        conditions = np.array([edge[0], edge_slope[-1], *joints])
        nodes = nodes_of(table.angle)
        angle, curvature = nodal(placed(*values), placed(*slopes), conditions, nodes)
        total, ends = placed(*(x[:-1] for x in integrals)), placed(*(x[-1:] for x in integrals))
        first = len(integrals[0]) - 1
        total[first:, :first] += ends[0, :first]
        stretch = powers_at(gauss_points(len(at)), k)[0] if k else zeros(len(at), 0)
        if k:
            stretch = nodal(stretch, stretch, stretch[:0], nodes_of(table.stretch))[0]
    return Curve(angle, curvature, stretch, np.vstack([total, ends[0], ends.sum(0)]))


def by_particles(
    scene: EquationsOfMotion, p: Any, q: Any, v: Any, t: Decimal
) -> dict[str, tuple[Any, Any]]:
    """Return values and sizes of the beam, inextensible or, with coordinates e_1, ..., not."""
    k = sum(name.startswith("e_") for name in scene.coordinates)
    n = len(q) - 1 - k
    shape = curve(n, k, float(p.mass_position))
    weights, radius, pull = shape.integral[-1], p.hub_radius, (p.gravity_x, p.gravity_y)
    masses = np.array([*(p.density * p.area * p.length * weights), p.mass])
    integral = p.length * shape.integral[:-1]
    hub = decimals([1] + [0] * (n + k))
    turning = np.column_stack([0 * weights + 1, shape.angle, 0 * shape.stretch])
    stretching = np.column_stack([0 * weights, 0 * shape.angle, shape.stretch])
    rates, stretch, stretch_rate = turning @ v, 1 + stretching @ q, stretching @ v
    tangent, clamp = np.array([cos_sin(angle) for angle in turning @ q]).T, cos_sin(q[0])
    jacobian, bias, place = [], [], []
    for along, across, e, e_n in zip(
        tangent, (-tangent[1], tangent[0]), clamp, (-clamp[1], clamp[0]), strict=True
    ):
        by = (stretch * across)[:, None] * turning + along[:, None] * stretching
        jacobian.append(radius * e_n * hub + integral @ by)
        bend = 2 * stretch_rate * rates * across - stretch * rates**2 * along
        bias.append(-radius * v[0] ** 2 * e + integral @ bend)
        place.append(radius * e + integral @ (stretch * along))
    strain = placed(
        zeros(1, 1),
        p.youngs_modulus * p.second_moment / p.length * products(shape.curvature, weights),
        p.youngs_modulus * p.area * p.length * products(shape.stretch, weights),
    )
    drive, drive_size = hub_drive(p, t)
    torque = drive * hub * (p.drive == "torque") - strain @ q
    weight = [masses * g for g in pull]
    m = placed(p.hub_inertia * np.outer(hub, hub), np.diag(masses), np.diag(masses))
    rows = np.hstack([np.vstack(jacobian), decimals(-np.eye(2 * len(masses), dtype=int))])
    constants = np.concatenate(bias)
    if p.drive == "prescribed":
        rows = np.vstack([rows, [*hub, *(0 * constants)]])
        constants = np.append(constants, -drive)
    x, reactions = constrained(m, np.concatenate([torque, *weight]), rows, constants)
    a = x[: len(q)]
    levers = [abs(radius * hub) + abs(integral) @ (abs(turning) + abs(stretching))] * 2
    sizes = [radius * v[0] ** 2 + abs(integral) @ (2 * abs(stretch_rate * rates) + rates**2)] * 2
    mass, mass_size = (
        p.hub_inertia * np.outer(hub, hub) + sum(j.T * masses @ j for j in js)
        for js in (jacobian, levers)
    )
    forces = torque + sum(
        j.T @ (pulled - masses * bent)
        for j, pulled, bent in zip(jacobian, weight, bias, strict=True)
    )
    force_size = (
        abs(strain) @ abs(q)
        + drive_size * hub * (p.drive == "torque")
        + sum(
            j.T @ (abs(pulled) + masses * bent)
            for j, pulled, bent in zip(levers, weight, sizes, strict=True)
        )
    )
    potential = q @ strain @ q / 2 - sum(w @ r for w, r in zip(weight, place, strict=True))
    potential_size = abs(q) @ abs(strain) @ abs(q) / 2 + sum(
        abs(w) @ levers[0][:, 0] for w in weight
    )
    torque_on_hub = reactions[-1] if p.drive == "prescribed" else drive
    hub_size = (mass_size @ abs(a) + force_size)[0] if p.drive == "prescribed" else drive_size
    given = {0: drive_size} if p.drive == "prescribed" else {}
    sized = (mass, mass_size.astype(float)), (forces, force_size.astype(float))
    return motion(*sized, a, given) | {
        "energy": (v @ mass @ v / 2 + potential, abs(v) @ mass_size @ abs(v) / 2 + potential_size),
        "power hub": (torque_on_hub * v[0], hub_size * abs(v[0])),
    }


def products(table: Any, weights: Any) -> Any:
    """Return the integrals of the products of functions."""
    return table.T * weights @ table
