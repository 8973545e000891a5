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
from . import limit_cycles
from .limit_cycles import (
    REGIMES,
    TURN,
    Flags,
    regimes_of,
    rotations,
    speed_values,
)


class RunOptions(NamedTuple):
    """How cranks are simulated.

    Attributes
    ----------
    steps_per_turn : tuple of (int, int)
        Orders of methods, and the steps of each at the fastest speed of the turn.
    samples : int
        Per turn, between which the passing of phi = 0 is interpolated.
    chunks : int
        Times the expected duration after which turns are given up.
    fast : float
        Speed at the start over that of the guess.
    turns : int
        Turns of a round.
    max_rounds : int
        Rounds until turns have settled.
    steady : float
        Largest relative change of the speed still to come of a rotation that counts as settled.
    swing_samples : int
        Of a released crank, each half a unit of its time from the next; a turn takes it several.
    max_swings : int
        Rounds of these samples.
    tolerance : float
        Relative change of the speed still to come of a rotation that counts as passed.
    max_iterations : int
        Of the secant method.
    steeper : float
        How many times more or less than the theory's an engine's turn may gain with its speed.
    """

    steps_per_turn: tuple[tuple[int, int], ...] = ((8, 32), (4, 64), (2, 256), (1, 1024))
    samples: int = 32
    chunks: int = 12
    fast: float = 1.01
    turns: int = 3
    max_rounds: int = 60
    steady: float = 0.02
    swing_samples: int = 12
    max_swings: int = 6
    tolerance: float = 1e-8
    max_iterations: int = 12
    steeper: float = 4.0


OPTIONS = RunOptions()


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
    """Return the simulation of points; a stiff closure limits the step to a stable one."""
    longest = np.full(len(points), np.inf if points.step is None else points.step)
    order = 8
    if points.engine != REFERENCE:
        for i in range(len(points)):
            setup = engine_setup(points, Case(points.scene.name, "point", points.one(i)))
            order = min(setup.integrator.order, 8)
            if points.step is None:
                longest[i] = setup.stable_step_bound
    per_turn = next(steps for least, steps in OPTIONS.steps_per_turn if order >= least)
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
    spacing = TURN / fastest / OPTIONS.samples
    samples = (count + 1) * OPTIONS.samples
    paths = [np.stack([0 * speed, speed])[:, :, None]]
    stopped, going = np.zeros(len(which), dtype=bool), np.ones(len(which), dtype=bool)
    steps = max(1, run.per_turn // OPTIONS.samples)
    for rows in rounds(going, OPTIONS.chunks):
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
    """Return True where turns (k, n) have settled: their speeds form a geometric sequence."""
    speeds = TURN / np.diff(times, axis=1)
    before, now = np.moveaxis(abs(np.diff(speeds, axis=1))[:, -2:], 1, 0)
    with np.errstate(all="ignore"):
        ratio = np.where(before > now, now / before, 0.0)
        return np.asarray(now / (1 - ratio) < OPTIONS.steady * speeds[:, -1], dtype=bool)


def keeps_turning(run: Runs) -> tuple[Flags, Flags]:
    """Return flags (k,) of a fast crank that goes on turning, and of undecided points.

    It starts a little faster than the theory's rotation; where that has none, with more than
    the energy that it takes to come over the spring.
    """
    p = run.points.parameters
    number = len(run.points)
    driven = np.broadcast_to((p.torque > 0) & (p.damping > 0), number)
    known = rotations(run.points).start_speed
    guesses = run.points.scene.orbit.guesses(p)
    guess = np.broadcast_to(np.maximum(guesses[1][1], guesses[3][1]), number)
    speed = OPTIONS.fast * (1 + run.perturbation) * np.where(np.isfinite(known), known, guess)
    turns, slow, open_ = (np.zeros(number, dtype=bool) for _ in range(3))
    open_ |= driven
    for rows in rounds(open_, OPTIONS.max_rounds):
        passed = turns_from(run, rows, speed[rows], OPTIONS.turns)
        arrived = np.isfinite(passed.speeds[:, -1])
        steady = arrived & settled(passed.times)
        turns[rows[steady]] = True
        slow[rows] = ~arrived & ~passed.stopped
        open_[rows] = arrived & ~steady
        speed[rows] = passed.speeds[:, -1]
    return turns, slow | open_


def can_rest(run: Runs) -> tuple[Flags, Flags]:
    """Return flags (k,) of cranks that the spring can stop, and of undecided points."""
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
    for rows in rounds(open_, OPTIONS.max_swings):
        path = run(rows, state[:, rows], unit[rows] / 2, OPTIONS.swing_samples, run.per_turn // 8)
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
    other = simulated_regimes(replace(run, finer=2, perturbation=limit_cycles.OPTIONS.shift))
    return run.flow.values({"regime": regime, "robust": (other == regime).astype(int)})


def simulated_speed(points: Points) -> QuantityValues:
    """Return the mean speed of the own rotation of who simulates, sought near the theory's."""
    run, known = runs(points), rotations(points)
    speed, means = known.start_speed.copy(), np.full(len(points), np.nan)
    slope = -(1 - known.multiplier) * np.maximum(known.multiplier, 0.5) ** 2
    before = np.full((2, len(points)), np.nan)
    open_ = np.isfinite(speed)
    for rows in rounds(open_, OPTIONS.max_iterations):
        passed = turns_from(run, rows, speed[rows], 3)
        gain = passed.speeds[:, 3] - passed.speeds[:, 2]
        done = abs(gain) < OPTIONS.tolerance * (1 - known.multiplier[rows]) * speed[rows]
        means[rows] = np.where(done, TURN / (passed.times[:, 3] - passed.times[:, 2]), np.nan)
        with np.errstate(all="ignore"):
            secant = (gain - before[1, rows]) / (speed[rows] - before[0, rows])
        steep = (
            np.isfinite(secant)
            & (secant < slope[rows] / OPTIONS.steeper)
            & (secant > OPTIONS.steeper * slope[rows])
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
