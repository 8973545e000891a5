"""The work of ``mbcheck inspect``: many files, each in a process with limits of time and memory."""

from __future__ import annotations

import glob
import io
import os
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf
from pathlib import Path
from time import monotonic
from typing import Any, TypeVar

import click
from rich.console import Console

from ...reference.errors import EngineError, MbcheckError, UsageError
from ..documents import document
from ..documents.reading import read_bytes
from ..engines.isolation import MEMORY, Worker, await_call, tell, within_limits
from ..queries.environment import versions
from ..reports.files import Destination, refuse_conflicts
from ..reports.github import annotated, append_step_summary
from ..reports.item import LEVELS, Outcome, ReportItem
from ..reports.junit import junit
from ..reports.sarif import sarif
from ..reports.sections import Section, markdown_sections, print_sections
from ..reports.text import STYLES, in_encoding, print_line, print_unbroken
from ..reports.words import plural, printable
from ..terminal.program import MISUSED, complain, console, json_text, progress_bar, to_stdout
from .console import VERDICTS, inspection_sections, omissions
from .fixes import neutral_edit
from .inspection import Inspection, inspect_in_parts, selection_of, unwaived
from .mujoco.source import ROOT, OtherRootError, read
from .request import InspectRun
from .rules.table import RULES
from .subject import SEVERITIES
from .tuning import EFFORT

T = TypeVar("T")

FAILING: Mapping[str, int] = {"error": 1, "warning": 2, "note": 3, "never": 0}
"""Value of --fail-on -> number of severities, the worst first, that make exit code 1."""

BEGIN = re.compile(rf"<{ROOT}[\s/>]".encode())
"""Beginning of MJCF, even where it cannot be parsed."""

WILD = re.compile(r"[*?\[]")

FileReport = tuple[dict[str, Any], str]
"""The ``inspect`` document of a file, and its report."""


# Names of files -------------------------------------------------------------------------------


def files_of(names: Sequence[str], whole: bool = False) -> list[str]:
    """Return the MJCF files that files, folders and patterns name, each once.

    Files of folders and patterns, or all files if ``whole``, are left out if they are not MJCF, or
    if another of them includes them.

    Raises
    ------
    UsageError
        If a folder or a pattern has none.
    """
    every: dict[str, None] = {}
    if whole:
        models = whole_models(names)
        names = [name for name in names if name in models or not os.path.isfile(name)]
    for name in names:
        if name and os.path.isdir(name):
            listed = sorted(map(str, Path(name).rglob("*.xml")))
        elif WILD.search(name) and not os.path.exists(name):
            listed = sorted(glob.glob(name, recursive=True))
        else:
            every[name] = None
            continue
        models = whole_models(listed)
        if not models:
            raise UsageError(f"{name} has no MJCF file")
        every.update(dict.fromkeys(models))
    return list(every)


def whole_models(names: Sequence[str]) -> list[str]:
    """Return those files that are MJCF and that no other of them includes."""
    parts, models = set[Path](), list[str]()
    for name in names:
        try:
            source = read(Path(name))
        except OtherRootError:
            continue
        except MbcheckError:
            with suppress(UsageError):
                models += [name] if BEGIN.search(read_bytes(name)) else []
            continue
        if any(child.tag == "worldbody" for child in source.root.children):
            models.append(name)
        parts.update((Path(name).parent / one).resolve() for one in source.files[1:])
    return [name for name in models if Path(name).resolve() not in parts]


def named_once(file: str, why: str) -> str:
    """Return the reason why a file cannot be read, with its name as given, once."""
    name = re.escape(Path(file).name)
    words, count = re.subn(rf"(?<![\w./-]){name}(?![\w-])", lambda _: file, why, count=1)
    return words if count else f"{file}: {why}"


# Results --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Unreadable:
    """File that could not be inspected.

    Attributes
    ----------
    file : str
        file, as it was given
    reason : str
        reason why it could not be inspected
    """

    file: str
    reason: str


@dataclass(frozen=True)
class InspectionsDocument:
    """Findings in several MJCF files.

    Attributes
    ----------
    summary : mapping of str to int
        number of findings in all files
    unreadable : tuple of Unreadable
        files that could not be inspected
    models : tuple of Inspection
        all other files, as documents of `inspect`
    """

    summary: Mapping[str, int]
    unreadable: tuple[Unreadable, ...]
    models: tuple[Inspection, ...]


