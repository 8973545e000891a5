"""Figures 2-6 of the rotor_pendulum paper, drawn again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import product
from typing import Any

import numpy as np

from ....reference.rotor_pendulum import theory
from ....reference.rotor_pendulum.phase import wrapped
from ....reference.scene import Array
from ...maps.store import Map
from ...reports.drawing import (
    broad,
    engine_line,
    label,
    look,
    new_figure,
)
from ..drawing import dotted, draw_gap, handles_of, outside_legend
from ..session import Session
from .measures import (
    BETAS,
    CURVE_SECONDS,
    LARGEST,
    RANGE,
    REDUCED,
    STARTS,
    StartUp,
    fold_curve,
    from_rest,
    other_start,
    phase_map,
    stable_phases,
    theory_on,
)

# Fig. 2

FIG_2 = theory.Ratios(0.0, 0.0, sigma=0.17, r_m=0.02, beta=np.pi / 6)
FINE = 281
LARGEST_COUPLING, SMALLEST_COUPLING = 1e2, 1e-3
CUTS = (
    (0.5, False, {"color": "#222222", "linestyle": "solid"}),
    (2.0, False, {"color": "#0072B2", "linestyle": (0, (4, 1.5))}),
    (0.5, True, {"color": "#D55E00", "linestyle": (0, (1, 1.2))}),
    (2.0, True, {"color": "#CC79A7", "linestyle": (0, (4, 1.5, 1, 1.5))}),
)
"""n_phi, whether mu_1 is as printed, and the line."""
COEFFICIENTS = (
    ("mu_1", "(a) $\\mu_1$; of $\\mu_4$ the mirror image"),
    ("mu_2", "(b) $\\mu_2$"),
    ("mu_3", "(c) $\\mu_3$"),
)
CELLS: Mapping[str, Any] = {"rasterized": True, "shading": "nearest"}


def figure_2(session: Session) -> Any:
    """Draw the coupling coefficients over the frequency ratios, and mu_1 as it is printed."""
    from matplotlib.colors import LogNorm

    values = np.linspace(*RANGE, FINE)
    mu = theory.coupling_coefficients(FIG_2._replace(n_x=values[None], n_phi=values[:, None]))
    figure, axes = new_figure(2, 2, height=2.9)
    for panel, (name, title) in zip(axes.flat, COEFFICIENTS, strict=False):
        field = np.array(np.broadcast_to(getattr(mu, name), (FINE, FINE)))
        size = np.clip(abs(field), SMALLEST_COUPLING, LARGEST_COUPLING)
        scale = {"norm": LogNorm(SMALLEST_COUPLING, LARGEST_COUPLING), "cmap": "cividis"}
        mesh = panel.pcolormesh(values, values, size, **scale, **CELLS)
        panel.contour(values, values, field > 0, levels=[0.5], colors="white", linewidths=0.8)
        for x, y in product((0.4, 4.0), repeat=2):
            sign = field[np.argmin(abs(values - y)), np.argmin(abs(values - x))]
            panel.text(x, y, "+" if sign > 0 else "−", color="white", ha="center", va="center")
        label(panel, "$n_x$", "$n_\\varphi$", title)
    figure.colorbar(mesh, ax=axes[0, 1], label="modulus")
    panel, fine = axes[1, 1], np.linspace(*RANGE, 4 * FINE)
    for n_phi, as_printed, line in CUTS:
        n = FIG_2._replace(n_x=fine, n_phi=n_phi)
        mu_1 = theory.coupling_coefficients(n, as_printed).mu_1
        words = f"{'printed' if as_printed else 'corrected'}, $n_\\varphi$ = {n_phi:g}"
        panel.plot(fine, np.where(abs(mu_1) < 6, mu_1, np.nan), linewidth=1.2, label=words, **line)
    panel.set_ylim(-4, 6)
    panel.legend(fontsize=7, frameon=False)
    label(panel, "$n_x$", "$\\mu_1$", "(d) $\\mu_1$ corrected and as printed")
    return figure


# Fig. 3

PHASE = {"cmap": "twilight", "vmin": -np.pi, "vmax": np.pi}
"""Colours of phases: light for antiphase, dark for synphase, the sign by hue, grey the modulus."""


NONE = {"hatch": "/////", "edgecolor": "#BBBBBB", "linewidth": 0}
"""Ground on which there is no stable orbit."""

TURN: Mapping[str, Any] = {
    "color": "#F0E442", "linewidth": 1.2,
    "label": "phase passes π/2: $n_\\varphi = 1/\\cos\\beta$",
}  # fmt: skip
RESONANCE: Mapping[str, Any] = {
    "color": "#56B4E9", "linewidth": 1.2, "linestyle": (0, (4, 1.5)),
    "label": "phase jumps by π: resonance, N = 0",
}  # fmt: skip
FOLD: Mapping[str, Any] = {
    "color": "#222222", "linestyle": "none", "marker": "D", "markersize": 4.5,
    "markeredgecolor": "white", "label": "orbits begin: a fold",
}  # fmt: skip
"""Lines of the theory's curves, and markers of the orbits' fold."""

OFFSET = 0.15
"""Horizontal distance of the engines' markers from a point, so that none hides another."""


