"""Sample times on the command line."""

from __future__ import annotations

import math
from decimal import Decimal

from ...reference.errors import UsageError
from ..documents.fields import number_from

MOST_TIMES = 1_000_000
"""Longer lists of times are refused as a slip of the pen."""


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
