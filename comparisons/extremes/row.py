"""One line of the extremes table: what was tried, what came of it, who noticed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ...reference.errors import EngineError

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


def noticer(error: EngineError) -> str:
    """Return who notices a failed run: the engine, or the guard."""
    return ENGINE if error.kind in OWN_KINDS else GUARD


@dataclass(frozen=True)
class Row:
    """One line of the extremes table.

    Attributes
    ----------
    section : str
        One of `SECTIONS`.
    scene, name, engine, model : str
        ``name`` tells within its section and scene what was tried.
    method : str or None
    step : float or None
        [s]
    changed : mapping of str to float or str
        Parameters, initial values and settings that provoke it, by name (SI).
    outcome : str
        One of `OUTCOMES`.
    noticed_by : tuple of str
        All who notice, in the order above; empty where the result is right.
    error, predicted : float or None
        Relative to the size of the quantities, the largest; predicted is what the method's
        order, step and the model's claim leave. In *long* they are the drift of the energy,
        relative, or where none is followed of the phase [rad].
    reason : str
        In one sentence, with the numbers that it comes from.
    values : mapping of str to float
        The section's own numbers: ``h_omega``, ``theory``, drifts, ...
    """

    section: str
    scene: str
    name: str
    engine: str
    model: str
    method: str | None
    step: float | None
    changed: Mapping[str, float | str]
    outcome: str
    noticed_by: tuple[str, ...]
    error: float | None
    predicted: float | None
    reason: str
    values: Mapping[str, float] = field(default_factory=dict)
