r"""What a published scheme makes of free vibrations: ``M a + C v + K q = 0``.

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

import numpy as np
from scipy.linalg import eigvals
from scipy.optimize import brentq

from .scene import Array
from .schemes import TABLEAUS, Tableau

SPECTRAL_RADIUS = 0.9
"""Of generalized-alpha at infinite steps, as Exudyn sets it by default."""

GROWTH = 10.0
"""A step counts as unstable if it lets an amplitude grow by more than this over the run."""

SCAN = 400
"""Steps tried, a constant factor apart, before the limit between two of them is refined."""

SHORTEST, LONGEST = 1e-4, 1e4
"""Between which multiples of 1 / omega they lie."""

DEFECT = 1e-6
"""By how much the moduli of multiple eigenvalues scatter in rounding, with a margin."""

Amplify = Callable[[Array, Array, Array, float], Array]


def runge_kutta(
    tableau: Tableau, mass: Array, damping: Array, stiffness: Array, step: float
) -> Array:
    """Return the matrix (2 n, 2 n) of an explicit Runge-Kutta method."""
    z = step * first_order(mass, damping, stiffness)
    stages: list[Array] = []
    for row in tableau.a:
        inner = np.eye(len(z)) + sum((a * k for a, k in zip(row, stages, strict=False)), 0 * z)
        stages.append(z @ inner)
    return np.eye(len(z)) + sum((b * k for b, k in zip(tableau.b, stages, strict=True)), 0 * z)


def first_order(mass: Array, damping: Array, stiffness: Array) -> Array:
    """Return A (2 n, 2 n) of ``x' = A x``, x the coordinates and their rates."""
    n = len(mass)
    inverse = np.linalg.inv(mass)
    return np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])


def semi_implicit(
    dampers: bool, springs: bool, mass: Array, damping: Array, stiffness: Array, step: float
) -> Array:
    """Return the matrix (2 n, 2 n) of Euler's method, velocities first.

    Dampers, or springs too, are taken at the end of the step.
    """
    n = len(mass)
    left = mass + step * damping * dampers + step**2 * stiffness * springs
    right = mass - step * damping * (not dampers)
    speed = np.linalg.solve(left, np.hstack([-step * stiffness, right]))
    place = np.hstack([np.eye(n), np.zeros((n, n))]) + step * speed
    return np.vstack([place, speed])


def generalized_alpha(
    radius: float, mass: Array, damping: Array, stiffness: Array, step: float
) -> Array:
    """Return the matrix (3 n, 3 n) of generalized-alpha, on (q, v, algorithmic a).

    Chung, Hulbert (1993), J. Appl. Mech. 60, 371-375, with the algorithmic accelerations of
    Arnold, Bruls (2007), Multibody Syst. Dyn. 18, 185-202; radius 1 and no averaging would be
    the trapezoidal rule.
    """
    n = len(mass)
    one, zero = np.eye(n), np.zeros((n, n))
    alpha_m, alpha_f = (2 * radius - 1) / (radius + 1), radius / (radius + 1)
    gamma = 0.5 + alpha_f - alpha_m
    beta = 0.25 * (gamma + 0.5) ** 2
    h = step
    # unknown: q+, v+, a+ (algorithmic), acc+; known: q, v, a, acc
    left = np.block(
        [
            [one, zero, -(h**2) * beta * one, zero],
            [zero, one, -h * gamma * one, zero],
            [zero, zero, (1 - alpha_m) * one, -(1 - alpha_f) * one],
            [stiffness, damping, zero, mass],
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
    whole = np.asarray(np.linalg.solve(left, right))
    # the true acceleration follows from q and v: fold it in
    fold = np.vstack(
        [
            np.eye(3 * n),
            np.hstack([-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping), zero]),
        ]
    )
    return whole[: 3 * n] @ fold


def trapezoidal(mass: Array, damping: Array, stiffness: Array, step: float) -> Array:
    """Return the matrix (2 n, 2 n) of the trapezoidal rule."""
    z = step / 2 * first_order(mass, damping, stiffness)
    one = np.eye(len(z))
    found: Array = np.linalg.solve(one - z, one + z)
    return found


AMPLIFICATION: dict[str, Amplify] = {
    **{name: partial(runge_kutta, tableau) for name, tableau in TABLEAUS.items()},
    "semi_implicit_euler": partial(semi_implicit, True, False),
    "implicit_euler_dampers": partial(semi_implicit, True, False),
    "implicit_euler_velocity": partial(semi_implicit, True, False),
    "implicit_euler": partial(semi_implicit, True, True),
    "trapezoidal": trapezoidal,
    "generalized_alpha": partial(generalized_alpha, SPECTRAL_RADIUS),
}
"""By name of the scheme. The three semi-implicit ones differ in which dampers they take at the
end of a step: where all are joint dampers, on a linear system, they agree."""


def spectral_radius(
    scheme: str, mass: Array, damping: Array, stiffness: Array, step: float
) -> float:
    """Return by how much one step of a scheme may multiply a free vibration."""
    with np.errstate(all="ignore"):
        matrix = AMPLIFICATION[scheme](mass, damping, stiffness, step)
    return float(np.max(np.abs(eigvals(matrix)))) if np.all(np.isfinite(matrix)) else np.inf


def largest_stable_step(
    scheme: str,
    mass: Array,
    damping: Array,
    stiffness: Array,
    horizon: float,
    growth: float = GROWTH,
) -> float:
    """Return the step [s] up to which no amplitude grows by more than ``growth`` over a run.

    What the motion grows by of itself, about an unstable state of rest, does not count.

    Parameters
    ----------
    scheme : str
        One of `AMPLIFICATION`.
    mass, damping, stiffness : array (n, n)
    horizon : float
        Length of the run [s].
    growth : float

    Returns
    -------
    float
        Infinity where every step is stable, or where nothing is faster than the run.
    """
    rates = eigvals(first_order(mass, damping, stiffness))
    fastest = float(np.max(np.abs(rates), initial=0.0))
    own_growth = max(0.0, float(np.max(rates.real, initial=0.0))) * horizon
    if not fastest * horizon > 0:
        return np.inf

    def excess(step: float) -> float:
        radius = spectral_radius(scheme, mass, damping, stiffness, step)
        if radius <= 1 + DEFECT:
            return -1.0
        return float(np.log(radius) * horizon / step - own_growth - np.log(growth))

    tried = np.geomspace(SHORTEST, min(LONGEST, fastest * horizon), SCAN) / fastest
    bad = next((i for i, step in enumerate(tried) if excess(step) > 0), None)
    if bad is None:
        return np.inf
    if bad == 0:
        return 0.0
    return float(brentq(excess, tried[bad - 1], tried[bad], rtol=1e-10))
