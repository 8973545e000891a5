"""Maps as pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ...reference.scene import Array
from ..reports.drawing import FAINT, INK, PALETTE, class_map, import_pyplot, label, new_figure, save
from .compare import Comparison, called
from .store import Map, units


def axis_label(found: Map, name: str) -> str:
    """Return what an axis is called, with its unit."""
    return named(name, units(found.settings["scene"], name))


def named(name: str, unit: str) -> str:
    """Return a name with its unit."""
    return name.replace("_", " ") + ("" if unit == "1" else f" [{unit}]")


def number_map(
    axes: Any, x: Array, y: Array, values: Array, unit: str, bar_label: str = "", **how: Any
) -> None:
    """Draw numbers (n_y, n_x) as cells of colour, angles in colours that close a circle."""
    scale = {"cmap": "twilight", "vmin": -np.pi, "vmax": np.pi} if unit == "rad" else {}
    mesh = axes.pcolormesh(
        x,
        y,
        np.ma.masked_invalid(values),
        shading="nearest",
        rasterized=True,
        **({"cmap": "cividis"} | scale | how),
    )
    bar = axes.figure.colorbar(mesh, ax=axes)
    bar.set_label(bar_label, size=8)
    bar.ax.tick_params(labelsize=8)


def draw(axes: Any, found: Map, name: str | None = None) -> list[Any]:
    """Draw a variable of a map; returns handles for a legend of its classes."""
    name = name or found.shown
    about, values = found.about[name], found.variables[name]
    if about.classes:
        robust = found.variables.get("robust")
        handles = class_map(
            axes, found.x.values, found.y.values, values, about.classes, robust=robust
        )
    else:
        number_map(
            axes, found.x.values, found.y.values, values, about.unit, named(name, about.unit)
        )
        handles = []
    label(axes, axis_label(found, found.x.name), axis_label(found, found.y.name))
    return handles


def draw_map(found: Map, path: Path) -> None:
    """Write a picture of a map.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    figure, axes = new_figure(height=4.2)
    panel = axes[0, 0]
    handles = draw(panel, found)
    panel.set_title(
        f"{found.settings['scene']}: {found.settings['quantity']} by {called(found.settings)}",
        loc="left",
        fontsize=9,
    )
    legend(figure, handles, dotted=bool(handles) and not np.all(found.robust))
    finish(figure, path)


def draw_comparison(found: Comparison, one: Map, path: Path) -> None:
    """Write a picture of two maps and of where they differ.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    figure, axes = new_figure(columns=3, height=2.8, sharey=True)
    panels = axes[0]
    handles: list[Any] = []
    for panel, values, name in zip(panels, (found.one, found.other), found.names, strict=False):
        if found.classes:
            handles = max(
                handles, class_map(panel, found.x, found.y, values, found.classes), key=len
            )
        else:
            both = np.array([found.one, found.other])
            ends = {"vmin": np.nanmin(both), "vmax": np.nanmax(both)}
            ends = {} if found.unit == "rad" else ends
            number_map(panel, found.x, found.y, values, found.unit, **ends)
        label(panel, axis_label(one, one.x.name), title=name)
    panels[0].set_ylabel(axis_label(one, one.y.name), fontsize=8)
    last = panels[2]
    if found.classes:
        level = np.where(found.differs, np.where(found.robust, 2, 1), 0)
        level = np.where(found.compared, level, -1)
        names = ("agree", "differ, not robust", "differ")
        handles += class_map(last, found.x, found.y, level, names, (FAINT, PALETTE[5], INK))
        title = f"{found.agreement():.1%} agree"
    else:
        off = np.full(found.one.shape, np.nan)
        off[found.compared] = np.abs(found.differences)
        number_map(last, found.x, found.y, off, "1", cmap="magma_r")
        title = f"|difference| [{found.unit}]"
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
