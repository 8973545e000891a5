"""The picture of the README: each scene as a sketch, a telling motion, and what makes it err.

``python docs/figure.py PATH`` draws it; the suffix of PATH says how (.png, .svg).
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
    INK,
    SUFFIXES,
    broad,
    import_pyplot,
    look,
    save,
)
from mbcheck.reference import SCENES, get_scene
from mbcheck.reference.errors import MbcheckError, UnknownNameError, UsageError
from mbcheck.reference.scene import Array, Case
from mbcheck.reference.solve.single import solve

from sketches import SKETCHES

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


class Panel(NamedTuple):
    """Which error is drawn against the step, for steps of 2^-first to 2^-last s."""

    case: Case
    quantity: str
    first: int
    last: int
    notes_model_error: bool = False


class Convergence(NamedTuple):
    """Which first frequencies are drawn against elements, from 2^first to 2^last of them."""

    kinds: Mapping[str, tuple[str, Case]]
    """Chain or element -> engine, and a case that names it"""
    labels: tuple[tuple[str, float, float], ...]
    """What is written into the panel, and where, as shares of it"""
    first: int
    last: int


class Row(NamedTuple):
    """What is drawn of one scene beside its sketch."""

    draw: Callable[[Any, tuple[Motion, ...]], None]
    """Draws the motions"""
    motions: tuple[Motion, ...]
    panel: Panel | Convergence


def rows() -> dict[str, Row]:
    """Return the rows of the picture, by scene."""
    startup = case_of("rotor_pendulum", "case_2_startup", horizon=0.125)
    panels: dict[str, Panel | Convergence] = {
        "hula_hoop": Panel(case_of("hula_hoop", "spinning_3hz_60n"), "theta", 8, 12),
        "rotor_pendulum": Panel(startup, "phi_2", 10, 14),
        "rotating_beam": convergence(),
        "speed_regulator": Panel(case_of("speed_regulator", "rotation"), "phi", 7, 11, True),
    }
    draw = {
        "hula_hoop": draw_locking,
        "rotor_pendulum": draw_phases,
        "rotating_beam": draw_deflections,
        "speed_regulator": draw_phase_plane,
    }
    return {name: Row(draw[name], motions()[name], panels[name]) for name in SCENES}


def convergence() -> Convergence:
    """Return what is drawn of the beam's first frequency."""
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
    return Convergence(beams, labels, 2, 5)


def motions() -> dict[str, tuple[Motion, ...]]:
    """Return the motions of the second column, by scene."""
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


def scenes_figure(path: str | Path, rows: Mapping[str, Row]) -> None:
    """Draw the scenes: mechanisms, motions by reference and engines, and what errors depend on.

    Parameters
    ----------
    path : str or Path
        Ends in ``.png`` or ``.svg``.
    rows : Mapping
        What is drawn of each scene.

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
            len(rows), 3, figsize=(10.5, 10.2), width_ratios=(3.4, 4, 4), layout="constrained"
        )
        for (left, middle, right), (scene, row) in zip(axes, rows.items(), strict=True):
            left.set_title(scene, loc="left", fontsize=11, fontweight="bold")
            SKETCHES[scene].draw(left)
            left.set_aspect("equal")
            left.axis("off")
            row.draw(middle, row.motions)
            if isinstance(row.panel, Convergence):
                draw_convergence(right, row.panel)
            else:
                draw_errors(right, row.panel)
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
    whole = get_scene(case.scene)
    scene = whole.variants[variant] if variant else whole
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
    by_engine = simulate(motion.case, motion.curve, motion.step, times)
    return times, reference(motion.case, times), by_engine


# Second column: motions


def overlay(axes: Any, motion: Motion, x: Array, truth: Array, values: Array, every: int) -> None:
    """Draw the reference as a broad line, and the engine's line and markers over it."""
    broad(axes, x, truth)
    thin(axes, motion, x, values, every)


def thin(axes: Any, motion: Motion, x: Array, values: Array, every: int) -> None:
    """Draw the values of an engine, with markers."""
    axes.plot(
        x,
        values,
        color=motion.curve.colour,
        linestyle=motion.curve.line,
        linewidth=0.8,
        marker=look(motion.curve.engine).marker,
        markevery=(round(motion.offset * every), every),
        markersize=3.5,
    )


