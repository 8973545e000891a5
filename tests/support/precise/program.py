"""Expressions as straight-line programs, which power series can run through.

An expression in states and time becomes a list of operations, each on earlier results. What depends
on parameters alone stays an expression and is evaluated to a number for each draw.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import prod
from typing import Any, NamedTuple

import gmpy2
import sympy as sp


class Operation(NamedTuple):
    """One operation on earlier results.

    Attributes
    ----------
    kind : {"input", "sum", "product", "square", "sine", "cosine", "root", "reciprocal"}
        A sine and its cosine stand one after the other.
    inputs : tuple of int
        The results that it takes.
    factors : tuple of sympy expressions
        Of a sum: the factor of each input, then what is added.
    """

    kind: str
    inputs: tuple[int, ...] = ()
    factors: tuple[Any, ...] = ()


@dataclass(eq=False)
class Program:
    """Operations in order; the first are the inputs.

    Attributes
    ----------
    operations : list of Operation
    results : list of int
        The operations whose results the expressions are.
    """

    operations: list[Operation] = field(default_factory=list)
    results: list[int] = field(default_factory=list)
    places: dict[Any, int] = field(default_factory=dict)

    def add(self, key: Any, *operation: Any) -> int:
        """Append an operation and return its place."""
        self.operations.append(Operation(*operation))
        self.places[key] = len(self.operations) - 1
        return self.places[key]

    def place(self, expression: Any) -> int:
        """Return where the result of an expression stands, appending what is missing."""
        if expression in self.places:
            return self.places[expression]
        if not self.moves(expression):
            return self.add(expression, "sum", (), (expression,))
        if expression.is_Add:
            still = sp.Add(*(part for part in expression.args if not self.moves(part)))
            parts = [self.split(part) for part in expression.args if self.moves(part)]
            inputs = tuple(self.place(part) for _, part in parts)
            return self.add(expression, "sum", inputs, (*(factor for factor, _ in parts), still))
        if expression.is_Mul:
            factor, rest = self.split(expression)
            if factor != 1:
                return self.add(expression, "sum", (self.place(rest),), (factor, sp.S.Zero))
            head, *tail = rest.args
            inputs = (self.place(head), self.place(sp.Mul(*tail)))
            return self.add(expression, "product", inputs)
        if isinstance(expression, (sp.sin, sp.cos)):
            at = self.place(expression.args[0])
            sine = self.add(sp.sin(*expression.args), "sine", (at, len(self.operations) + 1))
            self.add(sp.cos(*expression.args), "cosine", (at, sine))
            return self.places[expression]
        base, exponent = expression.as_base_exp()
        if exponent == 2:
            return self.add(expression, "square", (self.place(base),))
        if exponent == sp.Rational(1, 2):
            return self.add(expression, "root", (self.place(base),))
        if exponent.is_negative:
            return self.add(expression, "reciprocal", (self.place(base**-exponent),))
        if exponent.is_Rational and exponent > 1:
            inputs = (self.place(base), self.place(base ** (exponent - 1)))
            return self.add(expression, "product", inputs)
        raise NotImplementedError(f"no operation for {expression}")

    def moves(self, expression: Any) -> bool:
        """Return whether an expression depends on more than parameters."""
        return any(symbol in self.places for symbol in expression.free_symbols)

    def split(self, expression: Any) -> tuple[Any, Any]:
        """Return the factor of a product that parameters make, and the rest."""
        if not expression.is_Mul:
            return sp.S.One, expression
        factors = [part for part in expression.args if not self.moves(part)]
        rest = [part for part in expression.args if self.moves(part)]
        return sp.Mul(*factors), sp.Mul(*rest)


def compile_expressions(inputs: Sequence[Any], expressions: Sequence[Any]) -> Program:
    """Return the program of some expressions, common parts of them shared."""
    program = Program()
    for symbol in inputs:
        program.add(symbol, "input")
    shared, reduced = sp.cse(expressions)
    constants: dict[Any, Any] = {}
    for symbol, expression in shared:
        expression = expression.xreplace(constants)
        if program.moves(expression):
            program.places[symbol] = program.place(expression)
        else:
            constants[symbol] = expression
    program.results = [program.place(item.xreplace(constants)) for item in reduced]
    return program


def evaluate(expression: Any, values: Mapping[str, Any]) -> Any:
    """Return the value of an expression in parameters, rounded to the present precision."""
    if expression.is_Symbol:
        return values[expression.name]
    if expression.is_Rational:
        return gmpy2.mpfr(int(expression.p)) / int(expression.q)
    if expression is sp.pi:
        return gmpy2.const_pi()
    parts = [evaluate(part, values) for part in expression.args]
    if expression.is_Add:
        return sum(parts[1:], parts[0])
    if expression.is_Mul:
        return prod(parts)
    if expression.is_Pow:
        base, exponent = parts
        return gmpy2.sqrt(base) if exponent == 0.5 else base**exponent
    return {sp.sin: gmpy2.sin, sp.cos: gmpy2.cos}[expression.func](*parts)
