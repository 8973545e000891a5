"""Each term of functions, changed in turn: all that they add, and what they return."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

FACTORS = {"dropped": 0.0, "reversed": -1.0, "off by 1e-6": 1 + 1e-6}


class Counted(NDArrayOperatorsMixin):
    """An array that counts what is added to others or subtracted, and changes one of these.

    Attributes
    ----------
    value : array
    ledger : list of (count, number, factor)
        Of terms so far, and which one is multiplied by what; shared by all arrays of a run.
    """

    def __init__(self, value: Any, ledger: list[Any]) -> None:
        self.value, self.ledger = value, ledger

    def term(self, value: Any) -> Any:
        """Return a term, changed if it is the one to change; what is 0 does not count."""
        if not np.any(value):
            return value
        self.ledger[0] += 1
        return value * self.ledger[2] if self.ledger[0] == self.ledger[1] else value

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        """Return the result of a function of NumPy."""
        values = [x.value if isinstance(x, Counted) else x for x in inputs]
        if ufunc in (np.add, np.subtract):
            values = [self.term(value) for value in values]
        return Counted(ufunc(*values), self.ledger)


def evaluate(
    function: Callable[..., Any], arguments: tuple[Any, ...], number: int = 0, factor: float = 1.0
) -> tuple[Any, int]:
    """Return values of a function of arrays with one term changed, and how many there are."""
    ledger: list[Any] = [0, number, factor]

    def counted(x: Any) -> Any:
        if hasattr(x, "_fields"):
            return type(x)(*(counted(one) for one in x))
        if isinstance(x, np.ndarray) and x.ndim > 1:
            return [counted(one) for one in x]
        return Counted(x, ledger)

    def plain(x: Any) -> Any:
        if isinstance(x, list):
            return np.array(np.broadcast_arrays(*(plain(one) for one in x)))
        return x.term(x.value) if isinstance(x, Counted) else np.asarray(x)

    return plain(function(*(counted(one) for one in arguments))), ledger[0]
