"""An engine that crashes its process, hangs, or eats memory; each by a method of its own."""

from __future__ import annotations

import ctypes
import os
import time
from collections.abc import Callable
from typing import Any

from mbcheck.comparisons.engines import registry as engines
from mbcheck.comparisons.engines.protocol import Method
from mbcheck.comparisons.engines.reference import ReferenceEngine, ReferenceModel
from mbcheck.comparisons.engines.run import Trajectory, grid_indices
from mbcheck.reference import get_scene
from mbcheck.reference.scene import Array, Case
from mbcheck.reference.solve import schemes

NAME = "hostile"


def hang() -> None:
    """Sleep in C, for ever."""
    while True:
        time.sleep(3600)


def spin() -> None:
    """Compute for ever."""
    while True:
        pass


def eat() -> None:
    """Allocate without end; 8 GiB, should nothing stop it."""
    kept = []
    for _ in range(512):
        kept.append(bytearray(1 << 24))
    raise AssertionError("had all the memory that it wanted")


def leave() -> None:
    """End the process as if all were well."""
    os._exit(3)


def read_nothing() -> None:
    """Read at address 0, as C code does that was given no memory."""
    ctypes.string_at(0)


def megabytes(number: int) -> int:
    """Return the length of so much memory, once it was had."""
    return len(bytearray(number << 20))


DEEDS: dict[str, Callable[[], None]] = {
    "abort": os.abort,
    "hang": hang,
    "spin": spin,
    "eat": eat,
    "leave": leave,
}


class HostileModel(ReferenceModel):
    """A model whose runs do what their method is named after."""

    def simulate(self, case: Case, method: Method, step: float, times: Array) -> Trajectory:
        if method.name in DEEDS:
            DEEDS[method.name]()
        scene, p = get_scene(case.scene), case.parameters
        numbers = grid_indices(times, case.start_time, step)
        equations, start = schemes.ScalarEquations(scene, p), scene.state(case.state)
        states = schemes.integrate(equations, "RK44", start, step, numbers)
        values = scene.observe(states, p)
        return Trajectory(times=times, values=values, clock=times, steps=int(numbers[-1]))


class Hostile(ReferenceEngine):
    """The reference's equations by Kutta's method; other methods do what they are named after."""

    bound = HostileModel

    def __init__(self) -> None:
        super().__init__()
        self.name, self.version = NAME, "0"
        self.methods = tuple(Method(name, 4, "RK44") for name in ("RK4", *DEEDS))

    def models(self, scene: str) -> tuple[str, ...]:
        return ("exact",)


def register() -> None:
    """Make it one of the engines of this process."""
    known = engines.get_engine

    def get_engine(name: str) -> Any:
        return Hostile() if name == NAME else known(name)

    engines.ENGINES = (*engines.ENGINES, NAME)  # type: ignore[assignment]
    engines.get_engine = get_engine


def throw(end: type[BaseException]) -> None:
    """Raise it."""
    raise end("gone")
