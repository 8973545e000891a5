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


SARIF = {
    "type": "object",
    "required": ["version", "runs", "$schema"],
    "properties": {
        "version": {"const": "2.1.0"},
        "runs": {
            "minItems": 1,
            "items": {
                "required": ["tool", "results"],
                "properties": {
                    "tool": {
                        "required": ["driver"],
                        "properties": {"driver": {"required": ["name", "version", "rules"]}},
                    },
                    "results": {"items": {"$ref": "#/$defs/result"}},
                },
            },
        },
    },
    "$defs": {
        "result": {
            "required": ["ruleId", "ruleIndex", "level", "message", "locations"],
            "properties": {
                "level": {"enum": ["error", "warning", "note"]},
                "message": {
                    "required": ["text"],
                    "properties": {"text": {"type": "string", "minLength": 1}},
                },
                "locations": {"minItems": 1, "items": {"$ref": "#/$defs/location"}},
                "partialFingerprints": {"additionalProperties": {"type": "string"}},
            },
        },
        "location": {
            "required": ["physicalLocation"],
            "properties": {
                "physicalLocation": {
                    "required": ["artifactLocation", "region"],
                    "properties": {
                        "artifactLocation": {
                            "required": ["uri"],
                            "properties": {"uri": {"pattern": "^[!-~]+$"}},
                        },
                        "region": {"properties": {"startLine": {"minimum": 1}}},
                    },
                }
            },
        },
    },
}
"""What the schema of SARIF 2.1.0 and code scanning of GitHub require."""


def results_of_sarif(text: str) -> list[dict[str, Any]]:
    """Return the results of SARIF, which fits `SARIF` and whose rules are those it names."""

    def constant(word: str) -> None:
        raise ValueError(f"{word} is no JSON")

    loaded = json.loads(text, parse_constant=constant)
    jsonschema.Draft202012Validator(SARIF).validate(loaded)
    (run,) = loaded["runs"]
    for one in run["results"]:
        rule = run["tool"]["driver"]["rules"][one["ruleIndex"]]
        assert rule["id"] == one["ruleId"]
        assert rule["shortDescription"]["text"]
    hashes = [tuple(one["partialFingerprints"].values()) for one in run["results"]]
    assert len(set(hashes)) == len(hashes)
    found: list[dict[str, Any]] = run["results"]
    return found
