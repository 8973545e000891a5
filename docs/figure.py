"""The picture of the README: each scene as a sketch, a telling motion, and what makes it err.

``python -m mbcheck.docs.figure PATH`` draws it; the suffix of PATH says how (.png, .svg).
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mbcheck.comparisons.checks.kinds import elements
from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.comparisons.engines.protocol import Method
from mbcheck.comparisons.engines.registry import get_engine
from mbcheck.comparisons.engines.run import run
from mbcheck.comparisons.engines.setup import Setup
from mbcheck.comparisons.reports.drawing import (
    FAINT,
    INK,
    MARKERS,
    SUFFIXES,
    broad,
    import_pyplot,
    save,
)
from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.errors import MbcheckError, UnknownNameError, UsageError
from mbcheck.reference.scene import Array, Case
from mbcheck.reference.solve.solver import solve

TITLE: Mapping[str, Any] = {"loc": "left", "fontsize": 9}


class Curve(NamedTuple):
    """How a method is drawn, on the first model that it can run unless one is named."""

    engine: str
    method: str
    colour: str
    line: Any = "solid"
    model: str | None = None

    @property
    def label(self) -> str:
        """Return the name in the legend."""
        return f"{ {'mujoco': 'MuJoCo', 'exudyn': 'Exudyn'}[self.engine] } {self.method}"


RK4 = Curve("mujoco", "RK4", "#CC79A7")
RK67 = Curve("exudyn", "RK67", "#0072B2")
ALPHA = Curve("exudyn", "GeneralizedAlpha", "#E69F00", (0, (4, 1.5)))
CURVES = (
    Curve("mujoco", "Euler", "#D55E00"),
    ALPHA,
    Curve("exudyn", "RK33", "#56B4E9", (0, (6, 1, 1.5, 1))),
    RK4,
    Curve("exudyn", "DOPRI5", "#009E73", (0, (4, 1.5))),
    RK67,
)
"""Colours that colour-blind readers tell apart (Okabe and Ito); from the lowest order on."""


class Motion(NamedTuple):
    """A run that is drawn by the reference and by an engine.

    Attributes
    ----------
    case : Case
    curve : Curve
        Who is drawn over the reference.
    step : float
        Its step [s].
    offset : float
        Where its first marker stands, as a share of the distance between two.
    """

    case: Case
    curve: Curve
    step: float
    offset: float = 0.0


def case_of(scene: str, name: str, **changes: Any) -> Case:
    """Return a case of a scene with some of its fields changed."""
    return replace(get_scene(scene).case(name), **changes)


def motions() -> dict[str, tuple[Motion, ...]]:
    """Return what is drawn in the second column, by scene."""
    hoop = case_of("hula_hoop", "point_mass_3hz_60n", horizon=4.0)
    rotors = [
        case_of("rotor_pendulum", name, state=state, horizon=5.0)
        for name, state in (
            ("case_2_settles", {"phi_1": 1.06, "phi_1_dot": 153.8, "phi_2_dot": 153.8}),
            ("case_1_antiphase_settles", {"phi_1": -2.13, "phi_1_dot": 153.8, "phi_2_dot": 153.8}),
            ("case_3_startup", {"phi_1_dot": 153.8, "phi_2_dot": 153.8}),
        )
    ]
    regulator = [
        case_of("speed_regulator", name, horizon=8.0)
        for name in ("settles_to_rotation", "settles_to_rest")
    ]
    hard = RK4._replace(model="connect_hard")
    beam = case_of("rotating_beam", "above_critical")
    of_rods = {n: replace(beam, parameters=beam.parameters.replace(segments=n)) for n in (4, 16)}
    return {
        "hula_hoop": (Motion(hoop, RK4, 2.0**-10), Motion(hoop, RK67, 2.0**-10, 0.5)),
        "rotor_pendulum": tuple(
            Motion(case, curve, 2.0**-12)
            for case, curve in zip(rotors, (RK4, RK67, RK4), strict=True)
        ),
        "rotating_beam": (
            Motion(of_rods[4], RK4._replace(line="dotted"), 2.0**-10),
            Motion(of_rods[16], RK4, 2.0**-10, 0.5),
            Motion(beam, ALPHA._replace(line="solid"), 2.0**-8),
        ),
        "speed_regulator": (
            Motion(regulator[0], hard, 2.0**-10),
            Motion(regulator[1], RK67, 2.0**-8),
        ),
    }


class Panel(NamedTuple):
    """Which error is drawn against the step, for steps of 2^-first to 2^-last s."""

    case: Case
    quantity: str
    first: int
    last: int


class Convergence(NamedTuple):
    """Which first frequencies are drawn against elements, from 2^first to 2^last of them."""

    kinds: Mapping[str, tuple[str, Case]]
    """Chain or element -> engine, and a case that names it"""
    labels: tuple[tuple[str, float, float], ...]
    """What is written into the panel, and where, as shares of it"""
    first: int
    last: int


def panels() -> dict[str, Panel | Convergence]:
    """Return what is drawn in the third column, by scene."""
    names = {
        "chain A": ("mujoco", "steady_4"),
        "chain B": ("mujoco", "steady_4_chain_b"),
        "geometrically exact": ("exudyn", "steady_4_geometrically_exact"),
        "ANCF": ("exudyn", "steady_4"),
    }
    beams = {
        kind: (engine, case_of("rotating_beam", name)) for kind, (engine, name) in names.items()
    }
    labels = (
        ("chain, order 2: A below, B above", 0.36, 0.9),
        ("geometrically exact, order 2", 0.47, 0.365),
        ("ANCF, order 4", 0.24, 0.2),
    )
    return {
        "hula_hoop": Panel(case_of("hula_hoop", "spinning_3hz_60n"), "theta", 8, 12),
        "rotor_pendulum": Panel(
            case_of("rotor_pendulum", "case_2_startup", horizon=0.125), "phi_2", 10, 14
        ),
        "rotating_beam": Convergence(beams, labels, 2, 5),
        "speed_regulator": Panel(case_of("speed_regulator", "rotation"), "phi", 7, 11),
    }


def scenes_figure(path: str | Path) -> None:
    """Draw the scenes: mechanisms, motions by reference and engines, and what errors depend on.

    Parameters
    ----------
    path : str or Path
        Ends in ``.png`` or ``.svg``.

    Raises
    ------
    UsageError
        For another suffix, without matplotlib, or if the file cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise UnknownNameError("kind of picture", path.suffix, SUFFIXES)
    plt = import_pyplot()
    style = {
        "font.size": 8.5,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.edgecolor": INK,
        "svg.hashsalt": "mbcheck",
    }
    with plt.rc_context(style):
        figure, axes = plt.subplots(
            len(SCENES), 3, figsize=(10.5, 10.2), width_ratios=(3.4, 4, 4), layout="constrained"
        )
        for row, scene in zip(axes, SCENES, strict=True):
            row[0].set_title(scene, loc="left", fontsize=11, fontweight="bold")
            SKETCHES[scene](row[0])
            row[0].set_aspect("equal")
            row[0].axis("off")
            MOTIONS[scene](row[1], motions()[scene])
            panel = panels()[scene]
            if isinstance(panel, Convergence):
                draw_convergence(row[2], panel)
                continue
            draw_errors(row[2], panel)
            if scene == "speed_regulator":
                note_model_error(row[2], panel)
        legend(figure, axes[0, 1].get_lines()[0], axes[0, 2].get_lines())
        try:
            save(figure, path)
        except OSError as error:
            raise UsageError(f"cannot write {str(path)!r}: {error.strerror}") from None
        finally:
            plt.close(figure)


