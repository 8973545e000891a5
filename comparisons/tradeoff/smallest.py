"""The smallest model that meets a target: fewest parts, softest closure, what may be left out.

Models stand in a row from small to large: the smallest from which on all meet the target is
chosen, with the longest step of a run that meets it too. What lies beyond the largest model that
is run is extrapolated by the declared order and says so.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from ...reference import get_scene
from ...reference.errors import MbcheckError
from ...reference.scene import Array
from ...reference.solve.single import solve
from ..checks.free_vibrations import stable_step
from ..checks.kinds.elements import engine_modes, exact, of_continuum
from ..checks.suite import best_method
from ..checks.truth import Truth, roundoff_reference, truth
from ..engines.adapter import Adapter
from ..engines.equations import scene_equations
from ..engines.registry import REFERENCE, get_engine
from ..engines.setup import Setup, power_of_two, run
from ..scenes.data import scene_data
from ..scenes.tradeoff import STEP as PAIR_STEP
from ..scenes.tradeoff import (
    ClosureOption,
    ContinuumParts,
    LeftOutRow,
    LoopClosures,
    Pair,
    PairedRun,
    PairNumbers,
    PartKind,
    relative_error,
    sample_times,
)
from .sweep import cost_of
from .table import Choice, Point, StepSeries, Swept

CLOSED = 1e-6
"""Target of a loop beside those that are asked for."""

SPACING, PART_SPACING = 2.0**-5, 2.0**-4
"""Longest step, and spacing of the samples, of runs of loops and of continua [s]."""

FINE = 2.0**-9
"""Longest step [s] with which parts are told apart: the lowest modes' error of time is then 1e-6
of the range."""

MOST_LEVELS, REPEATS = 10, 3
"""Times that a step is halved to meet a target; runs of which the time is the median."""

PAIRS, EQUAL = 7, 0.03
"""Pairs of runs whose times are compared; costs that differ by a smaller share are equal."""


@dataclass(frozen=True)
class Ladder:
    """Models from small to large, and their errors, each computed once.

    Attributes
    ----------
    series : StepSeries
        Without its points.
    values : sequence of float
        Models by their value on the axis, the smallest first.
    tried : tuple of float
        Values that are tried first.
    measure : callable ``(value) -> array``
        Quantity of a model.
    truth : Truth or array
        The exact quantity; an array where nothing runs.
    setup_of : callable ``(value) -> Setup``, optional
        Setup that runs a model.
    unmet : callable ``(limit, doubt) -> str``
        Why no model meets a target.
    known : dict
        Quantities that were computed.
    """

    series: StepSeries
    values: Sequence[float]
    tried: Sequence[float]
    measure: Callable[[Any], Array]
    truth: Truth | Array
    setup_of: Callable[[Any], Setup] | None = None
    unmet: Callable[[float, float], str] = lambda limit, doubt: ""
    known: dict[float, Array] = field(default_factory=dict)

    def quantity(self, value: float) -> Array:
        """Return the quantity of a model."""
        if value not in self.known:
            self.known[value] = self.measure(value)
        return self.known[value]

    def error_of(self, quantity: Array) -> float:
        """Return the error of a quantity, relative to its size."""
        if isinstance(self.truth, Truth):
            return relative_error(quantity, self.truth)
        return float(np.max(np.abs(quantity / self.truth - 1)))

    def error(self, value: float) -> float:
        """Return the error of a model."""
        return self.error_of(self.quantity(value))

    def first_values(self, target: float) -> Sequence[float]:
        """Return the values up to where two in a row meet a target; one may do so by chance."""
        for last in range(2, len(self.tried)):
            if all(self.error(value) <= target for value in self.tried[last - 2 : last]):
                return self.tried[:last]
        return self.tried

    def limit(self, values: Sequence[float]) -> tuple[float, float]:
        """Return the error extrapolated from the last values, and by how much that has changed."""
        limits = []
        for a, b in pairwise(values):
            gain = (b / a) ** self.series.order - 1
            change = self.quantity(b) - self.quantity(a)
            limits.append(self.error_of(self.quantity(b) + (change / gain if gain else 0.0)))
        last = self.error(values[-1])
        before = limits[-2] if len(limits) > 1 else last
        limits = limits or [last]
        return limits[-1], abs(limits[-1] - before)

    def swept(self, choices: Sequence[Choice]) -> Swept:
        """Return the series of all models that were tried, with the choices."""
        points = [
            Point(None, self.error(value), value=value)
            for value in self.values
            if value in self.known
        ]
        return Swept((replace(self.series, points=tuple(points)),), tuple(choices))


def smallest(ladder: Ladder, target: float) -> Choice:
    """Return the smallest model from which on all that are tried meet a target."""
    tried, series = ladder.first_values(target), ladder.series
    limit, doubt = ladder.limit(tried)
    errors = [ladder.error(value) for value in tried]
    choice = series.choice(target)
    last = f"{errors[-1]:.2g} with {tried[-1]:g} {series.axis}"
    if limit - doubt > target:
        words = "; ".join(filter(None, [f"{limit:.2g} is left", ladder.unmet(limit, doubt)]))
        return replace(choice, error=limit, limit=words)
    if errors[-1] > target:
        if not series.order or limit > target / 2:
            return replace(choice, error=errors[-1], limit=f"not met: {last}")
        certain = max(0.0, limit - doubt)
        factor = (errors[-1] - certain) / (target - certain)
        count = int(np.ceil(tried[-1] * factor ** (1 / series.order)))
        words = f"extrapolated by order {series.order} from {last}"
        return replace(choice, value=count, extrapolated=True, met=True, limit=words)
    first = ladder.values.index(tried[0])
    if missed := [value for value, error in zip(tried, errors, strict=True) if error > target]:
        low = ladder.values.index(missed[-1])
        high = ladder.values.index(tried[tried.index(missed[-1]) + 1])
        first = bisect_left(
            ladder.values, True, low + 1, high, key=lambda value: ladder.error(value) <= target
        )
    value = ladder.values[first]
    smaller = ladder.error(ladder.values[first - 1]) if first else None
    words = "the smallest tried" if smaller is None else "measured"
    choice = replace(
        choice, value=value, error=ladder.error(value), smaller=smaller, met=True, limit=words
    )
    return with_longest_step(ladder, choice) if ladder.setup_of else choice


def with_longest_step(ladder: Ladder, choice: Choice) -> Choice:
    """Return a choice with the longest step with which a run meets its target, and the cost."""
    assert ladder.setup_of is not None
    assert isinstance(ladder.truth, Truth)
    setup, times = ladder.setup_of(choice.value), ladder.truth.times
    limit = stable_step(setup, setup.case.horizon)
    spacing = float(times[1] - times[0])
    longest = power_of_two(min(limit.step, spacing) if limit else spacing)
    for step in (longest / 2**level for level in range(MOST_LEVELS)):
        try:
            first = run(setup.with_step(step), times)
        except MbcheckError:
            continue
        if ladder.error_of(first.matrix(setup_names(ladder))) <= choice.target:
            runs = [first, *(run(setup.with_step(step), times) for _ in range(REPEATS - 1))]
            margin = limit.step / step if limit else None
            cost = cost_of(runs, setup.case.horizon)
            return replace(choice, step=step, margin=margin, cost=cost)
    shortest = longest / 2 ** (MOST_LEVELS - 1)
    words = f"no step from {longest:.2g} s down to {shortest:.2g} s meets it"
    return replace(choice, met=False, limit=f"{choice.limit}; {words}")


def setup_names(ladder: Ladder) -> tuple[str, ...]:
    """Return the observables that are compared."""
    quantity = ladder.series.quantity
    return (quantity,) if quantity else get_scene(ladder.series.scene).observables


# Parts of a continuum -------------------------------------------------------------------------


def continuum_of(scene: str) -> ContinuumParts:
    """Return the parts of a scene's continuum, if it is one."""
    none = ContinuumParts({}, (), "", "", lambda p, equations: np.zeros(0))
    return scene_data(scene, "tradeoff", "CONTINUUM", none)


