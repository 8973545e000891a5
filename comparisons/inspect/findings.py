"""Findings: what the rules say of a model, and what its file waives."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from .mujoco.source import Element, Waiver
from .rules.table import NEED_MODES, QUICK, REPEATED_DEFAULT, RULES
from .rules.text import BUDGET, repeated_default
from .subject import SEVERITIES, Hit, InspectedModel, Severity

BEFORE = "in the baseline"
"""Why a finding is waived that was there before."""

WORSE = 1.1
"""Times as bad as in the baseline from which on a finding counts again."""


@dataclass(frozen=True)
class ModelFinding:
    """What a rule says of a model.

    Attributes
    ----------
    rule : str
        its id; `mbcheck inspect --explain` tells about it
    severity : {"error", "warning", "note"}
        how bad it is
    element : str
        where: tag:name, tag:name/tag or tag
    file : str or None
        file; null if it does not stand in the text
    line : int or None
        line; null likewise
    message : str
        what was found, with its numbers
    fix : str
        what to do
    waived : str or None
        the reason that the file gives for it; null if it does not waive it
    attribute : str or None
        the attribute that is meant; null if it is not one
    measure : float or None
        how bad it is, the larger the worse; null where no number tells
    """

    rule: str
    severity: Severity
    element: str
    file: str | None
    line: int | None
    message: str
    fix: str
    waived: str | None = None
    attribute: str | None = None
    measure: float | None = None


@dataclass(frozen=True)
class Selection:
    """Which rules are asked, and what is waived beside the comments of a file.

    Attributes
    ----------
    rules : frozenset of str
    waivers : tuple of Waiver
        Those of a file beside it, for models of others.
    about_this_alone : frozenset of int
        Which of them are about no other model: they are to waive something.
    baseline : mapping of (str, str) to float or None
        Rule and element of findings that were there before, and how bad they were.
    """

    rules: frozenset[str]
    waivers: tuple[Waiver, ...] = ()
    baseline: Mapping[tuple[str, str], float | None] = field(default_factory=dict)
    about_this_alone: frozenset[int] = frozenset()

    def worse(self, rule: str, hit: Hit) -> str:
        """Return how much worse a finding is than in the baseline, in words; empty if it is not."""
        old = self.baseline.get((rule, hit.name))
        if old is None or hit.measure is None or not hit.measure > WORSE * abs(old):
            return ""
        return f"; in the baseline it was {old:.3g} where now it is {hit.measure:.3g}"

    @classmethod
    def of_profile(cls, strict: bool) -> Selection:
        """Return the rules that are asked by default, or all."""
        return cls(frozenset(name for name, rule in RULES.items() if strict or not rule.house))


Hits = list[tuple[str, Hit]]
"""What rules find, with their names."""


def hits_of(s: InspectedModel, selection: Selection, quick: Hits | None = None) -> Hits:
    """Return the findings of rules for which there is time: of `QUICK`, or all after these."""
    first = quick is None
    hits = list(quick or ())
    names = [name for name in RULES if name in selection.rules and (name in QUICK) == first]
    for place, name in enumerate(names, start=1):
        find = RULES[name].find
        if find and s.pace.begins(f"rule {name}"):
            with np.errstate(all="ignore"):
                hits += [(name, hit) for hit in find(s)]
        asked = {*names[:place], *(() if first else QUICK)}
        s.pace.keep(partial(so_far, s, selection, hits, asked), first and place == len(names))
    return hits


def so_far(
    s: InspectedModel, selection: Selection, hits: Hits, asked: Collection[str]
) -> tuple[InspectedModel, tuple[ModelFinding, ...]]:
    """Return a model and its findings as they are if the other rules are never asked."""
    rest = [f"rule {name}" for name in RULES if name in selection.rules and name not in asked]
    s = replace(s, pace=replace(s.pace, left_out=[*s.pace.left_out, *rest]))
    return s, findings_of(s, selection, hits)


def findings(
    s: InspectedModel, selection: Selection, budget: float = BUDGET, quick: Hits | None = None
) -> tuple[tuple[ModelFinding, ...], str | None]:
    """Return all findings, errors first, and why some attributes were not tried, if any.

    ``budget`` is what `repeated_default` may spend, ``quick`` what the rules of `QUICK` found, if
    they were asked before.
    """
    hits = hits_of(s, selection, hits_of(s, selection) if quick is None else quick)
    hits.sort(key=lambda hit: list(RULES).index(hit[0]))
    with np.errstate(all="ignore"):
        stated = {(hit.element, hit.attribute) for _, hit in hits if hit.element and hit.attribute}
        repeated, untried = (
            repeated_default(s, stated, budget)
            if REPEATED_DEFAULT in selection.rules and s.pace.begins(f"rule {REPEATED_DEFAULT}")
            else ([], None)
        )
    hits += [(REPEATED_DEFAULT, hit) for hit in repeated]
    return findings_of(s, selection, hits, {REPEATED_DEFAULT} if untried else set()), untried


def findings_of(
    s: InspectedModel, selection: Selection, hits: Hits, untried: Collection[str] = ()
) -> tuple[ModelFinding, ...]:
    """Return the hits of rules as findings, errors first.

    Those that are waived say so, and come last. A waiver of what was not looked for, or of a rule
    that was not tried on all, may be of use another time.
    """
    waivers = (*s.loaded.source.waivers, *selection.waivers)
    allowed = [
        next((i for i, waiver in enumerate(waivers) if waiver.covers(rule, hit.name)), None)
        for rule, hit in hits
    ]
    results = []
    for (rule, hit), number in zip(hits, allowed, strict=True):
        if number is not None:
            results.append(finding(rule, hit, waivers[number].reason))
        elif worse := selection.worse(rule, hit):
            results.append(finding(rule, hit._replace(message=hit.message + worse)))
        else:
            before = (rule, hit.name) in selection.baseline
            results.append(finding(rule, hit, BEFORE if before else None))
    skipped = {name for name in RULES if f"rule {name}" in s.pace.left_out}
    skipped |= set(RULES) - selection.rules | set(untried)
    if not any(view.linear for view in s.views):
        skipped |= NEED_MODES
    own = len(s.loaded.source.waivers)
    idle = [
        waiver
        for i, waiver in enumerate(waivers)
        if i not in allowed and not (waiver.rule in skipped and waiver.reason)
        if i < own or i - own in selection.about_this_alone  # others may be about other files
    ]
    complained = [finding(*one) for one in complaints(idle)]
    results += [one for one in complained if one.rule in selection.rules]
    return tuple(
        sorted(results, key=lambda one: (one.waived is not None, SEVERITIES.index(one.severity)))
    )


def finding(rule: str, hit: Hit, waived: str | None = None) -> ModelFinding:
    """Return what a rule found, with what the rule itself says, and why the file waives it."""
    return ModelFinding(
        rule=rule,
        severity=RULES[rule].severity,
        element=hit.name,
        file=hit.element.file if hit.element else None,
        line=hit.element.line if hit.element else None,
        message=hit.message,
        fix=hit.fix or RULES[rule].fix,
        waived=waived,
        attribute=hit.attribute,
        measure=hit.measure,
    )


def complaints(waivers: Sequence[Waiver]) -> Iterator[tuple[str, Hit]]:
    """Yield what is wrong with waivers that waive nothing."""
    for waiver in waivers:
        words = " ".join(waiver.text.split())
        quoted = repr(words if len(words) < 60 else f"{words[:57]}...")
        about = "" if waiver.pattern is None else f" for {waiver.pattern}"
        if not waiver.rule:
            rule, message = "waiver_reason", f"{quoted} is not a waiver"
        elif waiver.rule not in RULES:
            rule, message = "waiver_unknown", f"there is no rule {waiver.rule!r}"
        elif not waiver.reason:
            rule, message = "waiver_reason", f"{quoted} gives no reason"
        else:
            rule, message = "waiver_unused", f"nothing is found by {waiver.rule}{about}"
        yield rule, Hit(Element("comment", {}, waiver.file, waiver.line), "comment", message)