@dataclass(frozen=True)
class Inspections:
    """Inspections of many files, and the reasons why others could not be inspected.

    Attributes
    ----------
    models : tuple of mapping
        An ``inspect`` document for each; partial for a file that ended its process.
    unreadable : mapping of str to str
    """

    models: tuple[Mapping[str, Any], ...]
    unreadable: Mapping[str, str] = field(default_factory=dict)

    @property
    def files(self) -> list[str]:
        """All files, as they were given."""
        return list(dict.fromkeys([*(one["file"] for one in self.models), *self.unreadable]))

    @property
    def summary(self) -> dict[str, int]:
        """Number of findings by severity, and of waived ones."""
        names = (*SEVERITIES, "waived")
        return {name: sum(one["summary"][name] for one in self.models) for name in names}

    def items(self, fail_on: str) -> list[ReportItem]:
        """Return an item for each finding, and for each unreadable file, or file without any.

        A finding of a failing severity is a failure, others are skipped.
        """
        items, seen = list[ReportItem](), Counter[tuple[str, ...]]()
        for model in self.models:
            for one in unwaived(model):
                file = model["file"]
                if one["file"] not in (None, model["files"][0]):  # an included file
                    file = os.path.normpath(Path(file).parent / one["file"])
                parts = [one[key] for key in ("rule", "element", "attribute") if one[key]]
                seen[model["file"], file, *parts] += 1
                again = seen[model["file"], file, *parts]
                fails = one["severity"] in SEVERITIES[: FAILING[fail_on]]
                items.append(
                    ReportItem(
                        id=" ".join(parts) + (f" ({again})" if again > 1 else ""),
                        rule=one["rule"],
                        suite=model["file"],
                        outcome="failure" if fails else "skipped",
                        severity=one["severity"],
                        message=one["message"],
                        details=(f"fix: {one['fix']}",),
                        file=file,
                        line=one["line"],
                    )
                )
        clean = {file: "" for file in self.files if file not in {item.suite for item in items}}
        for file, why in (clean | dict(self.unreadable)).items():
            outcome: Outcome = "error" if why else "pass"
            items.append(ReportItem("inspect", "unreadable", file, outcome, None, why, file=file))
        return items

    def exit_code(self, fail_on: str) -> int:
        """Return 2 if a file could not be read, 1 if a finding fails or parts were left out."""
        fails = any(self.summary[name] for name in SEVERITIES[: FAILING[fail_on]])
        fails |= any(one["left_out"] for one in self.models)
        return 2 if self.unreadable else int(fails)

    def verdict(self, fail_on: str) -> str:
        """Return one line that counts findings."""
        counts, files = self.summary, self.files
        words = [plural(counts[name], name) for name in SEVERITIES]
        words += [f"{counts['waived']} waived"] if counts["waived"] else []
        words += [f"{len(self.unreadable)} cannot be read"] if self.unreadable else []
        of = f"{plural(len(files), 'file')}, " if len(files) > 1 else ""
        return f"{'FAIL' if self.exit_code(fail_on) else 'OK'}: {of}{', '.join(words)}"

    def print_verdict(self, console: Console, fail_on: str) -> None:
        """Print one line that counts findings, in the style of the worst."""
        worst = (STYLES.get(VERDICTS[name], "cyan") for name in LEVELS if self.summary[name])
        print_line(console, self.verdict(fail_on), next(worst, STYLES["pass"]))

    def as_json(self) -> dict[str, Any]:
        """Return the ``inspections`` document of docs/json.md."""
        unreadable = [Unreadable(file, why) for file, why in self.unreadable.items()]
        return document("inspections", self, unreadable=unreadable)


# The process ----------------------------------------------------------------------------------


