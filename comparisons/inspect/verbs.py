"""The verb ``mbcheck inspect``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from ...reference.errors import MbcheckError, UnknownNameError, UsageError
from ..reports.files import Destination, refuse_conflicts
from ..terminal.options import with_options_of
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
    to_stdout,
)
from .request import InspectRun

if TYPE_CHECKING:
    from rich.console import Console

    from ..reports.item import ReportItem
    from .batch import Inspections
    from .sandbox import Sandbox


@click.command(
    epilog=examples(
        "mbcheck inspect model.xml",
        "mbcheck inspect model.xml --full --about-rotation theta=10",
        "mbcheck inspect robots/ 'scenes/*.xml' --fail-on warning --sarif found.sarif",
        "mbcheck inspect model.xml --strict --ignore 'unused_*'",
        "mbcheck inspect model.xml --fix --dry-run",
        "mbcheck inspect --explain step_limit",
    )
)
@with_options_of(InspectRun)
@JSON
@JUNIT
@SARIF
def inspect(
    json_file: Destination | None,
    junit_file: Destination | None,
    sarif_file: Destination | None,
    **options: Any,
) -> int:
    """Inspect MJCF models: what is wrong in them, how they move, what they could do without.

    Findings, each with its rule, reason and fix; natural frequencies and damping at each keyframe;
    the largest stable step of each integrator; how far soft loops open. A comment in the file
    waives a finding: <!-- mbcheck: allow RULE, ELEMENT: REASON -->. Exit code 1 if an error (see
    --fail-on) is not waived, or a dry run of --fix would change something, 2 if a file cannot be
    read.
    """
    run = InspectRun(**options)
    if run.explain is not None:
        explain_rule(run.explain)
        if not run.models:
            return 0
    if not run.models:
        raise UsageError("which file? mbcheck inspect MODEL.xml")
    files = Documents(json_file, junit_file, sarif_file)
    refuse_conflicts(*files)
    from ..reports.github import annotated
    from .selection import refuse_slips

    refuse_slips(run)
    if run.dry_run and not run.fix:
        raise UsageError("--dry-run is for --fix")
    items: list[ReportItem] = []
    with annotated(lambda: items, run.annotations, to_stdout(*files)):
        return inspect_all(run, files, items)


class Documents(NamedTuple):
    """Where documents go."""

    json: Destination | None
    junit: Destination | None
    sarif: Destination | None


def inspect_all(run: InspectRun, documents: Documents, items: list[ReportItem]) -> int:
    """Inspect models: reports and documents; return the exit code, and add to items."""
    from ..reports.github import append_step_summary
    from ..reports.sections import markdown_sections
    from ..reports.text import in_encoding
    from .batch import files_of, named_once
    from .console import findings_table, print_lines
    from .sandbox import inspect_file, inspect_files

    files = files_of(run.models, run.whole_models)
    single = files == list(run.models) and len(files) == 1
    if not single:
        refuse_single(run)
    if run.fix:
        code = fix_files(run, files)
        if run.dry_run or code == MISUSED:
            return code
    screen = console(*documents)
    with sandboxed(run) as sandbox:
        every, reports = inspect_files(
            files,
            lambda file: partial(inspect_file, replace(run, path=file), as_screen(screen)),
            sandbox,
        )
    if single and not reports:
        raise UsageError(named_once(*next(iter(every.unreadable.items()))))
    items += every.items(run.fail_on)
    write_documents(every, items, single, documents)
    if not screen.stderr:
        if single and not run.lines:
            screen.file.write(in_encoding(reports[0], screen))
        else:
            print_lines(screen, every, run.fail_on)
    for file, why in every.unreadable.items():
        complain(named_once(file, why), MISUSED)
    title = f"mbcheck inspect: {every.verdict(run.fail_on)}"
    append_step_summary(markdown_sections(title, [findings_table(items)]))
    return every.exit_code(run.fail_on)


@contextmanager
def sandboxed(run: InspectRun) -> Iterator[Sandbox]:
    """Lend a process for the time that there is, with progress."""
    from .sandbox import Sandbox

    with (
        progress_bar(True, "inspect", lines=True) as progress,
        closing(Sandbox(inf if run.budget is None else run.budget, progress)) as sandbox,
    ):
        yield sandbox


def as_screen(screen: Console) -> dict[str, Any]:
    """Return what a report is written for, see `sandbox.Screen`."""
    colours = None if screen.no_color else screen.color_system
    return {"width": screen.width, "force_terminal": screen.is_terminal, "color_system": colours}


def fix_files(run: InspectRun, files: Sequence[str]) -> int:
    """Leave out what models do without; return 1 if a dry run would, 2 if a file is not read."""
    from ..reports.words import printable
    from .batch import named_once
    from .sandbox import fix

    code = 0
    with sandboxed(run) as sandbox:
        for file in files:
            try:
                work = partial(fix, replace(run, path=file))
                edit, summary, any_edit = sandbox.run(work, len(files) == 1)
            except MbcheckError as error:
                code = complain(named_once(file, str(error)), MISUSED)
                continue
            if run.dry_run:
                for line in edit.split("\n")[:-1]:
                    click.echo("\t".join(map(printable, line.split("\t"))))
                code = code or int(any_edit)
            for line in summary.split("\n"):
                click.echo(printable(line), err=True)
    return code


def refuse_single(run: InspectRun) -> None:
    """Refuse options that are about one model where there are several."""
    for option, value in (("--about-rotation", run.about_rotation), ("--full", run.full)):
        if value:
            raise UsageError(f"{option} is for one model")


def write_documents(
    every: Inspections, items: Sequence[ReportItem], single: bool, documents: Documents
) -> None:
    """Write documents; JSON of a single model is of that one."""
    from ..queries.environment import versions
    from ..reports.junit import junit
    from ..reports.sarif import sarif
    from .rules.table import RULES

    if documents.json:
        documents.json.write(json_text(every.models[0] if single else every.as_json()))
    if documents.junit:
        documents.junit.write(junit(items))
    if documents.sarif:
        rules = {name: (rule.meaning, rule.why) for name, rule in RULES.items()}
        documents.sarif.write(sarif(items, rules, versions(())["mbcheck"]))


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
