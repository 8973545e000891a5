"""Figures 2-7 of the hula_hoop paper, drawn again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ...maps.compare import compare
from ...maps.store import Map
from ...reports.drawing import (
    FAINT,
    INK,
    NOTE,
    broad,
    engine_line,
    label,
    look,
    new_figure,
)
from ..drawing import draw_gap, handles_of, outside_legend
from ..ledger import PaperFigure
from ..session import Session
from .results import (
    alike,
    apart,
    approximate_states,
    example_from_rest,
    example_rotation,
    is_class,
    motion_map,
    samples,
    stability_map,
    stable,
    states,
)

OBSERVABLES = (("y [mm]", 1e3), ("theta [rad]", 1.0), ("theta' [rad/s]", 1.0))
PLACES = (0, 1, 3)
"""Of y, theta and theta' in the state."""
PANELS = ("(a) main mass", "(b) angle of the free mass", "(c) its angular velocity")
FIG_3_SECONDS = 3.0

PAPER_LINE = {
    "color": INK,
    "linewidth": 1.0,
    "linestyle": (0, (5, 2)),
    "label": "paper, as printed",
}
CORRECTED_LINE = {"color": "#009E73", "linewidth": 1.0, "label": "with its phase (corrected)"}


def figure_2(session: Session) -> Any:
    """Draw the approximate solutions at 3 Hz, 60 N, over the true rotation."""
    times = samples(1.0)
    truth = states(example_rotation(session))
    lines = {"paper": PAPER_LINE, "corrected": CORRECTED_LINE}
    approximate = {name: approximate_states(name) for name in lines}
    engines = {name: states(example_rotation(session, name)) for name in session.engines}
    figure, axes = new_figure(3, 2, height=1.9, sharex=True)
    for name, values in approximate.items():
        draw_states(axes, times, values, truth, lines[name])
    draw_motion(axes, times, truth, engines)
    finish(figure, axes, "rotation of the reference")
    return figure


def figure_3(session: Session) -> Any:
    """Draw the motion from rest at 3 Hz, 60 N."""
    count = len(samples(FIG_3_SECONDS))
    times = samples(FIG_3_SECONDS)
    truth = states(example_from_rest(session))[:, :count]
    engines = {
        name: states(example_from_rest(session, name))[:, :count] for name in session.engines
    }
    figure, axes = new_figure(3, 2, height=1.9, sharex=True)
    draw_motion(axes, times, truth, engines)
    for panel in axes[:, 0]:
        panel.axvline(1.5, color=INK, linewidth=0.6, linestyle=(0, (1, 2)))
    axes[2, 0].annotate("1.5 s: end of the\ntransient in the paper", (1.55, -85), **NOTE)
    finish(figure, axes, "reference")
    return figure


def draw_motion(axes: Any, times: Array, truth: Array, engines: Mapping[str, Array]) -> None:
    """Draw the reference and the engines, and beside them how far they are apart."""
    for row, (place, (_, scale)) in enumerate(zip(PLACES, OBSERVABLES, strict=True)):
        broad(axes[row, 0], times, scale * truth[place], label=REFERENCE, zorder=1)
        for name, own in engines.items():
            engine_line(axes[row, 0], name, times, scale * own[place])
            draw_gap(axes[row, 1], name, times, scale * apart(own, truth)[place])


def draw_states(
    axes: Any, times: Array, values: Array, truth: Array, line: Mapping[str, Any]
) -> None:
    """Draw an approximate solution, and beside it how far it is from the truth."""
    for row, (place, (_, scale)) in enumerate(zip(PLACES, OBSERVABLES, strict=True)):
        axes[row, 0].plot(times, scale * values[place], zorder=3, **line)
        axes[row, 1].plot(times, scale * apart(values, truth)[place], **line)


def finish(figure: Any, axes: Any, against: str) -> None:
    """Name the panels of figs. 2, 3, and put the legend below."""
    for row, (title, (unit, _)) in enumerate(zip(PANELS, OBSERVABLES, strict=True)):
        last = "time [s]" if row == len(PANELS) - 1 else ""
        label(axes[row, 0], last, unit, title)
        label(axes[row, 1], last, f"|difference|, {unit}", f"from the {against}" if not row else "")
        axes[row, 1].set_yscale("log")
    outside_legend(figure, handles_of(axes[0, 0]))


# Figs. 4-7: markers on a grid

BLUE, CYAN, RED = "#0072B2", "#56B4E9", "#D55E00"

Style = Mapping[str, Any]

