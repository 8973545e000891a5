"""How many steps of `hula_hoop` maps resolve a period of its force, and motions in them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....reference.hula_hoop.equations import HulaHoop, coefficients
from ....reference.scene import Array
from ..orbit_map import Ints
from ..quantity import STEP_COUNTS, Points

MOST_STEPS_PER_FORCE = 8.0
"""No period counts as shorter than that of force or spring divided by this."""


def fastest_rate(p: HulaHoop) -> Any:
    """Return the fastest circular frequency [rad/s] that steps have to resolve.

    That of the force, of the spring with the rod across, or of the rod as it librates about
    the line of the force, shaken by the linear response of the main mass.
    """
    c = coefficients(p)
    slow = np.maximum(c.omega, np.sqrt(c.stiffness * c.inertia / c.determinant))
    impedance = c.stiffness - c.mass * c.omega**2 + 1j * c.damping * c.omega
    response = c.force / np.maximum(np.abs(impedance), 1e-12 * c.stiffness)
    libration = c.omega * np.sqrt(c.coupling * response / c.inertia)
    return np.clip(libration, slow, MOST_STEPS_PER_FORCE * slow)


def step_counts(
    points: Points, spans: Array, per_period: float, coarser: int = 1, counts: Ints = STEP_COUNTS
) -> Ints:
    """Return the number of equal steps in each point's span [s].

    Parameters
    ----------
    points : Points
    spans : array (k,)
    per_period : float
        Steps in the shortest period, unless ``points.step`` tells the longest step.
    coarser : int
        By how much longer the steps may be.
    counts : int array
        Numbers to choose from.
    """
    longest = 2 * np.pi / (fastest_rate(points.parameters) * per_period)
    return points.step_counts(
        np.broadcast_to(spans / coarser, (len(points),)), longest, counts=counts
    )
