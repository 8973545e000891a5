"""Request of a map: axes, quantity, engine; and one block of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from importlib.metadata import version
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...reference import get_scene
from ...reference.errors import UnknownNameError, UsageError
from ...reference.scene import Array, Case
from ...reference.solve import HEYOKA, takes_heyoka
from ..documents.fields import OptionMark
from ..engines.registry import REFERENCE, get_engine
from ..queries.axis import ParameterRange, refuse_axes
from ..queries.environment import versions
from ..queries.query import known_name, valid_step
from ..queries.request import MethodQuery
from ..scenes.data import scene_data
from ..scenes.quantity import AxisName, Points, Quantity, QuantityValues

Backend = Literal["auto", "numpy", "heyoka"]

MOST_POINTS = 1 << 26
"""Larger grids are refused as a slip of the pen."""


@dataclass(frozen=True)
class Axis(ParameterRange):
    """One axis of a map: equally spaced values of a parameter, or of an `AxisName` of the scene.

    Attributes
    ----------
    count : int
        How many, 2 or more.

    Raises
    ------
    UsageError
        If it is no such axis.
    """

    count: int

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.count < 2:
            raise UsageError(f"axis {self.name}: it needs 2 values or more, not {self.count}")

    @cached_property
    def values(self) -> Array:
        """Return the values (count,)."""
        return np.linspace(self.low, self.high, self.count)

    def nearest(self, values: Array) -> NDArray[np.int_]:
        """Return the places (k,) of the values on the axis that are nearest to some (k,)."""
        return np.argmin(np.abs(values[:, None] - self.values), axis=1)


def quantities(scene: str) -> Mapping[str, Quantity]:
    """Return the quantities of a scene's maps, by name; a scene may have none.

    Raises
    ------
    UnknownNameError
        If there is no such scene.
    """
    return scene_data(scene, "maps", "QUANTITIES", {})


def axis_names(scene: str) -> Mapping[str, AxisName]:
    """Return the names of axes other than the scene's parameters."""
    return scene_data(scene, "maps", "AXES", {})


@dataclass(frozen=True)
class Request(MethodQuery):
    """Everything that a map depends on.

    Attributes
    ----------
    step : float or None
        Longest step [s].
    quantity : str
        See mbcheck list SCENE.
    x, y : Axis
        A parameter, or what mbcheck list SCENE names beside them: N values from LO to HI.
    refine : bool
        Compute only points near boundaries of classes.
    block : int or None
        Points computed together; by default as many as suit the quantity.
    backend : {"auto", "numpy", "heyoka"}
        What takes the reference's steps: heyoka where it is installed (extra fast) and serves the
        quantity, or NumPy.
    """

    quantity: Annotated[str, OptionMark("NAME")]
    x: Annotated[Axis, OptionMark("NAME=LO:HI:N", parse=Axis.parse)]
    y: Annotated[Axis, OptionMark("NAME=LO:HI:N", parse=Axis.parse)]
    refine: Annotated[bool, OptionMark()] = False
    block: Annotated[int | None, OptionMark("N")] = None
    backend: Annotated[Backend, OptionMark()] = "auto"

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the grid."""
        return self.y.count, self.x.count

    @property
    def case(self) -> Case:
        """The case of the last corner."""
        return Case(self.scene, "corner", corners_of(self).one(1))

    @property
    def mapped(self) -> Quantity:
        """The mapped quantity."""
        return quantities(self.scene)[self.quantity]

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain values, with the versions of the engine and libraries."""
        settings = {**asdict(self), "versions": versions([self.engine])}
        if self.backend == HEYOKA:
            settings["versions"][HEYOKA] = version(HEYOKA)
        else:  # maps of NumPy do not depend on the choice
            del settings["backend"]
        return settings


def resolved(asked: Request) -> Request:
    """Check a request, and choose model, method and block where these are left open.

    Raises
    ------
    UsageError
        If a name is unknown, a value impossible, or the engine cannot do it.
    """
    known = quantities(asked.scene)
    if asked.quantity not in known:
        raise UnknownNameError(f"quantity of {asked.scene}", asked.quantity, known)
    get_engine(asked.engine)
    names = [*get_scene(asked.scene).parameters.numeric_names(), *axis_names(asked.scene)]
    refuse_axes(f"a map of {asked.scene}", asked.x, asked.y, names, asked.parameters or {})
    if asked.x.count * asked.y.count > MOST_POINTS:
        raise UsageError(f"{asked.x.count} x {asked.y.count} are more points than mbcheck computes")
    if asked.block is not None and asked.block < 1:
        raise UsageError(f"a block needs 1 point or more, not {asked.block}")
    if asked.refine and not any(item.classes for item in asked.mapped.variables.values()):
        raise UsageError(
            f"--refine follows the boundaries of classes, and {asked.quantity} has none"
        )
    step = None if asked.step is None else valid_step(asked.step)
    asked = replace(asked, step=step, parameters=asked.parameters or {})
    corners_of(asked)  # which refuses impossible values
    return by_reference(asked) if asked.engine == REFERENCE else by_engine(asked)


def by_reference(asked: Request) -> Request:
    """Return a request of the reference with what was left open."""
    quantity = asked.mapped
    model = known_name(f"model of {asked.quantity}", asked.model, quantity.models)
    if asked.method is not None:
        raise UsageError("--method is of engines: the reference has none")
    serves = model in quantity.compilable_models
    if asked.backend == HEYOKA and not serves:
        raise UsageError(f"--backend heyoka: {asked.quantity} by {model} takes no steps for it")
    name: Backend = "heyoka" if takes_heyoka(asked.backend) and serves else "numpy"
    return replace(asked, model=model, block=asked.block or quantity.block, backend=name)


def by_engine(asked: Request) -> Request:
    """Return a request of an engine with what was left open."""
    quantity = asked.mapped
    if not quantity.engines:
        raise UsageError(f"{asked.quantity} is of the theory alone: no engine can compute it")
    if asked.backend == HEYOKA:
        raise UsageError("--backend is of the reference: an engine takes its own steps")
    setup = asked.setup()
    block, method = asked.block or quantity.engine_block, setup.integrator.name
    return replace(asked, model=setup.model, method=method, block=block, backend="numpy")


def corners_of(asked: Request) -> Points:
    """Return the first and the last point of a map."""
    return points_of(asked, np.array([[0, 0], [asked.x.count - 1, asked.y.count - 1]]))


def points_of(asked: Request, places: NDArray[np.int_]) -> Points:
    """Return some points of a map, by their columns and rows (k, 2).

    Parameters on the axes come before what sets parameters, so that this can depend on those.
    """
    scene, special = get_scene(asked.scene), axis_names(asked.scene)
    values = {
        asked.x.name: asked.x.values[places[:, 0]],
        asked.y.name: asked.y.values[places[:, 1]],
    }
    parameters = scene.parameters().replace(**(asked.parameters or {}))
    parameters = parameters.replace(**{k: v for k, v in values.items() if k not in special})
    for name in [name for name in values if name in special]:
        parameters = special[name].apply(parameters, values[name])
    method = asked.model or "", asked.method, asked.step, asked.backend
    return Points(scene, parameters, places, values, asked.engine, *method)


def evaluate(asked: Request, places: NDArray[np.int_]) -> QuantityValues:
    """Compute some points of a map, by their columns and rows (k, 2)."""
    return asked.mapped.evaluate(points_of(asked, places))
