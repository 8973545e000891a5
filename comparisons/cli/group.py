"""The group of all verbs, and ``mbcheck list``."""

from __future__ import annotations

import click

from ...reference.errors import UsageError
from ..boundary.verb import boundary
from ..check.verb import check_verb
from ..diff.verb import diff
from ..extremes.verb import extremes
from ..inspect.verbs import inspect
from ..judge.verb import judge_verb
from ..maps.verbs import compare_maps, map_
from ..papers.verbs import reproduce_papers
from ..reports.files import Destination
from ..terminal.program import JSON, MISUSED, Program, deliver, examples
from .tradeoff import tradeoff
from .verbs import QUERIES


def show_versions(context: click.Context, option: click.Parameter, wanted: bool) -> None:
    """Print the versions of mbcheck and of the engines, and exit."""
    if not wanted or context.resilient_parsing:
        return
    from ..queries.environment import own_version
    from . import catalogue

    click.echo(f"mbcheck {own_version()}")
    for entry in catalogue.overview()["engines"]:
        click.echo(f"{entry['name']}: {entry['version'] or entry['reason']}")
    context.exit()


@click.group(
    cls=Program,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=examples(
        "mbcheck check                 is the simulator right?",
        "mbcheck list hula_hoop        what is there?",
        "mbcheck simulate hula_hoop --times 0:1:0.1 --csv -",
        "                              numbers to hold a simulator against",
    ),
)
@click.option(
    "--version",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=show_versions,
    help="Show the versions of mbcheck and of the engines.",
)
@click.pass_context
def program(context: click.Context) -> None:
    """Check multibody engines against published mechanisms.

    Exit codes: 0 all is well, 1 a deviation or an error, 2 misuse or nothing ran,
    130 interrupted.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help(), err=True)
        context.exit(MISUSED)


@click.command(
    "list",
    epilog=examples(
        "mbcheck list",
        "mbcheck list hula_hoop",
        "mbcheck list --coverage",
    ),
)
@click.argument("scene", required=False)
@click.option("--coverage", is_flag=True, help="Show which kinds of check each scene has.")
@JSON
def list_(scene: str | None, coverage: bool, json_file: Destination | None) -> None:
    """List what there is, what a scene consists of, or what is checked."""
    from . import catalogue, listing

    if coverage and scene is not None:
        raise UsageError("--coverage is of all scenes: leave the scene out")
    if coverage:
        deliver(catalogue.coverage(), listing.print_coverage, json_file)
    elif scene is None:
        deliver(catalogue.overview(), listing.print_overview, json_file)
    else:
        deliver(catalogue.scene_sheet(scene), listing.print_scene, json_file)


VERBS = (
    *(check_verb, judge_verb, *QUERIES, list_),
    *(diff, map_, boundary, compare_maps, reproduce_papers, tradeoff, extremes, inspect),
)

for verb in VERBS:
    program.add_command(verb)
