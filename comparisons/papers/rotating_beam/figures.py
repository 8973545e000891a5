"""Figures 2 to 5 of the paper on `rotating_beam`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import maximum_filter1d

from ....reference.rotating_beam.frequencies.assumed_modes import best_mass_position
from ....reference.rotating_beam.parameters import drive_end_time
from ...engines.registry import REFERENCE
from ...maps.store import Map
from ...reports.drawing import INK, NOTE, broad, engine_line, label, new_figure
from ..drawing import handles_of, outside_legend
from ..session import Session
from .measures import (
    FIRST_VARIABLE,
    MASSES,
    PRINTED_MAXIMA,
    SAMPLES,
    THRESHOLD,
    Response,
    by_place,
    by_ratio,
    by_speed,
    loaded,
    response,
    runs,
)

MASS_COLOURS = dict(zip(MASSES, ("#DCDCDC", "#B4B4B4", "#868686", "#4A4A4A"), strict=True))
"""The heavier, the darker."""


def mass_label(mass: float) -> str:
    """Return the label of a curve of the reference."""
    return f"reference, {mass:g} kg" if mass else "reference, no mass"


def decades(axes: Any) -> None:
    """Scale an axis of differences by whole powers of ten."""
    axes.set_yscale("log")
    low, high = np.log10(axes.get_ylim())
    axes.set_ylim(10.0 ** np.floor(low), 10.0 ** np.ceil(high))


# Frequencies --------------------------------------------------------------------------------


def curves(
    axes: Any, plane: Map, engines: Mapping[str, Map], names: Callable[[float], str] = mass_label
) -> None:
    """Draw rows of maps over their x axis, the reference's broad, and the engines' over them."""
    for row, colour in enumerate(MASS_COLOURS.values()):
        curve, words = plane.variables[FIRST_VARIABLE][row], names(float(plane.y.values[row]))
        broad(axes, plane.x.values, curve, colour, label=words)
    for engine, own in engines.items():
        for curve in own.variables[FIRST_VARIABLE]:
            engine_line(axes, engine, own.x.values, curve)


def differences(axes: Any, truth: Map, engines: Mapping[str, Map], axis: str, letters: str) -> None:
    """Draw the relative errors of engines, the largest of all rows.

    Letters are those of this panel and of the one that shows the frequencies.
    """
    right = CubicSpline(truth.x.values, truth.variables[FIRST_VARIABLE], axis=1)
    for engine, own in engines.items():
        off = np.abs(own.variables[FIRST_VARIABLE] / right(own.x.values) - 1)
        engine_line(axes, engine, own.x.values, np.max(off, axis=0))
    decades(axes)
    title = f"({letters[0]}) How far engines are off in ({letters[1]}), largest"
    label(axes, axis, "|engine / reference - 1|", title)


def draw_figure_2(session: Session) -> Any:
    """First frequency against speed and against mass ratio, mass at the tip."""
    figure, panels = new_figure(2, 2, 2.4)
    columns: tuple[tuple[Callable[..., Map], str, Callable[[float], str], str, str], ...] = (
        (by_speed, "dimensionless speed $\\gamma$", mass_label, LOWER[0], "ca"),
        (by_ratio, "mass ratio $\\alpha$", lambda gamma: f"$\\gamma$ = {gamma:g}", LOWER[1], "db"),
    )
    for (top, bottom), (read, axis, names, title, letters) in zip(panels.T, columns, strict=True):
        truth, engines = read(session), {name: read(session, name) for name in session.engines}
        curves(top, truth, engines, names)
        label(top, axis, "first frequency, dimensionless", title)
        differences(bottom, truth, engines, axis, letters)
    for gamma, curve in zip(truth.y.values, truth.variables[FIRST_VARIABLE], strict=True):  # of (b)
        at = truth.x.values[-1], curve[-1] + 0.45
        top.annotate(names(float(gamma)), at, ha="right", **NOTE)
    outside_legend(figure, handles_of(panels[0, 0]), columns=4, place="upper")
    return figure


LOWER = "(a) A mass at the tip lowers the frequency", "(b) More mass: less and less"


def draw_figure_3(session: Session) -> Any:
    """First frequency against the mass's place, converged and with two assumed modes."""
    figure, panels = new_figure(2, 2, 2.5)
    truth, two = by_place(session), by_place(session, model="paper")
    engines = {name: by_place(session, name) for name in session.engines}
    (left, right), (below, beside) = panels
    place = "place of the mass $\\beta$"
    curves(left, truth, engines)
    curves(right, two, {})
    differences(below, truth, engines, place, "ca")
    off = 100 * (two.variables[FIRST_VARIABLE] / truth.variables[FIRST_VARIABLE] - 1)
    for gap, colour in zip(off, MASS_COLOURS.values(), strict=True):
        broad(beside, two.x.values, gap, colour)
    line = {"color": INK, "linewidth": 0.7}
    for axes, plane, modes in ((left, truth, None), (right, two, 2)):
        for row, (mass, printed) in enumerate(PRINTED_MAXIMA.items(), start=1):
            best = best_mass_position(loaded(mass), modes)
            top = CubicSpline(plane.x.values, plane.variables[FIRST_VARIABLE][row])(best)
            axes.plot(best, top, "v", color=INK, markersize=4, label="maximum")
            axes.axvline(printed, linestyle=":", label="printed maxima", **line)
        axes.axvline(THRESHOLD, linestyle="--", label="printed crossing, 0.67", **line)
    limits = *left.get_ylim(), *right.get_ylim()
    for axes in (left, right):
        axes.set_ylim(min(limits), max(limits))
    label(left, place, "first frequency, dimensionless", "(a) Converged, at 7 rad/s")
    label(right, place, title="(b) With two assumed modes, at 7 rad/s")
    label(beside, place, "two modes over converged [%]", "(d) How far (b) lies above (a)")
    beside.set_ylim(bottom=0.0)
    outside_legend(figure, handles_of(left), columns=4, place="upper")
    return figure


