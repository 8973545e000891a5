"""Failures: the first level on which an engine is wrong, and failing checks by their causes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from ...checks.diagnosis import ANOTHER_MODEL
from ...checks.kinds.parts import WHOLE
from ...checks.table import KINDS
from ...checks.verdict import FAILURES, Result
from ...engines.protocol import NO_ACCELERATIONS
from ..words import number, plural, with_unit
from .results import digits_to_differ, error_size, grouped, measured, ratio

FAILED = {
    "clock": "its clock does not show the requested times",
    "step_count": "it takes or counts other steps than requested",
    "work_count": "it takes or counts other steps than requested",
    "non_finite": "its results are not finite",
    "returned": "its results are refused",
    "timeout": "it takes longer than the time limit",
    "crashed": "its process ended",
}
"""Heading of a level on which all failures are errors of such a kind."""

COUNTED = ("work_count: ", "step_count: ")
"""Beginnings of reasons that name the cause of deviations on other levels, and come first."""

MASS_SHARES = ("mass.", "inertia.", "products.", "armature.")
"""Beginnings of the names of shares of a mass matrix."""

MOST = 8
"""Lines for one engine."""


def located(results: Sequence[Result]) -> list[str]:
    """Return for each engine that deviates the first level, and its faults there."""
    wrong = [item for item in results if item.verdict in FAILURES]
    lines = []
    for engine in dict.fromkeys(item.engine for item in wrong):
        mine = [item for item in wrong if item.engine == engine]
        level = next((name for name in KINDS if any(r.kind == name for r in mine)), None)
        own = [item for item in results if item.engine == engine]
        ran = {item.kind for item in own if item.verdict == "pass"}
        ran -= {item.kind for item in own if item.verdict == "known"}
        if level is None:
            continue
        here = [item for item in mine if item.kind == level]
        here.sort(key=lambda item: item.verdict == "error")
        before = [name for name in list(KINDS)[: list(KINDS).index(level)] if name in ran]
        right = f", {' and '.join(before)} right" if before else ""
        lines.append(f"{engine}: {head(level, here)}{right}")
        counted = [r for r in mine if r.kind != level and r.reason.startswith(COUNTED)][:1]
        wrong_things = [*faults([*counted, *here], mine)]
        lines += [f"  {line}" for line in wrong_things[:MOST]]
        if len(wrong_things) > MOST:
            lines.append(f"  and {len(wrong_things) - MOST} more")
        deviates = any(item.verdict == "deviation" for item in mine)
        causes = any(item.cause not in (None, ANOTHER_MODEL) for item in mine)
        skipped = (item.reason for item in own if item.verdict == "skipped")
        if deviates and not causes and any(NO_ACCELERATIONS in reason for reason in skipped):
            lines.append("  its accelerations would show which part of the model: docs/engines.md")
    return lines


def head(level: str, here: Sequence[Result]) -> str:
    """Return the heading of a level, by the results that fail there."""
    causes = [item.cause for item in here if item.verdict == "deviation"]
    same = all(cause == ANOTHER_MODEL for cause in causes)
    said = [ANOTHER_MODEL if same else f"{KINDS[level].level} is wrong"] if causes else []
    other = {True: "it raised an exception", False: f"{KINDS[level].level} could not be judged"}
    said += [
        FAILED.get(item.reason.partition(":")[0]) or other[bool(item.traceback)]
        for item in here
        if item.verdict == "error"
    ]
    return " and ".join(dict.fromkeys(said))


def faults(results: Sequence[Result], every: Sequence[Result]) -> Iterator[str]:
    """Yield the faults, each once, with their scenes.

    A cause has the number of its checks on all levels, if more than one. The error of a mass matrix
    is left out if the masses and inertias that explain it are named.
    """
    explained = {item.check_id for item in results if item.quantity.startswith(MASS_SHARES)}
    own = [
        r
        for r in results
        if r.quantity != "mass_matrix" or r.check_id not in explained or fault(r) != off(r)
    ]
    for (text,), same in grouped(own, lambda r: (fault(r),)).items():
        worst = max(same, key=error_size)
        size = with_unit(worst.error, worst.unit, 2)
        words = text if text != off(worst) else f"{text} by {'up to ' if same[1:] else ''}{size}"
        where = ", ".join(dict.fromkeys(item.scene for item in same))
        alike = {item.check_id for item in every if item.cause and item.cause == text}
        yield f"{words} ({where}{f'; {len(alike)} checks' if len(alike) > 1 else ''})"


def fault(result: Result) -> str:
    """Return the fault of a result: its cause, the fate of a part, or the name of the quantity."""
    if result.verdict == "error":
        return result.reason
    if result.cause and result.cause != ANOTHER_MODEL:
        return result.cause
    said = result.reason.partition("; ")[2]
    if result.kind == "parts" and said != WHOLE.get(result.quantity):
        return said
    return off(result)


def off(result: Result) -> str:
    """Return the name of a quantity with the word that it is wrong."""
    return f"{result.method} {result.quantity} off" if result.method else f"{result.quantity} off"


# Blocks

HEADS = ("quantity", "unit", "engine", "reference", "error", "tolerance", "times")
"""Heads of the table of quantities of a failure."""

ROW_NAMES = {"unexplained": "unexplained by shares"}
"""Names of quantities in that table: forces beyond the parts of a file may have a cause."""


@dataclass(frozen=True)
class Block:
    """A check that fails, and others that fail by the same cause.

    Attributes
    ----------
    failed : tuple of Result
        The results of one check: errors first, then from the farthest beyond its tolerance down.
    count : int
        How many results of that check were judged.
    alike : tuple of str
        Ids of checks that fail by the same cause.
    """

    failed: tuple[Result, ...]
    count: int
    alike: tuple[str, ...] = ()

    @property
    def worst(self) -> Result:
        """The result that represents the check."""
        return self.failed[0]

    @property
    def title(self) -> str:
        """The check, and how many of its results fail."""
        few = "" if self.count == 1 else f"  {len(self.failed)} of {self.count} quantities"
        return f"{self.worst.verdict.upper()} {self.worst.check_id}{few}"

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """The numbers of each quantity, below `HEADS`."""
        return [
            (
                ROW_NAMES.get(item.quantity, item.quantity),
                item.unit,
                *(number(x, digits_to_differ(item)) for x in (item.value, item.reference)),
                *(number(x) for x in (item.error, item.tolerance, ratio(item))),
            )
            for item in self.failed
            if item.error is not None
        ]

    @property
    def quantities(self) -> list[str]:
        """The numbers of each quantity, in a line."""
        return [measured(item) for item in self.failed if measured(item)]

    @property
    def reasons(self) -> list[str]:
        """The reason of the worst, without the size of its error, and how many fail alike."""
        head, times, tail = self.worst.reason.partition(" x its tolerance")
        why = tail.removeprefix("; ") if times and head.startswith("error is") else head
        names = ", ".join([*self.alike[:2], *(["..."] if self.alike[2:] else [])])
        others = f"the same in {plural(len(self.alike), 'more check')}: {names}"
        return [why] * bool(why) + [others] * bool(names)


def blocks(results: Sequence[Result]) -> list[Block]:
    """Return the failures: the first wrong level first, then errors, then the worst.

    Checks that an engine fails by the same cause are one block.
    """
    checks = []
    for members in grouped(results, lambda r: (r.check_id,)).values():
        failed = [item for item in members if item.verdict in FAILURES]
        # a quantity with a unit is measured at one time, and says more than one of all times
        failed.sort(key=lambda r: (r.verdict != "error", r.unit == "1", -ratio(r), r.id))
        count = sum(item.verdict != "skipped" for item in members)
        checks += [Block(tuple(failed), count)] if failed else []
    groups: dict[tuple[str, ...], Block] = {}
    for block in sorted(checks, key=severity):
        worst = block.worst
        cause = worst.reason if worst.verdict == "error" else worst.cause
        key = (worst.engine, worst.verdict, cause) if cause else (worst.check_id,)
        first = groups.setdefault(key, block)
        if first is not block:
            groups[key] = replace(first, alike=(*first.alike, worst.check_id))
    return list(groups.values())


def severity(block: Block) -> tuple[int, bool, float, str]:
    """Return the place of a block in the order of `blocks`."""
    worst, levels = block.worst, [*KINDS]
    level = levels.index(worst.kind) if worst.kind in levels else len(levels)
    return level, worst.verdict != "error", -ratio(worst), worst.check_id
