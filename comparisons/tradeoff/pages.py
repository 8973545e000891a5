"""What accuracy costs, as tables: for the console and, as Markdown, for a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from .choice import Choice
from .closures import Closure
from .elements import Fewest
from .left_out import LeftOut
from .report import Tradeoff
from .series import Series
from .sweep import settings_text


class Page(NamedTuple):
    """A table: its title, heads and rows of words."""

    title: str
    heads: tuple[str, ...]
    rows: list[tuple[str, ...]]


def number(value: float | None, digits: int = 2) -> str:
    """Return a number in words, a dash if there is none."""
    return "-" if value is None else f"{value:.{digits}g}"


def tables(found: Tradeoff) -> Iterator[Page]:
    """Yield all tables that are not empty."""
    least = found.minimal
    for title, heads, rows in (
        ("Cheapest settings", CHOICE, [choice(item) for item in found.choices]),
        ("What limits the methods", LIMIT, [limits(one) for one in found.series]),
        ("Fewest parts of a beam", FEWEST, [fewest(item) for item in least.fewest]),
        ("Softest closure of a loop", CLOSURE, [closure(item) for item in least.closures]),
        ("What may be left out", LEFT_OUT, [left_out(item) for item in least.left_out]),
    ):
        if rows:
            yield Page(title, heads, rows)


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


def choice(item: Choice) -> tuple[str, ...]:
    """Return a recommendation."""
    names = (item.scene, item.engine, f"{item.target:g}")
    if item.step is None or item.cost is None:
        return (*names, "none", "", number(item.error), "", item.limit, "")
    settings = settings_text(item.settings or {})
    return (
        *names,
        " ".join(filter(None, [item.model, item.method, settings])),
        number(item.step, 3),
        number(item.error),
        number(item.cost.seconds),
        item.limit,
        number(item.margin),
    )


def limits(one: Series) -> tuple[str, ...]:
    """Return what limits a method: its order, its floor, and from where on halving is wasted."""
    useful = [point.step for point in one.points if point.error is not None and not point.wasted]
    return (
        one.scene,
        f"{one.engine} {one.model}",
        " ".join(filter(None, [one.method, settings_text(one.settings)])),
        str(one.order),
        number(one.slope, 3),
        number(one.plateau),
        "-" if one.plateau is None else number(useful[-1]),
        one.plateau_name or "none met",
    )


def fewest(item: Fewest) -> tuple[str, ...]:
    """Return how many parts a beam needs."""
    count = "none" if item.count is None else f"{item.count} {item.part}"
    return (
        item.engine, item.kind, item.case, item.quantity, f"{item.target:g}",
        f"{count} (extrapolated)" if item.extrapolated else count,
        number(item.error), number(item.fewer), number(item.step), item.reason,
    )  # fmt: skip


def closure(item: Closure) -> tuple[str, ...]:
    """Return how softly a loop may be closed."""
    value = "-" if item.value is None else f"{item.knob} {item.value:.3g} {item.unit}"
    return (
        f"{item.engine} {item.model}", f"{item.target:g}", value, number(item.error),
        number(item.step), "-" if item.cost is None else number(item.cost.seconds), item.reason,
    )  # fmt: skip


def left_out(item: LeftOut) -> tuple[str, ...]:
    """Return what leaving something out costs or saves."""
    return (
        item.scene, item.engine, f"{item.left_out} ({item.compared})", number(item.error_with),
        number(item.error_without), number(item.cost_ratio), item.verdict,
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
from which step on halving is wasted.
"""


def markdown(found: Tradeoff) -> str:
    """Return the page: what `docs/tradeoff.md` is."""
    lines = [INTRODUCTION]
    for page in tables(found):
        lines += [f"## {page.title}", "", row(page.heads), f"|{' --- |' * len(page.heads)}"]
        lines += [*map(row, page.rows), ""]
    return "\n".join(lines).rstrip() + "\n"


def row(cells: Sequence[str]) -> str:
    """Return a row of a Markdown table."""
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def show(console: Any, found: Tradeoff) -> None:
    """Print all tables."""
    from ..reports.tables import show as say
    from ..reports.tables import table

    for page in tables(found):
        say(console, page.title)
        table(console, page.heads, page.rows, narrow=True)
    for words in found.failures:
        say(console, words)
