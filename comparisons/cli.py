"""The command line. Every verb is a function of `mbcheck.comparisons.api`, printed."""

from __future__ import annotations

import csv
import io
import json
import math
import os
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from decimal import Decimal, InvalidOperation
from types import FrameType
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

import click
import numpy as np

from ..reference.errors import MbcheckError, UnknownNameError, UsageError
from .files import Destination, refuse_conflicts
from .verdict import PROFILES, Result

if TYPE_CHECKING:
    from rich.console import Console

    from .api import Report, Simulation

FAILED, MISUSED, INTERRUPTED, BROKEN_PIPE = 1, 2, 130, 141
"""Exit codes beside 0; the last two are those of a program ended by its signal."""

MOST_TIMES = 10_000_000
"""Longer lists of times are refused as a slip of the pen."""

Function = TypeVar("Function", bound=Callable[..., Any])


# Exit codes and messages


class Program(click.Group):
    """The verbs. A user's mistake is one line on standard error, never a traceback."""

    def main(self, *args: Any, **extra: Any) -> NoReturn:
        """Run a command line and exit."""
        sys.exit(self.exit_code(*args, **extra))

    def exit_code(self, *args: Any, **extra: Any) -> int:
        """Run a command line and return its exit code."""
        if sys.stdout is None or sys.stderr is None:
            return complain("standard output and standard error must be open", MISUSED)
        with interrupts() as interrupted, warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # what matters becomes an error
            code = self.outcome(*args, **extra)
            if interrupted() and code != INTERRUPTED:
                return complain("interrupted", INTERRUPTED)
            return code

    def outcome(self, *args: Any, **extra: Any) -> int:
        """Run a command line; return its exit code, with its error told in one line."""
        extra.update(prog_name="mbcheck", standalone_mode=False)
        try:
            return int(super().main(*args, **extra) or 0)
        except click.ClickException as error:
            return complain(hinted(error), MISUSED)
        except UsageError as error:
            return complain(str(error), MISUSED)
        except MbcheckError as error:
            return complain(str(error), FAILED)
        except (ArithmeticError, np.linalg.LinAlgError) as error:
            return complain(f"these values leave the range of numbers: {error}", MISUSED)
        except click.Abort:
            return complain("interrupted", INTERRUPTED)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the verb; a reader that has gone away ends it quietly."""
        try:
            outcome = super().invoke(ctx)
            sys.stdout.flush()
        except OSError as error:
            discard_output()
            if isinstance(error, BrokenPipeError):
                return BROKEN_PIPE
            return complain(f"{error.strerror or error}", MISUSED)
        return outcome

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a verb by name."""
        if cmd_name not in self.commands and not ctx.resilient_parsing:
            raise UnknownNameError("command", cmd_name, self.list_commands(ctx))
        return super().get_command(ctx, cmd_name)


@contextmanager
def interrupts() -> Iterator[Callable[[], bool]]:
    """Lend a function that tells whether Ctrl-C was pressed meanwhile.

    An engine may turn the KeyboardInterrupt into an error of its own.
    """
    seen: list[int] = []
    before = signal.getsignal(signal.SIGINT)

    def remember(number: int, frame: FrameType | None) -> None:
        seen.append(number)
        if callable(before):
            before(number, frame)

    signal.signal(signal.SIGINT, remember)
    try:
        yield lambda: bool(seen)
    finally:
        signal.signal(signal.SIGINT, before)


