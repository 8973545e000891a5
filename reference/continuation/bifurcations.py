"""Bifurcations of periodic orbits, as equations whose solutions over two parameters are curves.

The unknowns of all of them are a state, the period where nothing drives the scene, and two
parameters. To "the orbit closes" comes one more equation, of its monodromy matrix (Kuznetsov 2004,
chapters 5 and 10):

* fold: the matrix that closes the orbit is singular;
* period doubling: -1 is a multiplier, det(Phi + I) = 0;
* Neimark-Sacker: the product of two multipliers is 1, det(Phi (.) Phi - I) = 0 with the
  bialternate product;
* orbits along a line of the window: one parameter has a value.

Determinants stay regular where two multipliers meet. Where the equations of motion are those of
half a period before after a change of signs, an orbit that repeats itself so is closed over half a
period; it loses this symmetry (a pitchfork) by a period doubling of that map.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from ..errors import ParameterError
from ..newton import Rows
from ..orbits import PeriodMap, period_advance, section_row
from ..scene import Array, EquationsOfMotion, coefficients_at
from ..solve.rk8 import rk8_steps
from .curve import CurveEquations, cubic

STEP = 1e-5
"""Step of the central differences in all unknowns that give Newton's method its Jacobian."""

FOLD, DOUBLING, NEIMARK_SACKER, LINE = "fold", "period_doubling", "neimark_sacker", "orbits"
KINDS = (FOLD, DOUBLING, NEIMARK_SACKER)

PeriodFlow = Callable[[Any, Any, Any, int], Any]
"""Function of parameters (k,), states (2 n, k), spans (k,) [s] and the number of half periods (of a
symmetric scene, or else periods) in a span that returns the states these spans later."""


@dataclass(frozen=True)
class Family:
    """Periodic orbits of a scene over a window of two parameters.

    Attributes
    ----------
    scene : EquationsOfMotion
    parameters : callable ``(place (2, k) in the window, 0 to 1 each) -> Parameters``
    flow : PeriodFlow
    scale : array (2 n,)
        Size of each state.
    period : float
        Unit of the period, where it is unknown [s].
    parts : int
        Half periods (of a symmetric scene, or else periods) after which the orbits close.
    order : int or None
        Of the differences by which the flow is linearised; None takes complex steps.
    step : float or None
    """

    scene: EquationsOfMotion
    parameters: Callable[[Array], Any]
    flow: PeriodFlow
    scale: Array
    period: float
    parts: int = 1
    order: int | None = None
    step: float | None = None

    @property
    def size(self) -> int:
        """Number of states."""
        return len(self.scale)

    def period_map(self, z: Array) -> PeriodMap:
        """Return the map that the orbits of unknowns (2 n + 2, k) are fixed points of."""
        n, scene = self.size, self.scene
        p, row = self.parameters(z[n:]), section_row(scene)
        signs = half_period_signs(scene)
        halves = 1 if signs is None else 2
        states = z[:n] * self.scale[:, None]
        advance = period_advance(scene) * self.parts / halves
        if row is None:
            whole = np.array(np.broadcast_to(scene.period(p), z.shape[1:]), dtype=float)
        else:
            whole, states[row] = self.period * z[row], 0.0
        odd = signs is not None and self.parts % 2 == 1
        mirror = 1.0 if signs is None else signs[:, None]
        c = scene.coefficients(p)

        def flow(rows: Rows, starts: Any, spans: Any) -> Any:
            ends = self.flow((p, c, rows), starts, spans, self.parts)
            return mirror * (ends - advance) if odd else ends

        return PeriodMap(
            flow=flow,
            states=states,
            periods=whole * self.parts / halves,
            scale=np.repeat(self.scale[:, None], z.shape[1], axis=1),
            advance=0 * advance if odd else advance,
            section=row,
            order=self.order,
            step=self.step,
        )

    def evaluate(self, z: Array) -> tuple[Array, Array, Array]:
        """Return the residual of the closed orbit, and matrices, at unknowns (2 n + 2, k).

        Returns
        -------
        left : array (2 n, k)
        closing : array (k, 2 n, 2 n)
            Slopes of that by the unknowns of the orbit.
        monodromy : array (k, 2 n, 2 n)
        """
        at, n = self.period_map(z), self.size
        left, slopes = at.linearise(np.arange(z.shape[1]), np.zeros((n, z.shape[1])))
        closing = slopes[..., :n].copy()
        if at.section is not None:
            closing[..., at.section] = slopes[..., n] / z[at.section][:, None]
        return left, closing, slopes[..., :n] + np.eye(n)


