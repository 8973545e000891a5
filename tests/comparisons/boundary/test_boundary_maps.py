"""Curves over maps: regions, ticks, and what is said of them."""

from __future__ import annotations

from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from mbcheck.comparisons.maps import request as map_request
from mbcheck.comparisons.maps import run
from mbcheck.comparisons.maps.verbs import print_agreement
from mbcheck.comparisons.reports.boundaries import disagreements, regions, smooth, ticks
from mbcheck.tests.support.command import invoke, succeeds


def square(*corners: tuple[float, float]) -> dict[str, Any]:
    """Return a document with a closed curve with corners in a unit square."""
    around = [*corners, corners[0]]
    ways = np.diff(np.array([*around, around[1]]), axis=0)
    points = [
        {"x": x, "y": y, "direction": list(way)} for (x, y), way in zip(around, ways, strict=True)
    ]
    return {"curves": [{"of": "orbits", "kind": "fold", "parts": 1, "points": points}]}


def test_regions_between_curves() -> None:
    values = np.linspace(0, 1, 21)
    document = square((0.2, 0.2), (0.8, 0.2), (0.8, 0.8), (0.2, 0.8))
    labels = regions(document, values, values)
    assert len(np.unique(labels)) == 2
    inside = labels == labels[10, 10]
    assert 150 < np.sum(inside) < 250
    known = np.ones(labels.shape, bool)
    assert not np.any(disagreements(document, values, values, inside.astype(int), known))
    wrong = inside.astype(int)
    wrong[10, 10] = 0
    assert np.sum(disagreements(document, values, values, wrong, known)) == 1


def test_ticks_are_on_the_side_on_which_an_orbit_is_stable(small: dict[str, Any]) -> None:
    """Below the loss of symmetry, at right angles to it in a picture."""
    (curve,) = small["curves"]
    low = np.array([small[axis]["low"] for axis in ("x", "y")])
    size = np.array([small[axis]["high"] for axis in ("x", "y")]) - low
    path, shape = smooth(curve, low, size), np.array([1.0, 0.5])
    lines = ticks(curve, path, shape)
    assert len(lines) > 10
    way = np.diff(lines, axis=1)[:, 0] * shape
    assert np.all(way[:, 1] < 0)
    np.testing.assert_allclose(np.linalg.norm(way, axis=1), 0.012)
    along = (path[-1] - path[0]) * shape
    assert np.max(np.abs(way @ along)) < 0.2 * 0.012 * np.linalg.norm(along)
    without = {"points": [{**point, "stable_side": None} for point in curve["points"]]}
    assert not len(ticks(without, path, shape))


@pytest.mark.usefixtures("own_folder")
def test_a_map_of_the_window_agrees(folder: Path, small: dict[str, Any]) -> None:
    line = "--quantity floquet --x force_frequency=5.6:6:6 --y force_amplitude=15:24:6"
    printed = succeeds(
        f"map hula_hoop {line} -o map.nc --plot map.png --boundary", folder / "small.json"
    )
    assert "but for 0 of" in printed
    assert "curves of symmetry breaking part no classes" in printed
    done = invoke(
        f"map hula_hoop {line} -o m.nc --set stiffness=9 --boundary", folder / "small.json"
    )
    assert done.exit_code == 2
    assert "stiffness = 1000.0, the map has 9.0" in done.stderr
    other = line.replace("5.6:6:6", "5.5:6:6")
    done = invoke(f"map hula_hoop {other} -o map.nc --boundary", folder / "small.json")
    assert done.exit_code == 2
    assert "window" in done.stderr


@pytest.mark.parametrize(("of_start", "advised"), [(False, True), (True, False)])
def test_only_where_stability_parts_classes_is_a_place_named(
    of_start: bool, advised: bool, small: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A class of motions from one start may change where nothing loses its stability."""
    x = map_request.Axis("force_frequency", 5.6, 6.0, 4)
    y = map_request.Axis("force_amplitude", 15.0, 24.0, 4)
    computed = run.compute(map_request.resolved(map_request.Request("hula_hoop", "floquet", x, y)))
    classes = computed.variables["stability"].copy()
    classes[1, 1] = 2
    quantity = replace(map_request.quantities("hula_hoop")["floquet"], of_start=of_start)
    monkeypatch.setattr(map_request, "quantities", lambda scene: {"floquet": quantity})
    printed = StringIO()
    changed = replace(computed, variables={**computed.variables, "stability": classes})
    print_agreement(Console(file=printed, width=400), changed, small)
    words = printed.getvalue()
    assert "but for 1 of 16 robust points" in words
    assert ("mbcheck boundary --near 5.73333,18 looks about" in words) == advised
    assert ("from one start" in words) != advised
