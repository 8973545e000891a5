"""Rests and rotations of `speed_regulator` by runs, of the reference or of an engine.

A crank released where the spring holds it hardest either turns back, and then friction keeps it,
or comes round: no rest is left. A crank that turns fast either stops on its way, or goes on until
its turns have settled.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import KroghInterpolator

from ....reference.scene import Array, Case, coefficients_at
from ....reference.speed_regulator.equations import (
    Coefficients,
    coefficients,
    inertia,
    position,
)
from ....reference.speed_regulator.motions import static_torque
from ...engines.registry import REFERENCE
from ..quantity import NO_VALUE, Flow, Points, QuantityValues, engine_setup
from .limit_cycles import (
    REGIMES,
    SHIFT,
    TURN,
    Flags,
    regimes_of,
    rotations,
    speed_values,
)

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
"""Relative change of the speed still to come of a rotation that counts as passed."""
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
    perturbation : float
        Relative change of the speeds at the start.
    """

    points: Points
    flow: Flow
    longest: Array
    per_turn: int
    finer: int = 1
    perturbation: float = 0.0

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
            setup = engine_setup(points, Case(points.scene.name, "point", points.one(i)))
            order = min(setup.integrator.order, 8)
            if points.step is None:
                longest[i] = setup.stable_step_bound
    per_turn = STEPS_PER_TURN[max(known for known in STEPS_PER_TURN if known <= order)]
    return Runs(points, Flow(points, points.scene), longest, per_turn)


def rounds(open_: Flags, most: int) -> Iterator[NDArray[np.int_]]:
    """Yield which rows (k,) are open still, round after round, up to a number of rounds."""
    for _ in range(most):
        if not np.any(open_):
            return
        yield np.flatnonzero(open_)


class Passings(NamedTuple):
    """Successive passings of phi = 0 of rows: arrays (k, count + 1), NaN where none came.

    ``stopped`` (k,) tells whether the crank stood still on its way.
    """

    times: Array
    speeds: Array
    stopped: Flags


