r"""What can be mapped of `speed_regulator`: where it rests or rotates, and how fast.

`theory` solves the kinetic energy over the crank angle, all points at once, where halved steps
agree; what lies too near a homoclinic torque is left to `reference.speed_regulator_theory`.

`direct`, and engines, are simulated. A crank released where the spring holds it hardest either
turns back, and then friction keeps it, or comes round: no rest is left. A crank that turns fast
either stops on its way, or goes on until its turns have settled.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import KroghInterpolator

from ....reference.errors import NoOrbitError
from ....reference.scene import Array, Case
from ....reference.solve.solver import rk8_steps
from ....reference.speed_regulator import theory
from ....reference.speed_regulator.equations import (
    Coefficients,
    SpeedRegulator,
    coefficients,
    inertia,
    mean_speed,
    position,
    static_arcs,
    static_stiffness,
    static_torque,
)
from ...checks.prediction import bearable_step, claim
from ...engines.registry import REFERENCE
from ...queries.flow import Flow, chosen
from ...queries.quantity import NO_VALUE, AxisName, Found, Points, Quantity, Variable

Flags = NDArray[np.bool_]

REGIMES = ("rest", "coexistence", "rotation", "none", "undecided")
"""As `theory.regime` names them; coexistence is of rest and rotation. Undecided: slower to
settle than was waited for."""

TURN = 2 * np.pi
SHIFT = 1e-3
"""Of a perturbed torque (theory), and of a perturbed speed at the start of a run."""


# --- Theory, over the crank angle ------------------------------------------------------------

ESCAPE_FROM, ESCAPE_TO = 1e-4, 0.3
"""Between these distances from a saddle [rad] the steps grow as the distance does."""
ESCAPE_STEPS, TURN_STEPS = 64, 96
CLEAR = 1e-6
"""Energy left after a turn, over the largest on its way, that tells it from none."""
BISECTIONS = 60
NODES = (64, 256, 1024)
"""Of the collocation of a limit cycle; what the last do not resolve, `theory` solves."""
MOST_ITERATIONS = 16
FIRST_ROOM = 1.05
"""Least kinetic energy of the first guess, over what the spring takes of its mean."""
CLOSED, RESOLVED = 1e-10, 1e-11
"""Relative change by Newton's last step, and highest harmonics of log T."""


class Turn(NamedTuple):
    """One turn over the crank angle, arrays over rows."""

    energy: Array
    """Kinetic energy at its end [J]; negative if the motion lacks so much to get there."""
    lowest: Array
    """Least on the way."""
    largest: Array
    time: Array
    exponent: Array
    """Logarithm of what a small change of energy is multiplied by."""


