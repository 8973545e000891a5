"""Figures 2-7 of the hula_hoop paper, drawn again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
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
from ..session import Session
from .measures import (
    apart,
    approximate_states,
    example_from_rest,
    example_rotation,
    is_class,
    motion_map,
    on_grid,
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

APPROXIMATE_LINES: Mapping[str, Mapping[str, Any]] = {
    "paper": {"color": INK, "linestyle": (0, (5, 2)), "label": "paper, as printed"},
    "corrected": {"color": "#E69F00", "label": "with its phase (corrected)"},
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
    """Draw a motion by all and its approximations, and their distances from the reference.

    Parameters
    ----------
    times : array (n_t,) [s]
        Times of the first samples of the motion.
    motion_by : callable ``(session, who) -> Simulation``
    titles : sequence of str
        Titles of the rows.
    against : str
        Name of the reference's motion.
    approximate : mapping of str to array (4, n_t)
        States of approximate solutions, by names in `APPROXIMATE_LINES`.

    Returns
    -------
    figure, axes : matplotlib Figure, and Axes (3, 2)
    """
    everyone = (REFERENCE, *session.engines)
    truth, *engines = (states(motion_by(session, who))[:, : len(times)] for who in everyone)
    figure, axes = new_figure(3, 2, height=1.9, sharex=True)
    for (left, right), title, (place, factor, unit) in zip(axes, titles, OBSERVABLES, strict=True):
        for name, values in approximate.items():
            line = {**APPROXIMATE_LINES[name], "linewidth": 1.0}
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


def hollow(marker: str, colour: str, label: str) -> Style:
    """Return the style of a hollow marker."""
    face = {"markerfacecolor": "none", "markeredgecolor": colour}
    return {"marker": marker, **face, "label": label}


ZONES: Mapping[str, Style] = {
    "blue_o": {"marker": "o", "color": BLUE, "label": "stable, |u_1| < 0.5"},
    "red_o": hollow("o", RED, "unstable, |u_1| < 0.5"),
    "black_o": {"marker": "o", "color": "#000000", "label": "unstable, |u_1| >= 0.5"},
    "stable_large": hollow("s", BLUE, "stable, |u_1| >= 0.5: reverses (not in the paper)"),
}
"""Markers of figs. 4, 6: the paper's colours, distinguished by filling as well."""

MOTIONS: Mapping[str, Style] = {
    "blue_o": {"marker": "o", "color": BLUE, "label": "hula-hoop motion"},
    "blue_plus": {"marker": "+", "color": BLUE, "label": "rotation with reversals"},
    "cyan_o": hollow("o", CYAN, "rotation, f_u is not 2 omega"),
    "cyan_plus": {"marker": "+", "color": CYAN, "label": "the same with reversals"},
    "red_x": {"marker": "x", "color": RED, "label": "does not turn with the force"},
}
"""Markers of figs. 5, 7."""

FILLED_IN = 0.45
"""Relative size of a marker that an engine's map took from a computed point."""


@dataclass(frozen=True)
class Panel:
    """A map as it is drawn.

    Attributes
    ----------
    title : str
    plane : Map
        The map whose points they are.
    where : mapping of str to bool array (n_y, n_x)
        Points of each class.
    regions : mapping of str to bool array (n_y, n_x)
        Regions that the paper names, by number.
    """

    title: str
    plane: Map
    where: Mapping[str, Any]
    regions: Mapping[str, Any] = field(default_factory=dict)


def scatter(axes: Any, panel: Panel, styles: Mapping[str, Style]) -> None:
    """Draw each class with its marker, and the numbers of regions where these are widest."""
    x, y, size = panel.plane.x.values, panel.plane.y.values, min(75 / panel.plane.x.count, 5)
    for name, where in panel.where.items():
        for computed, share in ((1, 1.0), (0, FILLED_IN)):
            row, column = np.nonzero(where & (panel.plane.computed == computed))
            how = {"markersize": share * size, "markeredgewidth": 0.7, "linestyle": "none"}
            axes.plot(x[column], y[row], **how, **styles[name])
    for number, where in panel.regions.items():
        depth = distance_transform_edt(np.pad(where, 1))[1:-1, 1:-1]
        i, j = np.unravel_index(np.argmax(depth), depth.shape)
        box = {"boxstyle": "round", "facecolor": "white", "edgecolor": INK, "linewidth": 0.6}
        middle = {"ha": "center", "va": "center", "fontsize": 9, "bbox": box}
        axes.annotate(number, (x[j], y[i]), **middle)


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

    The text gives no place of the small regions III, IV and V.
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
    ]
    for letter, engine in zip("ef", session.engines, strict=False):
        own = stability_map(session, plate, engine)
        true = on_grid(session, own, stable(session, plate, "exact"))
        alike = np.mean((is_class(own, "stability", "stable") == true)[own.computed == 1])
        panels.append(zones(f"({letter}) {engine} agrees at {alike:.1%}", own))
    figure, _ = draw_panels(panels, ZONES, 3)
    legend(figure, ZONES)
    return figure


def motions(title: str, plane: Map) -> Panel:
    """Return a map of the motion from rest as it is drawn."""
    where = {name: is_class(plane, "motion", name) for name in MOTIONS}
    is_reference = plane.settings["engine"] == REFERENCE
    named = numbered(where["red_x"], where["blue_o"]) if is_reference else {}
    return Panel(title, plane, where, named)


def motion_figure(session: Session, plate: bool) -> Any:
    """Draw fig. 5, or 7 (plate); in the last panel, points that are not robust or that differ."""
    exact = motion_map(session, plate)
    panels = [motions("(a) Motion from rest by the reference", exact)]
    matches = {
        name: compare(exact, motion_map(session, plate, name)) for name in session.engines[:2]
    }
    for letter, (engine, match) in zip("bc", matches.items(), strict=False):
        title = (
            f"({letter}) {engine} agrees at {match.robust_agreement or 0.0:.1%} of robust points"
        )
        panels.append(motions(title, motion_map(session, plate, engine)))
    title = f"({'abcd'[len(panels)]}) Points that are not robust, or differ"
    figure, axes = draw_panels([*panels, Panel(title, exact, {})], MOTIONS, 2)
    last = axes.flat[len(panels)]
    row, column = np.nonzero(~exact.robust)
    dots = {"label": "not robust", "color": FAINT, "marker": ".", "linestyle": "none"}
    handles = last.plot(exact.x.values[column], exact.y.values[row], **dots)
    for size, (engine, match) in zip((5.5, 3.0), matches.items(), strict=False):
        row, column = np.nonzero(match.differs)
        its = hollow(look(engine).marker, look(engine).colour, f"{engine} differs")
        how = {"color": look(engine).colour, "markersize": size, "markeredgewidth": 0.8}
        handles += last.plot(match.x[column], match.y[row], linestyle="none", **its, **how)
    legend(figure, MOTIONS, handles)
    return figure
