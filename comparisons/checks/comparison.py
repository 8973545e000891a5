"""Runs beside the truth: the error that is predicted, what of a run is compared, the findings.

A method whose scheme is published must make exactly the error of that scheme; of another one the
error is predicted from three steps (Richardson), and what they extrapolate to must be the truth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ...reference.equations import ModelEquations, invariants_of
from ...reference.errors import UsageError
from ...reference.scene import Array, Case
from ...reference.solve import schemes
from ..engines.setup import Setup
from .free_vibrations import excitation
from .tolerances import (
    CAP,
    OPEN,
    RICHARDSON_SAFETY,
    SAFETY,
    VIOLATION,
    last_trusted_sample,
    richardson,
    rows,
)
from .truth import Truth
from .verdict import PROFILES, Finding, Inconclusive, Series

REFINEMENTS = 4
"""Times that a step is halved until errors shrink with it as the order says."""

CANCELLED = 1e-3
"""Share of its terms below which an invariant is a sum that cancels."""


class Part(NamedTuple):
    """A run, or part of it: the case that it starts from, and the numbers of its steps (n,)."""

    case: Case
    numbers: Any


class EngineRuns(NamedTuple):
    """What an engine computed in some parts with a step [s], and what it should have.

    Values and expected ones are arrays (k, n) of the scene's observables, all parts side by side.
    """

    setup: Setup
    step: float
    parts: Sequence[Part]
    values: Array
    expected: Array


class Measured(NamedTuple):
    """The findings of a check, and the runs from which they were made, if a cause shows in them."""

    findings: Sequence[Finding | Inconclusive]
    runs: EngineRuns | None = None


# What a right engine would do ----------------------------------------------------------------


@dataclass(frozen=True)
class Prediction:
    """What a correct engine would do.

    Attributes
    ----------
    errors : array (k, n_t)
        Predicted error of each state at each sample.
    safety : float
        Factor on them.
    limit : array (k, n_t)
        The engine's values without the error of its step: the truth if the engine is right.
    spread : array (k, n_t)
        By how much it may still differ from 0, rounding apart.
    shrinks : bool
        Whether the error shrinks with the step as declared; no error is granted if not.
    reason : str
    change : array (k, n_t)
        By how much each state moves when the step is halved.
    unfollowed : str
        Why no right engine's error shrinks as declared; "" if one's does.
    """

    errors: Array
    safety: float
    limit: Array
    spread: Array
    shrinks: bool
    reason: str
    change: Array
    unfollowed: str = ""

    def with_elements(self, change: Array, order: int) -> Prediction:
        """Return it with the error in space that halving the elements showed (k, n_t)."""
        share = np.maximum.accumulate(np.abs(change), axis=1) / (2**order - 1)
        return replace(
            self,
            errors=self.errors + share,
            spread=self.spread + self.safety * share,
            reason=f"{self.reason}; elements are off by up to {float(np.max(share)):.2g}",
        )

    def concludes(self, finding: Finding, change: float) -> Finding | Inconclusive:
        """Return a finding, unless it may come from vibrations that steps do not resolve."""
        return conclusion(finding, change, self.unfollowed)


def exact_prediction(errors: Array, values: Array) -> Prediction:
    """Return that of errors (k,) which are granted as they are, of values (k, n) at any step."""
    none = np.zeros_like(values)
    errors = np.broadcast_to(errors[:, None], values.shape)
    return Prediction(errors, 1.0, values, none, shrinks=True, reason="", change=none)


def by_scheme(scheme: str, values: Array, ideal: Array, right: Truth) -> Prediction:
    """Predict errors by the method's own scheme on the claimed equations of motion."""
    error = ideal - right.values
    return Prediction(
        errors=np.abs(error),
        safety=SAFETY,
        limit=values - error,
        spread=np.zeros_like(values),
        shrinks=True,
        reason=f"distance from {scheme} on the equations of motion",
        change=np.zeros_like(values),
    )


