"""How many steps of `rotor_pendulum` maps resolve a turn of its rotors and its springs."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....reference.rotor_pendulum.equations import RotorPendulum, coefficients
from ....reference.scene import Array
from ...engines.registry import REFERENCE
from ..orbit_map import Ints
from ..quantity import Points

NUDGE = 1e-3
"""Relative perturbation, of frequency ratios or of a start [rad, or size of the state], that
a robust class survives."""


def columns(points: Points, *values: Any) -> list[Array]:
    """Return values, each an array (k,) of its own."""
    return [np.array(np.broadcast_to(value, len(points)), dtype=float) for value in values]


RESOLVED = (1.0, 4.0)
"""Longest step times the `fastest_rate`, that of a motion which no rotor drives, of an engine and
of the reference. The 8th-order method damps it then, and is unstable from 5 on."""


def fastest_rate(p: RotorPendulum) -> Any:
    """Bound on natural frequencies and on rates at which motors and dampers slow down [1/s].

    The traces of M^-1 K and M^-1 C, whatever the rotors' angles: as they are free to turn,
    with the determinant at its least.
    """
    c = coefficients(p)

    def trace(platform: Any, rod: Any) -> Any:
        return (platform * c.end_mass + rod / np.square(c.length) * c.mass) / (c.platform * c.rod)

    motor = c.loss / (c.unbalance * c.eccentricity)
    vibration = np.sqrt(trace(c.stiffness, c.rod_stiffness))
    return np.maximum(np.maximum(vibration, motor), trace(c.damping, c.rod_damping))


def step_counts(points: Points, spans: Array, least: tuple[int, int], shortest: int) -> Ints:
    """Return the numbers of equal steps over spans (k,) [s].

    Parameters
    ----------
    points : Points
    spans : array (k,)
    least : (int, int)
        Of an engine and of the reference.
    shortest : int
        The least where ``points.step`` tells the longest step.
    """
    reference = points.engine == REFERENCE
    (fastest,) = columns(points, fastest_rate(points.parameters))
    fewest = least[reference] if points.step is None else shortest
    return points.step_counts(spans, RESOLVED[reference] / np.maximum(fastest, 1e-300), fewest)