def figure_3(session: Session, betas: Mapping[str, float] = BETAS) -> Any:
    """Draw the stable phase difference: theory, orbits, and the largest errors of engines."""
    from matplotlib.lines import Line2D

    figure, axes = new_figure(len(betas), 2, height=2.2, sharex=True, sharey=True)
    for letter, (name, beta), (by_theory, orbits) in zip("abcd", betas.items(), axes, strict=False):
        true = phase_map(session, beta)
        for panel, phases in ((by_theory, theory_on(true, beta)), (orbits, stable_phases(true))):
            valid = np.ma.masked_invalid(phases)
            mesh = panel.pcolormesh(true.x.values, true.y.values, valid, **CELLS, **PHASE)
        orbits.patch.set(**NONE)
        draw_theory_curves(by_theory, beta)
        if name in STARTS:
            orbits.plot(*fold_curve(session, name), **FOLD)
        title = "Orbits"
        for side, engine in zip((-OFFSET, OFFSET), session.engines, strict=False):
            own = phase_map(session, beta, engine)
            x, y = np.meshgrid(own.x.values + side, own.y.values)
            phase, its = stable_phases(own), look(engine)
            style = {"marker": its.marker, "edgecolors": its.colour, "linewidths": 0.8}
            orbits.scatter(x, y, s=13, c=phase, plotnonfinite=False, **style, **PHASE)
            none = np.isnan(phase)
            orbits.scatter(x[none], y[none], marker="x", s=6, color=its.colour, linewidths=0.7)
            title += f", {engine} to {np.nanmax(difference(own, true)):.1g} rad"
        angle = rf"$\beta$ = {name.replace('pi', 'π')}"
        label(by_theory, "", "$n_\\varphi$", f"({letter}) The theory, {angle}")
        label(orbits, title=title)
    for panel in axes[-1]:
        panel.set_xlabel("$n_x$", fontsize=8)
    low, high = RANGE[0] - 0.3, RANGE[1] + 0.4
    axes[0, 0].set(xlim=(low, high), ylim=(low, high))  # and of all
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
    open_marker: Mapping[str, Any] = {
        "linestyle": "none", "markerfacecolor": "none", "markersize": 4.0
    }  # fmt: skip
    handles = [Line2D([], [], **how) for how in (RESONANCE, TURN, FOLD)]
    for engine in session.engines:
        its, words = look(engine), f"{engine}; cross: none"
        handles.append(
            Line2D([], [], marker=its.marker, color=its.colour, label=words, **open_marker)
        )
    outside_legend(figure, handles, 3)
    return figure


def draw_theory_curves(panel: Any, beta: float) -> None:
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


def difference(own: Map, true: Map) -> Array:
    """Return the distances of an engine's phases from the reference's [rad], on the circle."""
    row, column = true.y.nearest(own.y.values), true.x.nearest(own.x.values)
    same = np.max(abs(own.x.values - true.x.values[column])) < 1e-9
    there = stable_phases(true)[np.ix_(row, column)]
    apart: Array = abs(wrapped(stable_phases(own) - there))
    return apart if same else np.full_like(apart, np.nan)


# Figs. 4-6

START_UP = 0.6
"""Time shown in the left column [s]: the slowest start by the motors' curve takes 0.51 s."""

HIGHEST = 20.0
"""Largest torque that the left column shows [N m]; by (14) it is 148 N m at rest."""

WINDOW = 128
"""Samples, about three turns, whose range and mean the right column shows."""

REDUCED_LINE = {
    "color": "#56B4E9", "linestyle": (0, (6, 1.5, 1, 1.5)), "marker": "",
    "label": "the paper's (11)",
}  # fmt: skip
CURVE_LINE = {
    "color": "#E69F00", "linestyle": (0, (8, 2)), "linewidth": 1.0,
    "label": "reference, motors by Kloss's curve",
}  # fmt: skip