# Runs


def reference(case: Case, times: Array, variant: str | None = None) -> Mapping[str, Array]:
    """Return the observables of the reference, or of another of its models."""
    scene = get_scene(case.scene)
    scene = scene.variants[variant] if variant else scene
    truth = solve(scene, case.parameters, scene.state(case.state), times, case.start_time)
    return scene.observe(truth.states, case.parameters)


def simulate(case: Case, curve: Curve, step: float, times: Array) -> Mapping[str, Array]:
    """Return the observables of a method."""
    engine = get_engine(curve.engine)
    method = next(item for item in engine.methods if item.name == curve.method)
    model = curve.model or fitting_model(engine, case, method)
    return run(Setup(engine, case, model, method, step), times).values


def fitting_model(engine: Adapter, case: Case, method: Method) -> str:
    """Return the first of an engine's models that a method can run."""
    models = engine.models(case.scene)
    return next(name for name in models if engine.why_not(case, name, method) is None)


def both(motion: Motion, spacing: float) -> tuple[Array, Any, Any]:
    """Return times [s], and a run by the reference and by the engine."""
    times: Array = spacing * np.arange(1.0, round(motion.case.horizon / spacing) + 1)
    found = simulate(motion.case, motion.curve, motion.step, times)
    return times, reference(motion.case, times), found


