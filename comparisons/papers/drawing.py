"""Differences from the reference, and legends, for all papers' figures."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ...reference.scene import Array
from ..reports.drawing import INK, engine_line


def draw_gap(panel: Any, engine: str, x: Array, gap: Array, **how: Any) -> None:
    """Draw the distance of an engine from the reference, on a logarithmic axis."""
    engine_line(panel, engine, x, np.where(gap > 0, gap, np.nan), **how)
    panel.set_yscale("log")


def dotted(panel: Any, height: float, **how: Any) -> None:
    """Draw a dotted line at a height: a value to compare with."""
    panel.axhline(height, color=INK, linewidth=0.6, linestyle=(0, (1, 2)), **how)


def outside_legend(
    figure: Any, handles: Iterable[Any], columns: int | None = None, place: str = "lower"
) -> None:
    """Put a legend outside the panels of a matplotlib figure, each label once.

    Parameters
    ----------
    figure : matplotlib Figure
    handles : iterable of artists
        Their labels tell what they stand for.
    columns : int, optional
        As many as there are labels by default.
    place : {"lower", "upper"}
    """
    by_label: dict[str, Any] = {}
    for handle in handles:
        by_label.setdefault(handle.get_label(), handle)
    figure.legend(
        handles=list(by_label.values()),
        loc=f"outside {place} center",
        ncols=columns or len(by_label),
        fontsize=8,
        frameon=False,
    )


def handles_of(*panels: Any) -> list[Any]:
    """Return the artists of panels that have labels."""
    return [handle for panel in panels for handle in panel.get_legend_handles_labels()[0]]