PANELS: tuple[tuple[str, str, Callable[[StartUp], Array]], ...] = (
    ("(a) Rotor 1 speeds up", "speed [rad/s]", lambda run: run.states[5]),
    ("(a) Rotor 2 speeds up", "speed [rad/s]", lambda run: run.states[6]),
    ("(a) How far rotor 1 is ahead of rotor 2", "α [rad]", lambda run: run.phase),
    ("(b) Torque of motor 1", "torque [N m]", lambda run: run.torques[0]),
    ("(b) Torque of motor 2", "torque [N m]", lambda run: run.torques[1]),
    ("(c) The platform swings", "x [mm]", lambda run: 1e3 * run.states[0]),
    ("(c) The rod swings", "$\\varphi_3$ [mrad]", lambda run: 1e3 * run.states[3]),
)
"""Title, unit and quantity of a run."""
NARROW = (0, 1, 3, 4)
"""Panels whose right half leaves out the start, which hides all that follows."""

MARKS: Mapping[int, tuple[tuple[float, ...], ...]] = {
    1: ((153.8,), (153.8,), (-3.10,), (3.08,), (3.08,), (-0.7, 0.7), (-0.7, 0.7)),
    2: ((153.5,), (153.5,), (-0.515,), (3.23,), (3.23,), (-0.25, 0.25), (-20.0, 20.0)),
    3: ((),) * len(PANELS),
}
"""Levels and amplitudes that section 5.2 prints of a case, for each of `PANELS`."""

MARGIN = 0.06
"""Margin around the range of values, as a share of it."""


def simulation_figure(session: Session, case: int) -> Any:
    """Draw the start from rest of a case: its first moments, all of it, and differences."""
    truth, curve = from_rest(session, case), other_start(session, case, CURVE_SECONDS, LARGEST)
    others = {name: from_rest(session, case, name) for name in session.engines}
    figure, axes = new_figure(len(PANELS) + 1, 2, height=1.15, sharex="col")
    early, late = truth.times <= START_UP, truth.times > START_UP
    first, times = curve.times <= START_UP, windows(truth.times).mean(axis=1)
    for i, (title, quantity, line_of) in enumerate(PANELS):
        left, right = axes[i]
        line = line_of(truth)
        broad(left, truth.times[early], line[early], label="reference")
        ends = windows(line).min(axis=1), windows(line).max(axis=1)
        right.fill_between(times, *ends, color="#DDDDDD", lw=0)
        broad(right, times, windows(line).mean(axis=1))
        left.plot(curve.times[first], line_of(curve)[first], **CURVE_LINE)
        for name, run in others.items():
            own = line_of(run)
            engine_line(left, name, run.times[early], own[early])
            engine_line(right, name, windows(run.times).mean(axis=1), windows(own).mean(axis=1))
        label(left, "", quantity, title)
        if "torque" in quantity:
            left.set_ylim(top=HIGHEST)
        if i in NARROW:
            low, high = line[late].min(), line[late].max()
            right.set_ylim(low - MARGIN * (high - low), high + MARGIN * (high - low))
        for height in MARKS[case][i]:
            dotted(right, height, label="printed in the paper")
    for name, run in {**others, REDUCED: from_rest(session, case, REDUCED)}.items():
        apart = abs(run.phase - truth.phase)
        style = REDUCED_LINE if name == REDUCED else {}
        draw_gap(axes[-1, 0], name, truth.times[early], apart[early], **style)
        draw_gap(axes[-1, 1], name, times, windows(apart).max(axis=1), **style)
    label(axes[0, 0], "", PANELS[0][1], f"{PANELS[0][0]}, first {START_UP:g} s")
    label(axes[0, 1], title="All of it: mean and range of 3 turns")
    label(axes[-1, 0], "time [s]", "distance [rad]", "How far α is from the reference's")
    axes[-1, 1].set_xlabel("time [s]", fontsize=8)
    axes[-1, 0].set_xlim(0, START_UP)
    axes[-1, 1].set_xlim(0, truth.times[-1])
    outside_legend(figure, handles_of(axes[0, 0], axes[-1, 0], axes[0, 1]), 3)
    return figure


def windows(values: Array) -> Array:
    """Return values (k, WINDOW); an incomplete last window is dropped."""
    count = len(values) // WINDOW
    return values[: count * WINDOW].reshape(count, WINDOW)
