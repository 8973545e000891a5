"""Sample times that a user gives, and the step on whose grid they lie."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from ...reference.errors import UsageError
from ...reference.scene import Array
from ...reference.solve.solution import sample_times
from ..documents.fields import number_from

MOST_TIMES = 1_000_000
"""Longer lists of times are refused as a slip of the pen."""

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


def times_from(text: str, flag: str) -> list[float]:
    """Return times from ``T1,T2,...`` or ``START:STOP:STEP``.

    A range is START + i STEP in decimal arithmetic, STOP included: as exact as it is typed.

    Raises
    ------
    UsageError
        If it is neither.
    """
    if ":" not in text:
        return [number_from(word.strip(), "--times: a time") for word in text.split(",")]
    words = text.split(":")
    if len(words) != 3:
        raise UsageError(f"--times needs T1,T2,... or START:STOP:STEP, not {text!r}")
    start, stop, step = (decimal(word) for word in words)
    if step <= 0 or stop < start:
        raise UsageError(f"--times {text}: STEP must be positive and STOP not before START")
    intervals = float((stop - start) / step)
    if intervals > MOST_TIMES:
        raise UsageError(f"--times {text}: that is more than {MOST_TIMES} times")
    count = math.floor(intervals * (1 + 1e-12) + 1e-9)
    return [float(start + i * step) for i in range(count + 1)]


def decimal(text: str) -> Decimal:
    """Return a decimal number from the command line.

    Raises
    ------
    UsageError
        If it is none, or too large or small for a float.
    """
    number_from(text, "--times: a time")
    value = Decimal(text.strip())
    if not math.isfinite(float(value)) or (value and not float(value)):
        raise UsageError(f"--times: a time must be finite, not {text!r}")
    return value
