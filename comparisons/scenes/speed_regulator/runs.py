"""Rests and rotations of `speed_regulator` by runs, of the reference or of an engine.

A crank released where the spring holds it hardest either turns back, and then friction keeps it,
or comes round: no rest is left. A rotation is a periodic orbit, sought near that of theory.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ....reference.orbits import Orbits, state_scale
from ....reference.scene import Array, Case
from ....reference.speed_regulator.equations import (
    Coefficients,
    coefficients,
    inertia,
    position,
)
from ....reference.speed_regulator.motions import mean_speed, static_torque
from ...engines.registry import REFERENCE
from ..orbit_map import Ints, Measured, OrbitMap
from ..quantity import NO_VALUE, Flow, Points, QuantityValues, engine_setup, enough_steps
from . import limit_cycles
from .limit_cycles import REGIMES, TURN, Flags, regimes_of, rotations, speed_values


class RunOptions(NamedTuple):
    """How points are simulated.

    Attributes
    ----------
    steps_per_turn : tuple of (int, int)
        Orders of methods, and steps of each at the fastest speed of a turn.
    rest_samples, rest_rounds : int
        Of a released crank, half a unit of its time apart; a turn takes it several.
    angles : int
        At which the torque is looked at that holds the crank.
    """

    steps_per_turn: tuple[tuple[int, int], ...] = ((8, 32), (4, 64), (2, 256), (1, 1024))
    rest_samples: int = 12
    rest_rounds: int = 6
    angles: int = 4096


OPTIONS = RunOptions()


def steps_of(points: Points) -> tuple[Array, int]:
    """Return the longest step [s] of each point (k,), and steps in a turn at its fastest speed.

    By default a model with a stiff closure takes its largest stable step.
    """
    longest = np.full(len(points), np.inf if points.step is None else points.step)
    order = 8
    if points.engine != REFERENCE:
        for i in range(len(points)):
            setup = engine_setup(points, Case(points.scene.name, "point", points.one(i)))
            order = min(setup.integrator.order, 8)
            if points.step is None:
                longest[i] = setup.stable_step_bound
    return longest, next(steps for least, steps in OPTIONS.steps_per_turn if order >= least)


def simulated_rotations(points: Points) -> tuple[OrbitMap, Orbits]:
    """Return the maps over a turn from phi = 0, and the rotations near those of theory.

    An engine may have one where theory has none: it is sought where the mean torques balance.
    """
    p, count, theory = points.parameters, len(points), rotations(points)
    guesses = points.scene.orbit.guesses(p)
    guess = np.broadcast_to(np.maximum(guesses[1][1], guesses[3][1]), count)
    driven = np.broadcast_to((p.torque > 0) & (p.damping > 0), count)
    c = coefficients(p)
    with np.errstate(all="ignore"):
        mean = np.where(np.isfinite(theory.mean_speed), theory.mean_speed, mean_speed(p))
        speed = np.where(np.isfinite(theory.start_speed), theory.start_speed, guess)
        periods = np.where(driven, TURN / mean, 1.0)
        spring = c.stiffness * (position(0.0, c).y - c.rest) ** 2 + 2 * TURN * abs(c.torque)
        fastest = np.sqrt(speed**2 + spring / inertia(position(0.0, c), c))
        longest, per_turn = steps_of(points)
        wanted = np.maximum(periods * fastest / TURN * per_turn, periods / longest)
    starts = np.stack([0 * speed, speed])
    maps = OrbitMap(
        Flow(points, points.scene),
        periods,
        state_scale(points.scene, starts, TURN / periods),
        enough_steps(np.where(driven, wanted, 1.0)),
    )
    which = np.flatnonzero(driven)
    return maps, maps.search(lambda maps, known: [(which, starts[:, which])])


def rounds(open_: Flags, most: int) -> Iterator[Ints]:
    """Yield which rows (k,) are open still, round after round, up to a number of rounds."""
    for _ in range(most):
        if not np.any(open_):
            return
        yield np.flatnonzero(open_)


def can_rest(flow: Flow, finer: int = 1, perturbation: float = 0.0) -> tuple[Flags, Flags]:
    """Return whether the spring can hold the crank (k,), and where that could not be told.

    Parameters
    ----------
    flow : Flow
    finer : int
        By how much all steps are divided.
    perturbation : float
        Speed at the start, in the unit of the spring's rate.
    """
    p, number = flow.points.parameters, len(flow.points)
    c = Coefficients(*(np.broadcast_to(v, number) for v in coefficients(p)))
    phi = np.linspace(0, TURN, OPTIONS.angles, endpoint=False)[:, None]
    forward = np.where(c.torque < 0, -1.0, 1.0)
    hardest = phi[np.argmax(forward * static_torque(phi, c), axis=0), 0]
    unit = np.sqrt(c.inertia / np.maximum(abs(c.torque), c.stiffness * c.radius**2 + 1e-300))
    longest, per_turn = steps_of(flow.points)
    steps = finer * enough_steps(np.maximum(unit / 2 / longest, per_turn // 8))
    state = np.stack([hardest, forward * perturbation / unit])
    rests, open_ = np.zeros(number, dtype=bool), np.ones(number, dtype=bool)
    for rows in rounds(open_, OPTIONS.rest_rounds):
        path = flow(rows, state[:, rows], 0.0, unit[rows] / 2, OPTIONS.rest_samples, steps[rows])
        back = np.any(forward[rows, None] * path[1] < 0, axis=1)
        away = np.any(abs(path[0] - hardest[rows, None]) >= TURN, axis=1)
        rests[rows] = back & ~away
        open_[rows] = ~back & ~away
        state[:, rows] = path[:, :, -1]
    return rests, open_


def simulated_regime(points: Points) -> QuantityValues:
    """Return the regime by runs, and whether perturbed ones with halved steps end in the same."""
    maps, orbits = simulated_rotations(points)
    which, again = np.flatnonzero(orbits.closed), np.zeros(len(points), dtype=bool)
    again[which] = maps.again(which, orbits.at(which)).closed
    regimes = []
    for turns, run in ((orbits.closed, (1, 0.0)), (again, (2, limit_cycles.OPTIONS.shift))):
        rests, slow = can_rest(maps.flow, *run)
        regimes.append(np.where(slow, REGIMES.index("undecided"), regimes_of(rests, turns)))
    regimes[0][list(maps.flow.problems)] = NO_VALUE
    robust = (regimes[0] == regimes[1]).astype(int)
    return maps.flow.values({"regime": regimes[0], "robust": robust})


def simulated_speed(points: Points) -> QuantityValues:
    """Return the mean speed of the own rotation of who simulates, sought near the theory's."""
    maps, orbits = simulated_rotations(points)
    values = maps.values(orbits, settled_speed, lambda numbers: numbers["mean_speed"] > 0, none=0)
    speed, bound = values["mean_speed"], values["mean_speed_bound"]
    return speed_values(points, speed, bound, maps.flow.problems)


def settled_speed(maps: OrbitMap, which: Ints, orbits: Orbits, finer: int) -> dict[str, Measured]:
    """Return the mean speed that turns after the first one settle to.

    Each run of a model with a soft closure begins with the closure at rest, so that its first turn
    differs from those that follow. What these change falls by the multiplier from turn to turn.
    """
    phi, rate = maps.flow(which, orbits.states, 0.0, orbits.periods, 3, finer * maps.steps[which])
    turns = orbits.periods[:, None] + (TURN - np.diff(phi, axis=1)) / rate[:, 1:]
    second, third = (TURN / turns).T
    multiplier = np.where(orbits.leading < 1, orbits.leading, 0.0)
    speed = third + (third - second) * multiplier / (1 - multiplier)
    return {"mean_speed": Measured(speed, speed[:, None], unit=speed)}