# Second column: motions


def overlay(axes: Any, motion: Motion, x: Array, truth: Array, found: Array, every: int) -> None:
    """Draw the reference as a broad line, and the engine's line and markers over it."""
    broad(axes, x, truth)
    thin(axes, motion, x, found, every)


def thin(axes: Any, motion: Motion, x: Array, found: Array, every: int) -> None:
    """Draw what an engine found, with markers."""
    axes.plot(
        x,
        found,
        color=motion.curve.colour,
        linestyle=motion.curve.line,
        linewidth=0.8,
        marker=MARKERS[motion.curve.engine],
        markevery=(round(motion.offset * every), every),
        markersize=3.5,
    )


def note(axes: Any, text: str, place: tuple[float, float], **how: Any) -> None:
    """Write into a panel, at a place in data."""
    axes.text(*place, text, fontsize=8, color=how.pop("color", INK), **how)


def draw_locking(axes: Any, drawn: tuple[Motion, ...]) -> None:
    """Draw the speed of the hula hoop's free mass over time."""
    for motion in drawn:
        times, truth, found = both(motion, 2.0**-7)
        overlay(axes, motion, times, truth["theta_dot"], found["theta_dot"], 32)
    omega = 2 * np.pi * drawn[0].case.parameters.force_frequency
    axes.axhline(omega, color=INK, linewidth=0.8, linestyle=(0, (1, 2)))
    note(axes, f"the force's, {omega:.3g} rad/s", (4.0, 50), ha="right")
    axes.set(xlabel="time [s]", ylabel="theta_dot [rad/s]", xlim=(0, 4), ylim=(-110, 60))
    axes.set_title("from rest, the free mass locks into rotation", **TITLE)


def draw_phases(axes: Any, drawn: tuple[Motion, ...]) -> None:
    """Draw the phase difference of the rotors over time."""
    for motion in drawn:
        times, truth, found = both(motion, 2.0**-6)
        alpha, own = (np.unwrap(run["phi_1"] - run["phi_2"]) for run in (truth, found))
        overlay(axes, motion, times, alpha, own, 32)
    note(axes, "case 3: the rotors lose each other", (0.1, 4.6))
    note(axes, "case 2: in phase, 0.064 rad", (4.95, 0.35), ha="right")
    note(axes, "case 1: in antiphase, $-$3.129 rad", (4.95, -2.75), ha="right")
    axes.set(xlabel="time [s]", ylabel="phi_1 $-$ phi_2 [rad]", xlim=(0, 5))
    axes.set_title("the rotors find a phase, or do not", **TITLE)


def draw_deflections(axes: Any, drawn: tuple[Motion, ...]) -> None:
    """Draw the beam's tip over time, and the model that cannot bear the speed."""
    case, spacing = drawn[0].case, 2.0**-4
    times: Array = spacing * np.arange(1.0, round(case.horizon / spacing) + 1)
    early = times[times <= LEAVES]
    lost = reference(case, early, "zero_order")["tip_deflection"]
    broad(axes, times, reference(case, times)["tip_deflection"])
    for motion in drawn:
        found = simulate(motion.case, motion.curve, motion.step, times)
        thin(axes, motion, times, found["tip_deflection"], 8)
    axes.plot(early, lost, color=INK, linewidth=1, linestyle=(0, (1, 2)))
    note(axes, "without foreshortening: diverges", (2.3, -5.7))
    note(axes, "chain of 4 rods, dotted; of 16, solid", (8, 2.9), ha="right")
    note(axes, "8 ANCF elements: on the reference", (8, -3.6), ha="right")
    axes.set(xlabel="time [s]", ylabel="tip_deflection [m]", xlim=(0, 8), ylim=(-6, 3.8))
    axes.set_title(f"spin-up to {case.parameters.angular_speed:g} rad/s in 3 s", **TITLE)