def half_period_signs(scene: EquationsOfMotion) -> Array | None:
    """Return the signs (2 n,) that states take half a period later; None without this symmetry."""
    if not scene.orbit.mirror:
        return None
    signs = [-1.0 if name in scene.orbit.mirror else 1.0 for name in scene.coordinates]
    return np.array([*signs, *signs])


def reference_flow(scene: EquationsOfMotion, steps: int) -> PeriodFlow:
    """Return the flow of the equations of motion, by so many steps in a (half) period."""

    def flow(at: Any, states: Any, spans: Any, parts: int) -> Any:
        _, c, rows = at
        return rk8_steps(
            scene.derivative(coefficients_at(c, rows)), states, 0.0, spans, parts * steps
        )

    return flow


def bialternate(matrix: Array) -> Array:
    """Return bialternate products (k, m, m) of matrices (k, n, n) with themselves.

    Their eigenvalues are the products of two eigenvalues of the matrix.
    """
    pairs = np.array(list(combinations(range(matrix.shape[-1]), 2)))
    i, j = pairs.T
    a = matrix[..., i[:, None], i] * matrix[..., j[:, None], j]
    return np.asarray(a - matrix[..., i[:, None], j] * matrix[..., j[:, None], i])


def bifurcation_function(kind: str, closing: Array, monodromy: Array) -> Array:
    """Return numbers (k,) that are 0, and change their sign, at a bifurcation of a kind.

    NaN where a run has failed.
    """
    matrix = closing
    if kind == DOUBLING:
        matrix = monodromy + np.eye(monodromy.shape[-1])
    elif kind != FOLD:
        products = bialternate(monodromy)
        matrix = products - np.eye(products.shape[-1])
    with np.errstate(invalid="ignore"):
        return np.linalg.det(matrix)


def stable_side(kind: str, jacobian: Array) -> Array:
    """Return the unit vector (2,) in the window to the side on which a curve's orbit is stable.

    NaN of kinds that have none. On that side the function of a period doubling, and of a
    Neimark-Sacker bifurcation with an even number of products, is positive, as it is of a matrix 0;
    of a fold it is the side on which there are orbits, two of them (Kuznetsov 2004, chapter 3).

    Parameters
    ----------
    kind : str
    jacobian : array (2 n + 1, 2 n + 2)
        Of the equations of the curve.
    """
    n = len(jacobian) - 1
    closing, by_place, last = jacobian[:n, :n], jacobian[:n, n:], jacobian[n]
    if kind == FOLD:
        left, values, right = np.linalg.svd(closing)
        minor = np.prod(values[:-1]) * np.linalg.det(left) * np.linalg.det(right)
        curvature = last[:n] @ right[-1] / minor
        way = -np.sign(curvature) * (left[:, -1] @ by_place)
    elif kind in KINDS:
        way = last[n:] - last[:n] @ np.linalg.lstsq(closing, by_place)[0]
        if kind == NEIMARK_SACKER and n * (n - 1) // 2 % 2:
            way = -way
    else:
        return np.full(2, np.nan)
    with np.errstate(all="ignore"):
        return np.asarray(way / np.linalg.norm(way))


