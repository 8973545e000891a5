"""Runs over halved steps: errors, what they cost, and what limits them.

The error of a run against the scene has three parts. What halving the step changes is the
*step's*; what the equations that the model claims are off the scene's is the *model's*; what
is left is rounding, a solver that stops early, or elements. The largest names the point.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from statistics import median

import numpy as np
from numpy.typing import NDArray

from ...reference import SCENES, get_scene
from ...reference.errors import EngineError
from ...reference.scene import Array, Case
from ..checks.free_vibrations import stable_step
from ..checks.suite import best_method
from ..checks.tolerances import rounding
from ..checks.truth import Truth, permitted_horizon, roundoff_reference
from ..engines.adapter import Adapter
from ..engines.equations import ModelEquations, scene_equations
from ..engines.protocol import Method
from ..engines.registry import get_engine
from ..engines.run import Trajectory
from ..engines.setup import Setup, power_of_two, run, shortest_period
from ..scenes.tradeoff import relative_error
from .series import MODEL, ROUND_OFF, STEP, UNEXPLAINED, Cost, Point, StepSeries

COARSEST = 4
"""Steps in the shortest period that a sweep begins with."""

LEVELS, MOST_STEPS, FIRST_STEPS = 20, 1 << 15, 1 << 17
"""Times that the step is halved at most, steps of the longest run, and of the first that holds."""

LONGEST = 4.0
"""A sweep ends after a run that takes longer than this [s]."""

SAMPLES, LEAST_SAMPLES = 64, 8
"""Samples that runs are compared at, and those of the longest step."""

REPEATS, BRIEF = 3, 1.0
"""Runs of which the wall time is the median, if they are shorter than this [s]."""

GAIN = 0.9
"""An error above this share of that with a longer step is no gain."""

SMALL = 0.1
"""Relative errors above this are outside of what an order describes."""

PERIODS = 100
"""Of the scene: a step is stable that bounds free vibrations so long; a run may be far shorter."""

SEGMENTS = (6, 12, 24, 48, 64)
"""Of a continuum, where they are the second axis."""


@dataclass(frozen=True)
class Sweep:
    """One series that is to be made.

    Attributes
    ----------
    scene, engine, model, method : str
    settings : tuple of (name, value)
        `segments`, or an option of the engine, that is not at its default.
    """

    scene: str
    engine: str
    model: str
    method: str
    settings: tuple[tuple[str, float], ...] = ()

    @property
    def name(self) -> str:
        """All of it in words."""
        words = (self.scene, self.engine, self.model, self.method)
        return " ".join(filter(None, [*words, settings_text(dict(self.settings))]))


def sweeps(scenes: Sequence[str], engines: Sequence[str]) -> list[Sweep]:
    """Return the series of these scenes and engines: all methods, then what else limits them."""
    return [
        replace(one, engine=name)  # by which a worker process finds it too
        for scene in scenes or SCENES
        for name in engines
        for model in get_engine(name).distinct_models(scene)
        for one in of_model(scene, get_engine(name), model)
    ]


def of_model(scene: str, engine: Adapter, model: str) -> Iterator[Sweep]:
    """Yield the series of one model; the second axis is that of its best method."""
    setup = Setup(engine, case_of(scene), model)
    case, top = setup.case, best_method(setup)
    for method in engine.methods:
        if engine.why_not(case, model, method) is None:
            yield Sweep(scene, engine.name, model, method.name)
    if top is None:
        return
    again = partial(Sweep, scene, engine.name, model, top.name)
    for option in engine.options(case, model, top):
        yield from (
            again(((option.name, value),)) for value in option.values if value != option.default
        )
    if setup.element_order:
        others = (float(count) for count in SEGMENTS if count != case.parameters.segments)
        yield from (again((("segments", count),)) for count in others)


def case_of(scene: str) -> Case:
    """Return the case that methods of a scene are compared with: a run that feeds *order*."""
    cases = [case for case in get_scene(scene).cases if "trajectory" in case.kinds]
    return next((case for case in cases if "order" in case.kinds), cases[0])


def setup_of(sweep: Sweep) -> Setup:
    """Return engine, case, model and method of a series with its settings applied."""
    engine, case = get_engine(sweep.engine), case_of(sweep.scene)
    method = next(item for item in engine.methods if item.name == sweep.method)
    for name, value in sweep.settings:
        if name == "segments":
            case = replace(case, parameters=case.parameters.replace(segments=value))
        else:
            engine = engine.with_option(name, value)
    return Setup(engine, case, sweep.model, method)


@dataclass(frozen=True)
class Horizon:
    """Where runs of a series are sampled: at each step, or at the spacing if that is longer.

    Attributes
    ----------
    coarsest : float
        Step that the sweep begins with [s], a power of two.
    spacing : float
        Of the samples [s], a power of two.
    length : float
        Of the run [s].
    growth : float
        What an initial error grows by.
    """

    coarsest: float
    spacing: float
    length: float
    growth: float

    def numbers(self, spacing: float, stride: int) -> NDArray[np.int_]:
        """Return the numbers of spacings in the run, one of so many."""
        return stride * np.arange(1, int(self.length / (stride * spacing) * (1 + 1e-12)) + 1)

    def samples(self, step: float) -> NDArray[np.int_]:
        """Return the step numbers of the samples of a run."""
        return self.numbers(step, round(max(step, self.spacing) / step))

    def times(self, case: Case, step: float) -> Array:
        """Return the times of these samples [s]."""
        return np.asarray(case.start_time + self.samples(step) * step, dtype=float)

    def rows(self, step: float) -> NDArray[np.int_]:
        """Return where these samples are among those of the finest run."""
        return self.numbers(self.spacing, round(max(step, self.spacing) / self.spacing)) - 1


def horizon_of(case: Case) -> Horizon:
    """Return how far a case is run, and at which times it is looked at."""
    length, growth = permitted_horizon(case)
    coarsest = power_of_two(min(shortest_period(case) / COARSEST, length / LEAST_SAMPLES))
    return Horizon(coarsest, min(coarsest, power_of_two(length / SAMPLES)), length, growth)


def reference_of(setup: Setup, span: Horizon, equations: ModelEquations | None = None) -> Truth:
    """Return the solution of the scene, or of other equations, at the finest samples."""
    case, times = setup.case, span.times(setup.case, span.spacing)
    return roundoff_reference(
        equations or scene_equations(case), case, times, setup.scene.observables
    )


def measure(sweep: Sweep, repeats: int = REPEATS) -> StepSeries:
    """Run a series from its coarsest step to where halving no longer pays."""
    setup = setup_of(sweep)
    span, method = horizon_of(setup.case), setup.integrator
    exact = reference_of(setup, span)
    size = exact.size[:, None]
    runs: list[Array | None] = []
    points: list[Point] = []
    for level in range(LEVELS):
        step = span.coarsest / 2**level
        if span.samples(step)[-1] > (MOST_STEPS if any(p.cost for p in points) else FIRST_STEPS):
            break
        try:
            trajectories = repeated(setup.with_step(step), span.times(setup.case, step), repeats)
        except EngineError as failure:
            runs.append(None)
            points.append(Point(step, None, reason=f"{failure.kind}: {failure.message}"))
            continue
        runs.append(trajectories[0].matrix(setup.scene.observables))
        sampled = replace(exact, values=exact.values[:, span.rows(step)])
        points.append(point_of(trajectories, sampled, step, setup))
        if finished(points) or min(one.seconds for one in trajectories) > LONGEST:
            break
    floor = floor_of(setup, span, exact, resized=setup.case != case_of(sweep.scene))
    labelled = label(points, changes(runs, size, method.order), floor)
    limit = stable_step(
        setup, max(span.length, PERIODS * setup.scene.period(setup.case.parameters))
    )
    return replace(summed(sweep, method, labelled), stable_step=limit and limit.step)


def repeated(setup: Setup, times: Array, repeats: int) -> list[Trajectory]:
    """Return runs of a setup, repeated while they are brief."""
    trajectories = [run(setup, times)]
    while len(trajectories) < repeats and trajectories[0].seconds < BRIEF:
        trajectories.append(run(setup, times))
    return trajectories


def point_of(trajectories: Sequence[Trajectory], right: Truth, step: float, setup: Setup) -> Point:
    """Return the point of repeated runs with a step beside the reference."""
    names, first = setup.scene.observables, trajectories[0]
    errors = np.max(np.abs(first.matrix(names) - right.values) / right.size[:, None], axis=1)
    span = float(first.times[-1] - setup.case.start_time)
    by_name = dict(zip(names, errors.tolist(), strict=True))
    return Point(step, float(np.max(errors)), by_name, cost(trajectories, span))


def cost(made: Sequence[Trajectory], span: float) -> Cost:
    """Return what repeated runs over a span [s] cost."""
    seconds = [item.seconds / span for item in made]
    first = made[0]
    return Cost(
        seconds=median(seconds),
        fastest=min(seconds),
        slowest=max(seconds),
        steps=first.steps / span,
        rhs_evaluations=per(first.rhs_evaluations, span),
        newton_iterations=per(first.newton_iterations, span),
    )


def per(count: int | None, span: float) -> float | None:
    """Return a count per simulated second, if there is one."""
    return None if count is None else count / span


def finished(points: Sequence[Point]) -> bool:
    """Return whether halving the step has been no gain twice, after it had been one."""
    errors = [point.error for point in points if point.error is not None]
    if len(errors) < 3 or min(errors) > SMALL:
        return False
    return all(after > GAIN * before for before, after in pairwise(errors[-3:]))


def changes(runs: Sequence[Array | None], size: Array, order: int) -> list[float | None]:
    """Return the step's part of each error: what the next halving takes away, and the rest of it.

    None for a run that failed or whose next did; the last has that of the run before, divided
    as the order says.
    """
    gain = 2.0**order
    parts: list[float | None] = []
    for now, after in pairwise(runs):
        if now is None or after is None:
            parts.append(None)
            continue
        every = after.shape[1] // now.shape[1]
        common = after[:, every - 1 :: every][:, : now.shape[1]]
        parts.append(float(np.max(np.abs(now - common) / size)) * gain / (gain - 1))
    return [*parts, None if not parts or parts[-1] is None else parts[-1] / gain]


@dataclass(frozen=True)
class Floor:
    """What no step takes away.

    Attributes
    ----------
    model_error : float
        Of the model's equations against the scene's.
    name : str
        What makes it, see `Series.plateau_name`.
    trust : float
        The reference's own bound.
    elements : bool
        Whether elements limit it beside the model's equations.
    growth : float
        What an initial error grows by.
    solver : bool
        Whether a solver, of an implicit method or of constraints, may stop early.
    """

    model_error: float
    name: str
    trust: float
    elements: bool
    growth: float
    solver: bool

    def explains(self, error: float) -> bool:
        """Return whether an error may be what the model leaves, where no other step tells."""
        return self.elements or self.model_error > error / 2

    def named(self, error: float, steps: float) -> tuple[str, str]:
        """Return the label and the name of an error that the step does not explain."""
        if self.model_error > error / 2 and self.model_error > self.trust:
            return MODEL, self.name
        if self.elements:
            return MODEL, "spatial discretisation"
        if error < max(rounding(round(steps), self.growth), 2 * self.trust):
            return ROUND_OFF, "round-off"
        return MODEL, "solver tolerance" if self.solver else UNEXPLAINED


def floor_of(setup: Setup, span: Horizon, exact: Truth, resized: bool) -> Floor:
    """Return what no step takes away from the errors of a setup.

    Where it has other segments than the case, solving a long chain takes longer than all that it
    tells: halved steps tell it too.
    """
    elements = setup.approximates_continuum
    model = exact
    if not (setup.is_exact or (resized and not elements)):
        model = reference_of(setup, span, setup.equations)
    return Floor(
        model_error=relative_error(model.values, exact),
        name=plateau_of(setup),
        trust=float(np.max(exact.bound / exact.size)),
        elements=resized or elements,
        growth=span.growth,
        solver=setup.integrator.scheme is None or setup.has_constraints,
    )


def plateau_of(setup: Setup) -> str:
    """Return what a model's own equations differ from the scene's by."""
    if setup.approximates_continuum:
        return "continuum"
    if setup.element_order:
        return "spatial discretisation"
    if setup.has_constraints:
        return "closure softness"
    return "" if setup.is_exact else "inertia floor"


def label(points: Sequence[Point], parts: Sequence[float | None], floor: Floor) -> list[Point]:
    """Return the points with what limits each, and whether its step is wasted."""
    labelled: list[Point] = []
    least = np.inf
    for point, part in zip(points, parts, strict=True):
        if point.error is None or point.cost is None:
            labelled.append(point)
            continue
        by_step = not floor.explains(point.error) if part is None else part >= point.error / 2
        kind, name = (STEP, "step") if by_step else floor.named(point.error, point.cost.steps)
        wasted = point.error > GAIN * least or any(
            one.label in (MODEL, ROUND_OFF) for one in labelled
        )
        least = min(least, point.error)
        labelled.append(replace(point, label=kind, limit=name, wasted=wasted))
    return labelled


def summed(sweep: Sweep, method: Method, points: Sequence[Point]) -> StepSeries:
    """Return the series, with the order that its points show and the floor that it meets."""
    good = [point for point in points if point.error is not None]
    on_slope = [
        point for point in good if point.label == STEP and (point.error or 0) < SMALL
        and not point.wasted
    ]  # fmt: skip
    met = [point for point in good if point.label != STEP]
    lowest = min(met, key=lambda point: point.error or 0.0, default=None)
    return StepSeries(
        scene=sweep.scene,
        case=case_of(sweep.scene).name,
        engine=sweep.engine,
        model=sweep.model,
        method=sweep.method,
        order=method.order,
        settings=dict(sweep.settings),
        points=tuple(points),
        slope=fitted(on_slope),
        plateau=lowest.error if lowest else None,
        plateau_name=lowest.limit if lowest else "",
    )


def beside(series: StepSeries, default: StepSeries) -> StepSeries:
    """Return a series with an option set, its floors named by what the default's are.

    What is more than twice the least error of the default is the option's doing.
    """
    engine, case = get_engine(series.engine), case_of(series.scene)
    method = next(item for item in engine.methods if item.name == series.method)
    limits = {
        option.name: option.limits
        for option in engine.options(case, series.model, method)
        if option.name in series.settings
    }
    least = min((point.error for point in default.points if point.error is not None), default=0.0)
    if not limits or series.plateau is None or series.plateau < 2 * least:
        return series
    name = next(iter(limits.values()))
    points = tuple(
        replace(point, limit=name) if point.label != STEP and point.error is not None else point
        for point in series.points
    )
    return replace(series, points=points, plateau_name=name)


def fitted(points: Sequence[Point]) -> float | None:
    """Return the slope of errors over steps, None of fewer than two."""
    if len(points) < 2:
        return None
    steps = np.log([point.step for point in points])
    return float(np.polyfit(steps, np.log([point.error or np.nan for point in points]), 1)[0])


def settings_text(settings: Mapping[str, float]) -> str:
    """Return settings in words."""
    return ", ".join(f"{name} {value:g}" for name, value in settings.items())
