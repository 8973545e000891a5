r"""rotating_beam: a hub with a flexible beam and a concentrated mass, in a horizontal plane.

::

            y                 theta of the hub frame x, y; O its axis, clamp at x = a
            |     __.--o  m   psi(s) the beam's angle in that frame, psi(0) = 0
      ( O )-+--.-'            d / L the mass's place, 1 at the tip
       J_h  a       L  -> x   no gravity

Source: Yang, Wang, Chen, Wu (2016), "Dynamic Modeling and Response of a Rotating Cantilever
Beam with a Concentrated Mass", equations (1)-(23). Four models of one beam, in the hub frame,
lengths over L (the strain energy of all is EI/2 times the squared curvature, and EA/2 times
the squared stretch):

- exact, inextensible: ``x + i y = a + int exp(i psi) ds`` with ``psi = sum b_i P_i(s)`` and the
  curvature psi';
- exact, ``extensible``: ``x + i y = a + int (1 + e) exp(i psi) ds`` with ``e = sum e_j Q_j(s)``
  and the curvature psi' as geometrically exact beams have it, by the unstretched length;
- ``second_order``: the paper's. With ``v' = sum b_i P_i`` and ``u' = sum e_j Q_j``, x = a + s +
  u - int v'^2/2 and y = v, and of the kinetic energy what is of second order in v and u;
- ``zero_order``: the same without the foreshortening int v'^2/2, which loses its stability where
  the hub turns at the first natural frequency of the beam at rest.

Misprints, against Lagrange's equations of the second-order model: (2) has u_xx for u_x; (3)
lacks the hub radius; (4), (5) print gravity; in (14) signs are wrong (theta'' in the row of
B_2, theta'^2 in the term with H); in (16), M_theta_theta lacks J_h, Q_theta lacks tau, U_10
lacks the mass; (12) is no eigenmode as printed.

The shapes are polynomials, one piece from clamp to mass and one from there to the tip, as
smooth as the solution: psi and psi' are continuous and psi' vanishes at the tip; psi'' and e
jump at the mass. A coordinate is the angle (the slope, the stretch) at one point, so that all
have like sizes; the error falls geometrically with their number.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.interpolate import CubicHermiteSpline
from scipy.linalg import block_diag, eigh, null_space, qr
from scipy.linalg.lapack import dgesv
from scipy.optimize import brentq

from ..errors import ParameterError
from ..linear import linearise
from ..scene import Array, Case, Paper, Parameters, Scene, choice, quantity

DRIVES = ("prescribed", "torque")
SCHEMES = ("A", "B")
ELEMENTS = ("ancf", "geometrically_exact")


@dataclass(frozen=True)
class RotatingBeam(Parameters):
    """Parameters of `rotating_beam` (SI units); the last three are models' settings.

    The defaults are those of figure 4 without the concentrated mass; the paper gives no
    hub inertia.
    """

    length: float = quantity(8.0, "L", "m", "section 3", "of the beam")
    hub_radius: float = quantity(0.0, "a", "m", "figure 4", "axis to clamp", "non-negative")
    hub_inertia: float = quantity(
        10.0, "J_h", "kg m^2", "chosen", "of the hub about its axis", "non-negative"
    )
    area: float = quantity(7.2968e-5, "A", "m^2", "section 3", "of the cross section")
    second_moment: float = quantity(8.2189e-9, "I", "m^4", "section 3", "of the cross section")
    density: float = quantity(2766.7, "rho", "kg/m^3", "section 3", "of the beam")
    youngs_modulus: float = quantity(6.8952e10, "E", "N/m^2", "section 3", "of the beam")
    mass: float = quantity(0.0, "m", "kg", "figures 2-5", "concentrated mass", "non-negative")
    mass_position: float = quantity(1.0, "d/L", "1", "figures 4, 5", "of the mass from the clamp")
    drive: str = choice(DRIVES, "(22), (23)", "the hub's motion, or the torque on it")
    angular_speed: float = quantity(
        10.0, "omega_0", "rad/s", "figure 4", "of the prescribed hub after the ramp", "any"
    )
    ramp_time: float = quantity(
        15.0, "T", "s", "figure 4", "to get there; 0: constant speed from the start", "non-negative"
    )
    torque_amplitude: float = quantity(1.0, "tau_0", "N m", "figure 5", "of the pulse", "any")
    torque_period: float = quantity(10.0, "T", "s", "figure 5", "of the pulse")
    segments: float = quantity(16, "n", "1", "chosen", "of a model: rods or elements")
    scheme: str = choice(
        SCHEMES, "chosen", "of a chain: first hinge at the clamp, or half a rod on"
    )
    element: str = choice(ELEMENTS, "chosen", "of a model of finite elements")

    def validate(self) -> None:
        """Refuse a mass beyond the tip, and segments that cannot be counted.

        Raises
        ------
        ParameterError
        """
        if np.any(np.asarray(self.mass_position) > 1):
            raise ParameterError(
                f"mass_position is d / L and must be at most 1 (the tip), not {self.mass_position}"
            )
        segments = np.asarray(self.segments)
        if np.any(segments != np.round(segments)) or np.any(segments < 2):
            raise ParameterError(
                f"segments must be a whole number, 2 or greater, not {self.segments}"
            )


class Coefficients(NamedTuple):
    """Coefficients, SI units; lengths over L."""

    length: Any
    hub_ratio: Any
    """a / L"""
    place: Any
    """d / L of the mass; 1 where there is none"""
    hub: Any
    """J_h"""
    beam: Any
    """rho A L^3"""
    point: Any
    """m L^2"""
    bending: Any
    """E I / L"""
    axial: Any
    """E A L"""
    prescribed: Any
    """1 where the hub's motion is prescribed, 0 where a torque drives it"""
    ramp: Any
    """omega_0 / T of (22); 0 without a ramp"""
    ramp_time: Any
    ramp_omega: Any
    torque: Any
    torque_time: Any
    torque_omega: Any


