"""Figures 3-7 of the speed_regulator paper, drawn again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from ....reference.scene import Array
from ....reference.speed_regulator.motions import mean_speed
from ....reference.speed_regulator.theory import printed_mean_speed
from ...engines.registry import REFERENCE, get_engine
from ...queries.simulate import Simulation
from ...reports.drawing import INK, NOTE, PALETTE, broad, engine_line, label, new_figure
from ..drawing import dotted, draw_gap, handles_of, outside_legend
from ..session import Session
from .measures import (
    ANGLES,
    DAMPINGS,
    EXAMPLE,
    FINE,
    SCENE,
    STARTS,
    TURN,
    damped,
    last_turn,
    recorded_motion,
    speed_map,
    turn_speeds,
)

TARGET = float(np.round(mean_speed(EXAMPLE), 2))
"""The one printed speed [rad/s]."""

FORMULA_LINE = {
    "color": INK,
    "linewidth": 0.9,
    "linestyle": (0, (6, 2)),
    "label": "(21) as printed",
}
MODEL_STYLES: tuple[dict[str, Any], ...] = (
    {},
    {"markerfacecolor": "white", "linestyle": (0, (3, 1, 1, 1, 1, 1))},
)
"""Styles of an engine's first model, and of its second."""


def figure_3(session: Session) -> Any:
    """Draw the mean speed against the torque for three dampers."""
    fine, coarse = speed_map(session, count=FINE), speed_map(session).variables["mean_speed"]
    figure, axes = new_figure(2, 1, height=2.7, sharex=True)
    upper, lower = axes[:, 0]
    torque, truth = fine.x.values, fine.variables["mean_speed"]
    formula = np.array([printed_mean_speed(damped(c).replace(torque=torque)) for c in DAMPINGS])
    for c, speed, line in zip(DAMPINGS, truth, formula, strict=True):
        broad(upper, torque, speed, label=REFERENCE)
        upper.plot(torque, line, **FORMULA_LINE)
        upper.annotate(f"c = {c:g} N s/m", (torque[-1] * 1.01, speed[-1]), va="center", **NOTE)
    lower.plot(torque, np.fmax.reduce(abs(formula - truth)), **FORMULA_LINE)
    for name in session.engines:
        for model, style in zip(get_engine(name).models(SCENE)[:2], MODEL_STYLES, strict=False):
            own = speed_map(session, name, model=model)
            speeds, style = own.variables["mean_speed"], style | {"label": f"{name}, {model}"}
            for speed in speeds:
                engine_line(upper, name, own.x.values, speed, **style | {"linestyle": "none"})
            draw_gap(lower, name, own.x.values, np.fmax.reduce(abs(speeds - coarse)), **style)
    upper.plot(EXAMPLE.torque, TARGET, "*", color=INK, markersize=9, label="5.07 rad/s, as printed")
    upper.set_xlim(0, torque[-1] * 1.14)
    lower.set_yscale("log")
    label(upper, "", "mean speed [rad/s]", "(a) The speed grows with the torque")
    title = "(b) How far formula and engines are from the limit cycle, largest of all c"
    label(lower, "torque M_m [N m]", "|difference| [rad/s]", title)
    outside_legend(figure, handles_of(upper), columns=3)
    return figure


def figure_4(session: Session) -> Any:
    """Draw the angular speed from different starts."""
    names = [*(f"start_{speed:g}" for speed in STARTS), "start_slow"]
    title = "(a) From different speeds at the start to one, c = 2 N s/m"
    figure, upper = speeds_over_time(session, names, title)
    dotted(upper, TARGET)
    upper.annotate(f"{TARGET:.2f} rad/s", (180, TARGET + 0.25), **NOTE)
    upper.annotate("comes to rest", (70, 0.5), **NOTE)
    return figure


def figure_5(session: Session) -> Any:
    """Draw the angular speed for three dampers, from the same start."""
    names = [f"damping_{c:g}" for c in DAMPINGS]
    figure, upper = speeds_over_time(session, names, "(a) A stronger damper: a lower speed")
    for c, height in zip(DAMPINGS, (5.35, 3.75, 2.95), strict=True):
        upper.annotate(f"c = {c:g} N s/m", (88, height), **NOTE)
    upper.set_xlim(0, 100)
    return figure


def speeds_over_time(session: Session, names: Sequence[str], title: str) -> tuple[Any, Any]:
    """Return a figure of speeds over time and of engines' errors, and the panel of the speeds."""
    figure, axes = new_figure(2, 1, height=2.7, sharex=True)
    for name in names:
        draw_motion(session, axes[:, 0], name, partial(over_time, name="phi_dot"), turns_apart)
    upper, lower = axes[:, 0]
    label(upper, "", "angular speed [rad/s]", title)
    title = f"(b) How far engines are off, in the mean of {TURNS} turns"
    label(lower, "time [s]", "|difference| [rad/s]", title)
    outside_legend(figure, handles_of(upper), columns=4)
    return figure, upper


