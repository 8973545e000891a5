"""The picture of the README: hula_hoop from rest into rotation, and the error of each method.

``python -m mbcheck.comparisons.figure PATH`` draws it; the suffix of PATH says how (.png, .svg).
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..reference import get_scene
from ..reference.errors import MbcheckError, UnknownNameError, UsageError
from ..reference.scene import Array, Case
from ..reference.solver import Solution, solve
from .engine import run
from .engines import get_engine

HORIZON = 4.0
"""Time shown [s]; rotation locks to the force after about 3 s."""

STEP = 2.0**-10
"""The same step for every method [s], so that their errors compare."""

WINDOW = 32
"""Steps within which the largest error is one point of a curve; less shows its zeros."""

INSTANTS = 0.3 + 0.375 * np.arange(10)
"""When the mechanism is drawn [s]; 9/8 of a period apart, so that the turning shows."""

DOTS_PER_INCH, COLOURS = 160, 128
SUFFIXES = (".png", ".svg")


class Curve(NamedTuple):
    """How a method is drawn."""

    engine: str
    method: str
    colour: str
    line: Any


CURVES = (
    Curve("exudyn", "ExplicitEuler", "#777777", "solid"),
    Curve("mujoco", "Euler", "#D55E00", "solid"),
    Curve("exudyn", "GeneralizedAlpha", "#E69F00", (0, (4, 1.5))),
    Curve("exudyn", "RK33", "#56B4E9", (0, (6, 1, 1.5, 1))),
    Curve("mujoco", "RK4", "#CC79A7", "solid"),
    Curve("exudyn", "DOPRI5", "#009E73", (0, (4, 1.5))),
    Curve("exudyn", "RK67", "#0072B2", "solid"),
)
"""Colours that colour-blind readers tell apart (Okabe and Ito); from the least accurate on."""

OVERLAID = {("mujoco", "RK4"): ("s", 0), ("exudyn", "RK67"): ("o", 24)}
"""Methods whose motion is drawn over the reference: marker, offset of the markers."""

INK, FAINT = "#222222", "#BBBBBB"
TITLE: Mapping[str, Any] = {"loc": "left", "fontsize": 10}


def hula_hoop_figure(path: str | Path) -> None:
    """Draw hula_hoop at 3 Hz and 60 N from rest: reference, engines, and their errors.

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
    case = replace(get_scene("hula_hoop").case("point_mass_3hz_60n"), horizon=HORIZON)
    times: Array = case.start_time + np.arange(0.0, round(HORIZON / STEP) + 1) * STEP
    scene = get_scene(case.scene)
    truth = solve(scene, case.parameters, scene.state(case.state), times, case.start_time)
    runs = {(curve.engine, curve.method): simulate(case, curve, times) for curve in CURVES}
    style = {
        "font.size": 9,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.edgecolor": INK,
        "svg.hashsalt": "mbcheck",
    }
    with plt.rc_context(style):
        figure, axes = plt.subplots(
            3, sharex=True, figsize=(8, 7.2), height_ratios=(3, 3, 4), layout="constrained"
        )
        draw_displacement(axes[0], truth)
        draw_speed(axes[1], case, truth, runs)
        draw_errors(axes[2], truth, runs)
        axes[2].set_xlabel("time [s]")
        axes[2].set_xlim(0, HORIZON)
        figure.align_ylabels(axes)
        figure.canvas.draw()  # only then are the axes where they stay
        draw_mechanism(axes[0], case, truth)
        try:
            save(figure, path)
        except OSError as error:
            raise UsageError(f"cannot write {str(path)!r}: {error.strerror}") from None
        finally:
            plt.close(figure)


def save(figure: Any, path: Path) -> None:
    """Write a figure: SVG without its date, PNG with few colours, half the size."""
    if path.suffix.lower() == ".svg":
        figure.savefig(path, metadata={"Date": None})
        return
    from PIL import Image

    buffer = BytesIO()
    figure.savefig(buffer, format="png", dpi=DOTS_PER_INCH)
    Image.open(buffer).convert("RGB").quantize(COLOURS).save(path, optimize=True)


def import_pyplot() -> Any:
    """Return matplotlib's pyplot, with a backend that needs no display.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    try:
        import matplotlib
        import matplotlib.pyplot as plt
    except ImportError:
        raise UsageError("figures need matplotlib; pip install 'mbcheck[plot]'") from None
    matplotlib.use("agg")
    return plt


def simulate(case: Case, curve: Curve, times: Array) -> Mapping[str, Array]:
    """Return the observables of a method on its engine's default model."""
    engine = get_engine(curve.engine)
    method = next(item for item in engine.methods if item.name == curve.method)
    model = engine.models(case.scene)[0]
    return run(engine, case, model, method, STEP, times).values


