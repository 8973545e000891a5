"""What accuracy costs, for the console and as Markdown: of scenes, or of an MJCF file."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console

from ..reports.sections import Section, print_sections
from ..reports.text import markdown_table
from ..reports.words import number, plain, plural, with_unit
from .left_out import LeftOut
from .model import ModelTradeoff
from .report import Tradeoff
from .stability import StabilityShift
from .table import Choice, StepSeries, Trial, percent, settings_text

DIGITS = 2
"""Significant digits of errors and times."""

LIMITS = "What limits the methods"
"""Title under which a page shows pictures."""

CHOICE = (
    "scene", "engine", "target", "setting", "step [s]", "error", "time [s/s]", "margin",
    "limited by",
)  # fmt: skip
LIMIT = (
    "scene", "engine, model", "method", "order", "fitted", "floor", "from step [s]", "named",
)  # fmt: skip
RUNS = (
    "", "integrator", "step [ms]", "error", "energy", "violation", "time [s/s]", "limit [ms]", "",
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
        lines = [result.sentence, *(f"note: {note}" for note in result.notes)]
        last = [legend(result)] if ordered else []
    else:
        steps = [one for one in result.recommendations if one.axis == "step"]
        models = [one for one in result.recommendations if one.axis != "step"]
        tables = [
            ("Cheapest settings", CHOICE, [choice_cells(one) for one in steps]),
            ("Smallest models", CHOICE, [choice_cells(one) for one in models]),
            (
                "What may be left out",
                LEFT_OUT,
                [left_out_cells(one) for one in result.left_out],
            ),
            (LIMITS, LIMIT, [limit_cells(one) for one in result.series]),
            ("What a step costs in stability", *stability_table(result.stability)),
        ]
        lines, last = [f"note: {note}" for note in result.failures], []
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
        note += f"; the next smaller has an error of {item.smaller:.2g}"
    return (
        item.scene, item.engine, number(item.target, 6), setting,
        "" if item.step is None else number(item.step, 3), item.error,
        item.cost.seconds if item.cost else "", item.margin if item.step else "", note,
    )  # fmt: skip


def limit_cells(one: StepSeries) -> Row:
    """Return what limits a method: its order, its floor, and from where on halving is wasted."""
    useful = [point.step for point in one.points if point.error is not None and not point.wasted]
    return (
        one.scene,
        f"{one.engine} {one.model}",
        " ".join(filter(None, [one.method, settings_text(one.settings)])),
        one.order,
        number(one.slope, 3, missing="-"),
        one.plateau,
        None if one.plateau is None else useful[-1],
        one.plateau_name or "none met",
    )


def left_out_cells(one: LeftOut) -> Row:
    """Return a model with something and one without it."""
    return (
        one.scene, one.engine, one.left_out, one.whole, one.without, one.error, one.error_without,
        one.saving,
    )  # fmt: skip


def stability_table(shifts: Sequence[StabilityShift]) -> tuple[Sequence[str], list[Row]]:
    """Return heads and rows of the shifts of boundaries, over steps in a period."""
    counts = list(shifts[0].shifts) if shifts else []
    heads = ("scene", "shift of", "engine, model", "method", "order", *counts, "fitted", "floor")
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
    """Return a run of a file; ``>`` is the choice, ``*`` the front, ``=`` the file's setting."""
    point, limit = trial.point, trial.series.stable_step
    marks: dict[str, list[Trial | None]] = {
        ">": [result.choice],
        "*": [*result.front],
        "=": [result.own],
    }
    return (
        "".join(mark for mark, of in marks.items() if point in [one and one.point for one in of]),
        trial.series.setting,
        1e3 * point.step,
        percent(point.error),
        percent(point.errors["energy"]) if point.errors else None,
        point.errors.get("violation") or None,
        trial.seconds,
        None if limit is None else 1e3 * limit,
        f"state lost: {point.reason}" if point.reason else "",
    )


def legend(result: ModelTradeoff) -> str:
    """Return the meaning of the columns."""
    return (
        f"> chosen, * on the front, = as in the file. error: the largest of {result.observed} over "
        f"{result.compared:.3g} s from {plural(len(result.truths), 'start')}, relative to the "
        f"motion; the uncertainty of the converged run is {percent(result.largest('error'))}. "
        "energy: largest difference from the converged run's, relative to the largest kinetic "
        "energy. violation: largest residual of an equality (m, rad). time: of the processor, "
        "median of the runs on this machine. limit: the largest stable step of small motions."
    )


INTRODUCTION = """# What accuracy costs

`mbcheck tradeoff` wrote this page. Every method of every engine ran a case of each scene over
halved steps, and over what else limits it: the closure of a loop, the tolerance of a solver, the
number of rods or elements. An error is the largest of all observables over the run, relative to the
size of each, against the scene's reference. A time is the median wall time of the stepping per
simulated second on one machine; take it as a ratio.

*Cheapest settings*: of all that were run, the cheapest whose error meets the target, as with all
shorter steps; the shortest step of all only at its floor. *limited by*: what has the largest share
in the error: the step, or what no step removes. *margin*: largest stable step by theory over this
step. *Smallest models*: the fewest segments and the coarsest option of an engine from which on all
that were run meet the target, with the cheapest step that does. *What may be left out*: the errors
of a model with something and without it, by the same short step, and the cost of both; of theories
the errors are against the one that has it. *What limits the methods*: the order fitted above the
floor, the floor and its name, and from which step on halving is wasted. *What a step costs in
stability*: by how much the parameter at which a periodic orbit loses its stability is shifted with
so many steps in a period; the order of the last halving above the floor, which is round-off.
"""


def markdown(result: Tradeoff | ModelTradeoff, pictures: Sequence[tuple[str, str]] = ()) -> str:
    """Return the page as Markdown: of scenes what `docs/tradeoff.md` is.

    Parameters
    ----------
    result : Tradeoff or ModelTradeoff
    pictures : sequence of (title, file)
        Pictures, and the titles below which they are shown.
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


def show(console: Console, result: Tradeoff | ModelTradeoff) -> None:
    """Print the report."""
    print_sections(console, sections(result))
