"""Which rules are asked, and what is waived from outside a model: files of waivers, baselines."""

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
"""File of waivers that is looked for beside a model."""

KEYS = ("rule", "reason", "element", "file")
"""What an entry of it may say; the first two it must."""

HEADER = re.compile(r"^[ \t]*\[\[[ \t]*waive[ \t]*\]\]", re.MULTILINE)


Baseline = Mapping[tuple[str, str], float | None]
"""Rule and element of findings that were there before, and how bad they were, if known."""


class Selection(NamedTuple):
    """Rules that are asked, and what is waived beside the comments of the file itself."""

    rules: frozenset[str]
    waivers: tuple[Waiver, ...]
    baseline: Baseline


def selection_of(asked: InspectRequest) -> Selection:
    """Return what is asked of a file.

    Raises
    ------
    UsageError
        If a pattern fits no rule, or the file of waivers, or the baseline, cannot be read.
    """
    file = str(asked.path)
    beside = os.path.join(os.path.dirname(file), BESIDE)
    place = asked.waivers or (beside if os.path.isfile(beside) else None)
    waivers = waivers_of(Path(place), file) if place else ()
    old = baseline_of(asked.baseline).get(Path(file).as_posix(), {}) if asked.baseline else {}
    return Selection(rules_of(asked), waivers, old)


def refuse_slips(asked: InspectRequest) -> None:
    """Refuse names that nothing answers to, and files that cannot be read, before any work."""
    rules_of(asked)
    if asked.waivers:
        waivers_of(Path(asked.waivers), "")
    if asked.baseline:
        baseline_of(asked.baseline)


def rules_of(asked: InspectRequest) -> frozenset[str]:
    """Return the rules that are asked.

    Raises
    ------
    UnknownNameError
        If a pattern fits none.
    """
    for pattern in (*asked.select, *asked.ignore):
        if not matching([pattern]):
            raise UnknownNameError("rule", pattern, RULES)
    default = {name for name, rule in RULES.items() if asked.strict or not rule.house}
    return frozenset((matching(asked.select) or default) - matching(asked.ignore))


def matching(patterns: Sequence[str]) -> set[str]:
    """Return the rules that some pattern fits."""
    return {name for name in RULES if any(fnmatchcase(name, pattern) for pattern in patterns)}


def waivers_of(place: Path, file: str) -> tuple[Waiver, ...]:
    """Return the waivers of a TOML file that are about a model.

    Raises
    ------
    UsageError
        If it cannot be read, or an entry is not what it must be.
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
            raise UsageError(f"{where}: an entry is a table of strings")
        odd = [key for key in entry if key not in KEYS]
        if odd:
            raise UnknownNameError("key", odd[0], KEYS)
        missing = [key for key in KEYS[:2] if not entry.get(key, "").strip()]
        if missing:
            raise UsageError(f"{where}: there is no {missing[0]}")
        if entry["rule"] not in RULES:
            raise UnknownNameError("rule", entry["rule"], RULES)
        name = Path(file).name
        if fnmatchcase(name, entry.get("file", "*")) or fnmatchcase(file, entry.get("file", "*")):
            waiver = Waiver(
                rule=entry["rule"],
                pattern=entry.get("element"),
                reason=entry["reason"],
                text=json.dumps(entry),
                file=os.path.relpath(place, Path(file).parent),
                line=line,
                required=entry.get("file") in (name, file),
            )
            waivers.append(waiver)
    return tuple(waivers)


def baseline_of(name: str) -> dict[str, dict[tuple[str, str], float | None]]:
    """Return the findings of a document: file -> rule and element -> how bad it was, if known.

    Raises
    ------
    UsageError
        If it cannot be read, or is no document of ``inspect``.
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
        raise UsageError(f"--baseline: {name} is no document of inspect --json") from None
    return baselines


def unwaived(model: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the findings of an ``inspect`` document that its file does not waive."""
    return [one for one in model["findings"] if one["waived"] is None]
