"""Reading what ``mbcheck check --json`` has written, of this release or an earlier one."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, NoReturn

from msgspec import ValidationError, convert

from ...reference.errors import UsageError
from ..checks.verdict import Result, result_from
from ..documents import SCHEMA, check
from ..documents.reading import read_document
from ..reports.run.results import MEASURES

FIELDS = (
    "id", "scene", "case", "kind", "source", "engine", "model", "quantity", "unit", "reason",
    "method", "verdict", *MEASURES,
)  # fmt: skip
"""Fields of a result that are compared."""


@dataclass(frozen=True)
class Document:
    """One run of checks.

    Attributes
    ----------
    file : str
    versions, environment : mapping of str to str
        ``environment`` is empty in documents that did not have it yet, and so is the next.
    selection : mapping
    not_reached : int
        Number of checks that were planned, and for which there was no time.
    results : mapping of id to Result
        Without those that stand for an engine that cannot be imported.
    unavailable : mapping of str to str
        Why an engine could not be imported, by its name.
    """

    file: str
    versions: Mapping[str, str]
    environment: Mapping[str, str]
    selection: Mapping[str, Any]
    not_reached: int
    results: Mapping[str, Result]
    unavailable: Mapping[str, str]

    @property
    def engines(self) -> tuple[str, ...]:
        """Engines that have results."""
        return tuple(dict.fromkeys(result.engine for result in self.results.values()))


def read(file: str) -> Document:
    """Return the ``check`` document of a file.

    Raises
    ------
    UsageError
        If it cannot be read, or is no such document of a schema that is known here.
    """

    def constant(word: str) -> NoReturn:
        raise ValueError(f"{word} is no JSON")

    _, content = read_document(file, "JSON", partial(json.loads, parse_constant=constant))
    if not isinstance(content, dict) or "schema" not in content:
        raise UsageError(f"{file!r} is no document of mbcheck: write one with `check --json`")
    if content["schema"] != SCHEMA:
        raise UsageError(
            f"{file!r} has schema {content['schema']!r}; this mbcheck reads schema {SCHEMA}"
        )
    try:
        return run_of(file, content)
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        why = f"there is no {error}" if isinstance(error, KeyError) else error
        raise UsageError(f"{file!r} is not what `mbcheck check --json` writes: {why}") from None


def run_of(file: str, content: Mapping[str, Any]) -> Document:
    """Return a document from its JSON.

    Raises
    ------
    KeyError, TypeError, ValueError, AttributeError, OverflowError
        If it is not as in docs/json.md.
    """
    results: dict[str, Result] = {}
    unavailable = {}
    for item in content["results"]:
        result = read_result(item)
        if result.id in results:
            raise ValueError(f"the id {result.id!r} stands twice")
        if result.kind == "-":
            unavailable[result.engine] = result.reason
        else:
            results[result.id] = result
    selection = convert(content.get("selection", {}), dict[str, Any])
    return Document(
        file,
        words(content["versions"]),
        words(content.get("environment", {})),
        typed(check.Selection, selection, selection),
        int(content.get("checks", {}).get("not_reached", 0)),
        results,
        unavailable,
    )


def words(table: Mapping[str, Any]) -> dict[str, str]:
    """Return a table of texts."""
    return {name: str(text) for name, text in table.items()}


def read_result(item: Mapping[str, Any]) -> Result:
    """Return one result from its JSON.

    Raises
    ------
    KeyError, TypeError, ValueError
    """
    known = typed(check.Result, {"known": None, **item}, ["known"])
    return result_from(typed(check.Result, item, FIELDS) | known)


def typed(kind: Any, values: Mapping[str, Any], names: Iterable[str]) -> dict[str, Any]:
    """Return some fields of a document, each of the type that it has there.

    Raises
    ------
    KeyError, TypeError, ValueError
    """
    types = kind.__annotations__
    fields = {}
    for name in names:
        try:
            fields[name] = convert(values[name], types.get(name, Any))
        except ValidationError as error:
            raise ValueError(f"{name} is {values[name]!r:.40}: {error}") from None
    return fields
