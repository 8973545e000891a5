"""Kind *limits*: the largest stable step of a method, by bisection on runs, compared with theory.

The engine vibrates freely with a small amplitude about a state of rest, in the shape of the mode
with the smallest stable step. The reference is the same bisection on powers of the amplification
matrix, from the same start, by the same measure. A run counts as unstable if an observable reaches
`GROWTH` times its true size, or if the guard stops it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from ....reference.amplification import AMPLIFICATION, GROWTH, first_order
from ....reference.differences import by_complex_step
from ....reference.errors import CannotJudgeError, EngineError, Unsupported
from ....reference.scene import Array, Case
from ...engines.setup import Setup
from ..comparison import Measured
from ..free_vibrations import START, Critical, Place, critical, places, stable_step
from ..rules.cautions import cautions, noticing_rules
from ..truth import rows
from ..verdict import REFERENCE, Finding, detected_by

QUANTITY = "step_limit"

PERIODS = 20
"""Periods of the fastest mode over which a vibration must stay bounded."""

STEPS = 200
"""Steps of the runs of a method without a limit."""

AMPLITUDE = 1e-7
"""Amplitude of the start [m, rad]: its nonlinear terms are far below the resolution of the
bisection. A soft closure hardens within MuJoCo's ``width`` of 1e-3 m."""

SEEN = 256
"""Most times at which a run is sampled."""

BEYOND = 1.02
"""Multiple of the largest stable step at which the least stable mode shows."""

RESOLUTION = 1e-3
"""Relative width in which the bisection ends."""

AGREEMENT = 2 * RESOLUTION
"""Largest relative distance of two limits that agree: each is known to `RESOLUTION`."""

UNLIMITED = (1000.0, 100.0, 10.0)
"""Periods of the fastest mode in a step with which a method without a limit is tried, in this
order."""

OVERSHOOT = 1.01
"""Factor on the growth of the amplification matrix: round-off with steps of a thousand periods."""


def quantities(setup: Setup) -> tuple[str, ...]:
    """Return the name of the measured quantity."""
    return (QUANTITY,)


def measure(setup: Setup) -> Measured:
    """Find the largest stable step on runs, and compare it with that of the amplification matrix.

    Of a method without a limit, compare the growth with steps of `UNLIMITED` periods.
    """
    scheme = setup.linear_scheme
    if scheme is None:
        raise CannotJudgeError("no amplification matrix of this method is known")
    rests = places(setup, scheme)
    rests = tuple(at for at in rests if at.name != START) or rests
    at = max(rests, key=fastest_rate)
    omega = fastest_rate(at)
    horizon = PERIODS * 2 * np.pi / omega
    limit = stable_step(setup, horizon, [at])
    if limit is None:
        return Measured([without_limit(Vibration(setup, at, scheme, *fastest_mode(at)))])
    # the mode that the method multiplies most beyond its limit
    values, vectors = np.linalg.eig(AMPLIFICATION[scheme](at.matrices, BEYOND * limit.step))
    shape = vectors[: 2 * len(at.coordinates), np.argmax(np.abs(values))].real
    free = Vibration(setup, at, scheme, critical(scheme, at, BEYOND * limit.step), shape)
    around = limit.step / 4, 4 * limit.step
    expected = bisected(lambda h: free.by_matrix(h, horizon) > GROWTH, *around)
    try:
        measured = bisected(lambda h: free.grows_in_run(h, horizon), *around)
    except EngineError as failure:
        refusal = f"{failure.message}; {free.words}, theory {limit.step:.4g} s"
        raise Unsupported(refusal) from failure
    omega = free.mode.omega
    reason = (
        f"{free.words}: h omega = {measured * omega:.4g}, theory {limit.step * omega:.4g}, from "
        f"this start {expected * omega:.4g}"
    )
    error, tolerance = abs(measured - expected), AGREEMENT * expected
    # beside a limit all steps are coarse: no rule tells that it is a wrong one
    noticed = (REFERENCE,)
    finding = Finding(QUANTITY, "s", measured, expected, error, tolerance, reason, None, noticed)
    return Measured([finding])


