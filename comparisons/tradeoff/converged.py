"""The model's own converged run from a start, and how long it is known."""

from __future__ import annotations

from dataclasses import dataclass, field
from time import monotonic

import numpy as np

from ...reference.scene import Array
from .bench import CONVERGED, Bench, SampledRun, Setting, Start, TimeUpError, time_constants
from .table import percent

SHARPEST = ("RK4", "implicitfast")
"""Integrators of the converged run: the second where the first loses the state, as it does where
joints are damped so strongly that only an implicit method keeps them."""

FINER = (1, 4, 16)
"""Times by which its steps are shorter still, where the motion is smooth and these are too long."""

KNOWN = 0.25
"""Share of the target by which the converged run may be uncertain: beyond, nothing is compared."""

DEPARTURE = 1e-6
"""Of the start, in the size of the motion, by which a run is tried for what it makes of errors."""

STILL = 1e-6
"""Motion (m, rad) below which nothing moves."""

LEAST = 5
"""Periods over which comparing makes sense."""

HARD = 16
"""Parts of the file's time constants that closures have which count as exact."""

TIME_UP = "the time was up before its converged run"
"""Why there is no converged run, if nothing else is known."""

WORK = 5.0
"""Times as long as before that runs take whose steps are a quarter."""


def nothing() -> Array:
    """Return no numbers."""
    return np.zeros(0)


@dataclass(frozen=True)
class Converged:
    """The converged run from a start, and how long it is known.

    Attributes
    ----------
    start : Start
    setting : Setting
    run : SampledRun
    size : array (n,)
        Of the observables.
    error : array (n_periods,)
        By how much it changes with half the step, relative; and with closures half as hard, where
        these count as exact.
    spread : array (n_periods,)
        By how much with a start that is `DEPARTURE` off.
    softness : array (n_periods,)
        By how much it is another with closures as soft as in the file, or, where they are that,
        with hard ones; empty without closures.
    """

    start: Start
    setting: Setting
    run: SampledRun
    size: Array
    error: Array = field(default_factory=nothing)
    spread: Array = field(default_factory=nothing)
    softness: Array = field(default_factory=nothing)

    def count(self, target: float) -> int:
        """Return the number of periods over which it is known for a target."""
        most = KNOWN * target
        return min(known(self.error, most), known(self.spread, most))

    @property
    def unmoved(self) -> bool:
        """Whether nothing moves."""
        return float(np.max(self.size, initial=0.0)) < STILL

    @property
    def smooth(self) -> bool:
        """Whether there were no contacts, limits and friction."""
        return self.run.rows == 0

    def grows(self, target: float) -> bool:
        """Return whether small errors grow too much, whatever the step."""
        most = KNOWN * target
        return known(self.error, most) > known(self.spread, most)

    def reason(self, target: float) -> str:
        """Return why it is not known for longer."""
        if self.run.failed is not None:
            return f"the converged run itself loses its state at t = {self.run.failed:.3g} s"
        cause = "contacts, limits or friction" if not self.smooth else "the motion"
        if self.grows(target):
            return f"small errors grow ({cause}): a start that is {DEPARTURE:g} off goes elsewhere"
        most = KNOWN * target
        words = f"{cause} left no converged run that is good to {percent(most)}"
        tried = f"by {self.setting.integrator} at {1e3 * self.setting.step:.3g} ms"
        what = "half of them or closures twice as soft" if self.setting.closure else "half of them"
        return f"{words} ({tried} steps, {what} change it by {percent(float(np.max(self.error)))})"


def converge(bench: Bench, start: Start, late: bool = False) -> Converged | str:
    """Return the converged run from a start, or why there is none.

    Parameters
    ----------
    bench : Bench
        Keeps it.
    start : Start
    late : bool
        Whether there is no time to compute it.
    """
    key = f"converged run, {start.name}"
    truth: Converged | str | None = bench.store.get(key, Converged | str)
    if truth is not None:
        return truth
    try:
        truth = TIME_UP if late else refined(bench, start)
    except TimeUpError:
        return TIME_UP
    if isinstance(truth, Converged) or (truth != TIME_UP and "--budget" not in truth):
        bench.store.put(key, truth)
    return truth


def refined(bench: Bench, start: Start) -> Converged | str:
    """Compute the converged run from a start, or why there is none.

    Its steps are refined where the motion is smooth and they are too long: one that no time is left
    for is told, with what it would take.

    Raises
    ------
    TimeUpError
        If there was no time.
    """
    target, exact = bench.asked.target, bench.asked.exact
    constants = time_constants(bench.loaded.model)
    closure = float(np.min(constants)) / HARD if exact and len(constants) else None
    best: Converged | None = None
    took = 0.0
    for finer in FINER:
        if best and monotonic() + WORK * took > bench.deadline:
            step = 1e3 * bench.file.step / CONVERGED / finer
            need = f"steps of {step:.2g} ms take about {WORK * took:.0f} s: --budget may give it"
            return f"{best.reason(target)}; {need}"
        began = monotonic()
        for integrator in SHARPEST:
            setting = Setting(integrator, bench.file.step / CONVERGED / finer, closure=closure)
            truth = converged_by(bench, start, setting)
            if truth.unmoved:
                return "nothing moves"
            best = max(best or truth, truth, key=lambda one: one.count(target))
            known_long = truth.count(target) >= min(LEAST, bench.count)
            if truth.run.failed is None and known_long:
                return truth
            if truth.run.failed is None and (truth.grows(target) or not truth.smooth):
                return truth.reason(target)  # no other step helps
        took = monotonic() - began
    assert best is not None
    return best if best.count(target) >= min(LEAST, bench.count) else best.reason(target)


def converged_by(bench: Bench, start: Start, setting: Setting) -> Converged:
    """Return the run by a setting, with its uncertainty."""
    whole = bench.run(start, setting, sharp=True)
    size = bench.sizes(whole)
    largest = float(np.max(size, initial=0.0))
    if largest < STILL:
        return Converged(start, setting, whole, size)
    coarse = setting._replace(step=2 * setting.step)
    half = bench.run(start, coarse, sharp=True)
    beside = bench.run(start, coarse, sharp=True, off=DEPARTURE * min(largest, 1.0))
    error, spread = (bench.apart(a, b, size) for a, b in ((half, whole), (beside, half)))
    softness = nothing()
    if len(constants := time_constants(bench.loaded.model)):
        hard = float(np.min(constants)) / HARD
        for closure in (2 * hard, None) if setting.closure else (hard,):
            other = bench.run(start, setting._replace(closure=closure), sharp=True)
            softness = bench.apart(other, whole, size)
            if setting.closure and closure:
                error = np.maximum(error, np.resize(softness, len(error)))
    return Converged(start, setting, whole, size, error, spread, softness)


def known(errors: Array, most: float) -> int:
    """Return the number of periods before an error first exceeds a bound."""
    above = np.flatnonzero(~(errors <= most))
    return int(above[0]) if len(above) else len(errors)
