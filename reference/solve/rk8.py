"""Equal steps of the 8th-order method of Dormand and Prince, for many points at once.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section II.5.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import DOP853

STAGES, A, B, C = DOP853.n_stages, DOP853.A, DOP853.B, DOP853.C


def equal_steps(derivative: Callable[[Any, Any], Any], x: Any, t0: Any, h: Any, steps: int) -> Any:
    """Return the states after some steps of length h [s] from t0.

    Parameters
    ----------
    derivative : callable ``(t, x) -> dx/dt``
    x : real or complex array (2 n, ...)
    t0, h : float or array (...)
        Start and length of a step of each point [s]; complex with x only.
    steps : int
    """
    h, x = np.asarray(h), np.array(x)
    k = np.empty((STAGES, *x.shape), dtype=x.dtype)
    # real and imaginary parts apart: the weights are real, and BLAS is slow at mixed products
    flat = k.reshape(STAGES, -1).view(float)
    for i in range(steps):
        t = t0 + i * h
        for s in range(STAGES):
            at = x + (A[s, :s] @ flat[:s]).view(x.dtype).reshape(x.shape) if s else x
            np.multiply(derivative(t + C[s] * h, at), h, out=k[s])
        x = x + (B @ flat).view(x.dtype).reshape(x.shape)
    return x


def rk8_steps(derivative: Callable[[Any, Any], Any], x: Any, t0: Any, t1: Any, steps: int) -> Any:
    """Return the states (2 n, ...) at t1 [s] after equal steps from t0; see `equal_steps`."""
    return equal_steps(derivative, x, t0, (np.asarray(t1) - t0) / steps, steps)


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
