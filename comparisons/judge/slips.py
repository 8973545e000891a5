"""What looks like a mistake: units, signs, turns, times, another start."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ...reference import get_scene
from ...reference.scene import Array
from ..checks.units import EXPLAINED, other_measure
from .comparison import ON_START, Comparison

LOOKED_AT = 2000
"""Samples by which it is judged whether times are off."""

NOTICEABLE = 1e-4
"""Share of a quantity's size below which an error is not looked into: so much makes a file that is
written with few digits."""


def mistakes(comparison: Comparison) -> list[str]:
    """Return in words what would explain the errors: times, units, signs, turns, the start."""
    shifted = late(comparison)
    if shifted:
        return [shifted]
    words, rest, units = [], [], get_scene(comparison.case.scene).units
    for row, name in enumerate(comparison.names):
        values, reference = comparison.values[row], comparison.reference[row]
        said, size = "", float(comparison.size[row])
        if np.all(np.isfinite(values)) and noticeable(comparison, row, values - reference):
            said = other_measure(name, units[name], values, reference, size)
        words.append(said)
        if not said:
            rest.append(row)
    return list(filter(None, [*words, started_elsewhere(comparison, rest)]))


def noticeable(comparison: Comparison, row: int, error: Array) -> bool:
    """Return whether an error is more than what the wrong digits of a file make."""
    return bool(np.max(np.abs(error)) > NOTICEABLE * comparison.size[row])


def started_elsewhere(comparison: Comparison, among: Iterable[int]) -> str:
    """Return where the first row differs from the initial state, if it stands there."""
    span = comparison.times[-1] - comparison.case.start_time
    if comparison.times[0] > comparison.case.start_time + ON_START * span:
        return ""
    states = get_scene(comparison.case.scene).state_names
    apart = [
        f"{comparison.names[row]} = {comparison.values[row, 0]:.6g}, the case with "
        f"{comparison.reference[row, 0]:.6g}"
        for row in among
        if comparison.names[row] in states
        and noticeable(comparison, row, comparison.values[row, :1] - comparison.reference[row, :1])
    ]
    if not apart:
        return ""
    return (
        f"the trajectory starts with {', with '.join(apart)}: another motion, which --state "
        "judges by its own reference"
    )


def late(comparison: Comparison) -> str:
    """Return by how much the times are off, if that explains the errors of the states."""
    scene = get_scene(comparison.case.scene)
    states = [i for i, name in enumerate(comparison.names) if name in scene.state_names]
    every = slice(None, None, max(1, comparison.seen // LOOKED_AT))
    size = comparison.size[states][:, None]
    error = ((comparison.values - comparison.reference)[states] / size)[:, every]
    if not states or not np.all(np.isfinite(error)):
        return ""
    slopes = scene.right_hand_side(comparison.case.parameters)
    rates = slopes(comparison.times[every], comparison.states[:, every])
    rate = rates[[scene.state_names.index(comparison.names[i]) for i in states]] / size
    shift = float(np.sum(rate * error) / np.sum(rate * rate))
    left = np.linalg.norm(error - shift * rate)
    if np.max(np.abs(error)) < NOTICEABLE or left > EXPLAINED * np.linalg.norm(error):
        return ""
    word = "early" if shift > 0 else "late"
    return (
        f"the times look {abs(shift):.3g} s {word}: do they belong to the states of their rows, "
        "before a step or after it?"
    )
