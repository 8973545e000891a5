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

CONVERGED = 1e-8
"""Newton correction after which no other is made: it leaves its square."""

NOISE = 1e-7
"""Largest correction of a solution whose corrections stop shrinking: flows of engines are noisy."""


MOST_TURN = 1.6
"""Of the angle that is aimed at: steps that turn more have led to other curves near by."""


OFF = 0.7, 0.1
"""Distance of a point from where the tangent led, in the step's length, by the turn and beside: of
an arc it is half the turn, and more where another curve was met."""

OFF_CUBIC = 0.2
"""Most of that from where a cubic led."""

AIM = 0.1
"""Distance from where a cubic led that is aimed at, in the step's length. It grows as the third
power of that."""

LONGER = 0.5, 2.0
"""Least and largest length of a step, in that of the step before."""


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


class Control(NamedTuple):
    """Steps along a curve.

    Attributes
    ----------
    first, shortest, longest : float
        Their lengths, in the unit of the unknowns.
    turn : float
        Angle between the tangents of neighbours that is aimed at [rad]; `MOST_TURN` times that is
        refused.
    iterations : int
        Newton iterations of a point at most.
    points : int
        Points of a curve in one direction at most.
    """

    first: float = 0.02
    shortest: float = 1e-4
    longest: float = 0.1
    turn: float = 0.2
    iterations: int = 8
    points: int = 400


@dataclass(frozen=True)
class Node:
    """A point of a curve.

    Attributes
    ----------
    z : array (m + 1,)
    tangent : array (m + 1,)
        Of length 1, in the direction in which the curve is followed.
    jacobian : array (m, m + 1)
    """

    z: Array
    tangent: Array
    jacobian: Array


@dataclass(frozen=True)
class CurveSolution:
    """Where Newton's method has ended; of ``jacobian`` that of the last iteration, or there."""

    z: Array
    jacobian: Array


def correct(
    equations: CurveEquations, z: Array, row: Array, value: float, iterations: int = 8
) -> CurveSolution | None:
    """Return the point of a curve on a plane ``row . z = value``; None where there is none near.

    Parameters
    ----------
    equations : CurveEquations
    z : array (m + 1,)
        Where to start.
    row : array (m + 1,)
    value : float
    iterations : int
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
        enough = size < CONVERGED * (1.0 if equations.exact else 0.1)
        if enough or size > 2 * before or size > 1.0:
            break
        before = size
    if not enough and before >= NOISE:
        return None
    return CurveSolution(z, matrix if equations.slopes is None else equations.slopes(z))


def tangent_of(jacobian: Array, along: Array) -> Array:
    """Return the unit tangent (m + 1,) of a curve that points as another vector does."""
    _, _, rows = np.linalg.svd(jacobian)
    tangent = rows[-1]
    return np.asarray(tangent * np.sign(tangent @ along) if tangent @ along else tangent)


def node(solution: CurveSolution, along: Array) -> Node:
    """Return a point of a curve with its tangent."""
    return Node(solution.z, tangent_of(solution.jacobian, along), solution.jacobian)


def step_on(
    equations: CurveEquations, here: Node, length: float, control: Control, before: Any = None
) -> tuple[Node, float] | None:
    """Return the next point of a curve, and the length of the step after it.

    None where no further point is found by the shortest step. ``before`` is the point before this
    one (with ``z`` and ``tangent``), None for the first.
    """
    is_cubic = before is not None
    while length >= control.shortest:
        guess = here.z + length * here.tangent
        if is_cubic:
            apart = float(np.linalg.norm(here.z - before.z))
            guess = between(before, here, 1 + length / apart)
        ahead_by = float(here.tangent @ guess)
        solution = correct(equations, guess, here.tangent, ahead_by, control.iterations)
        if solution is not None and np.max(np.abs(solution.z - guess)) < length:
            ahead = node(solution, here.tangent)
            turn = float(np.arccos(np.clip(ahead.tangent @ here.tangent, -1, 1)))
            off = float(np.linalg.norm(ahead.z - guess)) / length
            most = OFF[0] * turn + OFF[1]
            if is_cubic:
                most = min(most, OFF_CUBIC)
            if turn < MOST_TURN * control.turn and off < most:
                longer = control.turn / max(turn, 1e-12)
                if is_cubic:
                    longer = min(longer, float(np.cbrt(AIM / max(off, 1e-12))))
                longer = float(np.clip(longer, *LONGER))
                return ahead, min(max(longer * length, control.shortest), control.longest)
        length /= 2
    return None


def between(a: Any, b: Any, share: float) -> Array:
    """Return what a cubic through two neighbours (with ``z`` and ``tangent``) is between them."""
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
