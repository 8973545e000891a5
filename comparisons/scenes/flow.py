"""Many motions at once, by the reference or an engine: what quantities are computed from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...reference.errors import EngineError
from ...reference.scene import Array, Case, EquationsOfMotion, coefficients_at
from ...reference.solve.flow import rk8_steps
from ..engines.registry import REFERENCE
from ..engines.run import run_many
from ..engines.setup import Setup
from ..queries.query import choose_engine, choose_method
from .quantity import Points, QuantityValues


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
            NaN from where a motion was lost.
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
        legs = []
        for begin, end in pairwise([0, *np.unique(steps).tolist()]):
            rows = np.flatnonzero(steps >= end)
            derivative = self.scene.derivative(coefficients_at(c, which[rows]))
            share = spacing[rows] / steps[rows]
            legs.append((rows, derivative, begin * share, (end - begin) * share, end - begin))
        path, states = np.empty((*states.shape, count)), np.array(states, dtype=float)
        with np.errstate(all="ignore"):
            for i in range(count):
                for rows, derivative, begin, length, number in legs:
                    time = start[rows] + i * spacing[rows] + begin
                    states[:, rows] = rk8_steps(
                        derivative, states[:, rows], time, time + length, number
                    )
                path[..., i] = states
        return path

    def _simulated(
        self, which: Any, states: Array, start: Any, spacing: Any, count: int, steps: int
    ) -> Array:
        """Return them by the engine."""
        names = self.points.scene.state_names
        path = np.full((*states.shape, count), np.nan)
        rows = np.flatnonzero(
            np.all(np.isfinite(states), axis=0) & ~np.isin(which, list(self.problems))
        )
        if not rows.size:
            return path
        parameters = {point: self.points.one(point) for point in np.unique(which[rows]).tolist()}
        cases = [
            Case(
                self.points.scene.name,
                "point",
                parameters[which[row]],
                dict(zip(names, states[:, row].tolist(), strict=True)),
                start_time=float(start[row]),
            )
            for row in rows
        ]
        times = start[rows][:, None] + spacing[rows][:, None] * np.arange(1, count + 1)
        runs = run_many(engine_setup(self.points, cases[0]), cases, spacing[rows] / steps, times)
        for row, result in zip(rows, runs, strict=True):
            if isinstance(result, EngineError):
                self.problems[int(which[row])] = str(result)
            else:
                path[:, row] = result.matrix(names)
        return path

    def values(self, values: Mapping[str, Any]) -> QuantityValues:
        """Return what a quantity is at the points: nothing where the engine failed."""
        return QuantityValues.of(values, self.problems)


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
