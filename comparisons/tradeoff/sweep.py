"""Runs of a scene over halved steps: errors, costs, and the limits of the errors.

The error of a run against the scene has three parts. The change by halving the step is the
*step's*; the difference between the model's equations and the scene's is the *model's*; the rest is
round-off, a solver that stops early, or elements. The largest part names the limit of the point.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise, takewhile

import numpy as np

from ...reference import SCENES, get_scene
from ...reference.equations import ModelEquations, scene_equations
from ...reference.errors import EngineError
from ...reference.scene import Array, Case
from ..checks.free_vibrations import stable_step
from ..checks.kinds.order import relative_error
from ..checks.suite import best_method
from ..checks.truth import Truth, permitted_horizon, rounding, roundoff_reference
from ..engines.protocol import Option
from ..engines.registry import get_engine
from ..engines.setup import Setup, power_of_two, run, shortest_period
from ..queries.query import choose_method
from .table import (
    MODEL,
    ROUND_OFF,
    STEP,
    UNEXPLAINED,
    Choice,
    Cost,
    Point,
    StepSeries,
    cheapest_run,
    choose,
    trials_of,
)
from .tuning import SWEEP

SEGMENT_AXIS = "segments"
"""Name of the number of parts of a continuum among settings."""


def sweeps(scenes: Sequence[str], engines: Sequence[str]) -> list[StepSeries]:
    """Return the series of these scenes and engines, to be measured."""
    return [one for scene in scenes or SCENES for name in engines for one in of_scene(scene, name)]


def of_scene(scene: str, name: str) -> Iterator[StepSeries]:
    """Yield the series of a scene and an engine: all methods, and options that limit the best."""
    engine, case = get_engine(name), case_of(scene)
    for model in engine.distinct_models(scene):
        series = partial(StepSeries, scene, case.name, name, model)
        for method in engine.methods:
            if engine.bind(case, model).unsupported_reason(case, method) is None:
                yield series(method.name, method.order, {})
        setup = Setup(engine, case, model)
        top = best_method(setup)
        if top is None:
            continue
        for option in second_axes(replace(setup, method=top)):
            for value in option.values:
                if value != option.default:
                    yield series(top.name, top.order, {option.name: value})


def second_axes(setup: Setup) -> tuple[Option, ...]:
    """Return the options that limit the accuracy of a method, with the parts of a continuum."""
    options = setup.bound.options(setup.integrator)
    if not setup.bound.description.element_order:
        return options
    own = float(setup.case.parameters.segments)
    counts = tuple(sorted({*SWEEP.segments, own}))
    return (*options, Option(SEGMENT_AXIS, "1", own, counts, "spatial discretisation"))


def case_of(scene: str) -> Case:
    """Return the case by which methods of a scene are compared, if possible one of *order*."""
    cases = [case for case in get_scene(scene).cases if "trajectory" in case.kinds]
    return next((case for case in cases if "order" in case.kinds), cases[0])


def setup_of(series: StepSeries) -> Setup:
    """Return engine, case, model and method of a series with its settings applied."""
    engine, case = get_engine(series.engine), case_of(series.scene)
    method = choose_method(engine, case, series.model, series.method)
    for name, value in series.settings.items():
        if name == SEGMENT_AXIS:
            case = replace(case, parameters=case.parameters.replace(segments=value))
        else:
            engine = engine.with_option(name, value)
    return Setup(engine, case, series.model, method)


@dataclass(frozen=True)
class Horizon:
    """Times at which runs of a series are compared: each step, or a longer spacing.

    Attributes
    ----------
    start : float
        Time at which runs begin [s].
    coarsest : float
        First step of the sweep [s], a power of two.
    spacing : float
        Shortest time between samples [s], a power of two.
    length : float
        Length of the run [s].
    growth : float
        Growth factor of an initial error.
    """

    start: float
    coarsest: float
    spacing: float
    length: float
    growth: float

    def times(self, step: float) -> Array:
        """Return the times of the samples of a run with a step [s]."""
        return sample_times(self.start, max(step, self.spacing), self.length)


def sample_times(start: float, spacing: float, length: float) -> Array:
    """Return times [s] (n_t,) at a spacing [s] over a length [s], without the start."""
    count = int(length / spacing * (1 + 1e-12))
    return np.asarray(start + spacing * np.arange(1, count + 1), dtype=float)


def horizon_of(case: Case) -> Horizon:
    """Return the horizon of a case."""
    length, growth = permitted_horizon(case)
    coarsest = power_of_two(min(shortest_period(case) / SWEEP.coarsest, length / SWEEP.min_samples))
    spacing = min(coarsest, power_of_two(length / SWEEP.samples))
    return Horizon(case.start_time, coarsest, spacing, length, growth)


def thinned(values: Array, count: int) -> Array:
    """Return samples (k, n) at as many (count) equally spaced times, each a multiple."""
    every = values.shape[1] // count
    return values[:, every - 1 :: every][:, :count]


def reference_of(setup: Setup, span: Horizon, equations: ModelEquations) -> Truth:
    """Return the solution of equations at the finest samples."""
    times = span.times(span.spacing)
    return roundoff_reference(equations, setup.case, times, setup.scene.observables)


def swept(series: StepSeries, repeats: int = SWEEP.repeats) -> StepSeries:
    """Run a series from its coarsest step until halving is no longer a gain."""
    setup = setup_of(series)
    case, names, span = setup.case, setup.scene.observables, horizon_of(setup.case)
    exact = reference_of(setup, span, scene_equations(case))
    runs: list[Array | None] = []
    points: list[Point] = []
    for step in (span.coarsest / 2**level for level in range(SWEEP.levels)):
        times = span.times(step)
        steps = round((times[-1] - span.start) / step)
        has_run = any(point.cost for point in points)
        if steps > (SWEEP.max_steps if has_run else SWEEP.max_first_steps):
            break
        try:
            trajectories = [run(setup.with_step(step), times)]
            while len(trajectories) < repeats and trajectories[0].seconds < SWEEP.brief:
                trajectories.append(run(setup.with_step(step), times))
        except EngineError as failure:
            runs.append(None)
            points.append(Point(step, None, reason=f"{failure.kind}: {failure.message}"))
            continue
        values = trajectories[0].matrix(names)
        right = thinned(exact.values, len(times))
        errors = (np.max(np.abs(values - right), axis=1) / exact.size).tolist()
        length, first = float(times[-1] - span.start), trajectories[0]
        counts = (first.rhs_evaluations, first.newton_iterations)
        cost = Cost.of(
            [one.seconds / length for one in trajectories],
            first.steps / length,
            *(None if count is None else count / length for count in counts),
        )
        runs.append(values)
        points.append(Point(step, max(errors), dict(zip(names, errors, strict=True)), cost))
        if finished(points) or min(one.seconds for one in trajectories) > SWEEP.longest_run:
            break
    parts = changes(runs, exact.size[:, None], setup.integrator.order)
    limit = stable_step(
        setup, max(span.length, SWEEP.periods * setup.scene.period(case.parameters))
    )
    labelled = label(points, parts, setup, exact, resized=case != case_of(series.scene))
    series = replace(series, points=tuple(labelled))
    return summed(replace(series, stable_step=limit and limit.step))


def finished(points: Sequence[Point]) -> bool:
    """Return True if halving the step has been no gain twice, after it had been one."""
    errors = [point.error for point in points if point.error is not None]
    if len(errors) < 3 or min(errors) > SWEEP.asymptotic_error:
        return False
    return all(after > SWEEP.gain * before for before, after in pairwise(errors[-3:]))


def changes(runs: Sequence[Array | None], size: Array, order: int) -> list[float | None]:
    """Return the step's part of each error, from the change by the next halving.

    It is None for a run that failed or whose next did; for the last run it is that of the run
    before, divided according to the order.
    """
    gain = 2.0**order
    parts: list[float | None] = []
    for now, after in pairwise(runs):
        if now is None or after is None:
            parts.append(None)
            continue
        change = np.max(np.abs(now - thinned(after, now.shape[1])) / size)
        parts.append(float(change) * gain / (gain - 1))
    return [*parts, None if not parts or parts[-1] is None else parts[-1] / gain]


def floor_name(setup: Setup) -> str:
    """Return the name of the error that the model's equations leave."""
    names = {
        "continuum": setup.bound.approximates_continuum,
        "spatial discretisation": setup.bound.description.element_order,
        "closure softness": setup.bound.has_constraints,
        "inertia floor": not setup.bound.is_exact,
    }
    return next((name for name, applies in names.items() if applies), "")


