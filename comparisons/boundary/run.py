"""Following the boundaries of a window, and the document of what was followed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ...reference.continuation.bifurcations import DOUBLING, half_period_signs
from ...reference.continuation.curve import correct
from ...reference.continuation.network import CurveStart, Network
from ...reference.continuation.points import BifurcationCurve, CurvePoint, split
from ...reference.errors import EngineError, NoOrbitError, UsageError
from ...reference.orbits import section_row
from ...reference.scene import Array
from ..checks.orbits import engine_tracer
from ..documents import document
from ..queries.environment import versions
from ..queries.query import by_state, floats
from .request import BoundaryRequest

SYMMETRY = "symmetry_breaking"
"""What a period doubling of the map over half a period is."""

UNKNOWN = np.full(2, np.nan)
"""Shift of a curve of the reference."""

NEAR = 0.2
"""How far in the window, and in the sizes of the states, an engine's curve may have shifted."""

SETTINGS = (
    "scene",
    "engine",
    "model",
    "method",
    "step",
    "parameters",
    "x",
    "y",
    "lines",
    "versions",
)
"""What a boundary depends on."""


def kind_of(word: str) -> str:
    """Return the kind of a curve by its word in documents."""
    return DOUBLING if word == SYMMETRY else word


class Boundary:
    """The boundaries of a window, while they are followed and when they have been.

    Attributes
    ----------
    asked : BoundaryRequest
    network : Network
    """

    def __init__(self, asked: BoundaryRequest) -> None:
        self.asked = asked
        self.reference = self.tracer = asked.tracer()
        self.flow = None
        self.symmetric = half_period_signs(asked.equations) is not None
        if asked.steps_per_period is not None:
            pair = engine_tracer(self.reference, asked.setup, asked.steps_per_period)
            self.tracer, self.flow = pair
        self.network = Network(
            self.reference, self.tracer, asked.places, 2 if self.symmetric else 1
        )
        self.orbits = self.engine_orbits = self.missing = 0
        self.shifts: list[list[Array]] = []

    def work(self) -> Iterator[tuple[int, int, str]]:
        """Follow all curves, and see how far those of an engine lie off; yield what is done.

        Raises
        ------
        NoOrbitError
            If no orbit was found on any line.
        EngineError
        """
        for state in self.network.work():
            self.add_shifts()
            yield state
        self.add_shifts()
        problems = self.flow.problems if self.flow is not None else []
        if problems and self.network.missing and not self.network.curves:
            raise EngineError(self.asked.setup.engine.name, f"no curve was found: {problems[-1]}")
        if not self.network.has_orbits:
            x, y = self.asked.x, self.asked.y
            raise NoOrbitError(
                f"no periodic orbit of {self.asked.scene} was found in {x.name} {x.low:g} to "
                f"{x.high:g}, {y.name} {y.low:g} to {y.high:g}; choose another window"
            )

    def add_shifts(self) -> None:
        """See how far curves of an engine lie off of which that is not known yet."""
        for curve in self.network.curves[len(self.shifts) :] if self.flow is not None else ():
            self.shifts.append([self.shift(curve, point) for point in curve.points])

    def shift(self, curve: BifurcationCurve, point: CurvePoint) -> Array:
        """Return by how far an engine's curve lies off the reference's at a point (2,).

        In the axes' units: along the first at the same place on the second, and along the second;
        NaN where the reference has no such bifurcation near.
        """
        own, away = self.reference.curve(curve.kind, curve.parts), np.full(2, np.nan)
        for axis in (0, 1):
            row = np.eye(len(point.z))[-1 - axis]
            solution = correct(own.equations, point.z, row, point.place[1 - axis])
            self.reference.solutions += 1
            if solution is not None and np.max(np.abs(solution.z - point.z)) < NEAR:
                away[axis] = (point.z - solution.z)[-2 + axis]
        return np.asarray(away * self.asked.size)

    def as_json(self) -> dict[str, Any]:
        """Return the ``boundary`` document of docs/json.md."""
        asked, setup = self.asked, self.asked.setup
        units = self.units
        return document(
            "boundary",
            asked,
            engine=setup.engine.name,
            model=setup.model,
            method=setup.integrator.name,
            step=asked.longest_step,
            parameters={
                name: value
                for name, value in setup.case.parameters.as_dict().items()
                if name not in asked.window.names
            },
            x={**vars(asked.x), "unit": units[0]},
            y={**vars(asked.y), "unit": units[1]},
            lines_done=self.network.lines_done,
            orbits=self.orbits + self.reference.solutions,
            engine_orbits=self.engine_orbits + (0 if self.flow is None else self.tracer.solutions),
            curves=[self.curve(i) for i in range(len(self.network.curves))],
            pending=[
                {"kind": self.word(s), "parts": s.parts, "point": self.point(s.point)}
                for s in self.network.starts
            ],
            missing=self.missing + len(self.network.missing),
            versions=versions([setup.engine.name]),
        )

    @property
    def units(self) -> list[str]:
        """Units of the axes."""
        fields = self.asked.equations.parameters.__dataclass_fields__
        return [fields[name].metadata["unit"] or "1" for name in self.asked.window.names]

    def word(self, item: BifurcationCurve | CurveStart) -> str:
        """Return the kind of a curve in documents."""
        odd = item.parts % 2 == 1
        return SYMMETRY if self.symmetric and odd and item.kind == DOUBLING else item.kind

    def curve(self, number: int) -> dict[str, Any]:
        """Return a curve as the document has it."""
        curve = self.network.curves[number]
        is_known = number < len(self.shifts)
        shifts = self.shifts[number] if is_known else [UNKNOWN] * len(curve.points)
        pairs = zip(curve.points, shifts, strict=True)
        return {
            "kind": self.word(curve),
            "parts": curve.parts,
            "begins": curve.ends[0],
            "ends": curve.ends[1],
            "points": [self.point(point, away) for point, away in pairs],
        }

    def point(self, point: CurvePoint, away: Array = UNKNOWN) -> dict[str, Any]:
        """Return a point as the document has it."""
        scale, unit = self.reference.units
        scene, n, size = self.asked.equations, len(scale), self.asked.size
        row = section_row(scene)
        x, y = self.asked.window.low + size * point.place
        state = point.z[:n] * scale
        period = float(point.z[row] * unit) if row is not None else self.period_at(point.place)
        if row is not None:
            state[row] = 0.0
        return {
            "x": x,
            "y": y,
            "x_bound": point.bound[0] * size[0],
            "y_bound": point.bound[1] * size[1],
            "state": floats(by_state(scene, state)),
            "period": period,
            "multipliers": [{"re": value.real, "im": value.imag} for value in point.multipliers],
            "critical": {"re": point.critical.real, "im": point.critical.imag},
            "unstable": point.unstable,
            "direction": point.tangent,
            "shift_x": away[0],
            "shift_y": away[1],
        }

    def period_at(self, place: Any) -> float:
        """Return the period of the drive at a place of the window [s]."""
        return self.reference.guesses(place)[1]

    # Going on with a file ---------------------------------------------------------------------

    def restore(self, before: Mapping[str, Any]) -> None:
        """Take over what a document holds.

        Raises
        ------
        UsageError
            If it is of another boundary.
        """
        now = self.as_json()
        for name in SETTINGS:
            if before[name] != now[name]:
                raise UsageError(
                    f"--output: the file is of another boundary ({name}): name another"
                )
        self.orbits, self.engine_orbits = before["orbits"], before["engine_orbits"]
        self.missing = before["missing"]
        self.network.lines_done = before["lines_done"]
        self.network.has_orbits = before["orbits"] > 0
        for item in before["curves"]:
            points = [self.read_point(item["kind"], stored) for stored in item["points"]]
            ends = item["begins"], item["ends"]
            self.network.curves.append(
                BifurcationCurve(kind_of(item["kind"]), item["parts"], points, ends)
            )
            if self.flow is not None:
                away = [[stored["shift_x"], stored["shift_y"]] for stored in item["points"]]
                self.shifts.append(list(np.array(away, dtype=float)))
        if self.shifts and np.all(np.isnan(self.shifts[-1])):  # the time was up before them
            del self.shifts[-1]
        self.network.starts += [
            CurveStart(
                kind_of(item["kind"]), item["parts"], self.read_point(item["kind"], item["point"])
            )
            for item in before["pending"]
        ]

    def read_point(self, word: str, stored: Mapping[str, Any]) -> CurvePoint:
        """Return a point from a document."""
        scale, unit = self.reference.units
        scene, size = self.asked.equations, self.asked.size
        row = section_row(scene)
        state = np.array([stored["state"][name] for name in scene.state_names]) / scale
        if row is not None:
            state[row] = stored["period"] / unit
        place = (np.array([stored["x"], stored["y"]]) - self.asked.window.low) / size
        multipliers = np.array([complex(v["re"], v["im"]) for v in stored["multipliers"]])
        critical, others = split(kind_of(word), multipliers, row is not None)
        bound = np.array([stored["x_bound"], stored["y_bound"]]) / size
        z = np.concatenate([state, place])
        return CurvePoint(z, np.array(stored["direction"]), multipliers, critical, others, bound)
