"""The rules: each yields what breaks it."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence

from mbcheck.reference import SCENES
from mbcheck.tests.support.house.module import (
    DEFINITIONS,
    Module,
    bound_names,
    decorators,
    is_shipped,
    words_of,
)

ENGINES: Mapping[str, tuple[str, ...]] = {"mujoco": ("mujoco", "mjcf"), "exudyn": ("exudyn",)}
"""Engine -> the words one of which a module's path has if it may know that engine."""

DOWN = (
    "cli",
    "",
    "terminal",
    "reports",
    "scenes",
    "queries",
    "checks",
    "faults",
    "engines",
    "documents",
)
"""Folders of `comparisons` from the highest layer down; features, all others, stand for ""."""

BESIDE = {
    ("papers", "maps"), ("check", "papers"), ("extremes", "check"), ("tradeoff", "inspect"),
}  # fmt: skip
"""Features that import another feature: (importer, what it imports)."""

# fmt: off
WORDS = frozenset({
    "affordable", "bearable", "bears", "claim", "claims", "driven_until", "exactly", "knob",
    "knobs", "makes_of", "noticer", "noticers", "sharp_truth", "stands_for",
})
# fmt: on
"""Words that no name has: the field has its own."""

# fmt: off
PARTICIPLES = frozenset({
    "chosen", "climbed", "evened", "found", "given", "grown", "held", "judged", "kept", "nudged",
    "priced", "shown", "told", "trusted", "turned",
})
# fmt: on
"""Words that no name ends in: a past participle says what was done, and not to what."""

# fmt: off
MUTATORS = frozenset({
    "add", "append", "appendleft", "clear", "discard", "extend", "insert", "pop", "popitem",
    "popleft", "remove", "setdefault", "update",
})
# fmt: on
"""Methods that change a container."""


# Who knows whom -------------------------------------------------------------------------------


def scenes_by_name(house: Sequence[Module]) -> Iterator[str]:
    """Yield modules of generic code that name a scene in a literal or import one's module.

    Commands that are shown as examples do so: they begin with "mbcheck ".
    """
    pattern = re.compile(rf"(?<![\w.])({'|'.join(SCENES)})(?!\w)")
    free = ("comparisons/scenes/", "comparisons/papers/", "comparisons/faults/")
    for module in house:
        if module.path.startswith("comparisons/") and not module.path.startswith(free):
            texts = (
                *module.texts,
                *(f" {name.replace('.', ' ')}" for name in module.imports),
            )
            if any(pattern.search(text) for text in texts):
                yield module.path


def engines_by_name(house: Sequence[Module]) -> Iterator[str]:
    """Yield modules that name an engine in a literal, but the engine's own and those of faults.

    Commands that are shown as examples do so too.
    """
    for module in house:
        if not module.path.startswith("comparisons/") or "faults" in module.folders:
            continue
        for engine, words in ENGINES.items():
            if any(word in module.path for word in words):
                continue
            if any(re.search(rf"(?<![\w.]){engine}(?!\w)", text) for text in module.texts):
                yield f"{module.path}::{engine}"


def asked_engines(house: Sequence[Module]) -> Iterator[str]:
    """Yield functions that ask an engine what it has, by `getattr` or `hasattr`."""
    for module in filter(is_shipped, house):
        for name, node, _ in module.functions:
            if any(
                isinstance(call, ast.Call)
                and isinstance(call.func, ast.Name)
                and call.func.id in ("getattr", "hasattr")
                and "engine" in ast.unparse(call.args[0]).lower()
                for call in ast.walk(node)
            ):
                yield f"{module.path}::{name}"


LAYERS = {
    "reference": {"reference"},
    "models": {"reference", "models"},
    "comparisons": {"reference", "models", "comparisons"},
}
"""What each layer may import from mbcheck."""


def upward_imports(house: Sequence[Module]) -> Iterator[str]:
    """Yield imports of a layer above, of another feature, or of an engine from elsewhere."""
    for module in house:
        layer = module.folders[0] if module.folders else ""
        if layer not in LAYERS:
            continue
        for name in module.imports:
            top, *rest = name.split(".")
            if top == "mbcheck":
                wrong = rest[0] not in LAYERS[layer] or is_above(module, rest)
            else:
                own = layer != "reference" and any(
                    word in module.path for word in ENGINES.get(top, ())
                )
                wrong = top in ENGINES and not own
            if wrong:
                yield f"{module.path}: {name}"


def is_above(module: Module, path: list[str]) -> bool:
    """Return whether a module of `comparisons` may not import what has this path."""
    if module.folders[0] != "comparisons" or path[0] != "comparisons" or len(path) < 2:
        return False
    own, other = [*module.folders, ""][1], path[1]
    if own == other or (own, other) in BESIDE:
        return False
    here, there = (DOWN.index(name if name in DOWN else "") for name in (own, other))
    return there <= here


def sibling_kinds(house: Sequence[Module]) -> Iterator[str]:
    """Yield kinds of check, and mistakes, that import another kind or what lies above kinds."""
    folder = "mbcheck.comparisons.checks"
    above = tuple(f"{folder}.{name}" for name in ("kinds", "diagnosis", "table", "suite"))
    for module in house:
        if module.name.startswith((f"{folder}.kinds.", f"{folder}.mistakes.")):
            wrong = (name for name in module.imports if name.startswith(above))
            yield from (f"{module.path}: {name}" for name in wrong)


