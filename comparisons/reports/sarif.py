"""SARIF 2.1.0, which code scanning of GitHub and editors read."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from hashlib import sha256
from typing import Any
from urllib.parse import quote

from .item import ReportItem
from .words import printable

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"

FINGERPRINT = "primaryLocationLineHash"
"""The name under which GitHub seeks the fingerprint of an item, which stays as lines move."""


def sarif(items: Sequence[ReportItem], rules: Mapping[str, tuple[str, str]], version: str) -> str:
    """Return SARIF of the items that have a severity.

    Parameters
    ----------
    items : sequence of ReportItem
    rules : mapping of str to (str, str)
        Finding of each rule, and why it matters.
    version : str
        Version of mbcheck.
    """
    results = [result_of(item) for item in items if item.severity]
    names = list(dict.fromkeys(result["ruleId"] for result in results))
    described = [
        {"id": name, "shortDescription": {"text": short}, "fullDescription": {"text": full}}
        for name, (short, full) in ((name, rules.get(name, (name, name))) for name in names)
    ]
    driver = {"name": "mbcheck", "version": version, "rules": described}
    results = [result | {"ruleIndex": names.index(result["ruleId"])} for result in results]
    run = {"tool": {"driver": driver}, "results": results}
    return json.dumps({"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}, indent=2) + "\n"


def result_of(item: ReportItem) -> dict[str, Any]:
    """Return an item as a SARIF result.

    GitHub shows only items with a file and a line; an item without has its suite and line 1.
    """
    uri = quote(os.fsencode((item.file or printable(item.suite)).replace(os.sep, "/")))
    place = {"artifactLocation": {"uri": uri}, "region": {"startLine": item.line or 1}}
    location = {
        "physicalLocation": place,
        "logicalLocations": [{"fullyQualifiedName": printable(item.id)}],
    }
    numbers = {
        name: value
        for name, value in item.numbers.items()
        if value is not None and not (isinstance(value, float) and not math.isfinite(value))
    }
    name = sha256(f"{uri} {printable(item.id)}".encode()).hexdigest()[:16]
    return {
        "ruleId": item.rule,
        "level": item.severity,
        "message": {"text": printable("; ".join((item.message, *item.details)))},
        "locations": [location],
        "partialFingerprints": {FINGERPRINT: f"{name}:1"},
        "properties": numbers,
    }
