"""Bounds on the errors of a periodic orbit: period, state, multipliers, powers, harmonics.

Newton's method leaves a residual of the period map, which itself is off by what integration and
rounding of its coefficients do; the inverse of its Jacobian tells how far the true orbit may be
(Kantorovich). Each source of error is followed by itself: the orbit is displaced as the source
displaces it, and what that changes of multipliers, samples and quantities is added up. A multiplier
keeps its value where the matrix changes as by other coordinates, or by a shift along the orbit:
it is the change of the eigenvalue that counts, not those of the entries. Rounding of each step is
independent of that of others, so that squares are added.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig, matrix_balance

from ..differences import EPS, by_complex_step
from ..errors import NoOrbitError
from ..orbits import (
    Orbit,
    PeriodMap,
    hidden_by_rounding,
    mean_powers,
    reference_map,
    section_row,
    state_scale,
)
from ..periodic import spectrum_of
from ..scene import Array, EquationsOfMotion
from ..solve.rk8 import rk8_samples, rk8_steps
from . import modes
from .modes import pair_bounds, separations


class OrbitBoundOptions(NamedTuple):
    """Sources of error of an orbit.

    Attributes
    ----------
    displacement : float
        Displacement of orbits, relative to each state: changes are linear, round-off is small.
    rounding : float
        Round-off of a period's end, relative to the states, without that of the steps.
    step_rounding : float
        Round-off of a step: five standard deviations of half a unit, evenly spread.
    parts : int
        Parts of a period; round-off is followed from the end of each to the period's end.
    curved : float
        Relative change of the period map's Jacobian within the orbit's error that makes it unknown.
    samples : int
        Samples of a period.
    """

    displacement: float = 1e-7
    rounding: float = 3 * EPS
    step_rounding: float = 1.5 * EPS
    parts: int = 16
    curved: float = 0.25
    samples: int = 256


OPTIONS = OrbitBoundOptions()


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
        Bound on each state's mean and on the complex amplitudes of its harmonics.
    """

    period: float
    state: Array
    multipliers: Array
    power: Mapping[str, float]
    quantities: Mapping[str, float]
    harmonics: Array


