"""Continuation: curves on which m equations of m + 1 unknowns hold, by pseudo-arclength.

A step predicts a point, by the cubic through the last two points and their tangents, or along the
first tangent; Newton's method corrects it on the plane across the last tangent, so that turning
points need no care (Keller 1977; Allgower, Georg 2003).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..scene import Array


class CurveEquations(NamedTuple):
    """Equations of a curve.

    Attributes
    ----------
    linearise : callable ``z (m + 1,) -> residual (m,), Jacobian (m, m + 1)``
        Unknowns are in units in which they are of order one.
    residual : callable ``z (m + 1,) -> (m,)``, or None
        Given where residuals are dear and the Jacobian is that of a neighbour of them: it then
        serves all iterations, and secants (Broyden 1965) mend it.
    slopes : callable ``z (m + 1,) -> Jacobian (m, m + 1)``, or None
        Given with it: of the neighbour, for the tangent.
    """

    linearise: Callable[[Array], tuple[Array, Array]]
    residual: Callable[[Array], Array] | None = None
    slopes: Callable[[Array], Array] | None = None

    @property
    def exact(self) -> bool:
        """Whether the Jacobian is that of the residual."""
        return self.residual is None


class ContinuationOptions(NamedTuple):
    """How curves are followed; lengths are in the unit of the unknowns, those of places 0 to 1.

    Attributes
    ----------
    ds, ds_min, ds_max : float
        First, shortest and longest step along a curve.
    growth : (float, float)
        Least and largest length of a step, in that of the step before.
    turn, max_turn : float
        Angle between the tangents of neighbours: the one aimed at, and the largest accepted [rad].
    aim, max_offset : float
        Distance from where a cubic led, in the step's length: aimed at, and the largest accepted;
        it grows as the third power of that.
    max_offset_line : (float, float)
        The same from where a tangent led, by the turn and beside: of an arc it is half the turn,
        and more where another curve was met.
    max_points : int
        Points of a curve in one direction.
    max_iterations : int
        Newton iterations of a point.
    tolerance : float
        Correction after which no other is made: it leaves its square.
    noise : float
        Largest correction of a solution whose corrections stop shrinking: flows of engines are
        noisy.
    integration : float
        What integration may leave of a point of the reference.
    steps_min, steps_max : int
        Steps of the reference in a (half) period.
    rounding, step_rounding : float
        Of a period's end, in the sizes of the states: as it is, and by the root of its steps.
    edge : float
        How near an edge of the window is on it.
    symmetric : float
        Departure from its mirror image of an orbit that has become symmetric.
    near_meeting : float
        `margin` below which another bifurcation may be near.
    careful : (float, float)
        Longest step, the first and any other, from there: two bifurcations must not lie in between,
        nor another curve of the kind ahead. Longer ones may be taken while the margin hardly
        changes.
    max_change : float
        Most that the margin may change by in such a step, relative to itself.
    landed, max_landings : float, int
        Largest margin where two bifurcations meet, and the most points that are tried.
    max_multiplier : float
        Up to which orbits are followed along lines: none became stable again.
    max_period : float
        Periods of the window's middle in one, beyond which an orbit is taken to approach a saddle.
    real : float
        Imaginary part of multipliers that have met.
    same, same_orbit : float
        Distance from a curve, and between the states of two orbits, below which they are one.
    parting : float
        How far from a period doubling the doubled orbits start, in the size of the states.
    beside : float
        Step along a curve from where it begins, after which its other multipliers tell the way.
    exact : float
        Error bound of a bifurcation on a line before it is solved for again.
    astray : float
        Newton's method has led to another bifurcation than the one it started at.
    shares : tuple of float
        Where on a line orbits are looked for.
    near : float
        How far, in the sizes of the states too, an engine's curve may have shifted.
    """

    ds: float = 0.04
    ds_min: float = 1e-4
    ds_max: float = 0.4
    growth: tuple[float, float] = (0.5, 2.0)
    turn: float = 0.5
    max_turn: float = 0.8
    aim: float = 0.1
    max_offset: float = 0.2
    max_offset_line: tuple[float, float] = (0.7, 0.1)
    max_points: int = 400
    max_iterations: int = 8
    tolerance: float = 1e-8
    noise: float = 1e-7
    integration: float = 3e-11
    steps_min: int = 16
    steps_max: int = 2048
    rounding: float = 7e-16
    step_rounding: float = 5e-16
    edge: float = 1e-9
    symmetric: float = 1e-2
    near_meeting: float = 0.05
    careful: tuple[float, float] = (0.01, 0.08)
    max_change: float = 0.5
    landed: float = 1e-4
    max_landings: int = 8
    max_multiplier: float = 5.0
    max_period: float = 10.0
    real: float = 1e-9
    same: float = 1e-3
    same_orbit: float = 1e-2
    parting: float = 0.03
    beside: float = 5e-3
    exact: float = 1e-9
    astray: float = 0.3
    shares: tuple[float, ...] = (0.5, 0.15, 0.85)
    near: float = 0.2


OPTIONS = ContinuationOptions()


@dataclass(frozen=True)
class Node:
    """A point of a curve.

    Attributes
    ----------
    z : array (m + 1,)
    tangent : array (m + 1,)
        Of length 1, in the direction in which the curve is followed.
    jacobian : array (m, m + 1)
        There, or of the last iteration of Newton's method.
    """

    z: Array
    tangent: Array
    jacobian: Array


def correct(
    equations: CurveEquations,
    z: Array,
    row: Array,
    value: float,
    iterations: int = OPTIONS.max_iterations,
    along: Array | None = None,
) -> Node | None:
    """Return the point of a curve on a plane ``row . z = value``; None where there is none near.

    Parameters
    ----------
    equations : CurveEquations
    z : array (m + 1,)
        Where to start.
    row : array (m + 1,)
    value : float
    iterations : int
    along : array (m + 1,), optional
        Vector as which the tangent points; by default ``row``.
    """
    before, step, last, matrix = np.inf, z, z, np.zeros((len(z) - 1, len(z)))
    for number in range(iterations if equations.exact else 4 * iterations):
        with np.errstate(all="ignore"):
            if number and equations.residual is not None:
                residual = equations.residual(z)
                missing = residual - last - matrix @ step
                matrix = matrix + np.outer(missing, step) / (step @ step)
            else:
                residual, matrix = equations.linearise(z)
        if not (np.all(np.isfinite(residual)) and np.all(np.isfinite(matrix))):
            return None
        try:
            step = -np.linalg.solve(np.vstack([matrix, row]), [*residual, row @ z - value])
        except np.linalg.LinAlgError:
            return None
        z, last, size = z + step, residual, float(np.max(np.abs(step)))
        enough = size < OPTIONS.tolerance * (1.0 if equations.exact else 0.1)
        if enough or size > 2 * before or size > 1.0:
            break
        before = size
    if not enough and before >= OPTIONS.noise:
        return None
    jacobian = matrix if equations.slopes is None else equations.slopes(z)
    if not np.all(np.isfinite(jacobian)):
        return None
    return Node(z, tangent_of(jacobian, row if along is None else along), jacobian)


def tangent_of(jacobian: Array, along: Array) -> Array:
    """Return the unit tangent (m + 1,) of a curve that points as another vector does."""
    _, _, rows = np.linalg.svd(jacobian)
    tangent = rows[-1]
    return np.asarray(tangent * np.sign(tangent @ along) if tangent @ along else tangent)


def step_on(
    equations: CurveEquations,
    here: Any,
    ds: float,
    before: Any = None,
    options: ContinuationOptions = OPTIONS,
) -> tuple[Node, float] | None:
    """Return the next point of a curve, and the length of the step after it.

    None where no further point is found by the shortest step. ``here`` is a point with ``z`` and
    ``tangent``, ``before`` the one before it, None for the first.
    """
    while ds >= options.ds_min:
        guess = here.z + ds * here.tangent
        if before is not None:
            guess = between(before, here, 1 + ds / float(np.linalg.norm(here.z - before.z)))
        ahead = correct(equations, guess, here.tangent, float(here.tangent @ guess))
        if ahead is not None and np.max(np.abs(ahead.z - guess)) < ds:
            turn = float(np.arccos(np.clip(ahead.tangent @ here.tangent, -1, 1)))
            off = float(np.linalg.norm(ahead.z - guess)) / ds
            by_turn, beside = options.max_offset_line
            most, longer = by_turn * turn + beside, options.turn / max(turn, 1e-12)
            if before is not None:
                most = min(most, options.max_offset)
                longer = min(longer, float(np.cbrt(options.aim / max(off, 1e-12))))
            if turn < options.max_turn and off < most:
                longer = float(np.clip(longer, *options.growth))
                return ahead, min(max(longer * ds, options.ds_min), options.ds_max)
        ds /= 2
    return None


def between(a: Any, b: Any, share: float) -> Array:
    """Return the value of the cubic through two neighbours (with ``z`` and ``tangent``)."""
    return cubic(np.stack([a.z, b.z]), np.stack([a.tangent, b.tangent]), np.array([share]))[0]


def cubic(points: Array, tangents: Array, shares: Array) -> Array:
    """Return Hermite's cubics through points and tangents (k, m), from each to the next.

    Of each the values (j (k - 1), m) at these shares (j,) of the way, one cubic after the other;
    the tangents, of length 1, are taken as long as the chord.
    """
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)[:, None, None]
    s, a, b = shares[:, None], points[:-1, None], points[1:, None]
    bend = s * (1 - s) ** 2 * tangents[:-1, None] - s**2 * (1 - s) * tangents[1:, None]
    values = (1 + 2 * s) * (1 - s) ** 2 * a + s**2 * (3 - 2 * s) * b + chords * bend
    return np.asarray(values.reshape(-1, points.shape[1]))
