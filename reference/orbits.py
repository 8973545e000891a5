"""Periodic orbits: Newton's method on the period map, Floquet multipliers, harmonics, powers.

`PeriodMap.close` is what references, engines and maps find their periodic orbits by; they differ in
the flow that they hand it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .differences import by_complex_step, by_differences
from .errors import NoOrbitError
from .newton import NEWTON, Effort, Rows, newton
from .scene import Array, EquationsOfMotion, PeriodicOrbit, coefficients_at
from .solve.batched import converged_steps
from .solve.rk8 import rk8_samples, rk8_steps

WAITS = (60, 10, 10)
"""Periods of motion between searches for a stable orbit: a small basin may be missed by chance."""

ISOLATED = 1e-6
"""Largest scaled rounding of an orbit that counts as one."""

Flow = Callable[[Rows, Any, Any], Any]
"""Function of points (k,), states (2 n, k) and periods (k,) [s]: the states a period later."""


@dataclass(frozen=True)
class PeriodMap:
    """The flow of points over one period, about a guess of the periodic orbit of each.

    Unknowns are departures of the states from the guess in their sizes; where nothing drives the
    scene, the period is unknown, and its relative change takes the place of the section's
    coordinate, which stays.

    Attributes
    ----------
    flow : Flow
    states : array (2 n, k)
        Guesses of where the period begins.
    periods : array (k,)
        The periods of the drive, or guesses [s].
    scale : array (2 n, k)
        Size of each state.
    advance : array (2 n, 1)
        By how much a period advances the states: coordinates that rotate are turns ahead.
    section : int or None
        Row of the section's coordinate.
    order : int or None
        Order of the differences that the Jacobian comes from; None takes complex steps.
    step : float or None
        Of these differences, in the size of each state.
    """

    flow: Flow
    states: Array
    periods: Array
    scale: Array
    advance: Array
    section: int | None = None
    order: int | None = None
    step: float | None = None

    def residual(self, rows: Rows, unknowns: Array) -> Array:
        """Return by how far the orbits of points (k,) do not close, in the size of each state."""
        return np.asarray(self._left(rows, unknowns[:, None])[:, 0])

    def linearise(self, rows: Rows, unknowns: Array) -> tuple[Array, Array]:
        """Return the same with its slopes (k, 2 n, 2 n), and a last column for the period."""
        if self.section is not None:
            unknowns = np.concatenate([unknowns, unknowns[None, self.section]])
            unknowns[self.section] = 0.0
        left = partial(self._left, rows)
        if self.order is None:
            value, slopes = by_complex_step(left, unknowns)
        else:
            value, slopes = by_differences(left, unknowns, self.order, self.step)
        return value, np.moveaxis(slopes, -1, 0)

    def place(self, rows: Rows, unknowns: Any) -> tuple[Any, Any]:
        """Return states (2 n, lanes, k) and periods (lanes, k) from unknowns (m, lanes, k).

        The last of 2 n + 1 unknowns is the period; of 2 n, that in the section's place.
        """
        n = len(self.states)
        departures, change = unknowns[:n].copy(), np.zeros(unknowns.shape[1:])
        if len(unknowns) > n:
            change = unknowns[n]
        elif self.section is not None:
            change, departures[self.section] = departures[self.section].copy(), 0.0
        states = self.states[:, None, rows] + departures * self.scale[:, None, rows]
        return states, self.periods[rows] * (1 + change)

    def _left(self, rows: Rows, unknowns: Any) -> Any:
        states, periods = self.place(rows, unknowns)
        n, lanes = states.shape[:2]
        ends = self.flow(np.tile(rows, lanes), states.reshape(n, -1), periods.reshape(-1))
        left = ends.reshape(states.shape) - states - self.advance[:, None]
        return left / self.scale[:, None, rows]

    def close(self, effort: Effort = NEWTON, slopes: Array | None = None) -> Orbits:
        """Return the periodic orbits that Newton's method finds from the guesses.

        Parameters
        ----------
        effort : Effort
        slopes : array (k, 2 n, 2 n (+ 1)), optional
            `Orbits.slopes` that are known already; they serve first.
        """
        columns = np.arange(len(self.states))
        if self.section is not None:
            columns[self.section] = len(self.states)
        start = np.zeros_like(self.states)
        roots = newton(self.residual, self.linearise, start, effort, slopes, columns)
        states, periods = self.place(np.arange(start.shape[1]), roots.unknowns[:, None])
        return Orbits(
            states=states[:, 0],
            periods=periods[0],
            closed=roots.closed,
            correction=roots.size,
            slopes=roots.jacobians,
            scale=self.scale,
            columns=columns,
        )


@dataclass(frozen=True)
class Orbits:
    """Result of Newton's method on the period maps of points.

    Attributes
    ----------
    states : array (2 n, k)
        State where the period begins.
    periods : array (k,) [s]
    closed : bool array (k,)
        Which are periodic orbits.
    correction : array (k,)
        Size of Newton's last one; infinite where the point was lost.
    slopes : array (k, 2 n, 2 n (+ 1))
        Of what does not close: by the states and, in a last column, by the period; in their sizes.
    scale : array (2 n, k)
        These sizes.
    columns : int array (2 n,)
        Columns of the slopes that Newton's method inverts.
    """

    states: Array
    periods: Array
    closed: NDArray[np.bool_]
    correction: Array
    slopes: Array
    scale: Array
    columns: Rows

    def at(self, rows: Any) -> Orbits:
        """Return those of some points."""
        return Orbits(
            states=self.states[:, rows],
            periods=self.periods[rows],
            closed=self.closed[rows],
            correction=self.correction[rows],
            slopes=self.slopes[rows],
            scale=self.scale[:, rows],
            columns=self.columns,
        )

    def put(self, rows: Any, others: Orbits) -> None:
        """Replace those of some points by as many others."""
        self.states[:, rows], self.scale[:, rows] = others.states, others.scale
        self.periods[rows], self.closed[rows] = others.periods, others.closed
        self.correction[rows], self.slopes[rows] = others.correction, others.slopes

    @property
    def closing(self) -> Array:
        """Matrices (k, 2 n, 2 n) of Newton's method."""
        return self.slopes[..., self.columns]

    @property
    def monodromy(self) -> Array:
        """Jacobians of the period maps (k, 2 n, 2 n), in the sizes of the states."""
        n = len(self.states)
        return np.asarray(self.slopes[..., :n] + np.eye(n))

    @property
    def multipliers(self) -> Any:
        """Floquet multipliers (2 n, k), descending in modulus; NaN where no orbit has closed."""
        values = np.full(self.states.shape, np.nan, dtype=complex)
        values[:, self.closed] = descending(np.linalg.eigvals(self.monodromy[self.closed]).T)
        return values

    @property
    def leading(self) -> Array:
        """Largest modulus (k,) of the multipliers, that of a shift in time left out.

        Infinite where no orbit has closed.
        """
        values = np.where(self.closed, self.multipliers, np.inf)
        if len(self.states) in self.columns:  # the period is an unknown: nothing drives the scene
            trivial = np.argmin(np.abs(values - 1), axis=0)
            np.put_along_axis(values, trivial[None], 0.0, axis=0)
        return np.where(self.closed, np.max(np.abs(values), axis=0), np.inf)


