"""What the search for the rotation of `speed_regulator` starts from; what it is measured by."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..periodic import extremes
from ..scene import Array
from .equations import Coefficients, SpeedRegulator, coefficients, inertia, position


def mean_speed(p: SpeedRegulator) -> Any:
    """Speed [rad/s] at which the damper takes the motor's power: (21) with its exact average.

    The mean of y_phi^2 over a turn is ``l^2 (1 - sqrt(1 - lambda^2))``, of which the printed
    ``l^2 (0.5 lambda^2 + 0.000204)`` is the value near lambda = 0.2. Infinite without damping.
    """
    ratio = p.crank_radius / p.rod_length
    square = p.crank_radius**2 / (1 + np.sqrt((1 - ratio) * (1 + ratio)))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.divide(p.torque, p.damping * square)


def _guessed_speed(p: SpeedRegulator) -> Any:
    """`mean_speed` where that is a rotation, else 1 rad/s."""
    speed = mean_speed(p)
    return np.where(np.isfinite(speed) & (speed > 0), speed, 1.0)


def period(p: SpeedRegulator) -> Any:
    """Return the guess 2 pi / omega, omega from (21) [s]."""
    return 2 * np.pi / _guessed_speed(p)


GUESSED_HEADROOM = (0.02, 0.3, 1.0)
"""Kinetic energy at the hardest point of a turn, as shares of the spring's barrier."""


def orbit_guesses(p: SpeedRegulator) -> list[Array]:
    """States (phi = 0, phi') that may be near the rotation.

    The speed of (21), first as it is, then with the kinetic energy shared with the spring;
    and speeds that just clear the spring's barrier, as the slow rotations do.

    Returns
    -------
    list of arrays of shape (2, ...)
    """
    c = coefficients(p)
    speed = _guessed_speed(p)
    phi = np.linspace(0, 2 * np.pi, 64, endpoint=False).reshape(-1, *(1,) * np.ndim(speed))
    spring = c.stiffness / 2 * (position(phi, c).y - c.rest) ** 2
    climb = np.max(spring - c.torque * phi, axis=0) - spring[0]
    shared = np.mean(spring, axis=0) - spring[0]
    mass = inertia(position(0.0, c), c)
    squares = [speed**2, np.maximum(speed**2 + 2 * shared / mass, 0.01 * speed**2)]
    squares += [2 * climb * (1 + share) / mass for share in GUESSED_HEADROOM]
    return [
        np.array(np.broadcast_arrays(0.0, np.sqrt(square)), dtype=float)
        for square in np.broadcast_arrays(*squares)
    ]


ORBIT_UNITS = {
    "mean_speed": "rad/s",
    "minimum_speed": "rad/s",
    "maximum_speed": "rad/s",
    "irregularity": "1",
    "damper_work_ratio": "1",
}


def orbit_quantities(states: Array, c: Coefficients) -> dict[str, float]:
    """Return the speed's mean and extremes, and the damper's share of the motor's work."""
    speed = states[1]
    mean = float(np.mean(speed))  # over time: 2 pi / T
    low, high = extremes(speed)
    power = c.damping * np.mean((position(states[0], c).y_phi * speed) ** 2)
    motor = c.torque * mean
    return {
        "mean_speed": mean,
        "minimum_speed": low,
        "maximum_speed": high,
        "irregularity": (high - low) / mean,
        "damper_work_ratio": float(power / motor) if motor else math.nan,
    }
