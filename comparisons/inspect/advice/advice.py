"""Which setting of a user's model to choose: its error against the model's own converged run."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from functools import partial
from math import inf, nan
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np

from ....reference.errors import UsageError
from ...documents import document
from ...engines.mujoco.library import quiet
from ...queries.environment import versions
from ..mujoco.model import ENGINE, Loaded, load
from ..mujoco.trial import edited
from ..views import state_views, step_limits
from .converged import Converged, converge
from .outcome import Outcome, Trial, trial_document
from .runs import PROVED, TRIED, Bench, SampledRun, Setting, Start, harden
from .store import RunStore, packed, unpacked
from .words import notes, sentence

ENOUGH = 0.1
"""Share of the target below which no shorter steps of an integrator are tried."""

MEASURED, BRIEF = 3, 0.1
"""Times that a run is made whose wall time is below this [s]; the median time counts."""


class Advice(Outcome):
    """What accuracy costs of one model, worked out by runs."""

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
            own = {name: vars(asked)[name] for name in ("target", "horizon", "seed", "exact")}
            own |= {"observed": asked.observed, "MuJoCo": self.version, **versions(())}
            store = RunStore(asked.resume, loaded.dumped(loaded.model), **own)
            try:
                yield from self.runs(bench, store)
            finally:
                store.write()

    def runs(self, bench: Bench, store: RunStore) -> Iterator[tuple[int, int, str]]:
        """Run all that there is time for, see `work`; the converged runs have half of it."""
        asked = self.asked
        limits = Limits(bench.loaded)
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
        for i, setting in enumerate(settings if self.truths else ()):
            yield len(starts) + i, total, setting.name
            if sum(map(setting.alike, good)) > 1:
                continue
            trial = self.tried(bench, setting, store, limits)
            if trial is None:
                break
            good += [setting] if trial.error < ENOUGH * asked.target else []
        else:
            for setting in self.iterated(bench):
                yield total, total, setting.name
                if self.tried(bench, setting, store, limits) is None:
                    break
        yield total, total, "the choice, from other starts"
        self.prove(bench, store, limits)

    def converge(
        self, bench: Bench, start: Start, store: RunStore, late: bool = False
    ) -> Converged | str:
        """Return the converged run from a start, or why there is none."""
        key = f"converged run, {start.name}"
        if key in store.entries:
            return unpacked(store.entries[key], start)
        truth = None if late else converge(bench, start, self.asked.target, self.asked.exact)
        if truth is None:
            self.complete = False
            return "the time was up before its converged run"
        if isinstance(truth, Converged) or "--budget" not in truth:
            store.put(key, packed(truth))
        return truth

    def tried(
        self, bench: Bench, setting: Setting, store: RunStore, limits: Limits
    ) -> Trial | None:
        """Add how well a setting does to the trials, and return it; None if the time is up."""
        trial = self.trial(bench, setting, self.truths, store)
        if trial is None:
            self.complete = False
            return None
        trial = Trial(**vars(trial) | {"limit": limits.of(setting)})
        self.trials.append(trial)
        return trial

    def trial(
        self, bench: Bench, setting: Setting, truths: Sequence[Converged], store: RunStore
    ) -> Trial | None:
        """Return how well a setting does from some starts, None if the time is up."""
        times, worst = list[float](), dict.fromkeys(("bound", "energy", "violation", "error"), 0.0)
        failed = ""
        for truth in truths:
            key = f"{setting.integrator} {setting[1:]!r}, {truth.start.name}"
            if key not in store.entries:
                measured = measure(bench, setting, truth, truth.count(self.asked.target))
                if measured is None:
                    return None
                store.put(key, measured)
            one = store.entries[key]
            times += one["seconds"]
            failed = failed or one["failed"]
            worst = {name: max(value, one[name]) for name, value in worst.items()}
        if failed:
            worst = dict.fromkeys(worst, nan) | {"error": inf}
        return Trial(setting, **worst, seconds=float(np.median(times)), failed=failed, limit=inf)

    def iterated(self, bench: Bench) -> Iterator[Setting]:
        """Yield the best settings with other numbers of iterations of the solver, if it has any.

        Where nothing meets the target: the file's own and the one of the least error.
        """
        active = np.any(bench.loaded.model.eq_active0)
        if not self.trials or not (active or any(not one.smooth for one in self.truths)):
            return
        least = min(self.trials, key=lambda one: one.error)
        bases = [self.choice] if self.choice else [self.trials[0], least]
        for base in dict.fromkeys(one.setting for one in bases if one.error < inf):
            yield from bench.iterated(base)

    def prove(self, bench: Bench, store: RunStore, limits: Limits) -> None:
        """Run what would be recommended from other starts and with other controls.

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
        while truths and (choice := self.choice) is not None:
            again = self.trial(bench, choice.setting, truths, store)
            if again is None or again.error <= self.asked.target:
                self.proved, self.elsewhere = again is not None, again.error if again else 0.0
                return
            self.missed[choice.setting] = again.error
            known = {one.setting for one in self.trials}
            for shorter in bench.settings(self.asked.exact):
                less = shorter.alike(choice.setting) and shorter.step < choice.step
                if less and shorter not in known:
                    self.tried(bench, shorter, store, limits)
                    break

    @property
    def sentence(self) -> str:
        """What to do, in one sentence."""
        return sentence(self)

    @property
    def notes(self) -> list[str]:
        """What else is to be known."""
        return notes(self)

    def as_json(self) -> dict[str, Any]:
        """Return the document."""
        return document(
            "tradeoff_model",
            self.asked,
            **vars(self)
            | {"file": Path(self.file).name, "asked": self.asked.horizon}
            | {"exact_closures": self.asked.exact, "horizon": self.compared},
            softness=self.largest("softness") if self.softens else None,
            met=self.choice is not None,
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
            settings=[trial_document(one) for one in self.trials],
            front=[trial_document(one) for one in self.front],
            recommendation=None if self.choice is None else trial_document(self.choice),
            versions={**versions(()), ENGINE: self.version},
        )


