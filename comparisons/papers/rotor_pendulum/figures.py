"""Figures 2-6 of the rotor_pendulum paper, drawn again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from ....reference.rotor_pendulum import theory
from ....reference.rotor_pendulum.phase import wrapped
from ....reference.scene import Array
from ...maps.store import Map
from ...reports.drawing import (
    INK,
    NOTE,
    broad,
    engine_line,
    label,
    look,
    new_figure,
)
from ..drawing import dotted, draw_gap, handles_of, outside_legend
from ..ledger import PaperFigure
from ..session import Session
from .results import (
    BETAS,
    ENGINE_GRID,
    GRID,
    HORIZONS,
    PRINTED_RATIOS,
    RANGE,
    REDUCED,
    STEP,
    StartUp,
    from_rest,
    phase_map,
)

# Fig. 2

FIG_2 = theory.Ratios(0.0, 0.0, sigma=0.17, r_m=0.02, beta=np.pi / 6)
FINE = 281
LARGEST_COUPLING, SMALLEST_COUPLING = 1e2, 1e-3
CUTS = ((0.5, "solid"), (2.0, (0, (4, 1.5))))
COEFFICIENTS = (
    ("mu_1", "(a) $\\mu_1$; of $\\mu_4$ the mirror image"),
    ("mu_2", "(b) $\\mu_2$"),
    ("mu_3", "(c) $\\mu_3$"),
)


def figure_2(session: Session) -> Any:
    """Draw the coupling coefficients over the frequency ratios, and mu_1 as it is printed."""
    from matplotlib.colors import LogNorm

    values = np.linspace(*RANGE, FINE)
    n = FIG_2._replace(n_x=values[None], n_phi=values[:, None])
    mu = theory.coupling_coefficients(n)
    figure, axes = new_figure(2, 2, height=2.9)
    mesh = None
    for panel, (name, title) in zip(axes.flat, COEFFICIENTS, strict=False):
        field = np.array(np.broadcast_to(getattr(mu, name), (FINE, FINE)))
        mesh = panel.pcolormesh(
            values,
            values,
            np.clip(abs(field), SMALLEST_COUPLING, LARGEST_COUPLING),
            norm=LogNorm(SMALLEST_COUPLING, LARGEST_COUPLING),
            cmap="cividis",
            rasterized=True,
            shading="nearest",
        )
        panel.contour(values, values, field > 0, levels=[0.5], colors="white", linewidths=0.8)
        for x, y in ((0.4, 0.4), (4.0, 0.4), (0.4, 4.0), (4.0, 4.0)):
            sign = field[np.argmin(abs(values - y)), np.argmin(abs(values - x))]
            panel.text(x, y, "+" if sign > 0 else "−", color="white", ha="center", va="center")
        label(panel, "$n_x$", "$n_\\varphi$", title)
    figure.colorbar(mesh, ax=axes[0, 1], label="modulus")
    _cuts_of_mu_1(axes[1, 1])
    return figure


def _cuts_of_mu_1(panel: Any) -> None:
    """Draw mu_1 at two n_phi, corrected and as printed."""
    values = np.linspace(*RANGE, 4 * FINE)
    for n_phi, line in CUTS:
        n = FIG_2._replace(n_x=values, n_phi=n_phi)
        right, printed = (theory.coupling_coefficients(n, wrong).mu_1 for wrong in (False, True))
        for mu_1, colour, how in (
            (right, "#0072B2", "corrected"),
            (printed, "#D55E00", "printed"),
        ):
            cut = np.where(abs(mu_1) < 6, mu_1, np.nan)
            name = f"{how}, $n_\\varphi$ = {n_phi:g}"
            panel.plot(values, cut, color=colour, linestyle=line, linewidth=1.2, label=name)
    panel.set_ylim(-4, 6)
    panel.legend(fontsize=7, frameon=False)
    label(panel, "$n_x$", "$\\mu_1$", "corrected and as printed")


# Fig. 3

PHASE = {"cmap": "twilight", "vmin": -np.pi, "vmax": np.pi}
"""Light where antiphase, dark where synphase, the sign by hue: grey shows the modulus."""


TITLES = ("theory", "orbits of the exact equations", "engine − reference")


def figure_3(session: Session, betas: Mapping[str, float] = BETAS) -> Any:
    """Draw the stable phase difference: theory, orbits, and how far engines are off."""
    figure, axes = new_figure(len(betas), 3, height=1.95, sharex=True, sharey=True)
    mesh = None
    for row, (name, beta) in enumerate(betas.items()):
        ours = phase_map(session, beta, "theory")
        true = phase_map(session, beta)
        mesh = _phases(axes[row, 0], ours)
        _phases(axes[row, 1], true)
        for panel in (axes[row, 1], axes[row, 2]):
            for side, engine in zip((-OFFSET, OFFSET), session.engines, strict=False):
                _engine_points(panel, phase_map(session, beta, engine=engine), engine, true, side)
        axes[row, 2].set_facecolor("#F4F4F4")
        letter = f"({'abcd'[row]}) " + rf"$\beta$ = {name.replace('pi', 'π')}" + ":" * (row == 0)
        for column, title in enumerate(TITLES):
            heading = f"{letter if column == 0 else ''} {title if row == 0 else ''}"
            label(
                axes[row, column],
                "$n_x$" if row == len(betas) - 1 else "",
                "$n_\\varphi$" if column == 0 else "",
                heading.strip(),
            )
            axes[row, column].set_xlim(RANGE[0] - 0.3, RANGE[1] + 0.4)
            axes[row, column].set_ylim(RANGE[0] - 0.3, RANGE[1] + 0.3)
    bar = figure.colorbar(
        mesh,
        ax=axes[:, :2],
        location="bottom",
        aspect=45,
        pad=0.02,
        ticks=[-np.pi, -np.pi / 2, 0, np.pi / 2, np.pi],
        label="$\\alpha = \\varphi_1 - \\varphi_2$ [rad]; white: no stable orbit",
    )
    bar.ax.set_xticklabels(["$-\\pi$", "$-\\pi/2$", "0", "$\\pi/2$", "$\\pi$"])
    bar.ax.tick_params(labelsize=8)
    if session.engines:
        _engine_legend(figure, session)
    return figure


def _stable(plane: Map) -> Array:
    """Return the phases (n_y, n_x) of a map, NaN where they are not stable."""
    unstable = plane.about["class"].classes.index("unstable")
    stable: Array = np.where(
        plane.variables["class"] == unstable, np.nan, plane.variables["phase_difference"]
    )
    return stable


def _phases(panel: Any, plane: Map) -> Any:
    return panel.pcolormesh(
        plane.x.values,
        plane.y.values,
        np.ma.masked_invalid(_stable(plane)),
        shading="nearest",
        rasterized=True,
        **PHASE,
    )


OFFSET = 0.15
"""By which the engines' markers stand beside a point, so that none hides another."""


