"""Equations of motion as source code of one function.

The equations are evaluated once with symbols for time and states: what depends on coefficients
alone is computed then, and every other operation is written as a line of Python, equal ones once,
none with a zero coefficient. The function serves arrays and plain numbers; its values are those
of the equations to the last bit.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from types import CodeType
from typing import Any

import numpy as np

from ..cost import watched

MANY_CALLS = 500
"""Evaluations of plain numbers from which source code pays, which takes milliseconds to make."""

RESULT = re.compile(r"\by\d+\b")
"""The name of an operation's result in source code."""

Rates = Callable[..., Sequence[Any]]

MATH: Mapping[str, Any] = {"sin": math.sin, "cos": math.cos, "sqrt": math.sqrt}
NUMPY: Mapping[str, Any] = {"sin": np.sin, "cos": np.cos, "sqrt": np.sqrt}
"""The functions that source code calls, of plain numbers and of arrays."""


class UntraceableError(Exception):
    """These equations need more than arithmetic and elementary functions."""


class Symbol:
    """An operand of a traced operation, with its name in the source code."""

    __array_ufunc__ = None  # arrays leave operations with symbols to these

    def __init__(self, trace: Trace, name: str) -> None:
        self.trace, self.name = trace, name

    def __add__(self, other: Any) -> Any:
        """Sum; nothing is done for a zero."""
        return self if is_number(other, 0) else self.trace.apply("{} + {}", self, other)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        """Difference; nothing is done for a zero."""
        return self if is_number(other, 0) else self.trace.apply("{} - {}", self, other)

    def __rsub__(self, other: Any) -> Symbol:
        """Difference."""
        return self.trace.apply("{} - {}", other, self)

    def __mul__(self, other: Any) -> Any:
        """Product; that with a zero is one, and nothing is done for a one."""
        if is_number(other, 0):
            return 0.0
        return self if is_number(other, 1) else self.trace.apply("{} * {}", self, other)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Symbol:
        """Quotient."""
        return self.trace.apply("{} / {}", self, other)

    def __rtruediv__(self, other: Any) -> Symbol:
        """Quotient."""
        return self.trace.apply("{} / {}", other, self)

    def __neg__(self) -> Symbol:
        """Negative."""
        return self.trace.apply("-{}", self)

    def __pow__(self, exponent: Any) -> Symbol:
        """Power; squares are products."""
        if exponent == 2:
            return self.trace.apply("{} * {}", self, self)
        return self.trace.apply("{} ** {}", self, exponent)


def is_number(operand: Any, value: float) -> bool:
    """Return True if an operand is a constant with this value."""
    return not isinstance(operand, Symbol) and not np.ndim(operand) and operand == value


class Trace:
    """Recorded operations on symbols; it takes the place of NumPy in the equations.

    Attributes
    ----------
    lines : mapping of expression to Symbol
        Operations in their order, and their results.
    constants : mapping of id to (name, value)
    """

    def __init__(self) -> None:
        self.lines: dict[str, Symbol] = {}
        self.constants: dict[int, tuple[str, Any]] = {}

    def name(self, operand: Any) -> str:
        """Return the name of a symbol or of a constant.

        Raises
        ------
        UntraceableError
            If the operand is neither.
        """
        if isinstance(operand, Symbol):
            return operand.name
        if not isinstance(operand, float | int | np.ndarray | np.generic):
            raise UntraceableError
        return self.constants.setdefault(id(operand), (f"c{len(self.constants)}", operand))[0]

    def apply(self, form: str, *operands: Any) -> Symbol:
        """Return the result of an operation, which is written down if it is a new one."""
        line = form.format(*map(self.name, operands))
        return self.lines.setdefault(line, Symbol(self, f"y{len(self.lines)}"))

    def __getattr__(self, function: str) -> Callable[[Any], Any]:
        """Return an elementary function of symbols.

        Raises
        ------
        UntraceableError
            If it is another one.
        """
        if function not in NUMPY:
            raise UntraceableError

        def call(x: Any) -> Any:
            traced = isinstance(x, Symbol)
            return self.apply(f"{function}({{}})", x) if traced else NUMPY[function](x)

        return call


