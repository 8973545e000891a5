"""Figures 2-7 of the hula_hoop paper, drawn again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from scipy.ndimage import distance_transform_edt

from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ...maps.compare import compare
from ...maps.store import Map
from ...queries.simulate import Simulation
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
    regions,
    samples,
    stability_map,
    stable,
    states,
)

OBSERVABLES = ((0, 1e3, "y [mm]"), (1, 1.0, "theta [rad]"), (3, 1.0, "theta' [rad/s]"))
"""Place in the state, factor and unit of each row of figs. 2, 3."""
ROTATION_TITLES = (
    "(a) The main mass swings with the force",
    "(b) The free mass turns once in a period",
    "(c) It turns unevenly, twice in a period",
)
FROM_REST_TITLES = (
    "(a) The main mass swings up at once",
    "(b) The free mass turns back, then forward",
    "(c) Its speed settles slowly",
)

APPROXIMATE_LINES = {
    "paper": {
        "color": INK,
        "linewidth": 1.0,
        "linestyle": (0, (5, 2)),
        "label": "paper, as printed",
    },
    "corrected": {"color": "#E69F00", "linewidth": 1.0, "label": "with its phase (corrected)"},
}
FIG_3_SECONDS = 3.0


def figure_2(session: Session) -> Any:
    """Draw the approximate solutions at 3 Hz, 60 N, over the true rotation."""
    approximate = {name: approximate_states(name) for name in APPROXIMATE_LINES}
    return draw_motion(
        session,
        samples(1.0),
        example_rotation,
        ROTATION_TITLES,
        "rotation of the reference",
        approximate,
    )[0]


def figure_3(session: Session) -> Any:
    """Draw the motion from rest at 3 Hz, 60 N."""
    figure, axes = draw_motion(
        session, samples(FIG_3_SECONDS), example_from_rest, FROM_REST_TITLES, "reference", {}
    )
    for panel in axes[:, 0]:
        panel.axvline(1.5, color=INK, linewidth=0.6, linestyle=(0, (1, 2)))
    axes[2, 0].annotate("1.5 s: end of the\ntransient in the paper", (1.55, -85), **NOTE)
    return figure


def draw_motion(
    session: Session,
    times: Array,
    motion_by: Callable[[Session, str], Simulation],
    titles: Sequence[str],
    against: str,
    approximate: Mapping[str, Array],
) -> tuple[Any, Any]:
    """Draw a motion by all and its approximations, and beside it how far they are apart.

    Parameters
    ----------
    times : array (n_t,) [s]
        Of the first samples of the motion.
    motion_by : callable ``(session, who) -> Simulation``
    titles : sequence of str
        Of the rows.
    against : str
        What the reference's motion is called.
    approximate : mapping of str to array (4, n_t)
        States of approximate solutions, by names in `APPROXIMATE_LINES`.

    Returns
    -------
    figure, axes : matplotlib Figure, and Axes (3, 2)
    """
    truth, *engines = (states(motion_by(session, who))[:, : len(times)] for who in session.everyone)
    figure, axes = new_figure(3, 2, height=1.9, sharex=True)
    for (left, right), title, (place, factor, unit) in zip(axes, titles, OBSERVABLES, strict=True):
        for name, values in approximate.items():
            line = APPROXIMATE_LINES[name]
            left.plot(times, factor * values[place], zorder=3, **line)
            right.plot(times, factor * apart(values, truth)[place], **line)
        broad(left, times, factor * truth[place], label=REFERENCE, zorder=1)
        for name, own in zip(session.engines, engines, strict=True):
            engine_line(left, name, times, factor * own[place])
            draw_gap(right, name, times, factor * apart(own, truth)[place])
        label(left, "", unit, title)
        label(right, "", f"|difference|, {unit}")
        right.set_yscale("log")
    axes[0, 1].set_title(f"Distance from the {against}", loc="left", fontsize=9)
    for panel in axes[-1]:
        panel.set_xlabel("time [s]", fontsize=8)
    outside_legend(figure, handles_of(axes[0, 0]))
    return figure, axes


# Figs. 4-7: markers on a grid

BLUE, CYAN, RED = "#0072B2", "#56B4E9", "#D55E00"

Style = Mapping[str, Any]

ZONES: Mapping[str, Style] = {
    "blue_o": {"marker": "o", "color": BLUE, "label": "stable, |u_1| < 0.5"},
    "red_o": {
        "marker": "o",
        "markerfacecolor": "none",
        "markeredgecolor": RED,
        "label": "unstable, |u_1| < 0.5",
    },
    "black_o": {"marker": "o", "color": "#000000", "label": "unstable, |u_1| >= 0.5"},
    "stable_large": {
        "marker": "s",
        "markerfacecolor": "none",
        "markeredgecolor": BLUE,
        "label": "stable, |u_1| >= 0.5: reverses (not in the paper)",
    },
}
"""Markers of figs. 4, 6: the paper's colours, told apart by filling as well."""