def bisected(bad: Callable[[float], bool], low: float, high: float) -> float:
    """Return the largest good value between two, by bisection of the logarithm.

    They are moved by factors of 4 until the lower is good and the higher bad; where there is no
    such pair, the last that was tried is returned.
    """
    for _ in range(12):
        if not bad(low):
            break
        low, high = low / 4, low
    else:
        return low
    for _ in range(12):
        if bad(high):
            break
        low, high = high, 4 * high
    else:
        return high
    while high > low * (1 + RESOLUTION):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if bad(middle) else (middle, high)
    return low


def without_limit(free: Vibration) -> Finding:
    """Return the finding on a vibration with very long steps, by a method without a limit.

    Generalized-alpha is stable and yet amplifies a start before it settles: the growth of its
    matrix is granted.

    Raises
    ------
    Unsupported
        If the engine refuses such steps.
    """
    words, result = f"{free.words}: none by theory", None
    for periods in UNLIMITED:
        step = periods * 2 * np.pi / free.mode.omega
        setup, horizon = free.setup.with_step(step), STEPS * step
        words += f"; with {periods:g} periods in a step "
        try:
            growth = free.by_run(step, horizon)
        except EngineError as error:
            words += f"{error.kind}: {error.message}"
            if error.kind == "step":
                raise Unsupported(words) from error
            noticed = (detected_by(error), *noticing_rules(cautions(setup, horizon)))
            result = Finding(QUANTITY, "1", np.inf, 0.0, np.inf, GROWTH, words, None, noticed)
            continue
        most = max(GROWTH, OVERSHOOT * free.by_matrix(step, horizon))
        words += f"amplitude {growth:.3g} times its true size, {most:.3g} granted"
        if growth <= most:
            break
        noticed = (*noticing_rules(cautions(setup, horizon)), REFERENCE)
        result = Finding(QUANTITY, "1", growth, 0.0, growth, most, words, None, noticed)
    if result is None:
        return Finding(QUANTITY, "1", growth, 0.0, growth, most, words)
    return replace(result, reason=words)


def fastest_rate(at: Place) -> float:
    """Return the largest modulus of the eigenvalues about a place [1/s]."""
    return float(np.max(np.abs(at.rates)))


def fastest_mode(at: Place) -> tuple[Critical, Array]:
    """Return the fastest mode, and its shape (2 w,) at its largest displacement."""
    values, vectors = np.linalg.eig(first_order(at.matrices))
    row = int(np.argmax(np.abs(values) * (values.imag >= 0)))
    width = len(at.coordinates)
    place = int(np.argmax(np.abs(vectors[:width, row])))
    shape = (vectors[:, row] / vectors[place, row]).real
    shape[width:] = 0.0
    return Critical(float(abs(values[row])), at.coordinates[place]), shape