def part_ladder(scene: str, engine: Adapter, kind: PartKind, case_name: str) -> Ladder:
    """Return a continuum of more and more parts: the first frequency, or the observable of a run.

    By the engine's default model and its best method. The reference runs equations with so many
    modes.
    """
    continuum, case = continuum_of(scene), get_scene(scene).case(case_name)
    case = replace(case, parameters=case.parameters.replace(**kind.choices))
    setup, p = Setup(engine, case, engine.models(scene)[0]), case.parameters
    of_run, make = case_name == continuum.moving, kind.equations
    if make is None:
        setup = replace(setup, method=best_method(setup))
    names = (continuum.observable,)
    right: Truth | Array = exact(case)[:1]
    if of_run:
        right = truth(scene_equations(case), case, sample_times(case, PART_SPACING), names)
        right = replace(right, size=np.array([np.ptp(np.append(right.values, 0.0))]))

    def setup_of(count: int) -> Setup:
        return setup.with_case(replace(case, parameters=p.replace(segments=float(count))))

    def measure(count: int) -> Array:
        if not of_run and make is None:
            return np.array([mode.omega for mode in engine_modes(setup_of(count))][:1])
        if make is None:
            finer = setup_of(count)
            limit = stable_step(finer, case.horizon)
            step = power_of_two(min(limit.step, FINE) if limit else FINE)
            return run(finer.with_step(step), right.times).matrix(names)  # type: ignore[union-attr]
        equations = make(count)
        if not of_run:
            return continuum.first_frequency(p, equations)
        states = solve(equations, p, equations.state({}), right.times).states  # type: ignore[union-attr]
        return np.asarray(equations.observe(states, p)[names[0]])[None]

    series = StepSeries(
        scene, case.name, engine.name, kind.name, "" if make else setup.integrator.name,
        0 if make else setup.element_order, {}, axis=kind.part, unit="1",
        quantity=names[0] if of_run else OMEGA,
    )  # fmt: skip
    counts = kind.run_counts if of_run else kind.counts
    return Ladder(
        series,
        range(counts[0], counts[-1] + 1),
        counts,
        measure,
        right,
        setup_of if of_run and make is None else None,
        partial(why_parts_miss, setup, of_run or make is not None),
    )


