"""``mbcheck tradeoff MODEL.xml``: errors of settings against the model's own converged runs."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping, Sequence
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
from ..inspect.rules.remedies import PREFERRED
from ..queries.environment import versions
from .bench import CLOSURE, PROVED, TRIED, Bench, SampledRun, Setting, TimeUpError
from .converged import DEPARTURE, TIME_UP, Converged, converge
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

EVALUATIONS = {"RK4": 4}
"""Times that an integrator evaluates forces in a step, where that is more than once."""

CHEAPEST = ("Euler", *PREFERRED)
"""Integrators by the cost of a step beside the forces, the cheapest first."""

MARGIN = 0.5
"""Share of the target that a recommended setting may use: with other controls its error differs."""

ENOUGH = 0.1
"""Share of the target below which no shorter steps of an integrator are tried."""

MEASURED, BRIEF = 3, 0.1
"""Times that a run is repeated while they take less than this [s]; the median time counts."""

ITERATIONS = (8, 32, 128)
"""Iterations of the solver that are tried where nothing meets the target with the file's own."""

SOFT = 0.1
"""Share of the target above which the softness of closures is reported."""


@dataclass(frozen=True)
class ModelStart:
    """A start from which runs of a file are compared.

    Attributes
    ----------
    name : str
        state of the file, and whether controls move
    compared : float
        time over which runs are compared [s]
    smooth : bool
        whether no contact, limit or friction acted
    integrator : str
        of the converged run
    step : float
        of the converged run [s]
    bound : float
        relative change of the converged run with half its step
    spread : float
        relative change with a start that is 1e-6 off
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
    """What accuracy costs of an MJCF file.

    Attributes
    ----------
    file : str
        name of the file
    target : float
        relative error allowed
    asked : float
        horizon that was asked for [s]
    horizon : float
        over which all starts are compared [s]
    budget : float
        time to try settings in [s]
    seed : int
        of the controls that move
    observed : sequence of str
        joints and sites that are judged; empty: all joints
    exact_closures : bool
        whether loops count as closed exactly, not as soft as in the file
    softness : float or None
        how far closures as soft as in the file go from hard ones [1]; null: none
    met : bool
        whether a setting meets the target with a margin
    sentence : str
        what to do
    notes : sequence of str
        what else is to be known
    complete : bool
        whether the time was enough
    starts : sequence of ModelStart
        from where runs are compared
    unknown : sequence of str
        starts that were left out, with their reasons
    series : sequence of StepSeries
        all that were tried, by integrator and settings
    front : sequence of SettingRun
        those that none beats in error and time, the fastest first
    own : SettingRun or None
        the file's own setting
    recommendation : SettingRun or None
        the one to choose
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
    """What accuracy costs of one model, and the setting to choose; filled by `work`.

    Attributes
    ----------
    asked : TradeoffRequest
    truths : list of Converged
    trials : list of Trial
        Settings that were run, the file's own first.
    unknown : list of str
        Starts that were left out, each with its reason.
    complete : bool
        Whether the time was enough.
    missed : mapping of Setting to float
        Settings that miss the target from other starts or with other controls: the error there.
    elsewhere : float or None
        Error of the choice from other starts and with other controls, 0 if there are none; None if
        it was not proved there.
    unproved : list of str
        Of these, the starts without a converged run, each with its reason.
    period : float
        After which runs are compared [s].
    version : str
        MuJoCo's.
    """

    asked: TradeoffRequest
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
        """The path of the file."""
        return self.asked.scenes[0]

    # Runs -------------------------------------------------------------------------------------

    def work(self) -> Generator[tuple[int, int, str]]:
        """Run all that there is time for; yields ``(done, total, what)``.

        Raises
        ------
        UsageError
            If the file cannot be read, nothing moves in it, or what is to be resumed is of
            something else.
        """
        loaded = load(self.file)
        if loaded.model.nv == 0:
            raise UsageError(f"{loaded.path.name}: nothing moves in it")
        if self.asked.exact and not np.any(loaded.model.eq_active0):
            raise UsageError(f"--exact-closures: {loaded.path.name} has no equality")
        with quiet(loaded.mujoco):
            self.version = str(loaded.mujoco.__version__)
            bench = Bench(loaded, self.asked)
            self.period = bench.period
            try:
                yield from self.runs(bench)
            finally:
                bench.store.write()

    def runs(self, bench: Bench) -> Iterator[tuple[int, int, str]]:
        """Run all that there is time for, see `work`; the converged runs have half of it."""
        settings, starts = list(bench.settings()), list(bench.starts(TRIED))
        total, half = len(starts) + len(settings), monotonic() + self.asked.budget / 2
        for i, start in enumerate(starts):
            yield i, total, f"converged run, {start.name}"
            truth = converge(bench, start, late=monotonic() > half)
            if isinstance(truth, Converged):
                self.truths.append(truth)
            else:
                self.unknown.append(f"{start.name}: {truth}")
                self.complete = self.complete and truth != TIME_UP
        good: list[Setting] = []
        try:
            for i, setting in enumerate(settings if self.truths else ()):
                yield len(starts) + i, total, setting.name
                if sum(map(setting.alike, good)) < 2:
                    trial = self.tried(bench, setting)
                    good += [setting] if trial.error < ENOUGH * self.asked.target else []
            solves = np.any(bench.loaded.model.eq_active0) or any(not x.smooth for x in self.truths)
            if self.trials and solves and self.choice is None:
                best = setting_of(min(self.trials, key=lambda row: row.error))
                for count in ITERATIONS:
                    yield total, total, best.name
                    self.tried(bench, best._replace(iterations=count))
        except TimeUpError:
            self.complete = False
        yield total, total, "the choice, from other starts"
        self.prove(bench)

    def tried(self, bench: Bench, setting: Setting) -> Trial:
        """Add a setting's run to the trials, and return it."""
        settings: dict[str, float] = {"closure_steps": CLOSURE} if setting.closure else {}
        if setting.iterations:
            settings["iterations"] = setting.iterations
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
                point = point_of(bench, setting, truth, truth.count(self.asked.target))
                bench.store.put(key, point)
            every.append(point)
        return worst_of(every)

    def prove(self, bench: Bench) -> None:
        """Run the choice from other starts and with other controls.

        What misses the target there is dropped, and the next shorter step tried if it was not.
        """
        if self.choice is None:
            return
        bench.deadline = max(bench.deadline, monotonic() + self.asked.budget / 4)
        starts = [*bench.starts(PROVED), *bench.other_starts()]
        others = [(start, converge(bench, start)) for start in starts]
        truths = [one for _, one in others if isinstance(one, Converged)]
        self.unproved = [f"{a.name}: {b}" for a, b in others if not isinstance(b, Converged)]
        try:
            while (choice := self.choice) is not None:
                setting = setting_of(choice)
                point = self.point(bench, setting, truths) if truths else Point(setting.step, 0.0)
                error = Trial(choice.series, point).error
                if error <= self.asked.target:
                    self.elsewhere = error
                    return
                self.missed[setting] = error
                known = {setting_of(trial) for trial in self.trials}
                shorter = (one for one in bench.settings() if one.alike(setting))
                for one in shorter:
                    if one.step < setting.step and one not in known:
                        self.tried(bench, one)
                        break
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
        """The file's own setting, which is tried first."""
        return self.trials[0] if self.trials else None

    @property
    def choice(self) -> Trial | None:
        """The setting of least work that meets the target with a margin, as shorter steps do.

        Evaluations of forces decide: times scatter, and these do not.
        """
        rows = steady(self.series, self.asked.target, MARGIN)
        return cheapest(
            (row for row in rows if setting_of(row) not in self.missed), work_of, self.preference
        )

    def preference(self, row: Trial) -> tuple[float, ...]:
        """Return the key that orders settings of the same work, the best first."""
        own, setting = setting_of(self.trials[0]), setting_of(row)
        cost = CHEAPEST.index(setting.integrator)
        changes = len(row.series.settings)
        return setting != own, changes, setting.integrator != own.integrator, cost

    @property
    def counts(self) -> list[int]:
        """Periods over which each start is compared."""
        return [truth.count(self.asked.target) for truth in self.truths]

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
        """How far closures as soft as in the file go from hard ones; None without closures."""
        softens = any(len(one.softness) for one in self.truths)
        return self.largest("softness") if softens else None

    @property
    def failed(self) -> bool:
        """Whether no setting meets the target."""
        return self.choice is None

    def as_json(self) -> dict[str, Any]:
        """Return the ``tradeoff_model`` document of docs/json.md."""
        asked, own, choice = self.asked, self.own, self.choice
        return document(
            "tradeoff_model",
            self,
            file=Path(self.file).name,
            target=asked.target,
            asked=asked.horizon,
            horizon=self.compared,
            budget=asked.budget,
            seed=asked.seed,
            observed=asked.observed,
            exact_closures=asked.exact,
            met=choice is not None,
            starts=[
                {
                    "name": one.start.name,
                    "compared": n * self.period,
                    "smooth": one.smooth,
                    "step": one.setting.step,
                    "integrator": one.setting.integrator,
                    "bound": float(np.max(one.error[:n])),
                    "spread": float(np.max(one.spread[:n])),
                }
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
        """The recommendation, or why there is none, in one sentence."""
        choice, own, asked = self.choice, self.own, self.asked
        if not self.truths:
            words = "nothing converges" if self.complete else f"no answer in {asked.budget:g} s"
            return f"{words}: " + "; ".join(self.unknown)
        over = f"over {self.compared:.3g} s"
        if own is None:
            return f"no setting was tried in {asked.budget:g} s; --budget gives more"
        if choice is None:
            rows = {setting_of(row): row.error for row in self.trials}
            errors = {one: max(error, self.missed.get(one, 0.0)) for one, error in rows.items()}
            best = min(errors, key=lambda setting: errors[setting])
            if errors[best] == inf:
                return f"no setting came to an end {over}"
            where = "from other starts, too" if self.missed else "with a margin"
            return (
                f"no setting meets {percent(asked.target)} {where} {over}; the smallest error is "
                f"{percent(errors[best])}, of {best.name}"
            )
        error = percent(max(choice.error, self.elsewhere or 0.0))
        said = f"{setting_of(choice).name}: {error} {over}"
        if choice.point is own.point:
            return f"{said}, the file's own setting"
        fewer = work_of(own) / work_of(choice)
        compared = f"{fewer:.2g} times fewer evaluations of forces than" if fewer > 1 else ""
        compared = compared or f"{1 / fewer:.2g} times as many evaluations of forces as"
        compared = "as many evaluations of forces as" if fewer == 1 else compared
        mine = "which loses its state" if own.error == inf else f"error {percent(own.error)}"
        if MARGIN * asked.target < own.error <= asked.target:
            mine += ": no margin for other motions"
        return f"{said}, {compared} the file's setting ({setting_of(own).name}, {mine})"

    @property
    def notes(self) -> list[str]:
        """Cautions, and what was left out."""
        target = self.asked.target
        said = [f"left out: {one}" for one in self.unknown if self.truths]
        said += [
            f"{truth.start.name}: {truth.reason(target)}; compared over {n * self.period:.3g} s"
            for truth, n in zip(self.truths, self.counts, strict=True)
            if n < len(truth.error)
        ]
        if any(not truth.smooth for truth in self.truths):
            said.append(
                "contacts, limits or friction act: errors have no order, and no bound; a start "
                f"that is {DEPARTURE:g} off ends {percent(self.largest('spread'))} apart"
            )
        soft = self.softness
        if soft is not None and soft >= SOFT * target:
            more = "" if self.asked.exact else "; --exact-closures compares with those"
            said.append(
                f"closures as soft as in the file change the motion by {percent(soft)} against "
                f"hard ones{more}"
            )
        said += [
            f"{setting.name} has an error of {percent(error)} from other starts or with other "
            "controls, and is not recommended"
            for setting, error in self.missed.items()
        ]
        if self.choice is not None and self.elsewhere is None:
            said.append(
                "there was no time to try the choice from other starts and with other controls"
            )
        said += [f"the choice was not tried from {one}" for one in self.unproved if self.choice]
        said += [words for one in self.series if not one.settings for words in disagreements(one)]
        if not self.complete:
            said.append(
                f"not all was tried in {self.asked.budget:g} s; --budget gives more, and --resume "
                "goes on from what was kept"
            )
        return said

    @property
    def observed(self) -> str:
        """The joints and sites that are compared, in words."""
        return ", ".join(self.asked.observed) or "all joints"


def setting_of(row: Trial) -> Setting:
    """Return the setting that made a run."""
    options, step = row.series.settings, row.point.step
    iterations = int(options["iterations"]) if "iterations" in options else None
    closure = CLOSURE * step if "closure_steps" in options else None
    return Setting(row.series.method, step, iterations, closure)


def work_of(row: Trial) -> float:
    """Return the evaluations of forces in a simulated second [1/s]."""
    assert row.point.cost is not None
    return row.point.cost.rhs_evaluations or 0.0


def point_of(bench: Bench, setting: Setting, truth: Converged, count: int) -> Point:
    """Return error and cost of a setting from a start, compared over so many periods.

    A run that takes no more than `BRIEF` is made `MEASURED` times, for its time.
    """
    runs, began = list[SampledRun](), monotonic()
    while len(runs) < MEASURED and (not runs or monotonic() - began < BRIEF):
        runs.append(bench.run(truth.start, setting))
    run, n = runs[0], min(count, len(runs[0].positions))
    steps = 1 / setting.step
    work = steps * EVALUATIONS.get(setting.integrator, 1)
    cost = Cost.of([one.seconds for one in runs], steps, work)
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
    """Yield where the largest stable step of small motions and runs disagree."""
    name, limit = series.method, series.stable_step or inf
    runs = [(point.step, point.error) for point in series.points]
    lost = [step for step, error in runs if error is None and step < limit / STABLE]
    harmless = [
        step for step, error in runs if error is not None and error < 0.1 and step > STABLE * limit
    ]
    if lost:
        words = f"below its limit of small motions, {1e3 * limit:.4g} ms"
        words = words if limit < inf else "though small motions limit no step"
        yield f"{name} loses its state at {1e3 * min(lost):.4g} ms, {words}"
    if harmless:
        yield (
            f"{name} at {1e3 * max(harmless):.4g} ms is above its limit of small motions, "
            f"{1e3 * limit:.4g} ms: its error stays small over this time, and it is not recommended"
        )
