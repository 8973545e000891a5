"""How many parts, and how short a step, meet a target."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ...reference.errors import MbcheckError
from ...reference.scene import Array
from ..engines.run import Trajectory
from .series import Cost

REPEATS = 3
"""Runs of which the wall time is the median."""

MOST_LEVELS = 10
"""Times that a step is halved to meet a target."""


@dataclass(frozen=True, kw_only=True)
class Requirement:
    """What it takes to meet a target.

    Attributes
    ----------
    target : float
    stable_step : float or None
        Longest that theory grants [s]; None where there is no limit.
    step : float or None
        Longest power of two [s] with which a run meets the target.
    cost : Cost or None
        Of that run.
    reason : str
    """

    target: float
    stable_step: float | None = None
    step: float | None = None
    cost: Cost | None = None
    reason: str = ""


@dataclass
class Convergence:
    """A quantity by the number of parts, measured once for each.

    Attributes
    ----------
    measure : callable ``(n) -> array``
    truth : array
    size : float
    order : int
        Declared; 0 where none is.
    known : dict of int to array
    """

    measure: Callable[[int], Array]
    truth: Array
    size: float
    order: int
    known: dict[int, Array] = field(default_factory=dict)

    def values(self, count: int) -> Array:
        """Return the quantity with so many parts."""
        if count not in self.known:
            self.known[count] = self.measure(count)
        return self.known[count]

    def error_of(self, values: Array) -> float:
        """Return the error of values."""
        return float(np.max(np.abs(values - self.truth))) / self.size

    def error(self, count: int) -> float:
        """Return the error with so many parts."""
        return self.error_of(self.values(count))

    def limit(self, counts: Sequence[int]) -> tuple[float, float]:
        """Return the error extrapolated from the last counts, and how far it moved."""
        limits = []
        for a, b in pairwise(counts):
            gain = (b / a) ** self.order - 1
            change = self.values(b) - self.values(a)
            limits.append(self.values(b) + (change / gain if gain else 0.0))
        before = limits[-2] if len(limits) > 1 else self.values(counts[-1])
        doubt = float(np.max(np.abs(limits[-1] - before))) / self.size
        return self.error_of(limits[-1]), doubt


def counts_to_target(convergence: Convergence, counts: Sequence[int], target: float) -> list[int]:
    """Return the counts up to where two in a row meet the target; one may do so by chance."""
    for last in range(2, len(counts)):
        if all(convergence.error(n) <= target for n in counts[last - 2 : last]):
            return list(counts[:last])
    return list(counts)


def fewest(
    convergence: Convergence, tried: Sequence[int], target: float
) -> tuple[int | None, bool]:
    """Return the fewest parts that meet a target, and whether they are extrapolated.

    Beyond the count all that were tried meet it too: an error that passes through zero on its
    way to another limit does not count.
    """
    limit, doubt = convergence.limit(tried)
    errors = [convergence.error(n) for n in tried]
    if limit - doubt > target:
        return None, False
    if errors[-1] > target:
        if not convergence.order or limit > target / 2:
            return None, False
        certain = max(0.0, limit - doubt)
        factor = (errors[-1] - certain) / (target - certain)
        return int(np.ceil(tried[-1] * factor ** (1 / convergence.order))), True
    missed = [i for i, error in enumerate(errors) if error > target]
    if not missed:
        return tried[0], False
    low, high = tried[missed[-1]], tried[missed[-1] + 1]
    while high - low > 1:
        middle = between(convergence, low, high, target)
        low, high = (low, middle) if convergence.error(middle) <= target else (middle, high)
    return high, False


def between(convergence: Convergence, low: int, high: int, target: float) -> int:
    """Return a count between two: where a power law through both errors meets the target.

    Half of the way is the least that is gained where it lies beside one of them.
    """
    if high - low >= 32:
        return (low + high) // 2
    errors = np.log([convergence.error(low), convergence.error(high)])
    share = (errors[0] - np.log(target)) / max(errors[0] - errors[1], 1e-12)
    guess = round(float(np.exp(np.log(low) + share * np.log(high / low))))
    return int(np.clip(guess, low + 1, high - 1))


def longest_step_that_meets(
    simulate: Callable[[float], Trajectory],
    error: Callable[[Trajectory], float],
    longest: float,
    target: float,
) -> tuple[float | None, list[Trajectory]]:
    """Return the longest step that meets a target, a power of two times smaller, and its runs."""
    for level in range(MOST_LEVELS):
        step = longest / 2**level
        try:
            first = simulate(step)
        except MbcheckError:
            continue
        if error(first) <= target:
            return step, [first, *(simulate(step) for _ in range(REPEATS - 1))]
    return None, []


def no_step(longest: float) -> str:
    """Say that `longest_step_that_meets` found none."""
    return f"no step from {longest:.2g} s down to {longest / 2 ** (MOST_LEVELS - 1):.2g} s meets it"
