"""Failures of engines, and who notices: for the console, and as the page docs/extremes.md."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby

from rich.console import Console

from ..checks.table import EXTREMES
from ..checks.verdict import ENGINE, REFERENCE, Result
from ..faults.variants import NOT_PROVOKED
from ..reports.text import markdown_table, print_line, print_table

RIGHT, WRONG, FAILED, REFUSED, SKIPPED = "right", "wrong", "failed", "refused", "skipped"
OUTCOMES: Mapping[str, str] = {
    RIGHT: "within the predicted error",
    WRONG: "finite, and wrong",
    FAILED: "no result, and the reason is named",
    REFUSED: "the engine or its adapter refuses the model, the method or the step",
    SKIPPED: "cannot be judged, with the reason",
}

ABOUT: Mapping[str, str] = {
    "limits": "The largest stable step of each method, by bisection, beside its theory",
    "parameters": "Parameters at extremes, with a step that suits them, and with the usual one",
    "starts": "Starts that ask for trouble",
    "long": "Motions over hundreds of periods: energy, phase, closure and clock",
    "failures": "Failures, provoked for real",
}

INTRODUCTION = """# Extremes

Written by `mbcheck extremes{full} --markdown`. Each case is a check of the table of checks: run it
alone with `mbcheck check --id ID`, or all of them with `mbcheck check --extremes`.
"""

WHO = """Who notices: `engine`, the engine itself or its adapter; `guard`, what mbcheck asks of
every run; `rule:...`, a rule known before the run; `halving`, a run with half the step;
`reference`, a comparison with the reference.
"""

HEADS = ("scene", "what", "provoked by", "model, method", "outcome", "who notices")


def outcome(result: Result) -> str:
    """Return the outcome of a result, one of `OUTCOMES`."""
    if result.verdict == "skipped":
        return REFUSED if ENGINE in result.noticed_by else SKIPPED
    return {"pass": RIGHT, "error": FAILED}.get(result.verdict, WRONG)


def died(result: Result) -> bool:
    """Return True if the process of a check ended, or was stopped."""
    ends = tuple(f"{kind}: " for kind in ("crashed", "timeout", "memory"))
    return result.verdict == "error" and result.reason.startswith(ends)


def is_hidden(result: Result) -> bool:
    """Return True if a result is wrong, and only the reference notices."""
    return outcome(result) == WRONG and result.noticed_by == (REFERENCE,)


def counts(results: Iterable[Result]) -> list[tuple[object, ...]]:
    """Return the number of results of each kind by outcome."""
    numbers = Counter((one.kind, outcome(one)) for one in results)
    kinds = [kind for kind in EXTREMES if any(key[0] == kind for key in numbers)]
    return [(kind, *(numbers[kind, name] for name in OUTCOMES)) for kind in kinds]


def markdown(results: Sequence[Result], full: bool) -> str:
    """Return the page: what breaks in each engine, at which value, and who notices."""
    lines = [INTRODUCTION.format(full=" --full" if full else "")]
    lines += [f"* **{name}**: {words}" for name, words in OUTCOMES.items()]
    lines += ["", WHO, markdown_table(("results of", *OUTCOMES), counts(results)), ""]
    lines += [f"* *{kind}*: {words}." for kind, words in ABOUT.items()]
    hidden = [one for one in results if is_hidden(one)]
    lines += ["", "## Only the reference notices", ""]
    lines += [f"* `{one.id}`: {one_line(one.reason)}" for one in hidden] or ["Nothing."]
    for engine in dict.fromkeys(one.engine for one in results):
        broken = [
            one for one in results if one.engine == engine and outcome(one) in (WRONG, FAILED)
        ]
        lines += ["", f"## {engine}: what breaks", "", table(broken)]
    lines += ["", "## Known of these engines, and not provoked", ""]
    lines += [f"* {mode}: {why}" for mode, why in NOT_PROVOKED]
    return "\n".join(lines) + "\n"


def table(results: Sequence[Result]) -> str:
    """Return results as a Markdown table; what methods have in common is one line."""

    def key(one: Result) -> tuple[str, ...]:
        first = one.reason.partition(": ")[0]
        provoked = first if re.match(r"[\w. ]+=", first) else ""
        noticed = ", ".join(one.noticed_by)
        return one.scene, f"{one.kind}: {one.case}", provoked, outcome(one), noticed

    lines = []
    for (scene, what, provoked, name, noticed), same in groupby(sorted(results, key=key), key):
        who = dict.fromkeys(f"{one.model} {one.method}" for one in same)
        lines.append((scene, what, provoked, ", ".join(who), name, noticed))
    return markdown_table(HEADS, lines)


def one_line(reason: str) -> str:
    """Return a reason on one line, without the places of files."""
    return " ".join(re.sub(r" \[Python file .*?\]", "", reason).split())


def show(console: Console, results: Sequence[Result], every: bool) -> None:
    """Print how many results came out how, and what only the reference notices, or all."""
    print_table(console, ("kind", *OUTCOMES), counts(results))
    hidden = [one for one in results if is_hidden(one)]
    for one in [one for one in results if outcome(one) != RIGHT] if every else hidden:
        noticed = ", ".join(one.noticed_by) or "-"
        print_line(console, f"{outcome(one)} {one.id}; noticed by {noticed}: {one.reason}")
    print_line(console, f"{len(results)} results; {len(hidden)} that only the reference notices")
