"""Bent shapes of the reference in the coordinates of chains and elements, without stretch."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre

from ..scene import Array
from . import BENDING, SCENE
from .parameters import RotatingBeam, coefficients
from .shapes import MORE_POINTS, pieces, polynomials


class Bent(NamedTuple):
    """Places of the inextensible beam in the hub frame, over L.

    Attributes
    ----------
    angle, x, y : array (3, k)
        Value, rate and acceleration of the tangent's angle, and of the displacements.
    hub : float
        Acceleration of the hub [rad/s^2] without what drives it.
    """

    angle: Array
    x: Array
    y: Array
    hub: float


def bent(p: RotatingBeam, values: Mapping[str, float], places: Any) -> Bent:
    """Return the motion of places (k,) over L from the clamp, of a state of the scene."""
    c, places = coefficients(p), np.asarray(places, dtype=float)
    known = {name: values[name] for name in SCENE.state_names if name in values}
    q, v = np.split(SCENE.state(known), 2)
    a = np.asarray(SCENE.accelerations(0.0, q, v, c), dtype=float)
    shapes = polynomials(BENDING, 0, float(c.place))
    angles = np.array([q[1:], v[1:], a[1:]]) @ shapes.angle.T
    fields = np.concatenate([angles, *tangents(angles)])
    motion, ends, first = np.zeros((9, len(places))), np.zeros((9, 1)), 0
    for start, end, degree in pieces(BENDING, float(c.place)):
        last, half = first + degree + MORE_POINTS, (end - start) / 2
        local = (shapes.stations[first:last] - start) / half - 1
        series = legendre.legfit(local, fields[:, first:last].T, len(local) - 1)
        integral = half * legendre.legint(series[:, 3:], lbnd=-1)
        inside = (start <= places) & (places <= end)
        at = (places[inside] - start) / half - 1
        motion[:3, inside] = legendre.legval(at, series[:, :3])
        motion[3:, inside] = ends[3:] + legendre.legval(at, integral)
        ends[3:] += legendre.legval(np.ones(1), integral)
        first = last
    return Bent(motion[:3], motion[3:6], motion[6:], float(a[0]))


def tangents(angles: Array) -> Array:
    """Return tangents (2, 3, k), less that of the straight beam, of angles (3, k)."""
    (angle, rate, gain), less = angles, -2 * np.sin(angles[0] / 2) ** 2  # cos - 1, all digits
    cos, sin, swing = np.cos(angle), np.sin(angle), rate * rate
    return np.array(
        [
            [less, -sin * rate, -sin * gain - cos * swing],
            [sin, cos * rate, cos * gain - sin * swing],
        ]
    )


def chain_start(
    p: RotatingBeam, values: Mapping[str, float], ends: tuple[float, ...]
) -> dict[str, float]:
    """Return the state of rods between these places (n + 1,) over L of the beam, as its chords."""
    shape = bent(p, values, ends)
    x, y = np.diff(shape.x, axis=1), np.diff(shape.y, axis=1)
    x[0] += np.diff(ends)
    angles = np.arctan2(y[0], x[0])
    rates = (x[0] * y[1] - y[0] * x[1]) / (x[0] ** 2 + y[0] ** 2)
    state = {name: float(values.get(name, 0.0)) for name in ("theta", "theta_dot")}
    for i, (angle, rate) in enumerate(zip(*np.diff([angles, rates], prepend=0.0), strict=True), 1):
        state |= {f"joint_{i}": float(angle), f"joint_{i}_dot": float(rate)}
    return state


class Unstretched(NamedTuple):
    """Nodes of elements (N,) in all their coordinates, as the inextensible beam has them.

    Attributes
    ----------
    places, rates, accelerations : array (N,)
        Of displacements, in the hub frame.
    along : array (N, m)
        What stretches each element, then each slope vector.
    hub : float
        Acceleration of the hub [rad/s^2] without what drives it.
    """

    places: Array
    rates: Array
    accelerations: Array
    along: Array
    hub: float


def unstretched_nodes(
    p: RotatingBeam, values: Mapping[str, float], at: Array, slopes_too: bool
) -> Unstretched:
    """Return the nodes at these places (k,) over L: with slope vectors, or with angles.

    An element between angles has the tangent of their mean, and its nodes follow from that.
    """
    shape, count = bent(p, values, at), len(at)
    means = tangents((shape.angle[:, 1:] + shape.angle[:, :-1]) / 2)
    chords = means[:, 0] + np.array([[1.0], [0.0]])  # (2, k - 1)
    beyond = np.tri(count, count - 1, -1)
    if slopes_too:
        slopes = tangents(shape.angle)
        nodes = np.stack([p.length * shape.x, p.length * shape.y, *slopes], axis=-1)
    else:
        parts = [p.length * (mean * np.diff(at)) @ beyond.T for mean in means]
        nodes = np.stack([*parts, shape.angle], axis=-1)
    size = nodes.shape[-1]
    along = np.zeros((count, size, count - 1 + count * slopes_too))
    along[:, 0, : count - 1], along[:, 1, : count - 1] = beyond * chords[0], beyond * chords[1]
    if slopes_too:
        for i in range(2):
            along[:, 2 + i, count - 1 :] = np.diag(slopes[i, 0] + (1 - i))
    places, rates, accelerations = nodes.reshape(3, -1)
    columns = along.reshape(count * size, -1)
    return Unstretched(places, rates, accelerations, columns, shape.hub)
