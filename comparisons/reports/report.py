"""Reports on a list of results: console, JSON, JUnit, Markdown, and the exit code."""

from __future__ import annotations

import math
import re
import shlex
import textwrap
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..checks.known import Use
from ..checks.verdict import Result, Verdict
from ..queries.document import SCHEMA, finite
from .located import located

VERDICTS: tuple[Verdict, ...] = ("pass", "deviation", "known", "skipped", "error")
"""In the order of the summary."""

SEVERITY: tuple[Verdict, ...] = ("error", "deviation", "known", "pass", "skipped")
"""A group of results is as good as the first of these that it holds."""

SIGNS: Mapping[str, str] = {"pass": "ok", "deviation": "DEV", "known": "known", "error": "ERR"}
"""Words in the cells of the matrix, so that it reads without colour."""

STYLES: Mapping[str, str] = {
    "pass": "green",
    "deviation": "bold red",
    "known": "yellow",
    "skipped": "dim",
    "error": "bold magenta",
}

MEASURES = ("value", "reference", "error", "tolerance")
"""Fields of a result that are numbers."""

CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]+")
"""What a terminal might obey instead of show, and line ends."""

NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Everything outside the production Char of XML 1.0."""


def summary(results: Sequence[Result]) -> dict[str, int]:
    """Return the number of results by verdict, and their ``total``."""
    counts: dict[str, int] = {v: sum(r.verdict == v for r in results) for v in VERDICTS}
    return counts | {"total": len(results)}


@dataclass(frozen=True)
class Run:
    """What was asked for, where it ran, and what became of the known deviations.

    Attributes
    ----------
    planned : int or None
        Number of checks that were to run; None if only those that ran are known.
    selection : mapping
        ``scenes``, ``engines``, ``kinds``, ``methods``, ``ids``, ``profile`` and ``full``, as
        `mbcheck check` takes them; empty lists mean all.
    environment : mapping of str to str
        The machine and what computes on it.
    known_file : str or None
    uses : tuple of Use
        One for each entry of that file.
    strict_known : bool
        Whether stale entries fail.
    """

    planned: int | None = None
    selection: Mapping[str, Any] = field(default_factory=dict)
    environment: Mapping[str, str] = field(default_factory=dict)
    known_file: str | None = None
    uses: tuple[Use, ...] = ()
    strict_known: bool = False

    @property
    def stale(self) -> tuple[Use, ...]:
        """The entries that are of no use any more."""
        return tuple(use for use in self.uses if use.state == "stale")


def exit_code(results: Sequence[Result], run: Run | None = None) -> int:
    """Return 0 if all is well, 1 for any deviation or error, 2 if nothing ran.

    Stale entries are 1 too where they are to fail. An engine that was asked for by name, and of
    which nothing has passed, is as good as one that did not run.
    """
    counts = summary(results)
    stale = run is not None and run.strict_known and bool(run.stale)
    if counts["deviation"] or counts["error"] or stale:
        return 1
    return 2 if counts["skipped"] == counts["total"] or idle_engines(results, run) else 0


def idle_engines(results: Sequence[Result], run: Run | None) -> int:
    """Return how many of the engines that were asked for by name have passed nothing."""
    asked = set(run.selection.get("engines", ())) if run is not None else set()
    return max(0, len(asked) - len({r.engine for r in results if r.verdict in ("pass", "known")}))


def check_counts(results: Sequence[Result], run: Run | None = None) -> dict[str, int]:
    """Return how many checks were ``planned``, ``ran``, were ``skipped`` or ``not_reached``.

    A check of which a single result was judged ran. Engines that cannot be imported have none.
    """
    groups = grouped((r for r in results if r.kind != "-"), lambda r: (check_of(r),)).values()
    skipped = sum(all(r.verdict == "skipped" for r in members) for members in groups)
    planned = len(groups) if run is None or run.planned is None else run.planned
    return {
        "planned": planned,
        "ran": len(groups) - skipped,
        "skipped": skipped,
        "not_reached": max(0, planned - len(groups)),
    }


def skip_reasons(results: Sequence[Result]) -> dict[tuple[str, str], int]:
    """Return how many results were skipped, by engine and reason."""
    skipped = (r for r in results if r.verdict == "skipped")
    groups = grouped(skipped, lambda r: (r.engine, r.reason))
    return {(engine, reason): len(members) for (engine, reason), members in groups.items()}


# JSON


def json_document(
    results: Sequence[Result], versions: Mapping[str, str], run: Run | None = None
) -> dict[str, Any]:
    """Return the ``check`` document of docs/json.md; it holds no NaN and no infinity."""
    run = run or Run()
    return {
        "schema": SCHEMA,
        "summary": summary(results),
        "checks": check_counts(results, run),
        "skipped": [
            {"engine": engine, "reason": reason, "results": count}
            for (engine, reason), count in skip_reasons(results).items()
        ],
        "versions": dict(versions),
        "environment": dict(run.environment),
        "selection": {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in run.selection.items()
        },
        "known": {
            "file": run.known_file,
            "strict": run.strict_known,
            "entries": [json_use(use) for use in run.uses],
        },
        "results": [json_result(result) for result in results],
    }


def json_use(use: Use) -> dict[str, Any]:
    """Return as JSON what became of an entry of the known deviations."""
    return {**vars(use.entry), "results": use.results, "state": use.state, "why": use.why}


def json_result(result: Result) -> dict[str, Any]:
    """Return one result as JSON; a number that JSON has no word for is null, and why."""
    fields = result.as_dict()
    lost = []
    for name in MEASURES:
        if fields[name] is not None:
            fields[name] = finite(fields[name])
            if fields[name] is None:
                lost.append(f"{name} was {float(getattr(result, name))}")
    fields["reason"] = "; ".join(filter(None, [result.reason, *lost]))
    fields["work"] = {name: finite(amount) for name, amount in result.work.items()}
    return fields


# JUnit


def junit(
    results: Sequence[Result],
    versions: Mapping[str, str] | None = None,
    run: Run | None = None,
    repeat: Callable[[Result], str] | None = None,
) -> str:
    """Return JUnit XML: one suite per scene, engine and kind; one test case per result.

    A deviation is a failure, an error an error; skipped and known results are skipped.
    Stale entries of the known deviations are a suite of their own: failures if they are to
    fail, skipped otherwise. The time of a check is shared equally by its results. ``repeat``
    returns the command that repeats a result, by default that of `rerun`.
    """
    siblings = Counter(check_of(result) for result in results)
    times = {r.id: seconds(r) / siblings[check_of(r)] for r in results}
    root = ET.Element("testsuites", name="mbcheck")
    run = run or Run()
    root.attrib.update(with_stale(junit_counts(results, times), run))
    groups = grouped(results, lambda r: (r.scene, r.engine, r.kind))
    for key, members in groups.items():
        suite = ET.SubElement(root, "testsuite", name=xml_text("/".join(key)))
        suite.attrib.update(junit_counts(members, times))
        properties = ET.SubElement(suite, "properties")
        for name, text in {**(versions or {}), **run.environment}.items():
            ET.SubElement(properties, "property", name=xml_text(name), value=xml_text(text))
        for result in members:
            suite.append(junit_case(result, times[result.id], repeat or rerun))
    if run.stale:
        root.append(junit_stale(run))
    ET.indent(root)
    declaration = '<?xml version="1.0" encoding="utf-8"?>\n'
    return declaration + ET.tostring(root, encoding="unicode") + "\n"


def junit_case(result: Result, time: float, repeat: Callable[[Result], str]) -> ET.Element:
    """Return the test case of one result, which took this time [s]."""
    place = f"{result.source}.{result.scene}.{result.case}.{result.kind}.{result.engine}"
    case = ET.Element("testcase", name=xml_text(result.id), classname=xml_text(place))
    case.set("time", f"{time:.6f}")
    properties = ET.SubElement(case, "properties")
    for name in ("method", "model", "quantity", "unit", *MEASURES, "verdict"):
        content = getattr(result, name)
        if content is not None:
            ET.SubElement(properties, "property", name=name, value=xml_text(str(content)))
    reason = xml_text(result.reason)
    if result.verdict in ("deviation", "error"):
        tag = "failure" if result.verdict == "deviation" else "error"
        found = ET.SubElement(case, tag, message=reason, type=result.verdict)
        found.text = xml_text(
            "\n".join([result.id, measured(result), result.reason, repeat(result)])
        )
    elif result.verdict in ("skipped", "known"):
        if result.verdict == "known":
            reason = xml_text(f"known deviation: {why_known(result)}; {result.reason}")
        ET.SubElement(case, "skipped", message=reason)
    return case


def junit_stale(run: Run) -> ET.Element:
    """Return a suite with a test case for each stale entry of the known deviations."""
    suite = ET.Element("testsuite", name="known deviations")
    counts = dict.fromkeys(("tests", "failures", "errors", "skipped"), "0") | {"time": "0"}
    suite.attrib.update(with_stale(counts, run))
    for use in run.stale:
        name = xml_text(f"{use.entry.place}: {use.entry.id}")
        case = ET.SubElement(suite, "testcase", name=name, classname="known", time="0")
        message = xml_text(f"stale: {use.why}; remove it from {run.known_file}")
        if run.strict_known:
            ET.SubElement(case, "failure", message=message, type="stale").text = message
        else:
            ET.SubElement(case, "skipped", message=message)
    return suite


def with_stale(counts: Mapping[str, str], run: Run) -> dict[str, str]:
    """Return counts of JUnit with the stale entries added."""
    what = "failures" if run.strict_known else "skipped"
    added = {name: int(counts[name]) + len(run.stale) for name in ("tests", what)}
    return {**counts, **{name: str(count) for name, count in added.items()}}


def junit_counts(results: Sequence[Result], times: Mapping[str, float]) -> dict[str, str]:
    """Return the attributes by which JUnit counts test cases and time; ``times`` [s] by id."""
    counts = summary(results)
    return {
        "tests": str(counts["total"]),
        "failures": str(counts["deviation"]),
        "errors": str(counts["error"]),
        "skipped": str(counts["skipped"] + counts["known"]),
        "time": f"{sum(times[result.id] for result in results):.6f}",
    }


def seconds(result: Result) -> float:
    """Return the wall time [s] of the check of a result; 0 if unknown."""
    return finite(result.work.get("seconds")) or 0.0


def xml_text(text: str) -> str:
    """Return text without the characters that XML 1.0 forbids."""
    return NOT_XML.sub("\N{REPLACEMENT CHARACTER}", text)


# Console


def print_report(
    console: Console,
    results: Sequence[Result],
    versions: Mapping[str, str],
    verbosity: int = 0,
    command: str = "mbcheck check",
    interrupted: bool = False,
    run: Run | None = None,
) -> None:
    """Print what a reader needs first: deviations, then a matrix, then one summary line.

    Parameters
    ----------
    console : rich.console.Console
    results : sequence of Result
    versions : mapping of str to str
        Versions by name of engine or library.
    verbosity : int
        -1 prints the summary line only, 1 adds every single result.
    command : str
        What the commands that re-run one check start with; options that change a verdict
        belong in it.
    interrupted : bool
        The run was, so its results are not all there are.
    run : Run, optional
    """
    run = run or Run()
    if verbosity >= 0:
        for result in results:
            if result.verdict in ("deviation", "error"):
                print_failure(console, result, command)
        if verbosity > 0:
            print_results(console, results)
        if where := located(results):
            for line in ["Located:", *(f"  {line}" for line in where), ""]:
                print_line(console, line, style="")
        table = matrix(results)
        if table.rows:
            console.print(table)
        print_accuracy(console, results)
        print_reasons(console, "known", results)
        print_reasons(console, "skipped", results)
        console.print()
        print_wrapped(console, ", ".join(f"{name} {text}" for name, text in versions.items()))
        print_line(console, counts_line(results, run), style="")
    print_stale(console, run)
    style = STYLES["deviation" if exit_code(results, run) == 1 else worst(results)]
    print_line(console, summary_line(results, interrupted, run), style=style)


def print_stale(console: Console, run: Run) -> None:
    """Print the entries of the known deviations that are of no use any more."""
    for use in run.stale:
        line = f"stale: {run.known_file}, {use.entry.place}, {use.entry.id!r}: {use.why}"
        print_line(console, line, style=STYLES["deviation" if run.strict_known else "known"])


def print_failure(console: Console, result: Result, command: str) -> None:
    """Print one deviation or error, why, and how to run it again."""
    console.print(
        Text.assemble(
            (f"{result.verdict.upper()} ", STYLES[result.verdict]),
            shown(result.id, console),
        ),
        soft_wrap=True,
    )
    for line in (measured(result), result.reason):
        if line:
            print_wrapped(console, line, indent="    ")
    print_line(console, f"    {rerun(result, command)}", style="cyan")
    console.print()


def print_results(console: Console, results: Sequence[Result]) -> None:
    """Print every result as a line of a table per scene, case, kind and engine."""
    groups = grouped(results, lambda r: (r.source, r.scene, r.case, r.kind, r.engine))
    for key, members in groups.items():
        print_line(console, "/".join(key), style="bold")
        table = Table(box=None, show_header=False, padding=(0, 1, 0, 0))
        for width in (9, 25, 16, 27):
            table.add_column(min_width=width, max_width=width, overflow="fold")
        for result in members:
            table.add_row(
                Text(result.verdict.replace("pass", "ok"), STYLES[result.verdict]),
                Text(shown(method_of(result), console)),
                Text(shown(result.quantity, console)),
                Text(shown(against_tolerance(result), console)),
            )
        console.print(table)
        console.print()


def matrix(results: Sequence[Result]) -> Table:
    """Return the verdicts as a table of scene and engine against kind.

    Engines that cannot be imported have no kind, and no row.
    """
    results = [result for result in results if result.kind != "-"]
    kinds = list(dict.fromkeys(result.kind for result in results))
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), show_edge=False, header_style="bold")
    table.add_column("", overflow="fold")
    for kind in kinds:
        table.add_column(Text(heading(kind, len(kinds) > MOST_WHOLE)), overflow="fold")
    scenes = grouped(results, lambda r: (r.scene,))
    for (scene,), of_scene in scenes.items():
        table.add_row(Text(printable(scene), "bold"))
        for (engine,), members in grouped(of_scene, lambda r: (r.engine,)).items():
            by_kind = grouped(members, lambda r: (r.kind,))
            cells = [cell(by_kind.get((kind,), [])) for kind in kinds]
            table.add_row(Text(f"  {printable(engine)}"), *cells)
    return table


HYPHENS = {"trajectory": "trajec-\ntory", "frequency": "fre-\nquency", "stability": "stabil-\nity"}
"""Long kinds on two lines, so that a column for every kind fits in 80 characters."""

MOST_WHOLE = 6
"""So many kinds fit unbroken."""


def heading(kind: str, narrow: bool) -> str:
    """Return a kind of check as the heading of a column."""
    return HYPHENS.get(kind, printable(kind)) if narrow else printable(kind)


def cell(results: Sequence[Result]) -> Text:
    """Return a sign, and how many of the results that were judged passed."""
    if not results:
        return Text("-", "dim")
    verdict = worst(results)
    if verdict == "skipped":
        return Text("skipped", STYLES[verdict])
    counts = summary(results)
    judged = counts["total"] - counts["skipped"]
    of = "" if counts["pass"] == judged else f"/{judged}"
    return Text(f"{SIGNS[verdict]} {counts['pass']}{of}", STYLES[verdict])


def print_accuracy(console: Console, results: Sequence[Result]) -> None:
    """Print the most and the least accurate method of each scene and engine."""
    lines = []
    for (scene, engine), members in grouped(results, lambda r: (r.scene, r.engine)).items():
        quantity = headline_quantity([r for r in results if r.scene == scene])
        chosen = [r for r in members if is_trajectory(r) and r.quantity == quantity]
        methods = grouped(chosen, lambda r: (method_of(r),)).values()
        if not methods:
            continue
        ranked = sorted((max(group, key=error_size) for group in methods), key=error_size)
        ends = [ranked[0], ranked[-1]] if len(ranked) > 1 else ranked
        span = " to ".join(f"{with_unit(r.error, r.unit)} ({method_of(r)})" for r in ends)
        lines.append(f"{scene} {engine}: error of {quantity} {span}")
    if lines:
        console.print()
    for line in lines:
        print_wrapped(console, line)


def print_reasons(console: Console, verdict: Verdict, results: Sequence[Result]) -> None:
    """Print the reasons of a verdict, each once, with the number of checks it holds for."""
    chosen = [result for result in results if result.verdict == verdict]
    if not chosen:
        return
    console.print()
    print_line(console, f"{verdict} ({len(chosen)}):", style=STYLES[verdict])
    why = why_known if verdict == "known" else reason_of
    for (engine, reason), members in grouped(chosen, lambda r: (r.engine, why(r))).items():
        methods = list(dict.fromkeys(method_of(r) for r in members))
        names = ", ".join(methods[:4]) + (", ..." if len(methods) > 4 else "")
        line = f"{len(members)} x {engine} {names}: {reason or 'no reason given'}"
        print_wrapped(console, line, indent="  ")


def counts_line(results: Sequence[Result], run: Run | None = None) -> str:
    """Return how many checks ran, in one line."""
    counts = check_counts(results, run)
    parts = [f"{plural(counts['planned'], 'check')}: {counts['ran']} ran"]
    parts += [f"{counts['skipped']} skipped"] if counts["skipped"] else []
    parts += [f"{counts['not_reached']} not reached"] if counts["not_reached"] else []
    return ", ".join(parts)


def summary_line(
    results: Sequence[Result], interrupted: bool = False, run: Run | None = None
) -> str:
    """Return the whole run in one line; one that was interrupted passes nothing."""
    counts = summary(results)
    word = {0: "PASS", 1: "FAIL", 2: "NOTHING RAN"}[exit_code(results, run)]
    word = "INTERRUPTED" if interrupted else word
    parts = [f"{counts['pass']} passed"]
    parts += [plural(counts["deviation"], "deviation"), plural(counts["error"], "error")]
    parts += [f"{counts[name]} {name}" for name in ("known", "skipped") if counts[name]]
    if run is not None and run.stale:
        parts.append(f"{len(run.stale)} of the known deviations stale")
    return f"{word}: {', '.join(parts)}"


def plural(count: int, noun: str) -> str:
    """Return a count with its noun."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def print_line(console: Console, text: str, style: str) -> None:
    """Print text that is not to be broken: it may be copied, or searched for in a log."""
    console.print(Text(shown(text, console), style), soft_wrap=True)