class Limits:
    """The largest stable step of small motions, closures as hard as a setting has them."""

    def __init__(self, loaded: Loaded) -> None:
        self.loaded = loaded
        self.known: dict[float | None, dict[str, float]] = {}

    def of(self, setting: Setting) -> float:
        """Return the limit [s]; infinite if there is none, or none is known."""
        closure = setting.closure
        if closure not in self.known:
            loaded = self.loaded
            if closure is not None:
                loaded = edited(loaded, partial(harden, constant=closure))
            limits = step_limits(loaded, state_views(loaded, None, None))
            self.known[closure] = {one.integrator: one.limit for one in limits}
        limit = self.known[closure].get(setting.integrator, inf)
        return limit if limit > 0 else inf


def measure(bench: Bench, setting: Setting, truth: Converged, count: int) -> dict[str, Any] | None:
    """Return errors and times of a setting from a start, None if the time is up.

    A run that takes no more than `BRIEF` is made `MEASURED` times, for its time.

    Parameters
    ----------
    bench : Bench
    setting : Setting
    truth : Converged
    count : int
        Periods over which it is compared.
    """
    runs, began = list[SampledRun](), monotonic()
    while len(runs) < MEASURED and (not runs or monotonic() - began < BRIEF):
        run = bench.run(truth.start, setting)
        if run is None:
            return None
        runs.append(run)
    run, n = runs[0], min(count, len(runs[0].positions))
    lost = run.failed is not None and not truth.run.failed
    place = f"{truth.start.name}, before t = {run.failed:.3g} s" if run.failed is not None else ""
    off = np.abs(run.energy[:n] - truth.run.energy[:n])
    return {
        "seconds": [one.seconds for one in runs],
        "failed": place if lost else "",
        "error": float(np.max(bench.apart(run, truth.run, truth.size)[:n], initial=0.0)),
        "bound": float(np.max(truth.error[:n], initial=0.0)),
        "energy": float(np.max(off, initial=0.0) / (truth.run.kinetic or 1.0)),
        "violation": run.violation,
    }
