"""Gauss collocation with adaptive steps, for stiff vibrations.

Explicit methods must follow the fastest mode of a stiff joint or of a discretised continuum,
whether it moves or not. Gauss's collocation methods (Hairer, Wanner, Solving Ordinary
Differential Equations II, section IV.5) are A-stable, damp nothing and have order 2 s; the
stages of a step are computed together, as points of one call. SciPy's implicit methods have
order 5 at most, and interpolate with order 3.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from scipy.integrate import DenseOutput, OdeSolver

from ..differences import by_complex_step


class GaussOptions(NamedTuple):
    """How Newton's method solves for the stages of a step.

    Attributes
    ----------
    max_iterations : int
        Iterations of a step; each gains a factor, for the Jacobian is that of a start.
    jacobian_lifetime : int
        Steps for which a Jacobian serves.
    many_iterations : int
        Iterations of a step after which the next one has a Jacobian of its own.
    tolerance : float
        Change of a state, in what it may be off, below which it is the last one.
    caution : float
        How much more than the last change promised the next one may be.
    """

    max_iterations: int = 15
    jacobian_lifetime: int = 8
    many_iterations: int = 8
    tolerance: float = 0.01
    caution: float = 10.0


OPTIONS = GaussOptions()

STAGES = 10


Rates = Callable[[Any, Any], Any]

POINTS, WEIGHTS = legendre.leggauss(STAGES)
SERIES = (np.arange(STAGES) + 0.5)[:, None] * legendre.legvander(POINTS, STAGES - 1).T * WEIGHTS
"""Matrix from values at the stages to coefficients of Legendre's polynomials."""


def antiderivatives(x: Any) -> Any:
    """Integrals over [0, (x + 1) / 2] of Legendre's polynomials, (..., STAGES)."""
    x = np.asarray(x, dtype=float)
    values = legendre.legvander(x.ravel(), STAGES).reshape(*x.shape, -1)
    degrees = 2 * np.arange(1, STAGES) + 1
    inner = (values[..., 2:] - values[..., :-2]) / degrees
    return np.concatenate([x[..., None] + 1, inner], axis=-1) / 2


A = antiderivatives(POINTS) @ SERIES
"""The tableau."""

LAMBDA, VECTORS = np.linalg.eig(A)
INVERSE = np.linalg.inv(VECTORS)
HALF = np.flatnonzero(LAMBDA.imag > 0)
"""One of each pair of eigenvalues: the others are conjugate, and so are their shares."""


class GaussOutput(DenseOutput):
    """The collocation polynomial of one step."""

    def __init__(self, t_old: float, t: float, y_old: Any, series: Any) -> None:
        super().__init__(t_old, t)
        self.y_old, self.series = y_old, series

    def _call_impl(self, t: Any) -> Any:
        h = self.t - self.t_old
        shares = antiderivatives(2 * (np.asarray(t) - self.t_old) / h - 1)
        moved = h * (self.series @ shares.T)
        return moved + (self.y_old if moved.ndim == 1 else self.y_old[:, None])


