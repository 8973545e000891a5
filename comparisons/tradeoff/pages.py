"""Reports on the cost of accuracy: on the console and as Markdown."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import replace

from ..reports.files import Destination
from ..reports.sections import Section, print_sections
from ..reports.text import markdown_table
from ..reports.words import number, plain, plural, with_unit
from ..terminal.program import console, json_text, to_stdout
from .model import ModelTradeoff
from .report import Tradeoff
from .stability import StabilityShift
from .table import (
    Choice,
    StepSeries,
    Trial,
    cheapest_run,
    percent,
    settings_text,
    trials_of,
)

DIGITS = 2
"""Significant digits of errors and times."""

LIMITS = "What limits the methods"
"""Title of the section with the pictures."""

CHOICE = (
    "scene", "engine", "target", "setting", "step [s]", "error", "time [s/s]", "margin",
    "limited by",
)  # fmt: skip
LIMIT = (
    "scene", "engine, model", "method", "order", "fitted", "floor", "from step [s]", "named",
)  # fmt: skip
EACH = ("scene", "engine, model", "method", "stable up to [s]", "smallest error")
"""Heads of the steps of each method, before those of the targets."""

RUNS = (
    "", "integrator", "step [ms]", "error", "energy", "violation", "time [s/s]", "limit [ms]",
)  # fmt: skip

LEFT_OUT = (
    "scene", "engine", "left out", "model with it", "model without", "error", "error without",
    "leaving it out",
)  # fmt: skip

Row = tuple[object, ...]


def sections(result: Tradeoff | ModelTradeoff) -> list[Section]:
    """Return the parts of a report; tables without rows are left out."""
    tables: list[tuple[str, Sequence[str], list[Row]]]
    if isinstance(result, ModelTradeoff):
        ordered = sorted(result.trials, key=lambda trial: trial.seconds)
        tables = [("", RUNS, [run_cells(result, trial) for trial in ordered])]
        request = result.request
        lines = [
            result.sentence,
            f"target: {percent(request.target)} of the motion (--target), in runs of "
            f"{request.horizon:g} s (--horizon), within {request.budget:g} s (--budget)",
            *(f"note: {note}" for note in result.notes),
        ]
        lost = (line for one in result.series for line in losses(one))
        last = [legend(result), *lost] if ordered else []
    else:
        steps = [one for one in result.recommendations if one.axis == "step"]
        models = [one for one in result.recommendations if one.axis != "step"]
        tables = [
            ("Cheapest settings", CHOICE, [choice_cells(one) for one in steps]),
            ("Step of each method that meets a target", *steps_table(result)),
            ("Smallest models", CHOICE, [choice_cells(one) for one in models]),
            (
                "What may be left out",
                LEFT_OUT,
                [
                    (
                        one.scene,
                        one.engine,
                        one.left_out,
                        one.whole,
                        one.without,
                        one.error,
                        one.error_without,
                        one.saving,
                    )
                    for one in result.left_out
                ],
            ),
            (
                LIMITS,
                LIMIT,
                [
                    (
                        one.scene,
                        f"{one.engine} {one.model}",
                        " ".join(filter(None, [one.method, settings_text(one.settings)])),
                        one.order,
                        number(one.slope, 3, missing="-"),
                        one.plateau,
                        min(
                            (p.step for p in one.points if p.error is not None and not p.wasted),
                            default=None,
                        )
                        if one.plateau is not None
                        else None,
                        one.plateau_name or "none met",
                    )
                    for one in result.series
                ],
            ),
            ("What a step costs in stability", *stability_table(result.stability)),
        ]
        targets = ", ".join(map(percent, result.targets))
        lines, last = [f"targets: {targets} of the motion (--target)"], list[str]()
        lines += [f"note: {note}" for note in result.failures]
    full_tables = [Section(*table, digits=DIGITS) for table in tables if table[2]]
    parts = [Section(lines=lines), *full_tables, Section(lines=last)]
    return [part for part in parts if part.rows or part.lines]


def choice_cells(item: Choice) -> Row:
    """Return a recommendation: the cheapest setting, or the smallest model."""
    words, note = [item.model, item.method, settings_text(item.settings or {})], item.limit
    if item.axis != "step":
        words = [item.model, f"{item.method}:", item.axis, with_unit(item.value, item.unit, 6)]
        note = note if item.met else f"{item.axis}: {note}"
    setting = " ".join(filter(None, words)) if item.met else "none"
    if item.smaller is not None:
        note += f"; the next smaller model has an error of {item.smaller:.2g}"
    return (
        item.scene, item.engine, number(item.target, 6), setting,
        "" if item.step is None else number(item.step, 3), item.error,
        item.cost.seconds if item.cost else "", item.margin if item.step else "", note,
    )  # fmt: skip


def steps_table(result: Tradeoff) -> tuple[Sequence[str], list[Row]]:
    """Return heads and rows of the cheapest step with which each method meets each target."""
    rows = list[Row]()
    for one in (one for one in result.series if not one.settings):
        best = (cheapest_run([one], target) for target in result.targets)
        steps = ("-" if trial is None else number(trial.point.step, 3) for trial in best)
        least = min((trial.error for trial in trials_of([one])), default=None)
        stable = number(one.stable_step, 3, missing="-")
        rows.append((one.scene, f"{one.engine} {one.model}", one.method, stable, least, *steps))
    return (*EACH, *(f"{percent(target)} [s]" for target in result.targets)), rows


def stability_table(shifts: Sequence[StabilityShift]) -> tuple[Sequence[str], list[Row]]:
    """Return heads and rows of the shifts of boundaries, by the step as a share of the period T."""
    counts = list(shifts[0].shifts) if shifts else []
    steps = [f"T/{count}" for count in counts]
    heads = ("scene", "shift of", "engine, model", "method", "order", *steps, "fitted", "floor")
    rows: list[Row] = [
        (
            one.scene,
            f"{one.parameter.replace('_', ' ')} [{one.unit}]",
            f"{one.engine} {one.model}",
            one.method,
            one.order,
            *(number(one.shifts[count], DIGITS, missing="-") for count in counts),
            number(one.slope, 3, missing="-"),
            one.floor,
        )
        for one in shifts
    ]
    return heads, rows


def run_cells(result: ModelTradeoff, trial: Trial) -> Row:
    """Return a run of a file; ``>`` marks the choice, ``*`` the front, ``=`` the file's setting."""
    point, limit = trial.point, trial.series.stable_step
    marks: dict[str, list[Trial | None]] = {
        ">": [result.choice],
        "*": [*result.front],
        "=": [result.own],
    }
    return (
        "".join(mark for mark, of in marks.items() if point in [one and one.point for one in of]),
        trial.series.setting,
        number(1e3 * point.step, 4),
        percent(point.error),
        percent(point.errors["energy"]) if point.errors else None,
        point.errors.get("violation") or None,
        trial.seconds,
        None if limit is None else number(1e3 * limit, 4),
    )


