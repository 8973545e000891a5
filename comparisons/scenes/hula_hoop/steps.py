"""How many steps of `hula_hoop` maps resolve a period of its force, and motions in them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....reference.hula_hoop.equations import HulaHoop, coefficients
from ....reference.scene import Array, Case
from ...engines.registry import REFERENCE
from ..flow import Flow, chosen
from ..quantity import Points

Places = NDArray[np.int_]

MOST_STEPS_PER_FORCE = 8.0
"""No period counts as shorter than that of force or spring divided by this."""

FEW = np.array(sorted({m << j for j in range(24) for m in (1, 3)}))
"""Numbers of steps that are taken: few, so that points share them."""
MORE = np.array(sorted({m << j for j in range(24) for m in (4, 5, 6, 7)}))
"""The same for long spans."""


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
    points: Points, spans: Array, per_period: float, coarser: int = 1, allowed: Places = FEW
) -> Places:
    """Return how many equal steps each point's span [s] is gone through in.

    Parameters
    ----------
    points : Points
    spans : array (k,)
    per_period : float
        Steps in the shortest period, unless ``points.step`` tells the longest step.
    coarser : int
        By how much longer the steps may be.
    allowed : int array
        Numbers to choose from.
    """
    longest = points.step or 2 * np.pi / (fastest_rate(points.parameters) * per_period)
    wanted = np.broadcast_to(spans / (coarser * longest), (len(points),))
    return allowed[np.searchsorted(allowed, wanted * (1 - 1e-9))]


def advance(
    flow: Flow, which: Places, states: Array, start: Any, spacing: Array, count: int, steps: Places
) -> Array:
    """Call `Flow` with a number of ``steps`` (m,) of each row's own; returns (4, m, count).

    The reference takes the steps of all rows together, while they last: its time goes into
    calls rather than arithmetic.
    """
    counts = np.unique(steps)
    if flow.points.engine != REFERENCE or len(counts) == 1:
        return flow(which, states, start, spacing, count, steps)
    found = np.empty((*states.shape, count))
    start = np.broadcast_to(start, len(which))
    step = spacing / steps
    legs = [
        (np.flatnonzero(steps >= end), int(begin), int(end))
        for begin, end in zip([0, *counts], counts, strict=False)
    ]
    states = states.copy()
    for i in range(count):
        for rows, begin, end in legs:
            time = start[rows] + i * spacing[rows] + begin * step[rows]
            length = (end - begin) * step[rows]
            now = states[:, rows]
            states[:, rows] = flow(which[rows], now, time, length, 1, end - begin)[..., 0]
        found[..., i] = states
    return found


def order_of(points: Points) -> int:
    """Return the order of the engine's method."""
    case = Case(points.scene.name, "point", points.one(0))
    return chosen(points, case)[2].order
