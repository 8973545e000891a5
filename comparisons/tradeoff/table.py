"""The table of a trade-off: settings that were run, their errors, their costs, and the choice.

It serves scenes and MJCF files, whose runs and references differ.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from statistics import median
from typing import Any, NamedTuple

STEP, MODEL, ROUND_OFF, FAILED = "step-limited", "model-limited", "round-off", "failed"

UNEXPLAINED = "unexplained"
"""Name of a plateau that neither the model nor a solver explains."""

NOISE = 1.2
"""Factor up to which median times count as equal."""

STABLE = 1.02
"""Ratio to the largest stable step above which a step is unstable."""


@dataclass(frozen=True)
class Cost:
    """Cost of a run per simulated second.

    Attributes
    ----------
    seconds : float
        Median time of the stepping of repeated runs [s/s] on this machine: wall time for scenes,
        processor time for files.
    fastest : float
        Shortest time of these runs [s/s].
    slowest : float
        Longest time of these runs [s/s].
    steps : float
        Steps [1/s].
    rhs_evaluations : float or None
        Evaluations of the forces [1/s], comparable across machines; None if they are not counted.
    newton_iterations : float or None
        Newton iterations [1/s]; None if they are not counted.
    """

    seconds: float
    fastest: float
    slowest: float
    steps: float
    rhs_evaluations: float | None = None
    newton_iterations: float | None = None

    @classmethod
    def of(cls, seconds: Sequence[float], steps: float, *counts: float | None) -> Cost:
        """Return the cost of repeated runs, from their times [s/s] and counts [1/s]."""
        return cls(median(seconds), min(seconds), max(seconds), steps, *counts)


@dataclass(frozen=True)
class Point:
    """Error and cost of one setting of a series.

    Attributes
    ----------
    step : float
        Step of the run [s].
    error : float or None
        Largest error, relative to the size of the motion; None if the run failed.
    errors : mapping of str to float
        Errors by observable. For a file: ``energy``, the largest difference of the energy over the
        largest kinetic energy, and ``violation``, the largest residual of an equality (m, rad).
    cost : Cost or None
        Cost per simulated second; None if it was not measured.
    label : str
        Limit of the error: ``step-limited``, ``model-limited``, ``round-off`` or ``failed``; empty
        if it is unknown.
    limit : str
        Limit of the error in words: ``step``, or the name of the plateau.
    wasted : bool
        True if a longer step has the same error.
    reason : str
        Reason why the run failed.
    bound : float or None
        Uncertainty of the error.
    """

    step: float
    error: float | None
    errors: Mapping[str, float] = field(default_factory=dict)
    cost: Cost | None = None
    label: str = FAILED
    limit: str = ""
    wasted: bool = False
    reason: str = ""
    bound: float | None = None


@dataclass(frozen=True)
class MeasuredCase:
    """Scene, case and engine that a measurement is about.

    Attributes
    ----------
    scene : str
        Scene, or name of the file.
    case : str
        Case; empty for a file.
    engine : str
        Engine; ``reference`` for theories.
    """

    scene: str
    case: str
    engine: str


@dataclass(frozen=True)
class StepSeries(MeasuredCase):
    """Runs of a model by a method over steps.

    Attributes
    ----------
    model : str
        The engine's model of the scene; empty for a file.
    method : str
        Integrator.
    order : int
        Declared order of convergence; 0 if there is none.
    settings : mapping of str to float
        Options that are not at their default, and ``segments`` of a continuum; for a file
        ``iterations`` of the solver, and ``closure_steps``, the largest time constant of an
        equality over the step.
    points : tuple of Point
        Runs, the longest step first.
    slope : float or None
        Order fitted to the step-limited points; None if there are fewer than two.
    plateau : float or None
        Error that no step removes; None if none was reached.
    plateau_name : str
        ``closure softness``, ``inertia floor``, ``spatial discretisation``, ``continuum``,
        ``round-off``, ``solver tolerance`` or `UNEXPLAINED`.
    stable_step : float or None
        Largest step that keeps free vibrations bounded [s]; None if there is none, or it is
        unknown.
    """

    model: str
    method: str
    order: int
    settings: Mapping[str, float]
    points: tuple[Point, ...] = ()
    slope: float | None = None
    plateau: float | None = None
    plateau_name: str = ""
    stable_step: float | None = None

    @property
    def name(self) -> str:
        """Scene, engine and setting in words."""
        return f"{self.scene} {self.engine} {self.setting}"

    @property
    def setting(self) -> str:
        """Model, method and settings in words."""
        words = [self.model, self.method, settings_text(self.settings)]
        return " ".join(filter(None, words))


class Trial(NamedTuple):
    """A series, and one of its points."""

    series: StepSeries
    point: Point

    @property
    def seconds(self) -> float:
        """Time per simulated second [s/s]."""
        return self.point.cost.seconds if self.point.cost else inf

    @property
    def error(self) -> float:
        """Error of the run; infinite if it failed."""
        return inf if self.point.error is None else self.point.error

    @property
    def as_run(self) -> SettingRun:
        """Run as documents have it."""
        one, point = self
        names = one.engine, one.model, one.method, one.settings
        return SettingRun(*names, point.step, point.error, self.seconds)


@dataclass(frozen=True)
class SettingRun:
    """Run of one setting.

    Attributes
    ----------
    engine : str
        engine
    model : str
        model; empty for a file
    method : str
        integrator
    settings : mapping of str to float
        settings, as in a series
    step : float
        step [s]
    error : float or None
        error; null if the run failed
    seconds : float
        time per simulated second [s/s]
    """

    engine: str
    model: str
    method: str
    settings: Mapping[str, float]
    step: float
    error: float | None
    seconds: float


@dataclass(frozen=True)
class Choice(MeasuredCase):
    """Cheapest setting, or smallest model, that meets a target, or the reason why there is none.

    Attributes
    ----------
    target : float
        Relative error allowed.
    model : str or None
        The engine's model; None if no setting meets the target.
    method : str or None
        Integrator; None if no setting meets the target.
    settings : mapping of str to float
        Options and segments that are not at their default.
    step : float or None
        Longest step [s] with which a run meets the target.
    error : float or None
        Measured error; the smallest one if none meets the target.
    cost : Cost or None
        Cost per simulated second; None without a run.
    limit : str
        Limit of the error there, or reason why no setting or model meets the target.
    margin : float or None
        Largest stable step by theory over the step; None if no step is unstable, or the theory is
        unknown.
    axis : str
        ``step`` for the cheapest setting; for the smallest model parts of a continuum, or an option
        of the engine.
    unit : str
        Unit of the axis.
    value : float or None
        Smallest model from which on all meet the target, on that axis; None if there is none.
    smaller : float or None
        Error above the target of the next smaller model.
    met : bool
        True if the target is met.
    """

    target: float
    model: str | None = None
    method: str | None = None
    settings: Mapping[str, float] | None = None
    step: float | None = None
    error: float | None = None
    cost: Cost | None = None
    limit: str = ""
    margin: float | None = None
    axis: str = "step"
    unit: str = "s"
    value: float | None = None
    smaller: float | None = None
    met: bool = False


def trials_of(series: Iterable[StepSeries]) -> Iterator[Trial]:
    """Yield all runs of some series."""
    for one in series:
        yield from (Trial(one, point) for point in one.points)


def pareto(rows: Iterable[Trial]) -> list[Trial]:
    """Return the runs that none beats in both error and time, cheapest first."""
    front: list[Trial] = []
    for row in sorted(rows, key=lambda row: (row.seconds, row.error)):
        if row.error < min([1.0, *(other.error for other in front)]) and row.seconds < inf:
            front.append(row)
    return front


def steady(series: Iterable[StepSeries], target: float, share: float = 1.0) -> Iterator[Trial]:
    """Yield the runs that meet a share of a target, if all with shorter steps meet the target.

    A single error may be small by chance. Steps above the largest stable one are left out.
    """
    for one in series:
        for point in reversed(one.points):
            if point.error is None or point.error > target:
                break
            stable = one.stable_step is None or point.step <= STABLE * one.stable_step
            if point.error <= share * target and stable:
                yield Trial(one, point)


def cheapest(
    rows: Iterable[Trial],
    price: Callable[[Trial], float],
    preference: Callable[[Trial], object],
    noise: float = 1.0,
) -> Trial | None:
    """Return the preferred row among those with the lowest price, up to a factor of noise."""
    good = list(rows)
    least = min(map(price, good), default=0.0)
    alike = [row for row in good if price(row) <= noise * least]
    return min(alike, key=preference, default=None)  # type: ignore[arg-type]


def cheapest_run(series: Sequence[StepSeries], target: float) -> Trial | None:
    """Return the cheapest run of some series that meets a target.

    Among settings of about the same cost, the one with the fewest options set, then the most
    accurate, is chosen, since times scatter. The shortest step of a series must be at its floor,
    since the error with half of it is unknown.
    """
    good = [
        row
        for row in steady(series, target)
        if row.point is not row.series.points[-1] or row.point.label in (MODEL, ROUND_OFF)
    ]
    return cheapest(
        good, lambda row: row.seconds, lambda row: (len(row.series.settings), row.error), NOISE
    )


def choose(series: Sequence[StepSeries], target: float, **axis: Any) -> Choice:
    """Return the cheapest setting of one engine for one scene, or the reason why there is none.

    Parameters
    ----------
    series : sequence of StepSeries
        Series of one engine and one scene.
    target : float
    **axis
        Fields of the choice about the axis of a smallest model.
    """
    best = cheapest_run(series, target)
    if best is None:
        one, least = min(trials_of(series), key=lambda trial: trial.error)
        words = "no run reached its end"
        words = words if least.error is None else f"{least.limit} of {one.setting}"
        return Choice(
            one.scene, one.case, one.engine, target, error=least.error, limit=words, **axis
        )
    one, point = best
    return Choice(
        one.scene, one.case, one.engine, target, one.model, one.method, one.settings,
        step=point.step,
        error=point.error,
        cost=point.cost,
        limit=point.limit,
        margin=None if one.stable_step is None else one.stable_step / point.step,
        met=True,
        **axis,
    )  # fmt: skip


def settings_text(settings: Mapping[str, float]) -> str:
    """Return settings in words."""
    return ", ".join(f"{name} {value:g}" for name, value in settings.items())


def percent(value: float | None) -> str:
    """Return a relative error in per cent."""
    return "state lost" if value is None or not value < inf else f"{100 * value:.2g} %"
