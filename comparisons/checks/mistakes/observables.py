"""Mistakes in returned observables of a right motion: units, signs, turns, names, times."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.transform import Rotation

from ....reference.body.rotation import ROTATION
from ....reference.quaternions import matrix
from ....reference.scene import Array, Scene

EXPLAINED = 0.05
"""A mistake is named where taking it back leaves less than this share of the error."""

SEEN = 1e-9
"""Relative error below which no mistake is looked for in a run."""

FACTORS = {
    "rad": {180 / math.pi: "degrees", 1 / (2 * math.pi): "turns"},
    "rad/s": {
        180 / math.pi: "degrees per second",
        1 / (2 * math.pi): "turns per second",
        30 / math.pi: "rpm",
    },
    "m": {1e3: "millimetres", 1e2: "centimetres"},
    "m/s": {1e3: "millimetres per second"},
}
"""Factors from SI to other units, and the names of these units."""


@dataclass(frozen=True)
class Observed:
    """Observables of a scene as returned, and as expected.

    Attributes
    ----------
    scene : Scene
    names : tuple of str, k of them
    values, right : array (k, n)
    size : array (k, 1)
        Size to which errors are related.
    """

    scene: Scene
    names: tuple[str, ...]
    values: Array
    right: Array
    size: Array

    @property
    def error(self) -> float:
        """The largest error, relative to the size of each row."""
        return self.away(self.values, self.right)

    def away(self, values: Array, other: Array) -> float:
        """Return the largest difference, relative to the size of each row."""
        return float(np.max(np.abs(values - other) / self.size))


def otherwise_observed(seen: Observed) -> Iterator[str]:
    """Yield the other convention, order or unit that explains all errors."""
    error, measures = seen.error, other_measures(seen).values()
    others = ["; ".join(measures)] if measures and all(measures) else []
    yield from [*conventions(seen, error)] or [*exchanged(seen, error), *others]


def conventions(seen: Observed, error: float) -> Iterator[str]:
    """Yield the other convention of a quaternion that explains all errors."""
    if not seen.scene.quaternions or not {*ROTATION} <= {*seen.names}:
        return
    places = [seen.names.index(name) for name in ROTATION]
    x, y, z, w = Rotation.from_matrix(seen.right[places].T.reshape(-1, 3, 3)).as_quat().T
    name = seen.scene.quaternions[0].name
    for words, other in (
        ("has its scalar part last: it is (w, x, y, z) here", (x, y, z, w)),
        ("is that of the opposite rotation", (w, -x, -y, -z)),
        ("is that of the opposite rotation, its scalar part last", (-x, -y, -z, w)),
    ):
        motion = seen.right.copy()
        motion[places] = np.reshape(matrix(other), (9, -1))
        if seen.away(seen.values, motion) < EXPLAINED * error:
            yield f"the quaternion {name} {words}"


def exchanged(seen: Observed, error: float) -> Iterator[str]:
    """Yield the exchange of observables that explains all errors."""
    scale = np.max(np.abs(seen.right)) or 1.0
    distances = np.max(np.abs(seen.values[:, None] - seen.right[None]), axis=2) / scale
    _, order = linear_sum_assignment(np.log(distances + SEEN))
    moved = [i for i, j in enumerate(order) if i != j]
    values = np.empty_like(seen.values)
    values[order] = seen.values
    if moved and seen.away(values, seen.right) < EXPLAINED * error:
        pairs = [f"{seen.names[i]} is {seen.names[order[i]]}" for i in moved]
        yield f"observables are exchanged: {', '.join(pairs)}"


def other_measures(seen: Observed, least: float = EXPLAINED) -> dict[str, str]:
    """Return the unit, sign or turns that explain each row with an error above a share of its size.

    The text is empty if none of them explains the row.
    """
    every = zip(seen.names, seen.values, seen.right, seen.size[:, 0].tolist(), strict=True)
    return {
        name: other_measure(name, seen.scene.units[name], values, right, size)
        for name, values, right, size in every
        if not np.max(np.abs(values - right)) <= least * size
    }


def other_measure(name: str, unit: str, values: Array, reference: Array, size: float) -> str:
    """Return the other unit, sign or number of turns by which values (k,) fit a reference (k,)."""
    error = np.abs(values - reference)
    if not np.all(np.isfinite(error)):
        return ""
    for factor, word in [*FACTORS.get(unit, {}).items(), (-1.0, "")]:
        away = np.max(np.abs(values - factor * reference))
        if away < EXPLAINED * min(np.max(error), abs(factor) * size):
            if not word:
                return f"{name} fits with the opposite sign"
            return f"{name} fits if it is in {word} ({factor:.4g} x {unit}): convert it to {unit}"
    turns = np.abs(np.remainder(error + np.pi, 2 * np.pi) - np.pi)
    if unit == "rad" and np.max(error) > 6 and np.max(turns) < EXPLAINED:
        return f"{name} fits up to whole turns: it must count them (numpy.unwrap)"
    return ""


def limited(seen: Observed) -> Iterator[str]:
    """Yield the rates that never exceed a round number, of two digits, which right ones exceed."""
    for name, one, right in zip(seen.names, np.abs(seen.values), np.abs(seen.right), strict=True):
        most = float(np.max(one))
        limit = one > most * (1 - SEEN)
        whole = abs(most - float(f"{most:.2g}")) <= SEEN * most < SEEN * np.max(right)
        if name.endswith("_dot") and whole and np.ptp(right[limit]) > SEEN * most > 0:
            yield f"{name} never exceeds {most:.3g} {seen.scene.units[name]}: it is clamped there"


def late(seen: Observed, rates: Array, least: float) -> str:
    """Return the shift of times that explains the errors of all states; empty if none does.

    Parameters
    ----------
    seen : Observed
        Rows that are no states of the scene do not count.
    rates : array (2 n, n_t)
        Of the states of the scene.
    least : float
        Relative error that needs no explanation.
    """
    names = seen.scene.state_names
    states = [i for i, name in enumerate(seen.names) if name in names]
    error = ((seen.values - seen.right) / seen.size)[states]
    if not states or not np.all(np.isfinite(error)) or np.max(np.abs(error)) < least:
        return ""
    rate = rates[[names.index(seen.names[i]) for i in states]] / seen.size[states]
    shift = float(np.sum(rate * error) / np.sum(rate * rate))
    if np.linalg.norm(error - shift * rate) > EXPLAINED * np.linalg.norm(error):
        return ""
    word = "early" if shift > 0 else "late"
    return (
        f"the times look {abs(shift):.3g} s {word}: do they belong to the states of their rows, "
        "before a step or after it?"
    )
