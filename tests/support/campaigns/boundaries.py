"""What a step costs in stability: by how much engines shift boundary points.

``python -m mbcheck.tests.support.campaigns.boundaries hula_hoop docs/boundary_steps.png`` prints
the table of docs/boundaries.md and draws it.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mbcheck.comparisons.checks.kinds.boundary import engine_point, true_boundary
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.reports.drawing import FAINT, finish, label, look, named, new_figure
from mbcheck.comparisons.reports.text import markdown_table
from mbcheck.reference import get_scene
from mbcheck.reference.scene import Array, Case

METHODS = (
    ("mujoco", "RK4"),
    ("mujoco", "implicitfast"),
    ("mujoco", "Euler"),
    ("exudyn", "ExplicitMidpoint"),
    ("exudyn", "RK44"),
    ("exudyn", "RK67"),
    ("exudyn", "GeneralizedAlpha"),
)

STEPS = (40, 80, 160, 320, 640)
"""In a period."""

MARKERS = "osD^vPX"
"""Of the methods."""


class Shifts(NamedTuple):
    """Shifts of a boundary point, in the parameter's unit.

    Attributes
    ----------
    engine, method : str
    values, bounds : array (k,)
        By steps in a period, and what rounding and differences leave of each; NaN where the engine
        has no such point near.
    """

    engine: str
    method: str
    values: Array
    bounds: Array

    @property
    def order(self) -> float:
        """What the last halving above the bounds shows of the order."""
        clear = np.flatnonzero(np.abs(self.values) > 10 * self.bounds)
        if clear.size < 2:
            return float("nan")
        last = clear[-1]
        return float(np.log2(abs(self.values[last - 1] / self.values[last])))


def boundary_case(scene: str) -> Case:
    """Return the case of a scene that has a boundary."""
    return next(case for case in get_scene(scene).cases if case.boundary)


def shifts(case: Case, engine: str, method: str, steps: Sequence[int] = STEPS) -> Shifts:
    """Return by how much a method of an engine's default model shifts the boundary of a case."""
    assert case.boundary is not None
    sought, its = true_boundary(case.scene, case.parameters, case.boundary), get_engine(engine)
    (chosen,) = (one for one in its.methods if one.name == method)
    setup, true = Setup(its, case, its.models(case.scene)[0], chosen), sought.solution[1]
    points = [engine_point(setup, sought, count, true.z) for count in steps]
    size = [sought.unit if point.is_solved else np.nan for point in points]
    values = [unit * (point.z[-1] - true.z[-1]) for unit, point in zip(size, points, strict=True)]
    bounds = [unit * point.bound for unit, point in zip(size, points, strict=True)]
    return Shifts(engine, method, np.array(values), np.array(bounds))


def table(rows: Sequence[Shifts], steps: Sequence[int]) -> str:
    """Return a table of shifts and of the orders seen."""
    heads = ("engine", "method", *map(str, steps), "order")
    cells = [
        (
            r.engine,
            r.method,
            *(f"{value:.2g}" for value in r.values),
            f"{r.order:.2f}" if r.order > 0 else "-",
        )
        for r in rows
    ]
    return markdown_table(heads, cells)


def draw(case: Case, rows: Sequence[Shifts], steps: Sequence[int], path: Path) -> None:
    """Draw the sizes of shifts over steps in a period."""
    figure, axes = new_figure(height=3.6)
    panel, handles = axes[0, 0], []
    for row, marker in zip(rows, MARKERS, strict=False):
        its = look(row.engine)
        handles += panel.loglog(
            steps, np.abs(row.values), color=its.colour, linestyle=its.line, linewidth=1.0,
            marker=marker, markersize=4.5, markerfacecolor=its.face,
            label=f"{row.engine} {row.method}",
        )  # fmt: skip
    floor = np.nanmax([row.bounds for row in rows], axis=0)
    handles += panel.loglog(steps, floor, color=FAINT, linewidth=3, label="rounding, differences")
    panel.set_xticks(steps, [str(count) for count in steps])
    panel.minorticks_off()
    assert case.boundary is not None
    name = case.boundary.parameter
    unit = case.parameters.__dataclass_fields__[name].metadata["unit"] or "1"
    label(panel, "steps in a period", f"shift of {named(name, unit)}", case.name)
    finish(figure, handles, path)


def main(scene: str, path: str) -> None:
    """Print the table of a scene, and draw it."""
    case = boundary_case(scene)
    rows = [shifts(case, *method) for method in METHODS]
    print(table(rows, STEPS))
    draw(case, rows, STEPS, Path(path))


if __name__ == "__main__":
    main(*sys.argv[1:])
