"""Pictures of the trade-off: error over cost, and what a step costs in stability."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..reports.drawing import FAINT, INK, PALETTE, EngineLook, label, look, named, new_figure
from .model import ModelTradeoff, setting_of
from .pages import LIMITS, SHIFTS
from .report import Tradeoff
from .stability import AXIS
from .sweep import SMALL
from .table import STEP, Point, StepSeries, Trial, pareto, percent, trials_of

METHOD_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "h", "p", "d")

LINES: tuple[Any, ...] = ("solid", (0, (5, 1.5)), (0, (1.5, 1)), (0, (6, 1, 1, 1)))
"""Of an engine's models, in order."""

FRONT = "#000000"

USELESS, TOP = 2.0, 8.0
"""Relative errors above the first are as good as a failure, and stand at the second."""

Measure = Callable[[Point], float | None]
"""What of a point is its cost, per simulated second."""


def seconds(point: Point) -> float | None:
    """Return the wall time [s/s]."""
    return point.cost.seconds if point.cost else None


def steps(point: Point) -> float | None:
    """Return the steps per simulated second: known of a failed run, too."""
    return point.cost.steps if point.cost else 1 / point.step


def pictures(result: Tradeoff | ModelTradeoff, path: Path) -> Iterator[tuple[str, Path, Any]]:
    """Yield figures, each with the title of a page under which it belongs, and its path."""
    if isinstance(result, ModelTradeoff):
        if result.trials:
            yield "", path, figure_of_model(result)
        return
    for scene in result.scenes:
        name = path if len(result.scenes) == 1 else path.with_stem(f"{path.stem}_{scene}")
        if series := result.of(scene):
            front = [trial.point for trial in pareto(trials_of(series))]
            yield LIMITS, name, figure_work_precision(series, front)
        if shifts := result.of(scene, AXIS):
            yield SHIFTS, name.with_stem(f"{name.stem}_stability"), figure_stability(shifts)


def figure_of_model(result: ModelTradeoff) -> Any:
    """Draw the runs of a file, with the target, the recommended setting and the file's own."""
    front = [trial.point for trial in result.front]
    marks = {"recommended": (result.choice, "D"), "as in the file": (result.own, "s")}
    known = {
        f"{words}: {setting_of(trial).name}": (trial, marker)
        for words, (trial, marker) in marks.items()
        if trial is not None and trial.point.error
    }
    title = f"{result.series[0].scene}: error over {result.compared:.3g} s against converged runs"
    return figure_work_precision(result.series, front, title, known, result.asked.target)


