"""Equations of motion as a list of NumPy calls on arrays that are made once, or as source code.

The equations are evaluated once with symbols for time and states: what depends on coefficients
alone is computed then, and every other operation is written down, equal ones once. A call of the
kernel goes through that list. It computes what the equations say, to the last bit, but for sines
and cosines of many angles.

NumPy takes those of an array one number after the other, and the tangent of several at once. With
``t = tan(x / 2)`` and ``w = 2 / (1 + t^2)`` sine and cosine are ``t w`` and ``w - 1``: both in a
third of the time of one, off by 1.6 units of rounding at most, where the functions themselves are
off by half of one.

For plain numbers the same list is written as Python source, to the last bit what the equations say.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

MANY = 256
"""Numbers in an array from which on their arithmetic takes longer than the calls."""

MANY_CALLS = 500
"""Evaluations of a state from which on source code pays, which takes milliseconds to make."""

Rates = Callable[..., Sequence[Any]]

OPERATIONS: dict[Any, str] = {
    np.add: "{} + {}",
    np.subtract: "{} - {}",
    np.multiply: "{} * {}",
    np.divide: "{} / {}",
    np.power: "{} ** {}",
    np.negative: "-{}",
    np.sin: "sin({})",
    np.cos: "cos({})",
    np.sqrt: "sqrt({})",
}
"""What is written down, in Python."""


class UntraceableError(Exception):
    """These equations need more than arithmetic and elementary functions."""


class Symbol:
    """A number that is known when the kernel is called: a place in its list of arrays."""

    __array_ufunc__ = None  # arrays leave operations with symbols to these

    def __init__(self, trace: Trace, place: int, like: Any) -> None:
        self.trace, self.place, self.like = trace, place, like

    def __add__(self, other: Any) -> Any:
        """Sum; nothing is done for a zero, with which ``sum`` begins."""
        return (
            self if isinstance(other, int) and not other else self.trace.apply(np.add, self, other)
        )

    __radd__ = __add__

    def __sub__(self, other: Any) -> Symbol:
        """Difference."""
        return self.trace.apply(np.subtract, self, other)

    def __rsub__(self, other: Any) -> Symbol:
        """Difference."""
        return self.trace.apply(np.subtract, other, self)

    def __mul__(self, other: Any) -> Symbol:
        """Product."""
        return self.trace.apply(np.multiply, self, other)

    def __rmul__(self, other: Any) -> Symbol:
        """Product, its factors in their order."""
        return self.trace.apply(np.multiply, other, self)

    def __truediv__(self, other: Any) -> Symbol:
        """Quotient."""
        return self.trace.apply(np.divide, self, other)

    def __rtruediv__(self, other: Any) -> Symbol:
        """Quotient."""
        return self.trace.apply(np.divide, other, self)

    def __neg__(self) -> Symbol:
        """Negative."""
        return self.trace.apply(np.negative, self)

    def __pow__(self, exponent: Any) -> Symbol:
        """Power; squares are products."""
        if exponent == 2:
            return self * self
        return self.trace.apply(np.power, self, exponent)


class Trace:
    """What is done with symbols; it stands for NumPy where equations ask for functions.

    Attributes
    ----------
    calls : list of (function, places of what it takes, places of what it gives)
    values : list
        What stands at each place: constants, or arrays of the shape and type that comes there.
    """

    def __init__(self) -> None:
        self.calls: list[tuple[Callable[..., Any], tuple[int, ...], tuple[int, ...]]] = []
        self.values: list[Any] = []
        self.known: dict[Any, tuple[Symbol, ...]] = {}

    def symbol(self, like: Any) -> Symbol:
        """Return a new symbol for arrays like this."""
        self.values.append(like)
        return Symbol(self, len(self.values) - 1, like)

    def place(self, operand: Any) -> int:
        """Return the place of a symbol or of a constant."""
        if isinstance(operand, Symbol):
            return operand.place
        if not isinstance(operand, float | int | np.ndarray | np.generic):
            raise UntraceableError
        self.values.append(operand)
        return len(self.values) - 1

    def apply(self, function: Any, *operands: Any, outputs: int = 1) -> Any:
        """Write down the call of a function, if it is a new one."""
        key = function, *(x.place if isinstance(x, Symbol) else (id(x),) for x in operands)
        if key not in self.known:
            places = tuple(self.place(operand) for operand in operands)
            likes = [getattr(x, "like", x) for x in operands]
            shape = np.broadcast_shapes(*map(np.shape, likes))
            kind = np.result_type(0.0, *likes)  # plain numbers do not widen single precision
            made = tuple(self.symbol(np.empty(shape, kind)) for _ in range(outputs))
            self.calls.append((function, places, tuple(x.place for x in made)))
            self.known[key] = made
        made = self.known[key]
        return made[0] if outputs == 1 else made

    def _both(self, x: Any) -> Any:
        if not isinstance(x, Symbol):
            return np.sin(x), np.cos(x)
        if x.like.size < MANY:
            return self.apply(np.sin, x), self.apply(np.cos, x)
        return self.apply(sine_and_cosine, x, outputs=2)

    def sin(self, x: Any) -> Any:
        """Sine."""
        return self._both(x)[0]

    def cos(self, x: Any) -> Any:
        """Cosine."""
        return self._both(x)[1]

    def sqrt(self, x: Any) -> Any:
        """Square root."""
        return self.apply(np.sqrt, x) if isinstance(x, Symbol) else np.sqrt(x)

    def __getattr__(self, name: str) -> Any:
        """Refuse all other functions.

        Raises
        ------
        UntraceableError
        """
        raise UntraceableError


def sine_and_cosine(x: Any, sine: Any, cosine: Any) -> None:
    """Compute sine and cosine of an array.

    Complex numbers stand for complex steps, see `differences`: both functions are linear in their
    imaginary parts.
    """
    if x.dtype.kind == "c":
        real, s, c = x.real * 0.5, np.empty(x.shape), np.empty(x.shape)
        _from_half(real, s, c)
        sine.real, cosine.real = s, c
        np.multiply(c, x.imag, out=sine.imag)
        np.multiply(s, x.imag, out=s)
        np.negative(s, out=cosine.imag)
    else:
        _from_half(x * 0.5, sine, cosine)


def _from_half(t: Any, sine: Any, cosine: Any) -> None:
    np.tan(t, t)
    np.multiply(t, t, cosine)
    np.add(cosine, 1.0, cosine)
    np.divide(2.0, cosine, cosine)
    np.multiply(t, cosine, sine)
    np.subtract(cosine, 1.0, cosine)


def kernel_of(rates: Rates, t: Any, x: Any) -> Callable[[Any, Any], Any] | None:
    """Return equations of motion ``(t, x) -> dx/dt`` for arrays like these.

    Parameters
    ----------
    rates : callable ``(t, q, v, xp) -> accelerations``
    t : float or array (...)
    x : array (2 n, ...)

    Returns
    -------
    callable, or None
        None where the equations need more than can be written down.
    """
    trace = Trace()
    time, inputs = trace.symbol(t), [trace.symbol(np.empty_like(row)) for row in x]
    n = len(inputs) // 2
    try:
        ends = [trace.place(end) for end in rates(time, inputs[:n], inputs[n:], trace)]
    except (UntraceableError, TypeError):  # symbols know neither comparisons nor abs()
        return None
    program, own = with_buffers(trace, {*ends}), np.array(x)
    own_time = trace.values[0] = np.array(t)
    trace.values[1 : 2 * n + 1] = [own[row, ...] for row in range(2 * n)]  # `...`: never a copy
    calls = [(function, [trace.values[place] for place in places]) for function, places in program]
    results = [trace.values[place] for place in ends]

    def kernel(t: Any, x: Any) -> Any:
        own_time[...], own[...] = t, x
        for function, arrays in calls:
            function(*arrays)
        out = np.empty_like(x)
        out[:n] = x[n:]
        for row, result in enumerate(results, n):
            out[row] = result
        return out

    return kernel


def written_out(rates: Rates, n: int) -> Rates:
    """Return the accelerations of plain numbers: after `MANY_CALLS` those of their `source`.

    That is up to five times faster where the equations are long.

    Parameters
    ----------
    rates : callable ``(t, q, v, xp) -> accelerations``
    n : int
    """
    calls, function = 0, None

    def accelerations(t: float, q: Sequence[float], v: Sequence[float], xp: Any) -> Sequence[float]:
        nonlocal calls, function
        if function is not None:
            return function(t, *q, *v)
        calls += 1
        if calls == MANY_CALLS:
            function = source(rates, n)
        return rates(t, q, v, xp)

    return accelerations


def source(rates: Rates, n: int) -> Callable[..., Sequence[float]] | None:
    """Return the accelerations of plain numbers ``(t, *q, *v)`` as a function without branches.

    None where the equations need more than can be written down; parameters are those of
    `written_out`.
    """
    trace, like = Trace(), np.empty(())
    time, inputs = trace.symbol(like), [trace.symbol(like) for _ in range(2 * n)]
    try:
        ends = [trace.place(end) for end in rates(time, inputs[:n], inputs[n:], trace)]
    except (UntraceableError, TypeError):
        return None
    names = [
        f"x{place}" if isinstance(value, np.ndarray) else f"({float(value)!r})"
        for place, value in enumerate(trace.values)
    ]
    lines = [
        f"    {names[made]} = {OPERATIONS[function].format(*(names[place] for place in taken))}\n"
        for function, taken, (made,) in trace.calls
    ]
    text = f"def function({', '.join(names[: 2 * n + 1])}):\n{''.join(lines)}"
    text += f"    return [{', '.join(names[end] for end in ends)}]\n"
    space = {"sin": math.sin, "cos": math.cos, "sqrt": math.sqrt, "inf": math.inf, "nan": math.nan}
    exec(compile(text, "<equations of motion>", "exec"), space)
    return space["function"]


def with_buffers(trace: Trace, ends: set[int]) -> list[tuple[Any, tuple[int, ...]]]:
    """Return the calls of a trace, with arrays that are taken again when no one needs them."""
    last = {place: i for i, (_, taken, _) in enumerate(trace.calls) for place in taken}
    made = {place for _, _, outputs in trace.calls for place in outputs} - ends
    spare: dict[Any, list[Any]] = {}
    for i, (_, taken, outputs) in enumerate(trace.calls):
        for place in outputs:
            like = trace.values[place]
            spare_arrays = spare.get((like.shape, like.dtype))
            if spare_arrays:
                trace.values[place] = spare_arrays.pop()
        for place in {*taken} & made:
            if last[place] == i:
                like = trace.values[place]
                spare.setdefault((like.shape, like.dtype), []).append(like)
    return [(function, (*taken, *outputs)) for function, taken, outputs in trace.calls]
