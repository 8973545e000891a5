"""Common parts of all verbs: exit codes, options, printing, progress."""

from __future__ import annotations

import json
import os
import shutil
import signal
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path
from signal import SIGINT, SIGTERM
from time import monotonic
from types import FrameType
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

import click

from ...reference.errors import MbcheckError, UsageError
from ..reports.files import Destination, collect_unwritten, discard_output
from ..reports.words import broken_lines, printable, shell_lines
from .options import NUMBER

if TYPE_CHECKING:
    from rich.console import Console


FAILED, MISUSED, INTERRUPTED, BROKEN_PIPE = 1, 2, 130, 141
"""Exit codes besides 0; the last two are those of a program ended by a signal, as is 143, of
SIGTERM."""

LONGEST = 299
"""Characters of an error message."""

PAUSE = 10.0
"""Seconds between two lines of progress."""

HELP_WIDTH = 76
"""Columns of a help text, which click indents."""

LEAST_SHARE = 0.02
"""Share of the work after which the remaining time is estimated."""

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
            with collect_unwritten() as unwritten:
                code = self.outcome(*args, **extra)
            if any(isinstance(error, BrokenPipeError) for error in unwritten.values()):
                return BROKEN_PIPE
            for words in unwritten:
                code = complain(words, code or FAILED)
            if interrupted() and code != INTERRUPTED:
                complain("interrupted", INTERRUPTED)
            return 128 + interrupted() if interrupted() else code

    def outcome(self, *args: Any, **extra: Any) -> int:
        """Run a command line; print its error in one line, and return its exit code."""
        extra.update(prog_name="mbcheck", standalone_mode=False)
        try:
            return int(super().main(*args, **extra) or 0)
        except click.ClickException as error:
            return complain(hinted(error), MISUSED)
        except UsageError as error:
            return complain(str(error), MISUSED)
        except MbcheckError as error:
            return complain(str(error), FAILED)
        except (ArithmeticError, ValueError) as error:
            if not isinstance(error, ArithmeticError) and type(error).__name__ != "LinAlgError":
                raise
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
            return complain(f"{error.strerror or error}", FAILED)
        return outcome


@contextmanager
def interrupts() -> Iterator[Callable[[], int]]:
    """Yield a function that returns the signal that interrupts the program, or 0.

    Ctrl-C and SIGTERM both raise a KeyboardInterrupt, which an engine may catch.
    """
    seen: list[int] = []

    def remember(number: int, frame: FrameType | None) -> None:
        seen.append(number)
        before = handlers[signal.Signals(number)]
        (before if callable(before) else signal.default_int_handler)(number, frame)

    handlers = {int(number): signal.signal(number, remember) for number in (SIGINT, SIGTERM)}
    try:
        yield lambda: seen[0] if seen else 0
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)


def complain(message: str, code: int) -> int:
    """Print one line on standard error, wrapped on a terminal, and return an exit code."""
    line = one_line(f"Error: {message}")
    if sys.stderr.isatty():
        line = "\n".join(broken_lines(line, shutil.get_terminal_size().columns, "", "  "))
    click.echo(line, err=True)
    return code


def one_line(message: str) -> str:
    """Return a message in one line of printable characters, its middle left out if it is long."""
    text = printable(" ".join(message.split()))
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 105]} ... {text[-100:]}"


def hinted(error: click.ClickException) -> str:
    """Return the message of a misused command line, and where help is."""
    message = error.format_message().rstrip(".")
    context = getattr(error, "ctx", None)
    return f"{message}; see {context.command_path} --help" if context else message


# Options


def destination(
    context: click.Context, option: click.Parameter, name: str | None
) -> Destination | None:
    """Return where a document goes; refuse at once what cannot be written."""
    return None if name is None else Destination(option.opts[-1], name)


def into(name: str, what: str) -> Callable[[Function], Function]:
    """Return an option for where to write a document."""
    return click.option(
        f"--{name}", f"{name}_file", callback=destination, metavar="FILE", help=what
    )


def page_of(
    context: click.Context, option: click.Parameter, name: str | None
) -> Destination | None:
    """Return the page in a folder; refuse at once what cannot be written."""
    if name is None:
        return None
    from ..reports.run.page import page_file

    return page_file(name)


HTML = click.option(
    "--html",
    "html_file",
    callback=page_of,
    metavar="DIR",
    help="Write a page into a folder: DIR/index.html, with pictures of deviations.",
)
JUNIT = into("junit", "Write JUnit XML to a file, or '-'.")
SARIF = into("sarif", "Write SARIF, for code scanning, to a file or '-'.")
BADGE = into("badge", "Write a badge for shields.io (endpoint JSON) to a file, or '-'.")
QUIET = click.option("-q", "--quiet", is_flag=True, help="Print the summary line only.")
JSON = into("json", "Write JSON to a file; '-' is standard output, which then has nothing else.")
MARKDOWN = into("markdown", "Write the tables as Markdown to a file, or '-'.")
PLOT = click.option("--plot", callback=destination, metavar="FILE", help="Draw it: .png or .svg.")


