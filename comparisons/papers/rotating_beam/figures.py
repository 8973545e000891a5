"""Figures 2 to 5 of the paper on `rotating_beam`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import maximum_filter1d

from ....reference.rotating_beam.frequencies.assumed_modes import best_mass_position
from ....reference.rotating_beam.parameters import drive_end_time
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ...maps.store import Map
from ...reports.drawing import INK, NOTE, broad, engine_line, label, new_figure
from ..drawing import handles_of, outside_legend
from ..session import Session
from .measures import (
    CASES,
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

BY_MASS = list(MASS_COLOURS.values())


def mass_label(mass: float) -> str:
    """Return the label of a curve of the reference."""
    return f"reference, {mass:g} kg" if mass else "reference, no mass"


def legend(figure: Any, *panels: Any) -> None:
    """Explain the lines of panels above all of them, each once."""
    handles = handles_of(*panels)
    handles.sort(key=lambda handle: not handle.get_label().startswith("reference"))
    outside_legend(figure, handles, columns=4, place="upper")


def decades(axes: Any) -> None:
    """Scale an axis of differences by whole powers of ten."""
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    axes.set_ylim(10.0 ** np.floor(np.log10(low)), 10.0 ** np.ceil(np.log10(high)))


# Frequencies --------------------------------------------------------------------------------


def curves(axes: Any, truth: Map, engines: Mapping[str, Map], names: Callable[..., str]) -> None:
    """Draw rows of maps over their x axis, the reference's broad, and the engines' over it."""
    for row, value in enumerate(truth.y.values):
        curve = truth.variables[FIRST_VARIABLE][row]
        broad(axes, truth.x.values, curve, BY_MASS[row], label=names(float(value)))
        for engine, own in engines.items():
            engine_line(axes, engine, own.x.values, own.variables[FIRST_VARIABLE][row])


def differences(axes: Any, truth: Map, engines: Mapping[str, Map]) -> None:
    """Draw the relative errors of engines, the largest of all rows."""
    right = CubicSpline(truth.x.values, truth.variables[FIRST_VARIABLE], axis=1)
    for engine, own in engines.items():
        off = np.abs(own.variables[FIRST_VARIABLE] / right(own.x.values) - 1)
        engine_line(axes, engine, own.x.values, np.max(off, axis=0))
    decades(axes)


LOWER = "A mass at the tip lowers the frequency", "More mass: less and less"


def draw_figure_2(session: Session) -> Any:
    """First frequency against speed and against mass ratio, mass at the tip."""
    figure, panels = new_figure(2, 2, 2.4)
    columns: tuple[tuple[Callable[..., Map], str, Callable[..., str]], ...] = (
        (by_speed, "dimensionless speed $\\gamma$", mass_label),
        (by_ratio, "mass ratio $\\alpha$", lambda gamma: f"$\\gamma$ = {gamma:g}"),
    )
    for column, (read, axis, names) in enumerate(columns):
        truth, engines = read(session), {name: read(session, name) for name in session.engines}
        top, bottom = panels[:, column]
        curves(top, truth, engines, names)
        differences(bottom, truth, engines)
        label(top, axis, "first frequency, dimensionless", f"({'ab'[column]}) {LOWER[column]}")
        title = f"({'cd'[column]}) How far engines are off in ({'ab'[column]}), largest"
        label(bottom, axis, "|engine / reference - 1|", title)
    for row, gamma in enumerate(truth.y.values):  # of (b)
        at = truth.x.values[-1], truth.variables[FIRST_VARIABLE][row, -1] + 0.45
        panels[0, 1].annotate(names(float(gamma)), at, ha="right", **NOTE)
    legend(figure, panels[0, 0])
    return figure


def draw_figure_3(session: Session) -> Any:
    """First frequency against the mass's place, converged and with two assumed modes."""
    figure, panels = new_figure(2, 2, 2.5)
    truth, two = by_place(session), by_place(session, model="paper")
    engines = {name: by_place(session, name) for name in session.engines}
    (left, right), (below, beside) = panels
    curves(left, truth, engines, mass_label)
    curves(right, two, {}, mass_label)
    differences(below, truth, engines)
    off = 100 * (two.variables[FIRST_VARIABLE] / truth.variables[FIRST_VARIABLE] - 1)
    for row in range(len(MASSES)):
        broad(beside, two.x.values, off[row], BY_MASS[row])
    for axes, plane, modes in ((left, truth, None), (right, two, 2)):
        for row, (mass, printed) in enumerate(PRINTED_MAXIMA.items(), start=1):
            best = best_mass_position(loaded(mass), modes)
            top = CubicSpline(plane.x.values, plane.variables[FIRST_VARIABLE][row])(best)
            axes.plot(best, top, "v", color=INK, markersize=4, label="maximum")
            axes.axvline(printed, color=INK, linewidth=0.7, linestyle=":", label="printed maxima")
        crossing = {"color": INK, "linewidth": 0.7, "linestyle": "--"}
        axes.axvline(THRESHOLD, label="printed crossing, 0.67", **crossing)
    limits = [limit for axes in (left, right) for limit in axes.get_ylim()]
    for axes in (left, right):
        axes.set_ylim(min(limits), max(limits))
    place = "place of the mass $\\beta$"
    label(left, place, "first frequency, dimensionless", "(a) Converged, at 7 rad/s")
    label(right, place, title="(b) With two assumed modes, at 7 rad/s")
    label(below, place, "|engine / reference - 1|", "(c) How far engines are off in (a), largest")
    label(beside, place, "two modes over converged [%]", "(d) How far (b) lies above (a)")
    beside.set_ylim(bottom=0.0)
    legend(figure, left)
    return figure