def loose_modules(house: Sequence[Module]) -> Iterator[str]:
    """Yield modules that lie loose in `comparisons`."""
    for module in house:
        if module.folders == ("comparisons",) and not module.path.endswith("__init__.py"):
            yield module.path


# What hides faults ----------------------------------------------------------------------------


def broad_excepts(house: Sequence[Module]) -> Iterator[str]:
    """Yield functions that catch any exception and do not raise it again."""
    for module in filter(is_shipped, house):
        for name, node, _ in module.functions:
            for item in ast.walk(node):
                if isinstance(item, ast.ExceptHandler) and is_broad(item):
                    yield f"{module.path}::{name}"


def is_broad(handler: ast.ExceptHandler) -> bool:
    """Return whether a handler catches any exception and does not raise it again."""
    names = ast.unparse(handler.type) if handler.type else "Exception"
    again = isinstance(handler.body[-1], ast.Raise) and handler.body[-1].exc is None
    return bool(re.search(r"\b(Base)?Exception\b", names)) and not again


def module_caches(house: Sequence[Module]) -> Iterator[str]:
    """Yield containers of a module that its code changes, and names that it sets anew."""
    containers = ast.Dict | ast.List | ast.Set | ast.DictComp | ast.ListComp | ast.SetComp
    for module in filter(is_shipped, house):
        names = set()
        for node in module.tree.body:
            if isinstance(node, ast.Assign | ast.AnnAssign) and (
                isinstance(node.value, containers)
                or re.match(
                    r"(dict|list|set|deque|Counter|defaultdict|OrderedDict|\w*Dictionary)\(",
                    ast.unparse(node.value) if node.value else "",
                )
            ):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                names |= {item.id for item in targets if isinstance(item, ast.Name)}
        changed = set()
        for item in module.nodes:
            if isinstance(item, ast.Global):
                changed |= set(item.names)
            elif isinstance(item, ast.Subscript) and not isinstance(item.ctx, ast.Load):
                changed |= names & {ast.unparse(item.value)}
            elif (
                isinstance(item, ast.Call)
                and isinstance(item.func, ast.Attribute)
                and item.func.attr in MUTATORS
            ):
                changed |= names & {ast.unparse(item.func.value)}
        yield from (f"{module.path}::{name}" for name in sorted(changed))


# Tests ----------------------------------------------------------------------------------------


def patched_constants(house: Sequence[Module]) -> Iterator[str]:
    """Yield constants that tests set by `monkeypatch` where an argument would do."""
    for module in house:
        for call in module.nodes:
            if isinstance(call, ast.Call) and ast.unparse(call.func) == "monkeypatch.setattr":
                literals = [item.value for item in call.args if isinstance(item, ast.Constant)]
                name = str(literals[0]).rpartition(".")[2] if literals else ""
                if name.isupper():
                    yield f"{module.path}::{name}"


def tests_without_a_place(house: Sequence[Module]) -> Iterator[str]:
    """Yield tests whose folder mirrors none of the package's."""
    places = {module.folders for module in house}
    own = ("house", "support", "conformance", "foreign")
    for module in house:
        top, *below = module.folders or ("",)
        if top == "tests" and tuple(below) not in places and below[0] not in own:
            yield module.path


# Names ----------------------------------------------------------------------------------------


def shared_names(house: Sequence[Module]) -> Iterator[str]:
    """Yield names of classes that stand in several modules, and of functions imported from them.

    All scenes speak of the same things by the same names: their folders in one layer count as
    one place. A verb has the name of its function. A function that only its own module calls by
    its bare name is nobody else's word.
    """
    homes: dict[str, set[str]] = defaultdict(set)
    places = {}
    folders = {
        one.folders[1] for one in house if one.folders[:1] == ("models",) and one.folders[1:]
    }
    for module in filter(is_shipped, house):
        before, scene, _ = module.path.partition(
            next((s for s in folders if s in module.path), "?")
        )
        for node in module.tree.body:
            if not isinstance(node, DEFINITIONS) or node.name.startswith("_"):
                continue
            if not isinstance(node, ast.ClassDef) and "command" in decorators(node):
                continue
            place = f"{module.name.removesuffix('.__init__')}.{node.name}"
            places[place] = before if scene else module.path
            if isinstance(node, ast.ClassDef):
                homes[node.name].add(places[place])
    for name in (name for module in filter(is_shipped, house) for name in module.imports):
        if name in places:
            homes[name.rpartition(".")[2]].add(places[name])
    yield from (name for name, where in homes.items() if len(where) > 1)


def private_words(house: Sequence[Module]) -> Iterator[str]:
    """Yield names that have a word that is no name."""
    for module in house:
        if not is_shipped(module):
            continue
        names = set(bound_names(module))
        for name in sorted(names):
            words = words_of(name)
            if any(f"_{word}_" in words for word in WORDS) or any(
                words.endswith(f"_{word}_") for word in PARTICIPLES
            ):
                yield f"{module.path}::{name}"


RULES: Mapping[str, Callable[[Sequence[Module]], Iterator[str]]] = {
    rule.__name__: rule
    for rule in (
        loose_modules,
        scenes_by_name,
        engines_by_name,
        asked_engines,
        upward_imports,
        sibling_kinds,
        broad_excepts,
        module_caches,
        patched_constants,
        tests_without_a_place,
        shared_names,
        private_words,
    )
}