def _engine_points(panel: Any, own: Map, engine: str, true: Map, side: float) -> None:
    """Mark an engine's points: filled by its phase over the orbits, by size of the difference."""
    x, y = np.meshgrid(own.x.values, own.y.values)
    phase = _stable(own)
    edge = look(engine).colour
    marker = look(engine).marker
    if panel.get_subplotspec().colspan.start == 1:
        panel.scatter(
            x + side,
            y,
            c=phase,
            marker=marker,
            s=13,
            edgecolors=edge,
            linewidths=0.8,
            plotnonfinite=False,
            **PHASE,
        )
        none = np.isnan(phase)
        panel.scatter((x + side)[none], y[none], marker="x", s=6, color=edge, linewidths=0.7)
        return
    apart = difference(own, true)
    size = np.where(np.isfinite(apart), 3 * (12 + np.log10(np.maximum(apart, 1e-12))), 0)
    panel.scatter(x + side, y, marker=marker, s=size, color=edge, linewidths=0)


def difference(own: Map, true: Map) -> Array:
    """Return how far an engine's phases are from the reference's [rad], on the circle."""
    row, column = (
        np.argmin(abs(mine.values[:, None] - its.values), axis=1)
        for mine, its in ((own.y, true.y), (own.x, true.x))
    )
    same = np.max(abs(own.x.values - true.x.values[column])) < 1e-9
    apart: Array = abs(wrapped(_stable(own) - _stable(true)[np.ix_(row, column)]))
    return apart if same else np.full_like(apart, np.nan)