def by_extrapolation(
    order: int, runs: list[Array], right: Truth, names: tuple[str, ...]
) -> Prediction:
    """Predict errors from h, h/2, h/4 (Richardson), if they shrink as declared."""
    change, size = np.abs(runs[0] - runs[1]), right.size[:, None]
    predicted = change * 2**order / (2**order - 1)
    seen = max(1, last_trusted_sample(np.maximum.accumulate(predicted / size, axis=1)))
    states = [i for i, name in enumerate(names) if not name.endswith("_violation")]
    whole = richardson(runs, order)
    estimate = richardson([(run / size)[states, :seen] for run in runs], order)
    shrinks = estimate.shrinks(float(np.max(right.bound / right.size)))
    return Prediction(
        errors=np.maximum.accumulate(predicted, axis=1) if shrinks else 0 * predicted,
        safety=RICHARDSON_SAFETY,
        limit=whole.limit,
        spread=whole.moved if shrinks else 0 * predicted,
        shrinks=shrinks,
        reason=f"value extrapolated to h -> 0; halving divides the error by "
        f"{estimate.ratio:.3g}, {2**order} expected",
        change=change,
    )


def scheme_rows(
    equations: ModelEquations,
    scheme: str | None,
    parts: Sequence[Part],
    step: float,
    names: tuple[str, ...],
    integrates_drive: bool = False,
) -> Array:
    """Return observables (k, n) that a scheme reaches in parts of runs with a step [s].

    Raises
    ------
    UsageError
        If it is none that is published.
    """
    if scheme is None:
        raise UsageError("the method is no published scheme: no error can be computed from it")
    of = schemes.ScalarEquations(equations.scene, equations.parameters, integrates_drive)
    states = [
        schemes.integrate(of, scheme, equations.start(case), step, numbers, case.start_time)
        for case, numbers in parts
    ]
    return rows(equations, np.hstack(states), names)


def ideal_rows(setup: Setup, parts: Sequence[Part], step: float, names: tuple[str, ...]) -> Array:
    """Return observables (k, n) that a right engine reaches by the scheme of a setup."""
    return scheme_rows(
        setup.bound.equations, setup.scheme, parts, step, names, setup.bound.integrates_drive
    )


# What of a run is compared -------------------------------------------------------------------


@dataclass(frozen=True)
class Comparison:
    """Values beside true ones, with the error that is granted of each.

    Attributes
    ----------
    names : tuple of str, k of them
    units : mapping of str to str
        Of states and outputs; violations of a closed loop have none.
    values : array (k, n)
    right : Truth
        With values (k, n).
    prediction : Prediction
    room : float
        What rounding may leave, relative.
    seen : int
        Number of the first samples that are compared.
    """

    names: tuple[str, ...]
    units: Mapping[str, str]
    values: Array
    right: Truth
    prediction: Prediction
    room: float
    seen: int

    @property
    def states(self) -> list[int]:
        """Rows that are no violations."""
        return [i for i, name in enumerate(self.names) if name in self.units]

    def largest(self, errors: Array) -> float:
        """Return the largest of errors (k, n) of states, relative to their sizes."""
        return largest_share(errors[self.states, : self.seen], self.right.size[self.states])

    def observables(
        self, describe: Callable[[int, int], str], over_time: bool
    ) -> list[Finding | Inconclusive]:
        """Return the finding on each row, where it errs most beside what is granted.

        Parameters
        ----------
        describe : callable ``(row, sample) -> str``
            Where that is, in words.
        over_time : bool
            Whether the samples are those of one run, which can be drawn.
        """
        seen, findings = slice(self.seen), list[Finding | Inconclusive]()
        for i, name in enumerate(self.names):
            floor = max(self.room, VIOLATION) if name.endswith("_violation") else self.room
            value, right = self.values[i, seen], self.right.values[i, seen]
            errors, granted = np.abs(value - right), self.prediction.errors[i, seen]
            granted = (
                self.prediction.safety * granted + self.right.bound[i] + floor * self.right.scale[i]
            )
            worst = int(np.argmax(errors / granted))
            finding = Finding(
                name,
                self.unit(name),
                float(value[worst]),
                float(right[worst]),
                float(errors[worst]),
                float(granted[worst]),
                describe(i, worst),
                Series("time", self.right.times[seen], value, right) if over_time else None,
            )
            change = float(np.max(self.prediction.change[i, seen]))
            findings.append(self.prediction.concludes(finding, change))
        return findings

    def unit(self, name: str) -> str:
        """Return the unit of an observable or of a violation."""
        return self.units.get(name, "m" if name.startswith("position") else "m/s")

    def limit(
        self, name: str, value: float, reference: float, reason: str
    ) -> Finding | Inconclusive:
        """Judge a number of all states without the error of the step, relative to their sizes.

        What halving leaves open beyond all that is ever granted can tell neither right nor wrong.
        """
        known = float(np.max((self.right.bound / self.right.size)[self.states]))
        spread, error = self.largest(self.prediction.spread), abs(value - reference)
        granted = min(spread, CAP**2) + self.room
        granted += known
        open_to = granted + max(0.0, spread - CAP**2)
        if granted < error <= open_to:
            return Inconclusive(
                name,
                f"halving steps and elements leaves {open_to:.2g} open, and no more than "
                f"{CAP**2:.2g} is granted: choose more of them",
            )
        finding = Finding(name, "1", value, reference, error, granted, reason)
        return self.prediction.concludes(finding, self.largest(self.prediction.change))


