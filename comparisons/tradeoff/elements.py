"""The fewest elements, rods or modes of a continuum that meet a target.

What lies beyond the largest model that is run is extrapolated by the declared order and says so;
what no number of elements can meet says why.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from time import perf_counter

import numpy as np

from ...reference import get_scene
from ...reference.amplification import largest_stable_step, vibrations
from ...reference.scene import Array, Scene
from ...reference.solve.single import solve
from ...reference.solve.solution import Solution
from ..checks.free_vibrations import stable_step
from ..checks.kinds.elements import engine_modes, of_continuum
from ..checks.kinds.elements import exact as exact_frequencies
from ..checks.suite import best_method
from ..checks.truth import truth
from ..engines.adapter import Adapter
from ..engines.equations import scene_equations
from ..engines.run import Trajectory
from ..engines.setup import Setup, power_of_two, run
from ..scenes.data import scene_data
from ..scenes.tradeoff import ContinuumParts, PartKind, sample_times
from .search import (
    Convergence,
    Requirement,
    counts_to_target,
    fewest,
    longest_step_that_meets,
    no_step,
)
from .series import TARGETS, Cost
from .sweep import cost

OMEGA = "omega_1"
"""The first frequency, as a quantity."""

SPACING = 2.0**-4
"""Of the samples of a run [s]; no step is longer."""

FINE = 2.0**-9
"""Longest step [s] with which elements are told apart: the lowest modes' error of time is then
1e-6 of the range, which `Fewest.integration` shows."""


@dataclass(frozen=True)
class PartSubject:
    """Which parts are counted, and for what.

    Attributes
    ----------
    engine, kind, part, case, quantity : str
    """

    engine: str
    kind: str
    part: str
    case: str
    quantity: str


@dataclass(frozen=True)
class Curve(PartSubject):
    """How an error falls with the number of parts.

    Attributes
    ----------
    order : int
        Declared; 0 where none is.
    counts : tuple of int
    errors : tuple of float
        Of a frequency relative to it, of a run the largest over its range.
    limit, doubt : float
        Error extrapolated to parts of no length, and how far the extrapolation moved last.
    """

    order: int
    counts: tuple[int, ...]
    errors: tuple[float, ...]
    limit: float
    doubt: float


@dataclass(frozen=True, kw_only=True)
class Fewest(Requirement, PartSubject):
    """The fewest parts that meet a target.

    Attributes
    ----------
    count : int or None
        None where no number meets the target, or none that was tried and no order is known.
    error, fewer : float or None
        Measured with so many, and with one less, which misses the target; ``fewer`` is None
        where fewer are not to be had.
    extrapolated : bool
        The count follows from the declared order, and was not run.
    limit : float
        What no number of parts removes.
    integration : float or None
        What halving the step changes, over the same size.
    """

    count: int | None
    error: float | None = None
    fewer: float | None = None
    extrapolated: bool
    limit: float
    integration: float | None = None


@dataclass(frozen=True)
class Counting:
    """One kind of parts of a scene, by an engine, in one case.

    Attributes
    ----------
    continuum : ContinuumParts
    kind : PartKind
    setup : Setup
        By the engine's default model and its best method; the reference has none of its own.
    """

    continuum: ContinuumParts
    kind: PartKind
    setup: Setup

    @classmethod
    def of(cls, scene: str, engine: Adapter, kind: PartKind, case_name: str) -> Counting:
        """Return it with the parameters that choose the kind."""
        case = get_scene(scene).case(case_name)
        case = replace(case, parameters=case.parameters.replace(**kind.choices))
        setup = Setup(engine, case, engine.models(scene)[0])
        method = None if kind.equations else best_method(setup)
        return cls(continuum_of(scene), kind, replace(setup, method=method))

    @property
    def of_run(self) -> bool:
        """Whether a run is looked at, and not the first frequency."""
        return self.setup.case.name == self.continuum.moving

    @property
    def times(self) -> Array:
        """Times [s] at which a run is compared."""
        return sample_times(self.setup.case, SPACING)

    def with_parts(self, count: int) -> Setup:
        """Return the setup with so many parts."""
        case = self.setup.case
        return self.setup.with_case(
            replace(case, parameters=case.parameters.replace(segments=float(count)))
        )

    def equations(self, count: int) -> Scene:
        """Return the scene's equations with so many modes."""
        assert self.kind.equations is not None
        return self.kind.equations(count)

    def observed(self, trajectory: Trajectory) -> Array:
        """Return what is looked at of a run."""
        return np.asarray(trajectory.values[self.continuum.observable])

    def convergence(self) -> Convergence:
        """Return the observable of a run, or the first frequency [rad/s], by the parts."""
        case, order = self.setup.case, 0 if self.kind.equations else self.setup.element_order
        if not self.of_run:
            right = exact_frequencies(case)[:1]
            measure = self.modal_frequency if self.kind.equations else self.frequency
            return Convergence(measure, right, float(right[0]), order)
        names = (self.continuum.observable,)
        right = truth(scene_equations(case), case, self.times, names).values[0]
        measure = self.modal_run if self.kind.equations else self.fine_run
        return Convergence(measure, right, float(np.ptp(np.append(right, 0.0))), order)

    def frequency(self, count: int) -> Array:
        """Return the first frequency (1,) [rad/s] of the engine's own matrices."""
        return np.array([mode.omega for mode in engine_modes(self.with_parts(count))][:1])

    def modal_frequency(self, count: int) -> Array:
        """Return the first frequency (1,) [rad/s] with so many modes."""
        return self.continuum.first_frequency(self.setup.case.parameters, self.equations(count))

    def fine_run(self, count: int) -> Array:
        """Return the observable with steps that do not matter."""
        setup = self.with_parts(count)
        step = min(FINE, longest_step(setup))
        return self.observed(run(setup.with_step(step), self.times))

    def modal_solution(self, count: int) -> Solution:
        """Return the solution with so many modes."""
        case, scene = self.setup.case, self.equations(count)
        return solve(scene, case.parameters, scene.state({}), self.times)

    def modal_run(self, count: int) -> Array:
        """Return the observable with so many modes."""
        states, p = self.modal_solution(count).states, self.setup.case.parameters
        return np.asarray(self.equations(count).observe(states, p)[self.continuum.observable])