def descending(multipliers: Any) -> Any:
    """Return multipliers (2 n, ...) in descending order of their moduli."""
    order = np.argsort(-np.abs(multipliers), axis=0)
    return np.take_along_axis(multipliers.astype(complex), order, axis=0)


@dataclass(frozen=True)
class Orbit:
    """One periodic orbit.

    Attributes
    ----------
    period : float [s]
    state : array (2 n,)
        Where the period begins: at t = 0 modulo the period of the drive, or on the
        scene's section; turning coordinates in [0, 2 pi).
    multipliers : complex array (2 n,)
    monodromy : array (2 n, 2 n)
    trivial : int or None
        Which multiplier is the one of a shift in time, 1 where nothing drives the scene.
    steps : int
        Of the reference's method in the period; 0 where an engine took them.
    """

    period: float
    state: Array
    multipliers: Any
    monodromy: Array
    trivial: int | None = None
    steps: int = 0

    @property
    def stable(self) -> bool:
        """True if every multiplier but the trivial one lies inside the unit circle."""
        own = [value for i, value in enumerate(self.multipliers) if i != self.trivial]
        return bool(np.all(np.abs(own) < 1))


def period_advance(scene: EquationsOfMotion) -> Array:
    """Advance (2 n, 1) of the states over one period: whole turns."""
    return np.array(
        [[2 * np.pi * scene.rotations_per_period.get(name, 0)] for name in scene.state_names]
    )


