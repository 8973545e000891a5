"""Reading what ``mbcheck check --json`` has written."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NoReturn

from msgspec import convert, to_builtins

from ...reference.errors import UsageError
from ..checks.request import CheckRequest
from ..checks.verdict import NOT_APPLICABLE, Result, result_from
from ..documents import SCHEMA
from ..documents.core import record
from ..documents.fields import HIDDEN, documented
from ..documents.reading import read_document
from ..reports.run.outcome import Report


@dataclass(frozen=True)
class Document:
    """One run of checks.

    Attributes
    ----------
    file : str
        file that was read
    environment : mapping of str to str
        what rounding may depend on: python, system, machine, processor, libc
    results : mapping of id to Result
        Without those that stand for an engine that cannot be imported.
    selection : CheckRequest
    not_reached : int
        Number of checks that were planned, and for which there was no time.
    unavailable : mapping of str to str
        Why an engine could not be imported, by its name.
    """

    file: str
    versions: Mapping[str, str]
    environment: Mapping[str, str]
    results: Mapping[str, Result] = field(metadata=HIDDEN)
    selection: CheckRequest = field(metadata=HIDDEN)
    not_reached: int = field(metadata=HIDDEN)
    unavailable: Mapping[str, str] = field(metadata=HIDDEN)

    @property
    @documented
    def result_count(self) -> int:
        """Number of results."""
        return len(self.results)

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
        return run_of(file, convert(content, record(Report, is_root=True)))
    except ValueError as error:
        raise UsageError(f"{file!r} is not what `mbcheck check --json` writes: {error}") from None


def run_of(file: str, content: Any) -> Document:
    """Return a run from its document.

    Raises
    ------
    ValueError
        If an id stands twice.
    """
    results: dict[str, Result] = {}
    unavailable = {}
    for item in content.results:
        result = result_from(to_builtins(item))
        if result.id in results:
            raise ValueError(f"the id {result.id!r} stands twice")
        if result.kind == NOT_APPLICABLE:
            unavailable[result.engine] = result.reason
        else:
            results[result.id] = result
    return Document(
        file,
        content.versions,
        content.environment,
        results,
        CheckRequest(**to_builtins(content.selection)),
        content.checks.not_reached,
        unavailable,
    )
