"""Where the crank of `speed_regulator` rests: the spring's torque and its extrema."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from ..errors import NoOrbitError
from .equations import Coefficients, SpeedRegulator, coefficients, position


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
    """Where between two of its zeros the static torque is largest in magnitude."""
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
    c = coefficients(p)
    low, high = sorted(static_torque(phi, c, math) for phi in arcs[name])
    if not low < p.torque < high:
        raise NoOrbitError(
            f"speed_regulator has no equilibrium {name!r}: the spring holds torques from "
            f"{low:.6g} to {high:.6g} N m there, not {p.torque:.6g} N m"
        )
    return {"phi": _balanced(arcs[name], c)}


def _balanced(arc: tuple[float, float], c: Coefficients) -> float:
    return float(brentq(lambda phi: static_torque(phi, c, math) - c.torque, *arc, xtol=1e-15))


def found_equilibria(p: SpeedRegulator) -> dict[str, float]:
    """Return the crank angle [rad] of each equilibrium that exists."""
    c = coefficients(p)
    angles = {}
    for name, arc in static_arcs(p).items():
        low, high = sorted(static_torque(phi, c, math) for phi in arc)
        if low < p.torque < high:
            angles[name] = _balanced(arc, c)
    return angles