ZONES: Mapping[str, Style] = {
    "blue_o": {"marker": "o", "color": BLUE},
    "red_o": {"marker": "o", "markerfacecolor": "none", "markeredgecolor": RED},
    "black_o": {"marker": "o", "color": "#000000"},
    "stable_large": {"marker": "s", "markerfacecolor": "none", "markeredgecolor": BLUE},
}
"""Markers of figs. 4, 6: the paper's colours, told apart by filling as well."""
ZONE_WORDS = {
    "blue_o": "stable, |u_1| < 0.5",
    "red_o": "unstable, |u_1| < 0.5",
    "black_o": "unstable, |u_1| >= 0.5",
    "stable_large": "stable, |u_1| >= 0.5 (not in the paper)",
}

MOTIONS: Mapping[str, Style] = {
    "blue_o": {"marker": "o", "color": BLUE},
    "blue_plus": {"marker": "+", "color": BLUE},
    "cyan_o": {"marker": "o", "markerfacecolor": "none", "markeredgecolor": CYAN},
    "cyan_plus": {"marker": "+", "color": CYAN},
    "red_x": {"marker": "x", "color": RED},
}
"""Markers of figs. 5, 7."""
MOTION_WORDS = {
    "blue_o": "hula-hoop motion",
    "blue_plus": "hula-hoop motion, reversals",
    "cyan_o": "f_u is not 2 omega",
    "cyan_plus": "f_u is not 2 omega, reversals",
    "red_x": "does not turn with the force",
}

FILLED_IN = 0.3
"""Opacity of what an engine's map took from the nearest point that was computed."""


@dataclass(frozen=True)
class Panel:
    """A map as it is drawn.

    Attributes
    ----------
    title : str
    plane : Map
        Whose points they are.
    where : mapping of str to bool array (n_y, n_x)
        By class.
    """

    title: str
    plane: Map
    where: Mapping[str, Any]


def scatter(axes: Any, panel: Panel, styles: Mapping[str, Style]) -> None:
    """Draw each class with its marker."""
    plane = panel.plane
    size = min(75 / len(plane.x.values), 5)
    for name, where in panel.where.items():
        how = {"markersize": size, "markeredgewidth": 0.7, "linestyle": "none"} | dict(styles[name])
        for computed, opacity in ((1, 1.0), (0, FILLED_IN)):
            row, column = np.nonzero(where & (plane.computed == computed))
            axes.plot(plane.x.values[column], plane.y.values[row], alpha=opacity, **how)


