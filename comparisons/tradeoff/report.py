"""``mbcheck tradeoff``: all series, what to choose, and the least that a scene requires."""

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
from . import minimal
from .choice import Choice, choose, pareto
from .minimal import Minimal
from .series import TARGETS, Series
from .sweep import beside, measure, sweeps

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
    failures : list of str
        What came to nothing, and why.
    """

    targets: tuple[float, ...]
    asked_scenes: tuple[str, ...]
    engines: tuple[str, ...]
    series: list[Series] = field(default_factory=list)
    parts: list[Minimal] = field(default_factory=list)
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
        pieces = minimal.tasks(self.asked_scenes, self.engines, self.targets)
        names = [one.name for one in wanted] + [name for name, _ in pieces]
        calls: list[Callable[[], Series | Minimal]] = [partial(measure, one) for one in wanted]
        calls += [call for _, call in pieces]
        for place, result in isolated(calls, 1, LIMIT, MEMORY):
            if isinstance(result, EngineError):
                self.failures.append(f"{names[place]}: {result.kind}: {result.message}")
            elif isinstance(result, Minimal):
                self.parts.append(result)
            else:
                self.series.append(self.with_default(result))
            yield place + 1, len(calls), names[place]

    def with_default(self, series: Series) -> Series:
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

    def of(self, scene: str) -> tuple[Series, ...]:
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
