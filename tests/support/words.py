"""Texts with numbers in them, compared."""

import math
import re
from decimal import Decimal

NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
ROUNDING = 1e-7
"""Sizes below which a number is the rounding of a zero."""


def agree(text: str, other: str) -> bool:
    """Return whether two texts have the same words, and numbers that agree to their last digits."""
    if NUMBER.sub("#", text) != NUMBER.sub("#", other):
        return False
    return all(map(_alike, NUMBER.findall(text), NUMBER.findall(other)))


COUNTED = re.compile(rf"({NUMBER.pattern})(%?)")
POINTS = re.compile(r"(\d+) (?:\w+ )?points")


def agree_by_chance(text: str, other: str, points: int) -> bool:
    """Return whether two texts have the same words, and counts that differ as chance allows.

    For counts of points of which a part is chaotic: these hang on the last bit of a processor's
    sine. Counts n may differ by two standard deviations, 2 sqrt(n), shares p of so many points by
    2 sqrt(p (1 - p) / points), rank correlations r by 2 (1 - r^2) / sqrt(points).
    """
    if NUMBER.sub("#", text) != NUMBER.sub("#", other):
        return False
    return all(
        _alike(one, two) or abs(float(one) - float(two)) <= _chance(one, percent, points)
        for (one, percent), (two, _) in zip(
            COUNTED.findall(text), COUNTED.findall(other), strict=True
        )
    )


def _chance(text: str, percent: str, points: int) -> float:
    """Return two standard deviations of a written count, share in per cent, or correlation."""
    value = float(text)
    if percent:
        share = min(max(value / 100, 1 / points), 1 - 1 / points)
        return 200 * math.sqrt(share * (1 - share) / points)
    if text.isdigit():
        return 2 * math.sqrt(max(value, 1.0))
    return 2 * max(1 - value**2, 0.0) / math.sqrt(points)


def _alike(one: str, other: str) -> bool:
    """Return whether two written numbers differ by 2 units of their last digits at most."""
    unit = max(float(Decimal(1).scaleb(_exponent(text))) for text in (one, other))
    sizes = [abs(float(text)) for text in (one, other)]
    return max(sizes) < ROUNDING or abs(float(one) - float(other)) <= 2.001 * unit


def _exponent(text: str) -> int:
    exponent = Decimal(text).as_tuple().exponent
    assert isinstance(exponent, int)
    return exponent
