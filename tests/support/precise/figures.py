"""What many draws come to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbcheck.tests.support.precise.compare import Outcome


def figures(outcomes: Sequence[Outcome]) -> str:
    """Return a table of the kinds of runs, and the figures of all."""
    kinds = dict.fromkeys(outcome.kind for outcome in outcomes)
    rows = [row(kind, [one for one in outcomes if one.kind == kind]) for kind in kinds]
    head = f"{'kind':<16}{'runs':>6}{'regular':>9}{'lost':>6}{'refused':>9}{'above 1':>9}"
    head += f"{'max error/bound':>17}{'in time':>9}{'median bound/error':>20}"
    head += f"{'s reference':>13}{'s truth':>9}"
    return "\n".join([head, *rows, row("all", outcomes)])


def row(name: str, outcomes: Sequence[Outcome]) -> str:
    """Return the figures of some runs."""
    counts = (
        sum(one.regular for one in outcomes),
        sum(one.lost_from is not None for one in outcomes),
        sum(bool(one.refusal) for one in outcomes),
        sum(one.excess > 1 for one in outcomes),
    )
    spent = np.sum([one.seconds for one in outcomes], axis=0)
    return (
        f"{name:<16}{len(outcomes):>6}{counts[0]:>9}{counts[1]:>6}{counts[2]:>9}{counts[3]:>9}"
        f"{max(one.excess for one in outcomes):>17.3g}"
        f"{max(one.excess_in_time for one in outcomes):>9.3g}{median_margin(outcomes):>20.3g}"
        f"{spent[0]:>13.1f}{spent[1]:>9.1f}"
    )


def median_margin(outcomes: Sequence[Outcome]) -> float:
    """Return the median of bound over error, over all states of regular motions."""
    margins = [margin for one in outcomes if one.regular for margin in one.margins]
    return float(np.median(margins)) if margins else float("nan")
