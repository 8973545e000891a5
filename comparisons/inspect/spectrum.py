"""Modes of small motions with their shapes, and what a step of an integrator makes of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np
from scipy.linalg import eig

from ...reference.amplification import (
    AMPLIFICATION,
    ComplexArray,
    Vibrations,
    amplification_factors,
    first_order,
    largest_stable_step,
    rates,
    surpluses,
    vibrations,
)
from ...reference.linear import rigid_and_elastic
from ...reference.scene import Array

SHORT = 1e-9
"""Step [s] so short that no time constant of MuJoCo's constraints is raised."""

FREE = 1e-9
"""A direction that resists by less than this share of the stiffest is free: differences leave as
much."""

SLOW = 1e-6
"""An eigenvalue below this share of the largest counts as 0, and growth below it as none."""

STILL = 1e-7
"""A model whose fastest mode is slower than this [1/s], a year, has rigid modes only."""

WHOLE_UP_TO = 16
"""Degrees of freedom up to which the matrices of a step are taken whole; above, mode by mode."""

TRIED = 80
"""Steps that are tried; see `amplification.SCAN`."""

SCHEMES = {
    "Euler": "semi_implicit_euler",
    "implicit": "semi_implicit_euler",
    "implicitfast": "semi_implicit_euler",
    "RK4": "RK44",
    "discrete": "semi_implicit_euler",
}
"""Integrator of MuJoCo -> what it is, given what it takes late."""

ALIKE = 0.95
"""Share of the best likeness that counts as one: a coordinate may have a slow and a fast mode."""

LONG = 1e5
"""Horizon over which amplitudes may not grow, in 1 / omega of the fastest mode."""

FOLDS = 1.0
"""Times of growth by e over which a mode that grows of itself is followed: a method changes its
growth a little."""

Kind = Literal["rigid", "oscillating", "decaying", "unstable"]


class Shape(NamedTuple):
    """A mode: eigenvalue [1/s], and its vector (n,); a complex pair is one mode."""

    rate: complex
    vector: ComplexArray
    kind: Kind

    @property
    def omega(self) -> float:
        """Its modulus [rad/s]."""
        return abs(self.rate)

    @property
    def damping_ratio(self) -> float | None:
        """``-re / omega``; None of a rigid mode."""
        return None if self.kind == "rigid" else float(-self.rate.real / self.omega) + 0.0

    def place(self, mass: Array) -> int:
        """Return the coordinate that has most of its kinetic energy."""
        return int(np.argmax(np.abs(self.vector) * np.sqrt(np.diag(mass))))


def shapes(mass: Array, damping: Array, stiffness: Array) -> list[Shape]:
    """Return the modes of ``M a + C v + K q = 0`` ascending in modulus.

    Directions that neither spring nor damper resists are rigid modes; they are split off first,
    because their double eigenvalue 0 would keep half its digits only.

    Parameters
    ----------
    mass, damping, stiffness : array (n, n)
        Need not be symmetric but for the mass.
    """
    if not len(mass):
        return []
    root = 1 / np.sqrt(np.diag(mass))
    m, c, k = (matrix * np.outer(root, root) for matrix in (mass, damping, stiffness))
    c, k = c * (np.linalg.norm(c) > STILL), k * (np.linalg.norm(k) > STILL**2)
    free, elastic = rigid_and_elastic(m, c, k, FREE)
    modes = [Shape(0j, root * direction.astype(complex), "rigid") for direction in free.T]
    m, c, k = (elastic.T @ matrix @ elastic for matrix in (m, c, k))
    n = len(m)
    if not n:
        return modes
    values, vectors = eig(first_order(Vibrations(m, c, k, c)))
    upper, top = values.imag >= 0, np.max(np.abs(values))
    values[np.abs(values) < SLOW * top] = 0  # what rounding leaves beside the largest
    for part in (values.real, values.imag):
        part[np.abs(part) < FREE * top] = 0
    modes += [
        Shape(rate, root * (elastic @ vector), kind_of(rate))
        for rate, vector in zip(values[upper].tolist(), vectors[:n, upper].T, strict=True)
    ]
    return sorted(modes, key=lambda mode: (mode.omega, mode.rate.imag))


def kind_of(rate: complex) -> Kind:
    """Return what an eigenvalue does."""
    if rate == 0:
        return "rigid"
    if rate.real > SLOW * abs(rate):
        return "unstable"
    return "oscillating" if rate.imag else "decaying"


