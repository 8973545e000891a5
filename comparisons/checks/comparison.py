"""Runs compared with the reference: predicted errors, the samples that count, the findings.

A method whose scheme is published must make exactly the error of that scheme; of another one the
error is predicted from three steps (Richardson), and what they extrapolate to must be the truth.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from ...reference.equations import ModelEquations, invariants_of
from ...reference.errors import UsageError
from ...reference.scene import Array, Case
from ...reference.solve import schemes
from ..engines.setup import Setup
from .free_vibrations import excitation
from .mistakes.observables import Observed
from .truth import Truth, rows
from .verdict import PROFILES, Finding, Inconclusive, Series

SAFETY = 1.2
"""Safety factor on an error predicted with the engine's own scheme, for round-off and `strict`."""

RICHARDSON_SAFETY = 1.5
"""Safety factor on an error predicted from two steps: for the next order, and for round-off, which
grows in shorter steps of position constraints (Petzold and Loetstedt, SIAM J. Sci. Comput. 7)."""

CAP = 0.05
"""No predicted error above this share of a quantity's range is granted as tolerance."""

ROUNDING = 1e-10
"""Relative error granted to closed-form algebra; a thousand times what either engine needs."""

UNITS = 256
"""Units of rounding that closed-form algebra of some joints may lose."""

OPERATIONS = 8
"""Times that each term of a force or an inertia is rounded on its way into a sum."""

LEAST = 1e-6
"""No method of order p errs in a step by less than this share of what Taylor's polynomial of degree
p leaves: DOPRI5, the sharpest of all that were tried, errs by 3e-4 of it and more."""

NEXT_ORDERS = 3.0
"""Safety factor on the error of an extrapolated value: the terms of the next two orders may nearly
cancel in the one halving from which it is estimated."""

CLEAR = 100.0
"""A change with the step above this multiple of round-off is a truncation error."""

OPEN = 8.0
"""Before the asymptotic range of steps, an error below this multiple of the change by halving the
step may still vanish with the step: it is not judged."""

ORBIT_REFINEMENTS = 3
"""Times that the steps of orbits are halved until errors shrink with them as the order says."""

ORBIT_STEPS = {1: 512, 2: 64, 3: 64, 4: 48, 5: 40, 6: 32}
"""Steps in the shortest period of an orbit, by order of the method, to begin with."""

VIOLATION = 1e-9
"""Residual of a closed loop, relative to its lengths, that an iteration leaves which stops at
relative increments of 1e-11, with a margin: no drift."""

REFINEMENTS = 4
"""Times that a step is halved until errors shrink with it as the order says."""

CANCELLED = 1e-3
"""Share of its terms below which an invariant is a sum that cancels."""


class Part(NamedTuple):
    """A run, or part of it: the case that it starts from, and the numbers of its steps (n,)."""

    case: Case
    numbers: Any


@dataclass(frozen=True)
class EngineRuns(Observed):
    """Observables of an engine in some parts of runs with a step [s], all parts side by side."""

    setup: Setup
    step: float
    parts: Sequence[Part]

    @classmethod
    def of(
        cls, setup: Setup, step: float, parts: Sequence[Part], values: Array, right: Array
    ) -> Self:
        """Return runs with these values and expected ones (k, n) of the scene's observables."""
        size = np.max(np.abs(right), axis=1, keepdims=True)
        size, scene = np.where(size > 0, size, 1.0), setup.scene
        return cls(scene, scene.observables, values, right, size, setup, step, parts)


class Measured(NamedTuple):
    """The findings of a check, and the runs from which they were made, if a cause shows in them."""

    findings: Sequence[Finding | Inconclusive]
    runs: EngineRuns | None = None


def model_error(measured: float, predicted: float, tolerance: float, reason: str) -> Finding:
    """Compare a model's distance from its scene, as an engine shows it, with the prediction."""
    error = abs(measured - predicted)
    return Finding("model_error", "1", measured, predicted, error, tolerance, reason)


# Rounding and extrapolation -------------------------------------------------------------------


def matrix_rounding(epsilon: float, granted: float) -> float:
    """Relative error granted to an engine's matrices and forces: `granted`, or what rounding may.

    A sum of as many terms as a joint or a body has, each rounded, is off by few units.
    """
    return max(granted, UNITS * epsilon)