def source(
    rates: Rates, n: int, functions: Mapping[str, Any], kind: np.dtype[Any] | None = None
) -> Rates | None:
    """Return accelerations ``(t, *q, *v)`` as a function without branches.

    None where the equations need more than can be written down.

    Parameters
    ----------
    rates : callable ``(t, q, v, xp) -> accelerations``
    n : int
        Number of coordinates.
    functions : mapping of str to callable
        `MATH` or `NUMPY`.
    kind : dtype, optional
        Type of the arrays' numbers, which constants then have, too: NumPy converts numbers of
        Python at each operation, and its own numbers are slow.
    """
    trace = Trace()
    time, *x = (Symbol(trace, name) for name in ("t", *(f"x{i}" for i in range(2 * n))))
    try:
        ends = [trace.name(end) for end in rates(time, x[:n], x[n:], trace)]
    except (UntraceableError, TypeError):  # symbols know neither comparisons nor abs()
        return None
    lines, alive = [], set(ends)
    for line, made in reversed(trace.lines.items()):
        done = set(RESULT.findall(line)) - alive
        alive |= done
        lines += [f"    del {name}\n" for name in sorted(done)]  # arrays stay in the cache
        lines.append(f"    {made.name} = {line}\n")
    inputs = ", ".join(one.name for one in (time, *x))
    text = f"def function({inputs}):\n{''.join(lines[::-1])}    return [{', '.join(ends)}]\n"
    space = dict(functions)
    for name, value in trace.constants.values():
        number = value if np.ndim(value) else np.array(value, kind)
        space[name] = number.item() if kind is None and not np.ndim(value) else number
    exec(compiled(text), space)
    function: Rates = space["function"]
    return function


@lru_cache(maxsize=256)
def compiled(text: str) -> CodeType:
    """Compile source code; that of other coefficients is the same."""
    return compile(text, "<equations of motion>", "exec")


def written_out(rates: Rates) -> Rates:
    """Return the accelerations of plain numbers: after `MANY_CALLS` those of their `source`.

    That is up to five times faster where the equations are long.

    Parameters
    ----------
    rates : callable ``(t, q, v, xp) -> accelerations``
    """
    calls = 0
    function: Rates | None = None

    def accelerations(t: float, q: Sequence[float], v: Sequence[float], xp: Any) -> Sequence[float]:
        nonlocal calls, function
        if function is not None:
            return function(t, *q, *v)
        calls += 1
        if calls == MANY_CALLS:
            function = source(rates, len(q), MATH)
        return rates(t, q, v, xp)

    return accelerations


class RightHandSide:
    """Equations of motion ``f(t, x) -> dx/dt``, x of shape (2 n, ...).

    Parameters
    ----------
    rates : callable ``(t, q, v, xp) -> accelerations``
    numbers : callable, optional
        The same with floats and `math` of a single point: several times faster.
    is_traceable : bool
        Whether source code may be tried.
    """

    def __init__(self, rates: Rates, numbers: Rates | None, is_traceable: bool) -> None:
        self.rates, self.numbers, self.is_traceable = rates, numbers, is_traceable
        self.arrays: dict[Any, Rates] = {}
        self.call = watched(self.value)

    def __call__(self, t: Any, x: Any) -> Any:
        """Return dx/dt, within the budget."""
        return self.call(t, x)

    def value(self, t: Any, x: Any) -> Any:
        """Return dx/dt."""
        n, out = len(x) // 2, np.empty_like(x)
        one = x.ndim == 1 or (x.size == len(x) and np.isrealobj(t))
        if self.numbers is not None and x.dtype == float and one:
            numbers = x.ravel().tolist()
            try:
                rates = self.numbers(np.asarray(t).item(), numbers[:n], numbers[n:], math)
            except (OverflowError, ValueError, ZeroDivisionError):  # NumPy gives inf or nan
                rates = [math.nan] * n
        else:
            rates = self.of_arrays(n, x.dtype)(t, *x)
        out[:n] = x[n:]
        for row, rate in enumerate(rates, n):
            out[row] = rate
        return out

    def of_arrays(self, n: int, kind: np.dtype[Any]) -> Rates:
        """Return the accelerations ``(t, *q, *v)`` of arrays of a type of numbers, n of each."""
        if kind not in self.arrays:
            of = kind if kind.kind in "fc" else None
            traced = source(self.rates, n, NUMPY, of) if self.is_traceable else None
            self.arrays[kind] = traced or (lambda t, *x: self.rates(t, x[:n], x[n:], np))
        return self.arrays[kind]
