"""Documents, held against their schemas."""

import json
from importlib.resources import files
from typing import Any

import jsonschema


def schema(name: str) -> dict[str, Any]:
    """Return the schema of a verb's document."""
    schemas = files("mbcheck.comparisons.reports") / "schemas"
    loaded: dict[str, Any] = json.loads((schemas / f"{name}.json").read_text("utf-8"))
    return loaded


def validated(name: str, document: Any) -> dict[str, Any]:
    """Return what a strict reader gets from a document as written, which its schema accepts."""
    loaded: dict[str, Any] = json.loads(json.dumps(document, allow_nan=False))
    jsonschema.Draft202012Validator(schema(name)).validate(loaded)
    assert next(iter(loaded)) == "schema"
    return loaded


def objects(node: Any) -> list[dict[str, Any]]:
    """Return all nodes of a schema that declare properties of an object."""
    below = node.values() if isinstance(node, dict) else node if isinstance(node, list) else ()
    here = [node] if isinstance(node, dict) and node.get("type") == "object" else []
    return here + [item for child in below for item in objects(child)]
