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
        "A trajectory that was computed elsewhere, compared with the reference.",
    ),
    "simulate": (
        "queries.simulate.Simulation",
        "A trajectory, with the settings that repeat it.",
    ),
    "orbit": ("queries.orbit.OrbitReport", "The periodic orbit of a scene."),
    "frequencies": (
        "queries.frequencies.Frequencies",
        "Modes of the undriven scene about a state of rest.",
    ),
    "compare_maps": ("maps.compare.MapComparison", "Two maps on the points that both computed."),
    "boundary": (
        "boundary.document.BoundaryDocument",
        "Boundaries of stability of orbits and equilibria, as curves.",
    ),
    "reproduce": ("papers.outcomes.Findings", "Verdicts on the claims of the papers."),
    "tradeoff": (
        "tradeoff.report.Tradeoff",
        "Cost and accuracy of settings, and which to choose.",
    ),
    "tradeoff_model": (
        "tradeoff.model.TradeoffModelDocument",
        "Step and integrator that an MJCF file needs.",
    ),
    "compare": (
        "compare.comparison.ModelComparison",
        "Differences of two readings of one model.",
    ),
    "diff": ("diff.changes.Diff", "Changes between two runs of checks."),
    "inspect": (
        "inspect.inspection.Inspection",
        "Contents, modes and mistakes of an MJCF file.",
    ),
    "inspections": (
        "inspect.batch.InspectionsDocument",
        "Findings in several MJCF files.",
    ),
}
"""Class of each document, below `comparisons`, and its content."""


def document(name: str, result: object, /, **parts: object) -> dict[str, Any]:
    """Return a document as JSON can hold it: NaN and the infinities are null.

    Parameters
    ----------
    name : str
        Of the document.
    result : object
        Has the fields of the document, but those in ``parts``.
    **parts
        Fields of the document in place of those of ``result``.

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
