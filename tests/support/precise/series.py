"""Initial-value problems by power series in time, with numbers of any precision.

The solution's Taylor coefficients follow one from another by the rules for products, quotients,
roots and circular functions of power series; a step is a share of the radius of convergence.
Neither equations, numbers nor method have anything in common with the reference.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import mul
from typing import Any, Protocol

import gmpy2

from mbcheck.tests.support.precise.program import Program, evaluate

Numbers = list[Any]


class System(Protocol):
    """What can be integrated: second-order equations for n coordinates."""

    def expand(self, time: Any, state: Numbers, order: int) -> list[Numbers]:
        """Return the Taylor coefficients (n, order + 1) of the coordinates about a time."""

    def to_float(self) -> None:
        """Compute with doubles from now on."""


def convolution(a: Numbers, b: Numbers) -> Any:
    """Return coefficient k of a product, from the k + 1 first of both factors."""
    return sum(map(mul, a, b[::-1]))


class Expansion:
    """The power series of all results of a program, one more coefficient at a time."""

    def __init__(self, program: Program, values: Mapping[str, Any]) -> None:
        self.operations = program.operations
        self.series: list[Numbers] = []
        self.slopes: list[Numbers] = []  # k times coefficient k, of arguments of sine and cosine
        self.factors = [
            [evaluate(factor, values) for factor in operation.factors]
            for operation in program.operations
        ]

    def to_float(self) -> None:
        """Compute with doubles from now on."""
        self.factors = [[float(factor) for factor in row] for row in self.factors]

    def restart(self) -> None:
        """Forget all coefficients."""
        self.series = [[] for _ in self.operations]
        self.slopes = [[] for _ in self.operations]

    def extend(self, k: int) -> None:
        """Append coefficient k of every result; those of the inputs must be there."""
        for at, (kind, inputs, _) in enumerate(self.operations):
            if kind != "input":
                self.series[at].append(getattr(self, f"_{kind}")(k, at, *inputs))

    def _sum(self, k: int, at: int, *inputs: int) -> Any:
        factors = self.factors[at]
        value = factors[-1] if k == 0 else factors[-1] * 0
        for place, factor in zip(inputs, factors, strict=False):
            value += factor * self.series[place][k]
        return value

    def _product(self, k: int, at: int, left: int, right: int) -> Any:
        return convolution(self.series[left][: k + 1], self.series[right][: k + 1])

    def _square(self, k: int, at: int, base: int) -> Any:
        a, half = self.series[base], (k + 1) // 2
        value = 2 * sum(map(mul, a[:half], a[k : k - half : -1] if half else []))
        return value + a[k // 2] * a[k // 2] if k % 2 == 0 else value

    def _sine(self, k: int, at: int, angle: int, cosine: int) -> Any:
        if k == 0:
            self.slopes[at] = []
            return self._function(gmpy2.sin, math.sin, angle)
        self.slopes[at].append(k * self.series[angle][k])
        return convolution(self.slopes[at], self.series[cosine]) / k

    def _cosine(self, k: int, at: int, angle: int, sine: int) -> Any:
        if k == 0:
            return self._function(gmpy2.cos, math.cos, angle)
        return -convolution(self.slopes[sine], self.series[sine][:k]) / k

    def _function(self, precise: Any, plain: Any, angle: int) -> Any:
        value = self.series[angle][0]
        return plain(value) if isinstance(value, float) else precise(value)

    def _root(self, k: int, at: int, base: int) -> Any:
        if k == 0:
            return self._function(gmpy2.sqrt, math.sqrt, base)
        root = self.series[at]
        inner = convolution(root[1:], root[1:])
        return (self.series[base][k] - inner) / (2 * root[0])

    def _reciprocal(self, k: int, at: int, base: int) -> Any:
        divisor, quotient = self.series[base], self.series[at]
        if k == 0:
            return 1 / divisor[0]
        return -convolution(quotient, divisor[1 : k + 1]) * quotient[0]


class Lagrangian:
    """``M(q) a = f(t, q, v)`` as a `System`.

    Attributes
    ----------
    size : int
        Number n of coordinates.
    expansion : Expansion
        Of a program with the inputs t, q, v and the results M, row by row, then f.
    """

    def __init__(self, size: int, program: Program, values: Mapping[str, Any]) -> None:
        self.size = size
        self.results = program.results
        self.expansion = Expansion(program, values)

    def to_float(self) -> None:
        """Compute with doubles from now on."""
        self.expansion.to_float()

    def expand(self, time: Any, state: Numbers, order: int) -> list[Numbers]:
        """Return the Taylor coefficients (n, order + 1) of the coordinates about a time."""
        n, expansion = self.size, self.expansion
        expansion.restart()
        series = expansion.series
        zero = state[0] * 0
        for at, value in enumerate((time, *state)):
            series[at].append(value)
        mass = self.results[: n * n]
        entries = [(i // n, i % n, place) for i, place in enumerate(mass)]
        inverse: list[Numbers] = []
        for k in range(order):
            expansion.extend(k)
            if k == 0:
                inverse = inverse_matrix(
                    [[series[mass[i * n + j]][0] for j in range(n)] for i in range(n)]
                )
                rates: list[Numbers] = [[] for _ in range(n)]
            right = [series[place][k] for place in self.results[n * n :]]
            for i, j, place in entries if k else []:
                if expansion.operations[place].inputs:
                    right[i] -= convolution(rates[j], series[place][1 : k + 1])
            for i in range(n):
                rates[i].append(sum(map(mul, inverse[i], right)))
            series[0].append(zero + 1 if k == 0 else zero)
            for i in range(n):
                series[1 + i].append(series[1 + n + i][k] / (k + 1))
            for i in range(n):
                series[1 + n + i].append(rates[i][k] / (k + 1))
        return [list(series[1 + i]) for i in range(n)]


def inverse_matrix(matrix: list[Numbers]) -> list[Numbers]:
    """Return the inverse, by elimination with pivots."""
    n = len(matrix)
    zero = matrix[0][0] * 0
    rows = [[*row, *(zero + (i == j) for j in range(n))] for i, row in enumerate(matrix)]
    for column in range(n):
        pivot = max(range(column, n), key=lambda i: abs(rows[i][column]))
        rows[column], rows[pivot] = rows[pivot], rows[column]
        head = [value / rows[column][column] for value in rows[column]]
        rows[column] = head
        for i in range(n):
            if i != column and rows[i][column] != 0:
                factor = rows[i][column]
                rows[i] = [a - factor * b for a, b in zip(rows[i], head, strict=True)]
    return [row[n:] for row in rows]


@dataclass(frozen=True)
class Accuracy:
    """Precision of numbers and steps.

    Attributes
    ----------
    bits : int
        What the terms left out are smaller by than the largest, as a power of two.
    order : int
        Of the Taylor polynomials; 0 for the one that costs least.
    """

    bits: int = 96
    order: int = 0

    @property
    def degree(self) -> int:
        """Order of the Taylor polynomials."""
        return self.order or max(8, round(0.35 * self.bits) + 2)

    @property
    def working(self) -> int:
        """Bits of the numbers."""
        return self.bits + 24


class StepLimitError(Exception):
    """The trajectory takes too many steps.

    Attributes
    ----------
    reached : float
        Time [s] until which it was followed.
    """

    def __init__(self, message: str, reached: float) -> None:
        super().__init__(message)
        self.reached = reached


def step_size(coefficients: list[Numbers], bits: int, longest: Any) -> Any:
    """Return the largest step, at most `longest`, whose last two terms are small."""
    if longest == 0:
        return longest
    step = longest
    order = len(coefficients[0]) - 1
    for series in coefficients:
        logs = [log2(value) for value in series]
        last = max(logs[-1], logs[-2])
        if last == -math.inf:
            continue
        h = log2(step)
        while True:
            largest = max(value + k * h for k, value in enumerate(logs))
            excess = max(logs[-1] + order * h, logs[-2] + (order - 1) * h) - (largest - bits)
            if excess <= 0:
                break
            h -= max(excess / order, 0.02)
        step = min(step, longest * 0 + 2.0**h) if h > -900 else step * 0 + gmpy2.exp2(h)
    return step


def log2(value: Any) -> float:
    """Return the logarithm of a size."""
    if value == 0:
        return -math.inf
    if isinstance(value, float):
        return math.log2(abs(value))
    mantissa, exponent = gmpy2.frexp(value)[::-1]
    return math.log2(abs(float(mantissa))) + exponent


def horner(series: Numbers, step: Any) -> tuple[Any, Any]:
    """Return the value of a polynomial and of its derivative."""
    value, slope = series[-1], series[-1] * 0
    for coefficient in series[-2::-1]:
        slope = slope * step + value
        value = value * step + coefficient
    return value, slope


def integrate(
    system: System,
    state: Numbers,
    start: Any,
    times: Sequence[Any],
    accuracy: Accuracy,
    most_steps: int = 100_000,
) -> tuple[list[Numbers], int]:
    """Return the states at the times and the number of steps taken.

    Raises
    ------
    StepLimitError
    """
    samples: list[Numbers] = []
    time, steps = start, 0
    for mark in times:
        if mark == start:
            samples.append(list(state))
    waiting = [mark for mark in times if mark > start]
    while waiting:
        if steps >= most_steps:
            raise StepLimitError(f"more than {most_steps} steps", float(time))
        coefficients = system.expand(time, state, accuracy.degree)
        step = step_size(coefficients, accuracy.bits, waiting[-1] - time)
        steps += 1
        end = time + step if step < waiting[-1] - time else waiting[-1]
        while waiting and waiting[0] <= end:
            samples.append(moved(coefficients, waiting.pop(0) - time))
        if waiting:
            state = moved(coefficients, end - time)
            time = end
    return samples, steps


def moved(coefficients: list[Numbers], step: Any) -> Numbers:
    """Return the state (2 n,) a step on."""
    pairs = [horner(series, step) for series in coefficients]
    return [value for value, _ in pairs] + [slope for _, slope in pairs]
