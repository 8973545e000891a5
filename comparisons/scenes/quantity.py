"""Quantities of maps, their variables and points, and the motions behind them."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...reference.cost import keep_budget, keep_steps
from ...reference.errors import EngineError, UsageError
from ...reference.scene import Array, Case, EquationsOfMotion, Scene, coefficients_at
from ...reference.solve import HEYOKA, takes_heyoka
from ...reference.solve.rk8 import equal_steps
from ..checks.orbits import engine_paths
from ..engines.registry import REFERENCE
from ..engines.setup import Setup
from ..queries.query import choose_engine, choose_method, seconds_of_a_step

NO_VALUE = -1
"""Class of a point without one: the engine failed there."""

STEP_COUNTS = np.array(sorted({m << j for j in range(24) for m in (1, 3)}))
"""Numbers of steps that are taken between two samples."""

LONG_STEP_COUNTS = np.array(sorted({m << j for j in range(24) for m in (4, 5, 6, 7)}))
"""The same over long spans."""


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
    backend : {"numpy", "heyoka"}
        What takes the steps of the reference's `Flow`.
    """

    scene: Scene
    parameters: Any
    places: NDArray[np.int_]
    values: Mapping[str, Array]
    engine: str
    model: str
    method: str | None = None
    step: float | None = None
    backend: str = "numpy"

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.places)

    def one(self, i: int) -> Any:
        """Return the parameters of one point, all of them numbers or words."""
        return self.parameters.at(i)

    def step_counts(
        self, spans: Array, longest: Any, fewest: int = 1, counts: NDArray[np.int_] = STEP_COUNTS
    ) -> NDArray[np.int_]:
        """Return into how many equal steps spans (k,) [s] are divided.

        Parameters
        ----------
        spans : array (k,)
        longest : float or array (k,)
            Longest step [s], where ``step`` is not given.
        fewest : int
        counts : int array
            Numbers to choose from.

        Raises
        ------
        UsageError
            If ``step`` is too short for them.
        """
        shortest = spans / counts[-1]
        if self.step is not None and self.step < np.max(shortest):
            raise UsageError(
                f"steps of {self.step:g} s are more than this map takes from sample to sample; "
                f"{np.max(shortest):.3g} s is the shortest that all of its points can have"
            )
        return enough_steps(np.maximum(spans / (self.step or longest), fewest), counts)