def trivial_multiplier(scene: EquationsOfMotion, multipliers: Any) -> Any:
    """Return which multiplier (2 n, ...) is that of a shift in time, None with a drive."""
    return (
        None
        if scene.orbit.section_coordinate is None
        else np.argmin(np.abs(multipliers - 1), axis=0)
    )


def state_scale(scene: EquationsOfMotion, state: Array, omega: Any) -> Array:
    """Size of each state (2 n, ...) over an orbit: coordinate amplitude, and omega times that."""
    n = len(scene.coordinates)
    turns = np.array(
        [2 * np.pi * (name in scene.rotations_per_period) for name in scene.coordinates]
    )
    size = np.hypot(state[:n], state[n:] / omega)
    size = np.maximum(size, turns.reshape(-1, *(1,) * (state.ndim - 1)))
    size = np.where(size > 0, size, 1.0)
    return np.concatenate([size, omega * size])


def section_row(scene: EquationsOfMotion) -> int | None:
    """Return the row of the coordinate that vanishes where a period begins; None with a drive."""
    return (
        None
        if scene.orbit.section_coordinate is None
        else scene.coordinates.index(scene.orbit.section_coordinate)
    )


def wrapped_rotations(scene: EquationsOfMotion, states: Array) -> Array:
    """Return states (2 n, ...), the coordinates that rotate in [0, 2 pi)."""
    rows = [i for i, name in enumerate(scene.coordinates) if name in scene.rotations_per_period]
    wrapped = np.array(states)
    wrapped[rows] %= 2 * np.pi
    return wrapped


def shoot(
    scene: EquationsOfMotion, parameters: Any, guesses: Array, steps: int = 0, period: Any = None
) -> Orbits:
    """Find the periodic orbits of points by the reference's own flow.

    Parameters
    ----------
    scene : EquationsOfMotion
    parameters : Parameters of the scene
        Fields may be arrays over points.
    guesses : array (2 n, k)
    steps : int
        Integration steps per period; 0 chooses them by halving.
    period : array (k,), optional
        The period of the drive, or a guess [s]; by default ``scene.period``.
    """
    period = scene.period(parameters) if period is None else period
    period = np.array(np.broadcast_to(period, guesses.shape[1:]), dtype=float)
    steps = steps or converged_steps(scene, parameters, guesses, period)
    orbits = reference_map(scene, scene.coefficients(parameters), guesses, period, steps).close()
    return replace(orbits, states=wrapped_rotations(scene, orbits.states))


def reference_map(
    scene: EquationsOfMotion, c: Any, states: Array, periods: Array, steps: int
) -> PeriodMap:
    """Return the reference's period map about states (2 n, k) with periods (k,)."""

    def flow(rows: Rows, states: Any, periods: Any) -> Any:
        return rk8_steps(scene.derivative(coefficients_at(c, rows)), states, 0.0, periods, steps)

    scale = state_scale(scene, states, 2 * np.pi / periods)
    return PeriodMap(flow, states, periods, scale, period_advance(scene), section_row(scene))