def draw_displacement(axes: Any, truth: Solution) -> None:
    """Draw the displacement of the main mass."""
    axes.plot(truth.times, truth.states[0], color=FAINT, linewidth=1.2)
    axes.set_ylim(-0.15, 0.15)
    axes.set_ylabel("displacement y [m]")
    axes.set_title(
        "hula_hoop: a force of 60 N at 3 Hz shakes the main mass (square);\n"
        "from rest, the free mass (disc) on its hinged rod swings, and locks into rotation",
        **TITLE,
    )


def draw_mechanism(axes: Any, case: Case, truth: Solution) -> None:
    """Draw the mechanism at a few instants, its slide upright, to the scale of y."""
    (left, low), (right, high) = axes.transData.transform([(0, 0), (1, 1)])
    length = case.parameters.rod_length * np.array([(high - low) / (right - left), 1.0])
    circle = np.linspace(0, 2 * np.pi, 60)
    for i in np.rint(INSTANTS / STEP).astype(int):
        y, theta = truth.states[:2, i]
        hinge = np.array([truth.times[i], y])
        mass = hinge + length * [np.cos(theta), np.sin(theta)]
        path = hinge[:, None] + length[:, None] * [np.cos(circle), np.sin(circle)]
        axes.plot(*path, color=FAINT, linewidth=0.6)
        axes.plot(*np.transpose([hinge, mass]), color=INK, linewidth=1.5)
        axes.plot(*hinge, "s", color=INK, markersize=7)
        axes.plot(*mass, "o", color=CURVES[-1].colour, markersize=6)


def draw_speed(
    axes: Any, case: Case, truth: Solution, runs: Mapping[Any, Mapping[str, Array]]
) -> None:
    """Draw the speed of the free mass by the reference and by two engines."""
    omega = 2 * np.pi * case.parameters.force_frequency
    axes.axhline(omega, color=INK, linewidth=0.8, linestyle=(0, (1, 2)))
    beside(axes, f"the force's, {omega:.3g} rad/s", omega)
    axes.plot(truth.times, truth.states[3], color=FAINT, linewidth=3.5, label="reference")
    for curve in CURVES:
        name = curve.engine, curve.method
        if name in OVERLAID:
            marker, offset = OVERLAID[name]
            axes.plot(
                truth.times,
                runs[name]["theta_dot"],
                color=curve.colour,
                linewidth=0.8,
                marker=marker,
                markevery=(offset, 128),
                markersize=4,
                label=label(curve),
            )
    axes.set_ylim(-110, 60)
    axes.set_ylabel("speed theta_dot [rad/s]")
    axes.set_title("Its speed by the reference and by two engines: no difference to see", **TITLE)
    axes.legend(loc="lower right", frameon=False, ncols=3)


def draw_errors(axes: Any, truth: Solution, runs: Mapping[Any, Mapping[str, Array]]) -> None:
    """Draw how far each method is from the reference, on a logarithmic axis."""
    ends = []
    for curve in CURVES:
        error = np.abs(runs[curve.engine, curve.method]["theta"] - truth.states[1])
        peaks = error[1:].reshape(-1, WINDOW).max(axis=1)
        middles = truth.times[1:].reshape(-1, WINDOW).mean(axis=1)
        axes.semilogy(middles, peaks, color=curve.colour, linestyle=curve.line, linewidth=1.5)
        ends.append(float(np.exp(np.mean(np.log(peaks[-12:])))))
    axes.axhspan(1e-12, truth.error_bound[1], color="#EEEEEE")
    axes.annotate("below the error bound of the reference", (0.03, 2e-12), color="#555555")
    axes.set_ylim(1e-12, 1e3)
    axes.set_yticks([1e-12, 1e-9, 1e-6, 1e-3, 1, 1e3])
    for curve, height in zip(CURVES, spread(ends), strict=True):
        beside(axes, label(curve), height)
    axes.set_ylabel("error of theta [rad]")
    axes.set_title(
        f"The difference: error of each method at the same step, {1e3 * STEP:.3g} ms", **TITLE
    )


def beside(axes: Any, text: str, height: float) -> None:
    """Write text to the right of the axes at a height in data."""
    axes.annotate(
        text,
        (1, height),
        xycoords=("axes fraction", "data"),
        xytext=(5, 0),
        textcoords="offset points",
        va="center",
        annotation_clip=False,
    )


def spread(heights: list[float], gap: float = 8.0) -> list[float]:
    """Return falling heights moved apart to at least a factor, so that labels do not touch."""
    moved: list[float] = []
    for height in heights:
        moved.append(min(height, moved[-1] / gap) if moved else height)
    return moved


def label(curve: Curve) -> str:
    """Return the name of a curve."""
    return f"{ {'mujoco': 'MuJoCo', 'exudyn': 'Exudyn'}[curve.engine] } {curve.method}"


def main(arguments: list[str]) -> int:
    """Draw the figure to the one path given; return the exit code."""
    try:
        (path,) = arguments
        hula_hoop_figure(path)
    except ValueError:
        sys.stderr.write("usage: python -m mbcheck.comparisons.figure PATH\n")
        return 2
    except MbcheckError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
