"""What a map can show: quantities, the variables they are made of, and the points they are of."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...reference.scene import Array, Scene

NO_VALUE = -1
"""What stands for the class of a point that has none: the engine failed there."""


@dataclass(frozen=True)
class Variable:
    """One array of a map.

    Attributes
    ----------
    unit : str
        "1" for numbers without one, and for classes.
    meaning : str
    classes : tuple of str
        Where the variable is a class: its names. Values are then places in this tuple, or
        `NO_VALUE`.
    """

    unit: str
    meaning: str
    classes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Points:
    """Points of a map that are computed together.

    Attributes
    ----------
    scene : Scene
    parameters : Parameters of the scene
        Those on the axes are arrays (k,).
    places : int array (k, 2)
        Column and row of each point on the map's grid: neighbours differ by few.
    values : mapping of str to array (k,)
        What stands on the axes, by name.
    engine, model : str
    method : str or None
        None: the engine's method of highest order.
    step : float or None
        Longest step [s] wanted, None: what suits the method.
    """

    scene: Scene
    parameters: Any
    places: NDArray[np.int_]
    values: Mapping[str, Array]
    engine: str
    model: str
    method: str | None = None
    step: float | None = None

    def __len__(self) -> int:
        """Return how many points there are."""
        return len(self.places)

    def one(self, i: int) -> Any:
        """Return the parameters of one point, all of them numbers or words."""
        return self.parameters.replace(
            **{
                item.name: float(value[i])
                for item in fields(self.parameters)
                if np.ndim(value := getattr(self.parameters, item.name)) == 1
            }
        )


@dataclass(frozen=True)
class QuantityValues:
    """What a quantity is at some points.

    Attributes
    ----------
    values : mapping of str to array (k,)
        By variable. NaN, or `NO_VALUE` for classes, where there is none.
    problems : mapping of int to str
        Which points an engine failed at, and how.
    """

    values: Mapping[str, Any]
    problems: Mapping[int, str] = field(default_factory=dict)

    @classmethod
    def of(cls, values: Mapping[str, Any], problems: Mapping[int, str]) -> QuantityValues:
        """Return values, but none where an engine failed; whole numbers are classes.

        There nothing is robust.
        """
        arrays = {name: np.array(column) for name, column in values.items()}
        for name, column in arrays.items():
            none = 0 if name == "robust" else NO_VALUE if column.dtype.kind == "i" else np.nan
            column[list(problems)] = none
        return cls(arrays, problems)


@dataclass(frozen=True)
class Quantity:
    """What a map can show of a scene.

    Attributes
    ----------
    about : str
        One line for ``mbcheck map --help`` and the docs.
    variables : mapping of str to Variable
        The first is what is drawn and compared. One named ``robust`` (0 or 1) tells where a
        perturbation and a halved step leave the class as it is.
    evaluate : callable ``(Points) -> QuantityValues``
        Runs in a process of its own; what it returns depends on the points alone.
    models : tuple of str
        What ``--model`` may be with the reference: equations or theories, default first.
    engines : bool
        Whether engines can compute it too.
    block, engine_block : int
        How many points are computed together: by the reference, which works in batches, and
        by an engine. A block should take 0.1 s to 10 s.
    """

    about: str
    variables: Mapping[str, Variable]
    evaluate: Callable[[Points], QuantityValues]
    models: tuple[str, ...] = ("exact",)
    engines: bool = True
    block: int = 256
    engine_block: int = 16


@dataclass(frozen=True)
class AxisName:
    """Something that may stand on an axis and is no parameter, but sets some.

    Attributes
    ----------
    unit : str
    meaning : str
    apply : callable ``(parameters, values) -> parameters``
    """

    unit: str
    meaning: str
    apply: Callable[[Any, Array], Any]