def figure_work_precision(
    series: Sequence[StepSeries],
    front: Sequence[Point] = (),
    title: str = "",
    marks: Mapping[str, tuple[Trial, str]] | None = None,
    target: float | None = None,
) -> Any:
    """Draw the error of series of one scene or file over their cost.

    Above over time, below over steps, both per simulated second. Colour and face tell the engine,
    or of one engine the method; the marker tells the method, the line the model. Small hollow
    points are wasted, crosses at the top failed or have an error above `USELESS`, and what is on
    the front is ringed and joined. Series with other settings are thin lines.

    Parameters
    ----------
    series : sequence of StepSeries, all of one scene
    front : sequence of Point
        Over time, that none of these series' points beats.
    title : str
        By default the scene and the case.
    marks : mapping of str to (Trial, str)
        Runs that have a label and a marker of their own.
    target : float, optional
        Drawn as a line.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, panels = new_figure(2, 1, height=3.5)
    markers, lines, looks = marker_of(series), line_of(series), looks_of(series)
    for axes, measure in zip(panels[:, 0], (seconds, steps), strict=True):
        axes.set_xscale("log")
        axes.set_yscale("log")
        for one in series:
            how = looks[one.method], markers[one.method], lines[one.engine, one.model]
            draw_series(axes, one, measure, *how)
        for words, (trial, marker) in (marks or {}).items():
            axes.plot(measure(trial.point), trial.error, marker, color=INK, label=words, zorder=5)
        low, _ = axes.get_ylim()
        axes.set_ylim(low, 3 * TOP)
    guides(panels[1, 0], series)
    for axes in panels[:, 0]:
        mark_plateaus(axes, series)
        if target is not None:
            axes.axhline(target, color=INK, linewidth=0.8, linestyle=(0, (4, 2)))
            axes.annotate(
                f"target {percent(target)}", (1, target), (-2, 3), ha="right", fontsize=8,
                xycoords=axes.get_yaxis_transform(), textcoords="offset points", color=INK,
            )  # fmt: skip
    draw_front(panels[0, 0], front)
    title = title or f"{series[0].scene}: {series[0].case}"
    label(panels[0, 0], "time per simulated second [s/s]", "largest relative error", title)
    label(panels[1, 0], "steps per simulated second [1/s]", "largest relative error")
    legend(figure, series, (markers, lines, looks), bool(front))
    return figure


def marker_of(series: Sequence[StepSeries]) -> dict[str, str]:
    """Return a marker for each method."""
    names = dict.fromkeys(one.method for one in series)
    return {name: METHOD_MARKERS[i % len(METHOD_MARKERS)] for i, name in enumerate(names)}


def looks_of(series: Sequence[StepSeries]) -> dict[str, EngineLook]:
    """Return the look of each method: that of its engine, or a colour of its own of one engine."""
    methods = {one.method: look(one.engine) for one in reversed(series)}
    if len({one.engine for one in series}) > 1:
        return methods
    return {
        name: replace(one, colour=PALETTE[i % len(PALETTE)])
        for i, (name, one) in enumerate(methods.items())
    }


def line_of(series: Sequence[StepSeries]) -> dict[tuple[str, str], Any]:
    """Return a line for each model of each engine."""
    lines: dict[tuple[str, str], Any] = {}
    for one in series:
        if (one.engine, one.model) not in lines:
            count = sum(engine == one.engine for engine, _ in lines)
            lines[one.engine, one.model] = LINES[count % len(LINES)]
    return lines


def draw_series(
    axes: Any, one: StepSeries, measure: Measure, its: EngineLook, marker: str, line: Any
) -> None:
    """Draw the points of a series and the line through those that ran."""
    colour, face = its.colour, its.face
    ran = [(measure(p), p.error, p.wasted) for p in one.points if useful(p) and measure(p)]
    if ran:
        x, y, wasted = (np.array(column) for column in zip(*ran, strict=True))
        thin = 0.6 if one.settings else 1.1
        axes.plot(x, y, color=colour, linestyle=line, linewidth=thin, alpha=0.8, zorder=2)
        if one.settings:
            return
        how = {"linestyle": "none", "marker": marker, "markeredgecolor": colour, "zorder": 3}
        axes.plot(x[~wasted], y[~wasted], markersize=5.0, markerfacecolor=face, **how)
        axes.plot(x[wasted], y[wasted], markersize=2.6, markerfacecolor="white", alpha=0.6, **how)
    failed = [measure(p) for p in one.points if not useful(p) and measure(p)]
    axes.plot(failed, [TOP] * len(failed), "x", color=colour, markersize=4, zorder=3)


def useful(point: Point) -> bool:
    """Return whether a run came to its end with an error that means something."""
    return point.error is not None and 0 < point.error <= USELESS


APART = 0.03
"""Of the height of a panel: names of plateaus are not nearer to each other."""


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
                f"{one.plateau_name} {values}".strip(),
                (1.0, one.plateau),
                xycoords=("axes fraction", "data"),
                xytext=(3, 0),
                textcoords="offset points",
                fontsize=6.5,
                va="center",
                color=colour,
                annotation_clip=False,
            )
            written = place


def draw_front(axes: Any, front: Sequence[Point]) -> None:
    """Ring the points of the front and join them."""
    at = sorted((seconds(p) or np.nan, p.error or np.nan) for p in front)
    if at:
        x, y = zip(*at, strict=True)
        axes.step(x, y, where="post", color=FRONT, linewidth=2.4, alpha=0.25, zorder=1)
        axes.plot(x, y, "o", markersize=9, markerfacecolor="none", markeredgecolor=FRONT, zorder=4)


def guides(axes: Any, series: Sequence[StepSeries]) -> None:
    """Draw thin slopes of the declared orders, left of the best series of each."""
    limits = axes.get_xlim(), axes.get_ylim()
    for order in sorted({one.order for one in series} - {0}):
        slopes = [
            [
                (1 / p.step, p.error)
                for p in one.points
                if p.step and p.error and p.label == STEP and p.error < SMALL and not p.wasted
            ]
            for one in series
            if one.order == order and not one.settings
        ]
        points = min(
            (points for points in slopes if len(points) > 1),
            key=lambda points: points[0][1] * points[0][0] ** order,
            default=None,
        )
        if points is None:
            continue
        x, y = min(points, key=lambda at: at[1] * at[0] ** order)
        ends = np.array([points[0][1], points[-1][1]])
        run = x * (y / ends) ** (1 / order) / AWAY
        axes.plot(run, ends, color=FAINT, linewidth=0.8, zorder=0)
        axes.annotate(
            f"{order}",
            (run[1], ends[1]),
            fontsize=6.5,
            color=INK,
            ha="center",
            va="center",
            bbox={"boxstyle": "circle,pad=0.15", "facecolor": "white", "edgecolor": FAINT},
            zorder=4,
        )
    axes.set_xlim(limits[0][0] / AWAY, limits[0][1])
    axes.set_ylim(limits[1])


AWAY = 1.5
"""Factor in steps between a guide and its series."""


def legend(
    figure: Any, series: Sequence[StepSeries], styles: tuple[Any, Any, Any], front: bool
) -> None:
    """Name engines with their models, methods, and what marks mean, below the panels."""
    from matplotlib.lines import Line2D

    markers, lines, looks = styles
    models = [
        Line2D(
            [], [], color=look(engine).colour, linestyle=line, linewidth=1.6,
            label=f"{engine} {model}",
        )
        for (engine, model), line in lines.items()
    ]  # fmt: skip
    methods = [
        Line2D(
            [], [], linestyle="none", marker=marker, color=looks[name].colour,
            markerfacecolor=looks[name].face, markersize=5, label=name,
        )
        for name, marker in markers.items()
    ]  # fmt: skip
    other = [
        Line2D([], [], linestyle="none", marker="o", color=INK, markerfacecolor="white",
               markersize=2.6, label="wasted"),
        Line2D([], [], linestyle="none", marker="x", color=INK, markersize=4, label="failed"),
        Line2D([], [], color=FAINT, linewidth=0.8, label="slope of an order"),
        Line2D([], [], color=INK, linewidth=0.6, label="other settings"),
    ]  # fmt: skip
    if front:
        other.append(
            Line2D([], [], color="#BBBBBB", linewidth=2.4, marker="o", markersize=8,
                   markerfacecolor="none", markeredgecolor=FRONT, label="Pareto front")
        )  # fmt: skip
    marked = figure.axes[0].get_legend_handles_labels()[0]
    figure.legend(
        handles=[*marked, *models, *methods, *other],
        loc="outside lower center",
        ncols=4,
        fontsize=7,
        frameon=False,
    )


# Stability ----------------------------------------------------------------------------------


def figure_stability(shifts: Sequence[StepSeries]) -> Any:
    """Draw by how much methods shift one boundary point, over steps in a period.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = new_figure(height=3.6)
    panel, markers, first = axes[0, 0], marker_of(shifts), shifts[0]
    counts = [point.value for point in first.points]
    for one in shifts:
        its = look(one.engine)
        sizes = np.array([point.error for point in one.points], dtype=float)
        panel.loglog(
            counts, sizes, color=its.colour, linestyle=its.line, linewidth=1.0,
            marker=markers[one.method], markersize=4.5, markerfacecolor=its.face,
            label=f"{one.engine} {one.method}",
        )  # fmt: skip
    bounds = np.array([[point.bound for point in one.points] for one in shifts], dtype=float)
    panel.loglog(
        counts, np.fmax.reduce(bounds), color=FAINT, linewidth=3, label="round-off, differences"
    )
    panel.set_xticks(counts, [str(count) for count in counts])
    panel.minorticks_off()
    words = f"shift of {named(first.quantity, first.unit)}"
    label(panel, "steps in a period", words, f"{first.scene}: {first.case}")
    figure.legend(loc="outside lower center", ncols=4, fontsize=7, frameon=False)
    return figure
