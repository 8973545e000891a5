"""What an axis over a parameter is, of a map or of a window."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...reference.errors import UsageError


@dataclass(frozen=True)
class ParameterRange:
    """A parameter, and its range on an axis.

    Raises
    ------
    UsageError
        If it is none.
    """

    name: str
    low: float
    high: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise UsageError(
                f"axis {self.name}: it must go from a lower to a higher finite number, not from "
                f"{self.low!r} to {self.high!r}"
            )
