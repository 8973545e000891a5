"""Figures 3-7 of the speed_regulator paper, drawn again."""

from __future__ import annotations

from collections.abc import Sequence
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
    RUNS,
    SCENE,
    STARTS,
    TURN,
    damped,
    last_turn,
    recorded_motion,
    speed_map,
    turn_speeds,
)

FORMULA_LINE = {
    "color": INK,
    "linewidth": 0.9,
    "linestyle": (0, (6, 2)),
    "label": "(21) as printed",
}


def figure_3(session: Session) -> Any:
    """Draw the mean speed against the torque for three dampers."""
    fine, coarse = speed_map(session, fine=True), speed_map(session).variables["mean_speed"]
    figure, axes = new_figure(2, 1, height=2.7, sharex=True)
    upper, lower = axes[:, 0]
    torque, truth = fine.x.values, fine.variables["mean_speed"]
    formula = np.array([printed_mean_speed(damped(c).replace(torque=torque)) for c in DAMPINGS])
    for c, speed, line in zip(DAMPINGS, truth, formula, strict=True):
        broad(upper, torque, speed, label=REFERENCE)
        upper.plot(torque, line, **FORMULA_LINE)
        upper.annotate(f"c = {c:g} N s/m", (torque[-1] * 1.01, speed[-1]), va="center", **NOTE)
    lower.plot(torque, largest(formula - truth), **FORMULA_LINE)
    for name in session.engines:
        for model, how in zip(get_engine(name).models(SCENE)[:2], MODEL_STYLES, strict=False):
            own = speed_map(session, name, model=model)
            speeds, how = own.variables["mean_speed"], how | {"label": f"{name}, {model}"}
            for speed in speeds:
                engine_line(upper, name, own.x.values, speed, **how | {"linestyle": "none"})
            draw_gap(lower, name, own.x.values, largest(speeds - coarse), **how)
    target = float(np.round(mean_speed(EXAMPLE), 2))
    upper.plot(EXAMPLE.torque, target, "*", color=INK, markersize=9, label="5.07 rad/s, as printed")
    upper.set_xlim(0, torque[-1] * 1.14)
    lower.set_yscale("log")
    label(upper, "", "mean speed [rad/s]", "(a) The speed grows with the torque")
    what = "(b) How far formula and engines are from the limit cycle, largest of all c"
    label(lower, "torque M_m [N m]", "|difference| [rad/s]", what)
    outside_legend(figure, handles_of(upper), columns=3)
    return figure


MODEL_STYLES: tuple[dict[str, Any], ...] = (
    {},
    {"markerfacecolor": "white", "linestyle": (0, (3, 1, 1, 1, 1, 1))},
)
"""Styles of an engine's first model, and of its second."""


def largest(gaps: Array) -> Array:
    """Return the largest modulus over the dampers (3, n), NaN where there is none."""
    most = np.max(np.nan_to_num(np.abs(gaps)), axis=0)
    return np.where(most > 0, most, np.nan)


def figure_4(session: Session) -> Any:
    """Draw the angular speed from different starts."""
    names = [*(f"start_{speed:g}" for speed in STARTS), "start_slow"]
    title = "(a) From different speeds at the start to one, c = 2 N s/m"
    figure, upper, _ = speeds_over_time(session, names, title)
    target = float(np.round(mean_speed(EXAMPLE), 2))
    dotted(upper, target)
    upper.annotate(f"{target:.2f} rad/s", (180, target + 0.25), **NOTE)
    upper.annotate("comes to rest", (70, 0.5), **NOTE)
    return figure


def figure_5(session: Session) -> Any:
    """Draw the angular speed for three dampers, from the same start."""
    names = [f"damping_{c:g}" for c in DAMPINGS]
    figure, upper, lower = speeds_over_time(session, names, "(a) A stronger damper: a lower speed")
    for c, height in zip(DAMPINGS, (5.35, 3.75, 2.95), strict=True):
        upper.annotate(f"c = {c:g} N s/m", (88, height), **NOTE)
    lower.set_xlim(0, RUNS["damping_4"].seconds)
    return figure


def speeds_over_time(session: Session, names: Sequence[str], title: str) -> tuple[Any, Any, Any]:
    """Draw speeds over time, and how far an engine's turns are from the reference's.

    Returns
    -------
    figure, upper, lower : matplotlib Figure and Axes
    """
    figure, axes = new_figure(2, 1, height=2.7, sharex=True)
    upper, lower = axes[:, 0]
    for name in names:
        truth = recorded_motion(session, name)
        broad(upper, truth.times, truth.observables["phi_dot"], label=REFERENCE)
        for engine in session.engines:
            own = recorded_motion(session, name, engine)
            engine_line(upper, engine, own.times, own.observables["phi_dot"])
            if name != "start_slow":
                draw_gap(lower, engine, *turns_apart(own, truth))
    label(upper, "", "angular speed [rad/s]", title)
    what = f"(b) How far engines are off, in the mean of {TURNS} turns"
    label(lower, "time [s]", "|difference| [rad/s]", what)
    outside_legend(figure, handles_of(upper), columns=4)
    return figure, upper, lower