class Gauss(OdeSolver):
    """Gauss collocation of `STAGES` stages as one of SciPy's solvers.

    ``fun`` must take states (n, k), coordinates before their rates, complex ones too, and times
    (k,), as `Dynamics.right_hand_side` does. The step follows from the last coefficient of the
    stages' series, an estimate of order `STAGES`, pessimistic where the solution is smooth.
    """

    n_stages = STAGES
    t: float
    y: Any
    h_previous: float

    def __init__(self, fun: Rates, t0: float, y0: Any, t_bound: float, **options: Any) -> None:
        super().__init__(fun, t0, y0, t_bound, options.get("vectorized", False))
        self.many = fun
        self.rtol, self.atol = options["rtol"], options["atol"]
        self.max_step = options.get("max_step", np.inf)
        self.size = options.get("first_step") or abs(t_bound - t0) / 100
        self.series: Any = None
        self.jacobian: Any = None
        self.count = self.iterations = 0

    def rates(self, t: Any, y: Any) -> Any:
        """Evaluate the equations at times (k,) and states (n, k)."""
        self.nfev += y.shape[1]
        return self.many(t, y)

    def next_step(self) -> float:
        """Length [s] of the coming step, with its sign."""
        h = min(self.size, self.max_step, abs(self.t_bound - self.t)) * self.direction
        return float((self.t + h) - self.t)  # the step that the clock takes, too

    def slopes(self) -> Any:
        """Derivatives (2, n / 2, n / 2) of the accelerations, by coordinates and by rates.

        In the middle of the coming step, extrapolated from the last one; exact by complex steps.
        """
        self.njev += 1
        t, y, n = self.t, self.y, self.n // 2
        if self.series is not None:
            t = self.t + self.next_step() / 2
            y = self._dense_output_impl()(t)
        slopes = by_complex_step(lambda x: self.rates(np.full(self.n, t), x), y)[1]
        return slopes[n:, :n], slopes[n:, n:]

    def stages(self, h: float, guess: Any) -> Any:
        """Slopes at the stages (n, s), or None where Newton's method does not settle.

        The rates of coordinates are the other half of the state: each of its linear equations is
        solved for what the rates change, with matrices of half the size.
        """
        n, shares = self.n // 2, h * LAMBDA[HALF, None, None]
        by_place, by_rate = (shares * part for part in self.jacobian)
        factors = np.linalg.inv(np.eye(n) - by_rate - shares * by_place)
        times = self.t + h * (1 + POINTS) / 2
        scale = (self.atol + self.rtol * np.abs(self.y))[:, None]
        slopes, before, last = guess, np.inf, np.inf
        for self.iterations in range(1, OPTIONS.max_iterations + 1):
            rates = self.rates(times, self.y[:, None] + h * slopes @ A.T)
            residual = (INVERSE[HALF] @ (rates - slopes).T)[..., None]
            moved = factors @ (residual[:, n:] + by_place @ residual[:, :n])
            parts = np.concatenate([residual[:, :n] + shares * moved, moved], axis=1)
            change = 2 * (VECTORS[:, HALF] @ parts[..., 0]).real.T
            slopes = slopes + change
            size = np.max(np.abs(h * change) / scale)
            if not np.isfinite(size) or size > 2 * last:
                return None
            if size < OPTIONS.tolerance or (size < 1 and size > last / 2):
                return slopes
            gain = size / last
            if self.iterations > 1 and OPTIONS.caution * size * gain < OPTIONS.tolerance * (
                1 - gain
            ):
                return slopes
            # changes of places and of rates take turns: the gain is that of two iterations
            left = (OPTIONS.max_iterations - self.iterations) / 2
            if self.iterations > 3 and size * (size / before) ** left > 1:
                return None
            before, last = last, size
        return None

    def _step_impl(self) -> tuple[bool, str | None]:
        fresh = self.jacobian is None
        if fresh:
            self.jacobian = self.slopes()
        while True:
            h = self.next_step()
            if abs(h) < 10 * np.spacing(abs(self.t) + abs(self.t_bound)):
                return False, self.TOO_SMALL_STEP
            if self.series is None:
                guess = np.repeat(self.many(self.t, self.y)[:, None], STAGES, axis=1)
            else:
                x = 1 + (1 + POINTS) * h / self.h_previous
                guess = self.series @ legendre.legvander(x, STAGES - 1).T
            slopes = self.stages(h, guess)
            if slopes is None:
                if fresh:
                    self.size = abs(h) / 3
                    self.series = None
                self.jacobian, fresh = self.slopes(), True
                continue
            series = slopes @ SERIES.T
            y = self.y + h * series[:, 0]
            scale = self.atol + self.rtol * np.maximum(np.abs(self.y), np.abs(y))
            tail = np.abs(series[:, -1]) + np.abs(series[:, -2]) / STAGES
            error = np.max(np.abs(h) * tail / STAGES / scale)
            self.size = abs(h) * float(np.clip(0.9 * (error + 1e-300) ** (-1 / STAGES), 0.2, 3.0))
            if error <= 1:
                break
        self.series, self.h_previous, self.y_previous = series, h, self.y
        self.y = y
        at_end = abs(self.t + h - self.t_bound) <= 4 * np.spacing(abs(self.t_bound))
        self.t = self.t_bound if at_end else self.t + h
        self.count += 1
        if (
            self.count % OPTIONS.jacobian_lifetime == 0
            or self.iterations >= OPTIONS.many_iterations
        ):
            self.jacobian = None
        return True, None

    def _dense_output_impl(self) -> GaussOutput:
        return GaussOutput(self.t_old, self.t, self.y_previous, self.series)
