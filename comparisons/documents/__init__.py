"""The JSON documents of the verbs: one type each, from which they are written and described."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

from ...reference.errors import MbcheckError
from .check import Check, Diff, Judge
from .core import SCHEMA, builtin, plain, schema_of
from .features import CompareMaps, Extremes, Reproduce
from .inspect import Inspect
from .motion import Frequencies, Orbit, Simulate
from .tradeoff import Tradeoff

DOCUMENTS: Mapping[str, tuple[Any, str]] = {
    "check": (Check, "Results of a run of checks."),
    "judge": (Judge, "A trajectory that was computed elsewhere, against the reference."),
    "simulate": (Simulate, "A trajectory, and all that is needed to repeat it."),
    "orbit": (Orbit, "The periodic orbit of a scene."),
    "frequencies": (Frequencies, "Modes of the undriven scene about a state of rest."),
    "compare_maps": (CompareMaps, "Two maps on the points that both computed."),
    "reproduce": (Reproduce, "What of the papers holds."),
    "tradeoff": (Tradeoff, "What accuracy costs, and which settings to choose."),
    "extremes": (Extremes, "How far engines can be pushed, and who notices when they break."),
    "diff": (Diff, "What changed between two runs of checks."),
    "inspect": (Inspect, "What is in an MJCF file, how it moves, what it could do without."),
}
"""Type of the document of a verb, and what it is."""


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
    kind, _ = DOCUMENTS[name]
    there = {"schema": SCHEMA, **vars(result), **parts}
    fields = {key: value for key, value in there.items() if key in kind.__annotations__}
    values = plain(msgspec.to_builtins(fields, enc_hook=builtin, str_keys=True))
    try:
        return dict(msgspec.convert(values, kind))
    except msgspec.ValidationError as error:
        raise MbcheckError(
            f"a fault of mbcheck: the document {name!r} is not what docs/json.md says: {error}"
        ) from None


def schema(name: str) -> dict[str, Any]:
    """Return the JSON Schema of a document: ``schema("check")``."""
    kind, meaning = DOCUMENTS[name]
    return schema_of(kind, name, meaning)
