"""The verb ``mbcheck tradeoff``."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import click

from ..reports.files import Destination, refuse_conflicts
from ..terminal.options import with_options_of
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
    to_stdout,
)
from .request import TradeoffRequest

if TYPE_CHECKING:
    from .model import ModelTradeoff
    from .report import Tradeoff


@click.command(
    epilog=examples(
        "mbcheck tradeoff speed_regulator --target 0.001",
        "mbcheck tradeoff --json tradeoff.json --plot tradeoff.png",
        "mbcheck tradeoff model.xml --target 0.01 --horizon 2 --observe tip",
    ),
)
@with_options_of(TradeoffRequest)
@JSON
@MARKDOWN
@PLOT
def tradeoff(
    json_file: Destination | None,
    markdown_file: Destination | None,
    plot: Destination | None,
    **asked: Any,
) -> int:
    """Measure what accuracy costs, and recommend settings.

    Each method of each engine runs a case of the scene over halved steps, and over what else
    limits it. Times are those of this machine; counts may be compared. Of several scenes,
    --plot writes a picture each, FILE_scene.png, which a page of --markdown shows.

    Of an MJCF file: which step and integrator it needs. Runs from its keyframes and from the
    state that it opens in, controls held and moving, against its own converged run. Exit code 1
    if nothing meets the target.
    """
    request = TradeoffRequest(**asked)
    store = None if request.resume is None else Destination("--resume", request.resume)
    refuse_conflicts(json_file, markdown_file, plot, store)
    refuse_picture(plot)
    result: ModelTradeoff | Tradeoff
    if request.is_model:
        from .model import ModelTradeoff

        result = ModelTradeoff(request)
    else:
        from .report import Tradeoff

        result = Tradeoff.asked(request)
    ended = finished(result.work(), "runs")
    write(result, json_file, markdown_file, plot)
    if not ended:
        return complain("interrupted", INTERRUPTED)
    return FAILED if result.failed else 0


def write(
    result: ModelTradeoff | Tradeoff,
    json_file: Destination | None,
    markdown_file: Destination | None,
    plot: Destination | None,
) -> None:
    """Write the document, the page and the pictures that are wanted, or print the tables."""
    from . import pages

    if json_file:
        json_file.write(json_text(result.as_json()))
    drawn: list[tuple[str, str]] = []
    try:
        if plot:
            from ..reports.drawing import save_and_close
            from .draw import pictures

            for title, path, figure in pictures(result, plot.path):
                save_and_close(figure, path)
                drawn.append((title, str(path)))
    finally:
        if markdown_file:
            folder = markdown_file.path.parent
            links = [
                (title, os.path.relpath(path, folder).replace(os.sep, "/")) for title, path in drawn
            ]
            markdown_file.write(pages.markdown(result, links))
    if not to_stdout(json_file, markdown_file):
        pages.show(console(), result)
