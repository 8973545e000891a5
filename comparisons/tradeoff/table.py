"""The table of a trade-off: settings that were run, their errors, what they cost, and the choice.

Scenes and MJCF files differ in what runs and in what is true; all that follows is here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import Any, NamedTuple

import numpy as np

STEP, MODEL, ROUND_OFF, FAILED = "step-limited", "model-limited", "round-off", "failed"

UNEXPLAINED = "unexplained"
"""Name of a plateau that a right model by a method without a solver has no reason for."""

TARGETS = (1e-2, 1e-3, 1e-4)
"""Relative errors that settings are recommended for by default."""


@dataclass(frozen=True)
class Cost:
    """Cost of a run per simulated second.

    Attributes
    ----------
    seconds : float
        Time of the stepping [s/s] on this machine, the median of repeated runs: wall time of a
        scene, processor time of a file.
    fastest, slowest : float
        Shortest and longest time of these runs.
    steps : float
    rhs_evaluations, newton_iterations : float or None
        None where the engine does not count them. Counts may be compared across machines.
    """

    seconds: float
    fastest: float
    slowest: float
    steps: float
    rhs_evaluations: float | None = None
    newton_iterations: float | None = None


@dataclass(frozen=True)
class Point:
    """One setting of a series, run: its error and its cost.

    Attributes
    ----------
    step : float or None
        Step of the run [s]; None where the error is that of equations.
    error : float or None
        Largest error, relative to the size of the motion; None if the run failed.
    errors : mapping of str to float
        Errors by observable. Of a file: ``energy``, the largest difference of the energy over
        the largest kinetic energy, and ``violation``, the largest residual of an equality (m, rad).
    cost : Cost or None
    label : str
        What limits the error: `STEP`, `MODEL`, `ROUND_OFF` or `FAILED`.
    limit : str
        The same in words: ``step``, or the name of the plateau.
    wasted : bool
        A longer step has the same error.
    reason : str
        Why the run failed.
    value : float or None
        Value on an axis that is not the step.
    bound : float or None
        Uncertainty of the error.
    """

    step: float | None
    error: float | None
    errors: Mapping[str, float] = field(default_factory=dict)
    cost: Cost | None = None
    label: str = FAILED
    limit: str = ""
    wasted: bool = False
    reason: str = ""
    value: float | None = None
    bound: float | None = None


@dataclass(frozen=True)
class StepSeries:
    """A model and a method over steps or, on another axis, over models from small to large.

    Attributes
    ----------
    scene, case, engine, model, method : str
        Of a file its name stands for the scene.
    order : int
        Declared order of convergence; 0 where none is.
    settings : mapping of str to float
        Options that are not at their default, and ``segments`` of a continuum.
    points : tuple of Point
        The longest step, or the smallest model, first.
    axis, unit : str
        What varies: ``step``, parts of a continuum, an option that closes a loop, what is left
        out (0: it is left out, 1: it is there), or ``steps in a period``.
    quantity : str
        What the error is of; empty for all observables.
    slope : float or None
        Order fitted to the points that are step-limited; None if fewer than two are.
    plateau : float or None
        Error that no step removes; None where none was reached.
    plateau_name : str
        ``closure softness``, ``inertia floor``, ``spatial discretisation``, ``continuum``,
        ``round-off``, ``solver tolerance`` or `UNEXPLAINED`. No clock rounds: all steps are
        powers of two.
    stable_step : float or None
        Largest step that keeps free vibrations bounded [s]; None if there is none, or no theory
        is known.
    """

    scene: str
    case: str
    engine: str
    model: str
    method: str
    order: int
    settings: Mapping[str, float]
    points: tuple[Point, ...] = ()
    slope: float | None = None
    plateau: float | None = None
    plateau_name: str = ""
    stable_step: float | None = None
    axis: str = "step"
    unit: str = "s"
    quantity: str = ""

    @property
    def name(self) -> str:
        """All of it in words."""
        return f"{self.scene} {self.engine} {self.setting}"

    def choice(self, target: float, **values: Any) -> Choice:
        """Return a choice from this series."""
        names = ("scene", "case", "engine", "model", "method", "settings", "axis", "unit")
        own = {name: getattr(self, name) for name in (*names, "quantity")}
        return Choice(target=target, **own, **values)

    @property
    def setting(self) -> str:
        """The model, the method and the settings in words."""
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


@dataclass(frozen=True)
class Choice:
    """The cheapest setting, or the smallest model, that meets a target, or why there is none.

    Attributes
    ----------
    scene, case, engine : str
    target : float
        Relative error that is allowed.
    model, method : str or None
        None where no setting meets the target.
    settings : mapping of str to float
        Options and segments that are not at their default.
    step : float or None
        Longest step [s] with which a run meets the target.
    error : float or None
        Measured error; where none meets the target the smallest one.
    cost : Cost or None
    limit : str
        What limits the error there, or why no setting or model meets the target.
    margin : float or None
        Largest stable step by theory over the step; None where no step is unstable, or no
        theory is known.
    longest : float or None
        Longest step of the sweep that this method survived with an error below 1, over the step.
    axis, unit, quantity : str
        As of the series.
    value : float or None
        Of the smallest model that meets the target, on its axis.
    smaller : float or None
        Error of the next smaller model, which misses the target.
    extrapolated : bool
        The value follows from the declared order; the model was not run.
    met : bool
        Whether the target is met.
    """

    scene: str
    case: str
    engine: str
    target: float
    model: str | None = None
    method: str | None = None
    settings: Mapping[str, float] | None = None
    step: float | None = None
    error: float | None = None
    cost: Cost | None = None
    limit: str = ""
    margin: float | None = None
    longest: float | None = None
    axis: str = "step"
    unit: str = "s"
    quantity: str = ""
    value: float | None = None
    smaller: float | None = None
    extrapolated: bool = False
    met: bool = False


@dataclass(frozen=True)
class Swept:
    """Result of one piece of work."""

    series: tuple[StepSeries, ...] = ()
    choices: tuple[Choice, ...] = ()


def trials_of(series: Iterable[StepSeries]) -> Iterator[Trial]:
    """Yield all runs over steps."""
    for one in series:
        if one.axis == "step":
            yield from (Trial(one, point) for point in one.points)


def pareto(rows: Iterable[Trial]) -> list[Trial]:
    """Return the runs that none beats in both error and time, cheapest first."""
    front: list[Trial] = []
    for row in sorted(rows, key=lambda row: (row.seconds, row.error)):
        if row.error < min([1.0, *(other.error for other in front)]) and row.seconds < inf:
            front.append(row)
    return front


def steady(series: Iterable[StepSeries], target: float, share: float = 1.0) -> Iterator[Trial]:
    """Yield the runs that meet a share of a target, as all with shorter steps meet the target.

    An error may be small by chance. Steps above the largest stable one are not among them.
    """
    for one in series:
        for point in reversed(one.points):
            if point.error is None or point.error > target:
                break
            stable = one.stable_step is None or (point.step or inf) <= STABLE * one.stable_step
            if point.error <= share * target and stable:
                yield Trial(one, point)


STABLE = 1.02
"""A step above this many times the largest stable one is unstable."""


def cheapest(
    rows: Iterable[Trial],
    price: Callable[[Trial], float],
    preference: Callable[[Trial], object],
    noise: float = 1.0,
) -> Trial | None:
    """Return the preferred row of those whose price is the least, but for a factor of noise."""
    good = list(rows)
    least = min(map(price, good), default=0.0)
    alike = [row for row in good if price(row) <= noise * least]
    return min(alike, key=preference, default=None)  # type: ignore[arg-type]


def slope_of(points: Sequence[Point]) -> float | None:
    """Return the slope of errors over steps, or over counts; None of fewer than two points."""
    if len(points) < 2:
        return None
    steps = np.log([point.step or 1 / (point.value or np.nan) for point in points])
    return float(np.polyfit(steps, np.log([point.error or np.nan for point in points]), 1)[0])


def settings_text(settings: Mapping[str, float]) -> str:
    """Return settings in words."""
    return ", ".join(f"{name} {value:g}" for name, value in settings.items())


def percent(value: float | None) -> str:
    """Return a relative error in per cent."""
    return "state lost" if value is None or not value < inf else f"{100 * value:.2g} %"
