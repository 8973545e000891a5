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
    ".": (34, 122),
    "benchmarks": (322, 497),
    "comparisons": (1, 1),
    "comparisons/boundary": (484, 993),  # a hint where no curve is found; says what it follows
    "comparisons/check": (383, 729),
    "comparisons/checks": (4932, 8799),  # mistakes of checks and judge; sub-steps as causes (#39)
    "comparisons/cli": (474, 968),  # `explain` and its glossary (#39)
    "comparisons/compare": (1762, 3024),  # 1,300 granted; engines as readers (#38)
    "comparisons/diff": (278, 497),
    "comparisons/documents": (335, 678),  # waivers for compare too; lists and paths in Python (#39)
    "comparisons/engines": (2728, 5062),  # errors name the line of the engine
    "comparisons/extremes": (101, 187),
    "comparisons/faults": (616, 1127),  # those of tests came in: audits need them
    "comparisons/inspect": (3596, 7012),  # fixes are tried displaced; rigid modes apart (#39)
    "comparisons/judge": (649, 1242),
    "comparisons/maps": (801, 1486),  # curves that part no classes
    "comparisons/papers": (3286, 6270),
    "comparisons/queries": (600, 1279),  # refuses models unsuitable for parameters
    "comparisons/reports": (1552, 2761),  # 80 columns, a badge (#39); deviations before errors
    "comparisons/scenes": (1887, 4192),
    "comparisons/terminal": (308, 508),
    "comparisons/tradeoff": (1700, 3233),  # the step of each method (#39)
    "docs": (611, 1337),  # generated tables of pages, a picture (#39)
    "examples": (500, 783),
    "models": (1989, 3720),
    "reference": (8206, 16317),  # arrays in a third of the time: constants of their type
    "tests": (25063, 43336),  # engines as readers, import bugs, pages, 80 columns (#38, #39)
}
"""Folder -> statements and lines of Python."""

CLAIMS: Mapping[str, int] = {
    "hula_hoop": 1295,
    "rotating_beam": 1143,
    "rotor_pendulum": 1370,
    "speed_regulator": 692,
}
"""Lines of ``claims.toml`` of each paper that are not empty."""

WORDS: Mapping[str, int] = {
    "Return what": 0,
    "Of the": 0,
    "that is": 0,
    "what is": 1,
    "asked": 1,
    "told": 0,
    "held": 1,
    "looked at": 0,
    "makes of": 0,
}
"""How often each of `PHRASES` stands in the package."""

DOC_WORDS = 24976
"""Words of all pages that are written by hand."""

GENERATED_PAGES = ("json.md", "ledger.md")
"""Pages of `docs` that programs write."""

MINUTES: Mapping[str, float] = {
    "lint": 3.7,
    "check": 4.2,
    "default: .": 0.02,
    "default: comparisons/boundary": 0.17,
    "default: comparisons/check": 0.62,
    "default: comparisons/checks": 4.31,
    "default: comparisons/cli": 0.69,
    "default: comparisons/compare": 0.5,
    "default: comparisons/diff": 0.04,
    "default: comparisons/documents": 0.07,
    "default: comparisons/engines": 1.05,
    "default: comparisons/extremes": 0.08,
    "default: comparisons/inspect": 1.4,
    "default: comparisons/judge": 0.15,
    "default: comparisons/maps": 0.69,
    "default: comparisons/papers": 0.67,
    "default: comparisons/queries": 0.09,
    "default: comparisons/reports": 0.3,
    "default: comparisons/scenes": 0.0,
    "default: comparisons/tradeoff": 0.73,
    "default: docs": 0.46,
    "default: examples": 0.09,
    "default: house": 0.24,
    "default: models": 0.23,
    "default: models/speed_regulator": 0.05,
    "default: reference": 0.57,
    "default: reference/bounds": 0.11,
    "default: reference/continuation": 0.12,
    "default: reference/hula_hoop": 0.11,
    "default: reference/rotating_beam": 0.43,
    "default: reference/rotor_pendulum": 0.01,
    "default: reference/solve": 1.5,
    "default: reference/speed_regulator": 0.32,
    "slow: comparisons/boundary": 0.93,
    "slow: comparisons/check": 0.99,
    "slow: comparisons/checks": 13.35,
    "slow: comparisons/cli": 0.32,
    "slow: comparisons/compare": 1.9,
    "slow: comparisons/engines": 1.99,
    "slow: comparisons/extremes": 2.73,
    "slow: comparisons/inspect": 0.12,
    "slow: comparisons/judge": 0.13,
    "slow: comparisons/maps": 4.15,
    "slow: comparisons/papers": 9.18,
    "slow: comparisons/queries": 0.1,
    "slow: comparisons/reports": 0.03,
    "slow: comparisons/tradeoff": 1.05,
    "slow: docs": 2.7,
    "slow: examples": 1.11,
    "slow: house": 0.6,
    "slow: models/speed_regulator": 0.03,
    "slow: reference": 0.95,
    "slow: reference/bounds": 0.16,
    "slow: reference/continuation": 2.5,
    "slow: reference/hula_hoop": 0.03,
    "slow: reference/rotating_beam": 0.32,
    "slow: reference/rotor_pendulum": 0.22,
    "slow: reference/solve": 1.58,
    "slow: reference/speed_regulator": 0.51,
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


def count_claims(clone: Path) -> dict[str, int]:
    """Return the number of lines of each paper's data."""
    files = sorted((clone / "comparisons" / "papers").glob("*/claims.toml"))
    return {
        file.parent.name: sum(map(bool, file.read_text("utf-8").splitlines())) for file in files
    }


def count_doc_words(clone: Path) -> int:
    """Return the number of words of pages written by hand, without generated tables."""
    pages = {*clone.glob("*.md"), *clone.glob("docs/*.md")}
    texts = (page.read_text("utf-8") for page in pages if page.name not in GENERATED_PAGES)
    generated = re.compile(r"<!-- (fields|table|output) of .*?<!-- end -->", re.DOTALL)
    return sum(len(generated.sub("", text).split()) for text in texts)


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
    SIZES = {"FOLDERS": count_sizes(HOUSE), "CLAIMS": count_claims(Path.cwd())}
    TEXT = {"DOC_WORDS": count_doc_words(Path.cwd()), "WORDS": count_phrases(HOUSE)}
    pprint(SIZES | TEXT, sort_dicts=False)
