"""Failures, check by check: the quantities of a check together, and one cause once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ...checks.table import KINDS
from ...checks.verdict import Result
from ..words import number, plural
from .results import FAILURES, digits_to_differ, grouped, measured, ratio

HEADS = ("quantity", "unit", "engine", "reference", "error", "tolerance", "times")
"""Heads of the table of quantities of a failure."""


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
        """The result that stands for the check."""
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
                item.quantity,
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