# Responses ----------------------------------------------------------------------------------


def draw_responses(
    axes: Any, session: Session, figure: int, curve: Callable[[Response, float], Any]
) -> None:
    """Draw a curve of the motions of all masses: times and values of a motion by mass."""
    for mass in MASSES:
        truth = response(session, figure, REFERENCE, mass)
        times, values = curve(truth, mass)
        broad(axes, times, values, MASS_COLOURS[mass], label=mass_label(mass))
    for name, mass, own in engine_runs(session, figure):
        engine_line(axes, name, *curve(own, mass), marker="")


def draw_time(axes: Any, session: Session, figure: int, variable: str) -> None:
    """Draw one observable over time."""
    draw_responses(axes, session, figure, lambda own, mass: (own.times, own.values[variable]))


def draw_local(axes: Any, session: Session, figure: int, variable: str, share: float) -> None:
    """Draw an observable about its mean once nothing drives it, a thousand times as large."""
    start = drive_end_time(CASES[figure])
    truths = {mass: response(session, figure, REFERENCE, mass) for mass in MASSES}
    means = {
        mass: np.mean(one.values[variable][one.times >= start]) for mass, one in truths.items()
    }

    def local(own: Response, mass: float) -> tuple[Array, Array]:
        seen = (own.times >= start) & (own.times <= start + share)
        return own.times[seen], 1e3 * (own.values[variable][seen] - means[mass])

    draw_responses(axes, session, figure, local)


def draw_off(axes: Any, session: Session, figure: int, variable: str) -> None:
    """Draw the errors of engines: the largest of all masses, within 1 s."""
    off: dict[str, list[Array]] = {}
    for name, mass, own in engine_runs(session, figure):
        truth = response(session, figure, REFERENCE, mass)
        off.setdefault(name, []).append(np.abs(own.values[variable] - truth.values[variable]))
    for name, each in off.items():
        largest = maximum_filter1d(np.max(each, axis=0), SAMPLES)
        engine_line(axes, name, truth.times[1:], largest[1:], marker="")
    decades(axes)


def engine_runs(session: Session, figure: int) -> list[tuple[str, float, Response]]:
    """Return the engines' motions of a figure, where there are any, with engine and mass."""
    return [
        (who, mass, motion)
        for who in session.engines
        for mass, motion in runs(session, figure, who).items()
        if isinstance(motion, Response)
    ]


def draw_figure_4(session: Session) -> Any:
    """Spin-up: deformation and velocity of the tip."""
    figure, panels = new_figure(4, 1, 1.7)
    for (top, bottom), letter, variable, name, unit in zip(
        panels.reshape(2, 2),
        "ab",
        ("tip_deflection", "tip_deflection_dot"),
        ("deformation", "velocity"),
        ("m", "m/s"),
        strict=True,
    ):
        draw_time(top, session, 4, variable)
        draw_off(bottom, session, 4, variable)
        label(top, "", f"{name} [{unit}]", f"({letter}) {name.capitalize()} of the free end")
        title = f"({letter}) How far engines are off, largest of all masses within 1 s"
        label(bottom, "time [s]", f"difference [{unit}]", title)
    legend(figure, panels[0, 0])
    return figure


def draw_figure_5(session: Session) -> Any:
    """Pulse: angle and deformation of the free end."""
    figure, panels = new_figure(3, 2, 2.1)
    for (whole, local, off), (one, two, three), variable, name, unit in zip(
        panels.T,
        (("a", "b", "e"), ("c", "d", "f")),
        ("tip_angle", "tip_deflection"),
        ("angle of the free end", "deformation"),
        ("rad", "m"),
        strict=True,
    ):
        draw_time(whole, session, 5, variable)
        draw_local(local, session, 5, variable, 5.0)
        draw_off(off, session, 5, variable)
        label(whole, "", f"{name} [{unit}]", f"({one}) {name.capitalize()}")
        label(local, "time [s]", f"{name} [m{unit}]", f"({two}) After the pulse, about the mean")
        title = f"({three}) How far engines are off, largest within 1 s"
        label(off, "time [s]", f"difference [{unit}]", title)
    for line in panels[0, 1].lines:  # four deformations cross each other
        line.set_linewidth(line.get_linewidth() / 2)
    legend(figure, panels[0, 0])
    return figure
