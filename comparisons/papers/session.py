"""The engines, sizes and earlier results that figures and rows are computed with."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial, wraps
from hashlib import sha256
from inspect import signature
from pathlib import Path
from time import monotonic
from typing import Any, Concatenate, ParamSpec, TypeVar

from ...reference.errors import UsageError
from ..maps.request import Axis, Request, resolved
from ..maps.run import compute
from ..maps.store import Map
from ..terminal.program import time_left

P = ParamSpec("P")
T = TypeVar("T")

LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class Session:
    """One run of ``mbcheck reproduce``.

    Attributes
    ----------
    engines : tuple of str
        Engines besides the reference that can be imported here.
    full : bool
        Maps and runs at full size.
    workers : int
        Number of processes that compute maps.
    folder : Path or None
        Where maps are kept, so that an interrupted run goes on with them.
    progress : callable ``(words)``
        Called as the points of a map, or runs, are finished.
    points : int, optional
        Points along the axes of the papers' maps, in place of their own numbers.
    engine_points : int, optional
        The same of the engines' maps alone.
    seconds : float, optional
        Duration of runs from rest [s], in place of their own.
    cache : dict
        Earlier results, by key.
    """

    engines: tuple[str, ...] = ()
    full: bool = False
    workers: int = 1
    folder: Path | None = None
    progress: Callable[[str], None] = lambda words: None
    points: int | None = None
    engine_points: int | None = None
    seconds: float | None = None
    cache: dict[Any, Any] = field(default_factory=dict)

    def once(self, key: Any, produce: Callable[[], T]) -> T:
        """Return the value of `produce`, called only the first time that a key is used."""
        if key not in self.cache:
            self.cache[key] = produce()
        value: T = self.cache[key]
        return value

    def follow(self, what: str) -> Callable[[int, int], None]:
        """Return a function ``(done, total)`` that reports progress and the remaining time."""
        begin = monotonic()

        def report(done: int, total: int) -> None:
            left = time_left(monotonic() - begin, done / total) if done < total else ""
            self.progress(f"{what} {done}/{total}" + f" ({left})" * bool(left))

        return report

    def map(
        self,
        scene: str,
        quantity: str,
        x: tuple[str, float, float, int],
        y: tuple[str, float, float, int],
        **settings: Any,
    ) -> Map:
        """Return a map, computed once; the settings are those of a map's `Request`."""
        request = resolved(Request(scene, quantity, Axis(*x), Axis(*y), **settings))
        key = json.dumps(request.as_dict(), sort_keys=True)
        return self.once(key, lambda: self._map(request, key))

    def _map(self, request: Any, settings: str) -> Map:
        """Compute a map, except for the points that its file in the folder has."""
        name = f"{request.scene} {request.quantity} {request.engine} {request.model}"
        key = sha256(settings.encode()).hexdigest()[:12]
        file = self.folder and self.folder / f"{name.replace(' ', '_')}_{key}.nc"
        progress = self.follow(f"map {name}")
        call = partial(compute, request, workers=self.workers, resume=True, progress=progress)
        try:
            return call(unfinished=file)
        except UsageError:
            if not (file and file.exists()):
                raise
            LOG.warning("Warning: %s is damaged, or another map: computed again", file)
            file.unlink()
            return call(unfinished=file)


def once(function: Callable[Concatenate[Session, P], T]) -> Callable[Concatenate[Session, P], T]:
    """Let a function of a session compute its value once for the same arguments.

    The key in the session's cache is the function's name, after that of its paper, and all its
    arguments: ``("hula_hoop.example_orbit", "reference")``.
    """
    scene, parameters = function.__module__.split(".")[-2], signature(function)

    @wraps(function)
    def remembered(session: Session, /, *args: P.args, **more: P.kwargs) -> T:
        bound = parameters.bind(session, *args, **more)
        bound.apply_defaults()
        key = (f"{scene}.{function.__name__}", *bound.args[1:])
        return session.once(key, lambda: function(session, *args, **more))

    return remembered