def continuum_of(scene: str) -> ContinuumParts:
    """Return how the parts of a scene are counted; what is no continuum has none."""
    none = ContinuumParts({}, (), "", "", lambda p, equations: np.zeros(0))
    return scene_data(scene, "tradeoff", "CONTINUUM", none)


def parts_of(
    counting: Counting, targets: Sequence[float] = TARGETS
) -> tuple[Curve, tuple[Fewest, ...]]:
    """Return how many parts are needed: for a run, or for the first frequency."""
    kind, setup, convergence = counting.kind, counting.setup, counting.convergence()
    counts = kind.run_counts if counting.of_run else kind.counts
    tried = counts_to_target(convergence, counts, min(targets))
    limit, doubt = convergence.limit(tried)
    quantity = counting.continuum.observable if counting.of_run else OMEGA
    parts = PartSubject(setup.engine.name, kind.name, kind.part, setup.case.name, quantity)
    errors = tuple(convergence.error(n) for n in tried)
    curve = Curve(**asdict(parts), order=convergence.order, counts=tuple(tried), errors=errors,
                  limit=limit, doubt=doubt)  # fmt: skip
    rows = []
    for target in targets:
        count, extrapolated = fewest(convergence, tried, target)
        row = Fewest(
            **asdict(parts),
            target=target,
            count=count,
            extrapolated=extrapolated,
            limit=limit,
            reason=reason(counting, curve, target, count, extrapolated),
        )
        if count is not None and not extrapolated:
            less = convergence.error(count - 1) if count > counts[0] else None
            row = replace(row, error=convergence.error(count), fewer=less)
            row = with_cost(counting, row, count, convergence)
        rows.append(row)
    return curve, tuple(rows)


def reason(
    counting: Counting, curve: Curve, target: float, count: int | None, extrapolated: bool
) -> str:
    """Say where a count comes from, or why there is none."""
    last = f"{curve.errors[-1]:.2g} with {curve.counts[-1]} {curve.part}"
    if extrapolated:
        return f"extrapolated by order {curve.order} from {last}"
    if count is not None:
        return "measured"
    if curve.limit - curve.doubt <= target:
        return f"not met: {last}"
    known = model_error(counting)
    if known is None:
        why = "the model has another limit than the scene's beam"
    elif abs(known - curve.limit) > max(curve.doubt, known / 10, 1e-8):
        why = f"its claimed continuum explains only {known:.2g}: the model is not what it claims"
    else:
        why = f"it converges to another beam, {counting.setup.equations.scene.title}"
    return f"no number of {curve.part} meets it: {curve.limit:.2g} is left; {why}"


def model_error(counting: Counting) -> float | None:
    """Return by how much the first frequency of the model's continuum is off the scene's."""
    if counting.kind.equations or counting.of_run:
        return None
    if not counting.setup.approximates_continuum:
        return 0.0
    model, right = of_continuum(counting.setup), exact_frequencies(counting.setup.case)
    return float(abs(model[0] / right[0] - 1))


def longest_step(setup: Setup) -> float:
    """Return the longest power of two [s] that is stable by theory, up to `SPACING`."""
    limit = stable_step(setup, setup.case.horizon)
    return power_of_two(min(limit.step, SPACING) if limit else SPACING)


def with_cost(counting: Counting, row: Fewest, count: int, convergence: Convergence) -> Fewest:
    """Add the longest step that a count bears; of a run also what it costs and time adds."""
    if counting.kind.equations:
        return replace(row, cost=modal_cost(counting, count)) if counting.of_run else row
    setup = counting.with_parts(count)
    horizon = setup.case.horizon
    if not counting.of_run:
        fastest = max(mode.omega for mode in engine_modes(setup))
        scheme = setup.integrator.linear or setup.integrator.scheme
        one = np.eye(1)
        mode = vibrations(one, 0 * one, one * fastest**2)
        most = largest_stable_step(scheme, mode, horizon) if scheme else np.inf
        return replace(row, stable_step=most if np.isfinite(most) else None)
    limit, longest = stable_step(setup, horizon), longest_step(setup)

    def simulate(step: float) -> Trajectory:
        return run(setup.with_step(step), counting.times)

    halved = counting.observed(simulate(min(FINE, longest) / 2))
    change = float(np.max(np.abs(convergence.values(count) - halved)))
    row = replace(row, stable_step=limit and limit.step, integration=change / convergence.size)
    step, runs = longest_step_that_meets(
        simulate, lambda one: convergence.error_of(counting.observed(one)), longest, row.target
    )
    if step is None:
        return replace(row, reason=f"{row.reason}; {no_step(longest)}")
    return replace(row, step=step, cost=cost(runs, horizon))


def modal_cost(counting: Counting, count: int) -> Cost:
    """Return what the reference's solver takes with so many modes, its check included."""
    begin = perf_counter()
    solution, span = counting.modal_solution(count), counting.setup.case.horizon
    seconds = (perf_counter() - begin) / span
    per_second = solution.steps / span, solution.rhs_evaluations / span
    return Cost(seconds, seconds, seconds, *per_second, None)