LEAVES = 2.125
"""Time [s] by which the zero-order model has left the panel."""


def draw_phase_plane(axes: Any, drawn: tuple[Motion, ...]) -> None:
    """Draw the crank's speed over its angle."""
    for motion in drawn:
        _, truth, found = both(motion, 2.0**-8)
        overlay(axes, motion, *folded(truth, found), 128)
    axes.set(xlabel="phi modulo 2 pi [rad]", ylabel="phi_dot [rad/s]")
    axes.set_xticks(np.pi * np.arange(4) / 2, ["0", "pi/2", "pi", "3 pi/2"])
    axes.set_title("two ends of one regulator: rotation, rest", **TITLE)


def folded(truth: Any, found: Any) -> tuple[Array, Array, Array]:
    """Return the crank's angle in one turn, and two speeds, with a gap where a turn ends."""
    angle = (truth["phi"] + np.pi / 2) % (2 * np.pi) - np.pi / 2
    ends = np.flatnonzero(np.abs(np.diff(angle)) > np.pi) + 1
    return tuple(  # type: ignore[return-value]
        np.insert(row, ends, np.nan) for row in (angle, truth["phi_dot"], found["phi_dot"])
    )


MOTIONS: Mapping[str, Callable[[Any, tuple[Motion, ...]], None]] = {
    "hula_hoop": draw_locking,
    "rotor_pendulum": draw_phases,
    "rotating_beam": draw_deflections,
    "speed_regulator": draw_phase_plane,
}


# Third column: errors


def largest_error(panel: Panel, curve: Curve, step: float, times: Array, truth: Array) -> float:
    """Return a method's largest error of a panel's quantity, NaN if it fails."""
    try:
        found = simulate(panel.case, curve, step, times)
    except MbcheckError:  # unstable at this step
        return np.nan
    return float(np.max(np.abs(found[panel.quantity] - truth)))


def errors(panel: Panel, curve: Curve) -> tuple[Array, Array]:
    """Return steps [s] and the largest error of a method with each."""
    steps: Array = 2.0 ** -np.arange(float(panel.first), panel.last + 1)
    times: Array = steps[0] * np.arange(1.0, round(panel.case.horizon / steps[0]) + 1)
    truth = reference(panel.case, times)[panel.quantity]
    return steps, np.array([largest_error(panel, curve, h, times, truth) for h in steps])


def draw_errors(axes: Any, panel: Panel) -> None:
    """Draw the error of each method against its step, both logarithmic."""
    for curve in CURVES:
        axes.loglog(
            *errors(panel, curve),
            color=curve.colour,
            linestyle=curve.line,
            marker=MARKERS[curve.engine],
            markersize=3.5,
            linewidth=1.4,
        )
    ticks = 2.0 ** -np.arange(panel.first, panel.last + 1)
    axes.set_xticks(ticks, [f"2$^{{-{n}}}$" for n in range(panel.first, panel.last + 1)])
    axes.minorticks_off()
    axes.set(xlabel="step [s]", ylabel="largest error [rad]")
    axes.set_title(
        f"error of {panel.quantity} within {panel.case.horizon:.3g} s, by the step", **TITLE
    )


def frequency_errors(engine: str, case: Case, counts: Array) -> Array:
    """Return relative errors of the first frequency against the continuum that is approached."""
    tool = get_engine(engine)
    model = tool.models(case.scene)[0]
    found = []
    for count in counts:
        own = replace(case, parameters=case.parameters.replace(segments=float(count)))
        truth = elements.of_continuum(tool, own, model)[0]
        found.append(abs(elements.of_engine(tool, own, model)[0] / truth - 1))
    return np.array(found)


def draw_convergence(axes: Any, panel: Convergence) -> None:
    """Draw the error of the first frequency against the number of elements."""
    counts: Array = 2.0 ** np.arange(float(panel.first), panel.last + 1)
    for (engine, case), (colour, filled) in zip(panel.kinds.values(), DRAWN, strict=True):
        axes.loglog(
            counts, frequency_errors(engine, case, counts), color=colour, linewidth=1.4,
            marker=MARKERS[engine], markersize=4, markerfacecolor=colour if filled else "white",
        )  # fmt: skip
    for label, share, height in panel.labels:
        axes.text(share, height, label, fontsize=8, transform=axes.transAxes)
    axes.set_xticks(counts, [f"{count:g}" for count in counts])
    axes.minorticks_off()
    axes.set(xlabel="rods or elements", ylabel="relative error")
    speed = next(iter(panel.kinds.values()))[1].parameters.angular_speed
    axes.set_title(f"first frequency at {speed:.3g} rad/s, by elements", **TITLE)