def draw_panels(
    panels: Sequence[Panel], styles: Mapping[str, Style], columns: int
) -> tuple[Any, Any]:
    """Return a figure with a panel for each map, and its axes; some may be left over."""
    rows = -(-len(panels) // columns)
    figure, axes = new_figure(rows, columns, height=2.5, sharex=True, sharey=True)
    for i, (axis, panel) in enumerate(zip(axes.flat, panels, strict=False)):
        last, first = i + columns >= len(panels), i % columns == 0
        label(axis, "frequency [Hz]" if last else "", "force [N]" if first else "", panel.title)
        axis.tick_params(labelbottom=last)
        scatter(axis, panel, styles)
    for axis in axes.flat[len(panels) :]:
        axis.set_visible(False)
    return figure, axes


def legend(
    figure: Any, styles: Mapping[str, Style], words: Mapping[str, str], more: Sequence[Any] = ()
) -> None:
    """Put the meaning of the markers below."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], linestyle="none", markersize=5, label=words[name], **dict(style))
        for name, style in styles.items()
    ]
    outside_legend(figure, [*handles, *more], columns=3)


def by_size(stable: Any, unstable: Any, large: Any) -> dict[str, Any]:
    """Return the classes of figs. 4, 6 from stability and the size of u_1, all (n_y, n_x)."""
    return {
        "blue_o": stable & ~large,
        "red_o": unstable & ~large,
        "black_o": unstable & large,
        "stable_large": stable & large,
    }


def zones(title: str, plane: Map) -> Panel:
    """Return a map of stability as it is drawn."""
    calm, unstable = (is_class(plane, "stability", name) for name in ("stable", "unstable"))
    with np.errstate(invalid="ignore"):
        large = plane.variables["u_1"] >= 0.5
    return Panel(title, plane, by_size(calm, unstable, large))


def stability_figure(session: Session, plate: bool) -> Any:
    """Draw fig. 4, or 6 (plate)."""
    paper = stability_map(session, plate, model="paper")
    as_printed = stable(session, plate, "printed")
    where = by_size(as_printed, ~as_printed, paper.variables["u_1"] >= 0.5)
    panels = [
        Panel("(a) as printed", paper, where),
        zones("(b) (55) corrected", paper),
        zones("(c) and with its phase", stability_map(session, plate, model="corrected")),
        zones("(d) true rotation", stability_map(session, plate)),
    ]
    for letter, engine in zip("ef", session.engines, strict=False):
        words = f"{engine}, {alike(session, plate, engine):.1%} as (d)"
        panels.append(zones(f"({letter}) {words}", stability_map(session, plate, engine)))
    figure, _ = draw_panels(panels, ZONES, 3)
    legend(figure, ZONES, ZONE_WORDS)
    return figure


def motions(title: str, plane: Map) -> Panel:
    """Return a map of the motion from rest as it is drawn."""
    return Panel(title, plane, {name: is_class(plane, "motion", name) for name in MOTIONS})


def motion_figure(session: Session, plate: bool) -> Any:
    """Draw fig. 5, or 7 (plate)."""
    exact = motion_map(session, plate)
    panels = [motions("(a) reference", exact)]
    for letter, engine in zip("bc", session.engines, strict=False):
        own = motion_map(session, plate, engine)
        match = compare(exact, own).agreement(robust=True)
        panels.append(motions(f"({letter}) {engine}, {match:.1%} of robust points as (a)", own))
    panels.append(Panel(f"({'abcd'[len(panels)]}) not robust, or different", exact, {}))
    figure, axes = draw_panels(panels, MOTIONS, 2)
    legend(figure, MOTIONS, MOTION_WORDS, draw_apart(axes.flat[len(panels) - 1], session, plate))
    return figure


def draw_apart(axes: Any, session: Session, plate: bool) -> list[Any]:
    """Draw what is not robust, and where engines differ from the reference; return handles."""
    exact = motion_map(session, plate)
    row, column = np.nonzero(exact.variables["robust"] != 1)
    handles = axes.plot(
        exact.x.values[column],
        exact.y.values[row],
        label="not robust",
        color=FAINT,
        marker=".",
        linestyle="none",
    )
    for size, engine in zip((5.5, 3.0), session.engines, strict=False):
        match = compare(exact, motion_map(session, plate, engine))
        row, column = np.nonzero(match.differs)
        handles += axes.plot(
            match.x[column],
            match.y[row],
            label=f"{engine} differs",
            color=look(engine).colour,
            marker=look(engine).marker,
            markersize=size,
            markerfacecolor="none",
            markeredgewidth=0.8,
            linestyle="none",
        )
    return handles


OUR_AXES = "The text gives no axes: 1 to 10 Hz and 5 to 150 N are our choice."
REFINED = (
    "Engines take every third point, of these a coarse lattice and what lies at boundaries; "
    "pale markers are filled in from there (with --full all points are computed)."
)
STABILITY_CAPTION = (
    "Stability by Floquet multipliers of (a) the printed solution (49)-(52) and (55) as printed, "
    "(b) the same with (55) corrected, (c) the first-order solution with its phase theta_0, (d) "
    "the true rotation, found by shooting, and that of the engines. White: no rotation was found. "
    "Rotations coexist; on a coarse grid the search of an engine may end at an unstable one though "
    f"a stable one exists. {OUR_AXES} {REFINED}"
)
MOTION_CAPTION = (
    "Motion from rest after the transient, by the table of the paper: a window of 120 periods, no "
    "slip by half a turn, the largest peak of the spectrum of theta' for f_u. Last panel: points "
    "at which a start off by 1e-6 rad with twice the step ends in another class, and points where "
    f"engines differ from the reference. {OUR_AXES} {REFINED}"
)

FIGURES: tuple[PaperFigure, ...] = (
    PaperFigure(
        2,
        "Rotation at 3 Hz and 60 N by the approximate solution",
        "The printed solution (49)-(52), the one with the phase theta_0 that the paper drops, and "
        "the true rotation by the reference and the engines, each from its own periodic state; "
        "beside them the differences from the reference. Damping by table 1 is read as rho and "
        "zeta_m. Three periods are shown; the text gives no time axis.",
        figure_2,
    ),
    PaperFigure(
        3,
        "Motion from rest at 3 Hz and 60 N",
        "From rest with the rod across, by direct integration with the reference and the engines; "
        "beside it the differences from the reference. Damping by table 1 is read as rho and "
        "zeta_m. The first 3 s are shown; the text gives no time axis.",
        figure_3,
    ),
    PaperFigure(
        4,
        "Stability of the approximate solutions",
        f"Point mass. {STABILITY_CAPTION}",
        partial(stability_figure, plate=False),
    ),
    PaperFigure(
        5,
        "Hula-hoop motion from rest by direct integration",
        f"Point mass. {MOTION_CAPTION}",
        partial(motion_figure, plate=False),
    ),
    PaperFigure(
        6,
        "Stability of the approximate solutions, with inertia",
        f"Semicircular plate. {STABILITY_CAPTION}",
        partial(stability_figure, plate=True),
    ),
    PaperFigure(
        7,
        "Hula-hoop motion from rest by direct integration, with inertia",
        f"Semicircular plate. {MOTION_CAPTION}",
        partial(motion_figure, plate=True),
    ),
)
