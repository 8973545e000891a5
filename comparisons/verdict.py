"""Results of checks, and how an error and a tolerance become a verdict."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Verdict = Literal["pass", "deviation", "known", "skipped", "error"]

PROFILES: Mapping[str, float] = {"strict": 0.875, "default": 1.0, "loose": 3.0}
"""Factor on every tolerance. A right engine needs 1/1.2 = 0.83 of a tolerance whose error
is predicted exactly; ``strict`` stays above that."""


@dataclass(frozen=True)
class Finding:
    """One measured quantity against its reference, before it is named and judged.

    Attributes
    ----------
    quantity, unit : str
    value, reference : float
        The engine's and the true value where they differ most; what is an error by nature (a
        residual, a drift) is its own value against 0.
    error : float
        What is compared with the tolerance.
    tolerance : float
    reason : str
        Where the tolerance comes from, and what was seen.
    """

    quantity: str
    unit: str
    value: float
    reference: float
    error: float
    tolerance: float
    reason: str = ""


@dataclass(frozen=True)
class Result:
    """One line of a report; the fields are those of the JSON (see docs/json.md)."""

    id: str
    scene: str
    case: str
    kind: str
    source: str
    engine: str
    model: str
    method: str | None
    quantity: str
    unit: str
    value: float | None
    reference: float | None
    error: float | None
    tolerance: float | None
    verdict: Verdict
    reason: str
    work: Mapping[str, float] = field(default_factory=dict)


def judge(finding: Finding, profile: float) -> tuple[Verdict, str]:
    """Return the verdict on a finding and one line that explains it."""
    tolerance = profile * finding.tolerance
    if not math.isfinite(finding.error) or not math.isfinite(tolerance):
        return "error", f"{finding.quantity} could not be judged: {finding.reason}"
    if finding.error <= tolerance:
        return "pass", finding.reason
    ratio = finding.error / tolerance if tolerance > 0 else math.inf
    return "deviation", f"error is {ratio:.3g} x its tolerance; {finding.reason}"