DRAWN = ((INK, True), ("#777777", False), ("#777777", True), (INK, True))
"""Colour of each curve, and whether its markers are filled."""


def note_model_error(axes: Any, panel: Panel) -> None:
    """Draw MuJoCo's hard closure, and name what no step removes."""
    steps, found = errors(panel, RK4._replace(model="connect_hard"))
    axes.plot(
        steps, found, color=RK4.colour, linestyle=(0, (1, 1.5)), marker="s", markersize=3.5,
        linewidth=1.4,
    )  # fmt: skip
    note(axes, "RK4 on connect: model error stays", (steps[-1], 2e-4), va="top")
    note(axes, "on connect_hard", (steps[-1], 6e-8))


def legend(figure: Any, reference_line: Any, lines: Any) -> None:
    """Put one legend of the reference and of all methods below the panels."""
    figure.legend(
        [reference_line, *lines],
        ["reference", *(curve.label for curve in CURVES)],
        loc="outside lower center",
        ncols=1 + len(CURVES),
        frameon=False,
        handlelength=2.4,
        columnspacing=1.4,
    )


# First column: sketches


def line(axes: Any, *points: tuple[float, float], **how: Any) -> None:
    """Draw a polygon line."""
    axes.plot(*np.transpose(points), **{"color": INK, "linewidth": 1.3} | how)


def along(start: Any, end: Any, shape: Array) -> Array:
    """Return points (2, k) given as (length, height) shares of the way from start to end."""
    begin, way = np.asarray(start, float), np.subtract(end, start).astype(float)
    across = np.array([-way[1], way[0]]) / np.hypot(*way)
    return begin[:, None] + way[:, None] * shape[0] + across[:, None] * shape[1]


def spring(axes: Any, start: Any, end: Any, width: float = 0.08) -> None:
    """Draw a spring."""
    share = np.array([0, 0.15, *np.linspace(0.2, 0.8, 7), 0.85, 1])
    height = np.array([0, 0, *(width * (-1.0) ** np.arange(7)), 0, 0])
    axes.plot(*along(start, end, np.array([share, height])), color=INK, linewidth=1.1)


def damper(axes: Any, start: Any, end: Any, width: float = 0.08) -> None:
    """Draw a damper."""
    cup = np.array([[0.75, 0.4, 0.4, 0.75], [width, width, -width, -width]])
    piston = [[0.6, 0.6], [-0.7 * width, 0.7 * width]]
    for shape in ([[0, 0.4], [0, 0]], cup, piston, [[0.6, 1], [0, 0]]):
        axes.plot(*along(start, end, np.array(shape, dtype=float)), color=INK, linewidth=1.1)


def wall(axes: Any, start: Any, end: Any) -> None:
    """Draw the ground as a line, hatched on its right seen from start to end."""
    axes.plot(*np.transpose([start, end]), color=INK, linewidth=1.3)
    length = float(np.hypot(*np.subtract(end, start)))
    for share in np.arange(0.06, length, 0.1) / length:
        tick = np.array([[share, share - 0.07 / length], [0, -0.07]])
        axes.plot(*along(start, end, tick), color=INK, linewidth=0.7)


def box(axes: Any, centre: tuple[float, float], width: float, height: float) -> None:
    """Draw a body as a rectangle."""
    x, y = centre[0] - width / 2, centre[1] - height / 2
    axes.fill(
        [x, x + width, x + width, x], [y, y, y + height, y + height],
        facecolor="#E8E8E8", edgecolor=INK, linewidth=1.3, zorder=2,
    )  # fmt: skip


def disc(axes: Any, at: Any, size: float = 8, colour: str = "#0072B2") -> None:
    """Draw a point mass."""
    axes.plot(*at, "o", color=colour, markersize=size, zorder=4)


