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


def mistakes(found: Comparison) -> list[str]:
    """Return in words what would explain the errors: times, units, signs, turns, the start."""
    shifted = late(found)
    if shifted:
        return [shifted]
    explained = {row: taken_back(found, row) for row in range(len(found.names))}
    rest = [row for row, reason in explained.items() if not reason]
    return list(filter(None, [*explained.values(), started_elsewhere(found, rest)]))


def noticeable(found: Comparison, row: int, error: Array) -> bool:
    """Return whether an error is more than what the wrong digits of a file make."""
    return bool(np.max(np.abs(error)) > NOTICEABLE * found.size[row])


def started_elsewhere(found: Comparison, among: Iterable[int]) -> str:
    """Return where the first row differs from the initial state, if it stands there."""
    span = found.times[-1] - found.case.start_time
    if found.times[0] > found.case.start_time + ON_START * span:
        return ""
    states = get_scene(found.case.scene).state_names
    apart = [
        f"{found.names[row]} = {found.values[row, 0]:.6g}, the case with "
        f"{found.reference[row, 0]:.6g}"
        for row in among
        if found.names[row] in states
        and noticeable(found, row, found.values[row, :1] - found.reference[row, :1])
    ]
    if not apart:
        return ""
    return (
        f"the trajectory starts with {', with '.join(apart)}: another motion, which --state "
        "judges by its own reference"
    )


def taken_back(found: Comparison, row: int) -> str:
    """Return which other unit, sign or number of turns explains an error; empty for none."""
    values, reference, name = found.values[row], found.reference[row], found.names[row]
    if not (np.all(np.isfinite(values)) and noticeable(found, row, values - reference)):
        return ""
    unit = get_scene(found.case.scene).units[name]
    return other_measure(name, unit, values, reference, float(found.size[row]))


def late(found: Comparison) -> str:
    """Return by how much the times are off, if that explains the errors of the states."""
    scene = get_scene(found.case.scene)
    states = [i for i, name in enumerate(found.names) if name in scene.state_names]
    every = slice(None, None, max(1, found.seen // LOOKED_AT))
    size = found.size[states][:, None]
    error = ((found.values - found.reference)[states] / size)[:, every]
    if not states or not np.all(np.isfinite(error)):
        return ""
    slopes = scene.right_hand_side(found.case.parameters)
    rates = slopes(found.times[every], found.states[:, every])
    rate = rates[[scene.state_names.index(found.names[i]) for i in states]] / size
    shift = float(np.sum(rate * error) / np.sum(rate * rate))
    left = np.linalg.norm(error - shift * rate)
    if np.max(np.abs(error)) < NOTICEABLE or left > EXPLAINED * np.linalg.norm(error):
        return ""
    word = "early" if shift > 0 else "late"
    return (
        f"the times look {abs(shift):.3g} s {word}: do they belong to the states of their rows, "
        "before a step or after it?"
    )
