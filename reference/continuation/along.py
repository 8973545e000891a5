"""One bifurcation of a periodic orbit, sought along one parameter from those of a case."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..differences import by_complex_step
from ..errors import NoOrbitError
from ..orbits import period_advance, section_row
from ..scene import Array, EquationsOfMotion
from ..solve.single import solve
from .bifurcations import LINE, CurvePoint
from .curve import correct
from .tracing import Tracer

REACH = 0.2
"""How far the parameter may be off that of the case, in its size."""


@dataclass(frozen=True)
class BoundaryAlong:
    """Loss of stability of the orbits of a scene along one parameter.

    The window that curves are followed in is the parameter's reach; its first axis is idle.

    Attributes
    ----------
    scene : EquationsOfMotion
    parameters : Parameters
        Of a case near by.
    kind : str
        Of a bifurcation.
    parameter : str
        What is varied.
    """

    scene: EquationsOfMotion
    parameters: Any
    kind: str
    parameter: str

    where: ClassVar[str] = "in a period"
    """Time that the steps divide, in words."""

    @property
    def here(self) -> float:
        """The parameter at the case."""
        return float(getattr(self.parameters, self.parameter))

    @property
    def unit(self) -> float:
        """Size of the window, in the parameter's unit."""
        return 2 * REACH * abs(self.here)

    def value(self, place: Any) -> Any:
        """Return the parameter at places of the window, 0 to 1."""
        return self.here + self.unit * (place - 0.5)

    @property
    def span(self) -> float:
        """Time [s] of the orbit, its period, which steps divide."""
        tracer, point = self.solution
        section = section_row(self.scene)
        return tracer.units[1] * (1.0 if section is None else float(point.z[section]))

    @property
    def row(self) -> Array:
        """The plane (2 n + 2,) on which the window's idle axis stays."""
        return np.eye(2 * len(self.scene.coordinates) + 2)[-2]

    def tracer(self) -> Tracer:
        """Return the tracer of the orbits of the reference."""

        def at(place: Array) -> Any:
            return self.parameters.replace(**{self.parameter: self.value(place[1])})

        return Tracer(self.scene, at)

    @cached_property
    def solution(self) -> tuple[Tracer, CurvePoint]:
        """Tracer of the orbits, and the point.

        Raises
        ------
        NoOrbitError
            If there is none.
        """
        tracer = self.tracer()
        line, guess = tracer.curve(LINE, 1, 1, 0.5), tracer.starts(np.array([0.0, 0.5]))[0]
        orbit = correct(line.equations, guess, self.row, 0.0, 30)
        curve = tracer.curve(self.kind, 1)
        near = orbit and correct(curve.equations, orbit.z, self.row, 0.0, 30)
        point = None
        if near is not None:
            _, point = tracer.adapt(curve, *tracer.rate(curve, near))
        if point is None or not 0 <= point.place[1] <= 1:
            words = self.kind.replace("_", " ")
            raise NoOrbitError(
                f"{self.scene.name} has no {words} near {self.parameter} = {self.here:g}"
            )
        return tracer, point


MARGIN = 0.01
"""Relative increase of the parameter at which a first motion comes round."""

LONGEST, SAMPLES = 60.0, 4096
"""Longest time of that motion, in time constants of the unstable direction, and its samples."""

ITERATIONS, CLOSED, NUDGE = 20, 1e-13, 1e-5
"""Iterations of the secant method, its last change of the place, and its first."""

ROUGH, NOISE = 1e-6, 1e-7
"""Changes below which a secant tells no slope, and below which runs may scatter."""

STRETCHES, SETTLED = 10, 1e-6
"""Adaptations of the time at most, and the relative change below which it has converged."""

Ends = Callable[[Any, Array], Array]
"""Function of parameters and a state (2 n,) at t = 0 that returns the state a span later."""


class Saddle(NamedTuple):
    """A state of rest with one direction in which motions leave it.

    Attributes
    ----------
    state, away, row : array (2 n,)
        Where it is, the unstable direction (of 1 in the angle that turns), and the left eigenvector
        of that, 1 along it.
    rate, least : float
        Eigenvalue of that, and the largest of the others [1/s].
    """

    state: Array
    away: Array
    row: Array
    rate: float
    least: float


class Root(NamedTuple):
    """Root of a function: the place, its slope, and the last change of the place."""

    place: float
    slope: float
    change: float


