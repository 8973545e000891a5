"""Bounds on the errors of a periodic orbit: period, state, multipliers, what it is measured by.

Newton's method leaves a residual of the period map, which itself is off by what integration and
rounding of its coefficients do; the inverse of its Jacobian tells how far the true orbit may be
(Kantorovich). Each source of error is followed by itself: the orbit is displaced as the source
displaces it, and what that changes of multipliers, samples and quantities is added up.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import eig

from ..differences import EPS
from ..errors import NoOrbitError
from ..newton import Rows
from ..orbits import Orbit, PeriodMap, mean_powers, period_advance, section_row, state_scale
from ..periodic import spectrum_of
from ..scene import Array, EquationsOfMotion, coefficients_at
from ..solve.rk8 import rk8_steps
from .modes import COEFFICIENT, pair_bounds, separations

DISPLACEMENT = 1e-7
"""Of orbits, in the size of each state: changes are linear there, and rounding small in them."""

ROUNDING = 3 * EPS
"""Of a period's end, in the sizes of the states, beside what two numbers of steps differ by."""

STEP_ROUNDING = 2 * EPS
"""What each step adds to it, at random: half a unit in each of its 13 stages."""

CURVED = 0.25
"""Relative change of the period map's Jacobian within the orbit's error that makes it unknown."""

COUNT = 256
"""Samples of a period."""


@dataclass(frozen=True)
class OrbitBounds:
    """Bounds on the errors of a periodic orbit.

    Attributes
    ----------
    period : float [s]
    state : array (2 n,)
    multipliers : array (2 n,)
    power, quantities : mapping of str to float
    harmonics : array (2 n,)
        Of each state's mean, and of the complex amplitudes of its harmonics.
    """

    period: float
    state: Array
    multipliers: Array
    power: Mapping[str, float]
    quantities: Mapping[str, float]
    harmonics: Array


@dataclass(frozen=True)
class Neighbours:
    """The orbit, and beside it those that it is displaced to by one source of error each.

    Attributes
    ----------
    unknowns : array (2 n, k)
        Displacements, in the unknowns of `PeriodMap`; of the orbit itself, 0.
    coefficients : NamedTuple of arrays (k,)
    weights : array (k,)
        The source in units of the displacement; of the orbit itself, 0.
    """

    unknowns: Array
    coefficients: Any
    weights: Array

    def changes(self, values: Array) -> Array:
        """Return what all sources together may change of values (k, ...)."""
        return np.tensordot(self.weights, np.abs(values - values[0]), 1)


