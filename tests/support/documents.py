"""Documents, held against their schemas."""

import json
from typing import Any

import jsonschema

from mbcheck.comparisons.documents import schema


def validated(name: str, document: Any) -> dict[str, Any]:
    """Return what a strict reader gets from a document as written, which its schema accepts."""
    loaded: dict[str, Any] = json.loads(json.dumps(document, allow_nan=False))
    jsonschema.Draft202012Validator(schema(name)).validate(loaded)
    assert next(iter(loaded)) == "schema"
    return loaded