class Sandbox:
    """A process that works on one file after the other; another one follows if it ends.

    Parameters
    ----------
    budget : float, optional
        Time [s] for all files, after which work is stopped.
    progress : callable, optional
        Receives the number of parts that are done, their total, and the next part.

    Attributes
    ----------
    report : FileReport or None
        Findings up to the point where work was stopped.
    """

    def __init__(
        self, budget: float = inf, progress: Callable[..., None] = lambda *_: None
    ) -> None:
        if not budget > 0:
            raise UsageError(f"--budget must be a positive number, not {budget:g}")
        self.end, self.progress = monotonic() + budget, progress
        self.worker: Worker | None = None
        self.report: FileReport | None = None
        self.place, self.part, self.alone = (0, 1, ""), "", False

    def close(self) -> None:
        """End the process."""
        if self.worker is not None:
            self.worker.end()

    def run(self, work: Callable[[], T], alone: bool = False) -> T:
        """Return the result of work on a file.

        Work on a single file may take all the remaining time, work on one of several half of it.

        Raises
        ------
        EngineError
            If it was stopped, or ended its process.
        MbcheckError
            Raised by the work.
        """
        left = self.end - monotonic()
        if left <= 0:
            raise EngineError("timeout", "not inspected: the time of --budget was up")
        shared = left if alone else left / 2
        most = EFFORT.file_time if left == inf else max(EFFORT.min_file_time, shared)
        self.report, self.part, self.alone = None, "", alone
        if self.worker is None or not self.worker.process.is_alive():
            self.worker = Worker()
            self.worker.heard = self.hear
        with within_limits(most, MEMORY):
            outcome = await_call(self.worker, partial(in_folder, os.getcwd(), work), most)
        if isinstance(outcome, EngineError):
            message = outcome.message
            if outcome.kind == "timeout" and left < inf:
                message = f"stopped: the time of --budget was up, {most:.3g} s for this file"
            raise EngineError(outcome.kind, f"{message}; it was at: {self.part}")
        if isinstance(outcome, MbcheckError):
            raise outcome
        return outcome

    def hear(self, message: Any) -> None:
        """Receive the next part, an edit that a part tries, or an intermediate report."""
        if len(message) == 2:
            self.report = message
            return
        if len(message) == 1:
            done, total, part = self.place
            message = done, total, f"{part}: {message[0]}"
        else:
            self.place = message
        self.part = message[-1]
        if self.alone:
            self.progress(*message)


def in_folder(folder: str, work: Callable[[], T]) -> T | MbcheckError:
    """Return the result of work in a folder, or the error of mbcheck that it raises."""
    os.chdir(folder)
    try:
        return work()
    except MbcheckError as error:
        return error


def inspect_file(run: InspectRun, screen: Mapping[str, Any]) -> FileReport:
    """Inspect a file, with intermediate reports; ``screen`` holds arguments of rich's console."""

    def report_of(result: Inspection) -> FileReport:
        written = io.StringIO()
        outlet = Console(file=written, highlight=False, **screen)
        print_inspection(outlet, result, run.full, run.fail_on)
        return result.as_json(), written.getvalue()

    last_report, total = monotonic(), 0
    tell((0, 1, f"MuJoCo compiles {os.path.basename(run.path)}"))
    for left, inspection in inspect_in_parts(run):
        total = max(total, len(left))
        for part in left[:1]:
            tell((total - len(left), total, part))
            if not part.startswith("rule ") or monotonic() > last_report + EFFORT.report_interval:
                tell(report_of(inspection()))
                last_report = monotonic()
    return report_of(inspection())


def fix_file(run: InspectRun) -> tuple[str, str, bool]:
    """Remove redundant attributes of a file; return diff, summary, and True if there are any."""
    edit = neutral_edit(run)
    if not run.dry_run:
        edit.write()
    return edit.diff, edit.summary, bool(edit.attributes)


# The verb -------------------------------------------------------------------------------------


