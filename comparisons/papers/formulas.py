"""Formulas that are written as text, typeset: as LaTeX for Markdown, as MathML for HTML.

``theta' = alpha - 2 u_1 sin(psi)`` is one; products are blanks, primes and tildes belong to a name.
"""

from __future__ import annotations

import re
from functools import cache
from html import unescape
from typing import Any, NamedTuple

FUNCTIONS = ("sin", "cos", "tan", "exp", "log", "sqrt", "sinh", "cosh", "acot", "atan")
GREEK = re.findall(
    r"\w+",
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau phi "
    "chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Phi Psi Omega",
)
SHORT = {"eps": "epsilon"}

NAME = re.compile(r"([A-Za-z]+)((?:_[A-Za-z0-9]+)*)(~?)('*)(\(?)")
WHOLE = re.compile(r"[A-Z]?[A-Za-z]|[A-Z]{2}")
"""A name of a quantity: one letter, or two where the first is a capital, as in EI."""


class Formula(NamedTuple):
    """A formula, typeset."""

    latex: str
    mathml: str


@cache
def typeset(text: str) -> Formula | None:
    """Return a formula, or equations between semicolons, typeset; None of text in words."""
    parts = re.split(r" (=) |(;) ", text)
    typed = [
        Formula(part, f"<mo>{part}</mo>") if part in ("=", ";") else typeset_side(part)
        for part in parts
        if part
    ]
    formulas = [one for one in typed if one is not None]
    if len(formulas) < len(typed) or not re.search("[A-Za-z]", text):
        return None
    latex = " ".join(one.latex for one in formulas)
    return Formula(latex, f"<math><mrow>{''.join(one.mathml for one in formulas)}</mrow></math>")


def typeset_side(text: str) -> Formula | None:
    """Return one side of an equation, its terms in their order; None if it is no expression."""
    import sympy
    from sympy.parsing.sympy_parser import (
        convert_xor,
        implicit_multiplication_application,
        parse_expr,
        standard_transformations,
    )

    known: dict[str, Any] = {name: getattr(sympy, name) for name in FUNCTIONS}
    written: dict[str, Formula] = {}

    def stand_in(match: re.Match[str]) -> str:
        """Return the name of a quantity as SymPy prints it unchanged; others stay."""
        base, index, tilde, primes, bracket = match.groups()
        if base in FUNCTIONS:
            return match[0]
        name = "qq" + "".join(chr(ord("a") + int(digit)) for digit in str(len(written)))
        written[name] = symbol(SHORT.get(base, base), index, tilde, primes)
        known[name] = sympy.Function(name) if bracket else sympy.Symbol(name)
        return name + bracket

    names = {match[1] for match in NAME.finditer(text)} - {*FUNCTIONS, *GREEK, *SHORT}
    if not all(map(WHOLE.fullmatch, names)):
        return None
    rules = (*standard_transformations, convert_xor, implicit_multiplication_application)
    try:
        read = parse_expr(
            NAME.sub(stand_in, text), local_dict=known, transformations=rules, evaluate=False
        )
        latex = sympy.latex(read, order="none").replace(r"\left(-1\right) ", "- ")
        plain = Formula(latex, sympy.mathml(read, "presentation", order="none"))
    except (SyntaxError, TypeError, ValueError, AttributeError):
        return None
    if isinstance(read, tuple):  # several, between commas
        return None
    for name, own in written.items():
        plain = Formula(
            re.sub(rf"\\operatorname{{{name}}}|\b{name}\b", lambda _: own.latex, plain.latex),  # noqa: B023
            plain.mathml.replace(f"<mi>{name}</mi>", own.mathml),
        )
    return plain


def symbol(base: str, index: str, tilde: str, primes: str) -> Formula:
    """Return the name of a quantity, typeset."""
    first, *below = (
        (f"\\{part}", unescape(f"&{part};")) if part in GREEK else (part, part)
        for part in (base, *index.split("_")[1:])
    )
    latex, mathml = first[0], f"<mi>{first[1]}</mi>"
    if tilde:
        latex, mathml = f"\\tilde{{{latex}}}", f"<mover>{mathml}<mo>~</mo></mover>"
    if below:
        latex += f"_{{{','.join(one for one, _ in below)}}}"
        mathml = f"<msub>{mathml}<mi>{','.join(one for _, one in below)}</mi></msub>"
    if primes:
        latex, mathml = f"{latex}{primes}", f"<msup>{mathml}<mo>{'′' * len(primes)}</mo></msup>"
    return Formula(latex, mathml)
