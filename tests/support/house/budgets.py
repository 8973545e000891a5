"""Budgets: how large each folder of the repository may be, and how often worn-out words stand.

They only go down. ``python -m mbcheck.tests.support.house.budgets`` prints them as counted.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from pprint import pprint

from mbcheck.tests.support.house.module import Module, modules

SLACK = 0.02
"""Largest share by which a budget may exceed what is counted: beyond it, lower the budget."""

BESIDE = ("tests", "docs", "benchmarks")
"""Folders beside the package, each with one budget."""

GENERATED = "generated"
"""The only folder for Python that a program writes; what is there has a budget of its own."""

PHRASES: Mapping[str, str] = {
    "Return what": r"\bReturns? (what|how|whether|why)\b",
    "Of the": r"^(Of|By|At|In|From|Beside|Where|Those|What) ",
    "that is": r"\bthat is\b",
    "what is": r"\bwhat is\b",
    "asked": r"\basked\b",
    "told": r"\btold\b",
    "held": r"\bheld\b",
    "looked at": r"\blooked at\b",
    "makes of": r"\bmakes? of\b",
}
"""Phrase -> pattern, sought in every string of the package; "Of the" in docstrings alone."""

FOLDERS: Mapping[str, tuple[int, int]] = {
    ".": (31, 117),
    "benchmarks": (323, 498),
    "comparisons": (1, 1),
    "comparisons/boundary": (552, 1107),
    "comparisons/check": (403, 758),
    "comparisons/checks": (4965, 8638),
    "comparisons/cli": (480, 1029),
    "comparisons/diff": (312, 541),
    "comparisons/documents": (238, 481),
    "comparisons/engines": (3178, 5732),
    "comparisons/extremes": (104, 190),
    "comparisons/inspect": (3948, 7480),
    "comparisons/judge": (714, 1384),
    "comparisons/maps": (875, 1596),
    "comparisons/papers": (5023, 13254),
    "comparisons/queries": (575, 1230),
    "comparisons/reports": (1538, 2711),
    "comparisons/scenes": (2200, 4648),
    "comparisons/terminal": (343, 591),
    "comparisons/tradeoff": (1979, 3529),  # fields of documents are described as all others are
    "docs": (450, 995),
    "examples": (490, 769),
    "models": (2115, 4014),
    "reference": (8951, 17004),
    "tests": (27420, 46451),
}
"""Folder -> statements and lines of Python."""

WORDS: Mapping[str, int] = {
    "Return what": 374,
    "Of the": 453,
    "that is": 256,
    "what is": 206,
    "asked": 109,
    "told": 58,
    "held": 43,
    "looked at": 34,
    "makes of": 36,
}
"""How often each of `PHRASES` stands in the package."""

MINUTES: Mapping[str, float] = {
    "lint": 3.7,
    "check": 4.2,
    "default: .": 0.0,
    "default: comparisons/boundary": 0.33,
    "default: comparisons/check": 1.11,
    "default: comparisons/checks": 7.16,
    "default: comparisons/cli": 0.99,
    "default: comparisons/diff": 0.05,
    "default: comparisons/documents": 0.08,
    "default: comparisons/engines": 1.49,
    "default: comparisons/extremes": 0.12,
    "default: comparisons/inspect": 2.13,
    "default: comparisons/judge": 0.28,
    "default: comparisons/maps": 1.15,
    "default: comparisons/papers": 0.82,
    "default: comparisons/queries": 0.19,
    "default: comparisons/reports": 0.51,
    "default: comparisons/scenes": 0.0,
    "default: comparisons/tradeoff": 1.27,
    "default: docs": 0.69,
    "default: examples": 0.16,
    "default: house": 0.29,
    "default: models": 0.34,
    "default: models/speed_regulator": 0.1,
    "default: reference": 0.64,
    "default: reference/ball_hoop": 0.09,
    "default: reference/bounds": 0.21,
    "default: reference/continuation": 0.2,
    "default: reference/floating_beam": 0.06,
    "default: reference/floating_platform": 0.14,
    "default: reference/hula_hoop": 0.21,
    "default: reference/rigid_body": 0.06,
    "default: reference/rotating_beam": 0.78,
    "default: reference/rotor_pendulum": 0.09,
    "default: reference/solve": 4.4,
    "default: reference/speed_regulator": 0.63,
    "slow: comparisons/boundary": 1.34,
    "slow: comparisons/check": 1.04,
    "slow: comparisons/checks": 15.0,
    "slow: comparisons/cli": 0.44,
    "slow: comparisons/engines": 1.12,
    "slow: comparisons/extremes": 2.21,
    "slow: comparisons/inspect": 0.14,
    "slow: comparisons/judge": 0.18,
    "slow: comparisons/maps": 4.47,
    "slow: comparisons/papers": 9.83,
    "slow: comparisons/queries": 0.07,
    "slow: comparisons/reports": 0.04,
    "slow: comparisons/tradeoff": 1.15,
    "slow: docs": 3.12,
    "slow: examples": 1.39,
    "slow: house": 0.75,
    "slow: models/speed_regulator": 0.03,
    "slow: reference": 0.74,
    "slow: reference/bounds": 0.16,
    "slow: reference/continuation": 0.72,
    "slow: reference/floating_beam": 0.41,
    "slow: reference/hula_hoop": 0.02,
    "slow: reference/rotating_beam": 0.44,
    "slow: reference/rotor_pendulum": 0.32,
    "slow: reference/solve": 2.11,
    "slow: reference/speed_regulator": 0.19,
}
"""CPU time of continuous integration [min], as measured when it was last recorded."""


def folder_of(module: Module) -> str:
    """Return the folder under whose budget a module falls."""
    top = module.folders[:1]
    if GENERATED in module.folders:
        return GENERATED
    return "/".join(module.folders[:2] if top == ("comparisons",) else top) or "."


def count_sizes(house: Iterable[Module]) -> dict[str, tuple[int, int]]:
    """Return the numbers of statements and of lines of each folder."""
    statements, lines = Counter[str](), Counter[str]()
    for module in house:
        folder = folder_of(module)
        statements[folder] += sum(isinstance(node, ast.stmt) for node in module.nodes)
        lines[folder] += len(module.source.splitlines())
    return {folder: (statements[folder], lines[folder]) for folder in sorted(lines)}


def count_phrases(house: Iterable[Module]) -> dict[str, int]:
    """Return how often each of `PHRASES` stands in the strings of the package."""
    counts = dict.fromkeys(PHRASES, 0)
    for module in house:
        if folder_of(module) in BESIDE:
            continue
        prose = {id(node.value) for node in module.nodes if isinstance(node, ast.Expr)}
        for node in module.nodes:
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                for name, pattern in PHRASES.items():
                    if id(node) in prose or not pattern.startswith("^"):
                        counts[name] += len(re.findall(pattern, node.value))
    return counts


if __name__ == "__main__":
    HOUSE = modules(Path.cwd())
    pprint({"FOLDERS": count_sizes(HOUSE), "WORDS": count_phrases(HOUSE)}, sort_dicts=False)
