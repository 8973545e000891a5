"""Following the boundaries of a window, and the document of what was followed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ...reference.continuation.bifurcations import (
    DOUBLING,
    NEIMARK_SACKER,
    half_period_signs,
)
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
from .request import EQUILIBRIA, ORBITS, BoundaryRequest

SYMMETRY, HOPF = "symmetry_breaking", "hopf"
"""What a period doubling of the map over half a period is, and a Neimark-Sacker point of the flow
about an equilibrium."""

DIGITS = 13
"""Of logarithms of multipliers, which are as many after they were written and read."""

NONE = {ORBITS: "no periodic orbit", EQUILIBRIA: "no equilibrium"}
"""What was not found, by subject."""

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
    "of",
    "versions",
)
"""What a boundary depends on."""


def kind_of(word: str) -> str:
    """Return the kind of a curve by its word in documents."""
    return {SYMMETRY: DOUBLING, HOPF: NEIMARK_SACKER}.get(word, word)


class Boundary:
    """The boundaries of a window, while they are followed and when they have been.

    Attributes
    ----------
    asked : BoundaryRequest
    networks : dict of str to Network
        By subject.
    """

    def __init__(self, asked: BoundaryRequest) -> None:
        self.asked = asked
        self.flow = None
        self.symmetric = half_period_signs(asked.equations) is not None
        self.networks: dict[str, Network] = {}
        for subject in asked.subjects:
            tracer = reference = asked.tracer(subject)
            if asked.steps_per_period is not None:
                tracer, self.flow = engine_tracer(reference, asked.setup, asked.steps_per_period)
            parts = 2 if self.symmetric and subject == ORBITS else 1
            self.networks[subject] = Network(reference, tracer, asked.places, parts)
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
        for number, network in enumerate(self.networks.values()):
            for done, lines, words in network.work():
                self.add_shifts()
                yield done + number * lines, len(self.networks) * lines, words
        self.add_shifts()
        networks, problems = self.networks.values(), self.flow.problems if self.flow else []
        missing = any(network.missing and not network.curves for network in networks)
        if problems and missing:
            raise EngineError(self.asked.setup.engine.name, f"no curve was found: {problems[-1]}")
        if not any(network.has_orbits for network in networks):
            x, y = self.asked.x, self.asked.y
            what = " and ".join(NONE[subject] for subject in self.networks)
            raise NoOrbitError(
                f"{what} of {self.asked.scene} was found in {x.name} {x.low:g} to "
                f"{x.high:g}, {y.name} {y.low:g} to {y.high:g}; choose another window"
            )

    def add_shifts(self) -> None:
        """See how far curves of an engine lie off of which that is not known yet."""
        if self.flow is not None:
            network = self.networks[ORBITS]
            for curve in network.curves[len(self.shifts) :]:
                self.shifts.append([self.shift(network, curve, point) for point in curve.points])

    def shift(self, network: Network, curve: BifurcationCurve, point: CurvePoint) -> Array:
        """Return by how far an engine's curve lies off the reference's at a point (2,).

        In the axes' units: along the first at the same place on the second, and along the second;
        NaN where the reference has no such bifurcation near.
        """
        own, away = network.reference.curve(curve.kind, curve.parts), np.full(2, np.nan)
        for axis in (0, 1):
            row = np.eye(len(point.z))[-1 - axis]
            solution = correct(own.equations, point.z, row, point.place[1 - axis])
            network.reference.solutions += 1
            if solution is not None and np.max(np.abs(solution.z - point.z)) < NEAR:
                away[axis] = (point.z - solution.z)[-2 + axis]
        return np.asarray(away * self.asked.size)

    def as_json(self) -> dict[str, Any]:
        """Return the ``boundary`` document of docs/json.md."""
        asked, setup = self.asked, self.asked.setup
        units, networks = self.units, self.networks.values()
        engines = [network.tracer for network in networks if self.flow is not None]
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
            of=list(self.networks),
            lines_done=sum(network.lines_done for network in networks),
            lines_done_of={name: network.lines_done for name, network in self.networks.items()},
            orbits=self.orbits + sum(network.reference.solutions for network in networks),
            engine_orbits=self.engine_orbits + sum(tracer.solutions for tracer in engines),
            curves=[
                self.curve(subject, curve, number)
                for subject, network in self.networks.items()
                for number, curve in enumerate(network.curves)
            ],
            pending=[
                {
                    "of": subject,
                    "kind": self.word(subject, s),
                    "parts": s.parts,
                    "point": self.point(subject, s.point),
                }
                for subject, network in self.networks.items()
                for s in network.starts
            ],
            missing=self.missing + sum(len(network.missing) for network in networks),
            versions=versions([setup.engine.name]),
        )

    @property
    def units(self) -> list[str]:
        """Units of the axes."""
        fields = self.asked.equations.parameters.__dataclass_fields__
        return [fields[name].metadata["unit"] or "1" for name in self.asked.window.names]

    def word(self, subject: str, item: BifurcationCurve | CurveStart) -> str:
        """Return the kind of a curve in documents."""
        if subject == EQUILIBRIA:
            return HOPF if item.kind == NEIMARK_SACKER else item.kind
        odd = item.parts % 2 == 1
        return SYMMETRY if self.symmetric and odd and item.kind == DOUBLING else item.kind

    def curve(self, subject: str, curve: BifurcationCurve, number: int) -> dict[str, Any]:
        """Return a curve as the document has it, the so many-th of its subject."""
        is_known = number < len(self.shifts)
        shifts = self.shifts[number] if is_known else [UNKNOWN] * len(curve.points)
        pairs = zip(curve.points, shifts, strict=True)
        return {
            "of": subject,
            "kind": self.word(subject, curve),
            "parts": curve.parts,
            "begins": curve.ends[0],
            "ends": curve.ends[1],
            "points": [self.point(subject, point, away) for point, away in pairs],
        }

    def point(self, subject: str, point: CurvePoint, away: Array = UNKNOWN) -> dict[str, Any]:
        """Return a point as the document has it."""
        tracer = self.networks[subject].reference
        scale, unit = tracer.units
        scene, n, size = self.asked.equations, len(scale), self.asked.size
        x, y = self.asked.window.low + size * point.place
        state, period, row = point.z[:n] * scale, None, section_row(scene)
        values, critical = point.multipliers, point.critical
        if subject == EQUILIBRIA:
            values, critical = (np.log(v).round(DIGITS) / unit for v in (values, critical))
        elif row is not None:
            state[row], period = 0.0, float(point.z[row] * unit)
        else:
            period = tracer.guesses(point.place)[1]
        numbers = [{"re": value.real, "im": value.imag} for value in values]
        return {
            "x": x,
            "y": y,
            "x_bound": point.bound[0] * size[0],
            "y_bound": point.bound[1] * size[1],
            "state": floats(by_state(scene, state)),
            "period": period,
            "multipliers": numbers if subject == ORBITS else [],
            "eigenvalues": numbers if subject == EQUILIBRIA else [],
            "critical": {"re": critical.real, "im": critical.imag},
            "unstable": point.unstable,
            "direction": point.tangent,
            "shift_x": away[0],
            "shift_y": away[1],
        }

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
        for subject, network in self.networks.items():
            network.lines_done = before["lines_done_of"][subject]
            network.has_orbits = before["orbits"] > 0
        for item in before["curves"]:
            subject = item["of"]
            points = [self.read_point(subject, item["kind"], stored) for stored in item["points"]]
            ends = item["begins"], item["ends"]
            self.networks[subject].curves.append(
                BifurcationCurve(kind_of(item["kind"]), item["parts"], points, ends)
            )
            if self.flow is not None:
                away = [[stored["shift_x"], stored["shift_y"]] for stored in item["points"]]
                self.shifts.append(list(np.array(away, dtype=float)))
        if self.shifts and np.all(np.isnan(self.shifts[-1])):  # the time was up before them
            del self.shifts[-1]
        for item in before["pending"]:
            point = self.read_point(item["of"], item["kind"], item["point"])
            start = CurveStart(kind_of(item["kind"]), item["parts"], point)
            self.networks[item["of"]].starts.append(start)

    def read_point(self, subject: str, word: str, stored: Mapping[str, Any]) -> CurvePoint:
        """Return a point from a document."""
        scale, unit = self.networks[subject].reference.units
        scene, size = self.asked.equations, self.asked.size
        row = section_row(scene) if subject == ORBITS else None
        state = np.array([stored["state"][name] for name in scene.state_names]) / scale
        if row is not None:
            state[row] = stored["period"] / unit
        place = (np.array([stored["x"], stored["y"]]) - self.asked.window.low) / size
        name = "multipliers" if subject == ORBITS else "eigenvalues"
        multipliers = np.array([complex(v["re"], v["im"]) for v in stored[name]])
        if subject == EQUILIBRIA:
            multipliers = np.exp(unit * multipliers)
        critical, others = split(kind_of(word), multipliers, row is not None)
        bound = np.array([stored["x_bound"], stored["y_bound"]]) / size
        z = np.concatenate([state, place])
        return CurvePoint(z, np.array(stored["direction"]), multipliers, critical, others, bound)
