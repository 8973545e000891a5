r"""Free vibrations ``M a + C v + K q = 0`` as published schemes integrate them.

One step of a scheme multiplies the state by a matrix. Its spectral radius tells whether the
step is stable, its eigenvalues how much a mode loses or gains, and how far its phase drifts.
Along the imaginary axis semi-implicit Euler and central differences are stable up to
``h omega = 2``, Kutta's RK4 up to ``2 sqrt 2``, explicit Euler nowhere (Hairer, Wanner, Solving
Ordinary Differential Equations II, section IV.2; Hughes, The Finite Element Method, section
9.3, for the implicit ones).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.optimize import brentq, linear_sum_assignment

from .scene import Array
from .solve.schemes import TABLEAUS, Tableau

SPECTRAL_RADIUS = 0.9
"""Spectral radius of generalized-alpha at infinite steps, Exudyn's default."""

GROWTH = 10.0
"""A step counts as unstable if it lets an amplitude grow by more than this over the run."""

SCAN = 400
"""Steps tried, a constant factor apart, before the limit between two of them is refined."""

SHORTEST, LONGEST = 1e-4, 1e4
"""Between which multiples of 1 / omega they lie."""

DEFECT = 1e-6
"""Scatter of the moduli of multiple eigenvalues by round-off, with a margin."""

DECOUPLED = 1e-10
"""Largest share that couples two modes in rounding."""

ComplexArray = NDArray[np.complex128]


class Vibrations(NamedTuple):
    """``M a + C v + K q = 0``, arrays (..., n, n).

    ``implicit_damping`` is the part of C that semi-implicit Euler methods take at the end of a
    step: all dampers, or those of joints alone, as the engine has it.
    """

    mass: Array
    damping: Array
    stiffness: Array
    implicit_damping: Array

    @property
    def identity(self) -> Array:
        """Identity matrices (..., n, n)."""
        return np.asarray(0 * self.mass + np.eye(self.mass.shape[-1]))

    @property
    def resisting(self) -> Array:
        """Stiffness and damping side by side (..., n, 2 n)."""
        return np.concatenate([self.stiffness, self.damping], axis=-1)


Amplify = Callable[[Vibrations, float], Array]


def first_order(of: Vibrations) -> Array:
    """Return A (..., 2 n, 2 n) of ``x' = A x``, x the coordinates and their rates."""
    rates = -np.linalg.solve(of.mass, of.resisting)
    return np.concatenate([np.block([[0 * of.mass, of.identity]]), rates], axis=-2)


def runge_kutta(tableau: Tableau, of: Vibrations, step: float) -> Array:
    """Return the matrix (..., 2 n, 2 n) of an explicit Runge-Kutta method."""
    z = step * first_order(of)
    one = np.eye(z.shape[-1])
    stages: list[Array] = []
    for row in tableau.a:
        inner = one + sum((a * k for a, k in zip(row, stages, strict=False)), 0 * z)
        stages.append(z @ inner)
    return np.asarray(one + sum(b * k for b, k in zip(tableau.b, stages, strict=True)))


def semi_implicit(springs: bool, of: Vibrations, step: float) -> Array:
    """Return the matrix (..., 2 n, 2 n) of Euler's method, velocities first.

    The implicit damping, or springs too, are taken at the end of the step.
    """
    left = of.mass + step * of.implicit_damping + step**2 * of.stiffness * springs
    right = of.mass - step * (of.damping - of.implicit_damping)
    speed = np.linalg.solve(left, np.block([[-step * of.stiffness, right]]))
    place = np.block([[of.identity, 0 * of.mass]]) + step * speed
    return np.concatenate([place, speed], axis=-2)


