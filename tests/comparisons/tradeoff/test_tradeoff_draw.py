"""Pictures of the trade-off draw what they are given."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from matplotlib.text import Text

from mbcheck.comparisons.tradeoff import draw
from mbcheck.comparisons.tradeoff.table import FAILED, STEP, Cost, Point, StepSeries


def series(engine: str, method: str, order: int, floor: float = 0.0) -> StepSeries:
    """Return a method whose first run fails, whose second is useless and that meets a floor."""
    points = [Point(2.0**-3, None, label=FAILED), Point(2.0**-4, 1e30, label=STEP)]
    for k in range(5, 14):
        cost = Cost(1e-5 * 2**k, 9e-6 * 2**k, 2e-5 * 2**k, 2.0**k)
        points.append(Point(2.0**-k, 2.0 ** (-order * (k - 3)) + floor, cost=cost))
    return StepSeries(
        "speed_regulator", "rotation", engine, "connect", method, order, {}, tuple(points),
        float(order), floor or None, "closure softness" if floor else "",
    )  # fmt: skip


def test_work_precision_shows_what_it_should() -> None:
    """Failures at the top, the plateau by its name, every method, the front."""
    every = [
        series("mujoco", "Euler", 1),
        series("mujoco", "RK4", 4, 1e-6),
        series("exudyn", "GeneralizedAlpha", 2),
    ]
    figure = draw.figure_work_precision(every, [every[1].points[i] for i in (3, 5)])
    above, below = figure.axes
    written = {item.get_text() for item in figure.findobj(Text)}
    names = ("mujoco connect Euler", "exudyn connect GeneralizedAlpha", "front")
    assert {*names, "closure softness", "speed_regulator: rotation"} <= written
    crosses = [line for line in below.lines if line.get_marker() == "x"]
    assert [len(line.get_xdata()) for line in crosses] == [2, 2, 2]
    shown = np.concatenate([line.get_ydata() for line in above.lines if len(line.get_ydata())])
    assert np.max(shown.astype(float)) <= draw.TOP < above.get_ylim()[1]
    (rings,) = (line for line in above.lines if line.get_label() == "front")
    assert {*rings.get_ydata()} == {every[1].points[i].error for i in (3, 5)}


def test_a_series_that_only_failed_can_be_drawn() -> None:
    failed = StepSeries(
        "hula_hoop", "a", "exudyn", "m", "RK44", 4, {}, (Point(0.1, None, label=FAILED),)
    )
    _, below = draw.figure_work_precision([failed]).axes
    assert [len(line.get_xdata()) for line in below.lines if line.get_marker() == "x"] == [1]
