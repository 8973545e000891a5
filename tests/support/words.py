"""Texts with numbers in them, compared."""

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


def _alike(one: str, other: str) -> bool:
    """Return whether two written numbers differ by 2 units of their last digits at most."""
    unit = max(float(Decimal(1).scaleb(_exponent(text))) for text in (one, other))
    sizes = [abs(float(text)) for text in (one, other)]
    return max(sizes) < ROUNDING or abs(float(one) - float(other)) <= 2.001 * unit


def _exponent(text: str) -> int:
    exponent = Decimal(text).as_tuple().exponent
    assert isinstance(exponent, int)
    return exponent