def at_points(c: Any, which: NDArray[np.int_]) -> Any:
    """Return the coefficients of the points that rows belong to."""
    return type(c)(*(value[which] if np.ndim(value) else value for value in c))


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
    start = np.stack([moment * (rate * ESCAPE_FROM) ** 2 / 2, 0 * saddle, 0 * saddle])
    slopes = rates(c)

    def stretched(stretch: Any, x: Any) -> Any:
        away = ESCAPE_FROM * np.exp(stretch)
        return away * slopes(saddle + away, x)

    span = np.log(ESCAPE_TO / ESCAPE_FROM)
    first = walked(stretched, start, 0.0, span, ESCAPE_STEPS // share)
    second = walked(
        slopes, first[0], saddle + ESCAPE_TO, saddle + TURN - ESCAPE_TO, TURN_STEPS // share
    )

    def gathered(stretch: Any, x: Any) -> Any:
        left = ESCAPE_TO * np.exp(-stretch)
        return left * slopes(saddle + TURN - left, x)

    third = walked(gathered, second[0], 0.0, span, ESCAPE_STEPS // share)
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
            c = at_points(coefficients(p), rows)
            ends = np.array(arc)[:, None] * np.ones(len(rows))
            below = static_torque(ends, c) < c.torque
            inside = below[0] != below[1]
            rows, c, ends = rows[inside], at_points(c, inside), ends[:, inside]
            for _ in range(BISECTIONS):
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
    c = at_points(coefficients(p), which)
    with np.errstate(all="ignore"):
        fine, rough = (from_saddle(angles, c, share) for share in (1, 2))
        error = np.maximum(abs(fine.energy - rough.energy), abs(fine.lowest - rough.lowest))
        clear = np.minimum(abs(fine.energy), abs(fine.lowest)) > np.maximum(
            10 * error, CLEAR * fine.largest
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


def theory_regime(points: Points) -> Found:
    """Return the regime by theory, and whether a torque a little off leaves it."""
    regime = theory_regimes(points)
    p = points.parameters
    others = [
        theory_regimes(replace(points, parameters=p.replace(torque=p.torque * factor)))
        for factor in (1 - SHIFT, 1 + SHIFT)
    ]
    robust = np.all([other == regime for other in others], axis=0)
    return Found({"regime": regime, "robust": robust.astype(int)})


class Rotations(NamedTuple):
    """The limit cycles of points, arrays (k,), NaN where there is none."""

    start_speed: Array
    """At phi = 0 [rad/s]."""
    mean_speed: Array
    multiplier: Array


def rotations(points: Points) -> Rotations:
    """Return the limit cycles by theory."""
    starts, means, multipliers = (np.full(len(points), np.nan) for _ in range(3))
    left = np.flatnonzero(np.isin(theory_regimes(points), (1, 2)))
    guess = np.broadcast_to(mean_speed(points.parameters), len(points))
    for nodes in NODES:
        c = at_points(coefficients(points.parameters), left)
        speed, exponent, good = collocated(guess[left], c, nodes)
        starts[left[good]] = speed[good, 0]
        means[left[good]] = 1 / np.mean(1 / speed[good], axis=1)
        multipliers[left[good]] = np.exp(exponent[good])
        left = left[~good]
    for i in map(int, left):
        with suppress(NoOrbitError):
            found = theory.rotation(points.one(i))
            starts[i], means[i] = found.start_speed, found.mean_speed
            multipliers[i] = found.multiplier
    return Rotations(starts, means, multipliers)


def collocated(guess: Array, c: Coefficients, nodes: int) -> tuple[Array, Array, Flags]:
    """Return speeds over the crank angle (k, nodes), log multiplier, and which are found.

    Newton's method on ``dT/dphi = drive - damping sqrt(2 T / J)`` at equally spaced angles.
    Its linear equation ``d' + a d = residual`` has the periodic solution ``exp(-A) e``, where A
    is the integral of a less its mean m, and the harmonics n of e are those of
    ``exp(A) residual`` over ``m + i n``. Found is what closes, and whose highest harmonics are
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
    energy = np.maximum(level, FIRST_ROOM * room) + mean - spring
    order = np.arange(nodes // 2 + 1)
    slope = np.where(order < nodes // 2, 1j * order, 0)
    done = np.zeros(len(guess), dtype=bool)
    with np.errstate(all="ignore"):
        for _ in range(MOST_ITERATIONS):
            speed = np.sqrt(2 * energy / moment)
            residual = drive - damping * speed
            residual = residual - np.fft.irfft(slope * np.fft.rfft(energy), nodes)
            rate = np.fft.rfft(damping / (moment * speed))
            total = np.exp(np.fft.irfft(np.where(slope == 0, 0, rate / slope), nodes))
            change = np.fft.rfft(total * residual) / (rate[:, :1].real / nodes + 1j * order)
            step = np.fft.irfft(change, nodes) / total
            energy = np.maximum(energy + step, energy / 10)
            done = np.all(abs(step) < CLOSED * energy, axis=1)
            if np.all(done):
                break
        harmonics = abs(np.fft.rfft(np.log(energy), axis=1))
        resolved = np.max(harmonics[:, -nodes // 8 :], axis=1) < RESOLVED * nodes
        speed = np.sqrt(2 * energy / moment)
        exponent = -TURN * np.mean(damping / (moment * speed), axis=1)
    return speed, exponent, done & resolved


def theory_speed(points: Points) -> Found:
    """Return the limit cycle's mean speed by theory."""
    return speeds_found(points, rotations(points).mean_speed, {})


def speeds_found(points: Points, speed: Array, problems: Mapping[int, str]) -> Found:
    """Return the mean speed, and the relative errors of formula (21) in both forms."""
    with np.errstate(divide="ignore", invalid="ignore"):
        printed, exact = (
            np.where(np.isfinite(speed), formula(points.parameters) / speed - 1, np.nan)
            for formula in (theory.printed_mean_speed, mean_speed)
        )
    values = {"mean_speed": speed, "error_as_printed": printed, "error_exact": exact}
    return Found(values, problems)


# --- Simulations -----------------------------------------------------------------------------

STEPS_PER_TURN = {1: 1024, 2: 256, 4: 64, 8: 32}
"""By the order of the method, at the fastest speed of the turn."""
SAMPLES = 32
"""Per turn, between which the passing of phi = 0 is interpolated."""
CHUNKS = 12
"""Times the expected duration that is waited for turns."""
FAST = 1.01
"""Speed at the start over that of the guess."""
TURNS_SEEN = 3
MOST_ROUNDS = 60
STEADY = 0.02
"""Largest relative change of the speed still to come of a rotation that counts as settled."""
SWING_SAMPLES = 12
"""Of a released crank, each half a unit of its time from the next; a turn takes it several."""
SWINGS = 6
CLOSED_TURN = 1e-8
"""Relative change of the speed still to come of a rotation that counts as found."""
MOST_JUMPS = 12
STEEPER = 4.0
"""How many times more or less than the theory's an engine's turn may gain with its speed."""


@dataclass(frozen=True)
class Runs:
    """How the points of a map are simulated.

    Attributes
    ----------
    points : Points
    flow : Flow
    longest : array (k,)
        Longest step [s] of each point, beside those that a turn is divided in.
    per_turn : int
        Steps per turn, unless ``longest`` asks for more.
    finer : int
        By how much all steps are divided.
    nudge : float
        Relative change of the speeds at the start.
    """

    points: Points
    flow: Flow
    longest: Array
    per_turn: int
    finer: int = 1
    nudge: float = 0.0

    @property
    def parameters(self) -> Any:
        """Parameters of the points."""
        return self.points.parameters

    def __call__(
        self, which: NDArray[np.int_], states: Array, spacing: Array, count: int, steps: int
    ) -> Array:
        """Return the states (2, k, count) of rows, each in steps no longer than its longest."""
        wanted = np.maximum(np.ceil(spacing / self.longest[which] * (1 - 1e-12)), steps)
        return self.flow(which, states, 0.0, spacing, count, self.finer * wanted.astype(int))


def runs(points: Points) -> Runs:
    """Return how points are simulated; the step of a model with a stiff closure is one it bears."""
    longest = np.full(len(points), np.inf if points.step is None else points.step)
    order = 8
    if points.engine != REFERENCE:
        for i in range(len(points)):
            case = Case(points.scene.name, "point", points.one(i))
            engine, model, method = chosen(points, case)
            order = min(method.order, 8)
            if points.step is None:
                longest[i] = bearable_step(case, claim(engine, case, model))
    per_turn = STEPS_PER_TURN[max(known for known in STEPS_PER_TURN if known <= order)]
    return Runs(points, Flow(points, points.scene), longest, per_turn)


class Turns(NamedTuple):
    """Successive passings of phi = 0 of rows: arrays (k, count + 1), NaN where none came."""

    times: Array
    speeds: Array
    stopped: Flags
    """(k,): whether the crank stood still on its way."""


def turned(run: Runs, which: NDArray[np.int_], speed: Array, count: int) -> Turns:
    """Follow motions from phi = 0 for some turns."""
    c = at_points(coefficients(run.parameters), which)
    spring = c.stiffness * (position(0.0, c).y - c.rest) ** 2
    fastest = np.sqrt(speed**2 + (spring + 2 * TURN * abs(c.torque)) / inertia(position(0, c), c))
    spacing = TURN / fastest / SAMPLES
    samples = (count + 1) * SAMPLES
    paths = [np.stack([0 * speed, speed])[:, :, None]]
    stopped, going = np.zeros(len(which), dtype=bool), np.ones(len(which), dtype=bool)
    steps = max(1, run.per_turn // SAMPLES)
    for _ in range(CHUNKS):
        rows = np.flatnonzero(going)
        if not rows.size:
            break
        path = np.full((2, len(which), samples), np.nan)
        path[:, rows] = run(which[rows], paths[-1][:, rows, -1], spacing[rows], samples, steps)
        paths.append(path)
        stopped |= np.any(path[1] <= 0, axis=1)
        going &= ~stopped & ~(path[0, :, -3] >= count * TURN)
    phi, rate = np.concatenate(paths, axis=2)
    passed = [passings(phi[row], rate[row], spacing[row], count) for row in range(len(which))]
    times, speeds = np.moveaxis(np.array(passed), 1, 0)
    return Turns(times, speeds, stopped)


def passings(phi: Array, rate: Array, spacing: float, count: int) -> tuple[Array, Array]:
    """Return when, and how fast, a motion passes 0, 2 pi, ..., up to where it stops.

    Time over the angle, interpolated from four samples about each passing and their speeds.
    """
    times, speeds = np.zeros(count + 1), np.full(count + 1, rate[0])
    times[1:] = speeds[1:] = np.nan
    forward = np.isfinite(rate) & (rate > 0)
    end = len(rate) if np.all(forward) else int(np.argmin(forward))
    after = np.searchsorted(phi[:end], TURN * np.arange(count + 1))
    for mark in range(1, count + 1):
        near = np.arange(after[mark] - 2, after[mark] + 2)
        if near[-1] >= end:
            break
        angles = np.repeat(phi[near] - TURN * mark, 2)
        known = np.stack([spacing * near, 1 / rate[near]], axis=1).ravel()
        curve = KroghInterpolator(angles, known)
        times[mark] = curve(0.0)
        speeds[mark] = 1 / curve.derivative(0.0)
    return times, speeds


def settled(times: Array) -> Flags:
    """Return whether turns (k, n) have settled: their speeds go on as a geometric sequence."""
    speeds = TURN / np.diff(times, axis=1)
    before, now = np.moveaxis(abs(np.diff(speeds, axis=1))[:, -2:], 1, 0)
    with np.errstate(all="ignore"):
        ratio = np.where(before > now, now / before, 0.0)
        return np.asarray(now / (1 - ratio) < STEADY * speeds[:, -1], dtype=bool)


def keeps_turning(run: Runs) -> tuple[Flags, Flags]:
    """Return whether a fast crank goes on turning (k,), and where that could not be told.

    It starts a little faster than the theory's rotation; where that has none, with more than
    the energy that it takes to come over the spring.
    """
    p = run.parameters
    number = len(run.points)
    driven = np.broadcast_to((p.torque > 0) & (p.damping > 0), number)
    known = rotations(run.points).start_speed
    guesses = run.points.scene.orbit_guesses(p)
    guess = np.broadcast_to(np.maximum(guesses[1][1], guesses[3][1]), number)
    speed = FAST * (1 + run.nudge) * np.where(np.isfinite(known), known, guess)
    turns, slow, open_ = (np.zeros(number, dtype=bool) for _ in range(3))
    open_ |= driven
    for _ in range(MOST_ROUNDS):
        rows = np.flatnonzero(open_)
        if not rows.size:
            break
        found = turned(run, rows, speed[rows], TURNS_SEEN)
        arrived = np.isfinite(found.speeds[:, -1])
        steady = arrived & settled(found.times)
        turns[rows[steady]] = True
        slow[rows] = ~arrived & ~found.stopped
        open_[rows] = arrived & ~steady
        speed[rows] = found.speeds[:, -1]
    return turns, slow | open_


def can_rest(run: Runs) -> tuple[Flags, Flags]:
    """Return whether the spring can hold the crank (k,), and where that could not be told."""
    p = run.parameters
    number = len(run.points)
    which = np.arange(number)
    c = at_points(Coefficients(*(np.broadcast_to(v, number) for v in coefficients(p))), which)
    phi = np.linspace(0, TURN, 4096, endpoint=False)[:, None]
    forward = np.where(c.torque < 0, -1.0, 1.0)
    hardest = phi[np.argmax(forward * static_torque(phi, c), axis=0), 0]
    unit = np.sqrt(c.inertia / np.maximum(abs(c.torque), c.stiffness * c.radius**2 + 1e-300))
    state = np.stack([hardest, forward * run.nudge / unit])
    held, open_ = np.zeros(number, dtype=bool), np.ones(number, dtype=bool)
    for _ in range(SWINGS):
        rows = np.flatnonzero(open_)
        if not rows.size:
            break
        spacing = unit[rows] / 2
        path = run(rows, state[:, rows], spacing, SWING_SAMPLES, run.per_turn // 8)
        back = np.any(forward[rows, None] * path[1] < 0, axis=1)
        away = np.any(abs(path[0] - hardest[rows, None]) >= TURN, axis=1)
        held[rows] = back & ~away
        open_[rows] = ~back & ~away
        state[:, rows] = path[:, :, -1]
    return held, open_


def simulated_regimes(run: Runs) -> NDArray[np.int_]:
    """Return the regime (k,) that runs end in."""
    held, slow = can_rest(run)
    turns, open_ = keeps_turning(run)
    found = regimes_of(held, turns)
    found[slow | open_] = REGIMES.index("undecided")
    found[list(run.flow.problems)] = NO_VALUE
    return found


def simulated_regime(points: Points) -> Found:
    """Return the regime by runs, and whether perturbed ones with halved steps end in the same."""
    run = runs(points)
    regime = simulated_regimes(run)
    other = simulated_regimes(replace(run, finer=2, nudge=SHIFT))
    regime[list(run.flow.problems)] = NO_VALUE
    return Found({"regime": regime, "robust": (other == regime).astype(int)}, run.flow.problems)


def simulated_speed(points: Points) -> Found:
    """Return the mean speed of the own rotation of who simulates, sought near the theory's."""
    run, known = runs(points), rotations(points)
    speed, means = known.start_speed.copy(), np.full(len(points), np.nan)
    slope = -(1 - known.multiplier) * np.maximum(known.multiplier, 0.5) ** 2
    before = np.full((2, len(points)), np.nan)
    open_ = np.isfinite(speed)
    for _ in range(MOST_JUMPS):
        rows = np.flatnonzero(open_)
        if not rows.size:
            break
        found = turned(run, rows, speed[rows], 3)
        gain = found.speeds[:, 3] - found.speeds[:, 2]
        done = abs(gain) < CLOSED_TURN * (1 - known.multiplier[rows]) * speed[rows]
        means[rows] = np.where(done, TURN / (found.times[:, 3] - found.times[:, 2]), np.nan)
        with np.errstate(all="ignore"):
            secant = (gain - before[1, rows]) / (speed[rows] - before[0, rows])
        steep = (
            np.isfinite(secant)
            & (secant < slope[rows] / STEEPER)
            & (secant > STEEPER * slope[rows])
        )
        slope[rows] = np.where(steep, secant, slope[rows])
        before[:, rows] = speed[rows], gain
        speed[rows] -= gain / slope[rows]
        open_[rows] = np.isfinite(gain) & (speed[rows] > 0) & ~done
    problems = {i: "its turns do not settle" for i in map(int, np.flatnonzero(open_))}
    return speeds_found(points, means, problems | run.flow.problems)


# --- What can be mapped ----------------------------------------------------------------------


def regime(points: Points) -> Found:
    """Return the regime of each point."""
    by_theory = points.engine == REFERENCE and points.model != "direct"
    return theory_regime(points) if by_theory else simulated_regime(points)


def speed(points: Points) -> Found:
    """Return the mean speed of each point's rotation."""
    by_theory = points.engine == REFERENCE and points.model != "direct"
    return theory_speed(points) if by_theory else simulated_speed(points)


QUANTITIES: Mapping[str, Quantity] = {
    "regime": Quantity(
        about="which stable motions there are: rest, rotation, or both",
        variables={
            "regime": Variable("1", "stable motions", REGIMES),
            "robust": Variable("1", "1 where a perturbation and halved steps leave it as it is"),
        },
        evaluate=regime,
        models=("theory", "direct"),
        block=1024,
        engine_block=16,
    ),
    "mean_speed": Quantity(
        about="mean speed of the rotation, and the error of formula (21)",
        variables={
            "mean_speed": Variable("rad/s", "2 pi / period of the limit cycle"),
            "error_as_printed": Variable("1", "(21) as printed over the mean speed, less 1"),
            "error_exact": Variable("1", "(21) with its exact average over it, less 1"),
        },
        evaluate=speed,
        models=("theory", "direct"),
        block=1024,
        engine_block=16,
    ),
}

AXES: Mapping[str, AxisName] = {}
