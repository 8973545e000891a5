"""Results of checks, and how an error and a tolerance become a verdict."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any, Literal

from ...reference.errors import EngineError
from ...reference.scene import Array

Verdict = Literal["pass", "deviation", "known", "skipped", "error"]

NOT_APPLICABLE = "-"
"""What documents have in place of a scene, a case, ... of an engine that is not there."""

ENGINE, GUARD, HALVING, REFERENCE = "engine", "guard", "halving", "reference"
RULE = "rule:"
"""Who notices that something is wrong: the engine itself or its adapter, mbcheck's guard of every
run, a rule known before the run (``rule:<name>``), a run with half the step, or the reference."""

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
    """What a result is drawn by: the engine's values beside those that they should be.

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
        The engine's and the true value where they differ most; what is an error by nature (a
        residual, a drift) is its own value against 0.
    error : float
        What is compared with the tolerance.
    tolerance : float
    reason : str
        Where the tolerance comes from, and what was seen.
    series : Series, optional
        What it was found in, for pictures.
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
    """A quantity that a check has nothing to say of, and why; it is skipped."""

    quantity: str
    reason: str


@dataclass(frozen=True)
class Subject:
    """What a result is about; what does not apply has the word that documents have for it.

    Attributes
    ----------
    prefix : str
        The id of a result, without its quantity.
    source : {"verification", "validation"}
        Against the reference, or against a paper.
    scene, case, kind, engine, model : str
    method : str or None
        None for kinds that use no integrator.
    """

    prefix: str
    source: str
    engine: str
    scene: str = NOT_APPLICABLE
    case: str = NOT_APPLICABLE
    kind: str = NOT_APPLICABLE
    model: str = NOT_APPLICABLE
    method: str | None = None


@dataclass(frozen=True)
class Result:
    """One line of a report.

    Attributes
    ----------
    subject : Subject
    quantity, unit : str
    value, reference, error, tolerance : float or None
        As in `Finding`, the tolerance scaled by the profile; None where nothing was measured.
    verdict : Verdict
    reason : str
    work : mapping of str to float
        ``seconds`` of wall time.
    series : Series, optional
    known : str or None
        Why a deviation is known.
    traceback : str or None
        Where foreign code raised, with its message, in many lines.
    cause : str or None
        Where a deviation comes from, see `diagnosis`.
    noticed_by : tuple of str
        Who notices a deviation, a failure or a refusal, the first to do so first.
    """

    subject: Subject
    quantity: str
    verdict: Verdict
    reason: str
    unit: str = "1"
    value: float | None = None
    reference: float | None = None
    error: float | None = None
    tolerance: float | None = None
    work: Mapping[str, float] = field(default_factory=dict)
    series: Series | None = field(default=None, compare=False, repr=False)
    known: str | None = None
    traceback: str | None = None
    cause: str | None = None
    noticed_by: tuple[str, ...] = ()

    @property
    def id(self) -> str:
        """The name of the result, which stays from release to release."""
        return f"{self.subject.prefix}/{self.quantity}"

    @property
    def check_id(self) -> str:
        """What the ids of all results of its check begin with; a row has one, its own."""
        return self.id if self.source == "validation" else self.subject.prefix

    @property
    def scene(self) -> str:
        """The scene of the subject."""
        return self.subject.scene

    @property
    def case(self) -> str:
        """The case of the subject."""
        return self.subject.case

    @property
    def kind(self) -> str:
        """The kind of check of the subject."""
        return self.subject.kind

    @property
    def source(self) -> str:
        """The source of the subject."""
        return self.subject.source

    @property
    def engine(self) -> str:
        """The engine of the subject."""
        return self.subject.engine

    @property
    def model(self) -> str:
        """The model of the subject."""
        return self.subject.model

    @property
    def method(self) -> str | None:
        """The method of the subject."""
        return self.subject.method

    def as_dict(self) -> dict[str, Any]:
        """Return the fields of the JSON (docs/json.md), without what pictures are drawn from."""
        about = asdict(self.subject)
        del about["prefix"]
        mine = {item.name: getattr(self, item.name) for item in fields(self)}
        del mine["subject"], mine["series"]
        both = {"id": self.id} | about | mine
        return {name: both[name] for name in RESULT_FIELDS}


RESULT_FIELDS = (
    "id", "scene", "case", "kind", "source", "engine", "model", "method", "quantity", "unit",
    "value", "reference", "error", "tolerance", "verdict", "reason", "work", "known", "traceback",
    "cause", "noticed_by",
)  # fmt: skip
"""Fields of a result in documents, in their order."""


def result_from(document: Mapping[str, Any]) -> Result:
    """Return the result that a document holds, see `Result.as_dict`."""
    rest = {**document, "noticed_by": tuple(document.get("noticed_by", ()))}
    prefix = rest.pop("id").removesuffix(f"/{rest['quantity']}")
    about = {
        item.name: rest.pop(item.name)
        for item in fields(Subject)
        if item.name != "prefix" and item.name in rest
    }
    return Result(Subject(prefix, **about), **rest)


def judge(finding: Finding, profile: float) -> tuple[Verdict, str]:
    """Return the verdict on a finding and one line that explains it."""
    tolerance = profile * finding.tolerance
    if not math.isfinite(finding.error) or not math.isfinite(tolerance):
        return "error", f"{finding.quantity} could not be judged: {finding.reason}"
    if finding.error <= tolerance:
        return "pass", finding.reason
    ratio = finding.error / tolerance if tolerance > 0 else math.inf
    return "deviation", f"error is {ratio:.3g} x its tolerance; {finding.reason}"
