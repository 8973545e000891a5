"""The engines that mbcheck knows by name, and those that others plug in."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, partial
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

from ...reference import SCENES
from ...reference.errors import (
    BrokenEngineError,
    EngineUnavailableError,
    MbcheckError,
    UnknownNameError,
    UsageError,
)
from . import REFERENCE as REFERENCE
from .adapter import Adapter, adapt
from .isolation import RemoteEngine
from .protocol import Engine
from .run import IN_SIGHT, call_engine, captured
from .validation import attributes

ENGINES = (REFERENCE, "mujoco", "exudyn")
"""Engines that come with mbcheck."""

GROUP = "mbcheck.engines"
"""Entry points under which installed packages offer engines."""

_named: dict[str, Adapter] = {}
"""Engines that were given as ``package.module:Class``, by the name that they call themselves."""


@cache
def offered() -> dict[str, EntryPoint]:
    """Return the engines that installed packages offer, by name."""
    points = {point.name: point for point in entry_points(group=GROUP)}
    return {name: point for name, point in sorted(points.items()) if name not in ENGINES}


def known() -> tuple[str, ...]:
    """Return the names of all engines: our own, then those that packages offer.

    Those that mbcheck offers to who installs an extra are left out where it is not installed.
    """
    return (*ENGINES, *(name for name in offered() if usable(name) or not ours(name)))


def ours(name: str) -> bool:
    """Return True if mbcheck itself offers an engine, by an extra."""
    point = offered().get(name)
    return point is not None and point.dist is not None and point.dist.name == "mbcheck"


def installed(name: str) -> bool:
    """Return True if an engine is installed, though it may not run on this machine."""
    return name in offered() or importlib.util.find_spec(name) is not None


def checked_engines() -> tuple[str, ...]:
    """Return the names of the engines that are checked."""
    return tuple(name for name in known() if name != REFERENCE)


def usable(engine: str) -> bool:
    """Return True if an engine can be imported here."""
    try:
        get_engine(engine)
    except EngineUnavailableError:
        return False
    return True


def available() -> tuple[str, ...]:
    """Return the names of the engines that are checked and can be imported here."""
    return tuple(name for name in checked_engines() if usable(name))


def resolve_selection(
    scenes: Sequence[str] = (), engines: Sequence[str] = ()
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the selected scenes and engines; all of them if none are named.

    An engine may be a ``package.module:Class`` too.

    Raises
    ------
    UsageError
        For an unknown name, the reference, or an engine that cannot be imported.
    """
    if REFERENCE in engines:
        raise UsageError(
            "the reference is what engines are checked against; choose "
            f"{', '.join(checked_engines())} or package.module:Class"
        )
    for name in scenes:
        if name not in SCENES:
            raise UnknownNameError("scene", name, SCENES)
    failures = broken_engines(engines)
    names = tuple(dict.fromkeys(name for name in engines if name not in failures)) or (
        () if engines else available()
    )
    if not names and not failures:
        raise UsageError("no engine can be imported here; `mbcheck --version` tells why")
    return tuple(dict.fromkeys(scenes)) or tuple(SCENES), names


def broken_engines(names: Sequence[str]) -> dict[str, BrokenEngineError]:
    """Return the failures of engines to load, by the name that the user gave.

    Raises
    ------
    UsageError
        If there is none of a name.
    """
    failures = {}
    for name in names:
        try:
            get_engine(name)
        except BrokenEngineError as error:
            failures[name] = error
    return failures


def get_engine(name: str) -> Adapter:
    """Return the engine of this name, or ``package.module:Class``; one per process.

    Raises
    ------
    UnknownNameError
        If there is none.
    EngineUnavailableError
        If it cannot be imported on this machine.
    UsageError
        If a plugged-in engine does not follow the protocol.
    """
    engine = _named.get(name) or _loaded(name)
    if isinstance(engine, BrokenEngineError):
        raise engine
    if engine.failure is not None:
        raise engine.failure
    return engine


LENT: ContextVar[tuple[str, ...]] = ContextVar("LENT", default=())
"""Names of the engines that were given as objects, while `lent` is active."""


@contextmanager
def lent(engines: Sequence[Any]) -> Iterator[tuple[str, ...]]:
    """Return the names of engines of which some are objects; those run in this process.

    Raises
    ------
    UsageError
        If one does not follow the protocol, or two have the same name.
    """
    objects: dict[str, Adapter] = {}
    for engine in engines:
        if not isinstance(engine, str):
            kind = engine if isinstance(engine, type) else type(engine)
            adapter = adapt(kind.__name__, engine)
            if adapter.name in (*ENGINES, *engines, *objects, *_named):
                raise UsageError(f"two engines call themselves {adapter.name}: rename one")
            objects[adapter.name] = adapter
    own = iter(objects)
    names = tuple(one if isinstance(one, str) else next(own) for one in engines)
    before = LENT.set(tuple(objects))
    _named.update(objects)
    try:
        yield names
    finally:
        LENT.reset(before)
        for name in objects:
            del _named[name]


