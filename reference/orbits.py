"""Periodic orbits by shooting: monodromy, Floquet multipliers, harmonics, power balance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .errors import NoOrbitError
from .scene import Array, Scene
from .solve.batched import solve_many
from .solve.flow import converged_steps, rk8_steps, transition_matrix

MOST_ITERATIONS = 40
CLOSED = 1e-11
"""Largest scaled Newton correction of an orbit that counts as found."""

ISOLATED = 1e-6
"""Largest scaled rounding of an orbit that counts as found."""


@dataclass(frozen=True)
class Orbits:
    """Periodic orbits over parameter points.

    Attributes
    ----------
    states : array (2 n, ...)
        State where the period begins; NaN where no orbit was found.
    periods : array (...) [s]
    multipliers : complex array (2 n, ...)
        Floquet multipliers, descending in modulus.
    monodromy : array (2 n, 2 n, ...)
    closing : array (..., 2 n, 2 n)
        What Newton's method inverts, scaled: the monodromy less the identity, with the
        section's column replaced by the change with the period.
    found : bool array (...)
    """

    states: Array
    periods: Array
    multipliers: Any
    monodromy: Array
    closing: Array
    found: Any


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
    error_bound : array (2 n,)
        Bound on the error of ``state``.
    trivial : int or None
        Which multiplier is the one of a shift in time, 1 where nothing drives the scene.
    """

    period: float
    state: Array
    multipliers: Any
    monodromy: Array
    error_bound: Array
    trivial: int | None = None

    @property
    def stable(self) -> bool:
        """True if every multiplier but the trivial one lies inside the unit circle."""
        own = [value for i, value in enumerate(self.multipliers) if i != self.trivial]
        return bool(np.all(np.abs(own) < 1))


def turn(scene: Scene, ndim: int = 0) -> Array:
    """Advance of the state over one period, shape (2 n, 1, ...) with ``ndim`` ones."""
    advance = [2 * np.pi * scene.turning.get(name, 0) for name in scene.state_names]
    return np.array(advance).reshape(-1, *(1,) * ndim)


def trivial_multiplier(scene: Scene, multipliers: Any) -> Any:
    """Return which multiplier (2 n, ...) is that of a shift in time, None with a drive."""
    return None if scene.section is None else np.argmin(np.abs(multipliers - 1), axis=0)


def state_scale(scene: Scene, state: Array, omega: Any) -> Array:
    """Size of each state over an orbit: coordinate amplitude, and omega times that."""
    n = len(scene.coordinates)
    turning = np.array([2 * np.pi * (name in scene.turning) for name in scene.coordinates])
    size = np.hypot(state[:n], state[n:] / omega)
    size = np.maximum(size, turning.reshape(-1, *(1,) * (state.ndim - 1)))
    size = np.where(size > 0, size, 1.0)
    return np.concatenate([size, omega * size])


def shoot(
    scene: Scene, parameters: Any, guess: Array, steps: int = 0, period: Any = None
) -> Orbits:
    """Newton's method on the period map, vectorised over parameter points.

    Where nothing drives the scene, the period is unknown and the section's coordinate
    stays at its guess.

    Parameters
    ----------
    scene : Scene
    parameters : Parameters of the scene
        Fields may be arrays over points (one axis).
    guess : array (2 n, ...)
    steps : int
        Integration steps per period; 0 chooses them by halving.
    period : array (...), optional
        The period of the drive, or a guess [s]; by default ``scene.period``.

    Returns
    -------
    Orbits
    """
    period = scene.period(parameters) if period is None else period
    period = np.array(np.broadcast_to(period, guess.shape[1:]), dtype=float)
    state = np.array(guess, dtype=float)
    scale = state_scale(scene, state, 2 * np.pi / period)
    advance = turn(scene, state.ndim - 1)
    row = None if scene.section is None else scene.coordinates.index(scene.section)
    derivative = scene.right_hand_side(parameters)
    found = np.zeros(state.shape[1:], dtype=bool)
    steps = steps or converged_steps(scene, parameters, state, period)
    identity = np.eye(len(state))
    jacobian = np.full((len(state), *state.shape), np.nan)
    with np.errstate(all="ignore"):
        for _ in range(MOST_ITERATIONS):
            flow, jacobian = transition_matrix(scene, parameters, state, period, 0.0, steps)
            residual = (flow - state - advance) / scale
            scaled = jacobian * scale[None] / scale[:, None]
            matrix = np.moveaxis(scaled, (0, 1), (-2, -1)) - identity
            if row is not None:
                speed = derivative(period, flow) * period / scale
                matrix[..., row] = np.moveaxis(speed, 0, -1)
            usable = np.all(np.isfinite(matrix), axis=(-2, -1))
            closing = np.where(usable[..., None, None], matrix, identity)
            change = -np.einsum("...ij,j...->i...", np.linalg.pinv(closing), residual)
            size = np.max(np.abs(change), axis=0)
            size = np.where(usable & np.isfinite(size), size, np.inf)
            found |= size < CLOSED
            change = np.where(np.isfinite(size), change, 0.0) * np.minimum(1, 0.1 / size)
            if row is not None:
                period = period * (1 + change[row])
                change[row] = 0.0
            state = state + change * scale
            if np.all(found | ~np.isfinite(size)):
                break
    monodromy = np.where(found, jacobian, np.nan)
    square = np.where(found[..., None, None], np.moveaxis(jacobian, (0, 1), (-2, -1)), identity)
    multipliers = np.moveaxis(np.linalg.eigvals(square), -1, 0).astype(complex)
    order = np.argsort(-np.abs(multipliers), axis=0)
    multipliers = np.where(found, np.take_along_axis(multipliers, order, axis=0), np.nan)
    for i, name in enumerate(scene.coordinates):
        if name in scene.turning:
            state[i] %= 2 * np.pi
    return Orbits(
        np.where(found, state, np.nan),
        np.where(found, period, np.nan),
        multipliers,
        monodromy,
        closing,
        found,
    )


