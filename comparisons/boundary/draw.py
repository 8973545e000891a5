"""Boundaries as pictures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..reports.boundaries import draw_curves
from ..reports.drawing import finish, label, named, new_figure


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
    x, y = (named(text[axis]["name"], text[axis]["unit"]) for axis in ("x", "y"))
    label(panel, x, y, f"{text['scene']}: stability boundaries by {text['engine']}")
    finish(figure, handles, path)
