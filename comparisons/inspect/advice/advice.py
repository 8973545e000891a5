"""Which setting of a user's model to choose: its error against the model's own converged run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import inf, nan
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np

from ....reference.errors import UsageError
from ....reference.scene import Array
from ...documents import document
from ...engines.mujoco.library import quiet
from ...queries.environment import versions
from ..inspection import subject_of
from ..mujoco.model import ENGINE, load
from ..subject import StepLimit
from .runs import CONVERGED, PROVED, TRIED, Bench, SampledRun, Setting, Start

SHARPEST = ("RK4", "implicitfast")
"""Integrators of the converged run: the second where the first loses the state, as it does where
joints are damped so strongly that only an implicit method keeps them."""

KNOWN = 0.25
"""Share of the target by which the converged run may be uncertain: beyond, nothing is compared."""

NOISE = 1.25
"""Times that differ by no more than this factor are about the same."""

MARGIN = 0.5
"""Share of the target that a recommended setting may use: with other controls it errs otherwise."""

DEPARTURE = 1e-6
"""Of the start, in the size of the motion, by which a run is tried for what it makes of errors."""

STILL = 1e-6
"""Motion (m, rad) below which nothing moves."""

LEAST = 5
"""Periods over which comparing makes sense."""

ENOUGH = 0.1
"""Share of the target below which no shorter steps of an integrator are tried."""

RELIABLE = 1.02
"""A step above this many times a limit is one that the limit calls unstable."""


@dataclass(frozen=True)
class Converged:
    """The converged run from a start, and how long it is known.

    Attributes
    ----------
    start : Start
    integrator : str
    run : SampledRun
    size : array (n,)
        Of the observables.
    error : array (n_periods,)
        By how much it changes with half the step, relative.
    spread : array (n_periods,)
        By how much with a start that is `DEPARTURE` off.
    count : int
        Periods over which both stay below a share of the target.
    """

    start: Start
    integrator: str
    run: SampledRun
    size: Array
    error: Array
    spread: Array
    count: int

    @property
    def smooth(self) -> bool:
        """Whether there were no contacts, limits and friction."""
        return self.run.rows == 0


@dataclass(frozen=True)
class Trial:
    """What a setting costs and how well it does, over all starts.

    Attributes
    ----------
    setting : Setting
    error : float
        The largest of all starts, relative; infinite where the state was lost.
    bound : float
        Of the converged runs there.
    energy : float
        Largest difference of the energy, in the largest kinetic energy.
    violation : float
        Largest residual of an equality (m, rad).
    seconds : float
        Wall time [s/s].
    failed : str
        Where the state was lost, and when; empty if it was not.
    limit : float
        The largest stable step of small motions [s]; infinite if there is none, or none is known.
    """

    setting: Setting
    error: float
    bound: float
    energy: float
    violation: float
    seconds: float
    failed: str
    limit: float

    @property
    def integrator(self) -> str:
        """Of the setting."""
        return self.setting.integrator

    @property
    def step(self) -> float:
        """Of the setting [s]."""
        return self.setting.step


@dataclass
class Advice:
    """What accuracy costs of one model.

    Attributes
    ----------
    file : str
    target, horizon, budget : float
        Relative error, and times [s].
    seed : int
        Of the moving controls.
    observed : tuple of str
    truths : list of Converged
    trials : list of Trial
    unknown : list of str
        Starts that were left out, each with its reason.
    complete : bool
        Whether the time was enough.
    missed : mapping of Setting to float
        What would have been recommended, and its error with other controls.
    proved : bool
        Whether what is recommended met the target with other controls.
    period : float
        After which runs are compared [s].
    version : str
        MuJoCo's.
    """

    file: str
    target: float = 0.01
    horizon: float = 1.0
    budget: float = 120.0
    seed: int = 1
    observed: tuple[str, ...] = ()
    truths: list[Converged] = field(default_factory=list)
    trials: list[Trial] = field(default_factory=list)
    unknown: list[str] = field(default_factory=list)
    complete: bool = True
    missed: dict[Setting, float] = field(default_factory=dict)
    proved: bool = False
    period: float = 0.0
    version: str = ""

    def work(self) -> Iterator[tuple[int, int, str]]:
        """Run all that there is time for; yields ``(done, total, what)``.

        Raises
        ------
        UsageError
            If the file cannot be read, nothing moves in it, or a number makes no sense.
        """
        for name in ("target", "horizon", "budget"):
            value = getattr(self, name)
            if not 0 < value < inf:
                raise UsageError(f"--{name} must be a positive number, not {value:g}")
        if self.target >= 1:
            raise UsageError(f"--target is a relative error below 1, not {self.target:g}")
        loaded = load(self.file)
        if loaded.model.nv == 0:
            raise UsageError(f"{loaded.path.name}: nothing moves in it")
        with quiet(loaded.mujoco):
            bench = Bench(loaded, self.horizon, self.observed, monotonic() + self.budget)
            self.period, self.version = bench.period, str(loaded.mujoco.__version__)
            limits = {one.integrator: one for one in subject_of(loaded).steps}
            settings, starts = list(bench.settings()), list(bench.starts(self.seed, TRIED))
            total = len(starts) + len(settings)
            half = monotonic() + self.budget / 2
            for i, start in enumerate(starts):
                yield i, total, f"converged run, {start.name}"
                if monotonic() > half:
                    self.late(start)
                elif truth := self.converge(bench, start):
                    self.truths.append(truth)
            done: dict[str, int] = {}
            for i, setting in enumerate(settings):
                yield len(starts) + i, total, setting.name
                if not self.truths or done.get(setting.integrator, 0) > 1:
                    continue
                trial = self.tried(bench, setting, self.truths, limits.get(setting.integrator))
                if trial is None:
                    self.complete = False
                    break
                self.trials.append(trial)
                good = trial.error < ENOUGH * self.target
                done[setting.integrator] = done.get(setting.integrator, 0) + good
            yield total, total, "the choice, with other controls"
            self.prove(bench)

    def late(self, start: Start) -> None:
        """Note that there was no time for the converged run from a start."""
        self.complete = False
        self.unknown.append(f"{start.name}: the time was up before its converged run")

    def converge(self, bench: Bench, start: Start) -> Converged | None:
        """Return the converged run from a start, if it is known for long enough."""
        step = bench.file.step / CONVERGED
        for integrator in SHARPEST:
            fine, coarse = Setting(integrator, step), Setting(integrator, 2 * step)
            whole = bench.run(start, fine, sharp=True)
            size = np.ones(1) if whole is None else bench.sizes(whole)
            largest = float(np.max(size, initial=0.0))
            if largest < STILL:
                self.unknown.append(f"{start.name}: nothing moves")
                return None
            half = whole and bench.run(start, coarse, sharp=True)
            off = DEPARTURE * min(largest, 1.0)
            beside = half and bench.run(start, coarse, sharp=True, off=off)
            if whole is None or half is None or beside is None:
                self.late(start)
                return None
            runs = whole, half, beside
            if all(run.failed is None for run in runs):
                break
        whole, half, beside = runs
        error, spread = (bench.apart(a, b, size) for a, b in ((half, whole), (beside, half)))
        count = min(known(error, KNOWN * self.target), known(spread, KNOWN * self.target))
        truth = Converged(start, fine.integrator, whole, size, error, spread, count)
        if count < min(LEAST, bench.count):
            self.unknown.append(f"{start.name}: {why_unknown(truth, bench, self.target)}")
            return None
        return truth

    def prove(self, bench: Bench) -> None:
        """Run what would be recommended with other controls; drop what misses the target there."""
        if self.choice is None:
            return
        bench.deadline = max(bench.deadline, monotonic() + self.budget / 4)
        unknown, complete = list(self.unknown), self.complete
        others = [self.converge(bench, start) for start in bench.starts(self.seed, PROVED)]
        self.unknown, self.complete = unknown, complete
        truths = [one for one in others if one is not None]
        self.proved = not others  # there are no controls to vary
        while truths and (choice := self.choice) is not None:
            again = self.tried(bench, choice.setting, truths, None)
            if again is None or again.error <= self.target:
                self.proved = again is not None
                return
            self.missed[choice.setting] = again.error

    def tried(
        self,
        bench: Bench,
        setting: Setting,
        truths: Sequence[Converged],
        limit: StepLimit | None,
    ) -> Trial | None:
        """Return how well a setting does from some starts, None if the time is up."""
        error = bound = energy = violation = 0.0
        seconds, failed = list[float](), ""
        for truth in truths:
            run = bench.run(truth.start, setting)
            if run is None:
                return None
            seconds.append(run.seconds)
            if run.failed is not None and not truth.run.failed:
                failed = failed or f"{truth.start.name}, before t = {run.failed:.3g} s"
                error = inf
                continue
            n = min(truth.count, len(run.positions))
            error = max(error, float(np.max(bench.apart(run, truth.run, truth.size)[:n])))
            bound = max(bound, float(np.max(truth.error[:n])))
            off = np.max(np.abs(run.energy[:n] - truth.run.energy[:n]))
            energy = max(energy, float(off / (truth.run.kinetic or 1.0)))
            violation = max(violation, run.violation)
        known_limit = limit.limit if limit is not None and limit.limit > 0 else inf
        if failed:
            bound = energy = violation = nan
        time = float(np.median(seconds))
        return Trial(setting, error, bound, energy, violation, time, failed, known_limit)

    # What follows

    @property
    def front(self) -> list[Trial]:
        """What nothing beats in both error and time, the fastest first."""
        front: list[Trial] = []
        for one in sorted(self.trials, key=lambda trial: (trial.seconds, trial.error)):
            if one.error < min((other.error for other in front), default=inf):
                front.append(one)
        return [one for one in front if one.error < 1]

    @property
    def choice(self) -> Trial | None:
        """The fastest setting that meets the target with a margin, as shorter steps of it do."""
        good = [one for one in self.trials if one.error <= MARGIN * self.target]
        steady = [
            one
            for one in good
            if all(
                other.error <= self.target
                for other in self.trials
                if other.integrator == one.integrator and other.step < one.step
            )
            and one.step <= RELIABLE * one.limit
            and one.setting not in self.missed
        ]
        fastest = min((one.seconds for one in steady), default=0.0)
        alike = [one for one in steady if one.seconds <= NOISE * fastest]
        return min(alike, key=self.preference, default=None)

    def preference(self, one: Trial) -> tuple[bool, bool, float, float]:
        """Return what settings that cost about the same are ordered by, the best first."""
        own = self.trials[0].setting
        return one.setting != own, one.integrator != own.integrator, -one.step, one.error

    @property
    def own(self) -> Trial | None:
        """The file's own setting, which is tried first."""
        return self.trials[0] if self.trials else None

    @property
    def compared(self) -> float:
        """Time over which all starts are compared [s]."""
        return min((truth.count for truth in self.truths), default=0) * self.period

    @property
    def sentence(self) -> str:
        """What to do, in one sentence."""
        choice, own = self.choice, self.own
        if not self.truths:
            words = "nothing converges" if self.complete else f"no answer in {self.budget:g} s"
            return f"{words}: " + "; ".join(self.unknown)
        over = f"over {self.compared:.3g} s"
        if not self.trials:
            return f"no setting was tried in {self.budget:g} s; --budget gives more"
        if choice is None:
            best = min(self.trials, key=lambda one: one.error, default=None)
            if best is None or best.error == inf:
                return f"no setting came to an end {over}"
            return (
                f"no setting meets {percent(self.target)} with a margin {over}; the least error is "
                f"{percent(best.error)}, of {best.setting.name}"
            )
        said = f"{choice.setting.name}: {percent(choice.error)} {over}"
        if own is None or choice is own:
            return f"{said}, the file's own setting"
        faster = own.seconds / choice.seconds
        compared = "about as fast as" if 1 / NOISE < faster < NOISE else ""
        compared = compared or (
            f"{faster:.2g} times as fast as"
            if faster >= 1
            else f"it takes {1 / faster:.2g} times as long as"
        )
        compared += " the file's setting"
        mine = "which loses its state" if own.failed else f"which errs by {percent(own.error)}"
        if MARGIN * self.target < own.error <= self.target:
            mine += ": no margin for other motions"
        return f"{said}, {compared} ({own.setting.name}, {mine})"

    @property
    def notes(self) -> list[str]:
        """What else is to be known."""
        notes = [f"left out: {one}" for one in self.unknown if self.truths]
        for truth in self.truths:
            if truth.count < len(truth.error):
                notes.append(
                    f"{truth.start.name}: {why_unknown(truth, None, self.target)}; "
                    f"compared over {truth.count * self.period:.3g} s"
                )
        for truth in self.truths:
            if truth.integrator != SHARPEST[0]:
                notes.append(
                    f"{truth.start.name}: the converged run is by {truth.integrator}, since "
                    f"{SHARPEST[0]} loses the state even at its short step"
                )
        if any(not truth.smooth for truth in self.truths):
            worst = max(float(np.max(one.spread[: one.count])) for one in self.truths)
            notes.append(
                "contacts, limits or friction act: errors have no order, and no bound; a start "
                f"that is {DEPARTURE:g} off ends {percent(worst)} apart"
            )
        notes += [
            f"{setting.name} errs by {percent(error)} with other controls, and is not recommended"
            for setting, error in self.missed.items()
        ]
        if self.choice is not None and not self.proved:
            notes.append("there was no time to try the choice with other controls")
        notes += disagreements(self.trials)
        if not self.complete:
            notes.append(f"not all was tried in {self.budget:g} s; --budget gives more")
        return notes

    def as_json(self) -> dict[str, Any]:
        """Return the document."""
        return document(
            "tradeoff_model",
            self,
            horizon=self.compared,
            asked=self.horizon,
            met=self.choice is not None,
            sentence=self.sentence,
            notes=self.notes,
            starts=[
                {
                    "name": one.start.name,
                    "compared": one.count * self.period,
                    "smooth": one.smooth,
                    "bound": float(np.max(one.error[: one.count])),
                    "spread": float(np.max(one.spread[: one.count])),
                }
                for one in self.truths
            ],
            settings=[trial_document(one) for one in self.trials],
            front=[trial_document(one) for one in self.front],
            recommendation=None if self.choice is None else trial_document(self.choice),
            versions={**versions(()), ENGINE: self.version},
            file=Path(self.file).name,
        )