def losses(series: StepSeries) -> Iterator[str]:
    """Yield the steps with which runs lose their state, and where the shortest of them does."""
    if lost := [point for point in series.points if point.reason]:
        steps = ", ".join(number(1e3 * point.step, 4) for point in lost)
        yield f"{series.setting} loses its state at {steps} ms: {lost[-1].reason}"


def legend(result: ModelTradeoff) -> str:
    """Return the meaning of the columns."""
    observed = ", ".join(result.request.observed) or "all joints"
    return (
        f"> chosen, * on the front, = as in the file. error: largest error of {observed} "
        f"over {result.compared:.3g} s from {plural(len(result.truths), 'start')}, relative to the "
        f"motion; the uncertainty of the converged run is {percent(result.largest('error'))}. "
        "energy: largest difference from the converged run, relative to the largest kinetic "
        "energy. violation: largest residual of an equality (m, rad). time: median processor time "
        "on this machine. limit: largest stable step of small motions."
    )


INTRODUCTION = """# What accuracy costs

`mbcheck tradeoff` wrote this page. Every method of every engine ran a case of each scene over
halved steps, and over other options that limit it: the closure of a loop, the tolerance of a
solver, the number of rods or elements. An error is the largest of all observables over the run,
relative to the size of each, against the scene's reference. A time is the median wall time of the
stepping per simulated second on one machine; compare times by their ratios only.

*Cheapest settings*: the cheapest setting whose error meets the target, as with all shorter steps;
the shortest step of all counts only at its floor. *Step of each method*: the same of one method
alone, without other options, for each target; `-`: none meets it. *limited by*: the largest part of
the error, from the step or from a limit that no step removes. *margin*: largest stable step by
theory over this step. *Smallest models*: the fewest segments and the coarsest option of an engine
from which on all models meet the target, with the cheapest step. *What may be left out*: errors of
a model with a part and without it, by the same short step, and the cost of both; errors of theories
are against the one with the part. *What limits the methods*: the order fitted above the floor, the
floor and its name, and the step from which on halving is wasted. *What a step costs in stability*:
shift of the parameter at which a periodic orbit loses its stability, by steps of a share of the
period T; the order of the last halving above the floor, which is round-off.
"""


def markdown(result: Tradeoff | ModelTradeoff, pictures: Sequence[tuple[str, str]] = ()) -> str:
    """Return the page as Markdown; for all scenes it is `docs/tradeoff.md`.

    Parameters
    ----------
    result : Tradeoff or ModelTradeoff
    pictures : sequence of (title, file)
        Pictures, and the titles of their sections.
    """
    parts = [INTRODUCTION.strip()]
    if isinstance(result, ModelTradeoff):
        parts = [f"## {plain(result.file)}"]
    for section in sections(result):
        parts += [f"## {section.title}"] if section.title else []
        parts += [f"![{title}]({file})" for title, file in pictures if title == section.title]
        if section.rows:
            parts.append(markdown_table(section.heads, section.rows, DIGITS))
        else:
            parts.append("\n".join(f"* {plain(line)}" for line in section.lines))
    return "\n\n".join(parts) + "\n"


def write(
    result: ModelTradeoff | Tradeoff,
    json_file: Destination | None,
    markdown_file: Destination | None,
    plot: Destination | None,
) -> None:
    """Write document, page and pictures, or print the tables if nothing goes to standard output."""
    if json_file:
        json_file.write(json_text(result.as_json()))
    drawn: list[tuple[str, str]] = []
    try:
        if plot:
            from ..reports.drawing import save_and_close
            from .draw import pictures

            for title, path, figure in pictures(result, plot.path):
                save_and_close(figure, path)
                drawn.append((title, str(path)))
    finally:
        if markdown_file:
            folder = markdown_file.path.parent
            links = [
                (title, os.path.relpath(path, folder).replace(os.sep, "/")) for title, path in drawn
            ]
            markdown_file.write(markdown(result, links))
    if not to_stdout(json_file, markdown_file):
        print_sections(console(), map(with_headings, sections(result)))


def with_headings(section: Section) -> Section:
    """Return a table of scenes with its first two columns as headings above their rows."""
    if not section.title:
        return section
    groups = dict[str, list[Sequence[object]]]()
    for first, second, *rest in section.rows:
        groups.setdefault(f"{first} {second}", []).append(rest)
    rows = [
        row for name, rest in groups.items() for row in ([name, *[""] * (len(rest[0]) - 1)], *rest)
    ]
    return replace(section, heads=section.heads[2:], rows=rows)
