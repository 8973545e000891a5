"""``mbcheck tradeoff MODEL.xml``: errors of settings against the model's own converged runs."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from math import inf
from pathlib import Path
from statistics import median
from time import monotonic
from typing import Any

import numpy as np

from ...reference.errors import UsageError
from ..documents import document
from ..engines.mujoco.library import quiet
from ..inspect.mujoco.model import ENGINE, load
from ..inspect.rules.remedies import PREFERRED
from ..queries.environment import versions
from ..reports.words import plural
from .bench import CLOSURE, CONVERGED, PROVED, TRIED, Bench, Setting, Start, TimeUpError
from .converged import DEPARTURE, SHARPEST, Converged, converge
from .report import trial_document
from .store import RunStore
from .table import (
    FAILED,
    STABLE,
    Cost,
    Point,
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

ALIKE = 1e-3
"""Errors that differ by a smaller share are the same."""

ENOUGH = 0.1
"""Share of the target below which no shorter steps of an integrator are tried."""

MEASURED, BRIEF = 3, 0.1
"""Times that a run is repeated while they take less than this [s]; the median time counts."""

SOFT = 0.1
"""Share of the target above which the softness of closures is reported."""


@dataclass(frozen=True)
class Question:
    """Options of the trade-off of a model.

    Attributes
    ----------
    target, horizon, budget : float
        Relative error, and times [s].
    seed : int
        Seed of the moving controls.
    observed : tuple of str
        Joints and sites; all joints if there are none.
    exact : bool
        Whether runs are compared with closures that are closed exactly.
    resume : str or None
        File that keeps runs.
    """

    target: float = 0.01
    horizon: float = 1.0
    budget: float = 120.0
    seed: int = 1
    observed: tuple[str, ...] = ()
    exact: bool = False
    resume: str | None = None

    def refuse_nonsense(self) -> None:
        """Refuse numbers that make no sense.

        Raises
        ------
        UsageError
        """
        for name in ("target", "horizon", "budget"):
            value = vars(self)[name]
            if not 0 < value < inf:
                raise UsageError(f"--{name} must be a positive number, not {value:g}")
        if self.target >= 1:
            raise UsageError(f"--target is a relative error below 1, not {self.target:g}")


@dataclass
class ModelTradeoff:
    """What accuracy costs of one model, and the setting to choose; filled by `work`.

    Attributes
    ----------
    file : str
    asked : Question
    truths : list of Converged
    trials : list of Trial
        Settings that were run, the file's own first.
    unknown : list of str
        Starts that were left out, each with its reason.
    complete : bool
        Whether the time was enough.
    missed : mapping of Setting to float
        Settings that miss the target from other starts or with other controls: the error there.
    proved : bool
        Whether the choice met the target from other starts and with other controls.
    elsewhere : float
        Its error there.
    unproved : list of str
        Of these, the starts without a converged run, each with its reason.
    period : float
        After which runs are compared [s].
    version : str
        MuJoCo's.
    """

    file: str
    asked: Question = field(default_factory=Question)
    truths: list[Converged] = field(default_factory=list)
    trials: list[Trial] = field(default_factory=list)
    unknown: list[str] = field(default_factory=list)
    complete: bool = True
    missed: dict[Setting, float] = field(default_factory=dict)
    proved: bool = False
    elsewhere: float = 0.0
    unproved: list[str] = field(default_factory=list)
    period: float = 0.0
    version: str = ""

    # Runs -------------------------------------------------------------------------------------

    def work(self) -> Generator[tuple[int, int, str]]:
        """Run all that there is time for; yields ``(done, total, what)``.

        Raises
        ------
        UsageError
            If the file cannot be read, nothing moves in it, a number makes no sense, or what is to
            be resumed is of something else.
        """
        asked = self.asked
        asked.refuse_nonsense()
        loaded = load(self.file)
        if loaded.model.nv == 0:
            raise UsageError(f"{loaded.path.name}: nothing moves in it")
        if asked.exact and not np.any(loaded.model.eq_active0):
            raise UsageError(f"--exact-closures: {loaded.path.name} has no equality")
        with quiet(loaded.mujoco):
            deadline = monotonic() + asked.budget
            bench = Bench(loaded, asked.horizon, asked.observed, deadline)
            self.period, self.version = bench.period, str(loaded.mujoco.__version__)
            about = {name: vars(asked)[name] for name in ("target", "horizon", "seed", "exact")}
            about |= {"observed": asked.observed, "MuJoCo": self.version, **versions(())}
            digest = sha256(loaded.dumped(loaded.model)).hexdigest()
            store = RunStore(asked.resume, model=digest, **about)
            try:
                yield from self.runs(bench, store)
            finally:
                store.write()

    def runs(self, bench: Bench, store: RunStore) -> Iterator[tuple[int, int, str]]:
        """Run all that there is time for, see `work`; the converged runs have half of it."""
        asked = self.asked
        settings = list(bench.settings(asked.exact))
        starts = list(bench.starts(asked.seed, TRIED))
        total = len(starts) + len(settings)
        half = monotonic() + asked.budget / 2
        for i, start in enumerate(starts):
            yield i, total, f"converged run, {start.name}"
            truth = self.converge(bench, start, store, late=monotonic() > half)
            if isinstance(truth, Converged):
                self.truths.append(truth)
            else:
                self.unknown.append(f"{start.name}: {truth}")
        good: list[Setting] = []
        try:
            for i, setting in enumerate(settings if self.truths else ()):
                yield len(starts) + i, total, setting.name
                if sum(map(setting.alike, good)) < 2:
                    trial = self.tried(bench, setting, store)
                    good += [setting] if trial.error < ENOUGH * asked.target else []
            for setting in self.iterated(bench):
                yield total, total, setting.name
                self.tried(bench, setting, store)
        except TimeUpError:
            self.complete = False
        yield total, total, "the choice, from other starts"
        self.prove(bench, store)

    def converge(
        self, bench: Bench, start: Start, store: RunStore, late: bool = False
    ) -> Converged | str:
        """Return the converged run from a start, or why there is none."""
        key = f"converged run, {start.name}"
        known: Converged | str | None = store.get(key, Converged | str)
        if known is not None:
            return known
        try:
            if late:
                raise TimeUpError
            truth = converge(bench, start, self.asked.target, self.asked.exact)
        except TimeUpError:
            self.complete = False
            return "the time was up before its converged run"
        if isinstance(truth, Converged) or "--budget" not in truth:
            store.put(key, truth)
        return truth

    def tried(self, bench: Bench, setting: Setting, store: RunStore) -> Trial:
        """Add a setting's run to the trials, and return it."""
        point = self.point(bench, setting, self.truths, store)
        settings: dict[str, float] = {}
        if setting.closure:
            settings["closure_steps"] = CLOSURE
        if setting.iterations:
            settings["iterations"] = setting.iterations
        limit = bench.limit(setting)
        series = StepSeries(
            Path(self.file).name, "", ENGINE, "", setting.integrator, 0, settings,
            stable_step=limit if limit < inf else None,
        )  # fmt: skip
        self.trials.append(Trial(series, point))
        return self.trials[-1]

    def point(
        self, bench: Bench, setting: Setting, truths: Sequence[Converged], store: RunStore
    ) -> Point:
        """Return error and cost of a setting over all starts."""
        every = list[Point]()
        for truth in truths:
            key = f"{setting.integrator} {setting[1:]!r}, {truth.start.name}"
            point: Point | None = store.get(key, Point)
            if point is None:
                point = point_of(bench, setting, truth, truth.count(self.asked.target))
                store.put(key, point)
            every.append(point)
        return worst_of(every)

    def iterated(self, bench: Bench) -> Iterator[Setting]:
        """Yield the best settings with other numbers of iterations of the solver, if it has any.

        Where nothing meets the target: the file's own and the one of the least error.
        """
        active = np.any(bench.loaded.model.eq_active0)
        if not self.trials or not (active or any(not one.smooth for one in self.truths)):
            return
        least = min(self.trials, key=lambda row: row.error)
        bases = [self.choice] if self.choice else [self.trials[0], least]
        for base in dict.fromkeys(setting_of(row) for row in bases if row.error < inf):
            yield from bench.iterated(base)

    def prove(self, bench: Bench, store: RunStore) -> None:
        """Run the choice from other starts and with other controls.

        What misses the target there is dropped, and the next shorter step tried if it was not.
        """
        if self.choice is None:
            return
        bench.deadline = max(bench.deadline, monotonic() + self.asked.budget / 4)
        complete = self.complete
        starts = [*bench.starts(self.asked.seed, PROVED), *bench.other_starts(self.asked.seed)]
        others = [self.converge(bench, one, store) for one in starts]
        self.complete = complete
        truths = [one for one in others if isinstance(one, Converged)]
        both = zip(starts, others, strict=True)
        self.unproved = [f"{a.name}: {b}" for a, b in both if not isinstance(b, Converged)]
        self.proved = not truths  # there is nothing to try it with
        try:
            while truths and not self.proved and (choice := self.choice) is not None:
                setting = setting_of(choice)
                error = Trial(choice.series, self.point(bench, setting, truths, store)).error
                self.proved = error <= self.asked.target
                if self.proved:
                    self.elsewhere = error
                    return
                self.missed[setting] = error
                known = {setting_of(trial) for trial in self.trials}
                every = bench.settings(self.asked.exact)
                shorter = (one for one in every if one.alike(setting) and one.step < setting.step)
                if (one := next((one for one in shorter if one not in known), None)) is not None:
                    self.tried(bench, one, store)
        except TimeUpError:
            self.proved = False

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
                points=tuple(sorted((row.point for row in rows), key=lambda p: -(p.step or 0.0))),
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
        rows = [
            row
            for row in steady(self.series, self.asked.target, MARGIN)
            if not {one := setting_of(row), one._replace(iterations=None)} & self.missed.keys()
        ]
        return cheapest(rows, work_of, self.preference)

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
    def softens(self) -> bool:
        """Whether there are closures whose softness was tried."""
        return any(len(one.softness) for one in self.truths)

    @property
    def failed(self) -> bool:
        """Whether no setting meets the target."""
        return self.choice is None

    def as_json(self) -> dict[str, Any]:
        """Return the ``tradeoff_model`` document of docs/json.md."""
        recommended = self.choice
        return document(
            "tradeoff_model",
            self.asked,
            **vars(self)
            | {"file": Path(self.file).name, "asked": self.asked.horizon}
            | {"exact_closures": self.asked.exact, "horizon": self.compared},
            softness=self.largest("softness") if self.softens else None,
            met=recommended is not None,
            sentence=self.sentence,
            notes=self.notes,
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
            series=self.series,
            front=[trial_document(row) for row in self.front],
            own=trial_document(self.own) if self.own else None,
            recommendation=trial_document(recommended) if recommended else None,
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
        error = percent(max(choice.error, self.elsewhere))
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
        target, trials = self.asked.target, self.trials
        said = [f"left out: {one}" for one in self.unknown if self.truths]
        usual = (trials[0].point.step or 0.0) / CONVERGED if trials else 0.0
        for truth, count in zip(self.truths, self.counts, strict=True):
            if count < len(truth.error):
                over = f"compared over {count * self.period:.3g} s"
                said.append(f"{truth.start.name}: {truth.reason(target)}; {over}")
            by, step = truth.setting.integrator, truth.setting.step
            if by != SHARPEST[0] or (usual and step < 0.99 * usual):
                said.append(
                    f"{truth.start.name}: the converged run is by {by} at {1e3 * step:.3g} ms; "
                    f"longer steps, or {SHARPEST[0]}, are not enough"
                )
        if any(not truth.smooth for truth in self.truths):
            said.append(
                "contacts, limits or friction act: errors have no order, and no bound; a start "
                f"that is {DEPARTURE:g} off ends {percent(self.largest('spread'))} apart"
            )
        soft = self.largest("softness")
        if self.softens and soft >= SOFT * target:
            more = "" if self.asked.exact else "; --exact-closures compares with those"
            said.append(
                f"closures as soft as in the file change the motion by {percent(soft)} against "
                f"hard ones{more}"
            )
        said += self.least_iterations()
        said += [
            f"{setting.name} has an error of {percent(error)} from other starts or with other "
            "controls, and is not recommended"
            for setting, error in self.missed.items()
        ]
        if self.choice is not None and not self.proved:
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

    def least_iterations(self) -> list[str]:
        """Return the fewest iterations of the solver that leave the error of a setting as it is."""
        for base in self.trials:
            name = setting_of(base)
            same = [
                int(row.series.settings["iterations"])
                for row in self.trials
                if row.series.settings.get("iterations")
                and setting_of(row)._replace(iterations=None) == name
                and abs(row.error - base.error) <= ALIKE * base.error
            ]
            if same:
                words = f"{plural(min(same), 'iteration')} of the solver"
                return [f"{words} leave the error of {name.name} as it is"]
        return []

    @property
    def observed(self) -> str:
        """The joints and sites that are compared, in words."""
        return ", ".join(self.asked.observed) or "all joints"


def setting_of(row: Trial) -> Setting:
    """Return the setting that made a run."""
    options, step = row.series.settings, row.point.step or 0.0
    iterations = int(options["iterations"]) if "iterations" in options else None
    closure = CLOSURE * step if "closure_steps" in options else None
    return Setting(row.series.method, step, iterations, closure)


def work_of(row: Trial) -> float:
    """Return the evaluations of forces in a simulated second [1/s]."""
    assert row.point.cost is not None
    return row.point.cost.rhs_evaluations or 0.0


def point_of(bench: Bench, setting: Setting, truth: Converged, count: int) -> Point:
    """Return error and cost of a setting from a start.

    A run that takes no more than `BRIEF` is made `MEASURED` times, for its time.

    Parameters
    ----------
    bench : Bench
    setting : Setting
    truth : Converged
    count : int
        Periods over which it is compared.
    """
    runs, began = [], monotonic()
    while len(runs) < MEASURED and (not runs or monotonic() - began < BRIEF):
        runs.append(bench.run(truth.start, setting))
    run, n, times = runs[0], min(count, len(runs[0].positions)), [one.seconds for one in runs]
    steps = 1 / setting.step
    work = steps * EVALUATIONS.get(setting.integrator, 1)
    cost = Cost(median(times), min(times), max(times), steps, work)
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
    times = [cost.seconds for cost in costs]
    fastest, slowest = min(x.fastest for x in costs), max(x.slowest for x in costs)
    cost = replace(costs[0], seconds=median(times), fastest=fastest, slowest=slowest)
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
    runs = [(point.step or 0.0, point.error) for point in series.points]
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