# Responses ----------------------------------------------------------------------------------


def draw_responses(
    axes: Any, session: Session, figure: int, variable: str, seconds: float = 0.0
) -> None:
    """Draw an observable of the motions of all masses over time.

    With ``seconds`` so long after the drive, about its mean then, a thousand times as large.
    """
    for who in (REFERENCE, *session.engines):
        for mass, motion in motions(session, figure, who).items():
            times, values = motion.times, motion.values[variable]
            if seconds:
                truth = response(session, figure, REFERENCE, mass).values[variable]
                free = times >= drive_end_time(motion.beam)
                shown = free & (times <= drive_end_time(motion.beam) + seconds)
                times, values = times[shown], 1e3 * (values[shown] - np.mean(truth[free]))
            if who == REFERENCE:
                broad(axes, times, values, MASS_COLOURS[mass], label=mass_label(mass))
            else:
                engine_line(axes, who, times, values, marker="")


def motions(session: Session, figure: int, who: str) -> Mapping[float, Response]:
    """Return the motions of a figure by the reference or an engine, by mass, where it has any."""
    found = runs(session, figure, who)
    return {mass: motion for mass, motion in found.items() if isinstance(motion, Response)}


def draw_errors(axes: Any, session: Session, figure: int, variable: str) -> None:
    """Draw the errors of engines: the largest of all masses, within 1 s."""
    truths = motions(session, figure, REFERENCE)
    for who in session.engines:
        off = [
            np.abs(motion.values[variable] - truths[mass].values[variable])
            for mass, motion in motions(session, figure, who).items()
        ]
        if off:
            largest = maximum_filter1d(np.max(off, axis=0), SAMPLES)
            engine_line(axes, who, truths[0.0].times[1:], largest[1:], marker="")
    decades(axes)


def draw_figure_4(session: Session) -> Any:
    """Spin-up: deformation and velocity of the tip."""
    figure, panels = new_figure(4, 1, 1.7)
    for (top, bottom), letter, variable, name, unit in (
        (panels[:2, 0], "a", "tip_deflection", "deformation", "m"),
        (panels[2:, 0], "b", "tip_deflection_dot", "velocity", "m/s"),
    ):
        draw_responses(top, session, 4, variable)
        draw_errors(bottom, session, 4, variable)
        label(top, "", f"{name} [{unit}]", f"({letter}) {name.capitalize()} of the free end")
        title = f"({letter}) How far engines are off, largest of all masses within 1 s"
        label(bottom, "time [s]", f"difference [{unit}]", title)
    outside_legend(figure, handles_of(panels[0, 0]), columns=4, place="upper")
    return figure


def draw_figure_5(session: Session) -> Any:
    """Pulse: angle and deformation of the free end."""
    figure, panels = new_figure(3, 2, 2.1)
    for (whole, local, off), (one, two, three), variable, name, unit in (
        (panels[:, 0], "abe", "tip_angle", "angle of the free end", "rad"),
        (panels[:, 1], "cdf", "tip_deflection", "deformation", "m"),
    ):
        draw_responses(whole, session, 5, variable)
        draw_responses(local, session, 5, variable, seconds=5.0)
        draw_errors(off, session, 5, variable)
        label(whole, "", f"{name} [{unit}]", f"({one}) {name.capitalize()}")
        label(local, "time [s]", f"{name} [m{unit}]", f"({two}) After the pulse, about the mean")
        title = f"({three}) How far engines are off, largest within 1 s"
        label(off, "time [s]", f"difference [{unit}]", title)
    for line in panels[0, 1].lines:  # four deformations cross each other
        line.set_linewidth(line.get_linewidth() / 2)
    outside_legend(figure, handles_of(panels[0, 0]), columns=4, place="upper")
    return figure
