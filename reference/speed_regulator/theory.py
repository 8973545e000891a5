r"""The rotation of `speed_regulator`: formula (21), the limit cycle, and where it begins.

Written with the kinetic energy ``T = J(phi) phi'^2 / 2`` over the crank angle, (17) is of first
order and has lost J'::

    dT/dphi = M_m - k y_phi (y - y_0) - c y_phi^2 omega,    omega = sqrt(2 T / J(phi))

A rotation is a solution with ``T(2 pi) = T(0) > 0``. The derivative of the right-hand side by T
is ``-c y_phi^2 / (J omega)``, so that a turn multiplies small deviations by

    multiplier = exp(-closed integral of c y_phi^2 / (J omega) dphi)

which is Floquet's: over time the exponent is ``-c y_phi^2 / J``, the divergence of the flow less
``J' omega / J``, whose integral over a turn is 0 (Abel, Liouville). It follows that

- the multiplier lies between 0 and 1: every rotation is stable;
- it grows with T, so the map of a turn, ``T(0) -> T(2 pi)``, is increasing and convex, and it
  loses ever more energy as T grows: there is at most one rotation;
- a solution that has gone faster from one turn to the next goes on to the rotation. The
  slowest that can is the unstable manifold of a saddle, where the crank stands still: the
  rotation exists exactly if that of one saddle comes round to it, or if there is no saddle;
- more torque only helps. The rotation therefore dies at one torque: where the last manifold
  fails to come round (a homoclinic orbit), or, where damping is strong, where the saddle
  itself appears (a saddle-node on the circle).

The homoclinic orbit is a boundary value problem, ``T(phi_s) = T(phi_s + 2 pi) = 0``. It is solved
from both ends to the middle, where the two must meet: a smooth function of the torque. There are
two saddles, near the slider's dead centres; the limit is at that whose orbit gets past the other.

The averages of section 3 use another spring reference than (19); since the spring's mean
torque over a turn is 0 for any reference, (20), (21) do not depend on it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ..cost import watched
from ..errors import NoOrbitError
from ..periodic import extremes
from ..scene import Array, OrbitLimit
from .equations import (
    Coefficients,
    SpeedRegulator,
    coefficients,
    inertia,
    position,
)
from .motions import found_equilibria, mean_speed, static_arcs, static_stiffness, static_torque

PRINTED_REMAINDER = 0.000204
"""Mean of t^2 sin^2 b, below (19); holds for lambda = 0.2 alone."""


def printed_mean_speed(p: SpeedRegulator) -> Any:
    """Return the speed [rad/s] of (21) as printed; `mean_speed` has the exact average.

    Raises
    ------
    ParameterError
        If there is gravity.
    """
    p.refuse_gravity("the paper's formula (21)")
    ratio = p.crank_radius / p.rod_length
    return p.torque / (p.damping * p.rod_length**2 * (0.5 * ratio**2 + PRINTED_REMAINDER))


class Accuracy(NamedTuple):
    """Tolerance by which a direction of a saddle is followed, and the distance of its start [rad].

    Up to that distance the direction is taken to be straight.
    """

    tolerance: float
    offset: float


FINE, ROUGH = Accuracy(1e-13, 1e-6), Accuracy(1e-10, 1e-5)
TOLERANCE = 1e-12
"""Relative tolerance of the limit cycle."""

SAMPLES = 1024
"""Samples of a turn, uniform in phi, from which the extremes of the speed are found."""


def _along(phi: float, kinetic: float, c: Coefficients) -> tuple[float, float, float]:
    """Return dT/dphi [N m], the speed [rad/s] and the damper's rate c y_phi^2 / J [1/s].

    A negative T tells how much energy is missing to come so far: there no damper works.
    """
    at = position(phi, c, math)
    moment, damping = inertia(at, c), c.damping * at.y_phi * at.y_phi
    speed = math.sqrt(2 * max(kinetic, 0.0) / moment)
    drive = c.torque - c.stiffness * at.y_phi * (at.y - c.rest)
    return drive - damping * speed, speed, damping / moment


def _integrated(slopes: Any, ends: tuple[float, float], start: list[float], **options: Any) -> Any:
    return solve_ivp(watched(slopes), ends, start, "DOP853", **options)


# --- The limit cycle -----------------------------------------------------------------------


class Rotation(NamedTuple):
    """The limit cycle; speeds in rad/s.

    Attributes
    ----------
    start_speed : float
        At phi = 0.
    mean_speed : float
        2 pi / period.
    sensitivity : float
        `speed_sensitivity`.
    """

    start_speed: float
    period: float
    mean_speed: float
    minimum_speed: float
    maximum_speed: float
    multiplier: float
    sensitivity: float


def speed_sensitivity(speed: Array, multiplier: Any) -> Any:
    """Return the change of the mean speed by one of the turn's energy, relative to the largest.

    Parameters
    ----------
    speed : array (..., nodes)
        At equally spaced crank angles.
    multiplier : array (...)
    """
    mean = 1 / np.mean(1 / speed, axis=-1)
    share = np.max(speed, axis=-1) ** 2 * np.mean(speed**-3, axis=-1) * mean
    return mean * share / (1 - multiplier)


def _turn(start: float, c: Coefficients, tolerance: float, samples: Any = None) -> Any:
    """Integrate T, the time and the multiplier's exponent over the crank angle from 0 to 2 pi."""

    def rates(phi: float, x: Sequence[float]) -> tuple[float, float, float]:
        slope, speed, damping = _along(phi, x[0], c)
        speed = speed or math.nan
        return slope, 1 / speed, -damping / speed

    ends, atol = (0, 2 * math.pi), 0.1 * tolerance * start
    return _integrated(rates, ends, [start, 0.0, 0.0], t_eval=samples, rtol=tolerance, atol=atol)


