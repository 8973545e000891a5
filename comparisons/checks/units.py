"""Values in other units than SI, with the opposite sign, or short of whole turns."""

from __future__ import annotations

import math

import numpy as np

from ...reference.scene import Array

EXPLAINED = 0.05
"""A mistake is named where taking it back leaves less than this share of the error."""

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
"""What a quantity is multiplied by in units that are not SI, and their name."""


def other_measure(name: str, unit: str, values: Array, reference: Array, size: float) -> str:
    """Return which other unit, sign or number of turns makes values (k,) of a reference (k,)."""
    error = np.abs(values - reference)
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
