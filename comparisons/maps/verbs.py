"""The verbs ``mbcheck map`` and ``mbcheck compare-maps``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click
import numpy as np

from ...reference.cost import within
from ..reports.files import Destination, refuse_conflicts
from ..terminal.options import COUNT, with_options_of
from ..terminal.program import (
    JSON,
    MAP,
    PLOT,
    budget_option,
    console,
    destination,
    examples,
    json_text,
    progress_bar,
    refuse_picture,
    to_stdout,
)
from .request import Request, resolved

if TYPE_CHECKING:
    from .compare import MapComparison


@click.command(
    "map",
    epilog=examples(
        "mbcheck map hula_hoop --quantity floquet -o floquet.nc --plot floquet.png "
        "--x force_frequency=1:10:30 --y force_amplitude=5:150:30",
        "mbcheck map speed_regulator --quantity regime --engine mujoco --refine -o regime.nc "
        "--x damping=0.5:6:17 --y torque=0.02:1.2:17",
    ),
)
@with_options_of(Request)
@click.option(
    "-o",
    "--output",
    required=True,
    callback=destination,
    metavar="FILE.nc",
    help="The NetCDF file to write; FILE.nc.unfinished keeps finished blocks meanwhile.",
)
@PLOT
@click.option("--resume", is_flag=True, help="Go on with what an interrupted run has kept.")
@click.option("--workers", type=COUNT, default=1, show_default=True, help="Processes.")
@click.option("--dask", metavar="ADDRESS", help="Scheduler of a Dask cluster, instead.")
@budget_option(MAP)
@click.option(
    "--boundary",
    metavar="FILE.json",
    help="Curves of mbcheck boundary: drawn over the map, and compared with its classes.",
)
def map_(
    output: Destination,
    plot: Destination | None,
    resume: bool,
    workers: int,
    dask: str | None,
    budget: float,
    boundary: str | None,
    **asked: Any,
) -> int:
    """Map a quantity of a scene over two of its parameters.

    What is computed is kept: an interrupted map goes on with --resume, and equals one that
    was not interrupted. The map does not depend on --workers or --dask. Exit code 1: no point
    has a value.
    """
    from ..reports import boundaries
    from . import draw, run, store

    refuse_conflicts(output, plot)
    refuse_picture(plot)
    wanted = resolved(Request(**asked))
    curves = None if boundary is None else boundaries.read_beside(boundary, wanted)
    unfinished = None
    if not output.standard_output:
        unfinished = output.path.with_name(f"{output.path.name}.unfinished")
    with progress_bar(True, "points") as advance, within(budget):
        result = run.compute(
            wanted, workers=workers, dask=dask, unfinished=unfinished, resume=resume,
            progress=advance,
        )  # fmt: skip
    if output.write_bytes(store.to_bytes(result)) and unfinished is not None:
        unfinished.unlink(missing_ok=True)
    if plot:
        draw.draw_map(result, plot.path, curves)
    if not output.standard_output:
        print_map(console(), result)
        if curves is not None:
            print_agreement(console(), result, curves)
    return int(len(result.problems) == result.computed.sum())


def print_map(console: Any, result: Any) -> None:
    """Print what a map shows in a few lines."""
    from ..reports.text import print_line, print_table
    from ..reports.words import number, with_unit
    from .compare import called

    computed = int(result.computed.sum())
    print_line(
        console,
        f"{result.settings['scene']} {result.settings['quantity']} by {called(result.settings)}: "
        f"{result.x.count} x {result.y.count} points, {computed} computed",
    )
    for name, about in result.about.items():
        if about.classes:
            rows = [(label, f"{share:.1%}") for label, share in result.shares(name).items()]
            print_table(console, (name, "share of computed points"), rows)
        elif name != "robust" and np.any(np.isfinite(result.variables[name])):
            low, high = np.nanmin(result.variables[name]), np.nanmax(result.variables[name])
            print_line(console, f"{name}: {number(low, 6)} to {with_unit(high, about.unit, 6)}")
    if "robust" in result.variables:
        share = float((result.robust & result.computed).sum() / max(computed, 1))
        why = result.about["robust"].meaning.removeprefix("1 where ")
        print_line(console, f"{share:.1%} are robust: {why}")
    if result.problems:
        x, y, words = result.problems[0]
        print_line(
            console,
            f"no value at {len(result.problems)} points; the first, at "
            f"{result.x.name}={number(x, 6)} {result.y.name}={number(y, 6)}: {words}",
        )


def print_agreement(console: Any, result: Any, curves: Any) -> None:
    """Print at how many points the classes of a map are those of their region between curves."""
    from ..reports.boundaries import disagreements
    from ..reports.text import print_line
    from .request import quantities

    if not result.about[result.main_variable].classes:
        return
    known = result.robust & result.computed
    classes = result.variables[result.main_variable]
    off = disagreements(curves, result.x.values, result.y.values, classes, known)
    words = (
        f"the curves part the map into regions of one class each but for {int(off.sum())} of "
        f"{int(known.sum())} robust points"
    )
    if quantities(result.settings["scene"])[result.settings["quantity"]].of_start:
        words += "; classes of the motion from one start differ by more than stability"
    elif np.any(off):
        row, column = np.argwhere(off)[0]
        x, y = result.x.values[column], result.y.values[row]
        words += f"; mbcheck boundary --near {x:.6g},{y:.6g} looks about the first of them"
    print_line(console, words)
    if any(curve["kind"] == "symmetry_breaking" for curve in curves["curves"]):
        print_line(console, "curves of symmetry breaking part no classes: twins are of one class")


@click.command(
    "compare-maps",
    epilog=examples("mbcheck compare-maps reference.nc mujoco.nc --plot difference.png"),
)
@click.argument("one", metavar="A.nc")
@click.argument("other", metavar="B.nc")
@click.option("--variable", metavar="NAME", help="By default the one that a map is of.")
@PLOT
@JSON
def compare_maps(
    one: str,
    other: str,
    variable: str | None,
    plot: Destination | None,
    json_file: Destination | None,
) -> None:
    """Compare two maps of a scene on the points that both have computed.

    Classes: the share that agrees, over all points and over those that are robust in both;
    which class is taken for which; how far a boundary would have to move, in cells.
    """
    from . import compare, draw, store

    refuse_conflicts(plot, json_file)
    refuse_picture(plot)
    first, second = store.read(one), store.read(other)
    result = compare.compare(first, second, variable)
    if plot:
        draw.draw_comparison(result, first, plot.path)
    if json_file:
        json_file.write(json_text(result.as_json()))
    if not to_stdout(json_file):
        print_comparison(console(), result)


def print_comparison(console: Any, result: MapComparison) -> None:
    """Print how far two maps agree."""
    from ..reports.text import print_line, print_table
    from ..reports.words import number

    print_line(
        console, f"{result.variable}: {' against '.join(result.maps)}, {result.points} points"
    )
    if off := result.difference:
        print_line(
            console,
            f"largest difference {number(off.largest)} {result.unit} "
            f"({number(result.relative_difference, 2)} of the largest value), median "
            f"{number(off.median)}",
        )
    offset = result.boundary_offset_cells
    if result.agreement is None or offset is None:
        return
    print_line(console, f"agreement {result.agreement:.2%}")
    if result.robust_agreement is not None:
        print_line(
            console, f"of the {result.robust_points} robust points {result.robust_agreement:.2%}"
        )
    print_line(
        console,
        f"boundaries would have to move by {offset.median:.1f} cells (median; largest "
        f"{offset.largest:.1f})",
    )
    rows = [(name, *map(str, row.values())) for name, row in result.confusion.items()]
    print_table(console, (f"{result.maps[0]} \\ {result.maps[1]}", *result.classes), rows)