def coefficients(p: RotatingBeam) -> Coefficients:
    """Return the coefficients of the equations of motion."""
    mass = p.density * p.area * p.length
    ramp = np.where(np.asarray(p.ramp_time) > 0, p.ramp_time, np.inf)
    return Coefficients(
        length=p.length,
        hub_ratio=p.hub_radius / p.length,
        place=np.where(np.asarray(p.mass) > 0, p.mass_position, 1.0)[()],
        hub=p.hub_inertia,
        beam=mass * p.length**2,
        point=p.mass * p.length**2,
        bending=p.youngs_modulus * p.second_moment / p.length,
        axial=p.youngs_modulus * p.area * p.length,
        prescribed=float(p.drive == "prescribed"),
        ramp=(p.angular_speed / ramp)[()],
        ramp_time=p.ramp_time,
        ramp_omega=(2 * np.pi / ramp)[()],
        torque=p.torque_amplitude,
        torque_time=p.torque_period,
        torque_omega=2 * np.pi / p.torque_period,
    )


def drive(t: Any, c: Coefficients, xp: Any = np) -> Any:
    """Angular acceleration of the hub by (22) [rad/s^2], or the torque (23) on it [N m].

    Both are zero at their end, where the clock is stopped.
    """
    speeding = c.ramp * (1 - np.cos(c.ramp_omega * np.minimum(t, c.ramp_time)))
    torque = c.torque * np.sin(c.torque_omega * np.minimum(t, c.torque_time))
    return c.prescribed * speeding + (1 - c.prescribed) * torque


# Shapes -------------------------------------------------------------------------------------


class Shapes(NamedTuple):
    """Shape functions over s / L at Gauss points, and integrals from the clamp to the stations.

    Stations are the Gauss points and the mass. Arrays may have leading axes of points.
    """

    angle: Any
    """P (gauss, n)"""
    curvature: Any
    """P' (gauss, n)"""
    stretch: Any
    """Q (gauss, k)"""
    integral: Any
    """(stations, gauss)"""
    weights: Any
    """Of the Gauss points: the beam's mass there, over all of it"""
    stations: Any


MORE_POINTS = 12
"""Gauss points of a piece beyond the degree of its polynomials."""


def pieces(n: int, place: float) -> list[tuple[float, float, int]]:
    """Start, end and degree of psi on each piece: n free values are left by the conditions."""
    if place == 1:
        return [(0.0, 1.0, n + 1)]
    first = 2 + round((n - 2) * place)
    return [(0.0, place, first), (place, 1.0, n + 2 - first)]


def nodal(values: Array) -> Array:
    """Combine functions (points, n) so that each is 1 at one point and 0 at n - 1 others.

    The points are chosen by pivoting (approximate Fekete points).
    """
    _, pivots = qr(values.T, mode="r", pivoting=True)
    chosen = np.sort(pivots[: values.shape[1]])
    return np.asarray(np.linalg.inv(values[chosen]))


@cache
def polynomials(n: int, k: int, place: float) -> Shapes:
    """Shapes of n bending and k stretching coordinates, mass at ``place``."""
    parts = pieces(n, place)
    first = min(k, max(1, round(k * place)))
    shares = [k] if len(parts) == 1 else [first, k - first]
    stations = np.concatenate([*(gauss_points(*part)[0] for part in parts), [place]])
    weights = np.concatenate([gauss_points(*part)[1] for part in parts])
    integral = np.hstack([piece_integral(stations, *part) for part in parts])
    local = [legendre.leggauss(degree + MORE_POINTS)[0] for _, _, degree in parts]
    ends = [(-1.0) ** np.arange(degree) for _, _, degree in parts]  # of the curvature's series
    free_tip = np.concatenate([*(0 * end for end in ends[:-1]), abs(ends[-1])])
    conditions = [free_tip, np.concatenate([abs(ends[0]), -ends[-1]])][: len(parts)]
    series = block_diag(
        *(legendre.legvander(x, len(end) - 1) for x, end in zip(local, ends, strict=True))
    )
    curvature = series @ null_space(np.array(conditions))
    angle = integral[: len(weights)] @ curvature
    to_nodes = nodal(angle)
    stretch = block_diag(
        *(legendre.legvander(x, share)[:, :share] for x, share in zip(local, shares, strict=True))
    )
    return Shapes(
        angle=angle @ to_nodes,
        curvature=curvature @ to_nodes,
        stretch=stretch @ nodal(stretch) if k else stretch,
        integral=integral,
        weights=weights,
        stations=stations,
    )


