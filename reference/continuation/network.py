"""Networks of bifurcation curves: where they start, and how they are followed.

Orbits are followed along lines through a window of two parameters. Where multipliers cross the
unit circle a bifurcation begins, which is then followed through the window as a curve; where the
symmetry or the period of an orbit breaks, what parts from it is followed along the line, too.
Where a second bifurcation comes in, the curve ends and that of the second begins.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ..scene import Array
from .bifurcations import DOUBLING, LINE, OrbitCurve
from .curve import Control, between, correct, tangent_of
from .points import CODIMENSION_2, BifurcationCurve, CurvePoint, kind_beyond
from .tracing import Tracer, is_inside, leaves

ALONG = Control(first=0.08, longest=0.25, turn=0.5)
"""Steps along lines."""

ACROSS = Control(first=0.04, longest=0.2, turn=0.3)
"""Steps along curves."""

SAME = 1e-3
"""Distance from a curve, in the window's unit, below which a bifurcation is on it."""

SAME_ORBIT = 1e-2
"""Distance of two orbits at the same parameters, in the sizes of the states, likewise."""

PARTING = 0.03
"""How far from a period doubling the doubled orbits start, in the size of the states."""

ASTRAY = 0.3
"""Newton's method has led to another bifurcation than the one it started at."""

SHARES = (0.5, 0.15, 0.85)
"""Where on a line orbits are looked for."""


class CurveStart(NamedTuple):
    """A bifurcation from which a curve is to be followed.

    ``doubled`` is as of a `BifurcationCurve`.
    """

    kind: str
    parts: int
    point: CurvePoint
    doubled: bool = False


