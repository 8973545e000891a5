"""Sample times that a user gives, and the step on whose grid they lie."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from ...reference.errors import UsageError
from ...reference.scene import Array
from ...reference.solve.solution import sample_times

SHORTEST_STEP = 1 / 1024
"""Times that need a step below this share of the default step have no spacing in common."""

SHORTEST_RUN = 1e-150
"""Shortest run [s]; no number is left for the squares of the steps of a much shorter one."""

MOST_STEPS = 10**8
"""A default step that needs more steps is refused, since the run would take hours; a step that the
user gives may need more."""

RATIONAL = 8 * float(np.finfo(float).eps)
"""Relative distance within which a time is taken for a rational number."""


def times_array(times: ArrayLike) -> Array:
    """Return sample times as an array (n_t,).

    Raises
    ------
    UsageError
        If they are not numbers in one row, finite, increasing and not negative, the last
        positive.
    """
    try:
        row = np.asarray(times, dtype=float)
    except (TypeError, ValueError):
        raise UsageError("sample times must be numbers") from None
    if row.ndim != 1:
        raise UsageError("sample times must be one row of numbers")
    row = sample_times(row, 0.0)
    if row[-1] < SHORTEST_RUN:
        raise UsageError(
            f"nothing to simulate: the last sample time must be {SHORTEST_RUN:g} s or more"
        )
    return row


def step_for(times: Array, longest: float) -> float:
    """Return the longest step [s], up to a limit, on whose grid from 0 all times lie.

    Raises
    ------
    UsageError
        If the times share no spacing that is not far shorter, or steps are too many.
    """
    if not times[-1] / MOST_STEPS <= longest:
        raise UsageError(
            f"the fastest motion here asks for steps of {longest:.3g} s, more than "
            f"{MOST_STEPS:.0e} of them; choose other parameters, a shorter run, or give the step"
        )
    spacing = common_spacing(times)
    step = float(spacing / math.ceil(spacing / longest))
    if step < SHORTEST_STEP * longest:
        raise UsageError(
            f"these times need a step of {step:.3g} s, far shorter than the method's "
            f"{longest:.3g} s; choose times on a coarser grid, or give the step"
        )
    return step


def common_spacing(times: Array) -> Fraction:
    """Return the greatest common divisor of times taken as rational numbers."""
    exact = [rational(float(time)) for time in times]
    unit = math.lcm(*(time.denominator for time in exact))
    return Fraction(math.gcd(*(int(time * unit) for time in exact)), unit)


def rational(value: float) -> Fraction:
    """Return a rational number of small denominator that rounds to a value."""
    exact = Fraction(value)
    for digits in range(1, 16):
        near = exact.limit_denominator(10**digits)
        if abs(near - exact) <= RATIONAL * exact:
            return near
    return exact