def discard_output() -> None:
    """Send what is still to be flushed to standard output nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def complain(message: str, code: int) -> int:
    """Print one line on standard error and return an exit code."""
    click.echo(f"Error: {' '.join(message.split())}", err=True)
    return code


def hinted(error: click.ClickException) -> str:
    """Return the message of a misused command line, and where help is."""
    message = error.format_message().rstrip(".")
    context = getattr(error, "ctx", None)
    return f"{message}; see {context.command_path} --help" if context else message


# Words on the command line


def number(text: str, what: str) -> float:
    """Return a number from the command line.

    Raises
    ------
    UsageError
        If it is none.
    """
    try:
        return float(text)
    except ValueError:
        raise UsageError(f"{what} must be a number, not {text!r}") from None


def assignments(
    context: click.Context, option: click.Parameter, words: tuple[str, ...]
) -> dict[str, float | str]:
    """Return values by name from words NAME=VALUE; some parameters are words themselves.

    Raises
    ------
    UsageError
        If a word is no assignment, or a name stands twice.
    """
    values: dict[str, float | str] = {}
    for word in words:
        name, equals, text = (part.strip() for part in word.partition("="))
        if not (name and equals):
            raise UsageError(f"{option.opts[0]} needs NAME=VALUE, not {word!r}")
        if name in values:
            raise UsageError(f"{option.opts[0]} {name} is given twice")
        try:
            values[name] = float(text)
        except ValueError:
            values[name] = text
    return values


def sample_times(context: click.Context, option: click.Parameter, text: str) -> list[float]:
    """Return times from ``T1,T2,...`` or ``START:STOP:STEP``.

    A range is START + i STEP in decimal arithmetic, STOP included: as exact as it is typed.

    Raises
    ------
    UsageError
        If it is neither.
    """
    if ":" not in text:
        return [number(word.strip(), "--times: a time") for word in text.split(",")]
    words = text.split(":")
    if len(words) != 3:
        raise UsageError(f"--times needs T1,T2,... or START:STOP:STEP, not {text!r}")
    start, stop, step = (decimal(word) for word in words)
    if step <= 0 or stop < start:
        raise UsageError(f"--times {text}: STEP must be positive and STOP not before START")
    intervals = float((stop - start) / step)
    if intervals > MOST_TIMES:
        raise UsageError(f"--times {text}: that is more than {MOST_TIMES} times")
    count = math.floor(intervals * (1 + 1e-12) + 1e-9)
    return [float(start + i * step) for i in range(count + 1)]


def decimal(text: str) -> Decimal:
    """Return a decimal number from the command line.

    Raises
    ------
    UsageError
        If it is none, or too large or small for a float.
    """
    try:
        value = Decimal(text.strip())
    except InvalidOperation:
        raise UsageError(f"--times: a time must be a number, not {text!r}") from None
    if not math.isfinite(float(value)) or (value and not float(value)):
        raise UsageError(f"--times: a time must be finite, not {text!r}")
    return value


def destination(
    context: click.Context, option: click.Parameter, name: str | None
) -> Destination | None:
    """Return where a document goes; refuse at once what cannot be written."""
    return None if name is None else Destination(option.opts[-1], name)


def several(name: str, metavar: str, what: str) -> Callable[[Function], Function]:
    """Return an option that may be repeated."""
    return click.option(
        f"--{name}", f"{name}s", multiple=True, metavar=metavar, help=f"{what} (repeatable)."
    )


def into(name: str, what: str) -> Callable[[Function], Function]:
    """Return an option for where to write a document."""
    return click.option(
        f"--{name}", f"{name}_file", callback=destination, metavar="FILE", help=what
    )


SCENE = click.argument("scene")
SET = click.option(
    "--set",
    "parameters",
    multiple=True,
    callback=assignments,
    metavar="NAME=VALUE",
    help="Change a parameter from its default, SI units (repeatable).",
)
STATE = click.option(
    "--state",
    multiple=True,
    callback=assignments,
    metavar="NAME=VALUE",
    help="Initial value, otherwise 0, SI units (repeatable).",
)
ENGINE = click.option(
    "--engine", default="reference", show_default=True, metavar="ENGINE", help="Who computes it."
)
METHOD = click.option(
    "--method",
    metavar="METHOD",
    help="Integrator as the engine spells it; by default that of highest order.",
)
STEP = click.option("--step", type=float, metavar="H", help="Fixed step [s].")
MODEL = click.option("--model", metavar="NAME", help="One of the engine's models of the scene.")
JSON = into("json", "Write JSON to a file; '-' is standard output, and all else then leaves it.")


# Printing


def console(*destinations: Destination | None) -> Console:
    """Return the console: standard error if a document goes to standard output."""
    from rich.console import Console

    class Outlet(Console):
        """A console that leaves a broken pipe to `Program`."""

        def on_broken_pipe(self) -> None:
            """Pass the error on."""
            raise

    return Outlet(stderr=to_stdout(*destinations), highlight=False)


def to_stdout(*destinations: Destination | None) -> bool:
    """Return whether a document goes to standard output."""
    return any(item is not None and item.standard_output for item in destinations)


def json_text(document: Mapping[str, Any]) -> str:
    """Return a JSON document as text."""
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def csv_text(found: Simulation) -> str:
    """Return a trajectory as CSV: ``t``, then the observables, floats with all digits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["t", *found.observables])
    columns = (found.times.tolist(), *(row.tolist() for row in found.observables.values()))
    writer.writerows(zip(*columns, strict=True))
    return text.getvalue()


def deliver(
    document: Mapping[str, Any],
    printer: Callable[[Console, Any], None],
    found: object,
    json_file: Destination | None,
) -> None:
    """Write a document where it is wanted, and print a table where none goes to stdout."""
    if json_file:
        json_file.write(json_text(document))
    if not to_stdout(json_file):
        printer(console(), found)


