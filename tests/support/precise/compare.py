"""The reference held against trajectories in higher precision."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import gmpy2
import numpy as np

from mbcheck.reference import get_scene
from mbcheck.reference.errors import MbcheckError
from mbcheck.reference.scene import Array
from mbcheck.reference.solve.single import solve
from mbcheck.reference.solve.solution import Solution
from mbcheck.tests.support.precise.beam import HAS_EXTENDED, Beam
from mbcheck.tests.support.precise.body import Body
from mbcheck.tests.support.precise.floating import floating_beam, floating_platform
from mbcheck.tests.support.precise.kinds.common import Run
from mbcheck.tests.support.precise.lagrange import program_of
from mbcheck.tests.support.precise.series import (
    Accuracy,
    Lagrangian,
    Numbers,
    StepLimitError,
    System,
    integrate,
)

ROUGH = Accuracy(44, 16)
"""Of runs with doubles, for the length of a run and the growth of errors."""

EXTENDED = Accuracy(61, 26), Accuracy(61, 20)
"""Of numbers of 64 bits, which NumPy has on some machines, for a system of many coordinates."""

REGULAR = 1e3
"""Growth of errors below which a motion is regular."""

TRUSTED = 1e6
"""Growth of errors below which one precise solution does, with bits to spare."""

MOST_STEPS = 250
"""Most steps of a run with doubles, unless the run says more: it is shortened to these."""

ENOUGH = 1e-3
"""Share of the stated bound that the error of the precise trajectory may have."""

FINEST = 3000
"""Most bits that are tried."""


@dataclass(frozen=True)
class Outcome:
    """How far the reference is off in one run.

    Attributes
    ----------
    kind : str
    excess : float
        Largest error over stated bound, of all states before they are lost.
    excess_in_time : float
        The same with the bounds that hold up to each of the times.
    margins : tuple of float
        Stated bound over error of each state that has an error.
    growth : float
        Of errors of the start, relative to the sizes of the states.
    lost_from : float or None
        Time [s] from which the reference knows nothing.
    refusal : str
        Why the reference solved nothing, or "".
    seconds : (float, float)
        Taken by the reference, and by all else.
    """

    kind: str
    excess: float = 0.0
    excess_in_time: float = 0.0
    margins: tuple[float, ...] = ()
    growth: float = 1.0
    lost_from: float | None = None
    refusal: str = ""
    seconds: tuple[float, float] = (0.0, 0.0)

    @property
    def regular(self) -> bool:
        """Whether errors hardly grow."""
        return not self.refusal and self.lost_from is None and self.growth < REGULAR


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Compute with so many bits."""
    with gmpy2.context(gmpy2.get_context(), precision=bits):
        yield


def system_of(run: Run, bits: int) -> System:
    """Return the equations of a run, its parameters as they are in binary."""
    if run.scene == "rotating_beam":
        return Beam(run.parameters, bits)
    if run.scene == "floating_platform":
        return floating_platform(run.parameters, bits)
    if run.scene == "floating_beam":
        return floating_beam(run.parameters, bits)
    if get_scene(run.scene).quaternions:
        return Body(run.parameters, bits)
    values = run.parameters.as_dict()
    words = [value for value in values.values() if isinstance(value, str)]
    numbers = {name: gmpy2.mpfr(value) for name, value in values.items() if value not in words}
    size, program = program_of(run.scene, "".join(words))
    return Lagrangian(size, program, numbers)


def precise_states(run: Run, start: Array, times: Array, accuracy: Accuracy) -> list[Numbers]:
    """Return the states (n_t, 2 n) at the times, with an accuracy."""
    with precision(accuracy.working):
        system, number = system_of(run, max(accuracy.working, 128)), gmpy2.mpfr
        if accuracy in EXTENDED and isinstance(system, Beam):
            number = system.to_extended()
        state = [number(float(value)) for value in start]
        marks = [number(float(mark)) for mark in times]
        rows = integrate(system, state, number(run.start_time), marks, accuracy)[0]
        return rows if number is gmpy2.mpfr else [[exact(value) for value in row] for row in rows]


def exact(value: Any) -> Any:
    """Return a number of at most 106 bits as it is."""
    high = float(value)
    return gmpy2.mpfr(high) + gmpy2.mpfr(float(value - high))


class Plain:
    """A system in doubles, by the same equations."""

    def __init__(self, run: Run) -> None:
        with precision(53):
            self.system = system_of(run, 128)
        self.system.to_float()
        self.most_steps = round(run.patience * MOST_STEPS)

    def states(self, start: Array, begin: float, times: Array) -> Array:
        """Return the states (2 n, n_t)."""
        rows = integrate(
            self.system, start.tolist(), begin, times.tolist(), ROUGH, self.most_steps
        )[0]
        return np.array(rows, dtype=float).T

    def rate(self, begin: float, x: Array) -> Array:
        """Return dx/dt (2 n,)."""
        series = self.system.expand(begin, x.tolist(), 2)
        return np.array([row[1] for row in series] + [2 * row[2] for row in series])

    def fastest(self, begin: float, x: Array, size: Array) -> float:
        """Return the largest rate [1/s] of the linearised motion, and of turning."""
        n = len(x) // 2
        step = 1e-6 * size
        columns = [
            (self.rate(begin, x + dx) - self.rate(begin, x - dx)) / (2 * h)
            for dx, h in zip(np.diag(step), step, strict=True)
        ]
        rates = np.abs(np.linalg.eigvals(np.array(columns).T))
        return float(max(np.max(rates), np.max(np.abs(x[n:]) * (size[:n] > 0))))


