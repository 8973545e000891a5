"""Findings: what the rules say of a model, and what its file waives."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from .mujoco.source import Element, Waiver
from .rules.table import NEED_MODES, REPEATED_DEFAULT, RULES
from .rules.text import BUDGET, repeated_default
from .subject import SEVERITIES, Hit, Severity, Subject


@dataclass(frozen=True)
class Finding:
    """What a rule says of a model.

    Attributes
    ----------
    rule : str
        Its id.
    severity : {"error", "warning", "note"}
    element : str
        Where: ``tag:name``, ``tag:name/tag`` or ``tag``.
    file : str or None
    line : int or None
        Where that stands, if it stands in the text.
    message : str
        What is found, with its numbers.
    fix : str
        What to do.
    waived : str or None
        The reason that the file gives for it, if it does.
    """

    rule: str
    severity: Severity
    element: str
    file: str | None
    line: int | None
    message: str
    fix: str
    waived: str | None = None


def findings(s: Subject, budget: float = BUDGET) -> tuple[tuple[Finding, ...], str | None]:
    """Return all findings, errors first, and why some attributes were not tried, if any.

    Those that the file waives say so, and come last. A waiver of what was not looked for may be
    of use another time. ``budget`` is what `repeated_default` may spend.
    """
    with np.errstate(all="ignore"):
        hits = [(name, hit) for name, rule in RULES.items() if rule.find for hit in rule.find(s)]
        stated = {(hit.element, hit.attribute) for _, hit in hits if hit.element and hit.attribute}
        repeated, untried = repeated_default(s, stated, budget)
    hits += [(REPEATED_DEFAULT, hit) for hit in repeated]
    waivers, used = s.loaded.source.waivers, set[int]()
    results = [waived(finding(rule, hit), waivers, used) for rule, hit in hits]
    skipped = {REPEATED_DEFAULT} if untried else set()
    if not any(view.linear for view in s.views):
        skipped |= NEED_MODES
    used |= {i for i, waiver in enumerate(waivers) if waiver.rule in skipped and waiver.reason}
    results += [finding(rule, hit) for rule, hit in complaints(waivers, used)]
    results.sort(key=lambda one: (one.waived is not None, SEVERITIES.index(one.severity)))
    return tuple(results), untried


def finding(rule: str, hit: Hit) -> Finding:
    """Return what a rule found, with what the rule itself says."""
    return Finding(
        rule=rule,
        severity=RULES[rule].severity,
        element=hit.name,
        file=hit.element.file if hit.element else None,
        line=hit.element.line if hit.element else None,
        message=hit.message,
        fix=hit.fix or RULES[rule].fix,
    )


def waived(one: Finding, waivers: tuple[Waiver, ...], used: set[int]) -> Finding:
    """Return a finding with the reason for which the file waives it; ``used`` is added to."""
    for number, waiver in enumerate(waivers):
        if waiver.covers(one.rule, one.element):
            used.add(number)
            return replace(one, waived=waiver.reason)
    return one


def complaints(waivers: tuple[Waiver, ...], used: set[int]) -> Iterator[tuple[str, Hit]]:
    """Yield what is wrong with the waivers themselves."""
    for number, waiver in enumerate(waivers):
        place = Element("comment", {}, waiver.file, waiver.line)
        words = " ".join(waiver.text.split())
        quoted = repr(words if len(words) < 60 else f"{words[:57]}...")
        if not waiver.rule:
            yield "waiver_reason", Hit(place, "comment", f"{quoted} is not a waiver")
        elif waiver.rule not in RULES:
            yield "waiver_unknown", Hit(place, "comment", f"there is no rule {waiver.rule!r}")
        elif not waiver.reason:
            yield "waiver_reason", Hit(place, "comment", f"{quoted} gives no reason")
        elif number not in used:
            about = "" if waiver.pattern is None else f" for {waiver.pattern}"
            message = f"nothing is found by {waiver.rule}{about}"
            yield "waiver_unused", Hit(place, "comment", message)
