"""The verb ``mbcheck tradeoff``."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ...reference.errors import UsageError
from ..reports.files import STDOUT, Destination, refuse_conflicts
from ..terminal.options import NUMBER, SEED
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
from ..tradeoff.table import TARGETS

if TYPE_CHECKING:
    from ..tradeoff.model import ModelTradeoff
    from ..tradeoff.report import Tradeoff


@click.command(
    epilog=examples(
        "mbcheck tradeoff speed_regulator --target 0.001",
        "mbcheck tradeoff --json tradeoff.json --plot tradeoff.png",
        "mbcheck tradeoff model.xml --target 0.01 --horizon 2 --observe tip",
    ),
)
@click.argument("scenes", nargs=-1, metavar="[SCENE|MODEL.xml]...")
@several("engine", "ENGINE", "Only this engine")
@click.option(
    "--target",
    "targets",
    type=NUMBER,
    multiple=True,
    metavar="ERR",
    help="Relative error to recommend settings for. Of scenes: repeatable, by default 0.01, 0.001, "
    "0.0001. Of a model: one, by default 0.01.",
)
@click.option(
    "--horizon",
    type=NUMBER,
    metavar="T",
    help="Of a model: how long runs last [s], to the nearest 8 steps of the file; by default 1.",
)
@click.option(
    "--budget",
    type=NUMBER,
    metavar="SECONDS",
    help="Of a model: time to try settings in; by default 120.",
)
@several("observe", "NAME", "Of a model: judge by this joint or site, not by all joints")
@click.option(
    "--seed", type=SEED, metavar="N", help="Of a model: of the controls that move; by default 1."
)
@click.option(
    "--exact-closures",
    "exact",
    is_flag=True,
    help="Of a model: compare with loops that are closed exactly, and try how hard they are to be.",
)
@click.option(
    "--resume",
    metavar="FILE",
    help="Keep runs in FILE, and go on from those that an earlier call kept there.",
)
@JSON
@MARKDOWN
@PLOT
def tradeoff(
    scenes: tuple[str, ...],
    engines: tuple[str, ...],
    targets: tuple[float, ...],
    horizon: float | None,
    budget: float | None,
    observes: tuple[str, ...],
    seed: int | None,
    exact: bool,
    resume: str | None,
    json_file: Destination | None,
    markdown_file: Destination | None,
    plot: Destination | None,
) -> int:
    """Measure what accuracy costs, and recommend settings.

    Each method of each engine runs a case of the scene over halved steps, and over what else
    limits it. Times are those of this machine; counts may be compared. Of several scenes,
    --plot writes a picture each, FILE_scene.png, and more of what steps cost in stability, which a
    page of --markdown shows.

    Of an MJCF file: which step and integrator it needs. Runs from its keyframes and from the
    state that it opens in, controls held and moving, against its own converged run. Exit code 1
    if nothing meets the target.
    """
    has_store = resume is not None and resume != STDOUT
    runs = Destination("--resume", str(resume)) if has_store else None
    refuse_conflicts(json_file, markdown_file, plot, runs)
    refuse_picture(plot)
    own: dict[str, Any] = {"horizon": horizon, "budget": budget, "observed": observes}
    own |= {"seed": seed, "exact": exact or None}
    settings: dict[str, Any] = {
        name: value for name, value in own.items() if value is not None and value != ()
    }
    result: ModelTradeoff | Tradeoff
    if any(is_file(name) for name in scenes):
        from ..tradeoff.model import ModelTradeoff, Question

        refuse_more(scenes, targets, engines)
        settings |= {"target": targets[0]} if targets else {}
        result = ModelTradeoff(scenes[0], Question(**settings, resume=resume))
    elif settings:
        options = "--horizon, --budget, --observe, --seed and --exact-closures"
        raise UsageError(f"{options} are of a model: MODEL.xml")
    else:
        from ..tradeoff.report import Tradeoff

        result = Tradeoff.asked(scenes, engines, targets or TARGETS, resume)
    ended = finished(result.work(), "runs")
    write(result, json_file, markdown_file, plot)
    if not ended:
        return complain("interrupted", INTERRUPTED)
    return FAILED if result.failed else 0


def is_file(name: str) -> bool:
    """Return whether a word on the command line names a file, not a scene."""
    return name.lower().endswith(".xml") or os.path.isfile(name)  # of any text


def refuse_more(scenes: Sequence[str], targets: Sequence[float], engines: Sequence[str]) -> None:
    """Refuse what does not go together with a model.

    Raises
    ------
    UsageError
    """
    wrong = {
        f"one file, and nothing beside it ({', '.join(scenes)})": len(scenes) > 1,
        f"one --target ({', '.join(f'{one:g}' for one in targets)})": len(targets) > 1,
        f"no --engine ({', '.join(engines)}): MuJoCo runs it": bool(engines),
    }
    if any(wrong.values()):
        raise UsageError("of a model: " + "; ".join(words for words in wrong if wrong[words]))


def write(
    result: ModelTradeoff | Tradeoff,
    json_file: Destination | None,
    markdown_file: Destination | None,
    plot: Destination | None,
) -> None:
    """Write the document, the page and the pictures that are asked for, or print the tables."""
    from ..tradeoff import pages

    if json_file:
        json_file.write(json_text(result.as_json()))
    drawn: list[tuple[str, Path]] = []
    try:
        if plot:
            from ..reports.drawing import save
            from ..tradeoff.draw import pictures

            for title, path, figure in pictures(result, plot.path):
                save(figure, path)
                drawn.append((title, path))
    finally:
        if markdown_file:
            markdown_file.write(with_pictures(pages.markdown(result), drawn, markdown_file))
    if not to_stdout(json_file, markdown_file):
        pages.show(console(), result)


def with_pictures(page: str, pictures: Sequence[tuple[str, Path]], place: Destination) -> str:
    """Return a page that shows pictures, each under its title."""
    for title, path in reversed(pictures):
        name = os.path.relpath(path, place.path.parent).replace(os.sep, "/")
        heading = f"\n## {title}\n"
        page = page.replace(heading, f"{heading}\n![{title}]({name})\n")
    return page
