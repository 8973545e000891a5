"""The periodic orbits of an engine, as curves over two parameters.

An engine is a stepper: its map is that of a fixed number of steps in a period. Newton's method
takes slopes from the reference's equations, which secants mend, so that a point costs an engine the
runs of one difference for each iteration.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...reference.continuation.bifurcations import half_period_signs
from ...reference.continuation.curve import correct
from ...reference.continuation.points import CurvePoint
from ...reference.continuation.tracing import Stepper, Tracer
from ...reference.scene import Array
from ..checks.orbits import ORDER, PERTURBATION, engine_paths
from ..engines.setup import Setup

NEAR = 0.2
"""How far in the window, and in the sizes of the states, a curve may have shifted."""


@dataclass
class EngineFlow:
    """An engine's flow over parts of a period, from t = 0.

    Attributes
    ----------
    setup : Setup
        Its case and its step are not used.
    steps : int
        Steps in a part: half a period of a symmetric scene, or else a period.
    problems : list of str
        Why runs have failed.
    """

    setup: Setup
    steps: int
    problems: list[str] = field(default_factory=list)

    def __call__(self, at: Any, states: Array, spans: Array, parts: int) -> Array:
        """Return states (2 n, k) that spans (k,) [s] of so many parts later."""
        p, _, rows = at
        here = [p.at(int(row)) for row in rows]
        ends = np.asarray(spans, dtype=float)
        times = np.stack([np.zeros_like(ends), ends], axis=1)
        paths, problems = engine_paths(self.setup, here, states, ends / (parts * self.steps), times)
        self.problems += problems.values()
        return paths[..., 0]


def engine_tracer(reference: Tracer, setup: Setup, per_period: int) -> tuple[Tracer, EngineFlow]:
    """Return what follows an engine's orbits, with so many steps in a period, and its flow."""
    halves = 1 if half_period_signs(reference.scene) is None else 2
    flow = EngineFlow(setup, per_period // halves)
    stepper = Stepper(flow, ORDER, PERTURBATION)
    return Tracer(reference.scene, reference.parameters, stepper, reference.steps), flow


def shift(reference: Tracer, kind: str, parts: int, point: CurvePoint) -> tuple[float, float]:
    """Return by how far an engine's curve lies from the reference's at a point.

    In the window's unit: along the first parameter at the same second one, and along the second;
    NaN where the reference has no such bifurcation near.
    """
    curve, shifts = reference.curve(kind, parts), []
    for axis in (1, 0):
        row = np.eye(len(point.z))[-2 + axis]
        solution = correct(curve.equations, point.z, row, point.place[axis])
        reference.solutions += 1
        near = solution is not None and np.max(np.abs(solution.z - point.z)) < NEAR
        shifts.append(float((point.z - solution.z)[-1 - axis]) if near else np.nan)  # type: ignore[union-attr]
    return shifts[0], shifts[1]
