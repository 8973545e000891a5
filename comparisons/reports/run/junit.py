"""A run as JUnit XML."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Mapping

from ...checks.verdict import Result
from ..words import printable
from .located import located
from .outcome import Report, Run
from .results import FAILURES, MEASURES, grouped, measured, seconds, why_known


def junit(outcome: Report) -> str:
    """Return JUnit XML: one suite per scene, engine and kind; one test case per result.

    A deviation is a failure, an error an error; skipped and known results are skipped.
    Stale entries of the known deviations are a suite of their own: failures if they are to
    fail, skipped otherwise. The time of a check is shared equally by its results.
    """
    results, run = outcome.results, outcome.run
    siblings = Counter(result.check_id for result in results)
    times = {r.id: seconds(r) / siblings[r.check_id] for r in results}
    root = ET.Element("testsuites", name="mbcheck")
    by_engine = grouped(results, lambda r: (r.engine,))
    where = {engine: located(own) for (engine,), own in by_engine.items()}
    for key, members in grouped(results, lambda r: (r.scene, r.engine, r.kind)).items():
        suite = ET.SubElement(root, "testsuite", name=xml_text("/".join(key)))
        add_properties(suite, {**outcome.versions, **run.environment})
        for result in members:
            add_case(suite, result, times[result.id], outcome.run.repeat(result.id))
        if any(result.verdict in FAILURES for result in members) and where[key[1]]:
            text = "\n".join(["Located:", *where[key[1]]])
            ET.SubElement(suite, "system-out").text = xml_text(text)
    if run.stale:
        add_stale(root, run)
    for node in (root, *root):
        count_cases(node)
    ET.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def add_case(suite: ET.Element, result: Result, time: float, command: str) -> None:
    """Add the test case of one result, which took this time [s]."""
    place = f"{result.source}.{result.scene}.{result.case}.{result.kind}.{result.engine}"
    case = ET.SubElement(suite, "testcase", name=xml_text(result.id), classname=xml_text(place))
    case.set("time", f"{time:.6f}")
    names = ("method", "model", "quantity", "unit", *MEASURES, "verdict")
    add_properties(case, {name: getattr(result, name) for name in names})
    reason = xml_text(result.reason)
    if result.verdict in ("deviation", "error"):
        tag = "failure" if result.verdict == "deviation" else "error"
        lines = [result.id, measured(result), result.reason, command]
        lines += [result.traceback] if result.traceback else []
        failure = ET.SubElement(case, tag, message=reason, type=result.verdict)
        failure.text = xml_text("\n".join(lines))
    elif result.verdict in ("skipped", "known"):
        if result.verdict == "known":
            reason = xml_text(f"known deviation: {why_known(result)}; {result.reason}")
        ET.SubElement(case, "skipped", message=reason)


def add_properties(parent: ET.Element, texts: Mapping[str, object]) -> None:
    """Add what there is as properties."""
    properties = ET.SubElement(parent, "properties")
    for name, text in texts.items():
        if text is not None:
            ET.SubElement(properties, "property", name=xml_text(name), value=xml_text(str(text)))


def add_stale(root: ET.Element, run: Run) -> None:
    """Add a suite with a test case for each stale entry of the known deviations."""
    suite = ET.SubElement(root, "testsuite", name="known deviations")
    for use in run.stale:
        name = xml_text(f"{use.entry.place}: {use.entry.id}")
        case = ET.SubElement(suite, "testcase", name=name, classname="known", time="0")
        message = xml_text(f"stale: {use.why}; remove it from {run.known_file}")
        if run.strict_known:
            ET.SubElement(case, "failure", message=message, type="stale").text = message
        else:
            ET.SubElement(case, "skipped", message=message)


def count_cases(node: ET.Element) -> None:
    """Write how many test cases stand below a node, what became of them, and their time."""
    tags = {"tests": "testcase", "failures": "failure", "errors": "error", "skipped": "skipped"}
    for name, tag in tags.items():
        node.set(name, str(len(list(node.iter(tag)))))
    times = (float(case.get("time", 0.0)) for case in node.iter("testcase"))
    node.set("time", f"{sum(times):.6f}")


def xml_text(text: str) -> str:
    """Return text whose lines can be printed, and so stand in XML."""
    return "\n".join(map(printable, text.split("\n")))