def known(errors: Array, most: float) -> int:
    """Return the number of periods before an error first exceeds a bound."""
    above = np.flatnonzero(~(errors <= most))
    return int(above[0]) if len(above) else len(errors)


def why_unknown(truth: Converged, bench: Bench | None, target: float) -> str:
    """Return why a converged run is not known for longer."""
    if bench is not None and truth.run.failed is not None:
        return f"the converged run itself loses its state at t = {truth.run.failed:.3g} s"
    cause = "contacts, limits or friction" if not truth.smooth else "the motion"
    by_step = known(truth.error, KNOWN * target)
    if by_step <= known(truth.spread, KNOWN * target):
        return f"{cause} left no converged run that is good to {percent(KNOWN * target)}"
    return f"small errors grow ({cause}): a start that is {DEPARTURE:g} off goes elsewhere"


def disagreements(trials: Sequence[Trial]) -> list[str]:
    """Return where limits of small motions and runs say different things."""
    said = []
    for name in dict.fromkeys(one.integrator for one in trials):
        mine = [one for one in trials if one.integrator == name]
        limit = mine[0].limit
        lost = [one.step for one in mine if one.failed and one.step < limit / RELIABLE]
        harmless = [one.step for one in mine if one.error < 0.1 and one.step > RELIABLE * limit]
        if lost:
            words = f"below its limit of small motions, {1e3 * limit:.4g} ms"
            words = words if limit < inf else "though small motions limit no step"
            said.append(f"{name} loses its state at {1e3 * min(lost):.4g} ms, {words}")
        if harmless:
            said.append(
                f"{name} at {1e3 * max(harmless):.4g} ms is above its limit of small motions, "
                f"{1e3 * limit:.4g} ms: over this time it came to no harm, and is not recommended"
            )
    return said


def trial_document(one: Trial) -> dict[str, Any]:
    """Return a trial as a document holds it."""
    return {
        **vars(one),
        "setting": one.setting.name,
        "integrator": one.integrator,
        "step": one.step,
    }


def percent(value: float) -> str:
    """Return a share in per cent."""
    return "lost" if value == inf or value is nan else f"{100 * value:.2g} %"
