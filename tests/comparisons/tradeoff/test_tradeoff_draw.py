"""Pictures of the trade-off draw what they are given."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from mbcheck.comparisons.reports import drawing
from mbcheck.comparisons.tradeoff import draw
from mbcheck.comparisons.tradeoff.table import FAILED, MODEL, STEP, Cost, Point, StepSeries


def series(engine: str, method: str, order: int, floor: float = 0.0) -> StepSeries:
    """Return a method whose first run fails, whose second is useless and that meets a floor."""
    points = [Point(2.0**-3, None, label=FAILED, reason="non_finite"), Point(
        2.0**-4, 1e30, cost=Cost(1e-4, 1e-4, 1e-4, 16, 64, None), label=STEP, limit="step"
    )]  # fmt: skip
    for k in range(5, 14):
        own = 40.0 * 2.0 ** (-order * (k - 3)) / 40
        limited = own < floor
        cost = Cost(1e-5 * 2**k, 9e-6 * 2**k, 2e-5 * 2**k, 2.0**k, 4 * 2.0**k, None)
        points.append(
            Point(
                2.0**-k, own + floor, cost=cost, label=MODEL if limited else STEP,
                limit="closure softness" if limited else "step", wasted=limited,
            )
        )  # fmt: skip
    plateau = floor or None
    return StepSeries(
        "speed_regulator", "rotation", engine, "connect", method, order, {}, tuple(points),
        float(order), plateau, "closure softness" if floor else "",
    )  # fmt: skip


SERIES = (
    series("mujoco", "Euler", 1),
    series("mujoco", "RK4", 4, 1e-6),
    series("exudyn", "GeneralizedAlpha", 2),
)


def texts(figure: Any) -> str:
    """Return all that is written in a figure."""
    from matplotlib.text import Text

    return "\n".join(item.get_text() for item in figure.findobj(Text))


def test_work_precision_shows_what_it_should(tmp_path: Path) -> None:
    """Failures at the top, plateaus by name, wasted points hollow, orders, the front."""
    figure = draw.figure_work_precision(SERIES, [SERIES[1].points[i] for i in (3, 5)])
    path = tmp_path / "one.png"
    drawing.save(figure, path)
    assert path.stat().st_size > 10_000
    written = texts(figure)
    for name in ("mujoco connect", "GeneralizedAlpha", "closure softness", "wasted", "failed",
                 "Pareto front", "speed_regulator: rotation"):  # fmt: skip
        assert name in written
    above, below = figure.axes
    crosses = [line for line in below.lines if line.get_marker() == "x"]
    assert [len(line.get_xdata()) for line in crosses] == [2, 2, 2]
    shown = np.concatenate([line.get_ydata() for line in above.lines if len(line.get_ydata())])
    assert np.max(shown.astype(float)) <= draw.TOP < above.get_ylim()[1]
    rings = [line for line in above.lines if line.get_markersize() == 9]
    assert len(rings) == 1
    assert len(rings[0].get_xdata()) == 2


def test_guides_have_the_declared_slopes() -> None:
    """A guide falls by its order; series that do not look steeper than it do not fool a reader."""
    _, below = draw.figure_work_precision(SERIES).axes
    guides = [line for line in below.lines if line.get_color() == drawing.FAINT]
    slopes = []
    for line in guides:
        x, y = (np.log(np.asarray(data, dtype=float)) for data in line.get_data())
        slopes.append(-(y[1] - y[0]) / (x[1] - x[0]))
    assert sorted(slopes) == pytest.approx([1, 2, 4])


def test_a_series_that_only_failed_can_be_drawn() -> None:
    """Nothing ran: there are crosses and no more."""
    failed = StepSeries(
        "hula_hoop", "a", "exudyn", "m", "RK44", 4, {}, (Point(0.1, None, label=FAILED),)
    )
    figure = draw.figure_work_precision([failed])
    assert "RK44" in texts(figure)
