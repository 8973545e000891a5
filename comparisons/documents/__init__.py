"""The JSON documents of the verbs: one type each, from which they are written and described.

Types are loaded when a document is asked for.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

SCHEMA = 1
"""Version of the documents; docs/json.md says what a version promises."""

DOCUMENTS: Mapping[str, tuple[str, str]] = {
    "check": ("check.Check", "Results of a run of checks."),
    "judge": ("check.Judge", "A trajectory that was computed elsewhere, against the reference."),
    "simulate": ("motion.Simulate", "A trajectory, and all that is needed to repeat it."),
    "orbit": ("motion.Orbit", "The periodic orbit of a scene."),
    "frequencies": ("motion.Frequencies", "Modes of the undriven scene about a state of rest."),
    "compare_maps": ("features.CompareMaps", "Two maps on the points that both computed."),
    "boundary": (
        "boundary.Boundary",
        "Where orbits and equilibria lose their stability, as curves.",
    ),
    "reproduce": ("features.Reproduce", "What of the papers holds."),
    "tradeoff": ("tradeoff.Tradeoff", "What accuracy costs, and which settings to choose."),
    "tradeoff_model": ("tradeoff.TradeoffModel", "Which step and integrator an MJCF file needs."),
    "diff": ("check.Diff", "What changed between two runs of checks."),
    "inspect": ("inspect.Inspect", "What is in an MJCF file, and what it could do without."),
    "inspections": ("inspect.Inspections", "What is found in several MJCF files."),
}
"""Module and type of each document, and what it is."""


def document(name: str, result: object, **parts: object) -> dict[str, Any]:
    """Return a document as JSON can hold it: NaN and the infinities are null.

    Parameters
    ----------
    name : str
        Of the document.
    result : object
        Its fields are those of the document; others are left out.
    **parts
        Stand for fields of their name, or are added to them.

    Raises
    ------
    MbcheckError
        If a field is missing, or is not what the document's type says.
    """
    from .core import to_document

    return to_document(type_of(name), {"schema": SCHEMA, **vars(result), **parts})


def schema(name: str) -> dict[str, Any]:
    """Return the JSON Schema of a document: ``schema("check")``."""
    from .core import schema_of

    title = {"title": f"mbcheck {name}", "description": DOCUMENTS[name][1]}
    return schema_of(type_of(name)) | title


def type_of(name: str) -> Any:
    """Return the type of a document."""
    module, _, kind = DOCUMENTS[name][0].partition(".")
    return getattr(import_module(f".{module}", __package__), kind)
