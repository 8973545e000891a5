"""``mbcheck tradeoff MODEL.xml``: errors of settings against converged runs of the model."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np

from ...reference.errors import UsageError
from ..documents import document
from ..engines.mujoco.library import quiet
from ..inspect.mujoco.model import ENGINE, load
from ..inspect.tuning import THRESHOLDS
from ..queries.environment import versions
from .bench import TIME_UP, Bench, Converged, SampledRun, Setting, TimeUpError, converge
from .request import TradeoffRequest
from .table import (
    FAILED,
    STABLE,
    Cost,
    Point,
    SettingRun,
    StepSeries,
    Trial,
    cheapest,
    pareto,
    percent,
    steady,
    trials_of,
)
from .tuning import BENCH

CHEAPEST = ("Euler", *THRESHOLDS.preferred_integrators)
"""Integrators by the cost of a step apart from the forces, the cheapest first."""


@dataclass(frozen=True)
class ModelStart:
    """Start from which runs of a file are compared.

    Attributes
    ----------
    name : str
        state of the file, and kind of controls
    compared : float
        time over which runs are compared [s]
    smooth : bool
        true if no contact, limit or friction acted
    integrator : str
        integrator of the converged run
    step : float
        step of the converged run [s]
    bound : float
        relative change of the converged run with twice its step
    spread : float
        relative change with a start off by 1e-4 of the target, relative to the motion
    """

    name: str
    compared: float
    smooth: bool
    integrator: str
    step: float
    bound: float
    spread: float


@dataclass(frozen=True)
class TradeoffModelDocument:
    """Cost of accuracy for an MJCF file.

    Attributes
    ----------
    file : str
        name of the file
    target : float
        relative error allowed
    asked : float
        simulated time of each run, as requested [s]
    horizon : float
        simulated time over which all starts are compared [s]; shorter where errors grow
    budget : float
        time of this computer to try settings [s]
    seed : int
        seed of the moving controls
    observed : sequence of str
        joints and sites that are judged; empty: all joints
    exact_closures : bool
        true if loops count as closed exactly, not as soft as in the file
    softness : float or None
        relative change of the motion by closures as soft as in the file, against hard ones [1];
        null without closures
    met : bool
        true if a setting meets the target with a margin
    sentence : str
        recommendation, or the reason why there is none
    notes : sequence of str
        cautions, and omissions
    complete : bool
        true if the time was sufficient
    starts : sequence of ModelStart
        starts from which runs are compared
    unknown : sequence of str
        starts that were left out, with their reasons
    series : sequence of StepSeries
        all tried settings, by integrator and other changes
    front : sequence of SettingRun
        settings that none beats in error and time, the fastest first
    own : SettingRun or None
        setting of the file
    recommendation : SettingRun or None
        recommended setting
    """

    file: str
    target: float
    asked: float
    horizon: float
    budget: float
    seed: int
    observed: Sequence[str]
    exact_closures: bool
    softness: float | None
    met: bool
    sentence: str
    notes: Sequence[str]
    complete: bool
    starts: Sequence[ModelStart]
    unknown: Sequence[str]
    series: Sequence[StepSeries]
    front: Sequence[SettingRun]
    own: SettingRun | None
    recommendation: SettingRun | None
    versions: Mapping[str, str]


@dataclass
class ModelTradeoff:
    """Cost of accuracy for a model, and the setting to choose; filled by `work`.

    Attributes
    ----------
    request : TradeoffRequest
    truths : list of Converged
    trials : list of Trial
        Settings that were run, the one of the file first.
    unknown : list of str
        Starts that were left out, each with its reason.
    complete : bool
        True if the time was sufficient.
    missed : mapping of Setting to float
        Settings that miss the target from other starts or with other controls -> error there.
    elsewhere : float or None
        Error of the choice from other starts and with other controls, 0 if there are none; None if
        it was not proved there.
    unproved : list of str
        Other starts without a converged run, each with its reason.
    period : float
        Time after which runs are compared [s].
    version : str
        Version of MuJoCo.
    """

    request: TradeoffRequest
    truths: list[Converged] = field(default_factory=list)
    trials: list[Trial] = field(default_factory=list)
    unknown: list[str] = field(default_factory=list)
    complete: bool = True
    missed: dict[Setting, float] = field(default_factory=dict)
    elsewhere: float | None = None
    unproved: list[str] = field(default_factory=list)
    period: float = 0.0
    version: str = ""

    @property
    def file(self) -> str:
        """Path of the file."""
        return self.request.scenes[0]

    # Runs -------------------------------------------------------------------------------------

    def work(self) -> Generator[tuple[int, int, str]]:
        """Run all settings for which there is time; yields ``(done, total, what)``.

        Raises
        ------
        UsageError
            If the file cannot be read, nothing moves in it, or --resume names runs of another
            model or request.
        """
        loaded = load(self.file)
        if loaded.model.nv == 0:
            raise UsageError(f"{loaded.path.name}: nothing moves in it")
        if self.request.exact and not np.any(loaded.model.eq_active0):
            raise UsageError(f"--exact-closures: {loaded.path.name} has no equality")
        with quiet(loaded.mujoco):
            self.version = str(loaded.mujoco.__version__)
            bench = Bench(loaded, self.request)
            self.period = bench.period
            try:
                yield from self.runs(bench)
            finally:
                bench.store.write()

    def runs(self, bench: Bench) -> Iterator[tuple[int, int, str]]:
        """Run all settings for which there is time, see `work`; converged runs have half of it.

        Settings are tried in the order of their work; those that cannot be the choice are left out.
        """
        half, starts = monotonic() + self.request.budget / 2, list(bench.starts(BENCH.tried_draws))
        others = [*bench.starts(BENCH.proof_draws), *bench.other_starts()]
        before = len(starts) + len(bench.settings())
        total = before + len(others)
        for i, start in enumerate(starts):
            yield i, total, f"converged run, {start.name}"
            truth = converge(bench, start, late=monotonic() > half)
            if isinstance(truth, Converged):
                self.truths.append(truth)
            else:
                self.unknown.append(f"{start.name}: {truth}")
                self.complete = self.complete and truth != TIME_UP
        try:
            while self.truths and (setting := self.next_setting(bench)):
                yield len(starts) + len(self.trials), total, setting.name
                self.tried(bench, setting)
            solves = np.any(bench.loaded.model.eq_active0) or any(not x.smooth for x in self.truths)
            if self.trials and solves and self.choice is None:
                best = setting_of(min(self.trials, key=lambda row: row.error))
                for count in BENCH.iterations:
                    yield before, total, best.name
                    self.tried(bench, best._replace(iterations=count))
        except TimeUpError:
            self.complete = False
        if self.choice is not None:
            bench.deadline = max(bench.deadline, monotonic() + self.request.budget / 4)
            truths = list[Converged]()
            for i, start in enumerate(others):
                yield before + i, total, f"the choice, from {start.name}"
                truth = converge(bench, start)
                if isinstance(truth, Converged):
                    truths.append(truth)
                else:
                    self.unproved.append(f"{start.name}: {truth}")
            self.prove(bench, truths)

    def next_setting(self, bench: Bench) -> Setting | None:
        """Return the setting of least work that may become the choice, or reject it; None if none.

        It may not if two longer steps are far better than the target, or, once a step of the same
        integrator was tried, if it takes more work than the choice.
        """
        choice, enough = self.choice, BENCH.enough * self.request.target
        known = {setting_of(row): row.error for row in self.trials}
        for one in bench.settings():
            alike = [other for other in known if other.alike(one)]
            good = [other for other in alike if known[other] < enough and other not in self.missed]
            rival = choice and not setting_of(choice).alike(one)
            beaten = alike and rival and one.work > setting_of(choice).work
            if one not in known and len(good) < 2 and not beaten:
                return one
        return None

    def tried(self, bench: Bench, setting: Setting) -> Trial:
        """Run a setting, and add it to the trials."""
        changes = {
            "closure_steps": setting.closure and BENCH.closure_steps,
            "iterations": setting.iterations,
        }
        settings = {name: value for name, value in changes.items() if value}
        limit = bench.limit(setting)
        series = StepSeries(
            Path(self.file).name, "", ENGINE, "", setting.integrator, 0, settings,
            stable_step=limit if limit < inf else None,
        )  # fmt: skip
        self.trials.append(Trial(series, self.point(bench, setting, self.truths)))
        return self.trials[-1]

    def point(self, bench: Bench, setting: Setting, truths: Sequence[Converged]) -> Point:
        """Return error and cost of a setting over some starts."""
        every = list[Point]()
        for truth in truths:
            key = f"{setting.integrator} {setting[1:]!r}, {truth.start.name}"
            point: Point | None = bench.store.get(key, Point)
            if point is None:
                point = point_of(bench, setting, truth, truth.count(self.request.target))
                bench.store.put(key, point)
            every.append(point)
        return worst_of(every)

    def prove(self, bench: Bench, truths: Sequence[Converged]) -> None:
        """Run the choice from other starts and with other controls.

        A setting that misses the target there is dropped, and others are tried.
        """
        try:
            while (choice := self.choice) is not None:
                setting = setting_of(choice)
                point = self.point(bench, setting, truths) if truths else Point(setting.step, 0.0)
                error = Trial(choice.series, point).error
                if error <= self.request.target:
                    self.elsewhere = error
                    return
                self.missed[setting] = error
                while other := self.next_setting(bench):
                    self.tried(bench, other)
        except TimeUpError:
            pass

    # Results ----------------------------------------------------------------------------------

    @property
    def series(self) -> list[StepSeries]:
        """Trials by integrator, iterations and closures, the longest steps first."""
        kinds: dict[str, list[Trial]] = {}
        for row in self.trials:
            kinds.setdefault(row.series.setting, []).append(row)
        return [
            replace(
                rows[0].series,
                points=tuple(sorted((row.point for row in rows), key=lambda p: -p.step)),
            )
            for rows in kinds.values()
        ]

    @property
    def front(self) -> list[Trial]:
        """Runs that none beats in both error and time, the fastest first."""
        return pareto(trials_of(self.series))

    @property
    def own(self) -> Trial | None:
        """Setting of the file, which is tried first."""
        return self.trials[0] if self.trials else None

    @property
    def choice(self) -> Trial | None:
        """Setting of least work that meets the target with a margin, as shorter steps do.

        The number of evaluations of forces decides, since times scatter.
        """
        rows = steady(self.series, self.request.target, BENCH.margin)
        return cheapest(
            (row for row in rows if setting_of(row) not in self.missed),
            lambda row: setting_of(row).work,
            self.preference,
        )

    def preference(self, row: Trial) -> tuple[float, ...]:
        """Return the sort key of settings of the same work, the best first."""
        own, setting = setting_of(self.trials[0]), setting_of(row)
        cost = CHEAPEST.index(setting.integrator)
        changes = len(row.series.settings)
        return setting != own, changes, setting.integrator != own.integrator, cost

    @property
    def counts(self) -> list[int]:
        """Periods over which each start is compared."""
        return [truth.count(self.request.target) for truth in self.truths]

    @property
    def compared(self) -> float:
        """Time over which all starts are compared [s]."""
        return min(self.counts, default=0) * self.period

    def largest(self, field: str) -> float:
        """Return the largest of a field of all converged runs, as long as they are compared."""
        both = zip(self.truths, self.counts, strict=True)
        return max(
            (float(np.max(vars(one)[field][:n], initial=0.0)) for one, n in both), default=0.0
        )

    @property
    def softness(self) -> float | None:
        """Relative change of the motion by closures as soft as in the file, if there are any."""
        softens = any(len(one.softness) for one in self.truths)
        return self.largest("softness") if softens else None

    @property
    def failed(self) -> bool:
        """True if no setting meets the target."""
        return self.choice is None

    def as_json(self) -> dict[str, Any]:
        """Return the ``tradeoff_model`` document of docs/json.md."""
        request, own, choice = self.request, self.own, self.choice
        return document(
            "tradeoff_model",
            self,
            file=Path(self.file).name,
            target=request.target,
            asked=request.horizon,
            horizon=self.compared,
            budget=request.budget,
            seed=request.seed,
            observed=request.observed,
            exact_closures=request.exact,
            met=choice is not None,
            starts=[
                ModelStart(
                    name=one.start.name,
                    compared=n * self.period,
                    smooth=one.smooth,
                    integrator=one.setting.integrator,
                    step=one.setting.step,
                    bound=float(np.max(one.error[:n])),
                    spread=float(np.max(one.spread[:n])),
                )
                for one, n in zip(self.truths, self.counts, strict=True)
            ],
            front=[row.as_run for row in self.front],
            own=own and own.as_run,
            recommendation=choice and choice.as_run,
            versions={**versions(()), ENGINE: self.version},
        )

    # Words ------------------------------------------------------------------------------------

    @property
    def sentence(self) -> str:
        """Recommendation in one sentence, or the reason why there is none; soft closures first."""
        soft = self.softness
        if soft is None or soft < BENCH.softness_share * self.request.target:
            return self.advice
        link = "; with hard ones" if self.request.exact else " (--exact-closures); with soft ones"
        return (
            f"closures as soft as in the file change the motion by {percent(soft)} compared with "
            f"hard ones{link}, {self.advice}"
        )

    @property
    def advice(self) -> str:
        """Recommendation, or the reason why there is none."""
        choice, own, request = self.choice, self.own, self.request
        if not self.truths:
            words = (
                "no run converges" if self.complete else f"no answer within {request.budget:g} s"
            )
            return f"{words}: " + "; ".join(by_reason(self.unknown))
        over = f"over {self.compared:.3g} s"
        if min(self.counts) < max(len(one.error) for one in self.truths):
            over += f" of {request.horizon:.3g} s"
        if own is None:
            return f"no setting was tried within {request.budget:g} s: raise --budget"
        if choice is None:
            every = ((setting_of(row), row.error) for row in self.trials)
            errors = {one: max(error, self.missed.get(one, 0.0)) for one, error in every}
            best = min(errors, key=lambda setting: errors[setting])
            if errors[best] == inf:
                return f"no run reached its end {over}"
            where = "from other starts, too" if self.missed else "with a margin"
            return (
                f"no setting meets {percent(request.target)} {where} {over}; the smallest error is "
                f"{percent(errors[best])}, with {best.name}"
            )
        error = percent(choice.error)
        if (self.elsewhere or 0.0) > choice.error:
            error += f" ({percent(self.elsewhere)} from other starts)"
        words = f"{setting_of(choice).name}: error {error} {over}"
        if choice.point is own.point:
            return f"{words}, the file's own setting"
        fewer = setting_of(own).work / setting_of(choice).work
        times = f"{1 / fewer:.2g} times " if fewer < 1 else ""
        count = f"{fewer:.2g} times fewer" if fewer > 1 else f"{times}as many"
        mine = "which loses its state" if own.error == inf else f"error {percent(own.error)}"
        if BENCH.margin * request.target < own.error <= request.target:
            mine += ": no margin for other motions"
        return (
            f"{words}, {count} evaluations of forces {'than' if fewer > 1 else 'as'} the file's "
            f"setting ({setting_of(own).name}, {mine})"
        )

    @property
    def notes(self) -> list[str]:
        """Cautions, and omissions."""
        target = self.request.target
        notes = [f"left out: {one}" for one in by_reason(self.unknown) if self.truths]
        notes += [
            f"{truth.start.name}: {truth.reason(target)}; compared over {n * self.period:.3g} s"
            for truth, n in zip(self.truths, self.counts, strict=True)
            if n < len(truth.error)
        ]
        if any(not truth.smooth for truth in self.truths):
            notes.append(
                "contacts, limits or friction act: errors have no order, and no bound; a start "
                f"off by {max(one.apart for one in self.truths):.1g} of the motion ends "
                f"{percent(self.largest('spread'))} apart"
            )
        notes += [
            f"{setting.name} has an error of {percent(error)} from other starts or with other "
            "controls, and is not recommended"
            for setting, error in self.missed.items()
        ]
        if self.choice is not None and self.elsewhere is None:
            notes.append(
                "there was no time to try the choice from other starts and with other controls"
            )
        unproved = by_reason(self.unproved) if self.choice else ()
        notes += [f"the choice was not tried from {one}" for one in unproved]
        notes += [words for one in self.series if not one.settings for words in disagreements(one)]
        if not self.complete:
            notes.append(
                f"not all settings were tried within {self.request.budget:g} s: raise --budget, or "
                "continue with --resume"
            )
        return notes


def by_reason(starts: Iterable[str]) -> Iterator[str]:
    """Yield the starts that share a reason in one text each: ``start, start: reason``."""
    names = dict[str, list[str]]()
    for name, _, reason in (one.partition(": ") for one in starts):
        names.setdefault(reason, []).append(name)
    yield from (f"{'; '.join(listed)}: {reason}" for reason, listed in names.items())


def setting_of(row: Trial) -> Setting:
    """Return the setting of a run."""
    options, step = row.series.settings, row.point.step
    iterations = int(options["iterations"]) if "iterations" in options else None
    closure = BENCH.closure_steps * step if "closure_steps" in options else None
    return Setting(row.series.method, step, iterations, closure)


def point_of(bench: Bench, setting: Setting, truth: Converged, count: int) -> Point:
    """Return error and cost of a setting from a start, compared over so many periods.

    A brief run is repeated, for its time.
    """
    runs, began = list[SampledRun](), monotonic()
    while len(runs) < BENCH.repeats and (not runs or monotonic() - began < BENCH.brief):
        runs.append(bench.run(truth.start, setting))
    run, n = runs[0], min(count, len(runs[0].positions))
    cost = Cost.of([one.seconds for one in runs], 1 / setting.step, setting.work)
    if run.failed is not None and not truth.run.failed:
        reason = f"{truth.start.name}, before t = {run.failed:.3g} s"
        return Point(setting.step, None, cost=cost, label=FAILED, reason=reason)
    off = np.max(np.abs(run.energy[:n] - truth.run.energy[:n]), initial=0.0)
    return Point(
        setting.step,
        error=float(np.max(bench.apart(run, truth.run, truth.size)[:n], initial=0.0)),
        errors={"energy": float(off / (truth.run.kinetic or 1.0)), "violation": run.violation},
        cost=cost,
        label="",
        bound=float(np.max(truth.error[:n], initial=0.0)),
    )


def worst_of(points: Sequence[Point]) -> Point:
    """Return the largest errors of a setting over all starts, with the median time."""
    costs = [point.cost for point in points if point.cost]
    steps, work = costs[0].steps, costs[0].rhs_evaluations
    cost = Cost.of([one.seconds for one in costs], steps, work)
    failed = [point for point in points if point.error is None]
    if failed:
        return replace(failed[0], cost=cost)
    worst = max(points, key=lambda point: point.error or 0.0)
    errors = {name: max(point.errors[name] for point in points) for name in worst.errors}
    bound = max(point.bound or 0.0 for point in points)
    return replace(worst, errors=errors, bound=bound, cost=cost)


def disagreements(series: StepSeries) -> Iterator[str]:
    """Yield disagreements between runs and the largest stable step of small motions."""
    name, limit = series.method, series.stable_step or inf
    runs = [(point.step, point.error) for point in series.points]
    lost = [step for step, error in runs if error is None and step < limit / STABLE]
    harmless = [
        step for step, error in runs if error is not None and error < 0.1 and step > STABLE * limit
    ]
    if lost:
        words = f"below its limit of small motions, {1e3 * limit:.4g} ms"
        words = words if limit < inf else "although small motions limit no step"
        yield f"{name} loses its state at {1e3 * min(lost):.4g} ms, {words}"
    if harmless:
        yield (
            f"{name} at {1e3 * max(harmless):.4g} ms is above its limit of small motions, "
            f"{1e3 * limit:.4g} ms: its error stays small over this time, and it is not recommended"
        )