def find_orbit(scene: Scene, parameters: Any) -> Orbit:
    """Find the periodic orbit; a stable one where there is a choice.

    The scene's first guess is tried alone, then all of its guesses, then states that many
    periods of motion from several phases have led to.

    Raises
    ------
    NoOrbitError
        If the search ends without an orbit of the wanted kind.
    """
    candidates = scene.orbit_guesses(parameters)
    if not candidates:
        raise NoOrbitError(f"{scene.name} has no periodic orbit to look for: nothing drives it on")
    guesses = np.stack(candidates, axis=1)
    period = np.full(guesses.shape[1], float(scene.period(parameters)))
    orbit = _refined(scene, parameters, guesses[:, 0], period[0])
    if orbit is None or not orbit.stable:
        orbit = _best(scene, parameters, guesses, period)
    if orbit is None or not orbit.stable:
        settled = _best(scene, parameters, *_settle(scene, parameters, guesses, period[0]))
        orbit = settled if settled is not None and (orbit is None or settled.stable) else orbit
    if orbit is None:
        turns = ", ".join(f"{k} turning {n} time(s)" for k, n in scene.turning.items())
        cure = (
            "a larger drive amplitude or a lower frequency may have one"
            if scene.section is None
            else "a larger torque or less friction may have one"
        )
        raise NoOrbitError(
            f"no periodic orbit of {scene.name} with {turns or 'these parameters'} per period "
            f"was found; {cure}"
        )
    return orbit


def _settle(
    scene: Scene, parameters: Any, guesses: Array, period: float, periods: int = 60
) -> tuple[Array, Array]:
    """States after many periods from the guesses, moved to eight phases each; their periods."""
    starts = []
    for i, name in enumerate(scene.coordinates):
        if name in scene.turning and name != scene.section:
            for phase in np.arange(8) * np.pi / 4:
                shifted = guesses.copy()
                shifted[i] += phase
                starts.append(shifted)
    states = np.concatenate(starts or [guesses], axis=1)
    steps = min(converged_steps(scene, parameters, guesses, period, tolerance=1e-4), 128)
    derivative = scene.right_hand_side(parameters)
    with np.errstate(all="ignore"):
        before = rk8_steps(derivative, states, 0.0, periods * period, periods * steps)
        if scene.section is None:
            usable = np.all(np.isfinite(before), axis=0)
            return before[:, usable], np.full(int(np.sum(usable)), period)
        row = scene.coordinates.index(scene.section)
        watched = 8
        states = rk8_steps(derivative, before, 0.0, watched * period, watched * steps)
        turns = (states[row] - before[row]) / (2 * np.pi)
        for _ in range(3):  # on to the section, by Newton's method in time
            missing = 2 * np.pi * np.ceil(states[row] / (2 * np.pi) - 0.5) - states[row]
            rate = states[len(scene.coordinates) + row]
            states = rk8_steps(derivative, states, 0.0, missing / rate, steps)
        states[row] = 0.0
        usable = np.all(np.isfinite(states), axis=0) & (turns > 1)
        return states[:, usable], watched * period / turns[usable]


