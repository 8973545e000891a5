"""Equal steps of the 8th-order method of Dormand and Prince, for many points at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import DOP853

from ..cost import watched
from .kernel import Kernel, RightHandSide, sines

STAGES, A, B, C = DOP853.n_stages, DOP853.A, DOP853.B, DOP853.C


def rk8_steps(derivative: Callable[[Any, Any], Any], x: Any, t0: Any, t1: Any, steps: int) -> Any:
    """Advance x from t0 to t1 in equal steps of the 8th-order Dormand-Prince method.

    Works on real or complex arrays of any shape (2 n, ...); ``t0``, ``t1`` broadcast
    against the points, and ``t1`` may be complex too.
    """
    span = np.asarray(t1) - t0
    return FixedSteps(derivative, x, t0, span)(x, t0, span, steps)


class FixedSteps:
    """`rk8_steps` for arrays of one shape, as a list of calls on arrays that are made once.

    Sines and cosines of the drive within a step follow from those at its begin, by the angles
    between, which stay the same from step to step.

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
        self.waves = [] if kernel is None else [Turns(*w, self.h) for w in kernel.waves]
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
        if not np.array_equal(h, self.h):
            self.h[...] = h
            for wave in self.waves:
                wave.turn(h)
        for i in range(steps):
            self.time[...] = t0 + i * h
            self.look(self.time, self.x)
            for wave in self.waves:
                wave.begin(self.time)
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
        calls = [call for wave in self.waves for call in wave.calls(s)]
        if kernel.needs_time:
            calls += [
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


class Turns:
    """Sine and cosine of a frequency times the time, at the stages of steps.

    Parameters
    ----------
    frequency : array
    sine, cosine : array
        Where they are written, those of them that a kernel reads.
    h : array
        Like the steps that come.
    """

    def __init__(self, frequency: Any, sine: Any, cosine: Any, h: Any) -> None:
        self.frequency, self.sine, self.cosine = frequency, sine, cosine
        like = sine if cosine is None else cosine
        self.at_sine, self.at_cosine, self.product = (np.empty_like(like) for _ in range(3))
        self.turns = np.empty((2, STAGES, *np.shape(frequency * h)), like.dtype)

    def turn(self, h: Any) -> None:
        """Take steps of h from now on."""
        angles = np.multiply.outer(C[:STAGES], self.frequency * h)
        sines(angles.astype(self.turns.dtype), *self.turns)

    def begin(self, t: Any) -> None:
        """Begin a step at t."""
        sines(np.asarray(self.frequency * t), self.at_sine, self.at_cosine)

    def calls(self, s: int) -> list[tuple[Callable[..., Any], tuple[Any, ...]]]:
        """Return the calls for a stage."""
        sin, cos = self.turns[0, s, ...], self.turns[1, s, ...]  # `...`: never a copy
        calls: list[tuple[Callable[..., Any], tuple[Any, ...]]] = []
        for out, first, second, join in (
            (self.sine, self.at_sine, self.at_cosine, np.add),
            (self.cosine, self.at_cosine, self.at_sine, np.subtract),
        ):
            if out is not None:
                calls += [
                    (np.multiply, (first, cos, out)),
                    (np.multiply, (second, sin, self.product)),
                    (join, (out, self.product, out)),
                ]
        return calls
