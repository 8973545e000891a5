"""The group of all verbs, and ``mbcheck list``."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module

import click
from click.shell_completion import CompletionItem

from ...reference.errors import UnknownNameError, UsageError
from ..reports.files import Destination
from ..terminal.program import JSON, MISUSED, Program, deliver, examples

VERBS: Mapping[str, tuple[str, str]] = {
    "check": ("check.verb.check_verb", "Check engines against the reference."),
    "judge": ("judge.verb.judge_verb", "Judge a trajectory that was computed elsewhere."),
    "simulate": ("cli.verbs.simulate", "Simulate a scene from t = 0."),
    "orbit": ("cli.verbs.orbit", "Find a periodic orbit of a scene."),
    "frequencies": ("cli.verbs.frequencies", "Find the modes about a state of rest."),
    "export": ("cli.verbs.export", "Write a scene's MJCF with these parameters."),
    "list": ("cli.group.list_", "List scenes and engines, the parts of a scene, or all checks."),
    "explain": ("cli.explain.explain", "Explain a term of the reports."),
    "compare": ("compare.verb.compare_models", "Compare two readings of one model."),
    "diff": ("diff.verb.diff", "Compare two runs of `mbcheck check --json`."),
    "map": ("maps.verbs.map_", "Map a quantity of a scene over two of its parameters."),
    "boundary": (
        "boundary.verb.boundary",
        "Trace stability boundaries of orbits and equilibria.",
    ),
    "compare-maps": ("maps.verbs.compare_maps", "Compare two maps of a scene."),
    "reproduce": ("papers.verbs.reproduce_papers", "Reproduce figures and claims of the papers."),
    "tradeoff": ("tradeoff.verb.tradeoff", "Measure what accuracy costs, and recommend settings."),
    "extremes": ("extremes.verb.extremes", "Check engines at extremes, up to where they fail."),
    "inspect": ("inspect.verbs.inspect", "Find mistakes in MJCF models, and their modes."),
}
"""Function of each verb, below `comparisons`, and its purpose. Verbs are loaded when they run."""


class Verbs(Program):
    """The verbs, each loaded when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the verbs."""
        return sorted(VERBS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a verb by name."""
        if cmd_name not in VERBS:
            if ctx.resilient_parsing:
                return None
            raise UnknownNameError("command", cmd_name, sorted(VERBS))
        module, _, name = VERBS[cmd_name][0].rpartition(".")
        verb: click.Command = getattr(import_module(f"..{module}", __package__), name)
        return verb

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Return the verbs that begin so, none of which is loaded for it, and options."""
        verbs = [
            CompletionItem(name, help=VERBS[name][1])
            for name in self.list_commands(ctx)
            if name.startswith(incomplete)
        ]
        return verbs + click.Command.shell_complete(self, ctx, incomplete)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write what the verbs do."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, VERBS[name][1]) for name in sorted(VERBS)])


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
    cls=Verbs,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=examples(
        "mbcheck check                 check the installed engines",
        "mbcheck list hula_hoop        show the parts of a scene",
        "mbcheck simulate hula_hoop --times 0:1:0.1 --csv -",
        "                              numbers to compare a simulator with",
        'eval "$(_MBCHECK_COMPLETE=bash_source mbcheck)"',
        "                              complete verbs and options: bash, zsh, fish",
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
    """List scenes and engines, the parts of a scene, or all checks."""
    from . import catalogue

    if coverage and scene is not None:
        raise UsageError("--coverage lists all scenes: leave the scene out")
    if coverage:
        deliver(catalogue.coverage(), catalogue.print_coverage, json_file)
    elif scene is None:
        deliver(catalogue.overview(), catalogue.print_overview, json_file)
    else:
        deliver(catalogue.scene_sheet(scene), catalogue.print_scene, json_file)
