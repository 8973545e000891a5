"""Changes of one operator, constant, index, sign or return value of a module."""

from __future__ import annotations

import ast
import copy
import random
from collections.abc import Callable, Iterator
from typing import NamedTuple

COMPARED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
}  # fmt: skip
TURNED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.Gt, ast.LtE: ast.GtE, ast.Gt: ast.Lt, ast.GtE: ast.LtE,
}  # fmt: skip
ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult,
    ast.FloorDiv: ast.Mult, ast.Mod: ast.Mult,
}  # fmt: skip
NAMES = {
    "min": "max", "argmin": "argmax", "minimum": "maximum", "any": "all", "floor": "ceil",
    "sin": "cos",
}  # fmt: skip
EXCHANGED = NAMES | {new: old for old, new in NAMES.items()}
NUMBERS = ("float", "int", "Array")
"""Annotations of what a function returns whose sign may be turned."""

Change = Callable[[ast.Module, int], str]


class Mutant(NamedTuple):
    """A module with one thing changed.

    Attributes
    ----------
    line : int
    what : str
        Before and after.
    source : str
        Of the whole module.
    """

    line: int
    what: str
    source: str


def mutants(source: str, count: int, seed: int) -> list[Mutant]:
    """Return mutants of so many lines drawn at random, or of all that can be changed."""
    tree = ast.parse(source)
    lines: dict[int, list[tuple[int, ast.AST]]] = {}
    for place, node, line in places(tree):
        for new in variants(node):
            lines.setdefault(line, []).append((place, new))
    draw = random.Random(seed)
    found = []
    for line in sorted(draw.sample(sorted(lines), min(count, len(lines)))):
        place, new = draw.choice(lines[line])
        mutant = copy.deepcopy(tree)
        old = list(ast.walk(mutant))[place]
        what = f"{ast.unparse(old)} -> {ast.unparse(new)}"
        text = ast.unparse(Exchange(old, new).visit(mutant))
        found.append(Mutant(line, what, text))
    return found


class Exchange(ast.NodeTransformer):
    """Put a node in the place of another one."""

    def __init__(self, old: ast.AST, new: ast.AST) -> None:
        self.old, self.new = old, new

    def visit(self, node: ast.AST) -> ast.AST:
        """Return what stands in a node's place."""
        return self.new if node is self.old else super().visit(node)


def places(tree: ast.Module) -> Iterator[tuple[int, ast.AST, int]]:
    """Yield number (in the order of `ast.walk`), node and line of what runs and can be changed."""
    idle = set()
    for node in ast.walk(tree):
        quiet: list[ast.AST | None] = []
        if isinstance(node, ast.FunctionDef):
            arguments = (*node.args.args, *node.args.kwonlyargs)
            quiet = [node.returns, *node.decorator_list, *(one.annotation for one in arguments)]
        elif isinstance(node, ast.AnnAssign):
            quiet = [node.annotation]
        elif isinstance(node, ast.Raise | ast.JoinedStr):
            quiet = [node]
        elif isinstance(node, ast.ClassDef):
            quiet = [*node.bases, *node.decorator_list, *node.keywords]
        elif isinstance(node, ast.keyword) and node.arg == "strict":
            quiet = [node.value]  # a guard that never fires changes nothing
        idle |= {id(inner) for part in quiet if part is not None for inner in ast.walk(part)}
    returned = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and not numeric(node)
        for inner in ast.walk(node)
        if isinstance(inner, ast.Return)
    }
    for place, node in enumerate(ast.walk(tree)):
        line = getattr(node, "lineno", None)
        if line is not None and id(node) not in idle | returned:
            yield place, node, line


def numeric(function: ast.FunctionDef) -> bool:
    """Return whether a function returns a number or an array."""
    return function.returns is not None and ast.unparse(function.returns) in NUMBERS


def variants(node: ast.AST) -> Iterator[ast.AST]:
    """Yield a node with one thing changed."""
    match node:
        case ast.Compare(ops=[operator], left=left, comparators=right):
            for table in (COMPARED, TURNED):
                if type(operator) in table:
                    yield ast.Compare(left, [table[type(operator)]()], right)
        case ast.BinOp(left=first, op=sign, right=second) if type(sign) in ARITHMETIC:
            yield ast.BinOp(first, ARITHMETIC[type(sign)](), second)
        case ast.UnaryOp(op=ast.USub() | ast.Not(), operand=operand):
            yield operand
        case ast.BoolOp(op=operator, values=values):
            yield ast.BoolOp(ast.Or() if isinstance(operator, ast.And) else ast.And(), values)
        case ast.Constant(value=bool(value)):
            yield ast.Constant(not value)
        case ast.Constant(value=int(value)):
            yield ast.Constant(value + 1)
        case ast.Constant(value=float(value)):
            yield ast.Constant(2 * value if value else 1.0)
        case ast.Attribute(value=value, attr=name) if name in EXCHANGED:
            yield ast.Attribute(value, EXCHANGED[name], ast.Load())
        case ast.Name(id=name) if name in EXCHANGED:
            yield ast.Name(EXCHANGED[name], ast.Load())
        case ast.Return(value=value) if value is not None:
            yield ast.Return(ast.UnaryOp(ast.USub(), value))
