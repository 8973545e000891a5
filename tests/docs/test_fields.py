"""The tables of docs/json.md are those that the types of the documents give."""

import importlib
from pathlib import Path

import pytest

from mbcheck.comparisons.documents import DOCUMENTS


def test_the_page_has_the_tables_of_the_types(clone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(clone / "docs")
    fields = importlib.import_module("fields")
    page = (clone / "docs" / "json.md").read_text(encoding="utf-8")
    assert [name for _, name, _ in fields.BLOCK.findall(page)] == list(DOCUMENTS)
    assert fields.with_tables(page) == page, "write it again: python docs/fields.py"
