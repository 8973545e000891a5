"""Print how far the reference is off in some draws: ``SCENE FIRST COUNT``."""

from __future__ import annotations

import sys

from mbcheck.tests.support.precise.compare import compare
from mbcheck.tests.support.precise.figures import figures
from mbcheck.tests.support.precise.runs import run_of

if __name__ == "__main__":
    scene, first, count = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    outcomes = []
    for number in range(first, first + count):
        outcome = compare(run_of(scene, number))
        outcomes.append(outcome)
        lost = "" if outcome.lost_from is None else f" lost from {outcome.lost_from:.4g} s"
        print(
            f"{number:>6} {outcome.kind:<16} error/bound {outcome.excess:<10.3g}"
            f"in time {outcome.excess_in_time:<10.3g}"
            f"growth {outcome.growth:<10.3g}reference {outcome.seconds[0]:<8.2f}"
            f"truth {outcome.seconds[1]:.2f} s{lost} {outcome.refusal}",
            flush=True,
        )
    print(figures(outcomes))