@dataclass(frozen=True)
class Neighbours:
    """The orbit, and orbits displaced by one source of error each.

    Attributes
    ----------
    unknowns : array (2 n, k)
        Displacements, in the unknowns of `PeriodMap`; 0 for the orbit itself.
    coefficients : NamedTuple of arrays (k,)
    weights : array (k,)
        The source in units of the displacement; 0 for the orbit itself.
    random : bool array (k,)
        True for sources that are independent of each other: their squares are added.
    """

    unknowns: Array
    coefficients: Any
    weights: Array
    random: NDArray[np.bool_]

    def together(self, sizes: Array) -> Array:
        """Return the change by all sources, from the sizes (k, ...) of that by each."""
        each = self.weights[(slice(None), *[None] * (sizes.ndim - 1))] * sizes
        squares = np.sum(each[self.random] ** 2, axis=0)
        return np.asarray(np.sum(each[~self.random], axis=0) + np.sqrt(squares))

    def changes(self, values: Array) -> Array:
        """Return the change of values (k, ...) by all sources together."""
        return self.together(np.abs(values - values[0]))


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
        states = np.repeat(self.orbit.state[:, None], count, axis=1)
        return reference_map(self.scene, c, states, np.full(count, self.orbit.period), self.steps)

    def linearise(self, c: Any, unknowns: Array) -> tuple[Array, Array]:
        """Return the residuals of points (2 n, k), relative to their sizes, and the slopes."""
        count = unknowns.shape[1]
        return self.about(c, count).linearise(np.arange(count), unknowns)

    def samples(self, at: Neighbours) -> Array:
        """Return states (k, 2 n, count) over one period."""
        count = len(at.weights)
        parts = self.about(at.coefficients, count).place(np.arange(count), at.unknowns[:, None])
        x, periods = parts[0][:, 0], parts[1][0] * np.ones(count)
        derivative, times = (
            self.scene.derivative(at.coefficients),
            np.arange(1, OPTIONS.samples) / OPTIONS.samples,
        )
        rest = rk8_samples(
            derivative, x, 0.0, np.outer(times, periods), -(-self.steps // OPTIONS.samples)
        )
        return np.concatenate([x[..., None], rest], axis=-1).swapaxes(0, 1)

    def flows(self, c: Any) -> tuple[Array, Array, Array]:
        """Return the Jacobians of the flow up to the end of each part, and from there to the end.

        Both of shape (parts, 2 n, 2 n), in the sizes of the states; then the largest values
        (2 n,) of the states there, in the same.
        """
        scene, period, unit = self.scene, self.orbit.period, self.scale[:, None] / self.scale
        derivative, x = scene.derivative(c), self.orbit.state
        size, steps = len(x), -(-self.steps // OPTIONS.parts)
        jacobians: list[Array] = []
        largest = np.abs(x)
        for i in range(OPTIONS.parts):
            start, end = i * period / OPTIONS.parts, (i + 1) * period / OPTIONS.parts
            part = partial(rk8_steps, derivative, t0=start, t1=end, steps=steps)
            x, jacobian = by_complex_step(part, x)
            jacobians.append(jacobian / unit)
            largest = np.maximum(largest, np.abs(x))
        before, after = [np.eye(size)], [np.eye(size)]
        for jacobian in jacobians:
            before.append(jacobian @ before[-1])
        for jacobian in jacobians[:0:-1]:
            after.append(after[-1] @ jacobian)
        return np.array(before[1:]), np.array(after[::-1]), largest / self.scale

    def neighbours(self, c: Any, inverse: Array, sources: Array, random: Array) -> Neighbours:
        """Return the orbits that sources of error lead to.

        Parameters
        ----------
        c : NamedTuple of numbers
        inverse : array (2 n, 2 n)
            Inverse of the slopes of `residual`.
        sources, random : array (2 n, m)
            Errors of the residual, in the sizes of the states, one in a column: certain ones, and
            independent ones. The coefficients are further sources.
        """
        errors, places = np.hstack([sources, random]), np.flatnonzero(c)
        sizes, (unknowns_count, size) = np.max(np.abs(errors), axis=0), errors.shape
        of_one = np.concatenate([np.zeros((1 + size, len(c))), np.eye(len(c))[places]])

        def times(factors: Array) -> Any:
            return type(c)(*(value * factors[:, i] for i, value in enumerate(c)))

        points = times(1 + OPTIONS.displacement * of_one)
        unknowns = np.zeros((unknowns_count, len(of_one)))
        ends = self.about(points, len(of_one)).residual(np.arange(len(of_one)), unknowns)
        change = (ends[:, 1 + size :] - ends[:, :1]) / OPTIONS.displacement
        along = inverse @ (errors / np.where(sizes > 0, sizes, 1.0))
        moves = np.hstack([np.zeros((unknowns_count, 1)), along, -inverse @ change])
        length = OPTIONS.displacement / np.maximum(np.max(np.abs(moves), axis=0), 1.0)
        weights = np.concatenate([[0.0], sizes, np.full(len(places), modes.OPTIONS.coefficient)])
        independent = np.zeros(len(weights), dtype=bool)
        independent[1 + sources.shape[1] : 1 + size] = True
        coefficients = times(1 + length[:, None] * of_one)
        return Neighbours(moves * length, coefficients, weights / length, independent)


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
        rounding = OPTIONS.rounding + OPTIONS.step_rounding * np.sqrt(fine.steps)
        before, after, largest = coarse.flows(c)  # rounding needs no more digits
        random = rounding * spread_of(after, largest)
        integration = 2 * np.abs(rest - other) + np.sum(np.abs(random), axis=1)
        sources = np.stack([rest, 2 * (rest - other)], axis=1)
        near = coarse.neighbours(c, inverse, sources, random)
        jacobians = coarse.linearise(near.coefficients, near.unknowns)[1]
        bend = near.changes(jacobians)
        bent = float(np.max(np.sum(np.abs(inverse) @ bend[:, columns], axis=1)))
    if not bent < OPTIONS.curved:
        raise NoOrbitError(hidden_by_rounding(scene))
    spectrum, scale = Spectrum.of(monodromy), fine.scale
    error = near.together(np.abs(near.unknowns.T)) / (1 - bent)
    off = near.together(np.abs(spectrum.changes((jacobians - jacobians[0])[..., :size])))
    off += 2 * np.abs(spectrum.changes((slopes - other_slopes)[None, :, :size])[0])
    off += rounding * spectrum.scatter(before, after)
    samples = rough.samples(near)
    spread = near.changes(samples) + (integration * scale)[:, None]
    own = SampleBounds(near, samples, integration * scale)
    turns = [scene.rotations_per_period.get(name, 0) for name in scene.state_names]
    return OrbitBounds(
        period=orbit.period * float(EPS if section is None else error[section]),
        state=np.where(columns == size, 0.0, error * scale) + EPS * np.abs(orbit.state),
        multipliers=spectrum.bounds(off, orbit.multipliers),
        power=own.of(partial(mean_powers, scene, period=orbit.period)),
        quantities=own.of(scene.orbit.quantities),
        harmonics=np.array(
            [2 * np.mean(b) + tail(x, n) for b, x, n in zip(spread, samples[0], turns, strict=True)]
        ),
    )


def spread_of(after: Array, largest: Array) -> Array:
    """Return columns (2 n, 2 n): the effect of a unit of round-off at the end of each part.

    They are independent of each other, and together as large as that of the start and, on average,
    of one part.

    Parameters
    ----------
    after : array (k, 2 n, 2 n)
        Jacobians of the flow from each part to the period's end.
    largest : array (2 n,)
        Largest values of the states.
    """
    count, size = after.shape[:2]
    each = np.concatenate([np.eye(size)[None], after / np.sqrt(count)]) * largest
    return np.asarray(np.linalg.qr(np.concatenate(each, axis=1).T, mode="r")).T


@dataclass(frozen=True)
class Spectrum:
    """Multipliers, and how they change with their matrix, to first order.

    Attributes
    ----------
    values : array (2 n,)
    left, right : array (2 n, 2 n)
        Eigenvectors, in columns; ``left`` conjugate, and over its product with ``right``.
    own : array (2 n,)
        Round-off of their computation, in balanced coordinates.
    """

    values: Any
    left: Any
    right: Any
    own: Array

    @classmethod
    def of(cls, matrix: Array) -> Spectrum:
        """Return the spectrum of a matrix."""
        balanced, (unit, _) = matrix_balance(matrix, permute=False, separate=True)
        values, left, right = eig(balanced, left=True, right=True)
        with np.errstate(all="ignore"):
            left = left.conj() / np.sum(left.conj() * right, axis=0)
        lengths = np.linalg.norm(left, axis=0) * np.linalg.norm(right, axis=0)
        own = EPS * np.linalg.norm(balanced) * lengths
        return cls(values, left / unit[:, None], right * unit[:, None], own)

    def changes(self, changes: Array) -> Any:
        """Return the changes (k, 2 n) by those of the matrix (k, 2 n, 2 n)."""
        return np.einsum("mi,kmj,ji->ki", self.left, changes, self.right)

    def scatter(self, before: Array, after: Array) -> Array:
        """Return the change by a unit of round-off in the entries of each part's Jacobian.

        Parameters
        ----------
        before, after : array (k, 2 n, 2 n)
            See `Closing.flows`.
        """
        rows = np.abs(self.left.T @ after) ** 2
        columns = before**2 @ np.abs(self.right) ** 2
        return np.asarray(np.sqrt(np.mean(np.einsum("kim,kmi->ki", rows, columns), axis=0)))

    def bounds(self, off: Array, multipliers: Any) -> Array:
        """Return bounds on the errors of multipliers from first-order bounds (2 n,)."""
        with np.errstate(all="ignore"):
            bounds = pair_bounds(separations(self.values), off + self.own)
        nearest = np.argmin(np.abs(np.asarray(multipliers)[:, None] - self.values), axis=1)
        return np.asarray(bounds[nearest] + np.abs(multipliers - self.values[nearest]))


def tail(samples: Array, turns: int) -> float:
    """Return the share of harmonics beyond the samples: at most as much as the last ones."""
    spectrum = np.abs(spectrum_of(samples, turns))
    return float(4 * np.max(spectrum[-len(spectrum) // 8 :])) + EPS * float(np.max(np.abs(samples)))


@dataclass(frozen=True)
class SampleBounds:
    """Samples of neighbours of an orbit, from which results are bounded.

    Attributes
    ----------
    near : Neighbours
    samples : array (k, 2 n, count)
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

        def changes(others: Mapping[str, float]) -> Array:
            return np.array([abs(others[name] - value) for name, value in base.items()])

        bounds = 2 * EPS * np.abs([*base.values()])
        sources = zip(self.near.weights, self.samples, several, strict=True)
        bounds += self.near.together(
            np.array([changes(measure(x, one) if weight else base) for weight, x, one in sources])
        )
        phase = 2 * np.pi * np.arange(OPTIONS.samples) / OPTIONS.samples
        for i, size in enumerate(self.integration):
            step = max(size, OPTIONS.displacement * float(np.max(np.abs(self.samples[0, i]))))
            for pattern in (1.0, np.cos(phase), np.sin(phase)):
                moved = self.samples[0].copy()
                moved[i] += step * pattern
                bounds += size / step * changes(measure(moved, several[0]))
        bounds += changes(measure(self.samples[0][:, ::2], several[0]))
        return dict(zip(base, map(float, bounds), strict=True))