def joint(axes: Any, at: Any) -> None:
    """Draw a hinge."""
    axes.plot(*at, "o", color="white", markeredgecolor=INK, markersize=4.5, zorder=5)


def turn(axes: Any, centre: Any, radius: float, start: float, end: float) -> None:
    """Draw an arrow along an arc, from one angle to another [rad]."""
    angles = np.linspace(start, end, 40)
    x, y = polar(centre, radius, angles)
    axes.plot(x[:-2], y[:-2], color=INK, linewidth=0.8)
    arrow(axes, (x[-6], y[-6]), (x[-1], y[-1]))


def orbit(axes: Any, centre: Any, radius: float) -> None:
    """Draw the circle on which a point moves."""
    points = polar(centre, radius, np.linspace(0, 2 * np.pi, 80))
    axes.plot(*points, color=FAINT, linewidth=0.8, linestyle=(0, (3, 2)))


def arrow(axes: Any, start: Any, end: Any) -> None:
    """Draw a straight arrow."""
    style = {"arrowstyle": "-|>", "color": INK, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, start, arrowprops={**style, "mutation_scale": 8})


def frame(axes: Any, middle: float, bottom: float) -> None:
    """Show a sketch in the same frame as the others."""
    axes.set(xlim=(middle - 1.45, middle + 1.45), ylim=(bottom, bottom + 1.75))


def polar(centre: Any, radius: float, angle: Any) -> tuple[Any, Any]:
    """Return the point at a distance and an angle [rad] from a centre."""
    return centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)


def sketch_hula_hoop(axes: Any) -> None:
    """Draw a mass on a spring, shaken, with a free mass on a hinged rod."""
    hinge, length, theta = (0.0, 0.75), 0.55, 0.7
    wall(axes, (-0.35, 0), (0.35, 0))
    spring(axes, (-0.15, 0), (-0.15, 0.6))
    damper(axes, (0.15, 0), (0.15, 0.6))
    box(axes, hinge, 0.6, 0.3)
    orbit(axes, hinge, length)
    mass = polar(hinge, length, theta)
    line(axes, hinge, mass, zorder=3, linewidth=1.8)
    line(axes, hinge, (hinge[0] + length, hinge[1]), linewidth=0.6, zorder=3)
    turn(axes, hinge, 0.4, 0.0, theta)
    joint(axes, hinge)
    disc(axes, mass)
    arrow(axes, (-0.75, 0.6), (-0.75, 0.9))
    arrow(axes, (0, 1.38), (0, 1.05))
    for text, place in (
        ("y", (-0.95, 0.75)),
        ("F cos $\\omega$t", (0.05, 1.36)),
        ("M", (-0.2, 0.72)),
        ("m", (0.48, 1.2)),
        ("theta", (0.46, 0.84)),
    ):
        axes.text(*place, text, va="center", fontsize=8.5, zorder=6)
    frame(axes, 0.0, -0.1)


def sketch_rotor_pendulum(axes: Any) -> None:
    """Draw a sprung platform with a rotor, and a rod whose end carries a second one."""
    hinge, beta = (0.35, 0.4), np.pi / 6
    end = polar(hinge, 0.85, beta)
    wall(axes, (-1.1, 0.05), (-1.1, 0.75))
    spring(axes, (-1.1, 0.57), (-0.35, 0.57))
    damper(axes, (-1.1, 0.23), (-0.35, 0.23))
    box(axes, (0.15, 0.4), 1.0, 0.5)
    wall(axes, (0.8, 0.1), (-0.5, 0.1))
    line(axes, hinge, end, linewidth=2.2, zorder=3)
    line(axes, hinge, (1.25, 0.4), linewidth=0.6, zorder=3)
    turn(axes, hinge, 0.62, 0.0, beta)
    for centre, angle, way in ((hinge, np.pi - 0.9, -1), (end, 1.1, 1)):
        mass = polar(centre, 0.3, angle)
        line(axes, centre, mass, zorder=3)
        disc(axes, mass)
        turn(axes, centre, 0.4, angle + 0.25 * way, angle + 1.1 * way)
    disc(axes, end, 7, INK)
    joint(axes, hinge)
    arrow(axes, (-0.2, -0.12), (0.2, -0.12))
    for text, place in (
        ("x", (0.25, -0.12)),
        ("phi_1", (0.1, 0.93)),
        ("phi_2", (0.84, 1.42)),
        ("beta + phi_3", (1.0, 0.52)),
    ):
        axes.text(*place, text, va="center", fontsize=8.5, zorder=6)
    frame(axes, 0.15, -0.2)


