"""The verb ``mbcheck tradeoff``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..reports.files import Destination, refuse_conflicts
from ..terminal.program import (
    FAILED,
    INTERRUPTED,
    JSON,
    MARKDOWN,
    PLOT,
    complain,
    console,
    examples,
    finished,
    json_text,
    refuse_picture,
    several,
    to_stdout,
)
from .series import TARGETS

if TYPE_CHECKING:
    from .report import Tradeoff


@click.command(
    epilog=examples(
        "mbcheck tradeoff speed_regulator --target 0.001",
        "mbcheck tradeoff --json tradeoff.json --plot tradeoff.png",
    ),
)
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@several("engine", "ENGINE", "Only this engine")
@click.option(
    "--target",
    "targets",
    type=float,
    multiple=True,
    metavar="ERR",
    help="Relative error to recommend settings for (repeatable); by default 0.01, 0.001, 0.0001.",
)
@JSON
@MARKDOWN
@PLOT
def tradeoff(
    scenes: tuple[str, ...],
    engines: tuple[str, ...],
    targets: tuple[float, ...],
    json_file: Destination | None,
    markdown_file: Destination | None,
    plot: Destination | None,
) -> int:
    """Measure what accuracy costs, and recommend settings.

    Each method of each engine runs a case of the scene over halved steps, and over what else
    limits it. Times are those of this machine; counts may be compared. Of several scenes,
    --plot writes a picture each, FILE_scene.png, and one of the beam's elements.
    """
    from . import pages, report

    refuse_conflicts(json_file, markdown_file, plot)
    refuse_picture(plot)
    found = report.Tradeoff.asked(scenes, engines, targets or TARGETS)
    ended = finished(found.work(), "series")
    if json_file:
        json_file.write(json_text(found.as_json()))
    if markdown_file:
        markdown_file.write(pages.markdown(found))
    if plot:
        draw_all(found, plot.path)
    if not to_stdout(json_file, markdown_file):
        pages.show(console(), found)
    if not ended:
        return complain("interrupted", INTERRUPTED)
    return FAILED if found.failures else 0


def draw_all(found: Tradeoff, path: Path) -> None:
    """Write a figure for each scene, and one of the elements where there are any."""
    from ..reports.drawing import save
    from .choice import pareto
    from .draw import figure_beam, figure_work_precision

    for scene in found.scenes:
        series = found.of(scene)
        name = path if len(found.scenes) == 1 else path.with_stem(f"{path.stem}_{scene}")
        save(figure_work_precision(series, set(pareto(series))), name)
    if found.minimal.curves:
        save(figure_beam(found.minimal), path.with_stem(f"{path.stem}_elements"))
