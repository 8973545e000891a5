"""Initial-value problems by power series in time, with numbers of any precision.

The solution's Taylor coefficients follow one from another by the rules for products, quotients,
roots and circular functions of power series; a step is a share of the radius of convergence.
Neither equations, numbers nor method have anything in common with the reference.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from operator import mul
from typing import Any, Protocol

import gmpy2

from mbcheck.tests.support.precise.program import Operation, Program, evaluate

Numbers = list[Any]


class System(Protocol):
    """What can be integrated: second-order equations for n coordinates.

    Attributes
    ----------
    breaks : tuple of numbers
        Times [s] at which the equations change.
    """

    breaks: tuple[Any, ...]

    def expand(self, time: Any, state: Numbers, order: int) -> list[Numbers]:
        """Return the Taylor coefficients (n, order + 1) of the coordinates about a time."""

    def to_float(self) -> None:
        """Compute with doubles from now on."""


FIRST: Mapping[str, str] = {
    "product": "x{0}[0] * x{1}[0]",
    "square": "x{0}[0] * x{0}[0]",
    "sine": "sin(x{0}[0])",
    "cosine": "cos(x{0}[0])",
    "root": "sqrt(x{0}[0])",
    "reciprocal": "1 / x{0}[0]",
}
"""First coefficient of each kind of operation on series x."""

NEXT: Mapping[str, str] = {
    "product": "sum(map(mul, x{0}, x{1}[::-1]))",
    "square": "square(x{0}, k)",
    "sine": "sum(map(mul, slope(d{at}, k * x{0}[k]), x{1}[::-1])) / k",
    "cosine": "-sum(map(mul, d{1}, x{1}[k - 1 :: -1])) / k",
    "root": "(x{0}[k] - sum(map(mul, x{at}[1:], x{at}[:0:-1]))) / (2 * x{at}[0])",
    "reciprocal": "-sum(map(mul, x{at}, x{0}[:0:-1])) * x{at}[0]",
}
"""Coefficient k > 0; d are the slopes of the argument of a sine, k times its coefficients."""


def square(a: Numbers, k: int) -> Any:
    """Return coefficient k of a square."""
    half = (k + 1) // 2
    value = 2 * sum(map(mul, a[:half], a[: k - half : -1] if half else []))
    return value + a[k // 2] * a[k // 2] if k % 2 == 0 else value


def slope(slopes: Numbers, value: Any) -> Numbers:
    """Append a value and return all."""
    slopes.append(value)
    return slopes


def terms(operation: Operation, at: int, first: bool) -> str:
    """Return the sum of an operation's terms; its factors are the numbers f."""
    *factors, still = operation.factors
    parts = [f"f{at}_{len(factors)}"] if first and (still != 0 or not factors) else []
    for i, (place, factor) in enumerate(zip(operation.inputs, factors, strict=True)):
        scale = {1: "", -1: "-"}.get(factor, f"f{at}_{i} * ")
        parts.append(f"{scale}x{place}[k]")
    return " + ".join(parts) or "zero"


def source_of(program: Program) -> str:
    """Return a function that appends coefficient k of all results, as Python."""
    lines: Mapping[bool, list[str]] = {True: [], False: []}
    for at, operation in enumerate(program.operations):
        if operation.kind == "input":
            continue
        for first, rules in ((True, FIRST), (False, NEXT)):
            if operation.kind == "sum":
                value = terms(operation, at, first)
            else:
                value = rules[operation.kind].format(*operation.inputs, at=at)
            lines[first].append(f"            x{at}.append({value})")
    count = len(program.operations)
    names = [f"x{at}" for at in range(count)] + [f"d{at}" for at in range(count)]
    factors = [
        f"f{at}_{i}" for at, one in enumerate(program.operations) for i in range(len(one.factors))
    ]
    return "\n".join(
        [
            "def bind(series, slopes, factors, zero, sin, cos, sqrt):",
            f"    {', '.join(names)}, = (*series, *slopes)",
            f"    {', '.join(factors)}, = factors",
            "    def extend(k):",
            "        if k == 0:",
            *lines[True],
            "        else:",
            *lines[False],
            "    return extend",
        ]
    )


@cache
def bind_of(program: Program) -> Callable[..., Callable[[int], None]]:
    """Return the compiled function of a program."""
    names: dict[str, Any] = {"mul": mul, "square": square, "slope": slope}
    exec(source_of(program), names)
    bind: Callable[..., Callable[[int], None]] = names["bind"]
    return bind


class Lagrangian:
    """``M(q) a = f(t, q, v)`` as a `System`.

    Attributes
    ----------
    size : int
        Number n of coordinates.
    program : Program
        With the inputs t, q, v and the results M, row by row, then f.
    factors : list of numbers
        Of all sums, in order.
    functions : sine, cosine and root of such numbers
    """

    def __init__(self, size: int, program: Program, values: Mapping[str, Any]) -> None:
        self.size = size
        self.breaks: tuple[Any, ...] = ()
        self.program = program
        self.factors = [
            evaluate(factor, values) for one in program.operations for factor in one.factors
        ]
        self.functions: tuple[Any, ...] = (gmpy2.sin, gmpy2.cos, gmpy2.sqrt)

    def to_float(self) -> None:
        """Compute with doubles from now on."""
        self.factors = [float(factor) for factor in self.factors]
        self.functions = (math.sin, math.cos, math.sqrt)

    def expand(self, time: Any, state: Numbers, order: int) -> list[Numbers]:
        """Return the Taylor coefficients (n, order + 1) of the coordinates about a time."""
        n, zero = self.size, state[0] * 0
        series: list[Numbers] = [[] for _ in self.program.operations]
        slopes: list[Numbers] = [[] for _ in self.program.operations]
        extend = bind_of(self.program)(series, slopes, self.factors, zero, *self.functions)
        for at, value in enumerate((time, *state)):
            series[at].append(value)
        mass, load = self.program.results[: n * n], self.program.results[n * n :]
        moving = [
            (i // n, i % n, series[place])
            for i, place in enumerate(mass)
            if self.program.operations[place].inputs
        ]
        extend(0)
        start = [[series[place][0] for place in mass[i * n : i * n + n]] for i in range(n)]
        inverse = inverse_matrix(start)
        accelerations: list[Numbers] = [[] for _ in range(n)]
        for k in range(order):
            right = [series[place][k] for place in load]
            for i, j, entry in moving:
                right[i] -= sum(map(mul, accelerations[j], entry[:0:-1]))
            for row, values in zip(inverse, accelerations, strict=True):
                values.append(sum(map(mul, row, right)))
            series[0].append(zero if k else zero + 1)
            for i in range(n):
                series[1 + i].append(series[1 + n + i][k] / (k + 1))
            for i in range(n):
                series[1 + n + i].append(accelerations[i][k] / (k + 1))
            if k < order - 1:
                extend(k + 1)
        return series[1 : 1 + n]


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
    if not isinstance(value, gmpy2.mpfr):
        return math.log2(abs(float(value)))
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
        last = min([mark for mark in system.breaks if mark > time] + waiting[-1:])
        step = step_size(coefficients, accuracy.bits, last - time)
        steps += 1
        end = time + step if step < last - time else last
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
