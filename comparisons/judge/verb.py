"""The verb ``mbcheck judge``."""

from __future__ import annotations

import shlex
from typing import Any

import click

from ...reference.errors import UsageError
from ..reports.files import Destination, refuse_conflicts
from ..terminal.options import with_options_of
from ..terminal.program import (
    HTML,
    JSON,
    JUNIT,
    QUERY,
    QUIET,
    budget_option,
    budgeted,
    console,
    examples,
    json_text,
)
from .judge import JudgeRequest, judge_trajectory


@click.command(
    "judge",
    epilog=examples(
        "mbcheck judge run.csv --case hula_hoop/rod_aligned",
        "mbcheck judge run.csv --case hula_hoop/rod_aligned --order 4 --step 1e-3",
        "mbcheck judge - --case hula_hoop/rod_aligned --tolerance 1e-3 < run.csv",
    ),
)
@with_options_of(JudgeRequest)
@JSON
@JUNIT
@HTML
@QUIET
@budget_option(QUERY)
def judge_verb(
    json_file: Destination | None,
    junit_file: Destination | None,
    html_file: Destination | None,
    quiet: bool,
    budget: float,
    **asked: Any,
) -> int:
    """Judge a trajectory that was computed elsewhere.

    FILE is CSV with the columns t and observables, as `mbcheck simulate --csv` writes it; '-'
    is standard input. Errors are those against the reference of the case, at the times of the
    file. Exit codes are those of `check`; without a tolerance nothing is judged.
    """
    from ..reports.run.page import write_reports
    from . import report

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
    write_reports(outcome, junit=junit_file, html=html_file)
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