def label(
    points: Sequence[Point],
    parts: Sequence[float | None],
    setup: Setup,
    exact: Truth,
    resized: bool,
) -> list[Point]:
    """Return the points with the limit of each, and a mark for wasted steps.

    The step limits a point if its part is half of the error or more. Where that part is unknown,
    the model limits it if its equations explain half of the error. A continuum with other segments
    than the case is not solved again, which would take long: halved steps show the same.
    """
    span, model, continuum = horizon_of(setup.case), exact, setup.bound.approximates_continuum
    if not (setup.bound.is_exact or (resized and not continuum)):
        model = reference_of(setup, span, setup.bound.equations)
    model_error, elements = relative_error(model.values, exact), resized or continuum
    trust = float(np.max(exact.bound / exact.size))
    solves = setup.integrator.scheme is None or setup.bound.has_constraints
    labelled: list[Point] = []
    least = np.inf
    for point, part in zip(points, parts, strict=True):
        if point.error is not None and point.cost is not None:
            by_model = model_error > point.error / 2
            by_step = not (elements or by_model) if part is None else part >= point.error / 2
            roundoff = rounding(round(point.cost.steps), span.growth)
            limits = (
                (by_step, STEP, "step"),
                (by_model and model_error > trust, MODEL, floor_name(setup)),
                (elements, MODEL, "spatial discretisation"),
                (point.error < max(roundoff, 2 * trust), ROUND_OFF, "round-off"),
                (True, MODEL, "solver tolerance" if solves else UNEXPLAINED),
            )
            _, kind, name = next(row for row in limits if row[0])
            at_floor = any(one.label in (MODEL, ROUND_OFF) for one in labelled)
            wasted = at_floor or point.error > SWEEP.gain * least
            least = min(least, point.error)
            point = replace(point, label=kind, limit=name, wasted=wasted)
        labelled.append(point)
    return labelled


