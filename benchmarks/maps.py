"""What maps cost: how time grows with the points, with workers, and with refinement.

    python benchmarks/maps.py [--quick]

Wall times of `mbcheck.comparisons.maps.run.compute` in this process and its workers, as
ratios within one run: time per point of a map against that of one with a quarter of its
points (1 is linear), one process against several, and all points against those near boundaries.
"""

from __future__ import annotations

import argparse
import os
from itertools import pairwise
from time import perf_counter

from rich.console import Console
from rich.table import Table

from mbcheck.comparisons.maps.request import Axis, Request, resolved
from mbcheck.comparisons.maps.run import compute
from mbcheck.comparisons.maps.store import Map

AXES = {
    "hula_hoop": (("force_frequency", 1.0, 10.0), ("force_amplitude", 5.0, 150.0)),
    "rotor_pendulum": (("n_x", 0.5, 7.0), ("n_phi", 0.5, 7.0)),
    "rotating_beam": (("angular_speed", 0.0, 10.0), ("mass_ratio", 0.0, 1.0)),
    "speed_regulator": (("damping", 0.5, 6.0), ("torque", 0.02, 1.2)),
}
QUANTITIES = {
    "hula_hoop": "floquet",
    "rotor_pendulum": "phase",
    "rotating_beam": "frequency",
    "speed_regulator": "regime",
}


def timed(scene: str, count: int, workers: int = 1, refine: bool = False) -> tuple[float, Map]:
    """Return the wall time [s] of a map of ``count`` x ``count`` points, and the map."""
    x, y = (Axis(*axis, count) for axis in AXES[scene])
    asked = resolved(Request(scene, QUANTITIES[scene], x, y, refine=refine))
    begin = perf_counter()
    found = compute(asked, workers=workers)
    return perf_counter() - begin, found


def growth(counts: tuple[int, ...]) -> Table:
    """Time per point of each scene's default map, against that of a quarter of the points."""
    table = Table(title="ms per point by the reference, one process (ratio to a quarter of them)")
    for heading in ("scene", "quantity", *(f"{n} x {n}" for n in counts)):
        table.add_column(heading, no_wrap=True)
    for scene in AXES:
        timed(scene, 2)  # imports and warms up
        each = [1e3 * timed(scene, count)[0] / count**2 for count in counts]
        ratios = [f"{now:.3g} ({now / before:.2f})" for before, now in pairwise(each)]
        table.add_row(scene, QUANTITIES[scene], f"{each[0]:.3g}", *ratios)
    return table


def sharing(count: int, workers: int) -> Table:
    """One process against several, and the whole grid against a refined one."""
    table = Table(title=f"hula_hoop floquet, {count} x {count} points")
    for heading in ("", "seconds", "points", "ratio to the first"):
        table.add_column(heading, no_wrap=True)
    first = 0.0
    for name, number, refine in (
        ("1 process", 1, False),
        (f"{workers} processes", workers, False),
        (f"{workers} processes, refined", workers, True),
    ):
        seconds, found = timed("hula_hoop", count, number, refine)
        first = first or seconds
        points = int(found.computed.sum())
        table.add_row(name, f"{seconds:.3g}", str(points), f"{first / seconds:.2f}")
    return table


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--quick", action="store_true", help="fewer points")
    quick = parser.parse_args().quick
    console = Console()
    console.print(growth((2, 4) if quick else (8, 16, 32)))
    console.print(sharing(8 if quick else 128, os.cpu_count() or 1))


if __name__ == "__main__":
    main()
