"""Modules as the rules of the house see them: paths, syntax trees, and the names in them."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path


@dataclass(frozen=True)
class Module:
    """A module's text.

    Attributes
    ----------
    path : str
        Relative to the clone, with slashes.
    source : str
    """

    path: str
    source: str

    @cached_property
    def tree(self) -> ast.Module:
        """The syntax tree."""
        return ast.parse(self.source)

    @cached_property
    def nodes(self) -> list[ast.AST]:
        """All nodes of the tree."""
        return list(ast.walk(self.tree))

    @cached_property
    def name(self) -> str:
        """The dotted name; that of a package ends in ``.__init__``."""
        return ".".join(("mbcheck", *self.path.removesuffix(".py").split("/")))

    @cached_property
    def imports(self) -> list[str]:
        """The absolute dotted names of all that the module imports."""
        return list(imported_names(self))

    @property
    def folders(self) -> tuple[str, ...]:
        """The folders above the module, outermost first."""
        return tuple(self.path.split("/")[:-1])

    @cached_property
    def functions(self) -> list[tuple[str, ast.FunctionDef | ast.AsyncFunctionDef, bool]]:
        """Functions with their qualified names, and whether they are methods."""
        return [
            (name, node, inside)
            for name, node, inside in definitions(self.tree)
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        ]

    @cached_property
    def classes(self) -> list[tuple[str, ast.ClassDef]]:
        """Classes with their qualified names."""
        return [
            (name, node)
            for name, node, _ in definitions(self.tree)
            if isinstance(node, ast.ClassDef)
        ]

    @cached_property
    def texts(self) -> list[str]:
        """String literals, but docstrings and commands that are shown as examples."""
        prose = {
            id(node.value)
            for node in self.nodes
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        }
        return [
            node.value
            for node in self.nodes
            if isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and id(node) not in prose
            and not node.value.startswith("mbcheck ")
        ]


def modules(root: Path) -> list[Module]:
    """Return the modules of a clone: of the package, its tests, documents and examples."""
    tops = ("reference", "models", "comparisons", "tests", "docs", "examples", "benchmarks")
    paths = [root / "__init__.py"]
    paths += [path for top in tops for path in sorted((root / top).rglob("*.py"))]
    return [Module(p.relative_to(root).as_posix(), p.read_text(encoding="utf-8")) for p in paths]


def is_shipped(module: Module) -> bool:
    """Return whether a module is one of the package itself: no test, no document, no example."""
    return module.path.startswith(("reference/", "models/", "comparisons/", "__init__"))


# What a tree holds ----------------------------------------------------------------------------


DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)


def definitions(
    node: ast.AST, prefix: str = "", method: bool = False
) -> Iterator[tuple[str, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef, bool]]:
    """Yield functions and classes with their qualified names, and whether a class holds them."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            name = f"{prefix}{child.name}"
            yield name, child, method
            yield from definitions(child, f"{name}.", isinstance(child, ast.ClassDef))
        else:
            yield from definitions(child, prefix, method)


def imported_names(module: Module) -> Iterator[str]:
    """Yield the absolute dotted name of all that a module imports."""
    for node in module.nodes:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            parents = module.name.split(".")[: -node.level] if node.level else []
            base = [*parents, node.module] if node.module else parents
            yield from (".".join([*base, alias.name]) for alias in node.names)


def decorators(node: ast.FunctionDef | ast.AsyncFunctionDef) -> set[str]:
    """Return the last words of a function's decorators."""
    calls = (item.func if isinstance(item, ast.Call) else item for item in node.decorator_list)
    return {ast.unparse(item).rpartition(".")[2] for item in calls}


def bound_names(module: Module) -> Iterator[str]:
    """Yield all names that a module gives: to functions, classes, arguments, fields, variables."""
    for node in module.nodes:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.attr


def words_of(name: str) -> str:
    """Return a name's words in lower case, each between underscores."""
    return "_" + re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower().strip("_") + "_"
