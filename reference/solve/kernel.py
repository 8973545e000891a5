"""Equations of motion as a list of NumPy calls on arrays that are made once, or as source code.

The equations are evaluated once with symbols for time and states: what depends on coefficients
alone is computed then, and every other operation is written down, equal ones once, none with a
zero coefficient. A call of the kernel executes that list. Results equal those of the equations to
the last bit, but for sines and cosines of many angles.

NumPy takes those of an array one number after the other, and the tangent of several at once. With
``t = tan(x / 2)`` and ``w = 2 / (1 + t^2)`` sine and cosine are ``t w`` and ``w - 1``: both in a
third of the time of one, off by 1.6 units of rounding at most, where the functions themselves are
off by half of one.

For plain numbers the same list is written as Python source.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..cost import watched

MANY = 256
"""Numbers in an array from which on their arithmetic takes longer than the calls."""


MANY_CALLS = 500
"""Evaluations of a state from which on source code pays, which takes milliseconds to make."""

Rates = Callable[..., Sequence[Any]]

Call = tuple[Callable[..., Any], tuple[int, ...], tuple[int, ...]]

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
"""Traced NumPy functions as Python source."""


class UntraceableError(Exception):
    """These equations need more than arithmetic and elementary functions."""


class Symbol:
    """An operand of a traced operation: a place in the kernel's list of arrays."""

    __array_ufunc__ = None  # arrays leave operations with symbols to these

    def __init__(self, trace: Trace, place: int, like: Any) -> None:
        self.trace, self.place, self.like = trace, place, like

    def __add__(self, other: Any) -> Any:
        """Sum; nothing is done for a zero."""
        return self if is_number(other, 0) else self.trace.apply(np.add, self, other)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        """Difference; nothing is done for a zero."""
        return self if is_number(other, 0) else self.trace.apply(np.subtract, self, other)

    def __rsub__(self, other: Any) -> Symbol:
        """Difference."""
        return self.trace.apply(np.subtract, other, self)

    def __mul__(self, other: Any) -> Any:
        """Product; that with a zero is one, and nothing is done for a one."""
        return self._times(other, self, other)

    def __rmul__(self, other: Any) -> Any:
        """Product, its factors in their order."""
        return self._times(other, other, self)

    def _times(self, other: Any, *factors: Any) -> Any:
        if is_number(other, 0):
            return 0.0
        return self if is_number(other, 1) else self.trace.apply(np.multiply, *factors)

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


def is_number(operand: Any, value: float) -> bool:
    """Return True if an operand is a constant with this value."""
    return not isinstance(operand, Symbol) and not np.ndim(operand) and operand == value


class Trace:
    """Recorded operations on symbols; it takes the place of NumPy in the equations.

    Attributes
    ----------
    calls : list of (function, places of what it takes, places of what it gives)
    values : list
        What stands at each place: constants, or arrays of the shape and type that comes there.
        The first is the time.
    """

    def __init__(self) -> None:
        self.calls: list[Call] = []
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
        if x.like.dtype.kind == "c":
            return self.apply(sine_and_cosine, x, outputs=2)
        tangent = self.apply(np.tan, x * 0.5)
        width = 2.0 / (tangent * tangent + 1.0)
        return tangent * width, width - 1.0

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
    """Compute sine and cosine of an array of complex numbers.

    They stand for complex steps, see `differences`: both functions are linear in their imaginary
    parts.
    """
    tangent = np.tan(x.real * 0.5)
    width = 2.0 / (tangent * tangent + 1.0)
    s, c = tangent * width, width - 1.0
    sine.real, cosine.real = s, c
    np.multiply(c, x.imag, out=sine.imag)
    np.multiply(-s, x.imag, out=cosine.imag)


class Kernel:
    """Equations of motion ``(t, x) -> dx/dt`` for arrays of one shape.

    Attributes
    ----------
    time, x : array (...), array (2 n, ...)
        What its calls read.
    calls : list of (function, arrays)
    accelerations : list of arrays (...) or numbers
        Results of the calls.
    """

    def __init__(self, trace: Trace, ends: Sequence[int], t: Any, x: Any) -> None:
        n = len(x) // 2
        self.time, self.x = np.array(t, order="C"), np.array(x, order="C")
        arrays = trace.values
        arrays[0] = self.time
        arrays[1 : 2 * n + 1] = [self.x[row, ...] for row in range(2 * n)]  # `...`: never a copy
        self.accelerations = [arrays[place] for place in ends]
        self.calls: list[tuple[Any, list[Any]]] = []
        read = {*ends}
        for function, taken, made in reversed(trace.calls):
            if read & {*made}:  # what no one reads is not computed
                read |= {*taken}
                kind = arrays[made[-1]].dtype  # NumPy would make arrays of numbers in each call
                arguments = (arrays[i] for i in (*taken, *made))
                ready = [x if isinstance(x, np.ndarray) else np.asarray(x, kind) for x in arguments]
                self.calls.insert(0, (function, ready))

    def __call__(self, t: Any, x: Any) -> Any:
        """Return dx/dt."""
        self.time[...], self.x[...] = t, x
        for function, arrays in self.calls:
            function(*arrays)
        return with_rates_of(x, self.accelerations)


def with_rates_of(x: Any, accelerations: Sequence[Any]) -> Any:
    """Return dx/dt (2 n, ...) of states, from their accelerations."""
    n, out = len(x) // 2, np.empty_like(x)
    out[:n] = x[n:]
    for row, one in enumerate(accelerations, n):
        out[row] = one
    return out


