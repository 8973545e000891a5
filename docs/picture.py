"""The picture of the README: two engines whose motions look alike, and how their errors differ.

``python docs/picture.py PATH`` draws it; the suffix of PATH says how (.png, .svg). Both are MuJoCo
with RK4 on ``hula_hoop``; one has both dampers 1 % too weak.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mbcheck.comparisons.reports.drawing import INK, import_pyplot, save_and_close
from mbcheck.reference import get_scene
from mbcheck.reference.scene import Array

from drawn_runs import Curve, reference, simulate

RIGHT, WRONG, GREY = "#0072B2", "#D55E00", "#BBBBBB"
STEPS: Array = np.array([2.0**-n for n in range(6, 12)])


def runs(steps: Array = STEPS) -> dict[str, Any]:
    """Return a motion by the reference and both engines, and the errors of both over steps [s]."""
    case = get_scene("hula_hoop").case("spinning_3hz_60n")
    values = case.parameters
    weak = replace(
        case,
        parameters=replace(
            values,
            damping_ratio=0.99 * values.damping_ratio,
            hinge_damping_ratio=0.99 * values.hinge_damping_ratio,
        ),
    )
    method = Curve("mujoco", "RK4", RIGHT)
    times = np.arange(1, 33) * case.horizon / 32
    truth = reference(case, times)["theta"]
    size = np.abs(truth).max()

    def errors(one: Any) -> Array:
        found = [simulate(one, method, step, times)["theta"] for step in steps]
        return np.array([np.abs(angle - truth).max() / size for angle in found])

    fine = np.arange(0, 257) * case.horizon / 256
    motion = {"reference": reference(case, fine)["theta_dot"]}
    for name, one in (("right", case), ("wrong", weak)):
        motion[name] = simulate(one, method, 2.0**-9, fine)["theta_dot"]
    found = {"right": errors(case), "wrong": errors(weak)}
    return {"times": fine, "motion": motion, "steps": steps, **found}


def draw(path: Path, found: Mapping[str, Any]) -> None:
    """Draw the motions on the left, and the errors over the step on the right."""
    plt = import_pyplot()
    style = {"font.size": 9, "axes.spines.top": False, "axes.spines.right": False}
    with plt.rc_context(style):
        figure, (left, right) = plt.subplots(1, 2, figsize=(8, 5), layout="constrained")
        figure.suptitle("Two simulators, one mechanism, the same step: which one is wrong?")
        times, motion, steps = found["times"], found["motion"], found["steps"]
        left.plot(times, motion["reference"], color=GREY, lw=6, label="reference")
        left.plot(times, motion["right"], color=RIGHT, lw=1.6, label="engine A")
        left.plot(times, motion["wrong"], color=WRONG, lw=1.6, ls=(0, (3, 2)), label="engine B")
        left.set(xlabel="time [s]", ylabel="angular velocity of the rod [rad/s]")
        left.set_title("What a plot shows: no difference", loc="left", fontsize=10)
        left.legend(frameon=False, loc="upper right")
        for name, colour, marker in (("right", RIGHT, "o"), ("wrong", WRONG, "s")):
            right.loglog(steps, found[name], color=colour, marker=marker, lw=1.6)
        right.set_xscale("log", base=2)
        right.set(xlabel="step [s]", ylabel="largest error of the angle, relative")
        right.set_title("What mbcheck shows: B has another model", loc="left", fontsize=10)
        write = {"color": INK, "fontsize": 9}
        right.annotate(
            "B: no step removes the error;\nmbcheck names the part: damper of\n"
            "theta, counted 0.99 times",
            (steps[-1], found["wrong"][-1]), (0.03, 0.86), textcoords="axes fraction",
            va="top", **write,
        )  # fmt: skip
        right.annotate(
            "A: the error falls with\nthe step, at order 4",
            (steps[-1], found["right"][-1]), (0.42, 0.2), textcoords="axes fraction", **write,
        )  # fmt: skip
        save_and_close(figure, path, dots=100)


if __name__ == "__main__":
    draw(Path(sys.argv[1]), runs())
