"""Remarks on lines of files: as lines, as annotations of GitHub, as JUnit XML, and as SARIF."""

from __future__ import annotations

import json
import os
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import Any, Literal
from urllib.parse import quote

from .run.github import annotation, limited
from .run.junit import count_cases, xml_text
from .text import markdown_table
from .words import code, plain, printable

Level = Literal["error", "warning", "note"]

LEVELS: Mapping[Level, str] = {"error": "error", "warning": "warning", "note": "notice"}
"""As GitHub names them."""

HASH = "primaryLocationLineHash"
"""Under which name GitHub looks for a fingerprint."""

MOST_ROWS = 50
"""Remarks of a summary."""

SARIF = "https://json.schemastore.org/sarif-2.1.0.json"


@dataclass(frozen=True)
class Remark:
    """What is said about a line of a file.

    Attributes
    ----------
    file : str
        As the user names it.
    line : int or None
    severity : {"error", "warning", "note"}
    rule, element : str
    attribute : str or None
        Of the element, if one is meant.
    message, fix : str
    subject : str
        The file that was given, which may include ``file``.
    """

    file: str
    line: int | None
    severity: Level
    rule: str
    element: str
    attribute: str | None
    message: str
    fix: str
    subject: str

    @property
    def place(self) -> str:
        """File and line, as compilers write them."""
        return self.file if self.line is None else f"{self.file}:{self.line}"


def named(remarks: Sequence[Remark]) -> Iterator[tuple[Remark, str]]:
    """Yield remarks, each with a name that stays as lines are added above it."""
    seen = Counter[tuple[str, ...]]()
    for one in remarks:
        parts = tuple(filter(None, (one.rule, one.element, one.attribute)))
        seen[one.subject, one.file, *parts] += 1
        number = seen[one.subject, one.file, *parts]
        yield one, " ".join(parts) + (f" ({number})" if number > 1 else "")


def step_summary(verdict: str, remarks: Sequence[Remark]) -> str:
    """Return Markdown for the page of a run on GitHub."""
    rows = [
        (one.severity, code(one.rule), code(one.place), plain(f"{one.message}; fix: {one.fix}"))
        for one in remarks
    ]
    table = markdown_table(("severity", "rule", "where", "what"), rows[:MOST_ROWS])
    more = f"\n\n{len(rows) - MOST_ROWS} more" if len(rows) > MOST_ROWS else ""
    return f"## mbcheck inspect\n\n{verdict}\n\n{table if rows else ''}{more}\n"


def remark_lines(remarks: Sequence[Remark]) -> list[str]:
    """Return a line for each: ``file:line: severity rule message; fix: ...``."""
    return [
        " ".join(f"{one.place}: {one.severity} {one.rule} {one.message}; fix: {one.fix}".split())
        for one in remarks
    ]


def github_annotations(remarks: Sequence[Remark]) -> list[str]:
    """Return workflow commands of GitHub, no more of each kind than it shows."""
    return [
        line
        for level, name in LEVELS.items()
        for line in limited(
            name,
            [
                annotation(
                    name,
                    f"{one.message}\nfix: {one.fix}",
                    file=one.file,
                    line=str(one.line or 1),
                    title=f"mbcheck: {one.rule}",
                )
                for one in remarks
                if one.severity == level
            ],
        )
    ]


def junit_of_files(
    files: Sequence[str],
    remarks: Sequence[Remark],
    fails: Sequence[Level],
    broken: Mapping[str, str],
) -> str:
    """Return JUnit XML: a suite for each file, a test case for each remark.

    Parameters
    ----------
    files : sequence of str
        All that were looked at; one without remarks is a test that passes.
    remarks : sequence of Remark
    fails : sequence of str
        Severities that are failures; others are skipped.
    broken : mapping of str to str
        Files that could not be read, and why.
    """
    root = ET.Element("testsuites", name="mbcheck inspect")
    for file in files:
        suite = ET.SubElement(root, "testsuite", name=printable(file))
        own = [one for one in remarks if one.subject == file]
        if file in broken or not own:
            case = ET.SubElement(suite, "testcase", name="inspect", classname=printable(file))
            if file in broken:
                why = printable(broken[file])
                ET.SubElement(case, "error", message=why, type="unreadable").text = why
        for one, name in named(own):
            case = ET.SubElement(suite, "testcase", name=printable(name), classname=printable(file))
            words = printable(one.message)
            if one.severity in fails:
                failure = ET.SubElement(case, "failure", message=words, type=one.rule)
                failure.text = xml_text(f"{one.place}\n{one.message}\nfix: {one.fix}")
            else:
                words = f"{one.severity}: {one.place}: {one.message}"
                ET.SubElement(case, "skipped", message=printable(words))
    for node in (root, *root):
        count_cases(node)
    ET.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def sarif(remarks: Sequence[Remark], rules: Mapping[str, tuple[str, str]], version: str) -> str:
    """Return SARIF 2.1.0, which code scanning of GitHub and editors read.

    Parameters
    ----------
    remarks : sequence of Remark
    rules : mapping of str to (str, str)
        What each rule finds, and why that matters.
    version : str
        Of mbcheck.
    """
    names = list(dict.fromkeys(one.rule for one in remarks))
    driver = {
        "name": "mbcheck",
        "version": version,
        "rules": [
            {
                "id": name,
                "shortDescription": {"text": rules[name][0]},
                "fullDescription": {"text": rules[name][1]},
            }
            for name in names
        ],
    }
    results = [
        {
            "ruleId": one.rule,
            "ruleIndex": names.index(one.rule),
            "level": one.severity,
            "message": {"text": f"{one.message}; fix: {one.fix}"},
            "locations": [{"physicalLocation": location(one)}],
            "partialFingerprints": {HASH: fingerprint(f"{uri_of(one.file)} {name}")},
        }
        for one, name in named(remarks)
    ]
    run = {"tool": {"driver": driver}, "results": results}
    return json.dumps({"$schema": SARIF, "version": "2.1.0", "runs": [run]}, indent=2) + "\n"


def fingerprint(text: str) -> str:
    """Return by what code scanning knows a remark again, as lines move."""
    return f"{sha256(text.encode()).hexdigest()[:16]}:1"


def uri_of(file: str) -> str:
    """Return the name of a file as a URI, whatever its bytes are."""
    return quote(os.fsencode(file.replace(os.sep, "/")))


def location(one: Remark) -> dict[str, Any]:
    """Return where a remark points, as SARIF has it."""
    where = {"artifactLocation": {"uri": uri_of(one.file)}}
    return where | ({"region": {"startLine": one.line}} if one.line else {})
