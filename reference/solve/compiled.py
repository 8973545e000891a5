"""The steps of `rk8`, compiled by heyoka (optional extra ``fast``).

Each step is one function, with all its stages, made from the same equations: the method and its
number of steps are those of `rk8`, and results differ from its own by rounding alone.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import heyoka as hy
import numpy as np

from ..cost import watched
from ..scene import Dynamics
from .rk8 import STAGES, A, B, C

CHUNK = 1024
"""Points that take all their steps together; about what the cache holds."""


@cache
def step_function(dynamics: Dynamics, kind: Any, has_tangents: bool) -> Any:
    """Compile a step, from states (2 n), or from states and a tangent of each (4 n).

    Its parameters are the coefficients, then h.
    """
    symbols = hy.make_vars(*dynamics.state_names)
    n, number = len(dynamics.coordinates), len(kind._fields)
    c, h = kind(*(hy.par[i] for i in range(number))), hy.par[number]
    time = hy.make_vars("stage_time")
    u = dynamics.drive(time, c, hy) if dynamics.drive else 0.0
    rates = [*symbols[n:], *dynamics.accelerations(u, symbols[:n], symbols[n:], c, hy)]
    if has_tangents:
        tangents = hy.make_vars(*(f"tangent_{name}" for name in dynamics.state_names))
        slopes = hy.diff_tensors(rates, diff_args=symbols, diff_order=1).jacobian
        rates += [
            hy.sum([slope * tangent for slope, tangent in zip(row, tangents, strict=True)])
            for row in slopes
        ]
        symbols = [*symbols, *tangents]
    stages: list[list[Any]] = []
    for s in range(STAGES):
        at = [x + h * weighted(A[s], stages, i) for i, x in enumerate(symbols)] if s else symbols
        here = dict(zip(symbols, at, strict=True)) | {time: hy.time + C[s] * h}
        stages.append(hy.subs(rates, here))
    ends = [x + h * weighted(B, stages, i) for i, x in enumerate(symbols)]
    return hy.cfunc(ends, symbols)


def weighted(weights: Any, stages: list[list[Any]], row: int) -> Any:
    """Return the sum of a row of stages with weights."""
    terms = zip(weights, stages, strict=False)
    return hy.sum([weight * stage[row] for weight, stage in terms if weight])


class CompiledSteps:
    """Equal steps of `rk8.equal_steps`, for states (2 n, k).

    Complex states stand for complex steps, see `differences`: their imaginary parts are tangents.

    Parameters
    ----------
    dynamics : Dynamics
    c : NamedTuple of numbers or arrays (k,)
    x : array (2 n, k)
        Like those that come.
    """

    def __init__(self, dynamics: Dynamics, c: Any, x: Any) -> None:
        self.has_tangents = np.iscomplexobj(x)
        kind: Any = type(c)
        self.step = step_function(dynamics, kind, self.has_tangents)
        self.pars = np.empty((len(c) + 1, x.shape[1]))
        for row, value in enumerate(c):
            self.pars[row] = value
        self.look = watched(lambda t, x: None)

    def __call__(self, x: Any, t0: Any, h: Any, steps: int) -> Any:
        """Return the states after some steps of length h [s] from t0."""
        count = x.shape[1]
        rows = np.concatenate([x.real, x.imag]) if self.has_tangents else x
        self.pars[-1] = h = np.broadcast_to(h, count)
        start, ends = np.broadcast_to(t0, count), np.empty((len(rows), count))
        for begin in range(0, count, CHUNK):
            part = np.s_[begin : begin + CHUNK]
            now = np.array(rows[:, part], order="C")
            pars, after = np.ascontiguousarray(self.pars[:, part]), np.empty_like(now)
            for i in range(steps):
                time = start[part] + i * h[part]
                self.look(time, now)
                self.step(now, pars=pars, time=time, outputs=after)
                now, after = after, now
            ends[:, part] = now
        return ends[: len(x)] + 1j * ends[len(x) :] if self.has_tangents else ends
