"""Rules about the motion itself: where it starts, what it passes, how errors grow in it."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np

from ....reference.differences import PROBE, probed
from ....reference.scene import Dynamics
from ...engines.run import EPS
from ..truth import MOST_AMPLIFICATION
from .conditions import Statement
from .run import RunConditions

REST = 1e-9
"""How far [rad, m] from a state of rest a run counts as started there."""

LONG, STEPS = 12, 24
"""Periods over which the variational equations are solved to learn how errors grow, and steps in
each."""

PASSING = 1e-2
"""Part of a passage of the singular position that may be lost."""


def dead_centre(run: RunConditions) -> Statement | None:
    """Compare the step with the time in which the mechanism passes its singular position."""
    scene, n = run.scene, len(run.scene.coordinates)
    if "cos_b" not in scene.units:
        return None
    turn = np.zeros((2 * n, 257))
    turn[0] = np.linspace(0, 2 * np.pi, 257)
    outputs = scene.outputs(turn[:n], turn[n:], scene.coefficients(run.case.parameters))
    least = float(np.min(outputs["cos_b"]))
    speed = max(run.start_speeds(scene.rotations_per_period)) or 2 * np.pi / run.period
    p = run.integrator.order
    lost = max((run.step_size * speed / least) ** p / math.factorial(p + 1), EPS / least**2)
    if lost <= PASSING:
        return None
    return Statement(
        f"the rod comes as near to its singular position as cos b = {least:.2g}, and passes it in "
        f"{least / speed:.2g} s, with steps of {run.step_size:.2g} s: about {lost:.2g} of it is "
        "lost each time",
        "shorten the step, or the crank",
    )


def inconsistent_start(run: RunConditions) -> Statement | None:
    """Tell what is declared: a start off the constraints of the scene."""
    if not run.case.inconsistency:
        return None
    offsets = ", ".join(
        f"{name} by {offset:g} {run.scene.units.get(name, '')}".rstrip()
        for name, offset in run.case.inconsistency.items()
    )
    return Statement(
        f"the start is off the scene's constraints on purpose ({offsets}): a soft closure pulls it "
        "together in its own time, and the motion after that is another one"
    )


def unstable_start(run: RunConditions) -> Statement | None:
    """Look for a start that is a state of rest, and from which something grows."""
    (scene, parameters), n = run.equations, len(run.start) // 2
    growing = float(np.max(run.start_and_rests[0].rates.real))
    if np.any(run.start[n:]) or not growing * run.horizon > 1:
        return None
    rate, period = scene.right_hand_side(parameters), float(scene.period(parameters))
    times = [run.case.start_time + part * period for part in (0.0, 0.19, 0.41)]
    moved = max(float(np.max(np.abs(rate(time, run.start)[n:]))) for time in times)
    if moved > REST * growing**2:
        return None
    return Statement(
        f"the start is a state of rest that a disturbance leaves with {growing:.3g} /s: rounding "
        "alone decides where the run goes, and when",
        "start it off by a known amount",
    )


def amplification(run: RunConditions) -> Statement | None:
    """Ask how much an initial error grows within the first `LONG` periods.

    Later than that only the reference can tell.
    """
    case, scene = run.case, run.scene
    if scene.discretisation_coordinates:
        return None
    seen = min(run.horizon, LONG * 2 * np.pi / run.speed)
    start = tuple(scene.state(case.state).tolist())
    growth = _growth(scene, case.parameters, start, (case.start_time, seen), run.speed)
    if growth is None or growth <= MOST_AMPLIFICATION:
        return None
    return Statement(
        f"an initial error grows {growth:.2g} times within {seen:.4g} s: no method can follow this "
        "motion to its end"
    )


@lru_cache(maxsize=256)
def _growth(
    scene: Dynamics,
    parameters: Any,
    state: tuple[float, ...],
    span: tuple[float, float],
    speed: float,
) -> float | None:
    """Return the growth of a small initial error, by RK4 with complex steps: to a few percent.

    Coordinates and rates are measured in what the run has of either, by its fastest frequency.
    None where the motion is too stiff for these steps, so that they do not tell.
    """
    (t, seen), n = span, len(state) // 2
    rate, x = scene.right_hand_side(parameters), probed(np.array(state))
    steps = math.ceil(seen * speed / (2 * np.pi) * STEPS)
    h, largest, marks = seen / steps, np.abs(state), []
    for i in range(steps):
        first = rate(t, x)
        second = rate(t + h / 2, x + h / 2 * first)
        third = rate(t + h / 2, x + h / 2 * second)
        x = x + h / 6 * (first + 2 * (second + third) + rate(t + h, x + h * third))
        t, largest = span[0] + (i + 1) * h, np.maximum(largest, np.abs(x.real[:, 0]))
        if i % STEPS == 0 or i == steps - 1:
            marks.append(x.imag / PROBE)
    size = np.maximum(largest[:n], largest[n:] / speed)
    size = np.where(size > REST, size, 1.0)
    size = np.concatenate([size, size * speed])
    slopes = np.array(marks) * size / size[:, None]
    if not np.all(np.isfinite(slopes)):
        return None
    return float(np.max(np.linalg.norm(slopes, 2, axis=(1, 2))))
