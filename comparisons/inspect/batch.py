"""Many files: which they are, and what they come to."""

from __future__ import annotations

import glob
import os
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...reference.errors import MbcheckError, UsageError
from ..documents import document
from ..documents.reading import read_bytes
from ..reports.item import Outcome, ReportItem
from ..reports.words import plural
from .mujoco.source import ROOT, OtherRootError, read
from .selection import unwaived
from .subject import SEVERITIES, Severity

FAIL_ON: Mapping[str, tuple[Severity, ...]] = {
    "error": SEVERITIES[:1],
    "warning": SEVERITIES[:2],
    "note": SEVERITIES,
    "never": (),
}
"""Which findings make exit code 1."""

BEGIN = re.compile(rf"<{ROOT}[\s/>]".encode())
"""How MJCF begins, whether or not it can be parsed."""

WILD = re.compile(r"[*?\[]")


def files_of(names: Sequence[str], whole: bool = False) -> list[str]:
    """Return the MJCF files that files, folders and patterns name, each once.

    Of a folder, and of a pattern, those that are no MJCF or that another of them includes are left
    out; of all names, if ``whole``.

    Raises
    ------
    UsageError
        If a folder or a pattern has none.
    """
    every: dict[str, None] = {}
    if whole:
        models = whole_models(names)
        names = [name for name in names if name in models or not os.path.isfile(name)]
    for name in names:
        if name and os.path.isdir(name):  # of any text, as a user may write it
            listed = sorted(map(str, Path(name).rglob("*.xml")))
        elif WILD.search(name) and not os.path.exists(name):
            listed = sorted(glob.glob(name, recursive=True))
        else:
            every[name] = None
            continue
        models = whole_models(listed)
        if not models:
            raise UsageError(f"{name} has no MJCF file")
        every.update(dict.fromkeys(models))
    return list(every)


def whole_models(names: Sequence[str]) -> list[str]:
    """Return those files that are MJCF and that no other of them includes."""
    parts, models = set[Path](), list[str]()
    for name in names:
        try:
            source = read(Path(name))
        except OtherRootError:
            continue
        except MbcheckError:
            with suppress(UsageError):
                models += [name] if BEGIN.search(read_bytes(name)) else []
            continue
        if any(child.tag == "worldbody" for child in source.root.children):
            models.append(name)
        parts.update((Path(name).parent / one).resolve() for one in source.files[1:])
    return [name for name in models if Path(name).resolve() not in parts]


# What they come to --------------------------------------------------------------------------


@dataclass(frozen=True)
class Inspections:
    """Many files: those that were inspected, and those that could not be, with the reason.

    Attributes
    ----------
    models : tuple of mapping
        An ``inspect`` document for each; of a file that ended its process, what was found before.
    unreadable : mapping of str to str
    """

    models: tuple[Mapping[str, Any], ...]
    unreadable: Mapping[str, str] = field(default_factory=dict)

    @property
    def files(self) -> list[str]:
        """All files, as they were given."""
        return list(dict.fromkeys([*(one["file"] for one in self.models), *self.unreadable]))

    @property
    def summary(self) -> dict[str, int]:
        """Number of findings by severity, and of those that are waived."""
        names = (*SEVERITIES, "waived")
        return {name: sum(one["summary"][name] for one in self.models) for name in names}

    def items(self, fail_on: str = "error") -> list[ReportItem]:
        """Return an item for each finding, and one for each file that has none or cannot be read.

        A finding of a severity that is to fail is a failure, others are skipped.
        """
        items, seen = list[ReportItem](), Counter[tuple[str, ...]]()
        for model in self.models:
            for one in unwaived(model):
                file = path_of(model, one["file"])
                parts = [one[key] for key in ("rule", "element", "attribute") if one[key]]
                seen[model["file"], file, *parts] += 1
                again = seen[model["file"], file, *parts]
                items.append(
                    ReportItem(
                        id=" ".join(parts) + (f" ({again})" if again > 1 else ""),
                        rule=one["rule"],
                        suite=model["file"],
                        outcome="failure" if one["severity"] in FAIL_ON[fail_on] else "skipped",
                        severity=one["severity"],
                        message=one["message"],
                        details=(f"fix: {one['fix']}",),
                        file=file,
                        line=one["line"],
                    )
                )
        clean = {file: "" for file in self.files if file not in {item.suite for item in items}}
        for file, why in (clean | dict(self.unreadable)).items():
            outcome: Outcome = "error" if why else "pass"
            items.append(ReportItem("inspect", "unreadable", file, outcome, None, why, file=file))
        return items

    def exit_code(self, fail_on: str) -> int:
        """Return 2 if a file could not be read, 1 if a finding fails or parts were left out."""
        fails = any(self.summary[name] for name in FAIL_ON[fail_on])
        fails |= any(one["left_out"] for one in self.models)
        return 2 if self.unreadable else int(fails)

    def verdict(self, fail_on: str) -> str:
        """Return one line that counts findings."""
        counts, files = self.summary, self.files
        words = [plural(counts[name], name) for name in SEVERITIES]
        words += [f"{counts['waived']} waived"] if counts["waived"] else []
        words += [f"{len(self.unreadable)} cannot be read"] if self.unreadable else []
        of = f"{plural(len(files), 'file')}, " if len(files) > 1 else ""
        return f"{'FAIL' if self.exit_code(fail_on) else 'OK'}: {of}{', '.join(words)}"

    def as_json(self) -> dict[str, Any]:
        """Return the ``inspections`` document of docs/json.md."""
        return document(
            "inspections",
            self,
            summary=self.summary,
            unreadable=[{"file": file, "reason": why} for file, why in self.unreadable.items()],
        )


def omissions(left_out: Sequence[str]) -> str:
    """Return in words what was left out; empty if nothing was."""
    rules = [part.removeprefix("rule ") for part in left_out if part.startswith("rule ")]
    others = [part for part in left_out if not part.startswith("rule ")]
    others += [f"the rules {', '.join(rules)}"] if rules else []
    return f"it was stopped, and left out are {'; '.join(others)}" if others else ""


def named_once(file: str, why: str) -> str:
    """Return why a file cannot be read, with the file as the user gave it, named once."""
    name = re.escape(Path(file).name)
    words, count = re.subn(rf"(?<![\w./-]){name}(?![\w-])", lambda _: file, why, count=1)
    return words if count else f"{file}: {why}"


def path_of(model: Mapping[str, Any], file: str | None) -> str:
    """Return the path of a file that a model consists of, from where the user stands."""
    if file is None or file == model["files"][0]:
        return str(model["file"])
    return os.path.normpath(Path(model["file"]).parent / file)
