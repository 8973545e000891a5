"""A trajectory compared with its reference as far as it can be judged, and the granted error."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ...reference import get_scene
from ...reference.cost import expected_end
from ...reference.equations import ModelEquations, scene_equations
from ...reference.errors import UsageError
from ...reference.scene import Array, Case
from ...reference.solve.solution import floor_relative_to_largest
from ..checks.comparison import CAP, Comparison, Part, exact_prediction, sample_numbers, scheme_rows
from ..checks.mistakes.observables import (
    Observed,
    conventions,
    exchanged,
    late,
    other_measures,
)
from ..checks.truth import MOST_STEPS, Truth, moves, permitted_horizon, rounding, truth_to_the_end
from ..engines.setup import shortest_period
from .recording import Recording

SCHEMES_OF = {
    1: ("ExplicitEuler", "semi_implicit_euler"),
    2: ("ExplicitMidpoint",),
    3: ("RK33",),
    4: ("RK44",),
    5: ("DOPRI5",),
    6: ("RK67",),
}
"""Published schemes of each order; where there are two, the larger error counts."""

METHOD_SPREAD = {1: 2.0, 2: 4.0, 3: 4.0, 4: 4.0, 5: 4.0, 6: 4.0}
"""Methods of one order and step are granted so many times the error of the published scheme: those
of MuJoCo and Exudyn need half of it. The constants of explicit multistep methods of
order 3 and more are larger."""

ROUNDED = 1e-9
"""Relative distance within which a horizon is a whole number of steps."""

SLACK = 0.5
"""Distance of the error's slope over the step from the order up to which the error is scaled."""

ERROR_MARKS = 256
"""Approximate number of times at which the error of a run is evaluated."""

GRID = 256
"""Number of times at which the reference is evaluated besides those of the trajectory."""

LONGEST = 10.0
"""A trajectory may be so many times as long as its case; a longer one is a slip of units."""

ON_START = 1e-9
"""Distance, relative to the span of a trajectory, within which its first row is the start."""


MOST_ROUNDED = 1e-3
"""No rounding of printed numbers above this share of a quantity's size is granted."""

SHIFTED = 2000
"""Number of samples by which a shift of times is estimated."""

NOTICEABLE = 1e-4
"""Share of a quantity's size below which no mistake is sought: a file with few digits has such
errors."""


@dataclass(frozen=True)
class FileComparison(Comparison):
    """A trajectory compared with its reference, as far as it can be judged.

    Attributes
    ----------
    case : Case
    growth : float
        Growth factor of an initial error.
    printed : array (k,)
        Granted errors by the digits of the file.
    notes : tuple of str
    """

    case: Case
    growth: float
    printed: Array
    notes: tuple[str, ...]

    @property
    def span(self) -> float:
        """Time from the start of the case to the last sample [s]."""
        return float(self.right.times[-1] - self.case.start_time)


