"""What tolerances are made of: schemes and halved steps, rounding, and their safety factors."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...reference.equations import ModelEquations
from ...reference.scene import Array
from ..engines.run import EPS
from .verdict import Finding, Inconclusive

SAFETY = 1.2
"""On an error predicted with the engine's own scheme: rounding, and the profile `strict`."""

RICHARDSON_SAFETY = 1.5
"""On an error predicted from two steps: what the next order adds to it."""

CAP = 0.05
"""No predicted error above this share of a quantity's range is granted as tolerance."""

ROUNDING = 1e-10
"""Relative error granted to closed-form algebra; a thousand times what either engine needs."""

UNITS = 256
"""Units of rounding that closed-form algebra of some joints may lose."""

OPERATIONS = 8
"""Times that each term of a force or an inertia is rounded on its way into a sum."""

LEAST = 1e-6
"""No method of order p errs in a step by less than this share of what Taylor's polynomial of degree
p leaves: DOPRI5, the sharpest of all that were tried, errs by 3e-4 of it and more."""

NEXT_ORDERS = 3.0
"""On the error of an extrapolated value: the terms of the next two orders may nearly cancel
in the one halving that it is estimated from."""

CLEAR = 100.0
"""Floors by which a change with the step is told from rounding."""

OPEN = 8.0
"""Where errors do not shrink as declared yet, one of up to so many times what halving the step
changes may still vanish with it: it is called neither right nor wrong."""

ORBIT_REFINEMENTS = 3
"""Times that the steps of orbits are halved until errors shrink with them as the order says."""

ORBIT_STEPS = {1: 512, 2: 64, 3: 64, 4: 48, 5: 40, 6: 32}
"""Steps in the shortest period of an orbit, by order of the method, to begin with."""

VIOLATION = 1e-9
"""Residual of a closed loop that is no drift, in the size of its lengths: what an iteration
that stops at 1e-11 of its increments leaves, with a margin."""


def rows(equations: ModelEquations, states: Array, names: tuple[str, ...]) -> Array:
    """Return observables (k, n_t) of states (2 n, n_t) by model equations; unknown ones are 0."""
    observables = equations.scene.observe(states, equations.parameters)
    values = (observables.get(name, 0.0) for name in names)
    return np.array([np.broadcast_to(value, states.shape[1:]) for value in values])


def rounding(steps: float, growth: float, epsilon: float = EPS) -> float:
    """Relative error that rounding may leave after so many steps, errors growing so much.

    ``epsilon`` is `Setup.epsilon`.
    """
    return 8 * epsilon * (16 + steps) * max(growth, 1.0)


def matrix_rounding(epsilon: float, granted: float) -> float:
    """Relative error granted to an engine's matrices and forces: `granted`, or what rounding may.

    A sum of as many terms as a joint or a body has, each rounded, is off by few units.
    """
    return max(granted, UNITS * epsilon)


def largest_inertias(matrices: Array, alike: NDArray[np.bool_]) -> Array:
    """Return the largest inertia (n,) that enters the sums of each row of mass matrices (k, n, n).

    It is that of the bodies beyond a joint i about the farthest joint j of the same unit (`alike`,
    (n, n)), at least M_ij^2 / M_ii: at the end of a chain a sum is small beside its terms.
    """
    inertia = np.abs(np.diagonal(matrices, axis1=1, axis2=2))[:, :, None]
    about = np.where(alike, matrices**2 / np.where(inertia > 0, inertia, np.inf), 0.0)
    return np.asarray(np.max(about, axis=(0, 2)))


def taylor_remainder(motion: Array, size: Array, order: int) -> float:
    """Return what Taylor's polynomial of this degree leaves of a motion in a step.

    Parameters
    ----------
    motion : array (k, ..., n_t)
        Observables after equal steps, over ``order + 1`` of them or more.
    size : array (k,)
        To which it is related.
    order : int
        Degree p; the remainder is the difference of order p + 1 over (p + 1)!, its median over
        the places where the motion was looked at, since a drive that ends makes one of them large.
    """
    differences = np.abs(np.diff(motion, n=order + 1, axis=-1)) / math.factorial(order + 1)
    shares = (differences.reshape(len(size), -1) / size[:, None]).max(axis=0)
    return float(np.median(shares))


