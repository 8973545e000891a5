"""The engines that mbcheck knows, by name."""

from __future__ import annotations

from functools import cache

from ..reference.errors import UnknownNameError
from .engine import Engine

ENGINES = ("reference", "mujoco", "exudyn")
"""`reference` is what the others are checked against."""


@cache
def get_engine(name: str) -> Engine:
    """Return the engine of this name; one per process.

    Raises
    ------
    UnknownNameError
        If there is none.
    EngineUnavailableError
        If it cannot be imported on this machine.
    """
    if name == "mujoco":
        from .mujoco_engine import MujocoEngine

        return MujocoEngine()
    if name == "exudyn":
        from .exudyn_engine import ExudynEngine

        return ExudynEngine()
    if name == "reference":
        from .reference_engine import ReferenceEngine

        return ReferenceEngine()
    raise UnknownNameError("engine", name, ENGINES)