def _engine_legend(figure: Any, session: Session) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D(
            [],
            [],
            linestyle="none",
            marker=look(engine).marker,
            markersize=4,
            color=look(engine).colour,
            label=engine,
        )
        for engine in session.engines
    ]
    handles += [
        Line2D(
            [],
            [],
            linestyle="none",
            marker="o",
            markersize=float(np.sqrt(3 * (12 + power))),
            color="#888888",
            label=f"$10^{{{power}}}$ rad",
        )
        for power in (-9, -6, -3)
    ]
    outside_legend(figure, handles)


# Figs. 4-6

START_UP = 0.35
"""What the left column shows [s]."""

WINDOW = 128
"""Samples, about three turns, whose range and mean the right column shows."""

LIGHT = ("#BBBBBB", "#F0C27A")
"""Of rotors 1 and 2 by the reference."""

REDUCED_LINE = {"color": INK, "linewidth": 0.7, "marker": "", "label": "reduced, (11)"}

ROWS: tuple[tuple[str, str, Callable[[StartUp], Array | Sequence[Array]]], ...] = (
    ("(a) speeds", "rad/s", lambda run: run.states[5:7]),
    ("(a) phase difference", "rad", lambda run: run.phase[None]),
    ("(b) motor torques", "N m", lambda run: run.torques),
    ("(c) platform, x", "mm", lambda run: 1e3 * run.states[:1]),
    ("(c) rod, phi_3", "mrad", lambda run: 1e3 * run.states[3:4]),
)
"""Title, unit, and the lines of a run: one, or one for each rotor."""

MARKS: Mapping[int, Sequence[tuple[float, str]]] = {
    1: ((-np.pi, "$-\\pi$"), (-3.10, "")),
    2: ((-0.515, "printed"),),
}
"""Dotted lines beside the phase difference of a case, and their names."""


def simulation_figure(case: int, session: Session) -> Any:
    """Draw the start from rest of a case: its first moments, all of it, and differences."""
    truth = from_rest(session, case)
    others = {name: from_rest(session, case, name) for name in session.engines}
    reduced = from_rest(session, case, REDUCED)
    figure, axes = new_figure(len(ROWS) + 1, 2, height=1.25, sharex="col")
    early = truth.times <= START_UP
    for row, (title, unit, lines) in enumerate(ROWS):
        left, right = axes[row]
        for rotor, line in reversed(list(enumerate(lines(truth)))):
            name = f"reference, rotor {rotor + 1}" if row in (0, 2) else "reference"
            broad(left, truth.times[early], line[early], LIGHT[rotor], label=name)
            _band(right, truth.times, line, LIGHT[rotor])
            for name, run in others.items():
                own = lines(run)[rotor]
                engine_line(left, name, run.times[early], own[early])
                engine_line(right, name, *_means(run.times, own))
        label(left, "", f"[{unit}]", title)
        if row in (0, 2):
            spread = [line[truth.after(START_UP)] for line in lines(truth)]
            right.set_ylim(np.min(spread), np.max(spread))
    label(axes[0, 1], "", "", "range and mean over three turns each")
    _differences(axes[-1], truth, others, reduced, early)
    for panel in axes[-1]:
        panel.set_xlabel("time [s]", fontsize=8)
    axes[-1, 0].set_xlim(0, START_UP)
    axes[-1, 1].set_xlim(0, truth.times[-1])
    for height, words in MARKS.get(case, ()):
        dotted(axes[1, 1], height)
        axes[1, 1].annotate(words, (0.02, height), xycoords=("axes fraction", "data"), **NOTE)
    outside_legend(figure, handles_of(axes[0, 0], axes[-1, 0]))
    return figure