def _best(scene: Scene, parameters: Any, guesses: Array, period: Array) -> Orbit | None:
    """The orbit with the smallest leading multiplier that the guesses lead to."""
    if not guesses.shape[1]:
        return None
    steps = converged_steps(scene, parameters, guesses, period, tolerance=1e-6)
    coarse = shoot(scene, parameters, guesses, steps, period)
    if not np.any(coarse.found):
        return None
    moduli = np.abs(coarse.multipliers)
    if scene.section is not None:
        trivial = trivial_multiplier(scene, np.where(coarse.found, coarse.multipliers, 1))
        np.put_along_axis(moduli, trivial[None], 0.0, axis=0)
    best = int(np.argmin(np.where(coarse.found, np.max(moduli, axis=0), np.inf)))
    return _refined(scene, parameters, coarse.states[:, best], coarse.periods[best])


def follow_orbit(scene: Scene, parameters: Any, near: Orbit) -> Orbit:
    """Return the orbit that one of slightly other parameters goes over into.

    Raises
    ------
    NoOrbitError
        If it does not.
    """
    period = None if scene.section is None else near.period
    orbit = _refined(scene, parameters, near.state, period)
    if orbit is None:
        raise NoOrbitError(f"the periodic orbit of {scene.name} does not continue")
    return orbit


def _refined(scene: Scene, parameters: Any, start: Array, period: Any) -> Orbit | None:
    """The orbit that Newton's method finds from a state, at full accuracy.

    Rounding of the flow (1e-15 of each state, times the growth over a period) is divided
    by the smallest singular value of the matrix that closes the orbit. Where that leaves
    more than `ISOLATED` of error, the orbit is one of a family and no state of it is meant.
    """
    fine = shoot(scene, parameters, start, period=period)
    if not fine.found:
        return None
    scale = state_scale(scene, fine.states, 2 * np.pi / fine.periods)
    scaled = fine.monodromy * scale / scale[:, None]
    smallest = np.linalg.svd(fine.closing, compute_uv=False)[-1]
    if smallest == 0:
        return None
    rounding = 1e-14 * (1 + 1 / smallest) * max(1.0, float(np.linalg.norm(scaled, 2)))
    if rounding > ISOLATED:
        return None
    trivial = trivial_multiplier(scene, fine.multipliers)
    return Orbit(
        period=float(fine.periods),
        state=fine.states,
        multipliers=fine.multipliers,
        monodromy=fine.monodromy,
        error_bound=rounding * scale,
        trivial=None if trivial is None else int(trivial),
    )


@dataclass(frozen=True)
class Harmonic:
    """One term ``amplitude cos(order Omega t + phase)`` of a Fourier series."""

    order: int
    amplitude: float
    phase: float


def orbit_samples(scene: Scene, parameters: Any, orbit: Orbit, count: int = 256) -> Array:
    """States over one period at ``i T / count``, shape (2 n, count)."""
    times = np.arange(count) * orbit.period / count
    solution = solve_many(scene, parameters, orbit.state, times, tolerance=1e-12)
    return solution.states


def harmonics(
    values: Array, turns: int = 0, highest: int = 6
) -> tuple[float, tuple[Harmonic, ...]]:
    """Mean and harmonics of one observable sampled uniformly over one period.

    Parameters
    ----------
    values : array (count,)
        ``count`` even, the end of the period left out.
    turns : int
        Turns per period, whose secular part ``turns Omega t`` is removed first.
    highest : int
        Highest order returned.
    """
    count = len(values)
    periodic = values - 2 * np.pi * turns * np.arange(count) / count
    spectrum = np.fft.rfft(periodic) / count
    terms = tuple(
        Harmonic(k, float(2 * abs(spectrum[k])), float(np.angle(spectrum[k])))
        for k in range(1, highest + 1)
    )
    return float(spectrum[0].real), terms


def mean_powers(scene: Scene, parameters: Any, orbit: Orbit, samples: Array) -> dict[str, float]:
    """Mean power [W] of each non-conservative force over the orbit, from uniform samples."""
    c = scene.coefficients(parameters)
    n = len(scene.coordinates)
    times = np.arange(samples.shape[1]) * orbit.period / samples.shape[1]
    u = scene.drive(times, c, np) if scene.drive else 0.0
    powers = scene.powers(u, samples[:n], samples[n:], c)
    return {name: float(np.mean(values)) for name, values in powers.items()}
