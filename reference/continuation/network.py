"""Networks of bifurcation curves: where they start, and how they are followed.

Orbits are followed along lines through a window of two parameters. Where multipliers cross the
unit circle a bifurcation begins, which is then followed through the window as a curve; where the
symmetry or the period of an orbit breaks, what parts from it is followed along the line, too.
Where a second bifurcation comes in, the curve ends and that of the second begins.

Each line and each curve is a task of its own, which knows of no other; what they lead to is put
together in one order, so that a network does not depend on where and when tasks are done.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from ..orbits import descending, section_row
from ..scene import Array
from .bifurcations import (
    DOUBLING,
    LINE,
    BifurcationCurve,
    CurvePoint,
    OrbitCurve,
    crossings,
    split,
)
from .curve import OPTIONS, between, correct
from .tracing import Tracer, is_inside, leaves

ALONG = OPTIONS._replace(ds=0.15)
"""Steps along lines, which are longer at first than those along curves."""


class CurveStart(NamedTuple):
    """A bifurcation from which a curve is to be followed.

    Attributes
    ----------
    kind : str
    parts : int
    point : CurvePoint
        On the curve; or on another that ends where this one begins.
    begins : str
        Why the curve ends there, empty where it goes on both ways.
    """

    kind: str
    parts: int
    point: CurvePoint
    begins: str = ""

    @property
    def may_bound(self) -> bool:
        """Whether the curve may bound stability."""
        return bool(self.begins) or not self.point.unstable


class Line(NamedTuple):
    """A line of the window on which the first parameter stays.

    Attributes
    ----------
    value : float
        Where, 0 to 1.
    share : float or None
        Where on it the scene's orbit is looked for with all means; None takes those of the options,
        and the first guess alone.
    """

    value: float
    share: float | None = None


@dataclass
class SearchOutcome:
    """Result of a task.

    Attributes
    ----------
    starts : list of CurveStart
        What is to be followed from there.
    curve : BifurcationCurve or None
    limits : list of BifurcationCurve
        On which orbits end without a bifurcation.
    missing : bool
        Whether the tracer has no bifurcation near that from which a curve was to be followed.
    has_orbits : bool
    orbits, engine_orbits : int
        That the reference and, if it is another, the tracer have solved for.
    problems : list of str
        Why runs of an engine have failed.
    """

    starts: list[CurveStart] = field(default_factory=list)
    curve: BifurcationCurve | None = None
    limits: list[BifurcationCurve] = field(default_factory=list)
    missing: bool = False
    has_orbits: bool = False
    orbits: int = 0
    engine_orbits: int = 0
    problems: list[str] = field(default_factory=list)


@dataclass
class CurveSearch:
    """A task: one line to be scanned, or one curve to be followed.

    Attributes
    ----------
    reference : Tracer
        Looks for bifurcations along lines.
    tracer : Tracer
        Follows them: the same, or an engine's.
    outcome : SearchOutcome
    """

    reference: Tracer
    tracer: Tracer
    outcome: SearchOutcome = field(default_factory=SearchOutcome)

    # Along lines ------------------------------------------------------------------------------

    def look_along(self, line: Line) -> None:
        """Follow orbits along a line of the window, and gather where curves start.

        With the first line come the curves on which orbits end, if there are any.
        """
        if line == Line(0.0):
            self.outcome.limits = self.reference.least_curves()
        seen: list[BifurcationCurve] = []
        for share in OPTIONS.shares if line.share is None else (line.share,):
            place = np.array([line.value, share])
            if line.share is None:
                starts = [(1, guess) for guess in self.reference.starts(place)]
            else:
                starts = self.reference.orbits_at(place)
            for parts, guess in starts:
                curve, row = self.reference.curve(LINE, parts, 0, line.value), unit_rows(guess)[1]
                solution = correct(curve.equations, guess, row, share, 30)
                if solution is None or not np.all(np.abs(solution.z - guess) < 1):
                    continue
                start = self.reference.rate(curve, solution)[0]
                self.outcome.has_orbits = True
                if not is_known(start, parts, seen):
                    for sign in (1, -1):
                        self.branch(curve, replace(start, tangent=sign * start.tangent), seen)

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
            old, new = crossings(before.others), crossings(point.others)
            for kind, a in old.items():
                if a * new[kind] < 0:
                    self.meet(line, kind, between(before, point, a / (a - new[kind])))

    def meet(self, line: OrbitCurve, kind: str, guess: Array) -> None:
        """Keep a bifurcation near a point of a line."""
        parts, (row, along) = line.family.parts, unit_rows(guess)
        for own in self.reference.curves_at(kind, parts, guess):
            solution = correct(own.equations, guess, row, line.value, along=along)
            if solution is None or np.any(np.abs(solution.z - guess) > OPTIONS.astray):
                continue
            point = self.reference.rate(own, solution)[0]
            if is_inside(point.place) and self.reference.is_proper(own, point):
                self.outcome.starts.append(CurveStart(own.kind, parts, point))
                return

    def switch(self, parts: int, at: CurvePoint) -> None:
        """Follow the orbits of twice the length that part from one along its line."""
        _, _, monodromy = self.reference.family(parts).evaluate(at.z[:, None])
        values, vectors = np.linalg.eig(monodromy[0])
        away = vectors[:, np.argmin(np.abs(values + 1))].real
        row = np.append(away / np.linalg.norm(away), [0.0, 0.0])
        line = self.reference.curve(LINE, 2 * parts, 0, float(at.place[0]))
        guess = at.z + OPTIONS.parting * row
        solution = correct(line.equations, guess, row, float(row @ guess))
        if solution is not None:
            self.branch(line, self.reference.rate(line, solution)[0], [])

    # Across the window ------------------------------------------------------------------------

    def follow(self, start: CurveStart) -> None:
        """Follow a curve from a point in both directions, or from where it begins."""
        curve = self.tracer.curves_at(*start[:2], start.point.z)[-1]
        curve, point = self.first(curve, start)
        if point is None:
            self.outcome.missing = not start.begins
            return
        ways = [point, replace(point, tangent=-point.tangent)]
        if start.begins:
            ways = [way for way in ways if self.goes_on(curve, way)]
        if not ways:
            return
        points, end = self.one_way(curve, ways[0], start.begins)
        begin = start.begins
        if end == "closed":
            points, begin = [*points, point], end
        elif len(ways) > 1:
            back, begin = self.one_way(curve, ways[1], start.begins)
            points = [replace(item, tangent=-item.tangent) for item in back[:0:-1]] + points
        if len(points) > 1:
            shifts = []
            if self.tracer is not self.reference:
                shifts = [self.shift(start, item) for item in points]
            self.outcome.curve = BifurcationCurve(
                start.kind, start.parts, points, (begin, end), shifts=shifts
            )

    def first(self, curve: OrbitCurve, start: CurveStart) -> tuple[OrbitCurve, CurvePoint | None]:
        """Return the first point of a curve, None if there is none near; and the curve itself."""
        at, rows, most = start.point, [start.point.tangent], OPTIONS.astray
        if start.begins:
            rows, most = [*rows, *unit_rows(at.z)], OPTIONS.parting
        elif self.tracer is self.reference and np.max(at.bound) < OPTIONS.exact:
            return curve, at
        for row in rows:
            solution = correct(curve.equations, at.z, row, float(row @ at.z))
            if solution is not None and np.max(np.abs(solution.z - at.z)) < most:
                return self.tracer.adapt(curve, *self.tracer.rate(curve, solution))
        return curve, None

    def goes_on(self, curve: OrbitCurve, point: CurvePoint) -> bool:
        """Return True if a curve bounds stability just ahead of its beginning."""
        ahead = point.z + OPTIONS.beside * point.tangent
        _, _, monodromy = curve.values(curve.family, ahead[:, None])
        if not np.all(np.isfinite(monodromy)):
            return False
        values = descending(np.linalg.eigvals(monodromy[0]))
        parts = split(curve.kind, values, section_row(self.tracer.scene) is not None)
        guess = replace(point, z=ahead, critical=parts[0], others=parts[1])
        return not guess.unstable and self.tracer.is_proper(curve, guess)

    def one_way(
        self, curve: OrbitCurve, start: CurvePoint, begins: str
    ) -> tuple[list[CurvePoint], str]:
        """Return the points of a curve in one direction, with the first, and why it ends."""
        if leaves(start):
            return [start], "window"
        steps = list(self.tracer.trace(curve, start, OPTIONS, begins))
        points = [start, *(point for point, _ in steps if point)]
        why = steps[-1][1]
        if why.startswith("with_"):
            beyond, begins = why.removeprefix("with_"), f"with_{curve.kind}"
            self.outcome.starts.append(CurveStart(beyond, curve.family.parts, points[-1], begins))
        return points, why

    def shift(self, start: CurveStart, point: CurvePoint) -> Array:
        """Return by how far a point of a curve lies off the reference's curve (2,), in the window.

        Along the first axis at the same place on the second, and along the second; NaN where the
        reference has no such bifurcation near.
        """
        away = np.full(2, np.nan)
        for axis, row in enumerate(unit_rows(point.z)[::-1]):
            own = self.reference.curve(*start[:2])
            solution = correct(own.equations, point.z, row, point.place[1 - axis])
            if solution is None:
                continue
            true = self.reference.adapt(own, *self.reference.rate(own, solution), row)[1]
            if true is not None and np.max(np.abs(true.z - point.z)) < OPTIONS.near:
                away[axis] = (point.z - true.z)[-2 + axis]
        return away


Task = partial[None]
"""A part of the work on a network: a method of `CurveSearch` with its argument."""


def following(starts: Iterable[CurveStart]) -> list[Task]:
    """Return the tasks of following curves from where they begin."""
    return [partial(CurveSearch.follow, start=one) for one in starts]


Executor = Callable[[Sequence[Task]], SearchOutcome]
"""Function of tasks that returns the result of the first; the others will probably follow."""


@dataclass
class Network:
    """The bifurcation curves of a window.

    Attributes
    ----------
    lines : list of Line
    most_parts : int
        (Half) periods after which orbits close at most.
    lines_done : int
    starts : list of CurveStart
        What is still to be followed.
    doublings : list of CurveStart
        Period doublings on lines, from which orbits of twice the length part that are still to be
        followed along the line.
    curves : list of BifurcationCurve
    total : SearchOutcome
        What all tasks have counted.
    missing : int
        Bifurcations near which the tracer has none.
    """

    lines: list[Line]
    most_parts: int
    lines_done: int = 0
    starts: list[CurveStart] = field(default_factory=list)
    doublings: list[CurveStart] = field(default_factory=list)
    curves: list[BifurcationCurve] = field(default_factory=list)
    total: SearchOutcome = field(default_factory=SearchOutcome)
    missing: int = 0

    def work(self, execute: Executor) -> Iterator[tuple[int, int, str]]:
        """Scan the lines and follow the curves; yield the work done, the whole work, and words."""
        while tasks := self.tasks():
            self.add(execute(tasks))
            self.drop_known()
            done = self.lines_done + len(self.curves)
            yield done, done + len(self.tasks()), f"lines and curves, {len(self.curves)} curves"

    def tasks(self) -> list[Task]:
        """Return the remaining tasks; the first may make some of the others needless.

        All lines, then the curves that begin on them, then what parts from these. After the first
        curve those of other kinds: none of them is the same.
        """
        starts = [*filter(self.is_open, self.starts)]
        starts[1:] = sorted(starts[1:], key=lambda one: one[:2] == starts[0][:2])
        return [
            *(partial(CurveSearch.look_along, line=one) for one in self.lines[self.lines_done :]),
            *following(starts),
            *(partial(CurveSearch.switch, parts=one.parts, at=one.point) for one in self.doublings),
        ]

    def add(self, outcome: SearchOutcome) -> None:
        """Add what the first of the tasks has led to."""
        self.missing += outcome.missing
        self.total.has_orbits |= outcome.has_orbits
        self.total.orbits += outcome.orbits
        self.total.engine_orbits += outcome.engine_orbits
        self.total.problems += outcome.problems
        met = [one for one in outcome.starts if not one.begins]
        if self.lines_done < len(self.lines):
            self.lines_done += 1
            self.curves += outcome.limits
        elif self.starts:
            start, curve = self.starts.pop(0), outcome.curve
            if curve and start.begins:  # the first point may lie on other curves as well
                start = start._replace(point=curve.points[1], begins="")
                curve = curve if self.curve_through(start) is None else None
                met += [start] if curve else []
            self.curves += [curve] if curve else []
        else:
            curve = self.curve_through(self.doublings.pop(0))
            if curve is not None:
                curve.doubled = any(self.curve_through(one) is None for one in outcome.starts)
        self.starts += outcome.starts
        self.doublings += [
            one for one in met if one.kind == DOUBLING and 2 * one.parts <= self.most_parts
        ]

    def drop_known(self) -> None:
        """Drop the next tasks whose result is known already."""
        if self.lines_done == len(self.lines):
            self.starts = [*filter(self.is_open, self.starts)]
        if not self.starts:
            self.doublings = [*filter(self.is_single, self.doublings)]

    def is_single(self, start: CurveStart) -> bool:
        """Return True if no bifurcations are known of the orbits that branch off a curve."""
        curve = self.curve_through(start)
        return curve is None or not curve.doubled

    def is_open(self, start: CurveStart) -> bool:
        """Return True if a bifurcation bounds stability and is on no curve yet."""
        return start.may_bound and self.curve_through(start) is None

    def curve_through(self, start: CurveStart) -> BifurcationCurve | None:
        """Return the curve that a bifurcation is on already, or None."""
        for curve in self.curves:
            away = curve.distance(start.point.place)
            if (curve.kind, curve.parts) == start[:2] and away < OPTIONS.same:
                return curve
        return None


def unit_rows(z: Array) -> Array:
    """Return the planes (2, 2 n + 2) on which either parameter stays."""
    return np.eye(len(z))[-2:]


def is_known(start: CurvePoint, parts: int, lines: list[BifurcationCurve]) -> bool:
    """Return True if an orbit lies on a line that was followed."""
    for line in lines:
        for a, b in zip(line.points, line.points[1:], strict=False):
            way = b.z - a.z
            share = float(np.clip(way @ (start.z - a.z) / (way @ way), 0, 1))
            near = between(a, b, share) - start.z
            if line.parts == parts and np.max(np.abs(near)) < OPTIONS.same_orbit:
                return True
    return False