QUERY, MAP = 600.0, 86400.0
"""Default budgets of a query and of a map [s]."""


def budget_option(seconds: float) -> Callable[[Any], Any]:
    """Return the option, with its default [s]."""
    return click.option(
        "--budget",
        type=NUMBER,
        default=seconds,
        show_default=True,
        metavar="SECONDS",
        help="Refuse work with a longer estimated time.",
    )


@contextmanager
def budgeted(seconds: float, what: str) -> Iterator[None]:
    """Work within a budget [s], and show progress on a terminal or line by line."""
    from ...reference.cost import within

    with (
        progress_bar(True, f"parts of {what}", lines=True) as advance,
        within(seconds, lambda share, _: advance(round(100 * share), 100)),
    ):
        yield


def refuse_picture(plot: Destination | None) -> None:
    """Refuse a picture of a kind that cannot be drawn, before any work is done."""
    if plot is None:
        return
    from ..reports.drawing import SUFFIXES, import_pyplot

    if plot.standard_output or Path(plot.name).suffix.lower() not in SUFFIXES:
        raise UsageError(f"--plot needs a file that ends in {' or '.join(SUFFIXES)}")
    import_pyplot()


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
    """Return True if a document goes to standard output."""
    return any(item is not None and item.standard_output for item in destinations)


def json_text(document: Mapping[str, Any]) -> str:
    """Return a JSON document as text."""
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def deliver(
    result: Any, printer: Callable[[Console, Any], None], json_file: Destination | None
) -> None:
    """Write the document of a result where it is wanted; print it where none goes to stdout."""
    if json_file:
        document = result if isinstance(result, Mapping) else result.as_json()
        json_file.write(json_text(document))
    if not to_stdout(json_file):
        printer(console(), result)


def time_left(seconds: float, share: float) -> str:
    """Return the remaining time of work in words, from a share and its time [s]."""
    if share < LEAST_SHARE:
        return ""
    left = max(0.0, seconds * (1 - share) / share)
    return f"about {left:.0f} s left" if left < 100 else f"about {left / 60:.0f} min left"


@contextmanager
def progress_bar(wanted: bool, what: str, lines: bool = False) -> Iterator[Callable[..., None]]:
    """Show progress on a terminal; yields a function ``(done, total, what, share)``.

    Engines run with the descriptors of standard output and error redirected, so the bar has a
    duplicate. With ``lines`` a log gets a line every `PAUSE`. The share of finished work is
    ``done / total`` unless it is given.
    """
    begin = monotonic()
    if not (wanted and sys.stderr.isatty()):
        with progress_lines(what, begin) if wanted and lines else nullcontext(unseen) as advance:
            yield advance
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    with os.fdopen(os.dup(sys.stderr.fileno()), "w") as terminal:
        bar = Progress(
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.description}", markup=False),
            console=Console(file=terminal),
            transient=True,
            redirect_stdout=False,
            redirect_stderr=False,
        )
        with bar:
            task = bar.add_task(what, total=None)

            def advance_bar(
                done: int, total: int, now: str = what, share: float | None = None
            ) -> None:
                share = done / total if share is None else share
                left = time_left(monotonic() - begin, share)
                words = ", ".join(filter(None, (printable(now), left)))
                bar.update(task, completed=done, total=total, description=words)

            yield advance_bar


def unseen(done: int, total: int, now: str = "", share: float | None = None) -> None:
    """Show nothing."""


@contextmanager
def progress_lines(what: str, begin: float) -> Iterator[Callable[..., None]]:
    """Report progress on standard error, a line every `PAUSE`."""
    try:
        own = os.dup(sys.stderr.fileno())
    except (OSError, ValueError):  # it is no file
        yield unseen
        return
    last = begin
    with os.fdopen(own, "w") as log:

        def advance(done: int, total: int, now: str = what, share: float | None = None) -> None:
            nonlocal last
            if monotonic() - last < PAUSE:
                return
            last = monotonic()
            left = time_left(last - begin, done / total if share is None else share)
            words = f"{done} of {total} {printable(now)}, {last - begin:.0f} s"
            log.write(", ".join(filter(None, (words, left))) + "\n")
            log.flush()

        yield advance


def finished(states: Iterable[tuple[int, int, str]], what: str) -> bool:
    """Follow work that yields ``(done, total, what)`` to its end; return False if interrupted."""
    try:
        with progress_bar(True, what, lines=True) as advance, interrupts() as pressed:
            for state in states:
                advance(*state)
                if pressed():
                    return False
    except KeyboardInterrupt:
        return False
    return True


def examples(*commands: str) -> str:
    """Return shell commands as the last paragraph of a help text, its line breaks kept."""
    lines = [line for one in commands for line in shell_lines(f"  {one}", HELP_WIDTH)]
    return "\n".join(["\b", "Examples:", *lines])
