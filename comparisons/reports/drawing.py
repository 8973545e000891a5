"""How pictures look: colours, lines and markers that all of them share, and how they are saved."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from ...reference.errors import UsageError
from ...reference.scene import Array

DOTS_PER_INCH, COLOURS = 150, 96
SUFFIXES = (".png", ".svg")
INK, FAINT = "#222222", "#BBBBBB"
MARKERS = {"mujoco": "s", "exudyn": "o"}

ENGINE_COLOURS = {"mujoco": "#D55E00", "exudyn": "#0072B2"}
HOLLOW = ("exudyn",)
"""Engines whose markers are not filled, which tells them apart in grey."""

ENGINE_LINES = {"mujoco": (0, (4, 1.5)), "exudyn": (0, (1, 1.2))}
NAMES = {"reference": "reference", "mujoco": "MuJoCo", "exudyn": "Exudyn"}

PALETTE = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00", "#56B4E9", "#F0E442", "#000000")
"""Colours that colour-blind readers tell apart (Okabe and Ito)."""

WIDTH = 7.0
"""Of a figure [inches]."""

NOTE = {"fontsize": 8, "color": INK}


def broad(axes: Any, x: Array, truth: Array, colour: str = FAINT, **how: Any) -> None:
    """Draw the reference: a broad line, under those of the engines."""
    axes.plot(x, truth, color=colour, linewidth=3.2, solid_capstyle="round", **how)


def engine_line(axes: Any, engine: str, x: Array, found: Array, **how: Any) -> None:
    """Draw what an engine found: a thin line with a few markers."""
    style = {
        "color": ENGINE_COLOURS.get(engine, INK),
        "linestyle": ENGINE_LINES.get(engine, "solid"),
        "linewidth": 1.0,
        "marker": MARKERS.get(engine, "^"),
        "markersize": 3.5,
        "markevery": max(1, len(x) // 12),
        "label": NAMES.get(engine, engine),
    }
    axes.plot(x, found, **(style | how))


def new_figure(rows: int = 1, columns: int = 1, height: float = 2.2, **how: Any) -> tuple[Any, Any]:
    """Return a figure and its axes (rows, columns), each row ``height`` inches high."""
    plt = import_pyplot()
    figure, axes = plt.subplots(
        rows,
        columns,
        figsize=(WIDTH, height * rows + 0.4),
        layout="constrained",
        squeeze=False,
        **how,
    )
    for panel in axes.flat:
        panel.spines[["top", "right"]].set_visible(False)
        panel.tick_params(labelsize=8)
    return figure, axes


def label(axes: Any, x: str = "", y: str = "", title: str = "") -> None:
    """Name the axes, with units, and the panel."""
    axes.set_xlabel(x, fontsize=8)
    axes.set_ylabel(y, fontsize=8)
    axes.set_title(title, loc="left", fontsize=9)


def class_map(
    axes: Any,
    x: Array,
    y: Array,
    classes: Array,
    names: Sequence[str],
    colours: Sequence[str] = PALETTE,
    robust: Array | None = None,
) -> list[Any]:
    """Draw classes (n_y, n_x) as cells of colour; return handles for a legend.

    What is not robust is hatched by a dot, what has no value stays white.
    """
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.patches import Patch

    shown = [colours[i % len(colours)] for i in range(len(names))]
    axes.pcolormesh(
        x,
        y,
        np.ma.masked_less(classes, 0),
        cmap=ListedColormap(shown),
        norm=BoundaryNorm(np.arange(-0.5, len(names)), len(names)),
        rasterized=True,
        shading="nearest",
    )
    if robust is not None:
        row, column = np.nonzero((robust == 0) & (classes >= 0))
        axes.plot(x[column], y[row], linestyle="none", marker=".", markersize=2, color="white")
    present = np.unique(classes[classes >= 0]).astype(int)
    return [Patch(facecolor=shown[i], label=names[i].replace("_", " ")) for i in present]


def save(figure: Any, path: Path) -> None:
    """Write a figure: SVG without its date, PNG with few colours, half the size."""
    if path.suffix.lower() == ".svg":
        figure.savefig(path, metadata={"Date": None})
        return
    from PIL import Image

    buffer = BytesIO()
    figure.savefig(buffer, format="png", dpi=DOTS_PER_INCH)
    Image.open(buffer).convert("RGB").quantize(COLOURS).save(path, optimize=True)


def import_pyplot() -> Any:
    """Return matplotlib's pyplot, with a backend that needs no display.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    try:
        import matplotlib
        import matplotlib.pyplot as plt
    except ImportError:
        raise UsageError("figures need matplotlib; pip install 'mbcheck[plot]'") from None
    matplotlib.use("agg")
    return plt
