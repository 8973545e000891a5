"""What figures and rows are computed with: engines, maps, and what was computed before."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from ..maps.run import Map

T = TypeVar("T")


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
    """

    engines: tuple[str, ...] = ()
    full: bool = False
    workers: int = 1
    folder: Path | None = None
    kept: dict[Any, Any] = field(default_factory=dict)

    def once(self, key: Any, find: Callable[[], T]) -> T:
        """Return what `find` returns, computed only the first time that a key is asked for."""
        if key not in self.kept:
            self.kept[key] = find()
        value: T = self.kept[key]
        return value

    def map(
        self,
        scene: str,
        quantity: str,
        x: tuple[str, float, float, int],
        y: tuple[str, float, float, int],
        engine: str = "reference",
        model: str | None = None,
        parameters: Mapping[str, Any] | None = None,
        refine: bool = False,
        **more: Any,
    ) -> Map:
        """Return a map, see `mbcheck.comparisons.maps.run.compute`; each is computed once."""
        raise NotImplementedError
