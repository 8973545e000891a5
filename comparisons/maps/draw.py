"""Maps as pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ...reference.scene import Array
from ..reports.drawing import FAINT, INK, PALETTE, class_map, import_pyplot, label, new_figure, save
from .compare import Comparison, called
from .store import Map, units

Grid = tuple[Array, Array]


def axis_label(result: Map, name: str) -> str:
    """Return what an axis is called, with its unit."""
    return named(name, units(result.settings["scene"], name))


def named(name: str, unit: str) -> str:
    """Return a name with its unit."""
    return name.replace("_", " ") + ("" if unit == "1" else f" [{unit}]")


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


def draw(axes: Any, result: Map, name: str | None = None) -> list[Any]:
    """Draw a variable of a map; returns handles for a legend of its classes."""
    name = name or result.main_variable
    about, values = result.about[name], result.variables[name]
    grid = result.x.values, result.y.values
    if about.classes:
        robust = result.variables.get("robust")
        handles = class_map(axes, grid, values, about.classes, robust=robust)
    else:
        number_map(axes, grid, values, about.unit, named(name, about.unit))
        handles = []
    label(axes, axis_label(result, result.x.name), axis_label(result, result.y.name))
    return handles


def draw_map(result: Map, path: Path) -> None:
    """Write a picture of a map.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    figure, axes = new_figure(height=4.2)
    panel = axes[0, 0]
    handles = draw(panel, result)
    panel.set_title(
        f"{result.settings['scene']}: {result.settings['quantity']} by {called(result.settings)}",
        loc="left",
        fontsize=9,
    )
    legend(figure, handles, dotted=bool(handles) and not np.all(result.robust))
    finish(figure, path)


def draw_comparison(result: Comparison, one: Map, path: Path) -> None:
    """Write a picture of two maps and of where they differ.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    figure, axes = new_figure(columns=3, height=2.8, sharey=True)
    panels = axes[0]
    handles: list[Any] = []
    for panel, values, name in zip(panels, (result.one, result.other), result.names, strict=False):
        if result.classes:
            handles = max(
                handles, class_map(panel, (result.x, result.y), values, result.classes), key=len
            )
        else:
            both = np.array([result.one, result.other])
            ends = {"vmin": np.nanmin(both), "vmax": np.nanmax(both)}
            ends = {} if result.unit == "rad" else ends
            number_map(panel, (result.x, result.y), values, result.unit, **ends)
        label(panel, axis_label(one, one.x.name), title=name)
    panels[0].set_ylabel(axis_label(one, one.y.name), fontsize=8)
    last = panels[2]
    if result.classes:
        level = np.where(result.differs, np.where(result.robust, 2, 1), 0)
        level = np.where(result.compared, level, -1)
        names = ("agree", "differ, not robust", "differ")
        handles += class_map(last, (result.x, result.y), level, names, (FAINT, PALETTE[5], INK))
        title = f"{result.agreement():.1%} agree"
    else:
        off = np.full(result.one.shape, np.nan)
        off[result.compared] = np.abs(result.differences)
        number_map(last, (result.x, result.y), off, "1", cmap="magma_r")
        title = f"|difference| [{result.unit}]"
    label(last, axis_label(one, one.x.name), title=title)
    legend(figure, handles)
    finish(figure, path)


def legend(figure: Any, handles: list[Any], dotted: bool = False) -> None:
    """Put the legend of classes below a figure."""
    if dotted:
        from matplotlib.lines import Line2D

        dot = Line2D([], [], linestyle="none", marker=".", color="white", markeredgecolor=INK)
        dot.set_label("not robust")
        handles = [*handles, dot]
    if handles:
        figure.legend(
            handles=handles, loc="outside lower center", ncols=4, fontsize=8, frameon=False
        )


def finish(figure: Any, path: Path) -> None:
    """Save a figure and forget it."""
    try:
        save(figure, path)
    finally:
        import_pyplot().close(figure)
