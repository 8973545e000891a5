"""Maps as pictures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...reference.scene import Array
from ..reports.boundaries import draw_curves
from ..reports.drawing import (
    FAINT,
    INK,
    PALE,
    PALETTE,
    class_map,
    finish,
    label,
    named,
    new_figure,
)
from .compare import MapComparison, called
from .store import Map, units

Grid = tuple[Array, Array]


def axis_label(result: Map, name: str) -> str:
    """Return the label of an axis, with its unit."""
    return named(name, units(result.settings["scene"], name))


def number_map(
    axes: Any, grid: Grid, values: Array, unit: str, words: str = "", **how: Any
) -> None:
    """Draw numbers (n_y, n_x) as cells of colour, angles in colours that close a circle.

    ``grid`` are the values (n_x,) and (n_y,) on the axes.
    """
    style = {"cmap": "cividis", "shading": "nearest", "rasterized": True}
    if unit == "rad":
        style |= {"cmap": "twilight", "vmin": -np.pi, "vmax": np.pi}
    mesh = axes.pcolormesh(*grid, np.ma.masked_invalid(values), **(style | how))
    bar = axes.figure.colorbar(mesh, ax=axes)
    bar.set_label(words, size=8)
    bar.ax.tick_params(labelsize=8)


def draw_map(result: Map, path: Path, curves: Mapping[str, Any] | None = None) -> None:
    """Write a picture of a map, with the curves of a document of ``boundary``.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    figure, axes = new_figure(height=4.2)
    panel, settings = axes[0, 0], result.settings
    about, values = result.about[result.main_variable], result.variables[result.main_variable]
    grid = result.x.values, result.y.values
    handles = []
    if about.classes:
        robust = result.variables.get("robust")
        colours = PALETTE if curves is None else PALE
        handles = class_map(panel, grid, values, about.classes, colours, robust)
        if not np.all(result.robust):
            handles += panel.plot([], [], "w.", markeredgecolor=INK, label="not robust")
    else:
        number_map(panel, grid, values, about.unit, named(result.main_variable, about.unit))
    if np.any(values < 0 if about.classes else np.isnan(values)):
        handles.append(white_cell("no value"))
    if curves is not None:
        handles += draw_curves(panel, curves)
    title = f"{settings['scene']}: {settings['quantity']} by {called(settings)}"
    label(panel, axis_label(result, result.x.name), axis_label(result, result.y.name), title)
    finish(figure, handles, path)


def white_cell(words: str) -> Any:
    """Return the legend's handle of points that stay white."""
    from matplotlib.patches import Patch

    return Patch(facecolor="white", edgecolor=FAINT, label=words)


def draw_comparison(result: MapComparison, one: Map, path: Path) -> None:
    """Write a picture of two maps and of where they differ.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    figure, axes = new_figure(columns=3, height=2.8, sharey=True)
    *panels, last = axes[0]
    grid = result.x, result.y
    x_label = axis_label(one, one.x.name)
    handles: list[Any] = []
    both = np.array([result.one, result.other])
    for panel, values, name in zip(panels, both, result.maps, strict=True):
        if result.classes:
            handles = max(handles, class_map(panel, grid, values, result.classes), key=len)
        elif result.unit == "rad":
            number_map(panel, grid, values, result.unit)
        else:
            ends = {"vmin": np.nanmin(both), "vmax": np.nanmax(both)}
            number_map(panel, grid, values, result.unit, **ends)
        label(panel, x_label, title=name)
    panels[0].set_ylabel(axis_label(one, one.y.name), fontsize=8)
    if result.classes:
        level = np.where(result.compared, result.differs * (1 + result.robust), -1)
        names = ("agree", "differ, not robust", "differ")
        handles += class_map(last, grid, level, names, (FAINT, PALETTE[5], INK))
        title = f"{result.agreement or 0.0:.1%} of {result.points} points agree"
    else:
        off = np.full(result.one.shape, np.nan)
        off[result.compared] = np.abs(result.differences)
        number_map(last, grid, off, "1", cmap="magma_r")
        title = f"|difference| [{result.unit}]"
    if not np.all(result.compared):
        handles.append(white_cell("no value, or not computed in both"))
    label(last, x_label, title=title)
    finish(figure, handles, path)