def gauss_points(start: float, end: float, degree: int) -> tuple[Array, Array]:
    """Gauss points and weights on a piece."""
    points, weights = legendre.leggauss(degree + MORE_POINTS)
    half = (end - start) / 2
    return start + half * (1 + points), half * weights


def piece_integral(stations: Array, start: float, end: float, degree: int) -> Array:
    """Integrals over a piece, up to the stations, of what is given at its Gauss points."""
    points, weights = legendre.leggauss(degree + MORE_POINTS)
    count, half = len(points), (end - start) / 2
    double = 2 * np.arange(count) + 1
    to_series = double[:, None] / 2 * legendre.legvander(points, count - 1).T * weights
    local = np.clip((stations - start) / half - 1, -1, 1)
    values = legendre.legvander(local, count)
    values[:, 1:-1] = (values[:, 2:] - values[:, :-2]) / double[1:]
    values[:, 0] += local
    return np.asarray(half * values[:, :-1] @ to_series)


@cache
def cantilever_modes(n: int, k: int, place: float) -> Shapes:
    """Shapes of the paper: the modes (8), (12) at rest and without the mass, signs corrected."""
    exact = polynomials(max(n, 8) + 8, 1, place)
    at = exact.stations[: len(exact.angle)]
    roots = np.array([_cantilever_root(i) for i in range(1, n + 1)])
    x = np.multiply.outer(at, roots)
    # xi of (12) is small - 1: nothing is subtracted that nearly cancels
    small = (np.sin(roots) - np.cos(roots) - np.exp(-roots)) / (np.sin(roots) + np.sinh(roots))
    falling, rising = (1 - small / 2) * np.exp(-x), small / 2 * np.exp(x)
    angle = -np.sin(x) + (small - 1) * np.cos(x) + falling - rising
    curvature = -np.cos(x) - (small - 1) * np.sin(x) - falling - rising
    odd = np.pi / 2 * (2 * np.arange(1, k + 1) - 1)
    return exact._replace(
        angle=angle,
        curvature=curvature * roots,
        stretch=np.cos(np.multiply.outer(at, odd)),
    )


def _clamped_free(x: float) -> float:
    return float(np.cos(x) + 1 / np.cosh(x))


def _cantilever_root(i: int) -> float:
    """Root i of cos x = -1 / cosh x, which (11) misprints."""
    middle = (i - 0.5) * np.pi
    return float(brentq(_clamped_free, middle - 0.5, middle + 0.5, xtol=1e-14))


# Equations of motion ------------------------------------------------------------------------
#
# Inside, axes of points come first (the transposed of what scenes are given), so that
# NumPy's matrix products run over them.


class Equations(NamedTuple):
    """``mass @ a + inertia`` of free coordinates (..., N), theta first, without forces."""

    mass: Any
    inertia: Any


class Exact(NamedTuple):
    """What the exact equations need of the parameters; see `exact`."""

    angle: Any
    """1 for theta, then P: d angle / d coordinates"""
    stretch: Any
    integral: Any
    """To the stations, times the root of J = mass times L^2 there"""
    lever: Any
    """Hub radius over L, times the same root"""
    hub: Any


def prepare_exact(shapes: Shapes, c: Coefficients) -> Exact:
    """Return what does not change with the state."""
    root = np.sqrt(station_masses(shapes, c))
    rigid = np.ones((*shapes.angle.shape[:-1], 1))
    return Exact(
        angle=np.concatenate([rigid, shapes.angle], axis=-1),
        stretch=shapes.stretch,
        integral=root[..., None] * shapes.integral,
        lever=root * np.asarray(c.hub_ratio)[..., None],
        hub=c.hub,
    )


def exact(q: Any, v: Any, beam: Exact) -> Equations:
    """Large deflection, by d'Alembert: Jacobian of the stations, in axes that turn with the hub.

    The tangent there turns with theta' + psi', so that with t and n along and across it the
    velocity of a station is the integral of ``(1 + e) (theta' + psi') n + e' t`` from the clamp,
    and its acceleration, without second derivatives of coordinates, that of
    ``2 e' (theta' + psi') n - (1 + e) (theta' + psi')^2 t``.
    """
    turns = beam.angle.shape[-1]
    angle = of(beam.angle[..., 1:], q[..., 1:turns])
    turn = of(beam.angle, v[..., :turns])
    x, y = np.cos(angle), np.sin(angle)
    columns = np.empty((*x.shape, 2, q.shape[-1] + 1), dtype=x.dtype)
    across, along, last = columns[..., :turns], columns[..., turns:-1], columns[..., -1]
    if along.shape[-1]:
        along[..., 0, :] = x[..., None] * beam.stretch
        along[..., 1, :] = y[..., None] * beam.stretch
        size, growth = 1 + of(beam.stretch, q[..., turns:]), of(beam.stretch, v[..., turns:])
        swing = 2 * growth * turn
        last[..., 0], last[..., 1] = -swing * y, swing * x
        x, y = size * x, size * y
    else:
        last[...] = 0
    np.multiply(-y[..., None], beam.angle, out=across[..., 0, :])
    np.multiply(x[..., None], beam.angle, out=across[..., 1, :])
    spin = turn * turn
    last[..., 0] -= spin * x
    last[..., 1] -= spin * y
    flat = beam.integral @ columns.reshape(*x.shape, -1)
    found = flat.reshape(*flat.shape[:-1], 2, columns.shape[-1])
    found[..., 1, 0] += beam.lever
    found[..., 0, -1] -= v[..., :1] * v[..., :1] * beam.lever
    rows = found.reshape(*flat.shape[:-2], -1, columns.shape[-1])
    products = rows.swapaxes(-1, -2) @ rows
    products[..., 0, 0] += beam.hub
    return Equations(products[..., :-1, :-1], products[..., :-1, -1])


