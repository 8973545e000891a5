"""``mbcheck explain``: the terms of reports and documents."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Mapping
from fnmatch import fnmatchcase
from importlib.resources import files
from typing import Any

import click
from rich.console import Console

from ...reference import SCENES, get_scene
from ...reference.errors import UsageError
from ..checks.rules.cautions import RULES as CAUTIONS
from ..inspect.console import print_rule
from ..inspect.rules.table import RULES as FINDINGS
from ..reports.text import print_line
from ..terminal.program import console, examples

CLOSE = 0.75
"""Least similarity, by `difflib`, of a suggested term to an unknown one."""


def glossary() -> Mapping[str, Mapping[str, Any]]:
    """Return the entry of each term, by the sort of term.

    Returns
    -------
    Mapping
        A text; for a kind of check, its ``question`` and the faults that it ``catches``; below
        ``names``, the texts of the quantities of a kind, or of the words of a verb's tables. A key
        may name several terms, separated by commas, which share a text or have a list of them;
        terms may be patterns.
    """
    text = files(__package__).joinpath("glossary.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def texts_of(key: str, entry: Any) -> dict[str, str]:
    """Return the text of each term of an entry."""
    if isinstance(entry, Mapping):
        entry = f"{entry['question']} It finds: {entry['catches']}."
    terms = key.split(", ")
    return dict(zip(terms, [entry] * len(terms) if isinstance(entry, str) else entry, strict=True))


def by_sort() -> dict[str, dict[str, str]]:
    """Return the text of each term, by the sort of term, quantity and column."""
    terms = dict(glossary())
    names = terms.pop("names")
    return {
        sort: {term: text for row in rows.items() for term, text in texts_of(*row).items()}
        for sort, rows in {**terms, **names}.items()
    }


def explanations(name: str) -> list[str]:
    """Return the entries that explain a term, a quantity of a check, a column or an observable."""
    units = {scene: get_scene(scene).units for scene in SCENES}
    where = [f"{scene} [{unit[name]}]" for scene, unit in units.items() if name in unit]
    return [f"{name} (observable): of {', '.join(where)}"] * bool(where) + [
        f"{name} ({sort}): {text}"
        for sort, texts in by_sort().items()
        for pattern, text in texts.items()
        if fnmatchcase(name, pattern)
    ]


def print_terms(screen: Console) -> None:
    """Print the terms that are explained."""
    listed = {sort: [*entries] for sort, entries in by_sort().items()}
    for sort, entries in {**listed, "rule": list(dict.fromkeys([*CAUTIONS, *FINDINGS]))}.items():
        print_line(screen, f"{sort}: {', '.join(entries)}", hanging="  ")


def explain_term(screen: Console, name: str) -> None:
    """Print the entries of a term, an observable or a rule.

    Raises
    ------
    UsageError
        If there is no such term; the message names a close one, if there is one.
    """
    spellings = (name, name.lower(), name.replace(" ", "_"), name.removesuffix("s"))
    matches = next(filter(None, map(explanations, spellings)), [])
    if name in CAUTIONS and name not in FINDINGS:
        matches.append(f"{name} (rule for a run of a scene): {CAUTIONS[name].meaning}")
    for entry in matches:
        print_line(screen, entry, hanging="  ")
    if name in FINDINGS:
        print_rule(screen, name)
    elif not matches:
        known = [term for terms in by_sort().values() for term in terms]
        close = difflib.get_close_matches(name, [*known, *CAUTIONS, *FINDINGS], 1, CLOSE)
        hint = f"did you mean {close[0]!r}?" if close else "mbcheck explain lists all terms"
        raise UsageError(f"unknown term {name!r}; {hint}")


@click.command(
    epilog=examples(
        "mbcheck explain                all terms",
        "mbcheck explain least_error    a quantity",
        "mbcheck explain margin         a column",
        "mbcheck explain step_limit     a rule",
    ),
)
@click.argument("terms", metavar="[TERM]...", nargs=-1)
def explain(terms: tuple[str, ...]) -> None:
    """Explain terms of the reports: kinds of check, verdicts, quantities, columns and rules.

    Without a TERM all of them are listed.
    """
    screen = console()
    if not terms:
        print_terms(screen)
    unknown = []
    for term in terms:
        try:
            explain_term(screen, term)
        except UsageError as error:
            unknown.append(str(error))
    if unknown:
        raise UsageError("\n".join(unknown))
