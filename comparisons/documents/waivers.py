"""Waivers: findings that a user allows, each with the reason."""

from __future__ import annotations

import json
import os
import re
import tomllib
from collections.abc import Collection
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from ...reference.errors import UnknownNameError, UsageError
from .reading import read_document

KEYS = ("rule", "reason", "element", "file")
"""Keys of an entry; the first two are required."""

HEADER = re.compile(r"^[ \t]*\[\[[ \t]*waive[ \t]*\]\]", re.MULTILINE)


@dataclass(eq=False)
class Waiver:
    """A comment, or an entry of a file, that allows findings.

    Attributes
    ----------
    rule : str
        Empty if the comment has not the form of a waiver.
    pattern : str or None
        Name of the elements, with the wildcards ``*`` and ``?``; None for all.
    reason : str
    text, file, line
        The comment or entry, and its position.
    required : bool
        True if it concerns this model alone, so that an unused one is reported.
    """

    rule: str
    pattern: str | None
    reason: str
    text: str
    file: str
    line: int
    required: bool = True

    def covers(self, rule: str, *names: str) -> bool:
        """Return True if it allows a finding of a rule on an element with one of these names."""
        named = self.pattern is None or any(fnmatchcase(name, self.pattern) for name in names)
        return rule == self.rule and bool(self.reason) and named


def waivers_of(place: Path, file: str, rules: Collection[str]) -> tuple[Waiver, ...]:
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
        if entry["rule"] not in rules:
            raise UnknownNameError("rule", entry["rule"], rules)
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