@dataclass(frozen=True)
class RunComparison(Comparison):
    """An engine's runs with a step [s] beside the truth, all parts of them side by side."""

    setup: Setup
    step: float
    parts: Sequence[Part]

    @property
    def runs(self) -> EngineRuns:
        """The runs beside those of a right engine: of a scheme with its error, else the truth."""
        count, expected = len(self.setup.scene.observables), self.right.values
        if self.setup.scheme:
            expected = expected + self.values - self.prediction.limit
        return EngineRuns(self.setup, self.step, self.parts, self.values[:count], expected[:count])


def largest_share(errors: Array, size: Array) -> float:
    """Return the largest of errors (k, n), relative to their sizes (k,)."""
    return float(np.max(np.abs(errors) / size[:, None]))


def conclusion(finding: Finding, change: float, unfollowed: str) -> Finding | Inconclusive:
    """Return a finding, or nothing where it may come from vibrations that steps do not resolve.

    ``change`` is by how much the quantity moves when the step is halved.
    """
    least = PROFILES["strict"] * finding.tolerance
    if unfollowed and least < finding.error < OPEN * change:
        return Inconclusive(finding.quantity, f"too coarse to tell: {unfollowed}")
    return finding


def unfollowed_vibrations(
    setup: Setup, step: float, horizon: float, right: Truth, room: float
) -> str:
    """Return which vibrations a start excites that steps [s] do not follow, "" if none is seen."""
    lost, count = excitation(setup, step, horizon), len(setup.scene.observables)
    seen = lost.amplitudes / right.size[:count] > room + (right.bound / right.size)[:count]
    return (
        f"the start shakes vibrations above {lost.omega:.3g} rad/s, which steps of {step:.3g} s do "
        f"not follow over {horizon:.3g} s"
        if np.any(seen)
        else ""
    )


# What a motion conserves ---------------------------------------------------------------------


def drifts(
    equations: ModelEquations, case: Case, times: Any, values: Mapping[str, Array]
) -> dict[str, Array]:
    """Return (I(t) - I) / I (n_t,) of a run, by the reference's formula or as the engine tells.

    What it tells counts where its states do not give it. I is that at the start. Where the scene
    was driven, I(t) is counted from the end of the drive on, relative to the largest value before:
    a pulse may leave none of its momentum.
    """
    scene, c = equations.scene, equations.scene.coefficients(equations.parameters)
    end = scene.drive_end_time(equations.parameters)
    has_states, drift = set(scene.state_names) <= set(values), {}
    for name, invariant in invariants_of(equations).items():
        if name in values and not has_states:
            series = values[name]
        else:
            states = np.array([values[state] for state in scene.state_names])
            series = np.asarray(invariant(*np.split(states, 2), c))
        if end:
            quiet = series[times >= end]
            drift[name] = (quiet - quiet[0]) / np.max(np.abs(series))
        else:
            q, v = np.split(equations.start(case), 2)
            first = invariant(q, v, c)
            drift[name] = (series - first) / invariant_size(invariant, first, q, v, c)
    return drift


def invariant_size(invariant: Any, first: Any, q: Array, v: Array, c: Any) -> Any:
    """Return to what a drift is related: the value at the start, or terms that cancel in it.

    The terms are what each rate (n,) alone makes of it: a momentum may be the small difference of
    large ones, or 0.
    """
    terms = sum(
        abs(invariant(q, rate * unit, c)) for rate, unit in zip(v, np.eye(len(v)), strict=True)
    )
    return first if abs(first) > CANCELLED * terms else terms
