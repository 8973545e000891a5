"""What accuracy costs, as tables: for the console and, as Markdown, for a page."""

from __future__ import annotations

from rich.console import Console

from ..reports.drawing import named
from ..reports.text import markdown_table, print_line, print_table, print_wrapped
from ..reports.words import number
from .closures import LoopClosure
from .elements import Fewest
from .minimal import LeftOut
from .report import Choice, Tradeoff
from .series import StepSeries
from .stability import STEPS, BoundaryShift
from .sweep import settings_text

DIGITS = 2
"""Of errors and times."""

LIMITS, SHIFTS = "What limits the methods", "What a step costs in stability"
"""Titles under which a page shows pictures."""

Row = tuple[object, ...]


def tables(result: Tradeoff) -> list[tuple[str, tuple[str, ...], list[Row]]]:
    """Return title, heads and rows of all tables that are not empty."""
    least = result.minimal
    every = [
        ("Cheapest settings", CHOICE, [choice(item) for item in result.choices]),
        (LIMITS, LIMIT, [limits(one) for one in result.series]),
        ("Fewest parts of a beam", FEWEST, [fewest(item) for item in least.fewest]),
        ("Softest closure of a loop", CLOSURE, [closure(item) for item in least.closures]),
        ("What may be left out", LEFT_OUT, [left_out(item) for item in least.left_out]),
        (SHIFTS, STABILITY, [shifts(item) for item in result.stability]),
    ]
    return [(title, heads, rows) for title, heads, rows in every if rows]


CHOICE = (
    "scene", "engine", "target", "model, method", "step [s]", "error", "time [s/s]",
    "limited by", "margin",
)  # fmt: skip
LIMIT = (
    "scene", "engine, model", "method", "order", "fitted", "floor", "from step [s]", "named",
)  # fmt: skip
FEWEST = (
    "engine",
    "beam",
    "case",
    "of",
    "target",
    "parts",
    "error",
    "one less",
    "step [s]",
    "note",
)
CLOSURE = ("engine, model", "target", "softest", "leaves", "step [s]", "time [s/s]", "note")
LEFT_OUT = ("scene", "engine", "left out", "error with", "without", "cost ratio", "verdict")
STABILITY = (
    "scene", "shift of", "engine, model", "method", "order", *map(str, STEPS), "fitted", "floor",
)  # fmt: skip


def choice(item: Choice) -> Row:
    """Return a recommendation."""
    names = (item.scene, item.engine, number(item.target, 6))
    if item.step is None or item.cost is None:
        return (*names, "none", "", item.error, "", item.limit, "")
    return (
        *names,
        " ".join(filter(None, [item.model, item.method, settings_text(item.settings or {})])),
        number(item.step, 3),
        item.error,
        item.cost.seconds,
        item.limit,
        item.margin,
    )


def limits(one: StepSeries) -> Row:
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


def fewest(item: Fewest) -> Row:
    """Return how many parts a beam needs."""
    count = "none" if item.count is None else f"{item.count} {item.part}"
    return (
        item.engine, item.kind, item.case, item.quantity, number(item.target, 6),
        f"{count} (extrapolated)" if item.extrapolated else count,
        item.error, item.fewer, item.step, item.reason,
    )  # fmt: skip


def closure(item: LoopClosure) -> Row:
    """Return how softly a loop may be closed."""
    value = "-" if item.value is None else f"{item.knob} {number(item.value)} {item.unit}"
    return (
        f"{item.engine} {item.model}", number(item.target, 6), value, item.error,
        item.step, None if item.cost is None else item.cost.seconds, item.reason,
    )  # fmt: skip


def left_out(item: LeftOut) -> Row:
    """Return what leaving something out costs or saves."""
    return (
        item.scene, item.engine, f"{item.left_out} ({item.compared})", item.error_with,
        item.error_without, item.cost_ratio, item.verdict,
    )  # fmt: skip


def shifts(item: BoundaryShift) -> Row:
    """Return by how much a method shifts a boundary point."""
    return (
        item.scene, named(item.parameter, item.unit), f"{item.engine} {item.model}", item.method,
        item.order, *item.shifts, number(item.slope, 3, missing="-"), item.floor,
    )  # fmt: skip


INTRODUCTION = """# What accuracy costs

`mbcheck tradeoff` wrote this page. Every method of every engine ran a case of each scene over
halved steps, and over what else limits it: the closure of a loop, the tolerance of a solver, the
number of rods or elements. An error is the largest of all observables over the run, relative to the
size of each, against the scene's reference. A time is the median wall time of the stepping per
simulated second on one machine; take it as a ratio.

*Cheapest settings*: of all that were run, the cheapest whose error, and that with half the step,
meet the target; the shortest step of all only at its floor. *limited by*: what has the largest
share in the error: the step, or what no step removes. *margin*: longest stable step by theory over
this step. *What limits the methods*: the order fitted above the floor, the floor and its name, and
from which step on halving is wasted. *What a step costs in stability*: by how much the parameter at
which a periodic orbit loses its stability is shifted with so many steps in a period; the order of
the last halving above the floor, which rounding and differences leave.
"""


def markdown(result: Tradeoff) -> str:
    """Return the page: what `docs/tradeoff.md` is."""
    parts = [
        f"## {title}\n\n{markdown_table(heads, rows, DIGITS)}\n"
        for title, heads, rows in tables(result)
    ]
    return "\n".join([INTRODUCTION, *parts])


def show(console: Console, result: Tradeoff) -> None:
    """Print all tables."""
    for title, heads, rows in tables(result):
        print_line(console, title, "bold")
        print_table(console, heads, rows, DIGITS)
    for words in result.failures:
        print_wrapped(console, words)
