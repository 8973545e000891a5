"""Boundaries as pictures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..reports.boundaries import draw_curves
from ..reports.drawing import label, new_figure, save_and_close


def draw_boundary(text: Mapping[str, Any], path: Path) -> None:
    """Write a picture of the curves of a document.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    figure, axes = new_figure(height=4.2)
    panel = axes[0, 0]
    handles = draw_curves(panel, text)
    panel.set_xlim(text["x"]["low"], text["x"]["high"])
    panel.set_ylim(text["y"]["low"], text["y"]["high"])
    names = [
        item["name"].replace("_", " ") + ("" if item["unit"] == "1" else f" [{item['unit']}]")
        for item in (text["x"], text["y"])
    ]
    title = f"{text['scene']}: stability boundaries by {text['engine']}"
    label(panel, names[0], names[1], title)
    if handles:
        figure.legend(
            handles=handles, loc="outside lower center", ncols=4, fontsize=8, frameon=False
        )
    save_and_close(figure, path)