@dataclass(frozen=True)
class ConnectionAlong(BoundaryAlong):
    """Homoclinic orbit of a saddle along one parameter.

    Attributes
    ----------
    rest : str
        Name of the saddle among the equilibria of the scene.
    offset : float
        Distance from it at the begin and at the end, in the angle that turns [rad].
    """

    rest: str
    offset: float = 0.01

    where: ClassVar[str] = "along it"

    @cached_property
    def turning(self) -> int:
        """Row of the angle that turns."""
        (name,) = self.scene.rotations_per_period
        return list(self.scene.coordinates).index(name)

    def parameters_at(self, place: float) -> Any:
        """Return the parameters at a place of the window."""
        return self.parameters.replace(**{self.parameter: float(self.value(place))})

    def saddle(self, p: Any) -> Saddle:
        """Return the saddle at given parameters.

        Raises
        ------
        NoOrbitError
            If there is none.
        """
        x = self.scene.state(self.scene.equilibria[self.rest](p))
        rates = self.scene.right_hand_side(p)
        values, right = np.linalg.eig(by_complex_step(lambda state: rates(0.0, state), x)[1])
        order = np.argsort(-values.real)
        if not (values[order[0]].real > 0 > values[order[1]].real):
            raise NoOrbitError(f"{self.rest!r} of {self.scene.name} is no saddle")
        away = right[:, order[0]].real / right[self.turning, order[0]].real
        row = np.linalg.inv(right)[order[0]].real
        both = float(values[order[0]].real), float(values[order[1]].real)
        return Saddle(x, away, row / (row @ away), *both)

    def begin(self, its: Saddle) -> Array:
        """Return the state (2 n,) at which a motion begins, on the unstable direction."""
        return its.state + self.offset * its.away

    def left(self, p: Any, its: Saddle, ends: Ends) -> Array:
        """Return the distance of a motion from its saddle (2 n,), one turn later."""
        return ends(p, self.begin(its)) - its.state - period_advance(self.scene)[:, 0]

    def gap(self, place: float, ends: Ends) -> float:
        """Return the gap along the unstable direction; NaN where there is no motion."""
        p = self.parameters_at(place)
        try:
            its = self.saddle(p)
        except NoOrbitError:
            return np.nan
        return float(its.row @ self.left(p, its, ends))

    def root(self, ends: Ends, place: float, slope: float | None = None) -> Root | None:
        """Return where the gap vanishes, by secants from a place; None where none is near."""
        gap = self.gap(place, ends)
        change = NUDGE if slope is None else -gap / slope
        for _ in range(ITERATIONS):
            before, last, place = gap, abs(change), place + change
            if not 0 <= place <= 1:
                return None
            gap = self.gap(place, ends)
            if slope is None or last > ROUGH:
                slope = (gap - before) / change
            if not np.isfinite(gap) or not slope:
                return None
            change = -gap / slope
            size = abs(change)
            if size < CLOSED or (size < NOISE and size > last / 2):
                return Root(place, slope, max(size, CLOSED))
        return None

    def reference(self, span: float) -> Ends:
        """Return the flow of the equations of motion over a span [s]."""
        return lambda p, x: solve(self.scene, p, x, [span]).states[:, -1]

    def first_span(self) -> float:
        """Return the time [s] in which a motion comes round if the parameter is a little more."""
        p = self.parameters.replace(**{self.parameter: self.here * (1 + MARGIN)})
        its = self.saddle(p)
        times = np.linspace(0.0, LONGEST / its.rate, SAMPLES)[1:]
        angles = solve(self.scene, p, self.begin(its), times).states[self.turning]
        come = np.flatnonzero(angles > its.state[self.turning] + 2 * np.pi - 3 * self.offset)
        if not come.size:
            raise NoOrbitError(f"no motion from the saddle {self.rest!r} comes round")
        return float(times[come[0]])

    @cached_property
    def connection(self) -> tuple[float, Root]:
        """The time [s] after which the motion is as near its saddle as it began, and the root.

        Raises
        ------
        NoOrbitError
            If there is none.
        """
        span, place = self.first_span(), 0.5 + self.here * MARGIN / self.unit
        for _ in range(STRETCHES):
            ends = self.reference(span)
            root = self.root(ends, place)
            if root is None:
                break
            place = root.place
            p = self.parameters_at(place)
            its = self.saddle(p)
            distance = abs(self.left(p, its, ends)[self.turning])
            longer = float(np.log(distance / self.offset) / -its.least)
            if abs(longer) < SETTLED * span:
                return span, root
            span += longer
        raise NoOrbitError(
            f"{self.scene.name} has no homoclinic orbit near {self.parameter} = {self.here:g}"
        )

    @property
    def span(self) -> float:
        """Time [s] from the saddle's unstable direction back to its stable one."""
        return self.connection[0]

    @cached_property
    def solution(self) -> tuple[Any, CurvePoint]:
        """The root of the gap, and the point: its place, and a bound of that.

        Raises
        ------
        NoOrbitError
        """
        span, root = self.connection
        p = self.parameters_at(root.place)
        its = self.saddle(p)
        run = solve(self.scene, p, self.begin(its), [span])
        bound = float(np.abs(its.row) @ run.error_bound) / abs(root.slope) + root.change
        none, z = np.zeros(0), np.array([0.5, root.place])
        return root, CurvePoint(z, np.array([0.0, 1.0]), none, 0j, none, np.array([0.0, bound]))
