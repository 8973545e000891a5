"""Pictures of maps: what their legends say."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcheck.comparisons.maps import compare, draw, run
from mbcheck.comparisons.maps.request import Axis, Request, resolved
from mbcheck.comparisons.scenes.quantity import NO_VALUE


def test_white_cells_are_in_the_legend(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a class and of a number, where one of two maps has no value, and not where both have."""
    axes = Axis("force_frequency", 1.0, 10.0, 4), Axis("force_amplitude", 5.0, 150.0, 4)
    serial = run.compute(resolved(Request("hula_hoop", "floquet", *axes, model="paper")))
    legends: list[list[str]] = []

    def finish(figure: Any, handles: list[Any], path: Path) -> None:
        legends.append([item.get_label() for item in handles])

    monkeypatch.setattr(draw, "finish", finish)
    numbers = np.nan_to_num(serial.variables["multiplier"])
    whole = replace(serial, variables={**serial.variables, "multiplier": numbers})
    holes = {name: values.copy() for name, values in whole.variables.items()}
    holes[serial.main_variable][0, 0], holes["multiplier"][0, 0] = NO_VALUE, np.nan
    for other in (whole, replace(whole, variables=holes)):
        draw.draw_map(other, Path("none.png"))
        for variable in (None, "multiplier"):
            draw.draw_comparison(compare.compare(whole, other, variable), whole, Path("none.png"))
    there = [any("no value" in words for words in legend) for legend in legends]
    assert there == [*[False] * 3, *[True] * 3]