def inspect_models(
    run: InspectRun,
    json_file: Destination | None,
    junit_file: Destination | None,
    sarif_file: Destination | None,
) -> int:
    """Carry out ``mbcheck inspect``; return the exit code.

    Raises
    ------
    UsageError
        If options do not go together, or the only file cannot be read.
    """
    if not run.models:
        raise UsageError("which file? mbcheck inspect MODEL.xml")
    destinations = (json_file, junit_file, sarif_file)
    refuse_conflicts(*destinations)
    selection_of(run)  # which refuses unknown rules, and files that cannot be read
    if run.dry_run and not run.fix:
        raise UsageError("--dry-run is for --fix")
    items: list[ReportItem] = []
    with annotated(lambda: items, run.annotations, to_stdout(*destinations)):
        files = files_of(run.models, run.whole_models)
        single = files == list(run.models) and len(files) == 1
        for option, value in (("--about-rotation", run.about_rotation), ("--full", run.full)):
            if value and not single:
                raise UsageError(f"{option} is for one model")
        screen = console(*destinations)
        with (
            progress_bar(True, "inspect", lines=True) as progress,
            closing(Sandbox(inf if run.budget is None else run.budget, progress)) as sandbox,
        ):
            if run.fix:
                code = fix_files(run, files, sandbox)
                if run.dry_run or code == MISUSED:
                    return code
            arguments = {
                "width": screen.width,
                "force_terminal": screen.is_terminal,
                "color_system": None if screen.no_color else screen.color_system,
            }
            every, reports = inspect_files(
                files,
                lambda file: partial(inspect_file, replace(run, path=file), arguments),
                sandbox,
            )
        if single and not reports:
            raise UsageError(named_once(*next(iter(every.unreadable.items()))))
        items += every.items(run.fail_on)
        if json_file:
            json_file.write(json_text(every.models[0] if single else every.as_json()))
        if junit_file:
            junit_file.write(junit(items))
        if sarif_file:
            rules = {name: (rule.meaning, rule.why) for name, rule in RULES.items()}
            sarif_file.write(sarif(items, rules, versions(())["mbcheck"]))
        if single and not run.lines and not screen.stderr:
            screen.file.write(in_encoding(reports[0], screen))
        elif not screen.stderr:
            print_lines(screen, every, run.fail_on)
        for file, why in every.unreadable.items():
            complain(named_once(file, why), MISUSED)
        title = f"mbcheck inspect: {every.verdict(run.fail_on)}"
        rows = [
            (item.severity, item.rule, item.place, "; ".join((item.message, *item.details)))
            for item in items
            if item.severity
        ]
        table = Section("", ("severity", "rule", "where", "what"), rows)
        append_step_summary(markdown_sections(title, [table]))
    return every.exit_code(run.fail_on)


def inspect_files(
    files: Sequence[str], work: Callable[[str], Callable[[], FileReport]], sandbox: Sandbox
) -> tuple[Inspections, list[str]]:
    """Inspect files one after the other; an unreadable one does not end the others.

    Parameters
    ----------
    files : sequence of str
    work : callable
        Returns the function that inspects a file.
    sandbox : Sandbox

    Returns
    -------
    Inspections, and the reports of its models.
    """
    every, unreadable = list[FileReport](), dict[str, str]()
    for number, file in enumerate(files):
        if len(files) > 1:
            sandbox.progress(number, len(files), file)
        try:
            every.append(sandbox.run(work(file), len(files) == 1))
        except MbcheckError as error:
            ended = error.kind if isinstance(error, EngineError) else ""
            report = sandbox.report if ended else None  # a mistake of the user has none
            every += [report] if report else []
            if not (report and ended == "timeout"):
                unreadable[file] = str(error)
    return Inspections(tuple(model for model, _ in every), unreadable), [text for _, text in every]


def fix_files(run: InspectRun, files: Sequence[str], sandbox: Sandbox) -> int:
    """Fix models; return 1 if a dry run finds redundant attributes, 2 if a file is unreadable."""
    code = 0
    for file in files:
        try:
            work = partial(fix_file, replace(run, path=file))
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


def print_inspection(
    console: Console, inspection: Inspection, full: bool = True, fail_on: str = "error"
) -> None:
    """Print the report on a file, short or ``full``, and one line that counts its findings."""
    every = Inspections((inspection.as_json(),))
    print_sections(console, inspection_sections(inspection, every.items(fail_on), full))
    every.print_verdict(console, fail_on)


def print_lines(console: Console, every: Inspections, fail_on: str) -> None:
    """Print a line for each finding of several files, and one that counts them."""
    for item in every.items(fail_on):
        if item.severity:
            print_unbroken(console, item.text)
    for one in every.models:
        if words := omissions(one["left_out"]):
            print_line(console, f"{one['file']}: {words}")
    every.print_verdict(console, fail_on)
