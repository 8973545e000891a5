"""What a map is asked for: its axes, its quantity, who computes it; and one block of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...reference import get_scene
from ...reference.errors import UnknownNameError, UsageError
from ...reference.scene import Array, Case, Scene
from ..engines.registry import REFERENCE, get_engine
from ..queries.environment import versions
from ..queries.query import choose_engine, choose_method, known_name, valid_step
from ..scenes.data import scene_data
from ..scenes.quantity import AxisName, Found, Points, Quantity

MOST_POINTS = 1 << 26
"""Larger grids are refused as a slip of the pen."""


@dataclass(frozen=True)
class Axis:
    """One axis of a map: equally spaced values of a parameter.

    Attributes
    ----------
    name : str
        A parameter of the scene, or one of its `AxisName`.
    low, high : float
        First and last value.
    count : int
        How many, 2 or more.

    Raises
    ------
    UsageError
        If it is no such axis.
    """

    name: str
    low: float
    high: float
    count: int

    def __post_init__(self) -> None:
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise UsageError(
                f"axis {self.name}: it must go from a lower to a higher finite number, not from "
                f"{self.low!r} to {self.high!r}"
            )
        if self.count < 2:
            raise UsageError(f"axis {self.name}: it needs 2 values or more, not {self.count}")

    @cached_property
    def values(self) -> Array:
        """Return the values (count,)."""
        return np.linspace(self.low, self.high, self.count)


def quantities(scene: str) -> Mapping[str, Quantity]:
    """Return what can be mapped of a scene, by name; a scene may have nothing.

    Raises
    ------
    UnknownNameError
        If there is no such scene.
    """
    none: Mapping[str, Quantity] = {}
    return scene_data(scene, "maps", "QUANTITIES", none)


def axis_names(scene: str) -> Mapping[str, AxisName]:
    """Return what may stand on an axis beside the scene's parameters."""
    none: Mapping[str, AxisName] = {}
    return scene_data(scene, "maps", "AXES", none)


@dataclass(frozen=True)
class Request:
    """Everything that a map depends on.

    Attributes
    ----------
    scene, quantity, engine, model : str
    method : str or None
    step : float or None
        Longest step wanted [s].
    parameters : mapping
        Parameters that differ from the scene's defaults.
    x, y : Axis
    refine : bool
        Only points near the boundaries of classes are computed.
    block : int
        Points computed together.
    """

    scene: str
    quantity: str
    x: Axis
    y: Axis
    engine: str = REFERENCE
    model: str = ""
    method: str | None = None
    step: float | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    refine: bool = False
    block: int = 0

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the grid."""
        return self.y.count, self.x.count

    @property
    def shown(self) -> Quantity:
        """Return what is mapped."""
        return quantities(self.scene)[self.quantity]

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain values, with the versions of what it is computed with."""
        return {**asdict(self), "versions": versions([self.engine])}


def request(
    scene: str,
    quantity: str,
    x: Axis,
    y: Axis,
    *,
    engine: str = REFERENCE,
    model: str | None = None,
    method: str | None = None,
    step: float | None = None,
    parameters: Mapping[str, Any] | None = None,
    refine: bool = False,
    block: int | None = None,
) -> Request:
    """Check what is asked for, and fill in what is left open.

    Raises
    ------
    UsageError
        If a name is unknown, a value impossible, or the engine cannot do it.
    """
    known = quantities(scene)
    if quantity not in known:
        raise UnknownNameError(f"quantity of {scene}", quantity, known)
    shown = known[quantity]
    get_engine(engine)
    own = get_scene(scene)
    changed = dict(parameters or {})
    if x.name == y.name:
        raise UsageError(f"both axes are {x.name}: a map needs two parameters")
    for axis in (x, y):
        numbers = [name for name in own.parameters.names() if name not in own.parameters.choices()]
        names = [*numbers, *axis_names(scene)]
        if axis.name not in names:
            raise UnknownNameError(f"axis of {scene}", axis.name, names)
        if axis.name in changed:
            raise UsageError(f"{axis.name} is on an axis, and so cannot be set as well")
    if x.count * y.count > MOST_POINTS:
        raise UsageError(f"{x.count} x {y.count} are more points than mbcheck computes")
    if step is not None:
        step = valid_step(step)
    if block is not None and block < 1:
        raise UsageError(f"a block needs 1 point or more, not {block}")
    if refine and not any(item.classes for item in shown.variables.values()):
        raise UsageError(f"--refine follows the boundaries of classes, and {quantity} has none")
    base = own.parameters().replace(**changed)
    for low_or_high in ("low", "high"):
        ends = {axis.name: np.array([getattr(axis, low_or_high)]) for axis in (x, y)}
        corner = on_axes(scene, base, ends)
    if engine == REFERENCE:
        model = known_name(f"model of {quantity}", model, shown.models)
        if method is not None:
            raise UsageError("--method is of engines: the reference has none")
        size = shown.block
    else:
        if not shown.engines:
            raise UsageError(f"{quantity} is of the theory alone: no engine can compute it")
        case = Case(scene, "corner", first(corner))
        chosen, model = choose_engine(engine, case, model)
        method = choose_method(chosen, case, model, method).name
        size = shown.engine_block
    return Request(
        scene, quantity, x, y, engine, model, method, step, changed, refine, block or size
    )


def on_axes(scene: str, base: Any, values: Mapping[str, Array]) -> Any:
    """Return parameters whose fields on the axes are arrays (k,).

    Parameters come before what sets parameters, so that this can depend on those.
    """
    special = axis_names(scene)
    changed = base.replace(**{k: v for k, v in values.items() if k not in special})
    for name, value in values.items():
        if name in special:
            changed = special[name].apply(changed, value)
    return changed


def first(parameters: Any) -> Any:
    """Return the parameters of the first point."""
    changes = {
        item.name: float(value.flat[0])
        for item in fields(parameters)
        if np.ndim(value := getattr(parameters, item.name))
    }
    return parameters.replace(**changes)


def evaluate(asked: Request, places: NDArray[np.int_]) -> Found:
    """Compute some points of a map.

    Parameters
    ----------
    asked : Request
    places : int array (k, 2)
        Columns and rows.

    Returns
    -------
    Found
    """
    scene: Scene = get_scene(asked.scene)
    values = {
        asked.x.name: asked.x.values[places[:, 0]],
        asked.y.name: asked.y.values[places[:, 1]],
    }
    base = scene.parameters().replace(**asked.parameters)
    points = Points(
        scene,
        on_axes(asked.scene, base, values),
        places,
        values,
        asked.engine,
        asked.model,
        asked.method,
        asked.step,
    )
    return asked.shown.evaluate(points)