@dataclass(frozen=True)
class OrbitCurve:
    """A curve of periodic orbits over the window: of a bifurcation, or along a line.

    Attributes
    ----------
    family : Family
    kind : str
    axis : int
        Of a line: the parameter that stays.
    value : float
        Its place in the window.
    by : Family or None
        Whose slopes Newton's method takes; an engine's are dear, and those of the reference near.
    """

    family: Family
    kind: str
    axis: int = 0
    value: float = 0.0
    by: Family | None = None

    @property
    def equations(self) -> CurveEquations:
        """The equations of the curve."""
        if self.by is None:
            return CurveEquations(self.linearise)
        return CurveEquations(self.linearise, self.residual, self.slopes)

    def values(self, family: Family, z: Array) -> tuple[Array, Array, Array]:
        """Return residuals (2 n + 1, k), matrices that close and monodromy matrices."""
        left, closing, monodromy = family.evaluate(z)
        if self.kind == LINE:
            last = z[family.size + self.axis] - self.value
        else:
            last = bifurcation_function(self.kind, closing, monodromy)
        return np.vstack([left, last]), closing, monodromy

    def residual(self, z: Array) -> Array:
        """Return the residual of the equations (2 n + 1,) at unknowns (2 n + 2,)."""
        try:
            return self.values(self.family, z[:, None])[0][:, 0]
        except ParameterError:  # Newton's method has left what parameters may be
            return np.full(len(z) - 1, np.nan)

    def slopes(self, z: Array) -> Array:
        """Return the slopes (2 n + 1, 2 n + 2) of what Newton's method takes them of."""
        return replace(self, family=self.by or self.family, by=None).linearise(z)[1]

    def linearise(self, z: Array) -> tuple[Array, Array]:
        """Return residual (2 n + 1,) and Jacobian of the equations at unknowns (2 n + 2,)."""
        if self.by is not None:
            return self.residual(z), self.slopes(z)
        n, size = self.family.size, len(z)
        moved = np.arange(size) if self.kind != LINE else np.array([n + 1 - self.axis])
        shifts = STEP * np.eye(size)[:, moved]
        lanes = z[:, None] + np.hstack([np.zeros((size, 1)), shifts, -shifts])
        try:
            values, closing, _ = self.values(self.family, lanes)
        except ParameterError:
            return np.full(size - 1, np.nan), np.full((size - 1, size), np.nan)
        jacobian = np.zeros((size - 1, size))
        count = len(moved)
        jacobian[:, moved] = (values[:, 1 : 1 + count] - values[:, 1 + count :]) / (2 * STEP)
        jacobian[:n, :n] = closing[0]
        if self.kind == LINE:
            jacobian[-1, n + self.axis] = 1.0
        return values[:, 0], jacobian


BRANCH_POINT, HOMOCLINIC = "branch_point", "homoclinic"
"""Kinds of curves of states of rest: see `rest`; and of where a periodic orbit ends on a saddle."""


class ParameterWindow(NamedTuple):
    """Two parameters and their ranges."""

    names: tuple[str, str]
    low: Array
    high: Array

    def parameters(self, base: Any) -> Callable[[Array], Any]:
        """Return the map from places (2, k) in the window, 0 to 1 each, to parameters."""
        size = self.high - self.low

        def at(place: Array) -> Any:
            values = self.low[:, None] + size[:, None] * place
            return base.replace(**dict(zip(self.names, values, strict=True)))

        return at


@dataclass(frozen=True)
class CurvePoint:
    """A point of a curve.

    Attributes
    ----------
    z, tangent : array (2 n + 2,)
        Unknowns in their sizes, the place in the window last.
    multipliers : complex array (2 n,)
        Of the map that the orbit is closed by, descending in modulus.
    critical : complex
        That, or one of those, which the bifurcation is of; NaN on a line.
    others : complex array
        The others, that of a shift in time left out.
    bound : array (2,)
        On the error of the place, on the plane across the tangent.
    side : array (2,)
        See `stable_side`.
    """

    z: Array
    tangent: Array
    multipliers: Any
    critical: complex
    others: Any
    bound: Array
    side: Array = field(default_factory=lambda: np.full(2, np.nan))

    @property
    def unstable(self) -> int:
        """How many others lie outside the unit circle."""
        return int(np.sum(np.abs(self.others) > 1))

    @property
    def place(self) -> Array:
        """Place (2,) in the window."""
        return self.z[-2:]


