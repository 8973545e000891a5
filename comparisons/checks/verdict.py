"""Results of checks, and how an error and a tolerance become a verdict."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from ...reference.scene import Array

Verdict = Literal["pass", "deviation", "known", "skipped", "error"]

PROFILES: Mapping[str, float] = {"strict": 0.875, "default": 1.0, "loose": 3.0}
"""Factor on every tolerance. A right engine needs 1/1.2 = 0.83 of a tolerance whose error
is predicted exactly; ``strict`` stays above that."""


@dataclass(frozen=True)
class Series:
    """What a result is drawn by: the engine's values beside those that they should be.

    Attributes
    ----------
    over : {"time", "step"}
        A trajectory over its times [s]; relative errors over steps [s].
    x, value, reference : array (n,)
    seconds : array (n,), optional
        Wall time of the run with each step [s].
    """

    over: Literal["time", "step"]
    x: Array
    value: Array
    reference: Array
    seconds: Array | None = None


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
    series : Series, optional
        What it was found in, for pictures.
    """

    quantity: str
    unit: str
    value: float
    reference: float
    error: float
    tolerance: float
    reason: str = ""
    series: Series | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class NotJudged:
    """A quantity that a check has nothing to say of, and why; it is skipped."""

    quantity: str
    reason: str


@dataclass(frozen=True)
class Result:
    """One line of a report; the fields but ``series`` are those of the JSON (docs/json.md)."""

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
    series: Series | None = field(default=None, compare=False, repr=False)
    known: str | None = None


def judge(finding: Finding, profile: float) -> tuple[Verdict, str]:
    """Return the verdict on a finding and one line that explains it."""
    tolerance = profile * finding.tolerance
    if not math.isfinite(finding.error) or not math.isfinite(tolerance):
        return "error", f"{finding.quantity} could not be judged: {finding.reason}"
    if finding.error <= tolerance:
        return "pass", finding.reason
    ratio = finding.error / tolerance if tolerance > 0 else math.inf
    return "deviation", f"error is {ratio:.3g} x its tolerance; {finding.reason}"