def _cycle_energy(p: SpeedRegulator, tolerance: float) -> float | None:
    """Return T [J] of the rotation at phi = 0, None where there is none.

    Continued to negative T, without damping there, dT/dphi has exactly one periodic solution: a
    turn loses the more energy the larger T is. It is a rotation if T is positive all along.
    """
    c = coefficients(p)
    high = inertia(position(0.0, c, math), c) * float(mean_speed(p)) ** 2

    def slope(phi: float, x: Sequence[float]) -> float:
        return _along(phi, x[0], c)[0]

    least: Any = lambda phi, x: slope(phi, x)  # noqa: E731, a function that may have attributes
    least.direction = 1

    def turn(start: float) -> Any:
        atol = 1e-4 * tolerance * max(start, 1e-3 * high)
        ends = 0, 2 * math.pi
        return _integrated(
            lambda phi, x: [slope(phi, x)],
            ends,
            [start],
            rtol=0.1 * tolerance,
            atol=atol,
            events=least,
        )

    def gain(start: float) -> float:
        return float(turn(start).y[0, -1] - start)

    while gain(high) > 0:
        high *= 2
    if gain(0.0) <= 0:
        return None
    start = float(brentq(gain, 0.0, high, xtol=1e-15 * high, rtol=1e-14))
    return start if all(x[0] > 0 for x in turn(start).y_events[0]) else None


def rotation(p: SpeedRegulator, tolerance: float = TOLERANCE) -> Rotation:
    """Return the limit cycle, by integration over the crank angle with a relative tolerance.

    Raises
    ------
    NoOrbitError
        If there is none.
    """
    start = _cycle_energy(p, tolerance) if p.damping > 0 and p.torque > 0 else None
    if start is None:
        raise NoOrbitError(
            "speed_regulator has no steady rotation forward with these parameters: it needs "
            "damping, and a torque above least_torque"
        )
    c = coefficients(p)
    phi = np.linspace(0, 2 * math.pi, SAMPLES + 1)
    kinetic, time, exponent = _turn(start, c, tolerance, phi).y
    speed = np.sqrt(2 * kinetic / inertia(position(phi, c), c))
    least, most = extremes(speed[:-1])
    multiplier = math.exp(exponent[-1])
    return Rotation(
        start_speed=float(speed[0]),
        period=float(time[-1]),
        mean_speed=2 * math.pi / float(time[-1]),
        minimum_speed=least,
        maximum_speed=most,
        multiplier=multiplier,
        sensitivity=float(speed_sensitivity(speed[:-1], multiplier)),
    )


def cycle_start(p: SpeedRegulator) -> tuple[Array, float] | None:
    """Return the start (phi, phi') of a period of the limit cycle, and its period [s].

    None in gravity, which the kinetic energy over the crank angle leaves out.

    Raises
    ------
    NoOrbitError
        If there is no limit cycle.
    """
    if p.has_gravity:
        return None
    cycle = rotation(p)
    return np.array([0.0, cycle.start_speed]), cycle.period


# --- Where it begins -----------------------------------------------------------------------


def _direction(saddle: float, way: int, c: Coefficients) -> tuple[float, float]:
    """Return the inertia J [kg m^2] at a saddle, and the rate [1/s] of one of its directions.

    That is the unstable (1) or the stable (-1) one.
    """
    at = position(saddle, c, math)
    moment, damping = inertia(at, c), c.damping * at.y_phi**2
    softness = -static_stiffness(saddle, c, math)
    root = math.sqrt(damping**2 + 4 * moment * softness)
    return moment, 2 * softness / (root + damping) if way > 0 else (root + damping) / (2 * moment)


