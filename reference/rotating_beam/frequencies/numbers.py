"""Dimensionless parameters (19) of `rotating_beam` in steady rotation, or hanging at rest."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...errors import ParameterError, UnknownNameError
from ...scene import Array
from ..parameters import RotatingBeam

PLANES = ("chordwise", "flapwise")


class Numbers(NamedTuple):
    """Dimensionless parameters (19) of a beam in steady rotation, or hanging at rest.

    Attributes
    ----------
    delta : float
        Hub radius a/L.
    gamma : float
        Speed T Omega.
    alpha : float
        Mass m/(rho A L).
    beta : float
        Its place d/L, 0 to 1.
    weight : float
        rho A g L^3/(E I) of a gravity g along the beam, which does not rotate then.
    """

    delta: float = 0.0
    gamma: float = 0.0
    alpha: float = 0.0
    beta: float = 1.0
    weight: float = 0.0


def time_unit(p: RotatingBeam) -> float:
    """T of (19) [s]."""
    return float(p.length**2 * np.sqrt(p.density * p.area / (p.youngs_modulus * p.second_moment)))


def numbers(p: RotatingBeam) -> Numbers:
    """Dimensionless parameters at the final speed ``angular_speed``; with gravity, at rest."""
    gravity = float(np.hypot(p.gravity_x, p.gravity_y))
    return Numbers(
        delta=p.hub_radius / p.length,
        gamma=0.0 if gravity else abs(p.angular_speed) * time_unit(p),
        alpha=p.mass / (p.density * p.area * p.length),
        beta=p.mass_position,
        weight=gravity * time_unit(p) ** 2 / p.length,
    )


def tension(n: Numbers, x: Any) -> Any:
    """Return tau(xi): the tension by rotation is gamma^2 tau EI/L^2."""
    outside = n.delta * (1 - x) + (1 - x**2) / 2
    return outside + n.alpha * (n.delta + n.beta) * (x < n.beta)


def pull(n: Numbers, x: Any) -> Any:
    """Return the tension over EI/L^2, by rotation and by gravity."""
    return n.gamma**2 * tension(n, x) + n.weight * (1 - x + n.alpha * (x < n.beta))


class NaturalModes(NamedTuple):
    """Natural frequencies (count,), ascending, and bounds on their errors."""

    omega: Array
    bound: Array


def check(n: Numbers, plane: str, count: int) -> None:
    """Raise where there is nothing to solve."""
    if plane not in PLANES:
        raise UnknownNameError("plane", plane, PLANES)
    if not 0 <= n.beta <= 1:
        raise ParameterError(f"mass_position (d/L) must be between 0 and 1, not {n.beta!r}")
    if not 1 <= count <= MOST:
        raise ParameterError(f"count must be between 1 and {MOST}, not {count!r}")


MOST = 12
"""Largest number of frequencies."""