def largest_inertias(matrices: Array, alike: NDArray[np.bool_]) -> Array:
    """Return the largest inertia (n,) that enters the sums of each row of mass matrices (k, n, n).

    It is that of the bodies beyond a joint i about the farthest joint j of the same unit (`alike`,
    (n, n)), at least M_ij^2 / M_ii: at the end of a chain a sum is small compared with its terms.
    """
    inertia = np.abs(np.diagonal(matrices, axis1=1, axis2=2))[:, :, None]
    about = np.where(alike, matrices**2 / np.where(inertia > 0, inertia, np.inf), 0.0)
    return np.asarray(np.max(about, axis=(0, 2)))


def taylor_remainder(motion: Array, size: Array, order: int) -> float:
    """Return the remainder of a motion's Taylor polynomial of this degree after a step.

    Parameters
    ----------
    motion : array (k, ..., n_t)
        Observables after equal steps, over ``order + 1`` of them or more.
    size : array (k,)
        To which it is related.
    order : int
        Degree p; the remainder is the difference of order p + 1 over (p + 1)!, its median over the
        samples of the motion, since the end of a drive makes one of them large.
    """
    differences = np.abs(np.diff(motion, n=order + 1, axis=-1)) / math.factorial(order + 1)
    shares = (differences.reshape(len(size), -1) / size[:, None]).max(axis=0)
    return float(np.median(shares))


def least_error(
    order: int, step: float, error: float, bound: float, remainder: float
) -> Finding | Inconclusive:
    """Judge if the error of a step is below the least that its order allows.

    Parameters
    ----------
    order : int
    step : float
        Step [s].
    error, bound : float
        Relative error of the engine, and what its reference leaves open.
    remainder : float
        `taylor_remainder` of the true motion with this step.
    """
    least = LEAST * remainder
    if 0 < least < bound:
        reason = f"a step of {step:.3g} s may err by {least:.2g}, less than the reference resolves"
        return Inconclusive("least_error", reason)
    return Finding(
        "least_error",
        "1",
        error,
        least,
        least / (error + bound) if least else 0.0,
        1.0,
        f"the error of a method of order {order} is {least:.2g} or more with h = {step:.3g} s: "
        "with a smaller error it sub-steps or misdeclares its order",
    )


def last_trusted_sample(predicted: Array) -> int:
    """Return up to which sample the predicted relative errors (..., n_t) stay below `CAP`.

    A coarse method is judged up to the time at which its own error reaches this limit.
    """
    worst = np.maximum.accumulate(np.max(np.atleast_2d(predicted), axis=0))
    return int(np.searchsorted(worst, CAP / RICHARDSON_SAFETY, side="right"))


def sample_numbers(horizon: float, step: float, count: int = 32) -> NDArray[np.int_]:
    """Return about ``count`` step numbers spread evenly over a horizon.

    If the step is a power of two, the reference is stored at their times.
    """
    every = max(1, int(2.0 ** np.round(np.log2(max(1.0, horizon / step / count)))))
    return every * np.arange(1, max(1, int(horizon / step / every * (1 + 1e-12))) + 1)


@dataclass(frozen=True)
class Richardson:
    """Richardson extrapolation of a quantity from runs at h, h/2 and h/4.

    Attributes
    ----------
    predicted : float
        Error at h, with `RICHARDSON_SAFETY`.
    limit : array
        Value extrapolated to h -> 0 from the finer two.
    moved : array
        By how much that moved when the step was halved.
    change, ratio : float
        Largest change by halving, mostly that from h to h/2, and how many times larger this one is
        than that from h/2 to h/4.
    order : int
    """

    predicted: float
    limit: Array
    moved: Array
    change: float
    ratio: float
    order: int

    def is_regular(self, floor: float) -> bool:
        """Return True if it converges with its order, and so can be extrapolated."""
        inside = 2 ** (self.order - 0.5) < self.ratio < 2 ** (self.order + 1)
        return self.change < CLEAR * floor or inside

    def shrinks(self, floor: float) -> bool:
        """Return True if the error shrinks as declared, or has reached the floor of round-off."""
        return self.ratio > 2 ** (self.order - 0.5) or self.change < 10 * floor


def richardson(values: list[Array], order: int) -> Richardson:
    """Extrapolate a quantity measured at h, h/2 and h/4."""
    coarse, half, quarter = values
    gain = 2**order - 1
    limit, before = quarter + (quarter - half) / gain, half + (half - coarse) / gain
    change = float(np.max(np.abs(coarse - half)))
    finer = float(np.max(np.abs(half - quarter)))
    return Richardson(
        predicted=RICHARDSON_SAFETY
        * max(change * (gain + 1) / gain, float(np.max(np.abs(coarse - limit)))),
        limit=limit,
        moved=np.abs(limit - before),
        change=max(change, finer),
        ratio=change / finer if finer > 0 else np.inf,
        order=order,
    )