def _half_turn(saddle: float, way: int, c: Coefficients, accuracy: Accuracy) -> Array:
    """Return T [J] at the steps of half a turn from a saddle, on one of its directions."""
    moment, rate = _direction(saddle, way, c)
    run = _integrated(
        lambda phi, x: [_along(phi, x[0], c)[0]],
        (saddle + way * accuracy.offset, saddle + way * math.pi),
        [moment * (rate * accuracy.offset) ** 2 / 2],
        rtol=accuracy.tolerance, atol=1e-3 * accuracy.tolerance,
    )  # fmt: skip
    return np.asarray(run.y[0])


def rotates(p: SpeedRegulator) -> bool:
    """Return True if there is a steady rotation forward."""
    return p.damping > 0 and p.torque > 0 and _cycle_energy(p, TOLERANCE) is not None


def connection(p: SpeedRegulator, state: Any, fine: bool) -> tuple[float, float, float]:
    """Return T [J] half a turn from a saddle (phi, phi'), on its two directions, and the least.

    By fine tolerances, or coarse ones. NaN where the state is no saddle.
    """
    c, phi = coefficients(p), float(state[0])
    if static_stiffness(phi, c, math) >= 0:
        return math.nan, math.nan, math.nan
    accuracy = FINE if fine else ROUGH
    there, back = (_half_turn(phi, way, c, accuracy) for way in (1, -1))
    return float(there[-1]), float(back[-1]), float(min(there.min(), back.min()))


def saddle_node_torques(p: SpeedRegulator) -> dict[str, float]:
    """Return the torque [N m] at which each stable equilibrium meets a saddle and vanishes.

    The maxima of k y_phi (y - y_0); above the largest the crank can rest nowhere.
    """
    c = coefficients(p)
    roots = {}
    for name, arc in static_arcs(p).items():
        low, high = (static_torque(phi, c, math) for phi in arc)
        if low < high:
            roots[name] = high
    return roots


class Threshold(NamedTuple):
    """The least torque of a rotation [N m], and a bound on its error.

    Attributes
    ----------
    kind : str
        ``homoclinic`` or ``saddle-node on the circle``.
    saddle : str
        Name of the equilibrium that has the homoclinic orbit.
    """

    torque: float
    error: float
    kind: str
    saddle: str = ""


ON_THE_CIRCLE = 1e-6
"""Relative distance from the torque at which a saddle vanishes within which no homoclinic orbit of
it is looked for."""


def orbit_of(p: SpeedRegulator, saddle: str, fine: bool) -> float:
    """Return the torque [N m] at which a saddle has a homoclinic orbit, NaN if there is none."""

    def ends(torque: float) -> tuple[float, float, float]:
        here = p.replace(torque=torque)
        return connection(here, [found_equilibria(here)[saddle]], fine)

    def gap(torque: float) -> float:
        there, back, _ = ends(torque)
        return there - back

    torques = [(1 - ON_THE_CIRCLE) * value for value in saddle_node_torques(p).values()]
    present = [one for one in torques if saddle in found_equilibria(p.replace(torque=one))]
    if not present or gap(max(present)) < 0:
        return math.nan
    torque = float(brentq(gap, 0.0, max(present), xtol=1e-15, rtol=1e-14))
    return torque if ends(torque)[2] > 0 else math.nan


def least_torque(p: SpeedRegulator) -> Threshold:
    """Return the torque at which the rotation begins, whatever ``p.torque`` is.

    The bound of a homoclinic orbit is what a thousandfold tolerance and a tenfold distance from
    the saddle change, infinite where no orbit is found with these.

    Raises
    ------
    NoOrbitError
        Without damping, when no torque has a steady rotation.
    """
    if p.damping == 0:
        raise NoOrbitError("without damping speed_regulator has no steady rotation at any torque")
    still = p.replace(torque=0.0)
    c = coefficients(still)
    for name, phi in found_equilibria(still).items():
        if static_stiffness(phi, c, math) < 0:
            fine, rough = (orbit_of(p, name, accuracy) for accuracy in (True, False))
            if not math.isnan(fine):
                error = math.inf if math.isnan(rough) else abs(fine - rough) + 1e-13 * fine
                return Threshold(fine, error, "homoclinic", name)
    last = max(saddle_node_torques(p).values(), default=0.0)
    return Threshold(last, ON_THE_CIRCLE * last, "saddle-node on the circle")


def torque_limit(p: SpeedRegulator) -> OrbitLimit:
    """Return the least torque of a rotation, and the saddle that it then ends on."""
    limit = least_torque(p) if p.damping > 0 else Threshold(math.inf, math.inf, "none")
    angle = found_equilibria(p.replace(torque=limit.torque))[limit.saddle] if limit.saddle else None
    return OrbitLimit(limit.torque, limit.error, None if angle is None else {"phi": angle})
