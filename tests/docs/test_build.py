"""Tables and JSON Schemas that are generated from the code are those that the code gives."""

import importlib
import json
from pathlib import Path
from typing import Any

import pytest

import mbcheck
from mbcheck.comparisons.documents import DOCUMENTS, schema


@pytest.fixture
def build(clone: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return the script as a module."""
    monkeypatch.syspath_prepend(clone / "docs")
    return importlib.import_module("build")


def test_generated_files_are_not_stale(build: Any, clone: Path) -> None:
    files = dict(build.generated(clone))
    assert {clone / "README.md", clone / "docs" / "json.md", clone / "docs" / "glossary.md"} <= {
        *files
    }
    for path, text in files.items():
        assert path.read_text(encoding="utf-8") == text, f"{path}: run python docs/build.py"


def test_every_document_has_its_tables(build: Any, clone: Path) -> None:
    page = (clone / "docs" / "json.md").read_text(encoding="utf-8")
    assert [name for _, _, name, _ in build.BLOCK.findall(page)] == list(DOCUMENTS)


def test_schemas_are_in_the_package_under_fixed_names() -> None:
    folder = Path(str(mbcheck.__file__)).parent / "comparisons" / "documents" / "schemas"
    assert {path.name for path in folder.iterdir()} == {f"{name}.schema.json" for name in DOCUMENTS}
    assert json.loads((folder / "check.schema.json").read_text("utf-8")) == schema("check")


def test_every_table_is_on_a_page(build: Any, clone: Path) -> None:
    pages = "\n".join(page.read_text(encoding="utf-8") for page in clone.glob("docs/*.md"))
    for name in build.tables.TABLES:
        assert f"<!-- table of {name} -->" in pages, name
