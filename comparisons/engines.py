"""The engines that mbcheck knows, by name."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from ..reference import SCENES
from ..reference.errors import EngineUnavailableError, UnknownNameError, UsageError
from .engine import Engine

ENGINES = ("reference", "mujoco", "exudyn")
"""`reference` is what the others are checked against."""


def judged() -> tuple[str, ...]:
    """Return the names of the engines that are checked."""
    return tuple(name for name in ENGINES if name != "reference")


def usable(engine: str) -> bool:
    """Return whether an engine can be imported here."""
    try:
        get_engine(engine)
    except EngineUnavailableError:
        return False
    return True


def available() -> tuple[str, ...]:
    """Return the names of the engines that are checked and can be imported here."""
    return tuple(name for name in judged() if usable(name))


def chosen(
    scenes: Sequence[str] = (), engines: Sequence[str] = ()
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the scenes and engines that are asked for; without any, all that there are.

    Raises
    ------
    UsageError
        For an unknown name, the reference, or an engine asked for that is not there.
    """
    known = judged()
    if "reference" in engines:
        raise UsageError(
            f"the reference is what engines are checked against; choose {' or '.join(known)}"
        )
    for given, names, what in ((scenes, SCENES, "scene"), (engines, known, "engine")):
        for name in given:
            if name not in names:
                raise UnknownNameError(what, name, names)
    for name in engines:
        get_engine(name)
    found = tuple(dict.fromkeys(engines)) or available()
    if not found:
        raise UsageError("no engine can be imported here; `mbcheck --version` tells why")
    return tuple(dict.fromkeys(scenes)) or tuple(SCENES), found


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
