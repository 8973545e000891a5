"""Following a curve of periodic orbits through a window: its points, their errors, its ends."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.optimize import brentq

from ..errors import NoOrbitError
from ..orbits import descending, find_orbit, section_row, state_scale
from ..scene import Array, EquationsOfMotion
from .bifurcations import (
    LINE,
    NEIMARK_SACKER,
    BifurcationCurve,
    CurvePoint,
    Family,
    OrbitCurve,
    PeriodFlow,
    half_period_signs,
    kind_beyond,
    margin,
    reference_flow,
    split,
    stable_side,
)
from .curve import (
    OPTIONS,
    ContinuationOptions,
    Node,
    between,
    correct,
    step_on,
)


def numbers(parameters: Any) -> Any:
    """Return the parameters of a single point, arrays (1,), as numbers."""
    values = {name: getattr(parameters, name) for name in parameters.names()}
    single = {name: float(value[0]) for name, value in values.items() if np.ndim(value)}
    return parameters.replace(**single)


@dataclass(frozen=True)
class Stepper:
    """Who follows the orbits in place of the reference.

    Attributes
    ----------
    flow : PeriodFlow
    order : int
        Of the differences by which it is linearised.
    step : float
        Of these, in the size of each state.
    """

    flow: PeriodFlow
    order: int
    step: float


@dataclass
class Tracer:
    """Follows curves of the orbits of a scene.

    Attributes
    ----------
    scene : EquationsOfMotion
    parameters : callable
        See `Family`.
    stepper : Stepper or None
        None: the reference.
    steps : int
        Of the reference in a (half) period; as many as its error asks for.
    solutions : int
        Orbits that were solved for.
    """

    scene: EquationsOfMotion
    parameters: Callable[[Array], Any]
    stepper: Stepper | None = None
    steps: int = 32
    solutions: int = field(default=0, compare=False)

    def guess(self, place: Array) -> tuple[Array, float]:
        """Return a guess (2 n,) of the orbit at a place of the window, and its period [s]."""
        p = self.parameters(place[:, None])
        period = float(np.ravel(self.scene.period(p))[0])
        return np.reshape(self.scene.orbit.guesses(p)[0], -1), period

    @cached_property
    def units(self) -> tuple[Array, float]:
        """Sizes (2 n,) of the states and unit of the period [s]: those amid the window."""
        guess, period = self.guess(np.array([0.5, 0.5]))
        scale = state_scale(self.scene, guess[:, None], 2 * np.pi / period)
        return scale[:, 0], period

    def starts(self, place: Array) -> list[Array]:
        """Return guesses of unknowns (2 n + 2,) at a place of the window: the scene's first."""
        return [self.unknowns(*self.guess(place), place)]

    def unknowns(self, state: Array, period: float, place: Array) -> Array:
        """Return the unknowns (2 n + 2,) of an orbit with this state and period [s]."""
        (scale, unit), row = self.units, section_row(self.scene)
        start = state / scale
        if row is not None:
            start[row] = period / unit
        return np.concatenate([start, place])

    def orbits_at(self, place: Array) -> list[tuple[int, Array]]:
        """Return unknowns (2 n + 2,) at or near the orbits at a place, looked for with all means.

        Each with the (half) periods after which it may close.
        """
        try:
            orbit = find_orbit(self.scene, numbers(self.parameters(place[:, None])))
        except NoOrbitError:
            return []
        most = 1 if half_period_signs(self.scene) is None else 2
        unknowns = self.unknowns(orbit.state, orbit.period, place)
        return [(parts, unknowns) for parts in range(1, most + 1)]

    def family(self, parts: int, steps: int = 0) -> Family:
        """Return the orbits of the reference that close after so many (half) periods."""
        flow = reference_flow(self.scene, steps or self.steps)
        return Family(self.scene, self.parameters, flow, *self.units, parts)

    def curve(self, kind: str, parts: int, axis: int = 0, value: float = 0.0) -> OrbitCurve:
        """Return a kind of curve, see `OrbitCurve`."""
        family, its = self.family(parts), self.stepper
        if its is None:
            return OrbitCurve(family, kind, axis, value)
        own = replace(family, flow=its.flow, order=its.order, step=its.step)
        return OrbitCurve(own, kind, axis, value, by=family)

    def curves_at(self, kind: str, parts: int, z: Array) -> list[OrbitCurve]:
        """Return the curves that a bifurcation near unknowns (2 n + 2,) may lie on.

        The last is that of its kind, and those before it are special cases.
        """
        return [self.curve(kind, parts)]

    def second(self, curve: OrbitCurve) -> Family:
        """Return the family by other steps: of the reference, or of an engine's differences."""
        if self.stepper is None:
            return self.family(curve.family.parts, 3 * self.steps // 2)
        return replace(curve.family, step=2 * self.stepper.step)

    def rate(self, curve: OrbitCurve, here: Node) -> tuple[CurvePoint, float]:
        """Return a point with its multipliers and error bound, and what other steps change."""
        self.solutions += 1
        n = curve.family.size
        left, _, monodromy = curve.values(self.second(curve), here.z[:, None])
        inverse = np.linalg.inv(np.vstack([here.jacobian, here.tangent]))[:, :-1]
        off = np.abs(inverse @ left[:, 0])
        growth = 1 + np.sum(np.abs(monodromy[0]), axis=1)
        unit = OPTIONS.rounding + OPTIONS.step_rounding * np.sqrt(self.steps)
        rounding = unit * np.append(growth, max(growth))
        bound = 2 * off + np.abs(inverse) @ rounding
        multipliers = descending(np.linalg.eigvals(monodromy[0]))
        critical, others = split(curve.kind, multipliers, section_row(self.scene) is not None)
        side = stable_side(curve.kind, here.jacobian)
        point = CurvePoint(here.z, here.tangent, multipliers, critical, others, bound[n:], side)
        return point, float(np.max(off[n:]))

    def adapt(
        self, curve: OrbitCurve, point: CurvePoint, off: float, row: Array | None = None
    ) -> tuple[OrbitCurve, CurvePoint | None]:
        """Take more steps of the reference where they leave too much, or fewer.

        The point then moves on a plane: that across the curve, or on which a row is constant.
        """
        row = point.tangent if row is None else row
        while self.stepper is None and off > OPTIONS.integration and self.steps < OPTIONS.steps_max:
            self.steps = int(1.5 * self.steps) + 1
            curve = self.curve(curve.kind, curve.family.parts, curve.axis, curve.value)
            value = float(row @ point.z)
            again = correct(curve.equations, point.z, row, value, along=point.tangent)
            if again is None:
                return curve, None
            self.solutions -= 1
            before = off
            point, off = self.rate(curve, again)
            if off > before / 2:  # rounding
                break
        needless = off < OPTIONS.integration / 300 and self.steps > OPTIONS.steps_min
        if self.stepper is None and needless:
            self.steps = max(int(0.85 * self.steps), OPTIONS.steps_min)
            curve = self.curve(curve.kind, curve.family.parts, curve.axis, curve.value)
        return curve, point

    def trace(
        self, curve: OrbitCurve, start: CurvePoint, options: ContinuationOptions, begins: str = ""
    ) -> Iterator[tuple[CurvePoint | None, str]]:
        """Yield points of a curve from one on, without that; with the last, why it ends.

        ``begins`` is why it begins at the first, which is no end, whichever side it lies on.
        """
        past, before, ds = None, start, options.ds
        for _ in range(options.max_points):
            if curve.kind != LINE:
                ds = min(ds, careful(curve.kind, past, before))
            step = step_on(curve.equations, before, ds, past, options)
            if step is None:
                yield None, "lost"
                return
            ahead, apart = step[0], float(np.linalg.norm(step[0].z - before.z))
            edge = crossing(before, ahead, curve.family.size)
            if edge is not None:
                point, why = self.at_edge(curve, before, ahead, edge), "window"
                again = point is None and apart > 2 * options.ds_min
            else:
                ds = step[1]
                curve, point = self.adapt(curve, *self.rate(curve, ahead))
                why = "" if point is None else self.end(curve, start, before, point)
                again = why == "symmetric" and apart > options.ds / 2
            if point is not None and self.meets(curve, before, point, begins and before is start):
                landed = self.landing(curve, before, point)
                missed = landed is None or not is_inside(landed.place)
                again = missed and apart > 2 * options.ds_min  # or it has been outside meanwhile
                point = landed or point
                why = f"with_{kind_beyond(curve.kind, point)}"
            if again:
                ds = apart / 2
                continue
            if point is None:
                yield None, "lost"
                return
            yield (None if why in ("neutral", "symmetric") else point), why
            if why:
                return
            past, before = before, point
        yield None, "points"

    def meets(
        self, curve: OrbitCurve, before: CurvePoint, here: CurvePoint, is_beginning: Any
    ) -> bool:
        """Return True if another bifurcation lies between two points of a curve."""
        if curve.kind == LINE or is_beginning:
            return False
        return margin(curve.kind, before) > 0 > margin(curve.kind, here)

    def at_edge(
        self, curve: OrbitCurve, before: CurvePoint, ahead: Node, edge: tuple[Array, float, Array]
    ) -> CurvePoint | None:
        """Return where a curve leaves the window between two points.

        None where no such point is near the guess, or where the curve has come in there and turned.
        """
        row, value, guess = edge
        if abs(row @ before.z - value) < OPTIONS.edge and not leaves(before):
            return None
        apart = float(np.linalg.norm(ahead.z - before.z))
        solution = correct(curve.equations, guess, row, value, along=ahead.tangent)
        if solution is None or np.max(np.abs(solution.z - guess)) > apart / 4:
            return None
        if not is_inside(solution.z[-2:]):
            return None
        return self.rate(curve, solution)[0]

    def end(
        self, curve: OrbitCurve, first: CurvePoint, before: CurvePoint, here: CurvePoint
    ) -> str:
        """Return the reason for which a curve ends at a point, empty if it goes on."""
        family = curve.family
        if family.parts > 1:
            far, near = (self.asymmetry(family.parts // 2, point) for point in (before, here))
            if np.max(np.abs(near)) < OPTIONS.symmetric or far @ near < 0:
                return "symmetric"
        if curve.kind == LINE:
            row = section_row(self.scene)
            endless = row is not None and here.z[row] > OPTIONS.max_period
            far = np.max(np.abs(here.multipliers)) > OPTIONS.max_multiplier
            return "far" if endless or far else ""
        if before is not first and closes(first, before, here):
            return "closed"
        if not self.is_proper(curve, here):
            return "neutral"
        return "unstable" if here.unstable else ""

    def least_curves(self, count: int = 0) -> list[BifurcationCurve]:
        """Return the curves on which orbits end without a bifurcation."""
        return []

    def is_proper(self, curve: OrbitCurve, point: CurvePoint) -> bool:
        """Return True if a solution of a curve's equations is a bifurcation of its kind."""
        return curve.kind != NEIMARK_SACKER or abs(point.critical.imag) >= OPTIONS.real

    def asymmetry(self, parts: int, here: CurvePoint) -> Array:
        """Return by how far (2 n,) an orbit does not close after fewer (half) periods."""
        if half_period_signs(self.scene) is None:
            return np.full(self.family(parts).size, np.inf)
        at = self.family(parts).period_map(here.z[:, None])
        return at.residual(np.array([0]), np.zeros((len(at.scale), 1)))[:, 0]

    def landing(self, curve: OrbitCurve, a: CurvePoint, b: CurvePoint) -> CurvePoint | None:
        """Return the point between two others at which two bifurcations meet, if it is found."""
        points = {0.0: a, 1.0: b}

        def off(share: float) -> float:
            if share not in points:
                guess = between(a, b, share)
                solution = correct(curve.equations, guess, a.tangent, float(a.tangent @ guess))
                if solution is None:
                    raise NoOrbitError("no point of a curve between two others")
                points[share] = self.rate(curve, solution)[0]
                if abs(margin(curve.kind, points[share])) < OPTIONS.landed:
                    return 0.0
            return margin(curve.kind, points[share])

        try:
            most = OPTIONS.max_landings
            share, how = brentq(off, 0, 1, maxiter=most, full_output=True, disp=False)
        except NoOrbitError:
            return None
        return points[share] if how.converged else None


def careful(kind: str, past: CurvePoint | None, here: CurvePoint) -> float:
    """Return the longest step from a point of a curve that multipliers allow."""
    gap = abs(margin(kind, here))
    if gap > OPTIONS.near_meeting:
        return np.inf
    if past is None:
        return OPTIONS.careful[0]
    change = abs(gap - abs(margin(kind, past))) / float(np.linalg.norm(here.z - past.z))
    return max(OPTIONS.careful[1], OPTIONS.max_change * gap / max(change, 1e-12))


def closes(first: CurvePoint, before: CurvePoint, here: CurvePoint) -> bool:
    """Return True if a curve has passed its first point between two others."""
    a, b = ((point.z - first.z) @ first.tangent for point in (before, here))
    if not a < 0 <= b:
        return False
    near = before.z + (here.z - before.z) * (-a / (b - a)) - first.z
    return bool(np.max(np.abs(near)) < np.linalg.norm(here.z - before.z) / 2)


def crossing(before: Any, ahead: Any, n: int) -> tuple[Array, float, Array] | None:
    """Return the edge of the window between two points: its row, value, and a guess of unknowns."""
    nearest: tuple[float, int, float] | None = None
    for k in (0, 1):
        a, b = before.z[n + k], ahead.z[n + k]
        for value, outwards in ((0.0, -1), (1.0, 1)):
            if (b - value) * outwards > OPTIONS.edge:
                share = (value - a) / (b - a)
                if nearest is None or share < nearest[0]:
                    nearest = share, k, value
    if nearest is None:
        return None
    share, k, value = nearest
    return np.eye(n + 2)[n + k], value, between(before, ahead, float(np.clip(share, 0, 1)))


def is_inside(place: Array) -> bool:
    """Return True if a place (2,) lies in the window."""
    return bool(np.all((place > -OPTIONS.edge) & (place < 1 + OPTIONS.edge)))


def leaves(point: CurvePoint) -> bool:
    """Return True if a curve leaves the window at a point on its edge."""
    place, out, edge = point.place, point.tangent[-2:], OPTIONS.edge
    return bool(np.any(((place < edge) & (out < 0)) | ((place > 1 - edge) & (out > 0))))
