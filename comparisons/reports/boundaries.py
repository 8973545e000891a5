"""Curves of the ``boundary`` document: drawn, and compared with the classes of a map."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ...reference import get_scene
from ...reference.continuation.curve import cubic
from ...reference.errors import MbcheckError, UsageError
from ...reference.scene import Array
from ..documents import type_of
from ..documents.core import checked, record
from ..documents.reading import read_bytes
from .drawing import FAINT, INK, PALETTE

COLOURS = {
    "fold": INK,
    "symmetry_breaking": PALETTE[3],
    "period_doubling": PALETTE[4],
    "neimark_sacker": PALETTE[2],
    "hopf": PALETTE[2],
    "branch_point": PALETTE[3],
    "homoclinic": PALETTE[4],
}

FATES = {
    ("orbits", "fold"): "it and its unstable partner vanish",
    ("orbits", "symmetry_breaking"): "twins branch off",
    ("orbits", "period_doubling"): "an orbit of two periods branches off",
    ("orbits", "neimark_sacker"): "a torus branches off",
    ("equilibria", "fold"): "it and its unstable partner vanish",
    ("equilibria", "branch_point"): "others branch off",
    ("equilibria", "hopf"): "an orbit branches off",
    ("equilibria", "homoclinic"): "the orbit ends on a saddle",
}
"""Fate at a curve of the motion that one side has stable, by subject and kind."""

DASHES = (0, (4, 1.2))
"""Line style of curves of orbits without symmetry over half a period."""

PIECES = 8
"""Line segments of a curve between two points."""

SPACING, TICK = 0.025, 0.012
"""Spacing and length of ticks on a curve, relative to the width of a picture."""

INSIDE = 1e-7
"""How far points of a map are moved off the edges of the window, where curves end, and off lines
through it, on which they were begun."""


def read(path: Path, option: str) -> dict[str, Any] | None:
    """Return a document that an option names, None where there is no file.

    Raises
    ------
    UsageError
        If the file is none of a boundary.
    """
    if not os.path.lexists(path):
        return None
    data = read_bytes(path, f"{option}: ")
    try:
        return checked(record(type_of("boundary"), is_root=True), json.loads(data))
    except (MbcheckError, ValueError, TypeError, AttributeError, RecursionError):
        raise UsageError(
            f"{option}: {str(path)!r} is no boundary of mbcheck, or a broken one"
        ) from None


def read_beside(name: str, asked: Any) -> dict[str, Any]:
    """Return a document of the same scene, window and parameters as a requested map."""
    document = read(Path(name), "--boundary")
    if document is None:
        raise UsageError(f"--boundary: there is no file {name!r}")
    for axis, own in (("x", asked.x), ("y", asked.y)):
        its = document[axis]
        if (document["scene"], its["name"], its["low"], its["high"]) != (
            asked.scene, own.name, own.low, own.high
        ):  # fmt: skip
            raise UsageError(
                f"--boundary: {name!r} is of {document['scene']} with {axis} = {its['name']} from "
                f"{its['low']:g} to {its['high']:g}: it needs the map's scene and window"
            )
    own = get_scene(asked.scene).parameters().replace(**asked.parameters).as_dict()
    for parameter, value in document["parameters"].items():
        if own.get(parameter, value) != value:
            raise UsageError(
                f"--boundary: {name!r} has {parameter} = {value}, the map has {own[parameter]}"
            )
    return document


def smooth(curve: Mapping[str, Any], low: Array, size: Array) -> Array:
    """Return places (m, 2) along a curve of a document, 0 to 1 in the window, cubic between points.

    Parameters
    ----------
    curve : mapping
    low, size : array (2,)
        Lower ends and sizes of the window's axes.
    """
    places = (np.array([[p["x"], p["y"]] for p in curve["points"]]) - low) / size
    ways = np.array([p["direction"][-2:] for p in curve["points"]])
    ways /= np.maximum(np.linalg.norm(ways, axis=1), 1e-12)[:, None]
    return np.vstack([cubic(places, ways, np.arange(PIECES) / PIECES), places[-1:]])


def paths(document: Mapping[str, Any], low: Array, size: Array) -> list[Array]:
    """Return places (m, 2) along all curves of a document, 0 to 1 in a window."""
    return [smooth(curve, low, size) for curve in document["curves"]]


def kind_in_words(curve: Mapping[str, Any]) -> str:
    """Return the kind of a curve of a document in words."""
    words = str(curve["kind"]).replace("_", " ").replace("neimark s", "Neimark-S")
    shared = curve["of"] == "equilibria" and curve["kind"] in ("fold", "branch_point")
    return f"{words} of equilibria" if shared else words


def ticks(curve: Mapping[str, Any], path: Array, shape: Array) -> Array:
    """Return lines (m, 2, 2) from places along a curve to the side on which its orbit is stable.

    Parameters
    ----------
    curve : mapping
    path : array (k, 2)
        Along it, 0 to 1 in the window.
    shape : array (2,)
        Width and height of the window in a picture, in its width.
    """
    sides = [point.get("stable_side") for point in curve["points"]]
    if None in sides:
        return np.empty((0, 2, 2))
    ways = np.gradient(path, axis=0) * shape
    across = np.stack([-ways[:, 1], ways[:, 0]], axis=1)
    across /= np.maximum(np.linalg.norm(ways, axis=1), 1e-12)[:, None] * shape
    nearest = np.minimum((np.arange(len(path)) + PIECES // 2) // PIECES, len(sides) - 1)
    across *= np.sign(np.sum(across * np.array(sides)[nearest], axis=1))[:, None]
    steps = np.linalg.norm(np.diff(path, axis=0) * shape, axis=1)
    arc = np.append(0.0, np.cumsum(steps))
    at = np.searchsorted(arc, np.arange(SPACING / 2, arc[-1], SPACING))
    return np.stack([path[at], path[at] + TICK * across[at]], axis=1)


def draw_curves(axes: Any, document: Mapping[str, Any]) -> list[Any]:
    """Draw the curves of a document; return handles for a legend with their meanings."""
    from matplotlib.collections import LineCollection
    from matplotlib.lines import Line2D

    low = np.array([document[axis]["low"] for axis in ("x", "y")])
    size = np.array([document[axis]["high"] for axis in ("x", "y")]) - low
    handles: dict[str, Any] = {}
    for curve, path in zip(document["curves"], paths(document, low, size), strict=True):
        rests = curve["of"] == "equilibria"
        kind, name = curve["kind"], kind_in_words(curve)
        (line,) = axes.plot(
            *(low + size * path).T,
            color=COLOURS[kind],
            linewidth=1.4,
            linestyle="dotted" if rests else "solid" if curve["parts"] == 1 else DASHES,
            label=f"{name}: {FATES[curve['of'], kind]}",
        )
        handles.setdefault(name, line)
        marks = low + size * ticks(curve, path, np.array([1.0, axes.bbox.height / axes.bbox.width]))
        axes.add_collection(LineCollection(list(marks), colors=COLOURS[kind], linewidths=0.7))
    if any(point.get("stable_side") for curve in document["curves"] for point in curve["points"]):
        words = "ticks: towards the stable side"
        handles["ticks"] = Line2D(
            [], [], color=FAINT, marker="|", markersize=5, linewidth=1.0, label=words
        )
    if any(curve["parts"] > 1 for curve in document["curves"]):
        words = "dashed: of twins, not symmetric over half a period"
        handles["dashed"] = Line2D([], [], color=FAINT, linestyle=DASHES, label=words)
    return list(handles.values())


def regions(document: Mapping[str, Any], x: Array, y: Array) -> Array:
    """Return the number of the region between curves of each point (n_y, n_x) of a grid.

    Neighbours lie in one if no curve crosses the line between them.
    """
    low, high = np.array([x[0], y[0]]), np.array([x[-1], y[-1]])
    lines = [np.stack([path[:-1], path[1:]]) for path in paths(document, low, high - low)]
    lines = [np.clip(line, -1, 2) for line in lines]
    starts, ends = np.concatenate([np.empty((2, 0, 2)), *lines], axis=1)
    grid = np.stack(np.meshgrid((x - low[0]) / (high - low)[0], (y - low[1]) / (high - low)[1]), -1)
    grid = INSIDE + (1 - 3 * INSIDE) * grid
    numbers = np.arange(x.size * y.size).reshape(y.size, x.size)
    pairs = []
    for a, b in (
        (np.s_[:, :-1], np.s_[:, 1:]),
        (np.s_[:-1], np.s_[1:]),
    ):
        for row_a, row_b, from_a, to_b in zip(
            numbers[a], numbers[b], grid[a], grid[b], strict=True
        ):
            apart = np.any(cross(from_a[:, None], to_b[:, None], starts, ends), axis=1)
            pairs.append(np.stack([row_a[~apart], row_b[~apart]]))
    i, j = np.concatenate(pairs, axis=1)
    links = coo_array((np.ones(len(i)), (i, j)), shape=(numbers.size, numbers.size))
    return np.asarray(connected_components(links, directed=False)[1].reshape(numbers.shape))


def cross(a: Array, b: Array, c: Array, d: Array) -> Any:
    """Return True where lines from a to b cross lines from c to d; arrays (..., 2)."""

    def side(start: Array, end: Array, point: Array) -> Array:
        way, off = end - start, point - start
        return np.asarray(way[..., 0] * off[..., 1] - way[..., 1] * off[..., 0])

    return (side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)


def disagreements(document: Mapping[str, Any], x: Array, y: Array, classes: Any, known: Any) -> Any:
    """Return the points (n_y, n_x) of a map with another class than most of their region.

    Parameters
    ----------
    document : mapping
    x, y : array (n_x,), (n_y,)
    classes : int array (n_y, n_x)
    known : bool array (n_y, n_x)
        Which of them count.
    """
    labels, wrong = regions(document, x, y), np.zeros(classes.shape, dtype=bool)
    for label in np.unique(labels[known]):
        here = (labels == label) & known
        values, counts = np.unique(classes[here], return_counts=True)
        wrong |= here & (classes != values[np.argmax(counts)])
    return wrong
