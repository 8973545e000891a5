"""The verb ``mbcheck inspect``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import click

from ...reference.errors import UnknownNameError, UsageError
from ..reports.files import Destination, refuse_conflicts
from ..terminal.program import (
    JSON,
    assignments,
    console,
    destination,
    examples,
    json_text,
    to_stdout,
)


@click.command(
    epilog=examples(
        "mbcheck inspect model.xml",
        "mbcheck inspect model.xml --about-rotation theta=10 --json -",
        "mbcheck inspect model.xml --render model.gif",
        "mbcheck inspect --explain step_limit",
    ),
)
@click.argument("model", required=False, metavar="MODEL.xml")
@click.option(
    "--about-rotation",
    "rotation",
    multiple=True,
    callback=assignments,
    metavar="JOINT=SPEED",
    help="Also find the modes about the steady rotation of a hinge [rad/s].",
)
@click.option(
    "--modes/--no-modes",
    default=None,
    help="Find modes of models of any size, or of none; by default up to 120 degrees of freedom.",
)
@JSON
@click.option(
    "--render",
    callback=destination,
    metavar="FILE.png|.gif",
    help="Draw the first keyframe, or the motion from there; needs no display.",
)
@click.option("--view", is_flag=True, help="Open MuJoCo's viewer.")
@click.option("--explain", metavar="RULE", help="Tell what a rule finds and why; 'all' lists them.")
def inspect(
    model: str | None,
    rotation: Mapping[str, float | str],
    modes: bool | None,
    json_file: Destination | None,
    render: Destination | None,
    view: bool,
    explain: str | None,
) -> int:
    """Inspect an MJCF model: what is in it, how it moves, what it could do without.

    Bodies and joints; natural frequencies and damping at each keyframe; the largest stable step of
    each integrator; how far soft loops open; and findings, each with its rule, reason and fix. A
    comment in the file waives one: <!-- mbcheck: allow RULE, ELEMENT: REASON -->. Exit code 1 if
    an error is not waived, 2 if the file cannot be read.
    """
    if explain is not None:
        explain_rule(explain)
        if model is None:
            return 0
    if model is None:
        raise UsageError("which file? mbcheck inspect MODEL.xml")
    refuse_conflicts(json_file, render)
    from . import console as output
    from . import inspection
    from .mujoco import drawing

    if render is not None:
        if render.standard_output:
            raise UsageError("--render needs the name of a file")
        drawing.refuse_suffix(render.name)
    result = inspection.inspect(model, rotation, modes)
    if json_file:
        json_file.write(json_text(result.as_json()))
    if not to_stdout(json_file):
        output.print_inspection(console(), result)
    if render is not None:
        image, words = drawing.draw(model, Path(render.name).suffix.lower())
        render.write_bytes(image)
        click.echo(f"{render.name}: {words}", err=True)
    if view:
        drawing.view(model)
    return result.exit_code


def explain_rule(name: str) -> None:
    """Print what a rule is, or which there are.

    Raises
    ------
    UnknownNameError
        If there is no such rule.
    """
    from .console import print_rule, print_rules
    from .rules.table import RULES

    if name == "all":
        print_rules(console())
    elif name in RULES:
        print_rule(console(), name)
    else:
        raise UnknownNameError("rule", name, (*RULES, "all"))
