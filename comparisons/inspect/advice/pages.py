"""What a user's model needs: on the console, as Markdown, and as a picture."""

from __future__ import annotations

from math import inf
from pathlib import Path
from typing import Any

from rich.console import Console

from ...reports.drawing import INK, PALETTE, label, new_figure
from ...reports.text import markdown_table, print_table, print_wrapped
from ...reports.words import plain
from .advice import Advice
from .converged import percent
from .outcome import Trial
from .words import legend, what

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

NEAR = 1.6
"""Times by which points must differ for both to have a label."""

LOST = 3.0
"""Error at which the picture shows a run that has lost its state."""


def rows(advice: Advice) -> list[tuple[object, ...]]:
    """Return the table: fastest first; ``>`` is the choice, ``*`` the front, ``=`` the file's."""
    front, ordered = advice.front, sorted(advice.telling, key=lambda one: one.seconds)
    return [row(advice, one, one in front) for one in ordered]


def row(advice: Advice, one: Trial, best: bool) -> tuple[object, ...]:
    """Return what a trial was, in words."""
    marks = (">", one is advice.choice), ("*", best), ("=", one is advice.own)
    return (
        "".join(mark for mark, applies in marks if applies),
        kind_of(one),
        1e3 * one.step,
        percent(one.error),
        percent(one.energy) if not one.failed else None,
        one.violation if one.violation and not one.failed else None,
        one.seconds,
        1e3 * one.limit if one.limit < inf else None,
        f"state lost: {one.failed}" if one.failed else "",
    )


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
    """Draw errors over processor time, each integrator a line, its steps beside the points."""
    drawn, panels = new_figure(height=4.0)
    axes = panels[0, 0]
    axes.set_xscale("log")
    axes.set_yscale("log")
    kinds = dict.fromkeys(kind_of(one) for one in advice.telling)
    for number, kind in enumerate(kinds):
        draw_kind(axes, advice, kind, PALETTE[number % len(PALETTE)])
    if any(one.error == inf for one in advice.trials):
        axes.plot([], [], "x", color=INK, label="state lost")
    axes.axhline(advice.asked.target, color=INK, linewidth=0.8, linestyle=(0, (4, 2)))
    axes.annotate(
        f"target {percent(advice.asked.target)}", (1, advice.asked.target), (-2, 3), ha="right",
        xycoords=axes.get_yaxis_transform(), textcoords="offset points", fontsize=8, color=INK,
    )  # fmt: skip
    if (choice := advice.choice) is not None:
        axes.plot(
            choice.seconds, choice.error, "o", markersize=11, markerfacecolor="none",
            markeredgecolor=INK, label=f"recommended: {choice.setting.name}",
        )  # fmt: skip
    if advice.own is not None and advice.own.error < inf:
        name = f"as in the file: {advice.own.setting.name}"
        axes.plot(advice.own.seconds, advice.own.error, "s", color=INK, label=name)
    axes.legend(fontsize=7, frameon=False)
    over = f"error over {advice.compared:.3g} s against its converged run"
    title = f"{Path(advice.file).name}: {over}"
    label(
        axes, "processor time per simulated second [s/s]", f"largest error of {what(advice)}", title
    )
    return drawn


def kind_of(one: Trial) -> str:
    """Return what settings that differ by their step alone are called."""
    words = [one.integrator]
    words += ["hard closures"] if one.setting.closure else []
    words += [f"{one.setting.iterations} iterations"] if one.setting.iterations else []
    return ", ".join(words)


def draw_kind(axes: Any, advice: Advice, kind: str, colour: str) -> None:
    """Draw the settings of a kind, a cross for what lost its state."""
    mine = sorted((t for t in advice.telling if kind_of(t) == kind), key=lambda t: t.step)
    ended = [one for one in mine if 0 < one.error < inf]
    times, errors = [one.seconds for one in ended], [one.error for one in ended]
    axes.plot(times, errors, "o-", color=colour, label=kind)
    lost = [one for one in mine if one.error == inf]
    axes.plot([one.seconds for one in lost], [LOST] * len(lost), "x", color=colour)
    for one in (ended[0], ended[-1]) if len(ended) > 1 else ended:
        if any(crowded(text.xy, (one.seconds, one.error)) for text in axes.texts):
            continue
        axes.annotate(
            f"{1e3 * one.step:.3g} ms", (one.seconds, one.error), (4, 4),
            textcoords="offset points", fontsize=7, color=INK,
        )  # fmt: skip


def crowded(one: tuple[float, float], other: tuple[float, float]) -> bool:
    """Return whether labels at two points, on logarithmic axes, would hide each other."""
    ratios = (max(a, b) / min(a, b) for a, b in zip(one, other, strict=True))
    return all(ratio < NEAR for ratio in ratios)