def converging(
    finding: Finding, estimate: Richardson, floor: float, shrinks: bool, moving: bool = True
) -> Finding | Inconclusive:
    """Grant what three steps predict of a finding's error, where it shrinks as declared.

    Where it does not, and its order is ``moving`` from one halving to the next, an error that
    halving the step may still remove is not judged.
    """
    if not shrinks and moving and floor < finding.error < OPEN * estimate.change:
        return Inconclusive(finding.quantity, f"too coarse to tell: {finding.reason}")
    return replace(finding, tolerance=(estimate.predicted if shrinks else 0.0) + floor)


# What a right engine would do ----------------------------------------------------------------


@dataclass(frozen=True)
class Prediction:
    """Predicted errors of a correct engine.

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
            reason=f"{self.reason}; error of elements up to {float(np.max(share)):.2g}",
        )


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
        spread=RICHARDSON_SAFETY * whole.moved if shrinks else 0 * predicted,
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
        If it is not a published scheme.
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
    """Computed and true values, with the granted error of each.

    Attributes
    ----------
    names : tuple of str, k of them
    units : mapping of str to str
        Of states and outputs; violations of a closed loop have none.
    values : array (k, n)
    right : Truth
        Its values are (k, n).
    prediction : Prediction
    room : float
        Relative error that round-off may leave.
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
        """Return the finding on each row, where error over tolerance is largest.

        Parameters
        ----------
        describe : callable ``(row, sample) -> str``
            Description of the sample, in words.
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
            findings.append(conclusion(finding, change, self.prediction.unfollowed))
        return findings

    def unit(self, name: str) -> str:
        """Return the unit of an observable or of a violation."""
        return self.units.get(name, "m" if name.startswith("position") else "m/s")

    def limit(
        self, name: str, value: float, reference: float, reason: str
    ) -> Finding | Inconclusive:
        """Judge a number of all states without the error of the step, relative to their sizes.

        Where extrapolation is less certain than the largest tolerance, the number is not judged.
        """
        known = float(np.max((self.right.bound / self.right.size)[self.states]))
        spread, error = self.largest(self.prediction.spread), abs(value - reference)
        granted = min(spread, CAP**2) + self.room
        granted += known
        open_to = granted + max(0.0, spread - CAP**2)
        if granted < error <= open_to:
            return Inconclusive(
                name,
                f"extrapolation is uncertain by {open_to:.2g}, above the limit of {CAP**2:.2g}: "
                "use more elements or a shorter step",
            )
        finding = Finding(name, "1", value, reference, error, granted, reason)
        change = self.largest(self.prediction.change)
        return conclusion(finding, change, self.prediction.unfollowed)


@dataclass(frozen=True)
class RunComparison(Comparison):
    """An engine's runs with a step [s] compared with the truth, all parts side by side."""

    setup: Setup
    step: float
    parts: Sequence[Part]

    @property
    def runs(self) -> EngineRuns:
        """The runs, with those expected: of the scheme with its error, else the truth."""
        count, expected = len(self.setup.scene.observables), self.right.values
        if self.setup.scheme:
            expected = expected + self.values - self.prediction.limit
        values = self.values[:count]
        return EngineRuns.of(self.setup, self.step, self.parts, values, expected[:count])


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
    """Describe modes that the initial state excites and steps [s] do not resolve; empty if none."""
    lost, count = excitation(setup, step, horizon), len(setup.scene.observables)
    seen = lost.amplitudes / right.size[:count] > room + (right.bound / right.size)[:count]
    return (
        f"the initial state excites modes above {lost.omega:.3g} rad/s, which a step of "
        f"{step:.3g} s does not resolve over {horizon:.3g} s"
        if np.any(seen)
        else ""
    )


# What a motion conserves ---------------------------------------------------------------------


def drifts(
    equations: ModelEquations, case: Case, times: Any, values: Mapping[str, Array]
) -> dict[str, Array]:
    """Return (I(t) - I) / I (n_t,) of a run, by the reference's formula or by the engine.

    The engine's value counts if its states do not give it. I is that at the start. Where the scene
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
    """Return the size to which a drift is related: the value at the start, or its largest terms.

    The terms are the values for each rate (n,) alone: a momentum may be the small difference of
    large ones, or 0.
    """
    terms = sum(
        abs(invariant(q, rate * unit, c)) for rate, unit in zip(v, np.eye(len(v)), strict=True)
    )
    return first if abs(first) > CANCELLED * terms else terms