def turns_from(run: Runs, which: NDArray[np.int_], speed: Array, count: int) -> Passings:
    """Follow motions from phi = 0 for some turns."""
    c = coefficients_at(coefficients(run.points.parameters), which)
    spring = c.stiffness * (position(0.0, c).y - c.rest) ** 2
    fastest = np.sqrt(speed**2 + (spring + 2 * TURN * abs(c.torque)) / inertia(position(0, c), c))
    spacing = TURN / fastest / SAMPLES
    samples = (count + 1) * SAMPLES
    paths = [np.stack([0 * speed, speed])[:, :, None]]
    stopped, going = np.zeros(len(which), dtype=bool), np.ones(len(which), dtype=bool)
    steps = max(1, run.per_turn // SAMPLES)
    for rows in rounds(going, CHUNKS):
        path = np.full((2, len(which), samples), np.nan)
        path[:, rows] = run(which[rows], paths[-1][:, rows, -1], spacing[rows], samples, steps)
        paths.append(path)
        stopped |= np.any(path[1] <= 0, axis=1)
        going &= ~stopped & ~(path[0, :, -3] >= count * TURN)
    phi, rate = np.concatenate(paths, axis=2)
    passed = [passings(phi[row], rate[row], spacing[row], count) for row in range(len(which))]
    times, speeds = np.moveaxis(np.array(passed), 1, 0)
    return Passings(times, speeds, stopped)


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
        curve = KroghInterpolator(
            angles, np.stack([spacing * near, 1 / rate[near]], axis=1).ravel()
        )
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
    p = run.points.parameters
    number = len(run.points)
    driven = np.broadcast_to((p.torque > 0) & (p.damping > 0), number)
    known = rotations(run.points).start_speed
    guesses = run.points.scene.orbit.guesses(p)
    guess = np.broadcast_to(np.maximum(guesses[1][1], guesses[3][1]), number)
    speed = FAST * (1 + run.perturbation) * np.where(np.isfinite(known), known, guess)
    turns, slow, open_ = (np.zeros(number, dtype=bool) for _ in range(3))
    open_ |= driven
    for rows in rounds(open_, MOST_ROUNDS):
        passed = turns_from(run, rows, speed[rows], TURNS_SEEN)
        arrived = np.isfinite(passed.speeds[:, -1])
        steady = arrived & settled(passed.times)
        turns[rows[steady]] = True
        slow[rows] = ~arrived & ~passed.stopped
        open_[rows] = arrived & ~steady
        speed[rows] = passed.speeds[:, -1]
    return turns, slow | open_


def can_rest(run: Runs) -> tuple[Flags, Flags]:
    """Return whether the spring can hold the crank (k,), and where that could not be told."""
    p = run.points.parameters
    number = len(run.points)
    c = coefficients_at(
        Coefficients(*(np.broadcast_to(v, number) for v in coefficients(p))), np.arange(number)
    )
    phi = np.linspace(0, TURN, 4096, endpoint=False)[:, None]
    forward = np.where(c.torque < 0, -1.0, 1.0)
    hardest = phi[np.argmax(forward * static_torque(phi, c), axis=0), 0]
    unit = np.sqrt(c.inertia / np.maximum(abs(c.torque), c.stiffness * c.radius**2 + 1e-300))
    state = np.stack([hardest, forward * run.perturbation / unit])
    rests, open_ = np.zeros(number, dtype=bool), np.ones(number, dtype=bool)
    for rows in rounds(open_, SWINGS):
        path = run(rows, state[:, rows], unit[rows] / 2, SWING_SAMPLES, run.per_turn // 8)
        back = np.any(forward[rows, None] * path[1] < 0, axis=1)
        away = np.any(abs(path[0] - hardest[rows, None]) >= TURN, axis=1)
        rests[rows] = back & ~away
        open_[rows] = ~back & ~away
        state[:, rows] = path[:, :, -1]
    return rests, open_


def simulated_regimes(run: Runs) -> NDArray[np.int_]:
    """Return the regime (k,) that runs end in."""
    rests, slow = can_rest(run)
    turns, open_ = keeps_turning(run)
    regime = regimes_of(rests, turns)
    regime[slow | open_] = REGIMES.index("undecided")
    regime[list(run.flow.problems)] = NO_VALUE
    return regime


def simulated_regime(points: Points) -> QuantityValues:
    """Return the regime by runs, and whether perturbed ones with halved steps end in the same."""
    run = runs(points)
    regime = simulated_regimes(run)
    other = simulated_regimes(replace(run, finer=2, perturbation=SHIFT))
    return run.flow.values({"regime": regime, "robust": (other == regime).astype(int)})


def simulated_speed(points: Points) -> QuantityValues:
    """Return the mean speed of the own rotation of who simulates, sought near the theory's."""
    run, known = runs(points), rotations(points)
    speed, means = known.start_speed.copy(), np.full(len(points), np.nan)
    slope = -(1 - known.multiplier) * np.maximum(known.multiplier, 0.5) ** 2
    before = np.full((2, len(points)), np.nan)
    open_ = np.isfinite(speed)
    for rows in rounds(open_, MOST_JUMPS):
        passed = turns_from(run, rows, speed[rows], 3)
        gain = passed.speeds[:, 3] - passed.speeds[:, 2]
        done = abs(gain) < CLOSED_TURN * (1 - known.multiplier[rows]) * speed[rows]
        means[rows] = np.where(done, TURN / (passed.times[:, 3] - passed.times[:, 2]), np.nan)
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
    bound = np.full(len(points), np.nan)
    if points.engine == REFERENCE:
        bound = np.abs(means - known.mean_speed) + known.bound
    return speed_values(points, means, bound, problems | run.flow.problems)