def why_none(scene: EquationsOfMotion) -> str:
    """Return the reason why the search for a periodic orbit has no start."""
    sought = scene.orbit.guesses is not PeriodicOrbit.guesses
    return "nothing drives it on" if sought else "none is sought of this scene"


def hidden_by_rounding(scene: EquationsOfMotion) -> str:
    """Return the message for an orbit that exists, but whose state rounding leaves unknown."""
    return (
        f"the periodic orbit of {scene.name} is so nearly one of a family, or so near the end "
        "of its branch, that rounding hides it"
    )


def find_orbit(scene: EquationsOfMotion, parameters: Any) -> Orbit:
    """Find the periodic orbit; a stable one where there is a choice.

    The scene's first guess is tried alone, then all of its guesses, then states that many
    periods of motion from several phases have led to.

    Raises
    ------
    NoOrbitError
        If the search ends without an orbit of the wanted kind.
    """
    candidates = scene.orbit.guesses(parameters)
    if not candidates:
        raise NoOrbitError(f"{scene.name} has no periodic orbit to look for: {why_none(scene)}")
    guesses = np.stack(candidates, axis=1)
    period = np.full(guesses.shape[1], float(scene.period(parameters)))
    known = scene.orbit.known(parameters)
    orbit = _accurate(scene, parameters, *(known or (guesses[:, 0], period[0])))
    if known and orbit is None:
        raise NoOrbitError(hidden_by_rounding(scene))
    if orbit is None or not orbit.stable:
        orbit = _most_stable(scene, parameters, guesses, period)
    if orbit is None or not orbit.stable:
        for ends in _long_after(scene, parameters, guesses, period[0]):
            other = _most_stable(scene, parameters, *ends)
            orbit = other if other is not None and (orbit is None or other.stable) else orbit
            if orbit is not None and orbit.stable:
                break
    if orbit is None:
        turns = ", ".join(f"{k} turning {n} time(s)" for k, n in scene.rotations_per_period.items())
        cure = (
            "a larger drive amplitude or a lower frequency may have one"
            if scene.orbit.section_coordinate is None
            else "a larger torque or less friction may have one"
        )
        raise NoOrbitError(
            f"no periodic orbit of {scene.name} with {turns or 'these parameters'} per period "
            f"was found; {cure}"
        )
    return orbit


def _long_after(
    scene: EquationsOfMotion, parameters: Any, guesses: Array, period: float
) -> Iterator[tuple[Array, Array]]:
    """Yield states after `WAITS` periods from the guesses, moved to eight phases each; periods."""
    starts = []
    for i, name in enumerate(scene.coordinates):
        if name in scene.rotations_per_period and name != scene.orbit.section_coordinate:
            for phase in np.arange(8) * np.pi / 4:
                shifted = guesses.copy()
                shifted[i] += phase
                starts.append(shifted)
    states = np.concatenate(starts or [guesses], axis=1)
    steps = min(converged_steps(scene, parameters, guesses, period, tolerance=1e-4), 128)
    derivative = scene.right_hand_side(parameters)
    row = section_row(scene)
    for periods in WAITS:
        with np.errstate(all="ignore"):
            states = rk8_steps(derivative, states, 0.0, periods * period, periods * steps)
            at, spans = states, np.full(states.shape[1], period)
            if row is not None:
                turns = np.floor(at[row] / (2 * np.pi)) + 1
                _, at = _turn(derivative, at, row, 2 * np.pi * turns - at[row], steps)
                at[row] = 0.0
                spans, ends = _turn(derivative, at, row, 2 * np.pi, steps)
                at[:, ~np.isfinite(ends[row])] = np.nan
        usable = np.all(np.isfinite(at), axis=0) & (spans > 0)
        yield at[:, usable], spans[usable]


