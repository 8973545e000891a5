"""Rests and rotations of `speed_regulator` by theory, over the crank angle, all points at once.

The kinetic energy is integrated over the crank angle where halved steps agree; what lies too near
a homoclinic torque is left to `reference.speed_regulator.theory`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....reference.errors import NoOrbitError
from ....reference.scene import Array, coefficients_at
from ....reference.solve.rk8 import rk8_steps
from ....reference.speed_regulator import theory
from ....reference.speed_regulator.equations import (
    Coefficients,
    SpeedRegulator,
    coefficients,
    inertia,
    position,
)
from ....reference.speed_regulator.motions import (
    mean_speed,
    static_arcs,
    static_stiffness,
    static_torque,
)
from ..bounds import ROUNDING, difference
from ..quantity import Points, QuantityValues

Flags = NDArray[np.bool_]

REGIMES = ("rest", "coexistence", "rotation", "none", "undecided")
"""As `theory.regime` names them; coexistence is of rest and rotation. Undecided: slower to
settle than was waited for."""

TURN = 2 * np.pi


class CycleOptions(NamedTuple):
    """How limit cycles are solved for over the crank angle.

    Attributes
    ----------
    shift : float
        Of a perturbed torque, and of a perturbed speed at the start of a run, relative.
    escape : tuple[float, float]
        Between these distances from a saddle [rad] the steps grow as the distance does.
    escape_steps : int
        Steps there.
    turn_steps : int
        Steps over the rest of a turn.
    clear : float
        Energy left after a turn, over the largest on its way, that tells it from none.
    bisections : int
        Of an arc on which a saddle lies.
    nodes : tuple[int, ...]
        Of the collocation of a limit cycle; what the last do not resolve, `theory` solves.
    tolerances : tuple[float, float]
        Of `theory` there: the second tells the error of the first.
    max_iterations : int
        Of Newton's method.
    first_room : float
        Least kinetic energy of the first guess, over what the spring takes of its mean.
    tolerance : float
        Relative change by Newton's last step.
    resolved : float
        Largest of the highest harmonics of log T, relative.
    """

    shift: float = 1e-3
    escape: tuple[float, float] = (1e-4, 0.3)
    escape_steps: int = 64
    turn_steps: int = 96
    clear: float = 1e-6
    bisections: int = 60
    nodes: tuple[int, ...] = (64, 256, 1024)
    tolerances: tuple[float, float] = (1e-12, 1e-9)
    max_iterations: int = 16
    first_room: float = 1.05
    tolerance: float = 1e-10
    resolved: float = 1e-11


OPTIONS = CycleOptions()


class Turn(NamedTuple):
    """One turn over the crank angle, arrays over rows.

    Attributes
    ----------
    energy : array (k,)
        Kinetic energy at its end [J]; negative if the motion lacks so much to get there.
    lowest, largest : array (k,)
        Least and largest on the way.
    time : array (k,)
        [s]
    exponent : array (k,)
        Logarithm of what a small change of energy is multiplied by.
    """

    energy: Array
    lowest: Array
    largest: Array
    time: Array
    exponent: Array


def rates(c: Coefficients) -> Callable[[Any, Any], Any]:
    """Return d(T, time, exponent)/dphi of the equation of motion over the crank angle."""

    def slopes(phi: Any, x: Any) -> Any:
        at = position(phi, c)
        moment = inertia(at, c)
        speed = np.sqrt(2 * np.maximum(x[0], 0) / moment)
        damping = c.damping * at.y_phi**2
        drive = c.torque - c.stiffness * at.y_phi * (at.y - c.rest)
        return np.stack([drive - damping * speed, 1 / speed, -damping / (moment * speed)])

    return slopes


def from_saddle(saddle: Array, c: Coefficients, share: int) -> Turn:
    """Follow the unstable manifolds of saddles (k,) to where they stand a turn later.

    ``share`` divides the numbers of steps.
    """
    at = position(saddle, c)
    moment, damping = inertia(at, c), c.damping * at.y_phi**2
    softness = -static_stiffness(saddle, c)
    rate = 2 * softness / (damping + np.sqrt(damping**2 + 4 * moment * softness))
    start = np.stack([moment * (rate * OPTIONS.escape[0]) ** 2 / 2, 0 * saddle, 0 * saddle])
    slopes = rates(c)

    def stretched(stretch: Any, x: Any) -> Any:
        away = OPTIONS.escape[0] * np.exp(stretch)
        return away * slopes(saddle + away, x)

    span = np.log(OPTIONS.escape[1] / OPTIONS.escape[0])
    first = walked(stretched, start, 0.0, span, OPTIONS.escape_steps // share)
    second = walked(
        slopes,
        first[0],
        saddle + OPTIONS.escape[1],
        saddle + TURN - OPTIONS.escape[1],
        OPTIONS.turn_steps // share,
    )

    def gathered(stretch: Any, x: Any) -> Any:
        left = OPTIONS.escape[1] * np.exp(-stretch)
        return left * slopes(saddle + TURN - left, x)

    third = walked(gathered, second[0], 0.0, span, OPTIONS.escape_steps // share)
    lowest = np.minimum(second[1], third[1])
    largest = np.maximum.reduce([first[2], second[2], third[2]])
    return Turn(third[0][0], lowest, largest, third[0][1], third[0][2])


def walked(slopes: Any, x: Array, begin: Any, end: Any, steps: int) -> tuple[Array, Array, Array]:
    """Return where ``x`` (3, k) gets to, and the least and largest energy after any step."""
    low = high = x[0]
    width = (np.asarray(end) - begin) / steps
    for i in range(steps):
        x = rk8_steps(slopes, x, begin + i * width, begin + (i + 1) * width, 1)
        low, high = np.minimum(low, x[0]), np.maximum(high, x[0])
    return x, low, high


@lru_cache(maxsize=256)
def unit_arcs(radius: float, length: float, rest: float) -> tuple[tuple[float, float], ...]:
    """Return the arcs of the equilibria with a spring of 1 N/m: stiffness only scales torques."""
    p = SpeedRegulator(crank_radius=radius, rod_length=length, spring_rest=rest, stiffness=1.0)
    return tuple(static_arcs(p).values())


def saddles_of(points: Points) -> tuple[Flags, NDArray[np.int_], Array]:
    """Return where the crank can rest (k,), and of each saddle the point and the crank angle."""
    p, number = points.parameters, len(points)
    rests = np.zeros(number, dtype=bool)
    which, angles = [np.zeros(0, dtype=int)], [np.zeros(0)]
    lengths = [p.crank_radius, p.rod_length, p.spring_rest]
    shapes = np.stack([np.broadcast_to(value, number) for value in lengths], axis=1)
    kinds, kind = np.unique(shapes, axis=0, return_inverse=True)
    for i, shape in enumerate(kinds):
        for arc in unit_arcs(*map(float, shape)):
            rows = np.flatnonzero(kind.ravel() == i)
            c = coefficients_at(coefficients(p), rows)
            ends = np.array(arc)[:, None] * np.ones(len(rows))
            below = static_torque(ends, c) < c.torque
            inside = below[0] != below[1]
            rows, c, ends = rows[inside], coefficients_at(c, inside), ends[:, inside]
            for _ in range(OPTIONS.bisections):
                middle = np.mean(ends, axis=0)
                lower = (static_torque(middle, c) < c.torque) == below[0, inside]
                ends = np.where([lower, ~lower], middle, ends)
            stable = below[0, inside]  # the torque rises along the arc
            rests[rows[stable]] = True
            which.append(rows[~stable])
            angles.append(np.mean(ends, axis=0)[~stable])
    return rests, np.concatenate(which), np.concatenate(angles)


def theory_regimes(points: Points) -> NDArray[np.int_]:
    """Return the regime of each point (k,), as `theory.regime` tells it."""
    rests, which, angles = saddles_of(points)
    p = points.parameters
    driven = np.broadcast_to((p.torque > 0) & (p.damping > 0), len(points))
    turns = driven & ~np.isin(np.arange(len(points)), which)
    rows = driven[which]
    which, angles = which[rows], angles[rows]
    c = coefficients_at(coefficients(p), which)
    with np.errstate(all="ignore"):
        fine, rough = (from_saddle(angles, c, share) for share in (1, 2))
        error = np.maximum(abs(fine.energy - rough.energy), abs(fine.lowest - rough.lowest))
        clear = np.minimum(abs(fine.energy), abs(fine.lowest)) > np.maximum(
            10 * error, OPTIONS.clear * fine.largest
        )
    round_ = clear & (fine.energy > 0) & (fine.lowest > 0)
    turns[which[round_]] = True
    for i in np.unique(which[~clear]):
        if not turns[i]:
            turns[i] = theory.rotates(points.one(int(i)))
    return regimes_of(rests, turns)


def regimes_of(rests: Flags, turns: Flags) -> NDArray[np.int_]:
    """Return the places in `REGIMES` from which stable motions there are."""
    return np.where(turns, np.where(rests, 1, 2), np.where(rests, 0, 3))


def theory_regime(points: Points) -> QuantityValues:
    """Return the regime by theory, and whether a torque a little off leaves it."""
    regime = theory_regimes(points)
    p = points.parameters
    others = [
        theory_regimes(replace(points, parameters=p.replace(torque=p.torque * factor)))
        for factor in (1 - OPTIONS.shift, 1 + OPTIONS.shift)
    ]
    robust = np.all([other == regime for other in others], axis=0)
    return QuantityValues({"regime": regime, "robust": robust.astype(int)})


class LimitCycles(NamedTuple):
    """The limit cycles of points, arrays (k,), NaN where there is none.

    ``start_speed`` is that at phi = 0 [rad/s]; ``bound`` is one on the error of the mean speed.
    """

    start_speed: Array
    mean_speed: Array
    multiplier: Array
    bound: Array


def rotations(points: Points) -> LimitCycles:
    """Return the limit cycles by theory."""
    starts, means, multipliers, bounds = (np.full(len(points), np.nan) for _ in range(4))
    left = np.flatnonzero(np.isin(theory_regimes(points), (1, 2)))
    guess = np.broadcast_to(mean_speed(points.parameters), len(points))
    for nodes in OPTIONS.nodes:
        c = coefficients_at(coefficients(points.parameters), left)
        speed, exponent, good = collocated(guess[left], c, nodes)
        done, speed = left[good], speed[good]
        starts[done] = speed[:, 0]
        means[done] = 1 / np.mean(1 / speed, axis=1)
        multipliers[done] = np.exp(exponent[good])
        bounds[done] = collocation_bound(
            speed, multipliers[done], coefficients_at(c, np.flatnonzero(good))
        )
        left = left[~good]
    for i in map(int, left):
        with suppress(NoOrbitError):
            cycle, rough = (theory.rotation(points.one(i), size) for size in OPTIONS.tolerances)
            starts[i], means[i] = cycle.start_speed, cycle.mean_speed
            multipliers[i] = cycle.multiplier
            bounds[i] = difference(means[i], rough.mean_speed) + ROUNDING * cycle.sensitivity
    return LimitCycles(starts, means, multipliers, bounds)


def collocated(guess: Array, c: Coefficients, nodes: int) -> tuple[Array, Array, Flags]:
    """Return speeds over the crank angle (k, nodes), log multiplier, and which close.

    Newton's method on ``dT/dphi = drive - damping sqrt(2 T / J)`` at equally spaced angles.
    Its linear equation ``d' + a d = residual`` has the periodic solution ``exp(-A) e``, where A
    is the integral of a less its mean m, and the harmonics n of e are those of
    ``exp(A) residual`` over ``m + i n``. It counts where it closes, and its highest harmonics are
    next to nothing.
    """
    c = Coefficients(*(np.broadcast_to(value, len(guess))[:, None] for value in c))
    at = position(TURN * np.arange(nodes) / nodes, c)
    moment, damping = inertia(at, c), c.damping * at.y_phi**2
    drive = c.torque - c.stiffness * at.y_phi * (at.y - c.rest)
    spring = c.stiffness * (at.y - c.rest) ** 2 / 2
    mean = np.mean(spring, axis=1, keepdims=True)
    room = np.max(spring, axis=1, keepdims=True) - mean
    level = np.mean(moment, axis=1, keepdims=True) * guess[:, None] ** 2 / 2
    energy = np.maximum(level, OPTIONS.first_room * room) + mean - spring
    order = np.arange(nodes // 2 + 1)
    slope = np.where(order < nodes // 2, 1j * order, 0)
    done = np.zeros(len(guess), dtype=bool)
    with np.errstate(all="ignore"):
        for _ in range(OPTIONS.max_iterations):
            speed = np.sqrt(2 * energy / moment)
            residual = drive - damping * speed
            residual = residual - np.fft.irfft(slope * np.fft.rfft(energy), nodes)
            rate = np.fft.rfft(damping / (moment * speed))
            total = np.exp(np.fft.irfft(np.where(slope == 0, 0, rate / slope), nodes))
            change = np.fft.rfft(total * residual) / (rate[:, :1].real / nodes + 1j * order)
            step = np.fft.irfft(change, nodes) / total
            energy = np.maximum(energy + step, energy / 10)
            done = np.all(abs(step) < OPTIONS.tolerance * energy, axis=1)
            if np.all(done):
                break
        harmonics = abs(np.fft.rfft(np.log(energy), axis=1))
        resolved = np.max(harmonics[:, -nodes // 8 :], axis=1) < OPTIONS.resolved * nodes
        speed = np.sqrt(2 * energy / moment)
        exponent = -TURN * np.mean(damping / (moment * speed), axis=1)
    return speed, exponent, done & resolved


def collocation_bound(speed: Array, multiplier: Array, c: Coefficients) -> Array:
    """Return bounds on the errors of mean speeds (k,), from speeds over the crank angle (k, nodes).

    By twice as many nodes, and by the effect of round-off of the energy and of the coefficients
    where the motion is slowest.
    """
    mean = 1 / np.mean(1 / speed, axis=1)
    with np.errstate(all="ignore"):
        finer, _, good = collocated(mean, c, 2 * speed.shape[1])
        rounding = ROUNDING * theory.speed_sensitivity(speed, multiplier)
        off = difference(mean, 1 / np.mean(1 / finer, axis=1)) + rounding
    return np.where(good, off, np.nan)


def theory_speed(points: Points) -> QuantityValues:
    """Return the limit cycle's mean speed by theory."""
    cycles = rotations(points)
    return speed_values(points, cycles.mean_speed, cycles.bound, {})


def speed_values(
    points: Points, speed: Array, bound: Array, problems: Mapping[int, str]
) -> QuantityValues:
    """Return the mean speed, the relative errors of formula (21) in both forms, and bounds."""
    values = {"mean_speed": speed}
    bounds = {"mean_speed_bound": bound}
    formulas = {"error_as_printed": theory.printed_mean_speed, "error_exact": mean_speed}
    with np.errstate(divide="ignore", invalid="ignore"):
        for name, formula in formulas.items():
            ratio = np.where(np.isfinite(speed), formula(points.parameters) / speed, np.nan)
            values[name] = ratio - 1
            bounds[f"{name}_bound"] = np.abs(ratio) * (bound / speed + ROUNDING)
    return QuantityValues.of(values | bounds, problems)
