"""The trade-off of scenes: all series, the cheapest settings and the smallest models."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from ...reference.errors import EngineError
from ..documents import document
from ..documents.fields import HIDDEN, documented, takes_fields_of
from ..engines.isolation import MEMORY, isolated
from ..engines.registry import resolve_selection
from ..queries import environment
from .left_out import LeftOut, compare, pairs_of
from .model import ModelTradeoff
from .request import TARGETS, TradeoffRequest
from .stability import StabilityShift, boundaries_of, shift
from .store import RunStore
from .sweep import beside, smallest, sweeps, swept
from .table import Choice, SettingRun, StepSeries, choose, pareto, trials_of
from .tuning import SWEEP

Result = StepSeries | LeftOut | StabilityShift


@dataclass
class Tradeoff:
    """Cost of accuracy for scenes; filled by `work`.

    Attributes
    ----------
    targets : tuple of float
        relative errors for which settings are recommended [1]
    scenes, engines : tuple of str
        Names.
    resume : str or None
        File that keeps results.
    series : list of StepSeries
        runs of a model by a method over steps
    left_out : list of LeftOut
        parts that models may leave out
    stability : list of StabilityShift
        shifts of boundaries of stability by the step
    failures : list of str
        measurements that failed, with their reasons
    """

    targets: tuple[float, ...]
    scenes: tuple[str, ...] = field(metadata=HIDDEN)
    engines: tuple[str, ...] = field(metadata=HIDDEN)
    resume: str | None = field(default=None, metadata=HIDDEN)
    series: list[StepSeries] = field(default_factory=list)
    left_out: list[LeftOut] = field(default_factory=list)
    stability: list[StabilityShift] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)

    @classmethod
    def of_request(cls, request: TradeoffRequest) -> Tradeoff:
        """Return the trade-off of a request, to be filled by `work`.

        Raises
        ------
        UsageError
            For unknown names, or an engine that cannot be imported.
        """
        targets = tuple(sorted(set(request.targets or TARGETS), reverse=True))
        return cls(targets, *resolve_selection(request.scenes, request.engines), request.resume)

    def work(self) -> Iterator[tuple[int, int, str]]:
        """Measure one series after the other, each in a separate process; yields progress.

        They do not run at the same time, since they are timed.
        """
        store = RunStore(self.resume, versions=self.versions)
        pieces = self.pieces()
        known = {name: store.get(name, kind) for name, (kind, _) in pieces.items()}
        for one in filter(None, known.values()):
            self.add(one)
        names = [name for name in pieces if known[name] is None]
        done = len(pieces) - len(names)
        calls = [pieces[name][1] for name in names]
        try:
            for place, result in isolated(calls, 1, SWEEP.series_time, MEMORY):
                if isinstance(result, EngineError):
                    self.failures.append(f"{names[place]}: {result.kind}: {result.message}")
                else:
                    store.put(names[place], result)
                    self.add(result)
                yield done + place + 1, len(pieces), names[place]
        finally:
            store.write()

    def pieces(self) -> dict[str, tuple[type, Callable[[], Result]]]:
        """Return the type of each result and the call that measures it, by name."""
        pieces: dict[str, tuple[type, Callable[[], Result]]] = {
            one.name: (StepSeries, partial(swept, one)) for one in sweeps(self.scenes, self.engines)
        }
        for name, pair in pairs_of(self.scenes, self.engines):
            pieces[name] = LeftOut, partial(compare, pair)
        for name, names in boundaries_of(self.scenes, self.engines):
            pieces[name] = StabilityShift, partial(shift, *names)
        return pieces

    def add(self, result: Result) -> None:
        """Add a result to the list of its kind."""
        if isinstance(result, StepSeries):
            self.series.append(beside(result, self.series))
        elif isinstance(result, LeftOut):
            self.left_out.append(result)
        else:
            self.stability.append(result)

    @property
    def failed(self) -> bool:
        """True if a measurement failed."""
        return bool(self.failures)

    def of(self, scene: str) -> list[StepSeries]:
        """Return the series of one scene."""
        return [one for one in self.series if one.scene == scene]

    @property
    @documented
    def versions(self) -> Mapping[str, str]:
        """Versions of mbcheck, numpy, scipy and of the engines that took part, by name."""
        return environment.versions(self.engines)

    @property
    @documented
    def pareto(self) -> Mapping[str, Sequence[SettingRun]]:
        """Settings by scene that none beats in both error and time, the cheapest first."""
        fronts = {scene: pareto(trials_of(self.of(scene))) for scene in self.scenes}
        return {scene: [row.as_run for row in front] for scene, front in fronts.items()}

    @property
    @documented
    def recommendations(self) -> Sequence[Choice]:
        """Cheapest setting for each scene, target and engine; then the smallest models."""
        best, least = list[Choice](), list[Choice]()
        for scene in self.scenes:
            every = self.of(scene)
            engines = dict.fromkeys(one.engine for one in every)
            for target in self.targets:
                for engine in engines:
                    best.append(choose([one for one in every if one.engine == engine], target))
                least += smallest(every, target)
        return best + least

    def as_json(self) -> dict[str, Any]:
        """Return the ``tradeoff`` document of docs/json.md."""
        return document("tradeoff", self)


def begin(request: TradeoffRequest) -> Tradeoff | ModelTradeoff:
    """Return the trade-off of a request, to be filled by its ``work``.

    Raises
    ------
    UsageError
        If a scene or an engine is unknown, or an engine cannot be imported.
    """
    return ModelTradeoff(request) if request.is_model else Tradeoff.of_request(request)


@takes_fields_of(TradeoffRequest)
def tradeoff(request: TradeoffRequest) -> Tradeoff | ModelTradeoff:
    """Measure what accuracy costs for scenes or a file; takes the fields of `TradeoffRequest`.

    Raises
    ------
    UsageError
        If a name is unknown, an engine cannot be imported, or an option is invalid.
    """
    result = begin(request)
    for _ in result.work():
        pass
    return result
