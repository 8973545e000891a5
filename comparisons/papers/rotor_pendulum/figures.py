"""Figures 2-6 of the rotor_pendulum paper, drawn again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from ....reference.rotor_pendulum import theory
from ....reference.rotor_pendulum.phase import wrapped
from ....reference.scene import Array
from ...maps.store import Map
from ...reports.drawing import (
    INK,
    broad,
    engine_line,
    label,
    look,
    new_figure,
)
from ...scenes.rotor_pendulum.phase import PHASES
from ..drawing import dotted, draw_gap, handles_of, outside_legend
from ..ledger import PaperFigure
from ..session import Session
from .regions import STARTS, fold_curve
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
    mu = theory.coupling_coefficients(FIG_2._replace(n_x=values[None], n_phi=values[:, None]))
    figure, axes = new_figure(2, 2, height=2.9)
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
        for x, y in product((0.4, 4.0), repeat=2):
            sign = field[np.argmin(abs(values - y)), np.argmin(abs(values - x))]
            panel.text(x, y, "+" if sign > 0 else "−", color="white", ha="center", va="center")
        label(panel, "$n_x$", "$n_\\varphi$", title)
    figure.colorbar(mesh, ax=axes[0, 1], label="modulus")
    _cuts_of_mu_1(axes[1, 1])
    return figure


def _cuts_of_mu_1(panel: Any) -> None:
    """Draw mu_1 at two n_phi, corrected and as printed."""
    values = np.linspace(*RANGE, 4 * FINE)
    versions = ((False, "#0072B2", "corrected"), (True, "#D55E00", "printed"))
    for (n_phi, line), (as_printed, colour, words) in product(CUTS, versions):
        n = FIG_2._replace(n_x=values, n_phi=n_phi)
        mu_1 = theory.coupling_coefficients(n, as_printed).mu_1
        panel.plot(
            values,
            np.where(abs(mu_1) < 6, mu_1, np.nan),
            color=colour,
            linestyle=line,
            linewidth=1.2,
            label=f"{words}, $n_\\varphi$ = {n_phi:g}",
        )
    panel.set_ylim(-4, 6)
    panel.legend(fontsize=7, frameon=False)
    label(panel, "$n_x$", "$\\mu_1$", "(d) $\\mu_1$ corrected and as printed")


# Fig. 3

PHASE = {"cmap": "twilight", "vmin": -np.pi, "vmax": np.pi}
"""Light where antiphase, dark where synphase, the sign by hue: grey shows the modulus."""


NONE = {"hatch": "/////", "edgecolor": "#BBBBBB", "linewidth": 0}
"""Ground on which there is no stable orbit."""


def figure_3(session: Session, betas: Mapping[str, float] = BETAS) -> Any:
    """Draw the stable phase difference: theory, orbits, and how far engines are off."""
    figure, axes = new_figure(len(betas), 2, height=2.2, sharex=True, sharey=True)
    for letter, (name, beta), (by_theory, orbits) in zip("abcd", betas.items(), axes, strict=False):
        true = phase_map(session, beta)
        mesh = _phases(by_theory, phase_map(session, beta, "theory"))
        _phases(orbits, true)
        orbits.patch.set(**NONE)
        _theory_curves(by_theory, beta)
        if name in STARTS:
            orbits.plot(*fold_curve(session, name), **FOLD)
        largest = []
        for side, engine in zip((-OFFSET, OFFSET), session.engines, strict=False):
            own = phase_map(session, beta, engine=engine)
            _engine_phases(orbits, own, engine, side)
            largest.append(f"{engine} to {np.nanmax(difference(own, true)):.1g} rad")
        angle = rf"$\beta$ = {name.replace('pi', 'π')}"
        label(by_theory, "", "$n_\\varphi$", f"({letter}) The theory, {angle}")
        label(orbits, title=", ".join(("Orbits", *largest)))
    for panel in axes[-1]:
        panel.set_xlabel("$n_x$", fontsize=8)
    axes[0, 0].set(  # and of all
        xlim=(RANGE[0] - 0.3, RANGE[1] + 0.4), ylim=(RANGE[0] - 0.3, RANGE[1] + 0.3)
    )
    bar = figure.colorbar(
        mesh,
        ax=axes,
        location="bottom",
        aspect=60,
        pad=0.02,
        ticks=[-np.pi, -np.pi / 2, 0, np.pi / 2, np.pi],
        label="$\\alpha = \\varphi_1 - \\varphi_2$ [rad]; hatched: no stable orbit",
    )
    bar.ax.set_xticklabels(["$-\\pi$", "$-\\pi/2$", "0", "$\\pi/2$", "$\\pi$"])
    bar.ax.tick_params(labelsize=8)
    _legend_of_figure_3(figure, session)
    return figure


TURN: Mapping[str, Any] = {
    "color": "#F0E442",
    "linewidth": 1.2,
    "label": "phase passes π/2: $n_\\varphi = 1/\\cos\\beta$",
}
RESONANCE: Mapping[str, Any] = {
    "color": "#56B4E9", "linewidth": 1.2, "linestyle": (0, (4, 1.5)),
    "label": "phase jumps by π: resonance, N = 0",
}  # fmt: skip
FOLD: Mapping[str, Any] = {
    "color": "#009E73", "linestyle": "none", "marker": "D", "markersize": 4,
    "label": "orbits begin: a fold",
}  # fmt: skip
"""Of the theory's curves, and of the orbits'."""


def _theory_curves(panel: Any, beta: float) -> None:
    """Draw where the phase of (30), (36) jumps by pi, and where it passes pi/2."""
    if beta == 0:
        panel.axvline(1, **RESONANCE)
        return
    n_x, own = np.linspace(*RANGE, 20 * FINE), theory.Ratios(0.0, 0.0)
    springs = own.sigma * (1 - n_x**2)
    square = springs / (springs + own.r_m * np.sin(beta) ** 2 * n_x**2)
    inside = (square > 0) & (square < RANGE[1] ** 2)
    panel.plot(n_x, np.sqrt(np.where(inside, square, np.nan)), **RESONANCE)
    panel.axhline(1 / np.cos(beta), **TURN)


def _stable(plane: Map) -> Array:
    """Return the phases (n_y, n_x) of a map, NaN where they are not stable."""
    unstable = plane.variables["class"] == PHASES.index("unstable")
    return np.where(unstable, np.nan, plane.variables["phase_difference"])


def _engine_phases(panel: Any, own: Map, engine: str, side: float) -> None:
    """Mark an engine's points over the orbits, filled by its phase; a cross: none."""
    x, y = np.meshgrid(own.x.values + side, own.y.values)
    phase, its = _stable(own), look(engine)
    style = {"marker": its.marker, "s": 13, "edgecolors": its.colour, "linewidths": 0.8}
    panel.scatter(x, y, c=phase, plotnonfinite=False, **style, **PHASE)
    none = np.isnan(phase)
    panel.scatter(x[none], y[none], marker="x", s=6, color=its.colour, linewidths=0.7)


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


