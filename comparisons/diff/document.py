"""Reading what ``mbcheck check --json`` has written, of this release or an earlier one."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from ...reference.errors import UsageError
from ..checks.verdict import Result, result_from
from ..documents import SCHEMA
from ..reports.run.results import MEASURES, VERDICTS

WORDS = ("id", "scene", "case", "kind", "source", "engine", "model", "quantity", "unit", "reason")


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

    try:
        content = json.loads(Path(file).read_bytes(), parse_constant=constant)
    except OSError as error:
        raise UsageError(f"cannot read {file!r}: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{file!r} is not JSON: {error}") from None
    if not isinstance(content, dict) or "schema" not in content:
        raise UsageError(f"{file!r} is no document of mbcheck: write one with `check --json`")
    if content["schema"] != SCHEMA:
        raise UsageError(
            f"{file!r} has schema {content['schema']!r}; this mbcheck reads schema {SCHEMA}"
        )
    try:
        return run_of(file, content)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise UsageError(
            f"{file!r} is not what `mbcheck check --json` writes ({type(error).__name__}: {error})"
        ) from None


def run_of(file: str, content: Mapping[str, Any]) -> Document:
    """Return a document from its JSON.

    Raises
    ------
    KeyError, TypeError, ValueError, AttributeError
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
    return Document(
        file,
        words(content["versions"]),
        words(content.get("environment", {})),
        dict(content.get("selection", {})),
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
    for name in WORDS:
        if not isinstance(item[name], str):
            raise TypeError(f"{name} is {item[name]!r}")
    if item["verdict"] not in VERDICTS:
        raise ValueError(f"verdict is {item['verdict']!r}")
    fields: dict[str, Any] = {name: item[name] for name in (*WORDS, "method", "verdict")}
    for name in MEASURES:
        fields[name] = None if item[name] is None else float(item[name])
    return result_from(fields | {"known": item.get("known")})