def written_down(rates: Rates, t: Any, x: Sequence[Any]) -> tuple[Trace, list[int]] | None:
    """Return the operations of equations of motion on such arrays, and places of accelerations.

    None where the equations need more than can be written down.

    Parameters
    ----------
    rates : callable ``(t, q, v, xp) -> accelerations``
    t : float or array (...)
    x : 2 n arrays (...)
    """
    trace = Trace()
    time, inputs = trace.symbol(t), [trace.symbol(np.empty_like(row)) for row in x]
    n = len(inputs) // 2
    try:
        ends = [trace.place(end) for end in rates(time, inputs[:n], inputs[n:], trace)]
    except (UntraceableError, TypeError):  # symbols know neither comparisons nor abs()
        return None
    return trace, ends


def written_out(rates: Rates) -> Rates:
    """Return the accelerations of plain numbers: after `MANY_CALLS` those of their `source`.

    That is up to five times faster where the equations are long.

    Parameters
    ----------
    rates : callable ``(t, q, v, xp) -> accelerations``
    """
    calls = 0
    function: Callable[..., Sequence[float]] | None = None

    def accelerations(t: float, q: Sequence[float], v: Sequence[float], xp: Any) -> Sequence[float]:
        nonlocal calls, function
        if function is not None:
            return function(t, *q, *v)
        calls += 1
        if calls == MANY_CALLS:
            function = source(rates, len(q))
        return rates(t, q, v, xp)

    return accelerations


def source(rates: Rates, n: int) -> Callable[..., Sequence[float]] | None:
    """Return the accelerations of plain numbers ``(t, *q, *v)`` as a function without branches.

    None where the equations need more than can be written down; n is the number of coordinates.
    """
    written = written_down(rates, np.empty(()), [np.empty(())] * (2 * n))
    if written is None:
        return None
    trace, ends = written
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
    space: dict[str, Any] = {"sin": math.sin, "cos": math.cos, "sqrt": math.sqrt}
    space |= {"inf": math.inf, "nan": math.nan}
    exec(compile(text, "<equations of motion>", "exec"), space)
    function: Callable[..., Sequence[float]] = space["function"]
    return function


class RightHandSide:
    """Equations of motion ``f(t, x) -> dx/dt``, x of shape (2 n, ...).

    Parameters
    ----------
    rates : callable ``(t, q, v, xp) -> accelerations``
    numbers : callable, optional
        The same with floats and `math` of a single point: several times faster.
    is_traceable : bool
        Whether kernels may be tried.
    """

    def __init__(
        self,
        rates: Rates,
        numbers: Rates | None,
        is_traceable: bool,
    ) -> None:
        self.rates, self.numbers, self.is_traceable = rates, numbers, is_traceable
        self.kernels: dict[Any, Kernel | None] = {}
        self.call = watched(self.value)

    def __call__(self, t: Any, x: Any) -> Any:
        """Return dx/dt, within the budget."""
        return self.call(t, x)

    def is_single(self, t: Any, x: Any) -> bool:
        """Return True for one state of doubles."""
        one = x.ndim == 1 or (x.size == len(x) and np.isrealobj(t))
        return self.numbers is not None and x.dtype == float and one

    def is_few(self, t: Any, x: Any) -> bool:
        """Return True if states are evaluated one by one: no more doubles (2 n, k) than (2 n)^2.

        Plain numbers then take less time than the calls of NumPy, of which longer equations have
        the more.
        """
        known = self.is_traceable and self.numbers is not None and x.dtype == float
        return known and x.ndim == 2 and x.size <= len(x) ** 2 and np.isrealobj(t)

    def kernel(self, t: Any, x: Any) -> Kernel | None:
        """Return the kernel for arrays like these, if there is one."""
        if not self.is_traceable or self.is_single(t, x) or self.is_few(t, x):
            return None
        key = np.shape(t), np.result_type(t), x.shape, x.dtype
        if key not in self.kernels:
            written = written_down(self.rates, t, x)
            self.kernels[key] = None if written is None else Kernel(*written, t, x)
        return self.kernels[key]

    def prepared(self, t: Any, x: Any) -> Callable[[Any, Any], Any]:
        """Return the right-hand side for arrays of these shapes and types."""
        kernel = self.kernel(t, x)
        return self.call if kernel is None else watched(kernel)

    def value(self, t: Any, x: Any) -> Any:
        """Return dx/dt."""
        if self.is_single(t, x):
            return self.one(np.asarray(t).item(), x.ravel().tolist()).reshape(x.shape)
        if self.is_few(t, x):
            times = np.broadcast_to(t, x.shape[1:]).tolist()
            return np.column_stack([self.one(*at) for at in zip(times, x.T.tolist(), strict=True)])
        if (kernel := self.kernel(t, x)) is not None:
            return kernel(t, x)
        n = len(x) // 2
        return with_rates_of(x, self.rates(t, x[:n], x[n:], np))

    def one(self, t: float, x: list[float]) -> Any:
        """Return the same of a single state (2 n,)."""
        n = len(x) // 2
        try:
            a = self.numbers(t, x[:n], x[n:], math)  # type: ignore[misc]
        except (OverflowError, ValueError, ZeroDivisionError):  # NumPy gives inf or nan
            a = [math.nan] * n
        return np.array([*x[n:], *a], dtype=float)
