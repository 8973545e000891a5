"""The verb ``mbcheck check``; docs/ci.md is the page of its options for CI."""

from __future__ import annotations

import os
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from ...reference.errors import UsageError
from ..checks.request import CheckRequest, Execution
from ..reports.files import Destination, refuse_conflicts
from ..terminal.options import with_options_of
from ..terminal.program import (
    BADGE,
    HTML,
    INTERRUPTED,
    JSON,
    JUNIT,
    MARKDOWN,
    QUERY,
    QUIET,
    SARIF,
    budget_option,
    budgeted,
    complain,
    console,
    destination,
    examples,
    interrupts,
    json_text,
    progress_bar,
    to_stdout,
)

if TYPE_CHECKING:
    from ..checks.verdict import Result
    from ..reports.run.outcome import Report
    from .request import CheckPlan


def new_file(
    context: click.Context, option: click.Parameter, name: str | None
) -> Destination | None:
    """Return where a document goes that replaces nothing.

    Raises
    ------
    UsageError
        If there is a file of that name, or it cannot be written.
    """
    if name is not None and os.path.lexists(name):
        raise UsageError(f"{option.opts[0]}: {name!r} exists already: give another name")
    return destination(context, option, name)


@click.command(
    "check",
    epilog=examples(
        "mbcheck check",
        "mbcheck check --quick --engine mujoco",
        "mbcheck check hula_hoop --engine mujoco --kind trajectory -v",
        "mbcheck check --id '*/point_mass_3hz_60n/order/*' --profile strict",
        "mbcheck check --source validation hula_hoop --full",
        "mbcheck check -j 2 --json report.json --junit report.xml",
        "mbcheck check --known mbcheck-known.toml --strict-known --markdown summary.md",
        "mbcheck check hula_hoop --set force_amplitude=80 --state theta=0.3 --horizon 1",
        "mbcheck check hula_hoop --placement turned:7 --kind parts --kind algebra",
    ),
)
@with_options_of(CheckRequest, Execution)
@JSON
@JUNIT
@SARIF
@MARKDOWN
@BADGE
@click.option(
    "--write-known",
    "draft_file",
    callback=new_file,
    metavar="FILE",
    help="Write all current failures to a new --known file, to be annotated.",
)
@click.option(
    "--annotations/--no-annotations",
    default=None,
    help="Print annotations for GitHub; by default where GITHUB_ACTIONS is true.",
)
@HTML
@click.option(
    "--in-process",
    is_flag=True,
    help="Run third-party engines in this process, for a debugger: their output is shown, and a "
    "crash ends the run.",
)
@budget_option(QUERY)
@QUIET
@click.option("-v", "--verbose", is_flag=True, help="Print every result and traceback.")
def check_verb(
    json_file: Destination | None,
    junit_file: Destination | None,
    sarif_file: Destination | None,
    markdown_file: Destination | None,
    badge_file: Destination | None,
    draft_file: Destination | None,
    annotations: bool | None,
    html_file: Destination | None,
    quiet: bool,
    budget: float,
    verbose: bool,
    in_process: bool,
    **options: Any,
) -> int:
    """Check engines against the reference.

    Every result has an id; a deviation is printed first, with its reason and the command
    that repeats it alone. Exit code 0 if all passed or is known, 1 for any other deviation
    or error, 2 if nothing ran.

    With --set, --state or --horizon engines are checked at these parameters of one scene, in
    place of its cases. What the reference cannot judge there is refused or skipped, with why.
    """
    if quiet and verbose:
        raise UsageError("--quiet and --verbose contradict each other")
    files = (json_file, junit_file, sarif_file, markdown_file, badge_file, draft_file, html_file)
    refuse_conflicts(*files)
    from ..checks import known
    from ..engines.registry import in_this_process
    from ..reports import github
    from ..reports.run import sections
    from ..reports.run.page import write_reports
    from .request import CheckRun, plan_checks

    asked = CheckRun(**options)
    names = options["engines"]
    lent = in_this_process(names) if in_process else nullcontext(names)
    with lent as engines:
        asked = replace(asked, engines=engines)
        with (
            asked.limited(),
            budgeted(budget, "reference"),  # which finds out whether it can judge a user's case
        ):
            plan = plan_checks(asked)
        outcome = checked(plan, asked, bar=not quiet)
    if json_file:
        json_file.write(json_text(outcome.as_json()))
    write_reports(
        outcome,
        junit=junit_file,
        sarif=sarif_file,
        badge=badge_file,
        markdown=markdown_file,
        html=html_file,
    )
    if draft_file and not outcome.interrupted:
        draft_file.write(known.draft(outcome.results))
    github.append_step_summary(sections.run_summary(outcome))
    items = partial(sections.run_annotations, outcome)
    with github.annotated(items, annotations, err=to_stdout(*files)):
        sections.print_report(console(*files), outcome, verbosity=int(verbose) - int(quiet))
    if outcome.interrupted:
        return complain("interrupted", INTERRUPTED)
    return outcome.exit_code


def checked(plan: CheckPlan, execution: Execution, bar: bool) -> Report:
    """Run checks, until they are interrupted; return their report."""
    results: list[Result] = []
    try:
        efforts = {one.prefix: one.effort for one in plan.checks}
        left = whole = sum(efforts.values())
        with progress_bar(bar, "checks", lines=True) as advance, interrupts() as interrupted:

            def progress(done: int, total: int, arrived: list[Result]) -> None:
                if interrupted():  # and these results are of an engine that was
                    raise KeyboardInterrupt
                nonlocal left
                results.extend(arrived)
                left -= sum(efforts.pop(one, 0) for one in {item.prefix for item in arrived})
                advance(done, total, share=1 - left / whole)

            return plan.report(plan.run(execution, progress))
    except KeyboardInterrupt:
        return replace(plan.report(results), interrupted=True)