def generalized_alpha(radius: float, of: Vibrations, step: float) -> Array:
    """Return the matrix (..., 3 n, 3 n) of generalized-alpha, on (q, v, algorithmic a).

    Chung, Hulbert (1993), J. Appl. Mech. 60, 371-375, with the algorithmic accelerations of
    Arnold, Bruls (2007), Multibody Syst. Dyn. 18, 185-202.
    """
    one, zero, h = of.identity, 0 * of.mass, step
    alpha_m, alpha_f = (2 * radius - 1) / (radius + 1), radius / (radius + 1)
    gamma = 0.5 + alpha_f - alpha_m
    beta = 0.25 * (gamma + 0.5) ** 2
    # unknown: q+, v+, a+ (algorithmic), acc+; known: q, v, a, acc
    left = np.block(
        [
            [one, zero, -(h**2) * beta * one, zero],
            [zero, one, -h * gamma * one, zero],
            [zero, zero, (1 - alpha_m) * one, -(1 - alpha_f) * one],
            [of.stiffness, of.damping, zero, of.mass],
        ]
    )
    right = np.block(
        [
            [one, h * one, h**2 * (0.5 - beta) * one, zero],
            [zero, one, h * (1 - gamma) * one, zero],
            [zero, zero, -alpha_m * one, alpha_f * one],
            [zero, zero, zero, zero],
        ]
    )
    size = 3 * one.shape[-1]
    whole = np.linalg.solve(left, right)[..., :size, :]
    known, acceleration = whole[..., :size], whole[..., size:]
    # the true acceleration follows from q and v
    known[..., : 2 * one.shape[-1]] -= acceleration @ np.linalg.solve(of.mass, of.resisting)
    return np.asarray(known)


def trapezoidal(of: Vibrations, step: float) -> Array:
    """Return the matrix (..., 2 n, 2 n) of the trapezoidal rule."""
    z = step / 2 * first_order(of)
    one = np.eye(z.shape[-1])
    return np.asarray(np.linalg.solve(one - z, one + z))


AMPLIFICATION: dict[str, Amplify] = {
    **{name: partial(runge_kutta, tableau) for name, tableau in TABLEAUS.items()},
    "semi_implicit_euler": partial(semi_implicit, False),
    "implicit_euler_dampers": partial(semi_implicit, False),
    "implicit_euler_velocity": partial(semi_implicit, False),
    "implicit_euler": partial(semi_implicit, True),
    "trapezoidal": trapezoidal,
    "generalized_alpha": partial(generalized_alpha, SPECTRAL_RADIUS),
}
"""Amplification matrix of each scheme; the semi-implicit three differ in their implicit dampers."""


def vibrations(
    mass: Array, damping: Array, stiffness: Array, implicit_damping: Array | None = None
) -> Vibrations:
    """Return a system of vibrations, as single modes where it falls into them.

    Then its arrays are (n, 1, 1) in the coordinates of the modes, which is cheap and exact.
    By default all damping is implicit.
    """
    late = damping if implicit_damping is None else implicit_damping
    whole = Vibrations(mass, damping, stiffness, late)
    try:
        squares, shapes = eigh((stiffness + stiffness.T) / 2, (mass + mass.T) / 2)
    except np.linalg.LinAlgError:
        return whole
    modal = [shapes.T @ matrix @ shapes for matrix in whole]
    for matrix in modal[1:]:
        diagonal = np.diag(np.diag(matrix))
        if np.max(np.abs(matrix - diagonal)) > DECOUPLED * np.max(np.abs(diagonal)):
            return whole
    single = (np.diag(matrix)[:, None, None] for matrix in modal[1:])
    return Vibrations(np.ones((len(squares), 1, 1)), *single)


def amplification_factors(scheme: str, of: Vibrations, step: float) -> ComplexArray:
    """Return the eigenvalues (k,) of the matrix by which a step multiplies free vibrations."""
    with np.errstate(all="ignore"):
        try:
            matrix = AMPLIFICATION[scheme](of, step)
            return np.linalg.eigvals(matrix).ravel().astype(complex)
        except np.linalg.LinAlgError:
            return np.array([np.inf + 0j])


def rates(of: Vibrations) -> ComplexArray:
    """Return the eigenvalues (k,) [1/s] of the free vibrations themselves."""
    return np.linalg.eigvals(first_order(of)).ravel().astype(complex)


class NumericalMode(NamedTuple):
    """Eigenvalues [1/s] of a mode of the motion, and of the mode of the numerical solution."""

    exact: complex
    numerical: complex


