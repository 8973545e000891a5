"""One line of the extremes table: what was tried, what came of it, who noticed; and its task."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, NamedTuple

from ...reference.errors import EngineError
from ..checks.rules.cautions import cautions
from ..documents.fields import NULLABLE, Number
from ..engines.setup import Setup

SECTIONS = ("limits", "parameters", "starts", "long", "failures")

RIGHT, WRONG, FAILED, REFUSED, SKIPPED = "right", "wrong", "failed", "refused", "skipped"
OUTCOMES: Mapping[str, str] = {
    RIGHT: "within the error that is predicted",
    WRONG: "finite, and wrong",
    FAILED: "no result, and the reason is named",
    REFUSED: "the model or the method is not to be had there, and says so",
    SKIPPED: "cannot be judged, with the reason",
}

ENGINE, GUARD, HALVING, REFERENCE = "engine", "guard", "halving", "reference"
RULE = "rule:"
"""Who notices: the engine itself, the guard, an a-priori rule (``rule:<name>``), a run with half
the step, or only the reference. A right result needs nobody."""

OWN_KINDS = ("raised", "solver", "warning", "step", "start", "model")
"""Kinds of `EngineError` that the engine, or its adapter, raises by itself; the guard finds the
others."""


def detected_by(error: EngineError) -> str:
    """Return who notices a failed run: the engine, or the guard."""
    return ENGINE if error.kind in OWN_KINDS else GUARD


def rules_against(setup: Setup, horizon: float) -> tuple[str, ...]:
    """Return the rules that warn of a run over a horizon [s], each once, as they notice a row."""
    return tuple(dict.fromkeys(f"{RULE}{item.rule}" for item in cautions(setup, horizon)))


@dataclass(frozen=True)
class Row:
    """One line of the extremes table.

    Attributes
    ----------
    section : str
        part of the table
    name : str
        what was tried
    method : str or None
        integrator; null if the task died
    step : float or None
        step [s]
    changed : mapping of str to float or str
        parameters, initial values and settings that provoke it [SI]
    outcome : {"right", "wrong", "failed", "refused", "skipped"}
        what came of it
    noticed_by : tuple of str
        all who notice: `engine`, `guard`, `rule:<name>`, `halving`, `reference`; empty if it is
        right
    error : float or None
        relative, the largest of all observables [1]; in *long* the relative drift of the energy, or
        the phase [rad]; null if there is none
    predicted : float or None
        what the method and the model leave of it, likewise
    reason : str
        one sentence, with its numbers
    values : mapping of str to float
        the section's own numbers: `h_omega`; `borne`, the longest step that was borne; drifts with
        `_predicted` and `_slack`; `asked` periods; `reference_bound`; ...
    """

    section: str
    scene: str
    name: str
    engine: str
    model: str
    method: str | None = None
    step: Annotated[float | None, NULLABLE] = None
    changed: Mapping[str, Number | str] = field(default_factory=dict)
    outcome: str = FAILED
    noticed_by: tuple[str, ...] = ()
    error: Annotated[float | None, NULLABLE] = None
    predicted: Annotated[float | None, NULLABLE] = None
    reason: str = ""
    values: Mapping[str, Number] = field(default_factory=dict)

    @classmethod
    def of(cls, section: str, name: str, setup: Setup, **filled: Any) -> Row:
        """Return the row of a setup, with some of its fields filled."""
        method = setup.method.name if setup.method else None
        who = (setup.case.scene, name, setup.engine.name, setup.model, method)
        return cls(section, *who, setup.step, **filled)

    def failed(self, error: EngineError, rules: tuple[str, ...] = ()) -> Row:
        """Return the row of a run that failed."""
        noticed = (detected_by(error), *rules)
        return replace(self, outcome=FAILED, noticed_by=noticed, reason=f"{error.kind}: {error}")

    def refused(self, reason: str, noticed_by: tuple[str, ...] = (ENGINE,)) -> Row:
        """Return the row of a run that is not to be had."""
        return replace(self, outcome=REFUSED, noticed_by=noticed_by, reason=reason)

    def skipped(self, reason: object, rules: tuple[str, ...] = ()) -> Row:
        """Return the row of a run that cannot be judged."""
        return replace(self, outcome=SKIPPED, noticed_by=rules, reason=str(reason))

    def compared(self, measured: float, expected: float, tolerance: float) -> Row:
        """Return the row of a limit: right within a relative tolerance of what is expected."""
        error = abs(measured / expected - 1)
        outcome, noticed_by = (RIGHT, ()) if error <= tolerance else (WRONG, (REFERENCE,))
        return replace(
            self, outcome=outcome, noticed_by=noticed_by, error=error, predicted=tolerance
        )


class Provocation(NamedTuple):
    """One extreme of one scene by one engine, ready for a process of its own.

    Attributes
    ----------
    section, scene, name, engine : str
        As in the row of a task that died.
    call : callable
        No arguments, gives the rows; picklable (a module's function or a partial of one with plain
        arguments), for a worker process calls it.
    """

    section: str
    scene: str
    name: str
    engine: str
    call: Callable[[], list[Row]]