def compare(
    file: Recording,
    case: Case,
    names: tuple[str, ...],
    basis: Mapping[str, float],
    most_steps: int = MOST_STEPS,
) -> FileComparison:
    """Solve the case at the times of a trajectory, as far as errors grow slowly.

    A scheme that predicts the error takes `most_steps` steps at most.

    Raises
    ------
    UsageError
        If nothing moves, or nothing can be judged.
    """
    start, equations = case.start_time, scene_equations(case)
    times = np.maximum(file.times, start)
    span = float(times[-1] - start)
    horizon, growth = permitted_horizon(replace(case, horizon=span))
    notes = list[str]()

    def judged_until(after: float, most: int, why: str) -> int:
        """Return the number of samples until then, and note why no more are judged."""
        count = int(np.searchsorted(times, start + after * (1 + ON_START), side="right"))
        if count < most:
            notes.append(
                f"{why} after t = {start + after:.4g} s: {len(times) - count} of {len(times)} "
                "samples lie after that and are not judged"
            )
        return min(count, most)

    seen = judged_until(horizon, len(times), "initial errors grow too fast")
    scheme = Scheme.of(basis, horizon, most_steps) if "order" in basis else None
    marks = start + scheme.marks if scheme else np.empty(0)
    grid = start + horizon * np.arange(GRID + 1) / GRID
    every = np.unique([*times[:seen], *grid, *marks])
    with expected_end(float(every[-1])):
        right = truth_to_the_end(equations, equations.start(case), start, every, names)
    if not moves(right.states[: len(right.states) // 2]):
        raise UsageError(
            f"nothing moves in {case.scene}/{case.name}: it cannot judge a trajectory; choose "
            "another case, or give --state"
        )
    granted, room = basis.get("relative", 1.0) * right.size, 0.0
    printed = np.zeros(len(names))
    if scheme:
        granted, reach = scheme.errors(Problem(equations, case, right, names))
        of = f"a method of order {scheme.order} with h = {scheme.step:.3g} s"
        seen = judged_until(reach, seen, f"{of} may be off by more than {CAP:.0%}")
    if not seen or times[seen - 1] <= start:
        raise UsageError(f"no sample lies where it can be judged; {'; '.join(notes) or 'none'}")
    if scheme:
        on_grid = right.values[:, np.searchsorted(right.times, grid)]
        slope = np.max(np.abs(np.gradient(on_grid, grid, axis=1)), axis=1)
        digits = np.array([file.rounding(file.columns[name]) for name in names])
        digits += slope * file.rounding(file.times)
        printed, room = np.minimum(digits, MOST_ROUNDED * right.size), rounding(seen, growth)
    right = right.at(np.searchsorted(right.times, times[:seen]))
    values = np.array([file.columns[name][:seen] for name in names])
    units, prediction = get_scene(case.scene).units, exact_prediction(granted + printed, values)
    compared = names, units, values, right, prediction, room, seen
    return FileComparison(*compared, case, growth, printed, tuple(notes))


def refuse_outside(times: Array, case: Case) -> None:
    """Refuse times before a case begins, or long after it ends.

    Raises
    ------
    UsageError
    """
    start, span = case.start_time, float(times[-1] - case.start_time)
    if times[0] < start - ON_START * abs(span):
        raise UsageError(
            f"the first time is {times[0]:.6g} s, but {case.scene}/{case.name} begins at "
            f"t = {start:.6g} s"
        )
    if span <= 0:
        raise UsageError(f"no sample lies after the start of the case, t = {start:.6g} s")
    if span > LONGEST * case.horizon:
        raise UsageError(
            f"times go on to {times[-1]:.6g} s, but {case.scene}/{case.name} lasts "
            f"{case.horizon:.6g} s: are they in seconds? If they are, cut the file at "
            f"{start + LONGEST * case.horizon:.6g} s"
        )


# The error of a method of some order


class Problem(NamedTuple):
    """A case, the equations of its reference, their solution, and the observables compared."""

    equations: ModelEquations
    case: Case
    truth: Truth
    names: tuple[str, ...]


@dataclass(frozen=True)
class Scheme:
    """Estimate of the error of a method of some order: a published scheme with its step.

    Where a body turns fast, no less is granted than a method makes in Cartesian coordinates.

    Attributes
    ----------
    order : int
    step, coarse : float
        Given step, and simulated step [s]: larger by the power of two that keeps the number of
        steps below `most_steps`; the error is scaled by the order.
    numbers : array of int
        Numbers of the steps at which the error is evaluated.
    most_steps : int
    """

    order: int
    step: float
    coarse: float
    numbers: Any
    most_steps: int

    @classmethod
    def of(cls, basis: Mapping[str, float], horizon: float, most_steps: int) -> Scheme:
        """Return the scheme for an order and a step over a horizon [s]."""
        step = basis["step"]
        count = math.ceil(horizon / step * (1 - ROUNDED))
        coarse = step * 2.0 ** max(0, math.ceil(math.log2(count / most_steps)))
        last = math.ceil(horizon / coarse * (1 - ROUNDED))
        numbers = np.unique([*sample_numbers(horizon, coarse, ERROR_MARKS), last]).astype(int)
        return cls(int(basis["order"]), step, coarse, numbers[numbers <= last], most_steps)

    @property
    def marks(self) -> Array:
        """Times after the start at which the error is evaluated [s]."""
        return np.asarray(self.coarse * self.numbers)

    def errors(self, problem: Problem) -> tuple[Array, float]:
        """Return the errors (k,) that are granted, and until when after the start [s].

        Raises
        ------
        UsageError
            If no explicit scheme can predict them.
        """
        if problem.equations.scene.stiff:
            raise UsageError(
                f"the reference of {problem.case.scene} has modes far faster than its observables: "
                "no explicit scheme predicts the error of a method there; give a tolerance"
            )
        size = problem.truth.size[:, None]
        relative = np.zeros((len(problem.names), len(self.numbers)))
        for scheme in SCHEMES_OF[self.order]:
            here = self.relative(problem, scheme, 1)
            if self.coarse > self.step:
                self.refuse_before_convergence(problem, scheme, float(np.max(here[:, -1])))
            relative = np.maximum(relative, here)
        # a state whose error is small by chance with one scheme need not be so with another
        relative = floor_relative_to_largest(relative, np.ones_like(size))
        relative *= METHOD_SPREAD[self.order] * (self.step / self.coarse) ** self.order
        # a point on a circle: what a Runge-Kutta method leaves out of exp(i omega h) in each step;
        # one that integrates Cartesian coordinates of a body that turns makes it
        a_step = (fastest(problem) * self.step) ** (self.order + 1) / math.factorial(self.order + 1)
        relative = np.maximum(relative, a_step * self.marks / self.step)
        reach = int(np.searchsorted(np.max(relative, axis=0), CAP, side="right"))
        if not reach:
            raise UsageError(
                f"a method of order {self.order} with h = {self.step:.3g} s may be off by more "
                f"than {CAP:.0%} after {self.marks[0]:.3g} s: choose a shorter step"
            )
        return (relative * size)[:, reach - 1], float(self.marks[reach - 1])

    def relative(self, problem: Problem, scheme: str, factor: int) -> Array:
        """Return the largest errors (k, n_m) up to each mark, with so many times the step."""
        equations, case, truth, names = problem
        numbers = self.numbers[self.numbers % factor == 0]
        parts, step = [Part(case, numbers // factor)], factor * self.coarse
        values = scheme_rows(equations, scheme, parts, step, names)
        at = np.searchsorted(truth.times, case.start_time + self.coarse * numbers)
        away = np.abs(values - truth.values[:, at]) / truth.size[:, None]
        return np.maximum.accumulate(np.where(np.isfinite(away), away, np.inf), axis=1)

    def refuse_before_convergence(self, problem: Problem, scheme: str, error: float) -> None:
        """Refuse to scale errors that do not shrink with the step as the order says.

        Raises
        ------
        UsageError
        """
        twice = float(np.max(self.relative(problem, scheme, 2)[:, -1]))
        bound = float(np.max(problem.truth.bound / problem.truth.size))
        floor = rounding(int(self.numbers[-1]), 1.0) + bound
        slope = math.log2(twice / error) if 0 < error < math.inf else 0.0
        if not (error < 10 * floor or abs(slope - self.order) < SLACK):
            raise UsageError(
                f"h = {self.step:.3g} s needs more than {self.most_steps} steps here, and the "
                f"error of {scheme} cannot be scaled from h = {self.coarse:.3g} s; give a tolerance"
            )


def fastest(problem: Problem) -> float:
    """Return the fastest circular frequency of a case [rad/s]: of modes, drives and turns."""
    names = problem.equations.scene.state_names
    turning = [names.index(f"{name}_dot") for name in problem.equations.scene.rotations_per_period]
    rates = np.abs(problem.truth.states[turning])
    return max(2 * math.pi / shortest_period(problem.case), float(np.max(rates, initial=0.0)))


# What looks like a mistake


def likely_mistakes(compared: FileComparison) -> list[str]:
    """Return the likely mistakes in words: times, names, units, signs, the start."""
    scene, right = get_scene(compared.case.scene), compared.right
    every = slice(None, None, max(1, compared.seen // SHIFTED))
    seen = Observed(scene, compared.names, compared.values, right.values, right.size[:, None])
    some = replace(seen, values=seen.values[:, every], right=seen.right[:, every])
    others = list[str]()
    rates = scene.right_hand_side(compared.case.parameters)
    if shifted := late(some, rates(right.times[every], right.states[:, every]), NOTICEABLE):
        return [shifted]
    if np.all(np.isfinite(some.values)) and some.error > NOTICEABLE:
        others = [*conventions(some, some.error), *exchanged(some, some.error)][:1]
    if others:
        return others
    measures = other_measures(seen, NOTICEABLE)
    fitting = [said for said in measures.values() if said]
    start = started_elsewhere(compared, [name for name in measures if not measures[name]])
    return [*fitting, *([start] if start else [])]


def started_elsewhere(compared: FileComparison, among: list[str]) -> str:
    """Return the difference of the first row from the initial state, if it is at the start."""
    if compared.right.times[0] > compared.case.start_time + ON_START * compared.span:
        return ""
    firsts = zip(
        compared.names,
        compared.values[:, 0],
        compared.right.values[:, 0],
        compared.right.size,
        strict=True,
    )
    apart = [
        f"{name} = {value:.6g}, the case with {true:.6g}"
        for name, value, true, size in firsts
        if name in among
        and name in get_scene(compared.case.scene).state_names
        and abs(value - true) > NOTICEABLE * size
    ]
    if not apart:
        return ""
    return (
        f"the trajectory starts with {', with '.join(apart)}: another motion, which --state "
        "judges by its own reference"
    )
