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

from mbcheck.reference import get_scene
from mbcheck.reference.rotating_beam.shapes import pieces, polynomials
from mbcheck.tests.support.formulations.newton_euler import (
    DIGITS,
    PI,
    constrained,
    cos_sin,
    decimals,
    solve,
)
from mbcheck.tests.support.formulations.witness import Quantity, Sample, rounded_to

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


def placed(blocks: Any) -> Any:
    """Return blocks on the diagonal of a matrix, one for each piece."""
    rows = [np.hstack([block if i == j else np.zeros((len(block), other.shape[1]), int) for j, other in enumerate(blocks)]) for i, block in enumerate(blocks)]
    return decimals(np.vstack(rows))


@cache
def curve(n: int, k: int, place: float) -> Curve:
    """Return the tables of n angles and k stretches with the mass at a place.

    An angle is a polynomial on each piece, 0 at the clamp and smooth at the mass, without slope at
    the tip. Which points the coordinates belong to is the reference's choice.
    """
    table = polynomials(n, k, place)
    at = table.stations[:-1]
    with localcontext(prec=DIGITS):
        values, slopes, integrals, ends = [], [], [], []
        for start, end, degree in pieces(n, place):
            count = int(((start < at) & (at < end)).sum())
            size, points = Decimal(end) - Decimal(start), gauss_points(count)
            to_series = np.column_stack(
                [solve(powers_at(points, count)[0], unit) for unit in decimals(np.eye(count))]
            )
            grown = powers_at([*points, ONE], count + 1)[0][:, 1:] / decimals(range(1, count + 1))
            integrals.append(size * grown @ to_series)
            value, slope = powers_at(points, degree + 1)
            values.append(value)
            slopes.append(slope / size)
            edge, edge_slope = powers_at([Decimal(0), ONE], degree + 1)
            ends.append((edge, edge_slope / size))
        (first, first_slope), (last, last_slope) = ends[0], ends[-1]
        if len(ends) == 1:
            conditions = np.array([first[0], last_slope[1]])
        else:
            left, right = 0 * first[0], 0 * last[0]
            conditions = np.array(
                [
                    [*first[0], *right],
                    [*first[1], *-last[0]],
                    [*first_slope[1], *-last_slope[0]],
                    [*left, *last_slope[1]],
                ]
            )
        angle, curvature = nodal(placed(values), placed(slopes), conditions, nodes_of(table.angle))
        total = placed([block[:-1] for block in integrals])
        if len(integrals) == 2:
            total[len(values[0]) :, : len(values[0])] = integrals[0][-1]
        tip = np.concatenate([block[-1] for block in integrals])
        mass = tip.copy()
        if len(integrals) == 2:
            mass[len(values[0]) :] = Decimal(0)
        stretch = powers_at(gauss_points(len(at)), k)[0] if k else decimals(np.zeros((len(at), 0)))
        if k:
            stretch = nodal(stretch, stretch, 0 * stretch[:0], nodes_of(table.stretch))[0]
    return Curve(angle, curvature, stretch, np.vstack([total, mass, tip]))


def beam_witness(sample: Sample, k: int = 0) -> dict[str, Quantity]:
    """Return accelerations and energy of the inextensible beam, or with k stretches."""
    with localcontext(prec=DIGITS):
        points = [at_point(sample, k, i) for i in range(len(sample.times))]
    return {
        key: Quantity(*(np.stack([one[key][i] for one in points], -1) for i in (0, 1)))
        for key in points[0]
    }


