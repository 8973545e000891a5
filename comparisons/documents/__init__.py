"""The JSON documents of the verbs: each is written, and described, from the class of a result.

A document holds the fields of the class but those that are `HIDDEN`, and the properties that are
`documented`, see `fields`. Classes are loaded when they are needed.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

SCHEMA = 2
"""Version of the documents; docs/json.md says what a version promises."""

DOCUMENTS: Mapping[str, tuple[str, str]] = {
    "check": ("reports.run.outcome.Report", "Results of a run of checks."),
    "judge": (
        "judge.judge.Judgement",
        "A trajectory that was computed elsewhere, against the reference.",
    ),
    "simulate": (
        "queries.simulate.Simulation",
        "A trajectory, and all that is needed to repeat it.",
    ),
    "orbit": ("queries.orbit.OrbitReport", "The periodic orbit of a scene."),
    "frequencies": (
        "queries.frequencies.Frequencies",
        "Modes of the undriven scene about a state of rest.",
    ),
    "compare_maps": ("maps.compare.MapComparison", "Two maps on the points that both computed."),
    "boundary": (
        "boundary.document.BoundaryDocument",
        "Where orbits and equilibria lose their stability, as curves.",
    ),
    "reproduce": ("papers.outcomes.Findings", "What of the papers holds."),
    "tradeoff": (
        "tradeoff.report.Tradeoff",
        "What accuracy costs, and which settings to choose.",
    ),
    "tradeoff_model": (
        "tradeoff.model.TradeoffModelDocument",
        "Which step and integrator an MJCF file needs.",
    ),
    "compare": (
        "compare.comparison.ModelComparison",
        "What two readings of one model differ in.",
    ),
    "diff": ("diff.changes.Diff", "What changed between two runs of checks."),
    "inspect": (
        "inspect.inspection.Inspection",
        "What is in an MJCF file, and what it could do without.",
    ),
    "inspections": (
        "inspect.batch.InspectionsDocument",
        "What is found in several MJCF files.",
    ),
}
"""Class of each document, below `comparisons`, and what it is."""


def document(name: str, result: object, /, **parts: object) -> dict[str, Any]:
    """Return a document as JSON can hold it: NaN and the infinities are null.

    Parameters
    ----------
    name : str
        Of the document.
    result : object
        Has what the document holds, but for what is in ``parts``.
    **parts
        Fields of the document that ``result`` has otherwise.

    Raises
    ------
    MbcheckError
        If a field is missing, or is not what the document's type says.
    """
    from .core import to_document

    return to_document(type_of(name), result, {"schema": SCHEMA, **parts})


def schema(name: str) -> dict[str, Any]:
    """Return the JSON Schema of a document: ``schema("check")``."""
    from .core import schema_of

    title = {"title": f"mbcheck {name}", "description": DOCUMENTS[name][1]}
    return schema_of(type_of(name)) | title


def type_of(name: str) -> Any:
    """Return the class of a document."""
    module, _, kind = DOCUMENTS[name][0].rpartition(".")
    return getattr(import_module(f"..{module}", __package__), kind)
