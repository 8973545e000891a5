"""The verbs that print the result of one query: simulate, orbit, frequencies, export."""

from __future__ import annotations

from typing import Any

import click

from ...reference.errors import UsageError
from ..engines import REFERENCE
from ..queries.request import FrequenciesRequest, MethodQuery, ModelQuery, SimulateRequest
from ..reports.files import Destination, refuse_conflicts
from ..terminal.options import with_options_of
from ..terminal.program import (
    JSON,
    QUERY,
    budget_option,
    budgeted,
    console,
    deliver,
    destination,
    examples,
    into,
    json_text,
    to_stdout,
)


@click.command(
    epilog=examples(
        "mbcheck simulate hula_hoop --times 0:1:0.1",
        "mbcheck simulate hula_hoop --times 0.1,0.25,1 --set force_amplitude=80 --csv truth.csv",
        "mbcheck simulate hula_hoop --engine mujoco --method RK4 --step 0.001 "
        "--state theta=0.5 --times 0:0.5:0.01 --json -",
    ),
)
@with_options_of(SimulateRequest)
@into("csv", "Write CSV to a file, or '-': comments, t, then the observables, all digits.")
@click.option("--bounds", is_flag=True, help="Add columns NAME_bound of the reference to the CSV.")
@budget_option(QUERY)
@JSON
def simulate(
    csv_file: Destination | None,
    json_file: Destination | None,
    bounds: bool,
    budget: float,
    **asked: Any,
) -> None:
    """Simulate a scene from t = 0.

    The reference gives the truth with its error bound, the largest over the times: numbers
    to hold a simulator of your own against. From where rounding alone has grown to the size of
    the motion it gives no numbers, with a warning. Rules warn on standard error of doubtful runs of
    an engine.
    """
    refuse_conflicts(csv_file, json_file)
    if bounds and not csv_file:
        raise UsageError("--bounds adds columns to a CSV file: name it with --csv FILE")
    if bounds and asked["engine"] != REFERENCE:
        raise UsageError("--bounds: an engine states no bound on its error; the reference does")
    from ..queries.simulate import simulate as run_simulation
    from ..reports import queries

    with budgeted(budget, "simulate"):
        result = run_simulation(**asked)
    for caution in result.cautions:
        click.echo(f"Warning: {caution.rule}: {caution.message}", err=True)
    if result.lost and (csv_file or json_file):
        click.echo(f"Warning: {result.lost}", err=True)
    if csv_file:
        csv_file.write(queries.csv_text(result, bounds))
    if json_file:
        json_file.write(json_text(result.as_json()))
    if not to_stdout(csv_file, json_file):
        queries.print_simulation(console(), result)


@click.command(
    epilog=examples(
        "mbcheck orbit hula_hoop",
        "mbcheck orbit hula_hoop --set force_amplitude=80 --engine exudyn --json -",
    ),
)
@with_options_of(MethodQuery)
@budget_option(QUERY)
@JSON
def orbit(json_file: Destination | None, budget: float, **asked: Any) -> None:
    """Find a periodic orbit of a scene.

    Several may coexist at the same parameters. Starts are tried in a fixed order: the first
    stable orbit is printed, or an unstable one if no stable one is found. A map may show
    another. Error bounds are those of the orbit printed.

    The state is that where the period begins, with angles that turn in [0, 2 pi): at t = 0
    modulo the period of the drive or, where nothing drives the scene, where its first
    angle that turns is 0. Of the Floquet multipliers one is then trivially 1.
    harmonics are amplitude cos(order Omega t + phase), the secular part removed. An
    engine's orbit is that of its own discrete flow. No orbit: exit code 1.
    """
    from ..queries.orbit import orbit as find_orbit
    from ..reports.queries import print_orbit

    with budgeted(budget, "orbit"):
        result = find_orbit(**asked)
    deliver(result, print_orbit, json_file)


@click.command(
    epilog=examples(
        "mbcheck frequencies hula_hoop",
        "mbcheck frequencies hula_hoop --about rod_aligned --undamped --engine mujoco",
        "mbcheck frequencies rotating_beam --about rotation --plane flapwise --count 3",
    ),
)
@with_options_of(FrequenciesRequest)
@budget_option(QUERY)
@JSON
def frequencies(json_file: Destination | None, budget: float, **asked: Any) -> None:
    """Find the modes about a state of rest or steady motion, without forces and motors.

    From the engine's own mass, damping and stiffness matrices; ascending in omega =
    |eigenvalue|, zero modes listed.
    """
    from ..queries.frequencies import frequencies as find_modes
    from ..reports.queries import print_frequencies

    with budgeted(budget, "frequencies"):
        result = find_modes(**asked)
    deliver(result, print_frequencies, json_file)


@click.command(
    epilog=examples(
        "mbcheck export hula_hoop -o hula_hoop.xml",
        "mbcheck export hula_hoop --set rod_length=0.06 -o -",
    ),
)
@with_options_of(ModelQuery, without=("engine",))
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
    from ..queries.query import mjcf_text

    output.write(mjcf_text(**asked))
