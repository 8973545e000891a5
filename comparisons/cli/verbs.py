"""The command line. Every verb is a function of `mbcheck.comparisons.queries.api`, printed."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from ...reference.errors import UsageError
from ..checks.verdict import PROFILES, Result
from ..diff.verb import diff
from ..extremes.verbs import extremes
from ..inspect.verbs import inspect
from ..judge.verbs import or_trajectory
from ..maps.verbs import compare_maps, map_
from ..papers.verbs import reproduce
from ..reports.files import Destination, refuse_conflicts
from ..terminal.ci_options import ANNOTATIONS, KNOWN, STRICT_KNOWN, WRITE_KNOWN
from ..terminal.page_options import HTML, write_page
from ..terminal.program import (
    ENGINE,
    INTERRUPTED,
    JOBS,
    JSON,
    MARKDOWN,
    METHOD,
    MISUSED,
    MODEL,
    SCENE,
    SET,
    STATE,
    STEP,
    Program,
    complain,
    console,
    csv_text,
    deliver,
    destination,
    examples,
    interrupts,
    into,
    json_text,
    progress_bar,
    sample_times,
    several,
    to_stdout,
)
from ..tradeoff.verbs import tradeoff

if TYPE_CHECKING:
    from ..queries.api import Report


RUNNING = ("jobs", "fail_fast", "time_limit", "memory_limit")
"""Options of `check` that do not choose what is checked."""


# The verbs


def show_versions(context: click.Context, option: click.Parameter, wanted: bool) -> None:
    """Print the versions of mbcheck and of the engines, and exit."""
    if not wanted or context.resilient_parsing:
        return
    from ..queries import api
    from . import catalogue

    click.echo(f"mbcheck {api.own_version()}")
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


@program.command(
    epilog=examples(
        "mbcheck check",
        "mbcheck check hula_hoop --engine mujoco --kind trajectory -v",
        "mbcheck check --id '*/point_mass_3hz_60n/order/*' --profile strict",
        "mbcheck check -j 2 --json report.json --junit report.xml",
        "mbcheck check --known mbcheck-known.toml --strict-known --markdown summary.md",
        "mbcheck check --trajectory run.csv --case hula_hoop/rod_aligned --order 4 --step 1e-3",
    ),
)
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@several("engine", "ENGINE", "Only this engine, or package.module:Class")
@several("kind", "KIND", "Only this kind of check")
@several("method", "METHOD", "Only this integrator")
@several("id", "PATTERN", "Only results whose id matches; * and ? are wildcards")
@click.option(
    "--profile",
    default="default",
    show_default=True,
    metavar="|".join(PROFILES),
    help="Scales every tolerance.",
)
@JSON
@into("junit", "Write JUnit XML to a file, or '-'.")
@MARKDOWN
@KNOWN
@STRICT_KNOWN
@WRITE_KNOWN
@ANNOTATIONS
@HTML
@click.option("--full", is_flag=True, help="Include the cases left out of the default set.")
@click.option("--fail-fast", is_flag=True, help="Stop at the first deviation or error.")
@JOBS
@click.option(
    "--time-limit",
    type=float,
    metavar="SECONDS",
    help="Stop a check that takes longer: an error, and the others go on.",
)
@click.option(
    "--memory-limit",
    type=float,
    metavar="MB",
    help="The same for a check that takes more memory (on Linux).",
)
@click.option("-q", "--quiet", is_flag=True, help="Print the summary line only.")
@click.option("-v", "--verbose", is_flag=True, help="Print every result.")
@or_trajectory
def check(
    json_file: Destination | None,
    junit_file: Destination | None,
    markdown_file: Destination | None,
    draft_file: Destination | None,
    annotations: bool | None,
    html_file: Destination | None,
    quiet: bool,
    verbose: bool,
    **selected: Any,
) -> int:
    """Check engines against the reference.

    Every result has an id; a deviation is printed first, with its reason and the command
    that repeats it alone. Exit code 0 if all passed or is known, 1 for any other deviation
    or error, 2 if nothing ran.
    """
    if quiet and verbose:
        raise UsageError("--quiet and --verbose contradict each other")
    files = (json_file, junit_file, markdown_file, draft_file, html_file)
    refuse_conflicts(*files)
    outcome, interrupted = checked(selected, bar=not quiet)
    from ..checks import known
    from ..reports import ci, report

    command = report.repeating(outcome.run.selection)
    if json_file:
        json_file.write(json_text(outcome.as_json()))
    if junit_file:
        junit_file.write(report.junit(outcome.results, outcome.versions, outcome.run))
    summary = ci.markdown(outcome, command, interrupted)
    if markdown_file:
        markdown_file.write(summary)
    if html_file:
        write_page(html_file, outcome, partial(report.rerun, command=command), interrupted)
    if failure := ci.append_step_summary(summary):
        click.echo(f"Warning: {failure}", err=True)
    with ci.annotated(outcome, command, annotations, err=to_stdout(*files)):
        report.print_report(
            console(*files),
            outcome.results,
            outcome.versions,
            verbosity=int(verbose) - int(quiet),
            command=command,
            interrupted=interrupted,
            run=outcome.run,
        )
    if interrupted:
        return complain("interrupted", INTERRUPTED)
    if draft_file:
        draft_file.write(known.draft(outcome.results))
    return outcome.exit_code


def checked(selected: Mapping[str, Any], bar: bool) -> tuple[Report, bool]:
    """Run checks; return their report, and whether they were interrupted."""
    from ..queries import api

    running = {name: selected[name] for name in RUNNING}
    chosen = api.choose_checks(**{k: v for k, v in selected.items() if k not in RUNNING})
    found: list[Result] = []
    try:
        with progress_bar(bar, "checks") as advance, interrupts() as interrupted:

            def progress(done: int, total: int, results: list[Result]) -> None:
                if interrupted():  # and these results are of an engine that was
                    raise KeyboardInterrupt
                found.extend(results)
                advance(done, total)

            return chosen.report(chosen.run(**running, progress=progress)), False
    except KeyboardInterrupt:
        return chosen.report(found), True


@program.command(
    epilog=examples(
        "mbcheck simulate hula_hoop --times 0:1:0.1",
        "mbcheck simulate hula_hoop --times 0.1,0.25,1 --set force_amplitude=80 --csv truth.csv",
        "mbcheck simulate hula_hoop --engine mujoco --method RK4 --step 0.001 \\",
        "    --state theta=0.5 --times 0:0.5:0.01 --json -",
    ),
)
@SCENE
@ENGINE
@METHOD
@STEP
@MODEL
@SET
@STATE
@click.option(
    "--times",
    required=True,
    callback=sample_times,
    metavar="T1,T2,...|START:STOP:STEP",
    help="Sample times [s], on the grid of the step; STOP is included.",
)
@click.option(
    "--observe",
    multiple=True,
    metavar="NAME",
    help="Also show this output of the scene, see mbcheck list SCENE; 'all' for all that the "
    "engine tells (repeatable).",
)
@into("csv", "Write CSV to a file, or '-': t, then the observables, all digits.")
@JSON
def simulate(csv_file: Destination | None, json_file: Destination | None, **asked: Any) -> None:
    """Simulate a scene from t = 0.

    The reference gives the truth with its error bound, the largest over the times: numbers
    to hold a simulator of your own against. Of an engine, rules say on standard error what its
    run cannot be trusted in.
    """
    refuse_conflicts(csv_file, json_file)
    from ..queries import api
    from ..reports import tables

    found = api.simulate(**asked)
    for caution in found.cautions:
        click.echo(f"Warning: {caution.rule}: {caution.message}", err=True)
    if csv_file:
        csv_file.write(csv_text(found))
    if json_file:
        json_file.write(json_text(found.as_json()))
    if not to_stdout(csv_file, json_file):
        tables.print_simulation(console(), found)


@program.command(
    epilog=examples(
        "mbcheck orbit hula_hoop",
        "mbcheck orbit hula_hoop --set force_amplitude=80 --engine exudyn --json -",
    ),
)
@SCENE
@SET
@ENGINE
@METHOD
@STEP
@MODEL
@JSON
def orbit(json_file: Destination | None, **asked: Any) -> None:
    """Find the periodic orbit of a scene.

    The state is that where the period begins, with angles that turn in [0, 2 pi): at t = 0
    modulo the period of the drive or, where nothing drives the scene, where its first
    angle that turns is 0. Of the Floquet multipliers one is then trivially 1.
    harmonics are amplitude cos(order Omega t + phase), the secular part removed. An
    engine's orbit is that of its own discrete flow. No orbit: exit code 1.
    """
    from ..queries import api
    from ..reports import tables

    found = api.orbit(**asked)
    deliver(found.as_json(), tables.print_orbit, found, json_file)


@program.command(
    epilog=examples(
        "mbcheck frequencies hula_hoop",
        "mbcheck frequencies hula_hoop --about rod_aligned --undamped --engine mujoco",
        "mbcheck frequencies rotating_beam --about rotation --plane flapwise --count 3",
    ),
)
@SCENE
@click.option("--about", metavar="NAME", help="State of rest, see mbcheck list SCENE.")
@click.option("--count", type=click.IntRange(1), metavar="N", help="Only the lowest N modes.")
@click.option("--undamped", is_flag=True, help="Leave damping out.")
@click.option(
    "--plane",
    metavar="NAME",
    help="Of a rotating beam: chordwise (in the plane of rotation, the default) or flapwise.",
)
@SET
@ENGINE
@MODEL
@JSON
def frequencies(json_file: Destination | None, **asked: Any) -> None:
    """Find the modes about a state of rest or steady motion, forces and motors off.

    From the engine's own mass, damping and stiffness matrices; ascending in omega =
    |eigenvalue|, zero modes listed.
    """
    from ..queries import api
    from ..reports import tables

    found = api.frequencies(**asked)
    deliver(found.as_json(), tables.print_frequencies, found, json_file)


@program.command(
    epilog=examples(
        "mbcheck export hula_hoop -o hula_hoop.xml",
        "mbcheck export hula_hoop --set rod_length=0.06 -o -",
    ),
)
@SCENE
@SET
@MODEL
@click.option(
    "-o",
    "--output",
    required=True,
    callback=destination,
    metavar="FILE.xml",
    help="The file to write, or '-'.",
)
def export(output: Destination, **asked: Any) -> None:
    """Write a scene's MJCF with these parameters."""
    from ..queries import api

    output.write(api.mjcf_text(**asked))


@program.command(
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
    from ..reports import tables
    from . import catalogue

    if coverage:
        if scene is not None:
            raise UsageError("--coverage is of all scenes: leave the scene out")
        matrix = catalogue.coverage()
        deliver(matrix, tables.print_coverage, matrix, json_file)
        return
    found = catalogue.overview() if scene is None else catalogue.scene_sheet(scene)
    printer = tables.print_overview if scene is None else tables.print_scene
    deliver(found, printer, found, json_file)


for verb in (diff, map_, compare_maps, reproduce, tradeoff, extremes, inspect):
    program.add_command(verb)