@dataclass
class BifurcationCurve:
    """A curve of orbits: of a bifurcation, or along a line.

    Attributes
    ----------
    kind : str
    parts : int
        See `Family`.
    points : list of CurvePoint
    ends : (str, str)
        Why it begins and ends where it does.
    doubled : bool
        Whether bifurcations were found on orbits of twice the length that part from it.
    shifts : list of array (2,)
        Of an engine: by how far each point lies off the reference's curve.
    """

    kind: str
    parts: int
    points: list[CurvePoint] = field(default_factory=list)
    ends: tuple[str, str] = ("", "")
    doubled: bool = False
    shifts: list[Array] = field(default_factory=list)

    def distance(self, place: Array) -> float:
        """Return the distance of a place (2,) of the window from the curve."""
        path = smooth_path(self.points)
        start, way = path[:-1], np.diff(path, axis=0)
        share = np.sum((place - start) * way, axis=1) / np.maximum(np.sum(way**2, axis=1), 1e-300)
        nearest = start + np.clip(share, 0, 1)[:, None] * way
        return float(np.min(np.linalg.norm(nearest - place, axis=1), initial=np.inf))


def smooth_path(points: Any, count: int = 8) -> Array:
    """Return places (m, 2) along points, cubic with so many pieces between two of them."""
    if not points:
        return np.empty((0, 2))
    z, tangents = (np.array([getattr(p, name) for p in points]) for name in ("z", "tangent"))
    return np.vstack([cubic(z, tangents, np.arange(count) / count), z[-1:]])[:, -2:]


def split(kind: str, multipliers: Any, has_shift: bool) -> tuple[complex, Any]:
    """Return the critical multiplier and the others, that of a shift in time left out."""
    others = np.array(multipliers)
    if has_shift:
        others = np.delete(others, np.argmin(np.abs(others - 1)))
    if kind == LINE:
        return complex(np.nan), others
    if kind == HOMOCLINIC:  # that of the direction on which it leaves the saddle
        return complex(others[0]), others[1:]
    if kind == NEIMARK_SACKER:
        off = np.abs(np.outer(others, others) - 1)  # the pair whose product is nearest to 1
        off[np.tril_indices(len(off))] = np.inf
        pair = np.unravel_index(np.argmin(off), off.shape)
        return complex(others[pair[0]]), np.delete(others, pair)
    i = int(np.argmin(np.abs(others - (-1 if kind == DOUBLING else 1))))
    return complex(others[i]), np.delete(others, i)


def crossings(others: Any) -> dict[str, float]:
    """Return numbers, by kind of bifurcation, whose signs change where multipliers cross."""
    i, j = np.triu_indices(len(others), 1)
    products = (others - 1, others + 1, others[i] * others[j] - 1)
    return {
        kind: float(np.real(np.prod(value))) for kind, value in zip(KINDS, products, strict=True)
    }


def margin(kind: str, point: CurvePoint) -> float:
    """Return the distance of a point of a curve from another bifurcation.

    It is positive while all others are inside the unit circle and a pair on it is complex.
    """
    margins = 1 - np.abs(point.others)
    if kind == NEIMARK_SACKER:  # 2 cos of the pair's angle, or the sum of two that are real
        margins = np.append(margins, 2 - abs((point.critical + 1 / point.critical).real))
    return float(np.min(margins, initial=np.inf))


def kind_beyond(kind: str, point: CurvePoint) -> str:
    """Return the kind of the curve that begins where one of another kind ends.

    Two multipliers that meet at 1 or -1 leave it as a pair.
    """
    pair = abs((point.critical + 1 / point.critical).real)
    meets = kind == NEIMARK_SACKER and 2 - pair <= 1 - np.max(np.abs(point.others), initial=0)
    leading = point.critical if meets else point.others[np.argmax(np.abs(point.others))]
    if not meets and leading.imag:
        return NEIMARK_SACKER
    new = FOLD if leading.real > 0 else DOUBLING
    return NEIMARK_SACKER if kind in (new, BRANCH_POINT) else new