class Truncated(NamedTuple):
    """Kinetic energy ``v M v / 2 + theta'^2 (U + A q / 2) q + theta' v W q``, q without theta.

    All have the size (..., N) of the coordinates, zero for theta where they go with q.
    """

    mass: Any
    """M of the straight beam: J_h and the moment of inertia, U_12 + a U_20, M_22, M_11"""
    pull: Any
    """U: U_11 + a U_10"""
    softening: Any
    """A: M_22 - D_1 - a D_0, M_11"""
    coupling: Any
    """W, antisymmetric: R of (16)"""


def prepare_truncated(shapes: Shapes, c: Coefficients, foreshortening: bool = True) -> Truncated:
    """Return the matrices (16), corrected; without the D as the zero-order model has them."""
    masses = station_masses(shapes, c)
    radii = np.asarray(c.hub_ratio)[..., None] + shapes.stations
    axial, bending = shapes.integral @ shapes.stretch, shapes.integral @ shapes.angle
    n, size = bending.shape[-1], 1 + bending.shape[-1] + axial.shape[-1]
    bend, rest = slice(1, n + 1), slice(n + 1, size)
    along = np.zeros((*masses.shape, size))  # what the coordinates move the stations by
    across = np.zeros_like(along)
    along[..., rest], across[..., bend] = axial, bending
    across[..., 0] = radii
    left_along, left_across = (
        shape.swapaxes(-1, -2) * masses[..., None, :] for shape in (along, across)
    )
    mass = left_along @ along + left_across @ across
    softening = mass.copy()
    softening[..., 0, :] = softening[..., :, 0] = 0
    if foreshortening:
        tension = of(shapes.integral.swapaxes(-1, -2), masses * radii)
        slope = shapes.angle.swapaxes(-1, -2)
        softening[..., bend, bend] -= (slope * tension[..., None, :]) @ shapes.angle
    across[..., 0] = 0
    coupling = left_across @ along
    coupling[..., 0, :] = 0
    mass[..., 0, 0] += c.hub
    return Truncated(
        mass=mass,
        pull=of(left_along, radii),
        softening=softening,
        coupling=coupling - coupling.swapaxes(-1, -2),
    )


def truncated(q: Any, v: Any, beam: Truncated) -> Equations:
    """Small deflection: (14) to (16), corrected."""
    speed = v[..., :1]
    soft, cross = of(beam.softening, q), of(beam.coupling, q)
    pull = beam.pull + soft
    shape = np.broadcast_shapes(cross.shape, beam.pull.shape)
    mass = np.empty((*shape, shape[-1]), dtype=cross.dtype)
    mass[...] = beam.mass
    mass[..., 0, 0] += dot(beam.pull + pull, q)
    mass[..., 0, :] += cross
    mass[..., :, 0] += cross
    inertia = speed * (2 * of(beam.coupling, v) - speed * pull)
    inertia[..., 0] = 2 * speed[..., 0] * dot(pull, v)
    return Equations(mass, inertia)


class Tip(NamedTuple):
    """Displacement of the tip over L, in the hub frame."""

    deflection: Any
    deflection_dot: Any
    axial: Any
    axial_dot: Any


OUTPUTS = tuple(f"tip_{name}" for name in Tip._fields)


def exact_tip(q: Any, v: Any, shapes: Shapes) -> Tip:
    """Integrals of the tangent over the whole beam."""
    n = shapes.angle.shape[-1]
    angle, turn = of(shapes.angle, q[..., 1 : n + 1]), of(shapes.angle, v[..., 1 : n + 1])
    stretch, growth = of(shapes.stretch, q[..., n + 1 :]), of(shapes.stretch, v[..., n + 1 :])
    cos, sin, size = np.cos(angle), np.sin(angle), 1 + stretch
    shortening = -2 * np.sin(angle / 2) ** 2  # cos - 1 without its lost digits
    return Tip(
        dot(shapes.weights, size * sin),
        dot(shapes.weights, growth * sin + size * turn * cos),
        dot(shapes.weights, shortening + stretch * cos),
        dot(shapes.weights, growth * cos - size * turn * sin),
    )


