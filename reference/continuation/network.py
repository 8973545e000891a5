"""Networks of bifurcation curves: where they start, how they are followed, and where they end.

Orbits are followed along lines through a window of two parameters. Where a test function changes its
sign a bifurcation is found, which is then followed through the window as a curve; where the symmetry
or the period of an orbit breaks, the orbits that part from it are followed along the line, too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from .bifurcations import (
    DOUBLING,
    FOLD,
    KINDS,
    LINE,
    NEIMARK_SACKER,
    Family,
    OrbitCurve,
    half_period_signs,
    reference_flow,
    test_function,
)
from .curve import Control, Node, between, correct, node, step_on, tangent_of
from ..orbits import descending, section_row, state_scale
from ..scene import Array, EquationsOfMotion

ALONG = Control(first=0.05, longest=0.12, turn=0.3)
"""Steps along lines."""

ACROSS = Control(first=0.03, longest=0.12, turn=0.2)
"""Steps along curves."""

WANTED = 1e-10
"""What integration may leave of a point of the reference, in the window's unit."""

FEWEST, MOST = 16, 2048
"""Steps of the reference in a (half) period."""

ROUNDING, STEP_ROUNDING = 7e-16, 5e-16
"""Of a period's end, in the sizes of the states: as it is, and by the root of its steps."""

SAME = 1e-3
"""Distance from a curve, in the window's unit, below which a bifurcation is on it."""

EDGE = 1e-9
"""How near an edge of the window is on it."""

PARTING = 0.03
"""How far from a period doubling the doubled orbits start, in the size of the states."""

SYMMETRIC = 3e-3
"""Departure from its mirror image of an orbit that has become symmetric."""


class Window(NamedTuple):
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
class Point:
    """A point of a curve.

    Attributes
    ----------
    z, tangent : array (2 n + 2,)
    multipliers : complex array (2 n,)
        Of the map that the orbit is closed by, descending in modulus.
    critical : complex
        That, or one of those, which the bifurcation is of; NaN on a line.
    others : complex array
        The others, that of a shift in time left out.
    bound : array (2,)
        On the error of the parameters, in the window's unit.
    """

    z: Array
    tangent: Array
    multipliers: Any
    critical: complex
    others: Any
    bound: Array

    @property
    def unstable(self) -> int:
        """How many others lie outside the unit circle."""
        return int(np.sum(np.abs(self.others) > 1))


@dataclass
class Curve:
    """A curve of orbits, or along a line.

    Attributes
    ----------
    kind : str
    parts : int
        See `Family`.
    points : list of Point
    ends : list of str
        Why it begins and ends where it does.
    """

    kind: str
    parts: int
    points: list[Point] = field(default_factory=list)
    ends: list[str] = field(default_factory=list)

    def distance(self, place: Array) -> float:
        """Return how far a place (2,) of the window is from the curve."""
        path = self.path()
        if len(path) < 2:
            return np.inf
        start, way = path[:-1], np.diff(path, axis=0)
        share = np.sum((place - start) * way, axis=1) / np.maximum(np.sum(way**2, axis=1), 1e-300)
        nearest = start + np.clip(share, 0, 1)[:, None] * way
        return float(np.min(np.linalg.norm(nearest - place, axis=1)))

    def path(self, between_two: int = 8) -> Array:
        """Return places (m, 2) along the curve, cubic between its points."""
        shares = np.arange(between_two) / between_two
        places = [
            between(a, b, share)[-2:]  # type: ignore[arg-type]
            for a, b in zip(self.points, self.points[1:], strict=False)
            for share in shares
        ]
        return np.array([*places, *(point.z[-2:] for point in self.points[-1:])])


