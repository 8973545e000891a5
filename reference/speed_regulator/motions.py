"""The long-term motions of `speed_regulator`: rest, rotation, and in which of them a run ends."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from ..errors import NoOrbitError
from ..periodic import extremes
from ..scene import Array
from .equations import Coefficients, SpeedRegulator, coefficients, energy, inertia, position


def static_torque(phi: Any, c: Coefficients, xp: Any = np) -> Any:
    """Torque k y_phi (y - y_0) that holds the crank against the spring [N m]."""
    at = position(phi, c, xp)
    return c.stiffness * at.y_phi * (at.y - c.rest)


def static_stiffness(phi: Any, c: Coefficients, xp: Any = np) -> Any:
    """Slope of `static_torque` [N m/rad]: an equilibrium is stable where it is positive."""
    at = position(phi, c, xp)
    return c.stiffness * (at.y_phi_phi * (at.y - c.rest) + at.y_phi * at.y_phi)


EQUILIBRIA = ("right", "top", "left", "bottom")
ARC_SAMPLES = 512


def static_arcs(p: SpeedRegulator) -> dict[str, tuple[float, float]]:
    """Return the arc (phi, phi) on which each equilibrium moves as the torque changes.

    Without torque the crank rests where the slider is at y_0 (right and left), and at the
    dead centres of the slider (top and bottom). Along the arc about such a position, up to
    the next extremum of `static_torque` on either side, that torque is monotone; at its
    ends the equilibrium meets its neighbour and both vanish. Where the slider never comes
    to y_0 there is no right and no left.

    Raises
    ------
    NoOrbitError
        With gravity, in which the spring's torque alone holds nothing.
    """
    if p.has_gravity:
        raise NoOrbitError("in gravity speed_regulator has no position of rest that has a name")
    c = coefficients(p)
    if p.stiffness == 0:
        return {}
    sine = ((p.spring_rest - c.length) * (p.spring_rest + c.length) + c.radius**2) / (
        2 * c.radius * (p.spring_rest or -math.inf)
    )  # law of cosines
    anchors = {"top": math.pi / 2, "bottom": 3 * math.pi / 2}
    if p.spring_rest < 0 and abs(sine) < 1:
        anchors |= {"right": math.asin(sine), "left": math.pi - math.asin(sine)}
    order = sorted(anchors, key=lambda name: anchors[name])
    ring = [anchors[order[-1]] - 2 * math.pi, *(anchors[name] for name in order)]
    ends = [_extremum(start, stop, c) for start, stop in pairwise(ring)]
    ends.append(ends[0] + 2 * math.pi)
    arcs = {name: (ends[i], ends[i + 1]) for i, name in enumerate(order)}
    return {name: arcs[name] for name in EQUILIBRIA if name in arcs}


def _extremum(start: float, stop: float, c: Coefficients) -> float:
    """Return the angle of the largest static torque between two of its zeros."""
    grid = np.linspace(start, stop, ARC_SAMPLES)
    i = int(np.argmax(np.abs(static_torque(grid, c))))
    near = grid[max(i - 1, 0)], grid[min(i + 1, ARC_SAMPLES - 1)]
    fit = minimize_scalar(
        lambda phi: -abs(static_torque(phi, c, math)), bounds=near, options={"xatol": 1e-12}
    )
    return float(fit.x)


def equilibrium(name: str, p: SpeedRegulator) -> dict[str, float]:
    """Return the rest position of this name.

    Raises
    ------
    NoOrbitError
        If these parameters have none.
    """
    arcs = static_arcs(p)
    if not arcs:
        raise NoOrbitError(
            "without a spring (stiffness 0) speed_regulator has no position of rest of its own"
        )
    if name not in arcs:
        r, l = p.crank_radius, p.rod_length
        raise NoOrbitError(
            f"speed_regulator has no equilibrium {name!r}: the slider never comes to spring_rest "
            f"{p.spring_rest:.6g} m; put it between {-r - l:.6g} and {r - l:.6g} m"
        )
    angles = found_equilibria(p)
    if name not in angles:
        c = coefficients(p)
        low, high = sorted(static_torque(phi, c, math) for phi in arcs[name])
        raise NoOrbitError(
            f"speed_regulator has no equilibrium {name!r}: the spring holds torques from "
            f"{low:.6g} to {high:.6g} N m there, not {p.torque:.6g} N m"
        )
    return {"phi": angles[name]}


def found_equilibria(p: SpeedRegulator) -> dict[str, float]:
    """Return the crank angle [rad] of each equilibrium that exists."""
    c = coefficients(p)
    angles = {}
    for name, arc in static_arcs(p).items():
        low, high = (static_torque(phi, c, math) - p.torque for phi in arc)
        if low * high < 0:
            balance = brentq(lambda phi: static_torque(phi, c, math) - p.torque, *arc, xtol=1e-15)
            angles[name] = float(balance)
    return angles


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
    """`mean_speed` of a rotation, else 1 rad/s."""
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


TURNS_SEEN = 3
STEADY = 0.02
"""Largest relative change of the speed still to come of a rotation that counts as settled."""
RESTING = 1e-3
"""Largest energy of a state of rest, as a share of the depth of its well."""
LAST_PART = 0.1
"""Final share of the run that a state of rest must cover."""


def outcome(times: Array, values: Mapping[str, Array], p: SpeedRegulator) -> str:
    """Return the long-term motion of a run.

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