@contextmanager
def progress_bar(wanted: bool) -> Iterator[Callable[[int, int], None]]:
    """Show progress on a terminal; lends a function ``(done, total)``.

    Engines run with the descriptors of standard output and error redirected, so the bar
    has a duplicate of its own.
    """
    if not (wanted and sys.stderr.isatty()):
        yield lambda done, total: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn

    with os.fdopen(os.dup(sys.stderr.fileno()), "w") as terminal:
        bar = Progress(
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            console=Console(file=terminal),
            transient=True,
            redirect_stdout=False,
            redirect_stderr=False,
        )
        with bar:
            task = bar.add_task("checks", total=None)
            yield lambda done, total: bar.update(task, completed=done, total=total)


# The verbs


def show_versions(context: click.Context, option: click.Parameter, wanted: bool) -> None:
    """Print the versions of mbcheck and of the engines, and exit."""
    if not wanted or context.resilient_parsing:
        return
    from . import api, catalogue

    click.echo(f"mbcheck {api.own_version()}")
    for entry in catalogue.overview()["engines"]:
        click.echo(f"{entry['name']}: {entry['version'] or entry['reason']}")
    context.exit()


def examples(*lines: str) -> str:
    """Return command lines as the last paragraph of a help text, its line breaks kept."""
    return "\n".join(["\b", "Examples:", *(f"  {line}" for line in lines)])


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
    ),
)
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@several("engine", "ENGINE", "Only this engine")
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
@click.option("--full", is_flag=True, help="Include the cases left out of the default set.")
@click.option("--fail-fast", is_flag=True, help="Stop at the first deviation or error.")
@click.option(
    "-j",
    "--jobs",
    type=click.IntRange(1),
    default=os.cpu_count() or 1,
    help="Processes; by default one for each core.",
)
@click.option("-q", "--quiet", is_flag=True, help="Print the summary line only.")
@click.option("-v", "--verbose", is_flag=True, help="Print every result.")
def check(
    json_file: Destination | None,
    junit_file: Destination | None,
    quiet: bool,
    verbose: bool,
    **selected: Any,
) -> int:
    """Check engines against the reference.

    Every result has an id; a deviation is printed first, with its reason and the command
    that repeats it alone. Exit code 0 if all passed, 1 for any deviation or error, 2 if
    nothing ran.
    """
    if quiet and verbose:
        raise UsageError("--quiet and --verbose contradict each other")
    refuse_conflicts(json_file, junit_file)
    outcome, interrupted = checked(selected, bar=not quiet)
    write_report(outcome, json_file, junit_file)
    from . import report

    command = "mbcheck check"
    command += "" if selected["profile"] == "default" else f" --profile {selected['profile']}"
    command += " --full" if selected["full"] else ""
    report.print_report(
        console(json_file, junit_file),
        outcome.results,
        outcome.versions,
        verbosity=int(verbose) - int(quiet),
        command=command,
        interrupted=interrupted,
    )
    return complain("interrupted", INTERRUPTED) if interrupted else outcome.exit_code


def checked(selected: Mapping[str, Any], bar: bool) -> tuple[Report, bool]:
    """Run checks; return their report, and whether they were interrupted."""
    from . import api

    found: list[Result] = []
    try:
        with progress_bar(bar) as advance, interrupts() as interrupted:

            def progress(done: int, total: int, results: list[Result]) -> None:
                if interrupted():  # and these results are of an engine that was
                    raise KeyboardInterrupt
                found.extend(results)
                advance(done, total)

            return api.check(**selected, progress=progress), False
    except KeyboardInterrupt:
        return api.Report(tuple(found), api.versions(item.engine for item in found)), True


def write_report(
    outcome: Report, json_file: Destination | None, junit_file: Destination | None
) -> None:
    """Write the documents of a report that are wanted."""
    from . import report

    if json_file:
        json_file.write(json_text(outcome.as_json()))
    if junit_file:
        junit_file.write(report.junit(outcome.results))


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
    to hold a simulator of your own against.
    """
    refuse_conflicts(csv_file, json_file)
    from . import api, tables

    found = api.simulate(**asked)
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
    from . import api, tables

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
    from . import api, tables

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
    from . import api

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
    from . import catalogue, tables

    if coverage:
        if scene is not None:
            raise UsageError("--coverage is of all scenes: leave the scene out")
        matrix = catalogue.coverage()
        deliver(matrix, tables.print_coverage, matrix, json_file)
        return
    found = catalogue.overview() if scene is None else catalogue.scene_sheet(scene)
    printer = tables.print_overview if scene is None else tables.print_scene
    deliver(found, printer, found, json_file)


def main() -> NoReturn:
    """Run the command line of this process, and exit."""
    program.main()
