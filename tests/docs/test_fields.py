"""The tables of the pages that are generated are those that the package gives."""

import importlib
from pathlib import Path

import pytest

from mbcheck.comparisons.documents import DOCUMENTS
from mbcheck.reference import SCENES


def test_the_page_has_the_tables_of_the_types(clone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(clone / "docs")
    fields = importlib.import_module("fields")
    page = (clone / "docs" / "json.md").read_text(encoding="utf-8")
    assert [name for _, name, _ in fields.BLOCK.findall(page)] == list(DOCUMENTS)
    assert fields.with_tables(page) == page, "write it again: python docs/fields.py"


def test_generated_tables_are_fresh(clone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for engine in ("mujoco", "exudyn"):
        pytest.importorskip(engine, exc_type=ImportError)
    monkeypatch.syspath_prepend(clone / "docs")
    tables = importlib.import_module("tables")
    pages = [path.read_text(encoding="utf-8") for path in sorted((clone / "docs").glob("*.md"))]
    marked = [(name, of) for page in pages for _, name, of, _ in tables.BLOCK.findall(page)]
    others = [(name, "") for name in tables.TABLES if name != "scene"]
    assert sorted(marked) == sorted([*(("scene", name) for name in SCENES), *others])
    for page in pages:
        assert tables.with_tables(page) == page, "write it again: python docs/tables.py"