Curve = tuple[Array, Array] | Array
"""Values on the axes of a panel."""


def draw_motion(
    session: Session,
    panels: Sequence[Any],
    name: str,
    curve: Callable[[Simulation], Curve],
    distance: Callable[[Simulation, Simulation], Curve],
    **how: Any,
) -> None:
    """Draw a motion of `RUNS` in one panel, and the engines' errors in another.

    A line of the first panel is ``curve(motion)``, of the second ``distance(own, truth)``; ``how``
    is the style of the reference's.
    """
    truth, (motions, gaps) = recorded_motion(session, name), panels
    broad(motions, *curve(truth), **{"label": REFERENCE} | how)
    for engine in session.engines:
        own = recorded_motion(session, name, engine)
        engine_line(motions, engine, *curve(own))
        draw_gap(gaps, engine, *distance(own, truth))


def over_time(motion: Simulation, name: str) -> Curve:
    """Return times and an observable."""
    return motion.times, motion.observables[name]


TURNS = 4
"""Turns over which the speeds of two motions are averaged before they are compared."""


def turns_apart(own: Simulation, truth: Simulation) -> Curve:
    """Return times, and |difference| of the mean speeds of some turns."""
    ours, theirs = (turn_speeds(item, TURNS) for item in (truth, own))
    count = min(len(ours), len(theirs))
    return np.cumsum(TURN * TURNS / ours)[:count], abs(theirs[:count] - ours[:count])


def apart(own: Simulation, truth: Simulation, names: Sequence[str]) -> Curve:
    """Return times, and the distance of two motions in some observables."""
    gaps = [own.observables[name] - truth.observables[name] for name in names]
    return truth.times, np.linalg.norm(gaps, axis=0)


def figure_6(session: Session) -> Any:
    """Draw the braked motion."""
    figure, axes = new_figure(2, 2, height=2.5, sharex=True)
    for panels, name, quantity, unit, time, title, letter in (
        (axes[0], "phi_dot", "angular speed", "rad/s", "", "(a) The crank slows and swings", "b"),
        (axes[1], "y", "slider y", "m", "time [s]", "(c) The slider", "d"),
    ):
        curve, distance = partial(over_time, name=name), partial(apart, names=(name,))
        draw_motion(session, panels, "braked", curve, distance)
        label(panels[0], time, f"{quantity} [{unit}]", title)
        label(panels[1], time, f"|difference| [{unit}]", f"({letter}) How far engines are off")
    outside_legend(figure, handles_of(axes[0, 0]), columns=4)
    return figure


LAST_TURNS = 30.0
"""Time from which the braked motion is drawn [s]: its last turns, and how it comes to rest."""


def figure_7(session: Session) -> Any:
    """Draw the slider's motion in its phase plane."""
    figure, axes = new_figure(2, 2, height=2.7)
    (rotating, braked), (last, late) = axes
    for name, words, colour, dashes in (
        ("damping_4", "from 6 rad/s", PALETTE[2], "solid"),
        ("from_below", "from 1.5 rad/s", PALETTE[3], (0, (4, 1))),
    ):
        y, rate = smooth(recorded_motion(session, name))
        rotating.plot(y, rate, color=colour, linewidth=0.6, linestyle=dashes, label=words)
    cycle = {"colour": INK, "label": "limit cycle"}
    draw_motion(session, (rotating, last), "damping_4", last_turn, last_turns_apart, **cycle)
    curve, distance = partial(smooth, begin=LAST_TURNS), partial(apart, names=("y", "y_dot"))
    draw_motion(session, (braked, late), "braked", curve, distance)
    label(rotating, "y [m]", "dy/dt [m/s]", "(a) From both sides to one curve, c = 4 N s/m")
    label(braked, "y [m]", "dy/dt [m/s]", f"(b) Braked to rest, from {LAST_TURNS:g} s on")
    title = "(c) How far engines are off, last turn of (a)"
    label(last, "crank angle [rad]", "|difference| [m/s]", title)
    label(late, "time [s]", "|difference| [m, m/s]", "(d) How far engines are off in (b)")
    outside_legend(figure, handles_of(rotating, braked), columns=4)
    return figure


def last_turns_apart(own: Simulation, truth: Simulation) -> Curve:
    """Return crank angles, and |difference| of dy/dt in the last turn."""
    return ANGLES, abs(last_turn(own)[1] - last_turn(truth)[1])


def smooth(motion: Simulation, begin: float = 0.0) -> Curve:
    """Return y and dy/dt from some time on, between the samples too."""
    curve = CubicHermiteSpline(motion.times, motion.observables["y"], motion.observables["y_dot"])
    times = np.linspace(begin, motion.times[-1], 6 * len(motion.times))
    return curve(times), curve(times, 1)
