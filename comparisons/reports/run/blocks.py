"""What failed, check by check: its quantities together, and one cause of several checks once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...checks.verdict import Result
from ..words import number, plural
from .located import LEVELS
from .results import FAILURES, digits_to_differ, grouped, measured, ratio

HEADS = ("", "unit", "engine", "reference", "error", "tolerance", "times")
"""Of a table of quantities."""

MOST = 10
"""Blocks that are shown unless all are asked for."""


@dataclass(frozen=True)
class Block:
    """A check that fails, and others that do so by the same cause.

    Attributes
    ----------
    failed : tuple of Result
        Of one check: errors first, then from the farthest beyond its tolerance down.
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
        """What stands for the check."""
        return self.failed[0]

    @property
    def title(self) -> str:
        """The check, and how many of its results fail."""
        few = "" if self.count == 1 else f"  {len(self.failed)} of {self.count} quantities"
        return f"{self.worst.verdict.upper()} {self.worst.check_id}{few}"

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """What was measured of each, as `HEADS` says."""
        return [
            (
                f"    {item.quantity}",
                item.unit,
                *(number(x, digits_to_differ(item)) for x in (item.value, item.reference)),
                *(number(x) for x in (item.error, item.tolerance)),
                number(ratio(item)),
            )
            for item in self.failed
            if item.error is not None
        ]

    @property
    def quantities(self) -> list[str]:
        """What was measured of each, in a line."""
        return [f"{measured(item)}{beyond(item)}" for item in self.failed if measured(item)]

    @property
    def why(self) -> str:
        """The reason of the worst, without the size of its error, which stands beside it."""
        head, times, tail = self.worst.reason.partition(" x its tolerance")
        return tail.removeprefix("; ") if times and head.startswith("error is") else head

    @property
    def others(self) -> str:
        """How many checks fail alike; empty of none."""
        if not self.alike:
            return ""
        names = ", ".join([*self.alike[:2], *(["..."] if self.alike[2:] else [])])
        return f"the same in {plural(len(self.alike), 'more check')}: {names}"


def beyond(result: Result) -> str:
    """Return how many times its tolerance an error is, in words."""
    return "" if result.error is None else f" ({number(ratio(result))} x its tolerance)"


def blocks(results: Sequence[Result]) -> list[Block]:
    """Return what failed: the first level that is wrong first, then errors, then the worst."""
    checks = grouped(results, lambda r: (r.check_id,)).values()
    alone = []
    for members in checks:
        failed = [item for item in members if item.verdict in FAILURES]
        if failed:
            # what has a unit is seen at a time, and says more than what is derived of all times
            failed.sort(key=lambda r: (r.verdict != "error", r.unit == "1", -ratio(r), r.id))
            count = sum(item.verdict != "skipped" for item in members)
            alone.append(Block(tuple(failed), count))
    alone.sort(key=lambda block: severity(block.worst))
    return [
        Block(first.failed, first.count, tuple(block.worst.check_id for block in more))
        for first, *more in alike(alone)
    ]


def severity(result: Result) -> tuple[int, bool, float, str]:
    """Return what blocks are ordered by."""
    levels = list(LEVELS)
    level = levels.index(result.kind) if result.kind in levels else len(levels)
    return level, result.verdict != "error", -ratio(result), result.check_id


def alike(all_of_them: Sequence[Block]) -> list[list[Block]]:
    """Return blocks, those together that an engine fails by the same cause."""
    groups: dict[tuple[str, ...], list[Block]] = {}
    for block in all_of_them:
        worst = block.worst
        cause = worst.reason if worst.verdict == "error" else worst.cause
        key = (worst.engine, worst.verdict, cause) if cause else (worst.check_id,)
        groups.setdefault(key, []).append(block)
    return list(groups.values())
