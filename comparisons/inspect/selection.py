"""Selected rules, and waivers from outside a model: files of waivers, baselines."""

from __future__ import annotations

import json
import os
import re
import tomllib
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, NamedTuple

from ...reference.errors import UnknownNameError, UsageError
from ..documents.reading import read_document
from .mujoco.source import Waiver
from .request import InspectRequest
from .rules.table import RULES

BESIDE = "mbcheck-inspect.toml"
"""Name of the file of waivers in the folder of a model."""

KEYS = ("rule", "reason", "element", "file")
"""Keys of an entry in a file of waivers; the first two are required."""

HEADER = re.compile(r"^[ \t]*\[\[[ \t]*waive[ \t]*\]\]", re.MULTILINE)

Baseline = Mapping[tuple[str, str], float | None]
"""Rule and element of each known finding -> its measure, if it has one."""


class Selection(NamedTuple):
    """Selected rules, and waivers beside the comments of the file."""

    rules: frozenset[str]
    waivers: tuple[Waiver, ...]
    baseline: Baseline


def selection_of(request: InspectRequest) -> Selection:
    """Return the selected rules, the waivers and the baseline of a file.

    Raises
    ------
    UsageError
        If a pattern matches no rule, or the file of waivers, or the baseline, cannot be read.
    """
    file = str(request.path)
    beside = os.path.join(os.path.dirname(file), BESIDE)
    place = request.waivers or (beside if os.path.isfile(beside) else None)
    waivers = waivers_of(Path(place), file) if place else ()
    known = baseline_of(request.baseline) if request.baseline else {}
    return Selection(rules_of(request), waivers, known.get(Path(file).as_posix(), {}))


def refuse_slips(request: InspectRequest) -> None:
    """Refuse unknown rules, and files that cannot be read, before any work."""
    rules_of(request)
    if request.waivers:
        waivers_of(Path(request.waivers), "")
    if request.baseline:
        baseline_of(request.baseline)


def rules_of(request: InspectRequest) -> frozenset[str]:
    """Return the selected rules.

    Raises
    ------
    UnknownNameError
        If a pattern matches none.
    """

    def matching(patterns: Sequence[str]) -> set[str]:
        return {name for name in RULES if any(fnmatchcase(name, pattern) for pattern in patterns)}

    for pattern in (*request.select, *request.ignore):
        if not matching([pattern]):
            raise UnknownNameError("rule", pattern, RULES)
    default = {name for name, rule in RULES.items() if request.strict or not rule.house}
    return frozenset((matching(request.select) or default) - matching(request.ignore))


def waivers_of(place: Path, file: str) -> tuple[Waiver, ...]:
    """Return the waivers of a TOML file that concern a model.

    Raises
    ------
    UsageError
        If it cannot be read, or an entry is invalid.
    """
    text, content = read_document(place, "TOML", tomllib.loads, "--waivers: ")
    for key in content:
        if key != "waive":
            raise UnknownNameError(f"table of {place}", key, ("waive",))
    entries = content.get("waive", [])
    entries = entries if isinstance(entries, list) else [entries]
    lines = [text[: match.start()].count("\n") + 1 for match in HEADER.finditer(text)]
    waivers = []
    for number, entry in enumerate(entries):
        line = lines[number] if number < len(lines) else 1
        where = f"{place}, line {line}"
        if not isinstance(entry, dict) or not all(isinstance(v, str) for v in entry.values()):
            raise UsageError(f"{where}: an entry must be a table of strings")
        odd = [key for key in entry if key not in KEYS]
        if odd:
            raise UnknownNameError("key", odd[0], KEYS)
        missing = [key for key in KEYS[:2] if not entry.get(key, "").strip()]
        if missing:
            raise UsageError(f"{where}: add the missing {missing[0]}")
        if entry["rule"] not in RULES:
            raise UnknownNameError("rule", entry["rule"], RULES)
        names = (Path(file).name, file)
        if any(fnmatchcase(name, entry.get("file", "*")) for name in names):
            waivers.append(
                Waiver(
                    rule=entry["rule"],
                    pattern=entry.get("element"),
                    reason=entry["reason"],
                    text=json.dumps(entry),
                    file=os.path.relpath(place, Path(file).parent),
                    line=line,
                    required=entry.get("file") in names,
                )
            )
    return tuple(waivers)


def baseline_of(name: str) -> dict[str, dict[tuple[str, str], float | None]]:
    """Return the findings of a document: file -> rule and element -> measure, if any.

    Raises
    ------
    UsageError
        If it cannot be read, or is not a document of ``inspect``.
    """
    _, content = read_document(name, "JSON", json.loads, "--baseline: ")
    baselines: dict[str, dict[tuple[str, str], float | None]] = {}
    try:
        for model in content.get("models", [content]):
            known = baselines.setdefault(Path(model["file"]).as_posix(), {})
            for one in unwaived(model):
                key = one["rule"], one["element"]
                known[key] = max(known.get(key) or 0.0, one["measure"] or 0.0) or None
    except (KeyError, TypeError, AttributeError):
        raise UsageError(f"--baseline: {name} is not a document of inspect --json") from None
    return baselines


def unwaived(model: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the findings of an ``inspect`` document that are not waived."""
    return [one for one in model["findings"] if one["waived"] is None]
