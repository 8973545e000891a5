"""A result dataclass as the JSON document of docs/json.md."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

SCHEMA = 1
"""Version of the JSON documents; docs/json.md says what a version promises."""


def document(result: object, **parts: object) -> dict[str, Any]:
    """Return the JSON document of a dataclass; ``parts`` stand for fields of their name."""
    fields: dict[str, Any] = json_value({"schema": SCHEMA, **vars(result), **parts})
    return fields


def json_value(value: Any) -> Any:
    """Return a value as JSON can hold it; NaN and the infinities become None."""
    if isinstance(value, Mapping):
        return {name: json_value(item) for name, item in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [json_value(item) for item in value]
    return finite(value) if isinstance(value, float) else value


def finite(number: float | None) -> float | None:
    """Return a number as JSON can hold it: None for NaN and the infinities."""
    if number is None or not math.isfinite(number):
        return None
    return int(number) if isinstance(number, int) else float(number)
