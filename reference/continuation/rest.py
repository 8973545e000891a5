"""States of rest as curves over two parameters, and where rotations end on them.

A state of rest is a fixed point of the flow over any time. With the flow of the linearised
equations over a short one in place of a monodromy matrix, its bifurcations are those of orbits:
where an eigenvalue is 0 a multiplier is 1 (a fold), and where two have the sum 0 two multipliers
have the product 1 (a Hopf point). One more condition is of states of rest alone:

* branch point: an eigenvalue is 0 on a state that goes on, so that the fold's equations are
  singular. What they have along the left null vector, which vanishes on such a state, gives way to
  the component along the right one (Seydel 2010, chapter 5).

A rotation that comes ever nearer to a saddle ends there: the parameter at which it does is a root
that the scene knows how to find, and along the other axis of a window one root beside the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import groupby, pairwise, product
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

from ..cost import keep_budget
from ..differences import by_complex_step
from ..errors import NoOrbitError
from ..orbits import descending, state_scale
from ..scene import Array, EquationsOfMotion, coefficients_at
from .bifurcations import (
    BRANCH_POINT,
    FOLD,
    HOMOCLINIC,
    LINE,
    BifurcationCurve,
    CurvePoint,
    Family,
    OrbitCurve,
    ParameterWindow,
    bifurcation_function,
    reference_flow,
    split,
    stable_side,
)
from .curve import Node
from .tracing import Tracer, is_inside, numbers


class RestOptions(NamedTuple):
    """Search for states of rest, and their distinction.

    Attributes
    ----------
    share : float
        Of the time of the fastest mode amid the window, over which the flow is linearised.
    rounding : float
        What rounding is taken to change parameters and states by, relative.
    places : int
        Of the coordinates that turn, at which states of rest are looked for.
    max_iterations : int
        Of Newton's method to them.
    max_step, tolerance : float
        Its longest correction in the states' sizes, and the last.
    isolated : float
        Least singular value of the Jacobian at an isolated state of rest.
    continues : float
        Largest residual of a state at a branch point along the left null vector.
    least_points : int
        Places along an axis at which the end of rotations is solved for.
    least_stay : int
        Fewest points of a curve of it between two edges of the window.
    """

    share: float = 0.5
    rounding: float = 3e-15
    places: int = 16
    max_iterations: int = 40
    max_step: float = 0.1
    tolerance: float = 1e-11
    isolated: float = 1e-9
    continues: float = 1e-8
    least_points: int = 33
    least_stay: int = 5


OPTIONS = RestOptions()


def is_undriven(scene: EquationsOfMotion, parameters: Any, count: int) -> bool:
    """Return True if no force on a scene depends on time, at a number of points."""
    if scene.drive is None:
        return True
    period = np.max(scene.period(parameters))
    state = np.full((2 * len(scene.coordinates), count), 0.3)
    rates = scene.right_hand_side(parameters)
    values = [rates(share * period, state) for share in (0.0, 0.1, 0.3, 0.7)]
    return all(np.array_equal(value, values[0]) for value in values)


class RestFamily(Family):
    """States of rest of a scene over a window; ``period`` is the time of the linearised flow."""

    def evaluate(self, z: Array) -> tuple[Array, Array, Array]:
        """Return the rates (2 n, k) of states, their Jacobian, and the linearised flow."""
        n, k = self.size, z.shape[1]
        c, unit = self.scene.coefficients(self.parameters(z[n:])), self.scale[:, None, None]

        def rates(x: Any) -> Any:
            rows = np.tile(np.arange(k), x.shape[1])
            function = self.scene.derivative(coefficients_at(c, rows))
            moving = function(0.0, (x * unit).reshape(n, -1))
            return self.period * moving.reshape(x.shape) / unit

        left, slopes = by_complex_step(rates, z[:n])
        closing = np.moveaxis(slopes, -1, 0)
        finite = np.all(np.isfinite(closing), axis=(1, 2))[:, None, None]
        return left, closing, np.where(finite, expm(np.where(finite, closing, 0.0)), np.nan)


@dataclass(frozen=True)
class RestCurve(OrbitCurve):
    """A curve of states of rest: of a bifurcation, or along a line.

    Attributes
    ----------
    about : array (2 n + 2,) or None
        A state near a branch point; None of other kinds.
    """

    about: Array | None = None

    @cached_property
    def null_vectors(self) -> tuple[Array, Array]:
        """Left and right null vectors (2 n,) near a branch point."""
        assert self.about is not None
        _, closing, _ = self.family.evaluate(self.about[:, None])
        left, _, right = np.linalg.svd(closing[0])
        return left[:, -1], right[-1]

    def unbalanced(self, z: Array) -> float:
        """Return the residual of a state at a branch point along the left null vector."""
        left, _, _ = self.family.evaluate(z[:, None])
        return float(self.null_vectors[0] @ left[:, 0])

    def values(self, family: Family, z: Array) -> tuple[Array, Array, Array]:
        """Return residuals (2 n + 1, k), slopes of the first 2 n, and linearised flows."""
        if self.about is None:
            return super().values(family, z)
        left, closing, flow = family.evaluate(z)
        w, v = self.null_vectors
        shift = v @ (z[: family.size] - self.about[: family.size, None])
        left = left + np.outer(w, shift - w @ left)
        last = bifurcation_function(FOLD, closing, flow)
        closing = closing + w[:, None] * (v - w @ closing)[:, None, :]
        return np.vstack([left, last]), closing, flow


@dataclass
class RestTracer(Tracer):
    """Follows curves of the states of rest of a scene.

    Attributes
    ----------
    window : ParameterWindow
    """

    window: ParameterWindow = field(kw_only=True)

    @cached_property
    def units(self) -> tuple[Array, float]:
        """Sizes (2 n,) of the states, and the time over which the flow is linearised [s]."""
        middle = np.array([0.5, 0.5])
        time = float(np.ravel(self.scene.period(self.parameters(middle[:, None])))[0])
        family = self.over(time / (2 * np.pi))
        states = self.solved(family, middle)
        if not states:
            return family.scale, family.period
        _, closing, _ = family.evaluate(np.array(states).T)
        fastest = float(np.max(np.abs(np.linalg.eigvals(closing))))
        family = self.over(OPTIONS.share * family.period / max(fastest, 1e-6))
        return family.scale, family.period

    @property
    def turning(self) -> list[int]:
        """Rows of the coordinates that turn."""
        names = enumerate(self.scene.coordinates)
        return [row for row, name in names if name in self.scene.rotations_per_period]

    def over(self, time: float) -> RestFamily:
        """Return the states of rest with flows over a time [s]."""
        none = np.zeros((2 * len(self.scene.coordinates), 1))
        scale = state_scale(self.scene, none, 1 / time)[:, 0]
        return RestFamily(self.scene, self.parameters, reference_flow(self.scene, 1), scale, time)

    def family(self, parts: int, steps: int = 0) -> Family:
        """Return the states of rest."""
        return self.over(self.units[1])

    def curve(self, kind: str, parts: int, axis: int = 0, value: float = 0.0) -> OrbitCurve:
        """Return a kind of curve, see `RestCurve`."""
        return RestCurve(self.family(parts), kind, axis, value)

    def curves_at(self, kind: str, parts: int, z: Array) -> list[OrbitCurve]:
        """Return the curves that a bifurcation near unknowns (2 n + 2,) may lie on.

        The last is that of its kind; a fold may be a branch point.
        """
        here = RestCurve(self.family(parts), kind)
        branch = replace(here, kind=BRANCH_POINT, about=z)
        special: dict[str, list[OrbitCurve]] = {FOLD: [branch, here], BRANCH_POINT: [branch]}
        return special.get(kind, [here])

    def starts(self, place: Array) -> list[Array]:
        """Return states of rest (2 n + 2,) at a place of the window."""
        return self.solved(self.over(self.units[1]), place)

    def orbits_at(self, place: Array) -> list[tuple[int, Array]]:
        """Return the states of rest at a place: none is looked for with other means."""
        return [(1, state) for state in self.starts(place)]

    def solved(self, family: RestFamily, place: Array) -> list[Array]:
        """Return states of rest (2 n + 2,) of a family, each once."""
        n = family.size
        guesses = np.array(self.rough_states(place)) / family.scale
        z = np.vstack([guesses.T, np.repeat(place[:, None], len(guesses), axis=1)])
        size = np.full(len(guesses), np.inf)
        for _ in range(OPTIONS.max_iterations):
            keep_budget(1.0)
            left, closing, _ = family.evaluate(z)
            bad = ~np.all(np.isfinite(closing), axis=(1, 2))
            closing[bad], left[:, bad] = np.eye(n), 0.0
            step = -(np.linalg.pinv(closing) @ left.T[..., None])[..., 0].T
            size = np.where(bad, np.inf, np.max(np.abs(step), axis=0))
            z[:n] += step * np.minimum(1.0, OPTIONS.max_step / np.maximum(size, 1e-300))
            if np.all((size < OPTIONS.tolerance) | bad):
                break
        least = np.linalg.svd(family.evaluate(z)[1], compute_uv=False)[:, -1]
        z[self.turning] = (z[self.turning] + 0.05) % 1 - 0.05  # their size is a turn
        states: list[Array] = []
        for state in z.T[(size < OPTIONS.tolerance) & (least > OPTIONS.isolated)]:
            if not any(np.max(np.abs(state - one)) < 1e-6 for one in states):
                states.append(state)
        return states

    def rough_states(self, place: Array) -> list[Array]:
        """Return where states of rest (2 n,) are looked for: those with a name, and turned ones."""
        p = numbers(self.parameters(place[:, None]))
        states = []
        for parameters in (p, self.scene.unforced(p)):
            for where in self.scene.equilibria.values():
                try:
                    states.append(self.scene.state(where(parameters)))
                except NoOrbitError:
                    continue
        names = [self.scene.coordinates[row] for row in self.turning]
        count = round(OPTIONS.places ** (1 / max(len(names), 1)))
        angles = 2 * np.pi * np.arange(count) / count
        for at in product(angles, repeat=len(names)):
            states.append(self.scene.state(dict(zip(names, at, strict=True))))
        return [np.append(s[: len(s) // 2], 0 * s[: len(s) // 2]) for s in states]

    def rate(self, curve: OrbitCurve, here: Node) -> tuple[CurvePoint, float]:
        """Return a point with its multipliers and error bound; no steps change it."""
        self.solutions += 1
        n = curve.family.size
        left, _, flow = curve.values(curve.family, here.z[:, None])
        inverse = np.linalg.inv(np.vstack([here.jacobian, here.tangent]))[:, :-1]
        low, size = self.window.low, self.window.high - self.window.low
        values = np.append(here.z[:n], low / size + here.z[n:])
        rounding = OPTIONS.rounding * (np.abs(here.jacobian) @ np.abs(values))
        bound = np.abs(inverse) @ (2 * np.abs(left[:, 0]) + rounding)
        multipliers = descending(np.linalg.eigvals(flow[0]))
        critical, others = split(curve.kind, multipliers, False)
        side = stable_side(curve.kind, here.jacobian)
        point = CurvePoint(here.z, here.tangent, multipliers, critical, others, bound[n:], side)
        return point, 0.0

    def adapt(
        self, curve: OrbitCurve, point: CurvePoint, off: float, row: Array | None = None
    ) -> tuple[OrbitCurve, CurvePoint | None]:
        """Return both as they are: states of rest take no steps."""
        return curve, point

    def is_proper(self, curve: OrbitCurve, point: CurvePoint) -> bool:
        """Return True if a solution of a curve's equations is a bifurcation of its kind."""
        if isinstance(curve, RestCurve) and curve.about is not None:
            return abs(curve.unbalanced(point.z)) < OPTIONS.continues
        return super().is_proper(curve, point)

    def end(
        self, curve: OrbitCurve, first: CurvePoint, before: CurvePoint, here: CurvePoint
    ) -> str:
        """Return the reason for which a curve ends at a point, empty if it goes on."""
        if curve.kind == LINE:  # whole turns on, the states are the same
            return "closed" if np.any(np.abs(here.z - first.z)[self.turning] > 1) else ""
        return super().end(curve, first, before, here)

    # Where rotations end ----------------------------------------------------------------------

    def least_curves(self, count: int = OPTIONS.least_points) -> list[BifurcationCurve]:
        """Return the curves on which rotations end on a saddle.

        One axis of the window is the parameter that the scene solves for, at so many places of the
        other and where it crosses the window's edges. Each curve is a stay in the window.
        """
        limit, names = self.scene.orbit.limit, self.window.names
        if limit is None or limit[0] not in names:
            return []
        axis = names.index(limit[0])
        shares = np.linspace(0, 1, count).tolist()
        known = {share: self.least_at(axis, share) for share in shares}
        edges = [
            self.least_on_edge(axis, level, one, other)
            for one, other in pairwise(shares)
            if known[one] and known[other]
            for level in (0.0, 1.0)
            if (known[one][0][-2 + axis] - level) * (known[other][0][-2 + axis] - level) < 0
        ]
        known |= {share: self.least_at(axis, share) for share in edges}
        curves: list[BifurcationCurve] = []
        every = sorted(known)

        def stays(share: float) -> bool:
            return share in edges or (known[share] is not None and is_inside(known[share][0][-2:]))

        for inside, stay in groupby(range(len(every)), lambda i: stays(every[i])):
            numbers = list(stay)
            if inside and len(numbers) > 1:
                around = every[max(0, numbers[0] - 1)], every[min(numbers[-1] + 1, len(every) - 1)]
                ends = [f"with_{FOLD}" if known[one] is None else "window" for one in around]
                own = [every[i] for i in numbers]
                if len(own) < OPTIONS.least_stay:
                    own = np.linspace(own[0], own[-1], OPTIONS.least_stay).tolist()
                solved = [known.get(share) or self.least_at(axis, share) for share in own]
                curves.append(self.limit_curve(axis, solved, (ends[0], ends[1])))
        return curves

    def limit_curve(
        self, axis: int, solved: Sequence[tuple[Array, float]], ends: tuple[str, str]
    ) -> BifurcationCurve:
        """Return the curve through solutions of `least_at`."""
        points = []
        ways = np.gradient(np.array([z for z, _ in solved]), axis=0)
        for (z, bound), way in zip(solved, ways, strict=True):
            flow = self.family(1).evaluate(z[:, None])[2][0]
            multipliers = descending(np.linalg.eigvals(flow))
            across = np.zeros(2)
            across[axis] = bound
            parts = split(HOMOCLINIC, multipliers, False)
            points.append(CurvePoint(z, way / np.linalg.norm(way), multipliers, *parts, across))
        return BifurcationCurve(HOMOCLINIC, 1, points, ends)

    def least_on_edge(self, axis: int, level: float, one: float, other: float) -> float:
        """Return the share between two others at which the curve crosses an edge of the window."""

        def off(share: float) -> float:
            return float(self.least_at(axis, share)[0][-2 + axis] - level)

        return float(brentq(off, one, other, xtol=1e-9))

    def least_at(self, axis: int, share: float) -> Any:
        """Return the unknowns (2 n + 2,) where rotations end on a saddle, and a bound.

        At a share of the other axis; None where the saddle itself vanishes first. The bound is on
        the place along the axis.
        """
        keep_budget(1.0)
        place = np.full(2, share)
        assert self.scene.orbit.limit is not None
        at = self.scene.orbit.limit[1](numbers(self.parameters(place[:, None])))
        if at.saddle is None:
            return None
        size = (self.window.high - self.window.low)[axis]
        place[axis] = (at.value - self.window.low[axis]) / size
        state = self.scene.state(at.saddle) / self.units[0]
        return np.concatenate([state, place]), at.error / size