@dataclass(frozen=True)
class Vibration:
    """A mode about a state of rest, and how it starts.

    Attributes
    ----------
    setup : Setup
    at : Place
    scheme : str
    mode : Critical
    shape : array (2 w,)
        Of the matrices' coordinates and their rates, in any size.
    """

    setup: Setup
    at: Place
    scheme: str
    mode: Critical
    shape: Array

    @property
    def words(self) -> str:
        """The mode in words."""
        mode = self.mode
        return f"mode of {mode.coordinate}, {mode.omega:.5g} rad/s about {self.at.name}"

    @property
    def rows(self) -> list[int]:
        """Rows of the matrices' states that are the model's, a drive's left out."""
        n, width = len(self.setup.bound.equations.scene.coordinates), len(self.at.coordinates)
        return [*range(n), *range(width, width + n)]

    @cached_property
    def departure(self) -> Array:
        """Departure (2 n,) of the model equations' state from rest, at the start."""
        shape = self.shape[self.rows]
        q, v = np.split(np.abs(shape), 2)
        return AMPLITUDE * shape / max(np.max(q), np.max(v) / fastest_rate(self.at))

    @property
    def case(self) -> Case:
        """The case that starts off a state of rest as the vibration does."""
        setup, own = self.setup, self.setup.bound.equations.scene
        values = dict(zip(own.state_names, (self.at.state + self.departure).tolist(), strict=True))
        if own is setup.scene or setup.scene.discretisation_coordinates:
            return replace(setup.case, state=values)
        # a soft loop: the scene's own coordinates, and how far the others are from closing it
        names = setup.scene.state_names
        case = replace(setup.case, state={name: values[name] for name in names})
        closed = dict(zip(own.state_names, setup.bound.equations.start(case).tolist(), strict=True))
        apart = {name: values[name] - closed[name] for name in values if name not in names}
        return replace(case, inconsistency=apart)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Observables that are compared.

        If a coordinate is free to drift, turning angles drift with the round-off of their speed,
        and only their rates are compared.
        """
        drifting = self.setup.scene.rotations_per_period if np.any(self.at.rates == 0) else ()
        known = set(self.setup.bound.equations.scene.observables) - set(drifting)
        return tuple(name for name in self.setup.scene.observables if name in known)

    @cached_property
    def linear(self) -> tuple[Array, Array, Array]:
        """Observables at rest (k,), their slopes (k, 2 n), and their sizes (k,) in the vibration.

        An observable that hardly moves has an infinite size.
        """
        equations = self.setup.bound.equations
        rest, slopes = by_complex_step(lambda x: rows(equations, x, self.names), self.at.state)
        matrix = first_order(self.at.matrices)[np.ix_(self.rows, self.rows)]
        advance = expm(matrix * (2 * np.pi / fastest_rate(self.at) / 16))
        x, size = self.departure, np.abs(slopes @ self.departure)
        for _ in range(32):
            x = advance @ x
            size = np.maximum(size, np.abs(slopes @ x))
        return rest, slopes, np.where(size > 1e-6 * np.max(size), size, np.inf)

    def largest(self, values: Array) -> float:
        """Return the largest departure (k, n_t) of an observable, in the size that it has."""
        if not np.all(np.isfinite(values)):
            return np.inf
        with np.errstate(all="ignore"):
            return float(np.max(np.abs(values) / self.linear[2][:, None]))

    def by_run(self, step: float, horizon: float) -> float:
        """Run the engine and return the largest departure, in the size that it really has.

        Raises
        ------
        EngineError
            Of the engine or the guard.
        """
        run = self.setup.with_case(self.case).simulate(step, step_numbers(step, horizon))
        return self.largest(run.matrix(self.names) - self.linear[0][:, None])

    def by_matrix(self, step: float, horizon: float) -> float:
        """Return the largest departure by the amplification matrix."""
        matrix = AMPLIFICATION[self.scheme](self.at.matrices, step)
        width, x = len(self.at.coordinates), np.zeros(len(matrix))
        x[self.rows] = self.departure
        if len(matrix) > 2 * width:  # generalized-alpha carries accelerations
            x[2 * width :] = (first_order(self.at.matrices) @ x[: 2 * width])[width:]
        numbers = step_numbers(step, horizon)
        with np.errstate(all="ignore"):
            advance = np.linalg.matrix_power(matrix, int(numbers[0]))
            states = (advance @ x)[:, None]
            while states.shape[1] < len(numbers):  # twice as many each time
                states = np.hstack([states, advance @ states])
                advance = advance @ advance
            return self.largest(self.linear[1] @ states[self.rows, : len(numbers)])

    def grows_in_run(self, step: float, horizon: float) -> bool:
        """Run the engine; return True if the vibration grows, or the guard stops it.

        Raises
        ------
        EngineError
            ``step``, where the engine refuses it.
        """
        try:
            return self.by_run(step, horizon) > GROWTH
        except EngineError as error:
            if error.kind == "step":
                raise
            return True


def step_numbers(step: float, horizon: float) -> NDArray[np.int_]:
    """Return at which steps a run is sampled: evenly spread, at most `SEEN`."""
    count = max(2, math.ceil(horizon / step))
    every = math.ceil(count / SEEN)
    return every * np.arange(1, count // every + 1)
