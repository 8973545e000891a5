r"""The soft constraint of MuJoCo's documentation ("Computation", constraint model).

A residual r with the rate v is pulled together by ``f = (A + R)^-1 (-b v - d k r - a_0)``. The
impedance d runs from d_0 at ``|r| = 0`` to d_w at ``|r| = width`` as the spline that ``solimp``
(d_0, d_w, width, midpoint, power) describes; ``solref`` gives b and k.
"""

from __future__ import annotations

from typing import Any

import numpy as np

IMPEDANCES = (1e-4, 0.9999)
"""MuJoCo's limits of d, silently kept."""

SOLREF = (0.02, 1.0)
SOLIMP = (0.9, 0.95, 0.001, 0.5, 2.0)
"""MuJoCo's defaults."""


def choose(value: Any, limit: float, below: Any, above: Any, xp: Any) -> Any:
    """Return ``below`` where value < limit, else ``above``."""
    if xp is np:
        return np.where(np.real(value) < limit, below, above)
    if hasattr(xp, "select"):
        return xp.select(xp.lt(value, limit), below, above)
    return below if value.real < limit else above


def impedance(square: Any, solimp: tuple[float, ...], xp: Any = np) -> Any:
    """Return d for a squared residual; ``solimp`` within its limits."""
    zero, full, width, midpoint, power = solimp
    if zero == full or width == 0:
        return (zero + full) / 2
    x = xp.sqrt(square) / width
    rest = choose(x, 1.0, 1 - x, 0.0 * x, xp) / (1 - midpoint)
    start = square / (width * midpoint) ** 2  # keeps the derivative at 0
    near = midpoint * (start if power == 2 else start ** (power / 2))
    far = 1 - (1 - midpoint) * (rest * rest if power == 2 else rest**power)
    return zero + (full - zero) * choose(x, midpoint, near, far, xp)


def clamped(solimp: tuple[float, ...]) -> tuple[float, ...]:
    """Return ``solimp`` within MuJoCo's limits."""
    low, high = IMPEDANCES
    zero, full, width, midpoint, power = solimp
    zero, full, midpoint = (min(high, max(low, value)) for value in (zero, full, midpoint))
    return zero, full, max(0.0, width), midpoint, max(1.0, power)


def reference_spring(solref: tuple[float, float], full: float) -> tuple[float, float]:
    """Return k [1/s^2] and b [1/s] of the reference acceleration."""
    if solref[0] > 0:
        time, ratio = solref
        return 1 / (full * time * ratio) ** 2, 2 / (full * time)
    return -solref[0] / full**2, -solref[1] / full
