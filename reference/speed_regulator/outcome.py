"""What a run of `speed_regulator` ends in: rotation or rest."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..scene import Array
from .equations import SpeedRegulator, coefficients, energy
from .rest import found_equilibria, static_stiffness

TURNS_SEEN = 3
STEADY = 0.02
"""Largest relative change of the speed still to come of a rotation that counts as settled."""
RESTING = 1e-3
"""Largest energy of a state of rest, as a share of the depth of its well."""
LAST_PART = 0.1
"""Share of the run in which a state of rest is asked for."""


def outcome(times: Array, values: Mapping[str, Array], p: SpeedRegulator) -> str:
    """Return what a run ends in.

    ``rotation``: three full turns forward without a pause, whose mean speeds, extrapolated
    as a geometric sequence, have settled. ``rest``: through the last tenth of the run, next
    to nothing of the energy that it takes to leave the well of a stable equilibrium. A model
    that stands still anywhere else has not come to rest, and is ``undecided``.
    """
    phi, speed = (np.asarray(values[name], dtype=float) for name in ("phi", "phi_dot"))
    if not (np.all(np.isfinite(phi)) and np.all(np.isfinite(speed)) and len(phi) > 1):
        return "undecided"
    if _rests(np.asarray(times), phi, speed, p):
        return "rest"
    return "rotation" if _rotates(np.asarray(times), phi, speed) else "undecided"


def _rests(times: Array, phi: Array, speed: Array, p: SpeedRegulator) -> bool:
    c = coefficients(p)
    last = times >= times[-1] - LAST_PART * (times[-1] - times[0])
    phi, speed = phi[last], speed[last]

    def free_energy(phi: Any, speed: Any = 0.0) -> Any:
        return energy([phi], [speed], c) - c.torque * phi

    angles = list(found_equilibria(p).values())
    saddles = np.array([angle for angle in angles if static_stiffness(angle, c, math) < 0])
    barriers = np.concatenate([saddles + 2 * np.pi * turn for turn in (-2, -1, 0, 1, 2)])
    for centre in angles:
        if static_stiffness(centre, c, math) <= 0:
            continue
        walls = np.max(barriers[barriers < centre]), np.min(barriers[barriers > centre])
        depth = min(free_energy(wall) for wall in walls) - free_energy(centre)
        near = phi - 2 * np.pi * np.round((phi[-1] - centre) / (2 * np.pi))
        inside = np.all((near > walls[0]) & (near < walls[1]))
        excess = free_energy(near, speed) - free_energy(centre)
        if inside and np.all(excess < RESTING * depth):
            return True
    return False


def _rotates(times: Array, phi: Array, speed: Array) -> bool:
    marks = phi[-1] - 2 * np.pi * np.arange(TURNS_SEEN, -1, -1)
    if phi[0] >= marks[0]:
        return False
    begin = int(np.flatnonzero(phi < marks[0])[-1])
    if np.any(speed[begin:] <= 0) or np.any(np.diff(phi[begin:]) <= 0):
        return False
    passed = np.interp(marks, phi[begin:], times[begin:])
    speeds = 2 * np.pi / np.diff(passed)
    before, now = np.abs(np.diff(speeds))[-2:]
    ratio = now / before if before > now else 0.0
    remaining = now / (1 - ratio)
    return bool(remaining < STEADY * speeds[-1])
