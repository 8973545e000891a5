"""The way of one check through the package: which rooms it enters, and how often it climbs back.

A room is a module; `reference` is one room, and so is the folder of an engine. Reports are left
out. A stay is a call that enters another room than the last one; repeats of stays that follow each
other at once count once. A return is a stay in a room that was first entered before the room just
left: a climb back.

    python -m mbcheck.tests.support.house.walk

prints the way of one *step* check of `hula_hoop` in a fresh process, on which it depends.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

from mbcheck.comparisons.checks.suite import Check, plan, run_check

HOUSE = Path(__file__).resolve().parents[3]

LONGEST_REPEAT = 80
"""Stays of a repeat: those of one run, which each start of a check goes through."""


def room_of(file: str) -> str | None:
    """Return the room of a module by the path of its file; None where it is left out."""
    path = Path(file).resolve()
    if file.startswith("<") or not path.is_relative_to(HOUSE):
        return None
    parts = path.relative_to(HOUSE).with_suffix("").parts
    if parts[0] == "reference":
        return parts[0]
    if parts[:2] == ("comparisons", "engines") and len(parts) > 3:
        return "/".join(parts[:3])
    reports = parts[:2] == ("comparisons", "reports")
    return None if reports or parts[0] in ("tests", ".venv") else "/".join(parts)


def collapsed(stays: list[str]) -> list[str]:
    """Return stays without repeats that follow each other at once."""
    before: list[str] = []
    while before != stays:
        before = stays
        for length in range(1, LONGEST_REPEAT + 1):
            left: list[str] = []
            for stay in stays:
                left.append(stay)
                if left[-length:] == left[-2 * length : -length]:
                    del left[-length:]
            stays = left
    return stays


def walk(work: Callable[[], Any]) -> tuple[list[str], list[str], list[str]]:
    """Return the stays of some work, its rooms in the order of entry, and its returns."""
    rooms: dict[str, str | None] = {}
    stays: list[str] = []

    def follow(frame: Any, event: str, _: Any) -> None:
        code = frame.f_code
        if event == "call" and code.co_name != "<module>":
            file = code.co_filename
            if file not in rooms:
                rooms[file] = room_of(file)
            if rooms[file] is not None and stays[-1:] != [rooms[file]]:
                stays.append(str(rooms[file]))

    sys.setprofile(follow)
    try:
        work()
    finally:
        sys.setprofile(None)
    stays = collapsed(stays)
    order = list(dict.fromkeys(stays))
    steps = pairwise(stays)
    return stays, order, [b for a, b in steps if order.index(b) < order.index(a)]


def step_check(scene: str) -> Check:
    """Return the first *step* check of a scene by MuJoCo's method RK4."""
    checks = plan(scenes=[scene], engines=["mujoco"], kinds=["step"])
    return next(check for check in checks if check.method and check.method.name == "RK4")


if __name__ == "__main__":
    run_check(step_check("rotor_pendulum"))  # what is imported late
    chosen = step_check("hula_hoop")
    stays, order, returns = walk(lambda: run_check(chosen))
    print(f"{len(order)} rooms, {len(stays)} stays, {len(returns)} returns")
    if "-v" in sys.argv:
        print("\n".join(stays))