def note(axes: Any, text: str, place: tuple[float, float], **how: Any) -> None:
    """Write into a panel, at a place in data."""
    axes.text(*place, text, fontsize=8, color=how.pop("color", INK), **how)


def draw_locking(axes: Any, drawn: tuple[Motion, ...]) -> None:
    """Draw the speed of the hula hoop's free mass over time."""
    for motion in drawn:
        times, truth, values = both(motion, 2.0**-7)
        overlay(axes, motion, times, truth["theta_dot"], values["theta_dot"], 32)
    omega = 2 * np.pi * drawn[0].case.parameters.force_frequency
    axes.axhline(omega, color=INK, linewidth=0.8, linestyle=(0, (1, 2)))
    note(axes, f"the force's, {omega:.3g} rad/s", (4.0, 50), ha="right")
    axes.set(xlabel="time [s]", ylabel="theta_dot [rad/s]", xlim=(0, 4), ylim=(-110, 60))
    axes.set_title("from rest, the free mass locks into rotation", **TITLE)


def draw_phases(axes: Any, drawn: tuple[Motion, ...]) -> None:
    """Draw the phase difference of the rotors over time."""
    for motion in drawn:
        times, truth, values = both(motion, 2.0**-6)
        alpha, own = (np.unwrap(run["phi_1"] - run["phi_2"]) for run in (truth, values))
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
        values = simulate(motion.case, motion.curve, motion.step, times)
        thin(axes, motion, times, values["tip_deflection"], 8)
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
        _, truth, values = both(motion, 2.0**-8)
        overlay(axes, motion, *folded(truth, values), 128)
    axes.set(xlabel="phi modulo 2 pi [rad]", ylabel="phi_dot [rad/s]")
    axes.set_xticks(np.pi * np.arange(4) / 2, ["0", "pi/2", "pi", "3 pi/2"])
    axes.set_title("two ends of one regulator: rotation, rest", **TITLE)


def folded(truth: Any, values: Any) -> tuple[Array, Array, Array]:
    """Return the crank's angle in one turn, and two speeds, with a gap where a turn ends."""
    angle = (truth["phi"] + np.pi / 2) % (2 * np.pi) - np.pi / 2
    ends = np.flatnonzero(np.abs(np.diff(angle)) > np.pi) + 1
    return tuple(  # type: ignore[return-value]
        np.insert(row, ends, np.nan) for row in (angle, truth["phi_dot"], values["phi_dot"])
    )


# Third column: errors


def largest_error(panel: Panel, curve: Curve, step: float, times: Array, truth: Array) -> float:
    """Return a method's largest error of a panel's quantity, NaN if it fails."""
    try:
        values = simulate(panel.case, curve, step, times)
    except MbcheckError:  # unstable at this step
        return np.nan
    return float(np.max(np.abs(values[panel.quantity] - truth)))


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
            marker=look(curve.engine).marker,
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
    if panel.notes_model_error:
        note_model_error(axes, panel)


def frequency_errors(engine: str, case: Case, counts: Array) -> Array:
    """Return relative errors of the first frequency against the continuum that is approached."""
    tool = get_engine(engine)
    model = tool.models(case.scene)[0]
    errors = []
    for count in counts:
        own = replace(case, parameters=case.parameters.replace(segments=float(count)))
        truth = elements.of_continuum(Setup(tool, own, model))[0]
        errors.append(abs(elements.of_engine(Setup(tool, own, model))[0] / truth - 1))
    return np.array(errors)


def draw_convergence(axes: Any, panel: Convergence) -> None:
    """Draw the error of the first frequency against the number of elements."""
    counts: Array = 2.0 ** np.arange(float(panel.first), panel.last + 1)
    for (engine, case), (colour, filled) in zip(panel.kinds.values(), DRAWN, strict=True):
        axes.loglog(
            counts, frequency_errors(engine, case, counts), color=colour, linewidth=1.4,
            marker=look(engine).marker, markersize=4, markerfacecolor=colour if filled else "white",
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
    steps, values = errors(panel, RK4._replace(model="connect_hard"))
    axes.plot(
        steps, values, color=RK4.colour, linestyle=(0, (1, 1.5)), marker="s", markersize=3.5,
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


def main(arguments: list[str]) -> int:
    """Draw the figure to the one path given; return the exit code."""
    try:
        (path,) = arguments
        scenes_figure(path, rows())
    except ValueError:
        sys.stderr.write("usage: python docs/figure.py PATH\n")
        return 2
    except MbcheckError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
