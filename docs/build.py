"""Write what follows from the code: tables in README and on pages, and the JSON Schemas.

``python docs/build.py`` writes each table between the marks of its page, and each schema into
``comparisons/documents/schemas``. A test says which of them are stale.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mbcheck.comparisons.checks.rules.cautions import RULES as CAUTIONS
from mbcheck.comparisons.checks.table import KINDS
from mbcheck.comparisons.cli.explain import glossary, texts_of
from mbcheck.comparisons.documents import DOCUMENTS, schema
from mbcheck.comparisons.reports.text import markdown_table
from mbcheck.comparisons.reports.words import Markdown

import fields
import tables

ROOT = Path(__file__).resolve().parents[1]

BLOCK = re.compile(r"(<!-- (fields|table) of ([\w ]+) -->\n).*?(<!-- end -->)", re.DOTALL)
"""The marks of a table, with the sort of table and its name."""


def different_texts(key: str, entry: Any) -> dict[str, str]:
    """Return the text of each term of an entry; of all of them if they share it."""
    texts = texts_of(key, entry)
    return texts if len({*texts.values()}) > 1 else {key: next(iter(texts.values()))}


def table(name: str) -> str:
    """Return a table as Markdown: one of `tables`, kinds, rules of runs, or a sort of terms."""
    if name in tables.TABLES:
        return tables.TABLES[name]()
    if name == "kinds":
        heads = ["Kind", "Question", "What it catches"]
        of = glossary()["kind of check"]
        rows = [[f"`{key}`", of[key]["question"], of[key]["catches"]] for key in KINDS]
    elif name == "rules of runs":
        heads = ["Rule", "It finds"]
        rows = [[f"`{key}`", rule.meaning] for key, rule in CAUTIONS.items()]
    elif name in ("quantities of kinds", "columns"):
        begin = "quantity" if "kinds" in name else ("column", "title")
        groups = glossary()["names"].items()
        heads = ["Kind" if "kinds" in name else "Verb", "Name", "Meaning"]
        rows = [
            [f"`{group.rpartition(' ')[2]}`", f"`{term}`", text]
            for group, entries in groups
            if group.startswith(begin)
            for key, entry in entries.items()
            for term, text in different_texts(key, entry).items()
        ]
    else:
        heads = ["Term", "Meaning"]
        rows = []
        for key, entry in glossary()[name].items():
            texts = different_texts(key, entry)
            words = [f"`{term}`: {text}" * (len(texts) > 1) or text for term, text in texts.items()]
            rows.append([f"`{key}`", " ".join(words)])
    return markdown_table(heads, [[Markdown(cell) for cell in row] for row in rows])


def with_tables(page: str) -> str:
    """Return a page with its tables as the code gives them."""
    seen: set[str] = set()

    def written(mark: re.Match[str]) -> str:
        content = fields.tables(mark[3], seen) if mark[2] == "fields" else table(mark[3])
        return f"{mark[1]}{content}\n{mark[4]}"

    return BLOCK.sub(written, page)


def generated(root: Path = ROOT) -> Iterator[tuple[Path, str]]:
    """Yield each generated file, and its text.

    Parameters
    ----------
    root : Path
        Root of the repository.
    """
    for page in (root / "README.md", *sorted(root.glob("docs/*.md"))):
        text = page.read_text(encoding="utf-8")
        if BLOCK.search(text):
            yield page, with_tables(text)
    for name in DOCUMENTS:
        path = root / "comparisons" / "documents" / "schemas" / f"{name}.schema.json"
        yield path, json.dumps(schema(name), indent=1) + "\n"


if __name__ == "__main__":
    for path, text in generated():
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