def truncated_tip(q: Any, v: Any, shapes: Shapes, foreshortening: bool = True) -> Tip:
    """v, and u less the foreshortening, at the tip."""
    n = shapes.angle.shape[-1]
    slope, turn = of(shapes.angle, q[..., 1 : n + 1]), of(shapes.angle, v[..., 1 : n + 1])
    stretch, growth = of(shapes.stretch, q[..., n + 1 :]), of(shapes.stretch, v[..., n + 1 :])
    if foreshortening:
        stretch, growth = stretch - slope * slope / 2, growth - slope * turn
    return Tip(*(dot(shapes.weights, value) for value in (slope, turn, stretch, growth)))


def station_masses(shapes: Shapes, c: Coefficients) -> Any:
    """Mass times L^2 at each station (..., stations) [kg m^2]."""
    beam = np.asarray(c.beam)[..., None] * shapes.weights
    point = np.broadcast_to(np.asarray(c.point)[..., None], (*beam.shape[:-1], 1))
    return np.concatenate([beam, point], axis=-1)


def stiffness(shapes: Shapes, c: Coefficients) -> Any:
    """Stiffness matrix (..., N, N), zero for theta."""
    n, size = shapes.angle.shape[-1], 1 + shapes.angle.shape[-1] + shapes.stretch.shape[-1]
    bending, axial = (
        np.asarray(modulus)[..., None, None]
        * ((shape.swapaxes(-1, -2) * shapes.weights[..., None, :]) @ shape)
        for modulus, shape in ((c.bending, shapes.curvature), (c.axial, shapes.stretch))
    )
    found = np.zeros((*bending.shape[:-2], size, size))
    found[..., 1 : n + 1, 1 : n + 1] = bending
    found[..., n + 1 :, n + 1 :] = axial
    return found


def of(matrix: Any, vector: Any) -> Any:
    """Product of matrices (..., i, j) and vectors (..., j)."""
    if matrix.ndim == 2 and vector.ndim == 1:
        return matrix.dot(vector)
    return (matrix @ vector[..., None])[..., 0]


def dot(one: Any, other: Any) -> Any:
    """Scalar products of vectors (..., i)."""
    return np.sum(one * other, axis=-1)


# Scenes -------------------------------------------------------------------------------------

UNITS = {
    "theta": "rad",
    "theta_dot": "rad/s",
    "tip_deflection": "m",
    "tip_deflection_dot": "m/s",
    "tip_axial": "m",
    "tip_axial_dot": "m/s",
}

PAPER = Paper(
    "Y. Yang, Y. Wang, H. Chen, M. Wu",
    "Dynamic Modeling and Response of a Rotating Cantilever Beam with a Concentrated Mass",
    "Shock and Vibration 2016",
    2016,
    "",
)


def period(p: RotatingBeam) -> Any:
    """Period [s] of the first bending mode at rest, without the mass."""
    line = p.density * p.area
    bending = p.youngs_modulus * p.second_moment
    return 2 * np.pi / FIRST * np.sqrt(line * np.asarray(p.length) ** 4 / bending)


FIRST = 3.516015268500150
"""1.8751^2 of the cantilever."""


def unforced(p: RotatingBeam) -> RotatingBeam:
    """No torque; a prescribed hub turns at its speed."""
    return p.replace(torque_amplitude=0.0, ramp_time=0.0)


def driven_until(p: RotatingBeam) -> float:
    """End of the ramp or of the pulse [s]."""
    return float(p.torque_period if p.drive == "torque" else p.ramp_time)


def spectrum(continuum: str, p: RotatingBeam, plane: str, count: int) -> tuple[Array, Array]:
    """Frequencies (count,) [rad/s] of a continuum that rotates steadily, and their bounds."""
    from .frequencies import frequencies  # which takes the parameters from here

    found = frequencies(p, plane, count, continuum)
    return found.omega, found.bound


def rotation(p: RotatingBeam) -> dict[str, float]:
    """Straight beam that turns with ``angular_speed``."""
    return {"theta_dot": p.angular_speed}


def given(p: RotatingBeam) -> dict[str, float]:
    """Speed of a hub whose motion is prescribed: 0, or that of the rotation without a ramp."""
    if p.drive == "torque":
        return {}
    return {"theta_dot": p.angular_speed if p.ramp_time == 0 else 0.0}


class Theory(NamedTuple):
    """What one model of the beam is made of."""

    title: str
    prepare: Callable[[Shapes, Coefficients], Any]
    equations: Callable[[Any, Any, Any], Equations]
    tip: Callable[[Any, Any, Shapes], Tip]
    continuum: str | None = None
    """Whose frequencies are known, see `rotating_beam_frequencies`"""
    tolerances: tuple[float, float] = (1e-10, 1e-8)
    """Of `solve`; waves along the beam, which no one sees, would cost much more"""


