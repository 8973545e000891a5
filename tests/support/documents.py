"""Documents held against their schemas, and the fields of these as lines of text."""

import json
from collections.abc import Iterator
from typing import Any

import jsonschema

from mbcheck.comparisons.documents import schema


def validated(name: str, document: Any) -> dict[str, Any]:
    """Return what a strict reader gets from a document as written, which its schema accepts."""
    loaded: dict[str, Any] = json.loads(json.dumps(document, allow_nan=False))
    jsonschema.Draft202012Validator(schema(name)).validate(loaded)
    assert next(iter(loaded)) == "schema"
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


def fields(schema: dict[str, Any]) -> Iterator[str]:
    """Yield a line for each field of a schema: its path, and the types that it may have."""
    yield from below(schema, schema.get("$defs", {}), "")


def below(node: dict[str, Any], parts: dict[str, Any], path: str) -> Iterator[str]:
    """Yield the lines of what stands below a node of a schema."""
    for one in variants(node, parts):
        for name, value in one.get("properties", {}).items():
            optional = "" if name in one.get("required", ()) else "?"
            yield f"{path}{name}{optional}: {' '.join(sorted(types(value, parts)))}"
            yield from below(value, parts, f"{path}{name}.")
        for key, mark in (("items", "[]."), ("additionalProperties", "{}.")):
            if isinstance(one.get(key), dict):
                yield from below(one[key], parts, f"{path.removesuffix('.')}{mark}")


def variants(node: dict[str, Any], parts: dict[str, Any]) -> list[dict[str, Any]]:
    """Return what a node may be, with references followed."""
    if "anyOf" in node:
        return [one for part in node["anyOf"] for one in variants(part, parts)]
    return [node | parts[node["$ref"].rpartition("/")[2]]] if "$ref" in node else [node]


def types(node: dict[str, Any], parts: dict[str, Any]) -> set[str]:
    """Return the types of a value, what a list or a map holds in brackets; values of a choice."""
    found: set[str] = set()
    for one in variants(node, parts):
        words = one.get("enum", [one["const"]] if "const" in one else None)
        if words is not None:
            found |= {repr(word) for word in words}
            continue
        for kind in [one["type"]] if isinstance(one["type"], str) else one["type"]:
            inner = {"array": "items", "object": "additionalProperties"}.get(kind, "")
            held = types(one[inner], parts) if isinstance(one.get(inner), dict) else set()
            found.add(f"{kind}({' '.join(sorted(held))})" if held else kind)
    return found