def length_and_growth(run: Run, start: Array) -> tuple[float, float]:
    """Return the length [s] of a run, and how much errors of its start grow."""
    plain, begin = Plain(run), run.start_time
    n = len(start) // 2
    size = np.where(start != 0, np.abs(start), 1.0)
    length = run.horizon or run.turns * 2 * math.pi / plain.fastest(begin, start, size)
    while True:
        times = run.times(length)
        try:
            states = plain.states(start, begin, times)
            break
        except StepLimitError as error:
            length = 0.9 * (error.reached - begin)
    size = np.maximum(np.max(np.abs(states), axis=1), np.abs(start))
    size[n:] = np.maximum(size[n:], size[:n] / length)
    size[:n] = np.maximum(size[:n], 1e-3 * np.where(size[:n] > 0, 0, size[n:] * length))
    size = np.where(size > 0, size, 1.0)
    change = 1e-8 * size * np.random.default_rng(1).choice([-1.0, 1.0], 2 * n)
    plain.most_steps *= 2
    try:
        moved = plain.states(start + change, begin, times)
    except StepLimitError:
        return length, math.inf
    growth = np.max(np.abs(moved - states) / (1e-8 * size[:, None]))
    return length, max(1.0, float(growth))


def precise(run: Run, start: Array, solution: Solution, growth: float) -> tuple[list[Numbers], int]:
    """Return the states (n_t, 2 n), errors far below the solution's bound, and the bits they took.

    A regular motion is trusted in `Accuracy` with bits to spare; another is solved with more bits
    until two solutions agree.

    Raises
    ------
    StepLimitError
    """
    times, small = solution.times, solution.error_bound
    if not len(times):
        return [], 0
    bits = 88 + math.ceil(math.log2(min(growth, 1e9)))
    if run.scene == "rotating_beam" and HAS_EXTENDED and growth < TRUSTED:
        one, other = (precise_states(run, start, times, how) for how in EXTENDED)
        if np.all(differences(one, other) <= 10 * ENOUGH * small):
            return other, EXTENDED[1].bits
    states = precise_states(run, start, times, Accuracy(bits))
    if growth < TRUSTED:
        return states, bits
    while bits < FINEST:
        bits = round(1.5 * bits)
        better = precise_states(run, start, times, Accuracy(bits))
        if np.all(differences(states, better) <= ENOUGH * small):
            return better, bits
        states = better
    raise StepLimitError(f"{FINEST} bits do not do", run.start_time)


def differences(one: list[Numbers], other: list[Numbers]) -> Array:
    """Return how far states (n_t, 2 n) lie apart, (n_t, 2 n)."""
    with precision(FINEST):
        return np.array(
            [
                [float(abs(a - b)) for a, b in zip(*rows, strict=True)]
                for rows in zip(one, other, strict=True)
            ]
        )


def compare(run: Run) -> Outcome:
    """Solve a run by the reference and in higher precision."""
    begin = time.process_time()
    scene = get_scene(run.scene)
    start = scene.state(run.state)
    length, growth = length_and_growth(run, start)
    times = run.times(length)
    outcome = Outcome(run.kind, growth=growth)
    before = time.process_time()
    try:
        solution = solve(scene, run.parameters, start, times, run.start_time)
        after = time.process_time()
        states, _ = precise(run, start, solution.before_lost, growth)
    except (MbcheckError, StepLimitError) as error:
        return replace(outcome, refusal=f"{type(error).__name__}: {error}")
    return replace(
        outcome,
        **ratios(states, solution.before_lost),
        lost_from=solution.lost_from,
        seconds=(after - before, time.process_time() - after + before - begin),
    )


def ratios(states: list[Numbers], solution: Solution) -> dict[str, Any]:
    """Return both excesses and the margins of an `Outcome`."""
    stated = [[gmpy2.mpfr(float(x)) for x in row] for row in solution.states.T]
    errors = differences(states, stated).reshape(-1, len(solution.states)).T
    whole = solution.error_bound[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        margins = solution.error_bound / np.max(errors, axis=1, initial=0.0)
    return {
        "excess": largest_ratio(errors, whole),
        "excess_in_time": largest_ratio(
            errors, whole if solution.bounds is None else solution.bounds
        ),
        "margins": tuple(float(value) for value in margins if 0 < value < np.inf),
    }


def largest_ratio(errors: Array, bounds: Array) -> float:
    """Return the largest error over its bound; an error without a bound is infinitely above it."""
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.where(errors > 0, errors / bounds, 0.0)
    return float(np.max(np.where(np.isnan(shares), np.inf, shares), initial=0.0))
