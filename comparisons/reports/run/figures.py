"""Pictures of results: what deviates beside what it should be, and error over work."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator, Sequence
from io import BytesIO
from typing import Any, NamedTuple

import numpy as np

from ....reference.scene import Array
from ...checks.verdict import Result, Series
from ..drawing import FAINT, INK, PALETTE, broad, engine_line, import_pyplot, label, new_figure
from ..words import number, printable
from .results import grouped, method_of

SETTINGS = {"svg.hashsalt": "mbcheck", "svg.fonttype": "path"}
"""The same picture of the same numbers each time."""

PIXELS = 96
"""Per inch, in a browser."""

LINES = ("solid", (0, (4, 1.5)), (0, (1, 1.2)), (0, (4, 1.5, 1, 1.5)))
MARKS = "os^Dv<>PX"


class Figure(NamedTuple):
    """A picture as a page holds it: ``uri`` is all of it; sizes in pixels."""

    uri: str
    alt: str
    caption: str
    width: int
    height: int


def plain(text: str) -> str:
    """Return text that matplotlib shows as it is, and does not take for mathematics."""
    return printable(text).replace("$", r"\$")


def finished(figure: Any, alt: str, caption: str) -> Figure:
    """Return a figure as a data URI, and forget it."""
    plt = import_pyplot()
    buffer = BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    width, height = (round(PIXELS * float(inches)) for inches in figure.get_size_inches())
    plt.close(figure)
    data = b64encode(buffer.getvalue()).decode("ascii")
    return Figure(f"data:image/svg+xml;base64,{data}", alt, caption, width, height)


def logarithmic(axes: Any, x: Array | None = None, y: Array | None = None) -> None:
    """Make axes logarithmic, as far as what is drawn on them (n,) has logarithms."""
    for values, scale in ((x, axes.set_xscale), (y, axes.set_yscale)):
        if values is not None and np.any(np.isfinite(values) & (values > 0)):
            scale("log")


def deviation(result: Result) -> Figure:
    """Draw a result that has a series: over time, or its error over the step."""
    assert result.series is not None
    with import_pyplot().rc_context(SETTINGS):
        if result.series.over == "time":
            return over_time(result, result.series)
        return over_step(result, result.series)


def over_time(result: Result, series: Series) -> Figure:
    """Draw values and reference, and below them the difference with its tolerance."""
    figure, axes = new_figure(rows=2, height=1.9, sharex=True)
    upper, lower = axes[:, 0]
    name = plain(result.quantity)
    unit = "" if result.unit == "1" else f" [{plain(result.unit)}]"
    broad(upper, series.x, series.reference, label="reference")
    engine_line(upper, plain(result.engine), series.x, series.value)
    label(upper, y=f"{name}{unit}")
    upper.legend(fontsize=8, frameon=False)
    away = np.abs(series.value - series.reference)
    seen = np.where(np.isfinite(away) & (away > 0), away, np.nan)
    engine_line(lower, plain(result.engine), series.x, seen, label="|difference|")
    if result.tolerance:
        lower.axhline(result.tolerance, color=INK, linewidth=0.8, label="tolerance")
        lower.axhspan(0, result.tolerance, color=FAINT, alpha=0.35, linewidth=0)
    logarithmic(lower, y=seen)
    label(lower, x="t [s]", y=f"|difference|{unit}")
    lower.legend(fontsize=8, frameon=False)
    return finished(
        figure,
        f"{result.quantity} of {result.engine} over time beside the reference, and their "
        f"difference: up to {number(result.error)}, tolerance {number(result.tolerance)}",
        f"{result.quantity}: above, {result.engine} and the reference; below, their difference "
        "(logarithmic) and its tolerance.",
    )


def over_step(result: Result, series: Series) -> Figure:
    """Draw errors over steps, and how they should shrink."""
    figure, axes = new_figure(height=2.8)
    panel = axes[0, 0]
    broad(panel, series.x, series.reference, label="as the order declares")
    engine_line(panel, plain(result.engine), series.x, series.value, markevery=1)
    logarithmic(panel, series.x, series.value)
    label(panel, x="step [s]", y="relative error")
    panel.legend(fontsize=8, frameon=False)
    slope = f"finest slope {number(result.value)}, expected {number(result.reference)}"
    return finished(
        figure,
        f"Error of {method_of(result)} of {result.engine} over the step: {slope}",
        f"Error of {result.engine} {method_of(result)} over the step: {slope}.",
    )


def work_precision(results: Sequence[Result]) -> Iterator[Figure]:
    """Yield error over steps and over time of a scene's methods, where *order* measured them."""
    measured = [r for r in results if r.kind == "order" and r.series and r.series.over == "step"]
    by_case = grouped(measured, lambda r: (r.case,))
    if not by_case:
        return
    (case,), members = max(by_case.items(), key=lambda item: len(item[1]))
    engines = grouped(members, lambda r: (r.engine,))
    with import_pyplot().rc_context(SETTINGS):
        figure, axes = new_figure(len(engines), 2, 2.7, sharey="row", sharex="col")
        for row, ((engine,), of_engine) in zip(axes, engines.items(), strict=True):
            for i, result in enumerate(of_engine):
                draw_method(row, i, result)
            for panel in row:
                drawn = [line.get_xydata().T for line in panel.lines if len(line.get_xdata())]
                logarithmic(panel, *np.concatenate(drawn, axis=1) if drawn else ())
            label(row[0], y="relative error", title=plain(engine))
            row[1].legend(fontsize=7, frameon=False, loc="upper left", bbox_to_anchor=(1, 1))
        axes[-1, 0].invert_xaxis()
        axes[-1, 0].set_xlabel("step [s]", fontsize=8)
        axes[-1, 1].set_xlabel("wall time of the run [s]", fontsize=8)
        yield finished(
            figure,
            f"Error over step and over wall time, {case}, of {len(members)} methods",
            f"Work and precision in {case}, from the runs of the order checks: largest relative "
            "error of any observable. Times are of single short runs beside other work: read "
            "factors of ten from them, not per cents (mbcheck tradeoff measures them).",
        )


def draw_method(row: Any, i: int, result: Result) -> None:
    """Draw the errors of the i-th method over step and time."""
    assert result.series is not None
    style = {
        "color": PALETTE[i % len(PALETTE)],
        "linestyle": LINES[i // len(PALETTE) % len(LINES)],
        "marker": MARKS[i % len(MARKS)],
        "markersize": 3,
        "linewidth": 1,
        "label": plain(method_of(result)),
    }
    row[0].plot(result.series.x, result.series.value, **style)
    if result.series.seconds is not None and np.all(result.series.seconds > 0):
        times: Array = result.series.seconds
        row[1].plot(times, result.series.value, **style)
    else:
        row[1].plot([], [], **style)
