"""Common colours, lines and markers of pictures, and how these are saved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from ...reference.errors import UsageError
from ...reference.scene import Array
from ..engines.registry import ENGINES, REFERENCE, offered
from .files import write_or_collect

DOTS_PER_INCH, COLOURS = 150, 48
SUFFIXES = (".png", ".svg")
INK, FAINT = "#222222", "#BBBBBB"


@dataclass(frozen=True)
class EngineLook:
    """The look of an engine in every picture; open and filled markers differ in grey print too."""

    colour: str
    line: Any
    marker: str
    filled: bool = True


LOOKS = (
    EngineLook("#D55E00", (0, (4, 1.5)), "s"),
    EngineLook("#0072B2", (0, (1, 1.2)), "o", filled=False),
    EngineLook("#009E73", "solid", "^"),
    EngineLook("#CC79A7", (0, (4, 1.5, 1, 1.5)), "D", filled=False),
)
"""Looks of engines in order: built-in ones, those of installed packages, any other."""


def look(engine: str) -> EngineLook:
    """Return the look of an engine."""
    engines = [name for name in (*ENGINES, *offered()) if name != REFERENCE]
    place = engines.index(engine) if engine in engines else len(engines)
    return LOOKS[place % len(LOOKS)]


PALETTE = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00", "#56B4E9", "#F0E442", "#000000")
"""Colours that colour-blind readers can distinguish (Okabe and Ito)."""

PALE = ("#8CBFDE", "#F3CB78", "#78C8B0", "#E2B4CE", "#E69A66", "#A6D6F2", "#F7F09A", "#8C8C8C")
"""Colours of areas under lines in colours of the palette."""

WIDTH = 7.0
"""Width of a figure [inches]."""

SHORT = 32
"""Longest label of a legend with four labels in a row."""

NOTE = {"fontsize": 8, "color": INK}


def broad(axes: Any, x: Array, truth: Array, colour: str = FAINT, **how: Any) -> None:
    """Draw the reference: a broad line, under those of the engines."""
    axes.plot(x, truth, color=colour, linewidth=3.2, solid_capstyle="round", **how)


def engine_line(axes: Any, engine: str, x: Array, y: Array, **how: Any) -> None:
    """Draw what an engine computed: a thin line with a few markers."""
    its = look(engine)
    style = {
        "color": its.colour,
        "linestyle": its.line,
        "linewidth": 1.0,
        "marker": its.marker,
        "markersize": 3.5,
        "markevery": max(1, len(x) // 12),
        "label": engine,
    }
    axes.plot(x, y, **(style | how))


def new_figure(rows: int = 1, columns: int = 1, height: float = 2.2, **how: Any) -> tuple[Any, Any]:
    """Return a figure and its axes (rows, columns), each row ``height`` inches high."""
    figure, axes = import_pyplot().subplots(
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


def named(name: str, unit: str) -> str:
    """Return a name with its unit."""
    return name.replace("_", " ") + ("" if unit == "1" else f" [{unit}]")


def class_map(
    axes: Any,
    grid: tuple[Array, Array],
    classes: Array,
    names: Sequence[str],
    colours: Sequence[str] = PALETTE,
    robust: Array | None = None,
) -> list[Any]:
    """Draw classes (n_y, n_x) as cells of colour; return handles for a legend.

    ``grid`` has the values on either axis, (n_x,) and (n_y,). Cells that are not robust have a dot,
    cells without a value stay white.
    """
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.patches import Patch

    x, y = grid
    palette = [colours[i % len(colours)] for i in range(len(names))]
    axes.pcolormesh(
        x,
        y,
        np.ma.masked_less(classes, 0),
        cmap=ListedColormap(palette),
        norm=BoundaryNorm(np.arange(-0.5, len(names)), len(names)),
        rasterized=True,
        shading="nearest",
    )
    if robust is not None:
        row, column = np.nonzero((robust == 0) & (classes >= 0))
        axes.plot(x[column], y[row], linestyle="none", marker=".", markersize=2, color="white")
    present = np.unique(classes[classes >= 0]).astype(int)
    return [Patch(facecolor=palette[i], label=names[i].replace("_", " ")) for i in present]


def save(figure: Any, path: Path, dots: int = DOTS_PER_INCH) -> None:
    """Write a figure: SVG without its date, PNG with few colours, half the size."""
    buffer = BytesIO()
    if path.suffix.lower() == ".svg":
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    else:
        from PIL import Image

        figure.savefig(buffer, format="png", dpi=dots)
        picture = Image.open(buffer).convert("RGB").quantize(COLOURS, kmeans=1)
        picture.save(buffer := BytesIO(), format="png", optimize=True)
    write_or_collect(path, buffer.getvalue())


def save_and_close(figure: Any, *paths: Path, dots: int = DOTS_PER_INCH) -> None:
    """Write a figure to each path as `save` does, and let pyplot forget it."""
    try:
        for path in paths:
            save(figure, path, dots)
    finally:
        import_pyplot().close(figure)


def finish(figure: Any, handles: list[Any], path: Path) -> None:
    """Put a legend, of what there is, below a figure, write it and let pyplot forget it."""
    if handles:
        longest = max(len(handle.get_label()) for handle in handles)
        columns = 4 if longest <= SHORT else 2
        figure.legend(
            handles=handles, loc="outside lower center", ncols=columns, fontsize=8, frameon=False
        )
    save_and_close(figure, path)


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