@dataclass(frozen=True)
class Closing:
    """The period map about an orbit, in so many steps."""

    scene: EquationsOfMotion
    orbit: Orbit
    steps: int

    @property
    def scale(self) -> Array:
        """Sizes (2 n,) of the states."""
        return state_scale(self.scene, self.orbit.state, 2 * np.pi / self.orbit.period)

    def about(self, c: Any, count: int) -> PeriodMap:
        """Return the period map of so many points about the orbit."""

        def flow(rows: Rows, states: Any, periods: Any) -> Any:
            derivative = self.scene.derivative(coefficients_at(c, rows))
            return rk8_steps(derivative, states, 0.0, periods, self.steps)

        states, scale = (np.repeat(x[:, None], count, 1) for x in (self.orbit.state, self.scale))
        advance, section = period_advance(self.scene), section_row(self.scene)
        return PeriodMap(flow, states, np.full(count, self.orbit.period), scale, advance, section)

    def linearise(self, c: Any, unknowns: Array) -> tuple[Array, Array]:
        """Return by how far points (2 n, k) do not close, in their sizes, and the slopes."""
        count = unknowns.shape[1]
        return self.about(c, count).linearise(np.arange(count), unknowns)

    def samples(self, at: Neighbours) -> Array:
        """Return states (k, 2 n, `COUNT`) over one period."""
        count = len(at.weights)
        parts = self.about(at.coefficients, count).place(np.arange(count), at.unknowns[:, None])
        x, periods = parts[0][:, 0], parts[1][0] * np.ones(count)
        derivative, samples = self.scene.derivative(at.coefficients), np.empty((*x.shape, COUNT))
        for i in range(COUNT):
            samples[..., i] = x
            start, end = i * periods / COUNT, (i + 1) * periods / COUNT
            x = rk8_steps(derivative, x, start, end, -(-self.steps // COUNT))
        return samples.swapaxes(0, 1)

    def neighbours(self, c: Any, inverse: Array, sources: Array) -> Neighbours:
        """Return the orbits that sources of error lead to.

        Parameters
        ----------
        c : NamedTuple of numbers
        inverse : array (2 n, 2 n)
            Of the slopes of `residual`.
        sources : array (2 n,)
            Errors of the residual, in the sizes of the states; the coefficients are further ones.
        """
        size, places = len(sources), np.flatnonzero(c)
        of_one = np.concatenate([np.zeros((1 + size, len(c))), np.eye(len(c))[places]])

        def times(factors: Array) -> Any:
            return type(c)(*(value * factors[:, i] for i, value in enumerate(c)))

        points, unknowns = times(1 + DISPLACEMENT * of_one), np.zeros((size, len(of_one)))
        ends = self.about(points, len(of_one)).residual(np.arange(len(of_one)), unknowns)
        change = (ends[:, 1 + size :] - ends[:, :1]) / DISPLACEMENT
        moves = np.hstack([np.zeros((size, 1)), inverse, -inverse @ change])
        length = DISPLACEMENT / np.maximum(np.max(np.abs(moves), axis=0), 1.0)
        weights = np.concatenate([[0.0], sources, np.full(len(places), COEFFICIENT)])
        return Neighbours(moves * length, times(1 + length[:, None] * of_one), weights / length)


def orbit_bounds(scene: EquationsOfMotion, parameters: Any, orbit: Orbit) -> OrbitBounds:
    """Bound the errors of a periodic orbit of the reference.

    Parameters
    ----------
    scene : EquationsOfMotion
    parameters : Parameters of it
    orbit : Orbit

    Raises
    ------
    NoOrbitError
        If the orbit is so nearly one of a family that rounding hides it.
    """
    c, section, size = scene.coefficients(parameters), section_row(scene), len(orbit.state)
    steps = orbit.steps
    coarse, rough, fine = (
        Closing(scene, orbit, n) for n in (max(steps // 4, 8), steps, 3 * steps // 2)
    )
    columns = np.arange(size)
    if section is not None:
        columns[section] = size
    with np.errstate(all="ignore"):
        here = np.zeros((size, 1))
        (rest, slopes), (other, other_slopes) = (
            [part[0] for part in (value.T, jacobian)]
            for value, jacobian in (closing.linearise(c, here) for closing in (fine, rough))
        )
        inverse, monodromy = np.linalg.inv(slopes[:, columns]), slopes[:, :size] + np.eye(size)
        integration = 2 * np.abs(rest - other)
        rounding = ROUNDING + STEP_ROUNDING * np.sqrt(fine.steps)
        integration += rounding * (1 + np.sum(np.abs(monodromy), axis=1))
        sources = np.abs(rest) + integration
        near = coarse.neighbours(c, inverse, sources)  # changes need no more digits
        bend = near.changes(coarse.linearise(near.coefficients, near.unknowns)[1])
        bent = float(np.max(np.sum(np.abs(inverse) @ bend[:, columns], axis=1)))
    if not bent < CURVED:
        raise NoOrbitError(
            f"the periodic orbit of {scene.name} is so nearly one of a family, or so near the end "
            "of its branch, that rounding hides it"
        )
    unit, scale = fine.scale[:, None] / fine.scale, fine.scale
    error = np.abs(near.unknowns) @ near.weights / (1 - bent)
    off = bend[:, :size] + np.abs(slopes - other_slopes)[:, :size]
    off += np.abs(orbit.monodromy / unit - monodromy)
    off += rounding * (np.abs(monodromy) + np.linalg.norm(monodromy) / size)
    samples = rough.samples(near)
    spread = near.changes(samples) + (integration * scale)[:, None]
    own = SampleBounds(near, samples, integration * scale)
    turns = [scene.rotations_per_period.get(name, 0) for name in scene.state_names]
    return OrbitBounds(
        period=orbit.period * float(EPS if section is None else error[section]),
        state=np.where(columns == size, 0.0, error * scale) + EPS * np.abs(orbit.state),
        multipliers=multiplier_bounds(monodromy, off, orbit.multipliers),
        power=own.of(partial(mean_powers, scene, period=orbit.period)),
        quantities=own.of(scene.orbit.quantities),
        harmonics=np.array(
            [2 * np.mean(b) + tail(x, n) for b, x, n in zip(spread, samples[0], turns, strict=True)]
        ),
    )


def multiplier_bounds(monodromy: Array, error: Array, multipliers: Any) -> Array:
    """Return bounds on the errors of multipliers from those of the entries of their matrix."""
    values, left, right = eig(monodromy, left=True, right=True)
    with np.errstate(all="ignore"):
        overlap = np.abs(np.sum(left.conj() * right, axis=0))
        first_order = np.sum(np.abs(left) * (error @ np.abs(right)), axis=0) / overlap
        bounds = pair_bounds(separations(values), first_order)
    nearest = np.argmin(np.abs(np.asarray(multipliers)[:, None] - values), axis=1)
    return np.asarray(bounds[nearest] + np.abs(multipliers - values[nearest]))


def tail(samples: Array, turns: int) -> float:
    """Return what harmonics beyond the samples add to those within: at most as much as the last."""
    spectrum = np.abs(spectrum_of(samples, turns))
    return float(4 * np.max(spectrum[-len(spectrum) // 8 :])) + EPS * float(np.max(np.abs(samples)))


@dataclass(frozen=True)
class SampleBounds:
    """Samples of neighbours of an orbit, by which what is computed from them is bounded.

    Attributes
    ----------
    near : Neighbours
    samples : array (k, 2 n, `COUNT`)
    integration : array (2 n,)
        Bounds on the errors of the samples by integration.
    """

    near: Neighbours
    samples: Array
    integration: Array

    def of(self, measure: Callable[[Array, Any], Mapping[str, float]]) -> dict[str, float]:
        """Return bounds on the errors of numbers from samples (2 n, k) and coefficients."""
        c = self.near.coefficients
        several = [type(c)(*(value[i] for value in c)) for i in range(len(self.samples))]
        base = measure(self.samples[0], several[0])
        bounds = {name: 2 * EPS * abs(value) for name, value in base.items()}

        def add(weight: float, others: Mapping[str, float]) -> None:
            for name, value in others.items():
                bounds[name] += float(weight * abs(value - base[name]))

        for weight, samples, one in zip(self.near.weights, self.samples, several, strict=True):
            add(weight, measure(samples, one) if weight else base)
        phase = 2 * np.pi * np.arange(COUNT) / COUNT
        for i, size in enumerate(self.integration):
            step = max(size, DISPLACEMENT * float(np.max(np.abs(self.samples[0, i]))))
            for pattern in (1.0, np.cos(phase), np.sin(phase)):
                moved = self.samples[0].copy()
                moved[i] += step * pattern
                add(size / step, measure(moved, several[0]))
        add(1.0, measure(self.samples[0][:, ::2], several[0]))
        return bounds
