"""Equal steps of the 8th-order method of Dormand and Prince, for many points at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import DOP853


def rk8_steps(derivative: Callable[[Any, Any], Any], x: Any, t0: Any, t1: Any, steps: int) -> Any:
    """Advance x from t0 to t1 in equal steps of the 8th-order Dormand-Prince method.

    Works on real or complex arrays of any shape (2 n, ...); ``t0``, ``t1`` broadcast
    against the points, and ``t1`` may be complex too.
    """
    stages = DOP853.n_stages
    A, B, C = DOP853.A, DOP853.B, DOP853.C
    h = (np.asarray(t1) - t0) / steps
    k = np.empty((stages, *x.shape), dtype=x.dtype)
    at = np.empty_like(k[0])
    # real and imaginary parts apart: the weights are real, and BLAS is slow at mixed products
    flat, flat_at = k.reshape(stages, -1).view(float), at.reshape(-1).view(float)
    before = [(A[s, :s], flat[:s], C[s] * h) for s in range(1, stages)]
    for i in range(steps):
        t = t0 + i * h
        np.multiply(derivative(t, x), h, out=k[0])
        for s, (weights, parts, later) in enumerate(before, 1):
            np.matmul(weights, parts, out=flat_at)
            np.add(at, x, out=at)
            np.multiply(derivative(t + later, at), h, out=k[s])
        x = x + (B @ flat).view(x.dtype).reshape(x.shape)
    return x
