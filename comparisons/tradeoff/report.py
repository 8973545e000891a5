"""``mbcheck tradeoff`` of scenes: all series, the cheapest settings and the smallest models."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from ...reference import SCENES
from ...reference.errors import EngineError, UsageError
from ..documents import document
from ..engines.isolation import MEMORY, isolated
from ..engines.registry import resolve_selection
from ..queries.environment import versions
from . import smallest, stability
from .store import RunStore
from .sweep import beside, sweeps, swept
from .table import (
    MODEL,
    ROUND_OFF,
    TARGETS,
    Choice,
    StepSeries,
    Swept,
    Trial,
    cheapest,
    pareto,
    steady,
    trials_of,
)

NOISE = 1.2
"""Median times that differ by no more than this factor cost about the same."""

LIMIT = 300.0
"""Time limit of a series, or of one piece of the smallest models [s]."""

Progress = Callable[[int, int, str], None]


def choose(series: Sequence[StepSeries], target: float) -> list[Choice]:
    """Return the cheapest setting of each engine for each scene, or why there is none.

    Of settings that cost about the same, the one with the fewest options set, then the most
    accurate: noise of a clock is no reason to prefer one. The shortest step of a series has to be
    at its floor: the error with half of it is not known.
    """
    choices = []
    for scene, engine in dict.fromkeys((one.scene, one.engine) for one in series):
        mine = [one for one in series if (one.scene, one.engine) == (scene, engine)]
        good = [
            row
            for row in steady(mine, target)
            if row.point is not row.series.points[-1] or row.point.label in (MODEL, ROUND_OFF)
        ]
        best = cheapest(
            good, lambda row: row.seconds, lambda row: (len(row.series.settings), row.error), NOISE
        )
        choices.append(choice_from(best, mine, target))
    return choices


def choice_from(best: Trial | None, series: Sequence[StepSeries], target: float) -> Choice:
    """Return the choice of the best run of some series, or of none with the least error."""
    if best is None:
        one, least = min(trials_of(series), key=lambda trial: trial.error)
        words = "no run came to an end"
        words = words if least.error is None else f"{least.limit} of {one.setting}"
        return Choice(one.scene, one.case, one.engine, target, error=least.error, limit=words)
    one, point = best
    assert point.step is not None
    longest = max(trial.point.step or 0.0 for trial in trials_of([one]) if trial.error < 1)
    return one.choice(
        target,
        step=point.step,
        error=point.error,
        cost=point.cost,
        limit=point.limit,
        margin=None if one.stable_step is None else one.stable_step / point.step,
        longest=longest / point.step,
        met=True,
    )


@dataclass
class Tradeoff:
    """What accuracy costs; filled by `work`.

    Attributes
    ----------
    targets : tuple of float
    asked_scenes, engines : tuple of str
    resume : str or None
        File that keeps results.
    series : list of StepSeries
    smallest : list of Choice
        Smallest models.
    failures : list of str
        What came to nothing, and why.
    """

    targets: tuple[float, ...]
    asked_scenes: tuple[str, ...]
    engines: tuple[str, ...]
    resume: str | None = None
    series: list[StepSeries] = field(default_factory=list)
    smallest: list[Choice] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)

    @classmethod
    def asked(
        cls,
        scenes: Sequence[str],
        engines: Sequence[str],
        targets: Sequence[float],
        resume: str | None = None,
    ) -> Tradeoff:
        """Return what is asked for, to be filled by `work`; see `tradeoff`."""
        return cls(valid_targets(targets), *resolve_selection(scenes, engines), resume)

    def work(self) -> Iterator[tuple[int, int, str]]:
        """Measure one piece after the other, each in a process of its own; tell how far it is.

        One at a time: they are timed.
        """
        store = RunStore(self.resume, target=self.targets, versions=versions(self.engines))
        asked = self.asked_scenes, self.engines
        pieces: dict[str, Callable[[], Swept]] = {
            **{one.name: partial(swept, one) for one in sweeps(*asked)},
            **dict(smallest.tasks(*asked, self.targets)),
            **dict(stability.tasks(*asked)),
        }
        known = {name: store.get(name, Swept) for name in pieces}
        for result in filter(None, known.values()):
            self.add(result)
        names = [name for name in pieces if known[name] is None]
        done = len(pieces) - len(names)
        try:
            for place, result in isolated([pieces[name] for name in names], 1, LIMIT, MEMORY):
                if isinstance(result, EngineError):
                    self.failures.append(f"{names[place]}: {result.kind}: {result.message}")
                else:
                    store.put(names[place], result)
                    self.add(result)
                yield done + place + 1, len(pieces), names[place]
        finally:
            store.write()

    def add(self, result: Swept) -> None:
        """Add a piece; a series with an option set stands beside that with nothing set."""
        same = ("scene", "engine", "model", "method", "axis")
        for one in result.series:
            for other in self.series:
                alike = all(getattr(one, key) == getattr(other, key) for key in same)
                if alike and one.settings and not other.settings:
                    one = beside(one, other)
            self.series.append(one)
        self.smallest += result.choices

    @property
    def failed(self) -> bool:
        """Whether something came to nothing."""
        return bool(self.failures)

    @property
    def choices(self) -> list[Choice]:
        """The cheapest setting of each engine for each scene and target, then the smallest."""
        swept = [one for one in self.series if one.axis == "step"]
        choices = [choice for target in self.targets for choice in choose(swept, target)]
        return sorted(choices, key=lambda one: list(SCENES).index(one.scene)) + self.smallest

    def of(self, scene: str, axis: str = "step") -> list[StepSeries]:
        """Return the series of one scene on one axis."""
        return [one for one in self.series if (one.scene, one.axis) == (scene, axis)]

    @property
    def scenes(self) -> tuple[str, ...]:
        """Names of the scenes that there are series of."""
        return tuple(dict.fromkeys(one.scene for one in self.series))

    def as_json(self) -> dict[str, Any]:
        """Return the ``tradeoff`` document of docs/json.md."""
        fronts = {
            scene: [trial_document(row) for row in pareto(trials_of(self.of(scene)))]
            for scene in self.scenes
        }
        parts = {"pareto": fronts, "recommendations": self.choices}
        return document("tradeoff", self, versions=versions(self.engines), **parts)


def trial_document(row: Trial) -> dict[str, Any]:
    """Return a run as a document has it."""
    return {**vars(row.series), **vars(row.point), "seconds": row.seconds}


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