def summed(series: StepSeries) -> StepSeries:
    """Return a series with the order of its points, and its floor."""
    good = [(point, point.error) for point in series.points if point.error is not None]
    clear = [
        (p.step, e)
        for p, e in good
        if p.label == STEP and e < SWEEP.asymptotic_error and not p.wasted
    ]
    steps, errors = np.log(np.reshape(clear, (-1, 2))).T
    slope = float(np.polyfit(steps, errors, 1)[0]) if len(clear) > 1 else None
    floor, name = min(
        ((error, p.limit) for p, error in good if p.label != STEP), default=(None, "")
    )
    return replace(series, slope=slope, plateau=floor, plateau_name=name)


def beside(series: StepSeries, others: Sequence[StepSeries]) -> StepSeries:
    """Return a series with its floors named by comparison with the one without options.

    A floor above twice its least error is the effect of the option.
    """
    names = series.engine, series.model, series.method, series.scene
    default = [
        one
        for one in others
        if (one.engine, one.model, one.method, one.scene) == names and not one.settings
    ]
    if not (default and series.settings) or series.plateau is None:
        return series
    setup = setup_of(series)
    options = setup.engine.bind(setup.case, series.model).options(setup.integrator)
    limits = [option.error_source for option in options if option.name in series.settings]
    if not limits or series.plateau < 2 * min(trial.error for trial in trials_of(default)):
        return series
    points = [
        point if point.label == STEP or point.error is None else replace(point, limit=limits[0])
        for point in series.points
    ]
    return replace(series, points=tuple(points), plateau_name=limits[0])


def smallest(series: Sequence[StepSeries], target: float) -> Iterator[Choice]:
    """Yield the smallest models that meet a target, one for each axis besides the step.

    Models are ordered from few parts, or a coarse option, on: the first one from which on all meet
    the target is chosen, with its cheapest step.
    """
    for default in (one for one in series if not one.settings):
        names = default.engine, default.model, default.method
        mine = [one for one in series if (one.engine, one.model, one.method) == names]
        for option in second_axes(setup_of(default)):
            row = [
                (value, one)
                for value in option.values
                for one in mine
                if one.settings == ({} if value == option.default else {option.name: value})
            ]
            if len(row) < 2:
                continue
            meets = [cheapest_run([one], target) is not None for _, one in row]
            first = len(row) - len([*takewhile(bool, reversed(meets))])
            value, one = row[first] if first < len(row) else (None, row[-1][1])
            coarser = [one for _, one in row[:first][-1:]] if first < len(row) else []
            errors = [trial.error for trial in trials_of(coarser) if trial.error > target]
            smaller = min(errors, default=None)
            axis = {"axis": option.name, "unit": option.unit}
            yield choose([one], target, **axis, value=value, smaller=smaller)
