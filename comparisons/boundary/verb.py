"""The verb ``mbcheck boundary``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from time import monotonic
from typing import Any

import click

from ...reference.cost import within
from ..reports.files import Destination, refuse_conflicts
from ..terminal.options import COUNT, with_options_of
from ..terminal.program import (
    INTERRUPTED,
    MAP,
    PLOT,
    budget_option,
    console,
    destination,
    examples,
    finished,
    json_text,
    refuse_picture,
    to_stdout,
)
from .request import BoundaryRequest, refuse_impossible

OFTEN = 1.0
"""Time [s] after which the curves found so far are written again."""


@click.command(
    epilog=examples(
        "mbcheck boundary hula_hoop --x force_frequency=1:10 --y force_amplitude=5:150 "
        "-o boundary.json --plot boundary.png",
        "mbcheck boundary hula_hoop --engine mujoco --step 0.005 --lines 2 -o mujoco.json "
        "--x force_frequency=5:6 --y force_amplitude=15:35",
    ),
)
@with_options_of(BoundaryRequest)
@click.option(
    "-o",
    "--output",
    callback=destination,
    metavar="FILE.json",
    help="The document to write; if it exists, its curves are continued.",
)
@PLOT
@click.option("--workers", type=COUNT, default=1, show_default=True, help="Processes.")
@budget_option(MAP)
def boundary(
    output: Destination | None,
    plot: Destination | None,
    workers: int,
    budget: float,
    **asked: Any,
) -> int:
    """Follow where orbits and equilibria lose their stability, as curves over two parameters.

    By the reference, or by an engine with a fixed number of steps in a period; how far its curves
    lie from the reference's is a number in the unit of a parameter. The curves do not depend on
    --workers.
    """
    from ..reports import boundaries
    from . import run

    refuse_conflicts(output, plot)
    refuse_picture(plot)
    wanted = BoundaryRequest(**asked)
    refuse_impossible(wanted)
    result = run.Boundary(wanted)
    if output and not output.standard_output:
        before = boundaries.read(Path(output.name), output.option)
        if before:
            result.restore(before)

    def write() -> None:
        if output and not output.standard_output:
            output.write(json_text(result.as_json()))

    try:
        with within(budget):
            click.echo(
                f"looks for bifurcations of {' and '.join(result.networks)} along "
                f"{len(result.networks) * len(result.lines)} lines, then follows the curves "
                "through them: minutes mostly; finished lines give an estimate",
                err=True,
            )
            complete = finished(now_and_then(write, result.work(workers)), "")
    finally:
        text = result.as_json()
        if output:
            output.write(json_text(text))
    if plot:
        draw_boundary(text, plot.path)
    print_boundary(console(output), text, to_stdout(output))
    return 0 if complete else INTERRUPTED


def now_and_then(write: Callable[[], None], states: Iterable[Any]) -> Iterator[Any]:
    """Yield states of work, which is written every `OFTEN`: a kill leaves what was written."""
    written = monotonic()
    for state in states:
        if monotonic() - written > OFTEN:
            write()
            written = monotonic()
        yield state


def draw_boundary(text: Mapping[str, Any], path: Path) -> None:
    """Write a picture of the curves of a document."""
    from ..reports.boundaries import draw_curves
    from ..reports.drawing import finish, label, named, new_figure

    figure, axes = new_figure(height=4.2)
    panel, x, y = axes[0, 0], text["x"], text["y"]
    handles = draw_curves(panel, text)
    panel.set_xlim(x["low"], x["high"])
    panel.set_ylim(y["low"], y["high"])
    title = f"{text['scene']}: stability boundaries by {text['engine']}"
    label(panel, named(x["name"], x["unit"]), named(y["name"], y["unit"]), title)
    finish(figure, handles, path)


def print_boundary(screen: Any, text: Mapping[str, Any], quiet: bool) -> None:
    """Print what was followed, a line for each curve."""
    from ..reports.boundaries import kind_in_words
    from ..reports.text import print_line, print_table
    from ..reports.words import number as in_words
    from ..reports.words import plural

    if quiet:
        return
    names = [text[axis]["name"] for axis in ("x", "y")]
    rows = []
    for curve in text["curves"]:
        points = curve["points"]
        ranges = [
            f"{in_words(min(p[a] for p in points), 6)} to {in_words(max(p[a] for p in points), 6)}"
            for a in ("x", "y")
        ]
        bound = max(p["y_bound_across"] for p in points)
        shifts = [abs(p["shift_y"]) for p in points if p["shift_y"] is not None]
        row = (kind_in_words(curve), str(curve["parts"]), str(len(points)), *ranges)
        rows.append((*row, f"{bound:.1e}", f"{max(shifts):.3g}" if shifts else "-"))
    if rows:
        heads = ("curve", "parts", "points", *names, "bound across", "shift")
        print_table(screen, heads, rows)
    who = text["engine"]
    steps = text["steps_per_period"]
    how = f" {text['method']}, {steps} steps of at most {in_words(text['step'])} s in a period"
    print_line(
        screen,
        f"{text['scene']} by {who}{how if steps else ''}: {plural(len(rows), 'curve')}, "
        f"{plural(text['orbits'], 'orbit')} of the reference"
        + (f", {text['engine_orbits']} of {who}" if steps else ""),
    )
    if text["missing"]:
        print_line(
            screen, f"{text['missing']} bifurcations of the reference have none of {who} near"
        )
    lines = len(text["of"]) * (text["lines"] + len(text["near"]))
    left = len(text["pending"]) + len(text["doublings"]) + lines - text["lines_done"]
    if left:
        print_line(screen, f"not complete: {left} lines and curves are left")
    elif not rows and not text["missing"]:
        print_line(
            screen,
            f"no stability changes along {plural(text['lines'], 'line')}; more --lines may meet "
            "an island; mbcheck orbit says at one point whether the orbit is stable, and mbcheck "
            "map where orbits are",
        )