def difference(own: Map, true: Map) -> Array:
    """Return how far an engine's phases are from the reference's [rad], on the circle."""
    row, column = true.y.nearest(own.y.values), true.x.nearest(own.x.values)
    same = np.max(abs(own.x.values - true.x.values[column])) < 1e-9
    apart: Array = abs(wrapped(_stable(own) - _stable(true)[np.ix_(row, column)]))
    return apart if same else np.full_like(apart, np.nan)


def _legend_of_figure_3(figure: Any, session: Session) -> None:
    from matplotlib.lines import Line2D

    style: Mapping[str, Any] = {"linestyle": "none", "markerfacecolor": "none", "markersize": 4.0}
    handles = [
        Line2D([], [], marker=its.marker, color=its.colour, label=f"{engine}; cross: none", **style)
        for engine, its in ((engine, look(engine)) for engine in session.engines)
    ]
    curves = [Line2D([], [], **how) for how in (RESONANCE, TURN, FOLD)]
    outside_legend(figure, (*curves, *handles), 3)


# Figs. 4-6

START_UP = 0.35
"""What the left column shows [s]."""

WINDOW = 128
"""Samples, about three turns, whose range and mean the right column shows."""

LIGHT = ("#BBBBBB", "#F0C27A")
"""Of rotors 1 and 2 by the reference."""