def numerical_modes(scheme: str, of: Vibrations, step: float) -> list[NumericalMode]:
    """Return each oscillating mode with its counterpart in the numerical solution.

    Counterparts are the nearest eigenvalues; beyond half a turn in a step there are none.
    """
    exact = np.array([value for value in rates(of) if value.imag > 0])
    multiplied = amplification_factors(scheme, of, step)
    with np.errstate(all="ignore"):
        logs = np.log(multiplied[np.isfinite(multiplied) & (multiplied != 0)]) / step
    if not len(exact) or len(logs) < len(exact):
        return []
    pairs = zip(*linear_sum_assignment(np.abs(np.subtract.outer(exact, logs))), strict=True)
    return [NumericalMode(complex(exact[i]), complex(logs[j])) for i, j in pairs]


def surpluses(
    factors: ComplexArray, own: ComplexArray, step: float, horizon: float, folds: float = np.inf
) -> Array:
    """Return the logarithm (k,) of the excess growth of each eigenvalue of a step over a run.

    The largest is compared with the growth of the fastest-growing mode, the next with that of the
    next, and those beyond with none: one mode that grows of itself excuses no other.

    Parameters
    ----------
    factors : array (k,)
        Eigenvalues of the matrix of a step.
    own : array (n,)
        Eigenvalues of the motion itself [1/s].
    step, horizon : float
        [s]
    folds : float
        A mode that grows of itself is followed over so many of its times of growth by e at most.
    """
    sizes = np.abs(factors)
    order, growth = np.argsort(-sizes), np.zeros(len(sizes))
    growing = np.sort(np.maximum(own.real, 0.0))[::-1][: len(sizes)]
    growth[order[: len(growing)]] = growing
    with np.errstate(divide="ignore"):
        over = (np.log(sizes) / step - growth) * np.minimum(horizon, folds / growth)
    return np.where(sizes > 1 + DEFECT, over, -np.inf)


def excess(
    scheme: str,
    of: Vibrations,
    step: float,
    horizon: float,
    growth: float = GROWTH,
    own: ComplexArray | None = None,
    folds: float = np.inf,
) -> float:
    """Return the logarithm of the growth of an amplitude over a run, beyond the permitted one.

    Growth of the motion itself, about an unstable state of rest, does not count: it follows from
    its eigenvalues ``own``, by default those of the vibrations; see `surpluses`.
    """
    own = rates(of) if own is None else own
    over = surpluses(amplification_factors(scheme, of, step), own, step, horizon, folds)
    return max(-1.0, float(np.max(over)) - float(np.log(growth)))


StepVibrations = Callable[[float], tuple[Vibrations, ComplexArray]]
"""Function of a step [s] that returns a method's vibrations and their eigenvalues [1/s]."""


def largest_stable_step(
    scheme: str,
    of: Vibrations,
    horizon: float,
    growth: float = GROWTH,
    *,
    at: StepVibrations | None = None,
    folds: float = np.inf,
    scan: int = SCAN,
) -> float:
    """Return the step [s] up to which no amplitude grows by more than ``growth`` over a run.

    Every largest stable step of mbcheck is computed here: those of MJCF files (`mbcheck inspect`)
    too, whose vibrations depend on the step.

    Parameters
    ----------
    scheme : str
        One of `AMPLIFICATION`.
    of : Vibrations
    horizon : float
        Length of the run [s].
    growth : float
    at : callable, optional
        Gives the vibrations at each step; by default they are ``of`` at all steps.
    folds : float
        See `surpluses`.
    scan : int
        See `SCAN`.

    Returns
    -------
    float
        Infinity where every step is stable, or where nothing is faster than the run.
    """
    own = rates(of)
    fastest = float(np.max(np.abs(own), initial=0.0))
    if not fastest * horizon > 0:
        return np.inf

    def beyond(step: float) -> float:
        seen, exact = (of, own) if at is None else at(step)
        return excess(scheme, seen, step, horizon, growth, exact, folds)

    tried = np.geomspace(SHORTEST, min(LONGEST, fastest * horizon), scan) / fastest
    bad = next((i for i, step in enumerate(tried) if beyond(step) > 0), None)
    if bad is None:
        return np.inf
    if bad == 0:
        return 0.0
    return float(brentq(beyond, tried[bad - 1], tried[bad], rtol=1e-10))
