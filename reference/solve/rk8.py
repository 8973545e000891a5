"""Equal steps of the 8th-order method of Dormand and Prince, for many points at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import DOP853

from ..cost import watched
from .kernel import Kernel, RightHandSide

STAGES, A, B, C = DOP853.n_stages, DOP853.A, DOP853.B, DOP853.C


def rk8_steps(derivative: Callable[[Any, Any], Any], x: Any, t0: Any, t1: Any, steps: int) -> Any:
    """Advance x from t0 to t1 in equal steps of the 8th-order Dormand-Prince method.

    Works on real or complex arrays of any shape (2 n, ...); ``t0``, ``t1`` broadcast
    against the points, and ``t1`` may be complex too.
    """
    span = np.asarray(t1) - t0
    return FixedSteps(derivative, x, t0, span)(x, t0, span, steps)


def rk8_samples(
    derivative: Callable[[Any, Any], Any], x: Any, start: Any, times: Any, steps: int
) -> Any:
    """Return states (2 n, ..., n_t) at ``times`` (n_t, ...), by equal steps in each interval."""
    samples, before = [], start
    for now in times:
        x = rk8_steps(derivative, x, before, now, steps)
        samples.append(x)
        before = now
    return np.stack(samples, axis=-1)


class FixedSteps:
    """`rk8_steps` for arrays of one shape, as a list of calls on arrays that are made once.

    Parameters
    ----------
    derivative : callable ``(t, x) -> dx/dt``
        Calls of its kernel join the list, if it is a `RightHandSide` that has one.
    x, t0, span : array
        Like those that come.
    """

    def __init__(self, derivative: Callable[[Any, Any], Any], x: Any, t0: Any, span: Any) -> None:
        self.derivative = derivative
        time = np.add(t0, span, dtype=np.result_type(t0, span, float))
        kernel = derivative.kernel(time, x) if isinstance(derivative, RightHandSide) else None
        self.x = np.empty(x.shape, x.dtype)
        self.at = np.empty_like(self.x) if kernel is None else kernel.x
        self.k = np.empty((STAGES, *x.shape), dtype=x.dtype)
        # real and imaginary parts apart: the weights are real, and BLAS is slow at mixed products
        self.flat = self.k.reshape(STAGES, -1).view(float)
        self.time = np.empty_like(time)
        self.h = np.full(np.shape(span), np.nan, np.result_type(span, float))
        self.look = watched(nothing)
        self.calls = [
            (function, arguments)
            for s in range(STAGES)
            for function, arguments in (*self._state(s), *self._rates(s, kernel))
        ]

    def __call__(self, x: Any, t0: Any, span: Any, steps: int) -> Any:
        """Return the states a span after t0."""
        h = np.asarray(span) / steps
        self.x[...] = x
        self.h[...] = h
        for i in range(steps):
            self.time[...] = t0 + i * h
            self.look(self.time, self.x)
            for function, arguments in self.calls:
                function(*arguments)
            self.x += (B @ self.flat).view(x.dtype).reshape(x.shape)
        return self.x.copy()

    def _state(self, s: int) -> list[tuple[Callable[..., Any], tuple[Any, ...]]]:
        """Return the calls for the states of a stage."""
        if not s:
            return [(np.copyto, (self.at, self.x))]
        flat_at = self.at.reshape(-1).view(float)
        return [
            (np.matmul, (A[s, :s], self.flat[:s], flat_at)),
            (np.add, (self.at, self.x, self.at)),
        ]

    def _rates(self, s: int, kernel: Kernel | None) -> list[tuple[Callable[..., Any], Any]]:
        """Return the calls for h dx/dt of a stage."""
        out, n = self.k[s], len(self.x) // 2
        if kernel is None:
            return [(self._call, (s, out))]
        calls: list[tuple[Callable[..., Any], Any]] = []
        if kernel.needs_time:
            calls = [
                (np.multiply, (self.h, C[s], kernel.time)),
                (np.add, (kernel.time, self.time, kernel.time)),
            ]
        calls += [(function, tuple(arrays)) for function, arrays in kernel.calls]
        calls += [(np.multiply, (self.at[n:], self.h, out[:n]))]
        ends = enumerate(kernel.accelerations, n)
        return [*calls, *((np.multiply, (end, self.h, out[row, ...])) for row, end in ends)]

    def _call(self, s: int, out: Any) -> None:
        np.multiply(self.derivative(self.time + C[s] * self.h, self.at), self.h, out=out)


def nothing(t: Any, x: Any) -> None:
    """Stand for a right-hand side where only the budget is looked at."""
