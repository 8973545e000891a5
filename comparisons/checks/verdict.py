"""Results of checks, and how an error and a tolerance become a verdict."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from ...reference.errors import EngineError
from ...reference.scene import Array
from ..documents.fields import HIDDEN, Number, documented

Verdict = Literal["pass", "deviation", "known", "skipped", "error"]

FAILURES = ("error", "deviation")
"""Verdicts that make a run fail, and that a known deviation covers."""

NOT_APPLICABLE = "-"
"""Placeholder in documents for the scene, case, ... of a missing engine."""

ENGINE, GUARD, HALVING, REFERENCE = "engine", "guard", "halving", "reference"
RULE = "rule:"
"""Witnesses of a fault: the engine itself or its adapter, mbcheck's guard of every run, a rule
known before the run (``rule:<name>``), a run with half the step, or the reference."""

OWN_KINDS = ("raised", "solver", "warning", "step", "start", "model")
"""Kinds of `EngineError` that the engine, or its adapter, raises by itself; the guard finds the
others."""


def detected_by(error: EngineError) -> str:
    """Return who notices a failed run: the engine, or the guard."""
    return ENGINE if error.kind in OWN_KINDS else GUARD


PROFILES: Mapping[str, float] = {"strict": 0.875, "default": 1.0, "loose": 3.0}
"""Factor on every tolerance. A right engine needs 1/1.2 = 0.83 of a tolerance whose error
is predicted exactly; ``strict`` stays above that."""


@dataclass(frozen=True)
class Series:
    """Sampled values and reference, for plotting.

    Attributes
    ----------
    over : {"time", "step"}
        A trajectory over its times [s]; relative errors over steps [s].
    x, value, reference : array (n,)
    """

    over: Literal["time", "step"]
    x: Array
    value: Array
    reference: Array


@dataclass(frozen=True)
class Finding:
    """One measured quantity against its reference, before it is named and judged.

    Attributes
    ----------
    quantity, unit : str
    value, reference : float
        The engine's and the true value where they differ most; an error by nature (a residual, a
        drift) is compared with 0.
    error : float
        What is compared with the tolerance.
    tolerance : float
    reason : str
        Where the tolerance comes from, and what was seen.
    series : Series, optional
        Samples for pictures.
    noticed_by : tuple of str, optional
        Who notices, if it is wrong; by default rules of the run, and the reference.
    """

    quantity: str
    unit: str
    value: float
    reference: float
    error: float
    tolerance: float
    reason: str = ""
    series: Series | None = field(default=None, compare=False, repr=False)
    noticed_by: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Inconclusive:
    """A quantity that a check cannot judge, and the reason; its result is skipped."""

    quantity: str
    reason: str


@dataclass(frozen=True)
class Subject:
    """The subject of a result; `NOT_APPLICABLE` for fields that do not apply.

    Attributes
    ----------
    prefix : str
        the id of a result, without its quantity
    source : str
        `verification`: against the reference ODE; `validation`: against what a paper prints
    engine : str
        engine
    scene : str
        system; `-` if none was reached
    case : str
        parameters with initial state and horizon, by name
    kind : str
        kind of check
    model : str
        the engine's model of the scene
    method : str or None
        integrator, as the engine spells it; null for kinds that use none
    """

    prefix: str = field(metadata=HIDDEN)
    source: str
    engine: str
    scene: str = NOT_APPLICABLE
    case: str = NOT_APPLICABLE
    kind: str = NOT_APPLICABLE
    model: str = NOT_APPLICABLE
    method: str | None = None

    def result(self, quantity: str, verdict: Verdict, reason: str, **more: Any) -> Result:
        """Return a result about it; ``more`` are further fields of `Result`."""
        return Result(**vars(self), quantity=quantity, verdict=verdict, reason=reason, **more)

    def with_verdict(self, finding: Finding | Inconclusive, factor: float, **more: Any) -> Result:
        """Return the verdict on a finding, all tolerances times a factor, see `PROFILES`."""
        if isinstance(finding, Inconclusive):
            return self.result(finding.quantity, "skipped", finding.reason)
        verdict, reason = judge(finding, factor)
        return self.result(
            finding.quantity,
            verdict,
            reason,
            unit=finding.unit,
            value=float(finding.value),
            reference=float(finding.reference),
            error=float(finding.error),
            tolerance=float(factor * finding.tolerance),
            series=finding.series,
            **more,
        )


@dataclass(frozen=True, kw_only=True)
class Result(Subject):
    """One line of a report.

    Attributes
    ----------
    quantity : str
        what was measured
    unit : str
        of the next four; `1` for a number without unit
    value : float or None
        value of the engine, where it differs most from the reference; an error by nature (a
        residual, a drift) is compared with 0
    reference : float or None
        the true value
    error : float or None
        distance to compare with the tolerance
    tolerance : float or None
        largest error that passes, `--profile` included
    verdict : Verdict
        see below
    reason : str
        one line: where the tolerance comes from and what was seen; for `skipped` and `error`, why;
        which numbers are null because they are not finite
    work : mapping of str to float
        what the check cost, the same in all its results: `seconds` of wall time, that of a shared
        reference in the first check that needs it; empty if it did not run to its end
    series : Series, optional
    known : str or None
        why a deviation is known, as the user gave it; null for other verdicts
    traceback : str or None
        where foreign code raised, with its message, in many lines; null if none did
    cause : str or None
        where a deviation comes from, if one mistake alone explains it; else null
    noticed_by : tuple of str
        who notices a deviation, a failure or a refusal, the first to do so first: `engine`, the
        engine itself or its adapter; `guard`, the conditions on every run; `rule:NAME`, a rule
        known before the run; `halving`, a run with half the step; `reference`
    """

    quantity: str
    verdict: Verdict
    reason: str
    unit: str = "1"
    value: float | None = None
    reference: float | None = None
    error: float | None = None
    tolerance: float | None = None
    work: Mapping[str, Number] = field(default_factory=dict)
    series: Series | None = field(default=None, compare=False, repr=False, metadata=HIDDEN)
    known: str | None = None
    traceback: str | None = None
    cause: str | None = None
    noticed_by: tuple[str, ...] = ()

    @property
    @documented
    def id(self) -> str:
        """Source/scene/case/kind/engine/method/quantity; of a row validation/scene/row."""
        return f"{self.prefix}/{self.quantity}"

    @property
    def check_id(self) -> str:
        """Beginning of the ids of all results of its check; a row of a paper has one result."""
        return self.id if self.source == "validation" else self.prefix


def result_from(document: Mapping[str, Any]) -> Result:
    """Return the result of its fields in a document."""
    rest = {**document, "noticed_by": tuple(document.get("noticed_by", ()))}
    return Result(prefix=rest.pop("id").removesuffix(f"/{rest['quantity']}"), **rest)


def judge(finding: Finding, profile: float) -> tuple[Verdict, str]:
    """Return the verdict on a finding and one line that explains it."""
    tolerance = profile * finding.tolerance
    if not math.isfinite(finding.error) or not math.isfinite(tolerance):
        return "error", f"{finding.quantity} could not be judged: {finding.reason}"
    if finding.error <= tolerance:
        return "pass", finding.reason
    ratio = finding.error / tolerance if tolerance > 0 else math.inf
    return "deviation", f"error is {ratio:.3g} x its tolerance; {finding.reason}"
