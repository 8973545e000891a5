"""Pictures of results: deviating values and the reference."""

from __future__ import annotations

from base64 import b64encode
from io import BytesIO
from typing import Any, NamedTuple

import numpy as np

from ....reference.scene import Array
from ...checks.verdict import Result, Series
from ..drawing import FAINT, INK, broad, engine_line, import_pyplot, label, new_figure
from ..words import number, printable
from .results import method_of

SETTINGS = {"svg.hashsalt": "mbcheck", "svg.fonttype": "path"}
"""The same picture of the same numbers each time."""

PIXELS = 96
"""Per inch, in a browser."""


class Figure(NamedTuple):
    """A picture as a page holds it: ``uri`` is all of it; sizes in pixels."""

    uri: str
    words: str
    width: int
    height: int


def plain(text: str) -> str:
    """Return text that matplotlib shows as it is, and does not take for mathematics."""
    return printable(text).replace("$", r"\$")


def logarithmic(axes: Any, x: Array | None = None, y: Array | None = None) -> None:
    """Make axes logarithmic if drawn values (n,) have logarithms."""
    for values, scale in ((x, axes.set_xscale), (y, axes.set_yscale)):
        if values is not None and np.any(np.isfinite(values) & (values > 0)):
            scale("log")


def deviation(result: Result) -> Figure:
    """Draw a result that has a series: over time, or its error over the step."""
    assert result.series is not None
    plt, buffer = import_pyplot(), BytesIO()
    with plt.rc_context(SETTINGS):
        draw = over_time if result.series.over == "time" else over_step
        figure, words = draw(result, result.series)
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    width, height = (round(PIXELS * float(inches)) for inches in figure.get_size_inches())
    plt.close(figure)
    data = b64encode(buffer.getvalue()).decode("ascii")
    return Figure(f"data:image/svg+xml;base64,{data}", words, width, height)


def over_time(result: Result, series: Series) -> tuple[Any, str]:
    """Draw values and reference, and below them the difference with its tolerance."""
    figure, axes = new_figure(rows=2, height=1.9, sharex=True)
    upper, lower = axes[:, 0]
    name, engine = plain(result.quantity), plain(result.engine)
    unit = "" if result.unit == "1" else f" [{plain(result.unit)}]"
    broad(upper, series.x, series.reference, label="reference")
    engine_line(upper, engine, series.x, series.value)
    label(upper, y=f"{name}{unit}")
    away = np.abs(series.value - series.reference)
    difference = np.where(np.isfinite(away) & (away > 0), away, np.nan)
    engine_line(lower, engine, series.x, difference, label="|difference|")
    if result.tolerance:
        lower.axhline(result.tolerance, color=INK, linewidth=0.8, label="tolerance")
        lower.axhspan(0, result.tolerance, color=FAINT, alpha=0.35, linewidth=0)
    logarithmic(lower, y=difference)
    label(lower, x="t [s]", y=f"|difference|{unit}")
    for panel in (upper, lower):
        panel.legend(fontsize=8, frameon=False)
    return figure, (
        f"{result.quantity} of {result.engine} over time and the reference; below, their "
        f"difference (logarithmic): up to {number(result.error)}, tolerance "
        f"{number(result.tolerance)}"
    )


def over_step(result: Result, series: Series) -> tuple[Any, str]:
    """Draw errors over steps, and the slope of the declared order."""
    figure, axes = new_figure(height=2.8)
    panel = axes[0, 0]
    broad(panel, series.x, series.reference, label="as the order declares")
    engine_line(panel, plain(result.engine), series.x, series.value, markevery=1)
    logarithmic(panel, series.x, series.value)
    label(panel, x="step [s]", y="relative error")
    panel.legend(fontsize=8, frameon=False)
    return figure, (
        f"Error of {result.engine} {method_of(result)} over the step: finest slope "
        f"{number(result.value)}, expected {number(result.reference)}"
    )
