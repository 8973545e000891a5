"""``mbcheck tradeoff``: all series, what to choose, and the least that a scene requires."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

from ...reference import SCENES
from ...reference.errors import EngineError, UsageError
from ..documents import document
from ..engines.isolation import MEMORY, isolated
from ..engines.registry import resolve_selection
from ..queries.environment import versions
from . import minimal, stability
from .minimal import Minimal
from .series import MODEL, ROUND_OFF, TARGETS, Cost, Point, StepSeries
from .stability import BoundaryShift
from .sweep import beside, measure, settings_text, sweeps

NOISE = 1.2
"""Median times that differ by no more than this factor cost about the same."""


@dataclass(frozen=True)
class Choice:
    """The cheapest setting of an engine that meets a target, or why there is none.

    Attributes
    ----------
    scene, case, engine : str
    target : float
        Relative error that is allowed.
    model, method : str or None
        None where no setting meets the target.
    settings : mapping of str to float
        Options and segments that are not at their default.
    step : float or None
        [s]
    error : float or None
        Measured; the least that was, where none meets the target.
    cost : Cost or None
    limit : str
        What limits the error there.
    margin : float or None
        Longest stable step by theory over the step; None where no step is unstable, or no
        theory is known.
    longest : float or None
        Longest step of the sweep that this method survived with an error below 1, over the step.
    """

    scene: str
    case: str
    engine: str
    target: float
    model: str | None = None
    method: str | None = None
    settings: Mapping[str, float] | None = None
    step: float | None = None
    error: float | None = None
    cost: Cost | None = None
    limit: str = ""
    margin: float | None = None
    longest: float | None = None

    @property
    def met(self) -> bool:
        """Whether the target is met."""
        return self.method is not None


def pareto(series: Sequence[StepSeries]) -> list[tuple[StepSeries, Point]]:
    """Return the points that none beats in both error and wall time, cheapest first."""
    candidates = [
        (point.cost.seconds, point.error, one, point)
        for one in series
        for point in one.points
        if point.cost is not None and point.error is not None and point.error < 1
    ]
    front: list[tuple[StepSeries, Point]] = []
    least = float("inf")
    for _, error, one, point in sorted(candidates, key=lambda item: item[:2]):
        if error < least:
            front.append((one, point))
            least = error
    return front


def choose(series: Sequence[StepSeries], target: float) -> list[Choice]:
    """Return a choice for each scene and engine of the series."""
    pairs = dict.fromkeys((one.scene, one.case, one.engine) for one in series)
    return [choose_one(*pair, series=series, target=target) for pair in pairs]


def choose_one(
    scene: str, case: str, engine: str, series: Sequence[StepSeries], target: float
) -> Choice:
    """Return the cheapest setting of one engine for a scene.

    Of settings that cost about the same, the one with the fewest options set, then the most
    accurate: noise of a clock is no reason to prefer one.
    """
    none = partial(Choice, scene, case, engine, target)
    mine = [
        Candidate(one, point, point.error, point.cost, steady(one.points[place:], target))
        for one in series
        if (one.scene, one.engine) == (scene, engine)
        for place, point in enumerate(one.points)
        if point.error is not None and point.cost is not None
    ]
    if not mine:
        return none(limit="no run came to an end")
    good = [item for item in mine if item.steady]
    if not good:
        best = min(mine, key=lambda item: item.error)
        words = [best.series.model, best.series.method, settings_text(best.series.settings)]
        return none(error=best.error, limit=f"{best.point.limit} of {' '.join(words).strip()}")
    cheapest = min(good, key=lambda item: item.cost.seconds)
    alike = [item for item in good if item.cost.seconds <= NOISE * cheapest.cost.seconds]
    one, point, *_ = min(alike, key=lambda item: (len(item.series.settings), item.error))
    survived = max(item.step for item in one.points if item.error is not None and item.error < 1)
    return none(
        model=one.model,
        method=one.method,
        settings=one.settings,
        step=point.step,
        error=point.error,
        cost=point.cost,
        limit=point.limit,
        margin=None if one.stable_step is None else one.stable_step / point.step,
        longest=survived / point.step,
    )


class Candidate(NamedTuple):
    """A setting that may be chosen; ``steady`` if it meets the target, not by chance."""

    series: StepSeries
    point: Point
    error: float
    cost: Cost
    steady: bool


def steady(points: Sequence[Point], target: float) -> bool:
    """Return whether the first of some points meets a target, and the next, with half the step.

    The last one has no next: it has to be at its floor.
    """
    if len(points) == 1 and points[0].label not in (MODEL, ROUND_OFF):
        return False
    return all(point.error is not None and point.error <= target for point in points[:2])


LIMIT = 300.0
"""Time limit of a series, or of a piece of what is required [s]."""

Progress = Callable[[int, int, str], None]


@dataclass
class Tradeoff:
    """What accuracy costs; filled by `work`.

    Attributes
    ----------
    targets : tuple of float
    asked_scenes, engines : tuple of str
    series : list of Series
    parts : list of Minimal
        The least that the scenes require.
    stability : list of BoundaryShift
        What steps cost in stability.
    failures : list of str
        What came to nothing, and why.
    """

    targets: tuple[float, ...]
    asked_scenes: tuple[str, ...]
    engines: tuple[str, ...]
    series: list[StepSeries] = field(default_factory=list)
    parts: list[Minimal] = field(default_factory=list)
    stability: list[BoundaryShift] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)

    @classmethod
    def asked(
        cls, scenes: Sequence[str], engines: Sequence[str], targets: Sequence[float]
    ) -> Tradeoff:
        """Return what is asked for, to be filled by `work`; see `tradeoff`."""
        return cls(valid_targets(targets), *resolve_selection(scenes, engines))

    def work(self) -> Iterator[tuple[int, int, str]]:
        """Measure one piece after the other, each in a process of its own; tell how far it is.

        One at a time: they are timed.
        """
        wanted = sweeps(self.asked_scenes, self.engines)
        pieces: list[tuple[str, Callable[[], StepSeries | Minimal | BoundaryShift]]] = [
            *((one.name, partial(measure, one)) for one in wanted),
            *minimal.tasks(self.asked_scenes, self.engines, self.targets),
            *stability.tasks(self.asked_scenes, self.engines),
        ]
        names, calls = [name for name, _ in pieces], [call for _, call in pieces]
        for place, result in isolated(calls, 1, LIMIT, MEMORY):
            if isinstance(result, EngineError):
                self.failures.append(f"{names[place]}: {result.kind}: {result.message}")
            elif isinstance(result, Minimal):
                self.parts.append(result)
            elif isinstance(result, BoundaryShift):
                self.stability.append(result)
            else:
                self.series.append(self.with_default(result))
            yield place + 1, len(calls), names[place]

    def with_default(self, series: StepSeries) -> StepSeries:
        """Return a series beside that of the same method with nothing set, measured before."""
        same = ("scene", "engine", "model", "method")
        for one in self.series:
            if not one.settings and all(getattr(one, key) == getattr(series, key) for key in same):
                return beside(series, one)
        return series

    @property
    def choices(self) -> list[Choice]:
        """The cheapest setting of each engine for each scene and target."""
        choices = [choice for target in self.targets for choice in choose(self.series, target)]
        return sorted(choices, key=lambda choice: list(SCENES).index(choice.scene))

    def of(self, scene: str) -> tuple[StepSeries, ...]:
        """Return the series of one scene."""
        return tuple(one for one in self.series if one.scene == scene)

    @property
    def scenes(self) -> tuple[str, ...]:
        """Names of the scenes that there are series of."""
        return tuple(dict.fromkeys(one.scene for one in self.series))

    @property
    def minimal(self) -> Minimal:
        """The least that the scenes require."""
        return minimal.joined(self.parts)

    def as_json(self) -> dict[str, Any]:
        """Return the ``tradeoff`` document of docs/json.md."""
        fronts = {
            scene: [
                {"engine": one.engine, "model": one.model, "method": one.method}
                | {"settings": dict(one.settings), "step": point.step}
                | {"error": point.error, "seconds": point.cost.seconds if point.cost else None}
                for one, point in pareto(self.of(scene))
            ]
            for scene in self.scenes
        }
        choices = [{**vars(choice), "met": choice.met} for choice in self.choices]
        parts = {"pareto": fronts, "recommendations": choices, "minimal": self.minimal}
        return document("tradeoff", self, versions=versions(self.engines), **parts)


def tradeoff(
    scenes: Sequence[str] = (),
    engines: Sequence[str] = (),
    targets: Sequence[float] = TARGETS,
    progress: Progress | None = None,
) -> Tradeoff:
    """Measure errors and costs of all methods over steps, and of what else limits them.

    Parameters
    ----------
    scenes, engines : sequence of str
        All, if empty.
    targets : sequence of float
        Relative errors to recommend settings for.
    progress : callable ``(done, total, what)``, optional

    Raises
    ------
    UsageError
        For unknown names, an engine that cannot be imported, or targets that are no
        numbers between 0 and 1.
    """
    result = Tradeoff.asked(scenes, engines, targets)
    for done, total, what in result.work():
        if progress:
            progress(done, total, what)
    return result


def valid_targets(targets: Sequence[float]) -> tuple[float, ...]:
    """Return the targets, the largest first.

    Raises
    ------
    UsageError
        If one is no number between 0 and 1.
    """
    for target in targets:
        if not 0 < target < 1:
            raise UsageError(f"a target is a relative error between 0 and 1, not {target!r}")
    return tuple(sorted(set(targets), reverse=True))