MOTIONS: Mapping[str, Style] = {
    "blue_o": {"marker": "o", "color": BLUE, "label": "hula-hoop motion"},
    "blue_plus": {"marker": "+", "color": BLUE, "label": "rotation with reversals"},
    "cyan_o": {
        "marker": "o",
        "markerfacecolor": "none",
        "markeredgecolor": CYAN,
        "label": "rotation, f_u is not 2 omega",
    },
    "cyan_plus": {"marker": "+", "color": CYAN, "label": "the same with reversals"},
    "red_x": {"marker": "x", "color": RED, "label": "does not turn with the force"},
}
"""Markers of figs. 5, 7."""

FILLED_IN = 0.45
"""Size, by that of others, of a marker that an engine's map took from a computed point."""


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
    regions : mapping of str to bool array (n_y, n_x)
        Those that the paper names, by number.
    """

    title: str
    plane: Map
    where: Mapping[str, Any]
    regions: Mapping[str, Any] = field(default_factory=dict)


def scatter(axes: Any, panel: Panel, styles: Mapping[str, Style]) -> None:
    """Draw each class with its marker, and the numbers of regions where these are widest."""
    plane = panel.plane
    size = min(75 / len(plane.x.values), 5)
    for name, where in panel.where.items():
        for computed, share in ((1, 1.0), (0, FILLED_IN)):
            row, column = np.nonzero(where & (plane.computed == computed))
            axes.plot(
                plane.x.values[column],
                plane.y.values[row],
                markersize=share * size,
                markeredgewidth=0.7,
                linestyle="none",
                **styles[name],
            )
    for number, where in panel.regions.items():
        depth = distance_transform_edt(np.pad(where, 1))[1:-1, 1:-1]
        deepest = np.unravel_index(np.argmax(depth), depth.shape)
        box = {"boxstyle": "round", "facecolor": "white", "edgecolor": INK, "linewidth": 0.6}
        place = (plane.x.values[deepest[1]], plane.y.values[deepest[0]])
        axes.annotate(number, place, ha="center", va="center", fontsize=9, bbox=box)


def draw_panels(
    panels: Sequence[Panel], styles: Mapping[str, Style], columns: int
) -> tuple[Any, Any]:
    """Return a figure with a panel for each map, and its axes; some may be left over."""
    figure, axes = new_figure(
        -(-len(panels) // columns), columns, height=2.5, sharex=True, sharey=True
    )
    for i, (axis, panel) in enumerate(zip(axes.flat, panels, strict=False)):
        last, first = i + columns >= len(panels), i % columns == 0
        label(axis, "frequency [Hz]" if last else "", "force [N]" if first else "", panel.title)
        axis.tick_params(labelbottom=last)
        scatter(axis, panel, styles)
    for axis in axes.flat[len(panels) :]:
        axis.set_visible(False)
    return figure, axes


def legend(figure: Any, styles: Mapping[str, Style], more: Sequence[Any] = ()) -> None:
    """Put the meaning of the markers below."""
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], linestyle="none", markersize=5, **style) for style in styles.values()]
    outside_legend(figure, [*handles, *more], columns=3)


def by_size(stable: Any, unstable: Any, large: Any) -> dict[str, Any]:
    """Return the classes of figs. 4, 6 from stability and the size of u_1, all (n_y, n_x)."""
    return {
        "blue_o": stable & ~large,
        "red_o": unstable & ~large,
        "black_o": unstable & large,
        "stable_large": stable & large,
    }


def numbered(without: Any, hoop: Any) -> dict[str, Any]:
    """Return region I, without hula-hoop motion, and II, with it: the largest (n_y, n_x) of each.

    The text tells no place of the small regions III, IV and V.
    """
    parts = {"I": regions(without), "II": regions(hoop)}
    return {number: several[0] for number, several in parts.items() if several}


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
        Panel("(a) Solution as printed", paper, where, numbered(~as_printed, as_printed)),
        zones("(b) With (55) corrected", paper),
        zones("(c) With its phase, too", stability_map(session, plate, model="corrected")),
        zones("(d) The true rotation", stability_map(session, plate)),
        *(
            zones(
                f"({letter}) {engine} agrees at {alike(session, plate, engine):.1%}",
                stability_map(session, plate, engine),
            )
            for letter, engine in zip("ef", session.engines, strict=False)
        ),
    ]
    figure, _ = draw_panels(panels, ZONES, 3)
    legend(figure, ZONES)
    return figure


def motions(title: str, plane: Map) -> Panel:
    """Return a map of the motion from rest as it is drawn."""
    where = {name: is_class(plane, "motion", name) for name in MOTIONS}
    named = (
        numbered(where["red_x"], where["blue_o"]) if plane.settings["engine"] == REFERENCE else {}
    )
    return Panel(title, plane, where, named)


def motion_figure(session: Session, plate: bool) -> Any:
    """Draw fig. 5, or 7 (plate)."""
    exact = motion_map(session, plate)
    panels = [motions("(a) Motion from rest by the reference", exact)]
    for letter, engine in zip("bc", session.engines, strict=False):
        own = motion_map(session, plate, engine)
        match = compare(exact, own).robust_agreement or 0.0
        panels.append(motions(f"({letter}) {engine} agrees at {match:.1%} of robust points", own))
    panels.append(
        Panel(f"({'abcd'[len(panels)]}) Points that are not robust, or differ", exact, {})
    )
    figure, axes = draw_panels(panels, MOTIONS, 2)
    legend(figure, MOTIONS, draw_apart(axes.flat[len(panels) - 1], session, plate))
    return figure


def draw_apart(axes: Any, session: Session, plate: bool) -> list[Any]:
    """Draw what is not robust, and where engines differ from the reference; return handles."""
    exact = motion_map(session, plate)
    row, column = np.nonzero(~exact.robust)
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


OUR_AXES = (
    "The text gives no axes: 1 to 10 Hz and 5 to 150 N are our choice. I and II: the largest "
    "regions without and with hula-hoop motion, which have these numbers in the text; it tells no "
    "place of III, IV and V."
)
REFINED = (
    "Engines take every third point, of these a coarse lattice and what lies at boundaries; "
    "small markers are filled in from there (with --full all points are computed)."
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
    "at which, by the reference, a start off by 1e-6 rad with twice the step ends in another "
    "class, and points where engines differ from it. Robust points are those without that in "
    f"the map of the engine, too. {OUR_AXES} {REFINED}"
)

FIGURES: tuple[PaperFigure, ...] = (
    PaperFigure(
        2,
        "The printed solution moves the main mass rightly, and turns the free mass out of phase",
        "At 3 Hz and 60 N the printed solution (49)-(52), the one with the phase theta_0 that the "
        "paper drops, and the true rotation by the reference and the engines, each from its own "
        "periodic state; beside them the differences from the reference. Damping by table 1 is "
        "read as rho and zeta_m. Three periods are shown; the text gives no time axis.",
        figure_2,
    ),
    PaperFigure(
        3,
        "From rest the free mass falls into step with the force",
        "At 3 Hz and 60 N, from rest with the rod across, by direct integration with the "
        "reference and the engines; beside it the differences from the reference. Damping by "
        "table 1 is read as rho and zeta_m. The first 3 s are shown; the text gives no time axis.",
        figure_3,
    ),
    PaperFigure(
        4,
        "Where the rotation of a point mass is stable, by the approximate solutions and in truth",
        f"Point mass. {STABILITY_CAPTION}",
        partial(stability_figure, plate=False),
    ),
    PaperFigure(
        5,
        "Where a point mass comes from rest into hula-hoop motion",
        f"Point mass. {MOTION_CAPTION}",
        partial(motion_figure, plate=False),
    ),
    PaperFigure(
        6,
        "Where the rotation of a plate is stable, by the approximate solutions and in truth",
        f"Semicircular plate. {STABILITY_CAPTION}",
        partial(stability_figure, plate=True),
    ),
    PaperFigure(
        7,
        "Where a plate comes from rest into hula-hoop motion",
        f"Semicircular plate. {MOTION_CAPTION}",
        partial(motion_figure, plate=True),
    ),
)