THEORIES = {
    "inextensible": Theory("exact, inextensible", prepare_exact, exact, exact_tip, "inextensible"),
    "extensible": Theory(
        "exact, extensible", prepare_exact, exact, exact_tip, "extensible", (1e-8, 1e-6)
    ),
    "second_order": Theory(
        "small deflection, the paper's, corrected", prepare_truncated, truncated, truncated_tip
    ),
    "zero_order": Theory(
        "small deflection without foreshortening",
        partial(prepare_truncated, foreshortening=False),
        truncated,
        partial(truncated_tip, foreshortening=False),
    ),
}


class Prepared(NamedTuple):
    """What does not change with the state."""

    c: Coefficients
    shapes: Shapes
    theory: Any
    stiffness: Any


@cache
def beam_scene(
    theory: str = "inextensible",
    n: int = 10,
    k: int = 0,
    shapes: Callable[[int, int, float], Shapes] = polynomials,
) -> Scene:
    """Return the scene with n bending and k stretching coordinates; one object for each.

    Parameters
    ----------
    theory : str
        Of `THEORIES`.
    n, k : int
    shapes : callable
        `polynomials`, or the `cantilever_modes` of the paper.
    """
    about = THEORIES[theory]

    def prepare(c: Coefficients) -> Prepared:
        """Return what does not change with the state."""
        at = shapes_of(c.place, n, k, shapes)
        return Prepared(c, at, about.prepare(at, c), stiffness(at, c))

    prepare_one = lru_cache(64)(prepare)

    def prepared(c: Coefficients, axes: int) -> Prepared:
        """Return it for one set of numbers, or for arrays beside states of so many axes."""
        try:
            return prepare_one(c)
        except TypeError:  # arrays
            return prepare(Coefficients(*(lifted(value, axes - 1) for value in c)))

    def equations(u: Any, q: Any, v: Any, c: Coefficients) -> tuple[Any, Any, Equations]:
        """M and f with the hub's row as its drive has it, and `Equations`.

        Where the hub is prescribed, its row and column are those of the identity, and what its
        acceleration does to the others is part of f.
        """
        q, v = np.asarray(q).T, np.asarray(v).T
        beam = prepared(c, q.ndim)
        found = about.equations(q, v, beam.theory)
        load = -found.inertia - of(beam.stiffness, q)
        u, free = lifted(u, q.ndim - 1), np.asarray(1 - beam.c.prescribed)
        load -= np.asarray(u * beam.c.prescribed)[..., None] * found.mass[..., 0]
        load[..., 0] = u + free * load[..., 0]
        mass = found.mass.copy()
        mass[..., 0, :] *= free[..., None]
        mass[..., 1:, 0] *= free[..., None]
        mass[..., 0, 0] += beam.c.prescribed
        return mass, load, found

    def mass_matrix(q: Any, c: Coefficients, xp: Any = np) -> Any:
        """M; the hub's row and column are those of the identity where it is prescribed."""
        mass, _, _ = equations(0.0, q, np.zeros_like(q), c)
        return mass.swapaxes(-1, -2).T

    def forces(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> Any:
        """Forces less the velocity-dependent inertia terms."""
        _, load, _ = equations(u, q, v, c)
        return load.T

    def accelerations(u: Any, q: Any, v: Any, c: Coefficients, xp: Any = np) -> Any:
        """Solution of ``M a = forces``."""
        mass, load, _ = equations(u, q, v, c)
        if load.ndim == 1 and load.dtype == float:
            _, _, found, failed = dgesv(mass, load)
            return found if not failed else np.full_like(load, np.nan)
        return np.linalg.solve(mass, load[..., None])[..., 0].T

    def energy(q: Any, v: Any, c: Coefficients) -> Any:
        """Kinetic energy and strain energy [J]."""
        q, v = np.asarray(q).T, np.asarray(v).T
        beam = prepared(c, q.ndim)
        mass = about.equations(q, v, beam.theory).mass
        return ((dot(v, of(mass, v)) + dot(q, of(beam.stiffness, q))) / 2).T

    def momentum(q: Any, v: Any, c: Coefficients) -> Any:
        """Angular momentum of hub, beam and mass about the axis [kg m^2/s]."""
        q, v = np.asarray(q).T, np.asarray(v).T
        return dot(about.equations(q, v, prepared(c, q.ndim).theory).mass[..., 0, :], v).T

    def powers(u: Any, q: Any, v: Any, c: Coefficients) -> dict[str, Any]:
        """Power [W] of the torque on the hub: the given one, or what its motion takes."""
        mass, load, found = equations(u, q, v, c)
        a = np.linalg.solve(mass, load[..., None])[..., 0]
        taken = (dot(found.mass[..., 0, :], a) + found.inertia[..., 0]).T
        return {"hub": (c.prescribed * taken + (1 - c.prescribed) * u) * v[0]}

    def outputs(q: Any, v: Any, c: Coefficients, xp: Any = np) -> dict[str, Any]:
        """Tip's displacement in the hub frame."""
        q, v = np.asarray(q).T, np.asarray(v).T
        tip = about.tip(q, v, prepared(c, q.ndim).shapes)
        return {name: c.length * value.T for name, value in zip(OUTPUTS, tip, strict=True)}

    def invariants(p: RotatingBeam) -> Mapping[str, Callable[..., Any]]:
        """Energy and momentum of a hub on its own; ``E - theta' H`` of one that keeps its speed."""
        if p.drive == "prescribed":
            return {"jacobi": jacobi}
        return {"energy": energy, "momentum": momentum}

    def jacobi(q: Any, v: Any, c: Coefficients) -> Any:
        """Energy in the turning frame [J], the centrifugal potential included."""
        return energy(q, v, c) - v[0] * momentum(q, v, c)

    bends = tuple(f"b_{i}" for i in range(1, n + 1))
    stretches = tuple(f"e_{i}" for i in range(1, k + 1))
    rates = {f"{name}_dot": "1/s" for name in bends + stretches}
    return Scene(
        name="rotating_beam",
        title=f"hub with a flexible beam and a concentrated mass ({about.title})",
        paper=PAPER,
        parameters=RotatingBeam,
        coordinates=("theta", *bends, *stretches),
        units=UNITS | dict.fromkeys(bends, "rad") | dict.fromkeys(stretches, "1") | rates,
        coefficients=coefficients,
        drive=drive,
        mass_matrix=mass_matrix,
        forces=forces,
        accelerations=accelerations,
        damping_matrix=lambda c: np.zeros((1 + n + k, 1 + n + k)),
        energy=energy,
        powers=powers,
        equilibria={"rotation": rotation},
        held={"rotation": ("theta",)},
        turning={"theta": 1},
        period=period,
        orbit_guesses=lambda p: [],
        unforced=unforced,
        given=given,
        outputs=outputs,
        observed=OUTPUTS[:3],
        invariants=invariants,
        run_quantities=run_quantities,
        run_units=RUN_UNITS,
        outcome=outcome,
        stiff=about.tolerances,
        spectrum=partial(spectrum, about.continuum) if about.continuum else None,
        driven_until=driven_until,
        internal=bends + stretches,
        cases=CASES,
    )


def shapes_of(place: Any, n: int, k: int, shapes: Callable[[int, int, float], Shapes]) -> Shapes:
    """Shapes for one place of the mass, or stacked for an array of them."""
    places, index = np.unique(place, return_inverse=True)
    found = [shapes(n, k, one) for one in places.tolist()]
    if len(found) == 1:
        return found[0]
    count = max(len(one.weights) for one in found)
    padded = [padding(one, count - len(one.weights)) for one in found]
    where = index.reshape(np.shape(place))
    return Shapes(*(np.stack(parts)[where] for parts in zip(*padded, strict=True)))


def padding(shapes: Shapes, count: int) -> Shapes:
    """Put points that weigh nothing before the others."""
    return Shapes(*(np.pad(part, ((count, 0), (0, 0))[: part.ndim]) for part in shapes))._replace(
        integral=np.pad(shapes.integral, ((count, 0), (count, 0)))
    )


def lifted(value: Any, axes: int) -> Any:
    """A coefficient over points with their axes turned as those of the states, and as many."""
    if np.ndim(value) == 0:
        return value
    turned = np.asarray(value).T
    return turned.reshape(*turned.shape, *(1,) * (axes - turned.ndim))


# What a run is judged by ------------------------------------------------------------------

RUN_UNITS = {"tip_peak": "m", "tip_peak_time": "s", "tip_rms_after": "m"}


def run_quantities(
    times: Any, values: Mapping[str, Any], p: RotatingBeam
) -> dict[str, tuple[float, float]]:
    """Largest deflection of the tip, its time, and the RMS value once nothing drives the hub.

    Between samples by cubics that have their rates. An error of the rate shifts the time of the
    peak by its share of the acceleration there.
    """
    tip = CubicHermiteSpline(times, values["tip_deflection"], values["tip_deflection_dot"])
    inner = tip.derivative().roots(extrapolate=False)
    at = np.concatenate([inner, [times[0], times[-1]]])
    peak = float(at[np.argmax(np.abs(tip(at)))])
    after = np.asarray(times) >= driven_until(p)
    rest = values["tip_deflection"][after] if np.any(after) else np.zeros(1)
    return {
        "tip_peak": (float(tip(peak)), 1.0),
        "tip_peak_time": (peak, 1 / max(abs(float(tip(peak, 2))), 1e-12)),
        "tip_rms_after": (float(np.sqrt(np.mean(rest**2))), 1.0),
    }


# What a run ends in -------------------------------------------------------------------------


def outcome(times: Any, values: Mapping[str, Any], p: RotatingBeam) -> str:
    """Tell whether the deflection stays bounded.

    The first that holds of:

    1. *diverges*: the tip is farther beside the axis than the beam is long.
    2. *undecided*: a value is not finite; after the drive's end the run lasts less than
       `WATCH` times `period`.
    3. *diverges*: in the last third of that time the deflection swings `RISE` times as far
       as in the first. A vibration that goes on does not: nothing damps it, nothing drives it.
    4. *bounded*: what is left.
    """
    t, tip = np.asarray(times, dtype=float), np.asarray(values["tip_deflection"], dtype=float)
    if np.any(np.abs(tip) > p.length * BEYOND):
        return "diverges"
    rest = t - (p.ramp_time if p.drive == "prescribed" else p.torque_period)
    if not (len(t) and np.all(np.isfinite(tip)) and rest[-1] >= WATCH * period(p)):
        return "undecided"
    first, last = (
        np.max(np.abs(tip[(rest >= start * rest[-1]) & (rest <= end * rest[-1])]), initial=0.0)
        for start, end in ((0, 1 / 3), (2 / 3, 1))
    )
    return "diverges" if last > RISE * first else "bounded"


WATCH = 2.0

BEYOND = 1.1
"""Tip's deflection over the length; no inextensible beam has more than 1."""

RISE = 3.0
"""Share of the first by which the last deflections may be larger: beats of two modes."""


# Cases --------------------------------------------------------------------------------------

TIP_MASS = 0.4
"""[kg], the smallest of section 3.1: figures 4 and 5 do not name theirs."""

FIGURE_4 = RotatingBeam(mass=TIP_MASS)
FIGURE_5 = RotatingBeam(mass=TIP_MASS, drive="torque")
QUICK = FIGURE_4.replace(angular_speed=1.0, ramp_time=3.0, segments=12)
PULSE = FIGURE_5.replace(torque_amplitude=20.0, torque_period=1.5, segments=12)
STEADY = RotatingBeam(angular_speed=4.0, ramp_time=0.0)
ABOVE_CRITICAL = RotatingBeam(angular_speed=4.0, ramp_time=3.0, segments=8)


def _case(name: str, p: RotatingBeam, state: dict[str, float], horizon: float, *kinds: str) -> Case:
    return Case("rotating_beam", name, p, state, horizon, kinds)


def _steady(name: str, **changes: Any) -> Case:
    p = STEADY.replace(**changes)
    return replace(
        _case(name, p, {}, 0.5, "frequency", "order"), about="rotation", watch="elements"
    )


def steady_speed(number: float) -> float:
    """Speed [rad/s] of the default beam of this dimensionless speed."""
    return float(number * 2 * np.pi / period(RotatingBeam()) / FIRST)


STEADY_CASES: Mapping[str, Mapping[str, Any]] = {
    "steady_at_rest": {"angular_speed": 0.0},
    "steady_4": {"angular_speed": steady_speed(4)},
    "steady_4_chain_b": {"angular_speed": steady_speed(4), "scheme": "B"},
    "steady_4_hub_radius": {"angular_speed": steady_speed(4), "hub_radius": 8.0},
    "steady_4_tip_mass": {"angular_speed": steady_speed(4), "mass": 1.6, "hub_radius": 1.0},
    "steady_4_geometrically_exact": {
        "angular_speed": steady_speed(4),
        "element": "geometrically_exact",
    },
    "steady_12": {"angular_speed": steady_speed(12), "segments": 24},
    "steady_12_chain_b": {"angular_speed": steady_speed(12), "segments": 24, "scheme": "B"},
}
"""Steady rotation by dimensionless speed; chains need 24 rods at 12 for asymptotic errors."""


CASES = (
    _case("spin_up_quick", QUICK, {}, 4.0, "algebra", "trajectory"),
    replace(_case("pulse_quick", PULSE, {}, 2.0, "trajectory", "energy"), methods="best"),
    replace(_case("spin_up", FIGURE_4, {}, 17.0, "trajectory"), full_only=True, methods="best"),
    replace(_case("pulse", FIGURE_5, {}, 12.0, "trajectory"), full_only=True, methods="best"),
    *(_steady(name, **changes) for name, changes in STEADY_CASES.items()),
    replace(
        _case("above_critical", ABOVE_CRITICAL, {}, 8.0, "stability"),
        watch="outcome",
        methods="best",
    ),
)
"""``spin_up`` and ``pulse`` are figures 4 and 5, the quick ones bend the beam as far in less time.
``above_critical`` turns faster than the zero-order model can stand, `critical_speed`."""


def critical_speed(p: RotatingBeam) -> float:
    """Speed [rad/s] above which the zero-order model has no stable rotation.

    There its ``K - theta'^2 M`` of bending loses its definiteness: at the first natural
    frequency of the beam with its mass at rest, whatever the hub radius.
    """
    mass, _, k = linearise(ZERO_ORDER, p, ZERO_ORDER.state({}))
    bends = slice(1, BENDING + 1)
    return float(np.sqrt(eigh(k[bends, bends], mass[bends, bends], eigvals_only=True)[0]))


BENDING, STRETCHING = 8, 3
"""Coordinates of the reference: 10 bending ones change the tip of figure 4 by 4e-7 m, 2e-7 of
its deflection."""

SCENE, EXTENSIBLE, SECOND_ORDER, ZERO_ORDER = (
    replace(
        beam_scene(theory, BENDING, k),
        finer=beam_scene(theory, BENDING + 2, k and k + 1),
    )
    for theory, k in (
        ("inextensible", 0),
        ("extensible", STRETCHING),
        ("second_order", STRETCHING),
        ("zero_order", STRETCHING),
    )
)
SCENE = replace(
    SCENE,
    variants={"extensible": EXTENSIBLE, "second_order": SECOND_ORDER, "zero_order": ZERO_ORDER},
)
