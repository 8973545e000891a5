"""What figures and rows are computed with: engines, maps, and what was computed before."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar

from ...reference.errors import UsageError
from ..engines.registry import REFERENCE
from ..maps.request import Axis, Request, resolved
from ..maps.run import compute
from ..maps.store import Map, read

T = TypeVar("T")

LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class Session:
    """One run of ``mbcheck reproduce``.

    Attributes
    ----------
    engines : tuple of str
        Engines beside the reference that can be imported here.
    full : bool
        Maps and runs at full size.
    workers : int
        Processes that maps are computed in.
    folder : Path or None
        Where maps are kept, so that an interrupted run goes on with them.
    progress : callable ``(name, done, total)``
        Told how far a map is.
    points : int, optional
        Points along the axes of the papers' maps, in place of their own numbers.
    engine_points : int, optional
        The same of the engines' maps alone.
    seconds : float, optional
        Duration of runs from rest [s], in place of their own.
    cache : dict
        What was computed before, by key.
    """

    engines: tuple[str, ...] = ()
    full: bool = False
    workers: int = 1
    folder: Path | None = None
    progress: Callable[[str, int, int], None] = lambda name, done, total: None
    points: int | None = None
    engine_points: int | None = None
    seconds: float | None = None
    cache: dict[Any, Any] = field(default_factory=dict)

    def once(self, key: Any, produce: Callable[[], T]) -> T:
        """Return what `produce` returns, called only the first time that a key is asked for."""
        if key not in self.cache:
            self.cache[key] = produce()
        value: T = self.cache[key]
        return value

    @property
    def everyone(self) -> tuple[str, ...]:
        """Return the reference and the engines."""
        return (REFERENCE, *self.engines)

    def map(
        self,
        scene: str,
        quantity: str,
        x: tuple[str, float, float, int],
        y: tuple[str, float, float, int],
        **asked_for: Any,
    ) -> Map:
        """Return a map, computed once; what is asked for is that of `request`."""
        asked = resolved(Request(scene, quantity, Axis(*x), Axis(*y), **asked_for))
        settings = json.dumps(asked.as_dict(), sort_keys=True)
        return self.once(settings, lambda: self._map(asked, settings))

    def stored_map(self, file: Path, settings: str) -> Map | None:
        """Return a map from its file if there is one, and it is intact and that of the settings."""
        if not file.exists():
            return None
        with suppress(UsageError):
            stored = read(file)
            if json.loads(settings) == stored.settings:
                return stored
        LOG.warning("Warning: %s is damaged, or another map: computed again", file)
        return None

    def _map(self, asked: Any, settings: str) -> Map:
        """Read a map if it is there, or else compute it."""
        name = f"{asked.scene} {asked.quantity} {asked.engine} {asked.model}"
        unfinished = None
        if self.folder is not None:
            key = sha256(settings.encode()).hexdigest()[:12]
            file = self.folder / f"{name.replace(' ', '_')}_{key}.nc"
            if stored := self.stored_map(file, settings):
                return stored
            unfinished = file.with_suffix(".unfinished")
        computed = compute(
            asked,
            workers=self.workers,
            unfinished=unfinished,
            resume=True,
            progress=lambda done, total: self.progress(name, done, total),
        )
        if unfinished is not None:
            computed.save(file)
            unfinished.unlink(missing_ok=True)
        return computed