@contextmanager
def in_this_process(engines: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """Return the names of engines; those that others plug in run in this process meanwhile.

    Its console is the user's, as a debugger needs it.

    Raises
    ------
    UsageError
        If there is none, or as of `get_engine`.
    """
    plugins = [name for name in engines if ":" in name or name in offered()]
    if not plugins:
        raise UsageError(
            "--in-process runs engines that others plug in: name one by --engine, with the name of "
            "its entry point or as package.module:Class"
        )
    hidden = IN_SIGHT.set(True)
    try:
        with lent(
            [load_plugin(name).inner if name in plugins else name for name in engines]
        ) as names:
            yield names
    finally:
        IN_SIGHT.reset(hidden)


@cache
def _loaded(name: str) -> Adapter | BrokenEngineError:
    """Return an engine, or how it fails, which may take long to find."""
    try:
        return _load(name)
    except BrokenEngineError as error:
        return error


def _load(name: str) -> Adapter:
    if name == "mujoco":
        from .mujoco.engine import MuJoCo

        return Adapter(MuJoCo())
    if name == "exudyn":
        from .exudyn.engine import Exudyn

        return Adapter(Exudyn())
    if name == REFERENCE:
        from .reference import ReferenceEngine

        return ReferenceEngine()
    if ":" in name or name in offered():
        engine = load_plugin(name) if ours(name) else remote_plugin(name)
        return _register(engine) if ":" in name else engine
    if "." in name:
        meant = ":".join(name.rsplit(".", 1))
        raise UsageError(
            f"engine {name!r}: a class is named package.module:Class, with a colon; did you mean "
            f"{meant!r}?"
        )
    raise UnknownNameError("engine", name, known())


@cache
def load_plugin(name: str) -> Adapter:
    """Return a plugged-in engine that runs in this process; one per process."""
    if ":" not in name:
        return _offered(name)
    with _here_first():
        return adapt(name, _imported(*name.split(":", 1)))


def remote_plugin(name: str) -> Adapter:
    """Return a plugged-in engine that runs in a separate process.

    Raises
    ------
    BrokenEngineError
        If it fails as it is loaded; names it.
    """
    try:
        engine = RemoteEngine(partial(describe_plugin, name), partial(plugin_here, name))
    except BrokenEngineError as error:
        reason = f"{error}".removeprefix(f"engine {name}: ")
        raise BrokenEngineError(f"engine {name}: {reason}", error.traceback) from error
    return adapt(name, engine)


def describe_plugin(name: str) -> dict[str, Any]:
    """Return the attributes of a plugged-in engine of this process, and the functions it has."""
    adapter = load_plugin(name)
    own = {"functions": sorted(adapter.functions), "by_method": sorted(adapter.takes_method)}
    return attributes(adapter.inner) | own


@cache
def plugin_here(name: str, settings: tuple[tuple[str, float], ...] = ()) -> Engine:
    """Return a plugged-in engine of this process, without its adapter, with options set."""
    engine = load_plugin(name).inner
    for option, value in settings:
        engine = engine.with_option(option, value)
    return engine


def _offered(name: str) -> Adapter:
    """Return an engine of an installed package, which must not stop others from being checked.

    Raises
    ------
    EngineUnavailableError
        If it cannot be used.
    """
    point = offered()[name]
    others = {other.value for other in entry_points(group=GROUP, name=name)}
    if len(others) > 1:
        raise EngineUnavailableError(
            f"engine {name} is offered by {' and by '.join(sorted(others))}: uninstall one"
        )
    try:
        engine = adapt(name, _imported(point.module, point.attr))
        if engine.name != name:
            raise UsageError(f"it calls itself {engine.name}")
    except EngineUnavailableError:
        raise
    except UsageError as error:
        raise EngineUnavailableError(f"engine {name} ({point.value}): {error}") from error
    return engine


def _register(engine: Adapter) -> Adapter:
    """Make an engine known by the name that it calls itself.

    Raises
    ------
    UsageError
        If another engine has that name.
    """
    if engine.name in ENGINES:
        raise UsageError(f"an engine calls itself {engine.name}: choose another name for it")
    if _named.setdefault(engine.name, engine) is not engine:
        raise UsageError(f"two engines call themselves {engine.name}: rename one")
    return engine


@contextmanager
def _here_first() -> Iterator[None]:
    """Look for modules in the working directory first, and from then on last."""
    here = str(Path.cwd())
    sys.path.insert(0, here)
    try:
        yield
    finally:
        sys.path.remove(here)
        if here not in sys.path:
            sys.path.append(here)


def _imported(module: str, attribute: str) -> Any:
    """Return an attribute of a module.

    Raises
    ------
    EngineUnavailableError
        If the module cannot be imported.
    UsageError
        If it has no such attribute.
    """
    if "/" in module or module.endswith(".py"):
        raise UsageError(
            f"engine {module}:{attribute}: give the module's name, without .py or a path"
        )
    try:
        loaded = call_engine(lambda: importlib.import_module(module), container=captured)
    except MbcheckError as error:  # whatever a third-party module raises
        cause = error.__cause__
        absent = cause.name if isinstance(cause, ModuleNotFoundError) else None
        missing = absent is not None and f"{module}.".startswith(f"{absent}.")
        kind = EngineUnavailableError if missing else BrokenEngineError
        cure = "correct the module; -v shows where it raised"
        if absent:
            cure = f"install the package that provides {absent} for this Python"
        if missing:
            cure = f"run mbcheck in the folder of {absent}, or install its package with pip"
        message = f"{module} cannot be imported ({error}); {cure}"
        raise kind(message, error.traceback) from error
    try:
        place: Any = loaded
        for part in attribute.split("."):
            place = getattr(place, part)
    except AttributeError:
        classes = [key for key, item in vars(loaded).items() if isinstance(item, type)]
        raise UnknownNameError(f"class of {module}", attribute, classes) from None
    return place
