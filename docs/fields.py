"""The tables of docs/json.md, from the types of the documents."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mbcheck.comparisons.documents import schema
from mbcheck.comparisons.reports.text import markdown_table


def tables(name: str, seen: set[str]) -> str:
    """Return a table of a document's fields, and one of each object that was not seen before."""
    described = schema(name)
    fresh = {title: part for title, part in described["$defs"].items() if title not in seen}
    seen |= set(fresh)
    first = described["$ref"].rpartition("/")[2]
    return "\n".join(
        ("" if title == first else f"\n`{title}`:\n\n") + table(part["properties"])
        for title, part in fresh.items()
    )


def table(properties: Mapping[str, Any]) -> str:
    """Return a table of fields, with their types and what they mean."""
    rows = [(f"`{key}`", words(part), part["description"]) for key, part in properties.items()]
    return markdown_table(("Field", "Type", "Meaning"), rows)


def words(part: Mapping[str, Any]) -> str:
    """Return a type in words."""
    return " or ".join(dict.fromkeys(alternatives(part)))


def alternatives(part: Mapping[str, Any]) -> Iterator[str]:
    """Yield the types that a value may have."""
    if "$ref" in part:
        yield f"`{part['$ref'].rpartition('/')[2]}`"
    elif "anyOf" in part:
        for one in part["anyOf"]:
            yield from alternatives(one)
    elif "enum" in part:
        yield from (f"`{value}`" for value in part["enum"])
    elif part["type"] == "array":
        items = part.get("prefixItems") or [part["items"]]
        yield f"list of {', '.join(map(words, items))}"
    elif part["type"] == "object":
        yield f"{words(part['additionalProperties'])} by name"
    else:
        yield part["type"]