REDUCED_LINE = {"color": INK, "linewidth": 0.7, "marker": "", "label": "the paper's (11)"}

ROWS: tuple[tuple[str, str, Callable[[StartUp], Array | Sequence[Array]]], ...] = (
    ("(a) The rotors come up to speed", "speed [rad/s]", lambda run: run.states[5:7]),
    ("(a) How far rotor 1 is ahead of rotor 2", "α [rad]", lambda run: run.phase[None]),
    ("(b) The motors' torques fall with the speed", "torque [N m]", lambda run: run.torques),
    ("(c) The platform swings", "x [mm]", lambda run: 1e3 * run.states[:1]),
    ("(c) The rod swings", "$\\varphi_3$ [mrad]", lambda run: 1e3 * run.states[3:4]),
)
"""Title, quantity, and the lines of a run: one, or one for each rotor."""

MARKS: Mapping[int, Sequence[Sequence[float]]] = {
    1: ((153.8,), (-3.10,), (3.08,), (-0.7, 0.7), (-0.7, 0.7)),
    2: ((153.5,), (-0.515,), (3.23,), (-0.25, 0.25), (-20.0, 20.0)),
}
"""What section 5.2 prints of a case, for each of `ROWS`: levels and amplitudes."""

MARGIN = 0.06
"""Of the range of values, around it."""


def simulation_figure(case: int, session: Session) -> Any:
    """Draw the start from rest of a case: its first moments, all of it, and differences."""
    truth = from_rest(session, case)
    others = {name: from_rest(session, case, name) for name in session.engines}
    figure, axes = new_figure(len(ROWS) + 1, 2, height=1.25, sharex="col")
    early = truth.times <= START_UP
    for row, (title, quantity, lines) in enumerate(ROWS):
        left, right = axes[row]
        for rotor, line in reversed(list(enumerate(lines(truth)))):
            name = f"reference, rotor {rotor + 1}" if row in (0, 2) else "reference"
            broad(left, truth.times[early], line[early], LIGHT[rotor], label=name)
            _band(right, truth.times, line, LIGHT[rotor])
            for name, run in others.items():
                own = lines(run)[rotor]
                engine_line(left, name, run.times[early], own[early])
                engine_line(right, name, _means(run.times), _means(own))
        label(left, "", quantity, title)
        if row in (0, 2):
            spread = [line[truth.after(START_UP)] for line in lines(truth)]
            lowest, highest = np.min(spread), np.max(spread)
            gap = MARGIN * (highest - lowest)
            right.set_ylim(lowest - gap, highest + gap)
        for height in MARKS.get(case, ((),) * len(ROWS))[row]:
            dotted(right, height, label="printed in the paper")
    label(axes[0, 0], "", ROWS[0][1], f"{ROWS[0][0]}, first {START_UP:g} s")
    label(axes[0, 1], title="All of it: mean and range of 3 turns")
    for name, run in {**others, REDUCED: from_rest(session, case, REDUCED)}.items():
        apart = abs(run.phase - truth.phase)
        line = REDUCED_LINE if name == REDUCED else {}
        draw_gap(axes[-1, 0], name, truth.times[early], apart[early], **line)
        draw_gap(axes[-1, 1], name, _means(truth.times), _windows(apart).max(axis=1), **line)
    label(axes[-1, 0], "time [s]", "distance [rad]", "How far α is from the reference's")
    axes[-1, 1].set_xlabel("time [s]", fontsize=8)
    axes[-1, 0].set_xlim(0, START_UP)
    axes[-1, 1].set_xlim(0, truth.times[-1])
    rotors = sorted(handles_of(axes[0, 0]), key=lambda handle: str(handle.get_label()))
    outside_legend(figure, (*rotors, *handles_of(axes[-1, 0], axes[0, 1])), 3)
    return figure


