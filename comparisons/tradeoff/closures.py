"""The softest closure of a loop that meets a target, and what harder ones cost."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

from ...reference.errors import MbcheckError
from ...reference.scene import Array, Case
from ..checks.free_vibrations import stable_step
from ..checks.suite import best_method
from ..checks.truth import Truth, roundoff_reference
from ..engines.equations import ModelEquations, scene_equations
from ..engines.run import Trajectory
from ..engines.setup import Setup, power_of_two, run
from ..scenes.tradeoff import ClosureOption, relative_error, sample_times
from .search import REPEATS, Requirement, longest_step_that_meets, no_step
from .sweep import cost

CLOSED = 1e-6
"""Target of a loop beside those that are asked for."""

SPACING = 2.0**-5
"""Of the samples [s]; no step is longer."""


@dataclass(frozen=True, kw_only=True)
class LoopClosure(Requirement):
    """The softest closure of a loop that meets a target.

    Attributes
    ----------
    engine, model, method, case : str
    knob, unit : str
        Option that is varied; empty for a model that has none.
    value : float or None
        The softest; None where none meets it.
    error : float or None
        What it leaves, whatever the step.
    softer, softer_error : float or None
        The next softer one, which misses the target; None where the softest tried meets it.
    claimed : bool
        Errors are those of the equations that the model has; else the difference of runs to
        one with the hardest value.
    measured : float or None
        Error of the run with ``step``.
    """

    engine: str
    model: str
    method: str
    case: str
    knob: str
    unit: str
    value: float | None = None
    error: float | None = None
    softer: float | None = None
    softer_error: float | None = None
    claimed: bool
    measured: float | None = None


@dataclass(frozen=True)
class LoopSetup:
    """A setup of a closed loop, and the option that makes its closure softer.

    Attributes
    ----------
    setup : Setup
    option : ClosureOption
    """

    setup: Setup
    option: ClosureOption

    @classmethod
    def of(cls, case: Case, option: ClosureOption) -> LoopSetup:
        """Return it, with the best method.

        Raises
        ------
        MbcheckError
            If the model has none.
        """
        setup = Setup(option.engine.make(), case, option.model)
        method = best_method(setup)
        if method is None:
            raise MbcheckError(f"no method of {setup.engine.name} can run {option.model}")
        return cls(replace(setup, method=method), option)

    @property
    def times(self) -> Array:
        """Times [s] at which runs are compared."""
        return sample_times(self.setup.case, SPACING)

    def solution(self, equations: ModelEquations) -> Truth:
        """Return the solution of equations of motion."""
        setup = self.setup
        return roundoff_reference(equations, setup.case, self.times, setup.scene.observables)

    @property
    def truth(self) -> Truth:
        """The reference."""
        return self.solution(scene_equations(self.setup.case))

    def with_value(self, value: float) -> LoopSetup:
        """Return it with a value of the option."""
        return replace(self, setup=self.setup.with_option(self.option.option, value))

    def model_error(self) -> float:
        """Return how far the model's equations are off the exact ones, over the states' sizes."""
        return relative_error(self.solution(self.setup.equations).values, self.truth)

    def simulate(self, step: float) -> Trajectory:
        """Run it."""
        return run(self.setup.with_step(step), self.times)

    def error(self, trajectory: Trajectory) -> float:
        """Return the error of a run, over the states' sizes."""
        return relative_error(trajectory.matrix(self.setup.scene.observables), self.truth)

    def row(self, target: float) -> LoopClosure:
        """Return a row that is to be filled."""
        setup, option = self.setup, self.option
        return LoopClosure(
            engine=setup.engine.name,
            model=setup.model,
            method=setup.integrator.name,
            case=setup.case.name,
            knob=option.option,
            unit=option.unit,
            target=target,
            claimed=not option.exact,
        )


def closures(case: Case, option: ClosureOption, targets: Sequence[float]) -> list[LoopClosure]:
    """Return how softly an engine may close the loop, and what a harder closure costs."""
    loop = LoopSetup.of(case, option)
    search = loosest if option.exact else softest if option.option else as_it_is
    return [search(loop, target) for target in targets]


def softest(loop: LoopSetup, target: float) -> LoopClosure:
    """Return the softest value of the option that meets a target."""
    values, row = loop.option.values, loop.row(target)

    @cache
    def error(value: float) -> float:
        return loop.with_value(value).model_error()

    first = bisect_left(values, True, key=lambda value: error(value) <= target)
    if first == len(values):
        return replace(row, reason=f"the hardest tried leaves {error(values[-1]):.2g}")
    value, reason = values[first], "the softest tried"
    if first > 0:
        softer, reason = values[first - 1], "found between it and the next softer one"
        row = replace(row, softer=softer, softer_error=error(softer))
    row = replace(row, value=value, error=error(value), reason=reason)
    return with_cost(loop.with_value(value), row)


def as_it_is(loop: LoopSetup, target: float) -> LoopClosure:
    """Return whether a model's own closure meets a target."""
    error = loop.model_error()
    row = replace(loop.row(target), error=error, reason="as the engine closes loops by default")
    if error > target:
        return replace(row, reason=f"{row.reason}, {error:.2g} is left")
    return with_cost(loop, row)


def with_cost(loop: LoopSetup, row: LoopClosure) -> LoopClosure:
    """Add the longest step with which a run meets the target, and what it costs."""
    limit = stable_step(loop.setup, loop.setup.case.horizon)
    longest = power_of_two(min(limit.step, SPACING) if limit else SPACING)
    row = replace(row, stable_step=limit and limit.step)
    step, runs = longest_step_that_meets(loop.simulate, loop.error, longest, row.target)
    if step is None:
        return replace(row, reason=f"{row.reason}; {no_step(longest)}")
    return replace(
        row, step=step, measured=loop.error(runs[0]), cost=cost(runs, loop.setup.case.horizon)
    )


def loosest(loop: LoopSetup, target: float) -> LoopClosure:
    """Return the loosest tolerance of a solver of joints that are closed exactly."""
    values, row, truth = loop.option.values, loop.row(target), loop.truth
    names = loop.setup.scene.observables
    tight = loop.with_value(values[-1])
    step, runs = longest_step_that_meets(tight.simulate, loop.error, SPACING, target)
    if step is None:
        return replace(row, reason=no_step(SPACING))
    tightest = replace(truth, values=runs[0].matrix(names))
    exact = "joints are closed exactly; only the solver may stop early"
    for tolerance in values:
        runs = [loop.with_value(tolerance).simulate(step) for _ in range(REPEATS)]
        error = relative_error(runs[0].matrix(names), tightest)
        if loop.error(runs[0]) > target or error > target:
            row = replace(row, softer=tolerance, softer_error=error)
            continue
        return replace(
            row,
            value=tolerance,
            error=error,
            step=step,
            measured=loop.error(runs[0]),
            cost=cost(runs, loop.setup.case.horizon),
            reason=exact if row.softer else f"{exact}: the loosest that was tried meets it",
        )
    return replace(row, softer=None, softer_error=None, reason="no tolerance meets it")
