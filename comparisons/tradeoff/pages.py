"""What accuracy costs, for the console and as Markdown: of scenes, or of an MJCF file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from rich.console import Console

from ..reports.drawing import named
from ..reports.text import markdown_table, print_line, print_table, print_wrapped
from ..reports.words import number, plain, plural, with_unit
from .model import ModelTradeoff
from .report import Tradeoff
from .stability import AXIS, STEPS
from .table import Choice, StepSeries, Trial, percent, settings_text

DIGITS = 2
"""Significant digits of errors and times."""

LIMITS, SHIFTS = "What limits the methods", "What a step costs in stability"
"""Titles under which a page shows pictures."""

CHOICE = (
    "scene", "engine", "target", "setting", "step [s]", "error", "time [s/s]", "margin",
    "limited by",
)  # fmt: skip
LIMIT = (
    "scene", "engine, model", "method", "order", "fitted", "floor", "from step [s]", "named",
)  # fmt: skip
STABILITY = (
    "scene", "shift of", "engine, model", "method", "order", *map(str, STEPS), "fitted", "floor",
)  # fmt: skip
RUNS = (
    "", "integrator", "step [ms]", "error", "energy", "violation", "time [s/s]", "limit [ms]", "",
)  # fmt: skip

Cells = tuple[object, ...]


class Page(NamedTuple):
    """A page: a heading, one sentence, notes, tables with their titles, and a legend."""

    heading: str
    sentence: str
    notes: Sequence[str]
    tables: Sequence[tuple[str, tuple[str, ...], list[Cells]]]
    legend: str


def page_of(result: Tradeoff | ModelTradeoff) -> Page:
    """Return the page of a result; tables without rows are left out."""
    if isinstance(result, ModelTradeoff):
        ordered = sorted(result.trials, key=lambda trial: trial.seconds)
        tables = [("", RUNS, [run_cells(result, trial) for trial in ordered])]
        page = Page(result.file, result.sentence, result.notes, tables, legend(result))
    else:
        choices = [(item.axis == "step", choice_cells(item)) for item in result.choices]
        tables = [
            ("Cheapest settings", CHOICE, [cells for of_step, cells in choices if of_step]),
            ("Smallest models", CHOICE, [cells for of_step, cells in choices if not of_step]),
            (LIMITS, LIMIT, [limit_cells(one) for one in result.series if one.axis == "step"]),
            (SHIFTS, STABILITY, [shift_cells(one) for one in result.series if one.axis == AXIS]),
        ]
        page = Page("", "", result.failures, tables, "")
    return page._replace(tables=[table for table in page.tables if table[2]])


def choice_cells(item: Choice) -> Cells:
    """Return a recommendation: the cheapest setting, or the smallest model."""
    if not item.met:
        setting = "none"
    elif item.axis == "step":
        setting = " ".join(
            filter(None, [item.model, item.method, settings_text(item.settings or {})])
        )
    else:
        setting = f"{item.model} {item.method}".strip() + f": {model_text(item)}"
    note = item.limit
    if item.axis != "step" and item.quantity:
        note = f"{item.case}, {item.quantity.replace('_', ' ')}: {note}"
    if item.smaller is not None and item.axis not in ("step", ""):
        note = f"{note}; the next smaller has an error of {item.smaller:.2g}"
    return (
        item.scene, item.engine, number(item.target, 6), setting,
        "" if item.step is None else number(item.step, 3), item.error,
        item.cost.seconds if item.cost else "", item.margin if item.step else "", note,
    )  # fmt: skip


def model_text(item: Choice) -> str:
    """Return the smallest model on its axis in words."""
    if item.unit == "1" and item.value in (0.0, 1.0):
        return f"{'with' if item.value else 'without'} {item.axis}"
    words = f"{number(item.value, 6)} {item.axis}"
    if item.unit not in ("1", ""):
        words = f"{item.axis} {with_unit(item.value, item.unit)}"
    return f"{words} (extrapolated)" if item.extrapolated else words


def limit_cells(one: StepSeries) -> Cells:
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


def shift_cells(one: StepSeries) -> Cells:
    """Return by how much a method shifts a boundary point."""
    return (
        one.scene, named(one.quantity, one.unit), f"{one.engine} {one.model}", one.method,
        one.order, *(point.errors.get(one.quantity) for point in one.points),
        number(one.slope, 3, missing="-"), one.plateau,
    )  # fmt: skip


def run_cells(result: ModelTradeoff, trial: Trial) -> Cells:
    """Return a run of a file; ``>`` is the choice, ``*`` the front, ``=`` the file's setting."""
    point, limit = trial.point, trial.series.stable_step
    marks = {">": [result.choice], "*": result.front, "=": [result.own]}
    return (
        "".join(mark for mark, of in marks.items() if point in [one and one.point for one in of]),
        trial.series.setting,
        1e3 * (point.step or 0.0),
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
step. *Smallest models*: the fewest rods or elements, the softest closure, and what may be left out,
from which on all larger models meet the target, with the longest step that does. *What limits the
methods*: the order fitted above the floor, the floor and its name, and from which step on halving
is wasted. *What a step costs in stability*: by how much the parameter at which a periodic orbit
loses its stability is shifted with so many steps in a period; the order of the last halving above
the floor, which is round-off.
"""


def markdown(result: Tradeoff | ModelTradeoff) -> str:
    """Return the page as Markdown: of scenes what `docs/tradeoff.md` is."""
    page = page_of(result)
    parts = [f"## {plain(page.heading)}", f"**{plain(page.sentence)}**"]
    if not page.heading:
        parts = [INTRODUCTION.strip()]
    if page.heading and page.notes:
        parts.append("\n".join(f"* {plain(note)}" for note in page.notes))
    for title, heads, rows in page.tables:
        parts += [f"## {title}"] if title else []
        parts.append(markdown_table(heads, rows, DIGITS))
    parts += [plain(page.legend)] if page.legend and page.tables else []
    return "\n\n".join(parts) + "\n"


def show(console: Console, result: Tradeoff | ModelTradeoff) -> None:
    """Print the page."""
    page = page_of(result)
    if page.sentence:
        print_wrapped(console, page.sentence)
    for note in page.notes:
        print_wrapped(console, f"note: {note}", "  ")
    for title, heads, rows in page.tables:
        print_line(console, title, "bold")
        print_table(console, heads, rows, DIGITS)
    if page.legend and page.tables:
        print_wrapped(console, page.legend)
