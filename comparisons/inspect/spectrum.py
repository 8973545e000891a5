"""Modes of small motions with their shapes, and what a step of an integrator makes of them."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from scipy.linalg import eig, null_space

from ...reference.amplification import (
    AMPLIFICATION,
    ComplexArray,
    Vibrations,
    excess,
    first_beyond,
    rates,
    spectral_radius,
    vibrations,
)
from ...reference.scene import Array

FREE = 1e-9
"""A direction that resists by less than this share of the stiffest is free: differences leave as
much."""

SLOW = 1e-6
"""An eigenvalue below this share of the largest counts as 0, and growth below it as none."""

STILL = 1e-7
"""A model whose fastest mode is slower than this [1/s], a year, has rigid modes only."""

EXACT = 16
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
"""Horizon over which amplitudes may not grow, in 1 / omega of the fastest mode; shorter where a
mode grows of itself, whose growth a method changes a little."""

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
    resisting = np.vstack([matrix / (np.linalg.norm(matrix) or 1.0) for matrix in (k, c)])
    free = null_space(resisting, rcond=FREE)
    found = [Shape(0j, root * direction.astype(complex), "rigid") for direction in free.T]
    elastic = null_space((m @ free).T) if free.size else np.eye(len(m))
    m, c, k = (elastic.T @ matrix @ elastic for matrix in (m, c, k))
    n = len(m)
    if not n:
        return found
    lower = -np.linalg.solve(m, np.hstack([k, c]))
    values, vectors = eig(np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower]))
    top = float(np.max(np.abs(values)))
    for value, vector in zip(values, vectors.T, strict=True):
        if value.imag >= 0:
            rate = cleaned(complex(value), top)
            found.append(Shape(rate, root * (elastic @ vector[:n]), kind_of(rate)))
    return sorted(found, key=lambda mode: (mode.omega, mode.rate.imag))


def cleaned(value: complex, top: float) -> complex:
    """Return an eigenvalue without what rounding leaves beside the largest."""
    if abs(value) < SLOW * top:
        return 0j
    real = 0.0 if abs(value.real) < FREE * top else value.real
    imaginary = 0.0 if abs(value.imag) < FREE * top else value.imag
    return complex(real, imaginary)


def kind_of(rate: complex) -> Kind:
    """Return what an eigenvalue does."""
    if rate == 0:
        return "rigid"
    if rate.real > SLOW * abs(rate):
        return "unstable"
    return "oscillating" if rate.imag else "decaying"


class Step(NamedTuple):
    """The largest step [s] that an integrator bears, infinite if any, and the mode that sets it.

    ``omega`` [1/s] and ``place``, the coordinate with most of its energy; both None where no step
    is too long.
    """

    limit: float
    omega: float | None
    place: int | None


class Motion(NamedTuple):
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


def longest_step(integrator: str, motion: Motion, modes: list[Shape]) -> Step:
    """Return the longest step that keeps small motions bounded.

    Up to `EXACT` degrees of freedom by the matrix of a step, with more mode by mode, which is
    exact where damping does not couple modes.
    """
    if not any(mode.omega for mode in modes):
        return Step(np.inf, None, None)
    scheme = SCHEMES[integrator]
    own = modal(motion, modes) if len(motion.mass) > EXACT else scaled(motion)
    whole = not np.any(own.late_stiffness)
    fixed = vibrations(*own[:4]) if whole and own.mass.ndim == 2 else None
    own_rates = rates(own.vibrations(0.0))
    fastest, growth = float(np.max(np.abs(own_rates))), float(np.max(own_rates.real))
    horizon = min(LONG, fastest / growth if growth > SLOW * fastest else LONG) / fastest

    def beyond(step: float) -> float:
        return excess(scheme, fixed or own.vibrations(step), step, horizon)

    limit = first_beyond(beyond, fastest, horizon, TRIED)
    if not 0 < limit < np.inf:
        return Step(limit, None, None)
    critical = modes[setter(scheme, motion, modes, 1.001 * limit)]
    return Step(limit, critical.omega, critical.place(motion.mass))


def scaled(motion: Motion) -> Motion:
    """Return the same motions with unit inertias."""
    root = 1 / np.sqrt(np.diag(motion.mass))
    return Motion(*(matrix * np.outer(root, root) for matrix in motion))


def modal(motion: Motion, modes: list[Shape]) -> Motion:
    """Return each mode as a motion of its own, arrays (k, 1, 1): Rayleigh's quotients."""
    vectors = np.array([mode.vector for mode in modes]).T
    with np.errstate(all="ignore"):
        parts = [
            np.sum(vectors.conj() * (matrix @ vectors), axis=0).real[:, None, None]
            for matrix in motion
        ]
    moves = np.array([mode.kind != "rigid" for mode in modes])[:, None, None]
    return Motion(np.ones_like(parts[0]), *(moves * part / parts[0] for part in parts[1:]))


def setter(scheme: str, motion: Motion, modes: list[Shape], step: float) -> int:
    """Return the number of the mode that a step multiplies most."""
    if len(motion.mass) > EXACT:
        each = modal(motion, modes)
        alone = (Motion(*(part[i : i + 1] for part in each)) for i in range(len(modes)))
        growth = [spectral_radius(scheme, one.vibrations(step), step) for one in alone]
        return int(np.argmax(growth))
    values, vectors = np.linalg.eig(AMPLIFICATION[scheme](scaled(motion).vibrations(step), step))
    root = np.sqrt(np.diag(motion.mass))
    grown = vectors[: len(root), np.argmax(np.abs(values))]
    alike = [
        abs(np.vdot(root * mode.vector, grown)) / np.linalg.norm(root * mode.vector)
        for mode in modes
    ]
    near = [i for i, share in enumerate(alike) if share > ALIKE * max(alike)]
    return max(near, key=lambda i: modes[i].omega)
