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
    NUMBER,
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
    type=NUMBER,
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
    result = report.Tradeoff.asked(scenes, engines, targets or TARGETS)
    ended = finished(result.work(), "series")
    if json_file:
        json_file.write(json_text(result.as_json()))
    if markdown_file:
        markdown_file.write(pages.markdown(result))
    if plot:
        draw_all(result, plot.path)
    if not to_stdout(json_file, markdown_file):
        pages.show(console(), result)
    if not ended:
        return complain("interrupted", INTERRUPTED)
    return FAILED if result.failures else 0


def draw_all(result: Tradeoff, path: Path) -> None:
    """Write a figure for each scene, and one of the elements where there are any."""
    from ..reports.drawing import save
    from .draw import figure_parts, figure_work_precision
    from .elements import continuum_of
    from .report import pareto

    for scene in result.scenes:
        series = result.of(scene)
        name = path if len(result.scenes) == 1 else path.with_stem(f"{path.stem}_{scene}")
        save(figure_work_precision(series, [point for _, point in pareto(series)]), name)
        continuum = continuum_of(scene)
        if continuum.kinds and result.minimal.curves:
            save(figure_parts(result.minimal, continuum), path.with_stem(f"{path.stem}_elements"))
