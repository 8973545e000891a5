"""Many motions at once, by the reference or an engine: what quantities are computed from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...reference.errors import EngineError
from ...reference.scene import Array, Case, EquationsOfMotion
from ...reference.solve.flow import rk8_steps
from ..engines.adapter import Adapter
from ..engines.protocol import Method
from ..engines.registry import REFERENCE
from ..engines.run import run_many
from ..engines.setup import Setup
from ..queries.query import choose_engine, choose_method
from .quantity import Points


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
            Equal steps between two samples; rows with as many are advanced together.

        Returns
        -------
        array (2 n, k, count)
            NaN from where a motion was lost.
        """
        which = np.asarray(which)
        start, spacing = (
            np.broadcast_to(np.asarray(v, float), which.shape) for v in (start, spacing)
        )
        steps = np.broadcast_to(steps, which.shape)
        advance = self._solved if self.points.engine == REFERENCE else self._simulated
        numbers = np.unique(steps).tolist()
        if len(numbers) == 1:
            return advance(which, states, start, spacing, count, numbers[0])
        found = np.empty((*states.shape, count))
        for number in numbers:
            rows = np.flatnonzero(steps == number)
            found[:, rows] = advance(
                which[rows], states[:, rows], start[rows], spacing[rows], count, number
            )
        return found

    def _solved(
        self, which: Any, states: Array, start: Array, spacing: Array, count: int, steps: int
    ) -> Array:
        """Return them by the 8th-order method, all rows at once."""
        c = self.scene.coefficients(self.points.parameters)
        own = type(c)(*(v[which] if np.ndim(v) else v for v in c))
        derivative = self.scene.derivative(own)
        found = np.empty((*states.shape, count))
        with np.errstate(all="ignore"):
            for i in range(count):
                begin = start + i * spacing
                states = rk8_steps(derivative, states, begin, start + (i + 1) * spacing, steps)
                found[..., i] = states
        return found

    def _simulated(
        self, which: Any, states: Array, start: Array, spacing: Array, count: int, steps: int
    ) -> Array:
        """Return them by the engine."""
        names = self.points.scene.state_names
        found = np.full((*states.shape, count), np.nan)
        rows = [
            row
            for row, point in enumerate(which)
            if point not in self.problems and np.all(np.isfinite(states[:, row]))
        ]
        if not rows:
            return found
        parameters = {point: self.points.one(point) for point in np.unique(which[rows]).tolist()}
        cases = [
            Case(
                self.points.scene.name,
                "point",
                parameters[which[row]],
                dict(zip(names, map(float, states[:, row]), strict=True)),
                start_time=float(start[row]),
            )
            for row in rows
        ]
        engine, model, method = chosen(self.points, cases[0])
        lengths = spacing[rows] / steps
        times = start[rows][:, None] + spacing[rows][:, None] * np.arange(1, count + 1)
        for row, result in zip(
            rows,
            run_many(Setup(engine, cases[0], model, method), cases, lengths, times),
            strict=True,
        ):
            if isinstance(result, EngineError):
                self.problems[int(which[row])] = str(result)
            else:
                found[:, row] = result.matrix(names)
        return found


def chosen(points: Points, case: Case) -> tuple[Adapter, str, Method]:
    """Return the engine, model and method of a map's points.

    Raises
    ------
    UsageError
        If the engine has no such model or method, or cannot run this case with them.
    """
    engine, model = choose_engine(points.engine, case, points.model or None)
    return engine, model, choose_method(engine, case, model, points.method)
