"""JUnit XML, for the test pages of CI services."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence

from .item import ReportItem
from .words import printable

TAGS = {"tests": "testcase", "failures": "failure", "errors": "error", "skipped": "skipped"}
"""Attributes of a suite that count elements below it."""


def junit(
    items: Sequence[ReportItem],
    properties: Mapping[str, object] | None = None,
    output: Mapping[str, Sequence[str]] | None = None,
) -> str:
    """Return JUnit XML: a suite for each suite of items, a test case for each item.

    Parameters
    ----------
    items : sequence of ReportItem
    properties : mapping, optional
        Versions and machine, written into each suite.
    output : mapping of str to sequence of str, optional
        Lines that stand below a suite, by its name.
    """
    root = ET.Element("testsuites", name="mbcheck")
    for name in dict.fromkeys(item.suite for item in items):
        suite = ET.SubElement(root, "testsuite", name=printable(name))
        add_properties(suite, properties or {})
        for item in items:
            if item.suite == name:
                add_case(suite, item)
        if lines := (output or {}).get(name):
            ET.SubElement(suite, "system-out").text = xml_text("\n".join(lines))
    for node in (root, *root):
        for attribute, tag in TAGS.items():
            node.set(attribute, str(len(list(node.iter(tag)))))
        times = (float(case.get("time", 0.0)) for case in node.iter("testcase"))
        node.set("time", f"{sum(times):.6f}")
    ET.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def add_case(suite: ET.Element, item: ReportItem) -> None:
    """Add the test case of an item."""
    named = {"name": printable(item.id), "classname": printable(item.suite)}
    case = ET.SubElement(suite, "testcase", named, time=f"{item.seconds:.6f}")
    add_properties(case, item.numbers)
    message = printable(item.message)
    if item.outcome == "skipped":
        where = printable(f"{item.severity}: {item.place}: ") if item.line else ""
        ET.SubElement(case, "skipped", message=where + message)
    elif item.outcome != "pass":
        failure = ET.SubElement(case, item.outcome, message=message, type=item.rule)
        failure.text = xml_text("\n".join((item.place, item.message, *item.details)))


def add_properties(parent: ET.Element, values: Mapping[str, object]) -> None:
    """Add the values that there are as properties."""
    texts = {name: str(value) for name, value in values.items() if value is not None}
    properties = ET.SubElement(parent, "properties") if texts else parent
    for name, text in texts.items():
        ET.SubElement(properties, "property", name=printable(name), value=printable(text))


def xml_text(text: str) -> str:
    """Return text whose lines can be printed, for the content of an element."""
    return "\n".join(map(printable, text.split("\n")))
