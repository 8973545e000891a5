"""An engine's model with a method, and what a check says of an engine that stands in for it."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from mbcheck.comparisons.checks.suite import Check, checks_of, run_check
from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.checks.verdict import Result
from mbcheck.comparisons.engines.adapter import Adapter
from mbcheck.reference import get_scene
from mbcheck.reference.scene import Case

REFUSALS = ("not_at_rest:", "singular:", "step: with steps above")
"""Errors that say what is wrong with an engine, as good as a deviation."""


class Subject(NamedTuple):
    """An engine's model with a method."""

    scene: str
    engine: str
    model: str
    method: str


def check_of(subject: Subject, kind: str, case: str | Case) -> Check:
    """Return the check of a subject for a kind and a case, or the one of this name."""
    if isinstance(case, str):
        case = get_scene(subject.scene).case(case)
    (check,) = (
        check
        for check in checks_of(kind, case, subject.engine)
        if check.model == subject.model
        and (check.method is None or check.method.name == subject.method)
    )
    return check


def results_of(
    subject: Subject,
    kind: str,
    engine: Adapter,
    case: str | Case,
    profile: str = "loose",
    explain: bool = False,
) -> list[Result]:
    """Return the results of a check for an engine that stands in for the subject's."""
    check = check_of(subject, kind, case)
    quantities = KINDS[kind].quantities(check.setup(engine))
    return run_check(replace(check, quantities=quantities), profile, engine, explain)


def is_seen(results: list[Result]) -> bool:
    """Return whether the results tell a wrong engine, and no accident of the check."""
    return any(
        item.verdict == "deviation"
        or (item.verdict == "error" and item.reason.startswith(REFUSALS))
        for item in results
    )


def label(item: Subject | str) -> str:
    """Return what pytest calls a subject or a fault."""
    return item if isinstance(item, str) else "/".join(item)