@dataclass
class Network:
    """The bifurcation curves of a window.

    Attributes
    ----------
    reference : Tracer
        Looks for bifurcations along lines.
    tracer : Tracer
        Follows them: the same, or an engine's.
    lines : list of float
        Places in the window, 0 to 1, of lines on which the first parameter stays.
    most_parts : int
        (Half) periods after which orbits close at most.
    lines_done : int
    starts : list of CurveStart
        What is still to be followed.
    curves : list of BifurcationCurve
    missing : list of CurveStart
        What the tracer has no bifurcation near.
    has_orbits : bool
        Whether there was any on the lines.
    """

    reference: Tracer
    tracer: Tracer
    lines: list[float]
    most_parts: int
    lines_done: int = 0
    starts: list[CurveStart] = field(default_factory=list)
    curves: list[BifurcationCurve] = field(default_factory=list)
    missing: list[CurveStart] = field(default_factory=list)
    has_orbits: bool = False

    def work(self) -> Iterator[tuple[int, int, str]]:
        """Look along the lines, follow what begins there; yield what is done, of what, in words."""
        while self.starts or self.lines_done < len(self.lines):
            if self.starts:
                start = self.starts[0]
                if not start.point.unstable and self.curve_through(*start[:3]) is None:
                    self.follow(start)
                del self.starts[0]
            else:
                self.scan(0, float(self.lines[self.lines_done]))
                self.lines_done += 1
            yield self.lines_done, len(self.lines), f"lines, {len(self.curves)} curves"

    # Along lines ------------------------------------------------------------------------------

    def scan(self, axis: int, value: float) -> None:
        """Follow orbits along a line of the window, and gather where curves start."""
        seen: list[BifurcationCurve] = []
        line = self.reference.curve(LINE, 1, axis, value)
        for share in SHARES:
            place = np.full(2, share)
            place[axis] = value
            for guess in self.reference.starts(place):
                row = np.eye(len(guess))[-1 - axis]
                solution = correct(line.equations, guess, row, share, 30)
                if solution is None or not np.all(np.abs(solution.z - guess) < 1):
                    continue
                start = self.reference.rate(line, solution, row)[0]
                self.has_orbits = True
                if not is_known(start, 1, seen):
                    for sign in (1, -1):
                        self.branch(line, replace(start, tangent=sign * start.tangent), seen)

    def branch(self, line: OrbitCurve, start: CurvePoint, seen: list[BifurcationCurve]) -> None:
        """Follow a line from a point one way; what it meets is kept."""
        curve = BifurcationCurve(LINE, line.family.parts, [start])
        seen.append(curve)
        if leaves(start):
            return
        for point, _ in self.reference.trace(line, start, ALONG):
            if point is None:
                return
            before = curve.points[-1]
            curve.points.append(point)
            old, new = self.reference.crossings(before), self.reference.crossings(point)
            for kind in old:
                if old[kind] * new[kind] < 0:
                    guess = self.reference.crossing(kind, before, point)
                    self.meet(line, kind, guess, seen)

    def meet(self, line: OrbitCurve, kind: str, guess: Array, seen: list[BifurcationCurve]) -> None:
        """Keep a bifurcation near a point of a line; follow what parts from it there."""
        parts, rows = line.family.parts, np.eye(len(guess))[-2:]
        for own in self.reference.curves_at(kind, parts, guess):
            solution = correct(own.equations, guess, rows[line.axis], line.value)
            if solution is None or np.any(np.abs(solution.z - guess) > ASTRAY):
                continue
            kind, along = own.kind, tangent_of(solution.jacobian, rows[1 - line.axis])
            point = self.reference.rate(own, solution, along)[0]
            if is_inside(point.place) and self.reference.is_proper(own, point):
                break
        else:
            return
        curve, count = self.curve_through(kind, parts, point), len(self.starts)
        if curve is None or not curve.doubled:
            if kind == DOUBLING and 2 * parts <= self.most_parts:
                self.switch(line, point, seen)
            doubled = len(self.starts) > count
            if curve is None:
                self.starts.insert(count, CurveStart(kind, parts, point, doubled))
            else:
                curve.doubled = doubled

    def switch(self, line: OrbitCurve, at: CurvePoint, seen: list[BifurcationCurve]) -> None:
        """Follow the orbits of twice the length that part from one along a line."""
        parts = line.family.parts
        _, _, monodromy = self.reference.family(parts).evaluate(at.z[:, None])
        values, vectors = np.linalg.eig(monodromy[0])
        away = vectors[:, np.argmin(np.abs(values + 1))].real
        row = np.append(away / np.linalg.norm(away), [0.0, 0.0])
        doubled = self.reference.curve(LINE, 2 * parts, line.axis, line.value)
        guess = at.z + PARTING * row
        solution = correct(doubled.equations, guess, row, float(row @ guess))
        if solution is not None:
            start = self.reference.rate(doubled, solution, row)[0]
            if not is_known(start, 2 * parts, seen):
                self.branch(doubled, start, seen)

    # Across the window ------------------------------------------------------------------------

    def curve_through(self, kind: str, parts: int, point: CurvePoint) -> BifurcationCurve | None:
        """Return the curve that a bifurcation is on already, or None."""
        for curve in self.curves:
            if (curve.kind, curve.parts) == (kind, parts) and curve.distance(point.place) < SAME:
                return curve
        return None

    def follow(self, start: CurveStart) -> None:
        """Follow a curve from a point in both directions."""
        curve, point = self.tracer.curves_at(*start[:2], start.point.z)[-1], start.point
        if self.tracer is not self.reference:
            along = float(point.tangent @ point.z)
            solution = correct(curve.equations, point.z, point.tangent, along)
            if solution is None or np.any(np.abs(solution.z - point.z) > ASTRAY):
                self.missing.append(start)
                return
            point = self.tracer.rate(curve, solution, point.tangent)[0]
        ahead, end = self.one_way(curve, point)
        if end == "closed":
            points, begin = [*ahead, point], end
        else:
            back, begin = self.one_way(curve, replace(point, tangent=-point.tangent))
            points = [replace(item, tangent=-item.tangent) for item in back[:0:-1]] + ahead
        if len(points) > 1:
            ends = begin, end
            self.curves.append(
                BifurcationCurve(start.kind, start.parts, points, ends, start.doubled)
            )

    def one_way(self, curve: OrbitCurve, start: CurvePoint) -> tuple[list[CurvePoint], str]:
        """Return the points of a curve in one direction, with the first, and why it ends."""
        if leaves(start):
            return [start], "window"
        steps = list(self.tracer.trace(curve, start, ACROSS))
        points = [start, *(point for point, _ in steps if point)]
        why = steps[-1][1]
        if why in CODIMENSION_2:
            self.begin(curve, kind_beyond(why, curve.kind), points[-1])
        return points, why

    def begin(self, curve: OrbitCurve, kind: str, at: CurvePoint) -> None:
        """Keep the start of a curve of another kind at a point of a curve."""
        if self.curve_through(kind, curve.family.parts, at) is not None:
            return
        other = self.tracer.curves_at(kind, curve.family.parts, at.z)[-1]
        for row in (at.tangent, *np.eye(len(at.z))[-2:]):
            solution = correct(other.equations, at.z, row, float(row @ at.z))
            if solution is not None and np.max(np.abs(solution.z - at.z)) < PARTING:
                along = tangent_of(solution.jacobian, row)
                point = self.tracer.rate(other, solution, along)[0]
                self.starts.append(CurveStart(kind, curve.family.parts, point))
                return


def is_known(start: CurvePoint, parts: int, lines: list[BifurcationCurve]) -> bool:
    """Return whether an orbit lies on a line that was followed."""
    for line in lines:
        for a, b in zip(line.points, line.points[1:], strict=False):
            way = b.z - a.z
            share = float(np.clip(way @ (start.z - a.z) / (way @ way), 0, 1))
            near = between(a, b, share) - start.z
            if line.parts == parts and np.max(np.abs(near)) < SAME_ORBIT:
                return True
    return False