TURNS = 4
"""Turns over which the speeds of two motions are averaged before they are compared."""


def turns_apart(own: Simulation, truth: Simulation) -> tuple[Array, Array]:
    """Return times, and |difference| of the mean speeds of some turns."""
    ours, theirs = (turn_speeds(item, TURNS) for item in (truth, own))
    count = min(len(ours), len(theirs))
    return np.cumsum(TURN * TURNS / ours)[:count], abs(theirs[:count] - ours[:count])


OFF = "(b) How far engines are off"


def figure_6(session: Session) -> Any:
    """Draw the braked motion."""
    truth = recorded_motion(session, "braked")
    figure, axes = new_figure(2, 2, height=2.5, sharex=True)
    rows = (
        ("phi_dot", "rad/s", "", "angular speed [rad/s]", "(a) The crank slows and swings", OFF),
        ("y", "m", "time [s]", "slider y [m]", "(c) The slider", OFF.replace("b", "d", 1)),
    )
    for (left, right), (name, unit, time, observable, title, against) in zip(
        axes, rows, strict=True
    ):
        broad(left, truth.times, truth.observables[name], label=REFERENCE)
        for engine in session.engines:
            own = recorded_motion(session, "braked", engine).observables[name]
            engine_line(left, engine, truth.times, own)
            draw_gap(right, engine, truth.times, abs(own - truth.observables[name]))
        label(left, time, observable, title)
        label(right, time, f"|difference| [{unit}]", against)
    outside_legend(figure, handles_of(axes[0, 0]), columns=4)
    return figure


PHASE_RUNS = {
    "damping_4": ("from 6 rad/s", PALETTE[2], "solid"),
    "from_below": ("from 1.5 rad/s", PALETTE[3], (0, (4, 1))),
}
LAST_TURNS = 30.0
"""Time from which the braked motion is drawn [s]: its last turns, and how it comes to rest."""


def figure_7(session: Session) -> Any:
    """Draw the slider's motion in its phase plane."""
    figure, axes = new_figure(2, 2, height=2.7)
    (rotating, braked), (last, over_time) = axes
    for name, (words, colour, dashes) in PHASE_RUNS.items():
        y, rate = smooth(recorded_motion(session, name))
        rotating.plot(y, rate, color=colour, linewidth=0.6, linestyle=dashes, label=words)
    cycle = last_turn(recorded_motion(session, "damping_4"))
    stopping = recorded_motion(session, "braked")
    broad(rotating, cycle[0], cycle[1], INK, label="limit cycle")
    broad(braked, *smooth(stopping, LAST_TURNS), label=REFERENCE)
    for engine in session.engines:
        turn = last_turn(recorded_motion(session, "damping_4", engine))
        engine_line(rotating, engine, *turn)
        draw_gap(last, engine, ANGLES, abs(turn[1] - cycle[1]))
        own = recorded_motion(session, "braked", engine)
        engine_line(braked, engine, *smooth(own, LAST_TURNS))
        gap = np.hypot(*(own.observables[k] - stopping.observables[k] for k in ("y", "y_dot")))
        draw_gap(over_time, engine, own.times, gap)
    label(rotating, "y [m]", "dy/dt [m/s]", "(a) From both sides to one curve, c = 4 N s/m")
    label(braked, "y [m]", "dy/dt [m/s]", f"(b) Braked to rest, from {LAST_TURNS:g} s on")
    label(
        last,
        "crank angle [rad]",
        "|difference| [m/s]",
        "(c) How far engines are off, last turn of (a)",
    )
    label(over_time, "time [s]", "|difference| [m, m/s]", "(d) How far engines are off in (b)")
    outside_legend(figure, handles_of(rotating, braked), columns=4)
    return figure


SMOOTH = 6
"""Points drawn for each sample of a motion."""


def smooth(motion: Simulation, begin: float = 0.0) -> tuple[Array, Array]:
    """Return y and dy/dt from some time on, between the samples too."""
    curve = CubicHermiteSpline(motion.times, motion.observables["y"], motion.observables["y_dot"])
    times = np.linspace(begin, motion.times[-1], SMOOTH * len(motion.times))
    return curve(times), curve(times, 1)
