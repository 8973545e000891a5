"""The verb ``mbcheck judge``, which ``mbcheck check --trajectory`` is another name for."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from typing import Any

import click
from click.core import ParameterSource

from ...reference.errors import UsageError
from ..reports.files import Destination, refuse_conflicts
from ..terminal.budget import QUERY, budget_option, budgeted
from ..terminal.page_options import HTML, write_page
from ..terminal.program import (
    JSON,
    JUNIT,
    NUMBER,
    PROFILE,
    QUIET,
    SET,
    STATE,
    WHOLE,
    console,
    examples,
    json_text,
)

ALIAS = ("trajectory", "case", "tolerance", "order", "step")
"""Options of `check` that are for a trajectory alone."""

BOTH = ("parameters", "state", "profile", "json_file", "junit_file", "html_file", "quiet", "budget")
"""Options of `check` that mean the same for a trajectory."""


def options(prefix: str = "") -> tuple[Callable[[click.Command], click.Command], ...]:
    """Return the options of a trajectory, ``prefix`` before the help of each."""
    return (
        click.option("--case", metavar="SCENE/CASE", help=f"{prefix}What it is a run of."),
        click.option(
            "--tolerance",
            type=NUMBER,
            metavar="X",
            help=f"{prefix}Largest error, as a share of an observable's largest value.",
        ),
        click.option(
            "--order",
            type=WHOLE,
            metavar="P",
            help=f"{prefix}Order of the method, from which tolerances follow with --step.",
        ),
        click.option(
            "--step", type=NUMBER, metavar="H", help=f"{prefix}Fixed step of the run [s]."
        ),
    )


@click.command(
    "judge",
    epilog=examples(
        "mbcheck judge run.csv --case hula_hoop/rod_aligned",
        "mbcheck judge run.csv --case hula_hoop/rod_aligned --order 4 --step 1e-3",
        "mbcheck judge - --case hula_hoop/rod_aligned --tolerance 1e-3 < run.csv",
    ),
)
@click.argument("trajectory", metavar="FILE")
@SET
@STATE
@PROFILE
@JSON
@JUNIT
@HTML
@QUIET
@budget_option(QUERY)
def judge_verb(**asked: Any) -> int:
    """Judge a trajectory that was computed elsewhere.

    FILE is CSV with the columns t and observables, as `mbcheck simulate --csv` writes it; '-'
    is standard input. Errors are those against the reference of the case, at the times of the
    file. Exit codes are those of `check`; without a tolerance nothing is judged.
    """
    if asked["case"] is None:
        raise UsageError("judge needs --case SCENE/CASE; `mbcheck list SCENE` shows them")
    return judge_file(**asked)


for option in options():
    option(judge_verb)


def with_trajectory(check: click.Command) -> click.Command:
    """Return `check` with the options by which it judges a trajectory in place of its engines."""
    run_checks = check.callback
    assert run_checks is not None

    def either(**values: Any) -> Any:
        asked = {name: values.pop(name) for name in ALIAS}
        if is_trajectory(click.get_current_context()):
            return judge_file(**asked, **{name: values[name] for name in BOTH})
        return run_checks(**values)

    check.callback = either
    click.option("--trajectory", metavar="FILE", help="Judge this file, as `mbcheck judge` does.")(
        check
    )
    for option in options("Of --trajectory: "):
        option(check)
    return check


def is_trajectory(context: click.Context) -> bool:
    """Return whether `check` is to judge a trajectory; refuse what makes no sense beside it.

    Raises
    ------
    UsageError
        For options of the one kind of check with the other.
    """
    used = [
        item
        for item in context.command.params
        if item.name and context.get_parameter_source(item.name) is ParameterSource.COMMANDLINE
    ]
    names = {item.name for item in used}
    for item in used:
        word = item.opts[-1] if item.opts[-1].startswith("-") else "a scene"
        if "trajectory" in names and item.name not in (*ALIAS, *BOTH):
            raise UsageError(f"--trajectory judges one file: it does not go with {word}")
        if "trajectory" not in names and item.name in ALIAS:
            raise UsageError(f"{word} is for a trajectory of your own: add --trajectory FILE")
    if "trajectory" in names and "case" not in names:
        raise UsageError("--trajectory needs --case SCENE/CASE; `mbcheck list SCENE` shows them")
    return "trajectory" in names


def judge_file(
    json_file: Destination | None,
    junit_file: Destination | None,
    html_file: Destination | None,
    quiet: bool,
    budget: float,
    **asked: Any,
) -> int:
    """Judge a trajectory as asked for; write its documents, print it, return the exit code.

    Raises
    ------
    UsageError
    """
    from ..reports.run.junit import junit
    from . import report
    from .judge import judge_trajectory

    refuse_conflicts(json_file, junit_file, html_file)
    for file in (junit_file, html_file):
        if file and asked["tolerance"] is None and asked["order"] is None:
            raise UsageError(
                f"{file.option} needs verdicts: add --tolerance, or --order and --step"
            )
    with budgeted(budget, "reference"):
        judgement = judge_trajectory(**asked)
    outcome = report.as_report(judgement, repeating(**asked))
    if json_file:
        json_file.write(json_text(judgement.as_json()))
    if junit_file:
        junit_file.write(junit(outcome))
    if html_file:
        write_page(html_file, outcome)
    report.print_judgement(console(json_file, junit_file), judgement, quiet)
    return judgement.exit_code


def repeating(
    trajectory: str, case: str, parameters: dict[str, Any], state: dict[str, Any], **more: Any
) -> str:
    """Return the command that judges the same trajectory again; ``more`` are further options."""
    words = ["mbcheck", "judge", trajectory, "--case", case]
    for option, values in (("--set", parameters), ("--state", state)):
        for name, value in values.items():
            words += [option, f"{name}={value}"]
    for name, value in more.items():
        if value not in (None, "default"):
            words += [f"--{name}", str(value)]
    return shlex.join(words)
