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

from mbcheck.comparisons.reports.drawing import (
    INK,
    SUFFIXES,
    broad,
    import_pyplot,
    look,
    save_and_close,
)
from mbcheck.reference import get_scene
from mbcheck.reference.errors import MbcheckError, UnknownNameError, UsageError
from mbcheck.reference.scene import Array, Case

from drawn_runs import Curve, frequency_errors, model_of, reference, simulate
from sketches import SKETCHES

TITLE: Mapping[str, Any] = {"loc": "left", "fontsize": 9}


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

    def errors(self, curve: Curve) -> tuple[Array, Array]:
        """Return steps [s] and the largest error of a method with each, NaN where it fails."""
        steps: Array = 2.0 ** -np.arange(float(self.first), self.last + 1)
        times: Array = steps[0] * np.arange(1.0, round(self.case.horizon / steps[0]) + 1)
        truth = reference(self.case, times)[self.quantity]

        def largest(step: float) -> float:
            try:
                values = simulate(self.case, curve, step, times)
            except MbcheckError:  # unstable at this step
                return np.nan
            return float(np.max(np.abs(values[self.quantity] - truth)))

        return steps, np.array([largest(step) for step in steps])

    def draw(self, axes: Any) -> None:
        """Draw the error of each method against its step, both logarithmic."""
        for curve in CURVES:
            if model_of(self.case, curve) is None:
                continue
            axes.loglog(
                *self.errors(curve),
                color=curve.colour,
                linestyle=curve.line,
                marker=look(curve.engine).marker,
                markersize=3.5,
                linewidth=1.4,
            )
        powers = np.arange(self.first, self.last + 1)
        axes.set_xticks(2.0**-powers, [f"2$^{{-{n}}}$" for n in powers])
        axes.minorticks_off()
        unit = get_scene(self.case.scene).units[self.quantity]
        axes.set(xlabel="step [s]", ylabel=labelled("largest error", unit))
        title = f"error of {self.quantity} within {self.case.horizon:.3g} s, by the step"
        axes.set_title(title, **TITLE)
        if self.notes_model_error:
            self.note_model_error(axes)

    def note_model_error(self, axes: Any) -> None:
        """Draw MuJoCo's hard closure, and name what no step removes."""
        steps, values = self.errors(RK4._replace(model="connect_hard"))
        axes.plot(
            steps, values, color=RK4.colour, linestyle=(0, (1, 1.5)), marker="s", markersize=3.5,
            linewidth=1.4,
        )  # fmt: skip
        note(axes, "RK4 on connect: model error stays", (steps[-1], 2e-4), va="top")
        note(axes, "on connect_hard", (steps[-1], 6e-8))


class Convergence(NamedTuple):
    """Which first frequencies are drawn against elements, from 2^first to 2^last of them."""

    cases: tuple[tuple[str, Case], ...]
    """Engine, and a case that names a chain or an element"""
    looks: tuple[tuple[str, bool], ...]
    """Colour of each curve, and whether its markers are filled"""
    labels: tuple[tuple[str, float, float], ...]
    """What is written into the panel, and where, as shares of it"""
    first: int
    last: int

    def draw(self, axes: Any) -> None:
        """Draw the error of the first frequency against the number of elements."""
        counts: Array = 2.0 ** np.arange(float(self.first), self.last + 1)
        for (engine, case), (colour, filled) in zip(self.cases, self.looks, strict=True):
            axes.loglog(
                counts, frequency_errors(engine, case, counts), color=colour, linewidth=1.4,
                marker=look(engine).marker, markersize=4,
                markerfacecolor=colour if filled else "white",
            )  # fmt: skip
        for label, share, height in self.labels:
            axes.text(share, height, label, fontsize=8, transform=axes.transAxes)
        axes.set_xticks(counts, [f"{count:g}" for count in counts])
        axes.minorticks_off()
        axes.set(xlabel="rods or elements", ylabel="relative error")
        speed = self.cases[0][1].parameters.angular_speed
        axes.set_title(f"first frequency at {speed:.3g} rad/s, by elements", **TITLE)


class Row(NamedTuple):
    """What is drawn of one scene beside its sketch.

    Attributes
    ----------
    motions : tuple of Motion
    panel : Panel or Convergence
        What errors depend on.
    title : str
        Of the motions.
    curve : callable ``(times, observables) -> (x, y)``
        What is drawn of a motion.
    spacing : float
        Between two samples [s].
    every : int
        Samples from one marker to the next.
    axes : mapping
        Labels and limits.
    notes : tuple of (text, place, side)
        What is written where in the panel, and which side of the text is there.
    dotted : callable ``() -> (x, y)``, optional
        A line to compare with.
    """

    motions: tuple[Motion, ...]
    panel: Panel | Convergence
    title: str
    curve: Callable[[Array, Mapping[str, Array]], tuple[Any, Any]]
    spacing: float
    every: int
    axes: Mapping[str, Any]
    notes: tuple[tuple[str, tuple[float, float], str], ...] = ()
    dotted: Callable[[], tuple[Any, Any]] | None = None

    def draw(self, axes: Any) -> None:
        """Draw the motions: the reference's as broad lines, the engines' thin, with markers."""
        for motion in self.motions:
            case, curve = motion.case, motion.curve
            times: Array = self.spacing * np.arange(1.0, round(case.horizon / self.spacing) + 1)
            broad(axes, *self.curve(times, reference(case, times)), zorder=1)
            axes.plot(
                *self.curve(times, simulate(case, curve, motion.step, times)),
                color=curve.colour,
                linestyle=curve.line,
                linewidth=0.8,
                marker=look(curve.engine).marker,
                markevery=(round(motion.offset * self.every), self.every),
                markersize=3.5,
            )
        if self.dotted is not None:
            axes.plot(*self.dotted(), color=INK, linewidth=1, linestyle=(0, (1, 2)))
        for text, place, side in self.notes:
            note(axes, text, place, ha=side)
        axes.set(**self.axes)
        axes.set_title(self.title, **TITLE)


