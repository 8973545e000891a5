r"""The homoclinic limit of `speed_regulator` as a curve: shooting over the crank angle, both ways.

At the least torque of a rotation the crank leaves a saddle phi_s and comes back to it after a turn.
With the kinetic energy over the angle, as in `theory`, this is a boundary value problem::

    dT/dphi = M_m - k y_phi (y - y_0) - c y_phi^2 sqrt(2 T/J),    T(phi_s) = T(phi_s + 2 pi) = 0

It is solved from both ends to the middle, where the two must meet: a smooth function of the torque,
whose root takes a few turns where `theory.least_torque` bisects motions in time. There are two
saddles, near the slider's dead centres; the limit is at that whose orbit gets past the other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ..cost import watched
from .equations import Coefficients, SpeedRegulator, coefficients, inertia, position
from .rest import found_equilibria, static_stiffness
from .theory import saddle_node_torques

LAST = 1 - 1e-6
"""Share of the torque at which a saddle vanishes up to which its orbit is looked for."""


class Accuracy(NamedTuple):
    """How a direction of a saddle is followed: the solver's tolerance, and the start [rad]."""

    tolerance: float
    offset: float


FINE, ROUGH = Accuracy(1e-13, 1e-6), Accuracy(1e-10, 1e-5)


class HomoclinicTorque(NamedTuple):
    """The least torque of a rotation by a homoclinic orbit [N m], and a bound of its error."""

    torque: float
    error: float


def half_turn(saddle: float, way: int, c: Coefficients, accuracy: Accuracy) -> tuple[float, float]:
    """Return T [J] half a turn from a saddle, and the least on the way.

    On its unstable (1) or stable (-1) direction. Where the crank does not come so far, T is
    negative from there on and no damper works, so that it still tells how much is missing.
    """
    at = position(saddle, c, math)
    moment, damping = inertia(at, c), c.damping * at.y_phi**2
    softness = -static_stiffness(saddle, c, math)
    rate = (math.sqrt(damping**2 + 4 * moment * softness) - way * damping) / (2 * moment)

    def slope(phi: float, x: Sequence[float]) -> list[float]:
        at = position(phi, c, math)
        speed = math.sqrt(2 * max(x[0], 0.0) / inertia(at, c))
        spring = c.stiffness * at.y_phi * (at.y - c.rest)
        return [c.torque - spring - c.damping * at.y_phi * at.y_phi * speed]

    begin = saddle + way * accuracy.offset
    run: Any = solve_ivp(
        watched(slope), (begin, saddle + way * math.pi),
        [moment * (rate * accuracy.offset) ** 2 / 2], "DOP853",
        rtol=accuracy.tolerance, atol=1e-3 * accuracy.tolerance,
    )  # fmt: skip
    return float(run.y[0, -1]), float(run.y[0].min())


def connection(p: SpeedRegulator, state: Any, fine: bool) -> tuple[float, float, float]:
    """Return T [J] half a turn from a saddle (phi, phi'), on its two directions, and the least.

    See `reference.scene.PeriodicOrbit`. NaN where the state is no saddle.
    """
    c, phi = coefficients(p), float(state[0])
    if static_stiffness(phi, c, math) >= 0:
        return math.nan, math.nan, math.nan
    accuracy = FINE if fine else ROUGH
    (there, low), (back, least) = (half_turn(phi, way, c, accuracy) for way in (1, -1))
    return there, back, min(low, least)


def orbit_of(p: SpeedRegulator, saddle: str, accuracy: Accuracy) -> float:
    """Return the torque [N m] at which a saddle has a homoclinic orbit, NaN if there is none."""

    def ends(torque: float) -> tuple[tuple[float, float], ...]:
        here = p.replace(torque=torque)
        c, phi = coefficients(here), found_equilibria(here)[saddle]
        return tuple(half_turn(phi, way, c, accuracy) for way in (1, -1))

    def gap(torque: float) -> float:
        (there, _), (back, _) = ends(torque)
        return there - back

    torques = [LAST * value for value in saddle_node_torques(p).values()]
    present = [one for one in torques if saddle in found_equilibria(p.replace(torque=one))]
    if not present or gap(max(present)) < 0:
        return math.nan
    torque = float(brentq(gap, 0.0, max(present), xtol=1e-15, rtol=1e-14))
    return torque if min(least for _, least in ends(torque)) > 0 else math.nan


def homoclinic_limit(p: SpeedRegulator) -> HomoclinicTorque | None:
    """Return the least torque of a rotation, if it is at a homoclinic orbit.

    None where the rotation begins as the saddle vanishes, or where there is no saddle: see
    `theory.saddle_node_torques`. The bound is what a thousandfold tolerance and a tenfold
    distance from the saddle change, infinite where no orbit is found with these.
    """
    rests = found_equilibria(p.replace(torque=0.0))
    c = coefficients(p.replace(torque=0.0))
    for name, phi in rests.items():
        if static_stiffness(phi, c, math) < 0:
            fine, rough = (orbit_of(p, name, accuracy) for accuracy in (FINE, ROUGH))
            if not math.isnan(fine):
                error = math.inf if math.isnan(rough) else abs(fine - rough) + 1e-13 * fine
                return HomoclinicTorque(fine, error)
    return None
