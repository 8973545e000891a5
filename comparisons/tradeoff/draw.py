"""Pictures of the trade-off: error over cost."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..reports.drawing import INK, PALETTE, label, look, new_figure
from .model import ModelTradeoff, setting_of
from .pages import LIMITS
from .report import Tradeoff
from .table import Point, StepSeries, Trial, pareto, percent, trials_of

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "h", "p", "d")
"""Markers of methods, in order."""

LINES: tuple[Any, ...] = ("solid", (0, (5, 1.5)), (0, (1.5, 1)), (0, (6, 1, 1, 1)))
"""Line styles of an engine's models, in order."""

LEGEND = {"loc": "outside lower center", "ncols": 3, "fontsize": 7, "frameon": False}

USELESS, TOP = 2.0, 8.0
"""Relative errors above the first count as failures, and are drawn at the second."""

APART = 0.03
"""Least distance between names of plateaus, as a share of the height of a panel."""

Measure = Callable[[Point], float | None]
"""Function from a point to its cost per simulated second."""


def seconds(point: Point) -> float | None:
    """Return the wall time [s/s]."""
    return point.cost.seconds if point.cost else None


def steps(point: Point) -> float | None:
    """Return the steps per simulated second, for a failed run, too."""
    return point.cost.steps if point.cost else 1 / point.step


def pictures(result: Tradeoff | ModelTradeoff, path: Path) -> Iterator[tuple[str, Path, Any]]:
    """Yield figures, each with the title of its section on a page, and its path."""
    if isinstance(result, ModelTradeoff):
        if result.trials:
            yield "", path, figure_of_model(result)
        return
    scenes = [scene for scene in result.scenes if result.of(scene)]
    for scene in scenes:
        name = path if len(scenes) == 1 else path.with_stem(f"{path.stem}_{scene}")
        front = [trial.point for trial in pareto(trials_of(result.of(scene)))]
        yield LIMITS, name, figure_work_precision(result.of(scene), front)


def figure_of_model(result: ModelTradeoff) -> Any:
    """Draw the runs of a file, with the target, the recommended setting and that of the file."""
    front = [trial.point for trial in result.front]
    marks = {"recommended": (result.choice, "D"), "as in the file": (result.own, "s")}
    known = {
        f"{words}: {setting_of(trial).name}": (trial, marker)
        for words, (trial, marker) in marks.items()
        if trial is not None and trial.point.error
    }
    title = f"{result.series[0].scene}: error over {result.compared:.3g} s against converged runs"
    return figure_work_precision(result.series, front, title, known, result.request.target)


def figure_work_precision(
    series: Sequence[StepSeries],
    front: Sequence[Point] = (),
    title: str = "",
    marks: Mapping[str, tuple[Trial, str]] | None = None,
    target: float | None = None,
) -> Any:
    """Draw the error of series of one scene or file over their cost.

    The upper panel is over time, the lower one over steps, both per simulated second. Crosses at
    the top are runs that failed or have an error above `USELESS`; runs on the front have rings.
    Series with other settings are thin lines.

    Parameters
    ----------
    series : sequence of StepSeries, all of one scene
    front : sequence of Point
        Points on the front over time.
    title : str
        Title, by default the scene and the case.
    marks : mapping of str to (Trial, str)
        Runs with a label and a special marker.
    target : float, optional
        Relative error, drawn as a line.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, panels = new_figure(2, 1, height=3.5)
    for axes, measure in zip(panels[:, 0], (seconds, steps), strict=True):
        axes.set_xscale("log")
        axes.set_yscale("log")
        for one, style in zip(series, styles_of(series), strict=True):
            draw_series(axes, one, measure, style)
        for words, (trial, marker) in (marks or {}).items():
            axes.plot(measure(trial.point), trial.error, marker, color=INK, label=words, zorder=5)
        low, _ = axes.get_ylim()
        axes.set_ylim(low, 3 * TOP)
        mark_plateaus(axes, series)
        if target is not None:
            axes.axhline(target, color=INK, linewidth=0.8, linestyle=(0, (4, 2)))
            axes.annotate(
                f"target {percent(target)}", (1, target), (-2, 3), ha="right", fontsize=8,
                xycoords=axes.get_yaxis_transform(), textcoords="offset points", color=INK,
            )  # fmt: skip
    above, below = panels[:, 0]
    at = sorted((seconds(p) or np.nan, p.error or np.nan) for p in front)
    rings = {"marker": "o", "markersize": 9, "markerfacecolor": "none", "color": "#000000"}
    above.plot(*np.reshape(at, (-1, 2)).T, linestyle="none", label="front", **rings)
    title = title or f"{series[0].scene}: {series[0].case}"
    label(above, "time per simulated second [s/s]", "largest relative error", title)
    label(below, "steps per simulated second [1/s]", "largest relative error")
    figure.legend(*above.get_legend_handles_labels(), **LEGEND)
    return figure


def styles_of(series: Sequence[StepSeries]) -> list[dict[str, Any]]:
    """Return the style of each series.

    Colours stand for engines, or for methods if there is one engine; markers for methods, lines
    for models.
    """
    methods = list(dict.fromkeys(one.method for one in series))
    models: dict[str, list[str]] = {}
    for one in series:
        models.setdefault(one.engine, []).append(one.model)
    styles = []
    for one in series:
        engine, place = look(one.engine), methods.index(one.method)
        colour = engine.colour if len(models) > 1 else PALETTE[place % len(PALETTE)]
        line = list(dict.fromkeys(models[one.engine])).index(one.model)
        styles.append(
            {
                "color": colour,
                "linestyle": LINES[line % len(LINES)],
                "marker": MARKERS[place % len(MARKERS)],
                "markerfacecolor": colour if engine.filled else "white",
            }
        )
    return styles


def draw_series(axes: Any, one: StepSeries, measure: Measure, style: Mapping[str, Any]) -> None:
    """Draw the points of a series and the line through those that ran."""
    ran = [(measure(p), p.error) for p in one.points if useful(p) and measure(p)]
    if ran and one.settings:
        axes.plot(*zip(*ran, strict=True), **{**style, "marker": ""}, linewidth=0.6)
    elif ran:
        words = " ".join(filter(None, [one.engine, one.setting]))
        axes.plot(*zip(*ran, strict=True), **style, linewidth=1.1, markersize=5.0, label=words)
    failed = [measure(p) for p in one.points if not useful(p) and measure(p)]
    axes.plot(failed, [TOP] * len(failed), "x", color=style["color"], markersize=4, zorder=3)


def useful(point: Point) -> bool:
    """Return True if a run reached its end with a useful error."""
    return point.error is not None and 0 < point.error <= USELESS


def mark_plateaus(axes: Any, series: Sequence[StepSeries]) -> None:
    """Draw a line at each plateau, and its name at the right edge."""
    low, high = np.log(axes.get_ylim())
    written = -np.inf
    for one in sorted(series, key=lambda item: item.plateau or 0.0):
        if not one.plateau:
            continue
        colour = look(one.engine).colour
        axes.axhline(one.plateau, color=colour, linewidth=0.5, linestyle=(0, (2, 3)), zorder=1)
        place = (np.log(one.plateau) - low) / (high - low)
        if place > written + APART:
            values = ", ".join(f"{value:g}" for value in one.settings.values())
            axes.annotate(
                f"{one.plateau_name} {values}".strip(), (1.0, one.plateau), (3, 0), color=colour,
                xycoords=("axes fraction", "data"), textcoords="offset points", fontsize=6.5,
                va="center", annotation_clip=False,
            )  # fmt: skip
            written = place
