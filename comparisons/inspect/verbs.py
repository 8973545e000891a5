"""The verb ``mbcheck inspect``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Any

import click

from ...reference.errors import MbcheckError, UnknownNameError, UsageError
from ..reports.files import refuse_conflicts
from ..terminal.options import NUMBER, assignments
from ..terminal.program import (
    JSON,
    JUNIT,
    MISUSED,
    SARIF,
    complain,
    console,
    examples,
    json_text,
    progress_bar,
    several,
    to_stdout,
)

if TYPE_CHECKING:
    from rich.console import Console

    from ..reports.item import ReportItem
    from .batch import Inspections, InspectRequest
    from .sandbox import Sandbox

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
    )
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
    "--whole-models",
    is_flag=True,
    help="Leave out files that are no MJCF, or that another one includes, as of folders.",
)
@click.option(
    "--budget",
    type=NUMBER,
    metavar="SECONDS",
    help="Stop after this time, and report what was found until then; by default all is done.",
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
@click.option("--baseline", metavar="FILE", help="Waive what a document of --json has found.")
@JSON
@JUNIT
@SARIF
@click.option(
    "--annotations/--no-annotations",
    default=None,
    help="Print annotations for GitHub; by default where GITHUB_ACTIONS is true.",
)
@click.option(
    "--diff",
    "compare",
    is_flag=True,
    help="Compare two models, OLD.xml NEW.xml; exit code 1 if their physics differs.",
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
    documents = [options[f"{name}_file"] for name in DOCUMENTS]
    refuse_conflicts(*documents)
    from ..reports.github import annotated
    from .batch import InspectRequest

    request = InspectRequest(
        options["strict"],
        options["selects"],
        options["ignores"],
        options["waivers"],
        options["baseline"],
    )
    request.refuse_slips()
    if options["dry_run"] and not options["fix"]:
        raise UsageError("--dry-run is for --fix")
    items: list[ReportItem] = []
    quiet = to_stdout(*documents)
    with annotated(lambda: items, options["annotations"], quiet):
        if not options["compare"]:
            return inspect_all(models, request, options, items)
        if options["fix"]:
            raise UsageError("--fix is of files: leave out --diff")
        return inspect_two(models, request, options)


def inspect_all(
    models: Sequence[str],
    request: InspectRequest,
    options: Mapping[str, Any],
    items: list[ReportItem],
) -> int:
    """Inspect models: reports and documents; return the exit code, and add to items."""
    from ..reports.github import append_step_summary
    from ..reports.sections import markdown_sections
    from ..reports.text import in_encoding
    from .batch import files_of, named_once
    from .console import findings_table, print_lines
    from .sandbox import inspect_file, inspect_files

    files, fail_on = files_of(models, options["whole_models"]), options["fail_on"]
    single = len(models) == 1 and files == list(models)
    if not single:
        refuse_single(options)
    if options["fix"]:
        code = fix_files(files, request, options)
        if options["dry_run"] or code == MISUSED:
            return code
    screen = console(*(options[f"{name}_file"] for name in DOCUMENTS))
    with sandboxed(options) as sandbox:
        every, reports = inspect_files(
            files,
            lambda file: partial(inspect_file, file, request, options, as_screen(screen)),
            sandbox,
        )
    if single and not reports:
        raise UsageError(named_once(*next(iter(every.unreadable.items()))))
    items += every.items(fail_on)
    write_documents(every, items, single, options)
    if not screen.stderr:
        if single and not options["lines"]:
            screen.file.write(in_encoding(reports[0], screen))
        else:
            print_lines(screen, every, fail_on)
    for file, why in every.unreadable.items():
        complain(named_once(file, why), MISUSED)
    title = f"mbcheck inspect: {every.verdict(fail_on)}"
    append_step_summary(markdown_sections(title, [findings_table(items)]))
    return every.exit_code(fail_on)


@contextmanager
def sandboxed(options: Mapping[str, Any]) -> Iterator[Sandbox]:
    """Lend a process for the time that there is, with progress."""
    from .sandbox import Sandbox

    budget = inf if options["budget"] is None else float(options["budget"])
    with (
        progress_bar(True, "inspect", lines=True) as progress,
        closing(Sandbox(budget, progress)) as sandbox,
    ):
        yield sandbox


def as_screen(screen: Console) -> dict[str, Any]:
    """Return what a report is written for, see `sandbox.Screen`."""
    colours = None if screen.no_color else screen.color_system
    return {"width": screen.width, "force_terminal": screen.is_terminal, "color_system": colours}


def fix_files(files: Sequence[str], request: InspectRequest, options: Mapping[str, Any]) -> int:
    """Leave out what models do without; return 1 if a dry run would, 2 if a file is not read."""
    from ..reports.words import printable
    from .batch import named_once
    from .sandbox import fix

    code, dry_run = 0, options["dry_run"]
    with sandboxed(options) as sandbox:
        for file in files:
            try:
                work = partial(fix, file, request, dry_run)
                edit, summary, any_edit = sandbox.run(work, len(files) == 1)
            except MbcheckError as error:
                code = complain(named_once(file, str(error)), MISUSED)
                continue
            if dry_run:
                for line in edit.split("\n")[:-1]:
                    click.echo("\t".join(map(printable, line.split("\t"))))
                code = code or int(any_edit)
            for line in summary.split("\n"):
                click.echo(printable(line), err=True)
    return code


def inspect_two(models: Sequence[str], request: InspectRequest, options: Mapping[str, Any]) -> int:
    """Print what differs between two models; return the exit code."""
    from ..reports.text import in_encoding
    from .batch import FAIL_ON
    from .sandbox import compare_models

    if len(models) != 2:
        raise UsageError("--diff compares two models: OLD.xml NEW.xml")
    refuse_single(options)
    if any(options[f"{name}_file"] for name in DOCUMENTS):
        raise UsageError("--diff prints a table, and writes no document")
    screen = console()
    with sandboxed(options) as sandbox:
        work = partial(compare_models, models, request, options["modes"], as_screen(screen))
        text, differs, new = sandbox.run(work, alone=True)
    screen.file.write(in_encoding(text, screen))
    return int(differs or any(one in FAIL_ON[options["fail_on"]] for one in new))


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


def write_documents(
    every: Inspections, items: Sequence[ReportItem], single: bool, options: Mapping[str, Any]
) -> None:
    """Write documents; JSON of a single model is of that one."""
    from ..queries.environment import versions
    from ..reports.junit import junit
    from ..reports.sarif import sarif
    from .rules.table import RULES

    if options["json_file"]:
        options["json_file"].write(json_text(every.models[0] if single else every.as_json()))
    if options["junit_file"]:
        options["junit_file"].write(junit(items))
    if options["sarif_file"]:
        rules = {name: (rule.meaning, rule.why) for name, rule in RULES.items()}
        options["sarif_file"].write(sarif(items, rules, versions(())["mbcheck"]))


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
