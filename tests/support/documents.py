"""Documents held against their schemas."""

import json
import re
from typing import Any

import jsonschema

from mbcheck.comparisons.documents import schema

ID = re.compile(
    r"(verification|validation)(/[\w.+-]+){4}/[\w.+-]+(@[\w.+-]+)?/[\w.+-]+"
    r"|validation(/[a-z0-9_]+){2}",
    re.ASCII,
)


def validated(name: str, document: Any) -> dict[str, Any]:
    """Return what a strict reader gets from a document as written, which its schema accepts."""
    loaded: dict[str, Any] = json.loads(json.dumps(document, allow_nan=False))
    jsonschema.Draft202012Validator(schema(name)).validate(loaded)
    assert next(iter(loaded)) == "schema"
    for result in loaded["results"] if name in ("check", "judge") else ():
        assert ID.fullmatch(result["id"])
        numbers = (result[name] for name in ("value", "reference", "error", "tolerance"))
        assert result["verdict"] not in ("pass", "deviation") or None not in numbers
        assert result["verdict"] == "pass" or result["reason"]
    return loaded