def rows() -> dict[str, Row]:
    """Return the rows of the picture, by scene."""
    return {
        "hula_hoop": hula_hoop(),
        "rotor_pendulum": rotor_pendulum(),
        "rotating_beam": rotating_beam(),
        "speed_regulator": speed_regulator(),
        "rigid_body": rigid_body(),
        "ball_hoop": ball_hoop(),
        "floating_platform": floating_platform(),
        "floating_beam": floating_beam(),
    }


def hula_hoop() -> Row:
    """Return the speed of the hula hoop's free mass over time."""
    case = case_of("hula_hoop", "point_mass_3hz_60n", horizon=4.0)
    omega = 2 * np.pi * case.parameters.force_frequency
    return Row(
        motions=(Motion(case, RK4, 2.0**-10), Motion(case, RK67, 2.0**-10, 0.5)),
        panel=Panel(case_of("hula_hoop", "spinning_3hz_60n"), "theta", 8, 12),
        title="from rest, the free mass locks into rotation",
        curve=lambda times, run: (times, run["theta_dot"]),
        spacing=2.0**-7,
        every=32,
        axes={
            "xlabel": "time [s]",
            "ylabel": "theta_dot [rad/s]",
            "xlim": (0, 4),
            "ylim": (-110, 60),
        },
        notes=((f"the force's, {omega:.3g} rad/s", (4.0, 50), "right"),),
        dotted=lambda: ((0, 4), (omega, omega)),
    )


def rotor_pendulum() -> Row:
    """Return the phase difference of the rotors over time."""
    turning = {"phi_1_dot": 153.8, "phi_2_dot": 153.8}
    starts = (
        ("case_2_settles", {"phi_1": 1.06, **turning}, RK4),
        ("case_1_antiphase_settles", {"phi_1": -2.13, **turning}, RK67),
        ("case_3_startup", turning, RK4),
    )
    startup = case_of("rotor_pendulum", "case_2_startup", horizon=0.125)
    return Row(
        motions=tuple(
            Motion(case_of("rotor_pendulum", name, state=state, horizon=5.0), curve, 2.0**-12)
            for name, state, curve in starts
        ),
        panel=Panel(startup, "phi_2", 10, 14),
        title="the rotors find a phase, or do not",
        curve=lambda times, run: (times, np.unwrap(run["phi_1"] - run["phi_2"])),
        spacing=2.0**-6,
        every=32,
        axes={"xlabel": "time [s]", "ylabel": "phi_1 $-$ phi_2 [rad]", "xlim": (0, 5)},
        notes=(
            ("case 3: the rotors lose each other", (0.1, 4.6), "left"),
            ("case 2: in phase, 0.064 rad", (4.95, 0.35), "right"),
            ("case 1: in antiphase, $-$3.129 rad", (4.95, -2.75), "right"),
        ),
    )


def rotating_beam() -> Row:
    """Return the beam's tip over time, and the model that cannot bear the speed."""
    beam = case_of("rotating_beam", "above_critical")
    of_rods = {n: replace(beam, parameters=beam.parameters.replace(segments=n)) for n in (4, 16)}
    early = 2.0**-4 * np.arange(1.0, 35.0)  # by then the zero-order model has left the panel
    steady = (
        ("mujoco", "steady_4"),
        ("mujoco", "steady_4_chain_b"),
        ("exudyn", "steady_4_geometrically_exact"),
        ("exudyn", "steady_4"),
    )
    return Row(
        motions=(
            Motion(of_rods[4], RK4._replace(line="dotted"), 2.0**-10),
            Motion(of_rods[16], RK4, 2.0**-10, 0.5),
            Motion(beam, ALPHA._replace(line="solid"), 2.0**-8),
        ),
        panel=Convergence(
            cases=tuple((engine, case_of("rotating_beam", name)) for engine, name in steady),
            looks=((INK, True), ("#777777", False), ("#777777", True), (INK, True)),
            labels=(
                ("chain, order 2: A below, B above", 0.36, 0.9),
                ("geometrically exact, order 2", 0.47, 0.365),
                ("ANCF, order 4", 0.24, 0.2),
            ),
            first=2,
            last=5,
        ),
        title=f"spin-up to {beam.parameters.angular_speed:g} rad/s in 3 s",
        curve=lambda times, run: (times, run["tip_deflection"]),
        spacing=2.0**-4,
        every=8,
        axes={
            "xlabel": "time [s]",
            "ylabel": "tip_deflection [m]",
            "xlim": (0, 8),
            "ylim": (-6, 3.8),
        },
        notes=(
            ("without foreshortening: diverges", (2.3, -5.7), "left"),
            ("chain of 4 rods, dotted; of 16, solid", (8, 2.9), "right"),
            ("8 ANCF elements: on the reference", (8, -3.6), "right"),
        ),
        dotted=lambda: (early, reference(beam, early, "zero_order")["tip_deflection"]),
    )


