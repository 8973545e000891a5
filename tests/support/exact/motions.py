"""Long motions of many points at once in extended precision, and what they come to in the end.

Equations and method are those of `orbits`, from d'Alembert's principle. What a motion is called
follows from its last cycle: by its harmonics, and by how it repeats itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .orbits import LONG, PI, Motion, extrapolated, hula_hoop

PER_FORCE = 48
"""Samples in a period of the force."""

WATCHED = 24
"""Last periods of the force that are sampled, and the longest cycle that is looked for twice in."""

REPEATS = 1e-3
"""How closely a motion repeats, in the size of each state."""


def followed(motion: Motion, x: Any, begin: Any, spacing: Any, p: Any, count: int) -> Any:
    """Return states (count + 1, 2 n, k) at ``begin + i spacing``, a step of order 10 apart."""
    states = np.empty((count + 1, *np.shape(x)), dtype=LONG)
    states[0] = x
    for i in range(count):
        states[i + 1] = extrapolated(motion, begin + i * spacing, states[i], spacing, p, 5)
    return states


@dataclass(frozen=True)
class Ending:
    """What `hula_hoop` comes to, by its last cycle.

    Attributes
    ----------
    periods, turns : int
        Of the force and of the free mass in a cycle; 0 periods: it does not repeat.
    f_u, min_speed : float
        See the map's variables.
    """

    periods: int
    turns: int
    f_u: float = np.nan
    min_speed: float = np.nan

    @property
    def motion(self) -> str:
        """The class in the legend of the paper's figures."""
        if self.periods == 0 or abs(self.turns) != self.periods:
            return "red_x"
        shape = "plus" if self.min_speed < 0 else "o"
        return f"{'blue' if abs(self.f_u - 2) < 0.02 else 'cyan'}_{shape}"


def from_rest(p: Any, settling: Any, periods: int, steps: int = 24) -> list[Ending]:
    """Return what points (k,) come to, a whole number of periods after their settling time [s]."""
    span = settling.astype(LONG) + (periods - WATCHED) / p.force_frequency
    count = int(np.ceil(np.max(span * p.force_frequency) * steps))
    x = np.zeros((4, len(settling)), dtype=LONG)
    now = np.zeros(len(settling), dtype=LONG)
    for i in range(count):  # of the whole way nothing is kept
        x = extrapolated(hula_hoop, now + i * span / count, x, span / count, p, 4)
    spacing = 1 / (PER_FORCE * p.force_frequency)
    path = followed(hula_hoop, x, span, spacing, p, WATCHED * PER_FORCE)
    omega = 2 * PI * p.force_frequency
    return [ending(path[..., i].astype(float), float(omega[i])) for i in range(len(settling))]


def ending(path: Any, omega: float) -> Ending:
    """Return what a motion comes to, by its samples (n + 1, 4)."""
    amplitude = np.max(np.hypot(path[:, 0], path[:, 2] / omega)) or 1.0
    size = np.array([amplitude, 1.0, omega * amplitude, omega])
    for periods in range(1, WATCHED // 2 + 1):
        count = periods * PER_FORCE
        change = path[count:] - path[:-count]
        turns = int(np.rint(change[-1, 1] / (2 * np.pi)))
        change = change[-count:] - [0, 2 * np.pi * turns, 0, 0]
        if np.max(np.abs(change) / size) < REPEATS:
            break
    else:
        return Ending(0, 0)
    speed = path[-count:, 3] / omega * (-1 if turns < 0 else 1)
    spectrum = np.fft.rfft(speed)
    least = 16 * np.min(np.fft.irfft(spectrum, 16 * count))
    spectrum[0] = 0
    return Ending(periods, turns, np.argmax(np.abs(spectrum)) / periods, least)