@dataclass(frozen=True)
class QuantityValues:
    """Values of a quantity at some points.

    Attributes
    ----------
    values : mapping of str to array (k,)
        Values of each variable. NaN, or `NO_VALUE` for classes, where there is none.
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
    """A quantity of a scene that can be mapped.

    Attributes
    ----------
    about : str
        One line for ``mbcheck map --help`` and the docs.
    variables : mapping of str to Variable
        The first is drawn and compared. ``robust`` is 1 where the changes that its
        meaning names leave the class unchanged, else 0.
    evaluate : callable ``(Points) -> QuantityValues``
        Runs in a process of its own; what it returns depends on the points alone.
    models : tuple of str
        What ``--model`` may be with the reference: equations or theories, default first.
    engines : bool
        Whether engines can compute it too.
    of_start : bool
        Whether its classes are those of the motion from one start: where several motions are
        stable, no boundary of stability parts them.
    compilable_models : tuple of str
        Those whose motions are `Flow`'s alone, which heyoka's steps serve as well.
    block, engine_block : int
        How many points are computed together: by the reference, which works in batches, and
        by an engine. A block should take 0.1 s to 10 s.
    """

    about: str
    variables: Mapping[str, Variable]
    evaluate: Callable[[Points], QuantityValues]
    models: tuple[str, ...] = ("exact",)
    engines: bool = True
    of_start: bool = False
    compilable_models: tuple[str, ...] = ()
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


@dataclass
class Flow:
    """Motions of the points of a map; call it to advance some of them.

    Attributes
    ----------
    points : Points
    scene : EquationsOfMotion
        Whose equations the reference solves: the points' own, or one of its variants.
    problems : dict of int to str
        Points at which the engine failed, and how; filled by the calls.
    """

    points: Points
    scene: EquationsOfMotion
    problems: dict[int, str] = field(default_factory=dict)

    def __call__(
        self,
        which: NDArray[np.int_],
        states: Array,
        start: Any,
        spacing: Any,
        count: int,
        steps: int | NDArray[np.int_],
    ) -> Array:
        """Return the states of rows at ``start + i spacing``, i = 1 ... count.

        Parameters
        ----------
        which : int array (k,)
            The point that each row belongs to; a point may have several rows.
        states : array (2 n, k)
            At the start.
        start, spacing : float or array (k,)
            Start of each row and time between two of its samples [s].
        count : int
            Number of samples.
        steps : int or array (k,)
            Equal steps between two samples.

        Returns
        -------
        array (2 n, k, count)
            NaN from where a motion was lost. Complex where states or spacing are, of the reference.
        """
        which = np.asarray(which)
        start, spacing, steps = np.broadcast_arrays(start, spacing, steps, which)[:3]
        if self.points.engine == REFERENCE:
            return self._solved(which, states, start, spacing, count, steps)
        path = np.empty((*states.shape, count))
        for number in np.unique(steps).tolist():
            rows = np.flatnonzero(steps == number)
            path[:, rows] = self._simulated(
                which[rows], states[:, rows], start[rows], spacing[rows], count, number
            )
        return path

    def _solved(
        self, which: Any, states: Array, start: Any, spacing: Any, count: int, steps: Any
    ) -> Array:
        """Return them by the 8th-order method.

        All rows take their steps together, while these last: the time goes into calls rather
        than arithmetic.
        """
        c = self.scene.coefficients(self.points.parameters)
        states = np.array(states, dtype=np.result_type(states, spacing, float))
        legs = []
        for begin, end in pairwise([0, *np.unique(steps).tolist()]):
            rows = np.flatnonzero(steps >= end)
            share = spacing[rows] / steps[rows]
            stepper = self._stepper(coefficients_at(c, which[rows]), states[:, rows], share)
            legs.append((rows, stepper, begin * share, share, end - begin))
        path = np.empty((*states.shape, count), dtype=states.dtype)
        with np.errstate(all="ignore"):
            for i in range(count):
                for rows, stepper, begin, h, number in legs:
                    time = start[rows] + i * spacing[rows] + begin
                    states[:, rows] = stepper(states[:, rows], time, h, number)
                path[..., i] = states
        return path

    def _stepper(self, c: Any, states: Array, h: Array) -> Callable[..., Array]:
        """Return `equal_steps` of motions with these coefficients (k,)."""
        heyoka = self.points.backend == HEYOKA and takes_heyoka(HEYOKA)  # a worker may lack it
        if heyoka and np.isrealobj(h):
            from ...reference.solve.compiled import CompiledSteps

            return CompiledSteps(self.scene, c, states)
        return partial(equal_steps, self.scene.derivative(c))

    def _simulated(
        self, which: Any, states: Array, start: Any, spacing: Any, count: int, steps: int
    ) -> Array:
        """Return them by the engine."""
        path = np.full((*states.shape, count), np.nan)
        rows = np.flatnonzero(
            np.all(np.isfinite(states), axis=0) & ~np.isin(which, list(self.problems))
        )
        if not rows.size:
            return path
        one = {point: self.points.one(point) for point in np.unique(which[rows]).tolist()}
        parameters = [one[point] for point in which[rows].tolist()]
        case = Case(self.points.scene.name, "point", parameters[0], start_time=start[rows[0]])
        times = start[rows][:, None] + spacing[rows][:, None] * np.arange(count + 1)
        setup = engine_setup(self.points, case)
        some = setup.with_step(float(spacing[rows[0]]) / steps)
        with suppress(EngineError):  # which the run will tell of the point
            work = rows.size * count * steps / (os.cpu_count() or 1)
            keep_steps(work, lambda: seconds_of_a_step(some))
        path[:, rows], problems = engine_paths(
            setup, parameters, states[:, rows], spacing[rows] / steps, times
        )
        keep_budget(1.0)  # else its end would stand there as a failure of the engine
        self.problems |= {int(which[rows[i]]): words for i, words in problems.items()}
        return path

    def values(self, values: Mapping[str, Any]) -> QuantityValues:
        """Return the values of a quantity at the points: none where the engine failed."""
        return QuantityValues.of(values, self.problems)


def enough_steps(wanted: Array, counts: NDArray[np.int_] = STEP_COUNTS) -> NDArray[np.int_]:
    """Return numbers of steps (k,) no smaller than those wanted: few, so that points share them."""
    places = np.searchsorted(counts, wanted * (1 - 1e-9))
    return counts[np.minimum(places, len(counts) - 1)]


def engine_setup(points: Points, case: Case | None = None) -> Setup:
    """Return the engine's model of a case, of the first point without one, and its method.

    Raises
    ------
    UsageError
        If the engine has no such model or method, or cannot run this case with them.
    """
    case = case or Case(points.scene.name, "point", points.one(0))
    engine, model = choose_engine(points.engine, case, points.model or None)
    return Setup(engine, case, model, choose_method(engine, case, model, points.method))
