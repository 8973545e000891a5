"""Equations as printed, corrected and derived: read by SymPy, and compared at 30 digits.

They are text, a line each, which goes on in lines that are indented further::

    (46): at(d(hinge, h), h, 0) = -4*inertia*u_1*sin(gamma)
        - q_1*alpha**2*sin(beta)/2
    printed = -4*inertia*u_1*cos(gamma)

The left-hand side is derived from the paper's premises or from the scene, never from the equation's
own text; the right-hand side is the equation, corrected. A line ``printed`` has its right-hand side
as printed, and a name before a colon is the one that a row gives it. Names are symbols, or have a
definition, a text of the same form. Beside the usual functions there are ``J(n, u)``, a Bessel
function; ``d(f, x, n)``, a derivative; ``at(f, x, value)``; ``linear(f, x)``, the expansion about
x = 0 up to the first order; ``mean(f, x)``, the mean over a turn of x; and ``sum(f, n, first,
last)``.
"""

from __future__ import annotations

import builtins
import re
from collections import ChainMap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from textwrap import dedent
from typing import Any, NamedTuple

import numpy as np

from ..engines.registry import REFERENCE

FUNCTIONS = ("sin", "cos", "sqrt", "pi", "sinh", "cosh", "factorial")
DIGITS = 30
POINTS = 4
"""Number of random points at which equations are compared that name none."""

Values = Mapping[str, Any]
"""Numbers of symbols, by name."""


class Equation(NamedTuple):
    """One equation of a paper; texts, or SymPy expressions."""

    name: str
    derived: Any
    corrected: Any
    printed: Any


def join_lines(*texts: str) -> str:
    """Return texts one below the other, each without its indentation."""
    return "\n".join(dedent(text).strip() for text in texts)


def sides(text: str) -> list[tuple[str, str]]:
    """Return the left- and right-hand sides of the equations in a text.

    A line with a deeper indentation continues the one before.
    """
    lines = re.sub(r"\n+", "\n", re.sub(r"\n +", " ", dedent(text).strip())).splitlines()
    return [(left, right) for left, _, right in (line.partition(" = ") for line in lines)]


@dataclass(frozen=True)
class Identities:
    """Equations of one row, called to measure their errors.

    Attributes
    ----------
    text : str
    definitions : str
        Each may use those before it.
    values : mapping of str to float or array (k,)
        Where the paper's numbers are taken: points of which arrays have several. Symbols without
        a value are drawn at random.
    scene : callable ``(Values) -> Values``, optional
        Returns more values, which a scene has at a point.
    """

    text: str
    definitions: str = ""
    values: Values = field(default_factory=dict)
    scene: Callable[[Values], Values] | None = None

    def __call__(self, session: object = None) -> dict[str, Any]:
        """Return the errors under their names, the largest of all, and that as printed."""
        points = self.points(self.values)
        errors: dict[str, float] = {}
        for one in self.equations:
            off = self.error(one.corrected, one.derived, points)
            errors[one.name] = max(off, errors.get(one.name, 0.0))
        wrong = [one for one in self.equations if one.printed is not None]
        printed = max((self.error(one.printed, one.derived, points) for one in wrong), default=1.0)
        largest = max(errors.values())
        return {
            "errors": errors,
            "error": largest,
            "largest": largest,
            "corrected": largest,
            "as_printed": printed,
            "share": largest / printed,
            **errors,
        }

    @cached_property
    def symbols(self) -> set[str]:
        """Return the names in all texts that nothing defines."""
        texts = [right for _, right in sides(self.definitions)]
        for left, right in sides(self.text):
            texts += [left.rpartition(": ")[2], right]
        words = set(re.findall(r"[A-Za-z_]\w*", " ".join(texts)))
        known = {name for name, _ in sides(self.definitions)}
        return words - set(vocabulary()) - known - {"printed"}

    @cached_property
    def equations(self) -> list[Equation]:
        """Return the equations as SymPy expressions of symbols."""
        import sympy

        known = vocabulary()
        known |= {name: sympy.Symbol(name, real=True) for name in self.symbols}
        for name, text in sides(self.definitions):
            known[name] = sympy.sympify(text, locals=known, rational=True)
        every: list[Equation] = []
        for left, right in sides(self.text):
            own = sympy.sympify(right, locals=known, rational=True)
            if left == "printed":
                every[-1] = every[-1]._replace(printed=own)
            else:
                name, _, text = left.rpartition(": ")
                derived = sympy.sympify(text, locals=known, rational=True)
                every.append(Equation(name, derived, own, None))
        return every

    def points(self, values: Values, seed: int = 1) -> list[Values]:
        """Return points at which all symbols have numbers; those without one are random."""
        random = np.random.default_rng(seed)
        count = max((np.size(value) for value in values.values()), default=1)
        count = count if count > 1 else POINTS
        names = sorted(self.symbols - set(values))
        own = {name: random.uniform(0.2, 1.2, count) for name in names} | dict(values)
        wide = {name: np.broadcast_to(value, count) for name, value in own.items()}
        several = [{name: float(value[i]) for name, value in wide.items()} for i in range(count)]
        return [{**one, **(self.scene(one) if self.scene else {})} for one in several]

    def error(self, form: Any, derived: Any, points: Sequence[Values]) -> float:
        """Return the largest difference of two expressions."""
        import mpmath
        import sympy

        names = sorted(symbol.name for symbol in form.free_symbols | derived.free_symbols)
        apart = sympy.lambdify(names, form - derived, "mpmath")
        with mpmath.workdps(DIGITS):
            every = ([mpmath.mpf(point[name]) for name in names] for point in points)
            return float(max(abs(apart(*values)) for values in every))


@dataclass(frozen=True)
class Formulas:
    """Numbers of a row by formulas in Python, each of which may use those before it.

    Attributes
    ----------
    texts : mapping of str to str
        Name of a number -> formula.
    module : module
        The measures of the paper, whose names formulas may use, as well as ``session`` and ``who``,
        the engine or the reference. Its class ``Names``, if any, finds more of them.
    """

    texts: Mapping[str, str]
    module: Any

    def __call__(self, session: Any, who: str = REFERENCE) -> dict[str, Any]:
        """Return the numbers by name."""
        numbers: dict[str, Any] = {}
        arguments = {"session": session, "who": who}
        scope = vars(self.module) | arguments
        names = getattr(self.module, "Names", lambda **names: names)(**arguments)
        known: Any = ChainMap(scope, vars(builtins), names)
        for name, text in self.texts.items():
            scope[name] = numbers[name] = eval(text, scope, known)
        return numbers


def vocabulary() -> dict[str, Any]:
    """Return the functions that expressions may have, by name."""
    import sympy

    return {
        "J": sympy.besselj,
        "d": sympy.diff,
        "at": lambda f, x, value: f.subs(x, value),
        "linear": lambda f, x: f.subs(x, 0) + x * sympy.diff(f, x).subs(x, 0),
        "sum": lambda f, n, first, last: sympy.Sum(f, (n, first, last)),
        "mean": lambda f, x: sympy.Integral(f, (x, 0, 2 * sympy.pi)) / (2 * sympy.pi),
        **{name: getattr(sympy, name) for name in FUNCTIONS},
    }