@dataclass
class Tracer:
    """Follows curves of the orbits of a scene.

    Attributes
    ----------
    scene : EquationsOfMotion
    parameters : callable
        See `Family`.
    solutions : int
        Orbits that were solved for.
    """

    scene: EquationsOfMotion
    parameters: Callable[[Array], Any]
    steps: int = 32
    solutions: int = 0

    def guesses(self, place: Array) -> tuple[list[Array], float]:
        """Return guesses (2 n,) of the orbit at a place of the window, and its period [s]."""
        p = self.parameters(place[:, None])
        period = float(np.ravel(self.scene.period(p))[0])
        return [np.reshape(guess, -1) for guess in self.scene.orbit.guesses(p)], period

    @cached_property
    def units(self) -> tuple[Array, float]:
        """Sizes (2 n,) of the states and unit of the period [s]: those amid the window."""
        guesses, period = self.guesses(np.array([0.5, 0.5]))
        scale = state_scale(self.scene, guesses[0][:, None], 2 * np.pi / period)
        return scale[:, 0], period

    def family(self, parts: int = 1) -> Family:
        """Return the orbits that close after so many (half) periods."""
        flow = reference_flow(self.scene, self.steps)
        return Family(self.scene, self.parameters, flow, *self.units, parts)

    def starts(self, place: Array) -> list[Array]:
        """Return guesses of unknowns (2 n + 2,) at a place of the window."""
        guesses, period = self.guesses(place)
        scale, unit = self.units
        row, starts = section_row(self.scene), []
        for guess in guesses:
            start = guess / scale
            if row is not None:
                start[row] = period / unit
            starts.append(np.concatenate([start, place]))
        return starts

    def rated(self, curve: OrbitCurve, solution: Any, along: Array) -> tuple[Point, Node, float]:
        """Return a point with its multipliers and error bound, and what integration leaves."""
        self.solutions += 1
        n, here = curve.family.size, node(solution, along)
        fine = replace(curve, family=with_steps(curve.family, 3 * self.steps // 2), by=None)
        left, closing, monodromy = (part[..., 0] if i == 0 else part[0] for i, part in enumerate(
            fine.values(fine.family, here.z[:, None])))
        inverse = np.linalg.inv(np.vstack([here.jacobian, here.tangent]))
        off = np.abs(inverse[:, :-1] @ left)
        growth = 1 + np.sum(np.abs(monodromy), axis=1)
        rounding = (ROUNDING + STEP_ROUNDING * np.sqrt(self.steps)) * np.append(growth, max(growth))
        bound = 2 * off + np.abs(inverse[:, :-1]) @ rounding
        multipliers = descending(np.linalg.eigvals(monodromy))
        critical, others = split(curve.kind, multipliers, section_row(self.scene) is not None)
        point = Point(here.z, here.tangent, multipliers, critical, others, bound[n:])
        return point, here, float(np.max(off[n:]))

    def trace(
        self, curve: OrbitCurve, start: Point, control: Control, stop: Callable[..., str | None]
    ) -> Iterator[tuple[Point | None, str]]:
        """Yield points of a curve from one on, without that; at last why it ends.

        ``stop`` is asked at each point, beside the one before.
        """
        here, length = Node(start.z, start.tangent, np.empty(0)), control.first
        before = start
        for _ in range(control.points):
            ahead = step_on(curve.equations, here, length, control)
            if ahead is None:
                yield None, "lost"
                return
            length = ahead[1]
            edge = crossing(before, ahead[0], curve.family.size)
            if edge is not None:
                row, value, guess = edge
                solution = correct(curve.equations, guess, row, value)
                if solution is not None:
                    yield self.rated(curve, solution, ahead[0].tangent)[0], "window"
                    return
            point, here, off = self.rated(curve, ahead[0], ahead[0].tangent)
            if off > WANTED and self.steps < MOST:
                self.steps = int(1.5 * self.steps) + 1
                curve = replace(curve, family=with_steps(curve.family, self.steps))
                again = correct(curve.equations, here.z, here.tangent, here.tangent @ here.z)
                if again is None:
                    yield None, "lost"
                    return
                self.solutions -= 1
                point, here, off = self.rated(curve, again, here.tangent)
            elif off < WANTED / 300 and self.steps > FEWEST:
                self.steps = max(int(0.85 * self.steps), FEWEST)
                curve = replace(curve, family=with_steps(curve.family, self.steps))
            why = stop(curve, before, point)
            if why in CODIMENSION_2:
                yield self.landing(curve, before, point, why), why
                return
            if why == "neutral":  # it began where the multipliers of saddles meet
                yield None, why
                return
            yield point, why or ""
            if why:
                return
            before = point
        yield None, "points"


    def landing(self, curve: OrbitCurve, a: Point, b: Point, why: str) -> Point:
        """Return the point between two others at which a test function of the others is 0."""
        values = [CODIMENSION_2[why](point) for point in (a, b)]
        low, best = 0.0, b
        high = 1.0
        for _ in range(3):
            share = low + (high - low) * values[0] / (values[0] - values[1])
            guess = between(a, b, share)  # type: ignore[arg-type]
            solution = correct(curve.equations, guess, a.tangent, a.tangent @ guess)
            if solution is None:
                return best
            best = self.rated(curve, solution, a.tangent)[0]
            here = CODIMENSION_2[why](best)
            if abs(here) < LANDED:
                return best
            side = int(here * values[0] < 0)
            values[side] = here
            low, high = (share, high) if side == 0 else (low, share)
        return best


def with_steps(family: Family, steps: int) -> Family:
    """Return a family of the reference by other steps."""
    return replace(family, flow=reference_flow(family.scene, steps))


def split(kind: str, multipliers: Any, autonomous: bool) -> tuple[complex, Any]:
    """Return the critical multiplier and the others, that of a shift in time left out."""
    others = np.array(multipliers)
    if autonomous:
        others = np.delete(others, np.argmin(np.abs(others - 1)))
    if kind == LINE:
        return complex(np.nan), others
    if kind == NEIMARK_SACKER:
        i, j = critical_pair(others)
        return complex(others[i]), np.delete(others, [i, j])
    i = int(np.argmin(np.abs(others - (-1 if kind == DOUBLING else 1))))
    return complex(others[i]), np.delete(others, i)


def critical_pair(multipliers: Any) -> tuple[int, int]:
    """Return which two multipliers have a product nearest to 1."""
    off = np.abs(np.outer(multipliers, multipliers) - 1)
    off[np.tril_indices(len(off))] = np.inf
    i, j = np.unravel_index(np.argmin(off), off.shape)
    return int(i), int(j)


def crossing(before: Any, ahead: Any, n: int) -> tuple[Array, float, Array] | None:
    """Return the edge of the window between two points: its row, value, and a guess of unknowns."""
    first = None
    for k in (0, 1):
        a, b = before.z[n + k], ahead.z[n + k]
        for value in (0.0, 1.0):
            if (b - value) * (1 if value else -1) > 1e-9:
                share = (value - a) / (b - a)
                if first is None or share < first[0]:
                    first = (share, k, value)
    if first is None:
        return None
    share, k, value = first
    return np.eye(n + 2)[n + k], value, between(before, ahead, float(np.clip(share, 0, 1)))


# Where curves end ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Ends:
    """Looks at each point of a curve for a reason to end it there.

    Attributes
    ----------
    tracer : Tracer
    first : Point or None
        Where the curve began: if it comes back to it, it is closed.
    """

    tracer: Any
    first: Point

    def __call__(self, curve: OrbitCurve, before: Point, here: Point) -> str | None:
        """Return why the curve ends at a point, or None."""
        if curve.family.parts > 1 and self.symmetry(curve.family, here) < SYMMETRIC:
            return "symmetric"
        if curve.kind == LINE:
            return "far" if np.max(np.abs(here.multipliers)) > FAR else None
        if self.closes(curve.family, before, here):
            return "closed"
        for why, value in CODIMENSION_2.items():
            a, b = value(before), value(here)
            if why.startswith("resonance"):
                if curve.kind == NEIMARK_SACKER and a > 0 > b:
                    return why
            elif a * b < 0:
                return why
        if curve.kind == NEIMARK_SACKER and abs(here.critical.imag) < REAL:
            return "neutral"
        return "unstable" if here.unstable else None

    def symmetry(self, family: Family, here: Point) -> float:
        """Return by how far an orbit is not its own mirror image."""
        if half_period_signs(family.scene) is None:
            return np.inf
        half = replace(family, parts=family.parts // 2)
        at = half.period_map(here.z[:, None])
        return float(np.max(np.abs(at.residual(np.array([0]), np.zeros((family.size, 1))))))

    def closes(self, family: Family, before: Point, here: Point) -> bool:
        """Return whether the curve has passed its first point between two others."""
        first = self.first
        if before is first:
            return False
        a, b = ((point.z - first.z) @ first.tangent for point in (before, here))
        if not a < 0 <= b:
            return False
        near = before.z + (here.z - before.z) * (-a / (b - a)) - first.z
        return float(np.max(np.abs(near))) < np.linalg.norm(here.z - before.z) / 2


FAR = 10.0
"""Largest multiplier up to which orbits are followed along lines: none became stable again."""

REAL = 1e-9
"""Imaginary part of multipliers that have met."""

LANDED = 1e-4
"""Of a test function of multipliers, at a point where two bifurcations meet."""


def pair_sum(point: Point) -> float:
    """Return 2 cos of the angle of the critical pair, or the sum of two that are real."""
    return float((point.critical + 1 / point.critical).real)


def other(kind: str) -> Callable[[Point], float]:
    """Return the test function of the multipliers that are not critical."""
    return lambda point: others_test(point.others)[kind]


CODIMENSION_2: Mapping[str, Callable[[Point], float]] = {
    "resonance_1_1": lambda point: 2 - pair_sum(point),
    "resonance_1_2": lambda point: 2 + pair_sum(point),
    "with_fold": other(FOLD),
    "with_period_doubling": other(DOUBLING),
    "with_neimark_sacker": other(NEIMARK_SACKER),
}
"""Where a curve ends since another bifurcation comes in, by the test function of that."""


def comes_in(why: str, kind: str) -> str:
    """Return the kind of the curve that begins where another of a kind ends."""
    if why.startswith("resonance"):
        return FOLD if why.endswith("1") else DOUBLING
    new = why.removeprefix("with_")
    return NEIMARK_SACKER if new == kind else new


# The network --------------------------------------------------------------------------------


def others_test(others: Any) -> dict[str, float]:
    """Return test functions of multipliers; their signs change at a bifurcation."""
    i, j = np.triu_indices(len(others), 1)
    return {
        kind: float(np.real(np.prod(value)))
        for kind, value in zip(
            KINDS, (others - 1, others + 1, others[i] * others[j] - 1), strict=True
        )
    }


@dataclass
class Network:
    """The bifurcation curves of a window.

    Attributes
    ----------
    tracer : Tracer
    parts : int
        Largest number of (half) periods of the orbits.
    lines, curves : list of Curve
    """

    tracer: Tracer
    parts: int
    lines: list[Curve] = field(default_factory=list)
    curves: list[Curve] = field(default_factory=list)
    starts: list[tuple[OrbitCurve, Point]] = field(default_factory=list)

    def scan(self, axis: int, value: float, shares: tuple[float, ...] = (0.5, 0.15, 0.85)) -> None:
        """Follow orbits along a line of the window, and gather where curves start."""
        for share in shares:
            place = np.full(2, share)
            place[axis] = value
            family, guesses = self.tracer.family(), self.tracer.starts(place)
            line = OrbitCurve(family, LINE, axis, value)
            row = np.eye(family.size + 2)[family.size + 1 - axis]
            for guess in guesses[:1]:
                solution = correct(line.equations, guess, row, share, 30)
                if solution is None or not np.all(np.abs(solution.z - guess) < 1):
                    continue
                start = self.tracer.rated(line, solution, row)[0]
                if self.known(line, start):
                    continue
                for sign in (1, -1):
                    self.branch(line, replace(start, tangent=sign * start.tangent))

    def known(self, line: OrbitCurve, start: Point) -> bool:
        """Return whether an orbit is on a line that was followed."""
        n = line.family.size
        for other in self.lines:
            if other.parts != line.family.parts:
                continue
            for a, b in zip(other.points, other.points[1:], strict=False):
                if abs(a.z[n + line.axis] - line.value) > 1e-9:
                    break
                way, off = b.z - a.z, start.z - a.z
                share = float(np.clip(way @ off / (way @ way), 0, 1))
                if np.max(np.abs(between(a, b, share) - start.z)) < 0.01:  # type: ignore[arg-type]
                    return True
        return False

    def branch(self, line: OrbitCurve, start: Point) -> None:
        """Follow a line from a point one way; what it meets is kept."""
        curve = Curve(LINE, line.family.parts, [start])
        self.lines.append(curve)
        for point, why in self.tracer.trace(line, start, ALONG, Ends(self.tracer, start)):
            if point is None:
                curve.ends.append(why)
                break
            before = curve.points[-1]
            old, new = (others_test(p.others) for p in (before, point))
            curve.points.append(point)
            for kind in KINDS:
                if old[kind] * new[kind] < 0:
                    share = old[kind] / (old[kind] - new[kind])
                    self.meet(line, kind, between(before, point, share))  # type: ignore[arg-type]
            if why:
                curve.ends.append(why)
                break

    def meet(self, line: OrbitCurve, kind: str, guess: Array) -> None:
        """Keep a bifurcation near a point of a line; follow what is doubled there."""
        family = replace(line.family, flow=reference_flow(self.tracer.scene, self.tracer.steps))
        curve, n = OrbitCurve(family, kind), family.size
        row = np.eye(n + 2)[n + line.axis]
        solution = correct(curve.equations, guess, row, line.value)
        if solution is None or np.any(np.abs(solution.z - guess) > 0.3):
            return
        along = tangent_of(solution.jacobian, np.eye(n + 2)[n + 1 - line.axis])
        start = self.tracer.rated(curve, solution, along)[0]
        if kind == NEIMARK_SACKER and abs(start.critical.imag) < REAL:
            return
        if np.min(start.z[n:]) < -1e-9 or np.max(start.z[n:]) > 1 + 1e-9:
            return
        self.starts.append((curve, start))
        if kind == DOUBLING and 2 * family.parts <= self.parts:
            self.switch(line, family, start)

    def switch(self, line: OrbitCurve, family: Family, at: Point) -> None:
        """Follow the orbits of twice the length that part from one along a line."""
        n = family.size
        _, _, monodromy = family.evaluate(at.z[:, None])
        values, vectors = np.linalg.eig(monodromy[0])
        away = vectors[:, np.argmin(np.abs(values + 1))].real
        row = np.append(away / np.linalg.norm(away), [0.0, 0.0])
        doubled = OrbitCurve(replace(family, parts=2 * family.parts), LINE, line.axis, line.value)
        guess = at.z + PARTING * row
        solution = correct(doubled.equations, guess, row, row @ guess)
        if solution is None:
            return
        start = self.tracer.rated(doubled, solution, row)[0]
        if not self.known(doubled, start):
            self.branch(doubled, start)

    def follow_all(self) -> None:
        """Follow the curves from where they start, those not yet followed."""
        while self.starts:
            curve, start = self.starts.pop(0)
            if not start.unstable and not self.followed(curve, start):
                self.curves.append(self.both_ways(curve, start))

    def followed(self, curve: OrbitCurve, start: Point) -> bool:
        """Return whether a bifurcation is on a curve already."""
        return any(
            other.kind == curve.kind
            and other.parts == curve.family.parts
            and other.distance(start.z[-2:]) < SAME
            for other in self.curves
        )

    def both_ways(self, curve: OrbitCurve, start: Point) -> Curve:
        """Return a curve, followed from a point in both directions."""
        ahead, end = self.one_way(curve, start)
        if end == "closed":
            return Curve(curve.kind, curve.family.parts, [*ahead, start], [end, end])
        back, begin = self.one_way(curve, replace(start, tangent=-start.tangent))
        points = [replace(point, tangent=-point.tangent) for point in back[:0:-1]] + ahead
        return Curve(curve.kind, curve.family.parts, points, [begin, end])

    def one_way(self, curve: OrbitCurve, start: Point) -> tuple[list[Point], str]:
        """Return the points of a curve in one direction, with the first, and why it ends."""
        n, points, why = curve.family.size, [start], ""
        place, out = start.z[n:], start.tangent[n:]
        if np.any(((place < EDGE) & (out < 0)) | ((place > 1 - EDGE) & (out > 0))):
            return points, "window"
        for point, why in self.tracer.trace(curve, start, ACROSS, Ends(self.tracer, start)):
            points += [point] if point else []
        if why in CODIMENSION_2:
            self.begin(curve, comes_in(why, curve.kind), points[-1])
        return points, why

    def begin(self, curve: OrbitCurve, kind: str, at: Point) -> None:
        """Keep the start of a curve of another kind at a point of a curve."""
        other, n = replace(curve, kind=kind), curve.family.size
        for row in (at.tangent, *np.eye(n + 2)[n:]):
            solution = correct(other.equations, at.z, row, row @ at.z)
            if solution is not None and np.max(np.abs(solution.z - at.z)) < PARTING:
                along = tangent_of(solution.jacobian, row)
                self.starts.append((other, self.tracer.rated(other, solution, along)[0]))
                return