def least_error(
    order: int, step: float, error: float, bound: float, remainder: float
) -> Finding | Inconclusive:
    """Judge whether a step is too good for its order: then it is not the step that was asked for.

    Parameters
    ----------
    order : int
    step : float
        Step [s].
    error, bound : float
        Relative error of the engine, and what its reference leaves open.
    remainder : float
        `taylor_remainder` of the true motion with this step.
    """
    least = LEAST * remainder
    if 0 < least < bound:
        reason = f"a step of {step:.3g} s leaves {least:.2g}, less than the reference knows"
        return Inconclusive("least_error", reason)
    return Finding(
        "least_error",
        "1",
        error,
        least,
        least / (error + bound) if least else 0.0,
        1.0,
        f"a method of order {order} leaves {least:.2g} or more with h = {step:.3g} s; one that "
        "leaves less is too good for its order: it takes other steps, or has another order",
    )


def last_trusted_sample(predicted: Array) -> int:
    """Return up to which sample the predicted relative errors (..., n_t) stay below `CAP`.

    A coarse method is judged as far as its own error leaves something to be seen.
    """
    worst = np.maximum.accumulate(np.max(np.atleast_2d(predicted), axis=0))
    return int(np.searchsorted(worst, CAP / RICHARDSON_SAFETY, side="right"))


def sample_numbers(horizon: float, step: float, count: int = 32) -> NDArray[np.int_]:
    """Return about ``count`` step numbers spread evenly over a horizon.

    With a step that is a power of two, their times are those that references are kept at.
    """
    every = max(1, int(2.0 ** np.round(np.log2(max(1.0, horizon / step / count)))))
    return every * np.arange(1, max(1, int(horizon / step / every * (1 + 1e-12))) + 1)


@dataclass(frozen=True)
class Richardson:
    """What three runs at h, h/2, h/4 say of a quantity.

    Attributes
    ----------
    predicted : float
        Error at h, with `RICHARDSON_SAFETY`.
    limit : array
        Value extrapolated to h -> 0 from the finer two.
    moved : array
        By how much that moved when the step was halved.
    change, ratio : float
        Largest change by halving, mostly that from h to h/2, and how many times larger this one is
        than that from h/2 to h/4.
    order : int
    """

    predicted: float
    limit: Array
    moved: Array
    change: float
    ratio: float
    order: int

    def is_regular(self, floor: float) -> bool:
        """Return whether it converges with its order, and so can be extrapolated."""
        inside = 2 ** (self.order - 0.5) < self.ratio < 2 ** (self.order + 1)
        return self.change < CLEAR * floor or inside

    def shrinks(self, floor: float) -> bool:
        """Return whether the error shrinks as declared, or is down at the floor."""
        return self.ratio > 2 ** (self.order - 0.5) or self.change < 10 * floor


def richardson(values: list[Array], order: int) -> Richardson:
    """Extrapolate a quantity measured at h, h/2 and h/4."""
    coarse, half, quarter = values
    gain = 2**order - 1
    limit, before = quarter + (quarter - half) / gain, half + (half - coarse) / gain
    change = float(np.max(np.abs(coarse - half)))
    finer = float(np.max(np.abs(half - quarter)))
    return Richardson(
        predicted=RICHARDSON_SAFETY
        * max(change * (gain + 1) / gain, float(np.max(np.abs(coarse - limit)))),
        limit=limit,
        moved=np.abs(limit - before),
        change=max(change, finer),
        ratio=change / finer if finer > 0 else np.inf,
        order=order,
    )


def converging(
    finding: Finding, estimate: Richardson, floor: float, shrinks: bool, moving: bool = True
) -> Finding | Inconclusive:
    """Grant what three steps predict of a finding's error, where it shrinks as declared.

    Where it does not, and its order is ``moving`` from one halving to the next, an error that
    halving may still take away tells neither right nor wrong.
    """
    if not shrinks and moving and floor < finding.error < OPEN * estimate.change:
        return Inconclusive(finding.quantity, f"too coarse to tell: {finding.reason}")
    return replace(finding, tolerance=(estimate.predicted if shrinks else 0.0) + floor)