def _windows(values: Array) -> Array:
    """Return values (k, WINDOW); what is left over at the end is dropped."""
    count = len(values) // WINDOW
    return values[: count * WINDOW].reshape(count, WINDOW)


def _means(values: Array) -> Array:
    return _windows(values).mean(axis=1)


def _band(panel: Any, times: Array, values: Array, colour: str) -> None:
    """Draw the range of values over each window, and their mean."""
    ends = _windows(values).min(axis=1), _windows(values).max(axis=1)
    panel.fill_between(_means(times), *ends, color=colour, alpha=0.6, lw=0)
    broad(panel, _means(times), _means(values), colour)


# All of them


RUN_CAPTION = (
    "Simulated with the printed stiffnesses, not the printed frequency ratios (n_x = {n.n_x:g}, "
    "n_phi = {n.n_phi:g}), which do not belong to them. From rest, both motors switched on at "
    "once; the text gives no time "
    f"axis, {{horizon:g}} s are shown{{why}}. Left: the first {START_UP:g} s, right: all of it, "
    "range and mean over three turns each, speeds and torques without the start. Torques are "
    f"those of the motors, alpha is phi_1 - phi_2. Engines take steps of 1/{1 / STEP:.0f} s. "
    "Below: how far the phase difference of engines and of the reduced equations (11) is from the "
    "exact ones'."
)


DOTTED = "Dotted: the printed speed, phase, torque and amplitudes"


def _caption(case: int, why: str = "") -> str:
    return RUN_CAPTION.format(n=PRINTED_RATIOS[case], horizon=HORIZONS[case], why=why)


FIGURES: tuple[PaperFigure, ...] = (
    PaperFigure(
        2,
        "Coupling coefficients are large where a frequency ratio is near 1",
        "Modulus of (22) for sigma = 0.17, r_m = 0.02, beta = 30 degrees, with mu_1 corrected; "
        "white lines: where the sign (+, −) changes, through infinity on the curves of resonance. "
        "The paper draws surfaces, and names mu_2 in two panels: (a) is mu_1 and, mirrored, mu_4. "
        "(d) is mu_1 along two lines. Theory alone: no "
        "engine takes part.",
        figure_2,
    ),
    PaperFigure(
        3,
        "By the theory there is always a stable phase difference; with the dampers often not",
        "Left: the root of (30) that satisfies (36), mu_1 corrected. Right: mean phase of the "
        "stable synchronous orbit of the exact equations, with the dampers of table 1 "
        f"({GRID} x {GRID} points), and on {ENGINE_GRID} x {ENGINE_GRID} of them those of the "
        "engines' own orbits, filled by the same colours, one beside the "
        "other, 0.15 off their place; a cross: none; above, the largest "
        "difference between engine and reference. Curves: where the theory's phase jumps by pi "
        "(resonance) and where it passes pi/2, and for beta = pi/6 and pi/3 the fold at which "
        "orbits begin, followed at n_x = 2, 3, 7. Frequency ratios are made with the stiffnesses, "
        "at the speed at which motor and bearing balance. The paper draws surfaces.",
        figure_3,
    ),
    PaperFigure(
        4,
        "Case 1: from rest the rotors settle in antiphase",
        _caption(1, ", as the rotors start beside the unstable phase")
        + f" {DOTTED}, the phase with the sign of ours.",
        partial(simulation_figure, 1),
    ),
    PaperFigure(
        5,
        "Case 2: from rest the rotors settle in synphase, at another phase than printed",
        _caption(2) + f" {DOTTED}.",
        partial(simulation_figure, 2),
    ),
    PaperFigure(
        6,
        "Case 3: with an upright rod the rotors come to no common speed",
        _caption(3, ", in which rotor 1 gains more than a turn"),
        partial(simulation_figure, 3),
    ),
)