def speed_regulator() -> Row:
    """Return the crank's speed over its angle."""
    rotation, rest = (
        case_of("speed_regulator", name, horizon=8.0)
        for name in ("settles_to_rotation", "settles_to_rest")
    )
    return Row(
        motions=(
            Motion(rotation, RK4._replace(model="connect_hard"), 2.0**-10),
            Motion(rest, RK67, 2.0**-8),
        ),
        panel=Panel(case_of("speed_regulator", "rotation"), "phi", 7, 11, True),
        title="two ends of one regulator: rotation, rest",
        curve=folded,
        spacing=2.0**-8,
        every=128,
        axes={
            "xlabel": "phi modulo 2 pi [rad]",
            "ylabel": "phi_dot [rad/s]",
            "xticks": np.pi * np.arange(4) / 2,
            "xticklabels": ["0", "pi/2", "pi", "3 pi/2"],
        },
    )


def rigid_body() -> Row:
    """Return the rate about the middle axis, which a free body leaves to turn over."""
    panel = Panel(case_of("rigid_body", "heavy_tumbling", horizon=0.5), "R_xx", 8, 12)
    title = "a free body leaves its middle axis and turns over"
    case = case_of("rigid_body", "intermediate_axis", horizon=12.0)
    return in_space(case, "omega_y", panel, title, 64)


def ball_hoop() -> Row:
    """Return how an axis of the body on the slide turns."""
    panel = Panel(get_scene("ball_hoop").case("weighed"), "R_xx", 8, 12)
    title = "a body on a shaken ball joint, spun out of plane"
    return in_space(replace(panel.case, horizon=2.0), "R_xx", panel, title, 16)


def floating_platform() -> Row:
    """Return how the platform turns, which a rotor and a rod on it drive."""
    panel = Panel(get_scene("floating_platform").case("conservative"), "R_xx", 8, 12)
    title = "a platform afloat, turned by what moves on it"
    return in_space(replace(panel.case, horizon=2.0), "omega_z", panel, title, 16)


def floating_beam() -> Row:
    """Return how the last rod of a chain moves on a hub afloat."""
    panel = Panel(get_scene("floating_beam").case("conservative"), "R_xx", 8, 12)
    title = "a twisted chain of rods on a hub afloat"
    return in_space(replace(panel.case, horizon=2.0), "theta_3", panel, title, 16)


def in_space(case: Case, name: str, panel: Panel, title: str, every: int) -> Row:
    """Return an observable of a motion in space over time."""
    unit = get_scene(case.scene).units[name]
    return Row(
        motions=(Motion(case, RK4, 2.0**-9), Motion(case, ALPHA, 2.0**-9, 0.5)),
        panel=panel,
        title=title,
        curve=lambda times, run: (times, run[name]),
        spacing=2.0**-7,
        every=every,
        axes={"xlabel": "time [s]", "ylabel": labelled(name, unit), "xlim": (0, case.horizon)},
    )


def labelled(name: str, unit: str) -> str:
    """Return a label of an axis."""
    return name if unit == "1" else f"{name} [{unit}]"


def folded(times: Array, run: Mapping[str, Array]) -> tuple[Array, Array]:
    """Return the crank's angle in one turn, and its speed, with a gap where a turn ends."""
    angle = (run["phi"] + np.pi / 2) % (2 * np.pi) - np.pi / 2
    ends = np.flatnonzero(np.abs(np.diff(angle)) > np.pi) + 1
    return np.insert(angle, ends, np.nan), np.insert(run["phi_dot"], ends, np.nan)


def note(axes: Any, text: str, place: tuple[float, float], **how: Any) -> None:
    """Write into a panel, at a place in data."""
    axes.text(*place, text, fontsize=8, color=INK, **how)


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
            len(rows),
            3,
            figsize=(10.5, 2.3 * len(rows)),
            width_ratios=(3.4, 4, 4),
            layout="constrained",
        )
        for (left, middle, right), (scene, row) in zip(axes, rows.items(), strict=True):
            left.set_title(scene, loc="left", fontsize=11, fontweight="bold")
            SKETCHES[scene].draw(left)
            left.set_aspect("equal")
            left.axis("off")
            row.draw(middle)
            row.panel.draw(right)
        legend(figure, axes[0, 1].get_lines()[0], axes[0, 2].get_lines())
        try:
            save_and_close(figure, path)
        except OSError as error:
            raise UsageError(f"cannot write {str(path)!r}: {error.strerror}") from None


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
