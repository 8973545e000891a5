"""The verb ``mbcheck tradeoff``."""

from __future__ import annotations

from typing import Any

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
    examples,
    finished,
    refuse_picture,
)
from .request import TradeoffRequest


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
    **options: Any,
) -> int:
    """Measure what accuracy costs, and recommend settings.

    Each method of each engine runs a case of the scene over halved steps, and over other options
    that limit it. Times are those of this machine; counts may be compared. For several scenes,
    --plot writes a picture each, FILE_scene.png, which a page of --markdown shows.

    For an MJCF file: which step and integrator it needs. Runs start from its keyframes and from the
    state in which it opens, with constant and moving controls, and are compared with a converged
    run. Exit code 1 if no setting meets the target.
    """
    request = TradeoffRequest(**options)
    store = None if request.resume is None else Destination("--resume", request.resume)
    refuse_conflicts(json_file, markdown_file, plot, store)
    refuse_picture(plot)
    from .pages import write
    from .report import begin

    result = begin(request)
    ended = finished(result.work(), "runs")
    write(result, json_file, markdown_file, plot)
    if not ended:
        return complain("interrupted", INTERRUPTED)
    return FAILED if result.failed else 0
