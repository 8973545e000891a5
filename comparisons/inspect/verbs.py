"""The verb ``mbcheck inspect``."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

from ...reference.errors import MbcheckError, UnknownNameError, UsageError
from ..reports.files import refuse_conflicts
from ..terminal.program import (
    JSON,
    JUNIT,
    MISUSED,
    NUMBER,
    assignments,
    complain,
    console,
    destination,
    examples,
    into,
    json_text,
    progress_bar,
    several,
    to_stdout,
)

if TYPE_CHECKING:
    from .batch import Inspections, InspectRequest

DOCUMENTS = ("json", "junit", "sarif")
"""Options that write a document, which may go to standard output."""


@click.command(
    epilog=examples(
        "mbcheck inspect model.xml",
        "mbcheck inspect model.xml --full --about-rotation theta=10",
        "mbcheck inspect robots/ 'scenes/*.xml' --fail-on warning --sarif found.sarif",
        "mbcheck inspect model.xml --strict --ignore 'unused_*'",
        "mbcheck inspect --diff old.xml new.xml",
        "mbcheck inspect model.xml --fix --dry-run",
        "mbcheck inspect --explain step_limit",
    ),
)
@click.argument("models", nargs=-1, metavar="[MODEL.xml|FOLDER|PATTERN]...")
@click.option(
    "--about-rotation",
    "rotation",
    multiple=True,
    callback=assignments,
    metavar="JOINT=SPEED",
    help="Also find the modes about the steady rotation of a hinge [rad/s].",
)
@click.option(
    "--modes/--no-modes",
    default=None,
    help="Find modes of models of any size, or of none; by default up to 120 degrees of freedom.",
)
@click.option("--full", is_flag=True, help="Print all tables, and every finding.")
@click.option("--lines", is_flag=True, help="Print a line for each finding, as of many files.")
@click.option("--strict", is_flag=True, help="Look for matters of taste, too: rules of the house.")
@several("select", "RULE", "Ask this rule, and no others but those selected; * is a wildcard")
@several("ignore", "RULE", "Leave out this rule; * is a wildcard")
@click.option(
    "--budget",
    type=NUMBER,
    metavar="SECONDS",
    help="Begin nothing after this time, and tell what was left out; by default all is done.",
)
@click.option(
    "--fail-on",
    type=click.Choice(["error", "warning", "note", "never"]),
    default="error",
    show_default=True,
    help="The least severity that makes exit code 1.",
)
@click.option(
    "--waivers",
    metavar="FILE.toml",
    help="Waivers with their reasons; by default mbcheck-inspect.toml beside the model, if any.",
)
@click.option("--baseline", metavar="FILE", help="Waive what --write-baseline wrote there.")
@click.option(
    "--write-baseline",
    "write_baseline_file",
    callback=destination,
    metavar="FILE",
    help="Write all that is found now to a file for --baseline.",
)
@JSON
@JUNIT
@into("sarif", "Write SARIF, for code scanning, to a file or '-'.")
@click.option(
    "--annotations/--no-annotations",
    default=None,
    help="Print annotations for GitHub; by default where GITHUB_ACTIONS is true.",
)
@click.option(
    "--diff",
    "compare",
    is_flag=True,
    help="Compare two models, OLD.xml NEW.xml; exit code 1 for findings that are new.",
)
@click.option(
    "--fix",
    is_flag=True,
    help="Leave out attributes without which the file compiles to the same to the last bit.",
)
@click.option("--dry-run", is_flag=True, help="With --fix: print the edits, and make none.")
@click.option("--explain", metavar="RULE", help="Tell what a rule finds and why; 'all' lists them.")
def inspect(models: tuple[str, ...], **options: Any) -> int:
    """Inspect MJCF models: what is wrong in them, how they move, what they could do without.

    Findings, each with its rule, reason and fix; natural frequencies and damping at each keyframe;
    the largest stable step of each integrator; how far soft loops open. A comment in the file
    waives a finding: <!-- mbcheck: allow RULE, ELEMENT: REASON -->. Exit code 1 if an error (see
    --fail-on) is not waived, or a dry run of --fix would change something, 2 if a file cannot be
    read.
    """
    if options["explain"] is not None:
        explain_rule(options["explain"])
        if not models:
            return 0
    if not models:
        raise UsageError("which file? mbcheck inspect MODEL.xml")
    documents = [options[f"{name}_file"] for name in (*DOCUMENTS, "write_baseline")]
    refuse_conflicts(*documents)
    from .batch import InspectRequest, files_of

    request = InspectRequest(
        options["strict"],
        options["selects"],
        options["ignores"],
        options["waivers"],
        options["baseline"],
    )
    request.rules()  # a slip of the pen is told before anything is read
    if options["dry_run"] and not options["fix"]:
        raise UsageError("--dry-run is for --fix")
    if options["compare"]:
        if options["fix"]:
            raise UsageError("--fix is of files: leave out --diff")
        return inspect_two(models, request, options)
    single = len(models) == 1 and not os.path.isdir(models[0])
    files = files_of(models)
    if options["fix"]:
        code = fix_files(files, request, options)
        if options["dry_run"] or code == MISUSED:
            return code
    if single and files == list(models):
        return inspect_one(models[0], request, options)
    refuse_single(options)
    return inspect_many(files, request, options)


def inspect_one(model: str, request: InspectRequest, options: Mapping[str, Any]) -> int:
    """Inspect a model: its report and its documents; return the exit code."""
    from . import console as output
    from . import inspection
    from .batch import Inspections
    from .pace import Pace

    selection = request.selection(model)
    with progress_bar(True, "inspect", lines=True) as progress:
        pace = Pace(budget_of(options), progress)
        result = inspection.inspect(
            model, options["rotation"], options["modes"], request.strict, selection, pace
        )
    every = Inspections((result,))
    if options["json_file"]:
        options["json_file"].write(json_text(result.as_json()))
    write_documents(every, options)
    quiet = to_stdout(*(options[f"{name}_file"] for name in DOCUMENTS))
    if options["lines"] and not quiet:
        output.print_lines(console(), every, options["fail_on"])
    elif not quiet:
        output.print_inspection(console(), result, options["full"], options["fail_on"])
    annotate(every, options)
    return every.exit_code(options["fail_on"])


def fix_files(files: Sequence[str], request: InspectRequest, options: Mapping[str, Any]) -> int:
    """Leave out what models do without; return 1 if a dry run would, 2 if a file is not read."""
    from .batch import named_once
    from .fixes import neutral_edit
    from .inspection import inspect as inspect_model
    from .pace import Pace

    code, pace = 0, Pace(budget_of(options))
    for file in files:
        selection = request.fixing().selection(file)
        try:
            own = pace.remaining()
            edit = neutral_edit(inspect_model(file, modes=False, selection=selection, pace=own))
        except MbcheckError as error:
            code = complain(named_once(file, str(error)), MISUSED)
            continue
        if options["dry_run"]:
            click.echo(edit.diff, nl=False)
            code = code or int(bool(edit.attributes))
        else:
            edit.write()
        click.echo(edit.summary, err=True)
        if own.omissions:
            click.echo(f"{file}: {own.omissions}", err=True)
    return code


def inspect_two(models: Sequence[str], request: InspectRequest, options: Mapping[str, Any]) -> int:
    """Print what differs between two models; return the exit code."""
    from . import console as output
    from .batch import FAIL_ON
    from .difference import model_difference
    from .inspection import inspect as inspect_model

    if len(models) != 2:
        raise UsageError("--diff compares two models: OLD.xml NEW.xml")
    refuse_single(options)
    if any(options[f"{name}_file"] for name in (*DOCUMENTS, "write_baseline")):
        raise UsageError("--diff prints a table, and writes no document")
    old, new = (
        inspect_model(name, None, options["modes"], request.strict, request.selection(name))
        for name in models
    )
    result = model_difference(old, new)
    output.print_difference(console(), result)
    return int(any(one.severity in FAIL_ON[options["fail_on"]] for one in result.new))


def inspect_many(files: Sequence[str], request: InspectRequest, options: Mapping[str, Any]) -> int:
    """Inspect several models: a line for each finding, their documents; return the exit code."""
    from . import console as output
    from .batch import inspect_files, named_once
    from .pace import Pace

    with progress_bar(True, "inspect", lines=True) as progress:
        pace = Pace(budget_of(options), progress)
        every = inspect_files(files, request, options["modes"], pace)
    if options["json_file"]:
        options["json_file"].write(json_text(every.as_json()))
    write_documents(every, options)
    if not to_stdout(*(options[f"{name}_file"] for name in DOCUMENTS)):
        output.print_lines(console(), every, options["fail_on"])
    annotate(every, options)
    for file, why in every.unreadable.items():
        complain(named_once(file, why), MISUSED)
    return every.exit_code(options["fail_on"])


def budget_of(options: Mapping[str, Any]) -> float:
    """Return the time that there is [s]."""
    return math.inf if options["budget"] is None else float(options["budget"])


def refuse_single(options: Mapping[str, Any]) -> None:
    """Refuse options that are about one model where there are several.

    Raises
    ------
    UsageError
    """
    for name in ("rotation", "full"):
        if options[name]:
            option = "about-rotation" if name == "rotation" else name
            raise UsageError(f"--{option} is for one model")


def write_documents(every: Inspections, options: Mapping[str, Any]) -> None:
    """Write what is the same for one model and for many."""
    from ..queries.environment import versions
    from ..reports.remarks import junit_of_files, sarif
    from .batch import FAIL_ON
    from .rules.table import RULES

    remarks = every.remarks()
    if options["junit_file"]:
        fails = FAIL_ON[options["fail_on"]]
        text = junit_of_files(every.files, remarks, fails, every.unreadable)
        options["junit_file"].write(text)
    if options["sarif_file"]:
        rules = {name: (rule.meaning, rule.why) for name, rule in RULES.items()}
        options["sarif_file"].write(sarif(remarks, rules, versions(())["mbcheck"]))
    if options["write_baseline_file"]:
        options["write_baseline_file"].write(every.baseline())


def annotate(every: Inspections, options: Mapping[str, Any]) -> None:
    """Print annotations for GitHub, where they are asked for."""
    from ..reports.remarks import github_annotations
    from ..reports.run.github import wants_annotations

    if wants_annotations(options["annotations"]):
        err = to_stdout(*(options[f"{name}_file"] for name in DOCUMENTS))
        for line in github_annotations(every.remarks()):
            click.echo(line, err=err)


def explain_rule(name: str) -> None:
    """Print what a rule is, or which there are.

    Raises
    ------
    UnknownNameError
        If there is no such rule.
    """
    from .console import print_rule, print_rules
    from .rules.table import RULES

    if name == "all":
        print_rules(console())
    elif name in RULES:
        print_rule(console(), name)
    else:
        raise UnknownNameError("rule", name, (*RULES, "all"))