OMEGA = "omega_1"
"""The first frequency, as a quantity."""


def why_parts_miss(setup: Setup, unexplained: bool, limit: float, doubt: float) -> str:
    """Return the reason if no number of parts meets a target, as far as its continuum tells."""
    if unexplained:
        return "the model has another limit than the scene's beam"
    error = 0.0
    if setup.approximates_continuum:
        error = float(abs(of_continuum(setup)[0] / exact(setup.case)[0] - 1))
    if abs(error - limit) > max(doubt, error / 10, 1e-8):
        return f"its claimed continuum explains only {error:.2g}: the model is not what it claims"
    return f"it converges to another beam, {setup.equations.scene.title}"


def of_parts(scene: str, engine: str, kind: PartKind, case: str, targets: Sequence[float]) -> Swept:
    """Return the fewest parts of one kind in one case."""
    ladder = part_ladder(scene, get_engine(engine), kind, case)
    return ladder.swept([smallest(ladder, target) for target in targets])


# Closures of a loop ---------------------------------------------------------------------------


def loop_of(scene: str) -> LoopClosures:
    """Return how the closed loop of a scene is compared."""
    return scene_data(scene, "tradeoff", "LOOP", LoopClosures("", ()))


def closure_ladder(scene: str, option: ClosureOption) -> Ladder:
    """Return closures of a loop from soft to hard, by the solutions of their equations.

    Joints that are closed exactly have no equations of their own: runs with a short step are
    compared.

    Raises
    ------
    MbcheckError
        If no method runs the model.
    """
    case = get_scene(scene).case(loop_of(scene).case)
    setup = Setup(option.engine.make(), case, option.model)
    method = best_method(setup)
    if method is None:
        raise MbcheckError(f"no method of {setup.engine.name} can run {option.model}")
    setup, times = replace(setup, method=method), sample_times(case, SPACING)
    names = setup.scene.observables

    def setup_of(value: float) -> Setup:
        return setup.with_option(option.option, value) if option.option else setup

    def measure(value: float) -> Array:
        closed = setup_of(value)
        if option.exact:
            return run(closed.with_step(PAIR_STEP), times).matrix(names)
        return roundoff_reference(closed.equations, case, times, names).values

    values = option.values or (0.0,)
    series = StepSeries(
        scene, case.name, setup.engine.name, option.model, method.name, 0, {},
        axis=option.option or "closure by default", unit=option.unit,
    )  # fmt: skip
    right = roundoff_reference(scene_equations(case), case, times, names)
    return Ladder(series, values, (values[0], values[-1])[: len(values)], measure, right, setup_of)


def of_loop(scene: str, engine: str, targets: Sequence[float]) -> Swept:
    """Return the softest closures of an engine's models of a scene's loop."""
    parts = []
    for option in loop_of(scene).closures:
        if option.engine.engine == engine:
            ladder = closure_ladder(scene, option)
            parts.append(ladder.swept([smallest(ladder, target) for target in targets]))
    return joined(parts)


def joined(parts: Sequence[Swept]) -> Swept:
    """Return all parts as one."""
    return Swept(
        tuple(one for part in parts for one in part.series),
        tuple(one for part in parts for one in part.choices),
    )