def _turn(
    derivative: Callable[[Any, Any], Any], states: Array, row: int, angle: Any, steps: int
) -> tuple[Array, Array]:
    """Follow states (2 n, k) while one coordinate turns by an angle; the times (k,) [s] and ends.

    The angle takes the place of time, so that the ends lie on a section however slow the turn is.
    """

    def slopes(_: Any, x: Array) -> Array:
        rates = derivative(0.0, x[1:])
        return np.concatenate([np.ones_like(rates[:1]), rates]) / rates[row]

    start = np.concatenate([np.zeros_like(states[:1]), states])
    ends = rk8_steps(slopes, start, 0.0, angle, steps)
    return ends[0], ends[1:]


def _most_stable(
    scene: EquationsOfMotion, parameters: Any, guesses: Array, period: Array
) -> Orbit | None:
    """The orbit with the smallest leading multiplier that the guesses lead to."""
    if not guesses.shape[1]:
        return None
    steps = converged_steps(scene, parameters, guesses, period, tolerance=1e-6)
    coarse = shoot(scene, parameters, guesses, steps, period)
    if not np.any(coarse.closed):
        return None
    best = int(np.argmin(coarse.leading))
    return _accurate(scene, parameters, coarse.states[:, best], coarse.periods[best])


def _accurate(scene: EquationsOfMotion, parameters: Any, start: Array, guess: Any) -> Orbit | None:
    """The orbit that Newton's method finds from a state, at full accuracy.

    Its error is the rounding of the flow (1e-15 of each state, times the growth over a period) over
    the smallest singular value of the matrix that closes the orbit. Above `ISOLATED` the orbit is
    one of a family. Newton's slopes precede its last correction, so it begins again at the orbit.
    """
    span = scene.period(parameters) if guess is None else guess
    steps = converged_steps(scene, parameters, start, float(span))
    fine = shoot(scene, parameters, start[:, None], steps, guess)
    if fine.closed[0]:
        fine = shoot(scene, parameters, fine.states, steps, fine.periods)
    if not fine.closed[0]:
        return None
    if not (smallest := np.linalg.svd(fine.closing[0], compute_uv=False)[-1]):
        return None
    growth = np.linalg.norm(np.linalg.solve(fine.closing[0], fine.monodromy[0]), 2)
    rounding = 1e-14 * (1 + 1 / smallest + float(growth))
    if rounding > ISOLATED:
        return None
    state, period = fine.states[:, 0], float(fine.periods[0])
    multipliers, unit = fine.multipliers[:, 0], fine.scale[:, 0]
    trivial = trivial_multiplier(scene, multipliers)
    return Orbit(
        period=period,
        state=state,
        multipliers=multipliers,
        monodromy=fine.monodromy[0] * unit[:, None] / unit,
        trivial=None if trivial is None else int(trivial),
        steps=steps,
    )


def orbit_samples(
    scene: EquationsOfMotion, parameters: Any, orbit: Orbit, count: int = 256
) -> Array:
    """States over one period at ``i T / count``, shape (2 n, count)."""
    steps = orbit.steps or converged_steps(scene, parameters, orbit.state, orbit.period)
    derivative, times = scene.right_hand_side(parameters), np.arange(count) * orbit.period / count
    rest = rk8_samples(derivative, orbit.state, 0.0, times[1:], -(-steps // count))
    return np.concatenate([orbit.state[:, None], rest], axis=1)


def mean_powers(
    scene: EquationsOfMotion, samples: Array, c: Any, period: float
) -> dict[str, float]:
    """Mean power [W] of each non-conservative force over an orbit, from uniform samples."""
    n = len(scene.coordinates)
    times = np.arange(samples.shape[1]) * period / samples.shape[1]
    u = scene.drive(times, c, np) if scene.drive else 0.0
    powers = scene.powers(u, samples[:n], samples[n:], c)
    return {name: float(np.mean(values)) for name, values in powers.items()}