def sketch_rotating_beam(axes: Any) -> None:
    """Draw a hub that turns, and on it a bent beam with a mass at its tip."""
    hub, radius, angle, length, bent = (0.0, 0.0), 0.22, 0.45, 1.5, -0.35
    way = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-way[1], way[0]])
    share = np.linspace(0, 1, 40)
    height = bent * (6 * share**2 - 4 * share**3 + share**4) / 3
    beam = np.outer(radius + length * share, way) + np.outer(height, across)
    straight = (radius + length) * way
    line(axes, hub, (1.3, 0), linewidth=0.6)
    line(axes, hub, tuple(1.12 * straight), linewidth=0.6, linestyle=(0, (6, 2, 1, 2)))
    turn(axes, hub, 0.95, 0.0, angle)
    axes.plot(*beam.T, color=INK, linewidth=2.6, zorder=3)
    axes.fill(*polar(hub, radius, np.linspace(0, 2 * np.pi, 60)), facecolor="#E8E8E8",
        edgecolor=INK, linewidth=1.3, zorder=2)  # fmt: skip
    turn(axes, hub, 0.36, np.pi - 0.9, np.pi + 0.9)
    joint(axes, hub)
    disc(axes, beam[-1])
    arrow(axes, straight, straight + 0.85 * (beam[-1] - straight))
    for text, place in (
        ("J_h", (-0.1, -0.36)),
        ("theta", (1.02, 0.14)),
        ("E, I, rho, A, L", (0.3, -0.2)),
        ("m", (1.8, 0.4)),
        ("tip_deflection", (0.68, 0.86)),
    ):
        axes.text(*place, text, va="center", fontsize=8.5, zorder=6)
    frame(axes, 0.72, -0.65)


def sketch_speed_regulator(axes: Any) -> None:
    """Draw a crank that drives a damped and sprung slider by a rod."""
    origin, phi, length = (0.0, 1.2), 0.9, 0.75
    pin = polar(origin, 0.25, phi)
    foot = (0.0, pin[1] - float(np.sqrt(length**2 - pin[0] ** 2)))
    orbit(axes, origin, 0.25)
    line(axes, origin, (0.45, origin[1]), linewidth=0.6)
    turn(axes, origin, 0.36, 0.0, phi)
    turn(axes, origin, 0.42, np.pi - 0.6, np.pi + 0.6)
    line(axes, origin, pin, linewidth=2.2)
    line(axes, pin, foot, linewidth=1.8, zorder=3)
    box(axes, foot, 0.3, 0.16)
    for x in (-0.19, 0.19):
        line(axes, (x, foot[1] - 0.2), (x, foot[1] + 0.2), linewidth=0.9)
    spring(axes, (-0.08, foot[1] - 0.08), (-0.08, 0), 0.06)
    damper(axes, (0.08, foot[1] - 0.08), (0.08, 0), 0.05)
    wall(axes, (-0.3, 0), (0.3, 0))
    for at in (origin, pin, foot):
        joint(axes, at)
    for text, place in (
        ("M_m", (-0.82, 1.2)),
        ("phi", (0.38, 1.35)),
        ("A", (0.06, 1.52)),
        ("B", (0.25, foot[1])),
    ):
        axes.text(*place, text, va="center", fontsize=8.5, zorder=6)
    frame(axes, 0.0, -0.1)


SKETCHES: Mapping[str, Callable[[Any], None]] = {
    "hula_hoop": sketch_hula_hoop,
    "rotor_pendulum": sketch_rotor_pendulum,
    "rotating_beam": sketch_rotating_beam,
    "speed_regulator": sketch_speed_regulator,
}


def main(arguments: list[str]) -> int:
    """Draw the figure to the one path given; return the exit code."""
    try:
        (path,) = arguments
        scenes_figure(path)
    except ValueError:
        sys.stderr.write("usage: python -m mbcheck.docs.figure PATH\n")
        return 2
    except MbcheckError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
