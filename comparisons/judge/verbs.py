"""What ``mbcheck check --trajectory`` takes on the command line, and how it is answered."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any

import click
from click.core import ParameterSource

from ...reference.errors import UsageError
from ..checks.verdict import Result
from ..reports.files import Destination, refuse_conflicts
from ..terminal.page_options import write_page
from ..terminal.program import SET, STATE, console, json_text

OPTIONS = (
    click.option(
        "--trajectory",
        metavar="FILE",
        help="Judge a trajectory that was computed elsewhere: CSV with the columns t and "
        "observables, as `mbcheck simulate --csv` writes it; '-' is standard input.",
    ),
    click.option("--case", metavar="SCENE/CASE", help="Of --trajectory: what it is a run of."),
    SET,
    STATE,
    click.option(
        "--tolerance",
        type=float,
        metavar="X",
        help="Of --trajectory: largest error, as a share of an observable's largest value.",
    ),
    click.option(
        "--order",
        type=int,
        metavar="P",
        help="Of --trajectory: order of the method, from which tolerances follow with --step.",
    ),
    click.option("--step", type=float, metavar="H", help="Of --trajectory: its fixed step [s]."),
)

ASKED = ("trajectory", "case", "parameters", "state", "tolerance", "order", "step")
"""Names of these options as arguments."""

TOO = ("profile", "json_file", "junit_file", "html_file", "quiet")
"""Options of `check` that make sense with a trajectory."""


def or_trajectory(verb: Callable[..., int]) -> Callable[..., int]:
    """Let a verb judge a trajectory in place of what it does, where it is given one."""

    @click.pass_context
    @wraps(verb)
    def either(context: click.Context, **options: Any) -> int:
        asked = {name: options.pop(name) for name in ASKED}
        if refuse_mixture(context):
            return judge_file(**asked, **{name: options[name] for name in TOO})
        return verb(**options)

    for option in reversed(OPTIONS):
        either = option(either)
    return either


def given(context: click.Context) -> list[click.Parameter]:
    """Return the options and arguments that stand on the command line."""
    return [
        item
        for item in context.command.params
        if item.name and context.get_parameter_source(item.name) is ParameterSource.COMMANDLINE
    ]


def refuse_mixture(context: click.Context) -> bool:
    """Return whether a trajectory is to be judged; refuse what makes no sense beside it.

    Raises
    ------
    UsageError
        For options of the one kind of check with the other.
    """
    used = given(context)
    judged = any(item.name == "trajectory" for item in used)
    for item in used:
        word = item.opts[-1] if item.opts[-1].startswith("-") else "a scene"
        if judged and item.name not in (*ASKED, *TOO):
            raise UsageError(f"--trajectory judges one file: it does not go with {word}")
        if not judged and item.name in ASKED:
            raise UsageError(f"{word} is for a trajectory of your own: add --trajectory FILE")
    if judged and not any(item.name == "case" for item in used):
        raise UsageError("--trajectory needs --case SCENE/CASE; `mbcheck list SCENE` shows them")
    return judged


def judge_file(
    json_file: Destination | None,
    junit_file: Destination | None,
    html_file: Destination | None,
    quiet: bool,
    **asked: Any,
) -> int:
    """Judge a trajectory as asked for; write its documents, print it, return the exit code.

    Raises
    ------
    UsageError
    """
    from ..reports import report
    from . import judge

    refuse_conflicts(json_file, junit_file, html_file)
    for file in (junit_file, html_file):
        if file and asked["tolerance"] is None and asked["order"] is None:
            raise UsageError(
                f"{file.option} needs verdicts: add --tolerance, or --order and --step"
            )
    found = judge.judge_trajectory(**asked)

    def repeat(result: Result) -> str:
        return repeating(asked)

    if json_file:
        json_file.write(json_text(found.as_json()))
    if junit_file:
        junit_file.write(report.junit(found.results, found.versions, repeat=repeat))
    if html_file:
        write_page(html_file, judge.as_report(found), repeat)
    judge.print_judgement(console(json_file, junit_file), found, quiet)
    return found.exit_code


def repeating(asked: Mapping[str, Any]) -> str:
    """Return the command that judges the same trajectory again."""
    words = ["mbcheck", "check", "--trajectory", asked["trajectory"], "--case", asked["case"]]
    for option, values in (("--set", asked["parameters"]), ("--state", asked["state"])):
        for name, value in values.items():
            words += [option, f"{name}={value}"]
    for name in ("tolerance", "order", "step"):
        if asked[name] is not None:
            words += [f"--{name}", f"{asked[name]}"]
    if asked["profile"] != "default":
        words += ["--profile", asked["profile"]]
    return shlex.join(words)