def print_wrapped(console: Console, text: str, indent: str = "") -> None:
    """Print prose, broken between words only."""
    lines = textwrap.wrap(
        shown(text, console),
        console.width,
        initial_indent=indent,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
    for line in lines:
        console.print(Text(line), soft_wrap=True)


def shown(text: str, console: Console) -> str:
    """Return printable text in the encoding of the console."""
    return printable(text).encode(console.encoding, "backslashreplace").decode(console.encoding)


def printable(text: str) -> str:
    """Return text on one line and without control characters.

    The indentation stays; what engines print must not move the cursor or colour a log.
    """
    return CONTROL.sub(" ", text)


# Markdown


def markdown(results: Sequence[Result]) -> str:
    """Return a Markdown table with one row per scene, engine and method.

    The measured error is the largest of a trajectory's first observable; columns named by
    a kind hold the largest error / tolerance of its checks. A row without trajectory, such
    as that of a model, shows the check that is nearest to its tolerance.
    """
    kinds = list(dict.fromkeys(r.kind for r in results if r.verdict != "skipped"))
    heads = ["Scene", "Engine", "Method", "Measured", "Error", "Tolerance", *kinds, "Verdict"]
    rows = [heads, ["---"] * len(heads)]
    ran = in_order([result for result in results if result.verdict != "skipped"])
    for (scene, engine, how), members in grouped(
        ran, lambda r: (r.scene, r.engine, method_of(r))
    ).items():
        by_kind = grouped(members, lambda r: (r.kind,))
        ratios = [ratio_cell(by_kind.get((kind,), [])) for kind in kinds]
        quantity = headline_quantity([r for r in results if r.scene == scene])
        line = headline(members, quantity)
        method = f"(model {how})" if members[0].method is None else how
        rows.append([scene, engine, method, *line, *ratios, verdict_cell(members)])
    return "".join(f"| {' | '.join(markdown_text(text) for text in row)} |\n" for row in rows)


def in_order(results: Sequence[Result]) -> list[Result]:
    """Return results with scenes, and then engines, together, in the order of appearance."""
    scenes = list(dict.fromkeys(result.scene for result in results))
    engines = list(dict.fromkeys(result.engine for result in results))
    return sorted(results, key=lambda r: (scenes.index(r.scene), engines.index(r.engine)))


def headline(results: Sequence[Result], quantity: str | None) -> list[str]:
    """Return the name, error and tolerance of the result that stands for a method."""
    candidates = [r for r in results if is_trajectory(r) and r.quantity == quantity]
    chosen = max(candidates or results, key=error_size if candidates else ratio)
    what = chosen.quantity if candidates else f"{chosen.kind}: {chosen.quantity}"
    error, tolerance = (with_unit(x, chosen.unit) for x in (chosen.error, chosen.tolerance))
    return [what, error, tolerance]


def ratio_cell(results: Sequence[Result]) -> str:
    """Return the largest error / tolerance of results, bold where it is too large."""
    if not results:
        return ""
    verdict = worst(results)
    if verdict == "error":
        return "**error**"
    text = f"{max(ratio(result) for result in results):.2g}"
    return f"**{text}**" if verdict == "deviation" else text


def verdict_cell(results: Sequence[Result]) -> str:
    """Return how many results of a row passed, and in words what the others did."""
    counts = summary(results)
    judged = counts["total"] - counts["skipped"]
    bad = [name for name in ("error", "deviation", "known") if counts[name]]
    if not bad:
        return f"pass ({judged})"
    return f"{counts['pass']} of {judged} pass, " + ", ".join(
        f"{counts[name]} {name}" if name == "known" else f"**{plural(counts[name], name)}**"
        for name in bad
    )


def markdown_text(text: str) -> str:
    """Return text that fits into one cell of a Markdown table."""
    return printable(text).replace("|", "\\|")


# Words and numbers


def measured(result: Result) -> str:
    """Return what was measured, in one line; empty if nothing was."""
    if all(getattr(result, name) is None for name in MEASURES):
        return ""
    digits = digits_to_differ(result)
    value, reference = (
        with_unit(item, result.unit, digits) for item in (result.value, result.reference)
    )
    error, tolerance = (with_unit(item, result.unit) for item in (result.error, result.tolerance))
    return (
        f"{result.quantity} = {value}, reference {reference}; error {error}, tolerance {tolerance}"
    )


def against_tolerance(result: Result) -> str:
    """Return error and tolerance of a result in few words; empty if it has none."""
    if result.error is None or result.tolerance is None:
        return ""
    sign = "<=" if result.error <= result.tolerance else ">"
    return f"{number(result.error)} {sign} {with_unit(result.tolerance, result.unit)}"


def why_known(result: Result) -> str:
    """Return the reason that a user has given for a known deviation."""
    return result.known or "no reason given"


def reason_of(result: Result) -> str:
    """Return the reason of a result."""
    return result.reason


def repeating(selection: Mapping[str, Any]) -> str:
    """Return what a command that re-runs a check of a run starts with, see `Run.selection`."""
    command = " ".join(["mbcheck check", *custom_words(selection)])
    for spec in selection["engines"]:
        command += f" --engine {shlex.quote(spec)}" if ":" in spec else ""
    command += "" if selection["profile"] == "default" else f" --profile {selection['profile']}"
    return command + (" --full" if selection["full"] else "")


def custom_words(selection: Mapping[str, Any]) -> list[str]:
    """Return the words of a command that name a user's own parameters."""
    if "parameters" not in selection:
        return []
    words = list(selection["scenes"])
    for option, name in (("--set", "parameters"), ("--state", "state")):
        for key, value in selection[name].items():
            words += [option, shlex.quote(f"{key}={value}")]
    return words + ([] if selection["horizon"] is None else [f"--horizon {selection['horizon']}"])


def rerun(result: Result, command: str = "mbcheck check") -> str:
    """Return the shell command that runs the check of a result, and no other."""
    quoted = result.id.replace("'", "'\\''")
    return f"{command} --id '{quoted}'"


def digits_to_differ(result: Result) -> int:
    """Return how many significant digits show that value and reference differ."""
    if not (result.value and result.error):
        return 3
    return min(17, max(3, 2 + math.ceil(math.log10(abs(result.value) / result.error))))


def with_unit(value: float | None, unit: str, digits: int = 3) -> str:
    """Return a number with its unit."""
    text = number(value, digits)
    return text if value is None or unit in ("", "1") else f"{text} {unit}"


def number(value: float | None, digits: int = 3) -> str:
    """Return a number with so many significant digits, or "none"."""
    return "none" if value is None else f"{value:.{digits}g}"


def check_of(result: Result) -> str:
    """Return what the ids of all results of one check begin with."""
    return result.id.rpartition("/")[0]


def method_of(result: Result) -> str:
    """Return the method segment of a result's id, which also tells the model."""
    return result.id.split("/")[-2]


def is_trajectory(result: Result) -> bool:
    """Return whether a result is a trajectory's error in one observable."""
    return result.kind == "trajectory" and result.error is not None


def headline_quantity(results: Sequence[Result]) -> str | None:
    """Return the quantity by which methods are compared: the first of the trajectories."""
    return next((r.quantity for r in results if is_trajectory(r)), None)


def error_size(result: Result) -> float:
    """Return the error of a result; infinite where it has none."""
    error = finite(result.error)
    return math.inf if error is None else error


def ratio(result: Result) -> float:
    """Return error / tolerance of a result; infinite where it has none."""
    error, tolerance = finite(result.error), finite(result.tolerance)
    if error is None or tolerance is None:
        return math.inf
    if tolerance > 0:
        return error / tolerance
    return math.inf if error > 0 else 0.0


def worst(results: Sequence[Result]) -> Verdict:
    """Return the worst verdict of results; ``skipped`` if nothing ran."""
    present = {result.verdict for result in results}
    return next((verdict for verdict in SEVERITY if verdict in present), "skipped")


def grouped(
    results: Iterable[Result], key: Callable[[Result], tuple[str, ...]]
) -> dict[tuple[str, ...], list[Result]]:
    """Return results by key, in the order in which keys first appear."""
    groups: dict[tuple[str, ...], list[Result]] = {}
    for result in results:
        groups.setdefault(key(result), []).append(result)
    return groups
