"""Equations of motion of `rotating_beam`: exact, and truncated as the paper has them.

Inside, axes of points come first (the transposed of what scenes are given), so that
NumPy's matrix products run over them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import block_diag

from .hub import dot, of
from .parameters import Coefficients, hub_gravity
from .shapes import Shapes


class Equations(NamedTuple):
    """``mass @ a + inertia`` of free coordinates (..., N), theta first.

    Gravity g is an acceleration -g of the axis, and so is part of the inertia.
    """

    mass: Any
    inertia: Any


class Exact(NamedTuple):
    """Constants of the exact equations; see `exact`.

    Attributes
    ----------
    angle : float or array
        1 for theta, then P: d angle / d coordinates.
    integral : float or array
        To the stations, times the root of J = mass times L^2 there.
    lever : float or array
        Hub radius over L, times the same root.
    weight : float or array
        The root times 1 (..., stations), None without gravity.
    """

    angle: Any
    stretch: Any
    integral: Any
    lever: Any
    hub: Any
    weight: Any
    c: Coefficients


def prepare_exact(shapes: Shapes, c: Coefficients) -> Exact:
    """Return the constants of the exact equations."""
    root = np.sqrt(station_masses(shapes, c))
    return Exact(
        angle=np.hstack([np.ones((len(shapes.angle), 1)), shapes.angle]),
        stretch=shapes.stretch,
        integral=root[:, None] * shapes.integral,
        lever=root * c.hub_ratio,
        hub=c.hub,
        weight=root if c.gravity_x or c.gravity_y else None,
        c=c,
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
    terms = flat.reshape(*flat.shape[:-1], 2, columns.shape[-1])
    terms[..., 1, 0] += beam.lever
    terms[..., 0, -1] -= v[..., :1] * v[..., :1] * beam.lever
    if beam.weight is not None:
        for i, gravity in enumerate(hub_gravity(q[..., 0], beam.c)):
            terms[..., i, -1] -= np.asarray(gravity)[..., None] * beam.weight
    rows = terms.reshape(*flat.shape[:-2], -1, columns.shape[-1])
    products = rows.swapaxes(-1, -2) @ rows
    products[..., 0, 0] += beam.hub
    return Equations(products[..., :-1, :-1], products[..., :-1, -1])


def exact_potential(q: Any, beam: Exact) -> Any:
    """Potential energy [J] of gravity, 0 where all mass is on the axis."""
    if beam.weight is None:
        return 0.0
    turns = beam.angle.shape[-1]
    angle = of(beam.angle[..., 1:], q[..., 1:turns])
    size = 1 + of(beam.stretch, q[..., turns:])
    along, across = hub_gravity(q[..., 0], beam.c)
    x = beam.lever + of(beam.integral, size * np.cos(angle))
    y = of(beam.integral, size * np.sin(angle))
    return -along * dot(beam.weight, x) - across * dot(beam.weight, y)


class Truncated(NamedTuple):
    """Kinetic energy ``v M v / 2 + theta'^2 (U + A q / 2) q + theta' v W q``, q without theta.

    All have the size (..., N) of the coordinates, zero for theta where they go with q.

    Attributes
    ----------
    mass : float or array
        M of the straight beam: J_h and the moment of inertia, U_12 + a U_20, M_22, M_11.
    pull : float or array
        U: U_11 + a U_10.
    softening : float or array
        A: M_22 - D_1 - a D_0, M_11.
    coupling : float or array
        W, antisymmetric: R of (16).
    weight : float or array
        `Weight`, None without gravity.
    """

    mass: Any
    pull: Any
    softening: Any
    coupling: Any
    weight: Any
    c: Coefficients


class Weight(NamedTuple):
    """Integrals over the mass: ``rigid + along q - q shortening q / 2`` of x, ``across q`` of y."""

    rigid: Any
    along: Any
    across: Any
    shortening: Any


def prepare_truncated(shapes: Shapes, c: Coefficients, foreshortening: bool = True) -> Truncated:
    """Return the matrices (16), corrected; without the D as the zero-order model has them."""
    masses, radii = station_masses(shapes, c), c.hub_ratio + shapes.stations
    axial, bending = shapes.integral @ shapes.stretch, shapes.integral @ shapes.angle
    n, size = bending.shape[1], 1 + bending.shape[1] + axial.shape[1]
    bend, rest = slice(1, n + 1), slice(n + 1, size)
    along = np.zeros((len(masses), size))  # what the coordinates move the stations by
    across = np.zeros_like(along)
    along[:, rest], across[:, bend] = axial, bending
    across[:, 0] = radii
    mass = (along.T * masses) @ along + (across.T * masses) @ across
    softening = mass.copy()
    softening[0] = softening[:, 0] = 0

    def shortened(lever: Any) -> Any:
        """Return the quadratic form in q of the foreshortening, of masses with a lever."""
        matrix = np.zeros_like(mass)
        if foreshortening:
            tension = shapes.integral.T @ (masses * lever)
            matrix[bend, bend] = (shapes.angle.T * tension) @ shapes.angle
        return matrix

    softening -= shortened(radii)
    coupling = (across.T * masses) @ along
    coupling[0] = 0
    mass[0, 0] += c.hub
    across[:, 0] = 0
    weight = Weight(masses @ radii, along.T @ masses, across.T @ masses, shortened(1.0))
    return Truncated(
        mass=mass,
        pull=along.T @ (masses * radii),
        softening=softening,
        coupling=coupling - coupling.T,
        weight=weight if c.gravity_x or c.gravity_y else None,
        c=c,
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
    if beam.weight is not None:
        along, across = hub_gravity(q[..., 0], beam.c)
        x, y, slope = centre(q, beam.weight)
        inertia -= np.asarray(along)[..., None] * slope
        inertia -= np.asarray(across)[..., None] * beam.weight.across
        inertia[..., 0] -= across * x - along * y
    return Equations(mass, inertia)


def centre(q: Any, weight: Weight) -> tuple[Any, Any, Any]:
    """Integrals of x and y over the mass, and the slope of the first by the coordinates."""
    bent = of(weight.shortening, q)
    x = weight.rigid + dot(weight.along - bent / 2, q)
    return x, dot(weight.across, q), weight.along - bent


def truncated_potential(q: Any, beam: Truncated) -> Any:
    """Potential energy [J] of gravity, 0 where all mass is on the axis."""
    if beam.weight is None:
        return 0.0
    x, y, _ = centre(q, beam.weight)
    along, across = hub_gravity(q[..., 0], beam.c)
    return -along * x - across * y


class Tip(NamedTuple):
    """Displacement of the tip over L, in the hub frame."""

    deflection: Any
    deflection_dot: Any
    axial: Any
    axial_dot: Any


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
    """Mass times L^2 at each station (stations,) [kg m^2]."""
    return np.append(c.beam * shapes.weights, c.point)


def stiffness(shapes: Shapes, c: Coefficients) -> Any:
    """Stiffness matrix (N, N), zero for theta."""
    bending, axial = (
        modulus * ((shape.T * shapes.weights) @ shape)
        for modulus, shape in ((c.bending, shapes.curvature), (c.axial, shapes.stretch))
    )
    return block_diag(0.0, bending, axial)