def _windows(values: Array) -> Array:
    """Return values (k, WINDOW); what is left over at the end is dropped."""
    count = len(values) // WINDOW
    return values[: count * WINDOW].reshape(count, WINDOW)


def _means(times: Array, values: Array) -> tuple[Array, Array]:
    return _windows(times).mean(axis=1), _windows(values).mean(axis=1)


def _band(panel: Any, times: Array, values: Array, colour: str) -> None:
    """Draw the range of values over each window, and their mean."""
    at, mean = _means(times, values)
    parts = _windows(values)
    panel.fill_between(at, parts.min(axis=1), parts.max(axis=1), color=colour, alpha=0.6, lw=0)
    broad(panel, at, mean, colour)


def _differences(
    panels: Any, truth: StartUp, others: dict[str, StartUp], reduced: StartUp, early: Any
) -> None:
    """Draw how far phases are from the reference's, in the start-up and over all of it."""
    for name, run in {**others, REDUCED: reduced}.items():
        apart = abs(run.phase - truth.phase)
        at = _windows(truth.times).mean(axis=1)
        for panel, x, y in (
            (panels[0], truth.times[early], apart[early]),
            (panels[1], at, _windows(apart).max(axis=1)),
        ):
            draw_gap(panel, name, x, y, **(REDUCED_LINE if name == REDUCED else {}))
    label(panels[0], "", "[rad]", "|difference from the reference|, phase difference")


# All of them


RUN_CAPTION = (
    "Simulated with the printed stiffnesses, not the printed frequency ratios (n_x = {n.n_x:g}, "
    "n_phi = {n.n_phi:g}), which do not belong to them. From rest, both motors switched on at "
    "once; the text gives no time "
    f"axis, {{horizon:g}} s are shown{{why}}. Left: the first {START_UP:g} s, right: all of it, "
    "range and mean over three turns each, speeds and torques without the start. Torques are "
    f"those of the motors. Engines take steps of 1/{1 / STEP:.0f} s. Below: how far the phase "
    "difference of engines and of the reduced equations (11) is from the exact ones'."
)


def _caption(case: int, why: str = "") -> str:
    return RUN_CAPTION.format(n=PRINTED_RATIOS[case], horizon=HORIZONS[case], why=why)


FIGURES: tuple[PaperFigure, ...] = (
    PaperFigure(
        2,
        "coupling coefficients over the frequency ratios",
        "Modulus of (22) for sigma = 0.17, r_m = 0.02, beta = 30 degrees, with mu_1 corrected; "
        "white lines: where the sign (+, −) changes, through infinity on the curves of resonance. "
        "The paper draws surfaces, and names mu_2 in two panels: (a) is mu_1 and, mirrored, mu_4. "
        "Below on the right mu_1 along two lines, corrected and as printed. Theory alone: no "
        "engine takes part.",
        figure_2,
    ),
    PaperFigure(
        3,
        "stable phase difference over the frequency ratios",
        "Left: the root of (30) that satisfies (36), mu_1 corrected. Middle: mean phase of the "
        "stable synchronous orbit of the exact equations, with the dampers of table 1 "
        f"({GRID} x {GRID} points), and on {ENGINE_GRID} x {ENGINE_GRID} of them those of the "
        "engines' own orbits, filled by the same colours; a cross: none. Right: size of the "
        "difference between engine and reference. Frequency ratios are made with the stiffnesses, "
        "at the speed at which motor and bearing balance. The paper draws surfaces.",
        figure_3,
    ),
    PaperFigure(
        4,
        "case 1: start from rest into antiphase",
        _caption(1, ", as the rotors start beside the unstable phase")
        + " The dotted lines are -pi and the printed 3.10 rad with the sign of ours.",
        partial(simulation_figure, 1),
    ),
    PaperFigure(
        5,
        "case 2: start from rest into synphase",
        _caption(2) + " The dotted line is the printed phase, -0.515 rad.",
        partial(simulation_figure, 2),
    ),
    PaperFigure(
        6,
        "case 3: an upright rod, no synchronism",
        _caption(3, ", in which rotor 1 gains more than a turn"),
        partial(simulation_figure, 3),
    ),
)
