"""Following the boundaries of a window, and the document of what was followed."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ...reference.continuation.bifurcations import (
    DOUBLING,
    NEIMARK_SACKER,
    BifurcationCurve,
    CurvePoint,
    half_period_signs,
    split,
)
from ...reference.continuation.network import (
    CurveSearch,
    CurveStart,
    Executor,
    Line,
    Network,
    SearchOutcome,
    Task,
)
from ...reference.errors import EngineError, NoOrbitError, UsageError
from ...reference.orbits import section_row
from ...reference.scene import Array
from ..checks.orbits import engine_tracer
from ..documents import document
from ..engines.isolation import isolated
from ..queries.environment import versions
from ..queries.query import by_state, floats
from .request import EQUILIBRIA, ORBITS, BoundaryRequest

SYMMETRY, HOPF = "symmetry_breaking", "hopf"
"""Names of a period doubling of the map over half a period, and of a Neimark-Sacker point of the
flow about an equilibrium."""

DIGITS = 13
"""Digits of logarithms of multipliers, the same after they were written and read."""

NONE = {ORBITS: "no periodic orbit", EQUILIBRIA: "no equilibrium"}
"""Words for a subject without any."""

UNKNOWN = np.full(2, np.nan)
"""Shift of a curve of the reference."""

SETTINGS = (
    "scene", "engine", "model", "method", "step", "parameters", "x", "y", "lines", "of", "versions",
)  # fmt: skip
"""Fields of a document on which a boundary depends."""


Perform = Callable[[Task], SearchOutcome]


def kind_of(word: str) -> str:
    """Return the kind of a curve by its word in documents."""
    return {SYMMETRY: DOUBLING, HOPF: NEIMARK_SACKER}.get(word, word)


def perform(request: BoundaryRequest, subject: str, task: Task) -> SearchOutcome:
    """Do a part of the work on the curves of a subject; it depends on nothing else."""
    reference = tracer = request.tracer(subject)
    flow = None
    if request.steps_per_period is not None:
        tracer, flow = engine_tracer(reference, request.middle, request.steps_per_period)
    search = CurveSearch(reference, tracer)
    task(search)
    search.outcome.orbits = reference.solutions
    if flow is not None:
        search.outcome.engine_orbits = tracer.solutions
        search.outcome.problems = flow.problems[-1:]
    return search.outcome


def executor(perform: Perform, workers: int) -> Executor:
    """Return a function that gives the outcome of the first of several tasks, or raises its error.

    All lines are begun together, then as many curves as there are processes; what turns out to be
    needless is dropped. An outcome does not depend on the number of processes.
    """
    outcomes: dict[bytes, Any] = {}

    def outcome_of_first(tasks: Sequence[Task]) -> SearchOutcome:
        if workers == 1:
            return perform(tasks[0])
        lines = [one for one in tasks if one.func is CurveSearch.look_along]
        calls = [partial(perform, one) for one in lines or tasks[:workers]]
        keys = [pickle.dumps(call) for call in calls]
        if keys[0] not in outcomes:
            new = [i for i, key in enumerate(keys) if key not in outcomes]
            for place, outcome in isolated([calls[i] for i in new], workers):
                outcomes[keys[new[place]]] = outcome
        first: SearchOutcome | EngineError = outcomes.pop(keys[0])
        if isinstance(first, EngineError):
            raise first
        return first

    return outcome_of_first


class Boundary:
    """The boundaries of a window, while they are followed and when they have been.

    Attributes
    ----------
    request : BoundaryRequest
    networks : dict of str to Network
        One of each subject.
    """

    def __init__(self, request: BoundaryRequest) -> None:
        self.request = request
        self.symmetric = half_period_signs(request.equations) is not None
        self.tracers = {subject: request.tracer(subject) for subject in request.subjects}
        self.near = list(request.near)
        self.networks = {
            subject: Network(self.lines, 2 if self.symmetric and subject == ORBITS else 1)
            for subject in request.subjects
        }

    @property
    def lines(self) -> list[Line]:
        """Lines that are looked along: those of the window, and those through places."""
        low, size = self.request.window.low, self.request.size
        places = (np.reshape(self.near, (-1, 2)) - low) / size
        across = np.linspace(0, 1, self.request.lines).tolist()
        return [*map(Line, across), *(Line(*place) for place in places.tolist())]

    def work(self, workers: int = 1) -> Iterator[tuple[int, int, str]]:
        """Follow all curves, in a number of processes; yield the progress.

        Raises
        ------
        NoOrbitError
            If no orbit was found on any line.
        EngineError
        """
        before = 0
        for number, (subject, network) in enumerate(self.networks.items()):
            execute = executor(partial(perform, replace(self.request), subject), workers)
            ahead = len(self.networks) - number - 1
            done = 0
            for done, total, words in network.work(execute):
                yield before + done, before + total + ahead * len(self.lines), words
            before += done
        networks = self.networks.values()
        problems = [problem for network in networks for problem in network.total.problems]
        missing = any(network.missing and not network.curves for network in networks)
        if problems and missing:
            raise EngineError(
                self.request.middle.engine.name, f"no curve was found: {problems[-1]}"
            )
        if not any(network.total.has_orbits for network in networks):
            x, y = self.request.x, self.request.y
            what = " and ".join(NONE[subject] for subject in self.networks)
            raise NoOrbitError(
                f"{what} of {self.request.scene} was found in {x.name} {x.low:g} to "
                f"{x.high:g}, {y.name} {y.low:g} to {y.high:g}; choose another window"
            )

    def as_json(self) -> dict[str, Any]:
        """Return the ``boundary`` document of docs/json.md."""
        request, setup = self.request, self.request.middle
        units, networks = self.units, self.networks.values()
        return document(
            "boundary",
            request,
            engine=setup.engine.name,
            model=setup.model,
            method=setup.integrator.name,
            step=request.longest_step,
            parameters={
                name: value
                for name, value in setup.case.parameters.as_dict().items()
                if name not in request.window.names
            },
            x={**vars(request.x), "unit": units[0]},
            y={**vars(request.y), "unit": units[1]},
            of=list(self.networks),
            near=[{"x": x, "y": y} for x, y in self.near],
            lines_done=sum(network.lines_done for network in networks),
            lines_done_of={name: network.lines_done for name, network in self.networks.items()},
            orbits=sum(network.total.orbits for network in networks),
            engine_orbits=sum(network.total.engine_orbits for network in networks),
            curves=[
                self.curve(subject, curve)
                for subject, network in self.networks.items()
                for curve in network.curves
            ],
            pending=[
                self.start(subject, start)
                for subject, network in self.networks.items()
                for start in network.starts
            ],
            doublings=[
                self.start(subject, start)
                for subject, network in self.networks.items()
                for start in network.doublings
            ],
            missing=sum(network.missing for network in networks),
            versions=versions([setup.engine.name]),
        )

    def start(self, subject: str, start: CurveStart) -> dict[str, Any]:
        """Return where a curve starts, as the document has it."""
        return {
            "of": subject,
            "kind": self.word(subject, start),
            "parts": start.parts,
            "point": self.point(subject, start.point),
            "unknowns": start.point.z,
            "begins": start.begins or None,
        }

    @property
    def units(self) -> list[str]:
        """Units of the axes."""
        return list(map(self.request.equations.parameters.unit_of, self.request.window.names))

    def word(self, subject: str, item: BifurcationCurve | CurveStart) -> str:
        """Return the kind of a curve in documents."""
        if subject == EQUILIBRIA:
            return HOPF if item.kind == NEIMARK_SACKER else item.kind
        odd = item.parts % 2 == 1
        return SYMMETRY if self.symmetric and odd and item.kind == DOUBLING else item.kind

    def curve(self, subject: str, curve: BifurcationCurve) -> dict[str, Any]:
        """Return a curve as the document has it."""
        shifts = [away * self.request.size for away in curve.shifts]
        pairs = zip(curve.points, shifts or [UNKNOWN] * len(curve.points), strict=True)
        return {
            "of": subject,
            "kind": self.word(subject, curve),
            "parts": curve.parts,
            "doubled": curve.doubled,
            "begins": curve.ends[0],
            "ends": curve.ends[1],
            "points": [self.point(subject, point, away) for point, away in pairs],
        }

    def point(self, subject: str, point: CurvePoint, away: Array = UNKNOWN) -> dict[str, Any]:
        """Return a point as the document has it."""
        scale, unit = self.tracers[subject].units
        scene, n, size = self.request.equations, len(scale), self.request.size
        x, y = self.request.window.low + size * point.place
        state, period, row = point.z[:n] * scale, None, section_row(scene)
        values, critical = point.multipliers, point.critical
        if subject == EQUILIBRIA:
            values, critical = (np.log(v).round(DIGITS) / unit for v in (values, critical))
        elif row is not None:
            state[row], period = 0.0, float(point.z[row] * unit)
        else:
            period = self.tracers[subject].guess(point.place)[1]
        numbers = [{"re": value.real, "im": value.imag} for value in values]
        across, (along_x, along_y) = point.bound * size, np.abs(point.tangent[-2:] * size)
        slope = np.clip(along_y, 1e-100, None) / np.clip(along_x, 1e-100, None)
        return {
            "x": x,
            "y": y,
            "x_bound": across[0] + across[1] / slope,
            "y_bound": across[1] + across[0] * slope,
            "x_bound_across": across[0],
            "y_bound_across": across[1],
            "state": floats(by_state(scene, state)),
            "period": period,
            "multipliers": numbers if subject == ORBITS else [],
            "eigenvalues": numbers if subject == EQUILIBRIA else [],
            "critical": {"re": critical.real, "im": critical.imag},
            "unstable": point.unstable,
            "direction": point.tangent,
            "stable_side": list(point.side) if np.all(np.isfinite(point.side)) else None,
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
        first = next(iter(self.networks.values()))
        first.total.orbits, first.total.engine_orbits = before["orbits"], before["engine_orbits"]
        first.missing = before["missing"]
        looked_near = [(place["x"], place["y"]) for place in before["near"]]
        self.near = [*looked_near, *(place for place in self.near if place not in looked_near)]
        for subject, network in self.networks.items():
            network.lines, network.lines_done = self.lines, before["lines_done_of"][subject]
            network.total.has_orbits = before["orbits"] > 0
        for item in before["curves"]:
            points = [self.read_point(item, stored) for stored in item["points"]]
            shifts = []
            if self.request.steps_per_period is not None:
                away = [[stored["shift_x"], stored["shift_y"]] for stored in item["points"]]
                shifts = list(np.array(away, dtype=float) / self.request.size)
            ends = item["begins"], item["ends"]
            its = kind_of(item["kind"]), item["parts"], points, ends, item["doubled"], shifts
            self.networks[item["of"]].curves.append(BifurcationCurve(*its))
        for name in ("pending", "doublings"):
            for item in before[name]:
                point = replace(self.read_point(item, item["point"]), z=np.array(item["unknowns"]))
                start = CurveStart(
                    kind_of(item["kind"]), item["parts"], point, item["begins"] or ""
                )
                network = self.networks[item["of"]]
                (network.starts if name == "pending" else network.doublings).append(start)

    def read_point(self, item: Mapping[str, Any], stored: Mapping[str, Any]) -> CurvePoint:
        """Return a point from a document, of a curve or of where one starts."""
        subject = item["of"]
        scale, unit = self.tracers[subject].units
        scene, size = self.request.equations, self.request.size
        row = section_row(scene) if subject == ORBITS else None
        state = np.array([stored["state"][name] for name in scene.state_names]) / scale
        if row is not None:
            state[row] = stored["period"] / unit
        place = (np.array([stored["x"], stored["y"]]) - self.request.window.low) / size
        name = "multipliers" if subject == ORBITS else "eigenvalues"
        multipliers = np.array([complex(v["re"], v["im"]) for v in stored[name]])
        if subject == EQUILIBRIA:
            multipliers = np.exp(unit * multipliers)
        critical, others = split(kind_of(item["kind"]), multipliers, row is not None)
        bound = np.array([stored["x_bound_across"], stored["y_bound_across"]]) / size
        z = np.concatenate([state, place])
        side = np.array(stored["stable_side"] or (np.nan, np.nan))
        way = np.array(stored["direction"])
        return CurvePoint(z, way, multipliers, critical, others, bound, side)