class LinearMotion(NamedTuple):
    """Small motions, and what an integrator takes late of them; arrays (..., n, n)."""

    mass: Array
    damping: Array
    stiffness: Array
    late_damping: Array
    late_stiffness: Array

    def vibrations(self, step: float) -> Vibrations:
        """Return them as what semi-implicit Euler is on them with a step [s].

        A stiffness K_1 that is taken late is, in one step h, a late damping h K_1, and the whole
        damping grows by as much: ``(M + h C_1 + h^2 K_1) v+ = (M - h (C - C_1)) v - h K q``.
        """
        more = step * self.late_stiffness
        return Vibrations(self.mass, self.damping + more, self.stiffness, self.late_damping + more)


def longest_step(
    integrator: str,
    at: Callable[[float], LinearMotion],
    modes: Sequence[Shape],
    raised_from: float = np.inf,
    whole_up_to: int = WHOLE_UP_TO,
) -> tuple[float, Shape | None]:
    """Return the longest step [s] that keeps small motions bounded, and the mode that sets it.

    Up to so many degrees of freedom by the matrix of a step, with more mode by mode, which is
    exact where damping does not couple modes. The mode is None where every step is stable.

    Parameters
    ----------
    integrator : str
    at : callable
        From a step to the motions, which depend on it beyond ``raised_from`` [s].
    modes : sequence of Shape
        Those of short steps.
    """
    if not any(mode.omega for mode in modes):
        return np.inf, None
    motion = at(SHORT)
    scheme, whole = SCHEMES[integrator], len(motion.mass) <= whole_up_to

    def reduced(motion: LinearMotion) -> LinearMotion:
        return scaled(motion) if whole else modal(motion, modes)

    own = reduced(motion)
    fixed = vibrations(*own[:4]) if whole and not np.any(own.late_stiffness) else None
    whole_motion = own.vibrations(0.0)
    horizon = LONG / float(np.max(np.abs(rates(whole_motion))))

    def reduced_at(step: float) -> LinearMotion:
        return reduced(at(step)) if step > raised_from else own

    def seen(step: float) -> tuple[Vibrations, ComplexArray]:
        of = reduced_at(step)
        late = fixed if fixed and of is own else of.vibrations(step)
        return late, rates(of.vibrations(0.0))

    def over(factors: ComplexArray, of: LinearMotion, step: float) -> Array:
        return surpluses(factors, rates(of.vibrations(0.0)), step, horizon, FOLDS)

    limit = largest_stable_step(scheme, whole_motion, horizon, at=seen, folds=FOLDS, scan=TRIED)
    if not 0 < limit < np.inf:
        return limit, None
    step = 1.001 * limit
    own = reduced_at(step)
    if whole:
        values, vectors = np.linalg.eig(AMPLIFICATION[scheme](own.vibrations(step), step))
        worst = np.argmax(over(values, own, step))
        return limit, most_alike(vectors[: len(own.mass), worst], motion, modes)
    alone = [LinearMotion(*(part[i : i + 1] for part in own)) for i in range(len(modes))]
    factors = (amplification_factors(scheme, x.vibrations(step), step) for x in alone)
    most = [np.max(over(f, x, step)) for f, x in zip(factors, alone, strict=True)]
    return limit, modes[int(np.argmax(most))]


def scaled(motion: LinearMotion) -> LinearMotion:
    """Return the same motions with unit inertias."""
    root = 1 / np.sqrt(np.diag(motion.mass))
    return LinearMotion(*(matrix * np.outer(root, root) for matrix in motion))


def modal(motion: LinearMotion, modes: Sequence[Shape]) -> LinearMotion:
    """Return each mode as a motion of its own, arrays (k, 1, 1): Rayleigh's quotients."""
    vectors = np.array([mode.vector for mode in modes]).T
    with np.errstate(all="ignore"):
        parts = [
            np.sum(vectors.conj() * (matrix @ vectors), axis=0).real[:, None, None]
            for matrix in motion
        ]
    moves = np.array([mode.kind != "rigid" for mode in modes])[:, None, None]
    return LinearMotion(np.ones_like(parts[0]), *(moves * part / parts[0] for part in parts[1:]))


def most_alike(vector: ComplexArray, motion: LinearMotion, modes: Sequence[Shape]) -> Shape:
    """Return the mode nearest to a vector (n,), of motions with unit inertias."""
    root = np.sqrt(np.diag(motion.mass))
    shares = [
        abs(np.vdot(root * mode.vector, vector)) / np.linalg.norm(root * mode.vector)
        for mode in modes
    ]
    near = [m for m, share in zip(modes, shares, strict=True) if share > ALIKE * max(shares)]
    return max(near, key=lambda mode: mode.omega)