# What may be left out -------------------------------------------------------------------------


def left_out_rows(scene: str, engine: str) -> tuple[LeftOutRow, ...]:
    """Return what may be left out of an engine's models of a scene."""
    return scene_data(scene, "tradeoff", "LEFT_OUT", dict[str, Any]()).get(engine, ())


def compare(pair: Pair) -> PairNumbers:
    """Run both of a pair, in turns, and compare errors and wall times."""
    case, names = pair.case, get_scene(pair.case.scene).observables
    span = case.horizon if pair.span is None else pair.span
    spacing = max(pair.has.step, pair.lacks.step, power_of_two(span / 64))
    times = sample_times(case, spacing, span)
    right = roundoff_reference(scene_equations(case), case, times, names)
    setups = [paired_setup(pair, one) for one in (pair.has, pair.lacks)]
    runs = [[run(setup, times) for setup in setups] for _ in range(PAIRS)]
    has, lacks = (relative_error(one.matrix(names), right) for one in runs[0])
    ratios = tuple(one.seconds / other.seconds for one, other in runs)
    return PairNumbers(pair.left_out, pair.compared, case.name, (has, lacks), ratios, "wall time")


def paired_setup(pair: Pair, one: PairedRun) -> Setup:
    """Return the setup of one of a pair of runs."""
    engine = one.engine.make()
    method = next(item for item in engine.methods if item.name == one.method)
    case = replace(pair.case, parameters=pair.case.parameters.replace(**one.changes))
    return Setup(engine, case, one.model, method, one.step)


def with_and_without(scene: str, engine: str, row: LeftOutRow, targets: Sequence[float]) -> Swept:
    """Return a model without something and with it, and for each target the one that is needed."""
    numbers = compare(row) if isinstance(row, Pair) else row()
    has, lacks = numbers.errors
    series = StepSeries(
        scene, numbers.case, engine, numbers.compared, "", 0, {}, axis=numbers.left_out, unit="1",
        points=(Point(None, lacks, value=0.0), Point(None, has, value=1.0)),
    )  # fmt: skip
    words = [] if has is None else [f"{has:.2g} with it"]
    words += [saving(numbers)] if numbers.ratios else []
    choices = []
    for target in targets:
        value = 0.0 if lacks <= target else 1.0 if (has or 0.0) <= target else None
        error = has if value else lacks
        choice = series.choice(target, value=value, error=error, limit="; ".join(words))
        choices.append(replace(choice, met=value is not None, smaller=lacks if value else None))
    return Swept((series,), tuple(choices))


def saving(numbers: PairNumbers) -> str:
    """Return in words what leaving something out saves or costs, by quartiles of cost ratios."""
    low, ratio, high = np.quantile(numbers.ratios, (0.25, 0.5, 0.75)).tolist()
    if low <= 1 <= high or abs(ratio - 1) < EQUAL:
        return f"no difference in {numbers.cost_of} above the scatter"
    change = f"saves a factor of {ratio:.2g}" if ratio > 1 else f"costs a factor of {1 / ratio:.2g}"
    return f"leaving it out {change} in {numbers.cost_of}"


def of_left_out(scene: str, engine: str, targets: Sequence[float]) -> Swept:
    """Return what may be left out of an engine's models of a scene."""
    return joined(
        [with_and_without(scene, engine, row, targets) for row in left_out_rows(scene, engine)]
    )


Piece = tuple[str, Callable[[], Swept]]


def tasks(scenes: Sequence[str], engines: Sequence[str], targets: Sequence[float]) -> list[Piece]:
    """Return the pieces with their names, each ready for a process of its own."""
    return [
        piece
        for engine in (*engines, REFERENCE)
        for scene in scenes
        for piece in pieces(scene, engine, targets)
    ]


def pieces(scene: str, engine: str, targets: Sequence[float]) -> Iterator[Piece]:
    """Yield the pieces of one scene and engine."""
    continuum = continuum_of(scene)
    for kind in continuum.kinds.get(engine, ()):
        for case in (*continuum.steady, continuum.moving):
            name = f"{scene} {engine} {kind.name}, {case}"
            yield name, partial(of_parts, scene, engine, kind, case, targets)
    if any(option.engine.engine == engine for option in loop_of(scene).closures):
        all_targets = tuple(dict.fromkeys((*targets, CLOSED)))
        yield f"{scene} {engine} closure", partial(of_loop, scene, engine, all_targets)
    if left_out_rows(scene, engine):
        yield f"{scene} {engine} left out", partial(of_left_out, scene, engine, targets)
