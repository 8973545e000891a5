"""What a user's model needs: on the console, as Markdown, and as a picture."""

from __future__ import annotations

from math import inf
from typing import Any

from rich.console import Console

from ...reports.drawing import FAINT, INK, PALETTE, label, new_figure
from ...reports.text import markdown_table, print_table, print_wrapped
from ...reports.words import plain
from .advice import Advice, Trial, percent

HEADS = (
    "",
    "integrator",
    "step [ms]",
    "error",
    "energy",
    "violation",
    "time [s/s]",
    "limit [ms]",
    "",
)
DIGITS = 2

LOST = 3.0
"""Error at which the picture shows a run that has lost its state."""


def rows(advice: Advice) -> list[tuple[object, ...]]:
    """Return the table: fastest first; ``>`` is the choice, ``*`` the front, ``=`` the file's."""
    front, ordered = advice.front, sorted(advice.trials, key=lambda one: one.seconds)
    return [row(advice, one, one in front) for one in ordered]


def row(advice: Advice, one: Trial, best: bool) -> tuple[object, ...]:
    """Return what a trial was, in words."""
    marks = (">", one is advice.choice), ("*", best), ("=", one is advice.own)
    return (
        "".join(mark for mark, applies in marks if applies),
        one.integrator,
        1e3 * one.step,
        percent(one.error),
        percent(one.energy) if not one.failed else None,
        one.violation or None,
        one.seconds,
        1e3 * one.limit if one.limit < inf else None,
        f"state lost: {one.failed}" if one.failed else "",
    )


def legend(advice: Advice) -> str:
    """Return what the table shows."""
    return (
        f"> chosen, * on the front, = as in the file. Largest error of {what(advice)} over "
        f"{advice.compared:.3g} s from {len(advice.truths)} starts, in the size of the motion; the "
        "converged run is known to "
        f"{percent(max((float(t.error[: t.count].max()) for t in advice.truths), default=0.0))}."
    )


def what(advice: Advice) -> str:
    """Return what is compared, in words."""
    return ", ".join(advice.observed) or "all joints"


def show(console: Console, advice: Advice) -> None:
    """Print the sentence, what else is to be known, and the table."""
    print_wrapped(console, advice.sentence)
    for note in advice.notes:
        print_wrapped(console, f"note: {note}", "  ")
    if advice.trials:
        console.print()
        print_table(console, HEADS, rows(advice), DIGITS)
        print_wrapped(console, legend(advice))


def markdown(advice: Advice) -> str:
    """Return the same as a page."""
    parts = [f"## {plain(advice.file)}", f"**{plain(advice.sentence)}**"]
    parts += ["\n".join(f"* {plain(note)}" for note in advice.notes)] if advice.notes else []
    if advice.trials:
        parts += [markdown_table(HEADS, rows(advice), DIGITS), plain(legend(advice))]
    return "\n\n".join(parts) + "\n"


def figure(advice: Advice) -> Any:
    """Draw errors over wall time, each integrator a line, its steps beside the points."""
    drawn, panels = new_figure(height=4.0)
    axes = panels[0, 0]
    axes.set_xscale("log")
    axes.set_yscale("log")
    names = dict.fromkeys(one.integrator for one in advice.trials)
    for name, colour in zip(names, PALETTE, strict=False):
        mine = sorted((t for t in advice.trials if t.integrator == name), key=lambda t: t.step)
        ended = [one for one in mine if one.error < inf and one.error > 0]
        axes.plot(
            [t.seconds for t in ended], [t.error for t in ended], "o-", color=colour, label=name
        )
        lost = [one for one in mine if one.error == inf]
        axes.plot([t.seconds for t in lost], [LOST] * len(lost), "x", color=colour)
        for one in (ended[0], ended[-1]) if len(ended) > 1 else ended:
            axes.annotate(
                f"{1e3 * one.step:.3g} ms", (one.seconds, one.error), (4, 4),
                textcoords="offset points", fontsize=7, color=INK,
            )  # fmt: skip
    axes.axhline(advice.target, color=FAINT, linewidth=0.8)
    if advice.choice is not None:
        axes.plot(
            advice.choice.seconds, advice.choice.error, "o", markersize=11,
            markerfacecolor="none", markeredgecolor=INK, label="recommended",
        )  # fmt: skip
    if advice.own is not None and advice.own.error < inf:
        axes.plot(advice.own.seconds, advice.own.error, "s", color=INK, label="as in the file")
    axes.legend(fontsize=8, frameon=False)
    title = f"error over {advice.compared:.3g} s against the converged run"
    label(axes, "wall time per simulated second [s/s]", f"largest error of {what(advice)}", title)
    return drawn
