"""Which setting to take: the Pareto front, and the cheapest one for a target error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from .series import MODEL, ROUND_OFF, Cost, Point, Series
from .sweep import settings_text

NOISE = 1.2
"""Median times that differ by no more than this factor cost about the same."""


@dataclass(frozen=True)
class Choice:
    """The cheapest setting of an engine that meets a target, or why there is none.

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
        [s]
    error : float or None
        Measured; the least that was, where none meets the target.
    cost : Cost or None
    limit : str
        What limits the error there.
    margin : float or None
        Longest stable step by theory over the step; None where no step is unstable, or no
        theory is known.
    longest : float or None
        Longest step of the sweep that this method survived with an error below 1, over the step.
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

    @property
    def met(self) -> bool:
        """Whether the target is met."""
        return self.method is not None


def pareto(series: Sequence[Series]) -> list[tuple[Series, Point]]:
    """Return the points that none beats in both error and wall time, cheapest first."""
    candidates = [
        (point.cost.seconds, point.error, one, point)
        for one in series
        for point in one.points
        if point.cost is not None and point.error is not None and point.error < 1
    ]
    front: list[tuple[Series, Point]] = []
    least = float("inf")
    for _, error, one, point in sorted(candidates, key=lambda item: item[:2]):
        if error < least:
            front.append((one, point))
            least = error
    return front


def choose(series: Sequence[Series], target: float) -> list[Choice]:
    """Return a choice for each scene and engine of the series."""
    pairs = dict.fromkeys((one.scene, one.case, one.engine) for one in series)
    return [choose_one(*pair, series=series, target=target) for pair in pairs]


def choose_one(
    scene: str, case: str, engine: str, series: Sequence[Series], target: float
) -> Choice:
    """Return the cheapest setting of one engine for a scene.

    Of settings that cost about the same, the one with the fewest options set, then the most
    accurate: noise of a clock is no reason to prefer one.
    """
    none = partial(Choice, scene, case, engine, target)
    mine = [
        Candidate(one, point, point.error, point.cost, steady(one.points[place:], target))
        for one in series
        if (one.scene, one.engine) == (scene, engine)
        for place, point in enumerate(one.points)
        if point.error is not None and point.cost is not None
    ]
    if not mine:
        return none(limit="no run came to an end")
    good = [item for item in mine if item.steady]
    if not good:
        best = min(mine, key=lambda item: item.error)
        words = [best.series.model, best.series.method, settings_text(best.series.settings)]
        return none(error=best.error, limit=f"{best.point.limit} of {' '.join(words).strip()}")
    cheapest = min(good, key=lambda item: item.cost.seconds)
    alike = [item for item in good if item.cost.seconds <= NOISE * cheapest.cost.seconds]
    one, point, *_ = min(alike, key=lambda item: (len(item.series.settings), item.error))
    survived = max(item.step for item in one.points if item.error is not None and item.error < 1)
    return none(
        model=one.model,
        method=one.method,
        settings=one.settings,
        step=point.step,
        error=point.error,
        cost=point.cost,
        limit=point.limit,
        margin=None if one.stable_step is None else one.stable_step / point.step,
        longest=survived / point.step,
    )


class Candidate(NamedTuple):
    """A setting that may be chosen."""

    series: Series
    point: Point
    error: float
    cost: Cost
    steady: bool
    """Whether it meets the target, not by chance"""


def steady(points: Sequence[Point], target: float) -> bool:
    """Return whether the first of some points meets a target, and the next, with half the step.

    The last one has no next: it has to be at its floor.
    """
    if len(points) == 1 and points[0].label not in (MODEL, ROUND_OFF):
        return False
    return all(point.error is not None and point.error <= target for point in points[:2])
