"""Computing a map: its grid in blocks, by one core, all cores, or a cluster."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...reference.scene import Array


@dataclass(frozen=True)
class Axis:
    """One axis of a map: ``count`` equally spaced values of a parameter.

    Attributes
    ----------
    name : str
        A parameter of the scene, or one of its `AxisName`.
    low, high : float
    count : int
    """

    name: str
    low: float
    high: float
    count: int

    @property
    def values(self) -> Array:
        """Return the values (count,)."""
        raise NotImplementedError


@dataclass(frozen=True)
class Map:
    """A map as it was computed, or read from its file.

    Attributes
    ----------
    x, y : Axis
    variables : mapping of str to array (n_y, n_x)
        Classes are int8, with -1 for no value.
    about : mapping of str to Variable
        Unit, meaning and classes of each.
    computed : int8 array (n_y, n_x)
        1 where a point was computed, 0 where ``--refine`` filled it in.
    settings : mapping
        Scene, quantity, engine, model, method, step, parameters, versions.
    problems : tuple of (float, float, str)
        Points at which the engine failed, and how.
    """

    x: Axis
    y: Axis
    variables: Mapping[str, Array]
    about: Mapping[str, Any]
    computed: Array
    settings: Mapping[str, Any]
    problems: tuple[tuple[float, float, str], ...] = ()


def compute(*args: Any, **more: Any) -> Map:
    """Compute a map."""
    raise NotImplementedError