def at_point(sample: Sample, k: int, i: int) -> dict[str, tuple[Any, Any]]:
    """Return values and errors at one point."""
    p, t = sample.parameters.at(i), Decimal(float(sample.times[i]))
    exact = {x: Decimal(float(getattr(p, x))) for x in p.numeric_names()}
    q, v = decimals(sample.q[:, i]), decimals(sample.v[:, i])
    n = len(q) - 1 - k
    place = float(p.mass_position) if p.mass else 1.0
    shape = curve(n, k, place)
    length, radius = exact["length"], exact["hub_radius"]
    line = exact["density"] * exact["area"] * length
    weights = shape.integral[-1]
    masses = np.array([*(line * weights), exact["mass"]])
    integral = length * shape.integral[:-1]
    # angles, from x of the world, of the hub and of the tangent at the Gauss points
    hub = decimals([1, *[0] * (n + k)])
    turning = np.column_stack([0 * weights + 1, shape.angle, 0 * shape.stretch])
    stretching = np.column_stack([0 * weights, 0 * shape.angle, shape.stretch])
    angles, rates = turning @ q, turning @ v
    stretch, stretch_rate = 1 + stretching @ q, stretching @ v
    tangent = np.array([cos_sin(angle) for angle in angles])
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    cos, sin = cos_sin(q[0])
    jacobian, bias, bias_size, places, speeds = [], [], [], [], []
    for axis, e, e_n in ((0, cos, -sin), (1, sin, cos)):
        along, across = tangent[:, axis], normal[:, axis]
        by = (stretch * across)[:, None] * turning + along[:, None] * stretching
        jacobian.append(radius * e_n * hub + integral @ by)
        bend = 2 * stretch_rate * rates * across - stretch * rates**2 * along
        size = 2 * abs(stretch_rate * rates) + abs(stretch) * rates**2
        bias.append(-radius * v[0] ** 2 * e + integral @ bend)
        bias_size.append(radius * v[0] ** 2 + abs(integral) @ size)
        places.append(radius * e + integral @ (stretch * along))
        speeds.append(jacobian[-1] @ v)
    strain = decimals(np.zeros((n + k + 1, n + k + 1), dtype=int))
    strain[1 : n + 1, 1 : n + 1] = (
        exact["youngs_modulus"] * exact["second_moment"] / length
        * (shape.curvature.T * weights @ shape.curvature)
    )
    strain[n + 1 :, n + 1 :] = (
        exact["youngs_modulus"] * exact["area"] * length * (shape.stretch.T * weights @ shape.stretch)
    )
    pull = (exact["gravity_x"], exact["gravity_y"])
    size = len(masses)
    coordinates = np.diag(exact["hub_inertia"] * hub)
    zero = decimals(np.zeros((len(q), 2 * size), dtype=int))
    inertia = np.block([[coordinates, zero], [zero.T, np.diag([*masses, *masses])]])
    drive = drive_of(p, exact, t)
    load = np.concatenate([-strain @ q + drive * hub * (p.drive == "torque"), masses * pull[0], masses * pull[1]])
    load_size = np.concatenate([abs(strain) @ abs(q) + abs(drive) * hub, abs(masses * pull[0]), abs(masses * pull[1])])
    rows = np.hstack([np.vstack(jacobian), decimals(-np.eye(2 * size, dtype=int))])
    constants, sizes = np.concatenate(bias), np.concatenate(bias_size)
    if p.drive == "prescribed":
        rows = np.vstack([rows, [*hub, *zero[0]]])
        constants, sizes = np.append(constants, -drive), np.append(sizes, abs(drive))
    x, errors = constrained(inertia, load, load_size, rows, constants, sizes)
    kinetic = sum(masses @ speed**2 for speed in speeds) / 2 + exact["hub_inertia"] * v[0] ** 2 / 2
    weight = [-masses @ place * g for place, g in zip(places, pull, strict=True)]
    potential = q @ strain @ q / 2 + sum(weight)
    energy_size = kinetic + abs(q) @ abs(strain) @ abs(q) / 2 + (radius + length) * sum(masses) * sum(abs(g) for g in pull)
    return {
        "accelerations": (x[: len(q)].astype(float), errors[: len(q)]),
        "energy": rounded_to(kinetic + potential, energy_size),
    }


def drive_of(p: Any, exact: Any, t: Any) -> Any:
    """Return the hub's acceleration (22), or the torque (23) on it."""
    if p.drive == "torque":
        period = exact["torque_period"]
        return exact["torque_amplitude"] * cos_sin(2 * PI * t / period)[1] * (t < period)
    ramp = exact["ramp_time"]
    return exact["angular_speed"] / ramp * (1 - cos_sin(2 * PI * t / ramp)[0]) * (t < ramp)
